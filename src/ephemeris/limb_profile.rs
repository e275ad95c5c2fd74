//! The Moon's limb profile from a height map, as seen from a place anywhere outside the Moon.
//!
//! In: a height map and the place in the Moon's axes. Out: [`LimbProfile`], the height of the silhouette over the map's sphere at each position angle.
//! All ground near the limb is searched, on both sides of the limb of a sphere: the ground that appears highest defines the profile. Libration is contained in
//! the direction to the place. Always: a height is the distance of the grazing view ray from the Moon's centre, minus the sphere's radius, so that it
//! hardly depends on the viewer's distance.
//!
//! The ground is sampled along the line of sight, at sample steps of half the map's spacing. Then its highest point, the *summit*, is searched between the
//! neighbours of the highest sample. A summit between other samples can be missed, but only if it is higher by less than the ground rises over half a sample
//! step. Positions are relative to the Moon's centre of mass, the origin of the map. The Moon's orientation is accurate to 0.01 degrees, a shift of 0.3 km
//! along the limb.

use crate::catalog::lunar_heights::HeightMap;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Number of position angles of a profile: 1.3 km of limb each.
pub const LIMB_POINTS: usize = 8192;

/// Heights of a silhouette.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbProfile {
    /// Kilometres above the map's sphere, at equal steps of the position angle from the first vector of `position_angle_axes` towards the second.
    heights_km: Vec<f64>,
    /// Unit vectors perpendicular to the direction to the place, in the Moon's axes: towards the Moon's north as seen, and a quarter turn counterclockwise
    /// from it, as seen from the place.
    position_angle_axes: [DVec3; 2],
    /// Unit vector to the place.
    to_place: DVec3,
    /// Radius of the map's sphere.
    sphere_km: f64,
}

impl LimbProfile {
    /// The profile seen from `place_km` in the Moon's axes. The place must be outside of all ground.
    pub fn seen_from(map: &HeightMap, place_km: DVec3) -> Self {
        let distance_km = place_km.length();
        let to_place = place_km / distance_km;
        let north = (DVec3::Z - to_place * to_place.z).try_normalize().unwrap_or(DVec3::X);
        let position_angle_axes = [north, to_place.cross(north)];
        let heights_km = (0..LIMB_POINTS)
            .into_par_iter()
            .map(|k| {
                let (sin, cos) = (TAU * k as f64 / LIMB_POINTS as f64).sin_cos();
                silhouette_height_km(map, distance_km, to_place, position_angle_axes[0] * cos + position_angle_axes[1] * sin)
            })
            .collect();
        Self { heights_km, position_angle_axes, to_place, sphere_km: map.sphere_km() }
    }

    /// Radius of the sphere from which heights are measured.
    pub fn sphere_km(&self) -> f64 {
        self.sphere_km
    }

    /// Heights above the sphere at [`LIMB_POINTS`] equal steps of the position angle, from 0.
    pub fn heights_km(&self) -> &[f64] {
        &self.heights_km
    }

    /// The unit vectors at position angles of 0 and 90 degrees, in the Moon's axes.
    pub fn position_angle_axes(&self) -> [DVec3; 2] {
        self.position_angle_axes
    }

    /// Unit vector to the place from which the profile is seen, in the Moon's axes.
    pub fn to_place(&self) -> DVec3 {
        self.to_place
    }

    /// The minimum and maximum height above the sphere.
    pub fn range_km(&self) -> [f64; 2] {
        self.heights_km.iter().fold([f64::MAX, f64::MIN], |[a, b], h| [a.min(*h), b.max(*h)])
    }

    /// Height above the sphere at a position angle, interpolated linearly.
    pub fn height_km(&self, position_angle_rad: f64) -> f64 {
        let index = position_angle_rad.rem_euclid(TAU) / TAU * LIMB_POINTS as f64;
        let at = |k: usize| self.heights_km[k % LIMB_POINTS];
        let first = index as usize;
        at(first) + (at(first + 1) - at(first)) * index.fract()
    }

    /// Direction from the place to point `k` of the silhouette: unit vector in the Moon's axes. `distance_km`: from the place to the Moon's centre.
    pub fn direction(&self, k: usize, distance_km: f64) -> DVec3 {
        let (sin, cos) = (TAU * k as f64 / LIMB_POINTS as f64).sin_cos();
        // From a place no farther from the centre than the silhouette is, a grazing ray is perpendicular to the direction to the centre: a sine of 1.
        let sin_angle = ((self.sphere_km + self.heights_km[k]) / distance_km).min(1.0);
        (self.position_angle_axes[0] * cos + self.position_angle_axes[1] * sin) * sin_angle
            - self.to_place * (1.0 - sin_angle * sin_angle).sqrt()
    }
}

/// Iterations of the ternary search for the summit: they shrink its interval of two sample steps by (2/3)^13 = 0.005, to a hundredth of a sample step.
const REFINEMENTS: usize = 13;

/// Height of the silhouette above the sphere in the half plane towards `limb_direction`: the greatest distance from the Moon's centre of a view ray that meets
/// ground in that half plane, less the sphere's radius.
fn silhouette_height_km(map: &HeightMap, distance_km: f64, to_place: DVec3, limb_direction: DVec3) -> f64 {
    let [_, highest_ground_km] = map.range_km();
    let sphere_km = map.sphere_km();
    // Distance of a view ray from the Moon's centre: the place's distance times the sine of the angle at the place between the ray and the centre. The ray
    // passes through the point at `radius_km` from the centre and at `angle` from the direction to the place.
    let ray_km = |radius_km: f64, angle: f64| {
        let (sideways, ahead) = (radius_km * angle.sin(), distance_km - radius_km * angle.cos());
        distance_km * sideways / sideways.hypot(ahead)
    };
    // Angle at the Moon's centre between the direction to the place and the limb of the map's sphere.
    let limb_angle = (sphere_km / distance_km).min(1.0).acos();
    let ground_ray_km = |angle: f64| ray_km(sphere_km + map.height_km(to_place * angle.cos() + limb_direction * angle.sin()), angle);
    let step_rad = 0.5 * map.step_rad();
    let (mut best_km, mut best_angle) = (ground_ray_km(limb_angle), limb_angle);
    // Samples are taken farther and farther from the sphere's limb, first in front of it, then behind it, until even the map's maximum could not exceed the
    // highest sample. The two limits of the angle keep it between 0 and pi, in the half plane.
    for sign in [-1.0, 1.0] {
        for k in 1.. {
            let angle = limb_angle + sign * step_rad * f64::from(k);
            if angle <= 0.0 || angle >= limb_angle + FRAC_PI_2 || ray_km(sphere_km + highest_ground_km, angle) <= best_km {
                break;
            }
            let grazing_km = ground_ray_km(angle);
            if grazing_km > best_km {
                (best_km, best_angle) = (grazing_km, angle);
            }
        }
    }
    // The summit lies between the neighbours of the highest sample.
    let (mut low_angle, mut high_angle) = (best_angle - step_rad, best_angle + step_rad);
    for _ in 0..REFINEMENTS {
        let third = (high_angle - low_angle) / 3.0;
        let [low_km, high_km] = [ground_ray_km(low_angle + third), ground_ray_km(high_angle - third)];
        best_km = best_km.max(low_km).max(high_km);
        if low_km < high_km { low_angle += third } else { high_angle -= third }
    }
    best_km - sphere_km
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::lunar_heights::DEFAULT_SPHERE_KM;

    const COLUMNS: usize = 1440;

    /// A map of heights in km, given as a function of latitude and east longitude in degrees, with cells of 0.25 degrees.
    fn map(height: impl Fn(f64, f64) -> f64) -> HeightMap {
        let cell_centre = |k: usize, cells: usize, span: f64| (k as f64 + 0.5) / cells as f64 * span;
        let centres_deg = (0..COLUMNS / 2).flat_map(|row| {
            let latitude = 90.0 - cell_centre(row, COLUMNS / 2, 180.0);
            (0..COLUMNS).map(move |column| (latitude, cell_centre(column, COLUMNS, 360.0) - 180.0)).collect::<Vec<_>>()
        });
        let heights_km = centres_deg.map(|(latitude, longitude)| height(latitude, longitude) as f32).collect();
        let west_deg = -180.0;
        HeightMap::new("made", COLUMNS, heights_km, west_deg, DEFAULT_SPHERE_KM).expect("a map")
    }

    /// A place in the Moon's axes.
    fn place_at(latitude_deg: f64, longitude_deg: f64, distance_km: f64) -> DVec3 {
        let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (latitude_deg.to_radians().sin_cos(), longitude_deg.to_radians().sin_cos());
        DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat) * distance_km
    }

    #[test]
    fn level_ground_has_a_level_limb() {
        for km in [-2.0, 0.0, 3.5] {
            let profile = LimbProfile::seen_from(&map(|_, _| km), place_at(5.0, -7.0, 370_000.0));
            let [lowest, highest] = profile.range_km();
            // The samples start at the sphere's limb, not at that of the ground. They are 0.125 degrees apart, so one is within 0.0625 degrees of the ground's
            // limb: its view ray passes lower by 1738 km (1 - cos 0.0625 degrees) = 1 m at most.
            assert!((lowest - km).abs() < 2e-3 && (highest - km).abs() < 2e-3, "{km}: {lowest} to {highest}");
        }
    }

    /// A summit behind or in front of the limb of the map's sphere (radius R) appears as high as plane geometry predicts: the view ray that grazes it passes
    /// the centre at (R + h) cos(angle from the limb), because the rays from 370 000 km are almost parallel there.
    #[test]
    fn summits_behind_and_in_front_of_the_limb_count() {
        for (behind_deg, is_seen) in [(0.0, true), (2.0, true), (-2.0, true), (4.0, true), (6.5, false)] {
            // East longitude of the limb on the equator: 89.73 degrees.
            let limb_deg = (DEFAULT_SPHERE_KM / 370_000.0_f64).acos().to_degrees();
            // The summit is at the middle of a cell of the map (0.25 degrees wide), as is 0.125, the latitude of the summit and of the place.
            let cells: f64 = (limb_deg + behind_deg) / 0.25;
            let summit_deg = (cells.floor() + 0.5) * 0.25;
            // A ridge, 9 km high, that crosses the equator; wider than the spacing of the profile's points.
            let ridge = |latitude: f64, longitude: f64| {
                let beside_deg = ((latitude - 0.125).abs() - 0.5).max(0.0);
                (9.0 - 9.0 * beside_deg.hypot(longitude - summit_deg)).max(0.0)
            };
            let profile = LimbProfile::seen_from(&map(ridge), place_at(0.125, 0.0, 370_000.0));
            let beyond_limb_rad = (summit_deg - limb_deg).to_radians();
            let expected = (DEFAULT_SPHERE_KM + 9.0) * beyond_limb_rad.cos() - DEFAULT_SPHERE_KM;
            let [_, highest] = profile.range_km();
            assert_eq!(expected > 0.1, is_seen, "{expected}");
            assert!((highest - expected.max(0.0)).abs() < 0.03, "{behind_deg}: {highest} for {expected}");
            if is_seen {
                // The highest point must lie in the east (y), whichever way the position angle counts.
                let index = (0..LIMB_POINTS).max_by(|a, b| profile.heights_km[*a].total_cmp(&profile.heights_km[*b])).expect("points");
                let east = profile.position_angle_axes[0] * (TAU * index as f64 / LIMB_POINTS as f64).cos()
                    + profile.position_angle_axes[1] * (TAU * index as f64 / LIMB_POINTS as f64).sin();
                assert!(east.y > 0.999, "{east}");
            }
        }
    }

    /// Directions are those of rays at the silhouette's distance from the centre, and heights between points are linear.
    #[test]
    fn directions_graze_the_silhouette() {
        let place = place_at(3.0, 4.0, 380_000.0);
        let profile = LimbProfile::seen_from(&map(|latitude, longitude| (latitude / 9.0).sin() + (longitude / 7.0).cos()), place);
        for k in (0..LIMB_POINTS).step_by(97) {
            let ray = profile.direction(k, place.length());
            assert!((ray.length() - 1.0).abs() < 1e-12);
            assert!((place.cross(ray).length() - DEFAULT_SPHERE_KM - profile.heights_km[k]).abs() < 1e-6);
            let angle = TAU * (k as f64 + 0.5) / LIMB_POINTS as f64;
            let mean = 0.5 * (profile.heights_km[k] + profile.heights_km[(k + 1) % LIMB_POINTS]);
            assert!((profile.height_km(angle) - mean).abs() < 1e-9 && (profile.height_km(angle - TAU) - mean).abs() < 1e-9);
        }
    }
}
