//! The Key page: the value of each dimension of the key, and the effect of changing the key.

use super::descriptions::{is_switch, meaning, value_text};
use super::{Inspected, ShaderPanel};
use crate::scene::draw::DrawFeatures;
use crate::shader::key::{DIMENSIONS, Dimension, ShaderKey, reductions};
use crate::view::language::text;
use crate::view::panels::theme::SMALL;
use egui::{ComboBox, Grid, RichText, ScrollArea, TextEdit};

#[derive(Default)]
pub(crate) struct KeyPage {
    typed: String,
    /// The error in the typed key.
    error: String,
}

pub(crate) fn show(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>) {
    let (Some(drawn), Some(key)) = (inspected.drawn, inspected.key()) else {
        ui.label(text!("key-none"));
        return;
    };
    let base = inspected.draw.map_or(*drawn.features(), |d| d.features);
    let mut edited = panel.edited.unwrap_or(base);
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        super::change::summary(panel, ui, inspected);
        key_field(panel, ui, &mut edited);
        dimensions(ui, &mut edited, drawn.features(), key.features());
        ui.separator();
        super::change::details(panel, ui, inspected);
    });
    // The key counts as edited only if its features differ from those of the draw.
    let is_unchanged = edited == base || (panel.edited.is_none() && edited == *drawn.features());
    panel.edited = if is_unchanged { None } else { Some(edited) };
}

/// Shows a field for the text of a key.
fn key_field(panel: &mut ShaderPanel, ui: &mut egui::Ui, edited: &mut DrawFeatures) {
    let page = &mut panel.key;
    ui.horizontal(|ui| {
        let label = ui.label(text!("key-another"));
        let field = TextEdit::singleline(&mut page.typed).hint_text("lambert.albedo.sun1.ellipsoid").desired_width(f32::INFINITY);
        let response = ui.add(field).labelled_by(label.id).on_hover_text(text!("key-another-hint"));
        if response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter)) {
            match page.typed.trim().parse::<ShaderKey>() {
                Ok(key) => {
                    *edited = *key.features();
                    page.error.clear();
                }
                Err(e) => page.error = e.to_string(),
            }
        }
    });
    if !page.error.is_empty() {
        ui.colored_label(ui.visuals().warn_fg_color, &page.error);
    }
}

/// Shows a control and a description for each dimension.
fn dimensions(ui: &mut egui::Ui, edited: &mut DrawFeatures, drawn: &DrawFeatures, shown: &DrawFeatures) {
    // If several rules remove the value of a dimension, the first rule is shown as the reason.
    let rules = reductions(edited);
    let because = |d: &Dimension| rules.iter().find(|r| r.dimension == d.name).map(|r| r.because);
    let width = ui.available_width();
    Grid::new("dimensions").num_columns(3).striped(true).spacing([8.0, 3.0]).show(ui, |ui| {
        let mut part = None;
        for d in DIMENSIONS {
            let first = part != Some(d.part);
            part = Some(d.part);
            let value = (d.get)(edited);
            let effective = (d.get)(shown);
            let changed = effective != (d.get)(drawn);
            let name = if first { RichText::new(d.name) } else { RichText::new(format!("  {}", d.name)) };
            let name = if changed { name.strong().color(ui.visuals().warn_fg_color) } else { name };
            let label = ui.label(name).on_hover_text(text!("key-part", part = d.part.name()));
            control(ui, d, value, edited, label.id);
            let (words, weak) = match because(d).filter(|_| value != effective) {
                Some(why) => (text!("key-no-effect", why = why), true),
                None => (meaning(d, effective).to_owned(), effective == 0 && is_switch(d)),
            };
            let text = RichText::new(words).size(SMALL);
            let label = egui::Label::new(if weak { text.weak() } else { text }).wrap();
            ui.scope(|ui| {
                ui.set_max_width((width - 285.0).max(120.0));
                ui.add(label);
            });
            ui.end_row();
        }
    });
}

/// Shows a checkbox or a list for a dimension, with an accessible name.
fn control(ui: &mut egui::Ui, d: &Dimension, value: usize, edited: &mut DrawFeatures, label: egui::Id) {
    if is_switch(d) {
        let mut on = value == 1;
        let word = if on { text!("key-on") } else { text!("key-off") };
        if ui.checkbox(&mut on, word).labelled_by(label).on_hover_text(text!("key-switch", dimension = d.name)).changed() {
            (d.set)(edited, usize::from(on));
        }
        return;
    }
    let list = ComboBox::from_id_salt(d.name).selected_text(value_text(d, value)).width(165.0).show_ui(ui, |ui| {
        for v in 0..d.texts.len() {
            if ui.selectable_label(v == value, value_text(d, v)).on_hover_text(meaning(d, v)).clicked() {
                (d.set)(edited, v);
            }
        }
    });
    list.response.labelled_by(label).on_hover_text(text!("key-choose", dimension = d.name));
}
