//! The surface of a body: its shape, maps, overlays and meshes.

pub(crate) mod crescent;
pub(crate) mod detail;
pub(crate) mod ground;
pub(crate) mod mesh_decision;
pub(crate) mod meshes;
pub mod overlays;
