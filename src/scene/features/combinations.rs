//! Which of several effects a body's draws have, where no shader has all of them.
//!
//! In: the inputs of one body and the decisions made before. Out: the decisions, without effects that exclude each other. An eclipse excludes relief and
//! billows finer than the maps: all combinations would multiply the number of shader keys. Where the eclipse takes the same part of the sunlight from all that
//! the frame shows, the shaders need no eclipse: the sunlight is dimmed. Always: by the choice between an eclipse and dimmed sunlight, the light of no pixel
//! jumps by more than [`MAX_UNIFORM_ERROR`].

use crate::message::{Reason, reason};
use crate::scene::atmosphere;
use crate::scene::draw::features::Eclipse;
use crate::scene::draw::uniforms::EclipseUniforms;
use crate::scene::eclipse::points_in_frame::PointsInFrame;
use crate::scene::eclipse::sunlight_past::SunlightPast;
use crate::scene::features::inputs::{DecisionInputs, Decisions};
use crate::scene::light::lights;
use crate::scene::request::effects::Effect;
use glam::DVec3;

/// Largest error, relative to the light that is left, by which sunlight in an eclipse counts as the same everywhere in the frame: some two 8-bit levels.
const MAX_UNIFORM_ERROR: f64 = 0.02;
/// Smallest fraction of sunlight for which this is tested: deeper in the shadow, light that air refracts, which varies in colour, becomes a large part.
const MIN_UNIFORM_FRACTION: f64 = 0.1;

/// What the draws show of an eclipse that not all effects can be combined with.
enum EclipseBesideOthers {
    /// The shadow of every pixel, in place of the other effects.
    Drawn,
    /// This factor on the sunlight, per channel.
    DimmedSunlight { factor: DVec3, max_error: f64 },
}

/// Decides what is drawn of an eclipse if relief or billows finer than the maps are decided on, too. It precedes the decision about the atmosphere, whose draw
/// of the sky has the eclipse. An eclipse that the user has switched on is drawn.
pub(crate) fn decide_eclipse<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let is_forced = inputs.effects().override_of(Effect::Eclipse) == Some(true);
    if decisions.chosen.eclipse.occluders == 0 || is_forced || !inputs.pixel_view().shows_radiance() || inputs.mesh.is_some() {
        return decisions;
    }
    let excludes_detail = decisions.chosen.detail || atmosphere::cloud_decision::may_have_billows(inputs);
    let reason = match eclipse_beside_others(inputs, &decisions, excludes_detail) {
        EclipseBesideOthers::Drawn => return decisions,
        EclipseBesideOthers::DimmedSunlight { factor, .. } if factor == DVec3::ONE => reason!("eclipse-not-in-frame"),
        EclipseBesideOthers::DimmedSunlight { factor, max_error } => {
            decisions.sunlight_factor = factor;
            dimmed_reason(factor, max_error)
        }
    };
    decisions.log.record(Effect::Eclipse.name(), decisions.sunlight_factor != DVec3::ONE, reason);
    (decisions.chosen.eclipse, decisions.eclipse) = (Eclipse::default(), EclipseUniforms::default());
    decisions
}

fn dimmed_reason(factor: DVec3, max_error: f64) -> Reason {
    let [percent, error] = [factor.y, max_error].map(|x| 100.0 * x);
    reason!("eclipse-dims-all", percent = format_args!("{percent:.1}"), error = format_args!("{error:.1}"))
}

fn eclipse_beside_others(inputs: &DecisionInputs<'_, '_>, decisions: &Decisions<'_>, excludes_detail: bool) -> EclipseBesideOthers {
    if !excludes_detail {
        return EclipseBesideOthers::Drawn;
    }
    let Some(sunlight) = SunlightPast::of(&decisions.eclipse, decisions.chosen.eclipse.model) else { return EclipseBesideOthers::Drawn };
    let points = PointsInFrame::of(inputs.frame.camera, &inputs.placed.placement, inputs.body());
    let Some((centre, radius)) = points.ball() else { return EclipseBesideOthers::Drawn };
    let [least, most] = sunlight.range_within(centre, radius);
    let factor = 0.5 * (least + most);
    let max_error = (0.5 * (most - least) / factor.max(DVec3::splat(f64::MIN_POSITIVE))).max_element();
    // Ring-shine is drawn relative to sunlight, and moons' shadows do not dim it.
    let is_uniform = least.min_element() >= MIN_UNIFORM_FRACTION && max_error <= MAX_UNIFORM_ERROR;
    if is_uniform && (factor == DVec3::ONE || !decisions.chosen.ring_shine) {
        return EclipseBesideOthers::DimmedSunlight { factor, max_error };
    }
    EclipseBesideOthers::Drawn
}

/// Leaves out detail in an eclipse.
pub(crate) fn leave_out_detail<'c>(_inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    let chosen = &mut decisions.chosen;
    if chosen.detail && chosen.eclipse.occluders > 0 {
        decisions.log.record(Effect::Detail.name(), false, reason!("left-out-in-eclipse"));
        chosen.detail = false;
    }
    decisions
}

/// Chooses between ring-shine and planet-shine, which no shader has together: the light that causes the smaller irradiance of the ground is left out. This does
/// not depend on what the frame shows.
pub(crate) fn choose_secondary_lights<'c>(inputs: &DecisionInputs<'c, '_>, mut decisions: Decisions<'c>) -> Decisions<'c> {
    if !decisions.chosen.ring_shine || decisions.secondary_lights.is_empty() {
        return decisions;
    }
    // `brightest` is relative to sunlight.
    let rings_irradiance =
        decisions.ring.shine.as_ref().map_or(0.0, |s| s.brightest) * lights::sunlight(inputs.placed.body_to_sun_km).irradiance.x;
    let bodies_irradiance = decisions.secondary_lights.iter().map(|l| l.irradiance.max_element()).fold(0.0, f64::max);
    if bodies_irradiance > rings_irradiance {
        decisions.log.record(Effect::RingShine.name(), false, reason!("rings-beside-shine"));
        decisions.chosen.ring_shine = false;
        decisions.ring.shine = None;
    } else {
        decisions.log.record(Effect::PlanetShine.name(), false, reason!("shine-beside-rings"));
        decisions.secondary_lights.clear();
    }
    decisions
}
