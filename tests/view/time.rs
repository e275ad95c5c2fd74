//! The time bar: calendar, rate, neighbouring events. Also hints, messages, and clicks on bodies.

use crate::view::input::{Window, advance, click, type_text, window_without_images};
use crate::view::interface::{harness, interface, settle};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton};
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::scene::request::Quality;
use orrery::time::Instant;
use orrery::view::app::settings::HintsFollowed;
use orrery::view::language::Language;
use orrery::view::panels::Tab;

fn utc(window: &Window) -> String {
    window.state().viewer.view.time().to_utc_iso()
}

fn press(window: &mut Window, name: &str) {
    window.get_by_role_and_label(Role::Button, name).click();
    window.run_steps(3);
}

#[test]
fn a_day_is_chosen_from_the_calendar_and_escape_closes_it() {
    let mut window = window_without_images(NaifId(499));
    press(&mut window, "Calendar");
    press(&mut window, "24 May 2017");
    assert_eq!(utc(&window), "2017-05-24T00:00:00Z");
    // The calendar stays open for days of the next and the previous months.
    for (month, day, date) in [
        ("Next month", "30 June 2017", "2017-06-30"),
        ("Previous month", "31 May 2017", "2017-05-31"),
        ("Previous month", "1 April 2017", "2017-04-01"),
    ] {
        press(&mut window, month);
        press(&mut window, day);
        assert_eq!(utc(&window)[..10], *date, "{day}");
    }
    window.key_press(Key::Escape);
    window.run_steps(3);
    assert!(window.query_by_label("Next month").is_none() && !window.state().quit_requested);
}

/// Gives the date field the focus and types a text into it.
fn type_date(window: &mut Window, text: &str) {
    window.state_mut().show_reply("");
    window.get_by_role_and_label(Role::TextInput, "Date and time").focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    type_text(window, text);
}

#[test]
fn a_typed_date_counts_by_tab_and_by_a_click_elsewhere_but_not_by_escape() {
    const START: &str = "2017-05-17T00:00:00Z";
    /// What the user does, and how a test does it.
    type Leave = (&'static str, fn(&mut Window));
    let leave_by: [Leave; 4] = [
        ("Enter", |window| window.key_press(Key::Enter)),
        ("Tab", |window| window.key_press(Key::Tab)),
        ("a click in the image", |window| {
            let place = window.get_by_label_contains("The sky:").rect().center();
            click(window, place);
        }),
        ("a click on a button", |window| {
            let place = window.get_by_role_and_label(Role::Button, "Bodies").rect().center();
            click(window, place);
        }),
    ];
    for (how, leave) in leave_by {
        for (text, expected, reply) in [
            ("8.4.2024 18:17", "2024-04-08T18:17:00Z", ""),
            ("1 January 2025", "2025-01-01T00:00:00Z", ""),
            ("99.99.2024", START, "99.99.2024"),
        ] {
            let mut window = window_without_images(NaifId(499));
            type_date(&mut window, text);
            leave(&mut window);
            window.run_steps(4);
            let answer = window.state().reply_text();
            assert!(utc(&window) == expected && answer.contains(reply) && answer.is_empty() == reply.is_empty(), "{how}: {text}: {answer}");
        }
    }
    // These must leave the time: Escape, and a field that is only visited.
    let mut window = window_without_images(NaifId(499));
    for text in ["8.4.2024 18:17", "99.99.2024"] {
        type_date(&mut window, text);
        window.key_press(Key::Escape);
        window.run_steps(4);
        assert_eq!((utc(&window).as_str(), window.state().reply_text()), (START, ""), "{text}");
    }
    window.get_by_role_and_label(Role::TextInput, "Date and time").focus();
    window.run_steps(2);
    window.key_press(Key::Tab);
    window.run_steps(4);
    assert_eq!((utc(&window).as_str(), window.state().reply_text()), (START, ""), "visited");
}

/// A date that is typed, then changed back, leaves the time by Tab: the clock may have gone on meanwhile. By Enter it counts.
#[test]
fn a_date_that_is_changed_back_counts_only_by_enter() {
    for (key, expected) in [(Key::Tab, "2020-01-01T00:00:00Z"), (Key::Enter, "2017-05-17T00:00:00Z")] {
        let mut window = window_without_images(NaifId(499));
        type_date(&mut window, "2");
        type_date(&mut window, "2017-05-17 00:00:00");
        // In place of a running clock.
        window.state_mut().viewer.view.tdb_s = Instant::parse("2020-01-01T00:00:00Z").expect("a time").tdb_seconds_past_j2000();
        window.run_steps(2);
        window.key_press(key);
        window.run_steps(4);
        assert_eq!((utc(&window).as_str(), window.state().reply_text()), (expected, ""), "{key:?}");
    }
}

/// The text of the date field.
fn date_text(window: &Window) -> String {
    window.get_by_role_and_label(Role::TextInput, "Date and time").accesskit_node().value().unwrap_or_default()
}

/// The text once ran on with the clock, and undo brought back a text that was shown earlier, which then counted.
#[test]
fn the_date_field_keeps_its_text_while_it_has_the_focus() {
    /// Scene seconds in a real second, at the fourth preset above real time.
    const RATE: f64 = 3600.0;
    let mut window = window_without_images(NaifId(499));
    window.state_mut().viewer.time_rate.toggle_pause();
    (0..4).for_each(|_| window.state_mut().viewer.time_rate.faster());
    let clocks_s = |window: &Window| [window.ctx.input(|input| input.time), window.state().viewer.view.tdb_s];
    // The undo of the second visit may find the texts of the first one.
    for visit in 0..2 {
        let before = date_text(&window);
        advance(&mut window, 1.5);
        advance(&mut window, 1.5);
        assert_ne!(date_text(&window), before, "visit {visit}: without the focus it follows the clock");
        let start_s = clocks_s(&window);
        window.get_by_role_and_label(Role::TextInput, "Date and time").focus();
        window.run_steps(2);
        let entered = date_text(&window);
        for _ in 0..3 {
            advance(&mut window, 1.5);
            assert_eq!(date_text(&window), entered, "visit {visit}: it follows the clock");
            window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
            window.run_steps(2);
            assert_eq!(date_text(&window), entered, "visit {visit}: undo");
        }
        window.key_press(Key::Tab);
        window.run_steps(3);
        let [real_s, scene_s] = [0, 1].map(|k| clocks_s(&window)[k] - start_s[k]);
        assert!(real_s > 4.0 && (scene_s - RATE * real_s).abs() < 1.0, "visit {visit}: {scene_s} in {real_s} seconds");
    }
    // What the user types is undone.
    type_date(&mut window, "2");
    let entered = date_text(&window);
    advance(&mut window, 1.5);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run_steps(2);
    assert_ne!(date_text(&window), entered, "undo takes back nothing");
}

/// A date that is half typed when another window gets the keyboard is still there afterwards.
#[test]
fn a_typed_date_outlives_a_look_into_another_window() {
    let mut window = window_without_images(NaifId(499));
    type_date(&mut window, "8.4.2024 18:17");
    for has_keyboard in [false, true] {
        window.input_mut().focused = has_keyboard;
        window.event(Event::WindowFocused(has_keyboard));
        window.run_steps(3);
    }
    window.key_press(Key::Enter);
    window.run_steps(4);
    assert_eq!((utc(&window).as_str(), window.state().reply_text()), ("2024-04-08T18:17:00Z", ""));
}

/// Hour, minute and second are below the days, with a colon between each two.
#[test]
fn the_time_of_day_is_separated_from_the_date() {
    let mut window = window_without_images(NaifId(499));
    press(&mut window, "Calendar");
    let left_of = |name: &str| window.get_by_role_and_label(Role::SpinButton, name).rect().left();
    let fields = ["Hour", "Minute", "Second"].map(left_of);
    let mut colons: Vec<f32> = window.query_all_by_label(":").map(|colon| colon.rect().left()).collect();
    colons.sort_by(f32::total_cmp);
    let [first, second] = colons[..] else { panic!("{colons:?}") };
    assert!(fields[0] < first && first < fields[1] && fields[1] < second && second < fields[2], "{fields:?}, {colons:?}");
    assert!(window.get_by_label("Time of day").rect().top() > window.get_by_label("31 May 2017").rect().bottom());
}

/// egui does not wrap a slider by itself: that of the rate once extended beyond a narrow window, and so did the timeline, whose middle is the displayed time.
#[test]
fn the_time_bar_fits_windows_of_any_width() {
    for (language, names) in [(Language::English, ["Rate of time", "Timeline"]), (Language::German, ["Tempo der Zeit", "Zeitleiste"])] {
        let mut window = window_without_images(NaifId(499));
        window.state_mut().settings.panels.timeline_shown = true;
        window.state_mut().language = language;
        for width in (600..=1300).step_by(20).map(|width| width as f32) {
            window.set_size(egui::vec2(width, 640.0));
            window.run_steps(3);
            let [rate, timeline] = names.map(|name| window.get_by_role_and_label(Role::Slider, name).rect());
            assert!(rate.width() > 90.0 && rate.right() <= width, "{language:?}, {width} points: the rate is at {rate}");
            // The margins of the test window and of the bar are 8 points wide each.
            assert!((width - 16.0 - timeline.right()).abs() < 2.0, "{language:?}, {width} points: the timeline is at {timeline}");
        }
    }
}

#[test]
fn the_slider_of_the_rate_is_logarithmic() {
    let mut window = window_without_images(NaifId(499));
    let slider = window.get_by_role_and_label(Role::Slider, "Rate of time").rect();
    window.get_by_role_and_label(Role::Button, "Play").click();
    window.run_steps(2);
    let mut rates = Vec::new();
    for fraction in [0.1, 0.3, 0.5, 0.7, 0.9] {
        click(&mut window, slider.left_center() + egui::vec2(fraction * slider.width(), 0.0));
        window.run_steps(2);
        rates.push(window.state().viewer.time_rate.rate().log10());
    }
    // The slider spans 7.5 decades, from real time to a year per second: equal steps are equal factors.
    let steps: Vec<f64> = rates.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().all(|s| (1.2..2.4).contains(s)), "{rates:?}");
    assert!(rates[4] - rates[0] > 5.5, "{rates:?}");
}

#[test]
fn one_press_leads_to_the_next_or_previous_event() {
    let mut window = window_without_images(NaifId(499));
    window.state_mut().viewer.view.tdb_s = Instant::parse("2024-01-01").expect("a time").tdb_seconds_past_j2000();
    // NASA's eclipse bulletins: 2023-10-14 17:59:32, 2024-04-08 18:17:20, 2024-10-02 18:45:04 UT.
    for (button, event_time) in [
        ("Next event", "2024-04-08T18:1"),
        ("Next event", "2024-10-02T18:4"),
        ("Previous event", "2024-04-08T18:1"),
        ("Previous event", "2023-10-14T17:59"),
    ] {
        press(&mut window, button);
        window.run_steps(3);
        assert!(utc(&window).starts_with(event_time), "{button}: {} and not {event_time}", utc(&window));
    }
    window.get_by_role_and_label(Role::ComboBox, "Kind of event").click();
    window.run_steps(2);
    window.get_by_label("Transits").click();
    window.run_steps(2);
    press(&mut window, "Next event");
    window.run_steps(3);
    // Mercury, 2032-11-13 08:54 UT (NASA, catalog of transits).
    assert!(utc(&window).starts_with("2032-11-13T08:5"), "{}", utc(&window));
}

/// Each hint disappears after its gesture, and does not return.
#[test]
fn hints_disappear_when_used() {
    let mut first_start = interface(NaifId(499), "2017-05-17T00:00:00Z");
    first_start.settings.hints_followed = HintsFollowed::default();
    let mut window = harness(first_start);
    settle(&mut window);
    const HINTS: [&str; 3] = ["Drag to turn", "Scroll to zoom", "Press / to search"];
    let hints_shown = |window: &Window| HINTS.map(|hint| window.query_by_label(hint).is_some());
    assert_eq!(hints_shown(&window), [true; 3]);
    let image_centre = window.get_by_label_contains("The sky:").rect().center();
    let button = |pos, pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    window.hover_at(image_centre);
    window.event(button(image_centre, true));
    window.run_steps(1);
    window.hover_at(image_centre + egui::vec2(60.0, 20.0));
    window.run_steps(2);
    window.event(button(image_centre + egui::vec2(60.0, 20.0), false));
    window.run_steps(2);
    assert_eq!(hints_shown(&window), [false, true, true]);
    window.event(Event::Zoom(1.5));
    window.run_steps(2);
    assert_eq!(hints_shown(&window), [false, false, true]);
    window.event(Event::Text("/".into()));
    window.run_steps(2);
    window.event(Event::Text("moon".into()));
    window.run_steps(2);
    window.key_press(Key::Enter);
    settle(&mut window);
    assert_eq!(hints_shown(&window), [false; 3]);
    assert_eq!(window.state().settings.hints_followed, HintsFollowed { drag: true, scroll: true, search: true });
}

/// Messages about drivers appear only in the Performance panel. Other messages also appear over the image, for a while.
#[test]
fn driver_messages_do_not_cover_the_image() {
    let mut window = window_without_images(NaifId(499));
    let line = "llvmpipe is a software driver: drawing in software; --renderer gpu uses the driver nevertheless";
    window.state().session_messages.lock().push(line.into());
    window.run_steps(2);
    assert_eq!(window.state().message_line(), "");
    window.state().session_messages.lock().push("earth.png: not an image".into());
    window.run_steps(2);
    assert_eq!(window.state().message_line(), "earth.png: not an image");
    window.state_mut().tab = Some(Tab::Performance);
    window.run_steps(2);
    window.get_by_label(line);
    advance(&mut window, 20.0);
    assert_eq!(window.state().message_line(), "");
}

#[test]
fn all_messages_of_a_frame_are_shown() {
    let mut window = window_without_images(NaifId(499));
    let lines = ["earth.png: not an image", "moon.png: not an image"];
    window.state().session_messages.lock().extend(lines.map(String::from));
    window.run_steps(2);
    assert_eq!(window.state().message_line(), lines.join("\n"));
}

/// Replies are shown for 20 seconds. 30 seconds after the first copy, the reply to the second one is 15 seconds old.
#[test]
fn a_repeated_reply_is_shown_for_its_full_time() {
    let mut window = window_without_images(NaifId(499));
    for _ in 0..2 {
        window.event(Event::Copy);
        window.run_steps(2);
        advance(&mut window, 15.0);
        assert_ne!(window.state().message_line(), "");
    }
    advance(&mut window, 10.0);
    assert_eq!(window.state().message_line(), "");
}

/// A click selects a body without lowering the resolution, and a change of the view lowers it.
#[test]
fn a_click_keeps_the_full_resolution() {
    let mut window = harness(interface(NaifId(499), "2017-05-17T00:00:00Z"));
    window.state_mut().viewer.view.quality = Quality::Standard;
    settle(&mut window);
    let size_and_sampling = |window: &Window| window.state().shown().map(|d| (d.width, d.job.sampling)).expect("an image");
    let full = size_and_sampling(&window);
    window.state_mut().viewer.selected = NaifId::SUN;
    let image_centre = window.get_by_label_contains("The sky:").rect().center();
    click(&mut window, image_centre);
    for _ in 0..6 {
        assert_eq!(size_and_sampling(&window), full);
        advance(&mut window, 0.05);
    }
    assert_eq!(window.state().viewer.selected, NaifId(499));
    // Negative control: a change of the view does lower it.
    window.key_press(Key::ArrowLeft);
    window.run_steps(2);
    assert_ne!(size_and_sampling(&window), full);
}

#[test]
fn a_right_click_opens_the_menu_of_a_body() {
    let mut window = harness(interface(NaifId(499), "2017-05-17T00:00:00Z"));
    settle(&mut window);
    let image_centre = window.get_by_label_contains("The sky:").rect().center();
    let button =
        |pressed| Event::PointerButton { pos: image_centre, button: PointerButton::Secondary, pressed, modifiers: Modifiers::NONE };
    window.state_mut().viewer.selected = NaifId::SUN;
    window.hover_at(image_centre);
    window.run_steps(1);
    window.event(button(true));
    window.run_steps(1);
    window.event(button(false));
    window.run_steps(3);
    window.get_by_label("Fly there");
    assert_eq!(window.state().viewer.selected, NaifId(499), "the right-clicked body is selected");
    window.get_by_label("Information about it").click();
    window.run_steps(3);
    assert_eq!(window.state().tab, Some(Tab::Information));
    assert!(window.query_by_label("Fly there").is_none(), "the menu stays after a choice");
    let copy = window.query_by_label("Copy link to this view");
    assert!(copy.is_none_or(|n| n.accesskit_node().is_hidden()));
}

/// *Measure from here* starts at the place of the right click, although the image has another size by the time the command is chosen.
#[test]
fn a_measurement_starts_at_the_right_clicked_place() {
    let mut window = harness(interface(NaifId(499), "2017-05-17T00:00:00Z"));
    window.set_size(egui::vec2(800.0, 500.0));
    settle(&mut window);
    let image_centre = |window: &Window| window.get_by_label_contains("The sky:").rect().center();
    let press_and_release = |window: &mut Window, button: PointerButton, modifiers: Modifiers| {
        let pos = image_centre(window);
        window.hover_at(pos);
        window.run_steps(1);
        for pressed in [true, false] {
            window.event(Event::PointerButton { pos, button, pressed, modifiers });
            window.run_steps(1);
        }
        window.run_steps(3);
    };
    press_and_release(&mut window, PointerButton::Secondary, Modifiers::NONE);
    window.get_by_label("Measure from here");
    window.set_size(egui::vec2(1500.0, 1000.0));
    settle(&mut window);
    window.get_by_label("Measure from here").click();
    window.run_steps(3);
    assert!(window.state().reply_text().contains("second place"), "{}", window.state().reply_text());
    window.event(Event::ModifiersChanged(Modifiers::COMMAND));
    window.run_steps(1);
    press_and_release(&mut window, PointerButton::Primary, Modifiers::COMMAND);
    // Both places are the middle of the image, within a pixel: less than a degree apart.
    let message = window.state().reply_text();
    assert!(message.starts_with("Angle: ") && !message.contains('°'), "{message}");
}
