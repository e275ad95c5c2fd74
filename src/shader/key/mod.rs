//! The shader key: a draw's features, reduced to the least that draws the same image.
//!
//! In: scene's [`DrawFeatures`]. Out: [`ShaderKey`], a plain value with a text form. Always holds: a key is canonical, so two draws that
//! would run the same code have equal keys. One table ([`dimension::DIMENSIONS`]) gives every dimension its values, texts and fragment
//! features; one list ([`canonical::RULES`]) says which values mean nothing beside which others. A new dimension is a field of `DrawFeatures`, a row
//! of the table and its rules. Not here: the code that a key stands for.

#[doc(hidden)]
mod canonical;
#[doc(hidden)]
mod covering;
#[doc(hidden)]
mod dimension;
#[doc(hidden)]
mod text;

pub use canonical::{CanonicalRule, RULES, canonical, reductions};
pub use covering::{covering, nominal_size, sample, sample_features};
pub use dimension::{DIMENSIONS, Dimension, Part, features};
pub use text::KeyTextError;

use crate::scene::draw::{DrawFeatures, INSTRUCTIONS_PER_READ, PixelView};

/// The whole truth about one planet module: emission is a pure function of this value and the fragments in shaders/.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ShaderKey {
    features: DrawFeatures,
}

impl ShaderKey {
    /// The key of a draw.
    pub fn for_draw(features: &DrawFeatures) -> Self {
        Self { features: canonical(features) }
    }
    /// What the module does, in canonical form. Culling and the like follow the draw's own features, which may say more.
    pub fn features(&self) -> &DrawFeatures {
        &self.features
    }
    /// Where the picture is the work that the shaded one takes, counted by the renderer: the instructions that a texture read is shown as.
    pub fn instructions_per_read(&self) -> Option<f64> {
        (self.features.view == PixelView::Cost).then_some(INSTRUCTIONS_PER_READ)
    }
}

impl serde::Serialize for ShaderKey {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The keys of these draws, each once, in order.
pub fn keys_of(features: impl IntoIterator<Item = DrawFeatures>) -> std::collections::BTreeSet<ShaderKey> {
    features.into_iter().map(|n| ShaderKey::for_draw(&n)).collect()
}
