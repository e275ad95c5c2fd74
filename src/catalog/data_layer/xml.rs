//! A streaming XML reader that reports elements with line numbers.
//!
//! In: text. Out: calls of an [`ElementHandler`] where each element begins and ends; at the end the element's own text is known, too.
//! Always: only XML's predefined entities and character references are resolved, so that no entity expands without bound; the nesting depth is limited.

use crate::wording::{echo_within, one_line};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// Maximum nesting depth.
const MAX_DEPTH: usize = 64;

/// An element whose end has not been read yet.
pub(super) struct Element {
    /// The name without its namespace prefix.
    pub name: String,
    attributes: Vec<(String, String)>,
    /// The element's own text, without the text of nested elements.
    pub text: String,
    /// The line where it begins, starting at 1.
    pub line: usize,
}

impl Element {
    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }
}

/// Receives the elements of a document. `path`: the open elements, the outermost first. An error states what is wrong.
pub(super) trait ElementHandler {
    /// Called when the last element of `path` begins.
    fn start_element(&mut self, path: &[Element]) -> Result<(), String>;
    /// Called when the last element of `path` ends.
    fn end_element(&mut self, path: &[Element]) -> Result<(), String>;
}

/// Counts lines up to a byte offset; offsets must not decrease.
struct LineCounter<'a> {
    text: &'a [u8],
    /// Byte offset up to which line breaks are counted.
    counted_to: usize,
    /// The line that contains this offset, starting at 1.
    line: usize,
}

impl LineCounter<'_> {
    /// The line that contains a byte offset.
    fn line_at(&mut self, offset: usize) -> usize {
        let offset = offset.min(self.text.len());
        self.line += self.text.get(self.counted_to..offset).map_or(0, |part| part.iter().filter(|b| **b == b'\n').count());
        self.counted_to = self.counted_to.max(offset);
        self.line
    }
}

/// The element that a start tag opens.
fn element(start: &BytesStart<'_>, line: usize) -> Result<Element, String> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let mut attributes = Vec::new();
    for attribute in start.attributes() {
        let attribute = attribute.map_err(|e| format!("not XML: {}", one_line(&e.to_string())))?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|e| format!("not XML: {}", one_line(&e.to_string())))?;
        attributes.push((text(attribute.key.local_name().as_ref()), value.into_owned()));
    }
    Ok(Element { name: text(start.local_name().as_ref()), attributes, text: String::new(), line })
}

/// Reads a document and calls the handler for each element.
///
/// # Errors
/// The line number, and what is wrong there.
pub(super) fn walk(document: &str, handler: &mut impl ElementHandler) -> Result<(), (usize, String)> {
    let mut reader = Reader::from_str(document);
    let mut line_counter = LineCounter { text: document.as_bytes(), counted_to: 0, line: 1 };
    let mut path: Vec<Element> = Vec::new();
    let mut has_root = false;
    loop {
        let line = line_counter.line_at(usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX));
        let not_xml = |e: &dyn std::fmt::Display| (line, format!("not XML: {}", one_line(&e.to_string())));
        let event = reader.read_event().map_err(|e| not_xml(&e))?;
        match event {
            Event::Start(start) => {
                // The event begins on `line`: the reader returns the whitespace before a tag as a text event of its own.
                has_root = true;
                path.push(element(&start, line).map_err(|why| (line, why))?);
                if path.len() > MAX_DEPTH {
                    return Err((line, format!("more than {MAX_DEPTH} elements within each other")));
                }
                handler.start_element(&path).map_err(|why| (line, why))?;
            }
            Event::Empty(start) => {
                // An empty element contains no others, so the depth is not checked.
                has_root = true;
                path.push(element(&start, line).map_err(|why| (line, why))?);
                handler.start_element(&path).and_then(|()| handler.end_element(&path)).map_err(|why| (line, why))?;
                path.pop();
            }
            Event::End(_) => {
                // A wrong element is reported at the line where it begins.
                handler.end_element(&path).map_err(|why| (path.last().map_or(line, |e| e.line), why))?;
                path.pop();
            }
            Event::Text(text) => {
                let text = text.decode().map_err(|e| not_xml(&e))?;
                if let Some(open) = path.last_mut() {
                    open.text.push_str(&text);
                }
            }
            Event::CData(text) => {
                let text = text.decode().map_err(|e| not_xml(&e))?;
                if let Some(open) = path.last_mut() {
                    open.text.push_str(&text);
                }
            }
            Event::GeneralRef(reference) => {
                let by_number = reference.resolve_char_ref().map_err(|e| not_xml(&e))?;
                let name = reference.decode().map_err(|e| not_xml(&e))?;
                let character = by_number.or(match name.as_ref() {
                    "amp" => Some('&'),
                    "lt" => Some('<'),
                    "gt" => Some('>'),
                    "quot" => Some('"'),
                    "apos" => Some('\''),
                    _ => None,
                });
                let character =
                    character.ok_or_else(|| (line, format!("the entity &{}; is not predefined in XML", echo_within(&name, 40))))?;
                if let Some(open) = path.last_mut() {
                    open.text.push(character);
                }
            }
            Event::Eof if !path.is_empty() => {
                return Err((line, format!("the file ends within <{}>", echo_within(&path[path.len() - 1].name, 40))));
            }
            Event::Eof if !has_root => return Err((1, "not XML: no element in it".to_owned())),
            Event::Eof => return Ok(()),
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => {}
        }
    }
}
