//! Writes the output file of a verb: the image of `compare -o`, the GeoJSON of `eclipse find --path`.
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

/// Writes the bytes. Without `overwrite`, an existing file with other content is an error.
pub(super) fn write_output_file(option: &str, path: &Path, bytes: &[u8], overwrite: bool) -> Result<(), CliError> {
    let fill = |out: &mut BufWriter<&mut File>| out.write_all(bytes);
    if overwrite {
        return Ok(write_atomic(path, FileAccess::All, fill)?);
    }
    match read_bytes(path, MAX_FILE_BYTES) {
        Ok(existing) if existing == bytes => Ok(()),
        Ok(_) => {
            let name = echo(&path.display().to_string());
            Err(CliError::Failed(format!("{option} {name}: this file exists; --overwrite replaces it")))
        }
        Err(_) => Ok(write_new([path.to_owned()], FileAccess::All, fill).map(drop)?),
    }
}
