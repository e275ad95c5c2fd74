//! The lowest quality that is sufficient for one view: its image can hardly be distinguished from that of the reference quality.
//!
//! In: a view. Out: [`ViewMeasure`]: error and time of each quality relative to the reference quality's image at the same exposure, and the lowest
//! sufficient quality.

use super::images::{PrecisionRenderers, level_differences, p999, precision_of};
use super::rule::ErrorUnit;
use super::{Candidate, ChoiceMeasure, Effort, measure_choice};
use crate::render::plan::SamplingQuality;
use crate::scene::request::{Quality, ViewRequest};
use crate::session::{Session, SessionError};

/// A quality is sufficient if 99.9 % of the pixels are within this many 255ths of the reference.
pub(crate) const SUFFICIENT_LEVELS: f64 = 1.0;

/// Measurements of the qualities in one view.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ViewMeasure {
    /// Error and time of each quality.
    pub qualities: ChoiceMeasure,
    /// The lowest sufficient quality.
    pub sufficient: Quality,
}

/// Measures the qualities in a view; `effort` sets the number of rounds.
///
/// # Errors
/// The reason why the view cannot be drawn.
pub(crate) fn measure_view(session: &Session, request: &ViewRequest, effort: Effort) -> Result<ViewMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let request = renderers.with_metered_exposure(request.clone())?;
    let plan_view = |quality: Quality| renderers.plan_view(&ViewRequest { quality, ..request.clone() }, SamplingQuality::of(quality));
    let reference = renderers.draw_linear(&plan_view(Quality::Reference)?, precision_of(Quality::Reference))?;
    let mut candidates = Vec::new();
    let mut sufficient = None;
    for quality in Quality::ALL {
        let view = plan_view(quality)?;
        let error = p999(level_differences(&renderers.draw_linear(&view, precision_of(quality))?, &reference));
        if error <= SUFFICIENT_LEVELS {
            sufficient.get_or_insert(quality);
        }
        let renderers = &renderers;
        let workload = Box::new(move || renderers.draw(&view, precision_of(quality)));
        candidates.push(Candidate { name: quality.name().to_owned(), error, default_of: vec![quality], workload });
    }
    let qualities = measure_choice("quality", "this view, against the reference quality", ErrorUnit::Levels, effort.rounds(), candidates)?;
    Ok(ViewMeasure { qualities, sufficient: sufficient.unwrap_or(Quality::Reference) })
}
