//! Times parts of the software renderer, for development: `cargo test --test main software::speed -- --ignored --nocapture`. Nothing is asserted. Each
//! time is the minimum of many short rounds on one thread: other load on the machine affects the minimum least.

use super::sampling::bind_in;
use orrery::image::{TexelFormat, Texture};
use orrery::render::plan::{AddressMode, SamplerState};
use orrery::render::software::exec::{Gradients, LANES, TextureUnit};
use orrery::render::software::kernels::{KernelClass, Kernels};
use orrery::render::software::math::Real;
use orrery::render::software::tape::Op;
use std::hint::black_box;
use std::time::Instant;

/// The mask of active lanes.
const ALL_LANES: u128 = u128::MAX;
const ROUNDS: usize = 60;
/// Size of the map, texels.
const WIDTH: u32 = 2048;
const HEIGHT: u32 = 1024;

/// Nanoseconds per call in the fastest round. `work` gets the number of the call.
fn best_ns_per_call(calls: usize, mut work: impl FnMut(usize)) -> f64 {
    (0..ROUNDS).fold(f64::INFINITY, |best_ns, _| {
        let start = Instant::now();
        (0..calls).for_each(&mut work);
        best_ns.min(start.elapsed().as_secs_f64() * 1e9 / calls as f64)
    })
}

fn map() -> Texture {
    let rgba = (0..WIDTH * HEIGHT).flat_map(|i| [(i % 251) as u8, (i / WIDTH % 253) as u8, (i % 17 * 15) as u8, 255]).collect();
    Texture::from_rgba8(WIDTH, HEIGHT, rgba, TexelFormat::Rgba8Srgb).expect("complete levels")
}

fn sampling<R: Real>(texture: &Texture, class: KernelClass) {
    let state = |is_trilinear| SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear };
    // `dx` and `dy`: texels per pixel along x and y.
    for (filter, sampler, max_taps, dx, dy) in [
        ("nearest", state(false), 1.0, 0.7, 0.7),
        ("bilinear", state(true), 1.0, 0.7, 0.7),
        ("trilinear", state(true), 1.0, 1.5, 1.5),
        ("8 taps, ratio 1", state(true), 8.0, 1.5, 1.5),
        ("8 taps, ratio 2", state(true), 8.0, 3.0, 1.5),
        ("8 taps, ratio 8", state(true), 8.0, 12.0, 1.5),
    ] {
        let textures = bind_in(texture, sampler, class);
        // 8 x 8 blocks of 16 x 8 pixels; the lanes of a block are ordered by quads, as in the rasteriser.
        let uv = |block: usize, lane: usize| {
            let (quad, corner) = (lane / 4, lane % 4);
            let x = block % 8 * 16 + quad % 8 * 2 + corner % 2;
            let y = block / 8 * 8 + quad / 8 * 2 + corner / 2;
            [0.1 + dx * x as f64 / f64::from(WIDTH), 0.1 + dy * y as f64 / f64::from(HEIGHT)]
        };
        let blocks: Vec<[[R; LANES]; 2]> =
            (0..64).map(|block| [0, 1].map(|axis: usize| std::array::from_fn(|lane| R::from_f64(uv(block, lane)[axis])))).collect();
        let gradients =
            [[dx / f64::from(WIDTH), 0.0], [0.0, dy / f64::from(HEIGHT)]].map(|gradient| gradient.map(|v| [R::from_f64(v); LANES]));
        let max_taps = [R::from_f64(max_taps)];
        let mut out = [[R::ZERO; LANES]; 4];
        let ns = best_ns_per_call(blocks.len(), |block| {
            let [r, g, b, a] = &mut out;
            let [[du_dx, dv_dx], [du_dy, dv_dy]] = &gradients;
            let gradients = Gradients { du_dx, dv_dx, du_dy, dv_dy };
            textures.sample_filtered(0, [&blocks[block][0], &blocks[block][1]], gradients, &max_taps, ALL_LANES, [r, g, b, a]);
            black_box(&out);
        });
        println!("{:8} {:>4} {filter:22} {:7.1} ns per lane", class.name(), std::any::type_name::<R>(), ns / LANES as f64);
    }
}

#[test]
#[ignore = "prints times"]
fn texture_filters() {
    let texture = map();
    for class in KernelClass::available() {
        sampling::<f32>(&texture, class);
    }
    sampling::<f64>(&texture, KernelClass::available()[0]);
}

#[test]
#[ignore = "prints times"]
fn kernels_of_one_batch() {
    for class in KernelClass::available() {
        for op in [Op::Mul, Op::Fma, Op::Div, Op::Exp, Op::Log2, Op::Pow, Op::Sin, Op::Atan2, Op::Floor] {
            let run = f32::generic(class, op);
            let mut out = [0.0_f32; LANES];
            let lanes_from = |from: f32| std::array::from_fn::<f32, LANES, _>(|k| from + k as f32 / 128.0);
            let operands = [lanes_from(0.01), lanes_from(0.4), lanes_from(0.2)].concat();
            let offsets = [0, LANES as u32, 2 * LANES as u32];
            // SAFETY: the class is available and every operand has LANES lanes.
            let ns = best_ns_per_call(1000, |_| unsafe {
                run(&mut out, operands.as_ptr(), offsets.as_ptr());
                black_box(&out);
            });
            println!("{:8} {op:?}: {:6.2} ns per lane", class.name(), ns / LANES as f64);
        }
    }
}
