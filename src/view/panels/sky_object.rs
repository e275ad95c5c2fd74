//! Stars, comets and minor planets over the image: the ring around the chosen one, names of comets, and what a click selects.
//!
//! In: the image on screen with its scene, the session. Out: what is painted; an object and its title. Always: names keep apart from each other and from those
//! of bodies. Not here: the facts about the object (`information`).

use super::Interface;
use super::theme::{BODY_TEXT_POINTS, HIGHLIGHT_COLOUR, opaque};
use crate::catalog::small_bodies::SmallBody;
use crate::scene::draw::PixelView;
use crate::scene::labels::{
    self, LabelLayer, LabelMetrics, MARKER_RADIUS, Margin, SkyObject, SmallBodySight, place_texts, sight_of, small_body_at,
    small_body_names, small_body_px, star_at, star_px,
};
use crate::scene::{Scene, small_body_magnitude};
use crate::session::Session;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY};
use crate::view::language::{decimal, text};
use egui::{Align2, Color32, FontId, Painter, Pos2, Stroke, Vec2};
use glam::DVec2;

/// Text size of names, points.
pub(super) const NAME_POINTS: f32 = BODY_TEXT_POINTS;
/// Radius of a marker, and of the ring around the chosen object, points.
pub(super) const MARKER_RADIUS_POINTS: f32 = MARKER_RADIUS as f32 * NAME_POINTS;
/// Colour of names and hints.
pub(super) const NAME_COLOUR: Color32 = opaque(labels::NAME_COLOUR);

/// The star, comet or minor planet at a pixel of the image: of a star and a small body the nearer one.
pub(super) fn object_at(interface: &Interface, session: &Session, image_px: DVec2) -> Option<SkyObject> {
    let rendered = interface.shown()?;
    let (scene, layers) = (&rendered.scene, &rendered.job.request.layers);
    let star = star_at(scene, image_px);
    let star_distance_px = star.and_then(|star| star_px(scene, star)).map_or(f64::INFINITY, |px| px.distance(image_px));
    let small_body = small_body_at(scene, session.ephemeris(), &session.catalog().small_bodies(), layers, image_px);
    let nearer = small_body.filter(|(_, distance_px)| *distance_px <= star_distance_px).map(|(object, _)| object);
    nearer.or(star.map(SkyObject::Star))
}

/// Name and magnitude of an object in one line, as the camera of the scene sees it.
pub(super) fn title(object: SkyObject, session: &Session, scene: &Scene) -> Option<String> {
    let (catalog, ephemeris) = (session.catalog(), session.ephemeris());
    match object {
        SkyObject::Star(index) => catalog.stars().stars().get(index).map(super::star::title),
        SkyObject::Comet(_) | SkyObject::MinorPlanet(_) => {
            let all = catalog.small_bodies();
            object.small_body(&all).map(|body| small_body_title(body, &sight_of(scene, ephemeris)))
        }
    }
}

/// Name and magnitude of a comet or minor planet in one line.
pub(super) fn small_body_title(body: &SmallBody, sight: &SmallBodySight<'_>) -> String {
    let magnitude = sight.see(body).and_then(|seen| {
        let brightness = body.brightness_at(sight.time.tdb_seconds_past_j2000() / SECONDS_PER_DAY);
        small_body_magnitude(brightness, seen.apparent_km.length() / KM_PER_AU, seen.sun_distance_au, seen.phase_angle_rad)
    });
    let name = body.full_name();
    magnitude.map_or(name.clone(), |magnitude| text!("star-title", star = name, magnitude = decimal(magnitude, 1)))
}

/// Paints the ring around the chosen object and, as the settings demand, the names of the comets that the image shows and of the chosen comet or minor planet.
/// A small body whose layer is off has neither. `to_point`: the point of a pixel of the image.
pub(super) fn paint(interface: &Interface, painter: &Painter, session: &Session, points_per_px: f64, to_point: impl Fn(DVec2) -> Pos2) {
    let Some(rendered) = interface.shown() else { return };
    let (scene, request) = (&rendered.scene, &rendered.job.request);
    let all = session.catalog().small_bodies();
    let is_drawn = |object: &SkyObject| match object {
        SkyObject::Star(_) => true,
        SkyObject::Comet(_) => request.layers.comets,
        SkyObject::MinorPlanet(_) => request.layers.minor_planets,
    };
    let chosen = interface.viewport.sky_object.filter(is_drawn);
    let chosen_px = chosen.and_then(|object| match object {
        SkyObject::Star(index) => star_px(scene, index),
        SkyObject::Comet(_) | SkyObject::MinorPlanet(_) => small_body_px(scene, session.ephemeris(), object.small_body(&all)?),
    });
    if let Some(px) = chosen_px {
        painter.circle_stroke(to_point(px), MARKER_RADIUS_POINTS, Stroke::new(1.0, HIGHLIGHT_COLOUR));
    }
    // Names that the image itself has are not repeated.
    if !interface.settings.labels_bodies || request.layers.labels || request.pixel_view != PixelView::Final {
        return;
    }
    let comets: &[SmallBody] = if request.layers.comets { &all.comets } else { &[] };
    let chosen_body = chosen.and_then(|object| object.small_body(&all));
    let minor_planet = chosen_body.filter(|_| matches!(chosen, Some(SkyObject::MinorPlanet(_))));
    let glyph_px = f64::from(NAME_POINTS) / points_per_px;
    let sight = sight_of(scene, session.ephemeris());
    let image = scene.geometry.projection(&scene.camera);
    let bodies = comets.iter().chain(minor_planet);
    let names = small_body_names(&*image, &sight, &scene.bodies, bodies, scene.limiting_magnitude(), chosen_body, glyph_px);
    // The names of the bodies, as places that are taken.
    let of_bodies = LabelLayer {
        glyph_px,
        selected: interface.viewer.selected,
        labels: interface.viewport.labels.clone(),
        margin: Margin::default(),
        dots: Vec::new(),
    };
    let size_px = DVec2::new(f64::from(rendered.width), f64::from(rendered.height));
    let (metrics, taken) = (LabelMetrics::of_size(glyph_px), scene.text_and_bar_rects());
    for name in place_texts(names, Some(&of_bodies), glyph_px, size_px).texts {
        let rect = metrics.rect(&name.text, name.left_end_px);
        if taken.iter().any(|other| other.overlaps(&rect)) {
            continue;
        }
        let (anchor, font) = (to_point(name.left_end_px), FontId::proportional(NAME_POINTS));
        painter.text(anchor + Vec2::splat(1.0), Align2::LEFT_CENTER, &name.text, font.clone(), Color32::from_black_alpha(180));
        painter.text(anchor, Align2::LEFT_CENTER, &name.text, font, NAME_COLOUR);
    }
}
