//! Files of tables that take long to compute: their names and their form.
//!
//! In: the code and the inputs that determine a table, and its bytes. Out: a name that another table never has, and a file whose bytes are the table's or
//! nothing. Always: a truncated or damaged file reads as none; one that cannot be written is computed again by the next run. Not here: what a table holds.

use crate::files::{read_bytes, write_cached};
use sha2::{Digest, Sha256};
use std::path::Path;

/// What a file begins with: its kind and the version of its form.
pub(super) type Magic = [u8; 8];
/// Bytes of the checksum after that.
const CHECKSUM: usize = 32;

/// Digest of the sources that compute a table.
pub(super) fn code_digest(sources: &[&str]) -> [u8; 32] {
    let mut hash = Sha256::new();
    for text in sources {
        // Lengths in front, so that no two lists run together to the same bytes.
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    hash.finalize().into()
}

/// The name of a table: a digest of the code that computes it and of all its inputs.
pub(super) fn name(code: &[u8; 32], inputs: impl IntoIterator<Item = f64>) -> String {
    let mut hash = Sha256::new();
    hash.update(code);
    inputs.into_iter().for_each(|v| hash.update(v.to_le_bytes()));
    hash.finalize().iter().take(16).map(|b| format!("{b:02x}")).collect()
}

/// The bytes of a file.
pub(super) fn encode(magic: &Magic, table: &[u8]) -> Vec<u8> {
    [magic.as_slice(), Sha256::digest(table).as_slice(), table].concat()
}

/// The table in the bytes of a file.
pub(super) fn decode<'a>(magic: &Magic, bytes: &'a [u8]) -> Option<&'a [u8]> {
    let (sum, table) = bytes.strip_prefix(magic.as_slice())?.split_at_checked(CHECKSUM)?;
    (Sha256::digest(table).as_slice() == sum).then_some(table)
}

/// The table of a file, which has this many bytes.
pub(super) fn read(path: &Path, magic: &Magic, length: usize) -> Option<Vec<u8>> {
    let bytes = read_bytes(path, (magic.len() + CHECKSUM + length) as u64).ok()?;
    decode(magic, &bytes).filter(|table| table.len() == length).map(<[u8]>::to_vec)
}

/// Writes a table; if that fails, the next run computes it again.
pub(super) fn write(path: &Path, magic: &Magic, table: &[u8]) {
    drop(write_cached(path, &encode(magic, table)));
}

/// Floats in little-endian order.
pub(super) fn floats(bytes: &[u8]) -> impl Iterator<Item = f32> {
    bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b))
}

/// Parts of `crate::scene` that sources name outside their tests and comments, by module.
#[cfg(test)]
pub(super) fn scene_modules_used(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or("").lines().map(|l| l.split("//").next().unwrap_or(""));
    let code = code.collect::<Vec<_>>().join("\n");
    let path = |rest: &str| -> String { rest.chars().take_while(|c| c.is_alphanumeric() || "_:".contains(*c)).collect() };
    // In a `use` list the module's path ends before the braces.
    let module = |path: String| path.trim_end_matches("::").to_owned();
    code.match_indices("crate::scene::").map(|(at, found)| module(path(&code[at + found.len()..]))).collect()
}
