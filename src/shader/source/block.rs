//! Blocks of a fragment: the parts that stand or fall together by one condition.
//!
//! In: the scanner fills them in the order of the text. Out: a tree by index; [`ROOT`] is the part without a condition.

use super::condition::Condition;

/// The block that every module has.
pub const ROOT: u32 = 0;

/// What decides whether a piece of text is emitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    Root,
    /// Emitted inside `parent` where the condition holds and none of the alternatives before it did.
    When {
        parent: u32,
        condition: Condition,
        unless: Option<u32>,
    },
    /// Emitted where any of these is: the comments above a chain of alternatives.
    AnyOf(Vec<u32>),
}
