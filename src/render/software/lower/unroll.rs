//! Unrolls loops whose number of iterations is known when the module is lowered, so that what depends only on the loop's counter runs once per draw.
//!
//! In: a loop, and the environment before it. Out: its iterations one after the other, and the environment after them; or nothing, if the number of iterations
//! is unknown or the steps would be too many (the loop then remains a loop, `control_flow.rs`). Not here: the doubling of loops when a program is bound to
//! kernels (`exec/unroll_loops.rs`).

use super::error::Result;
use super::lowerer::{LoopFlags, Lowerer, OpenLoop};
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
        // The probe of a pixel shows the names of one iteration.
        if self.named_values.is_some() {
            return Ok(false);
        }
        let start_env = self.env.clone();
        let first_step = self.builder.lane_steps.len();
        let was_directly_in_loop = std::mem::replace(&mut self.is_directly_in_loop, false);
        self.builder.open_region();
        let is_unrolled = self.first_condition_is_known(body)? && {
            self.frame_mut().loops.push(flags);
            // No exit from this loop is a jump, and none belongs to the loop around it.
            let iteration_start = (Vec::new(), usize::MAX);
            let exit = self.builder.fresh_label();
            self.open_loops.push(OpenLoop { exit, variables: Vec::new(), exit_envs: Vec::new(), iteration_start });
            let is_unrolled = self.iterations(body, continuing, break_if, flags, first_step);
            self.open_loops.pop();
            self.frame_mut().loops.pop();
            is_unrolled?
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

    /// Whether the condition of the branch with which the body begins, as it does in a `for` loop, is known before the first iteration. Leaves steps behind.
    fn first_condition_is_known(&mut self, body: &'m Block) -> Result<bool> {
        for statement in body.iter() {
            match statement {
                Statement::Emit(_) => self.statement(statement)?,
                Statement::If { condition, .. } => {
                    let cond = self.scalar_of(*condition)?;
                    return Ok(self.builder.known_bool(cond).is_some());
                }
                _ => return Ok(false),
            }
        }
        Ok(false)
    }

    /// Lowers iterations until all lanes have left the loop; returns false if it is unknown whether they have.
    fn iterations(
        &mut self,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
        LoopFlags { break_flag, continue_flag }: LoopFlags,
        first_step: usize,
    ) -> Result<bool> {
        let no = self.builder.bool(false);
        // The last pass only finds that the condition fails.
        for _ in 0..=MAX_ITERATIONS {
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
            if self.builder.lane_steps.len() > first_step + MAX_UNROLLED_STEPS {
                return Ok(false);
            }
        }
        Ok(false)
    }
}
