//! Lowers the resolution of images while the camera or the bodies move, to keep the frame rate.
//!
//! In: pixel counts and times of finished images. Out: the factor by which width and height of the next moving image are smaller than those
//! of the window. Always: to reach 60 images per second, the factor is raised to at most 2; if that does not suffice, the rate may fall to
//! 30 per second; only to keep 30 per second is the factor raised further. This module reads no clock.

/// Target intervals between images, milliseconds. 62 and 32 per second leave a margin for slow images above the goals of 60 and 30.
const FAST_MS: f64 = 1000.0 / 62.0;
const SLOW_MS: f64 = 1000.0 / 32.0;
/// Largest factor that is used to reach the fast interval.
const MAX_FAST_SCALE: f64 = 2.0;
/// Largest factor; coarser images would be unrecognisable.
pub(crate) const MAX_SCALE: f64 = 5.0;
/// The factor until an image has been measured.
const FIRST_SCALE: f64 = 3.0;
/// Factors are multiples of this, so that small changes of the times do not change the resolution.
const SCALE_STEP: f64 = 0.125;
/// Weight of the newest image in the running means.
const NEWEST_WEIGHT: f64 = 0.3;
/// Longest waiting time that is recorded, as a fraction of [`FAST_MS`]: during a longer pause the user moved nothing.
const MAX_WAITING_FRACTION: f64 = 0.5;

/// Recent cost of images.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AdaptiveResolution {
    /// Running mean of the render time divided by the number of megapixels. All of the time is divided, including the part that does not depend on the pixels.
    ms_per_megapixel: Option<f64>,
    /// Running mean of the time between the end of an image and the start of the next.
    waiting_ms: f64,
    /// The last factor computed from a measured image; 0 before that.
    scale: f64,
}

impl AdaptiveResolution {
    /// Records the render time of an image of `pixels` pixels, and the time for which the renderer waited before it.
    pub(crate) fn record(&mut self, pixels: u64, render_ms: f64, waiting_ms: f64) {
        if pixels == 0 || !render_ms.is_finite() {
            return;
        }
        let updated_mean = |old: f64, new: f64| old + NEWEST_WEIGHT * (new - old);
        let new = render_ms / (pixels as f64 / 1e6);
        self.ms_per_megapixel = Some(self.ms_per_megapixel.map_or(new, |old| updated_mean(old, new)));
        if waiting_ms < MAX_WAITING_FRACTION * FAST_MS {
            self.waiting_ms = updated_mean(self.waiting_ms, waiting_ms);
        }
    }

    /// The factor of width and height for a moving image in a window of `pixels` pixels.
    pub(crate) fn scale(&mut self, pixels: u64) -> f64 {
        let Some(ms_per_megapixel) = self.ms_per_megapixel else { return FIRST_SCALE };
        let full_size_ms = ms_per_megapixel * pixels as f64 / 1e6;
        // The render time is proportional to the square of the resolution.
        let scale_for_interval = |interval_ms: f64| (full_size_ms / (interval_ms - self.waiting_ms)).sqrt();
        let fast_scale = scale_for_interval(FAST_MS);
        let target = if fast_scale <= MAX_FAST_SCALE { fast_scale } else { scale_for_interval(SLOW_MS).clamp(MAX_FAST_SCALE, MAX_SCALE) };
        // Hysteresis: the factor is lowered only if the target is more than one and a half steps below it; otherwise it would change all
        // the time.
        if target > self.scale || target < self.scale - 1.5 * SCALE_STEP {
            self.scale = ((target / SCALE_STEP).ceil() * SCALE_STEP).max(1.0);
        }
        self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW_PIXELS: u64 = 1_000_000;

    /// The rate (images per second) and the factor after 60 images of a renderer that needs `fixed_ms` for any image, further `window_ms`
    /// for one of the window's size, and `waiting_ms` between images.
    fn settled(resolution: &mut AdaptiveResolution, fixed_ms: f64, window_ms: f64, waiting_ms: f64) -> (f64, f64) {
        let mut last = (0.0, 0.0);
        for _ in 0..60 {
            let scale = resolution.scale(WINDOW_PIXELS);
            let pixels = WINDOW_PIXELS as f64 / (scale * scale);
            let took_ms = fixed_ms + window_ms * pixels / WINDOW_PIXELS as f64;
            resolution.record(pixels as u64, took_ms, waiting_ms);
            last = (1e3 / (took_ms + waiting_ms), scale);
        }
        last
    }

    #[test]
    fn the_factor_rises_to_2_then_the_rate_falls_to_30_then_the_factor_rises_further() {
        let mut resolution = AdaptiveResolution::default();
        assert_eq!(resolution.scale(WINDOW_PIXELS), FIRST_SCALE);
        let mut scales = Vec::new();
        for window_ms in [4.0, 12.0, 20.0, 35.0, 45.0, 60.0, 80.0, 120.0, 200.0, 400.0, 60.0, 20.0, 4.0] {
            let (rate, scale) = settled(&mut resolution, 1.0, window_ms, 2.0);
            // Up to one and a half steps above 2, hysteresis may keep the factor while a lower one would suffice.
            let is_held_coarse = (MAX_FAST_SCALE..=MAX_FAST_SCALE + 1.5 * SCALE_STEP).contains(&scale);
            assert!(rate >= 30.0 && (scale >= MAX_FAST_SCALE || rate >= 60.0), "{window_ms} ms: {rate:.1} a second at 1/{scale}");
            // The image is not coarser than the rate requires, apart from the steps of the factor.
            let max_rate = if scale < MAX_FAST_SCALE { 80.0 } else { 40.0 };
            assert!(scale == 1.0 || is_held_coarse || rate < max_rate, "{window_ms} ms: {rate:.1} at 1/{scale}");
            scales.push(scale);
        }
        assert!(scales[0] == 1.0 && scales[6] == MAX_FAST_SCALE && scales[9] > 3.0 && scales[12] == 1.0, "{scales:?}");
    }

    #[test]
    fn extreme_times_leave_the_factor_within_its_range() {
        let mut resolution = AdaptiveResolution::default();
        resolution.record(0, 5.0, 0.0);
        resolution.record(100, f64::NAN, 0.0);
        assert_eq!(resolution.scale(WINDOW_PIXELS), FIRST_SCALE);
        assert_eq!(settled(&mut resolution, 0.0, 1e6, 0.0).1, MAX_SCALE);
        assert_eq!(settled(&mut resolution, 0.0, 0.0, f64::NAN).1, 1.0);
        // A long pause before an image is the user's and has no effect.
        let (_, scale) = settled(&mut resolution, 0.0, 40.0, 0.0);
        assert_eq!(settled(&mut resolution, 0.0, 40.0, 1e5).1, scale);
    }
}
