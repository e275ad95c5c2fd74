//! A complete module: its text, its IR (naga's intermediate representation) and what is derived from them.
//!
//! In: a module's name, and the lowering of the software renderer. Out: [`ShaderModule`]: WGSL, validated IR, layout, source map, and the tape (the list of
//! operations that the software renderer runs).

use super::emit::{emit_fragment_with, emit_module_with};
use super::fragments::Fragments;
use super::id::ModuleId;
use super::key::{ShaderKey, feature_names};
use super::reflect::Layout;
use super::source_map::SourceMap;
use super::{Emitted, ShaderError};
use naga::valid::{Capabilities, FunctionError, ModuleInfo, ValidationError, ValidationFlags, Validator};

/// Why a lowering rejects a module, in one line.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{what}")]
pub struct LoweringFailure {
    /// The unsupported construct.
    pub what: String,
    /// Its position in the module's text; undefined if it has none.
    pub span: naga::Span,
}

/// Why bytes are not the tape of a module, in one line.
pub type TapeFault = Box<dyn std::error::Error + Send + Sync>;

/// The lowering: converts validated modules to tapes, the programs of the software renderer. The caller of [`super::ShaderLibrary`] supplies these functions,
/// so that `shader` depends on no renderer.
#[derive(Clone, Debug)]
pub struct Lowering {
    /// Digest of the lowering's code: an input of the generator digest, which names the shader library's folder on disk.
    pub digest: String,
    /// Lowers validated IR to the bytes of a tape; the error names the unsupported construct.
    pub lower: fn(&naga::Module, &ModuleInfo) -> Result<Vec<u8>, LoweringFailure>,
    /// Checks that bytes from disk are a tape with this module's entry points and bindings, and that all indices are in range.
    pub check: fn(&naga::Module, &[u8]) -> Result<(), TapeFault>,
}

impl Lowering {
    /// A lowering whose tapes are empty, for tools that need only the text and the IR.
    pub fn without_tape() -> Self {
        Self { digest: "none".into(), lower: |_, _| Ok(Vec::new()), check: |_, _| Ok(()) }
    }
}

/// A module that is ready to run.
#[derive(Clone, Debug)]
pub struct ShaderModule {
    /// The module's name or key.
    pub id: ModuleId,
    /// The emitted WGSL.
    pub wgsl: String,
    /// The text as naga's IR.
    pub module: naga::Module,
    /// The analysis of naga's validator.
    pub info: ModuleInfo,
    /// Uniform fields and bindings.
    pub layout: Layout,
    /// Where each line of the text comes from.
    pub source_map: SourceMap,
    /// The software renderer's tape; empty with [`Lowering::without_tape`].
    pub tape: Vec<u8>,
}

/// Runs all checks of naga's validator, without optional capabilities: the module may use only what every WebGPU implementation supports.
pub fn validate(module: &naga::Module) -> Result<ModuleInfo, Box<naga::WithSpan<ValidationError>>> {
    Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(module).map_err(Box::new)
}

/// The line (from 1) of an emitted text in which naga's parser found a fault: that of the first label with a position; `None` if no label has one. If a value
/// has the wrong type, the value's label counts, because the first label is then the place that asks for another type, such as a struct's member in another
/// fragment.
fn parse_error_line(e: &naga::front::wgsl::ParseError, wgsl: &str) -> Option<u32> {
    let labels: Vec<(naga::Span, &str)> = e.labels().filter(|(span, _)| span.is_defined()).collect();
    let wrong_value = labels.iter().find(|(_, text)| text.starts_with("this expression has type"));
    wrong_value.or(labels.first()).map(|(span, _)| span.location(wgsl).line_number)
}

/// The line (from 1) of an emitted text in which naga's validator found a fault. The validator names several parts of the text, such as the function and the
/// expression in it; the shortest part counts. `None` if it names none.
fn validation_error_line(e: &naga::WithSpan<ValidationError>, wgsl: &str) -> Option<u32> {
    let parts = e.spans().filter_map(|(span, _)| Some((span.to_range()?.len(), span)));
    parts.min_by_key(|(length, _)| *length).map(|(_, span)| span.location(wgsl).line_number)
}

/// What naga's validator found, with its causes, in one line.
fn validation_message(e: &ValidationError) -> String {
    if let ValidationError::Function { name, source: FunctionError::InvalidReturnType { expression: None, .. }, .. } = e {
        // The validator's own words name types by their numbers.
        return format!("the function `{name}` can end without a value; end it with a `return`");
    }
    let mut message = e.to_string();
    let mut cause = std::error::Error::source(e);
    while let Some(c) = cause {
        message.push_str(&format!(": {c}"));
        cause = c.source();
    }
    message
}

/// The first error in the WESL files or in the emitted text of a module: the message of the generator or of naga, with the line and a caret
/// below the position. `None` for a valid module, and for a name that no module has.
pub fn diagnosis(fragments: &Fragments, id: &ModuleId) -> Option<String> {
    let Emitted { wgsl, source_map } = match emit_module_with(fragments, id) {
        Ok(emitted) => emitted,
        Err(ShaderError::Fragment { path, line, column, what }) => {
            let text = fragments.text(&path).and_then(|t| t.lines().nth((line as usize).checked_sub(1)?)).unwrap_or_default();
            let indent = " ".repeat((column as usize).saturating_sub(1));
            return Some(format!("shaders/{path}, line {line}, column {column}\n\n{line:>4} | {text}\n     | {indent}^ {what}\n"));
        }
        // No module has this name: emission has no other errors.
        Err(_) => return None,
    };
    let (message, emitted_line) = match naga::front::wgsl::parse_str(&wgsl) {
        Err(e) => (e.emit_to_string_with_path(&wgsl, &id.to_string()), parse_error_line(&e, &wgsl)),
        Ok(module) => {
            let e = validate(&module).err()?;
            (e.emit_to_string_with_path(&wgsl, &id.to_string()), validation_error_line(&e, &wgsl))
        }
    };
    let origin = emitted_line.and_then(|l| source_map.origin_of(l as usize));
    Some(origin.map_or(message.clone(), |(fragment, line)| format!("shaders/{fragment}, line {line}\n\n{message}")))
}

/// Checks that a fragment declares or imports every name that it uses: other names are those of fragments that some modules contain and others lack.
///
/// # Errors
/// The first error of naga's parser in the fragment, if it is emitted with its imports alone. Errors in what it imports are those of the entire module.
pub fn check_names(fragments: &Fragments, path: &str, key: &ShaderKey) -> Result<(), ShaderError> {
    let Emitted { wgsl, source_map } = emit_fragment_with(fragments, path, "fragment", &feature_names(key.features()))?;
    let Err(e) = naga::front::wgsl::parse_str(&wgsl) else { return Ok(()) };
    match parse_error_line(&e, &wgsl).and_then(|line| source_map.origin_of(line as usize)) {
        Some((fragment, line)) if fragment == path => {
            Err(ShaderError::Parse { id: key.to_string(), what: format!("shaders/{path}:{line}: {}", e.message()) })
        }
        _ => Ok(()),
    }
}

impl ShaderModule {
    /// Builds a module from the built-in fragments: emits, parses, validates, reflects and lowers it.
    pub fn build(id: &ModuleId, lowering: &Lowering) -> Result<Self, ShaderError> {
        Self::build_with(&Fragments::default(), id, lowering)
    }

    /// Emits from the given fragments, then parses, validates, reflects and lowers.
    pub fn build_with(fragments: &Fragments, id: &ModuleId, lowering: &Lowering) -> Result<Self, ShaderError> {
        Self::from_emitted(id, emit_module_with(fragments, id)?, lowering)
    }

    /// Parses, validates, reflects and lowers an emitted text.
    pub fn from_emitted(id: &ModuleId, emitted: Emitted, lowering: &Lowering) -> Result<Self, ShaderError> {
        let Emitted { wgsl, source_map } = emitted;
        let name = || id.to_string();
        // Fragment and line of a line of the emitted text. In a message the place comes before the reason, so that a reader who shortens the message keeps it.
        let place_text = |line: Option<u32>| match line.and_then(|l| source_map.origin_of(l as usize)) {
            Some((fragment, line)) => format!("shaders/{fragment}:{line}: "),
            None => String::new(),
        };
        let module = naga::front::wgsl::parse_str(&wgsl).map_err(|e| {
            let place = place_text(parse_error_line(&e, &wgsl));
            ShaderError::Parse { id: name(), what: format!("{place}{}", e.message()) }
        })?;
        let info = validate(&module).map_err(|e| {
            let place = place_text(validation_error_line(&e, &wgsl));
            ShaderError::Invalid { id: name(), what: format!("{place}{}", validation_message(e.as_inner())) }
        })?;
        let layout = Layout::of(&module).map_err(|source| ShaderError::Layout { id: name(), source })?;
        let tape = (lowering.lower)(&module, &info).map_err(|e| {
            let place = place_text(e.span.is_defined().then(|| e.span.location(&wgsl).line_number));
            ShaderError::Lowering { id: name(), what: format!("{place}{}", e.what) }
        })?;
        Ok(Self { id: id.clone(), wgsl, module, info, layout, source_map, tape })
    }
}
