//! Minor planets as points of light: the inputs of the vertex stage of shaders/entry/minor_planets.wesl.
//!
//! In: the orbits of the catalog's small bodies, the camera, the radiance displayed as white. Out: [`MinorPlanets`]: columns that do not change from frame to
//! frame, each body's time since its perihelion, and uniforms. Always: a body's position is accurate to 1e-6 of its semi-major axis up to e = 0.97 (for larger
//! e see tests/scene/minor_planets.rs). For this, times are reduced to at most half a period in f64 before they are narrowed, and the heliocentric camera
//! position is split into two f32 vectors. Brightness follows the H,G law; the air around the camera dims and reddens it. A body too faint
//! for the exposure is drawn at [`MARKER_LEVEL`], so the layer is off by default. Left out: perturbations since the elements' epoch.

use super::minor_planet_columns::MinorPlanetColumns;
use crate::catalog::small_bodies::GAUSS_CONSTANT;
use crate::message::{Reason, reason};
use crate::scene::atmosphere::tint_table::{FrameTints, TintTable};
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::camera::{NEAR_DEPTH_KM, narrow, narrow_scalar};
use crate::scene::decision::Decision;
use crate::scene::draw::PixelView;
use crate::scene::point::point_peak;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::sky::star_colour::star_colour;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S};
use glam::{DVec3, Vec3, Vec4};
use std::f64::consts::PI;
use std::sync::Arc;

/// Radiance of the central pixel of a marker as a fraction of white, if the markers are few.
pub const MARKER_LEVEL: f64 = 0.25;
/// Largest number of bodies whose markers reach [`MARKER_LEVEL`]. Markers of more bodies are fainter, in inverse proportion to the fourth root of the number;
/// otherwise the markers of a hundred thousand bodies would merge into a white ring.
const FULL_LEVEL_COUNT: f64 = 1000.0;
/// Colour index B-V of a typical minor planet, between those of the C and the S type (0.70 and 0.86; Tedesco, Tholen and Zellner 1982, Astron. J. 87,
/// 1585).
const B_V: f32 = 0.78;

/// The minor planets of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct MinorPlanets {
    pub columns: Arc<MinorPlanetColumns>,
    /// Time of each body since its nearest perihelion passage: the result of `MinorPlanetColumns::times`.
    pub times: Arc<Vec<f32>>,
    /// The camera's axes right, up and forward, ICRF; right and up are divided by the tangents of half the field of view.
    pub axes: [Vec3; 3],
    /// Heliocentric position of the camera, au, as a sum of two vectors.
    pub camera_parts: [Vec3; 2],
    /// The viewer's velocity in units of the speed of light.
    pub velocity: Vec3,
    /// Linear RGB of luminance 1, of all minor planets.
    pub colour: Vec3,
    /// Flux divided by irradiance for a point in the middle of the frame.
    pub flux_per_irradiance: f32,
    /// Radiance of the central pixel of a point of flux 1, divided by the radiance of white.
    pub peak_over_white: f32,
    /// Flux of a marker: the smallest flux with which a body is drawn.
    pub marker_flux: f32,
    /// Axes in which the altitude of a line of sight is that above the xy plane, ICRF.
    pub air_axes: [Vec3; 3],
    /// Sine of the altitude of the first transmittance.
    pub horizon_sine: f32,
    /// Transmittances of the air around the camera (`atmosphere::tint_table`), rgb; 1 outside all air.
    pub transmittances: Vec<Vec4>,
}

/// Light time per au. The unit is the shader's unit of time for an orbit with a perihelion distance of 1 au: 1 / Gauss' constant in days, 58 days.
pub(crate) const LIGHT_TIME_PER_AU: f64 = KM_PER_AU / SPEED_OF_LIGHT_KM_S / SECONDS_PER_DAY * GAUSS_CONSTANT;
/// View depth that maps to reversed depth 1, au.
pub(crate) const NEAR_AU: f64 = NEAR_DEPTH_KM / KM_PER_AU;

/// Splits a vector into a sum of two f32 vectors.
fn two_parts(v: DVec3) -> [Vec3; 2] {
    let high = narrow(v);
    [high, narrow(v - high.as_dvec3())]
}

/// The minor planets of a frame and the decision about them; `None` in pixel views other than the final image. `sun_position_km`: barycentric; `white`: the
/// radiance displayed as white; `tints`: of the air around the camera.
pub(crate) fn minor_planets(
    request: &ViewRequest,
    columns: impl FnOnce() -> Arc<MinorPlanetColumns>,
    viewer: &Viewer,
    sun_position_km: Option<DVec3>,
    white: f64,
    tints: &FrameTints<'_>,
) -> (Option<MinorPlanets>, Option<Decision>) {
    let decided = |on: bool, reason: Reason| Some(Decision { effect: "minor-planets", on, reason, stated_error: None });
    if request.pixel_view != PixelView::Final {
        return (None, None);
    }
    if !request.layers.minor_planets {
        return (None, decided(false, reason!("minor-off")));
    }
    let Some(sun_position_km) = sun_position_km else { return (None, decided(false, reason!("no-sun-known"))) };
    let (camera, columns) = (&viewer.camera, columns());
    let marker_level = MARKER_LEVEL * (FULL_LEVEL_COUNT / columns.slope.len() as f64).powf(0.25).min(1.0);
    let days = request.time.tdb_seconds_past_j2000() / SECONDS_PER_DAY;
    let colour = star_colour(Some(B_V));
    let without_air = TintTable::of(None);
    let air = tints.table().unwrap_or(&without_air);
    let minor_planets = MinorPlanets {
        times: Arc::new(columns.times(days)),
        axes: [camera.right / camera.tan_half_fov.x, camera.up / camera.tan_half_fov.y, camera.forward].map(narrow),
        camera_parts: two_parts((camera.position_km - sun_position_km) / KM_PER_AU),
        velocity: narrow(viewer.velocity_km_s / SPEED_OF_LIGHT_KM_S),
        colour: narrow(colour),
        flux_per_irradiance: narrow_scalar(PI / camera.pixel_tangent().powi(2)),
        peak_over_white: narrow_scalar(point_peak() / white),
        marker_flux: narrow_scalar(marker_level * white / point_peak()),
        air_axes: air.axes().map(narrow),
        horizon_sine: narrow_scalar(air.horizon_sine),
        transmittances: air.transmittances.iter().map(|t| narrow(*t).extend(0.0)).collect(),
        columns,
    };
    let count = minor_planets.times.len();
    let reason = reason!("minor-orbits", count = count).and(reason!("minor-brightness", level = format_args!("{marker_level:.2}")));
    (Some(minor_planets), decided(count > 0, reason))
}
