//! Plans of images that are composed of several frames: stereo pairs, domes, whole spheres, and the warp onto a projector's screen.
//!
//! In: the scenes of the frames and their arrangement ([`Composite`]). Out: one plan with the passes of every frame, followed by the passes that combine the
//! frames. The frames of a dome or sphere are the faces of a cube around the camera, those of a stereo pair the views of both eyes. Always: the faces are
//! combined before bloom and tone map, so that no seam shows; both eyes are tone-mapped before they are combined, since an anaglyph combines display values.
//! Not here: the choice of frames (scene::composite).

use super::build::{DISPLAY_TARGET, HDR_TARGET, SamplingQuality, hdr_steps, modules, plan, steps_with_faces};
use super::error::PlanError;
use super::graph;
use super::passes::{Attribute, Blend, ColourFormat, Pass, Plan, PlanDraw, TextureBinding, TextureSource, Vertices};
use super::provider::ResourceProvider;
use super::simple_draws::{FIRST_READ_BINDING, full_screen_draw};
use crate::scene::composite::{Arrangement, BORDER_PX, Composite, Eyes, Faces};
use crate::scene::request::{Projection, StereoLayout, WarpMesh};
use crate::shader::ModuleId;
use glam::{DVec2, Vec2};
use std::sync::Arc;

/// Name of the pass that combines both eyes.
const STEREO_PASS: &str = "both eyes";
/// Name of the warp pass.
const WARP_PASS: &str = "screen";
/// Number of points along each side of a pixel at which the faces, or an image to be warped, are read. More points antialias better; the time grows with the
/// square of this number.
const SAMPLES_PER_SIDE: f32 = 4.0;
/// As [`SAMPLES_PER_SIDE`], for drafts, whose frames have one sample per pixel.
const DRAFT_SAMPLES_PER_SIDE: f32 = 2.0;

fn stereo_module(layout: StereoLayout) -> &'static str {
    match layout {
        StereoLayout::Anaglyph => "anaglyph",
        StereoLayout::SideBySide => "side_by_side",
        StereoLayout::Interlaced => "interlace",
    }
}

/// The module that resamples the faces of a dome or whole-sphere image; a perspective image has no faces.
fn sphere_module(projection: Projection) -> &'static str {
    if projection == Projection::Fisheye { "fisheye" } else { "equirectangular" }
}

/// The modules that a composite's plan runs, each once. `is_warped`: whether the plan ends with a warp.
pub fn composite_modules(composite: &Composite, is_warped: bool) -> Vec<ModuleId> {
    let mut all: Vec<ModuleId> = composite.scenes.iter().chain([&composite.whole_image]).flat_map(modules).collect();
    match &composite.arrangement {
        Arrangement::Eyes(eyes) => all.push(ModuleId::Simple(stereo_module(eyes.layout))),
        Arrangement::Faces(faces) => all.push(ModuleId::Simple(sphere_module(faces.image.projection))),
        Arrangement::Single => {}
    }
    all.extend(is_warped.then_some(ModuleId::Simple("warp")));
    all.sort();
    all.dedup();
    all
}

/// Appends passes, and shifts the pass indices that they read by the number of passes already in the plan.
fn append(plan: &mut Plan, mut passes: Vec<Pass>) {
    let passes_before = plan.passes.len();
    for texture in passes.iter_mut().flat_map(|p| &mut p.draws).flat_map(|d| &mut d.textures) {
        if let TextureSource::PassOutput(k) = &mut texture.source {
            *k += passes_before;
        }
    }
    plan.passes.extend(passes);
}

fn samples_per_side(sampling: SamplingQuality) -> f32 {
    if sampling.samples > 1 { SAMPLES_PER_SIDE } else { DRAFT_SAMPLES_PER_SIDE }
}

/// Plans an image of one or several frames. `warp`: the mesh that warps it, and the output size in pixels.
///
/// # Errors
/// See [`PlanError`].
pub fn composite(
    composite: &Composite,
    provider: &impl ResourceProvider,
    sampling: SamplingQuality,
    warp: Option<(&WarpMesh, [u32; 2])>,
) -> Result<Plan, PlanError> {
    let mut combined = match &composite.arrangement {
        Arrangement::Single => plan(&composite.whole_image, provider, sampling)?,
        Arrangement::Eyes(eyes) => plan_eyes(composite, eyes, provider, sampling)?,
        Arrangement::Faces(faces) => plan_faces(composite, faces, provider, sampling)?,
    };
    if let Some((mesh, size)) = warp {
        let (image, image_px) = last_pass(&combined);
        let draw = warp_draw(mesh, size, image_px, provider, sampling)?;
        let textures = vec![TextureBinding { binding: FIRST_READ_BINDING, source: TextureSource::PassOutput(image) }];
        combined.passes.push(display_pass(WARP_PASS, size, sampling.samples, PlanDraw { textures, ..draw }));
    }
    Ok(combined)
}

/// Index of the last pass, and its size in pixels.
fn last_pass(plan: &Plan) -> (usize, [u32; 2]) {
    (plan.passes.len().saturating_sub(1), plan.passes.last().map_or([1, 1], |p| [p.width, p.height]))
}

/// A pass with one draw into a display target cleared to black.
fn display_pass(name: &'static str, [width, height]: [u32; 2], samples: u8, draw: PlanDraw) -> Pass {
    let clear = [0.0, 0.0, 0.0, 1.0];
    Pass { name, width, height, format: ColourFormat::Rgba8Unorm, samples, clear, has_depth: false, draws: vec![draw] }
}

/// The complete plans of both eyes' frames, then the pass that combines their display images.
fn plan_eyes(composite: &Composite, eyes: &Eyes, provider: &impl ResourceProvider, sampling: SamplingQuality) -> Result<Plan, PlanError> {
    let mut combined = Plan { passes: Vec::new() };
    let mut images = Vec::new();
    for scene in &composite.scenes {
        append(&mut combined, plan(scene, provider, sampling)?.passes);
        images.push(last_pass(&combined));
    }
    // The left eye's image begins at `left_column` and ends at the last column of its frame. The right eye's image is as wide.
    let [left_column, _] = eyes.first_columns;
    let eye_px = images.first().map_or([1, 1], |(_, [w, h])| [w - left_column, *h]);
    let is_side_by_side = eyes.layout == StereoLayout::SideBySide;
    let size = if is_side_by_side { [2 * eye_px[0], eye_px[1]] } else { eye_px };
    let draw = full_screen_draw(stereo_module(eyes.layout), size, provider, |w| {
        w.vec2("first_columns_px", Vec2::from_array(eyes.first_columns.map(|c| c as f32)))?;
        if is_side_by_side { w.f32("eye_width_px", eye_px[0] as f32) } else { Ok(()) }
    })?;
    let textures =
        (FIRST_READ_BINDING..).zip(&images).map(|(binding, (k, _))| TextureBinding { binding, source: TextureSource::PassOutput(*k) });
    combined.passes.push(display_pass(STEREO_PASS, size, 1, PlanDraw { textures: textures.collect(), ..draw }));
    Ok(combined)
}

/// The linear images of the faces, then the plan of the finished image, in which one draw resamples the faces.
fn plan_faces(
    composite: &Composite,
    faces: &Faces,
    provider: &impl ResourceProvider,
    sampling: SamplingQuality,
) -> Result<Plan, PlanError> {
    let mut combined = Plan { passes: Vec::new() };
    let mut hdr_passes = Vec::new();
    for (scene, visible_rect) in composite.scenes.iter().zip(&faces.visible_rects) {
        // The background is transparent, because the finished image draws the stars behind the faces.
        let transparent = [0.0; 4];
        let no_faces = None;
        let mut face_plan = graph::compile(&hdr_steps(scene, provider, sampling, transparent, no_faces)?, HDR_TARGET)?;
        // Only the draws of the face's own pass are clipped to the visible rectangle: the images that this pass reads, such as the coarse image of the air,
        // have other pixel coordinates.
        for draw in face_plan.passes.iter_mut().filter(|p| p.name == HDR_TARGET).flat_map(|p| &mut p.draws) {
            let ([x0, y0, x1, y1], [left, top, right, bottom]) = (draw.scissor, *visible_rect);
            let [x0, y0] = [x0.max(left), y0.max(top)];
            draw.scissor = [x0, y0, x1.min(right).max(x0), y1.min(bottom).max(y0)];
        }
        append(&mut combined, face_plan.passes);
        hdr_passes.push(combined.passes.len() - 1);
    }
    let draw = sphere_draw(faces, provider, samples_per_side(sampling))?;
    let resampling_module = draw.module.clone();
    // The faces are antialiased already; stars and points are smooth sprites.
    let single_sample = SamplingQuality { samples: 1, ..sampling };
    let whole_plan = graph::compile(&steps_with_faces(&composite.whole_image, provider, single_sample, Some(draw))?, DISPLAY_TARGET)?;
    // A face without a frame is not visible in the image, so any pass may be bound for it.
    let pass_of = |frame: Option<usize>| hdr_passes.get(frame.unwrap_or(0)).copied().unwrap_or(0);
    let passes_before = combined.passes.len();
    append(&mut combined, whole_plan.passes);
    for draw in combined.passes[passes_before..].iter_mut().flat_map(|p| &mut p.draws).filter(|d| d.module == resampling_module) {
        let textures = (FIRST_READ_BINDING..)
            .zip(&faces.frame_of_face)
            .map(|(binding, f)| TextureBinding { binding, source: TextureSource::PassOutput(pass_of(*f)) });
        draw.textures = textures.collect();
    }
    Ok(combined)
}

/// The draw that resamples the faces to the dome or whole-sphere image.
fn sphere_draw(faces: &Faces, provider: &impl ResourceProvider, samples_per_side: f32) -> Result<PlanDraw, PlanError> {
    let image = &faces.image;
    let (width, height) = (image.width, image.height);
    let scale = image.radians_per_pixel().as_vec2();
    let draw = full_screen_draw(sphere_module(image.projection), [width, height], provider, |w| {
        w.vec2("middle", Vec2::new(width as f32, height as f32) / 2.0)?;
        if image.projection == Projection::Fisheye {
            w.f32("radians_per_pixel", scale.x)?;
            w.f32("half_fov", image.half_fov_rad as f32)?;
        } else {
            w.vec2("radians_per_pixel", scale)?;
        }
        w.f32("face_px", faces.face_px as f32)?;
        w.f32("border_px", BORDER_PX as f32)?;
        w.f32("samples_per_side", samples_per_side)
    })?;
    Ok(PlanDraw { blend: Blend::PremultipliedOver, ..draw })
}

/// Draws the warp mesh over the projector's whole screen, textured with an image of `image_px` pixels.
fn warp_draw(
    mesh: &WarpMesh,
    [width, height]: [u32; 2],
    image_px: [u32; 2],
    provider: &impl ResourceProvider,
    sampling: SamplingQuality,
) -> Result<PlanDraw, PlanError> {
    let screen = DVec2::new(f64::from(width), f64::from(height));
    let image = DVec2::from_array(image_px.map(f64::from));
    // On the screen, the mesh's y runs from -1 to 1, its x from minus to plus the aspect ratio.
    let px_per_unit = 0.5 * screen.y;
    let flip_y = DVec2::new(1.0, -1.0);
    let nodes = mesh.nodes();
    let vec2_attribute = |value: &dyn Fn(usize) -> Vec2| Attribute {
        components: 2,
        values: Arc::new((0..nodes.len()).flat_map(|k| value(k).to_array()).collect()),
    };
    // For each node, the derivatives of its position in the image by screen x and by screen y.
    let gradients = mesh.gradients();
    // Texels per pixel. The mesh's v and y point up; texture rows and screen rows run down.
    let texels_per_px = |gradient: DVec2| (gradient * image / px_per_unit * flip_y).as_vec2();
    let texel_and_brightness =
        |k: usize| (DVec2::new(nodes[k].image.x, 1.0 - nodes[k].image.y) * image).extend(nodes[k].brightness).as_vec3();
    // Position in clip space; position in the image (texels from the top left) and brightness; change of the position in the image per pixel of the screen to
    // the right and down.
    let attributes = vec![
        vec2_attribute(&|k| (nodes[k].screen * DVec2::new(screen.y / screen.x, 1.0)).as_vec2()),
        Attribute { components: 3, values: Arc::new((0..nodes.len()).flat_map(|k| texel_and_brightness(k).to_array()).collect()) },
        vec2_attribute(&|k| texels_per_px(gradients[k][0])),
        vec2_attribute(&|k| -texels_per_px(gradients[k][1])),
    ];
    let draw = full_screen_draw("warp", [width, height], provider, |w| w.f32("samples_per_side", samples_per_side(sampling)))?;
    Ok(PlanDraw { vertices: Vertices::Mesh { attributes, indices: Arc::new(mesh.triangles().to_vec()) }, ..draw })
}
