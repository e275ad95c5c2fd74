//! Lowers branches, switches and loops.
//!
//! Both sides of a branch on a lane value run, each after a jump that skips it if no lane needs it; scalars that differ between the sides are
//! merged by a `select`. Loops remain loops: the scalars that change in a loop become loop variables (phi values).

use super::error::Result;
use super::lowerer::{Lowerer, OpenLoop};
use super::step::{Step, Val};
use crate::render::software::tape::Op;
use naga::{Block, Expression, Handle, SwitchValue};
use rustc_hash::FxHashMap as HashMap;

/// Regions with fewer operations than this run without a skip, because the test would cost as much as the region.
const MIN_SKIPPED_STEPS: usize = 12;

/// How a scalar changes in a loop.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Change {
    /// The scalar differs between lanes.
    lane: bool,
    /// The scalar changes in iterations that continue, not only when the loop is left.
    each_iteration: bool,
}

impl<'m> Lowerer<'m> {
    /// Whether the innermost loop's `continue` flag may be set here.
    pub(super) fn may_continue(&self) -> bool {
        self.frame().loops.last().is_some_and(|l| self.builder.known_bool(self.env[l.1]) != Some(false))
    }

    /// Leaves the innermost loop by a jump if the (uniform) flag `exited` is set. Afterwards no flag is set.
    pub(super) fn leave_loop_if(&mut self, exited: Val) {
        let stay = self.builder.label();
        self.builder.code.push(Step::JumpIf { cond: exited, when: false, label: stay });
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

    /// Assigns loop variables their next values, with the effect of a parallel assignment.
    fn assign(&mut self, variables: &[(usize, Val)], env: &[Val]) {
        let mut moves: Vec<(Val, Val)> = variables.iter().map(|&(w, phi)| (phi, env[w])).filter(|(phi, v)| phi != v).collect();
        for i in 0..moves.len() {
            let from = moves[i].1;
            if moves[..i].iter().any(|(phi, _)| *phi == from) {
                let copy = if matches!(from, Val::Lane(_)) { self.builder.fresh_lane() } else { self.builder.fresh_uniform() };
                moves[i].1 = copy;
                self.builder.code.push(Step::Assign { dst: copy, from });
            }
        }
        for (dst, from) in moves {
            self.builder.code.push(Step::Assign { dst, from });
        }
    }

    /// Lowers `body` for the lanes where `cond` holds, after a jump that skips it if there are no such lanes, and merges the scalars that it changed.
    pub(super) fn conditional(&mut self, cond: Val, body: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        let before = self.env.clone();
        let (mask, top) = (self.active_mask, std::mem::replace(&mut self.top_of_loop, false));
        let label = self.builder.label();
        if matches!(cond, Val::Lane(_)) {
            self.active_mask = self.builder.bin(Op::And, mask, cond);
            self.builder.code.push(Step::SkipIfNone { mask: self.active_mask, label });
        } else {
            self.builder.code.push(Step::JumpIf { cond, when: false, label });
        }
        let start = self.builder.code.len();
        self.builder.open_region();
        body(self)?;
        self.builder.close_region();
        let region = &self.builder.code[start..];
        let cheap = region.len() < MIN_SKIPPED_STEPS && region.iter().all(|s| matches!(s, Step::Op { op, .. } if cheap(*op)));
        if cheap && matches!(cond, Val::Lane(_)) {
            self.builder.code.remove(start - 1);
        } else {
            self.builder.code.push(Step::Label(label));
        }
        self.active_mask = mask;
        self.top_of_loop = top;
        for (w, old) in before.into_iter().enumerate() {
            if self.env[w] != old {
                self.env[w] = self.builder.select(cond, self.env[w], old);
            }
        }
        Ok(())
    }

    /// Lowers both sides of a branch from the same environment; scalars that differ are merged by a `select`.
    pub(super) fn branch(
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

    /// Lowers a `switch` to a sequence of conditions. `break` sets the switch's own flag; a case that falls through also runs the next case.
    pub(super) fn switch(&mut self, selector: Handle<Expression>, cases: &'m [naga::SwitchCase]) -> Result<()> {
        let value = self.scalar_of(selector)?;
        let no = self.builder.bool(false);
        let mut any = no;
        let mut matches = Vec::new();
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
            matches.push(is);
        }
        let default = self.builder.not(any);
        let top = std::mem::replace(&mut self.top_of_loop, false);
        // In a switch, `break` leaves the switch, and `continue` the loop around it.
        let broken = self.env.len();
        self.env.push(no);
        let outer = self.frame().loops.last().copied();
        if outer.is_none() {
            self.env.push(no);
        }
        let continued = outer.map_or(broken + 1, |l| l.1);
        self.frame_mut().loops.push((broken, continued));
        let mut fall_through_mask = no;
        for (case, is) in cases.iter().zip(matches) {
            let enter = self.builder.bin(Op::Or, is.unwrap_or(default), fall_through_mask);
            let exited = self.exited();
            let stay = self.builder.not(exited);
            let enter_now = self.builder.bin(Op::And, enter, stay);
            self.branch(
                enter_now,
                |this| {
                    this.clear_flags();
                    this.block(&case.body)
                },
                |_| Ok(()),
            )?;
            // Lanes inside the case have cleared their flags; the merge keeps the flags of the other lanes.
            fall_through_mask = if case.fall_through { enter } else { no };
        }
        self.frame_mut().loops.pop();
        self.env.truncate(broken);
        self.top_of_loop = top;
        Ok(())
    }

    /// Lowers a loop. Finds which scalars change in it, and whether they differ between lanes, by lowering the body until a fixed point is reached.
    pub(super) fn repeat(&mut self, body: &'m Block, continuing: &'m Block, break_if: Option<Handle<Expression>>) -> Result<()> {
        let no = self.builder.bool(false);
        let base = self.env.len();
        self.env.push(no);
        self.env.push(no);
        let start_env = self.env.clone();
        let start_code = self.builder.code.len();
        let (mask, top) = (self.active_mask, self.top_of_loop);
        let mut changing: HashMap<usize, Change> = HashMap::default();
        loop {
            self.env.clone_from(&start_env);
            self.builder.code.truncate(start_code);
            self.active_mask = mask;
            self.frame_mut().loops.push((base, base + 1));
            let changes = self.loop_body(body, continuing, break_if, &changing);
            self.frame_mut().loops.pop();
            let changes = changes?;
            let mut stable = true;
            for (scalar, new) in changes {
                let known = changing.get(&scalar).copied();
                let merged =
                    known.map_or(new, |k| Change { lane: k.lane || new.lane, each_iteration: k.each_iteration || new.each_iteration });
                if known != Some(merged) {
                    changing.insert(scalar, merged);
                    stable = false;
                }
            }
            if stable {
                break;
            }
        }
        self.active_mask = mask;
        self.top_of_loop = top;
        self.env.truncate(base);
        Ok(())
    }

    /// Lowers a loop, given the scalars assumed to change in it; returns the scalars that changed.
    fn loop_body(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        changing: &HashMap<usize, Change>,
    ) -> Result<Vec<(usize, Change)>> {
        let outer_mask = self.active_mask;
        let mut scalars: Vec<usize> = changing.keys().copied().collect();
        scalars.sort_unstable();
        let mut variables = Vec::new();
        let returned = self.frame().returned;
        for w in scalars {
            let lane = changing[&w].lane || matches!(self.env[w], Val::Lane(_));
            let phi = if lane { self.builder.fresh_lane() } else { self.builder.fresh_uniform() };
            self.builder.code.push(Step::Assign { dst: phi, from: self.env[w] });
            // If `return` always leaves the loop by a jump, its flag is never set inside the loop.
            if w != returned || changing[&w].each_iteration {
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
        let exited_before = self.exited();
        let iteration = |this: &mut Self| {
            this.block(body)?;
            this.env[continued] = no;
            let exited = this.exited();
            let finish = |this: &mut Self| {
                this.clear_flags();
                this.block(continuing)?;
                if let Some(b) = break_if {
                    this.env[broken] = this.scalar_of(b)?;
                }
                Ok(())
            };
            match this.builder.known_bool(exited) {
                Some(false) => finish(this),
                Some(true) => Ok(()),
                None => {
                    let stay = this.builder.not(exited);
                    this.conditional(stay, finish)
                }
            }
        };
        // Lanes that left the loop in an earlier iteration are inactive in this one.
        if self.builder.known_bool(exited_before) == Some(false) {
            self.top_of_loop = true;
            iteration(self)?;
        } else {
            let stay = self.builder.not(exited_before);
            self.top_of_loop = false;
            self.conditional(stay, |this| {
                this.clear_flags();
                iteration(this)
            })?;
        }
        self.top_of_loop = false;
        self.env[continued] = no;
        let exited = self.exited();
        let end = self.env.clone();
        let stay = self.builder.not(exited);
        let repeats = if matches!(exited, Val::Lane(_)) { self.builder.bin(Op::And, outer_mask, stay) } else { stay };
        self.assign(&variables, &end);
        match (self.builder.known_bool(exited), repeats) {
            (Some(false), _) => self.builder.code.push(Step::Jump { label: head }),
            (Some(true), _) => {}
            (None, Val::Lane(_)) => {
                self.builder.code.push(Step::SkipIfNone { mask: repeats, label: exit });
                self.builder.code.push(Step::Jump { label: head });
            }
            (None, _) => self.builder.code.push(Step::JumpIf { cond: repeats, when: true, label: head }),
        }
        self.builder.close_region();
        self.builder.code.push(Step::LoopEnd);
        self.builder.code.push(Step::Label(exit));
        let exits = self.open_loops.pop().map(|o| o.exits).unwrap_or_default();
        let endless = exits.is_empty() && self.builder.known_bool(exited) == Some(false);
        let mut changes = Vec::new();
        for (env, each_iteration) in exits.iter().map(|e| (e, false)).chain([(&end, true)]) {
            for (w, v) in env.iter().enumerate().take(start.len()) {
                let own_flag = !each_iteration && (w == broken || w == continued);
                if *v != start[w] && !own_flag {
                    changes.push((w, Change { lane: matches!(v, Val::Lane(_)), each_iteration }));
                }
            }
        }
        if endless && changes.iter().all(|(w, _)| changing.contains_key(w)) {
            return Err(self.unsupported("this loop never ends".into()));
        }
        // After the loop every changed scalar is its loop variable, which each exit has assigned.
        self.env = start;
        for (w, phi) in variables {
            self.env[w] = phi;
        }
        self.env[broken] = no;
        self.env[continued] = no;
        Ok(changes)
    }
}

/// Whether an operation is cheap: it costs about one pass over the lanes.
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
