//! Caches of slow, smooth functions of time.
//!
//! [`GridCache`] stores values by an index, that of a node or of an interval of the caller's grid. [`TimeGrid`] gives values at the nodes of its own grid, from
//! which the caller interpolates or extrapolates.
//!
//! In: a key, an instant, the function. Out ([`TimeGrid`]): the values at the two nodes around the instant and the weight of the later one, or the value at the
//! nearest node and the seconds from this node to the instant. Always: the nodes are multiples of one step from J2000, so that a result does not depend on
//! earlier calls. A frame asks for a planet's moons at dozens of instants, which differ only by light times within the system. These instants share a few
//! nodes, and later frames of the same instant reuse them. Not here: the check of instants. Callers exclude instants that are not finite, or so far away that
//! the index of a node would overflow.

use parking_lot::Mutex;
use rustc_hash::FxHashMap;
use std::fmt;
use std::hash::Hash;

/// Largest number of values that a [`TimeGrid`] stores, of all keys together.
const MAX_VALUES: usize = 4096;

/// Values by key, such as a body, and by the index of the node or interval.
pub(crate) struct GridCache<K, V> {
    values: Mutex<FxHashMap<(K, i64), V>>,
    capacity: usize,
}

impl<K: Copy + Eq + Hash, V: Clone> GridCache<K, V> {
    /// `capacity`: largest number of values; a full cache is emptied before the next value is stored.
    pub(crate) fn with_capacity(capacity: usize) -> Self {
        Self { values: Mutex::default(), capacity }
    }

    /// The stored value; if there is none, the result of `compute`, which is then stored.
    pub(crate) fn get(&self, key: K, index: i64, compute: impl FnOnce() -> V) -> V {
        let stored = self.values.lock().get(&(key, index)).cloned();
        stored.unwrap_or_else(|| {
            // Computed without the lock, so that other threads are not blocked. Two threads may compute the same value; both get the same result.
            let value = compute();
            let mut values = self.values.lock();
            if values.len() >= self.capacity {
                values.clear();
            }
            values.insert((key, index), value.clone());
            value
        })
    }
}

impl<K, V> GridCache<K, V> {
    /// Number of stored values.
    pub(crate) fn len(&self) -> usize {
        self.values.lock().len()
    }
}

impl<K, V> fmt::Debug for GridCache<K, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "GridCache({} of {})", self.len(), self.capacity)
    }
}

/// Values by key at the nodes of a grid: multiples of one step from J2000.
#[derive(Debug)]
pub(crate) struct TimeGrid<K, V> {
    step_s: f64,
    nodes: GridCache<K, V>,
}

impl<K: Copy + Eq + Hash, V: Clone> TimeGrid<K, V> {
    /// `step_s`: the spacing of the nodes in seconds.
    pub(crate) fn new(step_s: f64) -> Self {
        Self { step_s, nodes: GridCache::with_capacity(MAX_VALUES) }
    }

    /// The value at the nearest node, and the seconds from this node to the instant `tdb_s`. `tdb_s` and the argument of `compute`: TDB seconds past J2000.
    pub(crate) fn nearest(&self, key: K, tdb_s: f64, compute: impl FnOnce(f64) -> V) -> (V, f64) {
        let node_index = (tdb_s / self.step_s).round();
        let node_s = node_index * self.step_s;
        (self.nodes.get(key, node_index as i64, || compute(node_s)), tdb_s - node_s)
    }

    /// The values at the nodes before and after the instant `tdb_s`, and the weight of the later one, 0 to 1. Arguments: as in [`Self::nearest`].
    pub(crate) fn values_around(&self, key: K, tdb_s: f64, compute: impl Fn(f64) -> V) -> ([V; 2], f64) {
        let steps = tdb_s / self.step_s;
        let first = steps.floor();
        ([first, first + 1.0].map(|index| self.nodes.get(key, index as i64, || compute(index * self.step_s))), steps - first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn each_node_is_computed_once_and_results_do_not_depend_on_order() {
        let evaluations = AtomicU32::new(0);
        let square = |s: f64| {
            evaluations.fetch_add(1, Ordering::Relaxed);
            s * s
        };
        let interpolated = |grid: &TimeGrid<u8, f64>, s: f64| {
            let ([a, b], weight) = grid.values_around(0, s, square);
            a + (b - a) * weight
        };
        let times = [0.0, 1.0, 7.9, 8.0, 9.5, -3.0, -8.0, 1e9 + 3.0];
        let (forward, backward) = (TimeGrid::new(8.0), TimeGrid::new(8.0));
        let values: Vec<f64> = times.iter().map(|s| interpolated(&forward, *s)).collect();
        assert_eq!(evaluations.load(Ordering::Relaxed), 6, "the nodes -8, 0, 8, 16 and two far away");
        let reversed: Vec<f64> = times.iter().rev().map(|s| interpolated(&backward, *s)).collect();
        assert!(values.iter().eq(reversed.iter().rev()));
        for (s, value) in times.iter().zip(&values) {
            // The step is 8, so a chord of the parabola s² is at most 8²/4 = 16 above it. Not for s = 1e9: near s² = 1e18, rounding alone exceeds 16.
            assert!((-1e-3..=16.0 + 1e-3).contains(&(value - s * s)) || s.abs() > 1e6, "{s}: {value}");
        }
        // Another key has its own values: two more evaluations, after six by each grid.
        forward.values_around(1, 0.0, square);
        assert_eq!(evaluations.load(Ordering::Relaxed), 14);
        // Instants ten steps apart share no nodes, so the capacity is exceeded.
        for k in 0..=MAX_VALUES {
            forward.values_around(2, k as f64 * 80.0, square);
        }
        assert!(forward.nodes.len() <= MAX_VALUES);
    }
}
