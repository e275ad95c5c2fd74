//! A body's rings in a frame: when they are drawn, when rings and planet cast shadows on each other, by which model, and with what uniforms.
//!
//! In: a placed body with rings, the camera, the threshold. Out: the visible rings, the models, the uniforms of shaders/lib/ring. Rings are flat and
//! circular here: halos, the inclination and eccentricity of the Uranian rings (0.008 of the radius for epsilon) and the arcs of Adams are left out.

use crate::catalog::{Body, Ring};
use crate::message::{Reason, reason};
use crate::scene::camera::silhouette::{Outline, PADDING_PX};
use crate::scene::camera::{self, AnchorForm, Camera, ClipRect, Placement};
use crate::scene::draw::DrawUniforms;
use crate::scene::draw::features::{BodyShadow, PixelView, RingShadow};
use crate::scene::draw::tables::{RingShine, RingTable};
use crate::scene::draw::uniforms::RingUniforms;
use crate::scene::eclipse::occluders::limb_darkening;
use crate::scene::purpose;
use crate::scene::resources::Caches;
use crate::scene::rings::phase::{
    DUST_LOBES, MIN_COSINE, OPPOSITION_SURGE, PHASE_EXPONENT, dust_phase, large_particle_phase, power_law_factor,
};
use crate::scene::rings::ring_shine::{RingShineGeometry, sun_disc_parts};
use crate::scene::rings::ring_table::{RingConditions, slants_of_sunlight};
use crate::scene::stated_errors::{self, MAX_EDGE_ERROR_PX};
use glam::{DVec2, DVec3, Vec2, Vec4};
use std::f64::consts::PI;
use std::sync::Arc;

/// Number of corners of the polygon around a ring's outline; they lie 0.05 % outside the outline.
const OUTLINE_CORNERS: usize = 96;
/// Maximum number of segments into which a pixel's footprint is divided: a limit on the shader's loop, reached by
/// nearly edge-on rings and by rings of a few pixels.
const MAX_SEGMENTS: f64 = 16.0;
/// Ratio of the polar to the equatorial radius of the thin spheroid that represents a ring when its outline is computed.
const OUTLINE_THICKNESS: f64 = 1e-6;

/// Rounds to 17 significant bits, so that frames within some minutes share a table. The relative error is below 8e-6; the relative error of the rings' light
/// is then below 2e-5.
fn rounded_for_reuse(x: f64) -> f64 {
    const DROPPED_BITS: u32 = 36;
    f64::from_bits((x.to_bits() + (1 << (DROPPED_BITS - 1))) & !((1 << DROPPED_BITS) - 1))
}

/// A corner of the polygon around the outline of rings out to a radius, in their plane.
fn outline_corner(outer_km: f64, k: usize) -> DVec2 {
    DVec2::from_angle(2.0 * PI * k as f64 / OUTLINE_CORNERS as f64) * (outer_km / (PI / OUTLINE_CORNERS as f64).cos())
}

/// The part of a convex polygon on the positive side of a plane through the origin.
fn clipped(polygon: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (side_p, side_q) = (p.dot(normal), q.dot(normal));
        if side_p >= 0.0 {
            kept.push(p);
        }
        if (side_p >= 0.0) != (side_q >= 0.0) {
            kept.push(p + (q - p) * (side_p / (side_p - side_q)));
        }
    }
    kept
}

/// The geometry of a body's rings in a frame.
pub(crate) struct RingView<'a> {
    pub body: &'a Body,
    pub camera: &'a Camera,
    pub placement: &'a Placement,
    /// Unit vector to the Sun, body axes.
    pub sun: DVec3,
    pub sun_distance_km: f64,
    /// Phase angle at the body's centre.
    pub phase_angle_rad: f64,
    /// Irradiance of a plane that faces the Sun, past the rings of other bodies; brightest channel.
    pub irradiance: f64,
    /// The threshold below which a ring is left out.
    pub threshold: purpose::Threshold,
    pub caches: &'a Caches,
}

/// Properties of the frame from which [`RingLimits`] of each ring are computed.
struct FrameLimits {
    /// The camera's height over the rings' plane, equatorial radii.
    height: f64,
    /// The camera's distance from the body's axis, equatorial radii.
    axis_distance: f64,
    /// Length of the longest ray of the frame, for rays scaled to view depth 1.
    longest_ray: f64,
    /// Smallest cosine between a ray of the frame and the rings' normal.
    min_cosine: f64,
    /// Largest angle between the body's centre and a corner of the frame.
    corner_rad: f64,
}

/// Bounds of the conditions under which a ring is seen, over all pixels that may show it.
struct RingLimits {
    /// Optical depth along the flattest ray.
    max_slant_depth: f64,
    /// The smallest and the largest phase angle.
    phase_angles_rad: [f64; 2],
    /// The largest fraction of a pixel that the ring fills.
    max_filled: f64,
}

/// Upper limits of the change that a ring makes to a pixel.
struct RingChange {
    /// Fraction of the background that a ring that fills the pixel hides.
    hidden: f64,
    /// Radiance that a ring that fills the pixel adds.
    added: f64,
    /// Fraction of the pixel that the ring fills.
    filled: f64,
}

/// Whether an effect exceeds its threshold, and the reason.
pub(crate) struct ThresholdCheck {
    pub on: bool,
    pub reason: Reason,
}

/// The rings that can visibly change a pixel.
pub(crate) struct VisibleRings<'a> {
    pub rings: Vec<&'a Ring>,
    pub check: ThresholdCheck,
}

impl<'a> RingView<'a> {
    /// Outermost radius of all rings that the body has.
    fn outermost_km(&self) -> f64 {
        self.body.rings.iter().map(|r| r.outer_km).fold(0.0, f64::max)
    }

    /// Pixels per equatorial radius at the body.
    fn pixels_per_radius(&self) -> f64 {
        self.body.radii_km.x / (self.placement.centre_km.length() * self.camera.pixel_tangent())
    }

    /// The same at the nearest ground, if the camera is near the body.
    fn pixels_per_radius_at_nearest(&self) -> f64 {
        let distance_km = self.placement.height_near_ground_km().unwrap_or_else(|| self.placement.centre_km.length());
        self.body.radii_km.x / (distance_km * self.camera.pixel_tangent())
    }

    /// The rays of the frame's corners in body axes, with view depth 1.
    fn corner_rays(&self) -> [DVec3; 4] {
        let clips = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].map(DVec2::from_array);
        clips.map(|clip| self.placement.body_from_icrf * self.camera.ray(clip))
    }

    /// The camera's height over the rings' plane and its distance from the body's axis, equatorial radii.
    fn camera_height_and_axis_distance(&self) -> (f64, f64) {
        let viewer = self.placement.body_from_icrf * -self.placement.centre_km / self.body.radii_km.x;
        // Above 0, so that a camera in the plane has finite slants.
        (viewer.z.abs().max(1e-9), viewer.truncate().length())
    }

    /// The limits that all rings of the frame share.
    fn frame_limits(&self) -> FrameLimits {
        let (height, axis_distance) = self.camera_height_and_axis_distance();
        let corners = self.corner_rays();
        let longest_ray = corners.iter().map(|r| r.length()).fold(0.0, f64::max);
        // Each ray of the frame is a weighted mean of the corner rays. If all corner rays point to the same side of the plane, no ray is flatter than the
        // flattest corner ray.
        let are_on_one_side = corners.iter().all(|r| r.z > 0.0) || corners.iter().all(|r| r.z < 0.0);
        let min_cosine = if are_on_one_side { corners.iter().map(|r| r.z.abs()).fold(f64::INFINITY, f64::min) / longest_ray } else { 0.0 };
        let centre = self.placement.body_from_icrf * self.placement.centre_km;
        let corner_rad = corners.iter().map(|r| crate::ephemeris::angle_rad(*r, centre)).fold(0.0, f64::max);
        FrameLimits { height, axis_distance, longest_ray, min_cosine, corner_rad }
    }

    /// Limits over all pixels that may show a ring.
    fn limits(&self, ring: &Ring, frame: &FrameLimits) -> RingLimits {
        let &FrameLimits { height, axis_distance, longest_ray, min_cosine, corner_rad } = frame;
        let [inner, outer] = [ring.inner_km, ring.outer_km].map(|r| r / self.body.radii_km.x);
        let min_cosine = min_cosine.max(height / height.hypot(axis_distance + outer)).max(MIN_COSINE);
        // The angle between a ray that may show the ring and the direction to the body's centre is at most the ring's angular radius, and at most the angle of
        // the farthest corner.
        let ring_rad = if outer < height.hypot(axis_distance) { (outer / height.hypot(axis_distance)).asin() } else { PI };
        let spread_rad = corner_rad.min(ring_rad);
        // Width of the narrowest pixel, equatorial radii, at the ring's nearest point: a pixel spans a smaller angle away from the middle of the image.
        let gap = (inner - axis_distance).max(axis_distance - outer).max(0.0);
        let narrowest_pixel = height.hypot(gap) * self.camera.pixel_tangent() / (longest_ray * longest_ray);
        RingLimits {
            max_slant_depth: ring.tau_normal / min_cosine,
            phase_angles_rad: [(self.phase_angle_rad - spread_rad).max(0.0), (self.phase_angle_rad + spread_rad).min(PI)],
            max_filled: ((outer - inner) / narrowest_pixel).min(1.0),
        }
    }

    /// Upper limits of a ring's effect on a pixel that shows nothing else.
    fn change(&self, ring: &Ring, frame: &FrameLimits) -> RingChange {
        let limits = self.limits(ring, frame);
        let albedo = ring.albedo.iter().copied().fold(0.0, f64::max);
        // Large particles are brightest at the smallest phase angle. The phase function of dust has one minimum, so its maximum is at an end of the range.
        let [smallest, largest] = limits.phase_angles_rad;
        // Few rings have dust, and its phase function is the costly one.
        let of_dust = if ring.dust_fraction > 0.0 { dust_phase(smallest).max(dust_phase(largest)) * ring.dust_fraction } else { 0.0 };
        let phase = large_particle_phase(smallest.cos()) * (1.0 - ring.dust_fraction) + of_dust;
        // Upper limit of single scattering: each photon is scattered once, and none is lost afterwards.
        RingChange {
            hidden: -(-limits.max_slant_depth).exp_m1(),
            added: albedo * 0.25 * phase * limits.max_slant_depth.min(1.0) * self.irradiance,
            filled: limits.max_filled,
        }
    }

    /// The visible rings; with `include_all` also rings below the threshold. Rings are left out from the outermost inwards as long as together they change no
    /// pixel visibly. Their joint change is at most the sum of their changes, and at most the largest change that one of them makes to a pixel that it fills.
    /// The check also fails if the disc out to the outermost visible ring, seen face-on, covers at most half a pixel.
    pub(crate) fn visible_rings(&self, include_all: bool) -> VisibleRings<'a> {
        let frame = self.frame_limits();
        let mut rings: Vec<(&Ring, RingChange)> =
            self.body.rings.iter().filter(|r| r.tau_normal > 0.0).map(|r| (r, self.change(r, &frame))).collect();
        rings.sort_by(|a, b| b.0.outer_km.total_cmp(&a.0.outer_km));
        let relative_change = |c: &RingChange| c.hidden.max(self.threshold.relative_to_white(c.added)) * c.filled;
        let strongest = rings.iter().map(|(r, c)| (relative_change(c), r.name.as_str())).max_by(|a, b| a.0.total_cmp(&b.0));
        let (mut sum, mut greatest) = ([0.0; 2], [0.0_f64; 2]);
        let first_visible = rings.iter().find(|(_, c)| {
            for (k, change) in [c.hidden, c.added].into_iter().enumerate() {
                sum[k] += change * c.filled;
                greatest[k] = greatest[k].max(change);
            }
            let [hidden, added] = [0, 1].map(|k| greatest[k].min(sum[k]));
            include_all || self.threshold.is_exceeded_by_change(hidden) || self.threshold.is_exceeded_by_radiance(added)
        });
        let outer_km = first_visible.map_or(0.0, |(r, _)| r.outer_km);
        // Gaps are kept: they are rings of zero optical depth that lie over wider rings.
        let seen: Vec<&Ring> = self.body.rings.iter().filter(|r| r.outer_km <= outer_km).collect();
        let area_px = PI * (outer_km / self.body.radii_km.x * self.pixels_per_radius()).powi(2);
        let reason = match strongest {
            None => reason!("rings-none"),
            Some((change, name)) if seen.is_empty() => {
                let min_change = self.threshold.min_change();
                let light = reason!("of-white", light = format_args!("{change:.2e}"), threshold = format_args!("{min_change:.2e}"));
                reason!("rings-strongest", ring = name, light = light)
            }
            Some((change, name)) => {
                let extent = reason!("rings-out-to", distance = format_args!("{outer_km:.0}"), area = format_args!("{area_px:.1}"));
                reason!("rings-change", ring = name, part = format_args!("{change:.2e}")).and(extent)
            }
        };
        VisibleRings { check: ThresholdCheck { on: !seen.is_empty() && area_px > 0.5, reason }, rings: seen }
    }

    /// Whether any of the rings may be in the image.
    pub(crate) fn meets_frame(&self) -> bool {
        self.rect(self.outermost_km()).is_some()
    }

    /// Tangent of the Sun's angular radius.
    fn sun_tangent(&self, sun_radius_km: f64) -> f64 {
        sun_radius_km / self.sun_distance_km
    }

    /// Whether the rings' shadow on the lit globe is visible, and its model.
    pub(crate) fn ring_shadow(&self, rings: &[&Ring], sun_radius_km: f64) -> (ThresholdCheck, RingShadow) {
        let sine = self.sun.z.abs();
        let tangent = self.sun_tangent(sun_radius_km);
        // Paths from the lit globe to the Sun cross the plane at most this far from the axis: the path from the terminator crosses it farthest out.
        let farthest_km = self.body.radii_km.x / sine.max(1e-9);
        let max_removed_fraction =
            rings.iter().filter(|r| r.inner_km < farthest_km).map(|r| -(-r.tau_normal / sine.max(MIN_COSINE)).exp_m1()).fold(0.0, f64::max);
        // Half the penumbra's width in the rings' plane, for the point of the globe that is farthest from the plane. The distance along the sunlight is about
        // 1 / sine; the light crosses the plane obliquely, which stretches the width by another 1 / sine.
        let half_penumbra_px = tangent / sine.max(tangent) / sine.max(tangent) * self.pixels_per_radius_at_nearest();
        let model = if half_penumbra_px > MAX_EDGE_ERROR_PX { RingShadow::Penumbra } else { RingShadow::PointSun };
        let (degrees, light) = (sine.asin().to_degrees(), self.threshold.change_description(max_removed_fraction));
        let reason = reason!("ring-shadow-sun", degrees = format_args!("{degrees:.3}"), light = light)
            .and(reason!("ring-shadow-penumbra", size = format_args!("{:.1}", 2.0 * half_penumbra_px)));
        (ThresholdCheck { on: self.threshold.is_exceeded_by_change(max_removed_fraction) && sine > 0.0, reason }, model)
    }

    /// Whether the globe's shadow falls on any of the rings, and its model.
    pub(crate) fn body_shadow(&self, rings: &[&Ring], sun_radius_km: f64) -> (ThresholdCheck, BodyShadow) {
        let inner_km = rings.iter().filter(|r| r.tau_normal > 0.0).map(|r| r.inner_km).fold(f64::INFINITY, f64::min);
        let outer_km = rings.iter().map(|r| r.outer_km).fold(0.0, f64::max);
        // Distance of the shadow's axis from the nearest point of the innermost ring, equatorial radii. An oblate globe and its penumbra lie within a
        // sphere around the globe and the penumbra of that sphere. For rings farther out the distance from the axis grows by more than the penumbra widens.
        // shaders/lib/ring/body_shadow.wesl makes the same test for each pixel.
        let inner = inner_km / self.body.radii_km.x;
        let (shadow_distance, penumbra_radius) = (inner * self.sun.z.abs(), 1.0 + inner * self.sun_tangent(sun_radius_km));
        let outer = outer_km / self.body.radii_km.x;
        let oblateness_offset = stated_errors::sphere_shadow_offset(self.body.radii_km.z / self.body.radii_km.x, self.sun.z, outer);
        let penumbra_width = 2.0 * self.sun_tangent(sun_radius_km) * outer;
        let offset_px = oblateness_offset.max(penumbra_width) * self.pixels_per_radius();
        let model = if offset_px > MAX_EDGE_ERROR_PX { BodyShadow::EllipsoidPenumbra } else { BodyShadow::Sphere };
        let reason =
            reason!("body-shadow-axis", radii = format_args!("{shadow_distance:.3}"), limit = format_args!("{penumbra_radius:.3}"))
                .and(reason!("body-shadow-edges", size = format_args!("{offset_px:.1}")));
        (ThresholdCheck { on: shadow_distance <= penumbra_radius, reason }, model)
    }

    /// The rectangle around the part of the rings out to a radius that is in the frame; `None` if no part is. The rectangle changes continuously with the
    /// camera, also where the outline becomes open.
    pub(crate) fn rect(&self, outer_km: f64) -> Option<ClipRect> {
        let disc = Placement { radii_km: DVec3::new(outer_km, outer_km, outer_km * OUTLINE_THICKNESS), ..*self.placement };
        if disc.camera_is_inside() {
            return Some(ClipRect::VIEWPORT);
        }
        let of_outline = Outline::of(self.camera, &disc).rect(self.camera)?;
        self.bounds_in_frame(outer_km).and_then(|bounds| of_outline.intersection(&bounds))
    }

    /// Padded bounds of the part of the rings that is in the padded frame; `None` if no part is.
    fn bounds_in_frame(&self, outer_km: f64) -> Option<ClipRect> {
        let camera = self.camera;
        let body_to_icrf = self.placement.body_from_icrf.transpose();
        // Clip coordinates times the depth, and the depth: points behind the camera have them, too.
        let corner = |k: usize| {
            let v = self.placement.centre_km + body_to_icrf * outline_corner(outer_km, k).extend(0.0);
            (DVec2::new(v.dot(camera.right), v.dot(camera.up)) / camera.tan_half_fov).extend(v.dot(camera.forward))
        };
        let pad = DVec2::splat(PADDING_PX + 1.0) / camera.half_size_px();
        let edge = DVec2::ONE + pad;
        let planes =
            [DVec3::new(1.0, 0.0, edge.x), DVec3::new(-1.0, 0.0, edge.x), DVec3::new(0.0, 1.0, edge.y), DVec3::new(0.0, -1.0, edge.y)];
        let outline: Vec<DVec3> = (0..OUTLINE_CORNERS).map(corner).collect();
        let in_frame = planes.into_iter().fold(outline, |polygon, normal| clipped(&polygon, normal));
        // Only a camera in the rings' plane has a corner at its own position.
        if in_frame.iter().any(|p| p.z <= 0.0) {
            return Some(ClipRect::VIEWPORT);
        }
        let clips = in_frame.iter().map(|p| p.truncate() / p.z);
        let (min, max) = clips.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
        let (min, max) = (min - pad, max + pad);
        (min.x < max.x && min.y < max.y).then_some(ClipRect { left: min.x, top: max.y, right: max.x, bottom: min.y })
    }

    /// The rectangle around one half of the rings out to a radius: in front of the body's centre (`side` 1) or behind it (-1), as
    /// shaders/lib/ring/surface.wesl divides them.
    pub(crate) fn half_rect(&self, outer_km: f64, side: f64) -> Option<ClipRect> {
        let whole = self.rect(outer_km)?;
        self.half_bounds(outer_km, side).map_or(Some(whole), |half| whole.intersection(&half))
    }

    /// Bounds of one half, padded; `None` for a camera over the rings or next to them, where any pixel may show both halves.
    fn half_bounds(&self, outer_km: f64, side: f64) -> Option<ClipRect> {
        let viewer = (self.placement.body_from_icrf * -self.placement.centre_km).truncate();
        let distance = viewer.length();
        if distance < 1.01 * outer_km {
            return None;
        }
        // The halves meet where view rays are nearest to the axis. With v the camera's projection onto the plane (`viewer`), these points p form the circle
        // whose diameter runs from the centre to v. So p.v >= |p|^2 >= 0 in front, and p.v <= |p|^2 <= outer^2 behind.
        let towards = viewer / distance;
        let limit = if side > 0.0 { 0.0 } else { outer_km * outer_km / distance };
        let excess = |p: DVec2| side * (p.dot(towards) - limit);
        let body_to_icrf = self.placement.body_from_icrf.transpose();
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut include = |p: DVec2| {
            let clip = self.camera.clip(self.placement.centre_km + body_to_icrf * p.extend(0.0))?;
            (min, max) = (min.min(clip), max.max(clip));
            Some(())
        };
        for k in 0..OUTLINE_CORNERS {
            let (p, q) = (outline_corner(outer_km, k), outline_corner(outer_km, k + 1));
            if excess(p) >= 0.0 {
                include(p)?;
            }
            if (excess(p) < 0.0) != (excess(q) < 0.0) {
                include(p + (q - p) * (excess(p) / (excess(p) - excess(q))))?;
            }
        }
        let pad = DVec2::splat(PADDING_PX + 1.0) / self.camera.half_size_px();
        let (min, max) = (min - pad, max + pad);
        (min.x < max.x && min.y < max.y).then_some(ClipRect { left: min.x, top: max.y, right: max.x, bottom: min.y })
    }

    /// Maximum number of segments into which shaders/lib/ring/segments.wesl divides a pixel's footprint: one for each 32nd of an equatorial radius along the
    /// longest footprint, at most [`MAX_SEGMENTS`]. [`MIN_COSINE`] is no limit here: a footprint is as long as the true inclination of its ray makes it.
    fn max_segments(&self) -> f64 {
        let (height, axis_distance) = self.camera_height_and_axis_distance();
        let outer = self.outermost_km() / self.body.radii_km.x;
        // Across a pixel the ray turns by at most the pixel's tangent. The 5 % added to the outer radius cover pixels at the edge, whose middle is outside the
        // ring.
        let cosine = height / height.hypot(axis_distance + 1.05 * outer);
        (32.0 * 1.05 * height * self.camera.pixel_tangent() / (cosine * cosine)).ceil().clamp(1.0, MAX_SEGMENTS)
    }

    /// The view rays over the rectangle, in units of the equatorial radius on all axes.
    pub(crate) fn rays(&self, rect: ClipRect) -> DrawUniforms {
        let round = Placement { radii_km: DVec3::splat(self.body.radii_km.x), ..*self.placement };
        DrawUniforms::of_rays(&self.camera.view_rays(&round, rect, AnchorForm::Auto))
    }

    /// Whether ring-shine on the globe is visible, and its table. The table is computed only if an upper limit exceeds the threshold, or if the
    /// user requests it.
    pub fn ring_shine(&self, rings: &[&Ring], sun_radius_km: f64, user_choice: Option<bool>) -> (ThresholdCheck, Option<Arc<RingShine>>) {
        let geometry = RingShineGeometry::of(self.body, rings, self.sun, self.sun_distance_km, sun_radius_km);
        // Radiance of the ground per unit of ring-shine. The albedo counts as at least 0.01.
        let ground_radiance = self.irradiance * self.body.geometric_albedo.max(0.01);
        let upper_limit = geometry.upper_limit() * ground_radiance;
        if user_choice == Some(false) || user_choice.is_none() && !self.threshold.is_exceeded_by_radiance(upper_limit) {
            let reason = reason!("ring-shine-below", light = self.threshold.radiance_description(upper_limit));
            return (ThresholdCheck { on: false, reason }, None);
        }
        let shine = geometry.shine(&self.caches.ring_shines);
        let max_radiance = shine.as_ref().map_or(0.0, |s| s.brightest) * ground_radiance;
        let reason = reason!("ring-shine-up-to", light = self.threshold.radiance_description(max_radiance));
        (ThresholdCheck { on: self.threshold.is_exceeded_by_radiance(max_radiance), reason }, shine)
    }

    /// Uniforms of ring-shine on the globe. `phase_brightness`: the factor in the drawn albedo for the phase angle of the Sun's light. It does not apply to
    /// ring-shine and is divided out.
    pub(crate) fn shine_parameters(&self, shine: &RingShine, phase_brightness: f64) -> Vec4 {
        let sun_in_plane = self.sun.truncate().try_normalize().unwrap_or(DVec2::X);
        let [x, y, z, w] =
            [sun_in_plane.x, sun_in_plane.y, 1.0 / shine.max_height, 1.0 / phase_brightness.max(1e-6)].map(camera::narrow_scalar);
        Vec4::new(x, y, z, w)
    }

    /// The light on the rings and the range of slants of the view rays that cross them.
    fn conditions(&self, sun: Option<&Body>, pixel_view: PixelView) -> RingConditions {
        let viewer = self.placement.body_from_icrf * -self.placement.centre_km;
        let [centre_side, other_side] = sun_disc_parts(self.sun.z.abs(), self.sun_tangent(sun.map_or(0.0, |s| s.radii_km.x)).max(1e-6));
        let sunlight = if viewer.z * self.sun.z > 0.0 { [centre_side, other_side] } else { [other_side, centre_side] };
        let sunlight = sunlight.map(|part| part.map(rounded_for_reuse));
        // Slants from the point of the plane nearest to the viewer to the farthest point of any ring, drawn or not, because the middle of a pixel may lie
        // outside the drawn rings.
        let outer_km = self.outermost_km();
        let (height_km, axis_distance_km) = (viewer.z.abs().max(1e-9), viewer.truncate().length());
        // Slant of the ray to a point of the plane at this distance from the point below the viewer.
        let slant = |distance_km: f64| height_km.hypot(distance_km) / height_km;
        RingConditions::new(
            (pixel_view != PixelView::Albedo).then_some(sunlight),
            slant((axis_distance_km - outer_km).max(0.0)),
            slant(axis_distance_km + outer_km),
        )
    }

    /// The ring uniforms that the draws behind and in front of the globe share: all except `side`.
    pub(crate) fn uniforms(&self, rings: &[&Ring], sun: Option<&Body>, pixel_view: PixelView) -> RingUniforms {
        let table = self.caches.ring_tables.profile(rings, self.body.radii_km.x, &self.conditions(sun, pixel_view));
        table.map_or_else(RingUniforms::default, |table| self.uniforms_with(table, sun))
    }

    /// Ring uniforms of the globe in the rings' shadow. The table contains the rings out to the outermost with a visible shadow, or all rings if none has one.
    pub(crate) fn shadow_uniforms(&self, rings: &[&Ring], sun: Option<&Body>, model: RingShadow) -> RingUniforms {
        let tangent = self.sun_tangent(sun.map_or(0.0, |s| s.radii_km.x));
        let has_visible_shadow =
            |r: &&&Ring| self.threshold.is_exceeded_by_change(-(-r.tau_normal / self.sun.z.abs().max(MIN_COSINE)).exp_m1());
        let outer_km = rings.iter().filter(has_visible_shadow).map(|r| r.outer_km).fold(0.0, f64::max);
        let in_table: Vec<&Ring> = rings.iter().copied().filter(|r| outer_km == 0.0 || r.outer_km <= outer_km).collect();
        let slants = slants_of_sunlight(self.sun.z, tangent, model == RingShadow::Penumbra);
        let table = self.caches.ring_tables.shadow(&in_table, self.body.radii_km.x, &slants);
        table.map_or_else(RingUniforms::default, |table| self.uniforms_with(table, sun))
    }

    /// The ring uniforms for a table; `side` and ring-shine have their defaults.
    fn uniforms_with(&self, table: Arc<RingTable>, sun: Option<&Body>) -> RingUniforms {
        let (u1, u2) = sun.map(limb_darkening).unwrap_or_default();
        // 0: the asymmetry of each lobe; 1: its weight.
        let of_each_lobe = |k: usize| camera::narrow(DVec3::from_array(DUST_LOBES.map(|lobe| lobe[k])));
        let narrow = camera::narrow_scalar;
        RingUniforms {
            radius_range: Vec2::new(narrow(table.radius_range[0]), narrow(table.radius_range[1])),
            table: Some(table),
            outermost_radius: narrow(self.outermost_km() / self.body.radii_km.x),
            max_segments: narrow(self.max_segments()),
            half_pixel: narrow(0.5 / self.pixels_per_radius()),
            phase: Vec2::new(narrow(power_law_factor()), narrow(PHASE_EXPONENT)),
            dust_asymmetry: of_each_lobe(0),
            dust_weight: of_each_lobe(1),
            opposition: Vec2::new(narrow(OPPOSITION_SURGE[0]), narrow(OPPOSITION_SURGE[1])),
            side: 0.0,
            sun_tangent: narrow(self.sun_tangent(sun.map_or(0.0, |s| s.radii_km.x)).max(1e-6)),
            shadow_axes: camera::narrow(self.body.radii_km / self.body.radii_km.x),
            sun_limb_darkening_u1: camera::narrow(u1),
            sun_limb_darkening_u2: camera::narrow(u2),
            ..RingUniforms::default()
        }
    }
}
