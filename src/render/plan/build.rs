//! Builds the plan of a scene: its passes, the shader modules of its draws and their uniform bytes.
//!
//! In: the scene, the layouts reflected from the modules, and the decoded maps. Out: a [`Plan`]. Always: uniform fields are filled by name from
//! `DrawUniforms`; a field of the module that the scene does not supply is an error, not zero. Not here: the choice of what is drawn (scene).

use super::coarse_air;
use super::error::PlanError;
use super::extent::Extent;
use super::graph::{self, PassStep, TargetDescriptor, Write};
use super::labels;
use super::light_around_sun;
use super::maps;
use super::passes::{Attribute, Blend, ColourFormat, Cull, DepthState, FrontFace, Instances, Pass, Plan, PlanDraw, ShadingRate, Vertices};
use super::provider::ResourceProvider;
use super::scissor::scissor;
use super::simple_draws;
use super::sky;
use super::small_bodies;
use super::uniform_bytes::uniform_bytes;
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::draw::{BodyPart, Draw, DrawFeatures, PixelView, Shape};
use crate::scene::request::Quality;
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use std::sync::Arc;

/// The number of samples per pixel, and of taps per map lookup.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplingQuality {
    /// 1 or 4.
    pub samples: u8,
    /// Maximum number of taps (samples of a map along a pixel's footprint, for anisotropic filtering), 1..=16.
    pub anisotropy: u8,
}

impl SamplingQuality {
    /// The sampling of a quality level.
    pub fn of(quality: Quality) -> Self {
        match quality {
            Quality::Draft => Self { samples: 1, anisotropy: 1 },
            Quality::Standard => Self { samples: 4, anisotropy: 8 },
            Quality::Reference => Self { samples: 4, anisotropy: 16 },
        }
    }
}

/// The modules that a scene's plan runs, each once, so that they can be compiled before the plan is made.
pub fn modules(scene: &Scene) -> Vec<ModuleId> {
    let module_of = |d: &Draw| ModuleId::Keyed(ShaderKey::for_draw(&d.features));
    let mut all: Vec<_> = scene.draws.iter().chain(&scene.outlined_shape).map(module_of).collect();
    all.extend(coarse_air::modules(&scene.draws));
    all.extend(simple_draws::modules(scene).into_iter().map(ModuleId::Simple));
    all.sort();
    all.dedup();
    all
}

/// Resource names of the scene's linear HDR image and of the display-encoded image. They are keys of the pass times in JSON reports, and
/// therefore do not change.
pub(super) const HDR_TARGET: &str = "light";
pub(crate) const DISPLAY_TARGET: &str = "picture";

impl Plan {
    /// The pass that draws the linear HDR image; `None` in a plan that draws no scene. The passes whose output it reads come before it.
    pub fn hdr_pass(&self) -> Option<&Pass> {
        self.hdr_pass_index().and_then(|k| self.passes.get(k))
    }

    /// Index of [`Plan::hdr_pass`]: the last pass named [`HDR_TARGET`]. In the plan of a dome or sphere, each face has a pass of this name too, before that of
    /// the finished image.
    pub(crate) fn hdr_pass_index(&self) -> Option<usize> {
        self.passes.iter().rposition(|pass| pass.name == HDR_TARGET)
    }
}

/// Radiance of display white below which the HDR target needs f32. Half a display level above black is 1 / (2 x 255 x 12.92) = 1.5e-4 of white, where 12.92 is
/// the slope of the sRGB curve at black. At this white it is 6e-8, about the smallest positive half float, 2^-24.
const DIM_WHITE: f64 = 4e-4;
/// Radiance of display white above which the HDR target needs f32: a line, name or outline in the HDR image has the radiance that is displayed as its colour,
/// at most that of white, and half floats end at 65,504. Automatic exposure chooses smaller whites: 54,000 for the Sun's disc.
const BRIGHT_WHITE: f64 = 65_000.0;

/// Plans one frame.
pub fn plan(scene: &Scene, provider: &impl ResourceProvider, sampling: SamplingQuality) -> Result<Plan, PlanError> {
    Ok(graph::compile(&steps(scene, provider, sampling)?, DISPLAY_TARGET)?)
}

/// Name of the step to which a body's draw belongs.
fn step_name(draw: &Draw) -> &'static str {
    if draw.part == BodyPart::Globe { "opaque bodies" } else { "translucent layers" }
}

/// The steps of one frame. The passes of the coarse image of the air come first, because bodies read it. Then, in drawing order:
/// 1. The sky and its stars, because everything else is in front of them.
/// 2. Opaque bodies, translucent layers (rings, atmospheres beyond the limb, clouds) and the corona, from far to near: an antialiased limb is blended over the
///    object behind it, which may be a ring. A refracted limb has two draws: before its body, one that hides the Sun's disc, which was drawn without
///    refraction; after its body, one that adds the refracted light.
/// 3. Lines, points and the glare.
/// 4. Bloom and the tone map.
/// 5. Over the display image, the outline of the selected body and the labels.
pub fn steps(scene: &Scene, provider: &impl ResourceProvider, sampling: SamplingQuality) -> Result<Vec<PassStep>, PlanError> {
    let no_faces = None;
    steps_with_faces(scene, provider, sampling, no_faces)
}

/// As [`steps`]. `faces_draw`: for a dome or a whole sphere, the draw that resamples its faces (frames along the axes of a cube). The faces contain the
/// bodies, so `scene` has none.
pub(super) fn steps_with_faces(
    scene: &Scene,
    provider: &impl ResourceProvider,
    sampling: SamplingQuality,
    faces_draw: Option<PlanDraw>,
) -> Result<Vec<PassStep>, PlanError> {
    let opaque_black = [0.0, 0.0, 0.0, 1.0];
    let mut steps = hdr_steps(scene, provider, sampling, opaque_black, faces_draw)?;
    steps.extend(display_steps(scene, provider, sampling)?);
    Ok(steps)
}

/// The steps that draw into [`HDR_TARGET`], which is first filled with the colour `clear` (linear premultiplied RGBA). `faces_draw`: as in
/// [`steps_with_faces`]; it is drawn over the stars and behind all bodies.
pub(super) fn hdr_steps(
    scene: &Scene,
    provider: &impl ResourceProvider,
    sampling: SamplingQuality,
    clear: [f32; 4],
    faces_draw: Option<PlanDraw>,
) -> Result<Vec<PassStep>, PlanError> {
    let (width, height) = (scene.camera.width, scene.camera.height);
    let hdr = TargetDescriptor {
        resource: HDR_TARGET,
        width,
        height,
        format: if (DIM_WHITE..=BRIGHT_WHITE).contains(&scene.exposure.white()) { ColourFormat::Hdr } else { ColourFormat::HdrF32 },
        samples: sampling.samples,
        clear,
        has_depth: true,
    };
    let format = hdr.format;
    let over_hdr = |name, draws| PassStep { name, reads: vec![], writes: Write::Over(HDR_TARGET), draws };
    let [.., background_opacity] = clear;
    let background = PassStep { name: "background", reads: vec![], writes: Write::New(hdr), draws: vec![] };
    let sky = over_hdr("sky", sky::background(scene, provider, background_opacity)?);
    let sky_lines = over_hdr("sky lines", simple_draws::lines_without_depth("sky lines", &scene.sky_lines, scene, provider)?);
    let sky_images = over_hdr("sky images", sky::images(scene, provider)?);
    let mut steps = coarse_air::steps(&scene.draws, [width, height], format, provider)?;
    steps.extend([background, sky, sky_images, sky_lines, over_hdr("stars", simple_draws::stars(scene, provider)?)]);
    steps.extend(faces_draw.map(|draw| over_hdr("faces", vec![draw])));
    let belongs_to = |body| move |d: &Draw| d.body == body;
    // Adds the steps of these draws, the first of which is `scene.draws[first_draw]`.
    let add_bodies = |steps: &mut Vec<PassStep>, first_draw: usize, draws: &[Draw]| -> Result<(), PlanError> {
        let mut run_start = first_draw;
        // A run: consecutive draws of one body. A ringed body may have several, because moons may be between its layers (ring behind, globe, ring in front).
        for run in draws.chunk_by(|a, b| a.body == b.body) {
            let (body, mut draw_index, run_end) = (run[0].body, run_start, run_start + run.len());
            let is_first_run = !scene.draws[..run_start].iter().any(belongs_to(body));
            let is_last_run = !scene.draws[run_end..].iter().any(belongs_to(body));
            run_start = run_end;
            // `occlusion` hides the Sun's disc, if one was drawn without refraction; `refraction` adds the refracted light.
            let limb = scene.refracted_limbs.iter().find(|l| l.body == body);
            let (occlusion, refraction) = limb.map(|l| simple_draws::refracted_limb(scene, l, provider)).transpose()?.unzip();
            steps.extend(occlusion.flatten().filter(|_| is_first_run).map(|draw| over_hdr("unrefracted Sun", vec![draw])));
            for layers in run.chunk_by(|a, b| step_name(a) == step_name(b)) {
                // Draw `k`, with the first rows of its parts (subimages) of the coarse image of the air in its uniforms.
                let with_subimage_rows = |k| coarse_air::with_subimage_rows(&scene.draws, k, [width, height]);
                let indices = draw_index..draw_index + layers.len();
                let draws = indices.map(|k| body_draw(&with_subimage_rows(k), &scene.camera, provider, sampling));
                let step = over_hdr(step_name(&layers[0]), draws.collect::<Result<Vec<_>, _>>()?);
                steps.push(PassStep { reads: coarse_air::reads_of(layers), ..step });
                draw_index += layers.len();
                let ground_lines = scene.ground_lines.iter().find(|(id, _)| *id == body && layers[0].part == BodyPart::Globe);
                if let Some((_, segments)) = ground_lines {
                    steps.push(over_hdr("ground lines", simple_draws::lines_without_depth("ground lines", segments, scene, provider)?));
                }
            }
            steps.extend(refraction.filter(|_| is_last_run).map(|draw| over_hdr("refracted limb", vec![draw])));
        }
        Ok(())
    };
    let draw_count_behind_corona = scene.corona.map_or(0, |c| c.draw_count_behind.min(scene.draws.len()));
    add_bodies(&mut steps, 0, &scene.draws[..draw_count_behind_corona])?;
    steps.push(over_hdr("corona", light_around_sun::corona(scene, provider)?));
    add_bodies(&mut steps, draw_count_behind_corona, &scene.draws[draw_count_behind_corona..])?;
    steps.extend([
        over_hdr("orbits", small_bodies::orbits(scene, provider)?),
        over_hdr("lines in space", simple_draws::lines_in_space(scene, provider)?),
        over_hdr("minor planets", small_bodies::minor_planets(scene, provider)?),
        over_hdr("comets", small_bodies::comets(scene, provider)?),
        over_hdr("points", simple_draws::points(scene, provider)?),
        over_hdr("glow", light_around_sun::glare(scene, provider)?),
    ]);
    Ok(steps)
}

/// The steps from the HDR image to the display image.
fn display_steps(scene: &Scene, provider: &impl ResourceProvider, sampling: SamplingQuality) -> Result<Vec<PassStep>, PlanError> {
    let mut steps = Vec::new();
    if scene.has_bloom {
        steps.extend(simple_draws::bloom_steps(scene, provider, HDR_TARGET)?);
    }
    steps.push(simple_draws::tone_map_step(scene, provider, HDR_TARGET, DISPLAY_TARGET)?);
    if let Some(draw) = &scene.outlined_shape {
        let shape = body_draw(draw, &scene.camera, provider, sampling)?;
        steps.extend(simple_draws::outline_steps(scene, shape, provider, DISPLAY_TARGET)?);
    }
    if scene.labels.is_some() || scene.line_texts.is_some() {
        steps.push(PassStep {
            name: "labels",
            reads: vec![],
            writes: Write::Over(DISPLAY_TARGET),
            draws: labels::labels(scene, provider)?,
        });
    }
    Ok(steps)
}

/// The back faces of a closed mesh are culled, because its front faces always hide them.
fn cull_of(features: &DrawFeatures) -> Cull {
    if features.flags.two_sided { Cull::None } else { Cull::Back }
}

/// The winding of a mesh's front faces on the screen.
fn front_face_of(camera: &Camera) -> FrontFace {
    if camera.is_mirrored() { FrontFace::Clockwise } else { FrontFace::CounterClockwise }
}

/// The vertex attributes of shaders/lib/mesh.wesl by location: position, normal, map coordinates, altitude of the Sun's centre above the horizon that the shape
/// forms at the vertex (in angular radii of the Sun), colour.
fn mesh_vertices(draw: &Draw, key: &ShaderKey) -> Result<Vertices, PlanError> {
    let missing = |what: &str| PlanError::Module(format!("{}: {key} draws a mesh, but the mesh's {what} are missing", draw.name));
    let mesh = draw.uniforms.mesh.as_ref().ok_or_else(|| missing("triangles"))?;
    let model = &mesh.model;
    let attribute = |components: u32, values: &Arc<Vec<f32>>| Attribute { components, values: values.clone() };
    let mut attributes = vec![
        attribute(3, &model.positions),
        attribute(3, &model.normals),
        attribute(2, &model.map_coordinates),
        attribute(1, &mesh.sun_altitudes),
    ];
    if key.features().flags.vertex_colour {
        attributes.push(attribute(4, model.colours.as_ref().ok_or_else(|| missing("colours"))?));
    }
    Ok(Vertices::Mesh { attributes, indices: model.indices.clone() })
}

/// Of the parts of bodies, only globes test and write depth. Lines in space, orbits, minor planets, comets and refracted limbs are tested against the depth of
/// globes. Points of bodies are not: the scene has removed the light that nearer bodies hide. The other layers of a body (rings, air, clouds) may be closer
/// together than depth resolves, so they are drawn in the scene's order without depth.
fn depth_of(part: BodyPart) -> DepthState {
    let is_globe = part == BodyPart::Globe;
    DepthState { test: is_globe, write: is_globe }
}

/// The draw of one part of a body.
fn body_draw(draw: &Draw, camera: &Camera, provider: &impl ResourceProvider, sampling: SamplingQuality) -> Result<PlanDraw, PlanError> {
    let (width, height) = (camera.width, camera.height);
    let module = ModuleId::Keyed(ShaderKey::for_draw(&draw.features));
    let layout = provider.layout(&module)?;
    let uniform_bytes = uniform_bytes(&layout, &draw.uniforms, sampling.anisotropy)
        .map_err(|source| PlanError::Layout { module: module.to_string(), source })?;
    let (textures, samplers) = (maps::textures(draw, &layout, provider)?, maps::samplers(draw, &layout));
    let (vertices, cull, front_face) = match &module {
        ModuleId::Keyed(key) if key.features().shape == Shape::Mesh => {
            (mesh_vertices(draw, key)?, cull_of(&draw.features), front_face_of(camera))
        }
        // The two triangles of the draw's rectangle.
        _ => (Vertices::Count(6), Cull::None, FrontFace::default()),
    };
    Ok(PlanDraw {
        label: draw.name.clone(),
        module,
        uniform_bytes,
        textures,
        samplers,
        vertices,
        instances: Instances { count: 1, attributes: Vec::new() },
        // In the cost view, the costs of overlapping draws are added. In other views a draw covers what is behind it.
        blend: if draw.features.view == PixelView::Cost { Blend::Add } else { Blend::PremultipliedOver },
        shading_rate: ShadingRate::PerPixel,
        cull,
        front_face,
        depth: depth_of(draw.part),
        scissor: scissor(draw.uniforms.rect_in_clip, width, height),
        // The marks are those of the pixels where the ground's draw also shows the clouds.
        extent: Extent::of(draw, [width, height], coarse_air::marks_for_clouds(draw)),
    })
}
