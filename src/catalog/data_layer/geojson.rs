//! Points and outlines of a GeoJSON file (RFC 7946): of every geometry of a FeatureCollection or a Feature, with the property `time` of its Feature, or of a
//! geometry alone.
//!
//! In: the document, where a position is longitude (east-positive), then latitude. Out: points and lines, where latitude comes first; or an error with line
//! number and field. A polygon is read as the outlines of its rings. `time` is text (ISO 8601 UTC or jd_tdb:DAY) or, as in catalogs of earthquakes,
//! milliseconds since 1970. Ignored: heights and other properties. Rejected: a `crs` member that names a coordinate system other than WGS 84.

use super::layer::{Content, check_is_line, checked_position};
use crate::time::Instant;
use crate::wording::echo_within;
use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt::Formatter;

/// Julian date of 1970-01-01.
const JD_1970: f64 = 2_440_587.5;
/// Milliseconds per day.
const MS_PER_DAY: f64 = 8.64e7;
/// Julian date of the end of the year 9999, the last with four digits.
const JD_END_OF_9999: f64 = 5_373_484.5;

/// The value of a `coordinates` member: nested lists of numbers.
enum Coordinates {
    Number(f64),
    /// A list that begins with two numbers: a position whose range was checked, as latitude and longitude, degrees.
    Position([f64; 2]),
    List(Vec<Coordinates>),
}

impl<'de> Deserialize<'de> for Coordinates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct CoordinatesVisitor;
        impl<'de> Visitor<'de> for CoordinatesVisitor {
            type Value = Coordinates;
            fn expecting(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
                f.write_str("field coordinates: numbers in lists")
            }
            fn visit_f64<E>(self, v: f64) -> Result<Coordinates, E> {
                Ok(Coordinates::Number(v))
            }
            fn visit_i64<E>(self, v: i64) -> Result<Coordinates, E> {
                Ok(Coordinates::Number(v as f64))
            }
            fn visit_u64<E>(self, v: u64) -> Result<Coordinates, E> {
                Ok(Coordinates::Number(v as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Coordinates, A::Error> {
                let mut all = Vec::new();
                while let Some(item) = list.next_element::<Coordinates>()? {
                    all.push(item);
                }
                match all[..] {
                    [Coordinates::Number(lon), Coordinates::Number(lat), ..] => checked_position(lon, lat)
                        .map(Coordinates::Position)
                        .map_err(|why| A::Error::custom(format!("field coordinates: {why}"))),
                    [Coordinates::Number(_), ..] => Err(A::Error::custom("field coordinates: a position is [longitude, latitude]")),
                    _ => Ok(Coordinates::List(all)),
                }
            }
        }
        deserializer.deserialize_any(CoordinatesVisitor)
    }
}

/// The points and lines of geometries: each position is latitude and longitude, degrees.
#[derive(Default)]
struct Geometries {
    points: Vec<[f64; 2]>,
    lines: Vec<Vec<[f64; 2]>>,
}

impl Geometries {
    /// The positions of a list; `None` if an item is something else.
    fn positions(list: Vec<Coordinates>) -> Option<Vec<[f64; 2]>> {
        list.into_iter().map(|c| if let Coordinates::Position(p) = c { Some(p) } else { None }).collect()
    }

    /// The lines of a list; `None` if an item is something else.
    fn lines(list: Vec<Coordinates>) -> Option<Vec<Vec<[f64; 2]>>> {
        list.into_iter().map(|c| if let Coordinates::List(items) = c { Self::positions(items) } else { None }).collect()
    }

    /// The points and lines of a geometry whose member `type` is `kind`; `None` if the coordinates are those of another type.
    fn of(kind: &str, coordinates: Coordinates) -> Option<Self> {
        let points = |points| Self { points, ..Self::default() };
        let lines = |lines| Self { lines, ..Self::default() };
        match (kind, coordinates) {
            // A geometry without positions counts as null (RFC 7946, section 3.1). The other types need no case of their own.
            ("Point" | "LineString", Coordinates::List(l)) if l.is_empty() => Some(Self::default()),
            ("Point", Coordinates::Position(p)) => Some(points(vec![p])),
            ("MultiPoint", Coordinates::List(l)) => Self::positions(l).map(points),
            ("LineString", Coordinates::List(l)) => Self::positions(l).map(|line| lines(vec![line])),
            ("MultiLineString" | "Polygon", Coordinates::List(l)) => Self::lines(l).map(lines),
            ("MultiPolygon", Coordinates::List(l)) => {
                let polygons = l.into_iter().map(|c| if let Coordinates::List(items) = c { Self::lines(items) } else { None });
                polygons.collect::<Option<Vec<_>>>().map(|all| lines(all.into_iter().flatten().collect()))
            }
            _ => None,
        }
    }

    fn add(&mut self, other: Self) {
        self.points.extend(other.points);
        self.lines.extend(other.lines);
    }
}

/// The types of geometries, for messages.
const GEOMETRY_TYPES: &str = "Point, MultiPoint, LineString, MultiLineString, Polygon, MultiPolygon, GeometryCollection";

/// A document, or a Feature of a FeatureCollection: the points and lines of all its geometries, with their times.
#[derive(Default)]
struct Object {
    content: Content,
}

/// The properties of a Feature that are read.
#[derive(Default, Deserialize)]
struct Properties {
    #[serde(default, deserialize_with = "deserialize_time")]
    time: Option<Instant>,
}

/// Reads a time from text, or from a number of milliseconds since 1970. Null and an empty text give `None`.
fn deserialize_time<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Instant>, D::Error> {
    let value = serde_json::Value::deserialize(deserializer)?;
    // At most 40 characters of the value are shown.
    let invalid = |shown: &str| {
        D::Error::custom(format!("field time: `{}` is not ISO 8601 UTC, jd_tdb:DAY or milliseconds since 1970", echo_within(shown, 40)))
    };
    match &value {
        serde_json::Value::Null => Ok(None),
        serde_json::Value::String(text) if text.trim().is_empty() => Ok(None),
        serde_json::Value::String(text) => Instant::parse(text).map(Some).map_err(|_| invalid(text)),
        serde_json::Value::Number(ms) => {
            let jd_utc = ms.as_f64().map(|ms| JD_1970 + ms / MS_PER_DAY).filter(|jd| (0.0..JD_END_OF_9999).contains(jd));
            jd_utc.map(|jd| Some(Instant::from_jd_utc(jd))).ok_or_else(|| invalid(&ms.to_string()))
        }
        other => Err(invalid(&other.to_string())),
    }
}

/// The members of a GeoJSON object as read so far. They may be in any order.
#[derive(Default)]
struct Members {
    /// The member `type`.
    kind: Option<String>,
    coordinates: Option<Coordinates>,
    /// The points and lines of the members `geometry` and `geometries`, still without their time; at the end, also those of `coordinates`.
    geometries: Geometries,
    /// The property `time` of a Feature.
    time: Option<Instant>,
    /// The points and lines, with their times, of the Features in the member `features`.
    content: Content,
    /// Whether the member `features` occurred.
    has_features: bool,
}

impl<'de> Deserialize<'de> for Object {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let ((geometries, time), mut content) = read_object(deserializer)?;
        for point in geometries.points {
            content.add_point(point, time).map_err(D::Error::custom)?;
        }
        for line in geometries.lines {
            content.add_line(line, time).map_err(D::Error::custom)?;
        }
        Ok(Self { content })
    }
}

/// A geometry within another object: it has no time of its own.
struct Geometry(Geometries);

impl<'de> Deserialize<'de> for Geometry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        read_object(deserializer).map(|((geometries, _), _)| Self(geometries))
    }
}

/// The members that are read. Each may occur once; of two, it is unknown which is meant.
const MEMBERS: [&str; 7] = ["type", "coordinates", "geometry", "geometries", "properties", "features", "crs"];

/// The geometries of an object itself, and its property `time`; `None` if it has none.
type TimedGeometries = (Geometries, Option<Instant>);

/// Reads an object: its own geometries with their time, and the content of its `features`.
fn read_object<'de, D: Deserializer<'de>>(deserializer: D) -> Result<(TimedGeometries, Content), D::Error> {
    struct ObjectVisitor;
    impl<'de> Visitor<'de> for ObjectVisitor {
        type Value = (TimedGeometries, Content);
        fn expecting(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
            f.write_str("an object of GeoJSON with its \"type\"")
        }
        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut members = Members::default();
            // Bit k: the k-th of `MEMBERS` has occurred.
            let mut seen = 0_u8;
            while let Some(key) = map.next_key::<String>()? {
                if let Some(k) = MEMBERS.iter().position(|member| *member == key) {
                    if seen >> k & 1 == 1 {
                        return Err(A::Error::custom(format!("field {key}: given twice")));
                    }
                    seen |= 1 << k;
                }
                match key.as_str() {
                    "type" => members.kind = Some(map.next_value()?),
                    "coordinates" => members.coordinates = Some(map.next_value()?),
                    "geometry" => {
                        // A Feature without a place has `null`.
                        let geometry: Option<Geometry> = map.next_value()?;
                        members.geometries.add(geometry.map_or_else(Geometries::default, |g| g.0));
                    }
                    "geometries" => {
                        for geometry in map.next_value::<Vec<Geometry>>()? {
                            members.geometries.add(geometry.0);
                        }
                    }
                    "properties" => members.time = map.next_value::<Option<Properties>>()?.and_then(|p| p.time),
                    "features" => {
                        members.has_features = true;
                        for feature in map.next_value::<Vec<Object>>()? {
                            members.content.append(feature.content).map_err(A::Error::custom)?;
                        }
                    }
                    "crs" => check_crs(&map.next_value()?).map_err(A::Error::custom)?,
                    _ => drop(map.next_value::<IgnoredAny>()?),
                }
            }
            let kind = members.kind.ok_or_else(|| A::Error::custom("an object without its \"type\""))?;
            match (kind.as_str(), members.coordinates) {
                ("FeatureCollection", None) if members.has_features => {}
                ("Feature" | "GeometryCollection", None) => {}
                (_, Some(coordinates)) => {
                    let mismatch =
                        || format!("field coordinates: not those of a {}; geometries are {GEOMETRY_TYPES}", echo_within(&kind, 40));
                    let geometries = Geometries::of(&kind, coordinates).ok_or_else(|| A::Error::custom(mismatch()))?;
                    // Checked here, while the parser is still on the geometry's line, so that the error states that line.
                    geometries.lines.iter().try_for_each(|line| check_is_line(line)).map_err(A::Error::custom)?;
                    members.geometries.add(geometries);
                }
                _ => return Err(A::Error::custom(format!("field type: `{}` without its coordinates or features", echo_within(&kind, 40)))),
            }
            Ok(((members.geometries, members.time), members.content))
        }
    }
    deserializer.deserialize_map(ObjectVisitor)
}

/// Checks a `crs` member, which RFC 7946 removed from the format: accepted are null, and longitude and latitude on WGS 84 (CRS84 or EPSG:4326).
fn check_crs(crs: &serde_json::Value) -> Result<(), String> {
    let name = crs.pointer("/properties/name").and_then(serde_json::Value::as_str).unwrap_or_default();
    match crs.is_null() || name.ends_with("CRS84") || name.ends_with("4326") {
        true => Ok(()),
        false => {
            Err(format!("field crs: `{}` is not longitude and latitude in degrees (urn:ogc:def:crs:OGC:1.3:CRS84)", echo_within(name, 60)))
        }
    }
}

/// The points and lines of a document. The error is a line number, from 1, and what is wrong there.
pub(super) fn read(text: &str) -> Result<Content, (usize, String)> {
    let object: Object = serde_json::from_str(text).map_err(|e| {
        let message = e.to_string();
        let why = message.rsplit_once(" at line ").map_or(message.as_str(), |(why, _)| why);
        // An error without a place has line 0.
        (e.line().max(1), why.to_owned())
    })?;
    if object.content.points.is_empty() && object.content.lines.is_empty() {
        return Err((1, "no geometry in it".to_owned()));
    }
    Ok(object.content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_member_that_is_given_twice_is_an_error() {
        let point = "{\"type\":\"Point\",\n\"coordinates\":[10,20]}";
        assert_eq!(read(point).expect("a point").points.len(), 1);
        // A member of another program may occur any number of times.
        assert!(read(&point.replace('{', "{\"note\":1,\"note\":2,")).is_ok());
        let why = |text: &str| read(text).expect_err("a member is given twice");
        assert_eq!(why(&point.replace('}', ",\n\"coordinates\":[1,2]}")), (3, "field coordinates: given twice".to_owned()));
        let feature = format!("{{\"type\":\"Feature\",\"geometry\":{point},\"geometry\":null}}");
        assert_eq!(why(&feature), (2, "field geometry: given twice".to_owned()));
    }
}
