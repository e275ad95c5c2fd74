//! The camera file: position, direction of view (`look`), up direction and field of view as JSON.
//!
//! In: the text of a file. Out: [`CameraFile`]; [`CameraFile::resolve`] looks up its names in the catalog. Always: an unknown field is an error that
//! names it.

use crate::catalog::Catalog;
use crate::scene::error::{RequestValue, SceneError};
use crate::scene::request::view_request::{Axes, EYE_HEIGHT_KM, Look, Position, Up, ViewRequest};
use crate::wording::{echo, json_error_text, suggestion_or_list, without_byte_order_mark};
use glam::DVec3;
use serde::Deserialize;

/// A value that must be a JSON object. Without this wrapper serde would also accept an array of the field values, in the order of the fields.
#[derive(Clone, Debug)]
struct Object<T>(T);

impl<'de, T: Deserialize<'de> + DescribedObject> Deserialize<'de> for Object<T> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ObjectVisitor<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de> + DescribedObject> serde::de::Visitor<'de> for ObjectVisitor<T> {
            type Value = Object<T>;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(T::DESCRIPTION)
            }
            fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(serde::de::value::MapAccessDeserializer::new(map)).map(Object)
            }
        }
        deserializer.deserialize_map(ObjectVisitor(std::marker::PhantomData))
    }
}

/// An object of the camera file, with its description in error messages.
trait DescribedObject {
    const DESCRIPTION: &'static str;
}
impl DescribedObject for CameraFile {
    const DESCRIPTION: &'static str = "an object {\"position\": {…}, \"look\": {…}, …}";
}
impl DescribedObject for PositionFields {
    const DESCRIPTION: &'static str = "an object {\"body\": …, \"radii\": [x, y, z]}";
}
impl DescribedObject for LookFields {
    const DESCRIPTION: &'static str = "an object {\"at\": …} or {\"direction\": [x, y, z]}";
}

/// The camera file, as JSON. Unknown fields are rejected by name. [`CAMERA_FILE_HELP`] describes the fields, their units and defaults.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraFile {
    position: Object<PositionFields>,
    look: Object<LookFields>,
    #[serde(default)]
    up: Option<UpField>,
    #[serde(default)]
    mirrored: bool,
    #[serde(default)]
    fov_deg: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PositionFields {
    body: String,
    #[serde(default)]
    axes: Axes,
    radii: Option<[f64; 3]>,
    km: Option<[f64; 3]>,
    latitude_deg: Option<f64>,
    longitude_deg: Option<f64>,
    height_km: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LookFields {
    at: Option<String>,
    direction: Option<[f64; 3]>,
    #[serde(default)]
    axes: Axes,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected \"up\" as a word (north, zenith, celestial, ecliptic) or as {\"direction\": [x, y, z]}")]
enum UpField {
    Named(String),
    Along(DirectionFields),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DirectionFields {
    direction: [f64; 3],
    #[serde(default)]
    axes: Axes,
}

/// The description of [`CameraFile`] for help texts.
pub const CAMERA_FILE_HELP: &str = r#"A camera file is one JSON object:
  {"position": {"body": "earth", "radii": [0, 0, 4]},
   "look": {"at": "earth"}, "up": "celestial", "fov_deg": 40}
position  "body" with one of "radii": [x,y,z] (equatorial radii from its centre),
          "km": [x,y,z] ([0,0,0]: its centre, from where it is not drawn), or
          "latitude_deg" (planetographic), "longitude_deg" (east, planetocentric)
          and "height_km"; "axes": "icrf" (default) or "body-fixed"
look      "at": a body's name, or "direction": [x,y,z] with "axes"
up        "north" (of what is looked at), "zenith", "celestial", "ecliptic", or
          {"direction": [x,y,z], "axes": ...}; default: on the ground "zenith",
          else "north"
fov_deg   vertical field of view, degrees
mirrored  true: the image is mirrored left to right, as a star diagonal does"#;

/// A vector in the direction of `values` that can be normalised: `values` themselves, or, if their squares overflow or vanish, a shorter or longer vector.
/// `None` if `values` are all zero or one of them is not finite.
pub(crate) fn normalisable_direction(values: [f64; 3]) -> Option<DVec3> {
    let given = DVec3::from_array(values);
    let scaled = if given.length_squared().is_normal() { given } else { given / given.abs().max_element() };
    scaled.is_finite().then_some(scaled)
}

/// The vector of a direction; an error if it is zero. `field`: its place in the file, for the error.
fn direction(values: [f64; 3], field: &'static str) -> Result<DVec3, SceneError> {
    normalisable_direction(values).ok_or_else(|| SceneError::CameraField { field, why: "the direction must not be zero".into() })
}

/// The names of the up directions.
pub const UP_NAMES: [&str; 4] = ["north", "zenith", "celestial", "ecliptic"];

/// The up direction of a name such as `zenith`.
pub fn up_by_name(name: &str) -> Result<Up, SceneError> {
    match name.to_ascii_lowercase().as_str() {
        "north" => Ok(Up::North),
        "zenith" => Ok(Up::Zenith),
        "celestial" => Ok(Up::Celestial),
        "ecliptic" => Ok(Up::Ecliptic),
        _ => {
            let suggestion = suggestion_or_list(name, &UP_NAMES);
            Err(SceneError::Request(format!("up `{}`: {suggestion}", echo(name))))
        }
    }
}

impl CameraFile {
    /// Reads the JSON text; `file` names it in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, SceneError> {
        let object: Object<Self> = serde_json::from_str(without_byte_order_mark(text)).map_err(|e| {
            let (line, column) = (e.line().max(1), e.column().max(1));
            SceneError::Request(format!("{file}:{line}:{column}: {}", echo(&json_error_text(&e))))
        })?;
        Ok(object.0)
    }

    /// The field of the file that gives this value of a request; `None` if none does.
    pub(crate) fn field_of(&self, value: RequestValue) -> Option<&'static str> {
        match value {
            RequestValue::FieldOfView => self.fov_deg.map(|_| "fov_deg"),
            RequestValue::Latitude => Some("position.latitude_deg"),
            RequestValue::Longitude => Some("position.longitude_deg"),
            RequestValue::Height => Some("position.height_km"),
            RequestValue::CameraOffset if self.position.0.radii.is_some() => Some("position.radii"),
            RequestValue::CameraOffset => Some("position.km"),
            RequestValue::Size
            | RequestValue::Distance
            | RequestValue::Exposure
            | RequestValue::StarsBoost
            | RequestValue::DomeTilt
            | RequestValue::EyeSeparation
            | RequestValue::TelescopeLength
            | RequestValue::ApparentField
            | RequestValue::Time => None,
        }
    }

    /// Copies position, direction of view, up direction, mirroring and field of view into a request. The body that the camera looks at becomes the target.
    pub fn resolve(&self, catalog: &Catalog, request: &mut ViewRequest) -> Result<(), SceneError> {
        let in_field = |field: &'static str, e: &dyn std::fmt::Display| SceneError::CameraField { field, why: e.to_string() };
        let id_of = |field: &'static str, name: &str| catalog.body_or_barycenter(name).map_err(|e| in_field(field, &e));
        let position = &self.position.0;
        let body = id_of("position.body", &position.body)?;
        // Only a position on the ground has a height. With an offset, a height is an error, because it would have no effect.
        let height_km = position.height_km;
        request.position = match (position.radii, position.km, position.latitude_deg, position.longitude_deg) {
            (Some(radii), None, None, None) if height_km.is_none() => {
                let radius_km = catalog.body_named(&position.body).map_err(|e| in_field("position.body", &e))?.radii_km.x;
                Position::at_offset(body, DVec3::from_array(radii) * radius_km, position.axes)
            }
            (None, Some(km), None, None) if height_km.is_none() => Position::at_offset(body, DVec3::from_array(km), position.axes),
            (None, None, Some(latitude_deg), Some(longitude_deg)) => {
                Position::Ground { body, latitude_deg, longitude_deg, height_km: height_km.unwrap_or(EYE_HEIGHT_KM) }
            }
            _ => {
                let how = "give one of radii, km, or latitude_deg with longitude_deg; height_km only with these angles";
                return Err(in_field("position", &how));
            }
        };
        let look = &self.look.0;
        match (&look.at, look.direction) {
            (Some(name), None) => {
                request.target = Some(id_of("look.at", name)?);
                request.look = Look::Target;
            }
            (None, Some(d)) => request.look = Look::Along { direction: direction(d, "look")?, axes: look.axes },
            _ => return Err(in_field("look", &"give one of at, direction")),
        }
        match &self.up {
            None => request.up = request.position.default_up(),
            Some(UpField::Named(name)) => request.up = up_by_name(name)?,
            Some(UpField::Along(d)) => request.up = Up::Along { direction: direction(d.direction, "up")?, axes: d.axes },
        }
        request.is_mirrored = self.mirrored;
        if self.fov_deg.is_some() {
            request.fov_deg = self.fov_deg;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_order_mark_is_no_part_of_the_file() {
        let why = |text: &str| CameraFile::parse("a.json", text).expect_err("no camera").to_string();
        assert_eq!(why("\u{feff}{\n\"positions\": 1}"), why("{\n\"positions\": 1}"));
        let text = r#"{"position": {"body": "Mars", "radii": [3, 0, 0]}, "look": {"at": "Mars"}}"#;
        for start in ["", "\u{feff}"] {
            let camera = CameraFile::parse("a.json", &format!("{start}{text}")).unwrap_or_else(|e| panic!("{start:?}: {e}"));
            assert_eq!(camera.position.0.radii, Some([3.0, 0.0, 0.0]));
        }
    }

    #[test]
    fn a_camera_file_may_mirror_the_image() {
        let catalog = Catalog::embedded();
        for (field, expected) in [("", false), (r#", "mirrored": true"#, true), (r#", "mirrored": false"#, false)] {
            let text = format!(r#"{{"position": {{"body": "Mars", "radii": [3, 0, 0]}}, "look": {{"at": "Mars"}}{field}}}"#);
            let mut request = ViewRequest::of(crate::catalog::NaifId::EARTH, crate::time::Instant::from_jd_tdb(2_451_545.0));
            CameraFile::parse("a.json", &text).and_then(|camera| camera.resolve(&catalog, &mut request)).expect(field);
            assert_eq!(request.is_mirrored, expected, "{field}");
        }
    }

    #[test]
    fn a_direction_of_any_length_but_zero_can_be_normalised() {
        for length in [1e-300, 1e-160, 1.0, 1e200, f64::MAX] {
            let unit = direction([0.0, -length, 0.0], "look").expect("a direction").normalize();
            assert!((unit - DVec3::NEG_Y).length() < 1e-12, "{length:e}: {unit}");
        }
        assert_eq!(direction([1.0, 2.0, 3.0], "look").expect("a direction"), DVec3::new(1.0, 2.0, 3.0));
        assert!(direction([0.0; 3], "look").unwrap_err().to_string().contains("must not be zero"));
    }
}
