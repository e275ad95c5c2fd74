//! The occluders and the rings between the Sun and a placed body, and the fraction of sunlight that they let through.
//!
//! In: a placed body, its size in pixels, and the request's eclipse settings. Out: the selected occluders and the reason for the selection, or what the caller
//! computes from their shadows, such as the mean fraction of sunlight per channel. The candidates and the rings are computed once per placed body and cached in
//! it.

use crate::catalog::{Body, NaifId};
use crate::ephemeris::BEST_SOURCE;
use crate::message::Reason;
use crate::scene::atmosphere::{clouds, multi_scatter_in_shadow};
use crate::scene::camera::Camera;
use crate::scene::eclipse::approximate_shadow::ApproximateShadow;
use crate::scene::eclipse::model::{EclipseModelChoice, choose_eclipse_model, eclipse_model_choice};
use crate::scene::eclipse::occluders::{self, MIN_BLOCKED_FRACTION_IN_IMAGES, Occluder, Receiver, ReceiverExtent};
use crate::scene::eclipse::shadow_region::{Frustum, ReceiverShape};
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use crate::scene::resources::Context;
use crate::scene::rings::rings_before_sun::{LitBody, RingsBeforeSun, rings_before_sun};
use crate::scene::surface::meshes;
use glam::DVec3;

/// The occluders of one receiver.
pub(crate) struct SunOccluders<'a> {
    pub receiver: Receiver<'a>,
    pub sun: &'a Body,
    /// Camera position relative to the receiver's centre, in the receiver's axes and equatorial radii.
    pub camera_position: DVec3,
    pub occluders: Vec<Occluder<'a>>,
    /// Why these occluders were selected, or why there are none.
    pub reason: Reason,
}

/// A placed body as a receiver of sunlight, the Sun, and the possible occluders between them; `None` if the body is the Sun or the catalog has no Sun.
pub(crate) fn receiver_and_candidates<'p, 'a>(
    context: Context<'_>,
    placed: &'p PlacedBody<'a>,
) -> Option<(&'p Receiver<'a>, &'a Body, &'p [Occluder<'a>])> {
    let body = placed.body;
    let sun = placed.catalog.body(NaifId::SUN).filter(|s| s.id != body.id)?;
    let (receiver, candidates) = placed.receiver_and_candidates.get_or_init(|| {
        let state = context.ephemeris.state(body.id, NaifId::SOLAR_SYSTEM_BARYCENTER, placed.emitted_at, BEST_SOURCE);
        let receiver = Receiver {
            body,
            position_km: placed.position_km,
            time: placed.emitted_at,
            body_from_icrf: placed.body_from_icrf,
            // If the ephemeris has no state, the velocity is 0: aberration is left out.
            velocity_km_s: state.map_or(DVec3::ZERO, |found| found.state.vel_km_s),
            body_to_sun_km: placed.body_to_sun_km,
        };
        let candidates =
            occluders::candidates(context.ephemeris, placed.catalog.bodies().iter(), sun, &receiver, MIN_BLOCKED_FRACTION_IN_IMAGES);
        (receiver, candidates)
    });
    Some((receiver, sun, candidates))
}

/// The rings of other bodies that take sunlight from a placed body, whether or not the user switched eclipses off.
pub(crate) fn rings_of_others<'p, 'a>(context: Context<'_>, placed: &'p PlacedBody<'a>) -> &'p [RingsBeforeSun<'a>] {
    placed.rings_before_sun.get_or_init(|| {
        let PlacedBody { body, position_km, body_to_sun_km, emitted_at, .. } = *placed;
        let lit = LitBody { body, position_km, time: emitted_at, body_to_sun_km };
        rings_before_sun(context.ephemeris, placed.catalog, &context.caches.ring_tables, lit)
    })
}

/// Fraction of the sunlight of a placed body, per channel, that the rings of other bodies let through. It does not depend on the image's settings.
pub(crate) fn sunlight_past_rings(context: Context<'_>, placed: &PlacedBody<'_>) -> DVec3 {
    rings_of_others(context, placed).iter().map(|rings| rings.fraction).product()
}

/// Like [`sunlight_past_rings`], but 1 if the user switched eclipses off.
pub(crate) fn shown_sunlight_past_rings(context: Context<'_>, placed: &PlacedBody<'_>) -> DVec3 {
    let is_switched_off = context.request.effects.override_of_body(placed.body, Effect::Eclipse) == Some(false);
    if is_switched_off { DVec3::ONE } else { sunlight_past_rings(context, placed) }
}

/// The part of a placed body that receives sunlight.
#[derive(Clone, Copy)]
pub(crate) enum ReceivingPart {
    /// The globe or mesh with its air and clouds.
    Body,
    /// Rings out to a radius.
    Rings { outer_km: f64 },
}

/// The occluders of a part of a placed body; `None` if the body is the Sun or the catalog has no Sun. Shadows on the side that faces away from the viewer for
/// whom `placed` was computed do not count. If `camera` is given, shadows outside its frustum do not count either. `diameter_px`: diameter of the body's disc.
pub(crate) fn sun_occluders<'a>(
    context: Context<'_>,
    placed: &PlacedBody<'a>,
    diameter_px: f64,
    part: ReceivingPart,
    camera: Option<&Camera>,
) -> Option<SunOccluders<'a>> {
    let body = placed.body;
    let (receiver, sun, candidates) = receiver_and_candidates(context, placed)?;
    let receiver = *receiver;
    // All radii here are in equatorial radii of the body.
    let (max_radius, shape) = match part {
        ReceivingPart::Rings { outer_km } => (outer_km / body.radii_km.x, ReceiverShape::EquatorialPlane),
        ReceivingPart::Body => {
            let clouds = body.clouds.as_ref().map_or(1.0, |c| clouds::shell_scale(body, c));
            let air = body.atmosphere.as_ref().map_or(1.0, |a| 1.0 + a.top_km / body.radii_km.x);
            let mesh = meshes::mesh_of(context, body).map_or(1.0, |m| m.max_radius);
            (air.max(clouds).max(mesh), ReceiverShape::Ball)
        }
    };
    // From the unit-sphere frame to body axes, in equatorial radii.
    let camera_position = placed.placement.camera_in_unit_sphere() * body.radii_km / body.radii_km.x;
    // Of a shape model, more may be seen than of the ellipsoid.
    let has_horizon = matches!(part, ReceivingPart::Body) && meshes::mesh_of(context, body).is_none();
    let spread_km = if body.atmosphere.is_some() { multi_scatter_in_shadow::MAX_SPREAD_KM } else { 0.0 };
    let frustum = camera
        .map(|c| Frustum::of(c, &placed.placement))
        .map(|f| if has_horizon { f.above_ground(body.radii_km / body.radii_km.x, max_radius, spread_km / body.radii_km.x) } else { f });
    // A pixel's width in equatorial radii: the body's disc is two radii wide. The lower limit avoids a division by 0.
    let extent =
        ReceiverExtent { max_radius, shape, camera_position: Some(camera_position), frustum, pixel_width: 2.0 / diameter_px.max(1e-9) };
    // With the effect forced on (`None`), every candidate whose penumbra touches the body counts, in the image or not.
    let is_forced = context.request.effects.override_of(Effect::Eclipse) == Some(true);
    let min_change = (!is_forced).then(|| context.request.purpose.min_change());
    let found = occluders::select_occluders(candidates, sun, &receiver, extent, min_change, MIN_BLOCKED_FRACTION_IN_IMAGES);
    Some(SunOccluders { receiver, sun, camera_position, occluders: found.occluders, reason: found.reason })
}

/// Approximate fraction of sunlight that eclipses and the rings of other bodies leave on the visible part of a body, per channel; 1 if there are no shadows
/// or the user switched eclipses off. `diameter_px`: diameter of the body's disc.
pub(crate) fn visible_sunlight(context: Context<'_>, placed: &PlacedBody<'_>, diameter_px: f64) -> DVec3 {
    let past_bodies = evaluate_shadow(context, placed, diameter_px, |shadow, camera_position| shadow.mean_sunlight(camera_position));
    past_bodies.unwrap_or(DVec3::ONE) * shown_sunlight_past_rings(context, placed)
}

/// The result of `evaluate`, a function of the shadows of other bodies (not of their rings) on a body and of the camera's position (from the body's centre,
/// body axes, equatorial radii). `None` if there are no shadows or the user switched eclipses off. `diameter_px`: diameter of the body's disc.
pub(crate) fn evaluate_shadow<T>(
    context: Context<'_>,
    placed: &PlacedBody<'_>,
    diameter_px: f64,
    evaluate: impl FnOnce(&ApproximateShadow<'_>, DVec3) -> T,
) -> Option<T> {
    if context.request.effects.override_of(Effect::Eclipse) == Some(false) {
        return None;
    }
    evaluate_shadow_with_model(context, placed, diameter_px, eclipse_model_choice(context.request), evaluate)
}

/// Like [`visible_sunlight`], but always with [`EclipseModelChoice::Best`], even if the user switched eclipses off: it serves magnitudes, which must not
/// depend on the image's settings.
pub(crate) fn visible_sunlight_by_best_model(context: Context<'_>, placed: &PlacedBody<'_>, diameter_px: f64) -> DVec3 {
    let mean_sunlight = |shadow: &ApproximateShadow<'_>, camera_position: DVec3| shadow.mean_sunlight(camera_position);
    let past_bodies = evaluate_shadow_with_model(context, placed, diameter_px, EclipseModelChoice::Best, mean_sunlight);
    past_bodies.unwrap_or(DVec3::ONE) * sunlight_past_rings(context, placed)
}

/// Like [`evaluate_shadow`], but with the given model, whether or not the user switched eclipses off.
fn evaluate_shadow_with_model<T>(
    context: Context<'_>,
    placed: &PlacedBody<'_>,
    diameter_px: f64,
    model_choice: EclipseModelChoice,
    evaluate: impl FnOnce(&ApproximateShadow<'_>, DVec3) -> T,
) -> Option<T> {
    let no_frustum = None;
    let mut found = sun_occluders(context, placed, diameter_px, ReceivingPart::Body, no_frustum)?;
    // This also moves the occluder whose air refracts light to the first place, where `ApproximateShadow` expects it.
    let model = choose_eclipse_model(&mut found.occluders, model_choice).model;
    ApproximateShadow::of(&found.occluders, model, &found.receiver, found.sun).map(|shadow| evaluate(&shadow, found.camera_position))
}
