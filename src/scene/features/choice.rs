//! Turns the features selected for the draws of one body into [`DrawFeatures`]. Nothing else does so.
//!
//! In: a [`FeatureSelection`], a body and a pixel view. Out: the [`DrawFeatures`] of each of the body's draws. Always: they contain no feature that
//! the body's catalog entry does not allow, whatever the selection says.

use crate::catalog::{Body, InventedRelief, MAX_OVERLAYS, NaifId, Photometry};
use crate::scene::atmosphere::species;
use crate::scene::draw::features::{
    AirPass, AtmosphereModel, BodyShadow, Detail, DrawFeatures, Eclipse, MAX_AIR_LIGHTS, MapSet, MeshFlags, PixelView, RingShadow, Shape,
    Surface,
};
use crate::scene::thresholds::MAX_LIGHTS;

/// The features that a body's catalog entry allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyCapabilities {
    /// Whether the semi-axes differ.
    pub is_flattened: bool,
    /// The maps that the draws of the body can read.
    pub maps: MapSet,
    /// Whether the body emits light, as the Sun does.
    pub is_emissive: bool,
    /// Whether the body has a visible ring: one with an optical depth above 0.
    pub has_rings: bool,
    /// The kind of procedural relief of the ground.
    pub detail: Detail,
    /// Number of the custom surface that colours the ground; 0 for none.
    pub custom_surface: u8,
    /// Whether the body's draw can use the lunar limb profile: only the Moon's and that of the Sun, which the Moon can cover.
    pub limb_heights: bool,
}

impl BodyCapabilities {
    pub(crate) fn of(body: &Body) -> Self {
        let is_emissive = matches!(body.photometry, Photometry::Emissive { .. });
        let maps = MapSet {
            albedo: body.maps.albedo.is_some(),
            normal: body.maps.normal.is_some() && !is_emissive,
            specular: body.maps.specular.is_some() && !is_emissive,
            night: body.maps.night.is_some() && !is_emissive,
            cloud_shadow: body.clouds.is_some() && !is_emissive,
        };
        let has_air_or_clouds = body.atmosphere.is_some() || body.clouds.is_some();
        let detail = match body.invented_relief {
            InventedRelief::Hills if !is_emissive => Detail::Hills,
            InventedRelief::Craters if !is_emissive && !has_air_or_clouds => Detail::Craters,
            _ => Detail::None,
        };
        let limb_heights = [NaifId::MOON, NaifId::SUN].contains(&body.id);
        Self {
            detail,
            custom_surface: body.custom_surface,
            is_flattened: ellipsoid_flattening(body) > 0.0,
            maps,
            is_emissive,
            has_rings: body.rings.iter().any(|r| r.tau_normal > 0.0),
            limb_heights,
        }
    }
}

/// Largest relative difference of two semi-axes. To first order also the largest angle in radians between the ellipsoid's normal at a point and the direction
/// to this point from the centre.
pub fn ellipsoid_flattening(body: &Body) -> f64 {
    1.0 - body.radii_km.min_element() / body.radii_km.max_element()
}

/// The features selected for the draws of one body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeatureSelection {
    /// Whether the ellipsoid is drawn in place of a sphere. Under an atmosphere it always is.
    pub ellipsoid: bool,
    /// Properties of the mesh that is drawn in place of the ellipsoid; `None` without a mesh.
    pub mesh: Option<MeshFlags>,
    /// The maps that are read.
    pub maps: MapSet,
    /// Whether the ground has procedural relief and albedo finer than the maps.
    pub detail: bool,
    /// Whether the clouds have procedural billows finer than the cloud map.
    pub cloud_detail: bool,
    /// Whether the body's custom surface is drawn.
    pub custom_surface: bool,
    /// Number of images over the ground.
    pub overlays: u8,
    /// Number of lights in addition to the Sun.
    pub secondary_light_count: u8,
    /// Whether the sky's draw shows the light of the strongest secondary light, too.
    pub second_light_in_air: bool,
    /// The eclipse of the sunlight on globe, air and clouds.
    pub eclipse: Eclipse,
    /// The eclipse of the sunlight on the body's rings.
    pub ring_eclipse: Eclipse,
    /// The shadow of rings, the body's own or those of another body, on the globe, its air and its clouds.
    pub ring_shadow: RingShadow,
    /// Whether ring-shine lights the globe.
    pub ring_shine: bool,
    /// The globe's shadow on the rings.
    pub body_shadow: BodyShadow,
    /// The model of the atmosphere; [`AtmosphereModel::None`] without an atmosphere.
    pub air_model: AtmosphereModel,
    /// Whether the air in front of ground and clouds is interpolated from the coarse image (`air-pass`), and whether the
    /// ground's draw then also shows the clouds.
    pub air_pass: AirPass,
    /// Whether the lunar limb profile shapes the limb.
    pub limb_heights: bool,
    /// Whether the sunlit crescent is so thin that the draws of ground and clouds average its light over each pixel.
    pub thin_crescent: bool,
    /// Whether the rim of air beyond the limb is so thin on the screen that its draw averages its light over each pixel.
    pub thin_rim: bool,
}

impl FeatureSelection {
    /// Whether ring-shine is selected and possible. Ring-shine excludes planet-shine, because supporting both would double the number of shader keys of ringed
    /// bodies. Moons light a ringed globe about a thousand times less than its rings do, and still less when the Sun is nearly in the rings' plane.
    fn has_ring_shine(self, body: &Body) -> bool {
        let available = BodyCapabilities::of(body);
        self.ring_shine && available.has_rings && !available.is_emissive
    }

    /// Whether the ground's draw can show the clouds. To limit the number of shader keys, it can do so only with albedo, normal and cloud maps, and without
    /// overlays, a mesh and the other features tested here.
    pub(crate) fn shows_clouds_on_ground(self, body: &Body) -> bool {
        let available = BodyCapabilities::of(body);
        let has_maps = self.maps.albedo
            && available.maps.albedo
            && self.maps.normal
            && available.maps.normal
            && self.maps.cloud_shadow
            && available.maps.cloud_shadow;
        let has_other_features = self.detail
            || self.cloud_detail
            || self.custom_surface
            || self.mesh.is_some()
            || self.ring_shine
            || self.limb_heights
            || self.thin_crescent;
        has_maps && !has_other_features && self.overlays == 0
    }

    /// The features of the globe's draw, without features that the body does not have.
    pub(crate) fn globe_features(self, body: &Body, view: PixelView) -> DrawFeatures {
        let available = BodyCapabilities::of(body);
        let air = species::air_features(body, self.air_model);
        // Under an atmosphere a flattened body is always drawn as an ellipsoid, even if a sphere would be accurate enough: this halves the number of keys.
        let ellipsoid = self.ellipsoid || air.model != AtmosphereModel::None;
        let mesh = self.mesh.zip(body.mesh.as_ref()).filter(|_| air.model == AtmosphereModel::None).map(|(flags, shape_model)| MeshFlags {
            two_sided: flags.two_sided && shape_model.two_sided,
            alpha_texture: flags.alpha_texture && shape_model.has_map_alpha && self.maps.albedo && available.maps.albedo,
            vertex_colour: flags.vertex_colour && shape_model.uses_vertex_colours,
        });
        let surface = match body.photometry {
            Photometry::Emissive { .. } => Surface::Emissive,
            Photometry::Lambert => Surface::Lambert,
            Photometry::LommelSeeliger => Surface::LommelSeeliger,
            Photometry::LunarLambert { .. } => Surface::LunarLambert,
            Photometry::OrenNayar { .. } => Surface::OrenNayar,
        };
        let in_foreign_ring_shadow = self.ring_shadow == RingShadow::OfPlanet && !available.has_rings && !available.is_emissive;
        DrawFeatures {
            surface,
            maps: MapSet {
                albedo: self.maps.albedo && available.maps.albedo,
                normal: self.maps.normal && available.maps.normal,
                specular: self.maps.specular && available.maps.specular,
                night: self.maps.night && available.maps.night,
                cloud_shadow: self.maps.cloud_shadow && available.maps.cloud_shadow,
            },
            detail: if self.detail && mesh.is_none() && view.shows_radiance() { available.detail } else { Detail::None },
            custom_surface: if self.custom_surface { available.custom_surface } else { 0 },
            overlays: self.overlays.min(body.overlays.len().min(usize::from(MAX_OVERLAYS)) as u8),
            // The Sun is the first light. An emissive body has none, and ring-shine excludes secondary lights.
            lights: match (available.is_emissive, self.has_ring_shine(body), self.secondary_light_count) {
                (true, ..) => 0,
                (false, true, _) | (false, false, 0) => 1,
                // With secondary lights, the number of lights is rounded up to the maximum, which halves the number of keys with air, an eclipse and secondary
                // lights; the last light may be black.
                (false, false, _) if air.model != AtmosphereModel::None && self.eclipse.occluders > 0 => MAX_LIGHTS,
                // The same in the shadow of another body's rings.
                (false, false, _) if in_foreign_ring_shadow => MAX_LIGHTS,
                (false, false, secondary) => 1 + secondary.min(MAX_LIGHTS - 1),
            },
            eclipse: match available.is_emissive {
                true => Eclipse::default(),
                false if in_foreign_ring_shadow => self.eclipse.beside_ring_shadow(),
                false => self.eclipse,
            },
            ring_shadow: match self.ring_shadow {
                _ if available.is_emissive => RingShadow::None,
                RingShadow::OfPlanet if in_foreign_ring_shadow => RingShadow::OfPlanet,
                _ if !available.has_rings => RingShadow::None,
                // A body with rings has their shadow alone; those of another body dim it evenly.
                RingShadow::OfPlanet => RingShadow::None,
                // Under an atmosphere in an eclipse the better model replaces the cheaper one, which halves the number of keys with all three.
                RingShadow::PointSun if air.model != AtmosphereModel::None && self.eclipse.occluders > 0 => RingShadow::Penumbra,
                ring_shadow => ring_shadow,
            },
            ring_shine: self.has_ring_shine(body),
            shape: match mesh {
                Some(_) => Shape::Mesh,
                None if ellipsoid && available.is_flattened => Shape::Ellipsoid,
                None => Shape::Sphere,
            },
            // The limb profile and the average over a thin crescent are not combined with each other, a mesh, detail or an eclipse: no key has both. Nor is a
            // crescent in the shadow of another body's rings averaged.
            limb_heights: self.limb_heights && available.limb_heights && mesh.is_none() && !self.detail && self.eclipse.occluders == 0,
            thin_limb: self.thin_crescent
                && !available.is_emissive
                && mesh.is_none()
                && !self.detail
                && !self.limb_heights
                && self.eclipse.occluders == 0
                && !in_foreign_ring_shadow,
            flags: mesh.unwrap_or_default(),
            air,
            air_pass: match self.air_pass {
                _ if air.model == AtmosphereModel::None => AirPass::None,
                AirPass::ReadWithClouds if !self.shows_clouds_on_ground(body) => AirPass::Read,
                air_pass => air_pass,
            },
            view,
            ..DrawFeatures::MINIMAL
        }
    }

    /// The features of the cloud shell's draw; `None` if the body has no clouds or the pixel view shows a quantity of the ground below them.
    pub(crate) fn cloud_features(self, body: &Body, view: PixelView) -> Option<DrawFeatures> {
        let is_shown = body.clouds.is_some() && view.shows_radiance();
        // The cloud shell is a sphere or an ellipsoid, even around a mesh.
        let ground = Self { mesh: None, ..self }.globe_features(body, view);
        is_shown.then_some(DrawFeatures {
            surface: Surface::Cloud,
            maps: MapSet::default(),
            detail: if self.cloud_detail && view.shows_radiance() { Detail::Billows } else { Detail::None },
            custom_surface: 0,
            overlays: 0,
            ring_shine: false,
            limb_heights: false,
            // As on the ground, not combined with detail.
            thin_limb: ground.thin_limb && !self.cloud_detail,
            ..ground
        })
    }

    /// The features of the draws of the body's rings; `None` if the body has no rings or is emissive.
    pub(crate) fn ring_features(self, body: &Body, view: PixelView) -> Option<DrawFeatures> {
        let available = BodyCapabilities::of(body);
        let features = DrawFeatures {
            surface: Surface::Ring,
            lights: 1,
            eclipse: self.ring_eclipse,
            body_shadow: self.body_shadow,
            view,
            ..DrawFeatures::MINIMAL
        };
        (available.has_rings && !available.is_emissive).then_some(features)
    }

    /// The features of the draw of the atmosphere beyond the limb; `None` without an atmosphere or if the pixel view does not show it.
    pub(crate) fn sky_features(self, body: &Body, view: PixelView) -> Option<DrawFeatures> {
        let is_shown = view.shows_radiance() || view == PixelView::OpticalDepth;
        let ground = self.globe_features(body, view);
        let sky = DrawFeatures {
            surface: Surface::Sky,
            maps: MapSet::default(),
            detail: Detail::None,
            custom_surface: 0,
            overlays: 0,
            ring_shine: false,
            limb_heights: false,
            thin_limb: self.thin_rim,
            lights: if self.second_light_in_air && view.shows_radiance() { ground.lights.clamp(1, MAX_AIR_LIGHTS) } else { 1 },
            air_pass: AirPass::None,
            ..ground
        };
        (is_shown && ground.air.model != AtmosphereModel::None).then_some(sky)
    }
}
