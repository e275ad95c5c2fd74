//! The sky of a camera in air that the body's map already includes. Where such air is opaque along the limb, the renderer continues the disc's mean colour
//! outwards beyond the limb. A ray that rises from a camera in the air never passes the limb, so it must see the light of the air alone.

use super::air_pass::image;
use super::dusk::{Place, bodies};
use crate::support::folds::larger;
use crate::support::session::SESSION;
use crate::support::sweep;
use orrery::catalog::NaifId;
use orrery::scene::Scene;
use orrery::scene::request::{ExposureRequest, Purpose, ViewRequest};
use orrery::units::luminance;

const JUPITER: NaifId = NaifId(599);
/// Exposures at which half floats hold all radiances compared: by day those of the sky, by night also that of the disc's colour, which is 0.02 to 1 (1: a white
/// surface that faces the Sun at 1 au).
const STOPS_BY_DAY: f64 = 4.0;
const STOPS_BY_NIGHT: f64 = 16.0;
/// By how much the sky may be brighter opposite the Sun, as a fraction of white. Much less than the disc's light where it must not be seen: by night that is 10
/// to 1000 times white.
const ALLOWED_EXCESS_OF_WHITE: f64 = 1e-3;

/// The scene with the draws of this body alone. The effect `points` is off in `Place::view`, so other bodies are drawn as discs, which are removed here.
/// `stops`: the exposure.
fn scene_of(id: NaifId, view: ViewRequest, stops: f64) -> Scene {
    let request = ViewRequest { exposure: ExposureRequest::Stops(stops), purpose: Purpose::LINEAR, ..view };
    let mut scene = SESSION.scene(&request).expect("a scene");
    scene.draws.retain(|d| d.body == id);
    scene
}

/// The luminance of each pixel, by row.
fn luminances(scene: &Scene) -> Vec<f64> {
    let (_, hdr) = image(scene);
    hdr.iter().map(|pixel| luminance([0, 1, 2].map(|c| f64::from(pixel[c])))).collect()
}

/// The scene with the light of the air alone, as if the map did not include the air.
fn with_air_alone(mut scene: Scene) -> Scene {
    for draw in &mut scene.draws {
        (draw.uniforms.air.blend_mode, draw.uniforms.air.map_weight) = (0.0, 0.0);
    }
    scene
}

/// Looks to the zenith, with the direction of the Sun at the top: the image shows the sky from 30 degrees above the horizon on (its corners: from 22 degrees).
fn to_the_zenith(id: NaifId, sun_altitude_deg: f64, height_km: f64) -> (Scene, f64) {
    let place = Place::at_height(id, sun_altitude_deg, height_km);
    let stops = if sun_altitude_deg > -1.0 { STOPS_BY_DAY } else { STOPS_BY_NIGHT };
    (scene_of(id, place.view(id, place.vertical, place.sunward, 120.0), stops), (-stops).exp2())
}

/// Whether the two luminances differ by at most a thousandth (two steps of half floats) or, if that is more, by a millionth of white.
fn are_equal(a: f64, b: f64, white: f64) -> bool {
    (a - b).abs() <= (1e-3 * a.max(b)).max(1e-6 * white)
}

/// Whether somewhere the sky is more than 1.5 times as bright as at the same altitude and angle on the side of the Sun. By a tenth it may be brighter, because
/// on Uranus the view's vertical and the normal of the ellipsoid differ by 1.2 degrees; and by a fifth under a Sun 8 degrees below the horizon, because gas
/// scatters more light straight back than to the side.
fn is_brighter_away_from_the_sun(light: &[f64], white: f64) -> bool {
    let side = light.len().isqrt();
    light.iter().enumerate().skip(side / 2 * side).any(|(k, away)| {
        let towards = light[(side - 1 - k / side) * side + k % side];
        *away > 1.5 * towards + ALLOWED_EXCESS_OF_WHITE * white
    })
}

/// At every height in the air and at every altitude of the Sun the rising rays see the light of the air alone, and it is nowhere brighter opposite the Sun.
/// Negative controls: light added opposite the Sun, and rays below the horizontal, to which the disc's colour beyond the limb is added.
#[test]
fn rising_rays_see_the_air_alone() {
    const HEIGHTS_IN_AIR: [f64; 7] = [0.003, 0.02, 0.1, 0.2, 0.4, 0.7, 0.95];
    const EYE_LEVEL_KM: f64 = 0.0017;
    // One body in three, chosen by the process id, unless full sweeps are on.
    for (_, (id, name)) in bodies().into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 3)) {
        let top_km = SESSION.catalog().body(id).and_then(|b| b.atmosphere.as_ref()).expect("air").top_km;
        for height_km in HEIGHTS_IN_AIR.map(|part| part * top_km).into_iter().chain([EYE_LEVEL_KM]) {
            for sun_altitude_deg in [89.0, 40.0, 5.0, -3.0, -8.0, -15.0, -30.0, -40.0] {
                let (scene, white) = to_the_zenith(id, sun_altitude_deg, height_km);
                let light = luminances(&scene);
                let of_air = luminances(&with_air_alone(scene));
                let at = format!("{name}, {height_km} km, the Sun at {sun_altitude_deg} degrees");
                for (found, expected) in light.iter().zip(&of_air) {
                    assert!(are_equal(*found, *expected, white), "{at}: {found:e}, that of the air alone is {expected:e}");
                }
                assert!(!is_brighter_away_from_the_sun(&light, white), "{at}: {light:?}");
            }
        }
    }
    // The checks can fail.
    let (scene, white) = to_the_zenith(JUPITER, 5.0, 5.0);
    let light = luminances(&scene);
    let false_light = |(k, value): (usize, &f64)| if k < light.len() / 2 { *value } else { 2.0 * value + white };
    let with_false_light: Vec<f64> = light.iter().enumerate().map(false_light).collect();
    assert!(is_brighter_away_from_the_sun(&with_false_light, white), "{with_false_light:?}");
    let place = Place::at_height(JUPITER, 40.0, 60.0);
    let to_the_horizon = scene_of(JUPITER, place.view(JUPITER, place.across, place.vertical, 60.0), STOPS_BY_DAY);
    let (light, of_air) = (luminances(&to_the_horizon), luminances(&with_air_alone(to_the_horizon)));
    let differs = light.iter().zip(&of_air).any(|(a, b)| !are_equal(*a, *b, (-STOPS_BY_DAY).exp2()));
    assert!(differs, "rays below the horizontal, too, see the air alone: {light:?}");
}

/// Mean luminance of each row of pixels, top row first. The view looks away from the Sun, which is 40 degrees high. Its direction is in the plane of the Sun
/// and the vertical, which is close to the equator's: in it, the normals of sphere and ellipsoid differ least. `altitude_deg`: of the view's middle.
fn rows(height_km: f64, altitude_deg: f64, fov_deg: f64, air_alone: bool) -> Vec<f64> {
    let place = Place::at_height(JUPITER, 40.0, height_km);
    let (sin, cos) = altitude_deg.to_radians().sin_cos();
    let direction = place.vertical * sin - place.sunward * cos;
    let scene = scene_of(JUPITER, place.view(JUPITER, direction, place.vertical, fov_deg), STOPS_BY_DAY);
    let light = luminances(&if air_alone { with_air_alone(scene) } else { scene });
    let side = light.len().isqrt();
    light.chunks(side).map(|row| row.iter().sum::<f64>() / side as f64).collect()
}

/// 60 km high in the air of Jupiter, by day: from the horizontal plane (between rows 5 and 6) down to the horizon, 2.35 degrees below (row 11 ends 0.15
/// degrees above it), the disc's colour begins gradually. In row 6, the first below the horizontal, it adds 8 %, in row 9 27 %: the negative control.
#[test]
fn the_colour_of_the_disc_begins_at_the_horizontal() {
    const DEGREES_PER_ROW: f64 = 2.2 / 6.0;
    let [light, of_air] = [false, true].map(|air_alone| rows(60.0, 0.0, 12.0 * DEGREES_PER_ROW, air_alone));
    let added: Vec<f64> = light.iter().zip(&of_air).map(|(light, of_air)| light / of_air - 1.0).collect();
    // The upper rows: within two steps of half floats.
    assert!(added[..6].iter().all(|part| part.abs() < 1e-3), "{added:?}");
    assert!((0.02..0.15).contains(&added[6]) && added[9] > 0.2, "{added:?}");
}

/// Within 1e-4 of the top of Jupiter's air, the light beside its limb (5.2 degrees below the horizontal) changes by some 0.3 %; bound: 3 %, as in
/// `top_of_air`. Negative control: below the top, the air alone is a quarter darker.
#[test]
fn light_beside_the_limb_does_not_jump_at_the_top_of_the_air() {
    let top_km = SESSION.catalog().body(JUPITER).and_then(|b| b.atmosphere.as_ref()).expect("air").top_km;
    let at = |part: f64, air_alone: bool| rows(part * top_km, -4.9, 0.4, air_alone);
    let (below, above, air_below) = (at(1.0 - 1e-4, false), at(1.0 + 1e-4, false), at(1.0 - 1e-4, true));
    let greatest = |below: &[f64]| below.iter().zip(&above).map(|(below, above)| (below / above - 1.0).abs()).fold(0.0, larger);
    assert!(greatest(&below) < 0.03, "{below:?} and {above:?}");
    assert!(greatest(&air_below) > 0.15, "{air_below:?}: the check above cannot fail");
}
