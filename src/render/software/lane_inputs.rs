//! Fills the lane inputs of a batch of quads (2 x 2 pixels): pixel positions, depth, varyings.
//!
//! In: the quads of a batch, in which the quads of one source triangle (a triangle before clipping) are consecutive, and the draw's geometry. Out: the inputs
//! of the fragment stage for all lanes. Always: planes (linear functions of the pixel's position) are evaluated at offsets from the triangle's first quad in
//! the batch, because small offsets round least; a lane's value does not depend on other triangles in the batch. Not here: which quads are covered.

// The compiler vectorises loops by index over several arrays of one fixed length.
#![allow(clippy::needless_range_loop)]

use super::fragment_setup::FragmentInputSource;
use super::math::Real;
use super::prepared_draw::{PreparedDraw, QUADS_PER_BATCH, Quad};
use super::raster::coverage::{PixelCentres, quad_position};
use super::raster::setup::{Plane, SourceTriangle};
use super::stage::{LANES, LaneRun};
use smallvec::SmallVec;
use std::ops::Range;

/// Number of lanes in a quad: one per pixel, row by row.
const QUAD_LANES: usize = 4;

/// Consecutive quads of one source triangle.
struct Span<'a> {
    /// The quads `start..end` of the batch.
    start: usize,
    end: usize,
    triangle: &'a SourceTriangle,
    /// Top-left corner of the first quad, in pixels of the target.
    first_corner: [f64; 2],
    /// The same corner, relative to the origin of the triangle's planes.
    from_plane_origin: [f64; 2],
}

impl Span<'_> {
    /// The lanes of this span, quad by quad.
    #[inline(always)]
    fn quads_of<'l, R>(&self, lanes: &'l mut [R; LANES]) -> &'l mut [[R; QUAD_LANES]] {
        &mut lanes.as_chunks_mut::<QUAD_LANES>().0[self.start..self.end]
    }

    /// Evaluates a plane at the position of each lane: `x`, `y`, in pixels, relative to the top-left corner of the span's first quad.
    #[inline(always)]
    fn evaluate<R: Real>(&self, lanes: &mut [R; LANES], [x, y]: [&[R; LANES]; 2], plane: &Plane) {
        let at_first_corner = R::from_f64(plane.at(self.from_plane_origin[0], self.from_plane_origin[1]));
        if plane.dx == 0.0 && plane.dy == 0.0 {
            return self.fill(lanes, at_first_corner);
        }
        let (dx, dy) = (R::from_f64(plane.dx), R::from_f64(plane.dy));
        if self.end - self.start == QUADS_PER_BATCH {
            // One loop over all lanes is fully vectorised.
            for ((lane, x), y) in lanes.iter_mut().zip(x).zip(y) {
                *lane = at_first_corner + dx * *x + dy * *y;
            }
            return;
        }
        let (x, y) = (&x.as_chunks::<QUAD_LANES>().0[self.start..self.end], &y.as_chunks::<QUAD_LANES>().0[self.start..self.end]);
        for ((lanes, x), y) in self.quads_of(lanes).iter_mut().zip(x).zip(y) {
            for i in 0..QUAD_LANES {
                lanes[i] = at_first_corner + dx * x[i] + dy * y[i];
            }
        }
    }

    /// Sets the lanes of this span to one value.
    #[inline(always)]
    fn fill<R: Real>(&self, lanes: &mut [R; LANES], value: R) {
        if self.end - self.start == QUADS_PER_BATCH {
            return lanes.fill(value);
        }
        self.quads_of(lanes).fill([value; QUAD_LANES]);
    }

    /// Sets lane = combine(lane, other) for the lanes of this span.
    #[inline(always)]
    fn combine<R: Real>(&self, lanes: &mut [R; LANES], other: &[R; LANES], combine: impl Fn(R, R) -> R) {
        if self.end - self.start == QUADS_PER_BATCH {
            for i in 0..LANES {
                lanes[i] = combine(lanes[i], other[i]);
            }
            return;
        }
        let other = &other.as_chunks::<QUAD_LANES>().0[self.start..self.end];
        for (lanes, other) in self.quads_of(lanes).iter_mut().zip(other) {
            for i in 0..QUAD_LANES {
                lanes[i] = combine(lanes[i], other[i]);
            }
        }
    }
}

/// Fills the lanes of the quads in `range` with one coordinate of their pixel centres, relative to `origin`. `centres`: this coordinate of all pixels of the
/// tile, quad by quad.
#[inline(always)]
fn fill_relative_centres<R: Real>(
    lanes: &mut [R; LANES],
    centres: &[f32],
    quads: &[Quad; QUADS_PER_BATCH],
    range: Range<usize>,
    origin: f32,
) {
    let centres = centres.as_chunks::<QUAD_LANES>().0;
    for (lanes, quad) in lanes.as_chunks_mut::<QUAD_LANES>().0[range.clone()].iter_mut().zip(&quads[range]) {
        // Copied before the lanes are written, so that the compiler uses vectors.
        let relative: [f32; QUAD_LANES] = centres[usize::from(quad.index)].map(|centre| centre - origin);
        *lanes = relative.map(|value| R::from_f32_bits(value.to_bits()));
    }
}

impl<'a> Span<'a> {
    /// The quads `start..end` of a batch, which belong to one triangle. `first`: the quad at `start`; `tile_corner`: the tile's top-left pixel.
    #[inline(always)]
    fn new<R: Real>(draw: &'a PreparedDraw<'_, R>, [start, end]: [usize; 2], first: Quad, tile_corner: [u32; 2]) -> Self {
        let quad_corner = quad_position(first.index.into());
        let triangle = &draw.geometry.source_triangles[first.source_triangle as usize];
        let first_corner = [0, 1].map(|axis: usize| f64::from(tile_corner[axis] + quad_corner[axis]));
        let from_plane_origin = [first_corner[0] - triangle.origin[0], first_corner[1] - triangle.origin[1]];
        Self { start, end, triangle, first_corner, from_plane_origin }
    }
}

/// Fills the lane inputs of a batch of quads. `tile_corner`: the tile's top-left pixel.
#[inline(always)]
pub(super) fn fill_quads<R: Real>(
    draw: &PreparedDraw<'_, R>,
    run: &mut dyn LaneRun<R>,
    quads: &[Quad; QUADS_PER_BATCH],
    pixel_centres: &PixelCentres,
    tile_corner: [u32; 2],
) {
    // Pixel centres relative to the top-left corner of their span's first quad.
    let (mut x, mut y) = ([R::ZERO; LANES], [R::ZERO; LANES]);
    let mut spans = SmallVec::<[Span<'_>; QUADS_PER_BATCH]>::new();
    let mut start = 0;
    while let Some(first) = quads.get(start) {
        let end = start + quads[start..].iter().take_while(|q| q.source_triangle == first.source_triangle).count();
        let quad_corner = quad_position(first.index.into());
        fill_relative_centres(&mut x, &pixel_centres.x, quads, start..end, quad_corner[0] as f32);
        fill_relative_centres(&mut y, &pixel_centres.y, quads, start..end, quad_corner[1] as f32);
        spans.push(Span::new(draw, [start, end], *first, tile_corner));
        start = end;
    }
    fill_spans(draw, run, &spans, [&x, &y]);
}

/// As [`fill_quads`] for a batch of one triangle. `points`: x and y of each lane in pixels, relative to the top-left corner of `first_quad`; values after the
/// first [`LANES`] are ignored.
#[inline(always)]
pub(super) fn fill_block<R: Real>(
    draw: &PreparedDraw<'_, R>,
    run: &mut dyn LaneRun<R>,
    first_quad: Quad,
    points: [&[f32]; 2],
    tile_corner: [u32; 2],
) {
    let spans = [Span::new(draw, [0, QUADS_PER_BATCH], first_quad, tile_corner)];
    let [Some(x), Some(y)] = points.map(|along_axis| along_axis.first_chunk::<LANES>()) else { return };
    let lanes = |values| R::from_f32_slice(values).and_then(|lanes| lanes.first_chunk::<LANES>());
    match (lanes(x), lanes(y)) {
        // The lanes are f32, so the points are used without a copy.
        (Some(x), Some(y)) => fill_spans(draw, run, &spans, [x, y]),
        _ => {
            let [x, y] = [x, y].map(|values| values.map(|value| R::from_f64(value.into())));
            fill_spans(draw, run, &spans, [&x, &y]);
        }
    }
}

/// Fills the lane inputs of spans that together make up the batch. `x`, `y`: each lane's position relative to the top-left corner of its span's first quad.
#[inline(always)]
fn fill_spans<R: Real>(draw: &PreparedDraw<'_, R>, run: &mut dyn LaneRun<R>, spans: &[Span<'_>], [x, y]: [&[R; LANES]; 2]) {
    let sources = &draw.fragment_setup.input_sources;
    let any_perspective = spans.iter().any(|s| !s.triangle.is_affine);
    // Clip-space w of each lane, needed only to interpolate varyings in perspective; 1 in the lanes of affine triangles.
    let w = (any_perspective && sources.iter().any(|s| matches!(s, FragmentInputSource::Interpolated(_)))).then(|| {
        let mut w = [R::ONE; LANES];
        for span in spans.iter().filter(|s| !s.triangle.is_affine) {
            span.evaluate(&mut w, [x, y], &span.triangle.inverse_w);
            span.quads_of(&mut w).iter_mut().for_each(|w| *w = w.map(|w| R::ONE / w));
        }
        w
    });
    for (k, source) in sources.iter().enumerate().filter(|(_, source)| **source != FragmentInputSource::Unread) {
        let lanes = run.input(k);
        for span in spans {
            let triangle = span.triangle;
            match *source {
                FragmentInputSource::PixelX | FragmentInputSource::PixelY => {
                    let (axis, offsets) = if *source == FragmentInputSource::PixelX { (0, x) } else { (1, y) };
                    let first_corner = R::from_f64(span.first_corner[axis]);
                    span.combine(lanes, offsets, |_, offset| first_corner + offset);
                }
                FragmentInputSource::Depth => span.evaluate(lanes, [x, y], &triangle.depth),
                FragmentInputSource::InverseW => span.evaluate(lanes, [x, y], &triangle.inverse_w),
                FragmentInputSource::Interpolated(index) => {
                    span.evaluate(lanes, [x, y], &draw.geometry.planes[triangle.first_plane + index]);
                    if let Some(w) = w.as_ref().filter(|_| !triangle.is_affine) {
                        span.combine(lanes, w, |lane, w| lane * w);
                    }
                }
                FragmentInputSource::Flat(index) => {
                    span.fill(lanes, R::from_f64(draw.geometry.flat_values[triangle.first_flat_value + index]))
                }
                FragmentInputSource::FrontFacing => span.fill(lanes, R::from_mask(triangle.is_front_facing)),
                FragmentInputSource::Zero | FragmentInputSource::Unread => span.fill(lanes, R::ZERO),
            }
        }
    }
}
