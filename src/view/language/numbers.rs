//! Formats and parses numbers as is usual in the window's language.
//!
//! In: a number and its number of decimals, or typed text. Out: text with the language's decimal mark, or the number. Always: a typed number may have
//! the language's own decimal mark, or a decimal point. Not for files, links or the command line.

use super::text;
use crate::units::SECONDS_PER_DAY;
use std::fmt::Display;

/// Largest exponent of ten, positive or negative, that [`number_text`] replaces by digits.
const MAX_REPLACED_EXPONENT: i32 = 9;

/// A number with a fixed number of decimals. A negative number that is rounded to 0 has no sign.
pub(crate) fn decimal(value: impl Display, decimals: usize) -> String {
    localised(without_minus_zero(format!("{value:.decimals$}"), ""))
}

/// A number with its sign, `+` or `-`, and a fixed number of decimals. A negative number that is rounded to 0 has the sign of 0, `+`.
pub(crate) fn signed(value: impl Display, decimals: usize) -> String {
    localised(without_minus_zero(format!("{value:+.decimals$}"), "+"))
}

/// The text of a number; if it is a minus sign before zeros, with `sign` in place of the minus sign.
fn without_minus_zero(number: String, sign: &str) -> String {
    match number.strip_prefix('-') {
        Some(zeros) if zeros.bytes().all(|b| matches!(b, b'0' | b'.')) => format!("{sign}{zeros}"),
        _ => number,
    }
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

/// A number with `decimals` decimals and thousands separators. A negative number that is rounded to 0 has no sign.
pub(crate) fn grouped(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value.abs());
    let (whole, mark_and_decimals) =
        text.split_once('.').map_or((text.as_str(), String::new()), |(whole, fraction)| (whole, localised(format!(".{fraction}"))));
    let groups: Vec<&str> = whole.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    let sign = if value < 0.0 && text.contains(|c| !matches!(c, '0' | '.')) { "-" } else { "" };
    format!("{sign}{}{mark_and_decimals}", groups.join(group_mark()))
}

/// A number that another module has written: `1.19e3` becomes `1 190`. The number of significant digits is unchanged.
pub(crate) fn number_text(number: &str) -> String {
    without_exponent(number).unwrap_or_else(|| localised(number.to_owned()))
}

/// The digits of a number such as `1.19e3`, with thousands separators. `None` if the number has no exponent, or one that would require too many digits.
fn without_exponent(number: &str) -> Option<String> {
    let (mantissa, exponent) = number.split_once('e')?;
    let exponent: i32 = exponent.parse().ok().filter(|e: &i32| (-MAX_REPLACED_EXPONENT..=MAX_REPLACED_EXPONENT).contains(e))?;
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let decimals = i32::try_from(decimals).ok()? - exponent;
    let value: f64 = number.parse().ok()?;
    Some(grouped(value, usize::try_from(decimals).unwrap_or(0)))
}

/// The text of sliders and number fields, for egui. A negative number that is rounded to 0 has no sign.
pub(crate) fn field_text(value: f64, decimals: std::ops::RangeInclusive<usize>) -> String {
    localised(without_minus_zero(egui::emath::format_with_decimals_in_range(value, decimals), ""))
}

/// A typed number, with a decimal point, or with the decimal mark of the language. `None` also for the words `inf` and `nan`, for which a field
/// would take its largest value, and for numbers beyond the range of f64.
pub(crate) fn typed_number(text: &str) -> Option<f64> {
    let compact: String = text.chars().filter(|c| !c.is_whitespace()).map(|c| if c == '−' { '-' } else { c }).collect();
    let number: Option<f64> = match text!("number-decimal-mark") {
        // A text with the language's decimal mark may also contain its thousands separators.
        mark if mark != "." && compact.contains(mark) => compact.replace(group_mark(), "").replace(mark, ".").parse().ok(),
        _ => compact.parse().ok(),
    };
    number.filter(|number| number.is_finite())
}

/// A typed whole number. It may have thousands separators: a point between groups of three digits is no decimal point if the language separates thousands
/// by points.
pub(crate) fn typed_whole_number(text: &str) -> Option<f64> {
    let text = text.trim();
    let (first, groups) = text.split_once(group_mark()).unwrap_or((text, ""));
    let is_digits = |digits: &str| digits.bytes().all(|b| b.is_ascii_digit());
    let first = first.trim_start_matches(['-', '−', '+']);
    let begins_groups = (1..=3).contains(&first.len()) && is_digits(first);
    let is_grouped = begins_groups && groups.split(group_mark()).all(|group| group.len() == 3 && is_digits(group));
    let number = if is_grouped { typed_number(&text.replace(group_mark(), "")) } else { typed_number(text) };
    number.filter(|number| number.fract() == 0.0)
}

/// A typed angle in degrees, whose sign of degrees may be left out; `None` as for [`typed_number`].
pub(crate) fn typed_degrees(text: &str) -> Option<f64> {
    typed_number(text.trim().trim_end_matches('°'))
}

/// A typed length of time, seconds: a number of seconds, or of another unit (`min`, `h`, `d`, also in capitals); `None` as for [`typed_number`].
pub(crate) fn typed_seconds(text: &str) -> Option<f64> {
    let text = text.trim().to_lowercase();
    let units = [("min", 60.0), ("s", 1.0), ("h", 3600.0), ("d", SECONDS_PER_DAY)];
    let with_unit = units.into_iter().find_map(|(unit, unit_s)| text.strip_suffix(unit).map(|number| (number, unit_s)));
    let (number, unit_s) = with_unit.unwrap_or((text.as_str(), 1.0));
    typed_number(number).map(|number| number * unit_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::language::{Language, set};

    #[test]
    fn a_number_that_is_rounded_to_zero_has_no_sign() {
        set(Language::English);
        for (value, decimals, text) in [
            (-0.4, 0, "0"),
            (-0.0, 1, "0.0"),
            (-0.004, 2, "0.00"),
            (-0.006, 2, "-0.01"),
            (-0.6, 0, "-1"),
            (-1234.0, 0, "-1 234"),
            (0.4, 0, "0"),
        ] {
            assert_eq!(grouped(value, decimals), text, "{value}");
        }
        for (value, decimals, plain, with_sign, of_field) in [
            (-0.0, 1, "0.0", "+0.0", "0.0"),
            (-0.004, 2, "0.00", "+0.00", "0.00"),
            (-0.006, 2, "-0.01", "-0.01", "-0.01"),
            (-0.4, 0, "0", "+0", "0"),
            (-10.0, 1, "-10.0", "-10.0", "-10.0"),
            (0.0, 1, "0.0", "+0.0", "0.0"),
        ] {
            let texts = [decimal(value, decimals), signed(value, decimals), field_text(value, decimals..=decimals)];
            assert_eq!(texts, [plain, with_sign, of_field], "{value}");
        }
        set(Language::German);
        assert_eq!([decimal(-0.004, 2), signed(-0.004, 2), field_text(-0.0, 1..=1)], ["0,00", "+0,00", "0,0"]);
        set(Language::English);
    }

    /// In German a point separates thousands; where a decimal point makes sense, it is one in every language.
    #[test]
    fn whole_numbers_may_have_separators() {
        set(Language::German);
        for (text, whole, number) in [
            ("1.000", Some(1000.0), Some(1.0)),
            ("1.234.567", Some(1_234_567.0), None),
            ("-1.000", Some(-1000.0), Some(-1.0)),
            ("1.000,0", Some(1000.0), Some(1000.0)),
            ("12", Some(12.0), Some(12.0)),
            ("-7", Some(-7.0), Some(-7.0)),
            ("12.00", Some(12.0), Some(12.0)),
            ("1.23", None, Some(1.23)),
            ("1234.567", None, Some(1234.567)),
            (".123", None, Some(0.123)),
            ("1..000", None, None),
            ("", None, None),
        ] {
            assert_eq!((typed_whole_number(text), typed_number(text)), (whole, number), "{text}");
        }
        set(Language::English);
        for (text, whole) in [("1 000", Some(1000.0)), ("1.000", Some(1.0)), ("1,000", None), ("1.5", None)] {
            assert_eq!(typed_whole_number(text), whole, "{text}");
        }
    }

    #[test]
    fn numbers_of_other_modules_have_no_exponent_and_keep_their_digits() {
        for (number, english, german) in [
            ("1.19e3", "1 190", "1.190"),
            ("1.2e6", "1 200 000", "1.200.000"),
            ("9.99e0", "9.99", "9,99"),
            ("1.52e-4", "0.000152", "0,000152"),
            ("-5.60e-2", "-0.0560", "-0,0560"),
            ("3.20e-15", "3.20e-15", "3,20e-15"),
            ("1e-2147483648", "1e-2147483648", "1e-2147483648"),
            ("243703.4", "243703.4", "243703,4"),
            ("NaN", "NaN", "NaN"),
        ] {
            set(Language::English);
            assert_eq!(number_text(number), english);
            set(Language::German);
            assert_eq!(number_text(number), german);
        }
        set(Language::English);
    }
}
