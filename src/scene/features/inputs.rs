//! The inputs and the results of the decisions about one body.
//!
//! In: a frame and a placed body. Out: [`DecisionInputs`], the input of every effect's decision; [`Decisions`], which the decision about each effect extends
//! and passes on to the next.

use crate::catalog::{Body, Catalog, NaifId, Overlay, Photometry};
use crate::mesh::Mesh;
use crate::scene::atmosphere::air::SurroundingAir;
use crate::scene::camera::silhouette::Outline;
use crate::scene::camera::{Camera, ClipRect};
use crate::scene::decision::DecisionLog;
use crate::scene::draw::uniforms::{EclipseUniforms, RingUniforms};
use crate::scene::draw::{Draw, PixelView};
use crate::scene::eclipse::sun_occluders;
use crate::scene::features::choice::FeatureSelection;
use crate::scene::light::lights::{self, IncidentLight, Reflector};
use crate::scene::placed::PlacedBody;
use crate::scene::point;
use crate::scene::purpose::Threshold;
use crate::scene::request::effects::{Effect, EffectOverrides};
use crate::scene::resources::Context;
use crate::scene::rings::view::RingView;
use crate::scene::surface::meshes;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Inputs that the decisions about all bodies of a frame have in common.
#[derive(Clone, Copy)]
pub(crate) struct FrameContext<'a> {
    pub context: Context<'a>,
    pub catalog: &'a Catalog,
    pub camera: &'a Camera,
    /// The threshold below which effects are left out.
    pub threshold: Threshold,
    /// All placed bodies, the Sun among them, as sources of light for each other.
    pub reflectors: &'a [Reflector<'a>],
    /// The atmosphere around the camera, if it is in one.
    pub air: Option<&'a SurroundingAir<'a>>,
}

/// One body of a frame, with the inputs of the decisions about it.
pub(crate) struct DecisionInputs<'c, 'a> {
    pub frame: &'c FrameContext<'c>,
    pub placed: &'c PlacedBody<'a>,
    /// Apparent diameter, from [`diameter_px`].
    pub diameter_px: f64,
    /// The rectangle that bounds the globe or mesh in the image; `None` if the body is outside the image.
    pub rect: Option<ClipRect>,
    /// The triangles of the body's shape model, if it is drawn as these; otherwise `None`.
    pub mesh: Option<&'c Arc<Mesh>>,
    /// The geometry of the body's rings, if the rings, or the globe that they shade and light, may be in the image.
    pub ring_view: Option<RingView<'c>>,
    /// Fraction of the body's light that is drawn as a disc; the rest is drawn as a point.
    pub disc_fraction: f64,
    /// Fraction of the disc's light that is in its glare (`light::disc_glare`), and that the draws of the disc therefore lack. 0 until the
    /// glare is decided (`scene::features`).
    pub glare_fraction: f64,
}

/// Apparent diameter of a body in pixels: that of a circle with the area of the body's outline, if the outline is an ellipse in front of the camera. Otherwise
/// an estimate from radius and distance, also for a body behind the camera, because its rings may reach into the frame. 0 with the camera at the centre.
pub(crate) fn diameter_px(camera: &Camera, placed: &PlacedBody<'_>) -> f64 {
    match placed.outline {
        Outline::Ellipse { area_px, .. } => 2.0 * (area_px / PI).sqrt(),
        _ if placed.distance_km <= 0.0 => 0.0,
        Outline::Open | Outline::Beside | Outline::Behind => 2.0 * placed.body.radii_km.x / placed.distance_km / camera.pixel_tangent(),
    }
}

impl<'c, 'a> DecisionInputs<'c, 'a> {
    pub(crate) fn of(frame: &'c FrameContext<'c>, placed: &'c PlacedBody<'a>) -> Self {
        let camera = frame.camera;
        let diameter_px = diameter_px(camera, placed);
        let mesh = meshes::mesh_of(frame.context, placed.body);
        let rect = mesh.map_or_else(|| placed.outline.rect(camera), |m| meshes::rect(camera, &placed.placement, m));
        let ring_view = ring_view(frame, placed).filter(|v| rect.is_some() || v.meets_frame());
        let disc_fraction = point::drawn_disc_fraction(frame.context.request.effects.override_of(Effect::Points), placed, diameter_px);
        Self { frame, placed, diameter_px, rect, mesh, ring_view, disc_fraction, glare_fraction: 0.0 }
    }

    /// Fraction of the body's light that the draws of its disc show.
    pub(crate) fn drawn_fraction(&self) -> f64 {
        self.disc_fraction * (1.0 - self.glare_fraction)
    }

    /// Transmittance of the air around the camera in front of the body, linear RGB; 1 without such air. The draws of the body that has this air apply it
    /// themselves.
    pub(crate) fn transmittance(&self) -> DVec3 {
        let air = self.frame.air.filter(|a| a.body.id != self.placed.body.id);
        air.map_or(DVec3::ONE, |a| a.transmittance(self.placed.placement.centre_km))
    }

    /// The geometry of the body's rings, also if neither they nor the globe are in the image: they shade its air.
    pub(crate) fn ring_view_for_air(&self) -> Option<RingView<'c>> {
        ring_view(self.frame, self.placed)
    }

    pub(crate) fn body(&self) -> &'c Body {
        self.placed.body
    }

    pub(crate) fn threshold(&self) -> Threshold {
        self.frame.threshold
    }

    pub(crate) fn effects(&self) -> &'c EffectOverrides {
        &self.frame.context.request.effects
    }

    pub(crate) fn pixel_view(&self) -> PixelView {
        self.frame.context.request.pixel_view
    }

    /// Ground that a pixel spans in the middle of the disc, in degrees about the body's centre.
    pub(crate) fn ground_deg_per_px(&self) -> f64 {
        let (distance_km, radius_km) = (self.placed.distance_km, self.body().radii_km.x);
        ((distance_km / radius_km - 1.0).max(0.0) * self.frame.camera.pixel_tangent()).to_degrees()
    }

    /// The Sun; `None` if it is not among the placed bodies.
    pub(crate) fn sun(&self) -> Option<&'c Body> {
        self.frame.reflectors.iter().map(|r| r.body).find(|b| b.id == NaifId::SUN)
    }

    /// An empty list of decisions about the body.
    pub(crate) fn log(&self) -> DecisionLog<'c> {
        DecisionLog::new(self.effects(), self.frame.context.resources)
    }
}

/// The geometry of a body's rings, the input of the decisions about them; `None` without rings, or for an emissive body, whose rings are not drawn.
fn ring_view<'c>(frame: &'c FrameContext<'c>, placed: &'c PlacedBody<'_>) -> Option<RingView<'c>> {
    let has_lit_rings = !placed.body.rings.is_empty() && !matches!(placed.body.photometry, Photometry::Emissive { .. });
    if !has_lit_rings {
        return None;
    }
    let past_other_rings = sun_occluders::shown_sunlight_past_rings(frame.context, placed);
    Some(RingView {
        body: placed.body,
        camera: frame.camera,
        placement: &placed.placement,
        sun: (placed.body_from_icrf * placed.body_to_sun_km).normalize(),
        sun_distance_km: placed.body_to_sun_km.length(),
        phase_angle_rad: placed.phase_angle_rad,
        irradiance: (lights::sunlight(placed.body_to_sun_km).irradiance * past_other_rings).max_element(),
        threshold: frame.threshold,
        caches: frame.context.caches,
    })
}

/// The decisions about one body so far: selected features, uniforms, finished draws of sky, clouds and rings, and reasons.
pub(crate) struct Decisions<'c> {
    pub log: DecisionLog<'c>,
    pub chosen: FeatureSelection,
    /// Lights in addition to the Sun, strongest first.
    pub secondary_lights: Vec<IncidentLight>,
    /// Occluders of the globe, its air and its clouds.
    pub eclipse: EclipseUniforms,
    /// Factor on the sunlight of globe, air, clouds and rings, per channel: less than 1 where the rings of another body dim it evenly
    /// (`eclipse::decision`).
    pub sunlight_factor: DVec3,
    /// The uniforms of the rings' shadow and of ring-shine, for the draws of globe and sky.
    pub ring: RingUniforms,
    /// The overlays that are drawn, the lowest first.
    pub overlays: Vec<&'c Overlay>,
    /// The value of [`crate::scene::draw::AtmosphereUniforms::blend_mode`].
    pub blend_mode: f32,
    /// The value of [`crate::scene::draw::AtmosphereUniforms::map_weight`].
    pub map_weight: f32,
    /// The value of [`crate::scene::draw::AtmosphereUniforms::second_light_irradiance`].
    pub second_light_irradiance: Vec3,
    /// Fraction of the night sky's light that lights ground and clouds; 1 unless the decision about the atmosphere sets it.
    pub night_fraction_on_ground: f32,
    /// Direction of the Sun in body axes and its angular radius in radians, if a mesh casts shadows on itself.
    pub self_shadow: Option<(DVec3, f64)>,
    /// The draw of the atmosphere beyond the limb.
    pub sky: Option<Draw>,
    /// The draw of the cloud shell.
    pub clouds: Option<Draw>,
    /// Draws of both halves of the rings: behind the globe and in front of it.
    pub rings: Vec<Draw>,
}

impl<'c> Decisions<'c> {
    pub(crate) fn new(log: DecisionLog<'c>) -> Self {
        Self {
            log,
            chosen: FeatureSelection::default(),
            secondary_lights: Vec::new(),
            eclipse: EclipseUniforms::default(),
            sunlight_factor: DVec3::ONE,
            ring: RingUniforms::default(),
            overlays: Vec::new(),
            blend_mode: 0.0,
            map_weight: 0.0,
            second_light_irradiance: Vec3::ZERO,
            night_fraction_on_ground: 1.0,
            self_shadow: None,
            sky: None,
            clouds: None,
            rings: Vec::new(),
        }
    }

    /// Irradiance of the body by the Sun, per channel, as its draws have it: dimmed by the rings of other bodies. The shadows of other bodies themselves, which
    /// differ from place to place, are left out.
    pub(crate) fn sunlight(&self, placed: &PlacedBody<'_>) -> DVec3 {
        lights::sunlight(placed.body_to_sun_km).irradiance * self.sunlight_factor
    }
}

/// Decides on one effect or a group of them, given the earlier decisions; returns the earlier decisions with its own added.
pub(crate) type DecideEffect = for<'c> fn(&DecisionInputs<'c, '_>, Decisions<'c>) -> Decisions<'c>;

/// Runs functions that decide, in order; each reads the decisions of those before it.
pub(crate) fn decide_in_order<'c>(steps: &[DecideEffect], inputs: &DecisionInputs<'c, '_>, decisions: Decisions<'c>) -> Decisions<'c> {
    steps.iter().fold(decisions, |decisions, decide| decide(inputs, decisions))
}
