//! A body drawn as a point has the light and the colour of its disc: air in front of the Sun, the eclipsed Moon, both sides of the full Moon, planet-shine,
//! elongated moons.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::{Body, NaifId};
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::photometry::irradiance_at_viewer;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Position, Purpose, ViewRequest};
use orrery::time::Instant;
use orrery::units::KM_PER_AU;

/// A side of a square image and a diameter of the body in it, in pixels: a disc with its air, and a point. The point's image is so narrow that no other body is
/// in it at the phase angles of the tests.
const DISC: [u32; 2] = [48, 36];
const POINT: [u32; 2] = [8, 1];

/// Light of a body at a phase angle times its distance squared, linear RGB. `distance_radii`: so large that the phase law holds in full.
fn light(body: i32, phase_deg: f64, time: &str, distance_radii: f64, [side, diameter_px]: [u32; 2], effects: &str) -> DVec3 {
    let (body, time) = (NaifId(body), Instant::parse(time).expect("a time"));
    let towards_sun = SESSION.ephemeris().state(NaifId::SUN, body, time, None).expect("a position").state.pos_km.normalize();
    // In the ecliptic, roughly.
    let across = towards_sun.cross(DVec3::new(0.0, -0.4, 0.917)).normalize();
    let radius_km = SESSION.catalog().body(body).expect("in the catalog").radii_km.x;
    let (sin, cos) = phase_deg.to_radians().sin_cos();
    let offset_km = (towards_sun * cos + across * sin) * (radius_km * distance_radii);
    let request = ViewRequest {
        position: Position::Offset { body, offset_km, axes: Axes::Icrf },
        fov_deg: Some((2.0 / distance_radii * f64::from(side) / f64::from(diameter_px)).to_degrees()),
        effects: EffectOverrides::parse(&format!("sun:-glow,sun:-corona{effects}")).expect("effects"),
        ..ViewRequest::of(body, time)
    };
    light_of(request, side)
}

/// The same of the Moon from the Earth's centre.
fn light_of_moon(time: &str, fov_deg: f64, effects: &str) -> DVec3 {
    let request = ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        fov_deg: Some(fov_deg),
        effects: EffectOverrides::parse(&format!("-planet-shine{effects}")).expect("effects"),
        ..ViewRequest::of(NaifId::MOON, Instant::parse(time).expect("a time"))
    };
    light_of(request, 64)
}

/// Light of the image, in a unit that does not depend on its field of view.
fn light_of(request: ViewRequest, side: u32) -> DVec3 {
    let (exposure, purpose, layers) = (ExposureRequest::Stops(0.0), Purpose::LINEAR, Layers::NONE);
    let request = ViewRequest { exposure, purpose, layers, width: side, height: side, ..request };
    let frame = SESSION.draw(&request, SamplingQuality { samples: 4, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn").frame;
    let sum: DVec3 = frame.hdr.iter().map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).sum();
    sum * ((0.5 * request.fov_deg.expect("a field of view").to_radians()).tan() / f64::from(side)).powi(2)
}

/// The greatest difference of a channel between two lights, relative to the second.
fn difference(light: DVec3, reference: DVec3) -> f64 {
    (light / reference - 1.0).abs().to_array().into_iter().fold(0.0, larger)
}

const TIME: &str = "2024-10-10T00:00:00Z";

/// The light that air adds at large phase angles, from the catalog. A tenth is allowed: the disc of Mars itself has up to 8 % less light at 24
/// pixels than at 36, because its bright rim is lower than a pixel.
#[test]
fn a_backlit_body_with_air_has_the_light_of_its_disc() {
    for (body, phases_deg, effects) in [
        (606, &[75.0, 90.0, 135.0, 150.0, 165.0, 175.0][..], ""),
        (499, &[140.0, 150.0, 165.0, 175.0][..], ""),
        (999, &[165.0, 175.0][..], ""),
        (599, &[160.0, 165.0][..], ""),
        (699, &[165.0, 170.0][..], ",-rings"),
        (799, &[162.0, 165.0, 170.0][..], ""),
        (899, &[150.0, 165.0, 170.0][..], ""),
    ] {
        for phase_deg in phases_deg {
            let effects = format!(",-planet-shine,-eclipse{effects}");
            let [disc, point] = [DISC, POINT].map(|size| light(body, *phase_deg, TIME, 400.0, size, &effects));
            println!("{body} at {phase_deg}: point / disc {}", point / disc);
            // Of Pluto and Uranus, and the blue of Titan, the catalog's colour of the ground differs from that of the map's crescent.
            assert!(difference(point, disc) < 0.15, "{body} at {phase_deg}: point {point}, disc {disc}");
            assert!((point.y / disc.y - 1.0).abs() < 0.1, "{body} at {phase_deg}: point {point}, disc {disc}");
        }
    }
    // Without the air, point and disc are faint, and the comparison would fail.
    for body in [606, 499] {
        let [disc, point] = [("", DISC), (",-atmosphere", POINT)].map(|(effects, size)| light(body, 150.0, TIME, 400.0, size, effects));
        assert!(point.y < 0.2 * disc.y, "{body}: {point}, {disc}");
    }
}

/// The light of a row of `forward_light` (see catalogs/README.md) at a phase angle, computed from the disc. `now`: the present row, which gives the unit.
fn forward_light_of_disc(body: &Body, phase_deg: f64, now: DVec3) -> DVec3 {
    let of = |size, effects: &str| light(body.id.0, phase_deg, TIME, 400.0, size, &format!(",-planet-shine,-eclipse,-rings{effects}"));
    let unit = (of(POINT, "") - of(POINT, ",-atmosphere")).element_sum() / now.element_sum();
    // Not the light of the point without air: at 175 degrees and more, planets near the Sun may be in the point's image. They cancel in the difference above.
    let of_phase_law = body.colour.as_dvec3() * irradiance_at_viewer(body, phase_deg.to_radians(), KM_PER_AU, 1.0, 1.0);
    (of(DISC, "") / unit - of_phase_law).max(DVec3::ZERO)
}

/// Prints `forward_light` of all bodies as catalogs/atmospheres.toml has it, at the phase angles of the present rows. Rows without light stay.
#[test]
#[ignore = "prints tables for catalogs/atmospheres.toml"]
fn print_forward_light() {
    let rounded = |x: f64| -> f64 { format!("{x:.2e}").parse().expect("a number") };
    for body in SESSION.catalog().bodies() {
        let Some(air) = body.atmosphere.as_ref().filter(|air| !air.forward_light.is_empty()) else { continue };
        println!("# {}\nforward_light = [", body.name);
        for [phase_deg, rgb @ ..] in &air.forward_light {
            let now = DVec3::from_array(*rgb);
            let new = if now == DVec3::ZERO { now } else { forward_light_of_disc(body, *phase_deg, now) };
            println!("    {:?},", [*phase_deg, rounded(new.x), rounded(new.y), rounded(new.z)]);
        }
        println!("]");
    }
}

/// The Moon in the Earth's umbra is as red and as bright as a point as it is as a disc: the approximation for points and the shader differ by 3 % in red and by
/// 10 % in blue, the faintest channel.
#[test]
fn the_eclipsed_moon_is_as_red_as_a_point() {
    let time = "2025-03-14T06:59:00Z";
    let [disc, point] = [3.0, 30.0].map(|fov_deg| light_of_moon(time, fov_deg, ""));
    let colour = |light: DVec3| [light.x / light.y, light.z / light.y];
    let ([red, blue], [disc_red, disc_blue]) = (colour(point), colour(disc));
    println!("red {red:.3}, disc {disc_red:.3}; blue {blue:.3}, disc {disc_blue:.3}; point / disc {}", point / disc);
    assert!((red / disc_red - 1.0).abs() < 0.08 && (blue / disc_blue - 1.0).abs() < 0.2, "point {point}, disc {disc}");
    assert!((point.y / disc.y - 1.0).abs() < 0.15, "point {point}, disc {disc}");
    // Negative control: the Moon outside the shadow, whose colour points had in it.
    let [red_outside, blue_outside] = colour(light_of_moon(time, 30.0, ",-eclipse"));
    assert!(red_outside < 0.6 * disc_red && blue_outside > 3.0 * disc_blue, "{red_outside} {blue_outside}");
}

/// The full Moon from the Earth, and its far side in full sunlight.
#[test]
fn both_sides_of_the_full_moon_have_the_light_of_their_discs() {
    let near = [1.0, 30.0].map(|fov_deg| light_of_moon("2025-01-13T22:00:00Z", fov_deg, ""));
    // Narrow, because the Earth is near the Moon in the sky.
    let effects = ",-planet-shine,-eclipse";
    let far = [[36, 24], [4, 1]].map(|size| light(301, 2.0, "2025-01-29T12:36:00Z", 400.0, size, effects));
    for [disc, point] in [near, far] {
        println!("point / disc {}", point / disc);
        // A small disc is up to 6 % too bright (`scene::point`), the harmonics are within 1 % of the map.
        assert!(difference(point, disc) < 0.1, "point {point}, disc {disc}");
    }
    // Negative control: the point of a Moon without sides would differ from one of the discs, because the far side of the map is half as bright again.
    let catalog = SESSION.catalog();
    let moon = catalog.body(NaifId::MOON).expect("the Moon");
    let [near, far] = [DVec3::X, DVec3::NEG_X].map(|side| orrery::scene::photometry::light_curve(moon, side, side));
    assert!((near - 1.0).abs() < 0.03 && far > 1.4, "near side {near}, far side {far}");
}

/// Jupiter lights the night sides of its moons. Sunlight alone would be half of the light of Io.
#[test]
fn a_crescent_moon_has_the_planet_shine_of_its_disc() {
    for (body, most_sunlight) in [(501, 0.6), (502, 0.8)] {
        let [disc, point] = [[24, 12], POINT].map(|size| light(body, 165.0, TIME, 9000.0, size, ""));
        let sunlit = light(body, 165.0, TIME, 9000.0, POINT, ",-planet-shine");
        println!("{body}: point / disc {}, in sunlight alone {}", point / disc, sunlit / disc);
        // The crescent's part of the map differs from the mean of the map: by up to 8 % in green without planet-shine.
        assert!((point.y / disc.y - 1.0).abs() < 0.15, "{body}: point {point}, disc {disc}");
        assert!(sunlit.y < most_sunlight * disc.y, "{body}: the comparison would not notice missing planet-shine: {sunlit}, {disc}");
    }
}

/// Elongated moons without a map: Amalthea, Thebe (Lommel-Seeliger), Telesto and Calypso (lunar-Lambert). With the phase function of a sphere, the point of
/// Amalthea had 0.48 of the light of its disc at 120 degrees, that of Calypso 1.7 times the light.
#[test]
fn elongated_moons_have_the_light_of_their_discs() {
    let moon_light = |body, phase_deg, size| light(body, phase_deg, TIME, 400.0, size, ",-planet-shine,-eclipse").y;
    for body in [505, 514, 613, 614] {
        for phase_deg in [60.0, 90.0, 120.0] {
            let [disc, point] = [DISC, POINT].map(|size| moon_light(body, phase_deg, size));
            println!("{body} at {phase_deg}: point / disc {:.3}", point / disc);
            // Calypso is 13 pixels wide: its disc lacks up to 4 % of the light of its crescent.
            assert!((point / disc - 1.0).abs() < 0.07, "{body} at {phase_deg}: point {point}, disc {disc}");
        }
    }
    // Negative control: a phase angle that is 15 degrees off, as that of Amalthea's long axis may be.
    let (disc, point) = (moon_light(505, 120.0, DISC), moon_light(505, 105.0, POINT));
    assert!((point / disc - 1.0).abs() > 0.2, "point {point}, disc {disc}");
}
