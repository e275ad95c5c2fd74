//! Looks up the value of a draw's uniform by its name in the shaders' WESL files, and computes those that are tables of quadrature nodes.
//!
//! In: a draw's uniforms, a name, and the number of rows of the array in the shader module, from which the number of nodes follows. Out: the value, not its
//! bytes.

use super::quadrature_nodes;
use crate::scene::draw::DrawUniforms;
use crate::scene::draw::uniforms::UniformValue;
use std::borrow::Cow;

/// The value of the uniform `name`. `rows`: length of its array, 0 if it is not an array. `None` if no draw has such a uniform.
pub fn uniform_value<'a>(uniforms: &'a DrawUniforms, name: &str, rows: usize) -> Option<UniformValue<'a>> {
    let air = &uniforms.air;
    let table = match name {
        "air_quadrature_nodes" => quadrature_nodes::nodes(air, (rows / quadrature_nodes::ROWS).saturating_sub(quadrature_nodes::ENDS)),
        "air_samples" | "air_multi_scatter_samples" => quadrature_nodes::samples(rows),
        "air_multi_scatter_nodes" => quadrature_nodes::multi_scatter(air, rows / quadrature_nodes::COEFFICIENTS),
        _ => return uniforms.uniform(name),
    };
    Some(UniformValue::Rows(Cow::Owned(table)))
}
