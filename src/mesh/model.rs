//! Builds a mesh from a file's faces, with one vertex for each combination of position, normal, texture coordinate and colour.
//!
//! In: an [`Obj`] and the body's [`ShapeParameters`]. Out: a [`Mesh`]. Missing data are computed: a normal as the mean of the faces around its position,
//! weighted by their areas; a texture coordinate from longitude and latitude as in the body's map. If a triangle crosses the map's seam, its texture
//! coordinates continue beyond the map's edge (the sampler repeats). A corner at a pole takes the mean longitude of the other two. A triangle that has a
//! pole inside or on an edge is split there, into three or two. Triangles without an area are dropped.

use super::obj::{Corner, Obj};
use super::self_shadow::{RayCastMesh, RayCastVertex};
use crate::units::srgb_to_linear;
use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// The properties of the body that the shape depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeParameters {
    /// Semi-axes of the body's ellipsoid.
    pub radii_km: DVec3,
    /// Kilometres per unit of the file.
    pub scale_km: f64,
    /// Factors on y (the first) and z (the second) of a point in the unit-sphere frame; x is kept. Longitude and latitude of the resulting direction are those
    /// of the map, whose latitude may be planetocentric or planetographic.
    pub map_stretch: DVec2,
    /// Whether both sides of each triangle are lit.
    pub two_sided: bool,
}

/// The reason why a file's triangles cannot be the shape of the body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// The file is in another unit, or of another body.
    #[error(
        "its farthest vertex is {farthest_km:.6} km from the centre; expected {} to {} times the body's {radius_km} km: is scale_km right?",
        FARTHEST_VERTEX_RANGE.start(),
        FARTHEST_VERTEX_RANGE.end()
    )]
    Size {
        /// Distance of the farthest vertex from the centre.
        farthest_km: f64,
        /// The body's largest semi-axis.
        radius_km: f64,
    },
    /// So many triangles overlap that computing the shape's own shadow would take minutes.
    #[error("its triangles overlap: a line meets the boxes around {overlap:.0} of them on average; expected at most {MAX_OVERLAP:.0}")]
    Overlap {
        /// Mean number of triangles' boxes that a line through the shape's box meets.
        overlap: f64,
    },
    /// Nothing to draw.
    #[error("none of its faces has an area")]
    NoArea,
}

/// Allowed distance of the farthest vertex from the centre, in units of the body's largest semi-axis; outside this range the file is in another unit.
const FARTHEST_VERTEX_RANGE: std::ops::RangeInclusive<f64> = 0.2..=4.0;
/// Maximum number of boxes of triangles that a line through the shape's box may meet on average. For a round shape it is 3, whatever its number of triangles.
const MAX_OVERLAP: f64 = 64.0;
/// A point counts as on a triangle's edge if its barycentric weight for the opposite corner is at most this, positive or negative; allows for rounding.
const MAX_EDGE_WEIGHT: f64 = 1e-9;
/// A corner is at a pole if its distance from the axis of rotation, in the unit-sphere frame, is below this.
const AXIS_TOLERANCE: f64 = 1e-7;

/// A shape ready to be drawn. Attribute arrays are flat, one vertex after the other.
pub struct Mesh {
    /// Positions in the unit-sphere frame, 3 numbers per vertex.
    pub positions: Arc<Vec<f32>>,
    /// Normals: unit vectors in body axes, 3 numbers per vertex.
    pub normals: Arc<Vec<f32>>,
    /// Texture coordinates, 2 numbers per vertex; u may be outside 0 to 1.
    pub map_coordinates: Arc<Vec<f32>>,
    /// Colours: linear RGB and an alpha of 1, 4 numbers per vertex; `None` if the file has no colours.
    pub colours: Option<Arc<Vec<f32>>>,
    /// Indices, three per triangle, counter-clockwise seen from outside.
    pub indices: Arc<Vec<u32>>,
    /// Distance of the farthest vertex from the centre, in the unit-sphere frame.
    pub max_radius: f64,
    /// The same mesh in f64, for self-shadowing.
    pub(super) ray_cast_mesh: RayCastMesh,
}

impl std::fmt::Debug for Mesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Mesh of {} vertices, {} triangles", self.vertex_count(), self.triangle_count())
    }
}

/// Meshes are compared by identity, because they are large and loaded once.
impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

/// A vertex in f64.
#[derive(Clone, Copy)]
struct Vertex {
    /// Body axes.
    position_km: DVec3,
    /// Unit vector, body axes.
    normal: DVec3,
    /// Texture coordinates.
    uv: DVec2,
    /// Linear RGB.
    colour: DVec3,
}

/// Corners with the same key share one vertex.
#[derive(PartialEq, Eq, Hash)]
struct VertexKey {
    position_id: u32,
    normal: [u64; 3],
    uv: [u64; 2],
    /// Repeated positions have one id ([`weld`]), but each may have its own colour.
    colour: [u64; 3],
}

/// Welds the positions: for each one, the index of the first position with the same coordinates. Some files repeat positions for each face.
fn weld(positions: &[DVec3]) -> Vec<u32> {
    let mut first_index: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    // Adding zero turns -0.0 into 0.0, whose bits differ.
    let bits = |p: &DVec3| (*p + DVec3::ZERO).to_array().map(f64::to_bits);
    (0..).zip(positions).map(|(k, p)| *first_index.entry(bits(p)).or_insert(k)).collect()
}

impl ShapeParameters {
    /// Texture coordinates of a position: (0, 0) at the upper left corner of the map, (1, 1) at the lower right.
    fn map_coordinates(&self, position_km: DVec3) -> DVec2 {
        let direction = position_km / self.radii_km * DVec3::new(1.0, self.map_stretch.x, self.map_stretch.y);
        DVec2::new(0.5 + direction.y.atan2(direction.x) / TAU, 0.5 - direction.z.atan2(direction.truncate().length()) / PI)
    }

    /// Whether a position is on the axis of rotation, which passes through the poles.
    fn is_on_axis(&self, position_km: DVec3) -> bool {
        (position_km / self.radii_km).truncate().length() < AXIS_TOLERANCE
    }
}

/// Barycentric coordinates of the point where the axis of rotation intersects a triangle; on an edge, the coordinate of the opposite corner is exactly 0.
/// `None` if the axis misses the triangle or meets a corner.
fn pole_weights(positions: [DVec3; 3]) -> Option<DVec3> {
    let p = positions.map(DVec3::truncate);
    let weights = DVec3::new(p[1].perp_dot(p[2]), p[2].perp_dot(p[0]), p[0].perp_dot(p[1]));
    let sum = weights.x + weights.y + weights.z;
    let weights = (weights / sum).to_array().map(|weight| if weight.abs() > MAX_EDGE_WEIGHT { weight } else { 0.0 });
    let is_at_corner = weights.iter().filter(|weight| **weight != 0.0).count() < 2;
    (sum != 0.0 && weights.iter().all(|weight| *weight >= 0.0) && !is_at_corner).then_some(DVec3::from_array(weights))
}

/// Makes the texture coordinates of a triangle's corners continuous across the seam and at a pole.
fn unwrap_map_coordinates(shape: &ShapeParameters, corners: &mut [Vertex; 3]) {
    let is_at_pole = corners.map(|c| shape.is_on_axis(c.position_km));
    let Some(first) = is_at_pole.iter().position(|p| !p) else { return };
    let u0 = corners[first].uv.x;
    for k in (0..3).filter(|k| !is_at_pole[*k]) {
        corners[k].uv.x += (u0 - corners[k].uv.x).round();
    }
    // All corners are shifted by a whole number, so that the smallest u is in 0..1, as in neighbouring triangles.
    let shift = (0..3).filter(|k| !is_at_pole[*k]).map(|k| corners[k].uv.x).fold(f64::INFINITY, f64::min).floor();
    (0..3).for_each(|k| corners[k].uv.x -= shift);
    let (sum, count) = (0..3).filter(|k| !is_at_pole[*k]).fold((0.0, 0.0), |(s, n), k| (s + corners[k].uv.x, n + 1.0));
    (0..3).filter(|k| is_at_pole[*k]).for_each(|k| corners[k].uv.x = sum / count);
}

#[derive(Default)]
struct MeshBuilder {
    /// The index in `vertices` of each vertex so far.
    vertex_indices: FxHashMap<VertexKey, u32>,
    vertices: Vec<Vertex>,
    /// For each vertex an id that vertices at the same position share.
    position_ids: Vec<u32>,
    indices: Vec<u32>,
}

impl MeshBuilder {
    /// The index of a vertex, which is added unless an equal one exists.
    fn add_vertex(&mut self, position_id: u32, vertex: Vertex) -> u32 {
        let key = VertexKey {
            position_id,
            normal: vertex.normal.to_array().map(f64::to_bits),
            uv: vertex.uv.to_array().map(f64::to_bits),
            colour: vertex.colour.to_array().map(f64::to_bits),
        };
        let next = self.vertices.len() as u32;
        let index = *self.vertex_indices.entry(key).or_insert(next);
        if index == next {
            self.vertices.push(vertex);
            self.position_ids.push(position_id);
        }
        index
    }

    /// Mean number of bounding boxes of triangles that a line through the bounding box of all triangles meets. By Cauchy's formula for convex bodies this
    /// number is the sum of the surface areas of the triangles' boxes divided by the surface area of the large box.
    fn overlap(&self) -> f64 {
        let half_box_area = |corners: &mut dyn Iterator<Item = DVec3>| {
            let (low, high) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
            let side = high - low;
            side.x * side.y + side.y * side.z + side.z * side.x
        };
        let corner = |k: &u32| self.vertices[*k as usize].position_km;
        let sum_of_half_areas: f64 = self.indices.chunks_exact(3).map(|t| half_box_area(&mut t.iter().map(corner))).sum();
        sum_of_half_areas / half_box_area(&mut self.indices.iter().map(corner))
    }

    /// Adds a triangle. `has_file_uv`: its texture coordinates are those of the file, which stay as they are.
    fn add_triangle(&mut self, shape: &ShapeParameters, position_ids: [u32; 3], mut corners: [Vertex; 3], has_file_uv: bool) {
        if !has_file_uv {
            unwrap_map_coordinates(shape, &mut corners);
        }
        for (position_id, corner) in position_ids.into_iter().zip(corners) {
            let index = self.add_vertex(position_id, corner);
            self.indices.push(index);
        }
    }
}

impl Mesh {
    pub(crate) fn vertex_count(&self) -> usize {
        self.positions.len() / 3
    }

    pub(crate) fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// The angle of the Sun's centre above the horizon that the shape itself forms, at each vertex, in units of `sun_radius_rad`, the Sun's angular radius.
    /// `towards_sun`: unit vector, body axes.
    pub fn sun_altitudes(&self, towards_sun: DVec3, sun_radius_rad: f64) -> Vec<f32> {
        self.ray_cast_mesh.sun_altitudes(towards_sun, sun_radius_rad)
    }

    /// Builds the mesh of a body from a file.
    ///
    /// # Errors
    /// A size that cannot be the body's, triangles that overlap too much, or no triangle with an area.
    pub fn of(obj: &Obj, shape: &ShapeParameters) -> Result<Self, ShapeError> {
        let positions_km: Vec<DVec3> = obj.positions.iter().map(|p| *p * shape.scale_km).collect();
        let corner_positions_km = || obj.triangles.iter().flatten().map(|c| positions_km[c.position as usize]);
        let largest_radius_km = shape.radii_km.max_element();
        let farthest_km = corner_positions_km().map(DVec3::length).fold(0.0, f64::max);
        if !FARTHEST_VERTEX_RANGE.contains(&(farthest_km / largest_radius_km)) {
            return Err(ShapeError::Size { farthest_km, radius_km: largest_radius_km });
        }
        let position_ids = weld(&positions_km);
        let mut normal_sums = vec![DVec3::ZERO; positions_km.len()];
        let position_km_of = |c: &Corner| positions_km[c.position as usize];
        // Normal to the triangle; its length is twice the triangle's area.
        let area_vector = |t: &[Corner; 3]| {
            let [a, b, c] = [&t[0], &t[1], &t[2]].map(position_km_of);
            (b - a).cross(c - a)
        };
        // The direction of a shorter area vector would be mostly rounding error.
        let triangles_with_area: Vec<&[Corner; 3]> =
            obj.triangles.iter().filter(|t| area_vector(t).length() > 1e-18 * largest_radius_km * largest_radius_km).collect();
        for t in &triangles_with_area {
            t.iter().for_each(|c| normal_sums[position_ids[c.position as usize] as usize] += area_vector(t));
        }
        let mut builder = MeshBuilder::default();
        // The id and the position of a pole on an edge, by the ids of the edge's ends: both triangles of the edge share them.
        let mut poles_on_edges: FxHashMap<[u32; 2], (u32, DVec3)> = FxHashMap::default();
        for t in &triangles_with_area {
            let face_normal = area_vector(t).normalize();
            let has_file_uv = t.iter().all(|c| c.texture.is_some());
            let vertex = |c: &Corner| {
                let position_km = position_km_of(c);
                let file_normal = c.normal.map(|n| obj.normals[n as usize]);
                let file_uv = c
                    .texture
                    .filter(|_| has_file_uv)
                    .map(|index| obj.texture_coordinates[index as usize])
                    .map(|uv| DVec2::new(uv.x, 1.0 - uv.y));
                Vertex {
                    position_km,
                    normal: file_normal.or(normal_sums[position_ids[c.position as usize] as usize].try_normalize()).unwrap_or(face_normal),
                    uv: file_uv.unwrap_or_else(|| shape.map_coordinates(position_km)),
                    colour: obj
                        .colours
                        .get(c.position as usize)
                        .map_or(DVec3::ONE, |srgb| DVec3::from_array(srgb.to_array().map(srgb_to_linear))),
                }
            };
            let corners = [vertex(&t[0]), vertex(&t[1]), vertex(&t[2])];
            let corner_ids = [0, 1, 2].map(|k| position_ids[t[k].position as usize]);
            match pole_weights(corners.map(|c| c.position_km)).filter(|_| !has_file_uv) {
                None => builder.add_triangle(shape, corner_ids, corners, has_file_uv),
                Some(weights) => {
                    let interpolated = |value: fn(&Vertex) -> DVec3| {
                        value(&corners[0]) * weights.x + value(&corners[1]) * weights.y + value(&corners[2]) * weights.z
                    };
                    let mut position_km = interpolated(|c| c.position_km);
                    (position_km.x, position_km.y) = (0.0, 0.0);
                    // An id that no position of the file and no earlier pole has.
                    let mut pole_id = (positions_km.len() + builder.vertices.len()) as u32;
                    if let Some(opposite) = (0..3).find(|k| weights[*k] == 0.0) {
                        let mut ends = [corner_ids[(opposite + 1) % 3], corner_ids[(opposite + 2) % 3]];
                        ends.sort_unstable();
                        (pole_id, position_km) = *poles_on_edges.entry(ends).or_insert((pole_id, position_km));
                    }
                    let normal = interpolated(|c| c.normal).try_normalize().unwrap_or(face_normal);
                    let pole = Vertex { position_km, normal, uv: shape.map_coordinates(position_km), colour: interpolated(|c| c.colour) };
                    // The triangle opposite a corner of weight 0 has no area.
                    for [a, b, _] in [[0, 1, 2], [1, 2, 0], [2, 0, 1]].into_iter().filter(|[.., opposite]| weights[*opposite] > 0.0) {
                        builder.add_triangle(shape, [corner_ids[a], corner_ids[b], pole_id], [corners[a], corners[b], pole], has_file_uv);
                    }
                }
            }
        }
        if builder.indices.is_empty() {
            return Err(ShapeError::NoArea);
        }
        let overlap = builder.overlap();
        if overlap > MAX_OVERLAP {
            return Err(ShapeError::Overlap { overlap });
        }
        Ok(Self::from_builder(builder, shape, !obj.colours.is_empty()))
    }

    /// Converts the builder's f64 vertices to arrays of f32.
    fn from_builder(builder: MeshBuilder, shape: &ShapeParameters, has_colours: bool) -> Self {
        let flat = |value: &dyn Fn(&Vertex) -> DVec3| -> Arc<Vec<f32>> {
            Arc::new(builder.vertices.iter().flat_map(|v| value(v).as_vec3().to_array()).collect())
        };
        let colours =
            has_colours.then(|| Arc::new(builder.vertices.iter().flat_map(|v| v.colour.as_vec3().extend(1.0).to_array()).collect()));
        let max_radius = builder.vertices.iter().map(|v| (v.position_km / shape.radii_km).length()).fold(0.0, f64::max);
        Self {
            positions: flat(&|v| v.position_km / shape.radii_km),
            normals: flat(&|v| v.normal),
            map_coordinates: Arc::new(builder.vertices.iter().flat_map(|v| v.uv.as_vec2().to_array()).collect()),
            colours,
            max_radius,
            ray_cast_mesh: RayCastMesh::new(
                builder.vertices.iter().map(|v| RayCastVertex { position_km: v.position_km, normal: v.normal }).collect(),
                &builder.position_ids,
                &builder.indices,
                shape.two_sided,
            ),
            indices: Arc::new(builder.indices),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::obj::parse;
    use super::*;

    const ROUND: ShapeParameters = ShapeParameters { radii_km: DVec3::ONE, scale_km: 1.0, map_stretch: DVec2::ONE, two_sided: false };

    /// The `size` numbers of vertex `k` in a flat attribute array.
    fn vertex(values: &[f32], size: usize, k: u32) -> &[f32] {
        &values[k as usize * size..][..size]
    }

    #[test]
    fn an_octahedron_shares_its_vertices_except_at_the_seam_and_the_poles() {
        let text = "v 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n\
                    f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 2 1 6\nf 3 2 6\nf 4 3 6\nf 1 4 6\n";
        let mesh = Mesh::of(&parse(text).expect("reads"), &ROUND).expect("a mesh");
        assert_eq!((mesh.triangle_count(), mesh.max_radius), (8, 1.0));
        // Four on the equator, the one at 180 degrees twice, and each pole once for each of its four faces.
        assert_eq!(mesh.vertex_count(), 4 + 1 + 8);
        for t in mesh.indices.chunks_exact(3) {
            let u: Vec<f32> = t.iter().map(|k| vertex(&mesh.map_coordinates, 2, *k)[0]).collect();
            let (low, high) = (u.iter().copied().fold(f32::MAX, f32::min), u.iter().copied().fold(f32::MIN, f32::max));
            assert!(high - low < 0.26, "a face spans a quarter of the map: {u:?}");
            for k in t {
                let (p, n, map) = (vertex(&mesh.positions, 3, *k), vertex(&mesh.normals, 3, *k), vertex(&mesh.map_coordinates, 2, *k));
                assert!(
                    p.iter().zip(n).all(|(p, n)| (p - n).abs() < 1e-6),
                    "by symmetry, the normal at a corner points away from the centre"
                );
                assert!((f64::from(map[1]) - (0.5 - f64::from(p[2]).asin() / PI)).abs() < 1e-6);
                let longitude = f64::from(p[1]).atan2(f64::from(p[0])) / TAU + 0.5;
                assert!(p[2].abs() > 0.5 || (f64::from(map[0]) - longitude).rem_euclid(1.0) < 1e-6, "{p:?} at {map:?}");
            }
        }
    }

    #[test]
    fn a_face_over_a_pole_is_cut_there() {
        let text = "v 0.6 0 0.8\nv -0.3 0.5 0.8\nv -0.3 -0.5 0.8\nf 1 2 3\n";
        let mesh = Mesh::of(&parse(text).expect("reads"), &ROUND).expect("a mesh");
        assert_eq!(
            (mesh.triangle_count(), mesh.vertex_count()),
            (3, 3 + 1 + 3),
            "one corner is doubled at the seam, and each triangle has its own pole"
        );
        let poles = (0..mesh.vertex_count() as u32).filter(|k| vertex(&mesh.positions, 3, *k)[..2] == [0.0, 0.0]);
        assert!(poles.clone().count() == 3 && poles.into_iter().all(|k| vertex(&mesh.map_coordinates, 2, k)[1] == 0.0));
        let beside = text.replace("v -0.3", "v 0.3");
        assert_eq!(Mesh::of(&parse(&beside).expect("reads"), &ROUND).expect("a mesh").triangle_count(), 1);
    }

    /// The diagonal of a square over the pole: each half is cut there. So each of the four triangles spans a quarter of the map's width;
    /// uncut, each of the two would span half of it.
    #[test]
    fn an_edge_over_a_pole_is_cut_there() {
        let text = "v 1 0.2 1\nv -0.2 1 1\nv -1 -0.2 1\nv 0.2 -1 1\nf 1 2 3\nf 1 3 4\n";
        let mesh_of = |text: &str| Mesh::of(&parse(text).expect("reads"), &ROUND).expect("a mesh");
        let triangles_and_poles = |mesh: &Mesh| {
            let is_pole = |k: &&u32| vertex(&mesh.positions, 3, **k)[..2] == [0.0, 0.0];
            (mesh.triangle_count(), mesh.indices.iter().filter(is_pole).count())
        };
        let mesh = mesh_of(text);
        assert_eq!(triangles_and_poles(&mesh), (4, 4));
        for t in mesh.indices.chunks_exact(3) {
            let poles: Vec<u32> = t.iter().copied().filter(|k| vertex(&mesh.positions, 3, *k) == [0.0, 0.0, 1.0]).collect();
            assert!(poles.len() == 1 && vertex(&mesh.map_coordinates, 2, poles[0])[1] == 0.0, "{t:?}");
            let u: Vec<f32> = t.iter().map(|k| vertex(&mesh.map_coordinates, 2, *k)[0]).collect();
            let (low, high) = (u.iter().copied().fold(f32::MAX, f32::min), u.iter().copied().fold(f32::MIN, f32::max));
            // A quarter, with the rounding of f32.
            assert!((high - low - 0.25).abs() < 1e-6, "{u:?}");
        }
        // Both halves share the pole's id, so none of the triangles around it counts as an obstacle for it. The square faces the Sun at the zenith.
        assert!(mesh.sun_altitudes(DVec3::Z, 0.01).iter().all(|altitude| *altitude > 1.0));
        // Controls: of a diagonal beside the pole, one half is cut into three triangles and the other is left; a corner at the pole needs no cut.
        assert_eq!(triangles_and_poles(&mesh_of(&text.replace("v 1 0.2 1", "v 1 0.3 1"))), (4, 3));
        assert_eq!(triangles_and_poles(&mesh_of("v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n")), (1, 1));
        // With texture coordinates of the file nothing is cut.
        let with_uv = text.replace("f 1 2 3\nf 1 3 4", "vt 0 0\nf 1/1 2/1 3/1\nf 1/1 3/1 4/1");
        assert_eq!(mesh_of(&with_uv).triangle_count(), 2);
    }

    #[test]
    fn normals_are_weighted_by_area_and_normals_of_the_file_have_precedence() {
        // Two faces on one edge: one twice as large as the other, a right angle between them.
        let text = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\n";
        let first = |text: &str| {
            let mesh = Mesh::of(&parse(text).expect("reads"), &ROUND).expect("a mesh");
            vertex(&mesh.normals, 3, mesh.indices[0]).to_vec()
        };
        let (n, length) = (first(text), 5.0_f32.sqrt());
        assert!((n[1] - 1.0 / length).abs() < 1e-6 && (n[2] - 2.0 / length).abs() < 1e-6, "{n:?}");
        let repeated = text.replace("f 1 4 2", "v 0 0 0\nv 1 0 0\nf 5 4 6");
        assert_eq!(first(&repeated), n, "positions repeated for each face are one surface");
        let given = text.replace("f 1 2 3", "vn 0 3 0\nf 1//1 2//1 3//1");
        assert_eq!(first(&given), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn faces_keep_their_colours_where_a_file_repeats_positions() {
        let text = "v 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 0 0 1 1 0 0\nv 0 1 0 0 0 1\nv -1 0 0 0 0 1\nv 0 0 1 0 0 1\nf 1 2 3\nf 4 5 6\n";
        let mesh = Mesh::of(&parse(text).expect("reads"), &ROUND).expect("a mesh");
        let colours = mesh.colours.as_ref().expect("colours");
        let of_face = |face: usize| mesh.indices[3 * face..][..3].iter().map(|k| vertex(colours, 4, *k).to_vec()).collect::<Vec<_>>();
        assert_eq!((of_face(0), of_face(1)), (vec![vec![1.0, 0.0, 0.0, 1.0]; 3], vec![vec![0.0, 0.0, 1.0, 1.0]; 3]));
        let [edge, edge_again] = [mesh.indices[1], mesh.indices[3]].map(|k| vertex(&mesh.normals, 3, k).to_vec());
        assert_eq!(edge, edge_again, "positions that coincide share one normal");
    }

    #[test]
    fn a_size_in_another_unit_is_refused() {
        let obj = parse("v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n").expect("reads");
        let mesh_at_scale = |scale_km: f64| Mesh::of(&obj, &ShapeParameters { scale_km, ..ROUND });
        assert!(mesh_at_scale(1.0).is_ok() && mesh_at_scale(3.9).is_ok());
        for scale_km in [1e-3, 1e3] {
            assert!(mesh_at_scale(scale_km).expect_err("another unit").to_string().contains("is scale_km right?"));
        }
    }
}
