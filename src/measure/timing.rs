//! Compares the times of workloads by alternating runs, so that other work on the machine affects all of them alike.
//!
//! In: repeatable workloads. Out: the results of each workload by round; the quartiles of the ratios of two workloads' times. Always: each round runs
//! every workload once, in an order that changes from round to round, so that warm-up and throttling affect all of them equally, too; only times
//! from the same round are divided by each other. Times are CPU time where the system reports it, elapsed time elsewhere.

use crate::session::process_cpu;
use std::time::{Duration, Instant};

/// A workload to be timed; its error ends the measurement.
pub(crate) type Workload<'a, T, E> = dyn Fn() -> Result<T, E> + 'a;

/// Runs every workload once per round. Returns the results by workload, then by round.
///
/// # Errors
/// The first error of a workload.
pub(crate) fn interleaved<T, E>(rounds: usize, workloads: &[&Workload<'_, T, E>]) -> Result<Vec<Vec<T>>, E> {
    let mut results: Vec<Vec<T>> = workloads.iter().map(|_| Vec::with_capacity(rounds)).collect();
    let count = workloads.len();
    for round in 0..rounds {
        // Even rounds (from 0) run forwards and odd ones backwards, both cyclically, and every second round begins one workload further. Three workloads:
        // abc, cba, bca, bac, cab, acb.
        for step in 0..count {
            let position = (step + round / 2) % count;
            let k = if round % 2 == 0 { position } else { count - 1 - position };
            results[k].push(workloads[k]()?);
        }
    }
    Ok(results)
}

/// Seconds that a workload takes: CPU time of the process, or elapsed time if the system reports no CPU time, or its CPU clock has not advanced.
///
/// # Errors
/// The workload's error.
pub(crate) fn seconds_of<E>(workload: impl FnOnce() -> Result<(), E>) -> Result<f64, E> {
    let cpu_at_start = process_cpu();
    let start = Instant::now();
    workload()?;
    let elapsed = start.elapsed();
    let cpu_time = cpu_at_start.and_then(|at_start| process_cpu()?.checked_sub(at_start)).filter(|time| *time > Duration::ZERO);
    Ok(cpu_time.unwrap_or(elapsed).as_secs_f64())
}

/// A median with its quartiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quartiles {
    /// The lower quartile.
    pub low: f64,
    /// The median.
    pub median: f64,
    /// The upper quartile.
    pub high: f64,
}

impl Quartiles {
    /// The quartiles of `values`, in any order; `None` if there are none.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        Some(Self { low: quantile(&values, 0.25)?, median: quantile(&values, 0.5)?, high: quantile(&values, 0.75)? })
    }

    /// The quartiles of the ratios `times` / `reference_times`, each of the same round; `None` if no reference time is positive.
    pub(crate) fn of_ratios(times: &[f64], reference_times: &[f64]) -> Option<Self> {
        Self::of(times.iter().zip(reference_times).filter(|(_, reference)| **reference > 0.0).map(|(time, reference)| time / reference))
    }
}

/// The quantile `fraction` (0 to 1) of sorted values, by linear interpolation; `None` without values.
pub(crate) fn quantile(sorted: &[f64], fraction: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let position = fraction.clamp(0.0, 1.0) * last as f64;
    let below = position.floor() as usize;
    let (low, high, weight) = (sorted[below], sorted[(below + 1).min(last)], position - below as f64);
    // The interpolation would give NaN between two infinite values (inf - inf), and between a finite and an infinite one with a weight of 0 (0 * inf).
    Some(if weight == 0.0 || low == high { low } else { low + weight * (high - low) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::{Cell, RefCell};

    #[test]
    fn workloads_take_turns_and_each_round_runs_all_of_them() {
        let order = RefCell::new(String::new());
        let [a, b, c] = ['a', 'b', 'c'].map(|name| {
            let order = &order;
            move || -> Result<char, ()> {
                order.borrow_mut().push(name);
                Ok(name)
            }
        });
        let results = interleaved(4, &[&a, &b, &c]).expect("no error");
        assert_eq!(results, [['a'; 4], ['b'; 4], ['c'; 4]]);
        let order = order.into_inner();
        for round in order.as_bytes().chunks(3) {
            let mut names = round.to_vec();
            names.sort_unstable();
            assert_eq!(names, b"abc", "{order}");
        }
        // The second round runs in another order than the first.
        assert_ne!(&order[0..3], &order[3..6]);
        assert_eq!(interleaved(1, &[&(|| Err::<(), _>("broken")) as &Workload<'_, (), &str>]), Err("broken"));
    }

    /// The machine slows down tenfold (1.06 per run, 40 runs) while two workloads run, one of which does twice as much as the other: the ratios stay near 2.
    #[test]
    fn ratios_are_independent_of_drift_of_the_machine() {
        let true_ratio = 2.0;
        let slowness = Cell::new(1.0);
        let workload = |amount: f64| {
            let slowness = &slowness;
            move || -> Result<f64, ()> {
                slowness.set(slowness.get() * 1.06);
                Ok(amount * slowness.get())
            }
        };
        let times = interleaved(20, &[&workload(1.0), &workload(true_ratio)]).expect("no error");
        let ratio = Quartiles::of_ratios(&times[1], &times[0]).expect("ratios");
        // The second run of a round is slower by 1.06, so the ratio is 2 * 1.06 = 2.12 in half of the rounds and 2 / 1.06 = 1.89 in the others.
        assert!((ratio.median - true_ratio).abs() < 0.15 && ratio.low > 1.8 && ratio.high < 2.2, "{ratio:?}");
        // Times of different rounds may not be compared: the slowdown would count as a cost of the second workload. Its last ten rounds take 6.4 times as long
        // as the first ten of the other, 2 for the work and 1.06^20 = 3.2 for the slowdown by the 20 runs of ten rounds.
        let (first, second) = (times[0][..10].iter().sum::<f64>(), times[1][10..].iter().sum::<f64>());
        assert!(second / first > 2.0 * true_ratio);
    }

    #[test]
    fn quartiles_and_quantiles_of_short_lists() {
        let quartiles = Quartiles::of([4.0, 1.0, 3.0, 2.0, 5.0]).expect("values");
        assert_eq!((quartiles.low, quartiles.median, quartiles.high), (2.0, 3.0, 4.0));
        assert_eq!(Quartiles::of([7.0]).expect("a value"), Quartiles { low: 7.0, median: 7.0, high: 7.0 });
        assert_eq!(Quartiles::of([]), None);
        // Of four values, the fractions 0, 1/3 and 1 are values themselves; 0.9 lies between the two infinite ones.
        let with_infinite = [1.0, 2.0, f64::INFINITY, f64::INFINITY];
        assert_eq!([0.0, 1.0 / 3.0, 0.9, 1.0].map(|f| quantile(&with_infinite, f)), [1.0, 2.0, f64::INFINITY, f64::INFINITY].map(Some));
        assert_eq!(Quartiles::of_ratios(&[1.0], &[0.0]), None);
    }
}
