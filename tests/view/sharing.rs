//! Saved pictures and shared links: files are never written over, a picture tells its request, a shared view keeps whether time stands still.

use super::hands::{SATURN, TIME, Window};
use crate::view::interface::{harness, interface, session, settle};
use egui::{Event, Key, Modifiers, OutputCommand};
use egui_kittest::kittest::Queryable;
use orrery::catalog::NaifId;
use orrery::scene::request::{Purpose, ViewRequest};
use orrery::session::ExistingPicture;
use orrery::time::Instant;
use orrery::view::link::restored;
use orrery::view::panels::Tab;
use orrery::view::worker::render_worker::InlineWorker;
use std::path::{Path, PathBuf};

/// The share panel with small pictures of a name in a folder.
fn sharing(file: &Path) -> Window {
    let mut window = harness(interface(SATURN, TIME));
    window.state_mut().tab = Some(Tab::Share);
    settle(&mut window);
    window.get_by_label_contains("Image file: .png or .exr").set_text_value_accesskit(&file.display().to_string());
    window.run_steps(2);
    for (field, value) in [("Width, pixels", 24.0), ("Height, pixels", 16.0), ("Number of frames", 3.0)] {
        window.get_by_label(field).set_value_accesskit(value);
        window.run_steps(2);
    }
    window
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn pictures_are_saved_beside_what_is_there_and_the_whole_path_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("p.png"), "mine").expect("a file");
    let mut window = sharing(&at("p.png"));
    for (k, tab) in [None, Some(Tab::Share), Some(Tab::Effects)].into_iter().enumerate() {
        window.state_mut().tab = tab;
        window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        settle(&mut window);
        let path = at(&format!("p-{}.png", k + 2));
        assert_eq!(window.state().message, format!("Saved {}", path.display()), "said after the pictures that came since");
        assert_eq!(window.state().said(), window.state().message);
        assert_eq!(image::image_dimensions(&path).expect("a picture"), (24, 16));
        assert_eq!(window.state().tab, tab, "saving opens no panel");
    }
    assert_eq!(std::fs::read_to_string(at("p.png")).expect("a file"), "mine");
    // A sequence under the same plain name, twice; the second beside the first.
    window.state_mut().tab = Some(Tab::Share);
    for first in ["p-00000.png", "p-5-00000.png"] {
        if first.starts_with("p-5") {
            (2..5).for_each(|n| std::fs::write(at(&format!("p-{n}-00001.png")), "another's").expect("a file"));
        }
        settle(&mut window);
        window.get_by_label("Export sequence").click();
        settle(&mut window);
        assert!(window.state().message.starts_with("3 of 3: Saved ") && !window.state().is_saving(), "{}", window.state().message);
        assert!(at(first).exists(), "{first} of {:?}", names_in(folder.path()));
    }
    assert_eq!(names_in(folder.path()).len(), 4 + 3 + 3 + 3);
    // Time goes on by a minute between frames: they are three pictures.
    let bytes = |n: usize| std::fs::read(at(&format!("p-0000{n}.png"))).expect("a frame");
    assert!(bytes(0) != bytes(1) && bytes(1) != bytes(2));
    // What cannot be written says where.
    let nowhere = PathBuf::from("none").join("p.png");
    window.get_by_label_contains("Image file: .png or .exr").set_text_value_accesskit(&at("").join(nowhere).display().to_string());
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(&mut window);
    assert!(window.state().message.contains(&at("none").display().to_string()), "{}", window.state().message);
}

/// As `render` writes them, so that a run of frames knows its own pictures and no other's.
#[test]
fn saved_pictures_tell_which_request_they_are_of() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, purpose) in [("p.png", Purpose::Display), ("p.exr", Purpose::of_file(true))] {
        let path = folder.path().join(name);
        let mut window = sharing(&path);
        window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        settle(&mut window);
        let view = &window.state().viewer.view;
        let request = view.request(session().catalog(), session().ephemeris(), 24, 16).expect("a request");
        let request = ViewRequest { purpose, ..request };
        assert_eq!(session().provenance(&request).existing(&path, (24, 16)), ExistingPicture::Same, "{name}");
        let wider = ViewRequest { fov_deg: Some(46.0), ..request };
        assert!(
            matches!(session().provenance(&wider).existing(&path, (24, 16)), ExistingPicture::Other(why) if why.contains("fov")),
            "{name}"
        );
    }
}

#[test]
fn a_view_that_is_shared_paused_stays_paused_and_one_that_runs_runs() {
    for paused in [true, false] {
        let mut window = harness(interface(SATURN, TIME));
        if !paused {
            window.state_mut().viewer.time_rate.toggle_pause();
        }
        settle(&mut window);
        window.event(Event::Copy);
        window.run_steps(1);
        let copied = window.output().platform_output.commands.iter().find_map(|c| match c {
            OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        });
        let link = copied.expect("a link");
        let view = restored(&link, session(), Instant::from_tdb_seconds_past_j2000(0.0)).expect("a view");
        // In a window of its own, and in one where time does the other.
        let subjects = window.state().viewer.subjects().to_vec();
        let opened = orrery::view::app::viewer::Viewer::new(subjects, view.clone(), || Instant::from_tdb_seconds_past_j2000(0.0));
        assert_eq!(opened.time_rate.is_paused(), paused);
        let mut other = harness(interface(NaifId::EARTH, TIME));
        if paused {
            other.state_mut().viewer.time_rate.toggle_pause();
        }
        other.state_mut().show(view, &InlineWorker::new(session()));
        let shown_s = other.state().viewer.view.tdb_s;
        settle(&mut other);
        assert_eq!(other.state().viewer.time_rate.is_paused(), paused);
        assert_eq!(other.state().viewer.view.tdb_s == shown_s, paused, "time goes on, or does not");
        // What is kept goes back to the link that it came from.
        let again = other.state().viewer.shared();
        assert_eq!(again.paused, Some(paused));
        assert!(other.state().viewer.view.paused.is_none());
    }
}
