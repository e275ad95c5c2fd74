//! Builds the scene of a request, and reads or computes the files and tables that it requires in addition to catalog and ephemeris, each only once.
//!
//! In: a request. Out: its scene. Always: a file that cannot be read is reported once, and the scene is built without it.

use super::{Session, SessionError, Stage};
use crate::catalog::Body;
use crate::image::MapDecoding;
use crate::render::plan;
use crate::scene::bright_ground::BrightGround;
use crate::scene::draw::{MapFiles, MapRole, Shape};
use crate::scene::night_lights::NightLights;
use crate::scene::request::ViewRequest;
use crate::scene::{Requirements, Resources, Scene, SceneBuilder, SceneError};
use std::collections::BTreeSet;
use std::fmt::Display;
use std::sync::Arc;

/// Largest width in texels of the map of city lights for the light meter. On the Earth each texel is then 20 km wide at the equator.
const MAX_NIGHT_LIGHTS_WIDTH: u32 = 2048;
/// The same for the map of bright ground. On the Earth each texel is then 78 km wide at the equator.
const MAX_BRIGHT_GROUND_WIDTH: u32 = 512;

impl Session {
    /// The scene of a view. Reads or computes shape models, tables, and the city lights and bright ground that the light meter needs, but not the other maps;
    /// maps that could not be read before are left out.
    ///
    /// # Errors
    /// See [`SceneBuilder::new`].
    pub fn scene(&self, request: &ViewRequest) -> Result<Scene, SessionError> {
        let ignore_requirements = |_: &Requirements| {};
        self.scene_with(request, ignore_requirements)
    }

    /// As [`Self::scene`]. `on_requirements` is called with the scene's requirements, before shape models and tables are read or computed.
    pub(super) fn scene_with(&self, request: &ViewRequest, on_requirements: impl FnOnce(&Requirements)) -> Result<Scene, SessionError> {
        self.scene_from(|| SceneBuilder::new(&self.catalog, &self.ephemeris, request, &self.scene_caches), on_requirements)
    }

    /// As [`Self::scene_with`], for the builder that `new_builder` creates.
    pub(super) fn scene_from<'a>(
        &'a self,
        new_builder: impl FnOnce() -> Result<SceneBuilder<'a>, SceneError>,
        on_requirements: impl FnOnce(&Requirements),
    ) -> Result<Scene, SessionError> {
        let (builder, resources_so_far) = self.metered_builder(new_builder)?;
        let required = self.timed(Stage::Scene, || builder.requirements(&resources_so_far));
        on_requirements(&required);
        let resources = self.resources(&required);
        Ok(self.timed(Stage::Scene, || builder.build(&resources)))
    }

    /// A builder that has metered the light, including city lights and bright ground, and the resources loaded so far.
    pub(super) fn metered_builder<'a>(
        &'a self,
        new_builder: impl FnOnce() -> Result<SceneBuilder<'a>, SceneError>,
    ) -> Result<(SceneBuilder<'a>, Resources), SessionError> {
        let mut builder = self.timed(Stage::Scene, new_builder)?;
        let mut resources_so_far = Resources { unreadable: self.unreadable(), sky_map: self.sky_map.clone(), ..Resources::default() };
        for body in builder.bright_grounds_to_meter(&resources_so_far).into_iter().filter_map(|id| self.catalog.body(id)) {
            let bright_ground = self.timed(Stage::Maps, || self.bright_grounds.get(body.id, || self.read_bright_ground(body)));
            resources_so_far.bright_grounds.extend(bright_ground.map(|bright_ground| (body.id, bright_ground)));
        }
        self.timed(Stage::Scene, || builder.meter_with(&resources_so_far));
        // Whether city lights count depends on the exposure without them.
        for body in builder.night_lights_to_meter(&resources_so_far).into_iter().filter_map(|id| self.catalog.body(id)) {
            let night_lights = self.timed(Stage::Maps, || self.night_lights.get(body.id, || self.read_night_lights(body)));
            resources_so_far.night_lights.extend(night_lights.map(|night_lights| (body.id, night_lights)));
        }
        if !resources_so_far.night_lights.is_empty() {
            self.timed(Stage::Scene, || builder.meter_city_lights(&resources_so_far));
        }
        Ok((builder, resources_so_far))
    }

    /// The files that could not be read so far.
    fn unreadable(&self) -> BTreeSet<String> {
        self.unreadable_files.lock().clone()
    }

    /// Records that a file cannot be read, and reports it the first time. Returns whether this was the first time.
    fn record_unreadable(&self, file: &str, line: impl FnOnce() -> String) -> bool {
        let is_new = self.unreadable_files.lock().insert(file.to_owned());
        if is_new {
            (self.notify)(&line());
        }
        is_new
    }

    /// As [`Self::record_unreadable`], for a map; the message states how the view is drawn without the map.
    pub(super) fn record_unreadable_map(&self, file: &str, why: &dyn Display) -> bool {
        // Only a colour map has a substitute. If any other map is unreadable, the effect that uses it is left out.
        let is_colour_map = self.catalog.bodies().iter().any(|body| body.maps.albedo.as_ref().is_some_and(|map| map.file == file));
        let how = if is_colour_map { "in its mean colour" } else { "without it" };
        self.record_unreadable(file, || format!("{why}; drawn {how}"))
    }

    /// Reads the shape models and computes the tables that a view needs. A shape model that cannot be read is reported once.
    fn resources(&self, required: &Requirements) -> Resources {
        let mut resources = Resources { sky_map: self.sky_map.clone(), ..Resources::default() };
        for mesh in &required.meshes {
            let Some((body, catalog_mesh)) = self.catalog.body(mesh.body).and_then(|b| Some((b, b.mesh.as_ref()?))) else { continue };
            match self.timed(Stage::Maps, || self.meshes.model(body)) {
                Ok(model) => {
                    if let Some((towards_sun, sun_radius_rad)) = mesh.self_shadow_sun {
                        // Altitudes of the Sun above the horizon that the shape itself forms, one for each vertex.
                        let altitudes = self.timed(Stage::Scene, || self.meshes.sun_altitudes(&model, towards_sun, sun_radius_rad));
                        resources.sun_altitudes.insert(body.id, altitudes);
                    }
                    resources.meshes.insert(body.id, model);
                }
                Err(why) => {
                    self.record_unreadable(&catalog_mesh.file, || format!("{why}; {} is drawn as its ellipsoid", body.name));
                }
            }
        }
        for body in required.scattering_tables.iter().filter_map(|id| self.catalog.body(*id)) {
            resources.scattering_tables.insert(body.id, self.timed(Stage::Scene, || self.air_tables.get(body)));
        }
        resources.unreadable = self.unreadable();
        resources
    }

    /// Reads the maps of a view in parallel, so that planning finds them in memory. A map that cannot be read is reported once.
    pub(super) fn read_maps(&self, required: &Requirements) {
        let (overlays, maps): (Vec<_>, Vec<_>) = required
            .maps
            .iter()
            .flat_map(|(files, shape)| files.by_role().map(move |(role, file)| (role, file, plan::map_decoding(role, files, *shape))))
            .filter(|(_, file, _)| !self.unreadable_files.lock().contains(*file))
            .partition(|(role, ..)| matches!(role, MapRole::Overlay(_)));
        let mut maps: Vec<(&str, MapDecoding)> = maps.into_iter().map(|(_, file, decoding)| (file, decoding)).collect();
        maps.extend(required.sky_map.as_deref().map(|file| (file, plan::SKY_DECODING)));
        self.maps.prefetch(&maps);
        for (file, decoding) in maps {
            if let Err(why) = self.maps.get_decoded(file, decoding) {
                self.record_unreadable_map(file, &why);
            }
        }
        for (_, file, _) in overlays {
            if let Err(why) = self.maps.premultiplied(file) {
                self.record_unreadable_map(file, &why);
            }
        }
    }

    /// The city lights of a body, for the light meter. An unreadable map is reported when it is read for drawing. The map is decoded as for an ellipsoid, also
    /// if the body has a shape model; the body's other maps do not matter.
    fn read_night_lights(&self, body: &Body) -> Option<Arc<NightLights>> {
        let night = body.maps.night.as_ref()?;
        let map = self.maps.get_decoded(&night.file, plan::map_decoding(MapRole::Night, &MapFiles::default(), Shape::Ellipsoid)).ok()?;
        let level = map.levels.iter().find(|l| l.width <= MAX_NIGHT_LIGHTS_WIDTH)?;
        let brightest_channel = |texel: &[u8]| texel.iter().take(3).copied().max().unwrap_or(0);
        let texels = level.bytes().chunks_exact(4).map(|texel| crate::units::srgb_to_linear(f64::from(brightest_channel(texel)) / 255.0));
        NightLights::new(body, level.width as usize, level.height as usize, texels).map(Arc::new)
    }

    /// As [`Self::read_night_lights`], for the bright ground of a body.
    fn read_bright_ground(&self, body: &Body) -> Option<Arc<BrightGround>> {
        let albedo = body.maps.albedo.as_ref()?;
        let map = self.maps.get_decoded(&albedo.file, plan::map_decoding(MapRole::Albedo, &MapFiles::default(), Shape::Ellipsoid)).ok()?;
        let level = map.levels.iter().find(|l| l.width <= MAX_BRIGHT_GROUND_WIDTH)?;
        let linear = |byte: u8| crate::units::srgb_to_linear(f64::from(byte) / 255.0);
        let texels = level.bytes().chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2]].map(linear));
        BrightGround::new(body, level.width as usize, level.height as usize, texels).map(Arc::new)
    }
}
