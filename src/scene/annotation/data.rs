//! Points of the user's data over a picture.
//!
//! In: the catalog's data layers, the time, and the bodies as the picture shows them. Out: [`Dot`]s. Always: a point shows from its time on and fades in the days that its
//! layer says; what is on the far side of its body, or behind another, is left out. A million points are some 100 ms.

use crate::catalog::{Catalog, DataLayer};
use crate::ephemeris::topocentric::ground_point_km;
use crate::scene::camera::sphere::PicturePlaces;
use crate::scene::in_view::BodyInView;
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use glam::{DVec2, DVec3};

/// A disc over the finished picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    pub centre_px: DVec2,
    pub radius_px: f64,
    /// sRGB.
    pub colour: [u8; 3],
    /// 0 to 1.
    pub opacity: f64,
}

/// Opacity of a point at its time.
const OPACITY: f64 = 0.9;
/// The picture's height at which sizes are pixels; in others they grow with it.
const HEIGHT_PX: f64 = 1024.0;

/// Opacity at a time of what has one; `None`: it does not show.
pub(super) fn shown(layer: &DataLayer, time: Option<Instant>, now: Instant) -> Option<f64> {
    let Some(time) = time else { return Some(OPACITY) };
    let age_days = (now.tdb_seconds_past_j2000() - time.tdb_seconds_past_j2000()) / SECONDS_PER_DAY;
    let left = layer.fade_days.map_or(1.0, |days| 1.0 - age_days / days);
    (age_days >= 0.0 && left > 0.0).then_some(OPACITY * left)
}

/// Whether a body nearer than this stands before a direction.
fn hidden(bodies: &[BodyInView], sight: DVec3, distance_km: f64) -> bool {
    bodies.iter().any(|b| {
        let place = &b.placement;
        let (camera, along) = (place.camera_in_unit_sphere(), place.direction_in_unit_sphere(sight).normalize());
        b.distance_km < distance_km && !place.camera_is_inside() && camera.dot(along) < 0.0 && camera.cross(along).length() < 1.0
    })
}

/// The dots of all layers, those of earlier ones below.
pub fn dots(picture: &impl PicturePlaces, catalog: &Catalog, bodies: &[BodyInView], now: Instant) -> Vec<Dot> {
    let scale = picture.size_px().y / HEIGHT_PX;
    let placed: Vec<BodyInView> = bodies.iter().filter(|b| b.distance_km > 0.0 && b.placement.centre_km.is_finite()).cloned().collect();
    let mut all = Vec::new();
    for layer in catalog.data_layers() {
        let body = layer.body.map(|id| placed.iter().find(|b| b.id == id));
        if matches!(body, Some(None)) {
            continue;
        }
        for point in layer.points.iter() {
            let Some(opacity) = shown(&layer, point.time, now) else { continue };
            let (sight, others_km) = match body.flatten() {
                Some(body) => {
                    let place = &body.placement;
                    let (ground, normal) = ground_point_km(place.radii_km, point.lat_deg, point.lon_deg, 0.0);
                    let sight = place.centre_km + place.body_from_icrf.transpose() * ground;
                    if (place.body_from_icrf.transpose() * normal).dot(sight) >= 0.0 {
                        continue;
                    }
                    (sight, body.distance_km * (1.0 - 1e-9))
                }
                None => {
                    let ((sin_ra, cos_ra), (sin_dec, cos_dec)) =
                        (point.lon_deg.to_radians().sin_cos(), point.lat_deg.to_radians().sin_cos());
                    (DVec3::new(cos_dec * cos_ra, cos_dec * sin_ra, sin_dec), f64::INFINITY)
                }
            };
            let Some(centre_px) = picture.place_px(sight) else { continue };
            let radius_px = 0.5 * point.size_px.unwrap_or(layer.size_px) * scale;
            let size = picture.size_px() + radius_px;
            if centre_px.cmplt(DVec2::splat(-radius_px)).any() || centre_px.cmpgt(size).any() || hidden(&placed, sight, others_km) {
                continue;
            }
            all.push(Dot { centre_px, radius_px, colour: point.colour.unwrap_or(layer.colour), opacity });
        }
    }
    all
}
