//! Reference for single scattering along a ray through spherical shells: tests/atmosphere/model_bounds.rs compares the shaders with it.
//!
//! In: an atmosphere, a ray, a Sun at infinity. Out: radiance per irradiance (1/sr) and transmittance, in f64. Method: globally adaptive Gauss-Kronrod 7/15 on
//! intervals cut where the integrand or its derivative jumps: the knots of the triangular profile on the ray and on the tangent points of sunlight, the ray's perigee, the
//! edges of the planet's shadow. Column densities: 12-point Gauss-Legendre on shells of 2.5 scale heights, the triangular profile in closed form. No code is shared with the
//! program. Verified against tests/data/rayleigh_reference_public.json by tests/atmosphere/model_bounds.rs. Lengths: planet radii.

use glam::DVec3;

pub enum Profile {
    Exponential {
        scale_height: f64,
    },
    /// Heights of the lower end, the centre and the upper end; linear in between.
    Triangle {
        knots: [f64; 3],
    },
}

pub enum Phase {
    Rayleigh,
    HenyeyGreenstein(f64),
}

/// Coefficients per planet radius, at the ground or at the centre of the triangle.
pub struct Species {
    pub profile: Profile,
    pub scattering: DVec3,
    pub extinction: DVec3,
    pub phase: Phase,
}

pub struct Air {
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

/// 12-point Gauss-Legendre: positive nodes and weights (Abramowitz & Stegun 25.4).
const GAUSS: [(f64, f64); 6] = [
    (0.125_233_408_511_468_92, 0.249_147_045_813_402_78),
    (0.367_831_498_998_180_2, 0.233_492_536_538_354_82),
    (0.587_317_954_286_617_4, 0.203_167_426_723_065_92),
    (0.769_902_674_194_304_7, 0.160_078_328_543_346_23),
    (0.904_117_256_370_474_9, 0.106_939_325_995_318_43),
    (0.981_560_634_246_719_3, 0.047_175_336_386_511_83),
];
/// Kronrod's 15 points (QUADPACK's qk15): node, weight, and the weight of the 7 Gauss points among them.
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

/// Relative tolerance of the entire integral. The error is estimated by the difference of the two rules, which is far larger than the error of Kronrod's.
const RELATIVE_TOLERANCE: f64 = 1e-9;
const MAX_INTERVALS: usize = 600;

fn radius_sq_minus_1(height: f64) -> f64 {
    height * (2.0 + height)
}

/// Height of a point with |p|^2 - 1 = `excess`.
fn height_of(excess: f64) -> f64 {
    excess / (1.0 + (1.0 + excess).sqrt())
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

    /// Column density along a line whose perigee has |p|^2 - 1 = `perigee_excess`, between two distances from the perigee, both at least 0.
    fn column(&self, perigee_excess: f64, from: f64, to: f64) -> f64 {
        if to <= from {
            return 0.0;
        }
        match self {
            Self::Exponential { scale_height } => {
                let (first, last) = (height_of(perigee_excess + from * from), height_of(perigee_excess + to * to));
                let (mut sum, mut start, mut height) = (0.0, from, first);
                // Beyond forty scale heights the density no longer changes the sum in f64.
                while start < to && height < first + 40.0 * scale_height {
                    height += 2.5 * scale_height;
                    let end = if height < last { (radius_sq_minus_1(height) - perigee_excess).max(0.0).sqrt().min(to) } else { to };
                    let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
                    let density_at = |s: f64| (-height_of(perigee_excess + s * s) / scale_height).exp();
                    sum +=
                        half * GAUSS.iter().map(|(x, w)| w * (density_at(middle - half * x) + density_at(middle + half * x))).sum::<f64>();
                    start = end;
                }
                sum
            }
            Self::Triangle { knots } => {
                let knot_distances = knots.map(|h| (radius_sq_minus_1(h) - perigee_excess).max(0.0).sqrt());
                // Antiderivative of the height r - 1 along the line, where r^2 = 1 + perigee_excess + s^2.
                let height_integral = |s: f64| {
                    let r = (1.0 + perigee_excess + s * s).sqrt();
                    // For a line through the centre the second term is 0.
                    let perigee_sq = (1.0 + perigee_excess).max(1e-200);
                    0.5 * (s * r + perigee_sq * ((s + r).ln() - 0.5 * perigee_sq.ln())) - s
                };
                let integrate_interval = |a: f64, b: f64, bottom: f64, width: f64| {
                    let (a, b) = (a.max(from), b.min(to));
                    if b > a { (height_integral(b) - height_integral(a) - bottom * (b - a)) / width } else { 0.0 }
                };
                let [bottom, middle, top] = *knots;
                integrate_interval(knot_distances[0], knot_distances[1], bottom, middle - bottom)
                    + integrate_interval(knot_distances[1], knot_distances[2], top, middle - top)
            }
        }
    }
}

impl Air {
    fn optical_depth(&self, perigee_excess: f64, from: f64, to: f64) -> DVec3 {
        let column_depth =
            |from: f64, to: f64| self.species.iter().map(|s| s.extinction * s.profile.column(perigee_excess, from, to)).sum::<DVec3>();
        if from >= 0.0 {
            column_depth(from, to)
        } else if to <= 0.0 {
            column_depth(-to, -from)
        } else {
            column_depth(0.0, -from) + column_depth(0.0, to)
        }
    }

    /// Optical depth towards the Sun from a point with this |p|^2 - 1; `rise`: dot(p, sun).
    fn depth_to_sun(&self, excess: f64, rise: f64) -> DVec3 {
        let perigee_excess = excess - rise * rise;
        self.optical_depth(perigee_excess, rise, (radius_sq_minus_1(self.top) - perigee_excess).max(0.0).sqrt())
    }

    fn scattered(&self, height: f64, cosine: f64) -> DVec3 {
        use std::f64::consts::PI;
        let phase = |p: &Phase| match p {
            Phase::Rayleigh => 3.0 / (16.0 * PI) * (1.0 + cosine * cosine),
            Phase::HenyeyGreenstein(g) => (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5)),
        };
        self.species.iter().map(|s| s.scattering * (s.profile.density(height) * phase(&s.phase))).sum()
    }

    pub fn evaluate(&self, ray: &Ray) -> RayResult {
        let (direction, sun) = (ray.direction.normalize(), ray.sun.normalize());
        // Distances along the ray count from its perigee.
        let camera_s = ray.camera.dot(direction);
        let perigee = ray.camera - direction * camera_s;
        let camera_excess = (ray.camera.length() - 1.0) * (ray.camera.length() + 1.0);
        let perigee_excess = camera_excess - camera_s * camera_s;
        let top = radius_sq_minus_1(self.top);
        let exit_distance = (top - perigee_excess).max(0.0).sqrt();
        let hits_ground = perigee_excess < 0.0 && camera_s < 0.0;
        let from = camera_s.max(-exit_distance);
        let to = if hits_ground { -(-perigee_excess).sqrt() } else { exit_distance };
        if perigee_excess >= top || to <= from {
            return RayResult { radiance: DVec3::ZERO, transmittance: DVec3::ONE, hits_ground, meets_air: false };
        }
        // The dot product of a point and the Sun's direction is perigee_rise + sun_cosine * s.
        let (perigee_rise, sun_cosine) = (perigee.dot(sun), direction.dot(sun));
        let mut cuts = vec![from, to, 0.0, -perigee_rise / sun_cosine];
        for species in &self.species {
            match species.profile {
                Profile::Triangle { knots } => {
                    for knot in knots.map(radius_sq_minus_1) {
                        cuts.extend([(knot - perigee_excess).sqrt(), -(knot - perigee_excess).sqrt()]);
                        cuts.extend(tangents(perigee_excess - knot, perigee_rise, sun_cosine));
                    }
                }
                // The integrand does not jump here, but a narrow peak must not be missed.
                Profile::Exponential { scale_height } => {
                    for scale_heights in [1.0, 3.0, 6.0, 12.0, 20.0] {
                        let distance = (radius_sq_minus_1(scale_heights * scale_height) - perigee_excess).sqrt();
                        cuts.extend([distance, -distance]);
                    }
                }
            }
        }
        cuts.extend(tangents(perigee_excess, perigee_rise, sun_cosine));
        cuts.retain(|s| s.is_finite() && *s >= from && *s <= to);
        cuts.sort_by(f64::total_cmp);
        let in_scattering = |s: f64| {
            let (excess, rise) = (perigee_excess + s * s, perigee_rise + sun_cosine * s);
            if rise < 0.0 && excess - rise * rise < 0.0 {
                return DVec3::ZERO;
            }
            let depth = self.optical_depth(perigee_excess, from, s) + self.depth_to_sun(excess, rise);
            self.scattered(height_of(excess), sun_cosine) * exp(-depth)
        };
        let radiance = integrate_adaptively(&cuts, in_scattering);
        RayResult { radiance, transmittance: exp(-self.optical_depth(perigee_excess, from, to)), hits_ground, meets_air: true }
    }
}

/// Distances s from the ray's perigee at which sunlight grazes a shell: roots of perigee_excess + s^2 - (perigee_rise + sun_cosine s)^2.
/// `perigee_excess`: |p|^2 - r^2 of the perigee for a shell of radius r.
fn tangents(perigee_excess: f64, perigee_rise: f64, sun_cosine: f64) -> [f64; 2] {
    let (quadratic, half_linear) = (1.0 - sun_cosine * sun_cosine, -perigee_rise * sun_cosine);
    let root = (half_linear * half_linear - quadratic * (perigee_excess - perigee_rise * perigee_rise)).sqrt();
    [(-half_linear - root) / quadratic, (-half_linear + root) / quadratic]
}

struct Interval {
    from: f64,
    to: f64,
    sum: DVec3,
    error: DVec3,
}

fn integrate_interval(from: f64, to: f64, f: &impl Fn(f64) -> DVec3) -> Interval {
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
    let mut intervals: Vec<Interval> = cuts.windows(2).filter(|w| w[1] > w[0]).map(|w| integrate_interval(w[0], w[1], &f)).collect();
    while intervals.len() < MAX_INTERVALS {
        let sum: DVec3 = intervals.iter().map(|p| p.sum).sum();
        let error: DVec3 = intervals.iter().map(|p| p.error).sum();
        // The last digits of a channel that is nearly black relative to the others do not matter.
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
        intervals.extend([integrate_interval(from, middle, &f), integrate_interval(middle, to, &f)]);
    }
    intervals.iter().map(|p| p.sum).sum()
}
