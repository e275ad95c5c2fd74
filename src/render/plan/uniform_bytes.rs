//! Fills the uniform block of a body's draw by the names of its module's fields.

use crate::scene::draw::DrawUniforms;
use crate::scene::draw::uniforms::UniformValue;
use crate::scene::uniform_value;
use crate::shader::reflect::{FieldType, LayoutError};
use crate::shader::{Layout, UniformWriter};

/// The bytes of a uniform block with this layout, filled by field name; fails on a name that the draw does not supply. `map_taps`: the maximum number of
/// taps with which a map is filtered anisotropically. If it is 1, a ring's profile is averaged over one span per pixel instead of two, too.
pub fn uniform_bytes(layout: &Layout, uniforms: &DrawUniforms, map_taps: u8) -> Result<Vec<u8>, LayoutError> {
    let mut writer = layout.writer();
    for field in &layout.fields {
        // Only arrays have rows.
        let rows = if let FieldType::Vec4Array(rows) = field.ty { rows as usize } else { 0 };
        match field.name.as_str() {
            name @ "map_taps" => writer.f32(name, f32::from(map_taps))?,
            name @ "ring_spans" => writer.f32(name, if map_taps > 1 { 2.0 } else { 1.0 })?,
            name => {
                let mut value = uniform_value(uniforms, name, rows).ok_or_else(|| LayoutError::Unknown(name.to_owned()))?;
                // A module that evaluates the Sun's light alone has one row, even if the body has several lights. The Sun comes first.
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
