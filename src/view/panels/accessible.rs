//! Names of controls for those who cannot see them.
//!
//! In: a control and what it is, in words. Out: the control, which shows the words to the mouse and tells them to a screen reader. Always: both hear
//! the same.

use crate::scene::draw::PixelView;
use egui::{ComboBox, DragValue, Response, Ui};

/// A field for a number. Its own name would be its unit.
pub fn number(ui: &mut Ui, field: DragValue<'_>, what: &str) -> Response {
    ui.add(field).on_hover_text(what).accessible_name(what)
}

/// What a pixel view is called in the window.
pub fn pixel_view(view: PixelView) -> &'static str {
    match view {
        PixelView::Final => "final image",
        PixelView::Uv => "texture coordinates",
        PixelView::OpticalDepth => "optical depth",
        other => other.name(),
    }
}

/// A list to choose a pixel view from.
pub fn pixel_views(ui: &mut Ui, chosen: &mut PixelView, what: &str) -> Response {
    let list = ComboBox::from_id_salt(what).selected_text(pixel_view(*chosen)).width(150.0).show_ui(ui, |ui| {
        for view in PixelView::ALL {
            ui.selectable_value(chosen, view, pixel_view(view));
        }
    });
    list.response.on_hover_text(what).accessible_name(what)
}

/// Something is on its way.
pub fn coming(ui: &mut Ui, what: &str) -> Response {
    ui.spinner().accessible_name(what)
}
