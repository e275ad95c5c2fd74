//! Reads the user's map of the Moon's heights from disk.
//!
//! In: `FILE`, or `FILE,LOW,HIGH` with the heights that black and white pixels stand for, in km above a sphere with a radius of 1737.4 km. Out: the
//! map, or an error in one line. A PDS label names its image file; an image file `.img` is read with the label of the same name. The format of any other
//! file is detected from its first bytes.

use super::SessionError;
use crate::catalog::lunar_heights::{HeightMap, HeightMapError, HeightRange, MAX_FILE_BYTES, MAX_LABEL_BYTES};
use crate::files::{check_inside, read_bytes, read_text};
use crate::wording::echo;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Splits `FILE,LOW,HIGH`. If a file with the complete text as its name exists, the text is not split.
fn split_argument(argument: &OsStr) -> (PathBuf, Option<HeightRange>) {
    let whole = PathBuf::from(argument);
    let parts = argument.to_str().filter(|_| !whole.is_file()).map(|text| text.rsplitn(3, ',').collect::<Vec<_>>());
    if let Some([white, black, file]) = parts.as_deref()
        && let (Ok(white_km), Ok(black_km)) = (white.trim().parse(), black.trim().parse())
    {
        return (PathBuf::from(file), Some(HeightRange { black_km, white_km }));
    }
    (whole, None)
}

/// Reads the map that the option `--lunar-heights` names.
///
/// # Errors
/// The file that cannot be read, and why.
pub fn read_lunar_heights(argument: Option<&OsStr>) -> Result<Option<Arc<HeightMap>>, SessionError> {
    let Some(argument) = argument else { return Ok(None) };
    let (path, range) = split_argument(argument);
    let name = path.display().to_string();
    let file_error = |file: &str, why: &str| SessionError::File { path: echo(file), why: format!("--lunar-heights: {why}") };
    let invalid_map = |e: HeightMapError| file_error(&e.file, &e.why);
    if let Some(HeightRange { black_km, white_km }) = range
        && !(black_km.is_finite() && white_km.is_finite() && black_km < white_km)
    {
        return Err(file_error(&name, &format!("the height of black ({black_km:?} km) must lie below that of white ({white_km:?} km)")));
    }
    let extension = path.extension().map(|e| e.to_ascii_lowercase()).unwrap_or_default();
    let read_image = |path: &Path| read_bytes(path, MAX_FILE_BYTES).map_err(|e| file_error(&path.display().to_string(), &e.to_string()));
    if extension != "lbl" && extension != "img" {
        return HeightMap::of_image(&name, &read_image(&path)?, range).map(Arc::new).map(Some).map_err(invalid_map);
    }
    if range.is_some() {
        return Err(file_error(&name, "a PDS label says what its numbers mean: leave out the heights of black and white"));
    }
    let label = if extension == "lbl" { path.clone() } else { with_extension_in_any_case(&path, "lbl") };
    let label_name = label.display().to_string();
    let text = read_text(&label, MAX_LABEL_BYTES).map_err(|e| file_error(&label_name, &format!("the image's label: {e}")))?;
    let image = match extension == "img" {
        true => path,
        false => {
            let image_name = HeightMap::image_of_label(&label_name, &text).map_err(invalid_map)?;
            let exact = label.with_file_name(&image_name);
            // Archives write names in capitals; local copies often have lower case.
            let image = if exact.is_file() { exact } else { label.with_file_name(image_name.to_ascii_lowercase()) };
            let folder = label.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
            check_inside(folder, &image).map_err(|e| file_error(&label_name, &format!("its image {}: {e}", echo(&image_name))))?;
            image
        }
    };
    HeightMap::of_pds(&label_name, &text, &read_image(&image)?).map(Arc::new).map(Some).map_err(invalid_map)
}

/// The path with another extension in lower case, or in capitals if only that file exists.
fn with_extension_in_any_case(path: &Path, extension: &str) -> PathBuf {
    let lower_case = path.with_extension(extension);
    let upper_case = path.with_extension(extension.to_ascii_uppercase());
    if !lower_case.is_file() && upper_case.is_file() { upper_case } else { lower_case }
}
