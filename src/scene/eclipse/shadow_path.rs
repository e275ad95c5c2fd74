//! The path of a shadow over the receiver's ground: the centre line and the limits of the umbra.
//!
//! In: a receiver and its occluder at one time. Out: lines on the ground for one passage, that is, one crossing of the shadow over the receiver: the passage
//! whose middle is nearest to that time. A limit is the envelope of the umbra's edges at all instants: the points where the edge is parallel to its own motion
//! over the rotating ground. Always: the geometry is that of [`ShadowCone`] at each instant, light time to the receiver's centre included. `events::path` has
//! another method for the limits of the Moon's shadow on the Earth: it starts from the instant of greatest eclipse at each place.

use crate::catalog::Body;
use crate::ephemeris::Ephemeris;
use crate::memo::Memo;
use crate::scene::eclipse::occluders::{Axis, Occluder, Receiver, candidates};
use crate::scene::eclipse::shadow_cone::{ConeKind, ConeLine, GroundLine, ShadowCone};
use crate::time::Instant;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A passage is found if its middle is at most this far from the receiver's time, seconds.
const MAX_MIDDLE_OFFSET_S: f64 = 6.0 * 3600.0;
/// Upper limit of half a passage's duration, seconds, with a wide margin: half of Callisto's passage over Jupiter takes about 2.5 hours.
const MAX_HALF_DURATION_S: f64 = 6.0 * 3600.0;
/// Number of intervals between the instants at which the points of a line are computed.
const INSTANT_INTERVALS: u32 = 200;
/// Number of generators, straight lines on the umbra's cone, in the search for the limits.
const GENERATORS: u32 = 64;
/// Passages of the same bodies whose middles are at most this far apart, seconds, are the same passage.
const SAME_PASSAGE_S: f64 = 60.0;
/// In the search for the middle of a passage: the interval over which the velocity of the axis is measured, and the precision of the middle, seconds.
const SEARCH_STEP_S: f64 = 60.0;
const MIDDLE_PRECISION_S: f64 = 0.1;
/// The middle counts as not found after this many steps of the search.
const MAX_SEARCH_STEPS: u32 = 8;
/// Halvings of an interval in a bisection: to 1e-12 of its length.
const BISECTION_STEPS: u32 = 40;
/// Number of paths in the cache.
const CACHED_PATHS: usize = 8;
/// The motion of the umbra's edge over the ground is a central difference: between this many seconds later and this many earlier.
const DIFFERENCE_STEP_S: f64 = 1.0;

/// Lines on the ground of one passage, in the receiver's unit-sphere frame.
#[derive(Clone, Debug)]
pub(crate) struct ShadowPath {
    /// The path of the shadow's axis; `None` if the axis misses the ground in the middle of the passage.
    pub centre_line: Option<GroundLine>,
    /// The limits of the umbra, or of the antumbra beyond its apex: first those on the left of the shadow's motion, then those on its right. A side may
    /// have none, or several with gaps between them.
    pub limits: Vec<GroundLine>,
    /// When the shadow's axis is nearest to the receiver's centre.
    pub middle: Instant,
}

/// Cache key: the bodies of a passage with the radii on which its lines depend, and its middle in TDB seconds past J2000.
#[derive(Debug)]
struct PassageKey {
    /// Of the Sun, the receiver and the occluder.
    radii_km: [DVec3; 3],
    /// Of the receiver and the occluder.
    ids: [i32; 2],
    middle_s: f64,
}

/// A cache of the paths computed most recently.
#[derive(Debug)]
pub(crate) struct ShadowPaths(Memo<PassageKey, Arc<ShadowPath>>);

impl Default for ShadowPaths {
    fn default() -> Self {
        Self(Memo::with_capacity(CACHED_PATHS))
    }
}

impl ShadowPaths {
    /// The path of an occluder's shadow over the receiver; `None` if the middle of the passage is more than `MAX_MIDDLE_OFFSET_S` away, or if the penumbra
    /// misses the receiver.
    pub(crate) fn of(
        &self,
        ephemeris: &Ephemeris,
        sun: &Body,
        receiver: &Receiver<'_>,
        occluder: &Occluder<'_>,
    ) -> Option<Arc<ShadowPath>> {
        let geometry = PassageGeometry { ephemeris, sun, receiver, occluder };
        let (middle_s, half_duration_s) = geometry.passage()?;
        let key = PassageKey {
            radii_km: [sun.radii_km, receiver.body.radii_km, occluder.body.radii_km],
            ids: [receiver.body.id.0, occluder.body.id.0],
            middle_s: receiver.time.tdb_seconds_past_j2000() + middle_s,
        };
        let is_same_passage = |cached: &PassageKey, requested: &PassageKey| {
            cached.ids == requested.ids
                && cached.radii_km == requested.radii_km
                && (cached.middle_s - requested.middle_s).abs() < SAME_PASSAGE_S
        };
        Some(self.0.get_compatible(is_same_passage, key, || Arc::new(geometry.path(middle_s, half_duration_s))))
    }
}

/// The bodies of a passage as functions of time. All times are seconds relative to the receiver's time.
struct PassageGeometry<'a, 'b> {
    ephemeris: &'a Ephemeris,
    sun: &'a Body,
    receiver: &'a Receiver<'b>,
    occluder: &'a Occluder<'b>,
}

impl PassageGeometry<'_, '_> {
    /// The receiver and the shadow cone at a time; `None` if the occluder is not in front of the Sun, or if the ephemeris lacks this time.
    fn at(&self, time_s: f64) -> Option<(Receiver<'_>, ShadowCone)> {
        let receiver = Receiver::at(self.ephemeris, self.receiver.body, self.receiver.time.plus_seconds(time_s)).ok()?;
        let axis = Axis::of(&receiver, self.sun)?;
        let min_blocked_fraction = 0.0;
        let found = candidates(self.ephemeris, std::iter::once(self.occluder.body), self.sun, &receiver, min_blocked_fraction);
        found.first().map(|occluder| (receiver, ShadowCone::of(axis, occluder, &receiver)))
    }

    fn cone(&self, time_s: f64) -> Option<ShadowCone> {
        self.at(time_s).map(|(_, cone)| cone)
    }

    /// Vector from the receiver's centre to the nearest point of the shadow's axis, in equatorial radii. The axes are those of the ICRF, so that the body's
    /// rotation does not count as motion.
    fn nearest_axis_point(&self, time_s: f64) -> Option<DVec3> {
        let (receiver, cone) = self.at(time_s)?;
        let ConeLine { origin, direction } = cone.axis_line();
        Some(receiver.body_from_icrf.transpose() * (origin - direction * origin.dot(direction)))
    }

    /// Middle of the passage and an upper limit of half its duration, seconds. The middle is when the shadow's axis is nearest to the receiver's centre;
    /// repeated linear extrapolation finds it. `None` if the penumbra misses the receiver, or if the middle is not found within [`MAX_MIDDLE_OFFSET_S`].
    fn passage(&self) -> Option<(f64, f64)> {
        let mut time_s = 0.0;
        for _ in 0..MAX_SEARCH_STEPS {
            let (axis_point, next) = (self.nearest_axis_point(time_s)?, self.nearest_axis_point(time_s + SEARCH_STEP_S)?);
            let velocity = (next - axis_point) / SEARCH_STEP_S;
            // Where |axis_point + velocity * step| is least.
            let step = -axis_point.dot(velocity) / velocity.length_squared();
            time_s += step;
            if !time_s.is_finite() || time_s.abs() > MAX_MIDDLE_OFFSET_S {
                return None;
            }
            if step.abs() < MIDDLE_PRECISION_S {
                let cone = self.cone(time_s)?;
                // In equatorial radii. At the contact distance the penumbra touches the receiver.
                let (nearest, contact_distance) = (axis_point.length(), 1.0 + cone.radius(ConeKind::Penumbra));
                // The factor of 1.2 is a margin for the curvature of the motion.
                let half_duration_s = 1.2 * ((contact_distance * contact_distance - nearest * nearest).max(0.0)).sqrt() / velocity.length();
                return (nearest < contact_distance).then_some((time_s, half_duration_s.min(MAX_HALF_DURATION_S)));
            }
        }
        None
    }

    /// The lines of the passage with this middle and at most this half duration.
    fn path(&self, middle_s: f64, half_duration_s: f64) -> ShadowPath {
        let axis_meets_ground = |time_s: f64| self.cone(time_s).is_some_and(|cone| cone.half_chord_sq(cone.axis_line()) > 0.0);
        let centre_point = |time_s: f64| self.cone(time_s).and_then(|cone| cone.ground_point(cone.axis_line()));
        let ground_line = |points: Vec<DVec3>| (points.len() > 3).then_some(GroundLine { points, is_closed: false });
        let centre_line = interval_where(middle_s, half_duration_s, axis_meets_ground)
            .and_then(|interval| ground_line(instants(interval).filter_map(centre_point).collect()));
        let umbra_meets_ground = |time_s: f64| {
            let generator_meets_ground = |cone: &ShadowCone, k: u32| {
                cone.half_chord_sq(cone.generator_at(ConeKind::Umbra, TAU * f64::from(k) / f64::from(GENERATORS))) > 0.0
            };
            self.cone(time_s).is_some_and(|cone| (0..GENERATORS).any(|k| generator_meets_ground(&cone, k)))
        };
        let mut limits = Vec::new();
        if let Some(interval) = interval_where(middle_s, half_duration_s, umbra_meets_ground) {
            let limit_points = |time_s: f64| self.limit_points(time_s).unwrap_or_default();
            let limits_by_instant: Vec<[Option<DVec3>; 2]> = instants(interval).map(limit_points).collect();
            for side in 0..2 {
                // A side may have no point for some instants; the line ends there.
                let runs = limits_by_instant.chunk_by(|a, b| a[side].is_some() == b[side].is_some());
                limits.extend(runs.filter_map(|run| ground_line(run.iter().filter_map(|sides| sides[side]).collect())));
            }
        }
        ShadowPath { centre_line, limits, middle: self.receiver.time.plus_seconds(middle_s) }
    }

    /// The two points at which the umbra's edge is parallel to its motion over the ground: the one on the left of the motion, seen from above, then the one on
    /// its right. Either is `None` if no such point was found. The outer `None`: there is no shadow cone at one of the times of the
    /// central difference, or a generator misses the ground during the bisection.
    fn limit_points(&self, time_s: f64) -> Option<[Option<DVec3>; 2]> {
        let (earlier, now, later) = (self.cone(time_s - DIFFERENCE_STEP_S)?, self.cone(time_s)?, self.cone(time_s + DIFFERENCE_STEP_S)?);
        let ground_point = |cone: &ShadowCone, angle: f64| cone.ground_point(cone.generator_at(ConeKind::Umbra, angle));
        // The point of the edge on the generator at `angle` (radians), the point's motion, and a number whose sign tells to which side of the edge the point
        // moves; at a limit this sign changes.
        let motion_at = |angle: f64| -> Option<(DVec3, DVec3, f64)> {
            /// Half the step of the central difference that gives the direction of the edge, radians.
            const ANGLE_STEP: f64 = 1e-4;
            let (point, motion) = (ground_point(&now, angle)?, ground_point(&later, angle)? - ground_point(&earlier, angle)?);
            let along_edge = ground_point(&now, angle + ANGLE_STEP)? - ground_point(&now, angle - ANGLE_STEP)?;
            Some((point, motion, point.dot(motion.cross(along_edge))))
        };
        let all: Vec<_> =
            (0..GENERATORS).map(|k| TAU * f64::from(k) / f64::from(GENERATORS)).map(|angle| (angle, motion_at(angle))).collect();
        let edge: Vec<DVec3> = all.iter().filter_map(|(_, found)| found.map(|(point, ..)| point)).collect();
        let centroid = edge.iter().sum::<DVec3>() / edge.len().max(1) as f64;
        let mut sides = [None; 2];
        for k in 0..all.len() {
            let ((from, Some((.., from_component))), (_, Some((.., next_component)))) = (all[k], all[(k + 1) % all.len()]) else {
                continue;
            };
            if (from_component > 0.0) == (next_component > 0.0) {
                continue;
            }
            let (mut low, mut high) = (from, from + TAU / f64::from(GENERATORS));
            for _ in 0..BISECTION_STEPS {
                let angle = 0.5 * (low + high);
                let (.., component) = motion_at(angle)?;
                if (component > 0.0) == (from_component > 0.0) { low = angle } else { high = angle }
            }
            let (point, motion, _) = motion_at(low)?;
            // The vector `up x motion` points to the left of the motion, and `point` points up.
            let is_left = point.cross(motion).dot(point - centroid) > 0.0;
            sides[usize::from(!is_left)] = Some(point);
        }
        Some(sides)
    }
}

/// The interval around the middle in which a condition holds, seconds; `None` if the condition does not hold in the middle.
fn interval_where(middle_s: f64, half_duration_s: f64, holds: impl Fn(f64) -> bool) -> Option<[f64; 2]> {
    let end = |mut outside: f64| {
        let mut inside = middle_s;
        for _ in 0..BISECTION_STEPS {
            let time_s = 0.5 * (inside + outside);
            if holds(time_s) { inside = time_s } else { outside = time_s }
        }
        inside
    };
    holds(middle_s).then(|| [end(middle_s - half_duration_s), end(middle_s + half_duration_s)])
}

/// Instants of an interval, denser at its ends, where a shadow runs fast over the ground.
fn instants([from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=INSTANT_INTERVALS).map(move |k| from + (to - from) * 0.5 * (1.0 - (PI * f64::from(k) / f64::from(INSTANT_INTERVALS)).cos()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use crate::scene::eclipse::occluders::MIN_BLOCKED_FRACTION_IN_IMAGES;

    /// Calls `check` with the catalog and the shadow paths over a receiver near a time, each with the NAIF code of its occluder.
    fn with_paths(receiver: i32, time: &str, check: impl FnOnce(&Catalog, Vec<(i32, Arc<ShadowPath>)>)) {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let body = |id| catalog.body(NaifId(id)).expect("in the catalog");
        let receiver = Receiver::at(&ephemeris, body(receiver), Instant::parse(time).expect("a time")).expect("placed");
        let found = candidates(&ephemeris, catalog.bodies().iter(), body(NaifId::SUN.0), &receiver, MIN_BLOCKED_FRACTION_IN_IMAGES);
        let cache = ShadowPaths::default();
        let path_of = |o: &Occluder<'_>| Some((o.body.id.0, cache.of(&ephemeris, body(NaifId::SUN.0), &receiver, o)?));
        check(&catalog, found.iter().filter_map(path_of).collect());
    }

    /// Distance in kilometres from a place on the ground, given in geodetic degrees, to the nearest point of a polyline in the unit-sphere frame.
    fn distance_km(radii_km: DVec3, line: &[DVec3], latitude_deg: f64, longitude_deg: f64) -> f64 {
        let height_km = 0.0;
        let (place, _normal) = crate::ephemeris::topocentric::ground_point_km(radii_km, latitude_deg, longitude_deg, height_km);
        let to_segment = |ends: &[DVec3]| {
            let [a, b] = [ends[0] * radii_km, ends[1] * radii_km];
            let t = ((place - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            place.distance(a.lerp(b, t))
        };
        line.windows(2).map(to_segment).fold(f64::INFINITY, f64::min)
    }

    /// The centre line and the limits of 2024-04-08 agree with NASA's published path at greatest eclipse.
    #[test]
    fn the_path_of_2024_agrees_with_nasa() {
        with_paths(399, "2024-04-08T18:17:16Z", |catalog, found| {
            let [(301, path)] = &found[..] else { panic!("{} paths", found.len()) };
            // The axis is nearest to the centre within two minutes of greatest eclipse.
            assert!(
                (path.middle.tdb_seconds_past_j2000() - Instant::parse("2024-04-08T18:17:16Z").expect("a time").tdb_seconds_past_j2000())
                    .abs()
                    < 120.0
            );
            let radii_km = catalog.body(NaifId::EARTH).expect("the Earth").radii_km;
            let centre = path.centre_line.as_ref().expect("a centre line");
            // NASA, Path of the Total Solar Eclipse of 2024 Apr 08 (Espenak): greatest eclipse 25 deg 17.4' N, 104 deg 08.3' W. With a Moon of k = 0.272508
            // Earth radii the width there is 197.5 km.
            let to_centre_line_km = distance_km(radii_km, &centre.points, 25.29, -104.138);
            assert!(to_centre_line_km < 2.0, "{to_centre_line_km} km");
            assert_eq!(path.limits.len(), 2);
            let [left, right] = [0, 1].map(|k| distance_km(radii_km, &path.limits[k].points, 25.29, -104.138));
            assert!((left + right - 197.5).abs() < 6.0 && (left - right).abs() < 6.0, "{left} {right}");
            // Negative control: a place 0.21 degrees (23 km) farther north is more than 10 km from the line.
            assert!(distance_km(radii_km, &centre.points, 25.5, -104.138) > 10.0);
        });
        // Twelve hours before the eclipse no passage is found; five hours before it, this passage is found.
        with_paths(399, "2024-04-08T06:00:00Z", |_, found| assert!(found.is_empty()));
        with_paths(399, "2024-04-08T13:20:00Z", |_, found| assert_eq!(found.len(), 1));
    }

    /// The centre lines of moons' shadows on Jupiter span less than 15 degrees of latitude, and a large moon's limits are 0.2 to 2.5 of its diameters apart.
    #[test]
    fn the_shadow_of_a_moon_crosses_jupiter_along_a_belt() {
        let mut passage_count = 0;
        for time in ["2024-12-07T20:00:00Z", "2024-12-08T12:00:00Z", "2024-12-09T06:00:00Z", "2024-12-10T00:00:00Z"] {
            with_paths(599, time, |catalog, found| {
                let radii_km = catalog.body(NaifId(599)).expect("Jupiter").radii_km;
                for (moon, path) in found.iter().filter(|(_, path)| path.centre_line.is_some()) {
                    let line = &path.centre_line.as_ref().expect("a centre line").points;
                    // Parametric latitudes.
                    let latitudes: Vec<f64> = line.iter().map(|p| p.z.asin().to_degrees()).collect();
                    let (south, north) = latitudes.iter().fold((90.0_f64, -90.0_f64), |(s, n), l| (s.min(*l), n.max(*l)));
                    assert!(north - south < 15.0, "{moon}: {south} to {north}");
                    let middle_km = line[line.len() / 2] * radii_km;
                    let distances_to_limits_km = path
                        .limits
                        .iter()
                        .map(|limit| limit.points.iter().map(|p| (*p * radii_km).distance(middle_km)).fold(f64::INFINITY, f64::min));
                    let diameter_km = 2.0 * catalog.body(NaifId(*moon)).expect("a moon").radii_km.x;
                    let width_km: f64 = distances_to_limits_km.sum();
                    // Only the Galilean moons: a small moon's umbra ends before it reaches Jupiter.
                    if diameter_km < 2000.0 {
                        continue;
                    }
                    // The umbra is narrower than the moon because of the Sun's angular size, and longer where it meets the ground at a slant.
                    // A width needs both limits.
                    assert!(path.limits.len() < 2 || (0.2..2.5).contains(&(width_km / diameter_km)), "{moon}: {width_km} of {diameter_km}");
                    passage_count += 1;
                }
            });
        }
        assert!(passage_count >= 1, "no passage of a large moon");
    }
}
