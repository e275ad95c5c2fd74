//! Minor planets and comets: orbit and brightness of each.
//!
//! In: the text of a table. Out: [`SmallBodies`], in the order of the file. Always: every number is finite and in its range; orbits are heliocentric; the two
//! vectors that orient an orbit are perpendicular unit vectors (ICRF). Orbits are osculating: perturbations since the epoch are left out;
//! embedded comets have an orbit for each of several apparitions. Not here: positions
//! (`ephemeris::conic`), and the brightness in an image (`scene`).

mod light_curves;
mod mpcorb;
mod names;
mod read;
mod rows;

use crate::catalog::{Catalog, NaifId};
use crate::random::Random;
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;
use std::sync::{Arc, LazyLock};

pub use names::NamedTarget;

/// Gauss' constant: square root of the Sun's GM in au^1.5 per day (IAU 1976). It once defined the au. IAU 2012 Resolution B2 fixes the au in kilometres
/// instead; the two lengths differ by less than 1e-9 of the au.
pub const GAUSS_CONSTANT: f64 = 0.017_202_098_95;

/// A conic about the Sun, given by its perihelion and the time of a perihelion passage. A parabola has these, too, but neither a semi-major axis nor a mean
/// anomaly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeliocentricOrbit {
    /// Perihelion distance, positive.
    pub perihelion_au: f64,
    /// Eccentricity, 0 or more.
    pub eccentricity: f64,
    /// Unit vector from the Sun to the perihelion, ICRF.
    pub to_perihelion: DVec3,
    /// Unit vector of the direction of motion at the perihelion, ICRF.
    pub motion_at_perihelion: DVec3,
    /// Time of a perihelion passage, days from J2000 (TDB), negative before.
    pub passage_days: f64,
}

impl HeliocentricOrbit {
    /// The period of an ellipse; `None` for a parabola or a hyperbola.
    pub fn period_days(&self) -> Option<f64> {
        let one_minus_e = 1.0 - self.eccentricity;
        (one_minus_e > 0.0).then(|| TAU / GAUSS_CONSTANT * (self.perihelion_au / one_minus_e).powf(1.5))
    }

    /// Time since the nearest perihelion passage, days, negative before it. `days`: from J2000 (TDB).
    pub fn since_passage(&self, days: f64) -> f64 {
        let since = days - self.passage_days;
        self.period_days().map_or(since, |period| since - period * (since / period).round())
    }
}

/// The brightness law of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BrightnessLaw {
    /// Absolute magnitude and slope of the H,G system (Bowell et al. 1989, Asteroids II, 524).
    Asteroid { h: f64, g: f64 },
    /// M1 and K1 of JPL's Small-Body Database: the total magnitude at 1 au from Sun and observer, and the magnitudes by which the comet is fainter at ten times
    /// the heliocentric distance. `dust_to_gas`: the light that dust scatters by 90 degrees, divided by the light of gas ([`ORDINARY_DUST_TO_GAS`]).
    Comet { m1: f64, k1: f64, dust_to_gas: f64 },
    /// The table gives no magnitude.
    Unknown,
}

/// A minor planet or a comet.
#[derive(Clone, Debug, PartialEq)]
pub struct SmallBody {
    /// Number or provisional designation, such as `2`; empty where the table has none.
    pub designation: String,
    /// Proper name (`Pallas`), or the full name (`1P/Halley`) if the table has only that; empty for a body with a designation alone.
    pub name: String,
    /// Its orbit about the Sun.
    pub orbit: HeliocentricOrbit,
    /// Its brightness by distance and phase angle; of a comet whose light curve is known, that before perihelion.
    pub brightness: BrightnessLaw,
    /// More about a well-known comet. Boxed, because a table may have over a million bodies without it.
    pub known: Option<Box<KnownComet>>,
}

/// What is known of a comet beyond one orbit and one brightness law.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnownComet {
    /// The brightness law after perihelion, if it is another; see [`SmallBody::brightness_at`].
    pub brightness_after_perihelion: Option<BrightnessLaw>,
    /// Orbits at other apparitions, each by osculating elements of its own; see [`SmallBody::orbit_at`].
    pub apparitions: Vec<HeliocentricOrbit>,
}

/// Ratio of the light of dust to that of gas in the coma of an ordinary comet, for light scattered by 90 degrees; 10 in a dusty one (Marcus 2007, Int. Comet
/// Quarterly 29, 39).
pub const ORDINARY_DUST_TO_GAS: f64 = 1.0;

/// Days from the perihelion on in which a comet's brightness law changes to that after it.
const LAW_CHANGE_DAYS: f64 = 10.0;

impl SmallBody {
    /// A body with one orbit and one brightness law.
    pub fn of(designation: &str, name: &str, orbit: HeliocentricOrbit, brightness: BrightnessLaw) -> Self {
        let (designation, name) = (designation.to_owned(), name.to_owned());
        Self { designation, name, orbit, brightness, known: None }
    }

    /// The orbit for a time, in days from J2000 (TDB): of those known the one with the nearest perihelion.
    pub fn orbit_at(&self, days: f64) -> &HeliocentricOrbit {
        let distance = |orbit: &HeliocentricOrbit| (days - orbit.passage_days).abs();
        let others = self.known.iter().flat_map(|known| &known.apparitions);
        others.fold(&self.orbit, |best, orbit| if distance(orbit) < distance(best) { orbit } else { best })
    }

    /// The brightness law at a time, in days from J2000 (TDB).
    pub fn brightness_at(&self, days: f64) -> BrightnessLaw {
        match (self.brightness, self.known.as_ref().and_then(|known| known.brightness_after_perihelion)) {
            (BrightnessLaw::Comet { m1, k1, dust_to_gas }, Some(BrightnessLaw::Comet { m1: m1_after, k1: k1_after, .. })) => {
                let change = (self.orbit_at(days).since_passage(days) / LAW_CHANGE_DAYS).clamp(0.0, 1.0);
                BrightnessLaw::Comet { m1: m1 + change * (m1_after - m1), k1: k1 + change * (k1_after - k1), dust_to_gas }
            }
            (law, _) => law,
        }
    }

    /// Whether no known orbit is of the apparition of this time (days from J2000, TDB): the planets have changed the orbit since, so that the body is days to
    /// months before or behind its computed place.
    pub fn is_between_apparitions(&self, days: f64) -> bool {
        let orbit = self.orbit_at(days);
        orbit.period_days().is_some_and(|period| (days - orbit.passage_days).abs() > 0.5 * period)
    }

    /// The full name: `2 Pallas`, `1P/Halley`.
    pub fn full_name(&self) -> String {
        match (self.designation.as_str(), self.name.as_str()) {
            ("", name) => name.to_owned(),
            (designation, "") => designation.to_owned(),
            (designation, name) => format!("{designation} {name}"),
        }
    }

    /// Whether its brightness follows the law of comets: false for a comet whose table has no M1.
    pub fn is_comet(&self) -> bool {
        matches!(self.brightness, BrightnessLaw::Comet { .. })
    }
}

/// The name without number and designation: `Ceres` for `1 Ceres (A801 AA)`, the form in which JPL writes full names.
fn bare_name(name: &str) -> &str {
    let name = name.split('(').next().unwrap_or_default();
    name.trim_start_matches(|c: char| c.is_ascii_digit()).trim()
}

/// The bodies of one or more tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SmallBodies {
    pub minor_planets: Vec<SmallBody>,
    pub comets: Vec<SmallBody>,
}

/// An error in a table of small bodies, in one line: file, line, field, what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {message}")]
pub struct SmallBodyFileError {
    pub file: String,
    /// Line number, starting at 1.
    pub line: usize,
    pub message: String,
}

static EMBEDDED: LazyLock<Arc<SmallBodies>> = LazyLock::new(|| {
    let read = |name: &str, text: &str| match SmallBodies::parse(name, text) {
        Ok(bodies) => bodies,
        Err(e) => panic!("an embedded table is broken: {e}"),
    };
    let mut all = read("small_bodies.csv", orrery_catalogs::SMALL_BODIES);
    all.comets = read("comets.csv", orrery_catalogs::COMETS).comets;
    // Rows without a magnitude: further orbits of comets.
    for apparition in read("comet_apparitions.csv", orrery_catalogs::COMET_APPARITIONS).minor_planets {
        match all.comets.iter_mut().find(|comet| comet.name == apparition.name) {
            Some(comet) => comet.known.get_or_insert_default().apparitions.push(apparition.orbit),
            None => panic!("comet_apparitions.csv: no comet {}", apparition.name),
        }
    }
    light_curves::add_to(&mut all.comets);
    Arc::new(all)
});

impl SmallBodies {
    /// The 605 minor planets and the comets that are embedded in the program. A test verifies that they can be read, so this never panics in a released
    /// program.
    pub fn embedded() -> Arc<Self> {
        Arc::clone(&EMBEDDED)
    }

    /// Reads a table: comma-separated values with named columns, JSON of JPL's Small-Body Database, or MPCORB.DAT.
    ///
    /// # Errors
    /// Names the first line that cannot be read.
    pub fn parse(file: &str, text: &str) -> Result<Self, SmallBodyFileError> {
        let (comets, minor_planets) = read::read(file, text)?.into_iter().partition(SmallBody::is_comet);
        Ok(Self { minor_planets, comets })
    }

    /// An invented main belt of `count` bodies, for measurements of speed. It is the same at each call. Semi-major axes, eccentricities and inclinations are
    /// those of embedded bodies between the 4:1 and 2:1 resonances with Jupiter (2.06 to 3.28 au), with random offsets of at most 0.02 au in axis
    /// and 0.02 in eccentricity. Node, perihelion and time of passage are uniformly distributed.
    pub fn synthetic_belt(count: usize) -> Self {
        let semi_major_axis_au = |orbit: &HeliocentricOrbit| orbit.perihelion_au / (1.0 - orbit.eccentricity);
        let embedded = Self::embedded();
        let templates: Vec<&SmallBody> =
            embedded.minor_planets.iter().filter(|b| (2.06..3.28).contains(&semi_major_axis_au(&b.orbit))).collect();
        let mut random = Random::new(0);
        let mut uniform = || random.unit_interval();
        let body = |k: usize| {
            let template = templates[((uniform() * templates.len() as f64) as usize).min(templates.len() - 1)];
            let template_orbit = &template.orbit;
            let e = (template_orbit.eccentricity + 0.04 * (uniform() - 0.5)).clamp(0.0, 0.6);
            let a = semi_major_axis_au(template_orbit) + 0.04 * (uniform() - 0.5);
            // The orbital plane is rotated about the ecliptic's pole, the perihelion within the plane. The ecliptic is that of J2000, to which the tables
            // refer.
            let (node_turn, perihelion_turn) = (TAU * uniform(), TAU * uniform());
            let pole = DVec3::new(0.0, -rows::OBLIQUITY_RAD.sin(), rows::OBLIQUITY_RAD.cos());
            let normal = DQuat::from_axis_angle(pole, node_turn) * template_orbit.to_perihelion.cross(template_orbit.motion_at_perihelion);
            let to_perihelion = DQuat::from_axis_angle(normal, perihelion_turn) * normal.any_orthonormal_vector();
            let orbit = HeliocentricOrbit {
                perihelion_au: a * (1.0 - e),
                eccentricity: e,
                to_perihelion,
                motion_at_perihelion: normal.cross(to_perihelion),
                passage_days: TAU / GAUSS_CONSTANT * a.powf(1.5) * uniform(),
            };
            // The number of bodies down to magnitude h grows as 10^(h / 2) (Ivezic et al. 2001, Astron. J. 122, 2749). The faintest have h = 17, so
            // the fraction u of all bodies is brighter than h = 17 + 2 log10(u).
            let h = 17.0 + 2.0 * uniform().max(1e-6).log10();
            SmallBody::of("", &format!("synthetic {k}"), orbit, BrightnessLaw::Asteroid { h, g: rows::DEFAULT_G })
        };
        Self { minor_planets: (0..count).map(body).collect(), comets: Vec::new() }
    }

    /// Removes the minor planets that the catalog contains as bodies.
    #[must_use]
    pub fn without_bodies_of(mut self, catalog: &Catalog) -> Self {
        // Only bodies about the Sun count: a moon and a minor planet may share a name, as Europa and 52 Europa do.
        let names: Vec<&str> = catalog.bodies().iter().filter(|b| b.parent == Some(NaifId::SUN)).map(|b| b.name.as_str()).collect();
        self.minor_planets.retain(|b| !names.iter().any(|known| known.eq_ignore_ascii_case(bare_name(&b.name))));
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_tables_have_the_stated_bodies() {
        let all = SmallBodies::embedded();
        assert_eq!(all.minor_planets.len(), 605);
        assert!(all.comets.len() > 20 && all.comets.iter().all(SmallBody::is_comet));
        for body in all.minor_planets.iter().chain(&all.comets) {
            let orbit = &body.orbit;
            let is_right_angle = orbit.to_perihelion.dot(orbit.motion_at_perihelion).abs() < 1e-12;
            assert!(is_right_angle && (orbit.to_perihelion.length() - 1.0).abs() < 1e-12, "{}", body.full_name());
        }
        // Light curves and apparitions were found by name.
        let known = || all.comets.iter().filter_map(|c| c.known.as_ref());
        assert!(known().filter(|k| k.brightness_after_perihelion.is_some()).count() >= 5);
        assert!(known().map(|k| k.apparitions.len()).sum::<usize>() > 90);
        // `MAX_BODIES` of a file's bodies stay small.
        assert!(all.minor_planets.iter().all(|b| b.known.is_none()) && size_of::<SmallBody>() <= 160, "{}", size_of::<SmallBody>());
        // Ceres: a (1 - e) = 2.7666 au x (1 - 0.0786) of its osculating elements; perihelion on 7 December 2022 (JPL Horizons), about day 8375 from J2000.
        let ceres = all.minor_planets.iter().find(|b| b.name == "Ceres").expect("Ceres").orbit;
        assert!((ceres.perihelion_au - 2.5491).abs() < 1e-3 && (ceres.passage_days - 8375.0).abs() < 3.0, "{ceres:?}");
    }

    #[test]
    fn minor_planets_of_the_catalog_are_not_duplicated() {
        let left = (*SmallBodies::embedded()).clone().without_bodies_of(&Catalog::embedded());
        let has = |name: &str| left.minor_planets.iter().any(|b| b.name == name);
        assert!(!has("Ceres") && !has("Vesta") && !has("Pluto") && has("Pallas") && has("Juno"));
    }
}
