//! Names of controls for those who cannot see them.
//!
//! In: a control and what it is, in words. Out: the control, which shows the words to the mouse and tells them to a screen reader. Always: both hear
//! the same.

use egui::{DragValue, Response, Ui};

/// A field for a number. Its own name would be its unit.
pub fn number(ui: &mut Ui, field: DragValue<'_>, what: &str) -> Response {
    ui.add(field).on_hover_text(what).accessible_name(what)
}

/// Something is on its way.
pub fn coming(ui: &mut Ui, what: &str) -> Response {
    ui.spinner().accessible_name(what)
}
