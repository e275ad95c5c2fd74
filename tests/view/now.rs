//! *What to see now*, a row of thumbnails: the views that they open, and when the row is visible.

use crate::support::session::session_over;
use crate::view::input::{Window, click, click_in_one_frame, type_text};
use crate::view::interface::{harness, interface, session, settle};
use crate::view::slow_answers::window_with_slow_answers;
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::scene::request::Quality;
use orrery::time::Instant;
use orrery::view::app::body_positions::{BodyPositions, SessionPositions};
use orrery::view::app::civil_time::ShownTimeZone;
use orrery::view::app::view_state::CameraPose;
use orrery::view::app::viewer::{Action, Viewer};
use orrery::view::app::what_to_see_now::{NowItem, NowView};
use orrery::view::panels::Tab;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const MARS: NaifId = NaifId(499);
const SATURN: NaifId = NaifId(699);
/// Height of the image that an action may refer to.
const HEIGHT_PX: f64 = 600.0;

/// A window with the settings of a first start.
fn first_start() -> Window {
    let mut interface = interface(MARS, "2017-05-17T00:00:00Z");
    interface.settings.panels.now_shown = true;
    let mut window = harness(interface);
    settle(&mut window);
    window
}

/// Labels of the thumbnail buttons on screen.
fn thumbnail_labels(window: &Window) -> Vec<String> {
    let all = window.query_all_by_role(Role::Button).filter_map(|n| n.accesskit_node().label());
    all.filter(|label| NowItem::ALL.iter().any(|item| label.starts_with(&format!("{}: ", item.name())))).collect()
}

/// The middle of a thumbnail button.
fn place_of(window: &Window, item: NowItem) -> Pos2 {
    let name = thumbnail_labels(window).into_iter().find(|label| label.starts_with(item.name())).expect("a thumbnail");
    window.get_by_role_and_label(Role::Button, &name).rect().center()
}

fn press(window: &mut Window, item: NowItem) {
    let place = place_of(window, item);
    click(window, place);
    settle(window);
}

/// As [`first_start`], but no thumbnail is drawn before `may_answer` is set.
fn first_start_on_a_busy_machine(may_answer: &Arc<AtomicBool>) -> Window {
    let mut interface = interface(MARS, "2017-05-17T00:00:00Z");
    interface.settings.panels.now_shown = true;
    let mut window = window_with_slow_answers(interface, may_answer);
    settle(&mut window);
    window
}

#[test]
fn each_thumbnail_opens_its_view_and_hides_the_row() {
    for item in NowItem::ALL {
        let mut window = first_start();
        assert_eq!(thumbnail_labels(&window).len(), NowItem::ALL.len(), "{:?}", thumbnail_labels(&window));
        press(&mut window, item);
        let state = window.state();
        let view = state.viewer.view_after_flight();
        let (target, tab) = match item {
            NowItem::Moon => (NaifId::MOON, None),
            // The clock of the test is at J2000. The next eclipse is that of the Moon on 2000-01-21 04:44 UT (NASA, canon of lunar eclipses).
            NowItem::Eclipse => (NaifId::MOON, Some(Tab::Events)),
            NowItem::Saturn => (SATURN, None),
            NowItem::Shadows => (NaifId(599), None),
            NowItem::Shader => (NaifId::EARTH, Some(Tab::Shader)),
        };
        assert_eq!((view.target, state.tab), (target, tab), "{item:?}");
        if item == NowItem::Eclipse {
            assert!(view.time().to_utc_iso().starts_with("2000-01-21T04:4"), "{}", view.time().to_utc_iso());
            window.get_by_label("Watch it");
        }
        if matches!(item, NowItem::Moon | NowItem::Saturn) {
            assert!(view.tdb_s.abs() < 10.0, "the view is at the current time");
        }
        // The row over the sky is closed; the Moments panel still shows the thumbnails.
        window.state_mut().tab = None;
        settle(&mut window);
        assert!(thumbnail_labels(&window).is_empty() && !window.state().settings.panels.now_shown);
        window.state_mut().tab = Some(Tab::Moments);
        settle(&mut window);
        assert_eq!(thumbnail_labels(&window).len(), NowItem::ALL.len());
    }
}

/// The view of *Triple shadow* in a session whose catalog has a moment of the same kind with this name, five years earlier, at the Moon.
fn shadows_beside_moment(name: &str) -> NowView {
    let folder = tempfile::tempdir().expect("a folder");
    let moment = format!(
        "[[moment]]\nname = \"{name}\"\nkind = \"shadows\"\ntime = \"2010-01-24T06:40:00Z\"\ntarget = \"Moon\"\nside = \"Sun\"\n\
         radii = 5.0\nabout = \"One shadow.\"\nsource = \"invented\"\n"
    );
    std::fs::write(folder.path().join("own.toml"), moment).expect("written");
    let (own_session, _) = session_over(folder.path());
    let base_view = interface(MARS, "2017-05-17T00:00:00Z").viewer.view;
    NowItem::Shadows.view(&own_session, Instant::parse("2026-01-01").expect("a time"), &base_view).expect("a view")
}

#[test]
fn a_moment_of_the_same_kind_does_not_replace_the_triple_shadow() {
    let shown = shadows_beside_moment("One shadow");
    assert_eq!((shown.view.target, shown.about(ShownTimeZone::Utc).as_str()), (NaifId(599), "Triple shadow on Jupiter, 2015-01-24"));
    // A moment of the same name replaces it here as in the list of moments.
    let shown = shadows_beside_moment("Triple shadow on Jupiter");
    assert_eq!((shown.view.target, shown.about(ShownTimeZone::Utc).as_str()), (NaifId::MOON, "Triple shadow on Jupiter, 2010-01-24"));
}

/// The user changes the present view after the thumbnails were drawn.
#[test]
fn an_opened_view_has_the_quality_and_the_layers_of_the_present_view() {
    for item in [NowItem::Saturn, NowItem::Shader] {
        let mut window = first_start();
        let view = &mut window.state_mut().viewer.view;
        (view.quality, view.orbits) = (Quality::Draft, true);
        press(&mut window, item);
        let view = window.state().viewer.view_after_flight();
        assert_eq!((view.quality, view.orbits), (Quality::Draft, true), "{item:?}");
    }
}

#[test]
fn opening_a_current_view_sets_real_time_forward_and_keeps_a_pause() {
    for actions_before in [vec![Action::RunAt(-600.0)], vec![Action::RunAt(-600.0), Action::TogglePause]] {
        let mut window = first_start();
        let positions = SessionPositions(session());
        for action in &actions_before {
            window.state_mut().viewer.apply(action.clone(), HEIGHT_PX, &positions);
        }
        assert!(window.state().viewer.time_rate.rate() <= 0.0);
        press(&mut window, NowItem::Moon);
        let state = window.state_mut();
        // If time was paused it still is; resuming it shows that the rate was set to real time.
        if actions_before.last() == Some(&Action::TogglePause) {
            assert_eq!(state.viewer.time_rate.rate(), 0.0, "{actions_before:?}");
            state.viewer.apply(Action::TogglePause, HEIGHT_PX, &positions);
        }
        assert_eq!(state.viewer.time_rate.rate(), 1.0, "{actions_before:?}");
    }
}

fn type_date(window: &mut Window, text: &str) {
    window.get_by_role_and_label(Role::TextInput, "Date and time").focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    type_text(window, text);
}

/// The press ends the text of the date, which sets the time; the row is there until the release, which is the click.
#[test]
fn a_click_on_the_row_that_ends_a_typed_date_opens_its_view() {
    for click_as_chosen in [click, click_in_one_frame] {
        let mut window = first_start();
        type_date(&mut window, "2020-01-01");
        let place = place_of(&window, NowItem::Saturn);
        click_as_chosen(&mut window, place);
        settle(&mut window);
        assert_eq!(window.state().viewer.view_after_flight().target, SATURN);
        assert!(thumbnail_labels(&window).is_empty());
    }
    // Any other click that ends the text hides the row.
    let mut window = first_start();
    type_date(&mut window, "2020-01-01");
    let place = window.get_by_label_contains("The sky:").rect().left_top() + egui::vec2(60.0, 80.0);
    click(&mut window, place);
    settle(&mut window);
    assert!(thumbnail_labels(&window).is_empty());
}

/// On a busy machine a frame can take a second. egui then took the click for a long press, and nothing happened.
#[test]
fn a_click_counts_although_a_frame_between_press_and_release_is_slow() {
    let mut window = first_start();
    let pos = place_of(&window, NowItem::Saturn);
    let press = |pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    window.hover_at(pos);
    window.run_steps(1);
    window.event(press(true));
    window.run_steps(1);
    let slow_s = 1.5;
    let next = window.ctx.input(|input| input.time) + slow_s;
    window.input_mut().time = Some(next);
    window.event(press(false));
    window.run_steps(1);
    settle(&mut window);
    assert_eq!(window.state().viewer.view_after_flight().target, SATURN);
}

/// The click was once ignored.
#[test]
fn a_click_on_a_thumbnail_that_is_not_drawn_yet_opens_its_view() {
    let may_answer: Arc<AtomicBool> = Arc::default();
    let mut window = first_start_on_a_busy_machine(&may_answer);
    press(&mut window, NowItem::Saturn);
    assert_eq!(window.state().viewer.view_after_flight().target, SATURN);
    assert!(thumbnail_labels(&window).is_empty());
    // The eclipse has to be searched for first. Its view then opens, unless the user has done something else.
    for does_something_else in [false, true] {
        may_answer.store(false, Ordering::Relaxed);
        let mut window = first_start_on_a_busy_machine(&may_answer);
        press(&mut window, NowItem::Eclipse);
        assert_eq!((window.state().viewer.view_after_flight().target, window.state().tab), (MARS, None));
        if does_something_else {
            drag(&mut window);
            settle(&mut window);
            window.state_mut().tab = Some(Tab::Moments);
        }
        may_answer.store(true, Ordering::Relaxed);
        settle(&mut window);
        let (target, tab) = if does_something_else { (MARS, Tab::Moments) } else { (NaifId::MOON, Tab::Events) };
        assert_eq!((window.state().viewer.view_after_flight().target, window.state().tab), (target, Some(tab)));
    }
}

/// Its place was once closed when the answer arrived, which moved the other buttons under the pointer.
#[test]
fn a_view_that_does_not_exist_leaves_its_place_empty() {
    let places = |window: &Window| [NowItem::Shadows, NowItem::Shader].map(|item| place_of(window, item));
    let expected = places(&first_start());
    let mut interface = interface(MARS, "2017-05-17T00:00:00Z");
    interface.settings.panels.now_shown = true;
    // The ephemeris of the Moon ends before this year.
    let (bodies, view) = (interface.viewer.selectable_bodies().to_vec(), interface.viewer.view.clone());
    interface.viewer = Viewer::new(bodies, view, || Instant::parse("9000-05-05").expect("a time"));
    interface.viewer.time_rate.toggle_pause();
    let mut window = harness(interface);
    settle(&mut window);
    assert!(!thumbnail_labels(&window).iter().any(|label| label.starts_with(NowItem::Moon.name())), "the Moon has a view");
    for (place, expected) in places(&window).into_iter().zip(expected) {
        assert!(place.distance(expected) < 1.0, "{place} in place of {expected}");
    }
}

#[test]
fn the_row_stays_closed_after_its_close_button() {
    let mut window = first_start();
    window.get_by_label("Close what to see now").click();
    settle(&mut window);
    assert!(thumbnail_labels(&window).is_empty());
    let text = serde_json::to_string(&window.state().settings).expect("text");
    assert!(text.contains("\"now_shown\":false"), "the next start remembers it");
}

/// Presses the left button on empty sky and moves the pointer.
fn drag(window: &mut Window) {
    let start = window.get_by_label_contains("The sky:").rect().left_top() + egui::vec2(60.0, 80.0);
    window.drag_at(start);
    window.run_steps(1);
    window.hover_at(start + egui::vec2(40.0, 10.0));
    window.run_steps(1);
    window.drop_at(start + egui::vec2(60.0, 20.0));
}

type Input = fn(&mut Window);

#[test]
fn the_row_hides_at_the_first_input_and_not_before() {
    let inputs: [(&str, Input); 5] = [
        ("drag", drag),
        ("zoom", |window| window.event(Event::Text("+".into()))),
        ("selection", |window| window.key_press(Key::PageDown)),
        ("panel", |window| window.get_by_label("Effects").click()),
        ("list of bodies", |window| window.get_by_label("Bodies").click()),
    ];
    for (name, input) in inputs {
        let mut window = first_start();
        // A pointer that rests over the sky is no input, and neither is the passing of time.
        let centre = window.get_by_label_contains("The sky:").rect().center();
        window.hover_at(centre);
        settle(&mut window);
        assert_eq!(thumbnail_labels(&window).len(), NowItem::ALL.len(), "before: {name}");
        input(&mut window);
        settle(&mut window);
        window.state_mut().tab = None;
        settle(&mut window);
        assert!(thumbnail_labels(&window).is_empty(), "after: {name}");
        window.state_mut().tab = Some(Tab::Moments);
        settle(&mut window);
        assert_eq!(thumbnail_labels(&window).len(), NowItem::ALL.len(), "in the panel, after: {name}");
    }
}

#[test]
fn the_shader_panel_opens_at_the_lines_of_the_eclipse() {
    let mut window = first_start();
    press(&mut window, NowItem::Shader);
    // The longest group of consecutive lines that the feature needs is in view, with its name in the margin.
    assert!(window.query_all_by_label_contains("needed by eclipse.1").count() > 0);
    assert!(window.query_by_label("Only lines for eclipse.1").is_some(), "the feature is chosen");
}

/// In years throughout Saturn's orbit the camera is on the lit side of the rings, over 10 degrees from their plane.
#[test]
fn saturn_is_seen_from_the_lit_side_of_its_rings() {
    let positions = SessionPositions(session());
    let base_view = first_start().state().viewer.view.clone();
    for year in (1990..2050).step_by(4) {
        let time = Instant::parse(&format!("{year}-07-01")).expect("a time");
        let view = NowItem::Saturn.view(session(), time, &base_view).expect("a view").view;
        let CameraPose::Orbit { elevation_deg, distance_radii, .. } = view.camera_pose else { panic!("no orbit") };
        let sunward = positions.geometric_vector_km(SATURN, NaifId::SUN, time).expect("a position");
        let pole = positions.body_from_icrf(SATURN, time).expect("an orientation").row(2);
        assert!(sunward.dot(pole) * elevation_deg > 0.0, "{year}: the dark side of the rings");
        assert!(elevation_deg.abs() > 10.0 && distance_radii > 4.0, "{year}");
    }
}

/// The message about a broken settings file appears at a start at which the row is shown, too.
#[test]
fn a_message_is_above_the_row() {
    let mut window = first_start();
    let line = "/home/user/.config/orrery/settings.json: EOF while parsing a string at line 38 column 6; kept as settings.json.broken";
    window.state().session_messages.lock().push(line.into());
    window.run_steps(4);
    let (message, heading) = (window.get_by_label(line).rect(), window.get_by_label("What to see now").rect());
    assert!(message.bottom() < heading.top(), "the message at {message} is behind the row, whose heading is at {heading}");
}
