//! Branches, switches and loops.
//!
//! Both sides of a branch on a lane value run, each behind a skip for when no lane needs it, and merge by one `select` for each scalar that differs.
//! Loops stay loops: the scalars that change in one become loop variables.

use super::error::Result;
use super::lowerer::{Lowerer, OpenLoop};
use super::step::{Step, Val};
use crate::render::software::tape::Op;
use naga::{Block, Expression, Handle, SwitchValue};
use rustc_hash::FxHashMap as HashMap;

/// Regions with fewer operations than this run without a skip: the test costs as much as they do.
const SKIP_WORTH: usize = 12;

/// How a scalar changes in a loop.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Change {
    /// Differs between lanes.
    lane: bool,
    /// Changes on the way to the next turn, not only on the way out.
    each_iteration: bool,
}

impl<'m> Lowerer<'m> {
    /// Whether the innermost loop's `continue` flag may be set here.
    pub(super) fn may_continue(&self) -> bool {
        self.frame().loops.last().is_some_and(|l| self.builder.known_bool(self.env[l.1]) != Some(false))
    }

    /// Leaves the innermost loop by a jump when the (uniform) flag is set. After it no flag is set.
    pub(super) fn leave_loop_if(&mut self, left: Val) {
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
                let copy = if matches!(from, Val::Lane(_)) { self.builder.fresh_lane() } else { self.builder.fresh_uniform() };
                moves[i].1 = copy;
                self.builder.code.push(Step::Assign { dst: copy, from });
            }
        }
        for (dst, from) in moves {
            self.builder.code.push(Step::Assign { dst, from });
        }
    }

    /// Lowers `body` for the lanes where `cond` holds, behind a skip, and merges what it changed.
    pub(super) fn conditional(&mut self, cond: Val, body: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
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

    /// Both sides of a branch; the sides see the same start and merge by one `select` per scalar that differs.
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

    /// A chain of conditions; `break` leaves it by its own flag, and a case that falls through runs the next one too.
    pub(super) fn switch(&mut self, selector: Handle<Expression>, cases: &'m [naga::SwitchCase]) -> Result<()> {
        let value = self.scalar_of(selector)?;
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

    /// A loop. Which scalars change in it, and whether they stay equal in all lanes, is found by lowering the body until nothing new shows.
    pub(super) fn repeat(&mut self, body: &'m Block, continuing: &'m Block, break_if: Option<Handle<Expression>>) -> Result<()> {
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
            let seen = self.loop_body(body, continuing, break_if, &changing);
            self.frame_mut().loops.pop();
            let seen = seen?;
            let mut stable = true;
            for (scalar, new) in seen {
                let known = changing.get(&scalar).copied();
                let both =
                    known.map_or(new, |k| Change { lane: k.lane || new.lane, each_iteration: k.each_iteration || new.each_iteration });
                if known != Some(both) {
                    changing.insert(scalar, both);
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

    /// Lowers a loop given the scalars that change; returns those that were seen to.
    fn loop_body(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        changing: &HashMap<usize, Change>,
    ) -> Result<Vec<(usize, Change)>> {
        let outer_path = self.path;
        let mut scalars: Vec<usize> = changing.keys().copied().collect();
        scalars.sort_unstable();
        let mut variables = Vec::new();
        let returned = self.frame().returned;
        for w in scalars {
            let lane = changing[&w].lane || matches!(self.env[w], Val::Lane(_));
            let phi = if lane { self.builder.fresh_lane() } else { self.builder.fresh_uniform() };
            self.builder.code.push(Step::Assign { dst: phi, from: self.env[w] });
            // A return that leaves by a jump is never seen set inside the loop.
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
        let out = self.left();
        let whole = |this: &mut Self| {
            this.block(body)?;
            this.env[continued] = no;
            let left = this.left();
            let finish = |this: &mut Self| {
                this.clear_flags();
                this.block(continuing)?;
                if let Some(b) = break_if {
                    this.env[broken] = this.scalar_of(b)?;
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
        for (env, each_iteration) in exits.iter().map(|e| (e, false)).chain([(&end, true)]) {
            for (w, v) in env.iter().enumerate().take(start.len()) {
                let own_flag = !each_iteration && (w == broken || w == continued);
                if *v != start[w] && !own_flag {
                    seen.push((w, Change { lane: matches!(v, Val::Lane(_)), each_iteration }));
                }
            }
        }
        if endless && seen.iter().all(|(w, _)| changing.contains_key(w)) {
            return Err(self.unsupported("this loop never ends".into()));
        }
        // After the loop every changed scalar is its loop variable: whichever way was taken has written it.
        self.env = start;
        for (w, phi) in variables {
            self.env[w] = phi;
        }
        self.env[broken] = no;
        self.env[continued] = no;
        Ok(seen)
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
