//! An invented shape model in place of that of Phobos, for measurements: a bumpy sphere. Its number of triangles is chosen.
//!
//! In: the sources of the user's session, and the number of latitude bands. Out: the sources of a session with the model, and the temporary folder that
//! contains the model. Always: the session uses the built-in catalog, not the user's catalogs. It has no custom surfaces either, because they may belong to
//! bodies that only the user's catalogs have.

use super::{SessionError, Sources};
use crate::catalog::NaifId;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;
use tempfile::TempDir;

/// The body that has the invented shape.
pub(crate) const PHOBOS: NaifId = NaifId(401);
/// Radius of the sphere without its bumps: about the mean radius of Phobos (11.08 km, IAU WGCCRE 2015).
const RADIUS_KM: f64 = 11.0;

/// The text of a Wavefront OBJ file of a bumpy sphere, and its number of triangles. Vertices lie in circles of latitude, numbered from south to north: `row`
/// is 0 at the southern pole and `bands`, at least 2, at the northern pole.
fn bumpy_sphere(bands: u32) -> (String, u32) {
    let columns = 2 * bands;
    let position_km = |column: u32, row: u32| {
        let (latitude, longitude) = (PI * (f64::from(row) / f64::from(bands) - 0.5), TAU * f64::from(column) / f64::from(columns));
        let direction = DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
        // Arbitrary waves from -2 to 2. They change the radius by at most 8 %, enough for the shape to cast shadows on itself.
        let bumps = (9.0 * direction.x).sin() * (7.0 * direction.y).sin() + (11.0 * direction.z).sin() * (8.0 * direction.x).cos();
        direction * RADIUS_KM * (1.0 + 0.04 * bumps)
    };
    let mut text = String::new();
    let mut vertex = |position_km: DVec3| {
        let _ = writeln!(text, "v {:.6} {:.6} {:.6}", position_km.x, position_km.y, position_km.z);
    };
    vertex(position_km(0, 0));
    (1..bands).for_each(|row| (0..columns).for_each(|column| vertex(position_km(column, row))));
    vertex(position_km(0, bands));
    // Indices of vertices, which OBJ counts from 1.
    let inner_vertex = |column: u32, row: u32| 2 + (row - 1) * columns + column % columns;
    let (south_pole, north_pole) = (1, 2 + (bands - 1) * columns);
    let mut triangle_count = 0;
    let mut face = |a: u32, b: u32, c: u32| {
        triangle_count += 1;
        let _ = writeln!(text, "f {a} {b} {c}");
    };
    for column in 0..columns {
        face(south_pole, inner_vertex(column + 1, 1), inner_vertex(column, 1));
        for row in 1..bands - 1 {
            face(inner_vertex(column, row), inner_vertex(column + 1, row), inner_vertex(column + 1, row + 1));
            face(inner_vertex(column, row), inner_vertex(column + 1, row + 1), inner_vertex(column, row + 1));
        }
        face(inner_vertex(column, bands - 1), inner_vertex(column + 1, bands - 1), north_pole);
    }
    (text, triangle_count)
}

/// Sources in which Phobos has an invented shape.
pub(crate) struct InventedShape {
    pub sources: Sources,
    /// Number of triangles of the model.
    pub triangle_count: u32,
    /// Contains the model. The folder is removed when this value is dropped.
    _folder: TempDir,
}

impl InventedShape {
    /// A model with this number of latitude bands, in place of the catalogs and the custom surfaces of `sources`.
    ///
    /// # Errors
    /// The folder or a file that cannot be written, and why.
    pub(crate) fn of(sources: &Sources, bands: u32) -> Result<Self, SessionError> {
        let failed = |path: &Path, e: std::io::Error| SessionError::File { path: path.display().to_string(), why: e.to_string() };
        let folder = tempfile::tempdir().map_err(|e| failed(&std::env::temp_dir(), e))?;
        let (text, triangle_count) = bumpy_sphere(bands);
        let catalog = "[[body]]\nid = 401\n[body.mesh]\nfile = \"bumpy.obj\"\ninvented = \"all of it, for a measurement\"\n";
        for (name, text) in [("bumpy.obj", text.as_str()), ("bumpy.toml", catalog)] {
            let path = folder.path().join(name);
            std::fs::write(&path, text).map_err(|e| failed(&path, e))?;
        }
        let sources = Sources { catalogs: Some(folder.path().to_owned()), surfaces: Vec::new(), ..sources.clone() };
        Ok(Self { sources, triangle_count, _folder: folder })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a closed surface each edge belongs to two triangles, once in each direction.
    #[test]
    fn a_bumpy_sphere_is_closed_and_faces_outwards() {
        let (text, triangle_count) = bumpy_sphere(6);
        let numbers = |line: &str| line.split(' ').skip(1).map(|n| n.parse::<f64>().expect("a number")).collect::<Vec<_>>();
        let vertices: Vec<DVec3> = text.lines().filter(|l| l.starts_with('v')).map(|l| DVec3::from_slice(&numbers(l))).collect();
        let faces: Vec<[usize; 3]> =
            text.lines().filter(|l| l.starts_with('f')).map(|l| [0, 1, 2].map(|k| numbers(l)[k] as usize - 1)).collect();
        assert_eq!(faces.len(), triangle_count as usize);
        let mut edges = std::collections::HashSet::new();
        for [a, b, c] in &faces {
            assert!(
                [(*a, *b), (*b, *c), (*c, *a)].into_iter().all(|edge| edges.insert(edge)),
                "two triangles have an edge in the same direction"
            );
            let normal = (vertices[*b] - vertices[*a]).cross(vertices[*c] - vertices[*a]);
            assert!(normal.dot(vertices[*a]) > 0.0, "a triangle faces inwards");
        }
        assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))), "an edge belongs to one triangle only");
    }
}
