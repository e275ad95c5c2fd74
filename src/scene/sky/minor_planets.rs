//! Minor planets as points of light: what the vertex stage of shaders/entry/minor_planets.wesl is given.
//!
//! In: the orbits of the catalog's small bodies, the camera, what is white. Out: [`MinorPlanets`]: columns that stay from frame to frame, the time of each since its perihelion, and
//! uniforms. Always: times are reduced in f64 before they are narrowed, and the camera is given from the Sun in two parts, so that a body's place is good to 1e-6 of its
//! semi-major axis up to e = 0.97 (tests/scene/minor_planets.rs has what is beyond). Brightness follows the H,G law. What the exposure does not show is a mark of
//! [`MARK_LEVEL`], so the layer is off until it is asked for. Left out: perturbations since the elements' epoch.

use crate::catalog::small_bodies::{BrightnessLaw, GAUSS_CONSTANT, HeliocentricOrbit, SmallBody};
use crate::scene::camera::viewpoint::Viewer;
use crate::scene::camera::{NEAR_DEPTH_KM, narrow, narrow_scalar};
use crate::scene::decision::Decision;
use crate::scene::draw::PixelView;
use crate::scene::light::photometry::irradiance_of_magnitude;
use crate::scene::point::point_peak;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::sky::star_colour::star_colour;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Brightest pixel of a mark, of white.
pub const MARK_LEVEL: f64 = 0.25;
/// Bodies from which on marks grow fainter, by the fourth root of their number: a hundred thousand would be one white ring.
const MANY: f64 = 1000.0;
/// Colour index of a common minor planet, between those of the C and the S type (0.70 and 0.86; Tedesco, Tholen and Zellner 1982, Astron. J. 87, 1585).
const B_V: f32 = 0.78;

/// What does not change from frame to frame, one row a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MinorPlanetColumns {
    /// Vector to the perihelion, au, ICRF, and 1 - e: four numbers a body.
    pub perihelion: Arc<Vec<f32>>,
    /// Direction of the motion there, as long as sqrt(1 + e) perihelion distances, and the irradiance at full phase 1 au from Sun and viewer: four numbers a body.
    pub along: Arc<Vec<f32>>,
    /// G of the H,G law.
    pub slope: Arc<Vec<f32>>,
    /// In f64: days past J2000 of a passage, days a unit of time of the shader, and half the period in such units.
    clocks: Arc<Vec<Clock>>,
}

/// The time of a body on its orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Clock {
    passage_days: f64,
    days_per_unit: f64,
    half_turn: f64,
}

impl Clock {
    fn of(orbit: &HeliocentricOrbit) -> Self {
        let (q, alpha) = (orbit.perihelion_au, 1.0 - orbit.eccentricity);
        let half_turn = if alpha > 0.0 { PI * alpha.powf(-1.5) } else { f64::INFINITY };
        Self { passage_days: orbit.passage_days, days_per_unit: q.powf(1.5) / GAUSS_CONSTANT, half_turn }
    }

    /// Time since the nearest passage, in units of the shader.
    fn time(&self, days: f64) -> f64 {
        let t = (days - self.passage_days) / self.days_per_unit;
        if self.half_turn.is_finite() { t - 2.0 * self.half_turn * (0.5 * t / self.half_turn).round() } else { t }
    }
}

impl MinorPlanetColumns {
    pub fn of(bodies: &[SmallBody]) -> Self {
        let mut columns = [Vec::with_capacity(4 * bodies.len()), Vec::with_capacity(4 * bodies.len()), Vec::with_capacity(bodies.len())];
        for body in bodies {
            let o = &body.orbit;
            let (brightness, slope) = match body.brightness {
                BrightnessLaw::Asteroid { h, g } => (irradiance_of_magnitude(h), g),
                BrightnessLaw::Comet { .. } | BrightnessLaw::Unknown => (0.0, 0.0),
            };
            let along = o.along_perihelion * (o.perihelion_au * (1.0 + o.eccentricity).sqrt());
            columns[0].extend(narrow(o.to_perihelion * o.perihelion_au).to_array());
            columns[0].push(narrow_scalar(1.0 - o.eccentricity));
            columns[1].extend(narrow(along).to_array());
            columns[1].push(narrow_scalar(brightness));
            columns[2].push(narrow_scalar(slope));
        }
        let [perihelion, along, slope] = columns.map(Arc::new);
        Self { perihelion, along, slope, clocks: Arc::new(bodies.iter().map(|b| Clock::of(&b.orbit)).collect()) }
    }

    /// Time of each body since its perihelion as the shader takes it.
    pub fn times(&self, days: f64) -> Vec<f32> {
        self.clocks.iter().map(|clock| narrow_scalar(clock.time(days))).collect()
    }
}

/// The minor planets of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct MinorPlanets {
    pub columns: Arc<MinorPlanetColumns>,
    pub times: Arc<Vec<f32>>,
    /// The camera's axes, right and up over the tangents of half the field of view.
    pub axes: [Vec3; 3],
    /// The camera from the Sun, au: the sum of both.
    pub camera_parts: [Vec3; 2],
    /// The viewer's velocity over that of light.
    pub velocity: Vec3,
    pub colour: Vec3,
    /// Flux of a point of unit irradiance in the middle of the frame.
    pub flux_per_irradiance: f32,
    /// The brightest pixel of a point of flux 1, over white.
    pub peak_over_white: f32,
    pub mark_flux: f32,
}

/// Light's days an au times Gauss' constant: what an au delays, in units of time at 1 au.
pub const LIGHT_TIME: f64 = KM_PER_AU / SPEED_OF_LIGHT_KM_S / SECONDS_PER_DAY * GAUSS_CONSTANT;
/// Depth 1 of the picture, au.
pub const NEAR_AU: f64 = NEAR_DEPTH_KM / KM_PER_AU;

/// A vector as a sum of two in f32.
fn two_parts(v: DVec3) -> [Vec3; 2] {
    let high = narrow(v);
    [high, narrow(v - high.as_dvec3())]
}

/// The minor planets of a frame, and why they are there or not; `None` where the picture shows a number. `sun_km`: barycentric.
pub(crate) fn minor_planets(
    request: &ViewRequest,
    columns: impl FnOnce() -> Arc<MinorPlanetColumns>,
    viewer: &Viewer,
    sun_km: Option<DVec3>,
    white: f64,
) -> (Option<MinorPlanets>, Option<Decision>) {
    let decided = |on: bool, reason: String| Some(Decision { feature: "minor-planets", on, reason, tier: None });
    if request.pixel_view != PixelView::Final {
        return (None, None);
    }
    if !request.layers.minor_planets {
        return (None, decided(false, "off unless you ask for it: most are marks, far fainter than any exposure shows".into()));
    }
    let Some(sun_km) = sun_km else { return (None, decided(false, "no source knows where the Sun is at this time".into())) };
    let (camera, columns) = (&viewer.camera, columns());
    let mark_level = MARK_LEVEL * (MANY / columns.slope.len() as f64).powf(0.25).min(1.0);
    let days = request.time.tdb_seconds_past_j2000() / SECONDS_PER_DAY;
    let colour = star_colour(Some(B_V));
    let all = MinorPlanets {
        times: Arc::new(columns.times(days)),
        axes: [camera.right / camera.tan_half_fov.x, camera.up / camera.tan_half_fov.y, camera.forward].map(narrow),
        camera_parts: two_parts((camera.position_km - sun_km) / KM_PER_AU),
        velocity: narrow(viewer.velocity_km_s / SPEED_OF_LIGHT_KM_S),
        colour: narrow(colour),
        flux_per_irradiance: narrow_scalar(PI / camera.pixel_tangent().powi(2)),
        peak_over_white: narrow_scalar(point_peak() / white),
        mark_flux: narrow_scalar(mark_level * white / point_peak()),
        columns,
    };
    let count = all.times.len();
    let reason = format!("{count} orbits; brightness by H and G, and marks of {mark_level:.2} of white where that is less");
    (Some(all), decided(count > 0, reason))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Times stay within half a turn for centuries, and differ from the whole by whole turns.
    #[test]
    fn times_are_reduced_by_whole_turns() {
        let orbit = |q: f64, e: f64| HeliocentricOrbit {
            perihelion_au: q,
            eccentricity: e,
            to_perihelion: DVec3::X,
            along_perihelion: DVec3::Y,
            passage_days: 8375.25,
        };
        for (q, e) in [(2.5, 0.08), (0.587, 0.967), (0.3, 0.9992), (1.0, 0.0)] {
            let clock = Clock::of(&orbit(q, e));
            let period_days = TAU / GAUSS_CONSTANT * (q / (1.0 - e)).powf(1.5);
            for days in [-700_000.0, -3.5, 8375.25, 9000.0, 812_345.6] {
                let t = clock.time(days);
                assert!(t.abs() <= clock.half_turn * (1.0 + 1e-12), "{q} {e} {days}: {t}");
                let turns = ((days - 8375.25) - t * clock.days_per_unit) / period_days;
                assert!((turns - turns.round()).abs() < 1e-9, "{turns}");
            }
        }
        // An open path has no turns.
        let open = Clock::of(&orbit(1.0, 1.2));
        assert!((open.time(8375.25 + 1e5) * open.days_per_unit - 1e5).abs() < 1e-6);
    }
}
