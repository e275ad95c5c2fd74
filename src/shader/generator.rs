//! The generator digest: a digest of everything on which a stored module depends, together called the generator.
//!
//! In: the Rust sources that determine a module's key, text and stored form; the fragments; the versions of naga and of the WESL parser; and the digest of the
//! lowering, the step from a module's IR to the tape of the software renderer (`shader` may not use the renderer, so the caller passes this digest in). Out: 16
//! hexadecimal digits, which name the library's folder on disk. Always: a change of any of these gives another folder, so a module that
//! older sources or packages produced is never read. Not included: sources that do not affect a module ([`EXCLUDED`]).

use super::fragments::Fragments;
use sha2::{Digest, Sha256};

macro_rules! sources {
    ($($name:literal),* $(,)?) => {
        /// The Rust sources that determine a module's key, text and stored form: path inside src/, and content.
        pub static SOURCES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../", $name)))),*];
    };
}

sources![
    "scene/constants.rs",
    "scene/draw/mod.rs",
    "scene/draw/features.rs",
    "shader/constants.rs",
    "shader/emit.rs",
    "shader/fragments.rs",
    "shader/generator.rs",
    "shader/id.rs",
    "shader/key/canonical.rs",
    "shader/key/dimension.rs",
    "shader/key/mod.rs",
    "shader/key/text.rs",
    "shader/library/entry.rs",
    "shader/library/mod.rs",
    "shader/mod.rs",
    "shader/module.rs",
    "shader/reflect.rs",
    "shader/source/block.rs",
    "shader/source/condition.rs",
    "shader/source/fragment.rs",
    "shader/source/limits.rs",
    "shader/source/mod.rs",
    "shader/source/own_names.rs",
    "shader/source/predicates.rs",
    "shader/source/scan.rs",
    "shader/source_map.rs",
];

/// Sources of `shader` that do not affect a module: they translate, compare or record finished modules, or list keys for tests.
pub const EXCLUDED: &[&str] = &["shader/compare.rs", "shader/key/covering.rs", "shader/record.rs", "shader/translate.rs"];

const LOCK_FILE: &str = include_str!("../../Cargo.lock");

/// naga's version, from the lock file with which this program was built; `None` if it names no naga.
pub fn naga_version() -> Option<&'static str> {
    version_in(LOCK_FILE, "naga")
}

/// The version of a package in the text of a lock file, where it stands on the line after the package's name; `None` if there is no such package.
fn version_in<'a>(lock: &'a str, package: &str) -> Option<&'a str> {
    let mut lines = lock.lines();
    lines.find(|l| *l == format!("name = \"{package}\""))?;
    lines.next()?.strip_prefix("version = \"")?.strip_suffix('"')
}

/// The generator digest (16 hexadecimal digits) for the built-in fragments. `lowering_digest`: [`Lowering::digest`](super::Lowering::digest).
pub fn digest(lowering_digest: &str) -> String {
    digest_with(&Fragments::default(), lowering_digest)
}

/// As [`digest`], for the given fragments.
pub fn digest_with(fragments: &Fragments, lowering_digest: &str) -> String {
    let version = |package| version_in(LOCK_FILE, package).unwrap_or("unknown");
    let versions_and_lowering = [("naga", version("naga")), ("wgsl-parse", version("wgsl-parse")), ("lowering", lowering_digest)];
    digest_of_pairs(SOURCES.iter().copied().chain(fragments.all()).chain(versions_and_lowering))
}

/// SHA-256 over pairs of a name and a text; the first 16 hexadecimal digits.
fn digest_of_pairs<'a>(parts: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let mut hash = Sha256::new();
    for (name, text) in parts {
        // Length-prefixed, so that different lists never give the same bytes.
        for part in [name, text] {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
    }
    hex(&hash.finalize()[..8])
}

/// Lower-case hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::super::fragments::FRAGMENTS;
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    /// Adds the paths, relative to `root`, of the files below `dir` with this extension.
    fn files_under(dir: &Path, extension: &str, found: &mut BTreeSet<String>, root: &Path) {
        for entry in std::fs::read_dir(dir).expect("readable").flatten() {
            let path = entry.path();
            if path.is_dir() {
                files_under(&path, extension, found, root);
            } else if path.extension().is_some_and(|e| e == extension) {
                let relative = path.strip_prefix(root).expect("below the root");
                found.insert(relative.to_string_lossy().replace('\\', "/"));
            }
        }
    }

    #[test]
    fn no_source_and_no_fragment_is_left_out() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        // Those outside src/shader, then all inside.
        let mut sources = BTreeSet::from(["scene/constants.rs", "scene/draw/mod.rs", "scene/draw/features.rs"].map(str::to_owned));
        files_under(&root.join("src/shader"), "rs", &mut sources, &root.join("src"));
        let named = SOURCES.iter().map(|(n, _)| *n).chain(EXCLUDED.iter().copied());
        assert_eq!(sources, named.map(str::to_owned).collect());
        assert_eq!(sources.len(), SOURCES.len() + EXCLUDED.len(), "no source is named twice");
        let mut fragments = BTreeSet::new();
        files_under(&root.join("shaders"), "wesl", &mut fragments, &root.join("shaders"));
        // The fragments in constants/ are generated by Rust (`shader::constants`) and also stored as files, which must be the same.
        for (path, text) in FRAGMENTS.iter() {
            let file = std::fs::read_to_string(root.join("shaders").join(path)).unwrap_or_default();
            assert!(
                file == *text,
                "shaders/{path} differs from the text that Rust generates: `orrery shader export shaders --overwrite` rewrites it"
            );
        }
        assert_eq!(fragments, FRAGMENTS.iter().map(|(n, _)| (*n).to_owned()).collect());
    }

    #[test]
    fn the_lock_file_names_naga() {
        let version = naga_version().expect("naga is locked");
        assert!(version.split('.').count() == 3 && version.split('.').all(|n| n.parse::<u32>().is_ok()), "{version}");
        // A package whose name only begins with the other's is another package.
        assert_eq!(version_in("name = \"naga-types\"\nversion = \"1.0.0\"\n", "naga"), None);
    }

    #[test]
    fn files_equal_to_built_in_fragments_leave_the_digest_unchanged() {
        let lowering_digest = "x";
        let file = |path: &str, text: &str| (path.to_owned(), text.to_owned());
        let (path, text) = FRAGMENTS[0];
        assert_eq!(digest_with(&Fragments::with_files([file(path, text)]), lowering_digest), digest(lowering_digest));
        let changed = Fragments::with_files([file(path, "// nothing")]);
        let new = Fragments::with_files([file("lib/new.wesl", "// nothing")]);
        assert_eq!((changed.text(path), changed.text("lib/new.wesl")), (Some("// nothing"), None));
        assert_eq!((new.text(path), new.text("lib/new.wesl")), (Some(text), Some("// nothing")));
        let all = [digest(lowering_digest), digest_with(&changed, lowering_digest), digest_with(&new, lowering_digest)];
        assert_eq!(BTreeSet::from(all).len(), 3);
    }

    #[test]
    fn any_change_changes_the_digest() {
        let base = digest_of_pairs([("a", "1"), ("b", "2")].into_iter());
        let others = [
            digest_of_pairs([("a", "1"), ("b", "3")].into_iter()),
            digest_of_pairs([("a", "1"), ("c", "2")].into_iter()),
            // The same letters, divided otherwise.
            digest_of_pairs([("a", "1b"), ("", "2")].into_iter()),
            digest_of_pairs([("a", "1")].into_iter()),
        ];
        assert_ne!(digest("x"), digest("y"), "the lowering is part of it");
        assert!(others.iter().all(|d| *d != base));
        assert_eq!(base.len(), 16);
    }
}
