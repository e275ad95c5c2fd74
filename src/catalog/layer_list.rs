//! The data layers of a catalog: those of its files, and those added at run time, as when a file is dropped on the window.

use super::data_layer::DataLayer;
use parking_lot::RwLock;
use std::sync::Arc;

/// Data layers in drawing order.
#[derive(Debug, Default)]
pub(super) struct LayerList(RwLock<Vec<Arc<DataLayer>>>);

impl LayerList {
    pub fn new(layers: Vec<DataLayer>) -> Self {
        Self(RwLock::new(layers.into_iter().map(Arc::new).collect()))
    }

    pub fn all(&self) -> Vec<Arc<DataLayer>> {
        self.0.read().clone()
    }

    /// Adds a layer, or replaces that of the same name.
    pub fn add(&self, layer: DataLayer) {
        let mut all = self.0.write();
        all.retain(|there| there.name != layer.name);
        all.push(Arc::new(layer));
    }
}

impl Clone for LayerList {
    fn clone(&self) -> Self {
        Self(RwLock::new(self.all()))
    }
}

impl PartialEq for LayerList {
    fn eq(&self, other: &Self) -> bool {
        self.all() == other.all()
    }
}
