//! How the window puts a picture together: one perspective frame, a dome, the whole sphere, or a stereo pair. The part of a view that a link keeps of it.
//!
//! In: fields of a link or a file, controls of the Effects panel. Out: a [`Composition`]. Always: a default one is a plain perspective picture, and is not written. Not here:
//! the warp mesh, a file of the projector's own, which `orrery view --warp` gives.

use crate::scene::request::composition::{DOME_TILT_RANGE_DEG, FISHEYE_DEG, FISHEYE_RANGE_DEG};
use crate::scene::request::{Composition, Projection, Stereo, StereoLayout};
use crate::view::app::option_text;
use serde::{Deserialize, Serialize};

/// How the picture is put together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CompositionState {
    #[serde(with = "option_text::by_name")]
    pub projection: Projection,
    /// Full angle of a fisheye's circle; other projections don't use it.
    pub fisheye_deg: f64,
    /// A fisheye with the zenith in its middle.
    pub dome_zenith: bool,
    pub dome_tilt_deg: f64,
    #[serde(with = "option_text::by_optional_name")]
    pub stereo: Option<StereoLayout>,
    /// `None`: as wide as the view makes comfortable.
    pub eye_separation_km: Option<f64>,
}

impl Default for CompositionState {
    fn default() -> Self {
        Self {
            projection: Projection::Perspective,
            fisheye_deg: FISHEYE_DEG,
            dome_zenith: false,
            dome_tilt_deg: 0.0,
            stereo: None,
            eye_separation_km: None,
        }
    }
}

impl CompositionState {
    /// Without its mesh.
    pub(crate) fn of(composition: &Composition) -> Self {
        Self {
            projection: composition.projection,
            dome_zenith: composition.zenith_centred,
            dome_tilt_deg: composition.tilt_deg,
            stereo: composition.stereo.map(|s| s.layout),
            eye_separation_km: composition.stereo.and_then(|s| s.eye_separation_km),
            ..Self::default()
        }
    }

    pub(crate) fn is_plain(&self) -> bool {
        *self == Self::default()
    }

    /// What the picture is made as; what a projection does not use is left out.
    pub(crate) fn composition(&self) -> Composition {
        let sphere = self.projection != Projection::Perspective;
        Composition {
            projection: self.projection,
            zenith_centred: self.dome_zenith && self.projection == Projection::Fisheye,
            tilt_deg: if sphere { self.dome_tilt_deg } else { 0.0 },
            stereo: self.stereo.filter(|_| !sphere).map(|layout| Stereo { layout, eye_separation_km: self.eye_separation_km }),
            warp: None,
        }
    }

    /// Each of its numbers that no picture can have.
    pub(super) fn faults(&self, check: &mut dyn FnMut(bool, &dyn Fn() -> String)) {
        check(FISHEYE_RANGE_DEG.contains(&self.fisheye_deg), &|| {
            format!("composition.fisheye_deg {}: must be 1 to 360 degrees", self.fisheye_deg)
        });
        check(DOME_TILT_RANGE_DEG.contains(&self.dome_tilt_deg), &|| {
            format!("composition.dome_tilt_deg {}: must be -180 to 180 degrees", self.dome_tilt_deg)
        });
        if let Some(km) = self.eye_separation_km {
            check(km > 0.0 && km.is_finite(), &|| format!("composition.eye_separation_km {km}: must be more than 0 km"));
        }
    }
}
