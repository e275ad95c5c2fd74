//! Keeping and sharing: links, files, bookmarks, screenshots, runs of frames.

use super::{Interface, named};
use crate::render::plan::Fineness;
use crate::scene::legend::legend;
use crate::scene::request::{Purpose, ViewRequest};
use crate::session::{Readers, Session, is_exr, write_picture, write_whole};
use crate::view::kept::{SCHEME, restored};
use crate::view::settings::{Bookmark, ZOOMS};
use crate::view::sight::Sight;
use crate::view::studio::{Studio, Ticket, ask};
use crate::view::viewer::Action;
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
    shot: Option<Ticket<Result<String, String>>>,
    run: Option<Run>,
    /// A picture was asked for by key.
    pub wants_picture: bool,
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
        }
    }
}

/// Frames on their way to files.
struct Run {
    sight: Sight,
    picture: String,
    size: [u32; 2],
    names: bool,
    step_s: f64,
    done: u32,
    frames: u32,
    frame: Ticket<Result<String, String>>,
}

impl SharePanel {
    /// A picture or a run is being made.
    pub fn is_busy(&self) -> bool {
        self.shot.is_some() || self.run.is_some()
    }
}

pub fn panel(interface: &mut Interface, ui: &mut egui::Ui, studio: &dyn Studio, actions: &mut Vec<Action>) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        links(interface, ui, studio.session(), actions);
        ui.separator();
        pictures(interface, ui, studio);
        ui.separator();
        bookmarks(interface, ui, actions);
        ui.separator();
        looks(interface, ui);
    });
}

fn links(interface: &mut Interface, ui: &mut egui::Ui, session: &Session, actions: &mut Vec<Action>) {
    ui.strong("This view");
    let link = interface.viewer.settled().to_link();
    ui.horizontal(|ui| {
        if ui.button("Copy link").on_hover_text("A link that restores this very view").clicked() {
            ui.ctx().copy_text(link.clone());
            interface.message = "the link is in the clipboard".into();
        }
        ui.add(egui::Label::new(egui::RichText::new(&link).small().weak()).truncate());
    });
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.link).hint_text(SCHEME).desired_width(200.0)).on_hover_text("A link to open");
        if ui.button("Open link").clicked() {
            let read = restored(&interface.share.link, session, interface.viewer.now());
            opened(interface, read, actions);
        }
    });
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.file).desired_width(140.0)).on_hover_text("File that keeps a view");
        let path = PathBuf::from(&interface.share.file);
        if ui.button("Save view").clicked() {
            let text = interface.viewer.settled().to_json();
            let written = write_whole(&path, Readers::All, |out| out.write_all(text.as_bytes()).map_err(|e| e.to_string()));
            interface.message = written.map_or_else(|why| why, |()| format!("saved as {}", path.display()));
        }
        if ui.button("Open view").clicked() {
            let text = std::fs::read_to_string(&path).map_err(|e| e.to_string());
            let read = text.and_then(|text| restored(&text, session, interface.viewer.now()));
            opened(interface, read.map_err(|e| format!("{}: {e}", path.display())), actions);
        }
    });
}

fn opened(interface: &mut Interface, read: Result<Sight, String>, actions: &mut Vec<Action>) {
    match read {
        Ok(sight) => actions.push(Action::Show(Box::new(sight))),
        Err(why) => interface.message = why,
    }
}

fn pictures(interface: &mut Interface, ui: &mut egui::Ui, studio: &dyn Studio) {
    let panel = &mut interface.share;
    ui.strong("Pictures");
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut panel.picture).desired_width(150.0))
            .on_hover_text("File, .png or .exr; %05d in it counts the frames of a run");
        named::number(ui, side(&mut panel.size[0]), "Width, pixels");
        ui.label("x");
        named::number(ui, side(&mut panel.size[1]), "Height, pixels");
        ui.checkbox(&mut panel.names, "with names").on_hover_text("Names and markers of bodies in saved pictures");
    });
    let busy = panel.is_busy();
    let asked = std::mem::take(&mut panel.wants_picture);
    if ui.add_enabled(!busy, egui::Button::new("Save picture")).clicked() || (asked && !busy) {
        let sight = interface.viewer.settled().clone();
        let (path, size, names) = (PathBuf::from(panel.picture.replace("%05d", "00000")), panel.size, panel.names);
        panel.shot = Some(ask(studio, move |session| save(session, &sight, size, names, &path)));
    }
    if let Some(said) = panel.shot.as_ref().and_then(Ticket::take) {
        panel.shot = None;
        interface.message = said.unwrap_or_else(|why| why);
    }
    let panel = &mut interface.share;
    ui.horizontal(|ui| {
        ui.label("Run of");
        named::number(ui, DragValue::new(&mut panel.frames).range(1..=100_000), "Frames of the run");
        ui.label("frames, each");
        // A century at the most.
        named::number(ui, DragValue::new(&mut panel.step_s).range(-3.2e9..=3.2e9).suffix(" s"), "Scene seconds between frames");
    });
    if ui.add_enabled(!busy, egui::Button::new("Save run")).clicked() {
        if panel.picture.contains("%05d") {
            let sight = interface.viewer.settled().clone();
            let (picture, size, step_s, frames) = (panel.picture.clone(), panel.size, panel.step_s, panel.frames);
            let mut run = Run { sight, picture, size, names: panel.names, step_s, done: 0, frames, frame: Ticket::default() };
            run.frame = next_frame(studio, &run);
            panel.run = Some(run);
        } else {
            interface.message = "a run needs %05d in the file's name, as out-%05d.png".into();
        }
    }
    progress(interface, ui, studio);
}

fn side(value: &mut u32) -> DragValue<'_> {
    DragValue::new(value).range(1..=16_384)
}

/// The running run: its bar, its next frame, its end.
fn progress(interface: &mut Interface, ui: &mut egui::Ui, studio: &dyn Studio) {
    let Some(mut run) = interface.share.run.take() else { return };
    let mut goes_on = true;
    match run.frame.take() {
        None => {}
        Some(Err(why)) => {
            interface.message = why;
            goes_on = false;
        }
        Some(Ok(said)) => {
            run.done += 1;
            interface.message = format!("{} of {}: {said}", run.done, run.frames);
            goes_on = run.done < run.frames;
            if goes_on {
                run.frame = next_frame(studio, &run);
            }
        }
    }
    ui.horizontal(|ui| {
        let bar = ProgressBar::new(run.done as f32 / run.frames.max(1) as f32).desired_width(180.0).show_percentage();
        ui.add(bar).accessible_name("Frames that are done");
        if ui.button("Cancel").on_hover_text("Frames that are done stay").clicked() {
            goes_on = false;
        }
    });
    if goes_on {
        interface.share.run = Some(run);
    }
}

fn next_frame(studio: &dyn Studio, run: &Run) -> Ticket<Result<String, String>> {
    let sight = Sight { tdb_s: run.sight.tdb_s + f64::from(run.done) * run.step_s, ..run.sight.clone() };
    let path = PathBuf::from(run.picture.replace("%05d", &format!("{:05}", run.done)));
    let (size, names) = (run.size, run.names);
    ask(studio, move |session| save(session, &sight, size, names, &path))
}

/// Draws a view and writes it; the answer is what to say.
fn save(session: &Session, sight: &Sight, [width, height]: [u32; 2], names: bool, path: &Path) -> Result<String, String> {
    let known = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) || is_exr(path);
    if !known {
        return Err(format!("{}: pictures end in .png or .exr", path.display()));
    }
    let mut request: ViewRequest = sight.request(session.catalog(), session.ephemeris(), width, height)?;
    request.layers.labels = names;
    request.purpose = Purpose::of_file(is_exr(path));
    let drawn = session.draw_aside(&request, Fineness::of(request.quality), is_exr(path)).map_err(|e| e.to_string())?;
    let text = vec![
        ("Title", session.catalog().body(sight.target).map_or("Orrery".into(), |b| b.name.clone())),
        ("Creation Time", request.time.to_utc_iso()),
        ("Description", sight.to_link()),
        ("Legend", legend(drawn.scene.pixel_view, &drawn.scene.exposure)),
        ("Software", format!("orrery {}", env!("CARGO_PKG_VERSION"))),
    ];
    write_picture(path, &drawn.frame, &text)?;
    Ok(format!("saved as {}", path.display()))
}

fn bookmarks(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    ui.strong("Bookmarks");
    let name_now = || {
        let sight = interface.viewer.settled();
        format!("{} {}", interface.viewer.name(sight.target), sight.time().to_utc_iso().get(..16).unwrap_or_default())
    };
    let usual = name_now();
    ui.horizontal(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.bookmark).hint_text(&usual).desired_width(180.0))
            .on_hover_text("Name of the bookmark");
        if ui.button("Keep").on_hover_text("Keep this view as a bookmark").clicked() {
            let typed = std::mem::take(&mut interface.share.bookmark);
            let name = if typed.trim().is_empty() { usual.clone() } else { typed.trim().to_owned() };
            interface.settings.bookmarks.push(Bookmark { name, sight: interface.viewer.settled().clone() });
        }
    });
    let mut removed = None;
    for (i, kept) in interface.settings.bookmarks.iter().enumerate() {
        ui.horizontal(|ui| {
            if ui.button(&kept.name).clicked() {
                actions.push(Action::Show(Box::new(kept.sight.clone())));
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
            if ui.button(&kept.name).clicked() {
                actions.push(Action::Show(Box::new(kept.sight.clone())));
            }
        }
    });
}

fn looks(interface: &mut Interface, ui: &mut egui::Ui) {
    ui.strong("Looks");
    ui.horizontal(|ui| {
        for (name, dark) in [("Dark", Some(true)), ("Light", Some(false)), ("As the system", None)] {
            ui.selectable_value(&mut interface.settings.dark, dark, name);
        }
    });
    ui.add(egui::Slider::new(&mut interface.settings.zoom, ZOOMS).text("size of text")).on_hover_text("Size of text and controls");
}
