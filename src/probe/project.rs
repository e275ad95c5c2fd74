//! `project`: the pixel at which a body, a star or a direction is drawn in a view.
//!
//! In: `view`, `time` and `size` as in the query `pixel`; a body, a star or a direction. A star is named by its number in the Hipparcos catalog; its proper
//! motion, parallax and aberration are included. Right ascension and declination give an ICRF direction, to which aberration is applied, but no parallax. From
//! a camera above or beside a body, bodies have no aberration, as in the image ([`crate::scene::viewpoint::Viewer`]): the answers differ from apparent places
//! by v/c. Out: the pixel, counted from the upper left corner of the image, whether it is in the frame, and whether a body hides it. In a perspective image,
//! positions behind the camera are not in the frame; the pixel returned for them is that of the opposite direction. In the other projections, positions
//! outside the image have no pixel.

use super::pixel::{IMAGE_SIZE, TIME, VIEW, view_request};
use super::{ProbeError, Prober, QueryKind, alternative, optional, parse_fields};
use crate::catalog::NaifId;
use crate::ephemeris::apparent::aberrated;
use crate::scene::Scene;
use crate::scene::camera::Placement;
use crate::scene::camera::sphere::ImageProjection;
use crate::scene::composite::{Arrangement, CompositeFrames};
use crate::scene::request::{CameraFile, Composition, Projection, ViewRequest};
use crate::scene::sky::frames::unit_vector;
use crate::scene::sky::stars::StarPlacer;
use crate::scene::viewpoint::viewer;
use crate::wording::{echo_within, suggestion_or_list};
use glam::DVec3;
use serde::Deserialize;
use serde_json::{Value, json};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    view: CameraFile,
    time: Option<String>,
    size: Option<[u32; 2]>,
    projection: Option<String>,
    body: Option<String>,
    star: Option<String>,
    ra_deg: Option<f64>,
    dec_deg: Option<f64>,
}

pub(super) static KIND: QueryKind = QueryKind {
    name: "project",
    description: "the pixel at which a body, a star or a direction is drawn, whether it is in the frame and whether a body hides it",
    fields: &[
        VIEW,
        TIME,
        IMAGE_SIZE,
        optional("projection", "perspective, fisheye or equirectangular, as --projection takes it", "perspective"),
        alternative("body", "a body's name; its place has light time, and from the ground or centre of a body also aberration"),
        alternative("star", "a number of the Hipparcos catalog, as HIP 32349; always with aberration by the body's motion"),
        alternative("ra_deg", "right ascension in degrees, ICRF, with dec_deg"),
        alternative("dec_deg", "declination in degrees, ICRF, with ra_deg"),
    ],
    example: r#"{"q":"project","view":{"position":{"body":"earth","radii":[4,0,0]},"look":{"direction":[0.1,1,0]}},"time":"2024-04-08T18:17:16Z","star":"HIP 32349"}"#,
    answer,
};

/// The Hipparcos number in a name such as `HIP 32349`.
fn hip_number(text: &str) -> Option<u32> {
    let text = text.trim();
    let digits = text.get(..3).filter(|prefix| prefix.eq_ignore_ascii_case("hip")).map_or(text, |_| &text[3..]);
    digits.trim().parse().ok()
}

fn answer(prober: &Prober<'_>, query: Value) -> Result<Value, ProbeError> {
    let query: Fields = parse_fields(query)?;
    let request = view_request(prober, &query.view, query.time.as_deref(), query.size)?;
    let names = Projection::ALL.map(Projection::name);
    let requested = query.projection.as_deref().unwrap_or(Projection::Perspective.name());
    let projection = Projection::by_name(requested)
        .ok_or_else(|| format!("field `projection`: `{}`: {}", echo_within(requested, 40), suggestion_or_list(requested, &names)))?;
    let scene = prober.session.scene(&request).map_err(|e| e.to_string())?;
    let viewer = viewer(prober.catalog(), prober.ephemeris(), &request).map_err(|e| e.to_string())?;
    let (infinite_km, no_body) = (f64::INFINITY, None);
    let (direction, distance_km, queried_body) = match (&query.body, &query.star, query.ra_deg, query.dec_deg) {
        (Some(name), None, None, None) => {
            let id = prober.catalog().body_named(name).map_err(|e| format!("field `body`: {e}"))?.id;
            let body = scene.body(id).filter(|b| b.placement.centre_km.is_finite());
            let body = body.ok_or_else(|| format!("field `body`: {name} cannot be placed at this time"))?;
            (body.placement.centre_km, body.distance_km, Some(id))
        }
        (None, Some(name), None, None) => {
            let stars = prober.catalog().stars();
            let star = hip_number(name).and_then(|n| stars.star_of_hip(n));
            let star =
                star.ok_or_else(|| format!("field `star`: no star `{}` in the catalog; write HIP and a number", echo_within(name, 40)))?;
            (StarPlacer::of(prober.catalog(), &viewer, &request).place(star).direction, infinite_km, no_body)
        }
        (None, None, Some(ra_deg), Some(dec_deg)) if ra_deg.is_finite() && (-90.0..=90.0).contains(&dec_deg) => {
            (aberrated(unit_vector(ra_deg, dec_deg), viewer.sky_aberration_velocity_km_s), infinite_km, no_body)
        }
        (None, None, Some(_), Some(_)) => return Err("fields `ra_deg` and `dec_deg`: degrees; declination from -90 to 90".into()),
        _ => return Err("give one of `body`, `star`, or `ra_deg` with `dec_deg`".into()),
    };
    let hidden = is_hidden(&scene, direction, distance_km, queried_body);
    if projection != Projection::Perspective {
        let composition = Composition { projection, ..Composition::default() };
        let composed = ViewRequest { composition, ..request };
        let frames = CompositeFrames::of(prober.catalog(), prober.ephemeris(), &composed).map_err(|e| e.to_string())?;
        let Arrangement::Faces(faces) = frames.arrangement else { return Err("the projection has no image".into()) };
        let pixel = faces.image.pixel_of(direction);
        let [x, y] = pixel.map_or([Value::Null, Value::Null], |pixel| [pixel.x.into(), pixel.y.into()]);
        return Ok(json!({ "x": x, "y": y, "in_frame": pixel.is_some(), "hidden": hidden }));
    }
    let camera = &scene.camera;
    let clip_in_front = camera.clip(direction);
    let pixel = clip_in_front.or_else(|| camera.clip(-direction)).map(|clip| camera.pixel_from_clip(clip));
    let in_frame = clip_in_front.is_some_and(|clip| clip.abs().max_element() <= 1.0);
    let [x, y] = pixel.map_or([Value::Null, Value::Null], |pixel| [pixel.x.into(), pixel.y.into()]);
    Ok(json!({ "x": x, "y": y, "in_frame": in_frame, "hidden": hidden }))
}

/// Whether a body other than `queried_body` hides the position at this distance in a direction; `None`: any body may hide it.
fn is_hidden(scene: &Scene, direction: DVec3, distance_km: f64, queried_body: Option<NaifId>) -> bool {
    scene.bodies.iter().filter(|b| Some(b.id) != queried_body).any(|b| hides(&b.placement, direction, distance_km))
}

/// Whether a ray enters a body within a distance of the camera. A moon just behind a planet's limb is nearer than the planet's centre, but farther than
/// the planet's surface.
fn hides(placement: &Placement, direction: DVec3, distance_km: f64) -> bool {
    let entry_km = |unit: DVec3| ((unit - placement.camera_in_unit_sphere()) * placement.radii_km).length();
    !placement.camera_is_inside() && placement.surface_along(direction).is_some_and(|unit| entry_km(unit) < distance_km)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    /// A globe of 1000 km whose centre is 1500 km away: its limb is at an angle of asin(2/3) = 41.81 degrees from the centre, at a distance of 1118 km. The
    /// ray at 41.70 degrees enters it after 1500 cos(41.70) - sqrt(1000^2 - (1500 sin(41.70))^2) = 1054 km and leaves it after 1186 km.
    #[test]
    fn a_globe_hides_what_is_behind_its_surface_and_not_what_is_behind_its_centre_alone() {
        let globe = Placement { centre_km: DVec3::new(1500.0, 0.0, 0.0), body_from_icrf: DMat3::IDENTITY, radii_km: DVec3::splat(1000.0) };
        let at = |degrees: f64, distance_km: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            hides(&globe, DVec3::new(cos, sin, 0.0), distance_km)
        };
        assert!(at(41.70, 1200.0), "behind the limb, but nearer than the centre");
        assert!(at(41.70, 2000.0) && at(41.70, f64::INFINITY), "behind the centre");
        assert!(!at(41.70, 1050.0), "in front of the limb");
        assert!(!at(41.90, f64::INFINITY), "beside the limb");
        assert!(!at(180.0, f64::INFINITY), "behind the camera");
    }

    #[test]
    fn an_ellipsoid_hides_by_its_distance_in_kilometres() {
        let radii_km = DVec3::new(1000.0, 1000.0, 500.0);
        let globe = Placement { centre_km: DVec3::new(0.0, 0.0, 3000.0), body_from_icrf: DMat3::IDENTITY, radii_km };
        assert!(hides(&globe, DVec3::Z, 2501.0) && !hides(&globe, DVec3::Z, 2499.0));
    }
}
