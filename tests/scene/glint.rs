//! Light that the sea mirrors as the shader computes it: of the Sun no more leaves than arrives, and the width of the glint follows from the slopes of the
//! waves; of the sky the waves mirror the mean of Fresnel's formulas.

use orrery::render::software::exec::{Executor, LANES, LaneMask, NoTextures};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::lower::lower;
use orrery::render::software::program::LaneInput;

/// A call of a function of lib/glint.wesl, evaluated for many inputs of four numbers each.
struct GlintFunction {
    program: orrery::render::software::program::Program,
}

impl GlintFunction {
    fn new(call: &str) -> Self {
        let main = format!("@fragment fn main(@location(0) p: vec4f) -> @location(0) vec4f {{ return vec4f({call}, 0.0, 0.0, 0.0); }}");
        let wgsl = [include_str!("../../shaders/lib/glint.wesl"), &main].concat();
        let module = naga::front::wgsl::parse_str(&wgsl).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&wgsl)));
        let flags = naga::valid::ValidationFlags::all();
        let info = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty()).validate(&module).expect("valid");
        Self { program: lower(&module, &info, "main").expect("lowers") }
    }

    fn run(&self, points: &[[f64; 4]]) -> Vec<f64> {
        let mut executor = Executor::<f64>::with_class(&self.program, KernelClass::Portable).expect("binds");
        let prepared = self.program.run_draw_tape::<f64>(&[], KernelClass::Portable, &NoTextures);
        let mut out = Vec::with_capacity(points.len());
        for chunk in points.chunks(LANES) {
            for (k, input) in self.program.inputs.iter().enumerate() {
                let LaneInput::Location { component, .. } = input else { panic!("{input:?}") };
                for (value, point) in executor.input_mut(k).iter_mut().zip(chunk) {
                    *value = point[*component as usize];
                }
            }
            executor.run(&prepared, LaneMask::MAX, &NoTextures);
            out.extend_from_slice(&executor.output(0)[..chunk.len()]);
        }
        out
    }
}

fn lobe() -> GlintFunction {
    GlintFunction::new("glint_lobe(glint_exponent(p.x, p.w), p.x, p.y, p.z, p.w)")
}

/// Arguments of [`lobe`] for a Sun at this incidence and for directions to the viewer that are evenly distributed over the hemisphere.
fn hemisphere(incidence_deg: f64, slope_sq: f64) -> Vec<[f64; 4]> {
    let (heights, around) = (300, 180);
    let (sin_sun, cos_sun) = incidence_deg.to_radians().sin_cos();
    let sun = glam::DVec3::new(sin_sun, 0.0, cos_sun);
    let arguments = |k: usize| {
        let mu = (f64::from((k / around) as u32) + 0.5) / f64::from(heights);
        let azimuth = (f64::from((k % around) as u32) + 0.5) / around as f64 * std::f64::consts::TAU;
        let horizontal = (1.0 - mu * mu).sqrt();
        let facet_normal = (glam::DVec3::new(horizontal * azimuth.cos(), horizontal * azimuth.sin(), mu) + sun).normalize();
        [facet_normal.z, cos_sun, mu, slope_sq]
    };
    (0..heights as usize * around).map(arguments).collect()
}

/// Ratio of reflected to arriving light for facets that are perfect mirrors.
fn reflected_fraction(points: &[[f64; 4]], lobe: &[f64]) -> f64 {
    let mean = points.iter().zip(lobe).map(|(p, l)| l * p[2] / p[1]).sum::<f64>() / points.len() as f64;
    2.0 * mean
}

#[test]
fn waves_reflect_nearly_all_light_and_never_more() {
    let fragment = lobe();
    // Winds of 1 and 5 m/s, and one beyond Cox and Munk's limit of 14 m/s. Light reflected twice is neglected: about a tenth at most
    // up to 75 degrees of incidence, a fifth at 85.
    for slope_sq in [0.008, 0.0286, 0.1] {
        for incidence_deg in [0.0, 30.0, 60.0, 75.0, 85.0] {
            let points = hemisphere(incidence_deg, slope_sq);
            let fraction = reflected_fraction(&points, &fragment.run(&points));
            println!("slope² {slope_sq}, {incidence_deg} deg: {fraction:.4}");
            let min = if incidence_deg > 80.0 { 0.79 } else { 0.89 };
            assert!((min..1.005).contains(&fraction), "slope² {slope_sq}, {incidence_deg} deg: {fraction}");
        }
    }
    // Without the shadowing term more light would leave than arrives.
    let points = hemisphere(85.0, 0.0286);
    let without_shadowing = |p: &[f64; 4]| ((1.0 - 1.0 / (p[0] * p[0])) / p[3]).exp() / (p[3] * p[0].powi(4)) / (4.0 * p[2]);
    assert!(reflected_fraction(&points, &points.iter().map(without_shadowing).collect::<Vec<_>>()) > 1.05);
}

/// Cox and Munk 1954: the probability of a facet's slope falls with exp(-tan² / slope²): to half at tan² = slope² ln 2.
#[test]
fn the_glint_is_as_wide_as_the_slopes() {
    let slope_sq = 0.003 + 0.005_12 * 5.0;
    let facing = |tan_sq: f64| {
        let cos_half = (1.0 / (1.0 + tan_sq)).sqrt();
        // The camera is in the Sun's direction, at most 10 degrees off the normal, so no facet is hidden.
        // The lobe times this power is proportional to the probability density of the slope.
        lobe().run(&[[cos_half, cos_half, cos_half, slope_sq]])[0] * cos_half.powi(5)
    };
    let (peak, half, quarter) = (facing(0.0), facing(slope_sq * std::f64::consts::LN_2), facing(2.0 * slope_sq * std::f64::consts::LN_2));
    assert!((peak * 4.0 * slope_sq - 1.0).abs() < 1e-6, "{peak}");
    assert!((half / peak - 0.5).abs() < 0.005 && (quarter / peak - 0.25).abs() < 0.005, "{half} {quarter} of {peak}");
}

/// Fresnel's reflectance of water for unpolarised light. `cos`: of the angle of incidence.
pub(super) fn fresnel(cos: f64) -> f64 {
    let n = 1.333;
    let cos_refracted = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let (s, p) = ((cos - n * cos_refracted) / (cos + n * cos_refracted), (cos_refracted - n * cos) / (cos_refracted + n * cos));
    0.5 * (s * s + p * p)
}

/// Mean of [`fresnel`] over the facets of a sea that a viewer at this altitude sees: slopes are Gaussian, and each facet counts with the area that it turns to
/// the viewer.
fn mean_fresnel(altitude_deg: f64, slope_sq: f64) -> f64 {
    const STEPS: i32 = 120;
    let (sin, cos) = altitude_deg.to_radians().sin_cos();
    let (mut sum, mut sum_of_weights) = (0.0, 0.0);
    for i in -STEPS..=STEPS {
        for j in -STEPS..=STEPS {
            // In units of the root mean square slope in one direction, up to 5.
            let [x, y] = [i, j].map(|k| 5.0 * f64::from(k) / f64::from(STEPS));
            let [slope_x, slope_y] = [x, y].map(|s| s * (0.5 * slope_sq).sqrt());
            let visible_area = (sin + slope_x * cos).max(0.0);
            let weight = visible_area * (-0.5 * (x * x + y * y)).exp();
            sum += weight * fresnel(visible_area / (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt());
            sum_of_weights += weight;
        }
    }
    sum / sum_of_weights
}

/// The part of the sky's light that waves mirror, for winds of 1, 5 and 19 m/s, against the sum over slopes. Measured: too much by 0.11 at most, at the horizon
/// (5 m/s: 0.073), from an altitude of 5 degrees on by 0.03 at most (5 m/s: 0.022).
#[test]
fn the_mean_reflectance_of_waves_is_that_of_their_slopes() {
    let fragment = GlintFunction::new("mean_fresnel_water(p.x, p.y)");
    for (slope_sq, at_horizon, from_5_deg) in [(0.0081, 0.115, 0.035), (0.0286, 0.08, 0.025), (0.1, 0.045, 0.025)] {
        for altitude_deg in [0.1, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 30.0, 45.0, 60.0, 90.0] {
            let found = fragment.run(&[[f64::to_radians(altitude_deg).sin(), slope_sq, 0.0, 0.0]])[0];
            let expected = mean_fresnel(altitude_deg, slope_sq);
            println!("slope² {slope_sq}, {altitude_deg} deg: {found:.4} for {expected:.4}");
            let bound = if altitude_deg < 5.0 { at_horizon } else { from_5_deg };
            assert!((found - expected).abs() < bound, "slope² {slope_sq}, {altitude_deg} deg: {found} for {expected}");
        }
    }
    // Negative control: calm water mirrors the horizon completely.
    assert!(fresnel(f64::to_radians(0.1).sin()) > 0.08 + mean_fresnel(0.1, 0.0286));
}

/// Of a uniform sky's light the sea mirrors about 6 % (the albedo for diffuse light of Payne 1972 and of Jin et al. 2004), never more than all.
#[test]
fn the_sea_mirrors_six_percent_of_the_light_of_a_uniform_sky() {
    const STEPS: u32 = 1000;
    let fragment = GlintFunction::new("mean_fresnel_water(p.x, p.y)");
    let cosines: Vec<f64> = (0..STEPS).map(|k| (f64::from(k) + 0.5) / f64::from(STEPS)).collect();
    for slope_sq in [0.0081, 0.0286, 0.1] {
        let found = fragment.run(&cosines.iter().map(|cos| [*cos, slope_sq, 0.0, 0.0]).collect::<Vec<_>>());
        assert!(found.iter().all(|part| (0.0199..=1.0).contains(part)), "{found:?}");
        let albedo = cosines.iter().zip(&found).map(|(cos, part)| 2.0 * cos * part).sum::<f64>() / f64::from(STEPS);
        println!("slope² {slope_sq}: {albedo:.4}");
        assert!((0.05..0.07).contains(&albedo), "slope² {slope_sq}: {albedo}");
    }
}

#[test]
fn fresnel_reflectance_follows_the_formulas() {
    let fragment = GlintFunction::new("fresnel_water(p.x)");
    for deg in 0..90 {
        let angle = f64::from(deg).to_radians();
        let approximate = fragment.run(&[[(2.0 * angle).cos(), 0.0, 0.0, 0.0]])[0];
        let bound = if deg <= 60 { 0.01 } else { 0.06 };
        assert!((approximate - fresnel(angle.cos())).abs() < bound, "{deg} deg: {approximate} against {}", fresnel(angle.cos()));
    }
    // The reflectance depends on the angle: a constant would fail.
    assert!(fresnel(80_f64.to_radians().cos()) > 0.02 + 0.06);
}
