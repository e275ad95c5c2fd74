//! The Shader and Compare panels, operated by the accessible names of their controls, without a window or a GPU.

use crate::view::interface::{interface, session};
use egui::accesskit::Role;
use egui::{Event, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Shape, TouchPhase, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::session::{Session, Sources};
use orrery::shader::fragments::{FRAGMENTS, Fragments};
use orrery::view::panels::{Interface, Tab};
use orrery::view::window::shader_watcher::ShaderWatcher;
use orrery::view::worker::render_worker::{FailedJob, InlineWorker, RenderJob, RenderWorker, RenderedView, Task};
use std::collections::{BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

/// Saturn from its lit side, with the rings' shadow on the globe; time is paused.
fn interface_at_saturn() -> Interface {
    interface(NaifId(699), "2017-05-17T00:00:00Z")
}

fn harness<'a>(worker: &'a InlineWorker<'a>, interface: Interface) -> Harness<'a, Interface> {
    let mut harness = Harness::builder()
        .with_size(vec2(1280.0, 800.0))
        .build_ui_state(|ui, interface: &mut Interface| interface.ui(ui, worker), interface);
    harness.run_steps(12);
    harness
}

fn press(harness: &mut Harness<'_, Interface>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(6);
}

/// Every accessible name on screen that contains a text, each once.
fn names_containing(harness: &Harness<'_, Interface>, part: &str) -> Vec<String> {
    let all = harness.query_all_by(|node| node.label().or(node.value()).is_some_and(|l| l.contains(part)));
    let names: BTreeSet<String> = all.filter_map(|n| n.accesskit_node().label().or(n.accesskit_node().value())).collect();
    names.into_iter().collect()
}

fn open_shader_page(harness: &mut Harness<'_, Interface>, page: &str) {
    harness.state_mut().tab = Some(Tab::Shader);
    harness.run_steps(6);
    press(harness, page);
}

/// The entry of the legend among these names: a feature and its number of lines, two words. The labels of the margin are longer.
fn legend_entry(names: &[String]) -> &str {
    names.iter().find(|name| name.split(' ').count() == 2).expect("a legend")
}

#[test]
fn the_source_names_the_feature_that_draws_the_rings_shadow() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Source");
    let features = names_containing(&harness, "ring-shadow.");
    assert!(!features.is_empty(), "no line of the globe is for the ring's shadow");
    press(&mut harness, legend_entry(&features));
    assert!(!names_containing(&harness, "ring_").is_empty(), "its lines are not in view");
    // 07230203: the magic number of SPIR-V.
    for (language, word) in
        [("HLSL", "float4"), ("MSL", "metal"), ("GLSL", "version"), ("SPIR-V", "07230203"), ("SPIR-V text", "OpCapability")]
    {
        press(&mut harness, language);
        assert!(!names_containing(&harness, word).is_empty(), "{language} without {word}");
        assert!(names_containing(&harness, ", needed by ").is_empty(), "{language} has a source map");
    }
    // The draw of the rings has no shadow of the rings: it has only lines for the absence of that feature ("not ring-shadow...").
    press(&mut harness, "WGSL");
    press(&mut harness, "ring");
    assert!(
        !names_containing(&harness, "body-shadow.").is_empty(),
        "the legend is not that of the rings, on which the globe's shadow falls"
    );
    assert!(names_containing(&harness, "ring-shadow.").iter().all(|f| f.starts_with("not ")), "a line is for the ring's shadow");
}

#[test]
fn a_key_chosen_in_the_gallery_is_compared_with_the_drawn_one() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Key");
    assert!(names_containing(&harness, "changed by hand").is_empty() && names_containing(&harness, "features differ").is_empty());
    assert_eq!(names_containing(&harness, "Reachable: one of").len(), 1, "the drawn key is not among the reachable ones");
    press(&mut harness, "Gallery");
    let tile = names_containing(&harness, "Inspect ring-shadow: none");
    // A click by the pointer would need the tile to be in view.
    harness.get_by_label(tile.first().expect("a tile without the ring's shadow")).click_accesskit();
    harness.run_steps(6);
    press(&mut harness, "Key");
    assert_eq!(names_containing(&harness, "changed by hand").len(), 1);
    let difference = names_containing(&harness, "features differ");
    assert!(difference[0].contains("lines removed"), "{difference:?}");
    assert!(!names_containing(&harness, "ring-shadow.").is_empty(), "the difference is not listed by feature");
    press(&mut harness, "Back to the drawn key");
    assert!(names_containing(&harness, "features differ").is_empty());
}

#[test]
fn a_pixel_is_reported_in_both_precisions() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Probe");
    assert!(names_containing(&harness, "f64 difference").is_empty(), "values before a click");
    press(&mut harness, "Centre of the image");
    let headings = names_containing(&harness, "f64 difference");
    assert!(headings.iter().any(|h| h.contains("f32") && h.contains("f64")), "{headings:?}");
    let red = names_containing(&harness, "colour red");
    let numbers: Vec<f64> = red[0].split_whitespace().filter_map(|w| w.parse().ok()).collect();
    let &[single, double, difference] = &numbers[..] else { panic!("{red:?}") };
    assert!(single > 0.0 && (single - double).abs() < 1e-4 * double && difference < 1e-4 * double, "{red:?}");
}

/// The left edge and the number of lines of each painted text that contains `part`.
fn painted_texts(harness: &Harness<'_, Interface>, part: &str) -> Vec<(f32, usize)> {
    fn texts(shape: &Shape, part: &str, found: &mut Vec<(f32, usize)>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| texts(shape, part, found)),
            Shape::Text(text) if text.galley.text().contains(part) => found.push((text.pos.x, text.galley.rows.len())),
            _ => {}
        }
    }
    let mut found = Vec::new();
    harness.output().shapes.iter().for_each(|clipped| texts(&clipped.shape, part, &mut found));
    found
}

/// At the panel's own width, the line once had the time, too, and wrapped.
#[test]
fn the_radiance_of_a_pixel_is_one_line() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Probe");
    press(&mut harness, "Centre of the image");
    let lines: Vec<usize> = painted_texts(&harness, "; exposure ").into_iter().map(|(_, lines)| lines).collect();
    assert_eq!(lines, [1]);
    // The time is that of the view, beside the pixel.
    assert_eq!(painted_texts(&harness, "2017-05-17T00:00:00").len(), 1);
}

/// They once wrapped to two lines, and stayed where they were while their columns scrolled sideways.
#[test]
fn the_headings_of_the_probe_are_one_line_above_their_columns() {
    let worker = InlineWorker::new(session());
    let mut interface = interface_at_saturn();
    interface.settings.panels.wide_width = Some(400.0);
    let mut harness = harness(&worker, interface);
    open_shader_page(&mut harness, "Probe");
    press(&mut harness, "Centre of the image");
    let headings_and_row = |harness: &Harness<'_, Interface>| {
        let [headings, rows] = ["f64 difference", "colour red"].map(|part| painted_texts(harness, part));
        assert_eq!((headings.len(), rows.len()), (1, 1), "{headings:?} {rows:?}");
        assert_eq!([headings[0].1, rows[0].1], [1, 1], "lines");
        [headings[0].0, rows[0].0]
    };
    let [headings_left, row_left] = headings_and_row(&harness);
    assert!((headings_left - row_left).abs() < 1.5, "{headings_left} {row_left}");
    let row = harness.query_all_by_label_contains("colour red").next().expect("a row").rect();
    harness.hover_at(row.left_center() + vec2(40.0, 0.0));
    harness.run_steps(2);
    let (unit, phase, source) = (MouseWheelUnit::Point, TouchPhase::Move, MouseWheelSource::Wheel);
    harness.event(Event::MouseWheel { unit, delta: vec2(-90.0, 0.0), phase, source, modifiers: Modifiers::NONE });
    harness.run_steps(12);
    let [headings_left, scrolled_left] = headings_and_row(&harness);
    assert!(scrolled_left < row_left - 30.0, "the rows do not scroll sideways: {row_left}, then {scrolled_left}");
    assert!((headings_left - scrolled_left).abs() < 1.5, "{headings_left} {scrolled_left}");
}

/// A click on a heading sorts the uniforms by that column; another click reverses the order.
#[test]
fn uniforms_are_sorted_by_a_click_on_a_heading() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Values");
    // The names below the heading, from top to bottom, and not those of the textures.
    let names = |harness: &Harness<'_, Interface>| {
        let left = harness.get_by_role_and_label(Role::Button, "name").rect().left();
        let bottom = harness.get_by_label_contains("Textures:").rect().top();
        let labels = harness.query_all_by_role(Role::Label).filter(|n| (n.rect().left() - left).abs() < 2.0 && n.rect().top() < bottom);
        let mut rows: Vec<(f32, String)> = labels.filter_map(|n| Some((n.rect().top(), n.accesskit_node().value()?))).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        rows.into_iter().map(|(_, name)| name).collect::<Vec<String>>()
    };
    let by_offset = names(&harness);
    assert!(by_offset.len() > 10 && !by_offset.is_sorted(), "{by_offset:?}");
    let widths = |harness: &Harness<'_, Interface>| {
        ["offset", "name"].map(|title| harness.get_by_role_and_label(Role::Button, title).rect().width())
    };
    let [width_of_sorted, width_of_unsorted] = widths(&harness);
    for is_descending in [false, true] {
        harness.get_by_role_and_label(Role::Button, "name").click();
        harness.run_steps(6);
        // A heading keeps its width whether it has an arrow or not.
        let [offset, name] = widths(&harness);
        assert!((offset - width_of_sorted).abs() < 1.0 && (name - width_of_unsorted).abs() < 1.0, "{offset} {name}");
        let mut by_name = names(&harness);
        if is_descending {
            by_name.reverse();
        }
        assert!(by_name.len() > 10 && by_name.is_sorted(), "{by_name:?}");
    }
}

/// A click may move by a few points. At a scale that is not whole, the last point of the image was beyond its last pixel, and nothing was inspected.
#[test]
fn the_pixel_that_was_pressed_is_inspected() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Probe");
    let pixel = |harness: &Harness<'_, Interface>| {
        ["Pixels from the left", "Pixels from the top"].map(|name| harness.query_by_label(name)?.accesskit_node().numeric_value())
    };
    let button = |pos, pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    let click = |harness: &mut Harness<'_, Interface>, pos: egui::Pos2, moved: egui::Vec2| {
        for event in [Event::PointerMoved(pos), button(pos, true), Event::PointerMoved(pos + moved), button(pos + moved, false)] {
            harness.event(event);
        }
        harness.run_steps(6);
    };
    let sky = |harness: &Harness<'_, Interface>| harness.get_by_label_contains("The sky:").rect();
    let place = sky(&harness);
    let offset = vec2(100.5, 80.5);
    click(&mut harness, place.min + offset, vec2(3.0, 2.0));
    assert_eq!(pixel(&harness), [Some(100.0), Some(80.0)]);
    for scale in [1.1, 1.3, 1.7] {
        harness.state_mut().settings.ui_scale = scale;
        harness.run_steps(8);
        assert_eq!(harness.ctx.pixels_per_point(), scale);
        let place = sky(&harness);
        click(&mut harness, place.max - vec2(0.01, 0.01), vec2(0.0, 0.0));
        let size_px = place.size() * scale;
        for (inspected, size_px) in pixel(&harness).into_iter().zip([size_px.x, size_px.y]) {
            assert!(inspected.is_some_and(|px| (px - f64::from(size_px)).abs() < 2.5), "{scale}: {inspected:?} of {size_px}");
        }
    }
}

/// The values of a pixel that the smaller image does not have would never be computed.
#[test]
fn a_pixel_outside_the_image_of_a_smaller_window_is_not_inspected() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Probe");
    press(&mut harness, "Centre of the image");
    let has_values = |harness: &Harness<'_, Interface>| !names_containing(harness, "f64 difference").is_empty();
    assert!(has_values(&harness));
    // The old centre lies below the lower edge.
    harness.set_size(vec2(1280.0, 340.0));
    harness.run_steps(12);
    assert!(!has_values(&harness) && harness.query_by_label("Centre of the image").is_some());
    harness.set_size(vec2(1280.0, 800.0));
    harness.run_steps(12);
    assert!(has_values(&harness), "the pixel is inside again");
}

#[test]
fn two_variants_are_drawn_and_compared() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    harness.state_mut().tab = Some(Tab::Compare);
    harness.run_steps(8);
    let metrics = names_containing(&harness, "PSNR");
    // The variants compared at first are draft and reference.
    assert_eq!(metrics.len(), 1, "there must be one line of metrics");
    assert!(!metrics[0].contains("infinite"), "draft and reference do not differ: {}", metrics[0]);
    // The same variant on both sides: no difference at all.
    harness.get_all_by_label("draft").nth(1).expect("the right side's").click();
    harness.run_steps(8);
    let metrics = names_containing(&harness, "PSNR");
    assert!(metrics[0].contains("mean 0.0000") && metrics[0].contains("infinite"), "{}", metrics[0]);
}

/// After a mistake in the effects of a variant, the last pair stays under the names of its own variants and is marked as such.
#[test]
fn after_a_mistake_the_last_pair_keeps_its_names() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    harness.state_mut().tab = Some(Tab::Compare);
    harness.run_steps(8);
    let type_effects = |harness: &mut Harness<'_, Interface>, text: &str| {
        let field = "Right: effects in addition to those of the view";
        harness.get_by_role_and_label(Role::TextInput, field).focus();
        harness.run_steps(1);
        harness.get_by_role_and_label(Role::TextInput, field).type_text(text);
        harness.run_steps(8);
        ["to the left of the divider", "PSNR", "are still those of", "is not known"].map(|part| names_containing(harness, part))
    };
    let [images, numbers, marks, errors] = type_effects(&mut harness, "-rings");
    assert_eq!(images, ["draft to the left of the divider, reference -rings to the right"]);
    assert!(numbers.len() == 1 && marks.is_empty() && errors.is_empty(), "{numbers:?} {marks:?} {errors:?}");
    let [images_after, numbers_after, marks, errors] = type_effects(&mut harness, ",+nonsense");
    assert_eq!((images_after, numbers_after), (images, numbers));
    assert!(marks == ["Images and numbers are still those of draft and reference -rings."] && !errors.is_empty(), "{marks:?} {errors:?}");
}

/// Stored answers are asked for again once the fragments have changed, although the view is the same.
#[test]
fn after_an_edit_of_a_fragment_pixel_and_comparison_are_computed_again() {
    let cache = tempfile::tempdir().expect("a temporary folder");
    let sources = Sources { cache: Some(cache.path().to_owned()), ..Sources::default() };
    let session = Session::open(&sources, |line| panic!("{line}")).expect("a session");
    let worker = InlineWorker::new(&session);
    let mut harness = harness(&worker, interface_at_saturn());
    // Half of the sunlight that Saturn reflects.
    let (path, text) = FRAGMENTS.iter().find(|(path, _)| *path == "lib/photometry/lambert.wesl").expect("a fragment");
    let darker = text.replacen("return ", "return 0.5 * ", 1);
    assert_ne!(*text, darker);
    open_shader_page(&mut harness, "Probe");
    press(&mut harness, "Centre of the image");
    let before = names_containing(&harness, "; exposure ");
    assert!(!before.is_empty(), "no radiance of the pixel");
    harness.run_steps(4);
    assert_eq!(names_containing(&harness, "; exposure "), before, "without an edit");
    session.set_fragments(Fragments::with_files([((*path).to_owned(), darker)]));
    harness.run_steps(8);
    let after = names_containing(&harness, "; exposure ");
    assert!(!after.is_empty() && after != before, "{before:?} {after:?}");
    harness.state_mut().tab = Some(Tab::Compare);
    harness.run_steps(8);
    let before = names_containing(&harness, "PSNR");
    assert_eq!(before.len(), 1, "one line of metrics: {before:?}");
    session.set_fragments(Fragments::default());
    harness.run_steps(8);
    let after = names_containing(&harness, "PSNR");
    assert!(after.len() == 1 && after != before, "{before:?} {after:?}");
}

#[test]
fn an_invalid_fragment_on_disk_is_shown_with_its_error_until_it_is_repaired() {
    let (cache, folder) = (tempfile::tempdir().expect("a temporary folder"), tempfile::tempdir().expect("a temporary folder"));
    let sources = Sources { cache: Some(cache.path().to_owned()), ..Sources::default() };
    let session = Session::open(&sources, |line| panic!("{line}")).expect("a session");
    // The generator digest, which depends on the fragments.
    let built_in_digest = session.library().generator_digest();
    assert!(
        ShaderWatcher::open(folder.path(), &session).is_err_and(|e| e.to_string().contains("no *.wesl")),
        "an empty folder is accepted"
    );
    let (path, text) = FRAGMENTS.iter().find(|(path, _)| *path == "lib/draw.wesl").expect("a fragment");
    let file = folder.path().join(path);
    std::fs::create_dir_all(file.parent().expect("a parent")).expect("made");
    std::fs::write(&file, text).expect("written");
    let watcher = ShaderWatcher::open(folder.path(), &session).expect("reads");
    assert_eq!(session.library().generator_digest(), built_in_digest, "the same text has another digest");
    let worker = InlineWorker::new(&session);
    let mut harness = harness(&worker, interface_at_saturn());
    // The drawing time identifies the image.
    let image_ms = harness.state().shown().expect("an image").render_ms;
    // Invalid WGSL.
    std::fs::write(&file, format!("{text}\nfn broken( {{\n")).expect("written");
    watcher.check_files(&worker);
    assert_ne!(session.library().generator_digest(), built_in_digest);
    harness.state_mut().tab = Some(Tab::Shader);
    harness.run_steps(8);
    assert_eq!(harness.state().shown().expect("the last good image").render_ms, image_ms);
    assert!(harness.state().message_line().contains(path), "{}", harness.state().message_line());
    let labels = names_containing(&harness, "fn broken( {");
    assert!(labels.iter().any(|t| t.contains('^') && t.contains(path)), "no source with a caret: {labels:?}");
    // Repaired.
    std::fs::write(&file, format!("{text}\n// repaired\n")).expect("written");
    watcher.check_files(&worker);
    harness.run_steps(8);
    assert!(harness.state().message_line().is_empty(), "{}", harness.state().message_line());
    assert!(names_containing(&harness, "fn broken( {").is_empty());
}

/// While an editor saves a file, the folder may be without it for an instant: that is not reported.
#[test]
fn a_folder_that_stays_without_fragments_is_reported_once() {
    let (cache, folder) = (tempfile::tempdir().expect("a temporary folder"), tempfile::tempdir().expect("a temporary folder"));
    let sources = Sources { cache: Some(cache.path().to_owned()), ..Sources::default() };
    let lines = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&lines);
    let session = Session::open(&sources, move |line| {
        noted.lock().unwrap_or_else(PoisonError::into_inner).push(line.to_owned());
    })
    .expect("a session");
    let reported = || lines.lock().unwrap_or_else(PoisonError::into_inner).iter().filter(|line: &&String| line.contains("*.wesl")).count();
    let (path, text) = FRAGMENTS.iter().find(|(path, _)| *path == "lib/draw.wesl").expect("a fragment");
    let file = folder.path().join(path);
    std::fs::create_dir_all(file.parent().expect("a parent")).expect("made");
    std::fs::write(&file, text).expect("written");
    let watcher = ShaderWatcher::open(folder.path(), &session).expect("reads");
    let worker = InlineWorker::new(&session);
    let mut expected = 0;
    for checks_without in [1, 4, 1, 2] {
        std::fs::remove_file(&file).expect("removed");
        for _ in 0..checks_without {
            watcher.check_files(&worker);
        }
        expected += usize::from(checks_without > 1);
        assert_eq!(reported(), expected, "after {checks_without} checks");
        std::fs::write(&file, text).expect("written");
        watcher.check_files(&worker);
    }
    // Another error is reported, too.
    std::fs::remove_file(&file).expect("removed");
    watcher.check_files(&worker);
    watcher.check_files(&worker);
    std::fs::write(file.with_extension("wgsl"), text).expect("written");
    watcher.check_files(&worker);
    watcher.check_files(&worker);
    assert_eq!(reported(), expected + 2);
}

/// Answers at most one question per frame.
struct SlowWorker {
    inline: InlineWorker<'static>,
    tasks: Mutex<VecDeque<Task>>,
}

impl RenderWorker for SlowWorker {
    fn session(&self) -> &Session {
        self.inline.session()
    }
    fn submit(&self, job: RenderJob) {
        self.inline.submit(job);
    }
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        let task = self.tasks.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
        if let Some(task) = task {
            self.inline.run(task);
        }
        self.inline.take()
    }
    fn run(&self, task: Task) {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner).push_back(task);
    }
}

#[test]
fn the_summary_of_a_changed_key_waits_for_the_comparison_of_its_lines() {
    let worker = SlowWorker { inline: InlineWorker::new(session()), tasks: Mutex::default() };
    let mut harness = Harness::builder()
        .with_size(vec2(1280.0, 800.0))
        .build_ui_state(|ui, interface: &mut Interface| interface.ui(ui, &worker), interface_at_saturn());
    harness.run_steps(12);
    for text in ["/", "lambert.albedo.sun1.ellipsoid"] {
        harness.event(Event::Text(text.into()));
        harness.run_steps(2);
    }
    harness.key_press(egui::Key::Enter);
    let mut is_compared = false;
    for _ in 0..60 {
        harness.run_steps(1);
        let gap = names_containing(&harness, "this key: ;");
        assert!(gap.is_empty(), "{gap:?}");
        is_compared |= !names_containing(&harness, "features differ").is_empty();
    }
    assert!(is_compared, "the lines were not compared");
}

/// The error stayed below a text that had been changed since.
#[test]
fn the_error_in_a_typed_key_ends_when_the_text_changes() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Key");
    let type_key = |harness: &mut Harness<'_, Interface>, text: &str| {
        harness.get_by_role_and_label(Role::TextInput, "Another key").focus();
        harness.run_steps(1);
        harness.event(Event::Text(text.into()));
        harness.run_steps(2);
        names_containing(harness, "nonsense").len()
    };
    // The text of the field is one of the names.
    assert_eq!(type_key(&mut harness, "nonsense"), 1);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    assert!(names_containing(&harness, "nonsense").len() > 1, "no error is shown");
    assert_eq!(type_key(&mut harness, "x"), 1);
}

/// After a key was pinned, nothing said where keys are compared, and a pin with another key looked like an empty one.
#[test]
fn pinned_keys_are_marked_and_the_comparison_is_one_click_away() {
    let worker = InlineWorker::new(session());
    let mut harness = harness(&worker, interface_at_saturn());
    open_shader_page(&mut harness, "Source");
    assert!(harness.query_by_label("Compare keys").is_none());
    press(&mut harness, "globe");
    press(&mut harness, "Pin A");
    harness.get_by_label("Compare keys");
    press(&mut harness, "Gallery");
    harness.get_by_label("this key (pinned: A)");
    press(&mut harness, "ring");
    // The key of the globe is still pinned.
    assert!(harness.query_by_label("Pin A").is_none() && harness.query_by_label("Replace A").is_some());
    press(&mut harness, "Pin B");
    press(&mut harness, "Compare keys");
    for pin in ["A is pinned:", "B is pinned:"] {
        harness.get_by_label(pin);
    }
    assert!(harness.query_by_label("Compare keys").is_none(), "the page Key is open");
}
