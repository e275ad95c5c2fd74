//! A log of what the window shows, for measurements: the variable `ORRERY_LOG_FRAMES` turns it on.
//!
//! In: each presented frame of the window. Out: lines on standard error, one per second with new images, and one each for the first frame and the first
//! image. Always: without the variable nothing is counted or written.

use std::io::Write;
use std::time::{Duration, Instant as WallInstant};

/// Interval of the lines.
const INTERVAL: Duration = Duration::from_secs(1);

/// What one presented frame showed.
pub(crate) struct PresentedFrame {
    /// Number of images received since the window was opened.
    pub images: u64,
    /// Size in pixels and render time in milliseconds of the last image, if any.
    pub image: Option<([u32; 2], f64)>,
    /// Time that the frame took on the window's thread.
    pub took: Duration,
}

/// Counts since the last line.
#[derive(Default)]
struct Counts {
    frames: u32,
    images: u64,
    image_ms: f64,
    frame_ms: f64,
    pixels: u64,
}

/// A closed stream has no reader, so a failure is ignored.
fn write_line(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

pub(crate) struct FrameLog {
    opened: WallInstant,
    since: WallInstant,
    images_before: u64,
    counts: Counts,
    has_shown: bool,
}

impl FrameLog {
    /// A log, if the environment asks for it.
    pub(crate) fn of_environment() -> Option<Self> {
        std::env::var_os("ORRERY_LOG_FRAMES")?;
        let now = WallInstant::now();
        Some(Self { opened: now, since: now, images_before: 0, counts: Counts::default(), has_shown: false })
    }

    /// Counts a frame, and writes a line if it is due.
    pub(crate) fn record(&mut self, frame: &PresentedFrame) {
        let now = WallInstant::now();
        let after_s = now.duration_since(self.opened).as_secs_f64();
        if !std::mem::replace(&mut self.has_shown, true) {
            write_line(format_args!("frames: the first frame {after_s:.3} s after the event loop's start"));
        }
        if self.images_before == 0 && frame.images > 0 {
            write_line(format_args!("frames: the first image {after_s:.3} s after the event loop's start"));
        }
        let counts = &mut self.counts;
        counts.frames += 1;
        counts.frame_ms += frame.took.as_secs_f64() * 1e3;
        if frame.images > self.images_before
            && let Some(([width, height], ms)) = frame.image
        {
            counts.images += 1;
            counts.image_ms += ms;
            counts.pixels += u64::from(width) * u64::from(height);
        }
        self.images_before = frame.images;
        let passed = now.duration_since(self.since);
        if passed < INTERVAL {
            return;
        }
        if counts.images > 0 {
            let images = counts.images as f64;
            write_line(format_args!(
                "frames: {:.1} images/s, {:.1} frames/s, mean image {:.0} px, {:.1} ms, mean frame {:.1} ms",
                images / passed.as_secs_f64(),
                f64::from(counts.frames) / passed.as_secs_f64(),
                counts.pixels as f64 / images,
                counts.image_ms / images,
                counts.frame_ms / f64::from(counts.frames),
            ));
        }
        (self.counts, self.since) = (Counts::default(), now);
    }
}
