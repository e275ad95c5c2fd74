//! Files: bounded reading of what comes from outside, whole writing of what is kept.
//!
//! In: paths. Out: bytes of regular files, of bounded length; files that are written whole or not at all. Always: a pipe, a device or a folder is refused at once; what is
//! written is created under a name that nobody can foresee, in the folder of its target and never through a link, and is on the disk before it takes the target's name;
//! temporary files that a killed process left are removed when a day old. It knows no format, and decides on no place.

use crate::wording::echo;
use parking_lot::Mutex;
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Error, ErrorKind, Read, Result, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use tempfile::NamedTempFile;

/// What the names of temporary files begin with.
const TEMPORARY: &str = ".orrery-writing-";
/// Age from which a temporary file is of no process that still runs: none takes so long to write one file.
const LITTER_AGE: Duration = Duration::from_secs(86_400);

/// The bytes of a regular file of at most `max_bytes`.
///
/// # Errors
/// Why it cannot be opened or read, that it is no regular file, or that it is longer.
pub fn read_bytes(path: &Path, max_bytes: u64) -> Result<Vec<u8>> {
    let mut options = OpenOptions::new();
    options.read(true);
    // Opening a pipe that nobody writes would wait for ever.
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
    // Files of the kernel say that they have no bytes; others may grow.
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes { Err(too_long(bytes.len() as u64)) } else { Ok(bytes) }
}

/// The same of text in UTF-8.
///
/// # Errors
/// As [`read_bytes`], or that it is not UTF-8.
pub fn read_text(path: &Path, max_bytes: u64) -> Result<String> {
    String::from_utf8(read_bytes(path, max_bytes)?).map_err(|_| Error::new(ErrorKind::InvalidData, "not UTF-8 text"))
}

/// That a file of a folder lies in it, links followed: the folder may be a stranger's, and its catalog names the file.
///
/// # Errors
/// That it lies elsewhere, or that it or the folder is not there.
pub fn check_inside(folder: &Path, path: &Path) -> Result<()> {
    match path.canonicalize()?.starts_with(folder.canonicalize()?) {
        true => Ok(()),
        false => Err(Error::new(ErrorKind::InvalidInput, "a link that leads out of its folder; put the file itself there")),
    }
}

/// Who may read a file that is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileAccess {
    All,
    /// Settings tell where someone lives.
    Owner,
}

/// A file that could not be written. Its text is one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {why}")]
pub struct WriteError {
    /// As it was named, escaped and cut for a message.
    pub path: String,
    /// What the system says, or which folder is missing.
    pub why: String,
}

/// Writes beside the target and moves it there whole.
///
/// # Errors
/// The path and why.
pub fn write_whole(
    path: &Path,
    readers: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>,
) -> std::result::Result<(), WriteError> {
    replace(path, readers, fill).map_err(|e| failure(path, &e))
}

/// Writes beside the target and moves it whole to the first of `names`, all of one folder, that no file has; answers which it is.
///
/// # Errors
/// The path and why: no name is free, for one.
pub fn write_new(
    names: impl IntoIterator<Item = PathBuf>,
    readers: FileAccess,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>,
) -> std::result::Result<PathBuf, WriteError> {
    let mut names = names.into_iter();
    let none = || WriteError { path: String::new(), why: "no name to write to".into() };
    let mut name = names.next().ok_or_else(none)?;
    let mut file = filled(&name, readers, fill).map_err(|e| failure(&name, &e))?;
    loop {
        // One step of the system: between looking and moving another program could take the name.
        match file.persist_noclobber(&name) {
            Ok(_) => return Ok(name),
            Err(e) if e.error.kind() == ErrorKind::AlreadyExists => {
                let taken = || WriteError { path: echo(&name.display().to_string()), why: "a file of this name exists already".into() };
                file = e.file;
                name = names.next().ok_or_else(taken)?;
            }
            Err(e) => return Err(failure(&name, &e.error)),
        }
    }
}

/// Writes an entry of a cache whole, for this user alone, and makes the folders that it lacks.
///
/// # Errors
/// Why it cannot be written.
pub fn write_cached(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut folders = std::fs::DirBuilder::new();
    folders.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut folders, 0o700);
    folders.create(folder_of(path))?;
    replace(path, FileAccess::Owner, |out| out.write_all(bytes))
}

fn replace(path: &Path, readers: FileAccess, fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>) -> Result<()> {
    // Moving a file there would put an end to the device or pipe.
    if path.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        return Err(Error::new(ErrorKind::InvalidInput, "not a regular file, which cannot be replaced"));
    }
    filled(path, readers, fill)?.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// The content of `path`, whole and on the disk, under another name of its folder.
fn filled(path: &Path, readers: FileAccess, fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<()>) -> Result<NamedTempFile> {
    let folder = folder_of(path);
    remove_litter_once(folder);
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    // Opened here: the crate's own opening puts the temporary name into its message.
    let mut file = tempfile::Builder::new().prefix(TEMPORARY).make_in(folder, |at| options.open(at))?;
    let mut out = BufWriter::new(file.as_file_mut());
    fill(&mut out)?;
    out.flush()?;
    drop(out);
    if readers == FileAccess::All {
        open_to_others(file.as_file());
    }
    file.as_file().sync_all()?;
    Ok(file)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Which folder is missing says more than that something is.
pub fn failure(path: &Path, e: &Error) -> WriteError {
    let folder = echo(&folder_of(path).display().to_string());
    let why = match e.kind() {
        ErrorKind::NotFound => format!("there is no folder {folder}; make it first"),
        ErrorKind::NotADirectory => format!("{folder} is no folder"),
        _ => e.to_string(),
    };
    WriteError { path: echo(&path.display().to_string()), why }
}

/// Temporary files are private; a picture is not.
#[cfg(unix)]
fn open_to_others(file: &File) {
    use std::os::unix::fs::PermissionsExt;
    // Failing leaves the picture readable by its owner alone, which is no reason to lose it.
    let _ = file.set_permissions(std::fs::Permissions::from_mode(0o644));
}

#[cfg(not(unix))]
fn open_to_others(_file: &File) {}

/// Whether a file is a temporary one of this program.
pub fn is_temporary(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n.to_string_lossy().starts_with(TEMPORARY))
}

/// Removes the temporary files of a folder that are older than a day, when this process first writes into it.
fn remove_litter_once(folder: &Path) {
    static LOOKED_INTO: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    if !LOOKED_INTO.lock().insert(folder.to_owned()) {
        return;
    }
    #[expect(clippy::disallowed_methods, reason = "the age of a file on disk; no picture depends on it")]
    let now = SystemTime::now();
    let is_old = |path: &Path| {
        let changed = path.symlink_metadata().ok().filter(std::fs::Metadata::is_file).and_then(|m| m.modified().ok());
        changed.and_then(|at| now.duration_since(at).ok()).is_some_and(|age| age > LITTER_AGE)
    };
    let entries = std::fs::read_dir(folder).ok().into_iter().flatten().flatten().map(|e| e.path());
    // Another user's, or gone already: neither stops anybody.
    entries.filter(|path| is_temporary(path) && is_old(path)).for_each(|path| drop(std::fs::remove_file(path)));
}

/// Why a folder is not this user's alone to write: another's, or open to others. `is_above`: our own folder is below it and is looked at itself, so that a group may write
/// here, and everybody where nobody can remove what is another's (the sticky bit of /tmp). A folder that does not exist is nobody's.
#[cfg(unix)]
pub fn who_else_writes(folder: &Path, is_above: bool) -> Option<String> {
    use std::os::unix::fs::MetadataExt;
    // SAFETY: it takes nothing, cannot fail and changes nothing.
    let own = unsafe { libc::geteuid() };
    // Of a link both count: what it is and where it leads.
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
pub fn who_else_writes(_folder: &Path, _is_above: bool) -> Option<String> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
        let folder = folder.to_owned();
        (1..).map(move |n| folder.join(format!("a-{n}.txt")))
    }

    /// Eight writers at once, each ten files, beside files of others: nothing is lost and nothing replaced.
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
        // No name is left out, and nothing else is left behind.
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

    /// A failure half-way leaves the old file as it was and nothing beside it.
    #[test]
    fn a_write_that_fails_leaves_what_was_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        write_whole(&path, FileAccess::All, |out| out.write_all(b"first")).expect("written");
        let half = write_whole(&path, FileAccess::All, |out| {
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

    /// Each of these would never end, or never begin.
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
            assert!(write_whole(path, FileAccess::All, |_| Ok(())).is_err_and(|e| e.why.contains("not a regular file")), "{path:?}");
        }
        assert!(read_bytes(&round, 1 << 20).is_err());
        // A file of the kernel that says it has no bytes.
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

    /// What someone laid at a name that could be foreseen is never written through.
    #[cfg(unix)]
    #[test]
    fn names_of_temporary_files_differ_and_links_are_not_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let (precious, target) = (folder.path().join("precious"), folder.path().join("entry"));
        std::fs::write(&precious, "keep").expect("a file");
        std::os::unix::fs::symlink(&precious, &target).expect("a link");
        let mut temporary = BTreeSet::new();
        for _ in 0..20 {
            write_whole(&target, FileAccess::Owner, |_| {
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
            who_else_writes(folder.path(), is_above).is_some()
        };
        assert!(!with(0o700, false) && !with(0o755, false) && !with(0o1777, true) && !with(0o775, true));
        assert!(with(0o777, false) && with(0o775, false) && with(0o777, true) && with(0o1777, false));
        assert!(who_else_writes(&folder.path().join("none"), false).is_none());
    }
}
