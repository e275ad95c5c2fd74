//! Converts the interface's triangles to primitives for a renderer.
//!
//! In: egui's tessellated meshes, the painter's textures, and the rendered view if it is on the GPU. Out: [`UiPrimitive`]s in drawing order.
//! Always: meshes that the CPU painter would skip are skipped here too. This module draws nothing.

use crate::render::plan::{AddressMode, GpuImage, SamplerState, TextureSource, UiPrimitive};
use crate::view::window::cpu_painter::{Painter, PixelBounds};
use egui::epaint::{Mesh, Primitive};
use egui::{ClippedPrimitive, TextureId};

/// The texture id of an image that is on the GPU.
pub const ON_GPU: TextureId = TextureId::User(0);

/// The primitives of a window of `[width, height]` pixels. `scene_image`: the rendered view, if it is on the GPU.
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
            (ON_GPU, Some(image)) => (TextureSource::OnGpu(image.clone()), sampler_state(true, false)),
            (id, _) => {
                let texture = painter.texture(id)?;
                (TextureSource::Persistent(texture.shared()), sampler_state(texture.smooth, texture.repeats))
            }
        };
        let bounds = PixelBounds::of(p.clip_rect, pixels_per_point, width as usize, height as usize);
        let scissor = [bounds.left, bounds.top, bounds.right, bounds.bottom].map(|v| v as u32);
        let is_visible = scissor[0] < scissor[2] && scissor[1] < scissor[3] && !mesh.indices.is_empty();
        is_visible.then(|| of_mesh(mesh, pixels_per_point, texture, sampler, scissor))
    };
    primitives.iter().filter_map(to_primitive).collect()
}

fn sampler_state(linear: bool, repeats: bool) -> SamplerState {
    let address = if repeats { AddressMode::Repeat } else { AddressMode::ClampToEdge };
    SamplerState { address_u: address, address_v: address, linear }
}

fn of_mesh(mesh: &Mesh, scale: f32, texture: TextureSource, sampler: SamplerState, scissor: [u32; 4]) -> UiPrimitive {
    let corners = &mesh.vertices;
    UiPrimitive {
        corners_px: corners.iter().flat_map(|v| [v.pos.x * scale, v.pos.y * scale]).collect(),
        uvs: corners.iter().flat_map(|v| [v.uv.x, v.uv.y]).collect(),
        colours: corners.iter().flat_map(|v| v.color.to_array().map(|c| f32::from(c) / 255.0)).collect(),
        indices: mesh.indices.clone(),
        texture,
        sampler,
        scissor,
    }
}
