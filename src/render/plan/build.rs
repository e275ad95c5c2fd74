//! From a scene to a plan: which pass, which module, which bytes.
//!
//! In: the scene, the layouts of the modules (read from the modules themselves) and the decoded maps. Out: a [`Plan`]. Uniform fields are
//! filled by name from [`Amounts`]; a field that the module wants and scene does not give is an error, not a zero.

use super::graph::{self, GraphError, Step, Target, Write};
use super::shared;
use super::{
    AddressMode, Attribute, Blend, ColourFormat, Cull, DepthState, Instances, ModuleName, Plan, PlanDraw, SamplerBinding, SamplerState,
    TextureBinding, TextureSource, Vertices,
};
use crate::image::{Letters, Level, Poles, Reading, SharedTexture, TexelFormat, Texture};
use crate::scene::Scene;
use crate::scene::air_nodes;
use crate::scene::draw::{Amounts, Draw, Light, Needs, Part, PixelView, RingTable, Shape};
use crate::scene::request::Quality;
use crate::scene::ring_shine::{self, RingShine};
use crate::shader::key::ShaderKey;
use crate::shader::reflect::{FieldType, LayoutError};
use crate::shader::{Layout, UniformWriter};
use glam::Vec4;
use std::sync::Arc;

#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    #[error("module {module}: {source}")]
    Layout { module: String, source: LayoutError },
    #[error("{0}")]
    Module(String),
    #[error(transparent)]
    Graph(#[from] GraphError),
    /// The file, and why it could not be read.
    #[error("map {file}: {why}")]
    Map { file: String, why: String },
}

/// What the plan asks of the outside: layouts of modules and decoded maps.
pub trait Supplies {
    fn layout(&self, module: &ModuleName) -> Result<Layout, PlanError>;
    /// A map by its file name, as colour or as plain numbers.
    fn map(&self, file: &str, reading: Reading) -> Result<SharedTexture, PlanError>;
    /// A colour image premultiplied by its alpha.
    fn overlay(&self, file: &str) -> Result<SharedTexture, PlanError>;
    /// The letters of all bodies' names for texts of a size, pixels.
    fn letters(&self, size_px: f64) -> Arc<Letters>;
}

/// How finely the frame is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fineness {
    /// 1 or 4.
    pub samples: u8,
    /// Taps along a footprint on a map, 1..=16.
    pub anisotropy: u8,
}

impl Fineness {
    /// What a quality draws with.
    pub fn of(quality: Quality) -> Self {
        match quality {
            Quality::Draft => Self { samples: 1, anisotropy: 1 },
            Quality::Standard => Self { samples: 4, anisotropy: 8 },
            Quality::Reference => Self { samples: 4, anisotropy: 16 },
        }
    }
}

/// The binding of the map of lamps.
pub const NIGHT_MAP_BINDING: u32 = 4;
/// The binding of the sampler of all maps.
const MAP_SAMPLER_BINDING: u32 = 8;
/// The binding of the ring's table.
pub const RING_PROFILE_BINDING: u32 = 5;
/// The binding of the table of light that the ring sends onto its globe.
pub const RING_SHINE_BINDING: u32 = 6;
/// The bindings of the images over the ground, and of their samplers.
pub const OVERLAY_BINDINGS: [u32; 2] = [9, 10];
const OVERLAY_SAMPLER_BINDINGS: [u32; 2] = [11, 12];
/// Albedo and night maps hold colours, normal, water and cloud maps plain numbers.
pub fn map_format(binding: u32) -> TexelFormat {
    match binding {
        2 | 3 | 7 => TexelFormat::Rgba8Unorm,
        _ => TexelFormat::Rgba8Srgb,
    }
}

/// How a draw's map is read. A mesh has map places of its own: its maps need not be those of a whole sphere, so they are taken as they are.
pub fn map_reading(binding: u32, shape: Shape) -> Reading {
    let poles = match (shape, binding) {
        (Shape::Mesh, _) => Poles::None,
        (_, 2) => Poles::Slopes,
        _ => Poles::Values,
    };
    Reading { format: map_format(binding), poles }
}

/// The modules that a scene's plan runs, each once, so that they can be fetched ahead.
pub fn modules(scene: &Scene) -> Vec<ModuleName> {
    let of_draw = |d: &Draw| ModuleName::Planet(ShaderKey::for_draw(&d.needs));
    let mut all: Vec<_> = scene.draws.iter().chain(&scene.outlined).map(of_draw).collect();
    all.extend(shared::modules(scene).into_iter().map(ModuleName::Simple));
    all.sort();
    all.dedup();
    all
}

/// Linear light of the scene, and the bytes that are shown.
const LIGHT: &str = "light";
pub const PICTURE: &str = "picture";

/// Plans one frame.
pub fn plan(scene: &Scene, supplies: &impl Supplies, fineness: Fineness) -> Result<Plan, PlanError> {
    Ok(graph::compile(&steps(scene, supplies, fineness)?, PICTURE)?)
}

/// What draws of a body are called among the steps.
fn kind(draw: &Draw) -> &'static str {
    if draw.part == Part::Globe { "opaque bodies" } else { "rings and shells" }
}

/// The steps of one frame. Opaque bodies, and rings and shells, go far to near in turns: a soft limb is blended over what lies behind it, be that a ring, so that
/// neither can wait until all of the other are drawn; the corona has its place among them. A refracted limb comes with its body: what it takes away before, what it
/// adds after. Then lines, points and the glow, then the tone map; over the finished picture the outline and the names. What a scene does not want makes no pass.
pub fn steps(scene: &Scene, supplies: &impl Supplies, fineness: Fineness) -> Result<Vec<Step>, PlanError> {
    let (width, height) = (scene.camera.width, scene.camera.height);
    let black = [0.0, 0.0, 0.0, 1.0];
    let light =
        Target { resource: LIGHT, width, height, format: ColourFormat::Rgba32Float, samples: fineness.samples, clear: black, depth: true };
    let over_light = |name, draws| Step { name, reads: vec![], writes: Write::Over(LIGHT), draws };
    let mut steps = vec![Step { name: "background", reads: vec![], writes: Write::New(light), draws: vec![] }];
    let of_body = |body| move |d: &Draw| d.body == body;
    let bodies = |steps: &mut Vec<Step>, first: usize, draws: &[Draw]| -> Result<(), PlanError> {
        let mut from = first;
        for run in draws.chunk_by(|a, b| a.body == b.body) {
            let (body, end) = (run[0].body, from + run.len());
            // Moons may stand between the layers of a ringed body.
            let begins = !scene.draws[..from].iter().any(of_body(body));
            let ends = !scene.draws[end..].iter().any(of_body(body));
            from = end;
            let limb = scene.limbs.iter().find(|l| l.body == body);
            let (unbent, bent) = limb.map(|l| shared::refracted_limb(scene, l, supplies)).transpose()?.unzip();
            steps.extend(unbent.flatten().filter(|_| begins).map(|draw| over_light("unbent Sun", vec![draw])));
            for of_kind in run.chunk_by(|a, b| kind(a) == kind(b)) {
                let draws = of_kind.iter().map(|draw| body_draw(draw, width, height, supplies, fineness)).collect::<Result<Vec<_>, _>>()?;
                steps.push(over_light(kind(&of_kind[0]), draws));
            }
            steps.extend(bent.filter(|_| ends).map(|draw| over_light("refracted limb", vec![draw])));
        }
        Ok(())
    };
    let behind = scene.corona.map_or(0, |c| c.draws_behind.min(scene.draws.len()));
    bodies(&mut steps, 0, &scene.draws[..behind])?;
    steps.push(over_light("corona", shared::corona(scene, supplies)?));
    bodies(&mut steps, behind, &scene.draws[behind..])?;
    steps.extend([
        over_light("lines", shared::lines(scene, supplies)?),
        over_light("points", shared::points(scene, supplies)?),
        over_light("glow", shared::glow(scene, supplies)?),
    ]);
    if scene.bloom {
        steps.extend(shared::bloom_steps(scene, supplies, LIGHT)?);
    }
    steps.push(shared::tone_map_step(scene, supplies, LIGHT, PICTURE)?);
    if let Some(draw) = &scene.outlined {
        let shape = body_draw(draw, width, height, supplies, fineness)?;
        steps.extend(shared::outline_steps(scene, shape, supplies, PICTURE)?);
    }
    if let Some(labels) = &scene.labels {
        let draws = shared::labels(scene, labels, supplies)?;
        steps.push(Step { name: "labels", reads: vec![], writes: Write::Over(PICTURE), draws });
    }
    Ok(steps)
}

/// Writes each field that the layout has, by name; fails on a name that the amounts do not have. `map_taps`: taps on a map at most.
pub fn uniforms_of(layout: &Layout, amounts: &Amounts, map_taps: u8) -> Result<Vec<u8>, LayoutError> {
    let directions: Vec<Vec4> = amounts.lights.iter().map(|l: &Light| l.direction_in_body.extend(0.0)).collect();
    let irradiances: Vec<Vec4> = amounts.lights.iter().map(|l| l.irradiance.extend(0.0)).collect();
    let mut w = layout.writer();
    for field in &layout.fields {
        // The module says how many samples it takes.
        let rows = if let FieldType::Vec4Array(rows) = field.ty { rows as usize } else { 0 };
        match field.name.as_str() {
            name @ "air_nodes" => {
                let samples = (rows / air_nodes::ROWS).saturating_sub(air_nodes::ENDS);
                w.vec4_array(name, &air_nodes::nodes(&amounts.air, samples))?;
            }
            name @ ("air_samples" | "air_many_samples") => w.vec4_array(name, &air_nodes::samples(rows))?,
            name @ "air_many_nodes" => w.vec4_array(name, &air_nodes::many(&amounts.air, rows / air_nodes::POWERS))?,
            name @ "map_taps" => w.f32(name, f32::from(map_taps))?,
            name => put(&mut w, name, amounts, &directions, &irradiances)?,
        }
    }
    w.finish()
}

fn put(w: &mut UniformWriter<'_>, name: &str, a: &Amounts, directions: &[Vec4], irradiances: &[Vec4]) -> Result<(), LayoutError> {
    match name {
        "rect_in_clip" => w.vec4(name, a.rect_in_clip),
        "anchor_origin" => w.vec3(name, a.anchor_origin),
        "anchor_du" => w.vec3(name, a.anchor_du),
        "anchor_dv" => w.vec3(name, a.anchor_dv),
        "ray_origin" => w.vec3(name, a.ray_origin),
        "ray_du" => w.vec3(name, a.ray_du),
        "ray_dv" => w.vec3(name, a.ray_dv),
        "anchor_excess" => w.f32(name, a.anchor_excess),
        "anchor_is_camera" => w.f32(name, a.anchor_is_camera),
        "depth_row" => w.vec4(name, a.depth_row),
        "axis_ratios" => w.vec3(name, a.axis_ratios),
        "albedo" => w.vec3(name, a.albedo),
        "light_direction" => w.vec4_array(name, directions),
        "light_irradiance" => w.vec4_array(name, irradiances),
        "photometric_parameter" => w.f32(name, a.photometric_parameter),
        "limb_u1" => w.vec3(name, a.limb_u1),
        "limb_u2" => w.vec3(name, a.limb_u2),
        "map_latitude_stretch" => w.f32(name, a.map_latitude_stretch),
        "night_radiance" => w.vec3(name, a.night_radiance),
        "specular_strength" => w.f32(name, a.specular_strength),
        "wave_slope_sq" => w.f32(name, a.wave_slope_sq),
        "overlay" => w.vec4_array(name, &a.overlays.iter().flat_map(|o| o.rows).collect::<Vec<_>>()),
        "normal_strength" => w.f32(name, a.normal_strength),
        "cloud_clear" => w.f32(name, a.clouds.clear),
        "cloud_full" => w.f32(name, a.clouds.full),
        "cloud_radius" | "shell_scale" => w.f32(name, a.clouds.radius),
        "cloud_albedo" => w.f32(name, a.clouds.albedo),
        "air_top" => w.f32(name, a.air.top),
        "air_gas_height" => w.f32(name, a.air.gas_height),
        "air_gas_scattering" => w.vec3(name, a.air.gas_scattering),
        "air_gas_extinction" => w.vec3(name, a.air.gas_extinction),
        "air_skylight" => w.vec3(name, a.air.skylight),
        "air_night" => w.f32(name, a.air.night),
        "air_haze_height" => w.f32(name, a.air.haze_height),
        "air_haze_asymmetry" => w.f32(name, a.air.haze_asymmetry),
        "air_haze_scattering" => w.vec3(name, a.air.haze_scattering),
        "air_haze_extinction" => w.vec3(name, a.air.haze_extinction),
        "air_veil" => w.f32(name, a.air.veil),
        "air_many_heights" => w.vec2(name, a.air.many_heights),
        "air_many" => w.vec4_array(name, &a.air.many),
        "air_layer" => w.vec3(name, a.air.layer),
        "air_layer_extinction" => w.vec3(name, a.air.layer_extinction),
        "camera_in_unit_sphere" => w.vec3(name, a.camera_in_unit_sphere),
        "clip_from_unit_sphere" => w.mat4(name, a.clip_from_unit_sphere),
        "mesh_anchor" => w.vec3(name, a.mesh_anchor),
        "eclipse_axis" => w.vec4(name, a.eclipse.axis),
        "eclipse_across" => w.vec4_array(name, &a.eclipse.across),
        "eclipse_limb" => w.vec4_array(name, &a.eclipse.limb),
        "caster_place" => w.vec4_array(name, &a.eclipse.places),
        "caster_shape" => w.vec4_array(name, &a.eclipse.shapes),
        "caster_spread" => w.vec4_array(name, &a.eclipse.spread),
        "caster_air_edges" => w.vec4_array(name, &a.eclipse.air_edges),
        "caster_air_passes" => w.vec4_array(name, &a.eclipse.air_passes),
        "ring_nodes" => w.f32(name, a.ring.nodes()),
        "ring_reach" => w.vec2(name, a.ring.reach),
        "ring_blur" => w.f32(name, a.ring.blur),
        "ring_phase" => w.vec3(name, a.ring.phase),
        "ring_dust_asymmetry" => w.vec3(name, a.ring.dust_asymmetry),
        "ring_dust_share" => w.vec3(name, a.ring.dust_share),
        "ring_opposition" => w.vec2(name, a.ring.opposition),
        "ring_shine" => w.vec4(name, a.ring.shine_frame),
        "ring_half" => w.f32(name, a.ring.half),
        "sun_tangent" => w.f32(name, a.ring.sun_tangent),
        "shadow_axes" => w.vec3(name, a.ring.shadow_axes),
        "sun_limb_u1" => w.vec3(name, a.ring.sun_limb_u1),
        "sun_limb_u2" => w.vec3(name, a.ring.sun_limb_u2),
        "hider" => w.vec4_array(name, &a.hiders.rows),
        "pixel_size" => w.vec2(name, a.pixel_size),
        _ => Err(LayoutError::Unknown(name.to_owned())),
    }
}

/// The ring's table as a texture of one level: it is read by texel.
pub fn ring_profile(table: &RingTable) -> SharedTexture {
    let bytes = table.texels.iter().flat_map(|v| v.to_le_bytes()).collect();
    let level = Level { width: table.width, height: table.height, bytes };
    Arc::new(Texture { format: TexelFormat::Rgba32Float, levels: vec![level] })
}

/// Light from the ring as a texture of one level: it is read by texel.
pub fn ring_shine(table: &RingShine) -> SharedTexture {
    let bytes = table.texels.iter().flat_map(|v| v.to_le_bytes()).collect();
    let level = Level { width: ring_shine::COLUMNS as u32, height: 2 * ring_shine::ROWS as u32, bytes };
    Arc::new(Texture { format: TexelFormat::Rgba32Float, levels: vec![level] })
}

/// Pixels that a clip rectangle touches.
pub(super) fn scissor(rect: Vec4, width: u32, height: u32) -> [u32; 4] {
    let across = |clip: f32, size: u32| f64::from(clip).mul_add(0.5, 0.5) * f64::from(size);
    let (x0, x1) = (across(rect.x, width), across(rect.z, width));
    let (y0, y1) = (across(-rect.y, height), across(-rect.w, height));
    // `as` saturates: nothing outside the viewport survives.
    [x0.floor() as u32, y0.floor() as u32, (x1.ceil() as u32).min(width), (y1.ceil() as u32).min(height)]
}

/// A closed shape hides its far side before depth does.
fn cull_of(needs: &Needs) -> Cull {
    if needs.flags.two_sided { Cull::None } else { Cull::Back }
}

/// Heights of a Sun that nothing hides, in its radii.
const SUN_IS_UP: f32 = 1e3;

/// The attributes of shaders/lib/mesh.wesl by location: place, normal, map place, height of the Sun, colour.
fn triangles(draw: &Draw, key: &ShaderKey) -> Result<Vertices, PlanError> {
    let missing = |what: &str| PlanError::Module(format!("{}: {key} draws a mesh, and its {what} are not there", draw.name));
    let mesh = draw.amounts.mesh.as_ref().ok_or_else(|| missing("triangles"))?;
    let model = &mesh.model;
    let attribute = |components: u32, values: &Arc<Vec<f32>>| Attribute { components, values: values.clone() };
    let heights = mesh.sun_heights.clone().unwrap_or_else(|| Arc::new(vec![SUN_IS_UP; model.vertices()]));
    let mut attributes =
        vec![attribute(3, &model.positions), attribute(3, &model.normals), attribute(2, &model.map_places), attribute(1, &heights)];
    if key.needs().flags.vertex_colour {
        attributes.push(attribute(4, model.colours.as_ref().ok_or_else(|| missing("colours"))?));
    }
    Ok(Vertices::Mesh { attributes, indices: model.indices.clone() })
}

/// Depth orders bodies: globes, and lines and points among them. The layers of one body may be closer than it can tell: they lie over what was drawn before
/// them (scene's order), and leave its depth.
fn depth_of(part: Part) -> DepthState {
    let globe = part == Part::Globe;
    DepthState { test: globe, write: globe }
}

fn body_draw(draw: &Draw, width: u32, height: u32, supplies: &impl Supplies, fineness: Fineness) -> Result<PlanDraw, PlanError> {
    let module = ModuleName::Planet(ShaderKey::for_draw(&draw.needs));
    let layout = supplies.layout(&module)?;
    let uniforms = uniforms_of(&layout, &draw.amounts, fineness.anisotropy)
        .map_err(|source| PlanError::Layout { module: module.to_string(), source })?;
    // The canonical key may read fewer maps than the draw needs (a depth view reads none).
    let mut textures = Vec::new();
    for (binding, file) in draw.map_files.bindings() {
        if layout.textures.iter().any(|t| t.binding == binding) {
            let image = if OVERLAY_BINDINGS.contains(&binding) {
                supplies.overlay(file)?
            } else {
                supplies.map(file, map_reading(binding, draw.needs.shape))?
            };
            textures.push(TextureBinding { binding, source: TextureSource::Image(image) });
        }
    }
    if layout.textures.iter().any(|t| t.binding == RING_PROFILE_BINDING)
        && let Some(table) = &draw.amounts.ring.table
    {
        textures.push(TextureBinding { binding: RING_PROFILE_BINDING, source: TextureSource::Image(ring_profile(table)) });
    }
    if layout.textures.iter().any(|t| t.binding == RING_SHINE_BINDING)
        && let Some(table) = &draw.amounts.ring.shine
    {
        textures.push(TextureBinding { binding: RING_SHINE_BINDING, source: TextureSource::Image(ring_shine(table)) });
    }
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, linear: true };
    let of_binding = |binding: u32| {
        let overlay = OVERLAY_SAMPLER_BINDINGS.iter().position(|b| *b == binding).and_then(|n| draw.amounts.overlays.get(n));
        match overlay {
            Some(o) if !o.around => Some(SamplerState { address_u: AddressMode::ClampToEdge, ..state }),
            Some(_) => Some(state),
            None => (binding == MAP_SAMPLER_BINDING).then_some(state),
        }
    };
    let samplers =
        layout.samplers.iter().filter_map(|s| Some(SamplerBinding { binding: s.binding, state: of_binding(s.binding)? })).collect();
    let (vertices, cull) = match &module {
        ModuleName::Planet(key) if key.needs().shape == Shape::Mesh => (triangles(draw, key)?, cull_of(&draw.needs)),
        _ => (Vertices::Count(6), Cull::None),
    };
    Ok(PlanDraw {
        label: draw.name.clone(),
        module,
        uniforms,
        textures,
        samplers,
        vertices,
        instances: Instances { count: 1, attributes: Vec::new() },
        // Work adds up; light is covered.
        blend: if draw.needs.view == PixelView::Cost { Blend::Add } else { Blend::PremultipliedOver },
        cull,
        depth: depth_of(draw.part),
        scissor: scissor(draw.amounts.rect_in_clip, width, height),
    })
}
