//! The composition of an image as a view stores it: a perspective image, a fisheye image for a dome, a whole-sphere image, or a
//! stereo pair.
//!
//! In: fields of a link or a file, controls of the Effects panel. Out: a [`Composition`]. Always: the default is a perspective image without
//! stereo, which links and files omit. Not here: the warp mesh, which distorts the image for one projector; `orrery view --warp` loads it.

use crate::scene::request::composition::{DEFAULT_FISHEYE_DEG, DOME_TILT_RANGE_DEG, FISHEYE_RANGE_DEG};
use crate::scene::request::{Composition, Projection, Stereo, StereoLayout};
use crate::view::app::option_serde;
use serde::{Deserialize, Serialize};

/// The fields of a composition that links and files store.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CompositionState {
    #[serde(with = "option_serde::by_name")]
    pub projection: Projection,
    /// Full angle of a fisheye's circle; other projections do not use this field.
    pub fisheye_deg: f64,
    /// Whether the zenith is in the middle of a fisheye image.
    #[serde(rename = "dome_zenith")]
    pub is_zenith_centred: bool,
    /// Degrees by which the direction in the middle of a fisheye or whole-sphere image is lowered towards the image's bottom, see [`Composition::tilt_deg`].
    pub dome_tilt_deg: f64,
    #[serde(with = "option_serde::by_optional_name")]
    pub stereo: Option<StereoLayout>,
    /// Distance between the two cameras of a stereo pair; `None`: a distance that suits the view.
    pub eye_separation_km: Option<f64>,
}

impl Default for CompositionState {
    fn default() -> Self {
        Self {
            projection: Projection::Perspective,
            fisheye_deg: DEFAULT_FISHEYE_DEG,
            is_zenith_centred: false,
            dome_tilt_deg: 0.0,
            stereo: None,
            eye_separation_km: None,
        }
    }
}

impl CompositionState {
    /// The composition of the command line (`options`), or this one if the command line specifies none. The command line does not specify the full angle
    /// of a fisheye, so if this composition is a fisheye, its angle stays.
    pub(crate) fn with_options(&self, options: &Composition) -> Self {
        let from_options = Self::of(options);
        if from_options.is_plain() {
            return self.clone();
        }
        let fisheye_deg = if self.projection == Projection::Fisheye { self.fisheye_deg } else { from_options.fisheye_deg };
        Self { fisheye_deg, ..from_options }
    }

    /// The stored fields of a composition, without its warp mesh. A [`Composition`] has no fisheye angle, so `fisheye_deg` is the default; the caller may
    /// replace it.
    fn of(composition: &Composition) -> Self {
        Self {
            projection: composition.projection,
            is_zenith_centred: composition.is_zenith_centred,
            dome_tilt_deg: composition.tilt_deg,
            stereo: composition.stereo.map(|s| s.layout),
            eye_separation_km: composition.stereo.and_then(|s| s.eye_separation_km),
            ..Self::default()
        }
    }

    /// Whether this is a perspective image without stereo, with all other fields at their defaults.
    pub(crate) fn is_plain(&self) -> bool {
        *self == Self::default()
    }

    /// The composition for a request; fields that the projection does not use are left at their defaults.
    pub(crate) fn composition(&self) -> Composition {
        // A fisheye or a whole-sphere image.
        let is_spherical = self.projection != Projection::Perspective;
        Composition {
            projection: self.projection,
            is_zenith_centred: self.is_zenith_centred && self.projection == Projection::Fisheye,
            tilt_deg: if is_spherical { self.dome_tilt_deg } else { 0.0 },
            stereo: self.stereo.filter(|_| !is_spherical).map(|layout| Stereo { layout, eye_separation_km: self.eye_separation_km }),
            warp: None,
        }
    }

    /// Calls `check` for each number. The arguments of `check`: whether the number is in range, and a function that gives the error message.
    pub(super) fn check_fields(&self, check: &mut dyn FnMut(bool, &dyn Fn() -> String)) {
        for (field, degrees, range) in
            [("fisheye_deg", self.fisheye_deg, FISHEYE_RANGE_DEG), ("dome_tilt_deg", self.dome_tilt_deg, DOME_TILT_RANGE_DEG)]
        {
            check(range.contains(&degrees), &|| {
                format!("composition.{field} {degrees}: must be {} to {} degrees", range.start(), range.end())
            });
        }
        if let Some(km) = self.eye_separation_km {
            check(km > 0.0 && km.is_finite(), &|| format!("composition.eye_separation_km {km}: must be more than 0 km"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_replace_a_composition_but_not_the_angle_of_a_fisheye() {
        let fisheye =
            CompositionState { projection: Projection::Fisheye, fisheye_deg: 90.0, is_zenith_centred: true, ..CompositionState::default() };
        let anaglyph = CompositionState { stereo: Some(StereoLayout::Anaglyph), ..CompositionState::default() };
        // Options without a projection and a stereo pair leave the composition as it is.
        assert_eq!(fisheye.with_options(&Composition::default()), fisheye);
        assert_eq!(anaglyph.with_options(&Composition::default()), anaglyph);
        let dome = Composition { projection: Projection::Fisheye, tilt_deg: 20.0, ..Composition::default() };
        let tilted = CompositionState { projection: Projection::Fisheye, dome_tilt_deg: 20.0, ..CompositionState::default() };
        assert_eq!(fisheye.with_options(&dome), CompositionState { fisheye_deg: 90.0, ..tilted.clone() });
        assert_eq!(anaglyph.with_options(&dome), tilted);
    }
}
