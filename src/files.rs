//! Reads files with a size limit, and writes files atomically.
//!
//! In: paths. Out: bytes of regular files, of bounded length; files that are written completely or not at all. Always: a pipe, a device or a folder is
//! refused at once. A new file is created under an unpredictable name in its target's folder, never through a link, and is synced to disk before it is
//! renamed to its target. A process that ends early removes its temporary files (`unfinished`); those that a killed process left behind are removed after a
//! day. This module knows no file format and chooses no location.

pub(crate) mod frame_number;
mod links;
mod unfinished;

use crate::wording::{echo, without_byte_order_mark};
pub(crate) use links::{check_inside, is_there};
use parking_lot::Mutex;
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Error, ErrorKind, Read, Result, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use unfinished::TemporaryFile;
pub(crate) use unfinished::remove_unfinished;

/// Prefix of the names of temporary files.
const TEMPORARY_PREFIX: &str = ".orrery-writing-";
/// Age above which a temporary file is taken for one that a killed process left behind, since writing a file never takes this long.
const STALE_AGE: Duration = Duration::from_secs(86_400);

/// Opens a regular file for reading. Returns its length as the system reports it.
fn open_regular(path: &Path) -> Result<(File, u64)> {
    let mut options = OpenOptions::new();
    options.read(true);
    // Opening a pipe without a writer would block forever.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    let file = options.open(path)?;
    let metadata = file.metadata()?;
    if metadata.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "this is a folder, not a file"));
    }
    if !metadata.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "not a regular file"));
    }
    Ok((file, metadata.len()))
}

/// The bytes of a regular file of at most `max_bytes`.
///
/// # Errors
/// The file cannot be opened or read, is not a regular file, or is longer than `max_bytes`.
pub(crate) fn read_bytes(path: &Path, max_bytes: u64) -> Result<Vec<u8>> {
    let (file, length) = open_regular(path)?;
    let too_long =
        |bytes: u64| Error::new(ErrorKind::FileTooLarge, format!("{bytes} bytes, more than {max_bytes}, the most that are read"));
    if length > max_bytes {
        return Err(too_long(length));
    }
    let mut bytes = Vec::new();
    // The length above is not reliable: files of procfs report 0, and others may grow while they are read.
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes { Err(too_long(bytes.len() as u64)) } else { Ok(bytes) }
}

/// A part of a regular file: `count` bytes from `start` on, or those up to its end. Returns the length of the whole file as well.
///
/// # Errors
/// The file cannot be opened or read, or is not a regular file.
pub(crate) fn read_part(path: &Path, start: u64, count: usize) -> Result<(Vec<u8>, u64)> {
    let (mut file, length) = open_regular(path)?;
    file.seek(SeekFrom::Start(start))?;
    let expected = length.saturating_sub(start).min(count as u64);
    let mut bytes = Vec::with_capacity(usize::try_from(expected).unwrap_or(0));
    file.take(count as u64).read_to_end(&mut bytes)?;
    Ok((bytes, length))
}

/// The text of a regular UTF-8 file of at most `max_bytes`, without a byte order mark.
///
/// # Errors
/// Those of [`read_bytes`], or the content is not UTF-8.
pub(crate) fn read_text(path: &Path, max_bytes: u64) -> Result<String> {
    let mut text = String::from_utf8(read_bytes(path, max_bytes)?).map_err(|_| Error::new(ErrorKind::InvalidData, "not UTF-8 text"))?;
    let mark_bytes = text.len() - without_byte_order_mark(&text).len();
    text.drain(..mark_bytes);
    Ok(text)
}

/// Who may read a file that this module writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileAccess {
    /// Everyone whom the process' umask admits, as for any new file.
    All,
    /// Only the user: for settings, which include the user's home location, and for cache entries.
    Owner,
}

/// A file that could not be written. Its text is one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {why}")]
pub struct WriteError {
    /// The path as the caller gave it, escaped and shortened for a message.
    pub path: String,
    /// The reason: usually the system's error, or that the folder is missing.
    pub why: String,
}

/// Writes a file atomically, with the content that `fill` produces.
///
/// # Errors
/// The path and the reason.
pub(crate) fn write_atomic(
    path: &Path,
    access: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>,
) -> std::result::Result<(), WriteError> {
    replace(path, access, fill).map_err(|e| write_error(path, &e))
}

/// Writes a file atomically at the first of `paths` that does not exist yet, and returns that path. All `paths` must be in one folder.
///
/// # Errors
/// The path and the reason, for example that a file exists at every path.
pub(crate) fn write_new(
    paths: impl IntoIterator<Item = PathBuf>,
    access: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>,
) -> std::result::Result<PathBuf, WriteError> {
    let mut paths = paths.into_iter();
    let mut path = paths.next().ok_or_else(|| WriteError { path: String::new(), why: "no name to write to".into() })?;
    let mut file = write_temporary(&path, access, fill).map_err(|e| write_error(&path, &e))?;
    loop {
        match file.persist_new(&path) {
            Ok(()) => return Ok(path),
            Err((e, same_file)) if e.kind() == ErrorKind::AlreadyExists => {
                let taken = || WriteError { path: echo(&path.display().to_string()), why: "a file of this name exists already".into() };
                file = same_file;
                path = paths.next().ok_or_else(taken)?;
            }
            Err((e, _)) => return Err(write_error(&path, &e)),
        }
    }
}

/// Writes a cache entry atomically, readable by this user only, and creates missing folders.
///
/// # Errors
/// The reason why the entry cannot be written.
pub(crate) fn write_cached(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut folders = std::fs::DirBuilder::new();
    folders.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut folders, 0o700);
    folders.create(folder_of(path))?;
    replace(path, FileAccess::Owner, |out| out.write_all(bytes))
}

/// Why a pipe or a device is not written to.
const NOT_REPLACED: &str = "not a regular file; only a regular file can be replaced";

/// Writes a file atomically in place of an existing one, if there is one.
fn replace(path: &Path, access: FileAccess, fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>) -> Result<()> {
    // A rename would replace a device or pipe by a regular file.
    if path.metadata().is_ok_and(|existing| !existing.is_file() && !existing.is_dir()) {
        return Err(Error::new(ErrorKind::InvalidInput, NOT_REPLACED));
    }
    write_temporary(path, access, fill)?.persist(path)
}

/// Writes the content for `path`, completely and synced to disk, to a temporary file in the same folder.
fn write_temporary(path: &Path, access: FileAccess, fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>) -> Result<TemporaryFile> {
    let folder = folder_of(path);
    remove_stale_once(folder);
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    // The mode is set at creation, because the system then applies the umask; a mode set later would bypass it.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, if access == FileAccess::All { 0o666 } else { 0o600 });
    #[cfg(not(unix))]
    let _ = access;
    // The file is opened here, because the error message of `tempfile` would contain the temporary name.
    let create = || tempfile::Builder::new().prefix(TEMPORARY_PREFIX).make_in(folder, |temporary_path| options.open(temporary_path));
    let mut file = TemporaryFile::new(create)?;
    let mut out = BufWriter::new(file.as_file_mut());
    fill(&mut out)?;
    out.flush()?;
    drop(out);
    file.as_file_mut().sync_all()?;
    Ok(file)
}

/// The folder of a file; the current folder for a bare name.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Checks whether a file can be written, before the long work that computes its content: its folder must exist, and the path must be unused or name a
/// regular file.
///
/// # Errors
/// The path and the reason.
pub(crate) fn check_output_path(path: &Path) -> std::result::Result<(), WriteError> {
    let refused = |kind: ErrorKind, why: &str| Err(write_error(path, &Error::new(kind, why)));
    let ends_in_separator = path.as_os_str().as_encoded_bytes().last().is_some_and(|b| std::path::is_separator(char::from(*b)));
    match folder_of(path).metadata() {
        Err(e) => Err(write_error(path, &e)),
        Ok(folder) if !folder.is_dir() => refused(ErrorKind::NotADirectory, "not a folder"),
        Ok(_) if path.is_dir() => refused(ErrorKind::IsADirectory, "this is a folder, not a file"),
        Ok(_) if ends_in_separator => refused(ErrorKind::IsADirectory, "this names a folder, not a file"),
        Ok(_) => match path.metadata() {
            Ok(existing) if !existing.is_file() => refused(ErrorKind::InvalidInput, NOT_REPLACED),
            // Such as a name that is too long for the file system.
            Err(e) if e.kind() != ErrorKind::NotFound => Err(write_error(path, &e)),
            _ => Ok(()),
        },
    }
}

/// As [`check_output_path`]; also tries to create a file in the folder, which costs a write to the disk.
pub(crate) fn try_output_path(path: &Path) -> std::result::Result<(), WriteError> {
    check_output_path(path)?;
    write_temporary(path, FileAccess::All, |_| Ok(())).map(drop).map_err(|e| write_error(path, &e))
}

/// Checks whether files can be written below a folder that need not exist: tries to create one in it, or else in the nearest folder above it that exists.
///
/// # Errors
/// The folder in which no file can be created, and the reason.
pub(crate) fn try_folder(folder: &Path) -> std::result::Result<(), WriteError> {
    let refused = |folder: &Path, why: String| Err(WriteError { path: echo(&folder.display().to_string()), why });
    // The last ancestor of a relative path is empty.
    let named = |path: &Path| if path.as_os_str().is_empty() { PathBuf::from(".") } else { path.to_owned() };
    let Some(existing) = folder.ancestors().map(named).find(|path| is_there(path)) else {
        return refused(folder, "there is no such folder".into());
    };
    if !existing.is_dir() {
        return refused(&existing, "not a folder".into());
    }
    match write_temporary(&existing.join("file"), FileAccess::Owner, |_| Ok(())) {
        Ok(_) => Ok(()),
        Err(e) => refused(&existing, format!("no file can be created in it ({e})")),
    }
}

/// Whether two paths name the same file, which need not exist.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    let folder_and_name = |path: &Path| Some((folder_of(path).canonicalize().ok()?, path.file_name()?.to_owned()));
    folder_and_name(a).is_some_and(|of_a| folder_and_name(b) == Some(of_a))
}

/// Removes a file. Returns false if there is none, which is no error, because another process may have removed it.
///
/// # Errors
/// The reason why the file cannot be removed.
pub(crate) fn remove_if_present(path: &Path) -> Result<bool> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
        removed => removed.map(|()| true),
    }
}

/// The error for a failed write. If the folder is missing, the error names the folder.
pub(crate) fn write_error(path: &Path, e: &Error) -> WriteError {
    let folder = echo(&folder_of(path).display().to_string());
    let why = match e.kind() {
        ErrorKind::NotFound => format!("there is no folder {folder}; make it first"),
        ErrorKind::NotADirectory => format!("{folder} is not a folder"),
        _ => e.to_string(),
    };
    WriteError { path: echo(&path.display().to_string()), why }
}

/// Whether a file is a temporary file of this program.
pub(crate) fn is_temporary(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n.to_string_lossy().starts_with(TEMPORARY_PREFIX))
}

/// Removes temporary files older than [`STALE_AGE`] from a folder, once per process and folder.
fn remove_stale_once(folder: &Path) {
    static CHECKED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    if !CHECKED.lock().insert(folder.to_owned()) {
        return;
    }
    #[expect(clippy::disallowed_methods, reason = "the age of a file on disk; no image depends on it")]
    let now = SystemTime::now();
    let is_old = |path: &Path| {
        let changed = path.symlink_metadata().ok().filter(std::fs::Metadata::is_file).and_then(|m| m.modified().ok());
        changed.and_then(|modified| now.duration_since(modified).ok()).is_some_and(|age| age > STALE_AGE)
    };
    let entries = std::fs::read_dir(folder).ok().into_iter().flatten().flatten().map(|e| e.path());
    // A failure is ignored: the file may belong to another user, or another process may have removed it.
    entries.filter(|path| is_temporary(path) && is_old(path)).for_each(|path| drop(std::fs::remove_file(path)));
}

/// Why other users could write to a folder (its owner or mode); `None` if they cannot, or if the folder does not exist. `is_parent`: the folder is not the
/// program's own but one that contains it. Such a folder may be group-writable, and world-writable if only owners can remove files (the sticky bit of
/// /tmp), because the program's own folder is checked separately.
#[cfg(unix)]
pub(crate) fn foreign_write_access(folder: &Path, is_parent: bool) -> Option<String> {
    use std::os::unix::fs::MetadataExt;
    // SAFETY: `geteuid` takes no arguments, cannot fail and has no side effects.
    let user_id = unsafe { libc::geteuid() };
    // For a link, both the link itself and its target are checked.
    for metadata in [folder.symlink_metadata().ok()?, folder.metadata().ok()?] {
        if metadata.uid() != user_id && metadata.uid() != 0 {
            return Some(format!("it belongs to user {}", metadata.uid()));
        }
        // Bits of the mode: 0o002 writable by everyone else, 0o020 writable by the group, 0o1000 sticky.
        let is_open = match is_parent {
            true => metadata.mode() & 0o002 != 0 && metadata.mode() & 0o1000 == 0,
            false => metadata.mode() & 0o022 != 0,
        };
        if metadata.is_dir() && is_open {
            return Some(format!("others may write into it (mode {:o})", metadata.mode() & 0o7777));
        }
    }
    None
}

#[cfg(not(unix))]
pub(crate) fn foreign_write_access(_folder: &Path, _is_parent: bool) -> Option<String> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names `a-1.txt`, `a-2.txt` and so on.
    fn numbered(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
        let folder = folder.to_owned();
        (1..).map(move |n| folder.join(format!("a-{n}.txt")))
    }

    /// Eight concurrent writers write ten files each into a folder with existing files: no file is lost or replaced.
    #[test]
    fn concurrent_writes_to_new_names_replace_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let existing = [2, 5, 41];
        for n in existing {
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
        assert_eq!(names.len(), 80, "two writers got the same name");
        for (text, path) in &written {
            assert_eq!(&std::fs::read_to_string(path).expect("a file"), text, "{}", path.display());
        }
        for n in existing {
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
    fn if_all_names_are_taken_the_error_names_the_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let name = folder.path().join("a.txt");
        std::fs::write(&name, "first").expect("a file");
        let why = write_new([name.clone()], FileAccess::All, |_| Ok(())).expect_err("it is taken").to_string();
        assert!(why.contains("a.txt") && why.contains("exists already") && !why.contains('\n'), "{why}");
        assert_eq!(std::fs::read_to_string(&name).expect("a file"), "first");
        let nowhere = folder.path().join("none").join("b.txt");
        assert!(write_new([nowhere], FileAccess::All, |_| Ok(())).is_err_and(|e| e.path.ends_with("b.txt")));
    }

    /// A write that fails half-way leaves the old file unchanged, and leaves no other file behind.
    #[test]
    fn a_failed_write_keeps_the_old_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        write_atomic(&path, FileAccess::All, |out| out.write_all(b"first")).expect("written");
        let failed_write = write_atomic(&path, FileAccess::All, |out| {
            out.write_all(&[b'x'; 100_000])?;
            Err(Error::other("the disk is gone"))
        });
        assert!(failed_write.expect_err("failed").to_string().ends_with("a.txt: the disk is gone"));
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
        assert_eq!(read_part(&path, 1, 3).expect("read"), (b"234".to_vec(), 5));
        assert_eq!(read_part(&path, 3, 9).expect("read"), (b"45".to_vec(), 5));
        assert_eq!(read_part(&path, 7, 1).expect("read"), (Vec::new(), 5));
        assert!(read_part(folder.path(), 0, 1).is_err() && read_part(&folder.path().join("b"), 0, 1).is_err());
        std::fs::write(&path, [0xff]).expect("a file");
        assert_eq!(read_text(&path, 5).expect_err("no text").to_string(), "not UTF-8 text");
        for (written, read) in [("\u{feff}a\u{feff}", "a\u{feff}"), ("\u{feff}", ""), ("a", "a"), ("", "")] {
            std::fs::write(&path, written).expect("a file");
            assert_eq!(read_text(&path, 9).expect("text"), read, "{written:?}");
        }
    }

    /// Reading the pipe or the device would block or never end.
    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_at_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let (pipe, link, cycle) = (folder.path().join("pipe"), folder.path().join("link"), folder.path().join("cycle"));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo runs").success());
        std::os::unix::fs::symlink("/dev/zero", &link).expect("a link");
        std::os::unix::fs::symlink(&cycle, &cycle).expect("a link");
        let begun = std::time::Instant::now();
        for path in [&pipe, &link, Path::new("/dev/zero")] {
            assert_eq!(read_bytes(path, 1 << 20).expect_err("no file").to_string(), "not a regular file");
            assert_eq!(read_part(path, 0, 1).expect_err("no file").to_string(), "not a regular file");
            assert!(write_atomic(path, FileAccess::All, |_| Ok(())).is_err_and(|e| e.why.contains("not a regular file")), "{path:?}");
            assert!(check_output_path(path).is_err_and(|e| e.why.contains("not a regular file")), "{path:?}");
        }
        assert!(read_bytes(&cycle, 1 << 20).is_err());
        // A file of procfs reports length 0 and has content all the same. On a system without procfs, where reading fails, nothing is checked.
        assert!(!read_bytes(Path::new("/proc/self/stat"), 1 << 20).map_or(vec![0], |b| b).is_empty());
        assert!(begun.elapsed() < Duration::from_secs(5));
    }

    #[test]
    #[expect(clippy::disallowed_methods, reason = "ages of files on disk")]
    fn only_temporary_files_older_than_a_day_are_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let put = |name: &str, age_s: u64| {
            let file = File::create(folder.path().join(name)).expect("a file");
            file.set_modified(SystemTime::now() - Duration::from_secs(age_s)).expect("a time");
        };
        put(&format!("{TEMPORARY_PREFIX}old"), 90_000);
        put(&format!("{TEMPORARY_PREFIX}young"), 80_000);
        put(".another-program", 900_000);
        put("picture.png", 900_000);
        std::fs::create_dir(folder.path().join(format!("{TEMPORARY_PREFIX}folder"))).expect("a folder");
        write_cached(&folder.path().join("entry"), b"x").expect("written");
        let expected =
            [&format!("{TEMPORARY_PREFIX}young"), ".another-program", "picture.png", &format!("{TEMPORARY_PREFIX}folder"), "entry"];
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
                temporary.extend(names_in(folder.path()).into_iter().filter(|n| n.starts_with(TEMPORARY_PREFIX)));
                Ok(())
            })
            .expect("written");
        }
        assert_eq!(temporary.len(), 20);
        assert_eq!(std::fs::read_to_string(&precious).expect("a file"), "keep");
    }

    #[cfg(unix)]
    #[test]
    fn folders_that_others_can_write_are_detected() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let others_can_write = |mode: u32, is_parent: bool| {
            std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(mode)).expect("permissions");
            foreign_write_access(folder.path(), is_parent).is_some()
        };
        let (own_folder, parent) = (|mode| others_can_write(mode, false), |mode| others_can_write(mode, true));
        assert!(!own_folder(0o700) && !own_folder(0o755) && !parent(0o1777) && !parent(0o775));
        assert!(own_folder(0o777) && own_folder(0o775) && parent(0o777) && own_folder(0o1777));
        assert!(foreign_write_access(&folder.path().join("none"), false).is_none());
    }
}
