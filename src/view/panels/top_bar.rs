//! The bar above the sky, in groups: explore, see, understand, share.
//!
//! In: clicks. Out: opened panels, switches, actions. Always: each button has an icon, a text and a tooltip with its key.

use super::icons::{self, Icon};
use super::{Interface, Tab, search};
use crate::view::app::viewer::Action;
use crate::view::worker::render_worker::RenderWorker;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{PopupCloseBehavior, Ui};

/// Window width above which the groups of the bar have captions, points.
const CAPTIONED_WIDTH: f32 = 1500.0;

impl Tab {
    fn icon(self) -> Icon {
        match self {
            Self::Moments => Icon::Moments,
            Self::Events => Icon::Events,
            Self::Effects => Icon::Effects,
            Self::Shader => Icon::Shader,
            Self::Compare => Icon::Compare,
            Self::Information => Icon::Information,
            Self::Performance => Icon::Performance,
            Self::Share => Icon::Share,
        }
    }
}

pub(crate) fn bar(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        caption(ui, "Explore");
        icons::toggle(ui, Icon::Bodies, &mut interface.bodies_shown, "Bodies").on_hover_text("Show the list of bodies (b)");
        search::field(interface, ui, worker, actions);
        let can_go = [interface.viewer.has_previous_view(), interface.viewer.has_next_view()];
        for (can_go, icon, name, hover, action) in [
            (can_go[0], Icon::Back, "Back", "Previous view (Backspace)", Action::PreviousView),
            (can_go[1], Icon::Forward, "Forward", "Next view (Shift+Backspace)", Action::NextView),
        ] {
            let button = ui.add_enabled_ui(can_go, |ui| icons::bare(ui, icon, name)).inner;
            if button.on_hover_text(hover).clicked() {
                actions.push(action);
            }
        }
        tabs(interface, ui, &[Tab::Moments, Tab::Events]);
        ui.separator();
        caption(ui, "See");
        tabs(interface, ui, &[Tab::Effects]);
        layers_menu(interface, ui);
        ui.separator();
        caption(ui, "Understand");
        tabs(interface, ui, &[Tab::Information, Tab::Shader, Tab::Compare, Tab::Performance]);
        ui.separator();
        tabs(interface, ui, &[Tab::Share]);
        icons::toggle(ui, Icon::Help, &mut interface.help_shown, "Help").on_hover_text("Keyboard and mouse help (?)");
    });
}

/// Buttons of panels, each with the key that opens it.
fn tabs(interface: &mut Interface, ui: &mut Ui, tabs: &[Tab]) {
    for tab in tabs {
        let key = Tab::ALL.iter().position(|t| t == tab).map_or(0, |at| at + 1);
        let is_open = interface.tab == Some(*tab);
        let button = icons::selectable(ui, tab.icon(), is_open, tab.title());
        if button.on_hover_text(format!("{} ({key})", tab.about())).clicked() {
            interface.tab = (!is_open).then_some(*tab);
        }
    }
}

/// A menu of switches that stays open while they are pressed.
fn layers_menu(interface: &mut Interface, ui: &mut Ui) {
    let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let button = icons::button(ui, Icon::Layers, "Layers");
    let (button, _) = MenuButton::from_button(button).config(stays).ui(ui, |ui| layers(interface, ui));
    button.on_hover_text("Names, markers, orbits, outline (n, m, o, x)");
}

/// Switches of everything besides the bodies.
fn layers(interface: &mut Interface, ui: &mut Ui) {
    let settings = &mut interface.settings;
    ui.toggle_value(&mut settings.names, "Names").on_hover_text("Label bodies with their names (n)");
    ui.toggle_value(&mut settings.markers, "Markers").on_hover_text("Mark bodies that are too small to see (m)");
    ui.toggle_value(&mut interface.viewer.view.orbits, "Orbits").on_hover_text("Show orbits (o)");
    ui.toggle_value(&mut settings.outline, "Outline").on_hover_text("Outline the selected body, unless it is the target (x)");
    let layers = &mut interface.viewer.view.layers;
    for (shown, name, about) in [
        (&mut layers.traces, "Traces", "Show where bodies have been, as seen from the target"),
        (&mut layers.minor_planets, "Minor planets", "Show minor planets, marked where they are too faint"),
        (&mut layers.comets, "Comets", "Show comets and their tails"),
        (&mut layers.features, "Features", "Name craters, mountains and landing sites of bodies that are large enough"),
        (&mut layers.caption, "Caption", "Write body, date, standpoint and field of view into the picture"),
        (&mut layers.scale_bar, "Scale", "Show a scale bar: a length at the target's distance, or an angle"),
        (&mut layers.compass, "Compass", "Show where the target's north is"),
    ] {
        ui.toggle_value(shown, name).on_hover_text(about);
    }
}

/// The caption of a group of controls, in a wide window.
pub(crate) fn caption(ui: &mut Ui, name: &str) {
    if ui.ctx().content_rect().width() >= CAPTIONED_WIDTH {
        ui.small(name);
    }
}
