//! The Key page: the value of each dimension (independent choice) of the displayed key, controls that change the key, and what a change makes
//! different.
//!
//! In: the drawn features, a typed key, changed controls. Out: egui shapes; the features changed by hand. Always: a value without effect stays chosen,
//! with the reason beside it, although the key omits it.

use super::descriptions::{is_switch, meaning, value_text};
use super::queries::ModuleFailure;
use super::{Inspected, ShaderPanel, show_failure};
use crate::scene::draw::DrawFeatures;
use crate::shader::key::{DIMENSIONS, Dimension, ShaderKey, reductions};
use crate::view::error_texts::error_text;
use crate::view::language::text;
use crate::view::panels::theme::{MIN_LIST_HEIGHT, SMALL_TEXT_POINTS};
use egui::{ComboBox, Grid, RichText, ScrollArea, TextEdit};

/// Width that the column of descriptions leaves for the columns of names and controls, points.
const CONTROLS_WIDTH: f32 = 285.0;

/// State of the Key page.
#[derive(Default)]
pub(crate) struct KeyPage {
    /// The text in the key field.
    typed: String,
    /// The error in the last key that was entered, until the text changes; empty if there is none.
    error: String,
}

impl KeyPage {
    /// Drops the error, whose text is in the language of the window at the time of the error.
    pub(crate) fn forget_failure(&mut self) {
        self.error.clear();
    }
}

/// Shows the page, and stores the features that the user changes. `failure`: why there is no module of the displayed key.
pub(crate) fn show(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>, failure: Option<&ModuleFailure>) {
    let (Some(drawn_key), Some(key)) = (inspected.drawn_key, inspected.key()) else {
        ui.label(text!("key-none"));
        if let Some(failure) = failure {
            show_failure(ui, failure);
        }
        return;
    };
    let drawn_features = inspected.draw.map_or(*drawn_key.features(), |draw| draw.features);
    let mut edited = panel.edited.unwrap_or(drawn_features);
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(MIN_LIST_HEIGHT).show(ui, |ui| {
        if let Some(failure) = failure {
            show_failure(ui, failure);
        }
        super::key_comparison::summary(panel, ui, inspected, failure.is_some());
        key_field(panel, ui, &mut edited);
        dimensions(ui, &mut edited, drawn_key.features(), key.features());
        ui.separator();
        super::key_comparison::details(panel, ui, inspected);
    });
    // Features equal to those of the draw do not count as edited. Nor do those of the drawn key, which result if it is typed: they lack the values without
    // effect, but name the same module.
    let is_unchanged = edited == drawn_features || (panel.edited.is_none() && edited == *drawn_key.features());
    panel.edited = if is_unchanged { None } else { Some(edited) };
}

/// Shows a field for the text of a key, and the error in an entered key. A valid key replaces `edited`.
fn key_field(panel: &mut ShaderPanel, ui: &mut egui::Ui, edited: &mut DrawFeatures) {
    let page = &mut panel.key;
    ui.horizontal(|ui| {
        let label = ui.label(text!("key-another"));
        let field = TextEdit::singleline(&mut page.typed).hint_text("lambert.albedo.sun1.ellipsoid").desired_width(f32::INFINITY);
        // Its own id, because the lines above come and go with answers to queries. By egui's number of the control it would then lose the focus.
        let response = ui.add(field.id_salt("another key")).labelled_by(label.id).on_hover_text(text!("key-another-hint"));
        if response.changed() {
            page.error.clear();
        }
        if response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter)) {
            match page.typed.trim().parse::<ShaderKey>() {
                Ok(key) => {
                    *edited = *key.features();
                    page.error.clear();
                }
                Err(e) => page.error = error_text(&e),
            }
        }
    });
    if !page.error.is_empty() {
        ui.colored_label(ui.visuals().warn_fg_color, &page.error);
    }
}

/// Shows a control and a description for each dimension. `edited` may have values without effect; `drawn` and `displayed`, the features of the drawn
/// key and of the displayed key, are canonical.
fn dimensions(ui: &mut egui::Ui, edited: &mut DrawFeatures, drawn: &DrawFeatures, displayed: &DrawFeatures) {
    // The rules that leave values without effect out of the key. If several concern one dimension, the first is shown as the reason.
    let rules = reductions(edited);
    let reason_without_effect = |dimension: &Dimension| rules.iter().find(|r| r.dimension == dimension.name).map(|r| r.because);
    let available_width = ui.available_width();
    Grid::new("dimensions").num_columns(3).striped(true).spacing([8.0, 3.0]).show(ui, |ui| {
        let mut last_part = None;
        for dimension in DIMENSIONS {
            let is_first_of_part = last_part != Some(dimension.part);
            last_part = Some(dimension.part);
            let value = (dimension.get)(edited);
            let effective_value = (dimension.get)(displayed);
            let is_changed = effective_value != (dimension.get)(drawn);
            let name = if is_first_of_part { RichText::new(dimension.name) } else { RichText::new(format!("  {}", dimension.name)) };
            let name = if is_changed { name.strong().color(ui.visuals().warn_fg_color) } else { name };
            let label = ui.label(name).on_hover_text(text!("key-part", part = dimension.part.name()));
            control(ui, dimension, value, edited, label.id);
            let (description, is_weak) = match reason_without_effect(dimension).filter(|_| value != effective_value) {
                Some(why) => (text!("key-no-effect", why = why), true),
                None => (meaning(dimension, effective_value).to_owned(), effective_value == 0 && is_switch(dimension)),
            };
            let text = RichText::new(description).size(SMALL_TEXT_POINTS);
            let label = egui::Label::new(if is_weak { text.weak() } else { text }).wrap();
            ui.scope(|ui| {
                ui.set_max_width((available_width - CONTROLS_WIDTH).max(120.0));
                ui.add(label);
            });
            ui.end_row();
        }
    });
}

/// Shows a checkbox or a list for a dimension. `value`: index of its value in `edited`. `label_id`: the label that is the control's accessible name.
fn control(ui: &mut egui::Ui, dimension: &Dimension, value: usize, edited: &mut DrawFeatures, label_id: egui::Id) {
    if is_switch(dimension) {
        let mut is_on = value == 1;
        let word = if is_on { text!("key-on") } else { text!("key-off") };
        if ui.checkbox(&mut is_on, word).labelled_by(label_id).on_hover_text(text!("key-switch", dimension = dimension.name)).changed() {
            (dimension.set)(edited, usize::from(is_on));
        }
        return;
    }
    let list = ComboBox::from_id_salt(dimension.name).selected_text(value_text(dimension, value)).width(165.0).show_ui(ui, |ui| {
        for choice in 0..dimension.texts.len() {
            let label = value_text(dimension, choice);
            if ui.selectable_label(choice == value, label).on_hover_text(meaning(dimension, choice)).clicked() {
                (dimension.set)(edited, choice);
            }
        }
    });
    list.response.labelled_by(label_id).on_hover_text(text!("key-choose", dimension = dimension.name));
}
