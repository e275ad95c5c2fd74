//! Verbs of the command line: exit statuses, JSON fields, one line for each invalid argument, reproducible output, closed streams.

use serde_json::Value;
use std::process::{Command, Output};

/// Runs the program without XDG_RUNTIME_DIR, as in a container, where drivers must not print either.
fn orrery(args: &[&str]) -> Output {
    let cache = crate::support::scratch::program_cache();
    Command::new(crate::support::program::path())
        .env_remove("XDG_RUNTIME_DIR")
        .args(args)
        .arg("--cache")
        .arg(cache)
        .output()
        .expect("the program starts")
}

fn json(args: &[&str]) -> Value {
    let out = orrery(args);
    assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
    serde_json::from_slice(&out.stdout).unwrap_or_else(|e| panic!("{args:?}: {e}"))
}

const ECLIPSE: &str = "2024-04-08T18:17:16Z";

#[test]
fn every_verb_has_help_and_an_example() {
    for verb in
        ["view", "render", "explain", "shader", "library", "ephemeris", "probe", "compare", "measure", "stability", "bench", "doctor"]
    {
        let out = orrery(&[verb, "--help"]);
        let text = String::from_utf8_lossy(&out.stdout).to_lowercase();
        assert!(out.status.success() && text.contains("usage"), "{verb}");
        assert!(text.contains("example"), "{verb} --help shows no example");
    }
}

/// An invented map that is visible is reported by `explain`, in its text and as a field, and in the image's metadata; a measured map is
/// not.
#[test]
fn invented_maps_are_reported() {
    let nearby = ["--distance-radii", "4", "--time", ECLIPSE];
    let folder = tempfile::tempdir().expect("a folder");
    for (body, invented) in [("callisto", true), ("iapetus", true), ("triton", true), ("phobos", true), ("moon", false), ("europa", false)]
    {
        let args = [&["explain", "--target", body], &nearby[..]].concat();
        let text = String::from_utf8(orrery(&args).stdout).expect("text");
        let line = text.lines().find(|l| l.trim_start().starts_with("+ albedo")).unwrap_or_else(|| panic!("{body}: {text}"));
        assert_eq!(line.contains("the map is invented: "), invented, "{line}");
        let all = json(&[&args[..], &["--json"]].concat());
        let explained_body =
            all["bodies"].as_array().expect("bodies").iter().find(|b| b["name"].as_str().is_some_and(|n| n.eq_ignore_ascii_case(body)));
        let list = explained_body.expect("the body")["invented"].as_array().expect("a list").len();
        assert_eq!(list > 0, invented, "{body}");
        let file = folder.path().join(format!("{body}.png"));
        let out = orrery(&[&["render", "--target", body, "--size", "32x32", "-o", file.to_str().expect("a path")], &nearby[..]].concat());
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        let bytes = std::fs::read(&file).expect("an image");
        let note = format!("invented: {body}.jpg");
        assert_eq!(bytes.windows(note.len()).any(|w| w == note.as_bytes()), invented, "{body}");
    }
    // The disc is too small to show its map, so nothing invented is visible.
    let from_far = json(&["explain", "--target", "callisto", "--from", "earth", "--fov", "20", "--time", ECLIPSE, "--json"]);
    let callisto = from_far["bodies"].as_array().expect("bodies").iter().find(|b| b["name"] == "Callisto").expect("Callisto");
    assert_eq!(callisto["invented"].as_array().map(Vec::len), Some(0));
}

/// The body at whose centre the camera is has no size, phase, magnitude or sub-observer point, and is not in a shadow for that; Io in Jupiter's umbra is.
#[test]
fn explain_tells_the_observers_own_body_from_one_in_shadow() {
    let view = ["explain", "--target", "moon", "--from", "earth", "--all", "--time", "2024-01-01", "--size", "64x64"];
    let line_of = |args: &[&str], body: &str| {
        let text = String::from_utf8(orrery(args).stdout).expect("text");
        text.lines().find(|l| l.starts_with(&format!("{body}: "))).unwrap_or_else(|| panic!("{body}: {text}")).to_owned()
    };
    assert_eq!(line_of(&view, "Earth"), "Earth: the camera is at its centre");
    assert!(line_of(&view, "Moon").contains(", magnitude -1"));
    let eclipsed = ["explain", "--target", "io", "--distance-radii", "5", "--time", "2024-12-08T06:30:00Z", "--size", "32x32"];
    assert!(line_of(&eclipsed, "Io").ends_with("magnitude none (in full shadow)"));
    let totality =
        ["explain", "--target", "sun", "--from", "earth", "--at", "32.779,-96.8", "--time", "2024-04-08T18:42:40Z", "--size", "32x32"];
    assert!(line_of(&totality, "Sun").ends_with("magnitude none (entirely hidden)"));
    let all = json(&[&view[..], &["--json"]].concat());
    let body = |name: &str| all["bodies"].as_array().expect("bodies").iter().find(|b| b["name"] == name).expect("in the list").clone();
    let (earth, moon) = (body("Earth"), body("Moon"));
    for field in ["angular_diameter_deg", "phase_angle_deg", "magnitude", "sub_viewer", "sun_altitude_deg"] {
        assert!(earth[field].is_null() && !moon[field].is_null(), "{field}: {} {}", earth[field], moon[field]);
    }
    assert!(earth["sub_solar"]["latitude_deg"].is_number() && earth["distance_km"] == 0.0, "{earth}");
}

#[test]
fn usage_errors_exit_with_2_and_failures_with_1_and_one_line() {
    for args in [&["paint"][..], &["render", "--sise", "3"], &["shader", "emit"], &["shader", "emit", "phong.sun1.sphere"]] {
        assert_eq!(orrery(args).status.code(), Some(2), "{args:?}");
    }
    for (args, code, message_part) in [
        (&["render", "--target", "nibiru", "-o", "/dev/null/x.png"][..], 2, "--target: no body"),
        (&["render", "--target", "earth", "--size", "0x9", "-o", "x.png"], 2, "--size 0x9"),
        (&["render", "--target", "earth", "--time", "someday", "-o", "x.png"], 2, "--time: time `someday`"),
        (&["render", "--target", "earth", "--effects", "+fog", "-o", "x.png"], 2, "--effects: "),
        (&["explain", "--target", "earth", "--layers", "+fog"], 2, "--layers: "),
        (&["explain", "--target", "earth", "--up", "down"], 2, "--up: "),
        (&["explain", "--target", "earth", "--fov", "0"], 2, "--fov: field of view 0.0"),
        (&["explain", "--target", "earth", "--exposure", "100"], 2, "--exposure: "),
        (&["explain", "--target", "earth", "--stars-boost", "100"], 2, "--stars-boost: "),
        (&["explain", "--target", "earth", "--telescope", "1000"], 2, "--telescope: "),
        (&["explain", "--target", "earth", "--distance-radii", "nan"], 2, "--distance-radii: "),
        (&["explain", "--target", "earth", "--at", "0,0", "--height-km", "nan"], 2, "--height-km"),
        (&["explain", "--target", "moon", "--from", "earth", "--at", "0,0", "--height-km", "-1"], 2, "--height-km: height -1.0"),
        (&["explain", "--target", "earth", "--tone-map", "film-noir"], 2, "--tone-map film-noir"),
        (&["render", "--target", "earth", "-o", "x.bmp"], 2, "-o x.bmp"),
        (&["render", "--target", "earth", "--step", "soon", "-o", "x.png"], 2, "--step soon"),
        (&["explain"], 2, "--target"),
        (&["shader", "keys", "--for", "nibiru"], 2, "--for: no body"),
        (&["ephemeris", "--body", "moon", "--center", "earth", "--time", "soon"], 2, "--time: time `soon`"),
        (&["ephemeris", "--body", "moon", "--center", "nibiru", "--time", "now"], 2, "--center: no body"),
        (&["bench", "--scene", "nothing"], 2, "--scene nothing"),
        (&["man", "nothing"], 2, "man nothing"),
        (&["probe", "{}"], 1, "\"q\""),
        (&["render", "--target", "earth", "-o", "/dev/null/x.png"], 1, "/dev/null"),
        (&["ephemeris", "--body", "moon", "--center", "earth", "--time", "9000-01-01"], 1, "9000-01-01"),
        (&["explain", "--target", "earth", "--kernel", "/nowhere.bsp"], 1, "/nowhere.bsp"),
        (&["explain", "--target", "earth", "--catalogs", "/nowhere"], 1, "/nowhere: there is no such folder; --catalogs takes"),
        (&["explain", "--target", "earth", "--shaders", "/nowhere"], 1, "/nowhere: there is no such folder; `orrery shader export`"),
    ] {
        let out = orrery(args);
        let stderr_text = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(code), "{args:?}: {stderr_text}");
        assert!(stderr_text.trim().lines().count() == 1 && stderr_text.contains(message_part), "{args:?}: {stderr_text}");
        assert!(out.stdout.is_empty(), "{args:?} printed a result");
    }
}

/// With --overwrite, a wrong folder of shader sources is reported before anything of the earlier export is removed.
#[test]
fn a_failed_export_leaves_the_earlier_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let manifest = folder.path().join(orrery::export::corpus::MANIFEST);
    let case = folder.path().join("cases").join("a.json");
    let manifest_text = r#"{"revision":"built-in","cases":["a"]}"#;
    std::fs::create_dir(folder.path().join("cases")).expect("made");
    std::fs::write(&case, "{}").expect("written");
    std::fs::write(&manifest, manifest_text).expect("written");
    let path = folder.path().to_str().expect("a path");
    let out = orrery(&["shader", "corpus", "-o", path, "--covering", "2", "--overwrite", "--shaders", "/nowhere/shaders"]);
    let stderr_text = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.code() == Some(1) && stderr_text.contains("/nowhere/shaders"), "{stderr_text}");
    assert!(case.is_file());
    assert_eq!(std::fs::read_to_string(&manifest).expect("there"), manifest_text);
}

/// clap does not demand an option that another one excludes, and an option without the one that it needs would have no effect.
#[test]
fn options_whose_required_option_is_excluded_are_refused() {
    let at_time = ["ephemeris", "--body", "moon", "--time", "2024-01-01"];
    let measure = ["measure", "--short", "--choice", "ephemeris"];
    let mut cases = vec![
        vec!["ephemeris", "--stdin", "--rise-set"],
        vec!["ephemeris", "--stdin", "--to", "2024-01-01", "--step", "1d"],
        [&at_time[..], &["--rise-set", "--apparent"]].concat(),
        [&at_time[..], &["--rise-set", "--orientation"]].concat(),
        [&at_time[..], &["--rise-set", "--center", "earth"]].concat(),
        [&at_time[..], &["--rise-set", "--center", "earth", "--source", "mean"]].concat(),
        [&at_time[..], &["--center", "earth", "--to", "2024-01-01", "--step", "1d"]].concat(),
        [&at_time[..], &["--at", "1,1", "--rise-set", "--csv", "--to", "2024-01-01", "--step", "1d"]].concat(),
        [&measure[..], &["--time", "2024-01-01"]].concat(),
        [&measure[..], &["--time", "2024-01-01", "--distance-radii", "3"]].concat(),
        [&measure[..], &["--size", "8x8"]].concat(),
        vec!["measure", "--short", "-o", "a.svg", "--time", "2024-01-01"],
        vec!["shader", "keys", "--covering", "2", "--time", "2024-01-01"],
        vec!["shader", "keys", "--simple", "--time", "2024-01-01"],
        vec!["shader", "corpus", "-o", "/nowhere/corpus", "--covering", "2", "--time", "2024-01-01"],
        vec!["shader", "verify", "--record", "/nowhere/digests.txt", "--json"],
        vec!["explain", "--camera-json", "/nowhere/camera.json", "--height-km", "3"],
    ];
    if crate::support::program::has_view() {
        cases.push(vec!["render", "--tour", "/nowhere/tour.json", "--height-km", "3", "-o", "a.gif"]);
    }
    for args in cases {
        let out = orrery(&args);
        let stderr_text = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.code() == Some(2) && out.stdout.is_empty(), "{args:?}: {:?} {stderr_text}", out.status);
    }
}

#[test]
fn the_same_command_writes_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let draw = |target: &str, name: &str| {
        let path = folder.path().join(name);
        let args = ["render", "--target", target, "--time", ECLIPSE, "--size", "96x64", "-o"];
        let out = orrery(&[&args[..], &[path.to_str().expect("a path")]].concat());
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        std::fs::read(path).expect("written")
    };
    // The Earth has the most features; for EXR any image will do.
    for (target, kind) in [("earth", "png"), ("io", "exr")] {
        assert_eq!(draw(target, &format!("a.{kind}")), draw(target, &format!("b.{kind}")), "{kind}");
    }
}

/// Evaluation in f64 changes fewer than 40 values by more than 4 levels, at edges where texture coordinates are rounded, and the mean
/// change is below 0.03 levels (measured: 8 values, and 0.007).
#[test]
fn the_reference_quality_draws_the_standard_image() {
    let folder = tempfile::tempdir().expect("a folder");
    let draw = |quality: &str, time: &str| {
        let path = folder.path().join("mars.png");
        let args = ["render", "--target", "mars", "--time", time, "--size", "96x96", "--quality", quality, "--overwrite", "-o"];
        let out = orrery(&[&args[..], &[path.to_str().expect("a path")]].concat());
        assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
        image::open(path).expect("an image").into_rgb8().into_raw()
    };
    let (standard, reference) = (draw("standard", ECLIPSE), draw("reference", ECLIPSE));
    let mean_difference = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64;
    let (different, mean) =
        (standard.iter().zip(&reference).filter(|(a, b)| a.abs_diff(**b) > 4).count(), mean_difference(&standard, &reference));
    assert!(different < 40 && mean < 0.03, "{different} values differ by more than 4 of 255, {mean} in the mean");
    assert!(standard.iter().any(|v| *v > 60), "the image is not black");
    // Negative control: in a minute Mars rotates by a quarter of a degree.
    let later = mean_difference(&draw("standard", "2024-04-08T18:18:16Z"), &reference);
    assert!(later > 0.1, "a minute changes the image by {later} levels in the mean");
}

#[test]
fn json_answers_have_their_fields() {
    let state = json(&["ephemeris", "--body", "moon", "--center", "earth", "--time", ECLIPSE, "--json"]);
    assert!(state["pos_km"].as_array().is_some_and(|v| v.len() == 3) && state["error_km"].is_number(), "{state}");
    let explained = json(&["explain", "--target", "earth", "--time", ECLIPSE, "--json"]);
    let earth = explained["bodies"].as_array().and_then(|b| b.iter().find(|b| b["name"] == "Earth")).expect("the Earth");
    assert!(earth["features"].as_array().is_some_and(|f| f.len() > 5) && earth["key"].is_string(), "{earth}");
    let estimate = "estimated albedo 0.434 ±50 %, up to 0.75 mag in brightness";
    assert!(earth["estimates"].as_array().is_some_and(|e| e.iter().any(|line| line == estimate)), "{earth}");
    // Each effect that has models lists the chosen model and its error.
    for (feature, model) in [("atmosphere", "table"), ("eclipse", "limb-darkened")] {
        let found = earth["features"].as_array().and_then(|f| f.iter().find(|f| f["feature"] == feature)).expect(feature);
        assert!(found["tier"]["name"] == model && found["tier"]["at_most"].as_f64().is_some_and(|e| e > 0.0), "{found}");
    }
    let draft = orrery(&["--quality", "draft", "explain", "--target", "earth", "--time", ECLIPSE]);
    let draft = String::from_utf8_lossy(&draft.stdout);
    assert!(
        draft.contains("pixel-8: error at most 90 %") && draft.contains("uniform-disc: error at most 10 % of the Sun's light"),
        "{draft}"
    );
    assert!(draft.contains(estimate), "{draft}");
    let keys = json(&["shader", "keys", "--for", "earth", "--time", ECLIPSE, "--json"]);
    assert!(keys.as_array().is_some_and(|k| k.iter().any(|k| *k == earth["key"])), "{keys}");
    let cost = json(&["shader", "cost", "lambert.albedo.sun1.ellipsoid", "--json"]);
    assert!(cost["ms_per_megapixel"].as_f64().is_some_and(|ms| ms > 0.0), "{cost}");
    let fragment = &cost["tapes"][1];
    assert!(fragment["texture_reads"] == 2 && fragment["slots"].as_u64() > Some(3), "{fragment}");
    let status = json(&["library", "status", "--json"]);
    assert!(status["entries"].is_number(), "{status}");
}

#[test]
fn the_cost_of_a_mesh_states_that_it_is_not_timed() {
    let out = orrery(&["shader", "cost", "lambert.sun1.mesh"]);
    assert!(String::from_utf8_lossy(&out.stdout).contains("not timed"));
}

#[test]
fn compare_reports_differences_and_refuses_unequal_sizes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a path").to_owned();
    let save = |name: &str, width: u32, level: u8| {
        image::RgbImage::from_fn(width, 10, |x, y| image::Rgb([if x + y == 0 { level } else { 40 }; 3])).save(path(name)).expect("saved");
    };
    save("a.png", 10, 40);
    save("b.png", 10, 60);
    save("wide.png", 11, 40);
    let compared = json(&["compare", &path("a.png"), &path("b.png"), "-o", &path("d.png"), "--json"]);
    // One pixel of 100 differs, by 20.
    assert!(
        (compared["mean"].as_f64().expect("mean") - 0.2).abs() < 1e-12
            && compared["max"] == 20
            && compared["p999"] == 20
            && compared["pixels"] == 100,
        "{compared}"
    );
    assert!((compared["psnr_db"].as_f64().expect("psnr") - 10.0 * (255.0_f64 * 255.0 / 4.0).log10()).abs() < 1e-9, "{compared}");
    let difference = image::open(path("d.png")).expect("an image").into_rgb8();
    assert!(difference.get_pixel(0, 0).0 == [255; 3] && difference.get_pixel(5, 5).0 == [0; 3]);
    let compare = |args: &[&str]| orrery(&[&["compare"], args].concat());
    assert_eq!(compare(&[&path("a.png"), &path("b.png"), "--tolerance", "20"]).status.code(), Some(0));
    for (args, code, message_part) in [
        (&[&*path("a.png"), &*path("b.png"), "--tolerance", "19"][..], 1, "20 levels"),
        (&[&path("a.png"), &path("wide.png")], 1, "10x10 and 11x10"),
        (&[&path("a.png"), &path("none.png")], 1, "none.png"),
        (&[&path("a.png"), &path("b.png"), "--tolerance", "-1"], 2, "--tolerance -1"),
        (&[&path("a.png"), &path("b.png"), "-o", &path("d.jpg")], 2, "must end in .png"),
        (&[&path("a.png"), &path("b.png"), "-o", "-"], 2, "must end in .png"),
    ] {
        let out = compare(args);
        let stderr_text = String::from_utf8_lossy(&out.stderr);
        assert!(
            out.status.code() == Some(code) && stderr_text.trim().lines().count() == 1 && stderr_text.contains(message_part),
            "{args:?}: {stderr_text}"
        );
    }
}

#[test]
fn without_a_driver_the_gpu_is_refused_and_the_default_draws_in_software() {
    let folder = tempfile::tempdir().expect("a folder");
    let png = folder.path().join("x.png");
    let png = png.to_str().expect("a path");
    // Paths of Vulkan and EGL drivers that do not exist.
    let no_drivers =
        [("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent"), ("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent")];
    let without_drivers =
        |args: &[&str]| Command::new(crate::support::program::path()).args(args).envs(no_drivers).output().expect("the program starts");
    let render = ["render", "--target", "moon", "--size", "16x16", "-o", png];
    for args in [
        &[&render[..], &["--renderer", "gpu"]].concat()[..],
        &["bench", "--scene", "whole-system", "--renderer", "gpu", "--size", "16x16", "--frames", "1"],
    ] {
        let out = without_drivers(args);
        let stderr_text = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.code() == Some(1) && stderr_text.trim().lines().count() == 1, "{args:?}: {stderr_text}");
        assert!(stderr_text.contains("--renderer software"), "{args:?}: {stderr_text}");
        assert!(!std::path::Path::new(png).exists(), "nothing is written");
    }
    // With the default renderer it draws in software, and a build with the GPU renderer reports that once.
    let out = without_drivers(&render);
    let stderr_text = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success() && std::path::Path::new(png).exists(), "{stderr_text}");
    let expected = if crate::support::program::has_gpu() { 1 } else { 0 };
    assert_eq!(stderr_text.trim().lines().filter(|l| l.contains("drawing in software")).count(), expected, "{stderr_text}");
    std::fs::remove_file(png).expect("it exists");
    let drawn = orrery(&["render", "--target", "moon", "--size", "16x16", "-o", png, "--renderer", "software"]);
    assert!(drawn.status.success() && std::path::Path::new(png).exists());
}

#[test]
fn the_stages_of_a_time_report_fit_into_the_first_frames_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = folder.path().join("moon.png");
    let start = std::time::Instant::now();
    let args = ["render", "--target", "moon", "--time", ECLIPSE, "--size", "32x32", "--renderer", "software", "--time-report", "-o"];
    let report = json(&[&args[..], &[image.to_str().expect("a plain name")]].concat());
    let whole_ms = 1e3 * start.elapsed().as_secs_f64();
    let stages = report["stages"].as_object().expect("stages");
    let stages_ms: f64 = stages.iter().filter(|(name, _)| *name != "write_ms").map(|(_, ms)| ms.as_f64().expect("milliseconds")).sum();
    let first_ms = report["first_frame_ms"].as_f64().expect("a frame was drawn");
    assert!(stages_ms > 0.0 && stages.contains_key("draw_ms"), "{report}");
    assert!(stages_ms <= first_ms && first_ms <= whole_ms, "stages {stages_ms}, first frame {first_ms}, whole run {whole_ms}");
    assert_eq!((&report["frames"], &report["renderer"]), (&serde_json::json!(1), &serde_json::json!("software")));
}

/// Standard output and the image are the same with and without `-v`.
#[test]
fn verbose_runs_print_their_times_to_standard_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |args: &[&str], name: &str| {
        let image = folder.path().join(name);
        let out = orrery(&[args, &["-o", image.to_str().expect("a plain name")]].concat());
        assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
        (out.stdout, String::from_utf8(out.stderr).expect("text"), std::fs::read(image).expect("an image"))
    };
    let render = ["render", "--target", "moon", "--time", ECLIPSE, "--size", "16x16", "--renderer", "software"];
    let (quiet, verbose) = (run(&render, "a.png"), run(&[&render[..], &["-v"]].concat(), "b.png"));
    assert_eq!((&quiet.0, quiet.1.as_str(), &quiet.2), (&verbose.0, "", &verbose.2));
    let [stages, total] = verbose.1.lines().collect::<Vec<_>>()[..] else { panic!("{}", verbose.1) };
    assert!(stages.starts_with("orrery: drew 1 frame by software: catalog ") && stages.contains(", draw "), "{stages}");
    assert!(total.starts_with("orrery: done in ") && total.ends_with(" s"), "{total}");
    // A verb that draws nothing prints one line.
    let other = orrery(&["ephemeris", "--body", "moon", "--center", "earth", "--time", ECLIPSE, "-v"]);
    let other = String::from_utf8(other.stderr).expect("text");
    assert!(other.starts_with("orrery: done in ") && other.lines().count() == 1, "{other}");
}

/// One problem does not hide another. A number of threads of 0 means one for each core.
#[test]
fn doctor_reads_the_data_files_of_every_option() {
    let folder = tempfile::tempdir().expect("a folder");
    let stars = folder.path().join("stars.csv");
    std::fs::write(&stars, "ra_deg,dec_deg,v_mag\n10,10,1\n").expect("written");
    let report = |stars: &str| {
        let files = ["--stars", stars, "--minor-planets", "none.csv", "--lunar-heights", "none.png", "--sky", "none.png"];
        let out = orrery(&[&["doctor", "--renderer", "software", "--threads", "0"], &files[..]].concat());
        let message = super::stderr_text(&out);
        assert!(out.status.code() == Some(1) && message.lines().count() == 1 && message.contains(": data"), "{message}");
        String::from_utf8_lossy(&out.stdout).into_owned()
    };
    let text = report("none.csv");
    for option in ["--stars", "--minor-planets", "--lunar-heights", "--sky"] {
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with(&format!("data      {option}: none."))).collect();
        let [line] = lines[..] else { panic!("{option}: {text}") };
        assert!(line.matches("none.").count() == 1 && line.matches(&format!("{option}: ")).count() == 1, "{line}");
    }
    assert!(!text.contains("on 0 threads"), "{text}");
    let text = report(stars.to_str().expect("a path"));
    assert!(text.contains("the file of --stars can be read") && !text.contains("data      --stars"), "{text}");
}

/// An existing file with the same bytes is accepted.
#[test]
fn compare_overwrites_another_file_only_with_overwrite() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a path").to_owned();
    for (name, level) in [("a.png", 40), ("b.png", 60)] {
        image::RgbImage::from_pixel(4, 4, image::Rgb([level; 3])).save(path(name)).expect("saved");
    }
    let compare = |more: &[&str]| orrery(&[&["compare", &*path("a.png"), &*path("b.png"), "-o", &*path("d.png")], more].concat());
    assert!(compare(&[]).status.success() && compare(&[]).status.success(), "an existing file with the same bytes must be accepted");
    let difference = std::fs::read(path("d.png")).expect("an image");
    std::fs::write(path("d.png"), "mine").expect("a file");
    let refused = compare(&[]);
    let stderr_text = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(1) && refused.stdout.is_empty(), "{stderr_text}");
    assert!(
        stderr_text.trim().lines().count() == 1 && stderr_text.contains("d.png") && stderr_text.contains("--overwrite"),
        "{stderr_text}"
    );
    assert_eq!(std::fs::read(path("d.png")).expect("a file"), b"mine");
    assert!(compare(&["--overwrite"]).status.success());
    assert_eq!(std::fs::read(path("d.png")).expect("an image"), difference);
}

/// Verbs that print end without a panic if standard output or standard error is closed, and a closed pipe is not a failure.
#[test]
fn closed_streams_end_every_verb_quietly() {
    use std::process::Stdio;
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a path").to_owned();
    image::RgbImage::new(4, 4).save(path("a.png")).expect("saved");
    // A pipe whose other end is closed before anything is written.
    let closed = || {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        Stdio::from(writer)
    };
    let (a, b, cache) = (path("a.png"), path("b.png"), path("cache"));
    let render = ["render", "--target", "moon", "--time", ECLIPSE, "--size", "16x16", "--renderer", "software"];
    let successful: &[&[&str]] = &[
        &["--help"],
        &["doctor", "--renderer", "software"],
        &["library", "status"],
        &["library", "verify"],
        &["library", "clear", "--json"],
        &["shader", "keys", "--simple"],
        &["shader", "emit", "lambert.sun1.sphere"],
        &["ephemeris", "--body", "moon", "--center", "earth", "--time", ECLIPSE],
        &["probe", "--questions"],
        &["compare", &a, &a],
        &["explain", "--target", "moon", "--time", ECLIPSE],
        &["completions", "bash"],
        &["man"],
        &[&render[..], &["--time-report", "-o", &b]].concat(),
        &[&render[..], &["--frames", "3", "-o", "-"]].concat(),
    ];
    let failing: &[&[&str]] = &[&["compare", &a, "none.png"], &["man", "nothing"], &["shader", "emit", "nothing"], &["--nothing"]];
    let run = |args: &[&str], out: Stdio, err: Stdio| {
        let mut command = Command::new(crate::support::program::path());
        command.args(args).env("XDG_CACHE_HOME", &cache).stdin(Stdio::null()).stdout(out).stderr(err);
        command.spawn().and_then(|child| child.wait_with_output()).expect("the program runs")
    };
    for args in successful {
        let done = run(args, closed(), Stdio::piped());
        let stderr_text = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success() && stderr_text.is_empty(), "{args:?}: {:?}, {stderr_text}", done.status);
        // Closed standard error does not change the result.
        assert!(run(args, Stdio::null(), closed()).status.success(), "{args:?}");
    }
    for args in failing {
        let code = run(args, closed(), closed()).status.code();
        assert!(matches!(code, Some(1 | 2)), "{args:?}: {code:?}");
    }
    // Output to a full device fails, with an error.
    for args in [&["man"][..], &["--help"], &["--version"], &["render", "--help"], &["help", "render"]] {
        let Ok(full) = std::fs::File::options().write(true).open("/dev/full") else { continue };
        let done = run(args, full.into(), Stdio::piped());
        let stderr_text = String::from_utf8_lossy(&done.stderr);
        assert!(
            done.status.code() == Some(1) && stderr_text.trim().lines().count() == 1 && stderr_text.contains("standard output"),
            "{args:?}: {stderr_text}"
        );
    }
}
