//! Phenomena of the Galilean moons and Titan: transits, occultations, shadow transits, eclipses.
//!
//! In: a span of time. Out: events as the Earth's centre sees them. The geometry is that of planes that touch the planet's spheroid and the source: the
//! Earth as a point for transits and occultations, the Sun's disc for shadows and eclipses. Light time between Sun, moon, planet and Earth is included. An
//! event is listed even if another hides it, such as the end of an eclipse behind the planet. The theories of the moons limit the accuracy of instants:
//! 30 s for the Galilean moons. Not here: the planets' atmospheres, which delay eclipses by a minute or so.

use super::contacts::{Contact, seconds_between, sort_by_time};
use super::fitted::FittedPlace;
use super::numeric::{end_of_negative, least, least_instant};
use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::{Ephemeris, EphemerisError};
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::DVec3;

pub(super) const GALILEAN: [NaifId; 4] = [NaifId(501), NaifId(502), NaifId(503), NaifId(504)];
const MOONS: [NaifId; 5] = [NaifId(501), NaifId(502), NaifId(503), NaifId(504), NaifId(606)];
/// Samples per orbit between which conjunctions are searched.
const STEPS_PER_ORBIT: f64 = 16.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoonEventType {
    /// The moon in front of the planet.
    Transit,
    /// The moon behind the planet.
    Occultation,
    /// The moon's shadow on the planet.
    ShadowTransit,
    /// The moon in the planet's shadow.
    Eclipse,
    /// The moon behind another moon.
    MutualOccultation,
    /// The moon in another moon's shadow.
    MutualEclipse,
}

impl MoonEventType {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Transit => "transit",
            Self::Occultation => "occultation",
            Self::ShadowTransit => "shadow transit",
            Self::Eclipse => "eclipse",
            Self::MutualOccultation => "mutual occultation",
            Self::MutualEclipse => "mutual eclipse",
        }
    }
}

#[derive(Clone, Debug)]
pub struct MoonEvent {
    pub class: MoonEventType,
    pub moon: NaifId,
    pub planet: NaifId,
    /// The other moon of a mutual event.
    pub by: Option<NaifId>,
    /// When the moon or its shadow is nearest to the middle of the planet, or the moon to the middle of the shadow around it. In mutual events,
    /// when the centres of the two moons are nearest.
    pub greatest: Instant,
    /// Contacts by time. `begin` and `end`: the moon's centre passes the planet's edge, seen from the Earth or from the Sun's centre. I, II, III, IV: the
    /// limbs touch, in transits and occultations. P1 and P4: the penumbra touches and leaves; U2 and U3: the moon is entirely inside the umbra. U1 and U4:
    /// umbra or antumbra of another moon touches and leaves.
    pub contacts: Vec<Contact>,
}

impl MoonEvent {
    /// Seconds from `begin` to `end`; in mutual events from the first to the last contact.
    pub(crate) fn duration_s(&self) -> Option<f64> {
        let between = |first, last| seconds_between(&self.contacts, first, last);
        between("begin", "end")
            .or_else(|| between("I", "IV").filter(|_| self.by.is_some()))
            .or_else(|| between("P1", "P4").filter(|_| self.by.is_some()))
    }
}

/// Events whose greatest phase is in `from..to`, moon by moon. Moons that the catalog lacks are left out.
///
/// # Errors
/// The theories do not cover the span.
pub fn moon_events(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<MoonEvent>, EphemerisError> {
    let mut found = Vec::new();
    let Some(sun) = catalog.body(NaifId::SUN) else { return Ok(found) };
    for moon in MOONS.iter().filter_map(|id| catalog.body(*id)) {
        let Some(planet) = moon.parent.and_then(|id| catalog.body(id)) else { continue };
        let pair = Pair { ephemeris, sun_km: sun.radii_km.x, planet, moon };
        for source in [NaifId::EARTH, NaifId::SUN] {
            for (middle, before) in pair.conjunctions(source, from, to)? {
                let event = Passage::around(&pair, source, middle)?.event(&pair, before)?;
                found.extend(event.filter(|e| (from..to).contains(&e.greatest)));
            }
        }
    }
    Ok(found)
}

struct Pair<'a> {
    ephemeris: &'a Ephemeris,
    sun_km: f64,
    planet: &'a Body,
    moon: &'a Body,
}

impl Pair<'_> {
    fn moon_from_planet(&self, t: Instant) -> Result<(DVec3, DVec3), EphemerisError> {
        let state = self.ephemeris.state(self.moon.id, self.planet.id, t, None)?.state;
        Ok((state.pos_km, state.vel_km_s))
    }

    /// When the moon crosses the line from the planet to a body, as time at the planet to some seconds, and whether it is in front of the planet.
    fn conjunctions(&self, source: NaifId, from: Instant, to: Instant) -> Result<Vec<(Instant, bool)>, EphemerisError> {
        let system = NaifId(self.planet.id.0 / 100);
        let sides = |t: Instant| -> Result<(f64, f64), EphemerisError> {
            let (pos_km, vel_km_s) = self.moon_from_planet(t)?;
            let towards = self.ephemeris.state(source, system, t, None)?.state.pos_km;
            let aside = pos_km.cross(vel_km_s).cross(towards);
            Ok((pos_km.dot(aside) / aside.length(), pos_km.dot(towards)))
        };
        // Light from the planet takes less than two hours.
        const LIGHT_S: f64 = 7200.0;
        let (pos_km, vel_km_s) = self.moon_from_planet(from)?;
        let step_s = std::f64::consts::TAU * pos_km.length() / vel_km_s.length() / STEPS_PER_ORBIT;
        let mut found = Vec::new();
        let mut at = from.plus_seconds(-LIGHT_S - step_s);
        let mut here = sides(at)?.0;
        while at < to {
            let next = at.plus_seconds(step_s);
            let there = sides(next)?.0;
            if (here < 0.0) != (there < 0.0) {
                // Secant method: the sideways offset is nearly linear in time here.
                let (mut a, mut fa, mut b, mut fb) = (0.0, here, step_s, there);
                for _ in 0..4 {
                    let s = a - fa * (b - a) / (fb - fa);
                    let f = sides(at.plus_seconds(s))?.0;
                    if (s - b).abs() < 1.0 || f == fb {
                        b = s;
                        break;
                    }
                    (a, fa, b, fb) = (b, fb, s, f);
                }
                let middle = at.plus_seconds(b);
                found.push((middle, sides(middle)?.1 > 0.0));
            }
            (at, here) = (next, there);
        }
        Ok(found)
    }
}

/// A moon, its planet and the source (the Sun, or the Earth as observer) around a conjunction. Times are seconds from the middle, at the planet; vectors
/// are from the planet's centre, km, ICRF axes.
struct Passage {
    source: NaifId,
    middle: Instant,
    half_s: f64,
    moon: FittedPlace,
    /// Vector to the Earth when it receives the light, or to the Sun when it sent the light.
    to_source: FittedPlace,
    /// Barycentric velocity of the planet.
    planet_velocity_km_s: DVec3,
    pole: DVec3,
}

/// The planes that bound a region. They touch the planet, and pass through the source's centre or touch its disc on the same or the opposite side.
#[derive(Clone, Copy)]
enum Edge {
    Centre,
    /// External tangent planes: of the umbra, and of the region of all lines between planet and Sun.
    Outer,
    /// Internal tangent planes: of the penumbra.
    Crossed,
}

impl Passage {
    fn around(pair: &Pair<'_>, source: NaifId, middle: Instant) -> Result<Self, EphemerisError> {
        let (planet, ephemeris) = (pair.planet.id, pair.ephemeris);
        let (_, vel_km_s) = pair.moon_from_planet(middle)?;
        let half_s = 2.0 * (pair.planet.radii_km.x + pair.moon.radii_km.x) / vel_km_s.length() + 600.0;
        let at = |s: f64| middle.plus_seconds(s);
        let moon = FittedPlace::over(half_s, |s| Ok(pair.moon_from_planet(at(s))?.0))?;
        let to_source = FittedPlace::over(half_s, |s| way_to(ephemeris, planet, source, at(s)))?;
        let planet_velocity_km_s = ephemeris.state(planet, NaifId::SOLAR_SYSTEM_BARYCENTER, middle, None)?.state.vel_km_s;
        let pole = ephemeris.body_from_icrf(planet, middle)?.row(2);
        Ok(Self { source, middle, half_s, moon, to_source, planet_velocity_km_s, pole })
    }

    /// For light that reaches or leaves the planet's centre at `s`: the moon's position when the light passes it, how many seconds later that is,
    /// and the vector to the source.
    fn places(&self, s: f64) -> (DVec3, f64, DVec3) {
        let to_source = self.to_source.at(s);
        let along_km = self.moon.at(s).dot(to_source.normalize_or_zero());
        // Light goes from the planet to the Earth, and from the Sun to the planet.
        let later_s = if self.source == NaifId::SUN { -along_km } else { along_km } / SPEED_OF_LIGHT_KM_S;
        (self.moon.at(s + later_s) + self.planet_velocity_km_s * later_s, later_s, to_source)
    }

    /// How far the moon's centre lies outside the region, km.
    fn outside_km(&self, pair: &Pair<'_>, s: f64, edge: Edge) -> f64 {
        let (moon_km, _, to_source) = self.places(s);
        let distance_km = to_source.length();
        let towards = to_source / distance_km;
        let radius_km = match edge {
            Edge::Centre => 0.0,
            Edge::Outer => -pair.sun_km,
            Edge::Crossed => pair.sun_km,
        };
        let radii_km = pair.planet.radii_km;
        let reach_km = |n: DVec3| (n * radii_km.x + self.pole * (n.dot(self.pole) * (radii_km.z - radii_km.x))).length();
        let aside = (moon_km - towards * moon_km.dot(towards)).try_normalize().unwrap_or_else(|| towards.any_orthonormal_vector());
        let other = towards.cross(aside);
        let beyond = |angle: f64| {
            let across = aside * angle.cos() + other * angle.sin();
            // The normal is tilted so that the plane touches both planet and source.
            let lean = (reach_km(across) + radius_km) / distance_km;
            let normal = across * (1.0 - lean * lean).max(0.0).sqrt() + towards * lean;
            moon_km.dot(normal) - reach_km(normal)
        };
        beyond(least(-0.3, 0.3, 1e-5, |angle| -beyond(angle)))
    }

    /// When the Earth's centre sees what happens at `s`: for an eclipse at the moon, else at the planet.
    fn seen(&self, pair: &Pair<'_>, class: MoonEventType, s: f64) -> Result<Instant, EphemerisError> {
        let (moon_km, later_s, _) = self.places(s);
        let at = self.middle.plus_seconds(s);
        let planet_km = pair.ephemeris.state(pair.planet.id, NaifId::SOLAR_SYSTEM_BARYCENTER, at, None)?.state.pos_km;
        if class == MoonEventType::Eclipse {
            return received(pair.ephemeris, planet_km + moon_km, at.plus_seconds(later_s));
        }
        received(pair.ephemeris, planet_km, at)
    }

    fn event(&self, pair: &Pair<'_>, before: bool) -> Result<Option<MoonEvent>, EphemerisError> {
        let class = match (self.source == NaifId::SUN, before) {
            (false, true) => MoonEventType::Transit,
            (false, false) => MoonEventType::Occultation,
            (true, true) => MoonEventType::ShadowTransit,
            (true, false) => MoonEventType::Eclipse,
        };
        let radius_km = pair.moon.radii_km.x;
        // Names of both contacts, the edge and the distance of the moon's centre from it.
        let limits: &[(&str, &str, Edge, f64)] = match class {
            MoonEventType::Transit | MoonEventType::Occultation => {
                &[("I", "IV", Edge::Centre, radius_km), ("II", "III", Edge::Centre, -radius_km), ("begin", "end", Edge::Centre, 0.0)]
            }
            MoonEventType::ShadowTransit => &[("P1", "P4", Edge::Outer, radius_km), ("begin", "end", Edge::Centre, 0.0)],
            _ => &[("P1", "P4", Edge::Crossed, radius_km), ("U2", "U3", Edge::Outer, -radius_km), ("begin", "end", Edge::Centre, 0.0)],
        };
        let sideways_km = |s: f64| {
            let (moon_km, _, to_source) = self.places(s);
            moon_km.cross(to_source.normalize_or_zero()).length()
        };
        let reach_s = self.half_s - 30.0;
        let deepest_s = least_instant(-reach_s, reach_s, sideways_km);
        let mut contacts = Vec::new();
        for &(first, last, edge, distance_km) in limits {
            let outside = |s: f64| self.outside_km(pair, s, edge) - distance_km;
            if outside(deepest_s) < 0.0 {
                contacts.push((first, self.seen(pair, class, end_of_negative(deepest_s, -reach_s, outside))?));
                contacts.push((last, self.seen(pair, class, end_of_negative(deepest_s, reach_s, outside))?));
            }
        }
        sort_by_time(&mut contacts);
        let greatest = self.seen(pair, class, deepest_s)?;
        let event = MoonEvent { class, moon: pair.moon.id, planet: pair.planet.id, by: None, greatest, contacts };
        Ok((!event.contacts.is_empty()).then_some(event))
    }
}

/// Vector from a planet at `t` to the Earth when it receives the planet's light, or to the Sun when it sent the light that arrives at `t`: km, ICRF
/// axes.
pub(super) fn way_to(ephemeris: &Ephemeris, planet: NaifId, source: NaifId, t: Instant) -> Result<DVec3, EphemerisError> {
    let barycentric_km = |body, t| Ok::<_, EphemerisError>(ephemeris.state(body, NaifId::SOLAR_SYSTEM_BARYCENTER, t, None)?.state.pos_km);
    let planet_km = barycentric_km(planet, t)?;
    if source == NaifId::SUN {
        return Ok(ephemeris.light_time_position(NaifId::SUN, planet_km, t)?.0 - planet_km);
    }
    Ok(barycentric_km(source, received(ephemeris, planet_km, t)?)? - planet_km)
}

/// When the Earth's centre receives light that leaves a barycentric place at `t`.
pub(super) fn received(ephemeris: &Ephemeris, place_km: DVec3, t: Instant) -> Result<Instant, EphemerisError> {
    let mut at = t;
    // The Earth's speed is 1e-4 of light's: three rounds leave less than a microsecond.
    for _ in 0..3 {
        let earth_km = ephemeris.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, at, None)?.state.pos_km;
        at = t.plus_seconds((earth_km - place_km).length() / SPEED_OF_LIGHT_KM_S);
    }
    Ok(at)
}
