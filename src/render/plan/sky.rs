//! The draws of the diffuse sky (Milky Way, zodiacal light) and of the user's images of the sky, which are drawn over it.
//!
//! In: the scene, the layouts of the simple shaders, the panorama and the images. Out: one full-screen draw for the diffuse sky and one for each image.

use super::error::PlanError;
use super::passes::{AddressMode, Blend, PlanDraw, SamplerBinding, SamplerState, TextureBinding, TextureSource};
use super::provider::ResourceProvider;
use super::simple_draws::simple_draw;
use crate::image::{Level, MapDecoding, PoleFilter, SharedTexture, TexelFormat, Texture};
use crate::scene::Scene;
use crate::scene::sky::images::SkyImageDraw;
use glam::Vec3;
use std::sync::{Arc, LazyLock};

/// The module of the diffuse sky: shaders/entry/sky_background.wesl.
const BACKGROUND_MODULE: &str = "sky_background";
/// Bindings of the texture and the sampler in this module and in sky_image.wesl.
const MAP_BINDING: u32 = 1;
const SAMPLER_BINDING: u32 = 2;
/// Binding of the texture of bright values in [`BACKGROUND_MODULE`].
const BRIGHT_MAP_BINDING: u32 = 3;

/// How a panorama of the sky is decoded.
pub(crate) const SKY_DECODING: MapDecoding = MapDecoding { poles: PoleFilter::Values, ..MapDecoding::plain(TexelFormat::Rgba8Srgb) };

/// Bound in place of a panorama if the scene has none.
static BLACK_MAP: LazyLock<SharedTexture> =
    LazyLock::new(|| Arc::new(Texture { format: TexelFormat::Rgba8Srgb, levels: vec![Level::new(1, 1, vec![0, 0, 0, 255])] }));

/// The diffuse sky. `opacity`: the alpha that it writes; 0 in a face of a dome or sphere, because the face is later blended over the stars.
pub(super) fn background(scene: &Scene, provider: &impl ResourceProvider, opacity: f32) -> Result<Vec<PlanDraw>, PlanError> {
    let Some(sky) = &scene.background else { return Ok(Vec::new()) };
    let map = |file: &Option<String>| file.as_ref().map_or_else(|| Ok(BLACK_MAP.clone()), |file| provider.map(file, SKY_DECODING));
    let texture = |binding, map| TextureBinding { binding, source: TextureSource::Image(map) };
    let textures = vec![texture(MAP_BINDING, map(&sky.map_file)?), texture(BRIGHT_MAP_BINDING, map(&sky.bright_file)?)];
    let draw = simple_draw(BACKGROUND_MODULE, scene, provider, |w| {
        w.vec3("middle", sky.middle)?;
        w.vec3("right", sky.right)?;
        w.vec3("up", sky.up)?;
        w.vec3("map_radiance", Vec3::splat(sky.map_radiance))?;
        w.vec3("bright_radiance", Vec3::splat(sky.bright_radiance))?;
        w.f32("map_level", sky.map_level)?;
        w.vec3("zodiacal_radiance", Vec3::splat(sky.zodiacal_radiance))?;
        w.vec3("to_sun", sky.to_sun)?;
        w.vec3("ecliptic_pole", sky.ecliptic_pole)?;
        w.vec4_array("zodiacal_law", &sky.zodiacal_law)?;
        w.f32("log_offset", sky.log_offset)?;
        w.f32("inner_cosine", sky.inner_cosine)?;
        w.f32("outer_cosine", sky.outer_cosine)?;
        w.f32("fades_into_corona", sky.fades_into_corona)?;
        w.f32("opacity", opacity)
    })?;
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };
    Ok(vec![PlanDraw { textures, samplers: vec![SamplerBinding { binding: SAMPLER_BINDING, state }], ..draw }])
}

/// The user's images of the sky. Their radiance is divided by the exposure, so white in an image is display white at every exposure.
pub(super) fn images(scene: &Scene, provider: &impl ResourceProvider) -> Result<Vec<PlanDraw>, PlanError> {
    let draw = |image: &SkyImageDraw| {
        let map = provider.overlay(&image.image)?;
        let draw = simple_draw("sky_image", scene, provider, |w| {
            w.vec3("middle", image.middle)?;
            w.vec3("right", image.right)?;
            w.vec3("up", image.up)?;
            w.vec2("span_px", image.span_px)?;
            w.f32("map_level", image.map_level)?;
            w.f32("radiance", 1.0 / scene.exposure.factor_f32())?;
            w.f32("opacity", image.opacity)
        })?;
        let textures = vec![TextureBinding { binding: MAP_BINDING, source: TextureSource::Image(map) }];
        let state = SamplerState { address_u: AddressMode::ClampToEdge, address_v: AddressMode::ClampToEdge, is_trilinear: true };
        let samplers = vec![SamplerBinding { binding: SAMPLER_BINDING, state }];
        Ok(PlanDraw { textures, samplers, blend: Blend::PremultipliedOver, ..draw })
    };
    scene.sky_images.iter().map(draw).collect()
}
