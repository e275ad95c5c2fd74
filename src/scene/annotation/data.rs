//! Points of the user's data layers over an image.
//!
//! In: the catalog's data layers (each on a body or in the sky), the time, the bodies in view and the viewer's velocity. Out: [`Dot`]s. Always: a point appears
//! at its time and fades over its layer's `fade_days`; a point in the sky has the aberration of a star, but neither proper motion nor parallax; points on the
//! far side of their body or behind another body are left out. A million points take about 100 ms.

use crate::catalog::{Catalog, DataLayer};
use crate::ephemeris::apparent::aberrated;
use crate::ephemeris::topocentric::ground_point_km;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::sphere::ImageProjection;
use crate::scene::sky::frames::unit_vector;
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use glam::{DVec2, DVec3};

/// A filled circle over the finished image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    pub centre_px: DVec2,
    pub radius_px: f64,
    /// sRGB.
    pub colour: [u8; 3],
    /// 0 to 1.
    pub opacity: f64,
}

/// Opacity of a point or line when it appears, before it fades. A point or line without a time always has this opacity.
const OPACITY: f64 = 0.9;
/// The image height for which the data layers give the sizes of dots; in other images the sizes are in proportion to the height.
const REFERENCE_HEIGHT_PX: f64 = 1024.0;

/// Opacity of a point or line of a layer; `None` if it is not visible now. `time`: when it appears; without a time it is always visible.
pub(super) fn opacity_at(layer: &DataLayer, time: Option<Instant>, now: Instant) -> Option<f64> {
    let Some(time) = time else { return Some(OPACITY) };
    let age_days = (now.tdb_seconds_past_j2000() - time.tdb_seconds_past_j2000()) / SECONDS_PER_DAY;
    let remaining = layer.fade_days.map_or(1.0, |days| 1.0 - age_days / days);
    (age_days >= 0.0 && remaining > 0.0).then_some(OPACITY * remaining)
}

/// Whether a body whose centre is nearer than `distance_km` covers this line of sight, a vector from the camera (ICRF) of any length. A body without a known
/// position covers none.
pub(crate) fn is_hidden(bodies: &[BodyReport], line_of_sight: DVec3, distance_km: f64) -> bool {
    bodies.iter().any(|b| {
        let placement = &b.placement;
        let (camera, ray) = (placement.camera_in_unit_sphere(), placement.direction_in_unit_sphere(line_of_sight).normalize());
        // The ray approaches the centre of the unit sphere, and its line passes the centre at a distance of less than 1.
        b.distance_km < distance_km && !placement.camera_is_inside() && camera.dot(ray) < 0.0 && camera.cross(ray).length() < 1.0
    })
}

/// The dots of all layers; those of later layers are on top. `velocity_km_s`: the viewer's velocity, for the aberration of points in the sky.
pub(crate) fn dots(image: &impl ImageProjection, catalog: &Catalog, bodies: &[BodyReport], velocity_km_s: DVec3, now: Instant) -> Vec<Dot> {
    let scale = image.size_px().y / REFERENCE_HEIGHT_PX;
    // Only bodies with a known position, and not at the camera, hide points or have points.
    let located: Vec<BodyReport> = bodies.iter().filter(|b| b.distance_km > 0.0 && b.placement.centre_km.is_finite()).cloned().collect();
    let mut dots = Vec::new();
    for layer in catalog.data_layers() {
        let body = layer.body.map(|id| located.iter().find(|b| b.id == id));
        // The layer is on a body without a known position, or at whose centre the camera is.
        if matches!(body, Some(None)) {
            continue;
        }
        for point in layer.points.iter() {
            let Some(opacity) = opacity_at(&layer, point.time, now) else { continue };
            let (line_of_sight, distance_km) = match body.flatten() {
                Some(body) => {
                    let placement = &body.placement;
                    let height_km = 0.0;
                    let (ground, normal) = ground_point_km(placement.radii_km, point.lat_deg, point.lon_deg, height_km);
                    let line_of_sight = placement.centre_km + placement.body_from_icrf.transpose() * ground;
                    if (placement.body_from_icrf.transpose() * normal).dot(line_of_sight) >= 0.0 {
                        continue;
                    }
                    // The distance of the body's centre: nearer bodies may hide the point, but its own body does not.
                    (line_of_sight, body.distance_km)
                }
                // For a point in the sky, `lon_deg` is the right ascension and `lat_deg` the declination.
                None => (aberrated(unit_vector(point.lon_deg, point.lat_deg), velocity_km_s), f64::INFINITY),
            };
            let Some(centre_px) = image.pixel_of(line_of_sight) else { continue };
            let radius_px = 0.5 * point.size_px.unwrap_or(layer.size_px) * scale;
            let max_centre_px = image.size_px() + radius_px;
            if centre_px.cmplt(DVec2::splat(-radius_px)).any()
                || centre_px.cmpgt(max_centre_px).any()
                || is_hidden(&located, line_of_sight, distance_km)
            {
                continue;
            }
            dots.push(Dot { centre_px, radius_px, colour: point.colour.unwrap_or(layer.colour), opacity });
        }
    }
    dots
}
