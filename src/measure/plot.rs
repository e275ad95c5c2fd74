//! The plot of time against error, with one panel for each choice. A choice is a setting; its options are the values that were compared.
//!
//! In: measured choices. Out: the same plot as SVG text or as pixels. Always: both axes are logarithmic: the time as a ratio to the most
//! accurate option, the error in the unit that the panel names. An error of 0 is drawn at the panel's lower edge, an infinite one at its upper edge, and both
//! are labelled. Each option's label contains its time ratio. Options on the Pareto frontier are joined by a line; dominated options are hollow.

use super::{ChoiceMeasure, OptionMeasure};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::error::Error;
use std::sync::OnceLock;

/// Width and height of the entire plot, pixels.
pub(crate) const SIZE_PX: (u32, u32) = (1560, 1240);
/// Panels in a row.
const COLUMNS: usize = 4;
const FONT: &str = "sans-serif";
/// Colour of texts.
const INK: RGBColor = RGBColor(35, 35, 35);
/// Colour of options on the Pareto frontier.
const FRONTIER: RGBColor = RGBColor(0, 90, 160);
/// Colour of dominated options.
const DOMINATED: RGBColor = RGBColor(190, 70, 20);

/// The plot could not be drawn; the message is one line.
#[derive(Debug, thiserror::Error)]
#[error("the plot cannot be drawn: {0}")]
pub(crate) struct PlotError(String);

fn plot_error(e: impl Error) -> PlotError {
    PlotError(e.to_string())
}

/// The plot as SVG.
///
/// # Errors
/// An error of the plotting library.
pub(crate) fn svg(choices: &[ChoiceMeasure]) -> Result<String, PlotError> {
    let mut text = String::new();
    draw(&SVGBackend::with_string(&mut text, SIZE_PX).into_drawing_area(), choices)?;
    Ok(text)
}

/// The plot as opaque pixels, rows from the top.
///
/// # Errors
/// An error of the plotting library.
pub(crate) fn pixels(choices: &[ChoiceMeasure]) -> Result<Vec<[u8; 4]>, PlotError> {
    let (width, height) = SIZE_PX;
    let mut rgb = vec![255; 3 * (width * height) as usize];
    draw(&BitMapBackend::with_buffer(&mut rgb, SIZE_PX).into_drawing_area(), choices)?;
    Ok(rgb.chunks_exact(3).map(|p| [p[0], p[1], p[2], 255]).collect())
}

/// Registers the embedded font with the plotting library, because the system may have none.
fn register_embedded_font() -> Result<(), PlotError> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let is_registered = REGISTERED.get_or_init(|| register_font(FONT, FontStyle::Normal, epaint_default_fonts::HACK_REGULAR).is_ok());
    if *is_registered { Ok(()) } else { Err(PlotError("the built-in font cannot be read".into())) }
}

fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, choices: &[ChoiceMeasure]) -> Result<(), PlotError>
where
    B::ErrorType: 'static,
{
    register_embedded_font()?;
    area.fill(&WHITE).map_err(plot_error)?;
    let title = "Speed against accuracy: time over that of the most accurate option, and error (down and left is better)";
    let area = area.titled(title, (FONT, 26).into_font().color(&INK)).map_err(plot_error)?;
    let panels = area.split_evenly((choices.len().div_ceil(COLUMNS).max(1), COLUMNS));
    for (choice, panel) in choices.iter().zip(&panels) {
        draw_panel(panel, choice)?;
    }
    area.present().map_err(plot_error)
}

/// The range of a logarithmic axis for positive values: from the least times `low_factor` to the greatest times `high_factor`; 0.1 to 10 without values.
fn axis_range(values: impl Iterator<Item = f64> + Clone, low_factor: f64, high_factor: f64) -> std::ops::Range<f64> {
    let (least, greatest) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(0.0, f64::max));
    if greatest > 0.0 { least * low_factor..greatest * high_factor } else { 0.1..10.0 }
}

fn draw_panel<B: DrawingBackend>(panel: &DrawingArea<B, Shift>, choice: &ChoiceMeasure) -> Result<(), PlotError>
where
    B::ErrorType: 'static,
{
    let options = &choice.options;
    // A logarithmic axis has neither 0 nor infinity: such errors are drawn at its ends. The factors leave room for them and for labels.
    let error_range = axis_range(options.iter().map(|o| o.measurement.error).filter(|e| *e > 0.0 && e.is_finite()), 0.1, 8.0);
    let (lower_edge, upper_edge) = (error_range.start, error_range.end);
    let drawn_error = |o: &OptionMeasure| o.measurement.error.clamp(lower_edge, upper_edge);
    let time_range = axis_range(options.iter().map(|o| o.measurement.relative_time.median), 0.5, 3.0);
    let mut chart = ChartBuilder::on(panel)
        .margin(10)
        .caption(format!("{} [{}]", choice.name, choice.unit.name()), (FONT, 22).into_font().color(&INK))
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(time_range.clone().log_scale(), error_range.clone().log_scale())
        .map_err(plot_error)?;
    let label = || (FONT, 16).into_font().color(&INK);
    chart
        .configure_mesh()
        .x_desc("time ratio")
        .y_desc(format!("error, {}", choice.unit.name()))
        .axis_desc_style(label())
        .label_style(label())
        .x_labels(5)
        .y_labels(6)
        .x_label_formatter(&|v| axis_label(*v))
        .y_label_formatter(&|v| axis_label(*v))
        .light_line_style(WHITE)
        .draw()
        .map_err(plot_error)?;
    let mut frontier: Vec<_> =
        options.iter().filter(|o| !o.is_dominated).map(|o| (o.measurement.relative_time.median, drawn_error(o))).collect();
    frontier.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(frontier, FRONTIER.stroke_width(2))).map_err(plot_error)?;
    for option in options {
        let (x, y) = (option.measurement.relative_time.median, drawn_error(option));
        let colour = if option.is_dominated { DOMINATED } else { FRONTIER };
        let style = if option.is_dominated { colour.stroke_width(2) } else { colour.filled() };
        let quartile_bar = [(option.measurement.relative_time.low, y), (option.measurement.relative_time.high, y)];
        chart.draw_series([PathElement::new(quartile_bar.to_vec(), colour.stroke_width(2))]).map_err(plot_error)?;
        chart.draw_series([Circle::new((x, y), POINT_RADIUS_PX, style)]).map_err(plot_error)?;
    }
    let corners = (chart.backend_coord(&(time_range.start, error_range.start)), chart.backend_coord(&(time_range.end, error_range.end)));
    let points: Vec<_> = options.iter().map(|o| chart.backend_coord(&(o.measurement.relative_time.median, drawn_error(o)))).collect();
    let texts: Vec<String> = options
        .iter()
        .map(|o| {
            let error_off_axis = match o.measurement.error {
                0.0 => ", 0",
                f64::INFINITY => ", infinite",
                _ => "",
            };
            format!(
                "{} ({:.2}{error_off_axis})",
                o.name.chars().take(MAX_NAME_CHARS).collect::<String>(),
                o.measurement.relative_time.median
            )
        })
        .collect();
    for (k, offset) in label_offsets(&points, &texts, corners).into_iter().enumerate() {
        let colour = if options[k].is_dominated { DOMINATED } else { FRONTIER };
        let font = (FONT, LABEL_PX).into_font().color(&colour);
        let position = (options[k].measurement.relative_time.median, drawn_error(&options[k]));
        chart.draw_series([EmptyElement::at(position) + Text::new(texts[k].clone(), offset, font)]).map_err(plot_error)?;
    }
    Ok(())
}

/// Radius of the circle that marks an option, pixels.
const POINT_RADIUS_PX: i32 = 5;
/// Height of the labels, pixels.
const LABEL_PX: i32 = 15;
/// Horizontal distance of a label beside its point from the point's centre, pixels.
const LABEL_GAP_PX: i32 = 7;
/// Number of characters to which an option's name is cut.
const MAX_NAME_CHARS: usize = 26;

/// Offset of each label from its point, pixels: the first of several positions at which the label lies within the panel (given by its lower left and upper
/// right corner) and overlaps no other label and no point. If there is none, the label is above the point on the right.
fn label_offsets(points: &[(i32, i32)], texts: &[String], ((left, bottom), (right, top)): ((i32, i32), (i32, i32))) -> Vec<(i32, i32)> {
    /// Left, top, right, bottom.
    type Rect = (i32, i32, i32, i32);
    let overlaps = |a: &Rect, b: &Rect| a.0 < b.2 && b.0 < a.2 && a.1 < b.3 && b.1 < a.3;
    let mut occupied: Vec<Rect> =
        points.iter().map(|(x, y)| (x - POINT_RADIUS_PX, y - POINT_RADIUS_PX, x + POINT_RADIUS_PX, y + POINT_RADIUS_PX)).collect();
    let mut offsets = Vec::new();
    for (&(x, y), text) in points.iter().zip(texts) {
        // A character of the built-in font is 0.61 times as wide as high.
        let width = i32::try_from(text.chars().count()).unwrap_or(0) * LABEL_PX * 61 / 100;
        // Vertical offsets of a label's top from the point: rows of `LABEL_PX + 3` pixels, above it (negative, 2 pixels higher) and below it (4 pixels lower),
        // the nearest first.
        let rows = [-1, 0, -2, 1, -3, 2, -4, 3, -5, 4].map(|row| row * (LABEL_PX + 3) + if row < 0 { -2 } else { 4 });
        let positions = rows.into_iter().flat_map(|dy| [LABEL_GAP_PX, -width - LABEL_GAP_PX, -width / 2].map(|dx| (dx, dy)));
        let rect = |(dx, dy): (i32, i32)| (x + dx, y + dy, x + dx + width, y + dy + LABEL_PX);
        // A label may extend 8 pixels into the margin on the right.
        let is_inside = |r: &Rect| r.0 >= left && r.2 <= right.max(left) + 8 && r.1 >= top && r.3 <= bottom;
        let first_free =
            positions.clone().find(|offset| is_inside(&rect(*offset)) && !occupied.iter().any(|t| overlaps(t, &rect(*offset))));
        // The first position, if none is free.
        let offset = first_free.unwrap_or((LABEL_GAP_PX, -LABEL_PX - 5));
        occupied.push(rect(offset));
        offsets.push(offset);
    }
    offsets
}

/// The text of an axis label: from 0.01 to 10000 plain digits, otherwise scientific notation with one digit.
fn axis_label(value: f64) -> String {
    if (0.01..10_000.0).contains(&value) { format!("{}", (value * 1e4).round() / 1e4) } else { format!("{value:.0e}") }
}
