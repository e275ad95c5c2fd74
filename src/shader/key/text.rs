//! The text form: `lambert.albedo-normal.sun1.ellipsoid`, with flags and view after it where there are any.
//!
//! Parts in the order of the table of dimensions; a part with nothing to say is left out. Lower
//! case letters, digits, `.` and `-` only. Reading ignores case and takes canonical keys alone: a part that would change nothing is refused.

use super::ShaderKey;
use super::canonical::{canonical, first_breach};
use super::dimension::{DIMENSIONS, Part};
use crate::scene::draw::Needs;
use std::fmt;
use std::str::FromStr;

/// Why a text is no key. Columns count from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyTextError {
    #[error("shader key {text:?}: `{part}` at column {column} is not a part that can stand here; {expected}")]
    Unknown { text: String, part: String, column: usize, expected: String },
    #[error("shader key {text:?}: `{part}` at column {column} is given twice")]
    Twice { text: String, part: String, column: usize },
    #[error("shader key {text:?}: the {part} is missing at column {column}; {expected}")]
    Missing { text: String, part: &'static str, column: usize, expected: String },
    #[error("shader key {text:?}: `{part}` at column {column} changes nothing: {because}; the same image is {canonical}")]
    Contradictory { text: String, part: String, column: usize, because: &'static str, canonical: String },
}

fn parts() -> Vec<Part> {
    let mut parts: Vec<Part> = DIMENSIONS.iter().map(|d| d.part).collect();
    parts.dedup();
    parts
}

/// Whether a part may be left out: every one of its dimensions has an unwritten value.
fn optional(part: Part) -> bool {
    DIMENSIONS.iter().filter(|d| d.part == part).all(|d| d.texts.contains(&""))
}

fn allowed(part: Part) -> String {
    let texts: Vec<_> = DIMENSIONS.iter().filter(|d| d.part == part).flat_map(|d| d.texts).copied().filter(|t| !t.is_empty()).collect();
    format!("{} is one of {}", part.name(), texts.join(", "))
}

pub(super) fn write(needs: &Needs) -> String {
    let mut written: Vec<String> = Vec::new();
    for part in parts() {
        let texts: Vec<_> =
            DIMENSIONS.iter().filter(|d| d.part == part).map(|d| d.texts[(d.get)(needs)]).filter(|t| !t.is_empty()).collect();
        if !texts.is_empty() {
            written.push(texts.join("-"));
        }
    }
    written.join(".")
}

impl fmt::Display for ShaderKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&write(&self.needs))
    }
}

/// The words of a part's text with their columns. Words are joined by `-` and may hold one: at each place the longest known word counts.
fn words(part: Part, text: &str, column: usize) -> Vec<(&str, usize)> {
    let known = || DIMENSIONS.iter().filter(|d| d.part == part).flat_map(|d| d.texts).filter(|t| !t.is_empty());
    let mut found = Vec::new();
    let mut start = 0;
    while start <= text.len() {
        let rest = &text[start..];
        let ends_word = |t: &&&str| rest.strip_prefix(**t).is_some_and(|after| after.is_empty() || after.starts_with('-'));
        let length = known().filter(ends_word).map(|t| t.len()).max().unwrap_or_else(|| rest.find('-').unwrap_or(rest.len()));
        found.push((&rest[..length], column + start));
        start += length + 1;
    }
    found
}

impl FromStr for ShaderKey {
    type Err = KeyTextError;

    fn from_str(given: &str) -> Result<Self, KeyTextError> {
        let text = given.to_ascii_lowercase();
        let mut needs = Needs::LEAST;
        // Where each dimension's word stands, for the message about contradictions.
        let mut places: Vec<(&str, String, usize)> = Vec::new();
        let mut rest = parts().into_iter().peekable();
        let mut column = 1;
        let mut pieces = text.split('.').peekable();
        let known = |part: Part, word: &str| {
            DIMENSIONS
                .iter()
                .filter(|d| d.part == part)
                .find_map(|d| d.texts.iter().position(|t| !t.is_empty() && *t == word).map(|value| (d, value)))
        };
        while let Some(part) = rest.next() {
            let Some(piece) = pieces.peek().copied() else {
                if optional(part) {
                    continue;
                }
                let column = text.len() + 1;
                return Err(KeyTextError::Missing { text: given.into(), part: part.name(), column, expected: allowed(part) });
            };
            let words = words(part, piece, column);
            // An optional part is absent when nothing in this piece belongs to it.
            if optional(part) && !words.iter().any(|(w, _)| known(part, w).is_some()) {
                if rest.peek().is_some() {
                    continue;
                }
                return Err(KeyTextError::Unknown { text: given.into(), part: piece.into(), column, expected: allowed(part) });
            }
            for (word, at) in words {
                let Some((dimension, value)) = known(part, word) else {
                    return Err(KeyTextError::Unknown { text: given.into(), part: word.into(), column: at, expected: allowed(part) });
                };
                if places.iter().any(|(name, _, _)| *name == dimension.name) {
                    return Err(KeyTextError::Twice { text: given.into(), part: word.into(), column: at });
                }
                (dimension.set)(&mut needs, value);
                places.push((dimension.name, word.into(), at));
            }
            column += piece.len() + 1;
            pieces.next();
        }
        if let Some(piece) = pieces.next() {
            let expected = "the key ends before it".into();
            return Err(KeyTextError::Unknown { text: given.into(), part: piece.into(), column, expected });
        }
        if let Some((rule, dimension, _)) = first_breach(&needs) {
            let (part, column) = places
                .iter()
                .find(|(name, _, _)| *name == dimension.name)
                .map_or((dimension.name.to_owned(), 1), |(_, word, at)| (word.clone(), *at));
            let canonical = write(&canonical(&needs));
            return Err(KeyTextError::Contradictory { text: given.into(), part, column, because: rule.because, canonical });
        }
        Ok(Self { needs })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{covering, sample};
    use super::*;

    #[test]
    fn every_key_round_trips_in_any_case() {
        for key in covering(3).into_iter().chain(sample(3, 20_000)) {
            let text = key.to_string();
            assert!(text.len() < 220 && text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'.' || b == b'-'), "{text}");
            assert_eq!(text.parse(), Ok(key));
            assert_eq!(text.to_ascii_uppercase().parse(), Ok(key));
        }
    }

    #[test]
    fn errors_name_the_part_and_the_column() {
        let column = |text: &str| match text.parse::<ShaderKey>().expect_err(text) {
            KeyTextError::Unknown { column, part, .. } => ("unknown", part, column),
            KeyTextError::Twice { column, part, .. } => ("twice", part, column),
            KeyTextError::Missing { column, part, .. } => ("missing", part.to_owned(), column),
            KeyTextError::Contradictory { column, part, .. } => ("contradictory", part, column),
        };
        assert_eq!(column("phong.sun1.sphere"), ("unknown", "phong".into(), 1));
        assert_eq!(column("lambert.sun1.cube"), ("unknown", "cube".into(), 14));
        assert_eq!(column("lambert.albedo-bump.sun1.sphere"), ("unknown", "bump".into(), 16));
        assert_eq!(column("lambert.albedo-albedo.sun1.sphere"), ("twice", "albedo".into(), 16));
        assert_eq!(column("lambert.sun1"), ("missing", "shape".into(), 13));
        assert_eq!(column("lambert.sun1.sphere.depthh"), ("unknown", "depthh".into(), 21));
        assert_eq!(column("lambert.sun1.sphere.uv.uv"), ("unknown", "uv".into(), 24));
        assert_eq!(column("lambert.sun1.lambert"), ("unknown", "lambert".into(), 14));
        assert_eq!(column("emissive.albedo.sun2.sphere"), ("contradictory", "sun2".into(), 17));
        assert_eq!(column("lambert.normal.sun1.sphere.vertexcolour"), ("contradictory", "vertexcolour".into(), 28));
        assert_eq!(column("lambert.sun1.eclipse2.sphere"), ("contradictory", "eclipse2".into(), 14));
        assert_eq!(column("lambert.sun1.limb-darkened.sphere"), ("contradictory", "limb-darkened".into(), 14));
        assert_eq!(column("lambert.sun1.eclipse2-limb-lit.sphere"), ("unknown", "limb".into(), 23));
        assert_eq!(column("sky.sun1.air-pixel-16-dust.sphere"), ("unknown", "dust".into(), 23));
        assert_eq!(column(""), ("unknown", String::new(), 1));
        assert_eq!(column("lambert..sun1.sphere").0, "unknown");
    }
}
