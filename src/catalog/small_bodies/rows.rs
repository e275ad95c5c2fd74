//! One row of a table of small bodies: its fields, their units and ranges, and the orbit computed from them.
//!
//! In: the text of each field of the row. Out: a [`SmallBody`], or a message with the wrong field and its allowed values. An orbit is given by the perihelion
//! distance or the semi-major axis, and by the time of a perihelion passage or the mean anomaly at an epoch; angles in degrees, ecliptic and equinox of J2000.
//! The mean equator and equinox of J2000 are taken for the axes of the ICRF, from which they differ by 0.02 arcsec.

use super::{BrightnessLaw, GAUSS_CONSTANT, HeliocentricOrbit, ORDINARY_DUST_TO_GAS, SmallBody};
use crate::units::{JD_J2000, RAD_PER_ARCSEC};
use crate::wording::echo_within;
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

/// Obliquity of the J2000 ecliptic to which published orbital elements refer (IAU 1976: 84381.448 arcsec).
pub(super) const OBLIQUITY_RAD: f64 = 84_381.448 * RAD_PER_ARCSEC;
/// Julian date of modified Julian date 0.
const JD_OF_MJD_ZERO: f64 = 2_400_000.5;
/// Slope of the H,G law where the table has none (IAU 1985).
pub(super) const DEFAULT_G: f64 = 0.15;
/// A comet's K1 where the table has none: its brightness falls with the fourth power of the heliocentric distance (10 = 2.5 * 4).
const DEFAULT_K1: f64 = 10.0;

/// A quantity of a row.
pub(super) struct Field {
    /// Its name in messages, with its unit.
    pub name: &'static str,
    /// The accepted names of its column, reduced to lower-case letters and digits. Earlier ones have precedence.
    pub columns: &'static [&'static str],
    /// Smallest and largest allowed value, in the field's unit.
    min: f64,
    max: f64,
    /// What messages call an allowed value.
    expected: &'static str,
}

impl Field {
    /// What a message says about the allowed values.
    fn expectation(&self) -> String {
        format!("expected {} from {} to {}", self.expected, self.min, self.max)
    }
}

const fn field(name: &'static str, columns: &'static [&'static str], [min, max]: [f64; 2], expected: &'static str) -> Field {
    Field { name, columns, min, max, expected }
}

// Indices in [`FIELDS`] and [`Values`]. M1 is a comet's total absolute magnitude, K1 the magnitudes by which it is fainter at ten times the heliocentric
// distance. Names of columns such as `om`, `w`, `ma` and `tp` are those of JPL's Small-Body Database.
pub(super) const ECCENTRICITY: usize = 0;
pub(super) const INCLINATION: usize = 1;
pub(super) const ASCENDING_NODE: usize = 2;
pub(super) const ARGUMENT_OF_PERIHELION: usize = 3;
pub(super) const SEMI_MAJOR_AXIS: usize = 4;
pub(super) const PERIHELION_DISTANCE: usize = 5;
pub(super) const MEAN_ANOMALY: usize = 6;
pub(super) const EPOCH: usize = 7;
pub(super) const EPOCH_MJD: usize = 8;
pub(super) const PERIHELION_PASSAGE: usize = 9;
pub(super) const ABSOLUTE_MAGNITUDE: usize = 10;
pub(super) const SLOPE: usize = 11;
pub(super) const M1: usize = 12;
pub(super) const K1: usize = 13;
/// The fields in the order of the indices above.
pub(super) const FIELDS: [Field; 14] = [
    field("e", &["e", "eccentricity"], [0.0, 100.0], "an eccentricity"),
    field("i_deg", &["ideg", "i", "incl", "inclination"], [0.0, 180.0], "degrees"),
    field("node_deg", &["nodedeg", "om", "node"], [-360.0, 360.0], "degrees"),
    field("argp_deg", &["argpdeg", "w", "peri", "argp"], [-360.0, 360.0], "degrees"),
    field("a_au", &["aau", "a"], [-1e6, 1e6], "au"),
    field("q_au", &["qau", "q"], [1e-5, 1e4], "au"),
    field("M_deg", &["mdeg", "ma", "m"], [-1e7, 1e7], "degrees"),
    // The ranges of Julian and modified Julian dates do not overlap, so that a date of the wrong kind is reported. Accepted, it would move the epoch by
    // 6,570 years.
    field("epoch_jd", &["epochjd", "epoch"], [1e6, 1e7], "a Julian date (TDB)"),
    field("epoch_mjd", &["epochmjd"], [-1.4e6, 999_999.0], "a modified Julian date (TDB)"),
    field("tp_jd", &["tpjd", "tp"], [1e6, 1e7], "a Julian date (TDB)"),
    field("H", &["h"], [-30.0, 50.0], "magnitudes"),
    field("G", &["g"], [-1.0, 2.0], "a slope"),
    field("M1", &["m1"], [-30.0, 50.0], "magnitudes"),
    field("K1", &["k1"], [-50.0, 100.0], "magnitudes for ten times the distance"),
];

/// The values of one row by field index; `None` where the row has no value.
pub(super) type Values = [Option<f64>; FIELDS.len()];

/// Parses the value of the field with index `k` and checks its range; `None` for an empty text.
pub(super) fn number(k: usize, text: &str) -> Result<Option<f64>, String> {
    let (field, text) = (&FIELDS[k], text.trim());
    if text.is_empty() {
        return Ok(None);
    }
    let value = text.parse::<f64>().ok().filter(|v| (field.min..=field.max).contains(v));
    value.map(Some).ok_or_else(|| format!("{} is `{}`; {}", field.name, echo_within(text, 40), field.expectation()))
}

/// The perihelion distance of an orbit with this semi-major axis, if it is in the range of `q_au`.
fn perihelion_of_axis_au(semi_major_axis_au: f64, eccentricity: f64) -> Result<f64, String> {
    let perihelion_au = semi_major_axis_au * (1.0 - eccentricity);
    let given = || format!("a_au is `{semi_major_axis_au:?}` and e `{eccentricity:?}`");
    let field = &FIELDS[PERIHELION_DISTANCE];
    if (field.min..=field.max).contains(&perihelion_au) {
        Ok(perihelion_au)
    } else if perihelion_au > 0.0 {
        Err(format!("{}, so q_au would be {perihelion_au:?}; {}", given(), field.expectation()))
    } else {
        Err(format!("{}: an ellipse has a above 0 and e below 1, a hyperbola a below 0", given()))
    }
}

/// Builds the body of a row. If a row has both, the perihelion distance is used and not the semi-major axis, the passage and not the mean anomaly, `epoch_jd`
/// and not `epoch_mjd`, M1 and not H.
pub(super) fn body(designation: &str, name: &str, values: &Values) -> Result<SmallBody, String> {
    let required = |k: usize| {
        let field = &FIELDS[k];
        values[k].ok_or_else(|| format!("{} is empty; {}", field.name, field.expectation()))
    };
    let eccentricity = required(ECCENTRICITY)?;
    let (inclination_deg, node_deg, argp_deg) = (required(INCLINATION)?, required(ASCENDING_NODE)?, required(ARGUMENT_OF_PERIHELION)?);
    let perihelion_au = match (values[PERIHELION_DISTANCE], values[SEMI_MAJOR_AXIS]) {
        (Some(q), _) => q,
        (None, Some(a)) => perihelion_of_axis_au(a, eccentricity)?,
        (None, None) => return Err("q_au and a_au are both empty; give one of them".into()),
    };
    let epoch_jd = values[EPOCH].or(values[EPOCH_MJD].map(|d| d + JD_OF_MJD_ZERO));
    // Days from J2000 (TDB). Gauss' constant / a^1.5 is the mean motion in radians per day, a in au.
    let passage_days = match (values[PERIHELION_PASSAGE], values[MEAN_ANOMALY], epoch_jd) {
        (Some(passage_jd), ..) => passage_jd - JD_J2000,
        (None, Some(mean_anomaly_deg), Some(epoch_jd)) if eccentricity != 1.0 => {
            let semi_major_axis_au = perihelion_au / (1.0 - eccentricity).abs();
            let given_rad = mean_anomaly_deg.to_radians();
            // An ellipse has many passages: take the one nearest to the epoch.
            let anomaly_rad = if eccentricity < 1.0 { (given_rad + PI).rem_euclid(TAU) - PI } else { given_rad };
            epoch_jd - JD_J2000 - anomaly_rad / (GAUSS_CONSTANT * semi_major_axis_au.powf(-1.5))
        }
        (None, Some(_), Some(_)) => return Err("a parabola has no mean anomaly; give tp_jd".into()),
        _ => return Err("tp_jd is empty, and so is M_deg or its epoch; give tp_jd, or M_deg with an epoch".into()),
    };
    let brightness = match (values[M1], values[ABSOLUTE_MAGNITUDE]) {
        (Some(m1), _) => BrightnessLaw::Comet { m1, k1: values[K1].unwrap_or(DEFAULT_K1), dust_to_gas: ORDINARY_DUST_TO_GAS },
        (None, Some(h)) => BrightnessLaw::Asteroid { h, g: values[SLOPE].unwrap_or(DEFAULT_G) },
        (None, None) => BrightnessLaw::Unknown,
    };
    let icrf_from_orbit = DMat3::from_rotation_x(OBLIQUITY_RAD)
        * DMat3::from_rotation_z(node_deg.to_radians())
        * DMat3::from_rotation_x(inclination_deg.to_radians())
        * DMat3::from_rotation_z(argp_deg.to_radians());
    let orbit = HeliocentricOrbit {
        perihelion_au,
        eccentricity,
        to_perihelion: icrf_from_orbit * DVec3::X,
        motion_at_perihelion: icrf_from_orbit * DVec3::Y,
        passage_days,
    };
    Ok(SmallBody::of(designation.trim(), name.trim(), orbit, brightness))
}
