//! A click on rings selects their planet, also in a gap between them and where the image does not show the globe; a moon in front of them wins. Dust too faint
//! to see and the sky beside the rings select nothing.

use crate::support::session::SESSION;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::labels::body_at;
use orrery::scene::request::{Axes, Composition, Layers, Look, Position, Projection, ViewRequest};
use orrery::time::Instant;

const SATURN: NaifId = NaifId(699);
const IAPETUS: NaifId = NaifId(608);

/// A view from a place relative to a body; without the layers of names, so that only discs and rings can be clicked on.
fn view(target: NaifId, offset_km: DVec3, axes: Axes) -> ViewRequest {
    ViewRequest {
        position: Position::Offset { body: target, offset_km, axes },
        fov_deg: Some(45.0),
        width: 512,
        height: 512,
        layers: Layers::NONE,
        ..ViewRequest::of(target, Instant::parse("2017-05-17T00:00:00Z").expect("a time"))
    }
}

fn scene(request: &ViewRequest) -> Scene {
    SESSION.scene(request).expect("a scene")
}

fn radius_km(body: NaifId) -> f64 {
    SESSION.catalog().body(body).expect("a body").radii_km.x
}

/// A place 8 radii from Saturn's centre, 20 degrees north of the rings' plane; body axes.
fn above_rings_km() -> DVec3 {
    let (sin, cos) = 20.0_f64.to_radians().sin_cos();
    DVec3::new(cos, 0.0, sin) * 8.0 * radius_km(SATURN)
}

/// The body that a click on a point selects, which is given relative to Saturn's centre in Saturn's axes.
fn clicked(scene: &Scene, point_km: DVec3) -> Option<NaifId> {
    let saturn = scene.body(SATURN).expect("Saturn").placement;
    let direction = saturn.centre_km + saturn.body_from_icrf.transpose() * point_km;
    let pixel = scene.geometry.pixel_of(&scene.camera, direction).expect("in front of the camera");
    let size = DVec2::new(f64::from(scene.camera.width), f64::from(scene.camera.height));
    assert!(pixel.cmpge(DVec2::ZERO).all() && pixel.cmple(size).all(), "{point_km} is outside the image: {pixel}");
    body_at(&[], scene, SESSION.catalog(), pixel)
}

#[test]
fn a_click_on_rings_selects_their_planet() {
    let request = view(SATURN, above_rings_km(), Axes::BodyFixed);
    let shown = scene(&request);
    let without_rings = scene(&ViewRequest { effects: EffectOverrides::parse("-rings").expect("effects"), ..request.clone() });
    let whole_sphere = ViewRequest {
        composition: Composition { projection: Projection::Equirectangular, ..Composition::default() },
        width: 512,
        height: 256,
        fov_deg: None,
        ..request.clone()
    };
    let sampling = SamplingQuality { samples: 1, anisotropy: 1 };
    let whole_sphere = SESSION.draw(&whole_sphere, sampling, FrameImages::Display).expect("drawn").scene;
    // Beside the globe; from the C ring to the A ring, also in the Cassini Division and in the Encke gap (133 589 km).
    for y_km in [80_000.0, 110_000.0, 119_000.0, 130_000.0, 133_589.0, -110_000.0] {
        let point_km = DVec3::new(0.0, y_km, 0.0);
        assert_eq!(clicked(&shown, point_km), Some(SATURN), "{y_km} km");
        assert_eq!(clicked(&whole_sphere, point_km), Some(SATURN), "{y_km} km in a whole-sphere image");
        assert_eq!(clicked(&without_rings, point_km), None, "{y_km} km without rings");
    }
    // The sky inside the C ring, outside the F ring, and in the dust of the E ring.
    for y_km in [66_000.0, 145_000.0, 190_000.0] {
        assert_eq!(clicked(&shown, DVec3::new(0.0, y_km, 0.0)), None, "{y_km} km");
    }
}

#[test]
fn rings_are_clicked_on_where_the_image_does_not_show_the_globe() {
    let towards = DVec3::new(0.0, 110_000.0, 0.0) - above_rings_km();
    let look = Look::Along { direction: towards, axes: Axes::BodyFixed };
    let beside = scene(&ViewRequest { look, fov_deg: Some(5.0), ..view(SATURN, above_rings_km(), Axes::BodyFixed) });
    assert_eq!(clicked(&beside, DVec3::new(0.0, 110_000.0, 0.0)), Some(SATURN));
}

/// Iapetus in front of one ansa of the rings, 60 of its radii away; at the other ansa nothing is in front of them.
#[test]
fn a_moon_in_front_of_the_rings_wins() {
    let shown = scene(&view(SATURN, above_rings_km(), Axes::BodyFixed));
    let [saturn, iapetus] = [SATURN, IAPETUS].map(|id| shown.body(id).expect("a body").placement);
    let to_iapetus = saturn.body_from_icrf * (iapetus.centre_km - saturn.centre_km);
    let ansa = DVec3::Z.cross(to_iapetus).normalize() * 110_000.0;
    let away_km = (to_iapetus - ansa).normalize() * 60.0 * radius_km(IAPETUS);
    let offset_km = saturn.body_from_icrf.transpose() * away_km;
    let behind_iapetus = scene(&ViewRequest { fov_deg: Some(20.0), ..view(IAPETUS, offset_km, Axes::Icrf) });
    assert_eq!(clicked(&behind_iapetus, ansa), Some(IAPETUS));
    assert_eq!(clicked(&behind_iapetus, -ansa), Some(SATURN));
}
