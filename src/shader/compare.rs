//! What differs between two modules, by the feature that asked for it; and what a module costs by its IR.

use super::{Emitted, ShaderModule, SourceMap};
use naga::{Expression, Statement};
use std::collections::{BTreeMap, BTreeSet};

/// Lines of one feature that only one of two modules has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FeatureDifference {
    pub feature: String,
    pub only_first: Vec<Line>,
    pub only_second: Vec<Line>,
}

/// One line with its place in the fragments.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Line {
    pub fragment: String,
    pub line: u32,
    pub text: String,
}

/// The lines of a module with their features.
fn lines_of<'a>(wgsl: &'a str, map: &'a SourceMap) -> impl Iterator<Item = (&'a str, Line)> {
    wgsl.lines().enumerate().filter_map(|(i, text)| {
        let (fragment, line) = map.origin_of(i + 1)?;
        Some((map.feature_of(i + 1)?, Line { fragment: fragment.to_owned(), line, text: text.to_owned() }))
    })
}

/// What differs, by feature in order of name. Empty exactly when the texts are equal line for line.
pub fn difference(first: &Emitted, second: &Emitted) -> Vec<FeatureDifference> {
    let places = |e: &Emitted| -> BTreeSet<Line> { lines_of(&e.wgsl, &e.source_map).map(|(_, l)| l).collect() };
    let (in_first, in_second) = (places(first), places(second));
    let mut by_feature: BTreeMap<&str, FeatureDifference> = BTreeMap::new();
    for (feature, line) in lines_of(&first.wgsl, &first.source_map).filter(|(_, l)| !in_second.contains(l)) {
        by_feature.entry(feature).or_default().only_first.push(line);
    }
    for (feature, line) in lines_of(&second.wgsl, &second.source_map).filter(|(_, l)| !in_first.contains(l)) {
        by_feature.entry(feature).or_default().only_second.push(line);
    }
    by_feature.into_iter().map(|(feature, d)| FeatureDifference { feature: feature.to_owned(), ..d }).collect()
}

/// What a module's IR holds. Each function counts once, however often it is called.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct IrCost {
    /// Expressions that compute, by kind.
    pub operations: BTreeMap<String, u32>,
    pub texture_reads: u32,
    pub branches: u32,
    pub functions: u32,
    pub uniform_bytes: u32,
    pub lines: u32,
}

fn count_block(block: &naga::Block, branches: &mut u32) {
    for statement in block {
        match statement {
            Statement::Block(inner) => count_block(inner, branches),
            Statement::If { accept, reject, .. } => {
                *branches += 1;
                count_block(accept, branches);
                count_block(reject, branches);
            }
            Statement::Switch { cases, .. } => {
                *branches += 1;
                cases.iter().for_each(|c| count_block(&c.body, branches));
            }
            Statement::Loop { body, continuing, .. } => {
                *branches += 1;
                count_block(body, branches);
                count_block(continuing, branches);
            }
            _ => {}
        }
    }
}

/// Counts what a module's IR holds.
pub fn ir_cost(m: &ShaderModule) -> IrCost {
    let mut cost = IrCost { uniform_bytes: m.layout.uniform_size, lines: m.wgsl.lines().count() as u32, ..IrCost::default() };
    let functions = m.module.functions.iter().map(|(_, f)| f).chain(m.module.entry_points.iter().map(|e| &e.function));
    for function in functions {
        cost.functions += 1;
        count_block(&function.body, &mut cost.branches);
        for (_, expression) in function.expressions.iter() {
            let kind = match expression {
                Expression::Binary { op, .. } => format!("{op:?}").to_lowercase(),
                Expression::Unary { op, .. } => format!("{op:?}").to_lowercase(),
                Expression::Math { fun, .. } => format!("{fun:?}").to_lowercase(),
                Expression::Select { .. } => "select".into(),
                Expression::Derivative { .. } => "derivative".into(),
                Expression::ImageSample { .. } | Expression::ImageLoad { .. } => {
                    cost.texture_reads += 1;
                    continue;
                }
                _ => continue,
            };
            *cost.operations.entry(kind).or_default() += 1;
        }
    }
    cost
}
