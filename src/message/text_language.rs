//! The languages of texts in images, and how each writes messages, names, numbers and times.
//!
//! In: messages, English names and numbers, times in ISO 8601. Out: text. Always: a message or name that a language lacks is English. Not here: the texts
//! of the window (`view::language`), which reads the same two files.

use super::{Argument, ENGLISH_FILE, GERMAN_FILE, Message, message};
use std::collections::HashMap;
use std::sync::LazyLock;

/// The language of the texts in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextLanguage {
    /// With ISO dates, and decimal points.
    #[default]
    English,
    /// With dates such as `8. April 2024`, and decimal commas.
    German,
}

/// The text of each message, with its placeholders, by id.
type Templates = HashMap<&'static str, &'static str>;

static ENGLISH: LazyLock<Templates> = LazyLock::new(|| templates(ENGLISH_FILE));
static GERMAN: LazyLock<Templates> = LazyLock::new(|| templates(GERMAN_FILE));

fn templates(file: &'static str) -> Templates {
    file.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(" = ")).collect()
}

/// A part of a message's text.
enum TextPart<'t> {
    Fixed(&'t str),
    Argument(&'t str),
}

/// The parts of a template in their order. Each piece after `{ $` begins with the name of an argument, which ends at ` }`.
fn parts(template: &str) -> impl Iterator<Item = TextPart<'_>> {
    template.split("{ $").enumerate().flat_map(|(k, part)| {
        let (name, fixed) = if k == 0 { (None, part) } else { part.split_once(" }").map_or((Some(part), ""), |(n, f)| (Some(n), f)) };
        name.map(TextPart::Argument).into_iter().chain([TextPart::Fixed(fixed)])
    })
}

impl TextLanguage {
    /// Its code: `en`, `de`.
    pub fn code(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::German => "de",
        }
    }

    /// The text of a message with its placeholders, in English if this language lacks it; `None` if English lacks it, too.
    fn template(self, id: &str) -> Option<&'static str> {
        let own = match self {
            Self::English => None,
            Self::German => GERMAN.get(id),
        };
        own.or_else(|| ENGLISH.get(id)).copied()
    }

    /// A name in this language: the text of the message `{kind}-{name in lower case}`, such as `body-earth`; the English name if there is no such message.
    pub(crate) fn name<'n>(self, kind: &str, name: &'n str) -> &'n str {
        match self {
            Self::English => name,
            Self::German => self.template(&format!("{kind}-{}", name.to_lowercase())).unwrap_or(name),
        }
    }

    /// A number with its unit in this language. `english`: with a decimal point and spaces between groups of three digits.
    pub(crate) fn number(self, english: &str) -> String {
        if self == Self::English {
            return english.to_owned();
        }
        let characters: Vec<char> = english.chars().collect();
        let is_digit = |k: Option<usize>| k.and_then(|k| characters.get(k)).is_some_and(char::is_ascii_digit);
        let mark = |id| self.template(id).and_then(|mark| mark.chars().next());
        let (decimal, group) = (mark("number-decimal-mark").unwrap_or('.'), mark("number-group-mark").unwrap_or(' '));
        let written = |(k, c): (usize, &char)| match c {
            '.' if is_digit(Some(k + 1)) => decimal,
            ' ' if is_digit(k.checked_sub(1)) && is_digit(Some(k + 1)) => group,
            other => *other,
        };
        characters.iter().enumerate().map(written).collect()
    }

    /// A time in ISO 8601 as date, time of day and time scale: UT1 before 1972, as for all times of the program.
    pub(crate) fn time(self, iso: &str) -> String {
        // What is not a calendar time, such as a Julian date, stays as it is.
        let Some((date, clock)) = iso.strip_suffix('Z').and_then(|iso| iso.split_once('T')) else { return iso.to_owned() };
        let mut from_end = date.rsplitn(3, '-');
        let mut number = || from_end.next()?.parse::<i64>().ok();
        let (Some(day), Some(month), Some(year)) = (number(), number(), number()) else { return format!("{date} {clock} UTC") };
        let scale = time_scale(year);
        if self == Self::English {
            return format!("{date} {clock} {scale}");
        }
        // A name that is no body's is written as it is.
        let month_name = Argument::Name(self.template(&format!("month-{month}")).unwrap_or_default().to_owned());
        // Year 0 of ISO 8601 is 1 BC.
        let mut year_text = if year > 0 {
            Argument::Number(format!("{year:04}"))
        } else {
            message!("date-iso-year-bc", year = format_args!("{}", 1 - year)).into()
        };
        if (year, month, day) < FIRST_GREGORIAN_DATE {
            year_text = message!("date-year-gregorian", year = year_text).into();
        }
        let date = message!("date-day", day_number = format_args!("{day}"), month_name = month_name, year = year_text);
        message!("date-instant", date = date, clock = Argument::Number(clock.to_owned()), scale = format_args!("{scale}")).text_in(self)
    }
}

/// The first day of the Gregorian calendar: year, month, day. An earlier date in words would be taken for one of the Julian calendar, so it names its calendar.
pub(crate) const FIRST_GREGORIAN_DATE: (i64, i64, i64) = (1582, 10, 15);

/// The first year whose times are in UTC; the civil time of earlier years is UT1.
const FIRST_UTC_YEAR: i64 = 1972;

/// The time scale of the times of a year.
pub(crate) fn time_scale(year: i64) -> &'static str {
    if year < FIRST_UTC_YEAR { "UT1" } else { "UTC" }
}

impl Message {
    /// The message in a language.
    pub(crate) fn text_in(&self, language: TextLanguage) -> String {
        let Some(template) = language.template(self.id) else { return self.id.to_owned() };
        let part_text = |part| match part {
            TextPart::Fixed(text) => text.to_owned(),
            TextPart::Argument(name) => match self.arguments.iter().find(|(argument_name, _)| *argument_name == name) {
                Some((_, argument)) => argument.text_in(language),
                None => name.to_owned(),
            },
        };
        parts(template).map(part_text).collect()
    }
}

impl Argument {
    fn text_in(&self, language: TextLanguage) -> String {
        match self {
            Self::Number(text) => language.number(text),
            Self::Name(text) => language.name("body", text).to_owned(),
            Self::Names(all) => all.iter().map(|name| language.name("body", name)).collect::<Vec<_>>().join(", "),
            // English texts keep ISO 8601, which programs can read.
            Self::Time(iso) if language == TextLanguage::English => iso.clone(),
            Self::Time(iso) => language.time(iso),
            Self::CatalogText(_, text) | Self::English(text) => text.clone(),
            Self::Reason(reason) => reason.messages().iter().map(|message| message.text_in(language)).collect::<Vec<_>>().join("; "),
        }
    }
}
