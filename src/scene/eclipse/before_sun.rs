//! Who stands before the Sun of a body that the viewer sees, and how much light is left there.

use crate::catalog::{Body, NaifId};
use crate::scene::atmosphere::clouds;
use crate::scene::eclipse::occluders::{self, EclipseModelChoice, Occluder, Receiver, ReceiverExtent};
use crate::scene::eclipse::shade::Shade;
use crate::scene::placed::PlacedBody;
use crate::scene::purpose::Purpose;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::{Quality, ViewRequest};
use crate::scene::resources::Context;
use crate::scene::surface::meshes;
use glam::DVec3;

/// The model that the viewer chose, or the best that the quality allows.
pub(crate) fn wanted(request: &ViewRequest) -> EclipseModelChoice {
    match (request.effects.eclipse_model(), request.quality) {
        (Some(model), _) => EclipseModelChoice::Asked(model),
        (None, Quality::Draft) => EclipseModelChoice::Draft,
        (None, Quality::Standard | Quality::Reference) => EclipseModelChoice::Best,
    }
}

pub(crate) struct BeforeSun<'a> {
    pub receiver: Receiver<'a>,
    pub sun: &'a Body,
    /// From the receiver's centre, body axes, equatorial radii.
    pub camera: DVec3,
    pub occluders: Vec<Occluder<'a>>,
    pub reason: String,
}

/// A body that the viewer sees as a receiver of sunlight, the Sun, and who is between the two; `None` where there is no Sun.
pub(crate) fn receiver<'p, 'a>(context: Context<'_>, p: &'p PlacedBody<'a>) -> Option<(&'p Receiver<'a>, &'a Body, &'p [Occluder<'a>])> {
    let body = p.body;
    let sun = p.catalog.body(NaifId::SUN).filter(|s| s.id != body.id)?;
    let (receiver, candidates) = p.before_sun.get_or_init(|| {
        let moving = context.ephemeris.state(body.id, NaifId::SOLAR_SYSTEM_BARYCENTER, p.seen_at, None);
        let receiver = Receiver {
            body,
            position_km: p.position_km,
            time: p.seen_at,
            body_from_icrf: p.body_from_icrf,
            velocity_km_s: moving.map_or(DVec3::ZERO, |a| a.state.vel_km_s),
            sun_from_body_km: p.sun_from_body_km,
        };
        let candidates = occluders::candidates(context.ephemeris, p.catalog.bodies().iter(), sun, &receiver);
        (receiver, candidates)
    });
    Some((receiver, sun, candidates))
}

/// The occluders over a body that the viewer sees, or over all within `reach` equatorial radii of its centre; `None` where there is no Sun.
pub(crate) fn before_sun<'a>(context: Context<'_>, p: &PlacedBody<'a>, diameter_px: f64, reach: Option<f64>) -> Option<BeforeSun<'a>> {
    let body = p.body;
    let (receiver, sun, candidates) = receiver(context, p)?;
    let receiver = *receiver;
    let clouds = body.clouds.as_ref().map_or(1.0, |c| clouds::shell_scale(body, c));
    let air = body.atmosphere.as_ref().map_or(1.0, |a| 1.0 + a.top_km / body.radii_km.x);
    let camera = p.placement.camera_in_unit_sphere() * body.radii_km / body.radii_km.x;
    let mesh = meshes::model(context, body).map_or(1.0, |m| m.reach);
    let extent =
        ReceiverExtent { reach: reach.unwrap_or(air.max(clouds).max(mesh)), camera: Some(camera), pixel: 2.0 / diameter_px.max(1e-9) };
    let everything = context.request.effects.override_of(Effect::Eclipse) == Some(true) || context.request.purpose != Purpose::Display;
    let found = occluders::select_occluders(candidates, sun, &receiver, extent, everything);
    Some(BeforeSun { receiver, sun, camera, occluders: found.occluders, reason: found.reason })
}

/// About what part of its sunlight eclipses leave a body: the mean of what the viewer sees.
pub(crate) fn dimming(context: Context<'_>, p: &PlacedBody<'_>, diameter_px: f64) -> f64 {
    shaded(context, p, diameter_px, |shade, camera| shade.mean(camera)).unwrap_or(1.0)
}

/// Answers a question about the shadows on a body; `None` where there are none. The camera: from the centre, body axes, equatorial radii.
pub(crate) fn shaded<T>(
    context: Context<'_>,
    p: &PlacedBody<'_>,
    diameter_px: f64,
    question: impl FnOnce(&Shade<'_>, DVec3) -> T,
) -> Option<T> {
    if context.request.effects.override_of(Effect::Eclipse) == Some(false) {
        return None;
    }
    estimate_notes(context, p, diameter_px, wanted(context.request), question)
}

/// The mean of [`dimming`] by the best model, whatever the picture is drawn with: what a magnitude is told of.
pub(crate) fn left_by_eclipses(context: Context<'_>, p: &PlacedBody<'_>, diameter_px: f64) -> f64 {
    estimate_notes(context, p, diameter_px, EclipseModelChoice::Best, |shade, camera| shade.mean(camera)).unwrap_or(1.0)
}

fn estimate_notes<T>(
    context: Context<'_>,
    p: &PlacedBody<'_>,
    diameter_px: f64,
    wanted: EclipseModelChoice,
    question: impl FnOnce(&Shade<'_>, DVec3) -> T,
) -> Option<T> {
    let mut found = before_sun(context, p, diameter_px, None)?;
    let model = occluders::model(&mut found.occluders, wanted).model;
    Shade::of(&found.occluders, model, &found.receiver, found.sun).map(|shade| question(&shade, found.camera))
}
