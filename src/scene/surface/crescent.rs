//! Whether the sunlit crescent of a body is so thin that one evaluation for each pixel would lose light.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions. In a thin crescent's draw, a pixel that the terminator crosses shows the mean
//! of its lit part (shaders/lib/intersection.wesl), and air in front of the ground is averaged over each pixel near the limb (shaders/lib/air/at_limb.wesl).

use crate::message::reason;
use crate::scene::features::choice::Capabilities;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use std::f64::consts::FRAC_PI_2;

/// Width in pixels below which a crescent is thin. Evaluated at one point of each pixel, a crescent of width w > 1 loses 0.22 / w^1.5 of its light: 2.7 % at
/// this width, 8 % at 2 pixels, and most of it below half a pixel.
const MAX_WIDTH_PX: f64 = 4.0;
/// Width in radii below which the pixels of a crescent are not averaged: at phase angles above 179 degrees, where bodies are silhouettes in front of the Sun
/// or close to it.
const MIN_WIDTH_RADII: f64 = 1.5e-4;

/// Name of the decision.
const THIN_CRESCENT: &str = "thin-crescent";

/// Width of the crescent of a sphere where it is widest, in radii.
fn width_radii(phase_angle_rad: f64) -> f64 {
    // 1 + cos a without a difference of nearly equal numbers.
    2.0 * (0.5 * phase_angle_rad).cos().powi(2)
}

/// Whether a body shows a thin crescent.
fn is_thin(diameter_px: f64, phase_angle_rad: f64) -> bool {
    let width_radii = width_radii(phase_angle_rad);
    phase_angle_rad > FRAC_PI_2 && width_radii > MIN_WIDTH_RADII && 0.5 * diameter_px * width_radii < MAX_WIDTH_PX
}

/// Decides whether the pixels of a crescent are averaged. Eclipses, meshes and relief finer than the maps exclude it, which limits the number of shader keys.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let (diameter_px, phase_angle_rad) = (inputs.diameter_px, inputs.placed.phase_angle_rad);
    let chosen = &mut decisions.chosen;
    let is_possible =
        !Capabilities::of(inputs.body()).is_emissive && chosen.eclipse.occluders == 0 && !chosen.detail && inputs.model.is_none();
    if is_possible && is_thin(diameter_px, phase_angle_rad) {
        let width_px = 0.5 * diameter_px * width_radii(phase_angle_rad);
        let reason = reason!("crescent-width", width = format_args!("{width_px:.2}"), threshold = MAX_WIDTH_PX);
        chosen.thin_crescent = decisions.log.record(THIN_CRESCENT, true, reason);
    }
    decisions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_crescents_of_few_pixels_are_thin() {
        // On a sphere of radius 1 the terminator is -cos a from the centre of the disc, so the crescent is 1 + cos a wide.
        assert!((width_radii(120_f64.to_radians()) - 0.5).abs() < 1e-12 && (width_radii(90_f64.to_radians()) - 1.0).abs() < 1e-12);
        let thin = |diameter_px: f64, phase_deg: f64| is_thin(diameter_px, phase_deg.to_radians());
        assert!(thin(15.9, 120.0) && !thin(16.1, 120.0));
        assert!(!thin(4.0, 89.0) && thin(4.0, 91.0), "more than half of a disc is no crescent");
        // A disc of 768 pixels in an image of 1024.
        assert!(!thin(768.0, 171.0) && thin(768.0, 175.0) && !thin(768.0, 179.5));
    }
}
