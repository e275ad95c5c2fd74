//! The cones of shadow of a body before the Sun, and where they meet the ground of the body that is lit.
//!
//! In: the axis from the lit body to the Sun and the occluder's outline about it, as the shader has them (shaders/lib/eclipse/occluders.wesl). Out: sides of the cones,
//! and the outlines of umbra and penumbra on the ground, as points of the unit sphere. Always: lengths are the lit body's equatorial radii in its axes; the cones touch the
//! Sun's sphere and the occluder's outline, so that the shader's light is 1 outside of the penumbra and 0 in the umbra of an opaque occluder. Left out: the refracted light of its air,
//! and the folds that the umbra of a long body has where its sides cross.

use crate::scene::eclipse::occluders::{Axis, Occluder, Receiver, outline};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Which cone: the sides of one cross between the bodies, of the other behind the occluder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Edge {
    /// Umbra, and behind its apex the antumbra.
    Umbra,
    Penumbra,
}

/// A line of points on the ground: body axes, each divided by its semi-axis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GroundLine {
    pub points: Vec<DVec3>,
    /// Whether the first point follows the last.
    pub is_closed: bool,
}

/// Umbra and penumbra of one occluder.
#[derive(Clone, Debug)]
pub(crate) struct ShadowCone {
    axis: Axis,
    /// Of the occluder's middle, across the axis and along it.
    across: DVec2,
    along: f64,
    long_axis: DVec2,
    semi: DVec2,
    /// Semi-axes of the lit body over its equatorial radius.
    ground: DVec3,
}

/// A straight line of light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// Where it touches the occluder.
    pub from: DVec3,
    /// Unit vector, away from the Sun.
    pub along: DVec3,
}

/// Sides of a cone that are asked for where it begins and ceases to meet the ground.
const SIDES: u32 = 720;
/// Points of an outline.
const POINTS: u32 = 360;

/// Where a line comes nearest to the centre of the unit sphere, and by how much it passes under the sphere there: 1 less the square of that distance, negative where it misses. `along`: unit vector.
pub(crate) fn under_unit_sphere(point: DVec3, along: DVec3) -> (DVec3, f64) {
    let foot = point - along * point.dot(along);
    (foot, 1.0 - foot.length_squared())
}

impl ShadowCone {
    pub(crate) fn of(axis: Axis, occluder: &Occluder<'_>, receiver: &Receiver<'_>) -> Self {
        let Occluder { across, along, long_axis, semi, .. } = *occluder;
        Self { axis, across, along, long_axis, semi, ground: receiver.body.radii_km / receiver.radius_km() }
    }

    /// Of the lit body itself: the shadow behind it.
    pub(crate) fn behind(axis: Axis, receiver: &Receiver<'_>) -> Self {
        let ground = receiver.body.radii_km / receiver.radius_km();
        let (long_axis, semi) = outline(&axis, DMat3::IDENTITY, ground);
        Self { axis, across: DVec2::ZERO, along: 0.0, long_axis, semi, ground }
    }

    fn in_space(&self, across: DVec2, along: f64) -> DVec3 {
        self.axis.across[0] * across.x + self.axis.across[1] * across.y + self.axis.along * along
    }

    /// The side that touches the outline at an angle about the axis, counted from the north of the lit body.
    pub(crate) fn side(&self, edge: Edge, angle: f64) -> Side {
        let north = self.axis.across(DVec3::Z).try_normalize().unwrap_or(DVec2::X);
        let (sin, cos) = (angle + self.long_axis.angle_to(north)).sin_cos();
        let turned = |v: DVec2| self.long_axis * v.x + self.long_axis.perp() * v.y;
        let rim = self.across + turned(self.semi * DVec2::new(cos, sin));
        let outwards = turned(DVec2::new(self.semi.y * cos, self.semi.x * sin)).normalize_or_zero();
        let sun_radius = self.axis.sun_distance / self.axis.cot;
        let of_sun = match edge {
            Edge::Umbra => outwards * sun_radius,
            Edge::Penumbra => outwards * -sun_radius,
        };
        let from = self.in_space(rim, self.along);
        Side { from, along: (from - self.in_space(of_sun, self.axis.sun_distance)).normalize() }
    }

    /// The line through the middles of the Sun and the occluder.
    pub(crate) fn middle(&self) -> Side {
        let from = self.in_space(self.across, self.along);
        Side { from, along: (from - self.axis.along * self.axis.sun_distance).normalize() }
    }

    /// Length from the occluder to the umbra's apex, of an occluder as round as its outline's mean; infinite where it has none.
    pub(crate) fn umbra_length(&self) -> f64 {
        let (radius, sun_radius) = (0.5 * (self.semi.x + self.semi.y), self.axis.sun_distance / self.axis.cot);
        if sun_radius > radius { radius * (self.axis.sun_distance - self.along) / (sun_radius - radius) } else { f64::INFINITY }
    }

    /// Half width of a cone where it passes the lit body's middle.
    pub(crate) fn radius(&self, edge: Edge) -> f64 {
        let widening = self.along / self.axis.cot;
        if edge == Edge::Penumbra { self.semi.x + widening } else { (self.semi.x - widening).abs() }
    }

    /// Whether the lit body's middle is behind the umbra's apex.
    pub(crate) fn is_antumbra(&self) -> bool {
        self.umbra_length() < self.along
    }

    /// By how much a side passes under the ground: 1 minus the square of its least distance from the centre of the unit sphere; negative where it misses.
    pub(crate) fn depth(&self, side: Side) -> f64 {
        let (point, along) = self.in_unit_sphere(side);
        under_unit_sphere(point, along).1
    }

    /// Where a side first meets the ground, on the unit sphere; `None` where it misses.
    pub(crate) fn meets(&self, side: Side) -> Option<DVec3> {
        let (point, along) = self.in_unit_sphere(side);
        let (foot, half_squared) = under_unit_sphere(point, along);
        let at = foot - along * half_squared.max(0.0).sqrt();
        (half_squared >= 0.0 && (at - point).dot(along) > 0.0).then(|| at.normalize())
    }

    fn in_unit_sphere(&self, side: Side) -> (DVec3, DVec3) {
        (side.from / self.ground, (side.along / self.ground).normalize())
    }

    /// Where a cone meets the ground: one closed line, or pieces that end where its sides graze the ground.
    pub(crate) fn outline(&self, edge: Edge) -> Vec<GroundLine> {
        let step = TAU / f64::from(SIDES);
        let depth = |angle: f64| self.depth(self.side(edge, angle));
        let meets = |k: u32| depth(step * f64::from(k)) > 0.0;
        let Some(first_miss) = (0..SIDES).find(|k| !meets(*k)) else {
            let at = |k: u32| self.meets(self.side(edge, TAU * f64::from(k) / f64::from(POINTS)));
            let points: Vec<DVec3> = (0..POINTS).filter_map(at).collect();
            return if points.len() == POINTS as usize { vec![GroundLine { points, is_closed: true }] } else { Vec::new() };
        };
        // The angle between two at which a side grazes; the first of them meets.
        let graze = |mut inside: f64, mut outside: f64| {
            for _ in 0..50 {
                let middle = 0.5 * (inside + outside);
                if depth(middle) > 0.0 { inside = middle } else { outside = middle }
            }
            inside
        };
        let mut lines = Vec::new();
        let mut begins = None;
        for k in first_miss..first_miss + SIDES {
            let (now, next) = (step * f64::from(k), step * f64::from(k + 1));
            match (begins, meets(k % SIDES), meets((k + 1) % SIDES)) {
                (None, false, true) => begins = Some(graze(next, now)),
                (Some(from), true, false) => {
                    lines.extend(self.arc(edge, from, graze(now, next)));
                    begins = None;
                }
                _ => {}
            }
        }
        lines
    }

    /// A piece of an outline. A side that grazes moves fast along the ground: points are closer at the ends.
    fn arc(&self, edge: Edge, from: f64, to: f64) -> Option<GroundLine> {
        let at = |k: u32| {
            let part = 0.5 * (1.0 - (PI * f64::from(k) / f64::from(POINTS)).cos());
            self.meets(self.side(edge, from + (to - from) * part))
        };
        let points: Vec<DVec3> = (0..=POINTS).filter_map(at).collect();
        (points.len() > 3).then_some(GroundLine { points, is_closed: false })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use crate::ephemeris::Ephemeris;
    use crate::scene::eclipse::occluders::candidates;
    use crate::time::Instant;

    fn with_cone(receiver: i32, occluder: i32, time: &str, check: impl FnOnce(&ShadowCone, f64)) {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let body = |id| catalog.body(NaifId(id)).expect("in the catalog");
        let receiver = Receiver::at(&ephemeris, body(receiver), Instant::parse(time).expect("a time")).expect("placed");
        let sun = body(10);
        let axis = Axis::of(&receiver, sun).expect("lit");
        let found = candidates(&ephemeris, catalog.bodies().iter(), sun, &receiver);
        let occluder = found.iter().find(|o| o.body.id == NaifId(occluder)).expect("before the Sun");
        check(&ShadowCone::of(axis, occluder, &receiver), sun.radii_km.x / receiver.radius_km());
    }

    /// The sides touch the Sun's sphere and the occluder's, found by distances of lines from points and not by the formula of the sides.
    #[test]
    fn sides_touch_both_bodies() {
        for (receiver, occluder, time) in
            [(399, 301, "2024-04-08T18:17:16Z"), (599, 501, "2024-12-07T20:00:00Z"), (301, 399, "2025-03-14T07:00:00Z")]
        {
            with_cone(receiver, occluder, time, |cone, sun_radius| {
                let sun = cone.axis.along * cone.axis.sun_distance;
                let distance = |side: Side, point: DVec3| (point - side.from).cross(side.along).length();
                for edge in [Edge::Umbra, Edge::Penumbra] {
                    for k in 0..24 {
                        let side = cone.side(edge, TAU * f64::from(k) / 24.0);
                        assert!((distance(side, sun) / sun_radius - 1.0).abs() < 1e-4, "{receiver} {edge:?} {k}");
                        let off = distance(side, cone.in_space(cone.across, cone.along));
                        assert!((cone.semi.y * 0.9999..=cone.semi.x * 1.0001).contains(&off), "{receiver} {edge:?} {k}: {off}");
                        // The other limb of the Sun: a line through the same point that touches it too would have the other sign.
                        let outwards = side.from - cone.in_space(cone.across, cone.along);
                        assert_eq!(side.along.dot(outwards) > 0.0, edge == Edge::Penumbra, "{receiver} {edge:?} {k}");
                    }
                }
            });
        }
    }

    /// An umbra within the disc is one closed line, the penumbra beside the limb an open one whose ends graze.
    #[test]
    fn outlines_close_or_end_at_the_limb() {
        with_cone(399, 301, "2024-04-08T18:17:16Z", |cone, _| {
            let umbra = cone.outline(Edge::Umbra);
            assert!(umbra.len() == 1 && umbra[0].is_closed, "{umbra:?}");
            // Gamma 0.343 and the penumbra's 0.536 of the Earth's radius are less than 1: all of it is on the disc.
            let penumbra = cone.outline(Edge::Penumbra);
            assert!(penumbra.len() == 1 && penumbra[0].is_closed, "{}", penumbra.len());
        });
        with_cone(399, 301, "2024-04-08T16:50:00Z", |cone, _| {
            let penumbra = cone.outline(Edge::Penumbra);
            assert!(!penumbra.is_empty() && penumbra.iter().all(|line| !line.is_closed), "{}", penumbra.len());
            for end in penumbra.iter().flat_map(|line| [line.points[0], line.points[line.points.len() - 1]]) {
                // The Sun is in the horizon there, to its radius of a quarter of a degree.
                let normal = (end / cone.ground).normalize();
                assert!(normal.dot(cone.axis.along).abs() < 0.006, "{}", normal.dot(cone.axis.along));
            }
        });
        with_cone(399, 301, "2024-04-08T14:00:00Z", |cone, _| {
            assert!(cone.outline(Edge::Umbra).is_empty() && cone.outline(Edge::Penumbra).is_empty());
        });
    }
}
