//! Traces: past positions of bodies relative to the target, such as the Moon's wavy path about the Sun or the loops of Mars about the Earth.
//!
//! In: the ephemeris, the centre (the target, else the Sun), and the apparent place of each body. Out: [`LineSegment`]s, clipped to the frame, whose ends
//! meet exactly. Paths are sampled backwards from the time when the light that now arrives left the body, so that the first vertex is the body's apparent
//! position; between samples they are Hermite cubics with the samples' velocities. Left out: moons of bodies other than the centre, because their loops are too
//! small and too numerous. The only exception is the Moon, which also has a trace about the Sun.

use crate::catalog::{Body, NaifId};
use crate::ephemeris::orbit_size::osculating_period_s;
use crate::ephemeris::{BEST_SOURCE, Ephemeris, State};
use crate::message::{Reason, reason};
use crate::scene::annotation::orbits::line_colour;
use crate::scene::annotation::strokes::{LineSegment, clipped_to_frame, reversed_depth};
use crate::scene::camera::{Camera, NEAR_DEPTH_KM, narrow, narrow_scalar, narrow2};
use crate::scene::decision::Decision;
use crate::scene::placed::PlacedBody;
use crate::units::{DAYS_PER_JULIAN_YEAR, SECONDS_PER_DAY};
use glam::{DVec2, DVec3};

/// Samples of the ephemeris per period, for the shorter of the periods of the body and the centre.
const SAMPLES_PER_PERIOD: f64 = 48.0;
/// Minimum and maximum number of samples of a path. The maximum also limits a path to 1200 / 48 = 25 of the shorter periods, which for a
/// centre that is a fast moon are days or weeks.
const MIN_SAMPLES: usize = 16;
const MAX_SAMPLES: usize = 1200;
/// A year in periods of the Moon about the Earth: the length of the Moon's trace about the Sun.
const MOON_PERIODS_PER_YEAR: f64 = 13.4;
/// Line segments between two samples.
const SEGMENTS_PER_SAMPLE: usize = 4;
/// Length of a path in units of the longer of two periods: the body's about its parent, and the centre's about its own. If the body orbits the centre, only the
/// body's counts.
const LENGTH_PERIODS: f64 = 1.0;
/// Maximum length of a path.
const MAX_DAYS: f64 = 12.0 * DAYS_PER_JULIAN_YEAR;
/// Opacity at the body; the path fades to 0 at its end.
const OPACITY: f64 = 0.9;

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PathPoint {
    /// Position relative to the body's current position, ICRF.
    offset_km: DVec3,
    /// Fraction of the opacity at the body that remains at this point.
    remaining_opacity: f64,
}

/// A point of a path as the camera sees it.
#[derive(Clone, Copy)]
struct CameraPoint {
    /// Position relative to the camera, camera axes.
    position_km: DVec3,
    /// As [`PathPoint::remaining_opacity`].
    remaining_opacity: f64,
}

/// Points of a path relative to the body's current position, newest first. `states`: samples `step_s` apart, newest first.
fn path(states: &[State], step_s: f64) -> Vec<PathPoint> {
    let count = (states.len() - 1) * SEGMENTS_PER_SAMPLE;
    let point = |k: usize, offset_km: DVec3| PathPoint { offset_km, remaining_opacity: 1.0 - k as f64 / count as f64 };
    let interpolated = |k: usize| {
        let (n, fraction) = (k / SEGMENTS_PER_SAMPLE, (k % SEGMENTS_PER_SAMPLE) as f64 / SEGMENTS_PER_SAMPLE as f64);
        let newer_km = states[n].pos_km - states[0].pos_km;
        let Some(older) = states.get(n + 1).filter(|_| fraction > 0.0) else { return point(k, newer_km) };
        // Hermite cubic. Time runs backwards, so the velocities have a minus sign.
        let (t, t2, t3) = (fraction, fraction * fraction, fraction * fraction * fraction);
        let older_km = older.pos_km - states[0].pos_km;
        let interpolated_km = newer_km * (2.0 * t3 - 3.0 * t2 + 1.0) - states[n].vel_km_s * ((t3 - 2.0 * t2 + t) * step_s)
            + older_km * (3.0 * t2 - 2.0 * t3)
            - older.vel_km_s * ((t3 - t2) * step_s);
        point(k, interpolated_km)
    };
    (0..=count).map(interpolated).collect()
}

/// The part of a path inside the frame, as line segments. `body_km`: the body's apparent position from the camera, ICRF.
fn segments(camera: &Camera, body_km: DVec3, path: &[PathPoint], colour: DVec3) -> Vec<LineSegment> {
    let seen_from_camera = |point: &PathPoint| CameraPoint {
        position_km: camera.in_axes(body_km + point.offset_km),
        remaining_opacity: point.remaining_opacity,
    };
    let points: Vec<CameraPoint> = path.iter().map(seen_from_camera).collect();
    // x to the right, y up.
    let px_from_middle = |p: DVec3| DVec2::new(p.x, p.y) / (p.z * camera.tan_half_fov) * camera.half_size_px();
    // Direction of segment k in the image; `None` if it does not exist, reaches the near plane or has no length.
    let direction = |k: usize| {
        let (a, b) = (points.get(k)?.position_km, points.get(k + 1)?.position_km);
        if a.z > NEAR_DEPTH_KM && b.z > NEAR_DEPTH_KM { (px_from_middle(b) - px_from_middle(a)).try_normalize() } else { None }
    };
    let normal = |k: usize| {
        let mean = k.checked_sub(1).and_then(direction).into_iter().chain(direction(k)).sum::<DVec2>();
        narrow2(mean.try_normalize().unwrap_or(DVec2::X).perp())
    };
    let segment = |k: usize| {
        let (from, to) = (points[k], points[k + 1]);
        let [enter, leave] = clipped_to_frame(camera, from.position_km, to.position_km)?;
        let at = |t: f64| CameraPoint {
            position_km: from.position_km.lerp(to.position_km, t),
            remaining_opacity: from.remaining_opacity + t * (to.remaining_opacity - from.remaining_opacity),
        };
        let [a, b] = [at(enter), at(leave)];
        let end = |p: DVec3| narrow((px_from_middle(p) / camera.half_size_px()).extend(reversed_depth(p)));
        Some(LineSegment {
            ends: [end(a.position_km), end(b.position_km)],
            normals: [normal(k), normal(k + 1)],
            opacity: [a, b].map(|point| narrow_scalar(OPACITY * point.remaining_opacity)),
            colour: narrow(colour),
        })
    };
    (0..points.len() - 1).filter_map(segment).collect()
}

/// Span of a path in seconds and its number of samples, from the longer and the shorter of the periods.
fn span_and_samples(longer_s: f64, shorter_s: f64) -> (f64, usize) {
    let max_sampled_s = MAX_SAMPLES as f64 / SAMPLES_PER_PERIOD * shorter_s;
    let span_s = (LENGTH_PERIODS * longer_s).min(MAX_DAYS * SECONDS_PER_DAY).min(max_sampled_s);
    let samples = ((span_s / shorter_s * SAMPLES_PER_PERIOD).ceil() as usize).clamp(MIN_SAMPLES, MAX_SAMPLES);
    (span_s, samples)
}

/// The trace of one body relative to a centre and the decision about it. `None`: the body is the centre, or a moon that is left out, or the centre is not in
/// the catalog.
pub(crate) fn trace(
    camera: &Camera,
    ephemeris: &Ephemeris,
    placed: &PlacedBody<'_>,
    centre: NaifId,
) -> Option<(Vec<LineSegment>, Decision)> {
    let is_child_of_centre = placed.body.parent == Some(centre);
    let is_sun_or_orbits_sun = placed.body.parent == Some(NaifId::SUN) || placed.body.id == NaifId::SUN;
    let is_moon_around_sun = centre == NaifId::SUN && placed.body.id == NaifId::MOON;
    if placed.body.id == centre || !(is_child_of_centre || is_sun_or_orbits_sun || is_moon_around_sun) {
        return None;
    }
    let effect = "trace";
    let decision = |on: bool, reason: Reason| Decision { effect, on, reason, stated_error: None };
    let centre_body = placed.catalog.body(centre)?;
    let period_s = |body: &Body| osculating_period_s(placed.catalog, ephemeris, body, placed.emitted_at);
    let own_period_s = period_s(placed.body);
    let centre_period_s = if is_child_of_centre {
        None
    } else {
        // The Sun has no period; for the Moon a year takes its place.
        period_s(centre_body).or_else(|| own_period_s.map(|s| MOON_PERIODS_PER_YEAR * s).filter(|_| is_moon_around_sun))
    };
    let periods_s = [own_period_s, centre_period_s];
    let longer_s = periods_s.into_iter().flatten().fold(0.0, f64::max);
    let shorter_s = periods_s.into_iter().flatten().fold(f64::INFINITY, f64::min);
    if longer_s <= 0.0 {
        return Some((Vec::new(), decision(false, reason!("trace-no-period"))));
    }
    let (span_s, samples) = span_and_samples(longer_s, shorter_s);
    let step_s = span_s / samples as f64;
    let states: Result<Vec<State>, _> = (0..=samples)
        .map(|k| ephemeris.state(placed.body.id, centre, placed.emitted_at.plus_seconds(-step_s * k as f64), BEST_SOURCE).map(|a| a.state))
        .collect();
    let states = match states {
        Ok(states) => states,
        Err(e) => return Some((Vec::new(), decision(false, reason!("quoted", text = &e.to_string())))),
    };
    let trace_segments = segments(camera, placed.placement.centre_km, &path(&states, step_s), line_colour(placed.body));
    let reason = match trace_segments.len() {
        0 => reason!("outside-frame"),
        n => {
            let days = span_s / SECONDS_PER_DAY;
            reason!("trace-samples", days = format_args!("{days:.1}"), body = &centre_body.name, samples = samples, count = n)
        }
    };
    let on = !trace_segments.is_empty();
    Some((trace_segments, decision(on, reason)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;
    use crate::time::Instant;

    /// Over a month the Moon's path agrees with the ephemeris between samples to 4 km, 1e-5 of its distance; linear interpolation is off by over 400 km.
    #[test]
    fn a_path_agrees_with_the_ephemeris() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("an ephemeris");
        let now = Instant::parse("2024-04-08T18:00:00Z").expect("a time");
        let at = |s: f64| ephemeris.state(NaifId::MOON, NaifId::EARTH, now.plus_seconds(s), BEST_SOURCE).expect("a state").state;
        let step_s = 27.3 * SECONDS_PER_DAY / SAMPLES_PER_PERIOD;
        let states: Vec<State> = (0..=48).map(|k| at(-step_s * f64::from(k))).collect();
        let path = path(&states, step_s);
        assert_eq!((path.len(), path[0]), (48 * SEGMENTS_PER_SAMPLE + 1, PathPoint { offset_km: DVec3::ZERO, remaining_opacity: 1.0 }));
        let (mut worst_km, mut worst_linear_km) = (0.0_f64, 0.0_f64);
        for (k, point) in path.iter().enumerate() {
            let expected = at(-step_s * k as f64 / SEGMENTS_PER_SAMPLE as f64).pos_km - states[0].pos_km;
            worst_km = worst_km.max(point.offset_km.distance(expected));
            let (a, fraction) = (k / SEGMENTS_PER_SAMPLE, (k % SEGMENTS_PER_SAMPLE) as f64 / SEGMENTS_PER_SAMPLE as f64);
            if let Some(b) = states.get(a + 1) {
                worst_linear_km = worst_linear_km.max((states[a].pos_km.lerp(b.pos_km, fraction) - states[0].pos_km).distance(expected));
            }
        }
        assert!(worst_km < 4.0 && worst_linear_km > 400.0, "{worst_km} km, linear interpolation {worst_linear_km} km");
        assert!(path.windows(2).all(|w| w[1].remaining_opacity < w[0].remaining_opacity), "it fades");
    }

    /// Paths of Jupiter relative to Io and of Mars relative to Phobos agree with the ephemeris between samples to 1e-3 of the moon's distance. Over the
    /// planet's own period, with as many samples, they are off by more than the moon's distance.
    #[test]
    fn a_path_relative_to_a_fast_moon_agrees_with_the_ephemeris() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("an ephemeris");
        let now = Instant::parse("2024-04-08T18:00:00Z").expect("a time");
        // Jupiter and Io, Mars and Phobos, with their periods.
        for (planet, moon, planet_days, moon_days) in [(599, 501, 4332.6, 1.769_14), (499, 401, 686.98, 0.318_91)] {
            let at = |s: f64| ephemeris.state(NaifId(planet), NaifId(moon), now.plus_seconds(s), BEST_SOURCE).expect("a state").state;
            // Largest error relative to the moon's distance.
            let worst = |span_s: f64, samples: usize| {
                let step_s = span_s / samples as f64;
                let states: Vec<State> = (0..=samples).map(|k| at(-step_s * k as f64)).collect();
                let error = |(k, point): (usize, &PathPoint)| {
                    let expected = at(-step_s * k as f64 / SEGMENTS_PER_SAMPLE as f64).pos_km;
                    (point.offset_km + states[0].pos_km).distance(expected) / expected.length()
                };
                path(&states, step_s).iter().enumerate().map(error).fold(0.0, f64::max)
            };
            let (span_s, samples) = span_and_samples(planet_days * SECONDS_PER_DAY, moon_days * SECONDS_PER_DAY);
            assert_eq!(samples, MAX_SAMPLES);
            assert!((span_s / SECONDS_PER_DAY / moon_days - 25.0).abs() < 1e-9, "{span_s}");
            let (error, error_of_long_path) = (worst(span_s, samples), worst(planet_days * SECONDS_PER_DAY, samples));
            assert!(error < 1e-3 && error_of_long_path > 1.0, "{planet}: {error}, over the planet's period {error_of_long_path}");
        }
        // Slow motion is sampled over the longer period, up to 12 years: 1.881 x 48 samples, rounded up, and 12 x 48.
        let year_s = DAYS_PER_JULIAN_YEAR * SECONDS_PER_DAY;
        assert_eq!(span_and_samples(1.881 * year_s, year_s), (1.881 * year_s, 91));
        assert_eq!(span_and_samples(164.8 * year_s, year_s), (MAX_DAYS * SECONDS_PER_DAY, 576));
    }
}
