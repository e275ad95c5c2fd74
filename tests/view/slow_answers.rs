//! A window on a busy machine, where answers to queries arrive late: nothing moves meanwhile, and a late answer does not replace what the user has chosen
//! since.

use crate::view::input::{SATURN, TIME, Window};
use crate::view::interface::{CpuTestRenderer, interface, session, settle};
use egui::accesskit::Role;
use egui::{Event, Key};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::session::Session;
use orrery::view::panels::Interface;
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

/// The event once replaced whatever view had been chosen while it was sought.
#[test]
fn an_event_that_is_found_late_does_not_replace_a_view_chosen_since() {
    for chooses_view in [false, true] {
        let may_answer: Arc<AtomicBool> = Arc::default();
        let mut window = window_with_timeline(&may_answer);
        window.event(Event::Text("e".into()));
        window.run_steps(3);
        if chooses_view {
            window.key_press(Key::PageDown);
        } else {
            // The camera's motion is no choice of a view.
            window.event(Event::Text("+".into()));
        }
        settle(&mut window);
        let shown = |window: &Window| window.state().viewer.view_after_flight();
        let before = shown(&window);
        may_answer.store(true, Ordering::Relaxed);
        settle(&mut window);
        let is_replaced = shown(&window).tdb_s != before.tdb_s;
        assert_eq!(is_replaced, !chooses_view, "{:?}, then {:?}", before.target, shown(&window).target);
    }
}
