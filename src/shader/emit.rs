//! Key to WGSL: a pure function of the key's features and the fragments.
//!
//! In: a module's name, the fragments. Out: the text of one module and, for each of its lines, the fragment it came from and the feature that asked
//! for it. Fragments are real WGSL with directives in comments, each on its own line:
//!
//! - `//: use lib/x.wgsl` puts that fragment here, once per module;
//! - `//: if a.b|c.d`, `//: else`, `//: end` keep lines for keys with any of these features, or with none of them.
//!
//! Not here: any shader code, any knowledge of what a feature means.

use super::fragments::{Fragments, SIMPLE_MODULES};
use super::key::{self, ShaderKey};
use super::{ModuleId, ShaderError};
use serde::{Deserialize, Serialize};

/// Where one emitted line came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineOrigin {
    /// Index into [`SourceMap::fragments`].
    pub fragment: u16,
    /// Line in the fragment, from 1.
    pub line: u32,
    /// Index into [`SourceMap::features`].
    pub feature: u16,
}

/// For each line of a module, who asked for it. Line `n` of the text (from 1) is `lines[n - 1]`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceMap {
    pub fragments: Vec<String>,
    /// Feature names; the first is the module's own name, for lines that every key has.
    pub features: Vec<String>,
    pub lines: Vec<LineOrigin>,
}

impl SourceMap {
    /// The feature that asked for a line (from 1).
    pub fn feature_of(&self, line: usize) -> Option<&str> {
        let origin = self.lines.get(line.checked_sub(1)?)?;
        self.features.get(usize::from(origin.feature)).map(String::as_str)
    }
    /// Fragment path and line of an emitted line (from 1).
    pub fn origin_of(&self, line: usize) -> Option<(&str, u32)> {
        let origin = self.lines.get(line.checked_sub(1)?)?;
        Some((self.fragments.get(usize::from(origin.fragment))?, origin.line))
    }
}

/// The text of one module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Emitted {
    pub wgsl: String,
    pub source_map: SourceMap,
}

/// Emits the module of a key.
pub fn emit(key: &ShaderKey) -> Result<Emitted, ShaderError> {
    emit_module(&ModuleId::Planet(*key))
}

/// Emits any module.
pub fn emit_module(id: &ModuleId) -> Result<Emitted, ShaderError> {
    emit_module_with(&Fragments::default(), id)
}

/// The same from other fragments.
pub fn emit_module_with(fragments: &Fragments, id: &ModuleId) -> Result<Emitted, ShaderError> {
    let (name, features) = match id {
        ModuleId::Planet(key) => ("planet", key::features(key.needs())),
        ModuleId::Simple(name) if SIMPLE_MODULES.contains(name) => (*name, Vec::new()),
        ModuleId::Probe(name, key) => (*name, key::features(key.needs())),
        ModuleId::Simple(name) => return Err(ShaderError::NoSuchModule((*name).to_owned())),
    };
    emit_fragment_with(fragments, &format!("entry/{name}.wgsl"), name, &features)
}

/// Emits one fragment and all it uses. `base` names the lines that no feature asked for.
pub fn emit_fragment(path: &str, base: &str, features: &[&str]) -> Result<Emitted, ShaderError> {
    emit_fragment_with(&Fragments::default(), path, base, features)
}

fn emit_fragment_with(fragments: &Fragments, path: &str, base: &str, features: &[&str]) -> Result<Emitted, ShaderError> {
    let mut emitter = Emitter { fragments, features, wgsl: String::new(), map: SourceMap::default() };
    let base = emitter.feature_index(base);
    emitter.fragment(path, base)?;
    Ok(Emitted { wgsl: emitter.wgsl, source_map: emitter.map })
}

struct Emitter<'a> {
    fragments: &'a Fragments,
    features: &'a [&'a str],
    wgsl: String,
    map: SourceMap,
}

/// One open `if`: whether its lines are kept, and for which feature.
struct Condition {
    holds: bool,
    outer_kept: bool,
    outer_feature: u16,
    else_feature: String,
    line: u32,
}

impl Emitter<'_> {
    fn feature_index(&mut self, name: &str) -> u16 {
        let features = &mut self.map.features;
        let index = features.iter().position(|f| f == name).unwrap_or_else(|| {
            features.push(name.to_owned());
            features.len() - 1
        });
        index as u16
    }

    fn fragment(&mut self, path: &str, asked_by: u16) -> Result<(), ShaderError> {
        if self.map.fragments.iter().any(|f| f == path) {
            return Ok(());
        }
        let broken = |line: u32, what: String| ShaderError::Fragment { path: path.to_owned(), line, what };
        let text = self.fragments.text(path).ok_or_else(|| broken(0, "there is no such fragment".into()))?;
        let fragment = self.map.fragments.len() as u16;
        self.map.fragments.push(path.to_owned());
        let mut open: Vec<Condition> = Vec::new();
        let (mut kept, mut feature) = (true, asked_by);
        for (number, line) in (1u32..).zip(text.lines()) {
            let Some(directive) = line.trim_start().strip_prefix("//:") else {
                if kept {
                    self.wgsl.push_str(line);
                    self.wgsl.push('\n');
                    self.map.lines.push(LineOrigin { fragment, line: number, feature });
                }
                continue;
            };
            let (word, argument) = directive.trim().split_once(' ').unwrap_or((directive.trim(), ""));
            match word {
                "use" if kept => self.fragment(argument.trim(), feature)?,
                "use" => {}
                "if" => {
                    let names: Vec<&str> = argument.split('|').map(str::trim).collect();
                    if let Some(unknown) = names.iter().find(|n| !known_feature(n)) {
                        return Err(broken(number, format!("`{unknown}` is no feature of any key")));
                    }
                    let found = names.iter().find(|n| self.features.contains(n));
                    let condition = Condition {
                        holds: found.is_some(),
                        outer_kept: kept,
                        outer_feature: feature,
                        else_feature: format!("not {}", names.join(", ")),
                        line: number,
                    };
                    open.push(condition);
                    if kept && let Some(name) = found {
                        feature = self.feature_index(name);
                    }
                    kept &= found.is_some();
                }
                "else" => {
                    let Some(condition) = open.last() else { return Err(broken(number, "`else` without `if`".into())) };
                    let name = condition.else_feature.clone();
                    kept = condition.outer_kept && !condition.holds;
                    if kept {
                        feature = self.feature_index(&name);
                    }
                }
                "end" => {
                    let Some(condition) = open.pop() else { return Err(broken(number, "`end` without `if`".into())) };
                    (kept, feature) = (condition.outer_kept, condition.outer_feature);
                }
                _ => return Err(broken(number, format!("`{word}` is not a directive: use, if, else, end"))),
            }
        }
        match open.last() {
            Some(condition) => Err(broken(condition.line, "this `if` has no `end`".into())),
            None => Ok(()),
        }
    }
}

fn known_feature(name: &str) -> bool {
    key::DIMENSIONS.iter().any(|d| d.features.contains(&name)) && !name.is_empty()
}
