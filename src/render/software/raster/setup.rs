//! Triangle set-up: edges in fixed point, and the plane equations of depth, 1/w and the varyings.
//!
//! In: the clip-space positions and varyings of a triangle's vertices. Out: its visible raster triangles and the planes that they share, appended to a
//! `RasterGeometry`.
//!
//! Positions are snapped to a [`VertexGrid`]; within the guard band, edge functions are exact in i64.
//! Planes are derived in f64 from the homogeneous triangle (Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates",
//! 1997), so clipped parts share the planes of the unclipped triangle.

use super::clip::{ClipVertex, GUARD_BAND_PX, VisiblePart, clip};
use crate::render::software::{RenderError, try_grow};

/// Number of fixed-point steps per pixel: the resolution of positions in the rasteriser.
pub(crate) const STEPS_PER_PIXEL: i64 = 4096;

/// The grid of the rasteriser's vertex positions: a vertex moves to the nearest point of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VertexGrid {
    /// Spacing 1/4096 pixel: a silhouette moves by at most 1/8192 pixel along each axis.
    #[default]
    Fine,
    /// Spacing 1/256 pixel, as on GPUs (Direct3D 11.3 Functional Specification, 3.4.4.1; `subPixelPrecisionBits` is 8 with most Vulkan drivers). Images
    /// that are compared with a GPU's need it: a silhouette moves by up to 1/512 pixel along each axis, which may decide whether a pixel's centre is covered.
    Gpu,
}

impl VertexGrid {
    /// Distance between neighbouring grid points, in fixed-point steps.
    const fn spacing(self) -> i64 {
        match self {
            Self::Fine => 1,
            Self::Gpu => STEPS_PER_PIXEL / 256,
        }
    }
}

/// Size of the target, scissor rectangle, culling and grid of the vertices; sizes and positions in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RasterState {
    pub width: u32,
    pub height: u32,
    /// Left, top, right and bottom edge (the last two exclusive), inside the target.
    pub scissor: [u32; 4],
    /// Whether back faces are dropped.
    pub culls_back_faces: bool,
    /// Whether front faces wind clockwise on the screen, as in a mirrored image.
    pub front_faces_are_clockwise: bool,
    pub vertex_grid: VertexGrid,
}

/// Edge function: `a x + b y + c >= 0` inside the triangle, with x and y in fixed-point steps. By the top-left rule, c is 1 less for edges that are neither top
/// nor left, so that points on them are outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EdgeFunction {
    pub a: i64,
    pub b: i64,
    pub c: i64,
}

/// A triangle in fixed point: a source triangle or a clipped part of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RasterTriangle {
    pub edges: [EdgeFunction; 3],
    /// Rectangle of the pixels that may be covered: left, top, right and bottom edge (the last two exclusive).
    pub bounds_px: [u32; 4],
    /// Index of the [`SourceTriangle`] of which this triangle is a part.
    pub source_triangle: u32,
}

/// A linear function of the position in pixels, relative to [`SourceTriangle::origin`]: value(x, y) = `at_origin` + `dx` x + `dy` y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Plane {
    pub at_origin: f64,
    pub dx: f64,
    pub dy: f64,
}

impl Plane {
    /// The value at the point (x, y), in pixels from the origin.
    pub(crate) fn at(&self, x: f64, y: f64) -> f64 {
        self.at_origin + self.dx * x + self.dy * y
    }
    fn constant(value: f64) -> Self {
        Self { at_origin: value, dx: 0.0, dy: 0.0 }
    }
}

/// The plane equations of one source triangle (a triangle before clipping), which its clipped parts share.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SourceTriangle {
    /// Origin of the planes' x and y, in pixels of the target.
    pub origin: [f64; 2],
    /// Reversed depth.
    pub depth: Plane,
    /// 1 / w, constant if `is_affine`.
    pub inverse_w: Plane,
    /// Whether all three w are equal, so that varyings are linear in screen space.
    pub is_affine: bool,
    pub is_front_facing: bool,
    /// Index in [`RasterGeometry::planes`] of this triangle's first plane. Each component of an interpolated varying has a plane: of value / w, or of the value
    /// itself if `is_affine`.
    pub first_plane: usize,
    /// Index in [`RasterGeometry::flat_values`] of this triangle's first value. Each component of a flat varying has a value.
    pub first_flat_value: usize,
}

/// All triangles of one draw, in drawing order.
#[derive(Clone, Debug, Default)]
pub(crate) struct RasterGeometry {
    pub triangles: Vec<RasterTriangle>,
    pub source_triangles: Vec<SourceTriangle>,
    /// Planes of the interpolated varyings.
    pub planes: Vec<Plane>,
    /// Values of the flat varyings.
    pub flat_values: Vec<f64>,
    /// Number of source triangles that were clipped and are still visible.
    pub clipped_count: usize,
}

/// Upper bound of the raster triangles that one source triangle becomes: each of the seven clip planes (smallest w, near, far, four of the guard band) adds
/// at most one corner, and a polygon of ten corners consists of eight triangles.
const MAX_PARTS: usize = 8;

impl RasterGeometry {
    /// Reserves memory for `count` more source triangles, and for clipping one of them into [`MAX_PARTS`] parts. `interpolated_count`, `flat_count`: components
    /// of the interpolated and of the flat varyings, per triangle.
    ///
    /// # Errors
    /// Too little memory.
    pub(crate) fn reserve(&mut self, count: usize, interpolated_count: usize, flat_count: usize) -> Result<(), RenderError> {
        try_grow(&mut self.triangles, count + MAX_PARTS - 1, "the triangles")?;
        try_grow(&mut self.source_triangles, count, "the triangles' depth planes")?;
        try_grow(&mut self.planes, count * interpolated_count, "the triangles' varyings")?;
        try_grow(&mut self.flat_values, count * flat_count, "the triangles' varyings")
    }

    /// Concatenates the triangles of several geometries.
    ///
    /// # Errors
    /// Too little memory.
    pub(crate) fn joined<'a>(geometries: impl Iterator<Item = &'a Self> + Clone) -> Result<Self, RenderError> {
        let mut all = Self::default();
        let sum = |count: fn(&Self) -> usize| geometries.clone().map(count).sum();
        try_grow(&mut all.triangles, sum(|g| g.triangles.len()), "the triangles")?;
        try_grow(&mut all.source_triangles, sum(|g| g.source_triangles.len()), "the triangles' depth planes")?;
        try_grow(&mut all.planes, sum(|g| g.planes.len()), "the triangles' varyings")?;
        try_grow(&mut all.flat_values, sum(|g| g.flat_values.len()), "the triangles' varyings")?;
        for g in geometries {
            let (source_triangle_base, plane_base, value_base) =
                (all.source_triangles.len() as u32, all.planes.len(), all.flat_values.len());
            all.triangles.extend(
                g.triangles.iter().map(|t| RasterTriangle { source_triangle: t.source_triangle + source_triangle_base, ..t.clone() }),
            );
            all.source_triangles.extend(g.source_triangles.iter().map(|s| SourceTriangle {
                first_plane: s.first_plane + plane_base,
                first_flat_value: s.first_flat_value + value_base,
                ..s.clone()
            }));
            all.planes.extend_from_slice(&g.planes);
            all.flat_values.extend_from_slice(&g.flat_values);
            all.clipped_count += g.clipped_count;
        }
        Ok(all)
    }
}

/// How many triangles before its use a triangle's data are fetched, in three stages: the raster triangle, its source triangle, and the planes and flat values
/// of that; each stage needs the data of the one before. The spacing of four triangles is a choice: docs/measurements.md has times with these distances only.
#[cfg(target_arch = "x86_64")]
const PREFETCH_DISTANCES: [usize; 3] = [12, 8, 4];

impl RasterGeometry {
    /// Prefetches the data of triangles that will be drawn soon, because a tile's triangles are scattered in memory. `upcoming`: indices in
    /// `triangles`, in drawing order; the first is the triangle that is drawn now.
    #[inline(always)]
    pub(crate) fn prefetch(&self, upcoming: &[u32]) {
        #[cfg(target_arch = "x86_64")]
        {
            fn fetch<T>(items: &[T], index: usize) {
                use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
                let first = items.as_ptr().wrapping_add(index).cast::<i8>();
                // A cache line has 64 bytes.
                for line in (0..size_of::<T>()).step_by(64) {
                    // SAFETY: a prefetch is only a hint; any address is allowed.
                    unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(line)) }
                }
            }
            let upcoming_at = |stage: usize| upcoming.get(PREFETCH_DISTANCES[stage]).map(|t| *t as usize);
            if let Some(triangle) = upcoming_at(0) {
                fetch(&self.triangles, triangle);
            }
            if let Some(triangle) = upcoming_at(1).and_then(|t| self.triangles.get(t)) {
                fetch(&self.source_triangles, triangle.source_triangle as usize);
            }
            if let Some(triangle) = upcoming_at(2).and_then(|t| self.triangles.get(t))
                && let Some(source) = self.source_triangles.get(triangle.source_triangle as usize)
            {
                fetch(&self.planes, source.first_plane);
                // A plane has 24 bytes, so the third one is usually in the next cache line.
                fetch(&self.planes, source.first_plane + 2);
                fetch(&self.flat_values, source.first_flat_value);
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = upcoming;
    }
}

/// How a varying is interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    Perspective,
    /// The first vertex's value.
    Flat,
}

/// The nearest integer, ties to even, of a number below 2^51. Adding 1.5 * 2^52 leaves the rounded number in the low bits. The standard function would
/// be a call wherever the compiler may not use SSE 4.1.
fn nearest_integer(x: f64) -> i64 {
    const ROUNDING: f64 = 1.5 * (1_u64 << 52) as f64;
    (x + ROUNDING).to_bits() as i64 - ROUNDING.to_bits() as i64
}

/// A vertex's pixel position inside the guard band, rounded to the nearest point of the grid, in fixed point.
fn snap(c: &ClipVertex, vertex_grid: VertexGrid) -> [i64; 2] {
    const { assert!(GUARD_BAND_PX * (STEPS_PER_PIXEL as f64) < (1_u64 << 51) as f64) };
    let spacing = vertex_grid.spacing();
    let points_per_pixel = (STEPS_PER_PIXEL / spacing) as f64;
    [c.x, c.y].map(|v| nearest_integer(v / c.w * points_per_pixel) * spacing)
}

/// The edge function of the edge from one corner of a clockwise triangle to the next.
fn edge(from: [i64; 2], to: [i64; 2]) -> EdgeFunction {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    // The triangle is clockwise on the screen (y down), so the inside lies to the right of the edge. Top edges run right, left edges run up.
    let top_left = (dy == 0 && dx > 0) || dy < 0;
    EdgeFunction { a: -dy, b: dx, c: dy * from[0] - dx * from[1] - i64::from(!top_left) }
}

/// A part of a source triangle; `None` if it lies outside the scissor rectangle, or if snapping has collapsed it or reversed its winding.
/// `is_clockwise`: the winding of the source triangle on the screen.
fn raster_triangle(
    [a, b, c]: [[i64; 2]; 3],
    is_clockwise: bool,
    raster_state: &RasterState,
    source_triangle: u32,
) -> Option<RasterTriangle> {
    let doubled_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if doubled_area == 0 || (doubled_area > 0) != is_clockwise {
        return None;
    }
    // With y down, a clockwise triangle has a positive area. Edge functions are for clockwise triangles.
    let (b, c) = if doubled_area < 0 { (c, b) } else { (b, c) };
    let min_pixel = |axis: usize| a[axis].min(b[axis]).min(c[axis]).div_euclid(STEPS_PER_PIXEL);
    let max_pixel = |axis: usize| a[axis].max(b[axis]).max(c[axis]).div_euclid(STEPS_PER_PIXEL) + 1;
    let [sx0, sy0, sx1, sy1] = raster_state.scissor.map(i64::from);
    let (x0, y0) = (min_pixel(0).max(sx0), min_pixel(1).max(sy0));
    let (x1, y1) = (max_pixel(0).min(sx1).min(raster_state.width.into()), max_pixel(1).min(sy1).min(raster_state.height.into()));
    if x0 >= x1 || y0 >= y1 {
        return None;
    }
    let edges = [edge(a, b), edge(b, c), edge(c, a)];
    Some(RasterTriangle { edges, bounds_px: [x0 as u32, y0 as u32, x1 as u32, y1 as u32], source_triangle })
}

/// Clips, culls and snaps one triangle, derives its planes and appends it to `geometry`. `varyings`: for each component of a varying, one value per vertex.
pub(crate) fn set_up(
    clip_positions: [[f64; 4]; 3],
    varyings: impl Iterator<Item = (Interpolation, [f64; 3])>,
    raster_state: &RasterState,
    geometry: &mut RasterGeometry,
) {
    let mut corners = clip_positions.map(|p| ClipVertex::from_clip(p, raster_state.width, raster_state.height));
    let Some(visible_part) = clip(&corners) else { return };
    let mut snapped = [[0; 2]; 3];
    let origin = match visible_part {
        VisiblePart::Whole => {
            // Planes are derived from the snapped triangle, so that no covered sample lies outside that triangle, even if it is very thin.
            for (c, snapped) in corners.iter_mut().zip(&mut snapped) {
                *snapped = snap(c, raster_state.vertex_grid);
                let [x, y] = snapped.map(|v| v as f64 / STEPS_PER_PIXEL as f64);
                (c.x, c.y) = (x * c.w, y * c.w);
            }
            [corners[0].x / corners[0].w, corners[0].y / corners[0].w]
        }
        VisiblePart::Clipped(_) => [0.5 * f64::from(raster_state.width), 0.5 * f64::from(raster_state.height)],
    };
    // Homogeneous positions relative to the planes' origin, one vertex per row.
    let matrix = corners.map(|c| [c.x - origin[0] * c.w, c.y - origin[1] * c.w, c.w]);
    let cross = |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    // Row k, divided by the determinant, is the plane of barycentric coordinate k divided by w.
    let cofactors = [cross(matrix[1], matrix[2]), cross(matrix[2], matrix[0]), cross(matrix[0], matrix[1])];
    let determinant = matrix[0][0] * cofactors[0][0] + matrix[0][1] * cofactors[0][1] + matrix[0][2] * cofactors[0][2];
    if determinant == 0.0 || !determinant.is_finite() {
        return;
    }
    // Pixel y points down, so the determinant of a triangle that winds clockwise on the screen is positive.
    let is_clockwise = determinant > 0.0;
    let is_front_facing = is_clockwise == raster_state.front_faces_are_clockwise;
    if raster_state.culls_back_faces && !is_front_facing {
        return;
    }
    // The plane of value / w, for one value per vertex.
    let plane_of = |v: [f64; 3]| {
        let sum = |k: usize| (v[0] * cofactors[0][k] + v[1] * cofactors[1][k] + v[2] * cofactors[2][k]) / determinant;
        Plane { dx: sum(0), dy: sum(1), at_origin: sum(2) }
    };
    let RasterGeometry { triangles, source_triangles, planes, flat_values, clipped_count } = geometry;
    let source_triangle = source_triangles.len() as u32;
    let triangles_before = triangles.len();
    match &visible_part {
        VisiblePart::Whole => triangles.extend(raster_triangle(snapped, is_clockwise, raster_state, source_triangle)),
        VisiblePart::Clipped(polygon) => {
            let points = polygon.corners();
            for k in 1..points.len() - 1 {
                let p = [points[0], points[k], points[k + 1]].map(|c| snap(&c, raster_state.vertex_grid));
                triangles.extend(raster_triangle(p, is_clockwise, raster_state, source_triangle));
            }
        }
    }
    if triangles.len() == triangles_before {
        return;
    }
    *clipped_count += usize::from(matches!(visible_part, VisiblePart::Clipped(_)));
    let is_affine = corners[0].w == corners[1].w && corners[1].w == corners[2].w;
    let w = corners[0].w;
    let (first_plane, first_flat_value) = (planes.len(), flat_values.len());
    for (interpolation, v) in varyings {
        match interpolation {
            Interpolation::Flat => flat_values.push(v[0]),
            // A plane of constant value avoids the division, so that the value stays exact.
            Interpolation::Perspective if is_affine && v[0] == v[1] && v[1] == v[2] => planes.push(Plane::constant(v[0])),
            Interpolation::Perspective if is_affine => {
                // Value / w times the common w.
                let p = plane_of(v);
                planes.push(Plane { at_origin: p.at_origin * w, dx: p.dx * w, dy: p.dy * w });
            }
            Interpolation::Perspective => planes.push(plane_of(v)),
        }
    }
    source_triangles.push(SourceTriangle {
        origin,
        depth: plane_of(corners.map(|c| c.z)),
        inverse_w: if is_affine { Plane::constant(1.0 / w) } else { plane_of([1.0; 3]) },
        is_affine,
        is_front_facing,
        first_plane,
        first_flat_value,
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    const RASTER_STATE: RasterState = RasterState {
        width: 64,
        height: 64,
        scissor: [0, 0, 64, 64],
        culls_back_faces: false,
        front_faces_are_clockwise: false,
        vertex_grid: VertexGrid::Fine,
    };

    /// The only source triangle, and the plane of a varying with these values at the vertices; `None` if nothing is visible.
    fn set_up_one(clip_positions: [[f64; 4]; 3], values: [f64; 3], raster_state: &RasterState) -> Option<(SourceTriangle, Plane)> {
        let mut g = RasterGeometry::default();
        set_up(clip_positions, [(Interpolation::Perspective, values)].into_iter(), raster_state, &mut g);
        Some((g.source_triangles.pop()?, g.planes.pop()?))
    }

    #[test]
    fn planes_reproduce_the_values_at_the_vertices() {
        let clip = [[-1.0, -1.0, 0.5, 1.0], [3.0, -3.0, 0.5, 4.0], [0.0, 2.0, 0.25, 2.5]];
        let (s, varying) = set_up_one(clip, [1.0, -2.0, 5.0], &RASTER_STATE).expect("visible");
        for (c, v) in clip.iter().zip([1.0, -2.0, 5.0]) {
            let corner = ClipVertex::from_clip(*c, 64, 64);
            let (x, y) = (corner.x / corner.w - s.origin[0], corner.y / corner.w - s.origin[1]);
            // Snapping moves a vertex by up to 1/8192 pixel, which changes these values by less than the tolerances.
            assert!((varying.at(x, y) / s.inverse_w.at(x, y) - v).abs() < 1e-2, "{v}");
            assert!((s.depth.at(x, y) - c[2] / c[3]).abs() < 1e-4);
        }
    }

    #[test]
    fn each_grid_moves_a_vertex_by_at_most_half_its_spacing() {
        // x in pixels of a target 64 pixels wide; x = 10.3 is not a point of either grid.
        let vertex = |x_px: f64| ClipVertex::from_clip([2.0 * x_px / 64.0 - 1.0, 0.0, 0.5, 1.0], 64, 64);
        for (grid, spacing_px) in [(VertexGrid::Fine, 1.0 / 4096.0), (VertexGrid::Gpu, 1.0 / 256.0)] {
            let snapped_px = snap(&vertex(10.3), grid)[0] as f64 / STEPS_PER_PIXEL as f64;
            assert!((snapped_px - 10.3).abs() <= 0.5 * spacing_px, "{grid:?}: {snapped_px}");
            assert_eq!((snapped_px / spacing_px).fract(), 0.0, "{grid:?}: {snapped_px}");
        }
        assert_ne!(snap(&vertex(10.3), VertexGrid::Fine), snap(&vertex(10.3), VertexGrid::Gpu));
    }

    #[test]
    fn positions_are_rounded_to_the_nearest_integer_with_ties_to_even() {
        let limit = GUARD_BAND_PX * STEPS_PER_PIXEL as f64;
        for x in [0.0, -0.0, 0.3, 0.5, 1.5, 2.5, 1e6 + 0.5, limit - 0.25, limit].into_iter().flat_map(|x| [x, -x]) {
            assert_eq!(nearest_integer(x), x.round_ties_even() as i64, "{x}");
        }
    }

    #[test]
    fn counter_clockwise_triangles_are_front_faces_even_if_clipped() {
        let unclipped = [[-0.5, -0.5, 0.5, 1.0], [0.5, -0.5, 0.5, 1.0], [0.0, 0.5, 0.5, 1.0]];
        let clipped = [[-0.5, -0.5, 0.1, 1.0], [0.5, -0.5, 0.1, 1.0], [0.0, 0.9, 0.1, -1.0]];
        for clip in [unclipped, clipped] {
            assert!(set_up_one(clip, [0.0; 3], &RASTER_STATE).expect("visible").0.is_front_facing);
            let back = [clip[0], clip[2], clip[1]];
            assert!(!set_up_one(back, [0.0; 3], &RASTER_STATE).expect("visible").0.is_front_facing);
            assert!(set_up_one(back, [0.0; 3], &RasterState { culls_back_faces: true, ..RASTER_STATE }).is_none());
            // In a mirrored image it is the other way round.
            let mirrored = RasterState { culls_back_faces: true, front_faces_are_clockwise: true, ..RASTER_STATE };
            assert!(set_up_one(back, [0.0; 3], &mirrored).expect("visible").0.is_front_facing);
            assert!(set_up_one(clip, [0.0; 3], &mirrored).is_none());
        }
    }

    #[test]
    fn a_constant_varying_is_exact_if_all_w_are_equal() {
        let clip = [[-1.0, -1.0, 0.0, 1.0], [1.0, -1.0, 0.0, 1.0], [-1.0, 1.0, 0.0, 1.0]];
        let (s, varying) = set_up_one(clip, [0.1; 3], &RASTER_STATE).expect("visible");
        assert!(s.is_affine);
        assert_eq!(varying, Plane { at_origin: 0.1, dx: 0.0, dy: 0.0 });
    }

    #[test]
    fn joined_parts_equal_the_geometry_set_up_at_once() {
        let triangle = |k: f64| [[-0.9, -0.5, 0.5, 1.0], [0.3 + 0.1 * k, -0.5, 0.5, 1.0], [0.0, 0.5, 0.1, 1.0 - 0.8 * k]];
        let set_up_all = |range: std::ops::Range<u32>| {
            let mut g = RasterGeometry::default();
            for k in range.map(f64::from) {
                g.reserve(1, 1, 1).expect("memory");
                let varyings = [(Interpolation::Flat, [k; 3]), (Interpolation::Perspective, [k, 1.0, 2.0])];
                set_up(triangle(k), varyings.into_iter(), &RASTER_STATE, &mut g);
            }
            g
        };
        let whole = set_up_all(0..4);
        let parts = [0..1, 1..1, 1..4].map(set_up_all);
        let parts = RasterGeometry::joined(parts.iter()).expect("memory");
        assert!(whole.source_triangles.len() == 4 && whole.triangles.len() > 4, "some triangles must be clipped into several parts");
        assert_eq!(parts.triangles, whole.triangles);
        assert_eq!(parts.source_triangles, whole.source_triangles);
        assert_eq!(parts.planes, whole.planes);
        assert_eq!((&parts.flat_values, whole.flat_values.len()), (&whole.flat_values, 4));
        assert_eq!(parts.clipped_count, whole.clipped_count);
        assert!(
            (1..4).contains(&whole.clipped_count),
            "the first triangle is not clipped, the last extends behind the camera: {}",
            whole.clipped_count
        );
    }
}
