//! Events of the Galilean moons and Titan against published times.

use super::{EPHEMERIS, IAU_RADII, parse_time, seconds_after};
use orrery::Instant;
use orrery::catalog::NaifId;
use orrery::ephemeris::angle_rad;
use orrery::ephemeris::apparent::sub_points;
use orrery::events::{MoonEvent, MoonEventType, moon_events, mutual_events};

const IO: NaifId = NaifId(501);
const EUROPA: NaifId = NaifId(502);
const GANYMEDE: NaifId = NaifId(503);
const CALLISTO: NaifId = NaifId(504);
const TITAN: NaifId = NaifId(606);

fn events(from: &str, to: &str) -> Vec<MoonEvent> {
    moon_events(&IAU_RADII, &EPHEMERIS, parse_time(from), parse_time(to)).expect("events")
}

/// Time of a contact by its name: `I` and `IV` are the first and last contact, `P1` is the first with the penumbra.
fn contact(event: &MoonEvent, name: &str) -> Instant {
    let found = event.contacts.iter().find(|(contact_name, _)| *contact_name == name);
    found.unwrap_or_else(|| panic!("{name} of {event:?}")).1
}

/// Published times, UT to the minute: Callisto's shadow from 3:11 to 8:00, Io's from 4:35 to 6:52, Europa's from 6:28 to 9:22
/// (B. King, Sky & Telescope, January 2015, in CST; the end of Callisto's is quoted from memory).
#[test]
fn three_shadows_fall_on_jupiter_on_the_24th_of_january_2015() {
    let found = events("2015-01-24T00:00:00Z", "2015-01-24T12:00:00Z");
    let shadow = |moon: NaifId| {
        found.iter().find(|e| e.class == MoonEventType::ShadowTransit && e.moon == moon).unwrap_or_else(|| panic!("{moon:?}"))
    };
    for (moon, begin, end) in [(CALLISTO, "03:11", "08:00"), (IO, "04:35", "06:52"), (EUROPA, "06:28", "09:22")] {
        for (name, published) in [("begin", begin), ("end", end)] {
            let error_s = seconds_after(contact(shadow(moon), name), parse_time(&format!("2015-01-24T{published}:00Z")));
            println!("{moon:?} {name}: {error_s:.0} s");
            // The published times are whole minutes. This fails without the light time from Jupiter, 36 minutes.
            assert!(error_s.abs() < 60.0, "{moon:?} {name}: {error_s} s");
        }
    }
    let all_three_s = seconds_after(contact(shadow(IO), "end"), contact(shadow(EUROPA), "begin"));
    // From 6:28 to 6:52.
    assert!((all_three_s - 24.0 * 60.0).abs() < 60.0, "{all_three_s} s");
    assert!(!found.iter().any(|e| e.class == MoonEventType::ShadowTransit && e.moon == GANYMEDE));
}

/// Predictions of IMCCE in whole minutes, at a phase angle of 9.8 degrees before opposition: the limb at which shadows enter is behind the Earth's limb, and
/// transits end at the terminator. Seen from the Sun, shadows began up to 108 s before the published times.
#[test]
fn phenomena_far_from_opposition_begin_and_end_as_the_earth_sees_them() {
    let found = events("2015-12-31", "2016-01-09");
    let mut counts = [0, 0];
    for line in include_str!("../data/jupiter_moons_2016_01.csv").lines().skip(1) {
        let [time, moon, class, name] = line.split(',').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let moon = match moon {
            "Io" => IO,
            "Europa" => EUROPA,
            "Ganymede" => GANYMEDE,
            _ => CALLISTO,
        };
        let (class, is_in_front) = match class {
            "transit" => (MoonEventType::Transit, true),
            "shadow transit" => (MoonEventType::ShadowTransit, true),
            "eclipse" => (MoonEventType::Eclipse, false),
            _ => (MoonEventType::Occultation, false),
        };
        let error_s = found
            .iter()
            .filter(|e| e.moon == moon && e.class == class)
            .map(|e| seconds_after(contact(e, name), parse_time(time)))
            .min_by(|a, b| a.abs().total_cmp(&b.abs()))
            .expect("an event of the moon");
        println!("{line}: {error_s:.0} s");
        assert!(error_s.abs() < if is_in_front { 50.0 } else { 70.0 }, "{line}: {error_s} s");
        counts[usize::from(is_in_front)] += 1;
    }
    assert_eq!(counts, [20, 24]);
}

/// The times of the contacts increase, and greatest phase is between the first and the last.
fn assert_contacts_in_order(event: &MoonEvent) {
    let times_s: Vec<_> = event.contacts.iter().map(|(_, time)| seconds_after(*time, event.greatest)).collect();
    assert!(times_s.windows(2).all(|pair| pair[0] < pair[1]), "{event:?}");
    assert!(times_s[0] < 0.0 && times_s[times_s.len() - 1] > 0.0, "{event:?}");
}

#[test]
fn contacts_come_in_order_and_every_orbit_has_its_events() {
    let found = events("2020-03-01", "2020-04-01");
    for event in &found {
        assert_contacts_in_order(event);
    }
    // An orbit of Io takes 1.769 days, so there are 17 or 18 events of each type in 31 days.
    for class in [MoonEventType::Transit, MoonEventType::Occultation, MoonEventType::ShadowTransit, MoonEventType::Eclipse] {
        let count = found.iter().filter(|e| e.class == class && e.moon == IO).count();
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
        .filter(|e| e.moon == TITAN && matches!(e.class, MoonEventType::Eclipse | MoonEventType::ShadowTransit));
    let titan_events: Vec<_> = titan_events.collect();
    assert_eq!(titan_events[0].class, MoonEventType::Eclipse);
    assert!(contact(&titan_events[0], "P1").to_utc_iso().starts_with("2024-10-27"), "{:?}", titan_events[0]);
    let shadows = |from: &str, to: &str| {
        events(from, to).into_iter().filter(|e| e.class == MoonEventType::ShadowTransit && e.moon == TITAN).collect::<Vec<_>>()
    };
    assert!(shadows("2017-01-01", "2018-01-01").is_empty());
    let season = shadows("2024-06-01", "2026-06-01");
    assert!((15..=25).contains(&season.len()), "{}", season.len());
}

/// The days on which the Earth and the Sun cross the plane of Saturn's rings (Sky & Telescope; the equinox of 2009 is that of Cassini's mission). In a day the
/// Earth's elevation above the plane changes by 0.056 degrees and the Sun's by 0.015; the pole is known to some thousandths of a degree.
#[test]
fn the_earth_and_the_sun_cross_the_plane_of_saturns_rings_on_the_known_days() {
    let saturn = IAU_RADII.body(NaifId(699)).expect("Saturn");
    let elevations_deg = |t: Instant| {
        let points = sub_points(&EPHEMERIS, saturn, NaifId::EARTH, t).expect("points");
        // The elevation above the plane is the latitude below the body.
        [points.sub_observer.lat_centric_deg, points.sub_solar.expect("the Sun's").lat_centric_deg]
    };
    let (earth_index, sun_index) = (0, 1);
    // `sign`: of the elevation after the crossing.
    for (body_index, day, sign) in [
        (earth_index, "2009-09-04", 1.0),
        (earth_index, "2025-03-23", -1.0),
        (sun_index, "2009-08-11", 1.0),
        (sun_index, "2025-05-06", -1.0),
    ] {
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
    assert!(mutual_events(&IAU_RADII, &EPHEMERIS, parse_time("2018-01-01"), parse_time("2018-04-01")).expect("events").is_empty());
    let found = mutual_events(&IAU_RADII, &EPHEMERIS, parse_time("2015-01-15"), parse_time("2015-02-15")).expect("events");
    let (occultations, eclipses): (Vec<_>, Vec<_>) = found.iter().partition(|e| e.class == MoonEventType::MutualOccultation);
    assert!(occultations.len() > 20 && eclipses.len() > 20, "{} and {}", occultations.len(), eclipses.len());
    let radius_km = |id: NaifId| IAU_RADII.body(id).expect("a moon").radii_km.x;
    for event in occultations {
        let nearer = event.nearer_moon.expect("another moon");
        // Separation of the limbs in degrees: negative where the discs overlap.
        let limb_separation_deg = |t: Instant| {
            let (farther_km, nearer_km) = (apparent_km(event.moon, t), apparent_km(nearer, t));
            assert!(nearer_km.length() < farther_km.length());
            (angle_rad(farther_km, nearer_km) - radius_km(event.moon) / farther_km.length() - radius_km(nearer) / nearer_km.length())
                .to_degrees()
        };
        // The discs are about 3e-4 degrees wide.
        for name in ["I", "IV"] {
            let separation_deg = limb_separation_deg(contact(event, name));
            assert!(separation_deg.abs() < 3e-7, "{name} of {event:?}: {separation_deg}");
            assert!(limb_separation_deg(contact(event, name).plus_seconds(60.0)).abs() > 3e-7, "{name} of {event:?}");
        }
        assert!(
            limb_separation_deg(event.greatest) < limb_separation_deg(event.greatest.plus_seconds(-60.0))
                && limb_separation_deg(event.greatest) < limb_separation_deg(event.greatest.plus_seconds(60.0)),
            "{event:?}"
        );
    }
    for event in eclipses {
        assert_contacts_in_order(event);
    }
}

/// Near its greatest elongation one moon passes the other twice within hours. On 10 August 2003 the discs parted in between, and these were two
/// occultations; on 25 August they did not, and there was one occultation, five hours long. The expected minutes at which the discs meet and part are from
/// tables of both moons' apparent places at steps of a minute (`orrery ephemeris --apparent`), from which the separation was computed outside of this program.
#[test]
fn two_passages_within_hours_are_two_events_or_one() {
    let occultations_of_europa = |from: &str, to: &str, by: NaifId| {
        let found = mutual_events(&IAU_RADII, &EPHEMERIS, parse_time(from), parse_time(to)).expect("events");
        found
            .into_iter()
            .filter(|e| e.class == MoonEventType::MutualOccultation && e.moon == EUROPA && e.nearer_moon == Some(by))
            .map(|e| ["I", "IV"].map(|name| contact(&e, name).to_utc_iso()[..16].to_owned()))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        occultations_of_europa("2003-08-10T11:00:00Z", "2003-08-10T19:00:00Z", IO),
        [["2003-08-10T13:01", "2003-08-10T14:00"], ["2003-08-10T16:01", "2003-08-10T16:50"]]
    );
    assert_eq!(
        occultations_of_europa("2003-08-25T18:00:00Z", "2003-08-26T04:00:00Z", GANYMEDE),
        [["2003-08-25T20:06", "2003-08-26T01:09"]]
    );
}
