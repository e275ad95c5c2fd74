//! Stereo pairs: two cameras side by side with parallel axes. *Parallax* here is the column of a point in the right eye's image minus that in the left eye's:
//! zero at the target's distance, negative (crossed) for nearer points, positive (uncrossed) for farther points.
//!
//! In: a request without its composition, and the stereo pair. Out: a frame for each eye. The off-axis frusta that the parallax requires are cut out of wider
//! symmetric frames: each frame is wider than its image by the parallax of infinity, a whole number of pixels, and the image starts at one of the frame's
//! columns. Always: no vertical parallax. The parallax of the target is exactly zero with the default separation, which is chosen for a whole number of pixels
//! at infinity. With a given separation or that of human eyes the parallax of infinity is rounded, and the target's is zero to within half a pixel.

use super::arrangement::{Arrangement, CompositeFrames, Eyes, FrameRequest};
use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::scene::camera::viewpoint::{self, Viewer};
use crate::scene::error::SceneError;
use crate::scene::request::Stereo;
use crate::scene::request::layers::Layers;
use crate::scene::request::view_request::{Position, ViewRequest};
use crate::units::KM_PER_AU;
use glam::DVec3;

/// Default parallax of infinity relative to the image's width: viewers fuse a parallax of a few hundredths without effort.
const INFINITY_PARALLAX_FRACTION: f64 = 1.0 / 30.0;
/// The mean distance between human eyes, kilometres (63 mm: Dodgson 2004, SPIE 5291, 36).
const HUMAN_EYE_SEPARATION_KM: f64 = 63e-6;

/// The frames of a stereo pair. `without_composition`: the request without its composition.
pub(super) fn frames(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    without_composition: &ViewRequest,
    stereo: Stereo,
) -> Result<CompositeFrames, SceneError> {
    // `Composite::new` adds caption, scale bar and compass, at the same position for both eyes.
    let layers = Layers { caption: false, scale_bar: false, compass: false, ..without_composition.layers };
    let mut request = ViewRequest { layers, ..without_composition.clone() };
    request.width = stereo.eye_width_px(request.width);
    let stands_on_ground = matches!(request.position, Position::Ground { .. });
    let viewer = viewpoint::viewer(catalog, ephemeris, &request)?;
    let distance_km = target_distance_km(ephemeris, &request, &viewer)?;
    // Width of a pixel at the target's distance.
    let pixel_km = distance_km * viewer.camera.pixel_tangent();
    let (separation_km, infinity_parallax_px) = match stereo.eye_separation_km {
        None if !stands_on_ground => {
            let infinity_parallax_px = (f64::from(request.width) * INFINITY_PARALLAX_FRACTION).round().max(1.0);
            (infinity_parallax_px * pixel_km, infinity_parallax_px)
        }
        // Without a given separation the camera is on the ground, and the eyes are a person's.
        given => {
            let separation_km = given.unwrap_or(HUMAN_EYE_SEPARATION_KM);
            (separation_km, (separation_km / pixel_km).round())
        }
    };
    // At infinity the eyes' images must have at least half of their columns in common.
    let max_parallax_px = f64::from(request.width / 2);
    if infinity_parallax_px > max_parallax_px {
        // Rounding accepts almost half a pixel more than the maximum, which is 0 for an image 1 pixel wide.
        let max_separation_km = (max_parallax_px + 0.49) * pixel_km;
        let infinity_text =
            if infinity_parallax_px < 1e6 { format!("{infinity_parallax_px:.0}") } else { format!("{infinity_parallax_px:.1e}") };
        return Err(SceneError::Request(format!(
            "eyes {separation_km:?} km apart see the stars {infinity_text} pixels apart, more than half the width of each eye's image: \
             choose at most {max_separation_km:.6e} km"
        )));
    }
    // The cast is exact: `infinity_parallax_px` is a whole number of at most half the image's width.
    let infinity_parallax_columns = infinity_parallax_px as u32;
    // `side`: -1 for the left eye, 1 for the right eye.
    let eye = |side: f64| {
        let mut viewer = viewer.clone();
        let camera = &mut viewer.camera;
        camera.position_km += camera.right * (0.5 * side * separation_km);
        let width = request.width + infinity_parallax_columns;
        camera.tan_half_fov.x *= f64::from(width) / f64::from(request.width);
        camera.width = width;
        FrameRequest { request: ViewRequest { width, ..request.clone() }, viewer }
    };
    let frames = vec![eye(-1.0), eye(1.0)];
    // The left eye's image is the right end of its frame, the right eye's image the left end of its frame.
    let arrangement = Arrangement::Eyes(Eyes { layout: stereo.layout, separation_km, first_columns: [infinity_parallax_columns, 0] });
    // The view between the eyes is metered, for the exposure of both.
    Ok(CompositeFrames { meter: FrameRequest { request, viewer }, frames, arrangement })
}

/// Distance from the camera to the target's centre: apparent, unless the camera stands on the target. It is clamped to the range from 1 mm to 1e9 au, so that
/// values divided by it are finite.
fn target_distance_km(ephemeris: &Ephemeris, request: &ViewRequest, viewer: &Viewer) -> Result<f64, SceneError> {
    let target = request.target.ok_or_else(|| SceneError::Request("stereo needs a target, at whose distance both images agree".into()))?;
    let target_centre_km: DVec3 = match viewer.stands_on {
        Some(ground) if ground.id == target => ground.centre_km,
        _ => {
            let (position_at_emission_km, _emission_time) =
                ephemeris.light_time_position(target, viewer.camera.position_km, request.time)?;
            position_at_emission_km
        }
    };
    // The distance is 0 if the camera is at the target's centre: `viewpoint::viewer` rejects this only if the camera looks at the target.
    Ok((target_centre_km - viewer.camera.position_km).length().clamp(1e-6, 1e9 * KM_PER_AU))
}
