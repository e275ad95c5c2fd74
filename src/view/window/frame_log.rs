//! A log of what the window shows, for measurements. The environment variable `ORRERY_LOG_FRAMES` turns it on.
//!
//! In: each presented frame of the window. Out: lines on standard error: one for the first frame, one for the first image, and one for each
//! second with new images. Always: without the variable nothing is counted or written.

use std::io::Write;
use std::time::{Duration, Instant as WallInstant};

/// Smallest interval between lines.
const INTERVAL: Duration = Duration::from_secs(1);

/// What one presented frame showed.
pub(crate) struct PresentedFrame {
    /// Number of images received since the window was opened.
    pub images: u64,
    /// Size in pixels and render time in milliseconds of the last image, if any.
    pub image: Option<([u32; 2], f64)>,
    /// Time for the frame on the window's thread.
    pub took: Duration,
}

/// Counts and total times since the last line.
#[derive(Default)]
struct Counts {
    frames: u32,
    images: u64,
    image_ms: f64,
    frame_ms: f64,
    /// Pixels of all images.
    pixels: u64,
}

/// Writes a line to standard error. A failure is ignored.
fn write_line(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

pub(crate) struct FrameLog {
    started: WallInstant,
    /// Start of the counts.
    counting_since: WallInstant,
    /// Number of images received when the last frame was recorded.
    last_images: u64,
    counts: Counts,
    has_shown_frame: bool,
}

impl FrameLog {
    /// A log, if the environment variable is set.
    pub(crate) fn of_environment() -> Option<Self> {
        std::env::var_os("ORRERY_LOG_FRAMES")?;
        let now = WallInstant::now();
        Some(Self { started: now, counting_since: now, last_images: 0, counts: Counts::default(), has_shown_frame: false })
    }

    /// Counts a frame, and writes a line if it is due.
    pub(crate) fn record(&mut self, frame: &PresentedFrame) {
        let now = WallInstant::now();
        let since_start_s = now.duration_since(self.started).as_secs_f64();
        if !std::mem::replace(&mut self.has_shown_frame, true) {
            write_line(format_args!("frames: the first frame {since_start_s:.3} s after the event loop's start"));
        }
        if self.last_images == 0 && frame.images > 0 {
            write_line(format_args!("frames: the first image {since_start_s:.3} s after the event loop's start"));
        }
        let counts = &mut self.counts;
        counts.frames += 1;
        counts.frame_ms += frame.took.as_secs_f64() * 1e3;
        if frame.images > self.last_images
            && let Some(([width, height], ms)) = frame.image
        {
            counts.images += 1;
            counts.image_ms += ms;
            counts.pixels += u64::from(width) * u64::from(height);
        }
        self.last_images = frame.images;
        let elapsed = now.duration_since(self.counting_since);
        if elapsed < INTERVAL {
            return;
        }
        if counts.images > 0 {
            let images = counts.images as f64;
            write_line(format_args!(
                "frames: {:.1} images/s, {:.1} frames/s, mean image {:.0} px, {:.1} ms, mean frame {:.1} ms",
                images / elapsed.as_secs_f64(),
                f64::from(counts.frames) / elapsed.as_secs_f64(),
                counts.pixels as f64 / images,
                counts.image_ms / images,
                counts.frame_ms / f64::from(counts.frames),
            ));
        }
        (self.counts, self.counting_since) = (Counts::default(), now);
    }
}
