//! The text of a module in one shading language, split into lines, with syntax colours and the feature of each line.
//!
//! In: a module, a language. Out: lines, and layout jobs that egui can display. Always: only WGSL has features and origins of lines, because the source
//! map describes the WGSL text.

use crate::shader::ShaderModule;
use crate::shader::key::DIMENSIONS;
use crate::shader::translate::{Language, translate};
use crate::view::error_texts::error_text;
use egui::ecolor::HsvaGamma;
use egui::{Color32, FontId, TextFormat, text::LayoutJob};
use std::ops::Range;

/// One line of the text, its feature and its origin.
pub(crate) struct ModuleLine {
    pub text: String,
    /// Index into [`ModuleText::features`]; 0 if the line needs no feature, or if the language has no features.
    pub feature_index: u16,
    /// Path of the fragment (a shader source) and number of the line in it, such as `shaders/lib/a.wesl:7`; empty if unknown.
    pub origin: String,
}

/// The text of a module in one language.
pub(crate) struct ModuleText {
    pub language: Language,
    pub lines: Vec<ModuleLine>,
    /// The name of each entry of the source map's `features`, and the number of its lines. Entry 0 is no feature: it has the module's own name, and its
    /// lines need no feature. A line may need several features: the lines of the entry `a, not b, c` are in the module because `a` is on, and `b` and `c`
    /// are off. Empty for languages other than WGSL.
    pub features: Vec<(String, usize)>,
}

/// Translates a module to a language.
///
/// # Errors
/// If the module cannot be translated; the error is a text in the window's language.
pub(crate) fn translated_text(module: &ShaderModule, language: Language) -> Result<ModuleText, String> {
    let text = translate(module, language).map_err(|e| error_text(&e))?;
    let source_map = &module.source_map;
    let has_source_map = language == Language::Wgsl;
    let line = |(index, text): (usize, &str)| {
        let mapped = source_map.lines.get(index).filter(|_| has_source_map);
        let line_number = index + 1;
        let origin =
            mapped.and_then(|_| source_map.origin_of(line_number)).map_or(String::new(), |(path, line)| format!("shaders/{path}:{line}"));
        ModuleLine { text: text.replace('\t', "    "), feature_index: mapped.map_or(0, |mapped| mapped.feature), origin }
    };
    let lines: Vec<ModuleLine> = text.lines().enumerate().map(line).collect();
    let line_count = |feature_index: usize| lines.iter().filter(|line| usize::from(line.feature_index) == feature_index).count();
    let features =
        source_map.features.iter().filter(|_| has_source_map).enumerate().map(|(index, name)| (name.clone(), line_count(index))).collect();
    Ok(ModuleText { language, lines, features })
}

/// The kind of a token, for its syntax colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TokenKind {
    Plain,
    Comment,
    /// A keyword, or an instruction of disassembled SPIR-V.
    Keyword,
    Type,
    Number,
    /// The name of a called function.
    Call,
    /// An attribute, or a preprocessor line.
    Attribute,
}

/// Keywords of WGSL, HLSL, GLSL and MSL, and boolean literals.
const KEYWORDS: &[&str] = &[
    "alias",
    "break",
    "case",
    "const",
    "constant",
    "continue",
    "continuing",
    "default",
    "discard",
    "do",
    "else",
    "fn",
    "for",
    "if",
    "in",
    "inout",
    "layout",
    "let",
    "loop",
    "namespace",
    "out",
    "override",
    "precision",
    "private",
    "return",
    "static",
    "struct",
    "switch",
    "thread",
    "typedef",
    "uniform",
    "using",
    "var",
    "void",
    "while",
    "cbuffer",
    "register",
    "device",
    "fragment",
    "vertex",
    "smooth",
    "flat",
    "highp",
    "true",
    "false",
];
/// Names of types of WGSL, HLSL, GLSL and MSL.
const TYPES: &[&str] = &["bool", "f32", "f16", "i32", "u32", "float", "int", "uint", "double", "half", "sampler", "array", "matrix"];
/// Beginnings of further names of types, in which a digit follows: `vec3f`, `texture_2d`, `sampler2D`.
const TYPE_PREFIXES_BEFORE_DIGIT: &[&str] =
    &["vec", "mat", "ivec", "uvec", "bvec", "float", "uint", "int", "bool", "texture", "texture_", "sampler"];
/// Beginnings of further names of types, in which anything may follow.
const TYPE_PREFIXES: &[&str] = &[
    "texture_cube",
    "texture_depth_",
    "texture_external",
    "texture_multisampled_",
    "texture_storage_",
    "texturecube",
    "samplerCube",
    "sampler_comparison",
    "Texture",
    "Sampler",
    "packed_",
];

/// Whether a word is the name of a type.
fn is_type(word: &str) -> bool {
    let is_before_digit = |prefix: &&str| word.strip_prefix(*prefix).is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    TYPES.contains(&word)
        || TYPE_PREFIXES_BEFORE_DIGIT.iter().any(is_before_digit)
        || TYPE_PREFIXES.iter().any(|prefix| word.starts_with(prefix))
}

/// The kind of the identifier or number `word`. `rest`: the remainder of the line after it.
fn token_kind(word: &str, rest: &str) -> TokenKind {
    if KEYWORDS.contains(&word) {
        TokenKind::Keyword
    } else if word.starts_with(|c: char| c.is_ascii_digit()) {
        TokenKind::Number
    } else if is_type(word) {
        TokenKind::Type
    } else if word.starts_with("Op") && word.len() > 2 && word[2..].starts_with(|c: char| c.is_ascii_uppercase()) {
        // An instruction of SPIR-V, such as `OpLoad`.
        TokenKind::Keyword
    } else if rest.starts_with('(') {
        TokenKind::Call
    } else {
        TokenKind::Plain
    }
}

/// The tokens of a line as byte ranges, in order and without gaps. Adjacent tokens of the same kind are merged. A comment extends to the end of the
/// line.
pub(crate) fn tokens(line: &str) -> Vec<(Range<usize>, TokenKind)> {
    let mut found: Vec<(Range<usize>, TokenKind)> = Vec::new();
    let mut push = |range: Range<usize>, kind: TokenKind| match found.last_mut() {
        Some((last, last_kind)) if *last_kind == kind => last.end = range.end,
        _ => found.push((range, kind)),
    };
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    // The byte offset of the next token.
    let mut start = 0;
    while let Some(c) = line[start..].chars().next() {
        let rest = &line[start..];
        if rest.starts_with("//") || (rest.starts_with('#') && line[..start].trim().is_empty()) {
            let kind = if c == '#' { TokenKind::Attribute } else { TokenKind::Comment };
            push(start..line.len(), kind);
            break;
        }
        if is_word(c) {
            let is_number = c.is_ascii_digit();
            // A number includes its decimal point and a signed exponent.
            let mut length = 0;
            let mut previous = ' ';
            for (i, c) in rest.char_indices() {
                let is_exponent_sign = (c == '-' || c == '+') && matches!(previous, 'e' | 'E') && !rest.starts_with("0x");
                if !(is_word(c) || is_number && (c == '.' || is_exponent_sign)) {
                    break;
                }
                length = i + c.len_utf8();
                previous = c;
            }
            push(start..start + length, token_kind(&rest[..length], &rest[length..]));
            start += length;
        } else if c == '@' || (c == '[' && rest.starts_with("[[")) {
            // An attribute of WGSL, or of MSL (`[[`).
            let length = rest.char_indices().skip(1).find(|(_, c)| !is_word(*c) && *c != '[').map_or(rest.len(), |(i, _)| i);
            push(start..start + length, TokenKind::Attribute);
            start += length;
        } else {
            push(start..start + c.len_utf8(), TokenKind::Plain);
            start += c.len_utf8();
        }
    }
    found
}

/// The colour of a token, on a dark background if `is_dark`, otherwise on a light one.
fn syntax_colour(kind: TokenKind, is_dark: bool) -> Color32 {
    let [on_dark, on_light] = match kind {
        TokenKind::Plain => [[212, 212, 212], [40, 40, 40]],
        TokenKind::Comment => [[128, 146, 118], [84, 112, 70]],
        TokenKind::Keyword => [[204, 140, 222], [140, 40, 160]],
        TokenKind::Type => [[92, 200, 178], [0, 110, 96]],
        TokenKind::Number => [[220, 176, 118], [160, 84, 0]],
        TokenKind::Call => [[122, 178, 236], [20, 84, 170]],
        TokenKind::Attribute => [[160, 160, 176], [100, 100, 116]],
    };
    let [r, g, b] = if is_dark { on_dark } else { on_light };
    Color32::from_rgb(r, g, b)
}

/// The colour of a feature, the same in every module; `is_dark`: on a dark background. Almost every feature of a dimension has its own colour; the
/// lines that need the feature to be off have the same hue. Any other name, such as the module's own, is grey.
pub(crate) fn feature_colour(name: &str, is_dark: bool) -> Color32 {
    // Of several negated features (`not a, b`), the first gives the hue.
    let (is_negated, name) = name.strip_prefix("not ").map_or((false, name), |names| (true, names.split(", ").next().unwrap_or(names)));
    let all_features = DIMENSIONS.iter().flat_map(|d| d.feature_names).filter(|f| !f.is_empty());
    let Some(index) = all_features.into_iter().position(|f| *f == name) else { return Color32::from_gray(if is_dark { 155 } else { 95 }) };
    // Consecutive features differ by the golden angle (0.382 of a turn), so that their hues are clearly different.
    let hue = (index as f32 * 0.381_966).fract();
    let (saturation, value) = if is_dark { (0.45, 0.95) } else { (0.9, 0.44) };
    // A negated feature is paler.
    HsvaGamma { h: hue, s: if is_negated { saturation * 0.5 } else { saturation }, v: value, a: 1.0 }.into()
}

/// The layout of a line, with syntax colours and highlighted occurrences of `needle`. The line's number precedes it, unless `number` is 0. `is_dark`: for
/// a dark background.
pub(crate) fn layout_job(number: usize, line: &str, needle: &str, font: &FontId, is_dark: bool) -> LayoutJob {
    let format = |color: Color32| TextFormat { font_id: font.clone(), color, ..TextFormat::default() };
    let mut layout_job = LayoutJob::default();
    layout_job.wrap.max_width = f32::INFINITY;
    if number > 0 {
        layout_job.append(&format!("{number:>5}  "), 0.0, format(Color32::from_gray(if is_dark { 155 } else { 95 })));
    }
    let matches = find_all(line, needle);
    let highlight = if is_dark { Color32::from_rgb(96, 80, 20) } else { Color32::from_rgb(255, 232, 130) };
    for (range, kind) in tokens(line) {
        let mut start = range.start;
        while start < range.end {
            let match_here = matches.iter().find(|m| m.contains(&start));
            let end = match match_here {
                Some(m) => m.end.min(range.end),
                None => matches.iter().map(|m| m.start).filter(|s| *s > start).min().unwrap_or(range.end).min(range.end),
            };
            let mut text_format = format(syntax_colour(kind, is_dark));
            if match_here.is_some() {
                // Some syntax colours are illegible on the highlight, so highlighted text has the plain colour.
                text_format.color = syntax_colour(TokenKind::Plain, is_dark);
                text_format.background = highlight;
            }
            layout_job.append(&line[start..end], 0.0, text_format);
            start = end;
        }
    }
    layout_job
}

/// Byte ranges of the occurrences of `needle` in a line, ignoring ASCII case.
pub(crate) fn find_all(line: &str, needle: &str) -> Vec<Range<usize>> {
    if needle.is_empty() {
        return Vec::new();
    }
    // ASCII case conversion keeps byte offsets.
    let (line, needle) = (line.to_ascii_lowercase(), needle.to_ascii_lowercase());
    line.match_indices(&needle).map(|(start, _)| start..start + needle.len()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_cover_the_line_and_have_their_kinds() {
        let line = "@group(0) let x = vec3f(1.5e-3, y); // twice";
        let found = tokens(line);
        let joined: String = found.iter().map(|(r, _)| &line[r.clone()]).collect();
        assert_eq!(joined, line);
        let kind = |word: &str| found.iter().find(|(r, _)| line[r.clone()].contains(word)).map(|(_, k)| *k);
        assert_eq!(kind("let"), Some(TokenKind::Keyword));
        assert_eq!(kind("vec3f"), Some(TokenKind::Type));
        assert_eq!(kind("1.5e-3"), Some(TokenKind::Number));
        assert_eq!(kind("@group"), Some(TokenKind::Attribute));
        assert_eq!(kind("twice"), Some(TokenKind::Comment));
        let kind_of_first = |line: &str| tokens(line).first().map(|(_, kind)| *kind);
        for call in ["textureSample(t, s, uv)", "textureLoad(t, at, 0)", "texture(t, uv)"] {
            assert_eq!(kind_of_first(call), Some(TokenKind::Call), "{call}");
        }
        for of_type in
            ["texture_2d<f32>", "texture2D t", "Texture2D t", "texture_storage_2d<r32float, read>", "mat4x4f", "sampler2D s", "float3 v"]
        {
            assert_eq!(kind_of_first(of_type), Some(TokenKind::Type), "{of_type}");
        }
        for variable in ["texture_sampler, uv", "textures[0]", "material = 1", "vector = x"] {
            assert_eq!(kind_of_first(variable), Some(TokenKind::Plain), "{variable}");
        }
        assert_eq!(tokens("a µ² b").iter().map(|(r, _)| r.len()).sum::<usize>(), "a µ² b".len());
    }

    #[test]
    fn search_results_are_highlighted_in_any_case() {
        assert_eq!(find_all("let Ring = ring;", "rInG"), [4..8, 11..15]);
        assert!(find_all("let", "").is_empty());
        let (line_number, is_dark) = (7, true);
        let layout_job = layout_job(line_number, "let ring = 2;", "ring", &FontId::monospace(12.0), is_dark);
        assert_eq!(layout_job.text, "    7  let ring = 2;");
        assert_eq!(layout_job.sections.iter().filter(|s| s.format.background != Color32::TRANSPARENT).count(), 1);
    }

    #[test]
    fn at_most_two_features_lack_a_colour_of_their_own() {
        let names: Vec<_> = DIMENSIONS.iter().flat_map(|d| d.feature_names).filter(|f| !f.is_empty()).collect();
        let distinct: std::collections::BTreeSet<_> = names.iter().collect();
        let is_dark = true;
        let colours: std::collections::BTreeSet<_> = names.iter().map(|n| feature_colour(n, is_dark).to_array()).collect();
        assert!(colours.len() + 2 >= distinct.len(), "{} colours for {} features", colours.len(), distinct.len());
    }
}
