//! A view request: position and direction of the camera, field of view, exposure, effects and layers.
//!
//! In: values from the command line, the window or a camera file (`camera_file`). Out: [`ViewRequest`]; [`ViewRequest::check`] rejects values outside their
//! ranges. Not here: the checks of directions and of a missing target (`scene::camera::viewpoint`).

use crate::catalog::{Body, Catalog, NaifId};
use crate::message::TextLanguage;
use crate::scene::draw::features::PixelView;
use crate::scene::error::{OutOfRange, RequestValue, SceneError};
use crate::scene::purpose::Purpose;
use crate::scene::request::composition::{Composition, FISHEYE_RANGE_DEG, Projection};
use crate::scene::request::effects::EffectOverrides;
use crate::scene::request::layers::Layers;
use crate::scene::request::telescope::Telescope;
use crate::time::Instant;
use glam::DVec3;
use serde::Deserialize;
use std::ops::RangeInclusive;

/// Axes in which a vector of a request is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axes {
    /// International Celestial Reference Frame.
    #[default]
    Icrf,
    /// Body-fixed axes of the body relative to which the camera is placed. For [`Position::AboveTarget`] this is the target; other positions name it.
    BodyFixed,
}

/// The position of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// Above the side of the target that faces another body.
    AboveTarget {
        /// The body towards which the camera is displaced from the target's centre; `None`: the Earth or, if the target is the Earth, the Sun.
        towards: Option<NaifId>,
        /// Distance from the target's centre in its equatorial radii; `None`: the distance at which the disc fills [`FITTED_DISC_FRACTION`] of the frame's
        /// height.
        distance_radii: Option<f64>,
    },
    /// At a body's centre or a barycentre, moving with it, so that stellar aberration follows from its velocity. The body itself is not drawn.
    Centre(NaifId),
    /// Above a point of a body's reference ellipsoid: planetographic latitude, planetocentric east longitude, height along the normal.
    Ground {
        /// The body on which the camera stands.
        body: NaifId,
        /// Planetographic, -90 to 90.
        latitude_deg: f64,
        /// East, -360 to 360.
        longitude_deg: f64,
        /// Height above the ellipsoid, positive.
        height_km: f64,
    },
    /// At an offset from a body's centre.
    Offset {
        /// The body from whose centre the offset is measured.
        body: NaifId,
        /// Vector from the centre to the camera.
        offset_km: DVec3,
        /// The axes in which `offset_km` is given.
        axes: Axes,
    },
}

impl Position {
    /// At an offset from a body's centre; without an offset at the centre, from where the body is not drawn.
    pub fn at_offset(body: NaifId, offset_km: DVec3, axes: Axes) -> Self {
        if offset_km == DVec3::ZERO { Self::Centre(body) } else { Self::Offset { body, offset_km, axes } }
    }

    /// The up direction of a request that gives a position but no up direction: on the ground the zenith, so that the horizon is level, else north.
    pub fn default_up(&self) -> Up {
        match self {
            Self::Ground { .. } => Up::Zenith,
            Self::AboveTarget { .. } | Self::Centre(_) | Self::Offset { .. } => Up::North,
        }
    }
}

/// The direction of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// At the target.
    Target,
    /// Along a direction.
    Along {
        /// A vector of any length.
        direction: DVec3,
        /// The axes in which it is given.
        axes: Axes,
    },
}

/// The up direction of the image. If it is along the line of sight, the celestial pole replaces it; if that is along it too, the equinox (ICRF +x).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Up {
    /// The north pole of the target if the camera looks at it, else that of the body relative to which the camera is placed.
    #[default]
    North,
    /// Away from the centre of the body relative to which the camera is placed; on the ground, along the normal of its ellipsoid. At a body's centre, the
    /// celestial pole replaces it.
    Zenith,
    /// The celestial pole, ICRF +z.
    Celestial,
    /// The pole of the ecliptic of J2000.
    Ecliptic,
    /// A direction.
    Along {
        /// A vector of any length.
        direction: DVec3,
        /// The axes in which it is given.
        axes: Axes,
    },
}

/// Difference of exposure that counts as invisible: it changes mid grey (0.18 of white, encoded as sRGB) by 0.8 / 255.
pub const INVISIBLE_EXPOSURE_CHANGE_STOPS: f64 = 0.02;

/// How the exposure is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ExposureRequest {
    /// Chosen by the light meter (`scene::light::meter`).
    #[default]
    Auto,
    /// Given in stops: at 0 a white plane facing the Sun at 1 au reaches linear 1; each stop doubles the value.
    Stops(f64),
    /// Interpolated between given stops and the metered ones, while the window adapts its exposure.
    Transition {
        /// The stops at the start.
        from_stops: f64,
        /// Fraction of the way to the metered stops, 0 to 1.
        progress: f64,
    },
}

impl ExposureRequest {
    /// The stops of an image with a metered exposure of `metered_stops`.
    pub fn stops_of(self, metered_stops: f64) -> f64 {
        match self {
            Self::Auto => metered_stops,
            Self::Stops(stops) => stops,
            // A transition ends when the difference is invisible, so that an image at rest has exactly the metered exposure, whatever the start.
            Self::Transition { from_stops, .. } if (metered_stops - from_stops).abs() <= INVISIBLE_EXPOSURE_CHANGE_STOPS => metered_stops,
            Self::Transition { from_stops, progress } => from_stops + (metered_stops - from_stops) * progress.clamp(0.0, 1.0),
        }
    }
}

/// How light brighter than white is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Linear up to 0.8 of white, then a shoulder like that of film.
    #[default]
    Filmic,
    /// Linear up to white, then clipped.
    Clipped,
}

impl ToneMap {
    /// All values.
    pub const ALL: [Self; 2] = [Self::Filmic, Self::Clipped];

    /// The name in options and links.
    pub fn name(self) -> &'static str {
        match self {
            Self::Filmic => "filmic",
            Self::Clipped => "clipped",
        }
    }

    /// The tone map with this name, in lower or upper case; `None` for an unknown name. Names of earlier versions are accepted.
    pub fn by_name(name: &str) -> Option<Self> {
        // Earlier versions used the names `film` and `plain`.
        let former = [("film", Self::Filmic), ("plain", Self::Clipped)];
        let known = Self::ALL.map(|t| (t.name(), t)).into_iter().chain(former);
        known.into_iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, t)| t)
    }
}

/// The trade-off between speed and accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// One sample per pixel, one tap per read of a map, and faster models of eclipses and air. A pixel of a ring shows the mean over the range of
    /// radii that it covers.
    Draft,
    /// Four samples per pixel, up to 8 taps per read of a map. A pixel of a ring shows the mean over two such ranges, half a pixel apart, against moire.
    #[default]
    Standard,
    /// As standard, but up to 16 taps per read of a map, and air evaluated for each pixel. The command line computes these images in f64 instead of f32.
    Reference,
}

impl Quality {
    /// All values, from the fastest to the most accurate.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Standard, Self::Reference];

    /// The name in options and links.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Standard => "standard",
            Self::Reference => "reference",
        }
    }

    /// The quality with this name, in lower or upper case; `None` for an unknown name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|q| q.name().eq_ignore_ascii_case(name))
    }
}

/// Largest width and height of an image, pixels: the largest texture that most GPUs support.
pub(crate) const MAX_IMAGE_PX: u32 = 16384;
/// Fields of view that a perspective image may have, degrees; the smallest is a third of a milliarcsecond.
const FOV_RANGE_DEG: RangeInclusive<f64> = 1e-7..=170.0;
/// Exposures that a request may give, stops: far beyond those of the Sun's disc and of the darkest sky.
const EXPOSURE_RANGE_STOPS: RangeInclusive<f64> = -60.0..=60.0;
/// Values of [`ViewRequest::stars_boost_stops`]: factors of up to 1e9 either way.
const STARS_BOOST_RANGE_STOPS: RangeInclusive<f64> = -30.0..=30.0;

/// One view. `target` may be missing only if `look` gives a direction and `position` is not above the target.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewRequest {
    /// The time at which the light arrives at the camera.
    pub time: Instant,
    /// The body that the camera looks at.
    pub target: Option<NaifId>,
    /// The position of the camera.
    pub position: Position,
    /// The direction of view.
    pub look: Look,
    /// The up direction of the image.
    pub up: Up,
    /// Whether the image is mirrored left to right, as a star diagonal does. Texts are not.
    pub is_mirrored: bool,
    /// How the image is put together.
    pub composition: Composition,
    /// Vertical field of view, degrees; for a fisheye, the full angle of its circle. `None`: for a fisheye 180, otherwise [`FOV_AT_FITTED_DISTANCE_DEG`] or
    /// [`FOV_AT_GIVEN_POSITION_DEG`]; but if the camera is at a body's centre and looks at the target, the field of view that fits the target's disc.
    pub fov_deg: Option<f64>,
    /// Width in pixels, 1..=16384.
    pub width: u32,
    /// Height in pixels, 1..=16384.
    pub height: u32,
    /// How the exposure is chosen.
    pub exposure: ExposureRequest,
    /// How light brighter than white is shown.
    pub tone_map: ToneMap,
    /// Effects that the user switched on or off, regardless of their thresholds.
    pub effects: EffectOverrides,
    /// Layers drawn behind and over the bodies.
    pub layers: Layers,
    /// The telescope whose field of view is outlined in the middle of a perspective image.
    pub telescope: Option<Telescope>,
    /// Stops by which stars, Milky Way and zodiacal light are brightened, -30 to 30; negative: darkened.
    pub stars_boost_stops: f64,
    /// The body whose name, marker and outline are emphasised: in the window, the one that the user selected. `None`: the target, or else the Sun.
    pub selected: Option<NaifId>,
    /// The trade-off between speed and accuracy.
    pub quality: Quality,
    /// The quantity that the pixels show.
    pub pixel_view: PixelView,
    /// The purpose of the image, which sets the threshold below which effects are left out.
    pub purpose: Purpose,
    /// The language of texts in the image: caption, names of bodies, numbers.
    pub language: TextLanguage,
    /// Whether draws may interpolate the air from the coarse image, which other draws fill. `false` for a probe of one pixel, which runs each draw alone.
    pub may_use_coarse_air: bool,
}

/// Default field of view for [`Position::AboveTarget`] without a distance; the distance then follows from it. It is that of a long lens, so that nearly a
/// hemisphere of the target is visible.
pub const FOV_AT_FITTED_DISTANCE_DEG: f64 = 20.0;
/// Default field of view for [`Position::AboveTarget`] with a distance, and for all other positions, except where it is fitted to the target
/// ([`ViewRequest::fov_deg`]). At a distance of 3 radii a disc fills 85 % of the frame's height.
pub const FOV_AT_GIVEN_POSITION_DEG: f64 = 45.0;
/// Diameter of a fitted disc relative to the frame's height.
pub const FITTED_DISC_FRACTION: f64 = 0.75;

impl ViewRequest {
    /// The default view of a body: see [`Position::AboveTarget`].
    pub fn of(target: NaifId, time: Instant) -> Self {
        Self {
            time,
            target: Some(target),
            position: Position::AboveTarget { towards: None, distance_radii: None },
            look: Look::Target,
            up: Up::North,
            is_mirrored: false,
            composition: Composition::default(),
            fov_deg: None,
            width: 1024,
            height: 1024,
            exposure: ExposureRequest::Auto,
            tone_map: ToneMap::Filmic,
            effects: EffectOverrides::default(),
            layers: Layers::default(),
            telescope: None,
            stars_boost_stops: 0.0,
            selected: None,
            quality: Quality::default(),
            pixel_view: PixelView::Final,
            purpose: Purpose::Display,
            language: TextLanguage::English,
            may_use_coarse_air: true,
        }
    }

    /// The request with all overrides of effects that apply to this body; `None` if none is for this body only, so that the request itself applies.
    pub(crate) fn for_body(&self, body: &Body) -> Option<Self> {
        self.effects.for_catalog_body(body).map(|effects| Self { effects, ..self.clone() })
    }

    /// Rejects effects for bodies that the catalog does not have.
    pub fn check_bodies(&self, catalog: &Catalog) -> Result<(), SceneError> {
        for name in self.effects.bodies() {
            catalog.body_named(name).map_err(SceneError::EffectBody)?;
        }
        Ok(())
    }

    /// Rejects numbers outside their ranges ([`SceneError::OutOfRange`]) and invalid compositions.
    pub fn check(&self) -> Result<(), SceneError> {
        let invalid = |what: RequestValue, given: String, allowed: &str| {
            let allowed = allowed.to_owned();
            Err(SceneError::from(OutOfRange { what, given, allowed }))
        };
        let bounds = |range: &RangeInclusive<f64>, unit: &str| format!("{} to {} {unit}", range.start(), range.end());
        if !(1..=MAX_IMAGE_PX).contains(&self.width) || !(1..=MAX_IMAGE_PX).contains(&self.height) {
            let allowed = format!("1 to {MAX_IMAGE_PX} pixels a side");
            return invalid(RequestValue::Size, format!("{}x{}", self.width, self.height), &allowed);
        }
        let fov_range_deg = match self.composition.projection {
            Projection::Perspective => Some(FOV_RANGE_DEG),
            Projection::Fisheye => Some(FISHEYE_RANGE_DEG),
            // The entire sphere.
            Projection::Equirectangular => None,
        };
        if let (Some(fov), Some(range)) = (self.fov_deg, fov_range_deg)
            && !range.contains(&fov)
        {
            return invalid(RequestValue::FieldOfView, format!("{fov:?}"), &bounds(&range, "degrees"));
        }
        if let Position::AboveTarget { distance_radii: Some(d), .. } = self.position
            && !(d > 0.0 && d.is_finite())
        {
            return invalid(RequestValue::Distance, format!("{d:?} radii"), "a number above 0");
        }
        if let Position::Ground { latitude_deg, longitude_deg, height_km, .. } = self.position {
            if !(-90.0..=90.0).contains(&latitude_deg) {
                return invalid(RequestValue::Latitude, format!("{latitude_deg:?}"), "-90 to 90 degrees");
            }
            if !(-360.0..=360.0).contains(&longitude_deg) {
                return invalid(RequestValue::Longitude, format!("{longitude_deg:?}"), "-360 to 360 degrees east");
            }
            if !(height_km > 0.0 && height_km.is_finite()) {
                return invalid(RequestValue::Height, format!("{height_km:?} km"), "above the ground");
            }
        }
        if let Position::Offset { offset_km, .. } = self.position
            && !offset_km.is_finite()
        {
            return invalid(RequestValue::CameraOffset, format!("{:?} km", offset_km.to_array()), "finite");
        }
        if let ExposureRequest::Stops(stops) | ExposureRequest::Transition { from_stops: stops, .. } = self.exposure
            && !EXPOSURE_RANGE_STOPS.contains(&stops)
        {
            return invalid(RequestValue::Exposure, format!("{stops:?}"), &bounds(&EXPOSURE_RANGE_STOPS, "stops"));
        }
        self.composition.check()?;
        if let Some(stereo) = self.composition.stereo {
            stereo.check_size([self.width, self.height], matches!(self.position, Position::Ground { .. }))?;
        }
        self.telescope.map_or(Ok(()), Telescope::check)?;
        if !STARS_BOOST_RANGE_STOPS.contains(&self.stars_boost_stops) {
            let given = format!("{:?}", self.stars_boost_stops);
            return invalid(RequestValue::StarsBoost, given, &bounds(&STARS_BOOST_RANGE_STOPS, "stops"));
        }
        if !self.time.tdb_seconds_past_j2000().is_finite() {
            return invalid(RequestValue::Time, format!("{:?}", self.time.tdb_seconds_past_j2000()), "a finite number");
        }
        Ok(())
    }
}

/// Height of a standing person's eyes above the ground, kilometres: the default of [`Position::Ground`]'s `height_km` on the command line and in camera files.
pub const EYE_HEIGHT_KM: f64 = 0.0017;
