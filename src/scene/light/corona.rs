//! The Sun's corona: its radiance as a function of distance from the Sun's centre, its flattening, and whether it is drawn.
//!
//! In: the apparent position of the Sun, the threshold, the date, the glare that the frame draws. Out: [`Corona`], the uniforms of shaders/entry/corona.wesl,
//! and the reason; for the light meter, the corona's weight and its radiance law. The corona is drawn around the Sun, not on its disc; nearer bodies hide it,
//! and the air in front reddens each line of sight by its own path. A body of less than four pixels is drawn as a point (`scene::point`), wholly or in part; so
//! is the inner corona of such a Sun (`InnerPart`), which keeps its light: in totality about half that of the full Moon, however small the image. The corona is
//! left out if it changes the glare by less than the threshold. A Sun far outside the image has no glare (`glare`), so its corona is drawn. While the Sun comes
//! nearer the glare grows; once the corona makes no visible difference beside it, it is left out. The light meter counts a corona under the same conditions,
//! so that no image is exposed for one that is not drawn. K corona (light scattered by electrons) and F corona (by dust) are combined: averaged over position
//! angle they follow Baumbach's law, and isophotes are flattened by Ludendorff's index, which varies with the sunspot cycle. From 15 to 25 degrees from the Sun
//! the corona fades into the zodiacal light (scene::sky::zodiacal). Left out: streamers; the change of the mean brightness within a cycle (a factor of two
//! between eclipses); prominences and chromosphere; the view from inside the corona, because the law is that of an observer far outside.

use crate::catalog::NaifId;
use crate::ephemeris::angle_rad;
use crate::message::{Reason, reason};
use crate::scene::atmosphere::tint_table::{FrameTints, TINT_STEPS, TintTable};
use crate::scene::camera::{Camera, ClipRect, narrow, narrow_scalar};
use crate::scene::features::inputs;
use crate::scene::light::glare::{self, VeilingGlare};
use crate::scene::light::meter::geometry::visible_fraction_behind_body;
use crate::scene::light::photometry::sun_disc_radiance;
use crate::scene::numeric::smoothstep;
use crate::scene::placed::PlacedBody;
use crate::scene::point::{MIN_POINT_RADIUS_PX, drawn_disc_fraction, pixel_sr, point_peak};
use crate::scene::purpose::Threshold;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::sky::zodiacal;
use crate::scene::thresholds::VISIBLE_LIGHT;
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, KM_PER_AU};
use glam::{DVec3, FloatExt, Vec3, Vec4};
use std::f64::consts::{PI, TAU};

/// Ratio of the radiance at the disc's centre to the disc's mean radiance in the visual band, rounded. Baumbach's figures are in units of the radiance at the
/// centre. With the catalog's limb darkening the ratio, 1 / (1 - u1/3 - u2/6), is 1.21 in red, 1.24 in green and 1.31 in blue.
const CENTRE_TO_MEAN_RATIO: f64 = 1.2;

/// Baumbach 1937, Astron. Nachr. 263, 121: coefficients, in millionths of the radiance of the disc's centre, and exponents of 1 / distance.
const BAUMBACH_TERMS: [(f64, f64); 3] = [(0.0532, 2.5), (1.425, 7.0), (2.565, 17.0)];

/// Upper bound of the ratio of the radiance to its mean over position angle. The law of shaders/entry/corona.wesl gives 0.26 to 2.24 at a sunspot minimum and
/// two solar radii.
const MAX_TO_MEAN_RATIO: f64 = 2.25;

/// Smallest diameter of the Sun, in pixels, at which its corona can be distinguished from a disc that is brighter.
const MIN_SUN_PX: f64 = 1.0;

/// Light of the corona relative to the Sun's, rounded.
const CORONA_TO_SUN_LIGHT: f64 = 1e-6;

/// Number of rings of the inner corona whose hidden parts are evaluated. The rings are narrowest at the limb, where the light falls fastest.
const INNER_RINGS: u32 = 48;

/// Dates of sunspot minima, years (SILSO's starts of cycles 11 to 25, to a month).
const SUNSPOT_MINIMA: [f64; 15] =
    [1867.2, 1879.0, 1890.2, 1902.1, 1913.6, 1923.6, 1933.7, 1944.1, 1954.3, 1964.8, 1976.2, 1986.7, 1996.6, 2008.9, 2019.9];
/// Mean length of a cycle, used before and after the table. Fifty years beyond the table the phase may already be off by half a cycle.
const MEAN_CYCLE_YEARS: f64 = 11.0;
/// Fraction of a cycle from minimum to maximum: 4.2 of 11 years on average. An estimate; single cycles lie between 0.25 and 0.5.
const RISE_FRACTION: f64 = 0.38;
/// Ludendorff's index at a minimum and at a maximum: the middles of 0.3 to 0.4 and 0.0 to 0.1 (Pishkalo 2023, Kinem. Phys. Celest. Bodies 39, 164: 69
/// eclipses of 1851 to 2020). Single eclipses scatter about the line between them by 0.06, an estimate from the correlation given there.
const LUDENDORFF_INDEX: (f64, f64) = (0.35, 0.05);

/// Uniforms of the corona, and where it is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corona {
    /// Left, top, right, bottom of the rectangle that contains all radiance above [`VISIBLE_LIGHT`] of the display's white.
    pub rect_in_clip: Vec4,
    /// Number of the scene's draws that lie behind the corona and are drawn before it.
    pub draw_count_behind: usize,
    /// View ray whose component along the camera's forward axis is 1, through the middle of the image. Axes: x and y across the line of sight to the Sun, y
    /// towards the Sun's north pole; z to the Sun's centre.
    pub middle: Vec3,
    /// Change of the view ray from the middle of the image to its right edge, and to its upper edge.
    pub right: Vec3,
    pub up: Vec3,
    /// 1 over the sine of the Sun's angular radius.
    pub radii_per_sine: f32,
    /// Half a pixel, in solar radii.
    pub half_pixel_radii: f32,
    /// Distance from the Sun's centre, in solar radii, within which the radiance is `inner_radiance` (on the Sun's disc, too), because a point has the rest of
    /// the light there ([`Self::point_flux`]). 1 and 0 for a Sun that is drawn only as a disc.
    pub inner_radius: f32,
    pub inner_radiance: f32,
    /// Ludendorff's index as seen from the camera.
    pub flattening: f32,
    /// Radiance of each of Baumbach's terms at the limb.
    pub terms: Vec3,
    /// The corona fades between two elongations. Cosine of the outer one, at which it has faded out; and 1 / (cosine of the inner one - cosine of the outer
    /// one).
    pub outer_cosine: f32,
    pub inverse_fade_width: f32,
    /// The Sun's colour.
    pub colour: Vec3,
    /// The view rays in the axes of the air's tints, whose z axis is the zenith: through the middle of the image, and their changes to the right and the upper
    /// edge.
    pub air_middle: Vec3,
    pub air_right: Vec3,
    pub air_up: Vec3,
    /// Sine of the altitude of the first tint, and the tints from there to the zenith (rgb); 1 outside all air. The draw of the air, blended over the corona,
    /// dims it by the mean over the channels.
    pub horizon_sine: f32,
    pub tints: [Vec4; TINT_STEPS + 1],
    /// Flux of the light that is added to the point of a small Sun, dimmed by the air and by bodies in front; linear RGB, 0 for a Sun drawn only as a disc.
    pub point_flux: Vec3,
    /// Radiance that is subtracted everywhere, so that the light falls to zero at the rectangle's edge; 0 for linear light.
    pub cutoff: f32,
}

/// Baumbach's factors and exponents; the factors in units of the radiance of a white plane that faces the Sun at 1 au.
fn terms() -> [(f64, f64); 3] {
    BAUMBACH_TERMS.map(|(factor, power)| (1e-6 * factor * CENTRE_TO_MEAN_RATIO * sun_disc_radiance(), power))
}

/// Radiance at `rho` solar radii from the Sun's centre, averaged over position angle, in units of a white plane that faces the Sun at 1 au; 0 on the disc.
pub fn radiance(rho: f64) -> f64 {
    if rho < 1.0 { 0.0 } else { terms().iter().map(|(factor, power)| factor * rho.powf(-power)).sum() }
}

/// Light of the corona between two distances from the Sun's centre: radiance times area, in squared solar radii. `from`, `to`: solar radii, at least 1.
fn light_between(from: f64, to: f64) -> f64 {
    // The integral of 2 pi r r^-n.
    let of_term = |(factor, power): &(f64, f64)| factor * TAU / (power - 2.0) * (from.powf(2.0 - power) - to.powf(2.0 - power));
    terms().iter().map(of_term).sum()
}

/// The size of the Sun in the image.
struct SunInImage {
    /// In the same measure as for the Sun's point.
    diameter_px: f64,
    sine_of_radius: f64,
    /// Fraction of the Sun's light that is drawn as a disc; the rest is drawn as a point.
    disc_fraction: f64,
    /// Half a pixel, in solar radii.
    half_pixel_radii: f64,
    /// Solid angle of a pixel.
    pixel_sr: f64,
}

impl SunInImage {
    fn of(request: &ViewRequest, camera: &Camera, sun: &PlacedBody<'_>) -> Self {
        let towards = sun.placement.centre_km / sun.distance_km;
        let sine_of_radius = sun.body.radii_km.x / sun.distance_km;
        let diameter_px = inputs::diameter_px(camera, sun);
        // The lower limit is for a Sun beside the frame.
        let cos_off_axis = towards.dot(camera.forward).clamp(0.1, 1.0);
        Self {
            diameter_px,
            sine_of_radius,
            disc_fraction: drawn_disc_fraction(request.effects.override_of_body(sun.body, Effect::Points), sun, diameter_px),
            half_pixel_radii: 0.5 * camera.pixel_tangent() * cos_off_axis * cos_off_axis / sine_of_radius,
            pixel_sr: pixel_sr(camera, towards),
        }
    }

    /// Flux of a light given as radiance times area in squared solar radii.
    fn flux(&self, light: f64) -> f64 {
        light * self.sine_of_radius * self.sine_of_radius / self.pixel_sr
    }

    /// Radius of a point's sprite, in solar radii.
    fn sprite_radii(&self) -> f64 {
        2.0 * MIN_POINT_RADIUS_PX * self.half_pixel_radii
    }

    /// Radiance of the brightest pixel around a Sun without anything in front of it: next to the limb, or of the point.
    fn peak_radiance(&self) -> f64 {
        let of_point = self.flux(light_between(1.0, self.sprite_radii().max(1.0))) * point_peak();
        of_point.lerp(radiance(1.0), self.disc_fraction)
    }
}

/// The inner corona of a small Sun, of whose light a point has the greater part. In the draw of the corona each pixel shows the light at its own distance from
/// the Sun's centre; where the light falls by half within a fraction of a pixel, its sum would depend on the position of the Sun in its pixel.
struct InnerPart {
    /// Outer edge, solar radii: a sprite's radius, or less while a disc gradually replaces the point; 1 without a point.
    radius: f64,
    /// Radiance within the edge in the draw of the corona.
    radiance: f64,
}

impl InnerPart {
    fn of(sun: &SunInImage) -> Self {
        let point_fraction = 1.0 - sun.disc_fraction;
        let radius = 1.0 + point_fraction * (sun.sprite_radii() - 1.0).max(0.0);
        Self { radius, radiance: point_fraction * radiance(radius) }
    }

    /// The light of the point: what the draw of the corona lacks. Radiance times area, in squared solar radii. `visible_fraction`: that of a disc of this
    /// radius, in solar radii, around the Sun's centre.
    fn point_light(&self, visible_fraction: impl Fn(f64) -> f64) -> f64 {
        if self.radius <= 1.0 {
            return 0.0;
        }
        // Radius, area and visible area within the inner edge of a ring.
        let edge = |k: u32| {
            let radius = 1.0 + (self.radius - 1.0) * (f64::from(k) / f64::from(INNER_RINGS)).powi(3);
            let area = PI * radius * radius;
            (radius, area, area * visible_fraction(radius))
        };
        let (mut light, mut inner) = (0.0, edge(0));
        for k in 1..=INNER_RINGS {
            let outer = edge(k);
            let area = outer.1 - inner.1;
            let visible = ((outer.2 - inner.2) / area).clamp(0.0, 1.0);
            light += visible * (light_between(inner.0, outer.0) - self.radiance * area);
            inner = outer;
        }
        light
    }
}

/// Solar activity by the phase of the sunspot cycle: 0 at a minimum, 1 at a maximum.
pub(crate) fn activity(time: Instant) -> f64 {
    let year = 2000.0 + (time.jd_tt() - 2_451_545.0) / DAYS_PER_JULIAN_YEAR;
    let (first, last) = (SUNSPOT_MINIMA[0], SUNSPOT_MINIMA[SUNSPOT_MINIMA.len() - 1]);
    let phase = if (first..last).contains(&year) {
        let k = SUNSPOT_MINIMA.partition_point(|m| *m <= year).clamp(1, SUNSPOT_MINIMA.len() - 1);
        (year - SUNSPOT_MINIMA[k - 1]) / (SUNSPOT_MINIMA[k] - SUNSPOT_MINIMA[k - 1])
    } else {
        let nearest_minimum = if year < first { first } else { last };
        ((year - nearest_minimum) / MEAN_CYCLE_YEARS).rem_euclid(1.0)
    };
    if phase < RISE_FRACTION { phase / RISE_FRACTION } else { (1.0 - phase) / (1.0 - RISE_FRACTION) }
}

/// Ludendorff's index a + b: the flattening of the isophote at two solar radii.
pub fn flattening(time: Instant) -> f64 {
    let (at_minimum, at_maximum) = LUDENDORFF_INDEX;
    at_minimum + (at_maximum - at_minimum) * activity(time)
}

/// Distance from the Sun's centre, in solar radii, within which the corona is brighter than `min_radiance`; at most 1e5 (465 au).
fn radius_at_radiance(min_radiance: f64) -> f64 {
    let (mut near, mut far) = (1.0_f64, 1e5_f64);
    for _ in 0..50 {
        let middle = (near * far).sqrt();
        if radiance(middle) > min_radiance { near = middle } else { far = middle }
    }
    far
}

/// The rectangle in the image that contains all directions within an angle of the direction `towards`; the angle is given by its sine.
fn rect(camera: &Camera, towards: DVec3, sine: f64) -> ClipRect {
    if sine >= 1.0 {
        return ClipRect::VIEWPORT;
    }
    glare::rect_around(camera, camera.in_axes(towards), 2.0 * (0.5 * sine.asin()).sin())
}

/// Radiance of the corona where it is brightest, minus the smallest visible change of the glare's radiance at the limb. `peak_radiance`:
/// [`SunInImage::peak_radiance`]; `min_change`: this change relative to the glare; `glare`: the glare that the frame draws, if any. If the Sun is partly
/// hidden, the limb opposite the visible part counts, because the corona shows there first.
fn excess_over_glare(peak_radiance: f64, min_change: f64, glare: Option<&VeilingGlare>) -> f64 {
    peak_radiance - min_change * glare.map_or(0.0, VeilingGlare::limb_radiance)
}

/// Cosines of the elongations between which the corona fades into the zodiacal light. `None` for a camera nearer to the Sun than [`zodiacal::NEAREST_AU`], for
/// which no zodiacal light is drawn.
pub(crate) fn fade_cosines(sun_distance_km: f64) -> Option<[f64; 2]> {
    let (inner_deg, outer_deg) = zodiacal::CORONA_BLEND_DEG;
    let is_far = sun_distance_km >= zodiacal::NEAREST_AU * KM_PER_AU;
    is_far.then(|| [inner_deg, outer_deg].map(|deg| deg.to_radians().cos()))
}

/// How much the corona differs from the visible part of the Sun's disc: 0 where the disc outshines it in the same pixel. Beside a Sun of at least
/// [`MIN_SUN_PX`] the corona has pixels of its own; the result rises from 0 to 1 up to twice that diameter. The corona of a smaller Sun can be seen once bodies
/// in front hide all of the disc but a part whose light the corona changes by `min_change`. `visible_fraction`: that of the disc's light.
fn contrast_with_disc(diameter_px: f64, visible_fraction: f64, min_change: f64) -> f64 {
    let by_size = smoothstep(diameter_px / MIN_SUN_PX - 1.0);
    by_size.max(smoothstep(1.0 - min_change * visible_fraction / CORONA_TO_SUN_LIGHT))
}

/// Weight of the corona for the light meter: 0 where [`corona`] leaves it out at any exposure. So that the exposure does not jump, the weight grows with
/// [`contrast_with_disc`]. Where the glare decides, the corona's contrast is so low that its weight needs no transition.
pub(crate) fn meter_weight(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    sun: &PlacedBody<'_>,
    glare: Option<&VeilingGlare>,
) -> f64 {
    if let Some(on) = request.effects.override_of_body(sun.body, Effect::Corona) {
        return f64::from(u8::from(on));
    }
    let (in_image, min_change) = (SunInImage::of(request, camera, sun), request.purpose.min_change());
    if excess_over_glare(in_image.peak_radiance(), min_change, glare) <= 0.0 {
        return 0.0;
    }
    contrast_with_disc(in_image.diameter_px, glare::visible_fraction(placed, sun), min_change)
}

/// Fraction of a disc around the Sun's centre that nearer bodies leave visible. `radii`: radius of the disc in solar radii. `nearer`: the bodies in front.
fn visible_fraction_of_disc(nearer: &[&PlacedBody<'_>], towards: DVec3, radii: f64, sine_of_radius: f64) -> f64 {
    let radius_rad = (radii * sine_of_radius).min(1.0).asin();
    nearer.iter().map(|p| visible_fraction_behind_body(&p.placement, towards, radius_rad)).product()
}

/// The corona of a frame, whether it is visible, and the reason; `None` if it is outside the image or the camera is inside the Sun. `glare`: the glare
/// that the frame draws. `frame_tints`: of the air around the camera.
pub(crate) fn corona(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[PlacedBody<'_>],
    threshold: Threshold,
    glare: Option<&VeilingGlare>,
    frame_tints: &FrameTints<'_>,
) -> Option<(Corona, bool, Reason)> {
    let sun = placed.iter().find(|p| p.body.id == NaifId::SUN && p.distance_km > p.body.radii_km.x)?;
    let towards = sun.placement.centre_km / sun.distance_km;
    let in_image = SunInImage::of(request, camera, sun);
    let sin_sun_radius = in_image.sine_of_radius;
    // The pole is the third row of the rotation. Seen from above a pole the corona is round, so any direction can be up.
    let pole = sun.placement.body_from_icrf.row(2);
    let up = (pole - towards * pole.dot(towards)).try_normalize().unwrap_or_else(|| towards.any_orthonormal_vector());
    let sin_camera_latitude = pole.dot(towards).abs();
    let in_sun_axes = |v: DVec3| DVec3::new(v.dot(towards.cross(up)), v.dot(up), v.dot(towards));
    let peak_radiance = in_image.peak_radiance();
    let cutoff = threshold.cutoff_radiance(VISIBLE_LIGHT);
    // `radiance` is a mean over position angle; the flattened corona is brighter at its equator.
    let mut sin_corona_radius = radius_at_radiance(cutoff / MAX_TO_MEAN_RATIO) * sin_sun_radius;
    let fade_cosines = fade_cosines(sun.distance_km);
    if fade_cosines.is_some() {
        let (_, outer_deg) = zodiacal::CORONA_BLEND_DEG;
        sin_corona_radius = sin_corona_radius.min(outer_deg.to_radians().sin());
    }
    // No direction has a cosine below -1, so this corona does not fade.
    let [inner_cosine, outer_cosine] = fade_cosines.unwrap_or([-2.0, -3.0]);
    let rect = rect(camera, towards, sin_corona_radius);
    if rect.left >= rect.right || rect.bottom >= rect.top {
        return None;
    }
    let (sun_px, min_change) = (in_image.diameter_px, threshold.min_change());
    let is_distinct = sun_px >= MIN_SUN_PX || contrast_with_disc(sun_px, glare::visible_fraction(placed, sun), min_change) > 0.0;
    // The corona must exceed the sum of the threshold on black and the smallest visible change of the glare.
    let on = is_distinct && threshold.is_exceeded_by_radiance(excess_over_glare(peak_radiance, min_change, glare));
    let reason = if is_distinct {
        let index = flattening(request.time);
        let light = threshold.radiance_description(peak_radiance);
        let glare_radiance = glare.map_or(0.0, VeilingGlare::limb_radiance);
        let limb_reason = if glare_radiance > 0.0 {
            reason!("corona-under-glare", light = light, times = format_args!("{:.1e}", glare_radiance / peak_radiance))
        } else {
            reason!("corona-limb", light = light)
        };
        limb_reason.and(reason!("corona-flattened", index = format_args!("{index:.2}")))
    } else {
        reason!("corona-sun-small", size = format_args!("{sun_px:.2}"), threshold = MIN_SUN_PX)
    };
    let inner = InnerPart::of(&in_image);
    let inner_edge_rad = (inner.radius * sin_sun_radius).min(1.0).asin();
    let may_hide_inner_part = |p: &&PlacedBody<'_>| {
        p.body.id != NaifId::SUN
            && p.distance_km < sun.distance_km
            && p.distance_km > 0.0
            && !p.placement.camera_is_inside()
            && angle_rad(p.placement.centre_km, towards) < p.angular_radius_rad() + inner_edge_rad
    };
    let nearer: Vec<_> = placed.iter().filter(may_hide_inner_part).collect();
    let point_light = inner.point_light(|radii| visible_fraction_of_disc(&nearer, towards, radii, sin_sun_radius));
    // Points are drawn after the air, so its transmittance is applied here.
    let transmittance = frame_tints.air.map_or(DVec3::ONE, |a| a.transmittance(towards));
    // The table takes the depth of the air along many rays; by day nothing reads it.
    let is_drawn = request.effects.override_of_body(sun.body, Effect::Corona).unwrap_or(on);
    let tints_if_drawn = if is_drawn { frame_tints.table() } else { None };
    let without_air = TintTable::of(None);
    let tints = tints_if_drawn.unwrap_or(&without_air);
    let in_air_axes = |v: DVec3| narrow(tints.in_axes(v));
    let camera_axes = [camera.forward, camera.right * camera.tan_half_fov.x, camera.up * camera.tan_half_fov.y];
    let [middle, right, up] = camera_axes.map(|v| narrow(in_sun_axes(v)));
    let [air_middle, air_right, air_up] = camera_axes.map(in_air_axes);
    let corona = Corona {
        rect_in_clip: rect.of_whole_pixels(camera.half_size_px()).narrowed(),
        draw_count_behind: 0,
        middle,
        right,
        up,
        radii_per_sine: narrow_scalar(1.0 / sin_sun_radius),
        half_pixel_radii: narrow_scalar(in_image.half_pixel_radii),
        inner_radius: narrow_scalar(inner.radius),
        inner_radiance: narrow_scalar(inner.radiance),
        // The corona is concentrated around the Sun's equator, so it looks round from above a pole.
        flattening: narrow_scalar(flattening(request.time) * (1.0 - sin_camera_latitude * sin_camera_latitude)),
        terms: narrow(DVec3::from_array(terms().map(|(factor, _)| factor))),
        outer_cosine: narrow_scalar(outer_cosine),
        inverse_fade_width: narrow_scalar(1.0 / (inner_cosine - outer_cosine)),
        colour: sun.body.colour,
        air_middle,
        air_right,
        air_up,
        horizon_sine: narrow_scalar(tints.horizon_sine),
        tints: tints.tints.map(|tint| narrow(tint).extend(0.0)),
        point_flux: sun.body.colour * narrow(transmittance * in_image.flux(point_light)),
        cutoff: narrow_scalar(cutoff),
    };
    Some((corona, on, reason))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The light of the corona beyond 1.03 radii (here out to 10) is about half that of the full Moon: 0.5e-6 to 1.5e-6 of the Sun's light (Allen's
    /// Astrophysical Quantities, 4th ed., 14.8). The test allows up to 2e-6.
    #[test]
    fn the_total_light_is_about_a_millionth_of_the_sun() {
        let steps = 20_000;
        let step = 9.0 / f64::from(steps);
        let total: f64 = (0..steps).map(|k| 1.03 + (f64::from(k) + 0.5) * step).map(|rho| radiance(rho) * TAU * rho * step).sum();
        let fraction = total / (PI * sun_disc_radiance());
        assert!((0.5e-6..2e-6).contains(&fraction), "{fraction:e}");
    }

    /// The point of a small Sun and the draw of the corona together have the light between limb and inner edge, by a sum over the law. A body that hides half
    /// of every ring hides half of the point; a Sun that is drawn as a disc has no point.
    #[test]
    fn point_and_draw_of_the_inner_corona_have_its_light() {
        let inner_part = |half_pixel_radii: f64, disc_fraction: f64| {
            InnerPart::of(&SunInImage { diameter_px: 1.0, sine_of_radius: 0.0047, disc_fraction, half_pixel_radii, pixel_sr: 1e-6 })
        };
        for (half_pixel_radii, disc_fraction) in [(0.3, 0.7), (0.5, 0.0), (1.0, 0.0), (50.0, 0.0)] {
            let inner = inner_part(half_pixel_radii, disc_fraction);
            let steps = 100_000;
            // Even steps of the logarithm of the distance.
            let step = inner.radius.ln() / f64::from(steps);
            let ring = |k: i32| ((f64::from(k) + 0.5) * step).exp();
            let expected: f64 = (0..steps).map(|k| radiance(ring(k)) * TAU * ring(k) * ring(k) * step).sum();
            let (point, half_hidden) = (inner.point_light(|_| 1.0), inner.point_light(|_| 0.5));
            let of_draw = inner.radiance * PI * (inner.radius * inner.radius - 1.0);
            assert!(((point + of_draw) / expected - 1.0).abs() < 1e-6, "{half_pixel_radii}: {point} and {of_draw} for {expected}");
            assert!(point > 0.0 && (half_hidden / point - 0.5).abs() < 1e-9, "{half_pixel_radii}: {half_hidden} of {point}");
        }
        let of_disc = inner_part(0.2, 1.0);
        assert_eq!([of_disc.radius, of_disc.radiance, of_disc.point_light(|_| 1.0)], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn radiance_falls_outward_and_is_zero_on_the_disc() {
        assert_eq!(radiance(0.99), 0.0);
        let distances = (0..100).map(|k| 1.0 + f64::from(k) * 0.1).collect::<Vec<_>>();
        assert!(distances.windows(2).all(|w| radiance(w[0]) > radiance(w[1])));
        for cutoff in [1e-1, 1e-3, 1e-6, 1e-9] {
            let rho = radius_at_radiance(cutoff);
            assert!(radiance(rho) <= cutoff && radiance(0.999 * rho) > cutoff, "{cutoff}: {rho}");
        }
    }

    /// The shader's law around a circle, with the mean of its exponential computed by summation: outside the rectangle no light reaches the cutoff.
    #[test]
    fn the_flattened_corona_stays_within_its_rectangle() {
        let steepness = |rho: f64| -(radiance(1.001 * rho) / radiance(rho)).ln() / 1.001_f64.ln();
        let equator_to_mean_ratio = |rho: f64| {
            // 1.609: as derived in shaders/entry/corona.wesl.
            let k = steepness(rho) * LUDENDORFF_INDEX.0 * (rho - 1.0).min(1.0) / 1.609;
            let mean = (0..360).map(|deg| (k * f64::from(deg).to_radians().cos()).exp()).sum::<f64>() / 360.0;
            k.exp() / mean
        };
        let largest = (0..400).map(|n| equator_to_mean_ratio(1.0 + 0.02 * f64::from(n))).fold(0.0, f64::max);
        assert!(largest > 2.0 && largest < MAX_TO_MEAN_RATIO, "{largest}");
        for cutoff in [1e-2, 1e-3, 1e-5] {
            let edge = radius_at_radiance(cutoff / MAX_TO_MEAN_RATIO);
            assert!(radiance(edge) * equator_to_mean_ratio(edge) <= cutoff, "{cutoff}: light beyond {edge} radii");
        }
    }

    /// For the years 1000 to 2900: within the index's range, without a jump, flattened at minima and round at maxima.
    #[test]
    fn the_cycle_runs_without_a_jump() {
        let at = |year: f64| Instant::from_jd_tt(2_451_545.0 + (year - 2000.0) * 365.25);
        let months = (1000 * 12..2900 * 12).map(|m| f64::from(m) / 12.0);
        let all: Vec<f64> = months.map(|y| flattening(at(y))).collect();
        assert!(all.iter().all(|f| (0.05..=0.35).contains(f)));
        assert!(all.windows(2).all(|w| (w[1] - w[0]).abs() < 0.012), "the index changes too fast within a month");
        for m in SUNSPOT_MINIMA {
            assert!(flattening(at(m)) > 0.345, "{m}");
        }
        // The corona was round in eclipses near maxima (1980, 2001, 2024) and elongated in eclipses near minima (1954, 1995, 2019).
        for (year, round) in [(1980.1, true), (2001.5, true), (2024.27, true), (1954.5, false), (1995.8, false), (2019.5, false)] {
            assert_eq!(flattening(at(year)) < 0.15, round, "{year}");
        }
    }
}
