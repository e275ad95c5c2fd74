//! Small caches of values that are expensive to compute: [`Memo`], a FIFO cache that computes a missing value itself, and [`LruMap`], an LRU cache.
//!
//! In: a key (and for [`Memo`] a function that computes its value). Out: the value. Always: keys are compared, not only their hashes; the number of
//! values is limited, and [`Memo`] drops the oldest first, [`LruMap`] the least recently used. While one thread computes a value of a [`Memo`], other
//! threads wait only if they need the same key. There is no process-wide cache: each lives as long as its owner.

use parking_lot::Mutex;
use std::collections::{HashMap, VecDeque};
use std::fmt;
use std::hash::Hash;
use std::sync::{Arc, OnceLock};

/// Keys, each with a cell for its value, oldest first. A cell is empty while its value is computed.
type Entries<K, V> = VecDeque<(K, Arc<OnceLock<V>>)>;

/// A FIFO cache of values by key, shared by threads.
pub(crate) struct Memo<K, V> {
    entries: Mutex<Entries<K, V>>,
    capacity: usize,
}

impl<K, V: Clone> Memo<K, V> {
    /// `capacity`: largest number of values.
    pub(crate) fn with_capacity(capacity: usize) -> Self {
        Self { entries: Mutex::new(VecDeque::new()), capacity }
    }

    /// The value of a cached key that is usable for `key`; if there is none, the value of `key` itself, which `make` computes. `is_usable_for` receives the
    /// cached key and the requested one.
    pub(crate) fn get_compatible(&self, is_usable_for: impl Fn(&K, &K) -> bool, key: K, make: impl FnOnce() -> V) -> V {
        let entry = {
            let mut entries = self.entries.lock();
            let found = entries.iter().find(|(cached_key, _)| is_usable_for(cached_key, &key)).map(|(_, entry)| Arc::clone(entry));
            found.unwrap_or_else(|| {
                while entries.len() >= self.capacity.max(1) {
                    entries.pop_front();
                }
                let entry = Arc::default();
                entries.push_back((key, Arc::clone(&entry)));
                entry
            })
        };
        entry.get_or_init(make).clone()
    }
}

impl<K: PartialEq, V: Clone> Memo<K, V> {
    /// The value of a key; `make` computes it if it is not cached.
    pub(crate) fn get(&self, key: K, make: impl FnOnce() -> V) -> V {
        self.get_compatible(|cached_key, requested_key| cached_key == requested_key, key, make)
    }
}

impl<K, V> fmt::Debug for Memo<K, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.entries.lock().len();
        write!(f, "Memo({count} of {})", self.capacity)
    }
}

/// An LRU cache: a map of limited size in which a new entry replaces the least recently used one.
#[derive(Debug)]
pub(crate) struct LruMap<K, V> {
    /// Values, each with the number that `uses` had after the value's last use.
    entries: HashMap<K, (V, u64)>,
    /// Number of uses of any entry so far.
    uses: u64,
    capacity: usize,
}

impl<K: Eq + Hash + Clone, V: Clone> LruMap<K, V> {
    /// `capacity`: largest number of entries.
    pub(crate) fn with_capacity(capacity: usize) -> Self {
        Self { entries: HashMap::new(), uses: 0, capacity }
    }

    /// The value of a key. Counts as a use.
    pub(crate) fn get(&mut self, key: &K) -> Option<V> {
        self.uses += 1;
        let (value, last_use) = self.entries.get_mut(key)?;
        *last_use = self.uses;
        Some(value.clone())
    }

    /// The value of a key. Does not count as a use.
    pub(crate) fn peek(&self, key: &K) -> Option<&V> {
        self.entries.get(key).map(|(value, _)| value)
    }

    /// Sets the value of a key. Counts as a use.
    pub(crate) fn insert(&mut self, key: K, value: V) {
        if self.entries.len() >= self.capacity && !self.entries.contains_key(&key) {
            let least_recent = self.entries.iter().min_by_key(|(_, (_, last_use))| *last_use).map(|(key, _)| key.clone());
            least_recent.map(|key| self.entries.remove(&key));
        }
        self.uses += 1;
        self.entries.insert(key, (value, self.uses));
    }

    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }
}

/// A key that consists of numbers, compared bit by bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NumbersKey(Vec<u64>);

impl FromIterator<f64> for NumbersKey {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        Self(numbers.into_iter().map(f64::to_bits).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_value_is_computed_once_and_the_oldest_is_dropped() {
        const CAPACITY: usize = 4;
        let memo = Memo::with_capacity(CAPACITY);
        let mut computed = 0;
        // The number of values computed so far, after a request for the value of `n`.
        let mut computed_after = |n: usize| {
            let value = memo.get(n, || {
                computed += 1;
                10 * n
            });
            assert_eq!(value, 10 * n);
            computed
        };
        assert_eq!((computed_after(1), computed_after(1), computed_after(2)), (1, 1, 2));
        for n in 3..=CAPACITY + 1 {
            computed_after(n);
        }
        assert_eq!(computed_after(2), CAPACITY + 1, "still kept");
        assert_eq!(computed_after(1), CAPACITY + 2, "computed anew");
    }

    #[test]
    fn a_new_entry_replaces_the_least_recently_used_one() {
        let mut recent = LruMap::with_capacity(3);
        for n in 1..=3 {
            recent.insert(n, 10 * n);
        }
        assert_eq!((recent.get(&1), recent.peek(&2)), (Some(10), Some(&20)));
        recent.insert(4, 40);
        assert_eq!([1, 2, 3, 4].map(|n| recent.get(&n)), [Some(10), None, Some(30), Some(40)], "a peek does not count as a use");
        recent.insert(1, 11);
        assert_eq!([1, 3, 4].map(|n| recent.get(&n)), [Some(11), Some(30), Some(40)], "a new value of a known key evicts nothing");
        recent.clear();
        assert_eq!(recent.get(&1), None);
    }

    #[test]
    fn a_compatible_key_is_reused() {
        let memo: Memo<f64, f64> = Memo::with_capacity(4);
        let near = |cached_key: &f64, requested_key: &f64| (cached_key - requested_key).abs() < 0.1;
        assert_eq!(memo.get_compatible(near, 1.0, || 1.0), 1.0);
        assert_eq!(memo.get_compatible(near, 1.05, || 1.05), 1.0);
        assert_eq!(memo.get_compatible(near, 1.2, || 1.2), 1.2);
    }

    /// The computation of a value may request another value; if a lock were held meanwhile, this would deadlock.
    #[test]
    fn other_keys_are_available_while_a_value_is_computed() {
        let (memo, computed) = (Memo::with_capacity(4), AtomicUsize::new(0));
        let value = memo.get(1, || {
            computed.fetch_add(1, Ordering::SeqCst);
            memo.get(2, || 20) + 1
        });
        assert_eq!((value, computed.into_inner()), (21, 1));
        std::thread::scope(|scope| {
            let all: Vec<_> = (0..8)
                .map(|k| {
                    scope.spawn({
                        let memo = &memo;
                        move || memo.get(3, || k)
                    })
                })
                .collect();
            let answers: Vec<i32> = all.into_iter().map(|t| t.join().expect("answers")).collect();
            assert!(answers.windows(2).all(|w| w[0] == w[1]), "the threads got different values: {answers:?}");
        });
    }

    #[test]
    fn number_keys_differ_if_any_bit_differs() {
        let key = |v: &[f64]| v.iter().copied().collect::<NumbersKey>();
        assert_eq!(key(&[1.0, 0.5]), key(&[1.0, 0.5]));
        assert!(key(&[0.0]) != key(&[-0.0]) && key(&[1.0]) != key(&[1.0, 0.0]));
    }
}
