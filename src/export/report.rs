//! Compares two revisions of the shader library: source, sample image and figures (cost, statistics of the image) of each module, by cause.
//!
//! In: two [`Revision`]s. Out: a [`Report`]. Always: modules with equal text and tape are counted and not drawn. A module that one revision
//! cannot compile is a failure with its reason, never "equal". The causes of a change are the fragments whose lines differ. If the text differs but no
//! fragment does, the cause is the generator. If the text is equal and only the tape differs, it is the lowering.

use super::revision::Revision;
use super::sample_image::{SampleBodyRenderer, SampleImage, level_differences, map_with_renderers};
use crate::session::{SessionError, tape_costs};
use crate::shader::compare::changed_lines;
use crate::shader::{Lowering, ModuleId, ShaderModule};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Width and height of the sample image, pixels.
const SIDE_PX: u32 = 40;

/// Cost of one module in one revision, and statistics of its sample image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Lane operations of the fragment stage's tape; operations in a loop count once.
    pub operations: usize,
    /// Texture samples and loads of the fragment stage's tape.
    pub texture_reads: usize,
    /// Slots of the fragment stage's tape: the number of values per lane that are live at the same time.
    pub slots: u32,
    /// Mean luminance of the sample image, relative to a white Lambert surface in full sunlight; `None` for modules that draw no body.
    pub mean_luminance: Option<f64>,
    /// The greatest difference between the sample images in f32 and in f64, display levels.
    pub rounding_levels: Option<f64>,
}

/// One cause of a difference: a fragment with the lines that only one revision has, or the generator, or the lowering.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cause {
    /// Path of the fragment, or `generator`, or `lowering`.
    pub what: String,
    /// Features to which the lines belong.
    pub features: BTreeSet<String>,
    /// Number of lines that only the first revision has.
    pub removed: usize,
    /// Number of lines that only the second revision has.
    pub added: usize,
}

/// Difference of two images, display levels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImageChange {
    /// The greatest difference of a pixel.
    pub max_levels: f64,
    /// The mean difference over all pixels.
    pub mean_levels: f64,
    /// Number of pixels that differ by half a level or more.
    pub pixels: usize,
}

/// One module that differs between the revisions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModuleChange {
    /// Key or name.
    pub module: String,
    /// What changed the module.
    pub causes: Vec<Cause>,
    /// Difference of the sample images; `None` for modules that draw no body.
    pub image: Option<ImageChange>,
    /// Figures in the first revision.
    pub first: Figures,
    /// Figures in the second revision.
    pub second: Figures,
}

/// The comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Name of the first revision.
    pub first: String,
    /// Name of the second revision.
    pub second: String,
    /// Number of modules with equal text and tape.
    pub equal: usize,
    /// Names of modules that only the first revision has.
    pub only_first: Vec<String>,
    /// Names of modules that only the second revision has.
    pub only_second: Vec<String>,
    /// Modules that both revisions have and that differ.
    pub changed: Vec<ModuleChange>,
    /// Modules that a revision cannot compile or run, each with the reason.
    pub failures: Vec<(String, String)>,
}

/// The result of the comparison of one module.
enum ModuleComparison {
    Equal,
    Changed(Box<ModuleChange>),
    OnlyInFirst,
    OnlyInSecond,
}

/// The modules to compare: those that at least one library lists, or `default_ids` if both revisions are folders of fragments.
fn ids_to_compare(revisions: [&Revision; 2], default_ids: &[ModuleId]) -> Vec<ModuleId> {
    let libraries: Vec<Vec<ModuleId>> = revisions.iter().filter_map(|r| r.ids()).collect();
    // A library whose modules are all unknown to this program gives an empty list, but still counts as a library: `default_ids` is not used then.
    let all: BTreeSet<ModuleId> =
        if libraries.is_empty() { default_ids.iter().cloned().collect() } else { libraries.into_iter().flatten().collect() };
    all.into_iter().collect()
}

/// The cost of a module, and the statistics of its sample image.
///
/// # Errors
/// The error is one line: the tape cannot be read, or the module has no fragment stage.
pub(crate) fn figures(module: &ShaderModule, sample: Option<&SampleImage>) -> Result<Figures, String> {
    let costs = tape_costs(module).map_err(|e| e.to_string())?;
    let Some(fragment_stage) = costs.iter().find(|c| c.stage == "fragment") else { return Err("no fragment stage".into()) };
    Ok(Figures {
        operations: fragment_stage.operations.values().sum(),
        texture_reads: fragment_stage.texture_reads,
        slots: fragment_stage.slots,
        mean_luminance: sample.map(SampleImage::mean_luminance),
        rounding_levels: sample.map(SampleImage::rounding_levels),
    })
}

/// The causes of the difference of two modules with the same id.
fn find_causes(first: &ShaderModule, second: &ShaderModule) -> Vec<Cause> {
    if first.wgsl == second.wgsl {
        return vec![Cause { what: "lowering".into(), ..Cause::default() }];
    }
    let cause_of = |(what, lines): (String, crate::shader::compare::ChangedLines)| Cause {
        what,
        features: lines.features,
        removed: lines.removed,
        added: lines.added,
    };
    let causes: Vec<Cause> =
        changed_lines((&first.wgsl, &first.source_map), (&second.wgsl, &second.source_map)).into_iter().map(cause_of).collect();
    // No line of a fragment was added or removed: the lines are in another order, or the changed lines come from no fragment.
    if causes.is_empty() { vec![Cause { what: "generator".into(), ..Cause::default() }] } else { causes }
}

/// Compares the two revisions of a module: text and tape, then, if these differ, the sample images and figures.
///
/// # Errors
/// Why a module cannot be drawn, or why its figures cannot be computed.
fn compare(renderer: &SampleBodyRenderer, modules: [ShaderModule; 2], id: &ModuleId) -> Result<ModuleComparison, String> {
    if modules[0].wgsl == modules[1].wgsl && modules[0].tape == modules[1].tape {
        return Ok(ModuleComparison::Equal);
    }
    let [first, second] = modules.map(Arc::new);
    let sample = |module: &Arc<ShaderModule>| match id {
        ModuleId::Keyed(key) => renderer.draw(module, key).map(Some).map_err(|e| e.to_string()),
        _ => Ok(None),
    };
    let samples = [sample(&first)?, sample(&second)?];
    let image = match &samples {
        [Some(a), Some(b)] => {
            let differences = level_differences(&a.f32_pixels, &b.f32_pixels);
            Some(ImageChange {
                max_levels: differences.iter().copied().fold(0.0, f64::max),
                mean_levels: differences.iter().sum::<f64>() / differences.len().max(1) as f64,
                pixels: differences.iter().filter(|d| **d >= 0.5).count(),
            })
        }
        _ => None,
    };
    let [a, b] = &samples;
    Ok(ModuleComparison::Changed(Box::new(ModuleChange {
        module: id.to_string(),
        causes: find_causes(&first, &second),
        image,
        first: figures(&first, a.as_ref())?,
        second: figures(&second, b.as_ref())?,
    })))
}

impl Report {
    /// Compares two revisions. `default_ids`: the modules to compare if both are folders of fragments. `on_start` is called with the number of
    /// modules, `on_module_done` after each module, from any thread.
    ///
    /// # Errors
    /// A renderer that cannot be created. Modules that cannot be read, compiled or drawn are listed in the report.
    pub fn of(
        revisions: [&Revision; 2],
        default_ids: &[ModuleId],
        lowering: &Lowering,
        on_start: impl FnOnce(usize),
        on_module_done: impl Fn() + Sync,
    ) -> Result<Self, SessionError> {
        // A trial: if no renderer can be created, the comparison gives one error instead of a failure of every module.
        drop(SampleBodyRenderer::new(SIDE_PX)?);
        let ids = ids_to_compare(revisions, default_ids);
        on_start(ids.len());
        let compare_module = |renderer: &SampleBodyRenderer, id: &ModuleId| -> Result<ModuleComparison, String> {
            let modules = revisions.map(|r| r.module(id, lowering).map_err(|e| format!("{}: {e}", r.name)));
            match modules {
                [Ok(Some(a)), Ok(Some(b))] => compare(renderer, [a, b], id),
                [Err(e), _] | [_, Err(e)] => Err(e),
                [Ok(Some(_)), Ok(None)] => Ok(ModuleComparison::OnlyInFirst),
                // Both cannot be `None`: an id comes from a library that has the module, or both revisions are folders of fragments, which never give `None`.
                [Ok(None), Ok(_)] => Ok(ModuleComparison::OnlyInSecond),
            }
        };
        let renderer_error = |_: &ModuleId, e: &SessionError| e.to_string();
        let comparisons = map_with_renderers(SIDE_PX, &ids, compare_module, renderer_error, on_module_done);
        let mut report = Self { first: revisions[0].name.clone(), second: revisions[1].name.clone(), ..Self::default() };
        for (id, comparison) in ids.iter().zip(comparisons) {
            match comparison {
                Ok(ModuleComparison::Equal) => report.equal += 1,
                Ok(ModuleComparison::Changed(change)) => report.changed.push(*change),
                Ok(ModuleComparison::OnlyInFirst) => report.only_first.push(id.to_string()),
                Ok(ModuleComparison::OnlyInSecond) => report.only_second.push(id.to_string()),
                Err(why) => report.failures.push((id.to_string(), why)),
            }
        }
        let [first_unknown, second_unknown] = revisions.map(Revision::unknown_names);
        report.only_first.extend(first_unknown.difference(second_unknown).cloned());
        report.only_second.extend(second_unknown.difference(first_unknown).cloned());
        let unknown_word = || "this program does not know a word of its name".to_owned();
        report.failures.extend(first_unknown.intersection(second_unknown).map(|name| (name.clone(), unknown_word())));
        Ok(report)
    }

    /// Whether both revisions have the same modules with equal text and tape, and none failed.
    pub fn is_equal(&self) -> bool {
        self.changed.is_empty() && self.only_first.is_empty() && self.only_second.is_empty() && self.failures.is_empty()
    }

    /// Changed modules by their causes, which are joined by ` + `.
    pub(crate) fn by_cause(&self) -> BTreeMap<String, Vec<&ModuleChange>> {
        let mut groups: BTreeMap<String, Vec<&ModuleChange>> = BTreeMap::new();
        for change in &self.changed {
            let causes: Vec<&str> = change.causes.iter().map(|c| c.what.as_str()).collect();
            groups.entry(causes.join(" + ")).or_default().push(change);
        }
        groups
    }
}
