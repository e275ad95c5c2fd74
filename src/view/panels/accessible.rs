//! Accessible names of controls.
//!
//! In: a control and its description. Out: the control with the description as accessible name. Always: where the control also has a tooltip,
//! the tooltip is the same text.

use crate::scene::draw::PixelView;
use crate::view::language::named;
use crate::view::language::numbers::typed_number;
use egui::{ComboBox, DragValue, Response, Ui};

/// Shows a number field. `what`: its accessible name, without which a screen reader would read only the unit.
pub(crate) fn number(ui: &mut Ui, field: DragValue<'_>, what: &str) -> Response {
    ui.add(field.custom_parser(typed_number)).on_hover_text(what).accessible_name(what)
}

/// The translated name of a pixel view.
pub(crate) fn pixel_view_name(view: PixelView) -> &'static str {
    named("pixels", view.name())
}

/// Shows a drop-down list of pixel views.
pub(crate) fn pixel_view_list(ui: &mut Ui, chosen: &mut PixelView, what: &str) -> Response {
    let list = ComboBox::from_id_salt(what).selected_text(pixel_view_name(*chosen)).width(150.0).show_ui(ui, |ui| {
        for view in PixelView::ALL {
            ui.selectable_value(chosen, view, pixel_view_name(view));
        }
    });
    list.response.on_hover_text(what).accessible_name(what)
}

/// Shows a spinner while a result is pending.
pub(crate) fn spinner(ui: &mut Ui, what: &str) -> Response {
    ui.spinner().accessible_name(what)
}
