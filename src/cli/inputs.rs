//! Reads the files that the common options name, for work that needs no session.
//!
//! In: the common options. Out: the catalog, the ephemeris, the shader sources, and the shader keys that follow from the catalog.

use super::{CliError, Common};
use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::scene::effects::possible_features;
use crate::session::{fragment_times, read_catalog, read_ephemeris, read_fragments, read_lunar_heights, surface_fragments, with_surfaces};
use crate::shader::Lowering;
use crate::shader::fragments::Fragments;
use crate::shader::key::{ShaderKey, keys_of};
use std::collections::BTreeSet;

/// The embedded catalog, overridden by the `.toml` files in the folder of `--catalogs`, in order of their names; with the data of `--radii`,
/// `--lunar-heights` and `--surface`.
pub(crate) fn catalog(common: &Common) -> Result<Catalog, CliError> {
    let heights = read_lunar_heights(common.lunar_heights.as_deref())?;
    let catalog = read_catalog(common.catalogs.as_deref())?.with_eclipse_radii(common.radii).with_lunar_heights(heights);
    Ok(with_surfaces(catalog, &common.surface)?)
}

/// The built-in fragments, overridden by `--shaders` and `--surface`.
pub(crate) fn fragments(common: &Common) -> Result<Fragments, CliError> {
    let from_folder = match &common.shaders {
        Some(folder) => {
            fragment_times(folder).and_then(|times| read_fragments(folder, &times)).map_err(|e| CliError::Failed(e.to_string()))?
        }
        None => Fragments::default(),
    };
    let surfaces = surface_fragments(&common.surface, &from_folder)?;
    Ok(from_folder.and_files(surfaces))
}

/// The embedded ephemeris, overridden by the file of `--kernel`.
pub(crate) fn ephemeris(common: &Common, catalog: &Catalog) -> Result<Ephemeris, CliError> {
    Ok(read_ephemeris(catalog, common.kernel.as_deref())?)
}

/// All shader keys that views of the catalog's bodies can need, whatever effects are switched on.
pub(crate) fn reachable_keys(common: &Common) -> Result<BTreeSet<ShaderKey>, CliError> {
    Ok(keys_of(possible_features(&catalog(common)?)))
}

/// The settings with which modules are lowered to tapes: those of the software renderer.
pub(crate) fn lowering() -> Lowering {
    crate::render::software::lowering()
}
