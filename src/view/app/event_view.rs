//! How the window shows an event: the view from the Earth's centre or from a place on the Earth, and the span and rate of its playback.
//!
//! In: an event, positions of bodies or a place, the base view. Out: a [`ViewState`], or an `EventPlayback`. Always: a view is paused at the greatest phase
//! of the event and tracks the observed body. Not here: the search for events, and their contacts at a place (`event_search`).

use super::body_positions::BodyPositions;
use super::event_search::{EventFromPlace, SkyEvent};
use super::view_state::{CameraPose, GROUND_CAMERA_HEIGHT_KM, ViewState};
use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::angle_rad;
use crate::events::{GeodeticPosition, MoonEventType};
use crate::time::Instant;

/// Vertical field of view around an eclipsed Sun: it includes the corona.
const ECLIPSED_SUN_FOV_DEG: f64 = 3.0;
/// Vertical field of view around the Sun, which is half a degree wide, during a transit.
const TRANSIT_FOV_DEG: f64 = 0.8;
/// Vertical field of view from the Earth's centre around an eclipsed Moon, which is half a degree wide.
const LUNAR_ECLIPSE_FOV_DEG: f64 = 0.8;
/// Field of view from a place on the Earth around an eclipsed Moon: about three times the Moon's diameter.
const LUNAR_ECLIPSE_FROM_PLACE_FOV_DEG: f64 = 2.0 * LUNAR_ECLIPSE_FOV_DEG;
/// Field of view from a place on the Earth for moons' events: about twice Jupiter's largest apparent diameter.
const PLANET_FROM_PLACE_FOV_DEG: f64 = 0.03;
/// Field of view from a place on the Earth for an eclipse of a moon: Callisto enters the shadow up to 0.03 degrees from the middle of Jupiter.
const ECLIPSED_MOON_FROM_PLACE_FOV_DEG: f64 = 0.08;
/// Field of view from a place on the Earth for mutual events of moons: about twelve times Io's apparent diameter.
const MUTUAL_FROM_PLACE_FOV_DEG: f64 = 0.004;
/// Field of view for an eclipse of a moon, as a multiple of the moon's angular distance from the planet, which is in the middle of the image.
const ECLIPSED_MOON_FOV_SEPARATIONS: f64 = 2.4;
/// Field of view from the Earth's centre for moons' events, in apparent diameters of the planet.
const PLANET_FOV_DIAMETERS: f64 = 2.2;
/// Field of view from the Earth's centre for mutual events of moons, in apparent diameters of the moon.
const MUTUAL_FOV_DIAMETERS: f64 = 12.0;
/// Height of the camera if the observed body is near the horizon, km: the dip of the horizon is then 1.8 degrees.
const LOW_BODY_CAMERA_HEIGHT_KM: f64 = 3.0;
/// Altitude below which the observed body is near the horizon, degrees.
const LOW_BODY_ALTITUDE_DEG: f64 = 2.0;
/// Longest playback of an event, real seconds. An event that lasts longer, with the margins before and after it, is played faster, so that its playback takes
/// this time; a shorter event is played in real time.
const PLAYBACK_S: f64 = 30.0;
/// Fraction of an event's length that is shown before its first contact and after its last contact.
const MARGIN_FRACTION: f64 = 0.05;
/// Least real time that the playback spends in the central phase, such as totality, seconds. A central phase that would take longer at the rate of the whole
/// event is played at that rate; one that is itself shorter is played in real time.
const CENTRAL_PHASE_S: f64 = 10.0;
/// Real time for which playback is slow before and after the central phase, so that one sees how it begins and ends, seconds.
const CENTRAL_MARGIN_S: f64 = 2.0;
/// The contacts at which the central phase of an event begins and ends: in a solar eclipse, an eclipse of a moon, a transit or occultation.
const CENTRAL_CONTACTS: [(&str, &str); 3] = [("C2", "C3"), ("U2", "U3"), ("II", "III")];

impl SkyEvent {
    /// The view that shows the event best, paused at its greatest phase: of a solar eclipse, from the place of greatest eclipse; of other events, from the
    /// Earth's centre. Other settings come from `base_view`.
    pub fn view(&self, catalog: &Catalog, positions: &dyn BodyPositions, base_view: &ViewState) -> ViewState {
        let from_earth_km = |id: NaifId| positions.geometric_vector_km(NaifId::EARTH, id, self.greatest());
        // The defaults in these two closures are not reached: the event was found with this catalog and these positions.
        let apparent_diameter_deg = |id: NaifId| {
            let radius_km = catalog.body(id).map_or(1.0, |b| b.radii_km.x);
            let distance_km = from_earth_km(id).map_or(1e9, |d| d.length());
            (2.0 * radius_km / distance_km).to_degrees()
        };
        let separation_deg = |a, b| from_earth_km(a).zip(from_earth_km(b)).map_or(0.0, |(a, b)| angle_rad(a, b).to_degrees());
        let (target, fov_deg) = match self {
            Self::Solar(e) => return self.view_from(e.place, e.sun_altitude_deg, base_view),
            Self::Lunar(_) => (NaifId::MOON, LUNAR_ECLIPSE_FOV_DEG),
            Self::Transit(_) => (NaifId::SUN, TRANSIT_FOV_DEG),
            // A mutual event, in which one moon occults or eclipses another.
            Self::Moons(e) if e.nearer_moon.is_some() => (e.moon, MUTUAL_FOV_DIAMETERS * apparent_diameter_deg(e.moon)),
            Self::Moons(e) => {
                // An eclipsed moon is in the shadow behind the planet, which at quadrature is far from the planet's disc.
                let moon_separation_deg = if e.class == MoonEventType::Eclipse { separation_deg(e.planet, e.moon) } else { 0.0 };
                let planet_fov_deg = PLANET_FOV_DIAMETERS * apparent_diameter_deg(e.planet);
                (e.planet, planet_fov_deg.max(ECLIPSED_MOON_FOV_SEPARATIONS * moon_separation_deg))
            }
        };
        base_view.paused_view(self.greatest(), target, CameraPose::Centre { body: NaifId::EARTH }, fov_deg)
    }

    /// The view of the event from a place on the Earth, paused at the event's greatest phase. `altitude_deg`: altitude of the observed body at the place.
    pub(crate) fn view_from(&self, place: GeodeticPosition, altitude_deg: f64, base_view: &ViewState) -> ViewState {
        let (target, fov_deg) = match self {
            Self::Solar(_) => (NaifId::SUN, ECLIPSED_SUN_FOV_DEG),
            Self::Lunar(_) => (NaifId::MOON, LUNAR_ECLIPSE_FROM_PLACE_FOV_DEG),
            Self::Transit(_) => (NaifId::SUN, TRANSIT_FOV_DEG),
            // A mutual event, as in `view`.
            Self::Moons(e) if e.nearer_moon.is_some() => (e.moon, MUTUAL_FROM_PLACE_FOV_DEG),
            Self::Moons(e) if e.class == MoonEventType::Eclipse => (e.planet, ECLIPSED_MOON_FROM_PLACE_FOV_DEG),
            Self::Moons(e) => (e.planet, PLANET_FROM_PLACE_FOV_DEG),
        };
        let camera_height_km = if altitude_deg < LOW_BODY_ALTITUDE_DEG { LOW_BODY_CAMERA_HEIGHT_KM } else { GROUND_CAMERA_HEIGHT_KM };
        let camera_pose = CameraPose::Ground {
            body: NaifId::EARTH,
            latitude_deg: place.latitude_deg,
            longitude_deg: place.longitude_deg,
            height_km: place.height_km.max(0.0) + camera_height_km,
            // The camera tracks the target, so these two angles are not used.
            azimuth_deg: 0.0,
            altitude_deg: 0.0,
        };
        base_view.paused_view(self.greatest(), target, camera_pose, fov_deg)
    }

    /// Playback from shortly before the first contact to shortly after the last contact. It takes [`PLAYBACK_S`], or less if the event is shorter.
    pub(crate) fn playback(&self) -> EventPlayback {
        let contacts = self.contacts_in_view();
        let time_of = |contact: Option<&(&str, Instant)>| contact.map_or(self.greatest(), |(_, time)| *time);
        EventPlayback::of_span(time_of(contacts.first()), time_of(contacts.last()), central_phase(&contacts))
    }

    /// Playback at a place. If the observed body rises during the event, playback begins when it rises; if the body sets during the event, playback ends
    /// when it sets.
    pub(crate) fn playback_at(&self, seen: &EventFromPlace) -> EventPlayback {
        let (Some(first), Some(last)) = (seen.contacts.first(), seen.contacts.last()) else { return self.playback() };
        let start = seen.rise.filter(|_| !first.is_up).unwrap_or(first.time);
        let end = seen.set.filter(|_| !last.is_up).unwrap_or(last.time);
        let contacts: Vec<(&str, Instant)> = seen.contacts.iter().map(|contact| (contact.name, contact.time)).collect();
        EventPlayback::of_span(start, end, central_phase(&contacts))
    }

    /// Contacts as seen in [`SkyEvent::view`]. For a solar eclipse these are the contacts at the place of greatest eclipse: an eclipse is shorter at one place
    /// than for the entire Earth.
    fn contacts_in_view(&self) -> Vec<(&'static str, Instant)> {
        let seen = if let Self::Solar(e) = self { e.seen_from(e.place) } else { None };
        let at_place = seen.map(|seen| seen.contacts.iter().map(|contact| (contact.name, contact.time)).collect::<Vec<_>>());
        at_place.filter(|contacts| !contacts.is_empty()).unwrap_or_else(|| self.contacts().to_vec())
    }
}

/// Start and end of the central phase of an event: totality, annularity, or the time that a planet or moon is entirely in front of the Sun or its planet.
/// `None` if it has none.
pub(crate) fn central_phase(contacts: &[(&str, Instant)]) -> Option<(Instant, Instant)> {
    let time_of = |name: &str| contacts.iter().find(|(contact, _)| *contact == name).map(|(_, time)| *time);
    CENTRAL_CONTACTS.into_iter().find_map(|(first, last)| time_of(first).zip(time_of(last)))
}

/// Span and rate of scene time for playing an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EventPlayback {
    /// Start of the span, TDB seconds past J2000; `end_tdb_s` is its end.
    pub start_tdb_s: f64,
    pub end_tdb_s: f64,
    /// Scene seconds per real second, except in the slow part.
    pub rate: f64,
    /// The part around a central phase that would be over in a moment at `rate`.
    pub slow_part: Option<SlowPart>,
}

/// The part of a playback around a short central phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SlowPart {
    /// Start, TDB seconds past J2000; `end_tdb_s` is its end.
    pub start_tdb_s: f64,
    pub end_tdb_s: f64,
    /// Scene seconds per real second.
    pub rate: f64,
}

impl EventPlayback {
    /// Playback of an event with these times of the first and the last contact, and with this central phase. The rest of the event is played faster where the
    /// central phase is played slower, so that the whole takes the same time.
    fn of_span(first: Instant, last: Instant, central: Option<(Instant, Instant)>) -> Self {
        let [first_tdb_s, last_tdb_s] = [first, last].map(Instant::tdb_seconds_past_j2000);
        let length_s = (last_tdb_s - first_tdb_s).max(1.0);
        let [start_tdb_s, end_tdb_s] = [first_tdb_s - MARGIN_FRACTION * length_s, last_tdb_s + MARGIN_FRACTION * length_s];
        let steady = Self { start_tdb_s, end_tdb_s, rate: ((end_tdb_s - start_tdb_s) / PLAYBACK_S).max(1.0), slow_part: None };
        let Some((second, third)) = central else { return steady };
        let [second_tdb_s, third_tdb_s] = [second, third].map(Instant::tdb_seconds_past_j2000);
        let rate = ((third_tdb_s - second_tdb_s) / CENTRAL_PHASE_S).max(1.0);
        let margin_s = CENTRAL_MARGIN_S * rate;
        // Rise or set may cut the central phase.
        let [slow_start_tdb_s, slow_end_tdb_s] =
            [second_tdb_s - margin_s, third_tdb_s + margin_s].map(|tdb_s| tdb_s.clamp(start_tdb_s, end_tdb_s));
        let slow_s = slow_end_tdb_s - slow_start_tdb_s;
        if rate >= steady.rate || slow_s <= 0.0 {
            return steady;
        }
        // The slow part takes at most `CENTRAL_PHASE_S` and twice `CENTRAL_MARGIN_S`, about half of `PLAYBACK_S`.
        let fast_rate = (end_tdb_s - start_tdb_s - slow_s) / (PLAYBACK_S - slow_s / rate);
        let slow_part = Some(SlowPart { start_tdb_s: slow_start_tdb_s, end_tdb_s: slow_end_tdb_s, rate });
        Self { rate: fast_rate, slow_part, ..steady }
    }

    /// Scene seconds per real second at a time.
    pub(crate) fn rate_at(&self, tdb_s: f64) -> f64 {
        self.slow_part.filter(|slow| (slow.start_tdb_s..slow.end_tdb_s).contains(&tdb_s)).map_or(self.rate, |slow| slow.rate)
    }

    /// Start, end and rate of the parts, in the order of time. Parts may be empty.
    fn parts(&self) -> [(f64, f64, f64); 3] {
        let none = SlowPart { start_tdb_s: self.end_tdb_s, end_tdb_s: self.end_tdb_s, rate: self.rate };
        let slow = self.slow_part.unwrap_or(none);
        [
            (self.start_tdb_s, slow.start_tdb_s, self.rate),
            (slow.start_tdb_s, slow.end_tdb_s, slow.rate),
            (slow.end_tdb_s, self.end_tdb_s, self.rate),
        ]
    }

    /// Length of the playback, real seconds.
    pub(crate) fn length_s(&self) -> f64 {
        self.parts().into_iter().map(|(start_tdb_s, end_tdb_s, rate)| (end_tdb_s - start_tdb_s) / rate).sum()
    }

    /// The time after a fraction (0 to 1) of the length of the playback, TDB seconds past J2000.
    pub(crate) fn tdb_s_at_fraction(&self, fraction: f64) -> f64 {
        let mut left_s = fraction * self.length_s();
        for (start_tdb_s, end_tdb_s, rate) in self.parts() {
            let part_s = (end_tdb_s - start_tdb_s) / rate;
            if left_s < part_s {
                return start_tdb_s + left_s * rate;
            }
            left_s -= part_s;
        }
        self.end_tdb_s
    }

    /// Whether a time is within the playback, or before or after it by at most its length. For a playback as seen from the Earth's centre or from the place of
    /// greatest eclipse, every time at which any other place sees the event is therefore near, too.
    pub(crate) fn is_near(&self, tdb_s: f64) -> bool {
        let length_s = self.end_tdb_s - self.start_tdb_s;
        (self.start_tdb_s - length_s..=self.end_tdb_s + length_s).contains(&tdb_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::MoonEvent;
    use crate::view::app::event_search::ContactAtPlace;
    use glam::DVec3;

    /// Rise and set cut the playback only where the first or the last contact is below the horizon: a body that sets and rises again is up at both.
    #[test]
    fn playback_at_a_place_is_cut_by_rise_and_set() {
        let at = Instant::from_tdb_seconds_past_j2000;
        let (class, moon, planet) = (MoonEventType::Transit, NaifId(501), NaifId(599));
        let event = SkyEvent::Moons(MoonEvent { class, moon, planet, nearer_moon: None, greatest: at(500.0), contacts: Vec::new() });
        let contact = |name, s: f64, is_up| ContactAtPlace { name, time: at(s), altitude_deg: 0.0, is_up };
        // Each span includes two margins of a twentieth of the length.
        for (first_is_up, last_is_up, rise_s, set_s, [start_s, end_s]) in [
            (false, true, Some(400.0), None, [370.0, 1030.0]),
            (true, false, None, Some(600.0), [-30.0, 630.0]),
            (false, false, Some(400.0), Some(600.0), [390.0, 610.0]),
            (true, true, Some(600.0), Some(400.0), [-50.0, 1050.0]),
            (true, true, None, None, [-50.0, 1050.0]),
        ] {
            let contacts = vec![contact("T1", 0.0, first_is_up), contact("T4", 1000.0, last_is_up)];
            let playback = event.playback_at(&EventFromPlace { contacts, is_visible: true, rise: rise_s.map(at), set: set_s.map(at) });
            let errors_s = [playback.start_tdb_s - start_s, playback.end_tdb_s - end_s];
            assert!(errors_s.iter().all(|error_s| error_s.abs() < 1e-3), "{start_s} to {end_s} s: {errors_s:?}");
        }
    }

    /// From a place, a mutual event is seen at the moon, and the field around Jupiter contains a moon in Jupiter's shadow.
    #[test]
    fn a_moons_event_is_in_the_view_from_a_place() {
        let (jupiter, io, callisto) = (NaifId(599), NaifId(501), NaifId(504));
        let greatest = Instant::from_tdb_seconds_past_j2000(0.0);
        let base_view = ViewState::around(NaifId::EARTH, DVec3::X * 1e5, 6378.0, DVec3::Z, greatest);
        let view = |class, moon, nearer_moon| {
            let event = SkyEvent::Moons(MoonEvent { class, moon, planet: jupiter, nearer_moon, greatest, contacts: Vec::new() });
            event.view_from(GeodeticPosition { latitude_deg: 50.0, longitude_deg: 10.0, height_km: 0.0 }, 45.0, &base_view)
        };
        let mutual = view(MoonEventType::MutualOccultation, io, Some(NaifId(502)));
        assert!(mutual.target == io && mutual.fov_deg < 0.01, "{mutual:?}");
        let transit = view(MoonEventType::Transit, io, None);
        // Jupiter's largest apparent diameter is 50 arcsec.
        assert!(transit.target == jupiter && transit.fov_deg > 1.2 * 50.0 / 3600.0, "{transit:?}");
        // At quadrature the Sun, Jupiter and the Earth form an angle of 11.5 degrees, and Jupiter is 5.1 au away: Callisto, 1.88 million km behind Jupiter,
        // appears at this angle from Jupiter.
        let separation_deg = (1.883e6 * 11.5_f64.to_radians().sin() / (5.1 * 1.496e8)).to_degrees();
        let eclipse = view(MoonEventType::Eclipse, callisto, None);
        assert!(eclipse.target == jupiter && eclipse.fov_deg > 2.0 * separation_deg, "{eclipse:?}, {separation_deg}");
    }

    /// Two minutes of totality once passed in a third of a second. The whole still takes half a minute; a long central phase needs no slow part.
    #[test]
    fn a_short_totality_is_played_for_ten_seconds() {
        let at = Instant::from_tdb_seconds_past_j2000;
        for (length_s, central_s, is_slow) in [(7200.0, 80.0, true), (7200.0, 4.0, true), (20_000.0, 3600.0, true), (7200.0, 6800.0, false)]
        {
            let middle_s = 0.5 * length_s;
            let [second_s, third_s] = [middle_s - 0.5 * central_s, middle_s + 0.5 * central_s];
            let contacts = [("C1", at(0.0)), ("C2", at(second_s)), ("C3", at(third_s)), ("C4", at(length_s))];
            let playback = EventPlayback::of_span(at(0.0), at(length_s), central_phase(&contacts));
            assert_eq!(playback.slow_part.is_some(), is_slow, "{playback:?}");
            assert!((playback.length_s() - PLAYBACK_S).abs() < 1e-9, "{playback:?}");
            assert_eq!(playback.rate_at(0.0), playback.rate);
            // Frames at equal real times, as an animation has them.
            let times: Vec<f64> = (0..=3000).map(|k| playback.tdb_s_at_fraction(f64::from(k) / 3000.0)).collect();
            let end_errors_s = [times[0] - playback.start_tdb_s, times[3000] - playback.end_tdb_s];
            assert!(times.is_sorted() && end_errors_s.iter().all(|error_s| error_s.abs() < 1e-6), "{end_errors_s:?}: {playback:?}");
            let in_phase = times.iter().filter(|tdb_s| (second_s..third_s).contains(*tdb_s)).count();
            let phase_s = in_phase as f64 / 3000.0 * PLAYBACK_S;
            let expected_s = CENTRAL_PHASE_S.min(central_s);
            assert!(if is_slow { (phase_s - expected_s).abs() < 0.1 } else { phase_s > CENTRAL_PHASE_S }, "{phase_s} s: {playback:?}");
        }
        // A partial eclipse has no central phase.
        assert_eq!(central_phase(&[("C1", at(0.0)), ("C4", at(9.0))]), None);
    }

    #[test]
    fn a_time_is_near_an_event_up_to_its_length_before_and_after() {
        let playback = EventPlayback { start_tdb_s: 1000.0, end_tdb_s: 1100.0, rate: 1.0, slow_part: None };
        for (tdb_s, is_near) in [(899.0, false), (901.0, true), (1050.0, true), (1199.0, true), (1201.0, false)] {
            assert_eq!(playback.is_near(tdb_s), is_near, "{tdb_s}");
        }
    }
}
