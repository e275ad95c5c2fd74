//! The disk cache with all its parts, and what `doctor` finds: files of maps that nothing uses, folders that cannot be written, as text and as JSON.

use super::{path_text, stderr_text};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

fn orrery(cache: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(crate::support::program::path());
    command.args(["--renderer", "software", "--cache", path_text(cache)]).args(args).output().expect("starts")
}

fn json(cache: &Path, args: &[&str]) -> Value {
    let out = orrery(cache, args);
    serde_json::from_slice(&out.stdout).unwrap_or_else(|e| panic!("{args:?}: {e}, {}", stderr_text(&out)))
}

/// A small view of the Earth computes a table of its air, and one of Saturn tables of ring-shine.
#[test]
fn the_library_covers_the_tables() {
    let folder = tempfile::tempdir().expect("a folder");
    let cache = folder.path().join("cache");
    for target in ["earth", "saturn"] {
        let image = folder.path().join(target).with_extension("png");
        let view = ["render", "--target", target, "--time", "2017-05-17", "--size", "64x64", "-o", path_text(&image)];
        let out = orrery(&cache, &view);
        assert!(out.status.success(), "{}", stderr_text(&out));
    }
    let files = |name: &str| -> Vec<_> {
        std::fs::read_dir(cache.join("orrery").join(name)).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
    };
    let tables = [files("air"), files("rings")].concat();
    assert!(!files("air").is_empty(), "no table was stored");
    let status = json(&cache, &["library", "status", "--json"]);
    assert_eq!(status["tables"]["entries"], tables.len(), "{status}");
    assert!(status["tables"]["bytes"].as_u64() > Some(1000), "{status}");
    assert_eq!(json(&cache, &["library", "verify", "--json"])["valid_tables"], tables.len());
    let mut bytes = std::fs::read(&tables[0]).expect("a table");
    bytes.pop();
    std::fs::write(&tables[0], bytes).expect("written");
    let damaged = orrery(&cache, &["library", "verify"]);
    assert_eq!(damaged.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&damaged.stdout).contains(path_text(&tables[0])), "{damaged:?}");
    assert!(orrery(&cache, &["library", "clear"]).status.success());
    assert!(files("air").is_empty() && files("rings").is_empty());
    assert_eq!(json(&cache, &["library", "status", "--json"])["tables"]["entries"], 0);
}

/// Filling takes minutes, and nothing would be stored.
#[test]
fn warm_refuses_a_folder_that_cannot_be_written_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    std::fs::write(&file, "").expect("written");
    let start = Instant::now();
    let out = orrery(&file, &["library", "warm"]);
    assert!(start.elapsed() < Duration::from_secs(30), "{:?}", start.elapsed());
    let line = stderr_text(&out);
    assert!(out.status.code() == Some(1) && line.lines().count() == 1 && line.contains("--cache"), "{line}");
    assert!(line.contains(path_text(&file)), "{line}");
}

#[test]
fn maps_with_misspelt_names_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let (maps, cache) = (folder.path().join("maps"), folder.path().join("cache"));
    std::fs::create_dir(&maps).expect("made");
    let save = |name: &str| {
        image::RgbImage::from_pixel(8, 4, image::Rgb([90; 3])).save_with_format(maps.join(name), image::ImageFormat::Png).expect("saved");
    };
    let explained = || {
        let out = orrery(&cache, &["explain", "--target", "mars", "--time", "2024-01-01", "--textures", path_text(&maps)]);
        assert!(out.status.success(), "{}", stderr_text(&out));
        stderr_text(&out)
    };
    let checked = || json(&cache, &["doctor", "--textures", path_text(&maps), "--json"]);
    let about_unused = |report: &Value| -> Vec<String> {
        let lines = report["lines"].as_array().expect("lines").iter();
        lines.filter_map(|l| l["text"].as_str()).filter(|l| l.starts_with("not used")).map(str::to_owned).collect()
    };
    assert_eq!(explained(), "", "an empty folder is one that the user may still fill");
    save("mras.jpg");
    let line = explained();
    assert!(line.lines().count() == 1 && line.contains("mras.jpg") && line.contains("did you mean `mars.jpg`"), "{line}");
    save("mars.jpg");
    assert_eq!(explained(), "", "one map is replaced");
    let report = checked();
    let unused_lines = about_unused(&report);
    let [unused] = &unused_lines[..] else { panic!("{report}") };
    assert!(unused.contains("mras.jpg") && report["problems"] == 1, "{report}");
    std::fs::remove_file(maps.join("mras.jpg")).expect("removed");
    let report = checked();
    assert!(about_unused(&report).is_empty() && report["problems"] == 0, "{report}");
}

/// `doctor` had said of a file and of a file system without space for files that the folder would be created.
#[test]
fn doctor_says_whether_the_cache_can_be_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    std::fs::write(&file, "").expect("written");
    let about_cache = |cache: &Path| {
        let report = json(cache, &["doctor", "--json"]);
        let line = report["lines"].as_array().expect("lines").iter().find(|l| l["topic"] == "cache").cloned();
        line.unwrap_or_else(|| panic!("{report}"))
    };
    let text = |line: &Value| line["text"].as_str().unwrap_or_default().to_owned();
    let missing = about_cache(&folder.path().join("missing"));
    assert!(missing["problem"] == false && text(&missing).contains("does not exist yet"), "{missing}");
    assert!(!folder.path().join("missing").exists(), "doctor creates nothing");
    let unusable = about_cache(&file);
    assert!(unusable["problem"] == true && text(&unusable).contains("not a folder"), "{unusable}");
    if cfg!(target_os = "linux") {
        assert_eq!(about_cache(Path::new("/proc/none"))["problem"], true);
    }
}

#[test]
fn doctor_and_diff_print_one_json_value() {
    let cache = crate::support::scratch::program_cache();
    let report = json(&cache, &["doctor", "--minor-planets", "none.csv", "--surface", "nibiru=none.wesl", "--json"]);
    let problems = report["lines"].as_array().expect("lines").iter().filter(|l| l["problem"] == true);
    let topics: Vec<&str> = problems.filter_map(|l| l["topic"].as_str()).collect();
    assert!(topics.contains(&"data") && topics.contains(&"shaders") && report["problems"] == topics.len(), "{report}");
    let differences = json(&cache, &["shader", "diff", "lambert.sun1.sphere", "lambert.albedo.sun1.sphere", "--json"]);
    let features = differences.as_array().expect("a list");
    let lines = features.iter().flat_map(|f| f["only_second"].as_array().expect("lines"));
    assert!(lines.clone().any(|l| l["text"].as_str().is_some_and(|t| t.contains("albedo_map"))), "{differences}");
    assert!(lines.clone().all(|l| l["line"].as_u64() > Some(0) && l["fragment"].is_string()), "{differences}");
    let same = json(&cache, &["shader", "diff", "tone_map", "tone_map", "--json"]);
    assert_eq!(same, serde_json::json!([]));
}

/// A failure is a problem with which other commands end, and `doctor` says so by its exit status. It was always 0.
#[test]
fn doctor_fails_if_and_only_if_other_commands_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let path_of = |name: &str| folder.path().join(name);
    let (cache, maps, bodies, file) = (path_of("cache"), path_of("maps"), path_of("bodies"), path_of("file"));
    [&maps, &bodies].iter().for_each(|folder| std::fs::create_dir(folder).expect("made"));
    std::fs::write(&file, "no data").expect("written");
    std::fs::write(maps.join("mars.jpg"), "no image").expect("written");
    std::fs::write(bodies.join("a.toml"), "[[body]]\nid = 401\ncolour = 3\n").expect("written");
    let (missing, file) = (path_of("missing"), path_text(&file));
    // Options, the topic of the problem, and whether it is a failure.
    let cases: [(&[&str], &str, bool); 10] = [
        (&["--catalogs", path_text(&bodies)], "catalogs", true),
        (&["--catalogs", path_text(&missing)], "catalogs", true),
        (&["--kernel", file], "kernel", true),
        (&["--textures", path_text(&missing)], "textures", true),
        (&["--shaders", path_text(&missing)], "shaders", true),
        (&["--surface", "nibiru=none.wesl"], "shaders", true),
        (&["--stars", file], "data", true),
        (&["--sky", file], "data", true),
        (&["--textures", path_text(&maps)], "textures", false),
        (&[], "cache", false),
    ];
    for (options, topic, fails) in cases {
        // A file in place of the cache folder.
        let cache = if topic == "cache" { Path::new(file) } else { &cache };
        let out = orrery(cache, &[&["doctor", "--json"], options].concat());
        let report: Value = serde_json::from_slice(&out.stdout).expect("JSON");
        let lines = report["lines"].as_array().expect("lines");
        let count = |field: &str| lines.iter().filter(|line| line[field] == true).count();
        assert_eq!((count("problem") > 0, count("failure") > 0), (true, fails), "{options:?}: {report}");
        assert!(lines.iter().filter(|line| line["problem"] == true).all(|line| line["topic"] == topic), "{options:?}: {report}");
        assert!(report["problems"] == count("problem") && report["failures"] == count("failure"), "{options:?}: {report}");
        assert_eq!(out.status.code(), Some(i32::from(fails)), "{options:?}: {report}");
        let message = stderr_text(&out);
        assert_eq!((message.lines().count(), message.contains(topic)), (usize::from(fails), fails), "{options:?}: {message}");
        let explained = orrery(cache, &[&["explain", "--target", "mars", "--time", "2024-01-01"], options].concat());
        assert_eq!(explained.status.success(), !fails, "{options:?}: {}", stderr_text(&explained));
    }
}

/// The variable that `doctor` recommends had no effect with a misspelt name, without a word.
#[test]
fn unknown_kernels_are_reported() {
    let with_kernels = |name: &str| {
        let mut command = Command::new(crate::support::program::path());
        command.env("ORRERY_KERNELS", name).args(["--renderer", "software", "--cache"]).arg(crate::support::scratch::program_cache());
        stderr_text(&command.args(["explain", "--target", "phobos", "--time", "2024-01-01"]).output().expect("starts"))
    };
    let line = with_kernels("foo");
    assert!(line.starts_with("orrery: ORRERY_KERNELS=foo: not one of ") && line.contains("portable"), "{line}");
    assert_eq!((with_kernels("portable").as_str(), with_kernels("").as_str()), ("", ""));
}
