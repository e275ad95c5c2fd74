//! Lowers the resolution of images while the camera or the bodies move, to keep the frame rate.
//!
//! In: pixel count and times of finished images. Out: the factor by which the next moving image is smaller than the window, in width and in height. This
//! module reads no clock. Always: the resolution is lowered, to a half at most, to reach 60 images per second; where a half does not suffice, fewer
//! images are accepted, down to 30 per second; only below 30 is the resolution lowered further.

/// Intervals between images, milliseconds: 62 and 32 per second, a little more than the goals, so that a slow image does not miss them.
const FAST_MS: f64 = 1000.0 / 62.0;
const SLOW_MS: f64 = 1000.0 / 32.0;
/// Largest factor by which the image is made coarser to reach the fast interval.
const MAX_FAST_SCALE: f64 = 2.0;
/// Largest factor; coarser images would be unrecognisable.
pub(crate) const MAX_SCALE: f64 = 5.0;
/// The factor until an image has been measured.
const FIRST_SCALE: f64 = 3.0;
/// Factors are multiples of this, so that small changes of the times change nothing.
const SCALE_STEP: f64 = 0.125;
/// Weight of the last image in the running means.
const NEWEST_WEIGHT: f64 = 0.3;
/// Largest waiting time that counts, as a fraction of [`FAST_MS`]: a longer pause is the user's, not the renderer's.
const MAX_WAITING_FRACTION: f64 = 0.5;

/// Recent cost of images.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AdaptiveResolution {
    /// Running mean of the render time; it includes the fixed cost of an image, which does not depend on its pixels.
    ms_per_megapixel: Option<f64>,
    /// Running mean of the time between the end of an image and the start of the next.
    waiting_ms: f64,
    /// The last factor; 0 before the first.
    scale: f64,
}

impl AdaptiveResolution {
    /// Records the render time of an image of `pixels` pixels, and the time for which the renderer waited before it.
    pub(crate) fn record(&mut self, pixels: u64, ms: f64, waiting_ms: f64) {
        if pixels == 0 || !ms.is_finite() {
            return;
        }
        let mean = |old: f64, new: f64| old + NEWEST_WEIGHT * (new - old);
        let new = ms / (pixels as f64 / 1e6);
        self.ms_per_megapixel = Some(self.ms_per_megapixel.map_or(new, |old| mean(old, new)));
        if waiting_ms < MAX_WAITING_FRACTION * FAST_MS {
            self.waiting_ms = mean(self.waiting_ms, waiting_ms);
        }
    }

    /// The factor of width and height for a moving image in a window of `pixels` pixels.
    pub(crate) fn scale(&mut self, pixels: u64) -> f64 {
        let Some(cost) = self.ms_per_megapixel else { return FIRST_SCALE };
        let full_size_ms = cost * pixels as f64 / 1e6;
        let scale_for_interval = |ms: f64| (full_size_ms / (ms - self.waiting_ms)).sqrt();
        let fast = scale_for_interval(FAST_MS);
        let target = if fast <= MAX_FAST_SCALE { fast } else { scale_for_interval(SLOW_MS).clamp(MAX_FAST_SCALE, MAX_SCALE) };
        // A finer image waits until it is well affordable; otherwise the resolution would change all the time.
        if target > self.scale || target < self.scale - 1.5 * SCALE_STEP {
            self.scale = ((target / SCALE_STEP).ceil() * SCALE_STEP).max(1.0);
        }
        self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: u64 = 1_000_000;

    /// The rate and the factor at which a renderer settles that needs `fixed_ms` and `ms` for a whole window, with `waiting_ms` between images.
    fn settled(resolution: &mut AdaptiveResolution, fixed_ms: f64, ms: f64, waiting_ms: f64) -> (f64, f64) {
        let mut last = (0.0, 0.0);
        for _ in 0..60 {
            let scale = resolution.scale(WINDOW);
            let pixels = WINDOW as f64 / (scale * scale);
            let took_ms = fixed_ms + ms * pixels / WINDOW as f64;
            resolution.record(pixels as u64, took_ms, waiting_ms);
            last = (1e3 / (took_ms + waiting_ms), scale);
        }
        last
    }

    #[test]
    fn the_rate_is_kept_by_half_the_resolution_then_lowered_to_half_and_then_kept_again() {
        let mut resolution = AdaptiveResolution::default();
        assert_eq!(resolution.scale(WINDOW), FIRST_SCALE);
        let mut scales = Vec::new();
        for ms in [4.0, 12.0, 20.0, 35.0, 45.0, 60.0, 80.0, 120.0, 200.0, 400.0, 60.0, 20.0, 4.0] {
            let (rate, scale) = settled(&mut resolution, 1.0, ms, 2.0);
            // A finer image waits until it is affordable by one and a half steps.
            let is_coarse = (MAX_FAST_SCALE..=MAX_FAST_SCALE + 1.5 * SCALE_STEP).contains(&scale);
            assert!(rate >= 30.0 && (scale >= MAX_FAST_SCALE || rate >= 60.0), "{ms} ms: {rate:.1} a second at 1/{scale}");
            // The image is not coarser than the rate needs, apart from the steps of the factor.
            let max_rate = if scale < MAX_FAST_SCALE { 80.0 } else { 40.0 };
            assert!(scale == 1.0 || is_coarse || rate < max_rate, "{ms} ms: {rate:.1} at 1/{scale}");
            scales.push(scale);
        }
        assert!(scales[0] == 1.0 && scales[6] == MAX_FAST_SCALE && scales[9] > 3.0 && scales[12] == 1.0, "{scales:?}");
    }

    #[test]
    fn no_time_gives_a_useless_image() {
        let mut resolution = AdaptiveResolution::default();
        resolution.record(0, 5.0, 0.0);
        resolution.record(100, f64::NAN, 0.0);
        assert_eq!(resolution.scale(WINDOW), FIRST_SCALE);
        assert_eq!(settled(&mut resolution, 0.0, 1e6, 0.0).1, MAX_SCALE);
        assert_eq!(settled(&mut resolution, 0.0, 0.0, f64::NAN).1, 1.0);
        // A pause of the user is not a cost.
        let (_, scale) = settled(&mut resolution, 0.0, 40.0, 0.0);
        assert_eq!(settled(&mut resolution, 0.0, 40.0, 1e5).1, scale);
    }
}
