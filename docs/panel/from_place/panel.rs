//! The Sample panel: all bodies as seen from the Earth's centre.
//!
//! In: the displayed time, the unit of lengths. Out: a table that the user sorts; the query that computes its rows.

use super::Interface;
use super::information::unit_row;
use super::table::{SortOrder, SortValue, aligned, headings};
use crate::catalog::NaifId;
use crate::scene::request::Position;
use crate::scene::{BodyReport, SceneError, bodies_seen_from};
use crate::session::Session;
use crate::view::error_texts::error_text;
use crate::view::language::{body_name, signed, text};
use crate::view::worker::latest_answer::LatestAnswer;
use crate::view::worker::render_worker::RenderWorker;
use egui::{Grid, ScrollArea, Ui};

/// State of the Sample panel.
#[derive(Default)]
pub(crate) struct SamplePanel {
    order: SortOrder,
    /// For whole minutes since J2000, TDB: a running clock must not start a query in each frame.
    answer: LatestAnswer<i64, Result<Vec<BodyReport>, SceneError>>,
}

/// The value by which a column is sorted; the columns are in the order of their titles.
fn sort_value(body: &BodyReport, column: usize) -> SortValue {
    match column {
        0 => SortValue::Text(body_name(&body.name).to_owned()),
        1 => SortValue::Number(body.distance_km),
        _ => SortValue::Number(body.magnitude.unwrap_or(f64::NAN)),
    }
}

/// Shows the panel.
pub(crate) fn panel(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker) {
    unit_row(ui, &mut interface.information.unit);
    let (unit, time) = (interface.information.unit, interface.viewer.view.time());
    let minutes = (time.tdb_seconds_past_j2000() / 60.0).floor() as i64;
    let query = move |session: &Session| bodies_seen_from(session.catalog(), session.ephemeris(), Position::Centre(NaifId::EARTH), time);
    // Two borrows of the panel's state: a heading changes the order while the rows are borrowed from the answer.
    let SamplePanel { order, answer } = &mut interface.sample;
    let bodies = match answer.update(worker, minutes, query) {
        Some((_, Ok(bodies))) => bodies,
        Some((_, Err(why))) => {
            ui.label(error_text(why));
            return;
        }
        None => {
            ui.weak(text!("computing"));
            return;
        }
    };
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        Grid::new("sample").num_columns(3).striped(true).show(ui, |ui| {
            headings(ui, order, &[text!("sample-body"), text!("fact-distance"), text!("fact-magnitude")]);
            ui.end_row();
            let rows = order.sorted(bodies, |body, column| sort_value(body, column));
            let distances = aligned(rows.iter().map(|body| {
                let is_placed = body.distance_km.is_finite();
                if is_placed { unit.format_length(body.distance_km, body.placement.radii_km.x) } else { "-".into() }
            }));
            let magnitudes = aligned(rows.iter().map(|body| body.magnitude.map_or("-".into(), |magnitude| signed(magnitude, 2))));
            for ((body, distance), magnitude) in rows.into_iter().zip(distances).zip(magnitudes) {
                ui.label(body_name(&body.name));
                ui.monospace(distance);
                ui.monospace(magnitude);
                ui.end_row();
            }
        });
    });
}
