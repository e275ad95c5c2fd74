//! The folder in which decoded maps are kept between runs of the program, because decoding a map and computing its mip levels takes longer
//! than drawing a frame.
//!
//! A stored map is a file of the folder, called an entry ([`map_entry`]). In: the file of a map. Out: its texture. If the map has an entry, the levels are
//! read from it one by one, each when it is first needed; if not, the map is decoded and stored. Always: the levels are those that the decoder returns. The
//! map of a damaged entry is decoded again, and the entry replaced. If the folder cannot be written, maps are decoded in each run. The entries together have
//! at most [`DISK_BUDGET_BYTES`]: those of other versions of the program are removed first, then the oldest.

use super::encoded_map::EncodedMap;
use super::map_entry::{self, EntryHeader, Key};
use super::mip_level::{Level, LevelSource};
use super::mips::RowThreads;
use super::{ImageError, MAX_MAP_SIDE, PoleFilter, TexelFormat, Texture, check_size};
use crate::files::{is_temporary, read_bytes, read_part, remove_if_present, write_cached};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, OnceLock};
use std::time::SystemTime;
use twox_hash::XxHash3_128;

/// Limit on the bytes of all entries together. The embedded maps take less than half of it.
pub(crate) const DISK_BUDGET_BYTES: u64 = 256 << 20;
/// Limit on the bytes of one entry. A larger map is not stored, but decoded in each run: in colour from 17 megapixels on, as a pixel takes 3 bytes, 4 with its
/// mip levels.
const MAX_ENTRY_BYTES: u64 = 64 << 20;
/// The extension of entries.
const EXTENSION: &str = "levels";

/// The source files whose code determines the levels. After a change to any of them, even of a comment, entries written before count as those of another
/// version of the program.
const SOURCES: [&str; 8] = [
    include_str!("map_entry.rs"),
    include_str!("encoded_map.rs"),
    include_str!("map_decoding.rs"),
    include_str!("mips.rs"),
    include_str!("poles.rs"),
    include_str!("mod.rs"),
    include_str!("jpeg.rs"),
    include_str!("../units.rs"),
];
/// The libraries that decode images, whose versions are in the lock file.
const DECODERS: [&str; 5] = ["image", "png", "fdeflate", "zune-core", "zune-jpeg"];
const CARGO_LOCK: &str = include_str!("../../Cargo.lock");

/// The section of a library in the lock file, with version and checksum; `None` if the file lacks the library.
fn locked_package(name: &str) -> Option<&'static str> {
    let line = format!("name = \"{name}\"\n");
    CARGO_LOCK.split("\n\n").find(|block| block.contains(&line))
}

/// Digest of the code that determines the levels.
static CODE_DIGEST: LazyLock<Key> = LazyLock::new(|| code_digest(&SOURCES));

fn code_digest(sources: &[&str]) -> Key {
    let mut hash = XxHash3_128::new();
    for text in sources.iter().copied().chain(DECODERS.iter().filter_map(|name| locked_package(name))) {
        // The length precedes each text, so that different lists of texts never give the same bytes.
        hash.write(&(text.len() as u64).to_le_bytes());
        hash.write(text.as_bytes());
    }
    hash.finish_128().to_le_bytes()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// Digest of everything that determines the levels of a map.
fn key_of(map: &EncodedMap) -> Key {
    let format = match map.decoding.format {
        TexelFormat::Rgba8Srgb => 0,
        TexelFormat::Rgba8Unorm => 1,
        TexelFormat::Rgba32Float => 2,
    };
    let poles = match map.decoding.poles {
        PoleFilter::None => 0,
        PoleFilter::Values => 1,
        PoleFilter::Normals => 2,
    };
    let mut hash = XxHash3_128::new();
    hash.write(&*CODE_DIGEST);
    hash.write(&[format, poles]);
    // Of a map of clouds: the texel values between which opacity rises.
    for bound in map.decoding.opacity.iter().flat_map(|texels| texels.range()) {
        hash.write(&bound.to_bits().to_le_bytes());
    }
    hash.write(&map.bytes);
    hash.finish_128().to_le_bytes()
}

/// Number and size of the entries in the folder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct StoredMapsStatus {
    /// Number of entries of this version of the program.
    pub entries: u64,
    /// Bytes of those entries.
    pub bytes: u64,
    /// Number of entries of other versions of the program.
    pub other_entries: u64,
    /// Bytes of the entries of other versions.
    pub other_bytes: u64,
}

/// A file with the extension of an entry.
struct EntryFile {
    path: PathBuf,
    /// Whether this version of the program wrote it.
    is_own: bool,
    bytes: u64,
    modified: SystemTime,
}

/// The folder of stored maps.
#[derive(Debug)]
pub struct StoredMaps {
    folder: PathBuf,
    budget_bytes: u64,
    /// Whether an entry could not be written: then no further one is.
    write_failed: AtomicBool,
}

impl StoredMaps {
    /// `cache`: the folder that contains, or will contain, the folder `orrery/`.
    pub fn new(cache: &Path) -> Self {
        Self { folder: cache.join("orrery").join("maps"), budget_bytes: DISK_BUDGET_BYTES, write_failed: AtomicBool::new(false) }
    }

    /// The start of the file names of this version's entries.
    fn version_prefix() -> String {
        hex(&CODE_DIGEST[..8])
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}-{}.{EXTENSION}", Self::version_prefix(), hex(key)))
    }

    /// The texture of a map, from its entry if there is one.
    pub(super) fn texture(self: &Arc<Self>, map: EncodedMap) -> Result<Texture, ImageError> {
        let key = key_of(&map);
        let file_start = 0;
        let head = read_part(&self.path(&key), file_start, map_entry::MAX_HEADER_BYTES).ok();
        let header = head.and_then(|(bytes, file_bytes)| EntryHeader::parse(&bytes, file_bytes));
        let Some(header) = header.filter(|header| header.key == key) else {
            let texture = map.decode(RowThreads::All)?;
            self.write(&key, &texture.levels);
            return Ok(texture);
        };
        check_size(&map.name, header.size, map.max_megapixels, MAX_MAP_SIDE)?;
        let (format, sizes) = (map.decoding.format, header.sizes());
        let source = Arc::new(EntryLevels { store: Arc::clone(self), map, header, decoded: OnceLock::new() });
        let level = |(k, size)| Level::on_demand(size, Arc::clone(&source) as Arc<dyn LevelSource>, k);
        Ok(Texture { format, levels: sizes.into_iter().enumerate().map(level).collect() })
    }

    /// Stores a complete chain, unless it is too large. After one failure nothing more is written, because on a full or read-only disk further
    /// attempts would only cost time.
    fn write(&self, key: &Key, chain: &[Level]) {
        let unpacked_bytes: u64 = chain.iter().map(|level| level.byte_count() as u64).sum();
        // An entry stores at least a quarter of the unpacked bytes: one (a grey map), three or all four bytes of a texel.
        if unpacked_bytes / 4 > MAX_ENTRY_BYTES || self.write_failed.load(Ordering::Relaxed) {
            return;
        }
        let Some(bytes) = map_entry::encode(key, chain).filter(|bytes| bytes.len() as u64 <= MAX_ENTRY_BYTES) else { return };
        let path = self.path(key);
        if write_cached(&path, &bytes).is_err() {
            self.write_failed.store(true, Ordering::Relaxed);
            return;
        }
        self.make_room(&path);
    }

    /// Removes entries, those of other versions first, then the oldest, until the rest fits into the budget. The entry `kept` stays.
    fn make_room(&self, kept: &Path) {
        let mut entries = self.entries();
        let mut total: u64 = entries.iter().map(|entry| entry.bytes).sum();
        // `false` sorts before `true`.
        entries.sort_by(|a, b| (a.is_own, a.modified, &a.path).cmp(&(b.is_own, b.modified, &b.path)));
        for entry in entries.iter().filter(|entry| entry.path != kept) {
            if total <= self.budget_bytes {
                return;
            }
            // An error means that another process has removed it already, or that it cannot be removed.
            let _ = std::fs::remove_file(&entry.path);
            total -= entry.bytes;
        }
    }

    /// Paths of everything in the folder.
    fn paths(&self) -> impl Iterator<Item = PathBuf> + use<> {
        std::fs::read_dir(&self.folder).ok().into_iter().flatten().flatten().map(|entry| entry.path())
    }

    /// Everything in the folder with the extension of an entry, including pipes and links, but no folders.
    fn entries(&self) -> Vec<EntryFile> {
        let prefix = Self::version_prefix();
        let entry_file = |path: PathBuf| {
            let metadata = path.symlink_metadata().ok().filter(|m| !m.is_dir())?;
            let is_own = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(&prefix));
            let modified = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            Some(EntryFile { path, is_own, bytes: metadata.len(), modified })
        };
        self.paths().filter(|path| path.extension().is_some_and(|e| e == EXTENSION)).filter_map(entry_file).collect()
    }

    /// Counts the entries.
    pub fn status(&self) -> StoredMapsStatus {
        let mut status = StoredMapsStatus::default();
        for entry in self.entries() {
            let (entries, bytes) = match entry.is_own {
                true => (&mut status.entries, &mut status.bytes),
                false => (&mut status.other_entries, &mut status.other_bytes),
            };
            *entries += 1;
            *bytes += entry.bytes;
        }
        status
    }

    /// Checks every entry of this version. Returns the number of intact entries, and the paths of the others with what is wrong.
    pub fn verify(&self) -> (u64, Vec<(PathBuf, String)>) {
        let mut files: Vec<PathBuf> = self.entries().into_iter().filter(|entry| entry.is_own).map(|entry| entry.path).collect();
        files.sort();
        let (mut intact_count, mut damaged) = (0, Vec::new());
        for path in files {
            match read_bytes(&path, MAX_ENTRY_BYTES).map(|bytes| map_entry::key_if_intact(&bytes)) {
                Ok(Some(key)) if self.path(&key) == path => intact_count += 1,
                Ok(Some(_)) => damaged.push((path, "it is the entry of another map".into())),
                Ok(None) => damaged.push((path, "its checksum is wrong".into())),
                Err(e) => damaged.push((path, e.to_string())),
            }
        }
        (intact_count, damaged)
    }

    /// Removes the entries of all versions, and temporary files of crashed writers. Returns the number of files removed.
    pub fn clear(&self) -> std::io::Result<u64> {
        if let Err(e) = std::fs::read_dir(&self.folder)
            && e.kind() != std::io::ErrorKind::NotFound
        {
            return Err(std::io::Error::new(e.kind(), format!("{} cannot be read: {e}", self.folder.display())));
        }
        let mut removed_count = 0;
        for file in self.paths().filter(|f| is_temporary(f)).chain(self.entries().into_iter().map(|entry| entry.path)) {
            removed_count += u64::from(remove_if_present(&file)?);
        }
        // A folder that contains other files is kept.
        let _ = std::fs::remove_dir(&self.folder);
        Ok(removed_count)
    }
}

/// The levels of a map with an entry whose header is intact.
#[derive(Debug)]
struct EntryLevels {
    store: Arc<StoredMaps>,
    map: EncodedMap,
    header: EntryHeader,
    /// All levels, decoded again from the map's file after a level could not be read from the entry.
    decoded: OnceLock<Vec<Level>>,
}

impl LevelSource for EntryLevels {
    fn read(&self, level: usize) -> Vec<u8> {
        if self.decoded.get().is_none() {
            let (start, byte_count) = self.header.start_and_length(level);
            let read = read_part(&self.store.path(&self.header.key), start, byte_count).ok();
            if let Some(texels) = read.and_then(|(packed, _)| self.header.unpack(level, &packed)) {
                return texels;
            }
        }
        let decoded = self.decoded.get_or_init(|| {
            // An entry exists only for a file that can be decoded.
            let levels = self.map.decode(RowThreads::CallingOnly).map_or(Vec::new(), |texture| texture.levels);
            self.store.write(&self.header.key, &levels);
            levels
        });
        decoded.get(level).map_or(Vec::new(), |level| level.bytes().to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{MapDecoding, MapStore, SharedTexture};

    const COLOUR: MapDecoding = MapDecoding { poles: PoleFilter::Values, ..MapDecoding::plain(TexelFormat::Rgba8Srgb) };
    const NORMALS: MapDecoding = MapDecoding { poles: PoleFilter::Normals, ..MapDecoding::plain(TexelFormat::Rgba8Unorm) };

    /// The folder of a user who has no maps of their own.
    const NO_FOLDER: Option<PathBuf> = None;

    /// A map as a new run of the program reads it.
    fn read(cache: &Path, (name, decoding): (&str, MapDecoding)) -> SharedTexture {
        MapStore::new(NO_FOLDER).with_disk_cache(Some(StoredMaps::new(cache))).get_decoded(name, decoding).expect("a map")
    }

    fn files(cache: &Path) -> Vec<PathBuf> {
        let mut all: Vec<_> = std::fs::read_dir(cache.join("orrery/maps")).into_iter().flatten().flatten().map(|e| e.path()).collect();
        all.sort();
        all
    }

    /// The levels that were read so far.
    fn in_memory(texture: &Texture) -> Vec<usize> {
        (0..texture.levels.len()).filter(|level| texture.levels[*level].bytes_in_memory() > 0).collect()
    }

    /// Maps of colours and of normals, a grey one, and one with odd sides: the levels are those of the decoder; a second run reads only the levels
    /// that are used.
    #[test]
    fn levels_are_those_of_the_decoder_and_are_read_one_by_one() {
        for map in [("iapetus.jpg", COLOUR), ("mars_normal.jpg", NORMALS), ("earth_water.jpg", COLOUR), ("jupiter.jpg", COLOUR)] {
            let (name, decoding) = map;
            let cache = tempfile::tempdir().expect("a folder");
            let decoded = MapStore::new(NO_FOLDER).get_decoded(name, decoding).expect("a map");
            let first = read(cache.path(), map);
            assert!(*first == *decoded && in_memory(&first).len() == decoded.levels.len(), "{name}");
            let second = read(cache.path(), map);
            assert!(in_memory(&second).is_empty(), "{name}");
            assert!(second.levels[2] == decoded.levels[2]);
            assert_eq!(in_memory(&second), [2], "{name}");
            assert!(*second == *decoded, "{name}");
            assert_eq!(files(cache.path()).len(), 1);
        }
    }

    /// Damage to any part, before the map is opened and after its header was read.
    #[test]
    fn a_damaged_entry_is_decoded_anew_and_replaced() {
        let cache = tempfile::tempdir().expect("a folder");
        let map = ("ceres.jpg", COLOUR);
        let complete = read(cache.path(), map);
        read(cache.path(), ("vesta.jpg", COLOUR));
        let vesta = MapStore::new(NO_FOLDER).get_decoded("vesta.jpg", COLOUR).expect("a map");
        let ceres = key_of(&MapStore::new(NO_FOLDER).encoded("ceres.jpg", COLOUR).expect("a map"));
        let file = &StoredMaps::new(cache.path()).path(&ceres);
        let stored = files(cache.path());
        let other = stored.iter().find(|other| *other != file).expect("Vesta's");
        let intact = std::fs::read(file).expect("stored");
        let with_bit = |at: usize| {
            let mut bytes = intact.clone();
            bytes[at] ^= 1;
            bytes
        };
        // One bit changed: in the magic bytes, the key, width, height, then channels and checksum of level 0, and three times in the texels.
        let mut damaged: Vec<Vec<u8>> = [0, 9, 25, 29, 32, 40, 400, 5000, intact.len() - 1].map(with_bit).to_vec();
        // Cut off in the key and in the last level; empty; one byte too long; the entry of another map.
        damaged.extend([intact[..20].to_vec(), intact[..intact.len() - 4].to_vec(), Vec::new(), [&intact[..], b"x"].concat()]);
        damaged.push(std::fs::read(other).expect("stored"));
        for bytes in &damaged {
            std::fs::write(file, bytes).expect("written");
            let (_, found) = StoredMaps::new(cache.path()).verify();
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(*read(cache.path(), map) == *complete);
            assert!(std::fs::read(file).expect("stored") == intact, "replaced");
            // The file is damaged after it was opened, before each level is read.
            for level in 0..complete.levels.len() {
                let opened = read(cache.path(), map);
                std::fs::write(file, bytes).expect("written");
                assert!(opened.levels[level] == complete.levels[level], "level {level}");
                assert!(*opened == *complete);
                std::fs::write(file, &intact).expect("written");
            }
        }
        let opened = read(cache.path(), map);
        std::fs::remove_file(file).expect("removed");
        assert!(*opened == *complete && std::fs::read(file).expect("stored") == intact);
        assert_eq!(StoredMaps::new(cache.path()).verify(), (2, Vec::new()));
        // Entries are really read: a valid entry with the levels of another map changes the map.
        let key = map_entry::key_if_intact(&intact).expect("intact");
        std::fs::write(file, map_entry::encode(&key, &vesta.levels).expect("a chain")).expect("written");
        assert!(*read(cache.path(), map) == *vesta);
    }

    /// Each of these changes the key: a user's map with the name of a shipped one, another decoding, and another state of the source code.
    #[test]
    fn another_file_or_decoding_has_its_own_entry() {
        let (cache, folder) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        let shipped = read(cache.path(), ("ceres.jpg", COLOUR));
        assert!(*read(cache.path(), ("ceres.jpg", NORMALS)) != *shipped);
        assert_eq!(files(cache.path()).len(), 2);
        let vesta = orrery_textures::MAPS.iter().find(|(name, _)| *name == "vesta.jpg").expect("shipped").1;
        std::fs::write(folder.path().join("ceres.jpg"), vesta).expect("written");
        let own = MapStore::new(Some(folder.path().to_owned())).with_disk_cache(Some(StoredMaps::new(cache.path())));
        assert!(own.get_decoded("ceres.jpg", COLOUR).expect("a map").levels == read(cache.path(), ("vesta.jpg", COLOUR)).levels);
        assert_eq!(files(cache.path()).len(), 3, "Vesta's entry serves both names");
        // The limit of megapixels holds for stored maps as well: 512 x 256 texels are less than one.
        let small = MapStore::with_limit(Some(folder.path().to_owned()), 0).with_disk_cache(Some(StoredMaps::new(cache.path())));
        assert!(matches!(small.get_decoded("ceres.jpg", COLOUR), Err(ImageError::TooLarge { .. })));
        let mut edited = SOURCES;
        edited[2] = "// edited";
        assert_ne!(code_digest(&edited), code_digest(&SOURCES));
        for name in DECODERS {
            assert!(locked_package(name).is_some_and(|block| block.contains("version = ")), "{name}");
        }
    }

    #[test]
    fn entries_of_other_versions_and_then_the_oldest_make_room() {
        let cache = tempfile::tempdir().expect("a folder");
        let store = Arc::new(StoredMaps { budget_bytes: 1_200_000, ..StoredMaps::new(cache.path()) });
        let maps = MapStore::new(NO_FOLDER);
        let texture = |name: &str| store.texture(maps.encoded(name, COLOUR).expect("a map")).expect("a map");
        // Ceres and Pluto take 0.52 MB each, Vesta, which is grey, 0.18. The budget of 1.2 MB holds any two of them, but not all three, and not
        // Ceres and Vesta with the foreign entry of 0.6 MB.
        texture("ceres.jpg");
        let first = files(cache.path());
        std::fs::write(store.folder.join("0123456789abcdef-0.levels"), vec![0; 600_000]).expect("written");
        std::fs::write(store.folder.join("notes.txt"), vec![0; 900_000]).expect("written");
        assert_eq!((store.status().entries, store.status().other_entries), (1, 1));
        texture("vesta.jpg");
        assert_eq!((store.status().entries, store.status().other_entries), (2, 0));
        // The oldest by its time, whatever the order of names.
        let old = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1_000_000);
        std::fs::File::options().write(true).open(&first[0]).and_then(|file| file.set_modified(old)).expect("a time");
        texture("pluto.jpg");
        assert_eq!(store.status().entries, 2);
        assert!(!first[0].exists() && store.status().bytes <= 1_200_000);
        assert_eq!((store.clear().expect("cleared"), store.status()), (2, StoredMapsStatus::default()));
        assert!(store.folder.join("notes.txt").exists(), "not an entry");
    }

    /// The folder cannot be created, because a file is in its place.
    #[test]
    fn a_folder_that_cannot_be_written_is_ignored() {
        let cache = tempfile::NamedTempFile::new().expect("a file");
        let decoded = MapStore::new(NO_FOLDER).get_decoded("ceres.jpg", COLOUR).expect("a map");
        assert!(*read(cache.path(), ("ceres.jpg", COLOUR)) == *decoded);
        assert_eq!(StoredMaps::new(cache.path()).status(), StoredMapsStatus::default());
    }
}
