//! Names over the sky keep clear of what the window shows over it.

use crate::view::interface::{harness, interface, settle};
use egui::Rect;
use egui::epaint::{ClippedShape, Shape};
use egui_kittest::Harness;
use orrery::catalog::NaifId;
use orrery::view::app::settings::HintsUsed;
use orrery::view::panels::Interface;

const JUPITER: NaifId = NaifId(599);
const UNUSED: HintsUsed = HintsUsed { drag: false, scroll: false, search: false };
const USED: HintsUsed = HintsUsed { drag: true, scroll: true, search: true };

/// Texts in the colour of names, with their rectangles.
fn texts(window: &Harness<'_, Interface>) -> Vec<(String, Rect)> {
    fn walk(shape: &Shape, out: &mut Vec<(String, Rect)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| walk(shape, out)),
            Shape::Text(text) => out.push((text.galley.job.text.clone(), text.visual_bounding_rect())),
            _ => {}
        }
    }
    let mut out = Vec::new();
    window.output().shapes.iter().for_each(|ClippedShape { shape, .. }| walk(shape, &mut out));
    out
}

/// The rectangle of the hints, and the name of a distant Jupiter, in a window so low that the name's usual place is under the hints.
fn hints_and_name(hints: HintsUsed) -> (Option<Rect>, Option<Rect>) {
    let mut interface = interface(JUPITER, "2024-01-01T00:00:00Z");
    interface.settings.hints = hints;
    interface.viewer.view.fov_deg = 120.0;
    let mut window = harness(interface);
    window.set_size([760.0, 228.0].into());
    settle(&mut window);
    let all = texts(&window);
    let of_hints = all.iter().filter(|(text, _)| ["Drag to turn", "Scroll to zoom"].contains(&text.as_str())).map(|(_, rect)| *rect);
    let name = all.iter().rfind(|(text, _)| text == "Jupiter").map(|(_, rect)| *rect);
    (of_hints.reduce(Rect::union), name)
}

#[test]
fn a_name_makes_room_for_the_hints() {
    let (hints, name) = hints_and_name(UNUSED);
    let (hints, name) = (hints.expect("hints"), name.expect("a name"));
    assert!(!name.intersects(hints), "{name:?} is under the hints at {hints:?}");
    // Without hints the name is where they were.
    let (none, usual) = hints_and_name(USED);
    let usual = usual.expect("a name");
    assert!(none.is_none() && usual.intersects(hints), "{usual:?} is beside {hints:?}");
}
