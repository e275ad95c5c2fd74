//! Files that the window opens, whether they are dropped on it or named by `orrery view`: views, tours, and data, which become layers over the sky or over
//! a body's surface.
//!
//! In: a path. Out: a view, a tour, or a layer that the session has already; else why not, in one line. Always: the content decides between a view, a tour
//! and data, because `.json`, `.csv` and `.txt` are endings of data files, too. Not here: what the window does with the file.

use crate::catalog::{NaifId, is_layer_file};
use crate::files::read_text;
use crate::session::Session;
use crate::time::Instant;
use crate::view::app::tour::{MAX_BYTES, Tour};
use crate::view::app::view_state::ViewState;
use crate::view::error_texts::UnreadFile;
use crate::view::link::{is_link, view_from_text};
use crate::wording::echo;
use percent_encoding::percent_decode_str;
use serde_json::{Map, Value};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// What a file contains.
pub enum OpenedFile {
    /// A layer, which the session has already; with the line that describes it.
    Layer(String),
    View(Box<ViewState>),
    Tour(Box<Tour>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Data,
    View,
    Tour,
}

/// The kind of a text. Views and tours have no field `type`, and every object of GeoJSON has one. `has_layer_ending`: whether the file's name is that of a data
/// layer.
fn kind_of(text: &str, has_layer_ending: bool) -> Kind {
    if is_link(text) {
        return Kind::View;
    }
    if !text.trim_start().starts_with('{') {
        return if has_layer_ending { Kind::Data } else { Kind::View };
    }
    let fields: Option<Map<String, Value>> = serde_json::from_str(text).ok();
    // A text that is no JSON gets an error about the kind that it seems to have.
    let has_field = |name: &str| fields.as_ref().map_or_else(|| text.contains(&format!("\"{name}\"")), |fields| fields.contains_key(name));
    match (has_field("type"), has_field("stops")) {
        (true, _) => Kind::Data,
        (false, true) => Kind::Tour,
        (false, false) => Kind::View,
    }
}

/// The path that an argument of the command line names. Desktops name a file by its path or by a `file:` address.
pub(crate) fn path_of(argument: &str) -> PathBuf {
    let address = argument.strip_prefix("file://").map(|address| address.strip_prefix("localhost").unwrap_or(address));
    let path = address.filter(|path| path.starts_with('/')).map(|path| percent_decode_str(path).decode_utf8_lossy().into_owned());
    PathBuf::from(path.as_deref().unwrap_or(argument))
}

/// Reads a file. `target`: the body that gets a layer with places on a body. `now`: the time of a view without one.
///
/// # Errors
/// The file cannot be read, or its content is invalid.
pub fn read(session: &Session, path: &Path, target: Option<NaifId>, now: Instant) -> Result<OpenedFile, UnreadFile> {
    let name = echo(&path.display().to_string());
    let has_layer_ending = path.file_name().is_some_and(|name| is_layer_file(&name.to_string_lossy()));
    let data = || session.add_data_file(path, target).map(OpenedFile::Layer).map_err(|e| UnreadFile::of_error(&e));
    let text = match read_text(path, MAX_BYTES) {
        Ok(text) => text,
        Err(_) if has_layer_ending => return data(),
        // An image, for example: the message lists the endings of data files.
        Err(e) if matches!(e.kind(), ErrorKind::InvalidData | ErrorKind::FileTooLarge) => return data(),
        Err(e) => return Err(UnreadFile::of_file(&name, e.to_string())),
    };
    match kind_of(&text, has_layer_ending) {
        Kind::Data => data(),
        Kind::View => {
            let view = view_from_text(&text, session, now);
            view.map(|view| OpenedFile::View(Box::new(view))).map_err(|e| UnreadFile::of_text(&name, &e))
        }
        Kind::Tour => {
            let tour = Tour::parse(&text, session, now);
            tour.map(|tour| OpenedFile::Tour(Box::new(tour))).map_err(|e| UnreadFile::of_text(&name, &e))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_decides_what_a_file_is() {
        for (text, in_data_file, in_other_file) in [
            ("orrery://view?target=mars", Kind::View, Kind::View),
            (r#"{"target": "mars"}"#, Kind::View, Kind::View),
            (r#"{"time": "2024-04-08"}"#, Kind::View, Kind::View),
            (r#"{"title": "a", "stops": []}"#, Kind::Tour, Kind::Tour),
            (r#"{"type": "Point", "coordinates": [1, 2]}"#, Kind::Data, Kind::Data),
            ("lat,lon\n1,2\n", Kind::Data, Kind::View),
            ("<kml></kml>", Kind::Data, Kind::View),
            ("", Kind::Data, Kind::View),
            // Not JSON: a comma is missing.
            (r#"{"type": "Point" "coordinates": [1, 2]}"#, Kind::Data, Kind::Data),
            (r#"{"title": "a" "stops": []}"#, Kind::Tour, Kind::Tour),
            (r#"{"target": "mars" "fov_deg": 3}"#, Kind::View, Kind::View),
        ] {
            assert_eq!((kind_of(text, true), kind_of(text, false)), (in_data_file, in_other_file), "{text}");
        }
    }

    #[test]
    fn desktops_may_name_a_file_by_its_address() {
        for (argument, path) in [
            ("quakes.geojson", "quakes.geojson"),
            ("/tmp/a%20b.csv", "/tmp/a%20b.csv"),
            ("file:///tmp/a%20b.csv", "/tmp/a b.csv"),
            ("file://localhost/tmp/a.csv", "/tmp/a.csv"),
            // The address of a file of another machine names none of this one.
            ("file://elsewhere/a.csv", "file://elsewhere/a.csv"),
        ] {
            assert_eq!(path_of(argument), PathBuf::from(path), "{argument}");
        }
    }
}
