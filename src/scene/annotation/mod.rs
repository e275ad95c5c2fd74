//! What explains a picture: names and markers of bodies, orbit lines, and the legend of its colours.

pub mod labels;
pub mod legend;
pub mod orbits;
pub mod picking;
pub mod traces;
