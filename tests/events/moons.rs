//! Events of the Galilean moons and Titan against published times.

use super::{EPHEMERIS, IAU, parse_time, seconds_after};
use orrery::Instant;
use orrery::catalog::NaifId;
use orrery::ephemeris::angle_rad;
use orrery::ephemeris::apparent::sub_points;
use orrery::events::{MoonEvent, MoonEventType, moon_events, mutual_events};

fn events(from: &str, to: &str) -> Vec<MoonEvent> {
    moon_events(&IAU, &EPHEMERIS, parse_time(from), parse_time(to)).expect("events")
}

fn contact(e: &MoonEvent, name: &str) -> Instant {
    e.contacts.iter().find(|c| c.0 == name).unwrap_or_else(|| panic!("{name} of {e:?}")).1
}

/// Published times, UT to the minute: Callisto's shadow from 3:11 to 8:00, Io's from 4:35 to 6:52, Europa's from 6:28 to 9:22
/// (B. King, Sky & Telescope, January 2015, in CST; the end of Callisto's is quoted from memory).
#[test]
fn three_shadows_fall_on_jupiter_on_the_24th_of_january_2015() {
    let found = events("2015-01-24T00:00:00Z", "2015-01-24T12:00:00Z");
    let shadow = |moon: i32| {
        found.iter().find(|e| e.class == MoonEventType::ShadowTransit && e.moon == NaifId(moon)).unwrap_or_else(|| panic!("{moon}"))
    };
    for (moon, begin, end) in [(504, "03:11", "08:00"), (501, "04:35", "06:52"), (502, "06:28", "09:22")] {
        for (name, published) in [("begin", begin), ("end", end)] {
            let error_s = seconds_after(contact(shadow(moon), name), parse_time(&format!("2015-01-24T{published}:00Z")));
            println!("{moon} {name}: {error_s:.0} s");
            // The published times are whole minutes. This fails without the light time from Jupiter, 36 minutes.
            assert!(error_s.abs() < 60.0, "{moon} {name}: {error_s} s");
        }
    }
    let all_three_s = seconds_after(contact(shadow(501), "end"), contact(shadow(502), "begin"));
    // From 6:28 to 6:52.
    assert!((all_three_s - 24.0 * 60.0).abs() < 60.0, "{all_three_s} s");
    assert!(!found.iter().any(|e| e.class == MoonEventType::ShadowTransit && e.moon == NaifId(503)));
}

#[test]
fn contacts_come_in_order_and_every_orbit_has_its_events() {
    let found = events("2020-03-01", "2020-04-01");
    for e in &found {
        let times: Vec<_> = e.contacts.iter().map(|c| seconds_after(c.1, e.greatest)).collect();
        assert!(times.windows(2).all(|w| w[0] < w[1]), "{e:?}");
        assert!(times[0] < 0.0 && times[times.len() - 1] > 0.0, "{e:?}");
    }
    // An orbit of Io takes 1.769 days, so there are 17 or 18 events of each type in 31 days.
    for class in [MoonEventType::Transit, MoonEventType::Occultation, MoonEventType::ShadowTransit, MoonEventType::Eclipse] {
        let count = found.iter().filter(|e| e.class == class && e.moon == NaifId(501)).count();
        assert!((17..=18).contains(&count), "{class:?}: {count}");
    }
}

/// In most years the Sun's elevation above the ring plane is so large that Titan's shadow misses Saturn.
#[test]
fn titans_shadow_meets_saturn_only_near_the_equinox() {
    // As the Sun approaches the ring plane, the first event of Titan is its entry into Saturn's shadow; half an orbit later its own shadow
    // meets the planet.
    let titan_events = events("2024-07-01", "2024-11-10")
        .into_iter()
        .filter(|e| e.moon == NaifId(606) && matches!(e.class, MoonEventType::Eclipse | MoonEventType::ShadowTransit));
    let titan_events: Vec<_> = titan_events.collect();
    assert_eq!(titan_events[0].class, MoonEventType::Eclipse);
    assert!(contact(&titan_events[0], "P1").to_utc_iso().starts_with("2024-10-27"), "{:?}", titan_events[0]);
    let shadows = |from: &str, to: &str| {
        events(from, to).into_iter().filter(|e| e.class == MoonEventType::ShadowTransit && e.moon == NaifId(606)).collect::<Vec<_>>()
    };
    assert!(shadows("2017-01-01", "2018-01-01").is_empty());
    let season = shadows("2024-06-01", "2026-06-01");
    assert!((15..=25).contains(&season.len()), "{}", season.len());
}

/// The days on which the Earth and the Sun cross the plane of Saturn's rings (Sky & Telescope; the equinox of 2009 is that of Cassini's mission). In a day the
/// Earth's elevation above the plane changes by 0.056 degrees and the Sun's by 0.015; the pole is known to some thousandths.
#[test]
fn the_earth_and_the_sun_cross_the_plane_of_saturns_rings_on_the_known_days() {
    let saturn = IAU.body(NaifId(699)).expect("Saturn");
    let elevations_deg = |t: Instant| {
        let points = sub_points(&EPHEMERIS, saturn, NaifId::EARTH, t).expect("points");
        [points.sub_observer.lat_centric_deg, points.sub_solar.expect("the Sun's").lat_centric_deg]
    };
    // 0: the Earth, 1: the Sun; and the sign of the elevation after the crossing.
    for (body_index, day, sign) in [(0, "2009-09-04", 1.0), (0, "2025-03-23", -1.0), (1, "2009-08-11", 1.0), (1, "2025-05-06", -1.0)] {
        let [before, after] = [0.0, 86_400.0].map(|s| sign * elevations_deg(parse_time(day).plus_seconds(s))[body_index]);
        assert!(before < 0.0 && after > 0.0, "{day}: {before} to {after} degrees");
        let day_after = sign * elevations_deg(parse_time(day).plus_seconds(2.0 * 86_400.0))[body_index];
        assert!(day_after > after, "{day}: the elevation must keep growing");
    }
}

/// Vector from the Earth's centre to a moon, with light time.
fn apparent_km(moon: NaifId, t: Instant) -> glam::DVec3 {
    let earth_km = EPHEMERIS.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, t, None).expect("the Earth").state.pos_km;
    EPHEMERIS.light_time_position(moon, earth_km, t).expect("a moon").0 - earth_km
}

/// There are mutual events in the season of 2015 (IMCCE's campaigns PHEMU), and none in 2018, when the Earth and the Sun are far from the
/// plane of Jupiter's equator.
#[test]
fn mutual_events_occur_only_in_their_seasons_and_limbs_touch_at_contacts() {
    assert!(mutual_events(&IAU, &EPHEMERIS, parse_time("2018-01-01"), parse_time("2018-04-01")).expect("events").is_empty());
    let found = mutual_events(&IAU, &EPHEMERIS, parse_time("2015-01-15"), parse_time("2015-02-15")).expect("events");
    let (occultations, eclipses): (Vec<_>, Vec<_>) = found.iter().partition(|e| e.class == MoonEventType::MutualOccultation);
    assert!(occultations.len() > 20 && eclipses.len() > 20, "{} and {}", occultations.len(), eclipses.len());
    let radius_km = |id: NaifId| IAU.body(id).expect("a moon").radii_km.x;
    for e in occultations {
        let front = e.nearer_moon.expect("another moon");
        // Separation of the limbs in degrees: negative where the discs overlap.
        let limb_separation_deg = |t: Instant| {
            let (rear_km, front_km) = (apparent_km(e.moon, t), apparent_km(front, t));
            assert!(front_km.length() < rear_km.length());
            (angle_rad(rear_km, front_km) - radius_km(e.moon) / rear_km.length() - radius_km(front) / front_km.length()).to_degrees()
        };
        // The discs are about 3e-4 degrees wide.
        for name in ["I", "IV"] {
            assert!(limb_separation_deg(contact(e, name)).abs() < 3e-7, "{name} of {e:?}: {}", limb_separation_deg(contact(e, name)));
            assert!(limb_separation_deg(contact(e, name).plus_seconds(60.0)).abs() > 3e-7, "{name} of {e:?}");
        }
        assert!(
            limb_separation_deg(e.greatest) < limb_separation_deg(e.greatest.plus_seconds(-60.0))
                && limb_separation_deg(e.greatest) < limb_separation_deg(e.greatest.plus_seconds(60.0)),
            "{e:?}"
        );
    }
    for e in eclipses {
        let times: Vec<_> = e.contacts.iter().map(|c| seconds_after(c.1, e.greatest)).collect();
        assert!(times.windows(2).all(|w| w[0] < w[1]) && times[0] < 0.0 && times[times.len() - 1] > 0.0, "{e:?}");
    }
}

/// Near its greatest elongation one moon passes the other twice within hours. On 10 August 2003 the discs parted in between, and these were two
/// occultations; on 25 August they did not, and it was one of five hours. The expected minutes at which the discs meet and part are from tables of both moons'
/// apparent places at steps of a minute (`orrery ephemeris --apparent`), from which the separation was computed outside of this program.
#[test]
fn two_passages_within_hours_are_two_events_or_one() {
    let occultations_of_europa = |from: &str, to: &str, by: NaifId| {
        let found = mutual_events(&IAU, &EPHEMERIS, parse_time(from), parse_time(to)).expect("events");
        found
            .into_iter()
            .filter(|e| e.class == MoonEventType::MutualOccultation && e.moon == NaifId(502) && e.nearer_moon == Some(by))
            .map(|e| ["I", "IV"].map(|name| contact(&e, name).to_utc_iso()[..16].to_owned()))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        occultations_of_europa("2003-08-10T11:00:00Z", "2003-08-10T19:00:00Z", NaifId(501)),
        [["2003-08-10T13:01", "2003-08-10T14:00"], ["2003-08-10T16:01", "2003-08-10T16:50"]]
    );
    assert_eq!(
        occultations_of_europa("2003-08-25T18:00:00Z", "2003-08-26T04:00:00Z", NaifId(503)),
        [["2003-08-25T20:06", "2003-08-26T01:09"]]
    );
}
