//! Procedural relief and albedo finer than a body's maps, by the laws of shaders/lib/detail.wesl: the positions of the lattices relative to the camera.
//!
//! In: the body's placement and the camera. Out: [`DetailUniforms`]. Always: a place on the ground has the same craters, hills or billows from any camera, in f32 down to a
//! metre above the ground, because lattice positions are reduced in f64; size classes fade in and out from weight 0 as the camera moves.

use crate::catalog::Map;
use crate::scene::camera::{Camera, Placement, narrow, narrow_scalar};
use crate::scene::constants::DETAIL_ROWS;
use crate::scene::draw::Detail;
use crate::scene::draw::uniforms::DetailUniforms;
use glam::{DVec3, Vec4};

/// The description in decisions and the window.
pub(crate) fn law(detail: Detail) -> &'static str {
    match detail {
        Detail::None => "nothing finer than the map",
        Detail::Craters => "craters finer than the map, by the law N(>D) ~ D^-2; nobody has measured them",
        Detail::Hills => "hills finer than the map, as steep at all sizes; nobody has measured them",
        Detail::Billows => "billows finer than the map of clouds, by the cube root of their size; nobody has measured them",
    }
}

/// Assumed columns of a map without an entry in the catalog: those of the coarsest embedded map.
const USUAL_COLUMNS: u32 = 512;
/// Pixels that a texel spans right below the camera when it begins to show: WANTED of the fragment.
const LEAST_TEXEL_PX: f64 = 6.0;
/// Ground that a pixel may span where there is no map: a fourth of the coarsest cell, degrees.
const DEG_PER_PX: f64 = 0.72;
/// Cell size of the coarsest lattice, radii.
const FIRST_CELL: f64 = 0.05;
/// Ratio of a lattice's cell size to that of the next coarser one, for craters, and for the noise of hills and billows, which costs more.
const CRATER_RATIO: f64 = 0.6;
const NOISE_RATIO: f64 = 0.4;
/// Cells after which a lattice repeats: PERIOD of the fragment.
const PERIOD: f64 = 289.0;
/// Size of a cell, in pixels, from which it is visible: less than the fragment's limit.
const LEAST_CELL_PX: f64 = 3.5;
/// A cell size that is never visible, radii.
const NOWHERE: f64 = 1e6;

/// Degrees of ground that a pixel spans right below the camera, and how many it may for detail to show.
pub(crate) fn ground_deg_per_px(camera: &Camera, placement: &Placement, map: Option<&Map>) -> (f64, f64) {
    let span = ((placement.camera_in_unit_sphere().length() - 1.0).max(0.0) * camera.pixel_tangent()).to_degrees();
    let of_map = |map: &Map| 360.0 / f64::from(map.columns.unwrap_or(USUAL_COLUMNS)) / LEAST_TEXEL_PX;
    (span, map.map_or(DEG_PER_PX, of_map))
}

/// The lattices for a draw of craters, or of hills or billows. `from_camera`: places count from the camera, else from the body's centre.
pub(crate) fn uniforms(detail: Detail, camera: &Camera, placement: &Placement, from_camera: bool) -> DetailUniforms {
    let ratio = if detail == Detail::Craters { CRATER_RATIO } else { NOISE_RATIO };
    let here = placement.camera_in_unit_sphere();
    let origin = if from_camera { here } else { DVec3::ZERO };
    let pixel = (here.length() - 1.0).max(1e-9) * camera.pixel_tangent();
    // The lattice whose cells just begin to show right below the camera.
    let finest = ((LEAST_CELL_PX * pixel / FIRST_CELL).ln() / ratio.ln()).max(0.0);
    let last = finest.ceil() as i32;
    let row = |k: usize| {
        let level = last - (DETAIL_ROWS as i32 - 1) + k as i32;
        if level < 0 {
            return Vec4::new(0.0, 0.0, 0.0, narrow_scalar(NOWHERE));
        }
        let cell = FIRST_CELL * ratio.powi(level);
        // Lattices are offset from each other, so that no two share a wall.
        let apart = DVec3::new(75.488, 56.984, 85.667) * f64::from(level + 1);
        let place = origin / cell + apart;
        narrow(place - (place / PERIOD).floor() * PERIOD).extend(narrow_scalar(cell))
    };
    let largest = FIRST_CELL * ratio.powf(finest - (DETAIL_ROWS as f64 - 1.0));
    let camera = narrow(here - origin).extend(narrow_scalar(camera.pixel_tangent()));
    DetailUniforms { lattice: std::array::from_fn(row), largest: narrow_scalar(largest), camera }
}
