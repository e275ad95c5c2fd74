//! Replaces calls of one WGSL function, `filtered_map` of shaders/lib/filtered_map.wesl, by the native operation [`TextureOp::Filtered`].
//!
//! In: a call. Out: the operation, if the callee is equal to the shipped fragment; otherwise `None`, and the call is lowered like any other, so that
//! an edited fragment runs as edited. tests/software/filtered.rs checks that the operation and the shipped fragment agree.
//!
//! Two bodies are equal if they lower to the same steps. Names, comments and positions in the text do not matter.

use super::builder::SsaBuilder;
use super::error::{LowerError, Result};
use super::lowerer::Lowerer;
use super::step::{SsaStep, SsaValue};
use super::value::Value;
use crate::render::software::program::Constant;
use crate::render::software::tape::TextureOp;
use naga::valid::ModuleInfo;
use naga::{Expression, Function, Handle, Module, TypeInner};
use std::sync::OnceLock;

const NATIVE_FUNCTION: &str = "filtered_map";
const SHIPPED_SOURCE: &str = include_str!("../../../../shaders/lib/filtered_map.wesl");
/// Declarations of the texture and the sampler with which the shipped fragment is lowered on its own.
const RESOURCES: &str = "@group(0) @binding(0) var shipped_map: texture_2d<f32>; @group(0) @binding(1) var shipped_sampler: sampler;";

/// A function's lowered body, for arguments that differ from lane to lane.
#[derive(PartialEq)]
struct Body {
    /// Steps that run once per draw, and steps that run per batch of lanes.
    steps: [Vec<SsaStep>; 2],
    result: Vec<SsaValue>,
}

/// Lowers a function on its own. `constants` are numbered first, so that equal steps refer to equal constants. `resources`: the function's textures
/// and samplers, in the order of its parameters.
fn body(
    module: &Module,
    info: &ModuleInfo,
    function: Handle<Function>,
    constants: &[Constant],
    resources: &[Value],
) -> Result<(Body, Vec<Constant>)> {
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
    let before = lowerer.env.clone();
    let result = lowerer.call(callee, &info[function], arguments)?;
    if lowerer.env != before {
        return Err(lowerer.unsupported("discards, or writes to a variable of the module".into()));
    }
    let SsaBuilder { constants, draw, code, .. } = lowerer.builder;
    Ok((Body { steps: [draw, code], result }, constants))
}

fn find_function(module: &Module) -> Option<Handle<Function>> {
    module.functions.iter().find(|(_, f)| f.name.as_deref() == Some(NATIVE_FUNCTION)).map(|(handle, _)| handle)
}

/// The shipped fragment's body and constants; `None` if it cannot be parsed on its own, in which case no call is replaced.
fn shipped_body() -> Option<&'static (Body, Vec<Constant>)> {
    static BODY: OnceLock<Option<(Body, Vec<Constant>)>> = OnceLock::new();
    let lower_shipped = || {
        let module = naga::front::wgsl::parse_str(&format!("{SHIPPED_SOURCE}{RESOURCES}")).ok()?;
        let info = crate::shader::module::validate(&module).ok()?;
        let resources: Vec<Value> = module.global_variables.iter().map(|(handle, _)| Value::Resource(handle)).collect();
        body(&module, &info, find_function(&module)?, &[], &resources).ok()
    };
    BODY.get_or_init(lower_shipped).as_ref()
}

impl Lowerer<'_> {
    /// The call as one native operation; `None` if the function has another name, or another body than the shipped fragment.
    pub(crate) fn native_call(&mut self, function: Handle<Function>, arguments: &[Handle<Expression>]) -> Result<Option<Vec<SsaValue>>> {
        let callee = &self.module.functions[function];
        let (Some(NATIVE_FUNCTION), &[image, sampler, uv, dx, dy, max_taps]) = (callee.name.as_deref(), arguments) else { return Ok(None) };
        if !self.is_shipped(function, [image, sampler])? {
            return Ok(None);
        }
        let texture = self.texture_use(image, Some(sampler))?;
        let mut args = Vec::new();
        for argument in [uv, dx, dy, max_taps] {
            args.extend(self.scalars_of(argument)?);
        }
        Ok(Some(self.builder.texture(TextureOp::Filtered, texture, &args, self.active_mask).to_vec()))
    }

    fn is_shipped(&mut self, function: Handle<Function>, resources: [Handle<Expression>; 2]) -> Result<bool> {
        if let Some(known) = self.matches_native.get(&function) {
            return Ok(*known);
        }
        let resources = [self.value_of(resources[0])?, self.value_of(resources[1])?];
        let is_equal = shipped_body().is_some_and(|(shipped, constants)| {
            let lowered: std::result::Result<_, LowerError> = body(self.module, self.info, function, constants, &resources);
            lowered.is_ok_and(|(body, _)| body == *shipped)
        });
        self.matches_native.insert(function, is_equal);
        Ok(is_equal)
    }
}
