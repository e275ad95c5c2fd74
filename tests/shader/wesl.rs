//! WESL as the generator reads it: conditions, imports, and errors with their positions. tests/reference_compiler/, a package of its own, compares the
//! generator with WESL's reference compiler.

use orrery::shader::emit::emit_module_with;
use orrery::shader::fragments::{FRAGMENTS, Fragments};
use orrery::shader::module::diagnosis;
use orrery::shader::{ModuleId, ShaderError};

/// The shipped fragments with a user's text in place of the Lambert reflectance.
fn with_fragment(text: &str) -> Fragments {
    Fragments::with_files([("lib/photometry/lambert.wesl".to_owned(), text.to_owned())])
}

fn error_position(text: &str) -> (u32, u32, String) {
    let id: ModuleId = "lambert.sun1.sphere".parse().expect("a key");
    match emit_module_with(&with_fragment(text), &id) {
        Err(ShaderError::Fragment { path, line, column, what }) => {
            assert_eq!(path, "lib/photometry/lambert.wesl");
            let shown = diagnosis(&with_fragment(text), &id).expect("a diagnosis");
            assert!(shown.contains(&format!("line {line}, column {column}")) && shown.contains(&what), "{shown}");
            (line, column, what)
        }
        other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn an_error_in_a_fragment_has_line_and_column() {
    let law = "fn reflectance(cos_incidence: f32, cos_emission: f32, cos_phase: f32) -> f32 {\n    return cos_incidence;\n}\n";
    for (text, line, column, message_part) in [
        (format!("//: if lights.1\n{law}"), 1, 1, "no longer read"),
        (format!("// law\n@if(light_1) {law}"), 2, 5, "`lights_1`"),
        (format!("@if(lights_1 + 1) {law}"), 1, 5, "is not a condition"),
        (format!("{law}@else const A = 1;\n"), 4, 1, "no `@if`"),
        (format!("@if(lights_1) @if(lights_2) {law}"), 1, 15, "&&"),
        (law.replace("-> f32", "-> @if(lights_1) f32"), 1, 74, "before a declaration"),
        (format!("{law}fn more( {{\n"), 4, 10, "closed"),
        (format!("{law}fn more() {{ let = 1; }}\n"), 4, 17, "is unexpected here"),
        (format!("import package::lib::none::a;\n{law}"), 1, 1, "there is no shader source `lib/none.wesl`"),
        (format!("import package::lib::screen::corner;\n{law}"), 1, 1, "declares no `corner`"),
        (format!("import package::lib::screen::screen_corner as corner;\n{law}"), 1, 1, "rename"),
    ] {
        let (at_line, at_column, what) = error_position(&text);
        assert!(what.contains(message_part), "{what}");
        assert_eq!((at_line, at_column), (line, column), "{text}{what}");
    }
}

/// naga's first label is the wanted type, which has no position here; the second is the value.
#[test]
fn a_value_of_the_wrong_type_is_shown_at_its_own_line() {
    let text = "fn reflectance(cos_incidence: f32, cos_emission: f32, cos_phase: f32) -> f32 {\n    return vec2(1.0);\n}\n";
    let shown = diagnosis(&with_fragment(text), &"lambert.sun1.sphere".parse().expect("a key")).expect("a diagnosis");
    assert!(shown.starts_with("shaders/lib/photometry/lambert.wesl, line 2\n"), "{shown}");
}

#[test]
fn conditions_on_any_item_leave_out_the_item_and_the_comments_above_it() {
    let text = "// Head.\n\n// Import.\n@if(lights_2)\nimport super::super::screen::screen_corner;\n\n// Both.\n@if(lights_2) const A = 2.0; // two\n\
                @elif(lights_1) const A = 1.0; // one\n@else const A = 0.0;\n\nfn reflectance(\n    a: f32,\n    // Out.\n    @if(lights_2) q: f32,\n    b: f32,\n    \
                third: f32,\n) -> f32 {\n    // Kept.\n    @if(lights_1) let x = A;\n    // Gone.\n    @if(lights_2)\n    if x > 0.0 {\n        return third;\n    } else {\n        \
                return b;\n    }\n    @if(lights_1 && !lights_2) { return a * x; }\n    @else return b;\n}\n";
    let emitted = emit_module_with(&with_fragment(text), &"lambert.sun1.sphere".parse().expect("a key")).expect("emits");
    let user_lines: Vec<(u32, &str)> = (1..)
        .zip(emitted.wgsl.lines())
        .filter_map(|(n, line)| {
            emitted.source_map.origin_of(n).filter(|(path, _)| path.ends_with("lambert.wesl")).map(|(_, at)| (at, line))
        })
        .collect();
    let expected = [
        (1, "// Head."),
        (2, ""),
        (7, "// Both."),
        (9, "const A = 1.0; // one"),
        (11, ""),
        (12, "fn reflectance("),
        (13, "    a: f32,"),
        (16, "    b: f32,"),
        (17, "    third: f32,"),
        (18, ") -> f32 {"),
        (19, "    // Kept."),
        (20, "    let x = A;"),
        (28, "    { return a * x; }"),
        (30, "}"),
    ];
    assert_eq!(user_lines, expected);
    naga::front::wgsl::parse_str(&emitted.wgsl).expect("what is left is WGSL");
    let feature = |text: &str| {
        let line = emitted.wgsl.lines().position(|l| l.contains(text)).expect(text);
        emitted.source_map.feature_of(line + 1).expect("mapped").to_owned()
    };
    assert_eq!(feature("const A = 1.0"), "lights.1");
    assert_eq!(feature("return a * x"), "not lights.2");
    assert_eq!(feature("third: f32"), feature("fn reflectance("));
}

#[test]
fn empty_lines_within_imports_and_conditions_are_left_out() {
    let text = "import package::lib::screen::{\n\n    screen_corner,\n};\n\n@if(\n\nlights_1)\nfn reflectance(a: f32, b: f32, c: f32) -> f32 {\n\n    return a;\n}\n";
    let emitted = emit_module_with(&with_fragment(text), &"lambert.sun1.sphere".parse().expect("a key")).expect("emits");
    naga::front::wgsl::parse_str(&emitted.wgsl).expect("what is left is WGSL");
    assert!(emitted.wgsl.contains("fn reflectance(a: f32, b: f32, c: f32) -> f32 {\n\n    return a;"), "{}", emitted.wgsl);
}

/// An `@else` ends its chain: an item after it would never be emitted.
#[test]
fn nothing_continues_a_chain_after_its_else() {
    for (last, is_valid) in
        [("@elif(lights_2)", true), ("@else", true), ("@else const k = 3;\n@else", false), ("@else const k = 3;\n@elif(lights_2)", false)]
    {
        let text =
            format!("@if(lights_1) const k = 1;\n{last} const k = 2;\nfn reflectance(a: f32, b: f32, c: f32) -> f32 {{ return a; }}\n");
        let error = emit_module_with(&with_fragment(&text), &"lambert.sun1.sphere".parse().expect("a key")).map(drop).err();
        let is_refused = error.as_ref().is_some_and(|e| e.to_string().contains("ends the chain"));
        assert_eq!((error.is_none(), is_refused), (is_valid, !is_valid), "{last}: {error:?}");
    }
}

/// With forty `<` in one statement, the WESL parser does not terminate.
#[test]
fn a_fragment_that_the_parser_cannot_finish_is_refused_with_its_position() {
    let (name, text) = FRAGMENTS.iter().find(|(name, _)| *name == "entry/tone_map.wesl").expect("a fragment");
    let build = |text: String| {
        emit_module_with(&Fragments::with_files(vec![((*name).to_owned(), text)]), &"tone_map".parse().expect("a name")).map(drop)
    };
    let start = std::time::Instant::now();
    for count in [13, 40, 10_000] {
        match build(format!("{text}\nalias A = {};\n", "vec2<".repeat(count))) {
            Err(ShaderError::Fragment { line, what, .. }) => {
                assert!(what.contains("more than 12 `<`") && line as usize == text.lines().count() + 2, "{count}: {line} {what}");
            }
            other => panic!("{count}: {other:?}"),
        }
    }
    assert!(start.elapsed().as_secs() < 5);
    // Types nested as in real code are accepted, and `<` in a comment does not count.
    build(format!("{text}\nalias A = array<array<vec4<f32>, 4>, 2>; // < < < < < < < < < < < < < < < <\n")).expect("a valid fragment");
    // The shipped fragments are far below the limit.
    for (name, text) in FRAGMENTS.iter() {
        orrery::shader::source::Fragment::check(name, text).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}
