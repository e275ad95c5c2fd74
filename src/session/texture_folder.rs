//! Which files of the folder of `--textures` are used: a map replaces an embedded one only if it has the same name, so a misspelt name does nothing.
//!
//! In: the folder and the catalog. Out: the images whose names no body uses. Not here: other files, and files in folders below; nothing is decoded.

use crate::catalog::Catalog;
use crate::files::{is_same_file, is_there};
use crate::wording::{did_you_mean, echo};
use std::path::Path;

/// Extensions of images that maps can be.
const IMAGE_EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "exr"];
/// Most names that a message lists.
const MAX_NAMES: usize = 5;

/// What a folder of maps holds.
pub(crate) struct TextureFolder {
    /// Whether some body, cloud map, overlay, shape model or data layer uses a file of the folder.
    pub is_used: bool,
    /// Names of images that nothing uses, in order.
    pub unused_images: Vec<String>,
}

/// The names of all files in folders of maps that the catalog uses.
fn used_names(catalog: &Catalog) -> Vec<String> {
    let mut names: Vec<String> = catalog.data_layers().iter().map(|layer| layer.file.clone()).collect();
    for body in catalog.bodies() {
        let maps = [&body.maps.albedo, &body.maps.normal, &body.maps.specular, &body.maps.night].into_iter().flatten();
        let maps = maps.chain(body.clouds.as_ref().map(|clouds| &clouds.map)).map(|map| map.file.clone());
        names.extend(maps.chain(body.overlays.iter().map(|overlay| overlay.file.clone())));
        names.extend(body.mesh.iter().map(|mesh| mesh.file.clone()));
    }
    names
}

impl TextureFolder {
    pub(crate) fn of(folder: &Path, catalog: &Catalog) -> Self {
        let used = used_names(catalog);
        // A file system may ignore the case of names.
        let is_used = |name: &str| {
            used.iter()
                .any(|known| *known == name || (known.eq_ignore_ascii_case(name) && is_same_file(&folder.join(known), &folder.join(name))))
        };
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).filter(|path| path.is_file());
        let is_image = |path: &Path| {
            path.extension().is_some_and(|extension| IMAGE_EXTENSIONS.iter().any(|known| extension.eq_ignore_ascii_case(known)))
        };
        let names = files.filter(|path| is_image(path)).filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
        let mut unused_images: Vec<String> = names.filter(|name| !is_used(name)).collect();
        unused_images.sort();
        Self { is_used: used.iter().any(|name| is_there(&folder.join(name))), unused_images }
    }

    /// A list of the unused images, the first with a suggestion if a map has a similar name; `None` if there are none.
    pub(crate) fn unused_text(&self, catalog: &Catalog) -> Option<String> {
        let first = self.unused_images.first()?;
        let mut listed: Vec<String> = self.unused_images.iter().take(MAX_NAMES).map(|name| echo(name)).collect();
        if self.unused_images.len() > MAX_NAMES {
            listed.push("...".to_owned());
        }
        let hint = did_you_mean(first, used_names(catalog).iter().map(String::as_str)).map_or(String::new(), |hint| format!("; {hint}"));
        Some(format!("no map has the name {}{hint}", listed.join(", ")))
    }
}
