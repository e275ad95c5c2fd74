//! Eclipses, transits and moons' events for the window: a search in short steps, and a view of each event.
//!
//! In: an instant, kinds of events, a direction in time. Out: the events of each step, nearest first; a view of an event, its contacts at a place, and
//! the span and rate of its playback. Always: a step takes well under a second, so that a search can be stopped and does not block other queries. Not
//! here: the geometry (`events`), the thread that searches, the list in the Events panel.

use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::topocentric::{HORIZON_REFRACTION_DEG, Observer, ObserverSky};
use crate::ephemeris::{Ephemeris, EphemerisError, angle_rad};
use crate::events::{self, GeodeticPosition, LunarEclipse, LunarType, MoonEvent, MoonEventType, SolarEclipse, SolarType, Transit};
use crate::time::Instant;
use crate::units::SECONDS_PER_DAY;
use crate::view::app::body_positions::BodyPositions;
use crate::view::app::place_text::place_text;
use crate::view::app::settings::Home;
use crate::view::app::view_state::{CameraPose, GROUND_CAMERA_HEIGHT_KM, ViewState};
use crate::view::language::dates::minute_text;
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

    /// Length of one step, days. A step contains about six eclipses of each kind, at most a few transits, or about a dozen moons' events.
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
pub struct ContactLine {
    pub name: &'static str,
    pub time: Instant,
    /// Altitude of the observed body; for moons' events, of the planet.
    pub altitude_deg: f64,
    /// Whether the body's upper limb, raised by refraction, is above the horizon; for moons' events, whether the planet's centre is.
    pub is_up: bool,
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
                let eclipses = events::lunar_eclipses_without_saros(catalog, ephemeris, from, to)?;
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

/// A search from an instant, forward or backward.
#[derive(Clone, Debug, PartialEq)]
pub struct EventSearch {
    kinds: Vec<EventKind>,
    start: Instant,
    /// Length of the entire span to search.
    span_s: f64,
    backward: bool,
    /// Length of the span searched so far, counted from `start` in the direction of the search.
    searched_s: f64,
}

impl EventSearch {
    pub fn new(kinds: Vec<EventKind>, start: Instant, span_s: f64, backward: bool) -> Self {
        Self { kinds, start, span_s, backward, searched_s: 0.0 }
    }

    /// Searched fraction, 0 to 1.
    pub fn progress(&self) -> f32 {
        (self.searched_s / self.span_s) as f32
    }

    pub fn is_over(&self) -> bool {
        self.kinds.is_empty() || self.searched_s >= self.span_s
    }

    /// Searches the next part of the span; returns its events, nearest first.
    ///
    /// # Errors
    /// If the ephemeris does not cover this part.
    pub fn step(&mut self, catalog: &Catalog, ephemeris: &Ephemeris) -> Result<Vec<SkyEvent>, EphemerisError> {
        let step_days = self.kinds.iter().map(|k| k.step_days()).fold(f64::INFINITY, f64::min);
        let until_s = (self.searched_s + step_days * SECONDS_PER_DAY).min(self.span_s);
        let [begin, end] = [self.searched_s, until_s].map(|s| self.start.plus_seconds(if self.backward { -s } else { s }));
        let (from, to) = if self.backward { (end, begin) } else { (begin, end) };
        let mut found = events_between(catalog, ephemeris, &self.kinds, from, to)?;
        if self.backward {
            found.reverse();
        }
        self.searched_s = until_s;
        Ok(found)
    }

    /// Searches until the first event.
    ///
    /// # Errors
    /// If the ephemeris does not cover a part that was searched.
    pub(crate) fn first(mut self, catalog: &Catalog, ephemeris: &Ephemeris) -> Result<Option<SkyEvent>, EphemerisError> {
        while !self.is_over() {
            if let Some(event) = self.step(catalog, ephemeris)?.into_iter().next() {
                return Ok(Some(event));
            }
        }
        Ok(None)
    }
}

/// Vertical field of view around an eclipsed Sun: it includes the corona.
const ECLIPSED_SUN_FOV_DEG: f64 = 3.0;
/// Vertical fields of view around the Sun during a transit and around an eclipsed Moon; both discs are half a degree wide.
const SUN_FOV_DEG: f64 = 0.8;
const LUNAR_ECLIPSE_FOV_DEG: f64 = 0.8;
/// Field of view from a place on the Earth around an eclipsed Moon: about three times its diameter.
const LUNAR_ECLIPSE_FROM_PLACE_FOV_DEG: f64 = 2.0 * LUNAR_ECLIPSE_FOV_DEG;
/// Field of view from a place on the Earth for moons' events: about twice Jupiter's largest apparent diameter.
const PLANET_FROM_PLACE_FOV_DEG: f64 = 0.03;
/// Field of view from a place on the Earth for an eclipse of a moon: Callisto enters the shadow up to 0.03 degrees from the middle of Jupiter.
const ECLIPSED_MOON_FROM_PLACE_FOV_DEG: f64 = 0.08;
/// Field of view from a place on the Earth for mutual events of moons: about twelve times Io's apparent diameter.
const MUTUAL_FROM_PLACE_FOV_DEG: f64 = 0.004;
/// Field of view for an eclipse of a moon, as a multiple of the moon's angular distance from the planet, which is in the middle of the image.
const ECLIPSED_MOON_FOV_DISTANCES: f64 = 2.4;
/// Field of view from the Earth's centre for moons' events, in apparent diameters of the planet.
const PLANET_FOV_DIAMETERS: f64 = 2.2;
/// Field of view for mutual events of moons, in apparent diameters of the moon.
const MUTUAL_FOV_DIAMETERS: f64 = 12.0;
/// Height of the camera if the observed body is near the horizon, km: the dip of the horizon is then 1.8 degrees.
const LOW_BODY_CAMERA_HEIGHT_KM: f64 = 3.0;
/// Altitude below which the observed body is near the horizon, degrees.
const LOW_BODY_ALTITUDE_DEG: f64 = 2.0;
/// Real seconds in which the button *Watch it* plays an event that is longer than this.
const PLAYBACK_S: f64 = 30.0;
/// Two searches may give slightly different times for one event; events of the same kind and bodies that are closer in time than this are one event.
const SAME_EVENT_S: f64 = 60.0;
/// Fraction of an event's length that is shown before its first contact and after its last contact.
const LEAD_FRACTION: f64 = 0.05;

impl SkyEvent {
    pub(crate) fn kind(&self) -> EventKind {
        match self {
            Self::Solar(_) => EventKind::Solar,
            Self::Lunar(_) => EventKind::Lunar,
            Self::Transit(_) => EventKind::Transit,
            Self::Moons(_) => EventKind::Moons,
        }
    }

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
        let bodies = |event: &Self| if let Self::Moons(e) = event { Some((e.class, e.moon, e.planet, e.by_moon)) } else { None };
        let apart_s = (tdb_s(self.greatest()) - tdb_s(other.greatest())).abs();
        self.kind() == other.kind() && bodies(self) == bodies(other) && apart_s < SAME_EVENT_S
    }

    /// Contacts that do not depend on a place on the Earth, ordered by time. Of a solar eclipse: when the shadow meets and leaves the Earth.
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
                let by = e.by_moon.map_or("?", name);
                match e.class {
                    MoonEventType::Transit => text!("event-moon-before", moon = moon, planet = planet),
                    MoonEventType::Occultation => text!("event-moon-behind", moon = moon, planet = planet),
                    MoonEventType::ShadowTransit => text!("event-shadow-on", moon = moon, planet = planet),
                    MoonEventType::Eclipse => text!("event-moon-in-shadow", moon = moon, planet = planet),
                    MoonEventType::MutualOccultation => text!("event-occultation", moon = moon, by = by),
                    MoonEventType::MutualEclipse => text!("event-mutual-eclipse", moon = moon, by = by),
                }
            }
        }
    }

    /// One line: the date, and of an eclipse its magnitude and place, of a transit the separation of the centres, of a moons' event its duration if known.
    pub fn summary(&self) -> String {
        let date = minute_text(self.greatest());
        match self {
            Self::Solar(e) => text!("event-solar-summary", date = date, magnitude = decimal(e.magnitude, 3), place = place_text(e.place)),
            Self::Lunar(e) => {
                let (name, magnitude) = match e.class {
                    LunarType::Penumbral => (text!("event-penumbral-magnitude"), e.penumbral_magnitude),
                    _ => (text!("event-magnitude"), e.umbral_magnitude),
                };
                text!("event-lunar-summary", date = date, name = name, magnitude = decimal(magnitude, 3), place = place_text(e.place))
            }
            Self::Transit(e) => text!("event-transit-summary", date = date, separation = decimal(e.separation_arcsec, 0)),
            Self::Moons(e) => match e.duration_s() {
                Some(s) => text!("event-moons-summary", date = date, minutes = decimal(s / 60.0, 0)),
                None => date,
            },
        }
    }

    /// Whether the event is notable: a total, annular or hybrid solar eclipse, a total lunar eclipse, a transit, or a shadow on a planet.
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
        (contacts.first().map_or(self.greatest(), |c| c.1), contacts.last().map_or(self.greatest(), |c| c.1))
    }

    /// The view that shows the event best, paused at its greatest phase: of a solar eclipse, from the place of greatest eclipse; of other events, from the
    /// Earth's centre. Other settings come from `base_view`.
    pub fn view(&self, catalog: &Catalog, positions: &dyn BodyPositions, base_view: &ViewState) -> ViewState {
        let from_earth = |target: NaifId, fov_deg: f64| (target, CameraPose::Centre { body: NaifId::EARTH }, fov_deg);
        // A multiple of a body's apparent diameter at the Earth's centre.
        let diameters_deg = |id: NaifId, count: f64| {
            // The defaults are not reached: the event was found with this catalog and these positions.
            let radius_km = catalog.body(id).map_or(1.0, |b| b.radii_km.x);
            let distance_km = positions.geometric_between_km(NaifId::EARTH, id, self.greatest()).map_or(1e9, |d| d.length());
            count * (2.0 * radius_km / distance_km).to_degrees()
        };
        // The separation of two bodies seen from the Earth's centre.
        let apart_deg = |a: NaifId, b: NaifId| {
            let [a, b] = [a, b].map(|id| positions.geometric_between_km(NaifId::EARTH, id, self.greatest()));
            a.zip(b).map_or(0.0, |(a, b)| angle_rad(a, b).to_degrees())
        };
        let (target, eye, fov_deg) = match self {
            Self::Solar(e) => return self.view_from(e.place, e.sun_altitude_deg, base_view),
            Self::Lunar(_) => from_earth(NaifId::MOON, LUNAR_ECLIPSE_FOV_DEG),
            Self::Transit(_) => from_earth(NaifId::SUN, SUN_FOV_DEG),
            // A mutual event, in which one moon occults or eclipses another.
            Self::Moons(e) if e.by_moon.is_some() => from_earth(e.moon, diameters_deg(e.moon, MUTUAL_FOV_DIAMETERS)),
            Self::Moons(e) => {
                // An eclipsed moon is in the shadow behind the planet, which at quadrature is far from the planet's disc.
                let moon_deg = if e.class == MoonEventType::Eclipse { apart_deg(e.planet, e.moon) } else { 0.0 };
                let fov_deg = diameters_deg(e.planet, PLANET_FOV_DIAMETERS).max(ECLIPSED_MOON_FOV_DISTANCES * moon_deg);
                from_earth(e.planet, fov_deg)
            }
        };
        base_view.paused_view(self.greatest(), target, eye, fov_deg)
    }

    /// The view of the event from a place on the Earth, where the observed body is at the given altitude.
    pub(crate) fn view_from(&self, place: GeodeticPosition, altitude_deg: f64, base_view: &ViewState) -> ViewState {
        let (target, fov_deg) = match self {
            Self::Solar(_) => (NaifId::SUN, ECLIPSED_SUN_FOV_DEG),
            Self::Lunar(_) => (NaifId::MOON, LUNAR_ECLIPSE_FROM_PLACE_FOV_DEG),
            Self::Transit(_) => (NaifId::SUN, SUN_FOV_DEG),
            Self::Moons(e) if e.by_moon.is_some() => (e.moon, MUTUAL_FROM_PLACE_FOV_DEG),
            Self::Moons(e) if e.class == MoonEventType::Eclipse => (e.planet, ECLIPSED_MOON_FROM_PLACE_FOV_DEG),
            Self::Moons(e) => (e.planet, PLANET_FROM_PLACE_FOV_DEG),
        };
        let camera_height_km = if altitude_deg < LOW_BODY_ALTITUDE_DEG { LOW_BODY_CAMERA_HEIGHT_KM } else { GROUND_CAMERA_HEIGHT_KM };
        let eye = CameraPose::Ground {
            body: NaifId::EARTH,
            latitude_deg: place.latitude_deg,
            longitude_deg: place.longitude_deg,
            height_km: place.height_km.max(0.0) + camera_height_km,
            azimuth_deg: 0.0,
            altitude_deg: 0.0,
        };
        base_view.paused_view(self.greatest(), target, eye, fov_deg)
    }

    /// Playback from shortly before the first contact to shortly after the last contact, in half a minute, or in real time if the event is shorter
    /// than that.
    pub(crate) fn playback(&self) -> EventPlayback {
        let (first, last) = self.local_span();
        EventPlayback::of_span(first, last)
    }

    /// Playback at a place with these contacts, ordered by time. If the observed body rises or sets during the event, playback begins with the last
    /// contact before the rise, or ends with the first contact after the set.
    pub(crate) fn playback_at(&self, lines: &[ContactLine]) -> EventPlayback {
        let first_up = lines.iter().position(|line| line.is_up).unwrap_or(0);
        let last_up = lines.iter().rposition(|line| line.is_up).unwrap_or(lines.len());
        match (lines.get(first_up.saturating_sub(1)), lines.get(last_up + 1).or(lines.last())) {
            (Some(first), Some(last)) => EventPlayback::of_span(first.time, last.time),
            _ => self.playback(),
        }
    }

    /// First and last contact as seen in [`SkyEvent::view`]. For a solar eclipse these are the contacts at the place of greatest eclipse: an eclipse is
    /// shorter at one place than for the entire Earth.
    fn local_span(&self) -> (Instant, Instant) {
        let seen = if let Self::Solar(e) = self { e.seen_from(e.place) } else { None };
        match seen.as_ref().and_then(|s| Some((s.contacts.first()?.time, s.contacts.last()?.time))) {
            Some(span) => span,
            None => self.span(),
        }
    }

    /// Contacts and greatest phase (of moons' events only contacts) as seen from a place, ordered by time, and whether any part of the event is above the
    /// horizon there. Empty if the event does not occur at that place.
    ///
    /// # Errors
    /// If the ephemeris does not cover the event.
    pub fn seen_from(&self, catalog: &Catalog, ephemeris: &Ephemeris, home: Home) -> Result<(Vec<ContactLine>, bool), EphemerisError> {
        let place = GeodeticPosition { latitude_deg: home.latitude_deg, longitude_deg: home.longitude_deg, height_km: 0.0 };
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
                let sky = ObserverSky { catalog, ephemeris, place: observer };
                let line = |(name, time): &(&'static str, Instant)| -> Result<ContactLine, EphemerisError> {
                    let altitude_deg = sky.topocentric(e.planet, *time)?.altitude_deg;
                    Ok(ContactLine { name, time: *time, altitude_deg, is_up: altitude_deg > -HORIZON_REFRACTION_DEG })
                };
                let lines = e.contacts.iter().map(line).collect::<Result<Vec<_>, _>>()?;
                let is_visible = lines.iter().any(|l| l.is_up);
                return Ok((lines, is_visible));
            }
        };
        let Some(seen) = seen else { return Ok((Vec::new(), false)) };
        let line = |c: &events::LocalContact| ContactLine { name: c.name, time: c.time, altitude_deg: c.altitude_deg, is_up: c.is_up() };
        let mut lines: Vec<ContactLine> = seen.contacts.iter().map(line).collect();
        lines.push(line(&seen.maximum));
        lines.sort_by(|a, b| tdb_s(a.time).total_cmp(&tdb_s(b.time)));
        Ok((lines, seen.visible))
    }
}

/// Span (TDB seconds past J2000) and rate of time for playing an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EventPlayback {
    pub from_tdb_s: f64,
    pub to_tdb_s: f64,
    /// Scene seconds per real second.
    pub rate: f64,
}

impl EventPlayback {
    fn of_span(first: Instant, last: Instant) -> Self {
        let length_s = (tdb_s(last) - tdb_s(first)).max(1.0);
        Self {
            from_tdb_s: tdb_s(first) - LEAD_FRACTION * length_s,
            to_tdb_s: tdb_s(last) + LEAD_FRACTION * length_s,
            rate: ((1.0 + 2.0 * LEAD_FRACTION) * length_s / PLAYBACK_S).max(1.0),
        }
    }

    /// Whether a time is within the playback, or before or after it by at most its length. This includes the times at which other places see the event.
    pub(crate) fn is_near(&self, tdb_s: f64) -> bool {
        let length_s = self.to_tdb_s - self.from_tdb_s;
        (self.from_tdb_s - length_s..=self.to_tdb_s + length_s).contains(&tdb_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_time_is_near_an_event_up_to_its_length_before_and_after() {
        let playback = EventPlayback { from_tdb_s: 1000.0, to_tdb_s: 1100.0, rate: 1.0 };
        for (tdb_s, is_near) in [(899.0, false), (901.0, true), (1050.0, true), (1199.0, true), (1201.0, false)] {
            assert_eq!(playback.is_near(tdb_s), is_near, "{tdb_s}");
        }
    }

    /// From a place, a mutual event is seen at the moon, and the field around Jupiter contains a moon in Jupiter's shadow.
    #[test]
    fn a_moons_event_is_in_the_view_from_a_place() {
        let (jupiter, io, callisto) = (NaifId(599), NaifId(501), NaifId(504));
        let greatest = Instant::from_tdb_seconds_past_j2000(0.0);
        let base_view = ViewState::around(NaifId::EARTH, DVec3::X * 1e5, 6378.0, DVec3::Z, greatest);
        let view = |class, moon, by| {
            let event = SkyEvent::Moons(MoonEvent { class, moon, planet: jupiter, by_moon: by, greatest, contacts: Vec::new() });
            event.view_from(GeodeticPosition { latitude_deg: 50.0, longitude_deg: 10.0, height_km: 0.0 }, 45.0, &base_view)
        };
        let mutual = view(MoonEventType::MutualOccultation, io, Some(NaifId(502)));
        assert!(mutual.target == io && mutual.fov_deg < 0.01, "{mutual:?}");
        let transit = view(MoonEventType::Transit, io, None);
        // Jupiter's largest apparent diameter is 50 arcsec.
        assert!(transit.target == jupiter && transit.fov_deg > 1.2 * 50.0 / 3600.0, "{transit:?}");
        // At quadrature the Sun, Jupiter and the Earth form an angle of 11.5 degrees, and Jupiter is 5.1 au away: Callisto, 1.88 million km behind Jupiter,
        // appears at this angle.
        let apart_deg = (1.883e6 * 11.5_f64.to_radians().sin() / (5.1 * 1.496e8)).to_degrees();
        let eclipse = view(MoonEventType::Eclipse, callisto, None);
        assert!(eclipse.target == jupiter && eclipse.fov_deg > 2.0 * apart_deg, "{eclipse:?}, {apart_deg}");
    }
}
