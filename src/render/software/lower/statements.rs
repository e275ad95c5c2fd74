//! Lowers the statements of a block in order.
//!
//! In: a block of naga's IR. Out: SSA instructions, the environment after them, and the flags in it. An exit from a block (`return`, `break`, `continue`) sets
//! its flag, in all lanes or in some; the rest of the block is then lowered as if it were inside `if (!flag)`. Therefore no single store needs to test the
//! flag, and the rest is skipped if no lane is active any more. An exit from a loop that all lanes take together may be a jump instead. Not here
//! (`control_flow.rs`): this jump, an `if` with one side (`conditional`) and with two (`branch`), `switch` and loops. A `frame` is that of a function call
//! (`CallFrame`), not an image.

use super::error::Result;
use super::lowerer::{DISCARDED_INDEX, Lowerer};
use super::ssa::SsaValue;
use crate::render::software::tape::Op;
use naga::{Block, Span, Statement};

impl<'m> Lowerer<'m> {
    /// The mask of the lanes that `return`, `break` or `continue` took out of the block that is being lowered.
    pub(super) fn exited_mask(&mut self) -> SsaValue {
        let frame = self.frame();
        let (return_flag, innermost_loop) = (frame.return_flag, frame.loop_flags.last().copied());
        let mut exited = self.env[return_flag];
        if let Some(flags) = innermost_loop {
            exited = self.builder.binary(Op::Or, exited, self.env[flags.break_flag]);
            exited = self.builder.binary(Op::Or, exited, self.env[flags.continue_flag]);
        }
        exited
    }

    /// Clears the flags of `return` and of the innermost loop's `break` and `continue`, before code is lowered for the lanes that have not exited.
    pub(super) fn clear_flags(&mut self) {
        let no = self.builder.bool(false);
        let frame = self.frame();
        let innermost_loop = frame.loop_flags.last();
        let flags = [Some(frame.return_flag), innermost_loop.map(|l| l.break_flag), innermost_loop.map(|l| l.continue_flag)];
        for flag in flags.into_iter().flatten() {
            self.env[flag] = no;
        }
    }

    pub(super) fn block(&mut self, block: &'m Block) -> Result<()> {
        let statements: Vec<(&'m Statement, Span)> = block.span_iter().map(|(s, span)| (s, *span)).collect();
        self.in_block(|this| this.statements(&statements))
    }

    /// Lowers statements in order. After one that some lanes may exit from, the rest is lowered for the remaining lanes only.
    fn statements(&mut self, statements: &[(&'m Statement, Span)]) -> Result<()> {
        for (i, (statement, span)) in statements.iter().enumerate() {
            self.span = *span;
            self.count_statement_and_check_limits()?;
            let discarded_before = self.env[DISCARDED_INDEX];
            self.statement(statement)?;
            let rest = &statements[i + 1..];
            let may_exit = matches!(
                statement,
                Statement::If { .. }
                    | Statement::Switch { .. }
                    | Statement::Loop { .. }
                    | Statement::Block(_)
                    | Statement::Break
                    | Statement::Continue
                    | Statement::Return { .. }
            );
            let exited = if may_exit { self.exited_mask() } else { self.builder.bool(false) };
            match self.builder.known_bool(exited) {
                Some(true) => return Ok(()),
                Some(false) => {
                    // Lanes that this statement discarded leave the block, too, unless the rest needs them for a derivative, or a loop is open, which
                    // they would never leave (`can_skip_discarded`).
                    if self.env[DISCARDED_INDEX] != discarded_before && self.can_skip_discarded(rest) {
                        let remaining = self.builder.not(self.env[DISCARDED_INDEX]);
                        return self.conditional(remaining, |this| this.statements(rest));
                    }
                    continue;
                }
                None => {}
            }
            if rest.is_empty() {
                return Ok(());
            }
            // At the top level of a loop's body (`may_exit_by_jump`) an exit that all lanes take together becomes a jump out of the loop; but not if it may be
            // a `continue`, after which the `continuing` block still runs.
            if self.may_exit_by_jump && !matches!(exited, SsaValue::Lane(_)) && !self.continue_flag_may_be_set() {
                self.leave_loop_if(exited);
                continue;
            }
            let remaining = self.builder.not(exited);
            // Where a jump goes if no lane remains: behind the loop, if this iteration has changed no variable; otherwise (`None`) past the rest of the block.
            let loop_exit = self.loop_exit_if_nothing_changed();
            return self.conditional_or_jump(remaining, loop_exit, |this| {
                // The flags are clear in the remaining lanes. The merge at the end keeps the flags of the other lanes.
                this.clear_flags();
                this.statements(rest)
            });
        }
        Ok(())
    }

    pub(super) fn statement(&mut self, statement: &'m Statement) -> Result<()> {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    let value = self.evaluate(handle)?;
                    // For the probe of a pixel.
                    self.capture_if_named(handle, &value)?;
                    self.frame_mut().values.insert(handle, value);
                }
                Ok(())
            }
            Statement::Block(b) => self.block(b),
            Statement::If { condition, accept, reject } => {
                let cond = self.scalar_of(*condition)?;
                self.branch(cond, |this| this.block(accept), |this| this.block(reject))
            }
            Statement::Switch { selector, cases } => self.switch(*selector, cases),
            Statement::Loop { body, continuing, break_if } => self.lower_loop(body, continuing, *break_if),
            Statement::Break | Statement::Continue => {
                let yes = self.builder.bool(true);
                let flags = self.frame().loop_flags.last().copied();
                let flags = flags.ok_or_else(|| self.unsupported("break or continue outside of a loop".into()))?;
                self.env[if matches!(statement, Statement::Break) { flags.break_flag } else { flags.continue_flag }] = yes;
                Ok(())
            }
            Statement::Return { value } => {
                if let Some(v) = value {
                    let scalars = self.scalars_of(*v)?;
                    let first = self.frame().result_start;
                    self.env[first..first + scalars.len()].copy_from_slice(&scalars);
                }
                let yes = self.builder.bool(true);
                let flag = self.frame().return_flag;
                self.env[flag] = yes;
                Ok(())
            }
            Statement::Kill => {
                self.env[DISCARDED_INDEX] = self.builder.bool(true);
                Ok(())
            }
            Statement::Store { pointer, value } => {
                let place = self.place_of(*pointer)?;
                let scalars = self.scalars_of(*value)?;
                self.store(&place, &scalars)
            }
            Statement::Call { function, arguments, result } => self.call_statement(statement, *function, arguments, *result),
            other => {
                let name = format!("{other:?}");
                let name = name.split([' ', '(', '{']).next().unwrap_or_default().to_owned();
                Err(self.unsupported(format!("statement {name} is not supported")))
            }
        }
    }
}
