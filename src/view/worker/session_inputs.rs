//! The inputs of an image, or of the answer to a query, that come from the session and not from the request: shader fragments, the choice of renderer, data
//! files dropped on the window.
//!
//! In: a session. Out: its [`SessionInputs`], to be compared with earlier ones; the two differ if one of these inputs has changed. Always: whoever stores an
//! answer with its request also stores the `SessionInputs` of the answer, and asks again when the current ones differ.

use crate::catalog::DataLayer;
use crate::session::{RendererPreference, Session};
use std::sync::Arc;

/// The session's inputs of an image, or of the answer to a query.
#[derive(Clone)]
pub(crate) struct SessionInputs {
    /// Digest of the shader fragments (sources) and of the emitter, which generates modules from them.
    generator_digest: Arc<str>,
    renderer_preference: RendererPreference,
    /// The data files dropped on the window.
    data_layers: Vec<Arc<DataLayer>>,
}

impl SessionInputs {
    /// The inputs of an image that is drawn now.
    pub(crate) fn of(session: &Session) -> Self {
        let (_, renderer_preference) = session.renderers();
        Self { generator_digest: session.library().generator_digest(), renderer_preference, data_layers: session.catalog().data_layers() }
    }
}

impl PartialEq for SessionInputs {
    fn eq(&self, other: &Self) -> bool {
        // A layer never changes, and a file that is dropped again becomes a new layer. So the address of a layer identifies it.
        let is_same_layer = |(a, b): (&Arc<DataLayer>, &Arc<DataLayer>)| Arc::ptr_eq(a, b);
        (&self.generator_digest, self.renderer_preference) == (&other.generator_digest, other.renderer_preference)
            && self.data_layers.len() == other.data_layers.len()
            && self.data_layers.iter().zip(&other.data_layers).all(is_same_layer)
    }
}
