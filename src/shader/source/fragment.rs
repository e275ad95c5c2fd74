//! A parsed fragment (a WESL source file).
//!
//! In: a fragment's path and text. Out: its lines, divided into pieces; the block of each piece (a [`Block`] is the text under one condition); its
//! imports and declared names; and, for a set of features, which blocks a module includes, and why.

use super::block::{Block, ROOT};
use super::condition::{Condition, FeatureSet};
use super::limits::first_exceeded_limit;
use super::scan::{ConditionChain, Scan, ScanError, scan};
use crate::shader::ShaderError;
use std::ops::Range;

/// Block number of text that is never emitted: the attributes `@if(...)`, `@elif(...)` and `@else` themselves, and import statements.
const REMOVED: u32 = u32::MAX;

/// Part of a line that belongs to one block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Bytes of the fragment's text.
    pub span: Range<usize>,
    /// Index into [`Fragment::blocks`].
    pub block: u32,
}

/// One line of a fragment, without its conditional attributes and imports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FragmentLine {
    pub pieces: Vec<Piece>,
    /// Whether text was removed from the line, or the line belongs to several blocks. Such a line is dropped if what is emitted of it is blank. A line that is
    /// blank in the file, by contrast, is kept.
    pub is_divided: bool,
}

/// One imported item.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Import {
    /// The block of the import statement: index into [`Fragment::blocks`].
    pub block: u32,
    /// Line and column (in characters) of the statement, both from 1.
    pub line: u32,
    pub column: u32,
    /// Path of the imported fragment inside shaders/.
    pub path: String,
    /// The imported name.
    pub item: String,
}

/// A parsed fragment. Line `n` (from 1) is `lines[n - 1]`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fragment {
    pub lines: Vec<FragmentLine>,
    /// Each after the blocks to which it refers.
    pub blocks: Vec<Block>,
    /// The imported items, in the order of the text.
    pub imports: Vec<Import>,
    /// Names of the fragment's declarations, whatever their conditions are.
    pub declared: Vec<String>,
}

/// Line and column (in characters) of a byte position, both from 1.
pub(super) fn line_and_column(text: &str, position: usize) -> (u32, u32) {
    let before = &text[..text.floor_char_boundary(position)];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    (line as u32, column as u32)
}

impl Fragment {
    /// Parses a trusted text: without the limits and the grammar check of [`Fragment::check`].
    ///
    /// # Errors
    /// The first syntax error or unsupported construct, with line and column.
    pub fn parse(path: &str, text: &str) -> Result<Self, ShaderError> {
        let error = |position: usize, what: String| {
            let (line, column) = line_and_column(text, position);
            ShaderError::Fragment { path: path.to_owned(), line, column, what }
        };
        if let Some(legacy_at) = legacy_directive_at(text) {
            let what = "`//: if`, `//: else` and `//: use` are no longer read: write `@if(lights_1)` before each declaration, member or \
                        statement, and `import package::lib::draw::draw;` (`orrery shader export` writes the shader sources of this version)";
            return Err(error(legacy_at, what.into()));
        }
        let scan = scan(path.trim_end_matches(".wesl"), text).map_err(|ScanError { position, what }| error(position, what))?;
        Ok(Self::of(text, scan))
    }

    /// Parses an untrusted text: enforces limits, and checks the entire text against the WESL grammar, including the parts that no key includes.
    ///
    /// # Errors
    /// An exceeded limit (`limits`), the errors of [`Fragment::parse`], or the first grammar error, with line and column.
    pub fn check(path: &str, text: &str) -> Result<Self, ShaderError> {
        if let Some((start, what)) = first_exceeded_limit(text) {
            let (line, column) = line_and_column(text, start);
            return Err(ShaderError::Fragment { path: path.to_owned(), line, column, what });
        }
        let fragment = Self::parse(path, text)?;
        match wgsl_parse::parse_str(text) {
            Ok(_) => Ok(fragment),
            Err(e) => {
                let (line, column) = line_and_column(text, e.span.start);
                Err(ShaderError::Fragment { path: path.to_owned(), line, column, what: short_message(&e.error) })
            }
        }
    }

    /// Divides a scanned text into lines and pieces.
    fn of(text: &str, scan: Scan) -> Self {
        let block_of_byte = blocks_of_bytes(text, &scan);
        let mut lines = Vec::new();
        let mut start = 0;
        for line in text.split('\n') {
            let end = start + line.len();
            let mut pieces: Vec<Piece> = Vec::new();
            let mut has_removed = false;
            for (byte, &block) in (start..).zip(&block_of_byte[start..end]) {
                match pieces.last_mut() {
                    _ if block == REMOVED => has_removed = true,
                    Some(last) if last.block == block && last.span.end == byte => last.span.end = byte + 1,
                    _ => pieces.push(Piece { span: byte..byte + 1, block }),
                }
            }
            if start == end
                && let Some(&block) = block_of_byte.get(start)
            {
                // An empty line belongs to the block of its line break; within a list of imports it is removed.
                match block {
                    REMOVED => has_removed = true,
                    _ => pieces.push(Piece { span: start..start, block }),
                }
            }
            lines.push(FragmentLine { is_divided: has_removed || pieces.len() > 1, pieces });
            start = end + 1;
        }
        if text.ends_with('\n') {
            lines.pop();
        }
        let imports = scan.imports.into_iter().flat_map(|i| {
            let (line, column) = line_and_column(text, i.position);
            let import = move |(stem, item): (String, String)| Import { block: i.block, line, column, path: format!("{stem}.wesl"), item };
            i.items.into_iter().map(import)
        });
        Self { lines, imports: imports.collect(), blocks: scan.blocks, declared: scan.declared }
    }

    /// For each block, whether it is emitted for these features.
    pub fn emitted_blocks(&self, features: FeatureSet) -> Vec<bool> {
        let mut emitted: Vec<bool> = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let is_emitted = match block {
                Block::Root => true,
                Block::AnyOf(blocks) => blocks.iter().any(|b| emitted[*b as usize]),
                Block::When { parent, condition, previous_branch } => {
                    emitted[*parent as usize] && !self.any_branch_holds(*previous_branch, features) && condition.holds(features)
                }
            };
            emitted.push(is_emitted);
        }
        emitted
    }

    /// Whether the condition of the branch `last`, or of an earlier branch of its chain, holds; false if `last` is `None`.
    fn any_branch_holds(&self, last: Option<u32>, features: FeatureSet) -> bool {
        let mut next = last;
        while let Some(Block::When { condition, previous_branch, .. }) = next.map(|b| &self.blocks[b as usize]) {
            if condition.holds(features) {
                return true;
            }
            next = *previous_branch;
        }
        false
    }

    /// The text by which the source map explains an emitted block: why its condition holds; for an `@else`, why the condition of the branch before it fails;
    /// for the comments above a chain, the text of the emitted branch; `None` for the root. `emitted`: for each block, whether it is emitted.
    pub fn reason(&self, block: u32, emitted: &[bool], features: FeatureSet) -> Option<String> {
        match &self.blocks[block as usize] {
            Block::Root => None,
            Block::AnyOf(blocks) => blocks.iter().find(|b| emitted[**b as usize]).and_then(|b| self.reason(*b, emitted, features)),
            // An `@else`.
            Block::When { condition: Condition::Constant(true), previous_branch: Some(b), .. } => match &self.blocks[*b as usize] {
                Block::When { condition, .. } => Some(condition.reason(features)),
                _ => None,
            },
            Block::When { condition, .. } => Some(condition.reason(features)),
        }
    }
}

/// For each byte, the block to which it belongs, or [`REMOVED`].
fn blocks_of_bytes(text: &str, scan: &Scan) -> Vec<u32> {
    let mut block_of_byte = vec![ROOT; text.len()];
    // Outer spans first, so that inner ones overwrite them; the scanner lists inner ones first.
    for item in scan.conditional_spans.iter().rev() {
        let end = end_with_comment(text, item.span.end);
        block_of_byte[item.span.start..end].fill(item.block);
    }
    // Comments above the first branch of a chain belong to all branches.
    for ConditionChain { start, block } in &scan.chains {
        block_of_byte[comments_above(text, *start)..line_start(text, *start)].fill(*block);
    }
    for item in &scan.conditional_spans {
        let above = comments_above(text, item.span.start)..line_start(text, item.span.start);
        // Comments above a later branch belong to that branch.
        if !scan.chains.iter().any(|c| c.start == item.span.start) {
            block_of_byte[above].fill(item.block);
        }
    }
    for removed in &scan.removed_spans {
        let trailing_blanks = text[removed.end..].bytes().take_while(|b| *b == b' ').count();
        block_of_byte[removed.start..removed.end + trailing_blanks].fill(REMOVED);
    }
    block_of_byte
}

/// Start of the line that contains a byte position.
fn line_start(text: &str, position: usize) -> usize {
    text[..position].rfind('\n').map_or(0, |n| n + 1)
}

/// Start of the comment lines directly above an item. Without any, or if other text precedes the item on its line: the start of that line.
fn comments_above(text: &str, item_start: usize) -> usize {
    let mut first = line_start(text, item_start);
    if !text[first..item_start].trim().is_empty() {
        return first;
    }
    while first > 0 {
        let above = line_start(text, first - 1);
        if !text[above..first].trim_start().starts_with("//") {
            break;
        }
        first = above;
    }
    first
}

/// The end of an item, including a comment after it on the same line.
fn end_with_comment(text: &str, end: usize) -> usize {
    let rest = text[end..].split('\n').next().unwrap_or_default();
    if rest.trim_start().starts_with("//") { end + rest.len() } else { end }
}

/// Position of the first directive of the syntax that preceded WESL, such as `//: if`.
fn legacy_directive_at(text: &str) -> Option<usize> {
    let mut start = 0;
    for line in text.split('\n') {
        if line.trim_start().starts_with("//:") {
            return Some(start + line.len() - line.trim_start().len());
        }
        start += line.len() + 1;
    }
    None
}

/// A parser's error without the list of expected tokens.
fn short_message(error: &wgsl_parse::error::ErrorKind) -> String {
    use wgsl_parse::error::ErrorKind;
    match error {
        ErrorKind::UnexpectedToken { token, .. } => format!("`{token}` is unexpected here"),
        ErrorKind::UnexpectedEof { .. } => "the file ends too early".into(),
        other => other.to_string(),
    }
}
