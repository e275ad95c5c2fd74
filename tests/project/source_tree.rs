//! The Rust files of src/ and the paths that each names, parsed from the text without a compiler.
//!
//! In: paths and texts of Rust sources. Out: a file's code without comments, literals and unit tests; every path in it as an absolute
//! module path; and the file that defines the item of a path, through re-exports. Not handled: items from macros, and from `use a::*`.

use std::collections::BTreeMap;
use std::path::Path;

#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Path inside src/, with `/`.
    pub path: String,
    pub text: String,
    /// The file's module: `["scene", "draw"]`; empty for lib.rs.
    module: Vec<String>,
    /// The paths in its code.
    pub paths: Vec<NamedPath>,
    /// Its paths that lead out of the crate, such as `std::fs`, and those that start with a name that a `use` brought in.
    pub external_paths: Vec<String>,
}

/// A path in code, from the crate root.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedPath {
    pub segments: Vec<String>,
    /// The name under which a `use` brings it in; `None` outside of `use`.
    used_as: Option<String>,
    /// From a `pub use`, or one with restricted visibility, such as `pub(crate) use`.
    pub is_public_use: bool,
}

impl SourceFile {
    /// A file with this path and text. [`SourceTree::new`] fills the lists of paths, once all modules are known.
    fn new(path: &str, text: &str) -> Self {
        let module = path.trim_end_matches(".rs").split('/').filter(|s| !matches!(*s, "mod" | "lib")).map(str::to_owned).collect();
        Self { path: path.into(), text: text.into(), module, paths: Vec::new(), external_paths: Vec::new() }
    }

    /// The module's path with `/`: `scene/draw`.
    pub fn module(&self) -> String {
        if self.module.is_empty() { "lib".into() } else { self.module.join("/") }
    }

    /// The first component of the module path; below `render` the first two, such as `render/plan`.
    pub fn layer(&self) -> String {
        let depth = if self.module.first().is_some_and(|m| m == "render") { 2 } else { 1 };
        self.module.iter().take(depth).cloned().collect::<Vec<_>>().join("/")
    }
}

/// All files of a crate.
#[derive(Clone, Debug)]
pub struct SourceTree {
    pub files: Vec<SourceFile>,
    by_module: BTreeMap<Vec<String>, usize>,
}

impl SourceTree {
    /// The project's src/.
    pub fn of_project() -> Self {
        let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut files = Vec::new();
        super::files_below(&src, &["rs"], &mut files);
        assert!(files.len() > 20, "only {} files found under src/", files.len());
        let text_of = |path: &Path| std::fs::read_to_string(path).expect("UTF-8");
        let name_of = |path: &Path| path.strip_prefix(&src).expect("under src").to_string_lossy().replace('\\', "/");
        let named: Vec<(String, String)> = files.iter().map(|path| (name_of(path), text_of(path))).collect();
        Self::new(&named.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect::<Vec<_>>())
    }

    /// From paths and texts.
    pub fn new(sources: &[(&str, &str)]) -> Self {
        let mut files: Vec<_> = sources.iter().map(|(path, text)| SourceFile::new(path, text)).collect();
        let by_module: BTreeMap<_, _> = files.iter().enumerate().map(|(n, f)| (f.module.clone(), n)).collect();
        for file in &mut files {
            (file.paths, file.external_paths) = PathReader::new(&file.text, &file.module, &by_module).paths();
        }
        Self { files, by_module }
    }

    /// Whether the crate has a top-level module with this name.
    pub fn is_module(&self, name: &str) -> bool {
        self.files.iter().any(|f| f.module.first().is_some_and(|m| m == name))
    }

    /// The file of the deepest module in a path.
    pub fn file_of(&self, path: &[String]) -> Option<usize> {
        (0..=path.len()).rev().find_map(|n| self.by_module.get(&path[..n]).copied())
    }

    /// The file that defines the item of a path, following re-exports.
    pub fn definition(&self, path: &[String]) -> Option<usize> {
        let mut path = path.to_vec();
        // Follows at most 8 re-exports.
        for _ in 0..8 {
            let file = self.file_of(&path)?;
            let depth = self.files[file].module.len();
            let Some(name) = path.get(depth) else { return Some(file) };
            let Some(import) = self.files[file].paths.iter().find(|p| p.used_as.as_ref() == Some(name)) else { return Some(file) };
            path = import.segments.iter().chain(&path[depth + 1..]).cloned().collect();
        }
        None
    }

    /// For each file of a layer, the other files of the layer that it uses. Left out: the mod.rs files of its parent folders, which declare
    /// items for all files below them.
    pub fn imports_within(&self, layer: &str) -> BTreeMap<&str, Vec<&str>> {
        let inside = |n: &usize| self.files[*n].layer() == layer;
        let uses = |n: usize| {
            let mut used: Vec<usize> = self.files[n].paths.iter().filter_map(|p| self.definition(&p.segments)).collect();
            used.retain(|m| !self.files[n].module.starts_with(&self.files[*m].module));
            used.sort_by_key(|m| &self.files[*m].path);
            used.dedup();
            used.into_iter().filter(inside).map(|m| self.files[m].path.as_str()).collect()
        };
        (0..self.files.len()).filter(inside).map(|n| (self.files[n].path.as_str(), uses(n))).collect()
    }
}

/// Code without comments, without the content of literals, and without modules and items under `#[cfg(test)]`.
pub fn code_of(text: &str) -> String {
    let stripped = without_comments_and_literals(text);
    let mut code = String::new();
    let mut rest = stripped.as_str();
    while let Some(at) = rest.find("#[cfg(test)]") {
        code.push_str(&rest[..at]);
        rest = &rest[at..];
        // The item ends with its block, or with a semicolon before any block.
        let (mut depth, mut end) = (0, rest.len());
        for (i, c) in rest.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 && matches!(c, '}' | ';') {
                end = i + 1;
                break;
            }
        }
        rest = &rest[end..];
    }
    code + rest
}

fn without_comments_and_literals(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let char_at = |i: usize| chars.get(i).copied().unwrap_or(' ');
    let mut code = String::new();
    let mut i = 0;
    while i < chars.len() {
        let c = chars[i];
        let starts_word = i == 0 || !(char_at(i - 1).is_alphanumeric() || char_at(i - 1) == '_');
        let hashes = (i + 1..).take_while(|k| char_at(*k) == '#').count();
        if c == '/' && char_at(i + 1) == '/' {
            i += chars[i..].iter().take_while(|c| **c != '\n').count();
        } else if c == '/' && char_at(i + 1) == '*' {
            i += 2;
            while i < chars.len() && !(char_at(i) == '*' && char_at(i + 1) == '/') {
                i += 1;
            }
            i += 2;
        } else if c == 'r' && starts_word && char_at(i + 1 + hashes) == '"' {
            i += 2 + hashes;
            while i < chars.len() && !(char_at(i) == '"' && (1..=hashes).all(|k| char_at(i + k) == '#')) {
                i += 1;
            }
            i += 1 + hashes;
            code.push_str("\"\"");
        } else if c == '"' {
            i += 1;
            while i < chars.len() && char_at(i) != '"' {
                i += if char_at(i) == '\\' { 2 } else { 1 };
            }
            i += 1;
            code.push_str("\"\"");
        } else if c == '\'' && (char_at(i + 1) == '\\' || char_at(i + 2) == '\'') {
            i += if char_at(i + 1) == '\\' { 3 } else { 2 };
            while i < chars.len() && char_at(i) != '\'' {
                i += 1;
            }
            i += 1;
            code.push_str("' '");
        } else {
            code.push(c);
            i += 1;
        }
    }
    code
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Token {
    Word(String),
    /// `::`
    PathSeparator,
    Other(char),
}

/// The tokens of a file, from which its paths are read.
struct PathReader<'a> {
    tokens: Vec<Token>,
    module: &'a [String],
    by_module: &'a BTreeMap<Vec<String>, usize>,
}

impl<'a> PathReader<'a> {
    fn new(text: &str, module: &'a [String], by_module: &'a BTreeMap<Vec<String>, usize>) -> Self {
        let code = code_of(text);
        let mut tokens = Vec::new();
        let mut chars = code.chars().peekable();
        while let Some(c) = chars.next() {
            if c.is_alphanumeric() || c == '_' {
                let mut word = String::from(c);
                while let Some(next) = chars.next_if(|c| c.is_alphanumeric() || *c == '_') {
                    word.push(next);
                }
                tokens.push(Token::Word(word));
            } else if c == ':' && chars.next_if_eq(&':').is_some() {
                tokens.push(Token::PathSeparator);
            } else if !c.is_whitespace() {
                tokens.push(Token::Other(c));
            }
        }
        Self { tokens, module, by_module }
    }

    fn word(&self, at: usize) -> Option<&str> {
        match self.tokens.get(at) {
            Some(Token::Word(word)) => Some(word),
            _ => None,
        }
    }

    fn is_char(&self, at: usize, c: char) -> bool {
        self.tokens.get(at) == Some(&Token::Other(c))
    }

    /// The paths that lead to a module of the crate, from the crate root; and the others, as they are written.
    fn paths(&self) -> (Vec<NamedPath>, Vec<String>) {
        let (mut paths, mut external_paths) = (Vec::new(), Vec::new());
        // The inline modules around the token, each with the number of braces open before its own.
        let mut inline: Vec<(String, i32)> = Vec::new();
        let (mut depth, mut at) = (0, 0);
        while at < self.tokens.len() {
            if self.is_char(at, '{') {
                depth += 1;
            } else if self.is_char(at, '}') {
                depth -= 1;
                if inline.last().is_some_and(|(_, d)| *d == depth) {
                    inline.pop();
                }
            }
            let previous = at.checked_sub(1).map(|b| &self.tokens[b]);
            let module = || -> Vec<String> { self.module.iter().cloned().chain(inline.iter().map(|(name, _)| name.clone())).collect() };
            match self.word(at) {
                Some("mod") if self.is_char(at + 2, '{') => inline.push((self.word(at + 1).unwrap_or_default().into(), depth)),
                Some("use") => {
                    // `use`, `pub use` or `pub(crate) use`.
                    let is_public =
                        previous == Some(&Token::Word("pub".into())) || (previous == Some(&Token::Other(')')) && self.is_after_pub(at));
                    let mut leaves = Vec::new();
                    at = self.leaves(at + 1, &mut Vec::new(), &mut leaves);
                    for (path, alias) in leaves {
                        let used_as = alias.or_else(|| path.last().cloned());
                        match self.absolute(&path, &module()) {
                            Some(segments) => paths.push(NamedPath { segments, used_as, is_public_use: is_public }),
                            None => external_paths.push(path.join("::")),
                        }
                    }
                    continue;
                }
                Some(_) if self.tokens.get(at + 1) == Some(&Token::PathSeparator) && previous != Some(&Token::PathSeparator) => {
                    let mut path = vec![self.word(at).unwrap_or_default().to_owned()];
                    while self.tokens.get(at + 1) == Some(&Token::PathSeparator)
                        && let Some(next) = self.word(at + 2)
                    {
                        path.push(next.to_owned());
                        at += 2;
                    }
                    match self.absolute(&path, &module()) {
                        Some(segments) => paths.push(NamedPath { segments, used_as: None, is_public_use: false }),
                        None => external_paths.push(path.join("::")),
                    }
                }
                _ => {}
            }
            at += 1;
        }
        (paths, external_paths)
    }

    /// Whether `pub(...)` ends right before `at`. Looks for its opening parenthesis among the 6 tokens before.
    fn is_after_pub(&self, at: usize) -> bool {
        (at.saturating_sub(6)..at).rev().find(|k| self.is_char(*k, '(')).is_some_and(|k| k > 0 && self.word(k - 1) == Some("pub"))
    }

    /// Appends the paths of the `use` tree that starts at token `at` to `out`, each with its alias. Returns the index of the token after the
    /// tree. `prefix`: the path that leads to the tree.
    fn leaves(&self, mut at: usize, prefix: &mut Vec<String>, out: &mut Vec<(Vec<String>, Option<String>)>) -> usize {
        let prefix_length = prefix.len();
        loop {
            match self.tokens.get(at) {
                Some(Token::Word(word)) if word == "as" => {
                    out.push((prefix.clone(), self.word(at + 1).map(str::to_owned)));
                    prefix.truncate(prefix_length);
                    return at + 2;
                }
                Some(Token::Word(word)) => prefix.push(word.clone()),
                Some(Token::PathSeparator) => {}
                Some(Token::Other('{')) => {
                    at += 1;
                    while at < self.tokens.len() && !self.is_char(at, '}') {
                        at = self.leaves(at, prefix, out);
                        at += usize::from(self.is_char(at, ','));
                    }
                    prefix.truncate(prefix_length);
                    return at + 1;
                }
                Some(Token::Other('*')) => {
                    out.push((prefix.clone(), Some("*".into())));
                    prefix.truncate(prefix_length);
                    return at + 1;
                }
                _ => {
                    if prefix.last().is_some_and(|l| l == "self") && prefix.len() > 1 {
                        prefix.pop();
                    }
                    out.push((prefix.clone(), None));
                    prefix.truncate(prefix_length);
                    return at;
                }
            }
            at += 1;
        }
    }

    /// The path from the crate root; `None` if it leads out of the crate or does not start with a known module.
    fn absolute(&self, path: &[String], module: &[String]) -> Option<Vec<String>> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" | "orrery" => Some(rest.to_vec()),
            "self" => Some(module.iter().chain(rest).cloned().collect()),
            "super" => {
                let levels_up = path.iter().take_while(|s| *s == "super").count();
                let parent = module.get(..module.len().checked_sub(levels_up)?)?;
                Some(parent.iter().chain(&path[levels_up..]).cloned().collect())
            }
            _ => {
                let child: Vec<String> = module.iter().chain([first]).cloned().collect();
                self.by_module.contains_key(&child).then(|| module.iter().chain(path).cloned().collect())
            }
        }
    }
}

#[test]
fn paths_are_read_from_every_form() {
    // Paths that end in `No` are in comments, literals and unit tests, and must not be found.
    let scene = "use super::units::Km;\npub(crate) use self::draw::{Draw, sky::{self, Sky as S}};\nmod draw;\n\
                 // use crate::render::No;\nfn f() { let x = \"crate::render::No\"; crate::time::now::<u8>(draw::Draw::new()); let c = '\"';
                 // }\n\
                 #[cfg(test)]\nmod tests { use crate::cli::No; }\nmod inner { use super::super::catalog::Body; }";
    let tree = SourceTree::new(&[("scene/mod.rs", scene), ("scene/draw.rs", ""), ("main.rs", "fn main() { orrery::cli::run(); }")]);
    let paths_of_file = |n: usize| tree.files[n].paths.iter().map(|p| p.segments.join("::")).collect::<Vec<_>>();
    let expected = [
        "units::Km",
        "scene::draw::Draw",
        "scene::draw::sky",
        "scene::draw::sky::Sky",
        "time::now",
        "scene::draw::Draw::new",
        "catalog::Body",
    ];
    assert_eq!(paths_of_file(0), expected);
    assert_eq!(paths_of_file(2), ["cli::run"]);
    // `Draw`, `sky` and `Sky`.
    assert!(tree.files[0].paths.iter().filter(|p| p.is_public_use).count() == 3, "{:?}", tree.files[0].paths);
}

#[test]
fn a_re_export_leads_to_the_definition() {
    let tree = SourceTree::new(&[("a/mod.rs", "mod b;\npub use b::B as C;"), ("a/b.rs", ""), ("a/c.rs", "use super::C;\nuse super::Own;")]);
    assert_eq!(tree.imports_within("a"), [("a/b.rs", vec![]), ("a/c.rs", vec!["a/b.rs"]), ("a/mod.rs", vec!["a/b.rs"])].into());
}
