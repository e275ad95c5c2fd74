//! Lowers the resolution of images while the camera or the bodies move, to keep the frame rate.
//!
//! In: pixel count and render time of finished images. Out: the divisor of the window's width and height for the next moving image. This
//! module reads no clock.

/// Time budget of a moving frame, milliseconds: for 30 frames per second, with time left for the interface.
const BUDGET_MS: f64 = 26.0;
/// Largest divisor; coarser images would be unrecognisable.
pub(crate) const MAX_DIVISOR: u32 = 5;
/// Weight of the last frame in the running mean.
const NEWEST_WEIGHT: f64 = 0.4;

/// Recent cost of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct AdaptiveResolution {
    /// Running mean. The fixed cost of a frame is included, as if its pixels caused it.
    ms_per_megapixel: Option<f64>,
}

impl AdaptiveResolution {
    /// Records the render time of a frame of `pixels` pixels.
    pub(crate) fn record(&mut self, pixels: u64, ms: f64) {
        if pixels == 0 || !ms.is_finite() {
            return;
        }
        let new = ms / (pixels as f64 / 1e6);
        self.ms_per_megapixel = Some(self.ms_per_megapixel.map_or(new, |old| old + NEWEST_WEIGHT * (new - old)));
    }

    /// The divisor of width and height for a moving frame in a window of `pixels` pixels.
    pub(crate) fn divisor(&self, pixels: u64) -> u32 {
        let Some(cost) = self.ms_per_megapixel else { return 3 };
        let full_size_ms = cost * pixels as f64 / 1e6;
        let side = (full_size_ms / BUDGET_MS).max(1.0).sqrt();
        (side.ceil() as u32).clamp(1, MAX_DIVISOR)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_frames_lower_the_resolution_and_fast_ones_restore_it() {
        let mut resolution = AdaptiveResolution::default();
        for _ in 0..20 {
            resolution.record(1_000_000, 10.0);
        }
        assert_eq!(resolution.divisor(1_000_000), 1);
        for _ in 0..20 {
            resolution.record(1_000_000, 4.0 * BUDGET_MS);
        }
        assert_eq!(resolution.divisor(1_000_000), 2);
        assert_eq!(resolution.divisor(1_000_000_000), MAX_DIVISOR);
        resolution.record(0, f64::NAN);
        assert_eq!(resolution.divisor(1_000_000), 2);
    }
}
