//! Lowers a validated naga module to one [`Program`] per entry point.
//!
//! In: a module that naga has validated, and the name of an entry point. Out: a tape for all lanes of a batch, or the first construct that the
//! software renderer does not support, with its position in the source.
//!
//! Vectors, matrices, structs and arrays become lists of scalars. Local variables have no memory: an environment maps each of
//! their scalars to its current value (SSA form), and where control flow joins, scalars that differ are merged by a `select`. Calls are inlined
//! (`calls.rs`), pointers are resolved to places (`place.rs`). Both sides of a branch on a lane value run, each after a jump that skips it if
//! no lane needs it; loops remain loops (`control_flow.rs`). The builder folds constants and applies value numbering (`builder.rs`); passes over the
//! steps then eliminate dead code, fuse operations and assign slots (`finish.rs`, `loops.rs`, `chains.rs`).

mod builder;
mod calls;
mod chains;
mod control_flow;
mod discard;
mod error;
mod expr;
mod finish;
mod functions;
mod loops;
mod lowerer;
mod named;
mod native;
mod place;
mod statements;
mod step;
mod stored;
mod value;
mod watch;

pub(crate) use error::LowerError;
pub use stored::lowering;

use super::program::{LaneInput, LaneOutput, Program, ProgramError, Stage};
use crate::shader::LoweringFailure;
use builder::Builder;
use error::Result;
use lowerer::Lowerer;
use naga::valid::ModuleInfo;
use naga::{Binding, BuiltIn, Interpolation, Span, TypeInner};
use step::Val;
use watch::NamedValueCapture;

/// Lowers one entry point, vertex or fragment. `info`: the result of validating `module`.
///
/// # Errors
/// The first construct that the software renderer does not support, with its position.
pub fn lower(module: &naga::Module, info: &ModuleInfo, entry: &str) -> Result<Program> {
    lower_with(module, info, entry, true)
}

/// Like [`lower`], but fuses operations into chains only if `chains`. The results have the same bits either way.
///
/// # Errors
/// As [`lower`].
pub fn lower_with(module: &naga::Module, info: &ModuleInfo, entry: &str, chains: bool) -> Result<Program> {
    lowered(module, info, entry, chains, None).map(|(program, _)| program)
}

/// A program with its named values as additional outputs, after its own outputs.
pub(crate) struct InspectableProgram {
    pub program: Program,
    /// Each name with the indices of its outputs, in order of first appearance.
    pub names: Vec<(String, std::ops::Range<usize>)>,
}

/// Lowers an entry point with every named value as an additional output.
///
/// # Errors
/// As [`lower`].
pub(crate) fn lower_for_inspection(module: &naga::Module, info: &ModuleInfo, entry: &str) -> Result<InspectableProgram> {
    let (program, watch) = lowered(module, info, entry, true, Some(NamedValueCapture::default()))?;
    let captured = watch.map(|w| w.captured).unwrap_or_default();
    let mut at = program.outputs.len() - captured.iter().map(|c| c.lanes.len()).sum::<usize>();
    let names = captured.into_iter().map(|c| {
        at += c.lanes.len();
        (c.name, at - c.lanes.len()..at)
    });
    Ok(InspectableProgram { names: names.collect(), program })
}

/// Lowers one entry point. With `watch`, the named values become outputs after the program's own.
fn lowered(
    module: &naga::Module,
    info: &ModuleInfo,
    entry: &str,
    chains: bool,
    watch: Option<NamedValueCapture>,
) -> Result<(Program, Option<NamedValueCapture>)> {
    let found = module.entry_points.iter().position(|e| e.name == entry);
    let index = found.ok_or_else(|| LowerError::new(format!("no entry point '{entry}'"), Span::UNDEFINED))?;
    let point = &module.entry_points[index];
    let stage = stage_of(point)?;
    let mut builder = Builder::new();
    let (mut interface, arguments) = Interface::of(module, point, stage, &mut builder)?;
    let active = builder.fresh_lane();
    interface.values.push(active);
    let mut lowerer = Lowerer::new(module, info, builder, active)?;
    lowerer.watch = watch;
    let result = lowerer.entry(&point.function, info.get_entry_point(index), arguments)?;
    let discarded = lowerer.discarded();
    let mut b = lowerer.builder;
    let mut outputs: Vec<Val> = result.into_iter().take(interface.outputs.len()).collect();
    let watch = lowerer.watch;
    if let Some(watch) = &watch {
        watch.initialise(&mut b);
        interface.outputs.extend(watch.outputs());
        outputs.extend(watch.values());
    }
    if let Some(k) = discarded {
        outputs.push(k);
    }
    // Each output must be a separate lane value, so inputs, values common to all lanes, and repeated outputs are copied.
    let mut used = rustc_hash::FxHashSet::default();
    for v in &mut outputs {
        if !matches!(v, Val::Lane(_)) || interface.values.contains(v) || !used.insert(*v) {
            let dst = b.fresh_lane();
            b.code.push(step::Step::Op { dst, op: super::tape::Op::Copy, args: smallvec::smallvec![*v] });
            *v = dst;
        }
    }
    let constants = b.constants.clone();
    let finished = finish::finish(b, &interface.values, &outputs, chains)?;
    let mut operands = finished.outputs;
    let discarded = if discarded.is_some() { operands.pop() } else { None };
    let uses_derivatives =
        finished.lane_tape.iter().any(|i| matches!(i, super::tape::Instr::Lane { op: super::tape::Op::Dpdx | super::tape::Op::Dpdy, .. }));
    let program = Program {
        name: entry.to_owned(),
        stage,
        inputs: interface.inputs,
        outputs: interface.outputs,
        output_operands: operands,
        textures: lowerer.textures,
        uses_discard: discarded.is_some(),
        discarded,
        uses_derivatives,
        uniform_size: lowerer.uniform_size,
        constants,
        draw_tape: finished.draw_tape,
        lane_tape: finished.lane_tape,
        registers: finished.registers,
        slots: finished.slots,
    };
    Ok((program, watch))
}

/// Lowers every entry point of a module to bytes for the library ([`programs_from_bytes`] reads them).
///
/// # Errors
/// As [`lower`].
pub fn lower_to_bytes(module: &naga::Module, info: &ModuleInfo) -> std::result::Result<Vec<u8>, LoweringFailure> {
    let programs: std::result::Result<Vec<Program>, LowerError> =
        module.entry_points.iter().map(|e| lower(module, info, &e.name)).collect();
    Ok(postcard::to_stdvec(&programs?)?)
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
pub fn check_bytes(module: &naga::Module, bytes: &[u8]) -> std::result::Result<(), LoweringFailure> {
    let programs = programs_from_bytes(bytes)?;
    if programs.len() != module.entry_points.len() {
        return Err(format!("{} programs for {} entry points", programs.len(), module.entry_points.len()).into());
    }
    let is_bound =
        |number: u32| module.global_variables.iter().any(|(_, v)| v.binding.is_some_and(|b| b.group == 0 && b.binding == number));
    for (program, point) in programs.iter().zip(&module.entry_points) {
        let stage = stage_of(point)?;
        let (interface, _) = Interface::of(module, point, stage, &mut Builder::new())?;
        let bound = program.textures.iter().all(|t| is_bound(t.texture_binding) && t.sampler_binding.is_none_or(is_bound));
        let same = (&program.name, program.stage) == (&point.name, stage)
            && program.inputs == interface.inputs
            && program.outputs == interface.outputs;
        if !(bound && same) {
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

fn stage_of(point: &naga::EntryPoint) -> Result<Stage> {
    match point.stage {
        naga::ShaderStage::Vertex => Ok(Stage::Vertex),
        naga::ShaderStage::Fragment => Ok(Stage::Fragment),
        other => Err(LowerError::new(format!("entry point '{}': stage {other:?} is not supported", point.name), Span::UNDEFINED)),
    }
}

struct Interface {
    inputs: Vec<LaneInput>,
    values: Vec<Val>,
    outputs: Vec<LaneOutput>,
}

fn scalars(inner: &TypeInner) -> u32 {
    match *inner {
        TypeInner::Vector { size, .. } => size as u32,
        _ => 1,
    }
}

fn is_flat(interpolation: Option<Interpolation>, inner: &TypeInner) -> Result<bool> {
    match interpolation {
        Some(Interpolation::Flat) => Ok(true),
        None | Some(Interpolation::Perspective) => Ok(!matches!(inner.scalar_kind(), Some(naga::ScalarKind::Float))),
        Some(other) => Err(LowerError::new(format!("interpolation {other:?} is not supported"), Span::UNDEFINED)),
    }
}

impl Interface {
    /// The inputs and outputs of an entry point, and the values of each argument.
    fn of(module: &naga::Module, point: &naga::EntryPoint, stage: Stage, builder: &mut Builder) -> Result<(Self, Vec<Vec<Val>>)> {
        let mut interface = Self { inputs: Vec::new(), values: Vec::new(), outputs: Vec::new() };
        let mut arguments = Vec::new();
        for arg in &point.function.arguments {
            arguments.push(interface.add_input(module, stage, builder, arg.ty, arg.binding.as_ref(), &arg.name)?);
        }
        if let Some(r) = &point.function.result {
            interface.add_output(module, stage, r.ty, r.binding.as_ref())?;
        }
        Ok((interface, arguments))
    }

    fn add_input(
        &mut self,
        module: &naga::Module,
        stage: Stage,
        b: &mut Builder,
        ty: naga::Handle<naga::Type>,
        binding: Option<&Binding>,
        name: &Option<String>,
    ) -> Result<Vec<Val>> {
        let inner = &module.types[ty].inner;
        let span = module.types.get_span(ty);
        if let (TypeInner::Struct { members, .. }, None) = (inner, binding) {
            let mut all = Vec::new();
            for m in members {
                all.extend(self.add_input(module, stage, b, m.ty, m.binding.as_ref(), &m.name)?);
            }
            return Ok(all);
        }
        let unsupported = |what: &str| LowerError::new(format!("input '{}': {what}", name.as_deref().unwrap_or("?")), span);
        let mut all = Vec::new();
        for component in 0..scalars(inner) {
            let input = match binding {
                Some(Binding::Location { location, interpolation, .. }) => {
                    LaneInput::Location { index: *location, component, flat: stage == Stage::Fragment && is_flat(*interpolation, inner)? }
                }
                Some(Binding::BuiltIn(BuiltIn::Position { .. })) => LaneInput::FragCoord { component },
                Some(Binding::BuiltIn(BuiltIn::FrontFacing)) => LaneInput::FrontFacing,
                Some(Binding::BuiltIn(BuiltIn::VertexIndex)) => LaneInput::VertexIndex,
                Some(Binding::BuiltIn(BuiltIn::InstanceIndex)) => LaneInput::InstanceIndex,
                Some(Binding::BuiltIn(BuiltIn::SampleIndex)) => LaneInput::SampleIndex,
                Some(Binding::BuiltIn(other)) => return Err(unsupported(&format!("builtin {other:?} is not supported"))),
                None => return Err(unsupported("has no binding")),
            };
            let v = b.fresh_lane();
            self.inputs.push(input);
            self.values.push(v);
            all.push(v);
        }
        Ok(all)
    }

    fn add_output(&mut self, module: &naga::Module, stage: Stage, ty: naga::Handle<naga::Type>, binding: Option<&Binding>) -> Result<()> {
        let inner = &module.types[ty].inner;
        if let (TypeInner::Struct { members, .. }, None) = (inner, binding) {
            return members.iter().try_for_each(|m| self.add_output(module, stage, m.ty, m.binding.as_ref()));
        }
        for component in 0..scalars(inner) {
            self.outputs.push(match binding {
                Some(Binding::Location { location, interpolation, .. }) => {
                    LaneOutput::Location { index: *location, component, flat: stage == Stage::Vertex && is_flat(*interpolation, inner)? }
                }
                Some(Binding::BuiltIn(BuiltIn::Position { .. })) => LaneOutput::Position { component },
                Some(Binding::BuiltIn(BuiltIn::FragDepth)) => LaneOutput::FragDepth,
                other => return Err(LowerError::new(format!("output {other:?} is not supported"), module.types.get_span(ty))),
            });
        }
        Ok(())
    }
}
