//! Motion on any conic about one centre: ellipse, parabola and hyperbola by one formula, Kepler's equation for the universal anomaly.
//!
//! In: a state, the centre's GM and a time span; or the orbit of a small body and a time. Out: the state after that span or at that time. The first four of
//! Stumpff's functions c_k(x) = sum (-x)^n / (2n + k)! describe all three kinds of conic, so no precision is lost near the parabola. Units: the length and time
//! units of GM. Omitted: perturbations. After Danby 1988, Fundamentals of Celestial Mechanics, 6.9.

use crate::catalog::small_bodies::{GAUSS_CONSTANT, HeliocentricOrbit};
use glam::DVec3;
use std::f64::consts::TAU;

/// Stumpff's c0 to c3 at `x`, accurate to rounding: `x` is divided by four until it is small, the series are summed there, and double-angle formulas
/// lead back to `x`.
pub fn stumpff(x: f64) -> [f64; 4] {
    let (mut x, mut quarterings) = (x, 0);
    // The bound ends the loop for an infinite `x`.
    while x.abs() > 0.1 && quarterings < 64 {
        x *= 0.25;
        quarterings += 1;
    }
    // k! c_k of the reduced `x`, by Horner's scheme. The first omitted term of c_k is at most 0.1^8 / 18!, below rounding.
    let series =
        |k: f64| (0..7).rev().fold(1.0, |sum, n| 1.0 - x / ((2.0 * f64::from(n) + k + 1.0) * (2.0 * f64::from(n) + k + 2.0)) * sum);
    let (mut c2, mut c3) = (0.5 * series(2.0), series(3.0) / 6.0);
    let (mut c0, mut c1) = (1.0 - x * c2, 1.0 - x * c3);
    for _ in 0..quarterings {
        // Writing 1 + c0 as 2 - x c2 preserves the precision of c2, which is (1 - cos E) / E² with E² = x.
        c3 = 0.25 * (c2 + c0 * c3);
        c2 *= 0.5 * (2.0 - x * c2);
        c1 *= c0;
        x *= 4.0;
        c0 = 1.0 - x * c2;
    }
    [c0, c1, c2, c3]
}

/// Largest number of doublings of the bracket, and of steps of Newton's method or bisection. The limit ends both loops for numbers that are not finite,
/// and the second one where rounding makes the steps alternate between neighbouring numbers.
const MAX_STEPS: u32 = 200;

/// Position and velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConicState {
    /// Position relative to the centre.
    pub position: DVec3,
    /// Time derivative of the position.
    pub velocity: DVec3,
}

impl ConicState {
    /// GM over the semi-major axis: positive for an ellipse, 0 for a parabola, negative for a hyperbola.
    pub fn gm_over_semi_major_axis(&self, gm: f64) -> f64 {
        2.0 * gm / self.position.length() - self.velocity.length_squared()
    }

    /// The period of an ellipse; `None` for a parabola or a hyperbola.
    pub fn period(&self, gm: f64) -> Option<f64> {
        let alpha = self.gm_over_semi_major_axis(gm);
        (alpha > 0.0).then(|| TAU * gm / alpha.powf(1.5))
    }

    /// The state after a time span, which may be negative.
    #[must_use]
    pub fn propagated(&self, gm: f64, span: f64) -> Self {
        // Danby's names: sigma is the dot product of position and velocity, alpha is GM over the semi-major axis, s the universal anomaly.
        let (r0, sigma) = (self.position.length(), self.position.dot(self.velocity));
        let alpha = self.gm_over_semi_major_axis(gm);
        let period = self.period(gm).unwrap_or(f64::INFINITY);
        // Full revolutions are removed.
        let span = if period.is_finite() { span - period * (span / period).round() } else { span };
        // s^k c_k(alpha s²) for k from 0 to 3.
        let universal_functions = |s: f64| {
            let [c0, c1, c2, c3] = stumpff(alpha * s * s);
            [c0, s * c1, s * s * c2, s * s * s * c3]
        };
        // Kepler's equation: the time at s minus the span, and dt/ds, which is the distance from the centre.
        let time_residual = |s: f64| {
            let [g0, g1, g2, g3] = universal_functions(s);
            (r0 * g1 + sigma * g2 + gm * g3 - span, r0 * g0 + sigma * g1 + gm * g2)
        };
        // dt/ds is positive, so the residual is monotonic: Newton's method, safeguarded by a bracket. The bracket starts small, because
        // the functions of a hyperbola overflow far beyond the root.
        let first_width = (span.abs() / r0).min(alpha.abs().sqrt().recip()).max(f64::MIN_POSITIVE);
        // `low` is short of the root; `high` is doubled until it is at the root or beyond. For a negative span both are at most 0.
        let (mut low, mut high) = (0.0_f64, span.signum() * first_width);
        for _ in 0..MAX_STEPS {
            if time_residual(high).0 * span.signum() >= 0.0 {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        let mut s = 0.5 * (low + high);
        for _ in 0..MAX_STEPS {
            let (residual, rate) = time_residual(s);
            if residual * span.signum() > 0.0 {
                high = s;
            } else {
                low = s;
            }
            let newton = s - residual / rate;
            let is_in_bracket = (newton - low) * (newton - high) <= 0.0;
            let next = if is_in_bracket { newton } else { 0.5 * (low + high) };
            let has_converged = (next - s).abs() <= 1e-16 * s.abs();
            s = next;
            if has_converged {
                break;
            }
        }
        let [_, g1, g2, g3] = universal_functions(s);
        let position = self.position * (1.0 - gm * g2 / r0) + self.velocity * (span - gm * g3);
        // Distance from the centre after the span.
        let (_, r) = time_residual(s);
        let velocity = self.position * (-gm * g1 / (r * r0)) + self.velocity * (1.0 - gm * g2 / r);
        Self { position, velocity }
    }
}

/// A small body's heliocentric state, au and au per day, ICRF, at a time in days past J2000 (TDB).
pub fn heliocentric_state(orbit: &HeliocentricOrbit, days: f64) -> ConicState {
    let gm = GAUSS_CONSTANT * GAUSS_CONSTANT;
    let speed = (gm * (1.0 + orbit.eccentricity) / orbit.perihelion_au).sqrt();
    let at_perihelion = ConicState { position: orbit.to_perihelion * orbit.perihelion_au, velocity: orbit.motion_at_perihelion * speed };
    at_perihelion.propagated(gm, days - orbit.passage_days)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ephemeris::two_body::eccentric_anomaly;

    #[test]
    fn stumpff_functions_agree_with_circular_and_hyperbolic_functions() {
        for k in 0..400 {
            let x = 1e-6 * 1.06_f64.powi(k);
            if x > 12.0 {
                break;
            }
            let s = x.sqrt();
            let [c0, c1, c2, c3] = stumpff(x);
            let half = (0.5 * s).sin();
            assert!((c0 - s.cos()).abs() < 4e-15 && (c1 - s.sin() / s).abs() < 4e-15 && (c2 - 2.0 * half * half / x).abs() < 4e-15, "{x}");
            assert!(x < 1e-2 || (c3 - (s - s.sin()) / (x * s)).abs() < 4e-14, "{x}");
            let [h0, h1, ..] = stumpff(-x * 9.0);
            let s = 3.0 * s;
            assert!((h0 / s.cosh() - 1.0).abs() < 1e-14 && (h1 / (s.sinh() / s) - 1.0).abs() < 1e-14, "{x}");
        }
        assert_eq!(stumpff(0.0), [1.0, 1.0, 0.5, 1.0 / 6.0]);
    }

    fn orbit(q: f64, e: f64) -> HeliocentricOrbit {
        HeliocentricOrbit { perihelion_au: q, eccentricity: e, to_perihelion: DVec3::X, motion_at_perihelion: DVec3::Y, passage_days: 0.0 }
    }

    /// Ellipses against the classical equation; the hyperbola against sinh; the parabola against Barker's equation.
    #[test]
    fn positions_agree_with_the_classical_formulas() {
        for e in [0.0, 1e-9, 0.2, 0.7, 0.97, 0.999, 0.999_999] {
            let (q, a) = (1.0 - e, 1.0);
            for step in -31..=31 {
                let m = 0.1 * f64::from(step) + 1e-3;
                let anomaly = eccentric_anomaly(m, e);
                let expected = DVec3::new(a * (anomaly.cos() - e), a * (1.0 - e * e).sqrt() * anomaly.sin(), 0.0);
                let found = heliocentric_state(&orbit(q, e), m / GAUSS_CONSTANT).position;
                // Far from the perihelion of a nearly parabolic orbit the universal functions cancel. At the aphelion of e = 0.999999 the error is 3.8e-10 by a
                // computation with 50 digits, which confirms the classical formula.
                let bound = if e <= 0.999 { 1e-10 } else { 1e-9 };
                assert!(found.distance(expected) < bound * a, "e {e} M {m}: {found} {expected}");
            }
        }
        // `h`: hyperbolic anomaly.
        for (e, h) in [(1.001, 0.3), (1.2, -2.0), (3.4, 7.0)] {
            let e: f64 = e;
            let h: f64 = h;
            let a = 1.0 / (e - 1.0);
            let expected = DVec3::new(a * (e - h.cosh()), a * (e * e - 1.0).sqrt() * h.sinh(), 0.0);
            let found = heliocentric_state(&orbit(1.0, e), (e * h.sinh() - h) * a.powf(1.5) / GAUSS_CONSTANT).position;
            assert!(found.distance(expected) < 1e-10 * expected.length(), "{e} {h}: {found} {expected}");
        }
        // Barker: t = sqrt(2 q^3) / k (w + w^3 / 3), w the tangent of half the true anomaly.
        for w in [-5.0, -0.1, 1e-6, 0.7, 30.0_f64] {
            let days = 2.0_f64.sqrt() / GAUSS_CONSTANT * (w + w * w * w / 3.0);
            let found = heliocentric_state(&orbit(1.0, 1.0), days).position;
            let expected = DVec3::new(1.0 - w * w, 2.0 * w, 0.0);
            assert!(found.distance(expected) < 1e-11 * expected.length(), "{w}: {found} {expected}");
            // Nearly parabolic orbits: eccentricities on both sides of 1, where classical formulas divide by nearly zero.
            let near = [1.0 - 1e-10, 1.0 + 1e-10].map(|e| heliocentric_state(&orbit(1.0, e), days).position);
            assert!(near.iter().all(|p| p.distance(expected) < 1e-5 * expected.length()), "{near:?}");
        }
    }

    /// Kepler's third law: 4 au are eight times the period of 1 au.
    #[test]
    fn only_an_ellipse_has_a_period() {
        let period = |q: f64, e: f64| heliocentric_state(&orbit(q, e), 10.0).period(GAUSS_CONSTANT * GAUSS_CONSTANT);
        assert!((period(1.0, 0.0).expect("a circle") * GAUSS_CONSTANT / TAU - 1.0).abs() < 1e-9);
        assert!((period(2.0, 0.5).expect("an ellipse") * GAUSS_CONSTANT / TAU - 8.0).abs() < 1e-8);
        assert_eq!(period(1.0, 3.4), None);
    }

    #[test]
    fn propagated_states_stay_on_their_orbit() {
        let gm = GAUSS_CONSTANT * GAUSS_CONSTANT;
        for (q, e) in [(0.6, 0.967), (1.0, 1.0), (2.0, 3.4), (2.5, 0.05)] {
            let (start, span) = (heliocentric_state(&orbit(q, e), 123.0), 77.0);
            let (propagated, expected) = (start.propagated(gm, span), heliocentric_state(&orbit(q, e), 123.0 + span));
            let (position, velocity) = (propagated.position, propagated.velocity);
            assert!(position.distance(expected.position) < 1e-12 && velocity.distance(expected.velocity) < 1e-13, "{q} {e}");
            let slope = (start.propagated(gm, 0.01).position - start.propagated(gm, -0.01).position) / 0.02;
            assert!(
                slope.distance(start.velocity) < 1e-9 && slope.distance(velocity) > 1e-4,
                "the slope is that of the start, not of the end"
            );
        }
    }

    /// Radiation pressure counteracts gravity: a small grain feels a part of it, none, or is repelled (its GM is negative). The reference is the equation of
    /// motion, integrated in 1000 steps (Nyström, fourth order).
    #[test]
    fn grains_follow_the_equation_of_motion_at_any_radiation_pressure() {
        let (gravity, span, count) = (GAUSS_CONSTANT * GAUSS_CONSTANT, 77.0, 1000);
        let step = span / f64::from(count);
        for (q, e) in [(0.6, 0.967), (1.0, 1.0), (2.0, 3.4), (2.5, 0.05)] {
            let start = heliocentric_state(&orbit(q, e), 123.0);
            for gm in [1.0, 0.1, 0.0, -1.5].map(|share| share * gravity) {
                let acceleration = |position: DVec3| position * (-gm / position.length().powi(3));
                let (mut position, mut velocity) = (start.position, start.velocity);
                for _ in 0..count {
                    let first = acceleration(position);
                    let middle = acceleration(position + 0.5 * step * velocity + 0.125 * step * step * first);
                    let last = acceleration(position + step * velocity + 0.5 * step * step * middle);
                    position += step * velocity + step * step / 6.0 * (first + 2.0 * middle);
                    velocity += step / 6.0 * (first + 4.0 * middle + last);
                }
                let found = start.propagated(gm, span);
                assert!(found.position.distance(position) < 1e-12 && found.velocity.distance(velocity) < 1e-14, "{q} {e} {gm}: {found:?}");
                let other = start.propagated(gm + 1e-3 * gravity, span);
                assert!(other.position.distance(position) > 1e-6, "{q} {e} {gm}: a thousandth of gravity makes no difference");
            }
        }
    }
}
