//! Lowers the resolution of images while the camera or the bodies move, to keep the frame rate.
//!
//! In: pixel counts and times of finished images. Out: the divisor: the number by which the window's width and height are divided to give the width and
//! height of the next moving image. Always: to reach 60 images per second, the divisor is raised to at most 2. If 2 does not suffice, the rate may fall to
//! 30 per second; only to keep 30 per second is the divisor raised further. This module reads no clock.

/// Target interval between images for the goal of 60 images per second; a target of 62 leaves a margin for slow images.
const FAST_INTERVAL_MS: f64 = 1000.0 / 62.0;
/// Target interval for the goal of 30 images per second, with the same kind of margin.
const SLOW_INTERVAL_MS: f64 = 1000.0 / 32.0;
/// Largest divisor that is used to reach the fast interval.
const MAX_FAST_DIVISOR: f64 = 2.0;
/// Largest divisor; coarser images would be unrecognisable.
pub(crate) const MAX_DIVISOR: f64 = 5.0;
/// The divisor until an image has been measured.
const FIRST_DIVISOR: f64 = 3.0;
/// Divisors are multiples of this, so that small changes of the times do not change the resolution.
const DIVISOR_STEP: f64 = 0.125;
/// Weight of the newest image in the running means.
const NEWEST_WEIGHT: f64 = 0.3;
/// Longest idle time that is recorded, as a fraction of [`FAST_INTERVAL_MS`]. In a longer pause nothing moved, so no image was needed.
const MAX_IDLE_FRACTION: f64 = 0.5;

/// Recent cost of images.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AdaptiveResolution {
    /// Running mean of the render time divided by the number of megapixels. The render time includes the part that does not depend on the number of
    /// pixels. `None` before the first image.
    ms_per_megapixel: Option<f64>,
    /// Running mean of the time for which the renderer is idle between two images.
    idle_ms: f64,
    /// The last divisor computed from a measured image; 0 before that.
    divisor: f64,
}

impl AdaptiveResolution {
    /// Records the render time of an image with this number of pixels, and the time for which the renderer was idle before the image.
    pub(crate) fn record(&mut self, pixel_count: u64, render_ms: f64, idle_ms: f64) {
        if pixel_count == 0 || !render_ms.is_finite() {
            return;
        }
        let updated_mean = |mean: f64, newest: f64| mean + NEWEST_WEIGHT * (newest - mean);
        let newest = render_ms / (pixel_count as f64 / 1e6);
        self.ms_per_megapixel = Some(self.ms_per_megapixel.map_or(newest, |mean| updated_mean(mean, newest)));
        if idle_ms < MAX_IDLE_FRACTION * FAST_INTERVAL_MS {
            self.idle_ms = updated_mean(self.idle_ms, idle_ms);
        }
    }

    /// The divisor of width and height for a moving image in a window with this number of pixels.
    pub(crate) fn divisor(&mut self, window_pixel_count: u64) -> f64 {
        let Some(ms_per_megapixel) = self.ms_per_megapixel else { return FIRST_DIVISOR };
        let full_size_ms = ms_per_megapixel * window_pixel_count as f64 / 1e6;
        // The divisor at which images follow each other at this interval. The render time is taken as proportional to the number of pixels, that is, to
        // 1 / (divisor * divisor).
        let divisor_for_interval = |interval_ms: f64| (full_size_ms / (interval_ms - self.idle_ms)).sqrt();
        let fast_divisor = divisor_for_interval(FAST_INTERVAL_MS);
        let target_divisor = if fast_divisor <= MAX_FAST_DIVISOR {
            fast_divisor
        } else {
            divisor_for_interval(SLOW_INTERVAL_MS).clamp(MAX_FAST_DIVISOR, MAX_DIVISOR)
        };
        // Hysteresis: the divisor is lowered only if the target is more than one and a half steps below it. Otherwise it would change all the time.
        if target_divisor > self.divisor || target_divisor < self.divisor - 1.5 * DIVISOR_STEP {
            self.divisor = ((target_divisor / DIVISOR_STEP).ceil() * DIVISOR_STEP).max(1.0);
        }
        self.divisor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW_PIXELS: u64 = 1_000_000;

    /// The rate (images per second) and the divisor after 60 images. The renderer needs `fixed_ms` for any image, and further `window_ms` for one of the
    /// window's size; between images it is idle for `idle_ms`.
    fn settled(resolution: &mut AdaptiveResolution, fixed_ms: f64, window_ms: f64, idle_ms: f64) -> (f64, f64) {
        let mut last = (0.0, 0.0);
        for _ in 0..60 {
            let divisor = resolution.divisor(WINDOW_PIXELS);
            let pixels = WINDOW_PIXELS as f64 / (divisor * divisor);
            let took_ms = fixed_ms + window_ms * pixels / WINDOW_PIXELS as f64;
            resolution.record(pixels as u64, took_ms, idle_ms);
            last = (1e3 / (took_ms + idle_ms), divisor);
        }
        last
    }

    #[test]
    fn the_divisor_rises_to_2_then_the_rate_falls_to_30_then_the_divisor_rises_further() {
        let mut resolution = AdaptiveResolution::default();
        assert_eq!(resolution.divisor(WINDOW_PIXELS), FIRST_DIVISOR);
        let mut divisors = Vec::new();
        for window_ms in [4.0, 12.0, 20.0, 35.0, 45.0, 60.0, 80.0, 120.0, 200.0, 400.0, 60.0, 20.0, 4.0] {
            let (rate, divisor) = settled(&mut resolution, 1.0, window_ms, 2.0);
            // Up to one and a half steps above 2, hysteresis may keep the divisor although a lower one would suffice.
            let is_held_coarse = (MAX_FAST_DIVISOR..=MAX_FAST_DIVISOR + 1.5 * DIVISOR_STEP).contains(&divisor);
            assert!(rate >= 30.0 && (divisor >= MAX_FAST_DIVISOR || rate >= 60.0), "{window_ms} ms: {rate:.1} a second at 1/{divisor}");
            // The image is not coarser than the rate requires, apart from the steps of the divisor.
            let max_rate = if divisor < MAX_FAST_DIVISOR { 80.0 } else { 40.0 };
            assert!(divisor == 1.0 || is_held_coarse || rate < max_rate, "{window_ms} ms: {rate:.1} at 1/{divisor}");
            divisors.push(divisor);
        }
        let [at_4_ms, _, _, _, _, _, at_80_ms, _, _, at_400_ms, _, _, again_at_4_ms] = divisors[..] else { panic!("{divisors:?}") };
        assert!(at_4_ms == 1.0 && at_80_ms == MAX_FAST_DIVISOR && at_400_ms > 3.0 && again_at_4_ms == 1.0, "{divisors:?}");
    }

    #[test]
    fn extreme_times_leave_the_divisor_within_its_range() {
        let mut resolution = AdaptiveResolution::default();
        resolution.record(0, 5.0, 0.0);
        resolution.record(100, f64::NAN, 0.0);
        assert_eq!(resolution.divisor(WINDOW_PIXELS), FIRST_DIVISOR);
        assert_eq!(settled(&mut resolution, 0.0, 1e6, 0.0).1, MAX_DIVISOR);
        assert_eq!(settled(&mut resolution, 0.0, 0.0, f64::NAN).1, 1.0);
        // A long idle time means that nothing moved before the image; it is not recorded.
        let (_, divisor) = settled(&mut resolution, 0.0, 40.0, 0.0);
        assert_eq!(settled(&mut resolution, 0.0, 40.0, 1e5).1, divisor);
    }
}
