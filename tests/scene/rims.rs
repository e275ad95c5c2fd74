//! Bodies with air in front of the Sun, seen from afar: automatic exposure shows the ring of air around them, and the light meter's estimate of its radiance is
//! that of the drawn ring.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::AUTO_EXPOSED_MEAN;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Look, Position, Purpose, ViewRequest};
use orrery::time::Instant;

const TIME: &str = "2024-04-08T18:17:16Z";
const SIDE: u32 = 96;

/// A view of a body at a phase angle, from a distance in its radii, whose disc fills about half of the image.
fn view(body: NaifId, phase_deg: f64, distance_radii: f64) -> ViewRequest {
    view_at(TIME, body, phase_deg, distance_radii)
}

fn view_at(time: &str, body: NaifId, phase_deg: f64, distance_radii: f64) -> ViewRequest {
    let time = Instant::parse(time).expect("a time");
    let towards_sun = SESSION.ephemeris().state(NaifId::SUN, body, time, None).expect("a position").state.pos_km.normalize();
    let across = towards_sun.cross(DVec3::Z).normalize();
    let radius_km = SESSION.catalog().body(body).expect("in the catalog").radii_km.x;
    let (sin, cos) = phase_deg.to_radians().sin_cos();
    let offset_km = (towards_sun * cos + across * sin) * (radius_km * distance_radii);
    ViewRequest {
        position: Position::Offset { body, offset_km, axes: Axes::Icrf },
        fov_deg: Some(2.0 * (2.0 / distance_radii).atan().to_degrees()),
        width: SIDE,
        height: SIDE,
        ..ViewRequest::of(body, time)
    }
}

/// Fractions of the image's pixels that are white, and that are at least a third of the way to white; and the geometric mean of radiance, weighted as by the
/// light meter (2/3 power).
fn white_lit_and_mean(request: &ViewRequest) -> (f64, f64, f64) {
    let frame = SESSION.draw(request, SamplingQuality { samples: 4, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn").frame;
    let fraction =
        |level: u8| frame.display.iter().filter(|p| p[..3].iter().any(|v| *v >= level)).count() as f64 / frame.display.len() as f64;
    let (mut weights, mut sum) = (0.0, 0.0);
    for radiance in frame.hdr.iter().map(|p| f64::from(p[0].max(p[1]).max(p[2]))).filter(|radiance| *radiance > 0.0) {
        let weight = radiance.powf(2.0 / 3.0);
        weights += weight;
        sum += weight * radiance.ln();
    }
    (fraction(254), fraction(85), (sum / weights).exp())
}

/// Titan, Pluto, Mars and the Earth from 20 radii, with the Sun behind them: the ring is neither white all over nor black, the meter finds the radiance of the
/// drawn image within a factor of 3 (of 8.5 for the Earth, whose ring is lower than a pixel), and the exposure changes gradually. Without the air the exposure is
/// that of the night side.
#[test]
fn the_ring_of_air_around_a_backlit_body_is_exposed() {
    for (body, phases_deg, factor) in [(606, 178..=180, 3.0), (999, 178..=180, 3.0), (499, 179..=180, 3.0), (399, 179..=180, 8.5)] {
        let body = NaifId(body);
        let mut stops = Vec::new();
        for phase_deg in phases_deg {
            let request = view(body, f64::from(phase_deg), 20.0);
            let metered = SESSION.scene(&request).expect("a scene").exposure.stops;
            let (white, lit, mean) = white_lit_and_mean(&request);
            let ratio = AUTO_EXPOSED_MEAN / metered.exp2() / mean;
            println!("{body:?} {phase_deg}: {metered:.2} stops, {white:.3} white, {lit:.3} lit; metered {ratio:.2} of what is drawn");
            assert!(white < 0.03 && lit > 0.002, "{body:?} at {phase_deg} degrees: {white} white, {lit} lit");
            assert!((1.0 / factor..factor).contains(&ratio), "{body:?} at {phase_deg} degrees: {ratio}");
            stops.push(metered);
        }
        assert!(stops.windows(2).all(|w| (w[1] - w[0]).abs() < 1.0), "{body:?}: {stops:?}");
        let without_air = ViewRequest { effects: EffectOverrides::parse("-atmosphere").expect("an effect"), ..view(body, 180.0, 20.0) };
        let without_air = SESSION.scene(&without_air).expect("a scene").exposure.stops;
        assert!(without_air > stops[0] + 5.0, "{body:?}: {without_air} stops without air, {stops:?}");
    }
}

/// A body with air in front of the Sun becomes smaller, from a disc of 7 pixels to a point of 1.4: with or without a target, the exposure does not jump. While
/// the ring of air counted on discs of more than 4 pixels alone, there were steps of 4 to 14 stops, and Mars that was not the target was not metered from 4 to
/// 2 pixels.
#[test]
fn the_exposure_is_continuous_where_a_backlit_disc_becomes_a_point() {
    let diameters_px: Vec<f64> = (0..=81).map(|k| 7.0 * 0.98_f64.powi(k)).collect();
    // The greatest change from the largest disc to any smaller one. The Earth's was 11 stops at 178.5 degrees, while its point had a fiftieth of the light of
    // its disc.
    for (body, phase_deg, has_target, most_stops) in [
        (499, 175.0, true, 3.5),
        (499, 178.0, false, 3.5),
        (606, 175.0, true, 3.5),
        (299, 177.0, true, 6.0),
        (399, 165.0, true, 5.0),
        (399, 178.5, true, 5.0),
        (399, 178.5, false, 7.0),
    ] {
        let stops: Vec<f64> = diameters_px
            .iter()
            .map(|diameter_px| {
                // A narrow field of view, so that the Sun is beside it.
                let fov_deg = 1.0_f64;
                let distance_radii = 2.0 * f64::from(SIDE) / diameter_px / fov_deg.to_radians();
                let request = view_at("2024-10-10T00:00:00Z", NaifId(body), phase_deg, distance_radii);
                let Position::Offset { offset_km, axes, .. } = request.position else { panic!("an offset") };
                let request = ViewRequest { fov_deg: Some(fov_deg), ..request };
                let look = Look::Along { direction: -offset_km, axes };
                let request = if has_target { request } else { ViewRequest { target: None, look, ..request } };
                SESSION.scene(&request).expect("a scene").exposure.stops
            })
            .collect();
        let greatest_step = stops.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, larger);
        let greatest_change = stops.iter().map(|s| (s - stops[0]).abs()).fold(0.0, larger);
        println!("{body} at {phase_deg}: {:.2} to {:.2} stops, steps of {greatest_step:.2}", stops[0], stops[stops.len() - 1]);
        assert!(greatest_step < 1.0 && greatest_change < most_stops, "{body} at {phase_deg} degrees: {stops:.2?}");
    }
}

/// The Earth shrinks, from 20 pixels to 3, where its air shows the Sun that a straight line misses: refracted light, which a point does not have, fades with
/// the disc. While it ended at 4 pixels, the light fell there to a 75th, and the exposure by 10 stops.
#[test]
fn the_light_and_the_exposure_of_a_refracted_sun_fade_with_the_disc() {
    let seen = |diameter_px: f64, effects: &str| {
        let fov_deg = 0.1_f64;
        let distance_radii = 2.0 * f64::from(SIDE) / diameter_px / fov_deg.to_radians();
        let effects = EffectOverrides::parse(effects).expect("effects");
        ViewRequest { fov_deg: Some(fov_deg), effects, ..view_at("2024-10-10T00:00:00Z", NaifId(399), 179.4, distance_radii) }
    };
    let stops = |request: &ViewRequest| SESSION.scene(request).expect("a scene").exposure.stops;
    let series: Vec<f64> = (0..=95).map(|k| stops(&seen(20.0 * 0.98_f64.powi(k), ""))).collect();
    let greatest_step = series.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, larger);
    println!("{:.2} to {:.2} stops, steps of {greatest_step:.2}", series[0], series[series.len() - 1]);
    assert!(greatest_step < 1.0, "{series:.2?}");
    let without = stops(&seen(20.0, "-refracted-limb"));
    assert!(without > series[0] + 6.0, "{without} stops without the refracted Sun, {} with it: the check above cannot fail", series[0]);
    let light = |diameter_px: f64| {
        let quality = SamplingQuality { samples: 4, anisotropy: 4 };
        let request =
            ViewRequest { exposure: ExposureRequest::Stops(0.0), purpose: Purpose::LINEAR, ..seen(diameter_px, "sun:-glow,sun:-corona") };
        let hdr = SESSION.draw(&request, quality, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr;
        hdr.iter().map(|p| f64::from(p[1])).sum::<f64>()
    };
    // A disc of 4 pixels is up to 1.5 times as bright as its point: the glint, and rays through the air at the limb.
    let (at_8, above_4, below_4) = (light(8.0), light(4.02), light(3.98));
    println!("light at 8, 4.02 and 3.98 pixels: {at_8:.3e}, {above_4:.3e}, {below_4:.3e}");
    assert!(above_4 < 2.0 * below_4 && below_4 < 2.0 * above_4, "{above_4} to {below_4}");
    assert!(at_8 > 10.0 * below_4, "{at_8} to {below_4}: the check above cannot fail");
}

/// Venus in front of the Sun hides the corona up to eight solar radii: the image is exposed for the corona around it, which is not white all over.
#[test]
fn the_corona_around_a_body_that_hides_its_inner_part_is_exposed() {
    for phase_deg in [179.0, 180.0] {
        let request = view(NaifId(299), phase_deg, 20.0);
        let (white, lit, _) = white_lit_and_mean(&request);
        println!("{phase_deg}: {:.2} stops, {white:.3} white, {lit:.3} lit", SESSION.scene(&request).expect("a scene").exposure.stops);
        assert!(white < 0.05 && lit > 0.05, "{phase_deg} degrees: {white} white, {lit} lit");
    }
    // Straight behind Venus the exposure is that of the corona; without it, of the dark sky.
    let stops = |effects: &str| {
        let effects = EffectOverrides::parse(effects).expect("an effect");
        SESSION.scene(&ViewRequest { effects, ..view(NaifId(299), 180.0, 20.0) }).expect("a scene").exposure.stops
    };
    // `+ellipsoid` changes nothing: a body with air has it anyway.
    let [with, without] = ["+ellipsoid", "-corona"].map(stops);
    assert!(without > with + 1.0, "{with} and {without} stops");
}

/// Titan in Saturn's umbra has no ring of light.
#[test]
fn the_ring_of_an_eclipsed_body_is_not_metered() {
    let request = view_at("2025-08-11T06:00:00Z", NaifId(606), 130.0, 20.0);
    let stops = |effects: &str| {
        let effects = EffectOverrides::parse(effects).expect("an effect");
        SESSION.scene(&ViewRequest { effects, ..request.clone() }).expect("a scene").exposure.stops
    };
    // `+ellipsoid` changes nothing: a body with air has it anyway.
    let [eclipsed, without_eclipse] = ["+ellipsoid", "-eclipse"].map(stops);
    assert!(eclipsed > 15.0 && without_eclipse < 10.0, "{eclipsed} and {without_eclipse} stops");
}

/// A camera behind the Earth turns away from the Sun that the Earth hides: while the Earth leaves the frame, the corona beside it counts as before.
#[test]
fn the_exposure_is_continuous_when_the_body_before_the_sun_leaves_the_frame() {
    let behind = view(NaifId::EARTH, 180.0, 40.0);
    let Position::Offset { offset_km, .. } = behind.position else { panic!("an offset") };
    let (towards, across) = (-offset_km.normalize(), offset_km.cross(DVec3::Z).normalize());
    let stops = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let look = Look::Along { direction: towards * cos + across * sin, axes: Axes::Icrf };
        SESSION.scene(&ViewRequest { look, fov_deg: Some(2.0), ..behind.clone() }).expect("a scene").exposure.stops
    };
    let all: Vec<f64> = (40..=60).map(|k| stops(0.1 * f64::from(k))).collect();
    assert!(all.windows(2).all(|w| (w[1] - w[0]).abs() < 0.4), "{all:?}");
}
