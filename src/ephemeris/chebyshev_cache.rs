//! Polynomials in place of a slow theory, made where time goes and kept.
//!
//! In: a place, an instant, a theory of the place's position. Out: its state. The theory is asked at the nodes of a stretch of days, once; whatever
//! else is asked in that stretch is a short sum. Always: the stretches lie on a grid of their own, so that an answer does not depend on
//! what was asked before; the velocity is the slope of the position that is answered.

use super::{State, chebyshev};
use crate::units::SECONDS_PER_DAY;
use glam::DVec3;
use parking_lot::Mutex;
use std::collections::HashMap;
use std::sync::Arc;

/// Terms of a polynomial.
const TERMS: usize = 14;
/// Polynomials that are kept, a third of a kilobyte each; with one more all go.
const MOST: usize = 8192;

/// Coefficients by axis, of a stretch.
type ChebyshevSegment = [Vec<f64>; 3];

#[derive(Debug, Default)]
pub struct ChebyshevCache {
    /// By place and the number of the stretch, counted from J2000.
    kept: Mutex<HashMap<(i32, i64), Arc<ChebyshevSegment>>>,
}

impl ChebyshevCache {
    /// The state of `place`, whose position in km at TDB seconds past J2000 is `theory`'s. `days`: the length of a stretch.
    pub fn state(&self, place: i32, days: f64, tdb_s: f64, theory: impl Fn(f64) -> DVec3) -> State {
        let radius_s = 0.5 * days * SECONDS_PER_DAY;
        let number = (tdb_s / (2.0 * radius_s)).floor();
        let middle_s = (2.0 * number + 1.0) * radius_s;
        let key = (place, number as i64);
        let known = self.kept.lock().get(&key).cloned();
        let piece = known.unwrap_or_else(|| {
            // Without the lock: others are answered meanwhile. Two that make the same piece make the same numbers.
            let made = Arc::new(chebyshev::fit_nodes(TERMS, |u| theory(middle_s + u * radius_s)));
            let mut kept = self.kept.lock();
            if kept.len() >= MOST {
                kept.clear();
            }
            kept.insert(key, Arc::clone(&made));
            made
        });
        let [x, y, z] = piece.each_ref().map(|c| chebyshev::value_and_slope(c, (tdb_s - middle_s) / radius_s));
        State { pos_km: DVec3::new(x.0, y.0, z.0), vel_km_s: DVec3::new(x.1, y.1, z.1) / radius_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn a_stretch_is_asked_for_once_and_answers_do_not_depend_on_order() {
        let asked = AtomicU32::new(0);
        let circle = |s: f64| {
            asked.fetch_add(1, Ordering::Relaxed);
            let angle = s / (20.0 * SECONDS_PER_DAY);
            1e6 * DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let times = [-1.0, 0.0, 1e5, 2e5, 9e5, 1e7, -3e9];
        let forth = ChebyshevCache::default();
        let there: Vec<State> = times.iter().map(|s| forth.state(3, 16.0, *s, circle)).collect();
        let first = asked.load(Ordering::Relaxed);
        assert_eq!(first as usize, 4 * TERMS, "four stretches");
        let back = ChebyshevCache::default();
        let mut again: Vec<State> = times.iter().rev().map(|s| back.state(3, 16.0, *s, circle)).collect();
        again.reverse();
        assert_eq!(there, again);
        times.iter().for_each(|s| assert_eq!(forth.state(3, 16.0, *s, circle), back.state(3, 16.0, *s, circle)));
        assert_eq!(asked.load(Ordering::Relaxed), 2 * first);
        for (s, state) in times.iter().zip(&there) {
            let angle = s / (20.0 * SECONDS_PER_DAY);
            let rate = 1e6 / (20.0 * SECONDS_PER_DAY);
            assert!((state.pos_km - 1e6 * DVec3::new(angle.cos(), angle.sin(), 0.0)).length() < 1e-6, "{s}");
            assert!((state.vel_km_s - rate * DVec3::new(-angle.sin(), angle.cos(), 0.0)).length() < 1e-10, "{s}");
        }
    }

    #[test]
    fn what_is_kept_has_an_end() {
        let pieces = ChebyshevCache::default();
        for k in 0..=MOST {
            pieces.state(1, 1.0, (k as f64 + 0.5) * SECONDS_PER_DAY, DVec3::splat);
        }
        assert!(pieces.kept.lock().len() <= MOST);
    }
}
