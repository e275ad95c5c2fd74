//! Tours: camera paths between stops, of the built-in tours too; errors in tour files; playing, pausing, ending and recording in the window.

use crate::view::input::{Window, type_text, window_without_images};
use crate::view::interface::session;
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::request::{Quality, ToneMap};
use orrery::scene::viewpoint::viewer;
use orrery::time::Instant;
use orrery::view::app::tour::Tour;
use orrery::view::app::view_state::ViewState;
use orrery::view::panels::Tab;

fn parse(text: &str) -> Result<Tour, String> {
    Tour::parse(text, session(), Instant::parse("2024-01-01").expect("a time")).map_err(|e| e.to_string())
}

/// Vector from a body's centre to the camera in km, and the direction of view. The centre is the apparent one, with light time, except for a camera on
/// the ground of the body, for which it is the true one.
fn offset_and_forward(view: &ViewState, body: NaifId) -> (DVec3, DVec3) {
    let session = session();
    let request = view.request(session.catalog(), session.ephemeris(), 160, 90).expect("a view");
    let viewer = viewer(session.catalog(), session.ephemeris(), &request).expect("a camera");
    let camera = viewer.camera;
    let centre = match viewer.stands_on {
        Some(ground) if ground.id == body => ground.centre_km,
        _ => session.ephemeris().light_time_position(body, camera.position_km, view.time()).expect("a place").0,
    };
    (camera.position_km - centre, camera.forward)
}

/// Scenes of every built-in tour can be prepared at five times in each second. From image to image, at 25 per second, the camera turns and moves by
/// little, except at cuts.
#[test]
fn built_in_tours_are_smooth_from_end_to_end() {
    for (name, _, text) in orrery_catalogs::TOURS {
        let tour = parse(text).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(tour.title == *name && tour.stop_count() >= 3 && (20.0..180.0).contains(&tour.length_s()), "{name}: {} s", tour.length_s());
        let mut previous = tour.at(0.0);
        let mut frames = 0;
        // The camera of the last image for which it was computed: number of the image, body, and the camera relative to the body.
        let mut last = None;
        for k in 1..=(25.0 * tour.length_s()) as u32 {
            let now = tour.at(f64::from(k) / 25.0);
            // Preparing a scene takes most of the time.
            if k % 5 == 0 {
                let request = now.view.request(session().catalog(), session().ephemeris(), 16, 9).expect("a view");
                let scene = session().scene(&request);
                assert!(scene.is_ok(), "{name}, {} s: {}", f64::from(k) / 25.0, scene.err().map_or(String::new(), |e| e.to_string()));
            }
            let body = now.view.camera_pose.body();
            if now.is_changing && previous.is_changing && now.stop_index == previous.stop_index && !previous.view.tracks && !now.view.tracks
            {
                let (offset_before, forward_before) = last
                    .filter(|(of, _)| *of == (k - 1, body))
                    .map_or_else(|| offset_and_forward(&previous.view, body), |(_, camera)| camera);
                let (offset, forward) = offset_and_forward(&now.view, body);
                last = Some(((k, body), (offset, forward)));
                frames += 1;
                let log_ratio = (offset.length() / offset_before.length()).ln().abs();
                assert!(log_ratio < 0.2, "{name}, {} s: the distance changes by a factor of e^{log_ratio}", f64::from(k) / 25.0);
                let turned_deg = forward_before.cross(forward).length().atan2(forward_before.dot(forward)).to_degrees();
                assert!(turned_deg < 6.0, "{name}, {} s: the camera turns by {turned_deg} degrees", f64::from(k) / 25.0);
            }
            previous = now;
        }
        assert!(frames > 50, "{name}: {frames} images between stops");
    }
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_tour() {
    let (_, _, text) = orrery_catalogs::TOURS[0];
    let tour = parse(text).expect("a tour");
    assert_eq!(parse(&format!("\u{feff}{text}")), Ok(tour));
}

#[test]
fn a_camera_path_starts_and_ends_at_its_stops() {
    let stop = |view: &str| format!(r#"{{"view":"orrery://view?{view}","hold_s":2,"travel_s":3,"time_rate":100}}"#);
    let stops = [
        "target=Saturn&time=2017-05-17&eye.distance_radii=6",
        "target=Moon&time=2017-05-18&eye.distance_radii=3&fov_deg=10",
        "target=Sun&time=2017-05-18T12:00:00Z&eye.kind=ground&eye.body=Earth&eye.latitude_deg=50&eye.longitude_deg=10&fov_deg=2",
    ];
    let tour = parse(&format!(r#"{{"title":"T","stops":[{}]}}"#, stops.map(stop).join(","))).expect("a tour");
    // The first stop has no camera path.
    assert_eq!((tour.length_s(), tour.arrival_s(0), tour.arrival_s(1), tour.arrival_s(2)), (12.0, 0.0, 5.0, 10.0));
    for k in [1, 2] {
        let (starts_s, arrives_s) = (tour.arrival_s(k) - 3.0, tour.arrival_s(k));
        for at_s in [starts_s, arrives_s] {
            let (before, after) = (tour.at(at_s - 1e-7), tour.at(at_s + 1e-7));
            let body = tour.at(arrives_s).view.camera_pose.body();
            let (offset_before, forward_before) = offset_and_forward(&before.view, body);
            let (offset_after, forward_after) = offset_and_forward(&after.view, body);
            assert!(
                (offset_before - offset_after).length() < 1e-5 * offset_before.length(),
                "stop {k}, {at_s} s: {offset_before} {offset_after}"
            );
            // A view that tracks its target looks at the apparent position, a camera path at the one without aberration: 20 arcsec.
            assert!((forward_before - forward_after).length() < 2e-4, "stop {k}, {at_s} s: {forward_before} {forward_after}");
            // The path to the second stop passes a day in three seconds, at most twice that rate: 0.02 s between these views.
            assert!(
                (before.view.tdb_s - after.view.tdb_s).abs() < 0.1 && (before.view.fov_deg / after.view.fov_deg - 1.0).abs() < 1e-5,
                "stop {k}, {at_s} s"
            );
        }
        // Negative control: one second before the arrival the camera is elsewhere.
        let body = tour.at(arrives_s).view.camera_pose.body();
        let [earlier, arrived] = [arrives_s - 1.0, arrives_s].map(|at_s| offset_and_forward(&tour.at(at_s).view, body).0);
        assert!((earlier - arrived).length() > 1e-3 * arrived.length());
    }
    assert_eq!(tour.at(1e9), tour.at(12.0));
    assert!((tour.at(2.0).view.tdb_s - tour.at(0.0).view.tdb_s - 200.0).abs() < 1e-6);
}

/// The body around the camera is hidden only at the stop itself. A camera path to a body's centre or from it must therefore stay outside the body.
#[test]
fn a_camera_path_to_or_from_a_centre_stays_outside_the_body() {
    let stop = |view: &str| format!(r#"{{"view":"orrery://view?time=2024-01-01&{view}","hold_s":1,"travel_s":3}}"#);
    let [orbit, moon, jupiter] = [
        "target=Earth&eye.distance_radii=4",
        "target=Moon&eye.kind=centre&eye.body=Earth&fov_deg=1",
        "target=Jupiter&eye.kind=centre&eye.body=Earth&fov_deg=1",
    ]
    .map(stop);
    for stops in [[&orbit, &moon], [&moon, &orbit], [&moon, &jupiter]] {
        let tour = parse(&format!(r#"{{"title":"T","stops":[{},{}]}}"#, stops[0], stops[1])).expect("a tour");
        for k in 0..=50 {
            let view = tour.at(f64::from(k) * 0.1).view;
            let request = view.request(session().catalog(), session().ephemeris(), 16, 9).expect("a view");
            let scene = session().scene(&request);
            assert!(scene.is_ok(), "{stops:?} after {k} images: {}", scene.err().map_or(String::new(), |e| e.to_string()));
        }
    }
}

#[test]
fn a_tour_error_names_its_stop_and_field() {
    let with_second_stop = |fields: &str| format!(r#"{{"title":"T","stops":[{{"view":"orrery://view?target=Moon"}},{{{fields}}}]}}"#);
    let two_stops = |fields: &str| format!(r#"{{"title":"T","stops":[{{{fields}}},{{"view":"orrery://view?target=Moon"}}]}}"#);
    for (text, message_part) in [
        ("[".to_owned(), "not a tour"),
        (r#"{"title":"T","stops":[]}"#.to_owned(), "at least one stop"),
        (r#"{"stops":[]}"#.to_owned(), "title"),
        (with_second_stop(r#""text":"x""#), "view"),
        (with_second_stop(r#""view":"orrery://view?target=Nibiru""#), "stop 2, view: target: "),
        (with_second_stop(r#""view":{"target":399,"fov_deg":-1}"#), "stop 2, view: fov_deg"),
        (with_second_stop(r#""view":{"target":399,"target":599}"#), "field `target` is given twice"),
        (with_second_stop(r#""view":"orrery://view?target=Moon","hold_s":-1"#), "stop 2, hold_s"),
        (with_second_stop(r#""view":"orrery://view?target=Moon","travel_s":1e9"#), "stop 2, travel_s"),
        (with_second_stop(r#""view":"orrery://view?target=Moon","time_rate":1e99"#), "stop 2, time_rate"),
        (with_second_stop(r#""view":"orrery://view?target=Moon","holds":3"#), "holds"),
        // Times beyond the ephemeris: in the second stop, in the first, and at the end of the first only.
        (with_second_stop(r#""view":"orrery://view?target=Moon&tdb_s=1e12""#), "stop 2, view: "),
        (two_stops(r#""view":"orrery://view?target=Moon&tdb_s=1e12""#), "stop 1, view: "),
        (two_stops(r#""view":"orrery://view?target=Moon","hold_s":1000,"time_rate":1e9"#), "stop 1, time_rate: "),
        // At the end of the last, which no camera path leaves.
        (with_second_stop(r#""view":"orrery://view?target=Moon","hold_s":1000,"time_rate":1e9"#), "stop 2, time_rate: "),
    ] {
        let error = parse(&text).expect_err(&text);
        assert!(error.contains(message_part) && !error.contains('\n'), "{text}: {error}");
    }
    // A tour that is too long: the message names what takes most of the time, and both sums. The first stop has no camera path.
    for (stops, fields, message) in [
        (
            2,
            r#""hold_s":3600"#,
            "stop 2, hold_s: up to here the tour is longer than 3600 s: 7200.0 s of hold_s and 4.0 s of travel_s in 2 stops",
        ),
        (
            4,
            r#""hold_s":1,"travel_s":1500"#,
            "stop 4, travel_s: up to here the tour is longer than 3600 s: 4.0 s of hold_s and 4500.0 s of travel_s in 4 stops",
        ),
        (
            700,
            r#""travel_s":0"#,
            "stop 601, hold_s: up to here the tour is longer than 3600 s: 3606.0 s of hold_s and 0.0 s of travel_s in 601 stops",
        ),
    ] {
        let stop = format!(r#"{{"view":"orrery://view?target=Moon",{fields}}}"#);
        let long = format!(r#"{{"title":"T","stops":[{}]}}"#, vec![stop; stops].join(","));
        assert_eq!(parse(&long).expect_err("too long"), message);
    }
    let many = format!(r#"{{"title":"T","stops":[{}]}}"#, vec![r#"{"view":"orrery://view?target=Moon","hold_s":0}"#; 1001].join(","));
    assert_eq!(parse(&many).expect_err("too many stops"), "1001 stops; a tour has at most 1000");
}

/// At one frame per second, a recorded tour has as many frames as its length in seconds, rounded up.
#[test]
fn a_tour_is_recorded() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("tour.json");
    let stop = |link: &str| format!(r#"{{"view":"orrery://view?{link}","hold_s":2,"travel_s":1}}"#);
    let stops = [stop("target=Saturn&time=2017-05-17"), stop("target=Moon&time=2017-05-18&eye.distance_radii=3")];
    std::fs::write(&file, format!(r#"{{"title":"T","stops":[{}]}}"#, stops.join(","))).expect("a file");
    let length_s = parse(&std::fs::read_to_string(&file).expect("text")).expect("a tour").length_s();
    let mut window = window_without_images(NaifId(699));
    window.state_mut().tab = Some(Tab::Share);
    window.run_steps(2);
    window.get_by_label_contains("Animation file: .gif").set_text_value_accesskit(&folder.path().join("t.apng").display().to_string());
    window.run_steps(2);
    for (field, value) in [("Width of the animation, pixels", 12.0), ("Height of the animation, pixels", 8.0), ("Frames a second", 1.0)] {
        window.get_by_label(field).set_value_accesskit(value);
        window.run_steps(2);
    }
    window.state_mut().tab = Some(Tab::Moments);
    window.run_steps(2);
    window.get_by_role_and_label(egui::accesskit::Role::TextInput, "Tour file").set_text_value_accesskit(&file.display().to_string());
    window.run_steps(2);
    window.get_by_label("Open tour").click();
    window.run_steps(2);
    window.get_by_label("Record tour").click();
    window.run_steps(40);
    assert!(window.state().reply_text().starts_with("Saved ") && !window.state().is_saving(), "{}", window.state().reply_text());
    use image::AnimationDecoder;
    let bytes = std::io::Cursor::new(std::fs::read(folder.path().join("t.apng")).expect("a file"));
    let frames = image::codecs::png::PngDecoder::new(bytes).expect("a PNG").apng().expect("animated").into_frames().count();
    assert_eq!(frames as f64, length_s.ceil());
}

/// A click plays a tour; a change of the view pauses it and keeps the view; Escape ends it.
#[test]
fn a_tour_plays_in_the_window() {
    let mut window = window_without_images(NaifId(699));
    window.run_steps(2);
    window.state_mut().tab = Some(Tab::Moments);
    window.run_steps(2);
    let (name, _, text) = orrery_catalogs::TOURS[0];
    let tour = parse(text).expect("a tour");
    window.get_by_label(name).click();
    window.run_steps(2);
    assert!(window.query_by_label_contains(tour.text(0)).is_some(), "the first text is shown");
    assert_eq!(window.state().viewer.view.target, NaifId::EARTH);
    let quality = window.state().viewer.view.quality;
    window.get_by_label("Next").click();
    window.run_steps(2);
    assert!(window.query_by_label_contains(tour.text(1)).is_some());
    assert_eq!(window.state().viewer.view.quality, quality, "quality is the user's");
    // A change of the time pauses the tour.
    window.get_by_label("+d").click();
    window.run_steps(2);
    let shown_time = window.state().viewer.view.tdb_s;
    window.run_steps(5);
    assert!(window.query_by_label("Play tour").is_some() && window.state().viewer.view.tdb_s == shown_time);
    window.key_press(egui::Key::Escape);
    window.run_steps(2);
    assert!(
        window.query_by_label("End tour").is_none() && window.state().tab == Some(Tab::Moments),
        "Escape ends the tour and leaves the panel"
    );
    // Back returns to the view before the tour.
    window.get_by_label("Back").click();
    window.run_steps(2);
    assert_eq!(window.state().viewer.view.target, NaifId(699));
}

/// Beside a panel in a small window, the buttons of a tour wrap instead of covering the panel.
#[test]
fn the_bar_of_a_tour_stays_in_a_narrow_viewport() {
    let mut window = window_without_images(NaifId(699));
    window.state_mut().tab = Some(Tab::Moments);
    window.run_steps(2);
    window.get_by_label(orrery_catalogs::TOURS[0].0).click();
    window.run_steps(2);
    let rows_at = |window: &mut Window, width: f32| {
        window.set_size(egui::vec2(width, 600.0));
        window.run_steps(4);
        let sky = window.get_by_label_contains("The sky:").rect();
        let buttons = ["Previous", "Record tour", "End tour"].map(|name| window.get_by_label(name).rect());
        for rect in buttons {
            assert!(rect.left() >= sky.left() && rect.right() <= sky.right(), "{width}: {rect:?} in {sky:?}");
        }
        buttons[2].center().y - buttons[0].center().y
    };
    assert!(rows_at(&mut window, 700.0) > 10.0, "two rows");
    assert!(rows_at(&mut window, 1400.0).abs() < 1.0, "one row");
}

/// A tour plays at once, also if another tour is open.
#[test]
fn a_tour_plays_at_once_after_another_tour() {
    let mut window = window_without_images(NaifId(699));
    window.state_mut().tab = Some(Tab::Moments);
    window.run_steps(2);
    for (name, _, text) in &orrery_catalogs::TOURS[..2] {
        window.get_by_label(name).click();
        window.run_steps(4);
        assert!(window.query_by_label_contains(parse(text).expect("a tour").text(0)).is_some(), "{name} is not shown");
        assert!(window.query_by_label("Pause tour").is_some(), "{name} is paused");
    }
}

/// The key that pauses time pauses a tour and continues it, and time does not start to run.
#[test]
fn space_pauses_and_continues_a_tour() {
    let mut window = window_without_images(NaifId(699));
    window.state_mut().tab = Some(Tab::Moments);
    window.run_steps(2);
    window.get_by_label(orrery_catalogs::TOURS[0].0).click();
    window.run_steps(4);
    assert!(window.query_by_label("Pause tour").is_some() && window.state().viewer.time_rate.is_paused());
    type_text(&mut window, " ");
    window.run_steps(2);
    assert!(window.query_by_label("Play tour").is_some(), "the tour goes on");
    let paused_s = window.state().viewer.view.tdb_s;
    window.run_steps(5);
    assert!(window.state().viewer.time_rate.is_paused() && window.state().viewer.view.tdb_s == paused_s, "time runs");
    type_text(&mut window, " ");
    window.run_steps(2);
    assert!(window.query_by_label("Pause tour").is_some() && window.state().viewer.time_rate.is_paused(), "the tour does not continue");
    // After a change of the view the key is about time: a tour that continues would undo the change.
    window.get_by_label("+d").click();
    window.run_steps(2);
    type_text(&mut window, " ");
    assert!(!window.state().viewer.time_rate.is_paused());
}

/// A control that changes what the view shows pauses the tour, and the change is kept. A change of quality lasts without a pause.
#[test]
fn a_switch_pauses_a_tour_and_is_kept() {
    let mut window = window_without_images(NaifId(699));
    window.state_mut().tab = Some(Tab::Moments);
    window.run_steps(2);
    window.get_by_label(orrery_catalogs::TOURS[0].0).click();
    window.run_steps(4);
    window.state_mut().tab = Some(Tab::Effects);
    window.run_steps(4);
    assert!(window.query_by_label("Pause tour").is_some(), "opening a panel pauses the tour");
    assert_eq!(window.state().viewer.view.quality, Quality::Draft);
    window.get_by_label("standard").click();
    window.run_steps(4);
    assert_eq!(window.state().viewer.view.quality, Quality::Standard);
    assert!(window.query_by_label("Pause tour").is_some(), "a change of quality pauses the tour");
    assert_eq!(window.state().viewer.view.tone_map, ToneMap::Filmic);
    window.get_by_label("clipped").click();
    window.run_steps(6);
    assert_eq!(window.state().viewer.view.tone_map, ToneMap::Clipped);
    assert!(window.query_by_label("Play tour").is_some(), "the tour goes on");
    window.get_by_label("Play tour").click();
    window.run_steps(4);
    assert!(window.query_by_label("Pause tour").is_some());
    // A shortcut, too.
    let orbits = window.state().viewer.view.orbits;
    type_text(&mut window, "o");
    window.run_steps(4);
    assert_eq!(window.state().viewer.view.orbits, !orbits);
    assert!(window.query_by_label("Play tour").is_some(), "the tour goes on");
}

/// Between two fisheye stops the field of view stays between those of the stops, even if both have the greatest one. On a path from a perspective stop the
/// fisheye has the field of view of its own stop.
#[test]
fn the_field_of_a_fisheye_changes_only_between_fisheyes() {
    let stop =
        |composition: &str| format!(r#"{{"view": {{"target": "earth", "composition": {composition}}}, "travel_s": 3, "hold_s": 1}}"#);
    let fisheye = |deg: f64| stop(&format!(r#"{{"projection": "fisheye", "fisheye_deg": {deg}}}"#));
    let perspective = stop("{}");
    for (first, second, from_deg, to_deg) in [
        (fisheye(360.0), fisheye(360.0), 360.0, 360.0),
        (fisheye(180.0), fisheye(360.0), 180.0, 360.0),
        (fisheye(1.0), fisheye(1.0), 1.0, 1.0),
        (perspective, fisheye(60.0), 60.0, 60.0),
    ] {
        let tour = parse(&format!(r#"{{"title": "t", "stops": [{first}, {second}]}}"#)).unwrap_or_else(|e| panic!("{first} {second}: {e}"));
        let mut last_deg = from_deg;
        for k in 0..=60 {
            let view = tour.at(1.0 + f64::from(k) * 0.05).view;
            let fisheye_deg = view.composition.fisheye_deg;
            assert!((last_deg..=to_deg).contains(&fisheye_deg), "{first} {second} at {k}: {fisheye_deg}");
            last_deg = fisheye_deg;
            if let Err(e) = view.request(session().catalog(), session().ephemeris(), 16, 16) {
                panic!("{first} {second} at {k}: {e}");
            }
        }
    }
}
