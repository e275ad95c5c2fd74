//! Reads a module's bindings and uniform fields from its naga IR, so that Rust need not repeat the layouts of the WESL files.
//!
//! In: a module. Out: [`Layout`], and a [`UniformWriter`] that fills the uniform block by field name; an error unless all bindings are in group 0 and the
//! uniform block, if any, is binding 0.

use naga::{AddressSpace, ArraySize, Module, ScalarKind, TypeInner, VectorSize};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Type of a uniform field. All components are f32.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum FieldType {
    /// `f32`.
    F32,
    /// `vec2f`.
    Vec2,
    /// `vec3f`.
    Vec3,
    /// `vec4f`.
    Vec4,
    /// `mat4x4f`, column-major.
    Mat4,
    /// `array<vec4f, n>`.
    Vec4Array(u32),
}

impl FieldType {
    /// Number of f32 components in a value.
    pub fn components(self) -> usize {
        match self {
            Self::F32 => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 => 4,
            Self::Mat4 => 16,
            Self::Vec4Array(n) => 4 * n as usize,
        }
    }
}

impl fmt::Display for FieldType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::F32 => f.write_str("f32"),
            Self::Vec2 => f.write_str("vec2f"),
            Self::Vec3 => f.write_str("vec3f"),
            Self::Vec4 => f.write_str("vec4f"),
            Self::Mat4 => f.write_str("mat4x4f"),
            Self::Vec4Array(n) => write!(f, "array<vec4f, {n}>"),
        }
    }
}

/// One field of the uniform block.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UniformField {
    /// Name in the shader.
    pub name: String,
    /// Its type in WGSL.
    pub ty: FieldType,
    /// Offset in bytes from the block's start.
    pub offset: u32,
    /// Size in bytes.
    pub size: u32,
}

/// A texture or sampler of a module.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Binding {
    /// Number of the binding in group 0.
    pub binding: u32,
    /// The variable's name in the shader.
    pub name: String,
}

/// The bindings of one module.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layout {
    /// Fields of the uniform block, sorted by offset; empty if the module has no uniform block.
    pub fields: Vec<UniformField>,
    /// Bytes of the uniform block.
    pub uniform_size: u32,
    /// Sorted by binding number.
    pub textures: Vec<Binding>,
    /// Sorted by binding number.
    pub samplers: Vec<Binding>,
}

/// Why a module's bindings cannot be used, or a uniform cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LayoutError {
    /// The variable of this name is bound outside group 0, or is neither the uniform block at binding 0, nor a texture, nor a sampler.
    #[error("`{0}` is bound outside group 0, or its kind of binding is not one that the plan fills")]
    UnsupportedBinding(String),
    /// The uniform field of this name has a type that is not one of [`FieldType`].
    #[error("uniform field `{0}` has a type that the plan does not fill; it fills f32, vec2f, vec3f, vec4f, mat4x4f and array<vec4f, n>")]
    UnsupportedFieldType(String),
    /// The module has no uniform field of this name.
    #[error("the module has no uniform field `{0}`")]
    UnknownField(String),
    /// The value given has another type or length than the field.
    #[error("uniform field `{name}` is {expected} in the module, but was given {given} components")]
    Mistyped {
        /// The field.
        name: String,
        /// Its type in the module.
        expected: FieldType,
        /// The components that were given: their number, "4 x 4" for a matrix, or "n x 4" for an array of n `vec4f`.
        given: String,
    },
    /// The field of this name was written a second time.
    #[error("uniform field `{0}` was written twice")]
    Twice(String),
    /// The fields of these names were not written.
    #[error("uniform fields never written: {0}")]
    Missing(String),
}

/// The type of a uniform field; `None` if it is not one of [`FieldType`], the types that a [`UniformWriter`] can write.
fn field_type(module: &Module, inner: &TypeInner) -> Option<FieldType> {
    let is_f32 = |s: &naga::Scalar| s.kind == ScalarKind::Float && s.width == 4;
    match inner {
        TypeInner::Scalar(s) if is_f32(s) => Some(FieldType::F32),
        TypeInner::Vector { size, scalar } if is_f32(scalar) => Some(match size {
            VectorSize::Bi => FieldType::Vec2,
            VectorSize::Tri => FieldType::Vec3,
            VectorSize::Quad => FieldType::Vec4,
        }),
        TypeInner::Matrix { columns: VectorSize::Quad, rows: VectorSize::Quad, scalar } if is_f32(scalar) => Some(FieldType::Mat4),
        TypeInner::Array { base, size: ArraySize::Constant(n), .. } => {
            (field_type(module, &module.types[*base].inner) == Some(FieldType::Vec4)).then(|| FieldType::Vec4Array(n.get()))
        }
        _ => None,
    }
}

impl Layout {
    /// Reads the bindings of a module. Variables and fields without a name get an empty one.
    pub fn of(module: &Module) -> Result<Self, LayoutError> {
        let mut layout = Self::default();
        for (_, variable) in module.global_variables.iter() {
            let name = variable.name.clone().unwrap_or_default();
            let Some(resource) = &variable.binding else { continue };
            match (&module.types[variable.ty].inner, variable.space) {
                _ if resource.group != 0 => return Err(LayoutError::UnsupportedBinding(name)),
                (TypeInner::Struct { members, span }, AddressSpace::Uniform) if resource.binding == 0 => {
                    layout.uniform_size = *span;
                    for member in members {
                        let name = member.name.clone().unwrap_or_default();
                        let member_type = &module.types[member.ty].inner;
                        let ty = field_type(module, member_type).ok_or_else(|| LayoutError::UnsupportedFieldType(name.clone()))?;
                        layout.fields.push(UniformField { name, ty, offset: member.offset, size: member_type.size(module.to_ctx()) });
                    }
                }
                (TypeInner::Image { .. }, _) => layout.textures.push(Binding { binding: resource.binding, name }),
                (TypeInner::Sampler { .. }, _) => layout.samplers.push(Binding { binding: resource.binding, name }),
                _ => return Err(LayoutError::UnsupportedBinding(name)),
            }
        }
        layout.textures.sort_by_key(|b| b.binding);
        layout.samplers.sort_by_key(|b| b.binding);
        Ok(layout)
    }
    /// A uniform field by its name; `None` if the block has no such field.
    pub fn field(&self, name: &str) -> Option<&UniformField> {
        self.fields.iter().find(|f| f.name == name)
    }
    /// The binding number of a texture by its name in the shader; `None` if the module has no such texture.
    pub fn texture(&self, name: &str) -> Option<u32> {
        self.textures.iter().find(|b| b.name == name).map(|b| b.binding)
    }
    /// Starts a uniform block, in which no field is written yet.
    pub fn writer(&self) -> UniformWriter<'_> {
        UniformWriter { layout: self, bytes: vec![0; self.uniform_size as usize], written: vec![false; self.fields.len()] }
    }
}

/// Fills a uniform block by field name. Every field must be written exactly once, with a value of its type.
#[derive(Clone, Debug)]
pub struct UniformWriter<'a> {
    layout: &'a Layout,
    bytes: Vec<u8>,
    /// For each field of the layout, whether it has been written.
    written: Vec<bool>,
}

impl UniformWriter<'_> {
    /// Whether the uniform block has this field.
    pub fn has_field(&self, name: &str) -> bool {
        self.layout.field(name).is_some()
    }

    /// Writes one field. `accepts_value`: whether the value may be written to a field of this type. `given`: see [`LayoutError::Mistyped`]. `values`: the
    /// components, of a matrix column by column.
    fn write(
        &mut self,
        name: &str,
        accepts_value: impl Fn(FieldType) -> bool,
        given: &dyn fmt::Display,
        values: &[f32],
    ) -> Result<(), LayoutError> {
        let index = self.layout.fields.iter().position(|f| f.name == name).ok_or_else(|| LayoutError::UnknownField(name.into()))?;
        let field = &self.layout.fields[index];
        let start = field.offset as usize;
        let target = self.bytes.get_mut(start..start + 4 * values.len());
        let (true, true, Some(target)) = (accepts_value(field.ty), values.len() == field.ty.components(), target) else {
            return Err(LayoutError::Mistyped { name: name.into(), expected: field.ty, given: given.to_string() });
        };
        if std::mem::replace(&mut self.written[index], true) {
            return Err(LayoutError::Twice(name.into()));
        }
        for (bytes, value) in target.as_chunks_mut::<4>().0.iter_mut().zip(values) {
            *bytes = value.to_le_bytes();
        }
        Ok(())
    }

    /// Writes an `f32`.
    pub fn f32(&mut self, name: &str, value: f32) -> Result<(), LayoutError> {
        self.write(name, |t| t == FieldType::F32, &1, &[value])
    }
    /// Writes a `vec2f`.
    pub fn vec2(&mut self, name: &str, value: glam::Vec2) -> Result<(), LayoutError> {
        self.write(name, |t| t == FieldType::Vec2, &2, &value.to_array())
    }
    /// Writes a `vec3f`.
    pub fn vec3(&mut self, name: &str, value: glam::Vec3) -> Result<(), LayoutError> {
        self.write(name, |t| t == FieldType::Vec3, &3, &value.to_array())
    }
    /// Writes a `vec4f`.
    pub fn vec4(&mut self, name: &str, value: glam::Vec4) -> Result<(), LayoutError> {
        self.write(name, |t| t == FieldType::Vec4, &4, &value.to_array())
    }
    /// Writes a `mat4x4f`.
    pub fn mat4(&mut self, name: &str, value: glam::Mat4) -> Result<(), LayoutError> {
        self.write(name, |t| t == FieldType::Mat4, &"4 x 4", &value.to_cols_array())
    }
    /// Writes an array of `vec4f` with exactly as many elements as the field.
    pub fn vec4_array(&mut self, name: &str, values: &[glam::Vec4]) -> Result<(), LayoutError> {
        let flat: Vec<f32> = values.iter().flat_map(|v| v.to_array()).collect();
        self.write(name, |t| matches!(t, FieldType::Vec4Array(_)), &format!("{} x 4", values.len()), &flat)
    }

    /// The bytes; an error unless every field is written.
    pub fn finish(self) -> Result<Vec<u8>, LayoutError> {
        let missing: Vec<&str> = self.layout.fields.iter().zip(&self.written).filter(|(_, w)| !**w).map(|(f, _)| f.name.as_str()).collect();
        if missing.is_empty() { Ok(self.bytes) } else { Err(LayoutError::Missing(missing.join(", "))) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3, Vec4};

    fn layout(wgsl: &str) -> Result<Layout, LayoutError> {
        Layout::of(&naga::front::wgsl::parse_str(wgsl).expect("the test's own shader parses"))
    }

    #[test]
    fn offsets_follow_the_uniform_rules() {
        let wgsl = "struct D { a: f32, b: vec3f, c: f32, d: array<vec4f, 2>, } @group(0) @binding(0) var<uniform> d: D; \
                    @group(0) @binding(3) var t: texture_2d<f32>;";
        let l = layout(wgsl).expect("layout");
        let offsets: Vec<_> = l.fields.iter().map(|f| (f.name.as_str(), f.offset, f.size)).collect();
        // WGSL, *Alignment and Size*: vec3f aligns to 16 bytes, and a scalar may follow in its padding.
        assert_eq!(offsets, [("a", 0, 4), ("b", 16, 12), ("c", 28, 4), ("d", 32, 32)]);
        assert_eq!((l.uniform_size, l.texture("t")), (64, Some(3)));
    }

    #[test]
    fn a_writer_checks_names_types_and_completeness() {
        let l = layout("struct D { a: f32, b: vec3f, d: array<vec4f, 2>, } @group(0) @binding(0) var<uniform> d: D;").expect("layout");
        let mut w = l.writer();
        assert!(matches!(w.f32("x", 1.0), Err(LayoutError::UnknownField(_))));
        assert!(matches!(w.f32("b", 1.0), Err(LayoutError::Mistyped { .. })));
        assert!(matches!(w.vec4_array("d", &[Vec4::ONE]), Err(LayoutError::Mistyped { .. })));
        w.f32("a", 2.5).expect("a");
        assert!(matches!(w.f32("a", 1.0), Err(LayoutError::Twice(_))));
        w.vec3("b", Vec3::new(1.0, 2.0, 3.0)).expect("b");
        assert_eq!(w.clone().finish(), Err(LayoutError::Missing("d".into())));
        w.vec4_array("d", &[Vec4::ONE, Vec4::splat(-1.0)]).expect("d");
        let bytes = w.finish().expect("complete");
        // `b` is at offset 16 and its z at 24; `d` is at 32 and its last component at 60.
        assert_eq!(bytes[0..4], 2.5f32.to_le_bytes());
        assert_eq!(bytes[24..28], 3f32.to_le_bytes());
        assert_eq!(bytes[60..64], (-1f32).to_le_bytes());
    }

    #[test]
    fn other_groups_and_types_are_refused() {
        assert!(matches!(layout("@group(1) @binding(0) var t: texture_2d<f32>;"), Err(LayoutError::UnsupportedBinding(_))));
        assert!(matches!(
            layout("struct D { a: u32, } @group(0) @binding(0) var<uniform> d: D;"),
            Err(LayoutError::UnsupportedFieldType(f)) if f == "a"
        ));
    }
}
