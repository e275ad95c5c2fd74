//! Writes a view as text, and reads it back: as a link or as a JSON file.
//!
//! In: a [`ViewState`], or untrusted text. Out: the text, or the view that it describes. Always: text written here restores every number of the view
//! exactly. Text may give bodies by name or by NAIF code. Omitted fields have the defaults of a new window: the target is the camera's body, or else
//! the Earth; the time is now; the camera (the field `eye`) sees the lit side from 3.5 radii, and on a surface looks south. Text of an impossible view
//! is rejected; the error counts all its errors and lists the first of them. This module reads no file.

use crate::catalog::{Catalog, NaifId};
use crate::json;
use crate::session::{Session, SessionError};
use crate::time::Instant;
use crate::view::app::body_positions::SessionPositions;
use crate::view::app::composition_state::CompositionState;
use crate::view::app::initial_view::initial_view;
use crate::view::app::view_state::{CameraPose, ViewState, ViewStateError, pose_on_ground};
use crate::wording::{did_you_mean, echo_within, json_error_text, without_byte_order_mark};
use glam::DVec3;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::borrow::Cow;

/// The beginning of every link.
pub(crate) const SCHEME: &str = "orrery://view?";

/// Fields that a text may contain although the serialised default view omits them; needed to suggest them for a misspelt name.
const FIELDS_WITHOUT_DEFAULT: [&str; 4] = ["time", "paused", "mirrored", "telescope"];
/// Largest accepted text, bytes. A text written here has about 600.
pub(crate) const MAX_BYTES: u64 = 65_536;
/// Maximum number of listed errors.
const MAX_ERRORS: usize = 20;
/// Maximum number of characters of a listed error.
const MAX_ERROR_CHARACTERS: usize = 200;

/// Why a text does not describe a view, in one line.
#[derive(Debug, thiserror::Error)]
pub enum ViewTextError {
    /// The errors of the text's fields.
    #[error("{}", errors_text(.0))]
    Fields(Vec<String>),
    /// Each field is valid alone, but their combination is not.
    #[error(transparent)]
    View(#[from] ViewStateError),
    /// No scene can be built, for instance because the ephemeris does not cover the time.
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// The errors in one line: their number, and the first of them.
fn errors_text(errors: &[String]) -> String {
    match errors {
        [one] => one.clone(),
        all => {
            let left_out = if all.len() > MAX_ERRORS { "; …" } else { "" };
            format!("{} errors: {}{left_out}", all.len(), all[..all.len().min(MAX_ERRORS)].join("; "))
        }
    }
}

/// Whether a text is meant as a link, valid or not.
pub(crate) fn is_link(text: &str) -> bool {
    text.trim().get(.."orrery:".len()).is_some_and(|scheme| scheme.eq_ignore_ascii_case("orrery:"))
}

/// The part of a link after `?`. Accepts the link as written, and as some systems normalise it (`Orrery://view/?…`).
fn query_of(link: &str) -> Option<&str> {
    let (prefix, query) = link.trim().split_once('?').unwrap_or((link.trim(), ""));
    let prefix = prefix.trim_end_matches('/');
    SCHEME.trim_end_matches('?').eq_ignore_ascii_case(prefix).then_some(query)
}

/// The view that a link or a file's text describes. `now`: the time of a view without one.
///
/// # Errors
/// A single line that lists the unreadable fields and impossible values: their number, and at most the first 20 of them.
pub fn view_from_text(text: &str, session: &Session, now: Instant) -> Result<ViewState, ViewTextError> {
    let catalog = session.catalog();
    let mut partial_view = PartialView::of(text);
    partial_view.resolve_body_names(catalog);
    let target = partial_view.target();
    let time = partial_view.take_time().unwrap_or(now);
    let defaults = initial_view(catalog, &SessionPositions(session), target, time)?;
    let view = partial_view.with_defaults(&defaults, catalog)?;
    // Building a scene checks combinations of fields, and that the ephemeris covers the view. The size of the image does not matter.
    let request = view.request(catalog, session.ephemeris(), 64, 64)?;
    session.scene(&request)?;
    Ok(view)
}

impl ViewState {
    /// `orrery://view?target=699&eye.kind=orbit&…`: every serialised field by its path.
    pub fn to_link(&self) -> String {
        let mut pairs = Vec::new();
        flatten("", &serde_json::to_value(self).unwrap_or_default(), &mut pairs);
        format!("{SCHEME}{}", pairs.iter().map(|(k, v)| format!("{k}={}", escaped(v))).collect::<Vec<_>>().join("&"))
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

/// The fields that a text contains, as JSON, and the errors found in it so far.
struct PartialView {
    fields: Map<String, Value>,
    errors: Vec<String>,
}

impl PartialView {
    /// Reads a link or JSON text.
    fn of(text: &str) -> Self {
        let text = without_byte_order_mark(text);
        if text.len() as u64 > MAX_BYTES {
            Self::from_error(format!("too long for a view: {} bytes, the limit is {MAX_BYTES}", text.len()))
        } else if is_link(text) {
            Self::of_link(text)
        } else {
            Self::of_json(text)
        }
    }

    /// A text without any readable field.
    fn from_error(why: String) -> Self {
        let mut partial_view = Self { fields: Map::new(), errors: Vec::new() };
        partial_view.record_error(why);
        partial_view
    }

    /// Records an error as one line of limited length, since the text is untrusted.
    fn record_error(&mut self, why: String) {
        self.errors.push(echo_within(&why, MAX_ERROR_CHARACTERS));
    }

    fn of_link(link: &str) -> Self {
        let Some(query) = query_of(link) else { return Self::from_error(format!("a link starts with {SCHEME}")) };
        let mut partial_view = Self { fields: Map::new(), errors: Vec::new() };
        for pair in query.split('&').filter(|p| !p.is_empty()) {
            if let Err(why) = partial_view.add_pair(pair) {
                partial_view.record_error(why);
            }
        }
        partial_view
    }

    /// Adds the field of a pair `field=value` or `group.field=value`.
    fn add_pair(&mut self, pair: &str) -> Result<(), String> {
        let (path, text) = pair.split_once('=').ok_or_else(|| format!("`{}`: write field=value", shortened(pair)))?;
        let text = unescaped(text).ok_or_else(|| format!("`{}`: invalid %-escape", shortened(pair)))?;
        // A value that is not valid JSON is a string. An error `is_data` if the value is valid JSON but gives a field twice.
        let value = match json::value(&text) {
            Err(e) if e.is_data() => return Err(format!("`{}`: {e}", shortened(path))),
            found => found.unwrap_or(Value::String(text)),
        };
        let Some((parent, name)) = path.split_once('.') else {
            if self.fields.get(path).is_some_and(Value::is_object) {
                return Err(format!("`{}` is both a value and a group of fields", shortened(path)));
            }
            return insert_once(&mut self.fields, path, path, value);
        };
        if name.contains('.') {
            return Err(format!("`{}`: fields are nested one level deep", shortened(path)));
        }
        let group = self.fields.entry(parent).or_insert_with(|| Value::Object(Map::new()));
        let map = group.as_object_mut().ok_or_else(|| format!("`{}`: the field above it is a value, not a group", shortened(path)))?;
        insert_once(map, name, path, value)
    }

    fn of_json(text: &str) -> Self {
        match json::value(text) {
            Ok(Value::Object(fields)) => Self { fields, errors: Vec::new() },
            Err(e) if text.trim_start().starts_with('{') => Self::from_error(e.to_string()),
            _ => Self::from_error(format!("neither a link ({SCHEME}…) nor the text of a saved view")),
        }
    }

    /// Replaces names of bodies with their codes. An unknown name is recorded as an error, and its field is removed.
    fn resolve_body_names(&mut self, catalog: &Catalog) {
        let mut errors = Vec::new();
        // The body that a field's value gives by name or by code. `path`: the field's path, for the error.
        let body_id = |path: &str, value: &Value| match value {
            Value::String(name) => catalog.body_named(name).map(|body| body.id).map_err(|e| format!("{path}: {e}")),
            other => match serde_json::from_value(other.clone()).map(NaifId) {
                Ok(id) if catalog.body(id).is_some() => Ok(id),
                Ok(id) => Err(format!("{path}: no body has the code {}", id.0)),
                Err(_) => Err(format!("{path} {other}: write a body's name or its NAIF code")),
            },
        };
        // Resolves the field `name` of `map`.
        let mut resolve = |path: &str, map: &mut Map<String, Value>, name: &str| {
            let Some(value) = map.get(name) else { return };
            match body_id(path, value) {
                Ok(id) => {
                    map.insert(name.to_owned(), Value::from(id.0));
                }
                Err(why) => {
                    map.remove(name);
                    errors.push(why);
                }
            }
        };
        resolve("target", &mut self.fields, "target");
        if let Some(Value::Object(eye)) = self.fields.get_mut("eye") {
            resolve("eye.body", eye, "body");
        }
        errors.into_iter().for_each(|why| self.record_error(why));
    }

    /// The target, or else the camera's body, or else the Earth; requires that [`Self::resolve_body_names`] was called.
    fn target(&self) -> NaifId {
        let body_id = |value: Option<&Value>| value.and_then(|v| serde_json::from_value(v.clone()).ok()).map(NaifId);
        body_id(self.fields.get("target")).or(body_id(self.fields.get("eye").and_then(|eye| eye.get("body")))).unwrap_or(NaifId::EARTH)
    }

    /// The time of the field `time` (a date), which is removed, or of `tdb_s`, which stays; `None` if neither gives a time. Records an error if the date is
    /// invalid, or if the text has both fields.
    fn take_time(&mut self) -> Option<Instant> {
        let (tdb_s, date) = (self.fields.get("tdb_s").cloned(), self.fields.remove("time"));
        if tdb_s.is_some() && date.is_some() {
            self.record_error("time and tdb_s are two forms of one value: leave one out".into());
        }
        if let Some(date) = date {
            // In a link a bare year is a number; as text it gives the error that shows how to write a date.
            let text = match date {
                Value::String(text) => text,
                other => other.to_string(),
            };
            return Instant::parse(&text).map_err(|e| self.record_error(format!("time: {e}"))).ok();
        }
        // An invalid `tdb_s` is reported later, with the other fields.
        serde_json::from_value(tdb_s?).ok().map(Instant::from_tdb_seconds_past_j2000)
    }

    /// The complete view: omitted fields are taken from `defaults`, whose camera is an orbit and whose time is already the text's.
    fn with_defaults(mut self, defaults: &ViewState, catalog: &Catalog) -> Result<ViewState, ViewTextError> {
        let fields = std::mem::take(&mut self.fields);
        let mut merged = object_of(defaults);
        for (name, value) in fields {
            match value {
                Value::Object(given_fields) if name == "eye" => {
                    let eye = self.camera_with_defaults(given_fields, defaults);
                    merged.extend(eye.map(|eye| (name, Value::Object(eye))));
                }
                Value::Object(given_fields) if name == "composition" => {
                    let mut composition = object_of(&defaults.composition);
                    for (name, value) in given_fields {
                        self.set_field::<CompositionState>("composition.", &mut composition, &name, value);
                    }
                    merged.insert(name, Value::Object(composition));
                }
                value => self.set_field::<ViewState>("", &mut merged, &name, value),
            }
        }
        let mut view: Option<ViewState> = serde_json::from_value(Value::Object(merged)).map_err(|e| self.record_error(e.to_string())).ok();
        if let Some(view) = &mut view {
            // In a view these two layers are fields of their own, because the window has separate switches for them.
            view.orbits |= std::mem::take(&mut view.layers.orbits);
            view.bloom |= std::mem::take(&mut view.layers.bloom);
        }
        // `set_field` gave unreadable fields their defaults, so this check does not report them again.
        view.iter().flat_map(|view| view.field_errors(catalog)).for_each(|why| self.record_error(why));
        match view {
            Some(view) if self.errors.is_empty() => Ok(view),
            _ => Err(ViewTextError::Fields(self.errors)),
        }
    }

    /// Sets the field `name` in `merged`, a serialised `T`. If the result could not be deserialised, leaves the field as it was and records an error.
    /// `parent`: the path of the fields of `T`, with a point at its end, for the error.
    fn set_field<T: DeserializeOwned>(&mut self, parent: &str, merged: &mut Map<String, Value>, name: &str, value: Value) {
        let previous = merged.insert(name.to_owned(), value);
        if let Err(e) = serde_json::from_value::<T>(Value::Object(merged.clone())) {
            match previous {
                Some(previous) => merged.insert(name.to_owned(), previous),
                None => merged.remove(name),
            };
            let why = Some(json_error_text(&e)).filter(|why| !why.starts_with("unknown field")).unwrap_or_else(|| {
                let known_names = merged.keys().map(String::as_str).chain(FIELDS_WITHOUT_DEFAULT.into_iter().filter(|_| parent.is_empty()));
                let hint = did_you_mean(name, known_names).map_or(String::new(), |hint| format!("; {hint}"));
                format!("no such field{hint}")
            });
            self.record_error(format!("{parent}{name}: {why}"));
        }
    }

    /// The fields of a text's camera, completed with defaults; an orbit if the text does not specify a kind. `None` if the kind is unknown.
    fn camera_with_defaults(&mut self, mut given_fields: Map<String, Value>, defaults: &ViewState) -> Option<Map<String, Value>> {
        let body = defaults.target;
        let kind = given_fields.remove("kind").unwrap_or_else(|| "orbit".into());
        let mut merged = match kind.as_str() {
            Some("orbit") => object_of(&defaults.camera_pose),
            Some("ground") => object_of(&pose_on_ground(body, 0.0, 0.0)),
            Some("centre") => object_of(&CameraPose::Centre { body }),
            Some("free") => {
                for name in ["offset_km", "forward", "up"].into_iter().filter(|name| !given_fields.contains_key(*name)) {
                    self.record_error(format!("eye.{name} is missing: a free camera has no default"));
                }
                // The vectors are placeholders: a text without one of them is rejected.
                object_of(&CameraPose::Free { body, offset_km: DVec3::X, forward: DVec3::X, up: DVec3::Z })
            }
            _ => {
                self.record_error(format!("eye.kind {kind}: one of orbit, ground, centre, free"));
                return None;
            }
        };
        for (name, value) in given_fields {
            self.set_field::<CameraPose>("eye.", &mut merged, &name, value);
        }
        Some(merged)
    }
}

/// Adds a field that `map` does not have yet. `path`: the field's path, for the error.
fn insert_once(map: &mut Map<String, Value>, name: &str, path: &str, value: Value) -> Result<(), String> {
    match map.insert(name.to_owned(), value) {
        None => Ok(()),
        Some(_) => Err(format!("`{}` is given twice", shortened(path))),
    }
}

/// A quotation of the text for a message.
fn shortened(text: &str) -> String {
    const MAX_CHARACTERS: usize = 60;
    echo_within(text, MAX_CHARACTERS)
}

/// The JSON object of a serialised structure.
fn object_of(value: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(value) {
        Ok(Value::Object(map)) => map,
        _ => Map::new(),
    }
}

/// Appends the path and the text of each field of a serialised value to `pairs`; `null` is omitted. `path`: the path of `value`; empty for the root.
fn flatten(path: &str, value: &Value, pairs: &mut Vec<(String, String)>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(k, v)| {
            let child_path = if path.is_empty() { k.clone() } else { format!("{path}.{k}") };
            flatten(&child_path, v, pairs);
        }),
        Value::Null => {}
        // A string that would be read as another JSON value keeps its quotes.
        Value::String(s) if serde_json::from_str::<Value>(s).is_err() => pairs.push((path.to_owned(), s.clone())),
        other => pairs.push((path.to_owned(), other.to_string())),
    }
}

/// Bytes that are escaped in a link's values: all except letters, digits and those removed here.
const ESCAPED_BYTES: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b'-').remove(b'_').remove(b'.').remove(b'~').remove(b'+').remove(b',').remove(b':').remove(b'[').remove(b']');

fn escaped(text: &str) -> String {
    utf8_percent_encode(text, ESCAPED_BYTES).to_string()
}

/// The text of an escaped value; `None` if an escape is incomplete (which `percent_encoding` would accept) or the bytes are not UTF-8.
fn unescaped(text: &str) -> Option<String> {
    let is_escape = |rest: &str| rest.as_bytes().get(..2).is_some_and(|hex| hex.iter().all(u8::is_ascii_hexdigit));
    let are_complete = text.split('%').skip(1).all(is_escape);
    are_complete.then(|| percent_decode_str(text).decode_utf8().ok().map(Cow::into_owned)).flatten()
}

#[cfg(test)]
mod tests;
