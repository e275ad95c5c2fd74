//! What a plan is made of besides its scene.

use super::error::PlanError;
use crate::image::{GlyphAtlas, MapDecoding, SharedTexture};
use crate::shader::Layout;
use crate::shader::ModuleId;
use std::sync::Arc;

/// What the plan asks of the outside: layouts of modules and decoded maps.
pub trait ResourceProvider {
    fn layout(&self, module: &ModuleId) -> Result<Layout, PlanError>;
    /// A map by its file name, as colour or as plain numbers.
    fn map(&self, file: &str, reading: MapDecoding) -> Result<SharedTexture, PlanError>;
    /// A colour image premultiplied by its alpha.
    fn overlay(&self, file: &str) -> Result<SharedTexture, PlanError>;
    /// The letters of all bodies' names for texts of a size, pixels.
    fn glyphs(&self, size_px: f64) -> Arc<GlyphAtlas>;
}
