//! A click that ends a typed text: the text counts, and the click means what was under the pointer at the press. The press makes the text count, which moves
//! days, dates and bodies before the release.

use crate::view::input::{Window, click, click_in_one_frame, type_text, window_without_images};
use crate::view::interface::{harness, interface, settle};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::time::Instant;

const MARS: NaifId = NaifId(499);
const JUPITER: NaifId = NaifId(599);
const TIME: &str = "2017-05-17T00:00:00Z";
const DAY_S: f64 = 86_400.0;
const CLICKS: [fn(&mut Window, Pos2); 2] = [click, click_in_one_frame];
/// The ways to click a button.
const BUTTON_CLICKS: [fn(&mut Window, Pos2); 3] = [click, click_in_one_frame, click_by_screen_reader];

/// The click of a screen reader, which has no pointer.
fn click_by_screen_reader(window: &mut Window, place: Pos2) {
    window.query_all_by_role(Role::Button).find(|button| button.rect().center() == place).expect("a button").click_accesskit();
    window.run_steps(1);
}

fn utc(window: &Window) -> String {
    window.state().viewer.view.time().to_utc_iso()
}

fn tdb_s(utc: &str) -> f64 {
    Instant::parse(utc).expect("a time").tdb_seconds_past_j2000()
}

/// Gives a field the focus, and replaces its text without ending it.
fn type_into(window: &mut Window, role: Role, field: &str, text: &str) {
    window.get_by_role_and_label(role, field).focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    type_text(window, text);
}

fn place_of_day(window: &Window, day: &str) -> Pos2 {
    window.get_by_role_and_label(Role::Button, day).rect().center()
}

/// A window at this time, with an open calendar.
fn window_with_calendar(utc: &str) -> Window {
    let mut window = window_without_images(MARS);
    window.state_mut().viewer.view.tdb_s = tdb_s(utc);
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Calendar").click();
    window.run_steps(3);
    window
}

/// The days of May begin on a Monday in 2017, and on a Wednesday in 2024: the cell of the 15th was that of the 13th.
#[test]
fn a_typed_year_counts_for_the_day_that_was_pressed() {
    for click_as_chosen in BUTTON_CLICKS {
        for (year, day, expected) in [
            ("2024", "15 May 2017", "2024-05-15T00:00:00Z"),
            ("2024", "3 June 2017", "2024-06-03T00:00:00Z"),
            ("2017", "24 May 2017", "2017-05-24T00:00:00Z"),
        ] {
            let mut window = window_with_calendar(TIME);
            type_into(&mut window, Role::SpinButton, "Year", year);
            let place = place_of_day(&window, day);
            click_as_chosen(&mut window, place);
            window.run_steps(4);
            assert_eq!(utc(&window), expected, "{year}, {day}");
        }
        // Then the days are laid out for the typed year, and a second click means what it hits there.
        let mut window = window_with_calendar(TIME);
        type_into(&mut window, Role::SpinButton, "Year", "2024");
        let place = place_of_day(&window, "15 May 2017");
        click_as_chosen(&mut window, place);
        window.run_steps(4);
        let place = place_of_day(&window, "13 May 2024");
        click_as_chosen(&mut window, place);
        window.run_steps(4);
        assert_eq!(utc(&window), "2024-05-13T00:00:00Z");
        // An hour counts with the day, too.
        type_into(&mut window, Role::SpinButton, "Hour", "12");
        let place = place_of_day(&window, "20 May 2024");
        click_as_chosen(&mut window, place);
        window.run_steps(4);
        assert_eq!(utc(&window), "2024-05-20T12:00:00Z");
    }
}

#[test]
fn a_day_that_the_typed_year_lacks_is_not_chosen() {
    for click_as_chosen in BUTTON_CLICKS {
        let mut window = window_with_calendar("2016-02-10T00:00:00Z");
        type_into(&mut window, Role::SpinButton, "Year", "2017");
        let place = place_of_day(&window, "29 February 2016");
        click_as_chosen(&mut window, place);
        window.run_steps(4);
        assert_eq!(utc(&window), "2016-02-10T00:00:00Z");
        assert!(window.query_by_role_and_label(Role::Button, "28 February 2017").is_some(), "the typed year does not count");
    }
}

/// A window at rest whose timeline spans 200 days, and the place of a day on it, counted from the middle.
fn window_with_timeline() -> (Window, impl Fn(&Window, f64) -> Pos2) {
    let mut interface = interface(MARS, "2024-05-01T00:00:00Z");
    interface.settings.panels.timeline_shown = true;
    interface.settings.panels.timeline_span_s = 200.0 * DAY_S;
    let mut window = harness(interface);
    settle(&mut window);
    let place_of = |window: &Window, days: f64| {
        let rect = window.get_by_role_and_label(Role::Slider, "Timeline").rect();
        rect.center() + vec2((days / 200.0) as f32 * rect.width(), 0.0)
    };
    (window, place_of)
}

/// The total eclipse of 2024-04-08 18:17:20 UT (NASA) is 22.24 days before the middle.
#[test]
fn a_click_on_the_timeline_means_what_was_shown_at_the_press() {
    for click_as_chosen in CLICKS {
        let (mut window, place_of) = window_with_timeline();
        type_into(&mut window, Role::TextInput, "Date and time", "2024-08-01");
        let place = place_of(&window, 40.0);
        click_as_chosen(&mut window, place);
        window.run_steps(4);
        let days = (window.state().viewer.view.tdb_s - tdb_s("2024-05-01T00:00:00Z")) / DAY_S;
        assert!((days - 40.0).abs() < 1.0, "{days} days");
        // The events near the eclipse are forgotten once the timeline shows a time years away.
        for typed in ["2024-08-01", "2034-08-01"] {
            let (mut window, place_of) = window_with_timeline();
            type_into(&mut window, Role::TextInput, "Date and time", typed);
            let place = place_of(&window, -22.24);
            click_as_chosen(&mut window, place);
            settle(&mut window);
            assert!(utc(&window).starts_with("2024-04-08T18:17"), "{typed}: {}", utc(&window));
        }
    }
    // The comparison must be able to fail: where the eclipse was, the timeline of the typed date shows another day.
    let (mut window, place_of) = window_with_timeline();
    type_into(&mut window, Role::TextInput, "Date and time", "2024-08-01");
    window.key_press(Key::Enter);
    settle(&mut window);
    let place = place_of(&window, -22.24);
    click(&mut window, place);
    settle(&mut window);
    assert!(utc(&window).starts_with("2024-07-"), "{}", utc(&window));
}

/// Another image arrives between the press and the release, as after a typed angle of view.
#[test]
fn a_click_on_the_image_means_the_body_that_was_pressed() {
    for button in [PointerButton::Primary, PointerButton::Secondary] {
        for is_replaced in [true, false] {
            let mut window = harness(interface(MARS, TIME));
            settle(&mut window);
            window.state_mut().viewer.selected = NaifId::SUN;
            let pos = window.get_by_label_contains("The sky:").rect().center();
            let press = |pressed| Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE };
            window.hover_at(pos);
            window.run_steps(1);
            if is_replaced {
                window.event(press(true));
                window.run_steps(1);
            }
            let shown_request = |window: &Window| window.state().shown().expect("an image").job.request.clone();
            let before = shown_request(&window);
            window.state_mut().viewer.view = interface(JUPITER, TIME).viewer.view.clone();
            window.run_steps(4);
            assert_ne!(shown_request(&window), before, "the image is not replaced");
            // The comparison must be able to fail: a press on the new image means its body.
            if !is_replaced {
                window.event(press(true));
                window.run_steps(1);
            }
            window.event(press(false));
            window.run_steps(2);
            let expected = if is_replaced { MARS } else { JUPITER };
            assert_eq!(window.state().viewer.selected, expected, "{button:?}, replaced while pressed: {is_replaced}");
        }
    }
}
