//! A cache of slow, smooth functions of time: their values at the nodes of a fixed grid, between which the caller interpolates.
//!
//! In: a key, an instant, the function. Out: its values at the two nodes around the instant, and the weight of the later one. Always: the nodes are multiples
//! of one step from J2000, so that a result does not depend on earlier calls. A frame asks for a planet's moons at dozens of instants that are light-seconds
//! apart: they share a few nodes, and the frames that follow at the same time need no others.

use parking_lot::Mutex;
use std::collections::HashMap;
use std::fmt;
use std::hash::Hash;

/// Largest number of cached values; when it is exceeded, all are dropped.
const MAX_NODES: usize = 4096;

pub(crate) struct TimeGrid<K, V> {
    step_s: f64,
    nodes: Mutex<HashMap<(K, i64), V>>,
}

impl<K: Copy + Eq + Hash, V: Clone> TimeGrid<K, V> {
    /// `step_s`: the distance of two nodes.
    pub(crate) fn new(step_s: f64) -> Self {
        Self { step_s, nodes: Mutex::default() }
    }

    /// The values at the nodes before and after an instant, and the weight of the second. `compute` gets TDB seconds past J2000.
    pub(crate) fn around(&self, key: K, tdb_s: f64, compute: impl Fn(f64) -> V) -> ([V; 2], f64) {
        let steps = tdb_s / self.step_s;
        let first = steps.floor();
        ([first, first + 1.0].map(|node| self.at_node((key, node as i64), node * self.step_s, &compute)), steps - first)
    }

    fn at_node(&self, key: (K, i64), tdb_s: f64, compute: &impl Fn(f64) -> V) -> V {
        let known = self.nodes.lock().get(&key).cloned();
        known.unwrap_or_else(|| {
            // Computed without the lock: two threads that compute the same node get the same numbers.
            let value = compute(tdb_s);
            let mut nodes = self.nodes.lock();
            if nodes.len() >= MAX_NODES {
                nodes.clear();
            }
            nodes.insert(key, value.clone());
            value
        })
    }
}

impl<K, V> fmt::Debug for TimeGrid<K, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "TimeGrid({} nodes of {} s)", self.nodes.lock().len(), self.step_s)
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
        let at = |grid: &TimeGrid<u8, f64>, s: f64| {
            let ([a, b], weight) = grid.around(0, s, square);
            a + (b - a) * weight
        };
        let times = [0.0, 1.0, 7.9, 8.0, 9.5, -3.0, -8.0, 1e9 + 3.0];
        let (forward, backward) = (TimeGrid::new(8.0), TimeGrid::new(8.0));
        let states: Vec<f64> = times.iter().map(|s| at(&forward, *s)).collect();
        assert_eq!(evaluations.load(Ordering::Relaxed), 6, "the nodes -8, 0, 8, 16 and two far away");
        let reversed: Vec<f64> = times.iter().rev().map(|s| at(&backward, *s)).collect();
        assert!(states.iter().eq(reversed.iter().rev()));
        for (s, value) in times.iter().zip(&states) {
            // A chord of a parabola is at most a quarter of the squared step above it.
            assert!((-1e-3..=16.0 + 1e-3).contains(&(value - s * s)) || s.abs() > 1e6, "{s}: {value}");
        }
        // Another key has its own values.
        forward.around(1, 0.0, square);
        assert_eq!(evaluations.load(Ordering::Relaxed), 14);
        for k in 0..=MAX_NODES {
            forward.around(2, k as f64 * 80.0, square);
        }
        assert!(forward.nodes.lock().len() <= MAX_NODES);
    }
}
