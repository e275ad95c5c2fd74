//! The Moments panel: *What to see now*, presets (ready-made views), tours, and the catalog's moments by kind.
//!
//! In: the catalog, clicks. Out: actions that show a view; a started tour.

use super::share::dialog::{self, FileField};
use super::share::is_entered;
use super::theme::MIN_LIST_HEIGHT;
use super::{Interface, MAX_ECHO_CHARS, tour, what_to_see_now};
use crate::catalog::moments::{KINDS, Moment};
use crate::view::app::body_positions::SessionPositions;
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::moment_view::view_of_moment;
use crate::view::app::preset_changes::PresetChanges;
use crate::view::app::presets::Preset;
use crate::view::app::viewer::Action;
use crate::view::language::dates::{day_text, second_text};
use crate::view::language::{catalog_entry_text, catalog_text, text, translated_name};
use crate::view::worker::render_worker::RenderWorker;
use crate::wording::echo_within;
use egui::ScrollArea;

/// State of the Moments panel.
#[derive(Default)]
pub(crate) struct MomentsPanel {
    /// Only moments whose name contains this text are shown.
    filter: String,
}

/// Shows the panel. With a filter text, it shows only moments.
pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ui.add(egui::TextEdit::singleline(&mut interface.moments.filter).hint_text(text!("moments-filter")))
        .on_hover_text(text!("moments-filter-hint"));
    let filter = interface.moments.filter.trim().to_lowercase();
    // The filter applies to the translated name and to the name in the catalog.
    let matches_filter = |moment: &Moment| {
        [catalog_text("moment", &moment.name), (&moment.name).into()].iter().any(|name| name.to_lowercase().contains(&filter))
    };
    let catalog = worker.session().catalog();
    let zone = interface.settings.time_zone;
    let has_matches = catalog.moments().iter().any(matches_filter);
    ScrollArea::vertical().auto_shrink(false).min_scrolled_height(MIN_LIST_HEIGHT).show(ui, |ui| {
        if filter.is_empty() {
            ui.strong(text!("now"));
            ui.horizontal_wrapped(|ui| what_to_see_now::thumbnail_row(interface, ui, worker, actions));
            presets(interface, ui, worker, actions);
            tours(interface, ui, worker, actions);
        }
        if has_matches {
            // The days below have no label of their own. A tooltip has the time, with the offset of local time at that date.
            ui.add_space(6.0);
            ui.weak(match zone {
                ShownTimeZone::Utc => text!("moments-days-utc"),
                ShownTimeZone::Local => text!("moments-days-local"),
            });
        } else if !filter.is_empty() {
            ui.weak(text!("search-nothing", typed = echo_within(interface.moments.filter.trim(), MAX_ECHO_CHARS)));
        }
        for kind in KINDS {
            let moments_of_kind: Vec<_> = catalog.moments().iter().filter(|m| m.kind == kind && matches_filter(m)).collect();
            if moments_of_kind.is_empty() {
                continue;
            }
            ui.add_space(6.0);
            ui.strong(translated_name("moment-kind", kind));
            for moment in moments_of_kind {
                let about = catalog_entry_text("moment", &moment.name, "about", &moment.about);
                let hover = text!("moments-hint", about = about, time = second_text(moment.time, zone), source = moment.source);
                if ui.button(catalog_text("moment", &moment.name)).on_hover_text(hover).clicked() {
                    match view_of_moment(moment, catalog, &SessionPositions(worker.session()), &interface.viewer.base_view()) {
                        Some(view) => actions.push(Action::Show(Box::new(view))),
                        None => interface.refuse_view(text!("outside-ephemeris", name = catalog_text("moment", &moment.name))),
                    }
                }
                ui.weak(text!("moments-line", day = day_text(moment.time, zone), about = about));
            }
        }
    });
}

/// Shows a button and a description for each preset.
fn presets(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ui.add_space(6.0);
    ui.strong(text!("presets"));
    for preset in Preset::ALL {
        if ui.button(preset.name()).on_hover_text(preset.about()).clicked() {
            open_preset(interface, worker, preset, actions);
        }
        ui.weak(preset.about());
    }
}

/// Shows a preset's view. The view is at the current time; only the view of tonight's sky is at the next time at which the sky is dark. From then on, time
/// runs at the preset's rate, if the preset has one. The viewer records in which settings the preset's view differs from the base view, so that later views do
/// not inherit these differences.
pub(crate) fn open_preset(interface: &mut Interface, worker: &dyn RenderWorker, preset: Preset, actions: &mut Vec<Action>) {
    let (now, observer_place) = (interface.viewer.now(), interface.information.observer_place);
    let base_view = interface.viewer.base_view();
    match preset.view(&SessionPositions(worker.session()), now, observer_place, &base_view) {
        Some(view) => {
            let changes = PresetChanges::between(&base_view, &view);
            actions.push(Action::ShowPreset(Box::new(view), changes));
            actions.extend(preset.rate().map(Action::RunAt));
        }
        None => interface.refuse_view(text!("outside-ephemeris", name = preset.name())),
    }
}

/// Shows the built-in tours, and a field for tour files.
fn tours(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ui.add_space(6.0);
    ui.strong(text!("tours"));
    for (name, about, json) in orrery_catalogs::TOURS {
        let about = catalog_entry_text("tour", name, "about", about);
        if ui.button(catalog_text("tour", name)).on_hover_text(about.as_ref()).clicked() {
            tour::start(interface, worker.session(), json, actions);
        }
        ui.weak(about);
    }
    ui.horizontal(|ui| {
        let field = egui::TextEdit::singleline(&mut interface.tour.file_name).hint_text("tour.json").desired_width(140.0);
        let response = ui.add(field).on_hover_text(text!("tours-file-hint")).accessible_name(text!("tours-file"));
        let enter_pressed = is_entered(&response, &interface.tour.file_name);
        dialog::button(interface, ui, FileField::Tour);
        if ui.button(text!("tours-open")).on_hover_text(text!("tours-open-hint")).clicked() || enter_pressed {
            tour::open(interface, worker.session(), actions);
        }
    });
}
