//! The mapping between directions and pixels of a finished image: perspective, fisheye, entire sphere or stereo pair; all but the stereo pair also on a warp
//! mesh.
//!
//! In: ICRF directions, pixels of the finished image. Out: the pixel of a direction, and the direction of a pixel. Always: `ImageGeometry::direction` and
//! [`ImageGeometry::pixel_of`] are inverse to each other within the image; for a stereo pair, both use the left eye's image.

use super::Camera;
use super::sphere::{ImageProjection, SphereImage};
use crate::message::Message;
use crate::scene::request::composition::Projection;
use crate::scene::request::warp_mesh::WarpMesh;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// How a finished image shows directions.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ImageGeometry {
    /// The perspective of the scene's camera.
    #[default]
    Perspective,
    /// A fisheye or an equirectangular image.
    Sphere(SphereImage),
    /// A stereo pair; the scene's camera is that of the left eye.
    Stereo(StereoGeometry),
    /// A perspective image, a fisheye or an equirectangular image, drawn on a warp mesh.
    Warped(WarpedGeometry),
}

/// The columns of the left eye's rendered frame that the finished image keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StereoGeometry {
    /// The first column that is kept.
    pub left_column: u32,
    /// Width of one eye's part of the finished image, pixels: half of a side-by-side pair, the whole of an overlaid one.
    pub width: u32,
    /// Whether the eyes' images are side by side; otherwise they are overlaid.
    pub is_side_by_side: bool,
}

/// The image that is cut out of the left eye's frame.
struct LeftEyeImage<'a> {
    camera: &'a Camera,
    geometry: StereoGeometry,
}

impl LeftEyeImage<'_> {
    /// Position of the image's left edge in the frame.
    fn left_edge_px(&self) -> DVec2 {
        DVec2::new(f64::from(self.geometry.left_column), 0.0)
    }
}

impl ImageProjection for LeftEyeImage<'_> {
    fn pixel_of(&self, direction: DVec3) -> Option<DVec2> {
        self.camera.pixel_of(direction).map(|px| px - self.left_edge_px())
    }
    fn direction_of(&self, pixel: DVec2) -> Option<DVec3> {
        self.camera.direction_of(pixel + self.left_edge_px())
    }
    fn size_px(&self) -> DVec2 {
        DVec2::new(f64::from(self.geometry.width), f64::from(self.camera.height))
    }
    fn disc_radius_px(&self, angular_radius_rad: f64) -> f64 {
        self.camera.disc_radius_px(angular_radius_rad)
    }
    fn scale_distance_km(&self, to_point_km: DVec3) -> f64 {
        self.camera.scale_distance_km(to_point_km)
    }
    fn field_of_view_text(&self) -> Message {
        self.camera.field_of_view_text()
    }
}

/// An image on a warp mesh. Here *image* is what the mesh shows, and *screen* the finished image, which the projector shows. The mapping and its inverse use
/// the triangles that the renderer draws, so that labels and markers match the drawn image.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpedGeometry {
    /// How the image on the mesh shows directions.
    pub image: Box<ImageGeometry>,
    /// Width and height of the image, before the mesh is applied.
    pub image_px: [u32; 2],
    /// The mesh.
    pub mesh: Arc<WarpMesh>,
    /// Width and height of the screen.
    pub screen_px: [u32; 2],
}

impl WarpedGeometry {
    /// The screen pixel that shows a pixel of the image; `None` if no screen pixel does. If several do, the first triangle of the mesh decides.
    pub(crate) fn screen_of_image(&self, pixel: DVec2) -> Option<DVec2> {
        // The mesh maps image positions, 0 to 1 from the lower left corner, to screen positions in half heights from the middle, y upwards.
        let position = pixel / size(self.image_px);
        let on_screen = self.mesh.screen_of_image(DVec2::new(position.x, 1.0 - position.y))?;
        let screen = size(self.screen_px);
        Some(DVec2::new(0.5 * screen.x + 0.5 * screen.y * on_screen.x, 0.5 * screen.y * (1.0 - on_screen.y)))
    }

    /// The pixel of the image that a screen pixel shows; `None` outside the mesh.
    pub(crate) fn image_of_screen(&self, pixel: DVec2) -> Option<DVec2> {
        let screen = size(self.screen_px);
        let on_screen = (pixel - 0.5 * screen) / (0.5 * screen.y);
        let position = self.mesh.image_of_screen(DVec2::new(on_screen.x, -on_screen.y))?;
        Some(DVec2::new(position.x, 1.0 - position.y) * size(self.image_px))
    }

    /// Pixels of the screen per pixel of the image, for a mesh on which the image fills the screen's height; an approximation for any other.
    pub(crate) fn scale(&self) -> f64 {
        f64::from(self.screen_px[1]) / f64::from(self.image_px[1])
    }
}

/// A size in whole pixels as a vector.
fn size([width, height]: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(width), f64::from(height))
}

/// An image on a warp mesh, with the camera of its perspective image.
struct WarpedImage<'a> {
    camera: &'a Camera,
    geometry: &'a WarpedGeometry,
}

impl ImageProjection for WarpedImage<'_> {
    fn pixel_of(&self, direction: DVec3) -> Option<DVec2> {
        self.geometry.image.pixel_of(self.camera, direction).and_then(|px| self.geometry.screen_of_image(px))
    }
    fn direction_of(&self, pixel: DVec2) -> Option<DVec3> {
        self.geometry.image.direction(self.camera, self.geometry.image_of_screen(pixel)?)
    }
    fn size_px(&self) -> DVec2 {
        DVec2::from_array(self.geometry.screen_px.map(f64::from))
    }
    fn disc_radius_px(&self, angular_radius_rad: f64) -> f64 {
        self.geometry.image.projection(self.camera).disc_radius_px(angular_radius_rad) * self.geometry.scale()
    }
    fn scale_distance_km(&self, to_point_km: DVec3) -> f64 {
        self.geometry.image.projection(self.camera).scale_distance_km(to_point_km)
    }
    fn field_of_view_text(&self) -> Message {
        self.geometry.image.projection(self.camera).field_of_view_text()
    }
}

impl ImageGeometry {
    /// The projection by which labels and markers are placed.
    pub(crate) fn projection<'a>(&'a self, camera: &'a Camera) -> Box<dyn ImageProjection + 'a> {
        match self {
            Self::Perspective => Box::new(camera.clone()),
            Self::Sphere(image) => Box::new(image.clone()),
            Self::Stereo(geometry) => Box::new(LeftEyeImage { camera, geometry: *geometry }),
            Self::Warped(geometry) => Box::new(WarpedImage { camera, geometry }),
        }
    }

    /// The pixel that shows an ICRF direction; in a side-by-side pair, the pixel in the left half. `None` if the image cannot show the direction.
    pub fn pixel_of(&self, camera: &Camera, direction: DVec3) -> Option<DVec2> {
        self.projection(camera).pixel_of(direction)
    }

    /// The ICRF direction that a pixel shows, a unit vector; `None` outside a fisheye's circle or a mesh.
    pub fn direction(&self, camera: &Camera, pixel: DVec2) -> Option<DVec3> {
        match self {
            Self::Perspective => camera.direction_of(pixel),
            Self::Sphere(image) => image.direction_of(pixel),
            Self::Stereo(geometry) => LeftEyeImage { camera, geometry: *geometry }.direction_of(self.left_eye_px(pixel)),
            Self::Warped(geometry) => WarpedImage { camera, geometry }.direction_of(pixel),
        }
    }

    /// Whether the left edge of the image continues the right edge, as in an equirectangular image. False for one on a warp mesh, because planning asks only
    /// about the image before the mesh is applied.
    pub(crate) fn is_periodic(&self) -> bool {
        matches!(self, Self::Sphere(image) if image.projection == Projection::Equirectangular)
    }

    /// Whether a short arc between two ICRF directions leaves the image at one edge and continues at the opposite edge: at the left and right edges of an
    /// equirectangular image, or at the circle of a fisheye of 360 degrees; also if the image is drawn on a mesh.
    #[cfg(any(feature = "view", test))]
    pub(crate) fn is_cut_between(&self, from: DVec3, to: DVec3) -> bool {
        match self {
            Self::Warped(geometry) => geometry.image.is_cut_between(from, to),
            Self::Sphere(image) => image.pixel_of(from).zip(image.pixel_of(to)).is_some_and(|(a, b)| {
                // Beside a pole of an equirectangular image, a short arc that is not cut may span 180 degrees of longitude.
                if self.is_periodic() {
                    (a.x - b.x).abs() > 0.5 * image.size_px().x
                } else {
                    a.distance(b) > 0.5 * image.size_px().min_element()
                }
            }),
            Self::Perspective | Self::Stereo(_) => false,
        }
    }

    /// The pixel at which a point sprite (such as a star) of the scene's frame appears in the image, before a mesh moves it to the screen. `clip`: the sprite's
    /// clip coordinates in the frame.
    pub(crate) fn sprite_px(&self, camera: &Camera, clip: DVec2) -> DVec2 {
        let px = camera.pixel_from_clip(clip);
        match self {
            // The sprites of a fisheye or an equirectangular image are placed in the finished image.
            Self::Perspective | Self::Sphere(_) => px,
            Self::Stereo(geometry) => px - LeftEyeImage { camera, geometry: *geometry }.left_edge_px(),
            Self::Warped(geometry) => geometry.image.sprite_px(camera, clip),
        }
    }

    /// The pixel of the image that a screen pixel shows: the same pixel without a mesh, `None` outside a mesh.
    pub(crate) fn image_of_screen(&self, pixel: DVec2) -> Option<DVec2> {
        if let Self::Warped(geometry) = self { geometry.image_of_screen(pixel) } else { Some(pixel) }
    }

    /// The screen pixel that shows a pixel of the image: the same pixel without a mesh, `None` if the mesh does not show it.
    pub(crate) fn screen_of_image(&self, pixel: DVec2) -> Option<DVec2> {
        if let Self::Warped(geometry) = self { geometry.screen_of_image(pixel) } else { Some(pixel) }
    }

    /// Maps a pixel in the right half of a side-by-side pair to the same position in the left half; other pixels are unchanged.
    pub(crate) fn left_eye_px(&self, pixel: DVec2) -> DVec2 {
        match self {
            Self::Stereo(StereoGeometry { width, is_side_by_side: true, .. }) if pixel.x >= f64::from(*width) => {
                pixel - DVec2::new(f64::from(*width), 0.0)
            }
            _ => pixel,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(width: u32, height: u32) -> Camera {
        Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0, width, height)
    }

    /// A mesh that bends and shears the image on a screen of the same size; it covers all but the screen's corners.
    fn warped() -> ImageGeometry {
        // A mesh file: the type 2, the numbers of nodes across and up; for each node x and y on the screen (in half heights), u and v in the image, brightness.
        let mut text = "2\n7 5\n".to_owned();
        for (row, column) in (0..5).flat_map(|r| (0..7).map(move |c| (r, c))) {
            let (u, v) = (f64::from(column) / 6.0, f64::from(row) / 4.0);
            let (x, y) = (3.0 * u - 1.5, 2.0 * v - 1.0);
            text.push_str(&format!("{} {} {u} {v} 1\n", x + 0.2 * y - 0.1 * x * y * y, 1.05 * y - 0.06 * x * x * y));
        }
        let mesh = Arc::new(WarpMesh::parse("m", &text).expect("a mesh"));
        ImageGeometry::Warped(WarpedGeometry { image: Box::default(), image_px: [90, 60], mesh, screen_px: [90, 60] })
    }

    /// An undistorted mesh on a screen of twice the image's size.
    #[test]
    fn an_undistorted_mesh_scales_the_image() {
        let mesh = Arc::new(WarpMesh::parse("m", "2\n2 2\n-1.5 -1 0 0 1\n1.5 -1 1 0 1\n-1.5 1 0 1 1\n1.5 1 1 1 1\n").expect("a mesh"));
        let plain = WarpedGeometry { image: Box::default(), image_px: [90, 60], mesh, screen_px: [180, 120] };
        for (x, y) in [(0.5, 0.5), (12.0, 47.0), (89.0, 3.0)] {
            let px = DVec2::new(x, y);
            let screen = plain.screen_of_image(px).expect("on the screen");
            assert!(screen.distance(2.0 * px) < 1e-9, "{px}: {screen}");
            assert!(plain.image_of_screen(screen).expect("in the image").distance(px) < 1e-9);
        }
        assert_eq!(plain.image_of_screen(DVec2::new(-1.0, 5.0)), None);
        let camera = camera(90, 60);
        let radius = |geometry: &ImageGeometry| geometry.projection(&camera).disc_radius_px(0.1);
        assert!((radius(&ImageGeometry::Warped(plain)) / radius(&ImageGeometry::Perspective) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn direction_and_pixel_are_inverse() {
        let frame_camera = camera(90, 60);
        let sphere = |projection| {
            let (right, up, forward) = (-DVec3::Y, DVec3::Z, DVec3::X);
            ImageGeometry::Sphere(SphereImage { right, up, forward, projection, half_fov_rad: 1.5, width: 90, height: 60 })
        };
        // A frame 90 pixels wide, whose right half is the left eye's image.
        let [side_by_side, overlaid] =
            [true, false].map(|is_side_by_side| ImageGeometry::Stereo(StereoGeometry { left_column: 45, width: 45, is_side_by_side }));
        for geometry in
            [ImageGeometry::Perspective, sphere(Projection::Fisheye), sphere(Projection::Equirectangular), side_by_side, overlaid, warped()]
        {
            // Number of pixels that show a direction. The fisheye's circle has the fewest: pi 30^2 = 2827 of 5400.
            let mut seen = 0;
            for (x, y) in (0..90).flat_map(|x| (0..60).map(move |y| (x, y))) {
                let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(direction) = geometry.direction(&frame_camera, pixel) else { continue };
                assert!((direction.length() - 1.0).abs() < 1e-12);
                let back = geometry.pixel_of(&frame_camera, direction).expect("in the image");
                assert!(back.distance(geometry.left_eye_px(pixel)) < 1e-7, "{geometry:?} {pixel}: {back}");
                seen += 1;
            }
            assert!(seen > 2500, "{geometry:?}: {seen}");
        }
    }

    #[test]
    fn both_halves_of_a_pair_show_one_direction_and_pixels_outside_a_fisheye_show_none() {
        let pair = ImageGeometry::Stereo(StereoGeometry { left_column: 45, width: 45, is_side_by_side: true });
        let left = DVec2::new(10.0, 20.0);
        let right = left + DVec2::new(45.0, 0.0);
        assert_eq!((pair.left_eye_px(right), pair.left_eye_px(left)), (left, left));
        assert_eq!(pair.direction(&camera(90, 60), right), pair.direction(&camera(90, 60), left));
        let (right, up, forward) = (-DVec3::Y, DVec3::Z, DVec3::X);
        let dome = SphereImage { right, up, forward, projection: Projection::Fisheye, half_fov_rad: 1.5, width: 90, height: 60 };
        assert_eq!(ImageGeometry::Sphere(dome).direction(&camera(90, 60), DVec2::ONE), None);
    }

    /// A small step is cut at the antimeridian of an equirectangular image and at the edge of a full fisheye only, both opposite to the middle.
    #[test]
    fn an_arc_is_cut_opposite_to_the_middle() {
        let sphere = |projection, half_fov_rad| {
            let (right, up, forward) = (-DVec3::Y, DVec3::Z, DVec3::X);
            ImageGeometry::Sphere(SphereImage { right, up, forward, projection, half_fov_rad, width: 90, height: 60 })
        };
        // Whether an arc of 0.02 rad is cut whose middle is `angle` to the left of the image's middle.
        let is_cut = |geometry: &ImageGeometry, angle: f64| {
            let at = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.01).normalize();
            geometry.is_cut_between(at(angle - 0.01), at(angle + 0.01))
        };
        for (geometry, cuts) in [
            (sphere(Projection::Equirectangular, std::f64::consts::PI), true),
            (sphere(Projection::Fisheye, std::f64::consts::PI), true),
            (sphere(Projection::Fisheye, 1.5), false),
            (ImageGeometry::Perspective, false),
        ] {
            assert_eq!(is_cut(&geometry, std::f64::consts::PI), cuts, "{geometry:?}");
            for angle in [0.0, 0.5, 1.6, 2.5, -2.5] {
                assert!(!is_cut(&geometry, angle), "{geometry:?} at {angle}");
            }
        }
    }
}
