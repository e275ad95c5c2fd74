//! Poles and prime meridians from a SPICE text kernel (PCK).
//!
//! In: the text of the kernel. Out: right ascension and declination of the north pole and the angle W of the prime meridian, by the models
//! of Archinal et al. 2018 (IAU WGCCRE 2015), which the kernel transcribes. Of the kernel's `\begindata` blocks, assignments of numbers (`=`, `+=`)
//! are read; strings and dates are ignored. The names of the assignments (`BODY599_POLE_RA`) are those of NAIF's PCK Required Reading.

use crate::catalog::NaifId;
use crate::units::{DAYS_PER_JULIAN_CENTURY, SECONDS_PER_DAY};
use std::collections::HashMap;

/// Why a text kernel was rejected: a number that cannot be parsed, or a body with more sines or cosines than its system has angles.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PckError {
    #[error("PCK line {line}: `{text}` is not a number")]
    NotANumber { line: usize, text: String },
    #[error("PCK: body {body} uses {terms} angles, its system {system} has {angles}")]
    MissingAngles { body: i32, system: i32, terms: usize, angles: usize },
}

/// Pole and prime meridian of one body at one time, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoleAndMeridian {
    /// Right ascension of the north pole, ICRF; not reduced to 0..360.
    pub pole_ra_deg: f64,
    /// Declination of the north pole, ICRF.
    pub pole_dec_deg: f64,
    /// WGCCRE's W, 0..360: the angle along the body's equator, eastwards, from the equator's ascending node on the ICRF equator to the prime meridian.
    pub w_deg: f64,
}

/// One body's model, in degrees: for right ascension and W, a polynomial plus the sum of amplitude times sine of each angle of the planet's system; for
/// declination, with cosines. Coefficients of polynomials start with the constant.
#[derive(Clone, Debug, Default)]
struct Model {
    /// Polynomial in Julian centuries from J2000.
    pole_ra: Vec<f64>,
    /// Polynomial in Julian centuries from J2000.
    pole_dec: Vec<f64>,
    /// Polynomial in days from J2000.
    w: Vec<f64>,
    /// Amplitudes of the sines in the right ascension, in the order of the system's angles.
    pole_ra_terms: Vec<f64>,
    /// Amplitudes of the cosines in the declination, in the same order.
    pole_dec_terms: Vec<f64>,
    /// Amplitudes of the sines in W, in the same order.
    w_terms: Vec<f64>,
}

/// The orientation models of a text kernel.
#[derive(Clone, Debug, Default)]
pub struct Pck {
    /// By NAIF code of the body.
    models: HashMap<i32, Model>,
    /// By code of the planet's system (that of its barycentre, 5 for Jupiter's): for each angle its polynomial in Julian centuries from J2000, degrees.
    angles: HashMap<i32, Vec<Vec<f64>>>,
}

/// Name and numbers of each assignment in the data blocks.
fn assignments(text: &str) -> Result<HashMap<&str, Vec<f64>>, PckError> {
    let mut values: HashMap<&str, Vec<f64>> = HashMap::new();
    let (mut in_data, mut name, mut in_quotes) = (false, "", false);
    for (index, line) in text.lines().enumerate() {
        match line.trim() {
            "\\begindata" => in_data = true,
            "\\begintext" => in_data = false,
            _ => {}
        }
        if !in_data || line.trim().starts_with('\\') {
            continue;
        }
        // The part of the line that holds values: all of it, or what follows the equals sign.
        let mut rest = line;
        if let Some((left, right)) = line.split_once('=') {
            let appends = left.trim_end().ends_with('+');
            name = left.trim().trim_end_matches('+').trim();
            if !appends {
                values.insert(name, Vec::new());
            }
            rest = right;
        }
        for word in rest.split(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | ',')).filter(|w| !w.is_empty()) {
            // Strings, of which a line may hold several words, and dates (`@2000-JAN-1`) are not orientation data.
            let quotes = word.matches('\'').count();
            if in_quotes || quotes > 0 || word.starts_with('@') {
                in_quotes ^= quotes % 2 == 1;
                continue;
            }
            // SPICE also writes exponents as in Fortran: `1.0D0`.
            let number = word.replace(['D', 'd'], "e").parse().map_err(|_| PckError::NotANumber { line: index + 1, text: word.into() })?;
            values.entry(name).or_default().push(number);
        }
    }
    Ok(values)
}

/// The value at `x` of a polynomial whose coefficients are given from the constant upwards.
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Code of the system whose angles a body's terms use: 4 for Mars (499) and Phobos (401), 3 for the Moon (301). For the Sun and small bodies, which have no
/// terms, a number without angles.
fn system_of(body: i32) -> i32 {
    body / 100
}

impl Pck {
    /// Reads a kernel's text.
    pub fn parse(text: &str) -> Result<Self, PckError> {
        let values = assignments(text)?;
        let mut pck = Self::default();
        for (name, numbers) in &values {
            let Some((code, item)) = name.strip_prefix("BODY").and_then(|n| n.split_once('_')) else { continue };
            let Ok(code) = code.parse::<i32>() else { continue };
            if item == "NUT_PREC_ANGLES" {
                // Angles are linear in time unless the kernel gives a degree.
                let degree = values.get(format!("BODY{code}_MAX_PHASE_DEGREE").as_str()).and_then(|v| v.first()).map_or(1, |d| *d as usize);
                pck.angles.insert(code, numbers.chunks(degree.saturating_add(1)).map(<[f64]>::to_vec).collect());
                continue;
            }
            let field: fn(&mut Model) -> &mut Vec<f64> = match item {
                "POLE_RA" => |m| &mut m.pole_ra,
                "POLE_DEC" => |m| &mut m.pole_dec,
                "PM" => |m| &mut m.w,
                "NUT_PREC_RA" => |m| &mut m.pole_ra_terms,
                "NUT_PREC_DEC" => |m| &mut m.pole_dec_terms,
                "NUT_PREC_PM" => |m| &mut m.w_terms,
                _ => continue,
            };
            *field(pck.models.entry(code).or_default()) = numbers.clone();
        }
        // Without one of the three polynomials a body has no orientation.
        pck.models.retain(|_, m| !m.pole_ra.is_empty() && !m.pole_dec.is_empty() && !m.w.is_empty());
        for (body, model) in &pck.models {
            let terms = model.pole_ra_terms.len().max(model.pole_dec_terms.len()).max(model.w_terms.len());
            let system = system_of(*body);
            let angles = pck.angles.get(&system).map_or(0, Vec::len);
            if terms > angles {
                return Err(PckError::MissingAngles { body: *body, system, terms, angles });
            }
        }
        Ok(pck)
    }

    /// Number of bodies with a model.
    pub fn len(&self) -> usize {
        self.models.len()
    }

    pub fn is_empty(&self) -> bool {
        self.models.is_empty()
    }

    /// Pole and prime meridian at TDB seconds past J2000; `None` if the kernel has no complete model of the body.
    pub fn pole_and_meridian(&self, body: NaifId, tdb_s: f64) -> Option<PoleAndMeridian> {
        let model = self.models.get(&body.0)?;
        let days = tdb_s / SECONDS_PER_DAY;
        let centuries = days / DAYS_PER_JULIAN_CENTURY;
        let mut result = PoleAndMeridian {
            pole_ra_deg: polynomial(&model.pole_ra, centuries),
            pole_dec_deg: polynomial(&model.pole_dec, centuries),
            w_deg: polynomial(&model.w, days),
        };
        let none = Vec::new();
        for (k, angle) in self.angles.get(&system_of(body.0)).unwrap_or(&none).iter().enumerate() {
            // Whole turns are removed in degrees, where this is exact.
            let (sin, cos) = (polynomial(angle, centuries) % 360.0).to_radians().sin_cos();
            let term = |terms: &[f64]| terms.get(k).copied().unwrap_or(0.0);
            result.pole_ra_deg += term(&model.pole_ra_terms) * sin;
            result.pole_dec_deg += term(&model.pole_dec_terms) * cos;
            result.w_deg += term(&model.w_terms) * sin;
        }
        result.w_deg = result.w_deg.rem_euclid(360.0);
        Some(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Jupiter, with two angles: 90 degrees, and 36 000 degrees per century. The assignment to Mars is outside the data block.
    const KERNEL: &str = "text BODY499_PM = ( 9 )\n\\begindata\n BODY599_POLE_RA = ( 268.0 -0.01 0. )\n BODY599_POLE_DEC = ( 64.5 )\n\
                          BODY599_PM = ( 284.95 870.536D0 )\n BODY599_LONG_NAME = ( 'a b' )\n\
                          BODY5_NUT_PREC_ANGLES = ( 90.0 0.0\n 0.0 36000.0 )\n\
                          BODY599_NUT_PREC_RA = ( 2.0 )\n BODY599_NUT_PREC_RA += ( 1.0 )\n\\begintext\n";

    #[test]
    fn only_data_blocks_are_read() {
        let pck = Pck::parse(KERNEL).expect("a valid kernel");
        assert_eq!(pck.len(), 1);
        let jupiter = pck.pole_and_meridian(NaifId(599), 0.0).expect("Jupiter");
        assert!((jupiter.pole_ra_deg - 270.0).abs() < 1e-12, "268 + 2 sin(90 deg) + 1 sin(0 deg): {jupiter:?}");
        let a_day_later = pck.pole_and_meridian(NaifId(599), SECONDS_PER_DAY).expect("Jupiter");
        assert!((a_day_later.w_deg - (284.95 + 870.536_f64).rem_euclid(360.0)).abs() < 1e-9);
        assert_eq!(pck.pole_and_meridian(NaifId(499), 0.0), None);
    }

    #[test]
    fn a_broken_number_and_a_missing_angle_are_named() {
        let broken = KERNEL.replace("64.5", "64.x");
        assert_eq!(Pck::parse(&broken).map(|_| ()).map_err(|e| e.to_string()), Err("PCK line 4: `64.x` is not a number".into()));
        let missing = KERNEL.replace("+= ( 1.0 )", "+= ( 1.0 1.0 )");
        assert!(matches!(Pck::parse(&missing), Err(PckError::MissingAngles { body: 599, terms: 3, angles: 2, .. })));
    }
}
