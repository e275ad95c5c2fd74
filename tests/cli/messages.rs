//! Messages: an error is one short line that names the value and suggestions, whatever the input; help is grouped and covers every verb.

use super::{path_text, stderr_text};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::LazyLock;

static CACHE: LazyLock<PathBuf> = LazyLock::new(crate::support::scratch::program_cache);

/// Runs the program without a display, so `view` reports that and ends.
fn orrery(args: &[&str]) -> Output {
    let mut command = Command::new(crate::support::program::path());
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env("COLUMNS", "200");
    command.args(["--renderer", "software", "--cache", CACHE.to_str().expect("a plain name")]).args(args).output().expect("starts")
}

/// The verbs that a help text lists.
fn listed_verbs(help: &str) -> Vec<String> {
    let commands = help.split("\nCommands:\n").nth(1).and_then(|rest| rest.split("\n\n").next()).unwrap_or_default();
    let names = commands.lines().filter_map(|l| l.split_whitespace().next()).filter(|n| *n != "help").map(str::to_owned);
    names.collect()
}

/// The program's verbs, as listed by its help.
fn verbs() -> Vec<String> {
    listed_verbs(&String::from_utf8_lossy(&orrery(&["--help"]).stdout))
}

/// The verbs of verbs, as in `eclipse find`.
fn nested_verbs() -> Vec<[String; 2]> {
    let nested = |verb: String| {
        let inner = listed_verbs(&String::from_utf8_lossy(&orrery(&[&verb, "--help"]).stdout));
        inner.into_iter().map(move |name| [verb.clone(), name])
    };
    verbs().into_iter().flat_map(nested).collect()
}

#[test]
fn every_nested_verb_has_an_example_and_a_manual_page_with_its_options() {
    let nested = nested_verbs();
    assert!(nested.len() >= 12 && nested.contains(&["eclipse".into(), "find".into()]), "{nested:?}");
    for [verb, name] in &nested {
        let text = |args: &[&str]| {
            let out = orrery(args);
            assert!(out.status.success(), "{args:?}: {}", stderr_text(&out));
            String::from_utf8_lossy(&out.stdout).into_owned()
        };
        let (help, page) = (text(&[verb, name, "--help"]), text(&["man", verb, name]).replace("\\-", "-"));
        assert!(help.contains(&format!("  orrery {verb} {name}")), "{help}");
        assert!(page.contains(&format!(".TH orrery-{verb}-{name}")), "{page}");
        let options = help.lines().filter_map(|l| l.trim_start().strip_prefix("--")).filter_map(|l| l.split([' ', '.']).next());
        for option in options.filter(|o| !o.is_empty()) {
            assert!(page.contains(&format!("--{option}")), "man {verb} {name} lacks --{option}");
        }
        // The list of a page names only commands that have a page.
        assert!(!text(&["man", verb]).contains("help(1)"), "{verb}");
    }
    let refused = stderr_text(&orrery(&["man", "render", "find"]));
    assert!(refused.contains("man render find: no such command"), "{refused}");
    assert!(stderr_text(&orrery(&["man", "eclipse", "fnd"])).contains("`find`"));
}

#[test]
fn every_verb_has_an_example_and_its_options_in_groups() {
    let verbs = verbs();
    assert!(verbs.len() >= 12 && verbs.iter().any(|v| v == "man"), "{verbs:?}");
    for verb in &verbs {
        let out = orrery(&[verb, "--help"]);
        let help = String::from_utf8_lossy(&out.stdout).into_owned();
        assert!(out.status.success() && help.contains("Example") && help.contains(&format!("orrery {verb}")), "{verb}: {help}");
        assert!(help.contains("\nCommon options:\n"), "{verb}: {help}");
        // Only these options may be outside the groups.
        let ungrouped = help.split("\nOptions:\n").nth(1).and_then(|rest| rest.split("\n\n").next()).unwrap_or_default();
        let options: Vec<_> = ungrouped.lines().filter(|l| l.trim_start().starts_with('-')).collect();
        let allowed = ["--help", "--version", "--json"];
        assert!(options.iter().all(|o| allowed.iter().any(|a| o.contains(a))), "{verb}: {options:?}");
    }
}

/// Values that no option accepts: too long, or with terminal control sequences.
fn hostile() -> [String; 3] {
    ["☃".repeat(5000), "\u{1b}[2J\u{1b}]0;x\u{7}\r\n\u{202e}☃".into(), format!("-{}", "☃".repeat(300))]
}

#[test]
fn errors_are_short_and_have_no_control_characters() {
    let view_options =
        ["target", "from", "distance-radii", "at", "camera-json", "time", "fov", "up", "size", "exposure", "tone-map", "effects"];
    let mut cases: Vec<Vec<String>> = Vec::new();
    let owned = |args: &[&str]| args.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
    for value in hostile() {
        for option in view_options.iter().chain(&["layers", "pixels"]) {
            let target: &[&str] = if *option == "target" { &["explain"] } else { &["explain", "--target", "earth"] };
            cases.push([owned(target), vec![format!("--{option}={value}")]].concat());
        }
        for before in [
            &[][..],
            &["view"],
            &["render", "--target", "earth", "-o"],
            &["render", "--target", "earth", "-o", "x.png", "--step"],
            &["render", "--target", "earth", "-o", "x.png", "--shard"],
            &["render", "--target", "earth", "-o", "x.png", "--frames"],
            &["shader", "emit"],
            &["shader", "diff", "blur"],
            &["shader", "keys", "--for"],
            &["ephemeris", "--center", "sun", "--time", "now", "--body"],
            &["ephemeris", "--center", "sun", "--body", "io", "--time"],
            &["ephemeris", "--center", "sun", "--body", "io", "--time", "now", "--source"],
            &["probe"],
            &["compare", "none.png"],
            &["bench", "--scene"],
            &["bench", "--size"],
            &["completions"],
            &["man"],
            &["library"],
            &["explain", "--target", "earth", "--kernel"],
            &["explain", "--target", "earth", "--catalogs"],
            &["explain", "--target", "earth", "--shaders"],
            &["explain", "--target", "earth", "--quality"],
        ] {
            cases.push([owned(before), vec![value.clone()]].concat());
        }
    }
    for args in cases {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let (out, short_args) = (orrery(&args), args.iter().map(|w| w.chars().take(20).collect::<String>()).collect::<Vec<_>>());
        let line = stderr_text(&out);
        let code = out.status.code();
        assert!(code == Some(1) || code == Some(2), "{short_args:?}: {code:?}, {line}");
        // `view` reports the invalid link, and then that there is no display.
        let max_lines = if args[0] == "view" { 2 } else { 1 };
        let is_of_clap = line.trim_end().ends_with("try '--help'.");
        assert!(is_of_clap || line.trim().lines().count() <= max_lines, "{short_args:?}: {line}");
        assert!(line.matches('☃').count() <= 200, "{short_args:?} is echoed {} times", line.matches('☃').count());
        assert!(!line.chars().any(|c| (c.is_control() && c != '\n') || c == '\u{202e}'), "{short_args:?}: {line:?}");
        assert!(!line.contains("panicked") && out.stdout.is_empty(), "{short_args:?}: {line}");
    }
}

/// Each invalid line gets one short error, and the next line is processed.
#[test]
fn invalid_json_lines_get_short_errors_in_order() {
    use std::io::Write;
    let long = "☃".repeat(5000);
    let lines = [
        format!(r#"{{"q":"{long}"}}"#),
        format!(r#"{{"q":"disc-overlap","{long}":1}}"#),
        format!(r#"{{"q":"disc-overlap","k":1,"d":1,"model":"{long}"}}"#),
        format!(r#"{{"q":"disc-overlap","k":"{long}","d":1}}"#),
        format!(r#"{{"q":"sunlight","body":"{long}","time":"2024-04-08","lat":0,"lon":0}}"#),
        format!(r#"{{"q":"sunlight","body":"earth","time":"{long}","lat":0,"lon":0}}"#),
        format!(r#"{{"q":"pixel","view":{{"position":{{"body":"{long}","km":[9e9,0,0]}},"look":{{"at":"sun"}}}},"x":0,"y":0}}"#),
        long.clone(),
        r#"{"q":"disc-overlap","k":1,"d":1}"#.into(),
    ];
    // The last question is one for `probe`.
    for (verb, last_is_valid) in [("probe", true), ("ephemeris", false)] {
        let mut child = Command::new(crate::support::program::path())
            .args([verb, "--stdin", "--cache", path_text(&CACHE)])
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::piped())
            .spawn()
            .expect("starts");
        child.stdin.take().expect("a pipe").write_all(lines.join("\n").as_bytes()).expect("written");
        let out = child.wait_with_output().expect("ends");
        let answers: Vec<serde_json::Value> =
            String::from_utf8_lossy(&out.stdout).lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
        assert_eq!(answers.len(), lines.len(), "{verb}");
        for (answer, line) in answers.iter().zip(&lines) {
            let error = answer["error"].as_str().unwrap_or_default();
            assert!(error.matches('☃').count() <= 200 && error.chars().count() < 700, "{verb}: {error}");
            assert_eq!(answer.get("ok").is_some(), last_is_valid && line.len() < 100, "{verb}: {answer}");
        }
    }
}

/// One of the two times would have been lost without a word. Negative control: the same line with one time.
#[test]
fn a_field_given_twice_is_an_error_of_its_line() {
    use std::io::Write;
    let line = r#"{"body":"mars","center":"sun","time":"2024-01-01"}"#;
    // A byte order mark in front of the first line is not part of it; in front of another it is an error.
    let lines = format!("\u{feff}{}\n{line}\n\u{feff}{line}\n", line.replace("\"time\"", "\"time\":\"2023-01-01\",\"time\""));
    let mut child = Command::new(crate::support::program::path())
        .args(["ephemeris", "--stdin", "--cache", path_text(&CACHE)])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("starts");
    child.stdin.take().expect("a pipe").write_all(lines.as_bytes()).expect("written");
    let out = child.wait_with_output().expect("ends");
    let answers: Vec<serde_json::Value> =
        String::from_utf8_lossy(&out.stdout).lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
    let error = answers[0]["error"].as_str().unwrap_or_default();
    assert!(error.starts_with("field `time` is given twice"), "{answers:?}");
    assert!(answers.len() == 3 && answers[1].get("ok").is_some() && answers[2].get("error").is_some(), "{answers:?}");
}

#[test]
fn similar_names_are_suggested_everywhere() {
    for (args, suggestion) in [
        (&["explain", "--target", "marz"][..], "`Mars`"),
        (&["explain", "--target", "mars", "--from", "erth"], "`Earth`"),
        (&["explain", "--target", "Jupitr"], "`Jupiter`"),
        (&["explain", "--target", "mars", "--effects", "+eclips"], "`eclipse`"),
        (&["explain", "--target", "mars", "--effects", "+eclipse=limb-darkend"], "`limb-darkened`"),
        (&["explain", "--target", "mars", "--effects", "mon:-eclipse"], "`Moon`"),
        (&["explain", "--target", "mars", "--layers", "+orbit"], "`orbits`"),
        (&["explain", "--target", "mars", "--pixels", "sunligt"], "`sunlight`"),
        (&["explain", "--target", "mars", "--up", "zenit"], "`zenith`"),
        (&["explain", "--target", "mars", "--tone-map", "filmc"], "`filmic`"),
        (&["shader", "keys", "--for", "satrun"], "`Saturn`"),
        (&["shader", "emit", "lambrt.sun1.sphere"], "`lambert`"),
        (&["shader", "emit", "lambert.sun1.elipsoid"], "`ellipsoid`"),
        (&["shader", "emit", "lable"], "`label`"),
        (&["ephemeris", "--body", "tritn", "--center", "sun", "--time", "now"], "`Triton`"),
        (&["probe", r#"{"q":"sunlght"}"#], "`sunlight`"),
        (&["probe", r#"{"q":"disc-overlap","k":1,"d":1,"modell":"linear"}"#], "`model`"),
        (&["probe", r#"{"q":"sunlight","body":"erth","time":"2024-04-08","lat":0,"lon":0}"#], "`Earth`"),
        (&["bench", "--scene", "satur"], "`saturn`"),
        (&["man", "rendr"], "`render`"),
        (&["--target", "marz"], "`Mars`"),
        (&["rendr"], "'render'"),
        (&["render", "--targte", "mars"], "'--target'"),
        (&["--targte", "mars"], "'--target'"),
    ] {
        // Without a window the arguments of a view are not read.
        if args == ["--target", "marz"] && !crate::support::program::has_view() {
            continue;
        }
        let out = orrery(args);
        assert!(!out.status.success() && stderr_text(&out).contains(suggestion), "{args:?}: {}", stderr_text(&out));
    }
}

/// The dates in a message are the first and the last for which a query succeeds.
#[test]
fn the_range_that_a_message_names_is_the_range_that_works() {
    let state_at = |body: &str, time: &str, source: &[&str]| {
        orrery(&[&["ephemeris", "--body", body, "--center", "solar system barycenter", "--time", time, "--json"], source].concat())
    };
    let julian_day = |day: &str| orrery::time::Instant::parse(day).unwrap_or_else(|e| panic!("{e}")).jd_tdb();
    let bodies_and_sources: &[(&str, &[&str])] = &[
        ("earth", &[]),
        ("moon", &[]),
        ("io", &[]),
        ("phobos", &[]),
        ("pluto", &[]),
        ("ceres", &[]),
        ("sun", &["--source", "mean"]),
        ("earth", &["--source", "kernel"]),
        ("titan", &["--source", "kernel"]),
        ("pluto", &["--source", "series"]),
    ];
    for (body, source) in bodies_and_sources {
        let mut spans = BTreeSet::new();
        for time in ["-9000-01-01", "9000-01-01T12:00:00Z"] {
            let out = state_at(body, time, source);
            let line = stderr_text(&out);
            assert!(out.status.code() == Some(1) && line.contains(time.split('T').next().expect("a day")), "{body} {source:?}: {line}");
            assert!(!line.contains("jd_tdb"), "{line}");
            let line_words: Vec<&str> = line.split([' ', ',']).collect();
            let after =
                |word: &str| line_words.iter().position(|w| *w == word).and_then(|k| line_words.get(k + 1)).expect("a range").to_string();
            spans.insert((after("from"), after("to")));
        }
        let (first, last) = spans.first().cloned().expect("a span");
        assert_eq!(spans.len(), 1, "{body}: one range");
        // The dates are whole days within the range. If a position is a sum of several states, its range is the intersection of theirs.
        for (day, outward) in [(&first, -1.0), (&last, 1.0)] {
            let jd = |days: f64| format!("jd_tdb:{}", julian_day(day) + days);
            let (inside, outside) = (state_at(body, &jd(-3.0 * outward), source), state_at(body, &jd(3.0 * outward), source));
            assert!(inside.status.success(), "{body} {source:?} 3 days within {day}: {}", stderr_text(&inside));
            assert!(!outside.status.success(), "{body} {source:?} 3 days beyond {day} works");
        }
    }
}

#[test]
fn a_distance_beyond_all_sources_names_its_limit() {
    for exponent in (1..=300).step_by(23).chain([11, 12, 13, 30]) {
        for target in ["phobos", "sun"] {
            let distance = format!("1e{exponent}");
            let out = orrery(&["explain", "--target", target, "--distance-radii", &distance, "--time", "2024-04-08"]);
            let line = stderr_text(&out);
            // The limit, a thousand light years, is 9.46e15 km.
            let radius_km = if target == "phobos" { 13.0 } else { 695_700.0 };
            let km = radius_km * 10_f64.powi(exponent);
            match out.status.code() {
                Some(0) => assert!(km < 9.47e15, "{target} {distance}"),
                code => {
                    assert!(code == Some(1) && km > 9.45e15 && line.contains("at most") && !line.contains("jd_tdb"), "{target}: {line}");
                }
            }
        }
    }
}

/// The line breaks between the invalid fields of a catalog once were shown as `\\n`, all in one line.
#[test]
fn a_window_without_an_invalid_catalog_reports_each_field_in_a_line() {
    if !crate::support::program::has_view() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("own.toml"), "[[body]]\nid = 10\nfirst = 1\nsecond = 2\n").expect("written");
    let message = stderr_text(&orrery(&["--catalogs", path_text(folder.path()), "--time", "2024-04-08"]));
    let lines: Vec<&str> = message.lines().collect();
    assert!(lines.iter().all(|line| line.starts_with("orrery: ")) && !message.contains("\\n"), "{message}");
    assert!(lines.iter().filter(|line| line.contains("own.toml:")).count() >= 2, "{message}");
    assert!(lines.contains(&"orrery: the window opens without --catalogs"), "{message}");
}

#[test]
fn arguments_without_a_verb_belong_to_view() {
    let no_window = if crate::support::program::has_view() { "no window can be opened here" } else { "this build has no window" };
    for (args, code, message_part) in [
        (&["--target", "saturn", "--time", "2024-04-08"][..], 1, no_window),
        (&["--time", "2024-04-08"], 1, no_window),
        (&["orrery://view?target=599&time=2015-01-24T06:45:00Z"], 1, no_window),
        (&["--time", "someday"], 2, "someday"),
        // A build without a window does not look the body up.
        (&["--target", "nibiru"], if crate::support::program::has_view() { 2 } else { 1 }, "nibiru"),
        (&["paint"], 2, "paint"),
        (&["--frames", "3"], 2, "--frames"),
        (&["--target", "mars", "render"], 2, "--target"),
    ] {
        let out = orrery(args);
        assert!(
            out.status.code() == Some(code) && stderr_text(&out).contains(message_part),
            "{args:?}: {:?} {}",
            out.status.code(),
            stderr_text(&out)
        );
    }
    if !crate::support::program::has_view() {
        let line = stderr_text(&orrery(&["--target", "earth moon", "--time", "2024-04-08"]));
        assert!(line.contains("--target 'earth moon'") && line.trim().ends_with("-o 'earth moon.png'"), "{line}");
    }
    let help = orrery(&["--help"]);
    assert!(String::from_utf8_lossy(&help.stdout).contains("orrery --target saturn"));
}

#[test]
fn completions_and_manual_pages_cover_every_verb_and_option() {
    let verbs = verbs();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let out = orrery(&["completions", shell]);
        let script = String::from_utf8_lossy(&out.stdout).into_owned();
        let missing: Vec<_> = verbs.iter().filter(|v| !script.contains(v.as_str())).collect();
        assert!(out.status.success() && missing.is_empty() && script.contains("distance-radii"), "{shell}: {missing:?}");
    }
    let page = |args: &[&str]| String::from_utf8_lossy(&orrery(args).stdout).replace("\\-", "-");
    let main = page(&["man"]);
    assert!(main.contains(".TH") && verbs.iter().all(|v| main.contains(v.as_str())), "{main}");
    for verb in &verbs {
        let help = String::from_utf8_lossy(&orrery(&[verb, "--help"]).stdout).into_owned();
        let verb_page = page(&["man", verb]);
        let options =
            help.lines().filter_map(|l| l.trim_start().strip_prefix("--")).map(|l| l.split([' ', '.']).next().unwrap_or(l).to_owned());
        for option in options.filter(|o| !o.is_empty()) {
            assert!(verb_page.contains(&format!("--{option}")), "man {verb} lacks --{option}");
        }
    }
}

#[test]
fn exported_fragments_override_the_built_in_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let shaders = folder.path().join("shaders");
    let fragment = |name: &str| shaders.join(name);
    let key = "lambert.sun1.sphere";
    let built_in = orrery(&["shader", "emit", key]).stdout;
    let out = orrery(&["shader", "export", path_text(&shaders)]);
    assert!(out.status.success(), "{}", stderr_text(&out));
    for (name, source) in orrery::shader::fragments::FRAGMENTS.iter() {
        assert_eq!(std::fs::read_to_string(fragment(name)).expect("written"), **source, "{name}");
    }
    let emit = |more: &[&str]| orrery(&[&["shader", "emit", key, "--shaders", path_text(&shaders)], more].concat());
    assert_eq!(emit(&[]).stdout, built_in, "exported fragments without changes give the same module");
    let edited = std::fs::read_to_string(fragment("lib/photometry/lambert.wesl")).expect("there") + "\n// a line of my own\n";
    std::fs::write(fragment("lib/photometry/lambert.wesl"), &edited).expect("written");
    assert!(String::from_utf8_lossy(&emit(&[]).stdout).contains("a line of my own"));
    // Another export does not overwrite the edited file.
    let out = orrery(&["shader", "export", path_text(&shaders)]);
    assert!(out.status.code() == Some(1) && stderr_text(&out).contains("lambert.wesl"), "{}", stderr_text(&out));
    assert_eq!(std::fs::read_to_string(fragment("lib/photometry/lambert.wesl")).expect("there"), edited);
    // A new file is used if a fragment imports it. Otherwise every verb reports it.
    std::fs::write(fragment("lib/mine.wesl"), "const MINE = 1.0;\n").expect("written");
    let unused_file = emit(&[]);
    assert!(unused_file.status.code() == Some(1) && stderr_text(&unused_file).contains("lib/mine.wesl"), "{}", stderr_text(&unused_file));
    std::fs::write(fragment("lib/photometry/lambert.wesl"), format!("import package::lib::mine::MINE;\n{edited}")).expect("written");
    assert!(emit(&[]).status.success(), "{}", stderr_text(&emit(&[])));
    std::fs::rename(fragment("lib/mine.wesl"), fragment("lib/photometry/lambrt.wesl")).expect("renamed");
    std::fs::write(fragment("lib/photometry/lambert.wesl"), &edited).expect("written");
    for args in [
        &["explain", "--target", "moon", "--time", "2024-04-08"][..],
        &["render", "--target", "moon", "--size", "8x8", "-o", "/nowhere/x.png"],
        &["probe", r#"{"q":"disc-overlap","k":1,"d":1}"#],
        &["shader", "diff", "blur", "glow"],
        &["shader", "cost", key],
        &["shader", "keys", "--for", "moon"],
        &["bench", "--scene", "saturn", "--size", "8x8", "--frames", "1"],
        &["library", "status"],
        &["view"],
        &["--target", "moon"],
    ] {
        if (args == ["view"] || args == ["--target", "moon"]) && !crate::support::program::has_view() {
            continue;
        }
        let out = orrery(&[args, &["--shaders", path_text(&shaders)]].concat());
        let line = stderr_text(&out);
        assert!(out.status.code() == Some(1) && line.trim().lines().count() == 1, "{args:?}: {line}");
        assert!(line.contains("lambrt.wesl") && line.contains("`lib/photometry/lambert.wesl`"), "{args:?}: {line}");
    }
    let empty = folder.path().join("empty");
    std::fs::create_dir(&empty).expect("made");
    for (folder, message_part) in [(empty, "no *.wesl"), (folder.path().join("none"), "none")] {
        let out = orrery(&["shader", "emit", key, "--shaders", path_text(&folder)]);
        assert!(out.status.code() == Some(1) && stderr_text(&out).contains(message_part), "{}", stderr_text(&out));
    }
}

#[test]
fn edited_fragments_change_the_image() {
    let folder = tempfile::tempdir().expect("a folder");
    let shaders = folder.path().join("shaders");
    assert!(orrery(&["shader", "export", path_text(&shaders)]).status.success());
    let display = shaders.join("lib/display.wesl");
    let source = std::fs::read_to_string(&display).expect("there");
    assert!(source.contains("1.055 * exp2("));
    std::fs::write(&display, source.replace("1.055 * exp2(", "0.500 * exp2(")).expect("written");
    let draw = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let out =
            orrery(&[&["render", "--target", "venus", "--time", "2024-04-08", "--size", "16x16", "-o", path_text(&path)], more].concat());
        assert!(out.status.success(), "{}", stderr_text(&out));
        image::open(path).expect("an image").into_rgb8().into_raw()
    };
    let brightest = |image: Vec<u8>| image.into_iter().max().unwrap_or(0);
    let (built_in, darker) = (brightest(draw("a.png", &[])), brightest(draw("b.png", &["--shaders", path_text(&shaders)])));
    assert!(built_in > 150 && darker < 140, "{built_in} of 255 and {darker}");
}

/// Graphics drivers print a line of their own if XDG_RUNTIME_DIR is missing or invalid.
#[test]
fn no_message_of_a_graphics_driver_reaches_the_user() {
    for folder in [None, Some(""), Some("relative"), Some("/nonexistent")] {
        let mut command = Command::new(crate::support::program::path());
        command.env_remove("XDG_RUNTIME_DIR").env_remove("WAYLAND_DISPLAY").env_remove("DISPLAY").args([
            "doctor",
            "--cache",
            path_text(&CACHE),
        ]);
        if let Some(folder) = folder {
            command.env("XDG_RUNTIME_DIR", folder);
        }
        let out = command.output().expect("starts");
        assert!(out.status.success() && !stderr_text(&out).contains("XDG_RUNTIME_DIR"), "{folder:?}: {}", stderr_text(&out));
    }
}

#[test]
fn doctor_lists_the_bodies() {
    let out = orrery(&["doctor"]);
    let listed = String::from_utf8_lossy(&out.stdout).into_owned();
    for body in orrery::catalog::Catalog::embedded().bodies() {
        assert!(listed.contains(&body.name), "{}: {listed}", body.name);
    }
    assert!(listed.contains("8 planets: Mercury"), "{listed}");
}

/// A map that two bodies share is one file.
#[test]
fn doctor_counts_files_of_maps_and_not_their_uses() {
    let folder = tempfile::tempdir().expect("a folder");
    let shared = "[[body]]\nid = 401\nmaps = { albedo = { file = \"shared.png\" } }\n[[body]]\nid = 402\nmaps = { albedo = { file = \"shared.png\" } }\n";
    std::fs::write(folder.path().join("moons.toml"), shared).expect("written");
    image::RgbImage::from_pixel(4, 2, image::Rgb([90; 3])).save(folder.path().join("shared.png")).expect("written");
    let path = path_text(folder.path());
    let out = orrery(&["doctor", "--catalogs", path, "--textures", path]);
    let listed = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(listed.contains(", 1 from --textures"), "{listed}");
}
