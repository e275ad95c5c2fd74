//! The lowering as the shader library takes it: a function and a digest of the code that decides what it yields.

use sha2::{Digest, Sha256};

/// Everything that decides how a module becomes a tape and what the tape means; the library's folder is named after it.
const LOWERING_SOURCES: &[&[u8]] = &[
    include_bytes!("../program.rs"),
    include_bytes!("../tape.rs"),
    include_bytes!("mod.rs"),
    include_bytes!("builder.rs"),
    include_bytes!("discard.rs"),
    include_bytes!("expr.rs"),
    include_bytes!("finish.rs"),
    include_bytes!("flow.rs"),
    include_bytes!("functions.rs"),
    include_bytes!("place.rs"),
    include_bytes!("../kernels/ops.rs"),
    include_bytes!("../kernels/chains.rs"),
    include_bytes!("chains.rs"),
    include_bytes!("../math/mod.rs"),
    include_bytes!("../math/double.rs"),
];

/// What the shader library needs to store tapes: the lowering and the digest of its code.
pub fn lowering() -> crate::shader::Lowering {
    let mut hash = Sha256::new();
    for source in LOWERING_SOURCES {
        hash.update((source.len() as u64).to_le_bytes());
        hash.update(source);
    }
    let digest = hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect();
    crate::shader::Lowering { digest, lower: super::lower_to_bytes }
}
