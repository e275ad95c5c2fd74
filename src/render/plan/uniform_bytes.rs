//! Fills the uniform block of a body's draw by the names of its module's fields.
//!
//! In: the module's layout and the draw's uniforms. Out: the bytes of the block. Always: each field of the module gets a value, or there is an error. Not
//! here: the uniforms of simple shaders (`simple_draws`).

use crate::scene::draw::DrawUniforms;
use crate::scene::draw::uniforms::UniformValue;
use crate::scene::uniform_value;
use crate::shader::reflect::{FieldType, LayoutError};
use crate::shader::{Layout, UniformWriter};

/// The bytes of a uniform block with this layout, filled by field name. `map_taps`: the most taps with which a map is filtered anisotropically.
///
/// # Errors
/// A field that the draw does not supply, or whose value has another type or number of rows.
pub fn uniform_bytes(layout: &Layout, uniforms: &DrawUniforms, map_taps: u8) -> Result<Vec<u8>, LayoutError> {
    let mut writer = layout.writer();
    for field in &layout.fields {
        // The length of an array of vec4, whose elements are called rows.
        let rows = if let FieldType::Vec4Array(rows) = field.ty { rows as usize } else { 0 };
        match field.name.as_str() {
            name @ "map_taps" => writer.f32(name, f32::from(map_taps))?,
            // A pixel's ring light is averaged over one span (an interval of the ring's radius, as wide as a pixel), or over two spans half a pixel apart. One
            // span is faster, two show fewer moire patterns. A view without anisotropic filtering takes the faster way for rings, too.
            name @ "ring_spans" => writer.f32(name, if map_taps > 1 { 2.0 } else { 1.0 })?,
            name => {
                let mut value = uniform_value(uniforms, name, rows).ok_or_else(|| LayoutError::UnknownField(name.to_owned()))?;
                // Lights have one row each, the Sun's first. A module may evaluate only the first few, for example the Sun alone; then it has fewer rows.
                if let (UniformValue::Rows(lights), "light_direction" | "light_irradiance") = (&mut value, name) {
                    lights.to_mut().truncate(rows);
                }
                write_value(&mut writer, name, &value)?
            }
        }
    }
    writer.finish()
}

fn write_value(writer: &mut UniformWriter<'_>, name: &str, value: &UniformValue<'_>) -> Result<(), LayoutError> {
    match value {
        UniformValue::F32(v) => writer.f32(name, *v),
        UniformValue::Vec2(v) => writer.vec2(name, *v),
        UniformValue::Vec3(v) => writer.vec3(name, *v),
        UniformValue::Vec4(v) => writer.vec4(name, *v),
        UniformValue::Mat4(v) => writer.mat4(name, *v),
        UniformValue::Rows(rows) => writer.vec4_array(name, rows),
    }
}
