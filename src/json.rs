//! JSON that users write.
//!
//! In: a text. Out: its value, or an error. Always: a text in which an object gives a field twice is an error; serde_json's own `Value` would keep only the
//! later of the two.

use crate::wording::echo_within;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};
use std::fmt;

/// The value of a text. The error about a repeated field is the only one of the category `Data`; all others are about the syntax.
pub(crate) fn value(text: &str) -> serde_json::Result<Value> {
    serde_json::from_str::<Unrepeated>(text).map(|found| found.0)
}

/// The value of a field, for `#[serde(deserialize_with = ...)]`.
#[cfg(feature = "view")]
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Value, D::Error> {
    Unrepeated::deserialize(deserializer).map(|found| found.0)
}

/// A value in which no object gives a field twice.
struct Unrepeated(Value);

impl<'de> Deserialize<'de> for Unrepeated {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(UnrepeatedVisitor).map(Self)
    }
}

struct UnrepeatedVisitor;

impl<'de> Visitor<'de> for UnrepeatedVisitor {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut all = Vec::new();
        while let Some(Unrepeated(item)) = items.next_element()? {
            all.push(item);
        }
        Ok(Value::Array(all))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut given: A) -> Result<Value, A::Error> {
        let mut fields = Map::new();
        while let Some(name) = given.next_key::<String>()? {
            if fields.contains_key(&name) {
                return Err(A::Error::custom(format!("field `{}` is given twice", echo_within(&name, 60))));
            }
            let Unrepeated(value) = given.next_value()?;
            fields.insert(name, value);
        }
        Ok(Value::Object(fields))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_serde_json() {
        for text in [
            "null",
            "true",
            " -3 ",
            "18446744073709551615",
            "0.1",
            "-1e-7",
            "\"a\\u00e4\\n\"",
            "[]",
            "[1, [2, {}], {\"a\": [null, \"x\"]}]",
            "{\"b\": 1.5, \"a\": {\"b\": false}}",
        ] {
            assert_eq!(value(text).expect(text), serde_json::from_str::<Value>(text).expect(text), "{text}");
        }
        for text in ["", "{", "[1,]", "{\"a\" 1}", "1 2", "nul", &"[".repeat(1000)] {
            let (own, reference) = (value(text).expect_err(text), serde_json::from_str::<Value>(text).expect_err(text));
            assert_eq!((own.to_string(), own.is_data()), (reference.to_string(), false), "{text}");
        }
    }

    #[test]
    fn a_field_given_twice_is_an_error_at_every_depth() {
        for text in ["{\"a\": 1, \"a\": 1}", "{\"b\": [{\"c\": {\"a\": 1, \"d\": 2, \"a\": 3}}]}", "{\"a\": 1, \"\\u0061\": 2}"] {
            let error = value(text).expect_err(text);
            assert!(error.is_data() && error.to_string().starts_with("field `a` is given twice"), "{text}: {error}");
        }
        assert!(value("{\"a\": {\"a\": 1}, \"A\": {\"a\": 1}}").is_ok());
    }
}
