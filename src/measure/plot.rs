//! The trade as a picture: for each choice its options by time and error.
//!
//! In: measured choices. Out: the same plot as SVG text or as pixels. Always: one panel a choice, both axes logarithmic, time as a ratio to the most accurate option,
//! error in the unit that the panel names; what no logarithm shows, an error of 0, lies on the panel's floor and says so. Options on the frontier are joined;
//! dominated ones are hollow.

use super::{ChoiceMeasure, OptionMeasure};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, FontTransform, register_font};
use std::error::Error;
use std::sync::OnceLock;

/// Of the whole plot, pixels.
pub const SIZE_PX: (u32, u32) = (1560, 1240);
/// Panels in a row.
const COLUMNS: usize = 4;
const FONT: &str = "sans-serif";
const INK: RGBColor = RGBColor(35, 35, 35);
const FRONTIER: RGBColor = RGBColor(0, 90, 160);
const DOMINATED: RGBColor = RGBColor(190, 70, 20);

/// The plot could not be made, in one line.
#[derive(Debug, thiserror::Error)]
#[error("the plot cannot be drawn: {0}")]
pub struct PlotError(String);

fn failed(e: impl Error) -> PlotError {
    PlotError(e.to_string())
}

/// The plot as SVG.
///
/// # Errors
/// What the plotting library refuses.
pub fn svg(choices: &[ChoiceMeasure]) -> Result<String, PlotError> {
    let mut text = String::new();
    draw(&SVGBackend::with_string(&mut text, SIZE_PX).into_drawing_area(), choices)?;
    Ok(text)
}

/// The plot as opaque pixels, rows from the top.
///
/// # Errors
/// What the plotting library refuses.
pub fn pixels(choices: &[ChoiceMeasure]) -> Result<Vec<[u8; 4]>, PlotError> {
    let mut rgb = vec![255; 3 * (SIZE_PX.0 * SIZE_PX.1) as usize];
    draw(&BitMapBackend::with_buffer(&mut rgb, SIZE_PX).into_drawing_area(), choices)?;
    Ok(rgb.chunks_exact(3).map(|p| [p[0], p[1], p[2], 255]).collect())
}

/// The fonts of bitmaps: the machine may have none.
fn provide_font() -> Result<(), PlotError> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let given = REGISTERED.get_or_init(|| register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT).is_ok());
    if *given { Ok(()) } else { Err(PlotError("the built-in font cannot be read".into())) }
}

fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, choices: &[ChoiceMeasure]) -> Result<(), PlotError>
where
    B::ErrorType: 'static,
{
    provide_font()?;
    area.fill(&WHITE).map_err(failed)?;
    let title = "Speed against accuracy: time over that of the most accurate option, and error (down and left is better)";
    let area = area.titled(title, (FONT, 26).into_font().color(&INK)).map_err(failed)?;
    let panels = area.split_evenly((choices.len().div_ceil(COLUMNS).max(1), COLUMNS));
    for (choice, panel) in choices.iter().zip(&panels) {
        draw_panel(panel, choice)?;
    }
    area.present().map_err(failed)
}

/// A range of a logarithmic axis around values above 0.
fn span(values: impl Iterator<Item = f64> + Clone, below: f64, above: f64) -> std::ops::Range<f64> {
    let (least, most) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(0.0, f64::max));
    if most > 0.0 { least * below..most * above } else { 0.1..10.0 }
}

fn draw_panel<B: DrawingBackend>(panel: &DrawingArea<B, Shift>, choice: &ChoiceMeasure) -> Result<(), PlotError>
where
    B::ErrorType: 'static,
{
    let options = &choice.options;
    let positive = options.iter().map(|o| o.weight.error).filter(|e| *e > 0.0);
    // Errors of 0 lie on the floor.
    let errors = span(positive, 0.2, 6.0);
    let floor = errors.start;
    let height = |o: &OptionMeasure| if o.weight.error > 0.0 { o.weight.error } else { floor };
    let times = span(options.iter().map(|o| o.weight.time.median), 0.5, 3.0);
    let mut chart = ChartBuilder::on(panel)
        .margin(10)
        .caption(format!("{} [{}]", choice.name, choice.unit.name()), (FONT, 22).into_font().color(&INK))
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(times.clone().log_scale(), errors.clone().log_scale())
        .map_err(failed)?;
    let label = || (FONT, 16).into_font().color(&INK);
    chart
        .configure_mesh()
        .x_desc("time ratio")
        .y_desc(format!("error, {}", choice.unit.name()))
        .axis_desc_style(label())
        .label_style(label())
        .x_labels(5)
        .y_labels(6)
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .light_line_style(WHITE)
        .draw()
        .map_err(failed)?;
    let mut frontier: Vec<_> = options.iter().filter(|o| !o.is_dominated).map(|o| (o.weight.time.median, height(o))).collect();
    frontier.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(frontier, FRONTIER.stroke_width(2))).map_err(failed)?;
    for option in options {
        let (x, y) = (option.weight.time.median, height(option));
        let colour = if option.is_dominated { DOMINATED } else { FRONTIER };
        let style = if option.is_dominated { colour.stroke_width(2) } else { colour.filled() };
        let ends = [(option.weight.time.low, y), (option.weight.time.high, y)];
        chart.draw_series([PathElement::new(ends.to_vec(), colour.stroke_width(2))]).map_err(failed)?;
        chart.draw_series([Circle::new((x, y), 5, style)]).map_err(failed)?;
        let zero = if option.weight.error > 0.0 { "" } else { " (0)" };
        // On the right half of a panel the name stands before its point.
        let is_right = (x / times.start).ln() > 0.55 * (times.end / times.start).ln();
        let is_tilted = option.name.len() > 40;
        let text = format!("{}{zero}", if is_tilted { &option.name[..40] } else { &option.name });
        let width = i32::try_from(8 * text.len()).unwrap_or(200);
        let offset = if is_right { (-width - 4, -22) } else { (7, -20) };
        let font = (FONT, 17).into_font().transform(FontTransform::None).color(&colour);
        chart.draw_series([EmptyElement::at((x, y)) + Text::new(text, offset, font)]).map_err(failed)?;
    }
    Ok(())
}

/// A number of an axis: powers of ten far from 1, plain digits near it.
fn short(value: f64) -> String {
    if (0.01..10_000.0).contains(&value) { format!("{}", (value * 1e4).round() / 1e4) } else { format!("{value:.0e}") }
}
