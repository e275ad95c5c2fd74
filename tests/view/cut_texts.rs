//! Texts are shown whole: the names over a comparison, the number beside a slider in the narrow list of bodies, and the span of the timeline.

use crate::view::input::{SATURN, TIME, Window, window_without_images};
use crate::view::interface::{harness, interface, settle};
use egui::Rect;
use egui::accesskit::Role;
use egui::epaint::Shape;
use egui_kittest::kittest::Queryable;
use orrery::view::language::Language;
use orrery::view::panels::Tab;

/// The rectangle of each painted text that contains `part`, and the one to which it is clipped.
fn painted(window: &Window, part: &str) -> Vec<[Rect; 2]> {
    fn walk(shape: &Shape, clip: Rect, part: &str, found: &mut Vec<[Rect; 2]>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| walk(shape, clip, part, found)),
            Shape::Text(text) if text.galley.text().contains(part) => found.push([text.visual_bounding_rect(), clip]),
            _ => {}
        }
    }
    let mut found = Vec::new();
    window.output().shapes.iter().for_each(|clipped| walk(&clipped.shape, clipped.clip_rect, part, &mut found));
    found
}

/// The texts that are shown with an ellipsis because they have no room.
pub(super) fn elided_texts(window: &Window) -> Vec<String> {
    fn walk(shape: &Shape, found: &mut Vec<String>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| walk(shape, found)),
            Shape::Text(text) if text.galley.elided => found.push(text.galley.text().to_owned()),
            _ => {}
        }
    }
    let mut found = Vec::new();
    window.output().shapes.iter().for_each(|clipped| walk(&clipped.shape, &mut found));
    found
}

/// In German the unit was cut.
#[test]
fn the_span_of_the_timeline_is_shown_with_its_unit() {
    for (language, timeline, units) in [
        (Language::English, "Timeline", ["hours", "days", "months", "years"]),
        (Language::German, "Zeitleiste", ["Stunden", "Tage", "Monate", "Jahre"]),
    ] {
        let mut window = window_without_images(SATURN);
        window.state_mut().language = language;
        window.state_mut().settings.panels.timeline_shown = true;
        let mut left_edges = Vec::new();
        for (span_days, number, unit) in [(1.5, 36, units[0]), (80.0, 80, units[1]), (600.0, 20, units[2]), (400.0 * 365.25, 400, units[3])]
        {
            window.state_mut().settings.panels.timeline_span_s = span_days * 86_400.0;
            window.run_steps(3);
            let span = format!("{number} {unit}");
            assert_eq!(painted(&window, &span).len(), 1, "{span}");
            assert!(!elided_texts(&window).contains(&span), "{span}");
            left_edges.push(window.get_by_role_and_label(Role::Slider, timeline).rect().left());
        }
        assert!(left_edges.iter().all(|left| *left == left_edges[0]), "the timeline moves: {left_edges:?}");
    }
}

/// The field was so wide that the panel cut the sign of degrees.
#[test]
fn the_smallest_field_of_view_is_shown_with_its_unit() {
    let mut window = window_without_images(SATURN);
    for fov_deg in [1e-4, 0.001_234, 60.0] {
        window.state_mut().viewer.view.fov_deg = fov_deg;
        window.run_steps(3);
        // The fields for latitude and longitude are above, with the angle 0.
        let numbers: Vec<[Rect; 2]> = painted(&window, "°").into_iter().filter(|[text, _]| text.left() < 190.0).collect();
        assert!(numbers.len() >= 3, "{fov_deg}: {} numbers", numbers.len());
        assert!(numbers.iter().all(|[text, clip]| clip.contains_rect(text.shrink(0.5))), "{fov_deg}: {numbers:?}");
    }
}

/// A name longer than its part of the image was cut at the image's edge.
#[test]
fn long_names_of_variants_stay_in_their_part_of_the_image() {
    let mut window = harness(interface(SATURN, TIME));
    window.state_mut().tab = Some(Tab::Compare);
    settle(&mut window);
    let field = "Right: effects in addition to those of the view";
    window.get_by_role_and_label(Role::TextInput, field).focus();
    window.run_steps(1);
    window.get_by_role_and_label(Role::TextInput, field).type_text("-rings,-ring-shadow,-atmosphere,-eclipse");
    settle(&mut window);
    let image = window.get_by_label_contains("to the left of the divider").rect();
    let names: Vec<Rect> =
        painted(&window, "-ring-shadow").into_iter().map(|[text, _]| text).filter(|text| image.y_range().contains(text.top())).collect();
    assert!(names.len() == 1 && image.contains_rect(names[0]) && names[0].left() >= image.center().x, "{names:?} in {image:?}");
}
