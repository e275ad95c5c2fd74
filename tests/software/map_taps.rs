//! The taps of `filtered_map` (shaders/lib/filtered_map.wesl): the function and the native operation against a definition of the taps, their places and their
//! weights; and the value where a tap is added. Both tests take every weight of taps in docs/map-filter.md, not only the shipped one.

use super::filtered_map::{
    ENTRY, FRAGMENT, Footprint, GUIDE, batch, bound, by_definition, edited, fixed, greatest, greatest_step, linear_weight, native_program,
    noise, program, random,
};
use orrery::image::Texture;
use orrery::render::software::exec::LANES;
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::program::Program;

/// A weight of a tap that overlaps no other one.
struct TapWeight {
    /// Its row in docs/map-filter.md, *Weights of taps*.
    name: &'static str,
    /// The expression in the shader, as in that row.
    in_shader: &'static str,
    /// The weight by the tap's place on the major axis, from the middle, and the length of the axis, both in taps.
    by_definition: fn(f64, f64) -> f64,
}

const WEIGHTS: [TapWeight; 3] = [
    TapWeight { name: "constant", in_shader: "1.0", by_definition: constant_weight },
    TapWeight { name: "tent", in_shader: "1.0 - abs(along) * (1.5 / length)", by_definition: tent_weight },
    TapWeight { name: "Gaussian", in_shader: "exp(-8.0 * along * along / (length * length))", by_definition: gaussian_weight },
];

/// The name of the weight that the shader has.
const SHIPPED: &str = "constant";

fn constant_weight(_along: f64, _length: f64) -> f64 {
    1.0
}

/// Falls linearly from 1 in the middle to a quarter at the ends.
fn tent_weight(along: f64, length: f64) -> f64 {
    let to_end = along.abs() / (0.5 * length);
    (1.0 - to_end) + 0.25 * to_end
}

/// A Gaussian whose standard deviation is a quarter of the length.
fn gaussian_weight(along: f64, length: f64) -> f64 {
    (-0.5 * (along / (0.25 * length)).powi(2)).exp()
}

/// The taps along an axis, by definition: the place of each, from the middle, and how much of the axis it covers, in taps. Each half of the axis is filled
/// from its end; its innermost tap covers it only to the middle. An odd tap in the middle covers what is left.
fn taps_along(length: f64) -> Vec<[f64; 2]> {
    let count = length.ceil() as usize;
    let mut taps = Vec::new();
    for k in 0..count / 2 {
        let along = 0.5 * length - 0.5 - k as f64;
        let covered = (along + 0.5).min(1.0);
        taps.extend([[-along, covered], [along, covered]]);
    }
    if count % 2 == 1 {
        taps.push([0.0, length - (count - 1) as f64]);
    }
    taps
}

/// A channel filtered by definition, with up to `max_taps` taps (at least 2). `weight`: as [`TapWeight::by_definition`].
fn by_taps(texture: &Texture, footprint: &Footprint, max_taps: f64, channel: usize, weight: impl Fn(f64, f64) -> f64) -> f64 {
    let Footprint { uv: [u, v], major, minor, rotation, .. } = *footprint;
    let width = minor.max(major / max_taps).max(1.0);
    // Shorter by 0.01, so that a round footprint has one tap.
    let length = (major / width - 0.01).clamp(1.0, max_taps);
    let last = texture.levels.len() - 1;
    let level = width.log2().min(last as f64);
    let (finer, between) = (level as usize, level.fract());
    let (mut sum, mut total) = (0.0, 0.0);
    for [along, covered] in taps_along(length) {
        let at = [u + along * width * rotation.cos() / 256.0, v + along * width * rotation.sin() / 128.0];
        let [finer, coarser] = [finer, (finer + 1).min(last)].map(|k: usize| by_definition(&texture.levels[k], at, channel, linear_weight));
        let weight = covered * weight(along, length);
        sum += weight * ((1.0 - between) * finer + between * coarser);
        total += weight;
    }
    sum / total
}

/// The greatest error at random footprints against the definition, in f64.
fn error_of_taps(filter: &Program, class: KernelClass, max_taps: f32, weight: impl Fn(f64, f64) -> f64) -> f64 {
    let texture = noise();
    let textures = bound(filter, &texture, class);
    greatest((0..4).flat_map(|k| {
        let values = batch::<f64>(filter, &textures, class, max_taps, |lane| random(lane + LANES * k));
        let error = |lane: usize, channel: usize| {
            (values[lane][channel] - by_taps(&texture, &random(lane + LANES * k), f64::from(max_taps), channel, &weight)).abs()
        };
        (0..LANES).map(|lane| greatest([0, 1, 2, 3].map(|channel: usize| error(lane, channel)))).collect::<Vec<_>>()
    }))
}

/// The fragment with a weight of the guide, which is the unedited fragment if the weight is the shipped one.
fn with_tap_weight(weight: &TapWeight) -> String {
    let TapWeight { name, in_shader, .. } = weight;
    let row = format!("| {name} | `{in_shader}` |");
    assert!(GUIDE.contains(&row), "docs/map-filter.md has no row {row}");
    let (before, rest) = FRAGMENT.split_once("fn tap_weight(along: f32, length: f32) -> f32 {\n").expect("the function");
    let (_, after) = rest.split_once("\n}\n").expect("its end");
    let fragment = format!("{before}fn tap_weight(along: f32, length: f32) -> f32 {{\n    return {in_shader};\n}}\n{after}");
    assert_eq!(fragment == FRAGMENT, *name == SHIPPED, "SHIPPED does not name the shader's weight: {name}");
    fragment
}

#[test]
fn taps_have_the_places_and_weights_of_their_definition() {
    let renamed = |weight| program(&format!("{}{ENTRY}", with_tap_weight(weight)).replace("filtered_map", "tap_by_tap"));
    let interpreted = WEIGHTS.iter().map(|weight| ("interpreted", renamed(weight), weight));
    let shipped = WEIGHTS.iter().find(|weight| weight.name == SHIPPED).expect("SHIPPED is in WEIGHTS");
    for (way, filter, weight) in interpreted.chain([("native", native_program(), shipped)]) {
        let name = weight.name;
        for class in KernelClass::available() {
            for max_taps in [2.0, 8.0, 16.0] {
                let error = error_of_taps(&filter, class, max_taps, weight.by_definition);
                assert!(error < 1e-9, "{name}, {way}, {}, {max_taps} taps: {error}", class.name());
            }
        }
        // The comparison must be able to fail: another weight. Two taps have equal weights in all.
        for other in WEIGHTS.iter().filter(|other| other.name != name) {
            let error = error_of_taps(&filter, KernelClass::in_use(), 8.0, other.by_definition);
            assert!(error > 1e-3, "{name}, {way}, is not told from {}: {error}", other.name);
        }
    }
}

/// How much the weights that grow, divided by the sum of all, grow together where a footprint gets a thousandth of a tap longer: at most, over all lengths.
fn greatest_growth(weight: fn(f64, f64) -> f64) -> f64 {
    let shares = |length: f64| -> Vec<f64> {
        let weights: Vec<f64> = taps_along(length).into_iter().map(|[along, covered]| covered * weight(along, length)).collect();
        let total: f64 = weights.iter().sum();
        weights.into_iter().map(|weight| weight / total).collect()
    };
    let growth = |length: f64| -> f64 {
        let pairs = shares(length).into_iter().zip(shares(length + 1e-3));
        pairs.map(|(before, after)| (after - before).max(0.0)).sum()
    };
    // At whole lengths, which are left out, a tap is added.
    greatest((1..16).flat_map(|taps| (0..999).map(move |k| f64::from(taps) + 1e-3 * (f64::from(k) + 0.1))).map(growth))
}

/// A footprint that grows from 1 to 17 widths.
fn lengthened(width: f64) -> impl Fn(f64) -> Footprint {
    move |t| fixed(width * (1.0 + 16.0 * t), width)
}

#[test]
fn an_added_tap_causes_no_jump() {
    let class = KernelClass::in_use();
    // A step is a thousandth of the width. It moves a tap by at most half of that, 0.75e-3 texels of the finer mip level, where these footprints are at most
    // 1.5 texels wide. Texels are noise between 0 and 1, so at this angle the value changes by at most 0.75e-3 (cos 0.6 + sin 0.6) = 1.04e-3; and, because the
    // weights change, by their growth. Both with a margin of 5 %.
    for weight in &WEIGHTS {
        let filter = program(&format!("{}{ENTRY}", with_tap_weight(weight)));
        let bound = 1.1e-3 + 1.05 * greatest_growth(weight.by_definition);
        for width in [1.0, 1.4, 3.0] {
            let step = greatest_step::<f64>(&filter, class, lengthened(width));
            assert!(step < bound, "{}: a step of {step} at a width of {width} texels; at most {bound}", weight.name);
        }
    }
    // The comparison must be able to fail: all taps weigh the same.
    let equal_weights = edited("1.0 - excess * max(1.0 - abs(offset), 0.0)", "reach.length / taps");
    let step = greatest_step::<f64>(&program(&format!("{equal_weights}{ENTRY}")), class, lengthened(1.0));
    assert!(step > 1e-2, "a jump of {step} is not detected");
}
