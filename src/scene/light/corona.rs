//! The Sun's corona: how bright it is at a distance from the Sun's centre, how flat, and when it is drawn.
//!
//! In: the Sun where it is seen, what hides it, what is white, the date. Out: [`Corona`], the uniforms of shaders/entry/corona.wesl, and the reason; for
//! exposure and tests the law alone. It lies around the Sun: what is nearer hides it, the air before it dims it, and there is none on the Sun's disc. K and F
//! corona together, by Baumbach's law in every direction's mean; isophotes are flattened by Ludendorff's index, which swings with the cycle of sunspots. Left out:
//! streamers and the change of the mean brightness within a cycle (a factor of two between eclipses), prominences and chromosphere, and what a camera within
//! the corona sees: the law is that of an observer far outside. From 15 to 25 degrees from the Sun the zodiacal light
//! takes over (scene::sky::zodiacal).

use crate::catalog::NaifId;
use crate::scene::camera::{Camera, ClipRect, narrow, narrow_scalar};
use crate::scene::light::glow::{self, VEILING_GLARE};
use crate::scene::light::photometry::sun_disc_radiance;
use crate::scene::placed::PlacedBody;
use crate::scene::purpose::Bound;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::sky::zodiacal;
use crate::scene::thresholds::{VISIBLE_CHANGE, VISIBLE_LIGHT};
use crate::time::Instant;
use crate::units::KM_PER_AU;
use glam::{DVec3, Vec3, Vec4};

/// Radiance of the disc's centre over the disc's mean in the visual band: one over 1 - u1/3 - u2/6 with the catalog's limb darkening is 1.1 to 1.3;
/// Baumbach's figures count in units of the disc's centre.
const CENTRE_OVER_MEAN: f64 = 1.2;

/// Baumbach 1937, Astron. Nachr. 263, 121: factors and powers of the distance, of a millionth of the radiance of the disc's centre.
const TERMS: [(f64, f64); 3] = [(0.0532, 2.5), (1.425, 7.0), (2.565, 17.0)];

/// A Sun narrower than this many pixels has no corona that could be told from it.
const MIN_SUN_PX: f64 = 1.0;

/// Minima of the smoothed sunspot number, years (SILSO's dates of the beginnings of the cycles 11 to 25, to a month).
const MINIMA: [f64; 15] =
    [1867.2, 1879.0, 1890.2, 1902.1, 1913.6, 1923.6, 1933.7, 1944.1, 1954.3, 1964.8, 1976.2, 1986.7, 1996.6, 2008.9, 2019.9];
/// Before and after the table: the mean length of a cycle. Within 50 years of its ends the phase may be off by half a cycle.
const CYCLE_YEARS: f64 = 11.0;
/// Part of a cycle from minimum to maximum: 4.2 years of the mean 11. An estimate; single cycles lie between 0.25 and 0.5.
const RISE: f64 = 0.38;
/// Ludendorff's index at a minimum and at a maximum: the middles of 0.3 to 0.4 and 0.0 to 0.1 (Pishkalo 2023, Kinem. Phys. Celest. Bodies 39, 164: 69 eclipses of
/// 1851 to 2020). A single eclipse scatters about the line between by 0.06, an estimate from the correlation given there.
const INDEX: (f64, f64) = (0.35, 0.05);

/// Uniforms of the corona, and where it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corona {
    /// Left, top, right, bottom: what holds all light over [`VISIBLE_LIGHT`](crate::scene::thresholds::VISIBLE_LIGHT) of white.
    pub rect_in_clip: Vec4,
    /// How many of the scene's draws lie behind it.
    pub draws_behind: usize,
    pub middle: Vec3,
    pub across: Vec3,
    pub up: Vec3,
    pub radii_per_sine: f32,
    pub half_px: f32,
    pub flattening: f32,
    pub terms: Vec3,
    pub outer_cosine: f32,
    pub per_cosine: f32,
    pub colour: Vec3,
    /// Radiance that is taken away everywhere, so that nothing is left at the rectangle's edge; 0 for linear light.
    pub least: f32,
}

/// The terms at the limb, in units of a white plane's radiance that faces the Sun at 1 au.
fn terms() -> [(f64, f64); 3] {
    TERMS.map(|(factor, power)| (1e-6 * factor * CENTRE_OVER_MEAN * sun_disc_radiance(), power))
}

/// Mean radiance over the position angles at `rho` solar radii from the Sun's centre, in units of a white plane's that faces the Sun at 1 au; 0 on the disc.
pub fn radiance(rho: f64) -> f64 {
    if rho < 1.0 { 0.0 } else { terms().iter().map(|(factor, power)| factor * rho.powf(-power)).sum() }
}

/// How active the Sun is, by the phase of its cycle: 0 at a minimum of sunspots, 1 at a maximum.
pub fn activity(time: Instant) -> f64 {
    let year = 2000.0 + (time.jd_tt() - 2_451_545.0) / 365.25;
    let (first, last) = (MINIMA[0], MINIMA[MINIMA.len() - 1]);
    let phase = if (first..last).contains(&year) {
        let k = MINIMA.partition_point(|m| *m <= year).clamp(1, MINIMA.len() - 1);
        (year - MINIMA[k - 1]) / (MINIMA[k] - MINIMA[k - 1])
    } else {
        let past = if year < first { first } else { last };
        ((year - past) / CYCLE_YEARS).rem_euclid(1.0)
    };
    if phase < RISE { phase / RISE } else { (1.0 - phase) / (1.0 - RISE) }
}

/// Ludendorff's index a + b: by how much the isophote of two solar radii is wider along the equator than along the poles.
pub fn flattening(time: Instant) -> f64 {
    INDEX.0 + (INDEX.1 - INDEX.0) * activity(time)
}

/// Solar radii from the centre within which the corona is brighter than a radiance.
fn reach(least: f64) -> f64 {
    let (mut near, mut far) = (1.0_f64, 1e5_f64);
    for _ in 0..50 {
        let middle = (near * far).sqrt();
        if radiance(middle) > least { near = middle } else { far = middle }
    }
    far
}

/// Where it lies in the picture: all directions within so many sines of the Sun's.
fn rect(camera: &Camera, towards: DVec3, sine: f64) -> ClipRect {
    if sine >= 1.0 {
        return ClipRect::VIEWPORT;
    }
    let in_camera = DVec3::new(towards.dot(camera.right), towards.dot(camera.up), towards.dot(camera.forward));
    glow::reach(camera, in_camera, 2.0 * (0.5 * sine.asin()).sin())
}

/// The corona of a frame with its reason, where the catalog has a Sun before the camera. `tint`: colour that the air gives to light from beyond.
pub(crate) fn corona(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    bound: Bound,
    tint: impl Fn(DVec3) -> DVec3,
) -> Option<(Corona, bool, String)> {
    let sun = placed.iter().find(|p| p.body.id == NaifId::SUN && p.distance_km > p.body.radii_km.x)?;
    let towards = sun.placement.centre_km / sun.distance_km;
    let sine = sun.body.radii_km.x / sun.distance_km;
    // The pole is the third row of the rotation; from over a pole any direction will do, for there the corona is round to the eye, which the law does not know.
    let pole = sun.placement.body_from_icrf.row(2);
    let up = (pole - towards * pole.dot(towards)).try_normalize().unwrap_or_else(|| towards.any_orthonormal_vector());
    let tilt = pole.dot(towards).abs();
    let axes = |v: DVec3| DVec3::new(v.dot(towards.cross(up)), v.dot(up), v.dot(towards));
    let ahead = towards.dot(camera.forward).clamp(0.1, 1.0);
    let limb = radiance(1.0);
    // Its contours run from a half to twice the mean.
    let least = bound.least_shown(VISIBLE_LIGHT);
    let mut reach = reach(0.5 * least) * sine;
    // From so near that no zodiacal light is drawn it goes on.
    let [inner_cosine, outer_cosine] = if sun.distance_km < zodiacal::NEAREST_AU * KM_PER_AU {
        [-2.0, -3.0]
    } else {
        let (inner, outer) = zodiacal::HANDOVER_DEG;
        reach = reach.min(outer.to_radians().sin());
        [inner, outer].map(|deg| deg.to_radians().cos())
    };
    let rect = rect(camera, towards, reach);
    if rect.left >= rect.right || rect.bottom >= rect.top {
        return None;
    }
    let sun_px = 2.0 * sine / camera.pixel_tangent();
    let has_glare = request.effects.override_of(Effect::Glow) != Some(false);
    let irradiance = (KM_PER_AU / sun.distance_km).powi(2);
    let glare =
        if has_glare { VEILING_GLARE * irradiance * glow::part_seen(placed, sun) / sine.max(camera.pixel_tangent()).powi(2) } else { 0.0 };
    // Under glare it is told from it by the same part as from white.
    let on = sun_px >= MIN_SUN_PX && bound.counts(limb - VISIBLE_CHANGE * glare);
    let reason = if sun_px < MIN_SUN_PX {
        format!("the Sun is {sun_px:.2} px across against {MIN_SUN_PX}")
    } else {
        let index = flattening(request.time);
        let drowned = if glare > 0.0 { format!(", under glare {:.1e} times as bright", glare / limb) } else { String::new() };
        format!("beside the limb it is {}{drowned}; flattened by {index:.2} at 2 radii", bound.description(limb))
    };
    let narrowed = |v: DVec3| narrow(axes(v));
    let corona = Corona {
        rect_in_clip: Vec4::from_array([rect.left, rect.top, rect.right, rect.bottom].map(narrow_scalar)),
        draws_behind: 0,
        middle: narrowed(camera.forward),
        across: narrowed(camera.right * camera.tan_half_fov.x),
        up: narrowed(camera.up * camera.tan_half_fov.y),
        radii_per_sine: narrow_scalar(1.0 / sine),
        half_px: narrow_scalar(0.5 * camera.pixel_tangent() * ahead * ahead / sine),
        // Seen from over a pole an equatorial belt is a ring.
        flattening: narrow_scalar(flattening(request.time) * (1.0 - tilt * tilt)),
        terms: narrow(DVec3::from_array(terms().map(|(factor, _)| factor))),
        outer_cosine: narrow_scalar(outer_cosine),
        per_cosine: narrow_scalar(1.0 / (inner_cosine - outer_cosine)),
        colour: sun.body.colour * narrow(tint(sun.placement.centre_km)),
        least: narrow_scalar(least),
    };
    Some((corona, on, reason))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// The whole corona beyond 1.03 radii is about half a full Moon: 0.5e-6 to 1.5e-6 of the Sun's light (Allen's Astrophysical Quantities, 4th ed., 14.8).
    #[test]
    fn all_of_it_is_about_a_millionth_of_the_sun() {
        let rings = 20_000;
        let step = 9.0 / f64::from(rings);
        let total: f64 = (0..rings).map(|k| 1.03 + (f64::from(k) + 0.5) * step).map(|rho| radiance(rho) * TAU * rho * step).sum();
        let part = total / (PI * sun_disc_radiance());
        assert!((0.5e-6..2e-6).contains(&part), "{part:e}");
    }

    #[test]
    fn it_fades_outward_and_is_nothing_on_the_disc() {
        assert_eq!(radiance(0.99), 0.0);
        let falls = (0..100).map(|k| 1.0 + f64::from(k) * 0.1).collect::<Vec<_>>();
        assert!(falls.windows(2).all(|w| radiance(w[0]) > radiance(w[1])));
        for least in [1e-1, 1e-3, 1e-6, 1e-9] {
            let rho = reach(least);
            assert!(radiance(rho) <= least && radiance(0.999 * rho) > least, "{least}: {rho}");
        }
    }

    /// Over every date that the program takes: within the index's range, without a jump, flat at minima and round at maxima.
    #[test]
    fn the_cycle_runs_without_a_jump() {
        let at = |year: f64| Instant::from_jd_tt(2_451_545.0 + (year - 2000.0) * 365.25);
        let months = (1000 * 12..2900 * 12).map(|m| f64::from(m) / 12.0);
        let all: Vec<f64> = months.map(|y| flattening(at(y))).collect();
        assert!(all.iter().all(|f| (0.05..=0.35).contains(f)));
        assert!(all.windows(2).all(|w| (w[1] - w[0]).abs() < 0.012), "a month changes it by no more than a steep rise does");
        for m in MINIMA {
            assert!(flattening(at(m)) > 0.345, "{m}");
        }
        // Eclipses at maxima were round (1980, 2001, 2024), at minima long (1954, 1994 to 1998 before and after, 2019).
        for (year, round) in [(1980.1, true), (2001.5, true), (2024.27, true), (1954.5, false), (1995.8, false), (2019.5, false)] {
            assert_eq!(flattening(at(year)) < 0.15, round, "{year}");
        }
    }
}
