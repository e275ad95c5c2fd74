//! Serialisation of a view's options in links and files, as the names that the command line uses.
//!
//! In: values; or names, including those that earlier versions wrote. Out: names; or values. Always: an unknown name is an error that suggests a
//! similar name or lists the known names.

use crate::scene::draw::PixelView;
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{Layers, Projection, Quality, StereoLayout, ToneMap};
use crate::wording::{echo_within, suggestion_or_list};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};

/// Maximum number of characters that a message quotes of an unknown name.
const MAX_ECHO_CHARS: usize = 60;

/// A type with a name for each of its values.
pub(crate) trait NamedOption: Copy + 'static {
    fn names() -> Vec<&'static str>;
    fn name(self) -> &'static str;
    fn by_name(name: &str) -> Option<Self>;
}

/// Implements [`NamedOption`] with the type's inherent methods of the same names.
macro_rules! impl_named_option {
    ($($option:ty),*) => {$(
        impl NamedOption for $option {
            fn names() -> Vec<&'static str> {
                Self::ALL.into_iter().map(Self::name).collect()
            }
            fn name(self) -> &'static str {
                Self::name(self)
            }
            fn by_name(name: &str) -> Option<Self> {
                Self::by_name(name)
            }
        }
    )*};
}

impl_named_option!(PixelView, Projection, Quality, StereoLayout, ToneMap);

/// Stores a value as its name, for `#[serde(with)]`.
pub mod by_name {
    use super::{Deserialize, Deserializer, Error, MAX_ECHO_CHARS, NamedOption, Serializer, echo_within, suggestion_or_list};

    pub(crate) fn serialize<T: NamedOption, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(value.name())
    }

    pub(crate) fn deserialize<'de, T: NamedOption, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        let name = String::deserialize(deserializer)?;
        let unknown = || {
            D::Error::custom(format!("`{}` is not known; {}", echo_within(&name, MAX_ECHO_CHARS), suggestion_or_list(&name, &T::names())))
        };
        T::by_name(&name).ok_or_else(unknown)
    }
}

/// Stores an optional value as its name, for `#[serde(with)]`.
pub mod by_optional_name {
    use super::{Deserializer, NamedOption, Serializer, by_name};
    use serde::{Deserialize, Serialize};

    #[derive(Serialize, Deserialize)]
    #[serde(bound = "T: NamedOption")]
    struct StoredByName<T: NamedOption>(#[serde(with = "by_name")] T);

    pub(crate) fn serialize<T: NamedOption, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
        value.map(StoredByName).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, T: NamedOption, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
        Ok(Option::<StoredByName<T>>::deserialize(deserializer)?.map(|StoredByName(value)| value))
    }
}

/// Stores overrides of effects in the syntax of `--effects`, for `#[serde(with)]`.
pub mod effects {
    use super::{Deserialize, Deserializer, EffectOverrides, Error, Serializer};

    pub(crate) fn serialize<S: Serializer>(effects: &EffectOverrides, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&effects.to_text())
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<EffectOverrides, D::Error> {
        EffectOverrides::parse(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

/// Stores layers in the syntax of `--layers`, for `#[serde(with)]`.
pub mod layers {
    use super::{Deserialize, Deserializer, Error, Layers, Serializer};

    pub(crate) fn serialize<S: Serializer>(layers: &Layers, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&layers.to_text())
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Layers, D::Error> {
        Layers::parse(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip<T: NamedOption + PartialEq + std::fmt::Debug>() {
        for name in T::names() {
            let value = T::by_name(name).expect(name);
            assert_eq!((value.name(), T::by_name(&name.to_uppercase())), (name, Some(value)));
        }
        assert_eq!(T::by_name("nothing"), None);
    }

    #[test]
    fn names_round_trip_in_any_case_and_names_of_earlier_versions_are_read() {
        round_trip::<PixelView>();
        round_trip::<Quality>();
        round_trip::<ToneMap>();
        round_trip::<Projection>();
        round_trip::<StereoLayout>();
        assert_eq!([ToneMap::by_name("film"), ToneMap::by_name("plain")], [Some(ToneMap::Filmic), Some(ToneMap::Clipped)]);
        assert_eq!(PixelView::by_name("shaded"), Some(PixelView::Final));
    }
}
