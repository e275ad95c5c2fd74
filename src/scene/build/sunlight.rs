//! Light around the Sun: refracted limbs of bodies in front of it, its corona and its glare.

use crate::catalog::NaifId;
use crate::message::{Reason, reason};
use crate::scene::decision::Decision;
use crate::scene::draw::PixelView;
use crate::scene::eclipse::refracted_limb::{self, RefractedLimb};
use crate::scene::features::inputs::FrameContext;
use crate::scene::in_view::BodyInView;
use crate::scene::light::corona::{self, Corona};
use crate::scene::light::glare::{self, Glare, VeilingGlare};
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use glam::DVec3;

/// The effects drawn around the Sun.
pub(super) struct LightAroundSun {
    pub limbs: Vec<RefractedLimb>,
    /// The corona; its position in the order of draws is not set yet.
    pub corona: Option<Corona>,
    pub glare: Option<Glare>,
}

impl LightAroundSun {
    /// Decides on all three effects, and records each decision in the report of its body.
    pub(super) fn decide(frame: &FrameContext<'_>, placed: &[PlacedBody<'_>], reports: &mut [BodyInView]) -> Self {
        let (request, camera, threshold) = (frame.context.request, frame.camera, frame.threshold);
        let tint = |towards: DVec3| frame.air.map_or(DVec3::ONE, |a| a.tint(towards));
        let transmittance = |towards: DVec3| frame.air.map_or(DVec3::ONE, |a| a.transmittance(towards));
        let own_request = placed.iter().find(|p| p.body.id == NaifId::SUN).and_then(|sun| request.for_body(sun.body));
        let sun_request = own_request.as_ref().unwrap_or(request);
        let veil = VeilingGlare::drawn(request, camera, placed);
        Self {
            limbs: refracted_limb::refracted_limbs(request, camera, placed, threshold, tint, reports),
            glare: decide(sun_request, Effect::Glare, glare::glare(request, camera, placed, threshold, transmittance), reports),
            corona: decide(sun_request, Effect::Corona, corona::corona(request, camera, placed, threshold, veil.as_ref(), tint), reports),
        }
    }
}

/// Decides whether to keep an effect of the Sun, and records the decision. A setting in the request overrides the effect's bound. `found`: the effect,
/// whether its bound exceeds the threshold, and the reason.
fn decide<T>(request: &ViewRequest, effect: Effect, found: Option<(T, bool, Reason)>, reports: &mut [BodyInView]) -> Option<T> {
    let (light, by_bound, reason) = found.filter(|_| request.pixel_view == PixelView::Final)?;
    let (on, reason) = match request.effects.override_of(effect) {
        Some(on) => (on, reason!("set-by-you")),
        None => (by_bound, reason),
    };
    if let Some(sun) = reports.iter_mut().find(|b| b.id == NaifId::SUN) {
        sun.decisions.push(Decision { effect: effect.name(), on, reason, stated_error: None });
    }
    on.then_some(light)
}
