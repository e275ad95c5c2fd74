//! The tree of bodies.
//!
//! In: clicks. Out: actions. Always: the pressed row is the one that is selected, and nothing expands while a button is held. It moves only its own rows.

use super::Interface;
use crate::catalog::{BodyKind, NaifId};
use crate::view::app::viewer::{Action, Subject};
use crate::view::language::{body_name, text};
use egui::collapsing_header::CollapsingState;
use egui::{Id, ScrollArea, UiBuilder};

#[derive(Default)]
pub(crate) struct BodyBrowser {
    /// The selection for which the tree was last expanded.
    expanded_for: Option<NaifId>,
    /// The selection was made in the tree, so it need not scroll.
    clicked: Option<NaifId>,
    /// Scrolled to until its branch has expanded.
    shown: Option<NaifId>,
}

/// The Sun, its planets each with its moons, then the other bodies.
pub(crate) fn tree(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    let news = branch_to_expand(interface, ui);
    let before = actions.len();
    let mut is_opening = false;
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(0.0).show(ui, |ui| {
        let subjects = interface.viewer.subjects();
        let top = |s: &&Subject| s.kind != BodyKind::Moon;
        for body in subjects.iter().filter(top) {
            let moons: Vec<&Subject> = subjects.iter().filter(|s| s.kind == BodyKind::Moon && s.parent == Some(body.id)).collect();
            if moons.is_empty() {
                entry(interface, ui, body, actions);
                continue;
            }
            let id = ui.make_persistent_id(("moons of", body.id.0));
            let mut fold = CollapsingState::load_with_default_open(ui.ctx(), id, false);
            if news.is_some_and(|selected| selected == body.id || moons.iter().any(|m| m.id == selected)) {
                fold.set_open(true);
            }
            is_opening |= fold.is_open() && fold.openness(ui.ctx()) < 1.0;
            let is_open = fold.is_open();
            let (arrow, ..) = fold.show_header(ui, |ui| entry(interface, ui, body, actions)).body(|ui| {
                for moon in moons {
                    entry(interface, ui, moon, actions);
                }
            });
            // An arrow alone has no accessible name.
            let name = text!("bodies-moons-of", body = body_name(&body.name));
            arrow.widget_info(|| egui::WidgetInfo::selected(egui::Role::DisclosureTriangle, true, is_open, &name));
        }
    });
    if !is_opening {
        interface.browse.shown = None;
    }
    if let Some(Action::Select(id) | Action::FlyTo(id)) = actions[before..].last() {
        interface.browse.clicked = Some(*id);
    }
}

/// The body of a new selection whose branch must be expanded; once, so that the user can collapse it again. Between press and release
/// nothing expands: a selection made meanwhile is handled after it.
fn branch_to_expand(interface: &mut Interface, ui: &egui::Ui) -> Option<NaifId> {
    let selected = interface.viewer.selected;
    let browse = &mut interface.browse;
    if browse.expanded_for == Some(selected) {
        return None;
    }
    if ui.input(|i| i.pointer.any_down() || i.pointer.any_released()) {
        ui.ctx().request_repaint();
        return None;
    }
    browse.expanded_for = Some(selected);
    browse.shown = (browse.clicked.take() != Some(selected)).then_some(selected);
    Some(selected)
}

fn entry(interface: &Interface, ui: &mut egui::Ui, body: &Subject, actions: &mut Vec<Action>) {
    // The id of a row depends on its body, not on its position: otherwise rows that expand above it would move the press to another body.
    let row = UiBuilder::new().scope_id(Id::unique(("body in the list", body.id.0)));
    let is_selected = interface.viewer.selected == body.id;
    let response = ui.scope_builder(row, |ui| ui.selectable_label(is_selected, body_name(&body.name))).inner;
    if interface.browse.shown == Some(body.id) {
        response.scroll_to_me(None);
    }
    if response.double_clicked() {
        actions.push(Action::FlyTo(body.id));
    } else if response.clicked() {
        actions.push(Action::Select(body.id));
    }
    response.on_hover_text(text!("bodies-hint"));
}
