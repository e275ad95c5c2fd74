//! The window in German: the choice applies at once and is kept; numbers, dates and texts in images are German; no common English words remain; buttons lie
//! inside the window, and no more texts are truncated than in English.

use crate::view::input::window_without_images;
use crate::view::interface::{harness, interface, session, settle, swept_tabs};
use egui::accesskit::Role;
use egui::epaint::{ClippedShape, Shape};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::message::TextLanguage;
use orrery::scene::request::{Layers, Position, ViewRequest};
use orrery::time::Instant;
use orrery::view::app::body_positions::SessionPositions;
use orrery::view::app::viewer::Action;
use orrery::view::language::Language;
use orrery::view::panels::{Interface, Tab};

const SATURN: NaifId = NaifId(699);
const EQUINOX: &str = "2017-05-17T00:00:00Z";

type Window = Harness<'static, Interface>;

#[test]
fn a_language_applies_at_once_and_is_kept() {
    let mut harness = harness(interface(SATURN, EQUINOX));
    let choose = |harness: &mut Window, name: &str| {
        harness.get_by_label(name).scroll_to_me();
        settle(harness);
        harness.get_by_label(name).click();
        settle(harness);
    };
    harness.state_mut().tab = Some(Tab::Share);
    settle(&mut harness);
    choose(&mut harness, "Deutsch");
    assert_eq!(harness.state().settings.language, Some(Language::German));
    assert!(harness.query_by_label("Lesezeichen setzen").is_some() && harness.query_by_label("Add bookmark").is_none());
    // Settings keep a panel by a name that no language changes.
    assert_eq!(harness.state().settings.panels.open_panel.as_deref(), Some("Share"));
    choose(&mut harness, "English");
    assert_eq!(harness.state().settings.language, Some(Language::English));
    assert!(harness.query_by_label("Add bookmark").is_some());
}

/// Replies are stored as texts, so those in the previous language are discarded. Messages of the session are written again: they may not have been read yet.
#[test]
fn messages_do_not_stay_in_the_previous_language() {
    let mut harness = harness(interface(SATURN, EQUINOX));
    settle(&mut harness);
    for is_reply in [true, false] {
        if is_reply {
            harness.event(egui::Event::Copy);
        } else {
            harness.state().session_messages.lock().push("earth.png: not an image".into());
        }
        harness.run_steps(1);
        assert!(!["", "earth.png: not an image"].contains(&harness.state().message_line()), "a reply: {is_reply}");
        let state = harness.state_mut();
        state.language = if state.language == Language::German { Language::English } else { Language::German };
        harness.run_steps(1);
        // The second change is from German to English.
        let expected = if is_reply { "" } else { "earth.png: not an image" };
        assert_eq!(harness.state().message_line(), expected, "a reply: {is_reply}");
    }
}

/// The error below the search field is discarded, too.
#[test]
fn a_search_error_does_not_stay_in_the_previous_language() {
    let mut harness = harness(interface(SATURN, EQUINOX));
    harness.run_steps(2);
    harness.get_by_role_and_label(Role::TextInput, "Search").focus();
    harness.run_steps(1);
    harness.get_by_role_and_label(Role::TextInput, "Search").type_text("qqqqqq");
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    assert_eq!(harness.query_all_by_label_contains("Nothing is called").count(), 1);
    harness.state_mut().language = Language::German;
    harness.run_steps(3);
    assert_eq!(harness.query_all_by_label_contains("Nothing is called").count(), 0);
}

/// A wrong effect in the Compare panel is reported in the window's language.
#[test]
fn a_wrong_effect_of_a_variant_is_reported_in_german() {
    let mut interface = interface(SATURN, EQUINOX);
    interface.language = Language::German;
    let mut harness = harness(interface);
    harness.state_mut().tab = Some(Tab::Compare);
    harness.run_steps(3);
    let name = "Rechts: Effekte zusätzlich zu denen der Ansicht";
    harness.get_by_role_and_label(Role::TextInput, name).focus();
    harness.run_steps(1);
    harness.get_by_role_and_label(Role::TextInput, name).type_text("+nonsense");
    harness.run_steps(3);
    let shown: Vec<String> = harness
        .query_all_by(|node| node.label().or(node.value()).is_some_and(|text| text.contains("nonsense") || text.contains("Rechts")))
        .filter_map(|node| node.accesskit_node().label().or(node.accesskit_node().value()))
        .collect();
    assert!(shown.iter().any(|text| text.starts_with("Rechts: Diese Ansicht ist nicht möglich")), "{shown:?}");
}

#[test]
fn numbers_and_dates_are_german() {
    let mut interface = interface(SATURN, EQUINOX);
    interface.language = Language::German;
    let mut harness = harness(interface);
    harness.state_mut().tab = Some(Tab::Information);
    settle(&mut harness);
    for text in ["297.199 km", "23,400°", "17h 44m 59,6s", "43,58° N, 142,03° O"] {
        assert!(harness.query_by_label(text).or_else(|| harness.query_by_value(text)).is_some(), "{text} is not shown");
    }
    assert!(harness.query_by_label_contains("17. Mai 2017, 21:59:10 UTC").is_some(), "the time of rise");
    harness.state_mut().tab = Some(Tab::Moments);
    settle(&mut harness);
    assert!(harness.query_by_label_contains("8. April 2024 · Der Kernschatten des Mondes").is_some(), "a moment of the catalog");
}

/// The magnitude of an eclipse is a size, not a brightness as that of a body is. The observer's place is Greenwich.
#[test]
fn the_magnitude_of_an_eclipse_is_a_size() {
    let mut interface = interface(SATURN, "1999-08-11T11:00:00Z");
    interface.language = Language::German;
    let mut harness = harness(interface);
    harness.set_size([1100.0, 1800.0].into());
    harness.state_mut().tab = Some(Tab::Information);
    settle(&mut harness);
    let count = |label: &str| harness.query_all_by_label(label).count();
    assert_eq!((count("Helligkeit"), count("Größe")), (1, 1));
}

/// No button extends beyond the left or right edge of the window, whether the window is 1100 or 760 points wide.
#[test]
fn german_buttons_fit() {
    for size in [[1100.0, 640.0], [760.0, 480.0]] {
        for tab in swept_tabs() {
            let mut harness = harness(interface(SATURN, EQUINOX));
            harness.set_size(size.into());
            harness.state_mut().tab = tab;
            harness.state_mut().language = Language::German;
            settle(&mut harness);
            for button in harness.query_all_by_role(Role::Button) {
                let (rect, name) = (button.rect(), button.accesskit_node().label().unwrap_or_default());
                assert!(rect.left() >= -0.5 && rect.right() <= size[0] + 0.5, "{tab:?}, {size:?}: {name} at {rect:?}");
            }
        }
    }
}

/// Texts truncated with an ellipsis.
fn truncated_texts(harness: &Window) -> Vec<String> {
    fn walk(shape: &Shape, out: &mut Vec<String>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| walk(shape, out)),
            Shape::Text(text) if text.galley.elided => out.push(text.galley.job.text.clone()),
            _ => {}
        }
    }
    let mut out = Vec::new();
    harness.output().shapes.iter().for_each(|ClippedShape { shape, .. }| walk(shape, &mut out));
    out
}

#[test]
fn german_truncates_no_more_texts_of_the_bars_than_english() {
    let mut interface = interface(SATURN, EQUINOX);
    interface.settings.panels.timeline_shown = true;
    let mut harness = harness(interface);
    harness.set_size([1280.0, 800.0].into());
    settle(&mut harness);
    let english = truncated_texts(&harness);
    harness.state_mut().language = Language::German;
    settle(&mut harness);
    let german = truncated_texts(&harness);
    assert!(german.len() <= english.len(), "{german:?}, in English {english:?}");
    // Negative control: the panel truncates a text, which is found.
    harness.state_mut().tab = Some(Tab::Effects);
    settle(&mut harness);
    assert!(truncated_texts(&harness).iter().any(|text| text.starts_with("seine Normalen")), "the reasons of effects are truncated");
}

/// Time that was paused while it ran backward resumes backward.
#[test]
fn the_rate_of_paused_time_is_shown_entirely_and_with_its_sign() {
    let mut harness = harness(interface(SATURN, EQUINOX));
    harness.set_size([1280.0, 800.0].into());
    let positions = SessionPositions(session());
    for action in [Action::RunAt(-59.9 * 60.0), Action::TogglePause] {
        let height_px = 600.0;
        harness.state_mut().viewer.apply(action, height_px, &positions);
    }
    for (language, text) in [(Language::English, "paused (-59.9 min/s)"), (Language::German, "Pause (-59,9 min/s)")] {
        harness.state_mut().language = language;
        settle(&mut harness);
        assert_eq!(harness.query_all_by_label(text).count(), 1, "{text}");
        let truncated = truncated_texts(&harness);
        assert!(!truncated.iter().any(|truncated| truncated == text), "{truncated:?}");
    }
}

/// Accessible names, values and descriptions of everything that the window shows.
fn reported_texts(harness: &Window) -> Vec<String> {
    fn walk(node: &egui_kittest::Node<'_>, out: &mut Vec<String>) {
        let n = node.accesskit_node();
        // The lines of a shader are code.
        if n.role() != Role::TextRun {
            out.extend([n.label(), n.value(), n.description()].into_iter().flatten());
        }
        node.children().for_each(|child| walk(&child, out));
    }
    let mut out = Vec::new();
    walk(&harness.root(), &mut out);
    out
}

/// Common English words that are neither German words nor keys or names of the program.
const ENGLISH_WORDS: [&str; 37] = [
    "the", "of", "and", "with", "from", "for", "this", "that", "is", "are", "its", "it", "to", "at", "on", "below", "above", "open",
    "close", "save", "show", "shown", "shows", "view", "time", "body", "picture", "moon", "earth", "sun", "north", "east", "every", "each",
    "drawn", "draws", "which",
];

fn english_words(text: &str) -> Vec<String> {
    let words = text.split(|c: char| !c.is_alphabetic()).map(str::to_lowercase);
    words.filter(|word| ENGLISH_WORDS.contains(&word.as_str())).collect()
}

/// No panel of a German window has one of these English words. Keys of shaders, links, file names, names of effects and citations are left out, because
/// they are the same in every language.
#[test]
fn german_panels_have_no_english_words() {
    let mut interface = interface(SATURN, EQUINOX);
    interface.language = Language::German;
    interface.settings.panels.timeline_shown = true;
    interface.body_browser_shown = true;
    let mut harness = harness(interface);
    harness.set_size([1280.0, 800.0].into());
    let is_code = |text: &str| {
        let is_source = session().catalog().moments().iter().any(|moment| text.contains(&moment.source));
        is_source
            || text.starts_with("orrery://")
            || text.contains("::")
            || text.contains('_')
            || text.contains(" = ")
            || text.contains("//")
    };
    let mut checked = 0;
    let mut errors = Vec::new();
    for tab in std::iter::once(None).chain(Tab::ALL.map(Some)) {
        harness.state_mut().tab = tab;
        settle(&mut harness);
        for text in reported_texts(&harness).into_iter().filter(|text| !is_code(text)) {
            checked += 1;
            // Names of effects and dimensions are written with hyphens.
            let plain: String = text.split_whitespace().filter(|word| !word.contains(['-', '.', '='])).collect::<Vec<_>>().join(" ");
            let found = english_words(&plain);
            if !found.is_empty() {
                errors.push(format!("{tab:?}: {found:?} in {}", text.chars().take(120).collect::<String>()));
            }
        }
    }
    assert!(checked > 600, "{checked} texts");
    assert!(errors.is_empty(), "{errors:#?}");
    // Negative control: in an English window such words are found.
    harness.state_mut().language = Language::English;
    settle(&mut harness);
    assert!(reported_texts(&harness).iter().filter(|text| !english_words(text).is_empty()).count() > 10);
}

/// Caption, scale bar, compass points and names in an image are in the language of the request.
#[test]
fn texts_in_images_are_in_the_requested_language() {
    let layers = Layers { caption: true, scale_bar: true, labels: true, grid_horizon: true, ..Layers::default() };
    let ground = Position::Ground { body: NaifId::EARTH, latitude_deg: -33.9, longitude_deg: 18.4, height_km: 1.0 };
    let time = Instant::parse("2024-04-08T18:30:00Z").expect("a time");
    let texts_of = |language: TextLanguage, position: Position| {
        let request =
            ViewRequest { position, layers, language, width: 900, height: 600, fov_deg: Some(90.0), ..ViewRequest::of(NaifId::MOON, time) };
        let scene = session().scene(&request).expect("a scene");
        let labels = scene.labels.expect("labels");
        let lines = scene.line_texts.into_iter().flat_map(|layer| layer.texts).map(|text| text.text);
        let names = labels.labels.into_iter().map(|mark| mark.name);
        labels.margin.texts.into_iter().map(|text| text.text).chain(names).chain(lines).collect::<Vec<_>>().join("|")
    };
    let away = Position::AboveTarget { towards: None, distance_radii: Some(40.0) };
    for (position, language, parts) in [
        (away, TextLanguage::German, ["Mond   8. April 2024, 18:30:00 UTC", "aus 69.496 km Entfernung, Bildfeld 90,0°", "Mond"]),
        (away, TextLanguage::English, ["Moon   2024-04-08 18:30:00 UTC", "from 69 496 km away, field of view 90.0°", "Moon"]),
        (ground, TextLanguage::German, ["Standort: Erde, 33,90° S 18,40° O", "Bildfeld", "°"]),
        (ground, TextLanguage::English, ["from Earth, 33.90° S 18.40° E", "field of view", "°"]),
    ] {
        let all = texts_of(language, position);
        assert!(parts.iter().all(|part| all.contains(part)), "{language:?}: {all}");
    }
}

/// Dates before Christ are the longest.
#[test]
fn the_date_field_shows_the_entire_date_in_every_language() {
    let mut window = window_without_images(SATURN);
    for (language, name) in [(Language::English, "Date and time"), (Language::German, "Datum und Uhrzeit")] {
        window.state_mut().language = language;
        for utc in ["2024-04-08T18:17:16Z", "-0584-05-22T14:26:00Z", "-2999-12-28T20:08:58Z"] {
            window.state_mut().viewer.view.tdb_s = Instant::parse(utc).expect(utc).tdb_seconds_past_j2000();
            window.run_steps(3);
            let field = window.get_by_role_and_label(Role::TextInput, name);
            let (text, width) = (field.accesskit_node().value().unwrap_or_default(), field.rect().width());
            let body = egui::TextStyle::Body.resolve(&window.ctx.style_of(egui::Theme::Dark));
            let needed = window.ctx.fonts_mut(|fonts| fonts.layout_no_wrap(text.clone(), body, egui::Color32::WHITE).size().x);
            assert!(!text.is_empty() && width > needed + 4.0, "{text}: {needed} of {width} points");
        }
    }
}
