//! What the common options name, read from the disk.

use super::{CliError, Common};
use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::session::read_catalog;

/// The embedded catalog under the files of `--catalogs` (every `.toml` in it, in order of name).
pub fn catalog(common: &Common) -> Result<Catalog, CliError> {
    Ok(read_catalog(common.catalogs.as_deref())?.with_eclipse_radii(common.eclipse_radii()))
}

/// The shipped ephemeris under the file of `--kernel`.
pub fn ephemeris(common: &Common, catalog: &Catalog) -> Result<Ephemeris, CliError> {
    let shipped = Ephemeris::embedded(catalog).map_err(|e| CliError(e.to_string()))?;
    let Some(path) = &common.kernel else { return Ok(shipped) };
    let bytes =
        std::fs::read(path).map_err(|e| CliError(format!("{}: {e}; --kernel wants an SPK file such as de440.bsp", path.display())))?;
    shipped.with_kernel(&path.display().to_string(), bytes).map_err(|e| CliError(e.to_string()))
}
