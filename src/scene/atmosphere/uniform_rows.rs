//! The value of each uniform of a draw by its name in the fragments, tables of the air among them.
//!
//! In: a draw's uniforms, and how many rows the module's array has: a tier's number of samples is a constant of its fragments. Out: the value. Not done: to
//! write bytes.

use super::air_nodes;
use crate::scene::draw::DrawUniforms;
use crate::scene::draw::uniforms::UniformValue;
use std::borrow::Cow;

/// The value of the uniform `name`; `rows`: of its array, 0 where it is none. `None`: no draw has such a uniform.
pub fn uniform_value<'a>(uniforms: &'a DrawUniforms, name: &str, rows: usize) -> Option<UniformValue<'a>> {
    let air = &uniforms.air;
    let table = match name {
        "air_quadrature_nodes" => air_nodes::nodes(air, (rows / air_nodes::ROWS).saturating_sub(air_nodes::ENDS)),
        "air_samples" | "air_multi_scatter_samples" => air_nodes::samples(rows),
        "air_multi_scatter_nodes" => air_nodes::multi_scatter(air, rows / air_nodes::POWERS),
        _ => return uniforms.uniform(name),
    };
    Some(UniformValue::Rows(Cow::Owned(table)))
}
