//! shaders/lib/filtered_map.wesl on the tape, tap by tap, against the single texture operation that the software renderer substitutes for it, on
//! random footprints.
//!
//! The fragment is lowered twice: unchanged, and with its function renamed, so that the lowering does not recognise it. An edited function is not
//! replaced by that operation.

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
struct Draw { most: f32 }
@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var map: texture_2d<f32>;
@group(0) @binding(8) var map_sampler: sampler;
@fragment fn main(@location(0) uv: vec2f, @location(1) gradients: vec4f) -> @location(0) vec4f {
    return filtered_map(map, map_sampler, uv, gradients.xy, gradients.zw, draw.most);
}";

/// Reads of a module whose filter is not replaced by the native operation: four texels of two levels.
const TAP_BY_TAP: [TextureOp; 8] = [TextureOp::Level; 8];

fn program(wgsl: &str) -> Program {
    let module = naga::front::wgsl::parse_str(wgsl).expect("WGSL");
    let info = orrery::shader::module::validate(&module).expect("valid");
    lower(&module, &info, "main").expect("lowers")
}

fn reads(program: &Program) -> Vec<TextureOp> {
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

/// One batch of random positions and footprints, from magnified to 300 texels long, of any direction and elongation.
fn batch<R: Real>(program: &Program, textures: &Textures<'_>, class: KernelClass, max_taps: f32, batch_index: usize) -> Vec<[f64; 4]> {
    let mut executor = Executor::<R>::with_class(program, class).expect("binds");
    let unit =
        |lane: usize, k: usize| ((lane + LANES * batch_index) as f64 * [0.618_034, 0.754_878, 0.819_173, 0.856_675, 0.880_2][k]).fract();
    for (k, input) in program.inputs.iter().enumerate() {
        for (lane, v) in executor.input_mut(k).iter_mut().enumerate() {
            let (length, ratio) = ((unit(lane, 2) * 11.0 - 3.0).exp2(), (-unit(lane, 3) * 5.0).exp2());
            let (rotation, phase) = (unit(lane, 4) * 6.3, unit(lane, 0) * 6.3);
            // The gradients of a rotated ellipse, in texels; then in map coordinates.
            let ([a, b], [c, d]) =
                ([length * rotation.cos(), length * rotation.sin()], [-length * ratio * rotation.sin(), length * ratio * rotation.cos()]);
            let x = [a * phase.cos() + c * phase.sin(), b * phase.cos() + d * phase.sin()];
            let y = [c * phase.cos() - a * phase.sin(), d * phase.cos() - b * phase.sin()];
            *v = R::from_f64(match input {
                LaneInput::Location { index: 0, component, .. } => 3.0 * unit(lane, *component as usize) - 1.0,
                LaneInput::Location { component, .. } => [x[0] / 256.0, x[1] / 128.0, y[0] / 256.0, y[1] / 128.0][*component as usize],
                other => panic!("{other:?}"),
            });
        }
    }
    executor.run(&program.prepare_for::<R>(&max_taps.to_le_bytes(), class), LaneMask::MAX, textures);
    (0..LANES).map(|lane| std::array::from_fn(|k| executor.output(k)[lane].f64())).collect()
}

/// Differences of all lanes (the largest of the four channels), in ascending order.
fn differences<R: Real>(native: &Program, taps: &Program, class: KernelClass, max_taps: f32) -> Vec<f64> {
    let texture = noise();
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, linear: true };
    let bound = |program: &Program| {
        let texels = Arc::new(Texels::of_texture(&texture).expect("whole"));
        let uses = program.textures.iter().map(|t| BoundTexture { texels: Arc::clone(&texels), sampler: t.sampler_binding.map(|_| state) });
        Textures::new(uses.collect(), class)
    };
    let (native_textures, tap_textures) = (bound(native), bound(taps));
    let mut all: Vec<f64> = (0..16)
        .flat_map(|k| {
            batch::<R>(native, &native_textures, class, max_taps, k).into_iter().zip(batch::<R>(taps, &tap_textures, class, max_taps, k))
        })
        .map(|(a, b)| a.iter().zip(b).fold(0.0, |d: f64, (a, b)| d.max((a - b).abs())))
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn the_operation_equals_the_fragment_tap_by_tap() {
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    let renamed = format!("{FRAGMENT}{ENTRY}").replace("filtered_map", "tap_by_tap");
    let taps = program(&renamed);
    assert_eq!(reads(&native), [TextureOp::Filtered]);
    // Four texels of each of two mip levels.
    assert_eq!(reads(&taps), TAP_BY_TAP);
    for max_taps in [1.0, 2.0, 8.0, 16.0] {
        for class in KernelClass::available() {
            let d = differences::<f64>(&native, &taps, class, max_taps);
            assert!(d[d.len() - 1] < 1e-9, "{} at {max_taps} taps, f64: {}", class.name(), d[d.len() - 1]);
            // In f32 rounding may change the number of taps of a footprint, and coordinates are accurate to 2^-16 of a texel.
            let d = differences::<f32>(&native, &taps, class, max_taps);
            assert!(d[d.len() * 99 / 100] < 1e-3, "{} at {max_taps} taps, f32: {}", class.name(), d[d.len() * 99 / 100]);
        }
    }
    // The comparison must be able to fail: the level raised by 0.3, or the taps shifted by half a tap.
    for (right, wrong) in [("0.5 * log2(kept_sq)", "0.5 * log2(kept_sq) + 0.3"), ("- 0.5 * (reach.taps - 1.0)", "- 0.5 * reach.taps")] {
        assert!(renamed.contains(right));
        let d = differences::<f64>(&native, &program(&renamed.replace(right, wrong)), KernelClass::detect(), 8.0);
        assert!(d[d.len() / 2] > 1e-3, "{wrong} is not detected");
    }
}

/// An edited function under its original name, so that only its body differs from the shipped one.
fn edited(right: &str, wrong: &str) -> String {
    assert!(FRAGMENT.contains(right), "{right}");
    FRAGMENT.replace(right, wrong)
}

#[test]
fn an_edited_function_is_not_replaced() {
    let class = KernelClass::detect();
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    for (right, wrong) in [
        ("0.5 * log2(kept_sq)", "0.5 * log2(kept_sq) + 0.3"),
        ("- 0.5 * (reach.taps - 1.0)", "- 0.5 * reach.taps"),
        ("+ 0.99)", "+ 0.5)"),
        ("return sum / reach.taps", "return 0.5 * sum / reach.taps"),
    ] {
        let fragment = edited(right, wrong);
        let edited_program = program(&format!("{fragment}{ENTRY}"));
        let taps = program(&format!("{fragment}{ENTRY}").replace("filtered_map", "tap_by_tap"));
        assert_eq!(reads(&edited_program), TAP_BY_TAP, "{wrong}");
        assert_eq!(differences::<f64>(&edited_program, &taps, class, 8.0).last(), Some(&0.0), "{wrong}");
        let d = differences::<f64>(&edited_program, &native, class, 8.0);
        assert!(d[d.len() - 1] > 1e-3, "{wrong} is not detected");
    }
    // Statements without a result, such as discard, count as edits too.
    let discarding = program(&format!("{}{ENTRY}", edited("let reach =", "if most > 100.0 { discard; }\n    let reach =")));
    assert!(discarding.uses_discard && reads(&discarding) == TAP_BY_TAP);
    let discarding = program(&format!("{}{ENTRY}", edited("return sum / reach.taps;", "discard;\n    return sum / reach.taps;")));
    assert_eq!(reads(&discarding), TAP_BY_TAP);
}

#[test]
fn names_comments_and_the_module_around_it_change_no_operation() {
    let equivalent = [
        edited("reach", "extent"),
        edited("let first", "// Position of the first tap.\n    let start_of_taps"),
        format!("var<private> unrelated: f32 = 7.5;\n{FRAGMENT}\nfn also(x: f32) -> f32 {{ return x * 2.5 + unrelated; }}"),
    ];
    for fragment in equivalent.map(|f| f.replace("first +", if f.contains("start_of_taps") { "start_of_taps +" } else { "first +" })) {
        assert_eq!(reads(&program(&format!("{fragment}{ENTRY}"))), [TextureOp::Filtered], "{fragment}");
    }
}

/// A planet's module with its map, and the same module with a user's fragment, given by the digest of its file as `view --shaders` does.
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
