//! Headers of FITS files (standard 4.0). A header is a sequence of 80-byte cards, `KEYWORD = value / comment`, in blocks of 2880 bytes.
//!
//! In: the bytes of a file from the start of a header. Out: its cards and the offset of its data, or a [`CardError`]. Always: at most 1000 blocks are read.
//! Left out: long strings (CONTINUE), hierarchical keywords.

use crate::wording::echo_within;

/// Length of a card, bytes.
pub(super) const CARD_BYTES: usize = 80;
/// Length of the keyword at the start of a card, bytes.
const KEYWORD_BYTES: usize = 8;
/// Block size of headers and data, bytes.
pub(super) const BLOCK_BYTES: usize = 2880;
/// Maximum number of blocks of a header.
const MAX_BLOCKS: usize = 1000;
/// Maximum length of a value that a message quotes, characters.
const MAX_VALUE_ECHO_CHARS: usize = 40;

/// The header of one HDU (header-data unit: an image or table of the file).
pub(super) struct Header {
    /// The cards that have a value: keyword, value, card number.
    cards: Vec<(String, String, usize)>,
    /// Number of bytes from the start of the header to the data.
    pub data_offset: usize,
}

/// An error in a header: the number of the wrong card, counted from 1 at the start of the file, and the reason. For a missing card, the number is
/// 1; if END is missing, it is that of the header's first card.
pub(super) type CardError = (usize, String);

impl Header {
    /// Reads the header at the start of `bytes`. `first_card`: number of the header's first card, counted from 1 at the start of the file.
    pub fn read(bytes: &[u8], first_card: usize) -> Result<Self, CardError> {
        let mut cards = Vec::new();
        for (k, card) in bytes.chunks_exact(CARD_BYTES).take(MAX_BLOCKS * BLOCK_BYTES / CARD_BYTES).enumerate() {
            let card_number = first_card + k;
            if !card.iter().all(|b| (0x20..0x7f).contains(b)) {
                return Err((card_number, "a header card with bytes that are not text: not FITS, or damaged".to_owned()));
            }
            let text = String::from_utf8_lossy(card);
            let (keyword, rest) = text.split_at(KEYWORD_BYTES);
            let keyword = keyword.trim_end();
            if keyword == "END" {
                return Ok(Self { cards, data_offset: ((k + 1) * CARD_BYTES).next_multiple_of(BLOCK_BYTES) });
            }
            if let Some(value) = rest.strip_prefix("= ") {
                cards.push((keyword.to_owned(), value_of(value), card_number));
            }
        }
        Err((first_card, "a header without END: not FITS, or cut short".to_owned()))
    }

    /// Value and card number of a keyword.
    fn find(&self, keyword: &str) -> Option<(&str, usize)> {
        self.cards.iter().find(|(k, _, _)| k == keyword).map(|(_, value, card_number)| (value.as_str(), *card_number))
    }

    /// The value of a card as text, without quotes; empty if there is no such card.
    pub fn text(&self, keyword: &str) -> &str {
        self.find(keyword).map_or("", |(value, _)| value)
    }

    /// The card number of a keyword, for messages; 1 if there is no such card.
    pub fn card_number(&self, keyword: &str) -> usize {
        self.find(keyword).map_or(1, |(_, card_number)| card_number)
    }

    /// The numeric value of a card; `None` if there is no such card. A value that is not a finite number is an error.
    pub fn number(&self, keyword: &str) -> Result<Option<f64>, CardError> {
        let Some((value, card_number)) = self.find(keyword) else { return Ok(None) };
        // Fortran writes exponents with D.
        let parsed = value.replace(['D', 'd'], "E").parse::<f64>().ok().filter(|v| v.is_finite());
        parsed.map(Some).ok_or_else(|| (card_number, format!("{keyword}: `{}` is not a number", echo_within(value, MAX_VALUE_ECHO_CHARS))))
    }

    /// The integer value of a card. A missing card or a value outside `range` is an error.
    pub fn integer(&self, keyword: &str, range: std::ops::RangeInclusive<i64>) -> Result<i64, CardError> {
        let Some((value, card_number)) = self.find(keyword) else { return Err((1, format!("{keyword} is missing"))) };
        let parsed = value.parse::<i64>().ok().filter(|v| range.contains(v));
        parsed.ok_or_else(|| {
            let (min, max) = (range.start(), range.end());
            (card_number, format!("{keyword}: `{}` is not a whole number from {min} to {max}", echo_within(value, MAX_VALUE_ECHO_CHARS)))
        })
    }
}

/// The value of a card without its comment: a string within quotes, in which two quotes mean one, or the text before the slash.
fn value_of(text: &str) -> String {
    let text = text.trim_start();
    let Some(string) = text.strip_prefix('\'') else {
        return text.split('/').next().unwrap_or_default().trim().to_owned();
    };
    let mut value = String::new();
    let mut chars = string.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '\'' if chars.peek() == Some(&'\'') => {
                chars.next();
                value.push('\'');
            }
            '\'' => break,
            c => value.push(c),
        }
    }
    value.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_end_before_their_comments() {
        for (text, value) in [
            ("                   16 / bits", "16"),
            ("'RA---TAN'           / right ascension", "RA---TAN"),
            ("'O''HARA  '", "O'HARA"),
            ("'a / b'  / c", "a / b"),
            ("-1.5D-3", "-1.5D-3"),
        ] {
            assert_eq!(value_of(text), value);
        }
    }
}
