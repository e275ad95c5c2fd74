//! File dialogs of the desktop.
//!
//! In: what the user has to choose. Out: the chosen path, or none. Always: a separate thread waits for the answer, never the window's thread.
//! On Linux the dialog comes from the desktop's portal (D-Bus) or from zenity; if neither exists, no file is chosen.

use crate::view::panels::FileRequest;
use crate::view::worker::render_worker::Pending;
use std::path::{Path, PathBuf};

/// Opens a dialog. The answer is the chosen path; `None` if the user cancels, or if no dialog can be opened.
pub(crate) fn open(request: FileRequest) -> Pending<Option<PathBuf>> {
    let (pending, deliver) = Pending::with_sender();
    let typed_path = Path::new(&request.name);
    let mut dialog = rfd::AsyncFileDialog::new().set_title(request.title).add_filter(request.title, request.extensions);
    let folder = std::path::absolute(typed_path).ok().and_then(|path| path.parent().map(Path::to_owned));
    if let Some(folder) = folder.filter(|folder| folder.is_dir()) {
        dialog = dialog.set_directory(folder);
    }
    // Some systems require the dialog to be opened on the window's thread; another thread then waits for the result.
    if request.is_for_opening {
        let chosen = dialog.pick_file();
        std::thread::spawn(move || deliver(pollster::block_on(chosen).map(|file| file.path().to_owned())));
    } else {
        let name = typed_path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let chosen = dialog.set_file_name(name).save_file();
        std::thread::spawn(move || deliver(pollster::block_on(chosen).map(|file| file.path().to_owned())));
    }
    pending
}
