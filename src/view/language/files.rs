//! The built-in Fluent files, and the ids of the messages in them.
//!
//! Out: for each language, the contents of its files. All languages have files of the same names; `catalog.ftl` exists only in languages other than
//! English. Always: as Fluent requires, a message's id begins a line, and continuation lines are indented.

use super::Language;

/// Embeds the files of each language with these names, and those of [`crate::message`].
macro_rules! files {
    ($($name:literal),* $(,)?) => {
        const ENGLISH: &[&str] = &[crate::message::ENGLISH_FILE, $(include_str!(concat!("en/", $name, ".ftl"))),*];
        const GERMAN: &[&str] = &[crate::message::GERMAN_FILE, $(include_str!(concat!("de/", $name, ".ftl"))),*];
    };
}

files!(
    "bars",
    "compare",
    "dates",
    "effects",
    "events",
    "information",
    "moments",
    "names",
    "performance",
    "search",
    "shader",
    "shader_key",
    "share",
    "shortcuts",
    "table",
    "time",
    "viewport",
);

/// The German texts of the shipped catalogs. The English texts are in the catalogs themselves.
const GERMAN_CATALOGS: &str = include_str!("de/catalog.ftl");

/// The contents of the files that translate the shipped catalogs; none for English and for `Language::MarkedEnglish`, English with marks around each message.
pub(super) fn catalog_files(language: Language) -> &'static [&'static str] {
    match language {
        Language::English | Language::MarkedEnglish => &[],
        Language::German => &[GERMAN_CATALOGS],
    }
}

/// The contents of a language's files, except those of [`catalog_files`]. For `Language::MarkedEnglish` they are the English ones: `Messages` adds the marks.
pub(super) fn message_files(language: Language) -> &'static [&'static str] {
    match language {
        Language::English | Language::MarkedEnglish => ENGLISH,
        Language::German => GERMAN,
    }
}

/// The ids of a file's messages, in order.
pub(super) fn ids(file: &str) -> impl Iterator<Item = &str> {
    let begins_message = |line: &&str| line.starts_with(|c: char| c.is_ascii_alphabetic());
    file.lines().filter(begins_message).filter_map(|line| Some(line.split_once('=')?.0.trim_end()))
}
