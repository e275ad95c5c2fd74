//! The panels at the sides: their controls neither widen them nor are cut off, every control can be scrolled to, and each panel keeps its scroll position. They
//! leave room for the image, and only the user changes their stored widths.

use crate::support::sweep;
use crate::view::input::{SATURN, TIME, Window, window_without_images};
use crate::view::interface::{harness, interface, session, settle};
use egui::accesskit::{Role, Toggled};
use egui::{Event, Modifiers, MouseWheelSource, MouseWheelUnit, Order, Pos2, Rect, TouchPhase, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::moments::KINDS;
use orrery::view::app::settings::Bookmark;
use orrery::view::language::Language;
use orrery::view::panels::Tab;

/// Margin of the test window, points.
const WINDOW_MARGIN: f32 = 8.0;

/// Each language, with the beginning of the viewport's name and the name of the button that closes a panel, in which `{}` is the panel's title.
const LANGUAGES: [(Language, &str, &str); 2] =
    [(Language::English, "The sky:", "Close {}"), (Language::German, "Der Himmel:", "{} schließen")];

/// A window of this size at rest, with an open panel and perhaps a kept one.
fn window(language: Language, [width, height]: [f32; 2], kept: Option<Tab>, open: Tab) -> Window {
    let mut interface = interface(SATURN, TIME);
    interface.language = language;
    (interface.kept_tab, interface.tab) = (kept, Some(open));
    let mut window = harness(interface);
    window.set_size(vec2(width, height));
    settle(&mut window);
    window
}

/// The rectangles of a panel's title and of the button that closes it.
fn title_and_close(window: &Window, tab: Tab, close_name: &str) -> (Rect, Rect) {
    let close = window.get_by_role_and_label(Role::Button, &close_name.replace("{}", tab.title())).rect();
    let mut titles = window.query_all_by_role_and_label(Role::Label, tab.title()).map(|title| title.rect());
    let title = titles.find(|title| (title.center().y - close.center().y).abs() < 8.0);
    (title.expect("a title"), close)
}

/// Where the controls of two panels need more room than there is, they wrap or scroll sideways. The left part of the panel at the right was once hidden.
#[test]
fn no_panel_is_cut_off_beside_a_kept_one() {
    for (language, sky_name, close_name) in LANGUAGES {
        for (size, kept, open) in [
            ([1280.0, 800.0], Tab::Effects, Tab::Compare),
            ([1280.0, 800.0], Tab::Share, Tab::Shader),
            ([1000.0, 700.0], Tab::Effects, Tab::Shader),
            ([1000.0, 700.0], Tab::Effects, Tab::Compare),
            ([1010.0, 700.0], Tab::Share, Tab::Events),
        ] {
            let window = window(language, size, Some(kept), open);
            let case = format!("{language:?}, {size:?}: {kept:?} and {open:?}");
            let sky = window.get_by_label_contains(sky_name).rect();
            assert!(sky.width() >= 310.0, "{case}: the viewport is at {sky}");
            let (title, close) = title_and_close(&window, open, close_name);
            assert!(title.left() >= sky.right() && close.right() <= size[0], "{case}: title {title}, button {close}, viewport {sky}");
            let (title, close) = title_and_close(&window, kept, close_name);
            assert!(title.left() >= 0.0 && close.right() <= sky.left(), "{case}: title {title}, button {close}, viewport {sky}");
        }
    }
}

/// At the usual size of a window, the list of bodies makes room for a narrow and a wide panel. The windows begin at a width of 1100 points, where a wide panel
/// beside a kept one is narrower than by default: once it stayed so in a wider window.
#[test]
fn the_list_of_bodies_makes_room_for_two_panels() {
    for (width, kept, open, has_list) in [
        (1280.0, Tab::Effects, Tab::Shader, false),
        (1280.0, Tab::Effects, Tab::Information, true),
        (1500.0, Tab::Effects, Tab::Shader, true),
        (1500.0, Tab::Shader, Tab::Compare, false),
    ] {
        let window = window(Language::English, [width, 700.0], Some(kept), open);
        assert_eq!(window.query_by_label("Follow target").is_some(), has_list, "{kept:?} and {open:?} at {width}");
        // Neither panel is narrower than by default. The kept one is at the left, beside the list.
        let sky = window.get_by_label_contains("The sky:").rect();
        let list_width = if has_list { window.state().settings.panels.bodies_width.expect("a width") } else { 0.0 };
        let widths = [sky.left() - WINDOW_MARGIN - list_width, width_at_the_right(&window, width, "The sky:")];
        for (tab, shown) in [kept, open].into_iter().zip(widths) {
            let default = if matches!(tab, Tab::Shader | Tab::Compare) { 560.0 } else { 330.0 };
            assert!((shown - default).abs() < 8.0, "{kept:?} and {open:?} at {width}: {tab:?} is {shown} wide");
        }
    }
}

/// A wide panel that is kept open alone takes as much room as one that is not kept: the list of bodies once left 250 points for the image.
#[test]
fn a_wide_kept_panel_alone_hides_the_list_of_bodies() {
    for (width, kept, has_list) in [(1050.0, Tab::Shader, false), (1050.0, Tab::Effects, true), (1080.0, Tab::Shader, true)] {
        let mut window = window(Language::English, [width, 700.0], Some(kept), Tab::Events);
        window.state_mut().tab = None;
        window.run_steps(5);
        assert_eq!(window.query_by_label("Follow target").is_some(), has_list, "{kept:?} at {width}");
    }
}

/// The width of the panel at the right of a window of this width. `sky_name`: the beginning of the viewport's name.
fn width_at_the_right(window: &Window, window_width: f32, sky_name: &str) -> f32 {
    window_width - WINDOW_MARGIN - window.get_by_label_contains(sky_name).rect().right()
}

/// Drags the left edge of the panel at the right of the viewport.
fn drag_edge(window: &mut Window, by: f32) {
    // Just inside the panel: the image, on whose edge the same point would be, is dragged otherwise.
    let start = window.get_by_label_contains("The sky:").rect().right_center() + vec2(2.0, 0.0);
    window.hover_at(start);
    window.run_steps(1);
    window.drag_at(start);
    window.run_steps(1);
    for part in [0.5, 1.0] {
        window.hover_at(start + vec2(part * by, 0.0));
        window.run_steps(2);
    }
    window.drop_at(start + vec2(by, 0.0));
    settle(window);
}

/// A panel that was dragged to 920 points in a wide window once covered a window of 900 points, and left an image of one pixel beside the list of bodies.
#[test]
fn a_widened_panel_leaves_room_for_the_image_in_any_window() {
    for (width, min_sky, has_list) in [(600.0, 290.0, false), (900.0, 310.0, false), (1200.0, 310.0, false), (1500.0, 310.0, true)] {
        for (kept, open) in
            [(None, Some(Tab::Compare)), (None, Some(Tab::Information)), (Some(Tab::Shader), None), (Some(Tab::Effects), None)]
        {
            // The kept panel needs a window for two.
            if kept.is_some() && width < 1000.0 {
                continue;
            }
            let mut interface = interface(SATURN, TIME);
            let panels = &mut interface.settings.panels;
            let widths = [&mut panels.panel_width, &mut panels.wide_width, &mut panels.kept_width, &mut panels.kept_wide_width];
            widths.into_iter().for_each(|stored| *stored = Some(920.0));
            (interface.kept_tab, interface.tab) = (kept, open);
            let mut window = harness(interface);
            window.set_size(vec2(width, 700.0));
            settle(&mut window);
            let sky = window.get_by_label_contains("The sky:").rect();
            assert!(sky.width() >= min_sky, "{kept:?} and {open:?} at {width}: the viewport is at {sky}");
            assert_eq!(window.query_by_label("Follow target").is_some(), has_list, "{kept:?} and {open:?} at {width}");
            let panels = &window.state().settings.panels;
            let stored = [panels.panel_width, panels.wide_width, panels.kept_width, panels.kept_wide_width];
            assert_eq!(stored, [Some(920.0); 4], "{kept:?} and {open:?} at {width}");
        }
    }
    // Two panels that want 920 points each.
    let mut interface = interface(SATURN, TIME);
    (interface.settings.panels.kept_width, interface.settings.panels.wide_width) = (Some(920.0), Some(920.0));
    (interface.kept_tab, interface.tab) = (Some(Tab::Effects), Some(Tab::Shader));
    let mut window = harness(interface);
    window.set_size(vec2(1280.0, 700.0));
    settle(&mut window);
    let sky = window.get_by_label_contains("The sky:").rect();
    assert!(sky.width() >= 310.0, "the viewport is at {sky}");
}

/// A window that was small for a moment once left the widths that it had enforced.
#[test]
fn only_the_user_changes_a_stored_width() {
    for (tab, default) in [(Tab::Shader, 560.0), (Tab::Information, 330.0)] {
        let mut window = window(Language::English, [1280.0, 800.0], None, tab);
        let stored = |window: &Window| {
            let panels = &window.state().settings.panels;
            let width = if tab == Tab::Shader { panels.wide_width } else { panels.panel_width };
            width.expect("a width")
        };
        let shown = |window: &Window| width_at_the_right(window, 1280.0, "The sky:");
        let is_near = |a: f32, b: f32| (a - b).abs() < 3.0;
        for size in [[500.0, 500.0], [250.0, 400.0], [640.0, 480.0]] {
            window.set_size(size.into());
            settle(&mut window);
            window.set_size(vec2(1280.0, 800.0));
            settle(&mut window);
            assert_eq!(stored(&window), default, "{tab:?}, {size:?}");
            assert!(is_near(shown(&window), default), "{tab:?}, {size:?}: {}", shown(&window));
        }
        // The user does change it, to more and to less.
        for by in [-120.0, 60.0] {
            let before = shown(&window);
            drag_edge(&mut window, by);
            assert!(is_near(shown(&window), before - by), "{tab:?}, {by}: from {before} to {}", shown(&window));
            assert!(is_near(stored(&window), shown(&window)), "{tab:?}, {by}: {} stored", stored(&window));
        }
        // No further than the room for the image.
        drag_edge(&mut window, -900.0);
        let sky = window.get_by_label_contains("The sky:").rect();
        assert!(sky.width() >= 310.0, "{tab:?}: the viewport is at {sky}");
        assert!(is_near(stored(&window), shown(&window)) && shown(&window) > default + 100.0, "{tab:?}: {}", stored(&window));
    }
}

/// The list of bodies once appeared in the middle of the drag, and pushed the panel at the left aside, so that its edge jumped.
#[test]
fn the_list_of_bodies_appears_only_at_the_end_of_a_drag() {
    for (kept, open) in [(None, Some(Tab::Shader)), (Some(Tab::Shader), None)] {
        let mut interface = interface(SATURN, TIME);
        let panels = &mut interface.settings.panels;
        (panels.wide_width, panels.kept_wide_width) = (Some(800.0), Some(800.0));
        // The kept panel is on the other side.
        panels.on_left = open.is_some();
        (interface.kept_tab, interface.tab) = (kept, open);
        let mut window = harness(interface);
        window.set_size(vec2(1280.0, 700.0));
        settle(&mut window);
        let case = format!("{kept:?} and {open:?}");
        let has_list = |window: &Window| window.query_by_label("Follow target").is_some();
        assert!(!has_list(&window), "{case}: the list has room beside 800 points");
        let sky_left = |window: &Window| window.get_by_label_contains("The sky:").rect().left();
        // Just inside the panel.
        let start = window.get_by_label_contains("The sky:").rect().left_center() - vec2(2.0, 0.0);
        window.hover_at(start);
        window.run_steps(1);
        window.drag_at(start);
        window.run_steps(1);
        for by in [-50.0, -150.0, -250.0, -300.0] {
            window.hover_at(start + vec2(by, 0.0));
            window.run_steps(2);
            let off = sky_left(&window) - start.x - by;
            assert!(!has_list(&window) && off.abs() < 4.0, "{case}: after {by}, the edge is {off} from the pointer");
        }
        window.drop_at(start + vec2(-300.0, 0.0));
        settle(&mut window);
        assert!(has_list(&window), "{case}: the list has room, but does not appear");
        let panels = &window.state().settings.panels;
        let stored = if open.is_some() { panels.wide_width } else { panels.kept_wide_width };
        assert!((stored.expect("a width") - 500.0).abs() < 8.0, "{case}: {stored:?} stored");
    }
}

/// Opening Share once widened all narrow panels, because its controls did not wrap.
#[test]
fn a_panel_keeps_its_width_whatever_it_shows() {
    for (language, sky_name, _) in LANGUAGES {
        for size in [[1280.0, 800.0], [900.0, 600.0]] {
            let mut window = window(language, size, None, Tab::Events);
            let view = window.state().viewer.view.clone();
            window.state_mut().settings.bookmarks.push(Bookmark { name: "the rings of Saturn ".repeat(6), view });
            for tab in [Tab::Share, Tab::Events] {
                window.state_mut().tab = Some(tab);
                settle(&mut window);
                let width = width_at_the_right(&window, size[0], sky_name);
                assert!((width - 330.0).abs() < 1.5, "{language:?}, {size:?}, {tab:?}: {width}");
                for button in window.query_all_by_role(Role::Button) {
                    let (rect, name) = (button.rect(), button.accesskit_node().label().unwrap_or_default());
                    assert!(rect.right() <= size[0], "{language:?}, {size:?}, {tab:?}: {name} at {rect}");
                }
            }
        }
    }
}

/// A panel once opened scrolled to where another one was left.
#[test]
fn each_panel_keeps_its_own_scroll_position() {
    let mut window = window_without_images(SATURN);
    window.set_size(vec2(1100.0, 640.0));
    window.state_mut().tab = Some(Tab::Moments);
    window.run_steps(5);
    let top = |window: &Window, name: &str| window.get_by_label(name).rect().top();
    let first = "The sky tonight";
    let unscrolled = top(&window, first);
    let last = session().catalog().moments().iter().rfind(|moment| Some(moment.kind.as_str()) == KINDS.last().copied());
    window.get_by_label(&last.expect("a moment").name).scroll_to_me();
    window.run_steps(90);
    let scrolled = top(&window, first);
    assert!(scrolled < unscrolled - 200.0, "scrolled from {unscrolled} to {scrolled}");
    window.state_mut().tab = Some(Tab::Share);
    window.run_steps(5);
    assert!((30.0..120.0).contains(&top(&window, "This view")), "Share begins at {}", top(&window, "This view"));
    window.get_by_label("at the right").scroll_to_me();
    window.run_steps(90);
    // The panel is where it was left, at the right and, once it is kept open, at the left.
    for tabs in [(Some(Tab::Moments), None), (None, Some(Tab::Moments))] {
        (window.state_mut().tab, window.state_mut().kept_tab) = tabs;
        window.run_steps(5);
        assert!((top(&window, first) - scrolled).abs() < 2.0, "{tabs:?}: {} instead of {scrolled}", top(&window, first));
    }
}

/// The pages of the Shader panel, by their English names.
const SHADER_PAGES: [&str; 6] = ["Source", "Values", "Cost", "Probe", "Gallery", "Key"];

/// The lowest widget of a panel at this place: all of it, and its part that is visible. Widgets that begin at the right edge or beyond are left out.
fn lowest_widget(window: &Window, panel: Rect) -> [Rect; 2] {
    let is_in_panel = |widget: Rect| widget.left() >= panel.left() - 2.0 && widget.left() <= panel.right() - 16.0;
    // No part of a panel is visible below its place: this widget belongs to the time bar.
    let is_below = |visible: Rect| visible.is_positive() && visible.top() >= panel.bottom() - 1.0;
    let lowest = window.ctx.viewport(|viewport| {
        let layers = viewport.prev_pass.widgets.layers().filter(|(layer, _)| layer.order == Order::Background);
        let widgets = layers.flat_map(|(_, widgets)| widgets).filter(|w| w.sense.interactive() && is_in_panel(w.rect));
        let widgets = widgets.filter(|w| !is_below(w.interact_rect)).map(|w| [w.rect, w.interact_rect]);
        widgets.max_by(|a, b| a[0].bottom().total_cmp(&b[0].bottom()))
    });
    lowest.expect("a widget")
}

/// Turns the wheel far down.
fn scroll_to_the_end(window: &mut Window, pointer: Pos2) {
    window.hover_at(pointer);
    // At first a list may not be below the pointer; then the panel scrolls before the list.
    for _ in 0..4 {
        let (unit, phase, source) = (MouseWheelUnit::Point, TouchPhase::Move, MouseWheelSource::Wheel);
        window.event(Event::MouseWheel { unit, delta: vec2(0.0, -1e5), phase, source, modifiers: Modifiers::NONE });
        // egui applies the wheel's turn over some time, and after `settle` time stands still unless it is set.
        for _ in 0..4 {
            window.run_steps(1);
            let next = window.input_mut().time.unwrap_or(0.0) + 0.25;
            window.input_mut().time = Some(next);
        }
    }
}

/// With all sections open, the list of effects was below the window's edge, where nothing scrolled. In points, a window of 1280 by 800 pixels is one of 640 by
/// 400 at text size 2. The last size is the smallest to which the size of the text may reduce a window.
#[test]
fn every_control_can_be_scrolled_to() {
    let sizes = [[1280.0, 800.0], [640.0, 400.0], [600.0, 340.0]];
    let cases = LANGUAGES.into_iter().flat_map(|language| sizes.map(|size| (language, size)));
    for (_, ((language, sky_name, close_name), size)) in cases.enumerate().filter(|(k, _)| sweep::runs(*k, 3)) {
        let mut window = window(language, size, None, Tab::Moments);
        window.state_mut().body_browser_shown = false;
        for tab in Tab::ALL {
            window.state_mut().tab = Some(tab);
            settle(&mut window);
            // All of its sections.
            let sections = window
                .query_all_by_role(Role::DisclosureTriangle)
                .filter(|section| section.accesskit_node().toggled() != Some(Toggled::True));
            let sections: Vec<String> = sections.filter_map(|section| section.accesskit_node().label()).collect();
            for section in sections {
                window.get_by_role_and_label(Role::DisclosureTriangle, &section).click_accesskit();
                window.run_steps(1);
            }
            let pages = if tab == Tab::Shader && language == Language::English { &SHADER_PAGES[..] } else { &[""][..] };
            for page in pages {
                if !page.is_empty() {
                    window.get_all_by_role_and_label(Role::Button, page).next().expect(page).click_accesskit();
                }
                settle(&mut window);
                let (title, close) = title_and_close(&window, tab, close_name);
                let bottom = window.get_by_label_contains(sky_name).rect().bottom();
                let panel = Rect::from_min_max(pos2(title.left(), close.top()), pos2(close.right(), bottom));
                let is_seen = |[whole, visible]: [Rect; 2]| visible.is_positive() && visible.bottom() >= whole.bottom() - 1.0;
                let case = format!("{language:?}, {size:?}: {tab:?} {page}, in {panel}");
                let lowest = lowest_widget(&window, panel);
                assert!(tab != Tab::Effects || !is_seen(lowest), "{case}: {lowest:?} fits, so that this test sees nothing");
                scroll_to_the_end(&mut window, pos2(panel.center().x, bottom - 12.0));
                let lowest = lowest_widget(&window, panel);
                assert!(is_seen(lowest), "{case}: {lowest:?}");
            }
        }
    }
}
