//! How long a planet's module takes by the million pixels.
//!
//! The body fills a square picture, seen from afar along its equator, lit from the side; maps are grey and small, so the figure is
//! arithmetic and filtering, not memory. Casters, rings and air have no extent: what the module skips for them is not counted.

use super::SessionError;
use crate::image::{TexelFormat, Texture};
use crate::render::plan::{
    AddressMode, Blend, ColourFormat, Cull, DepthState, Instances, Pass, Plan, PlanDraw, SamplerBinding, SamplerState, TextureBinding,
    TextureSource, Vertices, uniforms_of,
};
use crate::render::software::SoftwareRenderer;
use crate::scene::draw::{Amounts, Light, Shape};
use crate::shader::{Library, ModuleId};
use glam::{Vec3, Vec4};
use std::sync::Arc;
use std::time::Instant;

const SIDE: u32 = 1000;
const ROUNDS: usize = 5;
/// Half the picture's side in radii: its corners are still on the body.
const HALF: f32 = 0.7;

fn amounts(lights: u8) -> Amounts {
    let direction = Vec3::new(0.6, 0.5, 0.624_5);
    Amounts {
        rect_in_clip: Vec4::new(-1.0, 1.0, 1.0, -1.0),
        anchor_origin: Vec3::new(0.0, -HALF, HALF),
        anchor_du: Vec3::new(0.0, 2.0 * HALF, 0.0),
        anchor_dv: Vec3::new(0.0, 0.0, -2.0 * HALF),
        ray_origin: Vec3::NEG_X,
        depth_row: Vec4::new(-1.0, 0.0, 0.0, 1.0e3),
        axis_ratios: Vec3::new(1.0, 1.0, 0.95),
        albedo: Vec3::splat(0.5),
        lights: (0..lights).map(|_| Light { direction_in_body: direction, irradiance: Vec3::ONE }).collect(),
        photometric_parameter: 0.1,
        limb_u1: Vec3::splat(0.4),
        limb_u2: Vec3::splat(0.2),
        map_latitude_stretch: 1.0,
        specular_strength: 1.0,
        specular_power: 60.0,
        normal_strength: 1.0,
        camera_in_unit_sphere: Vec3::X * 1.0e3,
        ..Amounts::default()
    }
}

/// Milliseconds of wall time for a million pixels, best of five; `None` for a module that draws no planet, or a mesh.
///
/// # Errors
/// The module cannot be made or run.
pub fn ms_per_megapixel(renderer: &SoftwareRenderer, library: &Library, id: &ModuleId) -> Result<Option<f64>, SessionError> {
    let ModuleId::Planet(key) = id else { return Ok(None) };
    if key.needs().shape == Shape::Mesh {
        return Ok(None);
    }
    let failed = |e: String| SessionError::Renderer(e);
    let module = library.get(id).map_err(|e| failed(e.to_string()))?;
    let uniforms = uniforms_of(&module.layout, &amounts(key.needs().lights)).map_err(|e| failed(e.to_string()))?;
    let grey = Texture::from_rgba8(256, 128, [128, 128, 200, 255].repeat(256 * 128), TexelFormat::Rgba8Unorm);
    let grey = Arc::new(grey.map_err(|e| failed(e.to_string()))?);
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, linear: true, anisotropy: 8 };
    let draw = PlanDraw {
        label: id.to_string(),
        module: id.clone(),
        uniforms,
        textures: module
            .layout
            .textures
            .iter()
            .map(|t| TextureBinding { binding: t.binding, source: TextureSource::Image(grey.clone()) })
            .collect(),
        samplers: module.layout.samplers.iter().map(|s| SamplerBinding { binding: s.binding, state }).collect(),
        vertices: Vertices::Count(6),
        instances: Instances { count: 1, attributes: Vec::new() },
        blend: Blend::Replace,
        cull: Cull::None,
        depth: DepthState { test: true, write: true },
        scissor: [0, 0, SIDE, SIDE],
    };
    let pass = Pass {
        name: "cost",
        width: SIDE,
        height: SIDE,
        format: ColourFormat::Rgba32Float,
        samples: 1,
        clear: [0.0; 4],
        depth: true,
        draws: vec![draw],
    };
    let plan = Plan { passes: vec![pass] };
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        renderer.render(&plan, library, false).map_err(|e| failed(e.to_string()))?;
        best = best.min(1e3 * start.elapsed().as_secs_f64());
    }
    Ok(Some(best))
}
