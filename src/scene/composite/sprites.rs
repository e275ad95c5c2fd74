//! Stars and points of the faces as sprites of the entire image.
//!
//! In: the sprites of a face's frame. Out: sprites in the clip space of the image, with the same irradiance. A sprite's flux is inversely proportional to
//! the solid angle of a pixel, which differs between face and image. Each sprite comes from the face that contains its direction; on the edge of two faces,
//! from the first. Always: a sprite has as many pixels in height as in a perspective image. In an equirectangular image it is stretched horizontally as the
//! image is, so that it spans the same angle in both directions. Sprites that cross the left or right edge of such an image are repeated at the opposite
//! edge. Near its poles, where a sprite may surround the pole, the face draws the sprite itself, and the image is resampled from the face. In a fisheye a
//! sprite ends at the circle, except that no sprite is smaller than that of a faint star.

use super::faces::face_of;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::sphere::SphereImage;
use crate::scene::camera::{Camera, narrow, narrow_scalar};
use crate::scene::draw::{Point, StarSprite};
use crate::scene::point::{MIN_POINT_RADIUS_PX, pixel_sr, point_peak, point_radius_px};
use crate::scene::request::Projection;
use glam::{DVec2, DVec3, Vec3};

/// Maximum radius of a sprite relative to the image's shorter side. Without this limit the Sun, which is in every image of the entire sphere, would cover
/// everything within 20 degrees at a night exposure.
const MAX_RADIUS_FRACTION: f64 = 0.015;
/// Radius in pixels that a sprite may have in any image, however small.
const ALWAYS_ALLOWED_RADIUS_PX: f64 = 8.0;

/// Cosine of the latitude beyond which, towards the poles of an equirectangular image, the face draws the sprites: that of 60 degrees, where the image is
/// stretched by 2. The edges of the upper and the lower face are at least 15 degrees away from there.
const POLAR_COS_LATITUDE: f64 = 0.5;

/// Distance, in half sides of a face, within which a position is on an edge of the face: several times the rounding of f32.
const EDGE_WIDTH: f64 = 1e-6;

/// A sprite in the image. `centre`: clip position and reversed depth. `stretch`: its width over its height.
struct ProjectedSprite {
    centre: Vec3,
    radius_px: f32,
    stretch: f32,
    flux: Vec3,
    /// Solid angle of a pixel of the face relative to that of a pixel of the image.
    pixels_per_face_pixel: f32,
}

/// Where the light of a face's sprite is drawn.
enum Drawn {
    /// In the image, by these sprites; none if another face contains the direction, or the circle of a fisheye does not.
    InImage(Vec<ProjectedSprite>),
    /// In the face, with this radius in the face's pixels. `for_picking`: the sprite in the image, with radius 0.
    InFace { radius_px: f32, for_picking: ProjectedSprite },
}

/// The sprites of a face, divided into those that the face draws itself and those of the image.
pub(crate) struct DividedSprites<T> {
    pub in_face: Vec<T>,
    pub in_image: Vec<T>,
}

/// Projects a sprite of a face into the image, or leaves it to the face. `camera`: of the face. `centre`: clip position in the face's frame and reversed depth.
/// `white`: the radiance that is shown as white. `radius_px_at`: the sprite's radius in the image before it is limited, as a function of the brightness of
/// its central pixel (without glare, relative to white). `is_in_face`: whether the face contains a direction in the image's axes.
fn project(
    image: &SphereImage,
    camera: &Camera,
    (centre, flux): (Vec3, Vec3),
    white: f64,
    radius_px_at: impl Fn(f64) -> f64,
    is_in_face: impl Fn(DVec3) -> bool,
) -> Drawn {
    let ray = camera.ray(DVec2::new(f64::from(centre.x), f64::from(centre.y)));
    let direction = image.in_axes(ray).normalize();
    let Some(pixel) = image.pixel(direction).filter(|_| is_in_face(direction)) else { return Drawn::InImage(Vec::new()) };
    // A pixel of a face at the angle a from its axis covers less than the middle one: cos a along the circle around the axis, cos² a along the radius.
    let cos_off_axis = 1.0 / ray.length();
    let face_sr = pixel_sr(camera, ray.normalize());
    let (image_sr, stretch) = image.pixel_sr_and_stretch(direction);
    let pixels_per_face_pixel = face_sr / image_sr;
    let flux = flux.as_dvec3() * pixels_per_face_pixel;
    let size = DVec2::new(f64::from(image.width), f64::from(image.height));
    let clip_of = |px: DVec2| DVec2::new(2.0 * px.x / size.x - 1.0, 1.0 - 2.0 * px.y / size.y);
    let max_for_image_px = MAX_RADIUS_FRACTION * size.y.min(size.x);
    // Brightness of the sprite's central pixel relative to white.
    let peak = flux.max_element() / stretch.max(1.0) * point_peak() / white;
    let max_radius_px = max_for_image_px.max(ALWAYS_ALLOWED_RADIUS_PX).min(image.distance_from_circle_px(pixel));
    let radius_px = radius_px_at(peak).min(max_radius_px).max(MIN_POINT_RADIUS_PX);
    let wraps = image.projection == Projection::Equirectangular;
    let sprite_at = |px: DVec2, radius_px: f64, stretch: f64| ProjectedSprite {
        centre: narrow(clip_of(px).extend(f64::from(centre.z))),
        radius_px: narrow_scalar(radius_px),
        stretch: narrow_scalar(stretch),
        flux: narrow(flux),
        pixels_per_face_pixel: narrow_scalar(pixels_per_face_pixel),
    };
    let cos_latitude = direction.x.hypot(direction.z);
    if wraps && cos_latitude < POLAR_COS_LATITUDE {
        // The geometric mean of the angles that a pixel of the face covers along the radius and across it.
        let radians_per_face_px = camera.pixel_tangent() * cos_off_axis.powf(1.5);
        // Distance from the sprite's centre to the edge of the face's frame, beyond which the sprite would be cut off.
        let to_edge_px = (1.0 - f64::from(centre.x.abs().max(centre.y.abs()))) * camera.half_size_px().min_element();
        let in_face_px = (radius_px * image.radians_per_pixel().y / radians_per_face_px).min(to_edge_px).max(MIN_POINT_RADIUS_PX);
        return Drawn::InFace { radius_px: narrow_scalar(in_face_px), for_picking: sprite_at(pixel, 0.0, 1.0) };
    }
    let stretch = stretch.min(0.5 * size.x / radius_px).max(1.0);
    let mut sprites = Vec::new();
    for shift_px in [0.0, -size.x, size.x] {
        let x = pixel.x + shift_px;
        let half_width_px = radius_px * stretch;
        let is_inside = x + half_width_px > 0.0 && x - half_width_px < size.x;
        if is_inside && (wraps || shift_px == 0.0) {
            sprites.push(sprite_at(DVec2::new(x, pixel.y), radius_px, stretch));
        }
    }
    Drawn::InImage(sprites)
}

/// Divides the stars of a face. Stars that the face draws are in the image's list, too, with radius 0, so that they can be picked. `earlier_stars`: the stars
/// of the faces before this one. Because of rounding, the clip position of a star on the edge of two faces may be outside each of the faces. Therefore the
/// first face takes such a star, and the second skips it. `white`: the radiance that is shown as white.
pub(crate) fn stars(
    image: &SphereImage,
    face: usize,
    camera: &Camera,
    face_stars: &[StarSprite],
    earlier_stars: &[StarSprite],
    white: f64,
) -> DividedSprites<StarSprite> {
    let mut divided = DividedSprites { in_face: Vec::new(), in_image: Vec::new() };
    for s in face_stars {
        // Distance from the edge of the face in half sides of the face; the frame may be wider than the face.
        let edge_distance = (1.0 - (s.centre.truncate().abs().as_dvec2() * camera.tan_half_fov).max_element()).abs();
        // The tolerance is wider than that of `is_on_edge`, so that every star which an earlier face took as on its edge is recognised.
        if s.star.is_some() && edge_distance < 10.0 * EDGE_WIDTH && earlier_stars.iter().any(|e| e.star == s.star) {
            continue;
        }
        let is_on_edge = s.star.is_some() && edge_distance < EDGE_WIDTH;
        let in_image =
            |ProjectedSprite { centre, radius_px, stretch, flux, .. }| StarSprite { centre, radius_px, stretch, flux, star: s.star };
        match project(image, camera, (s.centre, s.flux), white, point_radius_px, |direction| is_on_edge || face_of(direction) == face) {
            Drawn::InImage(sprites) => divided.in_image.extend(sprites.into_iter().map(in_image)),
            Drawn::InFace { radius_px, for_picking } => {
                divided.in_face.push(StarSprite { radius_px, ..*s });
                divided.in_image.push(in_image(for_picking));
            }
        }
    }
    divided
}

/// Divides the points of a face. The face of a point follows from its body's position in f64, because the rounded clip position of a point on the edge of two
/// faces may be outside each of them.
pub(crate) fn points(
    image: &SphereImage,
    face: usize,
    camera: &Camera,
    face_points: &[Point],
    bodies: &[BodyReport],
    white: f64,
) -> DividedSprites<Point> {
    let mut divided = DividedSprites { in_face: Vec::new(), in_image: Vec::new() };
    for p in face_points {
        let centre_km = bodies.iter().find(|b| b.id == p.body).map(|b| image.in_axes(b.placement.centre_km));
        // The glare of a disc keeps its radius: pixels of the face are about as wide as those of the image.
        let radius_px = |peak: f64| if p.is_disc_glare() { f64::from(p.radius_px) } else { point_radius_px(peak) };
        let is_in_face = |direction: DVec3| face_of(centre_km.unwrap_or(direction)) == face;
        match project(image, camera, (p.centre, p.flux), white, radius_px, is_in_face) {
            Drawn::InImage(sprites) => divided.in_image.extend(sprites.into_iter().map(|s| Point {
                body: p.body,
                centre: s.centre,
                radius_px: s.radius_px,
                stretch: s.stretch,
                flux: s.flux,
                covered_px: p.covered_px * s.pixels_per_face_pixel,
                // Half the height, as `radius_px`: `stretch` widens both.
                disc_radius_px: p.disc_radius_px * (s.pixels_per_face_pixel / s.stretch).sqrt(),
            })),
            Drawn::InFace { radius_px, .. } => divided.in_face.push(Point { radius_px, ..p.clone() }),
        }
    }
    divided
}
