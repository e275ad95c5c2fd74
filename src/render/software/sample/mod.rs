//! Texture sampling: what the executor asks of its textures, batch by batch.
//!
//! [`texels`] borrows and decodes, [`filter`] chooses taps and weighs them, [`Textures`] binds both to the texture uses of one program.
//! Weights are of the lanes' own type; texels are f32, as stored.

pub mod filter;
pub mod texels;

use super::exec::{Gradients, LaneMask, TextureUnit};
use super::math::Real;
use crate::image::TexelFormat;
use crate::render::plan::{AddressMode, SamplerState};
use filter::{Footprint, footprint, sample};
use std::sync::Arc;
use texels::{Decode, Float, Srgb, Texels, Unorm};

/// One texture use of a program, bound.
#[derive(Clone, Debug)]
pub struct Bound<'a> {
    pub texels: Arc<Texels<'a>>,
    /// None for uses without a sampler.
    pub sampler: Option<SamplerState>,
}

/// The textures of one draw, in the order of the program's texture uses.
#[derive(Clone, Debug, Default)]
pub struct Textures<'a>(pub Vec<Bound<'a>>);

const PLAIN: SamplerState =
    SamplerState { address_u: AddressMode::ClampToEdge, address_v: AddressMode::ClampToEdge, linear: true, anisotropy: 1 };

fn lanes(active: LaneMask, count: usize) -> impl Iterator<Item = usize> {
    let mut left = active;
    std::iter::from_fn(move || {
        (left != 0).then(|| {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            lane
        })
    })
    .take_while(move |lane| *lane < count)
}

impl Bound<'_> {
    fn each<R: Real>(&self, u: &[R], v: &[R], active: LaneMask, out: [&mut [R]; 4], of: impl Fn(usize, &SamplerState) -> Footprint<R>) {
        let state = self.sampler.unwrap_or(PLAIN);
        match self.texels.format {
            TexelFormat::Rgba8Srgb => self.run(Srgb::new(), &state, u, v, active, out, of),
            TexelFormat::Rgba8Unorm => self.run(Unorm, &state, u, v, active, out, of),
            TexelFormat::Rgba32Float => self.run(Float, &state, u, v, active, out, of),
        }
    }

    fn run<R: Real, D: Decode>(
        &self,
        decode: D,
        state: &SamplerState,
        u: &[R],
        v: &[R],
        active: LaneMask,
        out: [&mut [R]; 4],
        of: impl Fn(usize, &SamplerState) -> Footprint<R>,
    ) {
        let [r, g, b, a] = out;
        for lane in lanes(active, u.len()) {
            [r[lane], g[lane], b[lane], a[lane]] = sample(decode, &self.texels.levels, [u[lane], v[lane]], &of(lane, state), state);
        }
    }

    fn load<R: Real, D: Decode>(&self, decode: D, x: &[R], y: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        let [r, g, b, a] = out;
        for lane in lanes(active, x.len()) {
            let (x, y) = (x[lane].int(), y[lane].int());
            // Negative integers are large ones here; what lies outside reads as zero.
            let texel = match self.texels.levels.get(level[lane].int() as usize) {
                Some(at) if x < at.width && y < at.height => decode.texel(at, x, y),
                _ => [0.0; 4],
            };
            [r[lane], g[lane], b[lane], a[lane]] = texel.map(|t| R::from_f32_bits(t.to_bits()));
        }
    }
}

impl<R: Real> TextureUnit<R> for Textures<'_> {
    fn sample_gradients(&self, texture: usize, u: &[R], v: &[R], g: Gradients<'_, R>, active: LaneMask, out: [&mut [R]; 4]) {
        let bound = &self.0[texture];
        let size = [bound.texels.levels[0].width, bound.texels.levels[0].height];
        bound.each(u, v, active, out, |lane, state| {
            footprint(size, [g.du_dx[lane], g.dv_dx[lane]], [g.du_dy[lane], g.dv_dy[lane]], state.anisotropy)
        });
    }

    fn sample_level(&self, texture: usize, u: &[R], v: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        self.0[texture].each(u, v, active, out, |lane, _| Footprint { level: level[lane], taps: 1, step: [R::ZERO; 2] });
    }

    fn load(&self, texture: usize, x: &[R], y: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        let bound = &self.0[texture];
        match bound.texels.format {
            TexelFormat::Rgba8Srgb => bound.load(Srgb::new(), x, y, level, active, out),
            TexelFormat::Rgba8Unorm => bound.load(Unorm, x, y, level, active, out),
            TexelFormat::Rgba32Float => bound.load(Float, x, y, level, active, out),
        }
    }

    fn dimensions(&self, texture: usize, level: u32) -> [u32; 2] {
        let levels = &self.0[texture].texels.levels;
        let at = &levels[(level as usize).min(levels.len() - 1)];
        [at.width, at.height]
    }

    fn levels(&self, texture: usize) -> u32 {
        self.0[texture].texels.levels.len() as u32
    }
}
