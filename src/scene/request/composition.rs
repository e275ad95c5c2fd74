//! Composition: images made of several perspective frames (a stereo pair, a dome, the entire sphere), and the warp onto a projector's screen.
//!
//! In: names and numbers from the command line. Out: a [`Composition`], part of a view request. Always: the default is a plain perspective image.
//! Not here: the frames themselves (`scene::composite`).

use super::warp_mesh::WarpMesh;
use crate::scene::error::{OutOfRange, RequestValue, SceneError};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Default field of view of a fisheye (`ViewRequest::fov_deg`), a full angle in degrees: a hemisphere.
pub const DEFAULT_FISHEYE_DEG: f64 = 180.0;
/// Fields of view that a fisheye can show, full angles in degrees.
pub const FISHEYE_RANGE_DEG: RangeInclusive<f64> = 1.0..=360.0;
/// Range of the tilt of a dome, degrees.
pub const DOME_TILT_RANGE_DEG: RangeInclusive<f64> = -180.0..=180.0;

/// The projection: how directions map to positions in the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// A plane, as in a camera.
    #[default]
    Perspective,
    /// The distance from the image's middle is proportional to the angle from its axis (azimuthal equidistant, "angular fisheye").
    Fisheye,
    /// The entire sphere: longitude varies along the rows, latitude along the columns. Before the tilt, the poles are the view's up and down directions, and
    /// the target is in the middle column.
    Equirectangular,
}

impl Projection {
    /// All values.
    pub const ALL: [Self; 3] = [Self::Perspective, Self::Fisheye, Self::Equirectangular];

    /// The name in options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Perspective => "perspective",
            Self::Fisheye => "fisheye",
            Self::Equirectangular => "equirectangular",
        }
    }

    /// The projection with this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name().eq_ignore_ascii_case(name))
    }
}

/// How one image shows the images of both eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StereoLayout {
    /// For red and cyan glasses, the left eye behind red.
    Anaglyph,
    /// The left eye's image on the left half, the right eye's on the right half, neither squeezed.
    SideBySide,
    /// Rows 0, 2, 4, ... show the left eye's image, the others the right eye's.
    Interlaced,
}

impl StereoLayout {
    /// All values.
    pub const ALL: [Self; 3] = [Self::Anaglyph, Self::SideBySide, Self::Interlaced];

    /// The name in options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Anaglyph => "anaglyph",
            Self::SideBySide => "side-by-side",
            Self::Interlaced => "interlaced",
        }
    }

    /// The layout with this name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name().eq_ignore_ascii_case(name))
    }
}

/// A stereo pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stereo {
    /// How one image shows both eyes' images.
    pub layout: StereoLayout,
    /// Distance between the eyes, kilometres. `None`: 63 mm if the camera stands on the ground, otherwise a thirtieth of the width that one eye's image shows
    /// at the target's distance.
    pub eye_separation_km: Option<f64>,
}

/// How an image is put together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Composition {
    /// How directions map to positions in the image.
    pub projection: Projection,
    /// Whether the middle of a fisheye is the zenith (the view's up direction), not the line of sight. The target is then towards the bottom, where a dome has
    /// its front.
    pub is_zenith_centred: bool,
    /// The tilt of a dome: degrees by which the direction in the image's middle is lowered towards the image's bottom, negative if it is raised.
    pub tilt_deg: f64,
    /// The stereo pair, if the image is drawn for two eyes.
    pub stereo: Option<Stereo>,
    /// The mesh onto which the finished image is drawn, if any.
    pub warp: Option<Arc<WarpMesh>>,
}

impl Stereo {
    /// Width of each eye's image in an image of this width.
    pub(crate) fn eye_width_px(&self, width: u32) -> u32 {
        if self.layout == StereoLayout::SideBySide { width / 2 } else { width }
    }

    /// Rejects images that are too narrow. `stands_on_ground`: whether the camera does.
    pub(crate) fn check_size(&self, [width, height]: [u32; 2], stands_on_ground: bool) -> Result<(), SceneError> {
        let allowed = match self.eye_width_px(width) {
            0 => "at least 2 pixels wide for a side-by-side image",
            // With the default separation the parallax of infinity is at least 1 pixel, more than half the width of such an image.
            1 if self.eye_separation_km.is_none() && !stands_on_ground => {
                "at least 2 pixels wide for each eye, unless the eye separation is given or the camera stands on the ground"
            }
            _ => return Ok(()),
        };
        Err(OutOfRange { what: RequestValue::Size, given: format!("{width}x{height}"), allowed: allowed.into() }.into())
    }
}

impl Composition {
    /// Whether the image is one perspective frame.
    pub fn is_plain(&self) -> bool {
        *self == Self::default()
    }

    /// Rejects invalid combinations.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let invalid = |what: &str| Err(SceneError::Request(what.into()));
        let is_perspective = self.projection == Projection::Perspective;
        // Each eye sees a perspective frame.
        if self.stereo.is_some() && !(is_perspective && self.warp.is_none()) {
            return invalid("stereo requires the perspective projection and no warp mesh");
        }
        // The tilt is that of a dome or sphere; a perspective view is tilted by its camera.
        if is_perspective && self.tilt_deg != 0.0 {
            return invalid("a dome's tilt requires --projection fisheye or equirectangular");
        }
        // The poles of an equirectangular image are the zenith and the nadir already.
        if self.is_zenith_centred && self.projection != Projection::Fisheye {
            return invalid("centring on the zenith requires --projection fisheye");
        }
        if !DOME_TILT_RANGE_DEG.contains(&self.tilt_deg) {
            let (given, range) = (format!("{:?}", self.tilt_deg), DOME_TILT_RANGE_DEG);
            let allowed = format!("{} to {} degrees", range.start(), range.end());
            return Err(OutOfRange { what: RequestValue::DomeTilt, given, allowed }.into());
        }
        if let Some(km) = self.stereo.and_then(|s| s.eye_separation_km).filter(|km| !(*km > 0.0 && km.is_finite())) {
            return Err(
                OutOfRange { what: RequestValue::EyeSeparation, given: format!("{km:?} km"), allowed: "more than 0 km".into() }.into()
            );
        }
        Ok(())
    }

    /// The text for metadata and provenance.
    pub fn to_text(&self) -> String {
        let mut text = self.projection.name().to_owned();
        if self.is_zenith_centred {
            text.push_str(", zenith in the middle");
        }
        if self.tilt_deg != 0.0 {
            text.push_str(&format!(", tilted by {} deg", self.tilt_deg));
        }
        if let Some(Stereo { layout, eye_separation_km }) = self.stereo {
            let separation_text = eye_separation_km.map_or_else(|| "eyes as usual".into(), |km| format!("eyes {km} km apart"));
            text.push_str(&format!(", {}, {separation_text}", layout.name()));
        }
        if let Some(mesh) = &self.warp {
            text.push_str(&format!(", warped by {}", mesh.digest()));
        }
        text
    }
}
