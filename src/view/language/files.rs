//! The built-in Fluent files, and the ids of the messages in them.
//!
//! In: nothing. Out: the texts of the same list of files for each language. Always: as Fluent requires, a message's id begins a line, and
//! continuation lines are indented.

use super::Language;

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        const ENGLISH: &[&str] = &[$(include_str!(concat!("en/", $name, ".ftl"))),*];
        const GERMAN: &[&str] = &[$(include_str!(concat!("de/", $name, ".ftl"))),*];
    };
}

files!(
    "bars",
    "bodies",
    "catalog",
    "compare",
    "dates",
    "effects",
    "events",
    "information",
    "moments",
    "names",
    "performance",
    "reasons",
    "search",
    "shader",
    "shader_key",
    "share",
    "shortcuts",
    "time",
    "viewport",
);

/// The English files for texts of other layers; their messages are found by text rather than by id.
pub(super) const ENGLISH_ELSEWHERE: [&str; 2] = [include_str!("en/catalog.ftl"), include_str!("en/reasons.ftl")];

/// The files of a language.
pub(super) fn of(language: Language) -> &'static [&'static str] {
    match language {
        Language::English | Language::Marked => ENGLISH,
        Language::German => GERMAN,
    }
}

/// The ids of a file's messages, in order.
pub(super) fn ids(file: &str) -> impl Iterator<Item = &str> {
    let begins = |line: &&str| line.starts_with(|c: char| c.is_ascii_alphabetic());
    file.lines().filter(begins).filter_map(|line| Some(line.split_once('=')?.0.trim_end()))
}
