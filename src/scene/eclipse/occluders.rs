//! The occluders of a receiver.
//!
//! In: the receiver at the time when light reaches it, and the catalog's other bodies. Out: at most [`MAX_OCCLUDERS`] occluders that can darken a visible
//! pixel. Light time is accounted for. The Sun is where it was when the light that now reaches the receiver left the Sun; an occluder is where it was when that
//! light passed the occluder. The directions to Sun and occluder include the aberration by the receiver's motion. Aberration does not change the angle between
//! the two as seen from the receiver's centre, but tilts the shadow's axis, so that the shadow is displaced elsewhere on the body (20 arcsec at the Earth: 0.6
//! km, 0.6 s). shaders/lib/eclipse computes the remaining light.

use crate::catalog::{Body, BodyKind, NaifId, Photometry};
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::{BEST_SOURCE, Ephemeris};
use crate::message::{Reason, reason};
use crate::scene::draw::features::MAX_OCCLUDERS;
use crate::scene::eclipse::refraction::{self, BentLight};
use crate::scene::eclipse::shadow_region::{Frustum, ReceiverShape, ShadowRegion};
use crate::scene::thresholds::VISIBLE_CHANGE;
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::{DMat2, DMat3, DVec2, DVec3};

/// The lit body at the time when light reaches it.
#[derive(Clone, Copy, Debug)]
pub struct Receiver<'a> {
    pub body: &'a Body,
    /// Barycentric position at `time`, ICRF.
    pub position_km: DVec3,
    /// The time at which the light reaches the body.
    pub time: Instant,
    /// Orientation at `time`.
    pub body_from_icrf: DMat3,
    /// Barycentric velocity, for the aberration of directions to occluders and the Sun.
    pub velocity_km_s: DVec3,
    /// Vector from the body to where the Sun was when the light left the Sun, ICRF.
    pub body_to_sun_km: DVec3,
}

impl<'a> Receiver<'a> {
    /// A body that light reaches at `time`.
    pub fn at(ephemeris: &Ephemeris, body: &'a Body, time: Instant) -> Result<Self, crate::ephemeris::EphemerisError> {
        let state = ephemeris.state(body.id, NaifId::SOLAR_SYSTEM_BARYCENTER, time, BEST_SOURCE)?.state;
        let position_km = state.pos_km;
        let (sun_km, _emission_time) = ephemeris.light_time_position(NaifId::SUN, position_km, time)?;
        let body_to_sun_km = sun_km - position_km;
        let velocity_km_s = state.vel_km_s;
        Ok(Self { body, position_km, time, velocity_km_s, body_from_icrf: ephemeris.body_from_icrf(body.id, time)?, body_to_sun_km })
    }

    pub(crate) fn radius_km(&self) -> f64 {
        self.body.radii_km.x
    }

    /// Corrects a vector from the receiver's centre for the aberration by its motion; the result is in body axes and equatorial radii.
    fn apparent_offset(&self, offset_km: DVec3) -> DVec3 {
        let distance_km = offset_km.length();
        if distance_km > 0.0 {
            self.body_from_icrf * aberrated(offset_km / distance_km, self.velocity_km_s) * (distance_km / self.radius_km())
        } else {
            DVec3::ZERO
        }
    }
}

/// The axis from the receiver's centre to the Sun's centre, in body axes; lengths in the receiver's equatorial radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    /// Unit vector to the Sun's centre.
    pub(crate) sunward: DVec3,
    /// Unit vectors perpendicular to `sunward` and to each other. Every 2D vector "across the axis" has these two as its basis.
    pub(crate) perpendicular_axes: [DVec3; 2],
    pub(crate) sun_distance: f64,
    /// Cotangent of the Sun's angular radius.
    pub(crate) cot_sun_angular_radius: f64,
}

impl Axis {
    /// `None` if the receiver's centre is inside the Sun.
    pub(crate) fn of(receiver: &Receiver<'_>, sun: &Body) -> Option<Self> {
        let to_sun = receiver.apparent_offset(receiver.body_to_sun_km);
        let sun_radius = sun.radii_km.max_element() / receiver.radius_km();
        let sun_distance = to_sun.length();
        if sun_distance.partial_cmp(&sun_radius) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let sunward = to_sun / sun_distance;
        let (x, y) = sunward.any_orthonormal_pair();
        let cot_sun_angular_radius = ((sun_distance - sun_radius) * (sun_distance + sun_radius)).sqrt() / sun_radius;
        Some(Self { sunward, perpendicular_axes: [x, y], sun_distance, cot_sun_angular_radius })
    }

    /// Components of a vector along the two `perpendicular_axes`.
    pub(crate) fn offset_across(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.perpendicular_axes[0]), v.dot(self.perpendicular_axes[1]))
    }
}

/// Light time from occluder to receiver, seconds, below which the occluder is treated as moving in a straight line during that time. Most bodies of one system
/// are closer together. In this time a moon's path deviates from a straight line by up to 0.4 km (Metis, whose path curves most), Io's by 40 m
/// (tests/ephemeris/positions.rs).
const MAX_STRAIGHT_LIGHT_TIME_S: f64 = 10.0;

/// In images, a body that can block only a smaller fraction of sunlight than this is no occluder: a tenth of the smallest visible change. As seen from the
/// systems of Mercury to Jupiter, all planets in transit but Venus and the Earth block less.
pub const MIN_BLOCKED_FRACTION_IN_IMAGES: f64 = 0.1 * VISIBLE_CHANGE;

/// A body that may be in front of the Sun: its outline projected along the axis, in the receiver's equatorial radii.
#[derive(Clone, Debug)]
pub struct Occluder<'a> {
    pub body: &'a Body,
    /// Position of the occluder's centre relative to the receiver's centre: components perpendicular to the axis, and the component along it, towards the Sun.
    pub(crate) offset_across: DVec2,
    pub(crate) distance_along: f64,
    /// Unit vector along the outline's major axis.
    pub(crate) long_axis: DVec2,
    /// Semi-axes of the outline, major and minor.
    pub(crate) semi_axes: DVec2,
    /// Largest fraction of sunlight that the body can block at any point of the receiver; 0 until [`select_occluders`] computes it.
    pub(crate) max_blocked_fraction: f64,
    /// Whether light that its air bends may reach a point of the receiver; `None` until [`select_occluders`] computes it.
    pub(crate) bent_light: BentLight,
}

/// Limb-darkening coefficients u1 and u2 of an emissive body, per channel; 0 for other bodies.
pub fn limb_darkening(body: &Body) -> (DVec3, DVec3) {
    match body.photometry {
        Photometry::Emissive { u1, u2 } => (DVec3::from_array(u1), DVec3::from_array(u2)),
        _ => (DVec3::ZERO, DVec3::ZERO),
    }
}

/// Ratio of the radiance at the centre of the Sun's disc to the disc's mean radiance, in the channel where it is largest; catalogs/README.md
/// explains the coefficients.
fn centre_to_mean_radiance(sun: &Body) -> f64 {
    let (u1, u2) = limb_darkening(sun);
    (0..3).map(|c| 1.0 / (1.0 - u1[c] / 3.0 - u2[c] / 6.0)).fold(1.0, f64::max)
}

/// The points of a receiver that sunlight may reach, and how the viewer sees them.
#[derive(Clone, Copy, Debug)]
pub struct ReceiverExtent {
    /// Farthest lit point from the centre, equatorial radii: 1 for the ground, more with air, clouds or rings.
    pub max_radius: f64,
    pub shape: ReceiverShape,
    /// Camera position from the centre, body axes, equatorial radii; `None`: every side is visible.
    pub camera_position: Option<DVec3>,
    /// The image; `None`: every direction is visible, and every pixel has the size `pixel_width`.
    pub frustum: Option<Frustum>,
    /// Width of a pixel at the receiver's centre in equatorial radii; 0 if single points are evaluated instead of pixels.
    pub pixel_width: f64,
}

/// How much an occluder matters to an image, in increasing order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Importance {
    /// Its shadow is on the far side or outside the image.
    OutOfView,
    /// Its shadow is in the image, but too faint or too small to see.
    Negligible,
    Visible,
}

/// The occluders of a receiver, and the reason for the choice.
pub struct FoundOccluders<'a> {
    /// Sorted by importance to the image, then by the light that they block, largest first.
    pub occluders: Vec<Occluder<'a>>,
    pub reason: Reason,
}

/// The first part of the search for occluders, and the only one that evaluates the ephemeris: the bodies between the receiver and the Sun that can block at
/// least `min_blocked_fraction` of the receiver's sunlight, even if their shadows miss the receiver. `min_blocked_fraction` is
/// [`MIN_BLOCKED_FRACTION_IN_IMAGES`], or 0 to include bodies of any size.
pub fn candidates<'a>(
    ephemeris: &Ephemeris,
    bodies: impl Iterator<Item = &'a Body>,
    sun: &Body,
    receiver: &Receiver<'_>,
    min_blocked_fraction: f64,
) -> Vec<Occluder<'a>> {
    let Some(axis) = Axis::of(receiver, sun) else { return Vec::new() };
    let can_block = |b: &Body| min_blocked_fraction <= 0.0 || can_occlude(b, receiver.body);
    let others = bodies.filter(|b| b.id != receiver.body.id && b.id != sun.id && can_block(b));
    others.filter_map(|body| Occluder::of(ephemeris, body, receiver, &axis, sun, min_blocked_fraction)).collect()
}

/// The second part of the search: selects those candidates of `receiver` whose shadows matter, and the reason for the selection. `min_change`: the relative
/// change of a pixel above which a shadow in the image matters; `None`: every shadow whose penumbra touches the receiver matters, in the image or not.
/// `min_blocked_fraction`: as for [`candidates`].
pub fn select_occluders<'a>(
    candidates: &[Occluder<'a>],
    sun: &Body,
    receiver: &Receiver<'_>,
    extent: ReceiverExtent,
    min_change: Option<f64>,
    min_blocked_fraction: f64,
) -> FoundOccluders<'a> {
    let Some(axis) = Axis::of(receiver, sun) else {
        return FoundOccluders { occluders: Vec::new(), reason: reason!("inside-sun") };
    };
    let mut occluders = Vec::new();
    // The smallest gap, in penumbra radii, between a penumbra and the receiver, and the name of the occluder.
    let mut nearest_miss: Option<(f64, &'a str)> = None;
    let mut out_of_view = Vec::new();
    for occluder in candidates {
        let occluder = occluder.for_points_within(&axis, sun, extent.max_radius, receiver);
        if occluder.max_blocked_fraction < min_blocked_fraction {
            continue;
        }
        let gap = occluder.penumbra_gap(&axis, extent.max_radius);
        if gap > 0.0 {
            let gap_ratio = gap / occluder.penumbra_radius(&axis, extent.max_radius);
            if occluder.max_blocked_fraction > VISIBLE_CHANGE && nearest_miss.is_none_or(|(min_ratio, _)| gap_ratio < min_ratio) {
                nearest_miss = Some((gap_ratio, &occluder.body.name));
            }
            continue;
        }
        let axis_ratios = receiver.body.radii_km / receiver.radius_km();
        let importance = occluder.importance(&axis, extent, axis_ratios, min_change.unwrap_or(VISIBLE_CHANGE));
        if importance == Importance::Visible || min_change.is_none() {
            occluders.push((importance, occluder));
        } else if importance == Importance::OutOfView {
            out_of_view.push(occluder.body.name.clone());
        }
    }
    // A large moon whose shadow falls outside the image must not take the place of a small one whose shadow is in it.
    let blocked_light = |o: &Occluder<'_>| o.max_blocked_fraction * o.outline_area();
    occluders
        .sort_by(|(importance_a, a), (importance_b, b)| importance_b.cmp(importance_a).then(blocked_light(b).total_cmp(&blocked_light(a))));
    let mut occluders: Vec<Occluder<'a>> = occluders.into_iter().map(|(_, occluder)| occluder).collect();
    let left_out = occluders.len().saturating_sub(usize::from(MAX_OCCLUDERS));
    occluders.truncate(usize::from(MAX_OCCLUDERS));
    let reason = match (occluders.first(), nearest_miss) {
        (Some(first), _) => {
            let names: Vec<String> = occluders.iter().map(|o| o.body.name.clone()).collect();
            let takes = reason!("eclipse-takes", body = &first.body.name, part = format_args!("{:.3}", first.max_blocked_fraction));
            let found = reason!("eclipse-penumbra-of", bodies = names).and(takes);
            if left_out > 0 { found.and(reason!("eclipse-omitted", count = left_out)) } else { found }
        }
        (None, _) if !out_of_view.is_empty() => reason!("eclipse-out-of-view", bodies = out_of_view),
        (None, Some((gap_ratio, name))) => reason!("eclipse-nearest", body = name, share = format_args!("{gap_ratio:.2}")),
        (None, None) => reason!("eclipse-none", part = format_args!("{:.2e}", min_change.unwrap_or(0.0).max(min_blocked_fraction))),
    };
    FoundOccluders { occluders, reason }
}

/// Whether a body can darken a receiver visibly. In other systems only planets are large enough: Jupiter blocks a twentieth of Saturn's sunlight, Ganymede
/// 7e-5.
fn can_occlude(occluder: &Body, receiver: &Body) -> bool {
    occluder.system_planet() == receiver.system_planet() || occluder.kind == BodyKind::Planet
}

/// Largest fraction of sunlight that a body of this radius can block for a point at a distance `depth` behind it; both in the receiver's equatorial radii.
fn max_blocked_fraction(radius: f64, axis: &Axis, sun: &Body, depth: f64) -> f64 {
    let apparent_radius = radius * axis.cot_sun_angular_radius / depth.max(1e-9);
    // In solar radii. The most light is lost where the body covers the bright centre of the Sun's disc.
    if apparent_radius >= 1.0 { 1.0 } else { (apparent_radius * apparent_radius * centre_to_mean_radiance(sun)).min(1.0) }
}

impl<'a> Occluder<'a> {
    /// `None` if the body is not between the receiver and the Sun, certainly blocks less than `min_fraction` of sunlight, or is not in the ephemeris.
    fn of(ephemeris: &Ephemeris, body: &'a Body, receiver: &Receiver<'_>, axis: &Axis, sun: &Body, min_fraction: f64) -> Option<Self> {
        let receiver_radius_km = receiver.radius_km();
        let radius = body.radii_km.max_element() / receiver_radius_km;
        // The geometric position, not corrected for light time, is enough to reject bodies that are far too small. Half the distance leaves a margin for its
        // error.
        let geometric = ephemeris.state(body.id, NaifId::SOLAR_SYSTEM_BARYCENTER, receiver.time, BEST_SOURCE).ok()?.state;
        let distance_km = (geometric.pos_km - receiver.position_km).length();
        // The geometric position is also enough to reject bodies behind the receiver or beyond the Sun. The margin is for light time and aberration: speeds are
        // below 2e-4 of that of light.
        let distance = distance_km / receiver_radius_km;
        let along = receiver.apparent_offset(geometric.pos_km - receiver.position_km).dot(axis.sunward);
        let is_between = along > -1e-3 * distance && along < axis.sun_distance + 1e-3 * distance;
        if !is_between || max_blocked_fraction(radius, axis, sun, 0.5 * distance) < min_fraction {
            return None;
        }
        let light_time_s = distance_km / SPEED_OF_LIGHT_KM_S;
        // Where and when the light passed the occluder.
        let (position_km, passage_time) = if light_time_s < MAX_STRAIGHT_LIGHT_TIME_S {
            // Orbital speeds are 1e-4 of the speed of light, so one iteration is enough.
            let light_time_s = (geometric.pos_km - geometric.vel_km_s * light_time_s - receiver.position_km).length() / SPEED_OF_LIGHT_KM_S;
            (geometric.pos_km - geometric.vel_km_s * light_time_s, receiver.time.plus_seconds(-light_time_s))
        } else {
            ephemeris.light_time_position(body.id, receiver.position_km, receiver.time).ok()?
        };
        let centre = receiver.apparent_offset(position_km - receiver.position_km);
        let (distance_along, offset_across) = (centre.dot(axis.sunward), axis.offset_across(centre));
        if distance_along <= 0.0 || distance_along >= axis.sun_distance {
            return None;
        }
        let occluder_from_icrf = ephemeris.body_from_icrf(body.id, passage_time).ok()?;
        let (long_axis, semi_axes) =
            outline(axis, receiver.body_from_icrf * occluder_from_icrf.transpose(), body.radii_km / receiver_radius_km);
        Some(Self { body, offset_across, distance_along, long_axis, semi_axes, max_blocked_fraction: 0.0, bent_light: BentLight::None })
    }

    /// A copy with `max_blocked_fraction` and `bent_light` set for points within `max_radius` of the centre of the receiver.
    fn for_points_within(&self, axis: &Axis, sun: &Body, max_radius: f64, receiver: &Receiver<'_>) -> Self {
        let radius = self.body.radii_km.max_element() / receiver.radius_km();
        let max_blocked_fraction = max_blocked_fraction(radius, axis, sun, (self.distance_along - max_radius).max(radius));
        let is_in_system = self.body.system_planet() == receiver.body.system_planet();
        let shift_per_bending = refraction::shift_per_bending(self.distance_along, axis.sun_distance);
        let max_bending = refraction::max_reduced_bending(self.body, shift_per_bending).filter(|_| is_in_system);
        let bent_light = max_bending.map_or(BentLight::None, |bending| {
            // Points nearer to the middle of the shadow than this get no light through the air.
            let dark_radius = self.semi_axes.y - (self.distance_along + max_radius) * (bending + 1.0 / axis.cot_sun_angular_radius);
            if self.offset_across.length() + max_radius > dark_radius { BentLight::Reaches } else { BentLight::Misses }
        });
        Self { max_blocked_fraction, bent_light, ..self.clone() }
    }

    /// Radius of the penumbra at the end of the receiver that is farthest from the occluder, where it is largest.
    fn penumbra_radius(&self, axis: &Axis, max_radius: f64) -> f64 {
        self.semi_axes.x + (self.distance_along + max_radius) / axis.cot_sun_angular_radius
    }

    /// Area of the occluder's outline. The occluder blocks at most the sunlight that would fall on an area of this size.
    fn outline_area(&self) -> f64 {
        std::f64::consts::PI * self.semi_axes.x * self.semi_axes.y
    }

    /// Distance by which the penumbra misses the receiver; 0 or less if it touches.
    fn penumbra_gap(&self, axis: &Axis, max_radius: f64) -> f64 {
        self.offset_across.length() - max_radius - self.penumbra_radius(axis, max_radius)
    }

    /// How much the shadow matters to the image. `axis_ratios`: the receiver's semi-axes divided by its equatorial radius; `min_change`: the relative change
    /// of a pixel above which the change is visible.
    fn importance(&self, axis: &Axis, extent: ReceiverExtent, axis_ratios: DVec3, min_change: f64) -> Importance {
        let mut pixel_width = extent.pixel_width;
        if let Some(frustum) = extent.frustum {
            let centre = axis.perpendicular_axes[0] * self.offset_across.x
                + axis.perpendicular_axes[1] * self.offset_across.y
                + axis.sunward * self.distance_along;
            // By how much the penumbra's radius grows per distance behind the occluder.
            let widening = 1.0 / axis.cot_sun_angular_radius;
            let region = ShadowRegion::of(centre, self.semi_axes.x, axis.sunward, widening, extent.max_radius, extent.shape);
            match region.filter(|r| r.meets(&frustum)) {
                Some(region) => pixel_width = region.min_pixel(&frustum),
                None => return Importance::OutOfView,
            }
        }
        if !self.shadow_is_visible(axis, extent, axis_ratios) {
            return Importance::OutOfView;
        }
        // A shadow smaller than a pixel darkens it in proportion to its area.
        let pixel_fraction = if pixel_width > 0.0 { self.outline_area() / (pixel_width * pixel_width) } else { 1.0 };
        if self.max_blocked_fraction * pixel_fraction.min(1.0) > min_change { Importance::Visible } else { Importance::Negligible }
    }

    /// Whether a point that the occluder darkens may be on the side that the viewer sees; true if this is unknown (rings, or points far above the ground).
    /// Tests points in the penumbra, and the lit point that projects along the axis to the same place as the sub-observer point. `MARGIN` covers the gaps
    /// between these points. Points and horizon are computed for the ellipsoid with these `axis_ratios`: with a sphere for an oblate planet, they would be
    /// off by more than the margin.
    fn shadow_is_visible(&self, axis: &Axis, extent: ReceiverExtent, axis_ratios: DVec3) -> bool {
        /// Equatorial radii.
        const MARGIN: f64 = 0.03;
        /// Larger receivers are not tested: points far above the ground are visible far beyond the horizon.
        const MAX_TESTED_RADIUS: f64 = 1.2;
        let is_tested = extent.shape == ReceiverShape::Ball && extent.max_radius < MAX_TESTED_RADIUS;
        let Some(camera) = extent.camera_position.filter(|_| is_tested) else { return true };
        let camera = camera / axis_ratios;
        let distance = camera.length();
        let radius = self.penumbra_radius(axis, extent.max_radius) + MARGIN;
        let towards_camera = camera / distance;
        // A point of the ground is visible if its component towards the camera exceeds 1 / distance. A point at height h is visible farther beyond the horizon,
        // by about sqrt(2 h); the factor 1.5 is sqrt(2), rounded up.
        let min_component = 1.0 / distance - MARGIN - (extent.max_radius - 1.0).max(0.0).sqrt() * 1.5;
        let sunward_in_unit_sphere = (axis.sunward / axis_ratios).normalize();
        // The lit point at an offset across the axis, or, beyond the receiver's outline, the nearest point of that outline; in the frame in which the
        // receiver is the unit sphere.
        let lit_point = |offset_across: DVec2| {
            let point = (axis.perpendicular_axes[0] * offset_across.x + axis.perpendicular_axes[1] * offset_across.y) / axis_ratios;
            let foot = (point - sunward_in_unit_sphere * point.dot(sunward_in_unit_sphere)).clamp_length_max(1.0);
            foot + sunward_in_unit_sphere * (1.0 - foot.length_squared()).max(0.0).sqrt()
        };
        let is_visible = |offset_across: DVec2| {
            let point = lit_point(offset_across);
            // The thousandth keeps points that rounding moves just outside the edge.
            let is_in_penumbra = (axis.offset_across(point * axis_ratios) - self.offset_across).length() <= radius * 1.001;
            is_in_penumbra && towards_camera.dot(point) > min_component
        };
        let penumbra_is_visible = (0..96).any(|k| {
            let direction = DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 96.0);
            [1.0, 0.66, 0.33, 0.0].iter().any(|fraction| is_visible(self.offset_across + direction * (radius * fraction)))
        });
        penumbra_is_visible || is_visible(axis.offset_across(towards_camera * axis_ratios))
    }
}

/// Major axis and semi-axes of an ellipsoid's outline projected along the axis. `radii`: the ellipsoid's semi-axes, which `receiver_from_occluder` rotates
/// into the receiver's axes.
pub(crate) fn outline(axis: &Axis, receiver_from_occluder: DMat3, radii: DVec3) -> (DVec2, DVec2) {
    // The squared half width along a unit vector n is n M n, where M sums the outer products of the projected semi-axes.
    let m = [0, 1, 2].map(|k| {
        let a = axis.offset_across(receiver_from_occluder.col(k)) * radii[k];
        DMat2::from_cols(a * a.x, a * a.y)
    });
    let m = m[0] + m[1] + m[2];
    let (p, q, r) = (m.x_axis.x, m.x_axis.y, m.y_axis.y);
    let (mean, spread) = (0.5 * (p + r), (0.5 * (p - r)).hypot(q));
    let long_axis = DVec2::from_angle(0.5 * (2.0 * q).atan2(p - r));
    (long_axis, DVec2::new((mean + spread).max(0.0).sqrt(), (mean - spread).max(0.0).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;
    use crate::random::Random;

    /// Mercury in front of the Sun, seen from Venus, is too small to be an occluder in images, even if every shadow counts. Venus has no other: no draw needs
    /// a module with an eclipse of Venus. A body with five times Mercury's radius is an occluder, and so is Mercury where every body counts.
    #[test]
    fn a_body_too_small_to_be_seen_is_no_occluder() {
        let catalog = Catalog::embedded();
        let [venus, mercury, sun] = [299, 199, 10].map(|id| catalog.body(NaifId(id)).expect("in the catalog"));
        let receiver = Receiver {
            body: venus,
            position_km: DVec3::ZERO,
            time: Instant::from_tdb_seconds_past_j2000(0.0),
            body_from_icrf: DMat3::IDENTITY,
            velocity_km_s: DVec3::ZERO,
            body_to_sun_km: DVec3::X * 1.08e8,
        };
        let extent = ReceiverExtent { max_radius: 1.0, shape: ReceiverShape::Ball, camera_position: None, frustum: None, pixel_width: 0.0 };
        // Number of occluders, if Mercury's radius is multiplied by `radius_ratio`.
        let count = |radius_ratio: f64, min_blocked_fraction: f64| {
            let semi_axes = DVec2::splat(mercury.radii_km.x * radius_ratio / venus.radii_km.x);
            let body = Body { radii_km: mercury.radii_km * radius_ratio, ..mercury.clone() };
            let (long_axis, distance_along) = (DVec2::X, 5e7 / venus.radii_km.x);
            let occluder = Occluder {
                body: &body,
                offset_across: DVec2::ZERO,
                distance_along,
                long_axis,
                semi_axes,
                max_blocked_fraction: 0.0,
                bent_light: BentLight::None,
            };
            let every_shadow_matters = None;
            select_occluders(&[occluder], sun, &receiver, extent, every_shadow_matters, min_blocked_fraction).occluders.len()
        };
        assert_eq!([count(1.0, MIN_BLOCKED_FRACTION_IN_IMAGES), count(5.0, MIN_BLOCKED_FRACTION_IN_IMAGES), count(1.0, 0.0)], [0, 1, 1]);
        assert_eq!(crate::scene::eclipse::max_occluders(catalog.bodies(), venus).0, 0);
        let (min_change, min_blocked_fraction) = (Some(0.01), 0.0);
        let reason = select_occluders(&[], sun, &receiver, extent, min_change, min_blocked_fraction).reason.to_string();
        assert!(reason.contains("1.00e-2"), "the reason names the threshold: {reason}");
    }

    /// Small shadows, with about Rhea's size and distance in radii of Saturn, on a sphere and on ellipsoids as oblate as Saturn and as elongated as Phobos. A
    /// visible shadow is never left out; most of those far on the other side are. If ellipsoids were taken for spheres, some visible shadows would be left out.
    #[test]
    fn a_shadow_on_the_visible_side_is_never_left_out() {
        let catalog = Catalog::embedded();
        let body = catalog.body(NaifId(605)).expect("Rhea");
        let mut random = Random::new(5);
        for axis_ratios in [DVec3::ONE, DVec3::new(1.0, 1.0, 0.902), DVec3::new(1.0, 0.88, 0.7)] {
            let (mut seen, mut left_out_if_sphere, mut hidden, mut left_out) = (0, 0, 0, 0);
            for _ in 0..20_000 {
                let sunward = random.direction();
                let (x, y) = sunward.any_orthonormal_pair();
                let axis = Axis { sunward, perpendicular_axes: [x, y], sun_distance: 2e4, cot_sun_angular_radius: 2e3 };
                let camera = random.direction() * 10.0_f64.powf(random.between(0.2, 4.0));
                let camera_position = Some(camera);
                let extent =
                    ReceiverExtent { max_radius: 1.0, shape: ReceiverShape::Ball, camera_position, frustum: None, pixel_width: 0.0 };
                let on_sphere = random.direction();
                let (point, normal) = (on_sphere * axis_ratios, (on_sphere / axis_ratios).normalize());
                if normal.dot(sunward) < 0.02 {
                    continue;
                }
                let semi_axes = DVec2::splat(0.0126);
                let offset_across = axis.offset_across(point)
                    + DVec2::from_angle(random.between(0.0, std::f64::consts::TAU)) * semi_axes * random.between(0.0, 1.0);
                let occluder = Occluder {
                    body,
                    offset_across,
                    distance_along: 8.7,
                    long_axis: DVec2::X,
                    semi_axes,
                    max_blocked_fraction: 1.0,
                    bent_light: BentLight::None,
                };
                let is_visible = |ratios: DVec3| occluder.shadow_is_visible(&axis, extent, ratios);
                let cos_emission = normal.dot((camera - point).normalize());
                if cos_emission > 0.02 {
                    seen += 1;
                    assert!(is_visible(axis_ratios), "{axis_ratios}: {point} seen from {camera}, lit from {sunward}");
                    left_out_if_sphere += u32::from(!is_visible(DVec3::ONE));
                } else if cos_emission < -0.5 {
                    hidden += 1;
                    left_out += u32::from(!is_visible(axis_ratios));
                }
            }
            assert!(seen > 3000 && 2 * left_out > hidden, "{axis_ratios}: {seen}, {left_out} of {hidden}");
            assert_eq!(left_out_if_sphere > 0, axis_ratios != DVec3::ONE, "{axis_ratios}: {left_out_if_sphere}");
        }
    }
}
