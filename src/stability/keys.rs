//! Every key of the covering set on the sample body, f32 against f64.

use super::difference::{describe_cause, larger_or_nan, worst_of};
use super::{SweepBench, SweepResult};
use crate::catalog::NaifId;
use crate::measure::PlannedView;
use crate::render::software::Precision;
use crate::scene::request::ViewRequest;
use crate::session::{HALF_SIDE_INSIDE, HALF_SIDE_WITH_LIMB, SessionError, sample_plan};
use crate::shader::key::covering;
use serde_json::json;

/// Side of the image, pixels.
const SIDE: u32 = 24;

/// Keys with all pairs of values (short) or all triples (full); each once with the disc filling the image
/// and once with its limb.
pub(super) fn run(bench: &SweepBench<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::none();
    let session = bench.session();
    let request = ViewRequest { width: SIDE, height: SIDE, ..ViewRequest::of(NaifId::MOON, super::views::instant()) };
    let scene = session.plan(&request, super::SINGLE_SAMPLE)?.0;
    for key in covering(bench.pick(2, 3)) {
        for half_side in [HALF_SIDE_INSIDE, HALF_SIDE_WITH_LIMB] {
            let mut plan = sample_plan(session.library(), &key, SIDE, half_side)?;
            if let Some(change) = bench.faults.plan {
                change(&mut plan);
            }
            let view = PlannedView { scene: scene.clone(), plan };
            let [single, double] = [bench.light(&view, Precision::F32)?, bench.light(&view, Precision::F64)?];
            let difference = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| f64::from((a[c] - b[c]).abs())).fold(0.0, larger_or_nan);
            let differences: Vec<f64> = single.light.iter().zip(&double.light).map(difference).collect();
            let (at, worst) = worst_of(&differences);
            let pixel = [at as u32 % SIDE, at as u32 / SIDE];
            found.add(worst, || {
                let location = json!({ "key": key.to_string(), "half_side_radii": half_side, "pixel": pixel });
                (location, describe_cause(bench, &view, [SIDE, SIDE], pixel))
            });
        }
    }
    Ok(found)
}
