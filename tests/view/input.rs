//! The window under clicks and keys: the pressed row is selected; Escape closes one thing at a time and never the program; a failed search is reported
//! until the next input; no image is stretched.

use crate::support::sweep;
use crate::view::interface::{CpuTestRenderer, interface, session, settle};
use egui::accesskit::{Role, Toggled};
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::scene::request::Quality;
use orrery::session::Session;
use orrery::view::panels::{Interface, Tab};
use orrery::view::window::cpu_painter::Painter;
use orrery::view::worker::render_worker::{FailedJob, InlineWorker, RenderJob, RenderWorker, RenderedView, Task};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub(super) const SATURN: NaifId = NaifId(699);

pub(super) const TIME: &str = "2017-05-17T00:00:00Z";

const SEARCH: &str = "Search";

pub(super) type Window = Harness<'static, Interface>;

/// Draws immediately while `is_drawing` is set. Otherwise the last image stays on screen, as it does for seconds when drawing is slow.
struct PausableWorker {
    inline: InlineWorker<'static>,
    is_drawing: Arc<AtomicBool>,
}

impl RenderWorker for PausableWorker {
    fn session(&self) -> &Session {
        self.inline.session()
    }
    fn submit(&self, job: RenderJob) {
        if self.is_drawing.load(Ordering::Relaxed) {
            self.inline.submit(job);
        }
    }
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        self.inline.take()
    }
    fn run(&self, task: Task) {
        self.inline.run(task);
    }
}

/// A window of this height, points, that draws images while `is_drawing` is set.
pub(super) fn pausable_window(interface: Interface, is_drawing: &Arc<AtomicBool>, height: f32) -> Window {
    let worker = PausableWorker { inline: InlineWorker::new(session()), is_drawing: Arc::clone(is_drawing) };
    Harness::builder()
        .with_size([1100.0, height])
        .with_max_steps(40)
        // Steps so short that two clicks in a row are a double-click.
        .with_step_dt(1.0 / 60.0)
        .renderer(CpuTestRenderer(Painter::default()))
        .build_ui_state(move |ui, interface: &mut Interface| interface.ui(ui, &worker), interface)
}

/// A window that never draws an image, tall enough for every row of the list.
pub(super) fn window_without_images(target: NaifId) -> Window {
    let mut window = pausable_window(interface(target, TIME), &Arc::default(), 1900.0);
    window.run_steps(3);
    window
}

pub(super) fn advance(window: &mut Window, seconds: f64) {
    let next = window.ctx.input(|i| i.time) + seconds;
    window.input_mut().time = Some(next);
    window.run_steps(1);
}

/// Names that begin left of this, points, are in the list of bodies.
const LIST_RIGHT: f32 = 185.0;
/// Names below this, points, are not in the top bar.
const LIST_TOP: f32 = 30.0;

/// The visible rows of the list: body, name, rectangle.
fn rows(window: &Window) -> Vec<(NaifId, String, Rect)> {
    let row_rect = |name: &str| {
        let found = window.query_all_by_label(name).map(|n| n.rect()).find(|r| r.left() < LIST_RIGHT && r.top() > LIST_TOP);
        found.filter(|r| r.height() > 5.0)
    };
    let bodies = window.state().viewer.selectable_bodies().to_vec();
    bodies.into_iter().filter_map(|b| row_rect(&b.name).map(|rect| (b.id, b.name, rect))).collect()
}

fn primary_button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

/// Presses and releases in separate frames.
pub(super) fn click(window: &mut Window, pos: Pos2) {
    window.hover_at(pos);
    window.run_steps(1);
    window.event(primary_button(pos, true));
    window.run_steps(1);
    window.event(primary_button(pos, false));
    window.run_steps(1);
}

/// Presses and releases in one frame.
pub(super) fn click_in_one_frame(window: &mut Window, pos: Pos2) {
    window.hover_at(pos);
    window.run_steps(1);
    window.input_mut().events.extend([primary_button(pos, true), primary_button(pos, false)]);
    window.run_steps(1);
}

#[test]
fn the_pressed_row_is_the_selected_row() {
    let count = rows(&window_without_images(NaifId::EARTH)).len();
    assert!(count > 12, "{count} rows");
    // Each row in a new window. The press selects another body, whose moons the list then expands.
    for target in [NaifId::EARTH, SATURN, NaifId::MOON] {
        let visible_rows = rows(&window_without_images(target));
        for (k, (id, name, _)) in visible_rows.iter().enumerate().filter(|(k, _)| sweep::runs(*k, 3)) {
            let mut window = window_without_images(target);
            let rect = rows(&window)[k].2;
            let click_as_chosen = if k % 2 == 0 { click_in_one_frame } else { click };
            click_as_chosen(&mut window, rect.center());
            window.run_steps(2);
            assert_eq!(window.state().viewer.selected, *id, "{name} was pressed, from {target:?}");
        }
    }
    // In one window, clicks every row in turn while branches expand; in the end every body's row was clicked.
    let mut window = window_without_images(NaifId::EARTH);
    let mut clicked = std::collections::BTreeSet::new();
    for attempt in 0..200 {
        let visible_rows = rows(&window);
        let Some((id, name, rect)) = visible_rows.iter().find(|(id, ..)| !clicked.contains(&id.0)).cloned() else { break };
        clicked.insert(id.0);
        window.hover_at(rect.center());
        window.run_steps(1);
        window.event(primary_button(rect.center(), true));
        window.run_steps(1);
        let at_press = rows(&window);
        // A selection from elsewhere moves nothing under the pointer.
        window.state_mut().viewer.selected = NaifId(599 + 100 * (attempt % 4));
        window.run_steps(2);
        window.event(primary_button(rect.center(), false));
        window.run_steps(1);
        assert_eq!(rows(&window), at_press, "the list moved under a click on {name}");
        window.run_steps(1);
        assert_eq!(window.state().viewer.selected, id, "{name} was pressed");
        (0..3).for_each(|_| advance(&mut window, 0.25));
    }
    assert_eq!(clicked.len(), window.state().viewer.selectable_bodies().len(), "rows that never showed");
}

#[test]
fn a_second_click_hits_the_same_row() {
    for target in [NaifId(599), SATURN, NaifId(799), NaifId(899)] {
        let mut window = window_without_images(NaifId::EARTH);
        let place = rows(&window).into_iter().find(|r| r.0 == target).expect("a row").2.center();
        click(&mut window, place);
        click(&mut window, place);
        window.run_steps(1);
        assert!(window.state().viewer.is_flying() && window.state().viewer.view_after_flight().target == target, "{target:?}");
    }
}

#[test]
fn branches_expand_and_collapse_whatever_is_selected() {
    let arrow = |window: &Window, name: &str| {
        let label = format!("Moons of {name}");
        let node = window.get_by_role_and_label(Role::DisclosureTriangle, &label);
        (node.rect().center(), node.accesskit_node().toggled() == Some(Toggled::True))
    };
    for (id, name) in [(399, "Earth"), (499, "Mars"), (599, "Jupiter"), (699, "Saturn"), (799, "Uranus"), (899, "Neptune")] {
        for selected in [NaifId(id), NaifId::SUN] {
            let mut window = window_without_images(selected);
            let (arrow_pos, mut is_open) = arrow(&window, name);
            for click_index in 0..4 {
                let click_as_chosen = if click_index % 2 == 0 { click_in_one_frame } else { click };
                click_as_chosen(&mut window, arrow_pos);
                (0..3).for_each(|_| advance(&mut window, 0.25));
                let now = arrow(&window, name).1;
                assert!(now != is_open, "{name}'s arrow does nothing at click {click_index}, {selected:?} selected");
                is_open = now;
            }
            assert_eq!(window.state().viewer.selected, selected);
        }
    }
}

#[test]
fn a_moon_that_is_selected_elsewhere_shows_in_the_list() {
    let mut window = pausable_window(interface(NaifId::EARTH, TIME), &Arc::default(), 640.0);
    window.run_steps(3);
    for id in [NaifId(501), NaifId(606), NaifId(801), NaifId::MOON] {
        window.state_mut().viewer.selected = id;
        for _ in 0..8 {
            advance(&mut window, 0.2);
        }
        let row = rows(&window).into_iter().find(|r| r.0 == id).map(|r| r.2);
        let list_bottom = window.get_by_label("Fly").rect().top();
        assert!(row.is_some_and(|r| r.top() > LIST_TOP && r.bottom() < list_bottom), "{id:?} at {row:?}");
    }
}

/// States of the search field, or an open list in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Search {
    Untouched,
    Empty,
    Typed,
    Failed,
    /// With text, but without the focus.
    Unfocused,
    /// The search is untouched, and the list *View from* is open.
    Menu,
}

/// Whether the search field has the focus, and its text.
fn search_field(window: &Window) -> (bool, String) {
    let field = window.get_by_role_and_label(Role::TextInput, SEARCH);
    (field.is_focused(), field.value().unwrap_or_default())
}

pub(super) fn type_text(window: &mut Window, text: &str) {
    window.event(Event::Text(text.into()));
    window.run_steps(2);
}

fn bring_search_into(window: &mut Window, search: Search) {
    if matches!(search, Search::Empty | Search::Typed | Search::Failed | Search::Unfocused) {
        type_text(window, "/");
    }
    match search {
        Search::Untouched | Search::Empty => {}
        Search::Typed => type_text(window, "satu"),
        Search::Failed => {
            type_text(window, "nowhere");
            window.key_press(Key::Enter);
            window.run_steps(2);
        }
        Search::Unfocused => {
            type_text(window, "satu");
            // On the empty sky.
            click(window, Pos2::new(620.0, 300.0));
        }
        Search::Menu => {
            window.get_by_role_and_label(Role::ComboBox, "View from").click();
            window.run_steps(3);
        }
    }
}

/// Number of things on screen that Escape closes.
fn open_things(window: &Window) -> usize {
    let state = window.state();
    let (is_focused, text) = search_field(window);
    let things = [
        is_focused || !text.is_empty() || window.query_by_label_contains("Nothing is called").is_some(),
        window.query_by_label("Centre of Mars").is_some(),
        state.warning.is_some(),
        state.help_shown,
        state.tab.is_some(),
        state.fullscreen,
    ];
    things.into_iter().filter(|open| *open).count()
}

/// Combinations of a state of the search or a menu with a panel, help, full screen and a warning: each Escape closes exactly one of them, further ones
/// close nothing, and none ends the program.
#[test]
fn escape_closes_one_thing_at_a_time_and_never_the_program() {
    let tabs: Vec<Option<Tab>> = std::iter::once(None).chain(Tab::ALL.map(Some)).collect();
    let mut window = pausable_window(interface(SATURN, TIME), &Arc::default(), 700.0);
    window.run_steps(2);
    let mut cases = 0;
    for search in [Search::Untouched, Search::Empty, Search::Typed, Search::Failed, Search::Unfocused, Search::Menu] {
        for tab in &tabs {
            for bits in 0..8 {
                let [help, full, warned] = [1, 2, 4].map(|bit| bits & bit != 0);
                // A warning takes the focus, so nothing can be typed.
                if warned && search != Search::Untouched {
                    continue;
                }
                // Panels other than Information only with an untouched search, or with help in full screen.
                let is_case = tab.is_none() || matches!(tab, Some(Tab::Information)) || search == Search::Untouched || bits == 3;
                cases += 1;
                if !is_case || !sweep::runs(cases, 5) {
                    continue;
                }
                // After everything is closed, the state is the initial one.
                assert_eq!(open_things(&window), 0);
                bring_search_into(&mut window, search);
                let state = window.state_mut();
                (state.tab, state.help_shown) = (*tab, help);
                state.warning = warned.then(|| "why".into());
                if full {
                    window.key_press(Key::F11);
                }
                window.run_steps(2);
                let case = format!("{search:?}, {tab:?}, help {help}, full screen {full}, warned {warned}");
                let mut open = open_things(&window);
                let expected =
                    usize::from(search != Search::Untouched) + [tab.is_some(), help, full, warned].map(usize::from).iter().sum::<usize>();
                assert_eq!(open, expected, "{case}");
                for press in 0..expected + 3 {
                    window.key_press(Key::Escape);
                    window.run_steps(2);
                    let now = open_things(&window);
                    assert!(!window.state().quit_requested, "{case}: Escape {press} quits");
                    assert_eq!(now, open.saturating_sub(1), "{case}: Escape {press}");
                    // Full screen is left last.
                    assert!(
                        now == 0 || window.state().fullscreen == full,
                        "{case}: Escape {press} leaves full screen before all else is closed"
                    );
                    open = now;
                }
            }
        }
    }
}

#[test]
fn only_ctrl_q_quits() {
    for search in [Search::Untouched, Search::Empty, Search::Typed, Search::Failed, Search::Unfocused] {
        let mut window = pausable_window(interface(SATURN, TIME), &Arc::default(), 700.0);
        window.run_steps(2);
        bring_search_into(&mut window, search);
        for letter in (' '..='~').filter(|c| *c != '/') {
            window.event(Event::Text(letter.to_string()));
            window.run_steps(1);
            assert!(!window.state().quit_requested, "{search:?}: `{letter}` quits");
        }
        window.key_press_modifiers(Modifiers::COMMAND, Key::Q);
        window.run_steps(2);
        assert!(window.state().quit_requested, "{search:?}");
    }
}

#[test]
fn a_failed_search_is_reported_below_the_field_until_the_next_input() {
    for (query, answer) in [
        ("nowhere", "Nothing is called “nowhere”"),
        ("satrun", "Nothing is called “satrun”"),
        ("tritan", "Nothing is called “tritan”"),
        ("+wings", "wings"),
        ("zz 9", "Nothing is called “zz 9”"),
    ] {
        let mut window = window_without_images(SATURN);
        type_text(&mut window, "/");
        type_text(&mut window, query);
        window.key_press(Key::Enter);
        window.run_steps(2);
        let line = window.get_by_label_contains(answer).rect();
        let field = window.get_by_role_and_label(Role::TextInput, SEARCH).rect();
        assert!(line.top() >= field.bottom() && line.top() < field.bottom() + 20.0 && (line.left() - field.left()).abs() < 20.0, "{line}");
        assert_eq!(search_field(&window), (true, query.to_owned()));
        type_text(&mut window, "mars");
        assert_eq!(search_field(&window).1, "mars");
        assert!(window.query_by_label_contains(answer).is_none(), "the answer to an earlier text is shown");
        window.key_press(Key::Enter);
        window.run_steps(2);
        assert_eq!(window.state().viewer.view_after_flight().target, NaifId(499));
        assert_eq!(search_field(&window), (false, String::new()));
    }
    // The field is left and entered again: by key, by key and a letter in the same frame, by mouse. The next letter replaces its text.
    for way in 0..3 {
        let mut window = window_without_images(SATURN);
        bring_search_into(&mut window, Search::Unfocused);
        assert_eq!(search_field(&window), (false, "satu".to_owned()));
        let field_centre = window.get_by_role_and_label(Role::TextInput, SEARCH).rect().center();
        match way {
            0 => {
                type_text(&mut window, "/");
                type_text(&mut window, "i");
            }
            1 => {
                window.input_mut().events.extend([Event::Text("/".into()), Event::Text("i".into())]);
                window.run_steps(3);
            }
            _ => {
                click(&mut window, field_centre);
                type_text(&mut window, "i");
            }
        }
        assert_eq!(search_field(&window), (true, "i".to_owned()), "way {way}");
    }
}

/// Width, height and centre of the pixels in a rectangle that are brighter than the black sky.
fn bright_area(window: &mut Window, sky: Rect) -> (f32, f32, Pos2) {
    // The pointer is bright too.
    window.remove_cursor();
    window.run_steps(1);
    let image = window.render().expect("an image");
    let mut found = Rect::NOTHING;
    for (x, y, pixel) in image.enumerate_pixels() {
        let at = Pos2::new(x as f32 + 0.5, y as f32 + 0.5);
        if sky.shrink(2.0).contains(at) && pixel.0[..3].iter().any(|c| *c > 40) {
            found.extend_with(at);
        }
    }
    (found.width(), found.height(), found.center())
}

#[test]
fn an_image_keeps_its_shape_until_the_next_one_is_there() {
    let mut moon = interface(NaifId::MOON, "2024-04-24T00:00:00Z");
    (moon.settings.labels_bodies, moon.settings.marks_small_bodies, moon.settings.outlines_selected) = (false, false, false);
    let is_drawing: Arc<AtomicBool> = Arc::new(true.into());
    let mut window = pausable_window(moon, &is_drawing, 640.0);
    settle(&mut window);
    let sky = |w: &Window| w.get_by_label_contains("The sky:").rect();
    let before_sky = sky(&window);
    let (width, height, _) = bright_area(&mut window, before_sky);
    assert!(width > 200.0 && (width / height - 1.0).abs() < 0.1, "the Moon's disc is {width} by {height}");
    is_drawing.store(false, Ordering::Relaxed);
    for size in [[1100.0, 640.0], [1400.0, 640.0], [900.0, 640.0], [1100.0, 900.0], [1300.0, 480.0]] {
        for (tab, bodies) in [(None, true), (Some(Tab::Information), true), (Some(Tab::Compare), false), (None, false)] {
            window.set_size(size.into());
            (window.state_mut().tab, window.state_mut().body_browser_shown) = (tab, bodies);
            window.run_steps(3);
            let sky_now = sky(&window);
            let (w, h, middle) = bright_area(&mut window, sky_now);
            let case = format!("{size:?}, {tab:?}, list {bodies}: {w} by {h} in {sky_now}");
            // The vertical field of view is fixed: at each size the disc fills the same fraction of the height.
            let scale = sky_now.height() / before_sky.height();
            assert!((w - width * scale).abs() < 3.0 && (h - height * scale).abs() < 3.0, "{case}, {width} by {height} before");
            assert!((middle.x - sky_now.center().x).abs() < 3.0, "{case}: middle at {middle}");
            // A click hits the body displayed there.
            window.state_mut().viewer.selected = NaifId::SUN;
            click(&mut window, middle);
            window.run_steps(1);
            assert_eq!(window.state().viewer.selected, NaifId::MOON, "{case}");
        }
    }
    // In the next image the Moon has the same size and position.
    let sky_now = sky(&window);
    let (w, h, middle) = bright_area(&mut window, sky_now);
    is_drawing.store(true, Ordering::Relaxed);
    window.state_mut().viewer.view.quality = Quality::Standard;
    settle(&mut window);
    let sky_now = sky(&window);
    let drawn = bright_area(&mut window, sky_now);
    assert!(
        (drawn.0 - w).abs() < 3.0 && (drawn.1 - h).abs() < 3.0 && (drawn.2 - middle).length() < 3.0,
        "{drawn:?} after {w} by {h} at {middle}"
    );
}

/// Compared images are shown in windows of other aspect ratios than the one for which they were drawn.
#[test]
fn compared_images_are_never_stretched() {
    let mut moon = interface(NaifId::MOON, "2024-04-24T00:00:00Z");
    (moon.settings.labels_bodies, moon.settings.marks_small_bodies, moon.settings.outlines_selected) = (false, false, false);
    let is_drawing: Arc<AtomicBool> = Arc::new(true.into());
    let mut window = pausable_window(moon, &is_drawing, 640.0);
    window.state_mut().tab = Some(Tab::Compare);
    settle(&mut window);
    let request = window.state().shown().expect("an image").job.request.clone();
    let aspect = f64::from(request.width) / f64::from(request.height);
    is_drawing.store(false, Ordering::Relaxed);
    let mut sizes = std::collections::BTreeSet::new();
    for size in [[1100.0, 640.0], [1500.0, 640.0], [900.0, 700.0], [1100.0, 1000.0], [1300.0, 560.0]] {
        window.set_size(size.into());
        // The list of bodies may be hidden in the new size, which gives the other widgets new ids.
        window.run_steps(1);
        for (page, image) in
            [("Split", "draft to the left"), ("Side by side", "draft"), ("Side by side", "reference"), ("Difference", "Difference of")]
        {
            window.get_by_label(page).click_accesskit();
            window.run_steps(3);
            let image = |n: &egui_kittest::Node<'_>| n.accesskit_node().label().is_some_and(|l| l.starts_with(image));
            let rect = window.query_all_by_role(Role::Image).find(image).unwrap_or_else(|| panic!("{page} at {size:?}: no image")).rect();
            let case = format!("{page} at {size:?}: {rect}, of aspect ratio {aspect}");
            sizes.insert(((rect.width() * 10.0) as i32, (rect.height() * 10.0) as i32));
            if page != "Side by side" {
                assert!((f64::from(rect.width() / rect.height()) / aspect - 1.0).abs() < 0.02, "{case}");
            }
            // The Moon is round wherever it is not cropped.
            if page == "Side by side" && rect.bottom() < size[1] - 40.0 {
                let (width, height, _) = bright_area(&mut window, rect);
                assert!(width > 20.0 && (width / height - 1.0).abs() < 0.15, "{case}: the Moon is {width} by {height}");
            }
        }
    }
    assert!(sizes.len() > 1, "images have one size in all windows: {sizes:?}");
}
