//! Hostile files and arguments: the program answers in bounded time and memory, with one line that names the file or field.

use super::{path_text, stderr_text};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest time until the program must have ended; most runs take a tenth of a second.
const TIMEOUT: Duration = Duration::from_secs(20);

/// The program's output, without a display. A timeout is a failure.
fn orrery(cache: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(crate::support::program::path());
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env("COLUMNS", "200");
    command.args(["--renderer", "software", "--cache", path_text(cache)]).args(args);
    run_with_timeout(command)
}

fn run_with_timeout(mut command: Command) -> Output {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    let (mut out, mut err) = (child.stdout.take().expect("a pipe"), child.stderr.take().expect("a pipe"));
    let read = |from: &mut dyn std::io::Read| {
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes).expect("read");
        bytes
    };
    std::thread::scope(|scope| {
        let (stdout, stderr) = (scope.spawn(|| read(&mut out)), scope.spawn(|| read(&mut err)));
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("waits") {
                break Some(status);
            }
            if start.elapsed() > TIMEOUT {
                child.kill().expect("killed");
                child.wait().expect("ended");
                break None;
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let (stdout, stderr) = (stdout.join().expect("read"), stderr.join().expect("read"));
        let status = status.unwrap_or_else(|| panic!("{command:?} does not end: {}", String::from_utf8_lossy(&stderr)));
        Output { status, stdout, stderr }
    })
}

/// Asserts that a command failed with a single line, and returns it.
fn error_line(out: &Output, case: &str) -> String {
    let line = stderr_text(out);
    assert!(matches!(out.status.code(), Some(1 | 2)), "{case}: {:?}: {line}", out.status);
    assert!(line.trim().lines().count() == 1 && out.stdout.is_empty(), "{case}: {line}");
    assert!(!line.contains("panicked"), "{case}: {line}");
    line
}

#[cfg(unix)]
fn pipe(path: PathBuf) -> PathBuf {
    assert!(Command::new("mkfifo").arg(&path).status().expect("mkfifo runs").success());
    path
}

/// A link may come from a web page. Its dotted parts and brackets must not overflow the stack.
#[test]
fn a_link_of_any_depth_and_length_is_answered() {
    if !crate::support::program::has_view() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let dotted = format!("orrery://view?{}=1", vec!["a"; 30_000].join("."));
    let brackets = format!("orrery://view?eye={}", "[".repeat(60_000));
    let long = format!("orrery://view?target={}", "x".repeat(100_000));
    for (link, message_part) in [(&dotted, "nested one level deep"), (&brackets, "eye"), (&long, "too long for a view")] {
        let out = orrery(folder.path(), &["view", link]);
        // A second line reports that there is no display.
        let line = stderr_text(&out);
        assert!(out.status.code() == Some(1) && line.contains(message_part) && line.lines().count() <= 2, "{message_part}: {line}");
        assert!(line.lines().all(|l| l.chars().count() < 600), "{line}");
    }
    let nested = folder.path().join("view.json");
    std::fs::write(&nested, format!("{{\"eye\":{}", "[".repeat(30_000))).expect("a file");
    assert!(stderr_text(&orrery(folder.path(), &["view", path_text(&nested)])).contains("recursion limit exceeded"));
}

/// Options that name files are given a pipe without a writer, and an endless device.
#[cfg(unix)]
#[test]
fn pipes_and_devices_in_the_place_of_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path_of = |name: &str| folder.path().join(name);
    let fifo = pipe(path_of("pipe"));
    let endless = path_of("endless");
    std::os::unix::fs::symlink("/dev/zero", &endless).expect("a link");
    let view = ["explain", "--target", "moon", "--time", "2024-01-01"];
    for (kind, special_file) in [("pipe", &fifo), ("device", &endless)] {
        let catalogs = path_of(&format!("catalogs-{kind}"));
        let shaders = path_of(&format!("shaders-{kind}"));
        let textures = path_of(&format!("textures-{kind}"));
        for (folder, name) in [(&catalogs, "x.toml"), (&shaders, "lib/draw.wesl"), (&textures, "moon.jpg")] {
            let link = folder.join(name);
            std::fs::create_dir_all(link.parent().expect("a folder")).expect("a folder");
            std::os::unix::fs::symlink(special_file, link).expect("a link");
        }
        let special_path = path_text(special_file);
        for args in [["--kernel", special_path], ["--catalogs", path_text(&catalogs)], ["--shaders", path_text(&shaders)]] {
            error_line(&orrery(&path_of("cache"), &[&view[..], &args].concat()), &format!("{kind} {args:?}"));
        }
        for args in [["explain", "--camera-json", special_path], ["compare", special_path, special_path]] {
            assert!(error_line(&orrery(&path_of("cache"), &args), kind).contains("not a regular file"), "{kind} {args:?}");
        }
        let output = path_of(&format!("{kind}.png"));
        std::os::unix::fs::symlink(special_file, &output).expect("a link");
        for overwrite in [&[][..], &["--overwrite"]] {
            let args = ["render", "--target", "moon", "--time", "2024-01-01", "--size", "8x8", "-o", path_text(&output)];
            let line = error_line(&orrery(&path_of("cache"), &[&args[..], overwrite].concat()), kind);
            assert!(line.contains("not a regular file") && !line.contains("--overwrite"), "{line}");
        }
        // A build without the window has no `view`.
        for args in
            [&["view", special_path][..], &["view", "--settings", special_path]].into_iter().filter(|_| crate::support::program::has_view())
        {
            let out = orrery(&path_of("cache"), args);
            assert!(
                out.status.code() == Some(1) && stderr_text(&out).contains("not a regular file"),
                "{kind} {args:?}: {}",
                stderr_text(&out)
            );
        }
        let out = orrery(&path_of("cache"), &[&view[..], &["--textures", path_text(&textures)]].concat());
        assert!(out.status.success(), "{kind}: {}", stderr_text(&out));
        // An image stores digests of its maps.
        let (size, output) = (["--size", "8x8", "--textures", path_text(&textures), "-o"], path_of(&format!("{kind}-map.png")));
        let args = [&["render", "--target", "moon", "--time", "2024-01-01"][..], &size, &[path_text(&output)]].concat();
        let out = orrery(&path_of("cache"), &args);
        assert!(out.status.success() && stderr_text(&out).contains("moon.jpg"), "{kind}: {}", stderr_text(&out));
    }
}

/// Entries of the shader library, scattering tables and decoded maps are replaced by pipes and links to an endless device.
#[cfg(unix)]
#[test]
fn unusual_file_types_in_the_cache_are_tolerated() {
    let folder = tempfile::tempdir().expect("a folder");
    let (cache, image) = (folder.path().join("cache"), folder.path().join("a.png"));
    let render = || {
        let args = ["render", "--target", "pluto", "--time", "2024-01-01", "--size", "16x16", "--overwrite", "-o", path_text(&image)];
        let out = orrery(&cache, &args);
        assert!(out.status.success(), "{}", stderr_text(&out));
        (std::fs::read(&image).expect("an image"), stderr_text(&out))
    };
    let (first, _) = render();
    let entries = |in_folder: &Path| -> Vec<PathBuf> {
        let mut found: Vec<PathBuf> = std::fs::read_dir(in_folder).expect("a folder").map(|e| e.expect("an entry").path()).collect();
        found.sort();
        found
    };
    let shaders = entries(&entries(&cache.join("orrery/shaders"))[0]);
    let (tables, maps) = (entries(&cache.join("orrery/air")), entries(&cache.join("orrery/maps")));
    assert!(!shaders.is_empty() && !tables.is_empty() && !maps.is_empty());
    for entry in shaders.iter().chain(&tables).chain(&maps) {
        std::fs::remove_file(entry).expect("removed");
    }
    shaders.iter().chain(&tables).chain(&maps).enumerate().for_each(|(k, entry)| match k % 2 {
        0 => drop(pipe(entry.clone())),
        _ => std::os::unix::fs::symlink("/dev/zero", entry).expect("a link"),
    });
    let (again, line) = render();
    assert!(first == again, "the image differs");
    assert!(line.lines().count() <= 2 && line.contains("not a regular file"), "{line}");
}

/// In a folder that others may write, another user's link could make the program overwrite a file of its own user.
#[cfg(unix)]
#[test]
fn a_cache_folder_writable_by_others_is_not_used() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let cache = folder.path().join("cache");
    for part in ["orrery", "orrery/shaders", "orrery/air", "orrery/maps"] {
        let shared = cache.join(part);
        std::fs::create_dir_all(&shared).expect("a folder");
        std::fs::set_permissions(&shared, std::fs::Permissions::from_mode(0o777)).expect("permissions");
        let out = orrery(
            &cache,
            &["render", "--target", "pluto", "--time", "2024-01-01", "--size", "8x8", "-o", path_text(&folder.path().join("a.png"))],
        );
        let line = stderr_text(&out);
        assert!(out.status.success() && line.lines().count() == 1, "{part}: {line}");
        assert!(line.contains("is not used: others may write into it (mode 777)") && line.contains("--cache"), "{part}: {line}");
        assert_eq!(std::fs::read_dir(&shared).expect("a folder").count(), 0, "{part}: something was written");
        std::fs::remove_dir_all(&cache).expect("removed");
    }
    // Cache folders that the program creates are accessible only to its user.
    let out = orrery(
        &cache,
        &[
            "render",
            "--target",
            "pluto",
            "--time",
            "2024-01-01",
            "--size",
            "8x8",
            "--overwrite",
            "-o",
            path_text(&folder.path().join("a.png")),
        ],
    );
    assert!(out.status.success() && out.stderr.is_empty(), "{}", stderr_text(&out));
    let mode = cache.join("orrery/air").metadata().expect("made").permissions().mode();
    assert_eq!(mode & 0o777, 0o700);
}

/// 100,000 threads, a file of 100 bytes that claims 400 megapixels, 20,000 wrong fields.
#[test]
fn oversized_counts_are_refused_or_truncated() {
    let folder = tempfile::tempdir().expect("a folder");
    let path_of = |name: &str| folder.path().join(name);
    let (maps, image) = (path_of("maps"), path_of("a.png"));
    for threads in ["257", "100000", "-1", "many"] {
        let out = orrery(&path_of("cache"), &["doctor", &format!("--threads={threads}")]);
        assert!(out.status.code() == Some(2) && stderr_text(&out).contains("threads from 1 to 256"), "{threads}: {}", stderr_text(&out));
    }
    assert!(orrery(&path_of("cache"), &["doctor", "--threads", "256"]).status.success());

    std::fs::create_dir(path_of("maps")).expect("a folder");
    let huge = path_of("maps/moon.jpg");
    let file = std::fs::File::create(&huge).expect("a file");
    let mut writer = png::Encoder::new(file, 20_000, 20_000).write_header().expect("a head");
    writer.write_chunk(png::chunk::IDAT, &[0x78, 0x9c]).expect("no pixels");
    drop(writer);
    let line = error_line(&orrery(&path_of("cache"), &["compare", path_text(&huge), path_text(&huge)]), "compare");
    assert!(line.contains("20000 x 20000 pixels are 400 megapixels, more than 64; --max-megapixels 400 allows them"), "{line}");
    // With a higher limit the file is read, and its damage reported.
    let line =
        error_line(&orrery(&path_of("cache"), &["compare", path_text(&huge), path_text(&huge), "--max-megapixels", "400"]), "raised");
    assert!(line.contains("not an image that can be read"), "{line}");
    let args =
        ["render", "--target", "moon", "--time", "2024-01-01", "--size", "8x8", "--textures", path_text(&maps), "-o", path_text(&image)];
    let out = orrery(&path_of("cache"), &args);
    assert!(
        out.status.success() && stderr_text(&out).contains("400 megapixels") && stderr_text(&out).lines().count() == 1,
        "{}",
        stderr_text(&out)
    );

    std::fs::create_dir(path_of("catalogs")).expect("a folder");
    let fields: String = (0..20_000).map(|k| format!("x{k} = 1\n")).collect();
    std::fs::write(path_of("catalogs/a.toml"), format!("[[body]]\nid = 401\n{fields}")).expect("a file");
    for verb in [&["explain", "--target", "moon", "--time", "2024-01-01"][..], &["doctor"]] {
        let out = orrery(&path_of("cache"), &[verb, &["--catalogs", path_text(&path_of("catalogs"))]].concat());
        let both = format!("{}{}", stderr_text(&out), String::from_utf8_lossy(&out.stdout));
        assert!(both.matches("is not a field here").count() == 20 && both.contains("and 19980 more"), "{verb:?}: {}", both.len());
    }
}

/// Text that messages quote from files and queries contains terminal control sequences and line breaks.
#[test]
fn quotations_of_files_in_messages_stay_on_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let path_of = |name: &str| folder.path().join(name);
    let control_sequence = "\\u001b[2J\\u001b]0;x\\u0007\\r\\norrery: all is well\\u202e";
    let has_control_characters = |text: &str| text.chars().any(|c| (c.is_control() && c != '\n') || c == '\u{202e}');
    let catalogs = [
        format!("[[body]]\nid = 401\n\"{control_sequence}\" = 1\n"),
        format!("[[body]]\nid = 401\nname = \"{control_sequence}\"\n"),
        format!("[[body]]\nid = 401\naliases = [\"{control_sequence}\"]\n"),
        format!("[[body]]\nid = 401\nparent = \"{control_sequence}\"\n"),
        format!("[[body]]\nid = 401\nkind = \"{control_sequence}\"\n"),
        format!("[[body]]\nid = 401\n[body.sources]\nradii = \"{control_sequence}\"\n"),
        format!("[[ring]]\nbody = \"Mars\"\nname = \"{control_sequence}\"\n"),
        format!("[[moment]]\nname = \"{control_sequence}\"\n"),
        "\u{1b}[2J = 1\n".to_owned(),
    ];
    for (k, text_of_file) in catalogs.iter().enumerate() {
        let catalog = path_of(&format!("catalogs-{k}"));
        std::fs::create_dir(&catalog).expect("a folder");
        std::fs::write(catalog.join("a.toml"), text_of_file).expect("a file");
        let out = orrery(&path_of("cache"), &["explain", "--target", "moon", "--time", "2024-01-01", "--catalogs", path_text(&catalog)]);
        let lines = stderr_text(&out);
        assert!(out.status.code() == Some(1) && !has_control_characters(&lines), "{text_of_file}: {lines:?}");
        assert!(!lines.is_empty() && lines.lines().all(|l| l.contains("a.toml:")), "{text_of_file}: a forged line: {lines}");
    }
    for question in [
        format!("{{\"q\":\"disc-overlap\",\"{control_sequence}\":1}}"),
        format!("{{\"q\":\"{control_sequence}\"}}"),
        format!("{{\"q\":\"disc-overlap\",\"k\":1,\"d\":1,\"model\":\"{control_sequence}\"}}"),
        format!("{{\"q\":\"sunlight\",\"body\":\"{control_sequence}\",\"time\":\"2024-04-08\",\"lat\":0,\"lon\":0}}"),
    ] {
        assert!(!has_control_characters(&error_line(&orrery(&path_of("cache"), &["probe", &question]), &question)), "{question}");
    }
    let camera = path_of("camera.json");
    std::fs::write(&camera, format!("{{\"{control_sequence}\":1}}")).expect("a file");
    assert!(!has_control_characters(&error_line(&orrery(&path_of("cache"), &["explain", "--camera-json", path_text(&camera)]), "camera")));
    // A line of a shape model, with raw control characters.
    let (mesh, image) = (path_of("mesh"), path_of("a.png"));
    std::fs::create_dir(&mesh).expect("a folder");
    std::fs::write(mesh.join("a.toml"), "[[body]]\nid = 401\nmesh = { file = \"a.obj\" }\n").expect("a file");
    std::fs::write(mesh.join("a.obj"), "v 1 2 \u{1b}[2J\u{7}\r\n").expect("a file");
    let args =
        ["render", "--target", "phobos", "--time", "2024-01-01", "--size", "8x8", "-o", path_text(&image), "--catalogs", path_text(&mesh)];
    let out = orrery(&path_of("cache"), &args);
    assert!(
        stderr_text(&out).lines().count() == 1 && stderr_text(&out).contains("a.obj:1") && !has_control_characters(&stderr_text(&out)),
        "{:?}",
        stderr_text(&out)
    );
}

/// If a meaningless value were accepted, the answer would be wrong, or there would be none.
#[test]
fn meaningless_values_are_refused_by_option_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let (cache, image) = (folder.path().join("cache"), folder.path().join("a.png"));
    let missing = folder.path().join("none");
    let cases: [(&[&str], &str); 11] = [
        (&["--at", "91,0"], "--at 91,0"),
        (&["--at=-90.5,0"], "--at -90.5,0"),
        (&["--at", "0,400"], "--at 0,400"),
        (&["--at", "nan,0"], "--at nan,0"),
        (&["--from", "earth", "--at", "91,0"], "--at 91,0"),
        (&["--from", "earth", "--at", "51,0", "--distance-radii", "5"], "--distance-radii: with --from and --at"),
        (&["--at", "51,0", "--height-km", "9", "--distance-radii", "5"], "--distance-radii and --height-km both"),
        (&["--rate", "0"], "--rate"),
        (&["--frames", "0"], "--frames"),
        (&["--textures", path_text(&missing)], "there is no such folder; --textures"),
        (&["--textures", "/dev/null"], "there is no such folder; --textures"),
    ];
    for (args, message_part) in cases {
        let view = ["render", "--target", "moon", "--time", "2024-01-01", "--size", "8x8", "-o", path_text(&image)];
        let out = orrery(&cache, &[&view[..], args].concat());
        assert!(
            matches!(out.status.code(), Some(1 | 2)) && stderr_text(&out).contains(message_part),
            "{args:?}: {:?} {}",
            out.status,
            stderr_text(&out)
        );
        assert!(!image.exists(), "{args:?}: an image was written");
    }
    let air = |fields: &str| {
        let species = format!(
            "{{\"profile\":\"exponential\",\"scattering_per_m\":[5e-6,1e-5,3e-5],\"extinction_per_m\":[5e-6,1e-5,3e-5],\"phase\":\"rayleigh\",{fields}}}"
        );
        let ray = "\"cam\":[0,0,1.0001],\"dir\":[1,0,0.2],\"sun\":[1,0,1],\"tier\":\"pixel-16\"";
        format!("{{\"q\":\"scatter\",\"atmosphere\":{{\"planet_radius_km\":6371,\"top_km\":60,\"species\":[{species}]}},{ray}}}")
    };
    for height in ["0", "-1", "-1e-300"] {
        let line = error_line(&orrery(&cache, &["probe", &air(&format!("\"scale_height_km\":{height}"))]), height);
        assert!(line.contains("scale_height_km must be greater than 0"), "{height}: {line}");
    }
    for height in ["1e300", "1e-300"] {
        let line = error_line(&orrery(&cache, &["probe", &air(&format!("\"scale_height_km\":{height}"))]), height);
        assert!(line.contains("not a number"), "{height}: {line}");
    }
    let out = orrery(&cache, &["probe", &air("\"scale_height_km\":8")]);
    assert!(out.status.success() && !String::from_utf8_lossy(&out.stdout).contains("null"), "{}", stderr_text(&out));
    let view = r#"{"position":{"body":"mars","radii":[0,-3,1]},"look":{"at":"mars"}}"#;
    let pixel = |effects: &str| format!(r#"{{"q":"pixel","view":{view},"size":[8,8],"x":4,"y":4,"effects":"{effects}"}}"#);
    assert!(error_line(&orrery(&cache, &["probe", &pixel("marz:-atmosphere")]), "a body of an effect").contains("`Mars`"));
    assert!(orrery(&cache, &["probe", &pixel("mars:-atmosphere")]).status.success());
    // A cache that cannot be read is an error, and not reported as empty or as cleared.
    std::fs::create_dir_all(cache.join("orrery")).expect("a folder");
    let _ = std::fs::remove_dir_all(cache.join("orrery/shaders"));
    std::fs::write(cache.join("orrery/shaders"), "a file").expect("a file");
    for args in [["library", "status"], ["library", "verify"], ["library", "clear"]] {
        let out = orrery(&cache, &args);
        assert!(out.status.code() == Some(1) && stderr_text(&out).contains("shaders cannot be read"), "{args:?}: {}", stderr_text(&out));
    }
}

/// Temporary files of killed processes are removed after a day; a write that fails (here by the limit of file sizes) leaves no partial
/// file.
#[cfg(unix)]
#[test]
#[expect(clippy::disallowed_methods, reason = "ages of files on disk")]
fn no_partial_or_stale_file_is_left_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    let (cache, image, difference) = (folder.path().join("cache"), folder.path().join("a.png"), folder.path().join("d.png"));
    let file_of_age = |folder: &Path, name: &str, age_s: u64| {
        std::fs::create_dir_all(folder).expect("a folder");
        let file = std::fs::File::create(folder.join(name)).expect("a file");
        file.set_modified(std::time::SystemTime::now() - Duration::from_secs(age_s)).expect("a time");
        folder.join(name)
    };
    let old = file_of_age(folder.path(), ".orrery-writing-aaaaaa", 100_000);
    let recent = file_of_age(folder.path(), ".orrery-writing-bbbbbb", 100);
    let foreign = file_of_age(folder.path(), ".tmpcccccc", 100_000);
    let args = ["render", "--target", "moon", "--time", "2024-01-01", "--size", "8x8", "-o", path_text(&image)];
    assert!(orrery(&cache, &args).status.success());
    assert!(!old.exists() && recent.exists() && foreign.exists());
    let program = crate::support::program::path();
    let mut limited = Command::new("sh");
    limited.args([
        "-c",
        "trap '' XFSZ; ulimit -f 0; exec \"$0\" \"$@\"",
        &program,
        "compare",
        path_text(&image),
        path_text(&image),
        "-o",
        path_text(&difference),
    ]);
    let line = stderr_text(&run_with_timeout(limited));
    assert!(line.lines().count() == 1 && line.contains("d.png"), "{line}");
    // What remains: the cache, the image, and two of the three temporary files.
    let remaining: Vec<_> = std::fs::read_dir(folder.path()).expect("a folder").map(|e| e.expect("an entry").file_name()).collect();
    assert!(remaining.len() == 4 && !difference.exists(), "{remaining:?}");
}

/// Whoever writes with a umask of 077 wants nobody else to read the files; with 002 the group may write them.
#[cfg(unix)]
#[test]
fn written_files_have_the_mode_of_the_umask() {
    use std::os::unix::fs::PermissionsExt;
    let program = crate::support::program::path();
    for (umask, mode) in [("077", 0o600), ("002", 0o664), ("022", 0o644)] {
        let folder = tempfile::tempdir().expect("a folder");
        let shaders = folder.path().join("shaders");
        let mut export = Command::new("sh");
        export.args(["-c", &format!("umask {umask}; exec \"$0\" \"$@\""), &program, "shader", "export", path_text(&shaders)]);
        let out = run_with_timeout(export);
        assert!(out.status.success(), "{}", stderr_text(&out));
        let written = shaders.join("lib/relief.wesl").metadata().expect("written").permissions().mode() & 0o777;
        assert_eq!(written, mode, "umask {umask}: {written:o}");
    }
}

/// Locks and attributes of editors and file systems beside the shader sources: Emacs' lock is a link without a target, and macOS' attributes are no text.
#[test]
fn hidden_files_beside_shader_sources_are_ignored() {
    let folder = tempfile::tempdir().expect("a folder");
    let shaders = folder.path().join("shaders");
    let (cache, shown) = (folder.path().join("cache"), path_text(&shaders));
    assert!(orrery(&cache, &["shader", "export", shown]).status.success());
    std::fs::write(shaders.join("lib/._relief.wesl"), [0xff, 0xfe, 0]).expect("a file");
    #[cfg(unix)]
    std::os::unix::fs::symlink("nobody@nowhere.4711:1", shaders.join("lib/.#relief.wesl")).expect("a link");
    let out = orrery(&cache, &["--shaders", shown, "shader", "emit", "point"]);
    assert!(out.status.success() && out.stderr.is_empty(), "{}", stderr_text(&out));
}

/// A file in the place of a shader source that is too long to be compared is not replaced without being asked.
#[test]
fn an_export_replaces_no_file_that_it_cannot_compare() {
    let folder = tempfile::tempdir().expect("a folder");
    let shaders = folder.path().join("shaders");
    let (cache, shown) = (folder.path().join("cache"), path_text(&shaders));
    std::fs::create_dir_all(shaders.join("lib")).expect("a folder");
    let long_file = shaders.join("lib/relief.wesl");
    let length = (1 << 26) + 1;
    std::fs::File::create(&long_file).and_then(|f| f.set_len(length)).expect("a sparse file");
    let line = error_line(&orrery(&cache, &["shader", "export", shown]), "a long file");
    assert!(line.contains("relief.wesl") && line.contains("--overwrite"), "{line}");
    assert_eq!(long_file.metadata().expect("there").len(), length);
    assert!(orrery(&cache, &["shader", "export", shown, "--overwrite"]).status.success());
    assert!(long_file.metadata().expect("there").len() < length);
}

/// Thousands of modules are compiled and compared with the record, which takes minutes.
#[test]
fn a_missing_record_of_digests_is_reported_before_the_modules_are_compiled() {
    let folder = tempfile::tempdir().expect("a folder");
    let (cache, record) = (folder.path().join("cache"), folder.path().join("nowhere/digests.txt"));
    for update in [&[][..], &["--update"]] {
        let args = ["shader", "verify", "--record", path_text(&record)];
        let line = error_line(&orrery(&cache, &[&args[..], update].concat()), "no record");
        assert!(line.contains("nowhere"), "{line}");
    }
}

/// A number is quoted about as it was given, not with its hundreds of digits.
#[test]
fn huge_numbers_make_short_messages() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = folder.path().join("a.png");
    let render = ["render", "--target", "moon", "--time", "2024-01-01", "--size", "16x16", "-o", path_text(&image)];
    for more in [
        &["--at", "0,0", "--height-km=-1e300"][..],
        &["--stereo", "anaglyph", "--eye-separation-km", "1e300"],
        &["--lunar-heights", "heights.png,1e300,-1e300"],
    ] {
        let line = error_line(&orrery(folder.path(), &[&render[..], more].concat()), more[1]);
        assert!(line.contains("1e300") && line.chars().count() < 250, "{line}");
    }
    let line = error_line(&orrery(folder.path(), &["compare", "a.png", "b.png", "--tolerance", "1e300"]), "--tolerance");
    assert!(line.contains("1e300") && line.chars().count() < 100, "{line}");
}
