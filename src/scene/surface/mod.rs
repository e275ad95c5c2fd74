//! The surface of a body: its shape and maps, images laid over it, and triangles in place of its ellipsoid.

pub(crate) mod detail;
pub(crate) mod ground;
pub(crate) mod mesh_decision;
pub(crate) mod meshes;
pub mod overlays;
