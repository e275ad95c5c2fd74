//! Tests of the viewer with bodies on a line.

use super::*;
use crate::view::app::view_state::MIN_FOV_DEG;

/// The Sun at the origin, the other bodies on the x axis. All bodies have the same orientation and rotate about z at 1e-4 rad/s.
struct CollinearBodies;

impl BodyPositions for CollinearBodies {
    fn geometric_vector_km(&self, from: NaifId, to: NaifId, _: Instant) -> Option<DVec3> {
        // The body's x coordinate.
        let x_km = |id: NaifId| match id {
            NaifId::SUN | HUGE => Some(0.0),
            NaifId::EARTH => Some(1.5e8),
            NaifId::MOON => Some(1.5e8 + 4e5),
            SATURN => Some(1.4e9),
            _ => None,
        };
        Some(DVec3::new(x_km(to)? - x_km(from)?, 0.0, 0.0))
    }
    /// Light time is ignored.
    fn free_camera_offset_km(&self, body: NaifId, camera_body: NaifId, offset_km: DVec3, time: Instant) -> Option<DVec3> {
        Some(self.geometric_vector_km(body, camera_body, time)? + offset_km)
    }
    fn body_from_icrf(&self, _: NaifId, time: Instant) -> Option<DMat3> {
        Some(DMat3::from_rotation_z(-time.tdb_seconds_past_j2000() * 1e-4))
    }
}

const SATURN: NaifId = NaifId(699);
/// An invented body at the Sun's place, which one test adds; its radius exceeds its distance from the Earth.
const HUGE: NaifId = NaifId(5);

fn viewer() -> Viewer {
    let body = |id, name: &str, radius_km| SelectableBody {
        id,
        name: name.into(),
        aliases: Vec::new(),
        kind: BodyKind::Planet,
        parent: Some(NaifId::SUN),
        radii_km: DVec3::splat(radius_km),
    };
    let bodies = vec![
        body(NaifId::SUN, "Sun", 695_700.0),
        body(NaifId::EARTH, "Earth", 6378.1),
        body(NaifId::MOON, "Moon", 1737.4),
        body(SATURN, "Saturn", 60_268.0),
    ];
    let start = Instant::from_tdb_seconds_past_j2000(0.0);
    let view = ViewState::around(NaifId::EARTH, DVec3::new(0.0, 20_000.0, 0.0), 6378.1, DVec3::Z, start);
    Viewer::new(bodies, view, || Instant::from_jd_tdb(2_460_000.5))
}

/// Height of the image in which the mouse moves.
const IMAGE_HEIGHT_PX: f64 = 800.0;

fn apply(viewer: &mut Viewer, action: Action) {
    viewer.apply(action, IMAGE_HEIGHT_PX, &CollinearBodies);
}

#[test]
fn a_flight_ends_at_the_lit_side_and_back_returns() {
    let mut viewer = viewer();
    let start = viewer.view.clone();
    apply(&mut viewer, Action::FlyTo(SATURN));
    assert!(viewer.is_flying() && viewer.is_animating());
    viewer.advance(0.5);
    assert!(matches!(viewer.view.camera_pose, CameraPose::Free { body: SATURN, .. }));
    for _ in 0..20 {
        viewer.advance(0.2);
    }
    assert!(!viewer.is_flying());
    let CameraPose::Orbit { body, distance_radii, .. } = viewer.view.camera_pose else { panic!("{:?}", viewer.view.camera_pose) };
    assert_eq!((body, viewer.view.target, viewer.selected), (SATURN, SATURN, SATURN));
    assert!((distance_radii - ARRIVAL_RADII).abs() < 1e-9);
    let pose = viewer.pose_relative_to(SATURN, &CollinearBodies).expect("a pose");
    let to_sun = DVec3::NEG_X;
    assert!(crate::ephemeris::angle_rad(pose.offset_km, to_sun).to_degrees() < 45.0, "the camera is on the lit side");
    apply(&mut viewer, Action::PreviousView);
    assert_eq!((viewer.view.camera_pose, viewer.view.target), (start.camera_pose, start.target));
    apply(&mut viewer, Action::NextView);
    assert_eq!(viewer.view.target, SATURN);
    assert!(!viewer.has_next_view() && viewer.has_previous_view());
}

#[test]
fn a_drag_ends_a_flight() {
    let mut viewer = viewer();
    apply(&mut viewer, Action::FlyTo(NaifId::MOON));
    viewer.advance(0.1);
    apply(&mut viewer, Action::Turn(10.0, 0.0));
    assert!(!viewer.is_flying() && matches!(viewer.view.camera_pose, CameraPose::Orbit { body: NaifId::MOON, .. }));
}

/// What the user changes during a flight lasts, and the views that are shared and remembered have it.
#[test]
fn changes_during_a_flight_last() {
    let mut viewer = viewer();
    apply(&mut viewer, Action::TogglePause);
    apply(&mut viewer, Action::FlyTo(SATURN));
    viewer.advance(0.5);
    (viewer.view.orbits, viewer.view.exposure_stops) = (true, Some(3.0));
    apply(&mut viewer, Action::SetTime(Instant::from_tdb_seconds_past_j2000(5e7)));
    apply(&mut viewer, Action::ChangeFov(2.0));
    let fov_deg = viewer.view.fov_deg;
    assert!(viewer.is_flying() && fov_deg < DEFAULT_FOV_DEG);
    let shared = viewer.shareable_view();
    viewer.advance(3.0);
    assert!(!viewer.is_flying());
    let arrived = viewer.shareable_view();
    apply(&mut viewer, Action::LookFrom(NaifId::EARTH));
    apply(&mut viewer, Action::PreviousView);
    for view in [&shared, &arrived, &viewer.view] {
        assert_eq!((view.orbits, view.exposure_stops, view.tdb_s), (true, Some(3.0), 5e7));
        assert_eq!((view.fov_deg, view.target), (fov_deg, SATURN));
        assert!(matches!(view.camera_pose, CameraPose::Orbit { body: SATURN, .. }), "{:?}", view.camera_pose);
    }
    // A pose in flight has its own roll, so a roll ends the flight, as a drag does.
    apply(&mut viewer, Action::FlyTo(SATURN));
    viewer.advance(0.5);
    assert!(viewer.is_flying());
    apply(&mut viewer, Action::Roll(5.0));
    assert!(!viewer.is_flying() && viewer.view.roll_deg == 5.0, "{:?}", viewer.view);
}

/// From another body's centre the disc and its surroundings are in the image: here the Earth is 1.8 degrees wide from the Moon. A body around the camera has
/// the greatest field of view.
#[test]
fn a_body_seen_from_another_fits_the_image() {
    for (target, from, fov_deg) in [
        (SATURN, NaifId::EARTH, MIN_LOOK_FROM_FOV_DEG..=MIN_LOOK_FROM_FOV_DEG),
        (NaifId::EARTH, NaifId::MOON, 2.5..=5.0),
        (HUGE, NaifId::EARTH, MAX_FOV_DEG..=MAX_FOV_DEG),
    ] {
        let mut viewer = viewer();
        let huge = SelectableBody { id: HUGE, radii_km: DVec3::splat(1e9), ..viewer.selectable_bodies[0].clone() };
        viewer.selectable_bodies.push(huge);
        viewer.selected = target;
        apply(&mut viewer, Action::LookFrom(from));
        assert!(fov_deg.contains(&viewer.view.fov_deg), "{target:?} from {from:?}: {}", viewer.view.fov_deg);
        assert_eq!(viewer.view.camera_pose, CameraPose::Centre { body: from });
    }
}

/// *Look at* ends a flight at its destination, and then faces the body. It also does so if the camera has turned away from the body that it orbits.
#[test]
fn look_at_faces_the_body() {
    let faces = |viewer: &Viewer, id: NaifId| {
        let camera_body = viewer.view.camera_pose.body();
        let pose = viewer.pose_relative_to(camera_body, &CollinearBodies).expect("a pose");
        let body_km = CollinearBodies.geometric_vector_km(camera_body, id, viewer.view.time()).expect("a body");
        pose.forward.distance((body_km - pose.offset_km).normalize()) < 1e-9
    };
    let mut viewer = viewer();
    apply(&mut viewer, Action::FlyTo(SATURN));
    viewer.advance(0.3);
    apply(&mut viewer, Action::LookAt(NaifId::EARTH));
    assert!(
        matches!(viewer.view.camera_pose, CameraPose::Orbit { body: SATURN, .. }) && faces(&viewer, NaifId::EARTH),
        "{:?}",
        viewer.view
    );
    let mut viewer = self::viewer();
    apply(&mut viewer, Action::LookAround(400.0, 100.0));
    assert!(!faces(&viewer, NaifId::EARTH));
    apply(&mut viewer, Action::LookAt(NaifId::EARTH));
    assert!(faces(&viewer, NaifId::EARTH), "{:?}", viewer.view);
    // From its own centre a body cannot be seen.
    let mut viewer = self::viewer();
    viewer.selected = NaifId::MOON;
    apply(&mut viewer, Action::LookFrom(NaifId::EARTH));
    apply(&mut viewer, Action::LookAt(NaifId::EARTH));
    assert_eq!(viewer.view.target, NaifId::MOON);
}

/// In the middle of a camera path of a tour the pose is free. The first motion changes it to an orbit with the same image.
#[test]
fn motions_continue_from_a_free_pose() {
    // Each motion is paired with whether it keeps the image.
    let zero_motions =
        [Action::Turn(0.0, 0.0), Action::LookAround(0.0, 0.0), Action::Roll(0.0), Action::Zoom(0.0)].map(|action| (action, true));
    let motions = [
        Action::Turn(30.0, 10.0),
        Action::LookAround(30.0, 10.0),
        Action::Roll(5.0),
        Action::Zoom(1.0),
        Action::FaceBody,
        Action::LookAt(NaifId::MOON),
    ];
    for (action, keeps_image) in zero_motions.into_iter().chain(motions.map(|action| (action, false))) {
        let mut viewer = viewer();
        viewer.view.tdb_s = 4321.0;
        let offset_km = DVec3::new(9000.0, 20_000.0, -7000.0);
        let forward = DVec3::new(-0.4, -0.8, 0.6).normalize();
        let up = forward.cross(DVec3::new(0.3, 0.1, 0.9)).normalize();
        viewer.view.camera_pose = CameraPose::Free { body: NaifId::EARTH, offset_km, forward, up };
        viewer.view.tracks = false;
        apply(&mut viewer, action.clone());
        assert!(matches!(viewer.view.camera_pose, CameraPose::Orbit { body: NaifId::EARTH, .. }), "{action:?}");
        let pose = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
        // The offset is about 2e4 km long, so that the first term is relative, like the other two.
        let change = pose.offset_km.distance(offset_km) / 2e4 + pose.forward.distance(forward) + pose.up.distance(up);
        assert!((change < 1e-9) == keeps_image, "{action:?}: {change} {pose:?}");
    }
}

/// Near the ground of a flattened body, closer to its centre than the equatorial radius, there is no orbit: the camera stays where it is, above the ground.
#[test]
fn a_free_pose_near_flattened_ground_stays_in_place() {
    for (radii_km, height_km) in [
        (DVec3::new(6378.1, 6378.1, 6356.8), 0.003),
        (DVec3::new(6378.1, 6370.0, 6356.8), 2.0),
        (DVec3::new(60_268.0, 60_268.0, 54_364.0), 900.0),
    ] {
        for latitude_deg in [-90.0, -70.0, 55.0, 80.0] {
            for action in [Action::Turn(0.0, 0.0), Action::LookAround(0.0, 0.0), Action::Roll(0.0)] {
                let mut viewer = viewer();
                viewer.view.tdb_s = 4321.0;
                viewer.selectable_bodies[1].radii_km = radii_km;
                let icrf_from_body = CollinearBodies.body_from_icrf(NaifId::EARTH, viewer.view.time()).expect("an orientation").transpose();
                let (point_km, normal) = ground_point_km(radii_km, latitude_deg, 130.0, height_km);
                let offset_km = icrf_from_body * point_km;
                assert!(offset_km.length() < radii_km.x, "an orbit is possible");
                let forward = icrf_from_body * (normal.any_orthonormal_vector() - 0.3 * normal).normalize();
                let up = forward.cross(DVec3::new(0.3, 0.1, 0.9)).normalize();
                viewer.view.camera_pose = CameraPose::Free { body: NaifId::EARTH, offset_km, forward, up };
                viewer.view.tracks = false;
                apply(&mut viewer, action.clone());
                assert!(
                    matches!(viewer.view.camera_pose, CameraPose::Ground { body: NaifId::EARTH, .. }),
                    "{action:?}: {:?}",
                    viewer.view.camera_pose
                );
                let pose = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
                let moved_km = pose.offset_km.distance(offset_km);
                let turned = pose.forward.distance(forward) + pose.up.distance(up);
                assert!(moved_km < 1e-6 && turned < 1e-6, "{radii_km}, {latitude_deg}, {action:?}: {moved_km} km, {turned}");
            }
        }
    }
}

#[test]
fn changing_the_frame_keeps_the_camera_in_place() {
    let mut viewer = viewer();
    viewer.view.tdb_s = 4321.0;
    apply(&mut viewer, Action::Turn(133.0, 57.0));
    let before = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
    apply(&mut viewer, Action::RotateWithBody(true));
    let after = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
    assert!((before.offset_km - after.offset_km).length() < 1e-6 * before.offset_km.length());
    // In 1000 s the body has turned by 0.1 rad, and the camera with it.
    viewer.view.tdb_s += 1000.0;
    let later = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
    let error_km = (DMat3::from_rotation_z(0.1) * after.offset_km - later.offset_km).length();
    assert!(error_km < 1e-6 * before.offset_km.length(), "{error_km}");
}

#[test]
fn changing_the_frame_keeps_the_direction_of_view() {
    let mut viewer = viewer();
    if let CameraPose::Orbit { yaw_deg, pitch_deg, .. } = &mut viewer.view.camera_pose {
        (*yaw_deg, *pitch_deg) = (60.0, -10.0);
    }
    let before = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
    let towards_earth = -before.offset_km.normalize();
    assert!(before.forward.dot(towards_earth) < 0.6, "the camera has turned away from the Earth");
    for make_body_fixed in [true, false] {
        apply(&mut viewer, Action::RotateWithBody(make_body_fixed));
        let after = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
        assert!(before.forward.distance(after.forward) < 1e-9 && before.up.distance(after.up) < 1e-9, "{make_body_fixed}: {after:?}");
    }
}

/// A flight starts with the direction of view that the last image had: here from an orbit about the Earth whose camera tracks the Moon.
#[test]
fn a_flight_starts_in_the_direction_of_the_tracked_body() {
    let mut viewer = viewer();
    apply(&mut viewer, Action::LookAt(NaifId::MOON));
    assert!(viewer.view.tracks && viewer.view.camera_pose.body() == NaifId::EARTH);
    let pose = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
    let moon_km = CollinearBodies.geometric_vector_km(NaifId::EARTH, NaifId::MOON, viewer.view.time()).expect("the Moon");
    assert!(pose.forward.distance((moon_km - pose.offset_km).normalize()) < 1e-9, "{pose:?}");
    // With a roll and without tracking, the image's up direction is rolled.
    let mut rolled = self::viewer();
    let level = rolled.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
    rolled.view.roll_deg = 90.0;
    let pose = rolled.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
    assert!(pose.up.dot(level.up).abs() < 1e-9 && pose.forward.distance(level.forward) < 1e-9, "{pose:?}");
}

#[test]
fn matching_bodies_begin_with_names_that_start_with_the_text() {
    let viewer = viewer();
    let found = |text: &str| viewer.matching_bodies(text, 5).iter().map(|s| s.name.clone()).collect::<Vec<_>>();
    assert_eq!(found("s"), ["Sun", "Saturn"]);
    assert_eq!(found("RTH"), ["Earth"]);
    assert!(found(" ").is_empty() && found("planet nine").is_empty());
}

#[test]
fn time_can_be_stepped_run_set_to_now_and_paused() {
    let mut viewer = viewer();
    apply(&mut viewer, Action::Step(-60.0));
    assert_eq!(viewer.view.tdb_s, -60.0);
    // The second of the preset speeds is 10 scene seconds per real second.
    apply(&mut viewer, Action::Faster);
    viewer.advance(0.1);
    assert!((viewer.view.tdb_s + 59.0).abs() < 1e-9);
    apply(&mut viewer, Action::Now);
    assert!((viewer.view.time().jd_tdb() - 2_460_000.5).abs() < 1e-9);
    assert_eq!(viewer.frame_interval_s(), Some(1.0));
    apply(&mut viewer, Action::TogglePause);
    assert_eq!(viewer.frame_interval_s(), None);
}

#[test]
fn on_the_ground_drags_look_around_and_zoom_changes_the_field_of_view() {
    let mut viewer = viewer();
    apply(&mut viewer, Action::StandOn(95.0, 190.0));
    let CameraPose::Ground { latitude_deg, longitude_deg, azimuth_deg, .. } = viewer.view.camera_pose else {
        panic!("{:?}", viewer.view.camera_pose)
    };
    assert_eq!((latitude_deg, longitude_deg, azimuth_deg), (90.0, -170.0, 180.0));
    let fov_deg = viewer.view.fov_deg;
    apply(&mut viewer, Action::Zoom(3.0));
    assert!(viewer.view.fov_deg < fov_deg);
    apply(&mut viewer, Action::Turn(80.0, 0.0));
    let CameraPose::Ground { azimuth_deg, .. } = viewer.view.camera_pose else { panic!("{:?}", viewer.view.camera_pose) };
    assert!(azimuth_deg < 180.0);
}

/// On the ground, the stored angles are not the direction of an image that tracks a body. A drag and the end of tracking start from that direction.
#[test]
fn on_the_ground_the_view_stays_where_it_was_when_tracking_ends() {
    for (action, largest_deg) in [(Action::Turn(1.0, 0.0), 1.0), (Action::LookAround(0.0, 1.0), 1.0), (Action::Track(false), 1e-6)] {
        let mut viewer = viewer();
        viewer.view.tdb_s = 5000.0;
        apply(&mut viewer, Action::StandOn(10.0, 20.0));
        apply(&mut viewer, Action::LookAt(NaifId::SUN));
        viewer.view.roll_deg = 30.0;
        let before = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
        assert!(before.forward.distance(DVec3::NEG_X) < 1e-3, "the camera tracks the Sun: {before:?}");
        apply(&mut viewer, action.clone());
        let after = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
        let turned_deg = crate::ephemeris::angle_rad(before.forward, after.forward).to_degrees();
        let rolled_deg = crate::ephemeris::angle_rad(before.up, after.up).to_degrees();
        assert!(turned_deg < largest_deg && rolled_deg < largest_deg, "{action:?}: {turned_deg} {rolled_deg}");
        let is_tracking = viewer.view.tracks && viewer.view.target != NaifId::EARTH;
        assert!(!is_tracking, "{action:?}");
        // The exposure favours the target.
        assert_eq!(viewer.view.target, NaifId::SUN, "{action:?}");
    }
}

/// In an orbit, in either frame, turning the camera away from the tracked body starts from the direction of the image, and moves the image.
#[test]
fn in_an_orbit_the_view_stays_where_it_was_when_tracking_ends() {
    for make_body_fixed in [false, true] {
        for (action, is_motion) in
            [(Action::LookAround(100.0, 40.0), true), (Action::LookAround(0.0, 0.0), false), (Action::Track(false), false)]
        {
            let mut viewer = viewer();
            viewer.view.tdb_s = 5000.0;
            apply(&mut viewer, Action::RotateWithBody(make_body_fixed));
            apply(&mut viewer, Action::LookAt(NaifId::MOON));
            let before = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
            apply(&mut viewer, action.clone());
            let after = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
            let turned = before.forward.distance(after.forward) + before.up.distance(after.up);
            assert!(if is_motion { turned > 0.05 } else { turned < 1e-9 }, "{action:?}, {make_body_fixed}: {turned}");
            assert_eq!((viewer.view.tracks, viewer.view.target), (false, NaifId::MOON), "{action:?}");
        }
    }
}

#[test]
fn zoom_on_the_ground_changes_the_angle_that_the_projection_shows() {
    use crate::scene::request::Projection;
    let mut viewer = viewer();
    apply(&mut viewer, Action::StandOn(10.0, 20.0));
    let before = viewer.view.fov_deg;
    viewer.view.composition.projection = Projection::Fisheye;
    apply(&mut viewer, Action::Zoom(3.0));
    assert!(viewer.view.composition.fisheye_deg < 180.0 && viewer.view.fov_deg == before);
    for (notches, angle_deg) in [(-1e4, 360.0), (1e4, 1.0)] {
        apply(&mut viewer, Action::ChangeFov(notches));
        assert_eq!((viewer.view.composition.fisheye_deg, viewer.view.image_fov_deg()), (angle_deg, angle_deg));
    }
    viewer.view.composition.projection = Projection::Equirectangular;
    apply(&mut viewer, Action::Zoom(3.0));
    assert_eq!((viewer.view.fov_deg, viewer.view.composition.fisheye_deg, viewer.view.image_fov_deg()), (before, 1.0, 180.0));
}

#[test]
fn extreme_zooms_keep_the_camera_finite() {
    let mut viewer = viewer();
    for notches in [1e4, -1e4, 5.0] {
        apply(&mut viewer, Action::Zoom(notches));
        apply(&mut viewer, Action::ChangeFov(notches));
        let pose = viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
        assert!(pose.offset_km.length() > 6378.1 && pose.offset_km.is_finite());
        assert!((MIN_FOV_DEG..=MAX_FOV_DEG).contains(&viewer.view.fov_deg));
    }
    apply(&mut viewer, Action::FlyTo(NaifId(12345)));
    apply(&mut viewer, Action::FlyAlongList(-3));
    assert!(viewer.selectable_body(viewer.selected).is_some());
}

/// A mirrored or rolled image follows the pointer, as a level one does: each drag of such an image has the effect of another drag of a level one. The key that
/// rolls clockwise does so in a mirrored image, too.
#[test]
fn drags_move_the_image_with_the_pointer_however_it_is_turned() {
    let angles_after = |is_mirrored: bool, roll_deg: f64, action: Action| {
        let mut viewer = viewer();
        (viewer.view.is_mirrored, viewer.view.roll_deg) = (is_mirrored, roll_deg);
        apply(&mut viewer, action);
        match viewer.view.camera_pose {
            CameraPose::Orbit { azimuth_deg, elevation_deg, yaw_deg, pitch_deg, .. } => [azimuth_deg, elevation_deg, yaw_deg, pitch_deg],
            pose => panic!("{pose:?}"),
        }
    };
    for motion in [Action::Turn as fn(f64, f64) -> Action, Action::LookAround] {
        for (is_mirrored, roll_deg, [right_px, down_px]) in
            [(true, 0.0, [-30.0, 10.0]), (false, 180.0, [-30.0, -10.0]), (false, 90.0, [10.0, -30.0]), (true, 90.0, [10.0, 30.0])]
        {
            let [found, expected, unturned] = [
                angles_after(is_mirrored, roll_deg, motion(30.0, 10.0)),
                angles_after(false, 0.0, motion(right_px, down_px)),
                angles_after(false, 0.0, motion(30.0, 10.0)),
            ];
            let largest_difference = |a: [f64; 4], b: [f64; 4]| (0..4).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
            assert!(largest_difference(found, expected) < 1e-9, "mirrored {is_mirrored}, roll {roll_deg}: {found:?}, not {expected:?}");
            assert!(largest_difference(found, unturned) > 0.1, "mirrored {is_mirrored}, roll {roll_deg}: {found:?}");
        }
    }
    let mut viewer = viewer();
    viewer.view.is_mirrored = true;
    apply(&mut viewer, Action::Roll(5.0));
    assert_eq!(viewer.view.roll_deg, 355.0);
}

/// *Look at* turns a rolled camera by the shortest way, so that its axis of rotation keeps its place in the image. The roll stayed, which is measured from the
/// pole of the orbited body before, and from celestial north after: the image turned. A level camera stays level.
#[test]
fn look_at_keeps_the_up_direction_of_a_rolled_image() {
    let mut viewer = viewer();
    if let CameraPose::Orbit { elevation_deg, .. } = &mut viewer.view.camera_pose {
        *elevation_deg = 50.0;
    }
    let pose = |viewer: &Viewer| viewer.pose_relative_to(NaifId::EARTH, &CollinearBodies).expect("a pose");
    let mut level = self::viewer();
    level.view = viewer.view.clone();
    apply(&mut level, Action::LookAt(NaifId::MOON));
    assert_eq!(level.view.roll_deg, 0.0);
    viewer.view.roll_deg = 70.0;
    let before = pose(&viewer);
    apply(&mut viewer, Action::LookAt(NaifId::MOON));
    let after = pose(&viewer);
    let axis = before.forward.cross(after.forward).normalize();
    let axis_in_image = |pose: &Pose| [pose.up.dot(axis), pose.forward.cross(pose.up).dot(axis)];
    let (from, to) = (axis_in_image(&before), axis_in_image(&after));
    assert!((from[0] - to[0]).abs() < 1e-9 && (from[1] - to[1]).abs() < 1e-9, "{from:?}, then {to:?}");
    assert!((viewer.view.roll_deg - 70.0).abs() > 5.0, "the same roll would do: {}", viewer.view.roll_deg);
    // Back at the Earth, the image is as it was.
    apply(&mut viewer, Action::LookAt(NaifId::EARTH));
    assert!((viewer.view.roll_deg - 70.0).abs() < 1e-6 && pose(&viewer).up.distance(before.up) < 1e-6, "{}", viewer.view.roll_deg);
}
