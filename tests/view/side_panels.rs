//! The panels at the sides: their controls neither widen them nor are cut off, every control can be scrolled to, and each panel keeps its scroll position.

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
        let panels = &window.state().settings.panels;
        // Neither panel is narrower than by default.
        let widths = [panels.panel_width, panels.wide_width, panels.kept_width, panels.kept_wide_width];
        let is_default = |width: f32| (width - 330.0).abs() < 1.0 || (width - 560.0).abs() < 1.0;
        assert_eq!(widths.into_iter().flatten().filter(|width| is_default(*width)).count(), 2, "{widths:?}");
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

/// Opening Share once widened all narrow panels, because its controls did not wrap.
#[test]
fn a_panel_keeps_its_width_whatever_it_shows() {
    for (language, ..) in LANGUAGES {
        for size in [[1280.0, 800.0], [900.0, 600.0]] {
            let mut window = window(language, size, None, Tab::Events);
            let view = window.state().viewer.view.clone();
            window.state_mut().settings.bookmarks.push(Bookmark { name: "the rings of Saturn ".repeat(6), view });
            for tab in [Tab::Share, Tab::Events] {
                window.state_mut().tab = Some(tab);
                settle(&mut window);
                let width = window.state().settings.panels.panel_width.expect("a width");
                assert!((width - 330.0).abs() < 1.0, "{language:?}, {size:?}, {tab:?}: {width}");
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
