//! Mutual phenomena of the Galilean moons: occultations and eclipses of one by another, in the seasons when the Earth or the Sun is in the plane of their
//! orbits.
//!
//! In: catalog, ephemeris, a span of time. Out: events as the Earth's centre sees them. Light time between Sun, both moons and the Earth is included; moons are
//! spheres. The theory of the moons limits the accuracy of instants to 30 s, so that grazing events are uncertain. Events that Jupiter hides are listed too.

use super::contacts::sort_by_time;
use super::fitted::FittedPosition;
use super::moons::{GALILEAN, MoonEvent, MoonEventType, reception_time, vector_to_observer};
use super::numeric::{time_of_minimum, zero_crossing};
use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::{BEST_SOURCE, Ephemeris, EphemerisError};
use crate::time::Instant;
use crate::units::{SECONDS_PER_DAY, SPEED_OF_LIGHT_KM_S};
use glam::DVec3;

const JUPITER: NaifId = NaifId(599);
const JUPITER_BARYCENTRE: NaifId = NaifId(5);
/// Time between samples. Two moons pass each other at 32 km/s at most, so their distance changes by at most 19 200 km from sample to sample.
const STEP_S: f64 = 600.0;
/// Two moons pass without an event if, at the sample nearest to their passage, their centres are farther apart than this perpendicular to the line of sight.
/// An event needs less than 10 000 km (both discs and the penumbra); until the nearest sample the distance grows by at most 19 200 km.
const MAX_DISTANCE_KM: f64 = 40_000.0;
/// Sine of 4 degrees: while the Earth or the Sun is farther from the plane of Jupiter's equator, there are no events. Two moons on the same side of Jupiter are
/// at least 249 000 km apart along the line of sight (Io and Europa). At 3 degrees from the plane of their orbits they pass each other at a distance of
/// 249 000 km * sin 3 degrees = 13 000 km, too far for an event. The fourth degree allows for the inclinations of the orbits.
const MAX_SEASON_SINE: f64 = 0.07;
/// Half of the fitted span: the slowest passages, at a moon's greatest elongation, take up to five hours.
const HALF_SPAN_S: f64 = 8.0 * 3600.0;
/// Time between samples of a passage. Near greatest elongation one moon may pass another twice within hours; small steps find the contacts of this passage, not
/// of the other one.
const CONTACT_STEP_S: f64 = 60.0;
/// Directions of a search in time.
const BACKWARD: f64 = -1.0;
const FORWARD: f64 = 1.0;

/// Events whose greatest phase is in `from..to`. Moons that the catalog lacks are left out.
///
/// # Errors
/// The ephemeris does not cover the span.
pub fn mutual_events(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<MoonEvent>, EphemerisError> {
    let moons: Vec<&Body> = GALILEAN.iter().filter_map(|id| catalog.body(*id)).filter(|b| b.parent == Some(JUPITER)).collect();
    let mut found = Vec::new();
    let Some(sun) = catalog.body(NaifId::SUN) else { return Ok(found) };
    let pairs: Vec<(usize, usize)> = (0..moons.len()).flat_map(|a| (0..a).map(move |b| (a, b))).collect();
    // Events are listed by the time when the Earth sees them. Light from Jupiter takes less than an hour. Two more steps, because a minimum needs three
    // samples.
    let start = from.plus_seconds(-3600.0 - 2.0 * STEP_S);
    for observer in [NaifId::EARTH, NaifId::SUN] {
        let mut sample_time = start;
        // Distances of the pairs perpendicular to the line of sight at the last two samples.
        let mut second_last: Option<Vec<f64>> = None;
        let mut last: Option<Vec<f64>> = None;
        while sample_time < to.plus_seconds(2.0 * STEP_S) {
            let observer_direction =
                ephemeris.state(observer, JUPITER_BARYCENTRE, sample_time, BEST_SOURCE)?.state.pos_km.normalize_or_zero();
            let pole = ephemeris.body_from_icrf(JUPITER, sample_time)?.row(2);
            if pole.dot(observer_direction).abs() > MAX_SEASON_SINE {
                (second_last, last) = (None, None);
                sample_time = sample_time.plus_seconds(SECONDS_PER_DAY);
                continue;
            }
            let positions = moons.iter().map(|m| Ok(ephemeris.state(m.id, JUPITER, sample_time, BEST_SOURCE)?.state.pos_km));
            let positions: Vec<DVec3> = positions.collect::<Result<_, EphemerisError>>()?;
            let current: Vec<f64> = pairs.iter().map(|&(a, b)| (positions[a] - positions[b]).cross(observer_direction).length()).collect();
            if let (Some(second_last), Some(last)) = (&second_last, &last) {
                for (k, &(a, b)) in pairs.iter().enumerate() {
                    // The distance was least at the last sample.
                    if last[k] <= second_last[k] && last[k] < current[k] && last[k] < MAX_DISTANCE_KM {
                        let middle = sample_time.plus_seconds(-STEP_S);
                        let conjunction = MutualConjunction::around(ephemeris, [moons[a], moons[b]], observer, sun.radii_km.x, middle)?;
                        let event = conjunction.event(ephemeris)?.filter(|e| (from..to).contains(&e.greatest));
                        // Two conjunctions may belong to one event.
                        let new_event = event.filter(|e| !found.iter().any(|earlier| is_same_event(earlier, e)));
                        found.extend(new_event);
                    }
                }
            }
            (second_last, last) = (last, Some(current));
            sample_time = sample_time.plus_seconds(STEP_S);
        }
    }
    Ok(found)
}

/// Whether two events are one: the same moons at the same instant.
fn is_same_event(a: &MoonEvent, b: &MoonEvent) -> bool {
    let apart_s = a.greatest.tdb_seconds_past_j2000() - b.greatest.tdb_seconds_past_j2000();
    (a.class, a.moon, a.nearer_moon) == (b.class, b.moon, b.nearer_moon) && apart_s.abs() < CONTACT_STEP_S
}

/// Two moons around their conjunction. Times, in seconds from `middle`: in an occultation, when the light leaves the farther moon; in an eclipse, when sunlight
/// reaches it. Vectors are from Jupiter's centre, km, ICRF axes. `observer`: the Earth in an occultation, the Sun in an eclipse. The nearer moon is the one
/// nearer to the observer.
struct MutualConjunction<'a> {
    near: &'a Body,
    far: &'a Body,
    /// Position of the nearer moon.
    near_km: FittedPosition,
    /// Position of the farther moon.
    far_km: FittedPosition,
    /// Vector to the Earth when it receives the light, or to the Sun when it sent the light.
    to_observer: FittedPosition,
    observer: NaifId,
    sun_radius_km: f64,
    /// Barycentric velocity of Jupiter.
    planet_velocity_km_s: DVec3,
    middle: Instant,
}

/// Position of the nearer moon relative to the line from the farther moon's centre to the observer, km.
struct Offset {
    /// Distance of the nearer moon's centre from the line.
    lateral_km: f64,
    /// Distance along the line by which the nearer moon is nearer to the observer than the farther moon.
    depth_km: f64,
    /// Distance of the observer from the farther moon.
    observer_distance_km: f64,
}

/// A region behind the nearer moon, which the farther moon may enter.
#[derive(Clone, Copy)]
enum Region {
    /// Hidden from the Earth by the nearer moon.
    Hidden,
    Penumbra,
    /// The umbra, or the antumbra beyond its tip.
    Umbra,
}

impl<'a> MutualConjunction<'a> {
    /// `moons`: in any order. `middle`: a sample near the conjunction.
    fn around(
        ephemeris: &Ephemeris,
        moons: [&'a Body; 2],
        observer: NaifId,
        sun_radius_km: f64,
        middle: Instant,
    ) -> Result<Self, EphemerisError> {
        let instant = |s: f64| middle.plus_seconds(s);
        let fit = |moon: &Body| {
            FittedPosition::fit(HALF_SPAN_S, |s| Ok(ephemeris.state(moon.id, JUPITER, instant(s), BEST_SOURCE)?.state.pos_km))
        };
        let to_observer = FittedPosition::fit(HALF_SPAN_S, |s| vector_to_observer(ephemeris, JUPITER, observer, instant(s)))?;
        let [a, b] = moons;
        let (a_km, b_km) = (fit(a)?, fit(b)?);
        let a_is_near = (a_km.at(0.0) - b_km.at(0.0)).dot(to_observer.at(0.0)) > 0.0;
        let (near, far, near_km, far_km) = if a_is_near { (a, b, a_km, b_km) } else { (b, a, b_km, a_km) };
        let planet_velocity_km_s = ephemeris.state(JUPITER, NaifId::SOLAR_SYSTEM_BARYCENTER, middle, BEST_SOURCE)?.state.vel_km_s;
        Ok(Self { near, far, near_km, far_km, to_observer, observer, sun_radius_km, planet_velocity_km_s, middle })
    }

    /// The offset for light that leaves (occultation) or reaches (eclipse) the farther moon at `s`.
    fn offset(&self, s: f64) -> Offset {
        let far_km = self.far_km.at(s);
        let far_to_observer_km = self.to_observer.at(s) - far_km;
        let observer_distance_km = far_to_observer_km.length();
        let observer_direction = far_to_observer_km / observer_distance_km;
        // Light goes from the farther moon past the nearer one to the Earth, and from the Sun past the nearer one to the farther.
        let depth_km = (self.near_km.at(s) - far_km).dot(observer_direction);
        let delay_s = if self.observer == NaifId::SUN { -depth_km } else { depth_km } / SPEED_OF_LIGHT_KM_S;
        // Positions are relative to Jupiter, which moves during the delay.
        let far_to_near_km = self.near_km.at(s + delay_s) + self.planet_velocity_km_s * delay_s - far_km;
        let lateral_km = far_to_near_km.cross(observer_direction).length();
        Offset { lateral_km, depth_km: far_to_near_km.dot(observer_direction), observer_distance_km }
    }

    /// Distance of the farther moon's limb, where it is nearest, from a region behind the nearer moon, km; negative if a part of the farther moon is inside.
    fn distance_outside_km(&self, s: f64, region: Region) -> f64 {
        let offset = self.offset(s);
        let (near_radius_km, far_radius_km) = (self.near.radii_km.x, self.far.radii_km.x);
        // Distance of the observer from the nearer moon.
        let near_to_observer_km = offset.observer_distance_km - offset.depth_km;
        // Radius of the region at the farther moon, by similar triangles.
        let radius_km = match region {
            Region::Hidden => near_radius_km * offset.observer_distance_km / near_to_observer_km,
            Region::Penumbra => near_radius_km + offset.depth_km * (self.sun_radius_km + near_radius_km) / near_to_observer_km,
            Region::Umbra => (near_radius_km - offset.depth_km * (self.sun_radius_km - near_radius_km) / near_to_observer_km).abs(),
        };
        // Distance of the farther moon's centre from the region's axis, which goes from the observer through the nearer moon's centre.
        let from_axis_km = offset.lateral_km * offset.observer_distance_km / near_to_observer_km;
        from_axis_km - radius_km - far_radius_km
    }

    /// The last instant before `inside_s` (`direction` [`BACKWARD`]), or the first one after it ([`FORWARD`]), at which the farther moon touches the region
    /// from outside. At `inside_s` a part of the moon is inside the region. If it is still inside near the end of the fitted span, the result is the
    /// last instant searched.
    fn exit_s(&self, inside_s: f64, direction: f64, region: Region) -> f64 {
        let distance_km = |s: f64| self.distance_outside_km(s, region);
        let mut last_inside_s = inside_s;
        // Not in the last 24 minutes of the fitted span, because the nearer moon is evaluated at another instant: earlier or later by the light time between
        // the moons, up to 10 s.
        while last_inside_s.abs() < 0.95 * HALF_SPAN_S {
            let next = last_inside_s + direction * CONTACT_STEP_S;
            if distance_km(next) >= 0.0 {
                return zero_crossing(last_inside_s, next, distance_km);
            }
            last_inside_s = next;
        }
        last_inside_s
    }

    /// The event at this conjunction; `None` if the farther moon misses the outermost region.
    fn event(&self, ephemeris: &Ephemeris) -> Result<Option<MoonEvent>, EphemerisError> {
        let lateral_km = |s: f64| self.offset(s).lateral_km;
        let conjunction_s = time_of_minimum(-2.0 * STEP_S, 2.0 * STEP_S, lateral_km);
        // For each region: names of the first and the last contact with it.
        let (class, limits): (_, &[(&str, &str, Region)]) = if self.observer == NaifId::SUN {
            (MoonEventType::MutualEclipse, &[("P1", "P4", Region::Penumbra), ("U1", "U4", Region::Umbra)])
        } else {
            (MoonEventType::MutualOccultation, &[("I", "IV", Region::Hidden)])
        };
        let reception_of = |s: f64| -> Result<Instant, EphemerisError> {
            let at = self.middle.plus_seconds(s);
            let planet_km = ephemeris.state(JUPITER, NaifId::SOLAR_SYSTEM_BARYCENTER, at, BEST_SOURCE)?.state.pos_km;
            reception_time(ephemeris, planet_km + self.far_km.at(s), at)
        };
        // The first region in `limits` contains the others.
        let outermost = limits[0].2;
        if self.distance_outside_km(conjunction_s, outermost) >= 0.0 {
            return Ok(None);
        }
        // Between the first and the last contact the moons may pass twice: the nearer passage is the greatest phase.
        let (begin_s, end_s) = (self.exit_s(conjunction_s, BACKWARD, outermost), self.exit_s(conjunction_s, FORWARD, outermost));
        let sample_s = |k: i32| begin_s + f64::from(k) * CONTACT_STEP_S;
        let steps = ((end_s - begin_s) / CONTACT_STEP_S).ceil() as i32;
        let nearest = (0..=steps).min_by(|a, b| lateral_km(sample_s(*a)).total_cmp(&lateral_km(sample_s(*b)))).unwrap_or(0);
        let greatest_s = time_of_minimum(sample_s(nearest) - CONTACT_STEP_S, sample_s(nearest) + CONTACT_STEP_S, lateral_km);
        let mut contacts = Vec::new();
        for &(first, last, region) in limits {
            if self.distance_outside_km(greatest_s, region) < 0.0 {
                contacts.push((first, reception_of(self.exit_s(greatest_s, BACKWARD, region))?));
                contacts.push((last, reception_of(self.exit_s(greatest_s, FORWARD, region))?));
            }
        }
        sort_by_time(&mut contacts);
        let greatest = reception_of(greatest_s)?;
        let event = MoonEvent { class, moon: self.far.id, planet: JUPITER, nearer_moon: Some(self.near.id), greatest, contacts };
        Ok((!event.contacts.is_empty()).then_some(event))
    }
}
