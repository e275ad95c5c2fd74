//! No circular imports between the files of a layer, no overlong files, and narrowing to f32 only in the camera.

use super::source_tree::{SourceTree, code_of};
use super::{assert_only_tolerated, files_below};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The only module of scene that may narrow f64 to f32: the camera subtracts in f64 first.
const MAY_NARROW: &[&str] = &["scene/camera"];

/// The files that are part of circular imports.
fn files_in_circles(imports: &BTreeMap<&str, Vec<&str>>) -> Vec<String> {
    let reaches_itself = |start: &str| {
        let mut seen = BTreeSet::new();
        let mut pending = imports[start].clone();
        while let Some(file) = pending.pop() {
            if file == start {
                return true;
            }
            if seen.insert(file) {
                pending.extend(&imports[file]);
            }
        }
        false
    };
    imports.keys().filter(|file| reaches_itself(file)).map(|file| (*file).to_owned()).collect()
}

#[test]
fn files_of_a_module_have_no_circular_imports() {
    let tree = SourceTree::of_project();
    let layers: BTreeSet<String> = tree.files.iter().map(|f| f.layer()).collect();
    let mut found = Vec::new();
    for layer in &layers {
        let imports = tree.imports_within(layer);
        let circle = files_in_circles(&imports);
        for file in &circle {
            let circular_imports: Vec<_> = imports[file.as_str()].iter().filter(|to| circle.iter().any(|c| c == *to)).collect();
            println!("{file} -> {circular_imports:?}");
        }
        found.extend(circle);
    }
    assert_only_tolerated("circle", &found);
}

#[test]
fn circular_imports_are_detected() {
    let circular = SourceTree::new(&[
        ("a/b.rs", "use super::c::C;"),
        ("a/c.rs", "use crate::a::d::D;"),
        ("a/d.rs", "use super::b::B;"),
        ("a/e.rs", "use super::b::B;"),
    ]);
    assert_eq!(files_in_circles(&circular.imports_within("a")), ["a/b.rs", "a/c.rs", "a/d.rs"]);
    // Imports of test modules do not count.
    let not_circular = SourceTree::new(&[
        ("a/b.rs", "use super::c::C;"),
        ("a/c.rs", "use crate::a::d::D;"),
        ("a/d.rs", "#[cfg(test)]\nmod tests { use super::super::b::B; }"),
    ]);
    assert!(files_in_circles(&not_circular.imports_within("a")).is_empty());
}

/// Paths of the files with more than `limit` lines. `files`: path and number of lines.
fn too_long(files: &[(String, usize)], limit: usize) -> Vec<String> {
    files.iter().filter(|(_, n)| *n > limit).map(|(path, _)| path.clone()).collect()
}

#[test]
fn no_file_is_too_long() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for (dir, limit) in [("src", 500), ("tests", 500), ("examples", 500), ("benches", 500), ("shaders", 250)] {
        let mut files = Vec::new();
        files_below(&root.join(dir), &["rs", "wgsl", "wesl"], &mut files);
        assert!(!files.is_empty(), "{dir}");
        let line_count = |path: &Path| std::fs::read_to_string(path).expect("UTF-8").lines().count();
        let name_of = |path: &Path| path.strip_prefix(root).expect("below").to_string_lossy().replace('\\', "/");
        found.extend(too_long(&files.iter().map(|path| (name_of(path), line_count(path))).collect::<Vec<_>>(), limit));
    }
    assert_only_tolerated("long", &found);
    assert_eq!(too_long(&[("a".into(), 501), ("b".into(), 500)], 500), ["a"]);
}

/// Whether code narrows f64 to f32, by a cast or by glam's vectors and matrices.
fn narrows_to_f32(code: &str) -> bool {
    [" as f32", ".as_vec2()", ".as_vec3()", ".as_vec4()", ".as_mat3()", ".as_mat4()", ".as_quat()"].iter().any(|cast| code.contains(cast))
}

#[test]
fn only_the_camera_of_scene_narrows_to_f32() {
    let tree = SourceTree::of_project();
    let scene = tree.files.iter().filter(|f| f.layer() == "scene" && !MAY_NARROW.iter().any(|m| f.module().starts_with(m)));
    let found: Vec<String> = scene.filter(|f| narrows_to_f32(&code_of(&f.text))).map(|f| f.path.clone()).collect();
    assert_only_tolerated("narrows", &found);
    assert!(narrows_to_f32("let x = y as f32;") && narrows_to_f32("p.as_vec3()"));
    assert!(!narrows_to_f32(&code_of("// y as f32\nlet x = f32::from(y);\n#[cfg(test)]\nmod tests { fn f() { y as f32; } }")));
}
