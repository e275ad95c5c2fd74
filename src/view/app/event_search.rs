//! Eclipses, transits and moons' events for the window: a search in short steps, the texts of an event, and its contacts at a place.
//!
//! In: an instant, kinds of events, a direction in time. Out: the events of each step, nearest first; title, summary and contacts of an event. Always: a
//! step takes well under a second, so that a search can be stopped and does not block other queries. If a step reaches beyond the ephemeris, shorter ones
//! approach its end, so that the events before the end are found. Eclipses of the Moon are those of almanacs, with a shadow enlarged by the air, whatever
//! `--radii` says: with the geometric shadow, total eclipses would be called partial. Not here: the geometry (`events`), the view and playback of an event
//! (`event_view`), the thread that searches, the list in the Events panel.

use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::topocentric::{HORIZON_REFRACTION_DEG, Observer, ObserverSky};
use crate::ephemeris::{Ephemeris, EphemerisError};
use crate::events::{self, GeodeticPosition, LunarEclipse, LunarType, MoonEvent, MoonEventType, SolarEclipse, SolarType, Transit};
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use crate::view::app::civil_time::ShownTimeZone;
use crate::view::app::place_text::place_text;
use crate::view::app::settings::Home;
use crate::view::language::dates::{minute_text, minute_text_without_zone};
use crate::view::language::{body_name, decimal, text};

/// A kind of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EventKind {
    /// Eclipses of the Sun.
    Solar,
    /// Eclipses of the Moon.
    Lunar,
    /// Mercury or Venus in front of the Sun.
    Transit,
    /// Transits, shadow transits, occultations and eclipses of the Galilean moons and Titan; mutual events of the Galilean moons.
    Moons,
}

impl EventKind {
    pub const ALL: [Self; 4] = [Self::Solar, Self::Lunar, Self::Transit, Self::Moons];

    pub fn name(self) -> &'static str {
        match self {
            Self::Solar => text!("kind-solar"),
            Self::Lunar => text!("kind-lunar"),
            Self::Transit => text!("kind-transit"),
            Self::Moons => text!("kind-moons"),
        }
    }

    /// Length of one step of a search, days. A step contains about six eclipses of each kind, at most a few transits, or about a dozen moons' events.
    fn step_days(self) -> f64 {
        match self {
            Self::Solar | Self::Lunar => 1000.0,
            Self::Transit => 2000.0,
            Self::Moons => 3.0,
        }
    }
}

/// One event with its geometry.
#[derive(Clone, Debug)]
pub enum SkyEvent {
    Solar(Box<SolarEclipse>),
    Lunar(Box<LunarEclipse>),
    Transit(Box<Transit>),
    Moons(MoonEvent),
}

/// A contact or the greatest phase at a place, as a line of the Events panel.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactAtPlace {
    pub name: &'static str,
    pub time: Instant,
    /// Altitude of the observed body; for moons' events, of the planet.
    pub altitude_deg: f64,
    /// Whether the body's upper limb, raised by refraction, is above the horizon; for moons' events, whether the planet's centre, raised by refraction, is.
    pub is_up: bool,
}

/// An event as seen from a place on the Earth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EventFromPlace {
    /// Contacts and `maximum`, the greatest phase above the horizon, ordered by time; none if the event does not occur at the place. If the whole event is
    /// below the horizon, the maximum ignores the horizon.
    pub contacts: Vec<ContactAtPlace>,
    /// Whether any part of the event is above the horizon.
    pub is_visible: bool,
    /// First rising of the observed body between first and last contact, if it rises then.
    pub rise: Option<Instant>,
    /// First setting of the observed body between first and last contact, if it sets then.
    pub set: Option<Instant>,
}

/// Events of the given kinds whose greatest phase is in `from..to`, ordered by time.
///
/// # Errors
/// If the ephemeris does not cover the span.
pub fn events_between(
    catalog: &Catalog,
    ephemeris: &Ephemeris,
    kinds: &[EventKind],
    from: Instant,
    to: Instant,
) -> Result<Vec<SkyEvent>, EphemerisError> {
    let mut found: Vec<SkyEvent> = Vec::new();
    for kind in kinds {
        match kind {
            EventKind::Solar => {
                let eclipses = events::solar_eclipses_without_saros(catalog, ephemeris, from, to)?;
                found.extend(eclipses.into_iter().map(|e| SkyEvent::Solar(Box::new(e))));
            }
            EventKind::Lunar => {
                let eclipses = events::lunar_eclipses_by_almanacs(catalog, ephemeris, from, to)?;
                found.extend(eclipses.into_iter().map(|e| SkyEvent::Lunar(Box::new(e))));
            }
            EventKind::Transit => {
                found.extend(events::transits(catalog, ephemeris, from, to)?.into_iter().map(|e| SkyEvent::Transit(Box::new(e))));
            }
            EventKind::Moons => {
                found.extend(events::moon_events(catalog, ephemeris, from, to)?.into_iter().map(SkyEvent::Moons));
                found.extend(events::mutual_events(catalog, ephemeris, from, to)?.into_iter().map(SkyEvent::Moons));
            }
        }
    }
    found.sort_by(|a, b| tdb_s(a.greatest()).total_cmp(&tdb_s(b.greatest())));
    Ok(found)
}

fn tdb_s(t: Instant) -> f64 {
    t.tdb_seconds_past_j2000()
}

/// Shortest step of a search, seconds. Where the ephemeris ends, less than two such steps therefore remain unsearched, besides the margin that the
/// computation of the events needs.
pub(super) const MIN_STEP_S: f64 = SECONDS_PER_DAY;

/// A search from an instant, forward or backward.
#[derive(Clone, Debug, PartialEq)]
pub struct EventSearch {
    kinds: Vec<EventKind>,
    start: Instant,
    /// Length of the entire span to search.
    span_s: f64,
    /// Whether the search goes back in time from `start`.
    is_backward: bool,
    /// Length of the span searched so far, counted from `start` in the direction of the search.
    searched_s: f64,
    /// Length of the next step, unless the span ends before. Below [`MIN_STEP_S`], the search is over.
    step_s: f64,
    /// Why the last failed step failed: a part of it is outside the ephemeris. From then on, `step_s` is halved after each step. `None`: no step has failed.
    failure: Option<EphemerisError>,
}

impl EventSearch {
    /// A search of `span_s` seconds from `start`, back in time if `is_backward`.
    pub fn new(kinds: Vec<EventKind>, start: Instant, span_s: f64, is_backward: bool) -> Self {
        let step_days = kinds.iter().map(|k| k.step_days()).fold(f64::INFINITY, f64::min);
        Self { kinds, start, span_s, is_backward, searched_s: 0.0, step_s: step_days * SECONDS_PER_DAY, failure: None }
    }

    /// The same search in steps of another length, at least a day.
    pub(super) fn in_steps_of(self, step_s: f64) -> Self {
        Self { step_s, ..self }
    }

    /// Searched fraction, 0 to 1.
    pub fn progress(&self) -> f32 {
        (self.searched_s / self.span_s) as f32
    }

    /// Whether nothing is left to search: the end of the span or of the ephemeris is reached.
    pub fn is_over(&self) -> bool {
        self.kinds.is_empty() || self.searched_s >= self.span_s || self.step_s < MIN_STEP_S
    }

    /// Why the search is over before the end of its span: the ephemeris ends. Otherwise `None`.
    pub fn failure(&self) -> Option<&EphemerisError> {
        self.failure.as_ref().filter(|_| self.step_s < MIN_STEP_S)
    }

    /// The instant up to which the span has been searched, in the direction of the search.
    pub(super) fn searched_until(&self) -> Instant {
        self.at(self.searched_s)
    }

    /// The instant up to which the next step searches.
    pub(super) fn end_of_step(&self) -> Instant {
        self.at(self.end_of_step_s())
    }

    /// The instant at a distance from the start, seconds in the direction of the search.
    fn at(&self, distance_s: f64) -> Instant {
        self.start.plus_seconds(if self.is_backward { -distance_s } else { distance_s })
    }

    /// Length of the span that will have been searched after the next step.
    fn end_of_step_s(&self) -> f64 {
        (self.searched_s + self.step_s).min(self.span_s)
    }

    /// Searches the next part of the span; returns its events, nearest first. A step that reaches beyond the ephemeris finds nothing, and the next one is
    /// shorter.
    pub fn step(&mut self, catalog: &Catalog, ephemeris: &Ephemeris) -> Vec<SkyEvent> {
        let (near_end, far_end) = (self.searched_until(), self.end_of_step());
        let (from, to) = if self.is_backward { (far_end, near_end) } else { (near_end, far_end) };
        let found = events_between(catalog, ephemeris, &self.kinds, from, to);
        self.finish_step(found.as_ref().err().cloned());
        let mut found = found.unwrap_or_default();
        if self.is_backward {
            found.reverse();
        }
        found
    }

    /// Advances the search by a step, or shortens its steps. `failure`: why the step failed, if it did.
    pub(super) fn finish_step(&mut self, failure: Option<EphemerisError>) {
        let end_s = self.end_of_step_s();
        let length_s = end_s - self.searched_s;
        if failure.is_none() {
            self.searched_s = end_s;
        }
        self.failure = failure.or(self.failure.take());
        // Bisection: the ephemeris ends within the length of a step that failed. After each further step, whether it failed or not, the end of the ephemeris
        // is no farther away than the length of that step.
        if self.failure.is_some() {
            self.step_s = 0.5 * length_s;
        }
    }

    /// Searches until the first event; `None` if the span contains none.
    ///
    /// # Errors
    /// If there is no event before the ephemeris ends, and it ends within the span.
    pub(crate) fn find_first(mut self, catalog: &Catalog, ephemeris: &Ephemeris) -> Result<Option<SkyEvent>, EphemerisError> {
        while !self.is_over() {
            if let Some(event) = self.step(catalog, ephemeris).into_iter().next() {
                return Ok(Some(event));
            }
        }
        self.failure().cloned().map_or(Ok(None), Err)
    }
}

/// Two searches may give slightly different times for one event; events of the same kind and bodies that are closer in time than this are one event.
const SAME_EVENT_S: f64 = 60.0;

impl SkyEvent {
    pub(crate) fn kind(&self) -> EventKind {
        match self {
            Self::Solar(_) => EventKind::Solar,
            Self::Lunar(_) => EventKind::Lunar,
            Self::Transit(_) => EventKind::Transit,
            Self::Moons(_) => EventKind::Moons,
        }
    }

    /// Time of the greatest phase.
    pub fn greatest(&self) -> Instant {
        match self {
            Self::Solar(e) => e.greatest,
            Self::Lunar(e) => e.greatest,
            Self::Transit(e) => e.greatest,
            Self::Moons(e) => e.greatest,
        }
    }

    /// Whether two results, possibly of different searches, are the same event.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let bodies = |event: &Self| if let Self::Moons(e) = event { Some((e.class, e.moon, e.planet, e.nearer_moon)) } else { None };
        let difference_s = (tdb_s(self.greatest()) - tdb_s(other.greatest())).abs();
        self.kind() == other.kind() && bodies(self) == bodies(other) && difference_s < SAME_EVENT_S
    }

    /// Names and times of the contacts that do not depend on a place on the Earth, ordered by time. Contacts of a solar eclipse: when the shadow meets and
    /// leaves the Earth.
    pub(crate) fn contacts(&self) -> &[(&'static str, Instant)] {
        match self {
            Self::Solar(e) => &e.contacts,
            Self::Lunar(e) => &e.contacts,
            Self::Transit(e) => &e.contacts,
            Self::Moons(e) => &e.contacts,
        }
    }

    /// Type and bodies of the event, such as `Total solar eclipse`.
    pub fn title(&self, catalog: &Catalog) -> String {
        let name = |id: NaifId| catalog.body(id).map_or("?", |b| body_name(&b.name));
        match self {
            Self::Solar(e) => match e.class {
                SolarType::Partial => text!("event-solar-partial"),
                SolarType::Annular => text!("event-solar-annular"),
                SolarType::Total => text!("event-solar-total"),
                SolarType::Hybrid => text!("event-solar-hybrid"),
            }
            .into(),
            Self::Lunar(e) => match e.class {
                LunarType::Penumbral => text!("event-lunar-penumbral"),
                LunarType::Partial => text!("event-lunar-partial"),
                LunarType::Total => text!("event-lunar-total"),
            }
            .into(),
            Self::Transit(e) => text!("event-transit", planet = name(e.planet)),
            Self::Moons(e) => {
                let (moon, planet) = (name(e.moon), name(e.planet));
                let nearer_moon_name = e.nearer_moon.map_or("?", name);
                match e.class {
                    MoonEventType::Transit => text!("event-moon-before", moon = moon, planet = planet),
                    MoonEventType::Occultation => text!("event-moon-behind", moon = moon, planet = planet),
                    MoonEventType::ShadowTransit => text!("event-shadow-on", moon = moon, planet = planet),
                    MoonEventType::Eclipse => text!("event-moon-in-shadow", moon = moon, planet = planet),
                    MoonEventType::MutualOccultation => text!("event-occultation", moon = moon, by = nearer_moon_name),
                    MoonEventType::MutualEclipse => text!("event-mutual-eclipse", moon = moon, by = nearer_moon_name),
                }
            }
        }
    }

    /// One line: the date; then the magnitude and place of an eclipse, the least separation of the centres in a transit, or, if known, the duration of a
    /// moons' event.
    pub fn summary(&self, zone: ShownTimeZone) -> String {
        self.summary_with_date(minute_text(self.greatest(), zone))
    }

    /// As [`Self::summary`], without the label of the zone.
    pub(crate) fn summary_without_zone(&self, zone: ShownTimeZone) -> String {
        self.summary_with_date(minute_text_without_zone(self.greatest(), zone))
    }

    fn summary_with_date(&self, date: String) -> String {
        match self {
            Self::Solar(e) => text!("event-solar-summary", date = date, magnitude = decimal(e.magnitude, 3), place = place_text(e.place)),
            Self::Lunar(e) => {
                let (label, magnitude) = match e.class {
                    LunarType::Penumbral => (text!("event-penumbral-magnitude"), e.penumbral_magnitude),
                    _ => (text!("event-magnitude"), e.umbral_magnitude),
                };
                text!("event-lunar-summary", date = date, name = label, magnitude = decimal(magnitude, 3), place = place_text(e.place))
            }
            Self::Transit(e) => text!("event-transit-summary", date = date, separation = decimal(e.separation_arcsec, 0)),
            Self::Moons(e) => match e.duration_s() {
                Some(s) => text!("event-moons-summary", date = date, minutes = decimal(s / 60.0, 0)),
                None => date,
            },
        }
    }

    /// Whether the event is notable: a total, annular or hybrid solar eclipse, a total lunar eclipse, a transit, or a moon's shadow on its planet.
    pub(crate) fn is_notable(&self) -> bool {
        match self {
            Self::Solar(e) => e.class != SolarType::Partial,
            Self::Lunar(e) => e.class == LunarType::Total,
            Self::Transit(_) => true,
            Self::Moons(e) => e.class == MoonEventType::ShadowTransit,
        }
    }

    /// Times of the first and the last contact; both are the time of the greatest phase if there are no contacts.
    pub(crate) fn span(&self) -> (Instant, Instant) {
        let contacts = self.contacts();
        let time_of = |contact: Option<&(&str, Instant)>| contact.map_or(self.greatest(), |(_, time)| *time);
        (time_of(contacts.first()), time_of(contacts.last()))
    }

    /// The event as seen from a place.
    ///
    /// # Errors
    /// If the ephemeris does not cover the event.
    pub fn seen_from(&self, catalog: &Catalog, ephemeris: &Ephemeris, observer_place: Home) -> Result<EventFromPlace, EphemerisError> {
        let place =
            GeodeticPosition { latitude_deg: observer_place.latitude_deg, longitude_deg: observer_place.longitude_deg, height_km: 0.0 };
        let seen = match self {
            Self::Solar(e) => e.seen_from(place),
            Self::Lunar(e) => Some(e.seen_from(place)),
            Self::Transit(e) => e.seen_from(place),
            Self::Moons(e) => {
                let observer = Observer {
                    body: NaifId::EARTH,
                    lat_graphic_deg: place.latitude_deg,
                    lon_east_deg: place.longitude_deg,
                    height_km: 0.0,
                };
                return moons_event_seen_from(e, self.span(), &ObserverSky { catalog, ephemeris, place: observer });
            }
        };
        let Some(seen) = seen else { return Ok(EventFromPlace::default()) };
        let contact =
            |c: &events::LocalContact| ContactAtPlace { name: c.name, time: c.time, altitude_deg: c.altitude_deg, is_up: c.is_up() };
        let mut contacts: Vec<ContactAtPlace> = seen.contacts.iter().map(contact).collect();
        contacts.push(contact(&seen.maximum));
        contacts.sort_by(|a, b| tdb_s(a.time).total_cmp(&tdb_s(b.time)));
        Ok(EventFromPlace { contacts, is_visible: seen.is_visible, rise: seen.rise, set: seen.set })
    }
}

/// A moons' event in the sky of a place. `first` and `last`: the times of its first and last contact.
fn moons_event_seen_from(
    event: &MoonEvent,
    (first, last): (Instant, Instant),
    sky: &ObserverSky<'_>,
) -> Result<EventFromPlace, EphemerisError> {
    let found = sky.rise_set_times(event.planet, first, tdb_s(last) - tdb_s(first))?;
    // When the planet is above the horizon. An event takes hours, so that the planet rises and sets at most once.
    let up_spans = match (found.is_up_at_start, found.rise, found.set) {
        (true, Some(rise), Some(set)) => vec![(first, set), (rise, last)],
        (true, None, Some(set)) => vec![(first, set)],
        (true, _, None) => vec![(first, last)],
        (false, Some(rise), set) => vec![(rise, set.unwrap_or(last))],
        (false, None, _) => Vec::new(),
    };
    // The time nearest to the greatest phase at which the planet is up. As in eclipses, it may be that of rising or setting.
    let nearest_within = |(from, to): (Instant, Instant)| match event.greatest {
        greatest if greatest < from => from,
        greatest if greatest > to => to,
        greatest => greatest,
    };
    let distance_s = |time: &Instant| (tdb_s(*time) - tdb_s(event.greatest)).abs();
    let visible_maximum = up_spans.into_iter().map(nearest_within).min_by(|a, b| distance_s(a).total_cmp(&distance_s(b)));
    let contact = |(name, time): &(&'static str, Instant)| -> Result<ContactAtPlace, EphemerisError> {
        let altitude_deg = sky.topocentric(event.planet, *time)?.altitude_deg;
        Ok(ContactAtPlace { name, time: *time, altitude_deg, is_up: altitude_deg > -HORIZON_REFRACTION_DEG })
    };
    let mut contacts = event.contacts.iter().map(contact).collect::<Result<Vec<_>, _>>()?;
    let is_visible = visible_maximum.is_some();
    let maximum = contact(&("maximum", visible_maximum.unwrap_or(event.greatest)))?;
    // At rising and setting, rounding errors would decide whether the planet is up.
    contacts.push(ContactAtPlace { is_up: is_visible, ..maximum });
    contacts.sort_by(|a, b| tdb_s(a.time).total_cmp(&tdb_s(b.time)));
    Ok(EventFromPlace { contacts, is_visible, rise: found.rise, set: found.set })
}
