//! Files: reads with a size limit, and atomic writes.
//!
//! In: paths. Out: bytes of regular files, of bounded length; files that are written completely or not at all. Always: a pipe, a device or a folder is refused at once; a new
//! file is created under an unpredictable name in the folder of its target, never through a link, and is synced to disk before it is renamed to its target;
//! temporary files of a killed process are removed after a day. It knows no format, and chooses no location.

use crate::wording::echo;
use parking_lot::Mutex;
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Error, ErrorKind, Read, Result, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use tempfile::NamedTempFile;

/// Prefix of temporary files.
const TEMPORARY: &str = ".orrery-writing-";
/// Age above which a temporary file cannot belong to a running process, since no file takes so long to write.
const STALE_AGE: Duration = Duration::from_secs(86_400);

/// The bytes of a regular file of at most `max_bytes`.
///
/// # Errors
/// It cannot be opened or read, is no regular file, or is longer.
pub(crate) fn read_bytes(path: &Path, max_bytes: u64) -> Result<Vec<u8>> {
    let mut options = OpenOptions::new();
    options.read(true);
    // Opening a pipe without a writer would block forever.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    let file = options.open(path)?;
    let about = file.metadata()?;
    if about.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "this is a folder, not a file"));
    }
    if !about.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "not a regular file"));
    }
    let too_long =
        |bytes: u64| Error::new(ErrorKind::FileTooLarge, format!("{bytes} bytes, more than {max_bytes}, the most that are read"));
    if about.len() > max_bytes {
        return Err(too_long(about.len()));
    }
    let mut bytes = Vec::new();
    // Files of procfs have length 0; others may grow.
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes { Err(too_long(bytes.len() as u64)) } else { Ok(bytes) }
}

/// The same for UTF-8 text.
///
/// # Errors
/// As [`read_bytes`], or that it is not UTF-8.
pub(crate) fn read_text(path: &Path, max_bytes: u64) -> Result<String> {
    String::from_utf8(read_bytes(path, max_bytes)?).map_err(|_| Error::new(ErrorKind::InvalidData, "not UTF-8 text"))
}

/// Checks that a file is inside a folder after links are resolved: the folder may come from somebody else, and its catalog names the file.
///
/// # Errors
/// It is elsewhere, or it or the folder does not exist.
pub(crate) fn check_inside(folder: &Path, path: &Path) -> Result<()> {
    match path.canonicalize()?.starts_with(folder.canonicalize()?) {
        true => Ok(()),
        false => Err(Error::new(ErrorKind::InvalidInput, "a link that leads out of its folder; put the file itself there")),
    }
}

/// Who may read a written file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileAccess {
    All,
    /// For settings, which include the user's home.
    Owner,
}

/// A file that could not be written. Its text is one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {why}")]
pub struct WriteError {
    /// The path as it was named, escaped and shortened for a message.
    pub path: String,
    /// The system's error, or the missing folder.
    pub why: String,
}

/// Writes a file atomically.
///
/// # Errors
/// The path and why.
pub(crate) fn write_atomic(
    path: &Path,
    readers: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>,
) -> std::result::Result<(), WriteError> {
    replace(path, readers, fill).map_err(|e| write_error(path, &e))
}

/// Writes a file atomically under the first of `names`, all in one folder, that does not exist; returns that name.
///
/// # Errors
/// The path and why, such as that no name is free.
pub(crate) fn write_new(
    names: impl IntoIterator<Item = PathBuf>,
    readers: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>,
) -> std::result::Result<PathBuf, WriteError> {
    let mut names = names.into_iter();
    let none = || WriteError { path: String::new(), why: "no name to write to".into() };
    let mut name = names.next().ok_or_else(none)?;
    let mut file = write_temporary(&name, readers, fill).map_err(|e| write_error(&name, &e))?;
    loop {
        // One system call: between a check and a rename another program could take the name.
        match file.persist_noclobber(&name) {
            Ok(_) => return Ok(name),
            Err(e) if e.error.kind() == ErrorKind::AlreadyExists => {
                let taken = || WriteError { path: echo(&name.display().to_string()), why: "a file of this name exists already".into() };
                file = e.file;
                name = names.next().ok_or_else(taken)?;
            }
            Err(e) => return Err(write_error(&name, &e.error)),
        }
    }
}

/// Writes a cache entry atomically, readable by this user only, and creates missing folders.
///
/// # Errors
/// Why it cannot be written.
pub(crate) fn write_cached(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut folders = std::fs::DirBuilder::new();
    folders.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut folders, 0o700);
    folders.create(folder_of(path))?;
    replace(path, FileAccess::Owner, |out| out.write_all(bytes))
}

fn replace(path: &Path, readers: FileAccess, fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>) -> Result<()> {
    // A rename would replace the device or pipe.
    if path.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        return Err(Error::new(ErrorKind::InvalidInput, "not a regular file, which cannot be replaced"));
    }
    write_temporary(path, readers, fill)?.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Writes the content for `path`, completely and synced to disk, to a temporary file in the same folder.
fn write_temporary(path: &Path, readers: FileAccess, fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>) -> Result<NamedTempFile> {
    let folder = folder_of(path);
    remove_stale_once(folder);
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    // Opened here, because the crate's own error message contains the temporary name.
    let mut file = tempfile::Builder::new().prefix(TEMPORARY).make_in(folder, |at| options.open(at))?;
    let mut out = BufWriter::new(file.as_file_mut());
    fill(&mut out)?;
    out.flush()?;
    drop(out);
    if readers == FileAccess::All {
        make_world_readable(file.as_file());
    }
    file.as_file().sync_all()?;
    Ok(file)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The error for a failed write. It names the missing folder, where that is the reason.
pub(crate) fn write_error(path: &Path, e: &Error) -> WriteError {
    let folder = echo(&folder_of(path).display().to_string());
    let why = match e.kind() {
        ErrorKind::NotFound => format!("there is no folder {folder}; make it first"),
        ErrorKind::NotADirectory => format!("{folder} is no folder"),
        _ => e.to_string(),
    };
    WriteError { path: echo(&path.display().to_string()), why }
}

/// Temporary files are private, while pictures are not.
#[cfg(unix)]
fn make_world_readable(file: &File) {
    use std::os::unix::fs::PermissionsExt;
    // On failure only the owner can read the picture, which is better than losing it.
    let _ = file.set_permissions(std::fs::Permissions::from_mode(0o644));
}

#[cfg(not(unix))]
fn make_world_readable(_file: &File) {}

/// Whether a file is a temporary one of this program.
pub(crate) fn is_temporary(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n.to_string_lossy().starts_with(TEMPORARY))
}

/// Removes the temporary files of a folder that are older than a day, when this process first writes into it.
fn remove_stale_once(folder: &Path) {
    static CHECKED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    if !CHECKED.lock().insert(folder.to_owned()) {
        return;
    }
    #[expect(clippy::disallowed_methods, reason = "the age of a file on disk; no picture depends on it")]
    let now = SystemTime::now();
    let is_old = |path: &Path| {
        let changed = path.symlink_metadata().ok().filter(std::fs::Metadata::is_file).and_then(|m| m.modified().ok());
        changed.and_then(|at| now.duration_since(at).ok()).is_some_and(|age| age > STALE_AGE)
    };
    let entries = std::fs::read_dir(folder).ok().into_iter().flatten().flatten().map(|e| e.path());
    // A file of another user, or already removed: neither matters.
    entries.filter(|path| is_temporary(path) && is_old(path)).for_each(|path| drop(std::fs::remove_file(path)));
}

/// Why other users could write to a folder: its owner or its mode. `is_above`: a parent of our own folder, which is checked itself; a parent may be group-writable,
/// and world-writable if only owners can remove files (the sticky bit of /tmp). `None` for a folder that does not exist.
#[cfg(unix)]
pub(crate) fn foreign_write_access(folder: &Path, is_above: bool) -> Option<String> {
    use std::os::unix::fs::MetadataExt;
    // SAFETY: it takes nothing, cannot fail and changes nothing.
    let own = unsafe { libc::geteuid() };
    // For a link, both itself and its target count.
    for about in [folder.symlink_metadata().ok()?, folder.metadata().ok()?] {
        if about.uid() != own && about.uid() != 0 {
            return Some(format!("it belongs to user {}", about.uid()));
        }
        let is_open = match is_above {
            true => about.mode() & 0o002 != 0 && about.mode() & 0o1000 == 0,
            false => about.mode() & 0o022 != 0,
        };
        if about.is_dir() && is_open {
            return Some(format!("others may write into it (mode {:o})", about.mode() & 0o7777));
        }
    }
    None
}

#[cfg(not(unix))]
pub(crate) fn foreign_write_access(_folder: &Path, _is_above: bool) -> Option<String> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
        let folder = folder.to_owned();
        (1..).map(move |n| folder.join(format!("a-{n}.txt")))
    }

    /// Eight concurrent writers with ten files each, beside existing files: nothing is lost or replaced.
    #[test]
    fn what_is_written_under_a_new_name_replaces_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let others = [2, 5, 41];
        for n in others {
            std::fs::write(folder.path().join(format!("a-{n}.txt")), "another's").expect("a file");
        }
        let write = |writer: usize, k: usize| {
            let text = format!("{writer} {k}");
            write_new(numbered(folder.path()), FileAccess::All, |out| out.write_all(text.as_bytes()))
        };
        let written: Vec<(String, PathBuf)> = std::thread::scope(|scope| {
            let writers: Vec<_> = (0..8)
                .map(|w| scope.spawn(move || (0..10).map(|k| (format!("{w} {k}"), write(w, k).expect("a file"))).collect::<Vec<_>>()))
                .collect();
            writers.into_iter().flat_map(|w| w.join().expect("a writer")).collect()
        });
        let names: BTreeSet<&PathBuf> = written.iter().map(|(_, path)| path).collect();
        assert_eq!(names.len(), 80, "two writers have one name");
        for (text, path) in &written {
            assert_eq!(&std::fs::read_to_string(path).expect("a file"), text, "{}", path.display());
        }
        for n in others {
            assert_eq!(std::fs::read_to_string(folder.path().join(format!("a-{n}.txt"))).expect("a file"), "another's");
        }
        // No name is skipped, and no other file remains.
        let expected: BTreeSet<String> = (1..=83).map(|n| format!("a-{n}.txt")).collect();
        assert_eq!(names_in(folder.path()), expected);
    }

    fn names_in(folder: &Path) -> BTreeSet<String> {
        let entries = std::fs::read_dir(folder).expect("a folder");
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn names_that_are_all_taken_are_refused_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let name = folder.path().join("a.txt");
        std::fs::write(&name, "first").expect("a file");
        let why = write_new([name.clone()], FileAccess::All, |_| Ok(())).expect_err("it is taken").to_string();
        assert!(why.contains("a.txt") && why.contains("exists already") && !why.contains('\n'), "{why}");
        assert_eq!(std::fs::read_to_string(&name).expect("a file"), "first");
        let nowhere = folder.path().join("none").join("b.txt");
        assert!(write_new([nowhere], FileAccess::All, |_| Ok(())).is_err_and(|e| e.path.ends_with("b.txt")));
    }

    /// A write that fails half-way leaves the old file unchanged and no other behind.
    #[test]
    fn a_write_that_fails_leaves_what_was_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        write_atomic(&path, FileAccess::All, |out| out.write_all(b"first")).expect("written");
        let half = write_atomic(&path, FileAccess::All, |out| {
            out.write_all(&[b'x'; 100_000])?;
            Err(Error::other("the disk is gone"))
        });
        assert!(half.expect_err("failed").to_string().ends_with("a.txt: the disk is gone"));
        assert_eq!(std::fs::read(&path).expect("a file"), b"first");
        assert_eq!(names_in(folder.path()), BTreeSet::from(["a.txt".to_owned()]));
    }

    #[test]
    fn only_regular_files_of_bounded_length_are_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a");
        std::fs::write(&path, "12345").expect("a file");
        assert_eq!(read_bytes(&path, 5).expect("read"), b"12345");
        assert_eq!(read_bytes(&path, 4).expect_err("long").to_string(), "5 bytes, more than 4, the most that are read");
        assert_eq!(read_bytes(folder.path(), 4).expect_err("a folder").kind(), ErrorKind::IsADirectory);
        assert_eq!(read_bytes(&folder.path().join("b"), 4).expect_err("none").kind(), ErrorKind::NotFound);
        std::fs::write(&path, [0xff]).expect("a file");
        assert_eq!(read_text(&path, 5).expect_err("no text").to_string(), "not UTF-8 text");
    }

    #[cfg(unix)]
    #[test]
    fn links_that_lead_out_of_a_folder_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("own/deep")).expect("a folder");
        std::fs::create_dir(at("own-too")).expect("a folder");
        for name in ["own/map", "own-too/map", "secret"] {
            std::fs::write(at(name), name).expect("a file");
        }
        let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, at(name)).expect("a link");
        link("map", "own/near");
        link("../secret", "own/up");
        link("../own-too/map", "own/beside");
        link("/etc/passwd", "own/far");
        link("../..", "own/deep/root");
        link("own", "alias");
        let own = at("own");
        for name in ["map", "near"] {
            assert!(check_inside(&own, &own.join(name)).is_ok() && check_inside(&at("alias"), &at("alias").join(name)).is_ok(), "{name}");
        }
        for name in ["up", "beside", "far", "../secret", "/etc/passwd", "deep/root/secret", "none", "near/x"] {
            assert!(check_inside(&own, &own.join(name)).is_err(), "{name}");
        }
    }

    /// Reading any of these would block or never end.
    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_at_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let (pipe, link, round) = (folder.path().join("pipe"), folder.path().join("link"), folder.path().join("round"));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo runs").success());
        std::os::unix::fs::symlink("/dev/zero", &link).expect("a link");
        std::os::unix::fs::symlink(&round, &round).expect("a link");
        let begun = std::time::Instant::now();
        for path in [&pipe, &link, Path::new("/dev/zero")] {
            assert_eq!(read_bytes(path, 1 << 20).expect_err("no file").to_string(), "not a regular file");
            assert!(write_atomic(path, FileAccess::All, |_| Ok(())).is_err_and(|e| e.why.contains("not a regular file")), "{path:?}");
        }
        assert!(read_bytes(&round, 1 << 20).is_err());
        // A procfs file that reports length 0.
        assert!(!read_bytes(Path::new("/proc/self/stat"), 1 << 20).map_or(vec![0], |b| b).is_empty());
        assert!(begun.elapsed() < Duration::from_secs(5));
    }

    #[test]
    #[expect(clippy::disallowed_methods, reason = "ages of files on disk")]
    fn litter_older_than_a_day_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let put = |name: &str, age_s: u64| {
            let file = File::create(folder.path().join(name)).expect("a file");
            file.set_modified(SystemTime::now() - Duration::from_secs(age_s)).expect("a time");
        };
        put(&format!("{TEMPORARY}old"), 90_000);
        put(&format!("{TEMPORARY}young"), 80_000);
        put(".another-program", 900_000);
        put("picture.png", 900_000);
        std::fs::create_dir(folder.path().join(format!("{TEMPORARY}folder"))).expect("a folder");
        write_cached(&folder.path().join("entry"), b"x").expect("written");
        let expected = [&format!("{TEMPORARY}young"), ".another-program", "picture.png", &format!("{TEMPORARY}folder"), "entry"];
        assert_eq!(names_in(folder.path()), expected.into_iter().map(str::to_owned).collect());
    }

    /// A link placed at a predictable name is never followed.
    #[cfg(unix)]
    #[test]
    fn names_of_temporary_files_differ_and_links_are_not_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (precious, target) = (folder.path().join("precious"), folder.path().join("entry"));
        std::fs::write(&precious, "keep").expect("a file");
        std::os::unix::fs::symlink(&precious, &target).expect("a link");
        let mut temporary = BTreeSet::new();
        for _ in 0..20 {
            write_atomic(&target, FileAccess::Owner, |_| {
                temporary.extend(names_in(folder.path()).into_iter().filter(|n| n.starts_with(TEMPORARY)));
                Ok(())
            })
            .expect("written");
        }
        assert_eq!(temporary.len(), 20);
        assert_eq!(std::fs::read_to_string(&precious).expect("a file"), "keep");
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_others_write_is_told_from_ones_own() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let with = |mode: u32, is_above: bool| {
            std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(mode)).expect("permissions");
            foreign_write_access(folder.path(), is_above).is_some()
        };
        assert!(!with(0o700, false) && !with(0o755, false) && !with(0o1777, true) && !with(0o775, true));
        assert!(with(0o777, false) && with(0o775, false) && with(0o777, true) && with(0o1777, false));
        assert!(foreign_write_access(&folder.path().join("none"), false).is_none());
    }
}
