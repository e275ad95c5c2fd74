//! Converts the interface's triangles to primitives for the GPU renderer.
//!
//! In: egui's tessellated meshes, the CPU painter's textures, and the rendered view if it is on the GPU. Out: [`UiPrimitive`]s in drawing
//! order. Always: a mesh that the CPU painter would skip is skipped here, too. This module draws nothing.

use crate::render::plan::{AddressMode, GpuImage, SamplerState, TextureSource, UiPrimitive};
use crate::view::window::cpu_painter::{Painter, PixelBounds};
use crate::view::window::painter_texture::PainterTexture;
use egui::epaint::{Mesh, Primitive};
use egui::{ClippedPrimitive, TextureId};

/// The texture id by which the interface refers to the rendered view while this view is on the GPU.
pub const SCENE_IMAGE: TextureId = TextureId::User(0);

/// The primitives for a window of `[width, height]` pixels. `scene_image`: the rendered view, if it is on the GPU.
pub fn ui_primitives(
    painter: &Painter,
    [width, height]: [u32; 2],
    pixels_per_point: f32,
    primitives: &[ClippedPrimitive],
    scene_image: Option<&GpuImage>,
) -> Vec<UiPrimitive> {
    let to_primitive = |p: &ClippedPrimitive| {
        let Primitive::Mesh(mesh) = &p.primitive else { return None };
        let (texture, sampler) = match (mesh.texture_id, scene_image) {
            (SCENE_IMAGE, Some(image)) => {
                let clamp = AddressMode::ClampToEdge;
                (TextureSource::OnGpu(image.clone()), SamplerState { address_u: clamp, address_v: clamp, is_trilinear: true })
            }
            (id, _) => {
                let texture = painter.texture(id)?;
                (TextureSource::Persistent(texture.shared()), sampler_of(texture))
            }
        };
        let bounds = PixelBounds::of(p.clip_rect, pixels_per_point, width as usize, height as usize);
        let scissor = [bounds.left, bounds.top, bounds.right, bounds.bottom].map(|v| v as u32);
        let is_visible = scissor[0] < scissor[2] && scissor[1] < scissor[3] && !mesh.indices.is_empty();
        is_visible.then(|| mesh_primitive(mesh, pixels_per_point, texture, sampler, scissor))
    };
    primitives.iter().filter_map(to_primitive).collect()
}

fn sampler_of(texture: &PainterTexture) -> SamplerState {
    // The texture has no mip levels, so trilinear filtering of it is bilinear.
    let address = if texture.repeats { AddressMode::Repeat } else { AddressMode::ClampToEdge };
    SamplerState { address_u: address, address_v: address, is_trilinear: texture.is_linear }
}

/// The primitive for a mesh. `scissor`: left, top, right and bottom pixel of the clip rectangle, the last two exclusive.
fn mesh_primitive(mesh: &Mesh, pixels_per_point: f32, texture: TextureSource, sampler: SamplerState, scissor: [u32; 4]) -> UiPrimitive {
    let vertices = &mesh.vertices;
    UiPrimitive {
        positions_px: vertices.iter().flat_map(|v| [v.pos.x * pixels_per_point, v.pos.y * pixels_per_point]).collect(),
        uvs: vertices.iter().flat_map(|v| [v.uv.x, v.uv.y]).collect(),
        colours: vertices.iter().flat_map(|v| v.color.to_array().map(|c| f32::from(c) / 255.0)).collect(),
        indices: mesh.indices.clone(),
        texture,
        sampler,
        scissor,
    }
}
