//! The purpose of an image, and the smallest change of a pixel for which an effect is drawn in an image of this purpose.
//!
//! In: the requested purpose and the exposure. Out: a `Threshold`, with which decisions compare the change that an effect makes. Always: for linear light, an
//! effect is kept if its relative change of a pixel's radiance exceeds the purpose's `floor`; on black, any light is kept. For a display, an
//! effect is kept if it may change a displayed 8-bit level: if it adds more than the fraction [`VISIBLE_LIGHT`] of white to a black pixel, or changes a pixel
//! by more than the fraction [`VISIBLE_CHANGE`]. Not here: limits of size, which do not depend on the exposure (a disc under two pixels is only a point; a
//! faint rim of an atmosphere, thinner than half a pixel, is left out); and the maximum number of lights and occluders of a draw.

use crate::message::{Reason, reason};
use crate::scene::thresholds::{VISIBLE_CHANGE, VISIBLE_LIGHT};

/// The use of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Purpose {
    /// Seen on a display at the image's exposure. An effect is kept if it adds more than the fraction [`VISIBLE_LIGHT`] of white to a black pixel, or changes a
    /// pixel by more than the fraction [`VISIBLE_CHANGE`].
    #[default]
    Display,
    /// Read as linear light at any exposure. An effect is kept if it changes a pixel by more than `floor` times the radiance without the effect.
    Linear {
        /// Relative change of a pixel's radiance up to which an effect is left out.
        floor: f64,
    },
}

impl Purpose {
    /// Linear light for files and for queries of pixels: an effect is left out only below a thousandth of the pixel's light.
    pub const LINEAR: Self = Self::Linear { floor: 1e-3 };

    /// The relative change of a pixel's radiance up to which an effect is left out.
    pub(crate) fn min_change(self) -> f64 {
        match self {
            Self::Display => VISIBLE_CHANGE,
            Self::Linear { floor } => floor,
        }
    }

    /// The purpose of a written file. `is_linear`: whether the file stores linear light, as EXR does.
    pub fn of_file(is_linear: bool) -> Self {
        if is_linear { Self::LINEAR } else { Self::Display }
    }
}

/// The limits up to which an effect is left out: of the radiance that it adds to black, and of its relative change of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Threshold {
    purpose: Purpose,
    /// The radiance that the display shows as white.
    white: f64,
}

impl Threshold {
    /// The threshold for a purpose. `white`: the radiance that the display shows as white.
    pub(crate) fn of(purpose: Purpose, white: f64) -> Self {
        Self { purpose, white }
    }

    /// Whether this radiance, added to black, is large enough to be kept.
    pub(crate) fn is_exceeded_by_radiance(self, radiance: f64) -> bool {
        match self.purpose {
            Purpose::Display => radiance > VISIBLE_LIGHT * self.white,
            Purpose::Linear { .. } => radiance > 0.0,
        }
    }

    /// Whether a relative change of a pixel of this magnitude is large enough to be kept.
    pub(crate) fn is_exceeded_by_change(self, change: f64) -> bool {
        change > self.min_change()
    }

    /// See [`Purpose::min_change`].
    pub(crate) fn min_change(self) -> f64 {
        self.purpose.min_change()
    }

    /// The smallest radiance, added to black, that is kept; 0 for linear light.
    pub(crate) fn min_radiance(self) -> f64 {
        self.cutoff_radiance(VISIBLE_LIGHT)
    }

    /// Whether the purpose is linear light. Some rules for displays do not apply to it: a body's overlays (`catalog::Overlay`) smaller than half a pixel are
    /// kept, and the air is not interpolated from its coarse image.
    pub(crate) fn is_linear(self) -> bool {
        matches!(self.purpose, Purpose::Linear { .. })
    }

    /// A radiance as a fraction of the radiance that the display shows as white.
    pub(crate) fn relative_to_white(self, radiance: f64) -> f64 {
        radiance / self.white
    }

    /// The radiance below which light is not drawn. For a display: this fraction of white. For linear light: 0, because all light is kept.
    pub(crate) fn cutoff_radiance(self, white_fraction: f64) -> f64 {
        if self.is_linear() { 0.0 } else { white_fraction * self.white }
    }

    /// A radiance and its threshold (linear light has none), in words.
    pub(crate) fn radiance_description(self, radiance: f64) -> Reason {
        match self.purpose {
            Purpose::Display => {
                let light = self.relative_to_white(radiance);
                reason!("of-white", light = format_args!("{light:.2e}"), threshold = format_args!("{VISIBLE_LIGHT:.2e}"))
            }
            Purpose::Linear { .. } => reason!("of-linear-light", light = format_args!("{radiance:.2e}")),
        }
    }

    /// A relative change and its threshold, in words.
    pub(crate) fn change_description(self, change: f64) -> Reason {
        reason!("of-the-light", part = format_args!("{change:.2e}"), threshold = format_args!("{:.2e}", self.min_change()))
    }
}

impl std::fmt::Display for Purpose {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Display => reason!("purpose-display", threshold = format_args!("{VISIBLE_LIGHT:.2e}")).fmt(f),
            Self::Linear { floor } => reason!("purpose-linear", floor = format_args!("{floor:.0e}")).fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a display, light that its exposure cannot show is left out. For linear light, any light on black is kept, and relative changes down to the floor.
    #[test]
    fn the_threshold_follows_the_purpose() {
        // [`VISIBLE_LIGHT`] is 1.5e-4 of white: more than this radiance if white is 1, less if white is 1e-3.
        let faint = 1e-5;
        let display = |white| Threshold::of(Purpose::Display, white);
        assert!(!display(1.0).is_exceeded_by_radiance(faint) && display(1e-3).is_exceeded_by_radiance(faint));
        // [`VISIBLE_CHANGE`] is 2e-3.
        assert!(display(1.0).is_exceeded_by_change(0.01) && !display(1.0).is_exceeded_by_change(1e-3));
        for white in [1e-6, 1.0, 1e6] {
            let linear = Threshold::of(Purpose::Linear { floor: 1e-4 }, white);
            assert!(
                linear.is_exceeded_by_radiance(faint)
                    && !linear.is_exceeded_by_radiance(0.0)
                    && linear.is_exceeded_by_change(1e-3)
                    && !linear.is_exceeded_by_change(1e-5)
            );
            assert_eq!(linear.cutoff_radiance(0.01), 0.0);
            // The English text of the reason `of-linear-light`.
            assert!(
                linear.radiance_description(faint).to_string().contains("no threshold")
                    && !display(white).radiance_description(faint).to_string().contains("no threshold")
            );
        }
    }
}
