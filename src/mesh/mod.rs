//! Shape models: from the text of a file to vertex data, and self-shadowing.
//!
//! In: an OBJ file's text ([`obj`]) and the body's ellipsoid. Out: a [`Mesh`], ready to be drawn: f32 attributes in the frame where the body's ellipsoid is the
//! unit sphere, and positions in f64, km. From these and the Sun's direction, [`self_shadow`] computes the *altitude of the Sun* at each vertex: its angle
//! above the skyline that the mesh itself forms in that direction, not above a horizontal plane. Always: every index is in range, every normal has length 1,
//! every number is finite. Not here: cameras, files, and other properties of bodies.

mod model;
pub mod obj;
pub mod self_shadow;

pub use model::{Mesh, ShapeError, ShapeParameters};
