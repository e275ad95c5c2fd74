//! The maps of bodies, by file name. A map in the user's folder takes precedence over an embedded one of the same name; each is decoded when first needed.
//!
//! In: names of maps and how they are decoded. Out: their texels and mip levels. Always: when the decoded maps exceed [`MEMORY_BUDGET_BYTES`], the next use of
//! any map drops those that no view has used for [`MIN_IDLE`], the least recently used first. So a tour of all bodies does not fill the memory. Textures that
//! other code has inserted are kept. With a disk cache ([`StoredMaps`]), decoded maps are also kept in a folder: later runs of the program do not decode them
//! again, and read only the levels that they need.

use super::encoded_map::EncodedMap;
use super::map_decoding::MapDecoding;
use super::mip_level::Level;
use super::mips::RowThreads;
use super::stored_maps::StoredMaps;
use super::{DEFAULT_MAX_MEGAPIXELS, ImageError, MAX_FILE_BYTES, SharedTexture, TexelFormat, Texture};
use crate::files::{check_inside, is_there, read_bytes};
use orrery_textures::MAPS;
use parking_lot::Mutex;
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Bytes of decoded maps above which unused ones are dropped: almost six maps of 2048x1024 with their mip levels.
const MEMORY_BUDGET_BYTES: usize = 64 << 20;
/// A map that was used within this time is not dropped: the next frame will probably use it again.
const MIN_IDLE: Duration = Duration::from_secs(5);

/// Where the map of a given name would be read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MapOrigin {
    /// The file in the user's folder, or whatever has its name there: reading it may fail.
    Folder(PathBuf),
    /// A map that is embedded in the program.
    Embedded,
    /// No file has this name.
    Missing,
}

/// How images with alpha (overlays on a body's ground) are decoded. Their colours are multiplied by alpha afterwards.
const OVERLAY_DECODING: MapDecoding = MapDecoding::plain(TexelFormat::Rgba8Srgb);

/// A decoded map in memory.
#[derive(Debug)]
struct CachedMap {
    texture: SharedTexture,
    /// `None`: not read from a file, so it cannot be read again and is never dropped.
    last_used: Option<Instant>,
}

/// Memory that the texels take now. Levels from the disk cache take none before they are first needed.
fn bytes_in_memory(texture: &Texture) -> usize {
    texture.levels.iter().map(Level::bytes_in_memory).sum()
}

/// Drops maps that were not used for [`MIN_IDLE`], the least recently used first, until the others fit into the budget.
fn evict(decoded: &mut HashMap<(String, MapDecoding), CachedMap>, now: Instant) {
    let mut total_bytes: usize = decoded.values().map(|map| bytes_in_memory(&map.texture)).sum();
    if total_bytes <= MEMORY_BUDGET_BYTES {
        return;
    }
    // `None`: recently used, or never dropped.
    let idle_since = |map: &CachedMap| map.last_used.filter(|used| now.saturating_duration_since(*used) >= MIN_IDLE);
    let mut oldest: Vec<_> = decoded.iter().filter_map(|(key, map)| Some((idle_since(map)?, key.clone()))).collect();
    oldest.sort_by_key(|(used, _)| *used);
    for (_, key) in oldest {
        if total_bytes <= MEMORY_BUDGET_BYTES {
            break;
        }
        total_bytes -= decoded.remove(&key).map_or(0, |map| bytes_in_memory(&map.texture));
    }
}

/// All maps by file name.
#[derive(Debug)]
pub struct MapStore {
    /// The user's folder of maps, if any.
    folder: Option<PathBuf>,
    /// Limit on the size of maps in that folder.
    max_megapixels: u32,
    /// Decoded maps in memory, by name and decoding.
    decoded: Mutex<HashMap<(String, MapDecoding), CachedMap>>,
    /// Images with premultiplied alpha, by name; never dropped.
    premultiplied: Mutex<HashMap<String, SharedTexture>>,
    /// The folder of decoded maps on disk; `None`: they are kept in memory alone.
    disk_cache: Option<Arc<StoredMaps>>,
}

impl MapStore {
    /// Maps of `folder` take precedence over embedded ones of the same name.
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self::with_limit(folder, DEFAULT_MAX_MEGAPIXELS)
    }

    /// As [`Self::new`], with a limit on the megapixels of maps in the folder.
    pub(crate) fn with_limit(folder: Option<PathBuf>, max_megapixels: u32) -> Self {
        Self { folder, max_megapixels, decoded: Mutex::default(), premultiplied: Mutex::default(), disk_cache: None }
    }

    /// Keeps decoded maps on disk from now on, and reads those that are there.
    #[must_use]
    pub fn with_disk_cache(self, disk_cache: Option<StoredMaps>) -> Self {
        Self { disk_cache: disk_cache.map(Arc::new), ..self }
    }

    /// Names and sizes in bytes of the embedded maps.
    pub fn embedded() -> impl Iterator<Item = (&'static str, usize)> {
        MAPS.iter().map(|(name, bytes)| (*name, bytes.len()))
    }

    /// Where `name` would be read from, without reading it.
    pub fn origin(&self, name: &str) -> MapOrigin {
        if let Some(path) = self.folder.as_ref().map(|f| f.join(name)).filter(|p| is_there(p)) {
            return MapOrigin::Folder(path);
        }
        if MAPS.iter().any(|(n, _)| *n == name) { MapOrigin::Embedded } else { MapOrigin::Missing }
    }

    /// The map with its mip chain, decoded without a filter at the poles. Colour maps are [`TexelFormat::Rgba8Srgb`]; normal and specular maps
    /// [`TexelFormat::Rgba8Unorm`].
    pub fn get(&self, name: &str, format: TexelFormat) -> Result<SharedTexture, ImageError> {
        self.get_decoded(name, MapDecoding::plain(format))
    }

    /// The map with its mip chain, decoded as `decoding` says.
    pub(crate) fn get_decoded(&self, name: &str, decoding: MapDecoding) -> Result<SharedTexture, ImageError> {
        let key = (name.to_owned(), decoding);
        {
            let (mut decoded, now) = (self.decoded.lock(), Instant::now());
            if let Some(found) = decoded.get_mut(&key) {
                // An inserted texture keeps its `None`.
                found.last_used = found.last_used.map(|_| now);
                let texture = found.texture.clone();
                evict(&mut decoded, now);
                return Ok(texture);
            }
        }
        let texture = Arc::new(self.read(name, decoding)?);
        let mut decoded = self.decoded.lock();
        let now = Instant::now();
        evict(&mut decoded, now);
        Ok(decoded.entry(key).or_insert(CachedMap { texture, last_used: Some(now) }).texture.clone())
    }

    /// A colour image whose texels are multiplied by their alpha, in linear light.
    pub(crate) fn premultiplied(&self, name: &str) -> Result<SharedTexture, ImageError> {
        if let Some(found) = self.premultiplied.lock().get(name) {
            return Ok(found.clone());
        }
        let texture = Arc::new(self.encoded(name, OVERLAY_DECODING)?.decode(RowThreads::All)?.premultiplied());
        Ok(self.premultiplied.lock().entry(name.to_owned()).or_insert(texture).clone())
    }

    /// Adds a texture that was created elsewhere, under a name that no file has.
    pub(crate) fn insert(&self, name: &str, decoding: MapDecoding, texture: Texture) {
        self.decoded.lock().insert((name.to_owned(), decoding), CachedMap { texture: Arc::new(texture), last_used: None });
    }

    /// Adds an image with premultiplied alpha under a name that no file has.
    pub(crate) fn insert_premultiplied(&self, name: &str, texture: Texture) {
        self.premultiplied.lock().insert(name.to_owned(), Arc::new(texture));
    }

    /// Decodes in parallel the maps that are not in memory yet. An error is ignored here: the next request for the map returns it.
    pub fn prefetch(&self, requested: &[(&str, MapDecoding)]) {
        let missing: Vec<&(&str, MapDecoding)> = {
            let decoded = self.decoded.lock();
            requested.iter().filter(|(name, decoding)| !decoded.contains_key(&((*name).to_owned(), *decoding))).collect()
        };
        missing.into_par_iter().for_each(|(name, decoding)| drop(self.get_decoded(name, *decoding)));
    }

    /// The file of a map: that in the user's folder, or else the embedded one.
    pub(super) fn encoded(&self, name: &str, decoding: MapDecoding) -> Result<EncodedMap, ImageError> {
        match self.origin(name) {
            MapOrigin::Folder(path) => {
                let name = path.display().to_string();
                let folder = self.folder.as_deref().unwrap_or(Path::new(""));
                let bytes = check_inside(folder, &path).and_then(|()| read_bytes(&path, MAX_FILE_BYTES));
                let bytes = bytes.map_err(|e| ImageError::Unreadable { name: name.clone(), reason: e.to_string() })?;
                Ok(EncodedMap { name, bytes: bytes.into(), decoding, max_megapixels: self.max_megapixels })
            }
            MapOrigin::Embedded => {
                let bytes = MAPS.iter().find(|(n, _)| *n == name).map_or(&[][..], |(_, b)| b);
                Ok(EncodedMap { name: name.to_owned(), bytes: bytes.into(), decoding, max_megapixels: DEFAULT_MAX_MEGAPIXELS })
            }
            MapOrigin::Missing => {
                let searched = self.folder.as_ref().map_or(String::new(), |f| format!(", nor is it in {}", f.display()));
                Err(ImageError::Missing { name: name.to_owned(), searched })
            }
        }
    }

    /// Decodes a map, or reads the decoded map from the disk cache.
    fn read(&self, name: &str, decoding: MapDecoding) -> Result<Texture, ImageError> {
        let map = self.encoded(name, decoding)?;
        match &self.disk_cache {
            Some(disk_cache) => disk_cache.texture(map),
            None => map.decode(RowThreads::All),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A link to a drive that is not mounted, or a folder, is not a reason to draw the embedded map in place of the user's.
    #[test]
    fn what_stands_in_the_place_of_a_map_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("moon.jpg")).expect("made");
        let store = MapStore::new(Some(folder.path().to_owned()));
        let error_of = |name: &str| store.get(name, TexelFormat::Rgba8Srgb).expect_err(name).to_string();
        let error = error_of("moon.jpg");
        assert!(error.contains(&folder.path().join("moon.jpg").display().to_string()) && error.contains("this is a folder"), "{error}");
        assert_eq!(store.origin("titan.jpg"), MapOrigin::Embedded, "negative control: nothing has this name in the folder");
        assert!(store.get("titan.jpg", TexelFormat::Rgba8Srgb).is_ok());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(folder.path().join("not mounted"), folder.path().join("ariel.jpg")).expect("made");
            let error = error_of("ariel.jpg");
            assert!(error.ends_with("ariel.jpg: not an image that can be read: a link to a file that does not exist"), "{error}");
        }
    }

    #[test]
    fn unused_maps_are_dropped_above_the_budget() {
        let now = Instant::now();
        let after = |seconds| now + Duration::from_secs(seconds);
        let megabytes = |n: usize| Arc::new(Texture { format: TexelFormat::Rgba8Unorm, levels: vec![Level::new(1, 1, vec![0; n << 20])] });
        let decoding = MapDecoding::plain(TexelFormat::Rgba8Unorm);
        let mut decoded = HashMap::new();
        // Until `recent` is used (second 33), it counts as used just now.
        for (name, used) in [("first", Some(after(0))), ("second", Some(after(1))), ("made", None), ("recent", Some(after(33)))] {
            decoded.insert((name.to_owned(), decoding), CachedMap { texture: megabytes(20), last_used: used });
        }
        let names = |decoded: &HashMap<(String, MapDecoding), CachedMap>| {
            let mut names: Vec<String> = decoded.keys().map(|(name, _)| name.clone()).collect();
            names.sort();
            names
        };
        evict(&mut decoded, after(4));
        assert_eq!(names(&decoded).len(), 4, "all were used in the last five seconds");
        evict(&mut decoded, after(35));
        assert_eq!(names(&decoded), ["made", "recent", "second"], "60 MB fit");
        decoded.insert(("large".to_owned(), decoding), CachedMap { texture: megabytes(200), last_used: Some(after(34)) });
        evict(&mut decoded, after(36));
        assert_eq!(names(&decoded), ["large", "made", "recent"], "what is in use, or cannot be read again, stays");
    }
}
