//! The quantities of an ephemeris: against almanacs, against geometry from states of the ephemeris, and against the reports of scenes.

use crate::support::folds::larger;
use orrery::catalog::small_bodies::{BrightnessLaw, NamedTarget};
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::apparent::apparent_place;
use orrery::ephemeris::topocentric::Observer;
use orrery::ephemeris::{Ephemeris, angle_rad};
use orrery::scene::request::Position;
use orrery::scene::sky::frames::unit_vector;
use orrery::scene::{Observed, SkyOfEarth, bodies_seen_from, small_body_magnitude};
use orrery::time::Instant;
use orrery::units::{KM_PER_AU, SPEED_OF_LIGHT_KM_S};

fn inputs() -> (Catalog, Ephemeris) {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    (catalog, ephemeris)
}

fn at(time: &str) -> Instant {
    Instant::parse(time).expect("a time")
}

fn abbreviation(seen: &Observed) -> &'static str {
    seen.constellation.map_or("", |c| c.abbreviation.as_str())
}

fn observe(catalog: &Catalog, ephemeris: &Ephemeris, name: &str, t: Instant) -> Observed {
    let target = catalog.target_named(name).expect(name);
    SkyOfEarth::new(catalog, ephemeris, None).observe(&target, t).expect(name)
}

/// Oppositions and greatest elongations as almanacs print them: magnitude within 0.2 (Ceres, Vesta and Pallas 0.3), diameter within 1 % or half the last printed
/// digit, elongation within 0.3 degrees, with its side. The elongation of an opposition is 180 degrees less the ecliptic latitude: at least the one given.
#[test]
fn bodies_have_the_values_of_almanacs() {
    struct Printed(&'static str, &'static str, f64, Option<f64>, f64, Option<bool>, &'static str);
    let (catalog, ephemeris) = inputs();
    for Printed(name, time, magnitude, diameter_arcsec, elongation_deg, is_east, constellation) in [
        Printed("Mercury", "2024-12-25T02:00:00Z", -0.4, Some(6.6), 22.0, Some(false), "Oph"),
        Printed("Venus", "2025-01-10T05:00:00Z", -4.5, Some(24.4), 47.2, Some(true), "Aqr"),
        Printed("Mars", "2025-01-16T02:00:00Z", -1.4, Some(14.6), 175.0, None, "Gem"),
        Printed("Jupiter", "2024-12-07T21:00:00Z", -2.8, Some(48.2), 179.0, None, "Tau"),
        Printed("Saturn", "2024-09-08T05:00:00Z", 0.6, Some(19.2), 177.0, None, "Aqr"),
        Printed("Uranus", "2024-11-17T03:00:00Z", 5.6, Some(3.8), 179.0, None, "Tau"),
        Printed("Neptune", "2024-09-21T00:00:00Z", 7.7, Some(2.4), 178.0, None, "Psc"),
        Printed("Ceres", "2025-10-02T12:00:00Z", 7.6, None, 163.0, None, "Cet"),
        Printed("Vesta", "2025-05-02T12:00:00Z", 5.6, None, 166.0, None, "Lib"),
    ] {
        let seen = observe(&catalog, &ephemeris, name, at(time));
        let found = seen.magnitude.expect("lit");
        let tolerance_mag = if diameter_arcsec.is_some() { 0.2 } else { 0.3 };
        println!("{name}: {found:.2} mag, {:?} deg, {:?} deg", seen.angular_diameter_deg, seen.elongation);
        assert!((found - magnitude).abs() < tolerance_mag, "{name}: {found} mag");
        if let Some(printed) = diameter_arcsec {
            let arcsec = 3600.0 * seen.angular_diameter_deg.expect("a disc");
            assert!((arcsec - printed).abs() < larger(0.01 * printed, 0.05), "{name}: {arcsec} arcsec");
        }
        let elongation = seen.elongation.expect("not the Sun");
        match is_east {
            Some(is_east) => {
                assert!((elongation.angle_deg - elongation_deg).abs() < 0.3, "{name}: {elongation:?}");
                assert_eq!(elongation.is_east, is_east, "{name}");
            }
            None => assert!(elongation.angle_deg > elongation_deg, "{name}: {elongation:?}"),
        }
        assert_eq!(abbreviation(&seen), constellation, "{name}");
    }
}

/// Values against states of the ephemeris: phase angle and distances within the motion during the light time; the lit part is (1 + cos) / 2; the rate of the
/// distance is its change over ten minutes.
#[test]
fn quantities_follow_from_the_geometry() {
    let (catalog, ephemeris) = inputs();
    let t = at("2026-09-20T00:00:00Z");
    let mut fastest_km_s = 0.0_f64;
    for (name, id) in [("mercury", 199), ("venus", 299), ("mars", 499), ("saturn", 699), ("moon", 301), ("ceres", 2_000_001)] {
        let seen = observe(&catalog, &ephemeris, name, t);
        let from = |origin: NaifId| ephemeris.state(NaifId(id), origin, t, None).expect("in range").state.pos_km;
        let (to_earth, to_sun) = (-from(NaifId::EARTH), -from(NaifId::SUN));
        let cos_phase = to_earth.normalize().dot(to_sun.normalize());
        let phase_deg = seen.phase_angle_deg.expect("not the Sun");
        assert!((phase_deg - cos_phase.acos().to_degrees()).abs() < 0.05, "{name}: {phase_deg}");
        let lit = seen.illuminated_fraction.expect("a disc");
        assert!((lit - 0.5 * (1.0 + phase_deg.to_radians().cos())).abs() < 1e-12, "{name}: {lit}");
        assert!((seen.place.distance_km / to_earth.length() - 1.0).abs() < 3e-4, "{name}: {:?}", seen.place);
        // An elongation E, a phase angle A and the angle at the Sun add up to 180 degrees.
        let to_sun_of_earth = -ephemeris.state(NaifId::EARTH, NaifId::SUN, t, None).expect("in range").state.pos_km;
        let at_sun_deg = to_sun.normalize().dot(to_sun_of_earth.normalize()).clamp(-1.0, 1.0).acos().to_degrees();
        let sum_deg = phase_deg + at_sun_deg + seen.elongation.expect("not the Sun").angle_deg;
        assert!((sum_deg - 180.0).abs() < 0.1, "{name}: {sum_deg}");

        let distance_km = |s: f64| apparent_place(&ephemeris, NaifId(id), t.plus_seconds(s)).expect("a place").distance_km;
        let rate_km_s = (distance_km(300.0) - distance_km(-300.0)) / 600.0;
        assert!((seen.range_rate_km_s - rate_km_s).abs() < 1e-4, "{name}: {} km/s, not {rate_km_s}", seen.range_rate_km_s);
        fastest_km_s = larger(fastest_km_s, rate_km_s.abs());
    }
    assert!(fastest_km_s > 5.0, "rates of at most {fastest_km_s} km/s, so small that a wrong one might pass");
    // The Sun has a magnitude and a size, but no phase; a barycentre has a place alone.
    let sun = observe(&catalog, &ephemeris, "sun", t);
    assert!((sun.magnitude.expect("shines") + 26.74).abs() < 0.05 && sun.phase_angle_deg.is_none() && sun.elongation.is_none());
    let barycenter = observe(&catalog, &ephemeris, "jupiter barycenter", t);
    assert!(barycenter.magnitude.is_none() && barycenter.angular_diameter_deg.is_none() && barycenter.phase_angle_deg.is_none());
    let earth = NamedTarget::Body(NaifId::EARTH);
    assert!(SkyOfEarth::new(&catalog, &ephemeris, None).observe(&earth, t).is_err());
}

/// Magnitude, diameter and phase angle are those of the reports of scenes, from which images and `explain` take them, also when the same sky is asked again.
#[test]
fn bodies_are_as_bright_as_in_scenes() {
    let (catalog, ephemeris) = inputs();
    let sky = SkyOfEarth::new(&catalog, &ephemeris, None);
    for time in ["2017-05-17T00:00:00Z", "2025-03-23T00:00:00Z"] {
        let reports = bodies_seen_from(&catalog, &ephemeris, Position::Centre(NaifId::EARTH), at(time)).expect("placed");
        for report in reports.iter().filter(|r| r.id != NaifId::EARTH) {
            let seen = sky.observe(&NamedTarget::Body(report.id), at(time)).expect("a place");
            assert_eq!(
                (seen.magnitude, seen.angular_diameter_deg),
                (report.magnitude, Some(report.angular_diameter_deg)),
                "{}",
                report.name
            );
            let phase_deg = seen.phase_angle_deg.unwrap_or(0.0);
            assert!((phase_deg - report.phase_angle_deg).abs() < 1e-6, "{}: {phase_deg}, not {}", report.name, report.phase_angle_deg);
        }
    }
}

/// Mean surface brightness, magnitudes per square arcsecond: the full Moon 3.4 to 3.7 (magnitude -12.7 on 2.7e6 square arcseconds), Venus 0.8 to 1.6, Mars 3.9 to
/// 4.5, Jupiter 5.2 to 5.6. Saturn's globe has about 7; with the light of its wide open rings it would have a magnitude less.
#[test]
fn surface_brightness_is_that_of_the_lit_globe() {
    let (catalog, ephemeris) = inputs();
    for (name, time, range) in [
        ("moon", "2024-12-15T09:02:00Z", 3.3..3.8),
        ("venus", "2025-01-10T05:00:00Z", 0.8..1.8),
        ("mars", "2025-01-16T00:00:00Z", 3.8..4.6),
        ("jupiter", "2024-12-07T21:00:00Z", 5.1..5.7),
        ("saturn", "2017-06-15T00:00:00Z", 6.6..7.5),
        ("sun", "2024-12-07T21:00:00Z", -10.8..-10.4),
    ] {
        let brightness = observe(&catalog, &ephemeris, name, at(time)).surface_brightness_mag_arcsec2.expect("lit");
        println!("{name}: {brightness:.2} mag per square arcsecond");
        assert!(range.contains(&brightness), "{name}: {brightness}");
    }
}

/// The Moon from Munich: its parallax, up to 57 arcminutes, its greater size where it is high, and the motion of the ground (0.31 km/s) in the rate.
#[test]
fn a_place_on_the_earth_has_its_own_view_of_the_moon() {
    let (catalog, ephemeris) = inputs();
    let munich = Observer { body: NaifId::EARTH, lat_graphic_deg: 48.14, lon_east_deg: 11.58, height_km: 0.52 };
    let sky = SkyOfEarth::new(&catalog, &ephemeris, Some(munich));
    let moon = NamedTarget::Body(NaifId::MOON);
    let direction = |seen: &Observed| unit_vector(seen.place.gcrs.ra_deg, seen.place.gcrs.dec_deg);
    let mut greatest_parallax_deg = 0.0_f64;
    for hour in (0..24).step_by(3) {
        let t = at("2026-09-20T00:00:00Z").plus_seconds(3600.0 * f64::from(hour));
        let (here, centre) = (sky.observe(&moon, t).expect("a place"), observe(&catalog, &ephemeris, "moon", t));
        let altitude_deg = sky.horizontal(&moon, t).expect("a place").expect("on the ground").altitude_deg;
        let parallax = angle_rad(direction(&here), direction(&centre)).to_degrees();
        greatest_parallax_deg = larger(greatest_parallax_deg, parallax);
        // Seen higher, the Moon is nearer and so larger: by the Earth's radius times the sine of the altitude.
        let nearer_km = centre.place.distance_km - here.place.distance_km;
        assert!((nearer_km - 6366.0 * altitude_deg.to_radians().sin()).abs() < 150.0, "{altitude_deg}: {nearer_km} km");
        let ratio = here.angular_diameter_deg.expect("a disc") / centre.angular_diameter_deg.expect("a disc");
        assert!((ratio * here.place.distance_km / centre.place.distance_km - 1.0).abs() < 1e-4, "{ratio}");
        let distance_km = |s: f64| sky.observe(&moon, t.plus_seconds(s)).expect("a place").place.distance_km;
        let rate_km_s = (distance_km(30.0) - distance_km(-30.0)) / 60.0;
        assert!((here.range_rate_km_s - rate_km_s).abs() < 1e-4, "{} km/s, not {rate_km_s}", here.range_rate_km_s);
    }
    assert!((0.7..1.02).contains(&greatest_parallax_deg), "{greatest_parallax_deg}");
}

/// H = 3.33 and G = 0.12 at 2.7 au from the Sun and 1.8 au from the Earth: the values of tests/scene/magnitudes.rs, computed outside this program.
#[test]
fn minor_planets_follow_the_h_g_law_and_comets_m1_and_k1() {
    let ceres = BrightnessLaw::Asteroid { h: 3.33, g: 0.12 };
    for (alpha_deg, published) in [(2.9, 7.074), (5.0, 7.200), (14.0, 7.593), (22.0, 7.867)] {
        let found = small_body_magnitude(ceres, 1.8, 2.7, f64::to_radians(alpha_deg)).expect("lit");
        assert!((found - published).abs() < 2e-3, "{alpha_deg}: {found}, not {published}");
    }
    // M1 + 5 log d + K1 log r of a comet of gas, which has no phases.
    let comet = BrightnessLaw::Comet { m1: 5.5, k1: 8.0, dust_to_gas: 0.0 };
    assert!((small_body_magnitude(comet, 10.0, 0.1, 1.0).expect("lit") - 2.5).abs() < 1e-12);
    assert_eq!(small_body_magnitude(BrightnessLaw::Unknown, 1.0, 1.0, 0.1), None);
    assert_eq!(small_body_magnitude(ceres, 1.0, 1.0, std::f64::consts::PI), None, "no light, not an infinite magnitude");
}

/// Pallas at its opposition of August 2025 (magnitude 9.4, in Delphinus), Hyakutake at its closest approach (0.1018 au on 25 March 1996, near the Big Dipper's
/// handle), and Hale-Bopp at its perihelion: as their tables have them, with light time.
#[test]
fn minor_planets_and_comets_are_observed_by_their_orbits() {
    let (catalog, ephemeris) = inputs();
    let pallas = observe(&catalog, &ephemeris, "pallas", at("2025-08-07T00:00:00Z"));
    assert!((pallas.magnitude.expect("lit") - 9.4).abs() < 0.3 && abbreviation(&pallas) == "Del", "{pallas:?}");
    assert!(pallas.angular_diameter_deg.is_none() && pallas.illuminated_fraction.is_some_and(|lit| lit > 0.98), "{pallas:?}");

    let hyakutake = observe(&catalog, &ephemeris, "Hyakutake", at("1996-03-25T07:00:00Z"));
    assert!((hyakutake.place.distance_km / KM_PER_AU - 0.1018).abs() < 5e-4, "{hyakutake:?}");
    assert!((hyakutake.place.light_time_s - hyakutake.place.distance_km / SPEED_OF_LIGHT_KM_S).abs() < 1e-9);
    assert!(hyakutake.range_rate_km_s.abs() < 5.0 && hyakutake.illuminated_fraction.is_none(), "{hyakutake:?}");
    assert!(["Boo", "UMa", "Dra"].contains(&abbreviation(&hyakutake)), "{hyakutake:?}");

    // Perihelion on 1 April 1997, 0.914 au from the Sun and 1.351 au from the Earth, in the evening sky. Observers saw it at -0.8.
    let hale_bopp = observe(&catalog, &ephemeris, "Hale-Bopp", at("1997-04-01T00:00:00Z"));
    assert!((hale_bopp.sun_distance_km / KM_PER_AU - 0.914).abs() < 1e-3, "{hale_bopp:?}");
    let elongation = hale_bopp.elongation.expect("not the Sun");
    assert!((hale_bopp.magnitude.expect("lit") + 0.8).abs() < 0.7, "{hale_bopp:?}");
    assert!((elongation.angle_deg - 42.6).abs() < 0.2 && elongation.is_east && abbreviation(&hale_bopp) == "And", "{hale_bopp:?}");
}
