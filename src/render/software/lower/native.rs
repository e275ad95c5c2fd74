//! Replaces calls of two WGSL functions by native operations: `filtered_map` of shaders/lib/filtered_map.wesl by [`TextureOp::Filtered`], and
//! `texels_between` of shaders/lib/texels_between.wesl by [`TextureOp::Bilinear`].
//!
//! In: a call. Out: the operation, if the callee is equal to the shipped function; otherwise `None`, and the call is lowered like any other, so that a fragment
//! (WESL source file) that the user has edited runs as edited. tests/software/filtered_map.rs and texels_between.rs check that the operations and the shipped
//! fragments agree. If the shipped fragment itself was edited since its native operation was written, which [`NativeFunction::reimplemented_sha256`] shows, no
//! call of it is replaced: the renderer interprets it, slowly but correctly.
//!
//! Two bodies are equal if they lower to the same SSA instructions. Names, comments and positions in the text do not matter. docs/map-filter.md says what to
//! edit for another filter of maps.

use super::builder::SsaBuilder;
use super::error::{LowerError, Result};
use super::lowerer::Lowerer;
use super::ssa::{SsaInstr, SsaValue};
use super::value::Value;
use crate::render::software::program::Constant;
use crate::render::software::tape::TextureOp;
use crate::shader::generator;
use naga::valid::ModuleInfo;
use naga::{Expression, Function, Handle, Module, TypeInner};
use sha2::{Digest, Sha256};
use std::sync::OnceLock;

/// A function that reads a texture and has a native operation.
struct NativeFunction {
    name: &'static str,
    /// The WESL source of the shipped fragment.
    shipped_source: &'static str,
    /// The [`source_digest`] of the source that the native operation reimplements. Record the new digest after adapting the operation to an edited source.
    reimplemented_sha256: &'static str,
    op: TextureOp,
    /// Whether the function's second parameter is a sampler; the first is the texture.
    has_sampler: bool,
}

const NATIVE_FUNCTIONS: [NativeFunction; 2] = [
    NativeFunction {
        name: "filtered_map",
        shipped_source: include_str!("../../../../shaders/lib/filtered_map.wesl"),
        reimplemented_sha256: "06e9d78b3979c5764f7340f0cc3f542663642ee3accd054d305cb41cc4d5b381",
        op: TextureOp::Filtered,
        has_sampler: true,
    },
    NativeFunction {
        name: "texels_between",
        shipped_source: include_str!("../../../../shaders/lib/texels_between.wesl"),
        reimplemented_sha256: "390df102fe0f38f9a9d5c18ee287c07b33d3a97f62a164c98ae443f1fb62554a",
        op: TextureOp::Bilinear,
        has_sampler: false,
    },
];

/// WGSL declarations of a texture and a sampler, so that a shipped fragment can be lowered on its own.
const RESOURCES: &str = "@group(0) @binding(0) var shipped_map: texture_2d<f32>; @group(0) @binding(1) var shipped_sampler: sampler;";

/// SHA-256 of a source without its comments and with single spaces, so that neither a comment nor the layout changes it. The digest covers the text, not the
/// lowered body, because the body changes with every improvement of the lowering.
fn source_digest(source: &str) -> String {
    let code = source.lines().map(|line| line.split("//").next().unwrap_or(""));
    let words: Vec<&str> = code.flat_map(str::split_whitespace).collect();
    generator::hex(&Sha256::digest(words.join(" ").as_bytes()))
}

/// A function's body, lowered for arguments that differ from lane to lane.
#[derive(PartialEq)]
struct FunctionBody {
    /// SSA instructions that run once per draw, and those that run per batch of lanes.
    instrs: [Vec<SsaInstr>; 2],
    result: Vec<SsaValue>,
}

/// Lowers a function on its own; also returns the constants to which its instructions refer. `constants`: the constants of the body to compare with, which get
/// the first numbers, so that equal bodies number their constants alike. `resources`: the function's textures and samplers, in the order of its parameters.
fn lower_body(
    module: &Module,
    info: &ModuleInfo,
    function: Handle<Function>,
    constants: &[Constant],
    resources: &[Value],
) -> Result<(FunctionBody, Vec<Constant>)> {
    let mut builder = SsaBuilder::new();
    for c in constants {
        builder.constant(*c);
    }
    let active = builder.fresh_lane();
    let mut lowerer = Lowerer::new(module, info, builder, active)?;
    let callee = &module.functions[function];
    let mut resources = resources.iter();
    let mut arguments = Vec::new();
    for argument in &callee.arguments {
        arguments.push(match &module.types[argument.ty].inner {
            TypeInner::Image { .. } | TypeInner::Sampler { .. } => {
                resources.next().cloned().ok_or_else(|| lowerer.unsupported("a texture or a sampler is missing".into()))?
            }
            inner => {
                let scalars = lowerer.scalar_count(inner)?;
                Value::Scalars((0..scalars).map(|_| lowerer.builder.fresh_lane()).collect())
            }
        });
    }
    let env_before = lowerer.env.clone();
    let result = lowerer.call(callee, &info[function], arguments)?;
    if lowerer.env != env_before {
        return Err(lowerer.unsupported("discards, or writes to a variable of the module".into()));
    }
    let SsaBuilder { constants, draw_instrs, lane_instrs, .. } = lowerer.builder;
    Ok((FunctionBody { instrs: [draw_instrs, lane_instrs], result }, constants))
}

fn find_function(module: &Module, name: &str) -> Option<Handle<Function>> {
    module.functions.iter().find(|(_, f)| f.name.as_deref() == Some(name)).map(|(handle, _)| handle)
}

impl NativeFunction {
    /// The shipped function's body and constants; `None` if the native operation reimplements another version of the fragment, or if the fragment cannot be
    /// lowered on its own. In both cases no call is replaced.
    fn lower_shipped(&self) -> Option<ShippedFunctionBody> {
        if source_digest(self.shipped_source) != self.reimplemented_sha256 {
            return None;
        }
        let module = naga::front::wgsl::parse_str(&format!("{}{RESOURCES}", self.shipped_source)).ok()?;
        let info = crate::shader::module::validate(&module).ok()?;
        let resources: Vec<Value> = module.global_variables.iter().map(|(handle, _)| Value::Resource(handle)).collect();
        lower_body(&module, &info, find_function(&module, self.name)?, &[], &resources).ok()
    }
}

/// A body with the constants that its instructions refer to.
type ShippedFunctionBody = (FunctionBody, Vec<Constant>);

/// The shipped body of each native function, in the order of [`NATIVE_FUNCTIONS`]; lowered at the first call.
static SHIPPED: [OnceLock<Option<ShippedFunctionBody>>; NATIVE_FUNCTIONS.len()] = [const { OnceLock::new() }; NATIVE_FUNCTIONS.len()];

impl Lowerer<'_> {
    /// The call as one native operation; `None` if the function has another name, or another body than the shipped fragment.
    pub(crate) fn native_call(&mut self, function: Handle<Function>, arguments: &[Handle<Expression>]) -> Result<Option<Vec<SsaValue>>> {
        let name = self.module.functions[function].name.as_deref();
        let Some(index) = NATIVE_FUNCTIONS.iter().position(|native| Some(native.name) == name) else { return Ok(None) };
        let NativeFunction { op, has_sampler, .. } = NATIVE_FUNCTIONS[index];
        let resource_count = 1 + usize::from(has_sampler);
        if arguments.len() <= resource_count || !self.equals_shipped(index, function, &arguments[..resource_count])? {
            return Ok(None);
        }
        let texture = self.texture_index(arguments[0], has_sampler.then(|| arguments[1]))?;
        let mut args = Vec::new();
        for argument in &arguments[resource_count..] {
            args.extend(self.scalars_of(*argument)?);
        }
        Ok(Some(self.builder.texture(op, texture, &args, self.active_mask).to_vec()))
    }

    /// Whether a function has the shipped body of the native function `index`. `resources`: the texture and, if there is one, the sampler of a call.
    fn equals_shipped(&mut self, index: usize, function: Handle<Function>, resources: &[Handle<Expression>]) -> Result<bool> {
        if let Some(known) = self.known_equal_to_shipped.get(&function) {
            return Ok(*known);
        }
        let resources = resources.iter().map(|r| self.value_of(*r)).collect::<Result<Vec<_>>>()?;
        let shipped = SHIPPED[index].get_or_init(|| NATIVE_FUNCTIONS[index].lower_shipped());
        let is_equal = shipped.as_ref().is_some_and(|(shipped, constants)| {
            let lowered: std::result::Result<_, LowerError> = lower_body(self.module, self.info, function, constants, &resources);
            lowered.is_ok_and(|(body, _)| body == *shipped)
        });
        self.known_equal_to_shipped.insert(function, is_equal);
        Ok(is_equal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rust_repeats_the_shipped_functions() {
        for native in NATIVE_FUNCTIONS {
            let (name, digest) = (native.name, source_digest(native.shipped_source));
            assert!(
                digest == native.reimplemented_sha256,
                "Rust reimplements another version of {name}, so that the software renderer interprets it, correctly but slowly. Adapt \
                 src/render/software/sample/, record the digest {digest} in NATIVE_FUNCTIONS, and run software::{name}, which compares both \
                 (docs/map-filter.md)"
            );
            assert!(native.lower_shipped().is_some(), "{name} must lower on its own");
        }
    }

    #[test]
    fn an_edited_shipped_function_is_not_replaced_until_its_digest_is_recorded() {
        for native in NATIVE_FUNCTIONS {
            let text: &'static str = native.shipped_source.replace("floor(", "ceil(").leak();
            assert_ne!(text, native.shipped_source, "{} has nothing to edit", native.name);
            let edited = NativeFunction { shipped_source: text, ..native };
            assert!(edited.lower_shipped().is_none(), "{}", native.name);
            let recorded = NativeFunction { reimplemented_sha256: source_digest(text).leak(), ..edited };
            assert!(recorded.lower_shipped().is_some(), "{}: only the digest may be the reason", native.name);
        }
    }

    #[test]
    fn the_digest_depends_on_code_alone() {
        let digest = source_digest("let a = 1.0; // one\n// and\nlet b = 2.0;\n");
        assert_eq!(digest, source_digest("let a =  1.0;\r\n    let b = 2.0;"));
        for edited in ["let a = 1.5; let b = 2.0;", "let a = 1.0; let c = 2.0;", "let a = 1.0;"] {
            assert_ne!(digest, source_digest(edited), "{edited}");
        }
    }
}
