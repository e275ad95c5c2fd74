//! Finds the conditional items of a fragment by scanning its tokens.
//!
//! In: a fragment's text. Out: [`Scan`]: for each item with `@if`, `@elif` or `@else` the spans of the item and of the attribute, the blocks (parts of
//! the text under one condition) that these attributes make, the import statements, and the names of the declarations. An item is a declaration, a struct
//! member, a parameter, an argument, a statement or an import; [`List`] says what ends it. Not here: the division into lines (`fragment`).

use super::block::{Block, ROOT};
use super::condition::Condition;
use std::ops::Range;
use wgsl_parse::lexer::{Lexer, Token};
use wgsl_parse::syntax::{Import as NestedImport, ImportContent, ImportStatement, PathOrigin};

/// An error at a byte position of the text.
pub(super) struct ScanError {
    pub position: usize,
    pub what: String,
}

/// The span of a conditional item, from its attribute to its end.
pub(super) struct ConditionalSpan {
    pub span: Range<usize>,
    /// The item's block: an index in [`Scan::blocks`], as all numbers of blocks here.
    pub block: u32,
}

/// An import statement.
pub(super) struct ImportedItems {
    /// Byte position of its start.
    pub position: usize,
    /// The block to which the statement belongs.
    pub block: u32,
    /// The imported items, each with the path of its fragment without extension: (path, item).
    pub items: Vec<(String, String)>,
}

/// A chain of items with `@if`, `@elif` and `@else`, its branches.
pub(super) struct ConditionChain {
    /// Byte position at which its first item starts.
    pub start: usize,
    /// The block to which the comments above the first item belong: they are emitted if any branch of the chain is.
    pub block: u32,
}

#[derive(Default)]
pub(super) struct Scan {
    /// The blocks, each after those that it refers to. The first is [`ROOT`].
    pub blocks: Vec<Block>,
    /// Spans of inner items come before those of the items that contain them.
    pub conditional_spans: Vec<ConditionalSpan>,
    /// Conditional attributes and import statements, which are never emitted.
    pub removed_spans: Vec<Range<usize>>,
    pub imports: Vec<ImportedItems>,
    pub chains: Vec<ConditionChain>,
    /// Names of the module-scope declarations.
    pub declared: Vec<String>,
}

/// What kind of items a list has, which determines what ends an item.
#[derive(Clone, Copy, PartialEq, Eq)]
enum List {
    /// Declarations end with a semicolon or a closing brace.
    Module,
    /// Statements end with a semicolon or a closing brace.
    Statements,
    /// Members, parameters and arguments end with a comma.
    CommaSeparated,
}

struct Scanner<'a> {
    text: &'a str,
    /// The fragment's path inside shaders/, without extension: an import's `super::` is relative to it.
    path: &'a str,
    tokens: Vec<(Range<usize>, Token)>,
    /// Index of the next token.
    next: usize,
    scan: Scan,
}

/// Scans a fragment's text. `path`: the fragment's path inside shaders/, without extension.
///
/// # Errors
/// Text that is no token, unbalanced brackets, invalid conditions or imports, and conditional attributes inside an item.
pub(super) fn scan(path: &str, text: &str) -> Result<Scan, ScanError> {
    let mut tokens = Vec::new();
    for token in Lexer::new(text) {
        let (start, token, end) = token.map_err(|(position, _, _)| ScanError { position, what: "this is not a WGSL token".into() })?;
        tokens.push((start..end, token));
    }
    let mut scanner = Scanner { text, path, tokens, next: 0, scan: Scan { blocks: vec![Block::Root], ..Scan::default() } };
    scanner.scan_items(ROOT, List::Module)?;
    match scanner.token_text() {
        "" => Ok(scanner.scan),
        bracket => Err(scanner.error(format!("`{bracket}` has no opening bracket"))),
    }
}

impl<'a> Scanner<'a> {
    /// The next token's text; empty at the end of the fragment.
    fn token_text(&self) -> &'a str {
        self.tokens.get(self.next).map_or("", |(span, _)| &self.text[span.clone()])
    }

    /// Position of the next token: its first byte.
    fn position(&self) -> usize {
        self.tokens.get(self.next).map_or(self.text.len(), |(span, _)| span.start)
    }

    /// End of the previous token.
    fn previous_end(&self) -> usize {
        self.next.checked_sub(1).and_then(|k| self.tokens.get(k)).map_or(0, |(span, _)| span.end)
    }

    fn error(&self, what: String) -> ScanError {
        ScanError { position: self.position(), what }
    }

    /// Whether the next token closes a list, or there is none.
    fn is_at_end_of_list(&self) -> bool {
        self.next >= self.tokens.len()
            || matches!(self.token_text(), "}" | ")" | "]")
            || matches!(self.tokens[self.next].1, Token::TemplateArgsEnd)
    }

    /// Scans items up to the bracket that closes their list; the bracket is not consumed.
    fn scan_items(&mut self, parent: u32, list: List) -> Result<(), ScanError> {
        // The branches of the chain that an `@elif` or `@else` would continue, and the start of its first item.
        let mut chain: Vec<u32> = Vec::new();
        let mut chain_start = 0;
        let mut chain_has_else = false;
        while !self.is_at_end_of_list() {
            let start = self.position();
            let (branch, attribute_span) = self.scan_attributes()?.unzip();
            let continues_chain = matches!(branch, Some(Branch::Elif(_) | Branch::Else));
            let previous_branch = if continues_chain { chain.last().copied() } else { None };
            if continues_chain && previous_branch.is_none() {
                return Err(ScanError { position: start, what: "the item before has no `@if`".into() });
            }
            if continues_chain && chain_has_else {
                return Err(ScanError { position: start, what: "the item before is an `@else`, which ends the chain".into() });
            }
            if !continues_chain {
                self.finish_chain(&chain, chain_start);
                chain.clear();
                chain_start = start;
            }
            chain_has_else = matches!(branch, Some(Branch::Else));
            let block = match branch {
                None => parent,
                Some(Branch::If(condition) | Branch::Elif(condition)) => {
                    self.push_block(Block::When { parent, condition, previous_branch })
                }
                Some(Branch::Else) => self.push_block(Block::When { parent, condition: Condition::Constant(true), previous_branch }),
            };
            if self.token_text() == "import" && list == List::Module {
                self.scan_import(block)?;
            } else {
                self.scan_item(block, list)?;
            }
            if let Some(attribute_span) = attribute_span {
                self.scan.removed_spans.push(attribute_span);
                self.scan.conditional_spans.push(ConditionalSpan { span: start..self.previous_end(), block });
                chain.push(block);
            }
        }
        self.finish_chain(&chain, chain_start);
        Ok(())
    }

    /// Adds a block; returns its index.
    fn push_block(&mut self, block: Block) -> u32 {
        self.scan.blocks.push(block);
        self.scan.blocks.len() as u32 - 1
    }

    /// Records the chain that consists of these branches, unless there are none. `start`: position of the chain's first item.
    fn finish_chain(&mut self, chain: &[u32], start: usize) {
        let block = match chain {
            [] => return,
            [only] => *only,
            several => self.push_block(Block::AnyOf(several.to_vec())),
        };
        self.scan.chains.push(ConditionChain { start, block });
    }

    /// Scans the attributes before an item; returns the conditional attribute, if there is one, with its span.
    fn scan_attributes(&mut self) -> Result<Option<(Branch, Range<usize>)>, ScanError> {
        let mut found = None;
        while self.token_text() == "@" {
            let start = self.position();
            self.next += 1;
            let name = self.token_text().to_owned();
            self.next += 1;
            let argument = if self.token_text() == "(" {
                let open = self.position() + 1;
                self.next += 1;
                // `ROOT`: the item's own block is known only after its attributes.
                self.scan_items(ROOT, List::CommaSeparated)?;
                let close = self.position();
                self.expect(")")?;
                Some(open..close)
            } else {
                None
            };
            let condition = |attribute: &str| {
                let span = argument
                    .clone()
                    .ok_or_else(|| ScanError { position: start, what: format!("`@{attribute}` has no condition in parentheses") })?;
                Condition::parse(&self.text[span.clone()]).map_err(|what| ScanError { position: span.start, what })
            };
            let branch = match name.as_str() {
                "if" => Branch::If(condition("if")?),
                "elif" => Branch::Elif(condition("elif")?),
                "else" => Branch::Else,
                _ => continue,
            };
            if found.replace((branch, start..self.previous_end())).is_some() {
                return Err(ScanError { position: start, what: "an item has one condition; join several with `&&`".into() });
            }
        }
        Ok(found)
    }

    /// Consumes the next token, which must be this one.
    fn expect(&mut self, token: &str) -> Result<(), ScanError> {
        if self.token_text() != token {
            return Err(self.error(format!("`{token}` is missing here")));
        }
        self.next += 1;
        Ok(())
    }

    /// Scans one item after its attributes, including the semicolon or comma that ends it.
    fn scan_item(&mut self, block: u32, list: List) -> Result<(), ScanError> {
        let first = self.next;
        if list == List::Module {
            self.record_declaration(first);
        }
        let is_struct = self.token_text() == "struct";
        while !self.is_at_end_of_list() {
            let (_, token) = &self.tokens[self.next];
            let opens_template = matches!(token, Token::TemplateArgsStart);
            match self.token_text() {
                "(" | "[" => self.scan_bracketed(block, List::CommaSeparated)?,
                "<" if opens_template => self.scan_bracketed(block, List::CommaSeparated)?,
                "{" => {
                    // A statement or declaration ends with its braces, but an `if` goes on with `else`.
                    self.scan_bracketed(block, if is_struct { List::CommaSeparated } else { List::Statements })?;
                    if list != List::CommaSeparated && self.token_text() != "else" {
                        return Ok(());
                    }
                }
                ";" if list != List::CommaSeparated => {
                    self.next += 1;
                    return Ok(());
                }
                "," if list == List::CommaSeparated => {
                    self.next += 1;
                    return Ok(());
                }
                "@" if matches!(self.tokens.get(self.next + 1).map(|(s, _)| &self.text[s.clone()]), Some("if" | "elif" | "else")) => {
                    let what = "a condition must come before a declaration, a member, a parameter or a statement; here it is within one";
                    return Err(self.error(what.into()));
                }
                _ => self.next += 1,
            }
        }
        Ok(())
    }

    /// Scans a list with its brackets. `block`: the block of the item to which the list belongs.
    fn scan_bracketed(&mut self, block: u32, list: List) -> Result<(), ScanError> {
        let open = self.position();
        let close = match self.token_text() {
            "(" => ")",
            "[" => "]",
            "{" => "}",
            _ => ">",
        };
        self.next += 1;
        self.scan_items(block, list)?;
        // `starts_with`: where `>>` closes two template lists, the lexer gives two tokens, the first with the text `>>`, the second with its second half.
        if !self.token_text().starts_with(close) {
            return Err(ScanError { position: open, what: format!("this is not closed by `{close}`") });
        }
        self.next += 1;
        Ok(())
    }

    /// Records the name of the declaration that begins with the token of index `first`.
    fn record_declaration(&mut self, first: usize) {
        let (tokens, text) = (&self.tokens, self.text);
        let word = |k: usize| tokens.get(k).map_or("", |(span, _)| &text[span.clone()]);
        let name = match word(first) {
            "fn" | "struct" | "const" | "override" | "alias" => word(first + 1),
            "var" if word(first + 1) == "<" => {
                // Without a closing bracket this is no WGSL, and the name does not matter.
                let end = (first + 2..self.tokens.len()).find(|k| word(*k).starts_with('>')).unwrap_or(first);
                word(end + 1)
            }
            "var" => word(first + 1),
            _ => return,
        };
        self.scan.declared.push(name.to_owned());
    }

    fn scan_import(&mut self, block: u32) -> Result<(), ScanError> {
        let start = self.position();
        while !matches!(self.token_text(), ";" | "") {
            self.next += 1;
        }
        self.expect(";")?;
        let span = start..self.previous_end();
        let error = |what: String| ScanError { position: start, what };
        let statement: ImportStatement = self.text[span.clone()].parse().map_err(|e: wgsl_parse::Error| error(e.error.to_string()))?;
        let mut base: Vec<String> = match statement.path.as_ref().map(|p| &p.origin) {
            Some(PathOrigin::Absolute) => Vec::new(),
            Some(PathOrigin::Relative(levels_up)) => {
                let own_path: Vec<String> = self.path.split('/').map(str::to_owned).collect();
                own_path[..own_path.len().saturating_sub(*levels_up)].to_vec()
            }
            _ => return Err(error("an import begins with `package::` or `super::`".into())),
        };
        base.extend(statement.path.iter().flat_map(|p| p.components.clone()));
        let mut items = Vec::new();
        flatten_import(&base, &statement.content, &mut items).map_err(error)?;
        self.scan.removed_spans.push(span);
        self.scan.imports.push(ImportedItems { position: start, block, items });
        Ok(())
    }
}

/// Appends the items of an import, which may be nested, as (fragment path without extension, item).
fn flatten_import(base: &[String], content: &ImportContent, items: &mut Vec<(String, String)>) -> Result<(), String> {
    match content {
        ImportContent::Item(item) if item.rename.is_some() => {
            Err("a shader source's text is taken as it is: `as` cannot rename an item".into())
        }
        ImportContent::Item(_) if base.is_empty() => {
            Err("an import names a shader source and an item of it: `package::lib::draw::draw`".into())
        }
        ImportContent::Item(item) => {
            items.push((base.join("/"), item.ident.name().clone()));
            Ok(())
        }
        ImportContent::Collection(all) => all.iter().try_for_each(|NestedImport { path, content }| {
            let base: Vec<String> = base.iter().chain(path).cloned().collect();
            flatten_import(&base, content, items)
        }),
    }
}

/// An item's conditional attribute, which makes the item a branch of a chain.
enum Branch {
    If(Condition),
    Elif(Condition),
    Else,
}
