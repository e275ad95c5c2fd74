//! What one frame needs, and why.
//!
//! In: the catalog, the ephemeris and a [`request::ViewRequest`]. Out: a [`Scene`]: the camera, every body with its decisions, the
//! draws far to near and the points. Everything is f64 until [`camera`] narrows it. Nothing here knows of shaders or keeps state.

mod air;
pub mod air_nodes;
pub mod air_spread;
pub mod air_table;
mod brightness;
pub mod camera;
mod clouds;
pub mod constants;
pub mod corona;
pub mod draw;
pub mod eclipse;
pub mod effects;
mod exposure;
mod extinction;
mod features;
pub mod glow;
mod hidden;
mod kept;
pub mod lamps;
pub mod legend;
mod lights;
pub mod marks;
mod meshes;
mod meter;
mod needs;
mod numeric;
pub mod orbits;
mod order;
pub mod overlays;
mod phase_laws;
pub mod photometry;
pub mod purpose;
pub mod refracted_limb;
pub mod request;
mod ring_light;
pub mod ring_shine;
mod ring_table;
pub mod rings;
pub mod silhouette;
pub mod tiers;
pub mod viewpoint;

use crate::catalog::{Body, Catalog, NaifId};
use crate::ephemeris::{Ephemeris, EphemerisError};
use crate::time::Instant;
use camera::{Camera, Placement};
use draw::{Draw, Part, PixelView, Point};
use effects::Decision;
pub use exposure::{AUTO_EXPOSED_MEAN, AUTO_EXPOSED_SUN, CANDELAS_PER_RADIANCE, DARKEST_EV, darkest_white};
pub use features::disc_share;
use features::{Frame, Seen};
use glam::{DMat3, DVec3};
use lights::Reflector;
use request::ViewRequest;
use silhouette::Outline;
use std::cell::OnceCell;

#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("{0}")]
    Request(String),
    #[error(transparent)]
    Unknown(#[from] crate::catalog::UnknownName),
    #[error("`{0}` is not a body of the catalog (a barycentre has no surface): name a body")]
    NotABody(String),
    #[error("the camera is inside {0}: move it out, or leave the body's name out of the position")]
    Inside(String),
    #[error(transparent)]
    Ephemeris(#[from] EphemerisError),
}

/// How radiance becomes brightness.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// 2^stops is the factor on radiance.
    pub stops: f64,
    /// What the light meter says, where it was asked; else the same.
    pub metered_stops: f64,
    pub reason: String,
}

impl Exposure {
    pub fn of(stops: f64, reason: impl Into<String>) -> Self {
        Self { stops, metered_stops: stops, reason: reason.into() }
    }
    pub fn factor(&self) -> f64 {
        self.stops.exp2()
    }
    /// The factor for the tone map.
    pub fn factor_f32(&self) -> f32 {
        camera::narrow_scalar(self.factor())
    }
    /// The radiance that the picture shows as white.
    pub fn white(&self) -> f64 {
        1.0 / self.factor()
    }
}

/// How a body is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Appearance {
    Disc,
    /// 2 to 4 pixels across: a disc that grows out of its point, the light shared between them.
    DiscAndPoint,
    Point,
    /// Outside the frame, behind the camera, around it, or not placed by the ephemeris: the first decision says which.
    NotShown,
}

/// Planetocentric place under a direction, degrees; east longitude in -180..=180.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SubPoint {
    pub latitude_deg: f64,
    pub longitude_deg: f64,
}

impl SubPoint {
    pub fn of(direction_in_body: DVec3) -> Self {
        Self {
            latitude_deg: direction_in_body.z.atan2(direction_in_body.truncate().length()).to_degrees(),
            longitude_deg: direction_in_body.y.atan2(direction_in_body.x).to_degrees(),
        }
    }
}

/// One body of the frame: what the viewer has of it and what was decided.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyInView {
    pub id: NaifId,
    pub name: String,
    pub appearance: Appearance,
    /// To the apparent centre.
    pub distance_km: f64,
    pub angular_diameter_deg: f64,
    /// Diameter of the disc of the same area, pixels.
    pub diameter_px: f64,
    /// Sun - body - viewer; 0 for the Sun.
    pub phase_angle_deg: f64,
    /// Visual magnitude of the whole disc with its rings, in the sunlight that eclipses leave; `None` where none is left.
    pub magnitude: Option<f64>,
    pub sub_viewer: SubPoint,
    pub sub_solar: Option<SubPoint>,
    pub placement: Placement,
    pub decisions: Vec<Decision>,
    /// Structure of its draws, the globe first.
    pub needs: Vec<draw::Needs>,
    /// What is shown of it that nobody has measured: a map's or a shape's file, and how it was made.
    pub invented: Vec<(String, String)>,
}

/// One frame, ready to be planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub time: Instant,
    pub camera: Camera,
    pub exposure: Exposure,
    pub pixel_view: PixelView,
    pub tone_map: request::ToneMap,
    /// Every body of the catalog, in its order.
    pub bodies: Vec<BodyInView>,
    /// Far to near: `order`.
    pub draws: Vec<Draw>,
    pub points: Vec<Point>,
    /// Over the bodies, hidden by what is nearer.
    pub lines: Vec<orbits::LinePiece>,
    /// Among the draws.
    pub corona: Option<corona::Corona>,
    /// Around bodies that stand before the Sun.
    pub limbs: Vec<refracted_limb::RefractedLimb>,
    /// Over everything.
    pub glow: Option<glow::Glow>,
    /// The selected body as a black shape, where its outline is wanted.
    pub outlined: Option<Draw>,
    /// Light beyond white spreads.
    pub bloom: bool,
    /// Over the finished picture, where they are wanted.
    pub labels: Option<marks::Labels>,
    /// Bodies whose shape model is wanted and was not in the request: drawn as ellipsoids.
    pub unread_meshes: Vec<NaifId>,
    /// Bodies whose lamps the exposure wants to know and that were not in the request.
    pub unread_lamps: Vec<NaifId>,
    /// What the picture is for.
    pub purpose: request::Purpose,
}

/// A body where the viewer sees it, before anything is decided.
struct Placed<'a> {
    body: &'a Body,
    /// Who else there is.
    catalog: &'a Catalog,
    /// Barycentric, when the light left.
    position_km: DVec3,
    sun_from_body_km: DVec3,
    seen_at: Instant,
    /// When the light left; directions to lights are turned by this one, the view by the placement's.
    body_from_icrf: DMat3,
    placement: Placement,
    distance_km: f64,
    alpha: f64,
    outline: Outline,
    /// At the viewer, in units of the Sun's at 1 au: globe and rings, as if no eclipse were.
    irradiance: f64,
    /// Itself as a receiver of sunlight, and who may stand before its Sun: asked for by the exposure, the globe, its rings and its point.
    before_sun: OnceCell<(eclipse::Receiver<'a>, Vec<eclipse::Caster<'a>>)>,
}

impl Scene {
    /// Looks at the sky of `request.time` from the request's camera.
    pub fn build(catalog: &Catalog, ephemeris: &Ephemeris, request: &ViewRequest) -> Result<Self, SceneError> {
        let viewer = viewpoint::viewer(catalog, ephemeris, request)?;
        let camera = &viewer.camera;
        let mut placed = Vec::new();
        let mut bodies: Vec<Option<BodyInView>> = Vec::new();
        for body in catalog.bodies() {
            match place(catalog, body, ephemeris, &viewer, request) {
                Ok(p) => {
                    placed.push(p);
                    bodies.push(None);
                }
                Err(e @ SceneError::Inside(_)) => return Err(e),
                Err(e) if request.target == Some(body.id) => return Err(e),
                Err(e) => bodies.push(Some(unplaced(body, e.to_string()))),
            }
        }
        let air = placed.iter().find_map(|p| air::Around::of(p.body, &p.placement));
        let reflectors: Vec<Reflector<'_>> =
            placed.iter().map(|p| Reflector { body: p.body, position_km: p.position_km, sun_from_body_km: p.sun_from_body_km }).collect();
        let exposure = exposure::exposure(request, camera, &placed, &reflectors, air.as_ref(), ephemeris);
        let bound = purpose::Bound::of(request.purpose, exposure.white());
        let frame = Frame { request, camera, bound, reflectors: &reflectors, ephemeris, air: air.as_ref() };
        let mut draws: Vec<Draw> = Vec::new();
        let mut points = Vec::new();
        let mut lines = Vec::new();
        let drawn_lines = request.layers.orbits && request.pixel_view == PixelView::Shaded;
        let mut next = placed.iter();
        for slot in bodies.iter_mut().filter(|b| b.is_none()) {
            let Some(p) = next.next() else { break };
            let hidden_inside = viewer.inside == Some(p.body.id);
            let own = request.effects.for_body(&p.body.name).map(|effects| ViewRequest { effects, ..request.clone() });
            let frame = Frame { request: own.as_ref().unwrap_or(request), ..frame };
            let (seen, parts, point) = features::decide(&frame, p, hidden_inside);
            let mut found = in_view(p, seen, &parts, brightness::magnitude(request, ephemeris, p, &placed));
            if let Some((pieces, decision)) = orbits::line(camera, ephemeris, p).filter(|_| drawn_lines) {
                lines.extend(pieces);
                found.decisions.push(decision);
            }
            *slot = Some(found);
            draws.extend(parts);
            points.extend(point);
        }
        let unread_meshes = meshes::unread(request, camera, &placed);
        let unread_lamps = exposure::unread_lamps(request, camera, &placed, &exposure);
        let mut bodies: Vec<BodyInView> = bodies.into_iter().flatten().collect();
        let tint = |to: DVec3| frame.air.as_ref().map_or(DVec3::ONE, |a| a.tint(to));
        let limbs = refracted_limb::limbs(request, camera, &placed, bound, tint, &mut bodies);
        let through = |to: DVec3| frame.air.as_ref().map_or(DVec3::ONE, |a| a.transmittance(to));
        let glow = decided(request, effects::Effect::Glow, glow::glow(camera, &placed, bound, through), &mut bodies);
        let corona = corona::corona(request, camera, &placed, bound, tint);
        let corona = decided(request, effects::Effect::Corona, corona, &mut bodies);
        hidden::take(&placed, camera, &mut draws, &mut points, &mut bodies);
        let draws = order::far_to_near(&placed, draws);
        let corona = corona.map(|c| corona::Corona { draws_behind: order::draws_behind(&placed, &draws, NaifId::SUN), ..c });
        let selected = request.selected.or(request.target).unwrap_or(NaifId::SUN);
        let outlined = draws.iter().find(|d| d.body == selected && d.part == Part::Globe);
        let outlined = outlined.filter(|_| request.layers.outline).map(Draw::shape_alone);
        let labels = request.layers.labels.then(|| {
            let size_px = marks::letter_size_px(camera.height);
            let parent = |id: NaifId| catalog.body(id).and_then(|b| b.parent);
            let marks = marks::marks(camera, &bodies, selected, parent, &marks::Lettering::of_size(size_px));
            marks::Labels { size_px, selected, marks }
        });
        Ok(Self {
            time: request.time,
            camera: viewer.camera,
            exposure,
            pixel_view: request.pixel_view,
            tone_map: request.tone_map,
            bodies,
            draws,
            points,
            lines,
            corona,
            limbs,
            glow,
            outlined,
            bloom: request.layers.bloom && request.pixel_view == PixelView::Shaded,
            labels,
            unread_meshes,
            unread_lamps,
            purpose: request.purpose,
        })
    }

    pub fn body(&self, id: NaifId) -> Option<&BodyInView> {
        self.bodies.iter().find(|b| b.id == id)
    }
}

/// Decides on light around the Sun and notes it among the Sun's features.
fn decided<T>(request: &ViewRequest, effect: effects::Effect, found: Option<(T, bool, String)>, bodies: &mut [BodyInView]) -> Option<T> {
    let (light, by_bound, reason) = found.filter(|_| request.pixel_view == PixelView::Shaded)?;
    let (on, reason) = match request.effects.asked(effect) {
        Some(on) => (on, "asked for".into()),
        None => (by_bound, reason),
    };
    let feature = effect.name();
    bodies
        .iter_mut()
        .filter(|b| b.id == NaifId::SUN)
        .for_each(|b| b.decisions.push(Decision { feature, on, reason: reason.clone(), tier: None }));
    on.then_some(light)
}

/// Puts a body where the viewer sees it: light time, and aberration for a viewer who moves.
fn place<'a>(
    catalog: &'a Catalog,
    body: &'a Body,
    ephemeris: &Ephemeris,
    viewer: &viewpoint::Viewer,
    request: &ViewRequest,
) -> Result<Placed<'a>, SceneError> {
    let camera = &viewer.camera;
    let stood_on = viewer.stands_on.filter(|(id, _)| *id == body.id);
    let (position_km, seen_at) = match stood_on {
        _ if viewer.inside == Some(body.id) => (camera.position_km, request.time),
        Some((_, position_km)) => (position_km, request.time),
        None => ephemeris.light_time_position(body.id, camera.position_km, request.time)?,
    };
    let resting_km = position_km - camera.position_km;
    let distance_km = resting_km.length();
    let body_from_icrf = ephemeris.body_from_icrf(body.id, seen_at)?;
    let mut placement = Placement { centre_km: resting_km, body_from_icrf, radii_km: body.radii_km };
    if viewer.velocity_km_s != DVec3::ZERO && distance_km > 0.0 && stood_on.is_none() {
        let direction = resting_km / distance_km;
        let apparent = viewpoint::aberrated(direction, viewer.velocity_km_s);
        // The whole body turns with its apparent place: the viewer sees the face that the light left, moved on the sky.
        let apparent_from_resting = viewpoint::rotation_between(direction, apparent);
        placement.centre_km = apparent * distance_km;
        placement.body_from_icrf = body_from_icrf * apparent_from_resting.transpose();
    }
    let sun_from_body_km = if body.id == NaifId::SUN {
        DVec3::ZERO
    } else {
        ephemeris.light_time_position(NaifId::SUN, position_km, seen_at)?.0 - position_km
    };
    let inside = viewer.inside == Some(body.id);
    if !inside && placement.camera_is_inside() {
        return Err(SceneError::Inside(body.name.clone()));
    }
    let alpha = if body.id == NaifId::SUN || inside { 0.0 } else { crate::ephemeris::angle_rad(-resting_km, sun_from_body_km) };
    let n = placement.camera_in_unit_sphere() * body.radii_km;
    let irradiance =
        if inside { 0.0 } else { brightness::irradiance(body, alpha, body_from_icrf * sun_from_body_km, n.normalize() * distance_km) };
    let outline = if inside { Outline::Behind } else { Outline::of(camera, &placement) };
    Ok(Placed {
        body,
        catalog,
        position_km,
        sun_from_body_km,
        seen_at,
        body_from_icrf,
        placement,
        distance_km,
        alpha,
        outline,
        irradiance,
        before_sun: OnceCell::new(),
    })
}

fn in_view(p: &Placed<'_>, seen: Seen, parts: &[Draw], magnitude: Option<f64>) -> BodyInView {
    let to_viewer = p.placement.body_from_icrf * -p.placement.centre_km;
    BodyInView {
        id: p.body.id,
        name: p.body.name.clone(),
        appearance: seen.appearance,
        distance_km: p.distance_km,
        angular_diameter_deg: 2.0 * (p.body.radii_km.max_element() / p.distance_km).min(1.0).asin().to_degrees(),
        diameter_px: seen.diameter_px,
        phase_angle_deg: p.alpha.to_degrees(),
        magnitude,
        sub_viewer: SubPoint::of(to_viewer),
        sub_solar: (p.body.id != NaifId::SUN).then(|| SubPoint::of(p.body_from_icrf * p.sun_from_body_km)),
        placement: p.placement,
        decisions: seen.decisions,
        needs: parts.iter().map(|d| d.needs).collect(),
        invented: invented(p.body, parts),
    }
}

/// The entry of a body that the ephemeris could not place.
fn unplaced(body: &Body, reason: String) -> BodyInView {
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
        needs: Vec::new(),
        invented: Vec::new(),
    }
}

/// The invented maps and shape that a body's draws show.
fn invented(body: &Body, parts: &[Draw]) -> Vec<(String, String)> {
    let maps = [&body.maps.albedo, &body.maps.normal, &body.maps.specular, &body.maps.night].into_iter().flatten();
    let maps = maps.chain(body.clouds.as_ref().map(|c| &c.map)).filter_map(|m| Some((&m.file, m.invented.as_ref()?)));
    let shown = |file: &String| parts.iter().any(|d| d.map_files.bindings().any(|(_, f)| f == file));
    let meshed = parts.iter().any(|d| d.needs.shape == draw::Shape::Mesh);
    let shape = body.mesh.iter().filter(|_| meshed).filter_map(|m| Some((&m.file, m.invented.as_ref()?)));
    maps.filter(|(file, _)| shown(file)).chain(shape).map(|(file, how)| (file.clone(), how.clone())).collect()
}
