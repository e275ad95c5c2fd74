//! Texture filtering against its definition in f64, and with extreme coordinates and gradients; the same bits in every kernel class.

use crate::support::folds::larger;
use orrery::image::{Level, TexelFormat, Texture};
use orrery::render::plan::{AddressMode, SamplerState};
use orrery::render::software::exec::{Gradients, TextureUnit};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::math::Real;
use orrery::render::software::sample::texels::Texels;
use orrery::render::software::sample::{BoundTexture, Textures};
use std::sync::Arc;

const REPEAT: SamplerState = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };

/// A noise texture with a mip chain of 2 x 2 means; both sides must be powers of two.
fn noise(width: u32, height: u32) -> Texture {
    let mut seed = 11_u64;
    let mut level: Vec<[f32; 4]> = (0..width * height)
        .map(|_| {
            std::array::from_fn(|_| {
                seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (seed >> 40) as f32 / (1u64 << 24) as f32
            })
        })
        .collect();
    let (mut w, mut h) = (width, height);
    let mut levels = Vec::new();
    loop {
        levels.push(Level::new(w, h, level.iter().flatten().flat_map(|v| v.to_le_bytes()).collect()));
        if w == 1 && h == 1 {
            return Texture { format: TexelFormat::Rgba32Float, levels };
        }
        let (half_w, half_h) = ((w / 2).max(1), (h / 2).max(1));
        level = (0..half_w * half_h)
            .map(|i| {
                let (x, y) = (i % half_w, i / half_w);
                let at = |dx: u32, dy: u32| level[(((y * h / half_h) + dy.min(h - 1)) * w + (x * w / half_w) + dx.min(w - 1)) as usize];
                std::array::from_fn(|k| 0.25 * (at(0, 0)[k] + at(1, 0)[k] + at(0, 1)[k] + at(1, 1)[k]))
            })
            .collect();
        (w, h) = (half_w, half_h);
    }
}

fn bind(texture: &Texture, sampler: SamplerState) -> Textures<'_> {
    bind_in(texture, sampler, KernelClass::in_use())
}

pub(super) fn bind_in(texture: &Texture, sampler: SamplerState, class: KernelClass) -> Textures<'_> {
    Textures::new(
        vec![BoundTexture { texels: Arc::new(Texels::of_texture(texture).expect("complete levels")), sampler: Some(sampler) }],
        class,
    )
}

/// Samples at each position, one lane each, with gradients `dx` and `dy` = (du, dv) along x and y; isotropic.
fn sample<R: Real>(textures: &Textures<'_>, uv: &[[f64; 2]], dx: [f64; 2], dy: [f64; 2]) -> Vec<[f64; 4]> {
    sample_filtered::<R>(textures, uv, dx, dy, None)
}

/// Like [`sample`], with at most `max_taps` taps along the footprint.
fn sample_filtered<R: Real>(textures: &Textures<'_>, uv: &[[f64; 2]], dx: [f64; 2], dy: [f64; 2], max_taps: Option<f64>) -> Vec<[f64; 4]> {
    let lanes = |f: &dyn Fn(usize) -> f64| (0..uv.len()).map(|k| R::from_f64(f(k))).collect::<Vec<R>>();
    let (u, v) = (lanes(&|k| uv[k][0]), lanes(&|k| uv[k][1]));
    let (du_dx, dv_dx, du_dy, dv_dy) = (lanes(&|_| dx[0]), lanes(&|_| dx[1]), lanes(&|_| dy[0]), lanes(&|_| dy[1]));
    let mut out = [u.clone(), u.clone(), u.clone(), u.clone()];
    let [r, g, b, a] = &mut out;
    let gradients = Gradients { du_dx: &du_dx, dv_dx: &dv_dx, du_dy: &du_dy, dv_dy: &dv_dy };
    match max_taps {
        Some(max_taps) => textures.sample_filtered(0, [&u, &v], gradients, &lanes(&|_| max_taps), u128::MAX, [r, g, b, a]),
        None => textures.sample_gradients(0, &u, &v, gradients, u128::MAX, [r, g, b, a]),
    }
    (0..uv.len()).map(|k| std::array::from_fn(|c| out[c][k].to_f64())).collect()
}

/// Bilinear filtering by its definition: the four texels around the position with tent weights; u is periodic, v is clamped.
fn tent(level: &Level, u: f64, v: f64, component: usize) -> f64 {
    let (w, h) = (i64::from(level.width), i64::from(level.height));
    let (x, y) = (u * w as f64 - 0.5, v * h as f64 - 0.5);
    let mut sum = 0.0;
    for i in x.floor() as i64..=x.floor() as i64 + 1 {
        for j in y.floor() as i64..=y.floor() as i64 + 1 {
            let weight = (1.0 - (x - i as f64).abs()).max(0.0) * (1.0 - (y - j as f64).abs()).max(0.0);
            let at = ((j.clamp(0, h - 1) * w + i.rem_euclid(w)) * 16) as usize + component * 4;
            sum += weight * f64::from(f32::from_le_bytes(level.bytes()[at..at + 4].try_into().expect("four bytes")));
        }
    }
    sum
}

fn positions(count: usize) -> Vec<[f64; 2]> {
    // Low-discrepancy steps: u over three periods, v beyond both edges.
    (0..count).map(|k| [(k as f64 * 0.618_033_988_75) % 1.0 * 3.0 - 1.0, (k as f64 * 0.754_877_666) % 1.0 * 1.2 - 0.1]).collect()
}

/// Trilinear filtering by its definition: a linear mixture of the two nearest of the existing levels.
fn trilinear(texture: &Texture, [u, v]: [f64; 2], level: f64, component: usize) -> f64 {
    let last = texture.levels.len() - 1;
    let level = level.clamp(0.0, last as f64);
    let (finer, fraction) = (level.floor() as usize, level.fract());
    let [of_finer, of_coarser] = [finer, (finer + 1).min(last)].map(|level| tent(&texture.levels[level], u, v, component));
    of_finer + fraction * (of_coarser - of_finer)
}

/// The greatest difference between sampled values and the definition. `level_of`: the level that a lane reads.
fn greatest_error(texture: &Texture, uv: &[[f64; 2]], sampled: &[[f64; 4]], level_of: impl Fn(usize) -> f64) -> f64 {
    let error = |lane: usize, c: usize| (sampled[lane][c] - trilinear(texture, uv[lane], level_of(lane), c)).abs();
    (0..uv.len()).flat_map(|lane| [0, 1, 2, 3].map(|c: usize| error(lane, c))).reduce(larger).expect("lanes")
}

/// The error of sampling by isotropic gradients, for pixels that span this many texels.
fn error_by_gradients<R: Real>(class: KernelClass, texels_per_px: f64) -> f64 {
    let (texture, uv) = (noise(64, 32), positions(100));
    let (dx, dy) = ([texels_per_px / 64.0, 0.0], [0.0, texels_per_px / 32.0]);
    let sampled = sample::<R>(&bind_in(&texture, REPEAT, class), &uv, dx, dy);
    greatest_error(&texture, &uv, &sampled, |_| texels_per_px.log2())
}

/// The error of reading given levels, one for each lane of a batch, as `textureSampleLevel` does. `expected_of`: the levels that the definition reads.
fn error_by_level<R: Real>(class: KernelClass, level_of: fn(usize) -> f64, expected_of: impl Fn(usize) -> f64) -> f64 {
    let (texture, uv) = (noise(64, 32), positions(128));
    let lanes = |f: &dyn Fn(usize) -> f64| (0..uv.len()).map(|k| R::from_f64(f(k))).collect::<Vec<R>>();
    let (u, v, level) = (lanes(&|k| uv[k][0]), lanes(&|k| uv[k][1]), lanes(&level_of));
    let mut out = [u.clone(), u.clone(), u.clone(), u.clone()];
    let [r, g, b, a] = &mut out;
    bind_in(&texture, REPEAT, class).sample_level(0, &u, &v, &level, u128::MAX, [r, g, b, a]);
    let sampled: Vec<[f64; 4]> = (0..uv.len()).map(|k| std::array::from_fn(|c| out[c][k].to_f64())).collect();
    greatest_error(&texture, &uv, &sampled, expected_of)
}

/// f32 coordinates in a map of 64 texels are accurate to 2^-17 texel.
const F32_ERROR: f64 = 3e-5;
const F64_ERROR: f64 = 1e-12;

#[test]
fn bilinear_and_trilinear_match_the_definition() {
    for class in KernelClass::available() {
        let name = class.name();
        for texels_per_px in [0.01, 0.5, 1.0, 1.3, 2.0, 2.9, 7.0, 31.0, 1000.0] {
            let [single, double] = [error_by_gradients::<f32>(class, texels_per_px), error_by_gradients::<f64>(class, texels_per_px)];
            assert!(single < F32_ERROR, "{name}, f32 at {texels_per_px} texels per pixel: {single}");
            assert!(double < F64_ERROR, "{name}, f64 at {texels_per_px} texels per pixel: {double}");
        }
        // Levels that differ between lanes, also beyond the finest and the coarsest one, 6; then levels that all lanes share.
        let levels: [fn(usize) -> f64; 5] = [|lane| lane as f64 * 0.377 % 8.0 - 0.7, |_| 0.0, |_| 0.25, |_| 2.7, |_| 6.5];
        for (k, level_of) in levels.into_iter().enumerate() {
            let [single, double] = [error_by_level::<f32>(class, level_of, level_of), error_by_level::<f64>(class, level_of, level_of)];
            assert!(single < F32_ERROR, "{name}, f32, levels {k}: {single}");
            assert!(double < F64_ERROR, "{name}, f64, levels {k}: {double}");
        }
        // The comparison must be able to fail: the levels raised by a hundredth.
        let of_raised = error_by_level::<f64>(class, levels[0], |lane| levels[0](lane) + 0.01);
        assert!(of_raised > 1e-3, "{name}: other levels are not detected: {of_raised}");
    }
}

#[test]
fn a_different_mip_level_is_detected() {
    let texture = noise(64, 32);
    let uv = [[0.3, 0.4]];
    let finest = sample::<f64>(&bind(&texture, REPEAT), &uv, [1.0 / 64.0, 0.0], [0.0, 1.0 / 32.0]);
    let next = sample::<f64>(&bind(&texture, REPEAT), &uv, [2.0 / 64.0, 0.0], [0.0, 2.0 / 32.0]);
    assert!((finest[0][0] - next[0][0]).abs() > 1e-3);
}

/// Mean and contrast (mean absolute deviation) of stripes two texels wide at a grazing angle: a pixel spans 16 texels along the stripes (v) and one
/// across them (u).
fn stripe_contrast(taps: f64) -> (f64, f64) {
    let mut texture = noise(64, 64);
    for level in &mut texture.levels {
        let w = level.width;
        let texel = |i: usize| {
            if w == 64 {
                (i as u32 % w % 4 / 2) as f32
            } else if w == 32 {
                (i as u32 % 2) as f32
            } else {
                0.5
            }
        };
        *level = Level::new(w, level.height, (0..(w * w) as usize).flat_map(|i| [texel(i); 4]).flat_map(f32::to_le_bytes).collect());
    }
    let uv: Vec<_> = (0..64).map(|k| [(f64::from(k) + 0.5) / 64.0, 0.5]).collect();
    let sampled = sample_filtered::<f32>(&bind(&texture, REPEAT), &uv, [1.0 / 64.0, 0.0], [0.0, 16.0 / 64.0], Some(taps));
    let mean = sampled.iter().map(|p| p[0]).sum::<f64>() / 64.0;
    (mean, sampled.iter().map(|p| (p[0] - mean).abs()).sum::<f64>() / 64.0)
}

#[test]
fn anisotropic_taps_keep_stripes_at_a_grazing_angle_and_their_mean() {
    let (mean_1, contrast_1) = stripe_contrast(1.0);
    let (mean_16, contrast_16) = stripe_contrast(16.0);
    assert!((mean_1 - 0.5).abs() < 1e-6 && (mean_16 - 0.5).abs() < 1e-6, "{mean_1} {mean_16}");
    assert!(contrast_1 < 1e-6, "isotropic filtering must blur the stripes away: {contrast_1}");
    assert!((contrast_16 - 0.5).abs() < 1e-3, "16 taps must keep them: {contrast_16}");
}

#[test]
fn exchanged_gradients_have_the_same_footprint() {
    // The major axis is along (1, 1) in texels. Exchanged gradients, one of them with the opposite sign, describe the same ellipse.
    let texture = noise(64, 64);
    let uv = positions(50).into_iter().map(|[u, v]| [u, 0.3 + 0.3 * v]).collect::<Vec<_>>();
    let (along, across) = ([5.0 / 64.0, 5.0 / 64.0], [0.7 / 64.0, -0.7 / 64.0]);
    let a = sample_filtered::<f64>(&bind(&texture, REPEAT), &uv, along, across, Some(8.0));
    let b = sample_filtered::<f64>(&bind(&texture, REPEAT), &uv, across, along.map(|v| -v), Some(8.0));
    for (p, q) in a.iter().zip(&b) {
        assert!(p.iter().zip(q).all(|(x, y)| (x - y).abs() < 1e-9));
    }
}

#[test]
fn a_constant_texture_stays_constant_for_any_gradients() {
    let texture = Texture {
        format: TexelFormat::Rgba8Srgb,
        levels: [(4, 2), (2, 1), (1, 1)].map(|(w, h)| Level::new(w, h, [188, 0, 255, 128].repeat((w * h) as usize))).to_vec(),
    };
    let extremes = [f64::NAN, f64::INFINITY, -1e30, 1e30, 0.0, -0.0, 1.0, 1e-40];
    let uv: Vec<_> = extremes.iter().flat_map(|u| extremes.map(|v| [*u, v])).collect();
    for is_trilinear in [false, true] {
        for max_taps in [None, Some(1.0), Some(16.0), Some(f64::NAN), Some(1e9)] {
            let textures = bind(&texture, SamplerState { is_trilinear, ..REPEAT });
            for gradient in extremes {
                for p in sample_filtered::<f32>(&textures, &uv, [gradient, 0.0], [0.3, gradient], max_taps) {
                    // 188 in sRGB is 0.5028865 linear (IEC 61966-2-1).
                    assert!((p[0] - 0.502_886_5).abs() < 1e-6, "{p:?} at gradient {gradient}");
                    assert!(p[1] == 0.0 && (p[2] - 1.0).abs() < 1e-6 && (p[3] - 128.0 / 255.0).abs() < 1e-6, "{p:?}");
                }
            }
        }
    }
}

/// Samples `count` lanes from the lane `first` on; each has its own position and footprint. Lanes that are not written keep 7.
fn sample_varied_lanes<R: Real>(textures: &Textures<'_>, max_taps: f64, first: usize, count: usize, active: u128) -> [Vec<R>; 4] {
    let lanes = |f: &dyn Fn(f64) -> f64| (first..first + count).map(|k| R::from_f64(f(k as f64))).collect::<Vec<R>>();
    let (u, v) = (lanes(&|k| k * 0.618 % 3.0 - 1.0), lanes(&|k| k * 0.754 % 1.2 - 0.1));
    let (du_dx, dv_dx) = (lanes(&|k| f64::exp2(k * 0.37 % 9.0 - 8.0)), lanes(&|k| (k * 0.11).sin() * 0.02));
    let (du_dy, dv_dy) = (lanes(&|k| (k * 0.23).cos() * 0.03), lanes(&|k| f64::exp2(k * 0.53 % 7.0 - 7.0)));
    let mut out = [const { Vec::new() }; 4].map(|_: Vec<R>| vec![R::from_f64(7.0); count]);
    let [r, g, b, a] = &mut out;
    let gradients = Gradients { du_dx: &du_dx, dv_dx: &dv_dx, du_dy: &du_dy, dv_dy: &dv_dy };
    textures.sample_filtered(0, [&u, &v], gradients, &lanes(&|_| max_taps), active, [r, g, b, a]);
    out
}

fn bits<R: Real>(v: R) -> u64 {
    v.to_f64().to_bits()
}

fn assert_lanes_are_independent<R: Real>(texture: &Texture, state: SamplerState, max_taps: f64) {
    let textures = bind(texture, state);
    let all = sample_varied_lanes::<R>(&textures, max_taps, 0, 128, u128::MAX);
    for class in KernelClass::available() {
        let other = sample_varied_lanes::<R>(&bind_in(texture, state, class), max_taps, 0, 128, u128::MAX);
        for k in 0..4 {
            assert!(all[k].iter().zip(&other[k]).all(|(a, b)| bits(*a) == bits(*b)), "{} differs in channel {k}", class.name());
        }
    }
    let mask = 0xdead_beef_0000_0001_8000_5555_1234_ffff_u128;
    let masked = sample_varied_lanes::<R>(&textures, max_taps, 0, 128, mask);
    for lane in 0..128 {
        let alone = sample_varied_lanes::<R>(&textures, max_taps, lane, 1, 1);
        for k in 0..4 {
            assert_eq!(bits(all[k][lane]), bits(alone[k][0]), "lane {lane} alone, channel {k}");
            if mask >> lane & 1 == 1 {
                assert_eq!(bits(all[k][lane]), bits(masked[k][lane]), "lane {lane} with a mask, channel {k}");
            }
        }
    }
    assert!((1..128).any(|k| bits(all[0][k]) != bits(all[0][0])), "the lanes must not all be the same");
}

#[test]
fn a_lane_depends_neither_on_other_lanes_nor_on_the_kernel_class() {
    let float = noise(256, 128);
    let bytes: Vec<u8> = (0..256 * 128 * 4_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let srgb = Texture::from_rgba8(256, 128, bytes, TexelFormat::Rgba8Srgb).expect("complete levels");
    for (is_trilinear, max_taps) in [(false, 1.0), (true, 1.0), (true, 8.0), (true, 16.0)] {
        let state = SamplerState { is_trilinear, ..REPEAT };
        assert_lanes_are_independent::<f32>(&srgb, state, max_taps);
        assert_lanes_are_independent::<f32>(&float, state, max_taps);
        assert_lanes_are_independent::<f64>(&srgb, state, max_taps);
    }
}

/// Samples lanes with one footprint: `width` texels along u, a quarter of that along v. `max_taps`: one value, or one per lane.
fn sample_one_footprint(
    textures: &Textures<'_>,
    width: f64,
    max_taps: &[f32],
    lanes: std::ops::Range<usize>,
    active: u128,
) -> [Vec<f32>; 4] {
    let of_lanes = |f: &dyn Fn(f64) -> f64| lanes.clone().map(|k| f(k as f64) as f32).collect::<Vec<f32>>();
    let (u, v) = (of_lanes(&|k| k * 0.618 % 3.0 - 1.0), of_lanes(&|k| k * 0.754 % 1.2 - 0.1));
    let (du_dx, dv_dy, zero) = (of_lanes(&|_| width / 64.0), of_lanes(&|_| 0.25 * width / 32.0), of_lanes(&|_| 0.0));
    let mut out = [const { Vec::new() }; 4].map(|_: Vec<f32>| vec![7.0; lanes.len()]);
    let [r, g, b, a] = &mut out;
    let gradients = Gradients { du_dx: &du_dx, dv_dx: &zero, du_dy: &zero, dv_dy: &dv_dy };
    textures.sample_filtered(0, [&u, &v], gradients, max_taps, active, [r, g, b, a]);
    out
}

/// Batches whose lanes share a mip level, or read only the finest, take faster code paths. Each lane gets the value that it gets alone.
#[test]
fn lanes_that_share_a_footprint_get_the_values_of_each_alone() {
    let same = |a: f32, b: f32| a.to_bits() == b.to_bits();
    for texture in of_each_format() {
        let mut of_widths = Vec::new();
        for (width, taps) in [0.2, 0.7, 1.0, 1.7, 2.0, 5.3, 1e4].into_iter().flat_map(|width| [1.0, 8.0].map(|taps| (width, taps))) {
            let portable = bind_in(&texture, REPEAT, KernelClass::Portable);
            let alone: Vec<_> = (0..128).map(|k| sample_one_footprint(&portable, width, &[taps], k..k + 1, 1)).collect();
            for class in KernelClass::available() {
                let textures = bind_in(&texture, REPEAT, class);
                let one_inactive = u128::MAX ^ 1 << 77;
                for (max_taps, active) in [(&[taps][..], u128::MAX), (&[taps; 128], u128::MAX), (&[taps], one_inactive)] {
                    let all = sample_one_footprint(&textures, width, max_taps, 0..128, active);
                    for (lane, alone) in alone.iter().enumerate().filter(|(lane, _)| active >> lane & 1 == 1) {
                        let agrees = all.iter().zip(alone).all(|(all, alone)| same(all[lane], alone[0]));
                        assert!(agrees, "{}: lane {lane}, {width} texels, {taps} taps", class.name());
                    }
                    assert!(active == u128::MAX || all.iter().all(|channel| same(channel[77], 7.0)), "an inactive lane was written");
                }
            }
            of_widths.push(alone[5][0][0]);
        }
        // One tap, and footprints 0.2, 0.7 and 5.3 texels wide.
        assert!(
            same(of_widths[0], of_widths[2]) && !same(of_widths[0], of_widths[10]),
            "levels differ only where a pixel spans several texels"
        );
    }
}

/// A texture of each format.
fn of_each_format() -> [Texture; 3] {
    let bytes: Vec<u8> = (0..64 * 32 * 4_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let texture_of = |format| Texture::from_rgba8(64, 32, bytes.clone(), format).expect("complete levels");
    [texture_of(TexelFormat::Rgba8Srgb), texture_of(TexelFormat::Rgba8Unorm), noise(64, 32)]
}

#[test]
fn a_channel_does_not_depend_on_the_other_requested_channels() {
    let lanes = |f: &dyn Fn(f64) -> f64| (0..128).map(|k| f32::from_f64(f(f64::from(k)))).collect::<Vec<f32>>();
    let (u, v) = (lanes(&|k| k * 0.618 % 3.0 - 1.0), lanes(&|k| k * 0.754 % 1.2 - 0.1));
    let (a, b) = (lanes(&|k| f64::exp2(k * 0.37 % 6.0 - 6.0)), lanes(&|k| (k * 0.11).sin() * 0.02));
    let ints = |f: &dyn Fn(u32) -> u32| (0..128).map(|k| f32::from_lane_bits(f(k))).collect::<Vec<f32>>();
    let (x, y, level) = (ints(&|k| k * 37 % 64), ints(&|k| k * 11 % 32), ints(&|_| 0));
    let gradients = Gradients { du_dx: &a, dv_dx: &b, du_dy: &b, dv_dy: &a };
    for texture in of_each_format() {
        for class in KernelClass::available() {
            let textures = bind_in(&texture, REPEAT, class);
            // Lanes of channels that are not requested keep 7.
            let read_channels = |channels: u32, operation: u32| {
                let mut out = [const { Vec::new() }; 4].map(|_: Vec<f32>| vec![7.0; 128]);
                let mut k = 0;
                let slices = out.each_mut().map(|lanes| {
                    k += 1;
                    if channels >> (k - 1) & 1 == 1 { &mut lanes[..] } else { &mut [] }
                });
                match operation {
                    0 => textures.sample_gradients(0, &u, &v, gradients, u128::MAX >> 5, slices),
                    1 => textures.sample_filtered(0, [&u, &v], gradients, &[8.0; 128], u128::MAX, slices),
                    _ => textures.load(0, &x, &y, &level, u128::MAX, slices),
                }
                out
            };
            for operation in 0..3 {
                let all = read_channels(0b1111, operation);
                assert!(all.iter().all(|channel| channel.iter().any(|v| *v != 7.0)));
                for channels in 0..16 {
                    let some = read_channels(channels, operation);
                    for (k, (some, all)) in some.iter().zip(&all).enumerate() {
                        let same = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
                        let expected: &[f32] = if channels >> k & 1 == 1 { all } else { &[7.0; 128] };
                        assert!(same(some, expected), "{}, operation {operation}, channels {channels:04b}: {k}", class.name());
                    }
                }
            }
        }
    }
}

#[test]
fn loads_are_the_same_in_every_class_and_number_of_lanes() {
    for texture in of_each_format() {
        let read = |class: KernelClass, first: u32, count: u32| {
            let ints = |f: &dyn Fn(u32) -> u32| (first..first + count).map(|k| f32::from_lane_bits(f(k))).collect::<Vec<_>>();
            let (x, y, level) = (ints(&|k| k * 37 % 64), ints(&|k| k * 11 % 32), ints(&|_| 0));
            let mut out = [const { Vec::new() }; 4].map(|_: Vec<f32>| vec![7.0; count as usize]);
            let [r, g, b, a] = &mut out;
            bind_in(&texture, REPEAT, class).load(0, &x, &y, &level, u128::MAX, [r, g, b, a]);
            out
        };
        let alone: Vec<[u32; 4]> =
            (0..128).map(|k| read(KernelClass::Portable, k, 1)).map(|out| out.each_ref().map(|c| c[0].to_bits())).collect();
        assert!(alone.windows(2).any(|w| w[0] != w[1]), "the texels must differ");
        for class in KernelClass::available() {
            for count in [1, 7, 8, 13, 128] {
                let out = read(class, 0, count);
                for (k, expected) in alone.iter().enumerate().take(count as usize) {
                    assert_eq!(out.each_ref().map(|c| c[k].to_bits()), *expected, "{} of {count} lanes, lane {k}", class.name());
                }
            }
        }
    }
}

#[test]
fn loads_outside_read_zero() {
    let texture = noise(8, 4);
    let textures = bind(&texture, REPEAT);
    let ints = |v: &[i32]| v.iter().map(|i| f32::from_lane_bits(*i as u32)).collect::<Vec<_>>();
    let (x, y, level) = (ints(&[3, -1, 8, 0, 3, 3]), ints(&[1, 0, 0, 4, 1, 1]), ints(&[0, 0, 0, 0, 1, 9]));
    let mut out = [const { [9.0_f32; 6] }; 4];
    let [r, g, b, a] = &mut out;
    textures.load(0, &x, &y, &level, u128::MAX, [r, g, b, a]);
    let texel = |level: usize, i: usize| f32::from_le_bytes(texture.levels[level].bytes()[i * 16..i * 16 + 4].try_into().expect("four"));
    assert_eq!(out[0], [texel(0, 11), 0.0, 0.0, 0.0, texel(1, 7), 0.0]);
    assert_eq!(TextureUnit::<f32>::dimensions(&textures, 0, 1), [4, 2]);
    assert_eq!(TextureUnit::<f32>::levels(&textures, 0), 4);
}

#[test]
fn a_level_of_the_wrong_size_is_refused() {
    let mut texture = noise(8, 4);
    texture.levels[1] = Level::new(4, 2, vec![0; 4 * 2 * 16 - 1]);
    let error = Texels::of_texture(&texture).expect_err("a byte is missing");
    assert!(error.contains("level 1"), "{error}");
    texture.levels.clear();
    assert!(Texels::of_texture(&texture).is_err());
}
