//! Stars and points of the faces as sprites of the whole picture.
//!
//! In: the sprites of a face's frame. Out: those of the picture in its clip space, with the same irradiance: the flux of a sprite is inversely proportional
//! to the solid angle of a pixel, which differs between face and picture. Each sprite is taken from the face that contains its direction. Always: the width
//! of a sprite is that of a star in a plain picture; near the poles of an equirectangular picture it is a row of sprites as wide as the stretched circle;
//! sprites that cross the left or right edge of such a picture are repeated at the other.

use super::faces::face_of;
use crate::scene::camera::sphere::SpherePicture;
use crate::scene::camera::{Camera, narrow, narrow_scalar};
use crate::scene::draw::{Point, StarSprite};
use crate::scene::point::{point_peak, point_radius_px};
use crate::scene::request::Projection;
use glam::{DVec2, DVec3, Vec3};

/// Maximum radius of a sprite relative to the picture's shorter side, and the radius in pixels that is always allowed: at a night's exposure the Sun, which
/// is in every picture of the whole sphere, would otherwise cover everything within 20 degrees.
const GLARE_OF_HEIGHT: f64 = 0.015;
const LEAST_GLARE_PX: f64 = 8.0;

/// A projected sprite: clip position, radius, flux.
struct Placed {
    centre: Vec3,
    radius_px: f32,
    flux: Vec3,
}

/// The sprites of the picture for one sprite of a face.
fn placed(picture: &SpherePicture, face: usize, camera: &Camera, centre: Vec3, flux: Vec3, white: f64) -> Vec<Placed> {
    let ray = camera.ray(DVec2::new(f64::from(centre.x), f64::from(centre.y)));
    let direction = picture.in_axes(ray).normalize();
    let Some(pixel) = picture.pixel(direction).filter(|_| face_of(direction) == face) else { return Vec::new() };
    let cos_off_axis = 1.0 / ray.length();
    let face_sr = camera.pixel_tangent().powi(2) * cos_off_axis.powi(3);
    let (picture_sr, stretch) = picture.pixel_sr_and_stretch(direction);
    let flux = flux.as_dvec3() * (face_sr / picture_sr);
    let size = DVec2::new(f64::from(picture.width), f64::from(picture.height));
    let copies = stretch.round().clamp(1.0, size.x);
    let share: DVec3 = flux / copies;
    let most_px = GLARE_OF_HEIGHT * size.y.min(size.x);
    let radius_px = point_radius_px(share.max_element() * point_peak() / white).min(most_px.max(LEAST_GLARE_PX));
    let wraps = picture.projection == Projection::Equirectangular;
    let mut all = Vec::new();
    // At most the picture's width.
    for k in 0..copies as u32 {
        let along = (f64::from(k) + 0.5 - 0.5 * copies) * (stretch / copies).min(size.x / copies);
        let x = if copies > 1.0 { pixel.x + along } else { pixel.x };
        for turn in [0.0, -size.x, size.x] {
            let at = DVec2::new(x + turn, pixel.y);
            let inside = at.x + radius_px > 0.0 && at.x - radius_px < size.x;
            if inside && (wraps || turn == 0.0) {
                let clip = DVec2::new(2.0 * at.x / size.x - 1.0, 1.0 - 2.0 * at.y / size.y);
                all.push(Placed {
                    centre: narrow(clip.extend(f64::from(centre.z))),
                    radius_px: narrow_scalar(radius_px),
                    flux: narrow(share),
                });
            }
        }
    }
    all
}

/// The stars of a face. `white`: the radiance that is shown as white.
pub(crate) fn stars(picture: &SpherePicture, face: usize, camera: &Camera, of_face: &[StarSprite], white: f64) -> Vec<StarSprite> {
    let of = |s: &StarSprite| {
        let star = s.star;
        let sprites = placed(picture, face, camera, s.centre, s.flux, white);
        sprites.into_iter().map(move |Placed { centre, radius_px, flux }| StarSprite { centre, radius_px, flux, star })
    };
    of_face.iter().flat_map(of).collect()
}

/// The points of a face.
pub(crate) fn points(picture: &SpherePicture, face: usize, camera: &Camera, of_face: &[Point], white: f64) -> Vec<Point> {
    let of = |p: &Point| {
        let body = p.body;
        let sprites = placed(picture, face, camera, p.centre, p.flux, white);
        sprites.into_iter().map(move |Placed { centre, radius_px, flux }| Point { body, centre, radius_px, flux })
    };
    of_face.iter().flat_map(of).collect()
}
