//! Points of a body's ground and lower air that a frame shows: samples for the choice between effects that no shader has together.
//!
//! In: the camera and a body. Out: points in body axes and equatorial radii, and a ball that contains the ground and the lower air in the frame. The points lie
//! on a grid of rays across the frame, its edges included, and where the horizon is in the frame also on the horizon.

use crate::catalog::Body;
use crate::scene::camera::{Camera, Placement};
use glam::{DVec2, DVec3};

/// Number of rays along each side of the frame.
const RAYS: u32 = 17;
/// Height of the lower air, relative to the top of the air: on the Earth 40 km, above which is 0.4 % of the gas.
const LOWER_AIR: f64 = 0.4;
/// Factor on the ball's radius, a margin for the ground between rays.
const BALL_MARGIN: f64 = 1.1;

/// Points that a frame shows of a body.
pub(crate) struct PointsInFrame {
    /// Where rays meet the ground: evenly spaced in the frame.
    pub ground: Vec<DVec3>,
    /// On the horizon, where rays enter or leave the lower air, and where rays that graze the horizon leave it.
    pub others: Vec<DVec3>,
}

impl PointsInFrame {
    pub(crate) fn of(camera: &Camera, placement: &Placement, body: &Body) -> Self {
        let axis_ratios = placement.radii_km / placement.radii_km.x;
        let origin = placement.camera_in_unit_sphere();
        let air_top = body.atmosphere.as_ref().map(|air| 1.0 + LOWER_AIR * air.top_km / body.radii_km.x);
        let mut points = Self { ground: Vec::new(), others: Vec::new() };
        let mut rays_above_horizon = Vec::new();
        for n in 0..RAYS * RAYS {
            let clip = DVec2::new(f64::from(n % RAYS), f64::from(n / RAYS)) * (2.0 / f64::from(RAYS - 1)) - 1.0;
            let ray = placement.direction_in_unit_sphere(camera.ray(clip)).normalize();
            let ground = placement.surface_along_unit_sphere(ray);
            match ground {
                Some(point) => points.ground.push(point * axis_ratios),
                None => rays_above_horizon.push(ray),
            }
            let Some(top) = air_top else { continue };
            let to_nearest = -origin.dot(ray);
            let half_chord_sq = top * top - origin.cross(ray).length_squared();
            if half_chord_sq <= 0.0 || to_nearest + half_chord_sq.sqrt() <= 0.0 {
                continue;
            }
            let enters_at = (to_nearest - half_chord_sq.sqrt()).max(0.0);
            points.others.push((origin + ray * enters_at) * axis_ratios);
            if ground.is_none() {
                points.others.push((origin + ray * (to_nearest + half_chord_sq.sqrt())) * axis_ratios);
            }
        }
        if !points.ground.is_empty() {
            let distance = origin.length();
            let up = origin / distance;
            let across_radius = (1.0 - 1.0 / (distance * distance)).max(0.0).sqrt();
            for ray in rays_above_horizon {
                let across = ray.reject_from_normalized(up).normalize_or_zero();
                let on_horizon = up / distance + across * across_radius;
                points.others.push(on_horizon * axis_ratios);
                // The ray that grazes the ground leaves the lower air farther away.
                let beyond = (on_horizon - origin).normalize_or_zero();
                points.others.extend(air_top.map(|top| (on_horizon + beyond * (top * top - 1.0).sqrt()) * axis_ratios));
            }
        }
        points
    }

    fn all(&self) -> impl Iterator<Item = DVec3> {
        self.ground.iter().chain(&self.others).copied()
    }

    /// Centre and radius of a ball that contains the points; `None` if there are none.
    pub(crate) fn ball(&self) -> Option<(DVec3, f64)> {
        let first = self.all().next()?;
        let (low, high) = self.all().fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
        let centre = 0.5 * (low + high);
        let radius = self.all().map(|p| p.distance(centre)).fold(0.0, f64::max);
        Some((centre, BALL_MARGIN * radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use glam::DMat3;

    /// A view from above a body of the catalog, with a field of view of 60 degrees. `down_deg`: of the line of sight below the horizontal plane.
    fn ball(id: i32, height_km: f64, down_deg: f64) -> Option<(DVec3, f64)> {
        let catalog = Catalog::embedded();
        let body = catalog.body(NaifId(id)).expect("in the catalog");
        let (sin, cos) = down_deg.to_radians().sin_cos();
        let camera = Camera::looking(DVec3::ZERO, DVec3::new(0.0, cos, -sin), DVec3::Z, 60.0, 200, 200);
        let centre_km = DVec3::Z * -(body.radii_km.z + height_km);
        let placement = Placement { centre_km, body_from_icrf: DMat3::IDENTITY, radii_km: body.radii_km };
        PointsInFrame::of(&camera, &placement, body).ball()
    }

    /// From 100 m above the Moon, the horizon is 18.6 km away. Without air, a frame of the sky shows nothing. Straight down, the frame shows the ground within
    /// 82 m, to its corners. On the Earth, the lower air in the frame is farther away than the ground.
    #[test]
    fn the_ball_contains_ground_horizon_and_lower_air() {
        let moon_km = 1737.4;
        let (centre, radius) = ball(301, 0.1, 10.0).expect("ground");
        let reach_km = (centre.y + radius) * moon_km;
        assert!(reach_km > 18.6 && radius * moon_km < 18.6, "{reach_km} {}", radius * moon_km);
        assert!(ball(301, 0.1, -60.0).is_none());
        let (_, radius) = ball(301, 0.1, 90.0).expect("ground");
        assert!(radius * moon_km > 0.081 && radius * moon_km < 0.095, "{}", radius * moon_km);
        let earth_km = 6378.0;
        let (centre, radius) = ball(399, 1.0, 10.0).expect("ground");
        let reach_km = (centre.y + radius) * earth_km;
        // The horizon is 113 km away, and the lower air 714 km beyond it.
        assert!(reach_km > 827.0 && reach_km < 1050.0, "{reach_km}");
        assert!(ball(399, 1.0, -60.0).is_some(), "the sky of the Earth is lower air");
    }
}
