//! What one draw is to have, and the one place that turns that choice into [`Needs`].
//!
//! Always: what a body does not have in the catalog is left out, so that no choice can ask for it.

use crate::catalog::{Body, OVERLAYS_AT_MOST, Photometry};
use crate::scene::atmosphere::species;
use crate::scene::draw::needs::{AirTier, BodyShadow, Eclipse, Flags, MapSet, Needs, PixelView, RingShadow, Shape, Surface};
use crate::scene::thresholds::LIGHTS_AT_MOST;

/// What a body could have drawn, by its catalog entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Available {
    pub ellipsoid: bool,
    pub maps: MapSet,
    pub emissive: bool,
    pub rings: bool,
}

impl Available {
    pub fn of(body: &Body) -> Self {
        let emissive = matches!(body.photometry, Photometry::Emissive { .. });
        let maps = MapSet {
            albedo: body.maps.albedo.is_some(),
            normal: body.maps.normal.is_some() && !emissive,
            specular: body.maps.specular.is_some() && !emissive,
            night: body.maps.night.is_some() && !emissive,
            cloud_shadow: body.clouds.is_some() && !emissive,
        };
        Self { ellipsoid: flattening(body) > 0.0, maps, emissive, rings: body.rings.iter().any(|r| r.tau_normal > 0.0) }
    }
}

/// Largest relative difference of two semi-axes: the most by which the ellipsoid's normal leans from the sphere's, radians.
pub fn flattening(body: &Body) -> f64 {
    1.0 - body.radii_km.min_element() / body.radii_km.max_element()
}

/// What one draw of a body is to have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chosen {
    pub ellipsoid: bool,
    /// Triangles in place of the ellipsoid, and how they are drawn.
    pub mesh: Option<Flags>,
    pub maps: MapSet,
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
    pub air: AirTier,
}

impl Chosen {
    /// Whether the rings light the globe. Moons give a thousandth of it (less beside rings that the Sun hardly lights): with both the keys of ringed bodies would be twice as many.
    fn lit_by_rings(self, body: &Body) -> bool {
        let available = Available::of(body);
        self.ring_shine && available.rings && !available.emissive
    }

    /// The structure of the draw. What the body does not have is left out, so no choice can ask for it.
    pub fn needs(self, body: &Body, view: PixelView) -> Needs {
        let available = Available::of(body);
        let air = species::structure(body, self.air);
        // Air lies on the true shape: half as many keys, and nobody misses a round one under it.
        let ellipsoid = self.ellipsoid || air.tier != AirTier::None;
        let mesh = self.mesh.zip(body.mesh.as_ref()).filter(|_| air.tier == AirTier::None).map(|(flags, model)| Flags {
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
        Needs {
            surface,
            maps: MapSet {
                albedo: self.maps.albedo && available.maps.albedo,
                normal: self.maps.normal && available.maps.normal,
                specular: self.maps.specular && available.maps.specular,
                night: self.maps.night && available.maps.night,
                cloud_shadow: self.maps.cloud_shadow && available.maps.cloud_shadow,
            },
            overlays: self.overlays.min(body.overlays.len().min(usize::from(OVERLAYS_AT_MOST)) as u8),
            lights: match (available.emissive, self.lit_by_rings(body), self.shine) {
                (true, ..) => 0,
                (false, true, _) | (false, false, 0) => 1,
                // The last of them may be dark: half as many keys.
                (false, false, _) if air.tier != AirTier::None && self.eclipse.casters > 0 => LIGHTS_AT_MOST,
                (false, false, shine) => (1 + shine).min(LIGHTS_AT_MOST),
            },
            eclipse: if available.emissive { Eclipse::default() } else { self.eclipse },
            // Under air in an eclipse the ring's shadow is left out: features.rs says so.
            ring_shadow: if available.rings && !available.emissive && (air.tier == AirTier::None || self.eclipse.casters == 0) {
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
            flags: mesh.unwrap_or_default(),
            air,
            view,
            ..Needs::LEAST
        }
    }
}

impl Chosen {
    /// The structure of the cloud shell's draw; `None` where the body has no clouds or the view shows what lies under them.
    pub fn cloud_needs(self, body: &Body, view: PixelView) -> Option<Needs> {
        let shown = body.clouds.is_some() && matches!(view, PixelView::Shaded | PixelView::Cost);
        let ground = Self { mesh: None, ..self }.needs(body, view);
        shown.then_some(Needs { surface: Surface::Cloud, maps: MapSet::default(), overlays: 0, ring_shine: false, ..ground })
    }

    /// The structure of the ring's draws; `None` where the body has none.
    pub fn ring_needs(self, body: &Body, view: PixelView) -> Option<Needs> {
        let available = Available::of(body);
        let needs =
            Needs { surface: Surface::Ring, lights: 1, eclipse: self.ring_eclipse, body_shadow: self.body_shadow, view, ..Needs::LEAST };
        (available.rings && !available.emissive).then_some(needs)
    }

    /// The structure of the draw of the air beside the ground; `None` where there is none or the view does not show it.
    pub fn sky_needs(self, body: &Body, view: PixelView) -> Option<Needs> {
        let shown = matches!(view, PixelView::Shaded | PixelView::Cost | PixelView::OpticalDepth);
        let ground = self.needs(body, view);
        let sky = Needs { surface: Surface::Sky, maps: MapSet::default(), overlays: 0, ring_shine: false, lights: 1, ..ground };
        (shown && ground.air.tier != AirTier::None).then_some(sky)
    }
}
