//! The coarse picture of the air: one pass that draws the air of each body that reads it, one that says where interpolation is accurate enough.
//!
//! In: the scene's draws, the layouts of modules. Out: the steps of both passes, and the draws that read their picture with their place in it. Always: a texel is
//! where four pixels of the screen meet (`COARSE_AIR_PX` apart), and the draws are one below the other in one picture, since bodies overlap on the screen. Not
//! here: which draws read the picture (scene).

use super::error::PlanError;
use super::graph::{PassStep, Read, Target, Write};
use super::passes::{Blend, ColourFormat, Cull, DepthState, Instances, PlanDraw, Vertices};
use super::provider::ResourceProvider;
use super::shared::{FIRST_READ_BINDING, full_screen_draw};
use super::uniform_bytes::uniforms_of;
use crate::scene::draw::constants::{COARSE_AIR_BORDER, COARSE_AIR_PX};
use crate::scene::draw::{AirPass, Draw, DrawUniforms};
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use glam::Vec4;
use std::borrow::Cow;

/// Resource names: the air as drawn, and with the texels marked between which it may be interpolated.
const SAMPLES: &str = "air samples";
const COARSE_AIR: &str = "coarse air";
/// The simple shader that marks them.
const MARKING_MODULE: &str = "coarse_air";
/// The texture variable of the picture.
pub const COARSE_AIR_TEXTURE: &str = "coarse_air";
/// Its binding in shaders/lib/air/coarse.wesl.
const BINDING: u32 = 14;

fn reads(draw: &Draw) -> bool {
    draw.features.air_pass == AirPass::Read
}

/// The modules that the passes run.
pub(super) fn modules(draws: &[Draw]) -> Vec<ModuleId> {
    let drawn = draws.iter().filter_map(|d| d.features.coarse_air());
    let mut all: Vec<_> = drawn.map(|features| ModuleId::Planet(ShaderKey::for_draw(&features))).collect();
    if !all.is_empty() {
        all.push(ModuleId::Simple(MARKING_MODULE));
    }
    all
}

/// Size of a body's part of the picture, for a screen of this size.
pub fn coarse_air_size(screen: [u32; 2]) -> [u32; 2] {
    screen.map(|px| px.div_ceil(COARSE_AIR_PX) + 1 + 2 * COARSE_AIR_BORDER)
}

/// Number of draws before this one that read the picture.
fn place(draws: &[Draw], k: usize) -> u32 {
    draws[..k].iter().filter(|d| reads(d)).count() as u32
}

/// The draw with its place in the picture, if it reads the picture. `k`: its index.
pub(super) fn placed(draws: &[Draw], k: usize, screen: [u32; 2]) -> Cow<'_, Draw> {
    let draw = &draws[k];
    if !reads(draw) {
        return Cow::Borrowed(draw);
    }
    let mut draw = draw.clone();
    draw.uniforms.air.coarse_row = (place(draws, k) * coarse_air_size(screen)[1]) as f32;
    Cow::Owned(draw)
}

/// What a step with these draws reads.
pub(super) fn reads_of(draws: &[Draw]) -> Vec<Read> {
    if draws.iter().any(reads) { vec![Read { resource: COARSE_AIR, binding: BINDING }] } else { Vec::new() }
}

/// The steps of both passes; none if no draw reads the picture.
pub(super) fn steps(
    draws: &[Draw],
    screen: [u32; 2],
    format: ColourFormat,
    provider: &impl ResourceProvider,
) -> Result<Vec<PassStep>, PlanError> {
    let parts = place(draws, draws.len());
    if parts == 0 {
        return Ok(Vec::new());
    }
    let [width, part_height] = coarse_air_size(screen);
    let height = parts * part_height;
    let mut samples = Vec::new();
    let mut marks = Vec::new();
    for (k, draw) in draws.iter().enumerate().filter(|(_, d)| reads(d)) {
        let Some(features) = draw.features.coarse_air() else { continue };
        let rect = rect_in_part(draw.uniforms.rect_in_clip, screen);
        let first_row = place(draws, k) * part_height;
        let scissor = [rect[0], rect[1] + first_row, rect[2], rect[3] + first_row];
        let mut uniforms = over_texels(&draw.uniforms, rect, scissor, screen, [width, height]);
        // The air scatters the Sun's light alone: the key keeps no other light.
        uniforms.lights.truncate(1);
        let module = ModuleId::Planet(ShaderKey::for_draw(&features));
        let layout = provider.layout(&module)?;
        let uniform_bytes =
            uniforms_of(&layout, &uniforms, 1).map_err(|source| PlanError::Layout { module: module.to_string(), source })?;
        samples.push(PlanDraw {
            label: format!("{} air samples", draw.name),
            module,
            uniform_bytes,
            textures: Vec::new(),
            samplers: Vec::new(),
            vertices: Vertices::Count(6),
            instances: Instances { count: 1, attributes: Vec::new() },
            blend: Blend::Replace,
            cull: Cull::None,
            depth: DepthState { test: false, write: false },
            scissor,
            extent: None,
        });
        let marking = full_screen_draw(MARKING_MODULE, [width, height], provider, |w| w.vec2("bound", draw.uniforms.air.coarse_bound))?;
        marks.push(PlanDraw { label: format!("{} coarse air", draw.name), scissor, ..marking });
    }
    let target = |resource| Target { resource, width, height, format, samples: 1, clear: [0.0; 4], depth: false };
    let of_samples = vec![Read { resource: SAMPLES, binding: FIRST_READ_BINDING }];
    Ok(vec![
        PassStep { name: SAMPLES, reads: vec![], writes: Write::New(target(SAMPLES)), draws: samples },
        PassStep { name: COARSE_AIR, reads: of_samples, writes: Write::New(target(COARSE_AIR)), draws: marks },
    ])
}

/// Texels by which the edge of the screen lies inside the picture: the middle of the first texel on the screen.
fn edge() -> f32 {
    COARSE_AIR_BORDER as f32 + 0.5
}

/// The texels of a body's part that its rectangle needs, with one more on each side: left, top, right and bottom (exclusive).
fn rect_in_part(rect_in_clip: Vec4, screen: [u32; 2]) -> [u32; 4] {
    let size = coarse_air_size(screen);
    let px = |clip: f32, side: u32| 0.5 * (1.0 + clip) * side as f32 / COARSE_AIR_PX as f32 + edge();
    let [x0, y0, x1, y1] = rect_in_clip.to_array();
    let from = |at: f32| (at.floor() - 1.0).max(0.0) as u32;
    let to = |at: f32, limit: u32| ((at.ceil() + 1.0).max(0.0) as u32).min(limit);
    let [left, top] = [from(px(x0, screen[0])).min(size[0]), from(px(-y0, screen[1])).min(size[1])];
    [left, top, to(px(x1, screen[0]), size[0]).max(left), to(px(-y1, screen[1]), size[1]).max(top)]
}

/// The uniforms with the rectangle of these texels: the same view rays, continued beyond the old rectangle where the new one is larger. `part`: the rectangle in
/// the body's part, `whole`: in the picture.
fn over_texels(uniforms: &DrawUniforms, part: [u32; 4], whole: [u32; 4], screen: [u32; 2], picture: [u32; 2]) -> DrawUniforms {
    let [x0, y0, x1, y1] = uniforms.rect_in_clip.to_array();
    let clip_of = |texel: u32, side: u32| 2.0 * (texel as f32 - edge()) * COARSE_AIR_PX as f32 / side as f32 - 1.0;
    let fraction = |clip: f32, from: f32, to: f32| (clip - from) / (to - from);
    let [u0, u1] = [part[0], part[2]].map(|t| fraction(clip_of(t, screen[0]), x0, x1));
    // Clip y points up, texel rows down.
    let [v0, v1] = [part[1], part[3]].map(|t| fraction(-clip_of(t, screen[1]), y0, y1));
    let clip_in_picture = |texel: u32, side: u32| 2.0 * texel as f32 / side as f32 - 1.0;
    let [left, right] = [whole[0], whole[2]].map(|t| clip_in_picture(t, picture[0]));
    let [top, bottom] = [whole[1], whole[3]].map(|t| -clip_in_picture(t, picture[1]));
    DrawUniforms {
        rect_in_clip: Vec4::new(left, top, right, bottom),
        anchor_origin: uniforms.anchor_origin + u0 * uniforms.anchor_du + v0 * uniforms.anchor_dv,
        anchor_du: (u1 - u0) * uniforms.anchor_du,
        anchor_dv: (v1 - v0) * uniforms.anchor_dv,
        ray_origin: uniforms.ray_origin + u0 * uniforms.ray_du + v0 * uniforms.ray_dv,
        ray_du: (u1 - u0) * uniforms.ray_du,
        ray_dv: (v1 - v0) * uniforms.ray_dv,
        ..uniforms.clone()
    }
}
