//! Red light for the night: everything that the window shows becomes red on black, so that eyes stay adapted to the dark.
//!
//! In: egui's tessellated meshes. Out: the same meshes with red vertex colours. Always: of an image only its red channel is shown; the opacity stays.

use egui::epaint::Primitive;
use egui::{ClippedPrimitive, Color32};

/// Replaces each colour by a red that is as bright as the brightest of its channels, so that all texts stay legible. The colours multiply those of the
/// textures, which are images and white glyphs.
pub fn make_red(primitives: &mut [ClippedPrimitive]) {
    for primitive in primitives {
        if let Primitive::Mesh(mesh) = &mut primitive.primitive {
            mesh.vertices.iter_mut().for_each(|vertex| vertex.color = red(vertex.color));
        }
    }
}

/// The red of a colour with premultiplied opacity.
fn red(colour: Color32) -> Color32 {
    let [r, g, b, opacity] = colour.to_array();
    Color32::from_rgba_premultiplied(r.max(g).max(b), 0, 0, opacity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::epaint::Mesh;
    use egui::{Rect, Vec2, pos2};

    #[test]
    fn every_colour_becomes_red_with_its_opacity() {
        let rect = Rect::from_min_size(pos2(1.0, 2.0), Vec2::splat(3.0));
        let colours = [Color32::WHITE, Color32::from_rgb(10, 60, 200), Color32::from_black_alpha(180), Color32::TRANSPARENT];
        let mut mesh = Mesh::default();
        colours.iter().for_each(|colour| mesh.add_colored_rect(rect, *colour));
        let mut primitives = [ClippedPrimitive { clip_rect: rect, primitive: Primitive::Mesh(mesh) }];
        make_red(&mut primitives);
        let Primitive::Mesh(mesh) = &primitives[0].primitive else { panic!("a mesh") };
        // Each rectangle has four vertices.
        let reds: Vec<[u8; 4]> = mesh.vertices.iter().step_by(4).map(|vertex| vertex.color.to_array()).collect();
        assert_eq!(reds, [[255, 0, 0, 255], [200, 0, 0, 255], [0, 0, 0, 180], [0, 0, 0, 0]]);
    }
}
