//! The uniform bytes, attributes and indices of a frame, which go to the device in one write each.

use crate::render::plan::{PlanDraw, Vertices};
use wgpu::{Buffer, BufferDescriptor, BufferUsages, Device, Queue};

/// Bytes of a frame.
#[derive(Default)]
pub(super) struct Bytes {
    pub uniforms: Vec<u8>,
    pub attributes: Vec<u8>,
    pub indices: Vec<u8>,
}

impl Bytes {
    /// Puts a draw's bytes behind those of the draws before.
    ///
    /// Answers the offset of the uniform block, start and length of each attribute, and the start of the indices. `align`: of uniform blocks.
    pub fn place(&mut self, draw: &PlanDraw, align: usize) -> (Option<u32>, Vec<(u64, u64)>, Option<u64>) {
        let uniform_offset = (!draw.uniform_bytes.is_empty()).then(|| {
            self.uniforms.resize(self.uniforms.len().next_multiple_of(align), 0);
            let at = self.uniforms.len() as u32;
            self.uniforms.extend_from_slice(&draw.uniform_bytes);
            at
        });
        let (of_vertices, indices) = match &draw.vertices {
            Vertices::Count(_) => (&[][..], None),
            Vertices::Mesh { attributes, indices } => (&attributes[..], Some(indices)),
        };
        let mut put = |values: &[f32]| {
            let at = self.attributes.len() as u64;
            self.attributes.extend_from_slice(bytemuck::cast_slice(values));
            (at, 4 * values.len() as u64)
        };
        let attributes = of_vertices.iter().chain(&draw.instances.attributes).map(|a| put(&a.values)).collect();
        let indices = indices.map(|indices| {
            let at = self.indices.len() as u64;
            self.indices.extend_from_slice(bytemuck::cast_slice(indices));
            at
        });
        (uniform_offset, attributes, indices)
    }
}

/// Buffers on the device; they grow and stay.
#[derive(Default)]
pub(super) struct Buffers {
    pub uniforms: Option<Buffer>,
    pub attributes: Option<Buffer>,
    pub indices: Option<Buffer>,
}

impl Buffers {
    /// All bytes of the frame to the device.
    pub fn send(&mut self, device: &Device, queue: &Queue, bytes: &Bytes) {
        let send = |buffer: &mut Option<Buffer>, bytes: &[u8], usage: BufferUsages, label: &str| {
            let size = (bytes.len() as u64).next_multiple_of(4);
            if size == 0 {
                return;
            }
            if buffer.as_ref().is_none_or(|b| b.size() < size) {
                let size = size.next_power_of_two().max(4096);
                let usage = usage | BufferUsages::COPY_DST;
                *buffer = Some(device.create_buffer(&BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false }));
            }
            let mut padded = bytes.to_vec();
            padded.resize(size as usize, 0);
            if let Some(buffer) = buffer {
                queue.write_buffer(buffer, 0, &padded);
            }
        };
        send(&mut self.uniforms, &bytes.uniforms, BufferUsages::UNIFORM, "uniforms");
        send(&mut self.attributes, &bytes.attributes, BufferUsages::VERTEX, "attributes");
        send(&mut self.indices, &bytes.indices, BufferUsages::INDEX, "indices");
    }
}
