//! All lines on the ground of one body: grid, terminator, eclipse shadows, the user's data.
//!
//! In: the requested layers, and a body. Out: line segments, labels and decisions. A body too small for lines has no segments; the
//! decisions give the reason.

use crate::catalog::{DataLayer, NaifId};
use crate::message::reason;
use crate::scene::annotation::body_lines::GroundLineBuilder;
use crate::scene::annotation::sky_lines::AnnotationLines;
use crate::scene::annotation::{data_lines, eclipse_lines};
use crate::scene::camera::Camera;
use crate::scene::decision::Decision;
use crate::scene::placed::PlacedBody;
use crate::scene::request::layers::Layers;
use crate::scene::resources::Context;
use std::sync::Arc;

/// Smallest diameter in pixels at which lines are drawn on a body.
const MIN_DIAMETER_PX: f64 = 16.0;

/// Whether the user's data are requested and have lines on a body.
fn has_data_lines(layers: Layers, body: Option<NaifId>, data: &[Arc<DataLayer>]) -> bool {
    layers.data && body.is_some_and(|id| data.iter().any(|l| l.body == Some(id) && !l.lines.is_empty()))
}

/// The layers with lines on the ground of a body: for each, whether its lines are requested, and its name. `data`: the user's data.
pub(crate) fn requested(layers: Layers, body: Option<NaifId>, data: &[Arc<DataLayer>]) -> [(bool, &'static str); 4] {
    let has_data_lines = has_data_lines(layers, body, data);
    [(layers.grid_body, "grid-body"), (layers.terminator, "terminator"), (layers.eclipse_path, "eclipse-path"), (has_data_lines, "data")]
}

/// The lines on the ground of a body. If `body` is `None`, the decisions report that there is no target.
pub(crate) fn ground_lines(
    context: Context<'_>,
    camera: &Camera,
    body: Option<&PlacedBody<'_>>,
    data: &[Arc<DataLayer>],
) -> AnnotationLines {
    let layers = context.request.layers;
    let diameter_px = body.map_or(0.0, |p| 2.0 * (p.placement.radii_km.x / p.distance_km).min(1.0).asin().tan() / camera.pixel_tangent());
    let Some(placed) = body.filter(|p| diameter_px >= MIN_DIAMETER_PX && !p.placement.camera_is_inside()) else {
        let reason = || match body {
            None => reason!("lines-no-target"),
            Some(_) => reason!("lines-small", size = format_args!("{diameter_px:.1}"), threshold = MIN_DIAMETER_PX),
        };
        let left_out = |(_, layer): (bool, &'static str)| Decision { effect: layer, on: false, reason: reason(), stated_error: None };
        let requested = requested(layers, body.map(|p| p.body.id), data);
        let decisions = requested.into_iter().filter(|(is_requested, _)| *is_requested).map(left_out).collect();
        return AnnotationLines { decisions, ..AnnotationLines::default() };
    };
    let mut builder = GroundLineBuilder { camera, placed, output: AnnotationLines::default() };
    if layers.grid_body {
        builder.grid(context.request.language);
    }
    if layers.terminator {
        builder.terminator();
    }
    if has_data_lines(layers, Some(placed.body.id), data) {
        data_lines::on_ground(&mut builder, data, context.request.time);
    }
    if layers.eclipse_path {
        eclipse_lines::on_ground(&mut builder, context);
    }
    builder.output
}
