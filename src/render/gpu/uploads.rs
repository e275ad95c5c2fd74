//! Textures on the device, each uploaded once and kept within a budget.
//!
//! Mips are those of the decoded map: nothing is filtered here. A texture is known by the decoded map it came from; one that no frame used lately
//! goes first when the budget is spent. Tables of one level are known by their content, because scene makes them anew each frame, but for those that their owner keeps.

use crate::image::{SharedTexture, TexelFormat, Texture};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::sync::{Arc, Weak};
use wgpu::{
    Device, Extent3d, Origin3d, Queue, TexelCopyBufferLayout, TexelCopyTextureInfo, TextureAspect, TextureDescriptor, TextureDimension,
    TextureFormat, TextureUsages, TextureView,
};

/// Bytes of maps on the device before the least used go: eight maps of 8192x4096 with their mips.
const BUDGET_BYTES: u64 = 1_500_000_000;

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
        let (sent, bytes) = send(device, queue, texture)?;
        self.sent_bytes += bytes;
        let view = sent.create_view(&wgpu::TextureViewDescriptor::default());
        let alive = (!table).then(|| Arc::downgrade(texture));
        self.by_source.insert(source, Uploaded { view: view.clone(), texture: sent, bytes, used_in: self.frame, alive });
        Ok(view)
    }
}

fn send(device: &Device, queue: &Queue, texture: &Texture) -> Result<(wgpu::Texture, u64), String> {
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
    let mut bytes = 0;
    for (mip_level, level) in (0..).zip(&texture.levels) {
        let to = TexelCopyTextureInfo { texture: &sent, mip_level, origin: Origin3d::ZERO, aspect: TextureAspect::All };
        let layout = TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(texel_bytes * level.width), rows_per_image: None };
        queue.write_texture(to, &level.bytes, layout, extent(level.width, level.height));
        bytes += level.bytes.len() as u64;
    }
    Ok((sent, bytes))
}
