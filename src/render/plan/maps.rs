//! Binds images and samplers to the texture variables of a body's module, by the variable's name.
//!
//! In: a draw, its module's layout, and the provider of images. Out: texture and sampler bindings. Always: only textures that the module declares are
//! requested.

use super::error::PlanError;
use super::passes::{AddressMode, SamplerBinding, SamplerState, TextureBinding, TextureSource};
use super::provider::ResourceProvider;
use crate::image::{Level, MapDecoding, OpacityTexels, PoleFilter, SharedTexture, TexelFormat, Texture};
use crate::scene::constants::{LIMB_COLUMNS, LIMB_ROWS};
use crate::scene::draw::{Draw, LimbTable, MapFiles, MapRole, RingShadowGrid, RingTable, Shape};
use crate::scene::ring_shine::{self as shine_table, RingShine};
use crate::shader::Layout;
use std::sync::Arc;

/// The texture variables of shaders/lib/maps.wesl and overlay.wesl, and the role of the map that is bound to each.
const MAPS: [(&str, MapRole); 7] = [
    ("albedo_map", MapRole::Albedo),
    ("normal_map", MapRole::Normal),
    ("specular_map", MapRole::Specular),
    ("night_map", MapRole::Night),
    ("cloud_map", MapRole::Clouds),
    ("overlay_map", MapRole::Overlay(0)),
    ("overlay_map_2", MapRole::Overlay(1)),
];
/// The sampler of all textures in [`MAPS`] but overlays.
const MAP_SAMPLER: &str = "map_sampler";
/// The samplers of the overlays, by overlay index.
const OVERLAY_SAMPLERS: [&str; 2] = ["overlay_sampler", "overlay_sampler_2"];
/// The texture variable of the ring profile.
pub const RING_PROFILE: &str = "ring_profile";
/// The texture variable of the ring-shine table: light that the ring sends onto its globe.
pub const RING_SHINE: &str = "ring_shine_table";
/// The texture variable of the grid with the shadow of another body's rings.
pub const RING_SHADOW_GRID: &str = "ring_shadow_grid";
/// The texture variable of the Moon's limb profile: heights of the terrain along the limb.
pub const LIMB_TABLE: &str = "limb_table";

/// The role of a texture variable's image; `None` if the image is not a map of a body.
pub fn role_of(texture: &str) -> Option<MapRole> {
    MAPS.iter().find(|(name, _)| *name == texture).map(|(_, role)| *role)
}

/// Albedo maps, night maps and overlays contain sRGB colours; normal, specular and cloud maps contain linear values.
pub fn map_format(role: MapRole) -> TexelFormat {
    match role {
        MapRole::Normal | MapRole::Specular | MapRole::Clouds => TexelFormat::Rgba8Unorm,
        MapRole::Albedo | MapRole::Night | MapRole::Overlay(_) => TexelFormat::Rgba8Srgb,
    }
}

/// How a draw's map is decoded. The maps of a mesh need not be equirectangular, so their rows near the poles are not filtered.
pub fn map_decoding(role: MapRole, files: &MapFiles, shape: Shape) -> MapDecoding {
    let poles = match (shape, role) {
        (Shape::Mesh, _) => PoleFilter::None,
        (_, MapRole::Normal) => PoleFilter::Normals,
        _ => PoleFilter::Values,
    };
    // The cloud map's values for a clear sky and for a closed cloud deck. They are stored as the bits of f32 because `MapFiles` implements `Eq`.
    let texel_bits = files.cloud_texel_bits.filter(|_| role == MapRole::Clouds);
    let opacity = texel_bits.map(|bits| bits.map(f32::from_bits)).map(|[clear, closed]| OpacityTexels::new(clear, closed));
    MapDecoding { format: map_format(role), poles, opacity }
}

/// The texture bindings of the draw. The module may read fewer maps than the draw has: a depth view reads none. A texture for which the
/// draw has no image gets no binding.
pub(super) fn textures(draw: &Draw, layout: &Layout, provider: &impl ResourceProvider) -> Result<Vec<TextureBinding>, PlanError> {
    let ring = &draw.uniforms.ring;
    let image_of = |name: &str| -> Result<Option<SharedTexture>, PlanError> {
        Ok(match (name, role_of(name)) {
            (RING_PROFILE, _) => ring.table.as_ref().map(|table| provider.ring_profile(table)),
            (RING_SHINE, _) => ring.shine.as_deref().map(ring_shine),
            (RING_SHADOW_GRID, _) => ring.shadow_grid.as_deref().map(ring_shadow_grid),
            (LIMB_TABLE, _) => draw.uniforms.limb.table.as_deref().map(limb_table),
            (_, Some(role)) => match draw.map_files.by_role().find(|(r, _)| *r == role) {
                Some((MapRole::Overlay(_), file)) => Some(provider.overlay(file)?),
                Some((_, file)) => Some(provider.map(file, map_decoding(role, &draw.map_files, draw.features.shape))?),
                None => None,
            },
            _ => None,
        })
    };
    let mut bindings = Vec::new();
    for texture in &layout.textures {
        let binding_of = |image| TextureBinding { binding: texture.binding, source: TextureSource::Image(image) };
        bindings.extend(image_of(&texture.name)?.map(binding_of));
    }
    Ok(bindings)
}

/// The sampler bindings of the draw. Maps, and overlays that span all longitudes, repeat across the antimeridian; other overlays are clamped.
pub(super) fn samplers(draw: &Draw, layout: &Layout) -> Vec<SamplerBinding> {
    let repeating = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };
    let state_of = |name: &str| {
        let overlay = OVERLAY_SAMPLERS.iter().position(|s| *s == name).and_then(|n| draw.uniforms.overlays.get(n));
        match overlay {
            Some(overlay) if !overlay.wraps_around => Some(SamplerState { address_u: AddressMode::ClampToEdge, ..repeating }),
            Some(_) => Some(repeating),
            None => (name == MAP_SAMPLER).then_some(repeating),
        }
    };
    layout.samplers.iter().filter_map(|s| Some(SamplerBinding { binding: s.binding, state: state_of(&s.name)? })).collect()
}

/// The bytes of a table of floats, little-endian as in textures.
fn little_endian_bytes(texels: &[f32]) -> Vec<u8> {
    if cfg!(target_endian = "little") {
        return bytemuck::cast_slice(texels).to_vec();
    }
    texels.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// The ring's profile as a texture of one level, read with `textureLoad`; layout: [`RingTable`].
pub fn ring_profile(table: &RingTable) -> SharedTexture {
    let level = Level::new(table.width, table.height, little_endian_bytes(&table.texels));
    Arc::new(Texture { format: TexelFormat::Rgba32Float, levels: vec![level] })
}

/// Ring-shine as a texture of one level, read with `textureLoad`. Columns: hour angles from the Sun. Rows: heights above the ring plane on
/// the Sun's side, then on the other side.
pub fn ring_shine(table: &RingShine) -> SharedTexture {
    let level = Level::new(shine_table::COLUMNS as u32, 2 * shine_table::ROWS as u32, little_endian_bytes(&table.texels));
    Arc::new(Texture { format: TexelFormat::Rgba32Float, levels: vec![level] })
}

/// The shadow of another body's rings as a texture of one level, read with `textureLoad`: one texel per place.
pub fn ring_shadow_grid(grid: &RingShadowGrid) -> SharedTexture {
    let level = Level::new(grid.side, grid.side, little_endian_bytes(&grid.texels));
    Arc::new(Texture { format: TexelFormat::Rgba32Float, levels: vec![level] })
}

/// The Moon's limb profile as a texture of one level, read with `textureLoad`: one texel per position angle, row by row.
pub fn limb_table(table: &LimbTable) -> SharedTexture {
    let level = Level::new(LIMB_COLUMNS as u32, LIMB_ROWS as u32, little_endian_bytes(&table.texels));
    Arc::new(Texture { format: TexelFormat::Rgba32Float, levels: vec![level] })
}
