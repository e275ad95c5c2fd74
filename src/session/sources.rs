//! The inputs with which a session is opened: files and folders that the user names, and options for drawing.
//!
//! In: values from the command line, or from a program that uses this crate as a library. Out: [`Sources`]. Not here: reading and checking the files.

use super::{RendererPreference, SurfaceFile};
use crate::catalog::EclipseRadii;
use crate::scene::sky::frames::SkyFrame;
use std::ffi::OsString;
use std::path::PathBuf;

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
}
