//! The Probe page: the named values that each draw computes at one pixel, in f32 and in f64.
//!
//! Always: both precisions are computed for the same view and pixel; nothing is computed before the user picks a pixel.

use super::values::number_text;
use super::{Inspected, ShaderPanel};
use crate::probe::pixel::{PixelDraw, PixelReport, inspect_pixel};
use crate::probe::{ProbeError, Prober};
use crate::render::plan::SamplingQuality;
use crate::scene::request::ViewRequest;
use crate::session::Session;
use crate::view::error_texts::error_text;
use crate::view::language::dates::instant_text;
use crate::view::language::{body_name, named, signed, text};
use crate::view::panels::theme::SMALL;
use crate::view::panels::{Interface, accessible};
use crate::view::worker::drawn_with::DrawnWith;
use crate::view::worker::render_worker::{Pending, ask};
use egui::{RichText, ScrollArea, TextEdit, TextStyle};

/// The reports of one pixel computed in f32 and in f64.
type BothPrecisions = [PixelReport; 2];

#[derive(Default)]
pub(crate) struct ProbePage {
    /// Only values whose name contains this text are shown.
    filter: String,
    /// The pixel chosen on this page, by its coordinates or by the button for the centre, until the viewport takes it.
    pub typed_px: Option<[u32; 2]>,
    /// Index of the chosen draw among those at the pixel.
    draw: usize,
    /// The pixel and view of the last query, and what it was computed with.
    requested: Option<([u32; 2], ViewRequest, DrawnWith)>,
    pending: Option<Pending<Result<BothPrecisions, ProbeError>>>,
    /// The last answer.
    answer: Option<Result<BothPrecisions, ProbeError>>,
}

/// Inspects a pixel in f32, then in f64.
fn in_both_precisions(session: &Session, request: &ViewRequest, pixel: [u32; 2]) -> Result<BothPrecisions, ProbeError> {
    let inspect = |in_f64: bool| {
        let renderer = session.renderer_in(in_f64)?;
        inspect_pixel(&Prober { session, renderer: &renderer }, request, SamplingQuality::of(request.quality), pixel)
    };
    Ok([inspect(false)?, inspect(true)?])
}

pub(crate) fn show(panel: &mut ShaderPanel, ui: &mut egui::Ui, inspected: &Inspected<'_>, interface: &Interface) {
    let page = &mut panel.probe;
    if let Some(done) = page.pending.as_ref().and_then(Pending::take) {
        page.pending = None;
        page.answer = Some(done);
    }
    let Some(pixel) = interface.viewport.picked_px else {
        ui.label(text!("probe-begin"));
        if ui.button(text!("probe-centre")).on_hover_text(text!("probe-centre-hint")).clicked() {
            page.typed_px = Some(interface.viewport.size_px.map(|side| side / 2));
        }
        return;
    };
    page.start_query(inspected, interface, pixel);
    let Some(answer) = &page.answer else {
        accessible::spinner(ui, text!("probe-coming"));
        return;
    };
    let [single, double] = match answer {
        Ok(both) => both,
        Err(why) => return drop(ui.colored_label(ui.visuals().warn_fg_color, error_text(why))),
    };
    let radiance = single.radiance.map(number_text).join(", ");
    ui.horizontal(|ui| {
        ui.strong(text!("probe-pixel"));
        let [mut x, mut y] = pixel;
        let last_px = interface.viewport.size_px.map(|side| side.saturating_sub(1));
        let x_field = accessible::number(ui, egui::DragValue::new(&mut x).prefix("x ").range(0..=last_px[0]), text!("probe-x"));
        let y_field = accessible::number(ui, egui::DragValue::new(&mut y).prefix("y ").range(0..=last_px[1]), text!("probe-y"));
        if x_field.changed() || y_field.changed() {
            page.typed_px = Some([x, y]);
        }
        if page.pending.is_some() {
            accessible::spinner(ui, text!("probe-another"));
        }
    });
    ui.label(text!("probe-radiance", level = radiance, stops = signed(single.exposure_stops, 2), time = instant_text(single.time)));
    if single.draws.is_empty() {
        ui.label(text!("probe-empty"));
        return;
    }
    let mut chosen = page.draw.min(single.draws.len() - 1);
    ui.horizontal_wrapped(|ui| {
        for (index, draw) in single.draws.iter().enumerate() {
            let name = format!("{} {}", body_name(&draw.name), named("part", draw.part.name()));
            if ui.selectable_label(index == chosen, name).on_hover_text(text!("probe-draw-hint")).clicked() {
                chosen = index;
            }
        }
    });
    page.draw = chosen;
    let single_draw = &single.draws[chosen];
    ui.add(egui::Label::new(RichText::new(single_draw.module.to_string()).monospace().size(SMALL)).wrap());
    if let Some([latitude, longitude]) = single_draw.ground_deg {
        ui.label(text!("probe-ground", latitude = signed(latitude, 4), longitude = signed(longitude, 4)));
    }
    // At an edge, the draw may cover the pixel in one precision and not in the other.
    let double_draw = double.draws.iter().find(|d| d.body == single_draw.body && d.part == single_draw.part);
    ui.horizontal(|ui| {
        let label = ui.label(text!("probe-filter"));
        ui.add(TextEdit::singleline(&mut page.filter).desired_width(160.0)).labelled_by(label.id).on_hover_text(text!("probe-filter-hint"));
        if ui.small_button(text!("shader-copy")).on_hover_text(text!("probe-copy-hint")).clicked() {
            ui.ctx().copy_text(rows(single_draw, double_draw).iter().map(|r| format!("{}\n", r.text())).collect());
        }
    });
    table(ui, &rows(single_draw, double_draw), &page.filter);
}

impl ProbePage {
    /// Starts a query if the pixel, the view or the fragments have changed, the view is at rest and no other query is running.
    fn start_query(&mut self, inspected: &Inspected<'_>, interface: &Interface, pixel: [u32; 2]) {
        let [width, height] = interface.viewport.size_px;
        let request = ViewRequest { width, height, quality: interface.viewer.view.quality, ..inspected.rendered.job.request.clone() };
        let query = (pixel, request, DrawnWith::now(inspected.worker.session()));
        if self.requested.as_ref() == Some(&query)
            || self.pending.is_some()
            || interface.viewer.is_animating()
            || pixel[0] >= width
            || pixel[1] >= height
        {
            return;
        }
        let request = query.1.clone();
        self.requested = Some(query);
        let pending = ask(inspected.worker, move |session| in_both_precisions(session, &request, pixel));
        // The worker that tests use has answered already.
        match pending.take() {
            Some(done) => self.answer = Some(done),
            None => self.pending = Some(pending),
        }
    }
}

/// A named value in both precisions.
struct Row {
    name: String,
    single: f64,
    double: Option<f64>,
}

impl Row {
    /// The name, both values and their absolute difference, in columns.
    fn text(&self) -> String {
        let number = |v: f64, digits: usize| if v.is_nan() { text!("probe-not-evaluated").to_owned() } else { format!("{v:.digits$e}") };
        let double = self.double.map_or(text!("probe-no-value").to_owned(), |v| number(v, 9));
        let difference = self.double.map(|double| (self.single - double).abs()).filter(|d| d.is_finite());
        let difference = difference.map_or(String::new(), |d| if d == 0.0 { "0".to_owned() } else { format!("{d:.1e}") });
        format!("{:<34} {:>14} {double:>17} {difference:>10}", self.name, number(self.single, 7))
    }
}

/// Every value of a draw at the pixel, with one row for each component of a vector.
fn rows(single_draw: &PixelDraw, double_draw: Option<&PixelDraw>) -> Vec<Row> {
    let mut all = Vec::new();
    let double_number = |name: &str, component: usize| {
        double_draw.and_then(|draw| draw.values.values.iter().find(|v| v.name == name)?.numbers.get(component).copied())
    };
    let channels = [text!("colour-red"), text!("colour-green"), text!("colour-blue"), text!("colour-coverage")];
    for (index, channel) in channels.iter().enumerate() {
        all.push(Row {
            name: text!("probe-colour", c = channel),
            single: single_draw.values.colour[index],
            double: double_draw.map(|draw| draw.values.colour[index]),
        });
    }
    for value in &single_draw.values.values {
        for (index, single) in value.numbers.iter().enumerate() {
            let component = ["x", "y", "z", "w"].get(index).filter(|_| value.numbers.len() > 1);
            let name = component.map_or(value.name.clone(), |component| format!("{}.{component}", value.name));
            all.push(Row { name, single: *single, double: double_number(&value.name, index) });
        }
    }
    all
}

/// Shows the rows whose name contains the filter text.
fn table(ui: &mut egui::Ui, rows: &[Row], filter: &str) {
    let shown: Vec<&Row> = rows.iter().filter(|r| r.name.contains(filter.trim())).collect();
    let small = |text: String| RichText::new(text).monospace().size(SMALL);
    ui.label(
        small(format!("{:<34} {:>14} {:>17} {:>10}", text!("probe-count", count = shown.len()), "f32", "f64", text!("probe-difference")))
            .strong(),
    );
    ui.spacing_mut().item_spacing.y = 1.0;
    let height = ui.text_style_height(&TextStyle::Monospace);
    ScrollArea::both().auto_shrink(false).show_rows(ui, height, shown.len(), |ui, range| {
        for row in shown.get(range).unwrap_or_default() {
            ui.add(egui::Label::new(small(row.text())).extend());
        }
    });
}
