//! What a session is opened with: the files and folders that the user names, and how it draws.

use super::{RendererPreference, SurfaceFile};
use crate::catalog::EclipseRadii;
use crate::scene::sky::frames::SkyFrame;
use std::ffi::OsString;
use std::path::PathBuf;

/// What the user named in place of what is built in.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// `*.toml` files that override or add bodies.
    pub catalogs: Option<PathBuf>,
    /// Which radii of the Sun and the Moon eclipses are reckoned with.
    pub eclipse_radii: EclipseRadii,
    /// Maps that come before the embedded ones.
    pub textures: Option<PathBuf>,
    /// Millions of pixels that such a map may have; `None`: [`crate::image::DEFAULT_MAX_MEGAPIXELS`].
    pub max_megapixels: Option<u32>,
    /// An SPK that comes before the embedded one.
    pub kernel: Option<PathBuf>,
    /// Stars in place of those built in: a table with named columns, or hip2.dat.
    pub stars: Option<PathBuf>,
    /// Minor planets and comets in place of those built in: a table with named columns, JSON of the JPL's database, or MPCORB.DAT.
    pub minor_planets: Option<PathBuf>,
    /// Heights of the whole Moon, with those of black and white where they are given: `FILE` or `FILE,LOW,HIGH`.
    pub lunar_heights: Option<OsString>,
    /// A panorama of the sky in place of the Milky Way: PNG, JPEG, EXR, or six faces of a cube.
    pub sky: Option<PathBuf>,
    /// Its axes.
    pub sky_frame: SkyFrame,
    /// Shader fragments that lie over those built in.
    pub shaders: Option<PathBuf>,
    /// Fragments that colour the ground of single bodies, at most four.
    pub surfaces: Vec<SurfaceFile>,
    /// Where the shader library lives; `None`: the user's cache folder.
    pub cache: Option<PathBuf>,
    /// Worker threads; `None`: one per core.
    pub threads: Option<usize>,
    /// The modules' lanes compute in f64.
    pub double_precision: bool,
    /// Which renderer draws.
    pub renderer: RendererPreference,
    /// Frames will be drawn: the device is opened while catalogs are read.
    pub draws: bool,
}
