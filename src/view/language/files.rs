//! The Fluent files that are built in, and what can be read from their text.
//!
//! In: nothing. Out: per language the same list of files. Always: a message's id begins its line, as Fluent demands; what follows it is indented.

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

/// English texts that other layers make: messages are found by them.
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
