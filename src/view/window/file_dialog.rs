//! Dialogs of the desktop for the name of a file.
//!
//! In: what the file is for. Out: its path, once someone has chosen. Always: nothing waits for a dialog but a thread of its own. On Linux it is asked for by the desktop's portal (D-Bus),
//! or by zenity; where neither is there the answer is that no file was chosen.

use crate::view::panels::FileQuestion;
use crate::view::worker::render_worker::Pending;
use std::path::{Path, PathBuf};

/// Opens a dialog.
pub fn open(question: FileQuestion) -> Pending<Option<PathBuf>> {
    let (pending, answer) = Pending::promised();
    let named = Path::new(&question.name);
    let mut dialog = rfd::AsyncFileDialog::new().set_title(question.title).add_filter(question.title, question.endings);
    let folder = std::path::absolute(named).ok().and_then(|path| path.parent().map(Path::to_owned));
    if let Some(folder) = folder.filter(|folder| folder.is_dir()) {
        dialog = dialog.set_directory(folder);
    }
    // Some systems want the question on the thread of the window, and the wait anywhere else.
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
