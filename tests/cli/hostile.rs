//! What the built program makes of files and words that mean harm: an answer in bounded time and memory, on one line that names the file or field.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest that a refusal may take; most take a tenth of a second.
const PATIENCE: Duration = Duration::from_secs(20);

/// The program's answer, without a screen. One that does not come is a failure, not a wait.
fn orrery(cache: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_orrery"));
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env("COLUMNS", "200");
    command.args(["--renderer", "software", "--cache", text(cache)]).args(words);
    ended(command)
}

fn ended(mut command: Command) -> Output {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    let (mut out, mut err) = (child.stdout.take().expect("a pipe"), child.stderr.take().expect("a pipe"));
    let read = |from: &mut dyn std::io::Read| {
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes).expect("read");
        bytes
    };
    std::thread::scope(|scope| {
        let (stdout, stderr) = (scope.spawn(|| read(&mut out)), scope.spawn(|| read(&mut err)));
        let begun = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().expect("waits") {
                break Some(status);
            }
            if begun.elapsed() > PATIENCE {
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

fn text(path: &Path) -> &str {
    path.to_str().expect("a plain name")
}

fn said(out: &Output) -> String {
    String::from_utf8_lossy(&out.stderr).into_owned()
}

/// The only line that a failed command says.
fn refusal(out: &Output, case: &str) -> String {
    let line = said(out);
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

/// A link comes from a stranger's page: 30,000 dotted parts, and as many brackets, overflowed the stack.
#[test]
fn a_link_of_any_depth_and_length_is_answered() {
    let folder = tempfile::tempdir().expect("a folder");
    let dotted = format!("orrery://view?{}=1", vec!["a"; 30_000].join("."));
    let brackets = format!("orrery://view?eye={}", "[".repeat(60_000));
    let long = format!("orrery://view?target={}", "x".repeat(100_000));
    for (link, word) in [(&dotted, "nested one level deep"), (&brackets, "eye"), (&long, "too long for a view")] {
        let out = orrery(folder.path(), &["view", link]);
        // The second line says that there is no screen.
        let line = said(&out);
        assert!(out.status.code() == Some(1) && line.contains(word) && line.lines().count() <= 2, "{word}: {line}");
        assert!(line.lines().all(|l| l.chars().count() < 600), "{line}");
    }
    let nested = folder.path().join("view.json");
    std::fs::write(&nested, format!("{{\"eye\":{}", "[".repeat(30_000))).expect("a file");
    assert!(said(&orrery(folder.path(), &["view", text(&nested)])).contains("recursion limit exceeded"));
}

/// Every option that names a file: a pipe that nobody writes, and a device without an end.
#[cfg(unix)]
#[test]
fn pipes_and_devices_in_the_place_of_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let fifo = pipe(at("pipe"));
    let endless = at("endless");
    std::os::unix::fs::symlink("/dev/zero", &endless).expect("a link");
    let view = ["explain", "--target", "moon", "--time", "2024-01-01"];
    for (kind, odd) in [("pipe", &fifo), ("device", &endless)] {
        let catalogs = at(&format!("catalogs-{kind}"));
        let shaders = at(&format!("shaders-{kind}"));
        let textures = at(&format!("textures-{kind}"));
        for (folder, name) in [(&catalogs, "x.toml"), (&shaders, "lib/draw.wesl"), (&textures, "moon_albedo.jpg")] {
            let place = folder.join(name);
            std::fs::create_dir_all(place.parent().expect("a folder")).expect("a folder");
            std::os::unix::fs::symlink(odd, place).expect("a link");
        }
        let o = text(odd);
        for words in [["--kernel", o], ["--catalogs", text(&catalogs)], ["--shaders", text(&shaders)]] {
            refusal(&orrery(&at("cache"), &[&view[..], &words].concat()), &format!("{kind} {words:?}"));
        }
        for words in [["explain", "--camera-json", o], ["compare", o, o]] {
            assert!(refusal(&orrery(&at("cache"), &words), kind).contains("not a regular file"), "{kind} {words:?}");
        }
        let out = orrery(&at("cache"), &["view", o]);
        assert!(out.status.code() == Some(1) && said(&out).contains("not a regular file"), "{kind}: {}", said(&out));
        let out = orrery(&at("cache"), &["view", "--settings", o]);
        assert!(out.status.code() == Some(1) && said(&out).contains("not a regular file"), "{kind}: {}", said(&out));
        let out = orrery(&at("cache"), &[&view[..], &["--textures", text(&textures)]].concat());
        assert!(out.status.success(), "{kind}: {}", said(&out));
    }
}

/// The library and the tables of air read entries that someone else may have laid there.
#[cfg(unix)]
#[test]
fn odd_kinds_of_files_in_the_cache_stop_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let (cache, picture) = (folder.path().join("cache"), folder.path().join("a.png"));
    let render = || {
        let words = ["render", "--target", "pluto", "--time", "2024-01-01", "--size", "16x16", "--overwrite", "-o", text(&picture)];
        let out = orrery(&cache, &words);
        assert!(out.status.success(), "{}", said(&out));
        (std::fs::read(&picture).expect("a picture"), said(&out))
    };
    let (first, _) = render();
    let entries = |below: &Path| -> Vec<PathBuf> {
        let mut found: Vec<PathBuf> = std::fs::read_dir(below).expect("a folder").map(|e| e.expect("an entry").path()).collect();
        found.sort();
        found
    };
    let shaders = entries(&entries(&cache.join("orrery/shaders"))[0]);
    let tables = entries(&cache.join("orrery/air"));
    assert!(!shaders.is_empty() && !tables.is_empty());
    for entry in shaders.iter().chain(&tables) {
        std::fs::remove_file(entry).expect("removed");
    }
    shaders.iter().chain(&tables).enumerate().for_each(|(k, entry)| match k % 2 {
        0 => drop(pipe(entry.clone())),
        _ => std::os::unix::fs::symlink("/dev/zero", entry).expect("a link"),
    });
    let (again, line) = render();
    assert!(first == again, "another picture");
    assert!(line.lines().count() <= 2 && line.contains("not a regular file"), "{line}");
}

/// In a shared cache another user's link made us overwrite our own file.
#[cfg(unix)]
#[test]
fn a_cache_that_others_may_write_is_not_used() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let cache = folder.path().join("cache");
    for part in ["orrery", "orrery/shaders", "orrery/air"] {
        let shared = cache.join(part);
        std::fs::create_dir_all(&shared).expect("a folder");
        std::fs::set_permissions(&shared, std::fs::Permissions::from_mode(0o777)).expect("permissions");
        let out = orrery(
            &cache,
            &["render", "--target", "pluto", "--time", "2024-01-01", "--size", "8x8", "-o", text(&folder.path().join("a.png"))],
        );
        let line = said(&out);
        assert!(out.status.success() && line.lines().count() == 1, "{part}: {line}");
        assert!(line.contains("is not used: others may write into it (mode 777)") && line.contains("--cache"), "{part}: {line}");
        assert_eq!(std::fs::read_dir(&shared).expect("a folder").count(), 0, "{part}: something was written");
        std::fs::remove_dir_all(&cache).expect("removed");
    }
    // What the program makes itself is nobody else's to read.
    let status = orrery(
        &cache,
        &["render", "--target", "pluto", "--time", "2024-01-01", "--size", "8x8", "--overwrite", "-o", text(&folder.path().join("a.png"))],
    );
    assert!(status.status.success() && status.stderr.is_empty(), "{}", said(&status));
    let mode = cache.join("orrery/air").metadata().expect("made").permissions().mode();
    assert_eq!(mode & 0o777, 0o700);
}
