//! One entry on disk: an encoded module with a checksum.
//!
//! Layout: a header of 8 bytes of magic, the last of which is the format's version, and 32 bytes of checksum, the SHA-256 of the rest; then the content, the
//! postcard encoding of generator digest (`shader::generator`), module name, WGSL, naga's IR, source map and tape (the module's program for the software
//! renderer). Always: bytes that [`decode`] accepts are complete, contain this program's generator digest and the name of the requested module, and contain
//! valid IR and a tape that fits its entry points. The checksum is not a signature: anyone who can write to the folder can write an entry that passes these
//! checks. naga's encoding omits spans, which matter only for error messages.

use crate::shader::module::validate;
use crate::shader::{Layout, Lowering, ModuleId, ShaderModule, SourceMap};
use crate::unwinding::catch_panic;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The first bytes of an entry: its kind and, in the last byte, the version of this format.
const MAGIC: [u8; 8] = *b"ORRSHD\x00\x02";
/// Position of the checksum in an entry.
const CHECKSUM: std::ops::Range<usize> = 8..40;

/// What is wrong with an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EntryError {
    #[error("it is shorter than its header")]
    Truncated,
    #[error("it is not of this program's format")]
    Foreign,
    #[error("its checksum is wrong")]
    Checksum,
    #[error("it was written by another generator, or for another module")]
    OtherGeneratorOrModule,
    #[error("its content does not decode")]
    Content,
    #[error("its module is not valid")]
    Module,
    #[error("its tape is not that of its module")]
    Tape,
}

/// The first fields of an entry's content, which can be decoded without the rest.
#[derive(Serialize, Deserialize)]
struct Identity {
    generator_digest: String,
    module_name: String,
}

#[derive(Serialize)]
struct EncodedModule<'a> {
    wgsl: &'a str,
    /// naga's IR.
    module: &'a naga::Module,
    source_map: &'a SourceMap,
    tape: &'a [u8],
}

#[derive(Deserialize)]
struct DecodedModule {
    wgsl: String,
    /// naga's IR.
    module: naga::Module,
    source_map: SourceMap,
    tape: Vec<u8>,
}

/// The bytes of an entry; `None` if postcard cannot encode the module.
pub fn encode(generator_digest: &str, ShaderModule { id, wgsl, module, source_map, tape, .. }: &ShaderModule) -> Option<Vec<u8>> {
    let identity = Identity { generator_digest: generator_digest.to_owned(), module_name: id.to_string() };
    let encoded_module = EncodedModule { wgsl, module, source_map, tape };
    let content = postcard::to_stdvec(&(identity, encoded_module)).ok()?;
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&Sha256::digest(&content));
    bytes.extend_from_slice(&content);
    Some(bytes)
}

/// The content of an entry, which follows the header, if magic and checksum are right.
fn checked_content(bytes: &[u8]) -> Result<&[u8], EntryError> {
    let (Some(magic), Some(checksum), Some(content)) = (bytes.get(..MAGIC.len()), bytes.get(CHECKSUM), bytes.get(CHECKSUM.end..)) else {
        return Err(EntryError::Truncated);
    };
    if magic != MAGIC {
        return Err(EntryError::Foreign);
    }
    if Sha256::digest(content).as_slice() != checksum {
        return Err(EntryError::Checksum);
    }
    Ok(content)
}

/// The name of the module in an entry that the generator with this digest wrote; an error if the entry is damaged or another generator wrote it.
pub fn module_name_if_written_by(generator_digest: &str, bytes: &[u8]) -> Result<String, EntryError> {
    let (identity, _) = postcard::take_from_bytes::<Identity>(checked_content(bytes)?).map_err(|_| EntryError::Content)?;
    if identity.generator_digest == generator_digest { Ok(identity.module_name) } else { Err(EntryError::OtherGeneratorOrModule) }
}

/// The name of the module in an entry of any generator.
pub fn module_name(bytes: &[u8]) -> Result<String, EntryError> {
    let (identity, _) = postcard::take_from_bytes::<Identity>(checked_content(bytes)?).map_err(|_| EntryError::Content)?;
    Ok(identity.module_name)
}

/// The module `id` from an entry that the generator with this digest wrote. All checks of the module comment are made; `lowering` checks the tape.
pub fn decode(generator_digest: &str, id: &ModuleId, bytes: &[u8], lowering: &Lowering) -> Result<ShaderModule, EntryError> {
    // naga's and postcard's deserialization of arenas may panic on input that naga did not write.
    catch_panic(|| decode_unguarded(Some(generator_digest), id, bytes, lowering)).unwrap_or(Err(EntryError::Content))
}

/// The module in an entry that another generator may have written, for inspection and comparison only. If this program's software renderer cannot
/// run its tape, the module is lowered again.
pub fn decode_of_any_generator(id: &ModuleId, bytes: &[u8], lowering: &Lowering) -> Result<ShaderModule, EntryError> {
    let unchecked_lowering = Lowering { check: |_, _| Ok(()), ..lowering.clone() };
    let mut module = catch_panic(|| decode_unguarded(None, id, bytes, &unchecked_lowering)).unwrap_or(Err(EntryError::Content))?;
    let is_runnable = catch_panic(|| (lowering.check)(&module.module, &module.tape).is_ok()).unwrap_or(false);
    if !is_runnable {
        module.tape = (lowering.lower)(&module.module, &module.info).map_err(|_| EntryError::Tape)?;
    }
    Ok(module)
}

/// Decodes and checks an entry; may panic on input that naga did not write. `generator_digest`: `None` accepts any generator.
fn decode_unguarded(generator_digest: Option<&str>, id: &ModuleId, bytes: &[u8], lowering: &Lowering) -> Result<ShaderModule, EntryError> {
    let (identity, rest) = postcard::take_from_bytes::<Identity>(checked_content(bytes)?).map_err(|_| EntryError::Content)?;
    // Another generator may have written the module under a former name. Parsing replaces former names by present ones.
    let is_requested = || identity.module_name == id.to_string() || identity.module_name.parse::<ModuleId>().ok().as_ref() == Some(id);
    if generator_digest.is_some_and(|g| identity.generator_digest != g) || !is_requested() {
        return Err(EntryError::OtherGeneratorOrModule);
    }
    let (decoded, rest): (DecodedModule, _) = postcard::take_from_bytes(rest).map_err(|_| EntryError::Content)?;
    let DecodedModule { wgsl, module, source_map, tape } = decoded;
    // The source map has one entry for each line of the WGSL.
    if !rest.is_empty() || wgsl.lines().count() != source_map.lines.len() {
        return Err(EntryError::Content);
    }
    let info = validate(&module).map_err(|_| EntryError::Module)?;
    let layout = Layout::of(&module).map_err(|_| EntryError::Module)?;
    (lowering.check)(&module, &tape).map_err(|_| EntryError::Tape)?;
    Ok(ShaderModule { id: id.clone(), wgsl, module, info, layout, source_map, tape })
}

/// Length in bytes of the longest module name that is used unchanged in the file name: well below the 255 bytes that most file systems allow, as some allow
/// fewer, and the name gets an extension.
const MAX_UNCHANGED_NAME_BYTES: usize = 180;
/// Number of characters at the start of a longer name that the file name contains. A hyphen and a digest of the whole name, 16
/// hexadecimal digits, follow; together they stay below [`MAX_UNCHANGED_NAME_BYTES`].
const SHORTENED_NAME_CHARS: usize = 150;

/// File name of a module's entry.
pub fn file_name(id: &ModuleId) -> String {
    format!("{}.{EXTENSION}", file_stem(id))
}

/// Name of a module's files (its entry, and its files in the atlas and the corpus), without the extension: the module's name or, if it is too long, its start
/// and a digest.
pub(crate) fn file_stem(id: &ModuleId) -> String {
    let name = id.to_string();
    if name.len() <= MAX_UNCHANGED_NAME_BYTES {
        return name;
    }
    let digest = crate::shader::generator::hex(&Sha256::digest(&name)[..8]);
    format!("{}-{digest}", name.chars().take(SHORTENED_NAME_CHARS).collect::<String>())
}

/// File extension of entries.
pub const EXTENSION: &str = "shader";
