//! What is dear to make and the same from frame to frame, kept by a digest of what it is made from.
//!
//! In: the digest's numbers and how to make it. Out: the kept value, made once. Always: a handful is kept, the oldest goes first; one is made at
//! a time, so that two frames never make the same. Not for what changes with every frame.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Mutex, PoisonError};

/// Values kept: those of each ringed body at a few heights of the Sun.
const MOST: usize = 16;

pub(super) struct Kept<T>(Mutex<Vec<(u64, T)>>);

impl<T: Clone> Kept<T> {
    pub const fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// The value that these numbers make.
    pub fn get(&self, numbers: impl IntoIterator<Item = f64>, make: impl FnOnce() -> T) -> T {
        let mut hash = DefaultHasher::new();
        numbers.into_iter().for_each(|v| v.to_bits().hash(&mut hash));
        let name = hash.finish();
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = held.iter().find(|(n, _)| *n == name) {
            return found.clone();
        }
        let made = make();
        if held.len() >= MOST {
            held.remove(0);
        }
        held.push((name, made.clone()));
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_and_the_oldest_goes() {
        static KEPT: Kept<usize> = Kept::new();
        let mut made = 0;
        let mut ask = |n: usize| {
            let value = KEPT.get([n as f64, 0.5], || {
                made += 1;
                n
            });
            assert_eq!(value, n);
            made
        };
        assert_eq!((ask(1), ask(1), ask(2)), (1, 1, 2));
        for n in 3..=MOST + 1 {
            ask(n);
        }
        assert_eq!(ask(2), MOST + 1, "still kept");
        assert_eq!(ask(1), MOST + 2, "made anew");
    }
}
