//! Number fields, and the numbers beside sliders, under the keyboard: a typed text counts as a whole or not at all, however fast it is typed, and also if the
//! value changes meanwhile; what leaves a value as it is.

use crate::view::input::{Window, advance, click, click_in_one_frame, type_text, window_without_images};
use crate::view::interface::CpuTestRenderer;
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, Pos2, SurrenderFocusOn, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::view::language::Language;
use orrery::view::panels::Tab;
use orrery::view::window::cpu_painter::Painter;

const MARS: NaifId = NaifId(499);
const LATITUDE: &str = "Latitude, degrees";
const LONGITUDE: &str = "Longitude (E), degrees";
const STEP: &str = "Simulated seconds between frames";
const FRAMES: &str = "Number of frames";

fn value(window: &Window, field: &str) -> f64 {
    window.get_by_role_and_label(Role::SpinButton, field).accesskit_node().numeric_value().expect("a number")
}

/// The values of all fields, in order.
fn values(window: &Window) -> Vec<f64> {
    window.query_all_by_role(Role::SpinButton).map(|field| field.accesskit_node().numeric_value().expect("a number")).collect()
}

fn type_letters(window: &mut Window, text: &str) {
    for letter in text.chars() {
        type_text(window, &letter.to_string());
    }
}

/// Gives a field the focus, with its text selected.
fn enter_field(window: &mut Window, field: &str) {
    window.get_by_role_and_label(Role::SpinButton, field).focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
}

fn leave_by(window: &mut Window, key: Key) {
    window.key_press(key);
    window.run_steps(4);
}

#[test]
fn a_typed_text_counts_as_a_whole_or_not_at_all() {
    const NO_LATITUDE: &str = "“10.5x” is not a latitude: write 33.9 S or -33.9";
    const NO_LENGTH: &str = "“5 x” is not a length of time: write 90, 90 s, 5 min, 2 h or 1 d";
    let mut window = window_without_images(MARS);
    window.state_mut().tab = Some(Tab::Share);
    window.run_steps(3);
    for is_at_once in [false, true] {
        for (field, text, expected, reply) in [
            (LATITUDE, "33.9 S", -33.9, ""),
            (LATITUDE, "10.5x", -33.9, NO_LATITUDE),
            (LATITUDE, "95", -33.9, "“95” is not between -90° and 90°"),
            (LATITUDE, "12", 12.0, ""),
            (LONGITUDE, "20 W", -20.0, ""),
            (LONGITUDE, "400", 40.0, ""),
            (STEP, "1 d", 86_400.0, ""),
            (STEP, "5 x", 86_400.0, NO_LENGTH),
            (FRAMES, "12", 12.0, ""),
            (FRAMES, "7.5", 12.0, "“7.5” is not a whole number"),
        ] {
            window.state_mut().show_reply("");
            enter_field(&mut window, field);
            if is_at_once {
                type_text(&mut window, text);
            } else {
                type_letters(&mut window, text);
            }
            leave_by(&mut window, Key::Enter);
            assert_eq!((value(&window, field), window.state().reply_text()), (expected, reply), "{field}: {text}, at once: {is_at_once}");
        }
    }
}

/// Types a text into a field, clicks a button of the top bar that hides the field, and shows the field again.
fn type_and_hide(window: &mut Window, field: &str, text: &str, button: &str, click_as_chosen: fn(&mut Window, Pos2)) {
    (window.state_mut().tab, window.state_mut().body_browser_shown) = (Some(Tab::Share), true);
    window.state_mut().show_reply("");
    window.run_steps(3);
    enter_field(window, field);
    type_letters(window, text);
    // The top bar is the first to show its buttons.
    let top = |a: &Pos2, b: &Pos2| a.y.total_cmp(&b.y);
    let place = window.query_all_by_role_and_label(Role::Button, button).map(|node| node.rect().center()).min_by(top).expect(button);
    click_as_chosen(window, place);
    window.run_steps(3);
    assert!(window.query_by_role_and_label(Role::SpinButton, field).is_none(), "{button} does not hide {field}");
    (window.state_mut().tab, window.state_mut().body_browser_shown) = (Some(Tab::Share), true);
    window.run_steps(3);
}

/// The click of a screen reader, which has no pointer and takes the focus from no field.
fn click_by_screen_reader(window: &mut Window, place: Pos2) {
    window.query_all_by_role(Role::Button).find(|button| button.rect().center() == place).expect("a button").click_accesskit();
    window.run_steps(1);
}

/// The button is shown before the field, and so hides it in the pass of the click.
#[test]
fn a_click_on_a_button_that_hides_the_field_counts() {
    let mut window = window_without_images(MARS);
    for click_as_chosen in [click, click_in_one_frame, click_by_screen_reader] {
        for (field, text, button, expected, reply) in [
            (FRAMES, "12", "Information", 12.0, ""),
            (FRAMES, "7.5", "Information", 12.0, "“7.5” is not a whole number"),
            (FRAMES, "34", "Share", 34.0, ""),
            (LATITUDE, "33.9 S", "Bodies", -33.9, ""),
            (LATITUDE, "95", "Bodies", -33.9, "“95” is not between -90° and 90°"),
            (LATITUDE, "12", "Bodies", 12.0, ""),
        ] {
            type_and_hide(&mut window, field, text, button, click_as_chosen);
            assert_eq!((value(&window, field), window.state().reply_text()), (expected, reply), "{field}: {text}, {button}");
        }
    }
    // The comparison must be able to fail: egui's own way, by which the field is gone before it loses the focus.
    window.ctx.options_mut(|options| options.input_options.surrender_focus_on = SurrenderFocusOn::Clicks);
    type_and_hide(&mut window, FRAMES, "56", "Information", click);
    assert_eq!(value(&window, FRAMES), 34.0, "a lost text is not detected");
}

/// The window becomes so narrow that the panel with the field is hidden. No press ends the text, which was once lost.
#[test]
fn a_text_counts_if_the_window_becomes_too_narrow_for_its_panel() {
    for is_at_once in [false, true] {
        for (field, kept, open, text, expected, reply) in [
            (FRAMES, Some(Tab::Share), None, "12", Some(12.0), ""),
            (FRAMES, Some(Tab::Share), Some(Tab::Events), "7.5", None, "“7.5” is not a whole number"),
            (LATITUDE, None, Some(Tab::Share), "33.9 S", Some(-33.9), ""),
        ] {
            let mut window = window_without_images(MARS);
            window.set_size(vec2(1200.0, 1900.0));
            (window.state_mut().kept_tab, window.state_mut().tab) = (kept, open);
            window.run_steps(3);
            let before = value(&window, field);
            enter_field(&mut window, field);
            if is_at_once {
                window.input_mut().events.push(Event::Text(text.into()));
            } else {
                type_letters(&mut window, text);
            }
            window.set_size(vec2(700.0, 1900.0));
            window.run_steps(5);
            assert!(window.query_by_role_and_label(Role::SpinButton, field).is_none(), "{field} is not hidden");
            assert_eq!(window.state().reply_text(), reply, "{field}: {text}, at once: {is_at_once}");
            window.set_size(vec2(1200.0, 1900.0));
            window.run_steps(4);
            assert_eq!(value(&window, field), expected.unwrap_or(before), "{field}: {text}, at once: {is_at_once}");
        }
    }
}

#[test]
fn a_refusal_is_in_the_language_of_the_window() {
    let mut window = window_without_images(MARS);
    window.state_mut().language = Language::German;
    window.run_steps(3);
    enter_field(&mut window, "Breite, Grad");
    type_letters(&mut window, "95");
    leave_by(&mut window, Key::Enter);
    assert_eq!(window.state().reply_text(), "„95“ liegt nicht zwischen -90° und 90°");
}

/// A value may have more decimals than its text, and Escape drops what was typed.
#[test]
fn escape_or_an_unchanged_text_leaves_the_value() {
    let mut window = window_without_images(MARS);
    enter_field(&mut window, LATITUDE);
    type_letters(&mut window, "12.34567891");
    leave_by(&mut window, Key::Tab);
    assert_eq!(value(&window, LATITUDE), 12.345_678_91);
    for key in [Key::Tab, Key::Enter, Key::Escape] {
        enter_field(&mut window, LATITUDE);
        leave_by(&mut window, key);
        assert_eq!((value(&window, LATITUDE), window.state().reply_text()), (12.345_678_91, ""), "{key:?}");
    }
    for text in ["45", "95"] {
        enter_field(&mut window, LATITUDE);
        type_letters(&mut window, text);
        leave_by(&mut window, Key::Escape);
        assert_eq!((value(&window, LATITUDE), window.state().reply_text()), (12.345_678_91, ""), "{text}");
    }
}

/// As in the number fields of browsers: an arrow key steps from the number that stands in the field.
/// egui's own step of whole numbers, 0.25, would be rounded away.
#[test]
fn an_arrow_key_steps_whole_numbers_by_one() {
    let mut window = window_without_images(MARS);
    window.get_by_role_and_label(Role::Button, "Calendar").click();
    window.run_steps(3);
    for (typed, key, expected) in [("", Key::ArrowUp, 1.0), ("", Key::ArrowDown, 0.0), ("5", Key::ArrowUp, 6.0), ("9", Key::ArrowDown, 8.0)]
    {
        enter_field(&mut window, "Hour");
        type_letters(&mut window, typed);
        window.key_press(key);
        window.run_steps(4);
        assert_eq!(value(&window, "Hour"), expected, "{typed} {key:?}");
        leave_by(&mut window, Key::Enter);
        assert_eq!(value(&window, "Hour"), expected, "{typed} {key:?}, entered");
    }
}

#[test]
fn an_arrow_key_steps_from_the_typed_number() {
    let mut window = window_without_images(MARS);
    let is_latitude = |window: &Window, expected: f64| (value(window, LATITUDE) - expected).abs() < 1e-9;
    for is_at_once in [false, true] {
        enter_field(&mut window, LATITUDE);
        if is_at_once {
            let up = Event::Key { key: Key::ArrowUp, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
            window.input_mut().events.extend([Event::Text("1".into()), Event::Text("2".into()), up]);
            window.run_steps(4);
        } else {
            type_letters(&mut window, "12");
            window.key_press(Key::ArrowUp);
            window.run_steps(3);
        }
        assert!(is_latitude(&window, 12.2), "at once: {is_at_once}: {}", value(&window, LATITUDE));
        leave_by(&mut window, Key::Enter);
        assert!(is_latitude(&window, 12.2), "at once: {is_at_once}, entered: {}", value(&window, LATITUDE));
        enter_field(&mut window, LATITUDE);
        type_letters(&mut window, "45");
        window.key_press(Key::ArrowDown);
        window.run_steps(3);
        let sky = window.get_by_label_contains("The sky:").rect().center();
        click(&mut window, sky);
        window.run_steps(4);
        assert!(is_latitude(&window, 44.8), "at once: {is_at_once}, clicked: {}", value(&window, LATITUDE));
    }
    // Without a typed number it steps from the value. What is typed after a step counts as ever.
    enter_field(&mut window, LATITUDE);
    window.key_press(Key::ArrowUp);
    window.run_steps(3);
    assert!(is_latitude(&window, 45.0), "{}", value(&window, LATITUDE));
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    type_letters(&mut window, "7");
    leave_by(&mut window, Key::Enter);
    assert_eq!(value(&window, LATITUDE), 7.0);
}

#[test]
fn an_arrow_key_leaves_a_text_without_a_number() {
    let mut window = window_without_images(MARS);
    for text in ["12x", "95"] {
        enter_field(&mut window, LATITUDE);
        type_letters(&mut window, text);
        window.key_press(Key::ArrowUp);
        window.run_steps(3);
        assert_eq!(value(&window, LATITUDE), 0.0, "{text}");
        assert!(window.state().reply_text().contains(text), "{text}: {}", window.state().reply_text());
        let field = window.get_by_role_and_label(Role::SpinButton, LATITUDE).accesskit_node().value().unwrap_or_default();
        assert!(field.contains(text), "{text} has become {field}");
        leave_by(&mut window, Key::Escape);
        // The message once stayed, although the text was gone.
        assert_eq!((value(&window, LATITUDE), window.state().reply_text()), (0.0, ""), "{text}, after Escape");
    }
}

/// So does the message about a date. A message about something else stays.
#[test]
fn escape_ends_the_message_about_a_text_that_was_refused() {
    let mut window = window_without_images(MARS);
    for (role, field, text) in [(Role::SpinButton, LATITUDE, "95"), (Role::TextInput, "Date and time", "soon")] {
        window.get_by_role_and_label(role, field).focus();
        window.run_steps(2);
        window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        window.run_steps(2);
        type_letters(&mut window, text);
        leave_by(&mut window, Key::Enter);
        assert!(window.state().reply_text().contains(text), "{field}: {}", window.state().reply_text());
        window.get_by_role_and_label(role, field).focus();
        window.run_steps(2);
        leave_by(&mut window, Key::Escape);
        assert_eq!(window.state().reply_text(), "", "{field}");
    }
    window.state_mut().show_reply("Link copied");
    enter_field(&mut window, LATITUDE);
    leave_by(&mut window, Key::Escape);
    assert_eq!(window.state().reply_text(), "Link copied");
}

/// Escape takes back the steps, too, whether or not something was typed before, between or after them.
#[test]
fn escape_restores_the_value_from_before_the_steps() {
    let mut window = window_without_images(MARS);
    enter_field(&mut window, LATITUDE);
    type_letters(&mut window, "12.34567891");
    leave_by(&mut window, Key::Enter);
    for (before, after) in [("", ""), ("40", ""), ("", "50"), ("40", "50x")] {
        enter_field(&mut window, LATITUDE);
        type_letters(&mut window, before);
        for _ in 0..2 {
            window.key_press(Key::ArrowUp);
            window.run_steps(3);
        }
        assert!((value(&window, LATITUDE) - 12.345_678_91).abs() > 0.1, "the keys step nothing");
        type_letters(&mut window, after);
        leave_by(&mut window, Key::Escape);
        assert_eq!((value(&window, LATITUDE), window.state().reply_text()), (12.345_678_91, ""), "{before}, {after}");
    }
    // Without Escape the steps count.
    enter_field(&mut window, LATITUDE);
    window.key_press(Key::ArrowUp);
    window.run_steps(3);
    leave_by(&mut window, Key::Tab);
    assert!(value(&window, LATITUDE) > 12.4, "{}", value(&window, LATITUDE));
}

/// Undo takes back what was typed since the field got the focus. Texts that it showed earlier once came back, and counted.
#[test]
fn undo_stops_at_the_text_with_which_the_field_got_the_focus() {
    let mut window = window_without_images(MARS);
    enter_field(&mut window, LATITUDE);
    type_letters(&mut window, "12");
    leave_by(&mut window, Key::Enter);
    for key in [Key::Tab, Key::Enter] {
        enter_field(&mut window, LATITUDE);
        for _ in 0..3 {
            advance(&mut window, 1.5);
            window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
            window.run_steps(2);
        }
        leave_by(&mut window, key);
        assert_eq!(value(&window, LATITUDE), 12.0, "{key:?}");
    }
    enter_field(&mut window, LATITUDE);
    advance(&mut window, 1.5);
    type_letters(&mut window, "34");
    advance(&mut window, 1.5);
    for _ in 0..3 {
        window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        window.run_steps(2);
    }
    leave_by(&mut window, Key::Enter);
    assert_eq!(value(&window, LATITUDE), 12.0, "undo takes back nothing");
}

/// A window with an open calendar and a running clock, whose rate is the preset after this many faster ones.
fn window_with_running_clock(faster: usize) -> Window {
    let mut window = window_without_images(MARS);
    window.get_by_role_and_label(Role::Button, "Calendar").click();
    window.run_steps(3);
    window.state_mut().viewer.time_rate.toggle_pause();
    (0..faster).for_each(|_| window.state_mut().viewer.time_rate.faster());
    window
}

/// Real time and scene time, seconds.
fn clocks_s(window: &Window) -> [f64; 2] {
    [window.ctx.input(|input| input.time), window.state().viewer.view.tdb_s]
}

/// The clock shows midnight at first and changes the field several times while the text is typed, but until the text counts it is far from the typed number.
/// After that it runs on for a few frames.
#[test]
fn a_running_clock_leaves_a_typed_text() {
    for (faster, field, text, wait_s, max_later) in
        [(0, "Second", "45", 1.5, 2.0), (2, "Second", "45", 0.02, 10.0), (4, "Minute", "45", 0.02, 10.0), (6, "Hour", "20", 0.02, 3.0)]
    {
        let mut window = window_with_running_clock(faster);
        enter_field(&mut window, field);
        for letter in text.chars() {
            type_text(&mut window, &letter.to_string());
            advance(&mut window, wait_s);
        }
        leave_by(&mut window, Key::Enter);
        let later = value(&window, field) - text.parse::<f64>().expect("a number");
        assert!((0.0..=max_later).contains(&later), "{field}, rate {faster}: {later} later than typed");
        assert_eq!(window.state().reply_text(), "", "{field}, rate {faster}");
    }
    // The comparison must be able to fail: the text of a field of egui is lost.
    let without_names = Harness::builder().renderer(CpuTestRenderer(Painter::default())).with_accessibility_check(false);
    let mut plain = without_names.build_ui_state(
        |ui, value: &mut f64| {
            *value += 1.0;
            ui.add(egui::DragValue::new(value).update_while_editing(false));
        },
        1000.0,
    );
    plain.run_steps(2);
    plain.get_by_role(Role::SpinButton).focus();
    plain.run_steps(2);
    for letter in ["4", "5"] {
        plain.event(Event::Text(letter.into()));
        plain.run_steps(2);
    }
    plain.key_press(Key::Enter);
    plain.run_steps(3);
    assert!(*plain.state() > 1000.0, "{}", plain.state());
}

/// Without typing, a field leaves the running clock as it is. The same number typed anew counts.
#[test]
fn only_typing_sets_a_running_clock() {
    const FASTER: usize = 4;
    const RATE: f64 = 3600.0;
    for key in [Key::Tab, Key::Enter, Key::Escape] {
        let mut window = window_with_running_clock(FASTER);
        let start_s = clocks_s(&window);
        enter_field(&mut window, "Minute");
        window.run_steps(10);
        leave_by(&mut window, key);
        let [real_s, scene_s] = [0, 1].map(|k| clocks_s(&window)[k] - start_s[k]);
        assert!(real_s > 0.2 && (scene_s - RATE * real_s).abs() < 0.1, "{key:?}: {scene_s} in {real_s} seconds");
    }
    let mut window = window_with_running_clock(FASTER);
    enter_field(&mut window, "Minute");
    let entered = value(&window, "Minute");
    window.run_steps(20);
    assert_eq!(value(&window, "Minute"), entered, "the value that is edited changes");
    type_letters(&mut window, &format!("{entered:02}"));
    leave_by(&mut window, Key::Enter);
    let later = value(&window, "Minute") - entered;
    assert!((0.0..=10.0).contains(&later), "{later} minutes later than typed");
}

/// Types a text into each field that is shown, and returns how many there are. Each must keep its value and say why.
fn refuse_in_each_field(window: &mut Window, place: &str) -> usize {
    let count = values(window).len();
    for index in 0..count {
        let before = values(window);
        window.state_mut().show_reply("");
        let field = window.query_all_by_role(Role::SpinButton).nth(index).expect("a field");
        assert!(!field.accesskit_node().is_disabled(), "{place}, field {index}");
        field.focus();
        window.run_steps(2);
        window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        window.run_steps(2);
        type_letters(window, "1 zz");
        leave_by(window, Key::Enter);
        assert_eq!(values(window), before, "{place}, field {index}");
        assert!(window.state().reply_text().contains("1 zz"), "{place}, field {index}: {}", window.state().reply_text());
    }
    count
}

#[test]
fn no_field_takes_the_readable_beginning_of_a_text() {
    let mut window = window_without_images(MARS);
    // So that the slider of the exposure is shown.
    window.state_mut().viewer.view.exposure_stops = Some(7.0);
    let mut count = 0;
    for tab in Tab::ALL {
        window.state_mut().tab = Some(tab);
        window.run_steps(3);
        count += refuse_in_each_field(&mut window, &format!("{tab:?}"));
    }
    window.get_by_role_and_label(Role::Button, "Calendar").click();
    window.run_steps(3);
    count += refuse_in_each_field(&mut window, "the calendar");
    // Three beside the list of bodies in each of the panels; eight of the Share panel, the exposure, four of the calendar.
    assert!(count > 30, "{count} fields");
    // The comparison must be able to fail: a field of egui without the program's reading.
    let without_names = Harness::builder().renderer(CpuTestRenderer(Painter::default())).with_accessibility_check(false);
    let mut plain = without_names.build_ui_state(
        |ui, value: &mut f64| {
            ui.add(egui::DragValue::new(value));
        },
        7.0,
    );
    plain.run_steps(2);
    plain.get_by_role(Role::SpinButton).focus();
    plain.run_steps(2);
    for letter in ["1", " ", "z", "z"] {
        plain.event(Event::Text(letter.into()));
        plain.run_steps(2);
    }
    plain.key_press(Key::Enter);
    plain.run_steps(3);
    assert_ne!(*plain.state(), 7.0, "the beginning of a text is not detected");
}
