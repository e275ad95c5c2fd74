//! Texts at lines and stars: names of constellations, stars and instruments (at the outlines of their fields of view), and coordinates of grid lines.
//!
//! In: texts with their positions, and the labels of the image. Out: the texts that fit, with the left end of each. Always: no two overlap (estimated
//! from the mean width of a glyph), none overlaps a label, and each is inside the image; names have priority over coordinates. Not here: the drawing of
//! glyphs.

use crate::scene::annotation::labels::{LabelLayer, LabelMetrics, label_rect};
use crate::scene::annotation::text::Rect;
use crate::scene::camera::narrow_scalar;
use crate::units::linear_to_srgb;
use glam::{DVec2, DVec3};

/// A text that is placed in the image if it fits.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct UnplacedText {
    pub text: String,
    /// The text's centre, pixels from the image's top left corner. For a coordinate this is a point of its grid line, from which [`place_texts`] moves the text
    /// if it would leave the image.
    pub centre_px: DVec2,
    /// Colour of the line or star, linear RGB, 0 to 1.
    pub colour: DVec3,
    /// Whether this is the coordinate of a grid line; if so, it is moved into the image.
    pub is_grid_coordinate: bool,
}

/// A text that fits, with its position in the image.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedText {
    pub text: String,
    /// Left end of its centre line, pixels from the image's top left corner.
    pub left_end_px: DVec2,
    /// sRGB, 0 to 1: `UnplacedText::colour` mixed with white.
    pub colour: [f32; 3],
}

/// The texts of an image and their glyph size.
#[derive(Clone, Debug, PartialEq)]
pub struct TextLayer {
    /// Font size, pixels.
    pub glyph_px: f64,
    pub texts: Vec<PlacedText>,
}

/// Smallest distance between a coordinate and the image's edge, in glyph sizes.
const EDGE_DISTANCE: f64 = 0.4;
/// Fraction of white mixed into a text's colour, so that the text is lighter than its line.
const WHITE_FRACTION: f64 = 0.35;
/// Maximum number of texts in an image.
const MAX_TEXTS: usize = 400;

/// Places the texts that fit into the image and overlap neither each other nor `labels`, those of bodies and of the margin (`None`: there are none). Names have
/// priority over coordinates; within each kind, earlier candidates have priority over later ones.
pub(crate) fn place_texts(mut candidates: Vec<UnplacedText>, labels: Option<&LabelLayer>, glyph_px: f64, image_px: DVec2) -> TextLayer {
    let metrics = LabelMetrics::of_size(glyph_px);
    let body_rects = labels.into_iter().flat_map(|layer| {
        let label_metrics = LabelMetrics::of_size(layer.glyph_px);
        layer.labels.iter().filter_map(move |l| Some(label_rect(l.centre_px, l.radius_px, &l.name, &label_metrics, l.name_side?)))
    });
    let mut occupied: Vec<Rect> = body_rects.collect();
    // The texts and bars of the margin: caption, scale bar, surface features.
    occupied.extend(labels.into_iter().flat_map(|layer| layer.occupied(&LabelMetrics::of_size(layer.glyph_px)).collect::<Vec<_>>()));
    candidates.sort_by_key(|t| t.is_grid_coordinate);
    let mut texts = Vec::new();
    for candidate in candidates {
        let size = DVec2::new(metrics.width_px(&candidate.text), metrics.line_height_px);
        let edge_distance_px = EDGE_DISTANCE * glyph_px;
        let mut corner = candidate.centre_px - 0.5 * size;
        // A text wider than the image is left out below.
        if candidate.is_grid_coordinate {
            corner = corner.clamp(DVec2::splat(edge_distance_px), (image_px - size - edge_distance_px).max(DVec2::splat(edge_distance_px)));
        }
        let rect = Rect { min: corner, max: corner + size };
        if rect.is_in_image(image_px) && texts.len() < MAX_TEXTS && !occupied.iter().any(|o| o.overlaps(&rect)) {
            occupied.push(rect);
            let colour = candidate.colour.to_array().map(|c| narrow_scalar(linear_to_srgb(WHITE_FRACTION + (1.0 - WHITE_FRACTION) * c)));
            let left_end_px = DVec2::new(corner.x, corner.y + 0.5 * size.y);
            texts.push(PlacedText { text: candidate.text, left_end_px, colour });
        }
    }
    TextLayer { glyph_px, texts }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_keep_apart_and_in_the_image() {
        let image = DVec2::new(400.0, 300.0);
        let name = |text: &str, x: f64, y: f64| UnplacedText {
            text: text.into(),
            centre_px: DVec2::new(x, y),
            colour: DVec3::ONE,
            is_grid_coordinate: false,
        };
        let coordinate = |text: &str, x: f64, y: f64| UnplacedText { is_grid_coordinate: true, ..name(text, x, y) };
        let candidates = vec![
            coordinate("+20°", -3.0, 150.0),
            coordinate("6h", 200.0, 303.0),
            name("Orion", 200.0, 290.0),
            name("Orion", 202.0, 288.0),
            name("Taurus", 399.0, 100.0),
        ];
        let glyph_px = 13.0;
        let no_labels = None;
        let layer = place_texts(candidates, no_labels, glyph_px, image);
        let placed: Vec<&str> = layer.texts.iter().map(|t| t.text.as_str()).collect();
        // There is no room for the coordinate below Orion or for the second Orion, and Taurus would be cut off.
        assert_eq!(placed, ["Orion", "+20°"]);
        assert!(layer.texts.iter().all(|t| t.left_end_px.x >= 0.0 && t.left_end_px.y > 0.0));
    }
}
