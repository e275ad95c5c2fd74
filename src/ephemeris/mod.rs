//! Positions, velocities and orientations of bodies: f64, kilometres, TDB, ICRF.
//!
//! In: a catalog and an instant. Out: states. Each target, a body or a barycentre, has a state relative to its origin, which is a target too. These links form
//! chains: Moon from Earth, Earth from the Earth-Moon barycentre, and so on to the solar system's barycentre. The state of a body relative to a centre is the
//! difference of their two chains up to the first common target. Always: the result names the least accurate source that it used and an upper limit of its
//! error. No file is read here: the caller passes bytes.

pub mod apparent;
#[doc(hidden)]
pub mod body_order;
#[doc(hidden)]
pub mod chebyshev;
mod chebyshev_cache;
pub mod conic;
mod coverage;
#[doc(hidden)]
pub mod elp;
#[doc(hidden)]
pub mod frames;
#[doc(hidden)]
pub mod limb_profile;
#[doc(hidden)]
pub mod mean_elements;
#[doc(hidden)]
pub mod orbit_size;
#[doc(hidden)]
pub mod orientation;
#[doc(hidden)]
pub mod satellites;
#[doc(hidden)]
pub mod series;
#[doc(hidden)]
pub mod spk;
pub mod star_place;
pub mod target;
mod time_grid;
pub mod topocentric;
#[doc(hidden)]
pub mod two_body;
mod user_kernel;

use crate::catalog::{Catalog, Motion, NaifId, Rotation};
use crate::message::{Argument, Message, message};
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY};
use glam::{DMat3, DVec3};
use parking_lot::Mutex;
use satellites::{drift, galilean, tass};
use std::collections::{HashMap, VecDeque};

/// Sources of states, from the least accurate to the most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// Mean elements, or an orbit that a catalog gives.
    Mean,
    /// Analytical series: VSOP87, ELP and the moons' theories.
    Series,
    /// An SPK kernel, such as DE440's.
    Kernel,
}

/// The `source` argument of [`Ephemeris::state`] that selects the best source that covers the time.
pub const BEST_SOURCE: Option<Source> = None;

/// Position in km and velocity in km/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Kilometres, ICRF.
    pub pos_km: DVec3,
    /// Kilometres per second, ICRF.
    pub vel_km_s: DVec3,
}

impl State {
    /// At rest at the origin.
    pub const REST: Self = Self { pos_km: DVec3::ZERO, vel_km_s: DVec3::ZERO };

    /// Chains two states: if `other` is the state of this one's origin, the sum is this state relative to the origin of `other`.
    pub fn plus(self, other: Self) -> Self {
        Self { pos_km: self.pos_km + other.pos_km, vel_km_s: self.vel_km_s + other.vel_km_s }
    }

    /// This state relative to `other`; both must have the same origin.
    pub fn minus(self, other: Self) -> Self {
        Self { pos_km: self.pos_km - other.pos_km, vel_km_s: self.vel_km_s - other.vel_km_s }
    }
}

/// A geometric state with the source that gave it and that source's error bound: infinite if any of the evaluated links comes from a user's kernel,
/// because an SPK does not state its accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourcedState {
    /// Position and velocity.
    pub state: State,
    /// The least accurate source of the evaluated links (up to the first common target of both chains); if none has a source, the requested one or `Kernel`.
    pub source: Source,
    /// Bound of the position's error.
    pub error_km: f64,
}

/// Angle between two directions of any length, radians: from cross and dot product, so that small angles keep their precision.
pub fn angle_rad(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Why a state is not available, in one line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct EphemerisError(pub Message);

impl EphemerisError {
    /// An error whose detail is English in every language.
    pub fn other(detail: impl Into<String>) -> Self {
        Self(message!("error-ephemeris", detail = Argument::English(detail.into())))
    }

    /// Adds to the message that its time is the one at which the light left the body: the user gave the time at which the light arrives.
    pub(crate) fn when_light_left(self) -> Self {
        Self(message!("error-light-left", error = self.0))
    }
}

/// The evaluated link of a chain: a target relative to its origin.
#[derive(Clone, Copy, Debug)]
struct LinkState {
    state: State,
    /// `None` for a planet's centre that coincides with its system's barycentre.
    source: Option<Source>,
    error_km: f64,
}

/// What evaluates a link. All links are found first; only those that the result needs are evaluated.
#[derive(Clone, Copy)]
enum Theory<'a> {
    Kernel {
        segment: &'a spk::Segment,
        error_km: f64,
    },
    Series,
    /// Mean elements; for the Moon, the largest terms of its series.
    Mean,
    /// A planet's centre relative to its system's barycentre, from the masses and states of its moons.
    CentreFromMoons,
    /// A catalog's orbit about the body's parent.
    Orbit(&'a Motion),
}

/// A link of a chain before it is evaluated.
#[derive(Clone, Copy)]
struct ChainLink<'a> {
    target: NaifId,
    /// The target relative to which the theory gives states.
    origin: NaifId,
    theory: Theory<'a>,
}

/// The motion of a body about its parent, from the catalog.
#[derive(Debug)]
struct Orbit {
    parent: NaifId,
    motion: Motion,
}

/// Largest number of links of a chain. A shipped moon needs four (moon, planet, its barycentre, Sun, solar system barycentre); a user's catalog may nest
/// more bodies.
const MAX_CHAIN_LINKS: usize = 8;

/// All theories behind one interface. Results never depend on earlier calls; threads may share it.
#[derive(Debug)]
pub struct Ephemeris {
    /// Kernels in order of precedence; the shipped one is the last.
    kernels: Vec<spk::Spk>,
    /// The series of planets, Sun and Moon.
    series: series::Series,
    /// Motions about a parent, from the catalog.
    orbits: HashMap<NaifId, Orbit>,
    /// Rotation models, from the catalog.
    rotations: HashMap<NaifId, Rotation>,
    /// The moons that displace a planet's centre, each with its share of the system's mass.
    mass_shares: HashMap<NaifId, Vec<MassShare>>,
    /// The theories of Jupiter's and Saturn's large moons.
    moon_theories: satellites::MoonTheories,
    /// Names of the catalog's bodies, for messages.
    names: HashMap<NaifId, String>,
    /// Poles and prime meridians from the text kernel.
    pck: orientation::Pck,
    /// The most recent centres of planets: a frame needs one at the same instant for each of the planet's moons.
    recent_centres: Mutex<VecDeque<(NaifId, Instant, LinkState)>>,
    /// The Earth's rotation, with cached precession and nutation.
    earth_rotation: orientation::EarthRotation,
}

/// Number of cached centres.
const MAX_RECENT_CENTRES: usize = 16;

impl Ephemeris {
    /// The shipped kernel, series and theories for the bodies of `catalog`.
    pub fn embedded(catalog: &Catalog) -> Result<Self, EphemerisError> {
        let shipped = spk::Spk::parse("orrery_1900_2100.bsp", orrery_catalogs::KERNEL)?;
        let moon_theories = satellites::MoonTheories::embedded()?;
        let pck = orientation::Pck::parse(orientation::EMBEDDED_PCK).map_err(|e| EphemerisError::other(e.to_string()))?;
        Ok(Self {
            kernels: vec![shipped],
            series: series::Series::embedded()?,
            orbits: catalog.bodies().iter().filter_map(|b| Some((b.id, Orbit { parent: b.parent?, motion: b.motion.clone() }))).collect(),
            rotations: catalog.bodies().iter().map(|b| (b.id, b.rotation.clone())).collect(),
            mass_shares: mass_shares(catalog),
            moon_theories,
            names: catalog.bodies().iter().map(|b| (b.id, b.name.clone())).collect(),
            pck,
            recent_centres: Mutex::default(),
            earth_rotation: orientation::EarthRotation::default(),
        })
    }

    /// Geometric state of `body` relative to `center`, ICRF. `source`: the one to use where there is a choice, or [`BEST_SOURCE`].
    pub fn state(&self, body: NaifId, center: NaifId, t: Instant, source: Option<Source>) -> Result<SourcedState, EphemerisError> {
        if !t.tdb_seconds_past_j2000().is_finite() {
            return Err(EphemerisError::other("the time is not a number"));
        }
        let (body_chain, center_chain) = (self.chain(body, t, source), self.chain(center, t, source));
        // Both chains are followed up to their first common target, because they cancel beyond it: the Sun's barycentric state is not needed if the Sun is the
        // centre.
        let common = body_chain.targets().find_map(|(body_len, target)| {
            center_chain.targets().find_map(|(center_len, center_target)| (target == center_target).then_some((body_len, center_len)))
        });
        let Some((body_len, center_len)) = common else {
            let incomplete = if body_chain.end() == NaifId::SOLAR_SYSTEM_BARYCENTER { &center_chain } else { &body_chain };
            return Err(self.error_without_theory(incomplete.end(), t, source));
        };
        let mut result = SourcedState { state: State::REST, source: source.unwrap_or(Source::Kernel), error_km: 0.0 };
        let mut least_accurate = None;
        for (link, is_subtracted) in
            body_chain.links(body_len).map(|link| (link, false)).chain(center_chain.links(center_len).map(|link| (link, true)))
        {
            let evaluated = self.evaluate(link, t).ok_or_else(|| self.error_without_theory(link.target, t, source))?;
            result.state = if is_subtracted { result.state.minus(evaluated.state) } else { result.state.plus(evaluated.state) };
            least_accurate = [least_accurate, evaluated.source].into_iter().flatten().min();
            result.error_km += evaluated.error_km;
        }
        result.source = least_accurate.unwrap_or(result.source);
        Ok(result)
    }

    /// Rotation from ICRF to the body's axes at `t`: its rows are these axes in ICRF.
    pub fn body_from_icrf(&self, body: NaifId, t: Instant) -> Result<DMat3, EphemerisError> {
        let unknown = |why: &str| EphemerisError::other(format!("the orientation of {} is unknown: {why}", self.name_of(body)));
        if !in_years(t, ORBIT_YEARS) {
            return Err(unknown("the time is outside the years -20000 to 20000"));
        }
        match self.rotations.get(&body).ok_or_else(|| unknown("the catalog has no such body"))? {
            Rotation::EarthIau2006 => Ok(self.earth_rotation.itrs_from_gcrs(t)),
            Rotation::Pck => {
                let pole_and_meridian = self.pck.pole_and_meridian(body, t.tdb_seconds_past_j2000());
                Ok(pole_and_meridian.ok_or_else(|| unknown("the PCK lacks it"))?.body_from_icrf())
            }
            Rotation::Synchronous => {
                let parent = self.orbits.get(&body).map(|o| o.parent).ok_or_else(|| unknown("it has no parent"))?;
                let state = self.state(body, parent, t, BEST_SOURCE)?.state;
                orientation::synchronous(state.pos_km, state.vel_km_s).ok_or_else(|| unknown("its orbit is a line"))
            }
            Rotation::Fixed { pole_ra_deg, pole_dec_deg, w0_deg, w_deg_day } => {
                let days = t.tdb_seconds_past_j2000() / SECONDS_PER_DAY;
                let w_deg = (w0_deg + w_deg_day * days).rem_euclid(360.0);
                Ok(orientation::PoleAndMeridian { pole_ra_deg: *pole_ra_deg, pole_dec_deg: *pole_dec_deg, w_deg }.body_from_icrf())
            }
        }
    }

    /// The links from `target` towards the solar system barycentre, as far as the theories go.
    fn chain(&self, target: NaifId, t: Instant, source: Option<Source>) -> StateChain<'_> {
        let mut chain = StateChain { first: target, links: [None; MAX_CHAIN_LINKS] };
        let mut current = target;
        for next in &mut chain.links {
            if current == NaifId::SOLAR_SYSTEM_BARYCENTER {
                break;
            }
            let Some(link) = self.link(current, t, source) else { break };
            current = link.origin;
            *next = Some(link);
        }
        chain
    }

    /// The best source for `target` at `t`, and its origin.
    fn link(&self, target: NaifId, t: Instant, source: Option<Source>) -> Option<ChainLink<'_>> {
        let tdb_s = t.tdb_seconds_past_j2000();
        let link_to = |origin: i32, theory| Some(ChainLink { target, origin: NaifId(origin), theory });
        if source.is_none_or(|s| s == Source::Kernel)
            && let Some((index, segment)) = self.kernels.iter().enumerate().find_map(|(i, k)| Some((i, k.segment(target.0, tdb_s)?)))
        {
            let is_shipped = index + 1 == self.kernels.len();
            let error_km = if is_shipped { kernel_error_km(target) } else { f64::INFINITY };
            return link_to(segment.center, Theory::Kernel { segment, error_km });
        }
        if source.is_none_or(|s| s == Source::Series)
            && in_years(t, SERIES_YEARS)
            && let Some(origin) = self.series.origin_of(target.0, tdb_s)
        {
            return link_to(origin, Theory::Series);
        }
        if source.is_none_or(|s| s == Source::Mean)
            && in_years(t, MEAN_ELEMENTS_YEARS)
            && let Some(origin) = mean_elements::origin_of(target.0)
        {
            return link_to(origin, Theory::Mean);
        }
        if is_centre_from_moons(target) {
            return link_to(target.0 / 100, Theory::CentreFromMoons);
        }
        match self.orbits.get(&target)? {
            Orbit { motion: Motion::Planetary, .. } => None,
            Orbit { parent, motion } => link_to(parent.0, Theory::Orbit(motion)),
        }
    }

    /// The state of a link's target relative to the link's origin; `None` if the theory has no state at `t`.
    fn evaluate(&self, link: &ChainLink, t: Instant) -> Option<LinkState> {
        let (target, tdb_s) = (link.target, t.tdb_seconds_past_j2000());
        let (state, source, error_km) = match link.theory {
            Theory::Kernel { segment, error_km } => (segment.state(tdb_s), Source::Kernel, error_km),
            Theory::Series => (self.series.state(target.0, tdb_s)?, Source::Series, series::error_km(target.0, tdb_s)),
            Theory::Mean => (self.mean_state(target.0, tdb_s)?, Source::Mean, mean_elements::error_km(target.0, tdb_s)),
            Theory::CentreFromMoons => return self.centre_from_barycentre(target, t),
            Theory::Orbit(motion) => return self.evaluate_orbit(target, motion, t),
        };
        Some(LinkState { state, source: Some(source), error_km })
    }

    /// The state of [`Theory::Mean`], relative to the target's origin ([`mean_elements::origin_of`]).
    fn mean_state(&self, target: i32, tdb_s: f64) -> Option<State> {
        match target {
            1..=9 => mean_elements::planet(target, tdb_s),
            10 => Some(mean_elements::sun(tdb_s)),
            301 => Some(self.series.moon_by_largest_terms(tdb_s)),
            399 => Some(series::earth_from_moon(self.series.moon_by_largest_terms(tdb_s))),
            // Mercury and Venus coincide with their barycentres.
            _ => Some(State::REST),
        }
    }

    /// Evaluates the orbit of a body about its parent. The orbits of moons and asteroids are used for every `source`, because nothing else gives their motion.
    fn evaluate_orbit(&self, target: NaifId, motion: &Motion, t: Instant) -> Option<LinkState> {
        if !in_years(t, ORBIT_YEARS) {
            return None;
        }
        let (state, source, error_km) = match motion {
            Motion::Planetary => return None,
            Motion::GalileanL12 { index } => (self.moon_theories.galilean.state(*index, t)?, Source::Series, galilean::error_km(*index, t)),
            Motion::Tass17 { index } => (self.moon_theories.saturn.state(*index, t)?, Source::Series, tass::error_km(*index, t)),
            Motion::MeanElements(elements) => (two_body::state(elements, t), Source::Mean, drift::error_km(target, elements, t)),
        };
        Some(LinkState { state, source: Some(source), error_km })
    }

    /// The centre of a planet relative to its system's barycentre, from the masses m of its moons and their positions r relative to the planet:
    /// -Σ m r / M, with M the mass of the system.
    fn centre_from_barycentre(&self, planet: NaifId, t: Instant) -> Option<LinkState> {
        let mut recent_centres = self.recent_centres.lock();
        if let Some((.., cached)) = recent_centres.iter().find(|(cached_planet, instant, _)| *cached_planet == planet && *instant == t) {
            return Some(*cached);
        }
        let mut centre = LinkState { state: State::REST, source: None, error_km: OMITTED_MOONS_KM };
        for share in self.mass_shares.get(&planet).map_or(&[][..], Vec::as_slice) {
            let moon = self.evaluate_orbit(share.moon, &self.orbits.get(&share.moon)?.motion, t)?;
            centre.state.pos_km -= moon.state.pos_km * share.mass_share;
            centre.state.vel_km_s -= moon.state.vel_km_s * share.mass_share;
            centre.source = [centre.source, moon.source].into_iter().flatten().min();
            centre.error_km += moon.error_km * share.mass_share;
        }
        if recent_centres.len() >= MAX_RECENT_CENTRES {
            recent_centres.pop_front();
        }
        recent_centres.push_back((planet, t, centre));
        Some(centre)
    }
}

/// Years in which series are used: those of [`MEAN_ELEMENTS_YEARS`]. VSOP87's authors state an error of 1 arcsec for 4000 years either side of 2000 (Mercury to
/// Mars), 2000 years (Jupiter, Saturn) and 6000 years (Uranus, Neptune). Before these spans the error is larger: [`series::error_km`] grows with time.
const SERIES_YEARS: (f64, f64) = (-3000.0, 3001.0);
/// Years in which mean elements are used: the span of their tables, from the year -3000 (3001 BC) to the end of AD 3000.
const MEAN_ELEMENTS_YEARS: (f64, f64) = (-3000.0, 3001.0);
/// Years in which moons and rotations are computed, with an error that grows: a long kernel such as DE441 may cover their planet in these years.
const ORBIT_YEARS: (f64, f64) = (-20_000.0, 20_000.0);

/// Whether a target is a planet whose centre is computed from the masses of its moons.
fn is_centre_from_moons(target: NaifId) -> bool {
    matches!(target.0, 499 | 599 | 699 | 799 | 899 | 999)
}

/// Whether an instant lies between two Julian years, such as [`SERIES_YEARS`].
fn in_years(t: Instant, (first, last): (f64, f64)) -> bool {
    (first..=last).contains(&(2000.0 + t.tdb_seconds_past_j2000() / (DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY)))
}

/// A moon and its share of its system's mass.
#[derive(Clone, Copy, Debug)]
struct MassShare {
    moon: NaifId,
    mass_share: f64,
}

/// Moons with a smaller share of their system's mass are left out. Of these, Hyperion and Mimas have the largest effects: they shift Saturn by 15 and
/// 12 metres. Phobos shifts Mars by 0.2 metres.
const MIN_MASS_SHARE: f64 = 1e-7;
/// Upper limit of the effect of the omitted moons, km.
const OMITTED_MOONS_KM: f64 = 0.05;

/// The heavy moons of each body whose GM is known, for [`Ephemeris::mass_shares`].
fn mass_shares(catalog: &Catalog) -> HashMap<NaifId, Vec<MassShare>> {
    let mut mass_shares = HashMap::new();
    for planet in catalog.bodies() {
        let Some(planet_gm) = planet.gm_km3_s2 else { continue };
        let moons = || catalog.moons_of(planet.id).filter_map(|moon| Some((moon.id, moon.gm_km3_s2?)));
        let system_gm = planet_gm + moons().map(|(_, gm)| gm).sum::<f64>();
        let heavy_moons =
            moons().map(|(moon, gm)| MassShare { moon, mass_share: gm / system_gm }).filter(|share| share.mass_share > MIN_MASS_SHARE);
        mass_shares.insert(planet.id, heavy_moons.collect());
    }
    mass_shares
}

/// A chain of links without a heap allocation; unused entries come last.
struct StateChain<'a> {
    first: NaifId,
    links: [Option<ChainLink<'a>>; MAX_CHAIN_LINKS],
}

impl<'a> StateChain<'a> {
    /// The first `len` links.
    fn links(&self, len: usize) -> impl Iterator<Item = &ChainLink<'a>> {
        self.links[..len].iter().flatten()
    }

    /// Each target of the chain, with the number of links from the first target to it.
    fn targets(&self) -> impl Iterator<Item = (usize, NaifId)> {
        std::iter::once(self.first).chain(self.links(MAX_CHAIN_LINKS).map(|link| link.origin)).enumerate()
    }

    /// The last target of the chain: the solar system's barycentre, unless a theory is missing.
    fn end(&self) -> NaifId {
        self.links(MAX_CHAIN_LINKS).last().map_or(self.first, |link| link.origin)
    }
}

/// Worst error of a shipped segment against DE440, km; printed by `examples/bake_kernel.rs` and rounded up. NAIF codes: barycentres 1 to 9, the Sun 10, the
/// Moon 301, the Earth 399. For Mercury and Venus, which coincide with their barycentres, it is a nominal bound.
fn kernel_error_km(target: NaifId) -> f64 {
    match target.0 {
        10 => 0.1,
        1 | 2 => 0.5,
        3 => 0.3,
        4 => 1.0,
        5 | 6 => 2.0,
        7..=9 => 5.0,
        399 | 301 => 0.03,
        _ => 0.001,
    }
}
