//! The output of `orrery render`: where frames are written, which frames of a sequence this process draws, and which of their files exist already.
//!
//! In: options of the command line, and the provenance of each frame. Out: paths, and the numbers of existing frames that need not be drawn. Always: every
//! path of the sequence is checked before anything is drawn. Without `--overwrite` a path must be free, or hold a complete frame or an animation of the same
//! request.

use super::CliError;
use crate::files::check_output_path;
use crate::files::frame_number::NumberedName;
use crate::image::{AnimationFormat, animation_format};
use crate::session::{ExistingImage, Provenance};
use crate::time::TimeStep;
use crate::units::SECONDS_PER_DAY;
use crate::wording::echo;
use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Where frames are written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FrameOutput {
    /// A single image file.
    One(PathBuf),
    /// A file for each frame, whose name contains the frame number.
    Sequence(NumberedName),
    /// A y4m stream on standard output.
    Stream,
    /// A single animation file.
    Animation(PathBuf, AnimationFormat),
}

impl FrameOutput {
    /// As [`Self::parse`], for any name that the system allows. A name that is not UTF-8 has no place for a frame number.
    pub(crate) fn of_option(name: Option<&OsStr>, frame_count: Option<u32>) -> Result<Self, CliError> {
        let Some(not_utf8) = name.filter(|name| name.to_str().is_none()) else {
            return Self::parse(name.and_then(OsStr::to_str), frame_count);
        };
        let path = PathBuf::from(not_utf8);
        // The extension decides which kind of file it is, as for any other name.
        let extension = path.extension().and_then(OsStr::to_str).unwrap_or_default();
        match Self::parse(Some(&format!("file.{extension}")), frame_count)? {
            Self::Animation(_, format) => Ok(Self::Animation(path, format)),
            _ => Ok(Self::One(path)),
        }
    }

    /// The output that `-o` names. `frame_count`: `None` stands for several frames whose number is not known yet.
    pub(crate) fn parse(text: Option<&str>, frame_count: Option<u32>) -> Result<Self, CliError> {
        let Some(text) = text else { return Err(CliError::Usage("no output: give -o out.png (or .exr, out-%05d.png, -)".into())) };
        let invalid = |why: &str| Err(CliError::Usage(format!("-o {}: {why}", echo(text))));
        if text == "-" {
            return Ok(Self::Stream);
        }
        if let Some(format) = animation_format(Path::new(text)) {
            if Path::new(text).file_name().is_some_and(|name| name.to_string_lossy().contains('%')) {
                return invalid("an animation is one file: leave out the frame number");
            }
            return Ok(Self::Animation(text.into(), format));
        }
        // A file named just `.exr` has no extension: its format could not be chosen by the name.
        let extension = Path::new(text).extension().map(|e| e.to_ascii_lowercase());
        if extension.as_ref().is_none_or(|e| e != "png" && e != "exr") {
            let is_video = |e: &OsString| ["mp4", "m4v", "mov", "mkv", "webm", "avi"].iter().any(|video| e == video);
            let stream = match extension {
                Some(e) if e == "y4m" => format!("; a y4m stream goes to standard output: -o - > {}", echo(text)),
                Some(e) if is_video(&e) => format!("; for a video, give a stream to an encoder: -o - | ffmpeg -i - {}", echo(text)),
                _ => String::new(),
            };
            return invalid(&format!("the name must have the extension .png, .exr, .gif or .apng{stream}"));
        }
        match NumberedName::of(text).map_err(|e| CliError::Usage(format!("-o {e}")))? {
            None if frame_count != Some(1) => {
                let count = frame_count.map_or("several".to_owned(), |n| n.to_string());
                invalid(&format!("for {count} frames the name needs a number, such as out-%05d.png"))
            }
            None => Ok(Self::One(text.into())),
            Some(names) => Ok(Self::Sequence(names)),
        }
    }

    /// The file of a frame; `None` if the frames have no files of their own. `number`: the frame's number, from 0.
    pub(crate) fn path(&self, number: u32) -> Option<PathBuf> {
        match self {
            Self::One(path) => Some(path.clone()),
            Self::Sequence(names) => Some(names.path(number)),
            Self::Stream | Self::Animation(..) => None,
        }
    }
}

/// Parses `--step`: a text such as `60s`, `10m`, `6h` or `1d`. A number without a unit is in seconds.
pub(crate) fn parse_step(text: &str) -> Result<TimeStep, CliError> {
    let (number, unit) = text.split_at(text.trim_end_matches(|c: char| c.is_ascii_alphabetic()).len());
    let seconds_of = |n: f64, unit_s: f64| Some(TimeStep::Seconds(n * unit_s)).filter(|_| (n * unit_s).is_finite());
    let step = number.trim().parse::<f64>().ok().and_then(|n| match unit {
        "" | "s" => seconds_of(n, 1.0),
        "m" | "min" => seconds_of(n, 60.0),
        "h" => seconds_of(n, 3600.0),
        "d" => Some(TimeStep::Days(n)).filter(|_| (n * SECONDS_PER_DAY).is_finite()),
        _ => None,
    });
    step.ok_or_else(|| CliError::Usage(format!("--step {}: write a number with s, m, h or d, such as 60s", echo(text))))
}

/// Parses `--shard i/n` as (i, n), with 0 <= i < n: of a sequence that n processes share, this process draws the frames i, i + n, i + 2 n ... Without the
/// option the result is (0, 1), which stands for all frames.
pub(crate) fn parse_shard(text: Option<&str>) -> Result<(u32, u32), CliError> {
    let Some(text) = text else { return Ok((0, 1)) };
    let parsed = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
    parsed
        .filter(|(i, n)| i < n)
        .ok_or_else(|| CliError::Usage(format!("--shard {}: write i/n with i from 0 to n-1, such as 0/4", echo(text))))
}

/// The error for an existing file that this request must not replace; `None` if the path is free or holds the requested image. `starts_now`: the sequence
/// starts at `now`.
fn conflict_error(path: &Path, existing: &ExistingImage, provenance: &Provenance, starts_now: bool) -> Option<CliError> {
    let path = echo(&path.display().to_string());
    let overwrite_hint = "--overwrite replaces it";
    let message = match existing {
        ExistingImage::None | ExistingImage::Same => return None,
        ExistingImage::Other(differences) => {
            // Each run that starts at `now` has other times, so it cannot resume an earlier one.
            let hint = if starts_now && differences.contains("time ") { "; give --time to fix the instant" } else { "" };
            format!("{path} is of another request: {differences}; {overwrite_hint}{hint}")
        }
        ExistingImage::Damaged(why) => {
            format!("{path} is of this request ({}) but damaged: {why}; {overwrite_hint}", provenance.target_time_and_size())
        }
        ExistingImage::Unknown(why) => {
            format!(
                "{path} exists, and its request is unknown ({why}); this one is {}; {overwrite_hint}",
                provenance.target_time_and_size()
            )
        }
    };
    Some(CliError::Failed(message))
}

/// The numbers of the frames whose files exist already, are complete and belong to this request. `requested`: number, path and provenance of each frame.
/// `starts_now`: the sequence starts at `now`.
///
/// # Errors
/// A folder that does not exist, a folder in place of a file, or a file that this request must not replace, unless it may be overwritten.
pub(crate) fn existing_frames(
    requested: impl Iterator<Item = (u32, PathBuf, Provenance)>,
    size: (u32, u32),
    overwrite: bool,
    starts_now: bool,
) -> Result<BTreeSet<u32>, CliError> {
    let mut existing_numbers = BTreeSet::new();
    for (number, path, provenance) in requested {
        check_output_path(&path)?;
        let existing = provenance.examine_existing_image(&path, size);
        if existing == ExistingImage::Same {
            existing_numbers.insert(number);
        } else if let (false, Some(conflict)) = (overwrite, conflict_error(&path, &existing, &provenance, starts_now)) {
            return Err(conflict);
        }
    }
    Ok(existing_numbers)
}

/// Whether the file of an animation may be replaced: it is of this request, or `overwrite` is given.
///
/// # Errors
/// A folder that does not exist, a folder in place of a file, or a file that this request must not replace.
pub(crate) fn may_replace_animation(path: &Path, provenance: &Provenance, overwrite: bool, starts_now: bool) -> Result<bool, CliError> {
    check_output_path(path)?;
    let existing = provenance.compare_with_file(path);
    match conflict_error(path, &existing, provenance, starts_now) {
        Some(conflict) if !overwrite => Err(conflict),
        _ => Ok(overwrite || existing == ExistingImage::Same),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_give_the_paths_of_frames_and_invalid_ones_are_refused() {
        let sequence = FrameOutput::parse(Some("a/out-%05d.png"), Some(10)).expect("a pattern");
        assert_eq!(sequence.path(7), Some("a/out-00007.png".into()));
        assert_eq!(FrameOutput::parse(Some("out-%d.exr"), Some(10)).expect("a pattern").path(12), Some("out-12.exr".into()));
        assert_eq!(FrameOutput::parse(Some("-"), Some(10)).expect("a stream"), FrameOutput::Stream);
        for (bad, frames) in [
            ("out.png", 2),
            ("out.tif", 1),
            ("out-%5x.png", 2),
            ("out-%d-%d.png", 2),
            ("out-%099999d.png", 2),
            ("a/.exr", 1),
            ("out-%d.gif", 2),
        ] {
            assert!(FrameOutput::parse(Some(bad), Some(frames)).unwrap_err().to_string().contains(bad), "{bad}");
        }
        // The number of frames of a tour is not known yet.
        for (frames, count) in [(Some(3), "for 3 frames"), (None, "for several frames")] {
            assert!(FrameOutput::parse(Some("out.png"), frames).unwrap_err().to_string().contains(count), "{frames:?}");
        }
        assert!(FrameOutput::parse(None, Some(1)).unwrap_err().to_string().contains("-o out.png"));
        for (video, command) in [("a.mp4", "-o - | ffmpeg -i - a.mp4"), ("a.WebM", "ffmpeg -i - a.WebM"), ("a.y4m", "-o - > a.y4m")] {
            assert!(FrameOutput::parse(Some(video), Some(9)).unwrap_err().to_string().ends_with(command), "{video}");
        }
    }

    #[test]
    fn a_percent_sign_in_the_name_of_a_folder_is_not_a_frame_number() {
        assert_eq!(FrameOutput::parse(Some("50%/a%d/out.png"), Some(1)).expect("one image"), FrameOutput::One("50%/a%d/out.png".into()));
        let sequence = FrameOutput::parse(Some("a%d/50%/out-%03d.png"), Some(2)).expect("a pattern");
        assert_eq!(sequence.path(7), Some("a%d/50%/out-007.png".into()));
        // The file's name has no number, so all frames would be written to the same file.
        assert!(FrameOutput::parse(Some("a-%d/out.png"), Some(2)).unwrap_err().to_string().contains("the name needs a number"));
    }

    #[test]
    fn steps_and_shards_are_read_or_refused() {
        assert_eq!(parse_step("60s").expect("s"), TimeStep::Seconds(60.0));
        assert_eq!(parse_step("-1.5h").expect("h"), TimeStep::Seconds(-5400.0));
        assert_eq!(parse_step("2d").expect("d"), TimeStep::Days(2.0));
        assert!(parse_step("soon").is_err() && parse_step("1e305d").is_err());
        assert_eq!(parse_shard(Some("3/4")).expect("a shard"), (3, 4));
        assert_eq!(parse_shard(None).expect("no shard"), (0, 1));
        for bad in ["4/4", "0/0", "1", "a/b"] {
            assert!(parse_shard(Some(bad)).unwrap_err().to_string().contains(bad));
        }
    }
}
