//! `orrery bench --meshes`: measures the cost of a shape model as a function of its number of triangles.
//!
//! In: an image size and a number of rounds. Out: JSON with one row per model:
//! - `triangles`: number of triangles;
//! - `read_ms`: time of the maps stage in the first frame with the mesh, which reads the mesh file;
//! - `trace_shadow_ms`: time of the scene stage in the first frame with the mesh's shadow on itself; most of that time is spent tracing the shadow;
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
use crate::session::invented_shape::{InventedShape, PHOBOS};
use crate::session::{Session, Stage, milliseconds};
use crate::time::Instant;
use serde_json::{Value, json};

/// Numbers of latitude bands from pole to pole; a sphere with n bands has 4 n (n - 1) triangles, so these models have 5040 to 326 040.
const BANDS: [u32; 4] = [36, 72, 143, 286];
/// Time of the view, chosen arbitrarily: 2013-08-20 00:00 TDB.
const VIEW_TIME_JD_TDB: f64 = 2_456_524.5;

/// Median and quartiles of the ratios of `times` to `base_times`, each ratio from one round.
fn ratio(times: &[f64], base_times: &[f64]) -> Value {
    Quartiles::of_ratios(times, base_times)
        .map_or(Value::Null, |q| json!({ "median": rounded(q.median), "quartiles": [rounded(q.low), rounded(q.high)] }))
}

/// The value with three decimals; further digits are noise.
fn rounded(value: f64) -> f64 {
    (1e3 * value).round() / 1e3
}

/// The row of the model with this number of latitude bands. `rounds`: how often each kind of frame is timed.
fn model_row(common: &Common, (width, height): (u32, u32), rounds: usize, bands: u32) -> Result<Value, CliError> {
    let shape = InventedShape::of(&common.sources_for_drawing(), bands)?;
    let session = Session::open(&shape.sources, print_message)?.counting_cpu();
    // The camera is over the sub-solar point, so that the whole disc is lit.
    let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(4.0) };
    let with_shadow =
        ViewRequest { width, height, position, quality: common.quality, ..ViewRequest::of(PHOBOS, Instant::from_jd_tdb(VIEW_TIME_JD_TDB)) };
    let without = |effect| {
        let mut request = with_shadow.clone();
        request.effects.set(effect, false);
        request
    };
    let (without_shadow, ellipsoid) = (without(Effect::SelfShadow), without(Effect::Mesh));
    let sampling = SamplingQuality::of(common.quality);
    let draw = |request: &ViewRequest| session.draw(request, sampling, FrameImages::Display).map(drop);
    // The first frame with an effect includes the one-time work for the effect: reading the mesh file, or tracing the mesh's shadow. The closure returns the
    // CPU time of the whole stage, or the elapsed time if the CPU time is unknown.
    let stage_ms_of_first_draw = |request: &ViewRequest, stage: Stage| -> Result<f64, CliError> {
        let (stages_before, _) = session.report();
        draw(request)?;
        let (stages_after, _) = session.report();
        let stages = stages_after.since(&stages_before);
        Ok(milliseconds(stages.cpu(stage).unwrap_or_else(|| stages.elapsed(stage))))
    };
    // Warm-up, not measured: loads maps and compiles modules.
    stage_ms_of_first_draw(&ellipsoid, Stage::Maps)?;
    let read_ms = stage_ms_of_first_draw(&without_shadow, Stage::Maps)?;
    let trace_shadow_ms = stage_ms_of_first_draw(&with_shadow, Stage::Scene)?;
    let timed = |request: &ViewRequest| seconds_of(|| draw(request));
    let workloads: [&Workload<'_, f64, _>; 3] = [&|| timed(&ellipsoid), &|| timed(&without_shadow), &|| timed(&with_shadow)];
    let times = interleaved(rounds, &workloads)?;
    Ok(json!({
        "triangles": shape.triangle_count,
        "read_ms": rounded(read_ms),
        "trace_shadow_ms": rounded(trace_shadow_ms),
        "ellipsoid_ms": Quartiles::of(times[0].clone()).map(|q| rounded(1e3 * q.median)),
        "without_self_shadow": ratio(&times[1], &times[0]),
        "mesh": ratio(&times[2], &times[0]),
    }))
}

pub(crate) fn run(common: &Common, (width, height): (u32, u32), rounds: usize) -> Result<(), CliError> {
    let bar = progress(BANDS.len() as u64);
    let mut models = Vec::new();
    for bands in BANDS {
        models.push(model_row(common, (width, height), rounds, bands)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    print_result(&format!("{:#}\n", json!({ "width": width, "height": height, "rounds": rounds, "meshes": models })))
}
