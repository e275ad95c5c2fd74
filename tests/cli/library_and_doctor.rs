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
