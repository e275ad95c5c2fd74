//! *What to see now*: its images, the views they open, and when the row is visible.

use crate::view::input::Window;
use crate::view::interface::{harness, interface, session, settle};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::time::Instant;
use orrery::view::app::now_showing::NowItem;
use orrery::view::app::places::{BodyPositions, SessionPositions};
use orrery::view::app::view_state::CameraPose;
use orrery::view::app::viewer::Action;
use orrery::view::panels::Tab;

const MARS: NaifId = NaifId(499);
const SATURN: NaifId = NaifId(699);

/// A window with the settings of a first start.
fn first_start() -> Window {
    let mut interface = interface(MARS, "2017-05-17T00:00:00Z");
    interface.settings.panels.now_shown = true;
    let mut window = harness(interface);
    settle(&mut window);
    window
}

fn tiles(window: &Window) -> Vec<String> {
    let all = window.query_all_by_role(Role::Button).filter_map(|n| n.accesskit_node().label());
    all.filter(|label| NowItem::ALL.iter().any(|item| label.starts_with(&format!("{}: ", item.name())))).collect()
}

fn press(window: &mut Window, item: NowItem) {
    let name = tiles(window).into_iter().find(|label| label.starts_with(item.name())).expect("a tile");
    window.get_by_role_and_label(Role::Button, &name).click();
    settle(window);
}

#[test]
fn each_image_opens_its_view_and_hides_the_row() {
    for item in NowItem::ALL {
        let mut window = first_start();
        assert_eq!(tiles(&window).len(), NowItem::ALL.len(), "{:?}", tiles(&window));
        press(&mut window, item);
        let state = window.state();
        let view = state.viewer.destination();
        let (target, tab) = match item {
            NowItem::Moon => (NaifId::MOON, None),
            // The test's clock is at J2000: a total eclipse of the Moon on 2000-01-21 04:44 UT (NASA, canon of lunar eclipses).
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
        // The row over the sky is closed; the panel still shows it.
        window.state_mut().tab = None;
        settle(&mut window);
        assert!(tiles(&window).is_empty() && !window.state().settings.panels.now_shown);
        window.state_mut().tab = Some(Tab::Moments);
        settle(&mut window);
        assert_eq!(tiles(&window).len(), NowItem::ALL.len());
    }
}

#[test]
fn a_view_of_now_passes_forward_in_real_time_and_stays_paused() {
    for earlier in [vec![Action::RunAt(-600.0)], vec![Action::RunAt(-600.0), Action::TogglePause]] {
        let mut window = first_start();
        let places = SessionPositions(session());
        for action in &earlier {
            window.state_mut().viewer.apply(action.clone(), 600.0, &places);
        }
        assert!(window.state().viewer.time_rate.rate() <= 0.0);
        press(&mut window, NowItem::Moon);
        let state = window.state_mut();
        if earlier.last() == Some(&Action::TogglePause) {
            assert_eq!(state.viewer.time_rate.rate(), 0.0, "{earlier:?}");
            state.viewer.apply(Action::TogglePause, 600.0, &places);
        }
        assert_eq!(state.viewer.time_rate.rate(), 1.0, "{earlier:?}");
    }
}

#[test]
fn the_row_stays_closed_after_its_close_button() {
    let mut window = first_start();
    window.get_by_label("Close what to see now").click();
    settle(&mut window);
    assert!(tiles(&window).is_empty());
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
        ("zoom", |window| window.event(egui::Event::Text("+".into()))),
        ("selection", |window| window.key_press(egui::Key::PageDown)),
        ("panel", |window| window.get_by_label("Effects").click()),
        ("list of bodies", |window| window.get_by_label("Bodies").click()),
    ];
    for (name, input) in inputs {
        let mut window = first_start();
        // The pointer over the sky and time that passes are no input.
        let centre = window.get_by_label_contains("The sky:").rect().center();
        window.hover_at(centre);
        settle(&mut window);
        assert_eq!(tiles(&window).len(), NowItem::ALL.len(), "before: {name}");
        input(&mut window);
        settle(&mut window);
        window.state_mut().tab = None;
        settle(&mut window);
        assert!(tiles(&window).is_empty(), "after: {name}");
        window.state_mut().tab = Some(Tab::Moments);
        settle(&mut window);
        assert_eq!(tiles(&window).len(), NowItem::ALL.len(), "in the panel, after: {name}");
    }
}

#[test]
fn the_shader_of_the_eclipse_is_shown_at_its_lines() {
    let mut window = first_start();
    press(&mut window, NowItem::Shader);
    // The longest run of the feature is visible, with its name in the margin.
    assert!(window.query_all_by_label_contains("needed by eclipse.1").count() > 0);
    assert!(window.query_by_label("Only lines for eclipse.1").is_some(), "the feature is chosen");
}

/// At any time of Saturn's year the camera is on the lit side of the rings and sees more day than night.
#[test]
fn saturn_is_seen_from_the_lit_side_of_its_rings() {
    let places = SessionPositions(session());
    let base_view = first_start().state().viewer.view.clone();
    for year in (1990..2050).step_by(4) {
        let time = Instant::parse(&format!("{year}-07-01")).expect("a time");
        let view = NowItem::Saturn.view(session(), time, &base_view).expect("a view").view;
        let CameraPose::Orbit { elevation_deg, distance_radii, .. } = view.eye else { panic!("no orbit") };
        let sunward = places.between_km(SATURN, NaifId::SUN, time).expect("a place");
        let pole = places.body_from_icrf(SATURN, time).expect("an orientation").row(2);
        assert!(sunward.dot(pole) * elevation_deg > 0.0, "{year}: the dark side of the rings");
        assert!(elevation_deg.abs() > 10.0 && distance_radii > 4.0, "{year}");
    }
}
