//! Procedural relief and albedo finer than a body's maps, by the laws of shaders/lib/detail.wesl: the positions of the lattices relative to the camera.
//!
//! In: the body's placement and the camera. Out: [`DetailUniforms`]. Always: a place on the ground has the same craters, hills or billows from any camera, in f32 down to a
//! metre above the ground and in fields of an arcsecond, because lattice positions are reduced in f64 and narrow fields count places from the ground that they show; size classes fade in and out from weight 0 as the camera moves.

use crate::catalog::Map;
use crate::scene::camera::{Camera, Placement, ViewRays, narrow, narrow_scalar};
use crate::scene::constants::DETAIL_ROWS;
use crate::scene::draw::Detail;
use crate::scene::draw::uniforms::DetailUniforms;
use glam::{DVec2, DVec3, Vec4};

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

/// Tangent of the angle that a pixel spans below which places count from a point of the ground that the picture shows: f32 rounds a ray to 6e-8 of its length.
const NARROW_PIXEL: f64 = 1e-4;
/// Rays on a side of the picture that are tried for that point.
const TRIED: u32 = 9;

/// A point of the ground from which places count, and the ray that meets it.
struct GroundReference {
    /// Unit-sphere frame.
    place: DVec3,
    /// View depth 1; unit-sphere frame.
    ray: DVec3,
    /// Length of the way to it, in those rays.
    depth: f64,
    /// Place in the draw's rectangle, 0 to 1 right and down.
    corner: DVec2,
}

impl GroundReference {
    /// The nearest of the points where a grid of rays meets the ground, if the field of view is so narrow that one is needed.
    fn of(camera: &Camera, placement: &Placement, rect_in_clip: Vec4) -> Option<Self> {
        if camera.pixel_tangent() >= NARROW_PIXEL {
            return None;
        }
        let [left, top, right, bottom] = rect_in_clip.to_array().map(f64::from);
        let origin = placement.camera_in_unit_sphere();
        let at = |n: u32| {
            // Exact in f32.
            let corner = DVec2::new(f64::from(n % TRIED), f64::from(n / TRIED)) / f64::from(TRIED - 1);
            let ray = placement
                .direction_in_unit_sphere(camera.ray(DVec2::new(left + corner.x * (right - left), top + corner.y * (bottom - top))));
            let place = placement.surface_along_unit_sphere(ray)?;
            Some(Self { place, ray, depth: (place - origin).dot(ray) / ray.length_squared(), corner })
        };
        (0..TRIED * TRIED).filter_map(at).min_by(|a, b| a.depth.total_cmp(&b.depth))
    }
}

/// The lattices for a draw of craters, or of hills or billows, whose rays they follow.
pub(crate) fn uniforms(detail: Detail, camera: &Camera, placement: &Placement, rays: &ViewRays) -> DetailUniforms {
    let ratio = if detail == Detail::Craters { CRATER_RATIO } else { NOISE_RATIO };
    let here = placement.camera_in_unit_sphere();
    let reference = GroundReference::of(camera, placement, rays.rect_in_clip);
    // Places count from there, else from the camera or the body's centre.
    let origin = reference.as_ref().map_or(if rays.anchor_is_camera { here } else { DVec3::ZERO }, |r| r.place);
    let pixel = (here.length() - 1.0).max(1e-9) * camera.pixel_tangent();
    // The lattice whose cells just begin to show right below the camera.
    let finest = ((LEAST_CELL_PX * pixel / FIRST_CELL).ln() / ratio.ln()).max(0.0);
    let last = finest.ceil() as i32;
    let row = |k: usize| {
        let level = last - (DETAIL_ROWS as i32 - 1) + k as i32;
        if level < 0 {
            return (DVec3::ZERO, NOWHERE);
        }
        let cell = FIRST_CELL * ratio.powi(level);
        // Lattices are offset from each other, so that no two share a wall.
        let apart = DVec3::new(75.488, 56.984, 85.667) * f64::from(level + 1);
        let place = origin / cell + apart;
        (place - (place / PERIOD).floor() * PERIOD, cell)
    };
    let largest = FIRST_CELL * ratio.powf(finest - (DETAIL_ROWS as f64 - 1.0));
    let camera = narrow(here - origin).extend(narrow_scalar(camera.pixel_tangent()));
    let to_reference = reference.map_or([Vec4::ZERO; 3], |r| {
        let [depth, u, v] = [r.depth, r.corner.x, r.corner.y].map(narrow_scalar);
        [narrow(r.place).extend(depth), narrow(r.ray).extend(u), Vec4::new(v, 0.0, 0.0, 0.0)]
    });
    DetailUniforms {
        // The cell and the place in it, apart: together they would leave a place four digits less.
        lattice: std::array::from_fn(|k| narrow(row(k).0.fract()).extend(narrow_scalar(row(k).1))),
        cells: std::array::from_fn(|k| narrow(row(k).0.floor()).extend(0.0)),
        largest: narrow_scalar(largest),
        camera,
        reference: to_reference,
    }
}
