//! Errors of opening a session and of drawing a view.
//!
//! In: the errors of the stages. Out: one error type for all of them, and one for the cache folder, without which a session still works.

use super::custom_surfaces::SurfaceError;
use super::fragment_folder::FragmentFolderError;
use super::renderers::RendererError;
use crate::catalog::CatalogError;
use crate::catalog::small_bodies::SmallBodyFileError;
use crate::catalog::stars::StarFileError;
use crate::ephemeris::EphemerisError;
use crate::render::plan::PlanError;
use crate::render::software::RenderError;
use crate::scene::SceneError;

/// Why a session cannot be opened, or a view cannot be drawn. One line, except for errors in catalog files.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// A file that cannot be read.
    #[error("{path}: {why}")]
    File {
        /// The path as the user named it.
        path: String,
        /// The reason, usually the system's error.
        why: String,
    },
    /// Invalid fields of catalog files, each with its line.
    #[error(transparent)]
    Catalog(#[from] CatalogError),
    /// An invalid line of a star catalog.
    #[error(transparent)]
    Stars(#[from] StarFileError),
    /// An invalid line of a table of minor planets or comets.
    #[error(transparent)]
    SmallBodies(#[from] SmallBodyFileError),
    /// A position cannot be computed, or a kernel is unusable.
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
    /// The requested view is impossible.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A module or map of the view is unusable.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The folder of the user's fragments is unusable.
    #[error(transparent)]
    Shaders(#[from] FragmentFolderError),
    /// A custom surface is unusable.
    #[error(transparent)]
    CustomSurface(#[from] SurfaceError),
    /// No renderer can draw the view.
    #[error(transparent)]
    Renderer(#[from] RendererError),
}

/// Why no cache folder is used; shaders, tables and decoded maps are then kept in memory only.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CacheFolderError {
    /// The user named no folder, and the system has none.
    #[error("this system has no cache folder; shaders, tables and decoded maps are kept in memory only unless --cache DIR names a folder")]
    None,
    /// Other users may write to the folder, and could thus change what is drawn.
    #[error(
        "the cache {folder} is not used: {why}; shaders, tables and decoded maps are kept in memory only unless --cache DIR names another folder"
    )]
    Shared {
        /// The cache folder, or one of the program's folders in it.
        folder: String,
        /// The reason: its owner or its mode.
        why: String,
    },
}

impl From<RenderError> for SessionError {
    fn from(e: RenderError) -> Self {
        Self::Renderer(e.into())
    }
}
