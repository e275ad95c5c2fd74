//! Stereo pairs: two cameras side by side with parallel axes.
//!
//! In: a plain request and the eye separation. Out: a frame for each eye. Both look in the same direction; points at the target's distance have zero
//! parallax, nearer ones have crossed, farther ones uncrossed parallax. The off-axis frusta that this requires are parts of wider symmetric frames: each
//! frame is wider than its picture by the parallax of infinity, which is a whole number of pixels, and the picture starts at some column of it. Always: no
//! vertical parallax; the target has zero parallax, to a quarter of a pixel if the separation was given.

use super::arrangement::{Arrangement, Eyes, FrameRequest, Frames};
use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::scene::camera::viewpoint::{self, Viewer};
use crate::scene::error::SceneError;
use crate::scene::request::layers::Layers;
use crate::scene::request::view_request::{Position, ViewRequest};
use crate::scene::request::{Stereo, StereoLayout};
use crate::units::KM_PER_AU;
use glam::DVec3;

/// Default parallax of infinity relative to the picture's width: an audience tolerates a few hundredths without effort.
const INFINITY_OF_WIDTH: f64 = 1.0 / 30.0;
/// The mean distance between human eyes, kilometres (63 mm: Dodgson 2004, SPIE 5291, 36).
const HUMAN_EYES_KM: f64 = 63e-6;

pub(super) fn frames(catalog: &Catalog, ephemeris: &Ephemeris, plain: &ViewRequest, stereo: Stereo) -> Result<Frames, SceneError> {
    // Caption, scale bar and compass are added to the combined picture.
    let layers = Layers { caption: false, scale_bar: false, compass: false, ..plain.layers };
    let mut request = ViewRequest { layers, ..plain.clone() };
    if stereo.layout == StereoLayout::SideBySide {
        if request.width < 2 {
            return Err(SceneError::Request("a side-by-side picture is at least 2 pixels wide".into()));
        }
        request.width /= 2;
    }
    let viewer = viewpoint::viewer(catalog, ephemeris, &request)?;
    let distance_km = target_distance_km(ephemeris, &request, &viewer)?;
    let pixel_km = distance_km * viewer.camera.pixel_tangent();
    let standing = matches!(request.position, Position::Ground { .. });
    let (separation_km, infinity_px) = match stereo.eye_separation_km {
        None if !standing => {
            let infinity_px = (f64::from(request.width) * INFINITY_OF_WIDTH).round().max(1.0);
            (infinity_px * pixel_km, infinity_px)
        }
        given => {
            let separation_km = given.unwrap_or(HUMAN_EYES_KM);
            (separation_km, (separation_km / pixel_km).round())
        }
    };
    let most = f64::from(request.width / 2);
    if infinity_px > most {
        return Err(SceneError::Request(format!(
            "eyes {separation_km} km apart see the stars {infinity_px:.0} pixels apart, more than half of the picture: at most {:.6e} km",
            most * pixel_km
        )));
    }
    // Exact: no more than half of 16384.
    let infinity = infinity_px as u32;
    let eye = |side: f64| -> Result<FrameRequest, SceneError> {
        let mut viewer = viewer.clone();
        let camera = &mut viewer.camera;
        camera.position_km += camera.right * (0.5 * side * separation_km);
        let width = request.width + infinity;
        camera.tan_half_fov.x *= f64::from(width) / f64::from(request.width);
        camera.width = width;
        Ok(FrameRequest { request: ViewRequest { width, ..request.clone() }, viewer })
    };
    let frames = vec![eye(-1.0)?, eye(1.0)?];
    let arrangement = Arrangement::Eyes(Eyes { layout: stereo.layout, separation_km, columns: [infinity, 0] });
    Ok(Frames { meter: FrameRequest { request, viewer }, frames, arrangement })
}

/// Distance from the camera to the target's centre.
fn target_distance_km(ephemeris: &Ephemeris, request: &ViewRequest, viewer: &Viewer) -> Result<f64, SceneError> {
    let target =
        request.target.ok_or_else(|| SceneError::Request("stereo needs a target, at whose distance both pictures agree".into()))?;
    let seen: DVec3 = match viewer.stands_on {
        Some((body, at)) if body == target => at,
        _ => ephemeris.light_time_position(target, viewer.camera.position_km, request.time)?.0,
    };
    // A camera at the centre of its target was rejected before.
    Ok((seen - viewer.camera.position_km).length().clamp(1e-6, 1e9 * KM_PER_AU))
}
