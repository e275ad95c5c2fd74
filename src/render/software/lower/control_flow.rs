//! Lowers branches, switches and loops.
//!
//! Both sides of a branch on a lane value (a condition that may differ between lanes) run, each after a jump that skips it if no lane needs it; scalars that
//! differ between the sides are merged by a `select`. Of a branch on one value for all lanes only one side runs, and each side writes the scalars that differ
//! to variables (`merge.rs`). Loops remain loops: the scalars that change in a loop become loop variables (phi values).
//!
//! In: a condition, or the parts of a `switch` or loop. Out: SSA instructions, and the environment after them. Not here: exits from blocks (`statements.rs`).

use super::error::{LowerError, Result};
use super::lowerer::{IterationStart, LoopChanges, LoopFlags, Lowerer, OpenLoop, ScalarChange};
use super::merge::Sides;
use super::ssa::{JumpLabel, SsaInstr, SsaValue};
use crate::render::software::tape::Op;
use naga::{Block, Expression, Handle, SwitchValue};

/// A conditional body of fewer instructions than this, all of them cheap, runs without a skip, because the test would cost as much as the body.
const MIN_SKIPPED_INSTRS: usize = 12;

impl<'m> Lowerer<'m> {
    /// Whether the flag of the innermost loop's `continue` may be set in some lane here; false if the flag is known to be clear, or no loop is open.
    pub(super) fn continue_flag_may_be_set(&self) -> bool {
        self.frame().loop_flags.last().is_some_and(|l| self.builder.known_bool(self.env[l.continue_flag]) != Some(false))
    }

    /// Leaves the innermost loop by a jump if the flag `exited`, one value for all lanes, is set. No flag is set in the code after the jump.
    pub(super) fn leave_loop_if(&mut self, exited: SsaValue) {
        let no_exit = self.builder.fresh_label();
        self.builder.lane_instrs.push(SsaInstr::JumpIf { cond: exited, when: false, label: no_exit });
        let env = self.env.clone();
        if let Some(open_loop) = self.open_loops.last_mut() {
            open_loop.exit_envs.push(env.clone());
            let (variables, exit) = (open_loop.variables.clone(), open_loop.exit);
            self.assign(&variables, &env);
            self.builder.lane_instrs.push(SsaInstr::Jump { label: exit });
        }
        self.builder.lane_instrs.push(SsaInstr::Label(no_exit));
        self.clear_flags();
    }

    /// Assigns to each loop variable (index in `env`, variable) its next value in `env`, with the effect of a parallel assignment.
    fn assign(&mut self, variables: &[(usize, SsaValue)], env: &[SsaValue]) {
        // Loop variable and new value. A value that an earlier move overwrites is copied first.
        let mut moves: Vec<(SsaValue, SsaValue)> =
            variables.iter().map(|&(scalar, phi)| (phi, env[scalar])).filter(|(phi, v)| phi != v).collect();
        for i in 0..moves.len() {
            let from = moves[i].1;
            if moves[..i].iter().any(|(phi, _)| *phi == from) {
                let copy = if matches!(from, SsaValue::Lane(_)) { self.builder.fresh_lane() } else { self.builder.fresh_shared() };
                moves[i].1 = copy;
                self.builder.lane_instrs.push(SsaInstr::Assign { dst: copy, from });
            }
        }
        for (dst, from) in moves {
            self.builder.lane_instrs.push(SsaInstr::Assign { dst, from });
        }
    }

    /// The label behind the innermost loop, if the code may jump there instead of running the rest of this iteration when no lane remains; otherwise `None`. It
    /// may if the iteration has changed no scalar yet except the flag of `break`: the loop variables then have the right values behind the loop, and no further
    /// iteration runs.
    pub(super) fn loop_exit_if_nothing_changed(&self) -> Option<JumpLabel> {
        let open_loop = self.open_loops.last()?;
        let break_flag = self.frame().loop_flags.last()?.break_flag;
        let start = &open_loop.iteration_start;
        let is_unchanged = |(scalar, (now, before)): (usize, (&SsaValue, &SsaValue))| now == before || scalar == break_flag;
        let is_at_top = start.condition_depth == self.condition_depth && start.env.len() == self.env.len();
        (is_at_top && self.env.iter().zip(&start.env).enumerate().all(is_unchanged)).then_some(open_loop.exit)
    }

    /// Lowers `body` for the lanes where `cond` holds, after a jump that skips the body if there are no such lanes, and merges the scalars that the body
    /// changed.
    pub(super) fn conditional(&mut self, cond: SsaValue, body: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        let skip_target = None;
        self.conditional_or_jump(cond, skip_target, body)
    }

    /// As [`Lowerer::conditional`]. If `cond` is a lane value and there is a `skip_target`, the jump goes there instead of past the body.
    pub(super) fn conditional_or_jump(
        &mut self,
        cond: SsaValue,
        skip_target: Option<JumpLabel>,
        body: impl FnOnce(&mut Self) -> Result<()>,
    ) -> Result<()> {
        let before = self.env.clone();
        let (outer_mask, outer_may_exit_by_jump) = (self.active_mask, std::mem::replace(&mut self.may_exit_by_jump, false));
        let label = self.builder.fresh_label();
        if matches!(cond, SsaValue::Lane(_)) {
            self.active_mask = self.builder.binary(Op::And, outer_mask, cond);
            self.builder.lane_instrs.push(SsaInstr::SkipIfNoLane { mask: self.active_mask, label: skip_target.unwrap_or(label) });
        } else {
            self.builder.lane_instrs.push(SsaInstr::JumpIf { cond, when: false, label });
        }
        let start = self.builder.lane_instrs.len();
        self.builder.open_reuse_scope();
        self.condition_depth += 1;
        body(self)?;
        self.condition_depth -= 1;
        self.builder.close_reuse_scope();
        let body_instrs = &self.builder.lane_instrs[start..];
        let needs_no_skip =
            body_instrs.len() < MIN_SKIPPED_INSTRS && body_instrs.iter().all(|s| matches!(s, SsaInstr::Op { op, .. } if is_cheap(*op)));
        if needs_no_skip && matches!(cond, SsaValue::Lane(_)) {
            // Removes the skip.
            self.builder.lane_instrs.remove(start - 1);
        } else {
            self.builder.lane_instrs.push(SsaInstr::Label(label));
        }
        self.active_mask = outer_mask;
        self.may_exit_by_jump = outer_may_exit_by_jump;
        for (scalar, old) in before.into_iter().enumerate() {
            if self.env[scalar] != old {
                self.env[scalar] = self.builder.select(cond, self.env[scalar], old);
            }
        }
        Ok(())
    }

    /// Lowers both sides of a branch from the same environment, and merges the scalars that differ.
    pub(super) fn branch(
        &mut self,
        cond: SsaValue,
        accept: impl FnOnce(&mut Self) -> Result<()>,
        reject: impl FnOnce(&mut Self) -> Result<()>,
    ) -> Result<()> {
        match self.builder.known_bool(cond) {
            Some(true) => return accept(self),
            Some(false) => return reject(self),
            None => {}
        }
        let before = self.env.clone();
        let start = self.builder.lane_instrs.len();
        let mut accepted_env = before.clone();
        // Each side restores the environment at its end, so that `conditional` merges nothing; both sides are merged below.
        self.conditional(cond, |this| {
            accept(this)?;
            accepted_env.clone_from(&this.env);
            this.env.clone_from(&before);
            Ok(())
        })?;
        let accepted_end = self.builder.lane_instrs.len();
        let negated = self.builder.not(cond);
        let mut rejected_env = before.clone();
        self.conditional(negated, |this| {
            reject(this)?;
            rejected_env.clone_from(&this.env);
            this.env.clone_from(&before);
            Ok(())
        })?;
        if !matches!(cond, SsaValue::Lane(_)) {
            let ends = [accepted_end, self.builder.lane_instrs.len()];
            self.merge_sides(cond, Sides { start, ends, envs: [accepted_env, rejected_env] });
            return Ok(());
        }
        for (scalar, (accepted, rejected)) in accepted_env.into_iter().zip(rejected_env).enumerate() {
            self.env[scalar] = self.builder.select(cond, accepted, rejected);
        }
        Ok(())
    }

    /// Lowers a `switch` to a sequence of conditions. `break` sets the switch's own flag; a case that falls through also runs the next case.
    pub(super) fn switch(&mut self, selector: Handle<Expression>, cases: &'m [naga::SwitchCase]) -> Result<()> {
        let value = self.scalar_of(selector)?;
        let constant_false = self.builder.bool(false);
        let mut any_match = constant_false;
        // Per case, the mask of the lanes whose selector has the case's value; `None` for the default case.
        let mut matches = Vec::new();
        for case in cases {
            let case_value = match case.value {
                SwitchValue::I32(i) => Some(self.builder.int(i as u32)),
                SwitchValue::U32(u) => Some(self.builder.int(u)),
                SwitchValue::Default => None,
            };
            let is_match = case_value.map(|k| self.builder.binary(Op::IEq, value, k));
            if let Some(is_match) = is_match {
                any_match = self.builder.binary(Op::Or, any_match, is_match);
            }
            matches.push(is_match);
        }
        let is_default = self.builder.not(any_match);
        let outer_may_exit_by_jump = std::mem::replace(&mut self.may_exit_by_jump, false);
        // In a switch, `break` leaves the switch, and `continue` the loop around it.
        let break_flag = self.env.len();
        self.env.push(constant_false);
        let outer_loop = self.frame().loop_flags.last().copied();
        if outer_loop.is_none() {
            // A `continue` flag that nothing sets.
            self.env.push(constant_false);
        }
        let continue_flag = outer_loop.map_or(break_flag + 1, |l| l.continue_flag);
        self.frame_mut().loop_flags.push(LoopFlags { break_flag, continue_flag });
        // The lanes that enter a case because the case before it falls through.
        let mut fall_through_mask = constant_false;
        for (case, is_match) in cases.iter().zip(matches) {
            let case_mask = self.builder.binary(Op::Or, is_match.unwrap_or(is_default), fall_through_mask);
            let exited = self.exited_mask();
            let remaining = self.builder.not(exited);
            let entering_mask = self.builder.binary(Op::And, case_mask, remaining);
            // Lanes that enter clear their flags; the merge keeps the flags of the other lanes.
            self.branch(
                entering_mask,
                |this| {
                    this.clear_flags();
                    this.block(&case.body)
                },
                |_| Ok(()),
            )?;
            fall_through_mask = if case.fall_through { case_mask } else { constant_false };
        }
        self.frame_mut().loop_flags.pop();
        self.env.truncate(break_flag);
        self.may_exit_by_jump = outer_may_exit_by_jump;
        Ok(())
    }

    /// Lowers a loop, unrolled if possible. To find which scalars change in the loop, and which of these differ between lanes, lowers it again until it changes
    /// no other scalars than were assumed.
    pub(super) fn lower_loop(&mut self, body: &'m Block, continuing: &'m Block, break_if: Option<Handle<Expression>>) -> Result<()> {
        let loop_span = self.span;
        let constant_false = self.builder.bool(false);
        let first_flag = self.env.len();
        // The flags of `break` and `continue`.
        self.env.extend([constant_false, constant_false]);
        let flags = LoopFlags { break_flag: first_flag, continue_flag: first_flag + 1 };
        if self.unroll(body, continuing, break_if, flags)? {
            self.env.truncate(first_flag);
            return Ok(());
        }
        let start_env = self.env.clone();
        let first_instr = self.builder.lane_instrs.len();
        let (outer_mask, outer_may_exit_by_jump) = (self.active_mask, self.may_exit_by_jump);
        // The scalars that are assumed to change. A loop in a loop is lowered again whenever the outer loop is, and then changes at least what it changed the
        // last time. Without this start, loops nested n deep would be lowered some 3^n times.
        let path = self.path_of_loop(body);
        if self.open_loops.is_empty() {
            self.known_changes.clear();
        }
        let mut assumed_changes: LoopChanges = self.known_changes.remove(&path).unwrap_or_default();
        loop {
            self.env.clone_from(&start_env);
            self.builder.lane_instrs.truncate(first_instr);
            self.active_mask = outer_mask;
            self.span = loop_span;
            self.frame_mut().loop_flags.push(flags);
            let changes = self.lower_loop_assuming(body, continuing, break_if, &assumed_changes);
            self.frame_mut().loop_flags.pop();
            let changes = changes?;
            let mut is_fixed_point = true;
            for (scalar, new) in changes {
                let known = assumed_changes.get(&scalar).copied();
                let merged = known.map_or(new, |k| ScalarChange {
                    is_per_lane: k.is_per_lane || new.is_per_lane,
                    is_changed_at_body_end: k.is_changed_at_body_end || new.is_changed_at_body_end,
                });
                if known != Some(merged) {
                    assumed_changes.insert(scalar, merged);
                    is_fixed_point = false;
                }
            }
            if is_fixed_point {
                break;
            }
        }
        self.known_changes.insert(path, assumed_changes);
        self.active_mask = outer_mask;
        self.may_exit_by_jump = outer_may_exit_by_jump;
        self.env.truncate(first_flag);
        Ok(())
    }

    /// Where a loop is: the calls that are being inlined, and its body.
    fn path_of_loop(&self, body: &'m Block) -> Vec<usize> {
        self.call_path.iter().copied().chain([std::ptr::from_ref(body).addr()]).collect()
    }

    /// Lowers a loop, given the scalars that are assumed to change in it; returns the scalars that changed. Scalars are given by their index in `env`.
    fn lower_loop_assuming(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        assumed_changes: &LoopChanges,
    ) -> Result<Vec<(usize, ScalarChange)>> {
        let (outer_mask, loop_span) = (self.active_mask, self.span);
        let mut scalars: Vec<usize> = assumed_changes.keys().copied().collect();
        scalars.sort_unstable();
        let mut variables = Vec::new();
        let return_flag = self.frame().return_flag;
        for scalar in scalars {
            let is_per_lane = assumed_changes[&scalar].is_per_lane || matches!(self.env[scalar], SsaValue::Lane(_));
            let phi = if is_per_lane { self.builder.fresh_lane() } else { self.builder.fresh_shared() };
            self.builder.lane_instrs.push(SsaInstr::Assign { dst: phi, from: self.env[scalar] });
            // If `return` always leaves the loop by a jump, its flag is never set inside the loop.
            if scalar != return_flag || assumed_changes[&scalar].is_changed_at_body_end {
                self.env[scalar] = phi;
            }
            variables.push((scalar, phi));
        }
        let (head, exit) = (self.builder.fresh_label(), self.builder.fresh_label());
        self.builder.lane_instrs.push(SsaInstr::LoopStart);
        self.builder.lane_instrs.push(SsaInstr::Label(head));
        self.builder.open_reuse_scope();
        let start_env = self.env.clone();
        // `iteration` below sets the state.
        let iteration_start = IterationStart::unequal_to_all();
        self.open_loops.push(OpenLoop { exit, variables: variables.clone(), exit_envs: Vec::new(), iteration_start });
        let LoopFlags { break_flag, continue_flag } = self.frame().loop_flags.last().copied().unwrap_or_default();
        let constant_false = self.builder.bool(false);
        let exited_before = self.exited_mask();
        let iteration = |this: &mut Self| {
            let iteration_start = IterationStart { env: this.env.clone(), condition_depth: this.condition_depth };
            if let Some(open_loop) = this.open_loops.last_mut() {
                open_loop.iteration_start = iteration_start;
            }
            this.block(body)?;
            this.env[continue_flag] = constant_false;
            let exited = this.exited_mask();
            let continuing_block = |this: &mut Self| {
                this.clear_flags();
                this.block(continuing)?;
                if let Some(b) = break_if {
                    this.env[break_flag] = this.scalar_of(b)?;
                }
                Ok(())
            };
            match this.builder.known_bool(exited) {
                Some(false) => continuing_block(this),
                Some(true) => Ok(()),
                None => {
                    let remaining = this.builder.not(exited);
                    this.conditional(remaining, continuing_block)
                }
            }
        };
        // Lanes that left the loop in an earlier iteration are inactive in this one.
        if self.builder.known_bool(exited_before) == Some(false) {
            self.may_exit_by_jump = true;
            iteration(self)?;
        } else {
            let remaining = self.builder.not(exited_before);
            self.may_exit_by_jump = false;
            self.conditional(remaining, |this| {
                this.clear_flags();
                iteration(this)
            })?;
        }
        self.may_exit_by_jump = false;
        self.env[continue_flag] = constant_false;
        let exited = self.exited_mask();
        let end_env = self.env.clone();
        let remaining = self.builder.not(exited);
        let repeat_condition =
            if matches!(exited, SsaValue::Lane(_)) { self.builder.binary(Op::And, outer_mask, remaining) } else { remaining };
        self.assign(&variables, &end_env);
        match (self.builder.known_bool(exited), repeat_condition) {
            (Some(false), _) => self.builder.lane_instrs.push(SsaInstr::Jump { label: head }),
            (Some(true), _) => {}
            (None, SsaValue::Lane(_)) => {
                self.builder.lane_instrs.push(SsaInstr::SkipIfNoLane { mask: repeat_condition, label: exit });
                self.builder.lane_instrs.push(SsaInstr::Jump { label: head });
            }
            (None, _) => self.builder.lane_instrs.push(SsaInstr::JumpIf { cond: repeat_condition, when: true, label: head }),
        }
        self.builder.close_reuse_scope();
        self.builder.lane_instrs.push(SsaInstr::LoopEnd);
        self.builder.lane_instrs.push(SsaInstr::Label(exit));
        let exit_envs = self.open_loops.pop().map(|o| o.exit_envs).unwrap_or_default();
        let is_endless = exit_envs.is_empty() && self.builder.known_bool(exited) == Some(false);
        let mut changes = Vec::new();
        for (env, is_body_end) in exit_envs.iter().map(|e| (e, false)).chain([(&end_env, true)]) {
            for (scalar, v) in env.iter().enumerate().take(start_env.len()) {
                // What an exit by a jump leaves in the loop's own flags does not count: nothing reads them behind the loop.
                let is_own_flag = !is_body_end && (scalar == break_flag || scalar == continue_flag);
                if *v != start_env[scalar] && !is_own_flag {
                    let is_per_lane = matches!(v, SsaValue::Lane(_));
                    changes.push((scalar, ScalarChange { is_per_lane, is_changed_at_body_end: is_body_end }));
                }
            }
        }
        // If a scalar changed that was assumed not to, the loop is lowered again, and may then turn out to end.
        if is_endless && changes.iter().all(|(scalar, _)| assumed_changes.contains_key(scalar)) {
            return Err(LowerError::new("this loop never ends".into(), loop_span));
        }
        // After the loop, the value of every changed scalar is its loop variable, to which each exit has assigned that value.
        self.env = start_env;
        for (scalar, phi) in variables {
            self.env[scalar] = phi;
        }
        self.env[break_flag] = constant_false;
        self.env[continue_flag] = constant_false;
        Ok(changes)
    }
}

/// Whether an operation is cheap: it takes about as long as to read and write its lanes once.
fn is_cheap(op: Op) -> bool {
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
