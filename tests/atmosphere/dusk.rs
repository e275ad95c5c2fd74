//! Dusk on the ground of every body with a sky: the image darkens with the sky while the Sun sinks, the light meter finds the sky that is drawn, and the
//! exposure has no jump.

use super::air_pass::image;
use crate::support::session::SESSION;
use crate::support::sweep;
use glam::{DVec2, DVec3};
use orrery::catalog::NaifId;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Look, Position, Purpose, Up, ViewRequest};
use orrery::scene::{CD_M2_PER_RADIANCE, Scene};
use orrery::time::Instant;
use orrery::units::luminance;

const SIDE: u32 = 12;
const TIME: &str = "2024-03-20T12:00:00Z";
const VENUS: NaifId = NaifId(299);
const MARS: NaifId = NaifId(499);
const TITAN: NaifId = NaifId(606);
/// Its air is too thin for a sky that is metered.
const TRITON: NaifId = NaifId(801);
const EYE_LEVEL_KM: f64 = 0.0017;
/// What to do if the bound of the light meter's error fails.
pub(super) const REMEDY: &str = "after a change of this air the bound is a fifth more than the greatest factor, also in docs/accuracy.md";
/// What is lower than this above the horizontal plane, in degrees, does not count as the sky of a view: there the arch of dusk is so bright and so thin that
/// the meter leaves it out.
const LOWEST_SKY_DEG: f64 = 6.0;
/// The sky in sunlight alone, without the rings in it.
const EFFECTS: &str = "-clouds,-night,-points,-glow,-corona,-planet-shine,-eclipse,-rings,-ring-shine";

fn time() -> Instant {
    Instant::parse(TIME).expect("a time")
}

/// The bodies with a sky, each with its name.
pub(super) fn bodies() -> Vec<(NaifId, String)> {
    let with_sky = SESSION.catalog().bodies().iter().filter(|b| b.atmosphere.is_some() && b.id != TRITON);
    let bodies: Vec<_> = with_sky.map(|b| (b.id, b.name.clone())).collect();
    assert!(bodies.len() >= 9, "{bodies:?}");
    bodies
}

/// A place near the equator: its vertical (away from the body's centre), the horizontal direction below or above which the Sun is, and the direction
/// across, all in body axes; and the position of a camera at eye level.
pub(super) struct Place {
    pub vertical: DVec3,
    pub sunward: DVec3,
    pub(super) across: DVec3,
    position: Position,
}

impl Place {
    /// The place where the Sun has an altitude above the plane across the vertical.
    fn of(id: NaifId, sun_altitude_deg: f64) -> Self {
        Self::at_height(id, sun_altitude_deg, EYE_LEVEL_KM)
    }

    /// The same with another height of the camera.
    pub fn at_height(id: NaifId, sun_altitude_deg: f64, height_km: f64) -> Self {
        let to_sun_km = SESSION.ephemeris().state(NaifId::SUN, id, time(), None).expect("placed").state.pos_km;
        let sun = SESSION.ephemeris().body_from_icrf(id, time()).expect("an orientation") * to_sun_km.normalize();
        let (sin, cos) = sun_altitude_deg.to_radians().sin_cos();
        let vertical = sun * sin + DVec3::Z.cross(sun).normalize() * cos;
        let sunward = (sun - vertical * sin).normalize();
        let radii_km = SESSION.catalog().body(id).expect("a body").radii_km;
        // The normal of the ellipsoid of revolution.
        let normal_z = vertical.z * (radii_km.x / radii_km.z).powi(2);
        let position = Position::Ground {
            body: id,
            latitude_deg: normal_z.atan2(vertical.truncate().length()).to_degrees(),
            longitude_deg: vertical.y.atan2(vertical.x).to_degrees(),
            height_km,
        };
        Self { vertical, sunward, across: vertical.cross(sunward), position }
    }

    /// A view along a direction, with another direction upwards.
    pub fn view(&self, id: NaifId, direction: DVec3, up: DVec3, fov_deg: f64) -> ViewRequest {
        ViewRequest {
            // As a target the ground would outweigh the sky.
            target: None,
            position: self.position,
            look: Look::Along { direction, axes: Axes::BodyFixed },
            up: Up::Along { direction: up, axes: Axes::BodyFixed },
            effects: EffectOverrides::parse(EFFECTS).expect("effects"),
            layers: Layers::NONE,
            width: SIDE,
            height: SIDE,
            fov_deg: Some(fov_deg),
            ..ViewRequest::of(id, time())
        }
    }
}

/// The mean radiance of the sky that is drawn at eye level.
fn drawn_radiance(id: NaifId, sun_altitude_deg: f64) -> f64 {
    drawn_radiance_from(id, sun_altitude_deg, &Place::of(id, sun_altitude_deg))
}

/// An exposure at which half floats hold the light of the sky: by day a shorter one than in dusk.
fn linear_stops(sun_altitude_deg: f64) -> f64 {
    if sun_altitude_deg > -1.0 { 4.0 } else { 16.0 }
}

/// The scene of a view as light, and the luminance of each of its pixels.
fn luminances(id: NaifId, sun_altitude_deg: f64, view: ViewRequest) -> (Scene, Vec<f64>) {
    let exposure = ExposureRequest::Stops(linear_stops(sun_altitude_deg));
    let mut scene = SESSION.scene(&ViewRequest { exposure, purpose: Purpose::LINEAR, ..view }).expect("a scene");
    // The body alone: without points, others are discs.
    scene.draws.retain(|d| d.body == id);
    let (_, hdr) = image(&scene);
    let luminances = hdr.iter().map(|pixel| luminance([0, 1, 2].map(|c| f64::from(pixel[c])))).collect();
    (scene, luminances)
}

/// The mean radiance of the drawn sky in a view, as a luminance: of the pixels that are more than [`LOWEST_SKY_DEG`] above the horizontal plane.
pub(super) fn drawn_radiance_in(id: NaifId, sun_altitude_deg: f64, place: &Place, view: ViewRequest) -> f64 {
    let (scene, luminances) = luminances(id, sun_altitude_deg, view);
    let body_from_icrf = SESSION.ephemeris().body_from_icrf(id, time()).expect("an orientation");
    let clip = |k: usize| (2.0 * k as f64 + 1.0) / f64::from(SIDE) - 1.0;
    let is_sky = |(k, _): &(usize, &f64)| {
        let ray = scene.camera.ray(DVec2::new(clip(k % SIDE as usize), -clip(k / SIDE as usize)));
        (body_from_icrf * ray.normalize()).dot(place.vertical).asin().to_degrees() > LOWEST_SKY_DEG
    };
    let sky: Vec<f64> = luminances.iter().enumerate().filter(is_sky).map(|(_, value)| *value).collect();
    assert!(sky.len() >= SIDE as usize, "{id:?}: hardly any sky in the view");
    sky.iter().sum::<f64>() / sky.len() as f64
}

/// The mean radiance of the drawn sky above the horizontal plane, as a luminance: the upper half of a cube around the camera.
pub(super) fn drawn_radiance_from(id: NaifId, sun_altitude_deg: f64, place: &Place) -> f64 {
    let (up, sunward, across) = (place.vertical, place.sunward, place.across);
    let (mut sum, mut total) = (0.0, 0.0);
    for (direction, above) in [(up, sunward), (sunward, up), (across, up), (-sunward, up), (-across, up)] {
        let (_, luminances) = luminances(id, sun_altitude_deg, place.view(id, direction, above, 90.0));
        let (side, clip) = (SIDE as usize, |k: usize| (2.0 * k as f64 + 1.0) / f64::from(SIDE) - 1.0);
        // Below the horizon is the lower half of the four side faces.
        let rows = if direction == up { side } else { side / 2 };
        for (k, value) in luminances.iter().enumerate().take(rows * side) {
            // Solid angle of the pixel.
            let weight = (1.0 + clip(k % side).powi(2) + clip(k / side).powi(2)).powf(-1.5);
            sum += weight * value;
            total += weight;
        }
    }
    sum / total
}

/// A view over the horizon, across the direction of the Sun, and its scene with automatic exposure. It looks away from the planet of a moon, or the moon of a
/// planet, that would be in the image.
fn automatic_view(id: NaifId, sun_altitude_deg: f64) -> (ViewRequest, Scene) {
    let place = Place::of(id, sun_altitude_deg);
    let looking = |direction: DVec3| {
        let view = place.view(id, direction, place.vertical, 70.0);
        let scene = SESSION.scene(&view).expect("a scene");
        (view, scene)
    };
    let (view, scene) = looking(place.across);
    let others = scene.bodies.iter().filter(|b| b.id != id && b.id != NaifId::SUN);
    let largest = others.max_by(|a, b| a.angular_diameter_deg.total_cmp(&b.angular_diameter_deg)).expect("another body");
    if largest.placement.centre_km.dot(scene.camera.forward) > 0.0 { looking(-place.across) } else { (view, scene) }
}

/// The scene of [`automatic_view`].
fn automatic(id: NaifId, sun_altitude_deg: f64) -> Scene {
    automatic_view(id, sun_altitude_deg).1
}

/// The luminance that the reason of an exposure gives for the sky of a body, if it names it.
pub(super) fn metered_sky_cd_m2(scene: &Scene, name: &str) -> Option<f64> {
    let reason = scene.exposure.reason.to_string();
    let (_, rest) = reason.split_once(&format!("the sky of {name} "))?;
    let (number, _) = rest.trim_start_matches("metered ").strip_prefix("at ")?.split_once(" cd/m2")?;
    number.parse().ok()
}

/// Rises of a level that count as none: by a quarter, or by 0.002 of white.
fn rises(levels: &[f64]) -> bool {
    levels.windows(2).any(|w| w[1] > 1.25 * w[0] + 0.002)
}

/// While the Sun sinks from 10 degrees above the horizon to 40 degrees below, the level at which the sky is drawn never rises. The luminance that the meter
/// finds is that of the drawn sky in the view within a factor of 2.5, where it is 0.01 cd/m2 or more. Views in which another body decides on the exposure do
/// not count.
#[test]
fn the_image_darkens_with_the_sky_that_is_metered_as_it_is_drawn() {
    for (_, (id, name)) in bodies().into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 3)) {
        let (mut levels, mut compared) = (Vec::new(), 0);
        for k in 0..=20 {
            let sun_altitude_deg = 10.0 - 2.5 * f64::from(k);
            let (drawn, (view, scene)) = (drawn_radiance(id, sun_altitude_deg), automatic_view(id, sun_altitude_deg));
            let reason = scene.exposure.reason.to_string();
            let level = drawn * scene.exposure.factor();
            println!("{name}, the Sun at {sun_altitude_deg} degrees: {:.2e} cd/m2, level {level:.4}; {reason}", drawn * CD_M2_PER_RADIANCE);
            if reason.starts_with(&format!("the sky of {name}")) || reason.starts_with(&name) || reason.starts_with("the dark sky") {
                levels.push(level);
            }
            let in_view = drawn_radiance_in(id, sun_altitude_deg, &Place::of(id, sun_altitude_deg), view) * CD_M2_PER_RADIANCE;
            if let Some(metered) = metered_sky_cd_m2(&scene, &name).filter(|_| in_view > 0.01) {
                let ratio = metered / in_view;
                assert!((0.4..2.5).contains(&ratio), "{name} at {sun_altitude_deg} degrees: metered {ratio} times what is drawn; {REMEDY}");
                compared += 1;
            }
        }
        assert!(levels.len() >= 8 && compared >= 3, "{name}: {} levels, {compared} comparisons", levels.len());
        assert!(!rises(&levels), "{name}: {levels:?}");
    }
}

/// The checks above can fail: exposed as the Earth at the same altitude of the Sun, the dusk of Mars and Titan becomes brighter as it becomes darker, and the
/// luminance of the Earth's sky in their sunlight is far from that of theirs.
#[test]
fn the_dusk_of_high_air_is_not_that_of_the_earth() {
    for id in [MARS, TITAN] {
        let sun_km = |id: NaifId| SESSION.ephemeris().state(NaifId::SUN, id, time(), None).expect("placed").state.pos_km.length();
        let irradiance = (sun_km(NaifId::EARTH) / sun_km(id)).powi(2);
        let altitudes_deg = [0.0, -4.0, -8.0];
        let drawn = altitudes_deg.map(|deg| drawn_radiance(id, deg) / irradiance);
        let on_earth = altitudes_deg.map(|deg| automatic(NaifId::EARTH, deg));
        let levels = [0, 1, 2].map(|k| drawn[k] * on_earth[k].exposure.factor());
        assert!(rises(&levels), "{id:?}: {levels:?}");
        let metered = metered_sky_cd_m2(&on_earth[2], "Earth").expect("a sky");
        let ratio = metered / (drawn[2] * CD_M2_PER_RADIANCE);
        assert!(ratio < 0.1, "{id:?}: {ratio}");
    }
}

/// From before sunset on, in steps of a quarter of a degree of the Sun's altitude, the exposure changes by less than 1.2 stops (fastest in the low air of
/// Venus: 0.8 by the curves of sky and exposure). Negative control: in ten such steps it changes by more, on the Earth.
#[test]
fn the_exposure_of_dusk_does_not_jump() {
    const MAX_STOPS: f64 = 1.2;
    let stops = |id: NaifId, k: i32| automatic(id, 7.0 - 0.25 * f64::from(k)).exposure.stops;
    for id in [NaifId::EARTH, VENUS, MARS, TITAN] {
        let all: Vec<f64> = (0..=100).map(|k| stops(id, k)).collect();
        for (k, step) in all.windows(2).enumerate() {
            assert!((step[1] - step[0]).abs() < MAX_STOPS, "{id:?}, step {k}: {step:?}");
        }
        assert!(id != NaifId::EARTH || all.windows(11).any(|w| (w[10] - w[0]).abs() > MAX_STOPS), "{all:?}");
    }
}
