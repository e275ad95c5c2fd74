//! The window's languages, and the choice between them.
//!
//! In: a language code from the command line or the settings, or the environment's locale. Out: a [`Language`]. Always: a locale of another language
//! gives English, and an unknown code on the command line is an error.

use crate::message::TextLanguage;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use unic_langid::LanguageIdentifier;

/// A language of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    #[default]
    English,
    German,
    /// English with marks around each message, for tests and for authors of texts; never offered to users.
    MarkedEnglish,
}

/// An unknown language code.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{code}: unknown language; known are {}", known_languages())]
pub struct UnknownLanguage {
    code: String,
}

fn known_languages() -> String {
    Language::ALL.map(|language| format!("{} ({})", language.code(), language.own_name())).join(" and ")
}

/// Maximum number of characters that an error quotes of an unknown code.
const MAX_CODE_CHARS: usize = 40;

/// The environment variables that name a locale, in order of precedence.
const LOCALE_VARIABLES: [&str; 3] = ["LC_ALL", "LC_MESSAGES", "LANG"];

impl Language {
    /// The languages that a user can choose.
    pub const ALL: [Self; 2] = [Self::English, Self::German];

    /// The code in `--language`, in the settings and in locales.
    pub fn code(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
            Self::MarkedEnglish => "en-x-marked",
        }
    }

    /// The language's name in the language itself.
    pub fn own_name(self) -> &'static str {
        match self {
            Self::English => "English",
            Self::German => "Deutsch",
            Self::MarkedEnglish => "English between marks",
        }
    }

    /// A title as it is written inside a sentence. German nouns keep their capitals.
    pub(crate) fn inside_sentence(self, title: &str) -> String {
        match self {
            Self::English | Self::MarkedEnglish => title.to_lowercase(),
            Self::German => title.to_owned(),
        }
    }

    /// The language of the texts that scenes draw into images.
    pub(crate) fn in_images(self) -> TextLanguage {
        match self {
            Self::English | Self::MarkedEnglish => TextLanguage::English,
            Self::German => TextLanguage::German,
        }
    }

    /// The identifier by which Fluent chooses plural forms.
    pub(super) fn identifier(self) -> LanguageIdentifier {
        self.code().parse().unwrap_or_default()
    }

    /// The language with this code.
    ///
    /// # Errors
    /// The code is unknown; the error lists the known languages.
    pub fn by_code(code: &str) -> Result<Self, UnknownLanguage> {
        let has_code = |language: &Self| language.code().eq_ignore_ascii_case(code.trim());
        let found = [Self::English, Self::German, Self::MarkedEnglish].into_iter().find(has_code);
        found.ok_or_else(|| UnknownLanguage { code: crate::wording::echo_within(code, MAX_CODE_CHARS) })
    }

    /// The language of the environment's locale, for instance `de_DE.UTF-8`; English if that language is not available. `variable` reads an
    /// environment variable.
    pub fn of_environment(variable: impl Fn(&str) -> Option<String>) -> Self {
        // The first variable that is set and not empty decides, as in POSIX.
        let locale = LOCALE_VARIABLES.into_iter().filter_map(variable).find(|locale| !locale.is_empty()).unwrap_or_default();
        let code = locale.split(['_', '-', '.', '@']).next().unwrap_or_default();
        Self::by_code(code).unwrap_or_default()
    }
}

impl Serialize for Language {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.code())
    }
}

/// Reads the language of a settings file. An unknown language counts as none, so that the rest of the file is still read.
///
/// # Errors
/// Invalid JSON.
pub(crate) fn deserialize_language<'d, D: Deserializer<'d>>(from: D) -> Result<Option<Language>, D::Error> {
    let value = serde_json::Value::deserialize(from)?;
    Ok(value.as_str().and_then(|code| Language::by_code(code).ok()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_locale_variables_have_the_precedence_of_posix() {
        let language_of = |variables: &'static [(&str, &str)]| {
            Language::of_environment(|name| variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned()))
        };
        assert_eq!(language_of(&[("LANG", "de_DE.UTF-8")]), Language::German);
        assert_eq!(language_of(&[("LANG", "de_AT@euro")]), Language::German);
        assert_eq!(language_of(&[("LC_ALL", "C"), ("LANG", "de_DE.UTF-8")]), Language::English);
        assert_eq!(language_of(&[("LC_ALL", ""), ("LC_MESSAGES", "de"), ("LANG", "en_GB")]), Language::German);
        assert_eq!(language_of(&[("LANG", "fr_FR.UTF-8")]), Language::English);
        // Only the whole code counts, not its beginning.
        assert_eq!(language_of(&[("LANG", "dement")]), Language::English);
        assert_eq!(language_of(&[]), Language::English);
    }

    #[test]
    fn an_unknown_code_is_an_error_that_lists_the_known_codes() {
        assert_eq!(Language::by_code("DE"), Ok(Language::German));
        let line = Language::by_code("fr").expect_err("no French").to_string();
        assert_eq!(line, "fr: unknown language; known are en (English) and de (Deutsch)");
    }
}
