//! Controls with accessible names: lists of pixel views, spinners.
//!
//! In: what a control edits, and its name. Out: the control on the screen, with the name for screen readers. Always: the tooltip of a list is its
//! accessible name. Not here: number fields (`number_field`).

use crate::scene::draw::PixelView;
use crate::view::language::translated_name;
use egui::{ComboBox, Response, Ui};

/// The translated name of a pixel view.
pub(crate) fn pixel_view_name(view: PixelView) -> &'static str {
    translated_name("pixels", view.name())
}

/// Shows a drop-down list of pixel views.
pub(crate) fn pixel_view_list(ui: &mut Ui, chosen: &mut PixelView, name: &str) -> Response {
    let list = ComboBox::from_id_salt(name).selected_text(pixel_view_name(*chosen)).width(150.0).show_ui(ui, |ui| {
        for view in PixelView::ALL {
            ui.selectable_value(chosen, view, pixel_view_name(view));
        }
    });
    list.response.on_hover_text(name).accessible_name(name)
}

/// Shows a spinner while a result is pending.
pub(crate) fn spinner(ui: &mut Ui, name: &str) -> Response {
    ui.spinner().accessible_name(name)
}
