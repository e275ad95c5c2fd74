//! The Probe page: the named values (values bound to a name in the module's source) that each draw computes at one pixel, in f32 and in f64.
//!
//! In: the displayed view, the picked pixel. Out: egui shapes; a pixel picked on this page. Always: both precisions are
//! computed for the same view and pixel; nothing is computed before the user picks a pixel.

use super::queries::ModuleFailure;
use super::values::brief_number;
use super::{Inspected, ShaderPanel, show_failure};
use crate::probe::pixel::{PixelDraw, PixelReport, inspect_pixel};
use crate::probe::{ProbeError, Prober};
use crate::render::plan::SamplingQuality;
use crate::scene::request::ViewRequest;
use crate::session::Session;
use crate::view::error_texts::error_text;
use crate::view::language::dates::instant_text;
use crate::view::language::{body_name, signed, text, translated_name};
use crate::view::panels::number_field::{self, NumberKind};
use crate::view::panels::theme::{MIN_LIST_HEIGHT, SMALL_TEXT_POINTS};
use crate::view::panels::{Interface, accessible};
use crate::view::worker::render_worker::{Pending, ask};
use crate::view::worker::session_inputs::SessionInputs;
use egui::{Align2, FontId, RichText, ScrollArea, Sense, TextEdit, vec2};

/// The reports of one pixel computed in f32 and in f64.
type BothPrecisions = [PixelReport; 2];

/// State of the Probe page.
#[derive(Default)]
pub(crate) struct ProbePage {
    /// Only values whose name contains this text are shown.
    filter: String,
    /// A pixel that the user has just picked on this page, by its coordinates or by the button for the centre. The panel passes it on to
    /// `Viewport::picked_px`.
    pub newly_picked_px: Option<[u32; 2]>,
    /// Index of the chosen draw among those at the pixel.
    draw_index: usize,
    /// What the answer to the last query depends on: the pixel, the view, and the state of the session.
    requested: Option<([u32; 2], ViewRequest, SessionInputs)>,
    pending: Option<Pending<Result<BothPrecisions, ProbeError>>>,
    /// The last answer.
    answer: Option<Result<BothPrecisions, ProbeError>>,
}

/// Inspects a pixel in f32, then in f64.
fn inspect_in_both_precisions(session: &Session, request: &ViewRequest, pixel: [u32; 2]) -> Result<BothPrecisions, ProbeError> {
    let inspect = |in_f64: bool| {
        let renderer = session.renderer_in(in_f64)?;
        inspect_pixel(&Prober { session, renderer: &renderer }, request, SamplingQuality::of(request.quality), pixel)
    };
    let (report_f32, report_f64) = (inspect(false)?, inspect(true)?);
    Ok([report_f32, report_f64])
}

/// Shows the page. `failure`: why there is no module of the displayed key.
pub(crate) fn show(
    panel: &mut ShaderPanel,
    ui: &mut egui::Ui,
    inspected: &Inspected<'_>,
    failure: Option<&ModuleFailure>,
    interface: &Interface,
) {
    let page = &mut panel.probe;
    if let Some(answer) = page.pending.as_ref().and_then(Pending::take) {
        page.pending = None;
        page.answer = Some(answer);
    }
    // A pixel that was picked in a larger window may lie outside the image.
    let [width, height] = interface.viewport.size_px;
    let Some(pixel) = interface.viewport.picked_px.filter(|[x, y]| *x < width && *y < height) else {
        ui.label(text!("probe-begin"));
        if ui.button(text!("probe-centre")).on_hover_text(text!("probe-centre-hint")).clicked() {
            page.newly_picked_px = Some([width / 2, height / 2]);
        }
        return;
    };
    page.start_query(inspected, interface, pixel);
    ui.horizontal_wrapped(|ui| {
        ui.strong(text!("probe-pixel"));
        let [mut x, mut y] = pixel;
        let x_field = number_field::show(ui, &mut x, NumberKind::Whole, 0..=width - 1, text!("probe-x"), |field| field.prefix("x "));
        let y_field = number_field::show(ui, &mut y, NumberKind::Whole, 0..=height - 1, text!("probe-y"), |field| field.prefix("y "));
        if x_field.changed() || y_field.changed() {
            page.newly_picked_px = Some([x, y]);
        }
        // The time is here because the line of the radiance, with it, would be wider than the panel.
        if let Some(Ok([report, _])) = &page.answer {
            ui.label(instant_text(report.time));
        }
        if page.pending.is_some() && page.answer.is_some() {
            accessible::spinner(ui, text!("probe-another"));
        }
    });
    // The field is above all that depends on the answer, which a running clock renews: the pixel may be beside the body then.
    let has_values = page.answer.as_ref().and_then(|answer| answer.as_ref().ok()).is_some_and(|[report, _]| !report.draws.is_empty());
    let copies = ui
        .horizontal(|ui| {
            let label = ui.label(text!("probe-filter"));
            let field = TextEdit::singleline(&mut page.filter).id_salt("filter of the probe").desired_width(160.0);
            ui.add(field).labelled_by(label.id).on_hover_text(text!("probe-filter-hint"));
            let copy = egui::Button::new(text!("shader-copy")).small();
            ui.add_enabled(has_values, copy).on_hover_text(text!("probe-copy-hint")).clicked()
        })
        .inner;
    let Some(answer) = &page.answer else {
        accessible::spinner(ui, text!("probe-coming"));
        return;
    };
    let [report_f32, report_f64] = match (answer, failure) {
        (Ok(both), _) => both,
        (Err(_), Some(failure)) => return show_failure(ui, failure),
        (Err(why), None) => return drop(ui.colored_label(ui.visuals().warn_fg_color, error_text(why))),
    };
    let radiance = report_f32.radiance.map(brief_number).join(", ");
    ui.label(text!("probe-radiance", level = radiance, stops = signed(report_f32.exposure_stops, 2)));
    if report_f32.draws.is_empty() {
        ui.label(text!("probe-empty"));
        return;
    }
    let mut chosen_index = page.draw_index.min(report_f32.draws.len() - 1);
    ui.horizontal_wrapped(|ui| {
        for (index, draw) in report_f32.draws.iter().enumerate() {
            let name = format!("{} {}", body_name(&draw.body_name), translated_name("part", draw.part.name()));
            if ui.selectable_label(index == chosen_index, name).on_hover_text(text!("probe-draw-hint")).clicked() {
                chosen_index = index;
            }
        }
    });
    page.draw_index = chosen_index;
    let draw_f32 = &report_f32.draws[chosen_index];
    ui.add(egui::Label::new(RichText::new(draw_f32.module.to_string()).monospace().size(SMALL_TEXT_POINTS)).wrap());
    if let Some([graphic_latitude, east_longitude]) = draw_f32.ground_deg {
        ui.label(text!("probe-ground", latitude = signed(graphic_latitude, 4), longitude = signed(east_longitude, 4)));
    }
    // At an edge, a draw may cover the pixel in only one of the precisions.
    let draw_f64 = report_f64.draws.iter().find(|d| d.body == draw_f32.body && d.part == draw_f32.part);
    let rows = rows(draw_f32, draw_f64);
    if copies {
        ui.ctx().copy_text(rows.iter().map(|row| format!("{}\n", row.text())).collect());
    }
    table(ui, &rows, &page.filter);
}

impl ProbePage {
    /// Starts a query about a pixel of the image, unless the last query was the same, the view is moving, or another query is running.
    fn start_query(&mut self, inspected: &Inspected<'_>, interface: &Interface, pixel: [u32; 2]) {
        let [width, height] = interface.viewport.size_px;
        // The displayed image may have been drawn for another size of the viewport, or in another quality than the view's.
        let request = ViewRequest { width, height, quality: interface.viewer.view.quality, ..inspected.rendered.job.request.clone() };
        let query = (pixel, request, SessionInputs::of(inspected.worker.session()));
        if self.requested.as_ref() == Some(&query) || self.pending.is_some() || interface.viewer.is_animating() {
            return;
        }
        let (_, request, _) = &query;
        let request = request.clone();
        self.requested = Some(query);
        let pending = ask(inspected.worker, move |session| inspect_in_both_precisions(session, &request, pixel));
        // The worker of the tests has answered already.
        match pending.take() {
            Some(answer) => self.answer = Some(answer),
            None => self.pending = Some(pending),
        }
    }
}

/// A number in both precisions: a named value, or one component of it.
struct Row {
    name: String,
    in_f32: f64,
    /// `None` if there is no such value in f64, as at an edge where the draw covers the pixel only in f32.
    in_f64: Option<f64>,
}

impl Row {
    /// The name, both values and their absolute difference, in columns.
    fn text(&self) -> String {
        self.text_with_name(&self.name)
    }

    /// As [`Self::text`], with a long name shortened in its middle, so that the numbers stay in their columns.
    fn shown_text(&self) -> String {
        self.text_with_name(&shortened(&self.name, NAME_CHARS))
    }

    fn text_with_name(&self, name: &str) -> String {
        let number =
            |v: f64, decimals: usize| if v.is_nan() { text!("probe-not-evaluated").to_owned() } else { format!("{v:.decimals$e}") };
        let in_f64 = self.in_f64.map_or(text!("probe-no-value").to_owned(), |v| number(v, 9));
        let difference = self.in_f64.map(|in_f64| (self.in_f32 - in_f64).abs()).filter(|d| d.is_finite());
        let difference = difference.map_or(String::new(), |d| if d == 0.0 { "0".to_owned() } else { format!("{d:.1e}") });
        columns(name, &number(self.in_f32, 7), &in_f64, &difference)
    }
}

/// Number of characters of the column of names.
const NAME_CHARS: usize = 34;

/// A name of at most `max_chars` characters: of a longer one, its beginning and its end.
fn shortened(name: &str, max_chars: usize) -> String {
    let count = name.chars().count();
    if count <= max_chars {
        return name.to_owned();
    }
    let (start, end) = (max_chars / 2, max_chars - max_chars / 2 - 1);
    name.chars().take(start).chain(['…']).chain(name.chars().skip(count - end)).collect()
}

/// A line of the table. The columns have room for the longest numbers: seven decimals in f32, nine in f64.
fn columns(name: &str, in_f32: &str, in_f64: &str, difference: &str) -> String {
    format!("{name:<NAME_CHARS$} {in_f32:>14} {in_f64:>17} {difference:>10}")
}

/// Every value of a draw at the pixel, with one row for each component of a vector. The draw's colour and coverage come first.
fn rows(draw_f32: &PixelDraw, draw_f64: Option<&PixelDraw>) -> Vec<Row> {
    let mut rows = Vec::new();
    let number_f64 =
        |name: &str, index: usize| draw_f64.and_then(|draw| draw.values.named.iter().find(|v| v.name == name)?.numbers.get(index).copied());
    let channels = [text!("colour-red"), text!("colour-green"), text!("colour-blue"), text!("colour-coverage")];
    for (index, channel) in channels.iter().enumerate() {
        rows.push(Row {
            name: text!("probe-colour", c = channel),
            in_f32: draw_f32.values.colour[index],
            in_f64: draw_f64.map(|draw| draw.values.colour[index]),
        });
    }
    for value in &draw_f32.values.named {
        for (index, in_f32) in value.numbers.iter().enumerate() {
            let component = ["x", "y", "z", "w"].get(index).filter(|_| value.numbers.len() > 1);
            let name = component.map_or(value.name.clone(), |component| format!("{}.{component}", value.name));
            rows.push(Row { name, in_f32: *in_f32, in_f64: number_f64(&value.name, index) });
        }
    }
    rows
}

fn row_text(text: String) -> RichText {
    RichText::new(text).monospace().size(SMALL_TEXT_POINTS)
}

/// Height of a row, points.
fn row_height(ui: &egui::Ui) -> f32 {
    ui.ctx().fonts_mut(|fonts| fonts.row_height(&FontId::monospace(SMALL_TEXT_POINTS)))
}

/// Shows the rows whose name contains the filter text, below headings that scroll sideways with their columns, but not down with the rows.
fn table(ui: &mut egui::Ui, rows: &[Row], filter: &str) {
    let filter = filter.trim().to_lowercase();
    let matching: Vec<&Row> = rows.iter().filter(|r| r.name.to_lowercase().contains(&filter)).collect();
    let headings = columns(&text!("probe-count", count = matching.len()), "f32", "f64", text!("probe-difference"));
    let height = row_height(ui);
    let (place, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &headings));
    ui.spacing_mut().item_spacing.y = 1.0;
    let area = ScrollArea::both().auto_shrink(false).min_scrolled_height(MIN_LIST_HEIGHT);
    let list = area.show_rows(ui, height, matching.len(), |ui, range| {
        for row in matching.get(range).unwrap_or_default() {
            let response = ui.add(egui::Label::new(row_text(row.shown_text())).extend());
            if row.name.chars().count() > NAME_CHARS {
                response.on_hover_text(&row.name).accessible_name(row.text());
            }
        }
    });
    let corner = place.min - vec2(list.state.clamped_offset().x, 0.0);
    let painter = ui.painter().with_clip_rect(place.intersect(ui.clip_rect()));
    painter.text(corner, Align2::LEFT_TOP, headings, FontId::monospace(SMALL_TEXT_POINTS), ui.visuals().strong_text_color());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of a value with a long name once stood to the right of those of the others, partly outside the panel.
    #[test]
    fn numbers_are_in_their_columns_whatever_the_length_of_the_name() {
        let row = |name: &str| Row { name: name.to_owned(), in_f32: 0.25, in_f64: Some(0.5) };
        let long = row("surface_hit/distance_from_limb/one_minus_q_sq");
        let widths = [row("albedo"), row("surface_hit/distance_from_limb"), row(&long.name)].map(|row| row.shown_text().chars().count());
        assert!(widths.iter().all(|width| *width == widths[0]), "{widths:?}");
        let shown = long.shown_text();
        assert!(shown.starts_with("surface_hit/dista…") && shown.contains("one_minus_q_sq "), "{shown}");
        assert!(long.text().starts_with(&long.name), "a copy has the whole name");
    }

    /// With another height, rows would be missing at the end of the list, or a gap would follow them.
    #[test]
    fn a_row_is_as_high_as_its_text() {
        let mut heights = [0.0; 2];
        {
            let _harness = egui_kittest::Harness::new_ui(|ui| {
                heights = [ui.add(egui::Label::new(row_text("colour red".to_owned()))).rect.height(), row_height(ui)];
            });
        }
        assert!(heights[0] > 5.0 && (heights[0] - heights[1]).abs() < 0.75, "{heights:?}");
    }
}
