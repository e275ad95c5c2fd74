//! What the viewer asks to see: where the camera stands, where it looks, how wide, how bright.
//!
//! In: plain values from the command line, the window or a camera file. Out: a [`ViewRequest`] that names places by code. Nothing
//! here looks anything up in the ephemeris; names are resolved against the catalog by [`CameraFile::resolve`].

use super::SceneError;
use super::draw::PixelView;
use super::effects::EffectOverrides;
use super::lamps::Lamps;
pub use super::purpose::Purpose;
use crate::catalog::{Catalog, NaifId};
use crate::mesh::Model;
use crate::time::Instant;
use crate::wording::{echo, of_json, or_one_of};
use glam::DVec3;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Axes in which a vector of a request is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axes {
    /// International Celestial Reference Frame.
    #[default]
    Icrf,
    /// Turning with the body that the position names.
    BodyFixed,
}

/// Where the camera stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// Over the target on the side of `towards` (`None`: the Earth's side; for the Earth itself the Sun's side), at a distance
    /// from its centre in equatorial radii (`None`: so that the disc fills 3/4 of the frame's height).
    Over { towards: Option<NaifId>, distance_radii: Option<f64> },
    /// At a body's centre or a barycentre, moving with it: directions carry its stellar aberration. The body itself is not drawn.
    Centre(NaifId),
    /// Above a point of a body's reference ellipsoid: planetographic latitude, east longitude, height along the normal.
    Ground { body: NaifId, latitude_deg: f64, longitude_deg: f64, height_km: f64 },
    /// At an offset from a body's centre.
    Offset { body: NaifId, offset_km: DVec3, axes: Axes },
}

impl Position {
    /// What is up where nothing else is asked for: whoever stands on ground sees its horizon level.
    pub fn usual_up(&self) -> Up {
        match self {
            Self::Ground { .. } => Up::Zenith,
            Self::Over { .. } | Self::Centre(_) | Self::Offset { .. } => Up::North,
        }
    }
}

/// Where the camera looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// At the target.
    Target,
    /// Along a direction; body-fixed axes are those of the body that the position names.
    Along { direction: DVec3, axes: Axes },
}

/// What is up in the picture. A direction along the line of sight is replaced by the next best axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Up {
    /// The north pole of the target (of the body stood on, where there is no target).
    #[default]
    North,
    /// Away from the centre of the body stood on.
    Zenith,
    /// The celestial pole, ICRF +z.
    Celestial,
    /// The pole of the ecliptic of J2000.
    Ecliptic,
    Along {
        direction: DVec3,
        axes: Axes,
    },
}

/// Nearer than this nobody sees a difference: half a level of 255 at mid grey is 0.02 stops.
pub const SETTLED_STOPS: f64 = 0.02;

/// How bright the picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ExposureRequest {
    /// By what fills the frame.
    #[default]
    Auto,
    /// Stops: at 0 a white plane facing the Sun at 1 au reaches linear 1; each stop doubles.
    Stops(f64),
    /// On the way from these stops to those of `Auto`, so far as a part of 0 to 1 says.
    Gliding { from_stops: f64, part: f64 },
}

impl ExposureRequest {
    /// The stops of a picture whose light meter says `metered_stops`.
    pub fn stops_of(self, metered_stops: f64) -> f64 {
        match self {
            Self::Auto => metered_stops,
            Self::Stops(stops) => stops,
            // What nobody sees is the end of the way: the picture at rest is the metered one, wherever the way began.
            Self::Gliding { from_stops, .. } if (metered_stops - from_stops).abs() <= SETTLED_STOPS => metered_stops,
            Self::Gliding { from_stops, part } => from_stops + (metered_stops - from_stops) * part.clamp(0.0, 1.0),
        }
    }
}

/// How light beyond white is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// True to 0.8 of white, then a shoulder, as film has.
    #[default]
    Film,
    /// True up to white, where it is cut.
    Plain,
}

impl ToneMap {
    pub const ALL: [Self; 2] = [Self::Film, Self::Plain];

    pub fn name(self) -> &'static str {
        match self {
            Self::Film => "filmic",
            Self::Plain => "clipped",
        }
    }

    pub fn by_name(name: &str) -> Option<Self> {
        // `film` and `plain` are the names of earlier versions.
        let former = [("film", Self::Film), ("plain", Self::Plain)];
        let known = Self::ALL.map(|t| (t.name(), t)).into_iter().chain(former);
        known.into_iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, t)| t)
    }
}

/// What is drawn over the bodies to explain them, or as a lens would.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    /// The lines on which bodies move about their parents.
    pub orbits: bool,
    /// Names and markers of bodies.
    pub labels: bool,
    /// A line of light around the selected body.
    pub outline: bool,
    /// Light beyond white spreads, as in a lens.
    pub bloom: bool,
}

impl Layers {
    pub const NAMES: [&str; 4] = ["orbits", "labels", "outline", "bloom"];

    fn by_name(&mut self, name: &str) -> Option<&mut bool> {
        match name {
            "orbits" => Some(&mut self.orbits),
            "labels" => Some(&mut self.labels),
            "outline" => Some(&mut self.outline),
            "bloom" => Some(&mut self.bloom),
            _ => None,
        }
    }

    /// Those that are on: `+orbits,+labels`.
    pub fn to_text(mut self) -> String {
        let on = Self::NAMES.into_iter().filter(|name| self.by_name(name).is_some_and(|on| *on));
        on.map(|name| format!("+{name}")).collect::<Vec<_>>().join(",")
    }

    /// Reads `+orbits,-labels`.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let mut layers = Self::default();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let wrong = |why: String| SceneError::Request(format!("layer `{}`: {why}", echo(part)));
            let (on, name) = match (part.strip_prefix('+'), part.strip_prefix('-')) {
                (Some(name), _) => (true, name),
                (_, Some(name)) => (false, name),
                (None, None) => return Err(wrong("write + or - before its name".into())),
            };
            *layers.by_name(name).ok_or_else(|| wrong(or_one_of(name, &Self::NAMES)))? = on;
        }
        Ok(layers)
    }
}

/// Trade of speed for accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    Draft,
    #[default]
    Standard,
    Reference,
}

impl Quality {
    pub const ALL: [Self; 3] = [Self::Draft, Self::Standard, Self::Reference];

    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Standard => "standard",
            Self::Reference => "reference",
        }
    }

    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|q| q.name().eq_ignore_ascii_case(name))
    }
}

/// One view. `target` may be missing only where the look gives a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewRequest {
    pub time: Instant,
    pub target: Option<NaifId>,
    pub position: Position,
    pub look: Look,
    pub up: Up,
    /// Vertical field of view, degrees. `None`: [`FOV_DEFAULT_DEG`], or what fits the target where only that can.
    pub fov_deg: Option<f64>,
    /// Pixels, each 1..=16384.
    pub width: u32,
    pub height: u32,
    pub exposure: ExposureRequest,
    pub tone_map: ToneMap,
    pub effects: EffectOverrides,
    pub layers: Layers,
    /// What the viewer has picked out; `None`: the target.
    pub selected: Option<NaifId>,
    pub quality: Quality,
    pub pixel_view: PixelView,
    /// Map and mesh files that could not be read: bodies go without, and say so.
    pub missing_maps: BTreeSet<String>,
    /// Shape models that were read, by body; [`super::Scene::unread_meshes`] says which are wanted.
    pub meshes: BTreeMap<NaifId, Arc<Model>>,
    /// Lamps of the night that were read, by body; [`super::Scene::unread_lamps`] says which are wanted.
    pub lamps: BTreeMap<NaifId, Arc<Lamps>>,
    /// What the picture is for: below which bound a feature is left out.
    pub purpose: Purpose,
}

/// Field of view when neither it nor a distance is asked for: a long lens, so that nearly a hemisphere shows.
pub const FOV_DEFAULT_DEG: f64 = 20.0;
/// Field of view when a place to stand is given: at 3 radii the disc then fills 85 % of the frame's height.
pub const FOV_AT_DISTANCE_DEG: f64 = 45.0;
/// Part of the frame's height that a fitted disc fills.
pub const FITTED_DISC: f64 = 0.75;

impl ViewRequest {
    /// The default view of a body: see [`Position::Over`].
    pub fn of(target: NaifId, time: Instant) -> Self {
        Self {
            time,
            target: Some(target),
            position: Position::Over { towards: None, distance_radii: None },
            look: Look::Target,
            up: Up::North,
            fov_deg: None,
            width: 1024,
            height: 1024,
            exposure: ExposureRequest::Auto,
            tone_map: ToneMap::Film,
            effects: EffectOverrides::default(),
            layers: Layers::default(),
            selected: None,
            quality: Quality::default(),
            pixel_view: PixelView::Shaded,
            missing_maps: BTreeSet::new(),
            meshes: BTreeMap::new(),
            lamps: BTreeMap::new(),
            purpose: Purpose::Display,
        }
    }

    /// Refuses effects asked of bodies that the catalog does not have.
    pub fn check_bodies(&self, catalog: &Catalog) -> Result<(), SceneError> {
        for name in self.effects.bodies() {
            catalog.named(name).map_err(|e| SceneError::Request(format!("effects: {e}")))?;
        }
        Ok(())
    }

    /// Refuses what no camera can do, naming the value.
    pub fn check(&self) -> Result<(), SceneError> {
        let bad = |what: String| Err(SceneError::Request(what));
        if !(1..=16384).contains(&self.width) || !(1..=16384).contains(&self.height) {
            return bad(format!("size {}x{}: each side must be 1 to 16384 pixels", self.width, self.height));
        }
        if let Some(fov) = self.fov_deg
            && !(1e-7..=170.0).contains(&fov)
        {
            return bad(format!("field of view {fov:?}: must be 0.0000001 to 170 degrees"));
        }
        if let Position::Over { distance_radii: Some(d), .. } = self.position
            && !(d > 0.0 && d.is_finite())
        {
            return bad(format!("distance {d:?} radii: must be a number above 0"));
        }
        if let Position::Ground { latitude_deg, longitude_deg, height_km, .. } = self.position {
            if !(-90.0..=90.0).contains(&latitude_deg) {
                return bad(format!("latitude {latitude_deg:?}: must be -90 to 90 degrees"));
            }
            if !(-360.0..=360.0).contains(&longitude_deg) {
                return bad(format!("longitude {longitude_deg:?}: must be -360 to 360 degrees east"));
            }
            if !(height_km > 0.0 && height_km.is_finite()) {
                return bad(format!("height {height_km:?} km: must be above the ground"));
            }
        }
        if let Position::Offset { offset_km, .. } = self.position
            && !offset_km.is_finite()
        {
            return bad("the camera's offset must be finite".into());
        }
        if let ExposureRequest::Stops(ev) | ExposureRequest::Gliding { from_stops: ev, .. } = self.exposure
            && !(-60.0..=60.0).contains(&ev)
        {
            return bad(format!("exposure {ev:?}: must be -60 to 60 stops"));
        }
        if !self.time.tdb_seconds_past_j2000().is_finite() {
            return bad("the time is not a finite number".into());
        }
        Ok(())
    }
}

/// A JSON object, never a list of its values in order, which serde would take too.
#[derive(Clone, Debug)]
struct Object<T>(T);

impl<'de, T: Deserialize<'de> + Named> Deserialize<'de> for Object<T> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OfMap<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de> + Named> serde::de::Visitor<'de> for OfMap<T> {
            type Value = Object<T>;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(T::NAME)
            }
            fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(serde::de::value::MapAccessDeserializer::new(map)).map(Object)
            }
        }
        deserializer.deserialize_map(OfMap(std::marker::PhantomData))
    }
}

/// What a message calls an object of the camera file.
trait Named {
    const NAME: &'static str;
}
impl Named for CameraFile {
    const NAME: &'static str = "an object {\"position\": {…}, \"look\": {…}, …}";
}
impl Named for PositionFile {
    const NAME: &'static str = "an object {\"body\": …, \"radii\": [x, y, z]}";
}
impl Named for LookFile {
    const NAME: &'static str = "an object {\"at\": …} or {\"direction\": [x, y, z]}";
}

/// The camera file, as JSON. Unknown fields are refused by name.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraFile {
    position: Object<PositionFile>,
    look: Object<LookFile>,
    #[serde(default)]
    up: Option<UpFile>,
    #[serde(default)]
    fov_deg: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PositionFile {
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
struct LookFile {
    at: Option<String>,
    direction: Option<[f64; 3]>,
    #[serde(default)]
    axes: Axes,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected \"up\" as a word (north, zenith, celestial, ecliptic) or as {\"direction\": [x, y, z]}")]
enum UpFile {
    Named(String),
    Along(DirectionFile),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DirectionFile {
    direction: [f64; 3],
    #[serde(default)]
    axes: Axes,
}

/// The schema of [`CameraFile`] in words, for help texts.
pub const CAMERA_FILE_HELP: &str = r#"A camera file is one JSON object:
  {"position": {"body": "earth", "radii": [0, 0, 4]},
   "look": {"at": "earth"}, "up": "celestial", "fov_deg": 40}
position  "body" with one of "radii": [x,y,z] (equatorial radii from its centre),
          "km": [x,y,z], or "latitude_deg" (planetographic), "longitude_deg" (east)
          and "height_km"; "axes": "icrf" (default) or "body-fixed"
look      "at": a body's name, or "direction": [x,y,z] with "axes"
up        "north" (of what is looked at), "zenith", "celestial", "ecliptic", or
          {"direction": [x,y,z], "axes": ...}; default: on the ground "zenith",
          else "north"
fov_deg   vertical field of view, degrees"#;

fn direction(values: [f64; 3], what: &str) -> Result<DVec3, SceneError> {
    let v = DVec3::from_array(values);
    if v.is_finite() && v.length() > 0.0 { Ok(v) } else { Err(SceneError::Request(format!("{what}: the direction must not be zero"))) }
}

/// The up direction that a word names.
pub fn up_by_name(name: &str) -> Result<Up, SceneError> {
    match name.to_ascii_lowercase().as_str() {
        "north" => Ok(Up::North),
        "zenith" => Ok(Up::Zenith),
        "celestial" => Ok(Up::Celestial),
        "ecliptic" => Ok(Up::Ecliptic),
        _ => {
            let meant = or_one_of(name, &["north", "zenith", "celestial", "ecliptic"]);
            Err(SceneError::Request(format!("up `{}`: {meant}", echo(name))))
        }
    }
}

impl CameraFile {
    /// Reads the JSON text; `file` names it in errors.
    pub fn parse(file: &str, text: &str) -> Result<Self, SceneError> {
        let whole: Object<Self> = serde_json::from_str(text).map_err(|e| {
            let (line, column) = (e.line().max(1), e.column().max(1));
            SceneError::Request(format!("{file}:{line}:{column}: {}", echo(&of_json(&e))))
        })?;
        Ok(whole.0)
    }

    /// Puts position, look, up and field of view of the file into a request. The target becomes the body looked at.
    pub fn resolve(&self, catalog: &Catalog, request: &mut ViewRequest) -> Result<(), SceneError> {
        let place = |name: &str| catalog.place(name);
        let p = &self.position.0;
        let body = place(&p.body)?;
        request.position = match (p.radii, p.km, p.latitude_deg, p.longitude_deg) {
            (Some(radii), None, None, None) => {
                let radius_km = catalog.named(&p.body)?.radii_km.x;
                Position::Offset { body, offset_km: DVec3::from_array(radii) * radius_km, axes: p.axes }
            }
            (None, Some(km), None, None) => Position::Offset { body, offset_km: DVec3::from_array(km), axes: p.axes },
            (None, None, Some(latitude_deg), Some(longitude_deg)) => {
                Position::Ground { body, latitude_deg, longitude_deg, height_km: p.height_km.unwrap_or(EYE_HEIGHT_KM) }
            }
            _ => {
                let how = "give one of radii, km, or latitude_deg with longitude_deg";
                return Err(SceneError::Request(format!("camera file, position: {how}")));
            }
        };
        let look = &self.look.0;
        match (&look.at, look.direction) {
            (Some(name), None) => {
                request.target = Some(place(name)?);
                request.look = Look::Target;
            }
            (None, Some(d)) => request.look = Look::Along { direction: direction(d, "camera file, look")?, axes: look.axes },
            _ => return Err(SceneError::Request("camera file, look: give one of at, direction".into())),
        }
        match &self.up {
            None => request.up = request.position.usual_up(),
            Some(UpFile::Named(name)) => request.up = up_by_name(name)?,
            Some(UpFile::Along(d)) => request.up = Up::Along { direction: direction(d.direction, "camera file, up")?, axes: d.axes },
        }
        if self.fov_deg.is_some() {
            request.fov_deg = self.fov_deg;
        }
        Ok(())
    }
}

/// Height of a standing viewer's eye, kilometres.
pub const EYE_HEIGHT_KM: f64 = 0.0017;
