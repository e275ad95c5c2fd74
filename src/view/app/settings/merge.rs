//! Merges the settings of this program with the settings that are in the file when the file is written.
//!
//! In: the settings, those that this program read or wrote last, and the text of the file. Out: the content to write. Always: what this program has
//! changed is written; what it has not changed is taken from the file, where another running program may have changed it. Fields that this version does
//! not know, at any depth, are taken from the file, too. If both programs have changed the list of bookmarks, those that the other program has added are
//! kept; the other program's other changes of the list are lost. Not here: a lock. Of two programs that write in the same instant, the last one wins.
//!
//! Names as in a three-way merge: `ours` is what this program has, `theirs` what is in the file, `base` what this program read or wrote last.

use super::other_version::{BOOKMARKS, LISTS};
use super::{Bookmark, Settings};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The JSON of a value as it is in a file. The value is converted by way of text, so that an f32 has the same digits as one that was read from a file.
fn as_written<T: DeserializeOwned>(value: &impl Serialize) -> serde_json::Result<T> {
    serde_json::from_str(&serde_json::to_string(value)?)
}

impl Settings {
    /// The content to write over a file with the text `stored`. `base`: the settings that this program read or wrote last; without `base`, all settings count
    /// as changed. A text that is no JSON object is ignored.
    pub(super) fn merged_with(&self, base: Option<&Self>, stored: Option<&str>) -> serde_json::Result<Map<String, Value>> {
        let mut ours: Map<String, Value> = as_written(&self.saved())?;
        let Some(mut theirs) = stored.and_then(|text| serde_json::from_str::<Map<String, Value>>(text).ok()) else { return Ok(ours) };
        let base: Option<Map<String, Value>> = base.map(|base| as_written(&base.saved())).transpose()?;
        for name in LISTS {
            if let (Some(list), Some(their_list)) = (ours.get_mut(name), theirs.remove(name)) {
                *list = merged_list(name, base.as_ref().and_then(|base| base.get(name)), list.take(), their_list);
            }
        }
        merge(base.as_ref(), &mut ours, theirs);
        Ok(ours)
    }
}

/// Settings that are merged as one value (`place`: the placement of the window). If we have changed one of the fields of such a setting, all its fields that
/// this version knows are ours.
const INDIVISIBLE: [&str; 2] = ["home", "place"];

/// Copies a field of `theirs` to `ours` if `ours` lacks it, or if it has not changed from `base` to `ours`; at any depth of objects. A field that only `ours`
/// has stays.
fn merge(base: Option<&Map<String, Value>>, ours: &mut Map<String, Value>, theirs: Map<String, Value>) {
    for (name, their_value) in theirs {
        let base = base.and_then(|base| base.get(&name));
        match ours.get_mut(&name) {
            None => drop(ours.insert(name, their_value)),
            Some(our_value) => match (our_value, their_value) {
                (Value::Object(ours), Value::Object(theirs)) => {
                    let base = base.and_then(Value::as_object);
                    let is_changed = INDIVISIBLE.contains(&name.as_str()) && base != Some(&*ours);
                    // Without a base, each of our fields counts as changed.
                    merge(base.filter(|_| !is_changed), ours, theirs);
                }
                (our_value, their_value) if Some(&*our_value) == base => *our_value = their_value,
                _ => {}
            },
        }
    }
}

/// A merged list of views. If ours is the same as the base, the result is theirs; otherwise it is ours, followed by the bookmarks that the other program has
/// added. `name`: the list's field.
fn merged_list(name: &str, base: Option<&Value>, ours: Value, theirs: Value) -> Value {
    if Some(&ours) == base {
        return theirs;
    }
    match (ours, theirs) {
        (Value::Array(ours), Value::Array(theirs)) => {
            // Each of their entries twice: as this version would write it, to compare, and as it is in the file, with fields that only another version knows.
            let theirs: Vec<(Value, Value)> = theirs.into_iter().map(|entry| (normalised(&entry), entry)).collect();
            let as_in_file = |entry: &Value| {
                let stored = theirs.iter().find(|(comparable, _)| comparable == entry).map(|(_, stored)| stored);
                stored.unwrap_or(entry).clone()
            };
            let mut all: Vec<Value> = ours.iter().map(as_in_file).collect();
            if let (BOOKMARKS, Some(Value::Array(base))) = (name, base) {
                let is_added = |entry: &Value| !base.contains(entry) && !ours.contains(entry);
                all.extend(theirs.iter().filter(|(comparable, _)| is_added(comparable)).map(|(_, stored)| stored.clone()));
            }
            Value::Array(all)
        }
        (ours, _) => ours,
    }
}

/// An entry as this version writes it, or unchanged if it cannot be read.
fn normalised(entry: &Value) -> Value {
    Bookmark::deserialize(entry).ok().and_then(|bookmark| as_written(&bookmark).ok()).unwrap_or_else(|| entry.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::NaifId;
    use crate::time::Instant;
    use crate::view::app::settings::Home;
    use crate::view::app::view_state::ViewState;
    use glam::DVec3;
    use serde_json::json;
    use std::path::Path;

    fn bookmark(name: &str) -> Bookmark {
        let view = ViewState::around(NaifId::MOON, DVec3::new(1e4, 0.0, 0.3), 1737.4, DVec3::Z, Instant::from_tdb_seconds_past_j2000(0.1));
        Bookmark { name: name.into(), view }
    }

    fn names(settings: &Settings) -> Vec<&str> {
        settings.bookmarks.iter().map(|b| b.name.as_str()).collect()
    }

    fn content(path: &Path) -> Value {
        serde_json::from_str(&std::fs::read_to_string(path).expect("text")).expect("JSON")
    }

    /// A newer version has fields inside the settings that this version knows: in the panels, in the home, in a bookmark.
    #[test]
    fn unknown_fields_inside_known_settings_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        let ours = Settings { bookmarks: vec![bookmark("a")], ui_scale: 1.1, ..Settings::default() };
        let mut newer: Value = as_written(&ours.saved()).expect("JSON");
        newer["panels"]["minimap"] = json!({"corner": 2});
        newer["home"]["height_m"] = json!(35.0);
        newer["bookmarks"][0]["colour"] = json!("red");
        std::fs::write(&path, newer.to_string()).expect("a file");
        let (loaded, notice) = Settings::load(&path);
        assert_eq!((&loaded, notice), (&ours, None));
        let mut changed = loaded.clone();
        changed.panels.on_left = true;
        changed.home = Home { latitude_deg: 52.5, longitude_deg: 13.4 };
        changed.bookmarks.push(bookmark("b"));
        for base in [Some(&loaded), None] {
            changed.save(&path, base).expect("a file");
            let saved = content(&path);
            assert_eq!((&saved["panels"]["minimap"], &saved["panels"]["on_left"]), (&json!({"corner": 2}), &json!(true)));
            assert_eq!(saved["home"], json!({"latitude_deg": 52.5, "longitude_deg": 13.4, "height_m": 35.0}));
            assert_eq!((&saved["bookmarks"][0]["colour"], &saved["bookmarks"][1]["name"]), (&json!("red"), &json!("b")));
            // The field of `ui_scale`, with the digits of an f32.
            assert_eq!(saved["zoom"], json!(1.1));
            assert_eq!(Settings::load(&path), (changed.clone(), None));
        }
    }

    /// Another window has saved another home: ours, of which only the longitude has changed, is not mixed with it.
    #[test]
    fn a_home_is_one_value() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        let base = Settings { home: Home { latitude_deg: 10.0, longitude_deg: 20.0 }, ..Settings::default() };
        let theirs = Settings { home: Home { latitude_deg: -30.0, longitude_deg: 20.0 }, ..base.clone() };
        let ours = Settings { home: Home { latitude_deg: 10.0, longitude_deg: 40.0 }, ..base.clone() };
        theirs.save(&path, Some(&base)).expect("a file");
        ours.save(&path, Some(&base)).expect("a file");
        assert_eq!(content(&path)["home"], json!({"latitude_deg": 10.0, "longitude_deg": 40.0}));
    }

    /// Fields that this version does not know survive also if another setting is invalid and the file is set aside.
    #[test]
    fn unknown_fields_are_kept_when_a_file_is_set_aside() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        std::fs::write(&path, r#"{"unit": "furlongs", "hints": {"drag": true, "tilt": true}, "finder": 1}"#).expect("a file");
        assert!(Settings::load(&path).1.is_some());
        let saved = content(&path);
        assert_eq!((&saved["hints"]["tilt"], &saved["hints"]["drag"], &saved["finder"]), (&json!(true), &json!(true), &json!(1)));
        assert_eq!(saved["unit"], json!("kilometres"));
    }

    /// Two windows are open; each writes what it has changed since it read or wrote the file last.
    #[test]
    fn two_programs_keep_each_others_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        let start = Settings { bookmarks: vec![bookmark("a"), bookmark("b")], ..Settings::default() };
        let no_base = None;
        start.save(&path, no_base).expect("a file");
        let first = Settings { labels_bodies: false, bookmarks: vec![bookmark("a"), bookmark("b"), bookmark("first")], ..start.clone() };
        first.save(&path, Some(&start)).expect("a file");
        // The second has deleted a bookmark, added one, and changed another field of the panels.
        let mut second = Settings { marks_small_bodies: false, bookmarks: vec![bookmark("b"), bookmark("second")], ..start.clone() };
        second.panels.timeline_shown = false;
        second.save(&path, Some(&start)).expect("a file");
        let (both, _) = Settings::load(&path);
        assert_eq!((both.labels_bodies, both.marks_small_bodies, both.panels.timeline_shown), (false, false, false));
        assert_eq!(names(&both), ["b", "second", "first"]);
        // The first writes again, with another change of the panels, and no change of the bookmarks.
        let mut later = first.clone();
        later.panels.on_left = true;
        later.save(&path, Some(&first)).expect("a file");
        let (all, _) = Settings::load(&path);
        assert_eq!((all.panels.on_left, all.panels.timeline_shown, all.marks_small_bodies), (true, false, false));
        assert_eq!(names(&all), ["b", "second", "first"]);
        // Without a change the file stays as it is.
        later.save(&path, Some(&later)).expect("a file");
        assert_eq!(Settings::load(&path).0, all);
        // A file that was damaged meanwhile is replaced.
        std::fs::write(&path, "[").expect("a file");
        later.save(&path, Some(&later)).expect("a file");
        assert_eq!(Settings::load(&path), (later, None));
    }

    /// Earlier versions wrote the view of a bookmark under another field name; such a bookmark counts as the same bookmark.
    #[test]
    fn bookmarks_of_an_earlier_version_are_not_doubled() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("settings.json");
        let start = Settings { bookmarks: vec![bookmark("a")], ..Settings::default() };
        let saved: Value = as_written(&start.saved()).expect("JSON");
        std::fs::write(&path, saved.to_string().replace("\"view\":", "\"sight\":")).expect("a file");
        let (loaded, _) = Settings::load(&path);
        let changed = Settings { bookmarks: vec![bookmark("a"), bookmark("b")], ..loaded.clone() };
        changed.save(&path, Some(&loaded)).expect("a file");
        assert_eq!(Settings::load(&path), (changed, None));
    }
}
