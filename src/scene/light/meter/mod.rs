//! The light meter of automatic exposure: it estimates the radiance of everything in the frame.
//!
//! In: the request, the camera, the placed bodies, the air around the camera. Out: a [`MeterReading`] (`reading`): weight and radiance of each kind of subject
//! in the frame, and the Sun's glare. Nothing is rendered: the light of each body is summed over points of its ground (`ground`) with its photometric model
//! and mean albedo, including eclipses and light from other bodies. Of a body that reaches beyond the frame, only the ground in the frame counts
//! (`visible_ground`). Rings, sky, corona, refracted limbs, comets and the dark sky are added. Always: a reading changes continuously with position, time, field of
//! view and phase (exceptions: [`geometry`]). For this, the weight of each subject falls off smoothly at the frame's edges (that of ground the less, the more
//! of the frame it fills), the ground is summed between exact limits, and the light of the sky fades towards the top of the air. Only the glare and the corona
//! that the image shows are metered: no glare of a Sun far outside the frame, and no corona that the glare hides or the user switched off. Left out: maps
//! other than city lights, bright and dark sides, and bright ground near the camera (from afar a sea is as bright as a desert), relief seen from afar, the
//! shadow of rings on a distant planet, the air beyond a near limb, and the light that another body's air adds in front of bodies behind it.
//! Weights and limits without a stated source are chosen; tests/scene/metering.rs checks that no exposure jumps.

mod comets;
pub(super) mod geometry;
mod ground;
mod highlights;
mod log_mean;
mod outer_corona;
mod reading;
mod refracted_limb;
mod rim;
mod ring_shadow;
mod rings;
mod sky;
mod sun_glare;
mod twilight;
mod visible_ground;
mod weights;

use crate::catalog::NaifId;
use crate::message::{Argument, reason};
use crate::scene::atmosphere::air;
use crate::scene::camera::{Camera, silhouette::Outline};
use crate::scene::eclipse::approximate_shadow::ApproximateShadow;
use crate::scene::eclipse::refracted_limb::LimbLight;
use crate::scene::eclipse::sun_occluders::evaluate_shadow;
use crate::scene::features::inputs::diameter_px;
use crate::scene::light::exposure::{AUTO_EXPOSED_MEAN, AUTO_EXPOSED_SUN};
use crate::scene::light::lights::{self, IncidentLight, Reflector};
use crate::scene::light::photometry;
use crate::scene::light::{city_lights, corona};
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::placed::PlacedBody;
use crate::scene::point::{drawn_disc_fraction, point_peak};
use crate::scene::request::effects::Effect;
use crate::scene::resources::Context;
use crate::scene::sky::comet_tails::LightPatch;
use geometry::{
    area_px, entire_disc_weight, frame_position_weight, is_beside_frame, lit_part_weight, ray_and_limb, visible_fraction_behind_body,
    weighted_in_frame_fraction,
};
use glam::{DVec2, DVec3, FloatExt};
#[doc(hidden)]
pub use ground::RELIEF_SLOPE_RMS;
pub(crate) use ground::bright_ground_weight;
use ground::{Albedo, Ground, GroundRadiance};
use log_mean::LogMean;
use reading::FrameLight;
pub(crate) use reading::MeterReading;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
pub(crate) use sun_glare::FrameGlare;
#[doc(hidden)]
pub use twilight::{corrected_twilight_rows, metered_twilight};

/// Weight of the target relative to an equal area of another subject: a target on a 64th of the frame counts as much as an equally bright subject on all of it.
const TARGET_WEIGHT: f64 = 64.0;
/// Weight of the Sun if it is the target; larger than that of other targets, because a daylight sky around the Sun is as bright as any ground. Also the weight
/// of a targeted Sun's corona, and of the target's refracted limbs.
const SUN_WEIGHT: f64 = 256.0;
/// Share of the frame at which the weight of the Sun's disc is halved: the weight has the factor share / (share + this). A smaller disc is no longer the
/// subject of the image but a light source in it. For refracted limbs, the share is that of [`LimbLight::arc_disc_sr`]. `is_target`: whether the Sun or the
/// refracted limb belongs to the target.
fn sun_half_weight_share(is_target: bool) -> f64 {
    if is_target { 1e-3 } else { 1e-2 }
}
/// Weight of the dark sky: if everything bright in the frame has less weight, the image is exposed for the dark sky.
const DARK_SKY_WEIGHT: f64 = 1e-6;
/// Distances of the camera, in body radii, between which the meter blends from the part of the ground that the frame shows (near) to a sum over the entire disc
/// (far). Of a distant disc that reaches beyond the frame, too, only the part in the frame counts ([`entire_disc_weight`]).
const FAR_RADII: [f64; 2] = [3.0, 8.0];
/// Weights below this count as 0.
const NEGLIGIBLE_WEIGHT: f64 = 1e-9;
/// Diameters of a body's disc, pixels, between which its bright parts become highlights: pixels of a smaller disc average over them.
const HIGHLIGHT_DIAMETERS_PX: (f64, f64) = (4.0, 16.0);
/// Number of rays along each side of the frame.
const FRAME_RAYS: u32 = 16;
/// Radii of the innermost and outermost edge of the annuli around the Sun on which the corona is sampled, solar radii. For a camera near the Sun, rays of the
/// frame sample the corona outside the annuli (`outer_corona`).
const CORONA_RADII: [f64; 2] = [1.0, 4.0];
/// Sines of the Sun's angular radius between which rays of the frame gradually replace the annuli: for a camera 8.3 to 5 solar radii from the Sun's centre.
const ANNULI_TO_RAYS_SINES: (f64, f64) = (0.12, 0.2);

/// A subject in the frame with its metered radiance.
#[derive(Clone, Debug)]
pub(crate) struct MeteredSubject {
    pub name: Argument,
    /// The body that the subject belongs to, if any: its ground, sky, refracted limb or, for the Sun, disc.
    pub body: Option<NaifId>,
    /// Weighted geometric mean of the subject's radiance; of a sky around the camera the mean luminance.
    pub radiance: f64,
    /// The display level, as a linear fraction of white, at which this radiance should be shown.
    pub target_level: f64,
    /// How much the subject counts relative to the other subjects.
    pub weight: f64,
    /// The part of `radiance` that images show: 1 for all but the Earth ([`ground::Albedo::drawn_part`]). It has no effect on the exposure.
    pub drawn_part: f64,
    /// Whether this is the subject of the target or of the other bodies, whose highlights count.
    pub is_of_bodies: bool,
}

impl MeteredSubject {
    /// The radiance that is white in an image that shows this subject at its target level.
    pub fn white(&self) -> f64 {
        self.radiance / self.target_level
    }

    /// The radiance that images show.
    pub fn drawn_radiance(&self) -> f64 {
        self.radiance * self.drawn_part
    }
}

/// The inputs of the light meter.
pub(crate) struct Meter<'m, 'a> {
    pub context: Context<'m>,
    pub camera: &'m Camera,
    pub placed: &'m [PlacedBody<'a>],
    pub reflectors: &'m [Reflector<'m>],
    /// Comas and tails of comets, without those too faint for any exposure.
    pub comet_patches: &'m [LightPatch],
    /// The air around the camera, if it is dense enough for a daylight sky.
    pub air: Option<&'m air::SurroundingAir<'m>>,
    /// Weight of city lights relative to other ground; 0 if an exposure chosen without them hardly shows them.
    pub city_light_weight: f64,
}

/// How far away a body is: 0 up to the smaller of [`FAR_RADII`] or if its outline is open, 1 from the larger on.
fn far_weight(placed: &PlacedBody<'_>) -> f64 {
    let [from, to] = FAR_RADII;
    let is_closed = matches!(placed.outline, Outline::Ellipse { .. });
    let radii = placed.distance_km / placed.body.radii_km.max_element();
    if is_closed { smoothstep((radii / from).ln() / (to / from).ln()) } else { 0.0 }
}

/// Inputs that all parts of a reading share.
struct MeteredFrame<'f, 'a> {
    meter: &'f Meter<'f, 'a>,
    light: FrameLight,
    /// Bodies of more than a pixel, which may hide others along rays. [`Self::visible_fraction`] lets smaller ones hide the Sun, too.
    resolved_bodies: Vec<&'f PlacedBody<'a>>,
}

impl Meter<'_, '_> {
    fn frame_area_px(&self) -> f64 {
        f64::from(self.camera.width) * f64::from(self.camera.height)
    }
}

impl<'a> MeteredFrame<'_, 'a> {
    /// Radiance added in front of a body in a direction (ICRF, any length): glare, and the sky unless the body's air surrounds the camera.
    fn foreground_radiance(&self, direction: DVec3, body: NaifId) -> f64 {
        let glare = self.light.glare.as_ref().map_or(0.0, |v| self.light.sun_transmittance * v.radiance(direction.normalize()));
        let is_behind_sky = self.meter.air.is_some_and(|a| a.body.id != body);
        glare + if is_behind_sky { self.light.sky_exposure_radiance } else { 0.0 }
    }

    /// Fraction of a body's disc that nearer bodies leave visible.
    fn visible_fraction(&self, p: &PlacedBody<'_>) -> f64 {
        let towards = p.placement.centre_km / p.distance_km;
        let radius_rad = p.angular_radius_rad();
        let is_nearer = |o: &&PlacedBody<'_>| o.body.id != p.body.id && o.distance_km < p.distance_km;
        // The Sun is so bright that bodies of less than a pixel matter, too. In front of other bodies, the meter gives a body an opacity that rises from 0 to 1
        // while its area grows from one pixel to two. A body whose centre is the camera's position has an area of 0: it hides nothing.
        let opacity = |o: &PlacedBody<'_>| {
            let area = area_px(self.meter.camera, o);
            if p.body.id == NaifId::SUN { f64::from(area > 0.0) } else { smoothstep(area - 1.0) }
        };
        let nearer = self.meter.placed.iter().filter(is_nearer).map(|o| (o, opacity(o))).filter(|(_, opacity)| *opacity > 0.0);
        nearer.map(|(o, opacity)| opacity * visible_fraction_behind_body(&o.placement, towards, radius_rad) + 1.0 - opacity).product()
    }

    /// Fraction of a body's light that the frame draws as a disc; it draws the rest as a point.
    fn disc_fraction(&self, p: &PlacedBody<'_>, diameter_px: f64) -> f64 {
        drawn_disc_fraction(self.meter.context.request.effects.override_of_body(p.body, Effect::Points), p, diameter_px)
    }

    /// The lights that other bodies reflect onto a body, unless the user has switched planet-shine off.
    fn planet_shine_on(&self, p: &PlacedBody<'_>) -> Vec<IncidentLight> {
        if self.meter.context.request.effects.override_of_body(p.body, Effect::PlanetShine) == Some(false) {
            return Vec::new();
        }
        let (all, _strongest) = lights::planet_shine(p.body, p.position_km, self.meter.reflectors, |_| true);
        all
    }

    /// How much a body counts as a point, 0 to 1. The target counts as a disc at any size, another body from a diameter of two pixels on. Exception: a body
    /// whose rim of air counts ([`Self::rim_weight`]) is a point to the extent that it is drawn as a point.
    fn point_weight(&self, p: &PlacedBody<'_>, diameter_px: f64) -> f64 {
        let point_light_fraction = 1.0 - self.disc_fraction(p, diameter_px);
        if point_light_fraction <= 0.0 {
            return 0.0;
        }
        let is_target = Some(p.body.id) == self.meter.context.request.target;
        let of_small_body = if is_target { 0.0 } else { 1.0 - smoothstep(diameter_px - 1.0) };
        (point_light_fraction * self.rim_weight(p, diameter_px)).max(of_small_body)
    }

    /// Meters a body (globe without rings). Returns the mean of its radiance, and its weighted share of the frame: 0 if it counts only as a point.
    fn body(&self, p: &PlacedBody<'_>) -> (LogMean, f64) {
        let (camera, mut mean) = (self.meter.camera, LogMean::default());
        if matches!(p.outline, Outline::Behind | Outline::Beside) {
            return (mean, 0.0);
        }
        let far_weight = far_weight(p);
        let area = area_px(camera, p);
        let share = area / self.meter.frame_area_px() * weighted_in_frame_fraction(camera, p);
        // An open outline has no share here, and no `far_weight`: its ground in the frame is metered.
        if far_weight > 0.0 && share <= 0.0 {
            return (mean, 0.0);
        }
        let diameter_px = 2.0 * (area / PI).sqrt();
        // Weight of the sum over the entire disc; the sum over the ground in the frame has the weight 1 minus this.
        let disc_weight = far_weight * entire_disc_weight(camera, p, diameter_px);
        let foreground_radiance = self.foreground_radiance(p.placement.centre_km, p.body.id);
        let air = self.meter.air.filter(|a| a.body.id != p.body.id);
        let transmittance = air.map_or(1.0, |a| a.mean_transmittance(p.placement.centre_km));
        let point_weight = self.point_weight(p, diameter_px);
        if point_weight > 0.0 {
            // A point: all of the body's light, spread over a sprite, which the meter treats as uniform with the radiance of its peak. The sprite then covers
            // 1 / `point_peak()` pixels.
            let pixel_sr = camera.pixel_tangent().powi(2);
            let peak_radiance = transmittance * p.shown_irradiance.max_element() * self.part_past_rings(p) * PI / pixel_sr * point_peak();
            let sprite_share = weighted_in_frame_fraction(camera, p) / point_peak() / self.meter.frame_area_px();
            mean.add_outside_highlights(point_weight * sprite_share, peak_radiance, foreground_radiance);
            if point_weight >= 1.0 {
                return (mean, 0.0);
            }
        }
        let albedo_at = |phase_angle_rad: f64| Albedo::of(p, &self.meter.context.request.effects, diameter_px, phase_angle_rad);
        let to_body_frame = |v: DVec3| (p.body_from_icrf * v).normalize();
        let of_planet_shine = |l: &IncidentLight| {
            let phase_angle_rad = crate::ephemeris::angle_rad(l.direction, -p.placement.centre_km);
            (to_body_frame(l.direction), albedo_at(phase_angle_rad).lit_by(l.irradiance.max_element()))
        };
        let city_light_weight = self.meter.city_light_weight * city_lights::factor(p);
        let night_lights = self.meter.context.resources.night_lights.get(&p.body.id).filter(|_| city_light_weight > 0.0);
        let ground = Ground {
            body: p.body,
            night_lights: night_lights.map(AsRef::as_ref),
            city_light_weight,
            bright_ground: self.meter.context.resources.bright_grounds.get(&p.body.id).map(AsRef::as_ref),
            ring_shine: self.ring_shine_on(p, diameter_px),
            albedo: albedo_at(p.phase_angle_rad),
            albedo_map: ground::map_of_sides(p.body, &self.meter.context.request.effects),
            relief_weight: ground::relief_weight(p, &self.meter.context.request.effects, far_weight),
            sun: to_body_frame(p.body_to_sun_km),
            sun_irradiance: self.sun_irradiance_on(p),
            secondary_lights: self.planet_shine_on(p).iter().map(of_planet_shine).collect(),
            sky_exposure_radiance: self.meter.air.filter(|a| a.body.id == p.body.id).map_or(0.0, |_| self.light.ground_exposure_radiance),
        };
        let mut sum = |shadow: Option<&ApproximateShadow<'_>>| {
            let mut ground_share = 0.0;
            if 1.0 - disc_weight > NEGLIGIBLE_WEIGHT {
                ground_share = self.sum_ground(p, &ground, shadow, 1.0 - disc_weight, transmittance, &mut mean);
            }
            if far_weight > 0.0 {
                // The sprite of a small disc covers more of the frame than the disc, and is fainter by the same factor.
                let dilution = area / (area + (1.0 - self.disc_fraction(p, diameter_px)) / point_peak());
                let visible_weight = self.visible_fraction(p) * (1.0 - point_weight);
                let disc_share = share * disc_weight * visible_weight;
                let highlight_part = smooth_rise(HIGHLIGHT_DIAMETERS_PX, diameter_px);
                if disc_weight > 0.0 {
                    self.sum_disc(p, &ground, shadow, diameter_px, |area_fraction, radiance| {
                        let (share, radiance) = (disc_share * area_fraction / dilution, radiance.times(dilution * transmittance));
                        mean.add_ground(share * highlight_part, radiance, foreground_radiance);
                        mean.add_ground_outside_highlights(share * (1.0 - highlight_part), radiance, foreground_radiance);
                    });
                }
                // `sum_rim` weights each part of the rim by its place in the frame.
                let rim_share = area / self.meter.frame_area_px() * far_weight * visible_weight;
                self.sum_rim(p, ground.albedo.of_lights, shadow, diameter_px, |area_fraction, radiance| {
                    mean.add_outside_highlights(
                        rim_share * area_fraction / dilution,
                        radiance * dilution * transmittance,
                        foreground_radiance,
                    );
                });
            }
            ground_share
        };
        // The user may have set effects for this body alone.
        let body_request = self.meter.context.request.for_body(p.body);
        let body_context = Context { request: body_request.as_ref().unwrap_or(self.meter.context.request), ..self.meter.context };
        let ground_share = evaluate_shadow(body_context, p, diameter_px, |shadow, _camera_position| sum(Some(shadow)));
        let no_shadow = None;
        let ground_share = ground_share.unwrap_or_else(|| sum(no_shadow));
        (mean, share * disc_weight + ground_share)
    }

    /// Samples the entire disc of a distant body: calls `add` with the area of each part, as a fraction of the disc's and times the part's weight, and its
    /// radiance. The grid in photometric longitude and latitude (origin at the sub-observer point, equator through the sub-solar point) covers the lit and the
    /// dark part separately, so that even the thinnest crescent is sampled. The sum treats the viewer as infinitely far away; only [`lit_part_weight`] takes
    /// the distance into account.
    fn sum_disc(
        &self,
        p: &PlacedBody<'_>,
        ground: &Ground<'_>,
        shadow: Option<&ApproximateShadow<'_>>,
        diameter_px: f64,
        mut add: impl FnMut(f64, GroundRadiance),
    ) {
        let viewer = (p.placement.body_from_icrf * -p.placement.centre_km).normalize();
        let phase_angle_rad = crate::ephemeris::angle_rad(viewer, ground.sun);
        let perpendicular =
            (ground.sun - viewer * ground.sun.dot(viewer)).try_normalize().unwrap_or_else(|| viewer.any_orthonormal_vector());
        let up = viewer.cross(perpendicular);
        let terminator = phase_angle_rad - FRAC_PI_2;
        // A coarser grid for discs of a few pixels saves time.
        let (columns, rows) = if diameter_px < 4.0 { (6, 3) } else { (14, 8) };
        let lit_weight = lit_part_weight(phase_angle_rad, p.distance_km / p.body.radii_km.max_element());
        // Ranges of longitude: the dark part, then the lit part.
        for (from, to, weight) in [(-FRAC_PI_2, terminator, 1.0), (terminator, FRAC_PI_2, lit_weight)] {
            for k in 0..columns * rows {
                let midpoint = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n);
                let (sin, cos) = (from + (to - from) * midpoint(k % columns, columns)).sin_cos();
                let (sin_lat, cos_lat) = (PI * (midpoint(k / columns, rows) - 0.5)).sin_cos();
                let normal = (viewer * cos + perpendicular * sin) * cos_lat + up * sin_lat;
                // The area of a cell in projection, divided by that of the unit disc.
                let area_fraction = cos * cos_lat * cos_lat * (to - from) / f64::from(columns) * PI / f64::from(rows) / PI;
                if area_fraction > 0.0 {
                    let no_ring_shadow = 1.0;
                    // The body counts as a sphere, on which `normal` is also the point.
                    ground.for_each_slope([normal, normal, viewer], shadow, no_ring_shadow, |part, radiance| {
                        add(weight * area_fraction * part, radiance);
                    });
                }
            }
        }
    }

    /// Weight of a part of a body's limb in a direction: 0 outside the frame, with a softened edge. In the frame it is `outline_weight`, the weight of the
    /// position of the body's outline, if `disc_weight` is 1; the weight of the part's own position if `disc_weight` is 0 ([`entire_disc_weight`]).
    fn part_position_weight(&self, direction: DVec3, outline_weight: f64, disc_weight: f64) -> f64 {
        let Some(clip) = self.meter.camera.clip(direction) else { return 0.0 };
        // The edge is softened over a hundredth of the image.
        let edge = (1.0 - clip.abs()) * 50.0 + 0.5;
        let own_weight = frame_position_weight(clip.abs().max_element().min(1.0));
        smoothstep(edge.x) * smoothstep(edge.y) * own_weight.lerp(outline_weight, disc_weight)
    }

    /// The bodies that may block rays of the frame from `p`. `spacing`: see [`Self::ray_visibility`].
    fn nearer_bodies(&self, p: &PlacedBody<'_>, spacing: f64) -> Vec<&PlacedBody<'a>> {
        let is_nearer = |o: &&&PlacedBody<'_>| o.body.id != p.body.id && o.distance_km < p.distance_km;
        let in_front = self.resolved_bodies.iter().filter(is_nearer);
        in_front.copied().filter(|o| !is_beside_frame(self.meter.camera, &o.placement, spacing)).collect()
    }

    /// Fraction of a ray's light that the bodies in `nearer` do not block. `spacing`: angle between rays, which softens the limbs.
    fn ray_visibility(nearer: &[&PlacedBody<'_>], direction: DVec3, spacing: f64) -> f64 {
        nearer.iter().map(|o| 1.0 - smoothstep(0.5 + ray_and_limb(&o.placement, direction).inside_rad / spacing)).product()
    }

    /// Meters the visible part of the Sun's disc, of which the air at a limb may dim a part. `limb_lights`: see [`Meter::limb_lights`].
    fn sun(&self, limb_lights: &[(&PlacedBody<'_>, LimbLight)]) -> Option<MeteredSubject> {
        let (camera, sun) = (self.meter.camera, self.meter.placed.iter().find(|p| p.body.id == NaifId::SUN)?);
        let area = area_px(camera, sun);
        // An open outline counts as entirely in the frame.
        let in_frame = if sun.outline == Outline::Open { 1.0 } else { weighted_in_frame_fraction(camera, sun) };
        let share = area / self.meter.frame_area_px() * in_frame * self.visible_fraction(sun);
        let dilution = area / (area + (1.0 - self.disc_fraction(sun, 2.0 * (area / PI).sqrt())) / point_peak());
        let is_target = self.meter.context.request.target == Some(NaifId::SUN);
        let mut mean = LogMean::default();
        let weighted_share = share * share / (share + sun_half_weight_share(is_target));
        let radiance = photometry::sun_disc_radiance() * dilution * self.light.sun_transmittance;
        let (fraction_behind_air, transmittance) = if share > 0.0 { self.sun_behind_air(sun, limb_lights) } else { (0.0, 1.0) };
        for (part, transmittance) in [(1.0 - fraction_behind_air, 1.0), (fraction_behind_air, transmittance)] {
            // The Sun's own glare does not reduce its contrast.
            mean.add(weighted_share * part, radiance * transmittance, self.light.sky_exposure_radiance);
        }
        let weight = if is_target { SUN_WEIGHT } else { 1.0 };
        let metered = mean.metered(&*sun.body.name, Some(NaifId::SUN), AUTO_EXPOSED_SUN)?;
        Some(MeteredSubject { weight: metered.weight * weight, ..metered })
    }

    /// Meters the part of the corona that no body hides; glare and sky in front of it lower its weight.
    fn corona(&self) -> Option<MeteredSubject> {
        let (camera, sun) = (self.meter.camera, self.meter.placed.iter().find(|p| p.body.id == NaifId::SUN)?);
        let towards = sun.placement.centre_km / sun.distance_km;
        let sin_radius = sun.body.radii_km.x / sun.distance_km;
        let corona_weight = corona::meter_weight(self.meter.context.request, camera, self.meter.placed, sun, self.light.glare.as_ref());
        let ray_weight = outer_corona::ray_weight_of_inner_corona(sin_radius);
        if corona_weight <= 0.0 || ray_weight >= 1.0 || towards.dot(camera.forward) <= 0.0 {
            return None;
        }
        let (x, y) = towards.any_orthonormal_pair();
        let (annuli, sectors) = (12, 16);
        let growth = (CORONA_RADII[1] / CORONA_RADII[0]).powf(1.0 / f64::from(annuli));
        let mut mean = LogMean::default();
        // The sprite of a small Sun covers more of the frame than the inner corona, and is fainter by the same factor.
        let sun_px = diameter_px(camera, sun);
        let annuli_area_px = PI * (0.5 * sun_px * CORONA_RADII[1]).powi(2);
        let dilution = annuli_area_px / (annuli_area_px + (1.0 - self.disc_fraction(sun, sun_px)) / point_peak());
        let nearer = self.bodies_before_inner_corona(sun);
        for k in 0..annuli {
            // Radii of the annulus's inner edge and of its middle, solar radii.
            let inner = CORONA_RADII[0] * growth.powi(k);
            let rho = inner * growth.sqrt();
            // Solid angle of the annulus; that of the frame is taken as 4 `tan_half_fov.x` `tan_half_fov.y`.
            let area = PI * (growth * growth - 1.0) * inner * inner * sin_radius * sin_radius;
            let share = area / (4.0 * camera.tan_half_fov.element_product()) / f64::from(sectors);
            // Approximate angular width of a grid cell.
            let cell_width = rho * sin_radius * (growth - 1.0);
            for n in 0..sectors {
                let (sin, cos) = (TAU * (f64::from(n) + 0.5) / f64::from(sectors)).sin_cos();
                // As in shaders/entry/corona.wesl, the sine is proportional to the distance from the Sun's centre.
                let sine = rho * sin_radius;
                let direction = towards * (1.0 - sine * sine).max(0.0).sqrt() + (x * cos + y * sin) * sine;
                let Some(clip) = camera.clip(direction) else { continue };
                let edge = (1.0 - clip.abs()) * camera.tan_half_fov / cell_width + 0.5;
                let inside = smoothstep(edge.x) * smoothstep(edge.y);
                if inside > 0.0 {
                    let visibility = Self::ray_visibility(&nearer, direction, cell_width);
                    let inside = inside * frame_position_weight(clip.abs().max_element().min(1.0));
                    mean.add(
                        share * inside * visibility / dilution,
                        corona::radiance(rho) * dilution * self.light.sun_transmittance,
                        self.foreground_radiance(direction, NaifId::SUN),
                    );
                }
            }
        }
        let weight =
            corona_weight * (1.0 - ray_weight) * if self.meter.context.request.target == Some(NaifId::SUN) { SUN_WEIGHT } else { 1.0 };
        let no_body = None;
        let metered = mean.metered(reason!("subject-corona"), no_body, AUTO_EXPOSED_MEAN)?;
        Some(MeteredSubject { weight: metered.weight * weight, ..metered })
    }

    /// Evaluates a function of the view ray on a grid over the frame of [`FRAME_RAYS`] points on each side, row by row from the lower edge.
    fn sample_frame<T>(&self, function: impl Fn(DVec3) -> T) -> Vec<T> {
        let clip = |k: u32| (DVec2::new(f64::from(k % FRAME_RAYS), f64::from(k / FRAME_RAYS)) + 0.5) * 2.0 / f64::from(FRAME_RAYS) - 1.0;
        (0..FRAME_RAYS * FRAME_RAYS).map(|k| function(self.meter.camera.ray(clip(k)))).collect()
    }
}
