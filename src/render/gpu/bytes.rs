//! Collects the uniform blocks, vertex and instance attributes, and indices of all draws of a frame, and uploads each kind with one write.
//!
//! In: the draws of a plan. Out: one buffer for each kind of data, and the offsets of each draw's data in these buffers.

use crate::render::plan::{PlanDraw, Vertices};
use std::ops::Range;
use wgpu::{Buffer, BufferDescriptor, BufferUsages, Device, Queue};

/// The contents of a frame's buffers.
#[derive(Default)]
pub(super) struct FrameBytes {
    pub uniforms: Vec<u8>,
    pub attributes: Vec<u8>,
    pub indices: Vec<u8>,
}

/// Where one draw's data are in the frame's buffers. All offsets in bytes.
pub(crate) struct DrawOffsets {
    /// Start of the uniform block; `None` if the module has no uniforms.
    pub uniforms: Option<u32>,
    /// Range of each attribute, per-vertex attributes first.
    pub attributes: Vec<Range<u64>>,
    /// Start of the indices; `None` if the draw has none.
    pub indices: Option<u64>,
}

impl FrameBytes {
    /// Appends a draw's bytes. `uniform_alignment`: that of uniform blocks, in bytes.
    pub(crate) fn append(&mut self, draw: &PlanDraw, uniform_alignment: usize) -> DrawOffsets {
        let uniforms = (!draw.uniform_bytes.is_empty()).then(|| {
            self.uniforms.resize(self.uniforms.len().next_multiple_of(uniform_alignment), 0);
            let offset = self.uniforms.len() as u32;
            self.uniforms.extend_from_slice(&draw.uniform_bytes);
            offset
        });
        let (vertex_attributes, indices) = match &draw.vertices {
            Vertices::Count(_) => (&[][..], None),
            Vertices::Mesh { attributes, indices } => (&attributes[..], Some(indices)),
        };
        let mut append_attribute = |values: &[f32]| {
            let offset = self.attributes.len() as u64;
            self.attributes.extend_from_slice(bytemuck::cast_slice(values));
            offset..offset + 4 * values.len() as u64
        };
        let attributes = vertex_attributes.iter().chain(&draw.instances.attributes).map(|a| append_attribute(&a.values)).collect();
        let indices = indices.map(|indices| {
            let offset = self.indices.len() as u64;
            self.indices.extend_from_slice(bytemuck::cast_slice(indices));
            offset
        });
        DrawOffsets { uniforms, attributes, indices }
    }
}

/// Buffers in GPU memory, reused by every frame and grown when needed.
#[derive(Default)]
pub(super) struct Buffers {
    pub uniforms: Option<Buffer>,
    pub attributes: Option<Buffer>,
    pub indices: Option<Buffer>,
}

impl Buffers {
    /// Uploads the bytes of a frame.
    pub(crate) fn upload(&mut self, device: &Device, queue: &Queue, bytes: &FrameBytes) {
        let upload = |buffer: &mut Option<Buffer>, bytes: &[u8], usage: BufferUsages, label: &str| {
            // wgpu writes only multiples of 4 bytes.
            let size = (bytes.len() as u64).next_multiple_of(4);
            if size == 0 {
                return;
            }
            if buffer.as_ref().is_none_or(|b| b.size() < size) {
                // Powers of two, and at least 4 KiB, so that a frame that grows a little seldom needs a new buffer.
                let capacity = size.next_power_of_two().max(4096);
                let usage = usage | BufferUsages::COPY_DST;
                *buffer =
                    Some(device.create_buffer(&BufferDescriptor { label: Some(label), size: capacity, usage, mapped_at_creation: false }));
            }
            let mut padded = bytes.to_vec();
            padded.resize(size as usize, 0);
            if let Some(buffer) = buffer {
                queue.write_buffer(buffer, 0, &padded);
            }
        };
        upload(&mut self.uniforms, &bytes.uniforms, BufferUsages::UNIFORM, "uniforms");
        upload(&mut self.attributes, &bytes.attributes, BufferUsages::VERTEX, "attributes");
        upload(&mut self.indices, &bytes.indices, BufferUsages::INDEX, "indices");
    }
}
