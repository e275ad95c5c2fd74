//! The rate of time in the window: forward, backward, faster, slower, paused.
//!
//! In: commands, and elapsed real seconds. Out: seconds of scene time. Both speed and rate are scene seconds per real second: the speed is a
//! magnitude, the rate has the sign of the direction and is 0 while paused. This module reads no clock.

use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY};
use crate::view::language::numbers::localised;
use crate::view::language::{text, text_by_id};

/// A Julian year.
const YEAR_S: f64 = DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY;
/// A mean month: a twelfth of a Julian year.
const MONTH_S: f64 = YEAR_S / 12.0;
/// The preset speeds, scene seconds per real second, from real time to a year per second.
const PRESET_SPEEDS: [f64; 10] = [1.0, 10.0, 60.0, 600.0, 3600.0, 6.0 * 3600.0, SECONDS_PER_DAY, 7.0 * SECONDS_PER_DAY, MONTH_S, YEAR_S];
/// Longest real time, seconds, that one frame converts to scene time. After a stall (a hidden window, a slow frame) scene time at a high speed therefore
/// does not jump. At a rate of exactly 1 there is no limit, so that a view of the current sky stays current.
pub(crate) const MAX_REAL_STEP_S: f64 = 2.0;

/// Least speed, scene seconds per real second.
pub(crate) const MIN_SPEED: f64 = PRESET_SPEEDS[0];
/// Greatest speed, scene seconds per real second.
pub(crate) const MAX_SPEED: f64 = PRESET_SPEEDS[PRESET_SPEEDS.len() - 1];

/// Rate and direction of scene time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeRate {
    /// Scene seconds per real second, [`MIN_SPEED`] to [`MAX_SPEED`].
    speed: f64,
    is_backward: bool,
    is_paused: bool,
}

impl Default for TimeRate {
    fn default() -> Self {
        Self { speed: MIN_SPEED, is_backward: false, is_paused: false }
    }
}

/// Relative difference up to which a speed counts as equal to a preset speed, so that a rounding error does not select the same preset again.
const SPEED_TOLERANCE: f64 = 1e-9;

impl TimeRate {
    /// Selects the next faster preset speed, and resumes paused time.
    pub fn faster(&mut self) {
        self.speed = PRESET_SPEEDS.into_iter().find(|preset| *preset > self.speed * (1.0 + SPEED_TOLERANCE)).unwrap_or(MAX_SPEED);
        self.is_paused = false;
    }

    /// Selects the next slower preset speed, and resumes paused time.
    pub(crate) fn slower(&mut self) {
        self.speed = PRESET_SPEEDS.into_iter().rev().find(|preset| *preset < self.speed * (1.0 - SPEED_TOLERANCE)).unwrap_or(MIN_SPEED);
        self.is_paused = false;
    }

    /// Runs time forward at the same speed, and resumes paused time.
    pub fn forward(&mut self) {
        (self.is_backward, self.is_paused) = (false, false);
    }

    /// Runs time backward at the same speed, and resumes paused time.
    pub(crate) fn backward(&mut self) {
        (self.is_backward, self.is_paused) = (true, false);
    }

    /// Runs time at a rate, backward if the rate is negative, and resumes paused time. The speed is limited to its range.
    pub(crate) fn run_at(&mut self, rate: f64) {
        self.set_speed(rate.abs());
        (self.is_backward, self.is_paused) = (rate < 0.0, false);
    }

    /// Sets the speed; the direction stays, and paused time stays paused.
    pub(crate) fn set_speed(&mut self, speed: f64) {
        if speed.is_finite() {
            self.speed = speed.clamp(MIN_SPEED, MAX_SPEED);
        }
    }

    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }

    pub fn toggle_pause(&mut self) {
        self.is_paused = !self.is_paused;
    }

    /// Pauses time, or resumes it at its former rate.
    pub(crate) fn set_paused(&mut self, paused: bool) {
        self.is_paused = paused;
    }

    /// Runs time forward at the speed of real time.
    pub(crate) fn reset(&mut self) {
        *self = Self::default();
    }

    pub fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// Scene seconds per real second, signed; 0 when paused.
    pub fn rate(&self) -> f64 {
        if self.is_paused { 0.0 } else { self.resumed_rate() }
    }

    /// The rate at which time runs, or at which paused time would resume.
    pub(crate) fn resumed_rate(&self) -> f64 {
        if self.is_backward { -self.speed } else { self.speed }
    }

    /// Scene seconds that pass in one frame of `real_s` real seconds; see [`MAX_REAL_STEP_S`].
    pub(crate) fn scene_seconds(&self, real_s: f64) -> f64 {
        let rate = self.rate();
        let max_step_s = if rate == 1.0 { f64::INFINITY } else { MAX_REAL_STEP_S };
        rate * real_s.clamp(0.0, max_step_s)
    }

    /// Short text for the title bar and the time bar: `paused`, `1 h/s`, `-1 d/s`.
    pub(crate) fn label(&self) -> String {
        if self.is_paused { text!("time-paused").into() } else { rate_text(self.rate()) }
    }
}

/// The text of a rate: scene time per real second with one decimal at most, in the largest unit that gives a value of at least 1: `6 h/s`, `2.5 min/s`.
pub(crate) fn rate_text(rate: f64) -> String {
    // Each unit's length in seconds and the id of its text.
    const UNITS: [(f64, &str); 6] = [
        (YEAR_S, "unit-year"),
        (MONTH_S, "unit-month"),
        (SECONDS_PER_DAY, "unit-day"),
        (3600.0, "unit-hour"),
        (60.0, "unit-minute"),
        (1.0, "unit-second"),
    ];
    let (unit_s, unit) = UNITS.into_iter().find(|(unit_s, _)| rate.abs() >= *unit_s).unwrap_or((1.0, "unit-second"));
    format!("{} {}/s", localised(((rate / unit_s * 10.0).round() / 10.0).to_string()), text_by_id(unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_step_through_the_presets_and_reverse_time() {
        let mut time_rate = TimeRate::default();
        for _ in 0..99 {
            time_rate.faster();
        }
        assert_eq!(time_rate.label(), "1 yr/s");
        time_rate.backward();
        assert_eq!(time_rate.rate(), -PRESET_SPEEDS[PRESET_SPEEDS.len() - 1]);
        for _ in 0..99 {
            time_rate.slower();
        }
        assert_eq!(time_rate.label(), "-1 s/s");
        time_rate.toggle_pause();
        assert_eq!((time_rate.rate(), time_rate.label().as_str()), (0.0, "paused"));
        time_rate.forward();
        assert!(!time_rate.is_paused() && time_rate.rate() == 1.0);
    }

    #[test]
    fn any_speed_within_the_limits_is_kept_and_steps_to_the_neighbouring_presets() {
        let mut time_rate = TimeRate::default();
        // NaN leaves the speed unchanged.
        for (requested, speed) in [(150.0, 150.0), (-150.0, 150.0), (0.01, MIN_SPEED), (1e12, MAX_SPEED), (f64::NAN, MAX_SPEED)] {
            time_rate.run_at(requested);
            assert_eq!(time_rate.speed(), speed, "{requested}");
            assert_eq!(time_rate.rate() < 0.0, requested < 0.0);
        }
        time_rate.run_at(150.0);
        time_rate.faster();
        assert_eq!(time_rate.rate(), 600.0);
        time_rate.run_at(150.0);
        time_rate.slower();
        assert_eq!(time_rate.rate(), 60.0);
        assert_eq!(
            (rate_text(150.0).as_str(), rate_text(-5400.0).as_str(), rate_text(21_600.0).as_str()),
            ("2.5 min/s", "-1.5 h/s", "6 h/s")
        );
        time_rate.toggle_pause();
        time_rate.set_speed(600.0);
        assert!(time_rate.is_paused());
    }

    #[test]
    fn scene_time_catches_up_after_a_stall_only_at_real_time_forward() {
        let mut time_rate = TimeRate::default();
        assert_eq!((time_rate.scene_seconds(3600.0), time_rate.scene_seconds(-1.0)), (3600.0, 0.0));
        time_rate.faster();
        assert_eq!(time_rate.scene_seconds(3600.0), 10.0 * MAX_REAL_STEP_S);
        time_rate.reset();
        time_rate.backward();
        assert_eq!(time_rate.scene_seconds(3600.0), -MAX_REAL_STEP_S);
        time_rate.toggle_pause();
        assert_eq!(time_rate.scene_seconds(3600.0), 0.0);
    }
}
