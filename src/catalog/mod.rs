//! The catalog: bodies (shape, photometry, maps, motion, rotation, rings, atmosphere), moments, instruments, data layers, stars, small bodies, lunar heights.
//!
//! In: the embedded files of catalogs/ and the user's files, as (name, text) pairs. Out: [`Catalog`], checked as a whole: every field is in its range, names
//! are unique and parents are known. The user's stars, small bodies, heights and layers are parsed here, too, and added by `Catalog::with_*`. Not here: access
//! to the file system, and positions.

use crate::wording::{did_you_mean, echo, echo_within, one_line};
use orrery_catalogs::CATALOG_FILES;
use std::collections::BTreeMap;

mod albedo_harmonics;
mod body;
#[doc(hidden)]
pub mod cities;
#[doc(hidden)]
pub mod constellations;
mod csv_line;
mod data_layer;
mod eclipse_radii;
mod fields;
mod instrument;
mod layer_list;
#[doc(hidden)]
pub mod lunar_heights;
pub mod moments;
#[doc(hidden)]
pub mod nomenclature;
mod overlay;
mod read;
mod read_body;
mod read_ring;
#[doc(hidden)]
pub mod small_bodies;
mod species;
#[doc(hidden)]
pub mod stars;
mod table;

pub use albedo_harmonics::AlbedoHarmonics;
pub use body::{
    Atmosphere, Body, BodyKind, Clouds, Estimates, InventedRelief, MAX_OVERLAYS, Map, MapLatitude, Maps, MeanElements, Motion, NaifId,
    Overlay, OverlayProjection, Photometry, Ring, Rotation, ShapeModel,
};
pub use data_layer::{
    ColourMap, DataLayer, DataLine, DataPoint, ImageStyle, ImageWcs, PlacedImage, Stretch, is_layer_file, layer_extensions,
};
pub use eclipse_radii::EclipseRadii;
pub use instrument::{FieldOfView, Instrument};
pub(crate) use instrument::{MAX_FIELD_OF_VIEW_DEG, angle_deg};
use layer_list::LayerList;
use lunar_heights::HeightMap;
use small_bodies::SmallBodies;
pub(crate) use species::PerChannel;
pub use species::{AerosolField, AerosolFunction, AerosolPhase, PhaseFunction, Species};
use stars::StarCatalog;
use std::sync::{Arc, OnceLock};

/// A body and the name of one of its fields.
type BodyField = (NaifId, &'static str);
/// A file and a line number, starting at 1.
type FileLine = (String, usize);

/// All bodies, the well-known moments, stars, small bodies, data layers, instruments, and the user's lunar height map.
#[derive(Clone, Debug, PartialEq)]
pub struct Catalog {
    bodies: Vec<Body>,
    moments: Vec<moments::Moment>,
    data_layers: LayerList,
    instruments: Vec<Instrument>,
    /// The convention by which the radii of the Sun and the Moon in `bodies` were chosen.
    eclipse_radii: EclipseRadii,
    /// The user's stars; `None`: the embedded stars.
    stars: Option<Arc<StarCatalog>>,
    /// Minor planets and comets; the embedded tables are read on first use.
    small_bodies: OnceLock<Arc<SmallBodies>>,
    /// The user's lunar height map; none is embedded.
    lunar_heights: Option<Arc<HeightMap>>,
    /// File and line of the fields `parent`, `motion` and `rotation`, which other modules check against the complete catalog. The entry of the field "" is the
    /// line of the body itself, at which problems of its other fields are reported.
    field_lines: BTreeMap<BodyField, FileLine>,
}

/// One problem of a file: where it is, and what is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file's name as the caller gave it.
    pub file: String,
    /// Line number, starting at 1.
    pub line: usize,
    /// What is wrong. For a field, it usually names the body, the field, its value and the allowed values.
    pub message: String,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // File name and message may quote any text, so control characters are escaped; a problem stays one line.
        write!(f, "{}:{}: {}", one_line(&self.file), self.line, one_line(&self.message))
    }
}

/// All problems of the files. As text it has one line for each of the first `MAX_SHOWN_PROBLEMS`, then the number of the others.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct CatalogError {
    /// In order of file, then line.
    pub problems: Vec<Problem>,
}

impl CatalogError {
    /// A problem of a file as a whole.
    fn in_file(file: String, message: String) -> Self {
        Self { problems: vec![Problem { file, line: 1, message }] }
    }
}

/// Maximum number of problems that a message lists.
const MAX_SHOWN_PROBLEMS: usize = 20;

impl std::fmt::Display for CatalogError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let shown: Vec<String> = self.problems.iter().take(MAX_SHOWN_PROBLEMS).map(Problem::to_string).collect();
        f.write_str(&shown.join("\n"))?;
        match self.problems.len() - shown.len() {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

/// An unknown name, in one line: the name, and the nearest known one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UnknownName(pub String);

/// The form in which names are compared: lower case, `barycenter` for both spellings, and single spaces instead of `_` and `-`.
pub(crate) fn normalized_name(name: &str) -> String {
    let name = name.to_lowercase().replace("barycentre", "barycenter").replace(['_', '-'], " ");
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Whether this normalized name is reserved for a barycentre (see [`Catalog::find_body_or_barycenter`]); no body may have such a name.
fn is_name_of_barycenter(normalized: &str) -> bool {
    matches!(normalized, "ssb" | "emb") || normalized.ends_with(" barycenter")
}

impl Catalog {
    /// The embedded catalog. A test verifies that its files have no problem, so this never panics in a released program.
    pub fn embedded() -> Self {
        match read::read(CATALOG_FILES) {
            Ok(catalog) => catalog,
            Err(e) => panic!("the embedded catalog is broken:\n{e}"),
        }
    }

    /// The embedded catalog, overridden by the user's files: (name, text) pairs in reading order. A `[[body]]` with a known `id` overrides
    /// the fields that it gives; any other adds a body.
    pub fn with_files(files: &[(String, String)]) -> Result<Self, CatalogError> {
        let all: Vec<(&str, &str)> = CATALOG_FILES.iter().copied().chain(files.iter().map(|(n, t)| (n.as_str(), t.as_str()))).collect();
        read::read(&all)
    }

    /// These files alone, without the embedded catalog: for fuzzing, which would otherwise spend its time on the embedded files.
    #[doc(hidden)]
    pub fn of_files_alone(files: &[(&str, &str)]) -> Result<Self, CatalogError> {
        read::read(files)
    }

    /// A problem with a body's field, with its file and line.
    pub fn problem(&self, id: NaifId, field: &'static str, message: String) -> Problem {
        let line_of_field = self.field_lines.get(&(id, field)).or_else(|| self.field_lines.get(&(id, "")));
        let (file, line) = line_of_field.cloned().unwrap_or_default();
        let name = self.body(id).map_or_else(|| format!("body {}", id.0), |b| b.name.clone());
        Problem { file, line, message: format!("{name}.{field}: {message}") }
    }

    /// Every body, in order of NAIF code.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// This catalog with the user's stars; `None`: with the embedded stars.
    pub fn with_stars(self, stars: Option<Arc<StarCatalog>>) -> Self {
        Self { stars, ..self }
    }

    /// Gives a body the custom surface shader with this number, from 1. Returns false if the body already has one, or if there is no such body.
    pub fn set_custom_surface(&mut self, id: NaifId, number: u8) -> bool {
        let body = self.bodies.iter_mut().find(|b| b.id == id && b.custom_surface == 0);
        body.map(|b| b.custom_surface = number).is_some()
    }

    /// The stars. The embedded stars are read on first use.
    pub fn stars(&self) -> Arc<StarCatalog> {
        self.stars.clone().unwrap_or_else(StarCatalog::embedded)
    }

    /// Magnitude of the brightest star; does not read the embedded stars.
    pub fn brightest_magnitude(&self) -> f32 {
        self.stars.as_ref().map_or(stars::EMBEDDED_BRIGHTEST_MAGNITUDE, |s| s.brightest_magnitude())
    }

    /// This catalog with the user's minor planets and comets. Where `supplied` has none of a kind, the embedded ones of that kind stay.
    pub fn with_small_bodies(self, supplied: Option<SmallBodies>) -> Self {
        let Some(supplied) = supplied else { return self };
        let embedded = SmallBodies::embedded();
        let or_embedded = |list: Vec<_>, default: &Vec<_>| if list.is_empty() { default.clone() } else { list };
        let minor_planets = or_embedded(supplied.minor_planets, &embedded.minor_planets);
        let all = SmallBodies { minor_planets, comets: or_embedded(supplied.comets, &embedded.comets) };
        let small_bodies = OnceLock::from(Arc::new(all.without_bodies_of(&self)));
        Self { small_bodies, ..self }
    }

    /// Minor planets and comets, without those that are bodies of the catalog.
    pub fn small_bodies(&self) -> Arc<SmallBodies> {
        Arc::clone(self.small_bodies.get_or_init(|| Arc::new((*SmallBodies::embedded()).clone().without_bodies_of(self))))
    }

    /// This catalog with a lunar height map.
    pub fn with_lunar_heights(self, lunar_heights: Option<Arc<HeightMap>>) -> Self {
        Self { lunar_heights, ..self }
    }

    /// The lunar height map, if the user gave one.
    pub fn lunar_heights(&self) -> Option<&Arc<HeightMap>> {
        self.lunar_heights.as_ref()
    }

    /// The user's data layers: those of the catalog files in their order, then those added at run time.
    pub fn data_layers(&self) -> Vec<Arc<DataLayer>> {
        self.data_layers.all()
    }

    /// This catalog with the content of its data layers. `read` returns a layer with the content of its file ([`DataLayer::with_content`]). An image on a body
    /// becomes one of the body's overlays.
    ///
    /// # Errors
    /// The first error: `read` fails, all layers together have too many positions or too great a total length of lines, or a body would get more than
    /// [`MAX_OVERLAYS`] overlays.
    pub fn with_data<E: From<CatalogError>>(mut self, mut read: impl FnMut(DataLayer) -> Result<DataLayer, E>) -> Result<Self, E> {
        let mut layers: Vec<DataLayer> = Vec::new();
        let mut total = data_layer::TotalSize::default();
        for layer in self.data_layers.all() {
            let layer = read(Arc::unwrap_or_clone(layer))?;
            if let Err(message) = total.add(&layer) {
                return Err(CatalogError::in_file(layer.file, message).into());
            }
            layers.push(layer);
        }
        for layer in &layers {
            let body = self.bodies.iter_mut().find(|b| Some(b.id) == layer.body);
            let Some((body, overlay)) = body.zip(layer.overlay()) else { continue };
            if let Err(message) = overlay::add(&mut body.overlays, overlay) {
                return Err(CatalogError::in_file(layer.file.clone(), message).into());
            }
        }
        Ok(Self { data_layers: LayerList::new(layers), ..self })
    }

    /// Instruments and eyepieces, in the order of the files.
    pub fn instruments(&self) -> &[Instrument] {
        &self.instruments
    }

    /// Adds a layer while the catalog is in use; it replaces a layer of the same name. Not for an image on a body, which is one of the body's overlays and is
    /// added by [`Self::with_data`].
    pub fn add_data_layer(&self, layer: DataLayer) {
        self.data_layers.add(layer);
    }

    /// Well-known moments, sorted by kind, then by time.
    pub fn moments(&self) -> &[moments::Moment] {
        &self.moments
    }

    /// The body with a NAIF code.
    pub fn body(&self, id: NaifId) -> Option<&Body> {
        self.bodies.iter().find(|b| b.id == id)
    }

    /// The moons of a body, in order of NAIF code.
    pub fn moons_of(&self, planet: NaifId) -> impl Iterator<Item = &Body> {
        self.bodies.iter().filter(move |body| body.is_moon_of(planet))
    }

    /// The body to whose system the body with a NAIF code belongs ([`Body::system_planet`]): Saturn for Titan, and Saturn for Saturn itself. An unknown code is
    /// returned unchanged.
    pub fn planet_of(&self, id: NaifId) -> NaifId {
        self.body(id).map_or(id, Body::system_planet)
    }

    /// The body or barycentre with a name: a body's name or alias, `solar system barycenter`, `ssb`, `earth-moon barycenter`, `emb`, or
    /// `<planet> barycenter`; or a NAIF code such as 599. Case and the spelling of barycentre do not matter.
    pub fn find_body_or_barycenter(&self, name_or_code: &str) -> Option<NaifId> {
        let name = normalized_name(name_or_code);
        match name.as_str() {
            "ssb" | "solar system barycenter" => return Some(NaifId::SOLAR_SYSTEM_BARYCENTER),
            "emb" | "earth moon barycenter" => return Some(NaifId::EARTH_MOON_BARYCENTER),
            _ => {}
        }
        if let Some(planet) = name.strip_suffix(" barycenter") {
            // NAIF: the planet of system n has the code 100 n + 99, the system's barycentre the code n.
            let id = self.find_body(planet)?.id.0;
            return (100..1000).contains(&id).then_some(id).filter(|id| id % 100 == 99).map(|id| NaifId(id / 100));
        }
        self.find_body(&name).map(|b| b.id).or_else(|| self.find_naif_code(name_or_code))
    }

    /// The body or barycentre whose NAIF code is written in `text`.
    fn find_naif_code(&self, text: &str) -> Option<NaifId> {
        let id = NaifId(text.trim().parse().ok()?);
        // The codes of the barycentres: 0 of the solar system, 3 of Earth and Moon, n of the system of planet n.
        ((0..=9).contains(&id.0) || self.body(id).is_some()).then_some(id)
    }

    /// The body or barycentre with a name.
    ///
    /// # Errors
    /// The name is unknown; the error suggests another.
    pub fn body_or_barycenter(&self, name: &str) -> Result<NaifId, UnknownName> {
        self.find_body_or_barycenter(name).ok_or_else(|| self.unknown(name, "body or barycentre"))
    }

    /// The body with a name.
    ///
    /// # Errors
    /// The name is unknown (the error suggests another), or it is that of a barycentre.
    pub fn body_named(&self, name: &str) -> Result<&Body, UnknownName> {
        let id = self.find_body_or_barycenter(name).ok_or_else(|| self.unknown(name, "body"))?;
        self.body(id)
            .ok_or_else(|| UnknownName(format!("`{}` is a barycentre, which has no surface: name a body", echo_within(name.trim(), 60))))
    }

    /// The error for an unknown name. `what`: the kind of thing that the name should denote.
    fn unknown(&self, name: &str, what: &str) -> UnknownName {
        let known = self.bodies.iter().flat_map(|b| std::iter::once(&b.name).chain(&b.aliases)).map(String::as_str);
        let hint = did_you_mean(name.trim(), known).unwrap_or_else(|| "`orrery doctor` lists all names".into());
        UnknownName(format!("no {what} is called `{}`; {hint}", echo(name.trim())))
    }

    /// The body with a name, as [`normalized_name`] returns it.
    fn find_body(&self, normalized: &str) -> Option<&Body> {
        let matches = |name: &String| normalized_name(name) == normalized;
        self.bodies.iter().find(|b| matches(&b.name) || b.aliases.iter().any(matches))
    }
}
