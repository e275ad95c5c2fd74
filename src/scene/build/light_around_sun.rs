//! Light around the Sun: refracted limbs of bodies in front of it, its corona and its glare.
//!
//! In: the placed bodies of a frame, and the effects that the user has set. Out: the effects to draw; each decision is added to the report of its body. Not
//! here: the brightness of each effect (`eclipse::refracted_limb`, `light`).

use crate::catalog::NaifId;
use crate::message::{Reason, reason};
use crate::scene::atmosphere::tint_table::FrameTints;
use crate::scene::body_report::BodyReport;
use crate::scene::decision::Decision;
use crate::scene::draw::PixelView;
use crate::scene::eclipse::refracted_limb::{self, RefractedLimb};
use crate::scene::features::inputs::FrameContext;
use crate::scene::light::corona::{self, Corona};
use crate::scene::light::glare::{self, Glare, VeilingGlare};
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use glam::DVec3;

/// The effects drawn around the Sun.
pub(super) struct LightAroundSun {
    pub refracted_limbs: Vec<RefractedLimb>,
    /// The corona; its position in the order of draws is not set yet.
    pub corona: Option<Corona>,
    pub glare: Option<Glare>,
}

impl LightAroundSun {
    /// Decides on all three effects, and records each decision in the report of its body. `tints`: of the air around the camera.
    pub(super) fn decide(frame: &FrameContext<'_>, placed: &[PlacedBody<'_>], tints: &FrameTints<'_>, reports: &mut [BodyReport]) -> Self {
        let (request, camera, threshold) = (frame.context.request, frame.camera, frame.threshold);
        // Limbs and corona are drawn before the air around the camera. The draw of that air multiplies them by its transmittance averaged over the channels,
        // so here they get only the tint: the transmittance divided by that average. A limb is narrow and gets one tint, the corona one for each line of sight.
        // The glare is drawn after the air, so here it gets the transmittance.
        let tint = |towards: DVec3| frame.air.map_or(DVec3::ONE, |a| a.tint(towards));
        let transmittance = |towards: DVec3| frame.air.map_or(DVec3::ONE, |a| a.transmittance(towards));
        // The request with the effects that the user set for this one body, the Sun.
        let own_request = placed.iter().find(|p| p.body.id == NaifId::SUN).and_then(|sun| request.for_body(sun.body));
        let sun_request = own_request.as_ref().unwrap_or(request);
        let veil = VeilingGlare::unless_switched_off(request, camera, placed);
        Self {
            refracted_limbs: refracted_limb::refracted_limbs(request, camera, placed, threshold, tint, reports),
            glare: decide(sun_request, Effect::Glare, glare::glare(request, camera, placed, threshold, transmittance), reports),
            corona: decide(sun_request, Effect::Corona, corona::corona(request, camera, placed, threshold, veil.as_ref(), tints), reports),
        }
    }
}

/// Decides whether to draw an effect of the Sun, and records the decision; pixel views other than the final image have no such effects. A setting of the user
/// takes precedence over the threshold. `found`: the effect, whether it exceeds the threshold, and the reason; `None` if there is nothing to draw or decide.
fn decide<T>(request: &ViewRequest, effect: Effect, found: Option<(T, bool, Reason)>, reports: &mut [BodyReport]) -> Option<T> {
    let (light, exceeds_threshold, reason) = found.filter(|_| request.pixel_view == PixelView::Final)?;
    let (on, reason) = match request.effects.override_of(effect) {
        Some(on) => (on, reason!("set-by-you")),
        None => (exceeds_threshold, reason),
    };
    if let Some(sun) = reports.iter_mut().find(|b| b.id == NaifId::SUN) {
        sun.decisions.push(Decision { effect: effect.name(), on, reason, stated_error: None });
    }
    on.then_some(light)
}
