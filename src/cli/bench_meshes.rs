//! `orrery bench --meshes`: measures the cost of a shape model as a function of its number of triangles.
//!
//! In: an image size and a number of rounds. Out: JSON with one row per model:
//! - `triangles`: their number;
//! - `read_ms`: time of the maps stage in the first frame with the mesh, which reads the mesh file;
//! - `trace_shadow_ms`: time of the scene stage in the first frame with the mesh's shadow on itself, most of which traces that shadow;
//! - `ellipsoid_ms`: median time of a frame with the ellipsoid in place of the mesh;
//! - `without_self_shadow` and `mesh`: times of frames with the mesh, without and with that shadow, as ratios to those with the ellipsoid. Frames of the
//!   three kinds are measured alternately.
//!
//! Times are CPU times, or elapsed times if the system reports no CPU time. The shapes are invented: bumpy spheres in place of Phobos. Their folder is
//! removed after the measurement.

use super::output::{print_message, print_result, progress};
use super::{CliError, Common};
use crate::catalog::NaifId;
use crate::measure::timing::{Quartiles, Workload, interleaved, seconds_of};
use crate::render::plan::{FrameImages, SamplingQuality};
use crate::scene::effects::Effect;
use crate::scene::request::{Position, ViewRequest};
use crate::session::{Session, Stage, milliseconds};
use crate::time::Instant;
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;

const PHOBOS: NaifId = NaifId(401);
/// Numbers of latitude bands from pole to pole; a sphere with n bands has 4 n (n - 1) triangles.
const BANDS: [u32; 4] = [36, 72, 143, 286];
/// Radius of the sphere without its bumps: about the mean radius of Phobos (11.08 km, IAU WGCCRE 2015).
const RADIUS_KM: f64 = 11.0;
/// 2013-08-20 00:00 TDB, chosen arbitrarily.
const JD_TDB: f64 = 2_456_524.5;

/// The text of a Wavefront OBJ file of a bumpy sphere, and its number of triangles. Vertices lie in circles of latitude from south to north, whose `row` is 0
/// at the southern pole and `bands` at the northern one.
fn bumpy_sphere(bands: u32) -> (String, u32) {
    let columns = 2 * bands;
    let position = |column: u32, row: u32| {
        let (latitude, longitude) = (PI * (f64::from(row) / f64::from(bands) - 0.5), TAU * f64::from(column) / f64::from(columns));
        let direction = DVec3::new(latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin(), latitude.sin());
        // Arbitrary waves, -2 to 2. They change the radius by at most 8 %, which is enough for the shape to cast shadows on itself.
        let bumps = (9.0 * direction.x).sin() * (7.0 * direction.y).sin() + (11.0 * direction.z).sin() * (8.0 * direction.x).cos();
        direction * RADIUS_KM * (1.0 + 0.04 * bumps)
    };
    let mut text = String::new();
    let mut vertex = |p: DVec3| {
        let _ = writeln!(text, "v {:.6} {:.6} {:.6}", p.x, p.y, p.z);
    };
    vertex(position(0, 0));
    (1..bands).for_each(|row| (0..columns).for_each(|column| vertex(position(column, row))));
    vertex(position(0, bands));
    // Indices of vertices: OBJ counts from 1, which is the southern pole.
    let inner_vertex = |column: u32, row: u32| 2 + (row - 1) * columns + column % columns;
    let (south_pole, north_pole) = (1, 2 + (bands - 1) * columns);
    let mut triangles = 0;
    let mut face = |a: u32, b: u32, c: u32| {
        triangles += 1;
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
    (text, triangles)
}

/// Writes the mesh file, and a catalog file that makes it the shape of Phobos. Returns its number of triangles.
fn write_model(folder: &Path, bands: u32) -> Result<u32, CliError> {
    let (text, triangles) = bumpy_sphere(bands);
    let catalog = "[[body]]\nid = 401\n[body.mesh]\nfile = \"bumpy.obj\"\ninvented = \"all of it, for a measurement\"\n";
    let write_file = |name: &str, text: &str| std::fs::write(folder.join(name), text);
    write_file("bumpy.obj", &text)
        .and_then(|()| write_file("bumpy.toml", catalog))
        .map_err(|e| CliError::Failed(format!("{}: {e}", folder.display())))?;
    Ok(triangles)
}

/// Median and quartiles of the ratios of `times` to `base_times`, each ratio from one round.
fn ratio(times: &[f64], base_times: &[f64]) -> Value {
    Quartiles::of_ratios(times, base_times)
        .map_or(Value::Null, |q| json!({ "median": rounded(q.median), "quartiles": [rounded(q.low), rounded(q.high)] }))
}

/// The value with three decimals; further digits are noise.
fn rounded(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}

/// The row of the model with this number of latitude bands.
fn model_row(common: &Common, (width, height): (u32, u32), rounds: usize, bands: u32) -> Result<Value, CliError> {
    let folder = tempfile::tempdir().map_err(|e| CliError::Failed(format!("a folder for shapes: {e}")))?;
    let triangles = write_model(folder.path(), bands)?;
    let mut sources = common.sources_for_drawing();
    sources.catalogs = Some(folder.path().to_owned());
    let session = Session::open(&sources, print_message)?.counting_cpu();
    // Over the sub-solar point, so that the whole disc is lit.
    let position = Position::Over { towards: Some(NaifId::SUN), distance_radii: Some(4.0) };
    let with_shadow =
        ViewRequest { width, height, position, quality: common.quality, ..ViewRequest::of(PHOBOS, Instant::from_jd_tdb(JD_TDB)) };
    let without = |effect| {
        let mut request = with_shadow.clone();
        request.effects.set(effect, false);
        request
    };
    let (without_shadow, ellipsoid) = (without(Effect::SelfShadow), without(Effect::Mesh));
    let sampling = SamplingQuality::of(common.quality);
    let draw = |request: &ViewRequest| session.draw(request, sampling, FrameImages::Display).map(drop);
    // The first frame with an effect includes the one-time work for it: reading the mesh file, or tracing its shadow. The time is that of the whole stage.
    let stage_ms_of_first_draw = |request: &ViewRequest, stage: Stage| -> Result<f64, CliError> {
        let earlier = session.report().0;
        draw(request)?;
        let stages = session.report().0.since(&earlier);
        Ok(milliseconds(stages.cpu(stage).unwrap_or_else(|| stages.spent(stage))))
    };
    // Warm-up, not measured: loads maps and compiles modules.
    stage_ms_of_first_draw(&ellipsoid, Stage::Maps)?;
    let read_ms = stage_ms_of_first_draw(&without_shadow, Stage::Maps)?;
    let trace_shadow_ms = stage_ms_of_first_draw(&with_shadow, Stage::Scene)?;
    let timed = |request: &ViewRequest| seconds_of(|| draw(request));
    let workloads: [&Workload<'_, f64, _>; 3] = [&|| timed(&ellipsoid), &|| timed(&without_shadow), &|| timed(&with_shadow)];
    let times = interleaved(rounds, &workloads)?;
    Ok(json!({
        "triangles": triangles,
        "read_ms": rounded(read_ms),
        "trace_shadow_ms": rounded(trace_shadow_ms),
        "ellipsoid_ms": Quartiles::of(times[0].clone()).map(|q| rounded(1e3 * q.median)),
        "without_self_shadow": ratio(&times[1], &times[0]),
        "mesh": ratio(&times[2], &times[0]),
    }))
}

pub(crate) fn run(common: &Common, size: (u32, u32), rounds: usize) -> Result<(), CliError> {
    let bar = progress(BANDS.len() as u64);
    let mut models = Vec::new();
    for bands in BANDS {
        models.push(model_row(common, size, rounds, bands)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    print_result(&format!("{:#}\n", json!({ "width": size.0, "height": size.1, "rounds": rounds, "meshes": models })))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a closed surface each edge belongs to two triangles, once in each direction.
    #[test]
    fn a_bumpy_sphere_is_closed_and_faces_outwards() {
        let (text, triangles) = bumpy_sphere(6);
        let numbers = |line: &str| line.split(' ').skip(1).map(|n| n.parse::<f64>().expect("a number")).collect::<Vec<_>>();
        let vertices: Vec<DVec3> = text.lines().filter(|l| l.starts_with('v')).map(|l| DVec3::from_slice(&numbers(l))).collect();
        let faces: Vec<[usize; 3]> =
            text.lines().filter(|l| l.starts_with('f')).map(|l| [0, 1, 2].map(|k| numbers(l)[k] as usize - 1)).collect();
        assert_eq!(faces.len(), triangles as usize);
        let mut edges = std::collections::HashSet::new();
        for [a, b, c] in &faces {
            assert!(
                [(*a, *b), (*b, *c), (*c, *a)].into_iter().all(|e| edges.insert(e)),
                "two triangles have an edge in the same direction"
            );
            let normal = (vertices[*b] - vertices[*a]).cross(vertices[*c] - vertices[*a]);
            assert!(normal.dot(vertices[*a]) > 0.0);
        }
        assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
    }
}
