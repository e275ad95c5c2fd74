//! The shader key.

use crate::scene::draw::Needs;

/// The whole truth about one planet module: emission is a pure function of this value and the fragments in shaders/.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ShaderKey {
    needs: Needs,
}

impl ShaderKey {
    /// The key of a draw, in canonical form.
    pub fn for_draw(needs: &Needs) -> Self {
        Self { needs: *needs }
    }
    pub fn needs(&self) -> &Needs {
        &self.needs
    }
}
