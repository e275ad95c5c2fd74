//! Which triangle of a mesh shows at a pixel's middle.
//!
//! In: a draw by triangles, and the layout of the uniforms that place them (shaders/lib/mesh.wesl). Out: the same vertices with the nearest triangle
//! alone, so that the values of one pixel are those of what is seen there and not of what lies behind. In f64, by the triangles' edges in
//! homogeneous coordinates, so that a triangle which reaches behind the camera counts as well.

use crate::render::plan::{Cull, PlanDraw, Vertices};
use crate::shader::Layout;
use glam::{DMat3, DMat4, DVec3};
use std::sync::Arc;

/// The numbers of a uniform field.
fn field<const N: usize>(draw: &PlanDraw, layout: &Layout, name: &str) -> Option<[f64; N]> {
    let at = layout.fields.iter().find(|f| f.name == name)?.offset as usize;
    let mut all = [0.0; N];
    for (slot, bytes) in all.iter_mut().zip(draw.uniforms.get(at..at + 4 * N)?.chunks_exact(4)) {
        *slot = f64::from(f32::from_le_bytes(bytes.try_into().ok()?));
    }
    Some(all)
}

/// The nearest triangle at the middle of a pixel; `None` where the draw is no mesh or no triangle is there.
pub fn nearest_triangle(draw: &PlanDraw, layout: &Layout, [width, height]: [u32; 2], [x, y]: [u32; 2]) -> Option<Vertices> {
    let Vertices::Mesh { attributes, indices } = &draw.vertices else { return None };
    let matrix = DMat4::from_cols_array(&field(draw, layout, "clip_from_unit_sphere")?);
    let anchor = DVec3::from_array(field(draw, layout, "mesh_anchor")?);
    let places = &attributes.first().filter(|a| a.components == 3)?.values;
    let clip = |k: u32| {
        let p = places.get(3 * k as usize..)?.get(..3)?;
        let p = DVec3::new(p[0].into(), p[1].into(), p[2].into());
        let c = matrix * (p - anchor).extend(1.0);
        Some(DVec3::new(c.x, c.y, c.w))
    };
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
    let found = indices.chunks_exact(3).filter_map(|t| Some((nearness(t)?, t))).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Vertices::Mesh { attributes: attributes.clone(), indices: Arc::new(found.1.to_vec()) })
}
