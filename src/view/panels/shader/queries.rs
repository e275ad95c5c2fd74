//! Queries of the Shader panel: modules with their costs, their texts, differences between modules, timings, images of the sample body.
//!
//! In: what a page of the panel asks for in this frame. Out: the result, some frames later. Always: a query runs on the query worker (a background
//! thread), and again only after its result was dropped; when the fragments (the shader sources from which modules are generated) change, all results
//! are dropped.

use super::module_text::{ModuleText, translated_text};
use crate::catalog::NaifId;
use crate::image::{DisplayImage, Level, MapDecoding};
use crate::render::plan::{self, FrameImages, ResourceProvider, SamplingQuality};
use crate::scene::draw::PixelView;
use crate::scene::effects::possible_features;
use crate::scene::request::ViewRequest;
use crate::session::{SAMPLE_HALF_SIDE_WITH_LIMB, Session, TapeCost, ms_per_megapixel_at, sample_body_plan, tape_costs};
use crate::shader::compare::{FeatureDiff, IrCost, difference, ir_cost};
use crate::shader::key::{ShaderKey, keys_of};
use crate::shader::library::Origin;
use crate::shader::module::diagnosis;
use crate::shader::translate::Language;
use crate::shader::{Emitted, ModuleId, ShaderModule};
use crate::view::error_texts::error_text;
use crate::view::language::text;
use crate::view::panels::compare::pair::{ComparedImage, Pair};
use crate::view::panels::render_loop::colour_image;
use crate::view::worker::query_cache::QueryCache;
use crate::view::worker::render_worker::RenderWorker;
use egui::{TextureHandle, TextureOptions};
use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant as WallInstant;

/// A module and its cost.
pub(crate) struct LoadedModule {
    pub module: Arc<ShaderModule>,
    /// Counts in the module's IR, naga's intermediate representation.
    pub ir: IrCost,
    /// Costs of the software renderer's tapes (lists of operations), vertex stage first.
    pub tapes: Vec<TapeCost>,
    /// How the library obtained the module, and how long that took; `None` if unknown.
    pub origin: Option<Origin>,
    /// Path and size in bytes of the module's entry in the library on disk; `None` if it has no entry.
    pub library_entry: Option<(PathBuf, u64)>,
}

/// Why there is no valid module.
pub(crate) struct ModuleFailure {
    /// The error in one line, in the window's language.
    pub why: String,
    /// The error as several lines: its source line, and a caret below the place of the error. Empty if no source line is known.
    pub diagnosis: String,
}

/// A module, or why there is none.
pub(crate) type ModuleResult = Result<Arc<LoadedModule>, Arc<ModuleFailure>>;

/// Gets a module from the library, and computes its costs.
fn load_module(session: &Session, id: &ModuleId) -> ModuleResult {
    let library = session.library();
    let failure = |why: String, diagnosis: String| Arc::new(ModuleFailure { why, diagnosis });
    let module = library.get(id).map_err(|e| failure(error_text(&e), diagnosis(&library.fragments(), id).unwrap_or_default()))?;
    let tapes = tape_costs(&module).map_err(|e| failure(error_text(&e), String::new()))?;
    let library_entry = library.entry_path(id).and_then(|path| {
        let bytes = path.metadata().ok()?.len();
        Some((path, bytes))
    });
    Ok(Arc::new(LoadedModule { ir: ir_cost(&module), tapes, origin: library.origin(id), library_entry, module }))
}

/// Size of a map in memory, as the shader reads it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MapFacts {
    /// Width and height of the first level, texels.
    pub width: u32,
    pub height: u32,
    /// Number of images in its mip chain.
    pub levels: usize,
    /// Size of all levels together, bytes.
    pub bytes: usize,
}

/// Side of a sample image (an image of the sample body), pixels.
pub(crate) const SAMPLE_PX: u32 = 96;
/// Largest number of sample images kept as textures; this number takes 22 MB. When it is reached, all textures are dropped before the next is stored.
const MAX_SAMPLE_TEXTURES: usize = 600;
/// Side of a timed image, pixels.
const TIMED_PX: u32 = 250;

type SampleImageResult = Result<egui::ColorImage, String>;

/// The replacement of one draw's key by another, in the image of the view.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct KeySwap {
    pub body: NaifId,
    /// Name of the part of the body that the draw shows ([`crate::scene::draw::BodyPart`]).
    pub part: &'static str,
    /// The new key.
    pub key: ShaderKey,
    /// Number of images that the window has shown, which identifies the view.
    pub image_number: u64,
}

/// The results of all queries so far.
#[derive(Default)]
pub(crate) struct ShaderQueries {
    /// Digest of the emitter (which generates the modules) and its fragments, to which the results belong.
    generator_digest: Option<Arc<str>>,
    modules: QueryCache<ModuleId, ModuleResult>,
    texts: QueryCache<(ModuleId, Language), Result<Arc<ModuleText>, String>>,
    differences: QueryCache<[ModuleId; 2], Result<Arc<Vec<FeatureDiff>>, String>>,
    reachable_keys: QueryCache<(), Arc<BTreeSet<ShaderKey>>>,
    timings: QueryCache<ModuleId, Result<Option<f64>, String>>,
    maps: QueryCache<(MapDecoding, String), Result<MapFacts, String>>,
    sample_images: QueryCache<ShaderKey, SampleImageResult>,
    /// The sample images that were displayed before.
    sample_textures: HashMap<ShaderKey, TextureHandle>,
    swaps: QueryCache<KeySwap, Result<Arc<Pair>, String>>,
    /// [`KeySwap::image_number`] of the pairs in `swaps`.
    swap_image_number: u64,
}

impl ShaderQueries {
    /// Drops all results if the fragments have changed.
    pub(crate) fn reset_on_new_fragments(&mut self, worker: &dyn RenderWorker) {
        let digest = worker.session().library().generator_digest();
        if self.generator_digest.as_ref() != Some(&digest) {
            *self = Self { generator_digest: Some(digest), ..Self::default() };
        }
    }

    /// For a change of language: drops errors, whose texts are in the previous language, and pending results, which may become such errors. Their queries run
    /// again.
    pub(crate) fn forget_failures(&mut self) {
        self.modules.forget_failures();
        self.texts.forget_failures();
        self.differences.forget_failures();
        self.timings.forget_failures();
        self.maps.forget_failures();
        self.sample_images.forget_failures();
        self.swaps.forget_failures();
    }

    /// The module, or the reason why there is none, once the result has arrived.
    pub(crate) fn module(&mut self, worker: &dyn RenderWorker, id: &ModuleId) -> Option<ModuleResult> {
        let asked_id = id.clone();
        self.modules.get(worker, id, move |session| load_module(session, &asked_id)).cloned()
    }

    /// The module; `None` until it has arrived, and if it is invalid.
    pub(crate) fn loaded_module(&mut self, worker: &dyn RenderWorker, id: &ModuleId) -> Option<Arc<LoadedModule>> {
        self.module(worker, id)?.ok()
    }

    /// The module's text in a shading language (or another format of [`Language`]), once it has arrived.
    pub(crate) fn text(&mut self, worker: &dyn RenderWorker, id: &ModuleId, language: Language) -> Option<Result<Arc<ModuleText>, String>> {
        let asked_id = id.clone();
        self.texts
            .get(worker, &(id.clone(), language), move |session| {
                let module = session.library().get(&asked_id).map_err(|e| error_text(&e))?;
                translated_text(&module, language).map(Arc::new)
            })
            .cloned()
    }

    /// The difference of two modules' sources, by feature, once it has arrived.
    pub(crate) fn difference(&mut self, worker: &dyn RenderWorker, ids: &[ModuleId; 2]) -> Option<Result<Arc<Vec<FeatureDiff>>, String>> {
        let asked_ids = ids.clone();
        self.differences
            .get(worker, ids, move |session| {
                let emitted = |id: &ModuleId| {
                    let module = session.library().get(id).map_err(|e| error_text(&e))?;
                    Ok::<_, String>(Emitted { wgsl: module.wgsl.clone(), source_map: module.source_map.clone() })
                };
                let [first, second] = &asked_ids;
                Ok(Arc::new(difference(&emitted(first)?, &emitted(second)?)))
            })
            .cloned()
    }

    /// Every key that any view of the catalog's bodies can need, once the result has arrived.
    pub(crate) fn reachable_keys(&mut self, worker: &dyn RenderWorker) -> Option<Arc<BTreeSet<ShaderKey>>> {
        self.reachable_keys.get(worker, &(), |session| Arc::new(keys_of(possible_features(session.catalog())))).cloned()
    }

    /// Starts timing a module; [`Self::timing`] returns the result.
    pub(crate) fn start_timing(&mut self, worker: &dyn RenderWorker, id: &ModuleId) {
        let asked_id = id.clone();
        self.timings.get(worker, id, move |session| {
            ms_per_megapixel_at(session.background_renderer(), session.library(), &asked_id, TIMED_PX).map_err(|e| error_text(&e))
        });
    }

    /// The time of a module in milliseconds per megapixel, if [`Self::start_timing`] was called and the result has arrived. `Ok(None)`: the module cannot
    /// draw the sample body, because it has no key or draws meshes.
    pub(crate) fn timing(&mut self, id: &ModuleId) -> Option<Result<Option<f64>, String>> {
        self.timings.known(id).cloned()
    }

    /// The size of a map file as it is decoded for a draw, once it has arrived.
    pub(crate) fn map_facts(&mut self, worker: &dyn RenderWorker, file: &str, decoding: MapDecoding) -> Option<Result<MapFacts, String>> {
        let asked_file = file.to_owned();
        self.maps
            .get(worker, &(decoding, file.to_owned()), move |session| {
                let map = session.map(&asked_file, decoding).map_err(|e| error_text(&e))?;
                let first = map.levels.first().ok_or(text!("map-empty"))?;
                let bytes = map.levels.iter().map(Level::byte_count).sum();
                Ok(MapFacts { width: first.width, height: first.height, levels: map.levels.len(), bytes })
            })
            .cloned()
    }

    /// The image of the sample body drawn with a key, once it has arrived. The body is the same for all keys: see `session::sample_body`.
    pub(crate) fn sample_texture(
        &mut self,
        ctx: &egui::Context,
        worker: &dyn RenderWorker,
        key: &ShaderKey,
    ) -> Option<Result<TextureHandle, String>> {
        if let Some(texture) = self.sample_textures.get(key) {
            return Some(Ok(texture.clone()));
        }
        let asked_key = *key;
        let drawn = self.sample_images.get(worker, key, move |session| draw_sample_body(session, &asked_key))?;
        let texture =
            drawn.as_ref().map(|image| ctx.load_texture(key.to_string(), image.clone(), TextureOptions::LINEAR)).map_err(Clone::clone);
        if let Ok(texture) = &texture {
            self.store_sample_texture(*key, texture.clone());
        }
        Some(texture)
    }

    /// Stores a texture. If there are [`MAX_SAMPLE_TEXTURES`] already, drops these first.
    fn store_sample_texture(&mut self, key: ShaderKey, texture: TextureHandle) {
        if self.sample_textures.len() >= MAX_SAMPLE_TEXTURES {
            self.sample_textures.clear();
        }
        self.sample_textures.insert(key, texture);
    }

    /// Two images of the view, once they have arrived: the first unchanged, the second with the key of one draw replaced.
    pub(crate) fn swap(
        &mut self,
        worker: &dyn RenderWorker,
        key_swap: &KeySwap,
        request: &ViewRequest,
    ) -> Option<Result<Arc<Pair>, String>> {
        if self.swap_image_number != key_swap.image_number {
            // The pairs of earlier views are dropped, because they are large and no longer needed.
            self.swap_image_number = key_swap.image_number;
            self.swaps.clear();
        }
        let (swap, request) = (key_swap.clone(), request.clone());
        self.swaps
            .get(worker, key_swap, move |session| {
                let [unchanged, changed] = [None, Some(&swap)].map(|applied| draw_swapped(session, &request, applied));
                Pair::of(unchanged, changed).map(Arc::new)
            })
            .cloned()
    }
}

/// Draws the sample body for display, encoded with a gamma of 2.2. Radiance 1 is white. With a key of another pixel view than the final image, the
/// greatest value is white.
fn draw_sample_body(session: &Session, key: &ShaderKey) -> SampleImageResult {
    let plan = sample_body_plan(session.library(), key, SAMPLE_PX, SAMPLE_HALF_SIDE_WITH_LIMB).map_err(|e| error_text(&e))?;
    let (frame, _) =
        session.background_renderer().render(&plan, session.library(), FrameImages::DisplayAndHdr).map_err(|e| error_text(&e))?;
    let is_radiance = key.features().view == PixelView::Final;
    // At least 1e-12, so that the scale of a black image is finite.
    let greatest_value = frame.hdr.iter().flat_map(|p| &p[..3]).copied().filter(|v| v.is_finite()).fold(1e-12, f32::max);
    let scale = if is_radiance { 1.0 } else { 1.0 / greatest_value };
    // 0.4545 = 1 / 2.2.
    let to_byte = |v: f32| (255.0 * (v * scale).clamp(0.0, 1.0).powf(0.4545)).round() as u8;
    let rgba = frame.hdr.iter().map(|p| [to_byte(p[0]), to_byte(p[1]), to_byte(p[2]), 255]).collect();
    Ok(colour_image(SAMPLE_PX, SAMPLE_PX, rgba))
}

/// Draws the view, with the key of one draw replaced if `swap` is given.
fn draw_swapped(session: &Session, request: &ViewRequest, swap: Option<&KeySwap>) -> Result<ComparedImage, String> {
    let sampling = SamplingQuality::of(request.quality);
    let mut scene = session.scene(request).map_err(|e| error_text(&e))?;
    for draw in &mut scene.draws {
        if let Some(swap) = swap.filter(|s| draw.body == s.body && draw.part.name() == s.part) {
            draw.features = *swap.key.features();
        }
    }
    let plan = plan::plan(&scene, session, sampling).map_err(|e| text!("swap-no-uniforms", e = e.to_string()))?;
    let start = WallInstant::now();
    let (frame, _) = session.background_renderer().render(&plan, session.library(), FrameImages::Display).map_err(|e| error_text(&e))?;
    let took_ms = start.elapsed().as_secs_f64() * 1e3;
    let image = DisplayImage { width: frame.width, height: frame.height, rgba: frame.display };
    Ok(ComparedImage { image, renderer: "software".into(), took_ms })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;

    /// A user who looks at many keys must not fill the memory of the GPU.
    #[test]
    fn textures_of_sample_images_are_dropped_when_there_are_too_many() {
        let keys = keys_of(possible_features(&Catalog::embedded()));
        assert!(keys.len() > 2 * MAX_SAMPLE_TEXTURES, "only {} keys", keys.len());
        let (ctx, mut queries) = (egui::Context::default(), ShaderQueries::default());
        for key in keys {
            let image = colour_image(1, 1, vec![[0, 0, 0, 255]]);
            queries.store_sample_texture(key, ctx.load_texture("sample", image, TextureOptions::LINEAR));
            assert!(queries.sample_textures.contains_key(&key) && queries.sample_textures.len() <= MAX_SAMPLE_TEXTURES);
        }
        // The font texture is egui's own.
        assert!(ctx.tex_manager().read().num_allocated() <= MAX_SAMPLE_TEXTURES + 1);
    }
}
