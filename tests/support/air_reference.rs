//! Reference for single scattering along a ray through spherical shells: tests/atmosphere/model_bounds.rs compares the shaders with it.
//!
//! In: an atmosphere, a ray, a Sun at infinity. Out: radiance per irradiance (1/sr) and transmittance, in f64. Method: globally adaptive Gauss-Kronrod 7/15 on
//! intervals cut where the integrand or its derivative jumps: where the ray crosses the shell of a knot of the triangular profile, and where the sunlight
//! that reaches it grazes such a shell or the ground (the edge of the planet's shadow); also at the ray's point closest to the planet's centre. Column
//! densities: 12-point Gauss-Legendre on shells of 2.5 scale heights for the exponential profile, in closed form for the triangular one. No code is
//! shared with the program. tests/atmosphere/model_bounds.rs also verifies this reference against tests/data/rayleigh_reference_public.json. Lengths are
//! in planet radii; a point p is relative to the planet's centre. `radius_sq_minus_1`: |p|^2 - 1, which keeps its digits near the ground. `sunward`:
//! dot(p, direction of the Sun).

use super::photons::per_steradian;
use glam::DVec3;
use orrery::catalog::PhaseFunction;

pub enum Profile {
    Exponential {
        scale_height: f64,
    },
    /// Heights of the lower end, the centre and the upper end. The density is 0 at the ends, 1 at the centre, and linear in between.
    Triangle {
        knots: [f64; 3],
    },
}

/// Coefficients per planet radius: at the ground for an exponential profile, at the centre of a triangular one.
pub struct Species {
    pub profile: Profile,
    pub scattering: DVec3,
    pub extinction: DVec3,
    pub phase: PhaseFunction,
}

pub struct Air {
    /// Height of the top.
    pub top: f64,
    pub species: Vec<Species>,
}

#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub camera: DVec3,
    pub direction: DVec3,
    /// Direction of the Sun.
    pub sun: DVec3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayResult {
    pub radiance: DVec3,
    pub transmittance: DVec3,
    pub hits_ground: bool,
    /// Whether the ray meets the atmosphere.
    pub meets_air: bool,
}

/// 12-point Gauss-Legendre: the positive nodes and their weights (Abramowitz & Stegun 25.4).
const GAUSS: [(f64, f64); 6] = [
    (0.125_233_408_511_468_92, 0.249_147_045_813_402_78),
    (0.367_831_498_998_180_2, 0.233_492_536_538_354_82),
    (0.587_317_954_286_617_4, 0.203_167_426_723_065_92),
    (0.769_902_674_194_304_7, 0.160_078_328_543_346_23),
    (0.904_117_256_370_474_9, 0.106_939_325_995_318_43),
    (0.981_560_634_246_719_3, 0.047_175_336_386_511_83),
];
/// Kronrod's 15 points (QUADPACK's qk15), those at 0 or above from the outermost inwards: node, weight, and the weight of the 7 Gauss points among
/// them.
const KRONROD: [(f64, f64, f64); 8] = [
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_55, 0.129_484_966_168_869_7),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (0.741_531_185_599_394_4, 0.140_653_259_715_525_92, 0.279_705_391_489_276_64),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_93),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (0.0, 0.209_482_141_084_727_83, 0.417_959_183_673_469_4),
];

/// Relative tolerance of the entire integral. The difference of the two rules serves as the error, and greatly overestimates that of Kronrod's rule.
const RELATIVE_TOLERANCE: f64 = 1e-9;
/// Ends a bisection in which rounding exceeds the tolerance; the result then has the accuracy reached so far.
const MAX_INTERVALS: usize = 600;

/// |p|^2 - 1 at a height.
fn radius_sq_minus_1_of(height: f64) -> f64 {
    height * (2.0 + height)
}

/// Height of a point, given |p|^2 - 1.
fn height_of(radius_sq_minus_1: f64) -> f64 {
    radius_sq_minus_1 / (1.0 + (1.0 + radius_sq_minus_1).sqrt())
}

fn exp(v: DVec3) -> DVec3 {
    DVec3::new(v.x.exp(), v.y.exp(), v.z.exp())
}

impl Profile {
    fn density(&self, height: f64) -> f64 {
        match self {
            Self::Exponential { scale_height } => (-height / scale_height).exp(),
            Self::Triangle { knots: [bottom, middle, top] } => {
                ((height - bottom) / (middle - bottom)).min((top - height) / (top - middle)).max(0.0)
            }
        }
    }

    /// Column density along a line, between two distances from its point closest to the centre, both at least 0. `closest_radius_sq_minus_1`: of that
    /// point.
    fn column(&self, closest_radius_sq_minus_1: f64, from: f64, to: f64) -> f64 {
        if to <= from {
            return 0.0;
        }
        match self {
            Self::Exponential { scale_height } => {
                let (first, last) = (height_of(closest_radius_sq_minus_1 + from * from), height_of(closest_radius_sq_minus_1 + to * to));
                let (mut sum, mut start, mut height) = (0.0, from, first);
                // Beyond forty scale heights the density no longer changes the sum in f64.
                while start < to && height < first + 40.0 * scale_height {
                    height += 2.5 * scale_height;
                    let end =
                        if height < last { (radius_sq_minus_1_of(height) - closest_radius_sq_minus_1).max(0.0).sqrt().min(to) } else { to };
                    let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
                    let density_at = |s: f64| (-height_of(closest_radius_sq_minus_1 + s * s) / scale_height).exp();
                    sum +=
                        half * GAUSS.iter().map(|(x, w)| w * (density_at(middle - half * x) + density_at(middle + half * x))).sum::<f64>();
                    start = end;
                }
                sum
            }
            Self::Triangle { knots } => {
                let knot_distances = knots.map(|h| (radius_sq_minus_1_of(h) - closest_radius_sq_minus_1).max(0.0).sqrt());
                // Antiderivative of the height r - 1 along the line, where r^2 = 1 + closest_radius_sq_minus_1 + s^2.
                let height_integral = |s: f64| {
                    let r = (1.0 + closest_radius_sq_minus_1 + s * s).sqrt();
                    // At least 1e-200, for a line through the centre, where the term with the logarithm is 0.
                    let closest_radius_sq = (1.0 + closest_radius_sq_minus_1).max(1e-200);
                    0.5 * (s * r + closest_radius_sq * ((s + r).ln() - 0.5 * closest_radius_sq.ln())) - s
                };
                // A flank of the triangle: density (height - zero_height) / height_to_peak.
                let column_of_flank = |a: f64, b: f64, zero_height: f64, height_to_peak: f64| {
                    let (a, b) = (a.max(from), b.min(to));
                    if b > a { (height_integral(b) - height_integral(a) - zero_height * (b - a)) / height_to_peak } else { 0.0 }
                };
                let [bottom, middle, top] = *knots;
                column_of_flank(knot_distances[0], knot_distances[1], bottom, middle - bottom)
                    + column_of_flank(knot_distances[1], knot_distances[2], top, middle - top)
            }
        }
    }
}

impl Air {
    /// Optical depth along a line, between two distances from its point closest to the centre; distances before that point are negative.
    fn optical_depth(&self, closest_radius_sq_minus_1: f64, from: f64, to: f64) -> DVec3 {
        let half_line_depth = |from: f64, to: f64| {
            self.species.iter().map(|s| s.extinction * s.profile.column(closest_radius_sq_minus_1, from, to)).sum::<DVec3>()
        };
        if from >= 0.0 {
            half_line_depth(from, to)
        } else if to <= 0.0 {
            half_line_depth(-to, -from)
        } else {
            half_line_depth(0.0, -from) + half_line_depth(0.0, to)
        }
    }

    /// Optical depth from a point towards the Sun. The line's closest point is `sunward` behind it.
    fn depth_to_sun(&self, radius_sq_minus_1: f64, sunward: f64) -> DVec3 {
        let closest_radius_sq_minus_1 = radius_sq_minus_1 - sunward * sunward;
        self.optical_depth(closest_radius_sq_minus_1, sunward, (radius_sq_minus_1_of(self.top) - closest_radius_sq_minus_1).max(0.0).sqrt())
    }

    /// Scattering coefficient times phase function, per planet radius and steradian. `cosine`: of the angle between ray and direction of the Sun.
    fn scattering_towards(&self, height: f64, cosine: f64) -> DVec3 {
        let phase = |s: &Species| DVec3::from_array([0, 1, 2].map(|channel| per_steradian(s.phase, channel, cosine)));
        self.species.iter().map(|s| s.scattering * phase(s) * s.profile.density(height)).sum()
    }

    /// Light scattered once into the ray, and the air's transmittance along it, from the camera to the ground or to the top of the air.
    pub fn evaluate(&self, ray: &Ray) -> RayResult {
        let (direction, sun) = (ray.direction.normalize(), ray.sun.normalize());
        // Distances along the ray count from its point closest to the centre.
        let camera_s = ray.camera.dot(direction);
        let closest = ray.camera - direction * camera_s;
        let camera_radius_sq_minus_1 = (ray.camera.length() - 1.0) * (ray.camera.length() + 1.0);
        let closest_radius_sq_minus_1 = camera_radius_sq_minus_1 - camera_s * camera_s;
        let top_radius_sq_minus_1 = radius_sq_minus_1_of(self.top);
        let exit_distance = (top_radius_sq_minus_1 - closest_radius_sq_minus_1).max(0.0).sqrt();
        let hits_ground = closest_radius_sq_minus_1 < 0.0 && camera_s < 0.0;
        let from = camera_s.max(-exit_distance);
        let to = if hits_ground { -(-closest_radius_sq_minus_1).sqrt() } else { exit_distance };
        if closest_radius_sq_minus_1 >= top_radius_sq_minus_1 || to <= from {
            return RayResult { radiance: DVec3::ZERO, transmittance: DVec3::ONE, hits_ground, meets_air: false };
        }
        // At the last of these cuts `sunward`, closest_sunward + sun_cosine * s, is 0: the Sun is at the horizon. Nothing jumps there.
        let (closest_sunward, sun_cosine) = (closest.dot(sun), direction.dot(sun));
        let mut cuts = vec![from, to, 0.0, -closest_sunward / sun_cosine];
        for species in &self.species {
            match species.profile {
                Profile::Triangle { knots } => {
                    for knot_radius_sq_minus_1 in knots.map(radius_sq_minus_1_of) {
                        let distance = (knot_radius_sq_minus_1 - closest_radius_sq_minus_1).sqrt();
                        cuts.extend([distance, -distance]);
                        cuts.extend(tangents(closest_radius_sq_minus_1 - knot_radius_sq_minus_1, closest_sunward, sun_cosine));
                    }
                }
                // The integrand does not jump here, but a narrow peak must not be missed.
                Profile::Exponential { scale_height } => {
                    for scale_heights in [1.0, 3.0, 6.0, 12.0, 20.0] {
                        let distance = (radius_sq_minus_1_of(scale_heights * scale_height) - closest_radius_sq_minus_1).sqrt();
                        cuts.extend([distance, -distance]);
                    }
                }
            }
        }
        cuts.extend(tangents(closest_radius_sq_minus_1, closest_sunward, sun_cosine));
        cuts.retain(|s| s.is_finite() && *s >= from && *s <= to);
        cuts.sort_by(f64::total_cmp);
        // Light scattered towards the camera per unit of length, dimmed on both ways.
        let in_scattering = |s: f64| {
            let (radius_sq_minus_1, sunward) = (closest_radius_sq_minus_1 + s * s, closest_sunward + sun_cosine * s);
            if sunward < 0.0 && radius_sq_minus_1 - sunward * sunward < 0.0 {
                return DVec3::ZERO;
            }
            let optical_depth = self.optical_depth(closest_radius_sq_minus_1, from, s) + self.depth_to_sun(radius_sq_minus_1, sunward);
            self.scattering_towards(height_of(radius_sq_minus_1), sun_cosine) * exp(-optical_depth)
        };
        let radiance = integrate_adaptively(&cuts, in_scattering);
        RayResult { radiance, transmittance: exp(-self.optical_depth(closest_radius_sq_minus_1, from, to)), hits_ground, meets_air: true }
    }
}

/// Distances s from the ray's closest point at which sunlight grazes a shell: roots of closest_sq_minus_shell_sq + s^2 - (closest_sunward + sun_cosine s)^2.
/// `closest_sq_minus_shell_sq`: |p|^2 - r^2 of the closest point for a shell of radius r.
fn tangents(closest_sq_minus_shell_sq: f64, closest_sunward: f64, sun_cosine: f64) -> [f64; 2] {
    let (quadratic, half_linear) = (1.0 - sun_cosine * sun_cosine, -closest_sunward * sun_cosine);
    let root = (half_linear * half_linear - quadratic * (closest_sq_minus_shell_sq - closest_sunward * closest_sunward)).sqrt();
    [(-half_linear - root) / quadratic, (-half_linear + root) / quadratic]
}

/// A part of the ray with the integral over it by Kronrod's rule, and its error.
struct Interval {
    from: f64,
    to: f64,
    sum: DVec3,
    error: DVec3,
}

fn gauss_kronrod(from: f64, to: f64, f: &impl Fn(f64) -> DVec3) -> Interval {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let (mut kronrod, mut gauss) = (DVec3::ZERO, DVec3::ZERO);
    for (x, w, g) in KRONROD {
        let value = if x == 0.0 { f(middle) } else { f(middle - half * x) + f(middle + half * x) };
        kronrod += value * w;
        gauss += value * g;
    }
    Interval { from, to, sum: kronrod * half, error: ((kronrod - gauss) * half).abs() }
}

/// Bisects the interval with the largest difference until the sum of the differences is small in each channel.
fn integrate_adaptively(cuts: &[f64], f: impl Fn(f64) -> DVec3) -> DVec3 {
    let mut intervals: Vec<Interval> = cuts.windows(2).filter(|w| w[1] > w[0]).map(|w| gauss_kronrod(w[0], w[1], &f)).collect();
    while intervals.len() < MAX_INTERVALS {
        let sum: DVec3 = intervals.iter().map(|p| p.sum).sum();
        let error: DVec3 = intervals.iter().map(|p| p.error).sum();
        // A channel under 1e-7 of the brightest need not be as accurate as the others.
        let allowed = sum.max(DVec3::splat(1e-7 * sum.max_element())) * RELATIVE_TOLERANCE;
        if error.cmple(allowed).all() {
            break;
        }
        let relative_error = |p: &Interval| (p.error / allowed.max(DVec3::splat(1e-300))).max_element();
        let Some(worst) = (0..intervals.len()).max_by(|i, j| relative_error(&intervals[*i]).total_cmp(&relative_error(&intervals[*j])))
        else {
            break;
        };
        let Interval { from, to, .. } = intervals.swap_remove(worst);
        let middle = 0.5 * (from + to);
        intervals.extend([gauss_kronrod(from, middle, &f), gauss_kronrod(middle, to, &f)]);
    }
    intervals.iter().map(|p| p.sum).sum()
}
