//! The window by keyboard, screen reader and touchpad: accessible names, focus order, keys and gestures.

use crate::view::input::{Window, window_without_images};
use crate::view::interface::{harness, harness_of, interface, session, settle};
use egui::accesskit::{Action, Role};
use egui::{Event, Key, Modifiers, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::time::Instant;
use orrery::view::app::view_state::CameraPose;
use orrery::view::language::Language;
use orrery::view::link::view_from_text;
use orrery::view::panels::{Interface, Tab};

const SATURN: NaifId = NaifId(699);

fn saturn() -> Harness<'static, Interface> {
    let mut harness = harness(interface(SATURN, "2017-05-17T00:00:00Z"));
    settle(&mut harness);
    harness
}

fn press_keys(harness: &mut Harness<'static, Interface>, keys: &[Key]) {
    for key in keys {
        harness.key_press(*key);
        harness.run_steps(2);
    }
}

fn advance_time(harness: &mut Harness<'static, Interface>, seconds: f64) {
    let next = harness.input_mut().time.unwrap_or(0.0) + seconds;
    harness.input_mut().time = Some(next);
    harness.run_steps(1);
}

#[test]
fn a_screen_reader_is_told_what_the_window_shows() {
    let mut harness = saturn();
    let title = |h: &Harness<'static, Interface>| h.root().accesskit_node().label().unwrap_or_default();
    assert_eq!(title(&harness), "Saturn · paused · Orrery");
    harness.state_mut().tab = Some(Tab::Performance);
    settle(&mut harness);
    let plot = harness.get_by_role_and_label(Role::Image, "Frame times").accesskit_node().value().unwrap_or_default();
    assert!(plot.contains("frames") && plot.contains("draw") && plot.contains(" ms"), "{plot}");
    // While time runs, the announced title does not change, and the announced time changes only from minute to minute.
    harness.state_mut().settings.panels.timeline_shown = true;
    harness.state_mut().viewer.time_rate.toggle_pause();
    advance_time(&mut harness, 0.1);
    let timeline_day = |h: &Harness<'static, Interface>| {
        h.get_by_role_and_label(Role::Slider, "Timeline").accesskit_node().numeric_value().expect("a number")
    };
    let (first, first_title) = (timeline_day(&harness), title(&harness));
    let mut announced = std::collections::BTreeSet::new();
    for _ in 0..45 {
        advance_time(&mut harness, 2.0);
        announced.insert(timeline_day(&harness).to_bits());
        assert_eq!(title(&harness), first_title);
    }
    // From the first of these times to the last are 88 seconds, which contain the end of one minute or of two.
    assert!((2..=3).contains(&announced.len()), "{} announced times in 90 seconds", announced.len());
    // Announced times are whole minutes, so they advance by at most two; half a second is for rounding in days.
    assert!((timeline_day(&harness) - first).abs() * 86_400.0 <= 120.5);
}

#[test]
fn the_source_is_one_stop_for_the_tab_key_and_arrows_walk_its_lines() {
    let mut harness = saturn();
    harness.state_mut().tab = Some(Tab::Shader);
    settle(&mut harness);
    let stops = |h: &Harness<'static, Interface>| {
        h.query_all_by_label_contains(", needed by ").filter(|n| n.accesskit_node().data().supports_action(Action::Focus)).count()
    };
    assert!(harness.query_all_by_label_contains(", needed by ").count() > 0);
    assert_eq!(stops(&harness), 0, "a line of the margin can have the focus");
    let list = "Lines of the source";
    harness.get_by_label_contains(list).focus();
    harness.run_steps(2);
    // The number of the line that a screen reader reads.
    let line = |h: &Harness<'static, Interface>| {
        let list = h.get_by_label_contains(list);
        let at = list.accesskit_node().active_descendant().and_then(|n| n.value()).unwrap_or_default();
        at.split_whitespace().next().and_then(|number| number.parse::<usize>().ok())
    };
    assert_eq!(line(&harness), Some(1));
    press_keys(&mut harness, &[Key::ArrowDown, Key::ArrowDown, Key::ArrowUp]);
    assert_eq!(line(&harness), Some(2));
    press_keys(&mut harness, &[Key::PageDown, Key::PageDown]);
    assert_eq!(line(&harness), Some(42));
    press_keys(&mut harness, &[Key::End]);
    let last = line(&harness).expect("a line");
    assert!(last > 100, "{last} lines");
    press_keys(&mut harness, &[Key::ArrowDown]);
    assert_eq!(line(&harness), Some(last));
    press_keys(&mut harness, &[Key::Home, Key::ArrowUp]);
    assert_eq!(line(&harness), Some(1));
    // The view has not rotated and no other body is selected.
    assert_eq!(harness.state().viewer.selected, SATURN);
    assert!(harness.query_by_label_contains("Only lines for").is_none());
    press_keys(&mut harness, &[Key::Enter]);
    harness.get_by_label_contains("Only lines for");
}

#[test]
fn pinching_moves_closer_and_keeps_the_field_of_view() {
    let mut harness = saturn();
    let distance_and_fov = |h: &Harness<'static, Interface>| match h.state().viewer.view.camera_pose {
        CameraPose::Orbit { distance_radii, .. } => (distance_radii, h.state().viewer.view.fov_deg),
        other => panic!("{other:?}"),
    };
    let before = distance_and_fov(&harness);
    let sky = harness.get_by_label_contains("The sky:").rect().center();
    harness.hover_at(sky);
    harness.run_steps(1);
    harness.event(Event::Zoom(2.0));
    harness.run_steps(1);
    let after = distance_and_fov(&harness);
    assert_eq!(after.1, before.1, "the lens changed");
    let height_ratio = (after.0 - 1.0) / (before.0 - 1.0);
    assert!((height_ratio - 0.5).abs() < 1e-3, "the height became {height_ratio} of what it was");
}

#[test]
fn escape_drops_the_focus_and_keeps_the_window() {
    let mut harness = saturn();
    harness.get_by_role_and_label(Role::TextInput, "Search").focus();
    harness.run_steps(2);
    press_keys(&mut harness, &[Key::Escape]);
    assert!(!harness.state().quit_requested, "Escape in a field ended the program");
    harness.get_by_role_and_label(Role::ComboBox, "View from").click();
    harness.run_steps(2);
    harness.get_by_label("Centre of Mars");
    press_keys(&mut harness, &[Key::Escape]);
    assert!(harness.query_by_label("Centre of Mars").is_none() && !harness.state().quit_requested, "Escape closes a list and no more");
    harness.state_mut().help_shown = true;
    harness.run_steps(2);
    press_keys(&mut harness, &[Key::Escape]);
    assert!(!harness.state().help_shown && !harness.state().quit_requested);
    press_keys(&mut harness, &[Key::Escape]);
    assert!(!harness.state().quit_requested);
}

#[test]
fn keys_change_the_size_of_text() {
    let mut harness = saturn();
    let zoom = |h: &Harness<'static, Interface>| h.state().settings.ui_scale;
    for (key, expected) in [(Key::Plus, 1.1), (Key::Equals, 1.2), (Key::Minus, 1.1), (Key::Num0, 1.0)] {
        harness.key_press_modifiers(Modifiers::COMMAND, key);
        harness.run_steps(2);
        assert!((zoom(&harness) - expected).abs() < 1e-5, "{key:?}: {}", zoom(&harness));
        assert!((harness.ctx.zoom_factor() - expected).abs() < 1e-3, "{key:?}: egui has {}", harness.ctx.zoom_factor());
    }
}

#[test]
fn the_reason_why_a_link_was_not_opened_stays_until_closed() {
    let mut interface = interface(SATURN, "2017-05-17T00:00:00Z");
    interface.warning = Some("orrery://view?aim=3: unknown field `aim`".into());
    let mut harness = harness_of(session(), interface);
    settle(&mut harness);
    assert!(harness.state().shown().is_some(), "the image is drawn all the same");
    harness.get_by_label_contains("unknown field `aim`");
    // The button has the focus.
    press_keys(&mut harness, &[Key::Enter]);
    assert!(harness.query_by_label_contains("unknown field `aim`").is_none());
    assert!(harness.state().warning.is_none() && !harness.state().quit_requested);
    harness.state_mut().warning = Some("again".into());
    harness.run_steps(2);
    press_keys(&mut harness, &[Key::Escape]);
    assert!(harness.state().warning.is_none() && !harness.state().quit_requested);
}

#[test]
fn a_partial_link_opens_and_an_impossible_link_gives_a_reason() {
    let now = Instant::parse("2017-05-17T00:00:00Z").expect("a time");
    let open = |link: &str| view_from_text(link, session(), now);
    let jupiter = open("orrery://view?target=599").expect("a view");
    assert_eq!((jupiter.target, jupiter.time()), (NaifId(599), now));
    assert!(
        matches!(jupiter.camera_pose, CameraPose::Orbit { body: NaifId(599), distance_radii, .. } if (distance_radii - 3.5).abs() < 1e-9)
    );
    assert_eq!(view_from_text(&jupiter.to_link(), session(), Instant::from_tdb_seconds_past_j2000(0.0)).expect("a view"), jupiter);
    assert_eq!(open("orrery://view?target=jupiter").expect("a view"), jupiter);
    let eclipse = open("orrery://view?time=2024-04-08T18:17:16Z").expect("a view");
    assert!(eclipse.target == NaifId::EARTH && eclipse.time().to_utc_iso().starts_with("2024-04-08T18:17:16"));
    for (bad, message_part) in [
        ("orrery://view?target=424242", "424242"),
        ("orrery://view?eye.kind=centre&eye.body=424242&target=399", "424242"),
        ("orrery://view?eye.distance_radii=0.5", "inside Earth"),
        ("orrery://view?tdb_s=1e300", "outside the years -20000 to 20000"),
        ("orrery://view?tone_map=sepia", "sepia"),
        ("orrery://view?target=jupitre&fov_deg=0&tone_map=sepia", "3 errors"),
        ("{\"quality\": \"best\"}", "best"),
        ("no link", "neither a link (orrery://view?…)"),
    ] {
        let why = open(bad).expect_err(bad).to_string();
        assert!(why.contains(message_part) && !why.contains('\n'), "{bad}: {why}");
    }
}

/// In a slow frame a complete search arrives at once. All of it is text for the search field: digits of a date and letters such as e are not taken as
/// shortcuts. Escape, in the same frame or later, leaves the view unchanged.
#[test]
fn a_search_typed_within_one_frame_triggers_no_shortcut() {
    let key = |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
    let typed = |text: &str| text.chars().map(|letter| Event::Text(letter.to_string())).collect::<Vec<_>>();
    let mut harness = saturn();
    let send_in_one_frame = |harness: &mut Harness<'static, Interface>, events: Vec<Event>| {
        harness.input_mut().events.extend(events);
        harness.run_steps(8);
    };
    send_in_one_frame(&mut harness, [typed("/2009-08-11T00:15:00Z"), vec![key(Key::Enter)]].concat());
    assert!(harness.state().tab.is_none(), "a digit opened a tab");
    let time = harness.state().viewer.view.time();
    assert!(time.to_utc_iso().starts_with("2009-08-11T00:15:00"), "{}", time.to_utc_iso());
    for end in [vec![], vec![key(Key::Escape)], vec![key(Key::Enter), key(Key::Escape), key(Key::Escape)]] {
        send_in_one_frame(&mut harness, [typed("/nowhere q"), end].concat());
        settle(&mut harness);
        assert_eq!(harness.state().viewer.view.time(), time, "a letter acted as a shortcut");
        assert!(!harness.state().quit_requested, "the q in a search quits");
        press_keys(&mut harness, &[Key::Escape, Key::Escape]);
    }
    // What is typed after Escape is a shortcut again.
    send_in_one_frame(&mut harness, [typed("/mars"), vec![key(Key::Escape)], typed("3")].concat());
    assert_eq!(harness.state().tab, Some(Tab::ALL[2]));
}

/// Every button, switch, list, slider and field has an accessible description.
#[test]
fn every_control_has_a_description() {
    let mut interface = interface(NaifId(699), "2017-05-17T00:00:00Z");
    interface.settings.panels.timeline_shown = true;
    let mut harness = harness(interface);
    let mut without_description = std::collections::BTreeSet::new();
    let mut count = 0;
    for tab in std::iter::once(None).chain(Tab::ALL.map(Some)) {
        harness.state_mut().tab = tab;
        settle(&mut harness);
        for role in [Role::Button, Role::CheckBox, Role::ComboBox, Role::Slider, Role::TextInput] {
            for node in harness.query_all_by_role(role) {
                let node = node.accesskit_node();
                // The legend of a plot belongs to egui_plot.
                let is_legend = tab == Some(Tab::Performance) && role == Role::CheckBox;
                if is_legend || node.is_disabled() || !node.data().supports_action(Action::Focus) {
                    continue;
                }
                count += 1;
                if node.description().is_none_or(|d| d.is_empty()) {
                    without_description.insert(format!("{tab:?} {role:?} {}", node.label().unwrap_or_default()));
                }
            }
        }
    }
    assert!(count > 300, "{count} controls");
    assert!(without_description.is_empty(), "{} of {count}: {without_description:#?}", without_description.len());
}

/// The button of each panel opens and closes it, and so does its digit key, if it has one.
#[test]
fn each_panel_has_its_button_and_its_key() {
    let mut window = window_without_images(SATURN);
    for (k, tab) in Tab::ALL.into_iter().enumerate() {
        // The bar comes first in the window: a control of a panel may have the same name.
        let press_button =
            |window: &Window| window.get_all_by_role_and_label(Role::Button, tab.title()).next().expect("in the bar").click();
        let press_key = |window: &Window| window.event(Event::Text((k + 1).to_string()));
        for expected in [Some(tab), None] {
            press_button(&window);
            window.run_steps(3);
            assert_eq!(window.state().tab, expected, "the button of {tab:?}");
        }
        for expected in [Some(tab), None].into_iter().filter(|_| k < 9) {
            press_key(&window);
            window.run_steps(3);
            assert_eq!(window.state().tab, expected, "the key of {tab:?}");
        }
    }
}

/// The open panel, its width and its side are restored at the next start.
#[test]
fn panels_are_remembered() {
    let mut harness = saturn();
    harness.state_mut().tab = Some(Tab::Events);
    harness.state_mut().settings.panels.on_left = true;
    settle(&mut harness);
    let checkbox = |h: &Harness<'static, Interface>| h.get_by_role_and_label(Role::CheckBox, "Solar eclipses").rect();
    let checkbox_rect = checkbox(&harness);
    assert!(checkbox_rect.left() < 400.0, "at the left: {checkbox_rect}");
    let text = serde_json::to_string(&harness.state().settings).expect("text");
    let mut settings: orrery::view::app::settings::Settings = serde_json::from_str(&text).expect("settings");
    assert_eq!(settings.panels.open_panel.as_deref(), Some("Events"));
    let width = settings.panels.panel_width.expect("a width");
    assert!((280.0..500.0).contains(&width), "{width}");
    // Another window with these settings, but with a wider panel and the list of bodies hidden.
    settings.panels.panel_width = Some(width + 80.0);
    settings.panels.bodies_shown = false;
    let restored = Interface::new(interface(NaifId(699), "2017-05-17T00:00:00Z").viewer, settings);
    let mut restored = crate::view::interface::harness(restored);
    settle(&mut restored);
    assert_eq!((restored.state().tab, restored.state().body_browser_shown), (Some(Tab::Events), false));
    assert!(checkbox(&restored).left() < 40.0);
    assert!((restored.state().settings.panels.panel_width.expect("a width") - width - 80.0).abs() < 2.0);
    // A missing or invalid width in a settings file is replaced by the default.
    for width in [Some(f32::NAN), Some(-3.0), Some(1e9), None] {
        assert_eq!(orrery::view::app::settings::valid_width(width, 330.0), 330.0);
    }
}

/// Beside a wide panel the viewport stays at least as wide as between two panels: the list of bodies makes room for it.
#[test]
fn a_wide_panel_leaves_room_for_the_viewport() {
    let mut window = window_without_images(SATURN);
    for (tab, width, has_list) in
        [(Tab::Compare, 1000.0, false), (Tab::Shader, 900.0, false), (Tab::Compare, 1100.0, true), (Tab::Information, 900.0, true)]
    {
        window.state_mut().tab = Some(tab);
        window.set_size(egui::vec2(width, 640.0));
        window.run_steps(5);
        let sky = window.get_by_label_contains("The sky:").rect();
        assert!(sky.width() >= 310.0, "{tab:?} at {width}: {sky}");
        assert_eq!(window.query_by_label("Follow target").is_some(), has_list, "{tab:?} at {width}");
    }
}

/// A panel that is kept open moves to the other side of the sky while another one opens. In a narrow window it is hidden until there is room again.
#[test]
fn a_kept_panel_stays_open_beside_another() {
    let mut harness = saturn();
    let close_button_x = |h: &Harness<'static, Interface>, panel: &str| {
        h.query_by_role_and_label(Role::Button, &format!("Close {panel}")).map(|close| close.rect().center().x)
    };
    let press = |h: &mut Harness<'static, Interface>, key: &str| {
        h.event(Event::Text(key.to_owned()));
        settle(h);
    };
    press(&mut harness, "6");
    let alone = close_button_x(&harness, "Information").expect("on the right");
    harness.get_by_label("Keep open").click();
    settle(&mut harness);
    assert!(close_button_x(&harness, "Information").expect("on the left") < alone - 200.0);
    assert_eq!((harness.state().tab, harness.state().kept_tab), (None, Some(Tab::Information)));
    press(&mut harness, "3");
    assert!(close_button_x(&harness, "Information") < close_button_x(&harness, "Effects"), "both are open, on two sides");
    // The next session opens both.
    let text = serde_json::to_string(&harness.state().settings).expect("text");
    let next = Interface::new(interface(NaifId(699), "2017-05-17T00:00:00Z").viewer, serde_json::from_str(&text).expect("settings"));
    assert_eq!((next.tab, next.kept_tab), (Some(Tab::Effects), Some(Tab::Information)));
    // Too narrow for two: the key of the hidden panel opens it in place of the other.
    harness.set_size(egui::vec2(800.0, 640.0));
    settle(&mut harness);
    assert!(close_button_x(&harness, "Information").is_none() && close_button_x(&harness, "Effects").is_some());
    assert!(harness.query_by_label("Keep open").is_none(), "there is no room to keep it");
    // Narrower still, the list of bodies makes room for an open panel.
    assert!(harness.query_by_label("Follow target").is_some());
    harness.set_size(egui::vec2(640.0, 480.0));
    settle(&mut harness);
    assert!(harness.query_by_label("Follow target").is_none() && close_button_x(&harness, "Effects").is_some());
    assert!(harness.state().body_browser_shown, "it is hidden, not closed");
    harness.set_size(egui::vec2(1100.0, 640.0));
    settle(&mut harness);
    assert!(close_button_x(&harness, "Information").is_some() && close_button_x(&harness, "Effects").is_some());
    // Escape closes the open panel, then the kept one.
    for tabs in [(None, Some(Tab::Information)), (None, None)] {
        harness.key_press(Key::Escape);
        settle(&mut harness);
        assert_eq!((harness.state().tab, harness.state().kept_tab), tabs);
    }
    // Escape keeps a panel that is hidden; it ends the full screen instead.
    harness.state_mut().kept_tab = Some(Tab::Information);
    harness.set_size(egui::vec2(800.0, 640.0));
    settle(&mut harness);
    harness.state_mut().fullscreen = true;
    harness.key_press(Key::Escape);
    settle(&mut harness);
    assert_eq!((harness.state().kept_tab, harness.state().fullscreen), (Some(Tab::Information), false));
    harness.set_size(egui::vec2(1100.0, 640.0));
    settle(&mut harness);
    // A second press of its key closes a kept panel.
    press(&mut harness, "6");
    assert_eq!((harness.state().tab, harness.state().kept_tab), (None, None));
}

/// A panel whose title is dragged to the other half of the window goes there and stays there; a shorter drag moves nothing.
#[test]
fn a_panel_is_dragged_to_the_other_side_by_its_title() {
    let mut harness = saturn();
    harness.event(Event::Text("6".to_owned()));
    settle(&mut harness);
    let close =
        |h: &Harness<'static, Interface>| h.query_by_role_and_label(Role::Button, "Close Information").expect("open").rect().center();
    let drag_title_by = |h: &mut Harness<'static, Interface>, by: f32| {
        // The title begins at the panel's left edge, on a line with the button that closes the panel.
        let panel_left = if close(h).x > 640.0 {
            h.get_by_label_contains("The sky:").rect().right()
        } else {
            h.state().settings.panels.bodies_width.unwrap_or(0.0)
        };
        let start = egui::pos2(panel_left + 24.0, close(h).y);
        h.drag_at(start);
        h.run_steps(1);
        h.hover_at(start + egui::vec2(0.5 * by, 4.0));
        h.run_steps(1);
        h.drop_at(start + egui::vec2(by, 4.0));
        settle(h);
    };
    let at_right = close(&harness).x;
    drag_title_by(&mut harness, -40.0);
    assert!((close(&harness).x - at_right).abs() < 1.0 && !harness.state().settings.panels.on_left);
    drag_title_by(&mut harness, -700.0);
    assert!(close(&harness).x < at_right - 200.0 && harness.state().settings.panels.on_left, "it is on the left, and the settings say so");
}

/// In a window of 400 x 300 points the texts of the help wrap and its rows scroll; in a large window they do neither.
#[test]
fn every_line_of_the_help_can_be_reached_in_a_small_window() {
    const SEARCH_DOES: [&str; 2] = [
        "search for bodies, stars, dates, events, places or shader keys; set an effect such as +eclipse or -rings",
        "Körper, Sterne, Daten, Ereignisse, Orte oder Shader-Schlüssel suchen; einen Effekt setzen, +eclipse oder -rings",
    ];
    let mut window = window_without_images(SATURN);
    let size = egui::vec2(400.0, 300.0);
    window.set_size(size);
    window.state_mut().help_shown = true;
    for (language, texts) in
        [(Language::English, ["Drag", SEARCH_DOES[0], "quit"]), (Language::German, ["Ziehen", SEARCH_DOES[1], "beenden"])]
    {
        window.state_mut().language = language;
        window.run_steps(5);
        for text in texts {
            window.get_by_label(text).scroll_to_me();
            window.run_steps(90);
            let rect = window.get_by_label(text).rect();
            assert!(Rect::from_min_size(egui::Pos2::ZERO, size).contains_rect(rect), "{text}: {rect}");
        }
    }
    window.set_size(egui::vec2(1400.0, 900.0));
    window.run_steps(10);
    let [wrapped, single] = [SEARCH_DOES[1], "beenden"].map(|text| window.get_by_label(text).rect());
    assert_eq!(wrapped.height(), single.height(), "a text still wraps");
    let screen = Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1400.0, 900.0));
    assert!(screen.contains_rect(window.get_by_label("Ziehen").rect()) && screen.contains_rect(single), "{single}");
}
