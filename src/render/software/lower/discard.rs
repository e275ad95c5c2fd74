//! Decides whether the statements after a `discard` need to run for discarded lanes.
//!
//! In: the statements of a block after the `discard`. Out: whether they may be lowered for the remaining lanes only, so that no texture is read for discarded
//! lanes, and a batch without remaining lanes skips the statements. They must run for all lanes inside a loop or `switch`, or if they compute a derivative,
//! which needs the values of discarded lanes (as helper invocations on a GPU).

use super::lowerer::{DISCARDED_INDEX, Lowerer};
use super::ssa::SsaValue;
use naga::valid::UniformityRequirements;
use naga::{Block, Expression, SampleLevel, Span, Statement};

impl<'m> Lowerer<'m> {
    /// Whether `rest`, the statements after a `discard`, may run for the remaining lanes only. Never inside a loop or `switch`, because
    /// discarded lanes would not leave a loop.
    pub(crate) fn can_skip_discarded(&self, rest: &[(&'m Statement, Span)]) -> bool {
        // Only a mask that can differ between lanes is worth a condition.
        matches!(self.env[DISCARDED_INDEX], SsaValue::Lane(_))
            && !rest.is_empty()
            && self.frames.iter().all(|f| f.loop_flags.is_empty())
            && !rest.iter().any(|(s, _)| self.uses_derivatives(s))
    }

    fn uses_derivatives(&self, statement: &Statement) -> bool {
        let block_uses_derivatives = |block: &Block| block.iter().any(|s| self.uses_derivatives(s));
        match statement {
            Statement::Emit(range) => range.clone().any(|handle| {
                matches!(
                    self.frame().function.expressions[handle],
                    Expression::Derivative { .. } | Expression::ImageSample { level: SampleLevel::Auto | SampleLevel::Bias(_), .. }
                )
            }),
            Statement::Call { function, .. } => {
                let derivatives = UniformityRequirements::DERIVATIVE | UniformityRequirements::IMPLICIT_LEVEL;
                self.info[*function].uniformity.requirements.intersects(derivatives)
            }
            Statement::Block(block) => block_uses_derivatives(block),
            Statement::If { accept, reject, .. } => block_uses_derivatives(accept) || block_uses_derivatives(reject),
            Statement::Switch { cases, .. } => cases.iter().any(|c| block_uses_derivatives(&c.body)),
            Statement::Loop { body, continuing, .. } => block_uses_derivatives(body) || block_uses_derivatives(continuing),
            _ => false,
        }
    }
}
