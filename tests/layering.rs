//! The module table of ARCHITECTURE.md, held by reading every `use crate::…` and `crate::…` path in src/.

use std::path::{Path, PathBuf};

/// (module path prefix, crate modules it may name, external crates it may not name).
const TABLE: &[(&str, &[&str], &[&str])] = &[
    ("units", &[], &["naga", "wgpu", "winit", "softbuffer"]),
    ("wording", &[], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("time", &["units", "time", "wording"], &["naga", "wgpu", "winit", "softbuffer"]),
    ("catalog", &["units", "time", "catalog", "wording"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("ephemeris", &["units", "time", "catalog", "ephemeris"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("memo", &["memo"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("mesh", &["mesh"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    (
        "scene",
        &["units", "time", "catalog", "ephemeris", "mesh", "memo", "scene", "wording"],
        &["naga", "wgpu", "winit", "softbuffer", "std::fs"],
    ),
    ("image", &["units", "image"], &["naga", "wgpu", "winit", "softbuffer"]),
    ("shader/key", &["scene::draw", "shader::key", "wording"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    ("shader", &["scene::draw", "shader", "wording"], &["wgpu", "winit", "softbuffer", "rayon::spawn"]),
    ("render/plan", &["scene", "shader", "image", "render::plan"], &["wgpu", "winit", "softbuffer", "std::fs"]),
    ("render/frame", &["image", "render::frame"], &["naga", "wgpu", "winit", "softbuffer", "std::fs"]),
    (
        "session",
        &["units", "time", "catalog", "ephemeris", "mesh", "memo", "scene", "shader", "render", "image", "session", "wording"],
        &["naga", "wgpu", "winit", "softbuffer"],
    ),
    (
        "probe",
        &["units", "time", "catalog", "ephemeris", "scene", "shader", "render", "image", "session", "probe", "wording"],
        &["naga", "wgpu", "winit", "softbuffer", "std::fs"],
    ),
    (
        "view",
        &["units", "time", "catalog", "ephemeris", "scene", "shader", "render::plan", "image", "session", "probe", "view"],
        &["naga", "wgpu"],
    ),
    (
        "render/gpu",
        &["shader", "image", "render::plan", "render::frame", "render::gpu"],
        &["naga", "winit", "softbuffer", "std::fs", "rayon"],
    ),
    (
        "render/software",
        &["shader", "image", "render::plan", "render::frame", "render::software"],
        &["wgpu", "winit", "softbuffer", "std::fs"],
    ),
];

fn rust_files(dir: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = std::fs::read_dir(dir).expect("src/ is readable").map(|e| e.expect("entry").path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            rust_files(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
}

/// The longest prefix of the table that holds this file, if any.
fn row_of(module: &str) -> Option<&'static (&'static str, &'static [&'static str], &'static [&'static str])> {
    TABLE
        .iter()
        .filter(|(prefix, _, _)| module == *prefix || module.starts_with(&format!("{prefix}/")))
        .max_by_key(|(prefix, _, _)| prefix.len())
}

/// The text without `//` comments.
fn code_of(text: &str) -> String {
    text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Every `crate::a::b` path named in code; a group `crate::{a::b, c::{d, e}}` gives `a::b` and `c`.
fn crate_paths(text: &str) -> Vec<String> {
    let code = code_of(text);
    let path_at = |s: &str| -> String {
        let path: String = s.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_' || *c == ':').collect();
        path.trim_end_matches(':').to_owned()
    };
    let mut paths = Vec::new();
    let mut rest = code.as_str();
    while let Some(at) = rest.find("crate::") {
        rest = &rest[at + "crate::".len()..];
        if !rest.starts_with('{') {
            paths.push(path_at(rest));
            continue;
        }
        let (mut depth, mut start) = (0, 1);
        for (i, c) in rest.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 || (depth == 1 && c == ',') {
                paths.push(path_at(&rest[start..i]));
                start = i + 1;
            }
            if depth == 0 {
                break;
            }
        }
    }
    paths.retain(|p| !p.is_empty());
    paths
}

fn breaches(module: &str, text: &str) -> Vec<String> {
    let Some((prefix, allowed, forbidden)) = row_of(module) else { return Vec::new() };
    let mut found = Vec::new();
    for path in crate_paths(text) {
        if !allowed.iter().any(|a| path == *a || path.starts_with(&format!("{a}::"))) {
            found.push(format!("src/{module}: `crate::{path}` is not among what {prefix} may use ({})", allowed.join(", ")));
        }
    }
    for name in *forbidden {
        if code_of(text).contains(&format!("{name}::")) {
            found.push(format!("src/{module}: `{name}` is barred from {prefix}"));
        }
    }
    found
}

#[test]
fn every_module_keeps_to_the_table() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    assert!(files.len() > 20, "only {} files found under src/", files.len());
    let mut all = Vec::new();
    for file in &files {
        let module = file.strip_prefix(&src).expect("under src").with_extension("");
        let module = module.to_string_lossy().replace('\\', "/");
        let module = module.strip_suffix("/mod").unwrap_or(&module).to_owned();
        all.extend(breaches(&module, &std::fs::read_to_string(file).expect("readable")));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn a_breach_is_found() {
    assert_eq!(breaches("catalog/body", "use crate::scene::Scene;").len(), 1);
    assert_eq!(breaches("ephemeris/kernel", "use crate::{catalog::NaifId, render::plan};").len(), 1);
    assert_eq!(breaches("scene/build", "use crate::{\n    catalog::{Body, NaifId},\n    render::{plan, frame},\n};").len(), 1);
    assert_eq!(breaches("scene/build", "let m = naga::Module::default();").len(), 1);
    assert_eq!(breaches("shader/key/text", "use crate::shader::emit::emit;").len(), 1);
    assert!(breaches("scene/build", "use crate::ephemeris::Ephemeris; // crate::render is not named").is_empty());
}

#[test]
fn no_file_is_over_its_budget() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut long = Vec::new();
    for (dir, extension, most) in [("src", "rs", 800), ("tests", "rs", 800), ("shaders", "wgsl", 250)] {
        let mut stack = vec![root.join(dir)];
        while let Some(d) = stack.pop() {
            for entry in std::fs::read_dir(&d).into_iter().flatten().flatten() {
                let path = entry.path();
                if path.is_dir() {
                    stack.push(path);
                } else if path.extension().is_some_and(|e| e == extension) {
                    let lines = std::fs::read_to_string(&path).expect("readable").lines().count();
                    if lines > most {
                        long.push(format!("{}: {lines} lines, {most} at the most", path.display()));
                    }
                }
            }
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}
