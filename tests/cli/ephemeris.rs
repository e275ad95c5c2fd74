//! `orrery ephemeris`: rows of tables equal single queries; at rise, set and twilight the Sun has the altitude that defines them; what an observer sees, also
//! of minor planets and comets; error messages.

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

/// In steps of days the time of day stays: `rows_of_a_table_equal_single_queries`.
#[test]
fn a_table_in_seconds_has_a_row_for_a_leap_second() {
    for rows in [
        ["2016-12-31T23:59:59Z", "2016-12-31T23:59:60Z", "2017-01-01T00:00:00Z"],
        ["1972-06-30T23:59:59Z", "1972-06-30T23:59:60Z", "1972-07-01T00:00:00Z"],
    ] {
        let table = json(&["--body", "moon", "--center", "earth", "--from", rows[0], "--to", rows[2], "--step", "1s"]);
        let times: Vec<&str> = table.as_array().expect("rows").iter().map(|r| r["time_utc"].as_str().expect("a time")).collect();
        assert_eq!(times, rows);
        // In each of the two seconds the Moon moves as far.
        let [first, second] = [0, 1].map(|k| number(&table[k + 1]["x_km"]) - number(&table[k]["x_km"]));
        assert!(first.abs() > 0.1 && (first - second).abs() < 1e-5, "{first} and {second} km");
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
        // Of one instant it was a failure, without the name of the option.
        (vec!["--body", "mars", "--apparent", "--center", "jupiter", "--time", "2026-01-01"], "--center: an apparent place"),
        (vec!["--body", "mars", "--apparent", "--center", "nibiru", "--time", "2026-01-01"], "--center: no body"),
        (vec!["--body", "mars", "--center", "sun", "--time", "soon"], "--time: time `soon`"),
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
    for unknown in ["-5", "987654", "5.0"] {
        let out = orrery(&[&format!("--body={unknown}"), "--center", "sun", "--time", "2024-04-08"]);
        let message = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(
            out.status.code() == Some(2) && message.contains("--body: no body, barycentre, minor planet or comet is called"),
            "{message}"
        );
    }
}

/// Text fits into 100 columns, JSON and CSV have every quantity; `--quantities` chooses. The values themselves: tests/scene/observed.rs.
#[test]
fn what_an_observer_sees_has_the_requested_columns() {
    let span = ["--from", "2025-01-10", "--to", "2025-01-12", "--step", "1d"];
    let all = [
        "time_utc",
        "ra_deg",
        "dec_deg",
        "azimuth_deg",
        "altitude_deg",
        "magnitude",
        "surface_brightness_mag_arcsec2",
        "diameter_arcsec",
        "illuminated_fraction",
        "phase_angle_deg",
        "elongation_deg",
        "elongation_side",
        "constellation",
        "distance_km",
        "distance_au",
        "range_rate_km_s",
    ];
    for (place, is_at_place) in [(&[][..], false), (&["--at", "48.14,11.58"][..], true)] {
        for body in ["venus", "moon", "sun", "1P/Halley", "mars barycenter"] {
            let args = [&["--body", body, "--observer"], place, &span[..]].concat();
            if (body, is_at_place) == ("mars barycenter", true) {
                // It has no disc and so no altitude.
                continue;
            }
            let printed = text(&args);
            assert!(printed.lines().count() == 4 && printed.lines().all(|line| line.chars().count() <= 100), "{printed}");
            let rows = json(&args);
            let expected: std::collections::BTreeSet<&str> =
                all.into_iter().filter(|name| is_at_place || !["azimuth_deg", "altitude_deg"].contains(name)).collect();
            let found: std::collections::BTreeSet<&str> = rows[0].as_object().expect("a row").keys().map(String::as_str).collect();
            assert_eq!(found, expected, "{args:?}");
            let csv = text(&[&args[..], &["--csv"]].concat());
            assert_eq!(csv.lines().next().expect("a heading").split(',').count(), expected.len(), "{csv}");
        }
    }
    let venus = json(&["--body", "venus", "--observer", "--time", "2025-01-10T05:00:00Z"]);
    assert!((number(&venus[0]["elongation_deg"]) - 47.2).abs() < 0.1 && venus[0]["elongation_side"] == "east", "{venus}");
    assert!(venus[0]["constellation"] == "Aqr" && (number(&venus[0]["illuminated_fraction"]) - 0.51).abs() < 0.01, "{venus}");
    let chosen = text(&[
        "--body",
        "venus",
        "--quantities",
        "range-rate,phase",
        "--from",
        "2025-01-10",
        "--to",
        "2025-01-11",
        "--step",
        "1d",
        "--csv",
    ]);
    assert_eq!(chosen.lines().next(), Some("time_utc,range_rate_km_s,phase_angle_deg"), "{chosen}");
    // A place sees the same azimuth as the table of `--at` alone.
    let [here, horizontal] = [&["--quantities", "horizon"][..], &[]]
        .map(|more| json(&[&["--body", "moon", "--at", "48.14,11.58", "--time", "2025-01-10"], more].concat()));
    for name in ["azimuth_deg", "altitude_deg"] {
        assert_eq!(here[0][name], horizontal[0][name], "{name}");
    }
}

/// Names, numbers and designations, packed or not, mean the same minor planet or comet in every form of query.
#[test]
fn minor_planets_and_comets_are_bodies_of_every_query() {
    let state = |body: &str| json(&["--body", body, "--center", "sun", "--time", "2025-08-07"]);
    let pallas = state("Pallas");
    for name in ["2 Pallas", "(2)", "2000002"] {
        assert_eq!(state(name), pallas, "{name}");
    }
    assert!(pallas["source"] == "mean" && pallas["error_km"].is_null(), "{pallas}");
    assert_ne!(state("2"), pallas, "2 is the barycentre of Venus");
    assert_eq!(state("CJ95O010"), state("C/1995 O1 (Hale-Bopp)"));
    // 3.40 au from the Sun, by an independent evaluation of the elements.
    let au = (0..3).map(|k| number(&pallas["pos_km"][k]).powi(2)).sum::<f64>().sqrt() / 149_597_870.7;
    assert!((au - 3.40116).abs() < 1e-4, "{au}");
    let apparent = json(&["--body", "pallas", "--apparent", "--time", "2025-08-07"]);
    assert!((number(&apparent["gcrs"]["ra_deg"]) - 308.625).abs() < 0.02 && apparent["error_arcsec"].is_null(), "{apparent}");
    // In Munich Pallas is up in the night of its opposition, and has no known disc.
    let up = json(&["--body", "pallas", "--at", "48.14,11.58", "--time", "2025-08-07T23:00:00Z"]);
    assert!(number(&up[0]["altitude_deg"]) > 40.0 && up[0]["semidiameter_deg"].is_null(), "{up}");
    let day = json(&["--body", "pallas", "--rise-set", "--at", "48.14,11.58", "--time", "2025-08-07T12:00:00Z"]);
    assert!(day["body"] == "2 Pallas" && day["rise"]["time"].is_string() && day["set"]["time"].is_string(), "{day}");
    let printed = text(&["--body", "halley", "--center", "earth", "--time", "1986-03-01"]);
    assert!(printed.contains("error unknown"), "{printed}");

    let out = orrery(&["--body", "pallas", "--orientation", "--time", "2025-08-07"]);
    assert!(out.status.code() == Some(1) && String::from_utf8_lossy(&out.stderr).contains("rotation"), "{out:?}");
    for (args, message_part) in [
        (&["--body", "palas", "--apparent", "--time", "now"][..], "`Pallas`"),
        (&["--body", "panstarrs", "--apparent", "--time", "now"], "is the name of several"),
        (&["--body", "mars", "--center", "pallas", "--time", "now"], "--center"),
        (&["--body", "mars", "--quantities", "horizon", "--time", "now"], "--at"),
        (&["--body", "mars", "--quantities", "colour", "--time", "now"], "surface-brightness"),
    ] {
        let out = orrery(args);
        let message = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.code() == Some(2) && message.contains(message_part) && out.stdout.is_empty(), "{args:?}: {message}");
    }
}

/// A minor planet of the user's file, with the packed designation that MPCORB.DAT has, and lines of standard input that ask what is seen of it.
#[test]
fn small_bodies_of_the_users_file_answer_by_packed_designation() {
    use std::io::Write;
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("mine.csv");
    std::fs::write(
        &file,
        "designation,name,e,a_au,i_deg,node_deg,argp_deg,M_deg,epoch_mjd,H,G\n2007 TA418,,0.1,2.5,5,80,70,30,60000,15.5,0.15\n",
    )
    .expect("written");
    let mut program = Command::new(crate::support::program::path())
        .args(["--minor-planets", file.to_str().expect("UTF-8"), "ephemeris", "--stdin", "--observer"])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    let lines = r#"{"body":"K07Tf8A","time":"2026-01-01"}
{"body":"2007 TA418","time":"2026-01-01","center":"earth"}
{"body":"2007 TA418","time":"2026-01-01","center":"mars"}
{"body":"Pallas","time":"2026-01-01"}
"#;
    program.stdin.take().expect("piped").write_all(lines.as_bytes()).expect("written");
    let out = program.wait_with_output().expect("ends");
    let answers: Vec<Value> =
        String::from_utf8(out.stdout).expect("UTF-8").lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(answers.len(), 4, "{answers:?}");
    assert_eq!(answers[0], answers[1]);
    assert!((15.0..22.0).contains(&number(&answers[0]["ok"]["magnitude"])) && answers[0]["ok"]["diameter_arcsec"].is_null(), "{answers:?}");
    assert!(answers[2]["error"].as_str().is_some_and(|e| e.starts_with("center")), "{answers:?}");
    assert!(answers[3]["error"].as_str().is_some_and(|e| e.contains("Pallas")), "the file replaces the embedded table: {answers:?}");
}
