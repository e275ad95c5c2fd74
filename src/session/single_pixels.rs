//! Plans of which single pixels are asked: for the inspector, and for comparisons of f32 with f64.
//!
//! In: a request. Out: scene and plan as for a picture, except that no body's draw reads a picture of an earlier pass. Always: the first pass is the one
//! that draws the bodies. Not here: what is asked (`probe`, `stability`).

use super::{Session, SessionError};
use crate::render::plan::{self, Plan, SamplingQuality};
use crate::scene::Scene;
use crate::scene::request::ViewRequest;

impl Session {
    /// Like [`Self::plan`], but each pixel evaluates its air, so that bodies' draws read no earlier pass. Errors: see [`Self::plan`].
    pub fn plan_of_single_pixels(&self, request: &ViewRequest, sampling: SamplingQuality) -> Result<(Scene, Plan), SessionError> {
        let (mut scene, plan) = self.plan(request, sampling)?;
        let plan = if scene.evaluate_air_in_each_pixel() { plan::plan(&scene, self, sampling)? } else { plan };
        Ok((scene, plan))
    }
}
