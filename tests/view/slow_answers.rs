//! A window on a busy machine, where answers to queries, and images, arrive late: nothing moves under the pointer or loses the focus when they do, and they do
//! not replace what the user has chosen since.

use crate::view::input::{SATURN, TIME, Window, type_text};
use crate::view::interface::{CpuTestRenderer, harness, interface, session, settle};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::scene::effects::EffectOverrides;
use orrery::session::Session;
use orrery::view::panels::{Interface, Tab};
use orrery::view::window::cpu_painter::Painter;
use orrery::view::worker::render_worker::{FailedJob, InlineWorker, RenderJob, RenderWorker, RenderedView, Task};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// Draws images at once, but answers queries only once `may_answer` is set.
struct SlowAnswers {
    inline: InlineWorker<'static>,
    waiting: Mutex<Vec<Task>>,
    may_answer: Arc<AtomicBool>,
}

impl RenderWorker for SlowAnswers {
    fn session(&self) -> &Session {
        self.inline.session()
    }
    fn submit(&self, job: RenderJob) {
        self.inline.submit(job);
    }
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        if self.may_answer.load(Ordering::Relaxed) {
            let tasks = std::mem::take(&mut *self.waiting.lock().expect("a list"));
            tasks.into_iter().for_each(|task| self.inline.run(task));
        }
        self.inline.take()
    }
    fn run(&self, task: Task) {
        self.waiting.lock().expect("a list").push(task);
    }
}

/// A window that draws images at once, but gets answers to queries only while `may_answer` is set.
pub(super) fn window_with_slow_answers(interface: Interface, may_answer: &Arc<AtomicBool>) -> Window {
    let worker = SlowAnswers { inline: InlineWorker::new(session()), waiting: Mutex::default(), may_answer: Arc::clone(may_answer) };
    Harness::builder()
        .with_size([1100.0, 640.0])
        .with_max_steps(40)
        .renderer(CpuTestRenderer(Painter::default()))
        .build_ui_state(move |ui, interface: &mut Interface| interface.ui(ui, &worker), interface)
}

/// A window at rest with a timeline, without answers.
fn window_with_timeline(may_answer: &Arc<AtomicBool>) -> Window {
    let mut interface = interface(SATURN, TIME);
    interface.settings.panels.timeline_shown = true;
    let mut window = window_with_slow_answers(interface, may_answer);
    settle(&mut window);
    window
}

/// The spinner of the search once pushed the timeline aside, and took the focus from it.
#[test]
fn the_timeline_stays_in_place_while_an_event_is_sought() {
    let may_answer: Arc<AtomicBool> = Arc::default();
    let mut window = window_with_timeline(&may_answer);
    let timeline = |window: &Window| {
        let slider = window.get_by_role_and_label(Role::Slider, "Timeline");
        (slider.rect(), slider.accesskit_node().is_focused())
    };
    window.get_by_role_and_label(Role::Slider, "Timeline").focus();
    window.run_steps(2);
    let before = timeline(&window);
    assert!(before.1, "the timeline does not take the focus");
    window.event(Event::Text("e".into()));
    window.run_steps(3);
    assert!(window.query_by_label("looking for the event").is_some(), "no search runs");
    assert_eq!(timeline(&window), before);
    may_answer.store(true, Ordering::Relaxed);
    settle(&mut window);
    assert!(window.query_by_label("looking for the event").is_none(), "the search does not end");
    assert_eq!(timeline(&window), before);
}

/// The event once replaced whatever view had been chosen while it was sought, or in the very frame in which it was found.
#[test]
fn an_event_that_is_found_late_does_not_replace_a_view_chosen_since() {
    for (chooses_view, is_found_in_same_frame) in [(false, false), (true, false), (true, true)] {
        let may_answer: Arc<AtomicBool> = Arc::default();
        let mut window = window_with_timeline(&may_answer);
        let time_before = window.state().viewer.view_after_flight().tdb_s;
        window.event(Event::Text("e".into()));
        window.run_steps(3);
        may_answer.store(is_found_in_same_frame, Ordering::Relaxed);
        if chooses_view {
            window.key_press(Key::PageDown);
        } else {
            // The camera's motion is no choice of a view.
            window.event(Event::Text("+".into()));
        }
        settle(&mut window);
        may_answer.store(true, Ordering::Relaxed);
        settle(&mut window);
        let shown = window.state().viewer.view_after_flight();
        assert_eq!(shown.tdb_s != time_before, !chooses_view, "found in the same frame: {is_found_in_same_frame}, {:?}", shown.target);
    }
}

/// The field once lost the focus when the bar of the export above it came or went, and the rest of the name acted as shortcuts.
#[test]
fn a_name_can_be_typed_while_an_export_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let may_answer: Arc<AtomicBool> = Arc::default();
    let mut interface = interface(SATURN, TIME);
    interface.tab = Some(Tab::Share);
    let mut window = window_with_slow_answers(interface, &may_answer);
    settle(&mut window);
    let file = folder.path().join("p.png").display().to_string();
    window.get_by_label_contains("Image file: .png or .exr").set_text_value_accesskit(&file);
    window.run_steps(2);
    for (field, value) in [("Width, pixels", 24.0), ("Height, pixels", 16.0), ("Number of frames", 2.0)] {
        window.get_by_label(field).set_value_accesskit(value);
        window.run_steps(2);
    }
    window.get_by_label("Export sequence").click_accesskit();
    window.run_steps(3);
    assert!(window.state().is_saving(), "no export runs: {}", window.state().reply_text());
    window.get_by_role_and_label(Role::TextInput, "Name of the bookmark").focus();
    window.run_steps(2);
    type_text(&mut window, "three ");
    may_answer.store(true, Ordering::Relaxed);
    settle(&mut window);
    assert!(!window.state().is_saving(), "the export does not end");
    type_text(&mut window, "shadows");
    let field = window.get_by_role_and_label(Role::TextInput, "Name of the bookmark");
    assert_eq!(field.accesskit_node().value().as_deref(), Some("three shadows"));
}

/// An image that arrives between press and release may draw other effects, which have other rows.
#[test]
fn the_switch_of_an_effect_stays_in_place_while_it_is_pressed() {
    let mut interface = interface(SATURN, TIME);
    interface.tab = Some(Tab::Effects);
    let mut window = harness(interface);
    settle(&mut window);
    let place = |window: &Window| window.get_by_role_and_label(Role::CheckBox, "ring-shadow").rect();
    let (before, pos) = (place(&window), place(&window).center());
    let press = |pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    window.hover_at(pos);
    window.run_steps(1);
    window.event(press(true));
    window.run_steps(1);
    window.state_mut().viewer.view.effects = EffectOverrides::parse("-clouds").expect("an effect");
    window.run_steps(4);
    assert_eq!(place(&window), before);
    window.event(press(false));
    window.run_steps(2);
    assert_eq!(window.state().viewer.view.effects.to_text(), "-clouds,-ring-shadow");
    // The comparison must be able to fail: after the release the row of the clouds is above this one.
    settle(&mut window);
    assert!(place(&window).top() > before.top() + 10.0, "{} after {before}", place(&window));
}

/// The field once lost the focus when the answer put a line above it, and the rest of the key acted as shortcuts.
#[test]
fn a_key_can_be_typed_while_the_keys_of_all_views_are_computed() {
    let may_answer: Arc<AtomicBool> = Arc::default();
    let mut interface = interface(SATURN, TIME);
    interface.tab = Some(Tab::Shader);
    let mut window = window_with_slow_answers(interface, &may_answer);
    settle(&mut window);
    window.get_all_by_role_and_label(Role::Button, "Key").next().expect("the page").click_accesskit();
    settle(&mut window);
    window.get_by_role_and_label(Role::TextInput, "Another key").focus();
    window.run_steps(2);
    type_text(&mut window, "lam");
    let has_answer = |window: &Window| window.query_by_label_contains("keys that views of this catalog can need").is_some();
    assert!(!has_answer(&window));
    may_answer.store(true, Ordering::Relaxed);
    settle(&mut window);
    assert!(has_answer(&window), "the keys are not computed");
    type_text(&mut window, "bert");
    let field = window.get_by_role_and_label(Role::TextInput, "Another key");
    assert_eq!(field.accesskit_node().value().as_deref(), Some("lambert"));
}

/// The field was once not shown while the module of the new image was loading, and the rest of the name acted as shortcuts.
#[test]
fn values_can_be_filtered_while_the_module_changes() {
    let may_answer = Arc::new(AtomicBool::new(true));
    let mut interface = interface(SATURN, TIME);
    interface.tab = Some(Tab::Shader);
    let mut window = window_with_slow_answers(interface, &may_answer);
    settle(&mut window);
    window.get_all_by_role_and_label(Role::Button, "Values").next().expect("the page").click_accesskit();
    settle(&mut window);
    let is_loading = |window: &Window| window.query_by_label_contains("uniforms, ").is_none();
    assert!(!is_loading(&window));
    window.get_by_role_and_label(Role::TextInput, "Filter").focus();
    window.run_steps(2);
    type_text(&mut window, "su");
    let place = window.get_by_role_and_label(Role::TextInput, "Filter").rect();
    may_answer.store(false, Ordering::Relaxed);
    window.state_mut().viewer.view.effects = EffectOverrides::parse("-ring-shadow").expect("an effect");
    window.run_steps(4);
    assert!(is_loading(&window), "the module does not change");
    type_text(&mut window, "n");
    assert_eq!(window.get_by_role_and_label(Role::TextInput, "Filter").rect(), place, "the field moves");
    may_answer.store(true, Ordering::Relaxed);
    settle(&mut window);
    assert!(!is_loading(&window), "the module does not arrive");
    let field = window.get_by_role_and_label(Role::TextInput, "Filter");
    assert_eq!(field.accesskit_node().value().as_deref(), Some("sun"));
}

/// The search field was once not shown until the source of the new image's module had been generated.
#[test]
fn a_text_can_be_sought_while_the_module_changes() {
    let may_answer = Arc::new(AtomicBool::new(true));
    let mut interface = interface(SATURN, TIME);
    interface.tab = Some(Tab::Shader);
    let mut window = window_with_slow_answers(interface, &may_answer);
    settle(&mut window);
    window.get_all_by_role_and_label(Role::Button, "Source").next().expect("the page").click_accesskit();
    settle(&mut window);
    let sources_coming = |window: &Window| window.query_all_by_label("Generating the source").count();
    assert_eq!(sources_coming(&window), 0);
    window.get_by_role_and_label(Role::TextInput, "Find").focus();
    window.run_steps(2);
    type_text(&mut window, "f");
    may_answer.store(false, Ordering::Relaxed);
    window.state_mut().viewer.view.effects = EffectOverrides::parse("-ring-shadow").expect("an effect");
    window.run_steps(4);
    assert_eq!(sources_coming(&window), 1, "the module does not change");
    type_text(&mut window, "n ");
    may_answer.store(true, Ordering::Relaxed);
    settle(&mut window);
    assert_eq!(sources_coming(&window), 0, "the source does not arrive");
    let field = window.get_by_role_and_label(Role::TextInput, "Find");
    assert_eq!(field.accesskit_node().value().as_deref(), Some("fn "));
}
