//! Names of comets, and of chosen minor planets, beside them.
//!
//! In: bodies, their viewer, and the image. Out: texts, brightest bodies first, each at the right of its body; `line_texts` decides which of them fit. Named are
//! the bodies that the image shows by their own light, and the chosen one, however faint it is: a body too faint for the exposure has a marker but no name.
//! Bodies behind a nearer disc have no name. Left out: the light of the sky, and the spread of a coma's light.

use crate::catalog::small_bodies::SmallBody;
use crate::scene::annotation::data;
use crate::scene::annotation::labels::LabelMetrics;
use crate::scene::annotation::line_texts::UnplacedText;
use crate::scene::body_report::BodyReport;
use crate::scene::camera::sphere::ImageProjection;
use crate::scene::sky::comets::total_magnitude;
use crate::scene::sky::small_body_sight::SmallBodySight;
use crate::units::{KM_PER_AU, SECONDS_PER_DAY};
use glam::{DVec2, DVec3};

/// Linear RGB of the name of a comet or minor planet.
const COLOUR: DVec3 = DVec3::new(0.6, 0.85, 0.65);

/// Where the image shows a small body; `None` if it is outside the image, or behind one of `reports`.
pub(crate) fn shown_px(image: &dyn ImageProjection, sight: &SmallBodySight<'_>, reports: &[BodyReport], body: &SmallBody) -> Option<DVec2> {
    px_of(image, reports, sight.see(body)?.apparent_km)
}

/// The same for an apparent position, relative to the camera.
fn px_of(image: &dyn ImageProjection, reports: &[BodyReport], apparent_km: DVec3) -> Option<DVec2> {
    let px = image.pixel_of(apparent_km)?;
    let is_inside = px.cmpge(DVec2::ZERO).all() && px.cmple(image.size_px()).all();
    (is_inside && !data::is_hidden(reports, apparent_km.normalize(), apparent_km.length())).then_some(px)
}

/// The names of the bodies that the image shows. `limiting_magnitude`: of a point in the image. `chosen`: the body of `bodies` that is named in any case.
/// `glyph_px`: size of glyphs.
pub(crate) fn small_body_names<'b>(
    image: &dyn ImageProjection,
    sight: &SmallBodySight<'_>,
    reports: &[BodyReport],
    bodies: impl IntoIterator<Item = &'b SmallBody>,
    limiting_magnitude: f64,
    chosen: Option<&SmallBody>,
    glyph_px: f64,
) -> Vec<UnplacedText> {
    let metrics = LabelMetrics::of_size(glyph_px);
    let mut named: Vec<(f64, String, DVec2)> = Vec::new();
    for body in bodies {
        let Some(seen) = sight.see(body) else { continue };
        let Some(px) = px_of(image, reports, seen.apparent_km) else { continue };
        let brightness = body.brightness_at(sight.time.tdb_seconds_past_j2000() / SECONDS_PER_DAY);
        let magnitude = total_magnitude(brightness, seen.apparent_km.length() / KM_PER_AU, seen.sun_distance_au, seen.phase_angle_rad);
        let magnitude = magnitude.unwrap_or(f64::INFINITY);
        if magnitude <= limiting_magnitude || chosen == Some(body) {
            named.push((magnitude, body.full_name(), px));
        }
    }
    named.sort_by(|(magnitude, ..), (other, ..)| magnitude.total_cmp(other));
    let head_radius_px = 0.0;
    let text = |(_, name, px): (f64, String, DVec2)| {
        let centre_px = px + DVec2::new(0.5 * metrics.width_px(&name) + metrics.name_offset_px(head_radius_px), 0.0);
        UnplacedText { text: name, centre_px, colour: COLOUR, is_grid_coordinate: false }
    };
    named.into_iter().map(text).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use crate::ephemeris::Ephemeris;
    use crate::scene::Scene;
    use crate::scene::request::view_request::{Axes, ExposureRequest, Look, Position, Up, ViewRequest};
    use crate::time::Instant;

    /// The drawn head of Hale-Bopp is where its name and its click are, from the moving Earth's centre: aberration, 20 arcseconds, is 40 pixels here.
    #[test]
    fn a_comet_is_named_where_its_head_is_drawn() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the built-in kernel");
        let comets = catalog.small_bodies().comets.clone();
        let comet = comets.iter().find(|c| c.name.contains("Hale-Bopp")).expect("in the catalog");
        let time = Instant::parse("1997-03-31T19:00:00Z").expect("a time");
        let mut request = ViewRequest::of(NaifId::SUN, time);
        (request.position, request.fov_deg) = (Position::Centre(NaifId::EARTH), Some(0.1));
        (request.width, request.height) = (720, 720);
        (request.layers.comets, request.layers.labels) = (true, true);
        let sight_of = |scene: &Scene| SmallBodySight {
            ephemeris: &ephemeris,
            position_km: scene.camera.position_km,
            velocity_km_s: scene.viewer_velocity_km_s,
            time,
        };
        let whole_sky = Scene::build(&catalog, &ephemeris, &request).expect("a scene");
        let direction = sight_of(&whole_sky).see(comet).expect("covered").apparent_km.normalize();
        request.look = Look::Along { direction, axes: Axes::Icrf };
        let scene = Scene::build(&catalog, &ephemeris, &request).expect("a scene");
        let sight = sight_of(&scene);
        let px = shown_px(&scene.camera, &sight, &scene.bodies, comet).expect("in the middle");
        let [head] = &scene.comets.heads[..] else { panic!("{} heads", scene.comets.heads.len()) };
        let head_px = scene.camera.pixel_from_clip(head.centre.truncate().as_dvec2());
        assert!(px.distance(head_px) < 0.1 && px.distance(DVec2::splat(360.0)) < 1.0, "{px} {head_px}");
        // Negative control.
        let at_rest = SmallBodySight { velocity_km_s: DVec3::ZERO, ..sight };
        assert!(shown_px(&scene.camera, &at_rest, &scene.bodies, comet).is_none_or(|px| px.distance(head_px) > 20.0));
        let texts = &scene.line_texts.as_ref().expect("a name").texts;
        let name = texts.iter().find(|text| text.text == "C/1995 O1 (Hale-Bopp)").unwrap_or_else(|| panic!("{texts:?}"));
        assert!(name.left_end_px.x > px.x && name.left_end_px.distance(px) < 20.0, "{name:?} {px}");
        // Without names of bodies there are none of comets.
        request.layers.labels = false;
        assert!(Scene::build(&catalog, &ephemeris, &request).expect("a scene").line_texts.is_none());
    }

    /// Hale-Bopp of magnitude -0.6, Wirtanen of 11.3 and Bennett of 30 within 33 degrees: named are those that the exposure shows, and the chosen one.
    #[test]
    fn comets_too_faint_for_the_exposure_have_no_name() {
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("the built-in kernel");
        let mut request = ViewRequest::of(NaifId::SUN, Instant::parse("1997-03-31T19:00:00Z").expect("a time"));
        (request.position, request.fov_deg, request.target) = (Position::Centre(NaifId::EARTH), Some(90.0), None);
        (request.look, request.up) = (Look::Along { direction: DVec3::new(0.637, 0.317, 0.702), axes: Axes::Icrf }, Up::Celestial);
        (request.width, request.height) = (720, 720);
        (request.layers.comets, request.layers.labels) = (true, true);
        let scene_at = |stops: f64| {
            let request = ViewRequest { exposure: ExposureRequest::Stops(stops), ..request.clone() };
            Scene::build(&catalog, &ephemeris, &request).expect("a scene")
        };
        // Limiting magnitudes of 6 and 15.
        for (stops, limit_mag, expected) in [(14.0, 6.0, [true, false, false]), (26.0, 15.0, [true, true, false])] {
            let scene = scene_at(stops);
            assert!((scene.limiting_magnitude() - limit_mag).abs() < 1.0, "{}", scene.limiting_magnitude());
            assert!(scene.comets.heads.len() >= 3, "{} heads", scene.comets.heads.len());
            let texts = &scene.line_texts.as_ref().expect("a name").texts;
            let is_named = ["Hale-Bopp", "Wirtanen", "Bennett"].map(|name| texts.iter().any(|text| text.text.contains(name)));
            assert_eq!(is_named, expected, "{stops} stops: {texts:?}");
        }
        let scene = scene_at(14.0);
        let sight = SmallBodySight {
            ephemeris: &ephemeris,
            position_km: scene.camera.position_km,
            velocity_km_s: scene.viewer_velocity_km_s,
            time: request.time,
        };
        let comets = catalog.small_bodies().comets.clone();
        let bennett = comets.iter().find(|c| c.name.contains("Bennett"));
        let limit_mag = scene.limiting_magnitude();
        let names = small_body_names(&scene.camera, &sight, &scene.bodies, &comets, limit_mag, bennett, 12.0);
        let names: Vec<&str> = names.iter().map(|name| name.text.as_str()).collect();
        assert_eq!(names, ["C/1995 O1 (Hale-Bopp)", "C/1969 Y1 (Bennett)"]);
    }
}
