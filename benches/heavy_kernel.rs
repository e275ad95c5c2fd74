//! The software renderer's tape against a shader written by hand for AVX2: median CPU time of each and median ratio over all rounds. All draw the same image
//! on one thread of one process, in turns. Where the machine has AVX-512, a shader written by hand for AVX-512 draws, too: its time shows what this processor
//! gains by AVX-512, without the tape.
//!
//! `cargo bench --bench heavy_kernel`. Prints the times of the shaders by hand, one line per kernel class, then the times of the tone map.

#[cfg(target_arch = "x86_64")]
#[path = "heavy/by_hand.rs"]
mod by_hand;
#[path = "heavy/mod.rs"]
mod heavy;

/// The largest difference of a channel between two images of linear light; NaN where either has one.
#[cfg(target_arch = "x86_64")]
fn largest_difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let differences = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
    // NaN stays: no number is at most NaN, so the comparison alone would replace it by the next difference.
    differences.fold(0.0, |largest: f32, d: f32| if largest.is_nan() || d <= largest { largest } else { d })
}

#[cfg(not(target_arch = "x86_64"))]
fn main() {
    println!("the shader written by hand is for x86-64");
}

#[cfg(target_arch = "x86_64")]
fn main() {
    use heavy::{WGSL, cpu_seconds, map, median, module, plan, simple_module, tone_map_plan};
    use orrery::FrameImages;
    use orrery::render::software::kernels::KernelClass;
    use orrery::render::software::{Options, Precision, SoftwareRenderer};

    if !KernelClass::available().contains(&KernelClass::Avx2Fma) {
        return println!("this machine has no AVX2 and FMA");
    }
    /// Width and height of the image in pixels.
    const SIZE: usize = 1024;
    const ROUNDS: usize = 11;
    /// Largest accepted difference of a channel between two shaders. It covers rounding, and the different polynomials of atan2.
    const TOLERANCE: f32 = 2e-3;
    let texture = map();
    let decoded = |v: u8| orrery::units::srgb_to_linear(f64::from(v) / 255.0) as f32;
    let linear = texture.levels[0].bytes().chunks_exact(4).map(|t| [decoded(t[0]), decoded(t[1]), decoded(t[2]), 1.0]).collect();
    let [width, height] = [texture.levels[0].width, texture.levels[0].height].map(|side| side as i32);
    let texels = by_hand::Texels { width, height, linear };
    let (plan, module) = (plan(SIZE as u32), module(WGSL));
    // `cargo bench --bench heavy_kernel -- avx2` measures one class alone.
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let classes: Vec<_> =
        KernelClass::available().into_iter().filter(|c| wanted.is_empty() || wanted.iter().any(|w| w == c.name())).collect();
    let renderers: Vec<_> = classes
        .iter()
        .map(|c| {
            SoftwareRenderer::new(Options { threads: 1, kernel_class: *c, precision: Precision::F32, ..Options::default() })
                .expect("a renderer")
        })
        .collect();
    let mut by_hand_image = vec![[0f32; 4]; SIZE * SIZE];
    let mut by_hand_avx512_image = by_hand_image.clone();
    let mut hand_avx2_s = Vec::new();
    let has_avx512 = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq");
    let mut hand_avx512_s = Vec::new();
    let mut tape_s = vec![Vec::new(); classes.len()];
    for _ in 0..ROUNDS {
        let start = cpu_seconds();
        // SAFETY: AVX2 and FMA were found above; the size is a multiple of 8.
        unsafe { by_hand::avx2::draw(SIZE, &texels, &mut by_hand_image) };
        hand_avx2_s.push(cpu_seconds() - start);
        if has_avx512 {
            let start = cpu_seconds();
            // SAFETY: AVX-512 was found above; the size is a multiple of 16.
            unsafe { by_hand::avx512::draw(SIZE, &texels, &mut by_hand_avx512_image) };
            hand_avx512_s.push(cpu_seconds() - start);
            let worst = largest_difference(&by_hand_avx512_image, &by_hand_image);
            assert!(worst < TOLERANCE, "the two shaders by hand draw different images: {worst}");
        }
        for (renderer, times) in renderers.iter().zip(&mut tape_s) {
            let start = cpu_seconds();
            let (frame, _) = renderer.render(&plan, &module, FrameImages::DisplayAndHdr).expect("draws");
            times.push(cpu_seconds() - start);
            let worst = largest_difference(&frame.hdr, &by_hand_image);
            assert!(worst < TOLERANCE, "the two draw different images: {worst}");
        }
    }
    println!("by hand, AVX2: {:.1} ms", 1e3 * median(hand_avx2_s.clone()));
    if has_avx512 {
        let ratio = median(hand_avx512_s.iter().zip(&hand_avx2_s).map(|(t, h)| t / h).collect());
        println!("by hand, AVX-512: {:.1} ms, {ratio:.2} times the shader by hand for AVX2", 1e3 * median(hand_avx512_s));
    }
    for (class, times) in classes.iter().zip(&tape_s) {
        let ratio = median(times.iter().zip(&hand_avx2_s).map(|(t, h)| t / h).collect());
        println!("tape, {}: {:.1} ms, {ratio:.2} times the shader by hand for AVX2", class.name(), 1e3 * median(times.clone()));
    }
    let (plan, module) = (tone_map_plan(SIZE as u32), simple_module("tone_map"));
    for class in &classes {
        // A separate renderer, because a renderer caches modules by name.
        let renderer = SoftwareRenderer::new(Options { threads: 1, kernel_class: *class, precision: Precision::F32, ..Options::default() })
            .expect("a renderer");
        let times = (0..ROUNDS).map(|_| {
            let start = cpu_seconds();
            renderer.render(&plan, &module, FrameImages::Display).expect("draws");
            cpu_seconds() - start
        });
        println!("tone map, {}: {:.1} ms", class.name(), 1e3 * median(times.collect()));
    }
}
