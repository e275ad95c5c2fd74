//! Reads the user's tables of stars, minor planets and comets from disk.
//!
//! In: a path, if the user gave one. Out: the content that replaces the embedded one, or an error for an unreadable file or the first invalid line.

use super::SessionError;
use crate::catalog::small_bodies::SmallBodies;
use crate::catalog::stars::StarCatalog;
use crate::files::read_text;
use crate::wording::echo;
use std::path::Path;
use std::sync::Arc;

/// Name and text of a user's table, if a path is given. `accepted`: which files the option accepts, for the error.
fn read_table(path: Option<&Path>, accepted: &str) -> Result<Option<(String, String)>, SessionError> {
    /// Largest table, bytes; Hipparcos' hip2.dat has 33 MB, MPCORB.DAT 300 MB.
    const MAX_BYTES: u64 = 1 << 30;
    let Some(path) = path else { return Ok(None) };
    let name = path.display().to_string();
    let file_error = |why: String| SessionError::File { path: echo(&name), why: format!("{why}; {accepted}") };
    let text = read_text(path, MAX_BYTES).map_err(|e| file_error(e.to_string()))?;
    Ok(Some((name, text)))
}

/// The stars of a file, if a path is given.
///
/// # Errors
/// A file that cannot be read, or its first invalid line.
pub(super) fn stars(path: Option<&Path>) -> Result<Option<Arc<StarCatalog>>, SessionError> {
    let table = read_table(path, "--stars takes a table with named columns or hip2.dat")?;
    Ok(table.map(|(name, text)| StarCatalog::parse(&name, &text)).transpose()?.map(Arc::new))
}

/// The minor planets and comets of a file, if a path is given.
///
/// # Errors
/// A file that cannot be read, or its first invalid line.
pub(super) fn small_bodies(path: Option<&Path>) -> Result<Option<SmallBodies>, SessionError> {
    let table = read_table(path, "--minor-planets takes a table with named columns, JSON of the JPL's database, or MPCORB.DAT")?;
    Ok(table.map(|(name, text)| SmallBodies::parse(&name, &text)).transpose()?)
}
