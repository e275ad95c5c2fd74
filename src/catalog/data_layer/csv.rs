//! Points in a table of comma-separated values (RFC 4180, without line breaks in values).
//!
//! In: the text. Its first line names the columns; empty lines and lines that begin with # are skipped. Out: points, or the wrong line and field.

use super::columns::Columns;
use super::layer::Content;

/// The values of a line, without their quotes. Within quotes, a doubled quote means one quote.
fn values(line: &str) -> Vec<String> {
    let (mut all, mut value, mut quoted) = (Vec::new(), String::new(), false);
    let mut chars = line.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => {
                chars.next();
                value.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => all.push(std::mem::take(&mut value).trim().to_owned()),
            _ => value.push(c),
        }
    }
    all.push(value.trim().to_owned());
    all
}

/// The points of a table. The error is a line number and what is wrong there.
pub(super) fn read(text: &str, on_body: bool) -> Result<Content, (usize, String)> {
    let mut lines = (1..).zip(text.trim_start_matches('\u{feff}').lines()).filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
    let (first, head) = lines.next().ok_or_else(|| (1, "empty; the first line names the columns".to_owned()))?;
    let columns = Columns::of(&values(head), on_body).map_err(|why| (first, format!("the first line {why}")))?;
    let mut content = Content::default();
    for (number, line) in lines {
        let point = columns.point(&values(line)).and_then(|point| content.count_positions(1).map(|()| point));
        content.points.push(point.map_err(|why| (number, why))?);
    }
    Ok(content)
}
