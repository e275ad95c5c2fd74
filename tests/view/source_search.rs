//! The search in the source of a shader: the current match is in view, also sideways, in a line that has a frame; lines that the list hides are not found; the
//! field stays if the module has an error, as do the fields of other pages.

use crate::view::input::{Window, type_text};
use crate::view::interface::{harness, harness_of, interface, settle};
use egui::accesskit::Role;
use egui::epaint::{ClippedShape, Shape};
use egui::{Key, Modifiers, Rect};
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::session::{Session, Sources};
use orrery::shader::fragments::{FRAGMENTS, Fragments};
use orrery::view::panels::Tab;

/// egui rounds places to pixels.
const PLACE_ERROR_POINTS: f32 = 1.5;
/// Right edge of the test window, points.
const WINDOW_RIGHT: f32 = 1100.0;

/// A window with the source of the selected body.
fn window_with_source(body: NaifId, utc: &str) -> Window {
    let mut window = harness(interface(body, utc));
    window.state_mut().tab = Some(Tab::Shader);
    settle(&mut window);
    window.get_all_by_role_and_label(Role::Button, "Source").next().expect("the page").click_accesskit();
    settle(&mut window);
    window
}

/// Searches for a text, and returns the number of matches.
fn find(window: &mut Window, needle: &str) -> usize {
    window.get_by_role_and_label(Role::TextInput, "Find").focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(2);
    type_text(window, needle);
    window.run_steps(2);
    match_numbers(window)[1]
}

/// The number of the current match, and that of all.
fn match_numbers(window: &Window) -> [usize; 2] {
    let mut labels = window.query_all_by_label_contains("match ").filter_map(|label| label.accesskit_node().value());
    let shown = labels.find(|label| label.starts_with("match ")).expect("a match");
    let numbers: Vec<usize> = shown.split(' ').filter_map(|word| word.replace(',', "").parse().ok()).collect();
    numbers.try_into().unwrap_or_else(|_| panic!("{shown}"))
}

fn rectangles(shape: &Shape, found: &mut Vec<Rect>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| rectangles(shape, found)),
        Shape::Rect(rectangle) if rectangle.stroke.width >= 1.0 && rectangle.fill.a() == 0 => found.push(rectangle.rect),
        _ => {}
    }
}

/// The text and the place of the line that has a frame, if it contains this text.
fn framed_line(window: &Window, needle: &str) -> Option<(String, Rect)> {
    let mut frames = Vec::new();
    let shapes: &[ClippedShape] = &window.output().shapes;
    shapes.iter().for_each(|shape| rectangles(&shape.shape, &mut frames));
    let is_framed = |line: Rect| {
        let is_near = |a: f32, b: f32| (a - b).abs() < PLACE_ERROR_POINTS;
        frames.iter().any(|frame| is_near(frame.top(), line.top()) && is_near(frame.bottom(), line.bottom()))
    };
    let lines = window.query_all_by_label_contains(needle).filter(|label| label.accesskit_node().role() == Role::Label);
    let mut lines = lines.filter_map(|label| Some((label.accesskit_node().value()?, label.rect())));
    lines.find(|(_, place)| is_framed(*place))
}

/// The horizontal place of a text in a line, whose letters all have the same width.
fn x_range(line: &str, place: Rect, needle: &str) -> [f32; 2] {
    let before = line.find(needle).expect("the text");
    let letter_width = place.width() / line.chars().count() as f32;
    [before, before + needle.len()].map(|letters| place.left() + letters as f32 * letter_width)
}

/// This comment is longer than the panel is wide, and so are others.
#[test]
fn the_current_match_is_in_view_sideways_in_a_line_with_a_frame() {
    let mut window = window_with_source(NaifId::SUN, "2017-05-17T00:00:00Z");
    // Where lines begin while the list is not scrolled sideways.
    let mut left_at_rest = None;
    for (needle, is_far) in [("Limb darkening of", false), ("cooler layers", true), ("Limb darkening of", false)] {
        assert_eq!(find(&mut window, needle), 1, "{needle}");
        let (line, place) = framed_line(&window, needle).expect("no line has a frame");
        let sky = window.get_by_label_contains("The sky:").rect();
        let [left, right] = x_range(&line, place, needle);
        assert!(left > sky.right() && right < WINDOW_RIGHT, "{needle}: {left} to {right}, beside {sky}");
        let left_at_rest = *left_at_rest.get_or_insert(place.left());
        assert_eq!(place.left() < left_at_rest, is_far, "{needle}: the line begins at {}, and at {left_at_rest} at rest", place.left());
        // The comparison must be able to fail: unless the list scrolls sideways, the end of this line is out of view.
        assert_eq!(left_at_rest + right - place.left() > WINDOW_RIGHT, is_far, "{needle}: {right}, of a line from {}", place.left());
    }
}

/// Chooses the ring's shadow in the legend, and returns the number of its lines.
fn choose_ring_shadow(window: &mut Window) -> usize {
    let mut labels = window.query_all_by_label_contains("ring-shadow.").filter_map(|label| label.accesskit_node().label());
    let entry = labels.find(|name| name.split(' ').count() == 2).expect("an entry of the legend");
    drop(labels);
    window.get_by_role_and_label(Role::Button, &entry).click_accesskit();
    settle(window);
    entry.split(' ').nth(1).and_then(|count| count.parse().ok()).expect("a number of lines")
}

fn press(window: &mut Window, button: &str) {
    window.get_by_role_and_label(Role::Button, button).click_accesskit();
    settle(window);
}

/// The current match was then the last one that is shown, which is before the one that was current.
#[test]
fn a_match_that_is_hidden_is_followed_by_the_next_one_or_the_first() {
    let mut window = window_with_source(NaifId(699), "2017-05-17T00:00:00Z");
    choose_ring_shadow(&mut window);
    let all = find(&mut window, "=");
    press(&mut window, "Previous");
    assert_eq!(match_numbers(&window), [all, all]);
    let (last_of_all, _) = framed_line(&window, "=").expect("no line has a frame");
    window.get_by_label_contains("Only lines for").click_accesskit();
    settle(&mut window);
    let [current, shown] = match_numbers(&window);
    assert!(shown > 1 && current == 1, "match {current} of {shown}");
    assert!(framed_line(&window, "=").is_some(), "the first match is not in view");
    press(&mut window, "Previous");
    assert_eq!(match_numbers(&window), [shown, shown]);
    // The comparison must be able to fail: the match that was current is not among those shown.
    assert_ne!(framed_line(&window, "=").expect("no line has a frame").0, last_of_all);
    press(&mut window, "Next");
    assert_eq!(match_numbers(&window), [1, shown]);
}

/// An error in a fragment, which may be saved while a text is typed, once replaced the whole page, and the rest of the text acted as shortcuts.
#[test]
fn a_text_can_be_typed_although_the_module_has_an_error() {
    let cache = tempfile::tempdir().expect("a folder");
    let sources = Sources { cache: Some(cache.path().to_owned()), ..Sources::default() };
    let session: &'static Session = Box::leak(Box::new(Session::open(&sources, |line| panic!("{line}")).expect("a session")));
    let mut window = harness_of(session, interface(NaifId(699), "2017-05-17T00:00:00Z"));
    window.state_mut().tab = Some(Tab::Shader);
    settle(&mut window);
    let (path, text) = FRAGMENTS.iter().find(|(path, _)| *path == "lib/draw.wesl").expect("a fragment");
    for (page, field) in [("Source", "Find"), ("Values", "Filter"), ("Key", "Another key")] {
        session.set_fragments(Fragments::default());
        settle(&mut window);
        window.get_all_by_role_and_label(Role::Button, page).next().expect("the page").click_accesskit();
        settle(&mut window);
        window.get_by_role_and_label(Role::TextInput, field).focus();
        window.run_steps(2);
        type_text(&mut window, "su");
        let shows_error = |window: &Window| window.query_all_by_label_contains("fn broken( {").next().is_some();
        assert!(!shows_error(&window), "{page}");
        session.set_fragments(Fragments::with_files([((*path).to_owned(), format!("{text}\nfn broken( {{\n"))]));
        settle(&mut window);
        assert!(shows_error(&window), "{page}: no error is shown");
        type_text(&mut window, "n");
        let value = window.get_by_role_and_label(Role::TextInput, field).accesskit_node().value();
        assert_eq!(value.as_deref(), Some("sun"), "{page}");
    }
}

/// The filter was below the values, and vanished with them when the body moved away from the pixel.
#[test]
fn the_filter_of_the_probe_stays_when_the_pixel_has_no_values() {
    let mut interface = interface(NaifId(499), "2017-05-17T00:00:00Z");
    // Mars fills the image.
    interface.viewer.view.fov_deg = 2.0;
    let mut window = harness(interface);
    window.state_mut().tab = Some(Tab::Shader);
    settle(&mut window);
    window.get_all_by_role_and_label(Role::Button, "Probe").next().expect("the page").click_accesskit();
    settle(&mut window);
    window.get_by_label("Centre of the image").click_accesskit();
    settle(&mut window);
    for side in ["Pixels from the left", "Pixels from the top"] {
        window.get_by_label(side).set_value_accesskit(1.0);
        settle(&mut window);
    }
    let has_values = |window: &Window| window.query_all_by_label_contains("f64 difference").next().is_some();
    assert!(has_values(&window), "Mars is not at the pixel");
    window.get_by_role_and_label(Role::TextInput, "Filter").focus();
    window.run_steps(2);
    type_text(&mut window, "co");
    window.state_mut().viewer.view.fov_deg = 60.0;
    settle(&mut window);
    assert!(!has_values(&window), "Mars is still at the pixel");
    type_text(&mut window, "l");
    let field = window.get_by_role_and_label(Role::TextInput, "Filter");
    assert_eq!(field.accesskit_node().value().as_deref(), Some("col"));
}

#[test]
fn hidden_lines_are_not_found() {
    let mut window = window_with_source(NaifId(699), "2017-05-17T00:00:00Z");
    let lines_of_feature = choose_ring_shadow(&mut window);
    let all = find(&mut window, "=");
    window.get_by_label_contains("Only lines for").click_accesskit();
    settle(&mut window);
    let [current, shown] = match_numbers(&window);
    assert!(current >= 1 && shown >= 1 && shown <= lines_of_feature && shown < all, "{shown} of {all}, in {lines_of_feature} lines");
    for _ in 0..shown.min(6) {
        assert!(framed_line(&window, "=").is_some(), "match {:?} is not in view", match_numbers(&window));
        press(&mut window, "Next");
    }
    window.get_by_label_contains("Only lines for").click_accesskit();
    settle(&mut window);
    assert_eq!(match_numbers(&window)[1], all, "the other lines are not found again");
}
