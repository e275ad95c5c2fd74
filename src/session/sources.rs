//! The inputs with which a session is opened: files and folders that the user names, and options for drawing.
//!
//! In: values from the command line, or from a program that uses this crate as a library. Out: [`Sources`]. Not here: reading and checking the files.

use super::{RendererPreference, SessionError, SurfaceFile};
use crate::catalog::EclipseRadii;
use crate::scene::sky::frames::SkyFrame;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The user's replacements for the built-in data, and options for drawing. A file or folder that is `None` replaces nothing.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// A folder of `*.toml` files that override or add bodies.
    pub catalogs: Option<PathBuf>,
    /// The radii of the Sun and the Moon used for eclipses.
    pub eclipse_radii: EclipseRadii,
    /// A folder of maps that take precedence over the embedded ones.
    pub textures: Option<PathBuf>,
    /// Limit on the size of each of the user's maps, megapixels; `None`: [`crate::image::DEFAULT_MAX_MEGAPIXELS`].
    pub max_megapixels: Option<u32>,
    /// An SPK file that takes precedence over the embedded one.
    pub kernel: Option<PathBuf>,
    /// A file of stars that replace the embedded ones: a table with named columns, or hip2.dat.
    pub stars: Option<PathBuf>,
    /// A file of minor planets and comets that replace the embedded ones: a table with named columns, JSON of the JPL's database, or
    /// MPCORB.DAT.
    pub minor_planets: Option<PathBuf>,
    /// A height map of the entire Moon: `FILE`, or `FILE,LOW,HIGH` with the heights in km that black and white pixels stand for. Without LOW and HIGH: a PDS
    /// image, floating-point values in km, or unsigned 16-bit values on the scale of NASA's CGI Moon Kit.
    pub lunar_heights: Option<OsString>,
    /// A panorama of the sky in place of the Milky Way: a PNG, JPEG or EXR; or a folder of the six faces of a cube, or a file pattern in which `*`
    /// stands for a face's name.
    pub sky: Option<PathBuf>,
    /// The axes of the panorama `sky`.
    pub sky_frame: SkyFrame,
    /// A folder of shader fragments that override the built-in ones.
    pub shaders: Option<PathBuf>,
    /// Fragments that colour the surface of individual bodies, at most four.
    pub surfaces: Vec<SurfaceFile>,
    /// The cache folder; `None`: the user's cache folder on this system.
    pub cache: Option<PathBuf>,
    /// Worker threads; `None`: one per core.
    pub threads: Option<usize>,
    /// Whether the software renderer computes shaders in f64.
    pub uses_f64: bool,
    /// The requested renderer.
    pub renderer: RendererPreference,
    /// Whether frames will be drawn; if so, the GPU is opened while the catalogs are read.
    pub will_draw: bool,
}

impl Sources {
    /// Folders that are searched for maps and meshes; earlier ones take precedence.
    pub(super) fn map_and_mesh_folders(&self) -> impl Iterator<Item = &PathBuf> {
        self.textures.iter().chain(&self.catalogs)
    }

    /// The option whose data a session could not use, and the sources without it; `None` if the error is about other sources.
    pub fn without_invalid_data(&self, error: &SessionError) -> Option<(&'static str, Self)> {
        let is_in_catalogs = |path: &str| self.catalogs.as_ref().is_some_and(|folder| Path::new(path).starts_with(folder));
        match error {
            SessionError::File { path, .. } if is_in_catalogs(path) => Some(("--catalogs", Self { catalogs: None, ..self.clone() })),
            SessionError::Catalog(_) if self.catalogs.is_some() => Some(("--catalogs", Self { catalogs: None, ..self.clone() })),
            SessionError::Stars(_) if self.stars.is_some() => Some(("--stars", Self { stars: None, ..self.clone() })),
            SessionError::SmallBodies(_) if self.minor_planets.is_some() => {
                Some(("--minor-planets", Self { minor_planets: None, ..self.clone() }))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::Session;

    /// A line without a value in a catalog of the user once kept the window from opening.
    #[test]
    fn only_the_invalid_data_is_left_out() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("own.toml"), "[[body]]\nname = \n").expect("written");
        let sources = Sources { catalogs: Some(folder.path().into()), threads: Some(1), ..Sources::default() };
        let error = Session::open(&sources, |_| {}).map(|_| ()).expect_err("an invalid catalog");
        let (option, usable) = sources.without_invalid_data(&error).expect("another try");
        assert_eq!((option, usable.catalogs.as_ref(), usable.threads), ("--catalogs", None, Some(1)));
        // An error of the built-in catalog, or about something else, cannot be avoided in this way.
        assert!(usable.without_invalid_data(&error).is_none());
        let other = SessionError::File { path: "a.toml".into(), why: "missing".into() };
        assert!(sources.without_invalid_data(&other).is_none());
        let in_folder = SessionError::File { path: folder.path().join("points.csv").display().to_string(), why: "missing".into() };
        assert!(sources.without_invalid_data(&in_folder).is_some());
    }
}
