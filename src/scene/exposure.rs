//! How bright the picture is: the exposure that is asked for, or one made for what is looked at.
//!
//! In: the request, the camera and the bodies where they are seen. Out: [`Exposure`] with its reason. Always: a body in another's shadow is exposed for
//! the light that is left there, but never so far that the light beside it, spread over the frame, exceeds [`MOST_BESIDE`] of white; and never less than
//! without the shadow. Left out beside it: rings, air, and shadows on the other bodies.

use super::camera::Camera;
use super::draw::PixelView;
use super::effects::Effect;
use super::request::{ExposureRequest, ViewRequest};
use super::silhouette::Outline;
use super::{Exposure, Placed, air, features, glow, legend, lights, photometry};
use crate::catalog::NaifId;
use crate::ephemeris::Ephemeris;
use crate::units::KM_PER_AU;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Radiance of a fully lit disc in its brightest channel, as a part of white, at automatic exposure: bright features of twice the mean
/// still differ, and a coloured body keeps its colour.
pub const AUTO_EXPOSED_MEAN: f64 = 0.5;
/// The same for the Sun, whose disc is what white is: its centre meets white and the darkened limb stays below.
pub const AUTO_EXPOSED_SUN: f64 = 0.85;
/// The faintest part of its sunlight for which the exposure of a body in a shadow opens: the Moon's light deep in the Earth's umbra.
const DARKEST_EXPOSED: f64 = 1e-5;
/// Light beside a body in a shadow for which the exposure opens no further: the mean of the frame without the body, as a part of white. A lit disc that takes
/// a fiftieth of the frame is then white and no more.
pub const MOST_BESIDE: f64 = 0.02;
/// Bodies that take more of the frame than this are summed over their ground by [`GRID`] x [`GRID`] rays: of smaller ones the whole disc's light does.
const WIDE_SHARE: f64 = 0.25;
const GRID: u32 = 48;

/// The automatic exposure shows the target's fully lit disc at [`AUTO_EXPOSED_MEAN`] of white; without a target in the frame, that of
/// the body that takes most pixels, the Sun last.
pub(super) fn exposure(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[Placed<'_>],
    air: Option<&air::Around<'_>>,
    ephemeris: &Ephemeris,
) -> Exposure {
    if let ExposureRequest::Stops(stops) = request.exposure {
        return Exposure { stops, reason: "asked for".into() };
    }
    match request.pixel_view {
        PixelView::Shaded => {}
        // White: a plane that faces the Sun at the target.
        PixelView::Sunlight => {
            let target = placed.iter().find(|p| Some(p.body.id) == request.target && p.body.id != NaifId::SUN);
            let irradiance = target.map_or(1.0, |p| lights::sunlight(p.sun_from_body_km).irradiance.x);
            return Exposure { stops: -irradiance.log2(), reason: "a plane that faces the Sun at the target is white".into() };
        }
        PixelView::Cost => {
            let stops = legend::COST_STOPS;
            return Exposure { stops, reason: format!("{:.0} instructions are white", (-stops).exp2()) };
        }
        _ => return Exposure { stops: 0.0, reason: "the picture shows a number: 1 is white".into() },
    }
    // Under a bright sky the eye settles on the sky, unless it is asked to look at something beyond, which the Sun is not.
    let drawn = request.effects.asked(Effect::Atmosphere) != Some(false);
    if let Some(air) = air.filter(|a| drawn && a.is_bright())
        && request.target.is_none_or(|t| t == NaifId::SUN || t == air.body.id)
        && let Some(p) = placed.iter().find(|p| p.body.id == air.body.id)
    {
        let level = air.level(p.sun_from_body_km);
        let stops = (AUTO_EXPOSED_MEAN / level.max(1e-30)).log2().clamp(-60.0, 60.0);
        return Exposure {
            stops,
            reason: format!("in the air of {}, a level of {level:.3e}, at {AUTO_EXPOSED_MEAN} of white", p.body.name),
        };
    }
    let Some(p) = subject(request, camera, placed) else {
        return Exposure { stops: 0.0, reason: "nothing in the frame: a white plane facing the Sun at 1 au is white".into() };
    };
    let radiance = if p.body.id == NaifId::SUN {
        photometry::sun_disc_radiance()
    } else {
        let from_afar = photometry::phase_correction(p.body, p.alpha, p.distance_km / p.body.radii_km.x);
        p.body.geometric_albedo * (KM_PER_AU / p.sun_from_body_km.length()).powi(2) * from_afar.max(0.01)
    };
    // In the shadow of another body it shows what light is left there.
    let diameter_px = 2.0 * (area_px(camera, p) / PI).sqrt();
    let (_, left) = features::dimming(request, ephemeris, p, diameter_px);
    let left = left.max(DARKEST_EXPOSED);
    let radiance = radiance * left;
    // A point spreads its light over the pixels of its sprite; a disc keeps its radiance.
    let brightest = f64::from(p.body.colour.max_element());
    let shown = radiance * brightest * (area_px(camera, p) * features::point_peak()).min(1.0);
    let stops_to = |mean: f64| (mean / shown.max(1e-30)).log2().clamp(-60.0, 60.0);
    let of = |how: &str, mean: f64| Exposure {
        stops: stops_to(mean),
        reason: format!("{} {how}, mean radiance {radiance:.3e}, at {mean} of white", p.body.name),
    };
    if p.body.id == NaifId::SUN {
        return of("shining", AUTO_EXPOSED_SUN);
    }
    if left >= 0.9 {
        return of("lit in full", AUTO_EXPOSED_MEAN);
    }
    let opened = -left.log2();
    let beside = light_beside(camera, placed, p);
    let held = (stops_to(AUTO_EXPOSED_MEAN) - (MOST_BESIDE / beside.max(1e-30)).log2()).clamp(0.0, opened);
    if held == 0.0 {
        return of("in eclipse", AUTO_EXPOSED_MEAN);
    }
    let reason = format!(
        "{} in eclipse, mean radiance {radiance:.3e}, opened by {:.1} of {opened:.1} stops for the light beside it",
        p.body.name,
        opened - held
    );
    Exposure { stops: stops_to(AUTO_EXPOSED_MEAN) - held, reason }
}

fn in_frame(camera: &Camera, p: &Placed<'_>) -> bool {
    p.outline.rect(camera).is_some()
}

fn frame_px(camera: &Camera) -> f64 {
    f64::from(camera.width) * f64::from(camera.height)
}

fn area_px(camera: &Camera, p: &Placed<'_>) -> f64 {
    match p.outline {
        Outline::Ellipse { area_px, .. } => area_px,
        Outline::Open => frame_px(camera),
        Outline::Behind | Outline::Beside => 0.0,
    }
}

/// What the exposure is made for.
fn subject<'p, 'b>(request: &ViewRequest, camera: &Camera, placed: &'p [Placed<'b>]) -> Option<&'p Placed<'b>> {
    let seen = || placed.iter().filter(|p| in_frame(camera, p));
    let largest = || {
        let not_sun = seen().filter(|p| p.body.id != NaifId::SUN).max_by(|a, b| area_px(camera, a).total_cmp(&area_px(camera, b)));
        not_sun.filter(|p| area_px(camera, p) >= 1.0).or(seen().find(|p| p.body.id == NaifId::SUN)).or(not_sun)
    };
    seen().find(|p| Some(p.body.id) == request.target).or_else(largest)
}

/// Mean radiance over the frame of all that is in it but one body.
fn light_beside(camera: &Camera, placed: &[Placed<'_>], subject: &Placed<'_>) -> f64 {
    let seen: Vec<&Placed<'_>> = placed.iter().filter(|p| in_frame(camera, p)).collect();
    let is_wide = |p: &Placed<'_>| p.body.id != NaifId::SUN && area_px(camera, p) > WIDE_SHARE * frame_px(camera);
    let wide: Vec<&Placed<'_>> = seen.iter().copied().filter(|p| is_wide(p)).collect();
    let others = seen.iter().filter(|p| p.body.id != subject.body.id && !is_wide(p));
    let of_small: f64 = others
        .map(|p| {
            let share = if p.body.id == NaifId::SUN {
                glow::part_seen(placed, p)
            } else {
                let middle = camera.clip(p.placement.centre_km).map(|c| nearest(camera, &wide, camera.pixel_from_clip(c)));
                f64::from(u8::from(!matches!(middle, Some(Some((w, _))) if w.distance_km < p.distance_km)))
            };
            share * in_frame_share(camera, p) * p.irradiance * PI / (camera.pixel_tangent().powi(2) * frame_px(camera))
        })
        .sum();
    let ground = |(p, hit): (&Placed<'_>, DVec3)| {
        if p.body.id == subject.body.id {
            return 0.0;
        }
        // A Lambert sphere is half as bright again at its middle as its geometric albedo.
        let sun = p.body_from_icrf * p.sun_from_body_km;
        let up = (hit / p.placement.radii_km).normalize();
        1.5 * p.body.geometric_albedo * (KM_PER_AU / sun.length()).powi(2) * up.dot(sun.normalize()).max(0.0)
    };
    let pixel = |k: u32| (DVec2::new(f64::from(k % GRID), f64::from(k / GRID)) + 0.5) * 2.0 * camera.half_size() / f64::from(GRID);
    let rays = if wide.is_empty() { 0 } else { GRID * GRID };
    let of_wide: f64 = (0..rays).filter_map(|k| nearest(camera, &wide, pixel(k))).map(ground).sum();
    of_small + of_wide / f64::from(GRID * GRID)
}

/// The nearest of some bodies under a pixel, and where it is met in its unit-sphere frame.
fn nearest<'p, 'b>(camera: &Camera, bodies: &[&'p Placed<'b>], pixel: DVec2) -> Option<(&'p Placed<'b>, DVec3)> {
    let met = bodies.iter().filter_map(|p| Some((*p, camera.surface_under_pixel(&p.placement, pixel)?)));
    let away_km = |(p, hit): &(&Placed<'_>, DVec3)| ((*hit - p.placement.camera_in_unit_sphere()) * p.placement.radii_km).length();
    met.min_by(|a, b| away_km(a).total_cmp(&away_km(b)))
}

/// About what part of a body's outline is in the frame: that of its bounding box.
fn in_frame_share(camera: &Camera, p: &Placed<'_>) -> f64 {
    let Outline::Ellipse { bounds, .. } = p.outline else { return 1.0 };
    let size = DVec2::new(bounds.right - bounds.left, bounds.top - bounds.bottom);
    // A point's sprite is two pixels wide.
    let size = size.max(2.0 / camera.half_size());
    let middle = 0.5 * DVec2::new(bounds.right + bounds.left, bounds.top + bounds.bottom);
    let inside = (DVec2::ONE.min(middle + 0.5 * size) - DVec2::NEG_ONE.max(middle - 0.5 * size)).max(DVec2::ZERO);
    (inside / size).element_product().min(1.0)
}
