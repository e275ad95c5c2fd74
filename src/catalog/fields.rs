//! Readers of values that occur in several tables of a catalog: numbers in a range, one of a few words, maps.
//!
//! In: a [`TableReader`]. Out: the checked value; or `None`, with a problem in the reader's list unless an optional field is merely absent.

use super::table::{TableReader, WithLine};
use super::{AlbedoHarmonics, Map, MapLatitude};

/// What [`is_file_name`] accepts, for messages.
pub(super) const ALLOWED_FILE_NAME: &str = "a file name without folders";

/// Whether a text is a plain file name, without a folder.
pub(super) fn is_file_name(text: &str) -> bool {
    !text.is_empty() && !text.contains(['/', '\\']) && !matches!(text, "." | "..")
}

/// Whether a number is finite, for checks of fields.
pub(super) fn finite(v: &f64) -> bool {
    v.is_finite()
}

/// A check of three components: each is finite and passes `check`.
pub(super) fn each_component(check: impl Fn(f64) -> bool) -> impl Fn(&[f64; 3]) -> bool {
    move |values| values.iter().all(|x| x.is_finite() && check(*x))
}

/// Reads an optional field whose value is one of a few words.
pub(super) fn optional_word<T: Copy>(table: &mut TableReader, field: &'static str, words: &[(&str, T)]) -> Option<T> {
    optional_word_with_line(table, field, words).map(|found| found.value)
}

/// Like [`optional_word`], with the line of the field.
pub(super) fn optional_word_with_line<T: Copy>(table: &mut TableReader, field: &'static str, words: &[(&str, T)]) -> Option<WithLine<T>> {
    let allowed = format!("one of {}", words.iter().map(|(w, _)| format!("\"{w}\"")).collect::<Vec<_>>().join(", "));
    let WithLine { value: word, source_line } = table.optional::<String>(field, &allowed, |v| words.iter().any(|(w, _)| w == v))?;
    words.iter().find(|(w, _)| *w == word).map(|(_, value)| WithLine { value: *value, source_line })
}

/// Like [`optional_word`], but reports a missing field.
pub(super) fn required_word<T: Copy>(table: &mut TableReader, field: &'static str, words: &[(&str, T)]) -> Option<T> {
    let allowed = format!("one of {}", words.iter().map(|(w, _)| format!("\"{w}\"")).collect::<Vec<_>>().join(", "));
    let found = table.required::<String>(field, &allowed, |v| words.iter().any(|(w, _)| w == v))?;
    words.iter().find(|(w, _)| *w == found.value).map(|(_, value)| *value)
}

/// Reads a required finite number that passes `ok`.
pub(super) fn required_number(table: &mut TableReader, field: &'static str, allowed: &str, ok: impl Fn(f64) -> bool) -> Option<f64> {
    table.required::<f64>(field, allowed, |v| v.is_finite() && ok(*v)).map(|l| l.value)
}

/// Reads `invented`: one line that describes the invented part of a map or shape; `None` if nothing is invented.
pub(super) fn invented_part(table: &mut TableReader) -> Option<String> {
    let text =
        table.optional("invented", "what of it is invented, in a line of words", |v: &String| !v.trim().is_empty() && !v.contains('\n'));
    text.map(|l| l.value)
}

/// Reads a table by `read`. The value gets the line where the table begins.
pub(super) fn with_line<T>(table: TableReader, read: impl FnOnce(TableReader) -> Option<T>) -> Option<WithLine<T>> {
    let source_line = table.source_line.clone();
    Some(WithLine { value: read(table)?, source_line })
}

/// Reads the table of one map; [`Map`] explains the fields. Only the table of an albedo map (`is_albedo`) may have `harmonics` and `relative_mean`.
pub(super) fn read_map(mut table: TableReader, is_albedo: bool) -> Option<Map> {
    let file = table.required::<String>("file", ALLOWED_FILE_NAME, |f| is_file_name(f));
    let gain = table.optional("gain", "three numbers from 0 to 100 (red, green, blue)", each_component(|x| (0.0..=100.0).contains(&x)));
    let latitude = optional_word(
        &mut table,
        "latitude",
        &[("planetographic", MapLatitude::Planetographic), ("planetocentric", MapLatitude::Planetocentric)],
    );
    let columns = table.optional::<u32>("columns", "the map's width in texels, 2 to 65536", |c| (2..=65_536).contains(c)).map(|l| l.value);
    let invented = invented_part(&mut table);
    let harmonics = if is_albedo {
        table.optional("harmonics", "eight numbers from -2 to 2", |c: &[f64; 8]| c.iter().all(|c| c.abs() <= 2.0))
    } else {
        None
    };
    let relative_mean =
        if is_albedo { table.optional("relative_mean", "a number above 0, at most 10", |m: &f64| *m > 0.0 && *m <= 10.0) } else { None };
    let harmonics = harmonics.map(|found| {
        // In the order of `AlbedoHarmonics::basis_of_degree_1`, then of degree 2.
        let [x, y, z, degree_2 @ ..] = found.value;
        AlbedoHarmonics { degree_1: [x, y, z], degree_2 }
    });
    // For the readers of the catalog only; `finish` would report it as unknown.
    let _ = table.optional::<String>("source", "a string", |_| true);
    table.finish();
    let (gain, latitude) = (gain.map_or([1.0; 3], |g| g.value), latitude.unwrap_or(MapLatitude::Planetocentric));
    let relative_mean = relative_mean.map_or(1.0, |m| m.value);
    Some(Map { file: file?.value, gain, relative_mean, latitude, columns, invented, harmonics })
}

/// What [`optional_percent`] accepts, for messages. A value whose error is 100 % would not be an estimate.
const ALLOWED_PERCENT: &str = "percent above 0, at most 90";

/// Reads an optional estimated error, in percent.
pub(super) fn optional_percent(table: &mut TableReader, field: &'static str) -> Option<f64> {
    table.optional(field, ALLOWED_PERCENT, |p: &f64| *p > 0.0 && *p <= 90.0).map(|l| l.value)
}

/// What [`is_name`] accepts, for messages.
pub(super) const ALLOWED_NAME: &str = "a name in one line, without control characters";

/// Whether a text is a name: not blank, and without control characters such as line breaks.
#[expect(clippy::ptr_arg, reason = "the check of a field that is read as a `String`")]
pub(super) fn is_name(text: &String) -> bool {
    !text.trim().is_empty() && !text.contains(char::is_control)
}
