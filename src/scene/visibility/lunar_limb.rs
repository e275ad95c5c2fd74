//! The Moon's limb profile in front of the Sun: the sunlight that the Moon leaves visible, and its silhouette in the draws of Moon and Sun.
//!
//! In: placed bodies and the user's height map. Out: the profile as seen from the camera, stored in the placed Moon ([`compute_profile`]); the visible
//! sunlight ([`visible_sunlight`]); features and uniforms of both draws ([`apply_to_moon`], [`apply_to_sun`]). Always: nothing changes without a height map,
//! or if the Moon does not touch the Sun's disc. Left out: relief on the Moon's disc, and the heights' effect on eclipsed bodies, whose sunlight follows from
//! the mean limb.

use crate::catalog::NaifId;
use crate::ephemeris::angle_rad;
use crate::ephemeris::limb_profile::{LIMB_POINTS, LimbProfile};
use crate::message::reason;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{AnchorForm, Camera, Placement, narrow, narrow_scalar};
use crate::scene::constants::{LIMB_COLUMNS, LIMB_ROWS};
use crate::scene::decision::Decision;
use crate::scene::draw::{BodyPart, Detail, Draw, LimbTable, LimbUniforms, Shape, Surface};
use crate::scene::eclipse::occluders::limb_darkening;
use crate::scene::placed::PlacedBody;
use crate::scene::visibility::limb_profiles::LimbProfileCache;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

// The table of the profile has one texel per point.
const _: () = assert!(LIMB_POINTS == LIMB_COLUMNS * LIMB_ROWS);
/// Smallest range of limb heights, in pixels, for which the profile is drawn.
const MIN_SPAN_PX: f64 = 0.25;
/// Largest sine of the angle at the camera between the Moon's centre and its limb, which keeps the tangent finite. The limit is not reached: a profile exists
/// only for cameras at least one radius above the Moon, where the sine is at most about 0.5.
const MAX_LIMB_SINE: f64 = 0.999;

/// Computes the limb profile as seen from the camera and stores it in the placed Moon, if a height map is given and the Moon may touch the Sun's disc.
pub(crate) fn compute_profile(placed: &mut [PlacedBody<'_>], profiles: &LimbProfileCache) {
    let index_of = |id: NaifId| placed.iter().position(|p| p.body.id == id);
    let (Some(moon), Some(sun)) = (index_of(NaifId::MOON), index_of(NaifId::SUN)) else { return };
    let (moon_placement, placed_sun) = (placed[moon].placement, &placed[sun]);
    let Some(map) = placed[moon].catalog.lunar_heights() else { return };
    let camera_in_moon_axes_km = moon_placement.body_from_icrf * -moon_placement.centre_km;
    let [_, max_km] = map.range_km();
    let moon_radius_rad = ((map.sphere_km() + max_km) / camera_in_moon_axes_km.length()).min(1.0).asin();
    let gap_rad = angle_rad(moon_placement.centre_km, placed_sun.placement.centre_km) - moon_radius_rad - placed_sun.angular_radius_rad();
    // The profile assumes that the camera is at least one radius above the Moon, and that the Moon is closer to the camera than the Sun.
    if gap_rad > 0.0 || camera_in_moon_axes_km.length() < 2.0 * map.sphere_km() || camera_in_moon_axes_km.length() > placed_sun.distance_km
    {
        return;
    }
    placed[moon].limb_profile = Some(profiles.seen_from(map, camera_in_moon_axes_km));
}

/// The limb profile in the camera's view. `position_angle_axes`: [`LimbProfile::position_angle_axes`] in ICRF, unit vectors perpendicular to the direction to
/// the Moon: towards the Moon's north (position angle 0), and a quarter turn counterclockwise from it as the camera sees it.
struct ApparentLimb<'p> {
    profile: &'p LimbProfile,
    position_angle_axes: [DVec3; 2],
    distance_km: f64,
}

impl<'p> ApparentLimb<'p> {
    fn of(profile: &'p LimbProfile, moon: &Placement) -> Self {
        let position_angle_axes = profile.position_angle_axes().map(|a| moon.body_from_icrf.transpose() * a);
        Self { profile, position_angle_axes, distance_km: moon.centre_km.length() }
    }

    /// Tangent of the angle at the camera between the Moon's centre and a limb point of this height.
    fn limb_angle_tan(&self, height_km: f64) -> f64 {
        let sine = ((self.profile.sphere_km() + height_km) / self.distance_km).min(MAX_LIMB_SINE);
        sine / (1.0 - sine * sine).sqrt()
    }
}

/// The fraction of the Sun's light that the Moon's limb profile leaves visible, per channel; exactly 0 if the Sun is completely hidden. `mean_limb_light`:
/// the fraction for a smooth limb of the Moon's catalog radius.
///
/// Computed in the plane tangent to the sky at the Moon's centre, where the Sun's outline is approximated by a circle. With the Sun at an angle theta from the
/// Moon's centre, the axis ratio of the true outline is 1 / cos theta: less than 1 + 5e-5 as seen from the Earth, and 1.16 one radius above the Moon.
pub(crate) fn visible_sunlight(profile: &LimbProfile, moon: &PlacedBody<'_>, sun: &PlacedBody<'_>, mean_limb_light: DVec3) -> DVec3 {
    let apparent_limb = ApparentLimb::of(profile, &moon.placement);
    let to_moon = moon.placement.centre_km.normalize();
    // The Sun's centre on the tangent plane.
    let to_sun = sun.placement.centre_km / sun.placement.centre_km.dot(to_moon);
    let sun_centre = DVec2::new(to_sun.dot(apparent_limb.position_angle_axes[0]), to_sun.dot(apparent_limb.position_angle_axes[1]));
    let sun_radius_tan = sun.angular_radius_rad().tan();
    let (u1, u2) = limb_darkening(sun.body);
    // The light of the entire disc, in units of the radiance of its centre times the square of its radius.
    let total = PI * (DVec3::ONE - u1 / 3.0 - u2 / 6.0);
    let mean_limb_tan = apparent_limb.limb_angle_tan(moon.body.radii_km.max_element() - profile.sphere_km());
    let (mut change, mut is_any_visible) = (DVec3::ZERO, false);
    for (k, height_km) in profile.heights_km().iter().enumerate() {
        let (sin, cos) = (TAU * k as f64 / LIMB_POINTS as f64).sin_cos();
        let radial = DVec2::new(cos, sin);
        // The Sun's disc on the ray from the Moon's centre at this position angle: the distances at which the ray enters and leaves it.
        let (along, offset_across) = (sun_centre.dot(radial), sun_centre.perp_dot(radial));
        let half_chord_sq = sun_radius_tan * sun_radius_tan - offset_across * offset_across;
        if half_chord_sq <= 0.0 {
            continue;
        }
        let (sun_entry, sun_exit) = (along - half_chord_sq.sqrt(), along + half_chord_sq.sqrt());
        let limb_tan = apparent_limb.limb_angle_tan(*height_km);
        is_any_visible |= sun_exit > limb_tan;
        // The light of the strip between profile and mean limb is gained if the profile is lower, and lost if it is higher.
        let (from, to) = (limb_tan.min(mean_limb_tan).max(sun_entry), limb_tan.max(mean_limb_tan).min(sun_exit));
        if to <= from {
            continue;
        }
        // The light per distance along the ray and per radian of position angle: radiance times r, because areas in polar coordinates are r dr dphi.
        let light_at = |r: f64| {
            let from_sun_centre = (radial * r - sun_centre) / sun_radius_tan;
            let mu = (1.0 - from_sun_centre.length_squared()).max(0.0).sqrt();
            (DVec3::ONE - u1 * (1.0 - mu) - u2 * (1.0 - mu).powi(2)) * r
        };
        // Simpson's rule suffices as seen from the Earth, where a strip is narrower than a hundredth of the Sun's radius. Near the Moon a strip may be as
        // wide as that radius, and the error was not measured.
        let strip = (light_at(from) + 4.0 * light_at(0.5 * (from + to)) + light_at(to)) * ((to - from) / 6.0);
        let sign = if limb_tan < mean_limb_tan { 1.0 } else { -1.0 };
        change += strip * (sign * TAU / LIMB_POINTS as f64 / (sun_radius_tan * sun_radius_tan));
    }
    if !is_any_visible {
        return DVec3::ZERO;
    }
    // At least one of Baily's beads is visible, so the result must not be zero.
    (mean_limb_light + change / total).clamp(DVec3::splat(f64::MIN_POSITIVE), DVec3::ONE)
}

/// Applies the stored profile to the Moon's draw, if the image resolves its heights; records the decision.
pub(crate) fn apply_to_moon(placed: &[PlacedBody<'_>], camera: &Camera, draws: &mut [Draw], bodies: &mut [BodyReport]) {
    let Some(moon) = placed.iter().find(|p| p.body.id == NaifId::MOON) else { return };
    let Some(profile) = moon.limb_profile.as_deref() else { return };
    let [min_km, max_km] = profile.range_km();
    // Approximation: the size of a pixel in the image's middle, at the distance of the Moon's centre. At the limb of a near Moon the span is up to 1.5 times as
    // large.
    let span_px = (max_km - min_km) / (moon.distance_km * camera.pixel_tangent());
    let draw = draws.iter_mut().find(|d| d.body == NaifId::MOON && d.part == BodyPart::Globe);
    let supports_limb_profile = |d: &Draw| d.features.shape == Shape::Sphere && d.features.eclipse.occluders == 0;
    let is_drawn = span_px >= MIN_SPAN_PX && draw.as_ref().is_some_and(|d| supports_limb_profile(d));
    let reason = reason!(
        "limb-heights",
        count = LIMB_POINTS,
        lowest = format_args!("{min_km:.2}"),
        highest = format_args!("{max_km:.2}"),
        size = format_args!("{span_px:.2}"),
        limit = MIN_SPAN_PX
    );
    let decision = Decision { effect: "limb-heights", on: is_drawn, reason, stated_error: None };
    bodies.iter_mut().filter(|b| b.id == NaifId::MOON).for_each(|b| b.decisions.push(decision.clone()));
    let Some(draw) = draw.filter(|_| is_drawn) else { return };
    // The Moon is in front of the Sun, so the camera sees its night side: this needs no procedural craters, and no average over pixels of a thin crescent.
    draw.features.detail = Detail::None;
    draw.features.thin_limb = false;
    draw.features.limb_heights = true;
    let radius_km = moon.body.radii_km.x;
    // In lunar radii, above the sphere of the Moon's radius.
    let height = |k: usize| (profile.sphere_km() + profile.heights_km()[k % LIMB_POINTS]) / radius_km - 1.0;
    let texels = (0..LIMB_POINTS).flat_map(|k| [height(k), height(k + 1) - height(k), 0.0, 0.0]).map(narrow_scalar).collect();
    let position_angle_axes = profile.position_angle_axes().map(|a| narrow(a).extend(0.0));
    draw.uniforms.limb = LimbUniforms { position_angle_axes, table: Some(Arc::new(LimbTable { texels })) };
    // The drawn rectangle must contain the highest peak; it is never smaller than the sphere's.
    let peak_radius_ratio = (profile.sphere_km() + max_km.max(0.0)) / radius_km;
    let placement_with_peaks = Placement { radii_km: moon.placement.radii_km * peak_radius_ratio.max(1.0), ..moon.placement };
    if let Some(rect) = Outline::of(camera, &placement_with_peaks).rect(camera) {
        let rays = camera.view_rays(&moon.placement, rect, AnchorForm::Auto);
        draw.uniforms = std::mem::take(&mut draw.uniforms).with_rays(&rays);
    }
}

/// Updates the reported features of bodies whose draws were changed.
pub(crate) fn update_features(draws: &[Draw], bodies: &mut [BodyReport]) {
    for changed in draws.iter().filter(|d| d.features.limb_heights) {
        let of_body = || draws.iter().filter(|d| d.body == changed.body).map(|d| d.features).collect();
        bodies.iter_mut().filter(|b| b.id == changed.body).for_each(|b| b.features = of_body());
    }
}

/// Applies the Moon's silhouette to the Sun's draw. `moon_limb`: the uniforms of [`apply_to_moon`]. `row`: index of the first of the Moon's three rows in the
/// shader's array `foreground_limb`. The coordinates x and y in these rows are pixels relative to an origin; `rays`: the view ray at this origin, and its
/// change per pixel in x and in y.
pub(crate) fn apply_to_sun(
    draw: &mut Draw,
    moon_limb: &LimbUniforms,
    moon: &PlacedBody<'_>,
    camera: &Camera,
    row: usize,
    rays: [DVec3; 3],
) {
    let (Some(profile), Some(_)) = (moon.limb_profile.as_deref(), &moon_limb.table) else { return };
    if draw.features.surface != Surface::Emissive || draw.features.shape != Shape::Sphere {
        return;
    }
    let apparent_limb = ApparentLimb::of(profile, &moon.placement);
    // Pixels per lunar radius of height at the limb: d tan(asin s) / ds = (1 - s^2)^(-3/2).
    let sine = (moon.body.radii_km.x / moon.distance_km).min(MAX_LIMB_SINE);
    let px_per_radius = sine / (1.0 - sine * sine).powf(1.5) / camera.pixel_tangent();
    // In the Sun's draw, a row has the view ray's component along a position-angle axis, as coefficients of 1, x, y in pixels. `w` has no part in it: the first
    // row's is `px_per_radius`, the second's is `row`.
    let limb_row = |k: usize, w: f64| {
        narrow(DVec3::from_array(rays.map(|ray| apparent_limb.position_angle_axes[k].dot(ray)))).extend(narrow_scalar(w))
    };
    draw.features.limb_heights = true;
    draw.uniforms.limb =
        LimbUniforms { position_angle_axes: [limb_row(0, px_per_radius), limb_row(1, row as f64)], table: moon_limb.table.clone() };
}
