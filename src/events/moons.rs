//! Phenomena of the Galilean moons and Titan: transits, occultations, shadow transits, eclipses.
//!
//! In: catalog, ephemeris, a span of time. Out: events as the Earth's centre sees them. The region that a moon enters is bounded by planes tangent to the
//! planet's spheroid. For transits and occultations these planes pass through the observer, the Earth's centre. For shadow transits and eclipses the observer
//! is the Sun, and the planes are tangent to its sphere or pass through its centre. The part of the planet that is both lit and visible is narrower than its
//! disc by up to 1500 km (Jupiter). Transits and shadow transits begin and end at the edge of this part: at the limb on one side, at the terminator on the
//! other. Light time between Sun, moon, planet and Earth is included. An event is listed even if another hides it, such as the end of an eclipse behind the
//! planet. The theories of the moons limit the accuracy of instants: 30 s for the Galilean moons. Not here: events of two moons (`mutual`). Not modelled: the
//! planets' atmospheres, which delay eclipses by a minute or so.

use super::contacts::{Contact, seconds_between, sort_by_time};
use super::fitted::FittedPosition;
use super::numeric::{minimum, time_of_minimum, zero_crossing};
use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::{BEST_SOURCE, Ephemeris, EphemerisError, State};
use crate::time::Instant;
use crate::units::SPEED_OF_LIGHT_KM_S;
use glam::DVec3;

/// Io, Europa, Ganymede, Callisto.
pub(super) const GALILEAN: [NaifId; 4] = [NaifId(501), NaifId(502), NaifId(503), NaifId(504)];
/// The Galilean moons and Titan.
const MOONS: [NaifId; 5] = [NaifId(501), NaifId(502), NaifId(503), NaifId(504), NaifId(606)];
/// Number of samples in one orbit of a moon; conjunctions are searched between neighbouring samples.
const STEPS_PER_ORBIT: f64 = 16.0;

/// The kind of phenomenon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoonEventType {
    /// The moon in front of the planet.
    Transit,
    /// The moon behind the planet.
    Occultation,
    /// The moon's shadow on the planet.
    ShadowTransit,
    /// The moon in the planet's shadow.
    Eclipse,
    /// The moon behind another moon.
    MutualOccultation,
    /// The moon in another moon's shadow.
    MutualEclipse,
}

impl MoonEventType {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Transit => "transit",
            Self::Occultation => "occultation",
            Self::ShadowTransit => "shadow transit",
            Self::Eclipse => "eclipse",
            Self::MutualOccultation => "mutual occultation",
            Self::MutualEclipse => "mutual eclipse",
        }
    }
}

/// A phenomenon of a moon.
#[derive(Clone, Debug)]
pub struct MoonEvent {
    /// Its type (`type` is a keyword of Rust).
    pub class: MoonEventType,
    /// The moon that is in transit, casts the shadow, is occulted or is eclipsed.
    pub moon: NaifId,
    /// The planet of the moon.
    pub planet: NaifId,
    /// The occulting or eclipsing moon of a mutual event; `None` for other events.
    pub nearer_moon: Option<NaifId>,
    /// As the Earth's centre sees it: when the moon's centre is nearest to the line through the planet's centre and the observer, which is the Earth, or for
    /// shadow transits and eclipses the Sun. In mutual events, when the nearer moon's centre is nearest to the line from the farther one to the observer.
    pub greatest: Instant,
    /// Contacts by time, as the Earth's centre sees them. `begin` and `end`: the moon's centre crosses the planet's limb, seen from the Earth or, in eclipses,
    /// from the Sun's centre; in transits and shadow transits the centre of the moon or of its shadow crosses the edge of the part of the disc that is lit and
    /// visible. I to IV: the limbs touch, in transits and occultations. P1 and P4: first and last contact with the penumbra, in a shadow transit of the planet
    /// with that of the moon, which may be on ground that the Earth does not see. U2 and U3: begin and end of the time for which the moon is entirely inside
    /// the planet's umbra. U1 and U4: first and last contact with the umbra or antumbra of another moon.
    pub contacts: Vec<Contact>,
}

impl MoonEvent {
    /// Seconds from `begin` to `end`; in mutual events from the first to the last contact. `None` if the event lacks these contacts.
    pub(crate) fn duration_s(&self) -> Option<f64> {
        let duration = |first, last| seconds_between(&self.contacts, first, last);
        duration("begin", "end")
            .or_else(|| duration("I", "IV").filter(|_| self.nearer_moon.is_some()))
            .or_else(|| duration("P1", "P4").filter(|_| self.nearer_moon.is_some()))
    }
}

/// Events whose greatest phase is in `from..to`, moon by moon. Moons that the catalog lacks are left out.
///
/// # Errors
/// The ephemeris does not cover the span.
pub fn moon_events(catalog: &Catalog, ephemeris: &Ephemeris, from: Instant, to: Instant) -> Result<Vec<MoonEvent>, EphemerisError> {
    let mut found = Vec::new();
    let Some(sun) = catalog.body(NaifId::SUN) else { return Ok(found) };
    for moon in MOONS.iter().filter_map(|id| catalog.body(*id)) {
        let Some(planet) = moon.parent.and_then(|id| catalog.body(id)) else { continue };
        let pair = MoonAndPlanet { ephemeris, sun_radius_km: sun.radii_km.x, planet, moon };
        for observer in [NaifId::EARTH, NaifId::SUN] {
            for (middle, is_in_front) in pair.conjunctions(observer, from, to)? {
                let event = MoonConjunction::around(&pair, observer, middle)?.event(&pair, is_in_front)?;
                found.extend(event.filter(|e| (from..to).contains(&e.greatest)));
            }
        }
    }
    Ok(found)
}

/// A moon and its planet, with what the computation of their events needs.
struct MoonAndPlanet<'a> {
    ephemeris: &'a Ephemeris,
    sun_radius_km: f64,
    planet: &'a Body,
    moon: &'a Body,
}

impl MoonAndPlanet<'_> {
    /// State of the moon relative to the planet.
    fn moon_from_planet(&self, t: Instant) -> Result<State, EphemerisError> {
        Ok(self.ephemeris.state(self.moon.id, self.planet.id, t, BEST_SOURCE)?.state)
    }

    /// When the moon crosses the line from the planet to the observer (time at the planet, accurate to half a minute: light time is left out), and whether it
    /// is then in front of the planet.
    fn conjunctions(&self, observer: NaifId, from: Instant, to: Instant) -> Result<Vec<(Instant, bool)>, EphemerisError> {
        // NAIF numbers: 5 is the barycentre of Jupiter (599) and its moons. For the observer it is within 1e-6 radians of the planet.
        let barycentre = NaifId(self.planet.id.0 / 100);
        // Signed distance of the moon from the line, in the plane of the orbit, km; and a number that is positive if the moon is in front of the planet.
        let offsets = |t: Instant| -> Result<(f64, f64), EphemerisError> {
            let State { pos_km, vel_km_s } = self.moon_from_planet(t)?;
            let to_observer_km = self.ephemeris.state(observer, barycentre, t, BEST_SOURCE)?.state.pos_km;
            let perpendicular = pos_km.cross(vel_km_s).cross(to_observer_km);
            Ok((pos_km.dot(perpendicular) / perpendicular.length(), pos_km.dot(to_observer_km)))
        };
        // Light from the planet takes less than two hours: the Earth sees the event of a conjunction at most this much later.
        const MAX_LIGHT_TIME_S: f64 = 7200.0;
        let State { pos_km, vel_km_s } = self.moon_from_planet(from)?;
        let step_s = std::f64::consts::TAU * pos_km.length() / vel_km_s.length() / STEPS_PER_ORBIT;
        let mut found = Vec::new();
        let mut sample_time = from.plus_seconds(-MAX_LIGHT_TIME_S - step_s);
        let mut offset = offsets(sample_time)?.0;
        while sample_time < to {
            let next = sample_time.plus_seconds(step_s);
            let next_offset = offsets(next)?.0;
            if (offset < 0.0) != (next_offset < 0.0) {
                // Secant method, until a step is shorter than a second: the offset is nearly linear in time here. a, b, s: seconds after `sample_time`.
                let (mut a, mut fa, mut b, mut fb) = (0.0, offset, step_s, next_offset);
                for _ in 0..4 {
                    let s = a - fa * (b - a) / (fb - fa);
                    let f = offsets(sample_time.plus_seconds(s))?.0;
                    if (s - b).abs() < 1.0 || f == fb {
                        b = s;
                        break;
                    }
                    (a, fa, b, fb) = (b, fb, s, f);
                }
                let middle = sample_time.plus_seconds(b);
                found.push((middle, offsets(middle)?.1 > 0.0));
            }
            (sample_time, offset) = (next, next_offset);
        }
        Ok(found)
    }
}

/// A moon, its planet and the observer around a conjunction. The observer is the Earth, or the Sun for events of shadows. Times are those at which the light
/// that shows the event is at the planet, in seconds from `middle`; vectors are from the planet's centre, km, ICRF axes.
struct MoonConjunction {
    observer: NaifId,
    middle: Instant,
    /// Half of the span, around `middle`, over which the positions are fitted.
    half_span_s: f64,
    /// Position of the moon.
    moon: FittedPosition,
    /// Vector to the Earth when it receives the light, or to the Sun when it sent the light.
    to_observer: FittedPosition,
    /// Barycentric velocity of the planet.
    planet_velocity_km_s: DVec3,
    /// Unit vector to the planet's north pole.
    pole: DVec3,
}

/// The planes that bound a region. Each touches the planet; the variant states their position relative to the observer.
#[derive(Clone, Copy)]
enum BoundingPlanes {
    /// The planes pass through the observer's centre.
    Centre,
    /// Planet and Sun are on the same side of each plane: the boundary of the umbra, and of the convex hull of planet and Sun.
    ExternalTangent,
    /// Each plane passes between planet and Sun: the boundary of the penumbra.
    InternalTangent,
}

impl MoonConjunction {
    /// `middle`: when the moon crosses the line from the planet to the observer ([`MoonAndPlanet::conjunctions`]).
    fn around(pair: &MoonAndPlanet<'_>, observer: NaifId, middle: Instant) -> Result<Self, EphemerisError> {
        let (planet, ephemeris) = (pair.planet.id, pair.ephemeris);
        let vel_km_s = pair.moon_from_planet(middle)?.vel_km_s;
        // All contacts are within about the time in which the moon moves by the sum of both radii: twice this time, and ten minutes, leaves room.
        let half_span_s = 2.0 * (pair.planet.radii_km.x + pair.moon.radii_km.x) / vel_km_s.length() + 600.0;
        let instant = |s: f64| middle.plus_seconds(s);
        let moon = FittedPosition::fit(half_span_s, |s| Ok(pair.moon_from_planet(instant(s))?.pos_km))?;
        let to_observer = FittedPosition::fit(half_span_s, |s| vector_to_observer(ephemeris, planet, observer, instant(s)))?;
        let planet_velocity_km_s = ephemeris.state(planet, NaifId::SOLAR_SYSTEM_BARYCENTER, middle, BEST_SOURCE)?.state.vel_km_s;
        let pole = ephemeris.body_from_icrf(planet, middle)?.row(2);
        Ok(Self { observer, middle, half_span_s, moon, to_observer, planet_velocity_km_s, pole })
    }

    /// For light that reaches or leaves the planet's centre at `s`: the moon's position when the light passes it; how much later than `s` the light passes the
    /// moon, in seconds, negative if it is earlier; and the vector to the observer.
    fn geometry_of_light(&self, s: f64) -> (DVec3, f64, DVec3) {
        let to_observer = self.to_observer.at(s);
        // Distance by which the moon is nearer to the observer than the planet is.
        let depth_km = self.moon.at(s).dot(to_observer.normalize_or_zero());
        // Light goes from the planet to the Earth, and from the Sun to the planet.
        let delay_s = if self.observer == NaifId::SUN { -depth_km } else { depth_km } / SPEED_OF_LIGHT_KM_S;
        // The planet moves during the delay; the vectors are from its centre at `s`.
        (self.moon.at(s + delay_s) + self.planet_velocity_km_s * delay_s, delay_s, to_observer)
    }

    /// How far the moon's centre lies outside the region that the planes bound, km; negative inside.
    fn distance_outside_km(&self, pair: &MoonAndPlanet<'_>, s: f64, planes: BoundingPlanes) -> f64 {
        let (moon_km, _, to_observer) = self.geometry_of_light(s);
        let distance_km = to_observer.length();
        let observer_direction = to_observer / distance_km;
        // The observer's radius, negative if planet and observer are on the same side of a plane.
        let signed_observer_radius_km = match planes {
            BoundingPlanes::Centre => 0.0,
            BoundingPlanes::ExternalTangent => -pair.sun_radius_km,
            BoundingPlanes::InternalTangent => pair.sun_radius_km,
        };
        let radii_km = pair.planet.radii_km;
        // Support function: distance from the planet's centre to the tangent plane with this unit normal.
        let support_km = |n: DVec3| (n * radii_km.x + self.pole * (n.dot(self.pole) * (radii_km.z - radii_km.x))).length();
        let perpendicular = (moon_km - observer_direction * moon_km.dot(observer_direction))
            .try_normalize()
            .unwrap_or_else(|| observer_direction.any_orthonormal_vector());
        let sideways = observer_direction.cross(perpendicular);
        // How far the moon's centre is beyond the plane whose normal has this angle from `perpendicular` around the line to the observer.
        let beyond_plane_km = |angle: f64| {
            let across = perpendicular * angle.cos() + sideways * angle.sin();
            // A plane with the unit normal n that touches the planet also touches the observer if n . to_observer is support_km(n) plus the signed radius.
            // n . to_observer is distance_km times the tilt, which is so small that `across` stands for n in the support function.
            let tilt = (support_km(across) + signed_observer_radius_km) / distance_km;
            let normal = across * (1.0 - tilt * tilt).max(0.0).sqrt() + observer_direction * tilt;
            moon_km.dot(normal) - support_km(normal)
        };
        // The plane beyond which the moon is farthest. The flattening rotates its normal away from `perpendicular`: by at most 0.1 radians
        // at the boundary (Saturn), and by less than 0.3 near it.
        let (max_angle_rad, tolerance_rad) = (0.3, 1e-5);
        beyond_plane_km(minimum(-max_angle_rad, max_angle_rad, tolerance_rad, |angle| -beyond_plane_km(angle)))
    }

    /// When the Earth's centre sees what the light that is at the planet at `s` shows: in an eclipse the moon, else the planet.
    fn reception_of(&self, pair: &MoonAndPlanet<'_>, class: MoonEventType, s: f64) -> Result<Instant, EphemerisError> {
        let (moon_km, delay_s, _) = self.geometry_of_light(s);
        let at = self.middle.plus_seconds(s);
        let planet_km = pair.ephemeris.state(pair.planet.id, NaifId::SOLAR_SYSTEM_BARYCENTER, at, BEST_SOURCE)?.state.pos_km;
        if class == MoonEventType::Eclipse {
            return reception_time(pair.ephemeris, planet_km + moon_km, at.plus_seconds(delay_s));
        }
        reception_time(pair.ephemeris, planet_km, at)
    }

    /// The part of the time `first..last` for which the ground below the moon's centre, on the line from the observer, is lit and visible; `None` if there is
    /// none. The observer is above its horizon; here the other of the two, the Sun or the Earth, must be, too.
    fn part_on_lit_and_visible_ground(
        &self,
        pair: &MoonAndPlanet<'_>,
        (first, last): (f64, f64),
    ) -> Result<Option<(f64, f64)>, EphemerisError> {
        let other = if self.observer == NaifId::SUN { NaifId::EARTH } else { NaifId::SUN };
        let to_other = FittedPosition::fit(self.half_span_s, |s| {
            vector_to_observer(pair.ephemeris, pair.planet.id, other, self.middle.plus_seconds(s))
        })?;
        let depression = |s: f64| {
            let (moon_km, _, to_observer_km) = self.geometry_of_light(s);
            -self.sine_of_altitude(pair.planet.radii_km, moon_km, moon_km - to_observer_km, to_other.at(s))
        };
        // The ground below the moon moves on a nearly straight line across the disc, on which the altitude has one maximum.
        let highest_s = time_of_minimum(first, last, depression);
        Ok((depression(highest_s) < 0.0).then(|| (zero_crossing(highest_s, first, depression), zero_crossing(highest_s, last, depression))))
    }

    /// Sine of the altitude of a distant body above the ground where a line first meets the planet's spheroid, or is nearest to it if it misses it. The line
    /// goes through `from_km` along `along`, of any length; `body_km`: the distant body. Vectors are from the planet's centre, ICRF axes.
    fn sine_of_altitude(&self, radii_km: DVec3, from_km: DVec3, along: DVec3, body_km: DVec3) -> f64 {
        // Makes the spheroid a sphere of the equatorial radius.
        let stretched = |v: DVec3| v + self.pole * (v.dot(self.pole) * (radii_km.x / radii_km.z - 1.0));
        let (from, direction) = (stretched(from_km), stretched(along).normalize_or_zero());
        let nearest_to_centre = from - direction * from.dot(direction);
        let half_chord = (radii_km.x.powi(2) - nearest_to_centre.length_squared()).max(0.0).sqrt();
        let ground = nearest_to_centre - direction * half_chord;
        // The normal of the spheroid is the gradient of the square of the stretched length.
        stretched(ground).normalize_or_zero().dot(body_km.normalize_or_zero())
    }

    /// The event at this conjunction; `None` if the moon misses the region.
    fn event(&self, pair: &MoonAndPlanet<'_>, is_in_front: bool) -> Result<Option<MoonEvent>, EphemerisError> {
        let class = match (self.observer == NaifId::SUN, is_in_front) {
            (false, true) => MoonEventType::Transit,
            (false, false) => MoonEventType::Occultation,
            (true, true) => MoonEventType::ShadowTransit,
            (true, false) => MoonEventType::Eclipse,
        };
        let radius_km = pair.moon.radii_km.x;
        // Names of the first and the last contact, the bounding planes, and the distance of the moon's centre outside them at these contacts.
        let limits: &[(&str, &str, BoundingPlanes, f64)] = match class {
            MoonEventType::Transit | MoonEventType::Occultation => &[
                ("I", "IV", BoundingPlanes::Centre, radius_km),
                ("II", "III", BoundingPlanes::Centre, -radius_km),
                ("begin", "end", BoundingPlanes::Centre, 0.0),
            ],
            // The moon's penumbra is on the planet while the moon is partly inside the convex hull of planet and Sun.
            MoonEventType::ShadowTransit => {
                &[("P1", "P4", BoundingPlanes::ExternalTangent, radius_km), ("begin", "end", BoundingPlanes::Centre, 0.0)]
            }
            // An eclipse.
            _ => &[
                ("P1", "P4", BoundingPlanes::InternalTangent, radius_km),
                ("U2", "U3", BoundingPlanes::ExternalTangent, -radius_km),
                ("begin", "end", BoundingPlanes::Centre, 0.0),
            ],
        };
        let distance_from_line_km = |s: f64| {
            let (moon_km, _, to_observer) = self.geometry_of_light(s);
            moon_km.cross(to_observer.normalize_or_zero()).length()
        };
        // The positions are evaluated up to a few seconds of light time before or after an instant of the search.
        let search_s = self.half_span_s - 30.0;
        let greatest_s = time_of_minimum(-search_s, search_s, distance_from_line_km);
        let mut contacts = Vec::new();
        for &(first, last, planes, distance_km) in limits {
            let gap_km = |s: f64| self.distance_outside_km(pair, s, planes) - distance_km;
            if gap_km(greatest_s) >= 0.0 {
                continue;
            }
            let mut span_s = (zero_crossing(greatest_s, -search_s, gap_km), zero_crossing(greatest_s, search_s, gap_km));
            if is_in_front && first == "begin" {
                let Some(seen_s) = self.part_on_lit_and_visible_ground(pair, span_s)? else { continue };
                span_s = seen_s;
            }
            contacts.push((first, self.reception_of(pair, class, span_s.0)?));
            contacts.push((last, self.reception_of(pair, class, span_s.1)?));
        }
        sort_by_time(&mut contacts);
        let greatest = self.reception_of(pair, class, greatest_s)?;
        let event = MoonEvent { class, moon: pair.moon.id, planet: pair.planet.id, nearer_moon: None, greatest, contacts };
        Ok((!event.contacts.is_empty()).then_some(event))
    }
}

/// Vector from a planet at `t` to the observer: to the Earth when it receives the planet's light, or to the Sun when it sent the light that arrives at
/// `t`. Kilometres, ICRF axes.
pub(super) fn vector_to_observer(ephemeris: &Ephemeris, planet: NaifId, observer: NaifId, t: Instant) -> Result<DVec3, EphemerisError> {
    let barycentric_km =
        |body, t| Ok::<_, EphemerisError>(ephemeris.state(body, NaifId::SOLAR_SYSTEM_BARYCENTER, t, BEST_SOURCE)?.state.pos_km);
    let planet_km = barycentric_km(planet, t)?;
    if observer == NaifId::SUN {
        let (sun_km, _emission_time) = ephemeris.light_time_position(NaifId::SUN, planet_km, t)?;
        return Ok(sun_km - planet_km);
    }
    Ok(barycentric_km(observer, reception_time(ephemeris, planet_km, t)?)? - planet_km)
}

/// When the Earth's centre receives light that leaves a place at `t`. `place_km`: barycentric, ICRF.
pub(super) fn reception_time(ephemeris: &Ephemeris, place_km: DVec3, t: Instant) -> Result<Instant, EphemerisError> {
    let mut at = t;
    // The Earth's speed is 1e-4 of light's: three rounds leave less than a microsecond.
    for _ in 0..3 {
        let earth_km = ephemeris.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, at, BEST_SOURCE)?.state.pos_km;
        at = t.plus_seconds((earth_km - place_km).length() / SPEED_OF_LIGHT_KM_S);
    }
    Ok(at)
}
