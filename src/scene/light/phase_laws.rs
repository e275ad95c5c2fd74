//! Published phase laws: brightness of the planets' globes, the Moon, Ceres, Vesta, the large moons of Jupiter and Saturn, and the dust of comets as a function
//! of phase angle.
//!
//! In: a body and a phase angle. Out: its brightness relative to zero phase; the brightness at zero phase follows from the catalog's geometric albedo.
//!
//! Source for the planets: Mallama and Hilton 2018, "Computing apparent planetary magnitudes for The Astronomical Almanac", Astronomy and Computing 25, 10-24,
//! the V-band laws without the terms of rotation and without Saturn's rings. Source for the Moon: Allen 1976, Astrophysical Quantities, 3rd ed., section
//! 66: 0.026 a + 4.0e-9 a^4 mag, a in degrees.
//!
//! Ceres and Vesta: the H, G system (Bowell et al. 1989, in Asteroids II) with the slope parameters of `small_bodies.csv`. Galilean moons: the polynomials of
//! the Explanatory Supplement to the Astronomical Almanac. Mimas to Rhea: the mean opposition magnitudes of the Explanatory Supplement. The albedos that the
//! catalog has for these five were measured within some hundredths of a degree of opposition (Verbiscer et al. 2007, Science 315, 815), where a moon is
//! brighter by a *surge*. Here the depth of the surge is the difference between the two; its width is an estimate, and so is the slope beyond it, 0.02
//! magnitudes per degree. Vesta's surge is the difference between its albedo and its H.
//!
//! Dust of comets: Marcus 2007, Int. Comet Quarterly 29, 39 (his numbers also in the Central Bureau's Electronic Telegram 5445); its grains scatter most light
//! forwards.

use crate::catalog::NaifId;
use glam::DVec3;

/// A curve of magnitude by phase angle. Coefficients begin with the constant term.
enum Curve {
    /// A polynomial of the angle in degrees.
    Magnitude(&'static [f64]),
    /// A magnitude, and the factor on its flux: a polynomial of the angle as a fraction of 180 degrees.
    Flux(f64, &'static [f64]),
    /// The law of the H, G system with the slope parameter G; H is left out.
    SlopeParameter(f64),
}

/// Brightness at a phase angle divided by that at 0, by the law of the H, G system with the slope parameter G. `tan_half`: tangent of half the phase angle. The
/// function `phase_law` of shaders/entry/minor_planets.wesl is the same law.
pub fn slope_parameter_law(tan_half: f64, slope: f64) -> f64 {
    let term = |a: f64, b: f64| (-a * tan_half.powf(b)).exp();
    (1.0 - slope) * term(3.33, 0.63) + slope * term(1.87, 1.22)
}

/// Brightness of a comet's dust at a phase angle, divided by that at 90 degrees: two Henyey-Greenstein functions, of light scattered forwards and backwards.
pub(crate) fn comet_dust_law(phase_angle_rad: f64) -> f64 {
    const FORWARD_ASYMMETRY: f64 = 0.9;
    const BACKWARD_ASYMMETRY: f64 = -0.6;
    const FORWARD_SHARE: f64 = 0.95;
    // The scattering angle is the supplement of the phase angle.
    let cosine = -phase_angle_rad.cos();
    let part = |g: f64| ((1.0 + g * g) / (1.0 + g * g - 2.0 * g * cosine)).powf(1.5);
    FORWARD_SHARE * part(FORWARD_ASYMMETRY) + (1.0 - FORWARD_SHARE) * part(BACKWARD_ASYMMETRY)
}

/// Brightness of a comet at a phase angle, divided by that at 90 degrees. Its gas shines equally in all directions. `dust_to_gas`: their light at 90 degrees.
pub(crate) fn comet_law(dust_to_gas: f64, phase_angle_rad: f64) -> f64 {
    (1.0 + dust_to_gas * comet_dust_law(phase_angle_rad)) / (1.0 + dust_to_gas)
}

/// Width of the opposition surge, degrees: it falls to 1/e at this phase angle.
const SURGE_WIDTH_DEG: f64 = 0.15;

impl Curve {
    fn magnitude(&self, alpha_deg: f64) -> f64 {
        let polynomial = |coefficients: &[f64], x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
        match self {
            Self::Magnitude(coefficients) => polynomial(coefficients, alpha_deg),
            Self::Flux(magnitude, coefficients) => magnitude - 2.5 * polynomial(coefficients, alpha_deg / 180.0).log10(),
            Self::SlopeParameter(g) => slope_parameter_magnitude(*g, alpha_deg),
        }
    }
}

/// Magnitudes by which a body of the H, G system is fainter than at zero phase. Not finite where the law gives no light, near 180 degrees.
pub(crate) fn slope_parameter_magnitude(g: f64, alpha_deg: f64) -> f64 {
    -2.5 * slope_parameter_law((0.5 * alpha_deg).to_radians().tan(), g).log10()
}

/// Magnitude as a function of phase angle.
pub(crate) struct PhaseLaw {
    /// Each curve with the largest angle to which it applies, degrees; in ascending order.
    pieces: &'static [(f64, Curve)],
    /// Largest phase angle to which the law was fitted, degrees.
    pub limit_deg: f64,
    /// Direction from which the body was measured, body axes, if it always shows this side. The laws of the others are means over their rotation.
    pub measured_side: Option<DVec3>,
    /// Depth of the opposition surge, which is added to `pieces`, magnitudes; 0: none.
    surge_mag: f64,
}

impl PhaseLaw {
    /// Brightness relative to zero phase. `alpha_deg`: phase angle, 0..=`limit_deg`.
    pub(crate) fn brightness(&self, alpha_deg: f64) -> f64 {
        10f64.powf(-0.4 * (self.magnitude(alpha_deg) - self.magnitude(0.0)))
    }

    fn magnitude(&self, alpha_deg: f64) -> f64 {
        let piece = self.pieces.iter().find(|(up_to, _)| alpha_deg <= *up_to).or(self.pieces.last());
        let surge = self.surge_mag * (1.0 - (-alpha_deg / SURGE_WIDTH_DEG).exp());
        piece.map_or(0.0, |(_, curve)| curve.magnitude(alpha_deg)) + surge
    }
}

use Curve::{Flux, Magnitude, SlopeParameter};

/// A law of one curve, a mean over the body's rotation.
const fn single(pieces: &'static [(f64, Curve)], limit_deg: f64, surge_mag: f64) -> PhaseLaw {
    PhaseLaw { pieces, limit_deg, measured_side: None, surge_mag }
}

const MERCURY: PhaseLaw = PhaseLaw {
    pieces: &[(170.0, Magnitude(&[-0.613, 6.3280e-2, -1.6336e-3, 3.3644e-5, -3.4265e-7, 1.6893e-9, -3.0334e-12]))],
    limit_deg: 170.0,
    measured_side: None,
    surge_mag: 0.0,
};
const VENUS: PhaseLaw = PhaseLaw {
    pieces: &[
        (163.7, Magnitude(&[-4.384, -1.044e-3, 3.687e-4, -2.814e-6, 8.938e-9])),
        (179.0, Magnitude(&[236.05828, -2.81914, 8.39034e-3])),
    ],
    limit_deg: 179.0,
    measured_side: None,
    surge_mag: 0.0,
};
const EARTH: PhaseLaw = single(&[(170.0, Magnitude(&[-3.99, -1.060e-3, 2.054e-4]))], 170.0, 0.0);
const MOON: PhaseLaw = PhaseLaw {
    pieces: &[(150.0, Magnitude(&[0.0, 0.026, 0.0, 0.0, 4.0e-9]))],
    limit_deg: 150.0,
    measured_side: Some(DVec3::X),
    surge_mag: 0.0,
};
const MARS: PhaseLaw = PhaseLaw {
    pieces: &[(50.0, Magnitude(&[-1.601, 2.267e-2, -1.302e-4])), (120.0, Magnitude(&[-0.367, -2.573e-2, 3.445e-4]))],
    limit_deg: 120.0,
    measured_side: None,
    surge_mag: 0.0,
};
const JUPITER: PhaseLaw = PhaseLaw {
    pieces: &[(12.0, Magnitude(&[-9.395, -3.7e-4, 6.16e-4])), (130.0, Flux(-9.428, &[1.0, -1.507, -0.363, -0.062, 2.809, -1.876]))],
    limit_deg: 130.0,
    measured_side: None,
    surge_mag: 0.0,
};
const SATURN: PhaseLaw = PhaseLaw {
    pieces: &[(6.5, Magnitude(&[-8.95, -3.7e-4, 6.16e-4])), (150.0, Magnitude(&[-8.94, 2.446e-4, 2.672e-4, -1.506e-6, 4.767e-9]))],
    limit_deg: 150.0,
    measured_side: None,
    surge_mag: 0.0,
};
const URANUS: PhaseLaw = single(&[(154.0, Magnitude(&[-7.110, 6.587e-3, 1.045e-4]))], 154.0, 0.0);
const NEPTUNE: PhaseLaw = single(&[(133.0, Magnitude(&[-7.00, 7.944e-3, 9.617e-5]))], 133.0, 0.0);
/// The H, G system is meant for phase angles up to 120 degrees.
const CERES: PhaseLaw = single(&[(120.0, SlopeParameter(0.12))], 120.0, 0.0);
const VESTA: PhaseLaw = single(&[(120.0, SlopeParameter(0.32))], 120.0, 0.19);
// Measured from the Earth, which sees phase angles up to 12 degrees.
const IO: PhaseLaw = single(&[(12.0, Magnitude(&[-1.68, 0.046, -0.0010]))], 12.0, 0.0);
const EUROPA: PhaseLaw = single(&[(12.0, Magnitude(&[-1.41, 0.0312, -0.00125]))], 12.0, 0.0);
const GANYMEDE: PhaseLaw = single(&[(12.0, Magnitude(&[-2.09, 0.0323, -0.00066]))], 12.0, 0.0);
const CALLISTO: PhaseLaw = single(&[(12.0, Magnitude(&[-1.05, 0.078, -0.00274]))], 12.0, 0.0);
/// Magnitudes per degree of Saturn's icy moons: up to 6.4 degrees as seen from the Earth.
const ICY_SLOPE: &[(f64, Curve)] = &[(6.4, Magnitude(&[0.0, 0.02]))];
const MIMAS: PhaseLaw = single(ICY_SLOPE, 6.4, 0.68);
const ENCELADUS: PhaseLaw = single(ICY_SLOPE, 6.4, 0.39);
const TETHYS: PhaseLaw = single(ICY_SLOPE, 6.4, 0.385);
const DIONE: PhaseLaw = single(ICY_SLOPE, 6.4, 0.475);
const RHEA: PhaseLaw = single(ICY_SLOPE, 6.4, 0.39);

/// The published law of a body; `None` if there is none.
pub(crate) fn law(body: NaifId) -> Option<&'static PhaseLaw> {
    match body.0 {
        199 => Some(&MERCURY),
        299 => Some(&VENUS),
        399 => Some(&EARTH),
        301 => Some(&MOON),
        499 => Some(&MARS),
        599 => Some(&JUPITER),
        699 => Some(&SATURN),
        799 => Some(&URANUS),
        899 => Some(&NEPTUNE),
        2_000_001 => Some(&CERES),
        2_000_004 => Some(&VESTA),
        501 => Some(&IO),
        502 => Some(&EUROPA),
        503 => Some(&GANYMEDE),
        504 => Some(&CALLISTO),
        601 => Some(&MIMAS),
        602 => Some(&ENCELADUS),
        603 => Some(&TETHYS),
        604 => Some(&DIONE),
        605 => Some(&RHEA),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Body, Catalog};
    use crate::scene::light::photometry::irradiance_of_magnitude;
    use crate::units::KM_PER_AU;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn pieces_join_within_a_tenth_of_a_magnitude() {
        for id in [299, 499, 599, 699] {
            let law = law(NaifId(id)).expect("has a law");
            for pair in law.pieces.windows(2) {
                let boundary_deg = pair[0].0;
                let step = law.magnitude(boundary_deg) - law.magnitude(boundary_deg + 1e-6);
                assert!(step.abs() < 0.1, "{id} jumps by {step} mag at {boundary_deg} degrees");
            }
        }
    }

    #[test]
    fn brightness_is_one_at_full_phase_and_less_at_quadrature() {
        for id in [199, 299, 399, 301, 499, 599, 699, 799, 899] {
            let law = law(NaifId(id)).expect("has a law");
            assert!((law.brightness(0.0) - 1.0).abs() < 1e-12);
            assert!((0.05..0.6).contains(&law.brightness(90.0)), "{id}: {}", law.brightness(90.0));
        }
    }

    #[test]
    fn laws_of_small_bodies_and_moons_fall_with_the_phase_angle() {
        for id in [501, 502, 503, 504, 601, 602, 603, 604, 605, 2_000_001, 2_000_004] {
            let law = law(NaifId(id)).expect("has a law");
            assert!((law.brightness(0.0) - 1.0).abs() < 1e-12);
            let steps: Vec<f64> = (0..=100).map(|k| law.brightness(law.limit_deg * f64::from(k) / 100.0)).collect();
            assert!(steps.windows(2).all(|pair| pair[1] < pair[0]), "{id}: {steps:?}");
        }
    }

    /// Geometric albedos by the magnitude at 1 au from Sun and viewer at zero phase: V(1,0) of the laws; H of the table of minor planets, brightened by the
    /// surge. The outline is the mean over a rotation, from above the equator. Without Mercury, whose law is extrapolated to zero phase along a steep slope (9
    /// %), and without Pluto, whose H in the table (10 % less light than by the albedo) has no slope parameter.
    #[test]
    fn albedos_are_those_of_the_absolute_magnitudes() {
        const TOLERANCE: f64 = 0.05;
        let catalog = Catalog::embedded();
        let albedo_of = |body: &Body, magnitude_at_zero_phase: f64| {
            let outline_radius_sq_km2 = 0.5 * (body.radii_km.x + body.radii_km.y) * body.radii_km.z;
            irradiance_of_magnitude(magnitude_at_zero_phase) * KM_PER_AU.powi(2) / outline_radius_sq_km2
        };
        let body_and_law = |id: i32| (catalog.body(NaifId(id)).expect("in the catalog"), law(NaifId(id)).expect("has a law"));
        let mut laws: Vec<(&Body, f64)> = [299, 399, 499, 599, 699, 799, 899, 501, 502, 503, 504]
            .map(|id| {
                let (body, law) = body_and_law(id);
                (body, law.magnitude(0.0))
            })
            .to_vec();
        for (id, name) in [(2_000_001, "Ceres"), (2_000_004, "Vesta")] {
            let mut rows = orrery_catalogs::SMALL_BODIES.lines().map(|line| line.split(',').collect::<Vec<&str>>());
            let row = rows.find(|row| row.get(1) == Some(&name)).expect("in the table");
            let (body, law) = body_and_law(id);
            laws.push((body, row[2].parse::<f64>().expect("an absolute magnitude") - law.surge_mag));
        }
        for (body, magnitude) in laws {
            let (published, by_magnitude) = (body.geometric_albedo, albedo_of(body, magnitude));
            println!("{}: {published}, by its magnitude {by_magnitude:.4}", body.name);
            assert!((published / by_magnitude - 1.0).abs() < TOLERANCE, "{}: {published}, by its magnitude {by_magnitude}", body.name);
        }
        // The albedo of 0.17 that JPL Horizons has for Callisto does not belong to its magnitude.
        let (callisto, law) = body_and_law(504);
        assert!((0.17 / albedo_of(callisto, law.magnitude(0.0)) - 1.0).abs() > 2.0 * TOLERANCE);
    }

    #[test]
    fn slope_parameters_are_those_of_the_table_of_minor_planets() {
        for (id, name) in [(2_000_001, "Ceres"), (2_000_004, "Vesta")] {
            let mut rows = orrery_catalogs::SMALL_BODIES.lines().map(|line| line.split(',').collect::<Vec<&str>>());
            let row = rows.find(|row| row.get(1) == Some(&name)).expect("in the table");
            let slope: f64 = row[3].parse().expect("a slope parameter");
            let law = law(NaifId(id)).expect("has a law");
            assert!(matches!(law.pieces, [(_, SlopeParameter(g))] if *g == slope), "{name}: {slope}");
        }
    }

    #[test]
    fn a_half_moon_is_an_eleventh_of_a_full_one() {
        // Allen 1976: phase 90 degrees is 2.60 mag fainter than full, a factor of 10.96.
        let factor = 1.0 / law(NaifId::MOON).expect("has a law").brightness(90.0);
        assert!((10.9..11.1).contains(&factor), "{factor}");
    }

    /// Marcus' predictions for the dusty comet C/2023 A3 in October 2024 (Central Bureau's Electronic Telegram 5445): scattering angle, magnitudes.
    #[test]
    fn dust_of_comets_scatters_forwards() {
        let dusty = 10.0;
        for (scattering_deg, published_mag) in [(79.5, -0.3), (58.7, -1.1), (36.7, -2.5), (21.4, -4.1), (7.0, -6.9), (46.8, -1.7)] {
            let found_mag = -2.5 * comet_law(dusty, f64::to_radians(180.0 - scattering_deg)).log10();
            assert!((found_mag - published_mag).abs() < 0.06, "{scattering_deg} degrees: {found_mag}, not {published_mag}");
        }
        assert!((comet_law(0.5, FRAC_PI_2) - 1.0).abs() < 1e-12 && (comet_law(0.0, 3.0) - 1.0).abs() < 1e-12);
    }
}
