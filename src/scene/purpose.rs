//! What a picture is for, and what that leaves out.
//!
//! In: the purpose that is asked for, and the exposure. Out: a [`Bound`], which every decision about a feature asks. Always: for linear light no feature
//! is left out that changes a pixel by more than the floor of what is there; where nothing else is, any light counts. For a display none is left out that
//! changes a byte by a level: light of half a level on black counts, where the sRGB curve is steepest. Not here: bounds of size (a disc under a pixel is a point,
//! a rim thinner than half a pixel is none), which no light moves, and the number of lights and occluders that a draw takes.

use crate::scene::thresholds::{VISIBLE_CHANGE, VISIBLE_LIGHT};

/// What the pixels are for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Purpose {
    /// Seen on a display at the picture's exposure: [`VISIBLE_LIGHT`] of white counts, and a change of a pixel by [`VISIBLE_CHANGE`] of itself.
    #[default]
    Display,
    /// Read as linear light at any exposure: a relative change beyond the floor counts, of what is in the pixel without it.
    Linear {
        /// Part of the picture's light below which a feature is left out.
        floor: f64,
    },
}

impl Purpose {
    /// Linear light for files and for questions about pixels: to a thousandth, an f32 film scanner's or a photometer's best.
    pub const LINEAR: Self = Self::Linear { floor: 1e-3 };

    /// By what a picture is written to: EXR keeps linear light.
    pub fn of_file(is_linear: bool) -> Self {
        if is_linear { Self::LINEAR } else { Self::Display }
    }
}

/// Below which a feature is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    purpose: Purpose,
    white: f64,
}

impl Bound {
    /// `white`: the radiance that the display shows as white.
    pub fn of(purpose: Purpose, white: f64) -> Self {
        Self { purpose, white }
    }

    /// Whether light of this radiance counts where it falls on black.
    pub fn counts(self, radiance: f64) -> bool {
        match self.purpose {
            Purpose::Display => radiance > VISIBLE_LIGHT * self.white,
            Purpose::Linear { .. } => radiance > 0.0,
        }
    }

    /// Whether a change of a pixel by this part of itself counts.
    pub fn counts_part(self, part: f64) -> bool {
        part > self.least_part()
    }

    /// The part of itself by which a pixel must change.
    pub fn least_part(self) -> f64 {
        match self.purpose {
            Purpose::Display => VISIBLE_CHANGE,
            Purpose::Linear { floor } => floor,
        }
    }

    /// Whether features count that only a pixel's size leaves out: what they add is not bounded by light.
    pub fn is_linear(self) -> bool {
        matches!(self.purpose, Purpose::Linear { .. })
    }

    /// A radiance over that of white; of a picture for linear light, which has no white, over that at 1 au.
    pub fn of_white(self, radiance: f64) -> f64 {
        radiance / self.white
    }

    /// What shows all light over a part of white, as a radiance; 0 for linear light, which shows all.
    pub fn least_shown(self, part_of_white: f64) -> f64 {
        if self.is_linear() { 0.0 } else { part_of_white * self.white }
    }

    /// A radiance against the bound, in words.
    pub fn description(self, radiance: f64) -> String {
        match self.purpose {
            Purpose::Display => format!("{:.2e} of white against {VISIBLE_LIGHT:.2e}", self.of_white(radiance)),
            Purpose::Linear { .. } => format!("{radiance:.2e} of linear light, where any counts"),
        }
    }

    /// A part of a pixel's light against the bound, in words.
    pub fn said_part(self, part: f64) -> String {
        format!("{part:.2e} of the light against {:.2e}", self.least_part())
    }
}

impl std::fmt::Display for Purpose {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Display => {
                write!(
                    f,
                    "a display at this exposure: what adds less than {VISIBLE_LIGHT:.2e} of white to a pixel, half a level of 255 on black, is left out"
                )
            }
            Self::Linear { floor } => {
                write!(f, "linear light: what changes no pixel by more than {floor:.0e} of what is there is left out")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A display lets go what it cannot show at its exposure, brighter pictures more of it; linear light keeps any light, and parts down to its floor.
    #[test]
    fn a_bound_is_what_the_picture_is_for() {
        let faint = 1e-5;
        let display = |white| Bound::of(Purpose::Display, white);
        assert!(!display(1.0).counts(faint) && display(1e-3).counts(faint));
        assert!(display(1.0).counts_part(0.01) && !display(1.0).counts_part(1e-3));
        for white in [1e-6, 1.0, 1e6] {
            let linear = Bound::of(Purpose::Linear { floor: 1e-4 }, white);
            assert!(linear.counts(faint) && !linear.counts(0.0) && linear.counts_part(1e-3) && !linear.counts_part(1e-5));
            assert_eq!(linear.least_shown(0.01), 0.0);
            assert!(linear.description(faint).contains("linear") && !display(white).description(faint).contains("linear"));
        }
    }
}
