//! Keeping and sharing: links, files, bookmarks, pictures, sequences of frames.
//!
//! In: the view, names of files. Out: files, and where they are. Always: no file that exists is written over; what was begun goes on when the panel is closed.

use super::{Interface, accessible};
use crate::files::{FileAccess, read_text, write_new};
use crate::render::plan::SamplingQuality;
use crate::scene::legend::legend_of;
use crate::scene::request::{Purpose, ViewRequest};
use crate::session::{PROVENANCE_CHUNK, Session, is_exr, write_new_picture};
use crate::view::app::file_names::{NumberedName, free_names, whole};
use crate::view::app::settings::{Bookmark, ZOOMS};
use crate::view::app::view_state::ViewState;
use crate::view::app::viewer::Action;
use crate::view::link::{MAX_BYTES, SCHEME, restored};
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use egui::{DragValue, ProgressBar, ScrollArea, TextEdit};
use std::io::Write;
use std::path::{Path, PathBuf};

pub struct SharePanel {
    link: String,
    file: String,
    bookmark: String,
    picture: String,
    size: [u32; 2],
    frames: u32,
    step_s: f64,
    /// Pictures have the names of bodies in them.
    names: bool,
    shot: Option<Pending<Result<PathBuf, String>>>,
    run: Option<Run>,
    /// A picture was asked for.
    pub wants_picture: bool,
    wants_sequence: bool,
}

impl Default for SharePanel {
    fn default() -> Self {
        Self {
            link: String::new(),
            file: "view.json".into(),
            bookmark: String::new(),
            picture: "orrery.png".into(),
            size: [1920, 1080],
            frames: 100,
            step_s: 60.0,
            names: false,
            shot: None,
            run: None,
            wants_picture: false,
            wants_sequence: false,
        }
    }
}

/// A sequence of frames on its way to files.
struct Run {
    view: ViewState,
    files: NumberedName,
    size: [u32; 2],
    names: bool,
    step_s: f64,
    done: u32,
    frames: u32,
    frame: Pending<Result<PathBuf, String>>,
}

impl SharePanel {
    /// A picture or a run is being made.
    pub fn is_busy(&self) -> bool {
        self.shot.is_some() || self.run.is_some()
    }
}

pub fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        links(interface, ui, worker.session(), actions);
        ui.separator();
        pictures(interface, ui);
        ui.separator();
        bookmarks(interface, ui, actions);
        ui.separator();
        appearance(interface, ui);
    });
}

fn links(interface: &mut Interface, ui: &mut egui::Ui, session: &Session, actions: &mut Vec<Action>) {
    ui.strong("This view");
    let link = interface.viewer.shared().to_link();
    ui.horizontal(|ui| {
        if ui.button("Copy link").on_hover_text("Copy a link that restores this view").clicked() {
            ui.ctx().copy_text(link.clone());
            interface.message = "Link copied".into();
        }
        ui.add(egui::Label::new(egui::RichText::new(&link).small().weak()).truncate());
    });
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.link).hint_text(SCHEME).desired_width(200.0)).on_hover_text("A link to open");
        if ui.button("Open link").on_hover_text("Show the view of the link in the field").clicked() {
            let read = restored(&interface.share.link, session, interface.viewer.now()).map_err(|e| e.to_string());
            opened(interface, read, actions);
        }
    });
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.file).desired_width(140.0)).on_hover_text("View file");
        let path = PathBuf::from(&interface.share.file);
        if ui.button("Save view").on_hover_text("Write this view to the file; the next free number is added to its name").clicked() {
            let text = interface.viewer.shared().to_json();
            let write = |names| write_new(names, FileAccess::All, |out| out.write_all(text.as_bytes())).map_err(|e| e.to_string());
            let written = free_names(&interface.share.file).map_err(|e| e.to_string()).and_then(write);
            if let Ok(path) = &written {
                // What was saved is what *Open view* opens.
                interface.share.file = path.display().to_string();
            }
            interface.message = written.map_or_else(|why| why, |path| saved(&path));
        }
        if ui.button("Open view").on_hover_text("Show the view of the file").clicked() {
            let text = read_text(&path, MAX_BYTES).map_err(|e| e.to_string());
            let read = text.and_then(|text| restored(&text, session, interface.viewer.now()).map_err(|e| e.to_string()));
            opened(interface, read.map_err(|e| format!("{}: {e}", path.display())), actions);
        }
    });
}

fn opened(interface: &mut Interface, read: Result<ViewState, String>, actions: &mut Vec<Action>) {
    match read {
        Ok(view) => actions.push(Action::Show(Box::new(view))),
        Err(why) => interface.message = why,
    }
}

fn saved(path: &Path) -> String {
    format!("Saved {}", whole(path))
}

fn pictures(interface: &mut Interface, ui: &mut egui::Ui) {
    let panel = &mut interface.share;
    ui.strong("Images");
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut panel.picture).desired_width(150.0))
            .on_hover_text("Image file: .png or .exr. No file is replaced: the next free number is added to the name. %05d stands for the frame number of a sequence");
        accessible::number(ui, side(&mut panel.size[0]), "Width, pixels");
        ui.label("x");
        accessible::number(ui, side(&mut panel.size[1]), "Height, pixels");
        ui.checkbox(&mut panel.names, "Labels").on_hover_text("Draw names and markers of bodies into saved images");
    });
    let folder =
        whole(Path::new(&panel.picture)).rsplit_once(std::path::MAIN_SEPARATOR).map_or(String::new(), |(folder, _)| folder.to_owned());
    ui.add(egui::Label::new(egui::RichText::new(format!("Folder: {folder}/")).small().weak()).truncate());
    let busy = panel.is_busy();
    if ui.add_enabled(!busy, egui::Button::new("Save image")).on_hover_text("Save an image (Ctrl+S)").clicked() {
        panel.wants_picture = true;
    }
    ui.horizontal(|ui| {
        ui.label("Sequence:");
        accessible::number(ui, DragValue::new(&mut panel.frames).range(1..=100_000), "Number of frames");
        ui.label("frames,");
        // A century at the most.
        accessible::number(ui, DragValue::new(&mut panel.step_s).range(-3.2e9..=3.2e9).suffix(" s"), "Simulated seconds between frames");
        ui.label("apart");
    });
    if ui.add_enabled(!busy, egui::Button::new("Export sequence")).clicked() {
        panel.wants_sequence = true;
    }
    progress(interface, ui);
}

fn side(value: &mut u32) -> DragValue<'_> {
    DragValue::new(value).range(1..=16_384)
}

/// The sequence that is being drawn: its bar, its end.
fn progress(interface: &mut Interface, ui: &mut egui::Ui) {
    let Some(run) = &interface.share.run else { return };
    let part = run.done as f32 / run.frames.max(1) as f32;
    let cancelled = ui.horizontal(|ui| {
        ui.add(ProgressBar::new(part).desired_width(180.0).show_percentage()).accessible_name("Progress of the export");
        ui.button("Cancel").on_hover_text("Stop the export; the frames written so far stay").clicked()
    });
    if cancelled.inner {
        interface.share.run = None;
    }
}

/// Begins what was asked for and takes what is done, whether the panel is open or not.
pub fn work(interface: &mut Interface, worker: &dyn RenderWorker) {
    let panel = &mut interface.share;
    let (picture, sequence) = (std::mem::take(&mut panel.wants_picture), std::mem::take(&mut panel.wants_sequence));
    if picture && panel.is_busy() {
        interface.message = "An image is already being saved".into();
    } else if picture {
        match free_names(&panel.picture) {
            Ok(files) => {
                let (view, size, names) = (interface.viewer.shared(), panel.size, panel.names);
                panel.shot = Some(ask(worker, move |session| save(session, &view, size, names, files)));
                interface.message = format!("Saving an image of {}×{} pixels", size[0], size[1]);
            }
            Err(e) => interface.message = e.to_string(),
        }
    }
    let panel = &mut interface.share;
    if sequence && !panel.is_busy() {
        match NumberedName::of_sequence(&panel.picture, panel.frames) {
            Ok(files) => {
                let (view, size, names, step_s, frames) = (interface.viewer.shared(), panel.size, panel.names, panel.step_s, panel.frames);
                let mut run = Run { view, files, size, names, step_s, done: 0, frames, frame: Pending::default() };
                run.frame = next_frame(worker, &run);
                panel.run = Some(run);
            }
            Err(e) => interface.message = e.to_string(),
        }
    }
    if let Some(written) = interface.share.shot.as_ref().and_then(Pending::take) {
        interface.share.shot = None;
        interface.message = written.map_or_else(|why| why, |path| saved(&path));
    }
    go_on(interface, worker);
}

/// The next frame of the sequence, once the last one is written.
fn go_on(interface: &mut Interface, worker: &dyn RenderWorker) {
    let Some(mut run) = interface.share.run.take() else { return };
    match run.frame.take() {
        None => interface.share.run = Some(run),
        Some(Err(why)) => interface.message = why,
        Some(Ok(path)) => {
            run.done += 1;
            interface.message = format!("{} of {}: {}", run.done, run.frames, saved(&path));
            if run.done < run.frames {
                run.frame = next_frame(worker, &run);
                interface.share.run = Some(run);
            }
        }
    }
}

fn next_frame(worker: &dyn RenderWorker, run: &Run) -> Pending<Result<PathBuf, String>> {
    let view = ViewState { tdb_s: run.view.tdb_s + f64::from(run.done) * run.step_s, ..run.view.clone() };
    let (size, names, file) = (run.size, run.names, run.files.path(run.done));
    ask(worker, move |session| save(session, &view, size, names, std::iter::once(file)))
}

/// Draws a view and writes it under the first of the names that is free; answers which.
fn save(
    session: &Session,
    view: &ViewState,
    [width, height]: [u32; 2],
    names: bool,
    files: impl Iterator<Item = PathBuf>,
) -> Result<PathBuf, String> {
    let mut files = files.peekable();
    let path = files.peek().cloned().unwrap_or_default();
    let known = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) || is_exr(&path);
    if !known {
        return Err(format!("{}: an image file ends in .png or .exr", path.display()));
    }
    let mut request: ViewRequest = view.request(session.catalog(), session.ephemeris(), width, height).map_err(|e| e.to_string())?;
    request.layers.labels = names;
    request.purpose = Purpose::of_file(is_exr(&path));
    let drawn = session.draw_in_background(&request, SamplingQuality::of(request.quality), is_exr(&path)).map_err(|e| e.to_string())?;
    let text = vec![
        ("Title", session.catalog().body(view.target).map_or("Orrery".into(), |b| b.name.clone())),
        ("Creation Time", request.time.to_utc_iso()),
        ("Description", view.to_link()),
        ("Legend", legend_of(&drawn.scene)),
        ("Software", format!("orrery {}", env!("CARGO_PKG_VERSION"))),
        (PROVENANCE_CHUNK, session.provenance(&request).to_text()),
    ];
    let files = files.map(|file| std::path::absolute(&file).unwrap_or(file));
    write_new_picture(files, is_exr(&path), &drawn.frame, &text).map_err(|e| e.to_string())
}

fn bookmarks(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    ui.strong("Bookmarks");
    let name_now = || {
        let view = interface.viewer.settled();
        format!("{} {}", interface.viewer.name(view.target), view.time().to_utc_iso().get(..16).unwrap_or_default())
    };
    let usual = name_now();
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.bookmark).hint_text(&usual).desired_width(180.0))
            .on_hover_text("Name of the bookmark");
        if ui.button("Add bookmark").on_hover_text("Add this view to the bookmarks").clicked() {
            let typed = std::mem::take(&mut interface.share.bookmark);
            let name = if typed.trim().is_empty() { usual.clone() } else { typed.trim().to_owned() };
            interface.settings.bookmarks.push(Bookmark { name, view: interface.viewer.shared() });
        }
    });
    let mut removed = None;
    for (i, kept) in interface.settings.bookmarks.iter().enumerate() {
        ui.horizontal(|ui| {
            if ui.button(&kept.name).on_hover_text("Show this view").clicked() {
                actions.push(Action::Show(Box::new(kept.view.clone())));
            }
            if ui.small_button("×").on_hover_text(format!("Remove the bookmark {}", kept.name)).clicked() {
                removed = Some(i);
            }
        });
    }
    if let Some(i) = removed {
        interface.settings.bookmarks.remove(i);
    }
    ui.collapsing("Recent views", |ui| {
        for kept in &interface.settings.recent {
            if ui.button(&kept.name).on_hover_text("Show this view").clicked() {
                actions.push(Action::Show(Box::new(kept.view.clone())));
            }
        }
    });
}

fn appearance(interface: &mut Interface, ui: &mut egui::Ui) {
    ui.strong("Appearance");
    ui.horizontal(|ui| {
        for (name, dark) in [("Dark", Some(true)), ("Light", Some(false)), ("Follow system", None)] {
            ui.selectable_value(&mut interface.settings.dark, dark, name).on_hover_text("Colours of the panels");
        }
    });
    ui.add(egui::Slider::new(&mut interface.settings.zoom, ZOOMS).text("Text size")).on_hover_text("Size of text and controls");
}
