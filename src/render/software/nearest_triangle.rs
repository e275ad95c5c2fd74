//! Finds the triangles of a mesh that may be visible at a pixel's centre.
//!
//! In: a draw of a mesh and its vertex program. Out: for each triangle that may cover the centre, nearest first, a mesh of this triangle alone, with the
//! attributes of the draw's mesh and three indices. These triangles are candidates: the rasteriser rounds corners to a grid finer than pixels, and counts a
//! centre on an edge as covered by only one of the two triangles at the edge. The first candidate that covers the centre in the rasteriser is the visible
//! triangle. Barycentric coordinates are computed in homogeneous clip space, so that triangles that extend behind the camera are included.

use super::RenderError;
use super::math::Real;
use super::stage::LaneStage;
use super::vertex::clip_positions;
use crate::render::plan::{Cull, FrontFace, PlanDraw, Vertices};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// A triangle whose edges miss the pixel's centre by less than this, in pixels along each axis, is still a candidate. The margin is greater than the rounding
/// of corners ([`VertexGrid`](super::VertexGrid)), which is at most 1/512 pixel.
const MARGIN_PX: f64 = 1.0 / 256.0;

/// The candidates at the centre of a pixel, nearest first; `None` if the draw is not a mesh.
///
/// # Errors
/// As [`clip_positions`].
pub(crate) fn nearest_triangles<R: Real>(
    draw: &PlanDraw,
    vertex: &dyn LaneStage<R>,
    [width, height]: [u32; 2],
    [x, y]: [u32; 2],
) -> Result<Option<Vec<Vertices>>, RenderError> {
    let Vertices::Mesh { attributes, indices } = &draw.vertices else { return Ok(None) };
    let positions = clip_positions(draw, vertex)?;
    // `None` if the index is out of range: the triangle is no candidate.
    let clip_xyw = |k: u32| positions.position(k).map(|[x, y, _, w]| DVec3::new(x, y, w));
    // The centre of pixel `k` along an axis of `size` pixels, from -1 to 1.
    let ndc = |k: u32, size: u32| (2.0 * f64::from(k) + 1.0) / f64::from(size) - 1.0;
    // Rows of pixels count downwards.
    let pixel_centre = DVec3::new(ndc(x, width), -ndc(y, height), 1.0);
    // MARGIN_PX in normalised device coordinates.
    let [margin_x, margin_y] = [width, height].map(|size| 2.0 * MARGIN_PX / f64::from(size));
    // 1/w of a triangle at the pixel's centre, greatest for the nearest triangle; `None` if the triangle is no candidate. The weights are the barycentric
    // coordinates divided by w, so their sum is 1/w.
    let inverse_w = |triangle: &[u32]| {
        let corners = DMat3::from_cols(clip_xyw(triangle[0])?, clip_xyw(triangle[1])?, clip_xyw(triangle[2])?);
        // Positive for a triangle that winds counter-clockwise on the screen, negative for a clockwise one, 0 edge-on.
        let determinant = corners.determinant();
        let is_front = (determinant < 0.0) == (draw.front_face == FrontFace::Clockwise);
        if determinant == 0.0 || (draw.cull == Cull::Back && !is_front) {
            return None;
        }
        let inverse = corners.inverse();
        let weights = inverse * pixel_centre;
        // The greatest value of each weight within the margin around the centre along each axis.
        let greatest_weights = weights + inverse.x_axis.abs() * margin_x + inverse.y_axis.abs() * margin_y;
        // 1/w is positive in front of the camera.
        let sum = weights.x + weights.y + weights.z;
        (greatest_weights.min_element() >= 0.0 && sum > 0.0).then_some(sum)
    };
    let mut found: Vec<(f64, &[u32])> = indices.chunks_exact(3).filter_map(|t| Some((inverse_w(t)?, t))).collect();
    found.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let vertices_of = |triangle: &[u32]| Vertices::Mesh { attributes: attributes.clone(), indices: Arc::new(triangle.to_vec()) };
    Ok(Some(found.into_iter().map(|(_, triangle)| vertices_of(triangle)).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::plan::{Attribute, Blend, DepthState, Instances, Pass, ShadingRate};
    use crate::render::software::VertexGrid;
    use crate::render::software::exec::LaneMask;
    use crate::render::software::pass::{DrawStages, PassImage, execute};
    use crate::render::software::program::{LaneInput, LaneOutput};
    use crate::render::software::stage::{LANES, LaneRun};
    use crate::shader::ModuleId;

    const SIZE: u32 = 16;

    /// A stage that copies its inputs to its outputs; without inputs, the outputs are zeros.
    struct PassThrough {
        inputs: Vec<LaneInput>,
        outputs: Vec<LaneOutput>,
    }

    /// The values of up to four inputs, which are also the outputs.
    struct PassThroughRun([[f32; LANES]; 4]);

    impl LaneStage<f32> for PassThrough {
        fn inputs(&self) -> &[LaneInput] {
            &self.inputs
        }
        fn outputs(&self) -> &[LaneOutput] {
            &self.outputs
        }
        fn uses_discard(&self) -> bool {
            false
        }
        fn new_run(&self) -> Box<dyn LaneRun<f32> + Send + '_> {
            Box::new(PassThroughRun([[0.0; LANES]; 4]))
        }
    }

    impl LaneRun<f32> for PassThroughRun {
        fn input(&mut self, k: usize) -> &mut [f32; LANES] {
            &mut self.0[k]
        }
        fn run(&mut self, active: LaneMask) -> LaneMask {
            active
        }
        fn output(&self, k: usize) -> &[f32; LANES] {
            &self.0[k]
        }
    }

    /// For each candidate at a pixel, whether the rasteriser covers the pixel's centre with it. `corners`: clip-space positions, three per triangle.
    fn coverage_by_candidates(corners: &[[f32; 4]], [x, y]: [u32; 2]) -> Vec<bool> {
        let attribute = Attribute { components: 4, values: Arc::new(corners.concat()) };
        let draw = PlanDraw {
            label: "test".into(),
            // Any module: the stages below run instead.
            module: ModuleId::Simple("tone_map"),
            uniform_bytes: Vec::new(),
            textures: Vec::new(),
            samplers: Vec::new(),
            vertices: Vertices::Mesh { attributes: vec![attribute], indices: Arc::new((0..corners.len() as u32).collect()) },
            instances: Instances { count: 1, attributes: Vec::new() },
            blend: Blend::Replace,
            shading_rate: ShadingRate::PerPixel,
            cull: Cull::None,
            front_face: FrontFace::default(),
            depth: DepthState { test: false, write: false },
            // The pixel alone.
            scissor: [x, y, x + 1, y + 1],
            extent: None,
        };
        let vertex = PassThrough {
            inputs: (0..4).map(|component| LaneInput::Location { index: 0, component, flat: false }).collect(),
            outputs: (0..4).map(|component| LaneOutput::Position { component }).collect(),
        };
        let fragment = PassThrough {
            inputs: Vec::new(),
            outputs: (0..4).map(|component| LaneOutput::Location { index: 0, component, flat: false }).collect(),
        };
        let is_covered_by = |vertices: Vertices| {
            // Pixels that are not covered are NaN.
            let pass = Pass::of_numbers("test", SIZE, SIZE, vec![PlanDraw { vertices, ..draw.clone() }]);
            let stages = [DrawStages { vertex: &vertex, vertex_grid: VertexGrid::Gpu, fragment: &fragment }];
            let (image, _) = execute::<f32>(&pass, &stages).expect("drawn");
            matches!(image, PassImage::Float(pixels) if !pixels[(y * SIZE + x) as usize][0].is_nan())
        };
        let candidates = nearest_triangles::<f32>(&draw, &vertex, [SIZE; 2], [x, y]).expect("runs").expect("a mesh");
        candidates.into_iter().map(is_covered_by).collect()
    }

    /// The diagonal of a square passes through pixel centres. The rasteriser gives each to one of the halves, which need not be the first candidate.
    #[test]
    fn one_candidate_covers_a_centre_on_an_edge() {
        let [a, b, c, d] = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[x, y]| [x, y, 0.5, 1.0]);
        let (upper, lower) = ([a, d, b], [a, c, d]);
        for pixel in [[0, 0], [7, 7], [15, 15]] {
            let orders = [[upper, lower], [lower, upper]].map(|halves| coverage_by_candidates(&halves.concat(), pixel));
            for coverage in &orders {
                assert_eq!(coverage.iter().filter(|is_covered| **is_covered).count(), 1, "{pixel:?}: {coverage:?}");
            }
            assert!(orders.iter().any(|coverage| !coverage[0]), "{pixel:?}: the first candidate alone would do");
        }
    }

    /// Rounding to the GPU's grid moves an edge 0.001 pixels to the right of a pixel's centre onto the centre, which then belongs to the triangle on the right.
    #[test]
    fn a_triangle_beside_the_centre_is_a_candidate_if_rounding_may_move_its_edge_there() {
        let triangle = |edge_px: f32, apex_clip_x: f32| {
            let x = 2.0 * edge_px / SIZE as f32 - 1.0;
            [[x, -3.0, 0.5, 1.0], [x, 3.0, 0.5, 1.0], [apex_clip_x, 0.0, 0.5, 1.0]]
        };
        let (left, right) = (triangle(8.501, -5.0), triangle(8.501, 5.0));
        assert_eq!(coverage_by_candidates(&left, [8, 8]), [false], "the triangle that contains the centre before rounding");
        let both = coverage_by_candidates(&[left, right].concat(), [8, 8]);
        assert!(both.len() == 2 && both.contains(&true), "{both:?}");
        assert!(coverage_by_candidates(&triangle(8.51, 5.0), [8, 8]).is_empty(), "an edge that rounding does not move so far");
    }
}
