//! docs/dependencies.md gives a reason for each direct dependency, and lists no others.

use std::collections::BTreeSet;

fn read(path: &str) -> String {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(root.join(path)).expect(path)
}

/// Names in the dependency tables of a manifest, for all targets and for each.
fn direct_dependencies(manifest: &str) -> BTreeSet<String> {
    let manifest: toml::Table = manifest.parse().expect("TOML");
    let targets = manifest.get("target").and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::values);
    let sections = targets.filter_map(toml::Value::as_table).chain([&manifest]);
    let tables = sections.flat_map(|section| ["dependencies", "dev-dependencies", "build-dependencies"].map(|kind| section.get(kind)));
    tables.flatten().filter_map(toml::Value::as_table).flat_map(toml::Table::keys).cloned().collect()
}

/// Names in the first column of the document's tables, if the second column has a reason.
fn dependencies_with_reason(text: &str) -> BTreeSet<String> {
    let rows = text.lines().filter_map(|l| l.strip_prefix("| `")?.split_once("` | "));
    rows.filter(|(_, why)| why.trim_end_matches(" |").len() > 5).map(|(name, _)| name.to_owned()).collect()
}

#[test]
fn each_direct_dependency_has_its_reason() {
    let mut direct = direct_dependencies(&read("Cargo.toml"));
    direct.extend(direct_dependencies(&read("tests/reference_compiler/Cargo.toml")).into_iter().filter(|name| name != "orrery"));
    assert_eq!(direct, dependencies_with_reason(&read("docs/dependencies.md")));
}

#[test]
fn a_dependency_without_a_reason_is_detected() {
    let tables = ["dependencies", "dev-dependencies", "build-dependencies", "target.'cfg(unix)'.dependencies", "target.x.dev-dependencies"];
    let manifest: String = tables.into_iter().zip('a'..).map(|(table, name)| format!("[{table}]\n{name} = \"1\"\n")).collect();
    assert_eq!(direct_dependencies(&manifest), ["a", "b", "c", "d", "e"].map(str::to_owned).into());
    assert_eq!(dependencies_with_reason("| `a` | why it is there |\n| `b` |  |\n| library | what |\n"), ["a"].map(str::to_owned).into());
}
