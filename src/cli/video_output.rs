//! Writes all frames into one output: a y4m stream on standard output, or an animation file.
//!
//! In: frames in order. Out: the stream, to which each frame is written as soon as it is drawn, or the animation file, which is written after the last frame.
//! Always: an existing file is replaced only if the caller allows it; an interrupted run leaves no animation file. Not here: frames with files of their own.

use super::CliError;
use super::frame_rate::FrameRate;
use super::frames::FrameOutput;
use super::output::stdout_error;
use super::output_file::check_may_be_written;
use crate::files::{FileAccess, try_output_path, write_atomic, write_new};
use crate::image::{AnimationWriter, ImageError, MAX_ANIMATION_PIXELS, SharedBytes, overwrite_with_y4m_frame, write_y4m_header};
use crate::render::frame::Frame;
use crate::wording::echo;
use std::io::Write;
use std::path::PathBuf;

/// Where the frames are written.
pub(crate) enum VideoOutput {
    /// No video: each frame has a file of its own, which `render` writes.
    ImageFiles,
    /// A y4m stream.
    Stream {
        rate: FrameRate,
        /// Standard output, once the stream has begun. Not `std::io::Stdout`, which is line-buffered and would search all bytes for line breaks.
        out: Option<std::fs::File>,
        /// Buffer for the bytes of a frame.
        bytes: Vec<u8>,
    },
    /// An animation file.
    File {
        path: PathBuf,
        overwrite: bool,
        writer: Box<AnimationWriter<SharedBytes>>,
        /// Whether the metadata are written.
        has_texts: bool,
        /// The encoded frames, to which `writer` appends.
        bytes: SharedBytes,
    },
}

fn failed(e: ImageError) -> CliError {
    CliError::Failed(e.to_string())
}

/// Standard output as a file without a buffer. The buffer of `std::io::stdout` must be empty, otherwise the order of the bytes would change.
fn unbuffered_stdout() -> std::io::Result<std::fs::File> {
    #[cfg(unix)]
    let handle = std::os::fd::AsFd::as_fd(&std::io::stdout()).try_clone_to_owned();
    #[cfg(windows)]
    let handle = std::os::windows::io::AsHandle::as_handle(&std::io::stdout()).try_clone_to_owned();
    Ok(handle?.into())
}

impl VideoOutput {
    /// Prepares the output. `size`: width and height of a frame, pixels; `frames`: number of frames; `rate`: of the frames.
    ///
    /// # Errors
    /// A folder that does not exist, a file that must not be replaced, or a size, number of frames or frame rate that the format does not support.
    pub(crate) fn begin(output: &FrameOutput, size: (u32, u32), frames: u32, rate: FrameRate, overwrite: bool) -> Result<Self, CliError> {
        match output {
            FrameOutput::One(_) | FrameOutput::Sequence(_) => Ok(Self::ImageFiles),
            FrameOutput::Stream => Ok(Self::Stream { rate, out: None, bytes: Vec::new() }),
            FrameOutput::Animation(path, format) => {
                try_output_path(path)?;
                check_may_be_written("-o", path, overwrite)?;
                if f64::from(size.0) * f64::from(size.1) * f64::from(frames) > MAX_ANIMATION_PIXELS {
                    return Err(CliError::Usage(format!(
                        "-o {}: more than {:.0} million pixels in all; draw fewer or smaller frames, or write a stream (-o -) to an encoder",
                        echo(&path.display().to_string()),
                        MAX_ANIMATION_PIXELS / 1e6
                    )));
                }
                let whole_rate = rate.whole().ok_or_else(|| {
                    CliError::Usage(format!(
                        "--rate {rate}: an animation has a whole number of frames a second; a y4m stream (-o -) may have others"
                    ))
                })?;
                let bytes = SharedBytes::default();
                let writer =
                    AnimationWriter::new(bytes.clone(), *format, size, frames, whole_rate).map_err(|e| CliError::Usage(e.to_string()))?;
                Ok(Self::File { path: path.clone(), overwrite, writer: Box::new(writer), has_texts: false, bytes })
            }
        }
    }

    /// Adds the next frame. `texts`: keyword and text of the metadata of an animation, asked for with its first frame.
    ///
    /// # Errors
    /// The reason why the frame cannot be written.
    pub(crate) fn add(&mut self, frame: &Frame, texts: impl FnOnce() -> Vec<(&'static str, String)>) -> Result<(), CliError> {
        match self {
            Self::ImageFiles => Ok(()),
            Self::Stream { rate, out, bytes } => {
                let out = match out {
                    Some(out) => out,
                    None => {
                        let stdout = out.insert(unbuffered_stdout().map_err(|e| stdout_error(&e))?);
                        let mut header = Vec::new();
                        write_y4m_header(&mut header, frame.width, frame.height, [rate.frames, rate.seconds]).map_err(failed)?;
                        stdout.write_all(&header).map_err(|e| stdout_error(&e))?;
                        stdout
                    }
                };
                overwrite_with_y4m_frame(bytes, &frame.display);
                out.write_all(bytes).map_err(|e| stdout_error(&e))
            }
            Self::File { writer, has_texts, .. } => {
                if !std::mem::replace(has_texts, true) {
                    writer.add_texts(&texts()).map_err(failed)?;
                }
                writer.add(&frame.display).map_err(failed)
            }
        }
    }

    /// Writes the animation file, if the output is one.
    ///
    /// # Errors
    /// The reason why the file cannot be written.
    pub(crate) fn finish(self) -> Result<(), CliError> {
        let Self::File { path, overwrite, writer, bytes, .. } = self else { return Ok(()) };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::AnimationFormat;

    /// The path is checked before anything is drawn: an error at the end would discard all frames.
    #[test]
    fn an_animation_without_a_folder_is_refused_at_the_start() {
        let folder = tempfile::tempdir().expect("a folder");
        let begin = |path: PathBuf, overwrite: bool| {
            VideoOutput::begin(
                &FrameOutput::Animation(path, AnimationFormat::Gif),
                (4, 4),
                2,
                FrameRate { frames: 25, seconds: 1 },
                overwrite,
            )
        };
        for overwrite in [false, true] {
            for (name, message_part) in [("nowhere/a.gif", "there is no folder"), ("", "this is a folder")] {
                let refused = begin(folder.path().join(name), overwrite).err().expect("refused").to_string();
                assert!(refused.contains(message_part), "{name}: {refused}");
            }
            assert!(begin(folder.path().join("a.gif"), overwrite).is_ok());
        }
    }
}
