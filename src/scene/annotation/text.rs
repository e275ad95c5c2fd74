//! Texts, bars and rings over a finished picture, in pixels from its left top corner: what labels are made of besides the names of bodies;
//! and the room that text takes.

use glam::DVec2;

/// Room that a name takes: a letter's mean width and a line's height, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelMetrics {
    pub glyph_width_px: f64,
    pub line_height_px: f64,
}

impl LabelMetrics {
    pub fn of_size(size_px: f64) -> Self {
        Self { glyph_width_px: LETTER_WIDTH * size_px, line_height_px: LINE_HEIGHT * size_px }
    }

    /// Size of the letters.
    pub fn size_px(&self) -> f64 {
        self.line_height_px / LINE_HEIGHT
    }

    /// Width of a text, by the mean width of a letter.
    pub fn width_px(&self, text: &str) -> f64 {
        text.chars().count() as f64 * self.glyph_width_px
    }

    /// Pixels from a body's centre to its name, right and up.
    pub fn gap_px(&self, radius_px: f64) -> f64 {
        let size_px = self.size_px();
        (radius_px * std::f64::consts::FRAC_1_SQRT_2).max(MARKER_RADIUS * size_px) + 0.3 * size_px
    }
}

/// sRGB of a name.
pub const NAME_COLOUR: [u8; 3] = [200, 208, 220];
/// Radius of a marker in parts of the size of the letters; bodies smaller than it have one.
pub const MARKER_RADIUS: f64 = 5.0 / 13.0;
/// A letter's mean width in parts of its size (Ubuntu Light, over English names).
pub const LETTER_WIDTH: f64 = 6.6 / 13.0;
/// A line's height in parts of the size of its letters.
pub const LINE_HEIGHT: f64 = 15.0 / 13.0;

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct TextMark {
    pub text: String,
    /// Left end of its middle line.
    pub left_px: DVec2,
    /// sRGB.
    pub colour: [u8; 3],
    /// 0 to 1.
    pub opacity: f64,
}

/// A filled rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    pub rect: Rect,
    pub colour: [u8; 3],
    pub opacity: f64,
}

/// A rectangle by its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    pub least: DVec2,
    pub most: DVec2,
}

impl Rect {
    pub fn overlaps(&self, other: &Self) -> bool {
        self.least.cmplt(other.most).all() && other.least.cmplt(self.most).all()
    }

    /// The same with room on every side.
    pub fn padded(&self, room: DVec2) -> Self {
        Self { least: self.least - room, most: self.most + room }
    }
}
