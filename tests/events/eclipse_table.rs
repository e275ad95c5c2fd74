//! Eclipses against every row of tests/data/eclipses_public.json (JPL DE440, ERFA).

use super::{EPHEMERIS, IAU_RADII, parse_time, seconds_after};
use orrery::Instant;
use orrery::events::{lunar_eclipses, solar_eclipses};
use serde_json::Value;

fn number(row: &Value, path: &str) -> f64 {
    row.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"))
}

fn instant(row: &Value, path: &str) -> Instant {
    Instant::from_tdb_seconds_past_j2000(number(row, path))
}

/// Rows of a kind, each with the start and the end of its day.
fn rows(kind: &str) -> Vec<(Value, Instant, Instant)> {
    let table: Value = serde_json::from_str(include_str!("../data/eclipses_public.json")).expect("JSON");
    let of_kind = table["eclipses"].as_array().expect("a list").iter().filter(|e| e["kind"] == kind);
    of_kind
        .map(|row| {
            let start = parse_time(row["date"].as_str().expect("a day"));
            (row.clone(), start, start.plus_seconds(86_400.0))
        })
        .collect()
}

#[test]
fn solar_eclipses_agree_with_the_reference() {
    for (row, from, to) in rows("solar") {
        let id = row["id"].as_str().expect("an id");
        let found = solar_eclipses(&IAU_RADII, &EPHEMERIS, from, to).expect("eclipses");
        let [eclipse] = &found[..] else { panic!("{id}: {} found", found.len()) };
        assert_eq!(eclipse.class.name(), row["type"], "{id}");
        let error_s = seconds_after(eclipse.greatest, instant(&row, "/greatest_eclipse/tdb_s_past_j2000"));
        let utc_error_s =
            seconds_after(eclipse.greatest, parse_time(&format!("{}Z", row["greatest_eclipse"]["utc"].as_str().expect("UTC"))));
        println!("{id}: {error_s:.4} s");
        assert!(error_s.abs() < 0.02 && utc_error_s.abs() < 0.02, "{id}: {error_s} {utc_error_s} s");
        assert!((eclipse.gamma - number(&row, "/greatest_eclipse/gamma")).abs() < 5e-6, "{id}: {}", eclipse.gamma);
        assert!((eclipse.magnitude - number(&row, "/sub_axis_point/magnitude")).abs() < 1e-6, "{id}: {}", eclipse.magnitude);
        assert!((eclipse.place.latitude_deg - number(&row, "/sub_axis_point/lat_deg")).abs() < 0.001, "{id}: {:?}", eclipse.place);
        assert!((eclipse.place.longitude_deg - number(&row, "/sub_axis_point/lon_east_deg")).abs() < 0.001, "{id}: {:?}", eclipse.place);
        assert!((eclipse.sun_altitude_deg - number(&row, "/sub_axis_point/sun_altitude_deg")).abs() < 0.002, "{id}");
        // Negative control: without light time the eclipse is half a minute later.
        let geometric_error_s = seconds_after(eclipse.greatest, instant(&row, "/geometric_no_light_time/tdb_s_past_j2000"));
        assert!(geometric_error_s < -30.0, "{id}: {geometric_error_s} s");
    }
}

/// The program bounds the shadow by rays that have passed the Earth, so its greatest eclipse differs by up to 0.25 s from that of almanacs.
/// The table also gives this difference.
#[test]
fn lunar_eclipses_agree_with_the_reference() {
    for (row, from, to) in rows("lunar") {
        let id = row["id"].as_str().expect("an id");
        let found = lunar_eclipses(&IAU_RADII, &EPHEMERIS, from, to).expect("eclipses");
        let [eclipse] = &found[..] else { panic!("{id}: {} found", found.len()) };
        assert_eq!(eclipse.class.name(), row["type"], "{id}");
        let ray_difference_s = number(&row, "/rigorous_shadow_ray_check/greatest_minus_almanac_s");
        let error_s = seconds_after(eclipse.greatest, instant(&row, "/greatest_eclipse/tdb_s_past_j2000"));
        println!("{id}: {error_s:.4} s, by rays {ray_difference_s:.4} s");
        assert!((error_s - ray_difference_s).abs() < 0.02, "{id}: {error_s} s");
        let contacts = row["contacts_geometric"].as_object().expect("contacts");
        assert_eq!(contacts.len(), eclipse.contacts.len());
        for (name, time) in &eclipse.contacts {
            let error_s = seconds_after(*time, instant(&row, &format!("/contacts_geometric/{name}/tdb_s_past_j2000")));
            assert!(error_s.abs() < 0.3, "{id} {name}: {error_s} s");
        }
        assert!((eclipse.gamma - number(&row, "/greatest_eclipse/gamma")).abs() < 1e-5, "{id}: {}", eclipse.gamma);
        assert!((eclipse.umbral_magnitude - number(&row, "/shadow/umbral_magnitude")).abs() < 2e-5, "{id}: {}", eclipse.umbral_magnitude);
        assert!((eclipse.penumbral_magnitude - number(&row, "/shadow/penumbral_magnitude")).abs() < 2e-5, "{id}");
        assert!((eclipse.place.longitude_deg - number(&row, "/sublunar_point/lon_east_deg")).abs() < 0.002, "{id}");
        let geometric_error_s = seconds_after(eclipse.greatest, instant(&row, "/geometric_no_light_time/tdb_s_past_j2000"));
        assert!(geometric_error_s < -30.0, "{id}: {geometric_error_s} s");
    }
}
