//! Translates texts that other layers produce in English: reasons of the scene, and descriptions in the catalogs (moments, tours, estimates).
//!
//! In: an English text. Out: the text in the window's language. Always: the message is found by matching its English text, where an argument of the
//! message matches a number, a name, or a text that is itself a message; parts between semicolons are translated one by one; a part without a
//! message stays English. Hence the layers below need no languages, and their texts are the same on the command line. Not here: errors, and the
//! user's own catalogs.

use super::dates::instant_text;
use super::numbers::localised;
use super::{Language, body_name, current, files, filled_by_text, named, plain};
use crate::time::Instant;
use std::borrow::Cow;
use std::sync::LazyLock;

/// An English message: its fixed parts, and the names of the arguments between them.
struct Template {
    id: &'static str,
    fixed: Vec<&'static str>,
    arguments: Vec<&'static str>,
}

impl Template {
    /// The template on a line of a Fluent file; `None` if no message begins there.
    fn of(line: &'static str) -> Option<Self> {
        let id = files::ids(line).next()?;
        let (_, text) = line.split_once('=')?;
        let mut parts = text.trim().split("{ $");
        let mut fixed = vec![parts.next()?];
        let mut arguments = Vec::new();
        for part in parts {
            let (argument, rest) = part.split_once(" }")?;
            arguments.push(argument);
            fixed.push(rest);
        }
        Some(Self { id, fixed, arguments })
    }

    /// The parts of `text` in place of the arguments; `None` if the text is not an instance of this message.
    fn arguments_in<'t>(&self, text: &'t str) -> Option<Vec<&'t str>> {
        let rest = text.strip_prefix(self.fixed[0])?;
        let mut found = Vec::new();
        split_arguments(rest, &self.fixed[1..], &mut found).then_some(found)
    }

    fn fixed_length(&self) -> usize {
        self.fixed.iter().map(|part| part.len()).sum()
    }
}

/// Splits `text` into arguments, each followed by the next of the `fixed` parts, and appends them to `found`. Returns whether this is possible such
/// that the text ends with the last fixed part and every argument is valid ([`is_argument`]). Backtracks, since a fixed part may occur repeatedly.
fn split_arguments<'t>(text: &'t str, fixed: &[&str], found: &mut Vec<&'t str>) -> bool {
    let Some((next, later)) = fixed.split_first() else { return text.is_empty() };
    if later.is_empty() {
        return text.strip_suffix(next).filter(|argument| is_argument(argument)).is_some_and(|argument| {
            found.push(argument);
            true
        });
    }
    text.match_indices(next).filter(|(at, _)| is_argument(&text[..*at])).any(|(at, _)| {
        let known = found.len();
        found.push(&text[..at]);
        let fits = split_arguments(&text[at + next.len()..], later, found);
        if !fits {
            found.truncate(known);
        }
        fits
    })
}

/// Whether an argument may have this text: not empty, and within one part between semicolons.
fn is_argument(text: &str) -> bool {
    !text.is_empty() && !text.contains("; ")
}

static TEMPLATES: LazyLock<Vec<Template>> = LazyLock::new(|| {
    let mut all: Vec<Template> = files::ENGLISH_ELSEWHERE.iter().flat_map(|file| file.lines()).filter_map(Template::of).collect();
    // The most specific template comes first.
    all.sort_by_key(|template| std::cmp::Reverse(template.fixed_length()));
    all
});

/// The translation of another layer's English text into the window's language.
pub fn translated(text: &str) -> Cow<'_, str> {
    if current() == Language::English {
        return Cow::Borrowed(text);
    }
    message(text).map_or_else(|| Cow::Owned(text.split("; ").map(part).collect::<Vec<_>>().join("; ")), Cow::Owned)
}

/// The translation of a text that is an instance of a message; `None` if no message matches.
fn message(text: &str) -> Option<String> {
    TEMPLATES.iter().find_map(|template| {
        let values = template.arguments_in(text)?;
        if values.is_empty() {
            return Some(plain(template.id).to_owned());
        }
        let values: Vec<(&str, String)> = template.arguments.iter().copied().zip(values.into_iter().map(argument)).collect();
        Some(filled_by_text(template.id, &values))
    })
}

/// The translation of a part of a text, or the part itself if no message matches.
fn part(text: &str) -> String {
    message(text).unwrap_or_else(|| text.to_owned())
}

/// The translation of an argument: a number, a time, a message, or names of models and bodies separated by commas.
fn argument(text: &str) -> String {
    if text.parse::<f64>().is_ok() {
        return localised(text.to_owned());
    }
    let time = text.ends_with('Z').then(|| Instant::parse(text).ok()).flatten();
    let names = || text.split(", ").map(|name| named("model", body_name(name))).collect::<Vec<_>>().join(", ");
    time.map(instant_text).or_else(|| message(text)).unwrap_or_else(names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::language::set;

    #[test]
    fn a_template_finds_its_arguments_and_nothing_else() {
        let template = Template::of("some-id = { $a } of white against { $b }, says { $c }").expect("a template");
        assert_eq!(template.arguments_in("1e-3 of white against 2, says the Sun"), Some(vec!["1e-3", "2", "the Sun"]));
        assert_eq!(template.arguments_in("1e-3 of black against 2, says the Sun"), None);
        assert_eq!(template.arguments_in(" of white against 2, says the Sun"), None, "an argument is never empty");
        assert_eq!(template.arguments_in("a of white against b, says "), None);
        // The first occurrence of a fixed part need not be the right one.
        let twice = Template::of("some-id = { $a } of { $b } end").expect("a template");
        assert_eq!(twice.arguments_in("x of y of z end"), Some(vec!["x", "y of z"]));
        let fixed = Template::of("some-id = set by you").expect("a template");
        assert_eq!((fixed.arguments_in("set by you"), fixed.arguments_in("set by you too")), (Some(vec![]), None));
    }

    #[test]
    fn reasons_are_translated_part_by_part() {
        set(Language::German);
        assert_eq!(translated("set by you"), "von Hand gesetzt");
        assert_eq!(
            translated("nearest penumbra: Moon's, 1.50 of its radius outside"),
            "nächster Halbschatten: Mond, er geht 1,50 seines Radius entfernt vorbei"
        );
        assert_eq!(translated("set by you; nobody wrote this"), "von Hand gesetzt; nobody wrote this");
        assert_eq!(translated("nobody wrote this"), "nobody wrote this");
        assert_eq!(
            translated("at most 2 of white against 1; point-sun: off by at most 7 % of the Sun's light"),
            "höchstens 2 von Weiß gegen 1; punktförmige Sonne: Fehler höchstens 7 % des Sonnenlichts"
        );
        set(Language::Marked);
        assert_eq!(
            translated("nearest penumbra: Mimas's, 1.50 of its radius outside"),
            "«nearest penumbra: ‹Mimas›'s, ‹1«.»50› of its radius outside»"
        );
        set(Language::English);
        assert_eq!(translated("set by you; nobody wrote this"), "set by you; nobody wrote this");
    }
}
