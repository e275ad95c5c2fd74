//! The shadow cones of an occluder, and the edges of its shadow on the receiver's ground.
//!
//! In: the axis from the receiver to the Sun and the occluder's outline projected along it, as in the shader (shaders/lib/eclipse/occluders.wesl). Out:
//! generators of the cones (the straight lines of which a cone consists), and the edges of umbra and penumbra on the ground, as points of the unit sphere.
//! Always: positions are in the receiver's body axes and equatorial radii; the cones touch the Sun's sphere and the occluder's outline, so that the shader's
//! fraction of sunlight is 1 outside the penumbra and 0 in the umbra of an opaque occluder. Not modelled: light refracted by the occluder's air, and
//! self-intersections of the umbra of an elongated body.

use crate::scene::eclipse::occluders::{Axis, Occluder, Receiver, outline};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Which cone: the penumbra's apex lies between Sun and occluder, the umbra's apex behind the occluder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ConeKind {
    /// Umbra, and beyond its apex the antumbra.
    Umbra,
    Penumbra,
}

/// A polyline on the ground: body axes, each coordinate divided by its semi-axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GroundLine {
    pub points: Vec<DVec3>,
    /// Whether the last point connects to the first.
    pub is_closed: bool,
}

/// The shadow of one occluder: the cone of its umbra and that of its penumbra.
#[derive(Clone, Debug)]
pub(crate) struct ShadowCone {
    axis: Axis,
    /// The occluder's centre: components perpendicular to the axis and along it.
    offset_across: DVec2,
    distance_along: f64,
    /// Unit vector along the major axis of the occluder's outline, and the outline's semi-axes.
    long_axis: DVec2,
    semi_axes: DVec2,
    /// Semi-axes of the receiver divided by its equatorial radius.
    axis_ratios: DVec3,
}

/// A generator of a cone, or the cone's axis: body axes, equatorial radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConeLine {
    /// The point on the occluder's outline, or its centre.
    pub origin: DVec3,
    /// Unit vector, away from the Sun.
    pub direction: DVec3,
}

/// Number of generators in the search for the ends of a shadow's edge.
const SEARCH_GENERATORS: u32 = 720;
/// Number of intervals between the points of an edge.
const EDGE_INTERVALS: u32 = 360;

/// The point of a line nearest to the centre of the unit sphere, and the square of half the line's chord in the sphere: positive where the line meets the
/// sphere, negative where it misses. `direction`: unit vector.
pub(crate) fn nearest_point_and_half_chord_sq(point: DVec3, direction: DVec3) -> (DVec3, f64) {
    let foot = point - direction * point.dot(direction);
    (foot, 1.0 - foot.length_squared())
}

impl ShadowCone {
    pub(crate) fn of(axis: Axis, occluder: &Occluder<'_>, receiver: &Receiver<'_>) -> Self {
        let Occluder { offset_across, distance_along, long_axis, semi_axes, .. } = *occluder;
        Self { axis, offset_across, distance_along, long_axis, semi_axes, axis_ratios: receiver.body.radii_km / receiver.radius_km() }
    }

    /// The shadow that the receiver itself casts behind it.
    pub(crate) fn own_shadow(axis: Axis, receiver: &Receiver<'_>) -> Self {
        let axis_ratios = receiver.body.radii_km / receiver.radius_km();
        let (long_axis, semi_axes) = outline(&axis, DMat3::IDENTITY, axis_ratios);
        Self { axis, offset_across: DVec2::ZERO, distance_along: 0.0, long_axis, semi_axes, axis_ratios }
    }

    /// The vector with these components perpendicular to the axis and along it.
    fn in_body_axes(&self, offset_across: DVec2, distance_along: f64) -> DVec3 {
        self.axis.perpendicular_axes[0] * offset_across.x
            + self.axis.perpendicular_axes[1] * offset_across.y
            + self.axis.sunward * distance_along
    }

    /// The generator that touches the occluder's outline at `angle`: the ellipse's eccentric angle, radians, from the direction of the receiver's north.
    pub(crate) fn generator_at(&self, kind: ConeKind, angle: f64) -> ConeLine {
        let north = self.axis.offset_across(DVec3::Z).try_normalize().unwrap_or(DVec2::X);
        let (sin, cos) = (angle + self.long_axis.angle_to(north)).sin_cos();
        let from_outline_axes = |v: DVec2| self.long_axis * v.x + self.long_axis.perp() * v.y;
        let outline_point = self.offset_across + from_outline_axes(self.semi_axes * DVec2::new(cos, sin));
        let outwards = from_outline_axes(DVec2::new(self.semi_axes.y * cos, self.semi_axes.x * sin)).normalize_or_zero();
        let sun_radius = self.axis.sun_distance / self.axis.cot_sun_angular_radius;
        let on_sun = match kind {
            ConeKind::Umbra => outwards * sun_radius,
            ConeKind::Penumbra => outwards * -sun_radius,
        };
        let origin = self.in_body_axes(outline_point, self.distance_along);
        ConeLine { origin, direction: (origin - self.in_body_axes(on_sun, self.axis.sun_distance)).normalize() }
    }

    /// The line through the centres of the Sun and the occluder.
    pub(crate) fn axis_line(&self) -> ConeLine {
        let origin = self.in_body_axes(self.offset_across, self.distance_along);
        ConeLine { origin, direction: (origin - self.axis.sunward * self.axis.sun_distance).normalize() }
    }

    /// Distance from the occluder to the umbra's apex, for a round occluder of the outline's mean radius; infinite if it has no apex.
    pub(crate) fn umbra_length(&self) -> f64 {
        let (radius, sun_radius) = (0.5 * (self.semi_axes.x + self.semi_axes.y), self.axis.sun_distance / self.axis.cot_sun_angular_radius);
        if sun_radius > radius { radius * (self.axis.sun_distance - self.distance_along) / (sun_radius - radius) } else { f64::INFINITY }
    }

    /// Radius of a cone where it passes the receiver's centre, along the major axis of the occluder's outline.
    pub(crate) fn radius(&self, kind: ConeKind) -> f64 {
        let half_penumbra_width = self.distance_along / self.axis.cot_sun_angular_radius;
        match kind {
            ConeKind::Penumbra => self.semi_axes.x + half_penumbra_width,
            ConeKind::Umbra => (self.semi_axes.x - half_penumbra_width).abs(),
        }
    }

    /// Whether the receiver's centre is farther from the occluder than the umbra's apex.
    pub(crate) fn is_antumbra(&self) -> bool {
        self.umbra_length() < self.distance_along
    }

    /// Square of half the line's chord in the unit sphere: positive where the line meets the ground, negative where it misses.
    pub(crate) fn half_chord_sq(&self, line: ConeLine) -> f64 {
        let (point, direction) = self.in_unit_sphere(line);
        let (_nearest_point, half_chord_sq) = nearest_point_and_half_chord_sq(point, direction);
        half_chord_sq
    }

    /// Where the line first meets the ground behind the occluder, on the unit sphere; `None` if it misses.
    pub(crate) fn ground_point(&self, line: ConeLine) -> Option<DVec3> {
        let (point, direction) = self.in_unit_sphere(line);
        let (foot, half_chord_sq) = nearest_point_and_half_chord_sq(point, direction);
        let entry = foot - direction * half_chord_sq.max(0.0).sqrt();
        (half_chord_sq >= 0.0 && (entry - point).dot(direction) > 0.0).then(|| entry.normalize())
    }

    /// Point and unit direction of a line in the frame in which the receiver is the unit sphere.
    fn in_unit_sphere(&self, line: ConeLine) -> (DVec3, DVec3) {
        (line.origin / self.axis_ratios, (line.direction / self.axis_ratios).normalize())
    }

    /// The shadow's edge on the ground, where a cone meets it: one closed line, or arcs that end where generators graze the ground.
    pub(crate) fn edge_on_ground(&self, kind: ConeKind) -> Vec<GroundLine> {
        let step = TAU / f64::from(SEARCH_GENERATORS);
        let half_chord_sq = |angle: f64| self.half_chord_sq(self.generator_at(kind, angle));
        let meets_ground = |k: u32| half_chord_sq(step * f64::from(k)) > 0.0;
        let Some(first_miss) = (0..SEARCH_GENERATORS).find(|k| !meets_ground(*k)) else {
            let at = |k: u32| self.ground_point(self.generator_at(kind, TAU * f64::from(k) / f64::from(EDGE_INTERVALS)));
            let points: Vec<DVec3> = (0..EDGE_INTERVALS).filter_map(at).collect();
            return if points.len() == EDGE_INTERVALS as usize { vec![GroundLine { points, is_closed: true }] } else { Vec::new() };
        };
        // Bisects for the angle at which the generator grazes the ground, between one that meets the ground and one that misses.
        let grazing_angle = |mut inside: f64, mut outside: f64| {
            for _ in 0..50 {
                let middle = 0.5 * (inside + outside);
                if half_chord_sq(middle) > 0.0 { inside = middle } else { outside = middle }
            }
            inside
        };
        let mut lines = Vec::new();
        let mut begin_angle = None;
        for k in first_miss..first_miss + SEARCH_GENERATORS {
            let (angle, next_angle) = (step * f64::from(k), step * f64::from(k + 1));
            match (begin_angle, meets_ground(k % SEARCH_GENERATORS), meets_ground((k + 1) % SEARCH_GENERATORS)) {
                (None, false, true) => begin_angle = Some(grazing_angle(next_angle, angle)),
                (Some(from), true, false) => {
                    lines.extend(self.arc(kind, from, grazing_angle(angle, next_angle)));
                    begin_angle = None;
                }
                _ => {}
            }
        }
        lines
    }

    /// The part of the edge between two angles, radians. The points are denser in angle at the ends: there the generators graze the ground, and a small change
    /// of the angle moves the point far along the ground.
    fn arc(&self, kind: ConeKind, from: f64, to: f64) -> Option<GroundLine> {
        let at = |k: u32| {
            let fraction = 0.5 * (1.0 - (PI * f64::from(k) / f64::from(EDGE_INTERVALS)).cos());
            self.ground_point(self.generator_at(kind, from + (to - from) * fraction))
        };
        let points: Vec<DVec3> = (0..=EDGE_INTERVALS).filter_map(at).collect();
        (points.len() > 3).then_some(GroundLine { points, is_closed: false })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use crate::ephemeris::Ephemeris;
    use crate::scene::eclipse::occluders::{MIN_BLOCKED_FRACTION_IN_IMAGES, candidates};
    use crate::time::Instant;

    /// Calls `check` with a shadow cone and the Sun's radius in the receiver's radii.
    fn with_cone(receiver: i32, occluder: i32, time: &str, check: impl FnOnce(&ShadowCone, f64)) {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let body = |id| catalog.body(NaifId(id)).expect("in the catalog");
        let receiver = Receiver::at(&ephemeris, body(receiver), Instant::parse(time).expect("a time")).expect("placed");
        let sun = body(10);
        let axis = Axis::of(&receiver, sun).expect("lit");
        let found = candidates(&ephemeris, catalog.bodies().iter(), sun, &receiver, MIN_BLOCKED_FRACTION_IN_IMAGES);
        let occluder = found.iter().find(|o| o.body.id == NaifId(occluder)).expect("in front of the Sun");
        check(&ShadowCone::of(axis, occluder, &receiver), sun.radii_km.x / receiver.radius_km());
    }

    /// The generators touch the Sun's sphere, and pass the occluder's centre at a distance between its outline's semi-axes.
    #[test]
    fn generators_touch_both_bodies() {
        for (receiver, occluder, time) in
            [(399, 301, "2024-04-08T18:17:16Z"), (599, 501, "2024-12-07T20:00:00Z"), (301, 399, "2025-03-14T07:00:00Z")]
        {
            with_cone(receiver, occluder, time, |cone, sun_radius| {
                let sun = cone.axis.sunward * cone.axis.sun_distance;
                let distance = |line: ConeLine, point: DVec3| (point - line.origin).cross(line.direction).length();
                for kind in [ConeKind::Umbra, ConeKind::Penumbra] {
                    for k in 0..24 {
                        let line = cone.generator_at(kind, TAU * f64::from(k) / 24.0);
                        assert!((distance(line, sun) / sun_radius - 1.0).abs() < 1e-4, "{receiver} {kind:?} {k}");
                        let from_occluder = distance(line, cone.in_body_axes(cone.offset_across, cone.distance_along));
                        let semi_axes = cone.semi_axes.y * 0.9999..=cone.semi_axes.x * 1.0001;
                        assert!(semi_axes.contains(&from_occluder), "{receiver} {kind:?} {k}: {from_occluder}");
                        // The sign tells which limb of the Sun the line touches.
                        let outwards = line.origin - cone.in_body_axes(cone.offset_across, cone.distance_along);
                        assert_eq!(line.direction.dot(outwards) > 0.0, kind == ConeKind::Penumbra, "{receiver} {kind:?} {k}");
                    }
                }
            });
        }
    }

    /// An umbra and a penumbra that lie on the disc seen from the Sun have one closed edge each; a penumbra that crosses the limb has an open edge whose ends
    /// graze the ground; before first contact there are no edges.
    #[test]
    fn edges_close_or_end_at_the_limb() {
        with_cone(399, 301, "2024-04-08T18:17:16Z", |cone, _| {
            let umbra = cone.edge_on_ground(ConeKind::Umbra);
            assert!(umbra.len() == 1 && umbra[0].is_closed, "{umbra:?}");
            // The shadow's axis passes the Earth's centre at 0.343 radii (gamma), and the penumbra's radius is 0.536: all of the penumbra is on the disc.
            let penumbra = cone.edge_on_ground(ConeKind::Penumbra);
            assert!(penumbra.len() == 1 && penumbra[0].is_closed, "{}", penumbra.len());
        });
        with_cone(399, 301, "2024-04-08T16:50:00Z", |cone, _| {
            let penumbra = cone.edge_on_ground(ConeKind::Penumbra);
            assert!(!penumbra.is_empty() && penumbra.iter().all(|line| !line.is_closed), "{}", penumbra.len());
            for end in penumbra.iter().flat_map(|line| [line.points[0], line.points[line.points.len() - 1]]) {
                // There the Sun is on the horizon, to within its angular radius of a quarter of a degree.
                let normal = (end / cone.axis_ratios).normalize();
                assert!(normal.dot(cone.axis.sunward).abs() < 0.006, "{}", normal.dot(cone.axis.sunward));
            }
        });
        with_cone(399, 301, "2024-04-08T14:00:00Z", |cone, _| {
            assert!(cone.edge_on_ground(ConeKind::Umbra).is_empty() && cone.edge_on_ground(ConeKind::Penumbra).is_empty());
        });
    }
}
