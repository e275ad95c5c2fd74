//! Accessible names of controls.
//!
//! In: a control and its description. Out: the control with the description as tooltip and accessible name. Always: both are
//! the same.

use crate::scene::draw::PixelView;
use crate::view::language::named;
use crate::view::language::numbers::typed_number;
use egui::{ComboBox, DragValue, Response, Ui};

/// A number field. Without a name, a screen reader would only read its unit.
pub(crate) fn number(ui: &mut Ui, field: DragValue<'_>, what: &str) -> Response {
    ui.add(field.custom_parser(typed_number)).on_hover_text(what).accessible_name(what)
}

/// The name of a pixel view in the window.
pub(crate) fn pixel_view(view: PixelView) -> &'static str {
    named("pixels", view.name())
}

/// A list of pixel views.
pub(crate) fn pixel_views(ui: &mut Ui, chosen: &mut PixelView, what: &str) -> Response {
    let list = ComboBox::from_id_salt(what).selected_text(pixel_view(*chosen)).width(150.0).show_ui(ui, |ui| {
        for view in PixelView::ALL {
            ui.selectable_value(chosen, view, pixel_view(view));
        }
    });
    list.response.on_hover_text(what).accessible_name(what)
}

/// A spinner for something pending.
pub(crate) fn coming(ui: &mut Ui, what: &str) -> Response {
    ui.spinner().accessible_name(what)
}
