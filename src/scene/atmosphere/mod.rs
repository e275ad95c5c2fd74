//! Air and clouds: when they are drawn, how finely the air is summed, and the tables and nodes that its shaders read.

pub(crate) mod air;
pub mod air_nodes;
pub mod air_spread;
pub mod air_table;
pub(crate) mod cloud_decision;
pub(crate) mod clouds;
pub(crate) mod decision;
pub(crate) mod extinction;
pub(crate) mod species;
pub(crate) mod uniform_rows;
