//! Stores tables that take long to compute in files, under names derived from their code and inputs.
//!
//! In: the code and the inputs that determine a table, and its bytes. Out: a name that no other table has, and a file with magic number and checksum.
//! Always: a truncated or damaged file is treated as missing; a table that cannot be written is computed again by the next run. Not here: the contents of
//! tables.

use crate::files::{read_bytes, write_cached};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// The first bytes of a file: the kind of table and the version of its format.
pub(super) type Magic = [u8; 8];
/// Length of the checksum that follows the magic number, bytes: a SHA-256 of the table.
const CHECKSUM_BYTES: usize = 32;

/// The extension of a table's file.
pub(super) const EXTENSION: &str = "table";

/// The folder of a kind of tables. `cache`: the folder that contains, or will contain, the folder `orrery/`; `name`: the kind's.
pub(super) fn folder(cache: &Path, name: &str) -> PathBuf {
    cache.join("orrery").join(name)
}

/// The file of a table in the folder of its kind.
pub(super) fn file(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.{EXTENSION}"))
}

/// Digest of the sources that compute a table.
pub(super) fn code_digest(sources: &[&str]) -> [u8; 32] {
    let mut hash = Sha256::new();
    for text in sources {
        // The length precedes each text, so that different lists of texts never give the same bytes.
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    hash.finalize().into()
}

/// The name of a table: a digest of the code that computes it and of all its inputs. `code_digest`: see [`code_digest`].
pub(super) fn name(code_digest: &[u8; 32], inputs: impl IntoIterator<Item = f64>) -> String {
    let mut hash = Sha256::new();
    hash.update(code_digest);
    inputs.into_iter().for_each(|v| hash.update(v.to_le_bytes()));
    hash.finalize().iter().take(16).map(|b| format!("{b:02x}")).collect()
}

/// The file content for a table.
pub(super) fn encode(magic: &Magic, table: &[u8]) -> Vec<u8> {
    [magic.as_slice(), Sha256::digest(table).as_slice(), table].concat()
}

/// The table in a file's content; `None` if the content is damaged.
pub(super) fn decode<'a>(magic: &Magic, bytes: &'a [u8]) -> Option<&'a [u8]> {
    let (checksum, table) = bytes.strip_prefix(magic.as_slice())?.split_at_checked(CHECKSUM_BYTES)?;
    (Sha256::digest(table).as_slice() == checksum).then_some(table)
}

/// Reads a table of `length` bytes; `None` if the file is missing, damaged or has another length.
pub(super) fn read(path: &Path, magic: &Magic, length: usize) -> Option<Vec<u8>> {
    let bytes = read_bytes(path, (magic.len() + CHECKSUM_BYTES + length) as u64).ok()?;
    decode(magic, &bytes).filter(|table| table.len() == length).map(<[u8]>::to_vec)
}

/// Writes a table; if that fails, the next run computes it again.
pub(super) fn write(path: &Path, magic: &Magic, table: &[u8]) {
    drop(write_cached(path, &encode(magic, table)));
}

/// The floats in little-endian bytes.
pub(super) fn floats(bytes: &[u8]) -> impl Iterator<Item = f32> {
    bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b))
}

/// For the tests that a table's digest covers all code on which the table depends: the paths below `crate::scene` that occur in a source text, outside its unit
/// tests and comments.
#[cfg(test)]
pub(super) fn scene_modules_used(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or("").lines().map(|l| l.split("//").next().unwrap_or(""));
    let code = code.collect::<Vec<_>>().join("\n");
    let path = |rest: &str| -> String { rest.chars().take_while(|c| c.is_alphanumeric() || "_:".contains(*c)).collect() };
    // The path of a `use` with a list in braces ends with `::`, which is removed.
    let module = |path: String| path.trim_end_matches("::").to_owned();
    code.match_indices("crate::scene::").map(|(at, found)| module(path(&code[at + found.len()..]))).collect()
}
