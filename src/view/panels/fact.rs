//! A row of a two-column grid of facts: a label, and a value in a monospaced font. Also numbers with thousands separators.

pub(super) use crate::view::language::numbers::grouped;

/// Adds one row to the grid.
pub(super) fn line(ui: &mut egui::Ui, what: &str, value: impl Into<String>) {
    ui.label(what);
    ui.add(egui::Label::new(egui::RichText::new(value.into()).monospace()).wrap());
    ui.end_row();
}
