//! docs/dependencies.md gives a reason for each direct dependency, and lists no others.

use std::collections::BTreeSet;

fn read(path: &str) -> String {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(root.join(path)).expect(path)
}

/// Names in the dependency tables of a manifest.
fn direct_dependencies(manifest: &str) -> BTreeSet<String> {
    let manifest: toml::Table = manifest.parse().expect("TOML");
    let names = |table: Option<&toml::Value>| -> Vec<String> {
        table.and_then(toml::Value::as_table).map_or(Vec::new(), |t| t.keys().cloned().collect())
    };
    let targets = manifest.get("target").and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::values);
    let of_targets = targets.flat_map(|target| names(target.get("dependencies")));
    names(manifest.get("dependencies")).into_iter().chain(names(manifest.get("dev-dependencies"))).chain(of_targets).collect()
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
    let manifest = "[dependencies]\na = \"1\"\n[dev-dependencies]\nb = \"1\"\n[target.'cfg(unix)'.dependencies]\nc = \"1\"\n";
    assert_eq!(direct_dependencies(manifest), ["a", "b", "c"].map(str::to_owned).into());
    assert_eq!(dependencies_with_reason("| `a` | why it is there |\n| `b` |  |\n| library | what |\n"), ["a"].map(str::to_owned).into());
}
