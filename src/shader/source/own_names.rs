//! Renames the declarations of a custom surface, so that none of its names clashes with one of another fragment (WESL file).
//!
//! In: path and text of the user's file, a prefix, and the one name that other fragments import. Out: the text in which every other name that the file declares
//! at module scope begins with the prefix. Always: each line keeps its number. Refused, with line and column: what a module has only once, such as entry
//! points and bindings, and a name that is both declared and imported. Not here: a name that the file only uses.

use super::fragment::{Fragment, line_and_column};
use crate::shader::ShaderError;
use std::collections::HashSet;
use std::ops::Range;
use wgsl_parse::lexer::Lexer;

/// Attributes of what a module has only once: entry points and bindings.
const REFUSED_ATTRIBUTES: [&str; 5] = ["vertex", "fragment", "compute", "group", "binding"];
/// Attributes whose arguments are not expressions, and so name no declaration.
const ATTRIBUTES_WITHOUT_EXPRESSIONS: [&str; 5] = ["if", "elif", "builtin", "interpolate", "diagnostic"];

/// The text with the prefix before each name that it declares, except `exported`.
///
/// # Errors
/// Those of [`Fragment::check`]; entry points, bindings and overridable constants; a name that is declared and imported.
pub fn with_prefixed_names(path: &str, text: &str, prefix: &str, exported: &str) -> Result<String, ShaderError> {
    let fragment = Fragment::check(path, text)?;
    let own_names: HashSet<&str> = fragment.declared.iter().map(String::as_str).filter(|name| *name != exported).collect();
    // `check` has found a token everywhere.
    let spans: Vec<Range<usize>> = Lexer::new(text).flatten().map(|(start, _, end)| start..end).collect();
    let word = |k: usize| spans.get(k).map_or("", |span| &text[span.clone()]);
    let error = |k: usize, what: String| {
        let (line, column) = line_and_column(text, spans[k].start);
        Err(ShaderError::Fragment { path: path.to_owned(), line, column, what })
    };
    let mut renamed = String::with_capacity(text.len());
    let mut copied = 0;
    // The depth of nested braces, and whether they are those of a structure, which contain no others.
    let (mut depth, mut in_struct) = (0usize, false);
    let mut k = 0;
    while k < spans.len() {
        match word(k) {
            "import" => {
                while !matches!(word(k), ";" | "") {
                    k += 1;
                }
            }
            "@" if REFUSED_ATTRIBUTES.contains(&word(k + 1)) => {
                return error(k, format!("a custom surface has no entry points and no bindings: remove `@{}`", word(k + 1)));
            }
            "@" if ATTRIBUTES_WITHOUT_EXPRESSIONS.contains(&word(k + 1)) && word(k + 2) == "(" => k = closing_parenthesis(word, k + 2),
            // The next token is the attribute's name.
            "@" => k += 1,
            "override" => return error(k, "a custom surface has no overridable constants: write `const`".into()),
            "struct" => in_struct = true,
            "{" => depth += 1,
            "}" => (depth, in_struct) = (depth.saturating_sub(1), false),
            name if own_names.contains(name) => {
                let before = k.checked_sub(1).map_or("", word);
                if depth == 0
                    && matches!(before, "fn" | "struct" | "const" | "alias" | "var" | ">")
                    && fragment.imports.iter().any(|i| i.item == name)
                {
                    return error(k, format!("`{name}` is imported, too: declare another name"));
                }
                let is_member = matches!(before, "." | "::") || (in_struct && word(k + 1) == ":");
                if !is_member {
                    renamed.push_str(&text[copied..spans[k].start]);
                    renamed.push_str(prefix);
                    copied = spans[k].start;
                }
            }
            _ => {}
        }
        k += 1;
    }
    renamed.push_str(&text[copied..]);
    Ok(renamed)
}

/// Index of the token that closes the parenthesis of index `open`; the number of tokens if none does.
fn closing_parenthesis<'t>(word: impl Fn(usize) -> &'t str, open: usize) -> usize {
    let (mut depth, mut k) = (0usize, open);
    loop {
        match word(k) {
            "(" => depth += 1,
            ")" if depth == 1 => return k,
            ")" => depth -= 1,
            "" => return k,
            _ => {}
        }
        k += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prefixed(text: &str) -> Result<String, ShaderError> {
        with_prefixed_names("lib/custom/surface_1.wesl", text, "p_", "custom_surface")
    }

    #[test]
    fn declarations_and_their_uses_get_the_prefix() {
        let text = "import package::lib::math::{tau, pi};
const scale = 2.0; // scale
alias numbers = array<f32, count>;
const count = 2u;
const has_air = 1.0;
struct shape { @align(count) scale: f32, @if(has_air || (custom_1)) colour: vec3f, }
var<private> state: f32;
@if(has_air) @must_use fn fold(scale: f32, s: shape) -> f32 { let count = s.scale * has_air; return vec3f(count).x + s.colour.x; }
fn custom_surface(point: SurfacePoint) -> CustomSurface {
    state = tau + fold(scale, shape(1.0, vec3f(state)));
    for (var fold = 0; fold < 3; fold++) { if fold>state { } }
}
";
        let expected = "import package::lib::math::{tau, pi};
const p_scale = 2.0; // scale
alias p_numbers = array<f32, p_count>;
const p_count = 2u;
const p_has_air = 1.0;
struct p_shape { @align(p_count) scale: f32, @if(has_air || (custom_1)) colour: vec3f, }
var<private> p_state: f32;
@if(has_air) @must_use fn p_fold(p_scale: f32, s: p_shape) -> f32 { let p_count = s.scale * p_has_air; return vec3f(p_count).x + s.colour.x; }
fn custom_surface(point: SurfacePoint) -> CustomSurface {
    p_state = tau + p_fold(p_scale, p_shape(1.0, vec3f(p_state)));
    for (var p_fold = 0; p_fold < 3; p_fold++) { if p_fold>p_state { } }
}
";
        assert_eq!(prefixed(text).as_deref(), Ok(expected));
    }

    #[test]
    fn what_a_module_has_only_once_is_refused_at_its_place() {
        for (text, line, column, what) in [
            ("\n@fragment fn f() {}", 2, 1, "`@fragment`"),
            ("@group(0) @binding(1) var t: texture_2d<f32>;", 1, 1, "`@group`"),
            (" override k = 1.0;", 1, 2, "`const`"),
            ("import package::lib::a::b;\n\nfn b() {}", 3, 4, "`b` is imported"),
            ("import package::lib::a::b;\nvar<private> b: f32;", 2, 14, "`b` is imported"),
            ("fn f() { let a = = 1.0; }", 1, 18, "`=`"),
        ] {
            match prefixed(text) {
                Err(ShaderError::Fragment { line: l, column: c, what: w, .. }) => {
                    assert_eq!((l, c), (line, column), "{text}: {w}");
                    assert!(w.contains(what), "{text}: {w}");
                }
                other => panic!("{text}: {other:?}"),
            }
        }
    }
}
