//! Tests of the messages in src/message/english.ftl: each message that a source file names exists in English, with the arguments that the source file
//! gives, and each English message is used.

use crate::message::ENGLISH_FILE;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Appends the path and the code, without unit tests, of each source file below a folder.
fn sources(folder: &Path, out: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if entry.is_dir() {
            sources(&entry, out);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&entry).expect("a source");
            let code = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default().to_owned();
            out.push((entry.display().to_string(), code));
        }
    }
}

/// The calls of a macro in a source file: the literal with which each begins, and the names of the arguments after it. `opening`: `reason!(` or `message!(`.
fn calls<'c>(code: &'c str, opening: &str) -> Vec<(&'c str, BTreeSet<&'c str>)> {
    let mut found = Vec::new();
    for call in code.split(opening).skip(1) {
        let Some((id, rest)) = call.trim_start().strip_prefix('"').and_then(|call| call.split_once('"')) else { continue };
        // Depth 0 is directly inside the call's own parentheses; string literals are skipped. `start` is the index at which the current argument begins.
        let (mut depth, mut in_literal, mut start, mut names) = (0, false, 0, BTreeSet::new());
        for (index, c) in rest.char_indices() {
            match c {
                '"' => in_literal = !in_literal,
                _ if in_literal => {}
                '(' | '[' | '{' => depth += 1,
                ')' | ']' | '}' if depth == 0 => break,
                ')' | ']' | '}' => depth -= 1,
                ',' if depth == 0 => start = index + 1,
                '=' if depth == 0 && !rest[start..index].contains('=') => {
                    let name = rest[start..index].trim();
                    if !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_') && !rest[index..].starts_with("==") {
                        names.insert(name);
                    }
                }
                _ => {}
            }
        }
        found.push((id, names));
    }
    found
}

/// The names of the arguments of each English message, by its id.
fn known_messages() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let names = |template: &'static str| template.split("{ $").skip(1).filter_map(|part| Some(part.split_once(" }")?.0)).collect();
    let lines = ENGLISH_FILE.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(" = "));
    lines.map(|(id, template)| (id, names(template))).collect()
}

#[test]
fn each_message_is_used_and_each_used_message_exists_with_its_arguments() {
    let known = known_messages();
    let mut all = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut all);
    let mut used = BTreeSet::new();
    // The module `message` and this file contain calls that are only examples.
    let has_examples = |path: &str| path.contains("src/message/") || path.ends_with("message_tests.rs");
    for (path, code) in all.iter().filter(|(path, _)| !has_examples(path)) {
        for (opening, prefix) in [("reason!(", "reason-"), ("message!(", "")] {
            for (id, arguments) in calls(code, opening) {
                let id = format!("{prefix}{id}");
                assert_eq!(known.get(id.as_str()), Some(&arguments), "{path}: {id}");
                used.insert(id);
            }
        }
    }
    // Ids of the names of bodies, compass points and months are composed at run time.
    let is_composed_at_run_time = |id: &str| ["body-", "compass-", "month-"].iter().any(|kind| id.starts_with(kind));
    // Some ids are string literals outside the macros, such as those of the quantities that have stated errors.
    let is_quoted = |id: &str| all.iter().any(|(_, code)| code.contains(&format!("\"{id}\"")));
    let unused: Vec<_> = known.keys().filter(|id| !used.contains(**id) && !is_quoted(id) && !is_composed_at_run_time(id)).collect();
    assert!(unused.is_empty(), "no source uses {unused:?}");
    assert_eq!(known.len(), ENGLISH_FILE.lines().filter(|line| line.contains(" = ")).count(), "an id occurs twice");
}

#[test]
fn calls_are_read_with_their_arguments() {
    let code = r#"f(reason!(x.0), reason!("one"), reason!( "two", a = g(b, c = 1), names = format_args!("{x:.2}, d = 3")))"#;
    assert_eq!(calls(code, "reason!("), [("one", BTreeSet::new()), ("two", BTreeSet::from(["a", "names"]))]);
}
