//! The state of the lowering of one entry point: values of variables, the functions and loops being lowered, the textures that the program reads.
//!
//! Variables have no memory: `env` maps each scalar of every variable in scope to its current SSA value. The other files lower statements and
//! expressions, and change `env`.

use super::builder::SsaBuilder;
use super::error::{LowerError, Result};
use super::ssa::{JumpLabel, SsaValue};
use super::value::{Place, Value};
use crate::render::software::program::TextureUse;
use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{AddressSpace, Expression, Function, Handle, Span};
use rustc_hash::FxHashMap as HashMap;

/// A function that is being inlined.
pub(crate) struct CallFrame<'m> {
    pub function: &'m Function,
    pub info: &'m FunctionInfo,
    pub arguments: Vec<Value>,
    /// Values of emitted expressions and of call results.
    pub values: HashMap<Handle<Expression>, Value>,
    /// Index in `env` of the first scalar of each local variable.
    pub locals: HashMap<Handle<naga::LocalVariable>, usize>,
    /// Index in `env` of the flag, per lane, that `return` sets.
    pub return_flag: usize,
    /// Index in `env` of the first scalar of the function's result.
    pub result_start: usize,
    /// The flags of the loops and switches of this function whose bodies are being lowered, innermost last.
    pub loop_flags: Vec<LoopFlags>,
}

/// Indices in `env` of the flags, per lane, that `break` and `continue` set. In a switch, `continue_flag` is that of the loop around it.
#[derive(Clone, Copy, Default)]
pub(crate) struct LoopFlags {
    pub break_flag: usize,
    pub continue_flag: usize,
}

/// How a scalar of the environment changes in a loop.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct ScalarChange {
    /// Whether the scalar differs between lanes.
    pub is_per_lane: bool,
    /// Whether the scalar has changed at the end of the body, and not only at jumps out of the loop.
    pub is_changed_at_body_end: bool,
}

/// The scalars that change in a loop, by their index in `env`.
pub(crate) type LoopChanges = HashMap<usize, ScalarChange>;

/// A loop whose body is being lowered.
pub(crate) struct OpenLoop {
    /// The label behind the loop. An exit that all lanes take together may be a jump to it ([`Lowerer::may_exit_by_jump`]).
    pub exit: JumpLabel,
    /// For each scalar that changes in the loop: its index in `env`, and the loop variable that carries it from one iteration to the next.
    pub variables: Vec<(usize, SsaValue)>,
    /// The environment (`Lowerer::env`) at each exit by jump.
    pub exit_envs: Vec<Vec<SsaValue>>,
    pub iteration_start: IterationStart,
}

/// The state of the lowering at the start of an iteration, to tell whether the iteration has changed anything yet
/// ([`Lowerer::loop_exit_if_nothing_changed`]).
pub(crate) struct IterationStart {
    pub env: Vec<SsaValue>,
    pub condition_depth: usize,
}

impl IterationStart {
    /// For a loop of which no iteration is being lowered yet, or which is unrolled: a state that equals no other, so that every iteration counts as changed.
    pub(crate) fn unequal_to_all() -> Self {
        Self { env: Vec::new(), condition_depth: usize::MAX }
    }
}

/// The lowering of one entry point.
pub(crate) struct Lowerer<'m> {
    pub module: &'m naga::Module,
    pub info: &'m ModuleInfo,
    pub builder: SsaBuilder,
    /// The environment: the current value of each scalar of every variable in scope, and the flags that `return`, `break` and `continue` set.
    pub env: Vec<SsaValue>,
    /// The callers, and last the function being lowered.
    pub frames: Vec<CallFrame<'m>>,
    /// The textures that the program reads, so far.
    pub textures: Vec<TextureUse>,
    /// Size of the uniform block in bytes; 0 if there is none.
    pub uniform_size: u32,
    /// Source position of the statement or expression being lowered.
    pub span: Span,
    /// Mask of the lanes that are active here.
    pub active_mask: SsaValue,
    /// The module's variables: textures, samplers, the uniform block and private variables.
    pub globals: HashMap<Handle<naga::GlobalVariable>, Value>,
    /// The loops whose bodies are being lowered, in all functions being inlined; innermost last.
    pub open_loops: Vec<OpenLoop>,
    /// Memory addresses, as identities, of the call statements that are being inlined, outermost first.
    pub call_path: Vec<usize>,
    /// For each inner loop that has been lowered so far within the outermost open loop: how scalars change in it. Key: [`Lowerer::path_of_loop`].
    pub known_changes: HashMap<Vec<usize>, LoopChanges>,
    /// Whether an exit from the innermost loop that all lanes take together may become a jump: only at the top level of the loop's body, and not in a loop that
    /// is being unrolled. Otherwise the exit only sets its flag.
    pub may_exit_by_jump: bool,
    /// Number of conditions under which the current statement runs; see [`Lowerer::conditional`].
    pub condition_depth: usize,
    /// Named values to be output, if they were requested.
    pub named_values: Option<super::named_values::NamedValueCapture>,
    /// Number of statements so far; with a large `env`, a statement counts as several ([`SCALARS_PER_STATEMENT`]). At most [`MAX_STATEMENTS`].
    statement_count: usize,
    /// Depth of nested blocks and calls; at most [`MAX_NESTING`].
    nesting: usize,
    /// Some functions of the shipped fragments, such as `filtered_map`, have native operations (`native.rs`). For each called function with the name of such a
    /// function: whether its body equals the shipped one.
    pub known_equal_to_shipped: HashMap<Handle<Function>, bool>,
}

/// Index in [`Lowerer::env`] of the mask of lanes that have discarded.
pub(crate) const DISCARDED_INDEX: usize = 0;

/// Maximum number of statements of a module, counted each time that a call is inlined or a loop's body is lowered again. Without a limit, a chain of
/// thirty functions, each calling the next one twice, would become 2^30 statements. The shipped modules have some 10^4.
const MAX_STATEMENTS: usize = 1 << 19;
/// Number of scalars in the environment that add one to the count of each statement, because a large environment is copied at many statements.
const SCALARS_PER_STATEMENT: usize = 64;
/// Maximum number of instructions of the lane tape ("steps" in the error). It is limited separately, because a store with a variable index takes several
/// instructions per element.
const MAX_INSTRS: usize = 1 << 20;
/// Maximum nesting of blocks and calls, because lowering is recursive.
const MAX_NESTING: usize = 200;

impl<'m> Lowerer<'m> {
    /// Counts a statement, and checks the numbers of statements and instructions so far.
    ///
    /// # Errors
    /// More statements than [`MAX_STATEMENTS`], or more instructions than [`MAX_INSTRS`].
    pub(super) fn count_statement_and_check_limits(&mut self) -> Result<()> {
        self.statement_count += 1 + self.env.len() / SCALARS_PER_STATEMENT;
        for (count, max, what) in
            [(self.statement_count, MAX_STATEMENTS, "statements"), (self.builder.lane_instrs.len(), MAX_INSTRS, "steps")]
        {
            if count > max {
                return Err(self.unsupported(format!("the module has too many {what} after all calls are inlined")));
            }
        }
        Ok(())
    }

    /// Runs `lower_content`, which lowers the content of a nested block.
    ///
    /// # Errors
    /// The errors of `lower_content`, or nesting deeper than the limit. After an error the lowering ends, so `nesting` is not restored.
    pub(super) fn in_block(&mut self, lower_content: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            return Err(self.unsupported(format!("more than {MAX_NESTING} blocks and calls are nested in each other")));
        }
        lower_content(self)?;
        self.nesting -= 1;
        Ok(())
    }

    /// The state before the first statement: the module's variables have their initial values. `active_mask`: the lanes that are active at the start.
    ///
    /// # Errors
    /// A variable of an unsupported kind.
    pub(crate) fn new(module: &'m naga::Module, info: &'m ModuleInfo, mut builder: SsaBuilder, active_mask: SsaValue) -> Result<Self> {
        let discarded = builder.bool(false);
        let mut this = Self {
            module,
            info,
            builder,
            env: vec![discarded],
            frames: Vec::new(),
            textures: Vec::new(),
            uniform_size: 0,
            span: Span::UNDEFINED,
            active_mask,
            globals: HashMap::default(),
            open_loops: Vec::new(),
            call_path: Vec::new(),
            known_changes: HashMap::default(),
            may_exit_by_jump: false,
            condition_depth: 0,
            named_values: None,
            statement_count: 0,
            nesting: 0,
            known_equal_to_shipped: HashMap::default(),
        };
        for (handle, global) in module.global_variables.iter() {
            this.span = module.global_variables.get_span(handle);
            let inner = &module.types[global.ty].inner;
            let value = match global.space {
                AddressSpace::Handle => Value::Resource(handle),
                AddressSpace::Uniform => {
                    if global.binding.as_ref().is_none_or(|b| b.group != 0 || b.binding != 0) {
                        return Err(this.unsupported("a uniform block must be at @group(0) @binding(0)".into()));
                    }
                    this.uniform_size = inner.size(module.to_ctx());
                    Value::Place(Place::Uniform { byte_offset: 0, word_offset: None, inner: inner.clone() })
                }
                AddressSpace::Private => {
                    // Index in `env` of the variable's first scalar.
                    let base = this.env.len();
                    let values = match global.init {
                        Some(init) => this.global_expression(init)?,
                        None => this.zeros(inner)?,
                    };
                    this.env.extend(values);
                    Value::Place(Place::Variable { base, indices: Vec::new(), inner: inner.clone() })
                }
                other => return Err(this.unsupported(format!("variables in address space {other:?} are not supported"))),
            };
            this.globals.insert(handle, value);
        }
        this.span = Span::UNDEFINED;
        Ok(this)
    }

    /// An error at the current source position.
    pub(crate) fn unsupported(&self, what: String) -> LowerError {
        LowerError::new(what, self.span)
    }

    /// The mask of discarded lanes; `None` if it is known that no lane has discarded so far.
    pub(crate) fn discarded(&self) -> Option<SsaValue> {
        let mask = self.env[DISCARDED_INDEX];
        (self.builder.known_bool(mask) != Some(false)).then_some(mask)
    }

    /// The function being lowered.
    pub(crate) fn frame(&self) -> &CallFrame<'m> {
        &self.frames[self.frames.len() - 1]
    }
    pub(crate) fn frame_mut(&mut self) -> &mut CallFrame<'m> {
        let last = self.frames.len() - 1;
        &mut self.frames[last]
    }
}
