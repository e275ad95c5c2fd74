//! The source tree itself: module layers, circular imports, file lengths, package sizes.

use std::path::{Path, PathBuf};

mod dependencies;
mod imports_and_sizes;
mod layering;
mod packages;
mod source_tree;

/// The files below a folder with one of these extensions, in order.
fn files_below(dir: &Path, extensions: &[&str], out: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = std::fs::read_dir(dir).expect("readable").map(|e| e.expect("entry").path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files_below(&path, extensions, out);
        } else if path.extension().is_some_and(|e| extensions.iter().any(|x| e == *x)) {
            out.push(path);
        }
    }
}

/// Compares violations with the lines `RULE: VIOLATION` of tolerated.txt. Reports new violations, and lines that no longer apply; there
/// must be neither, so that the list only shrinks.
fn list_changes(rule: &str, found: &[String], tolerated: &str) -> Vec<String> {
    let tolerated: Vec<&str> = tolerated.lines().filter_map(|l| l.strip_prefix(rule)?.strip_prefix(": ")).collect();
    let new = found.iter().filter(|f| !tolerated.contains(&f.as_str())).map(|f| format!("new violation: {rule}: {f}"));
    let gone = tolerated
        .iter()
        .filter(|t| !found.iter().any(|f| f == *t))
        .map(|t| format!("no longer applies, remove it from tolerated.txt: {rule}: {t}"));
    new.chain(gone).collect()
}

/// Fails unless a rule finds exactly the violations that tests/project/tolerated.txt lists for it.
fn assert_only_tolerated(rule: &str, found: &[String]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/project/tolerated.txt");
    let changes = list_changes(rule, found, &std::fs::read_to_string(path).expect("the list"));
    assert!(changes.is_empty(), "{}", changes.join("\n"));
}

#[test]
fn the_list_of_tolerated_violations_only_shrinks() {
    let found = ["a".to_owned(), "b".to_owned()];
    assert!(list_changes("long", &found, "# head\nlong: b\nlong: a\nwide: c\n").is_empty());
    assert_eq!(list_changes("long", &found, "long: a\nwide: b"), ["new violation: long: b"]);
    assert_eq!(list_changes("long", &found[..1], "long: a\nlong: b"), ["no longer applies, remove it from tolerated.txt: long: b"]);
}

/// Files that a table of tests/README.md names: `folder/file`, `folder/{a,b}` and `folder/*`.
fn named_in_table(readme: &str, all: &[String]) -> Vec<String> {
    let mut named = Vec::new();
    for pattern in readme.lines().filter(|l| l.starts_with('|')).flat_map(|l| l.split('`').skip(1).step_by(2)) {
        let Some((folder, files)) = pattern.split_once('/') else { continue };
        match files.trim_matches(['{', '}']) {
            "*" => named.extend(all.iter().filter(|f| f.starts_with(&format!("{folder}/"))).cloned()),
            files => named.extend(files.split(',').filter(|f| !f.is_empty()).map(|f| format!("{folder}/{f}"))),
        }
    }
    named
}

#[test]
fn the_readme_of_the_tests_names_each_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let mut files = Vec::new();
    files_below(&root, &["rs"], &mut files);
    let name = |f: &PathBuf| f.strip_prefix(&root).expect("below").with_extension("").to_string_lossy().replace('\\', "/");
    let all: Vec<String> = files
        .iter()
        .map(name)
        .filter(|n| n != "main" && !n.ends_with("/mod") && !n.starts_with("support/") && !n.starts_with("reference_compiler/"))
        .collect();
    let named = named_in_table(&std::fs::read_to_string(root.join("README.md")).expect("a README"), &all);
    let missing: Vec<_> = all.iter().filter(|f| !named.contains(f)).collect();
    let nonexistent: Vec<_> = named.iter().filter(|f| !all.contains(f)).collect();
    assert!(missing.is_empty() && nonexistent.is_empty(), "not named: {missing:?}; named, but not there: {nonexistent:?}");
    assert_eq!(named_in_table("| x | `a/{b,c}`, `d/*` |", &["d/e".into()]), ["a/b", "a/c", "d/e"]);
}

#[test]
fn the_readme_of_the_tables_names_each_file() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let mut files = Vec::new();
    files_below(&folder, &["json"], &mut files);
    let names: Vec<_> = files.iter().map(|file| file.strip_prefix(&folder).expect("below").to_string_lossy()).collect();
    let readme = std::fs::read_to_string(folder.join("README.md")).expect("a README");
    let missing: Vec<_> = names.iter().filter(|name| !readme.contains(&format!("| {name} |"))).collect();
    assert!(names.len() > 5 && missing.is_empty(), "not named: {missing:?} of {names:?}");
}
