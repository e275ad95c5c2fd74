//! Compares f32 with f64 images of shaders that together have every feature. A key names the features of one emitted module: one value in each of several
//! dimensions, such as the shape. The keys of a covering set together contain every combination of values of any two (or three) dimensions. Each is drawn on
//! the sample body, a made-up globe.
//!
//! In: a sweep's setup. Out: the greatest difference of a channel, where white is 1.

use super::difference::{describe_cause, least_differences, worst_of};
use super::{SweepResult, SweepSetup};
use crate::catalog::NaifId;
use crate::measure::{PlannedView, larger_or_nan};
use crate::render::software::Precision;
use crate::scene::request::ViewRequest;
use crate::session::{SAMPLE_HALF_SIDE_ON_DISC, SAMPLE_HALF_SIDE_WITH_LIMB, SessionError, sample_body_plan};
use crate::shader::key::covering_keys;
use serde_json::json;

/// Side of the image, pixels.
const SIDE_PX: u32 = 24;

/// Draws the keys of a 2-way (short effort) or 3-way (full) covering set. Each key is drawn twice: with the disc filling the image, and with the limb in it.
pub(super) fn run(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    let session = setup.session();
    let request = ViewRequest { width: SIDE_PX, height: SIDE_PX, ..ViewRequest::of(NaifId::MOON, super::views::eclipse_instant()) };
    // A planned view needs a scene, but the sample body has none. Nothing of this scene of the Moon is drawn; only its exposure is read.
    let scene = session.scene(&request)?;
    for key in covering_keys(setup.short_or_full(2, 3)) {
        for half_side_radii in [SAMPLE_HALF_SIDE_ON_DISC, SAMPLE_HALF_SIDE_WITH_LIMB] {
            let mut plan = sample_body_plan(session.library(), &key, SIDE_PX, half_side_radii)?;
            if let Some(change) = setup.injected_faults.change_plan {
                change(&mut plan);
            }
            let view = PlannedView { scene: scene.clone(), plan };
            let (f32_pixels, f64_frames) = (setup.draw_linear(&view, Precision::F32)?.light, setup.f64_frames(&view)?);
            let difference = |a: &[f32; 4], b: &[f32; 4]| (0..4).map(|c| f64::from((a[c] - b[c]).abs())).fold(0.0, larger_or_nan);
            // Of each pixel, the difference from the closest of the f64 frames, which differ in the grid to which vertices snap.
            let differences = least_differences(&f32_pixels, f64_frames.iter().map(|frame| &*frame.hdr), difference);
            let (worst_index, worst) = worst_of(&differences);
            let pixel = [worst_index as u32 % SIDE_PX, worst_index as u32 / SIDE_PX];
            found.add(worst, || {
                let case = json!({ "key": key.to_string(), "half_side_radii": half_side_radii, "pixel": pixel });
                (case, describe_cause(setup, &view, [SIDE_PX, SIDE_PX], pixel))
            });
        }
    }
    Ok(found)
}
