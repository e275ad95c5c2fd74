//! The light of bodies drawn as points, and of the glare of small discs, that nearer bodies and rings do not hide; and what a point itself hides.
//!
//! In: placed bodies, their draws and points. Out: the points with the flux that reaches the viewer, and with [`Point::covered_px`] above 0 only where a disc
//! or a ring is behind them; points without light that hide nothing are removed. Errors: the transmittance of rings is a mean over one diameter of the body's
//! disc, parallel to the pole of the rings. Not here: the air of a planet in front of a point, unless the camera is in it (`scene::features` dims it then).

use super::hidden::{gap_is_below, record_visible_fraction, visible_fraction};
use super::order::is_in_front;
use crate::catalog::NaifId;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::{narrow, narrow_scalar};
use crate::scene::draw::{BodyPart, Draw, Point};
use crate::scene::features::inputs::FrameContext;
use crate::scene::numeric::smooth_rise;
use crate::scene::placed::PlacedBody;
use crate::scene::point::MIN_POINT_RADIUS_PX;
use crate::scene::rings::ring_light::transmittance;
use crate::scene::rings::ring_table::RingInterval;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Sines of the Sun's altitude between which points cease to hide what is behind them: -6 degrees, the end of civil twilight, and 0. In between the radiance of
/// the sky, which is in front of the planets' discs, becomes larger than the radiance of the discs.
const DUSK_SUN_SINES: (f64, f64) = (-0.1045, 0.0);
/// Number of lines of sight to a body along which the rings of a planet are evaluated.
const LINE_OF_SIGHT_COUNT: u32 = 64;

/// A planet whose rings are drawn.
struct RingedPlanet<'p, 'a> {
    placed: &'p PlacedBody<'a>,
    intervals: Arc<Vec<RingInterval>>,
}

/// The rings of a planet, seen in the direction of a body.
struct RingsAtBody {
    /// Fraction of the body's light that the rings in front of it transmit.
    transmittance: f64,
    /// Whether a part of the rings is behind the body.
    are_behind: bool,
}

impl RingedPlanet<'_, '_> {
    /// Evaluates lines of sight to a diameter of the body's disc, parallel to the pole of the rings. One line would not be enough: seen almost edge-on, rings
    /// are narrower than the disc.
    fn rings_at(&self, body: &PlacedBody<'_>) -> RingsAtBody {
        let (planet, unit_km) = (self.placed, self.placed.body.radii_km.x);
        // In the planet's axes and equatorial radii, from its centre.
        let axes = planet.placement.body_from_icrf;
        let camera = axes * -planet.placement.centre_km / unit_km;
        let centre = axes * (body.placement.centre_km - planet.placement.centre_km) / unit_km;
        let radius = body.body.radii_km.element_sum() / 3.0 / unit_km;
        let line_of_sight = (centre - camera).normalize();
        let outer = self.intervals.last().map_or(0.0, |interval| interval.outer);
        // The line of sight to the body's centre passes the planet's centre at this distance.
        if camera.cross(line_of_sight).length() > outer + radius {
            return RingsAtBody { transmittance: 1.0, are_behind: false };
        }
        let diameter = DVec3::Z.reject_from(line_of_sight).try_normalize().unwrap_or(DVec3::ZERO);
        let (mut transmitted, mut total, mut are_behind) = (0.0, 0.0, false);
        for k in 0..LINE_OF_SIGHT_COUNT {
            // The disc is wide in proportion to the cosine, and so is the distance between lines of sight that are evenly spaced in angle.
            let (sine, cosine) = (PI * ((f64::from(k) + 0.5) / f64::from(LINE_OF_SIGHT_COUNT) - 0.5)).sin_cos();
            let point = centre + diameter * (radius * sine);
            let to_camera = (camera - point).normalize();
            // Otherwise the endless ray of `transmittance` crosses the plane only behind the camera, or not at all.
            let is_beyond_plane = point.z * camera.z < 0.0;
            let weight = cosine * cosine;
            transmitted += weight * if is_beyond_plane { transmittance(&self.intervals, point, to_camera) } else { 1.0 };
            total += weight;
            are_behind |= transmittance(&self.intervals, point, -to_camera) < 1.0;
        }
        RingsAtBody { transmittance: transmitted / total, are_behind }
    }
}

/// How much the light of the air around the camera outshines bodies: 0 at night and without air, 1 by day.
fn daylight_weight(frame: &FrameContext<'_>, placed: &[PlacedBody<'_>]) -> f64 {
    let sun = placed.iter().find(|p| p.body.id == NaifId::SUN);
    let sun_altitude_sine = |up: DVec3| sun.map(|s| up.dot(s.placement.centre_km) / s.distance_km);
    let sun_sine = frame.air.filter(|air| air.is_bright()).and_then(|air| sun_altitude_sine(air.up()));
    sun_sine.map_or(0.0, |sine| smooth_rise(DUSK_SUN_SINES, sine))
}

/// Dims the points by what is in front of them, reduces the areas that they cover (to 0 where they hide nothing), and records as a decision the fraction of
/// each body's light that nearer bodies leave visible. `corona_flux`: light of the Sun's corona that no body hides; it is added to the Sun's point.
pub(crate) fn apply(
    frame: &FrameContext<'_>,
    placed: &[PlacedBody<'_>],
    draws: &[Draw],
    corona_flux: Vec3,
    points: &mut Vec<Point>,
    bodies: &mut [BodyReport],
) {
    let has_draw = |body: NaifId, part: BodyPart| draws.iter().any(|d| d.body == body && d.part == part);
    let drawn_discs: Vec<_> = placed.iter().filter(|p| has_draw(p.body.id, BodyPart::Globe)).collect();
    let ring_tables = &frame.context.caches.ring_tables;
    let intervals = |p: &PlacedBody<'_>| ring_tables.intervals(p.body.rings.iter(), p.body.radii_km.x);
    let ringed = placed.iter().filter(|p| has_draw(p.body.id, BodyPart::RingInFront));
    let ringed: Vec<_> = ringed.map(|p| RingedPlanet { placed: p, intervals: intervals(p) }).collect();
    let night_weight = 1.0 - daylight_weight(frame, placed);
    for point in points.iter_mut() {
        let Some(p) = placed.iter().find(|p| p.body.id == point.body) else { continue };
        let visible = visible_fraction(placed, p);
        if !point.is_disc_glare() {
            record_visible_fraction(bodies, point.body, visible);
        }
        let ringed = ringed.iter().filter(|planet| planet.placed.body.id != point.body);
        let rings: Vec<RingsAtBody> = ringed.map(|planet| planet.rings_at(p)).collect();
        let by_rings = rings.iter().map(|r| r.transmittance).product::<f64>();
        // Fraction per channel.
        let transmitted = visible * by_rings;
        point.flux *= narrow(transmitted);
        if point.body == NaifId::SUN {
            point.flux += corona_flux * narrow_scalar(by_rings);
        }
        // The sprite of a point beside a disc may reach into the disc, so the point hides something from that distance on.
        let margin_rad = MIN_POINT_RADIUS_PX * frame.camera.pixel_tangent();
        let is_behind_point =
            |disc: &&&PlacedBody<'_>| disc.body.id != point.body && is_in_front(p, disc) && gap_is_below(p, disc, margin_rad);
        let discs_behind: Vec<_> = drawn_discs.iter().filter(is_behind_point).collect();
        let hides_something = rings.iter().any(|r| r.are_behind) || !discs_behind.is_empty();
        // The Sun outshines the sky at any time.
        let cover_weight = if discs_behind.iter().any(|disc| disc.body.id == NaifId::SUN) { 1.0 } else { night_weight };
        point.covered_px *= if hides_something { narrow_scalar(transmitted.element_sum() / 3.0 * cover_weight) } else { 0.0 };
    }
    points.retain(|point| point.flux != Vec3::ZERO || point.covered_px > 0.0);
}
