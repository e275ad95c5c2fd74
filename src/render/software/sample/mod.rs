//! Texture sampling: what the executor asks of its textures, batch by batch.
//!
//! [`texels`] borrows and decodes, [`footprint`] chooses levels and taps, [`filter`] weighs them, [`Textures`] binds them to the texture
//! uses of one program and runs them in a kernel class. Weights are of the lanes' own type; texels are f32, exact to f32 rounding.
//!
//! Texels stay as the map has them, 4 bytes each, and are decoded when read: a map of 8192x4096 then takes 179 MB with its mip levels, where
//! half floats or 16-bit integers would take 358 MB and f32 716 MB, and sRGB by a table of 1 kB costs three loads a texel. `texels::gather` has the loads of eight lanes
//! in one instruction, where there is one.
//! Every class gives the same bits.

pub mod filter;
pub mod footprint;
pub mod texels;

use super::exec::{Gradients, LaneMask, TextureUnit};
use super::kernels::KernelClass;
use super::math::Real;
use crate::image::TexelFormat;
use crate::render::plan::{AddressMode, SamplerState};
use filter::{Channels, FilterRequest, MOST, sample};
use std::sync::Arc;
use texels::{Decode, Float, Srgb, TexelLevel, Texels, Unorm};

/// One texture use of a program, bound.
#[derive(Clone, Debug)]
pub struct BoundTexture<'a> {
    pub texels: Arc<Texels<'a>>,
    /// None for uses without a sampler.
    pub sampler: Option<SamplerState>,
}

/// The textures of one draw, in the order of the program's texture uses.
#[derive(Clone, Debug)]
pub struct Textures<'a> {
    bound: Vec<BoundTexture<'a>>,
    class: KernelClass,
}

const PLAIN: SamplerState = SamplerState { address_u: AddressMode::ClampToEdge, address_v: AddressMode::ClampToEdge, linear: true };

/// A batch's coordinates and how their levels are to be found.
#[derive(Clone, Copy)]
struct Request<'a, R> {
    u: &'a [R],
    v: &'a [R],
    levels: Levels<'a, R>,
    active: LaneMask,
}

#[derive(Clone, Copy)]
enum Levels<'a, R> {
    Given(&'a [R]),
    Of(Gradients<'a, R>),
    /// With several taps, at most these.
    Along(Gradients<'a, R>, &'a [R]),
}

/// A batch's values, in `room` where they are fewer than a whole batch's.
#[inline(always)]
fn whole<'a, R: Real>(values: &'a [R], room: &'a mut Option<[R; MOST]>) -> &'a [R; MOST] {
    if let Some(values) = values.first_chunk() {
        return values;
    }
    let room = room.insert([R::ZERO; MOST]);
    room[..values.len()].copy_from_slice(values);
    room
}

#[inline(always)]
fn batch<R: Real, D: Decode>(decode: D, levels: &[TexelLevel<'_>], state: &SamplerState, request: Request<'_, R>, out: Channels<'_, R>) {
    let [room_u, room_v, room_0, room_1, room_2, room_3, room_most] = &mut [const { None }; 7];
    let mut wanted = FilterRequest::new(whole(request.u, room_u), whole(request.v, room_v));
    match request.levels {
        Levels::Given(level) => wanted.level = *whole(level, room_0),
        Levels::Of(g) | Levels::Along(g, _) => {
            let size = [levels[0].width, levels[0].height];
            let g = [whole(g.du_dx, room_0), whole(g.dv_dx, room_1), whole(g.du_dy, room_2), whole(g.dv_dy, room_3)];
            let most = if let Levels::Along(_, most) = request.levels { Some(whole(most, room_most)) } else { None };
            wanted.footprints(size, g, most);
        }
    }
    sample(decode, levels, &wanted, state, request.active, out);
}

macro_rules! class {
    ($name:ident, $decode:ident => $how:expr, $(#[$feature:meta])*) => {
        mod $name {
            use super::*;

            /// # Safety
            /// The instruction set of this class is available.
            $(#[$feature])*
            pub unsafe fn filtered<R: Real, D: Decode>(
                $decode: D, levels: &[TexelLevel<'_>], state: &SamplerState, request: Request<'_, R>, out: Channels<'_, R>,
            ) {
                batch($how, levels, state, request, out);
            }

            /// # Safety
            /// As above.
            $(#[$feature])*
            pub unsafe fn single<R: Real, D: Decode>(
                $decode: D, levels: &[TexelLevel<'_>], place: Place<'_, R>, active: LaneMask, out: [&mut [R]; 4],
            ) {
                load($how, levels, place, active, out);
            }
        }
    };
}

class!(plain, decode => decode,);
#[cfg(target_arch = "x86_64")]
class!(avx2, decode => {
    // SAFETY: whoever calls this class has AVX2.
    unsafe { decode.gathering() }
}, #[target_feature(enable = "avx2,fma")]);
#[cfg(target_arch = "x86_64")]
class!(avx512, decode => {
    // SAFETY: as above.
    unsafe { decode.gathering() }
}, #[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma")]);
#[cfg(target_arch = "aarch64")]
class!(neon, decode => decode, #[target_feature(enable = "neon")]);

/// The function of a class, of those that [`Textures::new`] keeps.
macro_rules! of_class {
    ($class:expr, $function:ident::<$r:ty, $d:ty>) => {
        match $class {
            #[cfg(target_arch = "x86_64")]
            KernelClass::Avx512 => avx512::$function::<$r, $d>,
            #[cfg(target_arch = "x86_64")]
            KernelClass::Avx2Fma => avx2::$function::<$r, $d>,
            #[cfg(target_arch = "aarch64")]
            KernelClass::Neon => neon::$function::<$r, $d>,
            _ => plain::$function::<$r, $d>,
        }
    };
}

impl<'a> Textures<'a> {
    /// Bound textures, sampled in a class that this machine has (another one falls back to plain code).
    pub fn new(bound: Vec<BoundTexture<'a>>, class: KernelClass) -> Self {
        let class = if KernelClass::available().contains(&class) { class } else { KernelClass::Portable };
        Self { bound, class }
    }

    fn sample<R: Real>(&self, texture: usize, request: Request<'_, R>, out: [&mut [R]; 4]) {
        let bound = &self.bound[texture];
        match bound.texels.format {
            TexelFormat::Rgba8Srgb => self.decoded(bound, Srgb::new(), request, out),
            TexelFormat::Rgba8Unorm => self.decoded(bound, Unorm, request, out),
            TexelFormat::Rgba32Float => self.decoded(bound, Float, request, out),
        }
    }

    fn decoded<R: Real, D: Decode>(&self, bound: &BoundTexture<'_>, decode: D, request: Request<'_, R>, out: [&mut [R]; 4]) {
        let state = bound.sampler.unwrap_or(PLAIN);
        let count = request.u.len().min(MOST);
        let there = if count == MOST { LaneMask::MAX } else { (1 << count) - 1 };
        let request = Request { active: request.active & there, ..request };
        if request.active == 0 {
            return;
        }
        let run = of_class!(self.class, filtered::<R, D>);
        let run_into = |out: Channels<'_, R>| {
            // SAFETY: `new` keeps only classes that this machine has.
            unsafe { run(decode, &bound.texels.levels, &state, request, out) }
        };
        if out.iter().all(|lanes| lanes.is_empty() || lanes.len() >= MOST) {
            return run_into(out.map(|lanes| lanes.first_chunk_mut()));
        }
        let mut filtered = [[R::ZERO; MOST]; 4];
        run_into(filtered.each_mut().map(Some));
        for (out, filtered) in out.into_iter().zip(&filtered) {
            let count = count.min(out.len());
            out[..count].copy_from_slice(&filtered[..count]);
        }
    }
}

/// Writes one lane.
#[inline(always)]
fn put<R: Real, D: Decode>(decode: D, stored: D::Texel, lane: usize, out: [&mut [R]; 4]) {
    for (to, channel) in out.into_iter().zip(decode.channels(stored)) {
        if let Some(to) = to.get_mut(lane) {
            *to = R::from_f32_bits(channel.to_bits());
        }
    }
}

/// Integer coordinates and level of single texels.
type Place<'a, R> = [&'a [R]; 3];

/// Single texels by integer coordinates.
#[inline(always)]
fn load<R: Real, D: Decode>(decode: D, levels: &[TexelLevel<'_>], place: Place<'_, R>, active: LaneMask, out: [&mut [R]; 4]) {
    let [x, y, level] = place;
    let count = x.len().min(MOST);
    let [r, g, b, a] = out;
    let (x, y, level) = (&x[..count], &y[..count], &level[..count]);
    // Where every lane lies inside level 0 there is no more to ask. Negative integers are large ones here.
    let (width, height) = (levels[0].width, levels[0].height);
    let mut inside = true;
    for i in 0..count {
        inside &= (x[i].int() < width) & (y[i].int() < height) & (level[i].int() == 0);
    }
    if inside {
        // Without branches, so that many reads are under way at once: they wait for memory more than anything.
        let eights = count / 8 * 8;
        for lanes in (0..eights).step_by(8).map(|k| k..k + 8) {
            let mut index = [0; 8];
            for ((index, x), y) in index.iter_mut().zip(&x[lanes.clone()]).zip(&y[lanes.clone()]) {
                *index = y.int().wrapping_mul(width).wrapping_add(x.int());
            }
            // SAFETY: tested above.
            let texels = unsafe { decode.eight(&levels[0], &index) };
            for (to, texels) in [&mut *r, &mut *g, &mut *b, &mut *a].into_iter().zip(&texels) {
                let Some(to) = to.get_mut(lanes.clone()).and_then(|to| to.first_chunk_mut::<8>()) else { continue };
                for (to, texel) in to.iter_mut().zip(texels) {
                    *to = R::from_f32_bits(texel.to_bits());
                }
            }
        }
        for lane in eights..count {
            // SAFETY: tested above.
            let stored = unsafe { decode.stored(&levels[0], y[lane].int().wrapping_mul(width).wrapping_add(x[lane].int())) };
            put(decode, stored, lane, [&mut *r, &mut *g, &mut *b, &mut *a]);
        }
        return;
    }
    for lane in 0..count {
        let (x, y) = (x[lane].int(), y[lane].int());
        let stored = match levels.get(level[lane].int() as usize) {
            // SAFETY: both lie inside the level.
            Some(at) if active >> lane & 1 == 1 && x < at.width && y < at.height => unsafe { decode.stored(at, y * at.width + x) },
            // What lies outside reads as zero, and zero bytes are zero in every format.
            _ => D::Texel::default(),
        };
        put(decode, stored, lane, [&mut *r, &mut *g, &mut *b, &mut *a]);
    }
}

impl<R: Real> TextureUnit<R> for Textures<'_> {
    fn sample_gradients(&self, texture: usize, u: &[R], v: &[R], g: Gradients<'_, R>, active: LaneMask, out: [&mut [R]; 4]) {
        self.sample(texture, Request { u, v, levels: Levels::Of(g), active }, out);
    }

    fn sample_filtered(&self, texture: usize, place: [&[R]; 2], g: Gradients<'_, R>, most: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        self.sample(texture, Request { u: place[0], v: place[1], levels: Levels::Along(g, most), active }, out);
    }

    fn sample_level(&self, texture: usize, u: &[R], v: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        self.sample(texture, Request { u, v, levels: Levels::Given(level), active }, out);
    }

    fn load(&self, texture: usize, x: &[R], y: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        let Texels { format, levels } = &*self.bound[texture].texels;
        let place = [x, y, level];
        // SAFETY: `new` keeps only classes that this machine has.
        unsafe {
            match format {
                TexelFormat::Rgba8Srgb => of_class!(self.class, single::<R, Srgb>)(Srgb::new(), levels, place, active, out),
                TexelFormat::Rgba8Unorm => of_class!(self.class, single::<R, Unorm>)(Unorm, levels, place, active, out),
                TexelFormat::Rgba32Float => of_class!(self.class, single::<R, Float>)(Float, levels, place, active, out),
            }
        }
    }

    fn dimensions(&self, texture: usize, level: u32) -> [u32; 2] {
        let levels = &self.bound[texture].texels.levels;
        let at = &levels[(level as usize).min(levels.len() - 1)];
        [at.width, at.height]
    }

    fn levels(&self, texture: usize) -> u32 {
        self.bound[texture].texels.levels.len() as u32
    }
}
