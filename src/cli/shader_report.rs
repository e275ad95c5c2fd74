//! `orrery shader verify --report A B`: reports how the modules of two revisions of the shader library differ.
//!
//! In: two folders, or `built-in`. Out: text or JSON. The changed modules are grouped by cause: the changed shader sources, the generator, or the lowering.

use super::CliError;
use super::inputs::lowering;
use super::output::{print_result, progress};
use crate::export::Revision;
use crate::export::report::{Figures, ModuleChange, Report};
use crate::shader::ModuleId;
use crate::shader::id::{SIMPLE_MODULES, probe_samples};
use crate::shader::key::covering_keys;
use crate::wording::{counted, echo};
use serde_json::json;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Number of modules that the text lists in each group; `--json` lists all.
const MAX_LISTED: usize = 3;

/// The modules that are compiled to compare two folders of fragments: those of a pairwise covering set of keys, simple shaders and probe modules.
fn default_modules() -> Vec<ModuleId> {
    let keys = covering_keys(2).into_iter().map(ModuleId::Keyed);
    SIMPLE_MODULES.iter().map(|n| ModuleId::Simple(n)).chain(probe_samples()).chain(keys).collect()
}

/// The revision that an argument of `--report` names.
fn revision(folder: &Path) -> Result<Revision, CliError> {
    if folder == Path::new("built-in") {
        return Ok(Revision::built_in());
    }
    Revision::open(folder)
        .map_err(|e| CliError::Failed(format!("--report {}: {}", echo(&folder.display().to_string()), echo(&e.to_string()))))
}

pub(crate) fn run(folders: &[PathBuf], as_json: bool) -> Result<(), CliError> {
    let [first, second] = folders else { return Err(CliError::Failed("--report takes two folders".into())) };
    let revisions = [revision(first)?, revision(second)?];
    // The comparison sets the length once it knows the number of modules.
    let bar = progress(0);
    let compared = Report::of(revisions.each_ref(), &default_modules(), &lowering(), |n| bar.set_length(n as u64), || bar.inc(1));
    bar.finish_and_clear();
    let report = compared?;
    if as_json {
        print_result(&format!("{}\n", json!({ "report": report, "equal": report.is_equal() })))?;
    } else {
        print_result(&report_text(&report))?;
    }
    match report.failures.len() {
        0 => Ok(()),
        n => Err(CliError::Failed(format!(
            "{} could not be compared; the first: {}: {}",
            counted(n, "module"),
            report.failures[0].0,
            report.failures[0].1
        ))),
    }
}

fn report_text(report: &Report) -> String {
    let mut text =
        format!("A  {}\nB  {}\n{} equal, {} changed", report.first, report.second, counted(report.equal, "module"), report.changed.len());
    let in_one_revision = [("A", &report.only_first), ("B", &report.only_second)];
    for (revision, names) in in_one_revision {
        if !names.is_empty() {
            let _ = write!(text, ", {} in {revision} alone", names.len());
        }
    }
    text.push('\n');
    for (causes, changes) in report.by_cause() {
        text.push_str(&group_text(&causes, &changes));
    }
    for (revision, names) in in_one_revision {
        if !names.is_empty() {
            let _ = writeln!(text, "\nin {revision} alone: {}{}", names[..names.len().min(MAX_LISTED)].join(", "), more_text(names.len()));
        }
    }
    for (module, why) in &report.failures {
        let _ = writeln!(text, "\nnot compared: {module}: {}", echo(why));
    }
    text
}

/// The end of a list of `total` entries of which at most [`MAX_LISTED`] are written.
fn more_text(total: usize) -> String {
    if total > MAX_LISTED { format!(" and {} more", total - MAX_LISTED) } else { String::new() }
}

/// A description of the causes that a group of changes shares. `causes`: their names, joined by ` + `. A fragment is described by its path in the source tree.
fn causes_text(causes: &str) -> String {
    let description = |cause: &str| match cause {
        "generator" => "the generator: lines from no shader source, or their order".to_owned(),
        "lowering" => "the lowering: the same text, another tape".to_owned(),
        path => format!("shaders/{path}"),
    };
    causes.split(" + ").map(description).collect::<Vec<_>>().join(", ")
}

/// The text of the modules whose changes have the same causes.
fn group_text(causes: &str, changes: &[&ModuleChange]) -> String {
    let features: BTreeSet<&str> = changes.iter().flat_map(|c| &c.causes).flat_map(|c| &c.features).map(String::as_str).collect();
    // The largest number of lines that a module of the group lost or gained.
    let most_lines = |count: fn(&crate::export::report::Cause) -> usize| {
        changes.iter().map(|c| c.causes.iter().map(count).sum::<usize>()).max().unwrap_or(0)
    };
    let mut text = format!("\n{}\n  {}", causes_text(causes), counted(changes.len(), "module"));
    let (removed, added) = (most_lines(|c| c.removed), most_lines(|c| c.added));
    if removed + added > 0 {
        let _ = write!(text, ", at most {} removed and {added} added", counted(removed, "line"));
    }
    if !features.is_empty() {
        let _ = write!(text, "; features: {}", features.into_iter().collect::<Vec<_>>().join(", "));
    }
    text.push('\n');
    let greatest_image_change =
        changes.iter().filter_map(|c| Some((c.image?, &c.module))).max_by(|a, b| a.0.max_levels.total_cmp(&b.0.max_levels));
    if let Some((image, module)) = greatest_image_change {
        let _ = writeln!(
            text,
            "  image     at most {:.2} of 255 levels, mean {:.3}, {} pixels differ by half a level or more: {module}",
            image.max_levels, image.mean_levels, image.pixels
        );
    }
    if let Some(range) = change_range(changes, |f| f.mean_luminance) {
        let _ = writeln!(text, "  mean luminance  {range}");
    }
    let greatest = |levels_of: fn(&ModuleChange) -> Option<f64>| changes.iter().filter_map(|c| levels_of(c)).fold(0.0, f64::max);
    if changes.iter().any(|c| c.first.rounding_levels.is_some()) {
        let (before, after) = (greatest(|c| c.first.rounding_levels), greatest(|c| c.second.rounding_levels));
        let _ = writeln!(text, "  f32 against f64  at most {before:.3} of 255 levels apart in A, {after:.3} in B");
    }
    if let Some(range) = change_range(changes, |f| Some(f.operations as f64)) {
        let _ = writeln!(text, "  operations  {range}");
    }
    if let Some(range) = change_range(changes, |f| Some(f.texture_reads as f64)) {
        let _ = writeln!(text, "  texture reads  {range}");
    }
    let names: Vec<&str> = changes.iter().take(MAX_LISTED).map(|c| c.module.as_str()).collect();
    let _ = writeln!(text, "  {}{}", names.join("\n  "), more_text(changes.len()));
    text
}

/// The smallest and the greatest relative change of a figure, as text; `None` if no module has the figure in both revisions. A change from 0 is infinite.
fn change_range(changes: &[&ModuleChange], figure: impl Fn(&Figures) -> Option<f64>) -> Option<String> {
    let percent_change = |c: &&ModuleChange| {
        let (a, b) = (figure(&c.first)?, figure(&c.second)?);
        Some(if a == b { 0.0 } else { 100.0 * (b - a) / a.abs() })
    };
    let percent_changes: Vec<f64> = changes.iter().filter_map(percent_change).collect();
    let (min, max) = percent_changes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), p| (min.min(*p), max.max(*p)));
    match percent_changes.len() {
        0 => None,
        _ if min == 0.0 && max == 0.0 => Some("unchanged".into()),
        _ => Some(format!("{min:+.2} % to {max:+.2} %")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_changes_is_in_percent_and_infinite_from_zero() {
        let change = |before: usize, after: usize| ModuleChange {
            module: "a".into(),
            causes: Vec::new(),
            image: None,
            first: Figures { texture_reads: before, ..Figures::default() },
            second: Figures { texture_reads: after, ..Figures::default() },
        };
        let range = |changes: &[ModuleChange]| {
            change_range(&changes.iter().collect::<Vec<_>>(), |f| Some(f.texture_reads as f64)).expect("a range of changes")
        };
        assert_eq!(range(&[change(0, 0), change(4, 4)]), "unchanged");
        assert_eq!(range(&[change(4, 3), change(4, 4)]), "-25.00 % to +0.00 %");
        assert_eq!(range(&[change(0, 1), change(4, 4)]), "+0.00 % to +inf %");
        assert!(change_range(&[&change(1, 2)], |f| f.mean_luminance).is_none());
    }
}
