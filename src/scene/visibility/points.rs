//! Bodies drawn as points among the other bodies of the frame: what of a point's light nearer bodies and rings leave, and what the point hides behind it.
//!
//! In: placed bodies, their draws and points. Out: the points with the flux that reaches the viewer, and with [`Point::covered_px`] above 0 only where a disc
//! or a ring is behind them; points without light that hide nothing are removed. Errors: the transmittance of rings is a mean over one diameter of the body's
//! disc, parallel to the pole of the rings. Not here: the air of a planet in front of a point, unless the camera is in it (`features`).

use super::hidden::{is_within, record, visible_fraction};
use super::order::is_in_front;
use crate::catalog::NaifId;
use crate::scene::camera::{Camera, narrow, narrow_scalar};
use crate::scene::draw::{BodyPart, Draw, Point};
use crate::scene::in_view::BodyInView;
use crate::scene::placed::PlacedBody;
use crate::scene::point::POINT_RADIUS_PX;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Number of lines of sight to a body on which the rings of a planet are evaluated.
const LINES_OF_SIGHT: u32 = 64;

/// Where a line of sight to a body meets the plane of a planet's rings.
struct RingPlaneCrossing {
    /// Distance from the camera, in distances of the body: above 1 behind it.
    distance: f64,
    /// Distance from the planet's centre.
    radius_km: f64,
    /// Cosine of the angle between the line of sight and the plane's normal, above 0.
    cosine: f64,
}

impl RingPlaneCrossing {
    /// The camera's position and the line of sight from there to the body, in the axes of the rings' planet. `None` if the line of sight does not meet the
    /// plane in front of the camera.
    fn of(camera_km: DVec3, line_of_sight_km: DVec3) -> Option<Self> {
        let distance = -camera_km.z / line_of_sight_km.z;
        let radius_km = (camera_km + line_of_sight_km * distance).truncate().length();
        let cosine = line_of_sight_km.z.abs() / line_of_sight_km.length();
        (distance > 0.0 && radius_km.is_finite()).then_some(Self { distance, radius_km, cosine })
    }

    /// Optical depth of the planet's rings along the line of sight.
    fn optical_depth(&self, planet: &PlacedBody<'_>) -> f64 {
        let here = planet.body.rings.iter().filter(|ring| (ring.inner_km..=ring.outer_km).contains(&self.radius_km));
        here.map(|ring| ring.tau_normal).sum::<f64>() / self.cosine
    }
}

/// The rings of a planet, seen in the direction of a body.
struct RingsAtBody {
    /// Fraction of the body's light that the rings in front of it transmit.
    transmittance: f64,
    /// Whether a part of the rings is behind the body.
    are_behind: bool,
}

impl RingsAtBody {
    /// Lines of sight to a diameter of the disc parallel to the pole of the rings: seen almost edge-on, rings are narrower than the disc.
    fn of(body: &PlacedBody<'_>, planet: &PlacedBody<'_>) -> Self {
        let axes = planet.placement.body_from_icrf;
        let (camera_km, to_body_km) = (axes * -planet.placement.centre_km, axes * body.placement.centre_km);
        let diameter = DVec3::Z.reject_from(to_body_km).try_normalize().unwrap_or(DVec3::ZERO);
        let radius_km = body.body.radii_km.element_sum() / 3.0;
        let (mut transmitted, mut total, mut are_behind) = (0.0, 0.0, false);
        for k in 0..LINES_OF_SIGHT {
            // The disc is wide in proportion to the cosine, and so is the distance between lines of sight that are evenly spaced in angle.
            let (sine, cosine) = (PI * ((f64::from(k) + 0.5) / f64::from(LINES_OF_SIGHT) - 0.5)).sin_cos();
            let crossing = RingPlaneCrossing::of(camera_km, to_body_km + diameter * (radius_km * sine));
            let depth = crossing.as_ref().map_or(0.0, |c| c.optical_depth(planet));
            let is_behind = crossing.is_some_and(|c| c.distance > 1.0);
            are_behind |= is_behind && depth > 0.0;
            let weight = cosine * cosine;
            transmitted += weight * if is_behind { 1.0 } else { (-depth).exp() };
            total += weight;
        }
        Self { transmittance: transmitted / total, are_behind }
    }
}

/// Applies the other bodies to the points, and records the fraction of each body's light that nearer bodies leave visible as a decision.
pub(crate) fn apply(placed: &[PlacedBody<'_>], camera: &Camera, draws: &[Draw], points: &mut Vec<Point>, bodies: &mut [BodyInView]) {
    let has_draw = |body: NaifId, part: BodyPart| draws.iter().any(|d| d.body == body && d.part == part);
    for point in points.iter_mut() {
        let Some(p) = placed.iter().find(|p| p.body.id == point.body) else { continue };
        let others = || placed.iter().filter(|other| other.body.id != point.body);
        let visible = visible_fraction(placed, p);
        record(bodies, point.body, visible);
        let ringed = others().filter(|other| has_draw(other.body.id, BodyPart::Ring));
        let rings: Vec<RingsAtBody> = ringed.map(|planet| RingsAtBody::of(p, planet)).collect();
        let transmitted = visible * rings.iter().map(|r| r.transmittance).product::<f64>();
        point.flux *= narrow(transmitted);
        // A sprite beside a disc reaches into it: the cover fades in while the body approaches the disc.
        let is_before_disc =
            |other: &PlacedBody<'_>| is_in_front(p, other) && is_within(p, other, POINT_RADIUS_PX * camera.pixel_tangent());
        let hides =
            rings.iter().any(|r| r.are_behind) || others().any(|other| has_draw(other.body.id, BodyPart::Globe) && is_before_disc(other));
        point.covered_px *= if hides { narrow_scalar(transmitted.element_sum() / 3.0) } else { 0.0 };
    }
    points.retain(|point| point.flux != Vec3::ZERO || point.covered_px > 0.0);
}
