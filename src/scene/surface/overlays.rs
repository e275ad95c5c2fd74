//! Overlays, the images over a body's ground: the decision which of them are visible, and the mapping from the ground to image coordinates.
//!
//! In: the catalog's overlays. Out: a decision with its reason, and the rows of shaders/lib/overlay.wesl. The image is blended over the ground's
//! colour by its alpha; relief, water, city lights and clouds do not change. Left out: the displacement by relief in an image that was taken
//! obliquely.

use crate::catalog::{Body, Overlay, OverlayProjection};
use crate::ephemeris::topocentric::ground_point_km;
use crate::message::{Reason, reason};
use crate::scene::camera;
use crate::scene::draw::uniforms::OverlayUniforms;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::purpose::Threshold;
use crate::scene::request::effects::Effect;
use glam::{DVec3, DVec4};
use std::f64::consts::{FRAC_PI_2, PI};

/// Image coordinate that replaces the limit on a side where the image has no edge: far outside any image.
const NO_EDGE: f64 = 1e6;

/// Whether an overlay can change a pixel, with the reason: it is opaque enough and its shorter side spans more than half a pixel. The size does not matter for
/// an image of linear light (`threshold.is_linear()`). `ground_deg_per_px`: degrees of ground per pixel.
pub(crate) fn is_visible(body: &Body, overlay: &Overlay, ground_deg_per_px: f64, threshold: Threshold) -> (bool, Reason) {
    let extent_deg = match overlay.projection {
        OverlayProjection::Equirectangular { west_deg, east_deg, south_deg, north_deg } => (east_deg - west_deg).min(north_deg - south_deg),
        // The width as if it were measured along the ground; at most the visible half of the globe.
        OverlayProjection::Orthographic { width_km, height_km, .. } => (width_km.min(height_km) / body.radii_km.x).min(PI).to_degrees(),
    };
    let size_px = extent_deg / ground_deg_per_px;
    let reason = reason!("overlay-size", overlay = &overlay.name, size = format_args!("{size_px:.1}"), opacity = overlay.opacity);
    ((size_px > 0.5 || threshold.is_linear()) && threshold.is_exceeded_by_change(overlay.opacity), reason)
}

/// Decides which overlays are drawn: one decision for each, all with the name of the effect.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let (body, name) = (inputs.body(), Effect::Overlays.name());
    if body.overlays.is_empty() {
        decisions.log.record(name, false, reason!("not-available"));
    }
    let resources = inputs.frame.context.resources;
    for overlay in &body.overlays {
        if resources.is_unreadable(&overlay.file) {
            decisions.log.record(name, false, reason!("unreadable", file = &overlay.file));
            continue;
        }
        let (on, reason) = is_visible(body, overlay, inputs.ground_deg_per_px(), inputs.threshold());
        if decisions.log.record_effect(Effect::Overlays, on, reason) {
            decisions.overlays.push(overlay);
        }
    }
    decisions.chosen.overlays = decisions.overlays.len() as u8;
    decisions
}

/// The uniforms of an overlay, in the rows of shaders/lib/overlay.wesl. `factor`: by which the draw multiplies the
/// colours of the ground, linear RGB.
pub(crate) fn uniforms(body: &Body, overlay: &Overlay, factor: DVec3) -> OverlayUniforms {
    let axis_ratios = body.radii_km / body.radii_km.x;
    // `axes`: of the overlay's frame, in body axes. The rows are described in overlay.wesl; lengths there are in equatorial radii.
    let (axes, scale_and_centre, limits, wraps_around) = match overlay.projection {
        OverlayProjection::Equirectangular { west_deg, east_deg, south_deg, north_deg } => {
            let [west, east, south, north] = [west_deg, east_deg, south_deg, north_deg].map(f64::to_radians);
            let (sin, cos) = (0.5 * (west + east)).sin_cos();
            let wraps_around = east_deg - west_deg >= 360.0;
            let edge = |exists: bool, limit: f64, no_limit: f64| if exists { limit } else { no_limit };
            // The image's first and last u, then its first and last v. At a pole there is no ground beyond the image, so it has no edge there.
            let limits = DVec4::new(
                edge(!wraps_around, 0.0, -NO_EDGE),
                edge(!wraps_around, 1.0, NO_EDGE),
                edge(north < FRAC_PI_2, 0.0, -NO_EDGE),
                edge(south > -FRAC_PI_2, 1.0, NO_EDGE),
            );
            // On the equator the central meridian and 90 degrees east of it, then the pole.
            let axes = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z];
            // Image widths and heights per radian, the central latitude, and 0 for equirectangular (1 for orthographic).
            (axes, DVec4::new(1.0 / (east - west), 1.0 / (north - south), 0.5 * (north + south), 0.0), limits, wraps_around)
        }
        OverlayProjection::Orthographic { latitude_deg, longitude_deg, width_km, height_km } => {
            let ground_height_km = 0.0;
            // The point of the ground in the image's middle, and the normal there.
            let (middle_km, up) = ground_point_km(body.radii_km, latitude_deg, longitude_deg, ground_height_km);
            let east = DVec3::Z.cross(up).normalize();
            let north = up.cross(east);
            let radius_km = body.radii_km.x;
            // Image widths and heights per equatorial radius, the northing of the middle, and 1 for orthographic.
            let scale_and_centre = DVec4::new(radius_km / width_km, radius_km / height_km, middle_km.dot(north) / radius_km, 1.0);
            let (limits, wraps_around) = (DVec4::new(0.0, 1.0, 0.0, 1.0), false);
            ([east, north, up], scale_and_centre, limits, wraps_around)
        }
    };
    let colour_and_opacity = (factor * DVec3::from_array(overlay.gain)).extend(overlay.opacity);
    // In w of the three rows with the axes: the factor on z that gives planetographic latitude, then the semi-axes y and z relative to x.
    let [x, y, z] = [axes[0].extend(1.0 / axis_ratios.z), axes[1].extend(axis_ratios.y), axes[2].extend(axis_ratios.z)];
    let rows = [x, y, z, scale_and_centre, limits, colour_and_opacity];
    OverlayUniforms { rows: rows.map(|r| camera::narrow(r.truncate()).extend(camera::narrow_scalar(r.w))), wraps_around }
}
