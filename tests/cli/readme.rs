//! The first example of README.md is what the program prints.

use super::stderr_text;
use std::process::Command;

/// What the program prints for a command of README.md, without the leading `$ orrery`.
fn printed(command: &str) -> String {
    let out = Command::new(crate::support::program::path())
        .args(command.split_whitespace())
        .arg("--cache")
        .arg(crate::support::scratch::program_cache())
        .output()
        .expect("starts");
    assert!(out.status.success(), "{command}: {}", stderr_text(&out));
    String::from_utf8(out.stdout).expect("UTF-8")
}

/// The list of keys is compared line by line, and the excerpt must be a part of the module that the last command prints.
#[test]
fn the_first_example_prints_what_readme_shows() {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).expect("README.md");
    let example: Vec<&str> = readme
        .lines()
        .skip_while(|line| !line.starts_with("    $ orrery "))
        .take_while(|line| line.starts_with("    "))
        .map(|line| &line[4..])
        .collect();
    let mut commands: Vec<(&str, String)> = Vec::new();
    for line in &example {
        if let Some(command) = line.strip_prefix("$ orrery ") {
            commands.push((command, String::new()));
        } else if let Some((_, shown)) = commands.last_mut() {
            shown.push_str(&format!("{line}\n"));
        }
    }
    let [(keys, shown_keys), (emit, shown_module)] = &commands[..] else { panic!("two commands expected: {commands:?}") };
    assert!(shown_keys.lines().count() > 1 && shown_module.is_empty(), "{commands:?}");
    assert_eq!(&printed(keys), shown_keys, "{keys}");
    let module = printed(emit);
    let excerpt = readme.split("```wgsl\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an excerpt");
    assert!(excerpt.lines().count() > 5 && module.contains(excerpt), "README.md shows another module:\n{module}");
    assert!(module.lines().count() > 500, "README.md says that it has more than 500 lines");
}
