//! Builds a finished [`Scene`] from a request, in two steps.
//!
//! In: catalog, ephemeris and a request. [`SceneBuilder::new`] places the bodies and meters their light; [`SceneBuilder::meter_night_lights`] adds the light of
//! cities; [`SceneBuilder::requirements`] says what else the view needs; [`SceneBuilder::build`] decides on every feature and makes the scene from the
//! resources that were loaded. Nothing changes a scene afterwards.

use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::Ephemeris;
use crate::ephemeris::topocentric::ground_point_km;
use crate::scene::annotation::sky_lines::{SkyLines, horizon_axes};
use crate::scene::annotation::{eclipse_lines, ground_lines, instrument_frames, labels, line_texts, orbits, sky_lines, star_names, traces};
use crate::scene::atmosphere::air::SurroundingAir;
use crate::scene::atmosphere::decision::needs_table;
use crate::scene::camera::Placement;
use crate::scene::camera::geometry::ImageGeometry;
use crate::scene::camera::viewpoint::{self, Viewer};
use crate::scene::decision::Decision;
use crate::scene::draw::features::{PixelView, Shape};
use crate::scene::draw::{Draw, Part};
use crate::scene::eclipse::refracted_limb;
use crate::scene::error::SceneError;
use crate::scene::features::case::{Case, Frame};
use crate::scene::features::{self, DecidedBody};
use crate::scene::finished::Scene;
use crate::scene::in_view::{Appearance, BodyInView, SubPoint};
use crate::scene::light::exposure::Exposure;
use crate::scene::light::lights::Reflector;
use crate::scene::light::{auto_exposure, corona, glow, magnitude};
use crate::scene::placed::{PlacedBody, place};
use crate::scene::point;
use crate::scene::purpose::Threshold;
use crate::scene::request::effects::Effect;
use crate::scene::request::view_request::{Position, ViewRequest};
use crate::scene::resources::{Caches, Context, MeshWanted, Requirements, Resources};
use crate::scene::sky::images::SkyImageDraw;
use crate::scene::sky::minor_planet_columns::MinorPlanetColumns;
use crate::scene::sky::{background, comets, images, minor_planets, stars};
use crate::scene::surface::{detail, mesh_decision, meshes};
use crate::scene::visibility::{hidden, lunar_limb, order};
use glam::{DMat3, DVec2, DVec3};
use std::sync::Arc;

/// A view whose bodies are placed and whose light is metered, before anything is decided.
pub struct SceneBuilder<'a> {
    catalog: &'a Catalog,
    ephemeris: &'a Ephemeris,
    request: &'a ViewRequest,
    caches: &'a Caches,
    viewer: Viewer,
    /// In the catalog's order, without those that the ephemeris could not place.
    placed: Vec<PlacedBody<'a>>,
    /// One entry per body of the catalog: `None` if it was placed, else the entry that says why not.
    unplaced: Vec<Option<BodyInView>>,
    reflectors: Vec<Reflector<'a>>,
    /// The atmosphere around the camera, if it is in one.
    air: Option<SurroundingAir<'a>>,
    /// Leaves city lights out until [`Self::meter_night_lights`] was called.
    exposure: Exposure,
}

impl Scene {
    /// The scene of a request from catalog and ephemeris alone, without shape models, city lights or tables of multiple scattering.
    ///
    /// # Errors
    /// Invalid camera parameters, or a target that cannot be placed.
    pub fn build(catalog: &Catalog, ephemeris: &Ephemeris, request: &ViewRequest) -> Result<Self, SceneError> {
        Ok(SceneBuilder::new(catalog, ephemeris, request, &Caches::default())?.build(&Resources::default()))
    }
}

impl<'a> SceneBuilder<'a> {
    /// Looks at the sky of `request.time` from the request's camera.
    ///
    /// # Errors
    /// Invalid camera parameters, or a target that cannot be placed.
    pub fn new(catalog: &'a Catalog, ephemeris: &'a Ephemeris, request: &'a ViewRequest, caches: &'a Caches) -> Result<Self, SceneError> {
        Self::with_viewer(catalog, ephemeris, request, viewpoint::viewer(catalog, ephemeris, request)?, caches)
    }

    /// Like [`Self::new`] for a camera that is already placed, such as one frame of a composed picture.
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
        let (mut placed, mut unplaced) = (Vec::new(), Vec::new());
        for body in catalog.bodies() {
            match place(catalog, body, ephemeris, &viewer, request, caches) {
                Ok(p) => {
                    placed.push(p);
                    unplaced.push(None);
                }
                Err(e @ SceneError::Inside(_)) => return Err(e),
                Err(e) if request.target == Some(body.id) => return Err(e),
                Err(e) => unplaced.push(Some(not_placed(body, e.to_string()))),
            }
        }
        lunar_limb::compute_profile(&mut placed, &caches.limb_profiles);
        let has_air = |body: &Body| {
            let own_effects = request.effects.for_body(&body.name);
            own_effects.as_ref().unwrap_or(&request.effects).override_of(Effect::Atmosphere) != Some(false)
        };
        let air = placed.iter().filter(|p| has_air(p.body)).find_map(|p| SurroundingAir::of(p.body, &p.placement));
        let reflectors: Vec<Reflector<'_>> =
            placed.iter().map(|p| Reflector { body: p.body, position_km: p.position_km, sun_from_body_km: p.sun_from_body_km }).collect();
        let context = Context { request, ephemeris, resources: &Resources::default(), caches };
        let exposure = auto_exposure::exposure(context, &viewer.camera, &placed, &reflectors, air.as_ref());
        Ok(Self { catalog, ephemeris, request, caches, viewer, placed, unplaced, reflectors, air, exposure })
    }

    /// The exposure as metered so far.
    pub(crate) fn exposure(&self) -> &Exposure {
        &self.exposure
    }

    /// The bodies whose city lights the exposure depends on.
    pub(crate) fn night_lights_wanted(&self, known: &Resources) -> Vec<NaifId> {
        auto_exposure::night_lights_wanted(self.context(known), &self.viewer.camera, &self.placed, &self.exposure)
    }

    /// Meters the light again, now including city lights.
    pub(crate) fn meter_night_lights(&mut self, resources: &Resources) {
        let camera = &self.viewer.camera;
        self.exposure = auto_exposure::exposure(self.context(resources), camera, &self.placed, &self.reflectors, self.air.as_ref());
    }

    fn context<'f>(&'f self, resources: &'f Resources) -> Context<'f> {
        Context { request: self.request, ephemeris: self.ephemeris, resources, caches: self.caches }
    }

    fn frame<'f>(&'f self, request: &'f ViewRequest, resources: &'f Resources) -> Frame<'f> {
        Frame {
            context: Context { request, ..self.context(resources) },
            camera: &self.viewer.camera,
            threshold: Threshold::of(self.request.purpose, self.exposure.white()),
            reflectors: &self.reflectors,
            air: self.air.as_ref(),
        }
    }

    /// Whether the camera sits at this body's centre, so that the body is not drawn.
    fn is_inside(&self, body: &Body) -> bool {
        self.viewer.inside == Some(body.id)
    }

    /// The request with the effects that are set for this body only; `None` if none are.
    fn own_request(&self, body: &Body) -> Option<ViewRequest> {
        self.request.effects.for_body(&body.name).map(|effects| ViewRequest { effects, ..self.request.clone() })
    }

    /// The files and tables that [`Self::build`] needs for the complete scene. `known` says which files cannot be read.
    pub fn requirements(&self, known: &Resources) -> Requirements {
        let frame = self.frame(self.request, known);
        let mut wanted = Requirements::default();
        for p in self.placed.iter().filter(|p| !self.is_inside(p.body)) {
            let own_request = self.own_request(p.body);
            let frame = Frame { context: Context { request: own_request.as_ref().unwrap_or(self.request), ..frame.context }, ..frame };
            if meshes::is_wanted(frame.context, frame.camera, p) {
                let shaded = frame.context.request.effects.override_of(Effect::SelfShadow) != Some(false);
                wanted.meshes.push(MeshWanted { body: p.body.id, sun: mesh_decision::sun_over(&frame, p).filter(|_| shaded) });
            }
            if needs_table(&Case::of(&frame, p)) {
                wanted.scattering_tables.push(p.body.id);
            }
            wanted.maps.extend(features::maps_wanted(&frame, p));
        }
        wanted.sky_map = self.background(&frame, false).0.and_then(|b| b.map_file);
        wanted
    }

    /// Diffuse light of the sky, and the decisions about it.
    fn background(&self, frame: &Frame<'_>, has_corona: bool) -> (Option<background::SkyBackground>, Vec<Decision>) {
        let resources = frame.context.resources;
        let map = resources.sky_map();
        let is_unreadable = resources.is_unreadable(&map.file);
        background::background(self.request, &self.viewer.camera, &self.placed, frame.threshold, &map, is_unreadable, has_corona)
    }

    /// Decides on every feature of every body, and makes the scene from the resources that were loaded.
    pub fn build(self, resources: &Resources) -> Scene {
        let (request, camera, placed) = (self.request, &self.viewer.camera, &self.placed);
        let context = self.context(resources);
        let frame = self.frame(request, resources);
        let (mut draws, mut points, mut arcs, mut lines) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let is_final = request.pixel_view == PixelView::Final;
        let (draws_orbits, draws_traces) = (request.layers.orbits && is_final, request.layers.traces && is_final);
        let target_distance_km =
            placed.iter().find(|p| request.target == Some(p.body.id) && !self.is_inside(p.body)).map(|p| p.distance_km);
        let centre = request.target.unwrap_or(NaifId::SUN);
        let mut seen_bodies = placed.iter().map(|p| {
            let own_request = self.own_request(p.body);
            let frame = Frame { context: Context { request: own_request.as_ref().unwrap_or(request), ..context }, ..frame };
            let mut decided = features::decide(&frame, p, self.is_inside(p.body));
            let (parts, point) = (std::mem::take(&mut decided.draws), decided.point.take());
            let mut found = body_in_view(p, decided, &parts, magnitude::magnitude(context, p, placed));
            if let Some((orbit_arcs, decision)) =
                draws_orbits.then(|| orbits::line(camera, self.ephemeris, p, target_distance_km)).flatten()
            {
                arcs.extend(orbit_arcs);
                found.decisions.push(decision);
            }
            if let Some((pieces, decision)) = draws_traces.then(|| traces::trace(camera, self.ephemeris, p, centre)).flatten() {
                lines.extend(pieces);
                found.decisions.push(decision);
            }
            draws.extend(parts);
            points.extend(point);
            found
        });
        let mut bodies: Vec<BodyInView> =
            self.unplaced.iter().filter_map(|unplaced| unplaced.clone().or_else(|| seen_bodies.next())).collect();
        drop(seen_bodies);
        let tint = |to: DVec3| frame.air.map_or(DVec3::ONE, |a| a.tint(to));
        let limbs = refracted_limb::limbs(request, camera, placed, frame.threshold, tint, &mut bodies);
        let transmittance = |to: DVec3| frame.air.map_or(DVec3::ONE, |a| a.transmittance(to));
        let glow = decide_sun_effect(request, Effect::Glow, glow::glow(camera, placed, frame.threshold, transmittance), &mut bodies);
        let corona = corona::corona(request, camera, placed, frame.threshold, tint);
        let corona = decide_sun_effect(request, Effect::Corona, corona, &mut bodies);
        lunar_limb::apply_to_moon(placed, camera, &mut draws, &mut bodies);
        hidden::apply(placed, camera, &mut draws, &mut points, &mut bodies);
        lunar_limb::update_features(&draws, &mut bodies);
        let white = self.exposure.white();
        points.iter_mut().for_each(|p| point::spread_glare(p, white));
        let minor_planet_columns = || {
            let columns = || Arc::new(MinorPlanetColumns::of(&self.catalog.small_bodies().minor_planets));
            Arc::clone(self.caches.minor_planets.get_or_init(columns))
        };
        let sun_km = self.ephemeris.state(NaifId::SUN, NaifId::SOLAR_SYSTEM_BARYCENTER, request.time, None).ok().map(|s| s.state.pos_km);
        let (minor_planets, minor_planet_decisions) =
            minor_planets::minor_planets(request, minor_planet_columns, &self.viewer, sun_km, white);
        let (stars, star_decisions) = stars::stars(request, self.catalog, &self.viewer, frame.threshold, white, frame.air);
        let (background, mut sky) = self.background(&frame, corona.is_some());
        sky.splice(0..0, star_decisions);
        let (sky_images, image_decisions) = self.sky_images();
        sky.extend(image_decisions);
        let (mut comets, comet_decisions) =
            comets::comets(request, || self.catalog.small_bodies().comets.clone(), &self.viewer, sun_km, white);
        arcs.append(&mut comets.orbits);
        sky.extend(minor_planet_decisions.into_iter().chain(comet_decisions));
        let draws = order::far_to_near(placed, draws);
        let corona = corona.map(|c| corona::Corona { draws_behind: order::draws_behind(placed, &draws, NaifId::SUN), ..c });
        let selected = request.selected.or(request.target).unwrap_or(NaifId::SUN);
        let outlined = draws.iter().find(|d| d.body == selected && d.part == Part::Globe);
        let outlined = outlined.filter(|_| request.layers.outline).map(Draw::shape_alone);
        let labels = labels::LabelLayer::of(camera, request, self.catalog, &bodies, true);
        let (sky_layer, ground_layer) = self.sky_and_ground_lines(context);
        if request.layers.eclipse_cones && is_final {
            let found = self.body_with_lines().map(|p| eclipse_lines::in_space(context, camera, p));
            let (cones, decision) = found.unzip();
            lines.extend(cones.into_iter().flatten());
            sky.extend(decision);
        }
        let size_px = labels::glyph_size_px(camera.height);
        let instrument_layer = self.instrument_frames(size_px);
        lines.extend(instrument_layer.segments);
        sky.extend(sky_layer.decisions.into_iter().chain(ground_layer.decisions).chain(instrument_layer.decisions));
        let mut sky_texts = sky_layer.texts;
        if request.layers.star_names && is_final {
            let (names, decision) = star_names::star_names(camera, &stars, self.catalog.stars().stars(), size_px);
            sky_texts.splice(0..0, names);
            sky.push(decision);
        }
        // Bodies, including the ground, hide labels on the sky behind them. A label on the horizon is drawn above it.
        let label_lift_px = DVec2::new(0.0, size_px);
        let is_hidden_by = |p: &PlacedBody<'_>, at_px: DVec2| {
            let is_ground = self.viewer.stands_on.is_some_and(|(id, _)| id == p.body.id);
            let at_px = if is_ground { at_px - label_lift_px } else { at_px };
            !self.is_inside(p.body) && camera.surface_under_pixel(&p.placement, at_px).is_some()
        };
        // Coordinate ticks stay at the picture's edge, even those of azimuths below the horizon.
        let on_sky = sky_texts.into_iter().filter(|t| t.is_tick || !placed.iter().any(|p| is_hidden_by(p, t.at_px)));
        let wanted: Vec<_> = on_sky.chain(ground_layer.texts).chain(instrument_layer.texts).collect();
        let texts = (!wanted.is_empty()).then(|| line_texts::place_texts(wanted, labels.as_ref(), size_px, camera.half_size() * 2.0));
        let ground_lines = self.body_with_lines().map(|p| (p.body.id, ground_layer.segments)).filter(|(_, pieces)| !pieces.is_empty());
        Scene {
            time: request.time,
            camera: camera.clone(),
            geometry: ImageGeometry::Perspective,
            exposure: self.exposure.clone(),
            pixel_view: request.pixel_view,
            tone_map: request.tone_map,
            bodies,
            background,
            sky_images,
            stars,
            minor_planets,
            comets,
            sky,
            sky_lines: sky_layer.segments,
            draws,
            points,
            orbits: arcs,
            lines,
            ground_lines,
            corona,
            limbs,
            glow,
            outlined,
            bloom: request.layers.bloom && request.pixel_view == PixelView::Final,
            labels,
            texts,
            purpose: request.purpose,
        }
    }

    /// The body on which ground lines are drawn: the target, or the body that the viewer stands on.
    fn body_with_lines(&self) -> Option<&PlacedBody<'a>> {
        let id = self.request.target.or(self.viewer.stands_on.map(|(id, _)| id))?;
        self.placed.iter().find(|p| p.body.id == id && !self.is_inside(p.body))
    }

    /// Fields of view of instruments around the target.
    fn instrument_frames(&self, size_px: f64) -> SkyLines {
        if !self.request.layers.instruments || self.request.pixel_view != PixelView::Final {
            return SkyLines::default();
        }
        let target = self.placed.iter().find(|p| Some(p.body.id) == self.request.target && !self.is_inside(p.body));
        instrument_frames::frames(self.catalog.instruments(), &self.viewer.camera, target.map(|p| p.placement.centre_km), size_px)
    }

    /// The user's images of the sky; none in pixel views other than the final image.
    fn sky_images(&self) -> (Vec<SkyImageDraw>, Vec<Decision>) {
        match self.request.layers.data && self.request.pixel_view == PixelView::Final {
            true => images::images(&self.catalog.data_layers(), &self.viewer.camera, self.viewer.body_velocity_km_s),
            false => Default::default(),
        }
    }

    /// Lines of the sky and of the ground; none in pixel views other than the final image.
    fn sky_and_ground_lines(&self, context: Context<'_>) -> (SkyLines, SkyLines) {
        if self.request.pixel_view != PixelView::Final {
            return Default::default();
        }
        let horizon = match (self.request.position, self.viewer.stands_on) {
            (Position::Ground { latitude_deg, longitude_deg, .. }, Some((id, _))) => {
                let body_from_icrf = self.ephemeris.body_from_icrf(id, self.request.time).ok();
                let radii_km = self.catalog.body(id).map_or(DVec3::ONE, |b| b.radii_km);
                let (_, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, 0.0);
                body_from_icrf.map(|m| horizon_axes(m.transpose() * normal, m.row(2)))
            }
            _ => None,
        };
        let sky_layer = sky_lines::sky_lines(self.request, &self.viewer, horizon);
        (sky_layer, ground_lines::ground_lines(context, &self.viewer.camera, self.body_with_lines(), &self.catalog.data_layers()))
    }
}

/// Decides whether light around the Sun (glow, corona) is drawn, and records the decision with the Sun's others.
fn decide_sun_effect<T>(request: &ViewRequest, effect: Effect, found: Option<(T, bool, String)>, bodies: &mut [BodyInView]) -> Option<T> {
    let (light, by_bound, reason) = found.filter(|_| request.pixel_view == PixelView::Final)?;
    let (on, reason) = match request.effects.override_of(effect) {
        Some(on) => (on, "set by you".into()),
        None => (by_bound, reason),
    };
    let feature = effect.name();
    bodies
        .iter_mut()
        .filter(|b| b.id == NaifId::SUN)
        .for_each(|b| b.decisions.push(Decision { feature, on, reason: reason.clone(), tier: None }));
    on.then_some(light)
}

fn body_in_view(p: &PlacedBody<'_>, decided: DecidedBody, parts: &[Draw], magnitude: Option<f64>) -> BodyInView {
    let to_viewer = p.placement.body_from_icrf * -p.placement.centre_km;
    BodyInView {
        id: p.body.id,
        name: p.body.name.clone(),
        appearance: decided.appearance,
        distance_km: p.distance_km,
        angular_diameter_deg: 2.0 * (p.body.radii_km.max_element() / p.distance_km).min(1.0).asin().to_degrees(),
        diameter_px: decided.diameter_px,
        phase_angle_deg: p.alpha.to_degrees(),
        magnitude,
        sub_viewer: SubPoint::of(to_viewer),
        sub_solar: (p.body.id != NaifId::SUN).then(|| SubPoint::of(p.body_from_icrf * p.sun_from_body_km)),
        placement: p.placement,
        features: parts.iter().map(|d| d.features).collect(),
        invented: invented(p.body, parts),
        decisions: decided.decisions,
    }
}

/// The report of a body that the ephemeris could not place.
fn not_placed(body: &Body, reason: String) -> BodyInView {
    BodyInView {
        id: body.id,
        name: body.name.clone(),
        appearance: Appearance::NotShown,
        distance_km: f64::NAN,
        angular_diameter_deg: f64::NAN,
        diameter_px: 0.0,
        phase_angle_deg: f64::NAN,
        magnitude: None,
        sub_viewer: SubPoint { latitude_deg: f64::NAN, longitude_deg: f64::NAN },
        sub_solar: None,
        placement: Placement { centre_km: DVec3::NAN, body_from_icrf: DMat3::IDENTITY, radii_km: body.radii_km },
        decisions: vec![Decision { feature: "visible", on: false, reason, tier: None }],
        features: Vec::new(),
        invented: Vec::new(),
    }
}

/// Those maps, shape and detail shown in a body's draws that nobody has measured: file and method.
fn invented(body: &Body, parts: &[Draw]) -> Vec<(String, String)> {
    let maps = [&body.maps.albedo, &body.maps.normal, &body.maps.specular, &body.maps.night].into_iter().flatten();
    let maps = maps.chain(body.clouds.as_ref().map(|c| &c.map)).filter_map(|m| Some((&m.file, m.invented.as_ref()?)));
    let shown = |file: &String| parts.iter().any(|d| d.map_files.by_role().any(|(_, f)| f == file));
    let meshed = parts.iter().any(|d| d.features.shape == Shape::Mesh);
    let detailed = parts.iter().any(|d| d.features.detail).then(|| ("detail".to_owned(), detail::LAW.to_owned()));
    let shape = body.mesh.iter().filter(|_| meshed).filter_map(|m| Some((&m.file, m.invented.as_ref()?)));
    maps.filter(|(file, _)| shown(file)).chain(shape).map(|(file, how)| (file.clone(), how.clone())).chain(detailed).collect()
}
