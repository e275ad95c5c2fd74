//! Which triangle of a mesh shows at a pixel's middle.
//!
//! In: a draw by triangles and its vertex program. Out: the same vertices with the nearest triangle alone, so that the values of one pixel are those of
//! what is seen there and not of what lies behind. Works on the triangles' edges in homogeneous coordinates, so that a triangle which reaches behind
//! the camera counts as well.

use super::RenderError;
use super::math::Real;
use super::stage::LaneProgram;
use super::vertex::clip_positions;
use crate::render::plan::{Cull, PlanDraw, Vertices};
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// The nearest triangle at the middle of a pixel; `None` where the draw is no mesh or no triangle is there.
///
/// # Errors
/// As [`clip_positions`].
pub fn nearest_triangle<R: Real>(
    draw: &PlanDraw,
    vertex: &dyn LaneProgram<R>,
    [width, height]: [u32; 2],
    [x, y]: [u32; 2],
) -> Result<Option<Vertices>, RenderError> {
    let Vertices::Mesh { attributes, indices } = &draw.vertices else { return Ok(None) };
    let positions = clip_positions(draw, vertex)?;
    let clip = |k: u32| positions.position(k).map(|[x, y, _, w]| DVec3::new(x, y, w));
    let middle = |k: u32, size: u32| (2.0 * f64::from(k) + 1.0) / f64::from(size) - 1.0;
    let ray = DVec3::new(middle(x, width), -middle(y, height), 1.0);
    // One over the depth, which is greatest where the triangle is nearest.
    let nearness = |t: &[u32]| {
        let corners = DMat3::from_cols(clip(t[0])?, clip(t[1])?, clip(t[2])?);
        let determinant = corners.determinant();
        if determinant == 0.0 || (draw.cull == Cull::Back && determinant < 0.0) {
            return None;
        }
        let weights = corners.inverse() * ray;
        let sum = weights.x + weights.y + weights.z;
        (weights.min_element() >= 0.0 && sum > 0.0).then_some(sum)
    };
    let found = indices.chunks_exact(3).filter_map(|t| Some((nearness(t)?, t))).max_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found.map(|(_, triangle)| Vertices::Mesh { attributes: attributes.clone(), indices: Arc::new(triangle.to_vec()) }))
}
