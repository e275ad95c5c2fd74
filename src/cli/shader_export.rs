//! `orrery shader atlas` and `orrery shader corpus`: export modules as a static site, and as test cases for other WGSL executors.
//!
//! In: options that select keys, and the output folder. Out: the files of `export::atlas` or `export::corpus`, in a folder that holds nothing else. Always: an
//! interrupted export is recognised by its manifest and can be repeated.

use super::inputs::{fragments, lowering, reachable_keys};
use super::output::{print_message, print_result, progress};
use super::view_args::parse_time_option;
use super::{CliError, Common};
use crate::export::{Revision, atlas, corpus};
use crate::files::read_bytes;
use crate::scene::draw::PixelView;
use crate::scene::request::ViewRequest;
use crate::session::Session;
use crate::shader::ModuleId;
use crate::shader::id::SIMPLE_MODULES;
use crate::shader::key::{self, ShaderKey, covering_keys};
use crate::wording::{counted, echo};
use std::collections::BTreeSet;
use std::path::Path;

/// The keys of every draw in the default view of a body.
pub(crate) fn keys_of_default_view(common: &Common, body: &str, time: &str) -> Result<Vec<ShaderKey>, CliError> {
    let session = Session::open(&common.sources(), print_message)?;
    let id = session.catalog().body_named(body).map_err(|e| CliError::Usage(format!("--for: {e}")))?.id;
    let time = parse_time_option(time)?;
    let scene = session.scene(&ViewRequest { quality: common.quality, ..ViewRequest::of(id, time) })?;
    Ok(key::keys_of(scene.draws.iter().map(|d| d.features)).into_iter().collect())
}

/// Which keys to export, and whether to replace an earlier export.
#[derive(clap::Args, Debug)]
pub(crate) struct ExportOptions {
    /// A set of keys in which every combination of the values of any N dimensions occurs (N is 2 or 3) [default: 2; an atlas also has all reachable keys]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(2..=3))]
    covering: Option<u8>,
    /// Only the keys of the default view of this body
    #[arg(long = "for", value_name = "BODY", conflicts_with = "covering")]
    body: Option<String>,
    /// Time: ISO 8601 UTC, jd_tdb:DAY, or now
    #[arg(long, value_name = "T", requires = "body", conflicts_with = "covering", allow_hyphen_values = true)]
    time: Option<String>,
    /// Replace an earlier export in the folder
    #[arg(long)]
    overwrite: bool,
}

impl ExportOptions {
    /// The selected keys; `default_keys` if no option selects keys.
    fn keys(&self, common: &Common, default_keys: impl FnOnce() -> Result<Vec<ShaderKey>, CliError>) -> Result<Vec<ShaderKey>, CliError> {
        match (self.covering, &self.body) {
            (Some(strength), _) => Ok(covering_keys(usize::from(strength))),
            (None, Some(body)) => keys_of_default_view(common, body, self.time.as_deref().unwrap_or("now")),
            (None, None) => default_keys(),
        }
    }
}

/// Number of dimensions whose combinations of values the default covering set contains.
const DEFAULT_STRENGTH: usize = 2;

/// Largest manifest, bytes; a longer one was not written by this program.
const MAX_MANIFEST_BYTES: u64 = 1 << 28;

/// The layout of the folder of one kind of export.
struct ExportLayout {
    /// The kind, as error messages name it.
    kind: &'static str,
    /// File name of the manifest.
    manifest: &'static str,
    /// The manifest's field that lists the exported modules; an earlier export is recognised by it.
    list_field: &'static str,
    /// Subfolders of an earlier export. They are removed before a new one is written.
    subfolders: [&'static str; 2],
}

const ATLAS: ExportLayout =
    ExportLayout { kind: "an atlas", manifest: atlas::MANIFEST, list_field: "modules", subfolders: ["pages", "pictures"] };
const CORPUS: ExportLayout =
    ExportLayout { kind: "a corpus", manifest: corpus::MANIFEST, list_field: "cases", subfolders: ["cases", "data"] };

/// Prepares an output folder. It must be new or empty, or hold an unfinished export of this kind. With `--overwrite` it may hold a complete one.
///
/// The function writes the manifest of an unfinished export, whose list is empty. If the export is interrupted, this manifest remains, and the export can be
/// repeated. Subfolders of an earlier export are removed, because an export of other keys would leave their files behind.
fn prepare_folder(folder: &Path, layout: &ExportLayout, overwrite: bool) -> Result<(), CliError> {
    let kind = layout.kind;
    let quoted_folder = echo(&folder.display().to_string());
    let failed = |e: std::io::Error| CliError::Failed(format!("{quoted_folder}: {e}"));
    let unfinished = serde_json::json!({ "revision": "unfinished", layout.list_field: [] });
    // Called before any file is removed or written, because a manifest whose list is not empty marks a complete export.
    let mark_unfinished = || std::fs::write(folder.join(layout.manifest), unfinished.to_string()).map_err(failed);
    if folder.exists() {
        let is_empty = std::fs::read_dir(folder).map_err(failed)?.next().is_none();
        let manifest = read_bytes(&folder.join(layout.manifest), MAX_MANIFEST_BYTES).ok();
        let manifest = manifest.and_then(|bytes| serde_json::from_slice::<serde_json::Value>(&bytes).ok());
        let is_unfinished = manifest.as_ref() == Some(&unfinished);
        let is_export_of_kind = manifest.is_some_and(|m| m["revision"].is_string() && m[layout.list_field].is_array());
        match (is_empty, is_export_of_kind, overwrite || is_unfinished) {
            (true, _, _) => {}
            (false, true, true) => {
                mark_unfinished()?;
                for subfolder in layout.subfolders.map(|name| folder.join(name)).iter().filter(|path| path.is_dir()) {
                    std::fs::remove_dir_all(subfolder).map_err(failed)?;
                }
            }
            (false, true, false) => return Err(CliError::Failed(format!("{quoted_folder} holds {kind} already; --overwrite replaces it"))),
            (false, false, _) => return Err(CliError::Failed(format!("{quoted_folder} holds other files: name a new folder for {kind}"))),
        }
    }
    std::fs::create_dir_all(folder).map_err(failed)?;
    mark_unfinished()
}

/// The revision to export: the built-in fragments with those of `--shaders` and `--surface`. It is named after the folder of `--shaders`, if given.
fn revision(common: &Common) -> Result<Revision, CliError> {
    let fragments = fragments(common)?;
    let name = common.shaders.as_ref().map(|folder| folder.display().to_string());
    Ok(if fragments.are_built_in() {
        Revision::built_in()
    } else {
        Revision::of_fragments(&name.unwrap_or_else(|| "edited".into()), fragments)
    })
}

pub(crate) fn atlas(common: &Common, folder: &Path, options: &ExportOptions) -> Result<(), CliError> {
    let keys = options.keys(common, || {
        Ok(reachable_keys(common)?.union(&covering_keys(DEFAULT_STRENGTH).into_iter().collect::<BTreeSet<_>>()).copied().collect())
    })?;
    let mut ids: Vec<ModuleId> = keys.into_iter().map(ModuleId::Keyed).collect();
    if options.body.is_none() {
        ids.extend(SIMPLE_MODULES.iter().map(|name| ModuleId::Simple(name)));
    }
    // Read before the folder is emptied, because `--shaders` may be wrong.
    let revision = revision(common)?;
    prepare_folder(folder, &ATLAS, options.overwrite)?;
    let bar = progress(ids.len() as u64);
    let written = atlas::write(folder, &revision, &ids, &lowering(), || bar.inc(1));
    bar.finish_and_clear();
    let modules = written.map_err(|e| CliError::Failed(echo(&e.to_string())))?;
    let index = folder.join("index.html").display().to_string();
    print_result(&format!("{} written; open {}\n", counted(modules.len(), "module"), echo(&index)))
}

pub(crate) fn corpus(common: &Common, folder: &Path, options: &ExportOptions) -> Result<(), CliError> {
    let keys = options.keys(common, || Ok(covering_keys(DEFAULT_STRENGTH)))?;
    // Keys of the pixel view `cost` are left out: their pixels count the software renderer's operations, which another implementation cannot reproduce.
    let keys: Vec<ShaderKey> = keys.into_iter().filter(|k| k.features().view != PixelView::Cost).collect();
    let revision = revision(common)?;
    prepare_folder(folder, &CORPUS, options.overwrite)?;
    let bar = progress(keys.len() as u64);
    let written = corpus::write(folder, &revision, &keys, &lowering(), || bar.inc(1));
    bar.finish_and_clear();
    let cases = written.map_err(|e| CliError::Failed(echo(&e.to_string())))?;
    print_result(&format!(
        "{} written to {}; docs/corpus.md describes the files\n",
        counted(cases, "case"),
        echo(&folder.display().to_string())
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An interrupted export must not pass for a complete one.
    #[test]
    fn an_export_to_replace_is_unfinished_and_can_be_replaced_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let manifest = folder.path().join(CORPUS.manifest);
        let [keep, overwrite] = [false, true];
        std::fs::create_dir(folder.path().join("cases")).expect("made");
        std::fs::write(&manifest, r#"{"revision":"built-in","cases":["a"]}"#).expect("written");
        assert!(prepare_folder(folder.path(), &CORPUS, keep).is_err() && manifest.exists());
        // The second time, the first export counts as interrupted.
        for _ in 0..2 {
            prepare_folder(folder.path(), &CORPUS, overwrite).expect("prepared");
            let manifest: serde_json::Value = serde_json::from_slice(&std::fs::read(&manifest).expect("a manifest")).expect("JSON");
            assert_eq!(manifest["cases"], serde_json::json!([]));
            assert!(!folder.path().join("cases").exists());
            std::fs::create_dir(folder.path().join("cases")).expect("made");
        }
    }

    /// An interrupted export leaves files, but its manifest lists none.
    #[test]
    fn an_interrupted_first_export_can_be_repeated() {
        let parent = tempfile::tempdir().expect("a folder");
        let folder = parent.path().join("corpus");
        for overwrite in [false, false, true] {
            prepare_folder(&folder, &CORPUS, overwrite).expect("prepared");
            assert!(!folder.join("data").exists());
            std::fs::create_dir(folder.join("data")).expect("made");
            std::fs::write(folder.join("data/a.bin"), "a").expect("written");
        }
        // A folder of other files stays refused.
        std::fs::remove_file(folder.join(CORPUS.manifest)).expect("removed");
        assert!(prepare_folder(&folder, &CORPUS, true).is_err() && folder.join("data/a.bin").exists());
    }
}
