//! Compares two modules, and counts the cost of one.
//!
//! In: modules. Out: the lines in which two modules differ, grouped by feature or by fragment (WESL source file); the operations, branches and texture reads in
//! a module's IR (naga's intermediate representation).

use super::{Emitted, ShaderModule, SourceMap};
use naga::{Expression, Statement};
use std::collections::{BTreeMap, BTreeSet};

/// Lines of one feature that occur in only one of two modules.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FeatureDiff {
    pub feature: String,
    pub only_first: Vec<EmittedLine>,
    pub only_second: Vec<EmittedLine>,
}

/// One emitted line, with the fragment (WESL file) and the line that it came from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EmittedLine {
    pub fragment: String,
    /// Line in the fragment, from 1.
    pub line: u32,
    pub text: String,
}

/// The lines of a module, each with its feature. Lines without an origin in a fragment are left out.
fn lines_of<'a>(wgsl: &'a str, map: &'a SourceMap) -> impl Iterator<Item = (&'a str, EmittedLine)> {
    wgsl.lines().enumerate().filter_map(|(i, text)| {
        // The source map counts lines from 1.
        let (fragment, line) = map.origin_of(i + 1)?;
        Some((map.feature_of(i + 1)?, EmittedLine { fragment: fragment.to_owned(), line, text: text.to_owned() }))
    })
}

/// Lines that occur in only one of the two modules, grouped by feature and sorted by the feature's name. Two lines are equal if they have the same text and
/// come from the same line of the same fragment, wherever they are in the module.
pub fn difference(first: &Emitted, second: &Emitted) -> Vec<FeatureDiff> {
    let lines = |e: &Emitted| -> BTreeSet<EmittedLine> { lines_of(&e.wgsl, &e.source_map).map(|(_, l)| l).collect() };
    let (in_first, in_second) = (lines(first), lines(second));
    let mut by_feature: BTreeMap<&str, FeatureDiff> = BTreeMap::new();
    for (feature, line) in lines_of(&first.wgsl, &first.source_map).filter(|(_, l)| !in_second.contains(l)) {
        by_feature.entry(feature).or_default().only_first.push(line);
    }
    for (feature, line) in lines_of(&second.wgsl, &second.source_map).filter(|(_, l)| !in_first.contains(l)) {
        by_feature.entry(feature).or_default().only_second.push(line);
    }
    by_feature.into_iter().map(|(feature, d)| FeatureDiff { feature: feature.to_owned(), ..d }).collect()
}

/// How many lines of one fragment occur in only one of two revisions of a module, an earlier one (the first) and a later one (the second).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChangedLines {
    /// Names of the features to which these lines belong.
    pub features: BTreeSet<String>,
    /// Number of lines that only the first revision has.
    pub removed: usize,
    /// Number of lines that only the second revision has.
    pub added: usize,
}

/// The changes between two revisions of one module, by path of the fragment; fragments whose emitted lines are the same are left out. Lines are compared by
/// their text: a line that only moved within its fragment is unchanged. `first`, `second`: WGSL and source map of each revision.
pub fn changed_lines(first: (&str, &SourceMap), second: (&str, &SourceMap)) -> BTreeMap<String, ChangedLines> {
    // By fragment path and text of the line: occurrences in the first revision minus those in the second, and the feature of the first occurrence.
    let mut counts: BTreeMap<(String, String), (i64, String)> = BTreeMap::new();
    for ((wgsl, map), sign) in [(first, 1), (second, -1)] {
        for (feature, line) in lines_of(wgsl, map) {
            let (count, _feature) = counts.entry((line.fragment, line.text)).or_insert_with(|| (0, feature.to_owned()));
            *count += sign;
        }
    }
    let mut changed: BTreeMap<String, ChangedLines> = BTreeMap::new();
    for ((fragment, _), (count, feature)) in counts.into_iter().filter(|(_, (count, _))| *count != 0) {
        let lines = changed.entry(fragment).or_default();
        lines.features.insert(feature);
        let number = usize::try_from(count.unsigned_abs()).unwrap_or(usize::MAX);
        if count > 0 { lines.removed += number } else { lines.added += number }
    }
    changed
}

/// Sizes of a module, and counts in its IR. Operations and branches of a function count once, however often it is called; its texture reads count once per
/// call.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct IrCost {
    /// Number of unary, binary, `Math`, `select` and derivative expressions, by operator or function (naga's name in lower case).
    pub operations: BTreeMap<String, u32>,
    /// Texture reads of the entry points, including those of the functions that they call, once per call. At most `u32::MAX`.
    pub texture_reads: u32,
    /// Number of `if`, `switch` and loops.
    pub branches: u32,
    /// Number of functions, including the entry points.
    pub functions: u32,
    /// Size of the uniform block.
    pub uniform_bytes: u32,
    /// Lines of the emitted WGSL.
    pub lines: u32,
}

fn count_branches(block: &naga::Block, branches: &mut u32) {
    for statement in block {
        match statement {
            Statement::Block(inner) => count_branches(inner, branches),
            Statement::If { accept, reject, .. } => {
                *branches += 1;
                count_branches(accept, branches);
                count_branches(reject, branches);
            }
            Statement::Switch { cases, .. } => {
                *branches += 1;
                cases.iter().for_each(|c| count_branches(&c.body, branches));
            }
            Statement::Loop { body, continuing, .. } => {
                *branches += 1;
                count_branches(body, branches);
                count_branches(continuing, branches);
            }
            _ => {}
        }
    }
}

fn saturating_sum(counts: impl Iterator<Item = u32>) -> u32 {
    counts.fold(0, u32::saturating_add)
}

/// Texture reads of a function and of its callees, once per call; what is in a loop counts as in one iteration. `reads_of_earlier`: reads of the functions
/// declared before this one, by index. The sum saturates, because it can grow exponentially: n functions, each of which calls the previous one twice, make 2^n
/// reads.
fn texture_reads(function: &naga::Function, reads_of_earlier: &[u32]) -> u32 {
    fn reads_by_calls(block: &naga::Block, reads_of_earlier: &[u32]) -> u32 {
        let reads_in = |b: &naga::Block| reads_by_calls(b, reads_of_earlier);
        let each = block.iter().map(|statement| match statement {
            // naga's validator rejects calls of later functions.
            Statement::Call { function, .. } => reads_of_earlier.get(function.index()).copied().unwrap_or(0),
            Statement::Block(inner) => reads_in(inner),
            Statement::If { accept, reject, .. } => reads_in(accept).saturating_add(reads_in(reject)),
            Statement::Switch { cases, .. } => saturating_sum(cases.iter().map(|c| reads_in(&c.body))),
            Statement::Loop { body, continuing, .. } => reads_in(body).saturating_add(reads_in(continuing)),
            _ => 0,
        });
        saturating_sum(each)
    }
    let own = function.expressions.iter().filter(|(_, e)| matches!(e, Expression::ImageSample { .. } | Expression::ImageLoad { .. }));
    (own.count() as u32).saturating_add(reads_by_calls(&function.body, reads_of_earlier))
}

/// The sizes and counts of a module.
pub fn ir_cost(shader: &ShaderModule) -> IrCost {
    let mut cost = IrCost { uniform_bytes: shader.layout.uniform_size, lines: shader.wgsl.lines().count() as u32, ..IrCost::default() };
    let naga::Module { functions, entry_points, .. } = &shader.module;
    let mut reads_of: Vec<u32> = Vec::new();
    for (_, function) in functions.iter() {
        // Callees come before their callers.
        reads_of.push(texture_reads(function, &reads_of));
    }
    cost.texture_reads = saturating_sum(entry_points.iter().map(|e| texture_reads(&e.function, &reads_of)));
    for function in functions.iter().map(|(_, f)| f).chain(entry_points.iter().map(|e| &e.function)) {
        cost.functions += 1;
        count_branches(&function.body, &mut cost.branches);
        for (_, expression) in function.expressions.iter() {
            let kind = match expression {
                Expression::Binary { op, .. } => format!("{op:?}").to_lowercase(),
                Expression::Unary { op, .. } => format!("{op:?}").to_lowercase(),
                Expression::Math { fun, .. } => format!("{fun:?}").to_lowercase(),
                Expression::Select { .. } => "select".into(),
                Expression::Derivative { .. } => "derivative".into(),
                _ => continue,
            };
            *cost.operations.entry(kind).or_default() += 1;
        }
    }
    cost
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::{Lowering, ModuleId};

    /// The texture reads of a module in which each of `n` functions calls the one before it twice; the first reads a texture once.
    fn reads_of_doubling_calls(n: usize) -> u32 {
        let mut wgsl = "@group(0) @binding(1) var image: texture_2d<f32>;\n".to_owned();
        wgsl.push_str("fn level0() -> f32 { return textureLoad(image, vec2i(0), 0).x; }\n");
        for k in 1..=n {
            wgsl.push_str(&format!("fn level{k}() -> f32 {{ return level{0}() + level{0}(); }}\n", k - 1));
        }
        wgsl.push_str(&format!("@fragment fn fragment_main() -> @location(0) vec4f {{ return vec4f(level{n}()); }}\n"));
        let emitted = Emitted { wgsl, source_map: SourceMap::default() };
        let module = ShaderModule::from_emitted(&ModuleId::Simple("tone_map"), emitted, &Lowering::without_tape()).expect("a module");
        ir_cost(&module).texture_reads
    }

    #[test]
    fn texture_reads_are_counted_per_call_and_saturate() {
        // n functions that double the reads make 2^n.
        assert_eq!([0, 1, 5].map(reads_of_doubling_calls), [1, 2, 32]);
        assert_eq!(reads_of_doubling_calls(33), u32::MAX);
    }
}
