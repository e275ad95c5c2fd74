//! The tone map's shader on the tape against its formula in f64 with the exact sRGB curve, for every kernel class and over a wide range of brightness.

use orrery::render::software::exec::{Executor, Gradients, LANES, LaneMask, TextureUnit};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::lower::lower;
use orrery::render::software::program::{LaneInput, Program};
use orrery::shader::emit::emit_module;

/// Half a level of the eight-bit image is 2e-3; the error of f32 arithmetic stays below this bound.
const TOLERANCE: f64 = 1.5e-6;

fn program() -> Program {
    let id = "tone_map".parse().expect("a simple module");
    let module = naga::front::wgsl::parse_str(&emit_module(&id).expect("emitted").wgsl).expect("WGSL");
    let info = orrery::shader::module::validate(&module).expect("valid");
    lower(&module, &info, "fragment_main").expect("lowers")
}

/// A texture that returns these texels lane by lane, whatever the coordinates.
struct Image([[f32; LANES]; 3]);

impl TextureUnit<f32> for Image {
    fn sample_gradients(&self, _: usize, _: &[f32], _: &[f32], _: Gradients<'_, f32>, _: LaneMask, _: [&mut [f32]; 4]) {
        unreachable!("the tone map only loads texels");
    }
    fn sample_level(&self, _: usize, _: &[f32], _: &[f32], _: &[f32], _: LaneMask, _: [&mut [f32]; 4]) {
        unreachable!("the tone map only loads texels");
    }
    fn load_bilinear(&self, _: usize, _: [&[f32]; 2], _: LaneMask, _: [&mut [f32]; 4]) {
        unreachable!("the tone map only loads texels");
    }
    fn load(&self, _: usize, _: &[f32], _: &[f32], _: &[f32], _: LaneMask, out: [&mut [f32]; 4]) {
        let [r, g, b, a] = out;
        for (to, from) in [r, g, b].into_iter().zip(&self.0) {
            to.copy_from_slice(from);
        }
        a.fill(1.0);
    }
    fn dimensions(&self, _: usize, _: u32) -> [u32; 2] {
        [LANES as u32, 1]
    }
    fn levels(&self, _: usize) -> u32 {
        1
    }
}

/// Runs one batch of 128 pixels along a row, with the radiance of each lane by channel.
fn run_batch(program: &Program, class: KernelClass, radiance: [[f32; LANES]; 3], row: u32, exposure: f32) -> [[f32; LANES]; 4] {
    let linear_limit = 0.8;
    let uniform_bytes: Vec<u8> = [exposure, linear_limit].iter().flat_map(|v| v.to_le_bytes()).collect();
    let mut executor = Executor::<f32>::with_class(program, class).expect("binds");
    for (k, input) in program.inputs.iter().enumerate() {
        for (i, v) in executor.input_mut(k).iter_mut().enumerate() {
            *v = match input {
                LaneInput::FragCoord { component: 0 } => i as f32 + 0.5,
                LaneInput::FragCoord { component: 1 } => row as f32 + 0.5,
                _ => 0.0,
            };
        }
    }
    let image = Image(radiance);
    executor.run(&program.run_draw_tape(&uniform_bytes, class, &image), LaneMask::MAX, &image);
    [0, 1, 2, 3].map(|k| *executor.output(k))
}

/// The formula of shaders/lib/display.wesl at the linear limit 0.8, with the exponent of the sRGB curve as an argument.
fn formula(radiance: [f64; 3], exponent: f64) -> [f64; 3] {
    let colour = radiance.map(|c| c.clamp(0.0, 1.0e6));
    let peak = colour.iter().fold(1.0e-12, |a: f64, b| a.max(*b));
    let mapped = if peak <= 0.8 { peak } else { 1.0 - 0.04 / (peak - 0.6) };
    let whiteness = 1.0 - 1.0 / (0.15 * (peak - mapped) + 1.0);
    colour.map(|c| {
        let linear = c * mapped / peak * (1.0 - whiteness) + mapped * whiteness;
        if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(exponent) - 0.055 }
    })
}

/// Colours from 1e-5, deep in the linear part of the sRGB curve, to 1000, far above white.
fn colours(batch: usize) -> [[f32; LANES]; 3] {
    [3, 17, 29].map(|step: usize| {
        std::array::from_fn(|i| {
            let t = ((batch * LANES + i) * step * 7919 % 100_003) as f32 / 100_003.0;
            10.0_f32.powf(8.0 * t - 5.0)
        })
    })
}

/// The greatest difference from the formula with this exponent.
fn greatest_error(class: KernelClass, exponent: f64) -> f64 {
    let program = program();
    let exposure = 0.75;
    let mut worst = 0.0_f64;
    for batch in 0..200 {
        let radiance = colours(batch);
        let out = run_batch(&program, class, radiance, 3, exposure);
        for i in 0..LANES {
            let exact = formula([0, 1, 2].map(|c| f64::from(radiance[c][i] * exposure)), exponent);
            for c in 0..3 {
                worst = worst.max((f64::from(out[c][i]) - exact[c]).abs());
            }
            // `max` would ignore NaN.
            assert!((0..3).all(|c| out[c][i].is_finite()), "{radiance:?}", radiance = radiance.map(|channel| channel[i]));
            assert_eq!(out[3][i], 1.0);
        }
    }
    worst
}

#[test]
fn the_tone_map_agrees_with_its_formula() {
    for class in KernelClass::available() {
        let error = greatest_error(class, 1.0 / 2.4);
        println!("{}: {error:.2e}", class.name());
        assert!(error < TOLERANCE, "{}: {error}", class.name());
    }
    assert!(greatest_error(KernelClass::Portable, 1.0 / 2.4 + 1e-5) > TOLERANCE, "a wrong exponent must be detected");
}

#[test]
fn black_negative_and_infinite_light_stay_in_range() {
    let program = program();
    let tone_mapped = |v: f32| run_batch(&program, KernelClass::in_use(), [[v; LANES]; 3], 0, 1.0)[0][0];
    assert_eq!((tone_mapped(0.0), tone_mapped(-1.0)), (0.0, 0.0));
    for v in [1e6, 1e30, f32::INFINITY] {
        assert!((tone_mapped(v) - 1.0).abs() < 1e-6, "{v}: {}", tone_mapped(v));
    }
}
