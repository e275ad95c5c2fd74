//! `orrery eclipse find`: fields, files, and one line for each invalid argument.

use serde_json::Value;
use std::process::{Command, Output};

fn find(args: &[&str]) -> Output {
    Command::new(crate::support::program::path()).args(["eclipse", "find"]).args(args).output().expect("the program starts")
}

fn json(args: &[&str]) -> Value {
    let out = find(&[args, &["--json"]].concat());
    assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap_or_else(|e| panic!("{args:?}: {e}"))
}

/// The JSON keeps the geometric shadow. The table says where almanacs have another type, and which eclipses only they have.
#[test]
fn the_table_names_the_type_of_almanacs_where_it_differs() {
    let text = |args: &[&str]| String::from_utf8(find(&[&["--kind", "lunar"][..], args].concat()).stdout).expect("text");
    let may_2021 = ["--from", "2021-05-20", "--to", "2021-05-30"];
    let by_iau = text(&may_2021);
    assert!(
        by_iau.contains("lunar  partial  ") && by_iau.contains("    almanacs, whose shadow the Earth's air enlarges: total, magnitude 1.0"),
        "{by_iau}"
    );
    let by_almanacs = text(&[&may_2021[..], &["--radii", "almanac"]].concat());
    assert!(by_almanacs.contains("lunar  total  ") && !by_almanacs.contains("almanacs, whose"), "{by_almanacs}");
    // The types are the same.
    let march_2025 = text(&["--from", "2025-03-01", "--to", "2025-04-01"]);
    assert!(march_2025.contains("lunar  total  ") && !march_2025.contains("almanacs, whose"), "{march_2025}");
    let july_2027 = text(&["--from", "2027-07-01", "--to", "2027-08-01"]);
    assert!(
        july_2027.contains("0 found") && july_2027.contains("only in almanacs") && july_2027.contains("2027-07-18 (penumbral, "),
        "{july_2027}"
    );
    let row = &json(&[&["--kind", "lunar"][..], &may_2021].concat())[0];
    assert_eq!((row["type"].as_str(), row["shadow"].as_str()), (Some("partial"), Some("geometric")));
}

const APRIL_2024: [&str; 4] = ["--from", "2024-04-01", "--to", "2024-05-01"];

#[test]
fn the_json_of_every_kind_has_its_fields() {
    for (kind, from, to) in [
        ("solar", "2024-04-01", "2024-05-01"),
        ("lunar", "2025-03-01", "2025-04-01"),
        ("transit", "2012-06-01", "2012-07-01"),
        ("moons", "2015-01-24", "2015-01-25"),
    ] {
        let list = json(&["--from", from, "--to", to, "--kind", kind]);
        let events = list.as_array().expect("a list");
        assert!(!events.is_empty(), "{kind}");
        for e in events {
            for field in [
                "kind",
                "type",
                "greatest",
                "gamma",
                "magnitude",
                "contacts",
                "lat",
                "lon",
                "saros",
                "duration_s",
                "radii",
                "delta_t_s",
                "delta_t_error_s",
            ] {
                assert!(e.get(field).is_some(), "{kind}: no {field}");
            }
            assert_eq!((e["kind"].as_str(), e["radii"].as_str()), (Some(kind), Some("iau")));
            assert!(e["greatest"].as_str().is_some_and(|t| t.ends_with('Z')));
            assert!(e["contacts"].as_object().is_some_and(|c| c.len() >= 2));
        }
    }
    let eclipse_with_radii = |radii: &str| json(&[&APRIL_2024[..], &["--kind", "solar", "--radii", radii]].concat())[0].clone();
    let (iau, almanac) = (eclipse_with_radii("iau"), eclipse_with_radii("almanac"));
    assert_eq!((iau["saros"].as_i64(), almanac["radii"].as_str()), (Some(139), Some("almanac")));
    let seconds = |e: &Value| e["duration_s"].as_f64().expect("a duration");
    assert!(seconds(&iau) - seconds(&almanac) > 3.0, "the radii must change totality by seconds");
}

#[test]
fn local_circumstances_and_paths_are_reported() {
    let from_dallas = json(&[&APRIL_2024[..], &["--kind", "solar", "--at", "32.7767,-96.797,130"]].concat());
    assert_eq!(from_dallas[0]["local"]["visible"], true);
    for contact in ["C1", "C2", "C3", "C4"] {
        assert!(
            from_dallas[0]["contacts"][contact].is_string() && from_dallas[0]["local"]["contacts"][contact]["altitude_deg"].is_number()
        );
    }
    assert_eq!(json(&[&APRIL_2024[..], &["--kind", "solar", "--at", "-30,150"]].concat())[0]["local"]["visible"], false);
    let text = String::from_utf8(find(&[&APRIL_2024[..], &["--at", "-30,150"]].concat()).stdout).expect("text");
    assert!(text.contains("here: not visible") && text.contains("radii iau"), "{text}");

    // In Lima the Moon rises after the umbral phase, in Berlin during it.
    let july_2018 = ["--from", "2018-07-27", "--to", "2018-07-28", "--kind", "lunar", "--at"];
    for (place, name) in [("-12.05,-77.04", " · penumbral magnitude 0."), ("52.52,13.4", " · magnitude 1.")] {
        let text = String::from_utf8(find(&[&july_2018[..], &[place]].concat()).stdout).expect("text");
        assert!(text.contains(name) && !text.contains("magnitude -"), "{text}");
        assert!(json(&[&july_2018[..], &[place]].concat())[0]["local"]["penumbral_magnitude"].is_number());
    }

    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("path.geojson");
    let file = file.to_str().expect("a path");
    assert!(find(&[&APRIL_2024[..], &["--path", file]].concat()).status.success());
    let path: Value = serde_json::from_slice(&std::fs::read(file).expect("a file")).expect("GeoJSON");
    assert_eq!(path["type"], "FeatureCollection");
    let names: Vec<_> = path["features"].as_array().expect("features").iter().filter_map(|f| f["properties"]["name"].as_str()).collect();
    assert_eq!(names, ["centre line", "northern limit", "southern limit"]);
    for feature in path["features"].as_array().expect("features") {
        assert_eq!(feature["geometry"]["type"], "MultiLineString");
        for line in feature["geometry"]["coordinates"].as_array().expect("lines") {
            for point in line.as_array().expect("points") {
                let (lon, lat) = (point[0].as_f64().expect("a longitude"), point[1].as_f64().expect("a latitude"));
                assert!((-180.0..=180.0).contains(&lon) && (-90.0..=90.0).contains(&lat));
            }
        }
    }
}

/// A place sees the contacts of a transit at other times than the Earth's centre, under the same names; those of the centre stay.
#[test]
fn contacts_of_a_transit_at_a_place_stand_beside_those_of_the_centre() {
    let args = ["--from", "2012-06-05", "--to", "2012-06-07", "--kind", "transit", "--at", "22.7,157.0"];
    let transit = json(&args)[0].clone();
    let (of_centre, at_place) = (transit["contacts"].as_object().expect("contacts"), &transit["local"]["contacts"]);
    assert_eq!(of_centre.keys().collect::<Vec<_>>(), ["I", "II", "III", "IV"]);
    for (name, time) in of_centre {
        assert!(time.is_string() && at_place[name]["time"].is_string() && at_place[name]["time"] != *time, "{name}: {transit}");
    }
    let text = String::from_utf8(find(&args).stdout).expect("text");
    assert!(text.contains("here: I 22:12:") && text.contains(" · II to III 5h58m"), "{text}");
    // The time from second to third contact of a solar eclipse has the names of its contacts.
    let text = String::from_utf8(find(&[&APRIL_2024[..], &["--kind", "solar", "--at", "32.7767,-96.797"]].concat()).stdout).expect("text");
    assert!(text.contains("here: C1 ") && text.contains(" · C2 to C3 "), "{text}");
}

/// A repeated command finds its own file.
#[test]
fn a_path_replaces_another_file_only_with_overwrite() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("path.geojson");
    let args = [&APRIL_2024[..], &["--kind", "solar", "--path", file.to_str().expect("a path")]].concat();
    assert!(find(&args).status.success() && find(&args).status.success(), "an existing file with the same bytes must be accepted");
    let path = std::fs::read(&file).expect("a file");
    std::fs::write(&file, "mine").expect("a file");
    let refused = find(&args);
    let stderr_text = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(1) && !refused.stdout.is_empty() && stderr_text.trim().lines().count() == 1, "{stderr_text}");
    assert!(stderr_text.contains("path.geojson: this file exists; --overwrite replaces it"), "{stderr_text}");
    assert_eq!(std::fs::read(&file).expect("a file"), b"mine");
    assert!(find(&[&args[..], &["--overwrite"]].concat()).status.success());
    assert_eq!(std::fs::read(&file).expect("a file"), path);
    assert_eq!(find(&[&APRIL_2024[..], &["--overwrite"]].concat()).status.code(), Some(2), "--overwrite needs --path");
}

/// Where a line crosses the antimeridian, it has a vertex on each side of the cut, with the time of the crossing.
#[test]
fn a_centre_line_over_the_antimeridian_has_a_time_for_each_vertex() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("path.geojson");
    let args = ["--from", "2012-05-20", "--to", "2012-05-22", "--kind", "solar", "--path", file.to_str().expect("a path")];
    assert!(find(&args).status.success());
    let path: Value = serde_json::from_slice(&std::fs::read(&file).expect("a file")).expect("GeoJSON");
    let centre_line = &path["features"][0];
    assert_eq!(centre_line["properties"]["name"], "centre line");
    let lines = centre_line["geometry"]["coordinates"].as_array().expect("lines");
    let [west, east] = [0, 1].map(|k| lines[k].as_array().expect("points").len());
    let times: Vec<&str> =
        centre_line["properties"]["times"].as_array().expect("times").iter().map(|t| t.as_str().expect("a time")).collect();
    assert_eq!((lines.len(), times.len()), (2, west + east));
    assert!(times.is_sorted(), "{times:?}");
    // The crossing is between its neighbours, and not at one of them.
    assert_eq!(times[west - 1], times[west]);
    assert!(times[west - 2] < times[west] && times[west] < times[west + 1], "{times:?}");
}

#[test]
fn a_span_may_begin_or_end_now() {
    for span in [["--from", "now", "--to", "2099-12-31"], ["--from", "1990-01-01", "--to", "NOW"]] {
        // Spans with several transits of Mercury.
        let list = json(&[&span[..], &["--kind", "transit"]].concat());
        assert!(list.as_array().is_some_and(|events| !events.is_empty()), "{span:?}: {list}");
    }
    assert_eq!(find(&["--from", "now", "--to", "1990-01-01"]).status.code(), Some(2));
}

/// No eclipse is possible in these spans by mean elements, which are good for any year; beyond the ephemeris that is no answer.
#[test]
fn a_span_beyond_the_ephemeris_is_an_error_even_if_no_eclipse_is_possible_in_it() {
    for (from, to) in
        [("5000-01-01", "5000-02-01"), ("3001-01-09", "3001-03-30"), ("3000-12-20", "3001-03-30"), ("-5000-01-01", "-5000-01-20")]
    {
        for kind in ["solar", "lunar"] {
            let out = find(&["--from", from, "--to", to, "--kind", kind]);
            let stderr_text = String::from_utf8_lossy(&out.stderr);
            assert_eq!(out.status.code(), Some(1), "{from} to {to}, {kind}: {stderr_text}");
            assert!(stderr_text.contains("the sources have Earth from") && stderr_text.trim_end().lines().count() == 1, "{stderr_text}");
        }
    }
    // Control: spans without an eclipse that are covered.
    for (from, to) in [("3000-12-20", "3001-01-05"), ("2024-06-01", "2024-06-20")] {
        assert_eq!(json(&["--from", from, "--to", to]), serde_json::json!([]), "{from} to {to}");
    }
}

#[test]
fn invalid_arguments_get_one_clear_line() {
    for (args, message_part) in [
        (vec!["--from", "2024-05-01", "--to", "2024-04-01"], "swap"),
        (vec!["--from", "soon", "--to", "2024-04-01"], "--from"),
        (vec!["--from", "2024-04-01", "--to", "2024-13-01"], "--to"),
        ([&APRIL_2024[..], &["--at", "here"]].concat(), "--at"),
        ([&APRIL_2024[..], &["--at", "91,0"]].concat(), "latitude"),
        ([&APRIL_2024[..], &["--at", "nan,0"]].concat(), "latitude"),
        ([&APRIL_2024[..], &["--at", "1,2,3,4"]].concat(), "two or three"),
        ([&APRIL_2024[..], &["--kind", "lunar", "--path", "x.geojson"]].concat(), "--path"),
        (vec!["--from", "2018-02-01", "--to", "2018-03-01", "--path", "x.geojson"], "no central eclipse"),
        (vec!["--from", "-9000-01-01", "--to", "-8999-01-01"], "not at"),
        // Reported before the search, hence before the span is read.
        (vec!["--from", "soon", "--to", "2024-04-01", "--path", "nowhere/x.geojson"], "there is no folder nowhere"),
        // Elsewhere `-` is standard output.
        (vec!["--from", "soon", "--to", "2024-04-01", "--path", "-"], "name a file"),
    ] {
        let out = find(&args);
        let stderr_text = String::from_utf8_lossy(&out.stderr);
        // The words of the other cases are right, but there is no answer.
        let is_failure = ["no central eclipse", "not at", "there is no folder nowhere"].contains(&message_part);
        assert_eq!(out.status.code(), Some(if is_failure { 1 } else { 2 }), "{args:?}: {stderr_text}");
        assert!(stderr_text.contains(message_part) && stderr_text.trim_end().lines().count() == 1, "{args:?}: {stderr_text}");
    }
    assert_eq!(find(&["--from", "2024-04-01"]).status.code(), Some(2));
}
