//! A cache of Chebyshev polynomials that approximate a slow theory.
//!
//! In: a target, an instant, the theory as a function of time. Out: the target's state. The theory is evaluated once at the Chebyshev nodes of an interval of
//! days; every further state in that interval is a sum of 14 terms per axis. Always: the intervals lie on a fixed grid, so that a result does not depend on
//! earlier calls; the velocity is the derivative of the returned position.

use super::time_grid::GridCache;
use super::{State, chebyshev};
use crate::units::SECONDS_PER_DAY;
use glam::DVec3;
use std::sync::Arc;

/// Number of terms of the polynomial of an axis.
const TERMS: usize = 14;
/// Largest number of cached intervals, of all targets together; the polynomials of each take a third of a kilobyte (3 x 14 x 8 bytes).
const MAX_INTERVALS: usize = 8192;

/// Chebyshev coefficients of the position in km over an interval, by axis, lowest degree first.
type Coefficients = [Vec<f64>; 3];

/// The polynomials of the intervals that were asked for.
#[derive(Debug)]
pub struct ChebyshevCache {
    /// Keyed by target (NAIF code) and index of the interval; interval 0 begins at J2000.
    intervals: GridCache<i32, Arc<Coefficients>>,
}

impl Default for ChebyshevCache {
    fn default() -> Self {
        Self { intervals: GridCache::with_capacity(MAX_INTERVALS) }
    }
}

impl ChebyshevCache {
    /// The state of `target` from polynomials over intervals of `interval_days`. All calls for one target must pass the same length, because the cache's key
    /// does not contain it. `theory` gives the target's position in km at TDB seconds past J2000; the state has its axes and origin.
    pub fn state(&self, target: i32, interval_days: f64, tdb_s: f64, theory: impl Fn(f64) -> DVec3) -> State {
        let half_interval_s = 0.5 * interval_days * SECONDS_PER_DAY;
        let interval_index = (tdb_s / (2.0 * half_interval_s)).floor();
        let middle_s = (2.0 * interval_index + 1.0) * half_interval_s;
        let fit = || Arc::new(chebyshev::fit_nodes(TERMS, |u| theory(middle_s + u * half_interval_s)));
        let coefficients = self.intervals.get(target, interval_index as i64, fit);
        let u = (tdb_s - middle_s) / half_interval_s;
        let [(x, x_slope), (y, y_slope), (z, z_slope)] = coefficients.each_ref().map(|c| chebyshev::value_and_slope(c, u));
        State { pos_km: DVec3::new(x, y, z), vel_km_s: DVec3::new(x_slope, y_slope, z_slope) / half_interval_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Any target.
    const TARGET: i32 = 3;
    const INTERVAL_DAYS: f64 = 16.0;

    #[test]
    fn each_interval_is_fitted_once_and_results_do_not_depend_on_order() {
        let evaluations = AtomicU32::new(0);
        let (radius_km, rad_per_s) = (1e6, 1.0 / (20.0 * SECONDS_PER_DAY));
        let circle = |s: f64| {
            evaluations.fetch_add(1, Ordering::Relaxed);
            let angle = s * rad_per_s;
            radius_km * DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        // In the intervals -1, 0 (0 to 1.38e6 s), 7 and another before J2000.
        let times = [-1.0, 0.0, 1e5, 2e5, 9e5, 1e7, -3e9];
        let forward = ChebyshevCache::default();
        let forward_states: Vec<State> = times.iter().map(|s| forward.state(TARGET, INTERVAL_DAYS, *s, circle)).collect();
        let evaluations_forward = evaluations.load(Ordering::Relaxed);
        assert_eq!(evaluations_forward as usize, 4 * TERMS, "four intervals");
        let backward = ChebyshevCache::default();
        let mut backward_states: Vec<State> = times.iter().rev().map(|s| backward.state(TARGET, INTERVAL_DAYS, *s, circle)).collect();
        backward_states.reverse();
        assert_eq!(forward_states, backward_states);
        let both_states = |s: f64| [&forward, &backward].map(|cache| cache.state(TARGET, INTERVAL_DAYS, s, circle));
        for s in times {
            let [forward_state, backward_state] = both_states(s);
            assert_eq!(forward_state, backward_state);
        }
        assert_eq!(evaluations.load(Ordering::Relaxed), 2 * evaluations_forward);
        for (s, state) in times.iter().zip(&forward_states) {
            let angle = s * rad_per_s;
            assert!((state.pos_km - radius_km * DVec3::new(angle.cos(), angle.sin(), 0.0)).length() < 1e-6, "{s}");
            assert!((state.vel_km_s - radius_km * rad_per_s * DVec3::new(-angle.sin(), angle.cos(), 0.0)).length() < 1e-10, "{s}");
        }
    }

    #[test]
    fn the_cache_has_a_maximum_size() {
        let cache = ChebyshevCache::default();
        for k in 0..=MAX_INTERVALS {
            let middle_s = (k as f64 + 0.5) * INTERVAL_DAYS * SECONDS_PER_DAY;
            let any_theory = DVec3::splat;
            cache.state(TARGET, INTERVAL_DAYS, middle_s, any_theory);
        }
        assert!(cache.intervals.len() <= MAX_INTERVALS);
    }
}
