//! Shape models: when a body is drawn as triangles, its rectangle on the screen, and the uniforms that transform its vertices.
//!
//! In: the models that were read for the request, the body's placement. Out: whether a body has a mesh or needs one, a bounding rectangle, and the origin and
//! matrix by which shaders/lib/mesh.wesl computes clip positions (`mesh_anchor`, `clip_from_unit_sphere`). Everything else still uses the body's ellipsoid:
//! maps, size, exposure, the shadow on other bodies and on rings, and the test whether the camera is inside. Vertices are in the unit-sphere frame of the
//! ellipsoid.

use crate::catalog::Body;
use crate::mesh::Mesh;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{self, Camera, ClipRect, NEAR_DEPTH_KM, Placement};
use crate::scene::draw::features::MeshFlags;
use crate::scene::placed::PlacedBody;
use crate::scene::point::POINT_ONLY_BELOW_PX;
use crate::scene::request::effects::Effect;
use crate::scene::resources::Context;
use glam::{DVec3, DVec4, Mat4};
use std::sync::Arc;

/// Distance of the camera from the body's centre, in the unit-sphere frame, within which the shader subtracts the camera's position from the vertices. The
/// difference is rounded to f32 relative to its own length, so vertices close to the camera keep their directions. With a farther camera the difference would
/// lose the last digits of the vertices, so these stay relative to the body's centre.
const NEAR_RADII: f64 = 8.0;
/// Smallest relative difference of reversed depth between a mesh's centre and its near side: 84 steps of f32 (2^-23). Beyond 1e5 radii the true difference is
/// smaller and could not order the triangles. This minimum makes the depth relative to other bodies wrong, by up to this fraction of the distance.
const MIN_DEPTH_RATIO: f64 = 1e-5;

/// The triangles of the shape model with which a body is drawn; `None` if the catalog has no model, if its file is unreadable or not loaded yet, or if the user
/// switched it off.
pub(crate) fn mesh_of<'r>(context: Context<'r>, body: &Body) -> Option<&'r Arc<Mesh>> {
    body.mesh
        .as_ref()
        .filter(|m| !context.resources.is_unreadable(&m.file) && context.request.effects.override_of(Effect::Mesh) != Some(false))?;
    context.resources.meshes.get(&body.id)
}

/// Whether a body's shape model is needed: the body is larger than a point, the file is readable, and the user has not switched meshes off.
pub(crate) fn is_required(context: Context<'_>, camera: &Camera, placed: &PlacedBody<'_>) -> bool {
    let is_large = 2.0 * placed.body.radii_km.max_element() / placed.distance_km.max(1e-9) / camera.pixel_tangent() > POINT_ONLY_BELOW_PX;
    let has_readable_model = placed.body.mesh.as_ref().is_some_and(|m| !context.resources.is_unreadable(&m.file));
    is_large && has_readable_model && context.request.effects.override_of(Effect::Mesh) != Some(false)
}

/// The rectangle of the image that the mesh may touch; `None` if the mesh is outside the image.
pub(crate) fn rect(camera: &Camera, placement: &Placement, mesh: &Mesh) -> Option<ClipRect> {
    // Only a mesh without extent has a smaller `max_radius`; `Outline` divides by it.
    let bounds = Placement { radii_km: placement.radii_km * mesh.max_radius.max(1e-9), ..*placement };
    if bounds.camera_is_inside() { Some(ClipRect::VIEWPORT) } else { Outline::of(camera, &bounds).rect(camera) }
}

/// The flags of a draw of the mesh.
pub(crate) fn flags(body: &Body, mesh: &Mesh) -> MeshFlags {
    body.mesh.as_ref().map_or_else(MeshFlags::default, |m| MeshFlags {
        two_sided: m.two_sided,
        alpha_texture: m.has_map_alpha,
        vertex_colour: m.uses_vertex_colours && mesh.colours.is_some(),
    })
}

/// The origin (camera or body's centre, in the unit-sphere frame) that the shader subtracts from each vertex as `mesh_anchor`, and the matrix that transforms
/// the difference to clip space.
pub(crate) fn clip_from_unit_sphere(camera: &Camera, placement: &Placement) -> (glam::Vec3, Mat4) {
    let camera_position = placement.camera_in_unit_sphere();
    let vertex_origin = if camera_position.length() < NEAR_RADII { camera::narrow(camera_position) } else { glam::Vec3::ZERO };
    let unit_km = placement.radii_km.x;
    let icrf_from_body = placement.body_from_icrf.transpose();
    let from_camera_km = placement.centre_km + icrf_from_body * (vertex_origin.as_dvec3() * placement.radii_km);
    let near = NEAR_DEPTH_KM / unit_km;
    // Reversed depth, z / w = near / view depth, decreases by about the fraction radius / distance per radius of view depth. If this is less than
    // `MIN_DEPTH_RATIO`, z (otherwise constant) decreases by the missing fraction per radius behind the body's centre. For a near camera nothing is missing.
    let added_slope = (MIN_DEPTH_RATIO - unit_km / placement.centre_km.length()).max(0.0);
    // `homogeneous`: 1 for the position of the vertices' origin relative to the camera, 0 for a body axis, along which only the change of z counts.
    let clip = |v_km: DVec3, homogeneous: f64| {
        let v = v_km / unit_km;
        let depth = v.dot(camera.forward);
        let across = DVec3::new(v.dot(camera.right) / camera.tan_half_fov.x, v.dot(camera.up) / camera.tan_half_fov.y, 0.0);
        let z = near * (homogeneous - added_slope * if homogeneous == 0.0 { depth } else { 0.0 });
        camera::narrow4(DVec4::new(across.x, across.y, z, depth))
    };
    let axis = |k: usize| clip(icrf_from_body.col(k) * placement.radii_km[k], 0.0);
    (vertex_origin, Mat4::from_cols(axis(0), axis(1), axis(2), clip(from_camera_km, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec2};

    /// The pixel of a vertex as the shader computes it in f32, the exact pixel (`None` behind the camera), and the ratio of the computed reversed depth to the
    /// exact one.
    fn vertex_pixels(camera: &Camera, placement: &Placement, vertex: glam::Vec3) -> (DVec2, Option<DVec2>, f64) {
        let (vertex_origin, matrix) = clip_from_unit_sphere(camera, placement);
        let clip = matrix * (vertex - vertex_origin).extend(1.0);
        let from_camera_km = placement.centre_km + placement.body_from_icrf.transpose() * (vertex.as_dvec3() * placement.radii_km);
        let computed = DVec2::new(f64::from(clip.x / clip.w), f64::from(clip.y / clip.w));
        let depth_ratio = f64::from(clip.z / clip.w) * from_camera_km.dot(camera.forward) / NEAR_DEPTH_KM;
        (camera.pixel_from_clip(computed), camera.clip(from_camera_km).map(|c| camera.pixel_from_clip(c)), depth_ratio)
    }

    #[test]
    fn vertices_are_accurate_from_a_metre_above_the_ground_to_a_telescope() {
        let body_from_icrf = DMat3::from_axis_angle(DVec3::new(0.3, -0.5, 0.8).normalize(), 1.1);
        // Sizes of the Moon, of Phobos and of a small asteroid.
        for (radii_km, height_km) in [(1737.4, 1e-3), (11.0, 1e-3), (11.0, 10.0), (1737.4, 4e5), (11.0, 8e7), (0.2, 1.5e8)] {
            let radii_km = DVec3::new(radii_km, 0.9 * radii_km, 0.8 * radii_km);
            let up = DVec3::new(0.6, 0.48, 0.64);
            let vertex = up.as_vec3();
            let camera_km = vertex.as_dvec3() * radii_km + up * height_km;
            let placement = Placement { centre_km: body_from_icrf.transpose() * -camera_km, body_from_icrf, radii_km };
            // The camera looks obliquely, so that the vertex is not in the middle. The body is about 500 of 1000 pixels wide; near the ground the field of view
            // is 60 degrees instead. 1e-7 degrees is the narrowest that a request may have.
            let fov_deg = (4.0 * radii_km.x / height_km).atan().to_degrees().clamp(1e-7, 60.0);
            let down = body_from_icrf.transpose() * -up;
            let forward = (down + down.any_orthonormal_vector() * 0.3 * (0.5 * fov_deg.to_radians()).tan()).normalize();
            let camera = Camera::looking(DVec3::ZERO, forward, DVec3::Z, fov_deg, 1000, 1000);
            let (computed, exact, depth_ratio) = vertex_pixels(&camera, &placement, vertex);
            let error_px = (computed - exact.expect("in front of the camera")).length();
            assert!(error_px < 0.02, "{height_km} km over {radii_km}: {error_px} pixels");
            // `MIN_DEPTH_RATIO`, and a tenth of it for rounding.
            assert!((depth_ratio - 1.0).abs() < 1.1e-5, "{height_km} km over {radii_km}: depth is wrong by {}", depth_ratio - 1.0);
        }
    }

    #[test]
    fn the_near_side_is_nearer_at_any_distance() {
        for distance_km in [1e2, 1e6, 1e9] {
            let placement = Placement { centre_km: DVec3::X * distance_km, body_from_icrf: DMat3::IDENTITY, radii_km: DVec3::splat(10.0) };
            let camera = Camera::looking(DVec3::ZERO, DVec3::X, DVec3::Z, 1e-3, 100, 100);
            // Reversed depth of a point on the x axis, which points away from the camera.
            let reversed_depth = |x: f32| {
                let (vertex_origin, matrix) = clip_from_unit_sphere(&camera, &placement);
                let clip = matrix * (glam::Vec3::new(x, 0.0, 0.0) - vertex_origin).extend(1.0);
                clip.z / clip.w
            };
            let far_to_near: Vec<f32> = (0..=20).map(|k| reversed_depth(1.0 - 0.1 * k as f32)).collect();
            assert!(far_to_near.windows(2).all(|w| w[1] > w[0]), "{distance_km}: {far_to_near:?}");
        }
    }
}
