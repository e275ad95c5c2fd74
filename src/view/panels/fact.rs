//! One fact in a grid of two columns: what it is, and its value in letters of one width.

pub(super) fn line(ui: &mut egui::Ui, what: &str, value: impl Into<String>) {
    ui.label(what);
    ui.add(egui::Label::new(egui::RichText::new(value.into()).monospace()).wrap());
    ui.end_row();
}
