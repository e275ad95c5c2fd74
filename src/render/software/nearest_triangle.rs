//! Finds the triangle of a mesh that is visible at a pixel's centre.
//!
//! In: a draw of a mesh and its vertex program. Out: the draw's vertices with the indices of the nearest triangle only, so that inspected values are
//! those of the visible surface. Barycentric coordinates are computed in homogeneous clip space, so that triangles that extend behind the camera are
//! included.

use super::RenderError;
use super::math::Real;
use super::stage::LaneProgram;
use super::vertex::clip_positions;
use crate::render::plan::{Cull, PlanDraw, Vertices};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// The nearest triangle at the centre of a pixel; `None` if the draw is not a mesh or no triangle covers the centre.
///
/// # Errors
/// As [`clip_positions`].
pub(crate) fn nearest_triangle<R: Real>(
    draw: &PlanDraw,
    vertex: &dyn LaneProgram<R>,
    [width, height]: [u32; 2],
    [x, y]: [u32; 2],
) -> Result<Option<Vertices>, RenderError> {
    let Vertices::Mesh { attributes, indices } = &draw.vertices else { return Ok(None) };
    let positions = clip_positions(draw, vertex)?;
    let clip_xyw = |k: u32| positions.position(k).map(|[x, y, _, w]| DVec3::new(x, y, w));
    let ndc = |k: u32, size: u32| (2.0 * f64::from(k) + 1.0) / f64::from(size) - 1.0;
    let pixel_centre = DVec3::new(ndc(x, width), -ndc(y, height), 1.0);
    // The weights are the barycentric coordinates divided by w, so their sum is 1/w, which is greatest for the nearest triangle.
    let inverse_w = |triangle: &[u32]| {
        let corners = DMat3::from_cols(clip_xyw(triangle[0])?, clip_xyw(triangle[1])?, clip_xyw(triangle[2])?);
        let determinant = corners.determinant();
        if determinant == 0.0 || (draw.cull == Cull::Back && determinant < 0.0) {
            return None;
        }
        let weights = corners.inverse() * pixel_centre;
        let sum = weights.x + weights.y + weights.z;
        (weights.min_element() >= 0.0 && sum > 0.0).then_some(sum)
    };
    let found = indices.chunks_exact(3).filter_map(|t| Some((inverse_w(t)?, t))).max_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found.map(|(_, triangle)| Vertices::Mesh { attributes: attributes.clone(), indices: Arc::new(triangle.to_vec()) }))
}
