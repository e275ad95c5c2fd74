//! The bar above the viewport, with its controls under the captions *Explore*, *See* and *Understand*; those for sharing and help have no caption.
//!
//! In: clicks. Out: opened panels, switches, actions. Always: each button has an icon, a tooltip, and a text or an accessible name.

use super::icons::{self, Icon};
use super::tab::Group;
use super::{Interface, Tab, search, theme};
use crate::view::app::viewer::Action;
use crate::view::language::text;
use crate::view::worker::render_worker::RenderWorker;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{PopupCloseBehavior, Ui};

/// Minimum width of a window for captions of groups of controls, points.
const MIN_WIDTH_FOR_CAPTIONS: f32 = 1500.0;

pub(crate) fn bar(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        caption(ui, text!("bar-explore"));
        icons::toggle(ui, Icon::Bodies, &mut interface.body_browser_shown, text!("bar-bodies")).on_hover_text(text!("bar-bodies-hint"));
        search::field(interface, ui, worker, actions);
        let (can_go_back, can_go_forward) = (interface.viewer.has_previous_view(), interface.viewer.has_next_view());
        for (is_enabled, icon, name, hover, action) in [
            (can_go_back, Icon::Back, text!("bar-back"), text!("bar-back-hint"), Action::PreviousView),
            (can_go_forward, Icon::Forward, text!("bar-forward"), text!("bar-forward-hint"), Action::NextView),
        ] {
            let button = ui.add_enabled_ui(is_enabled, |ui| icons::icon_button(ui, icon, name)).inner;
            if button.on_hover_text(hover).clicked() {
                actions.push(action);
            }
        }
        tab_buttons(interface, ui, Group::Explore);
        ui.separator();
        caption(ui, text!("bar-see"));
        tab_buttons(interface, ui, Group::See);
        layers_menu(interface, ui);
        ui.separator();
        caption(ui, text!("bar-understand"));
        tab_buttons(interface, ui, Group::Bodies);
        tab_buttons(interface, ui, Group::Drawing);
        ui.separator();
        tab_buttons(interface, ui, Group::Share);
        icons::toggle(ui, Icon::Help, &mut interface.help_shown, text!("bar-help")).on_hover_text(text!("bar-help-hint"));
    });
}

/// Shows the buttons of a group's panels; each button's tooltip names the key that opens the panel.
fn tab_buttons(interface: &mut Interface, ui: &mut Ui, group: Group) {
    for tab in Tab::ALL.into_iter().filter(|tab| tab.group() == group) {
        let is_open = interface.is_open(ui.ctx(), tab);
        let show_button = if tab.has_titled_button() { icons::selectable } else { icons::selectable_without_text };
        let button = show_button(ui, tab.icon(), is_open, tab.title());
        if button.on_hover_text(text!("bar-tab-hint", about = tab.about(), key = tab.digit())).clicked() {
            interface.toggle(ui.ctx(), tab);
        }
    }
}

/// Shows the Layers menu, which stays open when a switch in it is pressed.
fn layers_menu(interface: &mut Interface, ui: &mut Ui) {
    let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside).style(theme::menu_style);
    let button = icons::button(ui, Icon::Layers, text!("bar-layers"));
    let (button, _) = MenuButton::from_button(button).config(config).ui(ui, |ui| layers(interface, ui));
    button.on_hover_text(text!("bar-layers-hint"));
}

/// Shows the switches of names, markers, orbits and other layers that are drawn over or beside the bodies.
fn layers(interface: &mut Interface, ui: &mut Ui) {
    let settings = &mut interface.settings;
    ui.toggle_value(&mut settings.labels_bodies, text!("layer-names")).on_hover_text(text!("layer-names-hint"));
    ui.toggle_value(&mut settings.marks_small_bodies, text!("layer-markers")).on_hover_text(text!("layer-markers-hint"));
    ui.toggle_value(&mut interface.viewer.view.orbits, text!("layer-orbits")).on_hover_text(text!("layer-orbits-hint"));
    ui.toggle_value(&mut settings.outlines_selected, text!("layer-outline")).on_hover_text(text!("layer-outline-hint"));
    let layers = &mut interface.viewer.view.layers;
    for (is_shown, name, hover) in [
        (&mut layers.bright_stars, text!("layer-bright-stars"), text!("layer-bright-stars-hint")),
        (&mut layers.traces, text!("layer-traces"), text!("layer-traces-hint")),
        (&mut layers.minor_planets, text!("layer-minor-planets"), text!("layer-minor-planets-hint")),
        (&mut layers.comets, text!("layer-comets"), text!("layer-comets-hint")),
        (&mut layers.features, text!("layer-features"), text!("layer-features-hint")),
        (&mut layers.caption, text!("layer-caption"), text!("layer-caption-hint")),
        (&mut layers.scale_bar, text!("layer-scale"), text!("layer-scale-hint")),
        (&mut layers.compass, text!("layer-compass"), text!("layer-compass-hint")),
    ] {
        ui.toggle_value(is_shown, name).on_hover_text(hover);
    }
}

/// Shows the caption of a group of controls, if the window is wide enough.
pub(crate) fn caption(ui: &mut Ui, name: &str) {
    if ui.ctx().content_rect().width() >= MIN_WIDTH_FOR_CAPTIONS {
        ui.small(name);
    }
}
