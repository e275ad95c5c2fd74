//! Folders for caches and files that tests of one run share.
//!
//! They are in Cargo's folder for test data, not in the system's, because nothing runs after the last test that could remove them: each run removes those of
//! earlier runs. A run holds a lock on its folder, so that two runs at the same time do not disturb each other.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;

/// Name of the locked file in a run's folder.
const LOCK: &str = "lock";
/// Least age of a folder that is removed: a younger one may belong to a run that has not locked it yet.
const MIN_AGE: Duration = Duration::from_secs(60);

/// The folder of this run, and the file that it keeps locked.
static RUN: LazyLock<(PathBuf, File)> = LazyLock::new(|| {
    let runs = Path::new(env!("CARGO_TARGET_TMPDIR")).join("runs");
    let folder = runs.join(std::process::id().to_string());
    remove_ended_runs(&runs);
    std::fs::create_dir_all(&folder).expect("a folder");
    let lock = File::create(folder.join(LOCK)).expect("a file");
    lock.lock().expect("a lock");
    (folder, lock)
});

fn remove_ended_runs(runs: &Path) {
    for run in std::fs::read_dir(runs).into_iter().flatten().flatten() {
        let is_old = || run.metadata().ok()?.modified().ok()?.elapsed().ok().map(|age| age > MIN_AGE);
        let is_unlocked = || File::open(run.path().join(LOCK)).is_ok_and(|lock| lock.try_lock().is_ok());
        if is_old() == Some(true) && is_unlocked() {
            // Another run may be removing it too.
            let _ = std::fs::remove_dir_all(run.path());
        }
    }
}

/// A folder of this run; its parent exists.
pub fn folder(name: &str) -> PathBuf {
    RUN.0.join(name)
}

/// The cache folder of all tests that start the program, so that a module is compiled once.
pub fn program_cache() -> PathBuf {
    folder("program-cache")
}

#[test]
fn a_run_removes_the_folders_of_ended_runs() {
    let runs = tempfile::tempdir().expect("a folder");
    let run = |name: &str, age: Duration| {
        let folder = runs.path().join(name);
        std::fs::create_dir(&folder).expect("a folder");
        let lock = File::create(folder.join(LOCK)).expect("a file");
        let modified = std::time::SystemTime::from(chrono::Utc::now()) - age;
        File::open(&folder).expect("a folder").set_modified(modified).expect("a time");
        lock
    };
    let running = run("running", 2 * MIN_AGE);
    running.lock().expect("a lock");
    drop((run("ended", 2 * MIN_AGE), run("just started", Duration::ZERO)));
    remove_ended_runs(runs.path());
    let mut left: Vec<_> = std::fs::read_dir(runs.path()).expect("a folder").flatten().map(|run| run.file_name()).collect();
    left.sort();
    assert_eq!(left, ["just started", "running"]);
}
