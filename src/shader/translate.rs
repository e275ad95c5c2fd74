//! Translates a module to other shading languages with naga's backends.
//!
//! In: a built module. Out: its text in another language, or the message of naga's writer. Not here: the record of the translations' digests
//! (`record`).

use super::ShaderModule;
use naga::back;
use rspirv::binary::Disassemble;
use std::fmt;

/// A shading language or intermediate form in which a module can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Language {
    /// WGSL: the text as emitted.
    Wgsl,
    /// HLSL, for Direct3D.
    Hlsl,
    /// GLSL 4.30 (OpenGL): vertex stage, then fragment stage.
    Glsl,
    /// MSL, for Metal.
    Msl,
    /// SPIR-V 1.0 (naga's default), one hexadecimal word per line.
    Spirv,
    /// Disassembled SPIR-V, one instruction per line; called `spirv-text`.
    Assembly,
    /// naga's intermediate representation, for debugging.
    Ir,
}

impl Language {
    /// Every language, WGSL first.
    pub const ALL: [Self; 7] = [Self::Wgsl, Self::Hlsl, Self::Glsl, Self::Msl, Self::Spirv, Self::Assembly, Self::Ir];

    /// Whether the record of digests (`shader::record`) has one for a module's text in this language. The other languages need none: the module's own digest is
    /// that of its WGSL, naga's IR follows from WGSL, and disassembled SPIR-V follows from SPIR-V.
    pub fn is_recorded(self) -> bool {
        !matches!(self, Self::Wgsl | Self::Assembly | Self::Ir)
    }
}

impl fmt::Display for Language {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Wgsl => "wgsl",
            Self::Hlsl => "hlsl",
            Self::Glsl => "glsl",
            Self::Msl => "msl",
            Self::Spirv => "spirv",
            Self::Assembly => "spirv-text",
            Self::Ir => "ir",
        })
    }
}

/// naga could not write the module in this language.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("module {module} cannot be written in {language}: {what}")]
pub struct TranslateError {
    /// Which module.
    pub module: String,
    /// The language into which it was translated.
    pub language: Language,
    /// Message of naga's writer.
    pub what: String,
}

/// The module as the words of a SPIR-V file. `language`: the one that an error names.
fn spirv_words(shader: &ShaderModule, language: Language) -> Result<Vec<u32>, TranslateError> {
    // Without naga's default flags, which flip y, clamp depths and add names.
    let options = back::spv::Options { flags: back::spv::WriterFlags::empty(), ..Default::default() };
    let pipeline = None;
    back::spv::write_vec(&shader.module, &shader.info, &options, pipeline).map_err(|e| TranslateError {
        module: shader.id.to_string(),
        language,
        what: e.to_string(),
    })
}

/// The module as a SPIR-V file: its words, little-endian. [`translate`] has them as text.
pub fn spirv_file(shader: &ShaderModule) -> Result<Vec<u8>, TranslateError> {
    Ok(spirv_words(shader, Language::Spirv)?.into_iter().flat_map(u32::to_le_bytes).collect())
}

/// Translates the module to a language.
pub fn translate(shader: &ShaderModule, language: Language) -> Result<String, TranslateError> {
    let failed = |what: String| TranslateError { module: shader.id.to_string(), language, what };
    match language {
        Language::Wgsl => Ok(shader.wgsl.clone()),
        Language::Ir => Ok(format!("{:#?}\n", shader.module)),
        Language::Hlsl => {
            let mut text = String::new();
            let (options, pipeline) = (back::hlsl::Options::default(), back::hlsl::PipelineOptions::default());
            let fragment_entry_point = None;
            back::hlsl::Writer::new(&mut text, &options, &pipeline)
                .write(&shader.module, &shader.info, fragment_entry_point)
                .map_err(|e| failed(e.to_string()))?;
            Ok(text)
        }
        Language::Msl => {
            // No bindings are assigned: naga marks them in the text. MSL 2.0.
            let options = back::msl::Options { lang_version: (2, 0), fake_missing_bindings: true, ..Default::default() };
            let (text, _) = back::msl::write_string(&shader.module, &shader.info, &options, &back::msl::PipelineOptions::default())
                .map_err(|e| failed(e.to_string()))?;
            Ok(text)
        }
        Language::Spirv | Language::Assembly => {
            let words = spirv_words(shader, language)?;
            Ok(match language {
                Language::Assembly => rspirv::dr::load_words(&words).map_err(|e| failed(e.to_string()))?.disassemble(),
                _ => words.iter().map(|w| format!("{w:08x}\n")).collect(),
            })
        }
        Language::Glsl => {
            let mut text = String::new();
            for entry in &shader.module.entry_points {
                let options = back::glsl::Options { version: back::glsl::Version::Desktop(430), ..Default::default() };
                let pipeline = back::glsl::PipelineOptions { shader_stage: entry.stage, entry_point: entry.name.clone(), multiview: None };
                let policies = naga::proc::BoundsCheckPolicies::default();
                text.push_str(&format!("// {}\n", entry.name));
                back::glsl::Writer::new(&mut text, &shader.module, &shader.info, &options, &pipeline, policies)
                    .and_then(|mut writer| writer.write())
                    .map_err(|e| failed(e.to_string()))?;
            }
            Ok(text)
        }
    }
}
