//! The timeline: drags, clicks and keys change the time, a click on an event opens its view, and the wheel zooms.

use crate::view::input::{Window, click};
use crate::view::interface::{harness, interface, settle};
use egui::accesskit::{Action, Role};
use egui::{Event, Key, Modifiers, PointerButton, Rect};
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::time::Instant;

const MARS: NaifId = NaifId(499);
const DAY_S: f64 = 86_400.0;
const SPAN_DAYS: f64 = 200.0;
const START: &str = "2024-05-01T00:00:00Z";

fn window() -> Window {
    let mut interface = interface(MARS, START);
    interface.settings.panels.timeline_shown = true;
    interface.settings.panels.timeline_span_s = SPAN_DAYS * DAY_S;
    let mut window = harness(interface);
    settle(&mut window);
    window
}

fn timeline_rect(window: &Window) -> Rect {
    window.get_by_role_and_label(Role::Slider, "Timeline").rect()
}

/// Days from [`START`] to the time of the view.
fn days_since_start(window: &Window) -> f64 {
    (window.state().viewer.view.tdb_s - Instant::parse(START).expect("a time").tdb_seconds_past_j2000()) / DAY_S
}

#[test]
fn dragging_the_timeline_to_the_left_moves_the_time_forward() {
    let mut window = window();
    let rect = timeline_rect(&window);
    let primary_button = |pos, pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    let from = rect.center();
    window.hover_at(from);
    window.run_steps(1);
    window.event(primary_button(from, true));
    window.run_steps(1);
    let to = from - egui::vec2(0.25 * rect.width(), 0.0);
    window.hover_at(to);
    window.run_steps(2);
    window.event(primary_button(to, false));
    window.run_steps(2);
    // A quarter of 200 days, less the first few points, which do not count as a drag.
    assert!((days_since_start(&window) - 50.0).abs() < 3.0, "{} days", days_since_start(&window));
}

#[test]
fn a_click_goes_to_a_date_or_an_event() {
    let mut window = window();
    let rect = timeline_rect(&window);
    let pos_of = |days_from_middle: f64| rect.center() + egui::vec2((days_from_middle / SPAN_DAYS) as f32 * rect.width(), 0.0);
    click(&mut window, pos_of(40.0));
    window.run_steps(2);
    assert!((days_since_start(&window) - 40.0).abs() < 1.0, "{} days", days_since_start(&window));
    // The timeline now has the new time in its middle. The total eclipse of 2024-04-08 18:17:20 UT (NASA) is 22.24 days before the start.
    click(&mut window, pos_of(-22.24 - 40.0));
    settle(&mut window);
    let time = window.state().viewer.view.time().to_utc_iso();
    assert!(time.starts_with("2024-04-08T18:17"), "{time}");
    assert_eq!(window.state().viewer.view.target, NaifId::SUN, "the view of the event");
}

#[test]
fn keys_move_and_zoom_the_timeline_and_the_wheel_zooms_it() {
    let mut window = window();
    let span_days = |w: &Window| w.state().settings.panels.timeline_span_s / DAY_S;
    window.get_by_role_and_label(Role::Slider, "Timeline").focus();
    window.run_steps(2);
    window.key_press(Key::ArrowRight);
    window.run_steps(2);
    let step_days = days_since_start(&window);
    assert!(step_days > 0.5 && step_days < 20.0, "{step_days} days");
    window.key_press(Key::ArrowLeft);
    window.run_steps(2);
    assert!(days_since_start(&window).abs() < 0.01);
    window.key_press(Key::ArrowUp);
    window.run_steps(2);
    assert!(span_days(&window) < 190.0, "{} days", span_days(&window));
    window.key_press(Key::ArrowDown);
    window.run_steps(2);
    assert!((span_days(&window) - SPAN_DAYS).abs() < 0.01);
    assert!(window.get_by_role_and_label(Role::Slider, "Timeline").accesskit_node().data().supports_action(Action::Focus));
    window.hover_at(timeline_rect(&window).center());
    window.run_steps(1);
    window.event(Event::Zoom(1.5));
    window.run_steps(2);
    assert!(span_days(&window) < 190.0, "{} days", span_days(&window));
    let before = span_days(&window);
    window.get_by_label("Longer timeline").click();
    window.run_steps(2);
    assert!(span_days(&window) > before);
    // After Escape the keys belong to the window again.
    window.key_press(Key::Escape);
    window.run_steps(1);
    window.event(Event::Text("i".into()));
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::Slider, "Timeline").is_none(), "the key `i` does not hide the timeline");
}

/// Four centuries take some 300 searches, at most one per frame, from the middle outward. Until an end has been searched, a tooltip there says that events are
/// still being searched.
#[test]
fn a_part_that_is_still_to_be_searched_says_so() {
    let mut window = window();
    window.ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
    window.state_mut().settings.panels.timeline_span_s = 400.0 * 365.25 * DAY_S;
    let rect = timeline_rect(&window);
    let tooltip_says_so = |window: &mut Window, at: egui::Pos2| {
        window.hover_at(at);
        window.run_steps(3);
        window.query_by_label_contains("Events are still being searched here").is_some()
    };
    assert!(tooltip_says_so(&mut window, rect.left_center() + egui::vec2(5.0, -8.0)));
    assert!(tooltip_says_so(&mut window, rect.right_center() - egui::vec2(5.0, 8.0)));
    assert!(!tooltip_says_so(&mut window, rect.center() + egui::vec2(0.5, 12.0)), "the middle, which is searched first");
}
