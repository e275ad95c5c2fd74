//! Questions that the emitted shaders themselves answer, run on the software renderer.
//!
//! In: one JSON object with a field `q`. Out: one JSON value, or one line that says what is wrong with the question. A kind of question
//! is a file: it reads its fields, picks the module (an entry of shaders/entry/probe_*.wgsl with the features of a key) and turns rows of numbers
//! into named answers. Always holds: no formula of a shader is written a second time here.

pub mod lanes;
mod overlap;
pub mod pixel;
mod ring;
mod scatter;
pub mod sunlight;

use crate::catalog::Catalog;
use crate::ephemeris::Ephemeris;
use crate::render::software::SoftwareRenderer;
use crate::session::Session;
use crate::shader::Library;
use serde::Deserialize;
use serde_json::Value;

/// What answers are made with.
pub struct Prober<'a> {
    pub session: &'a Session,
    /// In the precision that was asked for.
    pub renderer: &'a SoftwareRenderer,
}

impl Prober<'_> {
    pub fn library(&self) -> &Library {
        self.session.library()
    }
    pub fn catalog(&self) -> &Catalog {
        self.session.catalog()
    }
    pub fn ephemeris(&self) -> &Ephemeris {
        self.session.ephemeris()
    }

    /// Answers one question.
    ///
    /// # Errors
    /// One line that names the field and what it may be.
    pub fn answer(&self, question: &str) -> Result<Value, String> {
        let value: Value = serde_json::from_str(question).map_err(|e| format!("not a JSON object: {e}"))?;
        let Value::Object(mut fields) = value else { return Err("not a JSON object: give {\"q\": …}".into()) };
        let kind = match fields.remove("q") {
            Some(Value::String(kind)) => kind,
            Some(_) => return Err("field \"q\" is not a string".into()),
            None => return Err(format!("field \"q\" is missing; {}", kinds())),
        };
        let Some((_, ask)) = KINDS.iter().find(|(name, _)| *name == kind) else {
            return Err(format!("q {kind:?} is not known; {}", kinds()));
        };
        ask(self, Value::Object(fields))
    }
}

/// Reads a question's fields, answers it.
type Ask = fn(&Prober<'_>, Value) -> Result<Value, String>;

/// Every kind of question.
static KINDS: &[(&str, Ask)] = &[
    ("disc-overlap", overlap::ask),
    ("pixel", pixel::ask),
    ("scatter", scatter::ask),
    ("sunlight", sunlight::ask),
    ("ring-shadow", ring::shadow),
    ("ring-transmission", ring::transmission),
];

fn kinds() -> String {
    let names: Vec<_> = KINDS.iter().map(|(name, _)| *name).collect();
    format!("there are {}", names.join(", "))
}

/// The fields of one kind of question; unknown and missing ones are named.
fn fields<'de, T: Deserialize<'de>>(value: Value) -> Result<T, String> {
    T::deserialize(value).map_err(|e| e.to_string())
}
