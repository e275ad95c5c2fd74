//! Lowers the entry points of a naga module to [`Program`]s.
//!
//! In: a module with the result of its validation, and the name of an entry point. Out: the entry point's [`Program`], or the first construct that the
//! software renderer does not support, with its position in the source.
//!
//! First, the functions are lowered to SSA instructions:
//! - Vectors, matrices, structs and arrays become lists of scalars. Local variables have no memory: an environment maps each of their scalars to its
//!   current value. Where control flow joins, scalars that differ are merged by a `select`.
//! - Calls are inlined (`calls.rs`). Pointers are resolved to places: scalars of the environment, or bytes of the uniform block (`place.rs`).
//! - Both sides of a branch on a lane value (one that may differ between lanes) run, each after a jump that skips it if no lane needs it. Loops remain
//!   loops (`control_flow.rs`).
//! - The builder folds constants and reuses equal values (`builder.rs`).
//!
//! Then, optimisations eliminate dead code and fuse operations (`finish.rs`, `loops.rs`, `chains.rs`), and tapes are assembled from what is left (`finish.rs`).

mod builder;
mod calls;
mod capture;
mod chains;
mod control_flow;
mod discard;
mod error;
mod expr;
mod finish;
mod functions;
mod loops;
mod lowerer;
mod merge;
mod named_values;
mod native;
mod place;
mod ssa;
mod statements;
mod stored;
mod unroll;
mod value;

pub(crate) use error::LowerError;
pub(crate) use named_values::FIRST_NAMED_LOCATION;
pub use stored::lowering;

use super::program::{LaneInput, LaneOutput, Program, ProgramError, ShaderStage};
use crate::shader::{LoweringFailure, TapeFault};
use builder::SsaBuilder;
use error::Result;
use lowerer::Lowerer;
use naga::valid::ModuleInfo;
use naga::{Binding, BuiltIn, Interpolation, Span, TypeInner};
use named_values::NamedValueCapture;
use ssa::SsaValue;

/// Lowers one entry point, vertex or fragment. `info`: the result of validating `module`.
///
/// # Errors
/// The first construct that the software renderer does not support, with its position.
pub fn lower(module: &naga::Module, info: &ModuleInfo, entry: &str) -> Result<Program> {
    let fuse_chains = true;
    lower_with(module, info, entry, fuse_chains)
}

/// Like [`lower`], but fuses operations into chains only if `fuse_chains`. The program computes the same bits either way.
///
/// # Errors
/// As [`lower`].
pub fn lower_with(module: &naga::Module, info: &ModuleInfo, entry: &str, fuse_chains: bool) -> Result<Program> {
    let named_values = None;
    lower_entry_point(module, info, entry, fuse_chains, named_values).map(|(program, _)| program)
}

/// A program for the probe of a pixel: its named values are additional outputs, after its own outputs.
pub(crate) struct InspectableProgram {
    pub program: Program,
    /// Each name with the indices of its outputs, in order of first appearance.
    pub names: Vec<(String, std::ops::Range<usize>)>,
}

/// Lowers an entry point with every named value (see `capture.rs`) as an additional output.
///
/// # Errors
/// As [`lower`].
pub(crate) fn lower_for_inspection(module: &naga::Module, info: &ModuleInfo, entry: &str) -> Result<InspectableProgram> {
    let fuse_chains = true;
    let (program, named_values) = lower_entry_point(module, info, entry, fuse_chains, Some(NamedValueCapture::default()))?;
    // Never `None` here: `named_values` is the capture that was passed in, now filled.
    let captured = named_values.map(|n| n.captured).unwrap_or_default();
    let mut next_output = program.outputs.len() - captured.iter().map(|c| c.output_variables.len()).sum::<usize>();
    let names = captured.into_iter().map(|c| {
        let first = next_output;
        next_output += c.output_variables.len();
        (c.name, first..next_output)
    });
    Ok(InspectableProgram { names: names.collect(), program })
}

/// Lowers one entry point. With `named_values`, the named values become outputs after the program's own.
fn lower_entry_point(
    module: &naga::Module,
    info: &ModuleInfo,
    entry: &str,
    fuse_chains: bool,
    named_values: Option<NamedValueCapture>,
) -> Result<(Program, Option<NamedValueCapture>)> {
    let position = module.entry_points.iter().position(|e| e.name == entry);
    let index = position.ok_or_else(|| LowerError::new(format!("no entry point '{entry}'"), Span::UNDEFINED))?;
    let entry_point = &module.entry_points[index];
    let stage = stage_of(entry_point)?;
    let mut builder = SsaBuilder::new();
    let (mut interface, arguments) = EntryPointInterface::of(module, entry_point, stage, &mut builder)?;
    let active_mask = builder.fresh_lane();
    interface.input_values.push(active_mask);
    let mut lowerer = Lowerer::new(module, info, builder, active_mask)?;
    lowerer.named_values = named_values;
    let result = lowerer.entry(&entry_point.function, info.get_entry_point(index), arguments)?;
    let discarded_mask = lowerer.discarded();
    let mut builder = lowerer.builder;
    let mut outputs: Vec<SsaValue> = result.into_iter().take(interface.outputs.len()).collect();
    let named_values = lowerer.named_values;
    if let Some(named_values) = &named_values {
        named_values.initialise_with_nan(&mut builder);
        interface.outputs.extend(named_values.outputs());
        outputs.extend(named_values.output_variables());
    }
    outputs.extend(discarded_mask);
    // Each output must be a lane value of its own, so inputs, values common to all lanes, and repeated outputs are copied.
    let mut own_outputs = rustc_hash::FxHashSet::default();
    for v in &mut outputs {
        if !matches!(v, SsaValue::Lane(_)) || interface.input_values.contains(v) || !own_outputs.insert(*v) {
            let dst = builder.fresh_lane();
            builder.lane_instrs.push(ssa::SsaInstr::Op { dst, op: super::tape::Op::Copy, args: smallvec::smallvec![*v] });
            *v = dst;
        }
    }
    let constants = builder.constants.clone();
    let mut finished = finish::finish(builder, &interface.input_values, &outputs, fuse_chains)?;
    // The last entry is for the mask of active lanes, which is no input of the entry point.
    finished.inputs_read.truncate(interface.inputs.len());
    let mut output_operands = finished.outputs;
    let discarded = if discarded_mask.is_some() { output_operands.pop() } else { None };
    let uses_derivatives =
        finished.lane_tape.iter().any(|i| matches!(i, super::tape::Instr::Lane { op: super::tape::Op::Dpdx | super::tape::Op::Dpdy, .. }));
    let program = Program {
        name: entry.to_owned(),
        stage,
        inputs: interface.inputs,
        inputs_read: finished.inputs_read,
        outputs: interface.outputs,
        output_operands,
        textures: lowerer.textures,
        uses_discard: discarded.is_some(),
        discarded,
        uses_derivatives,
        uniform_size: lowerer.uniform_size,
        constants,
        draw_tape: finished.draw_tape,
        lane_tape: finished.lane_tape,
        register_count: finished.register_count,
        slot_count: finished.slot_count,
    };
    Ok((program, named_values))
}

/// Lowers every entry point of a module to bytes that the shader library stores; [`programs_from_bytes`] reads them.
///
/// # Errors
/// As [`lower`].
pub fn lower_to_bytes(module: &naga::Module, info: &ModuleInfo) -> std::result::Result<Vec<u8>, LoweringFailure> {
    let programs: std::result::Result<Vec<Program>, LowerError> =
        module.entry_points.iter().map(|e| lower(module, info, &e.name)).collect();
    postcard::to_stdvec(&programs?).map_err(|e| LoweringFailure { what: e.to_string(), span: Span::UNDEFINED })
}

/// The programs of a module, verified.
///
/// # Errors
/// Bytes that are not serialized programs, or programs with an index out of range.
pub fn programs_from_bytes(bytes: &[u8]) -> std::result::Result<Vec<Program>, ProgramError> {
    let programs: Vec<Program> = postcard::from_bytes(bytes)?;
    programs.iter().try_for_each(Program::check)?;
    Ok(programs)
}

/// Verifies that `bytes` are programs of this module's entry points, with the same names, stages, inputs and outputs, and use only textures that the
/// module binds.
///
/// # Errors
/// The first mismatch, in one line.
pub fn check_bytes(module: &naga::Module, bytes: &[u8]) -> std::result::Result<(), TapeFault> {
    let programs = programs_from_bytes(bytes)?;
    if programs.len() != module.entry_points.len() {
        return Err(format!("{} programs for {} entry points", programs.len(), module.entry_points.len()).into());
    }
    // Programs have bindings of group 0 only.
    let is_bound =
        |binding: u32| module.global_variables.iter().any(|(_, v)| v.binding.is_some_and(|b| b.group == 0 && b.binding == binding));
    for (program, point) in programs.iter().zip(&module.entry_points) {
        let stage = stage_of(point)?;
        let (interface, _) = EntryPointInterface::of(module, point, stage, &mut SsaBuilder::new())?;
        let textures_are_bound = program.textures.iter().all(|t| is_bound(t.texture_binding) && t.sampler_binding.is_none_or(is_bound));
        let has_same_interface = (&program.name, program.stage) == (&point.name, stage)
            && program.inputs == interface.inputs
            && program.outputs == interface.outputs;
        if !(textures_are_bound && has_same_interface) {
            return Err(format!(
                "program '{}' is not that of the entry point '{}'",
                program.name.escape_debug(),
                point.name.escape_debug()
            )
            .into());
        }
    }
    Ok(())
}

fn stage_of(point: &naga::EntryPoint) -> Result<ShaderStage> {
    match point.stage {
        naga::ShaderStage::Vertex => Ok(ShaderStage::Vertex),
        naga::ShaderStage::Fragment => Ok(ShaderStage::Fragment),
        other => Err(LowerError::new(format!("entry point '{}': stage {other:?} is not supported", point.name), Span::UNDEFINED)),
    }
}

/// The inputs and outputs of an entry point, one for each scalar.
struct EntryPointInterface {
    inputs: Vec<LaneInput>,
    /// The value of each input, in order. `lower_entry_point` appends the mask of active lanes.
    input_values: Vec<SsaValue>,
    outputs: Vec<LaneOutput>,
}

/// Number of components of a scalar or vector.
fn component_count(inner: &TypeInner) -> u32 {
    match *inner {
        TypeInner::Vector { size, .. } => size as u32,
        _ => 1,
    }
}

/// Whether a varying, an output of the vertex stage and input of the fragment stage, is flat (not interpolated). Integers always are.
fn is_flat(interpolation: Option<Interpolation>, inner: &TypeInner) -> Result<bool> {
    match interpolation {
        Some(Interpolation::Flat) => Ok(true),
        None | Some(Interpolation::Perspective) => Ok(!matches!(inner.scalar_kind(), Some(naga::ScalarKind::Float))),
        Some(other) => Err(LowerError::new(format!("interpolation {other:?} is not supported"), Span::UNDEFINED)),
    }
}

impl EntryPointInterface {
    /// The inputs and outputs of an entry point, and the scalars of each argument. `builder` creates the value of each input.
    fn of(
        module: &naga::Module,
        point: &naga::EntryPoint,
        stage: ShaderStage,
        builder: &mut SsaBuilder,
    ) -> Result<(Self, Vec<Vec<SsaValue>>)> {
        let mut interface = Self { inputs: Vec::new(), input_values: Vec::new(), outputs: Vec::new() };
        let mut arguments = Vec::new();
        for arg in &point.function.arguments {
            arguments.push(interface.add_input(module, stage, builder, arg.ty, arg.binding.as_ref(), &arg.name)?);
        }
        if let Some(r) = &point.function.result {
            interface.add_output(module, stage, r.ty, r.binding.as_ref())?;
        }
        Ok((interface, arguments))
    }

    /// Adds an argument of type `ty`, or a member of an argument; for a struct, all its members. Returns the new inputs' values.
    fn add_input(
        &mut self,
        module: &naga::Module,
        stage: ShaderStage,
        builder: &mut SsaBuilder,
        ty: naga::Handle<naga::Type>,
        binding: Option<&Binding>,
        name: &Option<String>,
    ) -> Result<Vec<SsaValue>> {
        let inner = &module.types[ty].inner;
        let span = module.types.get_span(ty);
        if let (TypeInner::Struct { members, .. }, None) = (inner, binding) {
            let mut all = Vec::new();
            for m in members {
                all.extend(self.add_input(module, stage, builder, m.ty, m.binding.as_ref(), &m.name)?);
            }
            return Ok(all);
        }
        let unsupported = |what: &str| LowerError::new(format!("input '{}': {what}", name.as_deref().unwrap_or("?")), span);
        let mut all = Vec::new();
        for component in 0..component_count(inner) {
            let input = match binding {
                Some(Binding::Location { location, interpolation, .. }) => LaneInput::Location {
                    index: *location,
                    component,
                    flat: stage == ShaderStage::Fragment && is_flat(*interpolation, inner)?,
                },
                Some(Binding::BuiltIn(BuiltIn::Position { .. })) => LaneInput::FragCoord { component },
                Some(Binding::BuiltIn(BuiltIn::FrontFacing)) => LaneInput::FrontFacing,
                Some(Binding::BuiltIn(BuiltIn::VertexIndex)) => LaneInput::VertexIndex,
                Some(Binding::BuiltIn(BuiltIn::InstanceIndex)) => LaneInput::InstanceIndex,
                Some(Binding::BuiltIn(BuiltIn::SampleIndex)) => LaneInput::SampleIndex,
                Some(Binding::BuiltIn(other)) => return Err(unsupported(&format!("builtin {other:?} is not supported"))),
                None => return Err(unsupported("has no binding")),
            };
            let v = builder.fresh_lane();
            self.inputs.push(input);
            self.input_values.push(v);
            all.push(v);
        }
        Ok(all)
    }

    /// Adds the result, of type `ty`, or a member of it; for a struct, all its members.
    fn add_output(
        &mut self,
        module: &naga::Module,
        stage: ShaderStage,
        ty: naga::Handle<naga::Type>,
        binding: Option<&Binding>,
    ) -> Result<()> {
        let inner = &module.types[ty].inner;
        if let (TypeInner::Struct { members, .. }, None) = (inner, binding) {
            return members.iter().try_for_each(|m| self.add_output(module, stage, m.ty, m.binding.as_ref()));
        }
        for component in 0..component_count(inner) {
            self.outputs.push(match binding {
                Some(Binding::Location { location, interpolation, .. }) => LaneOutput::Location {
                    index: *location,
                    component,
                    flat: stage == ShaderStage::Vertex && is_flat(*interpolation, inner)?,
                },
                Some(Binding::BuiltIn(BuiltIn::Position { .. })) => LaneOutput::Position { component },
                Some(Binding::BuiltIn(BuiltIn::FragDepth)) => LaneOutput::FragDepth,
                other => return Err(LowerError::new(format!("output {other:?} is not supported"), module.types.get_span(ty))),
            });
        }
        Ok(())
    }
}
