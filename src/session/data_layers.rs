//! Reads the files of data layers (the user's points, lines or image on a body or in the sky), and adds their images to the map store.
//!
//! In: a layer of the catalog, or a file that was dropped on the window. Out: the layer with its content, or an error in one line. Always: an invalid file
//! adds nothing.

use super::{Session, SessionError};
use crate::catalog::{Catalog, CatalogError, DataLayer, NaifId, is_layer_file, layer_extensions};
use crate::files::read_bytes;
use crate::image::{ImageError, MapStore, TexelFormat, Texture};
use crate::wording::{counted, echo};
use std::path::Path;

/// Largest file of a data layer, bytes: enough for a million positions, the most that a layer may have.
const MAX_DATA_BYTES: u64 = 1 << 28;

fn file_error(path: &Path, why: String) -> SessionError {
    SessionError::File { path: echo(&path.display().to_string()), why }
}

/// Fills the layer with the content of a file.
pub(super) fn read(path: &Path, layer: DataLayer) -> Result<DataLayer, SessionError> {
    let bytes = read_bytes(path, MAX_DATA_BYTES).map_err(|e| file_error(path, e.to_string()))?;
    layer.with_content(&path.display().to_string(), &bytes).map_err(|problem| CatalogError { problems: vec![problem] }.into())
}

fn add_image(layer: &DataLayer, maps: &MapStore) -> Result<(), ImageError> {
    let Some(image) = &layer.image else { return Ok(()) };
    let texture = Texture::from_rgba8(image.width, image.height, image.rgba.clone(), TexelFormat::Rgba8Srgb)?;
    maps.insert_premultiplied(&layer.image_name(), texture.premultiplied());
    Ok(())
}

/// Adds the images of all layers to the map store.
pub(super) fn add_images(catalog: &Catalog, maps: &MapStore) -> Result<(), SessionError> {
    catalog
        .data_layers()
        .iter()
        .try_for_each(|layer| add_image(layer, maps).map_err(|e| SessionError::File { path: echo(&layer.file), why: e.to_string() }))
}

impl Session {
    /// Adds the content of a file as a layer: on the given body if the file has places on a body, otherwise in the sky. Returns a line that describes the
    /// layer.
    ///
    /// # Errors
    /// The name is not that of a data layer, the file cannot be read, its content is invalid (the message names file, line and field), or it is an image for a
    /// body. An error adds nothing.
    pub fn add_data_file(&self, path: &Path, body: Option<NaifId>) -> Result<String, SessionError> {
        let file = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if !is_layer_file(&file) {
            return Err(file_error(path, format!("not a data layer: its name does not end in any of {}", layer_extensions())));
        }
        // The file's name is also the layer's name. `body`: `None` in the sky.
        let layer = |body| DataLayer { body, ..DataLayer::new(file.clone(), file.clone()) };
        let body = body.and_then(|id| self.catalog.body(id));
        // If the file is valid neither on the body nor in the sky, the error for the body is returned.
        let on_body = body.map(|b| read(path, layer(Some(b.id))));
        let loaded = match on_body {
            Some(Ok(layer)) => layer,
            Some(Err(why)) => read(path, layer(None)).map_err(|_| why)?,
            None => read(path, layer(None))?,
        };
        let body_of_layer = loaded.body.and(body);
        if let (Some(_), Some(body)) = (&loaded.image, body_of_layer) {
            let why = format!("to lay an image over {}, add a [[layer]] to a catalog file (--catalogs)", body.name);
            return Err(file_error(path, why));
        }
        add_image(&loaded, &self.maps).map_err(|e| file_error(path, e.to_string()))?;
        let what = match &loaded.image {
            Some(image) => format!("an image of {}x{} pixels", image.width, image.height),
            None => format!("{} and {}", counted(loaded.points.len(), "point"), counted(loaded.lines.len(), "line")),
        };
        let place = body_of_layer.map_or("in the sky".to_owned(), |b| format!("on {}", b.name));
        self.catalog.add_data_layer(loaded);
        Ok(format!("{file}: {what} {place}"))
    }
}
