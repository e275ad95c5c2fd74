//! Stores each distinct line of all modules once in a table, and represents a module as runs of consecutive lines of this table.
//!
//! In: the text and the source map of each module. Out: the module's runs; the table as a script for the atlas's pages.

use crate::shader::SourceMap;
use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;

/// One line with its origin.
#[derive(Clone, PartialEq, Eq, Hash)]
struct SourceLine {
    text: String,
    /// Path of the fragment below shaders/; empty if the source map lacks it.
    fragment: String,
    /// Number of the line in the fragment, from 1; 0 if the source map lacks it.
    fragment_line: u32,
    /// Feature that includes the line; the module's own name if the line depends on no feature.
    feature: String,
}

/// The distinct lines, in the order of their first use, so that consecutive lines of a module mostly have consecutive indices.
#[derive(Default)]
pub(crate) struct LineTable {
    /// Index of each line in `lines`.
    indices: HashMap<SourceLine, usize>,
    lines: Vec<SourceLine>,
}

impl LineTable {
    /// Adds a module's lines. Returns them as runs of the table's lines: pairs `first,count`, separated by `;`, where `first` is the index of a line, from 0.
    pub(crate) fn add(&mut self, wgsl: &str, map: &SourceMap) -> String {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for (line_number, text) in (1..).zip(wgsl.lines()) {
            let (fragment, fragment_line) = map.origin_of(line_number).unwrap_or_default();
            let feature = map.feature_of(line_number).unwrap_or_default();
            let line = SourceLine { text: text.to_owned(), fragment: fragment.to_owned(), fragment_line, feature: feature.to_owned() };
            let index = *self.indices.entry(line).or_insert_with_key(|line| {
                self.lines.push(line.clone());
                self.lines.len() - 1
            });
            match runs.last_mut() {
                Some((first, count)) if *first + *count == index => *count += 1,
                _ => runs.push((index, 1)),
            }
        }
        runs.iter().map(|(first, count)| format!("{first},{count}")).collect::<Vec<_>>().join(";")
    }

    /// The table as a script: the names of fragments and features; each line as its text, the index of its fragment, its number in the fragment, and the
    /// index of its feature.
    pub(crate) fn script(&self) -> String {
        let names = |field: fn(&SourceLine) -> &str| self.lines.iter().map(field).collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>();
        let (fragments, features) = (names(|l| &l.fragment), names(|l| &l.feature));
        let index = |names: &[&str], name: &str| names.binary_search(&name).unwrap_or_default();
        let mut rows = String::new();
        for line in &self.lines {
            let (fragment, feature) = (index(&fragments, &line.fragment), index(&features, &line.feature));
            let _ = writeln!(rows, "{},", serde_json::json!([line.text, fragment, line.fragment_line, feature]));
        }
        format!(
            "// Each distinct line of all modules: text, fragment, number of the line in the fragment, feature.\nconst FRAGMENTS = {};\nconst FEATURES = {};\nconst LINES = [\n{rows}];\n",
            serde_json::json!(fragments),
            serde_json::json!(features)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::{Lowering, ModuleId, ShaderModule};

    #[test]
    fn modules_can_be_reconstructed_from_their_runs() {
        let modules: Vec<ShaderModule> = ["lambert.sun1.sphere", "lambert.albedo.sun1.ellipsoid", "tone_map"]
            .iter()
            .map(|name| ShaderModule::build(&name.parse::<ModuleId>().expect(name), &Lowering::without_tape()).expect(name))
            .collect();
        let mut table = LineTable::default();
        let runs: Vec<String> = modules.iter().map(|m| table.add(&m.wgsl, &m.source_map)).collect();
        for (module, runs) in modules.iter().zip(&runs) {
            let mut text = String::new();
            for run in runs.split(';') {
                let (first, count) = run.split_once(',').expect("a pair");
                let (first, count): (usize, usize) = (first.parse().expect("a number"), count.parse().expect("a number"));
                table.lines[first..first + count].iter().for_each(|l| text.push_str(&format!("{}\n", l.text)));
            }
            assert_eq!(text, module.wgsl);
        }
        let total: usize = modules.iter().map(|m| m.wgsl.lines().count()).sum();
        assert!(table.lines.len() < total, "shared lines are stored once: {} of {total}", table.lines.len());
        assert_eq!(table.script().matches("\n[").count(), table.lines.len());
    }
}
