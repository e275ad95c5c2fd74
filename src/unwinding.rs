//! Catches panics of libraries that read untrusted bytes.
//!
//! In: a closure that passes untrusted bytes to a library. Out: its result, or `None` if it panics. Always: a panic on the calling thread prints nothing. A
//! closure contains as little code of this crate as possible, because panics of that code are hidden, too.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether panics of this thread print nothing.
    static IS_QUIET: Cell<bool> = const { Cell::new(false) };
}

/// The result of `read`; `None` if it panicked. After a panic, values that `read` owned have been dropped. Values that it borrowed mutably may be half changed:
/// the caller must not use them.
pub(crate) fn catch_panic<T>(read: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let earlier_hook = take_hook();
        set_hook(Box::new(move |info| {
            if !IS_QUIET.get() {
                earlier_hook(info);
            }
        }));
    });
    let was_quiet = IS_QUIET.replace(true);
    let result = catch_unwind(AssertUnwindSafe(read)).ok();
    IS_QUIET.set(was_quiet);
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_caught_and_later_panics_print_again() {
        let inputs: [&[u8]; 2] = [&[1], &[]];
        assert_eq!(inputs.map(|bytes| catch_panic(|| bytes[0])), [Some(1), None]);
        assert!(!IS_QUIET.get());
        // A nested call leaves the outer one quiet.
        assert_eq!(catch_panic(|| (catch_panic(|| inputs[1][0]), IS_QUIET.get())), Some((None, true)));
    }
}
