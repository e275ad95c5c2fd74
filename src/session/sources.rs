//! What a session is opened with: the files and folders that the user names, and options of drawing.

use super::{RendererPreference, SurfaceFile};
use crate::catalog::EclipseRadii;
use crate::scene::sky::frames::SkyFrame;
use std::ffi::OsString;
use std::path::PathBuf;

/// The user's replacements for what is built in.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// `*.toml` files that override or add bodies.
    pub catalogs: Option<PathBuf>,
    /// The radii of the Sun and the Moon used for eclipses.
    pub eclipse_radii: EclipseRadii,
    /// Maps that take precedence over the embedded ones.
    pub textures: Option<PathBuf>,
    /// Limit for such a map, megapixels; `None`: [`crate::image::DEFAULT_MAX_MEGAPIXELS`].
    pub max_megapixels: Option<u32>,
    /// An SPK that takes precedence over the embedded one.
    pub kernel: Option<PathBuf>,
    /// Stars in place of those built in: a table with named columns, or hip2.dat.
    pub stars: Option<PathBuf>,
    /// Minor planets and comets in place of those built in: a table with named columns, JSON of the JPL's database, or MPCORB.DAT.
    pub minor_planets: Option<PathBuf>,
    /// A height map of the whole Moon, with the heights of black and white if given: `FILE` or `FILE,LOW,HIGH`.
    pub lunar_heights: Option<OsString>,
    /// A panorama of the sky in place of the Milky Way: PNG, JPEG, EXR, or six faces of a cube.
    pub sky: Option<PathBuf>,
    /// Its axes.
    pub sky_frame: SkyFrame,
    /// Shader fragments that override the built-in ones.
    pub shaders: Option<PathBuf>,
    /// Fragments that colour the surface of single bodies, at most four.
    pub surfaces: Vec<SurfaceFile>,
    /// Folder of the shader library; `None`: the user's cache folder.
    pub cache: Option<PathBuf>,
    /// Worker threads; `None`: one per core.
    pub threads: Option<usize>,
    /// The software renderer computes shaders in f64.
    pub double_precision: bool,
    /// The requested renderer.
    pub renderer: RendererPreference,
    /// Frames will be drawn: the GPU is opened while catalogs are read.
    pub draws: bool,
}
