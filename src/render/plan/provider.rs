//! What a plan needs besides its scene: the session implements this trait, so that planning itself reads no files and keeps no caches.

use super::error::PlanError;
use crate::image::{GlyphAtlas, MapDecoding, SharedTexture};
use crate::scene::draw::RingTable;
use crate::shader::Layout;
use crate::shader::ModuleId;
use std::sync::Arc;

/// Supplies the layouts of modules, decoded maps and glyphs.
pub trait ResourceProvider {
    /// The uniform fields and the texture and sampler bindings of a module.
    fn layout(&self, module: &ModuleId) -> Result<Layout, PlanError>;
    /// A map by its file name.
    fn map(&self, file: &str, decoding: MapDecoding) -> Result<SharedTexture, PlanError>;
    /// A colour image that lies over a body's map or over the sky, by its file name; premultiplied by its alpha in linear light.
    fn overlay(&self, file: &str) -> Result<SharedTexture, PlanError>;
    /// The texture of a ring profile. It takes up to a megabyte, so the provider keeps it from frame to frame.
    fn ring_profile(&self, table: &Arc<RingTable>) -> SharedTexture;
    /// The glyph atlas for texts of a size in pixels.
    fn glyphs(&self, size_px: f64) -> Arc<GlyphAtlas>;
}
