//! Whether a body's atmosphere is drawn, with how many samples, and whether it is composited over the ground.
//!
//! In: the case of one body and its decisions so far. Out: the decisions, with the tier of the air, the blend mode and the draw of the sky.

use crate::catalog::{Atmosphere, Body};
use crate::message::{Reason, reason};
use crate::scene::atmosphere::air;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{ClipRect, Placement};
use crate::scene::draw::features::{AtmosphereModel, MapSet, PixelView, RingShadow};
use crate::scene::draw::{Draw, MapFiles, Part};
use crate::scene::features::case::{BodyContext, Decisions};
use crate::scene::features::choice::Capabilities;
use crate::scene::features::globe;
use crate::scene::request::effects::Effect;
use crate::scene::tiers;

/// Whether the atmosphere can change the picture, with the reason.
fn is_significant(case: &BodyContext<'_, '_>, body: &Body, air: &Atmosphere, inside: bool) -> (bool, Reason) {
    air::is_significant(body, air, inside, case.diameter_px, case.threshold())
}

/// Whether some pixel may show the atmosphere: the camera is in it, or it is in the frame.
fn may_be_seen(case: &BodyContext<'_, '_>, shell: &Placement) -> bool {
    let camera = case.frame.camera;
    shell.camera_is_inside() || Outline::of(camera, shell).rect(camera).is_some() || case.rect.is_some()
}

/// Whether the body's draws may read a table of multiple scattering.
pub(crate) fn needs_table(case: &BodyContext<'_, '_>) -> bool {
    let body = case.body();
    let Some((air, shell)) = body.atmosphere.as_ref().zip(air::shell(body, &case.placed.placement)) else { return false };
    let request = case.frame.context.request;
    let drawn =
        case.effects().override_of(Effect::Atmosphere).unwrap_or_else(|| is_significant(case, body, air, shell.camera_is_inside()).0);
    // As in `features::decide`: a body that is only a point gets no atmosphere, unless neither its globe nor its rings reach the frame.
    let reaches_decision = case.disc_fraction > 0.0 || case.rect.is_none() && case.ring_view.is_none();
    drawn
        && reaches_decision
        && may_be_seen(case, &shell)
        && air::tier(request.effects.air_tier(), request.quality).0 == AtmosphereModel::Table
}

/// Decides on the atmosphere: sets the tier for the globe's draw, and creates the draw of the sky beyond the limb.
pub(crate) fn decide<'c>(case: &BodyContext<'c, '_>, mut so_far: Decisions<'c>) -> Decisions<'c> {
    let (body, context) = (case.body(), case.frame.context);
    let Some((air, shell)) = body.atmosphere.as_ref().zip(air::shell(body, &case.placed.placement)) else { return so_far };
    let inside = shell.camera_is_inside();
    let (on, reason) = is_significant(case, body, air, inside);
    let log = &mut so_far.log;
    if !log.effect(Effect::Atmosphere, on, reason) {
        return so_far;
    }
    let (mut tier, mut reason) = air::tier(context.request.effects.air_tier(), context.request.quality);
    let has_table = context.resources.scattering_tables.contains_key(&body.id);
    if tier == AtmosphereModel::Table && !has_table && may_be_seen(case, &shell) {
        (tier, reason) = (AtmosphereModel::Pixel16, reason!("air-samples-no-table", few = 8, many = 16));
    }
    log.note("air-samples", true, reason);
    let chosen = &mut so_far.chosen;
    chosen.air = tier;
    log.tier(Effect::Atmosphere.name(), tiers::of_atmosphere(tier));
    if chosen.eclipse.occluders > 0 {
        let has_spread = tier == AtmosphereModel::Table;
        let reason = if has_spread { reason!("air-spread") } else { reason!("air-no-spread") };
        log.note("light-into-shadow", has_spread, reason);
    }
    if !chosen.ellipsoid && Capabilities::of(body).ellipsoid {
        log.note(Effect::Ellipsoid.name(), true, reason!("required-by-air"));
    }
    let features = chosen.sky_features(body, case.pixel_view());
    let rim_px = air::rim_px(body, air, case.diameter_px);
    let rim_is_negligible = !inside && rim_px < air::RIM_PX;
    // Unless the catalog gives the ground's own colour, the disc's colour already includes the atmosphere.
    let colour_includes_air = !inside && !air::ground_is_bare(body) && case.pixel_view() != PixelView::OpticalDepth;
    if colour_includes_air
        && (rim_is_negligible || !air::is_opaque(air) || chosen.ring_shadow != RingShadow::None && chosen.eclipse.occluders > 0)
    {
        log.note("air-over-ground", false, reason!("air-in-colours"));
        chosen.air = AtmosphereModel::None;
    } else if colour_includes_air {
        log.note("air-over-ground", true, reason!("air-where-brighter"));
    }
    so_far.blend_mode = match (colour_includes_air, air::is_opaque(air)) {
        (false, _) => 0.0,
        (true, true) => 1.0,
        (true, false) => 2.0,
    };
    let camera = case.frame.camera;
    let rect = if inside { Some(ClipRect::VIEWPORT) } else { Outline::of(camera, &shell).rect(camera) };
    let (Some(rect), Some(mut features), false) = (rect, features, rim_is_negligible) else { return so_far };
    let mut uniforms = globe::uniforms_of_fraction(case, &case.placed.placement, rect, MapSet::default(), &[], 1.0);
    air::set_ends(&mut uniforms, true);
    if !inside {
        uniforms.air.night = 0.0;
    }
    if !inside && rim_px < air::SHADED_RIM_PX && features.ring_shadow != RingShadow::None {
        features.ring_shadow = RingShadow::PointSun;
        uniforms.air.thin_rim = 1.0;
        let reason = reason!("air-ring-shadow", height = format_args!("{rim_px:.2}"), least = air::SHADED_RIM_PX);
        so_far.log.note("ring-shadow-on-air", true, reason);
    }
    let name = format!("{} air", body.name);
    so_far.sky = Some(Draw { body: body.id, part: Part::Sky, name, features, uniforms, map_files: MapFiles::default() });
    so_far
}
