//! Maps whose texels are larger than pixels (shaders/lib/read_map.wesl): the cubic B-spline against its definition by 16 texels, and the transition to
//! `filtered_map`.

use super::filtered_map::{Footprint, b_spline_weight, batch, bound, by_definition, fixed, greatest, greatest_step, noise, program};
use orrery::render::software::exec::LANES;
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::math::Real;
use orrery::render::software::program::Program;

const FILTER: &str = include_str!("../../shaders/lib/filtered_map.wesl");
const READ_MAP: &str = include_str!("../../shaders/lib/read_map.wesl");

const NEAR: &str = "1.0e-4";
const FAR: &str = "0.01";

/// The fragment stage that reads a map. `map_pixel`: width of a pixel straight below the camera, in circumferences.
fn reading(read_map: &str, map_pixel: &str) -> Program {
    let fragment: String = read_map.lines().filter(|line| !line.starts_with("import ")).map(|line| format!("{line}\n")).collect();
    let fragment = fragment.replace("draw.map_pixel", map_pixel);
    let entry = "
struct Draw { map_taps: f32 }
@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var map: texture_2d<f32>;
@group(0) @binding(8) var map_sampler: sampler;
@fragment fn main(@location(0) uv: vec2f, @location(1) gradients: vec4f) -> @location(0) vec4f {
    return read_map(map, map_sampler, uv, gradients.xy, gradients.zw);
}";
    program(&format!("{FILTER}{fragment}{entry}"))
}

fn values<R: Real>(program: &Program, footprint_at: impl Fn(usize) -> Footprint) -> Vec<[f64; 4]> {
    let (texture, class) = (noise(), KernelClass::in_use());
    let textures = bound(program, &texture, class);
    (0..8).flat_map(|k| batch::<R>(program, &textures, class, 8.0, |lane| footprint_at(lane + LANES * k))).collect()
}

/// A round footprint of a width in texels at a quasi-random place.
fn round(index: usize, width: f64) -> Footprint {
    let unit = |factor: f64| (index as f64 * factor).fract();
    Footprint { uv: [3.0 * unit(0.618_034) - 1.0, 3.0 * unit(0.754_878) - 1.0], ..fixed(width, width) }
}

/// Below an eighth of a texel per pixel the value is that of the B-spline: in f64 to rounding, in f32 to 2^-16 of a texel's position.
#[test]
fn magnified_maps_are_cubic_b_splines() {
    let texture = noise();
    let at = |index: usize| round(index, 0.1);
    let spline = |uv: [f64; 2]| [0, 1, 2, 3].map(|channel: usize| by_definition(&texture.levels[0], uv, channel, b_spline_weight));
    let expected: Vec<[f64; 4]> = (0..8 * LANES).map(|index| spline(at(index).uv)).collect();
    let difference = |program: &Program, in_f32: bool| {
        let found = if in_f32 { values::<f32>(program, at) } else { values::<f64>(program, at) };
        greatest(found.iter().zip(&expected).flat_map(|(a, b)| [0, 1, 2, 3].map(|c: usize| (a[c] - b[c]).abs())))
    };
    let near = reading(READ_MAP, NEAR);
    let [in_f64, in_f32] = [difference(&near, false), difference(&near, true)];
    assert!(in_f64 < 1e-9 && in_f32 < 1e-3, "{in_f64} in f64, {in_f32} in f32");
    // The comparison must be able to fail: bilinear interpolation, and another weight.
    assert!(difference(&reading(READ_MAP, FAR), false) > 0.1, "bilinear values count as a spline");
    let edited = READ_MAP.replace("4.0 - 6.0 * f * f", "4.0 - 5.9 * f * f");
    assert!(edited != READ_MAP && difference(&reading(&edited, NEAR), false) > 1e-3, "another weight is not noticed");
}

/// Where no pixel is smaller than a quarter of a texel, all values are those of `filtered_map`, to the bit; so are, in a near view, pixels that span more than
/// a quarter of a texel in some direction.
#[test]
fn other_maps_are_filtered_to_the_bit() {
    let filter_only = READ_MAP.replace("if 2.0 * narrowest * narrowest < SMOOTHING_BEGINS {", "if false {");
    assert_ne!(filter_only, READ_MAP);
    let (filter, far, near) = (reading(&filter_only, FAR), reading(READ_MAP, FAR), reading(READ_MAP, NEAR));
    for width in [0.05, 0.15, 0.24, 0.26, 0.75, 1.5, 20.0] {
        let of = |program: &Program| values::<f32>(program, |index| round(index, width));
        assert_eq!(of(&far), of(&filter), "{width} texels");
        assert_eq!(of(&near) == of(&filter), width > 0.25, "{width} texels, near");
    }
}

/// While a footprint grows from a sixteenth of a texel to one, the value changes gradually.
#[test]
fn no_jump_separates_smooth_from_filtered_maps() {
    let growing = |t: f64| fixed(0.0625 + 0.9375 * t, 0.0625 + 0.9375 * t);
    // 16 000 steps of 5.9e-5 texels. The weight's slope is at most 1.5 per 0.09375 of the sum of squares, whose slope is at most 4 widths, 1 at a quarter of a
    // texel: 16 per texel; the two values differ by at most 1.
    const MAX_STEP: f64 = 16.0 * 5.9e-5;
    let step = greatest_step::<f64>(&reading(READ_MAP, NEAR), KernelClass::in_use(), growing);
    assert!(step < MAX_STEP, "a step of {step}");
    let edited = READ_MAP.replace("smoothstep(SMOOTHING_IS_COMPLETE, SMOOTHING_BEGINS, ", "step(0.08, ");
    assert_ne!(edited, READ_MAP);
    let step = greatest_step::<f64>(&reading(&edited, NEAR), KernelClass::in_use(), growing);
    assert!(step > 10.0 * MAX_STEP, "a jump of {step} is not noticed");
}
