//! Dome images and whole-sphere images: the faces of a cube around the camera. Each face is a perspective frame with a field of view of 90 degrees and a
//! border.
//!
//! In: a request for a fisheye or an equirectangular image. Out: frames for the visible faces, and the image's projection. The border lets the bilinear
//! filter of shaders/lib/cube_faces.wesl read pixels beyond the face's edge. The Sun's glare depends on the direction alone: all faces, and the light
//! meter, take it for the directions that the entire image shows (`Camera::composed_cone`).
//!
//! Size of a face. A face has the fewest pixels per radian at its centre: there it gets as many as the densest part of the image. For an equirectangular
//! image this is the equator. A fisheye has the same density everywhere along its radii. Along circles around its axis the density grows with the angle from
//! the axis, without limit towards 180 degrees, so only the circles up to 90 degrees count. A face that would be larger than [`MAX_FACE_PX_FOR_CIRCLES`] gets
//! that size, or the size that matches the fisheye's density along its radii if this is larger.

use super::arrangement::{Arrangement, CompositeFrames, Faces, FrameRequest};
use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::scene::camera::sphere::SphereImage;
use crate::scene::camera::viewpoint::{self, Viewer};
use crate::scene::camera::{Camera, ComposedCone};
use crate::scene::error::SceneError;
use crate::scene::request::composition::DEFAULT_FISHEYE_DEG;
use crate::scene::request::layers::Layers;
use crate::scene::request::view_request::{MAX_IMAGE_PX, ViewRequest};
use crate::scene::request::{Composition, Projection};
use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_4, PI};

/// Largest size of a face, in pixels, that is chosen to match a fisheye's pixels per radian along circles around its axis; see the module's documentation.
const MAX_FACE_PX_FOR_CIRCLES: u32 = 4096;
/// Maximum size of a face, in pixels: with its border the frame is no larger than the largest image. It is even, as the sizes of all faces are.
const MAX_FACE_PX: u32 = MAX_IMAGE_PX - 2 * BORDER_PX;
/// Border of a face on each side, in pixels; the bilinear filter reads one pixel beyond the edge.
pub(crate) const BORDER_PX: u32 = 2;
/// Minimum size of a face, in pixels.
const MIN_FACE_PX: u32 = 16;

/// Right, up and forward of each face in the image's axes. The image's axes (x right, y up, z forward) are left-handed: in them right x up = forward, whereas
/// in ICRF right x up = -forward, unless the image is mirrored. Order of the faces: front, right, back, left, up, down.
pub(crate) const FACE_AXES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::Y, DVec3::Z],
    [DVec3::NEG_Z, DVec3::Y, DVec3::X],
    [DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z],
    [DVec3::Z, DVec3::Y, DVec3::NEG_X],
    [DVec3::X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::X, DVec3::Z, DVec3::NEG_Y],
];

/// The face that contains a direction in the image's axes: the face whose axis is nearest. Ties are broken as in
/// shaders/lib/cube_faces.wesl.
pub(crate) fn face_of(direction: DVec3) -> usize {
    let a = direction.abs();
    if a.z >= a.x && a.z >= a.y {
        if direction.z >= 0.0 { 0 } else { 2 }
    } else if a.x >= a.y {
        if direction.x >= 0.0 { 1 } else { 3 }
    } else if direction.y >= 0.0 {
        4
    } else {
        5
    }
}

/// Number of cells along each side of the grid that samples a face to find its visible part.
const GRID_CELLS: u32 = 32;

/// Bounds (left, top, right, bottom) of the part of a face that a fisheye shows: the directions at most `half_fov_rad` from the image's axis, a cap of the
/// sphere. They are fractions of the face's side from its top left corner; `None` if the face is outside the cap.
fn visible_bounds(face: usize, half_fov_rad: f64) -> Option<[f64; 4]> {
    let [right, up, forward] = FACE_AXES[face];
    let step = 1.0 / f64::from(GRID_CELLS);
    // The boundary of the cap can lie between two grid points, which are at most 2 / GRID_CELLS radians apart: a face is 2 wide at the distance 1.
    let widened_half_fov_rad = half_fov_rad + 2.0 * step;
    let mut bounds: Option<[f64; 4]> = None;
    for (i, j) in (0..=GRID_CELLS).flat_map(|j| (0..=GRID_CELLS).map(move |i| (i, j))) {
        let (s, t) = (f64::from(i) * step, f64::from(j) * step);
        let direction = (right * (2.0 * s - 1.0) + up * (1.0 - 2.0 * t) + forward).normalize();
        if direction.truncate().length().atan2(direction.z) <= widened_half_fov_rad {
            let p = bounds.get_or_insert([s, t, s, t]);
            *p = [p[0].min(s - step), p[1].min(t - step), p[2].max(s + step), p[3].max(t + step)];
        }
    }
    bounds.map(|p| p.map(|v| v.clamp(0.0, 1.0)))
}

/// Size of a face before rounding, in pixels (see the module's documentation). At its centre a face of 2 n pixels has n per radian.
fn exact_face_size_px(image: &SphereImage) -> f64 {
    let for_densest_px = 2.0 * image.densest_pixels_per_radian();
    // In a fisheye the radians per pixel are those along its radii.
    let for_radii_px = 2.0 / image.radians_per_pixel().min_element();
    for_densest_px.min(for_radii_px.max(f64::from(MAX_FACE_PX_FOR_CIRCLES)))
}

/// Size of a face, in pixels. An equirectangular image of the largest size, 16384 by 16384, needs 10432, so only a fisheye can need more than [`MAX_FACE_PX`].
fn face_size_px(image: &SphereImage) -> u32 {
    (exact_face_size_px(image).ceil() as u32).max(MIN_FACE_PX).next_multiple_of(2)
}

/// For a fisheye whose faces would be larger than [`MAX_FACE_PX`]: the least field of view, for an image of the same size, at which they fit. In degrees,
/// rounded up to a tenth.
fn least_fov_deg(image: &SphereImage) -> f64 {
    // Such large faces match the pixels per radian along the radii (`exact_face_size_px`), so their size is inversely proportional to the field of view.
    let exact_deg = 2.0 * image.half_fov_rad.to_degrees() * exact_face_size_px(image) / f64::from(MAX_FACE_PX);
    // The factor allows for rounding errors: without it, the faces at a result that is exactly a multiple of a tenth might need one more pixel.
    (10.0 * exact_deg * (1.0 + 1e-12)).ceil() / 10.0
}

/// The frames of a dome image or a whole-sphere image. `without_composition`: the request without its composition.
pub(super) fn frames(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    request: &ViewRequest,
    without_composition: ViewRequest,
) -> Result<CompositeFrames, SceneError> {
    let composition = &request.composition;
    let fov_deg = request.fov_deg.unwrap_or(DEFAULT_FISHEYE_DEG);
    // The viewer's camera is a perspective one, to which the field of view of the fisheye does not apply.
    let viewer = viewpoint::viewer(catalog, ephemeris, &ViewRequest { fov_deg: None, ..without_composition.clone() })?;
    let [right, up, forward] = image_axes(composition, &viewer);
    let (width, height) = (request.width, request.height);
    let half_fov_rad = fov_deg.to_radians() / 2.0;
    let image = SphereImage { right, up, forward, projection: composition.projection, half_fov_rad, width, height };
    let face_px = face_size_px(&image);
    let frame_px = face_px + 2 * BORDER_PX;
    if face_px > MAX_FACE_PX {
        // Only for a fisheye: see `face_size_px`.
        let least_deg = least_fov_deg(&image);
        return Err(SceneError::Request(format!(
            "field of view {fov_deg}: a fisheye of {width}x{height} pixels shows {least_deg} to 360 degrees; choose a smaller image, or --projection perspective"
        )));
    }
    // `Composite::new` adds these layers to the combined image, except the outline, which such images lack.
    let layers = Layers {
        labels: false,
        features: false,
        caption: false,
        scale_bar: false,
        compass: false,
        outline: false,
        bloom: false,
        ..without_composition.layers
    };
    let face_request = ViewRequest { width: frame_px, height: frame_px, fov_deg: None, layers, ..without_composition };
    // An equirectangular image shows all directions.
    let half_angle_rad = if composition.projection == Projection::Fisheye { half_fov_rad } else { PI };
    let composed_cone = Some(ComposedCone { axis: forward, half_angle_rad });
    let in_icrf = |v: DVec3| right * v.x + up * v.y + forward * v.z;
    let camera = |[right, up, forward]: [DVec3; 3], tan_half_fov: f64, side_px: u32| Camera {
        right: in_icrf(right),
        up: in_icrf(up),
        forward: in_icrf(forward),
        tan_half_fov: DVec2::splat(tan_half_fov),
        width: side_px,
        height: side_px,
        is_cube_face: true,
        composed_cone,
        limits_sprite_size: true,
        ..viewer.camera.clone()
    };
    let (mut frames, mut visible_rects, mut frame_of_face) = (Vec::new(), Vec::new(), [None; 6]);
    let border = f64::from(BORDER_PX);
    for (face, axes) in FACE_AXES.into_iter().enumerate() {
        let bounds = match composition.projection {
            Projection::Fisheye => visible_bounds(face, half_fov_rad),
            // An equirectangular image shows every face as a whole.
            _ => Some([0.0, 0.0, 1.0, 1.0]),
        };
        let Some([x0, y0, x1, y1]) = bounds else { continue };
        // The rectangle of the visible part in pixels of the frame, which are pixels of the face plus one border. The filter that reads the face widens the
        // rectangle by one border on each side: at the start the two borders cancel, at the end they add up.
        let side_px = f64::from(face_px);
        let first_px = |fraction: f64| (fraction * side_px).floor().max(0.0) as u32;
        let end_px = |fraction: f64| ((fraction * side_px + 2.0 * border).ceil() as u32).min(frame_px);
        visible_rects.push([first_px(x0), first_px(y0), end_px(x1), end_px(y1)]);
        frame_of_face[face] = Some(frames.len());
        let tan_half_fov = f64::from(frame_px) / side_px;
        let viewer = Viewer { camera: camera(axes, tan_half_fov, frame_px), ..viewer.clone() };
        frames.push(FrameRequest { request: face_request.clone(), viewer });
    }
    // The light meter sees the middle of the image, at most the front face. Its camera is not marked as a cube face, but has the glare of the entire image.
    let meter_half_fov_rad = if composition.projection == Projection::Fisheye { half_fov_rad.min(FRAC_PI_4) } else { FRAC_PI_4 };
    let meter_camera = Camera { is_cube_face: false, ..camera(FACE_AXES[0], meter_half_fov_rad.tan(), frame_px) };
    let meter = FrameRequest { request: face_request, viewer: Viewer { camera: meter_camera, ..viewer } };
    Ok(CompositeFrames { meter, frames, arrangement: Arrangement::Faces(Faces { image, frame_of_face, face_px, visible_rects }) })
}

/// Right, up and forward axes of the image, ICRF. The middle of a fisheye is the line of sight or, if it is centred on the zenith, the view's up direction. An
/// equirectangular image is level: its poles are the view's up and down directions, and the target is in its middle column.
fn image_axes(composition: &Composition, viewer: &Viewer) -> [DVec3; 3] {
    let camera = &viewer.camera;
    // An up direction along the line of sight is replaced by the camera's own.
    let up_hint = viewer.up_hint.try_normalize().filter(|up| up.cross(camera.forward).length() > 1e-9).unwrap_or(camera.up);
    let horizontal = (camera.forward - up_hint * camera.forward.dot(up_hint)).normalize();
    let [up, forward] = match (composition.projection, composition.is_zenith_centred) {
        (Projection::Equirectangular, _) => [up_hint, horizontal],
        // The target's side of the horizon is at the bottom of the image.
        (_, true) => [-horizontal, up_hint],
        _ => [camera.up, camera.forward],
    };
    let axis = forward.cross(up);
    // A positive tilt lowers the direction in the image's middle towards the image's bottom.
    let tilt = DQuat::from_axis_angle(axis, -composition.tilt_deg.to_radians());
    [if camera.is_mirrored() { -axis } else { axis }, tilt * up, tilt * forward]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::GOLDEN_ANGLE_RAD;

    /// The axes of each face are left-handed as those of the image, and each direction is inside the face that [`face_of`] returns: within 45 degrees of the
    /// face's axis horizontally and vertically.
    #[test]
    fn the_faces_cover_the_sphere() {
        for [right, up, forward] in FACE_AXES {
            assert_eq!(right.cross(up), forward);
        }
        for k in 0..10_000 {
            let (z, azimuth) = (1.0 - 2.0 * (f64::from(k) + 0.5) / 1e4, f64::from(k) * GOLDEN_ANGLE_RAD);
            let across = (1.0 - z * z).sqrt();
            let direction = DVec3::new(across * azimuth.cos(), across * azimuth.sin(), z);
            let [right, up, forward] = FACE_AXES[face_of(direction)];
            let depth = direction.dot(forward);
            assert!(depth > 0.0 && direction.dot(right).abs() <= depth && direction.dot(up).abs() <= depth, "{direction}");
        }
    }

    /// If a field of view is refused because its faces would be too large, the suggested one is the least that is accepted, in tenths of a degree.
    #[test]
    fn the_suggested_field_of_view_is_the_least_that_fits() {
        let fisheye = |side_px: u32, fov_deg: f64| SphereImage {
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::Z,
            projection: Projection::Fisheye,
            half_fov_rad: fov_deg.to_radians() / 2.0,
            width: side_px,
            height: side_px,
        };
        let is_refused = |side_px: u32, fov_deg: f64| face_size_px(&fisheye(side_px, fov_deg)) > MAX_FACE_PX;
        let mut refused = 0;
        for side_px in (1..=MAX_IMAGE_PX).step_by(37).chain([MAX_IMAGE_PX]) {
            for fov_deg in (0..40).map(|k| 1.0 + 3.1 * f64::from(k)).filter(|fov_deg| is_refused(side_px, *fov_deg)) {
                let least_deg = least_fov_deg(&fisheye(side_px, fov_deg));
                assert!(!is_refused(side_px, least_deg), "{side_px} pixels, {fov_deg} degrees: {least_deg} is refused, too");
                assert!(is_refused(side_px, least_deg - 0.1), "{side_px} pixels, {fov_deg} degrees: less than {least_deg} fits");
                refused += 1;
            }
        }
        assert!(refused > 1000, "{refused}");
        // In the largest image, half the field of view must be at least MAX_IMAGE_PX / MAX_FACE_PX = 1.0002 radians.
        assert_eq!(least_fov_deg(&fisheye(MAX_IMAGE_PX, 1.0)), 114.7);
    }

    /// Every direction inside a cap is in the visible bounds of its face, and a narrow cap needs the front face only.
    #[test]
    fn visible_bounds_contain_all_that_a_fisheye_shows() {
        // Number of visible faces: the front face alone up to 45 degrees less the margin of 2 / GRID_CELLS radians; the back face, whose corners are 125
        // degrees from the image's axis, from 125 degrees less the margin.
        for (half_deg, faces) in [(10.0, 1), (40.0, 1), (90.0, 5), (110.0, 5), (140.0, 6), (180.0, 6)] {
            let half = f64::to_radians(half_deg);
            let bounds: Vec<_> = (0..6).map(|f| visible_bounds(f, half)).collect();
            assert_eq!(bounds.iter().flatten().count(), faces, "{half_deg}");
            for k in 0..20_000 {
                let (angle, azimuth) = (half * (f64::from(k % 200) + 0.5) / 200.0, f64::from(k) * 0.314_159);
                let direction = DVec3::new(angle.sin() * azimuth.cos(), angle.sin() * azimuth.sin(), angle.cos());
                let face = face_of(direction);
                let [right, up, forward] = FACE_AXES[face];
                let (right_tan, up_tan) = (direction.dot(right) / direction.dot(forward), direction.dot(up) / direction.dot(forward));
                let [x0, y0, x1, y1] = bounds[face].expect("a visible face");
                let (x, y) = (0.5 + 0.5 * right_tan, 0.5 - 0.5 * up_tan);
                assert!(x0 <= x && x <= x1 && y0 <= y && y <= y1, "{half_deg}: {direction}");
            }
        }
    }
}
