//! The glare of a small disc that is brighter than white: the part of its light that eye or lens spread around it, as they do around a point.
//!
//! In: the inputs of the decisions about one body. Out: [`DiscGlare`]: the sprite of the glare, and the fraction of the disc's light that it takes from the
//! draws of the disc. `scene::point` has the profile, and the range of diameters in which the glare fades to nothing. A small body is drawn partly as a point,
//! partly as a disc; `disc_fraction` is the disc's share of the light. Always: point, disc and glare together have the body's light. Not here: the Sun, whose
//! disc has a glare of its own (`light::glare`). Left out: the glare of larger discs, for which there is bloom, and that of rings and air apart from their
//! disc. The glare is centred on the lit part as if this were equally bright everywhere.

use crate::catalog::NaifId;
use crate::scene::camera::{narrow, narrow_scalar};
use crate::scene::draw::{PixelView, Point};
use crate::scene::eclipse::sun_occluders;
use crate::scene::features::inputs::DecisionInputs;
use crate::scene::light::{lights, planet_shine};
use crate::scene::point;
use crate::scene::request::effects::Effect;
use glam::DVec3;
use std::f64::consts::PI;

/// The glare of a disc.
pub(crate) struct DiscGlare {
    /// Fraction of the disc's light that is in the glare.
    pub fraction: f64,
    /// The glare as a sprite, before the light that nearer bodies hide is removed.
    pub sprite: Point,
}

/// Distance of the middle of the lit part from the middle of a disc, in radii: 0 at full phase, 0.42 if half lit, 0.85 for the thinnest crescent.
fn middle_of_lit_part(phase_angle_rad: f64) -> f64 {
    // The lit part extends from the limb, at sqrt(1 - y^2), to the terminator, at -cos a sqrt(1 - y^2). Its first moment is (2 / 3) sin^2 a, its area is
    // (pi / 2) (1 + cos a).
    4.0 / (3.0 * PI) * (1.0 - phase_angle_rad.cos())
}

/// The flux of a body by planet-shine; 0, without an evaluation, if the body would have no glare even in full sunlight, because planet-shine is never brighter
/// than sunlight.
fn flux_by_planet_shine(inputs: &DecisionInputs<'_, '_>) -> DVec3 {
    let (frame, placed) = (inputs.frame, inputs.placed);
    let sunlight = lights::sunlight(placed.body_to_sun_km).irradiance.max_element();
    if frame.threshold.relative_to_white(placed.body.geometric_albedo.max(0.01) * sunlight) < 1.0 {
        return DVec3::ZERO;
    }
    // The log is dropped: the decisions about planet-shine are recorded for the disc itself.
    point::flux_of_irradiance(frame.camera, placed, planet_shine::irradiance_at_viewer(inputs, &mut inputs.log()))
}

/// The glare of a body's disc. `None` if the disc is too large, is not brighter than white, or is so far outside the frame that its glare does not reach it;
/// for ground below the camera; for the Sun; if the user has switched points off; and in pixel views other than the final image.
pub(crate) fn of(inputs: &DecisionInputs<'_, '_>) -> Option<DiscGlare> {
    let (frame, placed, diameter_px) = (inputs.frame, inputs.placed, inputs.diameter_px);
    let is_possible = inputs.disc_fraction > 0.0
        && diameter_px < point::NO_GLARE_FROM_PX
        && placed.body.id != NaifId::SUN
        && !placed.is_ground_below_camera()
        && inputs.pixel_view() == PixelView::Final
        && inputs.effects().override_of(Effect::Points) != Some(false);
    let clip_if_glare_reaches_frame = |centre_km: DVec3| {
        let clip = frame.camera.clip(centre_km)?;
        point::reaches_frame(frame.camera, clip, point::MAX_RADIUS_PX).then_some(clip)
    };
    if !is_possible || clip_if_glare_reaches_frame(placed.placement.centre_km).is_none() {
        return None;
    }
    // The sprite is drawn after the air around the camera, which does not dim it: its flux includes the transmittance.
    let transmittance = inputs.transmittance();
    let brightness = |flux: DVec3| {
        let white = 1.0;
        point::disc_brightness(frame.threshold.relative_to_white(flux.max_element()), white, diameter_px)
    };
    let by_sunlight = point::flux(frame.camera, placed) * transmittance;
    let by_planet_shine = flux_by_planet_shine(inputs) * transmittance;
    // Eclipses are evaluated only for a disc that would have glare without them.
    if brightness(by_sunlight + by_planet_shine) <= 1.0 {
        return None;
    }
    let by_sunlight = by_sunlight * sun_occluders::visible_sunlight(frame.context, placed, diameter_px);
    let flux = by_sunlight + by_planet_shine;
    let (fraction, radius_px) = point::disc_glare(brightness(flux), diameter_px);
    if fraction <= 0.0 {
        return None;
    }
    // Sunlight comes from the lit part, planet-shine from all of the disc.
    let line_of_sight = placed.placement.centre_km / placed.distance_km;
    let across_to_sun = placed.body_to_sun_km.reject_from_normalized(line_of_sight).normalize_or_zero();
    let offset_radii = middle_of_lit_part(placed.phase_angle_rad) * by_sunlight.max_element() / flux.max_element();
    let radius_km = placed.body.radii_km.element_sum() / 3.0;
    let clip = clip_if_glare_reaches_frame(placed.placement.centre_km + across_to_sun * (offset_radii * radius_km))?;
    // `flux` is replaced below. The sprite hides nothing (`Point::covered_px`), because the body's own disc does.
    let (no_flux, covered_px) = (DVec3::ZERO, 0.0);
    let sprite = Point {
        radius_px: narrow_scalar(radius_px),
        disc_radius_px: narrow_scalar(0.5 * diameter_px),
        flux: narrow(flux * (inputs.disc_fraction * fraction)),
        ..point::sprite(placed.body.id, clip, no_flux, covered_px)
    };
    Some(DiscGlare { fraction, sprite })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The middle of the lit part, against sums over a grid of the disc.
    #[test]
    fn the_middle_of_the_lit_part_is_its_centroid() {
        for phase_deg in [0.0_f64, 45.0, 90.0, 135.0, 160.0] {
            let phase = phase_deg.to_radians();
            let (mut area, mut moment) = (0.0, 0.0);
            for k in 0..1000 * 1000 {
                let at = |n: i32| (f64::from(n) + 0.5) / 500.0 - 1.0;
                let (x, y) = (at(k % 1000), at(k / 1000));
                let half_chord = (1.0 - y * y).sqrt();
                if x.abs() < half_chord && x > -phase.cos() * half_chord {
                    (area, moment) = (area + 1.0, moment + x);
                }
            }
            assert!((middle_of_lit_part(phase) - moment / area).abs() < 5e-3, "{phase_deg}: {}", moment / area);
        }
        // Negative control: a shift by the sine of the phase angle would be wrong for crescents; at 160 degrees it would be 0.34 instead of 0.82.
        assert!((middle_of_lit_part(160_f64.to_radians()) - 160_f64.to_radians().sin()).abs() > 0.3);
    }
}
