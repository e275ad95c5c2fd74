//! Bodies drawn as points among the other bodies of the frame: what of a point's light nearer bodies and rings leave, and what the point hides behind it.
//!
//! In: placed bodies, their draws and points. Out: the points with the flux that reaches the viewer, and with [`Point::covered_px`] above 0 only where a disc or
//! a ring is behind them; points without light that hide nothing are removed. Errors: a ring counts with its optical depth at the body's centre. Not here: the
//! air of a planet in front of a point, unless the camera is in it (`features`).

use super::hidden::{is_within, record, visible_fraction};
use super::order::is_in_front;
use crate::catalog::NaifId;
use crate::scene::camera::{narrow, narrow_scalar};
use crate::scene::draw::{BodyPart, Draw, Point};
use crate::scene::in_view::BodyInView;
use crate::scene::placed::PlacedBody;
use glam::Vec3;

/// Where the line of sight to a body meets the plane of a planet's rings.
struct RingPlaneCrossing {
    /// Distance from the camera, in distances of the body: above 1 behind it.
    distance: f64,
    /// Distance from the planet's centre.
    radius_km: f64,
    /// Cosine of the angle between the line of sight and the plane's normal, above 0.
    cosine: f64,
}

impl RingPlaneCrossing {
    /// `None` if the line of sight does not meet the plane in front of the camera.
    fn of(body: &PlacedBody<'_>, planet: &PlacedBody<'_>) -> Option<Self> {
        let axes = planet.placement.body_from_icrf;
        let (camera_km, to_body_km) = (axes * -planet.placement.centre_km, axes * body.placement.centre_km);
        let distance = -camera_km.z / to_body_km.z;
        let radius_km = (camera_km + to_body_km * distance).truncate().length();
        let cosine = to_body_km.z.abs() / to_body_km.length();
        (distance > 0.0 && radius_km.is_finite()).then_some(Self { distance, radius_km, cosine })
    }

    /// Optical depth of the planet's rings along the line of sight.
    fn optical_depth(&self, planet: &PlacedBody<'_>) -> f64 {
        let here = planet.body.rings.iter().filter(|ring| (ring.inner_km..=ring.outer_km).contains(&self.radius_km));
        here.map(|ring| ring.tau_normal).sum::<f64>() / self.cosine
    }
}

/// Applies the other bodies to the points, and records the fraction of each body's light that nearer bodies leave visible as a decision.
pub(crate) fn apply(placed: &[PlacedBody<'_>], draws: &[Draw], points: &mut Vec<Point>, bodies: &mut [BodyInView]) {
    let has_draw = |body: NaifId, part: BodyPart| draws.iter().any(|d| d.body == body && d.part == part);
    for point in points.iter_mut() {
        let Some(p) = placed.iter().find(|p| p.body.id == point.body) else { continue };
        let others = || placed.iter().filter(|other| other.body.id != point.body);
        let visible = visible_fraction(placed, p);
        record(bodies, point.body, visible);
        let ringed = others().filter(|other| has_draw(other.body.id, BodyPart::Ring));
        let crossings: Vec<_> =
            ringed.filter_map(|planet| RingPlaneCrossing::of(p, planet).map(|c| (c.distance, c.optical_depth(planet)))).collect();
        let depth_in_front: f64 = crossings.iter().filter(|(distance, _)| *distance < 1.0).map(|(_, depth)| depth).sum();
        let transmitted = visible * (-depth_in_front).exp();
        point.flux *= narrow(transmitted);
        let is_before_disc = |other: &PlacedBody<'_>| is_in_front(p, other) && is_within(p, other, 0.0);
        // The Sun's draw leaves out what small bodies in front of it hide.
        let is_before_sun = others().any(|other| other.body.id == NaifId::SUN && is_before_disc(other));
        let hides = crossings.iter().any(|(distance, depth)| *distance > 1.0 && *depth > 0.0)
            || others().any(|other| has_draw(other.body.id, BodyPart::Globe) && is_before_disc(other));
        point.covered_px *= if hides && !is_before_sun { narrow_scalar(transmitted.element_sum() / 3.0) } else { 0.0 };
    }
    points.retain(|point| point.flux != Vec3::ZERO || point.covered_px > 0.0);
}
