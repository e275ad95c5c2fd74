//! Texts, bars and rectangles over a finished image, in pixels from its top left corner; and the metrics of text. Plain values. The *size* of glyphs is the
//! font size (em), pixels.

use glam::DVec2;

/// Mean width of a glyph and height of a line, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelMetrics {
    pub glyph_width_px: f64,
    pub line_height_px: f64,
}

impl LabelMetrics {
    /// The metrics of glyphs of this size.
    pub fn of_size(glyph_px: f64) -> Self {
        Self { glyph_width_px: GLYPH_WIDTH * glyph_px, line_height_px: LINE_HEIGHT * glyph_px }
    }

    /// Size of the glyphs, as given to [`Self::of_size`].
    pub(crate) fn glyph_px(&self) -> f64 {
        self.line_height_px / LINE_HEIGHT
    }

    /// Width of a text, estimated from the mean width of a glyph.
    pub fn width_px(&self, text: &str) -> f64 {
        text.chars().count() as f64 * self.glyph_width_px
    }

    /// The rectangle of a text. `left_end_px`: left end of the text's centre line.
    pub(crate) fn rect(&self, text: &str, left_end_px: DVec2) -> Rect {
        let half = DVec2::new(0.0, 0.5 * self.line_height_px);
        Rect { min: left_end_px - half, max: left_end_px + half + DVec2::new(self.width_px(text), 0.0) }
    }

    /// Horizontal and vertical distance from the centre of a body of this radius to the near end of its name. The name is diagonally beside the disc or
    /// marker, at least as far away as the marker's radius.
    pub(crate) fn name_offset_px(&self, radius_px: f64) -> f64 {
        let glyph_px = self.glyph_px();
        (radius_px * std::f64::consts::FRAC_1_SQRT_2).max(MARKER_RADIUS * glyph_px) + NAME_DISTANCE * glyph_px
    }
}

/// sRGB of a name.
pub(crate) const NAME_COLOUR: [u8; 3] = [200, 208, 220];
/// Radius of a marker relative to the size of glyphs: 5 pixels for glyphs of 13 pixels. A body whose disc is smaller has a marker.
pub(crate) const MARKER_RADIUS: f64 = 5.0 / 13.0;
/// Distance of a name from its disc or marker, horizontally and vertically, in glyph sizes.
const NAME_DISTANCE: f64 = 0.3;
/// Mean width of a glyph relative to its size, measured on English names in Ubuntu Light.
pub(crate) const GLYPH_WIDTH: f64 = 6.6 / 13.0;
/// Height of a line relative to the size of glyphs.
pub(crate) const LINE_HEIGHT: f64 = 15.0 / 13.0;

/// A line of text. A dark halo around its letters keeps it readable on bright ground.
#[derive(Clone, Debug, PartialEq)]
pub struct TextLine {
    pub text: String,
    /// Left end of its centre line.
    pub left_end_px: DVec2,
    /// sRGB.
    pub colour: [u8; 3],
    /// 0 to 1.
    pub opacity: f64,
}

/// A filled rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    pub rect: Rect,
    /// sRGB.
    pub colour: [u8; 3],
    /// 0 to 1.
    pub opacity: f64,
}

/// A rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// The top left corner.
    pub min: DVec2,
    /// The bottom right corner.
    pub max: DVec2,
}

impl Rect {
    /// Whether the rectangles have a common area.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmplt(other.max).all() && other.min.cmplt(self.max).all()
    }

    /// Distance of a point from the rectangle, pixels; 0 inside.
    pub(crate) fn distance_px(&self, point: DVec2) -> f64 {
        point.distance(point.clamp(self.min, self.max))
    }

    /// The rectangle enlarged by `margin.x` on the left and right and by `margin.y` above and below.
    pub(crate) fn padded(&self, margin: DVec2) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// Whether the rectangle is completely in an image of this size.
    pub(crate) fn is_in_image(&self, size_px: DVec2) -> bool {
        self.min.cmpge(DVec2::ZERO).all() && self.max.cmple(size_px).all()
    }
}
