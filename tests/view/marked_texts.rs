//! All texts of the window come from its Fluent files. In the marked test language every message is enclosed in `«»` and every inserted text in `‹›`.
//! So a text that is painted, shown as a tooltip or reported to a screen reader without marks must be one of the exceptions below.

use crate::support::sweep;
use crate::view::interface::{harness, interface, session, settle, swept_tabs};
use egui::accesskit::Role;
use egui::epaint::{ClippedShape, Shape};
use egui::{Event, FontFamily, Modifiers, PointerButton, Pos2, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::scene::effects::Effect;
use orrery::shader::key::{DIMENSIONS, Dimension};
use orrery::view::app::settings::{HintsFollowed, Home};
use orrery::view::language::Language;
use orrery::view::panels::{Interface, Tab};
use std::collections::BTreeSet;
use std::path::Path;

const SATURN: NaifId = NaifId(699);
const EQUINOX: &str = "2017-05-17T00:00:00Z";

type Window = Harness<'static, Interface>;

/// The parts of a text that are not from a message: those outside `«»`, and inserted texts, between `‹›`.
fn parts_without_message(text: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut open = Vec::new();
    for c in text.chars() {
        match c {
            '«' | '‹' => open.push(c),
            '»' | '›' => drop(open.pop()),
            _ if open.last() != Some(&'«') => parts.last_mut().expect("a part").push(c),
            _ => {}
        }
        if "«»‹›".contains(c) {
            parts.push(String::new());
        }
    }
    parts.into_iter().map(|part| part.trim().to_owned()).filter(|part| !part.is_empty()).collect()
}

/// Units, time zones and letters in numbers, which are the same in every language.
const UNITS: &[&str] = &[
    "km",
    "m",
    "px",
    "dB",
    "s",
    "ms",
    "µs",
    "kB",
    "MB",
    "MiB",
    "GiB",
    "K",
    "pc",
    "mag",
    "mas",
    "UTC",
    "UTC+00:00",
    "h",
    "min",
    "d",
    "x",
    "e",
];

/// Names that are the same in every language: contacts of eclipses, this program, languages, hardware, shading languages; places and stars that the
/// searches below find; shortcut keys and pinned shader keys of one letter; abbreviations such as PSNR.
const NAMES: &[&str] = &[
    "C1",
    "C2",
    "C3",
    "C4",
    "Tycho Brahe",
    "iau",
    "Orrery",
    "English",
    "Deutsch",
    "GPU",
    "CPU",
    "WGSL",
    "HLSL",
    "GLSL",
    "MSL",
    "SPIR-V",
    "IR",
    "Sirius",
    "Vega",
    "HIP",
    "Paris",
    "France",
    "Dallas",
    "United States",
    "Tycho",
    "A",
    "B",
    "p",
    "j",
    "l",
    "t",
    "PSNR",
    "RGB",
    "R",
    "G",
    "Alpha",
    "V",
];

/// Texts that egui itself reports to screen readers, in English.
const EGUI_TEXTS: [&str; 3] = ["Resize panel", "Close window", "Hide"];

/// Whether a word is a number without a decimal point, possibly with a unit, a sign or an exponent, or a size such as `640x360`.
fn is_number(word: &str) -> bool {
    word.chars().all(|c| c.is_ascii_digit() || "°′″%±×".contains(c))
        || word
            .strip_suffix(['h', 'm', 's', 'e', 'x'])
            .is_some_and(|digits| !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit()))
        || word.split_once('e').is_some_and(|(a, b)| !a.is_empty() && is_number(a) && !b.is_empty() && is_number(b))
        || word.split_once('x').is_some_and(|(a, b)| is_number(a) && is_number(b) && !a.is_empty() && !b.is_empty())
}

/// Catalog names without a message: bodies, rings, surface features, sources of moments.
fn catalog_names() -> BTreeSet<String> {
    let catalog = session().catalog();
    let mut all = BTreeSet::new();
    for body in catalog.bodies() {
        // These bodies must be shown by their messages.
        if !MESSAGE_BODIES.contains(&body.name.as_str()) {
            all.insert(body.name.clone());
        }
        all.extend(body.rings.iter().map(|ring| ring.name.clone()));
    }
    all.extend(catalog.moments().iter().map(|moment| moment.source.clone()));
    // Comets, minor planets, constellations and instruments, and surface features that the searches below find.
    for file in ["comets.csv", "small_bodies.csv", "constellation_names.json", "instruments.toml", "nomenclature_usgs.csv"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("catalogs").join(file);
        let text = std::fs::read_to_string(path).expect(file);
        all.extend(
            text.split([',', '"', '\n'])
                .map(|name| name.trim().to_owned())
                .filter(|name| name.len() > 2 && !name.starts_with(char::is_lowercase) && name.parse::<f64>().is_err()),
        );
    }
    all
}

/// Bodies that have messages: those whose names differ between languages, and Saturn.
const MESSAGE_BODIES: [&str; 10] = ["Sun", "Mercury", "Earth", "Moon", "Neptune", "Pluto", "Callisto", "Ganymede", "Nereid", "Saturn"];

/// Names of shader modules, from their files.
fn module_names() -> BTreeSet<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/entry");
    let stems =
        std::fs::read_dir(folder).expect("a folder").filter_map(|entry| entry.ok()?.path().file_stem()?.to_str().map(str::to_owned));
    stems.flat_map(|stem| [stem.replace('_', " "), stem]).collect()
}

/// Dimensions of keys with their values and features, stages of a module, and effects as named by the Shader panel's features.
fn key_names() -> BTreeSet<String> {
    let of_dimension =
        |d: &'static Dimension| std::iter::once(d.name).chain(d.texts.iter().copied()).chain(d.feature_names.iter().copied());
    let effects = Effect::ALL.into_iter().map(|effect| effect.name());
    DIMENSIONS.iter().flat_map(of_dimension).chain(effects).chain(["limb-heights", "vertex", "fragment", "y"]).map(str::to_owned).collect()
}

/// Collects parts of texts that are neither messages nor allowed exceptions.
pub struct Scan {
    names: BTreeSet<String>,
    modules: BTreeSet<String>,
    keys: BTreeSet<String>,
    pub errors: BTreeSet<String>,
    /// Number of texts checked.
    pub checked: usize,
}

impl Scan {
    pub fn new() -> Self {
        Self { names: catalog_names(), modules: module_names(), keys: key_names(), errors: BTreeSet::new(), checked: 0 }
    }

    fn is_allowed(&self, place: &str, part: &str) -> bool {
        let is_code = |text: &str| place.contains("Shader") && self.keys.contains(text);
        let is_known = |text: &str| {
            is_code(text)
                || self.names.contains(text)
                || self.modules.contains(text)
                || NAMES.contains(&text)
                || UNITS.contains(&text)
                || EGUI_TEXTS.contains(&text)
        };
        // Paths and file names; texts of effects and keys in fields that the user can edit.
        let folder = env!("CARGO_MANIFEST_DIR").trim_matches('/');
        let is_path_or_input = |word: &str| {
            word.contains("/orrery/")
                || word == folder
                || [".json", ".png", ".gif", ".jpg", ".wesl"].iter().any(|ending| word.contains(ending))
                || word.starts_with("eclipse=")
                || word.contains('_')
        };
        // Keys of shaders and names of their features: `lambert.albedo.sun1`, `not shape.mesh`.
        let is_key = |word: &str| {
            word == "not"
                || word.contains('.')
                    && word
                        .split('.')
                        .all(|name| !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c == '-' || c.is_ascii_digit()))
                    && !is_decimal(word)
        };
        let is_symbol = |word: &str| !word.chars().any(char::is_alphanumeric) || !word.chars().any(|c| c.is_ascii());
        let is_allowed_word = |word: &str| {
            let bare = word.trim_matches(|c: char| ",;:()[]·+-−…/'".contains(c));
            is_symbol(word)
                || is_known(bare)
                || is_path_or_input(bare)
                || is_key(bare)
                || bare.split([':', '-', '+', ',', '/', '(', '−']).all(|piece| is_number(piece) || is_known(piece))
        };
        let trimmed = part.trim_matches(|c: char| ",;:()·+-−… ".contains(c));
        part.starts_with("orrery://")
            || is_known(part)
            || is_known(trimmed)
            || place.contains("Shader") && is_value_list(part)
            || trimmed.split(", ").all(&is_known)
            || part.split_whitespace().all(is_allowed_word)
    }

    pub fn check(&mut self, place: &str, texts: impl IntoIterator<Item = String>) {
        for text in texts {
            self.checked += 1;
            for part in parts_without_message(&text) {
                if !self.is_allowed(place, &part) {
                    let full_text: String = text.chars().take(160).collect();
                    self.errors.insert(format!("{place}: {part}   in: {full_text}"));
                }
            }
        }
    }
}

/// Values of a pixel, as the probe copies them: `5.3, 4.7, 2.9`.
fn is_value_list(part: &str) -> bool {
    part.contains(", ") && part.split(", ").all(is_decimal)
}

/// A number that is not formatted in the window's language: `1.5`.
fn is_decimal(word: &str) -> bool {
    word.split('.').all(|digits| !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit()))
}

/// Every text that is painted or reported to a screen reader. With `without_code`, source text, which has its own font, is left out.
fn texts<S>(window: &Harness<'static, S>, without_code: bool) -> BTreeSet<String> {
    fn painted(shape: &Shape, without_code: bool, out: &mut BTreeSet<String>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| painted(shape, without_code, out)),
            Shape::Text(text) => {
                let is_code = text.galley.job.sections.iter().all(|section| section.format.font_id.family == FontFamily::Monospace);
                if !(without_code && is_code) {
                    out.insert(text.galley.job.text.clone());
                }
            }
            _ => {}
        }
    }
    fn reported(node: &egui_kittest::Node<'_>, without_code: bool, out: &mut BTreeSet<String>) {
        let n = node.accesskit_node();
        // A text run repeats its label. With `without_code`, labels are left out, too: they include source lines, and they are painted anyway.
        if n.role() != Role::TextRun && !(without_code && n.role() == Role::Label) {
            out.extend([n.label(), n.value(), n.description()].into_iter().flatten());
        }
        node.children().for_each(|child| reported(&child, without_code, out));
    }
    let mut out = BTreeSet::new();
    window.output().shapes.iter().for_each(|ClippedShape { shape, .. }| painted(shape, without_code, &mut out));
    reported(&window.root(), without_code, &mut out);
    out
}

/// Name, role and rectangle of each control that the window shows.
fn controls(window: &Window) -> Vec<(String, Role, Rect)> {
    fn walk(node: &egui_kittest::Node<'_>, out: &mut Vec<(String, Role, Rect)>) {
        let n = node.accesskit_node();
        // The harness draws one pixel per point.
        if let Some(b) = n.bounding_box() {
            let rect = Rect::from_min_max(Pos2::new(b.x0 as f32, b.y0 as f32), Pos2::new(b.x1 as f32, b.y1 as f32));
            out.push((n.label().unwrap_or_default(), n.role(), rect));
        }
        node.children().for_each(|child| walk(&child, out));
    }
    let mut out = Vec::new();
    walk(&window.root(), &mut out);
    let size = window.input().screen_rect.unwrap_or(Rect::EVERYTHING);
    let is_control =
        |role: Role| !matches!(role, Role::Window | Role::Pane | Role::GenericContainer | Role::TextRun | Role::ScrollBar | Role::Unknown);
    out.retain(|(_, role, rect)| is_control(*role) && size.contains(rect.center()) && rect.area() > 1.0);
    out
}

fn press(window: &mut Window, at: Pos2, button: PointerButton, modifiers: Modifiers) {
    window.hover_at(at);
    window.run_steps(1);
    for pressed in [true, false] {
        window.event(Event::PointerButton { pos: at, button, pressed, modifiers });
        window.run_steps(1);
    }
    window.run_steps(1);
}

/// Scans the visible texts, then each tooltip that was not seen before.
fn scan_with_tooltips(scan: &mut Scan, window: &mut Window, place: &str, hovered: &mut BTreeSet<String>) {
    let without_code = window.state().tab == Some(Tab::Shader);
    scan.check(place, texts(window, without_code));
    for (name, role, rect) in controls(window) {
        if hovered.insert(format!("{role:?} {name}")) {
            window.hover_at(rect.center());
            window.run_steps(2);
            scan.check(&format!("{place}, over {name}"), texts(window, without_code));
        }
    }
    window.hover_at(Pos2::new(640.0, 300.0));
    window.run_steps(1);
}

fn marked_window(target: NaifId, utc: &str) -> Window {
    let mut interface = interface(target, utc);
    interface.settings.panels.timeline_shown = true;
    interface.settings.hints_followed = HintsFollowed::default();
    interface.language = Language::MarkedEnglish;
    let mut window = harness(interface);
    window.set_size([1280.0, 800.0].into());
    settle(&mut window);
    window.ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
    window
}

/// Opens and scans each list and menu.
fn scan_lists(scan: &mut Scan, window: &mut Window, place: &str, hovered: &mut BTreeSet<String>) {
    for (name, role, rect) in controls(window) {
        let is_menu = role == Role::ComboBox || role == Role::Button && ["«Layers»", "«Calendar»"].contains(&name.as_str());
        if is_menu && hovered.insert(format!("list {name}")) {
            press(window, rect.center(), PointerButton::Primary, Modifiers::NONE);
            scan_with_tooltips(scan, window, &format!("{place}, list {name}"), hovered);
            press(window, rect.center(), PointerButton::Primary, Modifiers::NONE);
        }
    }
}

#[test]
fn every_panel_shows_only_messages() {
    let mut window = marked_window(SATURN, EQUINOX);
    let (mut scan, mut hovered) = (Scan::new(), BTreeSet::new());
    for tab in swept_tabs() {
        window.state_mut().tab = tab;
        settle(&mut window);
        let collapsed: Vec<_> = controls(&window)
            .into_iter()
            .filter(|(name, role, ..)| *role == Role::DisclosureTriangle && !name.contains("Moons of"))
            .collect();
        for (name, ..) in collapsed {
            window.get_by_role_and_label(Role::DisclosureTriangle, &name).click_accesskit();
            window.run_steps(1);
        }
        settle(&mut window);
        let location = format!("{tab:?}");
        scan_with_tooltips(&mut scan, &mut window, &location, &mut hovered);
        scan_lists(&mut scan, &mut window, &location, &mut hovered);
    }
    window.state_mut().tab = None;
    window.state_mut().help_shown = true;
    settle(&mut window);
    scan.check("help", texts(&window, false));
    assert!(scan.checked > if sweep::in_full() { 5000 } else { 500 }, "{} texts", scan.checked);
    assert!(scan.errors.is_empty(), "{} of {} texts: {:#?}", scan.errors.len(), scan.checked, scan.errors);
}

/// Texts that the window shows after an action: searches, menus, measured angles, tours, events, pages of the Shader panel, comparisons, a warning.
#[test]
fn results_of_actions_show_only_messages() {
    let mut window = marked_window(NaifId::EARTH, "2024-04-08T18:30:00Z");
    window.state_mut().settings.home = Home { latitude_deg: 32.8, longitude_deg: -96.8 };
    let (mut scan, mut hovered) = (Scan::new(), BTreeSet::new());
    for query in [
        "sat",
        "2027",
        "eclipse 2027",
        "51.5, -0.1",
        "paris",
        "sirius",
        "tycho",
        "hip 91262",
        "ring-sh",
        "lambert.albedo",
        "great",
        "nowhere at all",
    ] {
        window.get_by_role_and_label(Role::TextInput, "«Search»").focus();
        window.run_steps(1);
        window.get_by_role_and_label(Role::TextInput, "«Search»").type_text(query);
        window.run_steps(3);
        let shown: Vec<String> = texts(&window, false).into_iter().filter(|text| !text.contains(query)).collect();
        scan.check(&format!("searching {query}"), shown);
        window.key_press(egui::Key::Escape);
        window.run_steps(2);
    }
    let sky = Pos2::new(640.0, 330.0);
    press(&mut window, sky, PointerButton::Secondary, Modifiers::NONE);
    scan_with_tooltips(&mut scan, &mut window, "menu", &mut hovered);
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    for at in [sky, Pos2::new(700.0, 250.0)] {
        press(&mut window, at, PointerButton::Primary, Modifiers::CTRL);
    }
    scan.check("measured angle", texts(&window, false));
    // A warning quotes the error of a link; here it is only the link, which is an exception.
    window.state_mut().warning = Some("orrery://view?".into());
    window.run_steps(3);
    scan.check("warning", texts(&window, false));
    window.state_mut().warning = None;
    for (tab, buttons) in [
        (Tab::Information, &[][..]),
        (Tab::Events, &["«Search»", "«Partial solar eclipse»", "«Greatest»", "«From this place»"][..]),
        (Tab::Compare, &["«Side by side»", "«Difference»", "«Error bound»"][..]),
        (Tab::Shader, &["«Key»", "«Values»", "«Cost»", "«Probe»", "«Gallery»", "«Source»"][..]),
        (Tab::Moments, &["«A day on Mars»", "«Pause tour»", "«End tour»"][..]),
    ] {
        window.state_mut().tab = Some(tab);
        settle(&mut window);
        scan_with_tooltips(&mut scan, &mut window, &format!("{tab:?}"), &mut hovered);
        for button in buttons {
            let found = controls(&window)
                .into_iter()
                .find(|(name, role, ..)| name.contains(button) && matches!(role, Role::Button | Role::RadioButton));
            let (name, role, _) = found.unwrap_or_else(|| panic!("{tab:?} has no button {button}"));
            // Not by the pointer: the button may be scrolled out of its panel.
            window.get_all_by_role_and_label(role, &name).next().expect("found above").click_accesskit();
            window.run_steps(2);
            settle(&mut window);
            scan_with_tooltips(&mut scan, &mut window, &format!("{tab:?} after {button}"), &mut hovered);
        }
    }
    assert!(scan.errors.is_empty(), "{} of {} texts: {:#?}", scan.errors.len(), scan.checked, scan.errors);
}

/// The scan detects a label, a number or a tooltip that does not come from a message.
#[test]
fn a_text_without_a_message_is_found() {
    let scan = Scan::new();
    for text in ["Save image", "Save", "«Saved» file", "«Open ‹the file›»", "1.5 km", "12 kilometres", "Sun", "paused", "«km» per second"]
    {
        assert!(parts_without_message(text).iter().any(|part| !scan.is_allowed("here", part)), "{text}");
    }
    for text in [
        "«Save image»",
        "1«.»5 km",
        "‹12› km",
        "Mimas",
        "«Fly to ‹Mimas› (g)»",
        "-22° 01′ 07«.»8″",
        "18:20:00",
        "orrery.png",
        "lambert.albedo.sun1",
    ] {
        assert!(parts_without_message(text).iter().all(|part| scan.is_allowed("here", part)), "{text}");
    }
    let mut window = Harness::new_ui(|ui| {
        ui.label("painted");
        ui.button("pressed").on_hover_text("hovered");
    });
    window.run_steps(2);
    window.ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
    window.get_by_label("pressed").hover();
    window.run_steps(3);
    let found = texts(&window, false);
    assert!(["painted", "pressed", "hovered"].iter().all(|text| found.contains(*text)), "{found:?}");
}
