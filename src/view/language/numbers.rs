//! Formats and parses numbers as is usual in the window's language.
//!
//! In: a number and its number of decimals, or typed text. Out: text with the language's decimal mark, or the number. Always: a typed number may have
//! the language's own decimal mark, or a decimal point. Not for files, links or the command line.

use super::text;
use std::fmt::Display;

/// A number with a fixed number of decimals.
pub(crate) fn decimal(value: impl Display, digits: usize) -> String {
    localised(format!("{value:.digits$}"))
}

/// A number with its sign and a fixed number of decimals.
pub(crate) fn signed(value: impl Display, digits: usize) -> String {
    localised(format!("{value:+.digits$}"))
}

/// A number's text with the decimal mark of the language in place of the point.
pub(crate) fn localised(number: String) -> String {
    match text!("number-decimal-mark") {
        "." => number,
        mark => number.replace('.', mark),
    }
}

/// The mark that separates thousands.
pub(crate) fn group_mark() -> &'static str {
    text!("number-group-mark")
}

/// The text of sliders and number fields, for egui.
pub(crate) fn field_text(value: f64, decimals: std::ops::RangeInclusive<usize>) -> String {
    localised(egui::emath::format_with_decimals_in_range(value, decimals))
}

/// A typed number, with a decimal point, or with the decimal mark of the language.
pub(crate) fn typed_number(text: &str) -> Option<f64> {
    let plain: String = text.chars().filter(|c| !c.is_whitespace()).map(|c| if c == '−' { '-' } else { c }).collect();
    match text!("number-decimal-mark") {
        // A text with the language's decimal mark may also contain its thousands separators.
        mark if mark != "." && plain.contains(mark) => plain.replace(group_mark(), "").replace(mark, ".").parse().ok(),
        _ => plain.parse().ok(),
    }
}
