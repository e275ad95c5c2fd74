//! Positions against JPL DE440 (tests/data/ephemeris_public.json; km, km/s, ICRF, TDB).

use crate::support::folds::larger;
use glam::DVec3;
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::{Ephemeris, Source};
use orrery::time::Instant;
use orrery::units::{RAD_PER_ARCSEC, SPEED_OF_LIGHT_KM_S};
use serde_json::Value;

/// Names in the table, and NAIF codes.
const BODIES: &[(&str, i32)] = &[
    ("mercury", 199),
    ("venus", 299),
    ("earth", 399),
    ("moon", 301),
    ("earth_moon_barycenter", 3),
    ("mars_barycenter", 4),
    ("jupiter_barycenter", 5),
    ("saturn_barycenter", 6),
    ("uranus_barycenter", 7),
    ("neptune_barycenter", 8),
    ("pluto_barycenter", 9),
];

/// An epoch of the table. Positions in km, velocities in km/s.
struct Epoch {
    t: Instant,
    jd_tdb: f64,
    /// Name, id, position and velocity.
    heliocentric: Vec<(&'static str, NaifId, DVec3, DVec3)>,
    moon_geocentric: DVec3,
    sun_barycentric: DVec3,
}

fn vector(v: &Value) -> DVec3 {
    let component = |i: usize| v[i].as_f64().expect("a number");
    DVec3::new(component(0), component(1), component(2))
}

fn epochs() -> Vec<Epoch> {
    let text = include_str!("../data/ephemeris_public.json");
    let table: Value = serde_json::from_str(text).expect("the reference is JSON");
    let read = |e: &Value| {
        let jd_tdb = e["jd_tdb"].as_f64().expect("jd_tdb");
        let heliocentric = |&(name, id): &(&'static str, i32)| {
            let state = &e["heliocentric"][name];
            (name, NaifId(id), vector(&state["pos_km"]), vector(&state["vel_km_s"]))
        };
        Epoch {
            t: Instant::from_jd_tdb(jd_tdb),
            jd_tdb,
            heliocentric: BODIES.iter().map(heliocentric).collect(),
            moon_geocentric: vector(&e["moon_geocentric"]["pos_km"]),
            sun_barycentric: vector(&e["barycentric"]["sun"]["pos_km"]),
        }
    };
    table["epochs"].as_array().expect("epochs").iter().map(read).collect()
}

/// Angle between two directions, from the chord.
fn separation_arcsec(a: DVec3, b: DVec3) -> f64 {
    2.0 * (0.5 * (a.normalize() - b.normalize()).length()).asin() / RAD_PER_ARCSEC
}

fn ephemeris() -> Ephemeris {
    Ephemeris::embedded(&Catalog::embedded()).expect("the shipped kernel is whole")
}

/// Julian dates of the span of the shipped kernel, 1900 to 2100.
const KERNEL_SPAN: std::ops::RangeInclusive<f64> = 2_415_020.5..=2_488_069.5;

#[test]
fn the_kernel_keeps_its_stated_errors_at_every_reference_epoch() {
    let ephemeris = ephemeris();
    let mut compared = 0;
    for epoch in epochs().iter().filter(|e| KERNEL_SPAN.contains(&e.jd_tdb)) {
        compared += 1;
        let moon = ephemeris.state(NaifId::MOON, NaifId::EARTH, epoch.t, Some(Source::Kernel)).expect("Moon").state;
        assert!(
            (moon.pos_km - epoch.moon_geocentric).length() < 0.1,
            "{}: Moon {}",
            epoch.jd_tdb,
            (moon.pos_km - epoch.moon_geocentric).length()
        );
        let sun = ephemeris.state(NaifId::SUN, NaifId(0), epoch.t, None).expect("Sun");
        assert!((sun.state.pos_km - epoch.sun_barycentric).length() < sun.error_km);
        for &(name, id, pos_km, vel_km_s) in &epoch.heliocentric {
            let answer = ephemeris.state(id, NaifId::SUN, epoch.t, None).expect(name);
            let (deviation_km, angle_arcsec) = ((answer.state.pos_km - pos_km).length(), separation_arcsec(answer.state.pos_km, pos_km));
            assert_eq!(answer.source, Source::Kernel);
            assert!(angle_arcsec < 0.02, "{} {name}: {angle_arcsec} arcsec", epoch.jd_tdb);
            assert!(deviation_km < answer.error_km, "{} {name}: {deviation_km} km, stated {}", epoch.jd_tdb, answer.error_km);
            let speed_error = (answer.state.vel_km_s - vel_km_s).length();
            assert!(speed_error < 1e-4, "{} {name}: velocity off by {speed_error} km/s", epoch.jd_tdb);
        }
    }
    assert!(compared >= 10, "only {compared} reference epochs in the kernel's span");
}

#[test]
fn the_comparison_detects_an_error() {
    let ephemeris = ephemeris();
    let epochs = epochs();
    let epoch = epochs.iter().find(|e| KERNEL_SPAN.contains(&e.jd_tdb)).expect("an epoch in the span");
    // In a second the Moon moves by a kilometre, in a minute Mercury moves by 10 arcsec.
    let late = ephemeris.state(NaifId::MOON, NaifId::EARTH, epoch.t.plus_seconds(1.0), None).expect("Moon").state;
    assert!((late.pos_km - epoch.moon_geocentric).length() > 0.1);
    let (_, id, pos_km, _) = epoch.heliocentric[0];
    let late = ephemeris.state(id, NaifId::SUN, epoch.t.plus_seconds(60.0), None).expect("Mercury").state;
    assert!(separation_arcsec(late.pos_km, pos_km) > 0.02);
}

#[test]
fn relative_positions_are_differences_of_barycentric_positions() {
    let ephemeris = ephemeris();
    let t = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
    for (a, b) in [(301, 10), (399, 301), (5, 199), (0, 10), (3, 3), (599, 301)] {
        let pair = ephemeris.state(NaifId(a), NaifId(b), t, None).expect("a pair").state;
        let back = ephemeris.state(NaifId(b), NaifId(a), t, None).expect("a pair").state;
        let barycentric_km = |id| ephemeris.state(NaifId(id), NaifId(0), t, None).expect("a place").state.pos_km;
        assert!((pair.pos_km + back.pos_km).length() < 1e-6);
        assert!((pair.pos_km - (barycentric_km(a) - barycentric_km(b))).length() < 1e-6);
    }
}

#[test]
fn velocities_are_slopes_of_positions() {
    let ephemeris = ephemeris();
    let t = Instant::parse("1969-07-20T20:17:40Z").expect("a time");
    for id in [10, 199, 299, 399, 301, 4, 5, 9, 401] {
        let now = ephemeris.state(NaifId(id), NaifId(0), t, None).expect("a place");
        let position_at = |s: f64| ephemeris.state(NaifId(id), NaifId(0), t.plus_seconds(s), None).expect("a place").state.pos_km;
        let slope = (position_at(16.0) - position_at(-16.0)) / 32.0;
        assert!((slope - now.state.vel_km_s).length() < 2e-4, "{id}: {slope} {}", now.state.vel_km_s);
    }
}

#[test]
fn light_time_equals_distance_over_the_speed_of_light() {
    let ephemeris = ephemeris();
    let t = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
    let earth = ephemeris.state(NaifId::EARTH, NaifId(0), t, None).expect("Earth").state.pos_km;
    for id in [10, 301, 5, 9] {
        let (pos_km, emitted) = ephemeris.light_time_position(NaifId(id), earth, t).expect("a place");
        let travelled_km = (t.tdb_seconds_past_j2000() - emitted.tdb_seconds_past_j2000()) * SPEED_OF_LIGHT_KM_S;
        assert!((travelled_km - (pos_km - earth).length()).abs() < 1.0, "{id}");
        let there = ephemeris.state(NaifId(id), NaifId(0), emitted, None).expect("a place").state.pos_km;
        assert!((there - pos_km).length() < 1e-3, "{id}");
    }
}

#[test]
fn series_stay_within_30_arcsec_from_1600_to_2500() {
    let ephemeris = ephemeris();
    for epoch in epochs() {
        let moon = ephemeris.state(NaifId::MOON, NaifId::EARTH, epoch.t, Some(Source::Series)).expect("Moon");
        let deviation_km = (moon.state.pos_km - epoch.moon_geocentric).length();
        assert!(
            separation_arcsec(moon.state.pos_km, epoch.moon_geocentric) < 30.0 && deviation_km < moon.error_km,
            "{}: Moon {deviation_km} km",
            epoch.jd_tdb
        );
        for &(name, id, pos_km, vel_km_s) in &epoch.heliocentric {
            let answer = ephemeris.state(id, NaifId::SUN, epoch.t, Some(Source::Series)).expect(name);
            let deviation_km = (answer.state.pos_km - pos_km).length();
            assert_eq!(answer.source, Source::Series);
            assert!(separation_arcsec(answer.state.pos_km, pos_km) < 30.0, "{} {name}: {deviation_km} km", epoch.jd_tdb);
            assert!(deviation_km < answer.error_km, "{} {name}: {deviation_km} km, stated {}", epoch.jd_tdb, answer.error_km);
            assert!((answer.state.vel_km_s - vel_km_s).length() < 3e-3, "{} {name}: {}", epoch.jd_tdb, answer.state.vel_km_s);
        }
    }
}

#[test]
fn mean_elements_keep_their_stated_error() {
    let ephemeris = ephemeris();
    for epoch in epochs() {
        let moon = ephemeris.state(NaifId::MOON, NaifId::EARTH, epoch.t, Some(Source::Mean)).expect("Moon");
        assert!((moon.state.pos_km - epoch.moon_geocentric).length() < moon.error_km, "{}: Moon", epoch.jd_tdb);
        for &(name, id, pos_km, _) in &epoch.heliocentric {
            let answer = ephemeris.state(id, NaifId::SUN, epoch.t, Some(Source::Mean)).expect(name);
            let deviation_km = (answer.state.pos_km - pos_km).length();
            assert!(deviation_km < answer.error_km, "{} {name}: {deviation_km} km, stated {}", epoch.jd_tdb, answer.error_km);
        }
    }
    // Far from the reference epochs, the series (VSOP87) is the reference.
    for year in [-2999, -2500, -2000, -1000, 0, 1000, 2999] {
        let sign = if year < 0 { "-" } else { "" };
        let t = Instant::parse(&format!("{sign}{:04}-06-01T00:00:00Z", i32::abs(year))).expect("a time");
        for id in 1..=8 {
            let state = |source| ephemeris.state(NaifId(id), NaifId::SUN, t, Some(source)).expect("a planet");
            let (mean, series) = (state(Source::Mean), state(Source::Series));
            let deviation_km = (mean.state.pos_km - series.state.pos_km).length();
            assert!(deviation_km < mean.error_km + series.error_km, "{year} {id}: {deviation_km} km, stated {}", mean.error_km);
        }
    }
}

/// For every body and source at an epoch: a label, the deviation from the reference in km, and the stated error in km.
fn deviations(ephemeris: &Ephemeris, epoch: &Epoch) -> Vec<(String, f64, f64)> {
    let mut deviations = Vec::new();
    for source in [Source::Mean, Source::Series, Source::Kernel] {
        let mut compare = |name: &str, body: NaifId, center: NaifId, reference: DVec3| {
            if let Ok(answer) = ephemeris.state(body, center, epoch.t, Some(source)) {
                let deviation_km = (answer.state.pos_km - reference).length();
                deviations.push((format!("{} {name} by {source:?}", epoch.jd_tdb), deviation_km, answer.error_km));
            }
        };
        compare("sun", NaifId::SUN, NaifId::SOLAR_SYSTEM_BARYCENTER, epoch.sun_barycentric);
        compare("moon", NaifId::MOON, NaifId::EARTH, epoch.moon_geocentric);
        for &(name, id, pos_km, _) in &epoch.heliocentric {
            compare(name, id, NaifId::SUN, pos_km);
            compare(name, id, NaifId::SOLAR_SYSTEM_BARYCENTER, pos_km + epoch.sun_barycentric);
        }
    }
    deviations
}

#[test]
fn every_source_keeps_its_stated_error_at_every_reference_epoch() {
    let ephemeris = ephemeris();
    let found: Vec<_> = epochs().iter().flat_map(|epoch| deviations(&ephemeris, epoch)).collect();
    // 24 positions at every epoch by two sources, and by the kernel within its span.
    assert!(found.len() > 30 * 24 * 2 + 10 * 24, "{}", found.len());
    let exceeding = |factor: f64| found.iter().filter(|(_, deviation_km, error_km)| *deviation_km >= factor * error_km).collect::<Vec<_>>();
    assert!(exceeding(1.0).is_empty(), "{:?}", exceeding(1.0));
    // The stated errors are not too generous: every source exceeds a third of some of them.
    for source in ["Mean", "Series", "Kernel"] {
        assert!(exceeding(1.0 / 3.0).iter().any(|(label, ..)| label.ends_with(source)), "{source}");
    }
}

#[test]
fn dates_outside_every_theory_give_an_error_and_never_nan() {
    let (ephemeris, catalog) = (ephemeris(), Catalog::embedded());
    for jd in [-1_930_000.0, 5_373_484.5, 1e9, -1e9, 1e300, -1e300, f64::INFINITY, f64::NAN] {
        let t = Instant::from_jd_tdb(jd);
        let body_ids = catalog.bodies().iter().map(|b| b.id).chain((0..10).map(NaifId));
        for id in body_ids {
            for source in [None, Some(Source::Mean), Some(Source::Series), Some(Source::Kernel)] {
                let center = catalog.body(id).and_then(|b| b.parent).unwrap_or(NaifId::SUN);
                match ephemeris.state(id, center, t, source) {
                    Ok(answer) => assert!(
                        answer.state.pos_km.is_finite() && answer.state.vel_km_s.is_finite() && !answer.error_km.is_nan(),
                        "{id:?} {jd}"
                    ),
                    Err(e) => assert!(!e.to_string().contains('\n')),
                }
            }
            if let Ok(rotation) = ephemeris.body_from_icrf(id, t) {
                assert!((rotation.determinant() - 1.0).abs() < 1e-9, "{id:?} {jd}");
            }
        }
        assert!(ephemeris.state(NaifId::EARTH, NaifId::SUN, t, None).is_err());
        assert!(jd.abs() < 1e8 || ephemeris.state(NaifId(501), NaifId(599), t, None).is_err());
        assert!(!t.to_utc_iso().is_empty());
    }
    // A date that a theory covers is accepted.
    assert!(ephemeris.state(NaifId::EARTH, NaifId::SUN, Instant::from_jd_tdb(2_000_000.0), None).is_ok());
}

#[test]
fn the_best_source_that_covers_the_date_is_used() {
    let ephemeris = ephemeris();
    for (time, body, source) in [
        ("2024-04-08T18:17:16Z", 399, Source::Kernel),
        ("1900-01-01T00:00:00Z", 301, Source::Kernel),
        ("2099-12-31T23:59:59Z", 301, Source::Kernel),
        ("1750-01-01T00:00:00Z", 301, Source::Series),
        ("-2999-01-02T00:00:00Z", 4, Source::Series),
        ("2400-01-01T00:00:00Z", 9, Source::Series),
        ("-0500-01-01T00:00:00Z", 9, Source::Mean),
    ] {
        let answer = ephemeris.state(NaifId(body), NaifId::SUN, Instant::parse(time).expect(time), None).expect(time);
        assert_eq!(answer.source, source, "{time} {body}");
    }
    let old = Instant::parse("1750-01-01T00:00:00Z").expect("a time");
    for (body, source, name) in [(399, Some(Source::Kernel), "Earth"), (123_456, None, "body 123456")] {
        let error = ephemeris.state(NaifId(body), NaifId::SUN, old, source).expect_err("no theory").to_string();
        assert!(error.contains(name) && !error.contains('\n'), "{error}");
    }
    assert!(ephemeris.state(NaifId::EARTH, NaifId(0), Instant::from_jd_tdb(3_000_000.0), None).is_err());
}

/// `source` selects among the theories that a body has; the answer names what was used.
#[test]
fn the_answer_names_the_source_that_was_used() {
    let ephemeris = ephemeris();
    let t = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
    for (body, center, requested, source) in [
        // L1.2 and TASS are the only theories of these moons.
        (501, 599, Source::Mean, Source::Series),
        (606, 699, Source::Mean, Source::Series),
        (501, 599, Source::Kernel, Source::Series),
        // Mean elements are the only theory of Phobos.
        (401, 499, Source::Series, Source::Mean),
        // Jupiter's place relative to the Sun is from mean elements.
        (501, 10, Source::Mean, Source::Mean),
        (599, 10, Source::Mean, Source::Mean),
        (399, 10, Source::Series, Source::Series),
        // Mars coincides with its barycentre; nothing was evaluated.
        (499, 4, Source::Series, Source::Series),
        (399, 399, Source::Mean, Source::Mean),
    ] {
        let answer = ephemeris.state(NaifId(body), NaifId(center), t, Some(requested)).expect("a place");
        assert_eq!(answer.source, source, "{body} relative to {center} by {requested:?}");
        // Without a request the source is the same or a better one.
        let best = ephemeris.state(NaifId(body), NaifId(center), t, None).expect("a place");
        assert!(best.source >= answer.source, "{body} relative to {center}: {:?}", best.source);
    }
}

#[test]
fn moons_move_almost_linearly_while_light_crosses_their_system() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("opens");
    let t = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
    let mut worst_km = [0.0_f64; 2];
    for moon in catalog.bodies().iter().filter(|b| b.kind == orrery::catalog::BodyKind::Moon) {
        let parent = moon.parent.expect("a planet");
        let state = |t: Instant| ephemeris.state(moon.id, parent, t, None).expect("a place").state;
        let linear_error_km =
            |light_s: f64| (state(t).pos_km - state(t).vel_km_s * light_s - state(t.plus_seconds(-light_s)).pos_km).length();
        let error_km = [linear_error_km(1.0), linear_error_km(10.0)];
        assert!(moon.name != "Io" || error_km[1] < 0.04, "Io: {error_km:?} km");
        worst_km = [0, 1].map(|k: usize| larger(worst_km[k], error_km[k]));
    }
    // `light_time_position` and the positions of occluders assume linear motion. The error is small, but not zero.
    assert!(worst_km[0] < 6e-3 && worst_km[1] < 0.4, "{worst_km:?} km");
    assert!(worst_km[1] > 0.2, "{worst_km:?} km");
}

/// TDB seconds past J2000, over the entire span of the series. They are not Julian dates, because an f64 holds such a date only to 4e-5 s,
/// in which Mercury moves 2 m.
fn series_dates() -> impl Iterator<Item = f64> {
    (0..40).map(|k| (-4990.0 + 150.13 * f64::from(k) + 0.0137 * f64::from(k * k)) * 365.25 * 86_400.0)
}

#[test]
fn cached_polynomials_follow_the_planets_series() {
    use orrery::ephemeris::series::Series;
    let series = Series::embedded().expect("embedded");
    let (mut worst_km, mut worst_km_s) = (0.0_f64, 0.0_f64);
    for place in [1, 2, 3, 4, 5, 6, 7, 8, 10] {
        let series_km = |tdb_s: f64| Series::position_by_series_km(place, tdb_s).expect("has a series");
        for tdb_s in series_dates() {
            let state = series.state(place, tdb_s).expect("has a series");
            let step_s = 0.2 * 86_400.0;
            // Fourth-order central difference: the derivative times 12 steps.
            let difference_km = (series_km(tdb_s + step_s) - series_km(tdb_s - step_s)) * 8.0
                - (series_km(tdb_s + 2.0 * step_s) - series_km(tdb_s - 2.0 * step_s));
            let (km, km_s) = ((state.pos_km - series_km(tdb_s)).length(), (state.vel_km_s - difference_km / (12.0 * step_s)).length());
            assert!(km < 5e-3 && km_s < 2e-6, "{place} at {tdb_s}: {km} km, {km_s} km/s");
            (worst_km, worst_km_s) = (worst_km.max(km), worst_km_s.max(km_s));
        }
    }
    println!("at worst {worst_km:.2e} km, {worst_km_s:.2e} km/s");
    // Negative control: in a second Mercury moves by more than 30 km.
    let moved = series.state(1, 1.0).expect("Mercury").pos_km - Series::position_by_series_km(1, 0.0).expect("Mercury");
    assert!(moved.length() > 30.0);
}
