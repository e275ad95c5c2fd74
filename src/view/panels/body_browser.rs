//! The tree of bodies.
//!
//! In: the bodies, clicks. Out: actions that select a body or fly to it. Always: a click selects the row that was under the pointer when the button
//! was pressed, because no branch expands while a button is held. The tree expands and scrolls inside its own scroll area.

use super::Interface;
use super::table::row_button;
use crate::catalog::{BodyKind, NaifId};
use crate::view::app::viewer::{Action, SelectableBody};
use crate::view::language::{body_name, text};
use egui::ScrollArea;
use egui::collapsing_header::CollapsingState;

/// What the tree remembers from frame to frame, besides egui's state of its branches.
#[derive(Default)]
pub(crate) struct BodyBrowser {
    /// The selected body for which the tree was last expanded.
    expanded_for: Option<NaifId>,
    /// The last body that was clicked in the tree; as its row is visible already, the tree does not scroll to it.
    clicked: Option<NaifId>,
    /// The body to which the tree scrolls in each frame until all branches have finished expanding.
    scroll_target: Option<NaifId>,
}

/// Shows the Sun, the planets, each with its moons, and then the other bodies.
pub(crate) fn tree(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let revealed = body_to_reveal(interface, ui);
    let actions_before = actions.len();
    let mut is_expanding = false;
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(0.0).show(ui, |ui| {
        let bodies = interface.viewer.selectable_bodies();
        let is_top_level = |s: &&SelectableBody| s.kind != BodyKind::Moon;
        for body in bodies.iter().filter(is_top_level) {
            let moons: Vec<&SelectableBody> = bodies.iter().filter(|s| s.kind == BodyKind::Moon && s.parent == Some(body.id)).collect();
            if moons.is_empty() {
                body_row(interface, ui, body, actions);
                continue;
            }
            let id = ui.make_persistent_id(("moons of", body.id.0));
            let mut branch = CollapsingState::load_with_default_open(ui.ctx(), id, false);
            if revealed.is_some_and(|selected| selected == body.id || moons.iter().any(|m| m.id == selected)) {
                branch.set_open(true);
            }
            is_expanding |= branch.is_open() && branch.openness(ui.ctx()) < 1.0;
            let is_open = branch.is_open();
            let (arrow, ..) = branch.show_header(ui, |ui| body_row(interface, ui, body, actions)).body(|ui| {
                for moon in moons {
                    body_row(interface, ui, moon, actions);
                }
            });
            // An arrow alone has no accessible name.
            let name = text!("bodies-moons-of", body = body_name(&body.name));
            arrow.widget_info(|| egui::WidgetInfo::selected(egui::Role::DisclosureTriangle, true, is_open, &name));
        }
    });
    if !is_expanding {
        interface.body_browser.scroll_target = None;
    }
    if let Some(Action::Select(id) | Action::FlyTo(id)) = actions[actions_before..].last() {
        interface.body_browser.clicked = Some(*id);
    }
}

/// The newly selected body, whose branch must be expanded; otherwise `None`. A selection is returned only once, so that the user can collapse the branch again.
/// While a button is held no branch expands; a selection made meanwhile is returned after the release.
fn body_to_reveal(interface: &mut Interface, ui: &egui::Ui) -> Option<NaifId> {
    let selected = interface.viewer.selected;
    let browser = &mut interface.body_browser;
    if browser.expanded_for == Some(selected) {
        return None;
    }
    if ui.input(|i| i.pointer.any_down() || i.pointer.any_released()) {
        ui.ctx().request_repaint();
        return None;
    }
    browser.expanded_for = Some(selected);
    browser.scroll_target = (browser.clicked.take() != Some(selected)).then_some(selected);
    Some(selected)
}

/// Shows the row of a body: a click selects the body, a double click flies to it.
fn body_row(interface: &Interface, ui: &mut egui::Ui, body: &SelectableBody, actions: &mut Vec<Action>) {
    let is_selected = interface.viewer.selected == body.id;
    let response = row_button(ui, ("body in the list", body.id.0), is_selected, body_name(&body.name));
    if interface.body_browser.scroll_target == Some(body.id) {
        response.scroll_to_me(None);
    }
    if response.double_clicked() {
        actions.push(Action::FlyTo(body.id));
    } else if response.clicked() {
        actions.push(Action::Select(body.id));
    }
    response.on_hover_text(text!("bodies-hint"));
}
