//! Saved images, animations and shared links: no file is overwritten; a saved image carries its provenance; a shared view keeps whether time is paused.

use super::input::{SATURN, TIME, Window, click, window_without_images};
use super::search::window_after_search;
use crate::view::interface::{harness, interface, session, settle};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, OutputCommand};
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::image::{gif_text_in_head, png_text_in_head};
use orrery::scene::request::{Purpose, ViewRequest};
use orrery::session::ExistingImage;
use orrery::time::Instant;
use orrery::view::link::view_from_text;
use orrery::view::panels::Tab;
use orrery::view::worker::render_worker::InlineWorker;
use std::path::{Path, PathBuf};

/// A window with the Share panel, set to save small images in `file`.
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
fn saved_images_overwrite_no_file_and_their_path_is_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let path_of = |name: &str| folder.path().join(name);
    std::fs::write(path_of("p.png"), "mine").expect("a file");
    let mut window = sharing(&path_of("p.png"));
    for (k, tab) in [None, Some(Tab::Share), Some(Tab::Effects)].into_iter().enumerate() {
        window.state_mut().tab = tab;
        window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        settle(&mut window);
        let path = path_of(&format!("p-{}.png", k + 2));
        assert_eq!(window.state().reply_text(), format!("Saved {}", path.display()), "the message must remain after later images");
        assert_eq!(window.state().message_line(), window.state().reply_text());
        assert_eq!(image::image_dimensions(&path).expect("an image"), (24, 16));
        assert_eq!(window.state().tab, tab, "saving opens no panel");
    }
    assert_eq!(std::fs::read_to_string(path_of("p.png")).expect("a file"), "mine");
    // Two sequences under the same name. The second becomes p-5, because frames of other sequences occupy p-2 to p-4.
    window.state_mut().tab = Some(Tab::Share);
    for first_frame in ["p-00000.png", "p-5-00000.png"] {
        if first_frame.starts_with("p-5") {
            (2..5).for_each(|n| std::fs::write(path_of(&format!("p-{n}-00001.png")), "another's").expect("a file"));
        }
        settle(&mut window);
        window.get_by_label("Export sequence").click();
        settle(&mut window);
        assert!(
            window.state().reply_text().starts_with("3 of 3: Saved ") && !window.state().is_saving(),
            "{}",
            window.state().reply_text()
        );
        assert!(path_of(first_frame).exists(), "{first_frame} of {:?}", names_in(folder.path()));
    }
    // p.png and three single images, the first sequence, the frames of other sequences, the second sequence.
    assert_eq!(names_in(folder.path()).len(), 4 + 3 + 3 + 3);
    // Time advances by a minute between frames: three different images.
    let bytes = |n: usize| std::fs::read(path_of(&format!("p-0000{n}.png"))).expect("a frame");
    assert!(bytes(0) != bytes(1) && bytes(1) != bytes(2));
    // A write error names the path.
    let missing_folder = PathBuf::from("none").join("p.png");
    window
        .get_by_label_contains("Image file: .png or .exr")
        .set_text_value_accesskit(&path_of("").join(missing_folder).display().to_string());
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(&mut window);
    assert!(window.state().reply_text().contains(&path_of("none").display().to_string()), "{}", window.state().reply_text());
}

/// The size that is being typed when Ctrl+S is pressed counts; one that Escape drops does not.
#[test]
fn ctrl_s_saves_an_image_of_the_typed_size() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, is_dropped, size) in [("a.png", false, (30, 16)), ("b.png", true, (24, 16))] {
        let path = folder.path().join(name);
        let mut window = sharing(&path);
        window.get_by_role_and_label(Role::SpinButton, "Width, pixels").focus();
        window.run_steps(2);
        window.key_press_modifiers(Modifiers::COMMAND, Key::A);
        window.run_steps(2);
        window.event(Event::Text("30".into()));
        window.run_steps(2);
        if is_dropped {
            window.key_press(Key::Escape);
            window.run_steps(3);
        }
        window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        settle(&mut window);
        assert_eq!(image::image_dimensions(&path).expect("an image"), size, "{name}: {}", window.state().reply_text());
    }
}

/// A window with the Share panel, set to record small animations in `file`.
fn animating(file: &Path) -> Window {
    let mut window = sharing(&file.with_extension("png"));
    window.get_by_label_contains("Animation file: .gif").set_text_value_accesskit(&file.display().to_string());
    window.run_steps(2);
    for (field, value) in [("Width of the animation, pixels", 24.0), ("Height of the animation, pixels", 16.0), ("Frames a second", 5.0)] {
        window.get_by_label(field).set_value_accesskit(value);
        window.run_steps(2);
    }
    window
}

fn frames_of_apng(path: &Path) -> Vec<image::RgbaImage> {
    use image::AnimationDecoder;
    let bytes = std::io::Cursor::new(std::fs::read(path).expect("a file"));
    let frames = image::codecs::png::PngDecoder::new(bytes).expect("a PNG").apng().expect("animated").into_frames();
    frames.map(|f| f.expect("a frame").into_buffer()).collect()
}

#[test]
fn an_animation_is_saved_in_one_file_and_overwrites_none() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["a.apng", "a.gif"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "mine").expect("a file");
        let mut window = animating(&path);
        window.get_by_label("Simulated seconds between frames").set_value_accesskit(3600.0);
        window.run_steps(2);
        window.get_by_label("Record animation").click();
        settle(&mut window);
        let unused_path = folder.path().join(name.replacen("a.", "a-2.", 1));
        assert_eq!(window.state().reply_text(), format!("Saved {}", unused_path.display()));
        assert_eq!(std::fs::read_to_string(&path).expect("a file"), "mine");
        if name.ends_with("apng") {
            let frames = frames_of_apng(&unused_path);
            assert!(frames.len() == 3 && frames[0] != frames[1] && frames[1] != frames[2], "three different images of rotating Saturn");
            // The animation is centred on the displayed time, so its middle frame is the displayed view.
            let view = window.state().viewer.view.clone();
            let request = view.request(session().catalog(), session().ephemeris(), 24, 16).expect("a request");
            let sampling = orrery::render::plan::SamplingQuality::of(request.quality);
            let drawn = session().draw_in_background(&request, sampling, FrameImages::Display).expect("an image").frame.display;
            assert_eq!(frames[1].pixels().map(|p| p.0).collect::<Vec<_>>(), drawn);
        } else {
            assert_eq!(std::fs::read(&unused_path).expect("a file")[..6], *b"GIF89a");
        }
        let bytes = std::fs::read(&unused_path).expect("a file");
        let text = |keyword: &str| if name == "a.gif" { gif_text_in_head(&bytes, keyword) } else { png_text_in_head(&bytes, keyword) };
        assert_eq!(text("Title").as_deref(), Some("Saturn"), "{name}");
        assert!(text("Description").is_some_and(|link| link.starts_with("orrery://view?")), "{name}");
        assert!(text("Request").is_some_and(|request| request.contains("\"frames\":\"3 at 5 per second (")), "{name}");
    }
    // An impossible animation is reported and not started.
    let mut window = animating(&folder.path().join("a.mp4"));
    window.get_by_label("Record animation").click();
    settle(&mut window);
    assert!(window.state().reply_text().contains(".gif or .apng") && !window.state().is_saving(), "{}", window.state().reply_text());
}

/// A file that is chosen in a dialog is entered in the field. A cancelled dialog is reported; without dialogs there are no buttons for them.
#[test]
fn files_are_chosen_in_a_dialog_where_there_is_one() {
    use orrery::view::panels::FileRequest;
    use orrery::view::worker::render_worker::Pending;
    fn choose(question: FileRequest) -> Pending<Option<PathBuf>> {
        let (pending, answer) = Pending::with_sender();
        answer(Some(PathBuf::from(format!("chosen/{}", question.name))));
        pending
    }
    fn cancel(_: FileRequest) -> Pending<Option<PathBuf>> {
        let (pending, answer) = Pending::with_sender();
        answer(None);
        pending
    }
    let mut window = sharing(Path::new("p.png"));
    assert!(window.query_by_label("Choose: image file").is_none(), "no dialogs, no buttons");
    window.state_mut().file_dialog = Some(choose);
    window.run_steps(2);
    window.get_by_label("Choose: image file").click();
    window.run_steps(3);
    window.get_by_label("Choose: animation file").click();
    window.run_steps(3);
    let values: Vec<String> = window.query_all_by_role(Role::TextInput).filter_map(|n| n.accesskit_node().value()).collect();
    assert!(values.iter().any(|v| v == "chosen/p.png") && values.iter().any(|v| v == "chosen/orrery.gif"), "{values:?}");
    window.state_mut().file_dialog = Some(cancel);
    window.run_steps(2);
    window.get_by_label("Choose: view file").click();
    window.run_steps(3);
    assert!(window.state().reply_text().contains("No file was chosen"), "{}", window.state().reply_text());
}

/// A view to open was chosen in a dialog for saving, which asks whether to replace the file, and a name without an extension could not be saved.
#[test]
fn dialogs_choose_existing_files_to_open_and_complete_new_names() {
    use orrery::view::panels::FileRequest;
    use orrery::view::worker::render_worker::Pending;
    fn choose(question: FileRequest) -> Pending<Option<PathBuf>> {
        let (pending, answer) = Pending::with_sender();
        answer(Some(PathBuf::from(if question.is_for_opening { "chosen/existing" } else { "chosen/new" })));
        pending
    }
    let mut window = sharing(Path::new("p.png"));
    window.state_mut().file_dialog = Some(choose);
    window.run_steps(2);
    for (button, path) in [
        ("Choose: view file", "chosen/new.json"),
        ("Choose: view file to open", "chosen/existing"),
        ("Choose: image file", "chosen/new.png"),
        ("Choose: animation file", "chosen/new.gif"),
    ] {
        window.get_by_label(button).click();
        window.run_steps(3);
        let values: Vec<String> = window.query_all_by_role(Role::TextInput).filter_map(|n| n.accesskit_node().value()).collect();
        assert!(values.iter().any(|value| value == path), "{button}: {values:?}");
    }
}

/// A saved image carries the same provenance as one of `render`, so that a sequence can resume with it.
#[test]
fn saved_images_have_their_provenance() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, purpose) in [("p.png", Purpose::Display), ("p.exr", Purpose::of_file(true))] {
        let path = folder.path().join(name);
        let mut window = sharing(&path);
        window.key_press_modifiers(Modifiers::COMMAND, Key::S);
        settle(&mut window);
        let view = &window.state().viewer.view;
        let request = view.request(session().catalog(), session().ephemeris(), 24, 16).expect("a request");
        let request = ViewRequest { purpose, ..request };
        assert_eq!(session().provenance(&request).examine_existing_image(&path, (24, 16)), ExistingImage::Same, "{name}");
        let wider = ViewRequest { fov_deg: Some(46.0), ..request };
        let existing = session().provenance(&wider).examine_existing_image(&path, (24, 16));
        assert!(matches!(existing, ExistingImage::Other(why) if why.contains("fov")), "{name}");
    }
}

#[test]
fn a_shared_view_keeps_whether_time_is_paused() {
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
        let view = view_from_text(&link, session(), Instant::from_tdb_seconds_past_j2000(0.0)).expect("a view");
        // The link opened in a new window, then in a window in the opposite state.
        let bodies = window.state().viewer.selectable_bodies().to_vec();
        let opened = orrery::view::app::viewer::Viewer::new(bodies, view.clone(), || Instant::from_tdb_seconds_past_j2000(0.0));
        assert_eq!(opened.time_rate.is_paused(), paused);
        let mut other = harness(interface(NaifId::EARTH, TIME));
        if paused {
            other.state_mut().viewer.time_rate.toggle_pause();
        }
        other.state_mut().show(view, &InlineWorker::new(session()));
        let shown_s = other.state().viewer.view.tdb_s;
        settle(&mut other);
        assert_eq!(other.state().viewer.time_rate.is_paused(), paused);
        assert_eq!(other.state().viewer.view.tdb_s == shown_s, paused, "time must run or stay paused as shared");
        // The state is the same when the view is shared again.
        let again = other.state().viewer.shareable_view();
        assert_eq!(again.paused, Some(paused));
        assert!(other.state().viewer.view.paused.is_none());
    }
}

/// A selected text of a label is copied by egui, at the end of the frame; the reply once said that the link was copied.
#[test]
fn the_reply_to_a_copy_is_true_of_selected_text_and_of_the_link() {
    let mut window = window_without_images(SATURN);
    window.state_mut().tab = Some(Tab::Share);
    window.run_steps(3);
    let copy = |window: &mut Window| {
        window.event(Event::Copy);
        window.run_steps(1);
        let copied_last = window.output().platform_output.commands.iter().rev().find_map(|c| match c {
            OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        });
        (copied_last.unwrap_or_default(), window.state().reply_text().to_owned())
    };
    let (text, reply) = copy(&mut window);
    assert!(text.starts_with("orrery://view?") && reply == "Link copied", "{text}: {reply}");
    // A double click selects a word.
    let label = window.get_by_label("This view").rect().left_center() + egui::vec2(4.0, 0.0);
    click(&mut window, label);
    click(&mut window, label);
    assert_eq!(copy(&mut window), ("This".to_owned(), "Copied".to_owned()));
}

/// Replaces the text of a field of the Share panel, and enters it.
fn enter(window: &mut Window, field: &str, text: &str) {
    window.get_by_role_and_label(Role::TextInput, field).focus();
    window.run_steps(1);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.run_steps(1);
    window.get_by_role_and_label(Role::TextInput, field).type_text(text);
    window.run_steps(2);
    window.key_press(Key::Enter);
    window.run_steps(3);
}

/// Opening a view removes the error of an earlier link, which would seem to be about the opened view.
#[test]
fn enter_opens_a_link_and_adds_a_bookmark() {
    let mut window = window_without_images(SATURN);
    window.state_mut().tab = Some(Tab::Share);
    window.run_steps(3);
    enter(&mut window, "A link to open", "orrery://view?target=nosuch");
    assert!(window.state().reply_text().contains("nosuch"), "{}", window.state().reply_text());
    enter(&mut window, "A link to open", "orrery://view?target=599&time=2015-01-24T06:45:00Z");
    assert_eq!(window.state().viewer.view_after_flight().target, NaifId(599));
    assert_eq!(window.state().reply_text(), "");
    enter(&mut window, "Name of the bookmark", "three shadows");
    let names: Vec<&str> = window.state().settings.bookmarks.iter().map(|bookmark| bookmark.name.as_str()).collect();
    assert_eq!(names, ["three shadows"]);
}

/// A press of the wrong button once lost a bookmark.
#[test]
fn a_removed_bookmark_can_be_brought_back_to_its_place() {
    let mut window = window_without_images(SATURN);
    window.state_mut().tab = Some(Tab::Share);
    window.run_steps(3);
    let names = |window: &Window| window.state().settings.bookmarks.iter().map(|bookmark| bookmark.name.clone()).collect::<Vec<_>>();
    for name in ["first", "second", "third"] {
        enter(&mut window, "Name of the bookmark", name);
    }
    assert!(window.query_by_label_contains("Bring back").is_none());
    window.get_by_label("Remove the bookmark second").click_accesskit();
    window.run_steps(3);
    assert_eq!(names(&window), ["first", "third"]);
    window.get_by_label("Bring back second").click_accesskit();
    window.run_steps(3);
    assert_eq!(names(&window), ["first", "second", "third"]);
    assert!(window.query_by_label_contains("Bring back").is_none());
}

/// At another time the frames would not show the event.
#[test]
fn the_length_of_an_event_is_offered_only_near_its_time() {
    let mut window = window_after_search("eclipse 2027");
    window.get_by_label_contains("Total solar eclipse, 2027-08-02 10:0").click();
    window.run_steps(3);
    window.state_mut().tab = Some(Tab::Share);
    window.run_steps(3);
    assert_eq!(window.query_all_by_label("Whole event").count(), 1);
    window.state_mut().viewer.view.tdb_s += 30.0 * 86_400.0;
    window.run_steps(3);
    assert_eq!(window.query_all_by_label("Whole event").count(), 0);
}

/// A missing folder was noticed after the last frame, and all frames were lost.
#[test]
fn a_recording_that_cannot_be_written_does_not_start() {
    let folder = tempfile::tempdir().expect("a folder");
    for (file, starts) in [("none/a.gif", false), ("a.gif", true)] {
        let mut window = animating(&folder.path().join(file));
        window.get_by_label("Number of frames").set_value_accesskit(50.0);
        window.run_steps(2);
        window.get_by_label("Record animation").click_accesskit();
        window.run_steps(6);
        let reply = window.state().reply_text().to_owned();
        assert_eq!((window.state().is_saving(), reply.contains("there is no folder")), (starts, !starts), "{file}: {reply}");
    }
    assert_eq!(names_in(folder.path()), Vec::<String>::new(), "the trial leaves no file");
}

/// To quit during a recording, which loses it, one must ask twice.
#[test]
fn a_recording_is_not_lost_by_one_key() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = animating(&folder.path().join("a.gif"));
    assert!(window.state_mut().may_quit(), "nothing would be lost");
    for recording in 0..2 {
        window.get_by_label("Number of frames").set_value_accesskit(50.0);
        window.run_steps(2);
        window.get_by_label("Record animation").click_accesskit();
        window.run_steps(6);
        window.key_press_modifiers(Modifiers::COMMAND, Key::Q);
        window.run_steps(1);
        assert!(window.state().quit_requested && window.state().is_saving(), "recording {recording}");
        assert!(!window.state_mut().may_quit() && !window.state().quit_requested, "recording {recording}");
        // The messages about later frames keep the warning.
        for _ in 0..3 {
            let reply = window.state().reply_text();
            assert!(reply.contains("quit again"), "recording {recording}: {reply}");
            window.run_steps(1);
        }
        if recording == 0 {
            window.get_by_label("Cancel").click_accesskit();
            window.run_steps(3);
            assert!(!window.state().is_saving());
        }
    }
    assert!(window.state_mut().may_quit(), "asked for the second time");
}

/// The frames of a sequence began in the middle of the event, at the shown time.
#[test]
fn the_frames_of_a_whole_event_begin_before_it_and_end_after_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = window_after_search("eclipse 2027");
    window.get_by_label_contains("Total solar eclipse, 2027-08-02 10:0").click();
    window.run_steps(3);
    window.state_mut().tab = Some(Tab::Share);
    window.run_steps(3);
    for (field, value) in [("Width, pixels", 24.0), ("Height, pixels", 16.0), ("Number of frames", 2.0)] {
        window.get_by_label(field).set_value_accesskit(value);
        window.run_steps(2);
    }
    // Minutes from the greatest phase to each frame.
    let minutes_of_frames = |window: &mut Window, file: &str| {
        let file = folder.path().join(file);
        window.get_by_label_contains("Image file: .png or .exr").set_text_value_accesskit(&file.display().to_string());
        window.run_steps(2);
        window.get_by_label("Export sequence").click_accesskit();
        window.run_steps(12);
        let greatest = Instant::parse("2027-08-02T10:06:42Z").expect("a time");
        [0, 1].map(|frame| {
            let path = file.with_file_name(format!("{}-{frame:05}.png", file.file_stem().expect("a stem").display()));
            let png = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).expect("a frame"))).read_info().expect("a PNG");
            let text = png.info().utf8_text.iter().find(|text| text.keyword == "Creation Time").expect("a time");
            let time = Instant::parse(&text.get_text().expect("a text")).expect("a time");
            (time.tdb_seconds_past_j2000() - greatest.tdb_seconds_past_j2000()) / 60.0
        })
    };
    // Negative control: without the choice, the sequence begins at the shown time, that of the greatest phase.
    let [first, _] = minutes_of_frames(&mut window, "shown.png");
    assert!(first.abs() < 1.0, "{first} minutes");
    window.get_by_label("Whole event").click_accesskit();
    window.run_steps(3);
    let [first, last] = minutes_of_frames(&mut window, "event.png");
    // At the place of greatest eclipse, first and last contact are 85 minutes before and 81 minutes after the greatest phase; a twentieth of the length is
    // added at either end.
    assert!((-100.0..-80.0).contains(&first) && (80.0..100.0).contains(&last), "{first} to {last} minutes");
    // The shown time does not matter.
    window.state_mut().viewer.view.tdb_s += 3600.0;
    window.run_steps(3);
    let later = minutes_of_frames(&mut window, "later.png");
    assert!((later[0] - first).abs() < 0.1 && (later[1] - last).abs() < 0.1, "{later:?}");
}

/// The messages once began with a colon, where the name should have been.
#[test]
fn an_empty_file_name_is_refused_with_a_message() {
    let mut window = sharing(Path::new("orrery.png"));
    let is_folder = |label: &str| label.starts_with("Folder: ") && label.len() > "Folder: /".len();
    let folder = |window: &Window| {
        let mut labels = window.query_all_by_label_contains("Folder: ").filter_map(|label| label.accesskit_node().value());
        labels.find(|label| label.starts_with("Folder: ")).expect("a folder")
    };
    let named = folder(&window);
    assert!(is_folder(&named), "{named}");
    for name in ["", " "] {
        window.get_by_label_contains("Image file: .png or .exr").set_text_value_accesskit(name);
        window.get_by_role_and_label(Role::TextInput, "View file").set_text_value_accesskit(name);
        window.run_steps(3);
        if name.is_empty() {
            assert_eq!(folder(&window), named, "the folder of an empty name");
        }
        for button in ["Save image", "Export sequence", "Save view", "Open view"] {
            window.state_mut().show_reply("");
            window.get_by_role_and_label(Role::Button, button).click_accesskit();
            window.run_steps(4);
            assert_eq!(window.state().reply_text(), "Type a file name first", "{button}, “{name}”");
        }
    }
}
