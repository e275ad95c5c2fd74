//! The Moments panel: well-known moments, tours, and *What to see now*.

use super::share::dialog::{self, FileField};
use super::{Interface, now, tour};
use crate::catalog::moments::KINDS;
use crate::view::app::moment_view::view_of_moment;
use crate::view::app::places::SessionPositions;
use crate::view::app::viewer::Action;
use crate::view::worker::render_worker::RenderWorker;
use egui::ScrollArea;

#[derive(Default)]
pub(crate) struct MomentsPanel {
    /// Filter for names.
    filter: String,
}

pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ui.add(egui::TextEdit::singleline(&mut interface.moments.filter).hint_text("Filter"))
        .on_hover_text("Show moments whose name contains this text");
    let filter = interface.moments.filter.to_lowercase();
    let catalog = worker.session().catalog();
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        if filter.is_empty() {
            ui.strong("What to see now");
            ui.horizontal_wrapped(|ui| now::row(interface, ui, worker, actions));
            tours(interface, ui, worker, actions);
        }
        for kind in KINDS {
            let of_kind: Vec<_> = catalog.moments().iter().filter(|m| m.kind == kind && m.name.to_lowercase().contains(&filter)).collect();
            if of_kind.is_empty() {
                continue;
            }
            ui.add_space(6.0);
            ui.strong(title_case(kind));
            for moment in of_kind {
                let hover = format!("{}\n{}\nSource: {}", moment.about, moment.time.to_utc_iso(), moment.source);
                if ui.button(&moment.name).on_hover_text(hover).clicked() {
                    match view_of_moment(moment, catalog, &SessionPositions(worker.session()), &interface.viewer.view) {
                        Some(view) => actions.push(Action::Show(Box::new(view))),
                        None => interface.message = format!("{}: outside the range of the ephemeris", moment.name),
                    }
                }
                ui.weak(format!("{} · {}", moment.time.to_utc_iso().get(..10).unwrap_or_default(), moment.about));
            }
        }
    });
}

/// Built-in tours, and a field for tour files.
fn tours(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ui.add_space(6.0);
    ui.strong("Tours");
    for (name, about, text) in orrery_catalogs::TOURS {
        if ui.button(*name).on_hover_text(*about).clicked() {
            tour::start(interface, worker.session(), text, actions);
        }
        ui.weak(*about);
    }
    ui.horizontal(|ui| {
        let field = egui::TextEdit::singleline(&mut interface.tour.file).hint_text("tour.json").desired_width(140.0);
        ui.add(field).on_hover_text("Tour file (JSON); `orrery render --help` describes its fields").accessible_name("Tour file");
        dialog::button(interface, ui, FileField::Tour);
        if ui.button("Open tour").on_hover_text("Play the tour of the file").clicked() {
            tour::open(interface, worker.session(), actions);
        }
    });
}

fn title_case(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().collect::<String>() + letters.as_str())
}
