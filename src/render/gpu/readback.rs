//! Copies pixels from the GPU to the CPU. The copy is made in bands of rows, so that the staging buffer of a large image (up to 16384 x 16384 pixels) stays
//! small.
//!
//! In: a texture in GPU memory. Out: its pixels, without the padding of rows that the GPU requires.

use super::GpuError;
use std::sync::mpsc;
use wgpu::{
    Buffer, BufferDescriptor, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, Device, Extent3d, MapMode, Origin3d, PollType, Queue,
    TexelCopyBufferInfo, TexelCopyBufferLayout, TexelCopyTextureInfo, Texture, TextureAspect,
};

/// Maximum size of a band in bytes, unless one row is larger.
const BAND_BYTES: u64 = 64 << 20;

/// The staging buffer (CPU-visible memory into which the GPU copies), kept between frames.
#[derive(Default)]
pub(crate) struct Readback {
    buffer: Option<Buffer>,
}

/// Waits for the device, maps the first `byte_count` bytes of a buffer, and passes them to `read`.
pub(crate) fn read_mapped<T>(device: &Device, buffer: &Buffer, byte_count: u64, read: impl FnOnce(&[u8]) -> T) -> Result<T, GpuError> {
    let device_error = |error: &dyn std::fmt::Display| GpuError::DeviceLost(error.to_string());
    let (send, receive) = mpsc::channel();
    let slice = buffer.slice(..byte_count);
    slice.map_async(MapMode::Read, move |result| {
        let _ = send.send(result);
    });
    device.poll(PollType::wait_indefinitely()).map_err(|e| device_error(&e))?;
    receive.recv().map_err(|e| device_error(&e))?.map_err(|e| device_error(&e))?;
    let result = {
        let bytes = slice.get_mapped_range().map_err(|e| device_error(&e))?;
        read(&bytes)
    };
    buffer.unmap();
    Ok(result)
}

impl Readback {
    /// All pixels of a texture, top row first. `N`: bytes per pixel.
    pub(crate) fn pixels<const N: usize>(&mut self, device: &Device, queue: &Queue, texture: &Texture) -> Result<Vec<[u8; N]>, GpuError> {
        let (width, height) = (texture.width(), texture.height());
        let row_bytes = width * N as u32;
        let padded_row_bytes = row_bytes.next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
        let rows_per_band = u32::try_from(BAND_BYTES / u64::from(padded_row_bytes)).unwrap_or(u32::MAX).clamp(1, height);
        let needed_bytes = u64::from(padded_row_bytes) * u64::from(rows_per_band);
        if self.buffer.as_ref().is_none_or(|b| b.size() < needed_bytes) {
            let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
            self.buffer = Some(device.create_buffer(&BufferDescriptor {
                label: Some("readback"),
                size: needed_bytes,
                usage,
                mapped_at_creation: false,
            }));
        }
        let Some(buffer) = &self.buffer else { return Err(GpuError::OutOfMemory) };
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(width as usize * height as usize).map_err(|_| GpuError::OutOfMemory)?;
        for top in (0..height).step_by(rows_per_band as usize) {
            let band_rows = rows_per_band.min(height - top);
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_texture_to_buffer(
                TexelCopyTextureInfo { texture, mip_level: 0, origin: Origin3d { x: 0, y: top, z: 0 }, aspect: TextureAspect::All },
                TexelCopyBufferInfo {
                    buffer,
                    layout: TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded_row_bytes), rows_per_image: None },
                },
                Extent3d { width, height: band_rows, depth_or_array_layers: 1 },
            );
            queue.submit([encoder.finish()]);
            read_mapped(device, buffer, u64::from(padded_row_bytes) * u64::from(band_rows), |bytes| {
                for row in bytes.chunks_exact(padded_row_bytes as usize) {
                    pixels.extend_from_slice(row[..row_bytes as usize].as_chunks::<N>().0);
                }
            })?;
        }
        Ok(pixels)
    }
}
