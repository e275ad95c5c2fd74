//! What a plan is made of besides its scene.

use super::error::PlanError;
use super::passes::ModuleName;
use crate::image::{Letters, Reading, SharedTexture};
use crate::shader::Layout;
use std::sync::Arc;

/// What the plan asks of the outside: layouts of modules and decoded maps.
pub trait Supplies {
    fn layout(&self, module: &ModuleName) -> Result<Layout, PlanError>;
    /// A map by its file name, as colour or as plain numbers.
    fn map(&self, file: &str, reading: Reading) -> Result<SharedTexture, PlanError>;
    /// A colour image premultiplied by its alpha.
    fn overlay(&self, file: &str) -> Result<SharedTexture, PlanError>;
    /// The letters of all bodies' names for texts of a size, pixels.
    fn letters(&self, size_px: f64) -> Arc<Letters>;
}
