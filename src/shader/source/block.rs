//! Blocks of a fragment (WESL file): parts of its text that are included or omitted together, by one condition.
//!
//! Blocks form a tree: the scanner lists them in the order of the text, and each refers to others by their index. [`ROOT`] is the part
//! without a condition.

use super::condition::Condition;

/// Index of the block that every module has.
pub const ROOT: u32 = 0;

/// The condition under which a part of the text is emitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    Root,
    /// A branch of a chain of `@if`, `@elif` and `@else`: emitted as part of `parent` if its condition holds and that of no branch before it does.
    /// `unless`: the branch before it in the chain.
    When {
        parent: u32,
        condition: Condition,
        unless: Option<u32>,
    },
    /// Emitted if any of these blocks is; used for the comments above a chain.
    AnyOf(Vec<u32>),
}
