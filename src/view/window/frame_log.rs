//! A log of how fast the window shows frames and images, for measurements. A frame is the window's content at one moment; an image is a rendered view,
//! which may stay for several frames. The environment variable `ORRERY_LOG_FRAMES` turns the log on.
//!
//! In: each presented frame. Out: lines on standard error: one for the first frame, one for the first image, and one for each second with new images.
//! Always: without the variable nothing is counted or written.

use std::io::Write;
use std::time::{Duration, Instant as WallInstant};

/// Shortest time over which one line counts frames and images.
const INTERVAL: Duration = Duration::from_secs(1);

/// What one presented frame showed.
pub(crate) struct PresentedFrame {
    /// Number of images shown since the program was started.
    pub images_shown: u64,
    /// Size in pixels and render time in milliseconds of the image in the frame, if any.
    pub image: Option<([u32; 2], f64)>,
    /// Time that the window's thread needed for the frame.
    pub took: Duration,
}

/// Counts and total times in the current interval.
#[derive(Default)]
struct Counts {
    frames: u32,
    /// Number of new images.
    images: u64,
    /// Render times of all new images.
    total_render_ms: f64,
    /// Times that the window's thread needed for all frames.
    total_frame_ms: f64,
    /// Number of pixels of all new images.
    total_pixels: u64,
}

/// Writes a line to standard error, if that is possible.
fn write_line(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

pub(crate) struct FrameLog {
    /// When the log was opened, at the start of the event loop.
    opened: WallInstant,
    /// Start of the current interval.
    counting_since: WallInstant,
    /// Number of images shown up to the last frame.
    images_shown: u64,
    counts: Counts,
    has_shown_frame: bool,
}

impl FrameLog {
    /// A log, if the environment variable is set.
    pub(crate) fn of_environment() -> Option<Self> {
        std::env::var_os("ORRERY_LOG_FRAMES")?;
        let now = WallInstant::now();
        Some(Self { opened: now, counting_since: now, images_shown: 0, counts: Counts::default(), has_shown_frame: false })
    }

    /// Counts a frame, and writes the lines that are due.
    pub(crate) fn record(&mut self, frame: &PresentedFrame) {
        let now = WallInstant::now();
        let since_start_s = now.duration_since(self.opened).as_secs_f64();
        if !std::mem::replace(&mut self.has_shown_frame, true) {
            write_line(format_args!("frames: the first frame {since_start_s:.3} s after the event loop's start"));
        }
        if self.images_shown == 0 && frame.images_shown > 0 {
            write_line(format_args!("frames: the first image {since_start_s:.3} s after the event loop's start"));
        }
        let counts = &mut self.counts;
        counts.frames += 1;
        counts.total_frame_ms += frame.took.as_secs_f64() * 1e3;
        if frame.images_shown > self.images_shown
            && let Some(([width, height], render_ms)) = frame.image
        {
            counts.images += 1;
            counts.total_render_ms += render_ms;
            counts.total_pixels += u64::from(width) * u64::from(height);
        }
        self.images_shown = frame.images_shown;
        let elapsed = now.duration_since(self.counting_since);
        if elapsed < INTERVAL {
            return;
        }
        if counts.images > 0 {
            let image_count = counts.images as f64;
            write_line(format_args!(
                "frames: {:.1} images/s, {:.1} frames/s, mean image {:.0} px, {:.1} ms, mean frame {:.1} ms",
                image_count / elapsed.as_secs_f64(),
                f64::from(counts.frames) / elapsed.as_secs_f64(),
                counts.total_pixels as f64 / image_count,
                counts.total_render_ms / image_count,
                counts.total_frame_ms / f64::from(counts.frames),
            ));
        }
        (self.counts, self.counting_since) = (Counts::default(), now);
    }
}
