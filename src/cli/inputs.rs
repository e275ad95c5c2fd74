//! What the common options name, read from the disk.

use super::{CliError, Common};
use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;

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

/// The shipped ephemeris under the file of `--kernel`.
pub fn ephemeris(common: &Common, catalog: &Catalog) -> Result<Ephemeris, CliError> {
    let shipped = Ephemeris::embedded(catalog).map_err(|e| CliError(e.to_string()))?;
    let Some(path) = &common.kernel else { return Ok(shipped) };
    let bytes =
        std::fs::read(path).map_err(|e| CliError(format!("{}: {e}; --kernel wants an SPK file such as de440.bsp", path.display())))?;
    shipped.with_kernel(&path.display().to_string(), bytes).map_err(|e| CliError(e.to_string()))
}
