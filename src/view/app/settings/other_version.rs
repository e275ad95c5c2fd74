//! Settings files that another version of the program has written.
//!
//! In: the text of a settings file. Out: the settings that this version can read, and the rest. Always: a field or bookmark that cannot be read affects no
//! other; fields with unknown names, and bookmarks and recent views that cannot be read, are saved as they were, so that the other version still finds
//! them. Not here: unknown fields inside a known field, such as those of a panel's settings; `settings::merge` keeps them in the file.

use super::{Bookmark, MAX_RECENT, Settings};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The field of bookmarks.
pub(super) const BOOKMARKS: &str = "bookmarks";
/// Fields that are lists of views; each entry is read separately.
pub(super) const LISTS: [&str; 2] = [BOOKMARKS, "recent"];

/// The parts of a settings file that this version cannot read, but writes back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnreadParts {
    /// Fields with unknown names.
    fields: Map<String, Value>,
    /// Entries of the two lists that this version cannot read.
    bookmarks: Vec<Value>,
    recent: Vec<Value>,
}

impl UnreadParts {
    /// A line that tells the user which bookmarks are kept but not shown.
    pub(super) fn notice(&self) -> Option<String> {
        match self.bookmarks.len() {
            0 => None,
            1 => Some("1 bookmark of another version of this program is kept, but not shown".into()),
            n => Some(format!("{n} bookmarks of another version of this program are kept, but not shown")),
        }
    }
}

/// A bookmark or recent view; both have the form of a [`Bookmark`].
#[derive(Serialize)]
#[serde(untagged)]
enum SavedView<'s> {
    Read(&'s Bookmark),
    /// One that this version cannot read.
    Unread(&'s Value),
}

impl<'s> SavedView<'s> {
    /// The entries that this version could read, then those that it could not.
    fn all(read: &'s [Bookmark], unread: &'s [Value]) -> Vec<Self> {
        read.iter().map(Self::Read).chain(unread.iter().map(Self::Unread)).collect()
    }
}

/// The content of a settings file.
#[derive(Serialize)]
pub(super) struct Saved<'s> {
    /// Serialised without its lists and unread parts, which follow here.
    #[serde(flatten)]
    settings: &'s Settings,
    bookmarks: Vec<SavedView<'s>>,
    recent: Vec<SavedView<'s>>,
    #[serde(flatten)]
    other_fields: &'s Map<String, Value>,
}

impl Settings {
    /// The settings as they are written to a file.
    pub(super) fn saved(&self) -> Saved<'_> {
        let unread = &self.unread;
        Saved {
            settings: self,
            bookmarks: SavedView::all(&self.bookmarks, &unread.bookmarks),
            // The recent views that this version cannot read are limited, like the others, so that the file does not grow without bound.
            recent: SavedView::all(&self.recent, &unread.recent[..unread.recent.len().min(MAX_RECENT)]),
            other_fields: &unread.fields,
        }
    }
}

/// The settings in a text. The second value names the invalid fields, which have their defaults; `None` if all are valid.
///
/// # Errors
/// If the text is not a JSON object.
pub(super) fn read(text: &str) -> Result<(Settings, Option<String>), serde_json::Error> {
    let fields: Map<String, Value> = serde_json::from_str(text)?;
    // The names in this object are those that this version knows.
    let defaults = serde_json::to_value(Settings::default().saved())?;
    let mut unread = UnreadParts::default();
    let (mut valid, mut invalid) = (Map::new(), Vec::new());
    for (name, value) in fields {
        if defaults.get(&name).is_none() {
            unread.fields.insert(name, value);
            continue;
        }
        let value = match value {
            Value::Array(entries) if LISTS.contains(&name.as_str()) => {
                let is_readable = |entry: &Value| Bookmark::deserialize(entry).is_ok();
                let (readable, unreadable): (Vec<Value>, Vec<Value>) = entries.into_iter().partition(is_readable);
                if name == BOOKMARKS {
                    unread.bookmarks = unreadable
                } else {
                    unread.recent = unreadable
                }
                Value::Array(readable)
            }
            value => value,
        };
        // Each field is read alone, so that an error in it affects no other.
        let single_field = Value::Object(Map::from_iter([(name.clone(), value.clone())]));
        match serde_json::from_value::<Settings>(single_field) {
            Ok(_) => drop(valid.insert(name, value)),
            Err(e) => invalid.push(format!("{name}: {e}")),
        }
    }
    let settings = Settings { unread, ..serde_json::from_value::<Settings>(Value::Object(valid))? };
    Ok((settings, (!invalid.is_empty()).then(|| invalid.join("; "))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;
    use crate::time::Instant;
    use crate::view::app::view_state::ViewState;
    use glam::DVec3;
    use serde_json::json;

    fn bookmark(name: &str) -> Bookmark {
        let view = ViewState::around(NaifId::MOON, DVec3::new(1e4, 0.0, 0.3), 1737.4, DVec3::Z, Instant::from_tdb_seconds_past_j2000(0.1));
        Bookmark { name: name.into(), view }
    }

    /// A newer version writes a field that this one does not know, and a bookmark with an unknown option of its view.
    #[test]
    fn settings_of_a_newer_version_survive_this_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        let ours = Settings { ui_scale: 1.1, bookmarks: vec![bookmark("a"), bookmark("b")], ..Settings::default() };
        let mut newer = serde_json::to_value(ours.saved()).expect("JSON");
        newer["finder"] = json!({"aperture_mm": 150});
        let mut unknown = newer["bookmarks"][0].clone();
        unknown["view"]["polarisation"] = json!(0.5);
        let entries = newer["bookmarks"].as_array_mut().expect("a list");
        entries.insert(1, unknown.clone());
        newer["recent"] = json!([unknown]);
        std::fs::write(&path, newer.to_string()).expect("a file");
        let (settings, notice) = Settings::load(&path);
        assert_eq!((settings.ui_scale, &settings.bookmarks), (1.1, &ours.bookmarks));
        assert!(notice.expect("a line").contains("1 bookmark of another version"));
        assert!(!folder.path().join("settings.json.broken").exists(), "nothing is lost");
        // This version saves a change; nothing of the newer one is lost. In the file, `labels_bodies` is called `names`.
        let no_base = None;
        Settings { labels_bodies: false, ..settings }.save(&path, no_base).expect("a file");
        let saved: Value = serde_json::from_str(&std::fs::read_to_string(&path).expect("text")).expect("JSON");
        assert_eq!((&saved["finder"], &saved["names"]), (&newer["finder"], &json!(false)));
        assert_eq!((saved["bookmarks"].as_array().map(Vec::len), &saved["bookmarks"][2]), (Some(3), &unknown));
        assert_eq!(saved["recent"], json!([unknown]));
    }

    /// A field whose value this version cannot read has its default; the file is set aside, and the rest is written in its place.
    #[test]
    fn an_invalid_field_affects_no_other() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        let ours = Settings { labels_bodies: false, bookmarks: vec![bookmark("a")], recent: vec![bookmark("r")], ..Settings::default() };
        let mut other = serde_json::to_value(ours.saved()).expect("JSON");
        other["unit"] = json!("furlongs");
        other["recent"].as_array_mut().expect("a list").push(json!({"name": "x"}));
        std::fs::write(&path, other.to_string()).expect("a file");
        let (settings, line) = Settings::load(&path);
        let unread = UnreadParts { recent: vec![json!({"name": "x"})], ..UnreadParts::default() };
        let ours = Settings { unread, ..ours };
        assert_eq!(settings, ours);
        let line = line.expect("a line");
        assert!(line.contains("unit: ") && line.contains("settings.json.broken"), "{line}");
        assert_eq!(std::fs::read_to_string(folder.path().join("settings.json.broken")).expect("kept"), other.to_string());
        assert_eq!(Settings::load(&path), (ours, None), "the valid part is in the file, and is not reported again");
    }

    /// A file with a value that this version cannot read is its only copy. If the file cannot be renamed to `*.broken`, here because this name would be longer
    /// than the 255 bytes that file systems allow, the file is therefore not overwritten.
    #[test]
    fn a_file_that_cannot_be_set_aside_stays_as_it_is() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("s".repeat(250));
        // `names`: the name of `labels_bodies` in the file.
        let text = r#"{"unit": "furlongs", "names": false}"#;
        std::fs::write(&path, text).expect("a file");
        let (settings, line) = Settings::load(&path);
        assert!(!settings.labels_bodies && line.expect("a line").contains("could not be set aside"));
        assert_eq!(std::fs::read_to_string(&path).expect("kept"), text);
    }
}
