//! Procedural relief and albedo finer than a body's maps. Craters, and the noise of hills and billows, are defined on cubic lattices (shaders/lib/detail.wesl);
//! this module computes the positions of the lattices.
//!
//! In: the body's placement and the camera. Out: [`DetailUniforms`]. Always: a point on the ground has the same craters, hills or billows from any camera, in
//! f32 too, down to a metre above the ground and in fields of view of an arcsecond. For this, lattice positions are reduced modulo PERIOD in f64; in narrow
//! fields the shader's positions are relative to a point of the visible ground. As the camera moves, each lattice fades in from weight 0, and out again.

use crate::catalog::Map;
use crate::message::{Reason, reason};
use crate::scene::camera::{Camera, Placement, ViewRays, narrow, narrow_scalar};
use crate::scene::constants::MAX_DETAIL_LATTICES;
use crate::scene::draw::Detail;
use crate::scene::draw::uniforms::DetailUniforms;
use glam::{DVec2, DVec3, Vec4};

/// The description of the detail for decisions and the window.
pub(crate) fn description(detail: Detail) -> Reason {
    match detail {
        Detail::None => reason!("detail-none"),
        Detail::Craters => reason!("detail-craters").and(reason!("detail-unmeasured")),
        Detail::Hills => reason!("detail-hills").and(reason!("detail-unmeasured")),
        Detail::Billows => reason!("detail-billows").and(reason!("detail-unmeasured")),
    }
}

/// Assumed number of columns of a map whose catalog entry does not state it: that of the coarsest embedded map.
const DEFAULT_MAP_COLUMNS: u32 = 512;
/// Width of a map's texel in pixels, directly below the camera, above which detail appears: there `detail_weight` of shaders/lib/detail.wesl begins to rise.
const MIN_TEXEL_PX: f64 = 6.0;
/// Ground that a pixel may span, degrees, for detail to appear on a body without a map: a fourth of the coarsest cell, 0.05 rad / 4.
const UNMAPPED_DEG_PER_PX: f64 = 0.72;
/// Cell size of the coarsest lattice, radii of the body.
const COARSEST_CELL: f64 = 0.05;
/// Ratio of a lattice's cell size to that of the next coarser lattice, for craters, and for the noise of hills and billows. The noise costs more, so its ratio
/// gives fewer lattices.
const CRATER_RATIO: f64 = 0.6;
const NOISE_RATIO: f64 = 0.4;
/// Number of cells after which a lattice repeats: PERIOD of shaders/lib/detail.wesl.
const PERIOD: f64 = 289.0;
/// Size of the smallest cells that the lattices must include, in pixels: less than the 4 above which shaders/lib/detail.wesl shows cells.
const MIN_CELL_PX: f64 = 3.5;
/// A cell size that is never visible, radii.
const INVISIBLE_CELL: f64 = 1e6;

/// Two numbers in degrees of ground per pixel: what a pixel spans directly below the camera, and the limit below which detail is visible.
pub(crate) fn ground_deg_per_px(camera: &Camera, placement: &Placement, map: Option<&Map>) -> (f64, f64) {
    let span_deg = ((placement.camera_in_unit_sphere().length() - 1.0).max(0.0) * camera.pixel_tangent()).to_degrees();
    let limit_for_map_deg = |map: &Map| 360.0 / f64::from(map.columns.unwrap_or(DEFAULT_MAP_COLUMNS)) / MIN_TEXEL_PX;
    (span_deg, map.map_or(UNMAPPED_DEG_PER_PX, limit_for_map_deg))
}

/// Tangent of the angle that a pixel spans, below which positions are relative to a point of the visible ground: f32 rounds a ray to 6e-8 of its length, which
/// is 6e-4 of such a pixel.
const NARROW_PIXEL_TANGENT: f64 = 1e-4;
/// Number of rays along each side of the draw's rectangle that are tested to find this point.
const REFERENCE_RAYS: u32 = 9;

/// The point of the ground to which positions are relative, and the view ray that meets it.
struct GroundReference {
    /// The point, unit-sphere frame.
    point: DVec3,
    /// The view ray of view depth 1, unit-sphere frame.
    ray: DVec3,
    /// Distance from the camera to the point, in lengths of the ray.
    depth: f64,
    /// Position of the ray in the draw's rectangle: 0 to 1, right and down.
    rect_position: DVec2,
}

impl GroundReference {
    /// The nearest of the points where a grid of rays meets the ground; `None` if no ray meets it, or if the field of view is so wide that no reference is
    /// needed.
    fn of(camera: &Camera, placement: &Placement, rect_in_clip: Vec4) -> Option<Self> {
        if camera.pixel_tangent() >= NARROW_PIXEL_TANGENT {
            return None;
        }
        let [left, top, right, bottom] = rect_in_clip.to_array().map(f64::from);
        let origin = placement.camera_in_unit_sphere();
        let at = |n: u32| {
            // Multiples of 1/8, which are exact in f32.
            let rect_position = DVec2::new(f64::from(n % REFERENCE_RAYS), f64::from(n / REFERENCE_RAYS)) / f64::from(REFERENCE_RAYS - 1);
            let clip = DVec2::new(left + rect_position.x * (right - left), top + rect_position.y * (bottom - top));
            let ray = placement.direction_in_unit_sphere(camera.ray(clip));
            let point = placement.surface_along_unit_sphere(ray)?;
            Some(Self { point, ray, depth: (point - origin).dot(ray) / ray.length_squared(), rect_position })
        };
        (0..REFERENCE_RAYS * REFERENCE_RAYS).filter_map(at).min_by(|a, b| a.depth.total_cmp(&b.depth))
    }
}

/// The uniforms of a draw with craters, hills or billows. `rays`: the view rays of the same draw.
pub(crate) fn uniforms(detail: Detail, camera: &Camera, placement: &Placement, rays: &ViewRays) -> DetailUniforms {
    let ratio = if detail == Detail::Craters { CRATER_RATIO } else { NOISE_RATIO };
    let camera_position = placement.camera_in_unit_sphere();
    let reference = GroundReference::of(camera, placement, rays.rect_in_clip);
    // Positions are relative to the reference point, or without one to the camera or the body's centre.
    let origin = reference.as_ref().map_or(if rays.anchor_is_camera { camera_position } else { DVec3::ZERO }, |r| r.point);
    // The minimum keeps the logarithm below finite.
    let pixel_width_radii = (camera_position.length() - 1.0).max(1e-9) * camera.pixel_tangent();
    // The index, not rounded, of the lattice whose cells are just visible directly below the camera. Index 0 is the coarsest lattice.
    let finest = ((MIN_CELL_PX * pixel_width_radii / COARSEST_CELL).ln() / ratio.ln()).max(0.0);
    let last = finest.ceil() as i32;
    // For row k of the uniforms: the origin's position in the row's lattice, in cells, modulo the period; and the side of a cell, radii.
    let row = |k: usize| {
        let lattice = last - (MAX_DETAIL_LATTICES as i32 - 1) + k as i32;
        if lattice < 0 {
            return (DVec3::ZERO, INVISIBLE_CELL);
        }
        let cell = COARSEST_CELL * ratio.powi(lattice);
        // Arbitrary offsets, so that no two lattices share the walls of their cells.
        let offset = DVec3::new(75.488, 56.984, 85.667) * f64::from(lattice + 1);
        let position = origin / cell + offset;
        (position - (position / PERIOD).floor() * PERIOD, cell)
    };
    // Side of a cell, radii, from which on lattices have faded out, because the rows hold no coarser ones.
    let largest = COARSEST_CELL * ratio.powf(finest - (MAX_DETAIL_LATTICES as f64 - 1.0));
    let camera_row = narrow(camera_position - origin).extend(narrow_scalar(camera.pixel_tangent()));
    // The layout is that of `DetailUniforms::reference`.
    let reference_rows = reference.map_or([Vec4::ZERO; 3], |r| {
        let [depth, u, v] = [r.depth, r.rect_position.x, r.rect_position.y].map(narrow_scalar);
        [narrow(r.point).extend(depth), narrow(r.ray).extend(u), Vec4::new(v, 0.0, 0.0, 0.0)]
    });
    DetailUniforms {
        // The cell and the position within it are stored separately; a single number would lose up to four digits of the position.
        lattice: std::array::from_fn(|k| {
            let (position, cell) = row(k);
            narrow(position.fract()).extend(narrow_scalar(cell))
        }),
        cells: std::array::from_fn(|k| {
            let (position, _) = row(k);
            narrow(position.floor()).extend(0.0)
        }),
        largest: narrow_scalar(largest),
        camera: camera_row,
        reference: reference_rows,
    }
}
