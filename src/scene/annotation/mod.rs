//! Annotations of an image: names and markers of bodies, orbits, lines of the sky and of the ground with their labels, and the legend of the
//! image's colours.

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
pub mod sky_lines;
pub(crate) mod star_names;
pub mod strokes;
pub mod text;
pub mod traces;
