//! Two sweeps (runs over many cases) about shadows. `shadows` computes the fraction of sunlight at points in umbra, penumbra, antumbra and full light;
//! `umbra-exposure` draws moons in Jupiter's umbra at exposures from -20 to +25 stops ([`ExposureRequest::Stops`] states what stop 0 is).
//!
//! In: a sweep's setup. Out: the number of cases and the worst of them.

use super::views::{JUPITER, view_from_offset};
use super::{SINGLE_SAMPLE, SweepResult, SweepSetup, retain_draws};
use crate::catalog::{Body, NaifId};
use crate::ephemeris::{BEST_SOURCE, angle_rad};
use crate::measure::larger_or_nan;
use crate::probe::Prober;
use crate::probe::sunlight::OccludedSun;
use crate::render::plan::FrameImages;
use crate::render::software::Precision;
use crate::scene::draw::EclipseModel;
use crate::scene::eclipse::{EclipseModelChoice, Receiver};
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{ExposureRequest, Layers, ViewRequest};
use crate::session::SessionError;
use crate::time::Instant;
use crate::units::{SPEED_OF_LIGHT_KM_S, SUN_RADIUS_KM};
use glam::DVec3;
use serde_json::json;

/// Shadows, each as receiver, occluder and instant (UTC).
const SHADOWS: [(&str, &str, &str); 7] = [
    ("earth", "moon", "2024-04-08T18:17:16Z"),
    ("earth", "moon", "2023-10-14T17:59:30Z"),
    ("earth", "moon", "2013-11-03T12:46:30Z"),
    ("moon", "earth", "2022-11-08T10:59:00Z"),
    ("jupiter", "io", "2015-01-24T06:30:00Z"),
    ("jupiter", "callisto", "2015-01-24T06:30:00Z"),
    ("saturn", "titan", "2024-10-27T12:00:00Z"),
];

/// Margin, as a fraction of the Sun's angular radius, by which a point must be inside an umbra or outside a penumbra for its light to be
/// certain: exactly 0 or 1. f32 resolves directions to 6e-8 rad, or 1.2e-4 of the Sun's radius as seen from Saturn (4.9e-4 rad); the margin is forty times
/// that.
const UMBRA_MARGIN: f64 = 5e-3;

/// The fraction of sunlight at a point, if the angular radii of Sun and occluder and their separation alone decide it: 0 in the umbra, 1 in full light. `None`
/// in penumbra and antumbra, within [`UMBRA_MARGIN`] of the boundaries, and where the occluder's flattening matters. Positions are relative to the point.
fn light_from_angles(sun_km: DVec3, occluder_km: DVec3, occluder: &Body) -> Option<f64> {
    let sun_radius_rad = (SUN_RADIUS_KM / sun_km.length()).asin();
    let occluder_radius_rad = |km: f64| (km / occluder_km.length()).asin();
    let separation_rad = angle_rad(sun_km, occluder_km);
    if occluder_radius_rad(occluder.radii_km.min_element()) - separation_rad > sun_radius_rad * (1.0 + UMBRA_MARGIN) {
        Some(0.0)
    } else if separation_rad > sun_radius_rad * (1.0 + UMBRA_MARGIN) + occluder_radius_rad(occluder.radii_km.max_element()) {
        Some(1.0)
    } else {
        None
    }
}

/// Points on a body's surface: the centre of a shadow, and `steps` points in each of eight directions from it. Their distances from the centre grow
/// geometrically from a millionth of the equatorial radius to that radius. Points are in body axes, in equatorial radii. `sunward`: unit vector to the Sun;
/// `occluder_km`: position of the occluder relative to the body; both in body axes.
fn points_around(body: &Body, sunward: DVec3, occluder_km: DVec3, steps: u32) -> Vec<DVec3> {
    let axis_ratios = body.radii_km / body.radii_km.x;
    let occluder = occluder_km / body.radii_km.x;
    // Where the line from the Sun through the occluder hits the sphere; if it misses, the direction of its closest approach to the centre.
    let antisunward = -sunward;
    let nearest = occluder - antisunward * occluder.dot(antisunward);
    let shadow_centre = (nearest - antisunward * (1.0 - nearest.length_squared()).max(0.0).sqrt()).normalize();
    let (x, y) = shadow_centre.any_orthonormal_pair();
    let mut points = vec![shadow_centre * axis_ratios];
    for octant in 0..8 {
        // The 0.1 rad are arbitrary: no direction lies along `x` or `y`.
        let (sin, cos) = (f64::from(octant) * std::f64::consts::FRAC_PI_4 + 0.1).sin_cos();
        for k in 0..steps {
            let distance_radii = 1e-6 * 1e6_f64.powf(f64::from(k) / f64::from(steps - 1));
            points.push((shadow_centre + (x * cos + y * sin) * distance_radii).normalize() * axis_ratios);
        }
    }
    points
}

/// Sweep of the fraction of sunlight: f32 against f64, and both against [`light_from_angles`] where it gives a value.
pub(super) fn shadows(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    let session = setup.session();
    let ephemeris = session.ephemeris();
    for (receiver_name, occluder_name, time) in SHADOWS {
        let (Ok(body), Ok(occluder), Ok(time)) =
            (session.catalog().body_named(receiver_name), session.catalog().body_named(occluder_name), Instant::parse(time))
        else {
            continue;
        };
        let receiver = Receiver::at(ephemeris, body, time)?;
        let (occluder_icrf_km, _emitted_at) = ephemeris.light_time_position(occluder.id, receiver.position_km, time)?;
        let occluder_km = receiver.body_from_icrf * (occluder_icrf_km - receiver.position_km);
        let sun_km = receiver.body_from_icrf * receiver.body_to_sun_km;
        let points = points_around(body, sun_km.normalize(), occluder_km, setup.short_or_full(40, 400));
        for model in [EclipseModel::LimbDarkened, EclipseModel::UniformDisc] {
            let sunlight_in = |precision| {
                let prober = Prober { session, renderer: setup.renderers.renderer(precision) };
                let occluded_sun = OccludedSun::seen_from(&prober, &receiver, EclipseModelChoice::Requested(model)).ok()?;
                let one_occluder: Vec<_> = occluded_sun.occluders.iter().filter(|o| o.body.id == occluder.id).cloned().collect();
                // `None`: the catalog's limb darkening stays.
                let replaced_sun_photometry = None;
                occluded_sun.sunlight(&one_occluder, &points, replaced_sun_photometry).ok()
            };
            let (Some(single), Some(double)) = (sunlight_in(Precision::F32), sunlight_in(Precision::F64)) else {
                // What could not be computed is the worst result.
                found.add(f64::INFINITY, || {
                    (json!({ "body": receiver_name, "occluder": occluder_name }), "no light could be computed".into())
                });
                continue;
            };
            for ((point, a), b) in points.iter().zip(&single).zip(&double) {
                let point_km = *point * body.radii_km.x;
                let expected_light = light_from_angles(sun_km - point_km, occluder_km - point_km, occluder);
                let difference = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, larger_or_nan);
                let is_wrong = expected_light.is_some_and(|light| a.iter().chain(b).any(|v| *v != light));
                // In units of the fraction of sunlight. A value that is certainly wrong counts as 1, even if both precisions agree.
                found.add(if is_wrong { 1.0 } else { difference }, || {
                    let case = json!({
                        "body": receiver_name, "occluder": occluder_name, "time": time.to_utc_iso(), "model": model.name(),
                        "point_radii": point.to_array(),
                    });
                    let cause = match expected_light {
                        Some(light) if is_wrong => format!("the fraction of sunlight must be {light}: f32 {a:?}, f64 {b:?}"),
                        _ => format!("fraction of sunlight: f32 {a:?}, f64 {b:?}"),
                    };
                    (case, cause)
                });
            }
        }
    }
    Ok(found)
}

/// Greatest distance from the shadow's axis, in equatorial radii of Jupiter, at which a moon counts as deep in the umbra. At Ganymede's distance the polar
/// radius of the umbra is 0.92 equatorial radii, and Ganymede's own radius 0.04, so such a moon is entirely in the umbra.
const MAX_AXIS_DISTANCE_RADII: f64 = 0.8;

/// Duration of the search for a moon's passage through the shadow: longer than the periods of Io, Europa and Ganymede (172 hours).
const SEARCH_DURATION_S: f64 = 175.0 * 3600.0;

/// The instant, within [`SEARCH_DURATION_S`] after `start`, at which a moon is deepest in its planet's shadow, and the distance of its centre from the shadow's
/// axis, in equatorial radii of the planet. The distance is infinite if the moon is never behind the planet.
fn deepest_in_shadow(setup: &SweepSetup<'_>, moon: NaifId, planet: &Body, start: Instant) -> Result<(Instant, f64), SessionError> {
    let ephemeris = setup.session().ephemeris();
    let (mut deepest, mut least_distance_radii) = (start, f64::INFINITY);
    const STEP_S: f64 = 120.0;
    for k in 0..(SEARCH_DURATION_S / STEP_S) as u32 {
        let time = start.plus_seconds(STEP_S * f64::from(k));
        let moon_km = ephemeris.state(moon, planet.id, time, BEST_SOURCE)?.state.pos_km;
        let antisunward = -ephemeris.state(NaifId::SUN, planet.id, time, BEST_SOURCE)?.state.pos_km.normalize();
        let axis_distance_radii = moon_km.cross(antisunward).length() / planet.radii_km.x;
        if moon_km.dot(antisunward) > 0.0 && axis_distance_radii < least_distance_radii {
            (deepest, least_distance_radii) = (time, axis_distance_radii);
        }
    }
    Ok((deepest, least_distance_radii))
}

/// Greatest absolute radiance of any channel; NaN counts as the greatest.
fn greatest_radiance(hdr: &[[f32; 4]]) -> f64 {
    hdr.iter().flat_map(|p| p[..3].iter()).map(|v| f64::from(v.abs())).fold(0.0, larger_or_nan)
}

/// How many levels (1/255) the brightest byte of an image is above black. `radiance`: the image's greatest. If it is above 0 but too faint for a display level,
/// the result is 1; if it is not finite, infinite.
fn levels_above_black(radiance: f64, display: &[[u8; 4]]) -> f64 {
    let brightest = display.iter().flat_map(|p| p[..3].iter()).copied().max().unwrap_or(0);
    match radiance {
        0.0 => f64::from(brightest),
        _ if radiance.is_finite() => f64::from(brightest.max(1)),
        _ => f64::INFINITY,
    }
}

/// Moons deep in Jupiter's umbra at exposures from -20 to +25 stops: all bytes must be 0, in both precisions. The result is [`levels_above_black`].
pub(super) fn umbra_exposure(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    let session = setup.session();
    let Some(jupiter) = session.catalog().body(JUPITER) else { return Ok(found) };
    let effects = EffectOverrides::parse("+eclipse=limb-darkened,-planet-shine,-glow,-corona,-points,-atmosphere")?;
    for moon in [501, 502, 503].map(NaifId) {
        // The search begins on 2015-01-24.
        let (time, axis_distance_radii) = deepest_in_shadow(setup, moon, jupiter, Instant::from_jd_tdb(2_457_046.5))?;
        // Skip a moon that does not pass deep enough through the shadow.
        if axis_distance_radii > MAX_AXIS_DISTANCE_RADII {
            continue;
        }
        let Some((name, radius_km)) = session.catalog().body(moon).map(|b| (b.name.as_str(), b.radii_km.x)) else { continue };
        // The camera is on the Sun's side of the moon and looks along the axis of the shadow.
        let antisunward = -session.ephemeris().state(NaifId::SUN, moon, time, BEST_SOURCE)?.state.pos_km.normalize();
        let distance_km = 20.0 * radius_km;
        // The moon fills the frame: at this distance its disc has a diameter of 5.7 degrees.
        const FOV_DEG: f64 = 4.0;
        for stops in (-20..=25).step_by(setup.short_or_full(9, 1)) {
            let observation_time = time.plus_seconds(distance_km / SPEED_OF_LIGHT_KM_S);
            let request = ViewRequest {
                exposure: ExposureRequest::Stops(f64::from(stops)),
                layers: Layers { stars: false, ..Layers::default() },
                effects: effects.clone(),
                ..view_from_offset(moon, observation_time, -antisunward * distance_km, FOV_DEG, setup.short_or_full(24, 64))
            };
            let mut view = setup.plan_view(&request, SINGLE_SAMPLE)?;
            // Only the moon's draws, not Jupiter's.
            retain_draws(&mut view.plan, |label| label.starts_with(name));
            for precision in [Precision::F32, Precision::F64] {
                let (frame, _) = setup.renderers.renderer(precision).render(&view.plan, session.library(), FrameImages::DisplayAndHdr)?;
                let radiance = greatest_radiance(&frame.hdr);
                found.add(levels_above_black(radiance, &frame.display), || {
                    let case = json!({ "moon": moon.0, "stops": stops, "time": time.to_utc_iso(), "axis_radii": axis_distance_radii });
                    (case, format!("{precision:?}: radiance {radiance:e} in the umbra, where it must be 0"))
                });
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_that_is_too_faint_or_not_a_number_is_not_black() {
        let levels_of = |radiance: f32| levels_above_black(greatest_radiance(&[[0.0, radiance, 0.0, 1.0]]), &[[0, 0, 0, 255]]);
        assert_eq!([levels_of(0.0), levels_of(1e-30), levels_of(f32::NAN)], [0.0, 1.0, f64::INFINITY]);
    }
}
