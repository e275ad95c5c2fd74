//! What one draw is to have, and the one place that turns that choice into [`DrawFeatures`].
//!
//! Always: what a body does not have in the catalog is left out, so that no choice can ask for it.

use crate::catalog::{Body, MAX_OVERLAYS, NaifId, Photometry};
use crate::scene::atmosphere::species;
use crate::scene::draw::features::{
    AtmosphereModel, BodyShadow, DrawFeatures, Eclipse, Flags, MapSet, PixelView, RingShadow, Shape, Surface,
};
use crate::scene::thresholds::MAX_LIGHTS;

/// What a body could have drawn, by its catalog entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    pub ellipsoid: bool,
    pub maps: MapSet,
    pub emissive: bool,
    pub rings: bool,
    /// Its ground keeps craters: solid, without air.
    pub detail: bool,
    /// Which custom surface colours its ground, 0 for none.
    pub custom_surface: u8,
    /// The Moon, and the Sun behind it.
    pub limb_heights: bool,
}

impl Capabilities {
    pub fn of(body: &Body) -> Self {
        let emissive = matches!(body.photometry, Photometry::Emissive { .. });
        let maps = MapSet {
            albedo: body.maps.albedo.is_some(),
            normal: body.maps.normal.is_some() && !emissive,
            specular: body.maps.specular.is_some() && !emissive,
            night: body.maps.night.is_some() && !emissive,
            cloud_shadow: body.clouds.is_some() && !emissive,
        };
        let detail = body.cratered && !emissive && body.atmosphere.is_none() && body.clouds.is_none();
        let limb_heights = [NaifId::MOON, NaifId::SUN].contains(&body.id);
        Self {
            detail,
            custom_surface: body.custom_surface,
            ellipsoid: flattening(body) > 0.0,
            maps,
            emissive,
            rings: body.rings.iter().any(|r| r.tau_normal > 0.0),
            limb_heights,
        }
    }
}

/// Largest relative difference of two semi-axes: the most by which the ellipsoid's normal leans from the sphere's, radians.
pub fn flattening(body: &Body) -> f64 {
    1.0 - body.radii_km.min_element() / body.radii_km.max_element()
}

/// What one draw of a body is to have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeatureSelection {
    pub ellipsoid: bool,
    /// Triangles in place of the ellipsoid, and how they are drawn.
    pub mesh: Option<Flags>,
    pub maps: MapSet,
    /// Relief and albedo finer than the maps.
    pub detail: bool,
    /// The custom surface that the body has.
    pub custom_surface: bool,
    /// Images over the ground.
    pub overlays: u8,
    /// Lights besides the Sun, strongest first.
    pub shine: u8,
    pub eclipse: Eclipse,
    /// Of the sunlight on its rings.
    pub ring_eclipse: Eclipse,
    pub ring_shadow: RingShadow,
    /// The rings light the globe.
    pub ring_shine: bool,
    pub body_shadow: BodyShadow,
    /// How the air is summed; `None` without it.
    pub air: AtmosphereModel,
    /// The limb by the Moon's own heights.
    pub limb_heights: bool,
}

impl FeatureSelection {
    /// Whether the rings light the globe. Moons give a thousandth of it (less beside rings that the Sun hardly lights): with both the keys of ringed bodies would be twice as many.
    fn lit_by_rings(self, body: &Body) -> bool {
        let available = Capabilities::of(body);
        self.ring_shine && available.rings && !available.emissive
    }

    /// The structure of the draw. What the body does not have is left out, so no choice can ask for it.
    pub fn features(self, body: &Body, view: PixelView) -> DrawFeatures {
        let available = Capabilities::of(body);
        let air = species::structure(body, self.air);
        // Air lies on the true shape: half as many keys, and nobody misses a round one under it.
        let ellipsoid = self.ellipsoid || air.tier != AtmosphereModel::None;
        let mesh = self.mesh.zip(body.mesh.as_ref()).filter(|_| air.tier == AtmosphereModel::None).map(|(flags, model)| Flags {
            two_sided: flags.two_sided && model.two_sided,
            alpha_texture: flags.alpha_texture && model.alpha && self.maps.albedo && available.maps.albedo,
            vertex_colour: flags.vertex_colour && model.vertex_colours,
        });
        let surface = match body.photometry {
            Photometry::Emissive { .. } => Surface::Emissive,
            Photometry::Lambert => Surface::Lambert,
            Photometry::LommelSeeliger => Surface::LommelSeeliger,
            Photometry::LunarLambert { .. } => Surface::LunarLambert,
            Photometry::OrenNayar { .. } => Surface::OrenNayar,
        };
        DrawFeatures {
            surface,
            maps: MapSet {
                albedo: self.maps.albedo && available.maps.albedo,
                normal: self.maps.normal && available.maps.normal,
                specular: self.maps.specular && available.maps.specular,
                night: self.maps.night && available.maps.night,
                cloud_shadow: self.maps.cloud_shadow && available.maps.cloud_shadow,
            },
            // In an eclipse it is left out, which halves those keys.
            detail: self.detail
                && available.detail
                && mesh.is_none()
                && self.eclipse.occluders == 0
                && matches!(view, PixelView::Final | PixelView::Cost),
            custom_surface: if self.custom_surface { available.custom_surface } else { 0 },
            overlays: self.overlays.min(body.overlays.len().min(usize::from(MAX_OVERLAYS)) as u8),
            lights: match (available.emissive, self.lit_by_rings(body), self.shine) {
                (true, ..) => 0,
                (false, true, _) | (false, false, 0) => 1,
                // The last of them may be dark: half as many keys.
                (false, false, _) if air.tier != AtmosphereModel::None && self.eclipse.occluders > 0 => MAX_LIGHTS,
                (false, false, shine) => (1 + shine).min(MAX_LIGHTS),
            },
            eclipse: if available.emissive { Eclipse::default() } else { self.eclipse },
            // Under air in an eclipse the ring's shadow is left out: features.rs says so.
            ring_shadow: if available.rings && !available.emissive && (air.tier == AtmosphereModel::None || self.eclipse.occluders == 0) {
                self.ring_shadow
            } else {
                RingShadow::None
            },
            ring_shine: self.lit_by_rings(body),
            shape: match mesh {
                Some(_) => Shape::Mesh,
                None if ellipsoid && available.ellipsoid => Shape::Ellipsoid,
                None => Shape::Sphere,
            },
            limb_heights: self.limb_heights && available.limb_heights && mesh.is_none() && !self.detail && self.eclipse.occluders == 0,
            flags: mesh.unwrap_or_default(),
            air,
            view,
            ..DrawFeatures::MINIMAL
        }
    }
}

impl FeatureSelection {
    /// The structure of the cloud shell's draw; `None` where the body has no clouds or the view shows what lies under them.
    pub fn cloud_needs(self, body: &Body, view: PixelView) -> Option<DrawFeatures> {
        let shown = body.clouds.is_some() && matches!(view, PixelView::Final | PixelView::Cost);
        let ground = Self { mesh: None, ..self }.features(body, view);
        shown.then_some(DrawFeatures {
            surface: Surface::Cloud,
            maps: MapSet::default(),
            detail: false,
            custom_surface: 0,
            overlays: 0,
            ring_shine: false,
            limb_heights: false,
            ..ground
        })
    }

    /// The structure of the ring's draws; `None` where the body has none.
    pub fn ring_needs(self, body: &Body, view: PixelView) -> Option<DrawFeatures> {
        let available = Capabilities::of(body);
        let features = DrawFeatures {
            surface: Surface::Ring,
            lights: 1,
            eclipse: self.ring_eclipse,
            body_shadow: self.body_shadow,
            view,
            ..DrawFeatures::MINIMAL
        };
        (available.rings && !available.emissive).then_some(features)
    }

    /// The structure of the draw of the air beside the ground; `None` where there is none or the view does not show it.
    pub fn sky_needs(self, body: &Body, view: PixelView) -> Option<DrawFeatures> {
        let shown = matches!(view, PixelView::Final | PixelView::Cost | PixelView::OpticalDepth);
        let ground = self.features(body, view);
        let sky = DrawFeatures {
            surface: Surface::Sky,
            maps: MapSet::default(),
            detail: false,
            custom_surface: 0,
            overlays: 0,
            ring_shine: false,
            limb_heights: false,
            lights: 1,
            ..ground
        };
        (shown && ground.air.tier != AtmosphereModel::None).then_some(sky)
    }
}
