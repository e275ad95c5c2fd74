//! Air and clouds: when they are drawn, with how many samples the air is integrated, and the tables and nodes that its shaders read.
//!
//! In: the catalog's atmospheres and clouds, and one placed body with the request. Out: decisions with their reasons, draws, and uniforms.

pub(crate) mod air;
pub(crate) mod air_pass;
mod air_sphere;
pub(crate) mod cloud_decision;
pub(crate) mod clouds;
mod constituent;
pub(crate) mod decision;
mod diffuse_light;
pub(crate) mod extinction;
pub mod multi_scatter_in_shadow;
pub mod multi_scatter_table;
pub(crate) mod optical_depth_above_ground;
pub mod phase;
pub mod quadrature_nodes;
pub(crate) mod rim;
pub(crate) mod sky_brightness;
mod sky_in_shadow;
pub(crate) mod sky_in_view;
pub(crate) mod species;
pub(crate) mod tint_table;
pub(crate) mod uniform_rows;

/// |p|² - 1 of a point p at a height above the unit sphere, without the cancellation of a difference of nearly equal numbers.
pub(crate) fn radius_sq_minus_1(height: f64) -> f64 {
    height * (2.0 + height)
}

/// The inverse of [`radius_sq_minus_1`].
pub(crate) fn height_above_unit_sphere(radius_sq_minus_1: f64) -> f64 {
    radius_sq_minus_1 / (1.0 + (1.0 + radius_sq_minus_1).sqrt())
}
