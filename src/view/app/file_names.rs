//! Names of the files that the window saves. If a file with the name exists already, the name gets a number.
//!
//! In: the name that the user typed, such as `orrery.png` or `out-%05d.png`. Out: names to try in turn, and the names of a sequence's frames. This module
//! writes nothing: the writer uses the first name that it can create, because another program may take a free name in the meantime.

use crate::files::frame_number::{FrameNumberError, NumberedName};
use std::path::{Path, PathBuf};

/// Minimum number of digits of the frame number if the name has no placeholder such as `%05d`.
const DEFAULT_DIGITS: usize = 5;

/// Splits a name into folder and stem, and the extension with its dot; the second part is empty if there is no extension.
fn split_extension(name: &str) -> (&str, &str) {
    // `Path::extension` ignores separators at the end, as in `a.png//`; here such a name has no extension.
    let extension = Path::new(name).extension().and_then(|e| e.to_str()).filter(|e| name.ends_with(e));
    let extension_bytes = extension.map_or(0, |e| e.len() + 1);
    name.split_at(name.len() - extension_bytes)
}

/// The names of a sequence's frames, such as `orrery-00000.png`. If one of these files exists, a number is inserted before the frame number, as in
/// `orrery-2-00000.png`: the smallest for which no frame's file exists. A name without a placeholder gets a placeholder before its extension.
///
/// # Errors
/// If the placeholder is invalid; the message explains how to write it.
pub(crate) fn free_sequence(name: &str, frame_count: u32) -> Result<NumberedName, FrameNumberError> {
    let (stem, extension) = split_extension(name);
    let default_numbering = || NumberedName { prefix: format!("{stem}-"), min_digits: DEFAULT_DIGITS, suffix: extension.to_owned() };
    let first = NumberedName::of(name)?.unwrap_or_else(default_numbering);
    let nth_name = |n: u32| if n == 1 { first.clone() } else { NumberedName { prefix: format!("{}{n}-", first.prefix), ..first.clone() } };
    let is_free = |name: &NumberedName| (0..frame_count).all(|k| !name.path(k).exists());
    Ok((1..=u32::MAX).map(nth_name).find(is_free).unwrap_or(first))
}

/// Names to try in turn: `orrery.png`, `orrery-2.png`, `orrery-3.png`...; if the name has a placeholder, its number counts up from 0 instead.
///
/// # Errors
/// If the placeholder is invalid; the message explains how to write it.
pub(crate) fn candidate_names(name: &str) -> Result<Box<dyn Iterator<Item = PathBuf> + Send>, FrameNumberError> {
    if let Some(numbered) = NumberedName::of(name)? {
        return Ok(Box::new((0..=u32::MAX).map(move |n| numbered.path(n))));
    }
    let (stem, extension) = split_extension(name);
    let (first, stem, extension) = (PathBuf::from(name), stem.to_owned(), extension.to_owned());
    Ok(Box::new(std::iter::once(first).chain((2..=u32::MAX).map(move |n| format!("{stem}-{n}{extension}").into()))))
}

/// The absolute path, for messages.
pub(crate) fn absolute_path(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first_candidates(name: &str, count: usize) -> Vec<String> {
        candidate_names(name).expect(name).take(count).map(|p| p.display().to_string()).collect()
    }

    #[test]
    fn an_existing_name_is_followed_by_numbered_names() {
        assert_eq!(first_candidates("orrery.png", 3), ["orrery.png", "orrery-2.png", "orrery-3.png"]);
        assert_eq!(first_candidates("a.b/view", 2), ["a.b/view", "a.b/view-2"]);
        assert_eq!(first_candidates("a/.hidden", 2), ["a/.hidden", "a/.hidden-2"]);
        // Separators at the end of a name are not part of its extension.
        assert_eq!(first_candidates("a.é//", 2), ["a.é//", "a.é//-2"]);
        assert_eq!(first_candidates("x-%03d.exr", 2), ["x-000.exr", "x-001.exr"]);
        // A percent sign in the name of a folder is not a placeholder.
        assert_eq!(first_candidates("50%/a%d/x.png", 2), ["50%/a%d/x.png", "50%/a%d/x-2.png"]);
        assert_eq!(first_candidates("50%/x-%d.png", 2), ["50%/x-0.png", "50%/x-1.png"]);
        for bad in ["%x.png", "a-%d-%d.png", "100%.png", "%099d.png"] {
            assert!(candidate_names(bad).is_err_and(|why| why.to_string().contains(bad) && why.to_string().contains("%05d")), "{bad}");
        }
    }

    #[test]
    fn a_sequence_gets_the_first_number_for_which_no_frame_exists() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name).display().to_string();
        let sequence = |name: &str, frame_count| free_sequence(&at(name), frame_count).expect(name);
        // A name without a placeholder, such as the field's default, gets a frame number.
        assert_eq!(sequence("orrery.png", 100).path(7).display().to_string(), at("orrery-00007.png"));
        assert_eq!(sequence("x-%d.exr", 100).path(7).display().to_string(), at("x-7.exr"));
        std::fs::write(at("orrery-00099.png"), "").expect("a file");
        assert_eq!(
            sequence("orrery.png", 99).path(0).display().to_string(),
            at("orrery-00000.png"),
            "frame 99 is not part of a sequence of 99 frames"
        );
        assert_eq!(sequence("orrery.png", 100).path(0).display().to_string(), at("orrery-2-00000.png"));
        std::fs::write(at("orrery-2-00000.png"), "").expect("a file");
        assert_eq!(sequence("orrery.png", 100).path(0).display().to_string(), at("orrery-3-00000.png"));
        assert!(free_sequence("%s.png", 3).is_err());
    }

    #[test]
    fn absolute_path_makes_a_relative_path_absolute() {
        assert!(Path::new(&absolute_path(Path::new("orrery.png"))).is_absolute());
    }
}
