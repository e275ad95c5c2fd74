//! The views that `orrery render` draws: one view at several times, or the views along a tour.
//!
//! In: a request and a step, or a tour file. Out: the request of each frame by its number. Always: the same arguments and
//! file give the same requests, unless a time is `now` or a stop of a tour has none, which also means now.

use super::CliError;
use super::frame_rate::FrameRate;
use crate::scene::request::{Composition, ViewRequest};
use crate::scene::viewpoint::viewer;
use crate::session::Session;
use crate::time::TimeStep;
use std::path::Path;

/// Largest number of frames of a tour: an hour at 60 frames per second.
#[cfg(feature = "view")]
const MAX_TOUR_FRAMES: f64 = 216_000.0;

/// The views of a sequence.
pub(crate) enum Views {
    /// One view at `count` times, one step apart.
    Steps { first: Box<ViewRequest>, step: TimeStep, count: u32 },
    /// The views along a tour, one per frame.
    // Constructed only with the feature `view`, whose module parses tour files.
    #[cfg_attr(not(feature = "view"), expect(dead_code))]
    Tour { title: String, frames: Vec<ViewRequest> },
}

impl Views {
    /// One view at `count` times, one step apart.
    pub(crate) fn steps(first: ViewRequest, step: TimeStep, count: u32) -> Self {
        Self::Steps { first: Box::new(first), step, count }
    }

    /// The views along the tour of a file, `rate` frames per second. `options`: the composition that the command line requests. If it has a projection or a
    /// stereo pair, they replace those of every stop.
    ///
    /// # Errors
    /// A file that cannot be read, an invalid field of a stop, a stop that cannot be drawn with the options, or a tour of more than [`MAX_TOUR_FRAMES`] frames.
    #[cfg(feature = "view")]
    pub(crate) fn along_tour(
        file: &Path,
        (width, height): (u32, u32),
        rate: FrameRate,
        session: &Session,
        options: &Composition,
    ) -> Result<Self, CliError> {
        use super::view_args::parse_time_option;
        use crate::view::app::tour::{MAX_BYTES, Tour, TourFrame};
        use crate::view::app::view_state::ViewState;
        let file_error =
            |why: &dyn std::fmt::Display| CliError::Failed(format!("{}: {why}", crate::wording::echo(&file.display().to_string())));
        let text = crate::files::read_text(file, MAX_BYTES).map_err(|e| file_error(&e))?;
        let tour = Tour::parse(&text, session, parse_time_option("now")?).map_err(|e| file_error(&e))?;
        let (rate_text, rate) = (rate, rate.per_second());
        if tour.length_s() * rate > MAX_TOUR_FRAMES {
            // A tour lasts at most an hour, so only a rate above 60 frames per second can exceed the limit.
            return Err(CliError::Usage(format!(
                "--rate {rate_text}: {:.0} frames, more than {MAX_TOUR_FRAMES}; this tour of {:.1} s can have --rate {:.0}",
                (tour.length_s() * rate).ceil(),
                tour.length_s(),
                (MAX_TOUR_FRAMES / tour.length_s()).floor()
            )));
        }
        let frames = (0..(tour.length_s() * rate).round().max(1.0) as u32).map(|number| {
            let TourFrame { view, stop_index, .. } = tour.at(f64::from(number) / rate);
            let stop_error = |why: &dyn std::fmt::Display| file_error(&format!("stop {}: {why}", stop_index + 1));
            // The composition is replaced in the view, not in its request, because the request takes its field of view from the projection.
            let view = ViewState { composition: view.composition.with_options(options), ..view };
            let mut request = view.request(session.catalog(), session.ephemeris(), width, height).map_err(|e| stop_error(&e))?;
            request.composition.warp.clone_from(&options.warp);
            // `ViewState::request` checked the request before it had a warp mesh; now a stereo pair is refused, because it cannot be warped.
            request.check().map_err(|e| stop_error(&e))?;
            Ok(request)
        });
        Ok(Self::Tour { title: tour.title.clone(), frames: frames.collect::<Result<_, CliError>>()? })
    }

    /// # Errors
    /// Always, because this build lacks the feature `view`, which reads tour files.
    #[cfg(not(feature = "view"))]
    pub(crate) fn along_tour(
        _file: &Path,
        _size: (u32, u32),
        _rate: FrameRate,
        _session: &Session,
        _options: &Composition,
    ) -> Result<Self, CliError> {
        Err(CliError::Failed("--tour needs a build with the feature \"view\"".into()))
    }

    /// Total number of frames.
    pub(crate) fn count(&self) -> u32 {
        match self {
            Self::Steps { count, .. } => *count,
            Self::Tour { frames, .. } => u32::try_from(frames.len()).unwrap_or(u32::MAX),
        }
    }

    /// The request of a frame, counted from 0. A number beyond the end of a tour gives its last frame.
    pub(crate) fn request(&self, number: u32) -> ViewRequest {
        match self {
            Self::Steps { first, step, .. } => ViewRequest { time: step.after(first.time, f64::from(number)), ..(**first).clone() },
            Self::Tour { frames, .. } => frames[(number as usize).min(frames.len() - 1)].clone(),
        }
    }

    /// Checks, before the first frame is drawn, that the camera of the last of several frames can be placed: the ephemeris may end before the time of that
    /// frame. `last`: its number. The views of a tour were checked when its file was read.
    ///
    /// # Errors
    /// The number of that frame, and why it cannot be drawn.
    pub(crate) fn check_last_frame(&self, session: &Session, last: u32) -> Result<(), CliError> {
        match self {
            Self::Steps { count, .. } if *count > 1 => viewer(session.catalog(), session.ephemeris(), &self.request(last))
                .map(drop)
                .map_err(|e| CliError::Failed(format!("frame {last}, the last: {e}; draw fewer --frames, or take a shorter --step"))),
            Self::Steps { .. } | Self::Tour { .. } => Ok(()),
        }
    }

    /// Whether a frame shows a stereo pair or is warped onto a mesh.
    pub(crate) fn has_stereo_or_warp(&self) -> bool {
        let is_stereo_or_warped = |composition: &Composition| composition.stereo.is_some() || composition.warp.is_some();
        match self {
            Self::Steps { first, .. } => is_stereo_or_warped(&first.composition),
            Self::Tour { frames, .. } => frames.iter().any(|request| is_stereo_or_warped(&request.composition)),
        }
    }

    /// The title of the tour, if the views are those of one.
    pub(crate) fn title(&self) -> Option<&str> {
        match self {
            Self::Steps { .. } => None,
            Self::Tour { title, .. } => Some(title),
        }
    }
}
