//! A row of a two-column grid of facts.
//!
//! In: a label and a value. Out: the row, with the value in a monospaced font; long values wrap.

/// Adds one row to a grid of two columns. `ui`: the one that the grid passes to its content.
pub(super) fn row(ui: &mut egui::Ui, label: &str, value: impl Into<String>) {
    ui.label(label);
    ui.add(egui::Label::new(egui::RichText::new(value.into()).monospace()).wrap());
    ui.end_row();
}
