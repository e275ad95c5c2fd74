//! Runs the stages from a view request to a finished frame. It uses catalog, ephemeris, maps, shader library and renderers.
//!
//! In: [`Sources`] (folders and files the user named) and view requests. Out: scenes, plans, frames, and the time of each stage.
//! A session is opened once and draws many frames; it keeps decoded maps and shader modules. Problems that the user should know (a missing map,
//! a cache that cannot be written) are passed to `notify`, each once. The clock is read only to measure times.

mod air_tables;
mod cache_folder;
mod composite;
mod cpu;
mod custom_surfaces;
mod data_layers;
mod devices;
mod drawing;
mod effect_cost;
mod error;
mod fragment_folder;
#[cfg(feature = "gpu")]
mod gpu_device;
mod images;
// A made-up shape model of any size, for measurements.
pub(crate) mod invented_shape;
mod lunar_heights;
mod meshes;
mod provenance;
mod renderers;
mod requirements;
mod ring_shine_files;
mod sample_body;
mod sky_map;
mod software_renderers;
mod sources;
mod stages;
mod standard_scenes;
mod star_and_body_files;
mod stored_tables;
mod table_folders;
mod tape_cost;
mod texture_folder;
mod window_surface;

pub use cache_folder::cache_folder;
pub use cpu::process_cpu;
pub use custom_surfaces::{SurfaceArgumentError, SurfaceError, SurfaceFile, surface_fragments, with_surfaces};
use devices::Devices;
pub use effect_cost::{EffectCost, LightChange};
pub use error::{CacheFolderError, SessionError};
use fragment_folder::is_hidden;
pub use fragment_folder::{FragmentFolderError, FragmentTimes, fragment_times, read_fragments};
pub use images::{PROVENANCE_CHUNK, is_exr, write_image, write_new_image};
pub use lunar_heights::read_lunar_heights;
pub(crate) use meshes::Meshes;
use parking_lot::Mutex;
pub use provenance::{ExistingImage, Provenance};
pub use renderers::{DrawnBy, Readiness, RendererError, RendererPreference, RequestedOutput};
use ring_shine_files::RingShineFiles;
// The sample body: a body drawn with any shader, to measure the shader's cost and precision.
pub use sample_body::{
    SAMPLE_HALF_SIDE_ON_DISC, SAMPLE_HALF_SIDE_WITH_LIMB, ms_per_megapixel, ms_per_megapixel_at, sample_body_plan, sample_body_plan_of,
};
pub use sources::Sources;
pub use stages::{Stage, Stages, milliseconds};
pub use standard_scenes::{StandardScene, standard_scenes};
pub(crate) use table_folders::{StoredTables, StoredTablesStatus};
pub use tape_cost::{TapeCost, tape_costs};
pub(crate) use texture_folder::TextureFolder;
pub use window_surface::{DeviceSurface, DisplayError, DisplayPreference, PresenterChange, WindowHandle};

use crate::catalog::constellations::Constellations;
use crate::catalog::nomenclature;
use crate::catalog::small_bodies::SmallBodies;
use crate::catalog::stars::StarCatalog;
use crate::catalog::{Catalog, CatalogError, NaifId};
use crate::ephemeris::Ephemeris;
use crate::files::{read_bytes, read_text};
use crate::image::{DEFAULT_MAX_MEGAPIXELS, GlyphAtlas, MapDecoding, MapStore, SharedTexture, StoredMaps};
use crate::memo::Memo;
use crate::render::frame::Frame;
use crate::render::plan::{self, GpuImage, PlanError, ResourceProvider, SimpleDraw};
use crate::render::software::kernels::KernelClass;
use crate::render::software::{RenderError, SoftwareRenderer};
use crate::scene::bright_ground::BrightGround;
use crate::scene::draw::RingTable;
use crate::scene::labels;
use crate::scene::night_lights::NightLights;
use crate::scene::rings::ring_shine::{RingShineCache, RingShineStore};
use crate::scene::sky::map::SkyMap;
use crate::scene::{Caches, Scene};
use crate::shader::fragments::Fragments;
use crate::shader::library::{ShaderLibrary, Statistics};
use crate::shader::{Layout, Lowering, ModuleId};
use crate::wording::echo;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::thread::ThreadId;

/// A drawn frame with its scene.
pub struct DrawnFrame {
    /// What the frame shows, and why.
    pub scene: Scene,
    /// Draws whose shaders have no key: lines, labels, points.
    pub simple_draws: Vec<SimpleDraw>,
    /// The pixels.
    pub frame: Frame,
    /// The image, if it stays on the GPU that drew it; `frame` has no pixels then.
    pub gpu_image: Option<GpuImage>,
    /// The renderer that drew the frame.
    pub drawn_by: DrawnBy,
}

/// Largest catalog file, bytes; the longest embedded one has 130 kB.
const MAX_CATALOG_BYTES: u64 = 1 << 24;
/// Largest kernel, bytes: DE441, the longest that the JPL publishes, has 3.3 GB (https://ssd.jpl.nasa.gov/ftp/eph/planets/bsp/).
const MAX_KERNEL_BYTES: u64 = 4 << 30;
/// Characters of coordinates, for the glyph atlas.
const COORDINATE_CHARS: &str = "0123456789+-.°'\"hmsNESW";
/// Largest number of textures of ring tables in memory: enough for the rings and their shadows in a frame.
const MAX_RING_TEXTURES: usize = 6;
/// Largest number of bodies whose night lights (city lights) are in memory; the same for bright ground.
const MAX_BODIES_WITH_NIGHT_LIGHTS: usize = 16;
const MAX_BODIES_WITH_BRIGHT_GROUND: usize = 16;

/// Catalog, ephemeris, maps, shaders and renderers of one run. Threads share it.
pub struct Session {
    catalog: Catalog,
    ephemeris: Ephemeris,
    maps: MapStore,
    library: ShaderLibrary,
    air_tables: air_tables::AirTables,
    meshes: Meshes,
    /// Night lights (city lights) by body. Read when automatic exposure first needs them: when it shows them.
    night_lights: Memo<NaifId, Option<Arc<NightLights>>>,
    /// Bright ground by body. Read when automatic exposure first needs it: near the body.
    bright_grounds: Memo<NaifId, Option<Arc<BrightGround>>>,
    /// The textures of the latest ring tables.
    ring_textures: Memo<Arc<RingTable>, SharedTexture>,
    /// The glyph atlas of the last requested size, by the bits of the size in pixels.
    glyphs: Memo<u64, Arc<GlyphAtlas>>,
    scene_caches: Caches,
    /// The software renderer and the GPU.
    devices: Devices,
    /// Map and mesh files that could not be read, each reported once.
    unreadable_files: Mutex<BTreeSet<String>>,
    /// Receives the messages for the user.
    notify: Arc<dyn Fn(&str) + Send + Sync>,
    /// Times of the stages by thread, so that a frame's times do not include background work.
    stages: Mutex<HashMap<ThreadId, Stages>>,
    /// Whether CPU time is measured for each stage, in addition to elapsed time.
    count_cpu: bool,
    /// What the session was opened with.
    sources: Sources,
    /// Custom surfaces, the user's functions that colour the ground of bodies: path below shaders/, and WESL text.
    surfaces: Vec<(String, String)>,
    /// The user's panorama of the sky.
    sky_map: Option<SkyMap>,
    /// Digests of the files from which the session draws, for provenance; computed when first needed.
    source_digests: OnceLock<BTreeMap<String, String>>,
}

/// The minor planets and comets of the user's file ([`Catalog::with_small_bodies`]), if a path is given.
///
/// # Errors
/// A file that cannot be read, or its first invalid line.
pub fn read_small_bodies(path: Option<&Path>) -> Result<Option<SmallBodies>, SessionError> {
    star_and_body_files::small_bodies(path)
}

/// The error of an option that names a folder which does not exist. `remedy`: a text that says what the option takes.
fn no_folder(folder: &Path, remedy: &str) -> SessionError {
    SessionError::File { path: echo(&folder.display().to_string()), why: format!("there is no such folder; {remedy}") }
}

/// The built-in catalog, overridden by the `*.toml` files of a folder in order of their names. Hidden files are skipped, and a `Cargo.toml`, as in catalogs/.
///
/// # Errors
/// A folder without such files, a file that cannot be read, or a list of all invalid fields.
pub fn read_catalog(folder: Option<&Path>) -> Result<Catalog, SessionError> {
    let Some(folder) = folder else { return Ok(Catalog::embedded()) };
    let file_error = |path: &Path, e: std::io::Error| SessionError::File { path: echo(&path.display().to_string()), why: e.to_string() };
    if !folder.exists() {
        return Err(no_folder(folder, "--catalogs takes a folder of catalog files"));
    }
    if !folder.is_dir() {
        let why = "not a folder; --catalogs takes the folder of catalog files".to_owned();
        return Err(SessionError::File { path: echo(&folder.display().to_string()), why });
    }
    let entries = std::fs::read_dir(folder).and_then(|all| all.collect::<std::io::Result<Vec<_>>>()).map_err(|e| file_error(folder, e))?;
    let is_toml = |path: &PathBuf| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let mut paths: Vec<PathBuf> = entries.iter().map(|e| e.path()).filter(is_toml).collect();
    paths.retain(|p| !is_hidden(p) && p.file_name().is_some_and(|name| name != "Cargo.toml"));
    if paths.is_empty() {
        let why = "no catalog file (*.toml) in it; --catalogs takes a folder of catalog files".to_owned();
        return Err(SessionError::File { path: echo(&folder.display().to_string()), why });
    }
    paths.sort();
    let mut files = Vec::new();
    for path in paths {
        let text = read_text(&path, MAX_CATALOG_BYTES).map_err(|e| file_error(&path, e))?;
        files.push((path.display().to_string(), text));
    }
    Catalog::with_files(&files)?.with_data(|layer| data_layers::read(&folder.join(&layer.file), layer))
}

/// The embedded ephemeris, extended by the user's kernel. Checks that the motion and the rotation of every body of the catalog can be computed.
///
/// # Errors
/// A file that cannot be read, or a list of all fields of the catalog that the ephemeris does not support, each with its file and line.
pub fn read_ephemeris(catalog: &Catalog, kernel: Option<&Path>) -> Result<Ephemeris, SessionError> {
    let mut ephemeris = Ephemeris::embedded(catalog)?;
    if let Some(path) = kernel {
        let name = path.display().to_string();
        let file_error =
            |why: String| SessionError::File { path: echo(&name), why: format!("{why}; --kernel takes an SPK file such as de440.bsp") };
        let bytes = read_bytes(path, MAX_KERNEL_BYTES).map_err(|e| file_error(e.to_string()))?;
        ephemeris = ephemeris.with_kernel(&name, bytes)?;
    }
    let mut problems: Vec<_> = ephemeris.unsupported_fields(catalog).into_iter().map(|f| catalog.problem(f.body, f.field, f.why)).collect();
    problems.sort_by(|a, b| (&a.file, a.line).cmp(&(&b.file, b.line)));
    if problems.is_empty() { Ok(ephemeris) } else { Err(CatalogError { problems }.into()) }
}

/// The shader library below the cache folder, or in memory if there is no cache folder.
pub fn open_library(cache: Option<&Path>, lowering: Lowering, notify: Arc<dyn Fn(&str) + Send + Sync>) -> ShaderLibrary {
    match cache {
        Some(folder) => ShaderLibrary::open(folder, lowering, move |line| notify(line)),
        None => ShaderLibrary::in_memory(lowering),
    }
}

/// Reports what the user named and the program does not use: a folder of maps of which no file replaces any, and unknown kernels of the software renderer.
fn report_ignored(sources: &Sources, catalog: &Catalog, notify: &dyn Fn(&str)) {
    if let Some(folder) = &sources.textures {
        let found = TextureFolder::of(folder, catalog);
        if let Some(unused) = found.unused_text(catalog).filter(|_| !found.is_used) {
            notify(&format!("--textures {}: replaces no map: {unused}", echo(&folder.display().to_string())));
        }
    }
    if let Some(why) = KernelClass::unavailable_choice() {
        notify(&why);
    }
}

impl Session {
    /// Reads the user's files, and opens the shader library. Maps of bodies are read later, when a view needs them.
    pub fn open(sources: &Sources, notify: impl Fn(&str) + Send + Sync + 'static) -> Result<Self, SessionError> {
        let notify: Arc<dyn Fn(&str) + Send + Sync> = Arc::new(notify);
        if let Some(folder) = sources.textures.as_ref().filter(|folder| !folder.is_dir()) {
            return Err(no_folder(folder, "--textures takes a folder of maps"));
        }
        let renderer = software_renderers::renderer(sources.threads, sources.uses_f64)?;
        let devices = Devices::new(renderer, sources.renderer, sources.uses_f64, notify.clone());
        if sources.will_draw {
            devices.start_opening_gpu();
        }
        let mut stages = Stages::default();
        // `eclipse_radii`: the convention for the radii of the Sun and the Moon: the catalog's own, or those of almanacs.
        let catalog =
            stages.measure(Stage::Catalog, || read_catalog(sources.catalogs.as_deref()))?.with_eclipse_radii(sources.eclipse_radii);
        let stars = stages.measure(Stage::Catalog, || star_and_body_files::stars(sources.stars.as_deref()))?;
        let small_bodies = stages.measure(Stage::Catalog, || star_and_body_files::small_bodies(sources.minor_planets.as_deref()))?;
        let lunar_heights = stages.measure(Stage::Maps, || read_lunar_heights(sources.lunar_heights.as_deref()))?;
        let catalog = catalog.with_stars(stars).with_small_bodies(small_bodies).with_lunar_heights(lunar_heights);
        let catalog = with_surfaces(catalog, &sources.surfaces)?;
        let ephemeris = stages.measure(Stage::Kernel, || read_ephemeris(&catalog, sources.kernel.as_deref()))?;
        report_ignored(sources, &catalog, &*notify);
        let cache = cache_folder(sources.cache.as_deref()).map_err(|e| notify(&e.to_string())).ok();
        let maps = MapStore::with_limit(sources.textures.clone(), sources.max_megapixels.unwrap_or(DEFAULT_MAX_MEGAPIXELS));
        let maps = maps.with_disk_cache(cache.as_deref().map(StoredMaps::new));
        let sky_map =
            stages.measure(Stage::Maps, || sky_map::read_sky(sources.sky.as_deref(), sources.sky_frame, &maps, sources.max_megapixels))?;
        data_layers::add_images(&catalog, &maps)?;
        let library = open_library(cache.as_deref(), software_renderers::lowering(), notify.clone());
        let ring_shines = cache.as_deref().map(|folder| Box::new(RingShineFiles::new(folder)) as Box<dyn RingShineStore>);
        let air_tables = air_tables::AirTables::open(cache);
        let folder_fragments = match &sources.shaders {
            Some(folder) => fragment_times(folder).and_then(|times| read_fragments(folder, &times))?,
            None => Fragments::default(),
        };
        let surfaces = surface_fragments(&sources.surfaces, &folder_fragments)?;
        if sources.shaders.is_some() || !surfaces.is_empty() {
            library.set_fragments(folder_fragments.and_files(surfaces.iter().cloned()));
        }
        Ok(Self {
            catalog,
            ephemeris,
            maps,
            library,
            air_tables,
            meshes: Meshes::new(sources.map_and_mesh_folders().cloned()),
            night_lights: Memo::with_capacity(MAX_BODIES_WITH_NIGHT_LIGHTS),
            bright_grounds: Memo::with_capacity(MAX_BODIES_WITH_BRIGHT_GROUND),
            ring_textures: Memo::with_capacity(MAX_RING_TEXTURES),
            glyphs: Memo::with_capacity(1),
            scene_caches: Caches::with_ring_shines(RingShineCache::stored(ring_shines)),
            devices,
            unreadable_files: Mutex::default(),
            notify,
            stages: Mutex::new(HashMap::from([(std::thread::current().id(), stages)])),
            count_cpu: false,
            sources: sources.clone(),
            surfaces,
            sky_map,
            source_digests: OnceLock::new(),
        })
    }

    /// Replaces the minor planets and comets ([`Catalog::with_small_bodies`]), for a measurement; the provenance of images does not include them.
    #[must_use]
    pub fn with_small_bodies(self, small_bodies: SmallBodies) -> Self {
        Self { catalog: self.catalog.with_small_bodies(Some(small_bodies)), ..self }
    }

    /// Replaces the stars, for a measurement; the provenance of images does not include them.
    #[must_use]
    pub fn with_stars(self, stars: StarCatalog) -> Self {
        Self { catalog: self.catalog.with_stars(Some(Arc::new(stars))), ..self }
    }

    /// Counts CPU time from now on. This reads one file per thread at the start and the end of each stage; a window does not use it, because its frames would
    /// be slower.
    pub fn counting_cpu(self) -> Self {
        Self { count_cpu: true, ..self }
    }

    /// What the session was opened with.
    pub(crate) fn sources(&self) -> &Sources {
        &self.sources
    }

    /// The catalog: bodies, stars, moments, data layers.
    pub fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    /// The software renderer, which is always available.
    pub fn renderer(&self) -> &SoftwareRenderer {
        &self.devices.software
    }

    /// A software renderer with its own threads, for queries that are answered while a window's image is drawn.
    pub fn background_renderer(&self) -> &SoftwareRenderer {
        self.devices.background_renderer()
    }

    /// The renderers that the user can choose, and the current choice.
    pub fn renderers(&self) -> (&'static [RendererPreference], RendererPreference) {
        (self.devices.choices(), self.devices.preference())
    }

    /// Whether the GPU is still being prepared on another thread; until it is ready, the window's images are drawn in software. Never blocks.
    pub fn readiness(&self) -> Readiness {
        self.devices.readiness()
    }

    /// Sets the renderer for the next frame and all later ones. Ignored if it is not among the choices of [`Self::renderers`].
    pub fn set_renderer_preference(&self, preference: RendererPreference) {
        self.devices.set_preference(preference);
    }

    /// A new software renderer with the same number of threads as [`Self::renderer`], in f64 or in f32.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn renderer_in(&self, uses_f64: bool) -> Result<SoftwareRenderer, RenderError> {
        software_renderers::renderer(Some(self.renderer().threads()), uses_f64)
    }

    /// As [`Self::renderer_in`] in f64, but vertices snap to the subpixel grid of GPUs, so that edges cover the same pixels as a GPU's.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn renderer_for_gpu_comparison(&self) -> Result<SoftwareRenderer, RenderError> {
        software_renderers::renderer_for_gpu_comparison(Some(self.renderer().threads()))
    }

    /// Destroys the GPU device, as a driver reset would, to test the fallback.
    #[cfg(feature = "gpu")]
    pub fn destroy_gpu(&self) {
        self.devices.destroy_gpu();
    }

    /// Positions and rotations.
    pub fn ephemeris(&self) -> &Ephemeris {
        &self.ephemeris
    }

    /// The shader modules.
    pub fn library(&self) -> &ShaderLibrary {
        &self.library
    }

    /// Passes a line to `notify`, the receiver of this session's messages.
    pub fn notify(&self, line: &str) {
        (self.notify)(line);
    }

    /// Time by stage since the session was opened, and statistics of the library.
    pub fn report(&self) -> (Stages, Statistics) {
        let by_thread = self.stages.lock();
        (by_thread.values().fold(Stages::default(), |sum, s| sum.and(s)), self.library.statistics())
    }

    /// As [`Self::report`], but with the times of the calling thread only.
    pub fn report_of_this_thread(&self) -> (Stages, Statistics) {
        let by_thread = self.stages.lock();
        (by_thread.get(&std::thread::current().id()).cloned().unwrap_or_default(), self.library.statistics())
    }

    /// Runs `work` and adds its time to a stage of the calling thread.
    fn timed<T>(&self, stage: Stage, work: impl FnOnce() -> T) -> T {
        let cpu_at_start = if self.count_cpu { process_cpu() } else { None };
        let start = std::time::Instant::now();
        let result = work();
        let elapsed = start.elapsed();
        let cpu_time = cpu_at_start.and_then(|at_start| process_cpu()?.checked_sub(at_start));
        let mut by_thread = self.stages.lock();
        let stages = by_thread.entry(std::thread::current().id()).or_default();
        stages.add(stage, elapsed);
        if let Some(cpu_time) = cpu_time {
            stages.add_cpu(stage, cpu_time);
        }
        result
    }
}

impl ResourceProvider for Session {
    fn layout(&self, module: &ModuleId) -> Result<Layout, PlanError> {
        Ok(self.library.get(module).map_err(|e| PlanError::Module(e.to_string()))?.layout.clone())
    }
    fn map(&self, file: &str, decoding: MapDecoding) -> Result<SharedTexture, PlanError> {
        self.maps.get_decoded(file, decoding).map_err(|e| PlanError::Map { file: file.to_owned(), why: e.to_string() })
    }
    fn overlay(&self, file: &str) -> Result<SharedTexture, PlanError> {
        self.maps.premultiplied(file).map_err(|e| PlanError::Map { file: file.to_owned(), why: e.to_string() })
    }
    fn ring_profile(&self, table: &Arc<RingTable>) -> SharedTexture {
        self.ring_textures.get_compatible(Arc::ptr_eq, Arc::clone(table), || plan::ring_profile(table))
    }
    fn glyphs(&self, size_px: f64) -> Arc<GlyphAtlas> {
        self.glyphs.get(size_px.to_bits(), || {
            let names = self.catalog.bodies().iter().flat_map(|b| b.name.chars()).chain(nomenclature::characters());
            let names = names.chain(self.catalog.instruments().iter().flat_map(|i| i.name.chars()));
            let constellations = Constellations::embedded().all.iter().flat_map(|c| c.name.chars());
            let names = names.chain(constellations).chain(' '..='~').chain(COORDINATE_CHARS.chars());
            Arc::new(GlyphAtlas::draw(names, size_px as f32, labels::MARKER_RADIUS as f32))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_glyphs_contain_the_letters_of_the_users_instruments() {
        let folder = tempfile::tempdir().expect("a folder");
        let instrument_toml = "[[instrument]]\nname = \"Телескоп\"\nshape = \"circle\"\ndiameter_deg = 0.6\nsource = \"own\"\n";
        std::fs::write(folder.path().join("own.toml"), instrument_toml).expect("written");
        let catalogs = Some(folder.path().to_owned());
        let sources = Sources { catalogs, cache: Some(folder.path().join("cache")), ..Sources::default() };
        let session = Session::open(&sources, |line| panic!("{line}")).expect("a session");
        assert_eq!(session.glyphs(20.0).layout("Телескоп").count(), 8);
    }
}
