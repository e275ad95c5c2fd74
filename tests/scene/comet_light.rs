//! The light of comets in images: the same at any number of samples, shared by head and tails, dimmed by the air, metered.

use super::comets::{comet, from_earth_au};
use super::metering::assert_changes_smoothly;
use super::stars::towards;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::catalog::small_bodies::{BrightnessLaw, HeliocentricOrbit, SmallBodies, SmallBody};
use orrery::ephemeris::angle_rad;
use orrery::ephemeris::conic::heliocentric_state;
use orrery::render::plan::SamplingQuality;
use orrery::scene::camera::Camera;
use orrery::scene::request::{ExposureRequest, Layers, Position, ViewRequest};
use orrery::scene::sky::comet_tails::ion_direction;
use orrery::scene::sky::comets::total_magnitude;
use orrery::scene::sky::frames::unit_vector;
use orrery::session::Session;
use orrery::time::Instant;
use orrery::units::{SECONDS_PER_DAY, luminance};

const SIDE: u32 = 160;
const COMETS: Layers = Layers { comets: true, ..Layers::NONE };

fn session() -> &'static Session {
    &crate::support::session::SESSION
}

fn time_of(text: &str) -> (Instant, f64) {
    let time = Instant::parse(text).expect("a time");
    (time, time.tdb_seconds_past_j2000() / SECONDS_PER_DAY)
}

/// A view in a direction (ICRF) from the Earth's centre at a night exposure.
fn view(direction: DVec3, time: Instant, fov_deg: f64, layers: Layers) -> ViewRequest {
    ViewRequest { width: SIDE, height: SIDE, exposure: ExposureRequest::Stops(22.0), layers, ..towards(direction, fov_deg, time) }
}

fn view_of_comet(name: &str, time_text: &str, fov_deg: f64) -> ViewRequest {
    let (time, days) = time_of(time_text);
    let direction = from_earth_au(session().ephemeris(), &comet(name), days);
    view(direction.normalize(), time, fov_deg, COMETS)
}

/// The linear image and its camera.
fn drawn(session: &Session, request: &ViewRequest, samples: u8) -> (Vec<[f32; 4]>, Camera) {
    let drawn = session.draw(request, SamplingQuality { samples, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("drawn");
    (drawn.frame.hdr.to_vec(), drawn.scene.camera.clone())
}

fn luminance_of(pixel: &[f32; 4]) -> f64 {
    luminance([0, 1, 2].map(|k| f64::from(pixel[k])))
}

/// A pixel's offset from the middle of the image, pixels, y up.
fn offset_px(k: usize) -> DVec2 {
    let (x, y) = (k % SIDE as usize, k / SIDE as usize);
    let half = 0.5 * f64::from(SIDE);
    DVec2::new(x as f64 + 0.5 - half, half - 0.5 - y as f64)
}

/// Radiance is never below 0, and neither its sum nor its maximum depends on the number of samples per pixel: each pixel takes a patch's light at its centre,
/// and all samples of a lit pixel are inside the patch.
#[test]
fn light_does_not_depend_on_the_number_of_samples() {
    for (name, time, fov_deg) in [
        ("McNaught", "2007-01-10T10:00:00Z", 2.0),
        ("McNaught", "2007-01-15T10:00:00Z", 8.0),
        ("West", "1976-03-04T05:00:00Z", 2.0),
        ("Hale-Bopp", "1997-03-31T20:00:00Z", 0.2),
        ("Hale-Bopp", "1997-03-31T20:00:00Z", 20.0),
        ("Halley", "1986-03-16T00:00:00Z", 1.5),
        ("F3 (NEOWISE)", "2020-07-14T00:00:00Z", 4.0),
    ] {
        let request = view_of_comet(name, time, fov_deg);
        let [single, multiple] = [1, 4].map(|samples| drawn(session(), &request, samples).0);
        let lowest = |image: &[[f32; 4]]| image.iter().flat_map(|p| p[..3].to_vec()).fold(f32::INFINITY, f32::min);
        let total = |image: &[[f32; 4]]| image.iter().map(luminance_of).sum::<f64>();
        let highest = |image: &[[f32; 4]]| image.iter().map(luminance_of).fold(0.0, f64::max);
        println!("{name} {time} {fov_deg}: {:.4e} {:.4e}", total(&single), total(&multiple));
        assert!(lowest(&single) >= 0.0 && lowest(&multiple) >= 0.0, "{name} {time} {fov_deg}: {}", lowest(&multiple));
        assert!((total(&multiple) / total(&single) - 1.0).abs() < 0.005, "{name} {time} {fov_deg}");
        assert!((highest(&multiple) / highest(&single) - 1.0).abs() < 0.005, "{name} {time} {fov_deg}");
        // No black pixels in the head.
        let head = multiple.iter().enumerate().filter(|(k, _)| offset_px(*k).length() < 1.5).map(|(_, p)| luminance_of(p));
        assert!(head.fold(f64::INFINITY, f64::min) > 1e-4 * highest(&multiple), "{name} {time} {fov_deg}");
    }
}

/// In the image, head and tails together have the light of the total magnitude; the frame leaves out the ends of the tails.
#[test]
fn head_and_tails_share_the_light_of_the_magnitude() {
    let (_, days) = time_of("1997-03-31T20:00:00Z");
    let hale_bopp = comet("Hale-Bopp");
    let position_au = heliocentric_state(hale_bopp.orbit_at(days), days).position;
    let from_earth_au = from_earth_au(session().ephemeris(), &hale_bopp, days);
    let phase_angle_rad = angle_rad(-from_earth_au, -position_au);
    let magnitude = total_magnitude(hale_bopp.brightness_at(days), from_earth_au.length(), position_au.length(), phase_angle_rad);
    let magnitude = magnitude.expect("a comet");
    let request = view_of_comet("Hale-Bopp", "1997-03-31T20:00:00Z", 40.0);
    let (image, camera) = drawn(session(), &request, 1);
    let (without, _) = drawn(session(), &ViewRequest { layers: Layers::NONE, ..request }, 1);
    let pixel_tangent = camera.pixel_tangent();
    // A pixel at the tangent t from the middle covers the solid angle pixel_tangent^2 (1 + t^2)^-1.5.
    let solid_angle = |k: usize| pixel_tangent.powi(2) * (1.0 + (offset_px(k) * pixel_tangent).length_squared()).powf(-1.5);
    let light = image.iter().zip(&without).map(|(a, b)| luminance_of(a) - luminance_of(b));
    let irradiance: f64 = light.enumerate().map(|(k, light)| light * solid_angle(k) / std::f64::consts::PI).sum();
    // Irradiance 1 is the Sun's at 1 au, magnitude -26.76.
    let ratio = irradiance / 10_f64.powf(-0.4 * (magnitude + 26.76));
    println!("magnitude {magnitude:.2}: {ratio:.3} of its light in the frame");
    assert!((0.88..1.02).contains(&ratio), "{ratio}");
}

/// In photographs of Hale-Bopp the dust tail is brighter than the ion tail: here 5 degrees from the head.
#[test]
fn the_dust_tail_is_brighter_than_the_ion_tail() {
    let request = view_of_comet("Hale-Bopp", "1997-03-31T20:00:00Z", 14.0);
    let (image, camera) = drawn(session(), &request, 4);
    let (_, days) = time_of("1997-03-31T20:00:00Z");
    let hale_bopp = comet("Hale-Bopp");
    let state = heliocentric_state(hale_bopp.orbit_at(days), days);
    let to_ions_au = from_earth_au(session().ephemeris(), &hale_bopp, days) + 0.1 * ion_direction(&state);
    let ion_clip = camera.clip(to_ions_au).expect("ahead");
    let ions = ion_clip.normalize();
    let radius_px = 5_f64.to_radians().tan() / camera.pixel_tangent();
    let brightest = |is_ion_tail: bool| {
        let on_ring = image.iter().enumerate().filter(|(k, _)| {
            let offset = offset_px(*k);
            let is_near_ions = offset.normalize().dot(ions) > 8_f64.to_radians().cos();
            (offset.length() - radius_px).abs() < 1.5 && is_near_ions == is_ion_tail
        });
        on_ring.map(|(_, p)| luminance_of(p)).fold(0.0, f64::max)
    };
    let (dust, ion) = (brightest(false), brightest(true));
    println!("5 degrees from the head: dust {dust:.3e}, ions {ion:.3e}");
    assert!(ion > 0.0 && dust > ion, "{dust} {ion}");
}

/// Hyakutake's coma on 25 March 1996 was 2 degrees wide. Its light falls as 1 / distance, so twice the radius has nearly twice the light; all light of a point
/// would be within a few pixels.
#[test]
fn a_near_coma_is_a_disc() {
    let (image, camera) = drawn(session(), &view_of_comet("Hyakutake", "1996-03-25T07:00:00Z", 4.0), 4);
    let within = |radius_deg: f64| {
        let radius_px = radius_deg.to_radians() / camera.pixel_tangent();
        image.iter().enumerate().filter(|(k, _)| offset_px(*k).length() < radius_px).map(|(_, p)| luminance_of(p)).sum::<f64>()
    };
    let ratio = within(0.5) / within(0.25);
    println!("light within 0.5 degrees over that within 0.25: {ratio:.2}");
    assert!((1.4..2.1).contains(&ratio), "{ratio}");
}

/// The air dims and reddens a comet and a minor planet near the horizon as it does a star in the same direction: Capella from 40 N, 10 E.
#[test]
fn the_air_dims_comets_and_minor_planets_as_it_dims_stars() {
    let capella = unit_vector(79.172, 45.998);
    let times = ["1997-03-31T19:30:00Z", "1997-04-01T01:00:00Z"];
    let (_, days) = time_of(times[0]);
    let far_away = HeliocentricOrbit {
        perihelion_au: 5000.0,
        eccentricity: 0.0,
        to_perihelion: capella,
        motion_at_perihelion: capella.any_orthonormal_vector(),
        passage_days: days,
    };
    // Both have the magnitude 0 at 5000 au.
    let magnitude_at_1_au = -5.0 * 5000_f64.log10();
    let comet = SmallBody::of("", "far comet", far_away, BrightnessLaw::Comet { m1: magnitude_at_1_au, k1: 0.0, dust_to_gas: 1.0 });
    let minor_planet = SmallBody::of("", "far", far_away, BrightnessLaw::Asteroid { h: 2.0 * magnitude_at_1_au, g: 0.15 });
    let bodies = SmallBodies { minor_planets: vec![minor_planet], comets: vec![comet] };
    let session = Session::open(&crate::support::session::sources(), |line| panic!("{line}")).expect("opens").with_small_bodies(bodies);
    // Light per channel that a layer adds to the image.
    let light = |time: &str, layers: Layers| {
        let ground = Position::Ground { body: NaifId::EARTH, latitude_deg: 40.0, longitude_deg: 10.0, height_km: 0.002 };
        let request = |layers: Layers| ViewRequest { position: ground, ..view(capella, time_of(time).0, 1.0, layers) };
        let [with, without] = [layers, Layers::NONE].map(|layers| drawn(&session, &request(layers), 1).0);
        [0, 1, 2].map(|c| with.iter().zip(&without).map(|(a, b)| f64::from(a[c]) - f64::from(b[c])).sum::<f64>())
    };
    let dimming = |layers: Layers| {
        let [high, low] = times.map(|time| light(time, layers));
        [0, 1, 2].map(|c| low[c] / high[c])
    };
    let star = dimming(Layers { stars: true, ..Layers::NONE });
    // Near the horizon the star is much fainter, and redder.
    assert!(star[1] < 0.6 && star[2] < 0.7 * star[0], "{star:?}");
    for (name, layers) in [("comet", COMETS), ("minor planet", Layers { minor_planets: true, ..Layers::NONE })] {
        let found = dimming(layers);
        println!("{name}: {found:.3?}, star {star:.3?}");
        for c in 0..3 {
            assert!((found[c] - star[c]).abs() < 0.1 * star[c] + 0.01, "{name}: {found:?}, star {star:?}");
        }
    }
}

/// McNaught beside the Sun on 13 January 2007, in a frame of 4 degrees. Exposed for its sky, head and tail were white by a factor of 200; metered, the core of
/// the head is white, the tail is visible one degree from it.
#[test]
fn a_bright_comet_is_exposed_for_its_light() {
    let auto =
        |layers: Layers| ViewRequest { exposure: ExposureRequest::Auto, layers, ..view_of_comet("McNaught", "2007-01-13T17:00:00Z", 4.0) };
    let stops = |layers: Layers| session().scene(&auto(layers)).expect("a scene").exposure.stops;
    let (with_comet, of_sky) = (stops(COMETS), stops(Layers::NONE));
    assert!((12.8..14.8).contains(&with_comet) && of_sky > 20.5, "{with_comet} stops, without comets {of_sky}");
    let (image, camera) = drawn(session(), &auto(COMETS), 1);
    let (without, _) = drawn(session(), &auto(Layers::NONE), 1);
    let levels: Vec<f64> = image.iter().zip(&without).map(|(a, b)| (luminance_of(a) - luminance_of(b)) * with_comet.exp2()).collect();
    let white_part = levels.iter().filter(|level| **level > 1.0).count() as f64 / levels.len() as f64;
    let degree_px = 1_f64.to_radians().tan() / camera.pixel_tangent();
    let on_ring = levels.iter().enumerate().filter(|(k, _)| (offset_px(*k).length() - degree_px).abs() < 1.5);
    let tail = on_ring.map(|(_, level)| *level).fold(0.0, f64::max);
    println!("{with_comet:.2} stops, without comets {of_sky:.2}; white {white_part:.4} of the image, tail {tail:.3} of white");
    assert!((1e-4..0.03).contains(&white_part) && (0.03..0.5).contains(&tail), "{white_part} {tail}");
}

/// From a view of Hale-Bopp's head to one of its surroundings, in which the head is a point of light.
#[test]
fn a_comet_leaves_the_light_meters_reading_gradually() {
    let zoomed_out = |k: f64| ViewRequest {
        exposure: ExposureRequest::Auto,
        width: 96,
        height: 96,
        ..view_of_comet("Hale-Bopp", "1997-03-31T20:00:00Z", 0.2 * 1.05_f64.powf(k))
    };
    assert_changes_smoothly("Hale-Bopp", 0.3, 85, zoomed_out);
    let [near, far] = [0.0, 85.0].map(|k| session().scene(&zoomed_out(k)).expect("a scene").exposure.stops);
    assert!(near < far - 3.0, "{near} and {far} stops: the check above cannot fail");
}
