//! Builds a finished [`Scene`] from a request.
//!
//! In: catalog, ephemeris and a request. The steps, in their order: [`SceneBuilder::new`] places the bodies; [`SceneBuilder::meter_with`] meters their light
//! with their bright ground; [`SceneBuilder::meter_city_lights`] adds their night lights (cities); [`SceneBuilder::requirements`] lists the other files and
//! tables that the view needs; [`SceneBuilder::build`] decides on every effect and creates the scene from the resources that were loaded. The scene is never
//! modified afterwards. Without the two steps of the light meter, the light is metered without bright ground and night lights.

mod annotations;
mod bodies;
mod light_around_sun;
mod sky;

use self::annotations::Annotations;
use self::bodies::BodiesInFrame;
use self::light_around_sun::LightAroundSun;
use self::sky::Sky;
use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::Ephemeris;
use crate::message::reason;
use crate::scene::atmosphere::air::SurroundingAir;
use crate::scene::atmosphere::decision::needs_table;
use crate::scene::atmosphere::tint_table::FrameTints;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::geometry::ImageGeometry;
use crate::scene::camera::viewpoint::{self, Viewer};
use crate::scene::draw::features::PixelView;
use crate::scene::draw::{BodyPart, Draw};
use crate::scene::error::SceneError;
use crate::scene::features;
use crate::scene::features::inputs::{DecisionInputs, FrameContext};
use crate::scene::finished::Scene;
use crate::scene::light::auto_exposure::{self, Metered};
use crate::scene::light::corona;
use crate::scene::light::exposure::{Exposure, darkest_white};
use crate::scene::light::lights::Reflector;
use crate::scene::placed::{PlacedBody, place};
use crate::scene::purpose::Threshold;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::resources::{Caches, Context, MeshRequirement, Requirements, Resources};
use crate::scene::sky::comet_tails::LightPatch;
use crate::scene::surface::{mesh_decision, meshes};
use crate::scene::visibility::{lunar_limb, order};
use glam::Vec3;
use std::cell::OnceCell;

/// A view whose bodies are placed, and whose light is metered when it is first needed, before anything is decided.
pub struct SceneBuilder<'a> {
    catalog: &'a Catalog,
    ephemeris: &'a Ephemeris,
    request: &'a ViewRequest,
    caches: &'a Caches,
    viewer: Viewer,
    /// The bodies in catalog order, except those that the ephemeris could not place.
    placed: Vec<PlacedBody<'a>>,
    /// One entry per body of the catalog: `None` if the body was placed, else its report, which gives the reason.
    unplaced_reports: Vec<Option<BodyReport>>,
    /// All placed bodies, as sources of light for each other.
    reflectors: Vec<Reflector<'a>>,
    /// The atmosphere that surrounds the camera; if several bodies' atmospheres do, that of the first body in catalog order. `None` if none does.
    air: Option<SurroundingAir<'a>>,
    /// Comas and tails of comets for the light meter; empty until then.
    comets_to_meter: OnceCell<Vec<LightPatch>>,
    /// The latest result of the light meter; empty until then.
    metered: OnceCell<Metered>,
}

impl Scene {
    /// Builds the scene of a request from the catalog and the ephemeris alone. The scene lacks what [`Resources`] would supply: shape models, metered night
    /// lights, multiple-scattering tables and the user's panorama of the sky.
    ///
    /// # Errors
    /// Invalid camera parameters, a camera inside a body, or a target that cannot be placed.
    pub fn build(catalog: &Catalog, ephemeris: &Ephemeris, request: &ViewRequest) -> Result<Self, SceneError> {
        Ok(SceneBuilder::new(catalog, ephemeris, request, &Caches::default())?.build(&Resources::default()))
    }
}

impl<'a> SceneBuilder<'a> {
    /// Places the request's camera and all bodies at `request.time`.
    ///
    /// # Errors
    /// Invalid camera parameters, a camera inside a body, or a target that cannot be placed.
    pub fn new(catalog: &'a Catalog, ephemeris: &'a Ephemeris, request: &'a ViewRequest, caches: &'a Caches) -> Result<Self, SceneError> {
        Self::with_viewer(catalog, ephemeris, request, viewpoint::viewer(catalog, ephemeris, request)?, caches)
    }

    /// Like [`Self::new`] for a camera that is already placed, such as that of a frame of a composed image.
    ///
    /// # Errors
    /// A camera inside a body, or a target that cannot be placed.
    pub(crate) fn with_viewer(
        catalog: &'a Catalog,
        ephemeris: &'a Ephemeris,
        request: &'a ViewRequest,
        viewer: Viewer,
        caches: &'a Caches,
    ) -> Result<Self, SceneError> {
        let (mut placed, mut unplaced_reports) = (Vec::new(), Vec::new());
        for body in catalog.bodies() {
            match place(catalog, body, ephemeris, &viewer, request, caches) {
                Ok(p) => {
                    placed.push(p);
                    unplaced_reports.push(None);
                }
                Err(e @ SceneError::Inside(_)) => return Err(e),
                Err(e) if request.target == Some(body.id) => return Err(e),
                Err(e) => unplaced_reports.push(Some(bodies::not_placed(body, reason!("quoted", text = &e.to_string())))),
            }
        }
        // Stores the limb profile in the placed Moon, if it is needed.
        lunar_limb::compute_profile(&mut placed, &caches.limb_profiles);
        let shows_air = |body: &Body| request.effects.override_of_body(body, Effect::Atmosphere) != Some(false);
        let air =
            placed.iter().filter(|p| shows_air(p.body)).find_map(|p| SurroundingAir::of(p.body, &p.placement, &caches.sky_brightness));
        let reflectors: Vec<Reflector<'_>> =
            placed.iter().map(|p| Reflector { body: p.body, position_km: p.position_km, body_to_sun_km: p.body_to_sun_km }).collect();
        let (comets_to_meter, metered) = (OnceCell::new(), OnceCell::new());
        Ok(Self { catalog, ephemeris, request, caches, viewer, placed, unplaced_reports, reflectors, air, comets_to_meter, metered })
    }

    /// The latest result of the light meter. If there is none yet, the light is metered without night lights and bright ground.
    pub(crate) fn exposure(&self) -> &Exposure {
        let (nothing_loaded, earlier) = (Resources::default(), None);
        &self.metered.get_or_init(|| self.meter(&nothing_loaded, earlier)).exposure
    }

    /// See [`auto_exposure::exposure`].
    fn meter(&self, resources: &Resources, earlier: Option<Metered>) -> Metered {
        let (context, camera) = (self.context(resources), &self.viewer.camera);
        let comets = self.comets_to_meter.get_or_init(|| match auto_exposure::is_metered(self.request) {
            // All that the longest exposure shows.
            true => self.comets(darkest_white(), &FrameTints::of(self.air.as_ref())).0.patches,
            false => Vec::new(),
        });
        auto_exposure::exposure(context, camera, &self.placed, &self.reflectors, comets, self.air.as_ref(), earlier)
    }

    /// The bodies on whose night lights (cities) the exposure depends. `known`: as for [`Self::requirements`].
    pub(crate) fn night_lights_to_meter(&self, known: &Resources) -> Vec<NaifId> {
        auto_exposure::night_lights_to_meter(self.context(known), &self.viewer.camera, &self.placed, self.exposure())
    }

    /// The bodies near the camera on whose bright ground the exposure depends. `known`: as for [`Self::requirements`].
    pub(crate) fn bright_grounds_to_meter(&self, known: &Resources) -> Vec<NaifId> {
        auto_exposure::bright_grounds_to_meter(self.context(known), &self.viewer.camera, &self.placed)
    }

    /// Meters the light, including the night lights and the bright ground in `resources`.
    pub(crate) fn meter_with(&mut self, resources: &Resources) {
        let earlier = None;
        self.metered = OnceCell::from(self.meter(resources, earlier));
    }

    /// Adds the night lights in `resources` to the result of [`Self::meter_with`], which had the same bright ground and no night lights.
    pub(crate) fn meter_city_lights(&mut self, resources: &Resources) {
        let earlier = self.metered.take();
        self.metered = OnceCell::from(self.meter(resources, earlier));
    }

    /// What every part of the scene reads: request, ephemeris, resources and caches.
    fn context<'f>(&'f self, resources: &'f Resources) -> Context<'f> {
        Context { request: self.request, ephemeris: self.ephemeris, resources, caches: self.caches }
    }

    /// The context, and what else the decisions about all bodies of the frame share.
    fn frame<'f>(&'f self, resources: &'f Resources) -> FrameContext<'f> {
        FrameContext {
            context: self.context(resources),
            catalog: self.catalog,
            camera: &self.viewer.camera,
            threshold: Threshold::of(self.request.purpose, self.exposure().white()),
            reflectors: &self.reflectors,
            air: self.air.as_ref(),
        }
    }

    /// Whether the camera is at this body's centre, so that the body is not drawn.
    fn camera_is_at_centre_of(&self, body: &Body) -> bool {
        self.viewer.at_centre_of.is_some_and(|centre| centre.id == body.id)
    }

    /// The files and tables that [`Self::build`] needs for the complete scene. `known`: what has been loaded so far, and which files cannot be read; the
    /// result omits the unreadable files.
    pub fn requirements(&self, known: &Resources) -> Requirements {
        let frame = self.frame(known);
        let mut requirements = Requirements::default();
        for p in self.placed.iter().filter(|p| !self.camera_is_at_centre_of(p.body)) {
            // The request with the effects that the user set for this one body.
            let own_request = self.request.for_body(p.body);
            let body_frame =
                FrameContext { context: Context { request: own_request.as_ref().unwrap_or(self.request), ..frame.context }, ..frame };
            if meshes::is_required(body_frame.context, body_frame.camera, p) {
                // `None`: the mesh casts no shadows on itself.
                let may_shadow_itself = body_frame.context.request.effects.override_of(Effect::SelfShadow) != Some(false);
                let self_shadow_sun = mesh_decision::sun_direction_and_radius(&body_frame, p).filter(|_| may_shadow_itself);
                requirements.meshes.push(MeshRequirement { body: p.body.id, self_shadow_sun });
            }
            if needs_table(&DecisionInputs::of(&body_frame, p)) {
                requirements.scattering_tables.push(p.body.id);
            }
            requirements.maps.extend(features::required_maps(&body_frame, p));
        }
        // The choice of the sky's map does not depend on the corona, which only the background's decisions do.
        let has_corona = false;
        let (background, _decisions) = self.background(&frame, has_corona);
        requirements.sky_map = background.and_then(|b| b.map_file);
        requirements
    }

    /// Decides on every effect of every body, and creates the scene from the resources that were loaded.
    pub fn build(self, resources: &Resources) -> Scene {
        let (request, camera) = (self.request, &self.viewer.camera);
        let frame = self.frame(resources);
        let mut bodies = BodiesInFrame::decide(&self, &frame);
        let tints = FrameTints::of(frame.air);
        // This also adds decisions to the bodies' reports.
        let light_around_sun = LightAroundSun::decide(&frame, &self.placed, &tints, &mut bodies.reports);
        let corona_flux = light_around_sun.corona.map_or(Vec3::ZERO, |c| c.point_flux);
        bodies.apply_visibility(&frame, &self.placed, self.exposure().white(), corona_flux);
        let sky = Sky::build(&self, &frame, &tints, light_around_sun.corona.is_some());
        let BodiesInFrame { reports, draws, points, orbits, traces } = bodies;
        let draws = order::far_to_near(&self.placed, draws);
        let annotations = Annotations::build(&self, &frame, &reports, &sky.stars);
        let selected = request.selected.or(request.target).unwrap_or(NaifId::SUN);
        let outlined_globe = draws.iter().find(|d| request.layers.outline && d.body == selected && d.part == BodyPart::Globe);
        Scene {
            time: request.time,
            camera: camera.clone(),
            viewer_velocity_km_s: self.viewer.velocity_km_s,
            geometry: ImageGeometry::Perspective,
            exposure: self.exposure().clone(),
            pixel_view: request.pixel_view,
            tone_map: request.tone_map,
            bodies: reports,
            background: sky.background,
            sky_images: sky.images,
            stars: sky.stars,
            minor_planets: sky.minor_planets,
            sky_decisions: sky.decisions.into_iter().chain(annotations.decisions).collect(),
            sky_lines: annotations.sky_lines,
            outlined_shape: outlined_globe.map(Draw::shape_alone),
            // The Sun's draws and all draws before them are behind the corona.
            corona: light_around_sun
                .corona
                .map(|c| corona::Corona { draw_count_behind: order::draw_count_up_to(&self.placed, &draws, NaifId::SUN), ..c }),
            draws,
            points,
            orbits: orbits.into_iter().chain(sky.comet_orbits).collect(),
            comets: sky.comets,
            lines_in_space: traces.into_iter().chain(annotations.lines_in_space).collect(),
            ground_lines: annotations.ground_lines,
            refracted_limbs: light_around_sun.refracted_limbs,
            glare: light_around_sun.glare,
            has_bloom: request.layers.bloom && request.pixel_view == PixelView::Final,
            labels: annotations.labels,
            line_texts: annotations.line_texts,
            purpose: request.purpose,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::light::meter::{Meter, MeterReading};
    use crate::scene::light::night_lights::NightLights;
    use crate::scene::request::view_request::Position;
    use crate::time::Instant;
    use std::sync::Arc;

    /// City lights of an invented map, added to a reading without them, against a reading that has them from the start: among the lamps, and from orbit, where
    /// the Moon is in the frame.
    #[test]
    fn city_lights_are_added_to_a_reading_as_if_metered_from_the_start() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the built-in kernel");
        let earth = catalog.body(NaifId::EARTH).expect("the Earth");
        let texels = (0..32).map(|k| f64::from(k % 3) / 2.0);
        let night_lights = Arc::new(NightLights::new(earth, 8, 4, texels).expect("complete"));
        let resources = Resources { night_lights: [(earth.id, night_lights)].into(), ..Resources::default() };
        for (target, height_km) in [(NaifId::EARTH, 1.0), (NaifId::EARTH, 500.0), (NaifId::MOON, 500.0)] {
            let position = Position::Ground { body: NaifId::EARTH, latitude_deg: 48.85, longitude_deg: 2.35, height_km };
            let time = Instant::parse("2026-11-28T22:00:00Z").expect("a time");
            let request = ViewRequest { position, fov_deg: Some(90.0), width: 64, height: 64, ..ViewRequest::of(target, time) };
            let caches = Caches::default();
            let builder = SceneBuilder::new(&catalog, &ephemeris, &request, &caches).expect("a view");
            let meter = |city_light_weight: f64| Meter {
                context: builder.context(&resources),
                camera: &builder.viewer.camera,
                placed: &builder.placed,
                reflectors: &builder.reflectors,
                comet_patches: &[],
                air: builder.air.as_ref(),
                city_light_weight,
            };
            let numbers = |reading: &MeterReading| -> Vec<[f64; 3]> {
                reading.subjects.iter().map(|s| [s.radiance, s.target_level, s.weight]).collect()
            };
            let [without, from_the_start] = [0.0, 0.7].map(|weight| meter(weight).read(darkest_white()));
            let numbers_without = numbers(&without);
            let added = meter(0.7).add_city_lights(without);
            assert_eq!(numbers(&added), numbers(&from_the_start), "{target:?} from {height_km} km");
            assert!(numbers(&added) != numbers_without || target == NaifId::MOON, "no city lights in the frame from {height_km} km");
        }
    }
}
