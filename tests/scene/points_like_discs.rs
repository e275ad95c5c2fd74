//! A body drawn as a point has the light and the colour of its disc: air in front of the Sun, rings and ring-shine, the eclipsed Moon, both sides of the full
//! Moon, planet-shine, elongated moons. The discs of Venus and Mars have the light of the published phase laws. The Earth, whose drawn ground is darker than
//! the published albedo, has a point of more light than its disc, within stated limits.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Position, Purpose, ViewRequest};
use orrery::session::Session;
use orrery::time::Instant;
use orrery::units::KM_PER_AU;

/// A side of a square image and a diameter of the body in it, in pixels: a disc with its air, and a point. The point's image is so narrow that no other body is
/// in it at the phase angles of the tests.
const DISC: [u32; 2] = [48, 36];
pub(super) const POINT: [u32; 2] = [8, 1];

/// Direction from a body to the Sun.
fn towards_sun(session: &Session, body: NaifId, time: Instant) -> DVec3 {
    session.ephemeris().state(NaifId::SUN, body, time, None).expect("a position").state.pos_km.normalize()
}

/// A view of a body alone.
pub(super) struct View<'a> {
    pub body: NaifId,
    pub phase_deg: f64,
    pub time: Instant,
    /// So large that the phase law holds in full.
    pub distance_radii: f64,
    /// A side of the square image and the diameter of the body in it, in pixels.
    pub size: [u32; 2],
    pub effects: &'a str,
    /// Normal of the plane in which Sun, body and viewer are.
    pub plane_normal: DVec3,
}

/// The normal of the ecliptic, roughly.
pub(super) const ECLIPTIC_NORMAL: DVec3 = DVec3::new(0.0, -0.4, 0.917);

/// What to do if point and disc differ, or the disc and the published law.
const REMEDY: &str =
    "after a change of this air ORRERY_RECORD_FORWARD_LIGHT=1 cargo test --test main forward_light; do not change the bound";

/// Light of a body times its distance squared, linear RGB.
fn light(body: i32, phase_deg: f64, time: &str, distance_radii: f64, size: [u32; 2], effects: &str) -> DVec3 {
    let (body, time) = (NaifId(body), Instant::parse(time).expect("a time"));
    light_in(&SESSION, &View { body, phase_deg, time, distance_radii, size, effects, plane_normal: ECLIPTIC_NORMAL })
}

/// As [`light`], in a session whose catalog may be another one.
pub(super) fn light_in(session: &Session, view: &View<'_>) -> DVec3 {
    let View { body, phase_deg, time, distance_radii, size: [side, diameter_px], effects, plane_normal } = *view;
    let towards_sun = towards_sun(session, body, time);
    let across = towards_sun.cross(plane_normal).normalize();
    let radius_km = session.catalog().body(body).expect("in the catalog").radii_km.x;
    let (sin, cos) = phase_deg.to_radians().sin_cos();
    let offset_km = (towards_sun * cos + across * sin) * (radius_km * distance_radii);
    let request = ViewRequest {
        position: Position::Offset { body, offset_km, axes: Axes::Icrf },
        fov_deg: Some((2.0 / distance_radii * f64::from(side) / f64::from(diameter_px)).to_degrees()),
        effects: EffectOverrides::parse(&format!("sun:-glow,sun:-corona{effects}")).expect("effects"),
        ..ViewRequest::of(body, time)
    };
    light_of(session, request, side)
}

/// The same of the Moon from the Earth's centre.
fn light_of_moon(time: &str, fov_deg: f64, effects: &str) -> DVec3 {
    let request = ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        fov_deg: Some(fov_deg),
        effects: EffectOverrides::parse(&format!("-planet-shine{effects}")).expect("effects"),
        ..ViewRequest::of(NaifId::MOON, Instant::parse(time).expect("a time"))
    };
    light_of(&SESSION, request, 64)
}

/// Light of the image, in a unit that does not depend on its field of view.
fn light_of(session: &Session, request: ViewRequest, side: u32) -> DVec3 {
    let (exposure, purpose, layers) = (ExposureRequest::Stops(0.0), Purpose::LINEAR, Layers::NONE);
    let request = ViewRequest { exposure, purpose, layers, width: side, height: side, ..request };
    let frame = session.draw(&request, SamplingQuality { samples: 4, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn").frame;
    let sum: DVec3 = frame.hdr.iter().map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).sum();
    sum * ((0.5 * request.fov_deg.expect("a field of view").to_radians()).tan() / f64::from(side)).powi(2)
}

/// The greatest difference of a channel between two lights, relative to the second.
fn difference(light: DVec3, reference: DVec3) -> f64 {
    (light / reference - 1.0).abs().to_array().into_iter().fold(0.0, larger)
}

pub(super) const TIME: &str = "2024-10-10T00:00:00Z";

/// A disc whose rim of air is lower than a pixel, but not by so much that its light would be wrong.
pub(super) const DISC_WITH_LOW_RIM: [u32; 2] = [96, 72];
/// A distance from which less than a hundredth of a rim that the Sun lights at a phase angle of 179 degrees is behind the limb.
const FAR_RADII: f64 = 4000.0;

/// The light of haze and dust (Titan, Mars, Pluto) and of rims that continue the disc. In green 12 % is allowed: Uranus has 8 % less light in its map's
/// crescent.
#[test]
fn a_backlit_body_with_air_has_the_light_of_its_disc() {
    // Rings reach beyond the image of the disc. At 179 degrees those of Jupiter have as much light as its rim.
    let without_rings = ",-rings,-ring-shine,-ring-shadow";
    for (body, distance_radii, size, phases_deg, effects) in [
        (606, 400.0, DISC, &[75.0, 90.0, 135.0, 150.0, 165.0, 175.0][..], ""),
        (499, 400.0, DISC_WITH_LOW_RIM, &[90.0, 100.0, 110.0, 120.0, 130.0, 140.0, 150.0, 165.0, 175.0][..], ""),
        (999, 400.0, DISC, &[165.0, 175.0][..], ""),
        (299, FAR_RADII, DISC_WITH_LOW_RIM, &[160.0, 170.0, 175.0, 178.0][..], ""),
        (599, FAR_RADII, DISC_WITH_LOW_RIM, &[160.0, 165.0, 179.0][..], without_rings),
        (699, FAR_RADII, DISC_WITH_LOW_RIM, &[165.0, 170.0, 178.0][..], without_rings),
        (799, FAR_RADII, DISC_WITH_LOW_RIM, &[162.0, 165.0, 170.0, 179.0][..], without_rings),
        (899, FAR_RADII, DISC_WITH_LOW_RIM, &[150.0, 165.0, 170.0, 178.0][..], without_rings),
    ] {
        for phase_deg in phases_deg {
            let effects = format!(",-planet-shine,-eclipse{effects}");
            let [disc, point] = [size, POINT].map(|size| light(body, *phase_deg, TIME, distance_radii, size, &effects));
            println!("{body} at {phase_deg}: point / disc {}", point / disc);
            // Of Pluto, and the blue of Titan, the catalog's colour of the ground differs from that of the map's crescent.
            assert!(difference(point, disc) < 0.15, "{body} at {phase_deg}: point {point}, disc {disc}; {REMEDY}");
            assert!((point.y / disc.y - 1.0).abs() < 0.12, "{body} at {phase_deg}: point {point}, disc {disc}; {REMEDY}");
        }
    }
    // Without the air, point and disc are faint, and the comparison would fail.
    for body in [606, 499] {
        let [disc, point] = [("", DISC), (",-atmosphere", POINT)].map(|(effects, size)| light(body, 150.0, TIME, 400.0, size, effects));
        assert!(point.y < 0.2 * disc.y, "{body}: {point}, {disc}");
    }
}

/// The Earth at all phases, in the mean over a rotation. The point follows the published law.
/// The drawn ground and clouds have 0.36 of its geometric albedo (whole discs measured by DSCOVR with their air: 0.5), so that the disc has less light, 0.37 of
/// it where the ground has most of the light. The disc once had up to 50 times the light of the point, at phase angles of 150 degrees and more.
#[test]
fn the_earth_has_the_light_of_its_disc_within_the_stated_limits() {
    // A quarter of a rotation apart.
    const TIMES: [&str; 4] = [TIME, "2024-10-10T06:00:00Z", "2024-10-10T12:00:00Z", "2024-10-10T18:00:00Z"];
    let mean = |phase_deg: f64, size: [u32; 2], effects: &str| -> DVec3 {
        let effects = format!(",-planet-shine,-eclipse{effects}");
        let sum: DVec3 = TIMES.iter().map(|time| light(399, phase_deg, time, 400.0, size, &effects)).sum();
        sum / TIMES.len() as f64
    };
    let (mut ratios, mut failures) = (Vec::new(), Vec::new());
    // Measured: 2.45 2.61 2.49 2.03 1.71 1.45 1.19 1.15 1.16 1.32 1.16 1.07 1.01.
    for (phase_deg, least, most) in [
        (5.0, 2.2, 2.8),
        (60.0, 2.2, 2.9),
        (90.0, 2.2, 2.8),
        (110.0, 1.8, 2.3),
        (120.0, 1.5, 1.95),
        (135.0, 1.25, 1.65),
        (145.0, 1.0, 1.4),
        (155.0, 0.95, 1.35),
        (165.0, 0.95, 1.35),
        (170.0, 1.05, 1.5),
        (174.0, 0.95, 1.35),
        (176.0, 0.9, 1.2),
        (178.0, 0.9, 1.12),
    ] {
        let [disc, point] = [DISC_WITH_LOW_RIM, POINT].map(|size| mean(phase_deg, size, ""));
        let ratio = point.y / disc.y;
        println!("Earth at {phase_deg}: point / disc {ratio:.3}");
        ratios.push(format!("{ratio:.2}"));
        if !(least..most).contains(&ratio) {
            failures.push(format!("at {phase_deg}: {ratio:.3}, not from {least} to {most}: point {point}, disc {disc}"));
        }
    }
    let (failures, ratios) = (failures.join("\n"), ratios.join(" "));
    assert!(
        failures.is_empty(),
        "{failures}\nafter a change of the Earth's air or clouds record forward_light; if that is done: the point follows the law, so \
         these ratios go to the comment and to docs/accuracy.md, and the bounds are a tenth to a fifth beyond: {ratios}"
    );
    // Without air the point keeps the light of both, because most of it is that of the glint, which the disc has without air, too. Measured: 0.73; without this
    // light 0.17.
    let [disc, point] = [DISC_WITH_LOW_RIM, POINT].map(|size| mean(165.0, size, ",-atmosphere"));
    println!("without air: point / disc {}", point / disc);
    assert!(point.y > 0.5 * disc.y && point.y < 2.0 * disc.y, "without air: point {point}, disc {disc}");
    // Negative control: without air and glint the point has a twentieth of the light of the disc.
    let (disc, point) = (mean(178.0, DISC_WITH_LOW_RIM, ""), mean(178.0, POINT, ",-atmosphere,-specular"));
    assert!(point.y < 0.2 * disc.y, "point {point}, disc {disc}");
}

/// Light of a disc in units of that of a white Lambert disc under full sunlight: geometric albedo times phase function. Luminance.
fn mean_radiance(body: i32, phase_deg: f64, effects: &str) -> f64 {
    let distance_radii = 400.0;
    let light = light(body, phase_deg, TIME, distance_radii, DISC_WITH_LOW_RIM, &format!(",-planet-shine,-eclipse{effects}"));
    let time = Instant::parse(TIME).expect("a time");
    let sun_km = SESSION.ephemeris().state(NaifId::SUN, NaifId(body), time, None).expect("a position").state.pos_km.length();
    // A pixel is twice the tangent of half the field of view wide, divided by the number of pixels.
    let of_disc = 4.0 * orrery::units::luminance(light.to_array()) * distance_radii.powi(2) / std::f64::consts::PI;
    of_disc * (sun_km / KM_PER_AU).powi(2)
}

/// Drawn discs of Venus and Mars with their air against Mallama and Hilton 2018: magnitude by phase angle, relative to zero phase, of a disc of the catalog's
/// geometric albedo. At 120 degrees, where the law of Mars ends, its dust may have all the light of the law, and the ground still has a quarter of it: so there
/// 30 % more light is allowed.
#[test]
fn discs_with_air_have_the_light_of_the_published_law() {
    let venus = |a: f64| 236.05828 - 2.81914 * a + 8.39034e-3 * a * a + 4.384;
    let mars = |a: f64| -0.367 - 2.573e-2 * a + 3.445e-4 * a * a + 1.601;
    let published = |albedo: f64, magnitude: f64| albedo * 10_f64.powf(-0.4 * magnitude);
    let mut without_air = Vec::new();
    for (body, phase_deg, expected, max_excess) in [
        (299, 165.0, published(0.689, venus(165.0)), 0.12),
        (299, 172.0, published(0.689, venus(172.0)), 0.12),
        (299, 177.0, published(0.689, venus(177.0)), 0.12),
        (499, 100.0, published(0.17, mars(100.0)), 0.12),
        (499, 110.0, published(0.17, mars(110.0)), 0.12),
        (499, 120.0, published(0.17, mars(120.0)), 0.3),
    ] {
        let found = mean_radiance(body, phase_deg, "");
        println!("{body} at {phase_deg}: {found:.5}, published {expected:.5}");
        assert!((-0.12..max_excess).contains(&(found / expected - 1.0)), "{body} at {phase_deg}: {found}, not {expected}; {REMEDY}");
        without_air.push(mean_radiance(body, phase_deg, ",-atmosphere") / expected);
    }
    // Negative control: without their air both would be too faint for the law, Venus at its largest phase angle by more than three fifths, Mars at one of
    // its phase angles at least: at which of them depends on the light that its dust scatters there.
    assert!(without_air[2] < 0.35 && without_air[3..].iter().any(|part| *part < 0.88), "{without_air:?}");
}

/// With the Sun behind them, nearly all light of Saturn and Uranus is that of the grey dust of their rings, not of the globes' colours.
#[test]
fn rings_of_a_point_have_their_own_colour() {
    for (body, size) in [(699, [144, 36]), (799, [144, 36])] {
        let [disc, point] = [size, POINT].map(|size| light(body, 178.0, TIME, 400.0, size, ",-planet-shine,-eclipse"));
        println!("{body}: point / disc {}", point / disc);
        assert!(difference(point, disc) < 0.15, "{body}: point {point}, disc {disc}");
        // Negative control: the globe's colour.
        let colour = SESSION.catalog().body(NaifId(body)).expect("in the catalog").colour.as_dvec3();
        assert!(difference(colour * (disc.y / colour.y), disc) > 0.15, "{body}: colour {colour}, disc {disc}");
    }
}

/// Saturn with open rings from their unlit side: up to half of its light is ring-shine on the globe's night side, which was missing in the point and in the
/// magnitude.
#[test]
fn saturn_has_its_ring_shine_as_a_point() {
    // The Sun is 27 degrees north of the rings.
    let time = "2017-06-01T00:00:00Z";
    let pole = DVec3::new(0.0857, 0.0735, 0.9936);
    // The place is southwards of the direction away from the Sun, as far as the phase angle allows.
    let (body, time) = (NaifId(699), Instant::parse(time).expect("a time"));
    let plane_normal = towards_sun(&SESSION, body, time).cross(pole);
    let saturn = |phase_deg: f64, size: [u32; 2], effects: &str| {
        let effects = &format!(",-planet-shine,-eclipse{effects}");
        light_in(&SESSION, &View { body, phase_deg, time, distance_radii: 400.0, size, effects, plane_normal })
    };
    for phase_deg in [75.0, 100.0, 130.0, 150.0, 160.0, 165.0, 170.0, 174.0] {
        let [disc, point] = [[144, 36], POINT].map(|size| saturn(phase_deg, size, ""));
        println!("Saturn at {phase_deg}: point / disc {}", point / disc);
        // Measured: 0.98 to 1.09. The ring-shine of the point is up to 7 % fainter than that of the disc, whose map is brighter there.
        assert!(difference(point, disc) < 0.12, "at {phase_deg}: point {point}, disc {disc}");
    }
    // Negative control: without it the point has 0.6 of the light.
    let (disc, point) = (saturn(165.0, [144, 36], ""), saturn(165.0, POINT, ",-ring-shine"));
    assert!(point.y < 0.7 * disc.y, "point {point}, disc {disc}");
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
