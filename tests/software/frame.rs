//! Complete frames drawn with generated modules: a lit sphere against its formula, points against their flux, display bytes against sRGB; the same bits
//! for every number of threads, and for all kernel classes that round alike.

use crate::support::folds::larger;
use glam::{Vec2, Vec3, Vec4};
use orrery::FrameImages;
use orrery::image::{TexelFormat, Texture};
use orrery::render::frame::Frame;
use orrery::render::plan::{
    AddressMode, Attribute, Blend, ColourFormat, Cull, DepthState, FrontFace, Instances, ModuleProvider, Pass, Plan, PlanDraw,
    SamplerBinding, SamplerState, ShadingRate, TextureBinding, TextureSource, Vertices, uniform_bytes,
};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::{Options, Precision, RenderError, SoftwareRenderer, lowering};
use orrery::scene::draw::{DrawFeatures, DrawUniforms, Light, MapSet};
use orrery::scene::{CORE_SIGMA_PX, GLARE_SCALE_RADIUS_PX, point_spread};
use orrery::shader::ModuleId;
use orrery::shader::ShaderLibrary;
use orrery::shader::key::ShaderKey;
use std::sync::{Arc, LazyLock};

static LIBRARY: LazyLock<ShaderLibrary> = LazyLock::new(|| ShaderLibrary::in_memory(lowering()));

const ALBEDO: f32 = 0.75;
/// Half the side of the image, in radii of the sphere.
const HALF_SIDE: f64 = 1.25;

fn draw(label: &str, module: ModuleId, uniform_bytes: Vec<u8>, vertices: Vertices) -> PlanDraw {
    PlanDraw {
        label: label.to_owned(),
        module,
        uniform_bytes,
        textures: Vec::new(),
        samplers: Vec::new(),
        vertices,
        instances: Instances { count: 1, attributes: Vec::new() },
        blend: Blend::PremultipliedOver,
        shading_rate: ShadingRate::PerPixel,
        cull: Cull::None,
        front_face: FrontFace::default(),
        depth: DepthState { test: true, write: true },
        scissor: [0, 0, u32::MAX, u32::MAX],
        extent: None,
    }
}

/// A Lambert sphere seen along -z by parallel rays, lit from `towards_sun`.
pub(super) fn sphere(towards_sun: Vec3, maps: MapSet) -> PlanDraw {
    let features = DrawFeatures { maps, lights: 1, ..DrawFeatures::MINIMAL };
    let side = 2.0 * HALF_SIDE as f32;
    let uniforms = DrawUniforms {
        rect_in_clip: Vec4::new(-1.0, 1.0, 1.0, -1.0),
        anchor_origin: Vec3::new(-0.5 * side, 0.5 * side, 0.0),
        anchor_du: Vec3::new(side, 0.0, 0.0),
        anchor_dv: Vec3::new(0.0, -side, 0.0),
        ray_origin: Vec3::NEG_Z,
        ray_du: Vec3::ZERO,
        ray_dv: Vec3::ZERO,
        anchor_radius_sq_minus_1: 0.0,
        anchor_is_camera: 0.0,
        // 1 - x² - y² (radii) as a polynomial in the rectangle's coordinates, 0 to 1: its coefficients of 1, u, v; then of u², uv, v².
        silhouette_form: [
            Vec4::new(1.0 - 0.5 * side * side, side * side, side * side, 0.0),
            Vec4::new(-side * side, 0.0, -side * side, 0.0),
        ],
        depth_row: Vec4::new(0.0, 0.0, -1.0, 1.0e3),
        axis_ratios: Vec3::ONE,
        albedo: Vec3::splat(ALBEDO),
        lights: vec![Light { direction_in_body: towards_sun.normalize_or_zero(), irradiance: Vec3::ONE }],
        photometric_parameter: 0.0,
        limb_darkening_u1: Vec3::ZERO,
        limb_darkening_u2: Vec3::ZERO,
        map_stretch: Vec2::ONE,
        night_radiance: Vec3::ZERO,
        specular_strength: 0.0,
        wave_slope_sq: 1.0,
        normal_strength: 1.0,
        camera_in_unit_sphere: Vec3::Z * 1.0e3,
        pixel_size: Vec2::ONE,
        ..DrawUniforms::default()
    };
    let id = ModuleId::Keyed(ShaderKey::for_draw(&features));
    let map_taps = 8;
    let uniform_bytes = uniform_bytes(&LIBRARY.module(&id).expect("emitted").layout, &uniforms, map_taps).expect("every field is there");
    draw("sphere", id, uniform_bytes, Vertices::Count(6))
}

/// The tone map of the image of an HDR pass, by the pass's index.
pub(super) fn tone_map(pass: usize) -> PlanDraw {
    let id = ModuleId::Simple("tone_map");
    let module = LIBRARY.module(&id).expect("emitted");
    let mut writer = module.layout.writer();
    writer.f32("exposure", 1.0).expect("a field");
    writer.f32("linear_limit", 0.8).expect("a field");
    let mut tone_map_draw = draw("tone map", id, writer.finish().expect("filled"), Vertices::Count(3));
    tone_map_draw.blend = Blend::Replace;
    tone_map_draw.depth = DepthState { test: false, write: false };
    tone_map_draw.textures =
        vec![TextureBinding { binding: module.layout.texture("hdr").expect("bound"), source: TextureSource::PassOutput(pass) }];
    tone_map_draw
}

pub(super) fn pass(name: &'static str, size: [u32; 2], format: ColourFormat, samples: u8, clear: [f32; 4], draws: Vec<PlanDraw>) -> Pass {
    Pass { name, width: size[0], height: size[1], format, samples, clear, has_depth: format == ColourFormat::Hdr, draws }
}

/// An HDR pass with these draws, of the name by which a renderer finds it, and its tone map.
pub(super) fn scene(size: [u32; 2], draws: Vec<PlanDraw>) -> Plan {
    let bodies = pass("light", size, ColourFormat::Hdr, 4, [0.0, 0.0, 0.0, 1.0], draws);
    Plan { passes: vec![bodies, pass("tone map", size, ColourFormat::Rgba8Unorm, 1, [0.0; 4], vec![tone_map(0)])] }
}

fn render(plan: &Plan, options: Options) -> Frame {
    let renderer = SoftwareRenderer::new(options).expect("a renderer");
    renderer.render(plan, &*LIBRARY, FrameImages::DisplayAndHdr).expect("a frame").0
}

pub(super) fn with_threads(threads: usize) -> Options {
    Options { threads, ..Options::default() }
}

fn greatest_difference(a: &Frame, b: &Frame) -> f32 {
    a.hdr.iter().zip(&b.hdr).flat_map(|(p, q)| p.iter().zip(q)).map(|(x, y)| (x - y).abs()).reduce(larger).expect("pixels")
}

#[test]
fn a_lambert_sphere_agrees_with_its_formula() {
    let sun = Vec3::new(0.6, 0.2, 0.7);
    let plan = scene([200, 200], vec![sphere(sun, MapSet::default())]);
    let to_sun = sun.as_dvec3().normalize_or_zero();
    for (precision, tolerance) in [(Precision::F32, 2e-6), (Precision::F64, 2e-7)] {
        let frame = render(&plan, Options { precision, ..Options::default() });
        let mut inside = 0;
        for (i, p) in frame.hdr.iter().enumerate() {
            let step = 2.0 * HALF_SIDE / 200.0;
            let (x, y) = (((i % 200) as f64 + 0.5) * step - HALF_SIDE, HALF_SIDE - ((i / 200) as f64 + 0.5) * step);
            let r = x.hypot(y);
            // Edge pixels contain only part of the disc.
            if r < 1.0 - 1.5 * step {
                inside += 1;
                let cos = x * to_sun.x + y * to_sun.y + (1.0 - r * r).sqrt() * to_sun.z;
                let expected = f64::from(ALBEDO) * cos.max(0.0);
                // Near the limb the normal is ill-conditioned in f32: the tolerance grows with its slope.
                let slope = 1.0 / (1.0 - r * r).sqrt();
                assert!((f64::from(p[0]) - expected).abs() < tolerance * slope, "pixel {i}: {} is not {expected}", p[0]);
            } else if r > 1.0 + 1.5 * step {
                assert_eq!(p, &[0.0, 0.0, 0.0, 1.0]);
            }
        }
        assert!(inside > 18_000);
    }
}

#[test]
fn antialiasing_keeps_the_discs_area() {
    // At full phase the sum of cosines over pixels is 2/3 of the disc's area.
    let frame = render(&scene([96, 96], vec![sphere(Vec3::Z, MapSet::default())]), Options::default());
    let step = 2.0 * HALF_SIDE / 96.0;
    let sum: f64 = frame.hdr.iter().map(|p| f64::from(p[0])).sum::<f64>() * step * step;
    let expected = f64::from(ALBEDO) * std::f64::consts::PI * 2.0 / 3.0;
    assert!((sum / expected - 1.0).abs() < 1e-3, "{sum} against {expected}");
}

/// A point: centre (clip x and y, depth), radius in pixels and stretch, and flux.
type PointLight = ([f32; 3], (f32, f32), [f32; 3]);

/// Points of an image of 200 by 100 pixels, whose light is added.
fn points(items: &[PointLight]) -> PlanDraw {
    let id = ModuleId::Simple("point");
    let module = LIBRARY.module(&id).expect("emitted");
    let mut writer = module.layout.writer();
    writer.vec2("pixel_size", Vec2::new(2.0 / 200.0, 2.0 / 100.0)).expect("a field");
    writer.f32("core_sigma_px", CORE_SIGMA_PX as f32).expect("a field");
    writer.f32("glare_scale_radius_px", GLARE_SCALE_RADIUS_PX as f32).expect("a field");
    let sprite = |(radius_px, stretch): (f32, f32)| {
        let [core, glare] = point_spread(f64::from(radius_px));
        [radius_px, core as f32 / stretch, glare as f32 / stretch, stretch]
    };
    let mut points = draw("points", id, writer.finish().expect("filled"), Vertices::Count(6));
    points.blend = Blend::Add;
    points.depth.write = false;
    let attribute = |components: u32, values: Vec<f32>| Attribute { components, values: Arc::new(values) };
    points.instances = Instances {
        count: items.len() as u32,
        attributes: vec![
            attribute(3, items.iter().flat_map(|(centre, ..)| *centre).collect()),
            attribute(4, items.iter().flat_map(|(_, size, _)| sprite(*size)).collect()),
            attribute(3, items.iter().flat_map(|(.., flux)| *flux).collect()),
        ],
    };
    points
}

#[test]
fn points_keep_their_flux() {
    // A sharp point, a point with a little glare, and a point with much glare.
    let points = points(&[
        ([-0.613, 0.17, 0.5], (2.0, 1.0), [1.0, 0.5, 0.0]),
        ([0.3301, -0.2, 0.5], (3.1, 2.0), [0.0, 0.25, 0.0]),
        ([0.8, 0.77, 0.5], (9.0, 1.5), [0.0, 0.0, 2.0]),
    ]);
    let plan = Plan { passes: vec![pass("points", [200, 100], ColourFormat::Hdr, 4, [0.0; 4], vec![points])] };
    let frame = render(&plan, Options::default());
    for (k, flux) in [1.0, 0.75, 2.0].into_iter().enumerate() {
        let sum: f64 = frame.hdr.iter().map(|p| f64::from(p[k])).sum();
        // The error that shaders/entry/point.wesl states.
        assert!((sum / flux - 1.0).abs() < 0.003, "channel {k}: {sum} against {flux}");
    }
}

/// More points than a batch of the renderer holds quads (32), each with another centre and flux, share a pixel.
#[test]
fn the_values_of_a_pixel_contain_the_light_of_all_points_there() {
    let point = |k: u16| {
        let k = f32::from(k);
        ([0.005 + 1e-4 * k, 0.01 - 1e-4 * k, 0.5], (4.0, 1.0), [1.0 + k, 2.0, 0.1 * k])
    };
    let (size, pixel) = ([200, 100], [100, 49]);
    for count in [1, 2, 40, 70] {
        let draw = points(&(0..count).map(point).collect::<Vec<_>>());
        for precision in [Precision::F32, Precision::F64] {
            let renderer = SoftwareRenderer::new(Options { precision, ..with_threads(1) }).expect("a renderer");
            let values = renderer.pixel_values(&draw, &*LIBRARY, size, pixel).expect("runs").expect("the points shade the pixel");
            let plan = Plan { passes: vec![pass("points", size, ColourFormat::Hdr, 1, [0.0; 4], vec![draw.clone()])] };
            let (frame, _) = renderer.render(&plan, &*LIBRARY, FrameImages::DisplayAndHdr).expect("a frame");
            let drawn = frame.hdr[(pixel[1] * size[0] + pixel[0]) as usize];
            for (value, drawn) in values.colour.iter().zip(drawn) {
                assert!((value - f64::from(drawn)).abs() <= 1e-5 * value.abs(), "{count} points: {:?}, drawn {drawn:?}", values.colour);
            }
        }
    }
}

#[test]
fn display_bytes_are_srgb_of_the_scene() {
    let mut plan = scene([70, 3], Vec::new());
    plan.passes[0].clear = [0.5, 0.25, 0.0, 1.0];
    let frame = render(&plan, Options::default());
    // IEC 61966-2-1: 0.5 is 187.516, 0.25 is 136.958.
    assert!(frame.display.iter().all(|p| *p == [188, 137, 0, 255]), "{:?}", frame.display[0]);
    assert_eq!(frame.hdr[0], [0.5, 0.25, 0.0, 1.0]);
}

#[test]
fn threads_and_kernel_classes_that_round_alike_change_no_bit() {
    let map = Arc::new(Texture::from_rgba8(64, 32, noise(64 * 32), TexelFormat::Rgba8Srgb).expect("complete levels"));
    let mut body = sphere(Vec3::new(1.0, 0.3, 0.2), MapSet { albedo: true, ..MapSet::default() });
    body.textures = vec![TextureBinding { binding: 1, source: TextureSource::Image(map) }];
    let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };
    body.samplers = vec![SamplerBinding { binding: 8, state }];
    let plan = scene([150, 130], vec![body]);
    let single_threaded = render(&plan, with_threads(1));
    assert!(single_threaded.hdr.iter().filter(|p| p[0] > 0.01).count() > 2000);
    for threads in [1, 2, 5] {
        assert!(render(&plan, with_threads(threads)) == single_threaded, "{threads} threads");
    }
    // The first frame without fused multiply-add, and the first with it.
    let mut by_rounding: [Option<Frame>; 2] = [None, None];
    for kernel_class in KernelClass::available() {
        let frame = render(&plan, Options { kernel_class, ..Options::default() });
        assert!(greatest_difference(&frame, &single_threaded) < 2e-3, "{}", kernel_class.name());
        let first = &mut by_rounding[usize::from(kernel_class.has_fma())];
        match first {
            Some(other) => assert!(*other == frame, "{}", kernel_class.name()),
            None => *first = Some(frame),
        }
    }
    let double = render(&plan, Options { precision: Precision::F64, ..Options::default() });
    assert!(greatest_difference(&double, &single_threaded) < 2e-3);
}

fn noise(texels: u32) -> Vec<u8> {
    (0..texels).flat_map(|i| [(i.wrapping_mul(2_654_435_761) >> 24) as u8, 90, 200, 255]).collect()
}

#[test]
fn an_invalid_plan_is_refused_with_the_kind_of_error() {
    let renderer = SoftwareRenderer::new(with_threads(1)).expect("a renderer");
    let error = |plan: &Plan| renderer.render(plan, &*LIBRARY, FrameImages::DisplayAndHdr).expect_err("must be refused");
    let without_texture = scene([8, 8], vec![sphere(Vec3::Z, MapSet { albedo: true, ..MapSet::default() })]);
    assert!(matches!(error(&without_texture), RenderError::Binding { binding: 1, .. }));
    let mut reads_later_pass = scene([8, 8], Vec::new());
    reads_later_pass.passes[1].draws = vec![tone_map(1)];
    assert!(matches!(error(&reads_later_pass), RenderError::PassOrder { pass: 1, .. }));
    let mut large = scene([8, 8], Vec::new());
    large.passes[0].width = 16385;
    assert!(matches!(error(&large), RenderError::Size { width: 16385, .. }));
    large.passes[0].width = 0;
    assert!(matches!(error(&large), RenderError::Size { width: 0, .. }));
    large.passes[0].width = 8;
    large.passes[0].samples = 3;
    assert!(matches!(error(&large), RenderError::Samples { samples: 3, .. }));
    assert!(matches!(error(&Plan { passes: Vec::new() }), RenderError::NoPass));
    let mut mesh = sphere(Vec3::Z, MapSet::default());
    mesh.vertices = Vertices::Mesh { attributes: Vec::new(), indices: Arc::new(vec![0, 1, 2]) };
    assert!(matches!(error(&scene([8, 8], vec![mesh])), RenderError::Index { .. }));
}

#[test]
#[ignore = "prints times"]
fn times_of_the_passes() {
    let maps = MapSet { albedo: true, ..MapSet::default() };
    let map = Arc::new(Texture::from_rgba8(2048, 1024, noise(2048 * 1024), TexelFormat::Rgba8Srgb).expect("complete levels"));
    for (label, maps, threads) in [("no map", MapSet::default(), 1), ("albedo map", maps, 1), ("albedo map", maps, 2)] {
        let mut body = sphere(Vec3::new(0.6, 0.2, 0.7), maps);
        if maps.albedo {
            let state = SamplerState { address_u: AddressMode::Repeat, address_v: AddressMode::ClampToEdge, is_trilinear: true };
            body.textures = vec![TextureBinding { binding: 1, source: TextureSource::Image(Arc::clone(&map)) }];
            body.samplers = vec![SamplerBinding { binding: 8, state }];
        }
        let plan = scene([1024, 1024], vec![body]);
        let renderer = SoftwareRenderer::new(with_threads(threads)).expect("a renderer");
        let mut best = [f64::INFINITY; 3];
        for _ in 0..20 {
            let timings = renderer.render(&plan, &*LIBRARY, FrameImages::Display).expect("a frame").1;
            let wall_ms = [timings.passes[0].wall_ms, timings.passes[1].wall_ms, timings.wall_ms];
            best = [0, 1, 2].map(|k| f64::min(best[k], wall_ms[k]));
        }
        println!("{label}, {threads} threads: bodies {:.1} ms, tone map {:.1} ms, frame {:.1} ms", best[0], best[1], best[2]);
    }
}

#[allow(dead_code, reason = "used by the benches alone")]
#[path = "../../benches/heavy/mod.rs"]
mod heavy;

/// No test measures time, but the images of the benches must remain drawable.
#[test]
fn the_benches_draw_their_images() {
    // A new renderer for each, because a renderer caches its modules by name.
    let renderer = || {
        SoftwareRenderer::new(Options { threads: 1, kernel_class: KernelClass::in_use(), precision: Precision::F32, ..Options::default() })
            .expect("a renderer")
    };
    let (frame, _) =
        renderer().render(&heavy::plan(64), &heavy::module(heavy::WGSL), FrameImages::DisplayAndHdr).expect("the heavy shader draws");
    let [corner, middle] = [0, 32 * 64 + 32].map(|k: usize| frame.hdr[k]);
    assert_eq!(corner, [0.0, 0.0, 0.0, 1.0]);
    assert!(middle.iter().all(|v| v.is_finite() && *v > 0.0), "{middle:?}");
    let (frame, _) =
        renderer().render(&heavy::tone_map_plan(64), &heavy::simple_module("tone_map"), FrameImages::Display).expect("the tone map draws");
    assert!(frame.display.iter().any(|p| p[0] > 200) && frame.display.iter().any(|p| p[1] < 64));
}
