//! Blocks of a fragment: parts of its text that are included or omitted together, by one condition.
//!
//! In: blocks from the scanner, in the order of the text. Out: a tree by index; [`ROOT`] is the part without a condition.

use super::condition::Condition;

/// The block that every module has.
pub const ROOT: u32 = 0;

/// The condition under which a part of the text is emitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    Root,
    /// A branch of a chain of `@if`, `@elif` and `@else`: emitted as part of `parent` if its condition holds and that of no branch before it does.
    /// `unless`: the previous branch of the chain.
    When {
        parent: u32,
        condition: Condition,
        unless: Option<u32>,
    },
    /// Emitted if any of these blocks is; used for the comments above a chain.
    AnyOf(Vec<u32>),
}
