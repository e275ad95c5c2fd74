//! Blocks of a fragment (WESL file): parts of its text that are included or omitted together, by one condition.
//!
//! The scanner lists blocks in the order of the text; each refers to others by their index. By `parent`, the branches of chains form a tree, whose root,
//! [`ROOT`], is the part without a condition.

use super::condition::Condition;

/// Index of the block that every module has.
pub const ROOT: u32 = 0;

/// One block: the condition under which its part of the text is emitted. The numbers are indices of blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    /// Always emitted.
    Root,
    /// A branch of a chain of `@if`, `@elif` and `@else`: emitted if `parent` is emitted, its own condition holds, and the condition of no earlier branch of
    /// the chain holds. `previous_branch`: the branch directly before it.
    When { parent: u32, condition: Condition, previous_branch: Option<u32> },
    /// The comments above a chain: emitted if any branch of the chain is. The numbers are the branches.
    AnyOf(Vec<u32>),
}
