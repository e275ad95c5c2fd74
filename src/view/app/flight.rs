//! A flight of the camera from one view to another: smooth, without overshoot, two seconds long for any distance.
//!
//! In: both ends as poses about the target (ICRF kilometres). Out: the pose at a given time. Always: the logarithm of the distance eases
//! monotonically from one end to the other; the direction from the target to the camera moves along a great circle; in the second half
//! the camera faces the target, or, if the final pose does not face it, turns away from it gradually; the final pose is exactly the given one. The
//! flight does not avoid bodies on the way.

use glam::{DQuat, DVec3};

/// Length of a flight, seconds.
pub(crate) const FLIGHT_S: f64 = 2.0;
/// Fraction of the flight after which the camera faces the target.
const FACING_FROM_FRACTION: f64 = 0.5;

/// For a view from a body's centre, the caller starts or ends the flight or camera path at this distance from the centre, in the body's radii. A view from the
/// centre omits the body, but on the way the body is drawn, and a camera inside it would show nothing.
pub(super) const CENTRE_VIEW_DISTANCE_RADII: f64 = 1.5;

/// Position of the camera relative to the target's centre, and orientation (unit vectors); all ICRF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    pub offset_km: DVec3,
    pub forward: DVec3,
    pub up: DVec3,
}

/// A flight in progress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flight {
    pub start: Pose,
    pub end: Pose,
    /// Real seconds since the start.
    pub elapsed_s: f64,
}

/// Eases a fraction in and out, so that a motion starts and ends at rest and without a jump in acceleration (Perlin's *smootherstep*, 2002).
pub(super) fn ease_in_out(fraction: f64) -> f64 {
    let x = fraction.clamp(0.0, 1.0);
    x * x * x * (x * (6.0 * x - 15.0) + 10.0)
}

/// Spherical interpolation of unit vectors by a fraction of the angle between them; between opposite vectors the great circle is arbitrary.
fn slerp(from: DVec3, to: DVec3, fraction: f64) -> DVec3 {
    DQuat::IDENTITY.slerp(DQuat::from_rotation_arc(from, to), fraction) * from
}

impl Flight {
    pub(crate) fn new(start: Pose, end: Pose) -> Self {
        Self { start, end, elapsed_s: 0.0 }
    }

    /// Advances the flight by real seconds. Returns whether the flight is still in progress.
    pub(crate) fn advance(&mut self, seconds: f64) -> bool {
        self.elapsed_s += seconds.max(0.0);
        self.elapsed_s < FLIGHT_S
    }

    /// The pose after the elapsed time.
    pub(crate) fn pose(&self) -> Pose {
        let fraction = (self.elapsed_s / FLIGHT_S).clamp(0.0, 1.0);
        if fraction >= 1.0 {
            return self.end;
        }
        let eased = ease_in_out(fraction);
        let (start_km, end_km) = (self.start.offset_km, self.end.offset_km);
        // A distance of 0 would have no logarithm.
        let (start_distance_km, end_distance_km) = (start_km.length().max(1e-6), end_km.length().max(1e-6));
        let log_distance = start_distance_km.ln() + (end_distance_km.ln() - start_distance_km.ln()) * eased;
        let direction = slerp(start_km.try_normalize().unwrap_or(DVec3::X), end_km.try_normalize().unwrap_or(DVec3::X), eased);
        // How far the camera has turned from its first direction towards the target, 0 to 1.
        let facing_fraction = ease_in_out(fraction / FACING_FROM_FRACTION);
        // The entire turn is from facing the target to the final direction of the camera; `turn_so_far` is the part that has been made.
        let facing_at_end = (-end_km).try_normalize().unwrap_or(self.end.forward);
        let turn_so_far = DQuat::IDENTITY.slerp(DQuat::from_rotation_arc(facing_at_end, self.end.forward), eased);
        let towards_target = (turn_so_far * -direction).normalize();
        let forward = slerp(self.start.forward, towards_target, facing_fraction);
        let up = self.start.up.lerp(self.end.up, eased);
        let up = (up - forward * up.dot(forward)).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        Pose { offset_km: direction * log_distance.exp(), forward, up }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::angle_rad;

    fn flight() -> Flight {
        let start = Pose { offset_km: DVec3::new(1.3e9, -4e8, 2e7), forward: DVec3::Y, up: DVec3::Z };
        let offset_km = DVec3::new(-2e5, 1e5, 4e4);
        let forward = -offset_km.normalize();
        Flight::new(start, Pose { offset_km, forward, up: forward.any_orthonormal_vector() })
    }

    #[test]
    fn the_flight_starts_and_ends_at_the_given_poses() {
        let mut flight = flight();
        let first = flight.pose();
        assert!((first.offset_km - flight.start.offset_km).length() < 1e-12 * 1.3e9);
        assert!((first.forward - flight.start.forward).length() < 1e-12);
        assert!(!flight.advance(FLIGHT_S));
        assert_eq!(flight.pose(), flight.end);
    }

    #[test]
    fn an_approach_only_shortens_the_distance_and_nothing_jumps() {
        let mut flight = flight();
        let mut last = flight.pose();
        let steps = 400;
        for i in 1..steps {
            flight.elapsed_s = FLIGHT_S * f64::from(i) / f64::from(steps);
            let now = flight.pose();
            assert!(now.offset_km.length() < last.offset_km.length(), "step {i}");
            // The distance falls by a factor of 5990, whose logarithm is 8.7; the easing is at most 1.875 / 400 in a step: a factor of 1.042.
            let ratio = last.offset_km.length() / now.offset_km.length();
            assert!(ratio < 1.06, "step {i}: {ratio}");
            // The camera turns to the target in half of the steps, by at most 1.875 / 200 of pi in one of them, 0.03 rad. The direction to the target turns
            // at the same time, by at most half as much.
            assert!(angle_rad(now.forward, last.forward) < 0.06, "step {i}");
            assert!((now.forward.length() - 1.0).abs() < 1e-9 && now.up.dot(now.forward).abs() < 1e-9);
            last = now;
        }
        assert!(last.offset_km.length() / flight.end.offset_km.length() < 1.001);
    }

    /// In the second half of the flight the target is in front of the camera.
    #[test]
    fn the_target_is_in_view_from_halfway() {
        let mut flight = flight();
        for fraction in [0.5, 0.7, 0.9] {
            flight.elapsed_s = fraction * FLIGHT_S;
            let pose = flight.pose();
            assert!(angle_rad(pose.forward, -pose.offset_km) < 0.02, "{fraction}");
        }
    }

    #[test]
    fn a_flight_to_the_current_pose_stays_finite() {
        let pose = flight().end;
        for end in [pose, Pose { offset_km: -pose.offset_km, forward: -pose.forward, up: pose.up }] {
            let mut flight = Flight::new(pose, end);
            flight.elapsed_s = 0.31;
            let now = flight.pose();
            assert!(now.offset_km.is_finite() && now.forward.is_finite() && now.up.is_finite());
        }
    }
}
