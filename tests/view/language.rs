//! The window in German: the choice applies at once and is kept, buttons lie inside the window, and no more texts are truncated than in
//! English.

use crate::view::interface::{harness, interface, settle};
use egui::accesskit::Role;
use egui::epaint::{ClippedShape, Shape};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
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
    assert_eq!(harness.state().settings.panels.open.as_deref(), Some("Share"));
    choose(&mut harness, "English");
    assert_eq!(harness.state().settings.language, Some(Language::English));
    assert!(harness.query_by_label("Add bookmark").is_some());
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
    assert!(harness.query_by_label_contains("17. Mai 2017, 21:59:10,206 UTC").is_some(), "the time of rise");
    harness.state_mut().tab = Some(Tab::Moments);
    settle(&mut harness);
    assert!(harness.query_by_label_contains("8. April 2024 · Der Kernschatten des Mondes").is_some(), "a moment of the catalog");
}

/// No button of a bar lies outside the window at its smallest size.
#[test]
fn german_buttons_fit() {
    for size in [[1100.0, 640.0], [760.0, 480.0]] {
        for tab in std::iter::once(None).chain(Tab::ALL.map(Some)) {
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
    // In a narrow window some text is truncated, and the search finds it.
    harness.state_mut().tab = Some(Tab::Effects);
    settle(&mut harness);
    assert!(truncated_texts(&harness).iter().any(|text| text.starts_with("seine Normalen")), "the reasons of effects are truncated");
}
