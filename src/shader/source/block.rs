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
    /// Emitted as part of `parent` if the condition holds and none of the preceding alternatives does.
    When {
        parent: u32,
        condition: Condition,
        unless: Option<u32>,
    },
    /// Emitted if any of these blocks is; used for the comments above a chain of alternatives.
    AnyOf(Vec<u32>),
}
