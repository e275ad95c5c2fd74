//! Textures in GPU memory, each uploaded once and kept within a budget.
//!
//! In: decoded textures. Out: views of GPU textures with the same mip levels; nothing is filtered here. Large maps are uploaded in chunks. The
//! least recently used textures are evicted when the budget is exceeded. A map is identified by the address of its decoded texture. A table (a texture of one
//! mip level, such as the limb profile of the Moon) is identified by a digest of its content, because the plan makes new textures of tables in each frame; a
//! persistent table, which its owner keeps from frame to frame, by its address, like a map.

use crate::image::{SharedTexture, TexelFormat, Texture};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use wgpu::{
    Device, Extent3d, Origin3d, PollType, Queue, SubmissionIndex, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
    TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
};

/// Bytes of textures in GPU memory above which the least recently used are evicted: eight maps of 8192x4096 with their mip levels.
const BUDGET_BYTES: u64 = 1_500_000_000;

/// Bytes of one chunk of an upload. At most two chunks are in flight: each occupies staging memory until the device has copied it.
const CHUNK_BYTES: u64 = 32 << 20;

/// A table that is identified by its content is evicted after this many frames without a use: one second at 60 frames per second.
const UNUSED_TABLE_FRAMES: u64 = 60;

#[derive(Clone, PartialEq, Eq, Hash)]
enum TextureKey {
    /// A map or a persistent table: the address of the decoded texture.
    ByAddress(usize),
    /// Any other table: the digest of the content, its size and its format, because the same bytes can be texels of another table.
    ByContent([u8; 32], [u32; 2], TexelFormat),
}

/// A texture in GPU memory.
struct Uploaded {
    view: TextureView,
    texture: wgpu::Texture,
    /// Size of all mip levels.
    byte_count: u64,
    last_used_frame: u64,
    /// For [`TextureKey::ByAddress`], the decoded texture; `None` for [`TextureKey::ByContent`]. Once the decoded texture no longer exists, this entry is
    /// evicted; until then, the weak reference keeps the address from being reused.
    decoded: Option<Weak<Texture>>,
}

/// The uploaded textures, and the state of their uploads.
#[derive(Default)]
pub(crate) struct Uploads {
    by_key: HashMap<TextureKey, Uploaded>,
    /// Number of the current frame.
    frame: u64,
    /// Bytes written since the last chunk was submitted.
    pending_bytes: u64,
    /// The last submitted chunk; `None` before the first.
    last_chunk: Option<SubmissionIndex>,
    /// Bytes uploaded since the renderer was opened.
    pub total_uploaded_bytes: u64,
}

pub(crate) fn format_of(format: TexelFormat) -> TextureFormat {
    match format {
        TexelFormat::Rgba8Srgb => TextureFormat::Rgba8UnormSrgb,
        TexelFormat::Rgba8Unorm => TextureFormat::Rgba8Unorm,
        TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
    }
}

impl Uploads {
    /// Starts a frame: evicts textures whose decoded texture no longer exists, tables that were not used for [`UNUSED_TABLE_FRAMES`], and, while the
    /// budget is exceeded, the least recently used textures.
    pub(crate) fn begin_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        self.by_key.retain(|_, u| match &u.decoded {
            Some(decoded) => decoded.strong_count() > 0,
            None => u.last_used_frame + UNUSED_TABLE_FRAMES >= frame,
        });
        let mut total = self.resident_bytes();
        if total <= BUDGET_BYTES {
            return;
        }
        let mut by_last_use: Vec<(u64, TextureKey, u64)> =
            self.by_key.iter().map(|(key, u)| (u.last_used_frame, key.clone(), u.byte_count)).collect();
        by_last_use.sort_by_key(|(last_used_frame, ..)| *last_used_frame);
        for (_, key, byte_count) in by_last_use {
            if total <= BUDGET_BYTES {
                break;
            }
            if let Some(evicted) = self.by_key.remove(&key) {
                evicted.texture.destroy();
            }
            total -= byte_count;
        }
    }

    pub(crate) fn resident_bytes(&self) -> u64 {
        self.by_key.values().map(|u| u.byte_count).sum()
    }

    /// The view of a texture, which is uploaded first if necessary. `is_persistent`: the owner keeps the texture alive until its content changes.
    pub(crate) fn view(
        &mut self,
        device: &Device,
        queue: &Queue,
        texture: &SharedTexture,
        is_persistent: bool,
    ) -> Result<TextureView, String> {
        let key = match &texture.levels[..] {
            [] => return Err("a texture has no mip level".into()),
            // One mip level: a table.
            [only] if !is_persistent => {
                TextureKey::ByContent(Sha256::digest(only.bytes()).into(), [only.width, only.height], texture.format)
            }
            _ => TextureKey::ByAddress(Arc::as_ptr(texture) as usize),
        };
        if let Some(uploaded) = self.by_key.get_mut(&key) {
            uploaded.last_used_frame = self.frame;
            return Ok(uploaded.view.clone());
        }
        let uploaded = self.upload(device, queue, texture)?;
        let byte_count = texture.levels.iter().map(|level| level.byte_count() as u64).sum();
        self.total_uploaded_bytes += byte_count;
        let view = uploaded.create_view(&wgpu::TextureViewDescriptor::default());
        let decoded = matches!(key, TextureKey::ByAddress(_)).then(|| Arc::downgrade(texture));
        self.by_key.insert(key, Uploaded { view: view.clone(), texture: uploaded, byte_count, last_used_frame: self.frame, decoded });
        Ok(view)
    }

    /// Uploads all levels, those larger than a chunk in bands of rows.
    fn upload(&mut self, device: &Device, queue: &Queue, texture: &Texture) -> Result<wgpu::Texture, String> {
        let largest = &texture.levels[0];
        let max_side = device.limits().max_texture_dimension_2d;
        if largest.width > max_side || largest.height > max_side {
            return Err(format!(
                "a texture has {}x{} texels; the adapter allows at most {max_side} per side",
                largest.width, largest.height
            ));
        }
        let extent = |width: u32, height: u32| Extent3d { width, height, depth_or_array_layers: 1 };
        let uploaded = device.create_texture(&TextureDescriptor {
            label: None,
            size: extent(largest.width, largest.height),
            mip_level_count: texture.levels.len() as u32,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: format_of(texture.format),
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (mip_level, level) in (0..).zip(&texture.levels) {
            let row_bytes = texture.format.texel_bytes() * level.width;
            let rows_per_chunk = (CHUNK_BYTES / u64::from(row_bytes)).max(1) as u32;
            let chunks = level.bytes().chunks(rows_per_chunk as usize * row_bytes as usize);
            for (y, chunk) in (0..).step_by(rows_per_chunk as usize).zip(chunks) {
                let to =
                    TexelCopyTextureInfo { texture: &uploaded, mip_level, origin: Origin3d { x: 0, y, z: 0 }, aspect: TextureAspect::All };
                let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
                queue.write_texture(to, chunk, layout, extent(level.width, rows_per_chunk.min(level.height - y)));
                self.pending_bytes += chunk.len() as u64;
                if self.pending_bytes >= CHUNK_BYTES {
                    self.submit_chunk(device, queue)?;
                }
            }
        }
        Ok(uploaded)
    }

    /// Submits the pending writes, and waits until the device has completed the previous chunk.
    fn submit_chunk(&mut self, device: &Device, queue: &Queue) -> Result<(), String> {
        self.pending_bytes = 0;
        let previous = self.last_chunk.replace(queue.submit([]));
        let wait = |chunk| device.poll(PollType::Wait { submission_index: Some(chunk), timeout: None });
        previous.map_or(Ok(()), |chunk| wait(chunk).map(drop).map_err(|e| e.to_string()))
    }
}
