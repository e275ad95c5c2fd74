//! File dialogs of the desktop, where available.
//!
//! In: the text field for a file name. Out: the chosen file's path in that field, with an extension if it is new. Always: the field also accepts a typed
//! name; without dialogs there is no button beside it. The window provides the function that opens dialogs; tests provide their own.

use crate::view::language::text;
use crate::view::panels::Interface;
use crate::view::panels::icons::{self, Icon};
use crate::view::worker::render_worker::Pending;
use egui::Ui;
use std::path::PathBuf;
use std::time::Duration;

/// What a dialog asks the user to choose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileRequest {
    pub title: &'static str,
    /// File extensions without the dot.
    pub extensions: &'static [&'static str],
    /// The file name or path that the field contains when the dialog opens.
    pub name: String,
    /// Whether the user chooses an existing file to open; otherwise the user names a file to save.
    pub is_for_opening: bool,
}

/// Opens a dialog; the result is `None` if no file was chosen or no dialog could open.
pub type FileDialog = fn(FileRequest) -> Pending<Option<PathBuf>>;

/// A text field for a file name, which a dialog can fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileField {
    /// The name of the view file to save.
    View,
    /// The same field, for a view file that exists: a dialog for saving would ask whether to replace it.
    ViewToOpen,
    Image,
    Animation,
    Tour,
}

/// An open dialog.
pub(crate) struct OpenDialog {
    field: FileField,
    answer: Pending<Option<PathBuf>>,
}

/// Interval between checks whether an open dialog has been answered.
const CHECK_INTERVAL: Duration = Duration::from_millis(100);

impl FileField {
    /// The accessible name of the button that opens the dialog.
    fn button_name(self) -> &'static str {
        match self {
            Self::View => text!("dialog-choose-view"),
            Self::ViewToOpen => text!("dialog-choose-view-to-open"),
            Self::Image => text!("dialog-choose-image"),
            Self::Animation => text!("dialog-choose-animation"),
            Self::Tour => text!("dialog-choose-tour"),
        }
    }

    /// What the dialog for this field asks for, given the file name in the field.
    fn request(self, name: &str) -> FileRequest {
        let (title, extensions, is_for_opening): (_, &'static [&'static str], _) = match self {
            Self::View => (text!("share-view-file"), &["json"], false),
            Self::ViewToOpen => (text!("share-view-file"), &["json"], true),
            Self::Image => (text!("dialog-image"), &["png", "exr"], false),
            Self::Animation => (text!("dialog-animation"), &["gif", "apng"], false),
            Self::Tour => (text!("tours-file"), &["json"], true),
        };
        FileRequest { title, extensions, name: name.to_owned(), is_for_opening }
    }

    /// The path that was chosen for this field. Not every desktop adds the extension to a new name, without which the file could not be saved.
    fn with_extension(self, path: PathBuf) -> PathBuf {
        let FileRequest { extensions, is_for_opening, .. } = self.request("");
        match extensions.first() {
            Some(extension) if !is_for_opening && path.extension().is_none() => path.with_extension(extension),
            _ => path,
        }
    }
}

/// The text of a field.
fn field_text(interface: &mut Interface, field: FileField) -> &mut String {
    match field {
        FileField::View | FileField::ViewToOpen => &mut interface.share.view_file_name,
        FileField::Image => &mut interface.share.image_file_name,
        FileField::Animation => &mut interface.share.animation.file_name,
        FileField::Tour => &mut interface.tour.file_name,
    }
}

/// Shows the button that opens a dialog for a field, if dialogs are available.
pub(crate) fn button(interface: &mut Interface, ui: &mut Ui, field: FileField) {
    let Some(open) = interface.file_dialog else { return };
    let request = field.request(field_text(interface, field));
    let name = field.button_name();
    let is_enabled = interface.share.dialog.is_none();
    let button = ui.add_enabled_ui(is_enabled, |ui| icons::icon_button(ui, Icon::Open, name)).inner;
    if button.on_hover_text(text!("dialog-hint")).clicked() {
        interface.share.dialog = Some(OpenDialog { field, answer: open(request) });
    }
}

/// Checks whether the open dialog has been answered, and writes the chosen path into its field.
pub(crate) fn update(interface: &mut Interface, ctx: &egui::Context) {
    let Some(dialog) = &interface.share.dialog else { return };
    let field = dialog.field;
    match dialog.answer.take() {
        None => ctx.request_repaint_after(CHECK_INTERVAL),
        Some(answer) => {
            interface.share.dialog = None;
            match answer {
                Some(path) => *field_text(interface, field) = field.with_extension(path).display().to_string(),
                None => interface.show_reply(text!("dialog-none")),
            }
        }
    }
}
