//! The data layers of a catalog: layers from its files, and layers added at run time, for example by dropping a file on the window.
//!
//! In: layers. Out: all layers in drawing order. Layers are added to a catalog that several threads share, so the list is behind a lock.

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

    /// A copy of the list: the layers at the time of the call.
    pub fn all(&self) -> Vec<Arc<DataLayer>> {
        self.0.read().clone()
    }

    /// Adds a layer. It replaces an earlier layer of the same name.
    pub fn add(&self, layer: DataLayer) {
        let mut all = self.0.write();
        all.retain(|listed| listed.name != layer.name);
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
