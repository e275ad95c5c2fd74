//! File dialogs of the desktop.
//!
//! In: the purpose of the file. Out: its path, once chosen. Always: only a thread of its own waits for a dialog. On Linux the dialog comes from the desktop's portal (D-Bus)
//! or from zenity; without both, no file is chosen.

use crate::view::panels::FileRequest;
use crate::view::worker::render_worker::Pending;
use std::path::{Path, PathBuf};

/// Opens a dialog.
pub(crate) fn open(question: FileRequest) -> Pending<Option<PathBuf>> {
    let (pending, answer) = Pending::with_sender();
    let named = Path::new(&question.name);
    let mut dialog = rfd::AsyncFileDialog::new().set_title(question.title).add_filter(question.title, question.endings);
    let folder = std::path::absolute(named).ok().and_then(|path| path.parent().map(Path::to_owned));
    if let Some(folder) = folder.filter(|folder| folder.is_dir()) {
        dialog = dialog.set_directory(folder);
    }
    // Some systems need the request on the window's thread, and the wait on another.
    if question.opens {
        let chosen = dialog.pick_file();
        std::thread::spawn(move || answer(pollster::block_on(chosen).map(|file| file.path().to_owned())));
    } else {
        let name = named.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let chosen = dialog.set_file_name(name).save_file();
        std::thread::spawn(move || answer(pollster::block_on(chosen).map(|file| file.path().to_owned())));
    }
    pending
}
