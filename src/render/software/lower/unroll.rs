//! Unrolls loops whose number of iterations is known when the module is lowered, so that what depends only on the loop's counter runs once per draw.
//!
//! In: a loop, and the environment before it. Out: its iterations one after the other, and the environment after them; or nothing, if the loop is inside
//! another one or reads a texture, the number of its iterations is unknown, or the instructions would be too many (the loop then remains a loop,
//! `control_flow.rs`). Not here: the doubling of loops when a program is bound to kernels (`exec/unroll_loops.rs`).

use super::error::Result;
use super::lowerer::{IterationStart, LoopFlags, Lowerer, OpenLoop};
use super::ssa::SsaInstr;
use naga::{Block, Expression, Handle, Statement};

/// Largest number of iterations.
const MAX_ITERATIONS: usize = 8;
/// Largest number of instructions of all iterations, before operations are fused.
const MAX_UNROLLED_INSTRS: usize = 2048;

impl<'m> Lowerer<'m> {
    /// Lowers a loop as its iterations one after the other, if that is possible; otherwise returns false and leaves instructions and environment as they were.
    /// `flags`: the scalars of the environment in which `break` and `continue` set the lanes that execute them; clear in all lanes when the loop begins.
    pub(super) fn unroll(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        flags: LoopFlags,
    ) -> Result<bool> {
        // While named values are captured for the probe of a pixel, which shows one value per name, a loop remains a loop, with one iteration on the tape. A
        // loop inside a loop also remains one, because unrolling both would multiply the time of lowering.
        if self.named_values.is_some() || !self.open_loops.is_empty() {
            return Ok(false);
        }
        let start_env = self.env.clone();
        let first_instr = self.builder.lane_instrs.len();
        let outer_may_exit_by_jump = std::mem::replace(&mut self.may_exit_by_jump, false);
        // The instructions of `iteration_count` are removed below, so what they compute must not be found as earlier computations.
        self.builder.open_reuse_scope();
        let count = self.iteration_count(body, continuing)?;
        self.env.clone_from(&start_env);
        self.builder.lane_instrs.truncate(first_instr);
        self.builder.close_reuse_scope();
        self.builder.open_reuse_scope();
        let is_unrolled = if let Some(count) = count {
            self.frame_mut().loop_flags.push(flags);
            // With this start, and with `may_exit_by_jump` false, no exit from this loop becomes a jump: exits only set flags.
            let iteration_start = IterationStart::unequal_to_all();
            let exit = self.builder.fresh_label();
            self.open_loops.push(OpenLoop { exit, variables: Vec::new(), exit_envs: Vec::new(), iteration_start });
            let is_unrolled = self.iterations(body, continuing, break_if, flags, MAX_UNROLLED_INSTRS / count.max(1));
            self.open_loops.pop();
            self.frame_mut().loop_flags.pop();
            is_unrolled?
        } else {
            false
        };
        self.may_exit_by_jump = outer_may_exit_by_jump;
        if is_unrolled {
            self.builder.merge_reuse_scope();
            return Ok(true);
        }
        self.builder.close_reuse_scope();
        self.builder.lane_instrs.truncate(first_instr);
        self.env = start_env;
        Ok(false)
    }

    /// The number of iterations of a `for` loop, if it is known and at most [`MAX_ITERATIONS`], found by lowering only the condition with which the body begins
    /// and the `continuing` block. It is an estimate, because the rest of the body may change the counter, too. Changes instructions and environment.
    fn iteration_count(&mut self, body: &'m Block, continuing: &'m Block) -> Result<Option<usize>> {
        for count in 0..=MAX_ITERATIONS {
            // The side of the `if` at the start of the body that all lanes take, if that is known.
            let mut taken_side = None;
            for statement in body.iter() {
                match statement {
                    Statement::Emit(_) => self.statement(statement)?,
                    Statement::If { condition, accept, reject } => {
                        let cond = self.scalar_of(*condition)?;
                        taken_side = self.builder.known_bool(cond).map(|cond| if cond { accept } else { reject });
                        break;
                    }
                    _ => break,
                }
            }
            match taken_side.map(|side| side.first()) {
                None => return Ok(None),
                Some(Some(Statement::Break)) => return Ok(Some(count)),
                Some(_) => self.block(continuing)?,
            }
        }
        Ok(None)
    }

    /// Lowers iterations until all lanes have left the loop; returns false if it is unknown whether they have, or if an iteration
    /// has more than `max_instrs` instructions or reads a texture.
    fn iterations(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        LoopFlags { break_flag, continue_flag }: LoopFlags,
        max_instrs: usize,
    ) -> Result<bool> {
        let no = self.builder.bool(false);
        // The last turn of this Rust loop only finds that the condition fails.
        for _ in 0..=MAX_ITERATIONS {
            let first_instr = self.builder.lane_instrs.len();
            // `known_changes` caches which scalars each inner loop changes. These may differ between iterations of this loop.
            self.known_changes.clear();
            self.block(body)?;
            self.env[continue_flag] = no;
            let exited = self.exited_mask();
            match self.builder.known_bool(exited) {
                Some(false) => {}
                known => return Ok(known == Some(true)),
            }
            self.block(continuing)?;
            if let Some(condition) = break_if {
                self.env[break_flag] = self.scalar_of(condition)?;
                let exited = self.exited_mask();
                match self.builder.known_bool(exited) {
                    Some(false) => {}
                    known => return Ok(known == Some(true)),
                }
            }
            // Reads of textures take far longer than the loop's own instructions.
            let iteration = &self.builder.lane_instrs[first_instr..];
            if iteration.len() > max_instrs || iteration.iter().any(|instr| matches!(instr, SsaInstr::Texture { .. })) {
                return Ok(false);
            }
        }
        Ok(false)
    }
}
