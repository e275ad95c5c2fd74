//! If the first image cannot be drawn, the window and the messages for standard error give the reason, and the window keeps running. If a later
//! one fails, the exposure still reaches its metered value.

use super::interface::{CpuTestRenderer, harness_of, interface, session, settle};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::session::{Session, SessionError, Sources};
use orrery::time::Instant;
use orrery::view::app::body_positions::SessionPositions;
use orrery::view::app::initial_view::initial_view;
use orrery::view::app::settings::Settings;
use orrery::view::app::view_state::CameraPose;
use orrery::view::app::viewer::{SelectableBody, Viewer};
use orrery::view::language::Language;
use orrery::view::panels::Interface;
use orrery::view::window::cpu_painter::Painter;
use orrery::view::worker::render_worker::{FailedJob, InlineWorker, RenderJob, RenderWorker, RenderedView, Task};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

type Messages = Arc<Mutex<Vec<String>>>;

/// A session whose fragments may come from a folder, its messages, and the interface of a new window that shows the Moon at this time.
fn open_session(shaders: Option<&Path>, utc: &str) -> (&'static Session, Messages, Interface) {
    let messages = Messages::default();
    let sink = Arc::clone(&messages);
    let cache = tempfile::tempdir().expect("a folder").keep();
    let sources = Sources { cache: Some(cache), shaders: shaders.map(Path::to_owned), ..Sources::default() };
    let session = Session::open(&sources, move |line| sink.lock().expect("no panic").push(line.to_owned())).expect("a session");
    // The harness needs a session that lives until the process ends.
    let session: &'static Session = Box::leak(Box::new(session));
    let catalog = session.catalog();
    let view = initial_view(catalog, &SessionPositions(session), NaifId::MOON, Instant::parse(utc).expect(utc)).expect("a view");
    let bodies = catalog.bodies().iter().map(SelectableBody::of).collect();
    let mut viewer = Viewer::new(bodies, view, || Instant::from_tdb_seconds_past_j2000(0.0));
    viewer.time_rate.toggle_pause();
    (session, messages, Interface::new(viewer, Settings::default()))
}

/// Checks that the reason contains `part`, that a label of the window shows it, and that it was reported once.
fn assert_reported_once(session: &'static Session, messages: &Messages, interface: Interface, part: &str) {
    let mut harness = harness_of(session, interface);
    settle(&mut harness);
    assert!(harness.state().shown().is_none());
    let reason = harness.state().message_line().to_owned();
    assert!(reason.contains(part) && !reason.contains('\n'), "{reason}");
    assert!(harness.query_by_label(&reason).is_some(), "no label says: {reason}");
    assert_eq!(*messages.lock().expect("no panic"), [reason]);
}

#[test]
fn a_time_outside_the_ephemeris_is_reported() {
    let (session, messages, interface) = open_session(None, "9999-12-31T00:00:00Z");
    assert_reported_once(session, &messages, interface, "Moon from -3001-11-23 to 3001-01-08, not at 9999-12-31T00:00:00Z");
}

/// The reply to an action is shown although there is no image of the view.
#[test]
fn a_reply_is_shown_below_the_reason() {
    let (session, _, interface) = open_session(None, "9999-12-31T00:00:00Z");
    let mut harness = harness_of(session, interface);
    settle(&mut harness);
    let reason = harness.state().message_line().to_owned();
    harness.event(egui::Event::Copy);
    harness.run_steps(2);
    let reply = harness.state().reply_text().to_owned();
    assert!(!reply.is_empty() && harness.state().message_line() == reason);
    assert!(harness.query_by_label(&format!("{reason}\n{reply}")).is_some(), "{reply} is not shown");
}

/// The time for which the window waits until its next frame, unless there is input.
fn repaint_delay(harness: &Harness<'static, Interface>) -> Duration {
    harness.output().viewport_output.get(&egui::ViewportId::ROOT).expect("the window").repaint_delay
}

#[test]
fn a_window_without_its_first_image_is_at_rest() {
    let (session, _, interface) = open_session(None, "9999-12-31T00:00:00Z");
    let mut harness = harness_of(session, interface);
    settle(&mut harness);
    assert!(harness.state().shown().is_none());
    assert!(repaint_delay(&harness) > Duration::ZERO, "the window draws frame after frame");
}

/// Time runs on towards the span of the ephemeris although the view cannot be drawn; away from it time is paused.
#[test]
fn time_runs_only_towards_the_ephemeris_outside_it() {
    let mut harness = harness_of(session(), interface(NaifId::MOON, "2024-01-25T00:00:00Z"));
    settle(&mut harness);
    // 31 700 years after J2000 there is no orientation of any body.
    harness.state_mut().viewer.view.tdb_s = 1e12;
    harness.event(egui::Event::Text("j".into()));
    settle(&mut harness);
    let state = harness.state();
    assert!(!state.message_line().is_empty() && !state.viewer.time_rate.is_paused() && state.viewer.view.tdb_s < 1e12);
    let delay = repaint_delay(&harness);
    assert!(delay <= Duration::from_secs(1), "the next frame is due in {delay:?}");
    harness.state_mut().viewer.view.tdb_s = 1e12;
    harness.event(egui::Event::Text("l".into()));
    settle(&mut harness);
    let state = harness.state();
    assert!(!state.message_line().is_empty() && state.viewer.time_rate.is_paused() && state.viewer.view.tdb_s <= 1e12);
}

/// The clock once ran on beyond the ephemeris, while the image stayed as it was and the reason changed in every frame.
#[test]
fn the_clock_stops_at_the_ends_of_the_ephemeris() {
    for (start, key, reason) in [("3001-01-01T00:00:00Z", "l", "to 3001-01-08T"), ("-3001-12-01T00:00:00Z", "j", "from -3001-11-23T")] {
        let mut harness = harness_of(session(), interface(NaifId::MOON, start));
        settle(&mut harness);
        harness.event(egui::Event::Text(key.into()));
        harness.run_steps(2);
        // To a week a second.
        for _ in 0..7 {
            harness.event(egui::Event::Text(".".into()));
            harness.run_steps(1);
        }
        for _ in 0..3 {
            settle(&mut harness);
        }
        let state = harness.state();
        let (stopped_tdb_s, reply) = (state.viewer.view.tdb_s, state.reply_text().to_owned());
        assert!(state.viewer.time_rate.is_paused() && reply.contains(reason), "{start}: {reply}");
        // The image is that of the end: the reply is the message, not a reason why there is no image.
        assert_eq!(state.message_line(), reply);
        let shown_tdb_s = state.shown().expect("an image").scene.time.tdb_seconds_past_j2000();
        assert!((shown_tdb_s - stopped_tdb_s).abs() < 1e-3, "{start}: the image is {} s off", shown_tdb_s - stopped_tdb_s);
        // Less than the light times of Moon and Sun from the end, with 2 s for rounding.
        let end_tdb_s = if key == "l" { 3001.0 - 2000.0 } else { -3000.0 - 2000.0 } * 365.25 * 86_400.0;
        assert!((stopped_tdb_s - end_tdb_s).abs() < 600.0, "{start}: {} s from the end", stopped_tdb_s - end_tdb_s);
        // A step beyond the end is taken, and the message says from when to when there is an image.
        let beyond = if key == "l" { "+d" } else { "-d" };
        harness.get_by_label(beyond).click_accesskit();
        harness.run_steps(4);
        let message = harness.state().message_line();
        assert!(message.contains("from -3001-11-23") && message.contains("to 3001-01-08"), "{message}");
    }
}

/// The window gives the reason in its language; the message for standard error gives it in English, and once.
#[test]
fn a_german_window_gives_the_reason_in_german() {
    let (session, messages, mut interface) = open_session(None, "9999-12-31T00:00:00Z");
    interface.language = Language::German;
    let mut harness = harness_of(session, interface);
    settle(&mut harness);
    let reason = harness.state().message_line().to_owned();
    assert!(reason.starts_with("Zeitraum der Quellen für Mond: 23. November 3002 v. Chr. (greg.) bis 8. Januar 3001, nicht "), "{reason}");
    assert!(harness.query_by_label(&reason).is_some(), "no label says: {reason}");
    let reported = messages.lock().expect("no panic").clone();
    let is_english = |line: &str| line.contains("Moon from -3001-11-23 to 3001-01-08, not at 9999-12-31T00:00:00Z");
    assert!(reported.len() == 1 && is_english(&reported[0]) && !is_english(&reason), "{reported:?}");
}

#[test]
fn a_fragment_that_does_not_compile_is_reported_and_a_valid_one_is_silent() {
    let folder = tempfile::tempdir().expect("a folder");
    let (name, text) = orrery::shader::fragments::FRAGMENTS.iter().find(|(name, _)| *name == "entry/tone_map.wesl").expect("a fragment");
    let path = folder.path().join(name);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    std::fs::write(&path, text.replace("@fragment", "@fragment nonsense")).expect("a file");
    let (session, messages, interface) = open_session(Some(folder.path()), "2024-01-01T00:00:00Z");
    assert_reported_once(session, &messages, interface, "tone_map");
    let (valid, messages, interface) = open_session(None, "2024-01-01T00:00:00Z");
    let mut harness = harness_of(valid, interface);
    settle(&mut harness);
    assert!(
        harness.state().shown().is_some() && harness.state().message_line().is_empty() && messages.lock().expect("no panic").is_empty()
    );
}

/// Draws immediately; while `fails` is set, there is an error in place of each image.
struct FailingWorker {
    inner: InlineWorker<'static>,
    fails: Arc<AtomicBool>,
}

impl RenderWorker for FailingWorker {
    fn session(&self) -> &Session {
        self.inner.session()
    }
    fn submit(&self, job: RenderJob) {
        self.inner.submit(job);
    }
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        let image = self.inner.take()?;
        if !self.fails.load(Ordering::Relaxed) {
            return Some(image);
        }
        let why = SessionError::File { path: "map.jpg".to_owned(), why: "cannot be read".to_owned() };
        Some(image.and_then(|image| Err(FailedJob { why, exposure_ticket: image.job.exposure_ticket })))
    }
    fn run(&self, task: Task) {
        self.inner.run(task);
    }
}

/// A window that shows the Moon, and the flag of its [`FailingWorker`].
fn window_that_may_fail() -> (Harness<'static, Interface>, Arc<AtomicBool>) {
    let fails = Arc::<AtomicBool>::default();
    let worker = FailingWorker { inner: InlineWorker::new(session()), fails: Arc::clone(&fails) };
    let mut harness = Harness::builder()
        .with_size([700.0, 400.0])
        .with_max_steps(40)
        .renderer(CpuTestRenderer(Painter::default()))
        .build_ui_state(move |ui, interface: &mut Interface| interface.ui(ui, &worker), interface(NaifId::MOON, "2024-01-25T00:00:00Z"));
    settle(&mut harness);
    (harness, fails)
}

/// The reason stayed in the previous language until another view was chosen.
#[test]
fn the_reason_is_in_the_new_language_after_a_change() {
    let (mut harness, fails) = window_that_may_fail();
    fails.store(true, Ordering::Relaxed);
    harness.state_mut().viewer.view.fov_deg *= 0.5;
    settle(&mut harness);
    let english = harness.state().message_line().to_owned();
    harness.state_mut().language = Language::German;
    settle(&mut harness);
    let german = harness.state().message_line();
    assert!(english.contains("map.jpg") && german.contains("map.jpg") && english != german, "{english}, then {german}");
}

#[test]
fn the_exposure_adapts_although_an_image_fails() {
    let (mut harness, fails) = window_that_may_fail();
    let run_frame = |harness: &mut Harness<'static, Interface>| {
        let next = harness.input_mut().time.unwrap_or(0.0) + 0.02;
        harness.input_mut().time = Some(next);
        harness.run_steps(1);
    };
    let has_metered_exposure = |harness: &Harness<'static, Interface>| {
        let exposure = &harness.state().shown().expect("an image").scene.exposure;
        exposure.stops == exposure.metered_stops
    };
    assert!(has_metered_exposure(&harness));
    // To the night side of the Moon and back to the day side.
    for _ in 0..2 {
        let CameraPose::Orbit { azimuth_deg, .. } = &mut harness.state_mut().viewer.view.camera_pose else {
            panic!("the camera must be in orbit")
        };
        *azimuth_deg += 180.0;
        run_frame(&mut harness);
    }
    run_frame(&mut harness);
    assert!(!has_metered_exposure(&harness), "a fiftieth of a second after the night");
    fails.store(true, Ordering::Relaxed);
    run_frame(&mut harness);
    assert!(harness.state().message_line().contains("map.jpg"), "{}", harness.state().message_line());
    fails.store(false, Ordering::Relaxed);
    settle(&mut harness);
    assert!(has_metered_exposure(&harness) && harness.state().message_line().is_empty());
}
