//! Tests that the files of all languages have the same messages with the same arguments, that each message is used, and that no panel shows a text
//! that is not in those files.

use super::*;
use crate::view::app::civil_time::ShownTimeZone;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The arguments of each message of some files, by its id; an id that occurs twice is added to `errors`.
fn arguments_by_id<'f>(files: &[&'f str], errors: &mut Vec<String>) -> BTreeMap<&'f str, BTreeSet<&'f str>> {
    let mut found: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for file in files {
        let mut id = "";
        for line in file.lines().filter(|line| !line.starts_with('#')) {
            if let Some(new_id) = files::ids(line).next() {
                id = new_id;
                if found.insert(id, BTreeSet::new()).is_some() {
                    errors.push(format!("{id} occurs twice"));
                }
            }
            let arguments = line.split("{ $").skip(1).filter_map(|rest| rest.split([' ', '}']).next());
            found.entry(id).or_default().extend(arguments);
        }
    }
    found.remove("");
    found
}

/// One line for each message or argument that only one of two languages has.
fn differences(first: &[&str], second: &[&str]) -> Vec<String> {
    let mut errors = Vec::new();
    let [first, second] = [first, second].map(|files| arguments_by_id(files, &mut errors));
    for (id, arguments) in &first {
        match second.get(id) {
            None => errors.push(format!("{id} is missing in the second")),
            // A message for a date uses only the arguments that its language needs, but has some in every language or in none.
            Some(others) if id.starts_with("date-") && !others.is_empty() && !arguments.is_empty() => {}
            Some(others) if others != arguments => errors.push(format!("{id} has other arguments: {arguments:?}, {others:?}")),
            Some(_) => {}
        }
    }
    errors.extend(second.keys().filter(|id| !first.contains_key(*id)).map(|id| format!("{id} is missing in the first")));
    errors
}

#[test]
fn all_languages_have_the_same_messages() {
    for language in Language::ALL {
        assert_eq!(
            differences(files::message_files(Language::English), files::message_files(language)),
            Vec::<String>::new(),
            "{language:?}"
        );
    }
}

#[test]
fn differences_finds_missing_messages_missing_arguments_and_duplicates() {
    let english = "one = One\ntwo = Two of { $all }\n";
    assert!(differences(&[english], &[english]).is_empty());
    assert_eq!(differences(&[english], &["one = Eins\n"]), ["two is missing in the second"]);
    assert_eq!(differences(&["one = One\n"], &[english]), ["two is missing in the first"]);
    assert_eq!(differences(&[english], &["one = Eins\ntwo = Zwei\n"]).len(), 1);
    assert_eq!(differences(&[english, "one = Again\n"], &[english]), ["one occurs twice"]);
}

/// Fluent reads every file without an error, and `Messages::without_arguments` has exactly the messages without arguments. The files of `catalog_files`
/// translate the texts of the shipped catalogs, such as names of bodies.
#[test]
fn every_file_is_valid_fluent() {
    for language in Language::ALL {
        for file in files::message_files(language).iter().chain(files::catalog_files(language)) {
            let error = FluentResource::try_new((*file).to_owned()).err().map(|(_, errors)| format!("{errors:?}"));
            assert_eq!(error, None, "{language:?}: {}", file.lines().next().unwrap_or_default());
        }
        let all = arguments_by_id(files::message_files(language), &mut Vec::new());
        let formatted = &messages(language).without_arguments;
        for (id, arguments) in all {
            assert_eq!(formatted.contains_key(id), arguments.is_empty(), "{language:?}: {id}");
        }
    }
    assert!(FluentResource::try_new("one = { $\n".to_owned()).is_err(), "a broken file is found");
}

/// First parts of the ids of messages that [`translated_name`] looks up, without the hyphen.
const KINDS_OF_NAMES: [&str; 15] = [
    "body",
    "contact",
    "direction",
    "effect",
    "model",
    "moment-kind",
    "month",
    "month-short",
    "part",
    "pass",
    "pixels",
    "quality",
    "renderer",
    "stage",
    "tone",
];

/// Appends the path and the code, without unit tests, of each source file below a folder, except for folders named `language`.
fn sources(folder: &Path, out: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if entry.is_dir() && !entry.ends_with("language") {
            sources(&entry, out);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&entry).expect("a source");
            let code = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default().to_owned();
            out.push((entry.display().to_string(), code));
        }
    }
}

/// The source files of the window, including those of `language` that use messages.
fn window_sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/view");
    let mut all = Vec::new();
    sources(&root, &mut all);
    for name in ["dates.rs", "translation.rs", "numbers.rs"] {
        all.push((name.into(), std::fs::read_to_string(root.join("language").join(name)).expect("a source")));
    }
    all
}

/// Ids in calls of `text!`.
fn ids_in_calls(code: &str) -> impl Iterator<Item = &str> {
    code.split("text!(\"").skip(1).filter_map(|rest| rest.split('"').next())
}

#[test]
fn each_message_is_used_and_each_used_message_exists() {
    let known = arguments_by_id(files::message_files(Language::English), &mut Vec::new());
    let sources = window_sources();
    for (path, code) in &sources {
        for id in ids_in_calls(code) {
            assert!(known.contains_key(id), "{path}: no file has the message {id}");
        }
    }
    let is_used = |id: &str| {
        let quoted = format!("\"{id}\"");
        let is_composed_at_run_time = KINDS_OF_NAMES.iter().any(|kind| id.strip_prefix(kind).is_some_and(|rest| rest.starts_with('-')));
        // `message_tests` finds unused messages of `crate::message`.
        let is_of_other_modules = files::ids(crate::message::ENGLISH_FILE).any(|known| known == id);
        is_composed_at_run_time || is_of_other_modules || sources.iter().any(|(_, code)| code.contains(&quoted))
    };
    let unused: Vec<_> = known.keys().filter(|id| !is_used(id)).collect();
    assert!(unused.is_empty(), "no source uses {unused:?}");
    assert!(!is_used("nobody-uses-this"));
    assert_eq!(ids_in_calls("f(text!(\"a-b\"), text!(\"c\", n = 1))").collect::<Vec<_>>(), ["a-b", "c"]);
}

/// The beginnings of calls whose argument is shown as text.
const CALLS_THAT_SHOW: [&str; 19] = [
    "label(",
    "button(",
    "on_hover_text(",
    "heading(",
    "strong(",
    "weak(",
    "small(",
    "checkbox(",
    "hint_text(",
    "small_button(",
    "accessible_name(",
    "selectable_label(",
    "toggle_value(",
    "collapsing(",
    "CollapsingHeader::new(",
    "Window::new(",
    "RichText::new(",
    "line(ui, ",
    ".text(",
];

/// Shown texts that are the same in every language: units, file names, examples of input.
const SAME_IN_ALL: [&str; 5] = ["ms", "tour.json", "shaders/{}:{}", "+eclipse=linear,-normal", "lambert.albedo.sun1.ellipsoid"];

/// The string literals with at least one word in the calls of [`CALLS_THAT_SHOW`].
fn shown_literals(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for call in CALLS_THAT_SHOW {
        for rest in code.split(call).skip(1) {
            let first = rest.trim_start().trim_start_matches(['&', '(']);
            let literal = first.strip_prefix('"').or_else(|| first.strip_prefix("format!(\"")).and_then(|rest| rest.split('"').next());
            // Placeholders of a format string do not count as words.
            let words = |text: &str| {
                let plain: String = text.split('{').map(|part| part.rsplit('}').next().unwrap_or_default()).collect::<Vec<_>>().join(" ");
                plain.split_whitespace().filter(|word| word.chars().filter(|c| c.is_alphabetic()).count() > 1).count()
            };
            found.extend(literal.filter(|text| words(text) >= 1 && !SAME_IN_ALL.contains(text)).map(str::to_owned));
        }
    }
    found
}

#[test]
fn no_panel_shows_a_text_that_is_not_in_the_fluent_files() {
    let untranslated: Vec<String> = window_sources()
        .iter()
        .flat_map(|(path, code)| shown_literals(code).into_iter().map(move |text| format!("{path}: {text}")))
        .collect();
    assert!(untranslated.is_empty(), "{untranslated:#?}");
    assert_eq!(
        shown_literals("ui.label(\"one\"); ui.button(format!(\"open {x} now\")); ui.label(\"ms\"); ui.label(\"{km}: {}\")").len(),
        2
    );
}

/// The names of the contacts of events of all kinds, as the Events panel lists them: those for the entire Earth, and those at a place.
fn contact_names() -> BTreeSet<&'static str> {
    use crate::time::Instant;
    use crate::view::app::event_search::{EventKind, events_between};
    use crate::view::app::settings::Home;
    let catalog = crate::catalog::Catalog::embedded();
    let ephemeris = crate::ephemeris::Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    let instant = |text: &str| Instant::parse(text).expect("a time");
    let mut names = BTreeSet::new();
    for (kind, from, to, latitude_deg, longitude_deg) in [
        // A total eclipse of the Sun, at the place of its greatest phase.
        (EventKind::Solar, "2024-04-08T00:00:00Z", "2024-04-09T00:00:00Z", 25.3, -104.1),
        // A total eclipse of the Moon, where the Moon is then in the zenith.
        (EventKind::Lunar, "2025-03-14T00:00:00Z", "2025-03-15T00:00:00Z", 3.3, -102.2),
        // A transit of Venus, where the Sun is then in the zenith.
        (EventKind::Transit, "2012-06-05T00:00:00Z", "2012-06-07T00:00:00Z", 22.7, 157.0),
        // Two days with all four classes of events at Jupiter, and with mutual events of its moons.
        (EventKind::Moons, "2015-01-24T00:00:00Z", "2015-01-26T00:00:00Z", 18.0, 0.0),
    ] {
        let found = events_between(&catalog, &ephemeris, &[kind], instant(from), instant(to)).expect("events");
        assert!(!found.is_empty(), "{kind:?}");
        for event in found {
            names.extend(event.contacts().iter().map(|(name, _)| *name));
            let seen = event.seen_from(&catalog, &ephemeris, Home { latitude_deg, longitude_deg }).expect("a place");
            names.extend(seen.contacts.iter().map(|contact| contact.name));
            // The messages of C1 to C4 speak of an eclipse of the Sun.
            let has_solar_contacts = seen.contacts.iter().any(|contact| contact.name.starts_with('C'));
            assert_eq!(has_solar_contacts, kind == EventKind::Solar, "{kind:?}: {seen:?}");
        }
    }
    names
}

/// The name of each contact is a symbol, the same in all languages, which a message explains (`contact-about-c1`), or a word, which a message translates
/// (`contact-begin`). No language has such messages for any other name.
#[test]
fn each_contact_of_an_event_has_its_message() {
    let names = contact_names();
    for expected in ["C2", "P4", "U2", "U3", "I", "III", "maximum", "begin", "end"] {
        assert!(names.contains(expected), "{expected} is not among {names:?}");
    }
    // A symbol consists of capitals and digits.
    let key = |name: &str| {
        let lower = name.to_lowercase();
        if name == name.to_uppercase() { format!("contact-about-{lower}") } else { format!("contact-{lower}") }
    };
    for language in Language::ALL {
        let known = &messages(language).without_arguments;
        let has_message = |name: &str| known.contains_key(&key(name));
        let missing: Vec<_> = names.iter().filter(|name| !has_message(name)).collect();
        assert!(missing.is_empty(), "{language:?}: {missing:?}");
        // There is no message for names that no contact has.
        assert!(!has_message("begins") && !has_message("U9"), "{language:?}");
        // A message may explain a word, too (`contact-about-begin`).
        let is_of_a_contact = |id: &str| names.iter().any(|name| id == key(name) || id == format!("contact-about-{}", name.to_lowercase()));
        let unused: Vec<_> = known.keys().filter(|id| id.starts_with("contact-") && !is_of_a_contact(id)).collect();
        assert!(unused.is_empty(), "{language:?}: {unused:?}");
    }
    set(Language::German);
    assert_eq!(["begin", "end", "maximum", "C1"].map(|name| translated_name("contact", name)), ["beginnt", "endet", "Maximum", "C1"]);
    set(Language::English);
}

/// A message that a language lacks is shown in English, an unknown message as its id; missing arguments cause no panic.
#[test]
fn missing_messages_fall_back() {
    set(Language::German);
    assert_eq!(text_by_id("tab-effects"), "Effekte");
    assert_eq!(text_by_id("no-such-message"), "no-such-message");
    assert_eq!(text_with_arguments("no-such-message", &[]), "no-such-message");
    assert_eq!(text_with_arguments("perf-bodies-value", &[]), "perf-bodies-value", "its arguments are missing");
    assert_eq!((body_name("Earth"), body_name("Himalia")), ("Erde", "Himalia"));
    set(Language::English);
    assert_eq!((text_by_id("tab-effects"), body_name("Earth")), ("Effects", "Earth"));
}

#[test]
fn numbers_and_dates_are_written_as_in_the_language() {
    use crate::time::Instant;
    let time = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
    let early = Instant::parse("-0584-05-28T14:00:00Z").expect("a time");
    let day = chrono::NaiveDate::from_ymd_opt(2024, 3, 8).expect("a day");
    let all = || {
        let decimals = 0..=2;
        [
            decimal(1.25, 2),
            signed(0.5, 1),
            dates::instant_text(time),
            dates::day_text(early, ShownTimeZone::Utc),
            dates::long_date(day),
            dates::day_and_month(day),
            dates::minute_text(time, ShownTimeZone::Utc),
            dates::month_day_second_text(time, ShownTimeZone::Utc),
            dates::date_in_digits("2024-04-08"),
            dates::date_in_digits("-0584-05-28"),
            numbers::field_text(1.5, decimals),
        ]
    };
    assert_eq!(
        all(),
        [
            "1.25",
            "+0.5",
            "2024-04-08T18:17:16Z",
            "-0584-05-28",
            "8 March 2024",
            "8 Mar",
            "2024-04-08 18:17 UTC",
            "04-08 18:17:16",
            "2024-04-08",
            "-0584-05-28",
            "1.5"
        ]
    );
    assert_eq!((numbers::typed_number("1.5"), numbers::typed_number("1,5"), numbers::typed_number(" −2 ")), (Some(1.5), None, Some(-2.0)));
    for not_a_number in ["nan", "-NaN", "inf", "-infinity", "1e999", ""] {
        assert_eq!(numbers::typed_number(not_a_number), None, "{not_a_number}");
    }
    set(Language::German);
    assert_eq!(
        all(),
        [
            "1,25",
            "+0,5",
            "8. April 2024, 18:17:16 UTC",
            "28. Mai 585 v. Chr. (greg.)",
            "8. März 2024",
            "8. März",
            "8. April 2024, 18:17 UTC",
            "08.04. 18:17:16",
            "08.04.2024",
            "28.05.585 v. Chr.",
            "1,5"
        ]
    );
    assert_eq!((numbers::typed_number("1,5"), numbers::typed_number("1.5")), (Some(1.5), Some(1.5)));
    assert_eq!((numbers::typed_number("1.234,5"), numbers::typed_number("x")), (Some(1234.5), None));
    set(Language::English);
}

#[test]
fn times_are_rounded_and_carry_over() {
    use crate::time::Instant;
    let utc = ShownTimeZone::Utc;
    let instant = |text: &str| Instant::parse(text).expect(text);
    assert_eq!(dates::minute_text(instant("1999-12-31T23:59:40Z"), utc), "2000-01-01 00:00 UTC");
    assert_eq!(dates::minute_text_without_zone(instant("1999-12-31T23:59:40Z"), utc), "2000-01-01 00:00");
    assert_eq!(dates::month_day_second_text(instant("1999-12-31T23:59:40.6Z"), utc), "12-31 23:59:41");
    assert_eq!(dates::month_day_second_text(instant("-0584-05-28T14:00:00Z"), utc), "05-28 14:00:00");
    assert_eq!(dates::minute_text(instant("-0584-05-28T14:00:00Z"), utc), "-0584-05-28 14:00 UTC");
    assert_eq!(dates::minute_in_digits(instant("1999-12-31T23:59:40Z")), "1999-12-31 23:59 UTC");
    // More than a million years from 2000, the text is `jd_tdb:` and the Julian date. The 30 seconds are those that `minute_text` adds to round to the minute.
    let far = Instant::from_tdb_seconds_past_j2000(1e15);
    assert_eq!(dates::minute_text(far, utc), far.plus_seconds(30.0).to_utc_iso());
}

/// Times that a scene draws into its image are written as in the window.
#[test]
fn times_in_images_are_written_as_in_the_window() {
    use crate::time::Instant;
    set(Language::German);
    for month in 1..=12 {
        for year in ["2024", "0007", "-0584"] {
            let t = Instant::parse(&format!("{year}-{month:02}-09T18:17:16Z")).expect("a time");
            assert_eq!(Language::German.in_images().time(&t.to_utc_iso()), dates::instant_text(t));
        }
    }
    set(Language::English);
}
