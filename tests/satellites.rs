//! Moons against JPL's satellite solution, another program's TASS and the IAU's rotation of locked moons; the planets' centres.

use glam::DVec3;
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::{Ephemeris, Source};
use orrery::time::Instant;
use orrery::units::{KM_PER_AU, SECONDS_PER_DAY};
use serde_json::Value;

const JUPITER: NaifId = NaifId(599);
const SATURN: NaifId = NaifId(699);

fn ephemeris() -> Ephemeris {
    Ephemeris::embedded(&Catalog::embedded()).expect("the shipped tables are whole")
}

fn table() -> Value {
    serde_json::from_str(include_str!("data/moon_states.json")).expect("the reference is JSON")
}

fn vector(v: &Value) -> DVec3 {
    let a = |i: usize| v[i].as_f64().expect("a number");
    DVec3::new(a(0), a(1), a(2))
}

/// Every (moon, state) of one planet's part.
fn states<'a>(table: &'a Value, planet: &str) -> Vec<(NaifId, &'a Value)> {
    let moons = table[planet]["moons"].as_array().expect("moons");
    let of = |m: &'a Value| {
        let id = NaifId(i32::try_from(m["naif"].as_i64().expect("naif")).expect("a code"));
        m["states"].as_array().expect("states").iter().map(move |s| (id, s))
    };
    moons.iter().flat_map(of).collect()
}

#[test]
fn galilean_moons_keep_their_stated_error_against_jup365() {
    let (ephemeris, table) = (ephemeris(), table());
    let mut worst = std::collections::BTreeMap::new();
    for (id, reference) in states(&table, "jupiter") {
        let t = Instant::from_jd_tdb(reference["jd_tdb"].as_f64().expect("jd_tdb"));
        let (pos_km, vel_km_s) =
            (vector(&reference["pos_au"]) * KM_PER_AU, vector(&reference["vel_au_day"]) * (KM_PER_AU / SECONDS_PER_DAY));
        let answer = ephemeris.state(id, JUPITER, t, None).expect("a moon");
        assert_eq!(answer.source, Source::Series);
        let off_km = (answer.state.pos_km - pos_km).length();
        let off_km_s = (answer.state.vel_km_s - vel_km_s).length();
        let entry = worst.entry(id.0).or_insert((0.0_f64, 0.0_f64));
        *entry = (entry.0.max(off_km), entry.1.max(off_km_s));
        assert!(off_km < answer.error_km, "{} {}: {off_km} km, stated {}", id.0, t.jd_tdb(), answer.error_km);
        // A displacement along the orbit turns the velocity by the same angle.
        assert!(off_km_s < 1.5 * answer.error_km * vel_km_s.length() / pos_km.length(), "{}: {off_km_s} km/s", id.0);
        // Five minutes late is wrong by more than is stated.
        let late = ephemeris.state(id, JUPITER, t.plus_seconds(300.0), None).expect("a moon").state;
        assert!((late.pos_km - pos_km).length() > answer.error_km);
    }
    println!("{worst:?}");
}

#[test]
fn saturns_moons_agree_with_another_program_on_the_same_theory() {
    let (ephemeris, table) = (ephemeris(), table());
    let mut seen = 0;
    for (id, reference) in states(&table, "saturn") {
        seen += 1;
        let t = Instant::from_jd_tt(reference["jd_tt"].as_f64().expect("jd_tt"));
        let answer = ephemeris.state(id, SATURN, t, None).expect("a moon");
        assert_eq!(answer.source, Source::Series);
        let off_km = (answer.state.pos_km - vector(&reference["pos_km"])).length();
        let off_km_s = (answer.state.vel_km_s - vector(&reference["vel_km_s"])).length();
        // Rounding of the dates is a millisecond at most: 15 m for Mimas.
        assert!(off_km < 0.02 && off_km_s < 2e-5, "{} {}: {off_km} km, {off_km_s} km/s", id.0, t.jd_tt());
        let late = ephemeris.state(id, SATURN, t.plus_seconds(1.0), None).expect("a moon").state;
        assert!((late.pos_km - vector(&reference["pos_km"])).length() > 0.5);
    }
    assert_eq!(seen, 40);
}

#[test]
fn velocity_is_the_slope_of_position() {
    let ephemeris = ephemeris();
    for moon in (501..=504).chain(601..=608) {
        let planet = moon / 100 * 100 + 99;
        let mut worst = 0.0_f64;
        for day in 0..40 {
            let at = |s: f64| {
                let t = Instant::from_jd_tdb(2_451_545.0 + 97.3 * f64::from(day)).plus_seconds(s);
                ephemeris.state(NaifId(moon), NaifId(planet), t, None).expect("a moon").state
            };
            let slope = (at(30.0).pos_km - at(-30.0).pos_km) / 60.0;
            worst = worst.max((slope - at(0.0).vel_km_s).length() / slope.length());
        }
        println!("{moon}: {worst:e}");
        assert!(worst < 1e-3, "{moon}: {worst}");
    }
}

/// Worst angle in degrees between a locked moon's prime meridian and its planet, seen from the moon's centre along the equator.
fn worst_meridian_error_deg(ephemeris: &Ephemeris, moon: NaifId, planet: NaifId, late_s: f64) -> f64 {
    let mut worst = 0.0_f64;
    for i in 0..60 {
        let t = Instant::from_jd_tdb(2_451_545.0 + 251.7 * f64::from(i));
        let to_moon = ephemeris.state(moon, planet, t.plus_seconds(late_s), None).expect("a moon").state.pos_km;
        let planet_in_body = ephemeris.body_from_icrf(moon, t).expect("a rotation") * -to_moon;
        worst = worst.max(planet_in_body.y.atan2(planet_in_body.x).abs().to_degrees());
    }
    worst
}

/// Moons that the IAU's model turns once an orbit and whose motion is followed for decades; the small ones close to their planets drift.
const LOCKED: &[(i32, i32)] = &[
    (401, 499),
    (402, 499),
    (501, 599),
    (502, 599),
    (503, 599),
    (504, 599),
    (601, 699),
    (602, 699),
    (603, 699),
    (604, 699),
    (605, 699),
    (606, 699),
    (608, 699),
    (701, 799),
    (702, 799),
    (703, 799),
    (704, 799),
    (705, 799),
    (801, 899),
    (808, 899),
    (901, 999),
];
/// An eccentric orbit swings a locked moon by 2e radians (Titan and Iapetus 3.3 degrees); mean elements add a degree or two.
const FACING_DEG: f64 = 4.5;

#[test]
fn locked_moons_face_their_planets_by_the_iau_meridian() {
    let ephemeris = ephemeris();
    let mut off = Vec::new();
    for &(moon, planet) in LOCKED {
        let worst = worst_meridian_error_deg(&ephemeris, NaifId(moon), NaifId(planet), 0.0);
        println!("{moon} {worst:.3}");
        if worst > FACING_DEG {
            off.push(format!("{moon}: {worst:.2} degrees"));
        }
    }
    assert!(off.is_empty(), "{off:?}");
    // Two hours late is 17 degrees for Io.
    assert!(worst_meridian_error_deg(&ephemeris, NaifId(501), JUPITER, 7200.0) > FACING_DEG);
}

#[test]
fn the_planets_and_their_moons_balance_on_the_barycentre() {
    let (ephemeris, catalog) = (ephemeris(), Catalog::embedded());
    let gm = |id| catalog.body(NaifId(id)).and_then(|b| b.gm_km3_s2).expect("a GM");
    // Largest offsets: the sum over the moons of GM ratio times distance.
    for (planet, moons, most_km) in [
        (599, &[501, 502, 503, 504][..], 250.0),
        (699, &[606, 608, 605, 604, 603][..], 340.0),
        (799, &[701, 702, 703, 704, 705][..], 60.0),
        (899, &[801][..], 80.0),
        (999, &[901][..], 2150.0),
    ] {
        let t = Instant::from_jd_tdb(2_460_000.5);
        let barycentre = NaifId(planet / 100);
        let from_barycentre = |id| ephemeris.state(NaifId(id), barycentre, t, None).expect("a place").state.pos_km;
        let centre = ephemeris.state(NaifId(planet), barycentre, t, None).expect("a planet");
        let torque = from_barycentre(planet) * gm(planet) + moons.iter().map(|&m| from_barycentre(m) * gm(m)).sum::<DVec3>();
        let left_km = torque.length() / gm(planet);
        println!("{planet}: {:.3} km, stated {:.3}", centre.state.pos_km.length(), centre.error_km);
        // Moons that the sum here leaves out may unbalance it by a hundred metres.
        assert!(left_km < 0.1, "{planet}: {left_km} km");
        assert!(centre.state.pos_km.length() > 1.0 && centre.state.pos_km.length() < most_km, "{planet}: {}", centre.state.pos_km);
        assert!(centre.error_km < 50.0 && centre.source < Source::Kernel);
        // Without the moons the planet alone does not balance.
        assert!((from_barycentre(planet) * gm(planet)).length() / gm(planet) > 0.1);
    }
}
