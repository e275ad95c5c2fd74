//! Files dropped on the window or named by `orrery view`: data become layers, views are shown, tours are played, and errors are reported.

use super::interface::{harness_of, interface, settle};
use egui_kittest::kittest::Queryable as _;
use orrery::catalog::NaifId;
use orrery::session::{Session, Sources};
use orrery::time::Instant;
use orrery::view::opened_file::read;
use orrery::view::panels::Interface;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const SATURN: NaifId = NaifId(699);

#[derive(Debug)]
struct FileOnDisk(PathBuf);

impl egui::DroppedFile for FileOnDisk {
    fn path(&self) -> &Path {
        &self.0
    }
    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("the window reads the file by its path".into())
    }
}

type Window = egui_kittest::Harness<'static, Interface>;

/// A window that shows the Earth, with a session of its own, whose cache is in the folder.
fn window(folder: &Path) -> (&'static Session, Window) {
    let sources = Sources { cache: Some(folder.join("cache")), ..Sources::default() };
    let session: &'static Session = Box::leak(Box::new(Session::open(&sources, |line| panic!("{line}")).expect("a session")));
    let mut harness = harness_of(session, interface(NaifId::EARTH, "2024-03-20T03:00:00Z"));
    settle(&mut harness);
    (session, harness)
}

/// Writes a file and returns its path.
fn write(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, content).expect("written");
    path
}

/// Drops files on the window, all in one frame.
fn drop_files(window: &mut Window, paths: &[PathBuf]) {
    for path in paths {
        window.input_mut().dropped_files.push(Arc::new(FileOnDisk(path.clone())));
    }
    window.run_steps(1);
    window.input_mut().dropped_files.clear();
    settle(window);
}

#[test]
fn a_dropped_file_is_a_layer_and_an_invalid_one_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let (session, mut harness) = window(folder.path());
    let dot_count =
        |window: &Window| window.state().shown().and_then(|rendered| rendered.scene.labels.as_ref()).map_or(0, |labels| labels.dots.len());
    assert_eq!(dot_count(&harness), 0);
    let mut drop_file = |name: &str, content: &[u8]| {
        drop_files(&mut harness, &[write(folder.path(), name, content)]);
        (harness.state().reply_text().to_owned(), dot_count(&harness))
    };
    let (message, dots) = drop_file("own.csv", b"lat,lon\n0,135\n5,140\n");
    assert_eq!((message.as_str(), dots), ("own.csv: 2 points and 0 lines on Earth", 2));
    // An invalid file changes nothing, and the message names its line and field.
    let (message, dots) = drop_file("wrong.csv", b"lat,lon\n0,135\n95,140\n");
    assert!(message.contains("wrong.csv:3: field lat_deg: `95`") && dots == 2, "{message}");
    let (message, dots) = drop_file("own.png", b"\x89PNG\r\n\x1a\n");
    assert!(message.contains("not a data layer") && dots == 2, "{message}");
    // A file of the same name replaces the layer; celestial coordinates give points in the sky.
    let (message, _) = drop_file("own.csv", b"ra,dec\n10,20\n");
    assert_eq!(message, "own.csv: 1 point and 0 lines in the sky");
    assert_eq!(session.catalog().data_layers().len(), 1);
    // Of files dropped together, each has its message, the error first.
    let third = write(folder.path(), "third.csv", "lat,lon\n1,2\n");
    drop_files(&mut harness, &[folder.path().join("own.csv"), folder.path().join("wrong.csv"), third]);
    let lines: Vec<&str> = harness.state().reply_text().lines().collect();
    assert!(lines.len() == 3 && lines[0].contains("wrong.csv:3"), "{lines:?}");
    assert_eq!(lines[1..], ["own.csv: 1 point and 0 lines in the sky", "third.csv: 1 point and 0 lines on Earth"]);
}

/// A view was read as GeoJSON, and the reply was about the fields of that.
#[test]
fn a_dropped_view_is_shown_and_a_dropped_tour_is_played() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, mut harness) = window(folder.path());
    let mut drop_file = |name: &str, text: &str| {
        drop_files(&mut harness, &[write(folder.path(), name, text)]);
        let is_tour_open = harness.query_by_label_contains("Two planets: 1 of 1").is_some();
        (harness.state().viewer.view_after_flight().target, harness.state().reply_text().to_owned(), is_tour_open)
    };
    let saved_view = interface(SATURN, "2017-05-17T00:00:00Z").viewer.view.to_json();
    assert_eq!(drop_file("view.json", &saved_view), (SATURN, String::new(), false));
    let (target, reply, _) = drop_file("wrong.json", r#"{"target": "Mars", "fov_deg": 500}"#);
    assert!(target == SATURN && reply.contains("wrong.json: ") && reply.contains("fov_deg"), "{target:?}: {reply}");
    // The same ending, but data.
    let (target, reply, _) = drop_file("own.json", r#"{"type": "Point", "coordinates": [10, 20]}"#);
    assert_eq!((target, reply.as_str()), (SATURN, "own.json: 1 point and 0 lines on Saturn"));
    let view = "orrery://view?target=Mars&time=2013-08-19T20:00:00Z&eye.distance_radii=3";
    let tour = format!(r#"{{"title": "Two planets", "stops": [{{"view": "{view}", "text": "Mars.", "hold_s": 600}}]}}"#);
    let (target, _, is_tour_open) = drop_file("tour.JSON", &tour);
    assert!(target == NaifId(499) && is_tour_open, "{target:?}");
    // A file may have any ending: a link is one in a text file, too, whose ending is that of data.
    assert_eq!(drop_file("link.txt", "orrery://view?target=saturn&time=2017-05-17").0, SATURN);
    assert_eq!(drop_file("moon.view", r#"{"target": "Moon", "time": "2024-04-08"}"#).0, NaifId::MOON);
    // The reply about a wrong tour names the file.
    let (_, reply, _) = drop_file("wrong.json", r#"{"title": "None", "stops": []}"#);
    assert!(reply.contains("wrong.json: ") && reply.contains("at least one stop"), "{reply}");
}

/// `orrery view quakes.csv` was refused: "not a link".
#[test]
fn a_file_of_the_command_line_is_opened_in_the_first_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let (session, mut harness) = window(folder.path());
    let mut open = |name: &str, text: &str| {
        let interface = harness.state_mut();
        let now = Instant::parse("2024-04-08T18:17:16Z").expect("a time");
        let read = read(session, &write(folder.path(), name, text), Some(interface.viewer.view.target), now);
        interface.open_file(read.unwrap_or_else(|unread| panic!("{unread:?}")));
        settle(&mut harness);
        let is_tour_open = harness.query_by_label_contains("One planet: 1 of 1").is_some();
        (harness.state().reply_text().to_owned(), harness.state().viewer.view_after_flight().layers.data, is_tour_open)
    };
    assert_eq!(open("own.csv", "lat,lon\n0,135\n5,140\n"), ("own.csv: 2 points and 0 lines on Earth".to_owned(), true, false));
    let view = "orrery://view?target=Mars&time=2013-08-19T20:00:00Z&eye.distance_radii=3";
    let tour = format!(r#"{{"title": "One planet", "stops": [{{"view": "{view}", "text": "Mars.", "hold_s": 600}}]}}"#);
    assert!(open("tour.json", &tour).2);
    assert_eq!(harness.state().viewer.view_after_flight().target, NaifId(499));
}
