//! `orrery bench`: the fields of its JSON, and its errors.

use serde_json::Value;
use std::process::{Command, Output};

fn bench(args: &[&str]) -> Output {
    let cache = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(crate::support::program::path());
    command.args(["--renderer", "software", "bench"]).args(args).arg("--cache").arg(cache.path()).output().expect("the program runs")
}

/// The report with neither `--effects` nor `--counts`.
fn report_of_saturn() -> String {
    let out = bench(&["--scene", "saturn", "--size", "9x9", "--frames", "1"]);
    let report = String::from_utf8_lossy(&out.stdout).into_owned();
    // Without a report, a test that it lacks something could not fail.
    assert!(out.status.success() && report.contains("\"saturn\""), "{report}{}", String::from_utf8_lossy(&out.stderr));
    report
}

fn number(value: &Value, what: &str) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{what} is {value}, not a number"))
}

#[test]
fn the_report_is_one_json_value_whose_stages_fit_into_the_frame() {
    let out = bench(&["--json", "--scene", "saturn", "--scene", "moon-limb,whole-system", "--size", "48x32", "--frames", "2"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(out.stderr.is_empty(), "into a pipe it must not report progress: {}", String::from_utf8_lossy(&out.stderr));
    let report: Value = serde_json::from_slice(&out.stdout).expect("one JSON value");
    assert_eq!((&report["width"], &report["height"], &report["frames"]), (&48.into(), &32.into(), &2.into()));
    assert!(number(&report["threads"], "threads") >= 1.0);
    let scenes = report["scenes"].as_array().expect("a list");
    let names: Vec<_> = scenes.iter().filter_map(|s| s["scene"].as_str()).collect();
    assert_eq!(names, ["saturn", "moon-limb", "whole-system"]);
    for scene in scenes {
        let (median, least) = (number(&scene["median_ms"], "median_ms"), number(&scene["least_ms"], "least_ms"));
        assert!(0.0 < least && least <= median, "{scene}");
        let stages = scene["stages"].as_object().expect("an object");
        assert_eq!(stages.keys().map(String::as_str).collect::<Vec<_>>(), ["draw_ms", "maps_ms", "plan_ms", "scene_ms", "shaders_ms"]);
        // Each of the six figures is rounded to a microsecond.
        let sum: f64 = stages.values().map(|v| number(v, "a stage")).sum();
        assert!(sum <= median + 0.003, "stages take {sum} of {median} ms");
        for cpu in scene["stages_cpu"].as_object().expect("an object").values().chain([&scene["median_cpu_ms"]]) {
            assert!(cpu.is_null() || number(cpu, "a CPU time") >= 0.0);
            assert!(
                cpu.is_f64() || !std::path::Path::new("/proc/self/schedstat").exists(),
                "the system counts CPU times, but the report has none"
            );
        }
    }
}

/// The first line says what is wrong. To an option that clap refuses it adds an empty line and a reference to `--help`.
#[test]
fn invalid_arguments_are_refused_in_one_helpful_line() {
    for (args, is_of_clap, message_part) in
        [(["--scene", "pluto"], false, "whole-system"), (["--size", "9"], false, "--size"), (["--frames", "0"], true, "--frames")]
    {
        let out = bench(&args);
        let message = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{args:?}: {message}");
        let lines: Vec<&str> = message.lines().collect();
        assert!(lines[0].contains(message_part), "{args:?}: {message}");
        let clap_lines: &[&str] = if is_of_clap { &["", "For more information, try '--help'."] } else { &[] };
        assert_eq!(lines[1..], *clap_lines, "{args:?}");
        assert!(out.stdout.is_empty());
    }
}

/// Each shape model has more than three times the triangles of the previous one, times above 0, and a median ratio between its quartiles.
#[test]
fn meshes_are_timed_in_a_table_of_their_own() {
    let out = bench(&["--meshes", "--size", "64x64", "--frames", "2"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let report: Value = serde_json::from_slice(&out.stdout).expect("one JSON value");
    let rows = report["meshes"].as_array().expect("a list");
    let triangles: Vec<u64> = rows.iter().filter_map(|r| r["triangles"].as_u64()).collect();
    assert!(triangles.len() >= 4 && triangles.windows(2).all(|w| w[1] > 3 * w[0]), "{triangles:?}");
    for row in rows {
        assert!(number(&row["read_ms"], "read_ms") > 0.0 && number(&row["trace_shadow_ms"], "trace_shadow_ms") > 0.0, "{row}");
        for ratio in [&row["mesh"], &row["without_self_shadow"]] {
            let (median, quartiles) = (number(&ratio["median"], "median"), &ratio["quartiles"]);
            assert!(number(&quartiles[0], "low") <= median && median <= number(&quartiles[1], "high"), "{ratio}");
        }
    }
    assert_eq!(bench(&["--meshes", "--scene", "saturn"]).status.code(), Some(2), "--meshes excludes --scene");
}

#[test]
fn the_scene_of_a_million_stars_can_be_timed() {
    let out = bench(&["--scene", "million-stars", "--size", "64x64", "--frames", "1"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let report: Value = serde_json::from_slice(&out.stdout).expect("one JSON value");
    assert_eq!(report["scenes"][0]["scene"], "million-stars");
}

#[test]
fn each_active_effect_has_its_cost_and_light_change() {
    let out = bench(&["--effects", "--scene", "saturn", "--size", "64x64", "--frames", "2"]);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let report: Value = serde_json::from_slice(&out.stdout).expect("one JSON value");
    let effects = report["scenes"][0]["effects"].as_array().expect("a list");
    // The light of an effect, whose costs are checked, too.
    let checked_light = |name: &str| {
        let row = effects.iter().find(|e| e["name"] == name).unwrap_or_else(|| panic!("{name} is not in {effects:?}"));
        // In so small an image most costs are below the noise; none may be negative, and the noise must be reported.
        for (cost, noise) in [("wall_ms", "wall_noise_ms"), ("cpu_ms", "cpu_noise_ms")] {
            assert!(row[cost].is_null() == row[noise].is_null() && (cost == "cpu_ms" || row[cost].is_f64()), "{row}");
            assert!([cost, noise].iter().all(|c| row[*c].as_f64().is_none_or(|ms| ms >= 0.0)), "{row}");
        }
        number(&row["light"], "light")
    };
    assert!(effects.iter().all(|e| e["wall_ms"].as_f64().is_some_and(|ms| ms >= 0.0)), "{effects:?}");
    // The rings add more light to the image than their shadow removes. Saturn has no clouds in the catalog.
    let (rings, ring_shadow) = (checked_light("rings"), checked_light("ring-shadow"));
    assert!(rings > 0.1 && rings < 1.0 && ring_shadow < rings);
    assert!(effects.iter().all(|e| e["name"] != "clouds"), "{effects:?}");
    assert!(!report_of_saturn().contains("\"effects\""));
}

/// Twice the width and height are four times the pixels, and the operations per pixel stay the same.
#[test]
fn counted_operations_grow_with_the_number_of_pixels() {
    let counts = |size: &str| {
        let out = bench(&["--counts", "--scene", "moon-limb", "--size", size, "--frames", "1"]);
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let report: Value = serde_json::from_slice(&out.stdout).expect("one JSON value");
        ["shaded_pixels", "operations", "texture_reads"].map(|name| number(&report["scenes"][0]["counts"][name], name))
    };
    // At these sizes a pixel is no smaller than a texel.
    let (small, large) = (counts("48x48"), counts("96x96"));
    let [shaded_pixels, operations, texture_reads] = small;
    assert!(shaded_pixels > 0.0 && shaded_pixels < 48.0 * 48.0, "there is sky beside the Moon: {small:?}");
    assert!(
        operations > 20.0 * shaded_pixels && texture_reads >= shaded_pixels,
        "each shaded pixel must take operations and read a map: {small:?}"
    );
    for (of_small, of_large) in small.into_iter().zip(large) {
        assert!((of_large / of_small / 4.0 - 1.0).abs() < 0.1, "{small:?} {large:?}");
    }
    assert!(!report_of_saturn().contains("\"counts\""));
}
