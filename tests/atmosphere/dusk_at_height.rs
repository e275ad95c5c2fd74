//! The sky high in the air, by day and in dusk: the light meter finds the sky that a view shows, wherever the view looks. High up, after sunset, an arch low
//! above the place of the Sun has most of the sky's light.

use super::dusk::{Place, REMEDY, bodies, drawn_radiance_from, drawn_radiance_in, metered_sky_cd_m2};
use crate::support::session::SESSION;
use crate::support::sweep;
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::{CD_M2_PER_RADIANCE, darkest_white};
use std::ops::Range;

const EARTH: NaifId = NaifId(399);
const MARS: NaifId = NaifId(499);
const TITAN: NaifId = NaifId(606);
/// Metered over drawn luminance: a fifth more than the range found, 0.35 (Titan, whose thick air is metered too dark) to 2.5 (the zenith 30 km above the Earth
/// with the Sun 8 degrees below the horizon).
const RATIOS: Range<f64> = 0.29..3.0;
/// Darker skies are not compared.
const MIN_CD_M2: f64 = 0.01;
const FOV_DEG: f64 = 70.0;

/// Directions of views of the sky alone, each with the direction upwards: the zenith, and 50 degrees above the horizon in four directions.
fn views_of_sky(place: &Place) -> [(DVec3, DVec3); 5] {
    let (sin, cos) = 50_f64.to_radians().sin_cos();
    let rising = |azimuth: DVec3| (place.vertical * sin + azimuth * cos, place.vertical);
    let (sunward, across) = (place.sunward, place.across);
    [(place.vertical, sunward), rising(sunward), rising(across), rising(-sunward), rising(-across)]
}

/// Heights of the camera: eye level, one at which most of the air is above, and up to half of the air's height.
fn heights_km(id: NaifId) -> [f64; 5] {
    let top_km = SESSION.catalog().body(id).and_then(|b| b.atmosphere.as_ref()).expect("air").top_km;
    [0.0017, 0.02 * top_km, 0.1 * top_km, 0.3 * top_km, 0.5 * top_km]
}

/// Drawn and metered luminance of the sky in a view; `None` if the sky is too dark, or the exposure does not name it.
fn drawn_and_metered(id: NaifId, name: &str, sun_altitude_deg: f64, place: &Place, (direction, up): (DVec3, DVec3)) -> Option<[f64; 2]> {
    let view = place.view(id, direction, up, FOV_DEG);
    let metered = metered_sky_cd_m2(&SESSION.scene(&view).expect("a scene"), name)?;
    let drawn = drawn_radiance_in(id, sun_altitude_deg, place, view) * CD_M2_PER_RADIANCE;
    (drawn > MIN_CD_M2).then_some([drawn, metered])
}

/// On the ground and up to half of the air's height, towards the Sun, across and away from it, the metered luminance is that of the drawn sky of the view
/// within a factor of 3. At the same height the sky is metered differently in different directions.
#[test]
fn the_sky_is_metered_as_it_is_drawn_at_every_height_and_in_every_direction() {
    for (_, (id, name)) in bodies().into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 3)) {
        let mut compared = 0;
        for height_km in heights_km(id) {
            for sun_altitude_deg in [40.0, 10.0, 0.0, -3.0, -5.0, -8.0, -11.0] {
                let place = Place::at_height(id, sun_altitude_deg, height_km);
                for view in views_of_sky(&place) {
                    let Some([drawn, metered]) = drawn_and_metered(id, &name, sun_altitude_deg, &place, view) else { continue };
                    let ratio = metered / drawn;
                    println!(
                        "{name}, {height_km} km, the Sun at {sun_altitude_deg} degrees: {drawn:.3} cd/m2, metered {ratio:.2} times that"
                    );
                    let at = format!("{name}, {height_km} km, the Sun at {sun_altitude_deg} degrees, looking along {:?}", view.0);
                    assert!(RATIOS.contains(&ratio), "{at}: metered {ratio} times what is drawn; {REMEDY}");
                    compared += 1;
                }
            }
        }
        assert!(compared >= 20, "{name}: only {compared} comparisons");
    }
}

/// The check above can fail: 20 km above the Earth and 55 km above Mars, in dusk, the mean over the entire sky is far from what a view away from the Sun shows.
/// (The meter took this mean for all views: up to 22 and 15 times what is drawn there.)
#[test]
fn the_mean_over_the_entire_sky_is_not_what_a_view_shows() {
    for (id, name, height_km) in [(EARTH, "Earth", 20.0), (MARS, "Mars", 55.0)] {
        let sun_altitude_deg = -8.0;
        let place = Place::at_height(id, sun_altitude_deg, height_km);
        let mean = drawn_radiance_from(id, sun_altitude_deg, &place) * CD_M2_PER_RADIANCE;
        let [_, _, _, away, _] = views_of_sky(&place);
        let [drawn, metered] = drawn_and_metered(id, name, sun_altitude_deg, &place, away).expect("a sky");
        println!("{name}: {drawn:.3} cd/m2 away from the Sun, metered {metered:.3}; mean of the sky {mean:.3}");
        assert!(mean / drawn > 2.0 * RATIOS.end, "{name}: {drawn} away from the Sun, {mean} in the mean");
        assert!(metered < 0.5 * mean, "{name}: metered {metered}, {mean} in the mean");
    }
}

/// High in the air an image of a dusk is exposed for the light that this sky has, not for that of a sky on the ground: the view to the zenith from half of
/// the air's height gets at least a stop more than from the ground. A camera at twice eye level gets what one at eye level gets. By day the sky darkens with
/// height: it is exposed as on the ground.
#[test]
fn a_darker_sky_at_height_is_exposed_longer_in_dusk_alone() {
    let stops_with_sun_at = |sun_altitude_deg: f64, id: NaifId, height_km: f64| {
        let place = Place::at_height(id, sun_altitude_deg, height_km);
        SESSION.scene(&place.view(id, place.vertical, place.sunward, FOV_DEG)).expect("a scene").exposure.stops
    };
    for id in [EARTH, MARS] {
        let [eye_level_km, .., half_km] = heights_km(id);
        let [on_ground, above_it, high] =
            [eye_level_km, 2.0 * eye_level_km, half_km].map(|height_km| stops_with_sun_at(-5.0, id, height_km));
        let [on_ground_by_day, high_by_day] = [eye_level_km, half_km].map(|height_km| stops_with_sun_at(10.0, id, height_km));
        println!(
            "{id:?}: {on_ground:.2} stops on the ground, {high:.2} at {half_km} km; by day {on_ground_by_day:.2} and {high_by_day:.2}"
        );
        assert!(high - on_ground > 1.0, "{id:?}: {on_ground} stops on the ground, {high} at {half_km} km");
        assert!((above_it - on_ground).abs() < 0.01, "{id:?}: {on_ground} and {above_it} stops near the ground");
        assert!(
            (high_by_day - on_ground_by_day).abs() < 0.2,
            "{id:?} by day: {on_ground_by_day} stops on the ground, {high_by_day} at {half_km} km"
        );
    }
}

/// High in Titan's haze the metered sky darkens with the Sun, too, and is that which is drawn in the view within a factor of 2.5. Without sums at 0.8 of
/// the air's height the mean over the entire sky was 2.1, 2.8 and 4.9 times as bright as drawn, the brighter the lower the Sun.
#[test]
fn the_sky_of_high_haze_is_metered_as_it_is_drawn_at_height() {
    const HEIGHT_KM: f64 = 560.0;
    let metered = [10.0, -3.0, -8.0].map(|sun_altitude_deg| {
        let place = Place::at_height(TITAN, sun_altitude_deg, HEIGHT_KM);
        let views = [(place.vertical, place.sunward), (place.across, place.vertical), (-place.across, place.vertical)];
        let named = views.into_iter().find_map(|view| drawn_and_metered(TITAN, "Titan", sun_altitude_deg, &place, view));
        let [drawn, metered] = named.expect("a view whose exposure names the sky");
        let ratio = metered / drawn;
        println!("the Sun at {sun_altitude_deg} degrees: {drawn:.3} cd/m2, metered {ratio:.2} times that");
        assert!((0.4..2.5).contains(&ratio), "the Sun at {sun_altitude_deg} degrees: metered {ratio} times what is drawn; {REMEDY}");
        metered
    });
    assert!(metered.is_sorted_by(|a, b| a > b), "{metered:?}");
}

/// From half of the air's height to its top, by day and in dusk, no view of the sky is shown brighter than a fifth of white, or than the same view from the
/// ground (up to three times as bright: the error of the metered radiance). At the exposure for a dark sky some of these views would be white.
#[test]
fn no_sky_of_the_upper_air_is_brighter_than_on_the_ground() {
    let mut brightest_for_a_dark_sky: f64 = 0.0;
    for (_, (id, name)) in bodies().into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 3)) {
        let top_km = SESSION.catalog().body(id).and_then(|b| b.atmosphere.as_ref()).expect("air").top_km;
        for sun_altitude_deg in [40.0, 10.0, 0.0, -5.0, -8.0] {
            // For each view the drawn radiance, and its level as a fraction of white.
            let drawn_at = |height_km: f64| {
                let place = Place::at_height(id, sun_altitude_deg, height_km);
                views_of_sky(&place).map(|(direction, up)| {
                    let view = place.view(id, direction, up, FOV_DEG);
                    let factor = SESSION.scene(&view).expect("a scene").exposure.factor();
                    let drawn = drawn_radiance_in(id, sun_altitude_deg, &place, view);
                    (drawn, drawn * factor)
                })
            };
            let [eye_level_km, ..] = heights_km(id);
            let on_ground = drawn_at(eye_level_km);
            for part in [0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95, 0.98, 0.995] {
                for (k, ((drawn, level), (_, level_on_ground))) in drawn_at(part * top_km).into_iter().zip(on_ground).enumerate() {
                    let at = format!("{name}, {part} of the height, the Sun at {sun_altitude_deg} degrees, view {k}");
                    println!("{at}: {level:.4} of white, on the ground {level_on_ground:.4}");
                    assert!(level < f64::max(0.2, 3.0 * level_on_ground), "{at}: {level} of white, on the ground {level_on_ground}");
                    brightest_for_a_dark_sky = brightest_for_a_dark_sky.max(drawn / darkest_white());
                }
            }
        }
    }
    assert!(brightest_for_a_dark_sky > 1.0, "{brightest_for_a_dark_sky} of white: the check above cannot fail");
}
