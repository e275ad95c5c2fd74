//! Builds a finished [`Scene`] from a request.
//!
//! In: catalog, ephemeris and a request. The steps, in their order: [`SceneBuilder::new`] places the bodies and meters their light;
//! [`SceneBuilder::meter_with`] adds their night lights (cities) and bright ground; [`SceneBuilder::requirements`] lists the other files and tables that the
//! view needs; [`SceneBuilder::build`] decides on every effect and creates the scene from the resources that were loaded. The scene is never modified
//! afterwards.

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
use crate::scene::body_report::BodyReport;
use crate::scene::camera::geometry::ImageGeometry;
use crate::scene::camera::viewpoint::{self, Viewer};
use crate::scene::draw::features::PixelView;
use crate::scene::draw::{BodyPart, Draw};
use crate::scene::error::SceneError;
use crate::scene::features;
use crate::scene::features::inputs::{DecisionInputs, FrameContext};
use crate::scene::finished::Scene;
use crate::scene::light::exposure::Exposure;
use crate::scene::light::lights::Reflector;
use crate::scene::light::{auto_exposure, corona};
use crate::scene::placed::{PlacedBody, place};
use crate::scene::purpose::Threshold;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::resources::{Caches, Context, MeshRequirement, Requirements, Resources};
use crate::scene::surface::{mesh_decision, meshes};
use crate::scene::visibility::{lunar_limb, order};
use glam::Vec3;

/// A view whose bodies are placed and whose light is metered, before anything is decided.
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
    /// The latest result of the light meter; without night lights and bright ground until [`Self::meter_with`] has been called.
    exposure: Exposure,
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
    /// Places the request's camera and all bodies at `request.time`, and meters the light.
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
        let context = Context { request, ephemeris, resources: &Resources::default(), caches };
        let exposure = auto_exposure::exposure(context, &viewer.camera, &placed, &reflectors, air.as_ref());
        Ok(Self { catalog, ephemeris, request, caches, viewer, placed, unplaced_reports, reflectors, air, exposure })
    }

    /// The latest result of the light meter.
    pub(crate) fn exposure(&self) -> &Exposure {
        &self.exposure
    }

    /// The bodies on whose night lights (cities) the exposure depends. `known`: as for [`Self::requirements`].
    pub(crate) fn night_lights_to_meter(&self, known: &Resources) -> Vec<NaifId> {
        auto_exposure::night_lights_to_meter(self.context(known), &self.viewer.camera, &self.placed, &self.exposure)
    }

    /// The bodies near the camera on whose bright ground the exposure depends. `known`: as for [`Self::requirements`].
    pub(crate) fn bright_grounds_to_meter(&self, known: &Resources) -> Vec<NaifId> {
        auto_exposure::bright_grounds_to_meter(self.context(known), &self.viewer.camera, &self.placed)
    }

    /// Meters the light again, now including the night lights and the bright ground in `resources`.
    pub(crate) fn meter_with(&mut self, resources: &Resources) {
        let camera = &self.viewer.camera;
        self.exposure = auto_exposure::exposure(self.context(resources), camera, &self.placed, &self.reflectors, self.air.as_ref());
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
            threshold: Threshold::of(self.request.purpose, self.exposure.white()),
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
        // This also adds decisions to the bodies' reports.
        let light_around_sun = LightAroundSun::decide(&frame, &self.placed, &mut bodies.reports);
        let corona_flux = light_around_sun.corona.map_or(Vec3::ZERO, |c| c.point_flux);
        bodies.apply_visibility(&frame, &self.placed, self.exposure.white(), corona_flux);
        let sky = Sky::build(&self, &frame, light_around_sun.corona.is_some());
        let BodiesInFrame { reports, draws, points, orbits, traces } = bodies;
        let draws = order::far_to_near(&self.placed, draws);
        let annotations = Annotations::build(&self, &frame, &reports, &sky.stars);
        let selected = request.selected.or(request.target).unwrap_or(NaifId::SUN);
        let outlined_globe = draws.iter().find(|d| request.layers.outline && d.body == selected && d.part == BodyPart::Globe);
        Scene {
            time: request.time,
            camera: camera.clone(),
            geometry: ImageGeometry::Perspective,
            exposure: self.exposure.clone(),
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
