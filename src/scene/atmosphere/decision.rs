//! Whether a body's atmosphere is drawn, with how many samples, and whether it is composited over the ground.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions, with the model of the air, the blend mode and the draw of the sky (the
//! atmosphere beyond the limb).

use crate::catalog::{Atmosphere, Body};
use crate::message::{Reason, reason};
use crate::scene::atmosphere::air;
use crate::scene::atmosphere::rim::{self, Rim};
use crate::scene::atmosphere::species::{colours_exclude_air, is_visible_over_disc};
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{self, ClipRect, Placement};
use crate::scene::draw::features::{AtmosphereModel, MapSet, PixelView, RingShadow};
use crate::scene::draw::{BodyPart, Draw, MapFiles};
use crate::scene::features::choice::BodyCapabilities;
use crate::scene::features::globe;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::light::lights::IncidentLight;
use crate::scene::request::effects::Effect;
use crate::scene::stated_errors;
use glam::DVec3;

/// Whether the atmosphere can change the image, with the reason.
fn is_significant(inputs: &DecisionInputs<'_, '_>, body: &Body, air: &Atmosphere, camera_is_inside: bool) -> (bool, Reason) {
    air::is_significant(body, air, camera_is_inside, inputs.diameter_px, inputs.threshold())
}

/// Whether some pixel may show the atmosphere: the camera is in it, or the atmosphere or the globe is in the frame. `shell`: the ellipsoid at
/// the top of the air.
fn may_be_seen(inputs: &DecisionInputs<'_, '_>, shell: &Placement) -> bool {
    let camera = inputs.frame.camera;
    shell.camera_is_inside() || Outline::of(camera, shell).rect(camera).is_some() || inputs.rect.is_some()
}

/// Whether some pixel may show the body's atmosphere.
pub(crate) fn may_be_in_frame(inputs: &DecisionInputs<'_, '_>) -> bool {
    air::shell(inputs.body(), &inputs.placed.placement).is_some_and(|shell| may_be_seen(inputs, &shell))
}

/// The model of the air that is chosen if all tables of multiple scattering are available, and why. At draft quality the table
/// is used only near the body or for thick air.
fn chosen_model(inputs: &DecisionInputs<'_, '_>, air: &Atmosphere, shell: &Placement) -> (AtmosphereModel, Reason) {
    let request = inputs.frame.context.request;
    air::model(request.effects.air_model(), request.quality, air::why_table_in_drafts(inputs.placed, air, shell))
}

/// The light of another body is drawn in the air if it is more than this times the smallest visible change, relative to the sky's mean light by the Sun. The
/// factor is for the darkest part of the sky: in twilight, opposite the Sun, it is up to some twenty times darker than the mean; by day the sky is about
/// equally bright everywhere.
const MIN_SECOND_LIGHT_RATIO: f64 = 0.05;

/// Whether planet-shine is visible in the air of the body on which it falls, with the reason: always from outside the air, from inside it not by day. `light`:
/// the strongest of the secondary lights; `sunlight`: see [`Decisions::sunlight`].
fn second_light(inputs: &DecisionInputs<'_, '_>, sunlight: DVec3, light: &IncidentLight) -> (bool, Reason) {
    let source = inputs.frame.reflectors.iter().find(|r| r.body.id == light.from).map_or("?", |r| r.body.name.as_str());
    let Some(air_around_camera) = inputs.frame.air.filter(|a| a.body.id == inputs.body().id) else {
        return (true, reason!("air-shine-outside", body = source));
    };
    // The radiances for which the sky would be exposed if lit by the Sun or by the other body alone.
    let sunlit = air_around_camera.exposure_radiance(inputs.placed.body_to_sun_km, sunlight.y);
    let part = air_around_camera.exposure_radiance(light.direction, light.irradiance.y) / sunlit.max(f64::MIN_POSITIVE);
    let min_part = MIN_SECOND_LIGHT_RATIO * inputs.threshold().min_change();
    let reason = reason!("air-shine", body = source, part = format_args!("{part:.1e}"), threshold = format_args!("{min_part:.1e}"));
    (part > min_part, reason)
}

/// Whether the air is drawn, if it may be seen.
fn is_drawn(inputs: &DecisionInputs<'_, '_>, air: &Atmosphere, shell: &Placement) -> bool {
    let is_significant = || is_significant(inputs, inputs.body(), air, shell.camera_is_inside()).0;
    inputs.effects().override_of(Effect::Atmosphere).unwrap_or_else(is_significant)
}

/// Whether the disc's colour includes the light of the air, unless the catalog gives the ground's own colour. The pixel view of the optical depth shows all of
/// the air.
fn map_includes_air(inputs: &DecisionInputs<'_, '_>) -> bool {
    !colours_exclude_air(inputs.body()) && inputs.pixel_view() != PixelView::OpticalDepth
}

/// Whether the body's draws may read a table of multiple scattering.
pub(crate) fn needs_table(inputs: &DecisionInputs<'_, '_>) -> bool {
    let body = inputs.body();
    let Some((air, shell)) = body.atmosphere.as_ref().zip(air::shell(body, &inputs.placed.placement)) else { return false };
    // As in `scene::features::decide`: there is a decision on the air of a body that is drawn as a disc or whose globe and rings are outside the frame, not on
    // that of a body in the frame that is only a point.
    let is_decided_on = inputs.disc_fraction > 0.0 || inputs.rect.is_none() && inputs.ring_view.is_none();
    is_drawn(inputs, air, &shell)
        && is_decided_on
        && may_be_seen(inputs, &shell)
        && chosen_model(inputs, air, &shell).0 == AtmosphereModel::Table
}

/// Decides on the atmosphere: sets the model for the globe's draw, and creates the draw of the sky beyond the limb.
pub(crate) fn decide<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let (body, context) = (inputs.body(), inputs.frame.context);
    let Some((air, shell)) = body.atmosphere.as_ref().zip(air::shell(body, &inputs.placed.placement)) else { return decisions };
    let camera_is_inside = shell.camera_is_inside();
    let (on, reason) = is_significant(inputs, body, air, camera_is_inside);
    let sunlight = decisions.sunlight(inputs.placed);
    let log = &mut decisions.log;
    if !log.record_effect(Effect::Atmosphere, on, reason) {
        return decisions;
    }
    let (mut model, mut reason) = chosen_model(inputs, air, &shell);
    let has_table = context.resources.scattering_tables.contains_key(&body.id);
    if model == AtmosphereModel::Table && !has_table && may_be_seen(inputs, &shell) {
        model = AtmosphereModel::Pixel16;
        // Along rays that only rise or only fall, by day, and along all others.
        let (few, many) = air::sample_counts(model);
        reason = reason!("air-samples-no-table", few = few, many = many);
    }
    log.record("air-samples", true, reason);
    let chosen = &mut decisions.chosen;
    chosen.air_model = model;
    // No shader has both ring-shine and secondary lights.
    if !chosen.ring_shine
        && inputs.pixel_view().shows_radiance()
        && let Some(light) = decisions.secondary_lights.first()
    {
        let (on, reason) = second_light(inputs, sunlight, light);
        if log.record("planet-shine-in-air", on, reason) {
            chosen.second_light_in_air = true;
            // Relative to the Sun's.
            decisions.second_light_irradiance = camera::narrow(light.irradiance / sunlight);
        }
    }
    log.set_stated_error(Effect::Atmosphere.name(), stated_errors::of_atmosphere(model));
    if chosen.eclipse.occluders > 0 {
        // Only the table has the multiple scattering that brings light into the shadow.
        let spreads_into_shadow = model == AtmosphereModel::Table;
        let reason = if spreads_into_shadow { reason!("air-spread") } else { reason!("air-no-spread") };
        log.record("light-into-shadow", spreads_into_shadow, reason);
    }
    // `FeatureSelection::globe_features` draws the ellipsoid in place of a sphere under any atmosphere.
    if !chosen.ellipsoid && BodyCapabilities::of(body).is_flattened {
        log.record(Effect::Ellipsoid.name(), true, reason!("required-by-air"));
    }
    let height_km = air::camera_height_km(body, &inputs.placed.placement);
    // Unless the catalog gives the ground's own colour, the disc's colour was measured from space and already includes the atmosphere. A camera above the
    // atmosphere sees that colour. The deeper the camera is in the atmosphere, the more the colour counts as the ground's own, seen through the air. The pixel
    // view of the optical depth shows all of the air.
    let map_includes_air = map_includes_air(inputs);
    let map_weight = if map_includes_air { air::opacity_below(air, height_km) } else { 0.0 };
    let colour_includes_air = map_includes_air && !camera_is_inside;
    // Whether the rim, where it is opaque, has the disc's colour.
    let continues_disc = colour_includes_air && rim::continues_disc(body, air);
    let rim = Rim::of(body, air, inputs.diameter_px, inputs.placed.phase_angle_rad, continues_disc);
    let rim_is_left_out = !camera_is_inside && rim.is_negligible();
    if !camera_is_inside && rim.is_low() {
        let reason = reason!(
            "air-rim-light",
            height = format_args!("{:.2}", rim.height_px),
            part = format_args!("{:.1e}", rim.light_ratio),
            threshold = rim::MIN_LIGHT_RATIO
        );
        log.record("air-rim", !rim_is_left_out, reason);
    }
    chosen.thin_rim = !camera_is_inside && rim.is_averaged();
    // Before `air_model` is cleared, which is for the globe's draw only.
    let features = chosen.sky_features(body, inputs.pixel_view());
    if continues_disc {
        log.record("air-over-ground", false, reason!("air-in-colours"));
        chosen.air_model = AtmosphereModel::None;
    } else if colour_includes_air {
        log.record("air-over-ground", true, reason!("air-where-brighter"));
    } else if map_weight > 0.0 {
        log.record("air-over-ground", true, reason!("air-partly-in-colours", percent = format_args!("{:.2}", 100.0 * map_weight)));
    }
    decisions.map_weight = camera::narrow_scalar(map_weight);
    if rim::continues_disc(body, air) {
        // For a camera above air that continues the disc's colour, no air is drawn over the disc, and the night sky does not light the disc's night side.
        decisions.night_fraction_on_ground = camera::narrow_scalar(air::night_sky_above(air, height_km));
    }
    // The modes of `air_blend_mode`: everywhere, where brighter than the map, outside the disc.
    decisions.blend_mode = match (map_weight > 0.0, is_visible_over_disc(air)) {
        (false, _) => 0.0,
        (true, true) => 1.0,
        (true, false) => 2.0,
    };
    let camera = inputs.frame.camera;
    let rect = if camera_is_inside { Some(ClipRect::VIEWPORT) } else { Outline::of(camera, &shell).rect(camera) };
    let (Some(rect), Some(mut features), false) = (rect, features, rim_is_left_out) else { return decisions };
    // A small disc shares its light with a sprite, that of its point or glare. There is no sprite if the globe is not in the frame (only the atmosphere beyond
    // the limb is), or if the camera is in the air.
    let fraction = if inputs.disc_fraction > 0.0 && !camera_is_inside { inputs.drawn_fraction() } else { 1.0 };
    // The first of the `lights` is the Sun.
    let secondary_lights = decisions.secondary_lights.get(..usize::from(features.lights) - 1).unwrap_or_default();
    let mut uniforms = globe::uniforms_of_fraction(inputs, &inputs.placed.placement, rect, MapSet::default(), secondary_lights, fraction);
    // Where rays that only rise or only fall leave the air.
    air::set_ends(&mut uniforms, air::FarEnd::Top);
    air::set_night_sky(&mut uniforms.air, air, air::night_sky_above(air, height_km));
    // On a rim less than a pixel high, one mean of the shadow of the body's own rings serves each ray. (`chosen.thin_rim` is about averaging the rim's light
    // over each pixel.)
    if !camera_is_inside && rim.height_px < rim::MIN_SAMPLED_SHADOW_PX && features.ring_shadow.is_of_own_rings() {
        // The mean is for a point Sun, whichever model the module has. In an eclipse there is no module with this model (`FeatureSelection::globe_features`).
        if features.eclipse.occluders == 0 {
            features.ring_shadow = RingShadow::PointSun;
        }
        uniforms.air.rim_is_thin = 1.0;
        let reason = reason!("air-ring-shadow", height = format_args!("{:.2}", rim.height_px), threshold = rim::MIN_SAMPLED_SHADOW_PX);
        decisions.log.record("ring-shadow-on-air", true, reason);
    }
    let name = format!("{} air", body.name);
    decisions.sky = Some(Draw { body: body.id, part: BodyPart::Sky, name, features, uniforms, map_files: MapFiles::default() });
    decisions
}
