//! Shortcuts while a control has the keyboard focus: letters, digits and Page Down act while it is a button, which keeps Space, Enter and the arrow keys, and
//! not while it is a text field. The key that hides all controls.

use crate::view::input::{SATURN, Window, advance, type_text, window_without_images};
use egui::accesskit::Role;
use egui::{Event, Key};
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::view::language::Language;
use orrery::view::panels::Tab;

fn focus(window: &mut Window, role: Role, name: &str) {
    window.get_by_role_and_label(role, name).focus();
    window.run_steps(2);
}

fn press(window: &mut Window, key: Key) {
    window.key_press(key);
    window.run_steps(2);
}

/// A window at rest whose button *Bodies* has the focus.
fn window_with_focused_button() -> Window {
    let mut window = window_without_images(SATURN);
    focus(&mut window, Role::Button, "Bodies");
    assert!(window.get_by_role_and_label(Role::Button, "Bodies").is_focused());
    window
}

#[test]
fn letters_digits_and_page_down_act_while_a_button_has_the_focus() {
    let mut window = window_with_focused_button();
    type_text(&mut window, "5");
    assert_eq!(window.state().tab, Some(Tab::Compare));
    type_text(&mut window, "5");
    assert_eq!(window.state().tab, None);
    type_text(&mut window, "?");
    assert!(window.state().help_shown);
    type_text(&mut window, "?");
    assert!(!window.state().help_shown);
    window.event(Event::Copy);
    window.run_steps(2);
    assert_eq!(window.state().reply_text(), "Link copied");
    press(&mut window, Key::PageDown);
    assert_ne!(window.state().viewer.view_after_flight().target, SATURN);
    assert!(window.get_by_role_and_label(Role::Button, "Bodies").is_focused(), "the focus has moved");
    type_text(&mut window, "/");
    assert!(window.get_by_role_and_label(Role::TextInput, "Search").is_focused());
}

/// With Caps Lock all letters once did nothing.
#[test]
fn letters_act_with_caps_lock() {
    let mut window = window_without_images(SATURN);
    let is_shown = window.state().body_browser_shown;
    type_text(&mut window, "B");
    assert_ne!(window.state().body_browser_shown, is_shown);
}

#[test]
fn space_enter_and_arrow_keys_belong_to_the_focused_button() {
    for (key, text) in [(Key::Space, Some(" ")), (Key::Enter, None)] {
        let mut window = window_with_focused_button();
        let is_shown = window.state().body_browser_shown;
        let is_paused = window.state().viewer.time_rate.is_paused();
        window.key_press(key);
        window.input_mut().events.extend(text.map(|text| Event::Text(text.to_owned())));
        window.run_steps(3);
        assert_ne!(window.state().body_browser_shown, is_shown, "{key:?} does not press the button");
        assert_eq!(window.state().viewer.time_rate.is_paused(), is_paused, "{key:?} also acts as a shortcut");
    }
    let pose = |window: &Window| format!("{:?}", window.state().viewer.view.camera_pose);
    let mut window = window_with_focused_button();
    let before = pose(&window);
    press(&mut window, Key::ArrowRight);
    assert_eq!(pose(&window), before, "an arrow key turns the camera");
    // The comparisons must be able to fail: without the focus these keys are shortcuts.
    press(&mut window, Key::Escape);
    press(&mut window, Key::ArrowRight);
    assert_ne!(pose(&window), before);
    let is_paused = window.state().viewer.time_rate.is_paused();
    type_text(&mut window, " ");
    assert_ne!(window.state().viewer.time_rate.is_paused(), is_paused);
}

#[test]
fn nothing_typed_into_a_text_field_is_a_shortcut() {
    for (role, name) in [(Role::TextInput, "Search"), (Role::TextInput, "Date and time"), (Role::SpinButton, "Latitude, degrees")] {
        let mut window = window_without_images(SATURN);
        // The first key arrives in the pass after the one that gave the field the focus.
        window.get_by_role_and_label(role, name).focus();
        window.event(Event::Text("5".into()));
        window.run_steps(2);
        type_text(&mut window, "4");
        type_text(&mut window, "?");
        press(&mut window, Key::PageDown);
        assert_eq!((window.state().tab, window.state().help_shown), (None, false), "{name}");
        assert_eq!(window.state().viewer.view_after_flight().target, SATURN, "{name}");
        let text = window.get_by_role_and_label(role, name).accesskit_node().value().unwrap_or_default();
        assert!(text.contains("54?"), "{name}: {text}");
    }
}

/// Whether the bars above and below the image, and the panels beside it, are shown; and whether the image fills the window.
fn shown_controls(window: &Window) -> ([bool; 3], bool) {
    let controls = [(Role::TextInput, "Search"), (Role::TextInput, "Date and time"), (Role::SpinButton, "Latitude, degrees")];
    let sky = window.get_by_label_contains("The sky: ").rect();
    // The test's window has a margin of some points.
    let fills_window = (sky.size() - window.ctx.content_rect().size()).length() < 30.0;
    (controls.map(|(role, name)| window.query_by_role_and_label(role, name).is_some()), fills_window)
}

const ALL_SHOWN: ([bool; 3], bool) = ([true; 3], false);
const ALL_HIDDEN: ([bool; 3], bool) = ([false; 3], true);

/// For a projector: the image alone, in a window or in full screen. F11 once left the bars above and below the image.
#[test]
fn u_hides_all_controls_and_escape_or_u_brings_them_back() {
    let mut window = window_with_focused_button();
    assert_eq!(shown_controls(&window), ALL_SHOWN);
    press(&mut window, Key::F11);
    assert_eq!(shown_controls(&window), ALL_SHOWN);
    type_text(&mut window, "u");
    window.run_steps(2);
    assert_eq!(shown_controls(&window), ALL_HIDDEN);
    assert!(window.state().reply_text().contains("Escape brings"), "{}", window.state().reply_text());
    // The message is over the image for some seconds only.
    advance(&mut window, 5.0);
    assert_ne!(window.state().reply_text(), "");
    advance(&mut window, 2.0);
    assert_eq!(window.state().reply_text(), "");
    // Other keys act on the image and on time.
    let is_paused = window.state().viewer.time_rate.is_paused();
    type_text(&mut window, " ");
    assert_ne!(window.state().viewer.time_rate.is_paused(), is_paused);
    let before_s = window.state().viewer.view_after_flight().tdb_s;
    type_text(&mut window, " ");
    type_text(&mut window, "e");
    window.run_steps(10);
    assert!(window.state().viewer.view_after_flight().tdb_s > before_s + 1e4, "the next event is not shown");
    assert_eq!(shown_controls(&window), ALL_HIDDEN);
    // Escape brings the controls back before it leaves the full screen.
    press(&mut window, Key::Escape);
    window.run_steps(2);
    assert_eq!((shown_controls(&window), window.state().fullscreen), (ALL_SHOWN, true));
    type_text(&mut window, "u");
    window.run_steps(2);
    assert_eq!(shown_controls(&window), ALL_HIDDEN);
    type_text(&mut window, "u");
    window.run_steps(2);
    assert_eq!((shown_controls(&window), window.state().reply_text()), (ALL_SHOWN, ""));
}

/// The message was once recognised by its text, and dropped at a change of the language: then nothing said how the controls come back.
#[test]
fn the_message_about_hidden_controls_is_in_the_new_language_and_ends_with_them() {
    let mut window = window_without_images(SATURN);
    type_text(&mut window, "u");
    let english = window.state().reply_text().to_owned();
    window.state_mut().language = Language::German;
    window.run_steps(2);
    let german = window.state().reply_text().to_owned();
    assert!(german != english && german.contains("Esc"), "{english}, then {german}");
    type_text(&mut window, "u");
    assert_eq!((window.state().image_only, window.state().reply_text()), (false, ""));
    // Another reply stays although the controls come back.
    type_text(&mut window, "u");
    window.event(Event::Copy);
    window.run_steps(2);
    let copied = window.state().reply_text().to_owned();
    assert!(!copied.is_empty() && copied != german, "{copied}");
    type_text(&mut window, "u");
    assert_eq!((window.state().image_only, window.state().reply_text()), (false, copied.as_str()));
}

/// A key that shows a control brings back all of them, and never closes what was hidden with them.
#[test]
fn keys_that_show_a_control_bring_back_hidden_ones() {
    let mut window = window_without_images(SATURN);
    type_text(&mut window, "5");
    type IsShown = fn(&Window) -> bool;
    let cases: [(&str, IsShown); 5] = [
        ("5", |window| window.state().tab == Some(Tab::Compare)),
        ("b", |window| window.state().body_browser_shown),
        ("i", |window| window.state().settings.panels.timeline_shown),
        ("?", |window| window.state().help_shown),
        ("/", |window| window.get_by_role_and_label(Role::TextInput, "Search").is_focused()),
    ];
    for (key, is_shown) in cases {
        type_text(&mut window, "u");
        window.run_steps(2);
        assert!(window.state().image_only, "{key}");
        type_text(&mut window, key);
        window.run_steps(2);
        assert!(!window.state().image_only && is_shown(&window), "{key}");
    }
}
