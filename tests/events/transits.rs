//! Transits of Mercury and Venus against the tables of F. Espenak (NASA, geocentric, UT), quoted from memory: only the Venus transit of
//! 2012 was confirmed, to the minute (page OH/transit12.html of eclipse.gsfc.nasa.gov). A wrong digit would show as an error of minutes,
//! or as a disagreement between the contacts of one transit.

use super::{ALMANAC_RADII, EPHEMERIS, IAU_RADII, parse_time, seconds_after};
use orrery::catalog::NaifId;
use orrery::ephemeris::angle_rad;
use orrery::ephemeris::topocentric::{Observer, ObserverSky};
use orrery::events::{GeodeticPosition, Transit, transits};

fn transit_on(day: &str) -> Transit {
    let from = parse_time(day);
    transits(&ALMANAC_RADII, &EPHEMERIS, from, from.plus_seconds(86_400.0)).expect("transits").remove(0)
}

/// Day of greatest transit; planet; times of contacts I and II, greatest transit, contacts III and IV; least distance of the centres in
/// arcseconds.
const TABLE: [(&str, i32, [&str; 5], f64); 5] = [
    (
        "2004-06-08",
        299,
        ["2004-06-08T05:13:29Z", "2004-06-08T05:32:55Z", "2004-06-08T08:19:44Z", "2004-06-08T11:06:33Z", "2004-06-08T11:25:59Z"],
        626.9,
    ),
    (
        "2012-06-06",
        299,
        ["2012-06-05T22:09:38Z", "2012-06-05T22:27:34Z", "2012-06-06T01:29:36Z", "2012-06-06T04:31:39Z", "2012-06-06T04:49:35Z"],
        554.4,
    ),
    (
        "2006-11-08",
        199,
        ["2006-11-08T19:12:04Z", "2006-11-08T19:13:57Z", "2006-11-08T21:41:04Z", "2006-11-09T00:08:16Z", "2006-11-09T00:10:08Z"],
        422.9,
    ),
    (
        "2016-05-09",
        199,
        ["2016-05-09T11:12:19Z", "2016-05-09T11:15:31Z", "2016-05-09T14:57:26Z", "2016-05-09T18:39:14Z", "2016-05-09T18:42:26Z"],
        318.5,
    ),
    (
        "2019-11-11",
        199,
        ["2019-11-11T12:35:27Z", "2019-11-11T12:37:08Z", "2019-11-11T15:19:48Z", "2019-11-11T18:02:33Z", "2019-11-11T18:04:14Z"],
        75.9,
    ),
];

#[test]
fn contacts_agree_with_the_published_tables() {
    let mut worst_s = 0.0_f64;
    for (day, body, times, separation_arcsec) in TABLE {
        let e = transit_on(day);
        assert_eq!(e.planet, NaifId(body), "{day}");
        let found = [e.contacts[0].1, e.contacts[1].1, e.greatest, e.contacts[2].1, e.contacts[3].1];
        for (instant, published) in found.iter().zip(times) {
            let error_s = seconds_after(*instant, parse_time(published));
            worst_s = worst_s.max(error_s.abs());
            assert!(error_s.abs() < 8.0, "{published}: {error_s} s");
        }
        assert!((e.separation_arcsec - separation_arcsec).abs() < 0.15, "{day}: {}", e.separation_arcsec);
    }
    println!("worst {worst_s:.1} s");
    // Negative control: from geometric positions, without the light times of 2.4 minutes for Venus and 8.3 for the Sun, the transit is off
    // by minutes.
    let published = parse_time("2012-06-06T01:29:36Z");
    let separation = |seconds: i32| {
        let geometric_km =
            |body| EPHEMERIS.state(body, NaifId::EARTH, published.plus_seconds(f64::from(seconds)), None).expect("a place").state.pos_km;
        angle_rad(geometric_km(NaifId::SUN), geometric_km(NaifId(299)))
    };
    let least_at_s = (-180..180).map(|i| i * 10).min_by(|a, b| separation(*a).total_cmp(&separation(*b))).expect("instants");
    assert!(least_at_s.abs() > 60, "{least_at_s} s");
}

#[test]
fn two_centuries_have_the_known_transits() {
    let found = transits(&ALMANAC_RADII, &EPHEMERIS, parse_time("1901-01-01"), parse_time("2099-12-31")).expect("transits");
    let years = |body: i32| -> Vec<String> {
        let of_body = found.iter().filter(|e| e.planet == NaifId(body));
        of_body.map(|e| e.greatest.to_utc_iso()[..4].to_owned()).collect()
    };
    assert_eq!(years(299), ["2004", "2012"]);
    let mercury = "1907 1914 1924 1927 1937 1940 1953 1957 1960 1970 1973 1986 1993 1999 \
                   2003 2006 2016 2019 2032 2039 2049 2052 2062 2065 2078 2085 2095 2098";
    assert_eq!(years(199).join(" "), mercury);
    // In 1937 only a part of Mercury passed in front of the Sun, as seen from the Earth's centre.
    let grazing = found.iter().find(|e| e.greatest.to_utc_iso().starts_with("1937")).expect("a transit");
    assert_eq!(grazing.contacts.len(), 2);
    assert!(
        seconds_after(grazing.contacts[0].1, parse_time("1937-05-11T08:53:00Z")).abs() < 60.0
            && seconds_after(grazing.contacts[1].1, parse_time("1937-05-11T09:06:00Z")).abs() < 60.0
    );
    // With the IAU's smaller Sun there is no contact: the discs miss each other by 0.02 arcsec.
    assert!(transits(&IAU_RADII, &EPHEMERIS, parse_time("1937-05-01"), parse_time("1937-06-01")).expect("transits").is_empty());
}

/// Places see contacts at times that differ by minutes, on which Halley's method is based.
#[test]
fn parallax_shifts_the_contacts_of_the_transit_of_venus() {
    let found = transits(&IAU_RADII, &EPHEMERIS, parse_time("2012-06-05"), parse_time("2012-06-07")).expect("transits");
    let e = &found[0];
    let mut first_contact_shifts_s = Vec::new();
    for (latitude_deg, longitude_deg) in [(19.8, -155.5), (-33.9, 151.2), (65.0, -147.7)] {
        let circumstances = e.seen_from(GeodeticPosition { latitude_deg, longitude_deg, height_km: 0.0 }).expect("a transit");
        let names: Vec<_> = circumstances.contacts.iter().map(|contact| contact.name).collect();
        assert_eq!(names, ["I", "II", "III", "IV"]);
        let place = Observer { body: NaifId::EARTH, lat_graphic_deg: latitude_deg, lon_east_deg: longitude_deg, height_km: 0.0 };
        let sky = ObserverSky { catalog: &IAU_RADII, ephemeris: &EPHEMERIS, place };
        let start = e.greatest.plus_seconds(-5.0 * 3600.0);
        let passage = sky.passage(NaifId::SUN, NaifId(299), start, 36_000.0).expect("places").expect("a transit");
        // `inner`: contacts II and III.
        let (second, third) = passage.inner.expect("entirely in front of the Sun");
        let (first, last) = passage.begins.zip(passage.ends).expect("contacts of the limbs");
        for (contact, expected) in circumstances.contacts.iter().zip([first, second, third, last]) {
            assert!(
                seconds_after(contact.time, expected).abs() < 2.0,
                "{latitude_deg} {}: {} s",
                contact.name,
                seconds_after(contact.time, expected)
            );
            assert!(contact.is_up(), "the Sun must be up");
        }
        first_contact_shifts_s.push(seconds_after(circumstances.contacts[0].time, e.contacts[0].1));
    }
    // At each place first contact is within eight minutes of that for the Earth's centre, and at one of them at least it is off by more
    // than a minute.
    assert!(
        first_contact_shifts_s.iter().all(|s| s.abs() < 480.0) && first_contact_shifts_s.iter().any(|s| s.abs() > 60.0),
        "{first_contact_shifts_s:?}"
    );
}
