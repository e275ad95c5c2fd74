//! Anisotropic filtering by `filtered_map` (shaders/lib/filtered_map.wesl): the function run tap by tap, against the single texture operation that the
//! software renderer substitutes for it, on random footprints.
//!
//! The fragment is lowered twice: unchanged, and with its function renamed, so that the lowering does not recognise it. Only the unedited function is
//! replaced.

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

const FRAGMENT: &str = include_str!("../../shaders/lib/filtered_map.wesl");

const ENTRY: &str = "
struct Draw { max_taps: f32 }
@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var map: texture_2d<f32>;
@group(0) @binding(8) var map_sampler: sampler;
@fragment fn main(@location(0) uv: vec2f, @location(1) gradients: vec4f) -> @location(0) vec4f {
    return filtered_map(map, map_sampler, uv, gradients.xy, gradients.zw, draw.max_taps);
}";

/// Texture operations of a tape whose filter is not replaced: one read for each of four texels of two levels.
const TAP_BY_TAP: [TextureOp; 8] = [TextureOp::Level; 8];

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

/// Random texels on every level, so that a wrong level is detected.
fn noise() -> Texture {
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

/// A position on the map and the ellipse of a pixel's footprint, in texels.
struct Footprint {
    uv: [f64; 2],
    /// Lengths of the axes, texels.
    major: f64,
    minor: f64,
    /// Angle of the major axis, radians.
    rotation: f64,
    /// Direction of the gradient along x as the parameter of the ellipse: 0 along the major axis; radians.
    phase: f64,
}

/// A quasi-random position and footprint: the major axis is 1/8 to 256 texels long, up to 32 times the minor one, in any direction.
fn random(index: usize) -> Footprint {
    let unit = |k: usize| (index as f64 * [0.618_034, 0.754_878, 0.819_173, 0.856_675, 0.880_2][k]).fract();
    let major = (unit(2) * 11.0 - 3.0).exp2();
    let minor = major * (-unit(3) * 5.0).exp2();
    Footprint { uv: [3.0 * unit(0) - 1.0, 3.0 * unit(1) - 1.0], major, minor, rotation: unit(4) * 6.3, phase: unit(0) * 6.3 }
}

/// Filtered values of one batch: the lane number gives the footprint.
fn batch<R: Real>(
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
    executor.run(&program.prepare_for::<R>(&max_taps.to_le_bytes(), class), LaneMask::MAX, textures);
    (0..LANES).map(|lane| std::array::from_fn(|k| executor.output(k)[lane].f64())).collect()
}

/// The texture, bound at every place where the program reads a texture.
fn bound<'a>(program: &Program, texture: &'a Texture, class: KernelClass) -> Textures<'a> {
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, linear: true };
    let texels = Arc::new(Texels::of_texture(texture).expect("complete levels"));
    let uses = program.textures.iter().map(|t| BoundTexture { texels: Arc::clone(&texels), sampler: t.sampler_binding.map(|_| state) });
    Textures::new(uses.collect(), class)
}

/// Differences between two programs in each lane (the largest of the four channels), in ascending order.
fn differences<R: Real>(native: &Program, taps: &Program, class: KernelClass, max_taps: f32) -> Vec<f64> {
    let texture = noise();
    let (native_textures, tap_textures) = (bound(native, &texture, class), bound(taps, &texture, class));
    let mut all: Vec<f64> = (0..16)
        .flat_map(|k| {
            let footprint = |lane: usize| random(lane + LANES * k);
            let native = batch::<R>(native, &native_textures, class, max_taps, footprint);
            native.into_iter().zip(batch::<R>(taps, &tap_textures, class, max_taps, footprint))
        })
        .map(|(a, b)| a.iter().zip(b).fold(0.0, |d: f64, (a, b)| d.max((a - b).abs())))
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn the_operation_gives_the_values_of_the_fragment() {
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    let renamed = format!("{FRAGMENT}{ENTRY}").replace("filtered_map", "tap_by_tap");
    let taps = program(&renamed);
    assert_eq!(reads(&native), [TextureOp::Filtered]);
    // Four texels of each of two mip levels.
    assert_eq!(reads(&taps), TAP_BY_TAP);
    for max_taps in [1.0, 2.0, 8.0, 16.0] {
        for class in KernelClass::available() {
            let sorted = differences::<f64>(&native, &taps, class, max_taps);
            assert!(sorted[sorted.len() - 1] < 1e-9, "{} at {max_taps} taps, f64: {}", class.name(), sorted[sorted.len() - 1]);
            // In f32 rounding may add a tap, which then has almost no weight. Coordinates are accurate to 2^-16 of a texel.
            let sorted = differences::<f32>(&native, &taps, class, max_taps);
            assert!(sorted[sorted.len() - 1] < 1e-3, "{} at {max_taps} taps, f32: {}", class.name(), sorted[sorted.len() - 1]);
        }
    }
    // The comparison must be able to fail: the level raised by 0.3, or the taps shifted by half a tap.
    for (shipped, edit) in [("0.5 * log2(kept_sq)", "0.5 * log2(kept_sq) + 0.3"), ("- 0.5 * (taps - 1.0)", "- 0.5 * taps")] {
        assert!(renamed.contains(shipped));
        let sorted = differences::<f64>(&native, &program(&renamed.replace(shipped, edit)), KernelClass::detect(), 8.0);
        assert!(sorted[sorted.len() / 2] > 1e-3, "{edit} is not detected");
    }
}

/// The greatest change of the value from one footprint to the next, while a footprint at a fixed position grows from 1 to 17 widths in steps of a
/// thousandth of its width.
fn greatest_step(program: &Program, width: f64) -> f64 {
    let texture = noise();
    let class = KernelClass::detect();
    let textures = bound(program, &texture, class);
    let values: Vec<[f64; 4]> = (0..16_000 / LANES)
        .flat_map(|k| {
            let footprint = |lane: usize| {
                let major = width * (1.0 + (lane + LANES * k) as f64 / 1000.0);
                Footprint { uv: [0.31, 0.47], major, minor: width, rotation: 0.6, phase: 0.4 }
            };
            batch::<f64>(program, &textures, class, 16.0, footprint)
        })
        .collect();
    let step = |pair: &[[f64; 4]]| (0..4).map(|k| (pair[0][k] - pair[1][k]).abs()).fold(0.0, f64::max);
    values.windows(2).map(step).fold(0.0, f64::max)
}

#[test]
fn an_added_tap_causes_no_jump() {
    // Texels are noise between 0 and 1. A footprint that is longer by a thousandth of its width moves a tap by at most half of that thousandth. The
    // texels of the finer of the two mip levels are at least half as wide as the footprint.
    for width in [1.0, 1.4, 3.0] {
        let step = greatest_step(&program(&format!("{FRAGMENT}{ENTRY}")), width);
        assert!(step < 2e-3, "a step of {step} at a width of {width} texels");
    }
    // The comparison must be able to fail: all taps weigh the same.
    let equal_weights = edited("1.0 - excess * max(1.0 - abs(offset), 0.0)", "reach.length / taps");
    let step = greatest_step(&program(&format!("{equal_weights}{ENTRY}")), 1.0);
    assert!(step > 1e-2, "a jump of {step} is not detected");
}

/// An edited function under its original name, so that only its body differs from the shipped one.
fn edited(shipped: &str, edit: &str) -> String {
    assert!(FRAGMENT.contains(shipped), "{shipped}");
    FRAGMENT.replace(shipped, edit)
}

#[test]
fn an_edited_function_is_not_replaced() {
    let class = KernelClass::detect();
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    for (shipped, edit) in [
        ("0.5 * log2(kept_sq)", "0.5 * log2(kept_sq) + 0.3"),
        ("- 0.5 * (taps - 1.0)", "- 0.5 * taps"),
        ("- 0.01,", "- 0.5,"),
        ("return sum / reach.length", "return 0.5 * sum / reach.length"),
    ] {
        let fragment = edited(shipped, edit);
        let edited_program = program(&format!("{fragment}{ENTRY}"));
        let taps = program(&format!("{fragment}{ENTRY}").replace("filtered_map", "tap_by_tap"));
        assert_eq!(reads(&edited_program), TAP_BY_TAP, "{edit}");
        assert_eq!(differences::<f64>(&edited_program, &taps, class, 8.0).last(), Some(&0.0), "{edit}");
        let sorted = differences::<f64>(&edited_program, &native, class, 8.0);
        assert!(sorted[sorted.len() - 1] > 1e-3, "{edit} is not detected");
    }
    // A statement without a result, such as `discard`, is an edit too.
    let discarding = program(&format!("{}{ENTRY}", edited("let reach =", "if max_taps > 100.0 { discard; }\n    let reach =")));
    assert!(discarding.uses_discard && reads(&discarding) == TAP_BY_TAP);
    let discarding = program(&format!("{}{ENTRY}", edited("return sum / reach.length;", "discard;\n    return sum / reach.length;")));
    assert_eq!(reads(&discarding), TAP_BY_TAP);
}

#[test]
fn a_function_with_other_local_names_or_comments_is_still_replaced() {
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
