//! The highlights of bodies at automatic exposure: hardly any of a drawn disc is burnt out, at any phase and distance, alone or before a brighter body; and
//! small bright parts do not darken the rest.

use crate::support::session::SESSION;
use crate::support::sweep;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::request::{Axes, ExposureRequest, Position, ViewRequest};
use orrery::time::Instant;

const SIDE: u32 = 96;
const TIME: &str = "2019-06-20T00:00:00Z";
const PHOBOS: NaifId = NaifId(401);
const MARS: NaifId = NaifId(499);
const SATURN: NaifId = NaifId(699);
/// Channels from this level on count as burnt out, pixels with a channel from the other on as part of the subject.
const BURNT: u8 = 245;
const VISIBLE: u8 = 24;

fn view(target: NaifId, time: &str, position: Position, fov_deg: f64) -> ViewRequest {
    let time = Instant::parse(time).expect("a time");
    ViewRequest { position, fov_deg: Some(fov_deg), width: SIDE, height: SIDE, ..ViewRequest::of(target, time) }
}

/// Of the visible pixels, the fraction that is burnt out and the mean level of the brightest channel; and the exposure.
fn burnt_fraction(request: &ViewRequest) -> (f64, f64, orrery::scene::Exposure) {
    let drawn = SESSION.draw(request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::Display).expect("drawn");
    let brightest = drawn.frame.display.iter().map(|p| p[0].max(p[1]).max(p[2]));
    let visible: Vec<u8> = brightest.filter(|level| *level >= VISIBLE).collect();
    assert!(visible.len() > 60, "hardly any subject: {}", drawn.scene.exposure.reason);
    let burnt = visible.iter().filter(|level| **level >= BURNT).count();
    let mean = visible.iter().map(|level| f64::from(*level)).sum::<f64>() / visible.len() as f64;
    (burnt as f64 / visible.len() as f64, mean, drawn.scene.exposure)
}

/// A body at a phase angle, which fills three quarters of the frame's height.
fn at_phase(id: NaifId, phase_deg: f64, distance_radii: f64) -> ViewRequest {
    let time = Instant::parse(TIME).expect("a time");
    let to_sun = SESSION.ephemeris().state(NaifId::SUN, id, time, None).expect("placed").state.pos_km.normalize();
    let across = DVec3::Z.cross(to_sun).normalize();
    let (sin, cos) = phase_deg.to_radians().sin_cos();
    let radius_km = SESSION.catalog().body(id).expect("a body").radii_km.max_element();
    let position = Position::Offset { body: id, offset_km: (to_sun * cos + across * sin) * (distance_radii * radius_km), axes: Axes::Icrf };
    view(id, TIME, position, 2.7 * distance_radii.recip().asin().to_degrees())
}

/// At phase angles of either sign, from near and from afar, at most 8 % of the visible part of a body is burnt out, and it is not dark. Negative control: with
/// the exposure for the mean alone, that of a crescent half a stop longer, some are.
#[test]
fn hardly_any_of_a_disc_is_burnt_out() {
    let ids = [301, 199, 299, 499, 599, 699, 799, 899, 999, 501, 502, 503, 606, 801, 901].map(NaifId);
    let (mut tested, mut burnt_if_brighter) = (0, 0);
    for (_, id) in ids.into_iter().enumerate().filter(|(k, id)| *id == NaifId::MOON || sweep::runs(*k, 4)) {
        for (phase_deg, distance_radii) in
            [(15.0, 60.0), (60.0, 60.0), (-60.0, 12.0), (90.0, 60.0), (-90.0, 4.0), (120.0, 60.0), (150.0, 60.0)]
        {
            // The Moon from both sides. At large phase angles the air of others outshines the ground.
            if phase_deg > 130.0 && id != NaifId::MOON {
                continue;
            }
            let request = at_phase(id, phase_deg, distance_radii);
            let (burnt, mean, exposure) = burnt_fraction(&request);
            println!("{id:?} at {phase_deg} degrees, {distance_radii} radii: {burnt:.3}, mean level {mean:.0}; {}", exposure.reason);
            assert!(burnt <= 0.08, "{id:?} at {phase_deg} degrees, {distance_radii} radii: {burnt} burnt out; {}", exposure.reason);
            assert!(mean > 70.0, "{id:?} at {phase_deg} degrees, {distance_radii} radii: level {mean}; {}", exposure.reason);
            let brighter = ViewRequest { exposure: ExposureRequest::Stops(exposure.stops + 0.6), ..request };
            burnt_if_brighter += u32::from(burnt_fraction(&brighter).0 > 0.08);
            tested += 1;
        }
    }
    assert!(tested >= 7 && burnt_if_brighter >= 2, "{burnt_if_brighter} of {tested}");
}

/// The full Moon is bright: its mean level is above 170 of 255 (0.4 of white).
#[test]
fn the_full_moon_is_not_grey() {
    let (burnt, mean, exposure) = burnt_fraction(&at_phase(NaifId::MOON, 4.0, 60.0));
    assert!(mean > 170.0 && burnt < 0.08, "level {mean}, {burnt} burnt out; {}", exposure.reason);
}

/// The Moon in the penumbra, partly and entirely in the umbra, seen from the Earth: at most 8 % burnt out, also of the red light in the umbra.
#[test]
fn an_eclipsed_moon_is_not_burnt_out() {
    for time in ["2022-11-08T08:50:00Z", "2022-11-08T09:40:00Z", "2022-11-08T10:40:00Z", "2022-11-08T10:59:00Z", "2022-11-08T11:30:00Z"] {
        let (burnt, mean, exposure) = burnt_fraction(&view(NaifId::MOON, time, Position::Centre(NaifId::EARTH), 0.7));
        println!("{time}: {burnt:.3}, mean level {mean:.0}; {}", exposure.reason);
        assert!(burnt <= 0.08 && mean > 60.0, "{time}: {burnt} burnt out, level {mean}; {}", exposure.reason);
    }
}

/// Phobos, dark, in front of Mars, twice as bright and larger: the exposure protects Mars, though Phobos is the target. The reason says so.
#[test]
fn a_brighter_body_behind_the_target_is_protected() {
    let time = Instant::parse("2025-03-01T06:00:00Z").expect("a time");
    let from_mars = SESSION.ephemeris().state(MARS, PHOBOS, time, None).expect("placed").state.pos_km.normalize();
    let radius_km = SESSION.catalog().body(PHOBOS).expect("Phobos").radii_km.x;
    let position = Position::Offset { body: PHOBOS, offset_km: from_mars * (-8.0 * radius_km), axes: Axes::Icrf };
    let request = view(PHOBOS, "2025-03-01T06:00:00Z", position, 60.0);
    let (burnt, _, exposure) = burnt_fraction(&request);
    let (burnt_before, ..) = burnt_fraction(&ViewRequest { exposure: ExposureRequest::Stops(4.02), ..request });
    assert!(burnt < 0.08 && burnt_before > 0.2, "{burnt}, {burnt_before} at +4.02 stops; {}", exposure.reason);
    assert!(exposure.reason.to_string().contains("limited by the highlights: -"), "{}", exposure.reason);
}

/// A crescent with its rings (Saturn), and the same from behind.
#[test]
fn rings_are_not_burnt_out() {
    for phase_deg in [30.0, 60.0, 100.0, 130.0] {
        let (burnt, _, exposure) = burnt_fraction(&at_phase(SATURN, phase_deg, 12.0));
        assert!(burnt <= 0.08, "{phase_deg} degrees: {burnt} burnt out; {}", exposure.reason);
    }
}
