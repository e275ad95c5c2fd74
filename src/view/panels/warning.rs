//! A dialog with an error that occurred before the window opened.
//!
//! In: the error's text. Out: the dialog, which stays until the user closes it by its button or by Escape.

use super::Interface;
use crate::view::language::text;
use egui::accesskit::Live;
use egui::{Align2, Context, Label, Window};

/// Largest width of the text, points.
const MAX_TEXT_WIDTH: f32 = 460.0;

/// Shows the dialog, if there is an error that the user has not closed.
pub(crate) fn show(interface: &mut Interface, ctx: &Context) {
    let Some(warning) = &interface.warning else { return };
    let window = Window::new(text!("warning-title")).collapsible(false).resizable(false);
    let shown = window.anchor(Align2::CENTER_TOP, [0.0, 60.0]).show(ctx, |ui| {
        ui.set_max_width(MAX_TEXT_WIDTH);
        let message = ui.add(Label::new(warning).wrap());
        ui.ctx().accesskit_node_builder(message.id, |node| node.set_live(Live::Assertive));
        ui.weak(text!("warning-default"));
        let close = ui.button(text!("warning-close")).on_hover_text(text!("warning-close-hint"));
        if ui.memory(|memory| memory.focused().is_none()) {
            close.request_focus();
        }
        close.clicked()
    });
    if shown.and_then(|window| window.inner) == Some(true) {
        interface.warning = None;
    }
}
