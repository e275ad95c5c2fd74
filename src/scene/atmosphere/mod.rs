//! Air and clouds: when they are drawn, with how many samples the air is integrated, and the tables and nodes that its shaders read.

pub(crate) mod air;
pub mod air_nodes;
pub(crate) mod air_pass;
pub mod air_spread;
pub mod air_table;
pub(crate) mod cloud_decision;
pub(crate) mod clouds;
pub(crate) mod decision;
pub(crate) mod extinction;
pub(crate) mod species;
pub(crate) mod uniform_rows;
