//! File names with a placeholder for the frame number, such as `out-%05d.png`.
//!
//! In: the name that the user typed. Out: the name of each frame's file. Always: only the file's name has a placeholder; a percent sign in the name of a
//! folder is just a character. Not here: which of these files exist.

use crate::wording::echo;
use std::path::PathBuf;

/// Largest width of a frame number in a name. A `u32` has at most 10 digits; two more do no harm, and thousands would make the name too long.
const MAX_NUMBER_DIGITS: usize = 12;

/// The name has an invalid placeholder for the frame number.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: write the frame number as %d or %05d, once")]
pub(crate) struct FrameNumberError {
    /// The name as it was given, with control characters escaped.
    name: String,
}

/// A name with a placeholder for the frame number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NumberedName {
    /// Folder, and the file name up to the placeholder.
    pub prefix: String,
    /// Minimum number of digits.
    pub min_digits: usize,
    /// The file name after the placeholder.
    pub suffix: String,
}

impl NumberedName {
    /// Parses the placeholder of a name, `%d` or `%05d`; `None` if there is no placeholder.
    ///
    /// # Errors
    /// If the placeholder is invalid; the message quotes the name and explains how to write it.
    pub(crate) fn of(name: &str) -> Result<Option<Self>, FrameNumberError> {
        let (folder, file) = name.split_at(name.rfind(std::path::is_separator).map_or(0, |separator| separator + 1));
        let Some((prefix, rest)) = file.split_once('%') else { return Ok(None) };
        let found = rest.split_once('d').and_then(|(width, suffix)| {
            let min_digits = match width {
                "" => 0,
                _ => {
                    let digits = width.strip_prefix('0').filter(|digits| digits.bytes().all(|b| b.is_ascii_digit()))?;
                    digits.parse::<usize>().ok().filter(|min_digits| *min_digits <= MAX_NUMBER_DIGITS)?
                }
            };
            (!suffix.contains('%')).then(|| Self { prefix: format!("{folder}{prefix}"), min_digits, suffix: suffix.to_owned() })
        });
        found.map(Some).ok_or_else(|| FrameNumberError { name: echo(name) })
    }

    /// The file of a frame.
    pub(crate) fn path(&self, number: u32) -> PathBuf {
        let Self { prefix, min_digits, suffix } = self;
        format!("{prefix}{number:0min_digits$}{suffix}").into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_placeholder_is_read_in_the_name_of_the_file_alone() {
        let path = |name: &str, number| NumberedName::of(name).expect(name).map(|n| n.path(number));
        assert_eq!(path("a/out-%05d.png", 7), Some("a/out-00007.png".into()));
        assert_eq!(path("out-%d.exr", 12), Some("out-12.exr".into()));
        assert_eq!(path("a%d/50%/out-%03d.png", 7), Some("a%d/50%/out-007.png".into()));
        for none in ["out.png", "50%/a%d/out.png", "a-%d/out.png", ""] {
            assert_eq!(path(none, 7), None, "{none}");
        }
    }

    #[test]
    fn the_error_for_an_invalid_placeholder_shows_a_valid_one() {
        for bad in ["%x.png", "a-%d-%d.png", "100%.png", "out-%5d.png", "%099d.png", "%0+5d.png"] {
            let why = NumberedName::of(bad).expect_err(bad).to_string();
            assert!(why.contains(bad) && why.contains("%05d"), "{why}");
        }
        assert!(!NumberedName::of("\u{1b}%.png").expect_err("refused").to_string().contains('\u{1b}'));
    }
}
