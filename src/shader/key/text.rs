//! The text form of a key: `lambert.albedo-normal.sun1.ellipsoid`, followed by parts for a mesh's flags and the pixel view, if any.
//!
//! The text consists of parts, joined by `.`. A part consists of words, joined by `-`; each word names a value of one dimension. Parts and words are written in
//! the order of the table of dimensions; a part without words is omitted. Only lower-case letters, digits, `.` and `-` occur. Parts and words are read in any
//! order and case, because no word belongs to two dimensions. Only canonical keys are accepted: a word that does not change the image is an error.

use super::ShaderKey;
use super::canonical::{canonical, first_reduction};
use super::dimension::{DIMENSIONS, Dimension, KeyPart};
use crate::scene::draw::DrawFeatures;
use crate::wording::{did_you_mean, echo_within};
use std::fmt;
use std::str::FromStr;

/// Why a text is not a key. Columns count from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyTextError {
    #[error("shader key `{text}`: `{word}` at column {column} is not a word of a key; {expected}")]
    Unknown { text: String, word: String, column: usize, expected: String },
    #[error("shader key `{text}`: a part is empty at column {column}; {expected}")]
    Empty { text: String, column: usize, expected: String },
    #[error("shader key `{text}`: `{word}` at column {column} is a word of another part; join parts by `.`, as in {expected}")]
    OtherPart { text: String, word: String, column: usize, expected: String },
    #[error("shader key `{text}`: `{word}` at column {column} repeats the {dimension}, after `{earlier}` at column {earlier_column}")]
    Twice { text: String, word: String, column: usize, dimension: &'static str, earlier: String, earlier_column: usize },
    #[error("shader key `{text}`: the part `{part}` is missing at column {column}; {expected}")]
    Missing { text: String, part: &'static str, column: usize, expected: String },
    #[error("shader key `{text}`: `{word}` at column {column} changes nothing: {because}; the same image is {canonical}")]
    NoEffect { text: String, word: String, column: usize, because: &'static str, canonical: String },
}

impl KeyTextError {
    /// The message without the key, for messages that have quoted it already.
    pub fn without_key(&self) -> String {
        let message = self.to_string();
        let (Self::Unknown { text, .. }
        | Self::Empty { text, .. }
        | Self::OtherPart { text, .. }
        | Self::Twice { text, .. }
        | Self::Missing { text, .. }
        | Self::NoEffect { text, .. }) = self;
        message.strip_prefix(&format!("shader key `{text}`: ")).unwrap_or(&message).to_owned()
    }

    /// If the whole text is one unknown word, which may be a misspelt name of a module: suggests the most similar of these names.
    pub fn suggest_module_name(self, names: &[&'static str]) -> Self {
        match self {
            Self::Unknown { text, word, column: 1, expected } if text == word => {
                let expected = did_you_mean(&word, names.iter().copied()).unwrap_or(expected);
                Self::Unknown { text, word, column: 1, expected }
            }
            other => other,
        }
    }
}

/// Maximum number of characters that messages quote of a key.
const KEY_ECHO_CHARS: usize = 80;
/// Maximum number of characters that messages quote of an unknown word.
const WORD_ECHO_CHARS: usize = 40;

/// Every part, in the order of the table.
fn parts() -> Vec<KeyPart> {
    let mut parts: Vec<KeyPart> = DIMENSIONS.iter().map(|d| d.part).collect();
    parts.dedup();
    parts
}

/// Whether a part may be omitted: each of its dimensions has a value whose text is empty.
fn is_optional(part: KeyPart) -> bool {
    DIMENSIONS.iter().filter(|d| d.part == part).all(|d| d.texts.contains(&""))
}

/// A text that lists the words of a part.
fn words_of_part(part: KeyPart) -> String {
    let texts: Vec<_> = DIMENSIONS.iter().filter(|d| d.part == part).flat_map(|d| d.texts).copied().filter(|t| !t.is_empty()).collect();
    format!("`{}` is one of {}", part.name(), texts.join(", "))
}

/// The text of the key with these features.
pub(super) fn write(features: &DrawFeatures) -> String {
    let mut written: Vec<String> = Vec::new();
    for part in parts() {
        let texts: Vec<_> =
            DIMENSIONS.iter().filter(|d| d.part == part).map(|d| d.texts[(d.get)(features)]).filter(|t| !t.is_empty()).collect();
        if !texts.is_empty() {
            written.push(texts.join("-"));
        }
    }
    written.join(".")
}

impl fmt::Display for ShaderKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&write(&self.features))
    }
}

/// The words of a part's text with their columns; `column`: where the text begins in the key. Words are joined by `-` and may themselves contain `-`, so at
/// each position the longest known word is read. An unknown word ends before the next `-`.
fn words(part: KeyPart, text: &str, column: usize) -> Vec<(&str, usize)> {
    let known_words = || DIMENSIONS.iter().filter(|d| d.part == part).flat_map(|d| d.texts).filter(|t| !t.is_empty());
    let mut found = Vec::new();
    let mut start = 0;
    while start <= text.len() {
        let rest = &text[start..];
        let is_next_word = |word: &&&str| rest.strip_prefix(**word).is_some_and(|after| after.is_empty() || after.starts_with('-'));
        let length = known_words().filter(is_next_word).map(|t| t.len()).max().unwrap_or_else(|| rest.find('-').unwrap_or(rest.len()));
        found.push((&rest[..length], column + start));
        start += length + 1;
    }
    found
}

/// The dimension of this part that has this word, and the index of the value that the word names.
fn find_word(part: KeyPart, word: &str) -> Option<(&'static Dimension, usize)> {
    let of_part = DIMENSIONS.iter().filter(|d| d.part == part);
    of_part.into_iter().find_map(|d| d.texts.iter().position(|t| !t.is_empty() && *t == word).map(|value| (d, value)))
}

/// The part to which a piece of a key's text (between two `.`) belongs: the one that has most of its words. No word belongs to two parts.
fn part_of(piece: &str) -> Option<KeyPart> {
    let known_words = |part: KeyPart| words(part, piece, 1).iter().filter(|(w, _)| find_word(part, w).is_some()).count();
    // Of several parts with the most words, `max_by_key` returns the last; because of `rev` that is the first in the table.
    parts().into_iter().rev().max_by_key(|part| known_words(*part)).filter(|part| known_words(*part) > 0)
}

/// Every word of a key, each once.
fn all_words() -> Vec<&'static str> {
    DIMENSIONS.iter().flat_map(|d| d.texts).copied().filter(|t| !t.is_empty()).collect()
}

impl FromStr for ShaderKey {
    type Err = KeyTextError;

    fn from_str(given: &str) -> Result<Self, KeyTextError> {
        let lower = given.to_ascii_lowercase();
        let quoted = || echo_within(given, KEY_ECHO_CHARS);
        let mut features = DrawFeatures::MINIMAL;
        // Name of the dimension, text and column of each word, for messages about words that are repeated or have no effect.
        let mut positions: Vec<(&str, String, usize)> = Vec::new();
        let mut found_parts: Vec<KeyPart> = Vec::new();
        let mut column = 1;
        for piece in lower.split('.') {
            let unknown = |word: &str, column: usize, expected: String| KeyTextError::Unknown {
                text: quoted(),
                word: echo_within(word, WORD_ECHO_CHARS),
                column,
                expected,
            };
            if piece.is_empty() {
                let expected = suggestion(piece, &found_parts);
                return Err(KeyTextError::Empty { text: quoted(), column, expected });
            }
            let Some(part) = part_of(piece) else {
                return Err(unknown(piece, column, suggestion(piece, &found_parts)));
            };
            for (word, word_column) in words(part, piece, column) {
                let Some((dimension, value)) = find_word(part, word) else {
                    if all_words().contains(&word) {
                        // The `-` before the word, or after a first word, should be a `.`.
                        let separator = if word_column > column { word_column - column - 1 } else { word.len() };
                        let (before, after) = piece.split_at(separator);
                        let expected = format!("`{before}.{}`", after.trim_start_matches('-'));
                        return Err(KeyTextError::OtherPart {
                            text: quoted(),
                            word: word.into(),
                            column: word_column,
                            expected: echo_within(&expected, KEY_ECHO_CHARS),
                        });
                    }
                    return Err(unknown(word, word_column, did_you_mean(word, all_words()).unwrap_or_else(|| words_of_part(part))));
                };
                if let Some((_, earlier, earlier_column)) = positions.iter().find(|(name, _, _)| *name == dimension.name) {
                    return Err(KeyTextError::Twice {
                        text: quoted(),
                        word: word.into(),
                        column: word_column,
                        dimension: dimension.name,
                        earlier: earlier.clone(),
                        earlier_column: *earlier_column,
                    });
                }
                (dimension.set)(&mut features, value);
                positions.push((dimension.name, word.into(), word_column));
            }
            found_parts.push(part);
            column += piece.len() + 1;
        }
        if let Some(part) = parts().into_iter().find(|p| !is_optional(*p) && !found_parts.contains(p)) {
            let column = lower.len() + 1;
            return Err(KeyTextError::Missing { text: quoted(), part: part.name(), column, expected: words_of_part(part) });
        }
        if let Some((rule, dimension, _)) = first_reduction(&features) {
            // If the key has no word of this dimension, the dimension's name at column 1 stands for it.
            let (word, column) = positions
                .iter()
                .find(|(name, _, _)| *name == dimension.name)
                .map_or((dimension.name.to_owned(), 1), |(_, word, column)| (word.clone(), *column));
            let canonical = write(&canonical(&features));
            return Err(KeyTextError::NoEffect { text: quoted(), word, column, because: rule.because, canonical });
        }
        Ok(Self { features })
    }
}

/// What an error message suggests for a piece that belongs to no part: a similar word, or the words of a part that is still missing.
fn suggestion(piece: &str, found_parts: &[KeyPart]) -> String {
    did_you_mean(piece, all_words()).unwrap_or_else(|| match parts().into_iter().find(|p| !found_parts.contains(p)) {
        Some(part) => words_of_part(part),
        None => "every part is there already".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::{covering_keys, random_keys};
    use super::*;

    const SEED: u64 = 3;
    const RANDOM_KEYS: usize = 20_000;

    #[test]
    fn every_key_round_trips_in_any_case() {
        for key in covering_keys(3).into_iter().chain(random_keys(SEED, RANDOM_KEYS)) {
            let text = key.to_string();
            assert!(text.len() < 220 && text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'.' || b == b'-'), "{text}");
            assert_eq!(text.parse(), Ok(key));
            assert_eq!(text.to_ascii_uppercase().parse(), Ok(key));
        }
    }

    /// Parts in random order give the same key. The written order does not depend on the order that was parsed.
    #[test]
    fn parts_are_read_in_any_order() {
        // Random numbers below `n` (xorshift).
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut below = |n: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % n as u64) as usize
        };
        let mut reordered = 0;
        for key in covering_keys(3).into_iter().chain(random_keys(SEED + 2, RANDOM_KEYS)) {
            let text = key.to_string();
            let mut pieces: Vec<&str> = text.split('.').collect();
            for k in (1..pieces.len()).rev() {
                pieces.swap(k, below(k + 1));
            }
            let shuffled = pieces.join(".");
            reordered += usize::from(shuffled != text);
            let read: ShaderKey = shuffled.to_ascii_uppercase().parse().unwrap_or_else(|e| panic!("{e}"));
            assert_eq!((read, read.to_string()), (key, text), "{shuffled}");
        }
        assert!(reordered > 10_000, "only {reordered} keys were shuffled");
        // If a word belonged to two parts, the order would matter.
        let mut words = all_words();
        words.sort_unstable();
        let all = words.len();
        words.dedup();
        assert_eq!(words.len(), all);
    }

    #[test]
    fn errors_name_the_word_and_the_column() {
        let error_of = |text: &str| match text.parse::<ShaderKey>().expect_err(text) {
            KeyTextError::Unknown { column, word, .. } => ("unknown", word, column),
            KeyTextError::Empty { column, .. } => ("empty", String::new(), column),
            KeyTextError::OtherPart { column, word, .. } => ("other part", word, column),
            KeyTextError::Twice { column, word, .. } => ("twice", word, column),
            KeyTextError::Missing { column, part, .. } => ("missing", part.to_owned(), column),
            KeyTextError::NoEffect { column, word, .. } => ("no effect", word, column),
        };
        assert_eq!(error_of("phong.sun1.sphere"), ("unknown", "phong".into(), 1));
        assert_eq!(error_of("lambert.sun1.cube"), ("unknown", "cube".into(), 14));
        assert_eq!(error_of("lambert.albedo-bump.sun1.sphere"), ("unknown", "bump".into(), 16));
        assert_eq!(error_of("lambert.albedo-albedo.sun1.sphere"), ("twice", "albedo".into(), 16));
        assert_eq!(error_of("lambert.sun1"), ("missing", "shape".into(), 13));
        assert_eq!(error_of("lambert.sun1.sphere.depthh"), ("unknown", "depthh".into(), 21));
        assert_eq!(error_of("lambert.sun1.sphere.uv.uv"), ("twice", "uv".into(), 24));
        assert_eq!(error_of("lambert.sun1.lambert"), ("twice", "lambert".into(), 14));
        assert_eq!(error_of("sphere.sun1.lambert.sun2"), ("twice", "sun2".into(), 21));
        assert_eq!(error_of("albedo.lambert.sun1.normal.albedo.sphere"), ("twice", "albedo".into(), 28));
        assert_eq!(error_of("sun1.sphere"), ("missing", "surface".into(), 12));
        assert_eq!(error_of("emissive.albedo.sun2.sphere"), ("no effect", "sun2".into(), 17));
        assert_eq!(error_of("lambert.normal.sun1.sphere.vertexcolour"), ("no effect", "vertexcolour".into(), 28));
        assert_eq!(error_of("lambert.sun1.eclipse2.sphere"), ("no effect", "eclipse2".into(), 14));
        assert_eq!(error_of("lambert.sun1.limb-darkened.sphere"), ("no effect", "limb-darkened".into(), 14));
        // Neither `limb-lit` nor `dust` is a word; an unknown word ends before the next `-`.
        assert_eq!(error_of("lambert.sun1.eclipse2-limb-lit.sphere"), ("unknown", "limb".into(), 23));
        assert_eq!(error_of("sky.sun1.air-pixel-16-dust.sphere"), ("unknown", "dust".into(), 23));
        assert_eq!(error_of(""), ("empty", String::new(), 1));
        assert_eq!(error_of("lambert..sun1.sphere"), ("empty", String::new(), 9));
        assert_eq!(error_of("lambert.sun1."), ("empty", String::new(), 14));
        assert_eq!(error_of("lambert-albedo.sun1.sphere"), ("other part", "albedo".into(), 9));
        assert_eq!(error_of("albedo-lambert.sun1.sphere"), ("other part", "albedo".into(), 1));
        let message = "lambert-albedo.sun1".parse::<ShaderKey>().expect_err("a wrong separator");
        assert!(message.to_string().starts_with("shader key `lambert-albedo.sun1`: "), "{message}");
        assert_eq!(message.without_key(), "`albedo` at column 9 is a word of another part; join parts by `.`, as in `lambert.albedo`");
    }
}
