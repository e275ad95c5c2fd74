//! Files that `orrery render` writes: existing files of the same request are kept, others are refused, and the same request always writes
//! the same bytes.

use super::{path_text, stderr_text};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// A shared cache, so that modules are compiled once.
static CACHE: LazyLock<PathBuf> = LazyLock::new(crate::support::scratch::program_cache);

fn render(args: &[&str]) -> Output {
    let base = ["render", "--renderer", "software", "--cache", CACHE.to_str().expect("a plain name")];
    Command::new(crate::support::program::path()).args(base).args(args).output().expect("the program starts")
}

/// Names and contents of the files in a folder, sorted by name.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<_> = std::fs::read_dir(folder)
        .expect("a folder")
        .flatten()
        .filter(|e| e.path().is_file())
        .map(|e| (e.file_name().to_string_lossy().into_owned(), std::fs::read(e.path()).expect("readable")))
        .collect();
    all.sort();
    all
}

const TIME: &str = "2024-04-08T18:17:16Z";
const BASE: [&str; 6] = ["--target", "phobos", "--time", TIME, "--size", "12x10"];
/// With this the names of temporary files begin (`TEMPORARY_PREFIX` of src/files.rs): no message names such a file.
const TEMPORARY_PREFIX: &str = ".orrery-writing-";

/// One option is changed at a time: each change alone makes another request.
#[test]
fn a_file_of_another_request_is_refused_whatever_differs() {
    let folder = tempfile::Builder::new().prefix("frames").tempdir().expect("a folder");
    let catalogs = folder.path().join("catalogs");
    let maps = folder.path().join("maps");
    let shaders = folder.path().join("shaders");
    [&catalogs, &maps, &shaders].iter().for_each(|f| std::fs::create_dir_all(f).expect("made"));
    std::fs::write(catalogs.join("a.toml"), "[[body]]\nid = 401\ngeometric_albedo = 0.2\n").expect("written");
    let instruments = folder.path().join("instruments");
    std::fs::create_dir_all(&instruments).expect("made");
    std::fs::write(instruments.join("a.toml"), "[[instrument]]\nname = \"own\"\nshape = \"circle\"\ndiameter_deg = 0.3\n")
        .expect("written");
    let fragment = |name: &str| orrery::shader::fragments::FRAGMENTS.iter().find(|(n, _)| *n == name).expect("a fragment").1;
    std::fs::create_dir_all(shaders.join("entry")).expect("made");
    std::fs::write(shaders.join("entry/blur.wesl"), format!("{}\n// edited\n", fragment("entry/blur.wesl"))).expect("written");
    let path = folder.path().join("p.png");
    // An old file with this prefix is removed, so this is the prefix that the program uses.
    let left_behind = folder.path().join(format!("{TEMPORARY_PREFIX}old"));
    std::fs::File::create(&left_behind).and_then(|file| file.set_modified(std::time::SystemTime::UNIX_EPOCH)).expect("a file");
    let first = render(&[&BASE[..], &["-o", path_text(&path)]].concat());
    assert!(first.status.success() && first.stderr.is_empty(), "{}", stderr_text(&first));
    assert!(!left_behind.exists(), "{TEMPORARY_PREFIX} is not the prefix of temporary files");
    let bytes = std::fs::read(&path).expect("written");

    // The same request written differently, and options that do not change the image; `maps` is an empty folder.
    for equivalent in
        [&["--threads", "1"][..], &["--tone-map", "FILM"], &["--textures", path_text(&maps)], &["--exposure", "AUTO"], &["--overwrite"]]
    {
        let out = render(&[&BASE[..], equivalent, &["-o", path_text(&path)]].concat());
        assert!(out.status.success() && std::fs::read(&path).expect("there") == bytes, "{equivalent:?}: {}", stderr_text(&out));
    }
    // The message quotes the provenance, in which "as usual" is a value that the request leaves to the program, and "Phobos + [" begins an offset.
    let changed: &[(&[&str], &str)] = &[
        (&["--target", "deimos"], "Phobos, not Deimos"),
        (&["--time", "2024-04-08T18:17:17Z"], "18:17:16Z"),
        (&["--size", "10x12"], "12x10"),
        (&["--from", "sun"], "from side as usual, fitted, not centre of Sun"),
        (&["--distance-radii", "7"], "7 radii"),
        (&["--at", "3,4"], "not Phobos + ["),
        (&["--fov", "21"], "21 deg"),
        (&["--up", "celestial"], "celestial"),
        (&["--mirror"], "mirrored false, not true"),
        (&["--telescope", "1000/25/52"], "telescope none, not 1000/25/52"),
        (&["--exposure", "1"], "1 stops"),
        (&["--tone-map", "clipped"], "clipped"),
        (&["--effects", "-eclipse"], "-eclipse"),
        (&["--effects", "phobos:-eclipse"], "phobos:-eclipse"),
        (&["--layers", "+labels"], "+labels"),
        (&["--pixels", "depth"], "depth"),
        (&["--quality", "draft"], "draft"),
        (&["--catalogs", path_text(&catalogs)], "catalogs"),
        (&["--catalogs", path_text(&instruments)], "catalogs"),
        (&["--shaders", path_text(&shaders)], "shaders"),
        (&["--renderer", "auto"], "auto"),
    ];
    for (args, message_part) in changed {
        // clap does not allow repeated options, so the changed one is left out of the base.
        let base: Vec<&str> = BASE.chunks(2).filter(|pair| pair[0] != args[0]).flatten().copied().collect();
        let out = match *args {
            // The helper `render` already gives `--renderer software`.
            ["--renderer", _] => {
                let mut command = Command::new(crate::support::program::path());
                command.args(["render", "--cache", path_text(&CACHE)]).args(&base).args(["-o", path_text(&path)]).output().expect("starts")
            }
            _ => render(&[&base[..], args, &["-o", path_text(&path)]].concat()),
        };
        let line = stderr_text(&out);
        assert!(out.status.code() == Some(1) && line.trim().lines().count() == 1, "{args:?}: {line}");
        assert!(line.contains("p.png") && line.contains("--overwrite") && line.contains(message_part), "{args:?}: {line}");
        assert!(line.chars().count() < 600 && !line.contains(TEMPORARY_PREFIX), "{line}");
        assert_eq!(std::fs::read(&path).expect("there"), bytes, "{args:?}: a refused file is left as it is");
    }
    // With --overwrite the file is replaced by the same bytes that a new file gets.
    let fresh = folder.path().join("fresh.png");
    for args in [&["--overwrite"][..], &[]] {
        let output = if args.is_empty() { &fresh } else { &path };
        let out = render(&[&["--target", "deimos", "--time", TIME, "--size", "12x10"][..], args, &["-o", path_text(output)]].concat());
        assert!(out.status.success(), "{}", stderr_text(&out));
    }
    assert_eq!(std::fs::read(&path).expect("there"), std::fs::read(&fresh).expect("there"));
    assert_eq!(files(folder.path()).len(), 2, "no other file is left");
}

#[test]
fn a_sequence_resumes_only_from_its_own_frames() {
    for kind in ["png", "exr"] {
        let folder = tempfile::tempdir().expect("a folder");
        let path_of = |name: &str| folder.path().join(name);
        let pattern = path_of(&format!("m-%03d.{kind}"));
        let run = |target: &str, extra_options: &[&str]| {
            let args = ["--target", target, "--time", TIME, "--size", "12x10", "--frames", "4", "--step", "1h", "-o", path_text(&pattern)];
            render(&[&args[..], extra_options].concat())
        };
        // Two shards draw the entire sequence, so another run finds it complete.
        for shard in ["0/2", "1/2"] {
            let out = run("mars", &["--shard", shard]);
            assert!(out.status.success() && out.stderr.is_empty(), "{}", stderr_text(&out));
        }
        let all_frames = files(folder.path());
        assert_eq!(all_frames.len(), 4);
        let again = run("mars", &[]);
        assert!(again.status.success() && stderr_text(&again).contains("kept 4 of 4"), "{}", stderr_text(&again));
        // A sequence of another request is refused before anything is drawn.
        let other = run("venus", &[]);
        assert_eq!(other.status.code(), Some(1));
        assert!(
            stderr_text(&other).contains("target Mars, not Venus") && stderr_text(&other).trim().lines().count() == 1,
            "{}",
            stderr_text(&other)
        );
        let other = run("venus", &["--shard", "1/2"]);
        assert!(other.status.code() == Some(1) && stderr_text(&other).contains("m-001"), "{}", stderr_text(&other));
        assert_eq!(files(folder.path()), all_frames, "a refused run changes no file");
        // A missing frame is drawn again; a truncated, altered or foreign file is refused, and replaced only with --overwrite.
        std::fs::remove_file(path_of(&format!("m-002.{kind}"))).expect("removed");
        let out = run("mars", &[]);
        assert!(out.status.success() && stderr_text(&out).contains("kept 3 of 4"), "{}", stderr_text(&out));
        assert_eq!(files(folder.path()), all_frames);
        let damaged = path_of(&format!("m-001.{kind}"));
        let good = std::fs::read(&damaged).expect("there");
        let (mut flipped, middle) = (good.clone(), good.len() / 2);
        flipped[middle] ^= 4;
        for (damage, bytes) in
            [("truncated", &good[..good.len() - 9]), ("a flipped bit", &flipped), ("empty", &[]), ("foreign", b"a letter to a friend")]
        {
            std::fs::write(&damaged, bytes).expect("written");
            let out = run("mars", &[]);
            let line = stderr_text(&out);
            assert!(out.status.code() == Some(1) && line.contains("m-001") && line.contains("--overwrite"), "{kind}, {damage}: {line}");
            assert!(line.contains("target Mars") && (line.contains("damaged") || line.contains("unknown")), "{kind}, {damage}: {line}");
            let out = run("mars", &["--overwrite"]);
            assert!(out.status.success() && stderr_text(&out).contains("kept 3 of 4"), "{kind}, {damage}: {}", stderr_text(&out));
            assert_eq!(files(folder.path()), all_frames, "{kind}, {damage}");
        }
        // A longer sequence of the same request keeps the frames of the shorter one.
        let args = ["--target", "mars", "--time", TIME, "--size", "12x10", "--frames", "5", "--step", "1h", "-o", path_text(&pattern)];
        let out = render(&args);
        assert!(out.status.success() && stderr_text(&out).contains("kept 4 of 5"), "{}", stderr_text(&out));
        // With another step only the first frame is the same.
        let args = ["--target", "mars", "--time", TIME, "--size", "12x10", "--frames", "5", "--step", "2h", "-o", path_text(&pattern)];
        let out = render(&args);
        assert!(
            out.status.code() == Some(1) && stderr_text(&out).contains("m-001") && stderr_text(&out).contains("time"),
            "{}",
            stderr_text(&out)
        );
    }
}

/// Of two maps with the same name, that in the folder of `--textures` is used, not that in the folder of `--catalogs`. After it has changed, the earlier frames
/// are refused.
#[test]
fn frames_are_refused_after_the_map_in_the_textures_folder_has_changed() {
    let folder = tempfile::tempdir().expect("a folder");
    let [catalogs, maps] = ["catalogs", "maps"].map(|name| folder.path().join(name));
    let write_map = |folder: &Path, grey: u8| {
        std::fs::create_dir_all(folder).expect("made");
        image::RgbImage::from_pixel(8, 4, image::Rgb([grey; 3]))
            .save_with_format(folder.join("phobos.jpg"), image::ImageFormat::Png)
            .expect("written");
    };
    write_map(&catalogs, 100);
    write_map(&maps, 100);
    std::fs::write(catalogs.join("a.toml"), "[[body]]\nid = 401\ngeometric_albedo = 0.2\n").expect("written");
    let pattern = folder.path().join("m-%d.png");
    let folders = ["--catalogs", path_text(&catalogs), "--textures", path_text(&maps)];
    let draw = || render(&[&BASE[..], &folders, &["--frames", "2", "-o", path_text(&pattern)]].concat());
    let first = draw();
    assert!(first.status.success(), "{}", stderr_text(&first));
    for grey in [100, 50] {
        write_map(&catalogs, grey);
        let again = draw();
        assert!(again.status.success() && stderr_text(&again).contains("kept 2 of 2"), "{grey}: {}", stderr_text(&again));
    }
    write_map(&maps, 200);
    let other = draw();
    // The provenance lists the digests of maps and meshes under "images".
    assert!(other.status.code() == Some(1) && stderr_text(&other).contains("images"), "{}", stderr_text(&other));
}

#[test]
fn write_errors_do_not_name_the_temporary_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    std::fs::write(&file, "here").expect("written");
    let taken = folder.path().join("folder.png");
    std::fs::create_dir(&taken).expect("made");
    let cases = [
        (folder.path().join("nowhere/x.png"), "nowhere"),
        (file.join("x.png"), "file"),
        (PathBuf::from("/proc/x.png"), "/proc/x.png"),
        (taken, "folder.png"),
        (folder.path().join("new.png/"), "this names a folder"),
    ];
    for (path, message_part) in cases {
        for overwrite in [&[][..], &["--overwrite"]] {
            let out = render(&[&BASE[..], overwrite, &["-o", path_text(&path)]].concat());
            let line = stderr_text(&out);
            assert!(out.status.code() == Some(1) && line.trim().lines().count() == 1 && line.contains(message_part), "{path:?}: {line}");
            // A missing folder is named, instead of the system's text for error 2.
            assert!(!line.contains(TEMPORARY_PREFIX) && !line.contains("os error 2)"), "{path:?}: {line}");
            // Overwriting would not help.
            assert!(!line.contains("--overwrite"), "{path:?}: {line}");
        }
    }
    assert_eq!(files(folder.path()).len(), 1, "nothing is left behind");
}

/// The parts of a sequence are drawn by several processes, which start at different times.
#[test]
fn a_shared_sequence_without_a_time_says_that_its_parts_differ() {
    let folder = tempfile::tempdir().expect("a folder");
    let pattern = folder.path().join("out-%d.png");
    let shared = ["--target", "phobos", "--size", "12x10", "--frames", "3", "--shard", "0/2", "-o", path_text(&pattern)];
    for time in [&[][..], &["--time", "now"]] {
        let out = render(&[&shared[..], time, &["--overwrite"]].concat());
        assert!(out.status.success() && stderr_text(&out).contains("give --time"), "{}", stderr_text(&out));
    }
    assert_eq!(files(folder.path()).len(), 2);
    let out = render(&[&shared[..], &["--time", TIME, "--overwrite"]].concat());
    assert!(out.status.success() && !stderr_text(&out).contains("give --time"), "{}", stderr_text(&out));
}

#[test]
fn a_shard_without_frames_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, frames, shard, expected) in [("out.png", "1", "1/2", "1 frame"), ("out-%d.png", "2", "3/4", "2 frames")] {
        let path = folder.path().join(name);
        let out = render(&[&BASE[..], &["--frames", frames, "--shard", shard, "-o", path_text(&path)]].concat());
        let line = stderr_text(&out);
        assert!(out.status.success() && line.trim().lines().count() == 1, "{shard}: {line}");
        assert!(line.contains(&format!("--shard {shard}: this shard has no frames")) && line.trim().ends_with(expected), "{shard}: {line}");
    }
    assert!(files(folder.path()).is_empty(), "nothing is drawn");
}

/// A refusal at the first frame outside would be too late: an animation or a stream would lose the frames drawn until then.
#[test]
fn a_sequence_that_leaves_the_ephemeris_is_refused_before_its_first_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    for step in ["300000d", "-1000000d", "1e300d"] {
        for name in ["out-%d.png", "out.gif"] {
            let path = folder.path().join(name);
            let out = render(&[&BASE[..], &["--frames", "3", "--step", step, "-o", path_text(&path)]].concat());
            let line = stderr_text(&out);
            assert!(out.status.code() == Some(1) && line.trim().lines().count() == 1, "{step}: {line}");
            assert!(line.contains("frame 2") && line.contains("--step") && !line.contains("panicked"), "{step}: {line}");
        }
    }
    assert!(files(folder.path()).is_empty(), "a frame was drawn");
}

/// A tour has the frames of its stops and flights, and resumes like a sequence. An error names file, stop and field. Options that set the view are refused
/// together with a tour.
#[test]
fn a_tour_is_rendered_as_a_sequence() {
    // Tours belong to the window, which is an optional feature of the program.
    if !crate::support::program::has_view() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (tour, pattern) = (folder.path().join("tour.json"), folder.path().join("out-%02d.png"));
    let stop = |target: &str| format!(r#"{{"view":"orrery://view?target={target}&time={TIME}","text":"Here","hold_s":1,"travel_s":1}}"#);
    std::fs::write(&tour, format!(r#"{{"title":"Two","stops":[{},{}]}}"#, stop("Phobos"), stop("Deimos"))).expect("a file");
    let args = ["--tour", path_text(&tour), "--size", "12x10", "--rate", "2", "-o", path_text(&pattern)];
    let out = render(&args);
    assert!(out.status.success(), "{}", stderr_text(&out));
    let written = files(folder.path());
    let names: Vec<&str> = written.iter().map(|(name, _)| name.as_str()).filter(|n| n.ends_with(".png")).collect();
    assert_eq!(names, ["out-00.png", "out-01.png", "out-02.png", "out-03.png", "out-04.png", "out-05.png"]);
    // Two frames at the first stop, two of the flight, two at the second stop. Frames at a stop are equal, those of the flight differ.
    let pixels = |k: usize| image::open(folder.path().join(names[k])).expect("an image").to_rgb8().into_raw();
    assert!(pixels(0) == pixels(1) && pixels(4) == pixels(5) && pixels(1) != pixels(3) && pixels(3) != pixels(4));
    let again = render(&args);
    assert!(again.status.success() && stderr_text(&again).contains("kept 6 of 6"), "{}", stderr_text(&again));
    assert_eq!(files(folder.path()), written);
    let with_target = render(&[&args[..], &["--target", "moon"]].concat());
    assert!(with_target.status.code() == Some(2) && stderr_text(&with_target).contains("--target"), "{}", stderr_text(&with_target));
    // A width or height outside the range is refused, not clamped.
    for size in ["0x10", "12x16385"] {
        let out = render(&["--tour", path_text(&tour), "--size", size, "-o", path_text(&pattern)]);
        assert!(out.status.code() == Some(2) && stderr_text(&out).contains("each side must be 1 to 16384"), "{}", stderr_text(&out));
    }
    let too_many = render(&["--tour", path_text(&tour), "--size", "12x10", "--rate", "100000", "-o", path_text(&pattern)]);
    let message = "--rate 100000: 300000 frames, more than 216000; this tour of 3.0 s can have --rate 72000";
    assert!(too_many.status.code() == Some(2) && stderr_text(&too_many).contains(message), "{}", stderr_text(&too_many));
    std::fs::write(&tour, r#"{"title":"T","stops":[{"view":"orrery://view?target=Nibiru"}]}"#).expect("a file");
    let refused = render(&args);
    assert!(
        refused.status.code() == Some(1) && stderr_text(&refused).contains("tour.json: stop 1, view: target: "),
        "{}",
        stderr_text(&refused)
    );
}

/// Writes a tour that cuts from view to view. The views differ in their compositions, which are given as JSON.
fn write_tour(file: &Path, compositions: &[&str]) {
    let stop = |composition: &&str| {
        format!(r#"{{"view":{{"target":"Phobos","time":"{TIME}","composition":{composition}}},"hold_s":1,"travel_s":0}}"#)
    };
    let stops = compositions.iter().map(stop).collect::<Vec<_>>().join(",");
    std::fs::write(file, format!(r#"{{"title":"T","stops":[{stops}]}}"#)).expect("a file");
}

/// A stop keeps its projection, angle and stereo pair, as in the window. Options replace projection and stereo pair. With `--projection fisheye` the angle is
/// that of the stop if the stop is a fisheye, otherwise the default of a fisheye.
#[test]
fn a_tour_has_the_projection_of_its_stops_unless_options_replace_it() {
    // Tours belong to the window, which is an optional feature of the program.
    if !crate::support::program::has_view() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (tour, pattern) = (folder.path().join("tour.json"), folder.path().join("out-%d.png"));
    let (plain, dome, narrow) = ("{}", r#"{"projection":"fisheye"}"#, r#"{"projection":"fisheye","fisheye_deg":90}"#);
    let red_cyan = r#"{"stereo":"anaglyph"}"#;
    // "as usual": with the default eye separation.
    let stereo_text = "perspective, anaglyph, eyes as usual";
    let cases: [(&str, &[&str], &str, &str); 9] = [
        (plain, &[], "perspective", "45 deg"),
        (dome, &[], "fisheye", "180 deg"),
        (narrow, &[], "fisheye", "90 deg"),
        (red_cyan, &[], stereo_text, "45 deg"),
        (plain, &["--projection", "fisheye"], "fisheye", "180 deg"),
        (narrow, &["--projection", "fisheye", "--dome-tilt", "20"], "fisheye, tilted by 20 deg", "90 deg"),
        (narrow, &["--projection", "equirectangular"], "equirectangular", "45 deg"),
        (dome, &["--stereo", "anaglyph"], stereo_text, "45 deg"),
        (red_cyan, &["--projection", "fisheye"], "fisheye", "180 deg"),
    ];
    for (composition, options, expected_composition, expected_fov) in cases {
        write_tour(&tour, &[composition]);
        let args = ["--tour", path_text(&tour), "--size", "12x10", "--rate", "1", "--overwrite", "-o", path_text(&pattern)];
        let out = render(&[&args[..], options].concat());
        assert!(out.status.success(), "{composition} {options:?}: {}", stderr_text(&out));
        let file = std::fs::read(folder.path().join("out-0.png")).expect("written");
        let file_text = String::from_utf8_lossy(&file);
        for part in [format!(r#""composition":"{expected_composition}""#), format!(r#""fov":"{expected_fov}""#)] {
            assert!(file_text.contains(&part), "{composition} {options:?}: no {part}");
        }
    }
}

/// Without a target the description begins with the next item, and not with a comma.
#[test]
fn the_description_of_an_image_lists_what_was_given() {
    let folder = tempfile::tempdir().expect("a folder");
    let (camera, image) = (folder.path().join("camera.json"), folder.path().join("a.png"));
    std::fs::write(&camera, r#"{"position":{"body":"phobos","km":[0,60,0]},"look":{"at":"phobos"}}"#).expect("written");
    for (options, expected) in [
        (&["--camera-json", path_text(&camera)][..], "exposure "),
        (&["--camera-json", path_text(&camera), "--layers", "+labels"], "layers +labels, exposure "),
        (&["--target", "phobos", "--up", "celestial"], "target phobos, up celestial, exposure "),
        (&["--target", "phobos", "--mirror"], "target phobos, mirrored, exposure "),
    ] {
        let args = ["--time", TIME, "--size", "12x10", "--overwrite", "-o", path_text(&image)];
        let out = render(&[options, &args].concat());
        assert!(out.status.success(), "{}", stderr_text(&out));
        let file = std::fs::read(&image).expect("written");
        let file_text = String::from_utf8_lossy(&file);
        let description = file_text.split("Description\0").nth(1).expect("a description").trim_start_matches('\0');
        assert!(description.starts_with(expected), "{options:?}: {:?}", description.chars().take(80).collect::<String>());
    }
}

#[test]
fn a_stop_that_cannot_be_drawn_is_named() {
    // Tours belong to the window, which is an optional feature of the program.
    if !crate::support::program::has_view() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (tour, mesh) = (folder.path().join("tour.json"), folder.path().join("mesh.data"));
    std::fs::write(&mesh, "2\n2 2\n-1.2 -1 0 0 1\n1.2 -1 1 0 1\n-1.2 1 0 1 1\n1.2 1 1 1 1\n").expect("written");
    write_tour(&tour, &["{}", r#"{"stereo":"anaglyph"}"#]);
    // A mesh excludes a stereo pair, and a pair has no linear light for an EXR file.
    for (output, options, code, message_part) in [
        ("out-%d.png", &["--warp", path_text(&mesh)][..], 1, "tour.json: stop 2: stereo requires"),
        ("out-%d.exr", &[], 2, "display values"),
        ("out-%d.png", &["--dome-zenith"], 2, "zenith requires --projection fisheye"),
    ] {
        let pattern = folder.path().join(output);
        let args = ["--tour", path_text(&tour), "--size", "12x10", "--rate", "1", "-o", path_text(&pattern)];
        let out = render(&[&args[..], options].concat());
        let line = stderr_text(&out);
        assert!(out.status.code() == Some(code) && line.contains(message_part) && line.trim().lines().count() == 1, "{options:?}: {line}");
    }
    assert_eq!(files(folder.path()).len(), 2, "no frame was written");
}

#[test]
fn a_sequence_in_seconds_has_a_frame_in_a_leap_second() {
    let folder = tempfile::tempdir().expect("a folder");
    for times in [
        ["2016-12-31T23:59:59Z", "2016-12-31T23:59:60Z", "2017-01-01T00:00:00Z"],
        ["1972-12-31T23:59:59Z", "1972-12-31T23:59:60Z", "1973-01-01T00:00:00Z"],
    ] {
        let pattern = folder.path().join("%d.png");
        let args = ["--target", "phobos", "--size", "12x10", "--overwrite", "--frames", "3", "--step", "1s", "--time", times[0]];
        let out = render(&[&args[..], &["-o", path_text(&pattern)]].concat());
        assert!(out.status.success(), "{}", stderr_text(&out));
        let drawn = [0, 1, 2].map(|k| std::fs::read(folder.path().join(format!("{k}.png"))).expect("a frame"));
        assert_eq!(drawn.map(|png| orrery::image::png_text_in_head(&png, "Creation Time").expect("a time")), times);
    }
}

/// No such file exists, so `--overwrite` is no remedy.
#[test]
fn a_name_that_the_file_system_refuses_is_reported_as_such() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(format!("{}.png", "a".repeat(300)));
    for extra_options in [&[][..], &["--overwrite"]] {
        let out = render(&[&BASE[..], &["-o", path_text(&path)], extra_options].concat());
        let message = stderr_text(&out);
        assert!(out.status.code() == Some(1) && message.contains("too long"), "{message}");
        assert!(message.lines().count() == 1 && !message.contains("--overwrite") && !message.contains("exists"), "{message}");
    }
}
