//! Libraries on bytes from outside: a panic in one of them is an answer here.
//!
//! In: a call into a library that reads what may be forged. Out: what it returns, or nothing where it panics. Always: such a panic prints nothing. Own code has no need of this.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
}

/// What `read` answers; `None`: it panicked. What it had in hand is gone with it.
pub fn caught<T>(read: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = take_hook();
        set_hook(Box::new(move |about| {
            if !IS_QUIET.get() {
                usual(about);
            }
        }));
    });
    let before = IS_QUIET.replace(true);
    let answer = catch_unwind(AssertUnwindSafe(read)).ok();
    IS_QUIET.set(before);
    answer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_answer_and_what_follows_is_as_before() {
        let lengths: [&[u8]; 2] = [&[1], &[]];
        assert_eq!(lengths.map(|bytes| caught(|| bytes[0])), [Some(1), None]);
        assert!(!IS_QUIET.get());
        // One inside another leaves the outer one quiet.
        assert_eq!(caught(|| (caught(|| lengths[1][0]), IS_QUIET.get())), Some((None, true)));
    }
}
