//! Statements: branches, loops, calls, returns.
//!
//! A way out of a block (`return`, `break`, `continue`) sets a flag word; the rest of the block is then lowered as if it stood under
//! `if (!flag)`. So stores need no guards, and skipping the rest when no lane is left comes with it.

use super::builder::{Builder, Label, Step, Val};
use super::place::{Place, Value};
use super::{LowerError, Result};
use crate::render::software::program::TextureUse;
use crate::render::software::tape::Op;
use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{AddressSpace, Block, Expression, Function, Handle, Span, Statement, SwitchValue, TypeInner};
use rustc_hash::FxHashMap as HashMap;

/// Regions with fewer operations than this run without a skip: the test costs as much as they do.
const SKIP_WORTH: usize = 12;

/// One function being inlined.
pub struct Frame<'m> {
    pub function: &'m Function,
    pub info: &'m FunctionInfo,
    pub arguments: Vec<Value>,
    pub values: HashMap<Handle<Expression>, Value>,
    pub locals: HashMap<Handle<naga::LocalVariable>, usize>,
    /// Word of the flag that is set by `return`.
    returned: usize,
    result: usize,
    /// Flag words (broken, continued) of the loops that are open in this function.
    pub loops: Vec<(usize, usize)>,
}

/// The loop whose body is being lowered, for leaving it by a real jump.
struct OpenLoop {
    exit: Label,
    /// Words that change in the loop, with their loop variables.
    variables: Vec<(usize, Val)>,
    /// The environment at each exit by jump.
    exits: Vec<Vec<Val>>,
}

pub struct Lowerer<'m> {
    pub module: &'m naga::Module,
    pub info: &'m ModuleInfo,
    pub builder: Builder,
    pub env: Vec<Val>,
    pub frames: Vec<Frame<'m>>,
    pub textures: Vec<TextureUse>,
    pub uniform_size: u32,
    /// Where the statement or expression being lowered stands.
    pub span: Span,
    /// Lanes that are active here.
    pub path: Val,
    pub globals: HashMap<Handle<naga::GlobalVariable>, Value>,
    /// Nesting under loops whose body is walked at top level: only there may a uniform way out jump.
    open_loops: Vec<OpenLoop>,
    top_of_loop: bool,
    /// Named values to be kept, where someone asked for them.
    pub watch: Option<super::named::Watch>,
    /// For functions named as a native operation: whether their body is the one that the operation computes.
    pub native: HashMap<Handle<Function>, bool>,
}

/// How a word changes in a loop.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Change {
    /// Differs between lanes.
    lane: bool,
    /// Changes on the way to the next turn, not only on the way out.
    each_turn: bool,
}

/// Environment word of "this lane has discarded".
pub const KILLED: usize = 0;

impl<'m> Lowerer<'m> {
    pub fn new(module: &'m naga::Module, info: &'m ModuleInfo, mut builder: Builder, active: Val) -> Result<Self> {
        let alive = builder.bool(false);
        let mut this = Self {
            module,
            info,
            builder,
            env: vec![alive],
            frames: Vec::new(),
            textures: Vec::new(),
            uniform_size: 0,
            span: Span::UNDEFINED,
            path: active,
            globals: HashMap::default(),
            open_loops: Vec::new(),
            top_of_loop: false,
            watch: None,
            native: HashMap::default(),
        };
        for (handle, global) in module.global_variables.iter() {
            this.span = module.global_variables.get_span(handle);
            let inner = &module.types[global.ty].inner;
            let value = match global.space {
                AddressSpace::Handle => Value::Resource(handle),
                AddressSpace::Uniform => {
                    if global.binding.as_ref().is_none_or(|b| b.group != 0 || b.binding != 0) {
                        return Err(this.refuse("a uniform block must be at @group(0) @binding(0)".into()));
                    }
                    this.uniform_size = inner.size(module.to_ctx());
                    Value::Place(Place::Uniform { offset: 0, dynamic: None, inner: inner.clone() })
                }
                AddressSpace::Private => {
                    let base = this.env.len();
                    let values = match global.init {
                        Some(init) => this.global_expression(init)?,
                        None => this.zeros(inner)?,
                    };
                    this.env.extend(values);
                    Value::Place(Place::Local { base, indices: Vec::new(), inner: inner.clone() })
                }
                other => return Err(this.refuse(format!("variables in address space {other:?} are not supported"))),
            };
            this.globals.insert(handle, value);
        }
        this.span = Span::UNDEFINED;
        Ok(this)
    }

    pub fn refuse(&self, what: String) -> LowerError {
        LowerError::new(what, self.span)
    }

    /// The mask of discarded lanes, if the program discards.
    pub fn killed(&self) -> Option<Val> {
        let k = self.env[KILLED];
        (self.builder.known_bool(k) != Some(false)).then_some(k)
    }

    pub fn frame(&self) -> &Frame<'m> {
        &self.frames[self.frames.len() - 1]
    }
    pub fn frame_mut(&mut self) -> &mut Frame<'m> {
        let last = self.frames.len() - 1;
        &mut self.frames[last]
    }

    pub fn entry(&mut self, function: &'m Function, info: &'m FunctionInfo, arguments: Vec<Vec<Val>>) -> Result<Vec<Val>> {
        self.call(function, info, arguments.into_iter().map(Value::Words).collect())
    }

    /// Inlines a call and gives the words of its result.
    pub fn call(&mut self, function: &'m Function, info: &'m FunctionInfo, arguments: Vec<Value>) -> Result<Vec<Val>> {
        let base = self.env.len();
        let no = self.builder.bool(false);
        self.env.push(no);
        let result = self.env.len();
        if let Some(r) = &function.result {
            let zeros = self.zeros(&self.module.types[r.ty].inner)?;
            self.env.extend(zeros);
        }
        let end = self.env.len();
        let mut frame = Frame {
            function,
            info,
            arguments,
            values: HashMap::default(),
            locals: HashMap::default(),
            returned: base,
            result,
            loops: Vec::new(),
        };
        let mut inits = Vec::new();
        for (handle, local) in function.local_variables.iter() {
            frame.locals.insert(handle, self.env.len());
            if let Some(init) = local.init {
                inits.push((self.env.len(), init));
            }
            let zeros = self.zeros(&self.module.types[local.ty].inner)?;
            self.env.extend(zeros);
        }
        self.frames.push(frame);
        for (at, init) in inits {
            let values = self.words_of(init)?;
            self.env[at..at + values.len()].copy_from_slice(&values);
        }
        let top = std::mem::replace(&mut self.top_of_loop, false);
        self.block(&function.body)?;
        self.top_of_loop = top;
        self.watch_variables()?;
        self.frames.pop();
        let words = self.env[result..end].to_vec();
        self.env.truncate(base);
        Ok(words)
    }

    /// The flag that tells which lanes have left the block being lowered.
    fn left(&mut self) -> Val {
        let frame = self.frame();
        let (returned, inner) = (frame.returned, frame.loops.last().copied());
        let mut left = self.env[returned];
        if let Some((broken, continued)) = inner {
            left = self.builder.bin(Op::Or, left, self.env[broken]);
            left = self.builder.bin(Op::Or, left, self.env[continued]);
        }
        left
    }

    fn clear_flags(&mut self) {
        let no = self.builder.bool(false);
        let frame = self.frame();
        let words = [Some(frame.returned), frame.loops.last().map(|l| l.0), frame.loops.last().map(|l| l.1)];
        for w in words.into_iter().flatten() {
            self.env[w] = no;
        }
    }

    fn block(&mut self, block: &'m Block) -> Result<()> {
        let statements: Vec<(&'m Statement, Span)> = block.span_iter().map(|(s, span)| (s, *span)).collect();
        self.statements(&statements)
    }

    fn statements(&mut self, statements: &[(&'m Statement, Span)]) -> Result<()> {
        for (i, (statement, span)) in statements.iter().enumerate() {
            self.span = *span;
            let killed = self.env[KILLED];
            self.statement(statement)?;
            let rest = &statements[i + 1..];
            let may_leave = matches!(
                statement,
                Statement::If { .. }
                    | Statement::Switch { .. }
                    | Statement::Loop { .. }
                    | Statement::Block(_)
                    | Statement::Break
                    | Statement::Continue
                    | Statement::Return { .. }
            );
            let left = if may_leave { self.left() } else { self.builder.bool(false) };
            match self.builder.known_bool(left) {
                Some(true) => return Ok(()),
                Some(false) => {
                    if self.env[KILLED] != killed && self.skips_the_dead(rest) {
                        let alive = self.builder.not(self.env[KILLED]);
                        return self.conditional(alive, |this| this.statements(rest));
                    }
                    continue;
                }
                None => {}
            }
            if rest.is_empty() {
                return Ok(());
            }
            if self.top_of_loop && !matches!(left, Val::Lane(_)) && !self.may_continue() {
                self.leave_loop_if(left);
                continue;
            }
            let stay = self.builder.not(left);
            return self.conditional(stay, |this| {
                this.clear_flags();
                this.statements(rest)
            });
        }
        Ok(())
    }

    /// Whether the innermost loop's `continue` flag may be set here.
    fn may_continue(&self) -> bool {
        self.frame().loops.last().is_some_and(|l| self.builder.known_bool(self.env[l.1]) != Some(false))
    }

    /// Leaves the innermost loop by a jump when the (uniform) flag is set. After it no flag is set.
    fn leave_loop_if(&mut self, left: Val) {
        let stay = self.builder.label();
        self.builder.code.push(Step::JumpIf { cond: left, when: false, label: stay });
        let at = self.env.clone();
        if let Some(open) = self.open_loops.last_mut() {
            open.exits.push(at.clone());
            let (variables, exit) = (open.variables.clone(), open.exit);
            self.assign(&variables, &at);
            self.builder.code.push(Step::Jump { label: exit });
        }
        self.builder.code.push(Step::Label(stay));
        self.clear_flags();
    }

    /// Gives loop variables their next values as if all at once.
    fn assign(&mut self, variables: &[(usize, Val)], env: &[Val]) {
        let mut moves: Vec<(Val, Val)> = variables.iter().map(|&(w, phi)| (phi, env[w])).filter(|(phi, v)| phi != v).collect();
        for i in 0..moves.len() {
            let from = moves[i].1;
            if moves[..i].iter().any(|(phi, _)| *phi == from) {
                let copy = if matches!(from, Val::Lane(_)) { self.builder.fresh_lane() } else { self.builder.fresh_once() };
                moves[i].1 = copy;
                self.builder.code.push(Step::Assign { dst: copy, from });
            }
        }
        for (dst, from) in moves {
            self.builder.code.push(Step::Assign { dst, from });
        }
    }

    /// Lowers `body` for the lanes where `cond` holds, behind a skip, and merges what it changed.
    fn conditional(&mut self, cond: Val, body: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        let before = self.env.clone();
        let (path, top) = (self.path, std::mem::replace(&mut self.top_of_loop, false));
        let label = self.builder.label();
        if matches!(cond, Val::Lane(_)) {
            self.path = self.builder.bin(Op::And, path, cond);
            self.builder.code.push(Step::SkipIfNone { mask: self.path, label });
        } else {
            self.builder.code.push(Step::JumpIf { cond, when: false, label });
        }
        let start = self.builder.code.len();
        self.builder.open_region();
        body(self)?;
        self.builder.close_region();
        let region = &self.builder.code[start..];
        let cheap = region.len() < SKIP_WORTH && region.iter().all(|s| matches!(s, Step::Op { op, .. } if cheap(*op)));
        if cheap && matches!(cond, Val::Lane(_)) {
            self.builder.code.remove(start - 1);
        } else {
            self.builder.code.push(Step::Label(label));
        }
        self.path = path;
        self.top_of_loop = top;
        for (w, old) in before.into_iter().enumerate() {
            if self.env[w] != old {
                self.env[w] = self.builder.select(cond, self.env[w], old);
            }
        }
        Ok(())
    }

    /// Both sides of a branch; the sides see the same start and merge by one `select` per word that differs.
    fn branch(
        &mut self,
        cond: Val,
        accept: impl FnOnce(&mut Self) -> Result<()>,
        reject: impl FnOnce(&mut Self) -> Result<()>,
    ) -> Result<()> {
        match self.builder.known_bool(cond) {
            Some(true) => return accept(self),
            Some(false) => return reject(self),
            None => {}
        }
        let before = self.env.clone();
        let mut taken = before.clone();
        self.conditional(cond, |this| {
            accept(this)?;
            taken.clone_from(&this.env);
            this.env.clone_from(&before);
            Ok(())
        })?;
        let not = self.builder.not(cond);
        let mut other = before.clone();
        self.conditional(not, |this| {
            reject(this)?;
            other.clone_from(&this.env);
            this.env.clone_from(&before);
            Ok(())
        })?;
        for (w, (a, b)) in taken.into_iter().zip(other).enumerate() {
            self.env[w] = self.builder.select(cond, a, b);
        }
        Ok(())
    }

    fn statement(&mut self, statement: &'m Statement) -> Result<()> {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    let value = self.evaluate(handle)?;
                    self.watch_value(handle, &value)?;
                    self.frame_mut().values.insert(handle, value);
                }
                Ok(())
            }
            Statement::Block(b) => self.block(b),
            Statement::If { condition, accept, reject } => {
                let cond = self.word_of(*condition)?;
                self.branch(cond, |this| this.block(accept), |this| this.block(reject))
            }
            Statement::Switch { selector, cases } => self.switch(*selector, cases),
            Statement::Loop { body, continuing, break_if } => self.repeat(body, continuing, *break_if),
            Statement::Break | Statement::Continue => {
                let yes = self.builder.bool(true);
                let flags = self.frame().loops.last().copied();
                let (broken, continued) = flags.ok_or_else(|| self.refuse("break or continue outside of a loop".into()))?;
                self.env[if matches!(statement, Statement::Break) { broken } else { continued }] = yes;
                Ok(())
            }
            Statement::Return { value } => {
                if let Some(v) = value {
                    let words = self.words_of(*v)?;
                    let at = self.frame().result;
                    self.env[at..at + words.len()].copy_from_slice(&words);
                }
                let yes = self.builder.bool(true);
                let flag = self.frame().returned;
                self.env[flag] = yes;
                Ok(())
            }
            Statement::Kill => {
                self.env[KILLED] = self.builder.bool(true);
                Ok(())
            }
            Statement::Store { pointer, value } => {
                let place = self.place_of(*pointer)?;
                let words = self.words_of(*value)?;
                self.store(&place, &words)
            }
            Statement::Call { function, arguments, result } => {
                let callee = &self.module.functions[*function];
                if let (Some(filtered), Some(r)) = (self.native_call(*function, arguments)?, result) {
                    let value = Value::Words(filtered);
                    self.watch_value(*r, &value)?;
                    self.frame_mut().values.insert(*r, value);
                    return Ok(());
                }
                let mut values = Vec::new();
                for a in arguments {
                    values.push(self.value_of(*a)?);
                }
                let info = &self.info[*function];
                let here = self.span;
                self.watch_enter(callee.name.as_deref(), statement);
                let words = self.call(callee, info, values)?;
                self.watch_leave();
                self.span = here;
                if let Some(r) = result {
                    let value = Value::Words(words);
                    self.watch_value(*r, &value)?;
                    self.frame_mut().values.insert(*r, value);
                }
                Ok(())
            }
            other => {
                let name = format!("{other:?}");
                let name = name.split([' ', '(', '{']).next().unwrap_or_default().to_owned();
                Err(self.refuse(format!("statement {name} is not supported")))
            }
        }
    }

    /// A chain of conditions; `break` leaves it by its own flag, and a case that falls through runs the next one too.
    fn switch(&mut self, selector: Handle<Expression>, cases: &'m [naga::SwitchCase]) -> Result<()> {
        let value = self.word_of(selector)?;
        let no = self.builder.bool(false);
        let mut any = no;
        let mut chosen = Vec::new();
        for case in cases {
            let is = match case.value {
                SwitchValue::I32(i) => Some(self.builder.int(i as u32)),
                SwitchValue::U32(u) => Some(self.builder.int(u)),
                SwitchValue::Default => None,
            };
            let is = is.map(|k| self.builder.bin(Op::IEq, value, k));
            if let Some(is) = is {
                any = self.builder.bin(Op::Or, any, is);
            }
            chosen.push(is);
        }
        let default = self.builder.not(any);
        let top = std::mem::replace(&mut self.top_of_loop, false);
        // In a switch, `break` leaves the switch, and `continue` the loop around it.
        let broken = self.env.len();
        self.env.push(no);
        let outer = self.frame().loops.last().copied();
        let own_continued = outer.is_none();
        if own_continued {
            self.env.push(no);
        }
        let continued = outer.map_or(broken + 1, |l| l.1);
        self.frame_mut().loops.push((broken, continued));
        let mut falling = no;
        for (case, is) in cases.iter().zip(chosen) {
            let enter = self.builder.bin(Op::Or, is.unwrap_or(default), falling);
            let left = self.left();
            let stay = self.builder.not(left);
            let enter_now = self.builder.bin(Op::And, enter, stay);
            self.branch(
                enter_now,
                |this| {
                    this.clear_flags();
                    this.block(&case.body)
                },
                |_| Ok(()),
            )?;
            // The lanes inside cleared their flags; lanes outside kept theirs through the merge.
            falling = if case.fall_through { enter } else { no };
        }
        self.frame_mut().loops.pop();
        self.env.truncate(broken);
        self.top_of_loop = top;
        Ok(())
    }

    /// A loop. Which words change in it, and whether they stay equal in all lanes, is found by lowering the body until nothing new shows.
    fn repeat(&mut self, body: &'m Block, continuing: &'m Block, break_if: Option<Handle<Expression>>) -> Result<()> {
        let no = self.builder.bool(false);
        let base = self.env.len();
        self.env.push(no);
        self.env.push(no);
        let start_env = self.env.clone();
        let start_code = self.builder.code.len();
        let (path, top) = (self.path, self.top_of_loop);
        let mut changing: HashMap<usize, Change> = HashMap::default();
        loop {
            self.env.clone_from(&start_env);
            self.builder.code.truncate(start_code);
            self.path = path;
            self.frame_mut().loops.push((base, base + 1));
            let seen = self.turn(body, continuing, break_if, &changing);
            self.frame_mut().loops.pop();
            let seen = seen?;
            let mut stable = true;
            for (word, new) in seen {
                let known = changing.get(&word).copied();
                let both = known.map_or(new, |k| Change { lane: k.lane || new.lane, each_turn: k.each_turn || new.each_turn });
                if known != Some(both) {
                    changing.insert(word, both);
                    stable = false;
                }
            }
            if stable {
                break;
            }
        }
        self.path = path;
        self.top_of_loop = top;
        self.env.truncate(base);
        Ok(())
    }

    /// Lowers a loop given the words that change; returns those that were seen to.
    fn turn(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        changing: &HashMap<usize, Change>,
    ) -> Result<Vec<(usize, Change)>> {
        let outer_path = self.path;
        let mut words: Vec<usize> = changing.keys().copied().collect();
        words.sort_unstable();
        let mut variables = Vec::new();
        let returned = self.frame().returned;
        for w in words {
            let lane = changing[&w].lane || matches!(self.env[w], Val::Lane(_));
            let phi = if lane { self.builder.fresh_lane() } else { self.builder.fresh_once() };
            self.builder.code.push(Step::Assign { dst: phi, from: self.env[w] });
            // A return that leaves by a jump is never seen set inside the loop.
            if w != returned || changing[&w].each_turn {
                self.env[w] = phi;
            }
            variables.push((w, phi));
        }
        let (head, exit) = (self.builder.label(), self.builder.label());
        self.builder.code.push(Step::LoopStart);
        self.builder.code.push(Step::Label(head));
        self.builder.open_region();
        let start = self.env.clone();
        self.open_loops.push(OpenLoop { exit, variables: variables.clone(), exits: Vec::new() });
        let (broken, continued) = self.frame().loops.last().copied().unwrap_or_default();
        let no = self.builder.bool(false);
        let out = self.left();
        let whole = |this: &mut Self| {
            this.block(body)?;
            this.env[continued] = no;
            let left = this.left();
            let finish = |this: &mut Self| {
                this.clear_flags();
                this.block(continuing)?;
                if let Some(b) = break_if {
                    this.env[broken] = this.word_of(b)?;
                }
                Ok(())
            };
            match this.builder.known_bool(left) {
                Some(false) => finish(this),
                Some(true) => Ok(()),
                None => {
                    let stay = this.builder.not(left);
                    this.conditional(stay, finish)
                }
            }
        };
        // Lanes that left in an earlier turn sit this one out.
        if self.builder.known_bool(out) == Some(false) {
            self.top_of_loop = true;
            whole(self)?;
        } else {
            let stay = self.builder.not(out);
            self.top_of_loop = false;
            self.conditional(stay, |this| {
                this.clear_flags();
                whole(this)
            })?;
        }
        self.top_of_loop = false;
        self.env[continued] = no;
        let left = self.left();
        let end = self.env.clone();
        let stay = self.builder.not(left);
        let go_on = if matches!(left, Val::Lane(_)) { self.builder.bin(Op::And, outer_path, stay) } else { stay };
        self.assign(&variables, &end);
        match (self.builder.known_bool(left), go_on) {
            (Some(false), _) => self.builder.code.push(Step::Jump { label: head }),
            (Some(true), _) => {}
            (None, Val::Lane(_)) => {
                self.builder.code.push(Step::SkipIfNone { mask: go_on, label: exit });
                self.builder.code.push(Step::Jump { label: head });
            }
            (None, _) => self.builder.code.push(Step::JumpIf { cond: go_on, when: true, label: head }),
        }
        self.builder.close_region();
        self.builder.code.push(Step::LoopEnd);
        self.builder.code.push(Step::Label(exit));
        let exits = self.open_loops.pop().map(|o| o.exits).unwrap_or_default();
        let endless = exits.is_empty() && self.builder.known_bool(left) == Some(false);
        let mut seen = Vec::new();
        for (env, each_turn) in exits.iter().map(|e| (e, false)).chain([(&end, true)]) {
            for (w, v) in env.iter().enumerate().take(start.len()) {
                let own_flag = !each_turn && (w == broken || w == continued);
                if *v != start[w] && !own_flag {
                    seen.push((w, Change { lane: matches!(v, Val::Lane(_)), each_turn }));
                }
            }
        }
        if endless && seen.iter().all(|(w, _)| changing.contains_key(w)) {
            return Err(self.refuse("this loop never ends".into()));
        }
        // After the loop every changed word is its loop variable: whichever way was taken has written it.
        self.env = start;
        for (w, phi) in variables {
            self.env[w] = phi;
        }
        self.env[broken] = no;
        self.env[continued] = no;
        Ok(seen)
    }

    pub fn zeros(&mut self, inner: &TypeInner) -> Result<Vec<Val>> {
        let n = self.words(inner)?;
        let mut kinds = Vec::with_capacity(n);
        self.zero_words(inner, &mut kinds)?;
        Ok(kinds)
    }

    fn zero_words(&mut self, inner: &TypeInner, out: &mut Vec<Val>) -> Result<()> {
        if let TypeInner::Scalar(s) = inner {
            out.push(match super::place::supported(*s, self.span)? {
                naga::ScalarKind::Float => self.builder.float(0.0),
                naga::ScalarKind::Bool => self.builder.bool(false),
                _ => self.builder.int(0),
            });
            return Ok(());
        }
        for k in 0..self.children(inner)? {
            let (child, _, _) = self.child(inner, k)?;
            self.zero_words(&child, out)?;
        }
        Ok(())
    }
}

/// Whether an operation costs about one pass over the lanes.
fn cheap(op: Op) -> bool {
    use Op::*;
    matches!(
        op,
        Copy | Neg
            | Abs
            | Add
            | Sub
            | Mul
            | Min
            | Max
            | Select
            | And
            | Or
            | Xor
            | BNot
            | FLt
            | FLe
            | FEq
            | FNe
            | IEq
            | INe
            | ILt
            | ULt
            | IAdd
            | ISub
    )
}
