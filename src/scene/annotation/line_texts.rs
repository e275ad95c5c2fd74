//! Texts beside lines: names of constellations, and coordinates of grids. Which of them have room.
//!
//! In: texts with their places, and the room that the names of bodies take. Out: those that fit, each with the corner of its room. Always: no two overlap, as far as a letter's mean
//! width tells, none lies over a body's name, and each is in the picture; a constellation's name comes before a coordinate. Not here: letters.

use crate::scene::annotation::labels::{LabelLayer, LabelMetrics, label_rect};
use crate::scene::camera::narrow_scalar;
use crate::units::linear_to_srgb;
use glam::{DVec2, DVec3};

/// A text that wants room.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyText {
    pub text: String,
    /// Its middle, or of a coordinate the end of its line; pixels from the picture's top left corner.
    pub at_px: DVec2,
    /// Linear RGB.
    pub colour: DVec3,
    /// The coordinate of a grid's line: it is moved into the picture.
    pub is_tick: bool,
}

/// A text with room.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedText {
    pub text: String,
    /// Left end of its middle line, pixels from the picture's top left corner.
    pub left_px: DVec2,
    /// sRGB, 0 to 1: lighter than its line.
    pub colour: [f32; 3],
}

/// Texts of a picture, in letters of a size.
#[derive(Clone, Debug, PartialEq)]
pub struct TextLayer {
    pub size_px: f64,
    pub texts: Vec<PlacedText>,
}

/// Between a coordinate and the picture's edge, in letter sizes.
const INSET: f64 = 0.4;
/// Part of white in a text's colour.
const LIGHTER: f64 = 0.35;
/// Lines of one picture may have so many texts at most.
const MOST: usize = 400;

/// Those that have room beside the names of bodies.
pub fn placed(mut wanted: Vec<SkyText>, labels: Option<&LabelLayer>, size_px: f64, picture_px: DVec2) -> TextLayer {
    let metrics = LabelMetrics::of_size(size_px);
    let of_bodies = labels.into_iter().flat_map(|layer| {
        let lettering = LabelMetrics::of_size(layer.size_px);
        layer.marks.iter().filter_map(move |m| Some(label_rect(m.centre_px, m.radius_px, &m.name, &lettering, m.named?)))
    });
    let mut taken: Vec<(DVec2, DVec2)> = of_bodies.collect();
    taken.extend(labels.into_iter().flat_map(|layer| layer.taken(&metrics).map(|rect| (rect.least, rect.most)).collect::<Vec<_>>()));
    wanted.sort_by_key(|t| t.is_tick);
    let mut texts = Vec::new();
    for text in wanted {
        let size = DVec2::new(text.text.chars().count() as f64 * metrics.glyph_width_px, metrics.line_height_px);
        let inset = INSET * size_px;
        let mut corner = text.at_px - 0.5 * size;
        if text.is_tick {
            corner = corner.clamp(DVec2::splat(inset), (picture_px - size - inset).max(DVec2::splat(inset)));
        }
        let rect = (corner, corner + size);
        let apart = |other: &(DVec2, DVec2)| rect.1.cmplt(other.0).any() || rect.0.cmpgt(other.1).any();
        let inside = rect.0.cmpge(DVec2::ZERO).all() && rect.1.cmple(picture_px).all();
        if inside && texts.len() < MOST && taken.iter().all(apart) {
            taken.push(rect);
            let colour = text.colour.to_array().map(|c| narrow_scalar(linear_to_srgb(LIGHTER + (1.0 - LIGHTER) * c)));
            let left_px = DVec2::new(corner.x, corner.y + 0.5 * size.y);
            texts.push(PlacedText { text: text.text, left_px, colour });
        }
    }
    TextLayer { size_px, texts }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_keep_apart_and_in_the_picture() {
        let picture = DVec2::new(400.0, 300.0);
        let text =
            |text: &str, x: f64, y: f64, is_tick: bool| SkyText { text: text.into(), at_px: DVec2::new(x, y), colour: DVec3::ONE, is_tick };
        let wanted = vec![
            text("+20°", -3.0, 150.0, true),
            text("6h", 200.0, 303.0, true),
            text("Orion", 200.0, 290.0, false),
            text("Orion", 202.0, 288.0, false),
            text("Taurus", 399.0, 100.0, false),
        ];
        let layer = placed(wanted, None, 13.0, picture);
        let names: Vec<&str> = layer.texts.iter().map(|t| t.text.as_str()).collect();
        // The coordinate below Orion has no room, the second Orion none, and Taurus would be cut.
        assert_eq!(names, ["Orion", "+20°"]);
        assert!(layer.texts.iter().all(|t| t.left_px.x >= 0.0 && t.left_px.y > 0.0));
    }
}
