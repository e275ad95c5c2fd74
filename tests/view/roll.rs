//! The roll of the camera, which applies wherever the camera is and whatever it faces; drags where the camera cannot turn.

use crate::view::input::Window;
use crate::view::interface::{harness, interface, session, settle};
use egui::{Event, Modifiers, PointerButton};
use egui_kittest::kittest::{NodeT, Queryable};
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::ephemeris::angle_rad;
use orrery::scene::request::{Composition, Projection};
use orrery::scene::viewpoint::viewer;
use orrery::view::app::body_positions::SessionPositions;
use orrery::view::app::view_state::{CameraPose, ViewState};
use orrery::view::app::viewer::Action;

const TIME: &str = "2026-11-30T21:00:00Z";

/// Line of sight and up direction of the image of a view.
fn axes_in_image(view: &ViewState) -> [DVec3; 2] {
    let request = view.request(session().catalog(), session().ephemeris(), 300, 200).expect("a view");
    let camera = viewer(session().catalog(), session().ephemeris(), &request).expect("a camera").camera;
    [camera.forward, camera.up]
}

/// Every pose, each facing the Moon. On the ground and from an orbit the camera tracks it.
fn poses() -> [CameraPose; 5] {
    let (body, is_body_fixed, elevation_deg, yaw_deg, pitch_deg) = (NaifId::EARTH, false, 10.0, 0.0, 0.0);
    let orbit = |body, distance_radii| CameraPose::Orbit {
        body,
        is_body_fixed,
        azimuth_deg: 30.0,
        elevation_deg,
        distance_radii,
        yaw_deg,
        pitch_deg,
    };
    [
        CameraPose::Centre { body },
        CameraPose::Ground { body, latitude_deg: 50.0, longitude_deg: 10.0, height_km: 0.01, azimuth_deg: 0.0, altitude_deg: 0.0 },
        orbit(body, 3.0),
        CameraPose::Orbit { body, is_body_fixed: true, azimuth_deg: 30.0, elevation_deg, distance_radii: 3.0, yaw_deg, pitch_deg },
        orbit(NaifId::MOON, 5.0),
    ]
}

/// The roll was ignored whenever the camera followed another body, so the Moon could not be turned as a telescope shows it.
#[test]
fn the_roll_turns_the_image_in_every_pose() {
    let mut view = interface(NaifId::MOON, TIME).viewer.view;
    (view.target, view.tracks, view.fov_deg) = (NaifId::MOON, true, 0.6);
    for camera_pose in poses() {
        view.camera_pose = camera_pose;
        view.roll_deg = 0.0;
        let [forward, up] = axes_in_image(&view);
        for roll_deg in [180.0, 40.0, 300.0] {
            view.roll_deg = roll_deg;
            let [rolled_forward, rolled_up] = axes_in_image(&view);
            assert!(angle_rad(forward, rolled_forward) < 1e-7, "{camera_pose:?}: the line of sight moved");
            // A positive roll turns the image clockwise, so the camera counterclockwise: its up direction moves to the left.
            let right = forward.cross(up);
            let expected_up = up * roll_deg.to_radians().cos() - right * roll_deg.to_radians().sin();
            assert!(angle_rad(rolled_up, expected_up) < 1e-7, "{camera_pose:?}, roll {roll_deg}: {rolled_up} instead of {expected_up}");
        }
    }
}

/// The roll stays when the camera stops following: the image stays where it is. From an orbit about Mars, whose pole is 37 degrees from celestial north, the
/// stored roll then changes, and changes back when the camera follows again, by the switch or by *Look at*.
#[test]
fn the_rolled_image_stays_when_tracking_ends_and_begins() {
    let of_mars = CameraPose::Orbit {
        body: NaifId(499),
        is_body_fixed: false,
        azimuth_deg: 30.0,
        elevation_deg: 10.0,
        distance_radii: 3.0,
        yaw_deg: 0.0,
        pitch_deg: 0.0,
    };
    for camera_pose in poses()[1..4].iter().copied().chain([of_mars]) {
        for again in [Action::Track(true), Action::LookAt(NaifId::MOON)] {
            let mut viewer = interface(NaifId::MOON, TIME).viewer;
            (viewer.view.camera_pose, viewer.view.target, viewer.view.tracks, viewer.view.roll_deg) =
                (camera_pose, NaifId::MOON, true, 70.0);
            let before = axes_in_image(&viewer.view);
            // Without tracking the direction has no aberration: up to an arcminute.
            let turned_deg = |view: &ViewState| {
                let after = axes_in_image(view);
                [0, 1].map(|axis| angle_rad(before[axis], after[axis]).to_degrees())
            };
            for (action, tracks) in [(Action::Track(false), false), (again, true)] {
                viewer.apply(action.clone(), 600.0, &SessionPositions(session()));
                let turned_deg = turned_deg(&viewer.view);
                assert!(turned_deg.iter().all(|deg| *deg < 0.1), "{camera_pose:?}, {action:?}: turned by {turned_deg:?} degrees");
                assert_eq!(viewer.view.tracks, tracks);
            }
        }
    }
}

/// The least roll once tilted these images while the camera followed a body, and any altitude of the line of sight did while it followed none.
#[test]
fn whole_sphere_images_stay_level_and_domes_centred_on_the_zenith() {
    let mut view = interface(NaifId::MOON, TIME).viewer.view;
    let (latitude_deg, longitude_deg, height_km, azimuth_deg, altitude_deg) = (50.0, 10.0, 0.01, 0.0, 40.0);
    view.camera_pose = CameraPose::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg, height_km, azimuth_deg, altitude_deg };
    (view.target, view.tracks) = (NaifId::MOON, true);
    let up = |view: &ViewState| {
        let mut request = view.request(session().catalog(), session().ephemeris(), 300, 200).expect("a view");
        (request.composition, request.fov_deg) = (Composition::default(), None);
        viewer(session().catalog(), session().ephemeris(), &request).expect("a camera").up_hint.normalize()
    };
    let zenith = up(&view);
    for tracks in [true, false] {
        view.tracks = tracks;
        view.composition.projection = Projection::Perspective;
        assert!(zenith.dot(axes_in_image(&view)[0]).abs() > 1e-3, "the camera looks at the horizon");
        (view.composition.projection, view.composition.is_zenith_centred) = (Projection::Equirectangular, false);
        view.roll_deg = 1e-5;
        assert!(angle_rad(up(&view), zenith) < 1e-6, "follows: {tracks}");
        view.roll_deg = 90.0;
        assert!(angle_rad(up(&view), zenith) > 0.5, "follows: {tracks}");
        (view.composition.projection, view.composition.is_zenith_centred) = (Projection::Fisheye, true);
        assert!(angle_rad(up(&view), zenith) < 1e-7, "follows: {tracks}");
    }
}

fn drag(window: &mut Window, button: PointerButton) {
    let from = window.get_by_label_contains("The sky:").rect().center();
    let to = from + egui::vec2(60.0, 20.0);
    let press = |pos, pressed| Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE };
    window.hover_at(from);
    window.event(press(from, true));
    window.run_steps(1);
    window.hover_at(to);
    window.run_steps(2);
    window.event(press(to, false));
    window.run_steps(2);
}

/// A drag did nothing there, without a word, beside the hint *Drag to turn* and the choice *Follow target*.
#[test]
fn at_the_centre_of_a_body_a_drag_is_answered_and_a_middle_drag_rolls() {
    let mut state = interface(NaifId::MOON, TIME);
    (state.viewer.view.camera_pose, state.viewer.view.fov_deg) = (CameraPose::Centre { body: NaifId::EARTH }, 1.0);
    state.settings.hints_followed = orrery::view::app::settings::HintsFollowed::default();
    state.body_browser_shown = true;
    let mut window = harness(state);
    settle(&mut window);
    assert!(window.query_by_label("Drag to turn").is_none() && window.query_by_label("Scroll to zoom").is_some());
    assert!(window.get_by_label("Follow target").accesskit_node().is_disabled());
    for button in [PointerButton::Primary, PointerButton::Secondary] {
        window.state_mut().show_reply("");
        drag(&mut window, button);
        assert!(window.state().reply_text().starts_with("At the centre of a body"), "{button:?}: {}", window.state().reply_text());
    }
    assert_eq!(window.state().viewer.view.roll_deg, 0.0);
    drag(&mut window, PointerButton::Middle);
    assert!(window.state().viewer.view.roll_deg != 0.0);
    // Negative control: in an orbit.
    let mut orbiting = harness(interface(NaifId::MOON, TIME));
    settle(&mut orbiting);
    drag(&mut orbiting, PointerButton::Primary);
    assert_eq!(orbiting.state().reply_text(), "");
}
