use super::*;

/// The Sun at the origin, bodies on the x axis, all with the same orientation.
struct CollinearBodies;

impl BodyPositions for CollinearBodies {
    fn between_km(&self, from: NaifId, to: NaifId, _: Instant) -> Option<DVec3> {
        let x = |id: NaifId| match id.0 {
            10 => Some(0.0),
            399 => Some(1.5e8),
            301 => Some(1.5e8 + 4e5),
            699 => Some(1.4e9),
            _ => None,
        };
        Some(DVec3::new(x(to)? - x(from)?, 0.0, 0.0))
    }
    /// This test ephemeris ignores light time.
    fn offset_from_km(&self, body: NaifId, camera_body: NaifId, offset_km: DVec3, time: Instant) -> Option<DVec3> {
        Some(self.between_km(body, camera_body, time)? + offset_km)
    }
    fn body_from_icrf(&self, _: NaifId, time: Instant) -> Option<DMat3> {
        Some(DMat3::from_rotation_z(-time.tdb_seconds_past_j2000() * 1e-4))
    }
}

const SATURN: NaifId = NaifId(699);

fn viewer() -> Viewer {
    let subject = |id, name: &str, radius_km| Subject {
        id,
        name: name.into(),
        aliases: Vec::new(),
        kind: BodyKind::Planet,
        parent: Some(NaifId::SUN),
        radii_km: DVec3::splat(radius_km),
    };
    let subjects = vec![
        subject(NaifId::SUN, "Sun", 695_700.0),
        subject(NaifId::EARTH, "Earth", 6378.1),
        subject(NaifId::MOON, "Moon", 1737.4),
        subject(SATURN, "Saturn", 60_268.0),
    ];
    let start = Instant::from_tdb_seconds_past_j2000(0.0);
    let view = ViewState::around(NaifId::EARTH, DVec3::new(0.0, 20_000.0, 0.0), 6378.1, DVec3::Z, start);
    Viewer::new(subjects, view, || Instant::from_jd_tdb(2_460_000.5))
}

fn apply(v: &mut Viewer, action: Action) {
    v.apply(action, 800.0, &CollinearBodies);
}

#[test]
fn a_flight_ends_at_the_lit_side_and_back_returns() {
    let mut v = viewer();
    let home = v.view.clone();
    apply(&mut v, Action::FlyTo(SATURN));
    assert!(v.is_flying() && v.is_animating());
    v.advance(0.5);
    assert!(matches!(v.view.eye, CameraPose::Free { body: SATURN, .. }));
    for _ in 0..20 {
        v.advance(0.2);
    }
    assert!(!v.is_flying());
    let CameraPose::Orbit { body, distance_radii, .. } = v.view.eye else { panic!("{:?}", v.view.eye) };
    assert_eq!((body, v.view.target, v.selected), (SATURN, SATURN, SATURN));
    assert!((distance_radii - ARRIVAL_RADII).abs() < 1e-9);
    let pose = v.pose_from(SATURN, &CollinearBodies).expect("a place");
    let to_sun = DVec3::NEG_X;
    assert!(crate::ephemeris::angle_rad(pose.offset_km, to_sun).to_degrees() < 45.0, "the camera is on the lit side");
    apply(&mut v, Action::PreviousView);
    assert_eq!((v.view.eye, v.view.target), (home.eye, home.target));
    apply(&mut v, Action::NextView);
    assert_eq!(v.view.target, SATURN);
    assert!(!v.has_next_view() && v.has_previous_view());
}

#[test]
fn a_drag_ends_a_flight() {
    let mut v = viewer();
    apply(&mut v, Action::FlyTo(NaifId::MOON));
    v.advance(0.1);
    apply(&mut v, Action::Turn(10.0, 0.0));
    assert!(!v.is_flying() && matches!(v.view.eye, CameraPose::Orbit { body: NaifId::MOON, .. }));
}

#[test]
fn changing_the_frame_keeps_the_camera_in_place() {
    let mut v = viewer();
    v.view.tdb_s = 4321.0;
    apply(&mut v, Action::Turn(133.0, 57.0));
    let before = v.pose_from(NaifId::EARTH, &CollinearBodies).expect("a place");
    apply(&mut v, Action::RotateWithBody(true));
    let after = v.pose_from(NaifId::EARTH, &CollinearBodies).expect("a place");
    assert!((before.offset_km - after.offset_km).length() < 1e-6 * before.offset_km.length());
    // Later the frame has rotated, and the camera with it.
    v.view.tdb_s += 1000.0;
    let later = v.pose_from(NaifId::EARTH, &CollinearBodies).expect("a place");
    let turned = (DMat3::from_rotation_z(0.1) * after.offset_km - later.offset_km).length();
    assert!(turned < 1e-6 * before.offset_km.length(), "{turned}");
}

#[test]
fn names_complete_from_their_beginning_first() {
    let v = viewer();
    let found = |text: &str| v.completions(text, 5).iter().map(|s| s.name.clone()).collect::<Vec<_>>();
    assert_eq!(found("s"), ["Sun", "Saturn"]);
    assert_eq!(found("RTH"), ["Earth"]);
    assert!(found(" ").is_empty() && found("planet nine").is_empty());
}

#[test]
fn time_can_be_stepped_set_and_run() {
    let mut v = viewer();
    apply(&mut v, Action::Step(-60.0));
    assert_eq!(v.view.tdb_s, -60.0);
    apply(&mut v, Action::Faster);
    v.advance(0.1);
    assert!((v.view.tdb_s + 59.0).abs() < 1e-9);
    apply(&mut v, Action::Now);
    assert!((v.view.time().jd_tdb() - 2_460_000.5).abs() < 1e-9);
    assert_eq!(v.frame_interval_s(), Some(1.0));
    apply(&mut v, Action::TogglePause);
    assert_eq!(v.frame_interval_s(), None);
}

#[test]
fn on_the_ground_drags_look_around_and_zoom_changes_the_field_of_view() {
    let mut v = viewer();
    apply(&mut v, Action::StandOn(95.0, 190.0));
    let CameraPose::Ground { latitude_deg, longitude_deg, azimuth_deg, .. } = v.view.eye else { panic!("{:?}", v.view.eye) };
    assert_eq!((latitude_deg, longitude_deg, azimuth_deg), (90.0, -170.0, 180.0));
    let fov = v.view.fov_deg;
    apply(&mut v, Action::Zoom(3.0));
    assert!(v.view.fov_deg < fov);
    apply(&mut v, Action::Turn(80.0, 0.0));
    let CameraPose::Ground { azimuth_deg, .. } = v.view.eye else { panic!("{:?}", v.view.eye) };
    assert!(azimuth_deg < 180.0);
}

#[test]
fn zoom_on_the_ground_changes_the_angle_that_the_projection_shows() {
    use crate::scene::request::Projection;
    let mut v = viewer();
    apply(&mut v, Action::StandOn(10.0, 20.0));
    let before = v.view.fov_deg;
    v.view.composition.projection = Projection::Fisheye;
    apply(&mut v, Action::Zoom(3.0));
    assert!(v.view.composition.fisheye_deg < 180.0 && v.view.fov_deg == before);
    for (notches, angle_deg) in [(-1e4, 360.0), (1e4, 1.0)] {
        apply(&mut v, Action::ChangeFov(notches));
        assert_eq!((v.view.composition.fisheye_deg, v.view.image_fov_deg()), (angle_deg, angle_deg));
    }
    v.view.composition.projection = Projection::Equirectangular;
    apply(&mut v, Action::Zoom(3.0));
    assert_eq!((v.view.fov_deg, v.view.composition.fisheye_deg, v.view.image_fov_deg()), (before, 1.0, 180.0));
}

#[test]
fn extreme_zooms_keep_the_camera_finite() {
    let mut v = viewer();
    for notches in [1e4, -1e4, 5.0] {
        apply(&mut v, Action::Zoom(notches));
        apply(&mut v, Action::ChangeFov(notches));
        let pose = v.pose_from(NaifId::EARTH, &CollinearBodies).expect("a place");
        assert!(pose.offset_km.length() > 6378.1 && pose.offset_km.is_finite());
        assert!((MIN_FOV_DEG..=MAX_FOV_DEG).contains(&v.view.fov_deg));
    }
    apply(&mut v, Action::FlyTo(NaifId(12345)));
    apply(&mut v, Action::SelectNext(-3));
    assert!(v.subject(v.selected).is_some());
}
