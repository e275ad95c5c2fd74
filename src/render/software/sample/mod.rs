//! Samples textures for the executor, batch by batch.
//!
//! In: the textures of a draw, and the coordinates of a batch's lanes. Out: up to four linear channels per lane.
//!
//! [`texels`] borrows and decodes texels, [`footprint`] chooses levels and taps, [`filter`] interpolates (`filter_avx2`: f32 with AVX2), `texel_load` reads
//! single texels, and `texels_between` interpolates between the four texels around a position. [`Textures`] binds textures to the texture uses of one
//! program and samples them with the kernels of one instruction set (a kernel class). docs/map-filter.md lists the edits for another filter of maps.
//! Interpolation weights have the type of the lanes, f32 or f64; texels are decoded to f32, exact to f32 rounding.
//!
//! Texels are kept as the texture stores them, 4 bytes each in a map (16 in a table of floats), and are decoded when read: a map of 8192x4096 takes
//! 179 MB with its mip levels, whereas half floats or 16-bit integers would take 358 MB and f32 716 MB. Decoding sRGB with a table of 1 kB costs
//! three loads per texel. `texels::gather` loads the texels of eight lanes with one gather instruction, on machines that have one. Every class gives
//! the same bits.

#[cfg(target_arch = "x86_64")]
mod corners;
pub mod filter;
#[cfg(target_arch = "x86_64")]
mod filter_avx2;
pub mod footprint;
mod lane_order;
mod texel_load;
pub mod texels;
mod texels_between;

use super::exec::{Gradients, LaneMask, TextureUnit};
use super::kernels::KernelClass;
use super::math::Real;
use crate::image::TexelFormat;
use crate::render::plan::{AddressMode, SamplerState};
use filter::{BATCH, Channels, sample};
use footprint::FilterRequest;
use std::sync::Arc;
use texel_load::{TexelCoordinates, load};
use texels::{BoundLevel, Decode, Float, Srgb, Texels, Unorm};

/// A texture bound to one texture use of a program.
#[derive(Clone, Debug)]
pub struct BoundTexture<'a> {
    pub texels: Arc<Texels<'a>>,
    /// `None` for uses without a sampler.
    pub sampler: Option<SamplerState>,
}

/// The textures of one draw, in the order of the program's texture uses.
#[derive(Clone, Debug)]
pub struct Textures<'a> {
    bound: Vec<BoundTexture<'a>>,
    class: KernelClass,
}

/// For samples of a texture that is bound without a sampler.
const DEFAULT_SAMPLER: SamplerState =
    SamplerState { address_u: AddressMode::ClampToEdge, address_v: AddressMode::ClampToEdge, is_trilinear: true };

/// What a batch asks of a sampler: texture coordinates, and what determines the mip levels. A [`FilterRequest`] has the levels themselves.
#[derive(Clone, Copy)]
struct Request<'a, R> {
    /// Texture coordinates, one per lane: 0 to 1 across the texture.
    u: &'a [R],
    v: &'a [R],
    level_source: LevelSource<'a, R>,
    active: LaneMask,
}

/// What determines the mip level of each lane.
#[derive(Clone, Copy)]
enum LevelSource<'a, R> {
    /// The level itself.
    Explicit(&'a [R]),
    /// The longer of each lane's two gradients.
    Isotropic(Gradients<'a, R>),
    /// The footprint of the gradients, and the maximum number of taps, one per lane or one for all lanes. Only `filtered_map` of
    /// shaders/lib/filtered_map.wesl reads like this.
    Anisotropic(Gradients<'a, R>, &'a [R]),
}

/// The values as a full batch; fewer values are copied to `buffer` and padded with zeros.
#[inline(always)]
fn full_batch<'a, R: Real>(values: &'a [R], buffer: &'a mut Option<[R; BATCH]>) -> &'a [R; BATCH] {
    if let Some(values) = values.first_chunk() {
        return values;
    }
    let buffer = buffer.insert([R::ZERO; BATCH]);
    buffer[..values.len()].copy_from_slice(values);
    buffer
}

/// Filters a batch: computes its levels and footprints ([`FilterRequest`]), then calls [`filter::sample`].
#[inline(always)]
fn filter_batch<R: Real, D: Decode>(
    decode: D,
    levels: &[BoundLevel<'_>],
    state: &SamplerState,
    request: Request<'_, R>,
    out: Channels<'_, R>,
) {
    // Buffers that pad a partial batch to all lanes. A request has either levels or gradients, so that the levels and du/dx share a buffer. The buffers are
    // separate variables, because an array of buffers would be zeroed at each call.
    let (mut u, mut v, mut level_or_du_dx, mut dv_dx, mut du_dy, mut dv_dy, mut taps) = (None, None, None, None, None, None, None);
    // Whether every lane has at most one tap: anisotropic filtering then gives the same level as isotropic filtering.
    let has_one_tap = |max_taps: &[R]| max_taps.iter().fold(true, |all, taps| all & (*taps <= R::ONE));
    let mut filter_request = FilterRequest::new(full_batch(request.u, &mut u), full_batch(request.v, &mut v));
    match request.level_source {
        LevelSource::Explicit(level) => filter_request.level = Some(*full_batch(level, &mut level_or_du_dx)),
        LevelSource::Isotropic(g) | LevelSource::Anisotropic(g, _) => {
            let size = [levels[0].width, levels[0].height];
            let max_taps = match request.level_source {
                LevelSource::Anisotropic(_, max_taps) if !has_one_tap(max_taps) => Some(match max_taps {
                    [shared] => &*taps.insert([*shared; BATCH]),
                    _ => full_batch(max_taps, &mut taps),
                }),
                _ => None,
            };
            let gradients = [
                full_batch(g.du_dx, &mut level_or_du_dx),
                full_batch(g.dv_dx, &mut dv_dx),
                full_batch(g.du_dy, &mut du_dy),
                full_batch(g.dv_dy, &mut dv_dy),
            ];
            filter_request.set_footprints(size, gradients, max_taps);
        }
    }
    sample(decode, levels, &filter_request, state, request.active, out);
}

/// Calls `fill` with channels of `BATCH` lanes. If `out` has fewer lanes, they receive a copy of the first lanes that `fill` writes.
#[inline(always)]
fn write_batch<R: Real>(out: [&mut [R]; 4], fill: impl FnOnce(Channels<'_, R>)) {
    if out.iter().all(|lanes| lanes.is_empty() || lanes.len() >= BATCH) {
        return fill(out.map(|lanes| lanes.first_chunk_mut()));
    }
    let mut batch = [[R::ZERO; BATCH]; 4];
    fill(batch.each_mut().map(Some));
    for (out, lanes) in out.into_iter().zip(&batch) {
        let count = out.len().min(BATCH);
        out[..count].copy_from_slice(&lanes[..count]);
    }
}

/// The sampling functions, compiled for one kernel class. The expression `$decoder` makes this class's decoder from the portable decoder `$decode`.
macro_rules! functions_of_class {
    ($name:ident, $decode:ident => $decoder:expr, $(#[$feature:meta])*) => {
        mod $name {
            use super::*;

            /// # Safety
            /// The instruction set of this class is available.
            $(#[$feature])*
            pub unsafe fn filtered<R: Real, D: Decode>(
                $decode: D, levels: &[BoundLevel<'_>], state: &SamplerState, request: Request<'_, R>, out: Channels<'_, R>,
            ) {
                filter_batch($decoder, levels, state, request, out);
            }

            /// # Safety
            /// As for `filtered`.
            $(#[$feature])*
            pub unsafe fn load_texels<R: Real, D: Decode>(
                $decode: D, levels: &[BoundLevel<'_>], coordinates: TexelCoordinates<'_, R>, active: LaneMask, out: [&mut [R]; 4],
            ) {
                load($decoder, levels, coordinates, active, out);
            }

            /// # Safety
            /// As for `filtered`.
            $(#[$feature])*
            pub unsafe fn texels_between<R: Real, D: Decode>(
                $decode: D, levels: &[BoundLevel<'_>], position: [&[R; BATCH]; 2], active: LaneMask, out: Channels<'_, R>,
            ) {
                super::texels_between::interpolate($decoder, levels, position, active, out);
            }
        }
    };
}

functions_of_class!(portable, decode => decode,);
#[cfg(target_arch = "x86_64")]
functions_of_class!(avx2, decode => {
    // SAFETY: functions of this class are called only on machines with AVX2.
    unsafe { decode.avx2() }
}, #[target_feature(enable = "avx2,fma")]);
#[cfg(target_arch = "x86_64")]
functions_of_class!(avx512, decode => {
    // SAFETY: functions of this class are called only on machines with AVX-512, which have AVX2, too.
    unsafe { decode.avx2() }
}, #[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma")]);
#[cfg(target_arch = "aarch64")]
functions_of_class!(neon, decode => decode, #[target_feature(enable = "neon")]);

/// The variant of a function that is compiled for a kernel class; [`Textures::new`] has checked that the machine can run it.
macro_rules! for_class {
    ($class:expr, $function:ident::<$r:ty, $d:ty>) => {
        match $class {
            #[cfg(target_arch = "x86_64")]
            KernelClass::Avx512 => avx512::$function::<$r, $d>,
            #[cfg(target_arch = "x86_64")]
            KernelClass::Avx2Fma => avx2::$function::<$r, $d>,
            #[cfg(target_arch = "aarch64")]
            KernelClass::Neon => neon::$function::<$r, $d>,
            _ => portable::$function::<$r, $d>,
        }
    };
}

impl<'a> Textures<'a> {
    /// Textures that are sampled in a kernel class. A class that this machine lacks is replaced by the portable class.
    pub fn new(bound: Vec<BoundTexture<'a>>, class: KernelClass) -> Self {
        let class = if KernelClass::available().contains(&class) { class } else { KernelClass::Portable };
        Self { bound, class }
    }

    fn sample<R: Real>(&self, texture: usize, request: Request<'_, R>, out: [&mut [R]; 4]) {
        let bound = &self.bound[texture];
        match bound.texels.format {
            TexelFormat::Rgba8Srgb => self.sample_decoded(bound, Srgb::new(), request, out),
            TexelFormat::Rgba8Unorm => self.sample_decoded(bound, Unorm, request, out),
            TexelFormat::Rgba32Float => self.sample_decoded(bound, Float, request, out),
        }
    }

    /// [`TextureUnit::load_bilinear`] for a texture with this decoder.
    fn texels_between_decoded<R: Real, D: Decode>(
        &self,
        bound: &BoundTexture<'_>,
        decode: D,
        [x, y]: [&[R]; 2],
        active: LaneMask,
        out: [&mut [R]; 4],
    ) {
        let (mut buffer_x, mut buffer_y) = (None, None);
        let position = [full_batch(x, &mut buffer_x), full_batch(y, &mut buffer_y)];
        let run = for_class!(self.class, texels_between::<R, D>);
        // SAFETY: `new` has checked that this machine has the class.
        write_batch(out, |out| unsafe { run(decode, &bound.texels.levels, position, active, out) });
    }

    /// [`Self::sample`] for a texture with this decoder. Without active lanes `out` stays as it is.
    fn sample_decoded<R: Real, D: Decode>(&self, bound: &BoundTexture<'_>, decode: D, request: Request<'_, R>, out: [&mut [R]; 4]) {
        let state = bound.sampler.unwrap_or(DEFAULT_SAMPLER);
        let count = request.u.len().min(BATCH);
        // The lanes that the request has.
        let existing_lanes = if count == BATCH { LaneMask::MAX } else { (1 << count) - 1 };
        let request = Request { active: request.active & existing_lanes, ..request };
        if request.active == 0 {
            return;
        }
        let run = for_class!(self.class, filtered::<R, D>);
        // SAFETY: `new` has checked that this machine has the class.
        write_batch(out, |out| unsafe { run(decode, &bound.texels.levels, &state, request, out) });
    }
}

impl<R: Real> TextureUnit<R> for Textures<'_> {
    fn sample_gradients(&self, texture: usize, u: &[R], v: &[R], g: Gradients<'_, R>, active: LaneMask, out: [&mut [R]; 4]) {
        self.sample(texture, Request { u, v, level_source: LevelSource::Isotropic(g), active }, out);
    }

    fn sample_filtered(&self, texture: usize, uv: [&[R]; 2], g: Gradients<'_, R>, max_taps: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        self.sample(texture, Request { u: uv[0], v: uv[1], level_source: LevelSource::Anisotropic(g, max_taps), active }, out);
    }

    fn sample_level(&self, texture: usize, u: &[R], v: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        self.sample(texture, Request { u, v, level_source: LevelSource::Explicit(level), active }, out);
    }

    fn load_bilinear(&self, texture: usize, position: [&[R]; 2], active: LaneMask, out: [&mut [R]; 4]) {
        let bound = &self.bound[texture];
        match bound.texels.format {
            TexelFormat::Rgba8Srgb => self.texels_between_decoded(bound, Srgb::new(), position, active, out),
            TexelFormat::Rgba8Unorm => self.texels_between_decoded(bound, Unorm, position, active, out),
            TexelFormat::Rgba32Float => self.texels_between_decoded(bound, Float, position, active, out),
        }
    }

    fn load(&self, texture: usize, x: &[R], y: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        let Texels { format, levels } = &*self.bound[texture].texels;
        let coordinates = [x, y, level];
        // SAFETY: `new` has checked that this machine has the class.
        unsafe {
            match format {
                TexelFormat::Rgba8Srgb => for_class!(self.class, load_texels::<R, Srgb>)(Srgb::new(), levels, coordinates, active, out),
                TexelFormat::Rgba8Unorm => for_class!(self.class, load_texels::<R, Unorm>)(Unorm, levels, coordinates, active, out),
                TexelFormat::Rgba32Float => for_class!(self.class, load_texels::<R, Float>)(Float, levels, coordinates, active, out),
            }
        }
    }

    fn dimensions(&self, texture: usize, level: u32) -> [u32; 2] {
        let levels = &self.bound[texture].texels.levels;
        let level = &levels[(level as usize).min(levels.len() - 1)];
        [level.width, level.height]
    }

    fn levels(&self, texture: usize) -> u32 {
        self.bound[texture].texels.levels.len() as u32
    }
}
