//! From a scene to a plan: which pass, which module, which bytes.
//!
//! In: the scene, the layouts of the modules (read from the modules themselves) and the decoded maps. Out: a [`Plan`]. Uniform fields are
//! filled by name from [`DrawUniforms`]; a field that the module wants and scene does not give is an error, not a zero.

use super::error::PlanError;
use super::graph::{self, Step, Target, Write};
use super::passes::{
    AddressMode, Attribute, Blend, ColourFormat, Cull, DepthState, Instances, Plan, PlanDraw, SamplerBinding, SamplerState, TextureBinding,
    TextureSource, Vertices,
};
use super::provider::ResourceProvider;
use super::scissor::scissor;
use super::shared;
use crate::image::{Level, MapDecoding, PoleFilter, SharedTexture, TexelFormat, Texture};
use crate::scene::Scene;
use crate::scene::air_nodes;
use crate::scene::draw::uniforms::UniformValue;
use crate::scene::draw::{Draw, DrawFeatures, DrawUniforms, Part, PixelView, RingTable, Shape};
use crate::scene::request::Quality;
use crate::scene::ring_shine::{self, RingShine};
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use crate::shader::reflect::{FieldType, LayoutError};
use crate::shader::{Layout, UniformWriter};
use std::sync::Arc;

/// How finely the frame is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplingQuality {
    /// 1 or 4.
    pub samples: u8,
    /// Taps along a footprint on a map, 1..=16.
    pub anisotropy: u8,
}

impl SamplingQuality {
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
pub fn map_decoding(binding: u32, shape: Shape) -> MapDecoding {
    let poles = match (shape, binding) {
        (Shape::Mesh, _) => PoleFilter::None,
        (_, 2) => PoleFilter::Slopes,
        _ => PoleFilter::Values,
    };
    MapDecoding { format: map_format(binding), poles }
}

/// The modules that a scene's plan runs, each once, so that they can be fetched ahead.
pub fn modules(scene: &Scene) -> Vec<ModuleId> {
    let of_draw = |d: &Draw| ModuleId::Planet(ShaderKey::for_draw(&d.features));
    let mut all: Vec<_> = scene.draws.iter().chain(&scene.outlined).map(of_draw).collect();
    all.extend(shared::modules(scene).into_iter().map(ModuleId::Simple));
    all.sort();
    all.dedup();
    all
}

/// Linear light of the scene, and the bytes that are shown.
const HDR_TARGET: &str = "light";
pub const DISPLAY_TARGET: &str = "picture";

/// Below this white a level of the display may be less than the least step of half floats, 2^-24: half a level on black is 1.5e-4 of white.
const DIM_WHITE: f64 = 4e-4;

/// Plans one frame.
pub fn plan(scene: &Scene, provider: &impl ResourceProvider, sampling: SamplingQuality) -> Result<Plan, PlanError> {
    Ok(graph::compile(&steps(scene, provider, sampling)?, DISPLAY_TARGET)?)
}

/// What draws of a body are called among the steps.
fn kind(draw: &Draw) -> &'static str {
    if draw.part == Part::Globe { "opaque bodies" } else { "rings and shells" }
}

/// The steps of one frame. The stars come first, for everything else stands before them. Opaque bodies, and rings and shells, go far to near in turns: a soft limb is blended over what lies behind it, be that a ring, so that
/// neither can wait until all of the other are drawn; the corona has its place among them. A refracted limb comes with its body: what it takes away before, what it
/// adds after. Then lines, points and the glow, then the tone map; over the finished picture the outline and the names. What a scene does not want makes no pass.
pub fn steps(scene: &Scene, provider: &impl ResourceProvider, sampling: SamplingQuality) -> Result<Vec<Step>, PlanError> {
    let (width, height) = (scene.camera.width, scene.camera.height);
    let black = [0.0, 0.0, 0.0, 1.0];
    let light = Target {
        resource: HDR_TARGET,
        width,
        height,
        format: if scene.exposure.white() < DIM_WHITE { ColourFormat::Rgba32FloatDim } else { ColourFormat::Rgba32Float },
        samples: sampling.samples,
        clear: black,
        depth: true,
    };
    let over_light = |name, draws| Step { name, reads: vec![], writes: Write::Over(HDR_TARGET), draws };
    let background = Step { name: "background", reads: vec![], writes: Write::New(light), draws: vec![] };
    let mut steps = vec![background, over_light("stars", shared::stars(scene, provider)?)];
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
            let (unbent, bent) = limb.map(|l| shared::refracted_limb(scene, l, provider)).transpose()?.unzip();
            steps.extend(unbent.flatten().filter(|_| begins).map(|draw| over_light("unbent Sun", vec![draw])));
            for of_kind in run.chunk_by(|a, b| kind(a) == kind(b)) {
                let draws = of_kind.iter().map(|draw| body_draw(draw, width, height, provider, sampling)).collect::<Result<Vec<_>, _>>()?;
                steps.push(over_light(kind(&of_kind[0]), draws));
            }
            steps.extend(bent.filter(|_| ends).map(|draw| over_light("refracted limb", vec![draw])));
        }
        Ok(())
    };
    let behind = scene.corona.map_or(0, |c| c.draws_behind.min(scene.draws.len()));
    bodies(&mut steps, 0, &scene.draws[..behind])?;
    steps.push(over_light("corona", shared::corona(scene, provider)?));
    bodies(&mut steps, behind, &scene.draws[behind..])?;
    steps.extend([
        over_light("lines", shared::lines(scene, provider)?),
        over_light("points", shared::points(scene, provider)?),
        over_light("glow", shared::glow(scene, provider)?),
    ]);
    if scene.bloom {
        steps.extend(shared::bloom_steps(scene, provider, HDR_TARGET)?);
    }
    steps.push(shared::tone_map_step(scene, provider, HDR_TARGET, DISPLAY_TARGET)?);
    if let Some(draw) = &scene.outlined {
        let shape = body_draw(draw, width, height, provider, sampling)?;
        steps.extend(shared::outline_steps(scene, shape, provider, DISPLAY_TARGET)?);
    }
    if let Some(labels) = &scene.labels {
        let draws = shared::labels(scene, labels, provider)?;
        steps.push(Step { name: "labels", reads: vec![], writes: Write::Over(DISPLAY_TARGET), draws });
    }
    Ok(steps)
}

/// Writes each field that the layout has, by name; fails on a name that the amounts do not have. `map_taps`: taps on a map at most.
pub fn uniforms_of(layout: &Layout, uniforms: &DrawUniforms, map_taps: u8) -> Result<Vec<u8>, LayoutError> {
    let mut w = layout.writer();
    for field in &layout.fields {
        // The module says how many samples it takes.
        let rows = if let FieldType::Vec4Array(rows) = field.ty { rows as usize } else { 0 };
        match field.name.as_str() {
            name @ "air_quadrature_nodes" => {
                let samples = (rows / air_nodes::ROWS).saturating_sub(air_nodes::ENDS);
                w.vec4_array(name, &air_nodes::nodes(&uniforms.air, samples))?;
            }
            name @ ("air_samples" | "air_multi_scatter_samples") => w.vec4_array(name, &air_nodes::samples(rows))?,
            name @ "air_multi_scatter_nodes" => w.vec4_array(name, &air_nodes::many(&uniforms.air, rows / air_nodes::POWERS))?,
            name @ "map_taps" => w.f32(name, f32::from(map_taps))?,
            name => put(&mut w, name, &uniforms.uniform(name).ok_or_else(|| LayoutError::Unknown(name.to_owned()))?)?,
        }
    }
    w.finish()
}

fn put(w: &mut UniformWriter<'_>, name: &str, value: &UniformValue<'_>) -> Result<(), LayoutError> {
    match value {
        UniformValue::F32(v) => w.f32(name, *v),
        UniformValue::Vec2(v) => w.vec2(name, *v),
        UniformValue::Vec3(v) => w.vec3(name, *v),
        UniformValue::Vec4(v) => w.vec4(name, *v),
        UniformValue::Mat4(v) => w.mat4(name, *v),
        UniformValue::Rows(rows) => w.vec4_array(name, rows),
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

/// A closed shape hides its far side before depth does.
fn cull_of(features: &DrawFeatures) -> Cull {
    if features.flags.two_sided { Cull::None } else { Cull::Back }
}

/// The attributes of shaders/lib/mesh.wesl by location: place, normal, map place, height of the Sun, colour.
fn triangles(draw: &Draw, key: &ShaderKey) -> Result<Vertices, PlanError> {
    let missing = |what: &str| PlanError::Module(format!("{}: {key} draws a mesh, and its {what} are not there", draw.name));
    let mesh = draw.uniforms.mesh.as_ref().ok_or_else(|| missing("triangles"))?;
    let model = &mesh.model;
    let attribute = |components: u32, values: &Arc<Vec<f32>>| Attribute { components, values: values.clone() };
    let mut attributes = vec![
        attribute(3, &model.positions),
        attribute(3, &model.normals),
        attribute(2, &model.map_coordinates),
        attribute(1, &mesh.sun_heights),
    ];
    if key.features().flags.vertex_colour {
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

fn body_draw(
    draw: &Draw,
    width: u32,
    height: u32,
    provider: &impl ResourceProvider,
    sampling: SamplingQuality,
) -> Result<PlanDraw, PlanError> {
    let module = ModuleId::Planet(ShaderKey::for_draw(&draw.features));
    let layout = provider.layout(&module)?;
    let uniform_bytes = uniforms_of(&layout, &draw.uniforms, sampling.anisotropy)
        .map_err(|source| PlanError::Layout { module: module.to_string(), source })?;
    // The canonical key may read fewer maps than the draw needs (a depth view reads none).
    let mut textures = Vec::new();
    for (binding, file) in draw.map_files.bindings() {
        if layout.textures.iter().any(|t| t.binding == binding) {
            let image = if OVERLAY_BINDINGS.contains(&binding) {
                provider.overlay(file)?
            } else {
                provider.map(file, map_decoding(binding, draw.features.shape))?
            };
            textures.push(TextureBinding { binding, source: TextureSource::Image(image) });
        }
    }
    if layout.textures.iter().any(|t| t.binding == RING_PROFILE_BINDING)
        && let Some(table) = &draw.uniforms.ring.table
    {
        textures.push(TextureBinding { binding: RING_PROFILE_BINDING, source: TextureSource::Image(ring_profile(table)) });
    }
    if layout.textures.iter().any(|t| t.binding == RING_SHINE_BINDING)
        && let Some(table) = &draw.uniforms.ring.shine
    {
        textures.push(TextureBinding { binding: RING_SHINE_BINDING, source: TextureSource::Image(ring_shine(table)) });
    }
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, linear: true };
    let of_binding = |binding: u32| {
        let overlay = OVERLAY_SAMPLER_BINDINGS.iter().position(|b| *b == binding).and_then(|n| draw.uniforms.overlays.get(n));
        match overlay {
            Some(o) if !o.around => Some(SamplerState { address_u: AddressMode::ClampToEdge, ..state }),
            Some(_) => Some(state),
            None => (binding == MAP_SAMPLER_BINDING).then_some(state),
        }
    };
    let samplers =
        layout.samplers.iter().filter_map(|s| Some(SamplerBinding { binding: s.binding, state: of_binding(s.binding)? })).collect();
    let (vertices, cull) = match &module {
        ModuleId::Planet(key) if key.features().shape == Shape::Mesh => (triangles(draw, key)?, cull_of(&draw.features)),
        _ => (Vertices::Count(6), Cull::None),
    };
    Ok(PlanDraw {
        label: draw.name.clone(),
        module,
        uniform_bytes,
        textures,
        samplers,
        vertices,
        instances: Instances { count: 1, attributes: Vec::new() },
        // Work adds up; light is covered.
        blend: if draw.features.view == PixelView::Cost { Blend::Add } else { Blend::PremultipliedOver },
        cull,
        depth: depth_of(draw.part),
        scissor: scissor(draw.uniforms.rect_in_clip, width, height),
    })
}
