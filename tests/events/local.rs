//! Local circumstances: contacts against a topocentric search with discs, a published totality, eclipses cut off by sunrise or moonrise,
//! paths on the ground.

use super::{ALMANAC_RADII, EPHEMERIS, IAU_RADII, parse_time, seconds_after};
use orrery::Catalog;
use orrery::catalog::NaifId;
use orrery::ephemeris::topocentric::{Observer, ObserverSky};
use orrery::events::{GeodeticPosition, SolarEclipse, lunar_eclipses, solar_eclipses};

fn place(latitude_deg: f64, longitude_deg: f64) -> GeodeticPosition {
    GeodeticPosition { latitude_deg, longitude_deg, height_km: 0.0 }
}

fn eclipse_of(catalog: &Catalog, day: &str) -> SolarEclipse {
    let from = parse_time(day);
    solar_eclipses(catalog, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("eclipses").remove(0)
}

fn sky(place: GeodeticPosition) -> ObserverSky<'static> {
    let place = Observer {
        body: NaifId::EARTH,
        lat_graphic_deg: place.latitude_deg,
        lon_east_deg: place.longitude_deg,
        height_km: place.height_km,
    };
    ObserverSky { catalog: &IAU_RADII, ephemeris: &EPHEMERIS, place }
}

#[test]
fn local_contacts_agree_with_a_topocentric_search() {
    // Day, and places inside and outside the path. The topocentric search shares neither frame nor polynomials with the events.
    let cases = [
        ("2024-04-08", [(32.7767, -96.797), (25.2897, -104.1477), (45.0, -60.0), (10.0, -110.0)]),
        ("2020-06-21", [(30.5194, 79.6652), (0.0, 60.0), (20.0, 100.0), (40.0, 30.0)]),
        ("2021-12-04", [(-76.777, -46.216), (-70.0, 0.0), (-80.0, 120.0), (-55.0, -60.0)]),
    ];
    let mut central_count = 0;
    for (day, places) in cases {
        let e = eclipse_of(&IAU_RADII, day);
        for (lat, lon) in places {
            let observer = place(lat, lon);
            let circumstances = e.seen_from(observer);
            let by_discs =
                sky(observer).passage(NaifId::SUN, NaifId::MOON, e.greatest.plus_seconds(-4.0 * 3600.0), 8.0 * 3600.0).expect("places");
            assert_eq!(circumstances.is_some(), by_discs.is_some(), "{day} {lat} {lon}");
            let (Some(circumstances), Some(by_discs)) = (circumstances, by_discs) else { continue };
            let mut expected: Vec<_> = [by_discs.begins, by_discs.ends].into_iter().flatten().collect();
            expected.splice(1..1, by_discs.inner.into_iter().flat_map(|(a, b)| [a, b]));
            assert_eq!(circumstances.contacts.len(), expected.len(), "{day} {lat} {lon}");
            central_count += usize::from(by_discs.inner.is_some());
            for (contact, t) in circumstances.contacts.iter().zip(expected) {
                let error_s = seconds_after(contact.time, t);
                assert!(error_s.abs() < 0.2, "{day} {lat} {lon} {}: {error_s} s", contact.name);
            }
        }
    }
    assert!(central_count >= 3, "{central_count} of the places are in a path");
}

/// Prediction for Longyearbyen (78.22 N, 15.65 E) by svalbard2015.no: totality from 10:10:42.8 to 10:13:10.2 UT, altitude 11.2 to 11.3 degrees.
#[test]
fn the_eclipse_of_2015_is_total_at_longyearbyen() {
    let circumstances = eclipse_of(&ALMANAC_RADII, "2015-03-20").seen_from(place(78.22, 15.65)).expect("an eclipse");
    let names: Vec<_> = circumstances.contacts.iter().map(|c| c.name).collect();
    assert_eq!(names, ["C1", "C2", "C3", "C4"]);
    assert!(
        seconds_after(circumstances.contacts[1].time, parse_time("2015-03-20T10:10:42.8Z")).abs() < 3.0,
        "{}",
        circumstances.contacts[1].time.to_utc_iso()
    );
    assert!(
        seconds_after(circumstances.contacts[2].time, parse_time("2015-03-20T10:13:10.2Z")).abs() < 3.0,
        "{}",
        circumstances.contacts[2].time.to_utc_iso()
    );
    assert!(circumstances.is_visible && circumstances.magnitude > 1.0 && circumstances.obscuration == Some(1.0));
    assert!((circumstances.maximum.altitude_deg - 11.25).abs() < 0.1, "{}", circumstances.maximum.altitude_deg);
    assert!((circumstances.central_duration_s.expect("totality") - 147.4).abs() < 1.0);
    // In Tromsø, 950 km to the south, a sliver of the Sun remains.
    let tromso = eclipse_of(&ALMANAC_RADII, "2015-03-20").seen_from(place(69.65, 18.96)).expect("an eclipse");
    assert!(tromso.central_duration_s.is_none() && (0.9..1.0).contains(&tromso.magnitude), "{}", tromso.magnitude);
}

#[test]
fn at_sunrise_only_the_remainder_of_the_eclipse_is_visible() {
    let new_york = place(40.71, -74.01);
    let e = eclipse_of(&IAU_RADII, "2021-06-10");
    let circumstances = e.seen_from(new_york).expect("an eclipse");
    let rise = circumstances.rise.expect("a sunrise");
    // The search for risings leaves out aberration.
    let by_search =
        sky(new_york).rise_set_times(NaifId::SUN, parse_time("2021-06-10T04:00:00Z"), 43_200.0).expect("a day").rise.expect("a sunrise");
    assert!(seconds_after(rise, by_search).abs() < 6.0, "{} {}", rise.to_utc_iso(), by_search.to_utc_iso());
    assert!(!circumstances.contacts[0].is_up() && circumstances.contacts[1].is_up(), "only first contact must be before sunrise");
    assert!(seconds_after(circumstances.maximum.time, rise) >= 0.0 && circumstances.is_visible);
    assert!((circumstances.magnitude - 0.80).abs() < 0.005, "{}", circumstances.magnitude);
    // Further west the greatest phase is before sunrise, so the greatest visible phase is at sunrise.
    let west = e.seen_from(place(40.71, -82.0)).expect("an eclipse");
    assert!(west.is_visible && seconds_after(west.maximum.time, west.rise.expect("a sunrise")).abs() < 1e-3);
    assert!(west.magnitude < e.seen_from(new_york).expect("an eclipse").magnitude);
    // Where the Sun rises after last contact, the eclipse is not visible.
    let far_west = e.seen_from(place(40.71, -110.0));
    assert!(far_west.is_none_or(|circumstances| !circumstances.is_visible));
}

#[test]
fn a_lunar_eclipse_is_visible_only_where_the_moon_is_up() {
    let from = parse_time("2018-07-27");
    let e = lunar_eclipses(&IAU_RADII, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("eclipses").remove(0);
    let berlin = e.seen_from(place(52.52, 13.4));
    // The Moon rises in the partial phase. The search for risings leaves out aberration; with a semidiameter of 16 arcmin instead of 14.8 it would differ by
    // 9 s.
    let rise = berlin.rise.expect("a moonrise");
    let by_search = sky(place(52.52, 13.4))
        .rise_set_times(NaifId::MOON, parse_time("2018-07-27T12:00:00Z"), 43_200.0)
        .expect("a day")
        .rise
        .expect("a moonrise");
    assert!(seconds_after(rise, by_search).abs() < 4.0, "{} {}", rise.to_utc_iso(), by_search.to_utc_iso());
    assert!(seconds_after(rise, e.contacts[1].1) > 0.0 && seconds_after(rise, e.contacts[2].1) < 0.0);
    assert!(berlin.is_visible && !berlin.contacts[0].is_up() && berlin.maximum.altitude_deg > 0.0);
    assert!((berlin.magnitude - e.umbral_magnitude).abs() < 1e-6);
    let overhead = e.seen_from(e.place);
    assert!(overhead.maximum.altitude_deg > 89.0);
    assert!(!e.seen_from(place(-e.place.latitude_deg, e.place.longitude_deg + 180.0)).is_visible);
}

/// At 65 degrees of latitude the Moon sinks by 2.9 arcsec a second: with a semidiameter of 16 arcmin it would set 29 s after `ephemeris --rise-set`.
#[test]
fn the_moon_of_an_eclipse_sets_when_its_upper_limb_does() {
    let from = parse_time("2030-12-09");
    let e = lunar_eclipses(&IAU_RADII, &EPHEMERIS, from, from.plus_seconds(2.0 * 86_400.0)).expect("eclipses").remove(0);
    let observer = place(65.0, -180.0);
    let circumstances = e.seen_from(observer);
    let set = circumstances.set.expect("a moonset");
    let by_search =
        sky(observer).rise_set_times(NaifId::MOON, parse_time("2030-12-09T19:00:00Z"), 86_400.0).expect("a day").set.expect("a moonset");
    // Aberration, which the search leaves out, is at most 20.5 arcsec.
    assert!(seconds_after(set, by_search).abs() < 20.5 / 2.9, "{} {}", set.to_utc_iso(), by_search.to_utc_iso());
    assert!(circumstances.maximum.is_up() && (circumstances.maximum.semidiameter_deg - 0.24498).abs() < 1e-4, "{circumstances:?}");
}

/// In Greenwich the Moon set before the greatest eclipse of 2024-03-25, so the best of it was at moonset.
#[test]
fn a_maximum_at_moonset_is_not_below_the_horizon() {
    let from = parse_time("2024-03-25");
    let e = lunar_eclipses(&IAU_RADII, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("eclipses").remove(0);
    let greenwich = e.seen_from(place(51.4769, 0.0));
    let set = greenwich.set.expect("a moonset");
    assert!(greenwich.is_visible && seconds_after(greenwich.maximum.time, set).abs() < 1e-3);
    assert!(greenwich.maximum.is_up(), "{} degrees", greenwich.maximum.altitude_deg);
    assert!(greenwich.contacts.iter().any(|contact| !contact.is_up()), "the Moon must be down at the end");
}

/// In Lima the Moon rises between U4 (22:19 UT) and P4 (23:29), when only the penumbra is left.
#[test]
fn a_moon_that_rises_after_the_umbral_phase_has_a_penumbral_magnitude() {
    let from = parse_time("2018-07-27");
    let e = lunar_eclipses(&IAU_RADII, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("eclipses").remove(0);
    let lima = e.seen_from(place(-12.05, -77.04));
    let (rise, [u4, p4]) =
        (lima.rise.expect("a moonrise"), ["U4", "P4"].map(|name| lima.contacts.iter().find(|c| c.name == name).expect("a contact")));
    assert!(lima.is_visible && !u4.is_up() && p4.is_up());
    // Near the end the magnitude falls almost linearly, from 1.07 at U4, the Sun's diameter over the Moon's, to 0 at P4.
    let expected = 1.07 * seconds_after(p4.time, rise) / seconds_after(p4.time, u4.time);
    let penumbral = lima.penumbral_magnitude.expect("an eclipse of the Moon");
    assert!(lima.magnitude < 0.0 && (penumbral - expected).abs() < 0.05, "{} {penumbral} for {expected}", lima.magnitude);
    assert_eq!(eclipse_of(&IAU_RADII, "2024-04-08").seen_from(place(32.7767, -96.797)).expect("an eclipse").penumbral_magnitude, None);
}

#[test]
fn the_eclipse_is_central_only_between_the_limits_of_the_path() {
    // Widths at greatest eclipse from the canon, in whole kilometres, with its radii.
    for (day, width_km) in [("2024-04-08", 198.0), ("2017-08-21", 115.0)] {
        let e = eclipse_of(&ALMANAC_RADII, day);
        let path = e.path().expect("a path");
        assert!(path.centre_line.len() > 100 && path.northern_limit.len() > 100 && path.southern_limit.len() > 100);
        let is_central = |p: GeodeticPosition| e.seen_from(p).is_some_and(|s| s.central_duration_s.is_some());
        for (_, centre) in path.centre_line.iter().skip(5).step_by(10).take(10) {
            assert!(is_central(*centre), "{day} {centre:?}");
        }
        for (limit, outward) in [(&path.northern_limit, 1.0), (&path.southern_limit, -1.0)] {
            for p in limit.iter().skip(10).step_by(20).take(4) {
                let moved = |degrees: f64| GeodeticPosition { latitude_deg: p.latitude_deg + outward * degrees, ..*p };
                assert!(is_central(moved(-0.01)) && !is_central(moved(0.01)), "{day} {p:?}");
            }
        }
        // The width across the path at greatest eclipse.
        let nearest = |limit: &[GeodeticPosition]| limit.iter().map(|p| km_between(*p, e.place)).fold(f64::MAX, f64::min);
        let across_km = nearest(&path.northern_limit) + nearest(&path.southern_limit);
        assert!((across_km - width_km).abs() < 1.0, "{day}: {across_km} km");
    }
    assert!(eclipse_of(&IAU_RADII, "2018-02-15").path().is_none());
}

/// An antumbra that grazes the ground has only one limit on it, which may be the southern one in northern latitudes.
#[test]
fn the_only_limit_of_a_grazing_path_is_named_by_its_side() {
    let path = eclipse_of(&IAU_RADII, "1529-11-11").path().expect("a path");
    assert!(
        path.northern_limit.is_empty() && path.southern_limit.len() > 100,
        "{} {}",
        path.northern_limit.len(),
        path.southern_limit.len()
    );
    for (p, (_, centre)) in path.southern_limit.iter().zip(&path.centre_line) {
        assert!(p.latitude_deg < centre.latitude_deg && p.latitude_deg > 0.0, "{p:?} {centre:?}");
    }
}

/// An antumbra that grazes the ground reaches far from the centre line, and places there see it up to half an hour earlier or later than the centre line: a
/// limit has a point where the Sun is up at that time. The side in darkness has none.
#[test]
fn a_limit_far_from_the_centre_line_is_found_where_it_is_sunlit() {
    let path = eclipse_of(&IAU_RADII, "-0084-07-16").path().expect("a path");
    let counts = (path.centre_line.len(), path.northern_limit.len(), path.southern_limit.len());
    assert_eq!(counts, (121, 121, 0));
    let e = eclipse_of(&IAU_RADII, "-2311-08-18");
    let path = e.path().expect("a path");
    assert!(path.northern_limit.len() > 115, "{}", path.northern_limit.len());
    for p in path.northern_limit.iter().chain(&path.southern_limit) {
        let circumstances = e.seen_from(*p).expect("an eclipse");
        // At the limit itself the central phase lasts a moment, or, by rounding, not at all.
        let greatest = circumstances.contacts.iter().find(|c| c.name == "C2").unwrap_or(&circumstances.maximum);
        assert!(greatest.altitude_deg > -1.1, "{p:?}: {}", greatest.altitude_deg);
    }
}

fn km_between(a: GeodeticPosition, b: GeodeticPosition) -> f64 {
    let (lat, dlat) = (a.latitude_deg.to_radians(), (b.latitude_deg - a.latitude_deg).to_radians());
    let dlon = (b.longitude_deg - a.longitude_deg).to_radians() * (lat + 0.5 * dlat).cos();
    6371.0 * dlat.hypot(dlon)
}
