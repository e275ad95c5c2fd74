//! Writes the output file of a command: the image of `compare -o`, the plots of `measure -o`, the GeoJSON of `eclipse find --path`, the
//! module of `shader emit -o`.
//!
//! In: the option that names the file, the path, the bytes. Out: the file. Always: without `--overwrite`, an existing file with other content is kept, and
//! the error names it; a command can be repeated, because a file with the same content is no error.

use super::CliError;
use crate::files::{FileAccess, read_bytes, write_atomic, write_new};
use crate::image::MAX_FILE_BYTES;
use crate::wording::echo;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Checks, before long work, that a file does not exist or may be replaced. Unlike [`write_output_file`], this refuses an existing file even if the work would
/// produce the same content.
pub(super) fn check_may_be_written(option: &str, path: &Path, overwrite: bool) -> Result<(), CliError> {
    if path.exists() && !overwrite { Err(exists_error(option, path)) } else { Ok(()) }
}

fn exists_error(option: &str, path: &Path) -> CliError {
    CliError::Failed(format!("{option} {}: this file exists; --overwrite replaces it", echo(&path.display().to_string())))
}

/// Writes the bytes. Without `overwrite`, an existing file with other content is an error.
pub(super) fn write_output_file(option: &str, path: &Path, bytes: &[u8], overwrite: bool) -> Result<(), CliError> {
    let fill = |out: &mut BufWriter<&mut File>| out.write_all(bytes);
    if overwrite {
        return Ok(write_atomic(path, FileAccess::All, fill)?);
    }
    match read_bytes(path, MAX_FILE_BYTES) {
        Ok(existing) if existing == bytes => Ok(()),
        // Either the path is free, or it names a folder or a device, for which `write_new` fails.
        Err(_) if !path.is_file() => Ok(write_new([path.to_owned()], FileAccess::All, fill).map(drop)?),
        // Other content, or a file that cannot be compared because it is too long or not readable.
        _ => Err(exists_error(option, path)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The content of the second file is not known, because it is longer than any file that is read.
    #[test]
    fn a_file_with_other_or_unknown_content_is_kept_and_the_message_says_how_to_replace_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.json");
        let [keep, overwrite] = [false, true];
        for length in [3, MAX_FILE_BYTES + 1] {
            File::create(&path).and_then(|file| file.set_len(length)).expect("a file");
            let refused = write_output_file("-o", &path, b"abc", keep).expect_err("refused").to_string();
            assert!(refused.contains("--overwrite"), "{length}: {refused}");
            assert_eq!(path.metadata().expect("a file").len(), length);
        }
        write_output_file("-o", &path, b"abc", overwrite).expect("replaced");
        write_output_file("-o", &path, b"abc", keep).expect("the same content");
    }
}
