//! A view as users save and share it: target, camera, time, field of view, exposure, effects. Links, files and bookmarks store this value.
//!
//! In: angles, distances, names. Out: a [`ViewRequest`]. Always: the types contain only plain values. Not here: drawing, history, and the text form of a
//! link (`link`).

use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::topocentric::ground_point_km;
use crate::ephemeris::{Ephemeris, EphemerisError};
use crate::scene::SceneError;
use crate::scene::draw::PixelView;
use crate::scene::effects::EffectOverrides;
use crate::scene::request::composition::Composition;
use crate::scene::request::view_request::MAX_IMAGE_PX;
use crate::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Projection, Quality, Telescope, ToneMap, Up, ViewRequest};
use crate::scene::viewpoint::{Viewer, viewer};
use crate::time::Instant;
use crate::view::app::composition_state::CompositionState;
use crate::view::app::option_serde;
use crate::view::app::orbit_camera::OrbitCamera;
use crate::view::language;
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Why a view cannot be drawn, in one line.
#[derive(Debug, thiserror::Error)]
pub enum ViewStateError {
    /// A field has an impossible value.
    #[error("{0}")]
    Field(String),
    /// The catalog lacks the body.
    #[error("no body has the code {}", .0.0)]
    NoSuchBody(NaifId),
    /// The ephemeris has no position or orientation.
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
    /// The fields contradict each other.
    #[error(transparent)]
    Request(#[from] SceneError),
}

/// Position and orientation of the camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum CameraPose {
    /// In an orbit around a body: facing the body, then turned by yaw to the right and by pitch upwards. Azimuth, elevation and
    /// distance (from the centre, in equatorial radii) are those of an `OrbitCamera`.
    Orbit {
        body: NaifId,
        /// Whether azimuth and elevation are in body-fixed axes, so that the camera rotates with the body; otherwise they are in ICRF.
        #[serde(rename = "fixed")]
        is_body_fixed: bool,
        azimuth_deg: f64,
        elevation_deg: f64,
        distance_radii: f64,
        yaw_deg: f64,
        pitch_deg: f64,
    },
    /// On the surface, or above it: planetographic latitude, east longitude, height above the ellipsoid; azimuth (from north through east) and altitude of
    /// the direction that the camera faces, unless it tracks another body.
    Ground { body: NaifId, latitude_deg: f64, longitude_deg: f64, height_km: f64, azimuth_deg: f64, altitude_deg: f64 },
    /// At the centre of a body, which is not drawn; facing the target.
    Centre { body: NaifId },
    /// At an offset from the body's centre, facing the direction `forward`; the vectors are in ICRF. Used during flights and tours.
    Free { body: NaifId, offset_km: DVec3, forward: DVec3, up: DVec3 },
}

impl CameraPose {
    /// The body to which the position is relative.
    pub fn body(&self) -> NaifId {
        match *self {
            Self::Orbit { body, .. } | Self::Ground { body, .. } | Self::Centre { body } | Self::Free { body, .. } => body,
        }
    }

    /// Calls `check` for each number. The arguments of `check`: whether the number is possible, and a function that gives the error message.
    fn check_fields(&self, check: &mut dyn FnMut(bool, &dyn Fn() -> String)) {
        let mut check_number = |field: &str, value: f64, is_in_range: bool, requirement: &str| {
            check(value.is_finite() && is_in_range, &|| format!("eye.{field} {value}: must be {requirement}"));
        };
        // Any finite azimuth, elevation, altitude, yaw or pitch is valid.
        let is_angle_in_range = true;
        match *self {
            Self::Orbit { azimuth_deg, elevation_deg, distance_radii, yaw_deg, pitch_deg, .. } => {
                for (field, value) in
                    [("azimuth_deg", azimuth_deg), ("elevation_deg", elevation_deg), ("yaw_deg", yaw_deg), ("pitch_deg", pitch_deg)]
                {
                    check_number(field, value, is_angle_in_range, "an angle");
                }
                check_number("distance_radii", distance_radii, distance_radii > 0.0, "a positive number");
            }
            Self::Ground { latitude_deg, longitude_deg, height_km, azimuth_deg, altitude_deg, .. } => {
                check_number("latitude_deg", latitude_deg, (-90.0..=90.0).contains(&latitude_deg), "-90 to 90 degrees");
                check_number("longitude_deg", longitude_deg, (-360.0..=360.0).contains(&longitude_deg), "-360 to 360 degrees east");
                check_number("height_km", height_km, height_km > 0.0, "above the ground");
                check_number("azimuth_deg", azimuth_deg, is_angle_in_range, "an angle");
                check_number("altitude_deg", altitude_deg, is_angle_in_range, "an angle");
            }
            Self::Centre { .. } => {}
            Self::Free { offset_km, forward, up, .. } => {
                for (field, value) in [("offset_km", offset_km), ("forward", forward), ("up", up)] {
                    let may_be_zero = field == "offset_km";
                    let requirement = if may_be_zero { "finite" } else { "finite and not zero" };
                    check(value.is_finite() && (may_be_zero || value != DVec3::ZERO), &|| {
                        format!("eye.{field} {value}: must be {requirement}")
                    });
                }
            }
        }
    }
}

/// A view. Fields that a text omits have their defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewState {
    /// TDB seconds past J2000.
    pub tdb_s: f64,
    /// The body to which automatic exposure gives more weight than to others, and that the camera faces if `tracks` is true.
    pub target: NaifId,
    /// The camera's position and orientation.
    #[serde(rename = "eye")]
    pub camera_pose: CameraPose,
    /// Whether the camera keeps facing the target; otherwise it faces the direction given by the angles of its pose.
    #[serde(default = "default_true")]
    pub tracks: bool,
    /// Vertical field of view.
    pub fov_deg: f64,
    /// Roll about the line of sight; positive turns the image clockwise, before it is mirrored. A free pose, with its own up direction, does not use it, nor
    /// does a dome image centred on the zenith, from the ground or while the camera follows another body.
    #[serde(default)]
    pub roll_deg: f64,
    /// Whether the image is mirrored left to right.
    #[serde(default, rename = "mirrored", skip_serializing_if = "std::ops::Not::not")]
    pub is_mirrored: bool,
    /// Exposure in stops; `None`: automatic exposure.
    #[serde(default)]
    pub exposure_stops: Option<f64>,
    #[serde(default, with = "option_serde::by_name")]
    pub tone_map: ToneMap,
    #[serde(default, with = "option_serde::effects")]
    pub effects: EffectOverrides,
    /// Whether orbits are drawn.
    #[serde(default)]
    pub orbits: bool,
    /// Whether bloom is drawn: light above white spreads, as in a lens.
    #[serde(default)]
    pub bloom: bool,
    /// Layers other than `orbits` and `bloom`.
    #[serde(default, with = "option_serde::layers")]
    pub layers: Layers,
    /// The telescope whose field of view is outlined.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub telescope: Option<Telescope>,
    /// Stops by which stars, Milky Way and zodiacal light are brightened.
    #[serde(default)]
    pub stars_boost: f64,
    #[serde(default, rename = "pixels", with = "option_serde::by_name")]
    pub pixel_view: PixelView,
    #[serde(default, with = "option_serde::by_name")]
    pub quality: Quality,
    /// Perspective image, dome, entire sphere or stereo pair.
    #[serde(default, skip_serializing_if = "CompositionState::is_plain")]
    pub composition: CompositionState,
    /// Whether opening the view pauses time; `None` leaves time as it is. While the view is open, `TimeRate` stores the pause.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paused: Option<bool>,
}

fn default_true() -> bool {
    true
}

/// Default vertical field of view.
pub(crate) const DEFAULT_FOV_DEG: f64 = 45.0;
/// Least vertical field of view.
pub(crate) const MIN_FOV_DEG: f64 = 1e-4;
/// Greatest vertical field of view.
pub(crate) const MAX_FOV_DEG: f64 = 120.0;

impl ViewState {
    /// The view of a body from `offset_km` relative to its centre. `radius_km`: its equatorial radius. `pole`: direction of its pole; both vectors are in ICRF.
    /// All other fields have their defaults.
    pub fn around(body: NaifId, offset_km: DVec3, radius_km: f64, pole: DVec3, time: Instant) -> Self {
        let orbit = OrbitCamera::from_offset(offset_km, radius_km, pole);
        Self {
            tdb_s: time.tdb_seconds_past_j2000(),
            target: body,
            camera_pose: inertial_orbit_pose(body, orbit),
            tracks: true,
            fov_deg: DEFAULT_FOV_DEG,
            roll_deg: 0.0,
            is_mirrored: false,
            exposure_stops: None,
            tone_map: ToneMap::default(),
            effects: EffectOverrides::default(),
            orbits: false,
            bloom: false,
            layers: Layers::default(),
            telescope: None,
            stars_boost: 0.0,
            pixel_view: PixelView::default(),
            quality: Quality::default(),
            composition: CompositionState::default(),
            paused: None,
        }
    }

    /// A view that tracks a body, with automatic exposure. All other settings, such as time, quality, effects and layers, are kept.
    pub(crate) fn tracking_view(&self, target: NaifId, camera_pose: CameraPose, fov_deg: f64) -> Self {
        Self { target, camera_pose, tracks: true, fov_deg, roll_deg: 0.0, exposure_stops: None, ..self.clone() }
    }

    /// As [`Self::tracking_view`], but at an instant, with time paused.
    pub(crate) fn paused_view(&self, time: Instant, target: NaifId, camera_pose: CameraPose, fov_deg: f64) -> Self {
        Self { tdb_s: time.tdb_seconds_past_j2000(), paused: Some(true), ..self.tracking_view(target, camera_pose, fov_deg) }
    }

    pub fn time(&self) -> Instant {
        Instant::from_tdb_seconds_past_j2000(self.tdb_s)
    }

    /// The request for this view. `width` and `height`: size of the image, pixels.
    ///
    /// # Errors
    /// If the view cannot be drawn; the error is one line that says why.
    pub fn request(&self, catalog: &Catalog, ephemeris: &Ephemeris, width: u32, height: u32) -> Result<ViewRequest, ViewStateError> {
        if let Some(error) = self.field_errors(catalog).into_iter().next() {
            return Err(ViewStateError::Field(error));
        }
        let mut request = ViewRequest::of(self.target, self.time());
        let pose = self.request_pose(catalog, ephemeris)?;
        request.position = pose.position;
        request.look = pose.look;
        request.up = pose.up;
        request.is_mirrored = self.is_mirrored;
        request.composition = self.composition.composition();
        request.fov_deg =
            Some(if self.composition.projection == Projection::Fisheye { self.composition.fisheye_deg } else { self.fov_deg });
        (request.width, request.height) = (width.clamp(1, MAX_IMAGE_PX), height.clamp(1, MAX_IMAGE_PX));
        request.exposure = self.exposure_stops.map_or(ExposureRequest::Auto, ExposureRequest::Stops);
        request.effects = self.effects.clone();
        request.layers = Layers { orbits: self.orbits, bloom: self.bloom, ..self.layers };
        request.telescope = self.telescope;
        request.stars_boost_stops = self.stars_boost;
        request.pixel_view = self.pixel_view;
        request.tone_map = self.tone_map;
        request.quality = self.quality;
        request.language = language::current().in_images();
        request.check().and_then(|()| request.check_bodies(catalog))?;
        if self.roll_deg != 0.0 && request.look == Look::Target && !request.composition.is_zenith_centred {
            // Where the target is seen, and so the line of sight, only the camera says.
            let plain = ViewRequest { composition: Composition::default(), fov_deg: None, ..request.clone() };
            let Viewer { camera, up_hint, .. } = viewer(catalog, ephemeris, &plain)?;
            let up = if request.composition.projection == Projection::Equirectangular { up_hint } else { camera.up };
            request.up = Up::Along { direction: self.rolled(camera.forward, up), axes: Axes::Icrf };
        }
        Ok(request)
    }

    /// The angle that the height of the image spans.
    pub(crate) fn image_fov_deg(&self) -> f64 {
        match self.composition.projection {
            Projection::Perspective => self.fov_deg,
            Projection::Fisheye => self.composition.fisheye_deg,
            Projection::Equirectangular => 180.0,
        }
    }

    /// One line for each field with an impossible value. Combinations of fields (such as a camera inside a body) are not checked.
    pub(crate) fn field_errors(&self, catalog: &Catalog) -> Vec<String> {
        let mut errors = Vec::new();
        let mut check = |is_possible: bool, error: &dyn Fn() -> String| {
            if !is_possible {
                errors.push(error());
            }
        };
        for (field, id) in [("target", self.target), ("eye.body", self.camera_pose.body())] {
            check(catalog.body(id).is_some(), &|| format!("{field}: no body has the code {}", id.0));
        }
        check(self.tdb_s.is_finite(), &|| format!("tdb_s {}: not a time", self.tdb_s));
        check((MIN_FOV_DEG..=MAX_FOV_DEG).contains(&self.fov_deg), &|| {
            format!("fov_deg {}: must be {MIN_FOV_DEG} to {MAX_FOV_DEG} degrees", self.fov_deg)
        });
        check(self.roll_deg.is_finite(), &|| format!("roll_deg {}: not an angle", self.roll_deg));
        if let Some(stops) = self.exposure_stops {
            check((-60.0..=60.0).contains(&stops), &|| format!("exposure_stops {stops}: must be -60 to 60 stops"));
        }
        check((-30.0..=30.0).contains(&self.stars_boost), &|| format!("stars_boost {}: must be -30 to 30 stops", self.stars_boost));
        if let Some(Err(e)) = self.telescope.map(Telescope::check) {
            check(false, &|| e.to_string());
        }
        for name in self.effects.bodies() {
            if let Err(e) = catalog.body_named(name) {
                check(false, &|| format!("effects: {e}"));
            }
        }
        self.camera_pose.check_fields(&mut check);
        self.composition.check_fields(&mut check);
        errors
    }

    /// `up` turned about `forward` by the roll. A positive roll turns the image clockwise, so it turns the up vector by a negative angle.
    fn rolled(&self, forward: DVec3, up: DVec3) -> DVec3 {
        DQuat::from_axis_angle(forward, -self.roll_deg.to_radians()) * up
    }

    /// The camera's pose as the fields of a request. The result is `Look::Target`, without the roll, for a camera that tracks another body, for one at a
    /// body's centre, and for one that orbits the target without yaw, pitch and roll. On the ground, the poles of a whole-sphere image are zenith and nadir,
    /// turned by the roll; the middle of a dome image centred on the zenith is the zenith, whatever the roll.
    fn request_pose(&self, catalog: &Catalog, ephemeris: &Ephemeris) -> Result<RequestPose, ViewStateError> {
        let body_of = |id: NaifId| catalog.body(id).ok_or(ViewStateError::NoSuchBody(id));
        body_of(self.target)?;
        let body = body_of(self.camera_pose.body())?;
        let body_from_icrf = |id: NaifId| ephemeris.body_from_icrf(id, self.time());
        let tracks_other_body = self.target != body.id && self.tracks;
        Ok(match self.camera_pose {
            CameraPose::Orbit { is_body_fixed, azimuth_deg, elevation_deg, distance_radii, yaw_deg, pitch_deg, .. } => {
                let axes = if is_body_fixed { Axes::BodyFixed } else { Axes::Icrf };
                let pole = if is_body_fixed { DVec3::Z } else { body_from_icrf(body.id)?.row(2) };
                let orbit = OrbitCamera::from_degrees(azimuth_deg, elevation_deg, distance_radii);
                // About the body-fixed z axis the azimuth equals the longitude.
                let offset_km = orbit.offset_km(body.radii_km.x, pole);
                let position = Position::Offset { body: body.id, offset_km, axes };
                if tracks_other_body {
                    return Ok(RequestPose { position, look: Look::Target, up: Up::Celestial });
                }
                let forward = (-offset_km).try_normalize().unwrap_or(DVec3::X);
                if yaw_deg == 0.0 && pitch_deg == 0.0 && self.roll_deg == 0.0 && self.target == body.id {
                    return Ok(RequestPose { position, look: Look::Target, up: Up::North });
                }
                let (forward, up) = rotated_view(forward, pole, yaw_deg, pitch_deg);
                RequestPose {
                    position,
                    look: Look::Along { direction: forward, axes },
                    up: Up::Along { direction: self.rolled(forward, up), axes },
                }
            }
            CameraPose::Ground { latitude_deg, longitude_deg, height_km, azimuth_deg, altitude_deg, .. } => {
                let position = Position::Ground { body: body.id, latitude_deg, longitude_deg, height_km };
                if tracks_other_body {
                    return Ok(RequestPose { position, look: Look::Target, up: Up::Zenith });
                }
                // The vertical is the same at every height.
                let (_, normal) = ground_point_km(body.radii_km, latitude_deg, longitude_deg, 0.0);
                let (forward, level_up) = view_at_azimuth_altitude(normal, azimuth_deg, altitude_deg);
                let up = match (self.composition.projection, self.composition.is_zenith_centred) {
                    (Projection::Fisheye, true) => normal,
                    (Projection::Equirectangular, _) => self.rolled(forward, normal),
                    _ => self.rolled(forward, level_up),
                };
                let axes = Axes::BodyFixed;
                RequestPose { position, look: Look::Along { direction: forward, axes }, up: Up::Along { direction: up, axes } }
            }
            CameraPose::Centre { .. } => RequestPose { position: Position::Centre(body.id), look: Look::Target, up: Up::Celestial },
            CameraPose::Free { offset_km, forward, up, .. } => RequestPose {
                position: Position::Offset { body: body.id, offset_km, axes: Axes::Icrf },
                look: Look::Along { direction: forward, axes: Axes::Icrf },
                up: Up::Along { direction: up, axes: Axes::Icrf },
            },
        })
    }
}

/// The camera's pose as the fields of a request.
struct RequestPose {
    position: Position,
    look: Look,
    up: Up,
}

/// The pose of an orbit in ICRF that faces the body.
pub(crate) fn inertial_orbit_pose(body: NaifId, orbit: OrbitCamera) -> CameraPose {
    let is_body_fixed = false;
    orbit_pose(body, orbit, is_body_fixed)
}

/// The pose of an orbit in body-fixed axes that faces the body.
pub(crate) fn body_fixed_orbit_pose(body: NaifId, orbit: OrbitCamera) -> CameraPose {
    let is_body_fixed = true;
    orbit_pose(body, orbit, is_body_fixed)
}

fn orbit_pose(body: NaifId, orbit: OrbitCamera, is_body_fixed: bool) -> CameraPose {
    CameraPose::Orbit {
        body,
        is_body_fixed,
        azimuth_deg: orbit.azimuth_rad.to_degrees(),
        elevation_deg: orbit.elevation_rad.to_degrees(),
        distance_radii: orbit.distance_radii,
        yaw_deg: 0.0,
        pitch_deg: 0.0,
    }
}

/// Largest east or west longitude that an input field accepts: for most planets, longitudes are given from 0 to 360 degrees.
pub(crate) const MAX_TYPED_LONGITUDE_DEG: f64 = 360.0;

/// Wraps a longitude to -180 to 180 degrees. A longitude in this range, including both ends, stays unchanged.
pub(crate) fn wrapped_longitude_deg(longitude_deg: f64) -> f64 {
    if (-180.0..=180.0).contains(&longitude_deg) { longitude_deg } else { (longitude_deg + 180.0).rem_euclid(360.0) - 180.0 }
}

/// Height of a camera that is placed on the ground.
pub(crate) const GROUND_CAMERA_HEIGHT_KM: f64 = 0.01;

/// A camera on the ground that faces south, 10 degrees above the horizon.
pub(crate) fn pose_on_ground(body: NaifId, latitude_deg: f64, longitude_deg: f64) -> CameraPose {
    CameraPose::Ground {
        body,
        latitude_deg: latitude_deg.clamp(-90.0, 90.0),
        longitude_deg: wrapped_longitude_deg(longitude_deg),
        height_km: GROUND_CAMERA_HEIGHT_KM,
        azimuth_deg: 180.0,
        altitude_deg: 10.0,
    }
}

/// Forward and up vectors (unit vectors) of a camera turned from the unit vector `forward` by `yaw_deg` to the right and `pitch_deg` upwards. `up_hint`: any
/// vector whose part perpendicular to `forward` points up.
pub(crate) fn rotated_view(forward: DVec3, up_hint: DVec3, yaw_deg: f64, pitch_deg: f64) -> (DVec3, DVec3) {
    let right = forward.cross(up_hint).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    let up = right.cross(forward);
    let (sin_yaw, cos_yaw) = yaw_deg.to_radians().sin_cos();
    let (sin_pitch, cos_pitch) = pitch_deg.to_radians().sin_cos();
    let yawed_forward = forward * cos_yaw + right * sin_yaw;
    (yawed_forward * cos_pitch + up * sin_pitch, up * cos_pitch - yawed_forward * sin_pitch)
}

/// Forward and up vectors of a camera that looks at an azimuth (from north through east) and an altitude, at a place with the zenith `normal`; all in
/// body-fixed axes. Up is as close to the zenith as possible.
pub(crate) fn view_at_azimuth_altitude(normal: DVec3, azimuth_deg: f64, altitude_deg: f64) -> (DVec3, DVec3) {
    let axes = horizon_axes(normal);
    let (sin_az, cos_az) = azimuth_deg.to_radians().sin_cos();
    let (sin_alt, cos_alt) = altitude_deg.to_radians().sin_cos();
    let forward = axes * DVec3::new(cos_alt * sin_az, cos_alt * cos_az, sin_alt);
    let up = axes * DVec3::new(-sin_alt * sin_az, -sin_alt * cos_az, cos_alt);
    (forward, up)
}

/// Azimuth and altitude of a direction, degrees, at a place with the zenith `normal`: the inverse of [`view_at_azimuth_altitude`].
pub(crate) fn horizontal_angles_deg(normal: DVec3, direction: DVec3) -> (f64, f64) {
    let local = horizon_axes(normal).transpose() * direction;
    (local.x.atan2(local.y).to_degrees().rem_euclid(360.0), local.z.clamp(-1.0, 1.0).asin().to_degrees())
}

/// The axes at a place with the zenith `normal`. Columns: east, north, zenith. At a pole, where no direction is east, y takes its place.
fn horizon_axes(normal: DVec3) -> DMat3 {
    let east = DVec3::Z.cross(normal).try_normalize().unwrap_or(DVec3::Y);
    DMat3::from_cols(east, normal.cross(east), normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yaw_turns_right_and_pitch_up() {
        let (forward, up) = rotated_view(DVec3::Y, DVec3::Z, 90.0, 0.0);
        assert!((forward - DVec3::X).length() < 1e-12 && (up - DVec3::Z).length() < 1e-12);
        let (forward, up) = rotated_view(DVec3::Y, DVec3::Z, 0.0, 30.0);
        assert!((forward.z - 0.5).abs() < 1e-12 && forward.dot(up).abs() < 1e-12 && up.y < 0.0);
    }

    #[test]
    fn the_horizon_axes_are_east_north_and_zenith() {
        // At 0 N 0 E the zenith is x, east y, north z.
        let axes = horizon_axes(DVec3::X);
        assert!((axes.x_axis - DVec3::Y).length() < 1e-12 && (axes.y_axis - DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn the_angles_of_a_direction_are_those_that_give_it() {
        let normal = DVec3::new(0.3, -0.5, 0.7).normalize();
        for (azimuth_deg, altitude_deg) in [(0.0, 0.0), (90.0, 30.0), (200.0, -45.0), (359.0, 89.0)] {
            let (forward, _) = view_at_azimuth_altitude(normal, azimuth_deg, altitude_deg);
            let (found_azimuth_deg, found_altitude_deg) = horizontal_angles_deg(normal, forward);
            let azimuth_error_deg = (found_azimuth_deg - azimuth_deg + 180.0).rem_euclid(360.0) - 180.0;
            let altitude_error_deg = found_altitude_deg - altitude_deg;
            assert!(azimuth_error_deg.abs() < 1e-9 && altitude_error_deg.abs() < 1e-9, "{found_azimuth_deg} {found_altitude_deg}");
        }
    }

    #[test]
    fn the_azimuth_of_a_body_fixed_orbit_is_the_longitude() {
        let orbit = OrbitCamera { azimuth_rad: 0.7, elevation_rad: 0.0, distance_radii: 2.0 };
        let offset = orbit.offset_km(1.0, DVec3::Z);
        assert!((offset.y.atan2(offset.x) - 0.7).abs() < 1e-12, "{offset}");
    }
}
