//! Whether the sunlit crescent of a body is so thin that one evaluation for each pixel would lose light.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions, and the part of each pixel over which a draw averages its light. In a thin
//! crescent's draw, a pixel in which sunlight ends shows the mean of its lit part (shaders/lib/intersection.wesl). Under air, ground and air are averaged
//! together over each pixel near the limb (shaders/lib/air/at_limb.wesl). Always: no image changes suddenly where averages begin, and ground and sky agree on
//! the part of a pixel that the ground covers. Near its horns every crescent is thinner than a pixel, however wide it is in its middle; therefore the averages
//! fade out (`averaged_part`).

use crate::message::reason;
use crate::scene::draw::features::RingShadow;
use crate::scene::features::choice::BodyCapabilities;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::numeric::smooth_rise;

/// Widths in pixels between which averages fade out. Evaluated at one point of each pixel, a crescent of width w > 1 loses 0.22 / w^1.5 of its light: 1 % at
/// the upper width, 2.7 % at the lower one, 8 % at 2 pixels, and most of it below half a pixel.
const FADE_WIDTHS_PX: (f64, f64) = (4.0, 8.0);
/// Widths in radii between which averages fade out: at phase angles of 101.5 to 90 degrees. More than half of a disc is no crescent.
const HALF_LIT_WIDTHS_RADII: (f64, f64) = (0.8, 1.0);

/// Name of the decision.
const THIN_CRESCENT: &str = "thin-crescent";

/// Width of the crescent of a sphere where it is widest, in radii.
fn width_radii(phase_angle_rad: f64) -> f64 {
    // 1 + cos a without a difference of nearly equal numbers.
    2.0 * (0.5 * phase_angle_rad).cos().powi(2)
}

/// Part of each pixel over which the light of a body's crescent is averaged: 1 for all of it, 0 for one point of the pixel. Continuous in both arguments. It
/// stays 1 up to a phase angle of 180 degrees, where all the light comes from air at the limb: evaluated at one point of each pixel, a ring of pixels would
/// show the air along the ground, which is brightest, and the Earth in 3 to 5 pixels would have up to 7 times its light.
pub(crate) fn averaged_part(diameter_px: f64, phase_angle_rad: f64) -> f64 {
    let width_radii = width_radii(phase_angle_rad);
    (1.0 - smooth_rise(HALF_LIT_WIDTHS_RADII, width_radii)) * (1.0 - smooth_rise(FADE_WIDTHS_PX, 0.5 * diameter_px * width_radii))
}

/// Decides whether the pixels of a crescent are averaged. Eclipses, meshes and relief finer than the maps exclude it, which limits the number of shader keys.
/// So do the shadow of another body's rings and the limb profile of a Moon that touches the Sun's disc.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let (diameter_px, phase_angle_rad) = (inputs.diameter_px, inputs.placed.phase_angle_rad);
    let chosen = &mut decisions.chosen;
    let is_possible = !BodyCapabilities::of(inputs.body()).is_emissive
        && chosen.eclipse.occluders == 0
        && chosen.ring_shadow != RingShadow::OfPlanet
        && !chosen.detail
        && inputs.mesh.is_none()
        && inputs.placed.limb_profile.is_none();
    if is_possible && averaged_part(diameter_px, phase_angle_rad) > 0.0 {
        let width_px = 0.5 * diameter_px * width_radii(phase_angle_rad);
        let (from, to) = FADE_WIDTHS_PX;
        let reason = reason!("crescent-width", width = format_args!("{width_px:.2}"), from = from, to = to);
        chosen.thin_crescent = decisions.log.record(THIN_CRESCENT, true, reason);
    }
    // The draw of the sky, which may average its rim in any case, computes the ground's coverage as the ground's draw does.
    if !decisions.chosen.thin_crescent
        && let Some(sky) = &mut decisions.sky
    {
        sky.uniforms.averaged_part = 0.0;
    }
    decisions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_crescents_of_few_pixels_are_averaged() {
        // On a sphere of radius 1 the terminator is -cos a from the centre of the disc, so the crescent is 1 + cos a wide.
        assert!((width_radii(120_f64.to_radians()) - 0.5).abs() < 1e-12 && (width_radii(90_f64.to_radians()) - 1.0).abs() < 1e-12);
        let part = |diameter_px: f64, phase_deg: f64| averaged_part(diameter_px, phase_deg.to_radians());
        assert!(part(15.9, 120.0) >= 1.0 && part(16.1, 120.0) < 1.0 && part(31.9, 120.0) > 0.0 && part(32.1, 120.0) <= 0.0);
        assert!(part(4.0, 89.0) <= 0.0 && part(4.0, 91.0) > 0.0 && part(4.0, 102.0) >= 1.0, "more than half of a disc is no crescent");
        // A disc of 768 pixels in an image of 1024.
        assert!(part(768.0, 168.0) <= 0.0 && part(768.0, 169.0) > 0.0 && part(768.0, 175.0) >= 1.0);
        // The air's ring around a night side, seen from any distance.
        assert!([3.0, 768.0, 1e5].iter().all(|px| part(*px, 179.5) >= 1.0 && part(*px, 180.0) >= 1.0));
    }

    /// A zoom by 1 % and a motion by a fortieth of a degree around a half-lit body change the averages by 3 % or less. A limit without a fade would change them
    /// from 1 to 0.
    #[test]
    fn averages_fade_in_and_out() {
        let steps = |part: &dyn Fn(f64) -> f64| {
            let parts: Vec<f64> = (0..=2000).map(|k| part(f64::from(k))).collect();
            assert!(parts.contains(&0.0) && parts.iter().any(|p| *p > 0.99), "the steps must pass a fade");
            parts.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max)
        };
        let zoom = steps(&|k| averaged_part(4.0 * 1.01_f64.powf(k), 150_f64.to_radians()));
        let around = steps(&|k| averaged_part(6.0, (80.0 + 0.025 * k).to_radians()));
        assert!(zoom < 0.03 && around < 0.03, "{zoom} {around}");
    }
}
