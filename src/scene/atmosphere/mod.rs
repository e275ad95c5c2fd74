//! Air and clouds: when they are drawn, with how many samples the air is integrated, and the tables and nodes that its shaders read.

pub(crate) mod air;
pub(crate) mod air_pass;
pub(crate) mod cloud_decision;
pub(crate) mod clouds;
pub(crate) mod decision;
pub(crate) mod extinction;
pub(crate) mod ground_depth;
pub mod multi_scatter_in_shadow;
pub mod multi_scatter_table;
pub mod quadrature_nodes;
pub(crate) mod species;
pub(crate) mod uniform_rows;
