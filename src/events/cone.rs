//! The intersection of a shadow cone with the Earth's spheroid.
//!
//! In: centres of the Sun and the Moon relative to the Earth's, GCRS, km. Out: the gap between a cone and the spheroid, and where the cone's axis meets the
//! ground or is nearest to it. Consider the planes that touch the cone along a generator (one of its straight lines). Such a plane has the cone on one side.
//! The gap is the greatest distance of the whole spheroid from a plane on its other side. It is negative if no plane separates the two, that is, if cone and
//! spheroid overlap. It is exact where they are apart or graze each other, hence at the contacts of an eclipse. Only the planes on the side of the cone that
//! faces the Earth's centre are searched. Where the axis passes near the centre, a plane on another side may give a gap that is greater by up to 21 km, the
//! difference of the spheroid's radii; the sign of the computed gap is still right.

use super::numeric::minimum;
use crate::scene::eclipse::shadow_cone::nearest_point_and_half_chord_sq;
use glam::DVec3;

/// The Earth's spheroid, centred at the origin of the GCRS.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spheroid {
    /// Equatorial radius.
    pub equatorial_km: f64,
    /// Polar radius.
    pub polar_km: f64,
    /// Unit vector to the north pole.
    pub pole: DVec3,
}

impl Spheroid {
    /// `v` with its component perpendicular to the pole multiplied by `perpendicular_factor` and the one along the pole by `pole_factor`.
    fn scaled(&self, v: DVec3, perpendicular_factor: f64, pole_factor: f64) -> DVec3 {
        v * perpendicular_factor + self.pole * (v.dot(self.pole) * (pole_factor - perpendicular_factor))
    }

    /// The support function: for a unit vector, the distance from the centre to the tangent plane with this normal. It is proportional to the vector's length.
    fn support_km(&self, direction: DVec3) -> f64 {
        self.scaled(direction, self.equatorial_km, self.polar_km).length()
    }

    /// The point of the surface that lies farthest along a direction, which may have any length.
    pub(crate) fn support_point_km(&self, direction: DVec3) -> DVec3 {
        self.scaled(direction, self.equatorial_km.powi(2), self.polar_km.powi(2)) / self.support_km(direction)
    }

    /// Square of half the chord of the line through `point_km` along the unit vector `direction`, in the frame in which the spheroid is the unit sphere;
    /// negative if the line misses.
    pub(crate) fn half_chord_sq(&self, point_km: DVec3, direction: DVec3) -> f64 {
        let (p, d) = self.in_unit_sphere_frame(point_km, direction);
        let (_nearest_point, half_chord_sq) = nearest_point_and_half_chord_sq(p, d);
        half_chord_sq
    }

    /// Where the line through `point_km` along `direction`, the unit vector to the Sun, meets the surface: of the two points the one nearer to the Sun;
    /// `None` if the line misses.
    pub(crate) fn sunlit_intersection_km(&self, point_km: DVec3, direction: DVec3) -> Option<DVec3> {
        let (p, d) = self.in_unit_sphere_frame(point_km, direction);
        let (nearest_point, half_chord_sq) = nearest_point_and_half_chord_sq(p, d);
        (half_chord_sq >= 0.0).then(|| self.scaled(nearest_point + d * half_chord_sq.sqrt(), self.equatorial_km, self.polar_km))
    }

    /// A line, given by a point and a direction, in the frame in which the spheroid is the unit sphere. The returned direction is a unit vector.
    fn in_unit_sphere_frame(&self, point_km: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        let scaled = |v| self.scaled(v, 1.0 / self.equatorial_km, 1.0 / self.polar_km);
        (scaled(point_km), scaled(direction).normalize())
    }
}

/// One nappe of a cone: the part on one side of its apex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    apex_km: DVec3,
    /// Unit vector from the apex into the cone.
    axis_direction: DVec3,
    /// Sine of the angle between the axis and a generator.
    sin_half_angle: f64,
}

impl Cone {
    /// The cone of the penumbra, which encloses the umbra. Its generators touch Sun and Moon on opposite sides, so the apex lies between the two.
    pub(crate) fn penumbra(sun_km: DVec3, moon_km: DVec3, sun_radius_km: f64, moon_radius_km: f64) -> Self {
        let (to_sun, distance_km) = moon_to_sun(sun_km, moon_km);
        let sin_half_angle = (sun_radius_km + moon_radius_km) / distance_km;
        Self { apex_km: moon_km + to_sun * (moon_radius_km / sin_half_angle), axis_direction: -to_sun, sin_half_angle }
    }

    /// The umbra if the apex lies behind the Earth's centre, as seen from the Sun; otherwise the antumbra. The umbra is the nappe that opens towards the Sun,
    /// the antumbra the other one. The generators touch Sun and Moon on the same side, so the apex lies behind the Moon.
    pub(crate) fn umbra_or_antumbra(sun_km: DVec3, moon_km: DVec3, sun_radius_km: f64, moon_radius_km: f64) -> Self {
        let (to_sun, distance_km) = moon_to_sun(sun_km, moon_km);
        let sin_half_angle = (sun_radius_km - moon_radius_km) / distance_km;
        let apex_km = moon_km - to_sun * (moon_radius_km / sin_half_angle);
        let apex_is_behind_earth = apex_km.dot(to_sun) < 0.0;
        Self { apex_km, axis_direction: if apex_is_behind_earth { to_sun } else { -to_sun }, sin_half_angle }
    }

    /// The axis of the shadow as a cone with half angle 0.
    pub(crate) fn axis(sun_km: DVec3, moon_km: DVec3) -> Self {
        Self { apex_km: moon_km, axis_direction: -moon_to_sun(sun_km, moon_km).0, sin_half_angle: 0.0 }
    }

    /// Gap between cone and spheroid, km, negative if they overlap; and the unit normal of the tangent plane at the nearest generator, towards the spheroid.
    pub(crate) fn gap_km(&self, earth: &Spheroid) -> (f64, DVec3) {
        let apex_to_centre = -self.apex_km;
        let axis_to_centre = apex_to_centre - self.axis_direction * apex_to_centre.dot(self.axis_direction);
        let towards_centre = axis_to_centre.try_normalize().unwrap_or_else(|| self.axis_direction.any_orthonormal_vector());
        let sideways = self.axis_direction.cross(towards_centre);
        let cos_half_angle = (1.0 - self.sin_half_angle * self.sin_half_angle).sqrt();
        // Outward normal of the plane tangent to the cone; `angle` is counted around the axis from the side that faces the Earth's centre.
        let normal = |angle: f64| {
            (towards_centre * angle.cos() + sideways * angle.sin()) * cos_half_angle - self.axis_direction * self.sin_half_angle
        };
        let gap = |n: DVec3| apex_to_centre.dot(n) - earth.support_km(n);
        // Where the cone grazes the Earth, the flattening (1/298) rotates the nearest generator by at most about 1/298 radian; the search allows 0.05.
        let (max_angle_rad, tolerance_rad) = (0.05, 1e-7);
        let nearest_normal = normal(minimum(-max_angle_rad, max_angle_rad, tolerance_rad, |angle| -gap(normal(angle))));
        (gap(nearest_normal), nearest_normal)
    }
}

/// Unit vector from the Moon to the Sun, and their distance.
pub(super) fn moon_to_sun(sun_km: DVec3, moon_km: DVec3) -> (DVec3, f64) {
    let to_sun = sun_km - moon_km;
    let distance_km = to_sun.length();
    (to_sun / distance_km, distance_km)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Spheroid = Spheroid { equatorial_km: 6378.0, polar_km: 6357.0, pole: DVec3::Z };

    #[test]
    fn gaps_over_pole_and_equator_agree_with_plane_geometry() {
        let sun = DVec3::X * 1.5e8;
        for (perpendicular, support_km) in [(DVec3::Y, 6378.0), (DVec3::Z, 6357.0), (DVec3::NEG_Z, 6357.0)] {
            let moon = DVec3::X * 4e5 + perpendicular * 7000.0;
            let (to_sun, _) = moon_to_sun(sun, moon);
            // The distance of the Earth's centre from the nearest generator: that from the apex, times the sine of the angle between the two directions.
            let cone = Cone::penumbra(sun, moon, 696_000.0, 1737.0);
            let angle_at_apex = crate::ephemeris::angle_rad(-cone.apex_km, cone.axis_direction);
            let expected = cone.apex_km.length() * (angle_at_apex - cone.sin_half_angle.asin()).sin() - support_km;
            // The tangent plane is inclined to the axis by the half angle, 0.005 radian; this changes the support by less than 1 m.
            let (gap, normal) = cone.gap_km(&EARTH);
            assert!((gap - expected).abs() < 0.05, "{perpendicular}: {gap} for {expected}");
            assert!(normal.dot(-perpendicular) > 0.999);
            // The axis itself, 7000 km from the centre, misses the Earth.
            let (gap, _) = Cone::axis(sun, moon).gap_km(&EARTH);
            assert!(gap > 0.0 && EARTH.half_chord_sq(moon, to_sun) < 0.0 && EARTH.sunlit_intersection_km(moon, to_sun).is_none());
        }
    }

    #[test]
    fn a_line_meets_the_ground_on_the_sunlit_side() {
        let point_km = EARTH.sunlit_intersection_km(DVec3::new(4e5, 3000.0, 2000.0), DVec3::X).expect("it meets");
        assert!((point_km.y - 3000.0).abs() < 1e-9 && (point_km.z - 2000.0).abs() < 1e-9 && point_km.x > 0.0);
        assert!(
            ((point_km.x * point_km.x + point_km.y * point_km.y) / 6378.0_f64.powi(2) + point_km.z * point_km.z / 6357.0_f64.powi(2) - 1.0)
                .abs()
                < 1e-12
        );
        assert!((EARTH.support_point_km(DVec3::Z) - DVec3::Z * 6357.0).length() < 1e-9);
    }
}
