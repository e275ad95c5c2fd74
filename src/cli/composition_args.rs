//! The options that describe a composition: projection, stereo, warp mesh.
//!
//! In: arguments. Out: a [`Composition`]. The file of the warp mesh is read here.

use super::CliError;
use crate::files::read_text;
use crate::scene::request::{Composition, Projection, Stereo, StereoLayout, WarpMesh};
use crate::scene::{OutOfRange, RequestValue, SceneError};
use crate::wording::echo;
use std::path::PathBuf;
use std::sync::Arc;

/// Largest warp mesh file, bytes: enough for a million nodes, each a line of up to 134 characters (five numbers).
const MAX_MESH_BYTES: u64 = 1 << 27;

/// Options of the composition.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Projection and stereo")]
pub(crate) struct CompositionArgs {
    /// Projection: perspective; fisheye (angular: distance from the middle proportional to the angle; it shows 180 degrees unless a field of view is given);
    /// equirectangular (whole sphere, whatever --fov is; poles at the view's up and down, the target in the middle column). Fisheye and equirectangular images
    /// have no outline (--layers +outline), and neither coordinates on their grids nor names on frames of instruments
    #[arg(long, value_enum, value_name = "HOW", default_value_t = Projection::Perspective)]
    pub projection: Projection,
    /// Fisheye: the zenith in the middle, the target towards the bottom (the front of a dome)
    #[arg(long)]
    pub dome_zenith: bool,
    /// Tilt of the dome: degrees by which the direction at the image's centre is lowered
    #[arg(long, value_name = "D", default_value_t = 0.0, allow_negative_numbers = true)]
    pub dome_tilt: f64,
    /// Stereo pair: anaglyph (red and cyan glasses, red on the left; Dubois' matrix), side-by-side (each eye has half the width, undistorted),
    /// or interlaced (rows 0, 2, 4, ... for the left eye); zero parallax at the target's distance
    #[arg(long, value_enum, value_name = "HOW")]
    pub stereo: Option<StereoLayout>,
    /// Distance between the eyes in km [default: 1/30 of the width that the image spans at the target; on a surface 63 mm]
    #[arg(long, value_name = "KM", requires = "stereo", allow_negative_numbers = true)]
    pub eye_separation_km: Option<f64>,
    /// Warp the image onto a mesh (Paul Bourke's text format: x y u v i); the image size is that of the screen
    #[arg(long, value_name = "MESH")]
    pub warp: Option<PathBuf>,
}

impl CompositionArgs {
    /// The composition that these options describe.
    ///
    /// # Errors
    /// A mesh that cannot be read, with its file and line; options that contradict each other, or a number out of range.
    pub(crate) fn composition(&self) -> Result<Composition, CliError> {
        let warp = self.warp.as_ref().map(|path| {
            let mesh_name = echo(&path.display().to_string());
            let text =
                read_text(path, MAX_MESH_BYTES).map_err(|e| CliError::Failed(format!("{mesh_name}: {e}; --warp takes a text file")))?;
            WarpMesh::parse(&mesh_name, &text).map(Arc::new).map_err(|e| CliError::Failed(e.to_string()))
        });
        let composition = Composition {
            projection: self.projection,
            is_zenith_centred: self.dome_zenith,
            tilt_deg: self.dome_tilt,
            stereo: self.stereo.map(|layout| Stereo { layout, eye_separation_km: self.eye_separation_km }),
            warp: warp.transpose()?,
        };
        composition.check().map_err(|e| {
            let option = match &e {
                SceneError::OutOfRange(OutOfRange { what: RequestValue::DomeTilt, .. }) => "--dome-tilt: ",
                SceneError::OutOfRange(OutOfRange { what: RequestValue::EyeSeparation, .. }) => "--eye-separation-km: ",
                _ => "",
            };
            CliError::Usage(format!("{option}{e}"))
        })?;
        Ok(composition)
    }
}
