//! Stars and points of the faces as sprites of the entire image.
//!
//! In: the sprites of a face's frame. Out: sprites in the clip space of the image, with the same irradiance. A sprite's flux is inversely proportional to
//! the solid angle of a pixel, which differs between face and image. Each sprite comes from the face that contains its direction. Always:
//! a sprite is as wide as a star in a perspective image. Near the poles of an equirectangular image a star becomes a row of sprites as wide as the
//! stretched circle. Sprites that cross the left or right edge of such an image are repeated at the opposite edge.

use super::faces::face_of;
use crate::scene::camera::sphere::SphereImage;
use crate::scene::camera::{Camera, narrow, narrow_scalar};
use crate::scene::draw::{Point, StarSprite};
use crate::scene::point::{point_peak, point_radius_px};
use crate::scene::request::Projection;
use glam::{DVec2, DVec3, Vec3};

/// Maximum radius of a sprite relative to the image's shorter side. Without this limit the Sun, which is in every image of the entire sphere, would cover
/// everything within 20 degrees at a night exposure.
const MAX_RADIUS_OF_SHORT_SIDE: f64 = 0.015;
/// Radius in pixels that a sprite may have in any image, however small.
const ALWAYS_ALLOWED_RADIUS_PX: f64 = 8.0;

/// A projected sprite: clip position, radius, flux.
struct ProjectedSprite {
    centre: Vec3,
    radius_px: f32,
    flux: Vec3,
}

/// The sprites of the image for one sprite of a face; none if another face contains its direction.
fn project(image: &SphereImage, face: usize, camera: &Camera, centre: Vec3, flux: Vec3, white: f64) -> Vec<ProjectedSprite> {
    let ray = camera.ray(DVec2::new(f64::from(centre.x), f64::from(centre.y)));
    let direction = image.in_axes(ray).normalize();
    let Some(pixel) = image.pixel(direction).filter(|_| face_of(direction) == face) else { return Vec::new() };
    let cos_off_axis = 1.0 / ray.length();
    let face_sr = camera.pixel_tangent().powi(2) * cos_off_axis.powi(3);
    let (image_sr, stretch) = image.pixel_sr_and_stretch(direction);
    let flux = flux.as_dvec3() * (face_sr / image_sr);
    let size = DVec2::new(f64::from(image.width), f64::from(image.height));
    let copies = stretch.round().clamp(1.0, size.x);
    let copy_flux: DVec3 = flux / copies;
    let max_px = MAX_RADIUS_OF_SHORT_SIDE * size.y.min(size.x);
    let radius_px = point_radius_px(copy_flux.max_element() * point_peak() / white).min(max_px.max(ALWAYS_ALLOWED_RADIUS_PX));
    let wraps = image.projection == Projection::Equirectangular;
    let mut sprites = Vec::new();
    // The cast is exact: `copies` is a whole number of at most the image's width.
    for k in 0..copies as u32 {
        let offset_px = (f64::from(k) + 0.5 - 0.5 * copies) * (stretch / copies).min(size.x / copies);
        let x = if copies > 1.0 { pixel.x + offset_px } else { pixel.x };
        for shift_px in [0.0, -size.x, size.x] {
            let copy_px = DVec2::new(x + shift_px, pixel.y);
            let is_inside = copy_px.x + radius_px > 0.0 && copy_px.x - radius_px < size.x;
            if is_inside && (wraps || shift_px == 0.0) {
                let clip = DVec2::new(2.0 * copy_px.x / size.x - 1.0, 1.0 - 2.0 * copy_px.y / size.y);
                sprites.push(ProjectedSprite {
                    centre: narrow(clip.extend(f64::from(centre.z))),
                    radius_px: narrow_scalar(radius_px),
                    flux: narrow(copy_flux),
                });
            }
        }
    }
    sprites
}

/// The image's sprites for the stars of a face. `white`: the radiance that is shown as white.
pub(crate) fn stars(image: &SphereImage, face: usize, camera: &Camera, of_face: &[StarSprite], white: f64) -> Vec<StarSprite> {
    let sprites_of = |s: &StarSprite| {
        let star = s.star;
        let sprites = project(image, face, camera, s.centre, s.flux, white);
        sprites.into_iter().map(move |ProjectedSprite { centre, radius_px, flux }| StarSprite { centre, radius_px, flux, star })
    };
    of_face.iter().flat_map(sprites_of).collect()
}

/// The image's sprites for the points of a face.
pub(crate) fn points(image: &SphereImage, face: usize, camera: &Camera, of_face: &[Point], white: f64) -> Vec<Point> {
    let sprites_of = |p: &Point| {
        let body = p.body;
        let sprites = project(image, face, camera, p.centre, p.flux, white);
        sprites.into_iter().map(move |ProjectedSprite { centre, radius_px, flux }| Point { body, centre, radius_px, flux })
    };
    of_face.iter().flat_map(sprites_of).collect()
}
