//! The languages, and which one a window has.
//!
//! In: a code of the command line, the settings, locales of the environment. Out: a [`Language`]. Always: what says nothing about a language that exists leaves English.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use unic_langid::LanguageIdentifier;

/// A language of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    #[default]
    English,
    German,
    /// English with marks around each message: for tests and for those who write texts, never offered.
    Marked,
}

/// A code that no language has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{code}: the window speaks {}", known())]
pub struct UnknownLanguage {
    code: String,
}

fn known() -> String {
    Language::ALL.map(|language| format!("{} ({})", language.code(), language.own_name())).join(" and ")
}

/// The variables that name a locale, the strongest first.
const LOCALE_VARIABLES: [&str; 3] = ["LC_ALL", "LC_MESSAGES", "LANG"];

impl Language {
    /// The languages that a user can choose.
    pub const ALL: [Self; 2] = [Self::English, Self::German];

    /// As in `--language`, in the settings and in locales.
    pub fn code(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
            Self::Marked => "en-x-marked",
        }
    }

    /// What its speakers call it.
    pub fn own_name(self) -> &'static str {
        match self {
            Self::English => "English",
            Self::German => "Deutsch",
            Self::Marked => "English between marks",
        }
    }

    /// For Fluent, which chooses plural forms by it.
    pub(super) fn identifier(self) -> LanguageIdentifier {
        self.code().parse().unwrap_or_default()
    }

    /// The language of a code.
    ///
    /// # Errors
    /// Which languages there are.
    pub fn by_code(code: &str) -> Result<Self, UnknownLanguage> {
        let found =
            [Self::English, Self::German, Self::Marked].into_iter().find(|language| language.code().eq_ignore_ascii_case(code.trim()));
        found.ok_or_else(|| UnknownLanguage { code: crate::wording::echo_within(code, 40) })
    }

    /// The language of the environment's locale, `de_DE.UTF-8` for instance; English if it has none that exists. `variable`: reads one.
    pub fn of_environment(variable: impl Fn(&str) -> Option<String>) -> Self {
        // The first one that is set decides, as in POSIX.
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

/// The language of a settings file. One that this version does not have counts as none chosen, so that the rest of the file is still read.
///
/// # Errors
/// Those of the file's syntax.
pub(crate) fn chosen<'d, D: Deserializer<'d>>(from: D) -> Result<Option<Language>, D::Error> {
    let value = serde_json::Value::deserialize(from)?;
    Ok(value.as_str().and_then(|code| Language::by_code(code).ok()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_chooses_as_in_posix() {
        let of = |set: &'static [(&str, &str)]| {
            Language::of_environment(|name| set.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned()))
        };
        assert_eq!(of(&[("LANG", "de_DE.UTF-8")]), Language::German);
        assert_eq!(of(&[("LANG", "de_AT@euro")]), Language::German);
        assert_eq!(of(&[("LC_ALL", "C"), ("LANG", "de_DE.UTF-8")]), Language::English);
        assert_eq!(of(&[("LC_ALL", ""), ("LC_MESSAGES", "de"), ("LANG", "en_GB")]), Language::German);
        assert_eq!(of(&[("LANG", "fr_FR.UTF-8")]), Language::English);
        assert_eq!(of(&[("LANG", "dement")]), Language::English);
        assert_eq!(of(&[]), Language::English);
    }

    #[test]
    fn an_unknown_code_is_told_which_there_are() {
        assert_eq!(Language::by_code("DE"), Ok(Language::German));
        let line = Language::by_code("fr").expect_err("no French").to_string();
        assert_eq!(line, "fr: the window speaks en (English) and de (Deutsch)");
    }
}
