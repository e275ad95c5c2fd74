//! What explains a picture: names and markers of bodies, orbit lines, and the legend of its colours.

pub mod data;
pub mod features;
pub mod labels;
pub mod legend;
pub mod margin;
pub mod orbits;
pub mod picking;
pub mod text;
