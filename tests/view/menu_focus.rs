//! The keyboard focus in menus and drop-down lists: a ring around the entry, with a contrast of at least 3 to the entry (WCAG 2.2, success criteria 2.4.7 and
//! 1.4.11), in both themes.

use crate::support::folds::larger;
use crate::view::contrast::contrast;
use crate::view::input::{Window, window_without_images};
use crate::view::interface::{CpuTestRenderer, harness, interface, settle};
use egui::accesskit::Role;
use egui::epaint::{ClippedShape, RectShape, Shape};
use egui::{Event, Key, Modifiers, PointerButton, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::view::panels::Tab;
use orrery::view::window::cpu_painter::Painter;

/// Smallest contrast of a mark that shows a state.
const MIN_CONTRAST: f64 = 3.0;
/// The ring is on the edge of the entry. egui rounds places to pixels.
const PLACE_ERROR_POINTS: f32 = 2.0;
/// Smallest opacity of a ring. A menu may not be faded in completely, with its entries.
const MIN_ALPHA: u8 = 192;
/// Passes until a menu has been faded in.
const PASSES_OF_FADE: usize = 12;
/// Entries of a list beyond these may be scrolled out of view.
const ENTRIES_IN_VIEW: usize = 6;
/// So many entries of a menu, to the third week of the calendar, stand for all.
const ENTRIES_OF_MENU: usize = 24;

fn rectangles<'s>(shape: &'s Shape, found: &mut Vec<&'s RectShape>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| rectangles(shape, found)),
        Shape::Rect(rectangle) => found.push(rectangle),
        _ => {}
    }
}

/// The contrast between the fill of a control and the ring around it; 1 without a ring.
fn ring_contrast(shapes: &[ClippedShape], place: Rect) -> f64 {
    let mut found = Vec::new();
    shapes.iter().for_each(|shape| rectangles(&shape.shape, &mut found));
    let is_near = |a: egui::Pos2, b: egui::Pos2| (a - b).length() < PLACE_ERROR_POINTS;
    let rings = found.into_iter().filter(|ring| {
        ring.stroke.width >= 1.0
            && ring.stroke.color.a() >= MIN_ALPHA
            && is_near(ring.rect.min, place.min)
            && is_near(ring.rect.max, place.max)
    });
    rings.map(|ring| contrast(ring.stroke.color, ring.fill)).fold(1.0, larger)
}

/// The buttons that are shown: names and places.
fn buttons(window: &Window) -> Vec<(String, Rect)> {
    let named = |node: egui_kittest::Node<'_>| (node.accesskit_node().label().unwrap_or_default(), node.rect());
    window.query_all_by_role(Role::Button).map(named).collect()
}

/// Gives the focus to the first entries of the open menu, and returns the names of these. `before`: the buttons before it was opened.
fn visit_entries(window: &mut Window, before: &[(String, Rect)], max_count: usize, menu: &str) -> Vec<String> {
    let entries = buttons(window).into_iter().filter(|button| !before.contains(button)).take(max_count);
    let entries: Vec<(String, Rect)> = entries.collect();
    assert!(!entries.is_empty(), "{menu} has no entries");
    for (name, place) in &entries {
        assert!(ring_contrast(&window.output().shapes, *place) < MIN_CONTRAST, "{menu}: {name} has a ring without the focus");
        window.query_all_by_role(Role::Button).find(|button| button.rect() == *place).expect(name).focus();
        window.run_steps(3);
        let contrast = ring_contrast(&window.output().shapes, *place);
        assert!(contrast >= MIN_CONTRAST, "{menu}: {name} has no ring: {contrast}");
    }
    entries.into_iter().map(|(name, _)| name).collect()
}

fn close(window: &mut Window) {
    window.key_press(Key::Escape);
    window.run_steps(4);
}

#[test]
fn the_focused_entry_of_every_menu_has_a_ring() {
    let mut window = window_without_images(NaifId(599));
    for is_dark in [true, false] {
        window.state_mut().settings.dark = Some(is_dark);
        window.state_mut().settings.labels_bodies = true;
        window.run_steps(3);
        // One that is chosen, and one that is not.
        for (menu, chosen, other) in [("Layers", "Names", "Orbits"), ("Calendar", "17 May 2017", "18 May 2017")] {
            let before = buttons(&window);
            window.get_by_role_and_label(Role::Button, menu).click_accesskit();
            window.run_steps(PASSES_OF_FADE);
            let names = visit_entries(&mut window, &before, ENTRIES_OF_MENU, menu);
            assert!(names.iter().any(|name| name == chosen) && names.iter().any(|name| name == other), "{menu}: {names:?}");
            close(&mut window);
        }
    }
}

#[test]
fn the_focused_entry_of_the_menu_of_a_right_click_has_a_ring() {
    let mut window = harness(interface(NaifId(599), "2017-05-17T00:00:00Z"));
    settle(&mut window);
    for is_dark in [true, false] {
        window.state_mut().settings.dark = Some(is_dark);
        window.run_steps(3);
        let before = buttons(&window);
        let pos = window.get_by_label_contains("The sky:").rect().center();
        window.hover_at(pos);
        window.run_steps(1);
        for pressed in [true, false] {
            window.event(Event::PointerButton { pos, button: PointerButton::Secondary, pressed, modifiers: Modifiers::NONE });
            window.run_steps(1);
        }
        // The pointer marks the entry below it.
        window.hover_at(egui::pos2(1.0, 1.0));
        window.run_steps(PASSES_OF_FADE);
        visit_entries(&mut window, &before, ENTRIES_OF_MENU, "the menu of the view");
        close(&mut window);
    }
}

#[test]
fn the_focused_entry_of_every_list_has_a_ring() {
    let mut window = window_without_images(NaifId(599));
    let mut count = 0;
    for is_dark in [true, false] {
        window.state_mut().settings.dark = Some(is_dark);
        for tab in std::iter::once(None).chain(Tab::ALL.map(Some)) {
            window.state_mut().tab = tab;
            window.run_steps(4);
            for index in 0..window.query_all_by_role(Role::ComboBox).count() {
                let before = buttons(&window);
                let list = window.query_all_by_role(Role::ComboBox).nth(index).expect("a list");
                if list.accesskit_node().is_disabled() {
                    continue;
                }
                list.click_accesskit();
                window.run_steps(PASSES_OF_FADE);
                visit_entries(&mut window, &before, ENTRIES_IN_VIEW, &format!("{tab:?}, list {index}"));
                close(&mut window);
                count += 1;
            }
        }
    }
    // Two of them, beside the list of bodies and in the time bar, are shown with each of the panels.
    assert!(count > 36, "{count} lists");
}

/// After Escape the focus was nowhere, so that the next Tab went to the first control of the window.
#[test]
fn escape_gives_the_focus_back_to_the_button_of_the_menu() {
    let mut window = window_without_images(NaifId(599));
    for (role, name) in [(Role::Button, "Layers"), (Role::Button, "Calendar"), (Role::ComboBox, "Kind of event")] {
        for moves in [&[][..], &[Key::Tab], &[Key::ArrowDown, Key::ArrowDown]] {
            let shown = buttons(&window).len();
            window.get_by_role_and_label(role, name).focus();
            window.run_steps(2);
            window.key_press(Key::Enter);
            window.run_steps(PASSES_OF_FADE);
            assert!(buttons(&window).len() > shown, "{name} is not open");
            for key in moves {
                window.key_press(*key);
                window.run_steps(3);
            }
            close(&mut window);
            assert_eq!(buttons(&window).len(), shown, "{name} is still open");
            assert!(window.get_by_role_and_label(role, name).is_focused(), "{name}, {moves:?}");
        }
    }
    // Escape on the button itself, and a menu that was opened without the focus: neither leaves the focus on the button.
    close(&mut window);
    window.get_by_role_and_label(Role::Button, "Layers").click_accesskit();
    window.run_steps(PASSES_OF_FADE);
    close(&mut window);
    assert!(!window.get_by_role_and_label(Role::Button, "Layers").is_focused());
}

/// The tests must be able to fail: a menu in egui's own style.
#[test]
fn a_menu_in_the_style_of_egui_has_no_ring() {
    let mut plain = Harness::builder().renderer(CpuTestRenderer(Painter::default())).build_ui(|ui| {
        ui.menu_button("Menu", |ui| {
            let _ = ui.selectable_label(true, "Chosen");
        });
    });
    plain.run_steps(2);
    plain.get_by_label("Menu").click_accesskit();
    plain.run_steps(4);
    plain.get_by_label("Chosen").focus();
    plain.run_steps(3);
    let chosen = plain.get_by_label("Chosen");
    assert!(chosen.is_focused(), "the entry has no focus");
    let contrast = ring_contrast(&plain.output().shapes, chosen.rect());
    assert!(contrast < MIN_CONTRAST, "a missing ring is not detected: {contrast}");
}
