//! The interface through which the shader library lowers and stores modules: the lowering functions and a digest of their sources.
//!
//! The digest is part of two names: of the library's folder, and of the file that records which modules a test run has verified. Therefore it covers
//! every source file on which a module's tape depends:
//! - `lower/`: the lowering itself;
//! - `kernels/` and `math/`: constants are folded by the operations that the kernels run, and fused kernels exist only for the chains in
//!   `kernels/chain_table.rs`;
//! - `tape.rs` and `program.rs`: the format that is stored.
//!
//! Complete folders are embedded, so that a new file in them is covered. Not covered: code that only runs tapes (`exec`, `sample`, `raster`, `shade`
//! and the rest of `render::software`) and does not change stored tapes. naga and the fragments (WESL source files) are covered by the digest of the shader
//! generator.

use include_dir::{Dir, include_dir};
use sha2::{Digest, Sha256};

static FOLDERS: [(&str, Dir<'_>); 3] = [
    ("kernels", include_dir!("$CARGO_MANIFEST_DIR/src/render/software/kernels")),
    ("lower", include_dir!("$CARGO_MANIFEST_DIR/src/render/software/lower")),
    ("math", include_dir!("$CARGO_MANIFEST_DIR/src/render/software/math")),
];
const FILES: [(&str, &[u8]); 2] = [("program.rs", include_bytes!("../program.rs")), ("tape.rs", include_bytes!("../tape.rs"))];

/// Every source file on which a tape depends, in order of path: its path inside render/software/ and its content.
fn sources() -> Vec<(String, &'static [u8])> {
    fn rust_files<'a>(name: &str, dir: &'a Dir<'a>, out: &mut Vec<(String, &'a [u8])>) {
        let rust = dir.files().filter(|f| f.path().extension().is_some_and(|e| e == "rs"));
        out.extend(rust.map(|f| (format!("{name}/{}", f.path().display()).replace('\\', "/"), f.contents())));
        dir.dirs().for_each(|d| rust_files(name, d, out));
    }
    let mut all: Vec<(String, &[u8])> = FILES.map(|(path, content)| (path.to_owned(), content)).into();
    FOLDERS.iter().for_each(|(name, dir)| rust_files(name, dir, &mut all));
    all.sort();
    all
}

fn digest_of(sources: &[(String, &[u8])]) -> String {
    let mut hash = Sha256::new();
    for (path, content) in sources {
        // Each part is prefixed with its length, so that different lists never give the same bytes.
        for part in [path.as_bytes(), content] {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
    }
    hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect()
}

/// The functions that the shader library needs to store tapes, and the digest of their code.
pub fn lowering() -> crate::shader::Lowering {
    crate::shader::Lowering { digest: digest_of(&sources()), lower: super::lower_to_bytes, check: super::check_bytes }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    /// Modules outside render/software whose sources the generator's digest covers.
    const COVERED_ELSEWHERE: [&str; 1] = ["shader"];

    fn identifier(text: &str) -> &str {
        text.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("")
    }

    /// Modules of render/software, and other top-level modules, that a source file names in its paths.
    fn modules_named_in(path: &str, text: &str) -> BTreeSet<String> {
        let text = text.split("#[cfg(test)]").next().unwrap_or("");
        let code: String = text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
        let mut named = BTreeSet::new();
        for (at, _) in code.match_indices("crate::") {
            let rest = &code[at + "crate::".len()..];
            named.insert(
                rest.strip_prefix("render::software::").map_or_else(|| format!("crate::{}", identifier(rest)), |r| identifier(r).into()),
            );
        }
        // In lower/x.rs, `super` is lower; in lower/mod.rs and tape.rs it is render::software.
        let supers_to_software = if path.contains('/') && !path.ends_with("/mod.rs") { 2 } else { 1 };
        for (at, _) in code.match_indices("super::") {
            let before = &code[..at];
            let super_count = 1 + (0..).take_while(|k| before.ends_with(&"super::".repeat(k + 1))).count();
            if super_count == supers_to_software {
                named.insert(identifier(&code[at + "super::".len()..]).to_owned());
            }
        }
        named.retain(|n| !n.is_empty() && n != "super");
        named
    }

    /// Modules that the sources name and that the digest does not cover.
    fn uncovered_modules(sources: &[(String, &[u8])]) -> BTreeSet<String> {
        let covered: BTreeSet<&str> = sources.iter().map(|(p, _)| p.split(['/', '.']).next().unwrap_or("")).collect();
        let texts = sources.iter().map(|(path, content)| (path, std::str::from_utf8(content).expect("UTF-8")));
        let named = texts.flat_map(|(path, text)| modules_named_in(path, text));
        named
            .filter(|n| !covered.contains(n.as_str()))
            .filter(|n| n.strip_prefix("crate::").is_none_or(|module| !COVERED_ELSEWHERE.contains(&module)))
            .collect()
    }

    #[test]
    fn every_file_of_the_folders_is_in_the_digest() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/render/software");
        let sources = sources();
        for (folder, _) in &FOLDERS {
            for entry in root.join(folder).read_dir().expect("a folder").flatten() {
                let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
                assert!(sources.iter().any(|(p, _)| *p == path), "{path}");
            }
        }
        for path in ["lower/loops.rs", "kernels/mod.rs", "math/double.rs", "tape.rs", "program.rs"] {
            assert!(sources.iter().any(|(p, _)| p == path), "{path}");
        }
    }

    #[test]
    fn every_module_that_the_sources_use_is_in_the_digest() {
        let all = sources();
        assert_eq!(uncovered_modules(&all), BTreeSet::new());
        // The check must find a folder that is missing from the digest, and a new dependency.
        for folder in ["kernels", "math", "tape", "program"] {
            let without: Vec<_> = all.iter().filter(|(p, _)| !p.starts_with(folder)).cloned().collect();
            assert!(uncovered_modules(&without).contains(folder), "{folder}");
        }
        for (path, new) in [
            ("lower/new.rs", "use crate::render::software::exec::Executor;"),
            ("lower/new.rs", "use super::super::exec;"),
            ("lower/mod.rs", "use super::exec;"),
        ] {
            assert_eq!(modules_named_in(path, new), BTreeSet::from(["exec".to_owned()]), "{path}: {new}");
        }
        assert_eq!(modules_named_in("lower/new.rs", "use super::builder::SsaValue;"), BTreeSet::new());
        // The path is joined at run time, because tests/project/layering.rs reads this file too.
        let elsewhere = ["use crate", "scene::draw;"].join("::");
        assert_eq!(modules_named_in("lower/new.rs", &elsewhere), BTreeSet::from([["crate", "scene"].join("::")]));
    }

    #[test]
    fn an_edit_of_any_source_changes_the_digest() {
        let all = sources();
        let edited = (0..all.len()).map(|k| {
            let mut edited = all.clone();
            edited[k].1 = b"// edited";
            digest_of(&edited)
        });
        let digests: BTreeSet<String> = edited.chain([digest_of(&all)]).collect();
        assert_eq!(digests.len(), all.len() + 1);
    }
}
