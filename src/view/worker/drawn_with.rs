//! What an image or the answer to a query depends on besides its request: shader fragments, the choice of renderer, data files dropped on the window.
//!
//! In: a session. Out: a [`DrawnWith`], to be compared with an earlier one; the two differ if one of these things has changed. Always: whoever stores an
//! answer with its request also stores the `DrawnWith` of the answer, and asks again when the current one differs.

use crate::catalog::DataLayer;
use crate::session::{RendererPreference, Session};
use std::sync::Arc;

/// What an image or the answer to a query depends on besides its request.
#[derive(Clone)]
pub(crate) struct DrawnWith {
    /// Digest of the shader fragments (sources) and of the emitter, which generates modules from them.
    generator_digest: Arc<str>,
    renderer_preference: RendererPreference,
    /// The data files dropped on the window.
    data_layers: Vec<Arc<DataLayer>>,
}

impl DrawnWith {
    /// What an image that is drawn now depends on.
    pub(crate) fn now(session: &Session) -> Self {
        let (_, renderer_preference) = session.renderers();
        Self { generator_digest: session.library().generator_digest(), renderer_preference, data_layers: session.catalog().data_layers() }
    }
}

impl PartialEq for DrawnWith {
    fn eq(&self, other: &Self) -> bool {
        // A layer never changes, and a file that is dropped again becomes a new layer. So the address of a layer identifies it.
        let is_same_layer = |(a, b): (&Arc<DataLayer>, &Arc<DataLayer>)| Arc::ptr_eq(a, b);
        (&self.generator_digest, self.renderer_preference) == (&other.generator_digest, other.renderer_preference)
            && self.data_layers.len() == other.data_layers.len()
            && self.data_layers.iter().zip(&other.data_layers).all(is_same_layer)
    }
}
