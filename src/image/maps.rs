//! The store of maps: from the user's folder first, then embedded ones. Each is decoded once, when first needed.

use super::{DEFAULT_MAX_MEGAPIXELS, ImageError, MAX_FILE_BYTES, PoleFilter, SharedTexture, TexelFormat, Texture};
use crate::files::{check_inside, read_bytes};
use orrery_textures::MAPS;
use parking_lot::Mutex;
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a map of this name would be read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MapOrigin {
    Folder(PathBuf),
    Embedded,
    Missing,
}

/// How a map's file is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MapDecoding {
    pub format: TexelFormat,
    pub poles: PoleFilter,
}

/// All maps by file name.
#[derive(Debug)]
pub struct MapStore {
    folder: Option<PathBuf>,
    max_megapixels: u32,
    decoded: Mutex<HashMap<(String, MapDecoding), SharedTexture>>,
    premultiplied: Mutex<HashMap<String, SharedTexture>>,
}

impl MapStore {
    /// Maps of `folder` take precedence over embedded ones of the same name.
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self::with_limit(folder, DEFAULT_MAX_MEGAPIXELS)
    }

    /// The same, with a limit on the megapixels of maps in the folder.
    pub(crate) fn with_limit(folder: Option<PathBuf>, max_megapixels: u32) -> Self {
        Self { folder, max_megapixels, decoded: Mutex::default(), premultiplied: Mutex::default() }
    }

    /// Names and sizes in bytes of the embedded maps.
    pub fn embedded() -> impl Iterator<Item = (&'static str, usize)> {
        MAPS.iter().map(|(name, bytes)| (*name, bytes.len()))
    }

    /// Where `name` would be read from, without reading it.
    pub fn origin(&self, name: &str) -> MapOrigin {
        if let Some(path) = self.folder.as_ref().map(|f| f.join(name)).filter(|p| p.is_file()) {
            return MapOrigin::Folder(path);
        }
        if MAPS.iter().any(|(n, _)| *n == name) { MapOrigin::Embedded } else { MapOrigin::Missing }
    }

    /// The texels of the file. Colour maps are [`TexelFormat::Rgba8Srgb`]; normal and water maps [`TexelFormat::Rgba8Unorm`].
    pub fn get(&self, name: &str, format: TexelFormat) -> Result<SharedTexture, ImageError> {
        self.get_decoded(name, MapDecoding { format, poles: PoleFilter::None })
    }

    /// The map with its mip chain, filtered for drawing.
    pub(crate) fn get_decoded(&self, name: &str, decoding: MapDecoding) -> Result<SharedTexture, ImageError> {
        let key = (name.to_owned(), decoding);
        if let Some(found) = self.decoded.lock().get(&key) {
            return Ok(found.clone());
        }
        let texture = Arc::new(self.read(name, decoding)?);
        Ok(self.decoded.lock().entry(key).or_insert(texture).clone())
    }

    /// A colour image whose texels are multiplied by their alpha, in linear light.
    pub(crate) fn premultiplied(&self, name: &str) -> Result<SharedTexture, ImageError> {
        if let Some(found) = self.premultiplied.lock().get(name) {
            return Ok(found.clone());
        }
        let texture = Arc::new(self.read(name, MapDecoding { format: TexelFormat::Rgba8Srgb, poles: PoleFilter::None })?.premultiplied());
        Ok(self.premultiplied.lock().entry(name.to_owned()).or_insert(texture).clone())
    }

    /// Adds a texture that was created elsewhere, under a name that no file has.
    pub(crate) fn keep(&self, name: &str, decoding: MapDecoding, texture: Texture) {
        self.decoded.lock().insert((name.to_owned(), decoding), Arc::new(texture));
    }

    /// The same for an image with premultiplied alpha.
    pub(crate) fn keep_premultiplied(&self, name: &str, texture: Texture) {
        self.premultiplied.lock().insert(name.to_owned(), Arc::new(texture));
    }

    /// Decodes in parallel what is not in memory yet. Errors are reported to whoever gets the map.
    pub fn prefetch(&self, wanted: &[(&str, MapDecoding)]) {
        let away: Vec<&(&str, MapDecoding)> = {
            let decoded = self.decoded.lock();
            wanted.iter().filter(|(name, decoding)| !decoded.contains_key(&((*name).to_owned(), *decoding))).collect()
        };
        away.into_par_iter().for_each(|(name, decoding)| drop(self.get_decoded(name, *decoding)));
    }

    fn read(&self, name: &str, decoding: MapDecoding) -> Result<Texture, ImageError> {
        match self.origin(name) {
            MapOrigin::Folder(path) => {
                let shown = path.display().to_string();
                let folder = self.folder.as_deref().unwrap_or(Path::new(""));
                let bytes = check_inside(folder, &path).and_then(|()| read_bytes(&path, MAX_FILE_BYTES));
                let bytes = bytes.map_err(|e| ImageError::Unreadable { name: shown.clone(), reason: e.to_string() })?;
                Texture::decode_filtered(&shown, &bytes, decoding, self.max_megapixels)
            }
            MapOrigin::Embedded => {
                let bytes = MAPS.iter().find(|(n, _)| *n == name).map_or(&[][..], |(_, b)| b);
                Texture::decode_filtered(name, bytes, decoding, DEFAULT_MAX_MEGAPIXELS)
            }
            MapOrigin::Missing => {
                let searched = self.folder.as_ref().map_or(String::new(), |f| format!(" nor in {}", f.display()));
                Err(ImageError::Missing { name: name.to_owned(), searched })
            }
        }
    }
}
