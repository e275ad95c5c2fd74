//! Translates texts of the modules below the window (scene, catalogs).
//!
//! In: messages (reasons of scenes, notes on estimated values of bodies), or English texts of the catalogs (moments, tours, gases). Out: the text in the
//! window's language. Always: a message is looked up by its id, a text of a catalog by an id made of its English name; a text of a catalog without a
//! translation, such as one of a user's own catalog, stays English. Not here: which message an error has (`view::error_texts`).

use super::dates::{instant_text, iso_date_text};
use super::numbers::number_text;
use super::{Language, body_name, current, marked_message, messages, text, text_by_id, text_with_arguments, translated_name};
use crate::message::{Argument, Message, Reason};
use crate::time::Instant;
use std::borrow::Cow;

/// The text of a message.
pub fn message_text(message: &Message) -> String {
    if message.arguments.is_empty() {
        return text_by_id(message.id).to_owned();
    }
    let texts: Vec<(&'static str, String)> = message.arguments.iter().map(|(name, argument)| (*name, argument_text(argument))).collect();
    let arguments: Vec<_> = texts.iter().map(|(name, text)| (*name, text.as_str().into())).collect();
    text_with_arguments(message.id, &arguments)
}

/// The text of a reason.
pub fn reason_text(reason: &Reason) -> String {
    reason.messages().iter().map(message_text).collect::<Vec<_>>().join("; ")
}

/// The text of an argument in the window's language.
fn argument_text(argument: &Argument) -> String {
    // A name may be that of a body or of an effect's model; a name of any other kind has no translation and stays.
    let name_text = |name: &str| translated_name("model", body_name(name)).to_owned();
    match argument {
        Argument::Number(number) => number_text(number),
        Argument::Name(name) => name_text(name),
        Argument::Names(names) => names.iter().map(|name| name_text(name)).collect::<Vec<_>>().join(", "),
        Argument::English(text) => english_text(text),
        Argument::Time(iso_date) if !iso_date.contains('T') => iso_date_text(iso_date),
        Argument::Time(iso) => Instant::parse(iso).map_or_else(|_| iso.clone(), instant_text),
        // One argument may hold several texts of a catalog, separated by `; `; each has its own id.
        Argument::CatalogText(kind, text) => text.split("; ").map(|part| catalog_text(kind, part)).collect::<Vec<_>>().join("; "),
        Argument::Reason(reason) => reason_text(reason),
    }
}

/// An English text, such as the cause of an error. If it ends in an error of the operating system whose number and text are known, that error is translated.
fn english_text(english: &str) -> String {
    let Some((text_before, number_and_rest)) = english.split_once(" (os error ") else { return english.to_owned() };
    let number = number_and_rest.split_once(')').map_or(number_and_rest, |(number, _)| number);
    let (phrase, translated) = match number {
        "2" => ("No such file or directory", text!("system-not-found")),
        "13" => ("Permission denied", text!("system-denied")),
        "20" => ("Not a directory", text!("system-no-folder")),
        "21" => ("Is a directory", text!("system-folder")),
        "28" => ("No space left on device", text!("system-full")),
        "30" => ("Read-only file system", text!("system-read-only")),
        _ => return english.to_owned(),
    };
    match text_before.strip_suffix(phrase) {
        Some(start) if translated != phrase => format!("{start}{translated}"),
        _ => english.to_owned(),
    }
}

/// A text of a catalog, for instance the name of a moment. `kind`: the first part of the ids of its translations, such as `moment`.
pub fn catalog_text<'t>(kind: &str, english: &'t str) -> Cow<'t, str> {
    if current() == Language::English {
        return Cow::Borrowed(english);
    }
    catalog_translation(&format!("{kind}-{}", slug(english)), english)
}

/// A further text of a catalog's entry, for instance the description of a moment. `kind`: as for [`catalog_text`]. `name`: the entry's English name.
/// `part`: the last part of the id, such as `about`.
pub fn catalog_entry_text<'t>(kind: &str, name: &str, part: &str, english: &'t str) -> Cow<'t, str> {
    if current() == Language::English {
        return Cow::Borrowed(english);
    }
    catalog_translation(&format!("{kind}-{}-{part}", slug(name)), english)
}

/// The message with this id, or else the English text.
fn catalog_translation<'t>(id: &str, english: &'t str) -> Cow<'t, str> {
    // The message files for English have no texts of catalogs. The German file decides whether a text can be translated, and is therefore put in `«»`.
    if current() == Language::MarkedEnglish {
        let is_translated = messages(Language::German).without_arguments.contains_key(id);
        return if is_translated { Cow::Owned(marked_message(english)) } else { Cow::Borrowed(english) };
    }
    messages(current()).without_arguments.get(id).map_or(Cow::Borrowed(english), |text| Cow::Borrowed(text))
}

/// An English text as a part of an id: its ASCII letters and digits in lower case, with one hyphen for each run of other characters between them.
fn slug(english: &str) -> String {
    let mut id = String::new();
    for c in english.chars() {
        if c.is_ascii_alphanumeric() {
            id.push(c.to_ascii_lowercase());
        } else if !id.is_empty() && !id.ends_with('-') {
            id.push('-');
        }
    }
    id.truncate(id.trim_end_matches('-').len());
    id
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{message, reason};
    use crate::view::language::set;

    #[test]
    fn reasons_are_translated_message_by_message() {
        // `share`: by how much the penumbra misses, as a multiple of its radius.
        let nearest = reason!("eclipse-nearest", body = "Moon", share = format_args!("{:.2}", 1.5));
        let light = reason!("of-white", light = 2, threshold = 1);
        let both = nearest.and(reason!("eclipse-at-most", light = light)).and(reason!("set-by-you"));
        assert_eq!(reason_text(&both), both.to_string());
        set(Language::German);
        assert_eq!(
            reason_text(&both),
            "nächster Halbschatten: Mond, er geht um das 1,50-fache seines Radius vorbei; höchstens 2 × Weiß (Schwelle 1); von Hand gesetzt"
        );
        let light = reason!("of-white", light = format_args!("{:.2e}", 1190.0), threshold = format_args!("{:.2e}", 1.52e-4));
        assert_eq!(reason_text(&light), "1.190 × Weiß (Schwelle 0,000152)");
        let time = Argument::Time("2024-04-08T18:17:16Z".into());
        let path = reason!("lines-shadow-path", body = "Moon", time = time);
        assert!(reason_text(&path).contains("8. April 2024, 18:17:16 UTC"), "{}", reason_text(&path));
        assert_eq!(message_text(&message!("nobody-wrote-this")), "nobody-wrote-this");
        // A system error is recognised by its number and its text together.
        assert_eq!(english_text("x: No such file or directory (os error 2)"), "x: keine solche Datei, kein solcher Ordner");
        assert_eq!(english_text("x: odd (os error 2)"), "x: odd (os error 2)");
        // `«»` is around each message, also around the decimal mark, which is a message of its own; `‹›` is around each text argument.
        set(Language::MarkedEnglish);
        assert_eq!(
            reason_text(&both.messages()[0].clone().into()),
            "«the nearest penumbra, of ‹«Moon»›, misses by ‹1«.»50› times its own radius»"
        );
        set(Language::English);
    }

    #[test]
    fn texts_of_catalogs_are_found_by_their_english_names() {
        assert_eq!(slug("8 April: Voyager 2's (new) images."), "8-april-voyager-2-s-new-images");
        set(Language::German);
        assert_eq!(catalog_text("moment", "Earthrise"), "Erdaufgang");
        assert!(catalog_entry_text("moment", "Earthrise", "about", "The Earth").starts_with("Die Erde über dem Mondhorizont"));
        assert_eq!(catalog_text("moment", "My own eclipse"), "My own eclipse");
        // `invented`: the kind of texts about maps and shapes that are invented. Only the first of these two texts is in the shipped catalogs.
        let how = Argument::CatalogText("invented", "the northern half, which no spacecraft saw lit; my own part".into());
        assert_eq!(argument_text(&how), "die Nordhälfte, die keine Raumsonde beleuchtet sah; my own part");
        set(Language::MarkedEnglish);
        assert_eq!((catalog_text("moment", "Earthrise"), catalog_text("moment", "Mine")), ("«Earthrise»".into(), "Mine".into()));
        set(Language::English);
        assert_eq!(catalog_text("moment", "Earthrise"), "Earthrise");
    }
}
