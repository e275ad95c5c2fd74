//! Reading TOML tables field by field, so that one pass finds every wrong field, not only the first.
//!
//! In: the text of a file. Out: values with their file and line; all problems are added to one shared list, [`Problems`].
//! Serde converts each value to its type. The caller describes the allowed values next to its check.

use super::{CatalogError, Problem};
use crate::wording::{controls_terminal, echo_within};
use orrery_catalogs::CATALOG_FILES;
use serde::de::DeserializeOwned;
use std::cell::RefCell;
use std::rc::Rc;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// File and line of a value.
#[derive(Clone, Debug)]
pub(super) struct SourceLine {
    /// Name of the file.
    pub file: Rc<str>,
    /// Line number, starting at 1.
    pub line: usize,
}

impl SourceLine {
    /// Whether the line is in one of the embedded files.
    pub fn is_embedded(&self) -> bool {
        CATALOG_FILES.iter().any(|(file, _)| *file == &*self.file)
    }
}

/// A value with its file and line.
#[derive(Clone, Debug)]
pub(super) struct WithLine<T> {
    pub value: T,
    pub source_line: SourceLine,
}

/// After this many problems, [`Problems::nearest`] suggests nothing.
const MAX_PROBLEMS_WITH_SUGGESTION: usize = 200;

/// All problems found so far, in the order in which they were found.
#[derive(Default)]
pub(super) struct Problems(RefCell<Vec<Problem>>);

impl Problems {
    pub fn add(&self, source_line: &SourceLine, message: String) {
        self.0.borrow_mut().push(Problem { file: source_line.file.to_string(), line: source_line.line, message });
    }

    /// The known word that was probably meant, if one is similar. `None` after [`MAX_PROBLEMS_WITH_SUGGESTION`] problems: a file can
    /// have a hundred thousand of them, of which only the first are shown.
    pub fn nearest<'k>(&self, word: &str, known: &[&'k str]) -> Option<&'k str> {
        let is_suggestion_wanted = self.0.borrow().len() < MAX_PROBLEMS_WITH_SUGGESTION;
        is_suggestion_wanted.then(|| crate::wording::nearest(word, known.iter().copied()).first().copied()).flatten()
    }

    /// Reports a name that no body has, with the most similar of the known names. `field`: the field that has it.
    pub fn add_unknown_body(&self, field: &str, name: &WithLine<String>, known: &[&str]) {
        let hint = self.nearest(&name.value, known).map_or(String::new(), |n| format!("; did you mean \"{n}\"?"));
        self.add(&name.source_line, format!("{field} \"{}\" is not the name of a body{hint}", echo_within(&name.value, 60)));
    }

    pub fn into_result(self) -> Result<(), CatalogError> {
        if self.0.borrow().is_empty() { Ok(()) } else { Err(self.into_error()) }
    }

    /// The problems in the order of file and line, without duplicates.
    pub fn into_error(self) -> CatalogError {
        let mut problems = self.0.into_inner();
        problems.sort_by(|a, b| (&a.file, a.line, &a.message).cmp(&(&b.file, b.line, &b.message)));
        problems.dedup();
        CatalogError { problems }
    }
}

/// The text of one file. Converts byte offsets to line numbers.
pub(super) struct TomlFile<'a> {
    /// Name of the file.
    file: Rc<str>,
    /// Byte offset of the start of each line.
    line_starts: Vec<usize>,
    text: &'a str,
    problems: &'a Problems,
}

impl<'a> TomlFile<'a> {
    pub fn new(file: &str, text: &'a str, problems: &'a Problems) -> Self {
        let line_starts = std::iter::once(0).chain(text.match_indices('\n').map(|(offset, _)| offset + 1)).collect();
        Self { file: file.into(), line_starts, text, problems }
    }

    /// File and line of a byte offset.
    fn source_line(&self, offset: usize) -> SourceLine {
        SourceLine { file: self.file.clone(), line: self.line_starts.partition_point(|&start| start <= offset).max(1) }
    }

    /// The top-level table; `None` if the text is not TOML. Only the first syntax error is reported, because the parser may report errors after it that the
    /// file does not have.
    pub fn root(&'a self) -> Option<TableReader<'a>> {
        let (table, errors) = DeTable::parse_recoverable(self.text);
        let start = |e: &toml::de::Error| e.span().map_or(0, |s| s.start);
        if let Some(first) = errors.iter().min_by_key(|e| start(e)) {
            self.problems.add(&self.source_line(start(first)), format!("not TOML: {}", first.message().replace('\n', ", ")));
            return None;
        }
        let table = table.into_inner();
        table.values().for_each(|value| self.report_control_characters(value));
        Some(TableReader {
            toml_file: self,
            prefix: String::new(),
            source_line: self.source_line(0),
            unrequested: table,
            requested: Vec::new(),
        })
    }

    /// Reports strings with characters that control a terminal, because names and notes are printed. Line breaks and tabs are allowed.
    fn report_control_characters(&self, value: &Spanned<DeValue>) {
        match value.get_ref() {
            DeValue::String(text) => {
                if let Some(c) = text.chars().find(|c| controls_terminal(*c) && !matches!(c, '\n' | '\r' | '\t')) {
                    self.problems
                        .add(&self.source_line(value.span().start), format!("a string has the control character {}", c.escape_default()));
                }
            }
            DeValue::Array(items) => items.iter().for_each(|item| self.report_control_characters(item)),
            DeValue::Table(fields) => fields.values().for_each(|field| self.report_control_characters(field)),
            _ => {}
        }
    }
}

/// A table being read. The caller requests every allowed field once; [`TableReader::finish`] reports the fields that remain.
pub(super) struct TableReader<'a> {
    toml_file: &'a TomlFile<'a>,
    /// The prefix of fields in messages: a dotted path that ends in a dot, or empty.
    prefix: String,
    /// Where the table begins.
    pub source_line: SourceLine,
    /// The fields that have not been requested yet.
    unrequested: DeTable<'a>,
    /// Fields requested so far.
    requested: Vec<&'static str>,
}

impl<'a> TableReader<'a> {
    /// Sets the prefix of the fields in messages: the name of the body or moment that the table describes.
    pub fn set_message_prefix(&mut self, name: &str) {
        self.prefix = format!("{name}.");
    }

    /// Reports an invalid value of a field. `allowed` describes the values that the field may have.
    pub fn report_invalid(&self, source_line: &SourceLine, field: &str, value: &str, allowed: &str) {
        self.toml_file.problems.add(source_line, format!("{}{field} = {value}: expected {allowed}", self.prefix));
    }

    /// Takes the value of a field, which counts as requested from now on; `None` if the field is absent.
    fn value(&mut self, field: &'static str) -> Option<Spanned<DeValue<'a>>> {
        self.requested.push(field);
        self.unrequested.remove(field)
    }

    /// Whether a field is present.
    pub fn has(&self, field: &str) -> bool {
        self.unrequested.contains_key(field)
    }

    /// The value of a field; `None` if it is absent, or if it has not type `T` or does not pass `ok`, which is reported; `allowed` describes the condition.
    pub fn optional<T: DeserializeOwned>(&mut self, field: &'static str, allowed: &str, ok: impl Fn(&T) -> bool) -> Option<WithLine<T>> {
        let value = self.value(field)?;
        let span = value.span();
        let source_line = self.toml_file.source_line(span.start);
        match T::deserialize(ValueDeserializer::from(value)) {
            Ok(v) if ok(&v) => Some(WithLine { value: v, source_line }),
            _ => {
                let shown: String = self.toml_file.text.get(span).unwrap_or("?").split_whitespace().collect::<Vec<_>>().join(" ");
                self.report_invalid(&source_line, field, &echo_within(&shown, 80), allowed);
                None
            }
        }
    }

    /// Like [`TableReader::optional`], but reports a missing field.
    pub fn required<T: DeserializeOwned>(&mut self, field: &'static str, allowed: &str, ok: impl Fn(&T) -> bool) -> Option<WithLine<T>> {
        if !self.unrequested.contains_key(field) {
            self.toml_file.problems.add(&self.source_line, format!("{}{field} is missing: expected {allowed}", self.prefix));
            self.requested.push(field);
            return None;
        }
        self.optional(field, allowed, ok)
    }

    /// A nested table; `None` if it is absent, or if the field is no table, which is reported.
    pub fn section(&mut self, field: &'static str) -> Option<TableReader<'a>> {
        let value = self.value(field)?;
        let source_line = self.toml_file.source_line(value.span().start);
        match value.into_inner() {
            DeValue::Table(table) => Some(TableReader {
                toml_file: self.toml_file,
                prefix: format!("{}{field}.", self.prefix),
                source_line,
                unrequested: table,
                requested: Vec::new(),
            }),
            other => {
                self.report_invalid(&source_line, field, other.type_str(), "a table");
                None
            }
        }
    }

    /// The tables of `[[field]]`; reports what is not a table and leaves it out.
    pub fn sections(&mut self, field: &'static str) -> Vec<TableReader<'a>> {
        let Some(value) = self.value(field) else { return Vec::new() };
        let source_line = self.toml_file.source_line(value.span().start);
        let DeValue::Array(array) = value.into_inner() else {
            self.report_invalid(&source_line, field, "one value", &format!("tables, each under [[{field}]]"));
            return Vec::new();
        };
        let mut found = Vec::new();
        for item in array {
            let source_line = self.toml_file.source_line(item.span().start);
            match item.into_inner() {
                DeValue::Table(table) => {
                    found.push(TableReader {
                        toml_file: self.toml_file,
                        prefix: format!("{}{field}.", self.prefix),
                        source_line,
                        unrequested: table,
                        requested: Vec::new(),
                    });
                }
                other => self.report_invalid(&source_line, field, other.type_str(), "a table"),
            }
        }
        found
    }

    /// A table whose values are all strings, such as `sources`; empty if it is absent, or if it is of another form, which is reported.
    pub fn strings(&mut self, field: &'static str) -> std::collections::BTreeMap<String, String> {
        let allowed = "a table of strings";
        self.optional(field, allowed, |_| true).map(|l| l.value).unwrap_or_default()
    }

    /// Reports the fields that were not requested, each with the most similar allowed name.
    pub fn finish(self) {
        for key in self.unrequested.keys() {
            let source_line = self.toml_file.source_line(key.span().start);
            let name: &str = key.get_ref();
            let hint = match self.toml_file.problems.nearest(name, &self.requested) {
                Some(n) => format!("did you mean `{n}`?"),
                None => format!("allowed are {}", self.requested.join(", ")),
            };
            self.toml_file.problems.add(&source_line, format!("{}{} is not a field here: {hint}", self.prefix, echo_within(name, 80)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_name_of_no_body_is_cut_in_the_message() {
        let problems = Problems::default();
        let source_line = SourceLine { file: "own.toml".into(), line: 1 };
        problems.add_unknown_body("body", &WithLine { value: "x".repeat(1000), source_line }, &["mars"]);
        let message = &problems.into_error().problems[0].message;
        // 60 characters of the name, and the text around them.
        assert!(message.len() < 100 && message.ends_with("is not the name of a body"), "{message}");
    }
}
