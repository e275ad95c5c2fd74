//! Self-shadowing of a mesh: at each vertex, the altitude of the Sun, which is its angle above the horizon that the mesh itself forms.
//!
//! In: a mesh, the direction of the Sun and its angular radius. Out: the altitude of the Sun's centre at each vertex, in units of that radius: above 1 the
//! whole disc is visible, below -1 it is hidden, in between a straight horizon cuts it. Rays are traced in f64 through a bounding volume hierarchy, in the
//! plane of the vertex's normal and the Sun: upward from a hidden Sun or downward from a visible one, until visibility changes; bisection refines the altitude.
//!
//! Error: the altitude is measured from the edge of the mesh that is nearest above a hidden Sun or below a visible one. It is accurate to a quarter of the
//! Sun's radius or a tenth of the altitude, whichever is more. But only the directions 1, 4, 16, ... solar radii from the Sun are tested, so a gap or an
//! obstacle between two of them may be missed; the altitude is then measured from a farther edge. Between vertices the altitude is interpolated. The edge of a
//! smooth hill's shadow is accurate to less than a triangle's side. The edge of the shadow of something that is smaller than a triangle, or farther than a
//! triangle's side from the ground in its shadow, is accurate to the length of such a side. Not here: shadows in the light of other bodies.

use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

/// Altitudes are clamped to plus or minus this angle (5 degrees). Otherwise the interpolated altitude would be too steep between a vertex that sees past a peak
/// and a neighbour that does not.
const MAX_ALTITUDE_RAD: f64 = 0.0873;
/// Maximum number of triangles in a leaf of the tree.
const MAX_LEAF_TRIANGLES: usize = 4;
/// Distance of the nearest hit that counts, per largest side of the mesh's box: far above the rounding of f64, far below a triangle.
const MIN_HIT_PER_SIZE: f64 = 1e-9;
/// The Sun's angular radius is clamped to this range, radians. Altitudes are divided by it, so it must not be 0; the upper bound is the radius seen from about
/// two solar radii away.
const SUN_RADIUS_RANGE_RAD: [f64; 2] = [1e-6, 0.5];
/// Vertices per parallel task.
const VERTICES_PER_TASK: usize = 512;

/// A vertex of a mesh for ray casting, in body axes.
pub(crate) struct RayCastVertex {
    pub position_km: DVec3,
    /// Unit vector.
    pub normal: DVec3,
}

/// A mesh prepared for ray casting.
pub(crate) struct RayCastMesh {
    vertices: Vec<RayCastVertex>,
    /// For each vertex an id that vertices at the same position share: triangles with a corner there do not occlude the vertex.
    position_ids: Vec<u32>,
    /// Indices in `vertices`.
    triangles: Vec<[u32; 3]>,
    /// Whether both sides of a triangle are lit.
    two_sided: bool,
    /// Built on first use.
    tree: OnceLock<Bvh>,
}

/// A bounding volume hierarchy.
struct Bvh {
    nodes: Vec<Node>,
    /// Indices of the triangles, in the order of the leaves.
    order: Vec<u32>,
    /// Hits nearer than this are the surface itself.
    min_hit_km: f64,
}

struct Node {
    /// Corners of the bounding box, kilometres.
    low: DVec3,
    high: DVec3,
    /// Leaf: index in `order` of its first triangle. Inner node: index of its second child; the first child is the next node.
    start_or_second_child: u32,
    /// Leaf: number of triangles. Inner node: 0.
    triangle_count: u32,
}

impl Bvh {
    fn new(mesh: &RayCastMesh) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: Vec::new(), min_hit_km: 0.0 };
        let centroids: Vec<DVec3> = mesh.triangles.iter().map(|t| t.iter().map(|k| mesh.position_km(*k)).sum::<DVec3>() / 3.0).collect();
        let mut order: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let first_in_order = 0;
        tree.build_node(mesh, &centroids, &mut order, first_in_order);
        tree.order = order;
        tree.min_hit_km = tree.nodes.first().map_or(0.0, |n| MIN_HIT_PER_SIZE * (n.high - n.low).max_element());
        tree
    }

    /// Adds the node of these triangles and all nodes below it. `first_in_order`: index in `order` of the first of the triangles.
    fn build_node(&mut self, mesh: &RayCastMesh, centroids: &[DVec3], triangles: &mut [u32], first_in_order: usize) {
        let corners = || triangles.iter().flat_map(|t| mesh.triangles[*t as usize]).map(|k| mesh.position_km(k));
        let (low, high) = corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let node_index = self.nodes.len();
        self.nodes.push(Node { low, high, start_or_second_child: first_in_order as u32, triangle_count: triangles.len() as u32 });
        if triangles.len() <= MAX_LEAF_TRIANGLES {
            return;
        }
        let centroid = |t: &u32| centroids[*t as usize];
        let (min, max) = triangles.iter().map(centroid).fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let axis = (0..3).max_by(|a, b| (max - min)[*a].total_cmp(&(max - min)[*b])).unwrap_or(0);
        let half = triangles.len() / 2;
        triangles.select_nth_unstable_by(half, |a, b| centroid(a)[axis].total_cmp(&centroid(b)[axis]).then(a.cmp(b)));
        let (left, right) = triangles.split_at_mut(half);
        self.build_node(mesh, centroids, left, first_in_order);
        self.nodes[node_index].start_or_second_child = self.nodes.len() as u32;
        self.nodes[node_index].triangle_count = 0;
        self.build_node(mesh, centroids, right, first_in_order + half);
    }
}

/// Whether a ray from `origin` intersects the box of a node in front of `origin`.
fn intersects_box(node: &Node, origin: DVec3, inverse_direction: DVec3) -> bool {
    let (a, b) = ((node.low - origin) * inverse_direction, (node.high - origin) * inverse_direction);
    let (near, far) = (a.min(b), a.max(b));
    // The factor allows for rounding.
    near.max_element().max(0.0) <= far.min_element() * (1.0 + 1e-12)
}

impl RayCastMesh {
    /// `position_ids`: one per vertex, equal for vertices at one position; `indices`: three per triangle.
    pub(crate) fn new(vertices: Vec<RayCastVertex>, position_ids: &[u32], indices: &[u32], two_sided: bool) -> Self {
        let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        Self { vertices, position_ids: position_ids.to_vec(), triangles, two_sided, tree: OnceLock::new() }
    }

    fn position_km(&self, vertex: u32) -> DVec3 {
        self.vertices[vertex as usize].position_km
    }

    /// Whether a ray from a vertex intersects the mesh.
    fn is_occluded(&self, tree: &Bvh, vertex: usize, direction: DVec3) -> bool {
        let (origin, own_position_id) = (self.vertices[vertex].position_km, self.position_ids[vertex]);
        // The inverse is finite even for rays along an axis, where 0 times infinity would be NaN.
        let inverse_direction = DVec3::from_array(direction.to_array().map(|d| if d.abs() < 1e-30 { 1e30 } else { 1.0 / d }));
        let mut stack = [0_u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node_index = stack[depth] as usize;
            let node = &tree.nodes[node_index];
            if !intersects_box(node, origin, inverse_direction) {
                continue;
            }
            if node.triangle_count == 0 {
                // Each node is split into halves, so that the stack never holds more than 64 nodes.
                stack[depth] = node.start_or_second_child;
                stack[depth + 1] = node_index as u32 + 1;
                depth += 2;
                continue;
            }
            let leaf = node.start_or_second_child as usize..(node.start_or_second_child + node.triangle_count) as usize;
            for t in tree.order[leaf].iter().map(|t| self.triangles[*t as usize]) {
                if t.iter().any(|k| self.position_ids[*k as usize] == own_position_id) {
                    continue;
                }
                // Möller and Trumbore 1997.
                let [a, b, c] = t.map(|k| self.position_km(k));
                let (e1, e2) = (b - a, c - a);
                let p = direction.cross(e2);
                let determinant = e1.dot(p);
                if determinant == 0.0 {
                    continue;
                }
                let from_a = origin - a;
                let u = from_a.dot(p) / determinant;
                let q = from_a.cross(e1);
                let v = direction.dot(q) / determinant;
                if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && e2.dot(q) / determinant > tree.min_hit_km {
                    return true;
                }
            }
        }
        false
    }

    /// The altitude of the Sun's centre at a vertex, in radii of the Sun. `sun`: unit vector towards the Sun, body axes.
    fn altitude(&self, tree: &Bvh, vertex: usize, sun: DVec3, sun_radius_rad: f64) -> f64 {
        let outward = self.vertices[vertex].normal;
        let normal = if self.two_sided && outward.dot(sun) < 0.0 { -outward } else { outward };
        let cosine = normal.dot(sun).clamp(-1.0, 1.0);
        // Angle of the Sun above the tangent plane.
        let plane_altitude_rad = cosine.asin();
        if plane_altitude_rad < -sun_radius_rad {
            return plane_altitude_rad / sun_radius_rad;
        }
        // Perpendicular to the Sun's direction, in the plane of the normal and the Sun.
        let up = (normal - cosine * sun).try_normalize().unwrap_or_else(|| sun.any_orthonormal_vector());
        let is_occluded = |angle_rad: f64| self.is_occluded(tree, vertex, sun * angle_rad.cos() + up * angle_rad.sin());
        let is_hidden = is_occluded(0.0);
        // Search upward from a hidden Sun, or downward from a visible one to the tangent plane.
        let (sign, end_rad) = if is_hidden { (1.0, FRAC_PI_2) } else { (-1.0, plane_altitude_rad.max(0.0)) };
        // Tests larger and larger angles from the Sun until visibility changes: it does so between the angles `unchanged_rad` and `changed_rad`.
        let (mut unchanged_rad, mut tested_rad) = (0.0, sun_radius_rad);
        let mut changed_rad = loop {
            if tested_rad >= end_rad {
                return if is_hidden { -end_rad / sun_radius_rad } else { plane_altitude_rad / sun_radius_rad };
            }
            if is_occluded(sign * tested_rad) != is_hidden {
                break tested_rad;
            }
            unchanged_rad = tested_rad;
            tested_rad *= 4.0;
        };
        while changed_rad - unchanged_rad > (0.25 * sun_radius_rad).max(0.1 * unchanged_rad) {
            let middle_rad = 0.5 * (unchanged_rad + changed_rad);
            if is_occluded(sign * middle_rad) == is_hidden {
                unchanged_rad = middle_rad;
            } else {
                changed_rad = middle_rad;
            }
        }
        -sign * 0.5 * (unchanged_rad + changed_rad) / sun_radius_rad
    }

    /// The altitude of the Sun's centre at each vertex, in radii of the Sun. `towards_sun`: unit vector, body axes. `sun_radius_rad`: the Sun's
    /// angular radius.
    pub(crate) fn sun_altitudes(&self, towards_sun: DVec3, sun_radius_rad: f64) -> Vec<f32> {
        let tree = self.tree.get_or_init(|| Bvh::new(self));
        let sun_radius_rad = sun_radius_rad.clamp(SUN_RADIUS_RANGE_RAD[0], SUN_RADIUS_RANGE_RAD[1]);
        let max_altitude = MAX_ALTITUDE_RAD / sun_radius_rad;
        let altitude = |k| self.altitude(tree, k, towards_sun, sun_radius_rad).clamp(-max_altitude, max_altitude) as f32;
        (0..self.vertices.len()).into_par_iter().with_min_len(VERTICES_PER_TASK).map(altitude).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUN_RADIUS_RAD: f64 = 0.005;
    /// Place and height of the wall that most tests use.
    const WALL_X_KM: f64 = 1.5;
    const WALL_HEIGHT_KM: f64 = 0.5;
    /// The middle vertex of a floor of 4 x 4 cells, which has 5 x 5 vertices.
    const MIDDLE_OF_4_CELLS: usize = 12;

    /// A square floor at z = 0 of `n` by `n` cells from -1 to 1 km, and a wall at x = `wall_x_km` that faces it and rises `wall_height_km` above it.
    fn floor_and_wall(n: u32, wall_x_km: f64, wall_height_km: f64) -> RayCastMesh {
        let mut vertices = Vec::new();
        let mut indices = Vec::new();
        for j in 0..=n {
            for i in 0..=n {
                let coordinate = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
                vertices.push(RayCastVertex { position_km: DVec3::new(coordinate(i), coordinate(j), 0.0), normal: DVec3::Z });
                if i < n && j < n {
                    let index = j * (n + 1) + i;
                    indices.extend([index, index + 1, index + n + 2, index, index + n + 2, index + n + 1]);
                }
            }
        }
        let first = vertices.len() as u32;
        for (y, z) in [(-9.0, -0.1), (9.0, -0.1), (9.0, wall_height_km), (-9.0, wall_height_km)] {
            vertices.push(RayCastVertex { position_km: DVec3::new(wall_x_km, y, z), normal: DVec3::NEG_X });
        }
        indices.extend([first, first + 1, first + 2, first, first + 2, first + 3]);
        let position_ids: Vec<u32> = (0..vertices.len() as u32).collect();
        let two_sided = false;
        RayCastMesh::new(vertices, &position_ids, &indices, two_sided)
    }

    #[test]
    fn a_wall_hides_the_sun_up_to_its_height_seen_from_each_place() {
        let n = 8;
        let mesh = floor_and_wall(n, WALL_X_KM, WALL_HEIGHT_KM);
        for altitude_deg in [2.0_f64, 10.0, 15.0, 25.0, 60.0] {
            let plane_altitude_rad = altitude_deg.to_radians();
            let altitudes = mesh.sun_altitudes(DVec3::new(plane_altitude_rad.cos(), 0.0, plane_altitude_rad.sin()), SUN_RADIUS_RAD);
            let mut shadowed_and_lit = [0, 0];
            for (k, altitude) in altitudes.iter().enumerate().take(((n + 1) * (n + 1)) as usize) {
                let top_of_wall_rad = (WALL_HEIGHT_KM / (WALL_X_KM - mesh.vertices[k].position_km.x)).atan();
                let expected_rad = (plane_altitude_rad - top_of_wall_rad).clamp(-MAX_ALTITUDE_RAD, MAX_ALTITUDE_RAD);
                // The error that the module's comment states, a quarter of the Sun's radius or a tenth of the altitude, with a margin.
                let allowed = 0.26 + 0.11 * (expected_rad / SUN_RADIUS_RAD).abs();
                assert!(
                    (f64::from(*altitude) - expected_rad / SUN_RADIUS_RAD).abs() < allowed,
                    "{altitude_deg}: {altitude} against {}",
                    expected_rad / SUN_RADIUS_RAD
                );
                shadowed_and_lit[usize::from(expected_rad > 0.0)] += 1;
            }
            assert!(altitude_deg != 15.0 || shadowed_and_lit.iter().all(|n| *n > 8), "both light and shadow: {shadowed_and_lit:?}");
        }
    }

    #[test]
    fn the_sun_under_an_arch_is_seen() {
        // The wall begins above the ground: the view below its lower edge is free.
        let mut mesh = floor_and_wall(4, WALL_X_KM, WALL_HEIGHT_KM);
        let first_wall_vertex = mesh.vertices.len() - 4;
        let lower_edge_km = 0.3_f64;
        mesh.vertices[first_wall_vertex].position_km.z = lower_edge_km;
        mesh.vertices[first_wall_vertex + 1].position_km.z = lower_edge_km;
        // The altitude above the mesh's own horizon, in radii of the Sun, for a Sun at this altitude above the floor's plane.
        let altitude_above_mesh = |plane_altitude_rad: f64| {
            let towards_sun = DVec3::new(plane_altitude_rad.cos(), 0.0, plane_altitude_rad.sin());
            f64::from(mesh.sun_altitudes(towards_sun, SUN_RADIUS_RAD)[MIDDLE_OF_4_CELLS])
        };
        // Altitudes of the wall's edges above the floor's plane, seen from the middle.
        let (lower_edge_rad, top_rad) = ((lower_edge_km / WALL_X_KM).atan(), (WALL_HEIGHT_KM / WALL_X_KM).atan());
        assert!(altitude_above_mesh(0.5 * lower_edge_rad) > 1.0, "below the wall the whole disc is seen");
        assert!(altitude_above_mesh(0.5 * (lower_edge_rad + top_rad)) < -1.0, "behind the wall it is hidden");
        assert!(altitude_above_mesh(top_rad + 0.1) > 1.0, "above the wall it is seen");
    }

    #[test]
    fn two_sided_triangles_are_lit_from_both_sides() {
        let mut mesh = floor_and_wall(4, WALL_X_KM, WALL_HEIGHT_KM);
        let below = DVec3::new(0.6, 0.0, -0.8);
        assert!(mesh.sun_altitudes(below, SUN_RADIUS_RAD)[MIDDLE_OF_4_CELLS] < -1.0);
        mesh.two_sided = true;
        assert!(mesh.sun_altitudes(below, SUN_RADIUS_RAD)[MIDDLE_OF_4_CELLS] > 1.0);
    }

    #[test]
    fn altitudes_are_finite_for_any_direction_of_the_sun() {
        let mesh = floor_and_wall(2, WALL_X_KM, WALL_HEIGHT_KM);
        for sun in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y] {
            assert!(mesh.sun_altitudes(sun, 0.0).iter().all(|altitude| altitude.is_finite()));
        }
    }
}
