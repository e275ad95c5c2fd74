//! The draws of simple shaders: stars, points, lines, refracted limbs, tone map, bloom, outline.
//!
//! A simple shader is one fixed module, `shaders/entry/<name>.wesl`, whereas the module of a body is generated from the body's features. In: the scene and the
//! layouts of the shaders' uniform blocks. Out: draws and steps with their uniform bytes filled by field name. Always: only modules that [`modules`] returns
//! are used. Not here: the draws of bodies, of labels, of corona and glare (`light_around_sun`), and of minor planets, comets' comas, tails and orbits
//! (`small_bodies`); the choice of what is drawn (scene).

use super::error::PlanError;
use super::graph::{PassStep, Read, TargetDescriptor, Write};
use super::passes::{Attribute, Blend, ColourFormat, Cull, DepthState, FrontFace, Instances, PlanDraw, ShadingRate, Vertices};
use super::provider::ResourceProvider;
use super::scissor::scissor;
use crate::scene::annotation::strokes::LineSegment;
use crate::scene::camera::ViewRays;
use crate::scene::draw::{PixelView, Point, StarSprite};
use crate::scene::labels::SELECTED_COLOUR;
use crate::scene::orbits;
use crate::scene::refracted_limb::RefractedLimb;
use crate::scene::request::ToneMap;
use crate::scene::{CORE_SIGMA_PX, GLARE_SCALE_RADIUS_PX, MIN_POINT_RADIUS_PX, Scene, disc_glare_spread, point_spread};
use crate::shader::ModuleId;
use crate::shader::UniformWriter;
use crate::shader::reflect::LayoutError;
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// The binding of the first image that a full-screen draw reads; others follow it.
pub(super) const FIRST_READ_BINDING: u32 = 1;

/// The filmic tone map is linear up to this fraction of white. There the shoulder in shaders/lib/display.wesl begins, with slope 1.
const FILMIC_LINEAR_LIMIT: f32 = 0.8;

/// A Gaussian halo of bloom.
pub(super) struct Halo {
    /// Fraction of the radiance above white that is added.
    pub fraction: f32,
    /// Standard deviation as a fraction of the image height.
    pub relative_sigma: f32,
}

/// The narrow and the wide halo of bloom. Chosen by eye to resemble the halo of a clean camera lens; not measured.
pub(super) const BLOOM_NARROW: Halo = Halo { fraction: 0.10, relative_sigma: 0.006 };
pub(super) const BLOOM_WIDE: Halo = Halo { fraction: 0.05, relative_sigma: 0.03 };
/// Upper limit of the radiance above white that blooms, in units of white. The Sun's disc, up to a million times white, has its own glare (`glow`).
pub(super) const BLOOM_MAX_EXCESS: f32 = 16.0;
/// Factor by which each of bloom's two downsampling steps reduces the sides of the image.
const DOWNSAMPLING: u32 = 4;

/// Standard deviation of the outline's blur as a fraction of the image height, and its minimum in pixels. Chosen by eye.
const OUTLINE_RELATIVE_SIGMA: f32 = 0.0025;
const OUTLINE_MIN_SIGMA_PX: f32 = 1.5;
/// Radius of a blur in standard deviations, as in shaders/entry/blur.wesl.
const BLUR_RADIUS_SIGMAS: f32 = 3.0;

/// The simple shaders that a scene's plan runs.
pub(super) fn modules(scene: &Scene) -> Vec<&'static str> {
    // `times` of the minor planets has one entry per body.
    let conditions = [
        (scene.background.is_some(), "sky_background"),
        (!scene.sky_images.is_empty(), "sky_image"),
        (!scene.points.is_empty() || !scene.stars.is_empty() || !scene.comets.heads.is_empty(), "point"),
        (!scene.lines_in_space.is_empty() || !scene.sky_lines.is_empty() || !scene.ground_lines.is_empty(), "line"),
        (!scene.orbits.is_empty(), "orbit"),
        (scene.minor_planets.as_ref().is_some_and(|m| !m.times.is_empty()), "minor_planets"),
        (!scene.comets.patches.is_empty(), "comet_tail"),
        (scene.corona.is_some(), "corona"),
        (!scene.refracted_limbs.is_empty(), "refracted_limb"),
        (scene.glare.is_some(), "glow"),
        (scene.has_bloom, "shrink"),
        (scene.has_bloom || scene.outlined_shape.is_some(), "blur"),
        (scene.has_bloom, "tone_map_bloom"),
        (!scene.has_bloom, "tone_map"),
        (scene.outlined_shape.is_some(), "outline"),
        (scene.labels.is_some() || scene.line_texts.is_some(), "label"),
        (scene.labels.as_ref().is_some_and(|l| !l.dots.is_empty()), "dot"),
    ];
    conditions.into_iter().filter(|(is_used, _)| *is_used).map(|(_, name)| name).collect()
}

/// A draw of a simple shader over the scene's full image.
pub(super) fn simple_draw(
    module: &'static str,
    scene: &Scene,
    provider: &impl ResourceProvider,
    fill: impl FnOnce(&mut UniformWriter<'_>) -> Result<(), LayoutError>,
) -> Result<PlanDraw, PlanError> {
    full_screen_draw(module, [scene.camera.width, scene.camera.height], provider, fill)
}

/// A draw of a simple shader: one triangle over the full target, without depth. `fill` writes the uniforms by field name. Callers override fields of the draw
/// for other geometry or state.
pub(super) fn full_screen_draw(
    module: &'static str,
    [width, height]: [u32; 2],
    provider: &impl ResourceProvider,
    fill: impl FnOnce(&mut UniformWriter<'_>) -> Result<(), LayoutError>,
) -> Result<PlanDraw, PlanError> {
    let name = ModuleId::Simple(module);
    let layout = provider.layout(&name)?;
    let mut w = layout.writer();
    let uniform_bytes = fill(&mut w).and_then(|()| w.finish()).map_err(|source| PlanError::Layout { module: module.to_owned(), source })?;
    Ok(PlanDraw {
        label: module.replace('_', " "),
        module: name,
        uniform_bytes,
        textures: Vec::new(),
        samplers: Vec::new(),
        vertices: Vertices::Count(3),
        instances: Instances { count: 1, attributes: Vec::new() },
        blend: Blend::Replace,
        shading_rate: ShadingRate::PerPixel,
        cull: Cull::None,
        front_face: FrontFace::default(),
        depth: DepthState { test: false, write: false },
        scissor: [0, 0, width, height],
        extent: None,
    })
}

/// An instance attribute: the number of components, and a function that returns their values for an item.
pub(super) type InstanceAttribute<T> = (u32, fn(&T) -> Vec<f32>);

/// Rectangles of two triangles, one per item, with these instance attributes.
pub(super) fn instanced_rectangles<T>(items: &[T], attributes: &[InstanceAttribute<T>]) -> (Vertices, Instances) {
    let attribute = |(components, values): &InstanceAttribute<T>| Attribute {
        components: *components,
        values: Arc::new(items.iter().flat_map(values).collect()),
    };
    let count = u32::try_from(items.len()).unwrap_or(u32::MAX);
    (Vertices::Count(6), Instances { count, attributes: attributes.iter().map(attribute).collect() })
}

/// The depth state of draws that can be hidden by nearer bodies and hide nothing themselves.
pub(super) const DEPTH_TESTED: DepthState = DepthState { test: true, write: false };

/// A sprite's radius in pixels, the amplitudes of its core and its glare for a flux of 1 (see [`point_spread`]), and `stretch`, its width over its height
/// (above 1 away from the equator of an equirectangular image).
fn sprite_attribute(radius_px: f32, stretch: f32) -> Vec<f32> {
    // A wider sprite spreads the same flux over a greater area.
    let [core, glare] = point_spread(f64::from(radius_px)).map(|amplitude| amplitude / f64::from(stretch));
    vec![radius_px, core as f32, glare as f32, stretch]
}

/// As [`sprite_attribute`], for the glare of a disc, which has no core.
fn disc_glare_attribute(point: &Point) -> Vec<f32> {
    let [_scale_radius_px, amplitude] = disc_glare_spread(point.radius_px.into(), point.disc_radius_px.into());
    vec![point.radius_px, 0.0, amplitude as f32 / point.stretch, point.stretch]
}

/// Point sprites, blended additively unless the caller changes that: one draw, or none without items. `glare_scale_radius_px`: scale radius
/// of the glare's profile, [`GLARE_SCALE_RADIUS_PX`] except for the glare of a disc, which is wider.
pub(super) fn sprites<T>(
    label: &str,
    items: &[T],
    attributes: &[InstanceAttribute<T>],
    glare_scale_radius_px: f64,
    scene: &Scene,
    provider: &impl ResourceProvider,
) -> Result<Vec<PlanDraw>, PlanError> {
    if items.is_empty() {
        return Ok(Vec::new());
    }
    let (vertices, instances) = instanced_rectangles(items, attributes);
    let draw = simple_draw("point", scene, provider, |w| {
        w.vec2("pixel_size", scene.camera.clip_per_pixel())?;
        w.f32("core_sigma_px", CORE_SIGMA_PX as f32)?;
        w.f32("glare_scale_radius_px", glare_scale_radius_px as f32)
    })?;
    Ok(vec![PlanDraw { label: label.into(), vertices, instances, blend: Blend::Add, ..draw }])
}

/// Instance attributes of the sprites of stars and of comets' heads.
pub(super) const STAR_ATTRIBUTES: [InstanceAttribute<StarSprite>; 3] = [
    (3, |s| s.centre.to_array().to_vec()),
    (4, |s| sprite_attribute(s.radius_px, s.stretch)),
    (4, |s| s.flux.extend(0.0).to_array().to_vec()),
];

pub(super) fn stars(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    // A radius of 0 means that another frame of a composed image draws the star.
    let drawn_here: Vec<StarSprite> = scene.stars.iter().filter(|s| s.radius_px > 0.0).copied().collect();
    sprites("stars", &drawn_here, &STAR_ATTRIBUTES, GLARE_SCALE_RADIUS_PX, scene, provider)
}

/// Largest hidden area, in pixels, for which a point gets no draw that hides its background. Even in front of white, such an area changes a pixel by less than
/// half a level of 255, because a pixel gets at most 0.38 of the area: the peak of the sprite, `point_peak` in scene/point.rs.
const MIN_COVERED_PX: f32 = 1.0 / 255.0;

/// The draws of points: first the sprites that hide what is behind the points, then the sprites of the points' light and of the glare of discs, each with its
/// own profile. In this order no point hides the light of another: from that light the scene has already removed what nearer bodies hide.
pub(super) fn points(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    let centre: InstanceAttribute<Point> = (3, |p| p.centre.to_array().to_vec());
    // Light in red, green and blue, then the hidden area in pixels: 0 here, because these draws hide nothing.
    let flux: InstanceAttribute<Point> = (4, |p| p.flux.extend(0.0).to_array().to_vec());
    let light_attributes = [centre, (4, |p| sprite_attribute(p.radius_px, p.stretch)), flux];
    let glare_attributes = [centre, (4, disc_glare_attribute), flux];
    let hidden_area: InstanceAttribute<Point> = (4, |p| vec![0.0, 0.0, 0.0, p.covered_px]);
    // A sprite of this radius is all core, without glare: its size does not depend on the point's light.
    let cover_attributes = [centre, (4, |p| sprite_attribute(MIN_POINT_RADIUS_PX as f32, p.stretch)), hidden_area];
    let covering: Vec<Point> = scene.points.iter().filter(|p| p.covered_px > MIN_COVERED_PX).cloned().collect();
    let covers = sprites("cover of points", &covering, &cover_attributes, GLARE_SCALE_RADIUS_PX, scene, provider)?;
    let covers = covers.into_iter().map(|draw| PlanDraw { blend: Blend::PremultipliedOver, ..draw });
    let (discs, points): (Vec<Point>, Vec<Point>) = scene.points.iter().cloned().partition(Point::is_disc_glare);
    let mut draws: Vec<PlanDraw> =
        covers.chain(sprites("points", &points, &light_attributes, GLARE_SCALE_RADIUS_PX, scene, provider)?).collect();
    for disc in &discs {
        let [scale_radius_px, _amplitude] = disc_glare_spread(disc.radius_px.into(), disc.disc_radius_px.into());
        draws.extend(sprites("glare of a disc", std::slice::from_ref(disc), &glare_attributes, scale_radius_px, scene, provider)?);
    }
    Ok(draws)
}

/// Traces of past motion, cones of eclipses and frames of instruments, depth-tested against the bodies.
pub(super) fn lines_in_space(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    segment_draws("lines in space", &scene.lines_in_space, DEPTH_TESTED, scene, provider)
}

/// Lines that are not depth-tested: only the drawing order decides what covers them.
pub(super) fn lines_without_depth(
    label: &str,
    segments: &[LineSegment],
    scene: &Scene,
    provider: &impl ResourceProvider,
) -> Result<Vec<PlanDraw>, PlanError> {
    segment_draws(label, segments, DepthState { test: false, write: false }, scene, provider)
}

fn segment_draws(
    label: &str,
    segments: &[LineSegment],
    depth: DepthState,
    scene: &Scene,
    provider: &impl ResourceProvider,
) -> Result<Vec<PlanDraw>, PlanError> {
    if segments.is_empty() {
        return Ok(Vec::new());
    }
    let (vertices, instances) = instanced_rectangles::<LineSegment>(
        segments,
        &[
            (3, |p| p.ends[0].to_array().to_vec()),
            (3, |p| p.ends[1].to_array().to_vec()),
            (2, |p| p.normals[0].to_array().to_vec()),
            (2, |p| p.normals[1].to_array().to_vec()),
            (2, |p| p.opacity.to_vec()),
            (3, |p| p.colour.to_array().to_vec()),
        ],
    );
    let draw = simple_draw("line", scene, provider, |w| {
        w.vec2("pixel_size", scene.camera.clip_per_pixel())?;
        // All lines are as wide and as bright as orbits.
        w.f32("half_width_px", orbits::HALF_WIDTH_PX)?;
        w.f32("radiance", orbits::RELATIVE_RADIANCE / scene.exposure.factor_f32())
    })?;
    Ok(vec![PlanDraw { label: label.into(), vertices, instances, blend: Blend::PremultipliedOver, depth, ..draw }])
}

/// The draws of a body's refracted limb: one that occludes the Sun's disc drawn without refraction (`None` if no such disc was drawn), and one that
/// adds the refracted light.
pub(super) fn refracted_limb(
    scene: &Scene,
    limb: &RefractedLimb,
    provider: &impl ResourceProvider,
) -> Result<(Option<PlanDraw>, PlanDraw), PlanError> {
    // The value of the uniform `removes_sun` for the draw that adds the refracted light; otherwise it is the fraction of the unrefracted Sun that the draw
    // removes.
    const ADDS_LIGHT: f32 = 0.0;
    let limb_draw = |rays: &ViewRays, removes_sun: f32| -> Result<PlanDraw, PlanError> {
        let draw = simple_draw("refracted_limb", scene, provider, |w| {
            w.vec4("rect_in_clip", rays.rect_in_clip)?;
            w.vec3("anchor_origin", rays.anchor_origin)?;
            w.vec3("anchor_du", rays.anchor_du)?;
            w.vec3("anchor_dv", rays.anchor_dv)?;
            w.vec3("ray_origin", rays.ray_origin)?;
            w.vec3("ray_du", rays.ray_du)?;
            w.vec3("ray_dv", rays.ray_dv)?;
            w.vec4_array("silhouette_form", &rays.silhouette_form)?;
            w.vec3("camera_in_unit_sphere", rays.camera_in_unit_sphere)?;
            w.vec3("axis_ratios", limb.axis_ratios)?;
            w.f32("depth", limb.depth)?;
            w.vec4("sun_direction", limb.sun_direction)?;
            w.vec4_array("sun_basis", &limb.sun_basis)?;
            w.vec4_array("sun_limb_darkening", &limb.sun_limb_darkening)?;
            w.vec4_array("air_edges", &limb.air_edges)?;
            w.vec4_array("air_transmittance", &limb.air_transmittance)?;
            w.f32("removes_sun", removes_sun)
        })?;
        let scissor = scissor(rays.rect_in_clip, scene.camera.width, scene.camera.height);
        Ok(PlanDraw { vertices: Vertices::Count(6), blend: Blend::PremultipliedOver, depth: DEPTH_TESTED, scissor, ..draw })
    };
    let occluding = limb.unrefracted_sun.as_ref().map(|rays| limb_draw(rays, limb.drawn_fraction)).transpose()?;
    Ok((occluding, limb_draw(&limb.rays, ADDS_LIGHT)?))
}

/// Resource names of a halo's images, in the order in which they are made.
struct HaloImages {
    downsampled: &'static str,
    blurred_x: &'static str,
    blurred: &'static str,
}

/// The images of the narrow halo are made from the radiance above white (bright pass), and have a quarter of the image's width and height. Those of the wide
/// halo are made from the narrow one, and have a sixteenth. A pass has the name of its target, by which JSON reports state its time: therefore these names do
/// not change.
const NARROW_HALO: HaloImages = HaloImages { downsampled: "beyond white", blurred_x: "beyond white across", blurred: "near halo" };
const WIDE_HALO: HaloImages = HaloImages { downsampled: "near halo shrunk", blurred_x: "near halo across", blurred: "far halo" };

/// A linear HDR target of one sample per pixel.
fn linear_target(resource: &'static str, [width, height]: [u32; 2]) -> TargetDescriptor {
    TargetDescriptor { resource, width, height, format: ColourFormat::Hdr, samples: 1, clear: [0.0; 4], has_depth: false }
}

/// A step with one draw that fills a new target. The resources `reads` are bound from [`FIRST_READ_BINDING`] on.
pub(super) fn screen_step(name: &'static str, reads: &[&'static str], target: TargetDescriptor, draw: PlanDraw) -> PassStep {
    let reads = (FIRST_READ_BINDING..).zip(reads).map(|(binding, resource)| Read { resource, binding }).collect();
    let draw = PlanDraw { scissor: [0, 0, target.width, target.height], ..draw };
    PassStep { name, reads, writes: Write::New(target), draws: vec![draw] }
}

/// A Gaussian blur along one axis.
fn blur(scene: &Scene, provider: &impl ResourceProvider, axis: Vec2, sigma_px: f32) -> Result<PlanDraw, PlanError> {
    let draw = simple_draw("blur", scene, provider, |w| {
        w.vec2("axis", axis)?;
        w.f32("sigma_px", sigma_px)
    })?;
    Ok(PlanDraw { label: format!("blur along {}", if axis == Vec2::X { "x" } else { "y" }), ..draw })
}

/// The steps of bloom: radiance above white, downsampled and blurred at two scales. `hdr`: name of the resource that is read.
pub(super) fn bloom_steps(scene: &Scene, provider: &impl ResourceProvider, hdr: &'static str) -> Result<Vec<PassStep>, PlanError> {
    let downsampled = |size: [u32; 2]| size.map(|s| s.div_ceil(DOWNSAMPLING));
    let quarter = downsampled([scene.camera.width, scene.camera.height]);
    let sixteenth = downsampled(quarter);
    // Downsamples the exposed radiance above `threshold`, up to `max_excess` above it; both are in units of white.
    let downsample = |exposure: f32, threshold: f32, max_excess: f32| {
        simple_draw("shrink", scene, provider, |w| {
            w.f32("exposure", exposure)?;
            w.f32("threshold", threshold)?;
            w.f32("max_excess", max_excess)
        })
    };
    let white = 1.0;
    let height = scene.camera.height as f32;
    // In pixels of the downsampled images.
    let [narrow_sigma_px, wide_sigma_px] = [
        BLOOM_NARROW.relative_sigma * height / DOWNSAMPLING as f32,
        BLOOM_WIDE.relative_sigma * height / (DOWNSAMPLING * DOWNSAMPLING) as f32,
    ];
    let blur = |axis: Vec2, sigma_px: f32| blur(scene, provider, axis, sigma_px);
    Ok(vec![
        screen_step(
            "bloom, bright pass",
            &[hdr],
            linear_target(NARROW_HALO.downsampled, quarter),
            downsample(scene.exposure.factor_f32(), white, BLOOM_MAX_EXCESS)?,
        ),
        screen_step(
            "bloom, narrow, blurred along x",
            &[NARROW_HALO.downsampled],
            linear_target(NARROW_HALO.blurred_x, quarter),
            blur(Vec2::X, narrow_sigma_px)?,
        ),
        screen_step(
            "bloom, narrow",
            &[NARROW_HALO.blurred_x],
            linear_target(NARROW_HALO.blurred, quarter),
            blur(Vec2::Y, narrow_sigma_px)?,
        ),
        screen_step(
            "bloom, wide, downsampled",
            &[NARROW_HALO.blurred],
            linear_target(WIDE_HALO.downsampled, sixteenth),
            // All of the image: the bright pass has applied exposure, threshold and limit.
            downsample(1.0, 0.0, f32::MAX)?,
        ),
        screen_step(
            "bloom, wide, blurred along x",
            &[WIDE_HALO.downsampled],
            linear_target(WIDE_HALO.blurred_x, sixteenth),
            blur(Vec2::X, wide_sigma_px)?,
        ),
        screen_step("bloom, wide", &[WIDE_HALO.blurred_x], linear_target(WIDE_HALO.blurred, sixteenth), blur(Vec2::Y, wide_sigma_px)?),
    ])
}

/// The tone map from the resource `hdr` to the resource `display`, with bloom if it is on in the scene.
pub(super) fn tone_map_step(
    scene: &Scene,
    provider: &impl ResourceProvider,
    hdr: &'static str,
    display: &'static str,
) -> Result<PassStep, PlanError> {
    let (width, height) = (scene.camera.width, scene.camera.height);
    // Other pixel views show quantities instead of light.
    let is_filmic = scene.pixel_view == PixelView::Final && scene.tone_map == ToneMap::Filmic;
    let (module, reads) =
        if scene.has_bloom { ("tone_map_bloom", &[hdr, NARROW_HALO.blurred, WIDE_HALO.blurred][..]) } else { ("tone_map", &[hdr][..]) };
    let draw = simple_draw(module, scene, provider, |w| {
        w.f32("exposure", scene.exposure.factor_f32())?;
        // Without the filmic shoulder, the tone curve is linear throughout.
        w.f32("linear_limit", if is_filmic { FILMIC_LINEAR_LIMIT } else { f32::MAX })?;
        if scene.has_bloom {
            w.f32("narrow_fraction", BLOOM_NARROW.fraction)?;
            w.f32("wide_fraction", BLOOM_WIDE.fraction)?;
        }
        Ok(())
    })?;
    let black = [0.0, 0.0, 0.0, 1.0];
    let target =
        TargetDescriptor { resource: display, width, height, format: ColourFormat::Rgba8Unorm, samples: 1, clear: black, has_depth: false };
    Ok(screen_step("tone map", reads, target, draw))
}

/// Resource names of the outline's masks: the body's shape, the shape blurred along x, and along both axes. They do not change, as those of [`HaloImages`].
const OUTLINE_RESOURCES: [&str; 3] = ["shape", "shape blurred across", "shape blurred"];

/// sRGB bytes scaled to 0..=1, without decoding.
pub(super) fn colour(bytes: [u8; 3]) -> Vec3 {
    Vec3::from_array(bytes.map(f32::from)) / 255.0
}

/// The selected body's outline: a mask of its shape is blurred, and the part of the blurred mask outside the shape is drawn over the resource `display`.
/// `shape`: the draw of the body into the mask.
pub(super) fn outline_steps(
    scene: &Scene,
    shape: PlanDraw,
    provider: &impl ResourceProvider,
    display: &'static str,
) -> Result<Vec<PassStep>, PlanError> {
    let (width, height) = (scene.camera.width, scene.camera.height);
    let sigma_px = (OUTLINE_RELATIVE_SIGMA * height as f32).max(OUTLINE_MIN_SIGMA_PX);
    // The reach of the blur, and a pixel to spare.
    let margin_px = (BLUR_RADIUS_SIGMAS * sigma_px).ceil() as u32 + 1;
    let [x0, y0, x1, y1] = shape.scissor;
    let blurred_rect = [
        x0.saturating_sub(margin_px),
        y0.saturating_sub(margin_px),
        x1.saturating_add(margin_px).min(width),
        y1.saturating_add(margin_px).min(height),
    ];
    let mask = |resource| TargetDescriptor {
        resource,
        width,
        height,
        format: ColourFormat::Rgba8Unorm,
        samples: 1,
        clear: [0.0; 4],
        has_depth: false,
    };
    let blurred = |name, from, to, axis| -> Result<PassStep, PlanError> {
        let mut step = screen_step(name, &[from], mask(to), blur(scene, provider, axis, sigma_px)?);
        step.draws.iter_mut().for_each(|d| d.scissor = blurred_rect);
        Ok(step)
    };
    let [shape_mask, blurred_x_mask, blurred_mask] = OUTLINE_RESOURCES;
    // A body's module writes depth, so the mask needs a depth target.
    let shape_target = TargetDescriptor { has_depth: true, ..mask(shape_mask) };
    let outline = simple_draw("outline", scene, provider, |w| w.vec3("colour", colour(SELECTED_COLOUR)))?;
    let outline = PlanDraw { blend: Blend::PremultipliedOver, scissor: blurred_rect, ..outline };
    let reads = (FIRST_READ_BINDING..).zip([shape_mask, blurred_mask]).map(|(binding, resource)| Read { resource, binding }).collect();
    Ok(vec![
        PassStep { name: "outline, shape", reads: vec![], writes: Write::New(shape_target), draws: vec![shape] },
        blurred("outline, blurred along x", shape_mask, blurred_x_mask, Vec2::X)?,
        blurred("outline, blurred", blurred_x_mask, blurred_mask, Vec2::Y)?,
        PassStep { name: "outline", reads, writes: Write::Over(display), draws: vec![outline] },
    ])
}
