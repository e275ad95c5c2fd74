//! The shader key: a draw's features, reduced to the smallest set that draws the same image.
//!
//! In: the scene's [`DrawFeatures`]. Out: [`ShaderKey`], a plain value with a text form. Always: a key is canonical, so draws that differ only in features
//! without an effect on the image have equal keys. A dimension is one choice in a key, stored in one field of `DrawFeatures`. A table
//! ([`dimension::DIMENSIONS`]) gives each dimension its values, their texts, and the names that `@if` conditions of the WESL files test. A list
//! ([`canonical::RULES`]) states which values have no effect in combination with others. A new dimension needs a field of `DrawFeatures`, a row of the table
//! and its rules. Not here: the code of the module that a key identifies.

// Hidden from the documentation, like everything that is not part of the library's public interface (lib.rs).
#[doc(hidden)]
mod canonical;
#[doc(hidden)]
mod covering;
#[doc(hidden)]
mod dimension;
#[doc(hidden)]
mod text;

pub use canonical::{CanonicalRule, RULES, canonical, reductions};
pub use covering::{count_combinations, covering_keys, random_features, random_keys};
pub use dimension::{DIMENSIONS, Dimension, KeyPart, feature_names};
pub use text::KeyTextError;

use crate::scene::draw::{DrawFeatures, INSTRUCTIONS_PER_READ, PixelView};

/// The key of a body's module: emission is a pure function of this value and the WESL files of shaders/.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ShaderKey {
    features: DrawFeatures,
}

impl ShaderKey {
    /// The key of a draw.
    pub fn for_draw(features: &DrawFeatures) -> Self {
        Self { features: canonical(features) }
    }
    /// The features of the module, in canonical form: features of the draw that do not change the module are missing here. Culling and other pipeline state may
    /// depend on those, too, and therefore follow the draw's own features.
    pub fn features(&self) -> &DrawFeatures {
        &self.features
    }
    /// In the pixel view of shading cost, the number of instructions that one texture read counts as; `None` in the other views.
    pub fn instructions_per_read(&self) -> Option<f64> {
        (self.features.view == PixelView::Cost).then_some(INSTRUCTIONS_PER_READ)
    }
}

impl serde::Serialize for ShaderKey {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The keys of draws with these features, each once, sorted.
pub fn keys_of(features: impl IntoIterator<Item = DrawFeatures>) -> std::collections::BTreeSet<ShaderKey> {
    features.into_iter().map(|f| ShaderKey::for_draw(&f)).collect()
}
