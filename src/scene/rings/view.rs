//! Rings: when they are drawn, when they and their planet shade each other, by which model, and with what uniforms.
//!
//! In: a placed body with rings, the camera, what is white. Out: which rings count, the models, the numbers of shaders/lib/ring. A ring is flat and
//! round here: halos, the inclination and the eccentricity of the Uranian rings (0.008 of the radius for epsilon) and the arcs of Adams are left out.

use crate::catalog::{Body, Ring};
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{self, AnchorForm, Camera, ClipRect, Placement};
use crate::scene::draw::DrawUniforms;
use crate::scene::draw::features::{BodyShadow, PixelView, RingShadow};
use crate::scene::draw::tables::{RingShine, RingTable};
use crate::scene::draw::uniforms::RingUniforms;
use crate::scene::eclipse::occluders::limb_law;
use crate::scene::purpose;
use crate::scene::resources::Caches;
use crate::scene::rings::phase::{DUST_LOBES, MIN_COSINE, OPPOSITION, PHASE_EXPONENT, phase_factor, phase_function};
use crate::scene::rings::ring_shine::{RingShineGeometry, halves};
use crate::scene::rings::ring_table::{RingSeen, slopes_of_sunlight};
use crate::scene::tiers::{self, WITHIN_PX};
use glam::{DVec2, DVec3, Vec2, Vec4};
use std::sync::Arc;

/// Thickness of the spheroid that stands for the ring where its outline is sought, over its radius.
const THIN: f64 = 1e-6;

/// What of a body's rings a frame can see.
pub struct View<'a> {
    pub body: &'a Body,
    pub camera: &'a Camera,
    pub placement: &'a Placement,
    /// Unit vector, body axes.
    pub sun: DVec3,
    pub sun_km: f64,
    /// Phase angle, radians.
    pub alpha: f64,
    /// On a plane facing the Sun.
    pub irradiance: f64,
    /// Below which a ring is left out.
    pub bound: purpose::Bound,
    pub caches: &'a Caches,
}

/// A number against its bound.
pub struct Bound {
    pub on: bool,
    pub reason: String,
}

/// The rings that can change a pixel.
pub struct Counted<'a> {
    pub rings: Vec<&'a Ring>,
    pub bound: Bound,
}

impl<'a> View<'a> {
    /// Pixels that an equatorial radius spans at the body.
    fn pixels_per_radius(&self) -> f64 {
        self.body.radii_km.x / (self.placement.centre_km.length() * self.camera.pixel_tangent())
    }

    fn cos_emission(&self) -> f64 {
        let towards = self.placement.body_from_icrf * -self.placement.centre_km;
        (towards.z / towards.length()).abs().max(MIN_COSINE)
    }

    /// By how much a ring changes a pixel at most: the part that it hides, and the radiance that it adds, each times the part of the pixel it fills.
    fn change(&self, ring: &Ring) -> [f64; 2] {
        let deep = ring.tau_normal / self.cos_emission();
        let hides = -(-deep).exp_m1();
        let albedo = ring.albedo.iter().copied().fold(0.0, f64::max);
        // Single scattering never exceeds this: each photon stopped once on its way, none lost again.
        let adds = albedo * 0.25 * phase_function(self.alpha, ring.dust) * deep.min(1.0) * self.irradiance;
        let width_px = (ring.outer_km - ring.inner_km) / self.body.radii_km.x * self.pixels_per_radius();
        [hides, adds].map(|most| most * width_px.min(1.0))
    }

    /// The same as a part of white, and whether it counts.
    fn counts(&self, ring: &Ring) -> (f64, bool) {
        let [hides, adds] = self.change(ring);
        (hides.max(self.bound.of_white(adds)), self.bound.counts_part(hides) || self.bound.counts(adds))
    }

    /// `everything`: also rings that nobody would see.
    pub fn counted(&self, everything: bool) -> Counted<'a> {
        let rings: Vec<&Ring> = self.body.rings.iter().filter(|r| r.tau_normal > 0.0).collect();
        let strongest = rings.iter().map(|r| (self.counts(r).0, r.name.as_str())).max_by(|a, b| a.0.total_cmp(&b.0));
        let outer = rings.iter().filter(|r| self.counts(r).1 || everything).map(|r| r.outer_km).fold(0.0, f64::max);
        // Gaps come along: they lie over what they are gaps in.
        let seen: Vec<&Ring> = self.body.rings.iter().filter(|r| r.outer_km <= outer).collect();
        let area_px = std::f64::consts::PI * (outer / self.body.radii_km.x * self.pixels_per_radius()).powi(2);
        let reason = match strongest {
            None => "it has no rings".into(),
            Some((part, name)) if seen.is_empty() => {
                format!("the strongest, {name}, changes a pixel by {part:.2e} of white against {:.2e}", self.bound.least_part())
            }
            Some((part, name)) => {
                format!("{name} changes a pixel by {part:.2e} of white; out to {outer:.0} km, {area_px:.1} px against 0.5")
            }
        };
        Counted { bound: Bound { on: !seen.is_empty() && area_px > 0.5, reason }, rings: seen }
    }

    /// Whether any of its rings can be in the picture.
    pub fn meets_frame(&self) -> bool {
        self.rect(self.body.rings.iter().map(|r| r.outer_km).fold(0.0, f64::max)).is_some()
    }

    fn sun_tangent(&self, sun_radius_km: f64) -> f64 {
        sun_radius_km / self.sun_km
    }

    /// Whether the ring takes light from the lit globe, and the model that it takes.
    pub fn ring_shadow(&self, rings: &[&Ring], sun_radius_km: f64) -> (Bound, RingShadow) {
        let sine = self.sun.z.abs();
        let tangent = self.sun_tangent(sun_radius_km);
        // A path from the lit globe to the Sun meets the plane no farther out than the Sun's cylinder through the terminator does.
        let farthest_km = self.body.radii_km.x / sine.max(1e-9);
        let darkest =
            rings.iter().filter(|r| r.inner_km < farthest_km).map(|r| -(-r.tau_normal / sine.max(MIN_COSINE)).exp_m1()).fold(0.0, f64::max);
        let penumbra_px = tangent / sine.max(tangent) / sine.max(tangent) * self.pixels_per_radius();
        let model = if penumbra_px > WITHIN_PX { RingShadow::Penumbra } else { RingShadow::PointSun };
        let reason = format!(
            "the Sun stands {:.3} degrees over their plane and they take {}; penumbra up to {penumbra_px:.1} px",
            sine.asin().to_degrees(),
            self.bound.said_part(darkest)
        );
        (Bound { on: self.bound.counts_part(darkest) && sine > 0.0, reason }, model)
    }

    /// Whether the globe's shadow meets the ring, and the model that it takes.
    pub fn body_shadow(&self, rings: &[&Ring], sun_radius_km: f64) -> (Bound, BodyShadow) {
        let inner_km = rings.iter().filter(|r| r.tau_normal > 0.0).map(|r| r.inner_km).fold(f64::INFINITY, f64::min);
        let outer_km = rings.iter().map(|r| r.outer_km).fold(0.0, f64::max);
        // The shadow's cylinder passes this far over the innermost ring's nearest point.
        let aside = inner_km * self.sun.z.abs() / self.body.radii_km.x;
        let outer = outer_km / self.body.radii_km.x;
        let flat = tiers::sphere_shadow_offset(self.body.radii_km.z / self.body.radii_km.x, self.sun.z, outer);
        let soft = 2.0 * self.sun_tangent(sun_radius_km) * outer;
        let aside_px = flat.max(soft) * self.pixels_per_radius();
        let model = if aside_px > WITHIN_PX { BodyShadow::EllipsoidPenumbra } else { BodyShadow::Sphere };
        let reason =
            format!("the shadow's axis passes {aside:.3} radii from the innermost ring; oblateness and penumbra make {aside_px:.1} px");
        (Bound { on: aside < 1.0, reason }, model)
    }

    /// The outline of the outermost counted ring: the rectangle to draw.
    pub fn rect(&self, outer_km: f64) -> Option<ClipRect> {
        let disc = Placement { radii_km: DVec3::new(outer_km, outer_km, outer_km * THIN), ..*self.placement };
        if disc.camera_is_inside() {
            return Some(ClipRect::VIEWPORT);
        }
        Outline::of(self.camera, &disc).rect(self.camera)
    }

    /// The view rays over the rectangle, in the ring's frame: the equatorial radius on all axes.
    pub fn rays(&self, rect: ClipRect) -> DrawUniforms {
        let round = Placement { radii_km: DVec3::splat(self.body.radii_km.x), ..*self.placement };
        DrawUniforms::of_rays(&self.camera.view_rays(&round, rect, AnchorForm::Auto))
    }

    /// Whether the rings light the globe: what its albedo turns back.
    /// The table is made only where the rings' bound allows that it counts, or where it is asked for.
    pub fn ring_shine(&self, rings: &[&Ring], sun_radius_km: f64, asked: Option<bool>) -> (Bound, Option<Arc<RingShine>>) {
        let lit = RingShineGeometry {
            rings,
            radius_km: self.body.radii_km.x,
            polar: self.body.radii_km.z / self.body.radii_km.x,
            sine: self.sun.z,
            sun_tangent: self.sun_tangent(sun_radius_km),
        };
        let radiance = self.irradiance * self.body.geometric_albedo.max(0.01);
        let at_most = lit.at_most() * radiance;
        if asked == Some(false) || asked.is_none() && !self.bound.counts(at_most) {
            let reason = format!("ring-shine below {}", self.bound.description(at_most));
            return (Bound { on: false, reason }, None);
        }
        let shine = lit.shine(&self.caches.ring_shines);
        let most = shine.as_ref().map_or(0.0, |s| s.brightest) * radiance;
        let reason = format!("ring-shine up to {}", self.bound.description(most));
        (Bound { on: self.bound.counts(most), reason }, shine)
    }

    /// Uniforms of the light on the globe. `undo`: what the albedo has been multiplied by for the Sun's phase, which this light does not share.
    pub fn shine_axes(&self, shine: &RingShine, undo: f64) -> Vec4 {
        let level = self.sun.truncate().try_normalize().unwrap_or(DVec2::X);
        let [x, y, z, w] = [level.x, level.y, 1.0 / shine.reach, 1.0 / undo.max(1e-6)].map(camera::narrow_scalar);
        Vec4::new(x, y, z, w)
    }

    /// The light on rings and the view rays that meet them.
    fn seen(&self, rings: &[&Ring], sun: Option<&Body>, shows: PixelView) -> RingSeen {
        let viewer = self.placement.body_from_icrf * -self.placement.centre_km;
        let [same, other] = halves(self.sun.z.abs(), self.sun_tangent(sun.map_or(0.0, |s| s.radii_km.x)).max(1e-6));
        let sunlight = if viewer.z * self.sun.z > 0.0 { [same, other] } else { [other, same] };
        // From the place in the plane that is nearest to the viewer to the farthest.
        let outer_km = rings.iter().map(|r| r.outer_km).fold(0.0, f64::max);
        let (height, aside) = (viewer.z.abs().max(1e-9), viewer.truncate().length());
        let slope = |along: f64| height.hypot(along) / height;
        RingSeen::new((shows != PixelView::Albedo).then_some(sunlight), slope((aside - outer_km).max(0.0)), slope(aside + outer_km))
    }

    /// The uniforms of both draws; `half` is set by each.
    pub fn uniforms(&self, rings: &[&Ring], sun: Option<&Body>, shows: PixelView) -> RingUniforms {
        let table = self.caches.ring_tables.profile(rings, self.body.radii_km.x, &self.seen(rings, sun, shows));
        table.map_or_else(RingUniforms::default, |table| self.uniforms_with(table, sun))
    }

    /// Those of the globe in the rings' shadow: out to the last ring that takes light which counts, or all of them where none does.
    pub fn shadow_uniforms(&self, rings: &[&Ring], sun: Option<&Body>, model: RingShadow) -> RingUniforms {
        let tangent = self.sun_tangent(sun.map_or(0.0, |s| s.radii_km.x));
        let counts = |r: &&&Ring| self.bound.counts_part(-(-r.tau_normal / self.sun.z.abs().max(MIN_COSINE)).exp_m1());
        let outer = rings.iter().filter(counts).map(|r| r.outer_km).fold(0.0, f64::max);
        let seen: Vec<&Ring> = rings.iter().copied().filter(|r| outer == 0.0 || r.outer_km <= outer).collect();
        let slopes = slopes_of_sunlight(self.sun.z, tangent, model == RingShadow::Penumbra);
        let table = self.caches.ring_tables.shadow(&seen, self.body.radii_km.x, &slopes);
        table.map_or_else(RingUniforms::default, |table| self.uniforms_with(table, sun))
    }

    fn uniforms_with(&self, table: Arc<RingTable>, sun: Option<&Body>) -> RingUniforms {
        let (u1, u2) = sun.map(limb_law).unwrap_or_default();
        let lobe = |k: usize| camera::narrow(DVec3::from_array(DUST_LOBES.map(|l| l[k])));
        let narrow = camera::narrow_scalar;
        RingUniforms {
            reach: Vec2::new(narrow(table.reach[0]), narrow(table.reach[1])),
            table: Some(table),
            blur: narrow(0.5 / self.pixels_per_radius()),
            phase: Vec2::new(narrow(phase_factor()), narrow(PHASE_EXPONENT)),
            dust_asymmetry: lobe(0),
            dust_weight: lobe(1),
            opposition: Vec2::new(narrow(OPPOSITION[0]), narrow(OPPOSITION[1])),
            half: 0.0,
            sun_tangent: narrow(self.sun_tangent(sun.map_or(0.0, |s| s.radii_km.x)).max(1e-6)),
            shadow_axes: camera::narrow(self.body.radii_km / self.body.radii_km.x),
            sun_limb_u1: camera::narrow(u1),
            sun_limb_u2: camera::narrow(u2),
            ..RingUniforms::default()
        }
    }
}
