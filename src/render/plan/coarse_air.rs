//! The coarse image of the air: the light of the air at every few pixels. Draws of bodies interpolate it instead of evaluating the atmosphere at each pixel. A
//! first pass evaluates the air of each body whose draw reads the image and, in an eclipse, the sunlight that passes the occluders to its ground. A second pass
//! marks the texels around which interpolation is accurate enough (alpha 1). If the ground's draw also shows clouds (`AirPass::ReadWithClouds`), it does so in
//! the pixels between four marked texels, which the clouds' draw then discards.
//!
//! In: the scene's draws, the layouts of modules. Out: the steps of both passes, and the draws with the first rows of their subimages. Always: a texel lies at
//! the corner of four pixels of the screen, `COARSE_AIR_PX` pixels from the next; each quantity (air or sunlight) of each draw has its own subimage, a range
//! of rows as wide as the image, because bodies overlap on the screen. Not here: which draws read the image (scene).

use super::error::PlanError;
use super::extent::MarkedImage;
use super::graph::{PassStep, Read, TargetDescriptor, Write};
use super::passes::{Blend, ColourFormat, Cull, DepthState, FrontFace, Instances, PlanDraw, ShadingRate, Vertices};
use super::provider::ResourceProvider;
use super::simple_draws::{FIRST_READ_BINDING, full_screen_draw};
use super::uniform_bytes::uniform_bytes;
use crate::scene::draw::constants::{COARSE_AIR_BORDER, COARSE_AIR_PX};
use crate::scene::draw::{AirPass, BodyPart, Draw, DrawFeatures, DrawUniforms};
use crate::shader::ModuleId;
use crate::shader::key::ShaderKey;
use glam::Vec4;
use std::borrow::Cow;

/// Resource names: the image that the first pass writes, and the marked image of the second.
const SAMPLES_TARGET: &str = "air samples";
const COARSE_AIR_TARGET: &str = "coarse air";
/// The simple shader of the second pass.
const MARKING_MODULE: &str = "coarse_air";
/// The texture variable by which the modules of bodies read the marked image.
pub const COARSE_AIR_TEXTURE: &str = "coarse_air";
/// The binding of that variable in shaders/lib/air/coarse.wesl.
const COARSE_AIR_BINDING: u32 = 14;

// shaders/lib/air/coarse.wesl detects that one of the four texels around a pixel is unmarked only if that texel lowers the interpolated alpha by more than
// 1/128. A texel's smallest bilinear weight is 1 / (2 COARSE_AIR_PX)^2: in x and y, a pixel's centre is at least half a pixel from each texel.
const _: () = assert!(4 * COARSE_AIR_PX * COARSE_AIR_PX < 128);

/// Whether the draw interpolates the coarse image.
fn reads_coarse_air(draw: &Draw) -> bool {
    draw.features.air_pass.is_reader()
}

/// The features of the draws that fill a body's subimages, in the order of the subimages: the air, then the sunlight past occluders.
fn subimages_of(draw: &Draw) -> impl Iterator<Item = DrawFeatures> {
    [draw.features.coarse_air(), draw.features.coarse_sunlight()].into_iter().flatten()
}

/// Indices of a body's draws of ground and clouds, if the ground's draw also shows clouds and draw `k` is one of the two.
fn ground_and_clouds(draws: &[Draw], k: usize) -> Option<(usize, usize)> {
    let is_part = |d: &Draw, part| d.body == draws[k].body && d.part == part && d.features.air_pass == AirPass::ReadWithClouds;
    let find = |part| draws.iter().position(|d| is_part(d, part));
    find(BodyPart::Globe).zip(find(BodyPart::Clouds)).filter(|(ground, clouds)| k == *ground || k == *clouds)
}

/// The modules of both passes; none if no draw reads the image.
pub(super) fn modules(draws: &[Draw]) -> Vec<ModuleId> {
    let mut all: Vec<_> = draws.iter().flat_map(subimages_of).map(|features| ModuleId::Keyed(ShaderKey::for_draw(&features))).collect();
    if !all.is_empty() {
        all.push(ModuleId::Simple(MARKING_MODULE));
    }
    all
}

/// Width and height of a subimage in texels, for a screen of this size in pixels.
pub fn coarse_air_subimage_size(screen: [u32; 2]) -> [u32; 2] {
    screen.map(|px| px.div_ceil(COARSE_AIR_PX) + 1 + 2 * COARSE_AIR_BORDER)
}

/// Number of subimages before the first one of draw `k`.
fn subimages_before(draws: &[Draw], k: usize) -> u32 {
    draws[..k].iter().flat_map(subimages_of).count() as u32
}

/// Draw `k` with the first rows of its subimages in its uniforms, if it reads the image. If the ground's draw also shows the clouds, both draws get the rows
/// of both: the ground's draw reads the air in front of the clouds, and the clouds' draw tests the marks of the ground's subimage.
pub(super) fn with_subimage_rows(draws: &[Draw], k: usize, screen: [u32; 2]) -> Cow<'_, Draw> {
    let draw = &draws[k];
    if !reads_coarse_air(draw) {
        return Cow::Borrowed(draw);
    }
    let mut draw = draw.clone();
    let (ground, clouds) = ground_and_clouds(draws, k).unwrap_or((k, k));
    let first_row = |subimage| (subimage * coarse_air_subimage_size(screen)[1]) as f32;
    draw.uniforms.air.coarse_first_row = first_row(subimages_before(draws, ground));
    // The sunlight's subimage follows that of the air (`subimages_of`).
    draw.uniforms.eclipse.coarse_first_row = first_row(subimages_before(draws, ground) + 1);
    draw.uniforms.clouds.coarse_first_row = first_row(subimages_before(draws, clouds));
    Cow::Owned(draw)
}

/// For the clouds' draw, if the ground's draw also shows clouds: the marked image. It tells which pixels the clouds' draw discards, because the ground's draw
/// shows their clouds. `draw`: as [`with_subimage_rows`] returns it.
pub(super) fn marks_for_clouds(draw: &Draw) -> Option<MarkedImage> {
    let is_shared = draw.part == BodyPart::Clouds && draw.features.air_pass == AirPass::ReadWithClouds;
    is_shared.then(|| {
        let first_texel = [COARSE_AIR_BORDER, COARSE_AIR_BORDER + draw.uniforms.air.coarse_first_row as u32];
        MarkedImage { binding: COARSE_AIR_BINDING, pixels_per_texel: COARSE_AIR_PX, first_texel }
    })
}

/// The resources that a step with these draws reads.
pub(super) fn reads_of(draws: &[Draw]) -> Vec<Read> {
    if draws.iter().any(reads_coarse_air) { vec![Read { resource: COARSE_AIR_TARGET, binding: COARSE_AIR_BINDING }] } else { Vec::new() }
}

/// The steps of both passes; none if no draw reads the image.
pub(super) fn steps(
    draws: &[Draw],
    screen: [u32; 2],
    format: ColourFormat,
    provider: &impl ResourceProvider,
) -> Result<Vec<PassStep>, PlanError> {
    let subimage_count = subimages_before(draws, draws.len());
    if subimage_count == 0 {
        return Ok(Vec::new());
    }
    let [width, subimage_height] = coarse_air_subimage_size(screen);
    let height = subimage_count * subimage_height;
    let mut sampling_draws = Vec::new();
    let mut marking_draws = Vec::new();
    for (k, draw) in draws.iter().enumerate() {
        for (subimage, features) in (subimages_before(draws, k)..).zip(subimages_of(draw)) {
            let is_sunlight = features.air_pass == AirPass::SunlightDrawn;
            // The accepted error of the light (not of its square root, which the texels hold): as a fraction of the light (x), and as a fraction of the Sun's
            // irradiance (y).
            let bound = if is_sunlight { draw.uniforms.eclipse.max_coarse_error } else { draw.uniforms.air.max_coarse_error };
            // A negative bound: this quantity must not be interpolated. Its subimage keeps the clear colour, whose alpha 0 marks no texel.
            if bound.min_element() < 0.0 {
                continue;
            }
            let rect = rect_in_subimage(draw.uniforms.rect_in_clip, screen);
            let first_row = subimage * subimage_height;
            let scissor = [rect[0], rect[1] + first_row, rect[2], rect[3] + first_row];
            let uniforms = uniforms_over_texels(&draw.uniforms, rect, scissor, screen, [width, height]);
            let quantity = if is_sunlight { "sunlight" } else { "air" };
            let label = format!("{} {quantity} samples", draw.name);
            sampling_draws.push(sampling_draw(label, &features, uniforms, scissor, provider)?);
            // If the ground's draw also shows clouds: for the air in front of the ground, the number of subimages from this one to that of the air in front of
            // the clouds. Otherwise 0.
            let subimages_to_clouds = ground_and_clouds(draws, k)
                .filter(|(ground, _)| *ground == k && !is_sunlight)
                .map_or(0, |(_, clouds)| subimages_before(draws, clouds) - subimage);
            let marking = full_screen_draw(MARKING_MODULE, [width, height], provider, |w| {
                w.vec2("bound", bound)?;
                w.f32("rows_to_clouds", (subimages_to_clouds * subimage_height) as f32)
            })?;
            marking_draws.push(PlanDraw { label: format!("{} coarse {quantity}", draw.name), scissor, ..marking });
        }
    }
    let target = |resource| TargetDescriptor { resource, width, height, format, samples: 1, clear: [0.0; 4], has_depth: false };
    let reads_samples = vec![Read { resource: SAMPLES_TARGET, binding: FIRST_READ_BINDING }];
    Ok(vec![
        PassStep { name: SAMPLES_TARGET, reads: vec![], writes: Write::New(target(SAMPLES_TARGET)), draws: sampling_draws },
        PassStep { name: COARSE_AIR_TARGET, reads: reads_samples, writes: Write::New(target(COARSE_AIR_TARGET)), draws: marking_draws },
    ])
}

/// The draw that fills one subimage in the first pass.
fn sampling_draw(
    label: String,
    features: &DrawFeatures,
    mut uniforms: DrawUniforms,
    scissor: [u32; 4],
    provider: &impl ResourceProvider,
) -> Result<PlanDraw, PlanError> {
    // The module evaluates the first lights only: the Sun, and a second one if the air shows it.
    uniforms.lights.truncate(usize::from(features.lights));
    // The module reads no map.
    let map_taps = 1;
    let module = ModuleId::Keyed(ShaderKey::for_draw(features));
    let layout = provider.layout(&module)?;
    let uniform_bytes =
        uniform_bytes(&layout, &uniforms, map_taps).map_err(|source| PlanError::Layout { module: module.to_string(), source })?;
    Ok(PlanDraw {
        label,
        module,
        uniform_bytes,
        textures: Vec::new(),
        samplers: Vec::new(),
        // The two triangles of `uniforms.rect_in_clip`.
        vertices: Vertices::Count(6),
        instances: Instances { count: 1, attributes: Vec::new() },
        blend: Blend::Replace,
        shading_rate: ShadingRate::PerPixel,
        cull: Cull::None,
        front_face: FrontFace::default(),
        depth: DepthState { test: false, write: false },
        scissor,
        extent: None,
    })
}

/// Distance from a subimage's edge to the screen's edge, in texels: the border, and half a texel because the next texel's centre lies on
/// the screen's edge.
fn screen_edge_texels() -> f32 {
    COARSE_AIR_BORDER as f32 + 0.5
}

/// The texels of a subimage around a rectangle of the screen, and one more on each side: left, top, right and bottom edge (the last two exclusive).
fn rect_in_subimage(rect_in_clip: Vec4, screen: [u32; 2]) -> [u32; 4] {
    let size = coarse_air_subimage_size(screen);
    let texel_of = |clip: f32, side: u32| 0.5 * (1.0 + clip) * side as f32 / COARSE_AIR_PX as f32 + screen_edge_texels();
    let [x0, y0, x1, y1] = rect_in_clip.to_array();
    let first = |texel: f32| (texel.floor() - 1.0).max(0.0) as u32;
    let end = |texel: f32, limit: u32| ((texel.ceil() + 1.0).max(0.0) as u32).min(limit);
    let [left, top] = [first(texel_of(x0, screen[0])).min(size[0]), first(texel_of(-y0, screen[1])).min(size[1])];
    [left, top, end(texel_of(x1, screen[0]), size[0]).max(left), end(texel_of(-y1, screen[1]), size[1]).max(top)]
}

/// The uniforms for drawing a rectangle of texels instead of the draw's rectangle on the screen. The view rays are those of the draw, extrapolated where the
/// texels extend beyond the draw's rectangle. `in_subimage`: the rectangle of texels in the subimage; `in_image`: the same rectangle in the image. `screen`,
/// `image`: their sizes in pixels and in texels.
fn uniforms_over_texels(
    uniforms: &DrawUniforms,
    in_subimage: [u32; 4],
    in_image: [u32; 4],
    screen: [u32; 2],
    image: [u32; 2],
) -> DrawUniforms {
    let [x0, y0, x1, y1] = uniforms.rect_in_clip.to_array();
    let clip_of = |texel: u32, side: u32| 2.0 * (texel as f32 - screen_edge_texels()) * COARSE_AIR_PX as f32 / side as f32 - 1.0;
    // u and v of the texels' edges: 0 to 1 from the left and the top edge of the draw's rectangle.
    let fraction = |clip: f32, from: f32, to: f32| (clip - from) / (to - from);
    let [u0, u1] = [in_subimage[0], in_subimage[2]].map(|t| fraction(clip_of(t, screen[0]), x0, x1));
    // Clip y points up, texel rows down.
    let [v0, v1] = [in_subimage[1], in_subimage[3]].map(|t| fraction(-clip_of(t, screen[1]), y0, y1));
    let clip_in_image = |texel: u32, side: u32| 2.0 * texel as f32 / side as f32 - 1.0;
    let [left, right] = [in_image[0], in_image[2]].map(|t| clip_in_image(t, image[0]));
    let [top, bottom] = [in_image[1], in_image[3]].map(|t| -clip_in_image(t, image[1]));
    // `anchor_origin` and `ray_origin` are the anchor and the ray direction at the rectangle's top left corner; `_du` and `_dv` are their changes across it.
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
