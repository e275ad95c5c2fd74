//! The source map: for each line of an emitted module, the fragment (WESL file) and line from which it came, and the features on which the line depends.
//! `emit` fills it.

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

/// The origins of a module's lines. Line `n` of the text (from 1) is `lines[n - 1]`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceMap {
    /// Paths below shaders/ of the fragments in the module.
    pub fragments: Vec<String>,
    /// Names of features. If a line depends on several features, or on a feature being off, one entry states the whole condition, such as
    /// `lights.1, not lights.2`. The first entry is the module's own name, which stands for lines that depend on no feature.
    pub features: Vec<String>,
    /// One origin per line of the text.
    pub lines: Vec<LineOrigin>,
}

impl SourceMap {
    /// The entry of [`SourceMap::features`] for an emitted line (from 1): a feature, a condition, or the module's name. `None` past the last line.
    pub fn feature_of(&self, line: usize) -> Option<&str> {
        let origin = self.lines.get(line.checked_sub(1)?)?;
        self.features.get(usize::from(origin.feature)).map(String::as_str)
    }

    /// Fragment path and line of an emitted line (from 1); `None` past the last line.
    pub fn origin_of(&self, line: usize) -> Option<(&str, u32)> {
        let origin = self.lines.get(line.checked_sub(1)?)?;
        Some((self.fragments.get(usize::from(origin.fragment))?, origin.line))
    }

    /// Index of `name` in [`SourceMap::features`], to which it is added if it is missing.
    pub(super) fn feature_index(&mut self, name: &str) -> u16 {
        let index = self.features.iter().position(|f| f == name).unwrap_or_else(|| {
            self.features.push(name.to_owned());
            self.features.len() - 1
        });
        index as u16
    }
}
