//! The layer table of ARCHITECTURE.md, checked against every module path in src/: `crate::`, `orrery::`, `super::super::`, and paths to
//! child modules.

use super::assert_only_tolerated;
use super::source_tree::{NamedPath, SourceFile, SourceTree, code_of};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// (module path prefix, modules of this crate that it may name, crates and library modules that it may not name).
const TABLE: &[(&str, &[&str], &[&str])] = &[
    ("units", &[], &["naga", "wgpu", "winit", "softbuffer"]),
    ("wording", &[], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("json", &["wording"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("message", &["message"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("random", &[], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("unwinding", &[], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("files", &["files", "wording"], &["naga", "wgpu", "winit", "softbuffer"]),
    ("time", &["units", "time", "wording"], &["naga", "wgpu", "winit", "softbuffer"]),
    ("catalog", &["units", "time", "catalog", "random", "wording", "message"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("ephemeris", &["units", "time", "catalog", "ephemeris", "unwinding", "message"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("events", &["units", "time", "catalog", "ephemeris", "scene", "events"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("memo", &["memo"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("mesh", &["units", "mesh", "wording"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    (
        "scene",
        &["units", "time", "catalog", "ephemeris", "mesh", "memo", "scene", "wording", "message"],
        &["naga", "wgpu", "winit", "softbuffer", "std::fs"],
    ),
    ("image", &["units", "files", "image", "unwinding"], &["naga", "wgpu", "winit", "softbuffer"]),
    ("shader/key", &["scene::draw", "shader::key", "random", "wording"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("shader", &["scene::draw", "shader", "files", "memo", "unwinding", "wording"], &["wgpu", "winit", "softbuffer", "rayon::spawn"]),
    ("render/plan", &["scene", "shader", "image", "render::plan"], &["wgpu", "winit", "softbuffer", "std::fs"]),
    ("render/frame", &["image", "render::frame"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    (
        "session",
        &["units", "time", "catalog", "ephemeris", "mesh", "memo", "scene", "shader", "render", "image", "session", "files", "wording"],
        &["naga", "wgpu", "winit", "softbuffer"],
    ),
    (
        "probe",
        &["units", "time", "catalog", "ephemeris", "scene", "shader", "render", "image", "session", "probe", "json", "wording"],
        &["naga", "wgpu", "winit", "softbuffer", "std::fs"],
    ),
    (
        "measure",
        &["units", "time", "catalog", "ephemeris", "scene", "render", "image", "session", "measure"],
        &["naga", "wgpu", "winit", "softbuffer", "std::fs"],
    ),
    (
        "stability",
        &[
            "units",
            "time",
            "catalog",
            "ephemeris",
            "events",
            "random",
            "scene",
            "shader",
            "render",
            "image",
            "session",
            "probe",
            "measure",
            "stability",
        ],
        &["naga", "wgpu", "winit", "softbuffer", "std::fs"],
    ),
    (
        "export",
        &["units", "scene::draw", "shader", "render", "image", "session", "files", "wording", "export"],
        &["naga", "wgpu", "winit", "egui", "softbuffer"],
    ),
    (
        "view",
        &[
            "units",
            "time",
            "catalog",
            "ephemeris",
            "events",
            "scene",
            "shader",
            "render::plan",
            "image",
            "session",
            "probe",
            "measure",
            "view",
            "files",
            "json",
            "wording",
            "message",
        ],
        &["naga", "wgpu"],
    ),
    (
        "render/gpu",
        &["shader", "image", "render::plan", "render::frame", "render::gpu"],
        &["naga", "winit", "softbuffer", "std::fs", "rayon"],
    ),
    (
        "render/software",
        &["units", "memo", "shader", "image", "render::plan", "render::frame", "render::software"],
        &["wgpu", "winit", "softbuffer", "std::fs"],
    ),
    ("render", &["render"], &["naga", "wgpu", "winit", "egui", "softbuffer", "std::fs"]),
    (
        "cli",
        &[
            "units",
            "time",
            "catalog",
            "ephemeris",
            "events",
            "scene",
            "shader",
            "render",
            "image",
            "session",
            "probe",
            "measure",
            "stability",
            "export",
            "view",
            "cli",
            "files",
            "json",
            "message",
            "wording",
        ],
        &["naga", "wgpu", "winit", "egui", "softbuffer"],
    ),
    (
        "lib",
        &["time", "catalog", "ephemeris", "scene", "shader", "render", "session", "files"],
        &["naga", "wgpu", "winit", "egui", "softbuffer", "std::fs"],
    ),
    ("main", &["cli"], &["naga", "wgpu", "winit", "egui", "softbuffer"]),
];

/// The row whose prefix is the longest that matches this module, if any.
fn row_of(module: &str) -> Option<&'static (&'static str, &'static [&'static str], &'static [&'static str])> {
    TABLE
        .iter()
        .filter(|(prefix, _, _)| module == *prefix || module.starts_with(&format!("{prefix}/")))
        .max_by_key(|(prefix, _, _)| prefix.len())
}

fn violations(tree: &SourceTree, file: &SourceFile) -> Vec<String> {
    let module = file.module();
    let Some((prefix, allowed, forbidden)) = row_of(&module) else { return vec![format!("src/{module} matches no row of the table")] };
    let mut found = Vec::new();
    for path in &file.paths {
        let path = path.segments.join("::");
        // Macros and items of the crate root belong to no module.
        if tree.is_module(path.split("::").next().unwrap_or(""))
            && !allowed.iter().any(|a| path == *a || path.starts_with(&format!("{a}::")))
        {
            found.push(format!("src/{module}: `crate::{path}` is not one of the modules that {prefix} may use ({})", allowed.join(", ")));
        }
    }
    let code = code_of(&file.text);
    let uses = |name: &str| {
        let is_below = |path: &String| path.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"));
        code.contains(&format!("{name}::")) || file.external_paths.iter().any(is_below)
    };
    found.extend(forbidden.iter().filter(|name| uses(name)).map(|name| format!("src/{module}: {prefix} may not use `{name}`")));
    found
}

/// Re-exports of items that another layer defines, which would bypass the table. lib.rs is the facade and exempt.
fn re_exports(tree: &SourceTree, file: &SourceFile) -> Vec<String> {
    let foreign = |path: &&NamedPath| tree.file_of(&path.segments).is_some_and(|n| tree.files[n].layer() != file.layer());
    let public = file.paths.iter().filter(|p| p.is_public_use && file.module() != "lib").filter(foreign);
    public.map(|p| format!("{}: {}", file.path, p.segments.join("::"))).collect()
}

/// The modules that each module may use by ARCHITECTURE.md's table: those that its second cell names before a semicolon, after which crates
/// follow. `plan` and `frame` are those of `render`. Of "every module above except" a list, the top-level modules of the rows before.
fn documented_table(text: &str) -> BTreeMap<String, BTreeSet<String>> {
    let module_of = |word: &str| match word.trim_end_matches(':') {
        "plan" => "render::plan".to_owned(),
        "frame" => "render::frame".to_owned(),
        word => word.to_owned(),
    };
    let is_module = |name: &String| name == "scene::draw" || TABLE.iter().any(|(prefix, _, _)| prefix.replace('/', "::") == *name);
    let rows = text.lines().skip_while(|l| !l.starts_with("| module | may use")).skip(2).take_while(|l| l.starts_with('|'));
    let mut table = BTreeMap::new();
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, modules, may_use, ..] = cells[..] else { panic!("{row}") };
        let before_crates = may_use.split(';').next().unwrap_or_default();
        let words = before_crates.split(|c: char| !c.is_ascii_lowercase() && !matches!(c, '_' | ':'));
        let named: BTreeSet<String> = words.map(module_of).filter(is_module).collect();
        let allowed = if may_use.starts_with("every module above except") {
            table.keys().filter(|m: &&String| !m.contains("::") && !named.contains(*m)).cloned().collect()
        } else {
            named
        };
        for module in modules.split(", ") {
            table.insert(module.trim_end_matches(" (`mod.rs`)").to_owned(), allowed.clone());
        }
    }
    table
}

#[test]
fn the_table_allows_the_modules_that_architecture_names() {
    let architecture = Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md");
    let own: BTreeMap<String, BTreeSet<String>> = TABLE
        .iter()
        .map(|(prefix, allowed, _)| {
            let module = prefix.replace('/', "::");
            let others = allowed.iter().filter(|a| **a != module).map(|a| (*a).to_owned()).collect();
            (module, others)
        })
        .collect();
    assert_eq!(documented_table(&std::fs::read_to_string(architecture).expect("the document")), own);
    let head = "| module | may use | may not use |\n|---|---|---|\n";
    let found = documented_table(&format!("{head}| time, render (`mod.rs`) | units, and plan: more; naga | scene |\n"));
    let of_both: BTreeSet<String> = ["units", "render::plan"].map(str::to_owned).into();
    assert_eq!(found, ["time", "render"].map(|module| (module.to_owned(), of_both.clone())).into());
}

#[test]
fn every_module_keeps_to_the_table() {
    let tree = SourceTree::of_project();
    let all: Vec<String> = tree.files.iter().flat_map(|file| violations(&tree, file)).collect();
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn no_module_re_exports_items_of_another() {
    let tree = SourceTree::of_project();
    let found: Vec<String> = tree.files.iter().flat_map(|file| re_exports(&tree, file)).collect();
    assert_only_tolerated("re-export", &found);
}

#[test]
fn a_layering_violation_is_found() {
    let layers = [
        "catalog/mod.rs",
        "ephemeris/mod.rs",
        "render/plan/mod.rs",
        "scene/mod.rs",
        "shader/mod.rs",
        "session/mod.rs",
        "cli/mod.rs",
        "view/mod.rs",
    ];
    let count = |path: &str, text: &str| {
        let sources: Vec<_> = layers.into_iter().map(|layer| (layer, "")).chain([(path, text)]).collect();
        let tree = SourceTree::new(&sources);
        violations(&tree, &tree.files[layers.len()]).len()
    };
    assert_eq!(count("catalog/body.rs", "use crate::scene::Scene;"), 1);
    assert_eq!(count("catalog/body.rs", "use super::super::scene::Scene;"), 1);
    assert_eq!(count("ephemeris/kernel.rs", "use crate::{catalog::NaifId, render::plan};"), 1);
    assert_eq!(count("scene/build.rs", "use crate::{\n    catalog::{Body, NaifId},\n    render::{plan, frame},\n};"), 2);
    assert_eq!(count("scene/build.rs", "let m = naga::Module::default();"), 1);
    assert_eq!(count("scene/build.rs", "use std::{fs, io};"), 1);
    assert_eq!(count("scene/build.rs", "use std::fs as files;\nuse wgpu;"), 2);
    assert_eq!(count("shader/emit.rs", "fn emit() { rayon::spawn(|| ()); }"), 1);
    assert_eq!(count("shader/emit.rs", "use std::fs;\nfn emit() { rayon::spawn_fifo(|| ()); }"), 0);
    assert_eq!(count("shader/key/text.rs", "use crate::shader::emit::emit;"), 1);
    assert_eq!(count("cli/render.rs", "let w = winit::EventLoop::new();"), 1);
    assert_eq!(count("view/app.rs", "use crate::cli::run;"), 1);
    assert_eq!(count("main.rs", "fn main() { orrery::cli::run(); orrery::session::f(); }"), 1);
    assert_eq!(count("new_module.rs", ""), 1);
    assert_eq!(count("scene/build.rs", "use crate::ephemeris::Ephemeris; // crate::render is not named"), 0);
}

#[test]
fn a_re_export_of_another_module_is_found() {
    let found = |text: &str| {
        let tree = SourceTree::new(&[("render/software/mod.rs", ""), ("session/sample.rs", ""), ("session/mod.rs", text)]);
        re_exports(&tree, &tree.files[2])
    };
    assert_eq!(found("pub use crate::render::software::TapeCost;"), ["session/mod.rs: render::software::TapeCost"]);
    assert!(found("pub use sample::Sample;\nuse crate::render::software::TapeCost;").is_empty());
}
