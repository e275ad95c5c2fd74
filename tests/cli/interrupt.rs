//! Signals that end the program (Ctrl+C, a shutdown, a closed terminal): no temporary file stays behind.

use super::path_text;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// With this the names of temporary files begin (`TEMPORARY_PREFIX` of src/files.rs).
const TEMPORARY_PREFIX: &str = ".orrery-writing-";
const TIMEOUT: Duration = Duration::from_secs(60);

/// Starts `orrery render` of `frames` small images into a folder, with the same disposition for all signals of these tests, whatever the test's own is.
fn start(folder: &Path, frames: &str, disposition: libc::sighandler_t) -> Child {
    static CACHE: LazyLock<PathBuf> = LazyLock::new(crate::support::scratch::program_cache);
    let output = folder.join("%05d.png");
    let mut command = Command::new(crate::support::program::path());
    command.args(["render", "--renderer", "software", "--cache", path_text(&CACHE), "--target", "phobos", "--time", "2024-04-08"]);
    command.args(["--frames", frames, "--step", "1m", "--size", "16x16", "-o", path_text(&output)]);
    let set_dispositions = move || {
        for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
            // SAFETY: `disposition` is SIG_DFL or SIG_IGN.
            unsafe { libc::signal(signal, disposition) };
        }
        Ok(())
    };
    // SAFETY: between `fork` and `exec` the closure calls only `signal`, which is allowed there.
    unsafe { command.pre_exec(set_dispositions) };
    command.spawn().expect("the program starts")
}

fn send(child: &Child, signal: libc::c_int) {
    let pid = libc::pid_t::try_from(child.id()).expect("a process id");
    // SAFETY: `kill` accepts any number. The process has not been waited for, so that the id is still its own.
    assert_eq!(unsafe { libc::kill(pid, signal) }, 0, "signal {signal}");
}

fn temporary_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry"));
    entries.filter(|e| e.file_name().to_string_lossy().starts_with(TEMPORARY_PREFIX)).map(|e| e.path()).collect()
}

/// Stops the process (SIGSTOP) at an instant when a temporary file exists.
fn stop_while_it_writes(child: &Child, folder: &Path) {
    let start = Instant::now();
    loop {
        assert!(start.elapsed() < TIMEOUT, "no temporary file was seen");
        if temporary_files(folder).is_empty() {
            continue;
        }
        send(child, libc::SIGSTOP);
        let (mut status, pid) = (0, libc::pid_t::try_from(child.id()).expect("a process id"));
        // SAFETY: `status` is a valid place for the status.
        let changed = unsafe { libc::waitpid(pid, &raw mut status, libc::WUNTRACED) };
        assert!(changed == pid && libc::WIFSTOPPED(status), "the run ended too early: {status}");
        if !temporary_files(folder).is_empty() {
            return;
        }
        // The file was finished before the process stopped.
        send(child, libc::SIGCONT);
    }
}

#[test]
fn a_signal_ends_the_program_without_leaving_a_temporary_file() {
    for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
        let folder = tempfile::tempdir().expect("a folder");
        let mut child = start(folder.path(), "5000", libc::SIG_DFL);
        stop_while_it_writes(&child, folder.path());
        send(&child, signal);
        send(&child, libc::SIGCONT);
        // A shell reports this as 128 + the number of the signal.
        assert_eq!(child.wait().expect("ended").signal(), Some(signal));
        assert_eq!(temporary_files(folder.path()), [] as [PathBuf; 0], "signal {signal}");
    }
}

/// `nohup` and shells that start a command in the background ignore signals on its behalf.
#[test]
fn a_signal_that_is_ignored_at_the_start_stays_ignored() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut child = start(folder.path(), "20", libc::SIG_IGN);
    let start = Instant::now();
    while !folder.path().join("00000.png").exists() {
        assert!(start.elapsed() < TIMEOUT, "no image was written");
    }
    for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
        send(&child, signal);
    }
    let status = child.wait().expect("ended");
    assert!(status.success() && folder.path().join("00019.png").exists(), "{status}");
}
