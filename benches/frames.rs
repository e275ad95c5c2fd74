//! Criterion benchmarks of the stages of a frame: scene, plan and drawing of each standard scene; scenes in which the light meter takes
//! much of the time; emitting, building and reading back a shader; texture sampling.
//!
//! `cargo bench --bench frames`, or `cargo bench --bench frames -- draw/saturn`. Frames are 512 pixels wide and high, with 4 samples, on
//! all threads. Times are wall times, so nothing else should run at the same time.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::image::{TexelFormat, Texture};
use orrery::render::plan::{self, AddressMode, SamplerState, SamplingQuality};
use orrery::render::software::exec::{Gradients, TextureUnit};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::sample::texels::Texels;
use orrery::render::software::sample::{BoundTexture, Textures};
use orrery::render::software::{SoftwareRenderer, lowering};
use orrery::scene::Scene;
use orrery::scene::request::{Position, ViewRequest};
use orrery::session::{Session, Sources, standard_scenes};
use orrery::shader::{ModuleId, ShaderLibrary, ShaderModule, emit};
use orrery::time::Instant;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

/// Width and height of the frames in pixels.
const SIZE: u32 = 512;
const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 8 };

fn session(cache: &tempfile::TempDir) -> Session {
    let sources = Sources { cache: Some(cache.path().to_owned()), ..Sources::default() };
    Session::open(&sources, |line| eprintln!("{line}")).expect("the built-in data opens")
}

fn frames(c: &mut Criterion) {
    let cache = tempfile::tempdir().expect("a folder");
    let session = session(&cache);
    let renderer: &SoftwareRenderer = session.renderer();
    for scene in standard_scenes(SIZE, SIZE) {
        // This first plan loads the maps and modules.
        let (built, planned) = session.plan(&scene.request, SAMPLING).expect("a standard scene");
        c.bench_function(&format!("scene/{}", scene.name), |b| {
            b.iter(|| Scene::build(session.catalog(), session.ephemeris(), black_box(&scene.request)).expect("a scene"));
        });
        c.bench_function(&format!("plan/{}", scene.name), |b| {
            b.iter(|| plan::plan(black_box(&built), &session, SAMPLING).expect("a plan"));
        });
        c.bench_function(&format!("draw/{}", scene.name), |b| {
            b.iter(|| renderer.render(black_box(&planned), session.library(), FrameImages::Display).expect("a frame"));
        });
    }
}

/// Scenes near the ground, as a session builds them: with the maps that the light meter reads.
fn metered_scenes(c: &mut Criterion) {
    const SATURN: NaifId = NaifId(699);
    const MIMAS: NaifId = NaifId(601);
    let cache = tempfile::tempdir().expect("a folder");
    let session = session(&cache);
    let night = "2024-06-21T00:00:00Z";
    let (madrid, dallas) = ((NaifId::EARTH, [40.0, -4.0]), (NaifId::EARTH, [32.78, -96.8]));
    let eye_height_km = 0.0017;
    for (name, target, (body, [latitude_deg, longitude_deg]), height_km, time) in [
        ("noon-1-km", NaifId::EARTH, madrid, 1.0, "2024-06-21T12:00:00Z"),
        ("night-1-km", NaifId::EARTH, madrid, 1.0, night),
        ("night-500-km", NaifId::EARTH, madrid, 500.0, night),
        ("moonlit-night", NaifId::MOON, madrid, eye_height_km, night),
        ("totality", NaifId::SUN, dallas, eye_height_km, "2024-04-08T18:42:00Z"),
        ("under-the-rings", MIMAS, (SATURN, [20.0, 40.0]), eye_height_km, "2017-05-17T00:00:00Z"),
    ] {
        let position = Position::Ground { body, latitude_deg, longitude_deg, height_km };
        let time = Instant::parse(time).expect("a time");
        let request = ViewRequest { position, fov_deg: Some(60.0), width: SIZE, height: SIZE, ..ViewRequest::of(target, time) };
        // This first scene loads the maps.
        session.scene(&request).expect("a scene");
        c.bench_function(&format!("metered/{name}"), |b| b.iter(|| session.scene(black_box(&request)).expect("a scene")));
    }
}

/// Measures the Earth's module in the first standard scene, a module with many features.
fn shader(c: &mut Criterion) {
    let cache = tempfile::tempdir().expect("a folder");
    let session = session(&cache);
    let (scene, _) = session.plan(&standard_scenes(SIZE, SIZE)[0].request, SAMPLING).expect("a standard scene");
    let id = plan::modules(&scene).into_iter().find(|m| matches!(m, ModuleId::Keyed(_))).expect("the Earth is drawn");
    c.bench_function("shader/emit", |b| b.iter(|| emit::emit_module(black_box(&id)).expect("emits")));
    let lowering = lowering();
    c.bench_function("shader/build", |b| b.iter(|| ShaderModule::build(black_box(&id), &lowering).expect("builds")));
    // A library with nothing in memory yet. Each iteration returns it, so that dropping it is not measured.
    let fresh_library = || ShaderLibrary::open(cache.path(), orrery::render::software::lowering(), |line| eprintln!("{line}"));
    c.bench_function("shader/read-back", |b| {
        b.iter_batched(fresh_library, |library| (library.get(&id).expect("is on disk"), library), BatchSize::SmallInput);
    });
    let library = fresh_library();
    library.get(&id).expect("is on disk");
    assert_eq!(library.statistics().from_disk, 1, "the module that was measured did not come from disk");
}

/// Reads a batch of 128 lanes, along a row of pixels, from a map of 2048 x 1024 texels. Each pixel's footprint is about 3.5 x 0.3 texels:
/// four taps if eight are allowed.
fn sampling(c: &mut Criterion) {
    const LANES: usize = 128;
    let texels: Vec<u8> = (0..2048 * 1024 * 4_u32).map(|k| (k.wrapping_mul(0x9e37_79b9) >> 24) as u8).collect();
    let map = Texture::from_rgba8(2048, 1024, texels, TexelFormat::Rgba8Srgb).expect("a texture of this size");
    let u: Vec<f32> = (0..LANES).map(|k| 0.1 + k as f32 * 0.0017).collect();
    let v: Vec<f32> = (0..LANES).map(|k| 0.3 + k as f32 * 0.0004).collect();
    let (du_dx, dv_dx) = (vec![0.0017_f32; LANES], vec![0.0004_f32; LANES]);
    let (du_dy, dv_dy) = (vec![0.0_f32; LANES], vec![0.0003_f32; LANES]);
    let gradients = Gradients { du_dx: &du_dx, dv_dx: &dv_dx, du_dy: &du_dy, dv_dy: &dv_dy };
    let mut group = c.benchmark_group("sample");
    group.throughput(Throughput::Elements(LANES as u64));
    for taps in [1, 8] {
        let sampler = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };
        let max_taps = [taps as f32];
        let bound = BoundTexture { texels: Arc::new(Texels::of_texture(&map).expect("a complete texture")), sampler: Some(sampler) };
        let textures = Textures::new(vec![bound], KernelClass::in_use());
        let mut out: [Vec<f32>; 4] = std::array::from_fn(|_| vec![0.0; LANES]);
        group.bench_function(format!("{taps}-taps"), |b| {
            b.iter(|| {
                let [red, green, blue, alpha] = &mut out;
                textures.sample_filtered(0, [black_box(&u), black_box(&v)], gradients, &max_taps, u128::MAX, [red, green, blue, alpha]);
            });
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    targets = frames, metered_scenes, shader, sampling
}
criterion_main!(benches);
