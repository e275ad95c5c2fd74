//! Tests of the message texts: arguments, numbers, names and times in English and German, and the texts that are drawn into images.

use super::{Argument, ENGLISH_FILE, GERMAN_FILE, TextLanguage};
use std::collections::HashSet;

#[test]
fn messages_substitute_their_arguments() {
    let limit = reason!("of-white", light = format_args!("{:.2e}", 0.001), threshold = 2);
    let both = reason!("inside-sun").and(reason!("eclipse-at-most", light = limit));
    assert_eq!(both.to_string(), "it is inside the Sun; at most 1.00e-3 × white (threshold 2)");
    assert_eq!(serde_json::to_string(&both).expect("JSON"), "\"it is inside the Sun; at most 1.00e-3 × white (threshold 2)\"");
    let names = reason!("eclipse-penumbra-of", bodies = vec!["Io".to_owned(), "Europa".to_owned()]);
    assert_eq!(names.to_string(), "penumbra of Io, Europa on its lit side");
    // The text of an unknown id is the id, and that of a missing argument is its name: a mistake stays readable until the tests find it. `reason!` adds
    // `reason-` to the id, `message!` does not.
    assert_eq!(message!("nobody-wrote-this").to_string(), "nobody-wrote-this");
    assert_eq!(message!("reason-of-white", light = 1).to_string(), "1 × white (threshold threshold)");
}

#[test]
fn german_has_its_own_numbers_names_and_times() {
    let german = TextLanguage::German;
    for (english, expected) in
        [("20 000 km", "20.000 km"), ("0.5 au", "0,5 au"), ("1.00\"", "1,00\""), ("5 km", "5 km"), ("end. 7", "end. 7")]
    {
        assert_eq!((german.number(english).as_str(), TextLanguage::English.number(english).as_str()), (expected, english));
    }
    // The compass point E is O (Osten) in German.
    assert_eq!((german.name("body", "Earth"), german.name("compass", "E"), german.name("body", "Himalia")), ("Erde", "O", "Himalia"));
    assert_eq!(german.time("2024-04-08T18:17:16.250Z"), "8. April 2024, 18:17:16,250 UTC");
    assert_eq!(german.time("-0584-05-28T14:00:00Z"), "28. Mai 585 v. Chr. (greg.), 14:00:00 UT1");
    assert_eq!(german.time("1582-10-14T00:00:00Z"), "14. Oktober 1582 (greg.), 00:00:00 UT1");
    assert_eq!(german.time("1582-10-15T00:00:00Z"), "15. Oktober 1582, 00:00:00 UT1");
    assert_eq!(german.time("JD 5000000.5 UTC"), "JD 5000000.5 UTC", "not a calendar date");
    assert_eq!(TextLanguage::English.time("2024-04-08T18:17:16Z"), "2024-04-08 18:17:16 UTC");
    assert_eq!(TextLanguage::English.time("-2800-01-01T00:00:00Z"), "-2800-01-01 00:00:00 UT1");
    assert_eq!(TextLanguage::English.time("1971-12-31T23:59:59Z"), "1971-12-31 23:59:59 UT1");
    assert_eq!(TextLanguage::English.time("1972-01-01T00:00:00Z"), "1972-01-01 00:00:00 UTC");
    let caption = message!("image-from-centre", body = "Moon");
    assert_eq!((caption.text_in(german).as_str(), caption.to_string().as_str()), ("vom Mittelpunkt aus: Mond", "from the centre of Moon"));
    assert_eq!(message!("nobody-wrote-this").text_in(german), "nobody-wrote-this");
    // A time that cannot be parsed is written as it is.
    assert_eq!(message!("reason-lines-shadow-path", body = "Moon", time = Argument::Time("x".into())).to_string().matches('x').count(), 1);
}

/// In both languages each argument that is a quantity is followed by its unit, and the same numbers are called thresholds.
#[test]
fn quantities_have_the_same_units_in_both_languages() {
    let units = [
        ("} degrees", "} Grad"),
        ("} px", "} px"),
        ("} km", "} km"),
        ("} %", "} %"),
        ("} cd/m2", "} cd/m2"),
        ("} radii", "} Radien"),
        ("} au", "} AE"),
        ("(threshold ", "(Schwelle "),
    ];
    let mut compared = 0;
    for (id, english) in ENGLISH_FILE.lines().filter_map(|line| line.split_once(" = ")) {
        let german = GERMAN_FILE.lines().find_map(|line| line.strip_prefix(id)?.strip_prefix(" = ")).unwrap_or_default();
        for (unit, german_unit) in units {
            assert_eq!(english.matches(unit).count(), german.matches(german_unit).count(), "{id}: {english} | {german}");
            compared += english.matches(unit).count();
        }
    }
    assert!(compared > 50, "only {compared} units");
}

/// Every text that is drawn into an image exists in both languages. No line of either file chooses between plural forms, because this module cannot evaluate
/// Fluent's selectors (` ->`).
#[test]
fn texts_in_images_are_simple_and_in_both_languages() {
    let ids = |file: &'static str| -> HashSet<&str> {
        let of_images = |line: &&str| ["image-", "compass-", "body-"].iter().any(|kind| line.starts_with(kind));
        file.lines().filter(of_images).filter_map(|line| Some(line.split_once(" = ")?.0)).collect()
    };
    assert!(ids(ENGLISH_FILE).len() > 30);
    assert_eq!(ids(ENGLISH_FILE), ids(GERMAN_FILE));
    assert!(![ENGLISH_FILE, GERMAN_FILE].iter().any(|file| file.contains(" ->")));
}
