//! Sizes and distances to scale, in the Information panel: the selected body next to another, and the planets along a line from the Sun.
//!
//! In: radii, and distances at the displayed time. Out: two drawings, each with a sentence that says the same. Always: each drawing has one scale;
//! but in the first, no disc is drawn narrower or lower than `MIN_DIAMETER`, and in the second, bodies are dots of a fixed size.

use super::duration_text;
use crate::catalog::{BodyKind, Catalog, NaifId};
use crate::units::{KM_PER_AU, SPEED_OF_LIGHT_KM_S};
use crate::view::app::body_positions::{BodyPositions, SessionPositions};
use crate::view::app::viewer::SelectableBody;
use crate::view::language::numbers::grouped;
use crate::view::language::{body_name, decimal, text};
use crate::view::panels::Interface;
use crate::view::panels::theme::HIGHLIGHT_COLOUR;
use crate::view::worker::render_worker::RenderWorker;
use egui::{Align2, Color32, ComboBox, FontId, Pos2, Rect, Sense, Shape, Stroke, TextStyle, Ui, pos2, vec2};
use glam::DVec3;

/// Height of the drawing of sizes, points.
const SIZES_HEIGHT: f32 = 110.0;
/// Height of the drawing of distances, points.
const DISTANCES_HEIGHT: f32 = 44.0;
/// Smallest diameter of a drawn body, points.
const MIN_DIAMETER: f32 = 1.0;
/// Vertices of an ellipse.
const ELLIPSE_VERTICES: usize = 96;
/// Gap between the two discs, points.
const DISC_GAP: f32 = 10.0;
/// Smallest distance of a name from the left and right edges of its drawing, points.
const NAME_MARGIN: f32 = 2.0;
/// Smallest gap between two names, points.
const NAME_GAP: f32 = 4.0;
/// Colour of names and marks that are not highlighted, and of the disc of a body that the catalog lacks.
const OTHER_COLOUR: Color32 = Color32::from_gray(190);

/// The choice of the body with which the selected body is compared.
#[derive(Default)]
pub(crate) struct SizeComparison {
    /// `None`: the Earth, or the Moon if the Earth is selected.
    chosen: Option<NaifId>,
}

impl SizeComparison {
    /// The body with which the selected body is compared.
    fn other_body(&self, selected: NaifId) -> NaifId {
        let default_body = if selected == NaifId::EARTH { NaifId::MOON } else { NaifId::EARTH };
        self.chosen.filter(|chosen| *chosen != selected).unwrap_or(default_body)
    }
}

/// Shows this part of the Information panel.
pub(crate) fn panel(interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker) {
    let selected = interface.viewer.selected;
    let other = interface.information.comparison.other_body(selected);
    ui.strong(text!("sizes"));
    let viewer = &interface.viewer;
    let comparison = &mut interface.information.comparison;
    let list = ComboBox::from_id_salt("compare sizes").selected_text(viewer.name(other)).width(120.0).show_ui(ui, |ui| {
        for body in viewer.selectable_bodies().iter().filter(|b| b.id != selected) {
            ui.selectable_value(&mut comparison.chosen, Some(body.id), body_name(&body.name));
        }
    });
    list.response.on_hover_text(text!("sizes-hint")).accessible_name(text!("sizes-with"));
    let catalog = worker.session().catalog();
    if let (Some(a), Some(b)) = (viewer.selectable_body(selected), viewer.selectable_body(other)) {
        draw_sizes(ui, catalog, a, b);
        ui.label(size_text(a, b));
    }
    ui.separator();
    ui.strong(text!("distances"));
    let time = viewer.view.time();
    let positions = SessionPositions(worker.session());
    let distance_km = |id: NaifId| positions.geometric_vector_km(NaifId::SUN, id, time).map_or(0.0, DVec3::length);
    // For a selected moon, its planet is marked.
    let marked = catalog.planet_of(selected);
    let bodies = viewer.selectable_bodies().iter().filter(|s| s.kind == BodyKind::Planet || s.id == marked && s.id != NaifId::SUN);
    let plotted: Vec<PlottedBody<'_>> = bodies
        .map(|s| PlottedBody { name: body_name(&s.name), distance_au: distance_km(s.id) / KM_PER_AU, is_marked: s.id == marked })
        .collect();
    draw_distances(ui, &plotted);
    ui.label(distance_text(viewer.name(marked), distance_km(marked)));
}

/// A sentence about the wider body, such as `Saturn is 9.449 times as wide as Earth and has 764 times its volume.`
fn size_text(first: &SelectableBody, second: &SelectableBody) -> String {
    let ratio_text = |value: f64| if value >= 10.0 { grouped(value, 0) } else { decimal(value, 3) };
    let width_ratio = first.radii_km.x / second.radii_km.x;
    let volume_ratio = first.radii_km.element_product() / second.radii_km.element_product();
    if width_ratio >= 1.0 {
        text!(
            "size-sentence",
            larger = body_name(&first.name),
            width = ratio_text(width_ratio),
            smaller = body_name(&second.name),
            volume = ratio_text(volume_ratio)
        )
    } else {
        text!(
            "size-sentence",
            larger = body_name(&second.name),
            width = ratio_text(1.0 / width_ratio),
            smaller = body_name(&first.name),
            volume = ratio_text(1.0 / volume_ratio)
        )
    }
}

/// A sentence about the distance from the Sun and the light time; for the Sun itself, at 0 km, about the drawing.
fn distance_text(name: &str, distance_km: f64) -> String {
    match distance_km {
        0.0 => text!("distance-planets").into(),
        km => {
            let (au, duration) = (decimal(km / KM_PER_AU, 3), duration_text(km / SPEED_OF_LIGHT_KM_S));
            text!("distance-sentence", name = name, au = au, duration = duration)
        }
    }
}

/// Draws the background of a drawing and returns its area. `height`: points. `description`: accessible description of the drawing.
fn draw_background(ui: &mut Ui, height: f32, description: &str) -> Rect {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, description));
    ui.painter().rect_filled(rect, 4.0, Color32::BLACK);
    rect
}

/// The largest number of points per kilometre at which the discs of two bodies with semi-axes `a_km` and `b_km` fit side by side into an area of `size`
/// points (width, height).
fn fitting_scale(size: [f64; 2], a_km: DVec3, b_km: DVec3) -> f64 {
    let width_km = 2.0 * (a_km.x + b_km.x);
    let height_km = 2.0 * a_km.z.max(b_km.z);
    (size[0] / width_km).min(size[1] / height_km)
}

/// The x coordinate of the middle of a text of this width, points: as close to `x` as possible, but with the text between `left` and `right`. A text that
/// is too wide starts at `left`.
fn middle_within([left, right]: [f32; 2], x: f32, width: f32) -> f32 {
    x.min(right - 0.5 * width).max(left + 0.5 * width)
}

/// The middles of two names below their bodies. Each is given by the body's x coordinate and the name's width. Neither name crosses the edges of `area`
/// (left, right), and the second starts after the first, if both fit.
fn middles_of_two(area: [f32; 2], [(first_x, first_width), (second_x, second_width)]: [(f32, f32); 2]) -> [f32; 2] {
    let min_distance = 0.5 * (first_width + second_width) + NAME_GAP;
    let second_x = second_x.max(middle_within(area, first_x, first_width) + min_distance);
    let second_middle = middle_within(area, second_x, second_width);
    [middle_within(area, first_x.min(second_middle - min_distance), first_width), second_middle]
}

/// Draws two bodies next to each other.
fn draw_sizes(ui: &mut Ui, catalog: &Catalog, selected: &SelectableBody, other: &SelectableBody) {
    let rect = draw_background(ui, SIZES_HEIGHT, &text!("sizes-image", first = body_name(&selected.name), second = body_name(&other.name)));
    let inner = rect.shrink2(vec2(12.0, 16.0));
    let points_per_km =
        fitting_scale([f64::from(inner.width()) - f64::from(DISC_GAP), f64::from(inner.height()) - 8.0], selected.radii_km, other.radii_km);
    let font = TextStyle::Small.resolve(ui.style());
    let mut left = inner.left();
    let bodies = [(selected, HIGHLIGHT_COLOUR), (other, OTHER_COLOUR)];
    let names = bodies.map(|(body, colour)| {
        let [half_width, half_height] = [body.radii_km.x, body.radii_km.z].map(|km| ((km * points_per_km) as f32).max(0.5 * MIN_DIAMETER));
        let centre = pos2(left + half_width, inner.center().y);
        ui.painter().add(ellipse(centre, half_width, half_height, disc_colour(catalog, body.id)));
        left += 2.0 * half_width + DISC_GAP;
        let width = ui.painter().layout_no_wrap(body_name(&body.name).to_owned(), font.clone(), colour).size().x;
        (centre.x, width)
    });
    let middles = middles_of_two([rect.left() + NAME_MARGIN, rect.right() - NAME_MARGIN], names);
    for ((body, colour), middle) in bodies.into_iter().zip(middles) {
        let position = pos2(middle, rect.bottom() - 2.0);
        ui.painter().text(position, Align2::CENTER_BOTTOM, body_name(&body.name), font.clone(), colour);
    }
}

/// A filled ellipse with horizontal and vertical axes, points.
fn ellipse(centre: Pos2, half_width: f32, half_height: f32, fill: Color32) -> Shape {
    let vertex = |k: usize| {
        let (sin, cos) = (k as f32 / ELLIPSE_VERTICES as f32 * std::f32::consts::TAU).sin_cos();
        centre + vec2(half_width * cos, half_height * sin)
    };
    Shape::convex_polygon((0..ELLIPSE_VERTICES).map(vertex).collect(), fill, Stroke::NONE)
}

/// The mean colour of a body's disc, scaled so that its brightest channel is 1, and encoded with a gamma of 2.2.
fn disc_colour(catalog: &Catalog, id: NaifId) -> Color32 {
    let Some(body) = catalog.body(id) else { return OTHER_COLOUR };
    let peak = body.colour.max_element().max(1e-6);
    let [r, g, b] = (body.colour / peak).to_array().map(|c| (255.0 * c.clamp(0.0, 1.0).powf(1.0 / 2.2)) as u8);
    Color32::from_rgb(r, g, b)
}

/// A body on the line of distances from the Sun.
struct PlottedBody<'n> {
    name: &'n str,
    distance_au: f64,
    is_marked: bool,
}

/// The x coordinates of the middles of the labels along the line. `None`: a label is left out because it would be too close to another, or begin left of
/// `min_left` (a gap to the right of the Sun's disc). `labels`: for each label the x coordinate of its body, the label's width, and whether the body is
/// marked. The marked label must come first and is always shown; the others follow from left to right.
fn label_middles(area: [f32; 2], min_left: f32, labels: &[(f32, f32, bool)]) -> Vec<Option<f32>> {
    let mut last_end = min_left;
    // The left and right ends of the marked label.
    let mut marked: Option<(f32, f32)> = None;
    let middle_of = |&(x, width, is_marked): &(f32, f32, bool)| {
        let middle = middle_within(area, x, width);
        let (left, right) = (middle - 0.5 * width, middle + 0.5 * width);
        if is_marked {
            marked = Some((left, right));
        } else if left < last_end
            || marked.is_some_and(|(marked_left, marked_right)| left < marked_right + NAME_GAP && right > marked_left - NAME_GAP)
        {
            return None;
        } else {
            last_end = right + NAME_GAP;
        }
        Some(middle)
    };
    labels.iter().map(middle_of).collect()
}

/// Draws bodies along a line from the Sun.
fn draw_distances(ui: &mut Ui, bodies: &[PlottedBody<'_>]) {
    let farthest_au = bodies.iter().map(|b| b.distance_au).fold(1.0, f64::max);
    let description: Vec<String> = bodies.iter().map(|b| format!("{} {}", b.name, decimal(b.distance_au, 2))).collect();
    let rect = draw_background(ui, DISTANCES_HEIGHT, &text!("distances-image", list = description.join(", ")));
    let line_y = rect.top() + 14.0;
    let [sun_x, farthest_x] = [rect.left() + 10.0, rect.right() - 24.0];
    let x_of = |au: f64| sun_x + (farthest_x - sun_x) * (au / farthest_au) as f32;
    let painter = ui.painter().with_clip_rect(rect);
    painter.hline(sun_x..=farthest_x, line_y, Stroke::new(1.0, Color32::from_gray(90)));
    painter.circle_filled(pos2(sun_x, line_y), 4.0, Color32::from_rgb(255, 235, 170));
    let font: FontId = TextStyle::Small.resolve(ui.style());
    // The marked body is labelled first, so that its label is always shown.
    let mut order: Vec<&PlottedBody<'_>> = bodies.iter().collect();
    order.sort_by(|a, b| b.is_marked.cmp(&a.is_marked).then(a.distance_au.total_cmp(&b.distance_au)));
    let width_of = |name: &str| painter.layout_no_wrap(name.to_owned(), font.clone(), OTHER_COLOUR).size().x;
    let labels: Vec<(f32, f32, bool)> = order.iter().map(|body| (x_of(body.distance_au), width_of(body.name), body.is_marked)).collect();
    let middles = label_middles([rect.left() + NAME_MARGIN, rect.right() - NAME_MARGIN], sun_x + 6.0, &labels);
    for ((body, (x, _, is_marked)), middle) in order.iter().zip(labels).zip(middles) {
        let colour = if is_marked { HIGHLIGHT_COLOUR } else { OTHER_COLOUR };
        painter.circle_filled(pos2(x, line_y), 2.5, colour);
        if let Some(middle) = middle {
            painter.text(pos2(middle, rect.bottom() - 4.0), Align2::CENTER_BOTTOM, body.name, font.clone(), colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(name: &str, equatorial_km: f64, polar_km: f64) -> SelectableBody {
        SelectableBody {
            id: NaifId(1),
            name: name.into(),
            aliases: Vec::new(),
            kind: BodyKind::Planet,
            parent: None,
            radii_km: DVec3::new(equatorial_km, equatorial_km, polar_km),
        }
    }

    /// Volumes from NASA's planetary fact sheets: Saturn 82713e10 km³, the Earth 108.321e10 km³.
    #[test]
    fn sizes_match_the_fact_sheets() {
        let (saturn, earth) = (body("Saturn", 60_268.0, 54_364.0), body("Earth", 6378.137, 6356.752));
        let description = size_text(&saturn, &earth);
        assert_eq!(description, "Saturn is 9.449 times as wide as Earth and has 764 times its volume.");
        assert_eq!(size_text(&earth, &saturn), description, "the sentence is always about the wider body");
        assert!((82_713.0 / 108.321_f64 - 764.0).abs() < 1.0);
        assert!(distance_text("Earth", KM_PER_AU).contains("8.3 min"));
    }

    /// Whether a text with this middle and width is within the area.
    fn is_within([left, right]: [f32; 2], middle: f32, width: f32) -> bool {
        middle - 0.5 * width >= left - 1e-3 && middle + 0.5 * width <= right + 1e-3
    }

    #[test]
    fn two_names_neither_overlap_nor_cross_the_edges() {
        let area = [2.0, 298.0];
        // The body's x coordinate and the name's width. Cases: both bodies at the left edge, both at the right edge, a long name beside a short one, names far
        // apart.
        for [first, second] in
            [[(12.0, 60.0), (22.0, 40.0)], [(280.0, 60.0), (288.0, 90.0)], [(12.0, 140.0), (150.0, 30.0)], [(60.0, 30.0), (240.0, 30.0)]]
        {
            let ([a, b], (_, first_width), (_, second_width)) = (middles_of_two(area, [first, second]), first, second);
            assert!(is_within(area, a, first_width) && is_within(area, b, second_width), "{first:?} {second:?}: {a} {b}");
            assert!(a + 0.5 * first_width < b - 0.5 * second_width, "{first:?} {second:?}: {a} {b}");
        }
        assert_eq!(middles_of_two(area, [(60.0, 30.0), (240.0, 30.0)]), [60.0, 240.0], "each below its body");
        // A name that is wider than the drawing starts at its left edge.
        assert_eq!(middle_within([0.0, 100.0], 90.0, 140.0), 70.0);
    }

    #[test]
    fn labels_along_the_line_do_not_overlap() {
        let area = [2.0, 198.0];
        // The marked label is moved away from the right edge, over its neighbour's label.
        assert_eq!(
            label_middles(area, 10.0, &[(195.0, 60.0, true), (60.0, 40.0, false), (120.0, 40.0, false)]),
            [Some(168.0), Some(60.0), None]
        );
        // The label at the left edge is moved right, over the start of the next.
        assert_eq!(
            label_middles(area, 0.0, &[(5.0, 40.0, false), (44.0, 30.0, false), (80.0, 30.0, false)]),
            [Some(22.0), None, Some(80.0)]
        );
        // A label that starts left of `min_left` (16 here) is left out, unless it is marked.
        assert_eq!(label_middles(area, 16.0, &[(20.0, 30.0, false)]), [None::<f32>]);
        assert_eq!(label_middles(area, 16.0, &[(20.0, 30.0, true)]), [Some(20.0)]);
    }

    #[test]
    fn both_discs_fit_into_the_area() {
        for (a, b) in [(1.0, 1.0), (700_000.0, 1.0), (1.0, 9.4)] {
            let points_per_km = fitting_scale([300.0, 80.0], DVec3::splat(a), DVec3::splat(b));
            assert!(2.0 * (a + b) * points_per_km <= 300.0 + 1e-9 && 2.0 * a.max(b) * points_per_km <= 80.0 + 1e-9);
        }
    }
}
