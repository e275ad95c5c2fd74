//! The surface of a body: its shape, maps, overlays, procedural detail and meshes, and how a thin sunlit crescent of it is drawn.

pub(crate) mod crescent;
pub(crate) mod detail;
pub(crate) mod ground;
pub(crate) mod mesh_decision;
pub(crate) mod meshes;
pub mod overlays;
