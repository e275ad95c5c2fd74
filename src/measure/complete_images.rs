//! Cost and error of complete images, by quality, with and without stars, and by renderer.
//!
//! In: a session and an effort (how long the measurement may take). Out: a [`ChoiceMeasure`] of each of these choices. A [`Candidate`] is an option of a choice
//! that is to be timed; its `default_of` lists the qualities that use it in the program.

use super::drawings::standard_request;
use super::images::{LinearImage, PrecisionRenderers, larger_or_nan, level_differences, p999, precision_of};
use super::rule::ErrorUnit;
use super::{Candidate, ChoiceMeasure, Effort, measure_choice};
use crate::render::plan::{FrameImages, SamplingQuality};
use crate::render::software::Precision;
use crate::scene::request::{Layers, Quality, ViewRequest};
use crate::session::{RendererPreference, Session, SessionError, standard_scenes};

/// Names of standard scenes that together contain discs, rings, atmospheres, maps and limbs. `earth-3-radii` is at the time of a solar eclipse.
const SCENES: [&str; 3] = ["earth-3-radii", "saturn", "moon-limb"];

/// The qualities (`--quality`), with everything that a quality sets: models, sampling and precision. In each of the [`SCENES`], only the target is drawn. The
/// error is the 99.9th percentile of the pixels' differences from the reference quality, in display levels.
pub(super) fn quality(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let mut requests_and_references = Vec::new();
    for name in SCENES {
        let request = renderers.with_metered_exposure(standard_request(name, effort)?)?;
        let reference_request = ViewRequest { quality: Quality::Reference, ..request.clone() };
        let reference = renderers
            .draw_linear(&renderers.plan_target_body(&reference_request, SamplingQuality::of(Quality::Reference))?, Precision::F64)?;
        requests_and_references.push((request, reference));
    }
    let mut candidates = Vec::new();
    for quality in Quality::ALL {
        let mut worst = 0.0_f64;
        let mut planned_views = Vec::new();
        for (request, reference) in &requests_and_references {
            let planned_view = renderers.plan_target_body(&ViewRequest { quality, ..request.clone() }, SamplingQuality::of(quality))?;
            let error = p999(level_differences(&renderers.draw_linear(&planned_view, precision_of(quality))?, reference));
            worst = larger_or_nan(worst, error);
            planned_views.push(planned_view);
        }
        let renderers = &renderers;
        let workload = Box::new(move || planned_views.iter().try_for_each(|view| renderers.draw(view, precision_of(quality))));
        candidates.push(Candidate { name: quality.name().to_owned(), error: worst, default_of: vec![quality], workload });
    }
    let about = "the Earth in an eclipse, Saturn, the Moon's limb: the worst of them; against the reference quality";
    measure_choice("quality", about, ErrorUnit::Levels, effort.rounds(), candidates)
}

/// Without stars (`--layers -stars`) or with the star catalog. The error is that of the image's summed green light.
pub(super) fn stars(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let side = effort.side_px();
    let sky = standard_scenes(side, side).into_iter().find(|s| s.name == "night-sky").map(|s| s.request);
    let Some(sky) = sky else {
        // An empty measure; nothing is timed.
        let (rounds, no_candidates) = (1, Vec::new());
        return measure_choice("stars", "no night sky", ErrorUnit::PercentOfLight, rounds, no_candidates);
    };
    let request = renderers.with_metered_exposure(sky)?;
    let sampling = SamplingQuality::of(Quality::Standard);
    let plan_with =
        |stars: bool| renderers.plan_view(&ViewRequest { layers: Layers { stars, ..Layers::default() }, ..request.clone() }, sampling);
    let green_sum = |image: &LinearImage| image.light.iter().map(|p| f64::from(p[1])).sum::<f64>();
    let with_stars = true;
    let reference = green_sum(&renderers.draw_linear(&plan_with(with_stars)?, Precision::F64)?);
    let mut candidates = Vec::new();
    for (with_stars, name, default_of) in [(false, "none", vec![]), (true, "catalog", Quality::ALL.to_vec())] {
        let planned_view = plan_with(with_stars)?;
        let error = 100.0 * (green_sum(&renderers.draw_linear(&planned_view, Precision::F32)?) - reference).abs()
            / reference.max(f64::MIN_POSITIVE);
        let renderers = &renderers;
        candidates.push(Candidate {
            name: name.to_owned(),
            error,
            default_of,
            workload: Box::new(move || renderers.draw(&planned_view, Precision::F32)),
        });
    }
    measure_choice("stars", "light of the night sky around Orion, 45 degrees", ErrorUnit::PercentOfLight, effort.rounds(), candidates)
}

/// The software renderer against a GPU; `None` if the session uses no GPU. The time is CPU time: that of a GPU contains only the CPU's part of the work, unless
/// its driver draws on the CPU.
///
/// # Errors
/// The reason why the view cannot be drawn.
pub(crate) fn renderer(session: &Session, effort: Effort) -> Result<Option<ChoiceMeasure>, SessionError> {
    let (available, preference) = session.renderers();
    if preference == RendererPreference::Software || !available.contains(&RendererPreference::Gpu) {
        return Ok(None);
    }
    let renderers = PrecisionRenderers::new(session)?;
    let request = renderers.with_metered_exposure(standard_request("saturn", effort)?)?;
    let sampling = SamplingQuality::of(Quality::Standard);
    let drawn = session.draw(&request, sampling, FrameImages::DisplayAndHdr)?;
    // Without a usable GPU, the session draws in software.
    if drawn.drawn_by.adapter.is_none() {
        return Ok(None);
    }
    let planned_view = renderers.plan_view(&request, sampling)?;
    let reference = renderers.draw_linear(&planned_view, Precision::F64)?;
    // The image's size and exposure are those of the reference.
    let gpu_image = LinearImage { light: drawn.frame.hdr, ..reference.clone() };
    let software_image = renderers.draw_linear(&planned_view, Precision::F32)?;
    let candidates = vec![
        Candidate {
            name: format!("gpu ({})", drawn.drawn_by.adapter.as_deref().unwrap_or("unknown")),
            error: p999(level_differences(&gpu_image, &reference)),
            default_of: vec![],
            workload: Box::new(|| session.draw(&request, sampling, FrameImages::Display).map(drop)),
        },
        Candidate {
            name: "software".to_owned(),
            error: p999(level_differences(&software_image, &reference)),
            default_of: vec![],
            workload: Box::new(|| renderers.draw(&planned_view, Precision::F32)),
        },
    ];
    measure_choice("renderer", "Saturn with its rings; against f64", ErrorUnit::Levels, effort.rounds(), candidates).map(Some)
}
