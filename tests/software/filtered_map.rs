//! Anisotropic filtering by `filtered_map` (shaders/lib/filtered_map.wesl): the function run tap by tap, against the single texture operation that the
//! software renderer substitutes for it, on random footprints; and the examples in docs/map-filter.md against the definitions of their filters. Not here: what
//! the taps are (map_taps.rs).
//!
//! The fragment is lowered twice: unchanged, and with its function renamed, so that the lowering does not recognise it. Only the unedited function is
//! replaced.

use crate::support::folds::larger;
use orrery::image::{Level, TexelFormat, Texture};
use orrery::render::plan::{AddressMode, SamplerState};
use orrery::render::software::exec::{Executor, LANES, LaneMask};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::lower::{lower, lowering, programs_from_bytes};
use orrery::render::software::math::Real;
use orrery::render::software::program::{LaneInput, Program};
use orrery::render::software::sample::texels::Texels;
use orrery::render::software::sample::{BoundTexture, Textures};
use orrery::render::software::tape::{Instr, TextureOp};
use orrery::shader::fragments::Fragments;
use orrery::shader::{ModuleId, ShaderModule};
use std::sync::Arc;

pub(super) const FRAGMENT: &str = include_str!("../../shaders/lib/filtered_map.wesl");
pub(super) const GUIDE: &str = include_str!("../../docs/map-filter.md");
/// The two places where `filtered_map` reads the texels of one level.
const FINER_READ: &str = "bilinear(map, map_sampler, place, finer)";
const COARSER_READ: &str = "bilinear(map, map_sampler, place, min(finer + 1u, last))";

pub(super) const ENTRY: &str = "
struct Draw { max_taps: f32 }
@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var map: texture_2d<f32>;
@group(0) @binding(8) var map_sampler: sampler;
@fragment fn main(@location(0) uv: vec2f, @location(1) gradients: vec4f) -> @location(0) vec4f {
    return filtered_map(map, map_sampler, uv, gradients.xy, gradients.zw, draw.max_taps);
}";

/// The fragment stage `main` of a module.
pub(super) fn program(wgsl: &str) -> Program {
    let module = naga::front::wgsl::parse_str(wgsl).expect("WGSL");
    let info = orrery::shader::module::validate(&module).expect("valid");
    lower(&module, &info, "main").expect("lowers")
}

/// The texture operations of a tape, in order.
pub(super) fn reads(program: &Program) -> Vec<TextureOp> {
    program.lane_tape.iter().filter_map(|i| if let Instr::Texture { op, .. } = i { Some(*op) } else { None }).collect()
}

/// Whether a tape runs the filter as it is written, which reads single texels of given levels.
fn is_interpreted(program: &Program) -> bool {
    let reads = reads(program);
    !reads.is_empty() && reads.iter().all(|op| *op == TextureOp::Level)
}

/// The shipped function, which is replaced by the operation.
pub(super) fn native_program() -> Program {
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    assert_eq!(reads(&native), [TextureOp::Filtered], "not replaced; `cargo test --lib lower::native` says why");
    native
}

/// The shipped function under another name, so that it is not replaced.
fn renamed() -> String {
    format!("{FRAGMENT}{ENTRY}").replace("filtered_map", "tap_by_tap")
}

/// Random texels on every level, so that a wrong level is detected.
pub(super) fn noise() -> Texture {
    let mut seed = 5_u32;
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / 16_777_216.0
    };
    let sizes = std::iter::successors(Some((256_u32, 128_u32)), |&(w, h)| (w > 1 || h > 1).then_some(((w / 2).max(1), (h / 2).max(1))));
    let level = |(width, height): (u32, u32), texel: &mut dyn FnMut() -> f32| {
        Level::new(width, height, (0..4 * width * height).flat_map(|_| texel().to_le_bytes()).collect())
    };
    Texture { format: TexelFormat::Rgba32Float, levels: sizes.map(|s| level(s, &mut next)).collect() }
}

/// The ellipse on the map that is a pixel's footprint.
pub(super) struct Footprint {
    /// Its centre, in map coordinates.
    pub(super) uv: [f64; 2],
    /// Lengths of the axes, texels.
    pub(super) major: f64,
    pub(super) minor: f64,
    /// Angle of the major axis, radians.
    pub(super) rotation: f64,
    /// The gradients along x and y are the points `phase` and `phase` + 90 degrees of the ellipse in its parametric form, major axis times cosine + minor axis
    /// times sine; radians.
    pub(super) phase: f64,
}

/// A quasi-random position and footprint: the major axis is 1/8 to 256 texels long, up to 32 times the minor one, in any direction.
pub(super) fn random(index: usize) -> Footprint {
    let unit = |k: usize| (index as f64 * [0.618_034, 0.754_878, 0.819_173, 0.856_675, 0.880_2][k]).fract();
    let major = (unit(2) * 11.0 - 3.0).exp2();
    let minor = major * (-unit(3) * 5.0).exp2();
    Footprint { uv: [3.0 * unit(0) - 1.0, 3.0 * unit(1) - 1.0], major, minor, rotation: unit(4) * 6.3, phase: unit(0) * 6.3 }
}

/// A quasi-random footprint of at most 0.66 texels, so that the squares of its axes add up to less than 1 in every lane of a batch. The lanes of a quad are a
/// quarter of a texel apart, as in an image, and often lie between the same four texels.
fn magnified(index: usize) -> Footprint {
    let Footprint { uv: [u, v], major, minor, rotation, phase } = random(index / 4);
    let shrunk = (-0.6 - 0.3 * (major.log2() + 3.0)).exp2();
    let [x, y] = [index % 2, index / 2 % 2].map(|texels| 0.25 * texels as f64);
    Footprint { uv: [u + x / 256.0, v + y / 128.0], major: shrunk, minor: shrunk * minor / major, rotation, phase }
}

/// Filtered values of one batch: the lane number gives the footprint.
pub(super) fn batch<R: Real>(
    program: &Program,
    textures: &Textures<'_>,
    class: KernelClass,
    max_taps: f32,
    footprint: impl Fn(usize) -> Footprint,
) -> Vec<[f64; 4]> {
    let mut executor = Executor::<R>::with_class(program, class).expect("binds");
    for (k, input) in program.inputs.iter().enumerate() {
        for (lane, v) in executor.input_mut(k).iter_mut().enumerate() {
            let Footprint { uv, major, minor, rotation, phase } = footprint(lane);
            // Axes of the ellipse, then gradients along x and y, in texels; the inputs of the shader are in map coordinates.
            let [major_x, major_y] = [major * rotation.cos(), major * rotation.sin()];
            let [minor_x, minor_y] = [-minor * rotation.sin(), minor * rotation.cos()];
            let x = [major_x * phase.cos() + minor_x * phase.sin(), major_y * phase.cos() + minor_y * phase.sin()];
            let y = [minor_x * phase.cos() - major_x * phase.sin(), minor_y * phase.cos() - major_y * phase.sin()];
            *v = R::from_f64(match input {
                LaneInput::Location { index: 0, component, .. } => uv[*component as usize],
                LaneInput::Location { component, .. } => [x[0] / 256.0, x[1] / 128.0, y[0] / 256.0, y[1] / 128.0][*component as usize],
                other => panic!("{other:?}"),
            });
        }
    }
    executor.run(&program.run_draw_tape::<R>(&max_taps.to_le_bytes(), class, textures), LaneMask::MAX, textures);
    (0..LANES).map(|lane| std::array::from_fn(|k| executor.output(k)[lane].to_f64())).collect()
}

/// The texture, bound at every place where the program reads a texture.
pub(super) fn bound<'a>(program: &Program, texture: &'a Texture, class: KernelClass) -> Textures<'a> {
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };
    let texels = Arc::new(Texels::of_texture(texture).expect("complete levels"));
    let uses = program.textures.iter().map(|t| BoundTexture { texels: Arc::clone(&texels), sampler: t.sampler_binding.map(|_| state) });
    Textures::new(uses.collect(), class)
}

/// The greatest of some numbers; NaN if one of them is NaN.
pub(super) fn greatest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().reduce(larger).expect("one number at least")
}

/// Differences between two programs in each lane (the largest of the four channels), in ascending order.
fn differences<R: Real>(
    native: &Program,
    interpreted: &Program,
    class: KernelClass,
    max_taps: f32,
    footprint_of: fn(usize) -> Footprint,
) -> Vec<f64> {
    let texture = noise();
    let (native_textures, interpreted_textures) = (bound(native, &texture, class), bound(interpreted, &texture, class));
    let mut all: Vec<f64> = (0..16)
        .flat_map(|k| {
            let footprint = |lane: usize| footprint_of(lane + LANES * k);
            let native_values = batch::<R>(native, &native_textures, class, max_taps, footprint);
            native_values.into_iter().zip(batch::<R>(interpreted, &interpreted_textures, class, max_taps, footprint))
        })
        .map(|(a, b)| greatest([0, 1, 2, 3].map(|k: usize| (a[k] - b[k]).abs())))
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Compares both programs in every kernel class, in f64 and in f32.
fn assert_equal_values(native: &Program, interpreted: &Program, max_taps: f32, footprint_of: fn(usize) -> Footprint) {
    for class in KernelClass::available() {
        let sorted = differences::<f64>(native, interpreted, class, max_taps, footprint_of);
        assert!(sorted[sorted.len() - 1] < 1e-9, "{} at {max_taps} taps, f64: {}", class.name(), sorted[sorted.len() - 1]);
        // In f32 rounding may add a tap, which then has almost no weight. Coordinates are accurate to 2^-16 of a texel.
        let sorted = differences::<f32>(native, interpreted, class, max_taps, footprint_of);
        assert!(sorted[sorted.len() - 1] < 1e-3, "{} at {max_taps} taps, f32: {}", class.name(), sorted[sorted.len() - 1]);
    }
}

#[test]
fn the_operation_gives_the_values_of_the_fragment() {
    let (native, interpreted) = (native_program(), program(&renamed()));
    assert!(is_interpreted(&interpreted));
    for max_taps in [1.0, 2.0, 8.0, 16.0] {
        assert_equal_values(&native, &interpreted, max_taps, random);
    }
    // The comparison must be able to fail: the level raised by 0.3, or the taps shifted by half a tap.
    for (shipped, edit) in [("0.5 * log2(kept_sq)", "0.5 * log2(kept_sq) + 0.3"), ("- 0.5 * (taps - 1.0)", "- 0.5 * taps")] {
        assert!(renamed().contains(shipped));
        let edited_program = program(&renamed().replace(shipped, edit));
        let sorted = differences::<f64>(&native, &edited_program, KernelClass::in_use(), 8.0, random);
        assert!(sorted[sorted.len() / 2] > 1e-3, "{edit} is not detected");
    }
}

/// A batch in which the squares of the axes of each footprint add up to at most 1 takes a path of its own through the native code, without levels and taps.
#[test]
fn the_operation_gives_the_values_of_the_fragment_where_every_lane_is_magnified() {
    let (native, interpreted) = (native_program(), program(&renamed()));
    for max_taps in [1.0, 8.0] {
        assert_equal_values(&native, &interpreted, max_taps, magnified);
    }
    // The comparison must be able to fail: other weights of the four texels.
    let shipped = "let weight = fract(place);";
    assert!(renamed().contains(shipped));
    let edited_program = program(&renamed().replace(shipped, "let weight = fract(place) * fract(place);"));
    let sorted = differences::<f64>(&native, &edited_program, KernelClass::in_use(), 8.0, magnified);
    assert!(sorted[sorted.len() / 2] > 1e-3, "other weights are not detected");
}

/// A quasi-random footprint far longer than the map, as of a planet of which thousands of radii fit into a pixel: 2^29 to 2^40 texels.
fn vast(index: usize) -> Footprint {
    let Footprint { uv, major, minor, rotation, phase } = random(index);
    let scale = 32.0_f64.exp2();
    Footprint { uv, major: scale * major, minor: scale * minor, rotation, phase }
}

/// The greatest difference from the only texel of the coarsest level at vast footprints; NaN if a value is NaN.
fn error_of_vast<R: Real>(filter: &Program, class: KernelClass, max_taps: f32) -> f64 {
    let texture = noise();
    let coarsest = texture.levels.last().expect("levels");
    let texel = |channel| by_definition(coarsest, [0.0, 0.0], channel, linear_weight);
    let values = batch::<R>(filter, &bound(filter, &texture, class), class, max_taps, vast);
    greatest(values.into_iter().flat_map(|value| [0, 1, 2, 3].map(|k: usize| (value[k] - texel(k)).abs())))
}

/// The squares of such footprints are within f32, those of the squares are not. 1e-5 is for the rounding of up to 16 taps and their weights.
#[test]
fn a_footprint_far_longer_than_the_map_has_the_value_of_the_coarsest_level() {
    let (native, interpreted) = (native_program(), program(&renamed()));
    for filter in [&native, &interpreted] {
        for class in KernelClass::available() {
            for max_taps in [1.0, 8.0, 16.0] {
                let errors = [error_of_vast::<f64>(filter, class, max_taps), error_of_vast::<f32>(filter, class, max_taps)];
                assert!(errors.iter().all(|error| *error < 1e-5), "{} at {max_taps} taps, f64 and f32: {errors:?}", class.name());
            }
        }
    }
    // The comparison must be able to fail: gradients without a limit.
    let limits = ", vec2f(-LONGEST_GRADIENT), vec2f(LONGEST_GRADIENT))";
    assert_eq!(renamed().matches(limits).count(), 2);
    let unlimited = program(&renamed().replace(limits, ", vec2f(-1.0e38), vec2f(1.0e38))"));
    let error = error_of_vast::<f32>(&unlimited, KernelClass::in_use(), 8.0);
    assert!(!error.is_finite(), "an overflow is not detected: {error}");
}

/// The greatest change of the value from one footprint to the next, in 16 000 equal steps of the parameter from 0 to 1.
pub(super) fn greatest_step<R: Real>(program: &Program, class: KernelClass, footprint_at: impl Fn(f64) -> Footprint) -> f64 {
    let texture = noise();
    let textures = bound(program, &texture, class);
    let values: Vec<[f64; 4]> = (0..16_000 / LANES)
        .flat_map(|k| batch::<R>(program, &textures, class, 16.0, |lane| footprint_at((lane + LANES * k) as f64 / 16_000.0)))
        .collect();
    greatest(values.windows(2).flat_map(|pair| [0, 1, 2, 3].map(|k: usize| (pair[0][k] - pair[1][k]).abs())))
}

/// A footprint at a fixed position.
pub(super) fn fixed(major: f64, minor: f64) -> Footprint {
    Footprint { uv: [0.31, 0.47], major, minor, rotation: 0.6, phase: 0.4 }
}

/// A round footprint that grows from half a texel to two.
fn growing(t: f64) -> Footprint {
    fixed(0.5 + 1.5 * t, 0.5 + 1.5 * t)
}

/// The steepest slope of the weight between two levels as a function of the level's fraction. It is 1 because the weight is the fraction itself.
const STEEPEST_WEIGHT: f64 = 1.0;
/// A step of 1.5 / 16 000 of a texel changes the level by at most 1.4e-4, and so the weight between levels by at most that times its slope; and it moves a tap
/// by at most half of the step, 4.7e-5 texels. The texels are between 0 and 1. Both terms have a margin for rounding.
const GREATEST_STEP_OF_GROWTH: f64 = 1.45e-4 * STEEPEST_WEIGHT + 5.5e-5;

#[test]
fn no_jump_separates_magnification_from_minification() {
    for filter in [program(&format!("{FRAGMENT}{ENTRY}")), program(&renamed())] {
        for class in KernelClass::available() {
            let elongated = |t: f64| fixed(0.5 + 1.5 * t, (0.5 + 1.5 * t) / 3.0);
            for step in [
                greatest_step::<f64>(&filter, class, growing),
                greatest_step::<f32>(&filter, class, growing),
                greatest_step::<f64>(&filter, class, elongated),
                greatest_step::<f32>(&filter, class, elongated),
            ] {
                assert!(step < GREATEST_STEP_OF_GROWTH, "a step of {step}, {}", class.name());
            }
        }
    }
    // The comparison must be able to fail: half the value where the footprint is at most a texel wide.
    let halved = edited(FINER_READ, &format!("select(1.0, 0.5, reach.level < 1.0e-6) * {FINER_READ}"));
    let step = greatest_step::<f64>(&program(&format!("{halved}{ENTRY}")), KernelClass::in_use(), growing);
    assert!(step > 1e-2, "a jump of {step} is not detected");
}

/// A channel of a level by a separable filter of sixteen texels, by definition; u is periodic, v is clamped. `weight`: of a texel, by its distance along one
/// axis.
pub(super) fn by_definition(level: &Level, [u, v]: [f64; 2], channel: usize, weight: fn(f64) -> f64) -> f64 {
    let (w, h) = (i64::from(level.width), i64::from(level.height));
    let (x, y) = (u * w as f64 - 0.5, v * h as f64 - 0.5);
    let mut sum = 0.0;
    for i in x.floor() as i64 - 1..=x.floor() as i64 + 2 {
        for j in y.floor() as i64 - 1..=y.floor() as i64 + 2 {
            let at = ((j.clamp(0, h - 1) * w + i.rem_euclid(w)) * 16) as usize + channel * 4;
            let texel = f32::from_le_bytes(level.bytes()[at..at + 4].try_into().expect("four bytes"));
            sum += weight((x - i as f64).abs()) * weight((y - j as f64).abs()) * f64::from(texel);
        }
    }
    // Only filters with negative weights leave this range, and these are clamped to it.
    sum.clamp(0.0, 1.0)
}

/// The weight of a texel in the uniform cubic B-spline, by its distance along one axis.
pub(super) fn b_spline_weight(d: f64) -> f64 {
    if d < 1.0 { 2.0 / 3.0 - d * d + d * d * d / 2.0 } else { (2.0 - d).max(0.0).powi(3) / 6.0 }
}

fn catmull_rom_weight(d: f64) -> f64 {
    match d {
        d if d < 1.0 => 1.0 - 2.5 * d * d + 1.5 * d * d * d,
        d if d < 2.0 => 2.0 - 4.0 * d + 2.5 * d * d - 0.5 * d * d * d,
        _ => 0.0,
    }
}

pub(super) fn linear_weight(d: f64) -> f64 {
    (1.0 - d).max(0.0)
}

/// The guide's WGSL block that contains a text.
fn code_of_guide(text: &str) -> &'static str {
    let mut blocks = GUIDE.split("```wgsl").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.find(|block| block.contains(text)).unwrap_or_else(|| panic!("docs/map-filter.md has no WGSL block with `{text}`"))
}

/// The fragment edited as the guide says: `function`, which the guide defines, reads the texels of each level; a guard keeps bilinear reads for `smooth_map`.
fn example_of_guide(function: &str) -> Program {
    let reads = edited(FINER_READ, &FINER_READ.replace("bilinear", function));
    assert!(reads.contains(COARSER_READ) && reads.contains("    let reach ="));
    let reads = reads.replace(COARSER_READ, &COARSER_READ.replace("bilinear", function));
    let guarded = reads.replace("    let reach =", &format!("{}    let reach =", code_of_guide("if max_taps == 0.0 {")));
    program(&format!("{guarded}{}{ENTRY}", code_of_guide(&format!("fn {function}("))))
}

/// The greatest error at magnified footprints against a filter of level 0.
fn error_of_magnified(filter: &Program, max_taps: f32, weight: fn(f64) -> f64) -> f64 {
    let (texture, class) = (noise(), KernelClass::in_use());
    let values = batch::<f64>(filter, &bound(filter, &texture, class), class, max_taps, magnified);
    let errors = |lane: usize| {
        [0, 1, 2, 3].map(|k: usize| (values[lane][k] - by_definition(&texture.levels[0], magnified(lane).uv, k, weight)).abs())
    };
    greatest((0..LANES).flat_map(errors))
}

#[test]
fn the_examples_in_the_guide_magnify_by_their_filters_without_a_jump_and_keep_bilinear_reads() {
    let of_shipped = |weight| error_of_magnified(&program(&renamed()), 8.0, weight);
    for (function, weight) in [("b_spline", b_spline_weight as fn(f64) -> f64), ("catmull_rom", catmull_rom_weight)] {
        let example = example_of_guide(function);
        assert!(is_interpreted(&example));
        let (error, of_bilinear_reads) = (error_of_magnified(&example, 8.0, weight), error_of_magnified(&example, 0.0, linear_weight));
        assert!(error < 1e-9 && of_bilinear_reads < 1e-9, "{function}: {error}, without taps {of_bilinear_reads}");
        assert!(of_shipped(weight) > 1e-2, "{function}: the bilinear filter is not detected: {}", of_shipped(weight));
        let step = greatest_step::<f64>(&example, KernelClass::in_use(), growing);
        assert!(step < GREATEST_STEP_OF_GROWTH, "{function}: a step of {step}");
    }
}

/// An edited function under its original name, so that only its body differs from the shipped one.
pub(super) fn edited(shipped: &str, edit: &str) -> String {
    assert!(FRAGMENT.contains(shipped), "{shipped}");
    FRAGMENT.replace(shipped, edit)
}

#[test]
fn an_edited_function_is_not_replaced() {
    let class = KernelClass::in_use();
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    for (shipped, edit) in [
        ("0.5 * log2(kept_sq)", "0.5 * log2(kept_sq) + 0.3"),
        ("- 0.5 * (taps - 1.0)", "- 0.5 * taps"),
        ("- 0.01,", "- 0.5,"),
        ("return sum / total", "return 0.5 * sum / total"),
    ] {
        let fragment = edited(shipped, edit);
        let edited_program = program(&format!("{fragment}{ENTRY}"));
        let under_another_name = program(&format!("{fragment}{ENTRY}").replace("filtered_map", "tap_by_tap"));
        assert!(is_interpreted(&edited_program), "{edit}");
        assert_eq!(differences::<f64>(&edited_program, &under_another_name, class, 8.0, random).last(), Some(&0.0), "{edit}");
        let sorted = differences::<f64>(&edited_program, &native, class, 8.0, random);
        assert!(sorted[sorted.len() - 1] > 1e-3, "{edit} is not detected");
    }
    // A statement without a result, such as `discard`, is an edit too.
    let discarding = program(&format!("{}{ENTRY}", edited("let reach =", "if max_taps > 100.0 { discard; }\n    let reach =")));
    assert!(discarding.uses_discard && is_interpreted(&discarding));
    let discarding = program(&format!("{}{ENTRY}", edited("return sum / total;", "discard;\n    return sum / total;")));
    assert!(is_interpreted(&discarding));
}

#[test]
fn a_function_with_other_local_names_or_comments_is_still_replaced() {
    native_program();
    let equivalent = [
        edited("reach", "extent"),
        edited("excess", "overhang").replace("let overhang", "// Of the last tap.\n    let overhang"),
        format!("var<private> unrelated: f32 = 7.5;\n{FRAGMENT}\nfn also(x: f32) -> f32 {{ return x * 2.5 + unrelated; }}"),
    ];
    for fragment in equivalent {
        assert_eq!(reads(&program(&format!("{fragment}{ENTRY}"))), [TextureOp::Filtered], "{fragment}");
    }
}

/// A planet's module with a map, and the same module with the user's version of the fragment, as with `view --shaders`.
#[test]
fn a_planets_module_has_the_operation_until_the_fragment_is_edited() {
    native_program();
    let reads_of = |fragments: &Fragments| {
        let id: ModuleId = "lambert.albedo.sun1.sphere".parse().expect("a key");
        let module = ShaderModule::build_with(fragments, &id, &lowering()).expect("builds");
        let programs = programs_from_bytes(&module.tape).expect("programs");
        programs.iter().flat_map(reads).collect::<Vec<_>>()
    };
    let shipped = reads_of(&Fragments::default());
    assert!(shipped.contains(&TextureOp::Filtered), "{shipped:?}");
    let file = ("lib/filtered_map.wesl".to_owned(), edited("0.5 * log2(kept_sq)", "0.5 * log2(kept_sq) + 0.3"));
    let edited_reads = reads_of(&Fragments::with_files([file]));
    assert!(!edited_reads.contains(&TextureOp::Filtered) && edited_reads.contains(&TextureOp::Level), "{edited_reads:?}");
}
