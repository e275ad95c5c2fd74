//! What the common options name, read from the disk.

use super::{CliError, Common};
use crate::catalog::Catalog;

/// The embedded catalog under the files of `--catalogs` (every `.toml` in it, in order of name).
pub fn catalog(common: &Common) -> Result<Catalog, CliError> {
    let Some(folder) = &common.catalogs else { return Ok(Catalog::embedded()) };
    let refused = |path: &std::path::Path, e: std::io::Error| CliError(format!("{}: {e}", path.display()));
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|e| refused(folder, e))? {
        paths.push(entry.map_err(|e| refused(folder, e))?.path());
    }
    paths.retain(|p| p.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    let mut files = Vec::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).map_err(|e| refused(&path, e))?;
        files.push((path.display().to_string(), text));
    }
    Catalog::with_files(&files).map_err(|e| CliError(e.to_string()))
}
