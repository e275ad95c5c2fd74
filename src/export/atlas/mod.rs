//! The atlas: a static site with a page for each module that shows its image, features, cost, source by feature, and neighbouring modules.
//!
//! In: a revision and module ids. Out: `index.html`, a page for each module, an image for each module that draws a body, `lines.js`, `atlas.js`,
//! `atlas.css`, `manifest.json`. Always: the site works from the local disk without server or network; the same modules give the same bytes. Each distinct
//! source line is stored once for all pages, because modules share most of their lines: full copies of all modules would take a gigabyte.

mod lines;
mod neighbours;
mod page;

use super::report::{Figures, figures};
use super::revision::{Revision, RevisionError};
use super::sample_image::{SampleBodyRenderer, SampleImage, map_with_renderers};
use crate::files::{FileAccess, WriteError, write_atomic};
use crate::image::write_png;
use crate::session::SessionError;
use crate::shader::library::file_stem;
use crate::shader::{Lowering, ModuleId, ShaderModule};
use lines::LineTable;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Side of a module's image, pixels. The list shows it at this size, a module's page twice as large.
const IMAGE_SIDE_PX: u32 = 96;
/// How many modules are in memory at a time.
const MODULES_PER_CHUNK: usize = 128;
/// File name of the list of all modules, which identifies a folder as an atlas.
pub(crate) const MANIFEST: &str = "manifest.json";

/// Why an atlas was not written.
#[derive(Debug, thiserror::Error)]
pub enum AtlasError {
    #[error(transparent)]
    Session(#[from] SessionError),
    #[error(transparent)]
    Revision(#[from] RevisionError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("{module}: {why}")]
    Module { module: String, why: String },
}

/// A module as the manifest lists it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ListedModule {
    /// Key, or name of a simple module.
    #[serde(rename = "module")]
    pub name: String,
    /// Path of the module's page below the atlas folder: `pages/`, the stem of the module's files, and `.html`. The image of the same stem is in `pictures/`.
    pub page: String,
    /// Whether the module draws a body.
    pub has_image: bool,
    /// Features to which the module's lines belong.
    pub features: Vec<String>,
    /// Number of lines of the module's WGSL.
    pub lines: usize,
    /// Cost, and statistics of the image.
    pub figures: Figures,
}

/// One module with its figures and its image, before its page is written.
struct RenderedModule {
    module: Arc<ShaderModule>,
    figures: Figures,
    /// The sample body drawn by the module; `None` if the module draws no body.
    image: Option<SampleImage>,
}

/// Reads a module from the revision, draws the sample body with it, and computes the figures of both.
fn render_module(
    renderer: &SampleBodyRenderer,
    revision: &Revision,
    id: &ModuleId,
    lowering: &Lowering,
) -> Result<RenderedModule, AtlasError> {
    let failed = |why: String| AtlasError::Module { module: id.to_string(), why };
    let module = Arc::new(revision.module(id, lowering)?.ok_or_else(|| failed("not in the library".into()))?);
    let image = match id {
        ModuleId::Keyed(key) => Some(renderer.draw(&module, key)?),
        _ => None,
    };
    let figures = figures(&module, image.as_ref()).map_err(failed)?;
    Ok(RenderedModule { module, figures, image })
}

/// Writes a file, or replaces it.
fn write_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_atomic(path, FileAccess::All, |out| out.write_all(bytes))
}

/// Writes the atlas of these modules into a folder, and returns the modules as the manifest lists them. `on_module_done` is called after each module is drawn,
/// from any thread.
///
/// # Errors
/// A module that cannot be compiled, or a file that cannot be written.
pub fn write(
    folder: &Path,
    revision: &Revision,
    ids: &[ModuleId],
    lowering: &Lowering,
    on_module_done: impl Fn() + Sync,
) -> Result<Vec<ListedModule>, AtlasError> {
    for name in ["pages", "pictures"] {
        let subfolder = folder.join(name);
        std::fs::create_dir_all(&subfolder).map_err(|e| crate::files::write_error(&subfolder, &e))?;
    }
    let stems_by_name: BTreeMap<String, String> = ids.iter().map(|id| (id.to_string(), file_stem(id))).collect();
    let neighbours_of = neighbours::find(stems_by_name.keys().map(String::as_str));
    let mut table = LineTable::default();
    let mut listed_modules = Vec::new();
    for chunk in ids.chunks(MODULES_PER_CHUNK) {
        let render = |renderer: &SampleBodyRenderer, id: &ModuleId| render_module(renderer, revision, id, lowering);
        let renderer_error = |id: &ModuleId, e: &SessionError| AtlasError::Module { module: id.to_string(), why: e.to_string() };
        let results = map_with_renderers(IMAGE_SIDE_PX, chunk, render, renderer_error, &on_module_done);
        for (id, result) in chunk.iter().zip(results) {
            let RenderedModule { module, figures, image } = result?;
            let name = id.to_string();
            let stem = &stems_by_name[&name];
            let shows_cost = matches!(id, ModuleId::Keyed(key) if key.instructions_per_read().is_some());
            if let Some(sample) = &image {
                let mut png = Vec::new();
                write_png(&mut png, sample.side_px, sample.side_px, &sample.display(shows_cost), &[("Shader", &name)])
                    .map_err(|e| AtlasError::Module { module: name.clone(), why: e.to_string() })?;
                write_file(&folder.join("pictures").join(format!("{stem}.png")), &png)?;
            }
            let runs = table.add(&module.wgsl, &module.source_map);
            let listed_module = ListedModule {
                page: format!("pages/{stem}.html"),
                has_image: image.is_some(),
                features: module.source_map.features.clone(),
                lines: module.wgsl.lines().count(),
                figures,
                name: name.clone(),
            };
            let neighbours = neighbours_of.get(name.as_str()).map(Vec::as_slice).unwrap_or_default();
            let neighbour_links: Vec<(String, &str)> =
                neighbours.iter().map(|n| (n.change.clone(), stems_by_name[n.key].as_str())).collect();
            write_file(&folder.join(&listed_module.page), page::module_page(&listed_module, stem, &runs, &neighbour_links).as_bytes())?;
            listed_modules.push(listed_module);
        }
    }
    write_file(&folder.join("lines.js"), table.script().as_bytes())?;
    write_file(&folder.join("atlas.js"), include_bytes!("atlas.js"))?;
    write_file(&folder.join("atlas.css"), include_bytes!("atlas.css"))?;
    write_file(&folder.join("index.html"), page::index_page(&revision.name, &listed_modules).as_bytes())?;
    // The manifest is written last, so that a folder whose manifest lists modules is complete.
    let manifest = serde_json::json!({ "revision": revision.name, "modules": listed_modules });
    write_file(&folder.join(MANIFEST), manifest.to_string().as_bytes())?;
    Ok(listed_modules)
}
