//! Flights between bodies of the session's ephemeris: the first image of a flight equals the last one before it.

use crate::view::interface::{interface, session};
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::camera::Camera;
use orrery::scene::viewpoint::viewer;
use orrery::units::SPEED_OF_LIGHT_KM_S;
use orrery::view::app::body_positions::SessionPositions;
use orrery::view::app::view_state::{CameraPose, ViewState};
use orrery::view::app::viewer::Action;

/// Largest change of a position that the iteration for light time may cause.
const LIGHT_TIME_TOLERANCE_KM: f64 = 0.02;
/// Height of the image that the actions assume. A flight does not depend on it.
const IMAGE_HEIGHT_PX: f64 = 800.0;

fn camera(view: &ViewState) -> Camera {
    let session = session();
    let request = view.request(session.catalog(), session.ephemeris(), 160, 90).expect("a view");
    viewer(session.catalog(), session.ephemeris(), &request).expect("a camera").camera
}

/// Vector from the camera to a body's centre: to its true position if the camera is on the body's ground, otherwise to its apparent one, with light time.
fn seen_from_camera_km(body: NaifId, camera: &Camera, view: &ViewState, is_on_its_ground: bool) -> DVec3 {
    let ephemeris = session().ephemeris();
    let centre_km = if is_on_its_ground {
        ephemeris.state(body, NaifId::SOLAR_SYSTEM_BARYCENTER, view.time(), None).expect("a place").state.pos_km
    } else {
        ephemeris.light_time_position(body, camera.position_km, view.time()).expect("a place").0
    };
    centre_km - camera.position_km
}

/// Flights from each of seven bodies to each of the other six, from orbits and from the ground. Light takes up to hours between the bodies, in which they
/// move by up to half a million kilometres.
#[test]
fn a_flight_starts_where_the_camera_is() {
    // The Sun, the Earth, the Moon, Mars, Jupiter, Saturn and Pluto.
    let bodies = [10, 399, 301, 499, 599, 699, 999].map(NaifId);
    let places = SessionPositions(session());
    let mut jump_without_light_time_km: f64 = 0.0;
    for from in bodies {
        for to in bodies.into_iter().filter(|to| *to != from) {
            for from_ground in [false, true] {
                let mut viewer = interface(from, "2017-05-17T00:00:00Z").viewer;
                if from_ground {
                    let (latitude_deg, longitude_deg) = (40.0, 10.0);
                    viewer.view.camera_pose = CameraPose::Ground {
                        body: from,
                        latitude_deg,
                        longitude_deg,
                        height_km: 1.0,
                        azimuth_deg: 30.0,
                        altitude_deg: 5.0,
                    };
                }
                let before = camera(&viewer.view);
                let offset_before_km = seen_from_camera_km(from, &before, &viewer.view, from_ground);
                viewer.apply(Action::FlyTo(to), IMAGE_HEIGHT_PX, &places);
                assert!(viewer.is_flying());
                let after = camera(&viewer.view);
                // The body that the camera leaves keeps its place in the image. During a flight the camera is on no ground.
                let offset_after_km = seen_from_camera_km(from, &after, &viewer.view, false);
                let moved_km = (offset_after_km - offset_before_km).length();
                // The iteration for light time leaves an error of at most 6 metres, before and after.
                assert!(moved_km < LIGHT_TIME_TOLERANCE_KM, "{from:?} to {to:?}, from the ground: {from_ground}: {moved_km} km");
                // On the ground the camera follows the body's true position. It is as far from the apparent one as the body moves, at up to 50 km/s, in
                // the light time from its centre.
                let allowed_km = if from_ground { 50.0 * offset_before_km.length() / SPEED_OF_LIGHT_KM_S } else { LIGHT_TIME_TOLERANCE_KM };
                let step_km = (after.position_km - before.position_km).length();
                assert!(step_km < allowed_km, "{from:?} to {to:?}, from the ground: {from_ground}: {step_km} km");
                assert!(
                    (after.forward - before.forward).length() < 1e-3,
                    "{from:?} to {to:?}, from the ground: {from_ground}: the camera turns"
                );
                let CameraPose::Free { offset_km, .. } = viewer.view.camera_pose else { panic!("the camera must be in flight") };
                let state = session().ephemeris().state(to, NaifId::SOLAR_SYSTEM_BARYCENTER, viewer.view.time(), None).expect("a place");
                // Negative control: how far the camera would jump if the flight's offset were relative to the true position of the destination.
                jump_without_light_time_km = jump_without_light_time_km.max((state.state.pos_km + offset_km - before.position_km).length());
            }
        }
    }
    assert!(jump_without_light_time_km > 1e4, "without light time the camera would jump by {jump_without_light_time_km} km only");
}
