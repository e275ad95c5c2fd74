//! The Moon's limb profile: contacts and beads are compared with rays traced over the same heights, and with rendered pixels.
//!
//! The rays are an independent reference: of the program's code they use only the positions of bodies. They run from the place to points of
//! the Sun's limb, through the shell that contains all heights, in steps of 200 m. Totality is when every ray is blocked, annularity when none
//! is.

use super::{EPHEMERIS, IAU_RADII, parse_time, seconds_after};
use crate::support::sweep;
use glam::{DMat3, DVec3};
use orrery::catalog::NaifId;
use orrery::catalog::lunar_heights::HeightMap;
use orrery::ephemeris::orientation::earth_itrs_from_gcrs;
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::events::{GeodeticPosition, LimbContact, SolarEclipse, solar_eclipses};
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Layers, Position, ViewRequest};
use orrery::session::{Session, Sources};
use orrery::{FrameImages, Instant};
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

const COLUMNS: usize = 1440;
const ROWS: usize = 720;
/// Radius of the sphere from which heights are measured.
const SPHERE_KM: f64 = 1737.4;
const LOWEST_KM: f64 = -3.5;
const HIGHEST_KM: f64 = 6.0;
const KM_PER_HALF_METRE: f64 = 5e-4;

/// A made-up map of heights in half metres: hills and valleys of several sizes, summits, and every 12 degrees of latitude a deep valley along
/// the parallel. At the limb each of these valleys is a gap.
static HALF_METRES: LazyLock<Vec<i16>> = LazyLock::new(|| {
    let mut heights = Vec::new();
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let colatitude = (row as f64 + 0.5) * PI / ROWS as f64;
            let longitude = (column as f64 + 0.5) * TAU / COLUMNS as f64;
            let waves = 0.9 * (7.0 * longitude).sin() * (9.0 * colatitude).sin()
                + 0.5 * (31.0 * longitude + 5.0 * colatitude).sin() * colatitude.sin()
                + 0.3 * (57.0 * colatitude - 3.0 * longitude).cos();
            let valley = (0.5 + 0.5 * (30.0 * colatitude).cos()).powi(12);
            let summit = (0.5 + 0.5 * (23.0 * colatitude + 0.7).cos()).powi(20) * (0.5 + 0.5 * (19.0 * longitude).cos()).powi(6);
            let height_km = (waves - 1.6 * valley + 2.5 * summit).clamp(LOWEST_KM, HIGHEST_KM);
            heights.push((2000.0 * height_km).round() as i16);
        }
    }
    heights
});

fn height_map() -> HeightMap {
    let km = HALF_METRES.iter().map(|h| f32::from(*h) * KM_PER_HALF_METRE as f32).collect();
    HeightMap::new("made", COLUMNS, km, 0.0, SPHERE_KM).expect("a map")
}

/// Height above the sphere at a position in the Moon's axes, by bilinear interpolation.
fn height_km(at: DVec3) -> f64 {
    let latitude = (at.z / at.length()).asin();
    let fractional_row = (PI / 2.0 - latitude) / PI * ROWS as f64 - 0.5;
    let fractional_column = at.y.atan2(at.x) / TAU * COLUMNS as f64 - 0.5;
    let row = (fractional_row.floor().max(0.0) as usize).min(ROWS - 2);
    let row_fraction = (fractional_row - row as f64).clamp(0.0, 1.0);
    let interpolate_row = |row: usize| {
        let left = fractional_column.floor();
        let column_fraction = fractional_column - left;
        let texel_km =
            |column: f64| f64::from(HALF_METRES[row * COLUMNS + (column as i64).rem_euclid(COLUMNS as i64) as usize]) * KM_PER_HALF_METRE;
        texel_km(left) * (1.0 - column_fraction) + texel_km(left + 1.0) * column_fraction
    };
    interpolate_row(row) * (1.0 - row_fraction) + interpolate_row(row + 1) * row_fraction
}

/// Vectors from a place to the Sun and to the Moon, ICRF, km; and the rotation from ICRF to the Moon's axes. Light time is included, aberration
/// is not.
fn sun_and_moon(place: GeodeticPosition, t: Instant) -> (DVec3, DVec3, DMat3) {
    let earth_km = EPHEMERIS.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, t, None).expect("the Earth").state.pos_km;
    let radii_km = IAU_RADII.body(NaifId::EARTH).expect("the Earth").radii_km;
    let (point_km, _) = ground_point_km(radii_km, place.latitude_deg, place.longitude_deg, place.height_km);
    let here_km = earth_km + earth_itrs_from_gcrs(t).transpose() * point_km;
    let with_light_time = |body| EPHEMERIS.light_time_position(body, here_km, t).expect("placed");
    let ((sun_km, _), (moon_km, emitted)) = (with_light_time(NaifId::SUN), with_light_time(NaifId::MOON));
    (sun_km - here_km, moon_km - here_km, EPHEMERIS.body_from_icrf(NaifId::MOON, emitted).expect("an orientation"))
}

/// How many rays to the Sun's limb the Moon's ground blocks, and how many rays there are.
fn blocked_rays(place: GeodeticPosition, t: Instant) -> (usize, usize) {
    const RAYS: usize = 7200;
    let (sun_km, moon_km, moon_from_icrf) = sun_and_moon(place, t);
    let sun_radius_rad = (IAU_RADII.body(NaifId::SUN).expect("the Sun").radii_km.x / sun_km.length()).asin();
    let sun_direction = sun_km.normalize();
    let (x, y) = sun_direction.any_orthonormal_pair();
    let place_in_moon_axes = moon_from_icrf * -moon_km;
    let is_blocked = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / RAYS as f64).sin_cos();
        let ray = moon_from_icrf * (sun_direction * sun_radius_rad.cos() + (x * cos + y * sin) * sun_radius_rad.sin());
        // The ray's point closest to the Moon's centre: its position along the ray, and its distance from the centre.
        let closest_at_km = -place_in_moon_axes.dot(ray);
        let closest_km = (place_in_moon_axes + ray * closest_at_km).length();
        if closest_km <= SPHERE_KM + LOWEST_KM {
            return true;
        }
        if closest_km > SPHERE_KM + HIGHEST_KM {
            return false;
        }
        let half_chord_km = ((SPHERE_KM + HIGHEST_KM).powi(2) - closest_km * closest_km).sqrt();
        let steps = (2.0 * half_chord_km / 0.2).ceil();
        (0..=steps as usize).any(|n| {
            let p = place_in_moon_axes + ray * (closest_at_km - half_chord_km + 2.0 * half_chord_km * n as f64 / steps);
            p.length() <= SPHERE_KM + height_km(p)
        })
    };
    ((0..RAYS).filter(|k| is_blocked(*k)).count(), RAYS)
}

fn eclipse_on(day: &str) -> SolarEclipse {
    solar_eclipses(&IAU_RADII, &EPHEMERIS, parse_time(day), parse_time(day).plus_seconds(86_400.0)).expect("eclipses").remove(0)
}

fn contact(all: &[LimbContact], name: &str) -> LimbContact {
    *all.iter().find(|c| c.name == name).unwrap_or_else(|| panic!("no {name} in {all:?}"))
}

const DALLAS: GeodeticPosition = GeodeticPosition { latitude_deg: 32.78, longitude_deg: -96.80, height_km: 0.13 };
const ALBUQUERQUE: GeodeticPosition = GeodeticPosition { latitude_deg: 35.08, longitude_deg: -106.65, height_km: 1.6 };

/// Second and third contact agree with the rays within 0.3 s. In a total eclipse, the last bead before totality ends at second contact, and the first
/// one after it begins at third contact.
#[test]
fn beads_agree_with_rays_over_the_same_heights() {
    let map = height_map();
    let mut mean_limb_error_s: f64 = 0.0;
    let eclipses = [("2024-04-08", DALLAS, true), ("2023-10-14", ALBUQUERQUE, false)];
    // One eclipse of the two, chosen by the process id, unless full sweeps are on.
    for (_, (day, place, is_total)) in eclipses.into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 2)) {
        let eclipse = eclipse_on(day);
        let mean_limb = eclipse.seen_from(place).expect("an eclipse");
        let found = eclipse.limb_contacts(place, &EPHEMERIS, &map).expect("the Moon's orientation");
        assert_eq!(found.iter().map(|c| c.name).collect::<Vec<_>>(), ["C1", "C2", "C3", "C4"], "{day}");
        let is_total_or_annular = |t: Instant| {
            let (blocked, all) = blocked_rays(place, t);
            if is_total { blocked == all } else { blocked == 0 }
        };
        let middle = contact(&found, "C2").time.plus_seconds(0.5 * seconds_after(contact(&found, "C3").time, contact(&found, "C2").time));
        assert!(is_total_or_annular(middle), "{day}");
        // `outward`: the direction of time that leads out of totality or annularity.
        for (name, outward) in [("C2", -1.0), ("C3", 1.0)] {
            let found_contact = contact(&found, name);
            // Start 12 seconds inside totality or annularity, step outwards by half a second, then bisect. Times are in seconds from the start.
            let start = found_contact.time.plus_seconds(-outward * 12.0);
            let first_outside_s =
                (1..60).map(|k| outward * 0.5 * f64::from(k)).find(|s| !is_total_or_annular(start.plus_seconds(*s))).expect("it ends");
            let (mut inner_s, mut outer_s) = (first_outside_s - outward * 0.5, first_outside_s);
            for _ in 0..6 {
                let middle_s = 0.5 * (inner_s + outer_s);
                if is_total_or_annular(start.plus_seconds(middle_s)) { inner_s = middle_s } else { outer_s = middle_s }
            }
            let reference = start.plus_seconds(0.5 * (inner_s + outer_s));
            let error_s = seconds_after(found_contact.time, reference);
            assert!(error_s.abs() < 0.3, "{day} {name}: {error_s} s");
            let mean_limb_time = mean_limb.contacts.iter().find(|c| c.name == name).expect("central").time;
            assert!((seconds_after(found_contact.time, mean_limb_time) - found_contact.delay_s).abs() < 0.01);
            mean_limb_error_s = mean_limb_error_s.max(seconds_after(mean_limb_time, reference).abs());
        }
    }
    // Negative control: the contacts of the mean limb are off by more than a second.
    assert!(mean_limb_error_s > 1.0, "{mean_limb_error_s} s");
}

/// A Moon of constant height: at height 0 the contacts are those of the mean limb to 0.05 s. At a height of 2 km, totality begins 1.5 to 4.5 s
/// earlier and ends as much later. At -19 km, it begins more than 20 s later.
#[test]
fn level_ground_shifts_contacts_like_a_larger_moon() {
    let level_map = |km: f32| HeightMap::new("level", 360, vec![km; 360 * 180], 0.0, SPHERE_KM).expect("a map");
    let eclipse = eclipse_on("2024-04-08");
    let mean_limb = eclipse.seen_from(DALLAS).expect("an eclipse");
    let at_zero = eclipse.limb_contacts(DALLAS, &EPHEMERIS, &level_map(0.0)).expect("an orientation");
    for found in &at_zero {
        let mean_limb_time = mean_limb.contacts.iter().find(|m| m.name == found.name).expect("central").time;
        let delay_s = seconds_after(found.time, mean_limb_time);
        assert!(delay_s.abs() < 0.05, "{}: {delay_s} s", found.name);
    }
    let higher = eclipse.limb_contacts(DALLAS, &EPHEMERIS, &level_map(2.0)).expect("an orientation");
    let delay_s = |name: &str| seconds_after(contact(&higher, name).time, contact(&at_zero, name).time);
    // Two kilometres are 1.1 arcsec, and the Moon moves by 0.4 to 0.6 arcsec per second.
    assert!((-4.5..-1.5).contains(&delay_s("C2")) && (1.5..4.5).contains(&delay_s("C3")), "{} {}", delay_s("C2"), delay_s("C3"));
    let lower = eclipse.limb_contacts(DALLAS, &EPHEMERIS, &level_map(-19.0)).expect("an orientation");
    assert!(contact(&lower, "C2").delay_s > 20.0);
}

/// Half a second before totality and half a second after it there is light; half a second inside totality there is none.
#[test]
fn the_rendered_sun_goes_dark_with_the_last_bead() {
    let folder = tempfile::tempdir().expect("a folder");
    let label = format!(
        "PDS_VERSION_ID = \"PDS3\"\n^IMAGE = \"MADE.IMG\"\nLINES = {ROWS}\nLINE_SAMPLES = {COLUMNS}\n\
         SAMPLE_TYPE = LSB_INTEGER\nSAMPLE_BITS = 16\nUNIT = METER\nSCALING_FACTOR = 0.5\n\
         OFFSET = 1737400.\nWESTERNMOST_LONGITUDE = 0.0\n"
    );
    std::fs::write(folder.path().join("MADE.LBL"), label).expect("written");
    std::fs::write(folder.path().join("MADE.IMG"), HALF_METRES.iter().flat_map(|h| h.to_le_bytes()).collect::<Vec<_>>()).expect("written");
    let sources = Sources { lunar_heights: Some(folder.path().join("MADE.LBL").into_os_string()), ..crate::support::session::sources() };
    let session = Session::open(&sources, |_| ()).expect("opens");
    let found = eclipse_on("2024-04-08").limb_contacts(DALLAS, &EPHEMERIS, &height_map()).expect("an orientation");
    let sunlight = |t: Instant, threshold: f64| {
        let request = ViewRequest {
            width: 900,
            height: 900,
            fov_deg: Some(0.6),
            exposure: ExposureRequest::Stops(-15.0),
            effects: EffectOverrides::parse("-atmosphere,-glow,-corona,-albedo,-points").expect("effects"),
            layers: Layers::parse("-stars,-milky-way,-zodiacal-light").expect("layers"),
            position: Position::Ground {
                body: NaifId::EARTH,
                latitude_deg: DALLAS.latitude_deg,
                longitude_deg: DALLAS.longitude_deg,
                height_km: DALLAS.height_km,
            },
            ..ViewRequest::of(NaifId::MOON, t)
        };
        let frame = session.draw(&request, SamplingQuality { samples: 1, anisotropy: 1 }, FrameImages::DisplayAndHdr).expect("draws").frame;
        // The threshold excludes earthshine on the Moon.
        frame.hdr.iter().map(|p| f64::from(p[1])).filter(|v| *v > threshold).sum::<f64>()
    };
    for (name, outward) in [("C2", -1.0), ("C3", 1.0)] {
        let bead = contact(&found, name).time;
        let a_minute_outside = sunlight(bead.plus_seconds(outward * 60.0), 0.0);
        // In the unit of the image's light, in which the Sun's radiance is 46,000 (the square of 1 au in solar radii): far less than a pixel has of which a
        // bead covers a thousandth, and more than earthshine.
        let threshold = 1e-3;
        let [outside, inside] = [0.5, -0.5].map(|s| sunlight(bead.plus_seconds(outward * s), threshold));
        assert!(a_minute_outside > 0.0 && outside > 0.0, "{name}: {a_minute_outside} {outside}");
        assert_eq!(inside, 0.0, "{name}");
    }
}
