//! Export of images, sequences and animations to files.
//!
//! In: a view or a tour, file names, image sizes. Out: files. Always: no existing file is overwritten; the query worker (a background thread) draws one
//! frame after the other, so that the user can stop the export between frames; the export continues when the panel is closed; the file of an animation
//! is written only after its last frame.

use crate::files::frame_number::NumberedName;
use crate::files::{FileAccess, try_output_path, write_new};
use crate::image::{AnimationWriter, MAX_ANIMATION_PIXELS, SharedBytes, animation_format};
use crate::render::plan::{FrameImages, SamplingQuality};
use crate::scene::legend::legend_of;
use crate::scene::request::{Purpose, Quality, ViewRequest};
use crate::session::{DrawnFrame, PROVENANCE_CHUNK, Provenance, Session, is_exr, write_new_image};
use crate::view::app::event_view::EventPlayback;
use crate::view::app::file_names::{candidate_names, free_sequence};
use crate::view::app::tour::Tour;
use crate::view::app::view_state::ViewState;
use crate::view::error_texts::error_text;
use crate::view::language::{decimal, text};
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Settings of an exported image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ImageOptions {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Whether names and markers of bodies are drawn.
    pub has_labels: bool,
}

/// The views of an export's frames.
pub(crate) enum FrameViews {
    /// One view, whose displayed time advances by `step_s` seconds from frame to frame; a negative step goes back in time.
    Steps { view: Box<ViewState>, step_s: f64 },
    /// One view in the course of an event: as in its playback, more frames show a short central phase.
    Event { view: Box<ViewState>, playback: EventPlayback, frame_count: u32 },
    /// A tour, drawn at this quality instead of the tour's own.
    Tour { tour: Arc<Tour>, frames_per_s: u32, quality: Quality },
}

impl FrameViews {
    /// The view of a frame, counted from 0.
    fn view(&self, frame: u32) -> ViewState {
        match self {
            Self::Steps { view, step_s } => ViewState { tdb_s: view.tdb_s + f64::from(frame) * step_s, ..(**view).clone() },
            Self::Event { view, playback, frame_count } => {
                let fraction = f64::from(frame) / f64::from((*frame_count).max(2) - 1);
                ViewState { tdb_s: playback.tdb_s_at_fraction(fraction), ..(**view).clone() }
            }
            Self::Tour { tour, frames_per_s, quality } => {
                ViewState { quality: *quality, ..tour.at(f64::from(frame) / f64::from(*frames_per_s)).view }
            }
        }
    }
}

/// An animation that does not have all frames yet.
struct AnimationInProgress {
    writer: AnimationWriter<SharedBytes>,
    /// The part of the file that is encoded already; the writer appends to it.
    bytes: SharedBytes,
    /// The file name that the user typed.
    name: String,
    frame_count: u32,
    frames_per_s: u32,
}

/// The files to which an export writes its frames.
enum ExportOutput {
    /// One file per frame.
    Files(NumberedName),
    /// One file for all frames; `None` while the query worker adds a frame, and after the last frame.
    Animation(Option<Box<AnimationInProgress>>),
}

/// The result of a frame: the file that was written, if any, and the animation, if it needs more frames.
type FrameResult = Result<(Option<PathBuf>, Option<Box<AnimationInProgress>>), String>;

/// A running export.
pub(crate) struct Export {
    views: Arc<FrameViews>,
    output: ExportOutput,
    options: ImageOptions,
    /// Number of finished frames.
    finished_count: u32,
    /// Number of all frames.
    frame_count: u32,
    /// Start of the export, in egui's time (`InputState::time`); NaN before the start.
    started_s: f64,
    /// The frame that is being drawn and written.
    pending_frame: Pending<FrameResult>,
}

impl Export {
    /// An export that writes each frame to a file of its own. `name`: a file name, which may contain a placeholder for the frame number.
    ///
    /// # Errors
    /// If the name's placeholder for the frame number is invalid; the message explains how to write it.
    pub(crate) fn sequence(views: FrameViews, name: &str, frame_count: u32, options: ImageOptions) -> Result<Self, String> {
        let files = free_sequence(name, frame_count).map_err(|e| error_text(&e))?;
        Ok(Self::new(views, ExportOutput::Files(files), frame_count, options))
    }

    /// An export of all frames as one animation.
    ///
    /// # Errors
    /// If the extension is not that of an animation format, the format does not support the size or the rate, all frames together have more
    /// than [`MAX_ANIMATION_PIXELS`], or no file can be written in the folder.
    pub(crate) fn animation(
        views: FrameViews,
        name: &str,
        frame_count: u32,
        frames_per_s: u32,
        options: ImageOptions,
    ) -> Result<Self, String> {
        let file_format = animation_format(Path::new(name)).ok_or_else(|| text!("export-ending", name = name))?;
        let [width, height] = options.size_px;
        if f64::from(width) * f64::from(height) * f64::from(frame_count) > MAX_ANIMATION_PIXELS {
            return Err(text!("export-too-large", millions = decimal(MAX_ANIMATION_PIXELS / 1e6, 0)));
        }
        // Tested now, because the file itself is written only after the last frame, and a frame takes up to minutes.
        if let Some(file) = files_of_animation(name)?.find(|file| !file.exists()) {
            try_output_path(&file).map_err(|e| error_text(&e))?;
        }
        let bytes = SharedBytes::default();
        let writer = AnimationWriter::new(bytes.clone(), file_format, (width, height), frame_count, frames_per_s);
        let writer = writer.map_err(|e| error_text(&e))?;
        let animation = AnimationInProgress { writer, bytes, name: name.to_owned(), frame_count, frames_per_s };
        Ok(Self::new(views, ExportOutput::Animation(Some(Box::new(animation))), frame_count, options))
    }

    fn new(views: FrameViews, output: ExportOutput, frame_count: u32, options: ImageOptions) -> Self {
        let pending_frame = Pending::default();
        Self { views: Arc::new(views), output, options, finished_count: 0, frame_count, started_s: f64::NAN, pending_frame }
    }

    /// Starts the first frame. `now_s`: egui's time.
    pub(crate) fn start(mut self, worker: &dyn RenderWorker, now_s: f64) -> Self {
        self.started_s = now_s;
        self.start_next_frame(worker);
        self
    }

    /// Finished fraction of the frames, 0 to 1.
    pub(crate) fn fraction(&self) -> f32 {
        self.finished_count as f32 / self.frame_count.max(1) as f32
    }

    /// The progress, such as `12 of 60, about 20 s left`. `now_s`: egui's time.
    pub(crate) fn progress_text(&self, now_s: f64) -> String {
        let remaining = match (self.finished_count, now_s - self.started_s) {
            (0, _) => String::new(),
            (finished, elapsed_s) => {
                format!(", {}", remaining_text(elapsed_s / f64::from(finished) * f64::from(self.frame_count - finished)))
            }
        };
        text!("export-progress", done = self.finished_count, count = self.frame_count, left = remaining)
    }

    /// Takes a finished frame and starts the next one. Returns a message and whether the export has ended; `None` while the frame is being drawn.
    /// `saved_message`: formats the message about a written file.
    pub(crate) fn poll(&mut self, worker: &dyn RenderWorker, saved_message: impl Fn(&Path) -> String) -> Option<(String, bool)> {
        let (path, animation) = match self.pending_frame.take()? {
            Ok(result) => result,
            Err(why) => {
                let is_over = true;
                return Some((why, is_over));
            }
        };
        self.finished_count += 1;
        let is_over = self.finished_count >= self.frame_count;
        if let ExportOutput::Animation(in_progress) = &mut self.output {
            *in_progress = animation;
        }
        if !is_over {
            self.start_next_frame(worker);
        }
        let message = match (&self.output, path) {
            (ExportOutput::Files(_), Some(path)) => {
                text!("export-saved-frame", done = self.finished_count, count = self.frame_count, saved = saved_message(&path))
            }
            (_, Some(path)) => saved_message(&path),
            (_, None) => text!("export-recording", done = self.finished_count, count = self.frame_count),
        };
        Some((message, is_over))
    }

    /// Asks the query worker to draw and write the next frame.
    fn start_next_frame(&mut self, worker: &dyn RenderWorker) {
        // The number of the frame, from 0.
        let frame = self.finished_count;
        let (views, options) = (Arc::clone(&self.views), self.options);
        self.pending_frame = match &mut self.output {
            ExportOutput::Files(files) => {
                let file = files.path(frame);
                ask(worker, move |session| Ok((Some(save(session, &views.view(frame), options, std::iter::once(file))?), None)))
            }
            ExportOutput::Animation(animation) => {
                let Some(animation) = animation.take() else { return };
                ask(worker, move |session| add_frame(session, animation, &views, frame, options))
            }
        };
    }
}

/// The remaining time, such as `about 2 min left`.
fn remaining_text(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => text!("export-moment-left").into(),
        s if s < 90.0 => text!("export-seconds-left", s = decimal(s, 0)),
        s if s < 5400.0 => text!("export-minutes-left", minutes = decimal(s / 60.0, 0)),
        s => text!("export-hours-left", hours = decimal(s / 3600.0, 1)),
    }
}

/// Draws a frame, counted from 0, adds it to an animation, and writes the file after the last frame.
fn add_frame(
    session: &Session,
    mut animation: Box<AnimationInProgress>,
    views: &FrameViews,
    frame: u32,
    options: ImageOptions,
) -> FrameResult {
    let for_exr = false;
    let view = views.view(frame);
    let (request, drawn) = draw(session, &view, options, for_exr)?;
    if frame == 0 {
        let provenance = animation_provenance(session, views, options, animation.frame_count, animation.frames_per_s)?;
        let texts = metadata(session, &view, &request, &drawn, &provenance);
        animation.writer.add_texts(&texts).map_err(|e| error_text(&e))?;
    }
    animation.writer.add(&drawn.frame.display).map_err(|e| error_text(&e))?;
    if frame + 1 < animation.frame_count {
        return Ok((None, Some(animation)));
    }
    let AnimationInProgress { writer, bytes, name, .. } = *animation;
    writer.finish().map_err(|e| error_text(&e))?;
    let bytes = bytes.0.lock();
    let path = write_new(files_of_animation(&name)?, FileAccess::All, |out| out.write_all(&bytes)).map_err(|e| error_text(&e))?;
    Ok((Some(path), None))
}

/// The provenance of all frames of an animation.
fn animation_provenance(
    session: &Session,
    views: &FrameViews,
    options: ImageOptions,
    frame_count: u32,
    frames_per_s: u32,
) -> Result<Provenance, String> {
    let for_exr = false;
    let mut error = None;
    let frames = (0..frame_count).map_while(|frame| match request_of(session, &views.view(frame), options, for_exr) {
        Ok(request) => Some(session.provenance(&request)),
        Err(why) => {
            error = Some(why);
            None
        }
    });
    let provenance = Provenance::of_animation(frames, frames_per_s);
    error.map_or(Ok(provenance), Err)
}

/// The metadata of an image, or of an animation by its first frame: keyword and text.
fn metadata(
    session: &Session,
    view: &ViewState,
    request: &ViewRequest,
    drawn: &DrawnFrame,
    provenance: &Provenance,
) -> Vec<(&'static str, String)> {
    vec![
        ("Title", session.catalog().body(view.target).map_or("Orrery".into(), |b| b.name.clone())),
        ("Creation Time", request.time.to_utc_iso()),
        ("Description", view.to_link()),
        ("Legend", legend_of(&drawn.scene)),
        ("Software", format!("orrery {}", env!("CARGO_PKG_VERSION"))),
        (PROVENANCE_CHUNK, provenance.to_text()),
    ]
}

/// The files to try for an animation with this name, in turn.
fn files_of_animation(name: &str) -> Result<impl Iterator<Item = PathBuf>, String> {
    let files = candidate_names(name).map_err(|e| error_text(&e))?;
    Ok(files.map(|file| std::path::absolute(&file).unwrap_or(file)))
}

/// The request of an exported image; `for_exr`: of an EXR file.
fn request_of(session: &Session, view: &ViewState, options: ImageOptions, for_exr: bool) -> Result<ViewRequest, String> {
    let [width, height] = options.size_px;
    let mut request: ViewRequest = view.request(session.catalog(), session.ephemeris(), width, height).map_err(|e| error_text(&e))?;
    request.layers.labels = options.has_labels;
    request.purpose = Purpose::of_file(for_exr);
    Ok(request)
}

/// Draws one image by [`Session::draw_in_background`]; `for_exr`: also returns its linear light, for an EXR file.
fn draw(session: &Session, view: &ViewState, options: ImageOptions, for_exr: bool) -> Result<(ViewRequest, DrawnFrame), String> {
    let request = request_of(session, view, options, for_exr)?;
    let images = if for_exr { FrameImages::DisplayAndHdr } else { FrameImages::Display };
    let drawn = session.draw_in_background(&request, SamplingQuality::of(request.quality), images).map_err(|e| error_text(&e))?;
    Ok((request, drawn))
}

/// Draws a view and writes it to the first path of `files` at which there is no file; returns that path. All paths must have the same extension.
///
/// # Errors
/// If the extension is neither PNG nor EXR, or the image cannot be drawn or written; the error is a text in the window's language.
pub(crate) fn save(
    session: &Session,
    view: &ViewState,
    options: ImageOptions,
    files: impl Iterator<Item = PathBuf>,
) -> Result<PathBuf, String> {
    let mut files = files.peekable();
    let path = files.peek().cloned().unwrap_or_default();
    let is_supported = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) || is_exr(&path);
    if !is_supported {
        return Err(text!("export-image-ending", file = path.display()));
    }
    let (request, drawn) = draw(session, view, options, is_exr(&path))?;
    let texts = metadata(session, view, &request, &drawn, &session.provenance(&request));
    let files = files.map(|file| std::path::absolute(&file).unwrap_or(file));
    write_new_image(files, is_exr(&path), &drawn.frame, &texts).map_err(|e| error_text(&e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remaining_time_has_a_suitable_unit() {
        for (seconds, text) in
            [(0.2, "a moment left"), (20.4, "about 20 s left"), (600.0, "about 10 min left"), (9000.0, "about 2.5 h left")]
        {
            assert_eq!(remaining_text(seconds), text);
        }
    }
}
