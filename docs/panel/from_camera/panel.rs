//! The Sample panel: the moons of the target's planet as the camera sees them.
//!
//! In: the displayed image, the target. Out: a table that the user sorts; a click on a moon's name flies to the moon. Always: all values are those of the
//! displayed image.

use super::Interface;
use super::information::scaled_angle_text;
use super::table::{SortOrder, SortValue, aligned, headings, row_button};
use crate::scene::BodyReport;
use crate::view::app::viewer::Action;
use crate::view::language::{body_name, signed, text};
use crate::view::worker::render_worker::RenderWorker;
use egui::{Grid, ScrollArea, Ui};

/// Index of the column by which the table is sorted at first.
const MAGNITUDE: usize = 2;

/// State of the Sample panel.
pub(crate) struct SamplePanel {
    order: SortOrder,
}

impl Default for SamplePanel {
    fn default() -> Self {
        Self { order: SortOrder::by(MAGNITUDE) }
    }
}

/// The phase angle. NaN if the ephemeris cannot place the moon, or if the camera is at its centre.
fn phase_angle_deg(moon: &BodyReport) -> f64 {
    if moon.has_direction() { moon.phase_angle_deg } else { f64::NAN }
}

/// The value by which a column is sorted; the columns are in the order of their titles.
fn sort_value(moon: &BodyReport, column: usize) -> SortValue {
    match column {
        0 => SortValue::Text(body_name(&moon.name).to_owned()),
        1 => SortValue::Number(phase_angle_deg(moon)),
        _ => SortValue::Number(moon.magnitude.unwrap_or(f64::NAN)),
    }
}

/// Shows the panel.
pub(crate) fn panel(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    let (catalog, target) = (worker.session().catalog(), interface.viewer.view.target);
    // After a click the target is a moon of the same planet, so that the list stays.
    let planet = catalog.planet_of(target);
    ui.strong(text!("bodies-moons-of", body = interface.viewer.name(planet)));
    let Some(rendered) = interface.shown() else {
        ui.weak(text!("computing"));
        return;
    };
    let moons: Vec<&BodyReport> = catalog.moons_of(planet).filter_map(|moon| rendered.scene.body(moon.id)).collect();
    if moons.is_empty() {
        ui.weak(text!("sample-none"));
        return;
    }
    // A copy, because `moons` borrows the interface.
    let mut order = interface.sample.order;
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        Grid::new("sample").num_columns(3).striped(true).show(ui, |ui| {
            headings(ui, &mut order, &[text!("sample-moon"), text!("fact-phase-angle"), text!("fact-magnitude")]);
            ui.end_row();
            let rows = order.sorted(moons, |moon, column| sort_value(moon, column));
            let phase_angles = aligned(rows.iter().map(|moon| {
                let angle_deg = phase_angle_deg(moon);
                if angle_deg.is_nan() { "-".into() } else { scaled_angle_text(angle_deg) }
            }));
            let magnitudes = aligned(rows.iter().map(|moon| moon.magnitude.map_or("-".into(), |magnitude| signed(magnitude, 2))));
            for ((moon, phase_angle), magnitude) in rows.into_iter().zip(phase_angles).zip(magnitudes) {
                let name = body_name(&moon.name);
                let button = row_button(ui, ("moon of the sample panel", moon.id.0), moon.id == target, name);
                if button.on_hover_text(text!("sample-fly-hint", name = name)).clicked() {
                    actions.push(Action::FlyTo(moon.id));
                }
                ui.monospace(phase_angle);
                ui.monospace(magnitude);
                ui.end_row();
            }
        });
    });
    interface.sample.order = order;
}
