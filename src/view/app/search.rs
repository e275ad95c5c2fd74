//! Interpretations of a text in the search field: bodies, moments, stars, minor planets, comets, constellations, dates, events, cities, surface features,
//! places, effects, shader keys (each names one generated shader).
//!
//! In: the text, the catalog, the current time. Out: suggestions, the likeliest first; or similar names. Not here: the effect of choosing a
//! suggestion (`panels`).

use crate::catalog::cities::{self, City};
use crate::catalog::constellations::{Constellation, Constellations};
use crate::catalog::moments::Moment;
use crate::catalog::nomenclature::{self, SurfaceFeature};
use crate::catalog::small_bodies::SmallBody;
use crate::catalog::stars::STAR_NAMES;
use crate::catalog::{Catalog, NaifId};
use crate::scene::effects::Effect;
use crate::shader::key::ShaderKey;
use crate::time::Instant;
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::date_text::{julian_date, parse_date, resembles_date};
use crate::view::app::event_search::EventKind;
use crate::view::app::orbit_camera::OrbitCamera;
use crate::view::app::place_text::parse_place;
use crate::view::app::presets::Preset;
use crate::view::app::view_state::{DEFAULT_FOV_DEG, ViewState, body_fixed_orbit_pose};
use crate::view::app::viewer::{SelectableBody, Viewer};
use crate::view::app::what_to_see_now::NowItem;
use crate::view::language::dates::{day_text, minute_text, second_text, written_date};
use crate::view::language::{body_name, catalog_text, decimal, text, translated_name};
use crate::wording::nearest;
use chrono::{NaiveDate, NaiveTime};
use glam::DVec3;
use std::collections::HashSet;

/// Shortest text, in characters, that is looked up within names and search words: one or two letters occur in too many of them.
const MIN_LETTERS: usize = 3;
/// Height of the camera above a surface feature, in diameters of the feature.
const SURFACE_FEATURE_HEIGHT_DIAMETERS: f64 = 3.6;
/// Least and greatest height of the camera above a surface feature, in radii of the body.
const SURFACE_FEATURE_HEIGHT_LIMITS_RADII: [f64; 2] = [0.12, 2.5];
/// Largest number of minor planets and comets among the suggestions, so that they leave room for other kinds.
const MAX_SMALL_BODIES: usize = 3;
/// Largest number of minor planets and comets whose names are compared with a text that matches nothing.
const MAX_SIMILAR_SMALL_BODIES: usize = 5000;

/// What the user chooses with a suggestion.
#[derive(Clone, Debug, PartialEq)]
pub enum SearchTarget {
    Body(NaifId),
    Preset(Preset),
    /// A view of *What to see now*.
    WhatToSeeNow(NowItem),
    /// A moment's name in the catalog.
    Moment(String),
    /// Hipparcos number.
    Star(u32),
    /// A minor planet or comet that is no body of the catalog.
    SmallBody(Box<SmallBody>),
    Constellation(&'static Constellation),
    Time(Instant),
    Events {
        kinds: Vec<EventKind>,
        /// Start of the search, if a year or a date was given.
        start: Option<Instant>,
    },
    /// A place on the selected body.
    Place {
        latitude_deg: f64,
        longitude_deg: f64,
    },
    City(&'static City),
    /// A surface feature of a body.
    Feature {
        body: NaifId,
        feature: &'static SurfaceFeature,
    },
    Effect(Effect),
    Key(Box<ShaderKey>),
}

/// A line below the search field.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    pub name: String,
    /// A short description of the target.
    pub about: String,
    pub target: SearchTarget,
}

fn suggestion(name: impl Into<String>, about: impl Into<String>, target: SearchTarget) -> Suggestion {
    Suggestion { name: name.into(), about: about.into(), target }
}

/// At most `max_count` suggestions for a text, the likeliest first. `zone`: in which dates are read and written.
pub fn suggestions(text: &str, viewer: &Viewer, catalog: &Catalog, zone: ShownTimeZone, max_count: usize) -> Vec<Suggestion> {
    let text = text.trim();
    if text.is_empty() {
        return Vec::new();
    }
    let mut found = Vec::new();
    if let Some(time) = parse_date(text, zone, viewer.now()) {
        let has_seconds = text.matches(':').count() >= 2 && !time.to_utc_iso().ends_with(":00Z");
        let name = if has_seconds { second_text(time, zone) } else { minute_text(time, zone) };
        let name = julian_date(text).map_or(name.clone(), |julian| text!("search-julian", julian = written_date(julian), date = name));
        found.push(suggestion(name, text!("search-date"), SearchTarget::Time(time)));
        if resembles_date(text) {
            // Who types a day or a month may look for its eclipse.
            let kinds = vec![EventKind::Solar, EventKind::Lunar, EventKind::Transit];
            let start = start_of_day(time, zone);
            found.push(suggestion(
                events_from(&kinds, start, zone),
                text!("search-events"),
                SearchTarget::Events { kinds, start: Some(start) },
            ));
        }
    }
    found.extend(parse_place(text).map(|(latitude_deg, longitude_deg)| {
        let about = text!("search-place", body = viewer.name(viewer.selected));
        suggestion(text, about, SearchTarget::Place { latitude_deg, longitude_deg })
    }));
    found.extend(
        parse_event_search(text, zone, viewer.now())
            .map(|(name, kinds, start)| suggestion(name, text!("search-events"), SearchTarget::Events { kinds, start })),
    );
    found.extend(
        viewer
            .matching_bodies(text, max_count)
            .into_iter()
            .map(|body| suggestion(body_name(&body.name), about_body(body, viewer), SearchTarget::Body(body.id))),
    );
    found.extend(stars(text, catalog));
    // Minor planets have the names of cities, too (Paris, Vienna): the city is likelier.
    let is_city = cities::all().iter().any(|city| city.name.to_lowercase() == text.to_lowercase());
    let sky_objects = small_bodies(text, catalog).chain(constellations(text));
    let (called_so, beginning_so): (Vec<_>, Vec<_>) = sky_objects.partition(|(is_exact, _)| *is_exact && !is_city);
    found.extend(called_so.into_iter().map(|(_, suggestion)| suggestion));
    found.extend(presets_and_now_items(text));
    found.extend(moments(text, catalog.moments(), zone));
    found.extend(cities::with_prefix(text, max_count).into_iter().map(|city| {
        suggestion(city.name, text!("search-city", country = catalog_text("country", city.country)), SearchTarget::City(city))
    }));
    found.extend(beginning_so.into_iter().map(|(_, suggestion)| suggestion));
    found.extend(surface_features(text, viewer).take(max_count));
    found.extend(effects(text));
    if text.contains('.')
        && let Ok(key) = text.parse::<ShaderKey>()
    {
        found.push(suggestion(text, text!("search-key"), SearchTarget::Key(Box::new(key))));
    }
    found.truncate(max_count);
    found
}

/// Texts that the user may have meant by one that matches nothing, likeliest first: similar names of bodies, stars, constellations, cities, comets and minor
/// planets; then the text with its words for events and views spelled correctly, if that matches something. No two differ only in the case of letters.
pub fn similar_texts(text: &str, viewer: &Viewer, catalog: &Catalog, zone: ShownTimeZone) -> Vec<String> {
    let text = text.trim();
    let preset_words = Preset::ALL.into_iter().flat_map(|preset| preset.search_words().split_whitespace());
    let known_words: Vec<&str> = EVENT_WORDS.into_iter().chain(GERMAN_WORDS.map(|(german, _)| german)).chain(preset_words).collect();
    let corrected = |word: &str| {
        if word.parse::<f64>().is_ok() || known_words.contains(&word) {
            return word.to_owned();
        }
        nearest(word, known_words.iter().copied()).first().map_or(word.to_owned(), |near| (*near).to_owned())
    };
    let corrected_text = text.to_lowercase().split_whitespace().map(corrected).collect::<Vec<_>>().join(" ");
    let is_useful = corrected_text != text.to_lowercase() && !suggestions(&corrected_text, viewer, catalog, zone, 1).is_empty();
    let small_bodies = catalog.small_bodies();
    let all_small = small_bodies.comets.iter().chain(&small_bodies.minor_planets).take(MAX_SIMILAR_SMALL_BODIES);
    let names = searchable_names(viewer).chain(all_small.map(SmallBody::short_name).filter(|name| !name.is_empty()));
    let similar_names = nearest(text, names).into_iter().map(str::to_owned);
    let mut found: Vec<String> = similar_names.chain(is_useful.then_some(corrected_text)).collect();
    // A corrected text may be one of the similar names.
    let mut offered = HashSet::new();
    found.retain(|text| offered.insert(text.to_lowercase()));
    found
}

/// All names of bodies, stars, constellations and cities, for [`similar_texts`].
fn searchable_names(viewer: &Viewer) -> impl Iterator<Item = &str> {
    // Both the name in the catalog and, where it differs, the name in the window's language.
    let bodies = viewer.selectable_bodies().iter().flat_map(|b| {
        Some(body_name(&b.name))
            .filter(|name| *name != b.name)
            .into_iter()
            .chain([b.name.as_str()])
            .chain(b.aliases.iter().map(String::as_str))
    });
    let constellations = Constellations::embedded().all.iter().map(|c| c.name.as_str());
    bodies.chain(STAR_NAMES.iter().map(|(name, _)| *name)).chain(constellations).chain(cities::all().iter().map(|city| city.name))
}

/// The description of a body, with the body that it orbits unless that is the Sun.
fn about_body(body: &SelectableBody, viewer: &Viewer) -> String {
    match body.parent {
        Some(parent) if parent != NaifId::SUN && parent != body.id => text!("search-near", body = viewer.name(parent)),
        _ => text!("search-body").into(),
    }
}

/// Stars whose name begins with the text, or whose Hipparcos number it states, as in `HIP 32349`.
fn stars(text: &str, catalog: &Catalog) -> Vec<Suggestion> {
    let lower = text.to_lowercase();
    let stars = catalog.stars();
    let about = |hip: u32| stars.star_of_hip(hip).map(|star| text!("search-star", magnitude = decimal(star.v_magnitude, 1)));
    let by_name = STAR_NAMES.iter().filter(|(name, _)| name.to_lowercase().starts_with(&lower));
    let mut found: Vec<Suggestion> =
        by_name.filter_map(|(name, hip)| Some(suggestion(*name, about(*hip)?, SearchTarget::Star(*hip)))).collect();
    let hip_number = lower.strip_prefix("hip").and_then(|rest| rest.trim().parse().ok());
    found.extend(hip_number.and_then(|hip| Some(suggestion(format!("HIP {hip}"), about(hip)?, SearchTarget::Star(hip)))));
    found
}

/// Minor planets and comets whose name or designation is the text or begins so, each with whether it is the text.
fn small_bodies(text: &str, catalog: &Catalog) -> impl Iterator<Item = (bool, Suggestion)> {
    let lower = text.to_lowercase();
    catalog.small_bodies_matching(text, MAX_SMALL_BODIES).into_iter().map(move |body| {
        let full_name = body.full_name();
        let is_exact = [body.short_name(), body.designation.as_str(), full_name.as_str()].iter().any(|name| name.to_lowercase() == lower);
        let about = if body.is_comet() { text!("search-comet") } else { text!("search-minor-planet") };
        (is_exact, suggestion(full_name, about, SearchTarget::SmallBody(Box::new(body))))
    })
}

/// Constellations whose Latin name begins with the text, or whose abbreviation it is, each with whether the name is the text; `o` also stands for the `ö` of
/// Boötes.
fn constellations(text: &str) -> impl Iterator<Item = (bool, Suggestion)> {
    let plain = |text: &str| text.to_lowercase().replace('ö', "o");
    let wanted = plain(text);
    Constellations::embedded().all.iter().filter_map(move |c: &'static Constellation| {
        let name = plain(&c.name);
        let is_match = wanted.chars().count() >= MIN_LETTERS && (name.starts_with(&wanted) || plain(&c.abbreviation) == wanted);
        is_match.then(|| (name == wanted, suggestion(c.name.as_str(), text!("search-constellation"), SearchTarget::Constellation(c))))
    })
}

/// Presets and items of *What to see now*, if each typed word is the beginning of a word in the view's name or search words.
fn presets_and_now_items(text: &str) -> impl Iterator<Item = Suggestion> {
    let lower = text.to_lowercase();
    let matches = move |words: &str| {
        let known_words = words.to_lowercase();
        lower.chars().count() >= MIN_LETTERS
            && lower.split_whitespace().all(|typed| known_words.split_whitespace().any(|word| word.starts_with(typed)))
    };
    let presets = Preset::ALL.map(|preset| {
        (format!("{} {}", preset.name(), preset.search_words()), suggestion(preset.name(), preset.about(), SearchTarget::Preset(preset)))
    });
    // The other items of *What to see now* are found as events and moments. These two are listed with their search words.
    let now_items = [(NowItem::Moon, "moon tonight now"), (NowItem::Saturn, "saturn now rings")]
        .map(|(item, words)| (format!("{} {words}", item.name()), suggestion(item.name(), text!("now"), SearchTarget::WhatToSeeNow(item))));
    presets.into_iter().chain(now_items).filter(move |(words, _)| matches(words)).map(|(_, suggestion)| suggestion)
}

/// Moments whose name, in the catalog or translated, contains the text, or words that begin with the words of the text; each with its day in `zone`.
fn moments<'a>(text: &'a str, moments: &'a [Moment], zone: ShownTimeZone) -> impl Iterator<Item = Suggestion> + 'a {
    let lower = text.to_lowercase();
    let matches = move |name: &str| {
        let name = name.to_lowercase();
        let begins_words = || lower.split_whitespace().all(|typed| name.split_whitespace().any(|word| word.starts_with(typed)));
        lower.chars().count() >= MIN_LETTERS && (name.contains(&lower) || begins_words())
    };
    let found = moments.iter().filter(move |m| matches(&m.name) || matches(&catalog_text("moment", &m.name)));
    found.map(move |m| {
        let about = text!("search-moment", day = day_text(m.time, zone));
        suggestion(catalog_text("moment", &m.name), about, SearchTarget::Moment(m.name.clone()))
    })
}

/// Surface features whose name begins with the text, body by body, the most prominent features of a body first.
fn surface_features<'a>(text: &str, viewer: &'a Viewer) -> impl Iterator<Item = Suggestion> + 'a {
    let lower = text.to_lowercase();
    let features_of = move |body: &'a SelectableBody| {
        let lower = lower.clone();
        let is_match = move |f: &&'static SurfaceFeature| lower.chars().count() >= MIN_LETTERS && f.name.to_lowercase().starts_with(&lower);
        let features = nomenclature::surface_features(&body.name).iter().filter(is_match);
        features.map(|feature| {
            suggestion(feature.name, text!("search-on", body = body_name(&body.name)), SearchTarget::Feature { body: body.id, feature })
        })
    };
    viewer.selectable_bodies().iter().flat_map(features_of)
}

/// The view of a feature from above, in a frame that rotates with the body. The feature fills a third of the image's height, unless the camera's
/// height is limited by [`SURFACE_FEATURE_HEIGHT_LIMITS_RADII`].
pub(crate) fn surface_feature_view(feature: &SurfaceFeature, body: &SelectableBody, base_view: &ViewState) -> ViewState {
    let height_radii = (SURFACE_FEATURE_HEIGHT_DIAMETERS * feature.diameter_km / body.radii_km.x)
        .clamp(SURFACE_FEATURE_HEIGHT_LIMITS_RADII[0], SURFACE_FEATURE_HEIGHT_LIMITS_RADII[1]);
    let orbit = OrbitCamera::from_offset_radii(feature.direction * (1.0 + height_radii), DVec3::Z);
    base_view.tracking_view(body.id, body_fixed_orbit_pose(body.id, orbit), DEFAULT_FOV_DEG)
}

/// Effects whose name, in English or translated, contains the text.
fn effects(text: &str) -> impl Iterator<Item = Suggestion> {
    let lower = text.to_lowercase();
    let matches = move |e: &Effect| {
        e.name().contains(&lower.replace(' ', "-")) || translated_name("effect", e.name()).to_lowercase().contains(&lower)
    };
    let is_long_enough = text.chars().count() >= MIN_LETTERS;
    let found = Effect::ALL.into_iter().filter(move |e| is_long_enough && matches(e));
    found.map(|e| suggestion(translated_name("effect", e.name()), text!("search-effect"), SearchTarget::Effect(e)))
}

/// Whether `word` has at least `min_bytes` bytes and is the beginning of `known_word`, or all of it.
fn is_abbreviation(known_word: &str, min_bytes: usize, word: &str) -> bool {
    word.len() >= min_bytes && known_word.starts_with(word)
}

/// Words that a search for events may contain, in full or abbreviated.
const EVENT_WORDS: [&str; 14] = [
    "eclipses", "solar", "lunar", "total", "partial", "annular", "sun", "moon", "transits", "mercury", "venus", "shadows", "jupiter",
    "moons",
];

/// German words that a search for events may contain, and their English translations.
const GERMAN_WORDS: [(&str, &str); 18] = [
    ("finsternis", "eclipse"),
    ("finsternisse", "eclipses"),
    ("sonnenfinsternis", "solar eclipse"),
    ("sonnenfinsternisse", "solar eclipses"),
    ("mondfinsternis", "lunar eclipse"),
    ("mondfinsternisse", "lunar eclipses"),
    ("transite", "transits"),
    ("durchgang", "transit"),
    ("venustransit", "transit venus"),
    ("merkurtransit", "transit mercury"),
    ("merkur", "mercury"),
    ("totale", "total"),
    ("nächste", "next"),
    ("nächster", "next"),
    ("jupiters", "jupiter"),
    ("schattenvorübergang", "shadows"),
    ("jupitermonde", "moons"),
    ("von", "of"),
];

/// A text in lower case with its German words for events translated to English.
fn in_english(lower: &str) -> String {
    let english =
        |word: &str| GERMAN_WORDS.iter().find(|(german, _)| *german == word).map_or(word.to_owned(), |(_, word)| (*word).to_owned());
    lower.split_whitespace().map(english).collect::<Vec<_>>().join(" ")
}

/// Whether the text has a word for eclipses or transits, in full or abbreviated to at least four letters.
pub(crate) fn mentions_events(text: &str) -> bool {
    let lower = in_english(&text.to_lowercase());
    lower.split_whitespace().any(|word| ["eclipses", "transits"].iter().any(|known| is_abbreviation(known, 4, word)))
}

/// Parses a search for events, such as `eclipse`, `next lunar eclipse`, `transit of venus 2012`, `moons of jupiter`, `eclipse 12 August 2026`. Returns a name
/// for the search, the kinds of events, and the start of the year, month or day in `zone` if the text states one. `now`: the current time.
fn parse_event_search(text: &str, zone: ShownTimeZone, now: Instant) -> Option<(String, Vec<EventKind>, Option<Instant>)> {
    let lower = in_english(&text.to_lowercase());
    let is_event_word = |word: &&str| EVENT_WORDS.iter().any(|known| is_abbreviation(known, 3, word));
    let (words, date_words): (Vec<&str>, Vec<&str>) =
        lower.split_whitespace().filter(|w| !["next", "of", "the", "in", "on", "a", "am", "im"].contains(w)).partition(is_event_word);
    let year = match date_words[..] {
        [year] if year.len() == 4 => year.parse::<i32>().ok().filter(|y| *y >= 0),
        _ => None,
    };
    // A date that is no year alone.
    let date = match date_words[..] {
        [] => None,
        _ if year.is_some() => None,
        [month] if is_year_and_month(month) => Some(parse_date(&format!("{month}-01"), zone, now)?),
        _ => Some(parse_date(&date_words.join(" "), zone, now)?),
    };
    // Whether the text contains the known word, or an abbreviation of at least `min_bytes` bytes.
    let has_word = |known_word: &str, min_bytes: usize| words.iter().any(|w| is_abbreviation(known_word, min_bytes, w));
    let [mentions_eclipses, mentions_transits] = ["eclipses", "transits"].map(|known_word| has_word(known_word, 4));
    let mentions_moons = words.contains(&"moons") || has_word("jupiter", 3) && (mentions_eclipses || mentions_transits);
    let kinds = match () {
        // The moons of a planet have eclipses and transits, too, so this case comes before eclipses of the Sun and the Moon and transits of planets.
        () if mentions_moons || has_word("shadows", 4) => vec![EventKind::Moons],
        () if mentions_eclipses && (has_word("solar", 3) || has_word("sun", 3)) => vec![EventKind::Solar],
        () if mentions_eclipses && (has_word("lunar", 3) || words.contains(&"moon")) => vec![EventKind::Lunar],
        () if mentions_eclipses => vec![EventKind::Solar, EventKind::Lunar],
        () if mentions_transits => vec![EventKind::Transit],
        () => return None,
    };
    if let Some(date) = date {
        let start = start_of_day(date, zone);
        return Some((events_from(&kinds, start, zone), kinds, Some(start)));
    }
    let start = year.and_then(|y| zone.instant(NaiveDate::from_ymd_opt(y, 1, 1)?.and_time(NaiveTime::MIN)));
    let of_year = year.map_or(String::new(), |y| text!("search-of-year", y = y));
    Some((format!("{}{of_year}", names_of_kinds(&kinds)), kinds, start))
}

/// Whether a word is a year and a month in the form `2026-08`.
fn is_year_and_month(word: &str) -> bool {
    let has_digits = |part: &str, count: usize| part.len() == count && part.bytes().all(|byte| byte.is_ascii_digit());
    word.split_once('-').is_some_and(|(year, month)| has_digits(year, 4) && has_digits(month, 2))
}

/// The start of the day of a time in `zone`; the time itself outside the calendar's range of years.
fn start_of_day(time: Instant, zone: ShownTimeZone) -> Instant {
    zone.civil_time(time).and_then(|civil| zone.instant(civil.date().and_time(NaiveTime::MIN))).unwrap_or(time)
}

fn names_of_kinds(kinds: &[EventKind]) -> String {
    kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(text!("search-and"))
}

/// The name of a search for events from a day on.
fn events_from(kinds: &[EventKind], start: Instant, zone: ShownTimeZone) -> String {
    text!("search-from-day", kinds = names_of_kinds(kinds), day = day_text(start, zone))
}
