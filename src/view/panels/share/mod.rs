//! The Share panel: links, view files, bookmarks, images, sequences of images and animations; also settings of the window's appearance.
//!
//! In: the view, a typed or pasted link, file names. Out: files, a link in the clipboard, bookmarks, actions that show a view, settings. Always: no
//! existing file is overwritten; exports continue when the panel is closed. Not here: drawing and writing of images (`export`).

pub mod dialog;
mod export;
mod images;

use self::dialog::FileField;
use self::export::{Export, FrameViews, ImageOptions};
use super::Interface;
use super::icons::{self, Icon};
use super::number_field::{self, NumberKind};
use crate::files::{FileAccess, read_text, write_new};
use crate::session::Session;
use crate::view::app::file_names::{absolute_path, candidate_names};
use crate::view::app::settings::{Bookmark, UI_SCALE_RANGE};
use crate::view::app::view_state::ViewState;
use crate::view::app::viewer::Action;
use crate::view::error_texts::error_text;
use crate::view::language::{Language, text};
use crate::view::link::{MAX_BYTES, SCHEME, view_from_text};
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use egui::{Id, TextEdit, UiBuilder};
use std::io::Write;
use std::path::{Path, PathBuf};

/// State of the Share panel.
pub(crate) struct SharePanel {
    /// The text in the field for a link.
    typed_link: String,
    /// The name of the view file.
    view_file_name: String,
    /// The name for a new bookmark.
    bookmark_name: String,
    /// The bookmark that was removed last, and its place in the list.
    removed_bookmark: Option<(usize, Bookmark)>,
    /// The name of the image file. For the files of a sequence, it may contain a placeholder for the frame number.
    image_file_name: String,
    image_options: ImageOptions,
    /// Number of frames of a sequence or animation.
    frame_count: u32,
    /// Displayed time between two frames, seconds; negative to go back in time.
    step_s: f64,
    /// Whether the frames span the chosen event while the displayed time is near this event; `step_s` then has no effect.
    wants_event_span: bool,
    animation: Animation,
    /// The image that is being drawn and written.
    saving: Option<Pending<Result<PathBuf, String>>>,
    /// The sequence or animation that is being drawn and written.
    export: Option<Export>,
    /// Whether the user has asked to quit during this export, which would lose the rest of it.
    quit_refused: bool,
    /// The open file dialog.
    dialog: Option<dialog::OpenDialog>,
    /// Whether the user has asked to save an image, which [`update`] starts.
    pub wants_image: bool,
    /// The export for which the user has asked, which [`update`] starts.
    requested_export: Option<ExportKind>,
}

/// Settings of an animation.
struct Animation {
    file_name: String,
    options: ImageOptions,
    frames_per_s: u32,
    /// Whether the displayed time is in the middle of the animation; otherwise it is at the start.
    is_centred_on_displayed_time: bool,
}

/// What to export.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ExportKind {
    Sequence,
    Animation,
    Tour,
}

impl Default for SharePanel {
    fn default() -> Self {
        Self {
            typed_link: String::new(),
            view_file_name: "view.json".into(),
            bookmark_name: String::new(),
            removed_bookmark: None,
            image_file_name: "orrery.png".into(),
            image_options: ImageOptions { size_px: [1920, 1080], has_labels: false },
            frame_count: 60,
            step_s: 60.0,
            wants_event_span: false,
            animation: Animation {
                file_name: "orrery.gif".into(),
                options: ImageOptions { size_px: [640, 360], has_labels: false },
                frames_per_s: 25,
                is_centred_on_displayed_time: true,
            },
            saving: None,
            export: None,
            quit_refused: false,
            dialog: None,
            wants_image: false,
            requested_export: None,
        }
    }
}

impl SharePanel {
    /// Whether an image, a sequence or an animation is being drawn and written.
    pub(crate) fn is_busy(&self) -> bool {
        self.saving.is_some() || self.export.is_some()
    }

    /// Whether the program may quit: during an export only at the second request.
    pub(super) fn may_quit(&mut self) -> bool {
        self.export.is_none() || std::mem::replace(&mut self.quit_refused, true)
    }

    /// Requests an animation of the current tour.
    pub(crate) fn record_tour(&mut self) {
        self.requested_export = Some(ExportKind::Tour);
    }
}

pub(crate) fn panel(interface: &mut Interface, ui: &mut egui::Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
    links(interface, ui, worker.session(), actions);
    ui.separator();
    images::single_image(interface, ui);
    ui.separator();
    images::frames(interface, ui);
    section(ui, "animation", |ui| images::animation(interface, ui));
    images::progress(interface, ui);
    ui.separator();
    section(ui, "bookmarks", |ui| bookmarks(interface, ui, actions));
    ui.separator();
    section(ui, "appearance", |ui| appearance(interface, ui));
}

/// Shows controls below others that come and go by themselves, such as the progress of an export. egui numbers controls from the top, so that a field would
/// lose the focus, and what is typed next would act as shortcuts. These controls are numbered on their own.
fn section(ui: &mut egui::Ui, name: &str, add_contents: impl FnOnce(&mut egui::Ui)) {
    ui.scope_builder(UiBuilder::new().scope_id(Id::unique(("section of Share", name))), add_contents);
}

/// Shows the controls for links and view files.
fn links(interface: &mut Interface, ui: &mut egui::Ui, session: &Session, actions: &mut Vec<Action>) {
    ui.strong(text!("share-view"));
    let link = interface.viewer.shareable_view().to_link();
    ui.horizontal(|ui| {
        let copy = icons::button(ui, Icon::Link, text!("share-copy-link"));
        if ui.add(copy).on_hover_text(text!("share-copy-link-hint")).clicked() {
            ui.ctx().copy_text(link.clone());
            interface.show_reply(text!("link-copied"));
        }
        ui.add(egui::Label::new(egui::RichText::new(&link).small().weak()).truncate());
    });
    ui.horizontal_wrapped(|ui| {
        let field = ui.add(TextEdit::singleline(&mut interface.share.typed_link).hint_text(SCHEME).desired_width(200.0));
        let enter_pressed = is_entered(&field.on_hover_text(text!("share-link-field")), &interface.share.typed_link);
        if ui.button(text!("share-open-link")).on_hover_text(text!("share-open-link-hint")).clicked() || enter_pressed {
            let read = view_from_text(&interface.share.typed_link, session, interface.viewer.now()).map_err(|e| error_text(&e));
            show_or_report(interface, read, actions);
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.add(TextEdit::singleline(&mut interface.share.view_file_name).desired_width(140.0)).on_hover_text(text!("share-view-file"));
        dialog::button(interface, ui, FileField::View);
        let path = PathBuf::from(&interface.share.view_file_name);
        if ui.button(text!("share-save-view")).on_hover_text(text!("share-save-view-hint")).clicked() {
            let json = interface.viewer.shareable_view().to_json();
            let write = |names| write_new(names, FileAccess::All, |out| out.write_all(json.as_bytes())).map_err(|e| error_text(&e));
            let names = named(&interface.share.view_file_name).and_then(|name| candidate_names(name).map_err(|e| error_text(&e)));
            let written = names.and_then(write);
            if let Ok(path) = &written {
                // The saved file may have another name than the typed one. From now on *Open view* opens the saved file.
                interface.share.view_file_name = path.display().to_string();
            }
            interface.show_reply(written.map_or_else(|why| why, |path| saved_message(&path)));
        }
        dialog::button(interface, ui, FileField::ViewToOpen);
        if ui.button(text!("share-open-view")).on_hover_text(text!("share-open-view-hint")).clicked() {
            let text = read_text(&path, MAX_BYTES).map_err(|e| error_text(&e));
            let read = text.and_then(|text| view_from_text(&text, session, interface.viewer.now()).map_err(|e| error_text(&e)));
            let read = read.map_err(|e| format!("{}: {e}", path.display()));
            let read = named(&interface.share.view_file_name).and(read);
            show_or_report(interface, read, actions);
        }
    });
}

/// The text of a field for a file's name. An empty one is refused: messages about the file would begin without a name.
pub(super) fn named(file_name: &str) -> Result<&str, String> {
    if file_name.trim().is_empty() { Err(text!("share-no-file-name").to_owned()) } else { Ok(file_name) }
}

/// Whether the user has just pressed Enter in a field with this text; false if the text is blank.
pub(super) fn is_entered(field: &egui::Response, text: &str) -> bool {
    field.lost_focus() && field.ctx.input(|i| i.key_pressed(egui::Key::Enter)) && !text.trim().is_empty()
}

/// Shows the view that was read, or replies with the error.
fn show_or_report(interface: &mut Interface, read: Result<ViewState, String>, actions: &mut Vec<Action>) {
    match read {
        Ok(view) => actions.push(Action::Show(Box::new(view))),
        Err(why) => interface.refuse_view(why),
    }
}

/// The message about a written file.
fn saved_message(path: &Path) -> String {
    text!("share-saved", file = absolute_path(path))
}

/// Starts requested exports, and takes finished images and frames. Called in every frame of the interface, even if the panel is closed.
pub(crate) fn update(interface: &mut Interface, ctx: &egui::Context, worker: &dyn RenderWorker) {
    dialog::update(interface, ctx);
    let panel = &mut interface.share;
    let (wants_image, kind) = (std::mem::take(&mut panel.wants_image), panel.requested_export.take());
    if (wants_image || kind.is_some()) && panel.is_busy() {
        interface.show_reply(text!("share-busy"));
    } else if wants_image {
        match named(&panel.image_file_name).and_then(|name| candidate_names(name).map_err(|e| error_text(&e))) {
            Ok(files) => {
                let (view, options) = (interface.viewer.shareable_view(), panel.image_options);
                panel.saving = Some(ask(worker, move |session| export::save(session, &view, options, files)));
                interface.show_reply(text!("share-saving", width = options.size_px[0], height = options.size_px[1]));
            }
            Err(why) => interface.show_reply(why),
        }
    } else if let Some(kind) = kind {
        match new_export(interface, kind) {
            Ok(export) => {
                interface.share.export = Some(export.start(worker, interface.viewport.frame_start_s));
                interface.share.quit_refused = false;
            }
            Err(why) => interface.show_reply(why),
        }
    }
    if let Some(written) = interface.share.saving.as_ref().and_then(Pending::take) {
        interface.share.saving = None;
        interface.show_reply(written.map_or_else(|why| why, |path| saved_message(&path)));
    }
    if let Some((message, is_over)) = interface.share.export.as_mut().and_then(|export| export.poll(worker, saved_message)) {
        let repeats_quit_warning = interface.share.quit_refused && !is_over;
        interface.show_reply(if repeats_quit_warning { format!("{message}\n{}", text!("export-quit")) } else { message });
        if is_over {
            interface.share.export = None;
        }
    }
}

/// An export with the panel's settings, not started yet.
fn new_export(interface: &Interface, kind: ExportKind) -> Result<Export, String> {
    let panel = &interface.share;
    let Animation { file_name, options, frames_per_s, is_centred_on_displayed_time } = &panel.animation;
    let view = interface.viewer.shareable_view();
    let event_playback = images::chosen_playback(interface);
    // If the frames are to span an event: its frames. Otherwise frames from the given time on, at the panel's interval.
    let frames_from = |tdb_s: f64| match event_playback {
        Some(playback) => FrameViews::Event { view: Box::new(view.clone()), playback, frame_count: panel.frame_count },
        None => FrameViews::Steps { view: Box::new(ViewState { tdb_s, ..view.clone() }), step_s: panel.step_s },
    };
    match kind {
        ExportKind::Sequence => {
            let file_name = named(&panel.image_file_name)?;
            Export::sequence(frames_from(view.tdb_s), file_name, panel.frame_count, panel.image_options)
        }
        ExportKind::Animation => {
            let start_to_displayed_s =
                if *is_centred_on_displayed_time { 0.5 * f64::from(panel.frame_count - 1) * panel.step_s } else { 0.0 };
            let views = frames_from(view.tdb_s - start_to_displayed_s);
            Export::animation(views, named(file_name)?, panel.frame_count, *frames_per_s, *options)
        }
        ExportKind::Tour => {
            let tour = interface.tour.current_tour().ok_or(text!("share-no-tour"))?;
            let frame_count = ((tour.length_s() * f64::from(*frames_per_s)).ceil() as u32).max(1);
            Export::animation(
                FrameViews::Tour { tour, frames_per_s: *frames_per_s, quality: view.quality },
                named(file_name)?,
                frame_count,
                *frames_per_s,
                *options,
            )
        }
    }
}

/// Shows the bookmarks, a field that adds one, and the recent views.
fn bookmarks(interface: &mut Interface, ui: &mut egui::Ui, actions: &mut Vec<Action>) {
    ui.strong(text!("bookmarks"));
    let default_name = interface.name_of_view(&interface.viewer.view_after_flight());
    ui.horizontal_wrapped(|ui| {
        let field = ui.add(TextEdit::singleline(&mut interface.share.bookmark_name).hint_text(&default_name).desired_width(210.0));
        let enter_pressed = is_entered(&field.on_hover_text(text!("bookmarks-name")), &interface.share.bookmark_name);
        let add = icons::button(ui, Icon::Bookmark, text!("bookmarks-add"));
        if ui.add(add).on_hover_text(text!("bookmarks-add-hint")).clicked() || enter_pressed {
            let typed = std::mem::take(&mut interface.share.bookmark_name);
            let name = if typed.trim().is_empty() { default_name.clone() } else { typed.trim().to_owned() };
            interface.settings.bookmarks.push(Bookmark { name, view: interface.viewer.shareable_view() });
        }
    });
    let mut removed_index = None;
    for (i, bookmark) in interface.settings.bookmarks.iter().enumerate() {
        ui.horizontal_wrapped(|ui| {
            if ui.button(&bookmark.name).on_hover_text(text!("bookmarks-show-hint")).clicked() {
                actions.push(Action::Show(Box::new(bookmark.view.clone())));
            }
            let name = text!("bookmarks-remove", name = bookmark.name);
            if icons::icon_button(ui, Icon::Close, &name).on_hover_text(&name).clicked() {
                removed_index = Some(i);
            }
        });
    }
    if let Some(i) = removed_index {
        interface.share.removed_bookmark = Some((i, interface.settings.bookmarks.remove(i)));
    }
    restore_button(interface, ui);
    ui.collapsing(text!("recent-views"), |ui| {
        for recent in &interface.settings.recent {
            if ui.button(&recent.name).on_hover_text(text!("bookmarks-show-hint")).clicked() {
                actions.push(Action::Show(Box::new(recent.view.clone())));
            }
        }
    });
}

/// Shows a button that brings back the bookmark that was removed last.
fn restore_button(interface: &mut Interface, ui: &mut egui::Ui) {
    let Some((_, removed)) = &interface.share.removed_bookmark else { return };
    let name = text!("bookmarks-restore", name = removed.name);
    let is_clicked = ui.horizontal_wrapped(|ui| ui.button(name).on_hover_text(text!("bookmarks-restore-hint")).clicked()).inner;
    if is_clicked && let Some((index, bookmark)) = interface.share.removed_bookmark.take() {
        let bookmarks = &mut interface.settings.bookmarks;
        bookmarks.insert(index.min(bookmarks.len()), bookmark);
    }
}

/// Shows the settings of the window's appearance.
fn appearance(interface: &mut Interface, ui: &mut egui::Ui) {
    ui.strong(text!("appearance"));
    ui.horizontal(|ui| {
        for (name, dark) in
            [(text!("appearance-dark"), Some(true)), (text!("appearance-light"), Some(false)), (text!("appearance-system"), None)]
        {
            ui.selectable_value(&mut interface.settings.dark, dark, name).on_hover_text(text!("appearance-colours-hint"));
        }
    });
    ui.checkbox(&mut interface.settings.is_red, text!("appearance-red")).on_hover_text(text!("appearance-red-hint"));
    ui.horizontal(|ui| {
        ui.label(text!("appearance-language"));
        for language in Language::ALL {
            let choice = ui.selectable_value(&mut interface.language, language, language.own_name());
            if choice.on_hover_text(text!("appearance-language-hint")).clicked() {
                interface.settings.language = Some(language);
            }
        }
    });
    let text_size = number_field::slider(&mut interface.settings.ui_scale, NumberKind::Plain, UI_SCALE_RANGE, |slider| {
        slider.text(text!("appearance-text-size"))
    });
    ui.add(text_size).on_hover_text(text!("appearance-text-size-hint"));
    ui.horizontal(|ui| {
        ui.label(text!("appearance-panels"));
        for (name, on_left) in [(text!("appearance-left"), true), (text!("appearance-right"), false)] {
            ui.selectable_value(&mut interface.settings.panels.on_left, on_left, name).on_hover_text(text!("appearance-side-hint"));
        }
    });
}
