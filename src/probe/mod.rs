//! Queries that the emitted shaders answer, run on the software renderer.
//!
//! In: one JSON object with a field `q`, the kind of query. Out: one JSON value, or one line that states what is wrong with the query. A source file
//! of this folder lists the fields of a kind in a [`QueryKind`], from which messages, help and checks are generated. Its function `answer` parses the fields,
//! chooses the shader module (a file shaders/entry/probe_*.wesl, specialised for the features of a key) and converts the numbers that it computes into named
//! results. Always: the shader computes the result; no formula of a shader is duplicated here.

pub mod batch;
mod error;
mod overlap;
pub mod pixel;
mod project;
mod ring;
mod scatter;
pub mod sunlight;

pub(crate) use error::ProbeError;

use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::render::software::SoftwareRenderer;
use crate::scene::request::camera_file::normalisable_direction;
use crate::session::Session;
use crate::shader::ShaderLibrary;
use crate::wording::{echo, echo_within, json_error_text, suggestion_or_list};
use glam::DVec3;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

/// The session and renderer that answer queries.
pub struct Prober<'a> {
    pub session: &'a Session,
    /// The renderer, in the requested precision.
    pub renderer: &'a SoftwareRenderer,
}

impl Prober<'_> {
    pub(crate) fn library(&self) -> &ShaderLibrary {
        self.session.library()
    }
    pub fn catalog(&self) -> &Catalog {
        self.session.catalog()
    }
    pub fn ephemeris(&self) -> &Ephemeris {
        self.session.ephemeris()
    }

    /// Answers one query.
    ///
    /// # Errors
    /// One line that names the field and its allowed values.
    pub fn answer(&self, query: &str) -> Result<Value, ProbeError> {
        let value = crate::json::value(query).map_err(|e| {
            let why = echo(&e.to_string());
            // `is_data`: the text is valid JSON, but gives a field twice.
            if e.is_data() { why } else { format!("not a JSON object: {why}") }
        })?;
        let Value::Object(mut given) = value else { return Err("not a JSON object: give {\"q\": …}".into()) };
        let known: Vec<&str> = QUERIES.iter().map(|k| k.name).collect();
        let kind_name = match given.remove("q") {
            Some(Value::String(name)) => name,
            Some(_) => return Err("field \"q\" is not a string".into()),
            None => return Err(format!("field \"q\" is missing; one of {}", known.join(", ")).into()),
        };
        let Some(kind) = QUERIES.iter().find(|k| k.name == kind_name) else {
            return Err(format!("q `{}` is not known; {}", echo(&kind_name), suggestion_or_list(&kind_name, &known)).into());
        };
        kind.check(&given)?;
        (kind.answer)(self, Value::Object(given))
    }
}

/// Parses a query's fields (a JSON object without `q`) and answers the query.
type AnswerFn = fn(&Prober<'_>, Value) -> Result<Value, ProbeError>;

/// One field of a query.
pub struct QueryField {
    /// The key in the JSON object.
    pub name: &'static str,
    /// Meaning and unit.
    pub description: &'static str,
    /// Whether the field is required, optional or one of several alternatives.
    pub requirement: Requirement,
}

/// Whether a query must have a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Requirement {
    Required,
    /// Optional, with the default in words.
    Optional(&'static str),
    /// One of several alternatives. The query's own file checks that one is given.
    Alternative,
}

/// One kind of query: its name, its fields, and the function that answers it.
pub struct QueryKind {
    /// The value of the field `q`.
    pub name: &'static str,
    /// What the query answers.
    pub description: &'static str,
    /// The query's fields besides `q`.
    pub fields: &'static [QueryField],
    /// A complete query.
    pub example: &'static str,
    /// The function that answers the query, given the fields without `q`.
    pub answer: AnswerFn,
}

const fn required(name: &'static str, description: &'static str) -> QueryField {
    QueryField { name, description, requirement: Requirement::Required }
}
const fn optional(name: &'static str, description: &'static str, default: &'static str) -> QueryField {
    QueryField { name, description, requirement: Requirement::Optional(default) }
}
const fn alternative(name: &'static str, description: &'static str) -> QueryField {
    QueryField { name, description, requirement: Requirement::Alternative }
}

impl QueryKind {
    /// Rejects a query with an unknown field or without a required one; the error names the first such field.
    fn check(&self, given: &Map<String, Value>) -> Result<(), ProbeError> {
        let known: Vec<&str> = self.fields.iter().map(|f| f.name).collect();
        if let Some(unknown) = given.keys().find(|k| !known.contains(&k.as_str())) {
            return Err(format!("field `{}` is not known to {}; {}", echo(unknown), self.name, suggestion_or_list(unknown, &known)).into());
        }
        match self.fields.iter().find(|f| f.requirement == Requirement::Required && !given.contains_key(f.name)) {
            Some(f) => Err(format!("field `{}` is missing: {}", f.name, f.description).into()),
            None => Ok(()),
        }
    }
}

/// Every kind of query.
pub static QUERIES: [&QueryKind; 7] =
    [&sunlight::KIND, &overlap::KIND, &scatter::KIND, &ring::TRANSMISSION, &ring::BODY_SHADOW, &pixel::KIND, &project::KIND];

/// Every kind with its fields and an example, as text.
pub fn queries_text() -> String {
    let mut text = String::new();
    for kind in QUERIES {
        text.push_str(&format!("{}: {}\n", kind.name, kind.description));
        let width = kind.fields.iter().map(|f| f.name.len()).max().unwrap_or(0);
        for f in kind.fields {
            let default_note = match f.requirement {
                Requirement::Required => String::new(),
                Requirement::Optional(default) => format!(" [default: {default}]"),
                Requirement::Alternative => " [or another in its place]".into(),
            };
            text.push_str(&format!("  {:<width$}  {}{default_note}\n", f.name, f.description));
        }
        text.push_str(&format!("  {}\n\n", kind.example));
    }
    text
}

/// Every kind with its fields and an example, as JSON.
pub(crate) fn queries_json() -> Value {
    let field = |f: &QueryField| {
        let default = match f.requirement {
            Requirement::Optional(default) => Value::from(default),
            Requirement::Required | Requirement::Alternative => Value::Null,
        };
        json!({ "name": f.name, "says": f.description, "must": f.requirement == Requirement::Required, "default": default })
    };
    let kind = |k: &&QueryKind| {
        json!({
            "q": k.name, "says": k.description, "fields": k.fields.iter().map(field).collect::<Vec<_>>(),
            "example": serde_json::from_str::<Value>(k.example).unwrap_or_default(),
        })
    };
    QUERIES.iter().map(kind).collect()
}

/// Deserialises the fields of one kind of query.
fn parse_fields<T: DeserializeOwned>(value: Value) -> Result<T, ProbeError> {
    let shortened = with_short_texts(&value);
    let read = T::deserialize(value).map_err(|e| match T::deserialize(&shortened) {
        // The message quotes the input, so it is created from the shortened query.
        Err(e) => first_invalid_field::<T>(&shortened, &e.to_string())
            .map_or_else(|| json_error_text(&e), |name| format!("field `{name}`: {}", json_error_text(&e))),
        // Shortened, the query is valid: a text that was cut is what is wrong.
        Ok(_) => echo(&json_error_text(&e)),
    });
    Ok(read?)
}

/// Name of the field at which parsing failed with this message; `None` for an unknown field, which the message names. Fields are parsed in order, so parsing
/// fails with the same message as soon as the object contains the fields up to this one.
fn first_invalid_field<T: DeserializeOwned>(value: &Value, message: &str) -> Option<String> {
    let all = value.as_object()?;
    let mut fields_so_far = Map::new();
    all.iter().filter(|_| !message.starts_with("unknown field")).find_map(|(name, value)| {
        fields_so_far.insert(name.clone(), value.clone());
        let is_same_message = T::deserialize(&Value::Object(fields_so_far.clone())).is_err_and(|e| e.to_string() == message);
        is_same_message.then(|| name.clone())
    })
}

/// The unit vector along `v`, which may have any length but zero. `field`: the name of its field, for the message.
fn unit_vector(field: &str, v: [f64; 3]) -> Result<DVec3, ProbeError> {
    normalisable_direction(v).map(DVec3::normalize).ok_or_else(|| format!("field {field:?} has no direction").into())
}

/// The value, with every string and key in it cut to the length that a message may quote.
fn with_short_texts(value: &Value) -> Value {
    const MAX_QUOTED_CHARS: usize = 100;
    match value {
        Value::String(s) => echo_within(s, MAX_QUOTED_CHARS).into(),
        Value::Array(all) => all.iter().map(with_short_texts).collect(),
        Value::Object(all) => Value::Object(all.iter().map(|(k, v)| (echo_within(k, MAX_QUOTED_CHARS), with_short_texts(v))).collect()),
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_of_any_length_but_zero_has_a_direction() {
        for length in [1e-200, 1.0, 1e200] {
            let unit = unit_vector("sun", [0.0, 0.0, -length]).expect("a direction");
            assert!((unit - DVec3::NEG_Z).length() < 1e-12, "{length:e}: {unit}");
        }
        assert!(unit_vector("sun", [0.0; 3]).unwrap_err().to_string().contains("\"sun\" has no direction"));
    }
}
