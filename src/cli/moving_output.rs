//! Writes all frames into one output: a y4m stream on standard output, or an animation file.
//!
//! In: frames in order. Out: each frame at once on standard output, or a complete file at the end. Always: an existing file is replaced only with
//! `--overwrite`; an interrupted run leaves no file. Not here: single pictures.

use super::CliError;
use super::frames::Output;
use super::output::stdout_error;
use crate::files::{FileAccess, write_atomic, write_new};
use crate::image::{AnimationWriter, ImageError, MAX_ANIMATION_PIXELS as MAX_PIXELS, SharedBytes, write_y4m_frame, write_y4m_header};
use crate::render::frame::Frame;
use crate::wording::echo;
use std::io::Write;
use std::path::PathBuf;

pub(crate) enum MovingOutput {
    /// Each frame has its own file, which is written elsewhere.
    None,
    Stream {
        rate: u32,
        begun: bool,
    },
    File {
        path: PathBuf,
        overwrite: bool,
        writer: Box<AnimationWriter<SharedBytes>>,
        bytes: SharedBytes,
    },
}

fn failed(e: ImageError) -> CliError {
    CliError::Failed(e.to_string())
}

impl MovingOutput {
    /// # Errors
    /// A file that must not be replaced, or a size, number of frames or rate that the format does not support.
    pub(crate) fn begin(output: &Output, size: (u32, u32), frames: u32, rate: u32, overwrite: bool) -> Result<Self, CliError> {
        match output {
            Output::One(_) | Output::Sequence(..) => Ok(Self::None),
            Output::Stream => Ok(Self::Stream { rate, begun: false }),
            Output::Animation(path, format) => {
                let name = echo(&path.display().to_string());
                if path.exists() && !overwrite {
                    return Err(CliError::Failed(format!("-o {name}: this file exists; --overwrite replaces it")));
                }
                if f64::from(size.0) * f64::from(size.1) * f64::from(frames) > MAX_PIXELS {
                    return Err(CliError::Failed(format!(
                        "-o {name}: more than {:.0} million pixels in all; draw fewer or smaller frames, or write a stream (-o -) to an encoder",
                        MAX_PIXELS / 1e6
                    )));
                }
                let bytes = SharedBytes::default();
                let writer = AnimationWriter::new(bytes.clone(), *format, size, frames, rate).map_err(failed)?;
                Ok(Self::File { path: path.clone(), overwrite, writer: Box::new(writer), bytes })
            }
        }
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// The reason why it cannot be written.
    pub(crate) fn add(&mut self, frame: &Frame) -> Result<(), CliError> {
        match self {
            Self::None => Ok(()),
            Self::Stream { rate, begun } => {
                let mut bytes = Vec::new();
                if !std::mem::replace(begun, true) {
                    write_y4m_header(&mut bytes, frame.width, frame.height, *rate).map_err(failed)?;
                }
                write_y4m_frame(&mut bytes, &frame.display).map_err(failed)?;
                let mut out = std::io::stdout();
                out.write_all(&bytes).and_then(|()| out.flush()).map_err(|e| stdout_error(&e))
            }
            Self::File { writer, .. } => writer.add(&frame.display).map_err(failed),
        }
    }

    /// Writes the animation file.
    ///
    /// # Errors
    /// The reason why it cannot be written.
    pub(crate) fn finish(self) -> Result<(), CliError> {
        let Self::File { path, overwrite, writer, bytes } = self else { return Ok(()) };
        writer.finish().map_err(failed)?;
        let bytes = bytes.0.lock();
        let fill = |out: &mut std::io::BufWriter<&mut std::fs::File>| out.write_all(&bytes);
        if overwrite {
            write_atomic(&path, FileAccess::All, fill)?;
        } else {
            write_new([path], FileAccess::All, fill)?;
        }
        Ok(())
    }
}
