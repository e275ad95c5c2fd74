//! Texts, bars and rings over a finished picture, in pixels from its left top corner: what labels are made of besides the names of bodies.

use glam::DVec2;

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
