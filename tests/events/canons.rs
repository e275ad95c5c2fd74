//! Numbers, types, Saros series and magnitudes of the eclipses of two centuries against NASA's Five Millennium Canons (F. Espenak and J.
//! Meeus).

use super::{ALMANAC_RADII, EPHEMERIS, IAU_RADII, parse_time, seconds_after};
use orrery::Catalog;
use orrery::events::{LunarEclipse, LunarType, SolarEclipse, SolarType, lunar_eclipses, lunar_eclipses_by_almanacs, solar_eclipses};
use std::sync::LazyLock;

/// All eclipses of both centuries, computed once.
struct Eclipses {
    solar: Vec<SolarEclipse>,
    lunar: Vec<LunarEclipse>,
}

fn find_eclipses(catalog: &Catalog) -> Eclipses {
    let (from, to) = (parse_time("1901-01-01"), parse_time("2099-12-31"));
    Eclipses {
        solar: solar_eclipses(catalog, &EPHEMERIS, from, to).expect("solar eclipses"),
        lunar: lunar_eclipses(catalog, &EPHEMERIS, from, to).expect("lunar eclipses"),
    }
}

static WITH_ALMANAC_RADII: LazyLock<Eclipses> = LazyLock::new(|| find_eclipses(&ALMANAC_RADII));
static WITH_IAU_RADII: LazyLock<Eclipses> = LazyLock::new(|| find_eclipses(&IAU_RADII));

/// Numbers by type: partial, annular, total, hybrid; penumbral, partial, total.
type Counts = ([usize; 4], [usize; 3]);

fn counts(catalog: &Catalog, from: &str, to: &str) -> Counts {
    let (from, to) = (parse_time(from), parse_time(to));
    let solar = solar_eclipses(catalog, &EPHEMERIS, from, to).expect("solar eclipses");
    let lunar = lunar_eclipses(catalog, &EPHEMERIS, from, to).expect("lunar eclipses");
    let solar_count = |class| solar.iter().filter(|e| e.class == class).count();
    let lunar_count = |class| lunar.iter().filter(|e| e.class == class).count();
    (
        [SolarType::Partial, SolarType::Annular, SolarType::Total, SolarType::Hybrid].map(solar_count),
        [LunarType::Penumbral, LunarType::Partial, LunarType::Total].map(lunar_count),
    )
}

/// The canons' numbers for the 20th century (228 solar and 229 lunar eclipses) and the 21st (224 and 228). Those of the lunar eclipses of
/// 2001-2100 were read from NASA's catalog (LEcat5/LE2001-2100); the others are quoted from memory.
const TWENTIETH: Counts = ([78, 73, 71, 6], [83, 65, 81]);
const TWENTY_FIRST: Counts = ([77, 72, 68, 7], [86, 57, 85]);

#[test]
fn each_century_has_the_canons_eclipses_of_every_type() {
    assert_eq!(counts(&ALMANAC_RADII, "1901-01-01", "2001-01-01"), TWENTIETH);
    assert_eq!(counts(&ALMANAC_RADII, "2001-01-01", "2101-01-01"), TWENTY_FIRST);
    // With the IAU's radii the Moon is larger, which makes more eclipses hybrid, and the umbra is not enlarged by the Earth's air, so there
    // are fewer lunar eclipses.
    let (solar, lunar) = counts(&IAU_RADII, "1901-01-01", "2001-01-01");
    assert_eq!(solar.iter().sum::<usize>(), 228);
    assert!(solar[3] > 6 && lunar.iter().sum::<usize>() < 229, "{solar:?} {lunar:?}");
}

/// Types in NASA's catalog of lunar eclipses. In the geometric shadow, the first two are partial, the next two penumbral, and the last two miss the penumbra.
/// With either catalog, the search by almanacs finds the catalog's types.
#[test]
fn lunar_eclipses_by_almanacs_have_the_canons_types_with_any_radii() {
    let class_on = |found: &[LunarEclipse], day: &str| found.iter().find(|e| e.greatest.to_utc_iso().starts_with(day)).map(|e| e.class);
    for (day, class, geometric) in [
        ("2015-04-04", LunarType::Total, Some(LunarType::Partial)),
        ("2021-05-26", LunarType::Total, Some(LunarType::Partial)),
        ("2013-04-25", LunarType::Partial, Some(LunarType::Penumbral)),
        ("2034-09-28", LunarType::Partial, Some(LunarType::Penumbral)),
        ("2013-05-25", LunarType::Penumbral, None),
        ("2027-07-18", LunarType::Penumbral, None),
    ] {
        let from = parse_time(day).plus_seconds(-86_400.0);
        let to = parse_time(day).plus_seconds(2.0 * 86_400.0);
        for catalog in [&*IAU_RADII, &*ALMANAC_RADII] {
            let found = lunar_eclipses_by_almanacs(catalog, &EPHEMERIS, from, to).expect("eclipses");
            assert_eq!(class_on(&found, day), Some(class), "{day}");
            // The same numbers as with the almanacs' catalog.
            let expected = WITH_ALMANAC_RADII.lunar.iter().find(|e| e.greatest.to_utc_iso().starts_with(day)).expect(day);
            assert!((found[0].umbral_magnitude - expected.umbral_magnitude).abs() < 1e-9, "{day}: {}", found[0].umbral_magnitude);
        }
        assert_eq!(class_on(&WITH_IAU_RADII.lunar, day), geometric, "{day}");
    }
}

#[test]
fn known_eclipses_have_their_type_and_series() {
    use SolarType::{Annular, Hybrid, Partial, Total};
    // Day, type, whether central, Saros series, number in the series if known.
    for (day, class, is_central, saros, member) in [
        ("1919-05-29", Total, true, 136, Some(32)),
        ("1967-11-02", Total, false, 152, None),
        ("1986-10-03", Hybrid, true, 124, None),
        ("1999-08-11", Total, true, 145, Some(21)),
        ("2009-07-22", Total, true, 136, Some(37)),
        ("2013-11-03", Hybrid, true, 143, None),
        ("2014-04-29", Annular, false, 148, None),
        ("2015-03-20", Total, true, 120, Some(61)),
        ("2017-08-21", Total, true, 145, Some(22)),
        ("2018-02-15", Partial, false, 150, None),
        ("2020-06-21", Annular, true, 137, Some(36)),
        ("2023-04-20", Hybrid, true, 129, None),
        ("2024-04-08", Total, true, 139, Some(30)),
    ] {
        let e = WITH_ALMANAC_RADII.solar.iter().find(|e| e.greatest.to_utc_iso().starts_with(day)).expect(day);
        assert_eq!((e.class, e.is_central, e.saros), (class, is_central, saros), "{day}");
        assert!(member.is_none() || e.saros_member == member, "{day}: member {:?}", e.saros_member);
    }
    // In 2013 the shadow begins at sunrise, and runs so fast that the place below it is 130 km nearer to the Moon a second later. So the first place sees an
    // annular eclipse even with the IAU's larger Moon. In 2068 the Moon is larger than the Sun by 3e-4 at the end of the path, even with the almanacs' smaller
    // radius, so the eclipse is total everywhere.
    let class_of = |found: &Eclipses, day: &str| found.solar.iter().find(|e| e.greatest.to_utc_iso().starts_with(day)).expect("one").class;
    assert_eq!((class_of(&WITH_IAU_RADII, "2013-11-03"), class_of(&WITH_ALMANAC_RADII, "2068-05-31")), (Hybrid, Total));
    // Day, type, Saros series, number in the series if known.
    for (day, class, saros, member) in [
        ("2018-07-27", LunarType::Total, 129, Some(38)),
        ("2020-11-30", LunarType::Penumbral, 116, None),
        ("2021-11-19", LunarType::Partial, 126, None),
        ("2022-11-08", LunarType::Total, 136, Some(20)),
    ] {
        let e = WITH_ALMANAC_RADII.lunar.iter().find(|e| e.greatest.to_utc_iso().starts_with(day)).expect(day);
        assert_eq!((e.class, e.saros), (class, saros), "{day}");
        assert!(member.is_none() || e.saros_member == member, "{day}: member {:?}", e.saros_member);
    }
}

/// Magnitude and duration at greatest eclipse. The expected numbers are the canon's, some of them also used in tests/ephemeris/horizon.rs; durations are
/// rounded to a second.
#[test]
fn central_eclipses_are_as_large_and_long_as_in_the_canon() {
    for (day, magnitude, duration_s, latitude_deg, longitude_deg) in [
        ("1991-07-11", 1.0800, 413.0, 22.0, -105.2),
        ("2009-07-22", 1.0799, 399.0, 24.2, 144.1),
        ("2010-01-15", 0.9190, 668.0, 1.6, 69.3),
        ("2017-08-21", 1.0306, 160.0, 37.0, -87.7),
        ("2023-10-14", 0.9520, 317.0, 11.4, -83.1),
        ("2024-04-08", 1.0566, 268.0, 25.3, -104.1),
    ] {
        let eclipse_in = |found: &'static Eclipses| found.solar.iter().find(|e| e.greatest.to_utc_iso().starts_with(day)).expect(day);
        let (e, by_iau) = (eclipse_in(&WITH_ALMANAC_RADII), eclipse_in(&WITH_IAU_RADII));
        let duration_found_s = e.duration_s.expect("central");
        assert!((e.magnitude - magnitude).abs() < 1e-4, "{day}: {}", e.magnitude);
        assert!((duration_found_s - duration_s).abs() < 1.0, "{day}: {duration_found_s} s");
        assert!(
            (e.place.latitude_deg - latitude_deg).abs() < 0.06 && (e.place.longitude_deg - longitude_deg).abs() < 0.1,
            "{day}: {:?}",
            e.place
        );
        assert!((by_iau.magnitude - magnitude).abs() > 5e-4, "{day}: the IAU radii would pass too");
    }
}

/// Magnitudes of eclipses whose axis misses the Earth although the umbra or antumbra meets it, from NASA's canon. They differ by up to 0.04 from the ratios
/// of the diameters.
#[test]
fn the_magnitude_of_an_eclipse_that_is_not_central_is_the_covered_part_of_the_diameter() {
    for (day, magnitude) in [
        ("1928-05-19", 1.0140),
        ("1950-03-18", 0.9620),
        ("1957-04-30", 0.9799),
        ("1957-10-23", 1.0013),
        ("2014-04-29", 0.9868),
        ("2043-04-09", 1.0095),
        ("2043-10-03", 0.9497),
    ] {
        let e = WITH_ALMANAC_RADII.solar.iter().find(|e| e.greatest.to_utc_iso().starts_with(day)).expect(day);
        assert!(!e.is_central && (e.magnitude - magnitude).abs() < 2e-4, "{day}: {}", e.magnitude);
    }
}

#[test]
fn contacts_are_in_order_and_durations_and_gammas_in_range() {
    let in_order = |contacts: &[(&'static str, orrery::Instant)], greatest| {
        let times: Vec<_> = contacts.iter().map(|c| seconds_after(c.1, greatest)).collect();
        times.windows(2).all(|w| w[0] < w[1]) && times[0] < 0.0 && times[times.len() - 1] > 0.0
    };
    for e in &WITH_ALMANAC_RADII.solar {
        assert!(in_order(&e.contacts, e.greatest), "{e:?}");
        let (first, last) = (seconds_after(e.contacts[0].1, e.greatest), seconds_after(e.contacts[e.contacts.len() - 1].1, e.greatest));
        // The penumbra stays on the Earth for at most 6 h 16 min.
        assert!(last - first < 6.3 * 3600.0, "{}", e.greatest.to_utc_iso());
        assert_eq!(e.contacts.len() == 4, e.class != SolarType::Partial);
        // A central eclipse has a duration. If the axis misses the Earth, an eclipse may have one at the place nearest to the axis, unless it is partial.
        assert!(e.duration_s.is_some() || !e.is_central, "{e:?}");
        assert!(e.duration_s.is_none() || e.is_central || e.class != SolarType::Partial && e.magnitude > 0.9, "{e:?}");
        // The axis of a central eclipse meets the Earth; because of the flattening the limit of gamma is near 0.9972.
        assert!(e.gamma.abs() < 1.58 && (e.is_central == (e.gamma.abs() < 0.9972) || (e.gamma.abs() - 0.9972).abs() < 2e-3), "{}", e.gamma);
        assert!(e.place.latitude_deg * e.gamma > 0.0 || e.gamma.abs() < 0.5, "{e:?}");
    }
    for e in &WITH_ALMANAC_RADII.lunar {
        assert!(in_order(&e.contacts, e.greatest), "{e:?}");
        assert_eq!(
            e.contacts.len(),
            match e.class {
                LunarType::Penumbral => 2,
                LunarType::Partial => 4,
                LunarType::Total => 6,
            }
        );
        assert!(e.duration_s("U2", "U3").unwrap_or(0.0) < 108.0 * 60.0 && e.gamma.abs() < 1.6, "{e:?}");
    }
}
