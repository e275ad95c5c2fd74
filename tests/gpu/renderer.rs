//! The GPU renderer against the software renderer, plan by plan, on any adapter, including software drivers.
//!
//! Without a driver each test is skipped with a message, or fails (tests/support/gpu.rs). Bounds of the difference in levels of 255, and
//! why it is not 0:
//!
//! | what | mean | 99.9 % | greatest | why |
//! |---|---|---|---|---|
//! | golden views | 0.3 | 3 | 14 | drivers decode sRGB and round differently; a limb pixel may choose another texel: measured 0.16, 2, 13 on llvmpipe (one texel of the Moon) |
//! | covering keys | 0.3 | 3 | - | the same: measured 0.11, 1 |
//!
//! Anisotropic filtering is part of the module (shaders/lib/filtered_map.wesl), so both renderers can be compared at the default quality.

use crate::support::gpu::{gpu, or_skipped};
use crate::support::session::SESSION;
use crate::support::sweep;
use crate::support::views::views;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::image::{Difference, DisplayImage};
use orrery::render::frame::Frame;
use orrery::render::gpu::{AdapterKind, GpuError, GpuRenderer};
use orrery::render::plan::{Plan, PlanDraw, SamplingQuality, TextureSource, Vertices};
use orrery::render::software::{Options, SoftwareRenderer, lowering};
use orrery::scene::draw::PixelView;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Position, ViewRequest};
use orrery::session::{
    DisplayPreference, PresenterChange, Readiness, RendererPreference, RequestedOutput, SAMPLE_HALF_SIDE_WITH_LIMB, Session, Sources,
    sample_body_plan, standard_scenes,
};
use orrery::shader::ShaderLibrary;
use orrery::shader::key::covering_keys;
use orrery::time::Instant;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex};

const MEAN_LEVELS: f64 = 0.3;
const P999_LEVELS: u8 = 3;
const MAX_LEVELS: u8 = 14;

const SHORT_EXPOSURE: &str = "lines at a short exposure";

/// The default quality.
const SAMPLING: SamplingQuality = SamplingQuality { samples: 4, anisotropy: 8 };

fn session(renderer: RendererPreference) -> (Session, Arc<Mutex<Vec<String>>>, tempfile::TempDir) {
    let cache = tempfile::tempdir().expect("a folder");
    let sources = Sources { cache: Some(cache.path().to_owned()), renderer, ..Sources::default() };
    let messages: Arc<Mutex<Vec<String>>> = Arc::default();
    let sink = Arc::clone(&messages);
    let session = Session::open(&sources, move |line| sink.lock().expect("not poisoned").push(line.to_owned())).expect("opens");
    (session, messages, cache)
}

fn image(frame: Frame) -> DisplayImage {
    DisplayImage { width: frame.width, height: frame.height, rgba: frame.display }
}

fn exceeds_bounds(d: &Difference) -> bool {
    d.mean > MEAN_LEVELS || d.p999 > P999_LEVELS || d.max > MAX_LEVELS
}

/// The golden views; two with all layers: a planet with its moons, and the solar system, which exceeds the depth range of GL; and Titan, full and half lit,
/// because no golden view has thick haze; and lines brighter than half floats.
fn compared_views() -> Vec<(&'static str, ViewRequest)> {
    let layers = Layers::ALL;
    let moons = views().into_iter().find(|(name, _)| *name == "jupiter-moons").expect("in the table").1;
    let system =
        standard_scenes(moons.width, moons.height).into_iter().find(|s| s.name == "whole-system").expect("a standard scene").request;
    let all_layers = [("jupiter-moons with all layers", moons), ("whole-system with all layers", system)];
    let all_layers = all_layers.map(|(name, request)| (name, ViewRequest { layers, ..request }));
    let titans = [("titan", 0.0), ("titan half lit", 90.0)].map(|(name, phase_deg)| (name, titan(phase_deg)));
    views().into_iter().chain(all_layers).chain(titans).chain([(SHORT_EXPOSURE, lines_at_a_short_exposure())]).collect()
}

/// The Sun with lines of a grid at an exposure so short that the radiance of the lines is beyond the range of half floats.
fn lines_at_a_short_exposure() -> ViewRequest {
    let time = Instant::parse("2024-10-10T00:00:00Z").expect("a time");
    ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        fov_deg: Some(2.0),
        width: 160,
        height: 160,
        exposure: ExposureRequest::Stops(-20.0),
        layers: Layers::parse("+grid-equatorial").expect("layers"),
        ..ViewRequest::of(NaifId::SUN, time)
    }
}

/// Titan at a phase angle, from 6 of its radii.
fn titan(phase_deg: f64) -> ViewRequest {
    let (id, time) = (NaifId(606), Instant::parse("2021-06-01T00:00:00Z").expect("a time"));
    let to_sun = SESSION.ephemeris().state(NaifId::SUN, id, time, None).expect("placed").state.pos_km.normalize();
    let (sin, cos) = phase_deg.to_radians().sin_cos();
    let offset_km = (to_sun * cos + to_sun.any_orthonormal_vector() * sin) * (6.0 * 2575.0);
    let position = Position::Offset { body: id, offset_km, axes: Axes::Icrf };
    ViewRequest { position, fov_deg: Some(25.0), width: 192, height: 192, ..ViewRequest::of(id, time) }
}

#[test]
fn golden_views_match_the_software_renderer() {
    let Some(gpu) = gpu() else { return };
    assert_views_match_the_software_renderer(&gpu);
}

#[test]
fn golden_views_match_the_software_renderer_on_gl() {
    let Some(gpu) = or_skipped(GpuRenderer::open_gl()) else { return };
    println!("on {}", gpu.facts());
    assert_eq!(gpu.facts().backend, "gl");
    assert_views_match_the_software_renderer(&gpu);
}

fn assert_views_match_the_software_renderer(gpu: &GpuRenderer) {
    let session = &*SESSION;
    let mut failures = Vec::new();
    // One view in four, chosen by the process id, unless full sweeps are on; "moon" always, for the negative control.
    for (_, (name, request)) in compared_views().into_iter().enumerate().filter(|(k, (name, _))| *name == "moon" || sweep::runs(*k, 4)) {
        let (_, plan) = session.plan(&request, SAMPLING).expect("a plan");
        let drawn = match gpu.render(&plan, session.library(), FrameImages::Display) {
            // A GL driver that cannot blend 32-bit floats refuses these views; a session then draws them in software.
            Err(GpuError::Unsupported(why))
                if ["night-sky", "halley", "milky-way", "dome-dusk", SHORT_EXPOSURE].contains(&name) && gpu.facts().backend == "gl" =>
            {
                println!("{name}: {why}");
                continue;
            }
            drawn => drawn.expect("drawn").0,
        };
        let (soft, _) = session.renderer().render(&plan, session.library(), FrameImages::Display).expect("drawn");
        let (drawn, soft) = (image(drawn), image(soft));
        let difference = soft.difference(&drawn).expect("one size");
        println!("{name}: mean {:.4}, 99.9 % {}, greatest {}", difference.mean, difference.p999, difference.max);
        if exceeds_bounds(&difference) {
            failures.push(format!("{name}: mean {:.3}, 99.9 % {}, greatest {}", difference.mean, difference.p999, difference.max));
        }
        // Negative control: half a stop more light exceeds the bounds.
        if name == "moon" {
            let mut brighter = plan.clone();
            let tone_map = brighter.passes.last_mut().and_then(|p| p.draws.last_mut()).expect("a tone map");
            let exposure = f32::from_le_bytes(tone_map.uniform_bytes[..4].try_into().expect("four bytes"));
            tone_map.uniform_bytes[..4].copy_from_slice(&(1.4 * exposure).to_le_bytes());
            let (other, _) = gpu.render(&brighter, session.library(), FrameImages::Display).expect("drawn");
            assert!(exceeds_bounds(&soft.difference(&image(other)).expect("one size")), "half a stop is not detected");
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn pairs_of_key_values_match_the_software_renderer() {
    let Some(gpu) = gpu() else { return };
    // `lowering` translates shaders to programs of the software renderer.
    let library = ShaderLibrary::in_memory(lowering());
    let software = SoftwareRenderer::new(Options::default()).expect("starts");
    // Every fifth key of the covering set of pairs in a full run, every sixtieth otherwise: a driver takes a second or more to compile
    // each.
    let step = if sweep::in_full() { 5 } else { 60 };
    let keys: Vec<_> = covering_keys(2).into_iter().filter(|k| k.features().view != PixelView::Cost).step_by(step).collect();
    assert!(keys.len() * step > 50);
    let (mut failures, mut not_drawn) = (Vec::new(), None);
    for key in &keys {
        // A sample body drawn with this key; the last argument is half the image's side in body radii.
        let side_px = 40;
        let plan = sample_body_plan(&library, key, side_px, SAMPLE_HALF_SIDE_WITH_LIMB).expect("a plan");
        let (drawn, _) = match gpu.render(&plan, &library, FrameImages::DisplayAndHdr) {
            // The adapter lacks a capability that every linear image needs.
            Err(GpuError::Unsupported(why)) => {
                not_drawn = Some(why);
                break;
            }
            drawn => drawn.expect("drawn"),
        };
        let (soft, _) = software.render(&plan, &library, FrameImages::DisplayAndHdr).expect("drawn");
        let level = |v: f32| (255.0 * v.clamp(0.0, 1.0)).round() as u8;
        let display_image =
            |f: &Frame| DisplayImage { width: f.width, height: f.height, rgba: f.hdr.iter().map(|p| p.map(level)).collect() };
        let difference = display_image(&soft).difference(&display_image(&drawn)).expect("one size");
        println!("{key}: mean {:.4}, 99.9 % {}, greatest {}", difference.mean, difference.p999, difference.max);
        if difference.mean > MEAN_LEVELS || difference.p999 > P999_LEVELS {
            failures.push(format!("{key}: mean {:.3}, 99.9 % {}, greatest {}", difference.mean, difference.p999, difference.max));
        }
    }
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), keys.len(), failures.join("\n"));
    if let Some(why) = not_drawn {
        or_skipped::<()>(Err(why));
    }
}

/// 1e5 radii fit into a pixel, so that the squares of the squares of gradients on the map exceed f32. The negative control, without the shader's
/// limit on gradients, is in tests/software/filtered_map.rs: on a GPU it would prove nothing, because drivers need not propagate NaN.
#[test]
fn a_body_far_smaller_than_a_pixel_has_the_light_of_the_software_renderer() {
    let Some(gpu) = gpu() else { return };
    let session = &*SESSION;
    let request = ViewRequest {
        position: Position::AboveTarget { towards: None, distance_radii: Some(5e6) },
        fov_deg: Some(60.0),
        width: 64,
        height: 64,
        effects: orrery::scene::effects::EffectOverrides::parse("-points").expect("an effect"),
        layers: Layers::parse("-stars,-milky-way,-zodiacal-light").expect("layers"),
        ..ViewRequest::of(NaifId::SUN, Instant::parse("2024-01-01T00:00:00Z").expect("a time"))
    };
    let (_, plan) = session.plan(&request, SAMPLING).expect("a plan");
    let drawn = match gpu.render(&plan, session.library(), FrameImages::DisplayAndHdr) {
        // The adapter lacks a capability that every linear image needs.
        Err(GpuError::Unsupported(why)) => {
            or_skipped::<()>(Err(why));
            return;
        }
        drawn => drawn.expect("drawn").0,
    };
    let (soft, _) = session.renderer().render(&plan, session.library(), FrameImages::DisplayAndHdr).expect("drawn");
    let light = |frame: &Frame| frame.hdr.iter().map(|pixel| f64::from(pixel[0] + pixel[1] + pixel[2])).sum::<f64>();
    let (of_gpu, of_software) = (light(&drawn), light(&soft));
    // Measured 0.4 % on llvmpipe. Without the limit on gradients the light would be NaN.
    assert!(of_software > 0.0 && (of_gpu / of_software - 1.0).abs() < 0.02, "{of_gpu} and {of_software}");
}

#[test]
fn a_lost_device_falls_back_to_software_with_the_same_view() {
    let Some(renderer) = gpu() else { return };
    let (session, messages, _cache) = session(RendererPreference::Gpu);
    let (_, request) = views().into_iter().find(|(name, _)| *name == "moon").expect("in the table");
    let draw = || session.draw(&request, SAMPLING, FrameImages::Display).expect("drawn");
    // The window has no GPU surface, so far; the preference is for what presents its images.
    let no_surface = None;
    assert_eq!(session.presenter_change(no_surface, DisplayPreference::Gpu), PresenterChange::Unchanged, "nothing is open yet");
    let before = draw();
    assert_eq!(before.drawn_by.renderer, "gpu");
    assert_eq!(
        session.presenter_change(no_surface, DisplayPreference::Gpu),
        PresenterChange::Unchanged,
        "a window would wait for the pipelines of its frames"
    );
    // The pipelines of a window's frame are compiled while the software renderer draws it.
    session.draw_without_waiting(&request, SAMPLING, RequestedOutput::Frame(FrameImages::Display)).expect("drawn");
    let mut polls = 0;
    while session.presenter_change(no_surface, DisplayPreference::Gpu) == PresenterChange::Unchanged {
        std::thread::sleep(std::time::Duration::from_millis(5));
        polls += 1;
        assert!(polls < 10_000, "the device never became ready for windows");
    }
    assert_eq!(session.presenter_change(no_surface, DisplayPreference::Gpu), PresenterChange::NewGpu);
    // Automatically a window uses a hardware GPU, but not a software driver (llvmpipe), for which it would wait at each image.
    let is_software = renderer.facts().kind == AdapterKind::Software;
    let automatic = if is_software { PresenterChange::Unchanged } else { PresenterChange::NewGpu };
    assert_eq!(session.presenter_change(no_surface, DisplayPreference::Auto), automatic);
    assert_eq!(session.presenter_change(no_surface, DisplayPreference::Cpu), PresenterChange::Unchanged);
    session.destroy_gpu();
    let after = draw();
    assert_eq!(after.drawn_by.renderer, "software");
    assert_eq!(session.presenter_change(no_surface, DisplayPreference::Gpu), PresenterChange::Unchanged, "no device is left");
    let difference = image(before.frame).difference(&image(after.frame)).expect("one size");
    assert!(!exceeds_bounds(&difference), "a different image: mean {}, 99.9 % {}", difference.mean, difference.p999);
    draw();
    let messages = messages.lock().expect("not poisoned");
    assert!(messages.len() == 1 && messages[0].contains("lost") && messages[0].contains("drawing in software"), "{messages:?}");
}

#[test]
fn a_window_never_blocks_on_shader_compilation() {
    if gpu().is_none() {
        return;
    }
    let (session, messages, _cache) = session(RendererPreference::Gpu);
    let (_, request) = views().into_iter().find(|(name, _)| *name == "moon").expect("in the table");
    let draw = || session.draw_without_waiting(&request, SAMPLING, RequestedOutput::Frame(FrameImages::Display)).expect("drawn");
    let first = draw();
    assert_eq!(first.drawn_by.renderer, "software", "the device was not open yet");
    let mut frames = 0;
    let later = loop {
        let drawn = draw();
        frames += 1;
        if drawn.drawn_by.renderer == "gpu" {
            break drawn;
        }
        assert!(frames < 10_000, "the GPU never became ready: {:?}", messages.lock());
    };
    assert!(!exceeds_bounds(&image(first.frame).difference(&image(later.frame)).expect("one size")));
    assert!(messages.lock().expect("not poisoned").is_empty());
}

#[test]
fn a_window_never_waits_for_background_images() {
    if gpu().is_none() {
        return;
    }
    let (session, messages, _cache) = session(RendererPreference::Gpu);
    let request = ViewRequest { width: 32, height: 32, ..views().swap_remove(0).1 };
    let draw_window =
        || session.draw_without_waiting(&request, SAMPLING, RequestedOutput::Frame(FrameImages::Display)).expect("drawn").drawn_by.renderer;
    let mut frames = 0;
    while draw_window() != "gpu" {
        frames += 1;
        assert!(frames < 10_000, "the GPU never became ready: {:?}", messages.lock());
    }
    // Views whose pipelines are not compiled, so that the driver needs time.
    let background: Vec<ViewRequest> = views().into_iter().skip(1).map(|(_, view)| ViewRequest { width: 64, height: 64, ..view }).collect();
    for view in &background {
        session.plan(view, SAMPLING).expect("planned");
    }
    // Number, from 1, of the image that is drawn in the background; 0 between images.
    let in_progress = AtomicUsize::new(0);
    let window_images = std::thread::scope(|scope| {
        let drawing = scope.spawn(|| {
            for (k, view) in background.iter().enumerate() {
                in_progress.store(k + 1, SeqCst);
                assert_eq!(session.draw_in_background(view, SAMPLING, FrameImages::Display).expect("drawn").drawn_by.renderer, "gpu");
                in_progress.store(0, SeqCst);
            }
        });
        // Window images that began and ended while the same background image was drawn; none if the window waits for background images.
        let mut window_images = 0;
        while !drawing.is_finished() {
            let before = in_progress.load(SeqCst);
            draw_window();
            window_images += usize::from(before != 0 && in_progress.load(SeqCst) == before);
        }
        drawing.join().expect("no panic");
        window_images
    });
    assert!(window_images > 0, "no window image ended before the background image during which it began");
    assert!(messages.lock().expect("not poisoned").is_empty());
}

#[test]
fn readiness_is_reported_between_images_and_the_renderer_changes_at_once() {
    if gpu().is_none() {
        return;
    }
    let (session, messages, _cache) = session(RendererPreference::Software);
    let request = ViewRequest { width: 32, height: 32, ..views().swap_remove(0).1 };
    let renderer_used = |s: &Session| {
        s.draw_without_waiting(&request, SAMPLING, RequestedOutput::Frame(FrameImages::Display)).expect("drawn").drawn_by.renderer
    };
    // `Settled`: nothing is being prepared, here because software draws. `JustReady`: the image should be drawn again.
    assert_eq!((renderer_used(&session), session.readiness()), ("software", Readiness::Settled));
    session.set_renderer_preference(RendererPreference::Gpu);
    assert_eq!(renderer_used(&session), "software", "the window must not wait for a compiler");
    while session.readiness() == Readiness::Preparing {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert_eq!((session.readiness(), renderer_used(&session)), (Readiness::JustReady, "gpu"));
    assert_eq!(session.readiness(), Readiness::Settled);
    session.set_renderer_preference(RendererPreference::Software);
    assert_eq!(renderer_used(&session), "software");
    // Dropping a session while a driver compiles waits for the driver.
    session.set_renderer_preference(RendererPreference::Gpu);
    assert_eq!(renderer_used(&session), "software");
    drop(session);
    assert!(messages.lock().expect("not poisoned").is_empty());
}

#[test]
fn nothing_is_uploaded_twice_and_memory_does_not_grow() {
    let Some(gpu) = gpu() else { return };
    let session = &*SESSION;
    let (_, request) = views().into_iter().find(|(name, _)| *name == "saturn").expect("in the table");
    let plans: Vec<Plan> = (0..12)
        .map(|k| {
            let mut request = ViewRequest { width: 16, height: 16, ..request.clone() };
            request.time = request.time.plus_seconds(600.0 * f64::from(k));
            let effects = if k % 2 == 0 { "" } else { "-ring-shadow" };
            request.effects = orrery::scene::effects::EffectOverrides::parse(effects).expect("effects");
            session.plan(&request, SAMPLING).expect("a plan").1
        })
        .collect();
    let upload_bytes = || -> Vec<u64> {
        plans.iter().map(|plan| gpu.render(plan, session.library(), FrameImages::Display).expect("drawn").1.uploaded_bytes).collect()
    };
    let first = upload_bytes();
    let resources = gpu.resource_use();
    assert!(first[0] > 0, "the first frame must upload its maps");
    assert!(plans[0].passes[0].draws.iter().any(|d| d.textures.iter().any(|t| matches!(t.source, TextureSource::Image(_)))));
    // The scenes differ in time and effects, but all their resources are on the GPU already.
    for repetition in 0..4 {
        let again = upload_bytes();
        assert_eq!(again.iter().sum::<u64>(), 0, "repetition {repetition} uploads again: {again:?}");
        assert_eq!(gpu.resource_use(), resources, "bytes of textures and number of pipelines, repetition {repetition}");
    }
}

#[test]
fn the_gpu_refuses_an_unsupported_plan_and_draws_the_next() {
    let Some(gpu) = gpu() else { return };
    let session = &*SESSION;
    let (_, request) = views().into_iter().find(|(name, _)| *name == "moon").expect("in the table");
    let (_, plan) = session.plan(&request, SAMPLING).expect("a plan");
    let mut too_wide = plan.clone();
    too_wide.passes.iter_mut().for_each(|p| p.width = 1 << 20);
    let refused = gpu.render(&too_wide, session.library(), FrameImages::Display).expect_err("no adapter is that wide");
    assert!(matches!(refused, GpuError::TargetSize { width, .. } if width == 1 << 20) && !refused.is_final(), "{refused}");
    let mut without_textures = plan.clone();
    without_textures.passes[0].draws.iter_mut().for_each(|d| d.textures.clear());
    let refused = gpu.render(&without_textures, session.library(), FrameImages::Display).expect_err("a map is missing");
    assert!(matches!(&refused, GpuError::Draw { what, .. } if what.contains("not supplied")), "{refused}");
    gpu.render(&plan, session.library(), FrameImages::Display).expect("the device still works after a refused plan");
}

/// A draw without instances or without triangles changes nothing. wgpu panics at its empty buffers, so it must not get there.
#[test]
fn an_empty_draw_is_skipped() {
    fn is_instanced(draw: &PlanDraw) -> bool {
        !draw.instances.attributes.is_empty()
    }
    fn with_edited_draws(plan: &Plan, edit: fn(&mut PlanDraw)) -> Plan {
        let mut edited = plan.clone();
        for draw in edited.passes.iter_mut().flat_map(|p| &mut p.draws) {
            if is_instanced(draw) {
                edit(draw);
            }
        }
        edited
    }
    let Some(gpu) = gpu() else { return };
    let session = &*SESSION;
    let plan = views()
        .into_iter()
        .map(|(_, request)| session.plan(&request, SAMPLING).expect("a plan").1)
        .find(|plan| plan.passes.iter().flat_map(|p| &p.draws).any(is_instanced))
        .expect("a view with stars or points");
    let image_of = |plan: &Plan| gpu.render(plan, session.library(), FrameImages::Display).expect("drawn").0;
    let mut without_instanced_draws = plan.clone();
    without_instanced_draws.passes.iter_mut().for_each(|p| p.draws.retain(|d| !is_instanced(d)));
    let without_instances = with_edited_draws(&plan, |draw| {
        draw.instances.count = 0;
        draw.instances.attributes.iter_mut().for_each(|a| a.values = Arc::default());
    });
    let without_triangles =
        with_edited_draws(&plan, |draw| draw.vertices = Vertices::Mesh { attributes: Vec::new(), indices: Arc::default() });
    let expected = image_of(&without_instanced_draws);
    assert!(image_of(&without_instances) == expected && image_of(&without_triangles) == expected);
}

/// Resident memory of this process, bytes; `None` if the system does not report it.
fn resident_bytes() -> Option<u64> {
    const PAGE_BYTES: u64 = 4096;
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(PAGE_BYTES * text.split_whitespace().nth(1)?.parse::<u64>().ok()?)
}

/// Run it with `cargo test --test main ten_thousand -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn ten_thousand_frames_grow_no_memory() {
    let Some(gpu) = gpu() else { return };
    let session = &*SESSION;
    let (_, saturn) = views().into_iter().find(|(name, _)| *name == "saturn").expect("in the table");
    let effects = ["", "-ring-shadow", "-rings", "-body-shadow", "-albedo"];
    let mut after_1000 = None;
    for k in 0..10_000_u32 {
        let mut request = ViewRequest { width: 32, height: 32, ..saturn.clone() };
        request.time = request.time.plus_seconds(60.0 * f64::from(k));
        let effects = effects[k as usize % effects.len()];
        request.effects = orrery::scene::effects::EffectOverrides::parse(effects).expect("effects");
        let (_, plan) = session.plan(&request, SAMPLING).expect("a plan");
        gpu.render(&plan, session.library(), FrameImages::Display).expect("drawn");
        if k % 1000 == 999 {
            let now = (gpu.resource_use(), resident_bytes());
            println!("{k}: {} bytes of textures, {} pipelines, {:?} bytes resident", now.0.0, now.0.1, now.1);
            let (held, resident) = *after_1000.get_or_insert(now);
            assert_eq!(gpu.resource_use().0, held.0, "textures grow");
            assert!(gpu.resource_use().1 <= held.1 + 4, "pipelines grow");
            if let (Some(before), Some(now)) = (resident, now.1) {
                assert!(now < before + 32_000_000, "{before} bytes after 1,000 frames, {now} after {k}");
            }
        }
    }
}
