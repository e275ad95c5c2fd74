//! The window's interface without a window: tests use the controls by their accessible names, and the CPU painter paints the screen. Other tests of the
//! window use the session, the interface and the harness of this file.

use crate::support::sweep;
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, TestRenderer};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::request::{Quality, ViewRequest};
use orrery::session::{RequestedOutput, Session, Sources};
use orrery::time::Instant;
use orrery::view::app::body_positions::{BodyPositions, SessionPositions};
use orrery::view::app::exposure_adaptation::ExposureTicket;
use orrery::view::app::settings::{HintsFollowed, PanelLayout, Settings};
use orrery::view::app::view_state::ViewState;
use orrery::view::app::viewer::{SelectableBody, Viewer};
use orrery::view::link::view_from_text;
use orrery::view::panels::{Interface, Tab};
use orrery::view::window::cpu_painter::{Canvas, Painter};
use orrery::view::worker::render_worker::{FailedJob, InlineWorker, RenderJob, RenderWorker, RenderedView, Task, ThreadedWorker};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, OnceLock};

/// One session for all tests: maps and modules are read once.
pub fn session() -> &'static Session {
    static SESSION: OnceLock<Session> = OnceLock::new();
    SESSION.get_or_init(|| {
        let cache = tempfile::tempdir().expect("a folder").keep();
        let sources = Sources { cache: Some(cache), ..Sources::default() };
        Session::open(&sources, |line| panic!("{line}")).expect("a session")
    })
}

const SATURN: NaifId = NaifId(699);

/// An interface that looks at a body from its lit side, paused, in draft quality.
pub fn interface(target: NaifId, utc: &str) -> Interface {
    let session = session();
    let time = Instant::parse(utc).expect(utc);
    let catalog = session.catalog();
    let bodies = orrery::ephemeris::body_order::bodies_in_usual_order(catalog, session.ephemeris());
    let bodies = bodies.into_iter().filter_map(|id| catalog.body(id)).map(SelectableBody::of);
    let positions = SessionPositions(session);
    let radius_km = catalog.body(target).expect("a body").radii_km.x;
    let sunward = positions.geometric_vector_km(target, NaifId::SUN, time).expect("a place").try_normalize().unwrap_or(glam::DVec3::X);
    let pole = positions.body_from_icrf(target, time).expect("an orientation").row(2);
    let mut view = ViewState::around(target, (sunward + 0.4 * pole) * 4.0 * radius_km, radius_km, pole, time);
    view.quality = Quality::Draft;
    let mut viewer = Viewer::new(bodies.collect(), view, || Instant::from_tdb_seconds_past_j2000(0.0));
    viewer.time_rate.toggle_pause();
    // Hints would put bright text over the sky, whose pixels some tests measure.
    let hints_followed = HintsFollowed { drag: true, scroll: true, search: true };
    // *What to see now* and the timeline cost time, so only the tests about them show them.
    let panels = PanelLayout { now_shown: false, timeline_shown: false, ..PanelLayout::default() };
    Interface::new(viewer, Settings { hints_followed, panels, ..Settings::default() })
}

/// Paints the harness's images with the window's CPU painter instead of wgpu.
pub struct CpuTestRenderer(pub Painter);

impl TestRenderer for CpuTestRenderer {
    fn handle_delta(&mut self, delta: &mut egui::TexturesDelta) {
        for (id, deltas) in delta.set.drain() {
            deltas.into_iter().for_each(|d| self.0.set_texture(id, d));
        }
        delta.free.drain().for_each(|id| self.0.free_texture(id));
    }
    fn render(&mut self, ctx: &egui::Context, output: &egui::FullOutput) -> Result<image::RgbaImage, String> {
        let size = ctx.content_rect().size() * output.pixels_per_point;
        let (width, height) = (size.x.round() as usize, size.y.round() as usize);
        let mut pixels = vec![0; width * height];
        let primitives = ctx.tessellate(output.shapes.clone(), output.pixels_per_point);
        self.0.paint(&mut Canvas { width, height, pixels: &mut pixels }, output.pixels_per_point, &primitives);
        let bytes = pixels.iter().flat_map(|p| [(p >> 16) as u8, (p >> 8) as u8, *p as u8, 255]).collect();
        image::RgbaImage::from_raw(width as u32, height as u32, bytes).ok_or_else(|| "the size is wrong".into())
    }
}

pub fn harness(interface: Interface) -> Harness<'static, Interface> {
    harness_of(session(), interface)
}

pub fn harness_of(session: &'static Session, interface: Interface) -> Harness<'static, Interface> {
    let worker = InlineWorker::new(session);
    Harness::builder()
        .with_size([1100.0, 640.0])
        .with_max_steps(40)
        .renderer(CpuTestRenderer(Painter::default()))
        .build_ui_state(move |ui, interface: &mut Interface| interface.ui(ui, &worker), interface)
}

/// Advances time until the interface is at rest and its full-resolution image has arrived.
pub fn settle(harness: &mut Harness<'static, Interface>) {
    // Flights, expansions and the full-resolution image take less than three seconds.
    for _ in 0..14 {
        harness.run_steps(1);
        harness.input_mut().predicted_dt = 0.25;
        let next = harness.input_mut().time.unwrap_or(0.0) + 0.25;
        harness.input_mut().time = Some(next);
    }
    harness.run_steps(2);
}

/// No panel, and each panel; in a short run a third of these and the last panel, so that a new one is always tested.
pub fn swept_tabs() -> Vec<Option<Tab>> {
    let tabs = std::iter::once(None).chain(Tab::ALL.map(Some));
    tabs.enumerate().filter(|(k, tab)| sweep::runs(*k, 3) || *tab == Tab::ALL.last().copied()).map(|(_, tab)| tab).collect()
}

/// Width and height of the image of the sky.
fn sky_size_px(harness: &Harness<'static, Interface>) -> (u32, u32) {
    let d = harness.state().shown().expect("an image");
    (d.width, d.height)
}

#[test]
fn saturn_is_found_by_search_and_flown_to() {
    let mut harness = harness(interface(NaifId::EARTH, "2017-05-17T00:00:00Z"));
    harness.run_steps(2);
    harness.get_by_role_and_label(egui::accesskit::Role::TextInput, "Search").focus();
    harness.run_steps(1);
    harness.get_by_role_and_label(egui::accesskit::Role::TextInput, "Search").type_text("satu");
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(1);
    assert!(harness.state().viewer.is_flying());
    settle(&mut harness);
    assert_eq!(harness.state().viewer.view.target, SATURN);
    let rendered = harness.state().shown().expect("an image");
    let saturn = rendered.scene.body(SATURN).expect("Saturn");
    assert!(saturn.diameter_px > 150.0, "{} px", saturn.diameter_px);
    assert!(harness.state().settings.recent.len() == 1, "the view that was left is remembered");
}

#[test]
fn an_effect_switched_off_changes_the_image_and_says_so() {
    let mut harness = harness(interface(SATURN, "2017-05-17T00:00:00Z"));
    settle(&mut harness);
    let before = harness.render().expect("an image");
    assert!(sky_size_px(&harness).0 > 300);
    harness.state_mut().tab = Some(Tab::Effects);
    settle(&mut harness);
    let toggle = harness.get_by_role_and_label(egui::accesskit::Role::CheckBox, "ring-shadow");
    assert_eq!(toggle.accesskit_node().toggled(), Some(egui::accesskit::Toggled::True));
    toggle.click();
    settle(&mut harness);
    assert_eq!(harness.state().viewer.view.effects.to_text(), "-ring-shadow");
    let decisions = harness.state().shown().expect("an image").scene.body(SATURN).expect("Saturn").decisions.clone();
    let shadow = decisions.iter().find(|d| d.effect == "ring-shadow").expect("a decision");
    assert!(!shadow.on);
    harness.state_mut().tab = None;
    settle(&mut harness);
    let after = harness.render().expect("an image");
    let changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(x, y)| x.abs_diff(y) > 4)).count();
    let all = (before.width() * before.height()) as usize;
    assert!(changed > 200 && changed < all / 4, "{changed} of {all} pixels changed");
    // *Reset to automatic* withdraws it.
    harness.state_mut().tab = Some(Tab::Effects);
    settle(&mut harness);
    harness.get_by_label("Reset to automatic").click();
    settle(&mut harness);
    assert_eq!(harness.state().viewer.view.effects.to_text(), "");
}

#[test]
fn a_moment_is_one_click_away() {
    let mut harness = harness(interface(NaifId(499), "2000-01-01T12:00:00Z"));
    harness.state_mut().tab = Some(Tab::Moments);
    settle(&mut harness);
    // The button is below the thumbnails of *What to see now*, perhaps out of view.
    harness.get_by_label("Total eclipse over North America").click_accesskit();
    settle(&mut harness);
    let state = harness.state();
    assert_eq!(state.viewer.view.target, NaifId::EARTH);
    assert!(state.viewer.view.time().to_utc_iso().starts_with("2024-04-08T18:17:1"));
    assert!(state.viewer.time_rate.is_paused());
    let earth = state.shown().expect("an image").scene.body(NaifId::EARTH).expect("the Earth").clone();
    assert!(earth.decisions.iter().any(|d| d.effect == "eclipse" && d.on), "{:?}", earth.decisions);
    // Back returns to Mars.
    harness.get_by_label("Back").click();
    settle(&mut harness);
    assert_eq!(harness.state().viewer.view.target, NaifId(499));
}

#[test]
fn time_is_typed_and_stepped_and_an_invalid_time_is_refused() {
    let mut harness = harness(interface(SATURN, "2017-05-17T00:00:00Z"));
    settle(&mut harness);
    let enter = |h: &mut Harness<'static, Interface>, text: &str| {
        let name = "Date and time";
        h.get_by_role_and_label(egui::accesskit::Role::TextInput, name).focus();
        h.run_steps(1);
        h.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
        h.run_steps(1);
        h.get_by_role_and_label(egui::accesskit::Role::TextInput, name).type_text(text);
        h.run_steps(2);
    };
    enter(&mut harness, "1999-08-11T11:03:05Z");
    harness.key_press(egui::Key::Enter);
    settle(&mut harness);
    assert!(harness.state().viewer.view.time().to_utc_iso().starts_with("1999-08-11T11:03:0"), "{}", harness.state().reply_text());
    harness.get_by_label("+d").click();
    settle(&mut harness);
    assert!(harness.state().viewer.view.time().to_utc_iso().starts_with("1999-08-12T11:03:0"));
    enter(&mut harness, "next Tuesday");
    harness.key_press(egui::Key::Enter);
    harness.run_steps(1);
    assert!(harness.state().reply_text().contains("next Tuesday"), "{}", harness.state().reply_text());
    assert!(harness.state().viewer.view.time().to_utc_iso().starts_with("1999-08-12T11:03:0"));
    // A valid time removes the message about the invalid one.
    enter(&mut harness, "1999-08-13");
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    assert!(harness.state().viewer.view.time().to_utc_iso().starts_with("1999-08-13T00:00:0"));
    assert_eq!(harness.state().reply_text(), "");
}

#[test]
fn the_camera_stands_on_the_ground_or_at_another_body() {
    use orrery::view::app::view_state::CameraPose;
    let mut harness = harness(interface(NaifId::EARTH, "2024-04-08T18:17:16Z"));
    settle(&mut harness);
    harness.get_by_label("Stand on surface").click();
    settle(&mut harness);
    let state = harness.state();
    assert!(matches!(state.viewer.view.camera_pose, CameraPose::Ground { body: NaifId::EARTH, .. }));
    assert!(state.message_line().is_empty() && state.shown().is_some(), "{}", state.message_line());
    harness.get_by_role_and_label(egui::accesskit::Role::ComboBox, "View from").click();
    harness.run_steps(2);
    harness.get_by_label("Centre of Mars").click();
    settle(&mut harness);
    let state = harness.state();
    assert_eq!(state.viewer.view.camera_pose, CameraPose::Centre { body: NaifId(499) });
    let earth = state.shown().expect("an image").scene.body(NaifId::EARTH).expect("the Earth").clone();
    assert!(earth.distance_km > 5e7, "{} km", earth.distance_km);
}

#[test]
fn the_information_panel_describes_the_selected_body() {
    let mut harness = harness(interface(SATURN, "2017-05-17T00:00:00Z"));
    harness.state_mut().tab = Some(Tab::Information);
    settle(&mut harness);
    for label in ["distance", "illuminated", "right ascension", "rise"] {
        harness.get_by_label(label);
    }
    harness.state_mut().tab = Some(Tab::Performance);
    settle(&mut harness);
    harness.get_by_label("bodies shown");
}

#[test]
fn every_panel_fits_the_window_and_names_its_controls() {
    let mut harness = harness(interface(SATURN, "2017-05-17T00:00:00Z"));
    for tab in Tab::ALL {
        harness.state_mut().tab = Some(tab);
        settle(&mut harness);
        let (width, _) = sky_size_px(&harness);
        assert!(width > 150, "{}: the sky keeps {width} pixels", tab.title());
        // The harness itself rejects a control without a name and a glyph that no font has.
        let image = harness.render().expect("an image");
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("viewer");
        std::fs::create_dir_all(&folder).expect("a folder");
        image.save(folder.join(format!("{}.png", tab.title().to_lowercase()))).expect("a file");
    }
    harness.state_mut().tab = None;
    harness.state_mut().help_shown = true;
    settle(&mut harness);
    harness.get_by_label("Double-click, g");
}

#[test]
fn a_link_restores_the_view_in_another_window() {
    let mut first = harness(interface(SATURN, "2017-05-17T00:00:00Z"));
    settle(&mut first);
    let link = first.state().viewer.view.to_link();
    let mut second = harness(interface(NaifId::EARTH, "2000-01-01T12:00:00Z"));
    settle(&mut second);
    let view = view_from_text(&link, session(), Instant::from_tdb_seconds_past_j2000(0.0)).expect("a link");
    second.state_mut().show(view, &InlineWorker::new(session()));
    settle(&mut second);
    let images = [&mut first, &mut second].map(|h| h.state().shown().expect("an image").job.request.clone());
    assert_eq!(images[0], images[1]);
}

#[test]
fn a_window_of_zero_size_draws_nothing_and_recovers() {
    let mut harness = harness(interface(SATURN, "2017-05-17T00:00:00Z"));
    settle(&mut harness);
    harness.set_size(egui::vec2(1.0, 1.0));
    harness.run_steps(3);
    harness.set_size(egui::vec2(900.0, 500.0));
    settle(&mut harness);
    assert!(sky_size_px(&harness).0 > 300);
    // The panels have their widths again.
    assert!(harness.get_by_label_contains("The sky:").rect().left() > 165.0);
}

#[test]
fn an_image_does_not_wait_for_a_query() {
    let (wake_sender, wakes) = std::sync::mpsc::channel();
    let worker = ThreadedWorker::new(session(), move || {
        let _ = wake_sender.send(());
    });
    let (release, released) = std::sync::mpsc::channel::<()>();
    let request =
        ViewRequest { width: 16, height: 16, ..ViewRequest::of(NaifId::MOON, Instant::parse("2024-04-08T18:17:16Z").expect("a time")) };
    let (drawn, answered) = std::thread::scope(|scope| {
        scope.spawn(|| worker.render_until_closed());
        scope.spawn(|| worker.run_tasks_until_closed());
        // A query that runs until it is released.
        worker.run(Box::new(move |_| {
            let _ = released.recv();
        }));
        worker.submit(RenderJob {
            sampling: SamplingQuality::of(request.quality),
            request: request.clone(),
            output: RequestedOutput::Frame(FrameImages::Display),
            exposure_ticket: ExposureTicket::default(),
        });
        let timeout = std::time::Duration::from_secs(120);
        // The window is woken when this image arrives, and not before.
        assert!(worker.is_drawing(), "an image is on its way");
        let arrived = wakes.recv_timeout(timeout).is_ok();
        assert!(!worker.is_drawing(), "the image has arrived; the query does not count as drawing");
        let drawn = arrived && worker.take().is_some_and(|d| d.is_ok_and(|d| d.width == 16));
        drop(release);
        let answered = wakes.recv_timeout(timeout).is_ok();
        worker.close();
        (drawn, answered)
    });
    assert!(drawn, "the image waited for the query");
    assert!(answered, "the query was not answered after its release");
}

/// Counts the requested images.
struct CountingWorker(InlineWorker<'static>, Arc<AtomicU32>);

impl RenderWorker for CountingWorker {
    fn session(&self) -> &Session {
        self.0.session()
    }
    fn submit(&self, job: RenderJob) {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.submit(job);
    }
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        self.0.take()
    }
    fn run(&self, task: Task) {
        self.0.run(task);
    }
}

#[test]
fn real_time_needs_few_images() {
    let mut interface = interface(SATURN, "2017-05-17T00:00:00Z");
    interface.viewer.time_rate.toggle_pause();
    assert_eq!(interface.viewer.time_rate.rate(), 1.0);
    let image_count: Arc<AtomicU32> = Arc::default();
    let worker = CountingWorker(InlineWorker::new(session()), Arc::clone(&image_count));
    let mut harness = Harness::builder()
        .with_size([700.0, 400.0])
        .with_max_steps(40)
        .renderer(CpuTestRenderer(Painter::default()))
        .build_ui_state(move |ui, interface: &mut Interface| interface.ui(ui, &worker), interface);
    settle(&mut harness);
    let run_frames = |harness: &mut Harness<'static, Interface>, count: u32, step_s: f64| {
        let (count_before, tdb_before_s) = (image_count.load(Ordering::Relaxed), harness.state().viewer.view.tdb_s);
        for _ in 0..count {
            let next = harness.input_mut().time.unwrap_or(0.0) + step_s;
            harness.input_mut().time = Some(next);
            harness.run_steps(1);
        }
        (image_count.load(Ordering::Relaxed) - count_before, harness.state().viewer.view.tdb_s - tdb_before_s)
    };
    // Ten frames a second for six seconds: at most one image per second.
    let (images, elapsed_s) = run_frames(&mut harness, 60, 0.1);
    assert!((1..=7).contains(&images), "{images} images in six seconds");
    assert!((elapsed_s - 6.0).abs() < 0.2, "{elapsed_s} s went by in six");
    // The window itself redraws once a second.
    let (_, elapsed_s) = run_frames(&mut harness, 10, 1.0);
    assert!((elapsed_s - 10.0).abs() < 0.2, "{elapsed_s} s went by in ten");
    // A change of the view is drawn at once.
    harness.state_mut().viewer.view.fov_deg *= 0.9;
    assert!(run_frames(&mut harness, 1, 0.05).0 == 1, "the view changed and no image was requested");
}
