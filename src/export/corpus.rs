//! The conformance corpus: modules with their inputs, expected outputs and tolerances, for other implementations of WGSL.
//!
//! In: a revision and keys. Out: a folder per key with `module.wgsl` and `case.json`; `data/` with files of binary data that cases share, each
//! named by the first 16 bytes of its SHA-256; the manifest `corpus.json`. Always: the files contain everything that the draw needs; expected
//! outputs are those of the software renderer in f64, rounded to f32; the same modules give the same bytes. Not included: modules that draw no
//! body. docs/corpus.md describes the format.

use super::revision::{Revision, RevisionError};
use super::sample_image::{SampleBodyRenderer, SampleImage, map_with_renderers};
use crate::files::{FileAccess, WriteError, write_atomic, write_error};
use crate::image::{TexelFormat, Texture};
use crate::render::plan::{AddressMode, Attribute, PlanDraw, TextureSource, Vertices};
use crate::session::SessionError;
use crate::shader::generator::hex;
use crate::shader::key::ShaderKey;
use crate::shader::library::file_stem;
use crate::shader::{Lowering, ModuleId, ShaderModule};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Width and height of the image of each case, pixels.
const SIDE_PX: u32 = 48;
/// Number of cases in memory at a time.
const CASES_PER_CHUNK: usize = 64;
/// File name of the list of cases, which identifies a folder as a corpus.
pub const MANIFEST: &str = "corpus.json";
/// Version of the format, incremented on incompatible changes.
pub(crate) const FORMAT: u32 = 1;
/// Largest accepted absolute error of a channel of linear light, where white is 1. The sRGB curve turns it into a fifth of a level of 255 at white, and into 6
/// levels at black. The software renderer in f32 is within this tolerance for each key of the pairwise covering set (tests/render/permutations.rs).
pub(crate) const TOLERANCE: f64 = 1.0 / 512.0;

/// Why a corpus was not written.
#[derive(Debug, thiserror::Error)]
pub enum CorpusError {
    #[error(transparent)]
    Session(#[from] SessionError),
    #[error(transparent)]
    Revision(#[from] RevisionError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("{key}: {why}")]
    Case { key: String, why: String },
}

/// A file of binary data, to which cases refer by its name.
struct Blob {
    /// Path below the corpus folder, from the digest of the bytes.
    name: String,
    bytes: Vec<u8>,
}

impl Blob {
    /// The blob of these bytes. Equal bytes have the same name.
    fn of(bytes: Vec<u8>) -> Self {
        Self { name: format!("data/{}.bin", hex(&Sha256::digest(&bytes)[..16])), bytes }
    }
}

/// A case before it is written.
struct Case {
    /// Path of its folder below that of the corpus.
    folder: String,
    wgsl: String,
    /// Content of `case.json`.
    json: Value,
    /// The binary data to which `json` refers.
    blobs: Vec<Blob>,
}

/// The bytes of f32 values, little-endian.
fn little_endian(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

/// Name of a texel format in WebGPU.
fn format_name(format: TexelFormat) -> &'static str {
    match format {
        TexelFormat::Rgba8Unorm => "rgba8unorm",
        TexelFormat::Rgba8Srgb => "rgba8unorm-srgb",
        TexelFormat::Rgba32Float => "rgba32float",
    }
}

/// Name of an address mode in WebGPU.
fn address_name(mode: AddressMode) -> &'static str {
    match mode {
        AddressMode::Repeat => "repeat",
        AddressMode::ClampToEdge => "clamp-to-edge",
    }
}

/// The description of a texture. Its mip levels, finest first, are in one blob.
fn texture_json(binding: u32, name: &str, texture: &Texture, blobs: &mut Vec<Blob>) -> Value {
    let blob = Blob::of(texture.levels.iter().flat_map(|l| l.bytes().iter().copied()).collect());
    let levels: Vec<[u32; 2]> = texture.levels.iter().map(|l| [l.width, l.height]).collect();
    let value = json!({ "binding": binding, "name": name, "format": format_name(texture.format), "levels": levels, "data": blob.name });
    blobs.push(blob);
    value
}

/// The description of a vertex attribute.
fn attribute_json(location: usize, attribute: &Attribute, blobs: &mut Vec<Blob>) -> Value {
    let blob = Blob::of(little_endian(attribute.values.iter().copied()));
    let value = json!({ "location": location, "components": attribute.components, "data": blob.name });
    blobs.push(blob);
    value
}

/// The description of the vertices of a draw.
fn vertices_json(input: &Vertices, blobs: &mut Vec<Blob>) -> Value {
    match input {
        Vertices::Count(count) => json!({ "count": count }),
        Vertices::Mesh { attributes, indices } => {
            let attributes: Vec<Value> = attributes.iter().enumerate().map(|(k, a)| attribute_json(k, a, blobs)).collect();
            let blob = Blob::of(indices.iter().flat_map(|i| i.to_le_bytes()).collect());
            let value = json!({ "indices": blob.name, "count": indices.len(), "attributes": attributes });
            blobs.push(blob);
            value
        }
    }
}

/// The case of a module, made from the draw that runs the module and from the images that the software renderer draws with it.
fn assemble_case(module: &ShaderModule, draw: &PlanDraw, sample: &SampleImage) -> Result<Case, String> {
    let mut blobs = Vec::new();
    let mut add_blob = |bytes: Vec<u8>| {
        let blob = Blob::of(bytes);
        let name = blob.name.clone();
        blobs.push(blob);
        name
    };
    let uniforms = add_blob(draw.uniform_bytes.clone());
    let expected = add_blob(little_endian(sample.f64_pixels.iter().flatten().copied()));
    let fields: Vec<Value> = module
        .layout
        .fields
        .iter()
        .map(|f| json!({ "name": f.name, "offset": f.offset, "size": f.size, "type": f.ty.to_string() }))
        .collect();
    let mut textures = Vec::new();
    for (bound, declared) in draw.textures.iter().zip(&module.layout.textures) {
        let TextureSource::Image(image) = &bound.source else { return Err(format!("`{}` is not an image in memory", declared.name)) };
        textures.push(texture_json(bound.binding, &declared.name, image, &mut blobs));
    }
    let samplers: Vec<Value> = draw
        .samplers
        .iter()
        .map(|s| {
            json!({
                "binding": s.binding,
                "address_u": address_name(s.state.address_u),
                "address_v": address_name(s.state.address_v),
                "filter": if s.state.is_trilinear { "linear" } else { "nearest" },
            })
        })
        .collect();
    let vertices = vertices_json(&draw.vertices, &mut blobs);
    let entry_points: serde_json::Map<String, Value> =
        module.module.entry_points.iter().map(|e| (format!("{:?}", e.stage).to_lowercase(), json!(e.name))).collect();
    Ok(Case {
        folder: format!("cases/{}", file_stem(&module.id)),
        wgsl: module.wgsl.clone(),
        json: json!({
            "format": FORMAT,
            "module": module.id.to_string(),
            "entry_points": entry_points,
            "target": { "width": sample.side_px, "height": sample.side_px, "format": "rgba32float", "clear": [0, 0, 0, 0], "depth": "reversed, cleared to 0" },
            "uniforms": { "group": 0, "binding": 0, "data": uniforms, "fields": fields },
            "textures": textures,
            "samplers": samplers,
            "vertices": vertices,
            "expected": expected,
            "tolerance": TOLERANCE,
            // A difference of encoded sRGB values, whereas the tolerance is of linear light.
            "own_f32_max_error": sample.rounding_levels() / 255.0,
        }),
        blobs,
    })
}

/// Reads the module of a key from the revision, draws the sample body with it, and makes a case of both.
fn draw_case(renderer: &SampleBodyRenderer, revision: &Revision, key: &ShaderKey, lowering: &Lowering) -> Result<Case, CorpusError> {
    let failed = |why: String| CorpusError::Case { key: key.to_string(), why };
    let module = Arc::new(revision.module(&ModuleId::Keyed(*key), lowering)?.ok_or_else(|| failed("not in the library".into()))?);
    let plan = renderer.plan(&module, key)?;
    let draw = plan.passes.first().and_then(|p| p.draws.first()).ok_or_else(|| failed("draws nothing".into()))?;
    assemble_case(&module, draw, &renderer.draw(&module, key)?).map_err(failed)
}

/// Writes the corpus of these keys into a folder; `on_case_done` is called after each case is drawn, from any thread. Returns the number of cases.
///
/// # Errors
/// A module that cannot be compiled or run, or a file that cannot be written.
pub fn write(
    folder: &Path,
    revision: &Revision,
    keys: &[ShaderKey],
    lowering: &Lowering,
    on_case_done: impl Fn() + Sync,
) -> Result<usize, CorpusError> {
    let create_dir = |path: &Path| std::fs::create_dir_all(path).map_err(|e| write_error(path, &e));
    let write_file = |path: &Path, bytes: &[u8]| write_atomic(path, FileAccess::All, |out| out.write_all(bytes));
    create_dir(&folder.join("data"))?;
    let mut written_blobs: BTreeSet<String> = BTreeSet::new();
    let mut cases: Vec<String> = Vec::new();
    for chunk in keys.chunks(CASES_PER_CHUNK) {
        let make = |renderer: &SampleBodyRenderer, key: &ShaderKey| draw_case(renderer, revision, key, lowering);
        let renderer_error = |key: &ShaderKey, e: &SessionError| CorpusError::Case { key: key.to_string(), why: e.to_string() };
        for case in map_with_renderers(SIDE_PX, chunk, make, renderer_error, &on_case_done) {
            let Case { folder: case_folder, wgsl, json, blobs } = case?;
            let path = folder.join(&case_folder);
            create_dir(&path)?;
            for blob in blobs {
                if written_blobs.insert(blob.name.clone()) {
                    write_file(&folder.join(&blob.name), &blob.bytes)?;
                }
            }
            write_file(&path.join("module.wgsl"), wgsl.as_bytes())?;
            write_file(&path.join("case.json"), format!("{json:#}\n").as_bytes())?;
            cases.push(case_folder);
        }
    }
    // The manifest is written last, so that a folder whose manifest lists cases is complete.
    let manifest = json!({ "format": FORMAT, "revision": revision.name, "tolerance": TOLERANCE, "cases": cases });
    write_file(&folder.join(MANIFEST), format!("{manifest:#}\n").as_bytes())?;
    Ok(cases.len())
}
