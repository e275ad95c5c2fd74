//! A body's shape as triangles: from the text of a file to what a renderer takes, and the shadow that the shape throws on itself.
//!
//! In: an OBJ file's text ([`obj`]) and the body's figure. Out: a [`Model`], ready to be drawn: f32 attributes in the frame where the body's ellipsoid
//! is the unit sphere, and the same places in f64 for [`self_shadow`], which says at each vertex how high the Sun stands over the shape's own horizon.
//! Always holds: every index is in range, every normal has length 1, every number is finite. It knows no camera, no body but by its figure, no files.

mod model;
pub mod obj;
pub mod self_shadow;

pub use model::{Model, ShapeError, ShapeFrame};
