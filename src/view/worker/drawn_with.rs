//! What an image or an answer depends on besides its request: shader fragments, the choice of renderer, data files dropped on the window.
//!
//! In: a session. Out: a value that differs once one of these has changed. Always: whoever stores an answer with its request stores this value, too,
//! and asks again when it differs.

use crate::catalog::DataLayer;
use crate::session::{RendererPreference, Session};
use std::sync::Arc;

/// What an image or an answer depends on besides its request.
#[derive(Clone)]
pub(crate) struct DrawnWith {
    /// Digest of the shader fragments (sources) and of the emitter, which generates modules from them.
    generator: Arc<str>,
    preference: RendererPreference,
    data_layers: Vec<Arc<DataLayer>>,
}

impl DrawnWith {
    /// What an image would depend on now.
    pub(crate) fn now(session: &Session) -> Self {
        Self {
            generator: session.library().generator_digest(),
            preference: session.renderers().1,
            data_layers: session.catalog().data_layers(),
        }
    }
}

impl PartialEq for DrawnWith {
    fn eq(&self, other: &Self) -> bool {
        // A layer never changes; a file that is dropped again becomes a new layer. So a layer is identified by its address, without comparing contents.
        let is_same_layer = |(a, b): (&Arc<DataLayer>, &Arc<DataLayer>)| Arc::ptr_eq(a, b);
        (&self.generator, self.preference) == (&other.generator, other.preference)
            && self.data_layers.len() == other.data_layers.len()
            && self.data_layers.iter().zip(&other.data_layers).all(is_same_layer)
    }
}
