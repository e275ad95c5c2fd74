//! Unrolls loops whose number of iterations is known when the module is lowered, so that what depends only on the loop's counter runs once per draw.
//!
//! In: a loop outside of other loops that reads no texture, and the environment before it. Out: its iterations one after the other, and the environment after them; or nothing, if
//! the number of iterations is unknown or the steps would be too many (the loop then remains a loop, `control_flow.rs`). Not here: the doubling of loops when
//! a program is bound to kernels (`exec/unroll_loops.rs`).

use super::error::Result;
use super::lowerer::{LoopFlags, Lowerer, OpenLoop};
use super::step::SsaStep;
use naga::{Block, Expression, Handle, Statement};

/// Largest number of iterations.
const MAX_ITERATIONS: usize = 8;
/// Largest number of steps of all iterations, before operations are fused.
const MAX_UNROLLED_STEPS: usize = 2048;

impl<'m> Lowerer<'m> {
    /// Lowers a loop without a loop, if that is possible; otherwise returns false and leaves steps and environment as they were. `flags`: of the loop's `break`
    /// and `continue`, both clear.
    pub(super) fn unroll(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        flags: LoopFlags,
    ) -> Result<bool> {
        // The probe of a pixel shows the names of one iteration. Loops in loops would multiply the time of lowering.
        if self.named_values.is_some() || !self.open_loops.is_empty() {
            return Ok(false);
        }
        let start_env = self.env.clone();
        let first_step = self.builder.lane_steps.len();
        let was_directly_in_loop = std::mem::replace(&mut self.is_directly_in_loop, false);
        self.builder.open_region();
        let count = self.iteration_count(body, continuing)?;
        self.env.clone_from(&start_env);
        // The removed steps must not be found as earlier computations.
        self.builder.lane_steps.truncate(first_step);
        self.builder.close_region();
        self.builder.open_region();
        let is_unrolled = if let Some(count) = count {
            self.frame_mut().loops.push(flags);
            // No exit from this loop is a jump, and none belongs to the loop around it.
            let iteration_start = (Vec::new(), usize::MAX);
            let exit = self.builder.fresh_label();
            self.open_loops.push(OpenLoop { exit, variables: Vec::new(), exit_envs: Vec::new(), iteration_start });
            let is_unrolled = self.iterations(body, continuing, break_if, flags, MAX_UNROLLED_STEPS / count.max(1));
            self.open_loops.pop();
            self.frame_mut().loops.pop();
            is_unrolled?
        } else {
            false
        };
        self.is_directly_in_loop = was_directly_in_loop;
        if is_unrolled {
            self.builder.keep_region();
            return Ok(true);
        }
        self.builder.close_region();
        self.builder.lane_steps.truncate(first_step);
        self.env = start_env;
        Ok(false)
    }

    /// The number of iterations of a `for` loop, if it is known and at most [`MAX_ITERATIONS`], found by lowering only the condition with which the body begins
    /// and the `continuing` block. It is an estimate, because the rest of the body may change the counter, too. Changes steps and environment.
    fn iteration_count(&mut self, body: &'m Block, continuing: &'m Block) -> Result<Option<usize>> {
        for count in 0..=MAX_ITERATIONS {
            let mut side = None;
            for statement in body.iter() {
                match statement {
                    Statement::Emit(_) => self.statement(statement)?,
                    Statement::If { condition, accept, reject } => {
                        let cond = self.scalar_of(*condition)?;
                        side = self.builder.known_bool(cond).map(|cond| if cond { accept } else { reject });
                        break;
                    }
                    _ => break,
                }
            }
            match side.map(|side| side.first()) {
                None => return Ok(None),
                Some(Some(Statement::Break)) => return Ok(Some(count)),
                Some(_) => self.block(continuing)?,
            }
        }
        Ok(None)
    }

    /// Lowers iterations until all lanes have left the loop; returns false if it is unknown whether they have, or if an iteration
    /// has more than `max_steps` steps or reads a texture.
    fn iterations(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        LoopFlags { break_flag, continue_flag }: LoopFlags,
        max_steps: usize,
    ) -> Result<bool> {
        let no = self.builder.bool(false);
        // The last pass only finds that the condition fails.
        for _ in 0..=MAX_ITERATIONS {
            let first_step = self.builder.lane_steps.len();
            // The loops in one iteration may change less than those in another.
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
            // Reads of textures take far longer than the loop's own steps.
            let iteration = &self.builder.lane_steps[first_step..];
            if iteration.len() > max_steps || iteration.iter().any(|step| matches!(step, SsaStep::Texture { .. })) {
                return Ok(false);
            }
        }
        Ok(false)
    }
}
