//! `orrery ephemeris`: rows of tables equal single queries; at rise, set and twilight the Sun has the altitude that defines them; error
//! messages.

use serde_json::Value;
use std::process::{Command, Output};

fn orrery(args: &[&str]) -> Output {
    Command::new(crate::support::program::path()).arg("ephemeris").args(args).output().expect("the program starts")
}

/// The output of a run that succeeds.
fn text(args: &[&str]) -> String {
    let out = orrery(args);
    assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8(out.stdout).expect("UTF-8")
}

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&text(&[args, &["--json"]].concat())).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

/// Compares the rows of JSON and of CSV with single queries. The rows of the text table have equal widths.
#[test]
fn rows_of_a_table_equal_single_queries() {
    let span = ["--from", "2016-12-30", "--to", "2017-01-02", "--step", "1d"];
    // Arguments; a column of the table; and the JSON pointer to the same value of a single query.
    let tables: [(&[&str], &str, &str); 4] = [
        (&["--body", "mars", "--center", "sun"], "x_km", "/pos_km/0"),
        (&["--body", "mars", "--apparent"], "ra_deg", "/true_of_date/ra_deg"),
        (&["--body", "mars", "--orientation"], "sub_observer_lon_east_deg", "/sub_observer/lon_east_deg"),
        (&["--body", "moon", "--at", "52.5,13.4,40"], "altitude_deg", "/0/altitude_deg"),
    ];
    for (args, column, pointer) in tables {
        let rows = json(&[args, &span].concat());
        let rows = rows.as_array().expect("rows");
        // Every row has the same time of day, although there is a leap second between the second and the third.
        let times: Vec<&str> = rows.iter().map(|r| r["time_utc"].as_str().expect("a time")).collect();
        assert_eq!(times, ["2016-12-30T00:00:00Z", "2016-12-31T00:00:00Z", "2017-01-01T00:00:00Z", "2017-01-02T00:00:00Z"]);
        let csv = text(&[args, &span, &["--csv"]].concat());
        let csv_lines: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
        assert!(csv_lines.len() == 5 && csv_lines.iter().all(|line| line.len() == csv_lines[0].len()), "{csv}");
        let column_index = csv_lines[0].iter().position(|name| *name == column).expect("the column");
        for (row, line) in rows.iter().zip(&csv_lines[1..]) {
            let single = json(&[args, &["--time", row["time_utc"].as_str().expect("a time")]].concat());
            let (found, expected) = (number(&row[column]), number(single.pointer(pointer).expect("the same value")));
            assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{args:?} {column}: {found}, not {expected}");
            assert!((line[column_index].parse::<f64>().expect("a number") - found).abs() <= 6e-4, "{csv}");
        }
        assert_ne!(rows[0][column], rows[1][column], "{args:?} {column}: equal in two rows, so that a row of another time would pass");
        let table = text(&[args, &span].concat());
        let widths: Vec<usize> = table.lines().map(|line| line.chars().count()).collect();
        assert!(widths.len() == 5 && widths.iter().all(|w| *w == widths[0]), "{table}");
    }
}

/// A query for the instant of rise, set or twilight has the Sun at the altitude that defines it: in middle latitudes, near the equator and
/// beyond the polar circle.
#[test]
fn the_sun_is_at_the_altitudes_of_rise_set_and_twilight() {
    let altitude = |place: &str, time: &str| number(&json(&["--body", "sun", "--at", place, "--time", time])[0]["altitude_deg"]);
    for (place, day) in [("51.48,0", "2026-03-20"), ("0,-78.5", "2026-06-21"), ("-33.9,18.4", "2025-12-21"), ("69.65,18.96", "2026-10-15")]
    {
        let found = json(&["--rise-set", "--at", place, "--time", day]);
        for name in ["rise", "set"] {
            // The upper limb is at the horizon: refraction is 34', the semidiameter 15.7' to 16.3'.
            let sun_altitude_deg = altitude(place, found[name]["time"].as_str().expect("a time"));
            assert!((-50.4 / 60.0..-49.6 / 60.0).contains(&sun_altitude_deg), "{place} {name}: {sun_altitude_deg}");
        }
        let transit = found["transit"]["time"].as_str().expect("a time");
        assert!((number(&found["transit"]["altitude_deg"]) - altitude(place, transit)).abs() < 1e-6);
        let at_transit = json(&["--body", "sun", "--at", place, "--time", transit]);
        assert!(number(&at_transit[0]["hour_angle_deg"]).abs() < 1e-3, "{place}: {at_transit}");
        // The times are exact to 0.05 s, in which the altitude changes by less than 1e-3 degrees.
        for (name, expected) in [("civil", -6.0), ("nautical", -12.0), ("astronomical", -18.0)] {
            for end in ["dawn", "dusk"] {
                let sun_altitude_deg =
                    altitude(place, found["twilight"][name][end].as_str().unwrap_or_else(|| panic!("{place} {name} {end}")));
                assert!((sun_altitude_deg - expected).abs() < 1e-3, "{place} {name} {end}: {sun_altitude_deg}");
            }
        }
    }
    // In June, it is not fully dark in London at any time, and the Sun does not set in Tromsø. In December it does not rise there.
    let london = json(&["--rise-set", "--at", "51.5,-0.13", "--time", "2026-06-21"]);
    assert!(london["twilight"]["astronomical"]["dawn"].is_null() && london["twilight"]["nautical"]["dusk"].is_string(), "{london}");
    let tromso = |day: &str| json(&["--rise-set", "--at", "69.65,18.96", "--time", day]);
    let (june, december) = (tromso("2026-06-21"), tromso("2026-12-21"));
    assert!(june["rise"].is_null() && june["set"].is_null() && june["up_at_start"] == true, "{june}");
    assert!(
        december["rise"].is_null() && december["up_at_start"] == false && december["twilight"]["civil"]["dawn"].is_string(),
        "{december}"
    );
    // Only for the Sun are there times of twilight. The text has a line for each event.
    assert!(json(&["--body", "moon", "--rise-set", "--at", "51.5,-0.13", "--time", "2026-06-21"])["twilight"].is_null());
    let printed = text(&["--rise-set", "--at", "51.5,-0.13", "--time", "2026-06-21"]);
    assert!(printed.lines().count() == 10 && printed.contains("astronomical dawn     none within the day"), "{printed}");
}

/// Jupiter rises four minutes earlier each day, so that it may rise twice in 24 hours: the second time was left out.
#[test]
fn a_planet_that_rises_twice_in_a_day_has_both_risings() {
    let args = ["--rise-set", "--body", "jupiter", "--at", "40.7,-74", "--time", "2024-03-10T13:27:00Z"];
    let found = json(&args);
    let time = |name: &str| found[name]["time"].as_str().unwrap_or_else(|| panic!("{name}: {found}"))[..16].to_owned();
    assert_eq!((time("rise"), time("second_rise")), ("2024-03-10T13:28".to_owned(), "2024-03-11T13:25".to_owned()));
    assert!(found["second_set"].is_null() && found["second_transit"].is_null(), "{found}");
    let lines = text(&args);
    assert!(
        lines.lines().any(|line| line.starts_with("second rise           2024-03-11T13:25")) && !lines.contains("second set"),
        "{lines}"
    );
    // Negative control: a minute later there is only one.
    assert!(json(&[&args[..6], &["2024-03-10T13:32:00Z"]].concat())["second_rise"].is_null());
}

#[test]
fn errors_about_spans_and_places_name_a_remedy() {
    let span = |from: &'static str, to: &'static str, step: &'static str| {
        vec!["--body", "mars", "--apparent", "--from", from, "--to", to, "--step", step]
    };
    for (args, message_part) in [
        (span("2026-01-02", "2026-01-01", "1d"), "swap"),
        (span("2026-01-01", "2026-01-02", "0s"), "more than 0"),
        (span("2026-01-01", "2026-01-02", "-1h"), "more than 0"),
        (span("2026-01-01", "2036-01-02", "1s"), "200000 rows"),
        (span("soon", "2026-01-02", "1d"), "--from"),
        (vec!["--body", "mars", "--from", "2026-01-01", "--to", "2026-01-02"], "--step"),
        (vec!["--body", "mars", "--from", "2026-01-01", "--to", "2026-01-02", "--step", "1d"], "--center"),
        (vec!["--rise-set", "--at", "91,0", "--time", "now"], "--at"),
        (vec!["--rise-set", "--time", "now"], "--at"),
        (vec!["--body", "nibiru", "--at", "51,0", "--time", "now"], "nibiru"),
        (vec!["--body", "earth", "--at", "48,11", "--time", "2024-04-08"], "Earth has no altitude and azimuth from a place on it"),
        (vec!["--body", "earth", "--rise-set", "--at", "48,11", "--time", "2024-04-08"], "from a place on it"),
        (vec!["--body", "earth", "--apparent", "--time", "2024-04-08"], "from its own centre"),
    ] {
        let out = orrery(&args);
        let stderr_text = String::from_utf8_lossy(&out.stderr).into_owned();
        // The words of the last three cases are right, but there is no answer.
        let code = if args.contains(&"earth") { 1 } else { 2 };
        assert!(
            out.status.code() == Some(code) && stderr_text.contains(message_part) && out.stdout.is_empty(),
            "{args:?}: {:?}, {stderr_text}",
            out.status
        );
    }
}

/// Rise and set need a place and a time, but no centre.
#[test]
fn rise_and_set_without_place_and_time_ask_for_these_alone() {
    let out = orrery(&["--rise-set"]);
    let message = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(out.status.code() == Some(2) && message.contains("--at") && message.contains("--time"), "{message}");
    assert!(!message.contains("--center"), "{message}");
}

/// The bound of the error is a sum in binary floating point, for the Earth 0.329_999_999_999_999_96 km. Three digits of it are printed.
#[test]
fn the_error_of_a_position_is_printed_to_the_metre() {
    let printed = text(&["--body", "earth", "--center", "solar system barycenter", "--time", "2024-01-01"]);
    let bound = printed.split("within ").nth(1).and_then(|rest| rest.strip_suffix(" km\n")).unwrap_or_else(|| panic!("{printed}"));
    assert!(bound.parse::<f64>().is_ok_and(|km| km > 0.0) && bound.split('.').nth(1).is_some_and(|d| d.len() == 3), "{printed}");
}

/// Codes of NAIF: 499 Mars, 4 the barycentre of Mars and its moons, 10 the Sun, 0 the barycentre of the solar system, 301 the Moon, 3 the
/// barycentre of Earth and Moon. Codes of spacecraft are negative.
#[test]
fn bodies_have_naif_codes_too() {
    let query = |body: &str, center: &str| json(&["--body", body, "--center", center, "--time", "2024-04-08"]);
    for (by_code, by_name) in
        [(["499", "10"], ["mars", "sun"]), (["4", "0"], ["mars barycenter", "solar system barycenter"]), (["301", "3"], ["moon", "emb"])]
    {
        assert_eq!(query(by_code[0], by_code[1]), query(by_name[0], by_name[1]), "{by_code:?}");
    }
    for unknown in ["-5", "498", "11", "5.0"] {
        let out = orrery(&[&format!("--body={unknown}"), "--center", "sun", "--time", "2024-04-08"]);
        let message = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && message.contains("--body: no body or barycentre is called"), "{message}");
    }
}
