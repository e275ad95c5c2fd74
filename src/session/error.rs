//! Errors between a request and its frame.

use super::custom_surfaces::SurfaceError;
use super::renderers::RendererError;
use super::shaders::FragmentFolderError;
use crate::catalog::CatalogError;
use crate::catalog::small_bodies::SmallBodyFileError;
use crate::catalog::stars::StarFileError;
use crate::ephemeris::EphemerisError;
use crate::render::plan::PlanError;
use crate::render::software::RenderError;
use crate::scene::SceneError;

/// Why a session cannot be opened, or a view cannot be drawn, in one line.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// A file that cannot be read.
    #[error("{path}: {why}")]
    File {
        /// As the user named it.
        path: String,
        /// What the system says.
        why: String,
    },
    /// Wrong fields of catalog files, each with its line.
    #[error(transparent)]
    Catalog(#[from] CatalogError),
    /// Wrong lines of a star catalogue.
    #[error(transparent)]
    Stars(#[from] StarFileError),
    /// Wrong lines of a table of minor planets or comets.
    #[error(transparent)]
    SmallBodies(#[from] SmallBodyFileError),
    /// No position, or an unusable kernel.
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
    /// An impossible view.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A module or map of the view.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The folder of the user's fragments.
    #[error(transparent)]
    Shaders(#[from] FragmentFolderError),
    /// A custom surface.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// No renderer can draw it.
    #[error(transparent)]
    Renderer(#[from] RendererError),
}

/// Why shaders are kept in memory only.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CacheFolderError {
    /// Neither the user nor the system gives a folder.
    #[error("this system names no cache folder; shaders are kept in memory only, --cache DIR names a place")]
    None,
    /// Other users may write to it, and so could decide what is drawn.
    #[error("the cache {folder} is not used: {why}; shaders are kept in memory only, --cache DIR names another place")]
    Shared {
        /// The folder, or the one above it.
        folder: String,
        /// Who may write to it.
        why: String,
    },
}

impl From<RenderError> for SessionError {
    fn from(e: RenderError) -> Self {
        Self::Renderer(e.into())
    }
}
