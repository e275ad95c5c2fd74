//! Annotations of an image: names and markers (bodies, stars, surface features), lines in space, on the sky and on the ground with their labels, points of the
//! user's data, past positions of bodies (`traces`), and near the image's edges caption, scale bar and compass (`margin`); and the legend of the image's
//! colours.
//!
//! In: placed bodies or the reports on them (`scene::body_report`), the camera and the requested layers. Out: line segments, arcs of orbits and texts as plain
//! values, with the decisions which of them are drawn, and why. `labels` places the names of bodies, `line_texts` those of lines, stars and comets; `text`
//! defines lines of text, bars and rectangles. `picking` goes the other way: from a click to the body, comet or star under it. Not here: drawing
//! (`render::plan`).

pub mod body_lines;
pub mod data;
mod data_lines;
pub(crate) mod eclipse_lines;
pub mod features;
pub mod grids;
pub(crate) mod ground_lines;
pub(crate) mod instrument_frames;
pub mod labels;
pub mod legend;
pub mod line_texts;
pub mod margin;
pub mod orbit_arcs;
pub mod orbits;
pub mod picking;
mod shown_ground;
pub mod sky_lines;
pub(crate) mod small_body_names;
pub(crate) mod star_names;
pub mod strokes;
pub mod text;
pub mod traces;
