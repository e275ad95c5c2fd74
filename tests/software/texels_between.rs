//! Bilinear interpolation by `texels_between` (shaders/lib/texels_between.wesl): the function run as four texel loads per lane, against the single
//! texture operation that the software renderer substitutes for it. Only the unedited function is replaced.

use super::filtered_map::{program, reads};
use crate::support::folds::larger;
use orrery::image::{Level, TexelFormat, Texture};
use orrery::render::software::exec::{Executor, LANES, LaneMask};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::math::Real;
use orrery::render::software::program::{LaneInput, Program};
use orrery::render::software::sample::texels::Texels;
use orrery::render::software::sample::{BoundTexture, Textures};
use orrery::render::software::tape::TextureOp;
use std::sync::Arc;

const FRAGMENT: &str = include_str!("../../shaders/lib/texels_between.wesl");
const ENTRY: &str = "
@group(0) @binding(1) var image: texture_2d<f32>;
@fragment fn main(@location(0) at: vec2f) -> @location(0) vec4f { return texels_between(image, at); }";
/// Width and height of the image in texels; unequal, so that exchanged axes are detected.
const SIZE: [u32; 2] = [37, 21];

/// Noise from 0 to 1 in the given format.
fn noise(format: TexelFormat) -> Texture {
    let mut seed = 7_u32;
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        seed >> 8
    };
    let channels = 4 * SIZE[0] * SIZE[1];
    let bytes = match format {
        TexelFormat::Rgba32Float => (0..channels).flat_map(|_| (next() as f32 / 16_777_216.0).to_le_bytes()).collect(),
        _ => (0..channels).map(|_| (next() >> 16) as u8).collect(),
    };
    Texture { format, levels: vec![Level::new(SIZE[0], SIZE[1], bytes)] }
}

/// How the positions of a batch are spread.
#[derive(Clone, Copy, PartialEq)]
enum Positions {
    /// Over the image and beyond its edges.
    Scattered,
    /// The pixels of a block, so dense that the four pixels of a quad lie between the same four texels.
    Magnified,
}

fn position(positions: Positions, lane: usize, batch: usize) -> [f64; 2] {
    let unit = |k: usize| ((lane + LANES * batch) as f64 * [0.618_034, 0.754_878][k]).fract();
    match positions {
        Positions::Scattered => [unit(0) * 45.0 - 4.0, unit(1) * 29.0 - 4.0],
        Positions::Magnified => {
            // Quads of a block of 16 x 8 pixels; a texel is four pixels wide.
            let (quad, corner) = (lane / 4, lane % 4);
            let pixel = [2 * (quad % 8) + corner % 2, 2 * (quad / 8) + corner / 2];
            [0, 1].map(|axis| (pixel[axis] as f64 + 0.5) / 4.0 + 3.0 * batch as f64 - 2.0)
        }
    }
}

/// Results of one batch of `LANES` lanes. `at`: the position of each lane, in texels. Only lanes whose bit in `active` is set read texels.
fn run<R: Real>(
    program: &Program,
    texture: &Texture,
    class: KernelClass,
    active: LaneMask,
    at: impl Fn(usize) -> [f64; 2],
) -> Vec<[f64; 4]> {
    let texels = Arc::new(Texels::of_texture(texture).expect("complete levels"));
    let uses = program.textures.iter().map(|_| BoundTexture { texels: Arc::clone(&texels), sampler: None });
    let textures = Textures::new(uses.collect(), class);
    let mut executor = Executor::<R>::with_class(program, class).expect("binds");
    for (k, input) in program.inputs.iter().enumerate() {
        let LaneInput::Location { component, .. } = input else { panic!("{input:?}") };
        for (lane, v) in executor.input_mut(k).iter_mut().enumerate() {
            *v = R::from_f64(at(lane)[*component as usize]);
        }
    }
    executor.run(&program.run_draw_tape::<R>(&[], class, &textures), active, &textures);
    (0..LANES).map(|lane| std::array::from_fn(|k| executor.output(k)[lane].to_f64())).collect()
}

fn largest_difference<R: Real>(native: &Program, loads: &Program, format: TexelFormat, class: KernelClass) -> f64 {
    let texture = noise(format);
    let mut largest: f64 = 0.0;
    for (positions, batch) in [Positions::Scattered, Positions::Magnified].into_iter().flat_map(|p| (0..6).map(move |k| (p, k))) {
        let at = |lane: usize| position(positions, lane, batch);
        let (a, b) = (run::<R>(native, &texture, class, LaneMask::MAX, at), run::<R>(loads, &texture, class, LaneMask::MAX, at));
        let differences = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs());
        largest = differences.fold(largest, larger);
    }
    largest
}

const FORMATS: [TexelFormat; 3] = [TexelFormat::Rgba32Float, TexelFormat::Rgba8Unorm, TexelFormat::Rgba8Srgb];

#[test]
fn the_operation_gives_the_values_of_four_loads() {
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    let renamed = format!("{FRAGMENT}{ENTRY}").replace("texels_between", "by_four_loads");
    let loads = program(&renamed);
    assert_eq!(reads(&native), [TextureOp::Bilinear], "not replaced; `cargo test --lib lower::native` says why");
    assert_eq!(reads(&loads), [TextureOp::Load; 4]);
    for (class, format) in KernelClass::available().into_iter().flat_map(|class| FORMATS.map(|format| (class, format))) {
        let difference = largest_difference::<f64>(&native, &loads, format, class);
        assert!(difference < 1e-12, "{} {format:?}, f64: {difference}", class.name());
        // Both paths round four times, and weights and texels are at most 1.
        let difference = largest_difference::<f32>(&native, &loads, format, class);
        assert!(difference < 4.0 * f64::from(f32::EPSILON), "{} {format:?}, f32: {difference}", class.name());
    }
    // The comparison must be able to fail: the weights of the rows exchanged.
    let rows_exchanged = renamed.replace("mix(above, below, weight.y)", "mix(below, above, weight.y)");
    assert!(largest_difference::<f64>(&native, &program(&rows_exchanged), TexelFormat::Rgba32Float, KernelClass::in_use()) > 0.1);
}

#[test]
fn every_kernel_class_gives_the_same_bits() {
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    for format in FORMATS {
        let texture = noise(format);
        for (positions, active) in [(Positions::Scattered, LaneMask::MAX), (Positions::Magnified, 0x0f_ff00_f0f0_ffff_0000_0000_00ff_1234)]
        {
            let of_class = |class| run::<f32>(&native, &texture, class, active, |lane| position(positions, lane, 3));
            let expected = of_class(KernelClass::Portable);
            for class in KernelClass::available() {
                assert!(of_class(class) == expected, "{} {format:?}", class.name());
            }
            let inactive = (0..LANES).filter(|lane| active >> lane & 1 == 0);
            inactive.for_each(|lane| assert_eq!(expected[lane], [0.0; 4], "an inactive lane must stay zero"));
        }
    }
}

#[test]
fn infinite_huge_and_nan_positions_read_values_in_range() {
    let native = program(&format!("{FRAGMENT}{ENTRY}"));
    let texture = noise(TexelFormat::Rgba32Float);
    for class in KernelClass::available() {
        for extreme in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e30, -1e30] {
            let at = |lane: usize| if lane.is_multiple_of(3) { [extreme, 2.5] } else { [4.5, extreme] };
            let result = run::<f32>(&native, &texture, class, LaneMask::MAX, at);
            assert!(result.iter().flatten().all(|v| (0.0..=1.0).contains(v)), "{} {extreme}", class.name());
        }
    }
}

#[test]
fn an_edited_function_is_not_replaced() {
    for (shipped, edit) in [("floor(at)", "floor(at + 0.5)"), ("- vec2i(1)", "- vec2i(2)"), ("mix(above, below, weight.y)", "above")] {
        assert!(FRAGMENT.contains(shipped), "{shipped}");
        let edited = program(&format!("{}{ENTRY}", FRAGMENT.replace(shipped, edit)));
        let reads = reads(&edited);
        assert!(!reads.is_empty() && reads.iter().all(|op| *op == TextureOp::Load), "{edit}: {reads:?}");
    }
}
