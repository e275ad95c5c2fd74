//! Emits the WGSL of a module: a pure function of the [`ModuleId`], which contains the module's features, and of the fragments.
//!
//! In: a module's id and the fragments. Out: the text of one module and, for each of its lines, the fragment that the line came
//! from and the feature that includes it. Fragments are WESL (<https://wesl-lang.dev>). An item whose `@if`, `@elif` or `@else`
//! condition is false is omitted together with the comment lines directly above it. An import is replaced by the entire fragment
//! that it names, once per module. Comments and names are kept, so no two fragments of one module may declare the same name: the names of a custom surface
//! get a prefix before they come here (`source::with_prefixed_names`).
//!
//! The emitter contains no shader code and does not know what a feature means.

use super::ShaderError;
use super::fragments::Fragments;
use super::id::{ModuleId, SIMPLE_MODULES};
use super::key::{self, ShaderKey};
use super::source::condition::FeatureSet;
use super::source::{Fragment, Import};
pub use super::source_map::{LineOrigin, SourceMap};

/// The text of one module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Emitted {
    /// The complete module.
    pub wgsl: String,
    /// Where each line comes from.
    pub source_map: SourceMap,
}

/// Emits the module of a key.
///
/// # Errors
/// See [`emit_module_with`].
pub fn emit(key: &ShaderKey) -> Result<Emitted, ShaderError> {
    emit_module(&ModuleId::Keyed(*key))
}

/// Emits any module.
///
/// # Errors
/// See [`emit_module_with`].
pub fn emit_module(id: &ModuleId) -> Result<Emitted, ShaderError> {
    emit_module_with(&Fragments::default(), id)
}

/// Emits any module from the given fragments.
///
/// # Errors
/// There is no simple shader of this name, or a fragment has an error, which is returned with its line and column.
pub fn emit_module_with(fragments: &Fragments, id: &ModuleId) -> Result<Emitted, ShaderError> {
    // Modules with a key draw parts of bodies: entry/planet.wesl.
    let (name, feature_names) = match id {
        ModuleId::Keyed(key) => ("planet", key::feature_names(key.features())),
        ModuleId::Simple(name) if SIMPLE_MODULES.contains(name) => (*name, Vec::new()),
        ModuleId::Probe(name, key) => (*name, key::feature_names(key.features())),
        ModuleId::Simple(name) => return Err(ShaderError::NoSuchModule((*name).to_owned())),
    };
    emit_fragment_with(fragments, &format!("entry/{name}.wesl"), name, &feature_names)
}

/// Emits one fragment and everything that it imports. `base_feature`: what the source map states in place of a feature for lines that depend on none; for a
/// module, the name of its first fragment. `feature_names`: the features that are on.
///
/// # Errors
/// See [`emit_module_with`].
pub fn emit_fragment(path: &str, base_feature: &str, feature_names: &[&str]) -> Result<Emitted, ShaderError> {
    emit_fragment_with(&Fragments::default(), path, base_feature, feature_names)
}

/// As [`emit_fragment`], from the given fragments.
pub(super) fn emit_fragment_with(
    fragments: &Fragments,
    path: &str,
    base_feature: &str,
    feature_names: &[&str],
) -> Result<Emitted, ShaderError> {
    let mut emitter = Emitter { fragments, features: FeatureSet::of(feature_names), wgsl: String::new(), source_map: SourceMap::default() };
    let base_feature_index = emitter.source_map.feature_index(base_feature);
    let missing = || ShaderError::Fragment { path: path.to_owned(), line: 0, column: 0, what: "there is no such shader source".into() };
    let (text, fragment) = fragments.parsed(path).ok_or_else(missing)?;
    emitter.append_fragment(path, text, fragment?, base_feature_index)?;
    Ok(Emitted { wgsl: emitter.wgsl, source_map: emitter.source_map })
}

struct Emitter<'a> {
    fragments: &'a Fragments,
    /// The features that are on.
    features: FeatureSet,
    /// The text emitted so far.
    wgsl: String,
    source_map: SourceMap,
}

impl Emitter<'_> {
    /// Appends a fragment and what it imports. `importing_feature`: index of the feature that requires the import of this fragment; lines of the fragment
    /// without a condition get this feature in the source map.
    fn append_fragment(&mut self, path: &str, text: &str, fragment: &Fragment, importing_feature: u16) -> Result<(), ShaderError> {
        let fragment_index = self.source_map.fragments.len() as u16;
        self.source_map.fragments.push(path.to_owned());
        // A block is a part of the fragment that is emitted under one condition (`source::Block`).
        let block_is_emitted = fragment.emitted_blocks(self.features);
        let mut feature_of_block: Vec<Option<u16>> = vec![None; fragment.blocks.len()];
        let mut imports = fragment.imports.iter().peekable();
        for (line_number, line) in (1u32..).zip(&fragment.lines) {
            while let Some(import) = imports.next_if(|i| i.line <= line_number) {
                if block_is_emitted[import.block as usize] {
                    let feature =
                        self.feature_index_of(fragment, import.block, &block_is_emitted, &mut feature_of_block, importing_feature);
                    self.append_import(path, import, feature)?;
                }
            }
            let start = self.wgsl.len();
            // The line belongs to the block of its first piece that is not blank; a blank line, to that of its last piece.
            let mut block = None;
            for piece in line.pieces.iter().filter(|p| block_is_emitted[p.block as usize]) {
                let piece_text = &text[piece.span.clone()];
                self.wgsl.push_str(piece_text);
                let only_blanks_precede = self.wgsl[start..].trim_start().len() == piece_text.trim_start().len();
                if block.is_none() || only_blanks_precede {
                    block = Some(piece.block);
                }
            }
            self.wgsl.truncate(start + self.wgsl[start..].trim_end().len());
            let is_blank = self.wgsl.len() == start;
            // A blank line is kept if it is also blank in the fragment, except at the start of the module and after another blank line.
            let may_be_blank = !line.is_divided && !self.wgsl.is_empty() && !self.wgsl.ends_with("\n\n");
            let Some(block) = block.filter(|_| !is_blank || may_be_blank) else {
                continue;
            };
            self.wgsl.push('\n');
            let feature = self.feature_index_of(fragment, block, &block_is_emitted, &mut feature_of_block, importing_feature);
            self.source_map.lines.push(LineOrigin { fragment: fragment_index, line: line_number, feature });
        }
        Ok(())
    }

    /// Index, in the source map, of the features that explain why a block is emitted. `feature_of_block`: the indices found so far.
    fn feature_index_of(
        &mut self,
        fragment: &Fragment,
        block: u32,
        block_is_emitted: &[bool],
        feature_of_block: &mut [Option<u16>],
        importing_feature: u16,
    ) -> u16 {
        if let Some(index) = feature_of_block[block as usize] {
            return index;
        }
        let index = match fragment.reason(block, block_is_emitted, self.features) {
            Some(reason) => self.source_map.feature_index(&reason),
            None => importing_feature,
        };
        feature_of_block[block as usize] = Some(index);
        index
    }

    /// Appends the fragment that an import names, unless the module already contains it. `from`: path of the importing fragment.
    fn append_import(&mut self, from: &str, import: &Import, importing_feature: u16) -> Result<(), ShaderError> {
        let error = |what: String| ShaderError::Fragment { path: from.to_owned(), line: import.line, column: import.column, what };
        let fragments = self.fragments;
        let Some((text, fragment)) = fragments.parsed(&import.path) else {
            return Err(error(format!("there is no shader source `{}`; an import names a source and an item of it", import.path)));
        };
        let fragment = fragment?;
        if !fragment.declared.contains(&import.item) {
            return Err(error(format!("shaders/{} declares no `{}`", import.path, import.item)));
        }
        if self.source_map.fragments.contains(&import.path) {
            return Ok(());
        }
        self.append_fragment(&import.path, text, fragment, importing_feature)
    }
}
