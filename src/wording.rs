//! Parts of messages and tables: quotations of input, counts, numbers, suggestions of known words, and JSON errors in plain words. Also the start of a user's
//! text, whose byte order mark is no part of it.
//!
//! In: untrusted text, numbers, known words. Out: text for one line on a terminal. Always: a quotation contains no control character and at most as
//! many characters as the caller allows. Not here: the sentences of messages.

/// U+FEFF, in front of the texts of some editors.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// The text without the byte order mark that some editors write in front of it. Every parser of a user's file begins with this, also where `files::read_text`
/// has removed the mark, because programs that use the library hand in texts of their own. The `toml` crate skips the mark itself.
pub(crate) fn without_byte_order_mark(text: &str) -> &str {
    text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)
}

/// Largest length of a quotation of input in a message, characters.
pub(crate) const MAX_ECHO_CHARS: usize = 200;

/// The input with control characters escaped, cut at [`MAX_ECHO_CHARS`].
pub(crate) fn echo(given: &str) -> String {
    echo_within(given, MAX_ECHO_CHARS)
}

/// As [`echo`] with another limit, for messages with several quotations.
pub(crate) fn echo_within(given: &str, max_chars: usize) -> String {
    let escaped = given.chars().flat_map(|c| if controls_terminal(c) { c.escape_default().collect::<Vec<_>>() } else { vec![c] });
    let mut shown: Vec<char> = escaped.take(max_chars + 1).collect();
    if shown.len() > max_chars {
        shown.truncate(max_chars.saturating_sub(1));
        shown.push('…');
    }
    shown.into_iter().collect()
}

/// A count and its noun, such as `1 point` or `2 points`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// A number with this many decimals, without a minus sign if it rounds to zero.
pub(crate) fn fixed_decimals(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    text.strip_prefix('-').filter(|digits| digits.bytes().all(|b| matches!(b, b'0' | b'.'))).unwrap_or(&text).to_owned()
}

/// A message with terminal control characters escaped; line breaks stay.
pub(crate) fn escape_controls(message: &str) -> String {
    message.chars().map(|c| if controls_terminal(c) && c != '\n' { c.escape_default().to_string() } else { c.to_string() }).collect()
}

/// A message on one line, with terminal control characters escaped.
pub(crate) fn one_line(message: &str) -> String {
    message.chars().map(|c| if controls_terminal(c) { c.escape_default().to_string() } else { c.to_string() }).collect()
}

/// Whether a character controls the terminal: control characters, line separators, and characters that change the direction of text.
pub(crate) fn controls_terminal(c: char) -> bool {
    c.is_control() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// At most three known words that may be meant by `word`, nearest first: words that begin with `word`, if it has three letters or more, and words that differ
/// from it by few edits; of words that are equally near, first those with the nearest number. The allowed number of edits is a third of the letters of `word`,
/// rounded down, but at least one and at most three. The swap of two neighbouring letters is one edit, and so is the completion of a word. Case is ignored.
pub(crate) fn nearest<'k>(word: &str, known: impl IntoIterator<Item = &'k str>) -> Vec<&'k str> {
    // Longer input matches no name, and would be slow to compare.
    let lower: String = word.chars().take(64).flat_map(char::to_lowercase).collect();
    let letters = lower.chars().count();
    let max_edits = (letters / 3).clamp(1, 3);
    let distance = |known_word: &str| {
        let known_word = known_word.to_lowercase();
        let is_prefix = letters >= 3 && known_word.starts_with(&lower);
        if is_prefix { 1 } else { strsim::osa_distance(&lower, &known_word) }
    };
    let number = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>().parse::<u64>().ok();
    let number_of_word = number(&lower);
    let from_number = |known_word: &str| number_of_word.zip(number(known_word)).map_or(u64::MAX, |(a, b)| a.abs_diff(b));
    let near = known.into_iter().map(|k| (distance(k), from_number(k), k)).filter(|(d, _, _)| *d <= max_edits);
    let mut near: Vec<(usize, u64, &str)> = near.collect();
    near.sort();
    near.dedup();
    near.into_iter().map(|(_, _, k)| k).take(3).collect()
}

/// A suggestion such as ``did you mean `a` or `b`?``, if any known word is similar.
pub(crate) fn did_you_mean<'k>(word: &str, known: impl IntoIterator<Item = &'k str>) -> Option<String> {
    let near: Vec<String> = nearest(word, known).iter().map(|n| format!("`{n}`")).collect();
    match near.split_last()? {
        (only, []) => Some(format!("did you mean {only}?")),
        (last, others) => Some(format!("did you mean {} or {last}?", others.join(", "))),
    }
}

/// The suggestion, or else a list of all known words: ``did you mean `a`?`` or `one of a, b, c`.
pub(crate) fn suggestion_or_list(word: &str, known: &[&str]) -> String {
    did_you_mean(word, known.iter().copied()).unwrap_or_else(|| format!("one of {}", known.join(", ")))
}

/// A serde_json error in plain words and without its position, such as `expected an object, found a list`.
pub(crate) fn json_error_text(error: &serde_json::Error) -> String {
    let full_text = error.to_string();
    let end = full_text.rfind(" at line ").filter(|_| error.line() > 0).unwrap_or(full_text.len());
    let text = &full_text[..end];
    for (prefix, is_length) in [("invalid type: ", false), ("invalid value: ", false), ("invalid length ", true)] {
        if let Some((found, wanted)) = text.strip_prefix(prefix).and_then(|rest| rest.rsplit_once(", expected ")) {
            let found = if is_length { format!("{found} values") } else { json_kind_name(found) };
            return format!("expected {}, found {found}", expected_type_name(wanted));
        }
    }
    text.to_owned()
}

/// The plain name of a kind of JSON value; serde calls a list a sequence.
fn json_kind_name(found: &str) -> String {
    match found {
        "sequence" => "a list".into(),
        "map" => "an object".into(),
        _ => match found.split_once(' ') {
            Some(("string", text)) => format!("the text {text}"),
            Some(("integer", number)) => format!("the number {}", number.trim_matches('`')),
            Some(("floating", number)) => format!("the number {}", number.trim_start_matches("point ").trim_matches('`')),
            Some(("boolean", value)) => value.trim_matches('`').to_owned(),
            _ => found.to_owned(),
        },
    }
}

/// The plain name of an expected Rust type.
fn expected_type_name(wanted: &str) -> String {
    match wanted {
        "a sequence" => "a list".into(),
        "a map" => "an object".into(),
        "f64" | "f32" => "a number".into(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number from 0".into(),
        "i32" | "i64" | "isize" => "a whole number".into(),
        _ => wanted.strip_prefix("an array of length ").map_or_else(|| wanted.to_owned(), |n| format!("a list of {n} values")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_echo_is_short_and_has_no_control_characters() {
        let cases =
            ["", "mars", &"x".repeat(200), &"x".repeat(201), &"é".repeat(5000), "a\u{1b}[2Jb\r\n\t", "\u{202e}sram", &"\u{7}".repeat(150)];
        for given in cases {
            for max_chars in [20, MAX_ECHO_CHARS] {
                let shown = echo_within(given, max_chars);
                assert!(shown.chars().count() <= max_chars, "{given:?}: {} characters", shown.chars().count());
                assert!(!shown.chars().any(controls_terminal), "{shown:?}");
                // Short harmless input is unchanged.
                if given.chars().count() <= max_chars && !given.chars().any(controls_terminal) {
                    assert_eq!(shown, given);
                }
            }
        }
        assert!(echo(&"x".repeat(201)).ends_with("x…") && echo("a\u{1b}[2J") == "a\\u{1b}[2J");
        assert_eq!(escape_controls("a\u{1b}b\nc"), "a\\u{1b}b\nc");
        assert_eq!(one_line("a\u{1b}b\r\nc é"), "a\\u{1b}b\\r\\nc é");
    }

    #[test]
    fn a_number_that_rounds_to_zero_has_no_sign() {
        for (value, decimals, text) in
            [(-0.000_04, 4, "0.0000"), (-0.000_06, 4, "-0.0001"), (-0.0, 0, "0"), (-0.4, 0, "0"), (-10.0, 1, "-10.0"), (0.0, 2, "0.00")]
        {
            assert_eq!(fixed_decimals(value, decimals), text, "{value}");
        }
    }

    #[test]
    fn similar_words_are_suggested_and_others_are_not() {
        let known = ["Mars", "Saturn", "Titan", "Triton", "Titania", "Moon"];
        assert_eq!(nearest("marz", known), ["Mars"]);
        assert_eq!(nearest("SATRUN", known), ["Saturn"]);
        assert_eq!(nearest("tita", known), ["Titan", "Titania"]);
        assert_eq!(nearest("sun5", ["sun0", "sun1", "sun2", "sun3"]), ["sun3", "sun2", "sun1"]);
        assert!(nearest("nibiru", known).is_empty() && nearest("", known).is_empty());
        assert!(nearest(&"mars".repeat(100_000), known).is_empty());
        assert_eq!(did_you_mean("moo", known).as_deref(), Some("did you mean `Moon`?"));
    }

    #[test]
    fn json_errors_are_in_plain_words() {
        let error_text = |text: &str| json_error_text(&serde_json::from_str::<Vec<f64>>(text).expect_err(text));
        assert_eq!(error_text("{}"), "expected a list, found an object");
        assert_eq!(error_text("[\"a\"]"), "expected a number, found the text \"a\"");
        assert_eq!(error_text("[1,"), "EOF while parsing a value");
    }
}
