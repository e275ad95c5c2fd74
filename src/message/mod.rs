//! Localisable messages of the layers below the window: reasons for decisions, notes on estimates, captions in images, errors shown to the user.
//! A message is an id with arguments; the command line writes it in English, the window in the user's language.
//!
//! In: the id of a message in `english.ftl`, and its arguments. Out: the English text by `Display`, that of another language by `text_in`.
//! Always: the texts are only in `english.ftl` and `german.ftl`, which the window (`view::language`) reads, too; an unknown id is written as it
//! is, so that a test can find it. Not here: the window's own texts (`view::language`), and texts of the catalogs.

mod text_language;

pub use self::text_language::TextLanguage;
#[cfg(feature = "view")]
pub(crate) use self::text_language::{FIRST_GREGORIAN_DATE, time_scale};
use serde::{Serialize, Serializer};
use std::fmt;

/// The English messages, in a part of the syntax of Fluent: `id = text with { $arguments }`, one a line, without selectors.
pub(crate) const ENGLISH_FILE: &str = include_str!("english.ftl");

/// The German messages, with the same ids.
pub(crate) const GERMAN_FILE: &str = include_str!("german.ftl");

/// A message: its id and its arguments by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// The id, which all languages share.
    pub id: &'static str,
    /// The arguments, by the names that the message uses.
    pub arguments: Vec<(&'static str, Argument)>,
}

/// An argument of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A number, formatted as it will be shown, with a decimal point.
    Number(String),
    /// The name of a body, a model, a file or another thing.
    Name(String),
    /// Several names, separated by commas.
    Names(Vec<String>),
    /// An instant or a day, in ISO 8601.
    Time(String),
    /// A detail in English, such as an error of a compiler, for which there is no translation.
    English(String),
    /// A text of a catalog: the prefix of the ids of its translations, and the English text, from which the rest of the id is made.
    CatalogText(&'static str, String),
    /// Messages within this message, whether or not they are reasons.
    Reason(Reason),
}

/// Any number of messages, mostly the reasons of a decision. `Display` joins them with semicolons.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reason(Vec<Message>);

impl Reason {
    /// These messages, and then those of `further`.
    #[must_use]
    pub fn and(mut self, further: impl Into<Self>) -> Self {
        self.0.extend(further.into().0);
        self
    }

    /// The messages, in order.
    pub fn messages(&self) -> &[Message] {
        &self.0
    }
}

impl From<Message> for Reason {
    fn from(message: Message) -> Self {
        Self(vec![message])
    }
}

impl FromIterator<Self> for Reason {
    fn from_iter<I: IntoIterator<Item = Self>>(reasons: I) -> Self {
        Self(reasons.into_iter().flat_map(|reason| reason.0).collect())
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text_in(TextLanguage::English))
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, message) in self.0.iter().enumerate() {
            if k > 0 {
                f.write_str("; ")?;
            }
            message.fmt(f)?;
        }
        Ok(())
    }
}

impl Serialize for Message {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Serialize for Reason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// For numbers only, not for other formatted text: `format_args!("{value:.2}")` passes a rounded number to `message!`.
impl From<fmt::Arguments<'_>> for Argument {
    fn from(number: fmt::Arguments<'_>) -> Self {
        Self::Number(number.to_string())
    }
}

impl From<Reason> for Argument {
    fn from(reason: Reason) -> Self {
        Self::Reason(reason)
    }
}

impl From<Message> for Argument {
    fn from(message: Message) -> Self {
        Self::Reason(message.into())
    }
}

impl From<&str> for Argument {
    fn from(name: &str) -> Self {
        Self::Name(name.to_owned())
    }
}

impl From<&String> for Argument {
    fn from(name: &String) -> Self {
        Self::Name(name.clone())
    }
}

impl From<Vec<String>> for Argument {
    fn from(names: Vec<String>) -> Self {
        Self::Names(names)
    }
}

/// Implements the conversion of number types to [`Argument::Number`].
macro_rules! arguments_from_numbers {
    ($($number:ty),*) => {$(
        impl From<$number> for Argument {
            fn from(number: $number) -> Self {
                Self::Number(number.to_string())
            }
        }
    )*};
}
arguments_from_numbers!(f64, u32, usize, i32);

/// A [`Message`]: `message!("id")`, or `message!("id", name = value)`. To round a number, pass `format_args!("{value:.2}")`.
macro_rules! message {
    ($id:expr $(, $name:ident = $value:expr)* $(,)?) => {
        $crate::message::Message { id: $id, arguments: vec![$((stringify!($name), $crate::message::Argument::from($value))),*] }
    };
}
pub(crate) use message;

/// A [`Reason`] of one message: like `message!`, but the prefix `reason-` is added to the id.
macro_rules! reason {
    ($id:literal $(, $name:ident = $value:expr)* $(,)?) => {
        $crate::message::Reason::from($crate::message::message!(concat!("reason-", $id) $(, $name = $value)*))
    };
}
pub(crate) use reason;

#[cfg(test)]
mod tests;
