//! Meters the light of rings: the light that they scatter towards the camera, and ring-shine on the night side of the globe.
//!
//! In: a placed body with rings. Out: the weighted logarithmic mean of the rings' radiance, sampled by a grid of rays over them; the part of it that counts
//! beside the globe; the table of ring-shine, with the ground's radiance per unit of it; and, for any body, the sunlight that other bodies' rings leave.
//! Dense and faint rings have a grid each. On one grid over all rings of Saturn, which reach to eight radii, few rays were left for the main rings, the fewer
//! the more of the E ring was in the frame: the exposure depended on the distance.

use super::geometry::{frame_position_weight, ray_and_limb};
use super::{LogMean, MeteredFrame};
use crate::catalog::{Photometry, Ring};
use crate::scene::draw::tables::RingShine;
use crate::scene::eclipse::sun_occluders;
use crate::scene::light::{lights, photometry};
use crate::scene::numeric::{smooth_rise, smoothstep};
use crate::scene::placed::PlacedBody;
use crate::scene::purpose::{Purpose, Threshold};
use crate::scene::request::effects::Effect;
use crate::scene::rings::ring_light::SHINE_FADE_IN_RAD;
use crate::scene::rings::{phase, ring_shine, view};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Number of rays along each side of the rectangle of dense or of faint rings.
const RING_RAYS: u32 = 28;
/// Rings with less than this part of the greatest normal optical depth of a body's rings are faint: the rings D, G and E of Saturn, but no narrow ring.
const FAINT_PART_OF_DEPTH: f64 = 1e-3;
/// Ratios of the rings' mean radiance to that of what they surround, in stops, between which rings count beside it: see [`counted_part_of_rings`].
const COUNTED_RINGS_STOPS: (f64, f64) = (0.0, 2.0);
/// Share of the globe in the weight of globe and rings from which on the globe determines the exposure.
const LEADING_GLOBE_SHARE: f64 = 0.1;
/// Width over which the edge of the globe's shadow on the rings is softened, globe radii: wider than the penumbra, so that the meter's reading changes
/// gradually.
const SHADOW_EDGE_RADII: f64 = 0.02;
/// Lengths of the longer side of the rings' rectangle, margins included, between which the weight of the rings rises from 0 to 1. The light of smaller rings is
/// part of the body's point.
const FADE_IN_SIZES_PX: (f64, f64) = (4.0, 8.0);

/// The part of the weight of rings that counts beside `inner`, the mean of the globe or of the globe and the dense rings. Rings that are not brighter do not
/// count: gaps, thin rings and the area that rings fill would move the mean, so that the same globe would be exposed longer with its rings in the frame. They
/// count if they are brighter, as around a night side, or if hardly anything of the globe is in the frame.
fn counted_part_of_rings(inner: &LogMean, rings: &LogMean) -> f64 {
    if inner.weight <= 0.0 || rings.weight <= 0.0 {
        return 1.0;
    }
    let leading = smoothstep(inner.weight / (inner.weight + rings.weight) / LEADING_GLOBE_SHARE);
    let brighter = smooth_rise(COUNTED_RINGS_STOPS, (rings.radiance() / inner.radiance()).log2());
    1.0 - leading * (1.0 - brighter)
}

impl MeteredFrame<'_, '_> {
    /// Merges the means of a body's dense and faint rings into that of its globe.
    pub(super) fn add_rings(&self, p: &PlacedBody<'_>, mean: &mut LogMean) {
        let greatest_depth = p.body.rings.iter().map(|r| r.tau_normal).fold(0.0, f64::max);
        let is_faint = |r: &Ring| r.tau_normal < FAINT_PART_OF_DEPTH * greatest_depth;
        // A gap, a ring without optical depth, cuts out a part of the rings before it.
        let is_gap = |r: &Ring| r.tau_normal <= 0.0;
        for rings in [self.rings_among(p, |r| is_gap(r) || !is_faint(r)), self.rings_among(p, |r| is_gap(r) || is_faint(r))] {
            let part = counted_part_of_rings(mean, &rings);
            mean.merge(&rings.times(part));
            // All of the rings may have highlights.
            mean.highlights.merge(&rings.highlights.times(1.0 - part));
        }
    }

    /// Fraction of the sunlight on a body that the rings of other bodies leave, as images show it; its green channel.
    pub(super) fn part_past_rings(&self, p: &PlacedBody<'_>) -> f64 {
        sun_occluders::shown_sunlight_past_rings(self.meter.context, p).y
    }

    /// Irradiance of a plane on a body that faces the Sun, past the rings of other bodies. Sunlight counts as the same in all channels.
    pub(super) fn sun_irradiance_on(&self, p: &PlacedBody<'_>) -> f64 {
        lights::sunlight(p.body_to_sun_km).irradiance.x * self.part_past_rings(p)
    }

    /// The table of ring-shine on the globe relative to the Sun's irradiance, and the ground's radiance where this ratio is 1, times a weight; `None` where
    /// ring-shine does not count. The weight falls to 0 towards small phase angles ([`SHINE_FADE_IN_RAD`]): on the day side ring-shine is a hundredth of the
    /// light. `diameter_px`: of the globe.
    pub(super) fn ring_shine_on(&self, p: &PlacedBody<'_>, diameter_px: f64) -> Option<(Arc<RingShine>, f64)> {
        let weight = smooth_rise(SHINE_FADE_IN_RAD, p.phase_angle_rad);
        let user_choice = self.meter.context.request.effects.override_of_body(p.body, Effect::RingShine);
        let rings: Vec<&Ring> = p.body.rings.iter().filter(|r| r.tau_normal > 0.0).collect();
        // Only for the part of the light that is drawn as a disc: the light of a point already includes ring-shine.
        let weight = weight * self.disc_fraction(p, diameter_px);
        if weight <= 0.0 || rings.is_empty() || user_choice == Some(false) {
            return None;
        }
        // As if the user had requested ring-shine: then its table is computed whatever the threshold.
        let (_, shine) = self.ring_view(p).ring_shine(&rings, crate::units::SUN_RADIUS_KM, Some(true));
        let shine = shine?;
        let albedo_scale = photometry::albedo_normalisation(p.body).x * p.body.geometric_albedo * f64::from(p.body.colour.max_element());
        Some((shine, weight * albedo_scale * self.sun_irradiance_on(p)))
    }

    /// The geometry of a body's rings. The meter calls only methods whose results do not depend on `irradiance` and `threshold`, whose values here are
    /// arbitrary.
    pub(super) fn ring_view<'v>(&'v self, p: &'v PlacedBody<'_>) -> view::RingView<'v> {
        view::RingView {
            body: p.body,
            camera: self.meter.camera,
            placement: &p.placement,
            sun: (p.body_from_icrf * p.body_to_sun_km).normalize(),
            sun_distance_km: p.body_to_sun_km.length(),
            phase_angle_rad: p.phase_angle_rad,
            irradiance: 1.0,
            threshold: Threshold::of(Purpose::LINEAR, 1.0),
            caches: self.meter.context.caches,
        }
    }

    /// Meters some of a body's rings with rays over their rectangle.
    fn rings_among(&self, p: &PlacedBody<'_>, is_counted: impl Fn(&Ring) -> bool + Copy) -> LogMean {
        let (camera, mut mean) = (self.meter.camera, LogMean::default());
        let rings = p.body.rings.iter().filter(move |r| is_counted(r));
        let outer_km = rings.clone().filter(|r| r.tau_normal > 0.0).map(|r| r.outer_km).fold(0.0, f64::max);
        let user_choice = self.meter.context.request.effects.override_of_body(p.body, Effect::Rings);
        if outer_km <= 0.0 || user_choice == Some(false) || matches!(p.body.photometry, Photometry::Emissive { .. }) {
            return mean;
        }
        // Unit of the lengths below: the equatorial radius.
        let unit_km = p.body.radii_km.x;
        let sun = (p.body_from_icrf * p.body_to_sun_km).normalize();
        let view = self.ring_view(p);
        // `None`: no part of the rings is in the frame.
        let Some(rect) = view.rect(outer_km) else { return mean };
        // In clip units: the frame is 2 by 2.
        let size = DVec2::new(rect.right - rect.left, rect.top - rect.bottom);
        // The flux of a body that is drawn as a point includes its rings.
        let size_weight = smooth_rise(FADE_IN_SIZES_PX, (size * camera.half_size_px()).max_element());
        if size_weight <= 0.0 {
            return mean;
        }
        let intervals = self.meter.context.caches.ring_tables.intervals(rings, unit_km);
        let Some(inner) = intervals.first().map(|first| first.inner) else { return mean };
        let outer = outer_km / unit_km;
        let sun_tangent = crate::units::SUN_RADIUS_KM / view.sun_distance_km;
        let irradiance = self.sun_irradiance_on(p);
        // Angle between diagonally adjacent rays, as a tangent.
        let spacing = (size * camera.tan_half_fov).length() / f64::from(RING_RAYS);
        // Fraction of the frame's area for which a ray stands, times the weight.
        let share = size_weight * size.element_product() / 4.0 / f64::from(RING_RAYS * RING_RAYS);
        let origin = p.placement.body_from_icrf * -p.placement.centre_km / unit_km;
        let polar_radius = p.body.radii_km.z / unit_km;
        // Parts of the Sun's disc that the ring plane divides: `sunlight` has first the part on the camera's side.
        let [centre_side, other_side] = ring_shine::sun_disc_parts(sun.z.abs(), sun_tangent);
        let sunlight = if sun.z * origin.z < 0.0 { [other_side, centre_side] } else { [centre_side, other_side] };
        let nearer_bodies = self.nearer_bodies(p, spacing);
        let cached_sums = self.meter.context.caches.radial_sums.of(&intervals, sunlight);
        let mut sums = cached_sums.lock();
        for k in 0..RING_RAYS * RING_RAYS {
            let position = (DVec2::new(f64::from(k % RING_RAYS), f64::from(k / RING_RAYS)) + 0.5) / f64::from(RING_RAYS);
            let clip = DVec2::new(rect.left, rect.bottom) + size * position;
            let direction = camera.ray(clip);
            let ray = (p.placement.body_from_icrf * direction).normalize();
            let distance = -origin.z / ray.z;
            if !(distance > 0.0 && distance.is_finite()) {
                continue;
            }
            let ring_point = origin + ray * distance;
            let radius = ring_point.truncate().length();
            let cos_emission = ray.z.abs().max(phase::MIN_COSINE);
            // A narrow cone around the ray meets the ring plane in an ellipse, elongated along the ray's projection onto it.
            // Estimated radial part of this elongation, in widths of the cone:
            let radial_stretch = (ray.truncate().dot(ring_point.truncate()) / radius.max(1e-9)).abs() / cos_emission;
            // Half the range of radii that the ray represents.
            let half_width = 0.5 * (distance * spacing * (1.0 + radial_stretch)).max(1e-6);
            if radius - half_width > outer || radius + half_width <= inner {
                continue;
            }
            // The ring gets no light in the globe's shadow, and cannot be seen behind the globe. `unit_sphere_scale` makes the globe a unit sphere.
            let unit_sphere_scale = DVec3::new(1.0, 1.0, 1.0 / polar_radius);
            let (point, to_sun) = (ring_point * unit_sphere_scale, (sun * unit_sphere_scale).normalize());
            let sunlit_fraction =
                if point.dot(to_sun) < 0.0 { smoothstep((point.cross(to_sun).length() - 1.0) / SHADOW_EDGE_RADII + 0.5) } else { 1.0 };
            // `inside_rad` is positive where the ray meets the globe.
            let limb = ray_and_limb(&p.placement, direction);
            let is_behind_globe = distance > (origin - limb.point * DVec3::new(1.0, 1.0, polar_radius)).length();
            let visible_fraction = if is_behind_globe { 1.0 - smoothstep(0.5 + limb.inside_rad / spacing) } else { 1.0 };
            let weight = frame_position_weight(clip.abs().max_element());
            let visible_share = share * weight * visible_fraction * Self::ray_visibility(&nearer_bodies, direction, spacing);
            // Sums are computed only for rays that count.
            if sunlit_fraction <= 0.0 || visible_share <= 0.0 {
                continue;
            }
            let cos_phase = (-ray.dot(sun)).clamp(-1.0, 1.0);
            // Large particles and dust have phase functions of their own.
            let (particle_phase, dust_phase) = (phase::large_particle_phase(cos_phase), phase::dust_phase(cos_phase.acos()));
            let [by_particles, by_dust] = sums.mean([radius - half_width, radius + half_width], 1.0 / cos_emission);
            let light = particle_phase * by_particles + dust_phase * by_dust;
            // The factor 1/4 of single scattering, which `light` lacks (`rings::single_scatter`).
            let radiance = 0.25 * light * irradiance * sunlit_fraction;
            mean.add(visible_share, radiance, self.foreground_radiance(direction, p.body.id));
        }
        mean
    }
}
