//! Views of general interest that are not moments of the catalog: the whole system, the Moon's phases, the sky tonight.
//!
//! In: the current time, the observer's place, positions. Out: a [`ViewState`], or `None` if the ephemeris does not cover the time; the rate
//! of time at which the view runs. Always: quality and effects are those of the user. Besides camera (with `tracks`) and time, a preset may change only orbits,
//! constellations, the brightness of stars and the exposure; `PresetChanges` undoes this for the next view.

use super::body_positions::BodyPositions;
use super::orbit_camera::OrbitCamera;
use super::settings::Home;
use super::view_state::{CameraPose, DEFAULT_FOV_DEG, ViewState, inertial_orbit_pose};
use super::what_to_see_now::MOON_FOV_DEG;
use crate::catalog::NaifId;
use crate::ephemeris::topocentric::ground_point_km;
use crate::time::Instant;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, SUN_RADIUS_KM};
use crate::view::language::{text, text_by_id};
use glam::DVec3;

/// Elevation of the camera above the Sun's equator.
const SYSTEM_ELEVATION_DEG: f64 = 40.0;
/// Exposure of a view of the system, stops as in `ExposureRequest::Stops` (greater is brighter): low enough that the Sun's glare hides no orbit, high enough
/// that stars appear in the layer `bright_stars`.
const SYSTEM_EXPOSURE_STOPS: f64 = 2.0;
/// Distance of the camera from the Sun at which the orbit of Neptune fills the image.
const OUTER_DISTANCE_AU: f64 = 75.0;
/// Distance of the camera from the Sun at which the orbit of Mars fills the image.
const INNER_DISTANCE_AU: f64 = 3.9;
/// Height of the camera of [`Preset::SkyTonight`] above the ground.
const SKY_CAMERA_HEIGHT_KM: f64 = 0.002;
/// Altitude of the middle of the image of [`Preset::SkyTonight`]; the image's lower edge is just above the horizon.
const SKY_ALTITUDE_DEG: f64 = 38.0;
/// Vertical field of view of [`Preset::SkyTonight`].
const SKY_FOV_DEG: f64 = 75.0;
/// Stops by which stars, Milky Way and zodiacal light are brightened in [`Preset::SkyTonight`].
const SKY_STARS_BOOST: f64 = 2.0;
/// Altitude of the Sun below which the sky counts as dark: the middle of astronomical twilight (-12 to -18 degrees).
const DARK_SUN_ALTITUDE_DEG: f64 = -15.0;
/// Time step of the search for a dark sky.
const DARK_STEP_S: f64 = 600.0;
/// Length of the search for a dark sky.
const DARK_SEARCH_S: f64 = SECONDS_PER_DAY;

/// A view of general interest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    WholeSystem,
    InnerSystem,
    MoonPhases,
    SkyTonight,
}

impl Preset {
    pub const ALL: [Self; 4] = [Self::WholeSystem, Self::InnerSystem, Self::MoonPhases, Self::SkyTonight];

    pub fn name(self) -> &'static str {
        match self {
            Self::WholeSystem => text!("preset-system"),
            Self::InnerSystem => text!("preset-inner-system"),
            Self::MoonPhases => text!("preset-phases"),
            Self::SkyTonight => text!("preset-sky"),
        }
    }

    /// A sentence that describes the view.
    pub(crate) fn about(self) -> &'static str {
        text_by_id(match self {
            Self::WholeSystem => "preset-system-about",
            Self::InnerSystem => "preset-inner-system-about",
            Self::MoonPhases => "preset-phases-about",
            Self::SkyTonight => "preset-sky-about",
        })
    }

    /// English and German words by which the search field finds this preset, besides its name.
    pub(crate) fn search_words(self) -> &'static str {
        match self {
            Self::WholeSystem => "whole solar system all planets orbits sonnensystem planeten bahnen",
            Self::InnerSystem => "inner solar system planets orbits inneres sonnensystem planeten bahnen",
            Self::MoonPhases => "moon lunar phases mondphasen",
            Self::SkyTonight => "night sky tonight stars constellations nachthimmel sternhimmel sternbilder",
        }
    }

    /// Rate at which time runs in this view, scene seconds per real second; `None` keeps the user's rate.
    pub fn rate(self) -> Option<f64> {
        match self {
            Self::WholeSystem | Self::InnerSystem => None,
            Self::MoonPhases => Some(SECONDS_PER_DAY),
            Self::SkyTonight => Some(1.0),
        }
    }

    /// The view of this preset; settings that it does not change come from `base_view`.
    pub fn view(self, positions: &dyn BodyPositions, now: Instant, observer_place: Home, base_view: &ViewState) -> Option<ViewState> {
        let with_time_running = |view: ViewState| ViewState { paused: Some(false), ..view };
        match self {
            Self::WholeSystem => system_view(OUTER_DISTANCE_AU, positions, now, base_view),
            Self::InnerSystem => system_view(INNER_DISTANCE_AU, positions, now, base_view),
            Self::MoonPhases => {
                Some(with_time_running(base_view.paused_view(now, NaifId::MOON, CameraPose::Centre { body: NaifId::EARTH }, MOON_FOV_DEG)))
            }
            Self::SkyTonight => {
                let time = dark_time(positions, now, observer_place)?;
                // North or south, where the Moon and the planets culminate.
                let azimuth_deg = if observer_place.latitude_deg < 0.0 { 0.0 } else { 180.0 };
                let camera_pose = CameraPose::Ground {
                    body: NaifId::EARTH,
                    latitude_deg: observer_place.latitude_deg,
                    longitude_deg: observer_place.longitude_deg,
                    height_km: SKY_CAMERA_HEIGHT_KM,
                    azimuth_deg,
                    altitude_deg: SKY_ALTITUDE_DEG,
                };
                let mut view = with_time_running(base_view.paused_view(time, NaifId::EARTH, camera_pose, SKY_FOV_DEG));
                // `tracks` is false so that the camera faces the sky at the angles above, and not a body.
                (view.tracks, view.stars_boost, view.layers.constellations) = (false, SKY_STARS_BOOST, true);
                Some(view)
            }
        }
    }
}

/// The planets' orbits from above, with the camera on the Earth's side of the Sun.
fn system_view(distance_au: f64, positions: &dyn BodyPositions, now: Instant, base_view: &ViewState) -> Option<ViewState> {
    let pole = positions.body_from_icrf(NaifId::SUN, now)?.row(2);
    let earth_km = positions.geometric_vector_km(NaifId::SUN, NaifId::EARTH, now)?;
    // Only the azimuth of this offset, the Earth's direction from the Sun, is kept.
    let mut camera = OrbitCamera::from_offset_radii(earth_km.try_normalize()?, pole);
    camera.elevation_rad = SYSTEM_ELEVATION_DEG.to_radians();
    camera.distance_radii = distance_au * KM_PER_AU / SUN_RADIUS_KM;
    let view = base_view.paused_view(now, NaifId::SUN, inertial_orbit_pose(NaifId::SUN, camera), DEFAULT_FOV_DEG);
    // `paused: None`: time runs or is paused as before.
    Some(ViewState { orbits: true, exposure_stops: Some(SYSTEM_EXPOSURE_STOPS), paused: None, ..view })
}

/// The first time from `now` on at which the sky over a place is dark; if the sky stays bright for a day, the time of the lowest Sun. `None` if the ephemeris
/// ends before the search does.
fn dark_time(positions: &dyn BodyPositions, now: Instant, observer_place: Home) -> Option<Instant> {
    // Only the direction of the vertical is used; it depends neither on the radii nor on the height.
    let (_, up) = ground_point_km(DVec3::ONE, observer_place.latitude_deg, observer_place.longitude_deg, 0.0);
    let sun_altitude_sine = |time: Instant| -> Option<f64> {
        let sun = positions.geometric_vector_km(NaifId::EARTH, NaifId::SUN, time)?.try_normalize()?;
        Some((positions.body_from_icrf(NaifId::EARTH, time)? * sun).dot(up))
    };
    // The least sine of the Sun's altitude so far, with its time.
    let mut lowest: Option<(f64, Instant)> = None;
    for step in 0..=(DARK_SEARCH_S / DARK_STEP_S) as u32 {
        let time = now.plus_seconds(f64::from(step) * DARK_STEP_S);
        let sine = sun_altitude_sine(time)?;
        if sine < DARK_SUN_ALTITUDE_DEG.to_radians().sin() {
            return Some(time);
        }
        if lowest.is_none_or(|(least, _)| sine < least) {
            lowest = Some((sine, time));
        }
    }
    lowest.map(|(_, time)| time)
}
