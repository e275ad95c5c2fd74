//! Minor planets: Kepler's equation in the vertex stage against f64, positions and light in images, and files supplied by the user.
//!
//! The reference is `ephemeris::conic` in f64, whose own tests compare it with the classical formulas. The tolerance is 1e-6 of the
//! semi-major axis up to e = 0.97.

use crate::support::emitted::{Emitted, EvalInput};
use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::small_bodies::{GAUSS_CONSTANT, HeliocentricOrbit, SmallBodies, SmallBody};
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::Ephemeris;
use orrery::ephemeris::apparent::aberrated;
use orrery::ephemeris::conic::heliocentric_state;
use orrery::render::plan::SamplingQuality;
use orrery::render::software::math::Real;
use orrery::scene::draw::DrawUniforms;
use orrery::scene::photometry::{irradiance_of_magnitude, slope_parameter_law};
use orrery::scene::request::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Position, ViewRequest};
use orrery::scene::sky::minor_planets::MARKER_LEVEL;
use orrery::scene::viewpoint::viewer;
use orrery::scene::{
    CORE_SIGMA_PX, GLARE_RADIUS_EXPONENT, GLARE_SCALE_RADIUS_PX, MAX_GLARE_FRACTION, MAX_RADIUS_PX, MIN_POINT_RADIUS_PX, point_peak,
    point_spread,
};
use orrery::session::{Session, Sources};
use orrery::time::Instant;
use orrery::units::{KM_PER_AU, SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S};
use std::f64::consts::PI;

/// The shader's position for `p`, the first four numbers of [`motion_input`]. The perihelion is on the x axis at distance `p.x`; `p.y` is 1 - e; the velocity
/// at perihelion is along y with the speed `p.z`; `p.w` is the time.
const POSITION_EXPRESSION: &str = "vec4f(motion(vec4f(p.x, 0.0, 0.0, p.y), vec3f(0.0, p.z, 0.0), p.w).position, 0.0)";

fn in_plane(perihelion_au: f64, eccentricity: f64) -> HeliocentricOrbit {
    HeliocentricOrbit { perihelion_au, eccentricity, to_perihelion: DVec3::X, motion_at_perihelion: DVec3::Y, passage_days: 0.0 }
}

/// The shader's input for an orbit with perihelion distance 1 au: this distance, 1 - e, speed at perihelion, and time. `time` past perihelion is in
/// units of 1 / [`GAUSS_CONSTANT`] days, as in the shader.
fn motion_input(e: f64, time: f64) -> EvalInput {
    [1.0, 1.0 - e, (1.0 + e).sqrt(), time, 0.0, 0.0, 0.0, 0.0]
}

/// Greatest distance between the shader's position and the f64 position over the given times, in units of `scale` at each.
fn greatest_error<R: Real>(shader: &Emitted, e: f64, times: &[f64], scale: impl Fn(DVec3) -> f64) -> f64 {
    let inputs: Vec<EvalInput> = times.iter().map(|t| motion_input(e, *t)).collect();
    let positions = shader.evaluate_in::<R>(&DrawUniforms::default(), None, &inputs);
    let error = |(t, p): (&f64, &[f64; 4])| {
        let expected = heliocentric_state(&in_plane(1.0, e), t / GAUSS_CONSTANT).position;
        DVec3::new(p[0], p[1], p[2]).distance(expected) / scale(expected)
    };
    times.iter().zip(&positions).map(error).fold(0.0, larger)
}

/// Times for [`motion_input`] over an orbit with perihelion distance 1 au, half of them before perihelion, and more times close to perihelion. An open orbit
/// has no period; its times are within 10,000 units of time of the passage through perihelion.
fn times(e: f64) -> Vec<f64> {
    let half_period = if e < 1.0 { PI * (1.0 - e).powf(-1.5) } else { 1e4 };
    let evenly_spaced = (-2000..=2000).map(|k| half_period * f64::from(k) / 2000.0);
    let near_perihelion = (-600..=600).map(|k| f64::from(k) / 100.0).filter(|t| t.abs() <= half_period);
    evenly_spaced.chain(near_perihelion).collect()
}

#[test]
fn keplers_equation_in_f32_agrees_with_f64() {
    let shader = Emitted::new("minor_planets", POSITION_EXPRESSION);
    for e in [0.0, 1e-6, 0.01, 0.1, 0.3, 0.5, 0.7, 0.85, 0.93, 0.97] {
        let semi_major_axis = 1.0 / (1.0 - e);
        let single = greatest_error::<f32>(&shader, e, &times(e), |_| semi_major_axis);
        let double = greatest_error::<f64>(&shader, e, &times(e), |_| semi_major_axis);
        println!("e {e}: {single:.2e} of the semi-major axis in f32, {double:.2e} in f64");
        assert!(single < 1e-6 && double < 1e-9, "e {e}: {single} {double}");
    }
    // For larger e, relative to the distance from the Sun: near-parabolic orbits on both sides, the parabola, and hyperbolas as open as
    // that of 2I/Borisov.
    for e in [0.99, 0.999, 0.9999, 1.0 - 1e-6, 1.0, 1.0 + 1e-6, 1.0001, 1.01, 1.2, 2.0, 3.4] {
        let single = greatest_error::<f32>(&shader, e, &times(e), DVec3::length);
        println!("e {e}: {single:.2e} of the distance in f32");
        assert!(single < 3e-6, "e {e}: {single}");
    }
    // The comparison must be able to fail: with one step instead of four, and with a Stumpff function that is off by 1e-5.
    let edited = |shipped: &'static str, edit: &'static str| {
        Emitted::edited("minor_planets", POSITION_EXPRESSION, |text| {
            assert_eq!(text.matches(shipped).count(), 1, "{shipped}");
            text.replace(shipped, edit)
        })
    };
    let one_step = edited("for (var k = 0; k < 4; k++)", "for (var k = 0; k < 1; k++)");
    assert!(greatest_error::<f32>(&one_step, 0.7, &times(0.7), |_| 1.0 / 0.3) > 1e-5);
    let inexact = edited("c2 *= 1.0 - 0.5 * y * c2;", "c2 = 0.5 * c1 * c1 * 1.00001;");
    assert!(greatest_error::<f32>(&inexact, 0.3, &times(0.3), |_| 1.0 / 0.7) > 2e-6);
}

/// The shader's H, G law against that of Ceres' and Vesta's globes: phase angles of 0 to 180 degrees, slope parameters of -0.1 to 0.6. Tolerance 1e-6: the
/// shader's constants are f32. At full phase it takes an angle of 0.4 arcseconds, which makes 6e-4 for a slope parameter of 0.
#[test]
fn the_phase_law_of_minor_planets_is_that_of_globes() {
    const TOLERANCE: f64 = 1e-6;
    const LAW: &str = "vec4f(phase_law(p.x, p.y))";
    let angles_deg = (0..=720).map(|k| 0.25 * f64::from(k));
    let cases: Vec<[f64; 2]> =
        angles_deg.flat_map(|deg| (0..=7).map(move |k| [(0.5 * deg).to_radians().tan(), -0.1 + 0.1 * f64::from(k)])).collect();
    let inputs: Vec<EvalInput> = cases.iter().map(|[tan_half, slope]| [*tan_half, *slope, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).collect();
    let greatest_error = |shader: &Emitted| {
        let results = shader.evaluate(&DrawUniforms::default(), None, &inputs);
        let error = |([tan_half, slope], found): (&[f64; 2], &[f64; 4])| {
            let at_full_phase = if *tan_half == 0.0 { 7e-4 } else { 0.0 };
            (found[0] - slope_parameter_law(*tan_half, *slope)).abs() - at_full_phase
        };
        cases.iter().zip(&results).map(error).fold(f64::NEG_INFINITY, larger)
    };
    let found = greatest_error(&Emitted::new("minor_planets", LAW));
    assert!(found < TOLERANCE, "{found}");
    // Each constant matters.
    for (shipped, edit) in [("-3.33", "-3.34"), ("0.63)", "0.64)"), ("-1.87", "-1.88"), ("1.22)", "1.23)")] {
        let edited = Emitted::edited("minor_planets", LAW, |text| {
            assert_eq!(text.matches(shipped).count(), 1, "{shipped}");
            text.replace(shipped, edit)
        });
        let found = greatest_error(&edited);
        assert!(found > 10.0 * TOLERANCE, "{edit}: {found}");
    }
}

/// The shader gives a sprite the profile of `scene::point_spread`, and an extent that grows with the same power of its peak.
#[test]
fn sprites_have_the_profile_of_other_points() {
    let law = format!("vec4f({MIN_POINT_RADIUS_PX:?}, {GLARE_RADIUS_EXPONENT:?}, {MAX_RADIUS_PX:?}, {MAX_GLARE_FRACTION:?})");
    let value = format!("vec4f(point_shape(p.x, {law}, {CORE_SIGMA_PX:?}, {GLARE_SCALE_RADIUS_PX:?}), 0.0)");
    let shader = Emitted::new("minor_planets", &value);
    let peaks: Vec<f64> = (-20..=80).map(|k| 10_f64.powf(f64::from(k) / 10.0)).collect();
    let inputs: Vec<EvalInput> = peaks.iter().map(|p| [*p, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).collect();
    for (peak, found) in peaks.iter().zip(shader.evaluate_in::<f32>(&DrawUniforms::default(), None, &inputs)) {
        let radius = (MIN_POINT_RADIUS_PX * peak.max(1.0).powf(GLARE_RADIUS_EXPONENT)).min(MAX_RADIUS_PX);
        let [core, glare] = point_spread(radius);
        assert!((found[0] / radius - 1.0).abs() < 1e-5, "{peak}: {found:?}");
        assert!(
            (found[1] / core - 1.0).abs() < 1e-5 && (found[2] - glare).abs() < 1e-4 * glare.max(1e-3),
            "{peak}: {found:?} {core} {glare}"
        );
    }
}

/// A session with this table of minor planets, and the folder of its files.
fn session_with_table(table: &str) -> (Session, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("one.csv");
    std::fs::write(&file, table).expect("written");
    let sources = Sources { minor_planets: Some(file), cache: Some(folder.path().join("cache")), ..Sources::default() };
    (Session::open(&sources, |line| panic!("{line}")).expect("opens"), folder)
}

/// The embedded entry with that name, and a table with only this entry.
fn single_entry(name: &str) -> (SmallBody, String) {
    let all = SmallBodies::embedded();
    let body = all.minor_planets.iter().find(|b| b.name == name).expect(name).clone();
    let rows: Vec<&str> = orrery_catalogs::SMALL_BODIES.lines().collect();
    // The first row is a comment.
    let column_names = rows[1];
    let row = rows.iter().find(|l| l.split(',').nth(1) == Some(name)).expect(name);
    (body, format!("{column_names}\n{row}\n"))
}

/// From the Earth's centre to a body: its apparent direction (light time iterated in f64, aberration), and its distances from the Earth and
/// the Sun.
fn seen_from_earth(ephemeris: &Ephemeris, body: &SmallBody, time: Instant) -> (DVec3, f64, f64) {
    let state = |id: NaifId| ephemeris.state(id, NaifId::SOLAR_SYSTEM_BARYCENTER, time, None).expect("a state").state;
    let (earth, sun) = (state(NaifId::EARTH), state(NaifId::SUN));
    let days = time.tdb_seconds_past_j2000() / SECONDS_PER_DAY;
    let (mut light_time_days, mut place_au) = (0.0, DVec3::ZERO);
    for _ in 0..5 {
        place_au = heliocentric_state(&body.orbit, days - light_time_days).position;
        let distance_km = (sun.pos_km + place_au * KM_PER_AU - earth.pos_km).length();
        light_time_days = distance_km / SPEED_OF_LIGHT_KM_S / SECONDS_PER_DAY;
    }
    let from_earth = sun.pos_km + place_au * KM_PER_AU - earth.pos_km;
    (aberrated(from_earth.normalize(), earth.vel_km_s), from_earth.length() / KM_PER_AU, place_au.length())
}

fn towards(direction: DVec3, fov_deg: f64, time: Instant) -> ViewRequest {
    ViewRequest {
        width: 64,
        height: 64,
        exposure: ExposureRequest::Stops(24.0),
        layers: Layers { minor_planets: true, ..Layers::NONE },
        // At this exposure the corona lights the sky up to 25 degrees from the Sun.
        effects: EffectOverrides::parse("-corona").expect("an effect"),
        ..super::stars::towards(direction, fov_deg, time)
    }
}

/// Pallas, the near-Earth asteroid Eros and distant Sedna at four dates: the centroid in the image is at the f64 position, and the light
/// follows H and G.
#[test]
fn images_show_minor_planets_at_their_position_and_brightness() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("an ephemeris");
    let (mut worst_px, mut worst_light, mut geometric_shift_px): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let mut brighter_than_markers = 0;
    for name in ["Pallas", "Eros", "Sedna"] {
        let (body, table) = single_entry(name);
        let (session, _folder) = session_with_table(&table);
        for time in ["1950-06-01T00:00:00Z", "2012-01-31T11:00:00Z", "2024-04-08T18:00:00Z", "2090-10-10T10:10:10Z"] {
            let time = Instant::parse(time).expect("a time");
            let (direction, distance_au, sun_distance_au) = seen_from_earth(&ephemeris, &body, time);
            // Slightly off the middle.
            let aim = (direction + DVec3::new(2e-5, -1e-5, 3e-5)).normalize();
            let request = towards(aim, 0.02, time);
            let camera = viewer(&catalog, &ephemeris, &request).expect("a camera").camera;
            let expected_px = camera.pixel_from_clip(camera.clip(direction).expect("ahead"));
            let drawn = session.draw(&request, SamplingQuality { samples: 4, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn");
            let (mut sum, mut moment) = (0.0, DVec2::ZERO);
            for (k, p) in drawn.frame.hdr.iter().enumerate() {
                let at = DVec2::new((k % 64) as f64 + 0.5, (k / 64) as f64 + 0.5);
                sum += f64::from(p[1]);
                moment += at * f64::from(p[1]);
            }
            worst_px = larger(worst_px, (moment / sum).distance(expected_px));
            let earth_to_sun_au = ephemeris.state(NaifId::SUN, NaifId::EARTH, time, None).expect("a state").state.pos_km / KM_PER_AU;
            geometric_shift_px = geometric_shift_px
                .max(((geometric_direction(&ephemeris, &body, time) - direction).length() / camera.pixel_tangent()).abs());
            // The phase angle from the triangle of Sun, Earth and body.
            let cos_phase =
                (sun_distance_au.powi(2) + distance_au.powi(2) - earth_to_sun_au.length_squared()) / (2.0 * sun_distance_au * distance_au);
            let tan_half_phase = (0.5 * cos_phase.clamp(-1.0, 1.0).acos()).tan();
            let orrery::catalog::small_bodies::BrightnessLaw::Asteroid { h, g } = body.brightness else { panic!("{name} has H") };
            let phase_law = (1.0 - g) * (-3.33 * tan_half_phase.powf(0.63)).exp() + g * (-1.87 * tan_half_phase.powf(1.22)).exp();
            let magnitude = h + 5.0 * (sun_distance_au * distance_au).log10() - 2.5 * phase_law.log10();
            let flux = irradiance_of_magnitude(magnitude) * PI / camera.pixel_tangent().powi(2);
            // `MARKER_LEVEL`: radiance of a marker's brightest pixel as a fraction of white. `point_peak`: radiance of that pixel for a flux of 1.
            let marker_flux = MARKER_LEVEL * drawn.scene.exposure.white() / point_peak();
            let colour = f64::from(drawn.scene.minor_planets.as_ref().expect("asked for").colour.y);
            worst_light = larger(worst_light, (sum / (flux.max(marker_flux) * colour) - 1.0).abs());
            brighter_than_markers += usize::from(flux > marker_flux);
        }
    }
    println!("centroids within {worst_px:.4} px (a pixel is 1.1 arcsec wide), light within {:.2} %", 100.0 * worst_light);
    assert!(worst_px < 0.1 && worst_light < 0.02, "{worst_px} {worst_light}");
    assert!(brighter_than_markers > 4, "{brighter_than_markers} are brighter than markers");
    // Without light time and aberration the positions differ.
    assert!(geometric_shift_px > 5.0, "{geometric_shift_px}");
}

/// Direction from the Earth to the body without light time and aberration.
fn geometric_direction(ephemeris: &Ephemeris, body: &SmallBody, time: Instant) -> DVec3 {
    let state = |id: NaifId| ephemeris.state(id, NaifId::SOLAR_SYSTEM_BARYCENTER, time, None).expect("a state").state.pos_km;
    let days = time.tdb_seconds_past_j2000() / SECONDS_PER_DAY;
    (state(NaifId::SUN) + heliocentric_state(&body.orbit, days).position * KM_PER_AU - state(NaifId::EARTH)).normalize()
}

/// Minor planets are drawn if their layer is on, otherwise not. In both cases the scene records a decision with its reason.
#[test]
fn minor_planets_are_drawn_only_with_their_layer() {
    let time = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
    let view = |layers: &str| ViewRequest {
        position: Position::Offset { body: NaifId::SUN, offset_km: DVec3::new(0.0, -0.4, 0.9) * 6.5 * KM_PER_AU, axes: Axes::Icrf },
        width: 128,
        height: 128,
        fov_deg: Some(60.0),
        layers: Layers::parse(layers).expect("layers"),
        ..ViewRequest::of(NaifId::SUN, time)
    };
    let draw = |layers: &str| {
        SESSION.draw(&view(layers), SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn")
    };
    let (without, with) = (draw("-stars"), draw("-stars,+minor-planets"));
    // `times` has one element for each body.
    assert!(without.scene.minor_planets.is_none() && with.scene.minor_planets.as_ref().is_some_and(|m| m.times.len() == 602));
    let decision_of = |drawn: &orrery::session::DrawnFrame| {
        drawn.scene.sky_decisions.iter().find(|d| d.effect == "minor-planets").cloned().expect("a reason")
    };
    assert!(!decision_of(&without).on && decision_of(&without).reason.to_string().contains("off unless you switch"));
    assert!(decision_of(&with).on && decision_of(&with).reason.to_string().contains("602 orbits"), "{:?}", decision_of(&with));
    let changed = without.frame.display.iter().zip(&with.frame.display).filter(|(a, b)| a != b).count();
    assert!(changed > 1500, "{changed} pixels");
}

/// A file that lists only Ceres, which is a body of the catalog, leaves no minor planets. Nothing is drawn for them: wgpu panics at a draw with empty buffers.
#[test]
fn a_file_that_lists_only_bodies_of_the_catalog_makes_no_draw() {
    let (_, table) = single_entry("Ceres");
    let (session, _folder) = session_with_table(&table);
    let request = towards(DVec3::X, 1.0, Instant::parse("2024-04-08T18:17:16Z").expect("a time"));
    let (scene, plan) = session.plan(&request, SamplingQuality { samples: 1, anisotropy: 1 }).expect("a plan");
    assert!(scene.minor_planets.as_ref().is_some_and(|m| m.times.is_empty()));
    let mut draws = plan.passes.iter().flat_map(|pass| &pass.draws);
    assert!(draws.all(|draw| draw.instances.count > 0 && draw.label != "minor planets"));
}
