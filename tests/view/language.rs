//! The window in German: nothing of its English texts is left among the accessible names, buttons keep their whole text, and the choice applies at once.

use crate::view::interface::{harness, interface, settle};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::view::language::Language;
use orrery::view::panels::{Interface, Tab};
use std::collections::BTreeSet;

const SATURN: NaifId = NaifId(699);
const EQUINOX: &str = "2017-05-17T00:00:00Z";

/// Accessible names and values of all controls and texts.
fn names(harness: &Harness<'static, Interface>) -> BTreeSet<String> {
    fn walk(node: &egui_kittest::Node<'_>, out: &mut BTreeSet<String>) {
        let n = node.accesskit_node();
        // A text run repeats its label; a list of source lines is not the window's.
        if n.role() != Role::TextRun {
            out.extend(n.label().or_else(|| n.value()));
        }
        for child in node.children() {
            walk(&child, out);
        }
    }
    let mut out = BTreeSet::new();
    walk(&harness.root(), &mut out);
    out
}

/// Words that English texts have and German ones never.
const ENGLISH: [&str; 40] = [
    "the",
    "of",
    "and",
    "with",
    "for",
    "is",
    "are",
    "from",
    "this",
    "that",
    "which",
    "each",
    "show",
    "view",
    "save",
    "open",
    "time",
    "frame",
    "frames",
    "image",
    "picture",
    "body",
    "bodies",
    "event",
    "events",
    "eclipse",
    "eclipses",
    "light",
    "shadow",
    "next",
    "previous",
    "step",
    "search",
    "key",
    "none",
    "year",
    "month",
    "moons",
    "magnitude",
    "size",
];

/// English by their origin: reasons that the scene gives, contents of catalogs, the program's own names for modules and stages of a pass. Each with its reason in docs/window.md.
fn is_of_elsewhere(name: &str, tab: Option<Tab>) -> bool {
    match tab {
        // Names, sentences and tours of the catalogs.
        Some(Tab::Moments) => true,
        // Reasons and key words of the scene.
        Some(Tab::Effects) => name.contains(':') || name.contains("(") || name.contains("1/512") || name.split(' ').count() > 2,
        // Names of modules, dimensions, features, source lines.
        Some(Tab::Shader) => true,
        // Estimates of the catalog.
        Some(Tab::Information) => name.contains("IAU") || name.contains("estimate") || name.contains("albedo"),
        // Passes and modules.
        Some(Tab::Performance) => name.contains('_') || name.starts_with("Durchgang"),
        // Links and file names.
        Some(Tab::Share) => name.contains("orrery"),
        _ => false,
    }
}

/// Names with an English word, beside those of other origin.
fn english_names(names: &BTreeSet<String>, tab: Option<Tab>) -> Vec<String> {
    let has_word = |name: &str| name.split(|c: char| !c.is_alphabetic()).any(|word| ENGLISH.contains(&word.to_lowercase().as_str()));
    names.iter().filter(|name| has_word(name) && !is_of_elsewhere(name, tab)).cloned().collect()
}

fn german(harness: &mut Harness<'static, Interface>) {
    harness.state_mut().language = Language::German;
}

#[test]
fn no_panel_speaks_english_in_german() {
    let mut shown = interface(SATURN, EQUINOX);
    shown.settings.panels.timeline_shown = true;
    let mut harness = harness(shown);
    let mut left = Vec::new();
    for tab in std::iter::once(None).chain(Tab::ALL.map(Some)) {
        harness.state_mut().tab = tab;
        harness.state_mut().help_shown = tab.is_none();
        harness.state_mut().language = Language::English;
        settle(&mut harness);
        let english = names(&harness);
        assert!(!english_names(&english, None).is_empty(), "{tab:?}: the scan finds nothing in English either");
        german(&mut harness);
        settle(&mut harness);
        let german = names(&harness);
        left.extend(english_names(&german, tab).into_iter().map(|name| format!("{tab:?}: {name}")));
    }
    assert!(left.is_empty(), "{left:#?}");
}

#[test]
fn a_language_applies_at_once_and_is_kept() {
    let mut harness = harness(interface(SATURN, EQUINOX));
    harness.state_mut().tab = Some(Tab::Share);
    settle(&mut harness);
    harness.get_by_label("Deutsch").scroll_to_me();
    harness.run_steps(2);
    harness.get_by_label("Deutsch").click();
    settle(&mut harness);
    assert_eq!(harness.state().settings.language, Some(Language::German));
    assert!(harness.query_by_label("Lesezeichen setzen").is_some() && harness.query_by_label("Add bookmark").is_none());
    // Settings keep a panel by a name that no language changes.
    assert_eq!(harness.state().settings.panels.open.as_deref(), Some("Share"));
    harness.get_by_label("English").click();
    settle(&mut harness);
    assert!(harness.query_by_label("Add bookmark").is_some());
}

/// No button of a bar lies outside the window at its least usual size, in either language.
#[test]
fn german_buttons_fit() {
    for size in [[1100.0, 640.0], [760.0, 480.0]] {
        for tab in std::iter::once(None).chain(Tab::ALL.map(Some)) {
            let mut harness = harness(interface(SATURN, EQUINOX));
            harness.set_size(size.into());
            harness.state_mut().tab = tab;
            german(&mut harness);
            settle(&mut harness);
            for button in harness.query_all_by_role(Role::Button) {
                let (rect, name) = (button.rect(), button.accesskit_node().label().unwrap_or_default());
                assert!(rect.left() >= -0.5 && rect.right() <= size[0] + 0.5, "{tab:?}, {size:?}: {name} at {rect:?}");
            }
        }
    }
}
