//! Picking: finds the body, star, comet or minor planet under a click.
//!
//! In: the labels, the finished scene, the catalog with its rings, and the position of a click in pixels of the screen. Out: a body, an index into a list of
//! the catalog, or a position in pixels of the screen. Screen and image differ only on a warp mesh.

use crate::catalog::small_bodies::{SmallBodies, SmallBody};
use crate::catalog::{Catalog, NaifId, Ring};
use crate::ephemeris::Ephemeris;
use crate::scene::annotation::labels::Label;
use crate::scene::annotation::small_body_names::shown_px;
use crate::scene::body_report::{Appearance, BodyReport};
use crate::scene::draw::StarSprite;
use crate::scene::finished::Scene;
use crate::scene::request::effects::Effect;
use crate::scene::request::layers::Layers;
use crate::scene::sky::small_body_sight::SmallBodySight;
use glam::{DVec2, DVec3};

/// Largest distance of a click from the centre of the star or small body that it selects, pixels. A body is small if its disc has a smaller radius than this.
pub const CLICK_RADIUS_PX: f64 = 14.0;

/// Optical depth along the line of sight from which a ring can be clicked on: it hides 1 % of what is behind it.
const MIN_RING_DEPTH: f64 = 0.01;

/// Largest distance of a click from the rings that it selects, pixels: some rings are narrower than a pixel.
const RING_REACH_PX: f64 = 3.0;

/// Largest number of minor planets of a list among which a click selects one: the places of more would take longer than the click.
const MAX_CLICKABLE: usize = 20_000;

/// Something in the sky that is no body of the catalog, by its index in a list of the catalog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyObject {
    /// In [`Catalog::stars`].
    Star(usize),
    /// In the comets of [`Catalog::small_bodies`].
    Comet(usize),
    /// In the minor planets of [`Catalog::small_bodies`].
    MinorPlanet(usize),
}

impl SkyObject {
    /// The comet or minor planet; `None` for a star.
    pub fn small_body(self, all: &SmallBodies) -> Option<&SmallBody> {
        match self {
            Self::Star(_) => None,
            Self::Comet(index) => all.comets.get(index),
            Self::MinorPlanet(index) => all.minor_planets.get(index),
        }
    }

    /// The comet or minor planet that equals `body`.
    pub fn of_small_body(all: &SmallBodies, body: &SmallBody) -> Option<Self> {
        let index_in = |list: &[SmallBody]| list.iter().position(|b| b == body);
        index_in(&all.comets).map(Self::Comet).or_else(|| index_in(&all.minor_planets).map(Self::MinorPlanet))
    }
}

/// The viewer of a finished scene.
pub fn sight_of<'a>(scene: &Scene, ephemeris: &'a Ephemeris) -> SmallBodySight<'a> {
    SmallBodySight { ephemeris, position_km: scene.camera.position_km, velocity_km_s: scene.viewer_velocity_km_s, time: scene.time }
}

/// The position on the screen of a comet or minor planet, if no body hides it; also of one whose layer is off.
pub fn small_body_px(scene: &Scene, ephemeris: &Ephemeris, body: &SmallBody) -> Option<DVec2> {
    shown_px(&*scene.geometry.projection(&scene.camera), &sight_of(scene, ephemeris), &scene.bodies, body)
}

/// The comet or minor planet that a click selects: of those whose layer is on the nearest within the click radius, with its distance from the click in pixels.
pub fn small_body_at(
    scene: &Scene,
    ephemeris: &Ephemeris,
    all: &SmallBodies,
    layers: &Layers,
    click_px: DVec2,
) -> Option<(SkyObject, f64)> {
    let is_clickable = layers.minor_planets && all.minor_planets.len() <= MAX_CLICKABLE;
    let comets = all.comets.iter().enumerate().filter(|_| layers.comets).map(|(k, body)| (SkyObject::Comet(k), body));
    let minor_planets = all.minor_planets.iter().enumerate().filter(|_| is_clickable).map(|(k, body)| (SkyObject::MinorPlanet(k), body));
    let image = scene.geometry.projection(&scene.camera);
    let sight = sight_of(scene, ephemeris);
    let distance_px = |body: &SmallBody| Some(shown_px(&*image, &sight, &scene.bodies, body)?.distance(click_px));
    let in_reach = comets.chain(minor_planets).filter_map(|(object, body)| Some((object, distance_px(body)?)));
    in_reach.filter(|(_, px)| *px <= CLICK_RADIUS_PX).min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// The star that a click selects: the brightest within the click radius that no body hides, as an index into the star catalog.
pub fn star_at(scene: &Scene, click_px: DVec2) -> Option<usize> {
    // Converts the click from the screen to the image, rather than every star from the image to the screen.
    let click_in_image = scene.geometry.image_of_screen(click_px)?;
    let in_reach = scene.stars.iter().filter(|s| sprite_px(scene, s).distance(click_in_image) <= CLICK_RADIUS_PX);
    in_reach.filter(|s| s.star.is_some() && !is_hidden(scene, s)).max_by(|a, b| a.flux.y.total_cmp(&b.flux.y)).and_then(|s| s.star)
}

/// The centre of the small body that a click selects, else the centre of the star that it selects, else the click's own position.
pub fn snapped_px(labels: &[Label], scene: &Scene, click_px: DVec2) -> DVec2 {
    let in_reach =
        labels.iter().filter(|l| l.radius_px < CLICK_RADIUS_PX).map(|l| l.centre_px).filter(|px| px.distance(click_px) <= CLICK_RADIUS_PX);
    let body = in_reach.min_by(|a, b| a.distance(click_px).total_cmp(&b.distance(click_px)));
    body.or_else(|| star_at(scene, click_px).and_then(|star| star_px(scene, star))).unwrap_or(click_px)
}

/// The position of a star on the screen, if it is drawn and no body hides it. `star`: index into the star catalog.
pub fn star_px(scene: &Scene, star: usize) -> Option<DVec2> {
    let sprite = scene.stars.iter().find(|s| s.star == Some(star) && !is_hidden(scene, s))?;
    scene.geometry.screen_of_image(sprite_px(scene, sprite))
}

/// Whether a body covers the centre of a sprite. The body in which the camera is covers nothing.
fn is_hidden(scene: &Scene, sprite: &StarSprite) -> bool {
    let screen_px = scene.geometry.screen_of_image(sprite_px(scene, sprite));
    let direction = screen_px.and_then(|px| scene.geometry.direction(&scene.camera, px));
    let covers = |b: &BodyReport, d: DVec3| !b.placement.camera_is_inside() && b.placement.surface_along(d).is_some();
    direction.is_some_and(|d| scene.bodies.iter().any(|b| covers(b, d)))
}

/// The centre of a sprite in pixels of the image.
fn sprite_px(scene: &Scene, sprite: &StarSprite) -> DVec2 {
    scene.geometry.sprite_px(&scene.camera, sprite.centre.truncate().as_dvec2())
}

/// The body that a click selects: the nearest small body within the click radius, else the one whose disc or rings are foremost under the click.
pub fn body_at(labels: &[Label], scene: &Scene, catalog: &Catalog, click_px: DVec2) -> Option<NaifId> {
    let nearest_small = labels
        .iter()
        .filter(|l| l.radius_px < CLICK_RADIUS_PX)
        .map(|l| (l.centre_px.distance(click_px), l.body))
        .filter(|(d, _)| *d <= CLICK_RADIUS_PX)
        .min_by(|(a_px, _), (b_px, _)| a_px.total_cmp(b_px));
    let foremost = || {
        let direction = scene.geometry.direction(&scene.camera, click_px)?;
        let reach_rad = RING_REACH_PX / scene.geometry.projection(&scene.camera).px_per_radian_in_middle();
        let distance_km = |body: &BodyReport| {
            let disc = body.placement.ground_along(direction).filter(|_| body.appearance == Appearance::Disc).map(DVec3::length);
            let rings = distance_of_rings_km(body, catalog, direction, reach_rad);
            disc.into_iter().chain(rings).min_by(f64::total_cmp)
        };
        let under_click = scene.bodies.iter().filter_map(|b| Some((distance_km(b)?, b.id)));
        under_click.min_by(|(a_km, _), (b_km, _)| a_km.total_cmp(b_km)).map(|(_, id)| id)
    };
    nearest_small.map(|(_, id)| id).or_else(foremost)
}

/// Distance along a direction from the camera (ICRF, unit vector) to a body's rings: to their plane, if the place there is between the innermost and the
/// outermost ring that hides more than [`MIN_RING_DEPTH`] of the background, or beside them by less than an angle. So gaps between such rings belong to them,
/// and the faint dust outside does not. `None` also if the image does not show the rings.
fn distance_of_rings_km(body: &BodyReport, catalog: &Catalog, direction: DVec3, reach_rad: f64) -> Option<f64> {
    if !body.decisions.iter().any(|d| d.effect == Effect::Rings.name() && d.on) {
        return None;
    }
    let (camera_km, ray) = (body.placement.body_from_icrf * -body.placement.centre_km, body.placement.body_from_icrf * direction);
    let distance_km = -camera_km.z / ray.z;
    if !(distance_km.is_finite() && distance_km > 0.0) {
        return None;
    }
    let is_dense = |ring: &&Ring| ring.tau_normal >= MIN_RING_DEPTH * ray.z.abs();
    let (inner_km, outer_km) = catalog
        .body(body.id)?
        .rings
        .iter()
        .filter(is_dense)
        .fold((f64::INFINITY, 0.0_f64), |(inner, outer), ring| (inner.min(ring.inner_km), outer.max(ring.outer_km)));
    let (radius_km, reach_km) = ((camera_km + ray * distance_km).truncate().length(), reach_rad * distance_km);
    (inner_km - reach_km..=outer_km + reach_km).contains(&radius_km).then_some(distance_km)
}
