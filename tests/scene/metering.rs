//! The light meter over distances, phases, fields of view and eclipses: no image is all white or all black, exposure never jumps, and it
//! never exceeds that of a night photograph.

use crate::support::session::SESSION;
use crate::support::sweep;
use glam::{DMat3, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Look, Position, ViewRequest};
use orrery::scene::{Scene, corona, darkest_white};
use orrery::time::Instant;

const SIDE: u32 = 96;
const PHOBOS: NaifId = NaifId(401);
const VENUS: NaifId = NaifId(299);
const MARS: NaifId = NaifId(499);
const JUPITER: NaifId = NaifId(599);
const IO: NaifId = NaifId(501);
const SATURN: NaifId = NaifId(699);
const NEPTUNE: NaifId = NaifId(899);
const PLUTO: NaifId = NaifId(999);

/// The height of a standing observer's eyes.
const EYE_HEIGHT_KM: f64 = 0.0017;

fn parse_time(time: &str) -> Instant {
    Instant::parse(time).expect("a time")
}

fn view(target: NaifId, time: &str, position: Position, fov_deg: Option<f64>) -> ViewRequest {
    ViewRequest { position, fov_deg, width: SIDE, height: SIDE, ..ViewRequest::of(target, parse_time(time)) }
}

/// Above the side of the target that faces the body `towards`. `None`: the Earth or, if the target is the Earth, the Sun.
fn above_target(towards: Option<NaifId>, distance_radii: f64) -> Position {
    Position::AboveTarget { towards, distance_radii: Some(distance_radii) }
}

fn ground(body: NaifId, latitude_deg: f64, longitude_deg: f64) -> Position {
    Position::Ground { body, latitude_deg, longitude_deg, height_km: EYE_HEIGHT_KM }
}

fn scene(request: &ViewRequest) -> Scene {
    SESSION.scene(request).expect("a scene")
}

fn exposure_stops(request: &ViewRequest) -> f64 {
    scene(request).exposure.stops
}

/// How bright an image is displayed. A white pixel is above 235 of 255 in every channel, a visible pixel above 20 in some channel.
#[derive(Debug)]
struct DisplayedLight {
    white_fraction: f64,
    visible_fraction: f64,
    /// The greatest value of any channel, of 255.
    brightest_level: u8,
}

fn displayed_light(request: &ViewRequest) -> DisplayedLight {
    let frame = SESSION.draw(request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn").frame;
    assert!(frame.hdr.iter().flatten().all(|v| v.is_finite()), "{:?}", request.exposure);
    let fraction =
        |is_counted: &dyn Fn(&[u8; 4]) -> bool| frame.display.iter().filter(|p| is_counted(p)).count() as f64 / frame.display.len() as f64;
    DisplayedLight {
        white_fraction: fraction(&|p| p[..3].iter().all(|v| *v > 235)),
        visible_fraction: fraction(&|p| p[..3].iter().any(|v| *v > 20)),
        brightest_level: frame.display.iter().flat_map(|p| &p[..3]).copied().max().unwrap_or(0),
    }
}

/// A view and the limits of its [`DisplayedLight`].
struct Case {
    name: &'static str,
    request: ViewRequest,
    white_at_most: f64,
    visible_at_least: f64,
    /// Negative control: the exposure for the target alone, which must exceed a limit. `None`: it exceeds none in an image of [`SIDE`] pixels.
    target_only_stops: Option<f64>,
}

fn cases() -> Vec<Case> {
    let case = |name, request, [white_at_most, visible_at_least]: [f64; 2], target_only_stops| Case {
        name,
        request,
        white_at_most,
        visible_at_least,
        target_only_stops,
    };
    let from_earth = Position::Centre(NaifId::EARTH);
    let above_city = Position::Ground { body: NaifId::EARTH, latitude_deg: 48.85, longitude_deg: 2.35, height_km: 60.0 };
    let in_orbit = Position::Ground { body: NaifId::EARTH, latitude_deg: 0.0, longitude_deg: 0.0, height_km: 420.0 };
    let sunlit_saturn = view(SATURN, "2013-07-19T21:27:00Z", above_target(Some(NaifId::SUN), 20.0), Some(45.0));
    // Seen from the sunlit side, the direction to Saturn is that away from the Sun. An offset in this direction puts the camera behind Saturn.
    let offset_km = scene(&sunlit_saturn).body(SATURN).expect("Saturn").placement.centre_km;
    let backlit_saturn =
        ViewRequest { position: Position::Offset { body: SATURN, offset_km, axes: Axes::Icrf }, fov_deg: Some(22.0), ..sunlit_saturn };
    vec![
        case("the new Moon beside the Sun", view(NaifId::MOON, "2024-04-08T18:17:16Z", from_earth, None), [0.3, 0.05], Some(5.25)),
        case("night above a city", view(NaifId::EARTH, "2024-12-25T20:00:00Z", above_city, None), [0.1, 0.5], None),
        case(
            "Phobos in front of the Sun",
            view(NaifId::SUN, "2013-08-20T07:11:29Z", ground(MARS, -4.59, 137.44), Some(0.6)),
            [0.5, 0.1],
            Some(2.1),
        ),
        case(
            "the Sun in an annular eclipse",
            view(NaifId::SUN, "2023-10-14T16:37:00Z", ground(NaifId::EARTH, 35.08, -106.65), Some(1.0)),
            [0.2, 0.03],
            Some(1.0),
        ),
        case("Saturn and its rings against the light", backlit_saturn, [0.1, 0.02], None),
        case("a crescent Moon", view(NaifId::MOON, "2024-04-10T18:21:00Z", from_earth, None), [0.05, 0.01], None),
        case("the Moon in the umbra", view(NaifId::MOON, "2022-11-08T11:00:00Z", from_earth, None), [0.1, 0.3], None),
        case("Venus in front of the Sun", view(NaifId::SUN, "2012-06-06T01:30:00Z", from_earth, Some(0.7)), [0.7, 0.3], None),
        case(
            "sunlight in the Earth's air around its night side",
            view(NaifId::EARTH, "2022-11-08T10:59:00Z", ground(NaifId::MOON, 0.0, 0.0), Some(3.0)),
            [0.01, 0.005],
            Some(15.0),
        ),
        case(
            "the setting Sun",
            view(NaifId::SUN, "2024-06-21T19:05:00Z", ground(NaifId::EARTH, 45.0, 10.0), Some(60.0)),
            [0.3, 0.3],
            Some(-9.33),
        ),
        case("twilight from orbit", view(NaifId::EARTH, "2024-03-20T18:24:00Z", in_orbit, Some(45.0)), [0.05, 0.5], None),
        case("the lit Earth", view(NaifId::EARTH, "2024-04-08T18:17:16Z", above_target(None, 3.0), None), [0.2, 0.3], Some(12.0)),
    ]
}

/// Whether the image is too bright or too dark. Some part of every image must be fairly bright: 100 of 255.
fn exceeds_limits(case: &Case, light: &DisplayedLight) -> bool {
    light.white_fraction > case.white_at_most || light.visible_fraction < case.visible_at_least || light.brightest_level < 100
}

#[test]
fn no_view_is_all_white_or_all_black() {
    let mut failures = Vec::new();
    for case in cases() {
        let exposure = scene(&case.request).exposure;
        let found = displayed_light(&case.request);
        println!("{}: {:+.2} stops, {found:?}; {}", case.name, exposure.stops, exposure.reason);
        if exceeds_limits(&case, &found) {
            failures.push(format!("{}: {found:?}", case.name));
        }
        if let Some(stops) = case.target_only_stops {
            let found = displayed_light(&ViewRequest { exposure: ExposureRequest::Stops(stops), ..case.request.clone() });
            assert!(exceeds_limits(&case, &found), "{} is within its limits at {stops} stops too: {found:?}", case.name);
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// A planet from beyond 1 au is a point in a dark sky: it is metered, most of the image is dark, and the point is bright. The same holds for Phobos
/// from 0.09 au, in an image so narrow that Mars is outside.
#[test]
fn a_far_planet_is_a_point_in_a_dark_sky() {
    // The Sun is far outside these images, and so is its glare.
    let in_wide_image = [(NaifId::EARTH, JUPITER, 30_000.0), (NaifId::EARTH, JUPITER, 60_000.0), (JUPITER, SATURN, 20_000.0)];
    let wide_fov_deg = 20.0;
    let of_planets = in_wide_image.map(|(target, towards, distance_radii)| (target, towards, distance_radii, wide_fov_deg));
    for (target, towards, distance_radii, fov_deg) in of_planets.into_iter().chain([(PHOBOS, NaifId::SUN, 1e6, 0.02)]) {
        let request = view(target, "2024-10-08T18:17:16Z", above_target(Some(towards), distance_radii), Some(fov_deg));
        let (found, exposure) = (displayed_light(&request), scene(&request).exposure);
        let name = &SESSION.catalog().body(target).expect("a body").name;
        let reason = exposure.reason.to_string();
        assert!(reason.starts_with(name.as_str()), "{name} from {distance_radii} radii: {reason}");
        assert!(found.visible_fraction < 0.5 && found.brightest_level > 60, "{name} from {distance_radii} radii: {found:?}, {reason}");
        // Negative controls: six stops more show the sky where the image is wide; ten stops less do not show the point.
        let at = |stops: f64| displayed_light(&ViewRequest { exposure: ExposureRequest::Stops(exposure.stops + stops), ..request.clone() });
        let (brighter, darker) = (at(6.0), at(-10.0));
        assert_eq!(brighter.visible_fraction > 0.5, fov_deg == wide_fov_deg, "{name} from {distance_radii} radii: {brighter:?}");
        assert!(darker.brightest_level < 60, "{name} from {distance_radii} radii: {darker:?}");
    }
    // With the Sun in the image, its glare makes at most a tenth of the pixels white.
    let beside_sun = view(NaifId::EARTH, "2024-04-08T18:17:16Z", above_target(None, 60_000.0), None);
    let (found, exposure) = (displayed_light(&beside_sun), scene(&beside_sun).exposure);
    assert!(found.white_fraction < 0.1 && exposure.reason.to_string().contains("glare"), "{found:?}, {}", exposure.reason);
}

/// In totality the exposure is that for the inner corona. Of the radiance shown as white, the corona has less than 20 times at 1.05 solar radii,
/// more than 0.3 at 1.1, and more than 0.01 at 1.6.
#[test]
fn totality_is_exposed_for_the_corona() {
    let request = view(NaifId::SUN, "2024-04-08T18:42:38Z", ground(NaifId::EARTH, 32.78, -96.80), Some(3.0));
    let exposure = scene(&request).exposure;
    let fraction_of_white = |solar_radii: f64| corona::radiance(solar_radii) / exposure.white();
    assert!(exposure.reason.to_string().contains("corona"), "{}", exposure.reason);
    assert!(
        fraction_of_white(1.05) < 20.0 && fraction_of_white(1.1) > 0.3 && fraction_of_white(1.6) > 0.01,
        "{} stops: {}",
        exposure.stops,
        exposure.reason
    );
    // 90 minutes earlier, the Sun's disc is metered.
    let before = scene(&ViewRequest { time: request.time.plus_seconds(-5400.0), ..request }).exposure;
    assert!(before.reason.to_string().starts_with("Sun") && before.stops < -12.0, "{} stops: {}", before.stops, before.reason);
}

/// While the Sun is outside the frame, farther than its glare reaches, its corona is drawn, and the exposure is for the corona. In the frame the glare hides
/// it. While the Sun enters the frame, and with the corona switched off, no exposure is for a corona that is not drawn.
#[test]
fn a_corona_that_is_metered_is_drawn() {
    let effects = |text: &str| EffectOverrides::parse(text).expect("effects");
    let is_metered = |scene: &Scene| scene.exposure.reason.to_string().contains("corona");
    // The Moon and the bright planets are far from the Sun.
    let at_sun = view(NaifId::SUN, "2025-01-10T00:00:00Z", Position::Centre(NaifId::EARTH), Some(2.0));
    let at_sun = ViewRequest { effects: effects("-atmosphere"), ..at_sun };
    let towards = scene(&at_sun).body(NaifId::SUN).expect("the Sun").placement.centre_km.normalize();
    let east = DVec3::Z.cross(towards).normalize();
    let beside_sun = |angle_deg: f64| {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let look = Look::Along { direction: towards * cos + east * sin, axes: Axes::Icrf };
        scene(&ViewRequest { look, target: None, ..at_sun.clone() })
    };
    // The frame's edge is a degree from its middle, and the Sun's radius is a quarter of a degree. In the range tested below the Sun crosses the edge.
    for k in 0..30 {
        let angle_deg = 0.05 * f64::from(k);
        let scene = beside_sun(angle_deg);
        let (metered, drawn) = (is_metered(&scene), scene.corona.is_some());
        assert!(drawn || !metered, "{angle_deg} degrees: {}", scene.exposure.reason);
        if !(0.7..1.35).contains(&angle_deg) {
            assert_eq!((metered, drawn), (angle_deg > 1.0, angle_deg > 1.0), "{angle_deg} degrees: {}", scene.exposure.reason);
        }
    }
    let totality = view(NaifId::SUN, "2024-04-08T18:42:38Z", ground(NaifId::EARTH, 32.78, -96.80), Some(3.0));
    for (text, expected) in [("", true), ("-corona", false)] {
        let scene = scene(&ViewRequest { effects: effects(text), ..totality.clone() });
        assert_eq!((is_metered(&scene), scene.corona.is_some()), (expected, expected), "{text}: {}", scene.exposure.reason);
    }
}

/// How often [`assert_changes_smoothly`] halves a step that changes the exposure too much.
const HALVINGS: u32 = 12;

/// Checks the exposures of the views `view(0.0)`, `view(1.0)` and so on to `view(steps)`. None exceeds that of a night photograph. From one view to the next
/// the exposure may change by more than `bound_stops` only if the change is continuous, as where a limb or the Sun enters the frame. To test this, the step
/// is halved [`HALVINGS`] times. Of the two halves the one with the larger change is kept; the last one must change by less than `bound_stops`.
pub(super) fn assert_changes_smoothly(name: &str, bound_stops: f64, steps: i32, view: impl Fn(f64) -> ViewRequest) {
    let exposure_at = |step: f64| {
        let exposure = scene(&view(step)).exposure;
        assert!(exposure.stops.is_finite() && exposure.stops <= -darkest_white().log2() + 1e-9, "{name}: {} stops", exposure.stops);
        exposure
    };
    let (mut greatest_change, mut description) = (0.0_f64, String::new());
    let mut before = exposure_at(0.0);
    for k in 1..=steps {
        let after = exposure_at(f64::from(k));
        let change = (after.stops - before.stops).abs();
        if change > greatest_change {
            (greatest_change, description) =
                (change, format!("step {k}: {:+.2} ({}) to {:+.2} ({})", before.stops, before.reason, after.stops, after.reason));
        }
        if change > bound_stops {
            let (mut from, mut to) = (f64::from(k - 1), f64::from(k));
            let (mut from_stops, mut to_stops) = (before.stops, after.stops);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (from + to);
                let stops = exposure_at(middle).stops;
                if (stops - from_stops).abs() > (to_stops - stops).abs() {
                    (to, to_stops) = (middle, stops);
                } else {
                    (from, from_stops) = (middle, stops);
                }
            }
            let jump = (to_stops - from_stops).abs();
            assert!(jump < bound_stops, "{name}: a jump of {jump:.3} stops at step {from}, {bound_stops} allowed; {description}");
        }
        before = after;
    }
    println!("{name}: at most {greatest_change:.3} stops per step, {description}");
}

/// From half a radius above the ground to 2 au at most, in steps of 5 %. Per step, a point's light falls by a seventh of a stop.
#[test]
fn distance_moves_the_exposure_smoothly() {
    let targets = [NaifId::EARTH, NaifId::MOON, JUPITER, SATURN, NaifId::SUN];
    for (_, target) in targets.into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 2)) {
        // On a path past the Sun the scene behind the target would change completely.
        let towards = Some(if target == JUPITER { SATURN } else { JUPITER });
        let view_at = |k: f64| view(target, "2024-03-01T00:00:00Z", above_target(towards, 1.5 * 1.05_f64.powf(k)), None);
        // From more than 2 au away, the Sun would be in the frame of an inner planet.
        let radius_km = SESSION.catalog().body(target).expect("a body").radii_km.x;
        let steps = ((2.0 * orrery::units::KM_PER_AU / (1.5 * radius_km)).ln() / 1.05_f64.ln()) as i32;
        assert_changes_smoothly(&format!("distance from {target:?}"), 0.8, steps, view_at);
    }
}

/// Returns a function from the phase angle in degrees to a view of the body. The scene that gives the Sun's direction is built only once.
fn views_by_phase(target: NaifId, time: &str, distance_radii: f64, fov_deg: f64) -> impl Fn(f64) -> ViewRequest {
    let body = SESSION.catalog().body(target).expect("a body");
    let request = view(target, time, above_target(Some(NaifId::SUN), distance_radii), Some(fov_deg));
    let full_phase = scene(&request);
    let sunward = -full_phase.body(target).expect("a body").placement.centre_km.normalize();
    let distance_km = distance_radii * body.radii_km.x;
    move |phase_deg| {
        let rotation = DMat3::from_axis_angle(sunward.any_orthonormal_vector(), phase_deg.to_radians());
        let position = Position::Offset { body: target, offset_km: rotation * sunward * distance_km, axes: Axes::Icrf };
        ViewRequest { position, ..request.clone() }
    }
}

#[test]
fn phase_moves_the_exposure_smoothly() {
    let targets = [(NaifId::MOON, 12.0), (NaifId::EARTH, 3.0), (SATURN, 12.0), (VENUS, 5.0)];
    for (_, (target, distance_radii)) in targets.into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 2)) {
        let view_at = views_by_phase(target, "2024-03-01T00:00:00Z", distance_radii, 25.0);
        // First the body wanes until shortly before the Sun enters the frame. Then, in steps of 0.15 degrees, the Sun enters and sets behind the body.
        assert_changes_smoothly(&format!("phase of {target:?}"), 1.5, 110, |k| view_at(1.5 * k));
        assert_changes_smoothly(&format!("the Sun sets behind {target:?}"), 3.0, 100, |k| view_at(165.0 + 0.15 * k));
    }
}

#[test]
fn the_field_of_view_moves_the_exposure_smoothly() {
    let from_earth = |target, time, fov_deg: f64| view(target, time, Position::Centre(NaifId::EARTH), Some(fov_deg));
    let wider = |first_fov_deg: f64, k: f64| first_fov_deg * 1.04_f64.powf(k);
    let new_moon = |k| from_earth(NaifId::MOON, "2024-04-08T18:17:16Z", wider(0.2, k));
    assert_changes_smoothly("from the Sun and new Moon to a wide sky", 3.0, 155, new_moon);
    let full_moon = |k| from_earth(NaifId::MOON, "2024-04-23T23:00:00Z", wider(0.2, k));
    assert_changes_smoothly("from the full Moon to a wide sky", 3.0, 155, full_moon);
    let io = |k| from_earth(IO, "2025-03-01T13:00:00Z", wider(0.003, k));
    assert_changes_smoothly("from Io in shadow to Jupiter's system", 3.0, 200, io);
}

/// A solar eclipse seen from the ground; a lunar eclipse seen from the Earth, then from the Moon. Around second and third contact of the solar eclipse the
/// light changes within seconds, so the steps there are one second long.
#[test]
fn an_eclipse_moves_the_exposure_smoothly() {
    let sun = |seconds: f64| {
        let request = view(NaifId::SUN, "2024-04-08T17:20:00Z", ground(NaifId::EARTH, 32.78, -96.80), Some(3.0));
        ViewRequest { time: request.time.plus_seconds(seconds), ..request }
    };
    assert_changes_smoothly("from first to last contact", 2.0, 350, |k| sun(30.0 * k));
    for (name, from_s, is_before_totality) in [("around second contact", 4800.0, true), ("around third contact", 5040.0, false)] {
        let [first, last] = [from_s, from_s + 120.0].map(|seconds| exposure_stops(&sun(seconds)));
        let change = if is_before_totality { last - first } else { first - last };
        assert!(change > 6.0, "{name}: from {first} to {last} stops, so the contact is not in this span");
        assert_changes_smoothly(name, 2.0, 120, |k| sun(from_s + k));
    }
    let moon = |k: f64| {
        let request = view(NaifId::MOON, "2022-11-08T08:00:00Z", Position::Centre(NaifId::EARTH), Some(0.8));
        ViewRequest { time: request.time.plus_seconds(120.0 * k), ..request }
    };
    assert_changes_smoothly("the Moon through the umbra", 2.0, 180, moon);
    let earth = |k: f64| {
        let request = view(NaifId::EARTH, "2022-11-08T08:00:00Z", ground(NaifId::MOON, 0.0, 0.0), Some(3.0));
        ViewRequest { time: request.time.plus_seconds(120.0 * k), ..request }
    };
    assert_changes_smoothly("the Sun behind the Earth", 2.0, 180, earth);
}

/// The camera turns until the full Moon, or the Sun, has left the frame, by half a pixel per step.
#[test]
fn turning_the_camera_moves_the_exposure_smoothly() {
    for target in [NaifId::MOON, NaifId::SUN] {
        let centred = view(target, "2024-04-23T23:00:00Z", Position::Centre(NaifId::EARTH), Some(6.0));
        let towards = scene(&centred).body(target).expect("a body").placement.centre_km.normalize();
        let sideways = towards.any_orthonormal_vector();
        let turned = |k: f64| {
            let angle_rad = (0.03 * k).to_radians();
            let look = Look::Along { direction: towards * angle_rad.cos() + sideways * angle_rad.sin(), axes: Axes::Icrf };
            ViewRequest { look, target: None, ..centred.clone() }
        };
        assert_changes_smoothly(&format!("past {target:?}"), 2.0, 150, turned);
    }
    // Negative control: an explicit exposure that jumps.
    let jumps = |k: f64| {
        let exposure = ExposureRequest::Stops(if k < 1.7 { 0.0 } else { 5.0 });
        ViewRequest { exposure, ..view(MARS, "2024-03-01T00:00:00Z", above_target(None, 3.0), None) }
    };
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| assert_changes_smoothly("jumps", 4.0, 4, jumps))).is_err());
}

/// The mean radiance of a fully lit disc is half of the one shown as white, to a third of a stop.
#[test]
fn lit_discs_are_shown_at_half_of_white() {
    // The radiance is about the geometric albedo divided by the square of the distance from the Sun in au.
    for (target, disc_radiance) in [(NaifId::EARTH, 0.434), (MARS, 0.0793), (JUPITER, 0.0214), (NEPTUNE, 4.9e-4)] {
        let sunward = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: None };
        let request = view(target, "2024-04-08T18:17:16Z", sunward, None);
        let colour = f64::from(SESSION.catalog().body(target).expect("a body").colour.max_element());
        let expected = (0.5_f64 / (disc_radiance * colour)).log2();
        let found = exposure_stops(&request);
        assert!((found - expected).abs() < 0.34, "{target:?}: {found} stops, {expected} expected");
    }
}

/// At any explicit exposure every pixel is finite, and a higher exposure never shows fewer pixels.
#[test]
fn explicit_stops_give_finite_pixels() {
    for target in [NaifId::EARTH, SATURN, NaifId::SUN] {
        let base = ViewRequest { width: 48, height: 48, ..view(target, "2024-04-08T18:17:16Z", above_target(None, 4.0), None) };
        let mut visible_before = 0.0;
        for k in -4..=5 {
            let found = displayed_light(&ViewRequest { exposure: ExposureRequest::Stops(5.0 * f64::from(k)), ..base.clone() });
            assert!(found.visible_fraction >= visible_before, "{target:?} at {} stops: {found:?}, not {visible_before} as before", 5 * k);
            visible_before = found.visible_fraction;
        }
        assert!(visible_before > 0.1, "{target:?}: {visible_before} visible at the highest exposure");
    }
}

/// The exposure of a frame depends on its request alone, not on the frames drawn before it. A transition from another exposure is part of the request.
#[test]
fn exposure_depends_on_the_request_alone() {
    let night = view(NaifId::EARTH, "2024-12-25T18:00:00Z", ground(NaifId::EARTH, 48.14, 11.58), None);
    let day = ViewRequest { time: parse_time("2024-12-25T11:00:00Z"), ..night.clone() };
    let [night_stops, day_stops, again] = [&night, &day, &night].map(exposure_stops);
    assert_eq!(night_stops.to_bits(), again.to_bits());
    assert!(night_stops > day_stops + 8.0, "{night_stops} at night, {day_stops} by day");
    let in_transition = ViewRequest { exposure: ExposureRequest::Transition { from_stops: day_stops, progress: 0.25 }, ..night };
    let quarter_way = scene(&in_transition).exposure;
    assert!(
        (quarter_way.stops - (day_stops + 0.25 * (night_stops - day_stops))).abs() < 1e-9 && quarter_way.metered_stops == night_stops,
        "{}",
        quarter_way.stops
    );
}

/// Switching an effect off for the one body that shows it gives the same exposure as switching it off for all bodies, under each name of that body. In
/// each of these views the effect changes the exposure.
#[test]
fn effects_of_one_body_are_metered_as_they_are_drawn() {
    let crescent = view(NaifId::MOON, "2024-04-08T10:00:00Z", Position::Centre(NaifId::EARTH), None);
    let eclipsed = view(NaifId::MOON, "2022-11-08T11:00:00Z", Position::Centre(NaifId::EARTH), None);
    // The sunlit face of the rings beside the globe, which is outside the frame.
    let radius_km = SESSION.catalog().body(SATURN).expect("Saturn").radii_km.x;
    let from_north = Position::Offset { body: SATURN, offset_km: DVec3::new(4.0, 0.0, 3.0) * radius_km, axes: Axes::BodyFixed };
    let look = Look::Along { direction: DVec3::new(-4.0, 1.9, -3.0), axes: Axes::BodyFixed };
    let ringed = ViewRequest { look, ..view(SATURN, "2017-05-17T00:00:00Z", from_north, Some(12.0)) };
    let corona = ViewRequest { fov_deg: Some(3.0), ..view(NaifId::SUN, "2024-04-08T18:42:00Z", ground(NaifId::EARTH, 32.78, -96.8), None) };
    for (request, effect, names) in [
        (crescent, "-planet-shine", ["moon", "luna"]),
        (eclipsed, "-eclipse", ["moon", "luna"]),
        (ringed, "-rings", ["saturn", "Saturn"]),
        (corona, "-corona", ["sun", "sol"]),
    ] {
        let with =
            |effects: &str| exposure_stops(&ViewRequest { effects: EffectOverrides::parse(effects).expect("effects"), ..request.clone() });
        let (on, off) = (with(""), with(effect));
        assert!((on - off).abs() > 0.05, "{on} stops, {off} with {effect}");
        for name in names {
            let off_for_one = with(&format!("{name}:{effect}"));
            assert!((off_for_one - off).abs() < 1e-9, "{name}:{effect}: {off_for_one}, not {off}");
        }
    }
}

/// During totality, without the effect `eclipse`, the sky is drawn and exposed as on any day.
#[test]
fn a_sky_without_eclipses_is_exposed_for_its_daylight() {
    let totality =
        ViewRequest { fov_deg: Some(60.0), ..view(NaifId::MOON, "2024-04-08T18:42:00Z", ground(NaifId::EARTH, 32.78, -96.8), None) };
    for effects in ["-eclipse", "earth:-eclipse"] {
        let request = ViewRequest { effects: EffectOverrides::parse(effects).expect("effects"), ..totality.clone() };
        let light = displayed_light(&request);
        assert!(light.white_fraction < 0.2 && light.visible_fraction > 0.9, "{effects}: {light:?} at {} stops", exposure_stops(&request));
        // Negative control: at the exposure for the eclipsed sky it is white.
        let exposed_for_eclipse = ViewRequest { exposure: ExposureRequest::Stops(exposure_stops(&totality)), ..request };
        assert!(displayed_light(&exposed_for_eclipse).white_fraction > 0.9, "{effects}");
    }
}

/// A Sun smaller than two pixels beside a view of the Moon's night side, at first too far outside for glare (0.15 of the field). Then its glare, the sixth power
/// of an angle, rises by 0.13 stops per step where the exposure begins to fall, and the meter's limits by at most as much again. It does not whiten the image.
#[test]
fn the_glare_of_a_point_like_sun_beside_the_frame_fades() {
    let position = above_target(Some(PLUTO), 20.0);
    let of_moon = view(NaifId::MOON, "1981-05-06T02:00:00Z", position, None);
    let request = |fov_deg: f64| ViewRequest { width: 40, height: 40, fov_deg: Some(fov_deg), ..of_moon.clone() };
    for fov_deg in [34.0, 36.0, 38.0] {
        let light = displayed_light(&request(fov_deg));
        assert!(light.white_fraction < 0.05 && light.visible_fraction < 0.1, "{fov_deg} degrees: {light:?}");
    }
    for fov_deg in [43.0, 45.0, 47.0, 49.0] {
        let light = displayed_light(&request(fov_deg));
        assert!(light.white_fraction < 0.15, "{fov_deg} degrees: {light:?}");
    }
    let stops: Vec<f64> = (0..=96).map(|k| exposure_stops(&request(38.0 + 0.125 * f64::from(k)))).collect();
    for (k, [before, after]) in stops.array_windows().enumerate() {
        assert!((before - after).abs() < 0.3, "{} degrees: {before} to {after} stops", 38.0 + 0.125 * k as f64);
    }
    // Negative control: in all, the exposure falls by far more.
    assert!(stops[0] - stops[96] > 6.0, "{} to {} stops", stops[0], stops[96]);
}
