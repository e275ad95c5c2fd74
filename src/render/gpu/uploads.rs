//! Textures on the device, each uploaded once and kept within a budget.
//!
//! Mips are those of the decoded map: nothing is filtered here. A texture is known by the decoded map it came from; one that no frame used lately
//! goes first when the budget is spent. Large maps go in pieces. Tables of one level are known by their content, because scene makes them anew each frame, but for those that their owner keeps.

use crate::image::{SharedTexture, TexelFormat, Texture};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use wgpu::{
    Device, Extent3d, Origin3d, PollType, Queue, SubmissionIndex, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect,
    TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
};

/// Bytes of maps on the device before the least used go: eight maps of 8192x4096 with their mips.
const BUDGET_BYTES: u64 = 1_500_000_000;

/// Bytes of maps that are on their way at a time, twice: what is sent lies once more beside the map until the device has it.
const PIECE_BYTES: u64 = 32 << 20;

/// Frames for which a table that none of them reads is kept.
const TABLE_FRAMES: u64 = 60;

#[derive(Clone, PartialEq, Eq, Hash)]
enum Source {
    Map(usize),
    Table([u8; 32]),
}

struct Uploaded {
    view: TextureView,
    texture: wgpu::Texture,
    bytes: u64,
    used_in: u64,
    /// Of a map: the address alone could be another map's by now.
    alive: Option<Weak<Texture>>,
}

#[derive(Default)]
pub struct Uploads {
    by_source: HashMap<Source, Uploaded>,
    frame: u64,
    /// Bytes of maps since the device was last told to begin.
    on_the_way: u64,
    last_piece: Option<SubmissionIndex>,
    /// Bytes sent since the renderer was opened.
    pub sent_bytes: u64,
}

pub fn format_of(format: TexelFormat) -> TextureFormat {
    match format {
        TexelFormat::Rgba8Srgb => TextureFormat::Rgba8UnormSrgb,
        TexelFormat::Rgba8Unorm => TextureFormat::Rgba8Unorm,
        TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
    }
}

impl Uploads {
    /// A new frame begins: what it does not use may go.
    pub fn begin_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        self.by_source.retain(|_, u| match &u.alive {
            Some(map) => map.strong_count() > 0,
            None => u.used_in + TABLE_FRAMES >= frame,
        });
        let mut held = self.held_bytes();
        if held <= BUDGET_BYTES {
            return;
        }
        let mut oldest: Vec<(u64, Source, u64)> = self.by_source.iter().map(|(s, u)| (u.used_in, s.clone(), u.bytes)).collect();
        oldest.sort_by_key(|(used, ..)| *used);
        for (_, source, bytes) in oldest {
            if held <= BUDGET_BYTES {
                break;
            }
            if let Some(gone) = self.by_source.remove(&source) {
                gone.texture.destroy();
            }
            held -= bytes;
        }
    }

    pub fn held_bytes(&self) -> u64 {
        self.by_source.values().map(|u| u.bytes).sum()
    }

    /// The texture on the device, sent there if it is not. `kept`: its owner holds it while it is unchanged.
    pub fn view(&mut self, device: &Device, queue: &Queue, texture: &SharedTexture, kept: bool) -> Result<TextureView, String> {
        let source = match &texture.levels[..] {
            [] => return Err("a texture without levels".into()),
            [only] if !kept => Source::Table(Sha256::digest(&only.bytes).into()),
            _ => Source::Map(Arc::as_ptr(texture) as usize),
        };
        let table = matches!(source, Source::Table(_));
        if let Some(known) = self.by_source.get_mut(&source) {
            known.used_in = self.frame;
            return Ok(known.view.clone());
        }
        let sent = self.send(device, queue, texture)?;
        let bytes = texture.levels.iter().map(|level| level.bytes.len() as u64).sum();
        self.sent_bytes += bytes;
        let view = sent.create_view(&wgpu::TextureViewDescriptor::default());
        let alive = (!table).then(|| Arc::downgrade(texture));
        self.by_source.insert(source, Uploaded { view: view.clone(), texture: sent, bytes, used_in: self.frame, alive });
        Ok(view)
    }

    /// All levels, by rows where one is more than a piece.
    fn send(&mut self, device: &Device, queue: &Queue, texture: &Texture) -> Result<wgpu::Texture, String> {
        let first = &texture.levels[0];
        let most = device.limits().max_texture_dimension_2d;
        if first.width > most || first.height > most {
            return Err(format!("a map of {}x{} texels, of {most} that the adapter takes", first.width, first.height));
        }
        let extent = |width: u32, height: u32| Extent3d { width, height, depth_or_array_layers: 1 };
        let sent = device.create_texture(&TextureDescriptor {
            label: None,
            size: extent(first.width, first.height),
            mip_level_count: texture.levels.len() as u32,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: format_of(texture.format),
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let texel_bytes = if texture.format == TexelFormat::Rgba32Float { 16 } else { 4 };
        for (mip_level, level) in (0..).zip(&texture.levels) {
            let row_bytes = texel_bytes * level.width;
            let rows = (PIECE_BYTES / u64::from(row_bytes)).max(1) as u32;
            for (y, piece) in (0..).step_by(rows as usize).zip(level.bytes.chunks(rows as usize * row_bytes as usize)) {
                let to = TexelCopyTextureInfo { texture: &sent, mip_level, origin: Origin3d { x: 0, y, z: 0 }, aspect: TextureAspect::All };
                let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
                queue.write_texture(to, piece, layout, extent(level.width, rows.min(level.height - y)));
                self.on_the_way += piece.len() as u64;
                if self.on_the_way >= PIECE_BYTES {
                    self.send_off(device, queue)?;
                }
            }
        }
        Ok(sent)
    }

    /// Lets the device begin with what is on its way, and waits until it has what went before.
    fn send_off(&mut self, device: &Device, queue: &Queue) -> Result<(), String> {
        self.on_the_way = 0;
        let gone = self.last_piece.replace(queue.submit([]));
        let wait = |piece| device.poll(PollType::Wait { submission_index: Some(piece), timeout: None });
        gone.map_or(Ok(()), |piece| wait(piece).map(drop).map_err(|e| e.to_string()))
    }
}
