//! Altitudes, rise and set, and local circumstances of eclipses, against reference tables and almanacs.

use orrery::catalog::{Catalog, EclipseRadii, NaifId};
use orrery::ephemeris::topocentric::{DiscPassage, Observer, ObserverSky};
use orrery::ephemeris::{Ephemeris, angle_rad};
use orrery::time::Instant;
use serde_json::Value;

fn number(v: &Value, field: &str) -> f64 {
    v[field].as_f64().unwrap_or_else(|| panic!("{field} in {v}"))
}

/// At every sample of the solar eclipses in the table.
#[test]
fn altitudes_and_separations_agree_with_the_reference() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    let table: Value = serde_json::from_str(include_str!("../data/eclipses_public.json")).expect("the table");
    let mut compared = 0;
    let (mut altitude_error_deg, mut separation_error_deg, mut motion_in_a_second_deg) = (0.0_f64, 0.0_f64, 0.0_f64);
    for eclipse in table["eclipses"].as_array().expect("eclipses").iter().filter(|e| e["kind"] == "solar") {
        let times = eclipse["sample_times"].as_array().expect("times");
        for point in eclipse["sample_points"].as_array().expect("points") {
            let place = Observer {
                body: NaifId::EARTH,
                lat_graphic_deg: number(point, "lat_deg"),
                lon_east_deg: number(point, "lon_east_deg"),
                height_km: number(point, "height_m") / 1e3,
            };
            let sky = ObserverSky { catalog: &catalog, ephemeris: &ephemeris, place };
            for (sample, sample_time) in point["at"].as_array().expect("samples").iter().zip(times) {
                let time = Instant::from_tdb_seconds_past_j2000(number(sample_time, "tdb_s_past_j2000"));
                let sun = sky.topocentric(NaifId::SUN, time).expect("the Sun");
                let moon = sky.topocentric(NaifId::MOON, time).expect("the Moon");
                altitude_error_deg = altitude_error_deg.max((sun.altitude_deg - number(sample, "sun_altitude_deg")).abs());
                let separation_deg = angle_rad(sun.direction, moon.direction).to_degrees();
                separation_error_deg = separation_error_deg.max((separation_deg - number(sample, "separation_deg")).abs());
                let late_moon = sky.topocentric(NaifId::MOON, time.plus_seconds(1.0)).expect("the Moon");
                let late_separation_deg = angle_rad(sun.direction, late_moon.direction).to_degrees();
                motion_in_a_second_deg = motion_in_a_second_deg.max((late_separation_deg - separation_deg).abs());
                // `max` ignores NaN.
                assert!(sun.altitude_deg.is_finite() && separation_deg.is_finite(), "{sample}");
                compared += 1;
            }
        }
    }
    assert!(compared >= 100, "{compared} samples");
    // Program and reference leave out aberration and refraction. Errors measured in a third of the samples: 4e-5 and 6e-7 degrees.
    assert!(altitude_error_deg < 2e-4, "{altitude_error_deg} degrees");
    assert!(separation_error_deg < 5e-6, "{separation_error_deg} degrees");
    // Negative control: in a second, about its light time, the Moon moves by some tenths of an arcsecond.
    assert!(motion_in_a_second_deg > 5e-5, "{motion_in_a_second_deg} degrees");
}

fn seconds_apart(found: Instant, published: &str) -> f64 {
    found.tdb_seconds_past_j2000() - Instant::parse(published).expect(published).tdb_seconds_past_j2000()
}

/// Sunrise and sunset in Greenwich at the summer solstice of 2024: 03:43 and 20:21 UT (HM Nautical Almanac Office, to the minute).
#[test]
fn the_sun_rises_and_sets_as_in_the_almanac() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    let place = Observer { body: NaifId::EARTH, lat_graphic_deg: 51.4769, lon_east_deg: 0.0, height_km: 0.0 };
    let sky = ObserverSky { catalog: &catalog, ephemeris: &ephemeris, place };
    let sun_times = sky.rise_set_times(NaifId::SUN, Instant::parse("2024-06-20T00:00:00Z").expect("a day"), 86_400.0).expect("a day");
    // Rounding to the minute changes a time by up to 30 s.
    assert!(seconds_apart(sun_times.rise.expect("a sunrise"), "2024-06-20T03:43:00Z").abs() < 32.0);
    assert!(seconds_apart(sun_times.set.expect("a sunset"), "2024-06-20T20:21:00Z").abs() < 32.0);
    let (noon, altitude_deg) = sun_times.transit.expect("noon");
    // At noon: 90 degrees - latitude + obliquity. The equation of time is -1 min 43 s (Meeus, Astronomical Algorithms, chapter 28).
    assert!((altitude_deg - (90.0 - 51.4769 + 23.438)).abs() < 0.003, "{altitude_deg}");
    assert!(seconds_apart(noon, "2024-06-20T12:01:43Z").abs() < 3.0, "{}", noon.to_utc_iso());
    assert!(!sun_times.is_up_at_start);
    // Beyond the polar circle the Sun does not set.
    let arctic = ObserverSky { place: Observer { lat_graphic_deg: 78.0, ..place }, ..sky };
    let polar_day = arctic.rise_set_times(NaifId::SUN, Instant::parse("2024-06-20T00:00:00Z").expect("a day"), 86_400.0).expect("a day");
    assert_eq!((polar_day.rise, polar_day.set, polar_day.is_up_at_start), (None, None, true));
}

/// The error names the barycentre as the user did, not by its code.
#[test]
fn a_barycentre_has_no_altitude() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    let place = Observer { body: NaifId::EARTH, lat_graphic_deg: 48.0, lon_east_deg: 11.0, height_km: 0.0 };
    let sky = ObserverSky { catalog: &catalog, ephemeris: &ephemeris, place };
    let noon = Instant::parse("2024-01-01T12:00:00Z").expect("a time");
    let error = sky.topocentric(NaifId(4), noon).expect_err("a barycentre").to_string();
    assert!(error.starts_with("Mars's barycentre has no disc"), "{error}");
}

/// NASA's table gives 12:23, 13:40, 13:42, 13:44 and 15:02 CDT, truncated to the minute; each is compared with the middle of its minute.
#[test]
fn local_contacts_of_the_eclipse_of_2024_in_dallas_agree_with_nasa() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    let place = Observer { body: NaifId::EARTH, lat_graphic_deg: 32.7767, lon_east_deg: -96.797, height_km: 0.13 };
    let sky = ObserverSky { catalog: &catalog, ephemeris: &ephemeris, place };
    let start = Instant::parse("2024-04-08T06:00:00Z").expect("a morning");
    let passage = sky.passage(NaifId::SUN, NaifId::MOON, start, 86_400.0).expect("places").expect("an eclipse");
    let (second_contact, third_contact) = passage.inner.expect("totality");
    let outer_contacts = |p: &DiscPassage| (p.begins.expect("a first contact"), p.ends.expect("a last contact"));
    let (begins, ends) = outer_contacts(&passage);
    for (found, minute) in [
        (begins, "2024-04-08T17:23:30Z"),
        (second_contact, "2024-04-08T18:40:30Z"),
        (passage.greatest, "2024-04-08T18:42:30Z"),
        (third_contact, "2024-04-08T18:44:30Z"),
        (ends, "2024-04-08T20:02:30Z"),
    ] {
        assert!(seconds_apart(found, minute).abs() < 40.0, "{} against {minute}", found.to_utc_iso());
    }
    assert!(passage.magnitude > 1.0 && passage.altitude_deg > 60.0, "{passage:?}");
    // A day that ends before totality, or begins after it, has the same eclipse with the same greatest phase.
    for start in ["2024-04-07T18:00:00Z", "2024-04-08T19:30:00Z"] {
        let of_day = sky.passage(NaifId::SUN, NaifId::MOON, Instant::parse(start).expect(start), 86_400.0).expect("places").expect(start);
        let (first, last) = outer_contacts(&of_day);
        for (found, whole) in [(first, begins), (of_day.greatest, passage.greatest), (last, ends)] {
            let apart_s = found.tdb_seconds_past_j2000() - whole.tdb_seconds_past_j2000();
            assert!(apart_s.abs() < 1.0, "{start}: {} is {apart_s} s away", found.to_utc_iso());
        }
        assert!((of_day.magnitude - passage.magnitude).abs() < 1e-5 && of_day.inner.is_some(), "{start}: {of_day:?}");
    }
    // A span that ends ten seconds before the eclipse begins has none. Its length, 990 s, is no multiple of the search's step.
    let before = begins.plus_seconds(-1000.0);
    assert_eq!(sky.passage(NaifId::SUN, NaifId::MOON, before, 990.0).expect("places"), None);
    assert!(sky.passage(NaifId::SUN, NaifId::MOON, before, 1010.0).expect("places").is_some());
    // At the preceding new moon there is no eclipse.
    let march = Instant::parse("2024-03-10T00:00:00Z").expect("a day");
    assert_eq!(sky.passage(NaifId::SUN, NaifId::MOON, march, 86_400.0).expect("places"), None);
}

/// Greatest eclipse: time (UT), latitude, east longitude, magnitude, central duration in seconds, from NASA's Five Millennium Canon (F.
/// Espenak and J. Meeus; its pages of Besselian elements, read in the copy of the package astronomy-bundle-php). Its radius of the Moon
/// for the umbra (k) is 0.272281 radii of the Earth. Positions are rounded to 0.1 degrees, durations to 1 s.
const CANON: [(&str, f64, f64, f64, f64); 7] = [
    ("1991-07-11T19:06:03Z", 22.0, -105.2, 1.0800, 413.0),
    ("2009-07-22T02:35:18Z", 24.2, 144.1, 1.0799, 399.0),
    ("2010-01-15T07:06:32Z", 1.6, 69.3, 0.9190, 668.0),
    ("2017-08-21T18:25:30Z", 37.0, -87.7, 1.0306, 160.0),
    ("2020-12-14T16:13:27Z", -40.3, -67.9, 1.0254, 130.0),
    ("2023-10-14T17:59:27Z", 11.4, -83.1, 0.9520, 317.0),
    ("2024-04-08T18:17:15Z", 25.3, -104.1, 1.0566, 268.0),
];

/// Magnitude and duration in seconds of the longest central phase near a position, as the canon's positions are rounded and the duration is
/// longest on the central line.
fn longest_central_duration(catalog: &Catalog, ephemeris: &Ephemeris, start: Instant, latitude_deg: f64, longitude_deg: f64) -> (f64, f64) {
    let offsets = [-0.05, 0.0, 0.05];
    let places = offsets.iter().flat_map(|north| offsets.map(|east| (latitude_deg + north, longitude_deg + east)));
    let found = places.map(|(latitude_deg, longitude_deg)| {
        let place = Observer { body: NaifId::EARTH, lat_graphic_deg: latitude_deg, lon_east_deg: longitude_deg, height_km: 0.0 };
        let passage = ObserverSky { catalog, ephemeris, place }
            .passage(NaifId::SUN, NaifId::MOON, start, 1200.0)
            .expect("places")
            .expect("an eclipse");
        let (second, third) = passage.inner.expect("a central eclipse");
        (passage.magnitude, third.tdb_seconds_past_j2000() - second.tdb_seconds_past_j2000())
    });
    found.max_by(|a, b| a.1.total_cmp(&b.1)).expect("places")
}

#[test]
fn almanac_radii_give_the_canons_magnitudes_and_durations() {
    let iau = Catalog::embedded();
    let almanac = Catalog::embedded().with_eclipse_radii(EclipseRadii::Almanac);
    let ephemeris = Ephemeris::embedded(&iau).expect("the shipped ephemeris");
    let mut failures = Vec::new();
    for (greatest, latitude_deg, longitude_deg, magnitude, duration_s) in CANON {
        let start = Instant::parse(greatest).expect(greatest).plus_seconds(-600.0);
        let (almanac_magnitude, almanac_duration_s) = longest_central_duration(&almanac, &ephemeris, start, latitude_deg, longitude_deg);
        let (iau_magnitude, iau_duration_s) = longest_central_duration(&iau, &ephemeris, start, latitude_deg, longitude_deg);
        println!("{greatest}: almanac {almanac_magnitude}, {almanac_duration_s} s, IAU {iau_magnitude}, {iau_duration_s} s");
        println!("{greatest}: canon {magnitude}, {duration_s} s");
        if (almanac_magnitude - magnitude).abs() > 2e-4 || (almanac_duration_s - duration_s).abs() > 1.5 {
            failures.push(format!("{greatest}: {almanac_magnitude}, {almanac_duration_s} s, the canon has {magnitude}, {duration_s} s"));
        }
        // With the IAU's Moon, which is larger, totality is longer by seconds, and annularity shorter.
        let longer_s = (iau_duration_s - almanac_duration_s) * (magnitude - 1.0).signum();
        assert!((2.5..12.0).contains(&longer_s), "{greatest}: {longer_s} s");
        assert!((6e-4..12e-4).contains(&(iau_magnitude - almanac_magnitude)), "{greatest}");
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
