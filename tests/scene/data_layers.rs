//! Points of one's own data: read from a catalog's layer, on the right ground, at their times.

use crate::support::session::session_over;
use glam::DVec2;
use orrery::catalog::NaifId;
use orrery::ephemeris::topocentric::ground_point_km;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::marks::Dot;
use orrery::scene::request::{Layers, Position, ViewRequest};
use orrery::session::Session;
use orrery::time::Instant;
use std::path::Path;

const LAYER: &str =
    "[[layer]]\nname = \"quakes\"\nfile = \"quakes.csv\"\nbody = \"Earth\"\nfade_days = 2.0\ncolour = \"#ff0000\"\nsize_px = 12.0\n";

fn view(time: &str) -> ViewRequest {
    // Over Tohoku at noon of its longitude.
    let position = Position::Over { towards: Some(NaifId::SUN), distance_radii: Some(4.0) };
    ViewRequest { position, ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time")) }
}

fn with_tables(folder: &Path, layer: &str, table: &str) {
    std::fs::write(folder.join("layers.toml"), layer).expect("written");
    std::fs::write(folder.join("quakes.csv"), table).expect("written");
}

fn dots(session: &Session, request: &ViewRequest) -> (Scene, Vec<Dot>) {
    let scene = session.scene(request).expect("a scene");
    let dots = scene.labels.as_ref().map_or(Vec::new(), |l| l.dots.clone());
    (scene, dots)
}

/// A point appears at its time where the camera sees its ground, fades over its days, and never shows on the far side.
#[test]
fn points_appear_at_their_time_and_place_and_fade() {
    let folder = tempfile::tempdir().expect("a folder");
    with_tables(folder.path(), LAYER, "time,lat_deg,lon_deg\n2024-03-11T03:00:00Z,38.3,142.4\n2024-03-11T03:00:00Z,-38.3,-37.6\n");
    let (session, said) = session_over(folder.path());
    assert!(dots(&session, &view("2024-03-11T02:59:00Z")).1.is_empty(), "before its time");
    let mut last = 1.0;
    for hours in [0, 6, 12, 24, 36] {
        let request = ViewRequest {
            time: Instant::parse("2024-03-11T03:00:00Z").expect("a time").plus_seconds(3600.0 * f64::from(hours)),
            ..view("2024-03-11T03:00:00Z")
        };
        let (scene, dots) = dots(&session, &request);
        let earth = scene.body(NaifId::EARTH).expect("the Earth").placement;
        let ground = ground_point_km(earth.radii_km, 38.3, 142.4, 0.0).0 / earth.radii_km;
        match scene.camera.pixel_of_surface(&earth, ground) {
            Some(expected) => {
                assert_eq!(dots.len(), 1, "{hours} h: the other is on the far side");
                assert!(dots[0].centre_px.distance(expected) < 0.01, "{hours} h: {:?} for {expected}", dots[0]);
                let wanted = 0.9 * (1.0 - f64::from(hours) / 48.0);
                assert!((dots[0].opacity - wanted).abs() < 1e-6 && dots[0].opacity < last, "{hours} h: {}", dots[0].opacity);
                last = dots[0].opacity;
            }
            None => assert!(dots.iter().all(|d| d.centre_px.distance(DVec2::splat(512.0)) < 512.0)),
        }
    }
    let much_later = dots(&session, &view("2024-03-13T03:00:01Z")).1;
    assert!(much_later.is_empty(), "{much_later:?}");
    let off = ViewRequest { layers: Layers::parse("-data").expect("layers"), ..view("2024-03-11T03:00:00Z") };
    assert!(dots(&session, &off).1.is_empty());
    // In the picture: red where the point is.
    let request = view("2024-03-11T03:00:00Z");
    let drawn = session.draw(&request, SamplingQuality { samples: 1, anisotropy: 1 }, false).expect("drawn");
    let at = dots(&session, &request).1[0].centre_px;
    let pixel = drawn.frame.display[(at.y as usize) * 1024 + at.x as usize];
    assert!(pixel[0] > 200 && pixel[1] < 60 && pixel[2] < 60, "{pixel:?}");
    assert!(said.lock().expect("a list").is_empty());
}

/// What is wrong is said with file, line and field, and no session opens.
#[test]
fn wrong_layers_are_refused() {
    let refused = |layer: &str, table: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        with_tables(folder.path(), layer, table);
        let e = orrery::session::read_catalog(Some(folder.path())).map(|_| ()).expect_err("refused").to_string();
        e.replace(&folder.path().display().to_string(), "")
    };
    assert!(refused(LAYER, "lat,lon\n1,2\n91,3\n").contains("quakes.csv:3: field lat_deg: `91`"));
    assert!(refused(&LAYER.replace("Earth", "Earht"), "lat,lon\n1,2\n").contains("layers.toml:4: \"Earht\" is not the name of a body"));
    assert!(refused(&LAYER.replace("2.0", "-2.0"), "lat,lon\n1,2\n").contains("layers.toml:5"));
    assert!(refused(&LAYER.replace("quakes.csv", "none.csv"), "lat,lon\n1,2\n").contains("none.csv"));
}
