//! What is known of each body: identity, figure, light, maps, motion, rotation, rings, air.
//!
//! In: the embedded files of catalogs/ and the user's, as (name, text) pairs. Out: [`Catalog`], checked as a whole: a catalog that exists has
//! every field in its range, single names and known parents. It reads no file system and computes no position.

use crate::wording::{did_you_mean, echo, echo_within, one_line};
use glam::{DVec3, Vec3};
use orrery_catalogs::TABLES;
use std::collections::BTreeMap;

mod eclipse_radii;
pub mod moments;
mod overlay;
mod read;
mod table;

pub use eclipse_radii::EclipseRadii;

/// A NAIF integer code: a body (`399` the Earth), a system barycentre (`1`..`9`), or `0`, the solar system barycentre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct NaifId(pub i32);

impl NaifId {
    pub const SOLAR_SYSTEM_BARYCENTER: Self = Self(0);
    pub const EARTH_MOON_BARYCENTER: Self = Self(3);
    pub const SUN: Self = Self(10);
    pub const EARTH: Self = Self(399);
    pub const MOON: Self = Self(301);
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    Star,
    Planet,
    DwarfPlanet,
    Moon,
    Asteroid,
}

/// How a surface turns sunlight into radiance. The amounts are uniforms; the variant is structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Photometry {
    /// Glows by itself; limb darkening I(mu)/I(1) = 1 - u1 (1-mu) - u2 (1-mu)^2 per linear RGB channel.
    Emissive {
        u1: [f64; 3],
        u2: [f64; 3],
    },
    Lambert,
    LommelSeeliger,
    /// McEwen's blend: 2 L mu0/(mu+mu0) + (1-L) mu0.
    LunarLambert {
        lunar_weight: f64,
    },
    /// Roughness as the standard deviation of facet slopes, degrees.
    OrenNayar {
        roughness_deg: f64,
    },
}

/// Which latitude the rows of a map count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapLatitude {
    Planetographic,
    Planetocentric,
}

/// One equirectangular map: longitude 0 at the centre, east to the right, north up.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// File name inside textures/ (embedded) or `--textures`.
    pub file: String,
    /// Linear factor per channel that brings the decoded map to the body's published colour and albedo.
    pub gain: [f64; 3],
    pub latitude: MapLatitude,
    /// What of it nobody has measured, and what it was made from; `None`: all of it is pictures or measurements.
    pub invented: Option<String>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    pub albedo: Option<Map>,
    pub normal: Option<Map>,
    pub specular: Option<Map>,
    pub night: Option<Map>,
}

/// A shell of cloud over the whole body.
#[derive(Clone, Debug, PartialEq)]
pub struct Clouds {
    /// Opacity, linear in the texel's first channel; the gain is not used.
    pub map: Map,
    /// Above the ellipsoid.
    pub height_km: f64,
    /// Lambert albedo of a closed deck.
    pub albedo: f64,
    /// Texels, 0 to 1, at which the sky is clear, and closed.
    pub clear_texel: f64,
    pub closed_texel: f64,
}

/// Which theory places a body, relative to its parent.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// The kernel and the planetary series know this code.
    Planetary,
    /// L1.2, index 0 Io .. 3 Callisto.
    GalileanL12 { index: usize },
    /// TASS 1.7, index in the table's order.
    Tass17 { index: usize },
    /// Mean elements; see catalogs/README.md for the formula.
    MeanElements(MeanElements),
}

/// Mean orbital elements about the parent, in the frame whose pole is given (x axis at the pole's RA + 90 degrees).
#[derive(Clone, Debug, PartialEq)]
pub struct MeanElements {
    pub pole_ra_deg: f64,
    pub pole_dec_deg: f64,
    pub epoch_jd_tt: f64,
    pub semi_major_axis_km: f64,
    pub eccentricity: f64,
    pub inclination_deg: f64,
    pub node_deg: f64,
    pub argument_of_periapsis_deg: f64,
    pub mean_anomaly_deg: f64,
    pub mean_motion_deg_day: f64,
    /// Julian years; 0 = does not precess.
    pub node_period_yr: f64,
    pub argument_period_yr: f64,
    /// Coefficient of T² in the mean longitude, degrees per Julian century squared, T from the epoch: what a tide does to the motion. 0 = none known.
    pub longitude_quadratic_deg_cy2: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Rotation {
    /// IAU 2006 precession, nutation, UT1.
    EarthIau2006,
    /// The text PCK has this body's pole and prime meridian.
    Pck,
    /// Turns once an orbit, the same face to the parent, pole along the orbit's normal.
    Synchronous,
    /// Pole and spin given here (bodies that the PCK lacks).
    Fixed { pole_ra_deg: f64, pole_dec_deg: f64, w0_deg: f64, w_deg_day: f64 },
}

#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    pub name: String,
    pub inner_km: f64,
    pub outer_km: f64,
    pub tau_normal: f64,
    /// Single-scattering albedo per linear RGB channel that makes single scattering as bright as what is observed.
    pub albedo: [f64; 3],
    /// Part of its light that dust scatters forward.
    pub dust: f64,
}

/// A gas or aerosol with an exponential profile (or a tent when `tent_centre_km` is set).
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    pub name: String,
    pub scale_height_km: f64,
    pub tent_centre_km: Option<f64>,
    /// Linear sRGB channel means, per kilometre, at the reference level.
    pub scattering_per_km: [f64; 3],
    pub absorption_per_km: [f64; 3],
    /// Henyey-Greenstein asymmetry; `None` is Rayleigh's phase function.
    pub asymmetry: Option<f64>,
    /// By how much scattering and absorption may be off, where no published table was read.
    pub estimate_percent: Option<f64>,
}

/// By how much a value may be off that was not read in a published table, percent of it; `None` was read there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimates {
    pub albedo_percent: Option<f64>,
    pub colour_percent: Option<f64>,
}

/// Images that one body may have.
pub const MAX_OVERLAYS: u8 = 2;

/// Where an overlay's image lies. Latitudes are planetographic, longitudes east; north is up in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Even in longitude and latitude.
    Equirectangular { west_deg: f64, east_deg: f64, south_deg: f64, north_deg: f64 },
    /// Seen from far above a place, straight down.
    Orthographic { latitude_deg: f64, longitude_deg: f64, width_km: f64, height_km: f64 },
}

/// An image laid over a body's ground by its alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    pub name: String,
    /// File name inside `--textures` or textures/.
    pub file: String,
    /// Linear factor per channel from the image's colour to albedo.
    pub gain: [f64; 3],
    /// On its alpha.
    pub opacity: f64,
    pub projection: Projection,
}

/// A shape given by triangles in place of the ellipsoid.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeModel {
    /// A Wavefront OBJ in `--textures` or beside the catalog files; body axes: x through the prime meridian, z the pole.
    pub file: String,
    /// Kilometres to one unit of the file.
    pub scale_km: f64,
    /// Both sides of each triangle are seen.
    pub two_sided: bool,
    /// The albedo map's alpha cuts it out.
    pub alpha: bool,
    /// The colours of the file's vertices multiply the albedo, where it has any.
    pub vertex_colours: bool,
    /// What of it nobody has measured; `None`: a measured shape.
    pub invented: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Atmosphere {
    pub top_km: f64,
    /// Refractive index less 1 at the reference level, green light; `None`: its bending of light is not counted.
    pub refractivity: Option<f64>,
    /// Luminance of its glow at night, straight up; `None`: not known, and left out.
    pub airglow_cd_m2: Option<f64>,
    pub species: Vec<Species>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub id: NaifId,
    pub name: String,
    /// Other names that [`Catalog::find_body_or_barycenter`] takes.
    pub aliases: Vec<String>,
    pub kind: BodyKind,
    pub parent: Option<NaifId>,
    /// Semi-axes: x through the prime meridian, y at 90 degrees east, z the pole.
    pub radii_km: DVec3,
    pub gm_km3_s2: Option<f64>,
    /// V-band geometric albedo (0 for the Sun).
    pub geometric_albedo: f64,
    pub bond_albedo: Option<f64>,
    /// Geometric albedo of the ground alone where the map shows it without the clouds that the whole disc has.
    pub clear_sky_albedo: Option<f64>,
    /// Linear sRGB of the mean disc, scaled to luminance 1: what an eye would see, without the brightness.
    pub colour: Vec3,
    pub photometry: Photometry,
    pub maps: Maps,
    /// The first lies under the second.
    pub overlays: Vec<Overlay>,
    pub clouds: Option<Clouds>,
    pub mesh: Option<ShapeModel>,
    pub motion: Motion,
    pub rotation: Rotation,
    pub rings: Vec<Ring>,
    pub atmosphere: Option<Atmosphere>,
    /// Where the values come from, by topic (`radii`, `gm`, `albedo`, `colour`, ...).
    pub sources: BTreeMap<String, String>,
    pub estimates: Estimates,
}

impl Body {
    /// What of the body rests on estimates, and what that does to a picture; a line for each.
    pub fn estimate_notes(&self) -> Vec<String> {
        // A part too little is more magnitudes than the same part too much.
        let magnitudes = |percent: f64| -2.5 * (1.0 - percent / 100.0).log10();
        let albedo = self.estimates.albedo_percent.map(|p| {
            let value = self.geometric_albedo;
            format!("albedo {value}: an estimate, +-{p} %: changes brightness by up to {:.2} mag", magnitudes(p))
        });
        let colour =
            self.estimates.colour_percent.map(|p| format!("colour: an estimate, +-{p} %: changes red or blue against green by up to that"));
        let species = self.atmosphere.iter().flat_map(|air| &air.species);
        let air = species.filter_map(|s| {
            let p = s.estimate_percent?;
            Some(format!("{} of the atmosphere: an estimate, +-{p} %: changes its optical depth by up to that", s.name))
        });
        albedo.into_iter().chain(colour).chain(air).collect()
    }

    /// The mean linear RGB that the albedo map times its gain has over the sphere: the body's colour times its geometric albedo (the Sun: 1).
    /// The Earth's map shows its ground without cloud and air, so its target is that of a clear sky: a luminance of 0.11, not 0.434.
    pub fn target_mean_colour(&self) -> [f64; 3] {
        let level = match self.kind {
            BodyKind::Star => 1.0,
            _ => self.clear_sky_albedo.unwrap_or(self.geometric_albedo),
        };
        self.colour.to_array().map(|c| f64::from(c) * level)
    }

    /// Factor on z that turns a point of the unit-sphere frame into the direction whose latitude the body's maps count.
    pub fn map_latitude_stretch(&self) -> f64 {
        let latitude = self.maps.albedo.as_ref().or(self.maps.night.as_ref()).map_or(MapLatitude::Planetocentric, |m| m.latitude);
        let polar_ratio = self.radii_km.z / self.radii_km.x;
        // Planetographic latitude is that of the normal: the unit-sphere point divided by the semi-axes. Planetocentric: times them.
        match latitude {
            MapLatitude::Planetocentric => polar_ratio,
            MapLatitude::Planetographic => 1.0 / polar_ratio,
        }
    }
}

/// A body and the name of one of its fields.
type BodyField = (NaifId, &'static str);
/// A file and a line of it, the first is 1.
type FileLine = (String, usize);

#[derive(Clone, Debug, PartialEq)]
pub struct Catalog {
    bodies: Vec<Body>,
    moments: Vec<moments::Moment>,
    eclipse_radii: EclipseRadii,
    /// File and line of the fields that only the whole can check, by body and field; a field that is not here stands with its body, under "".
    field_lines: BTreeMap<BodyField, FileLine>,
}

/// One wrong field: where, what it says, what is allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    pub file: String,
    /// First line is 1.
    pub line: usize,
    pub message: String,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Both repeat what stands in files: a fault stays on its line.
        write!(f, "{}:{}: {}", one_line(&self.file), self.line, one_line(&self.message))
    }
}

/// Every problem of the files, by file and line; printed one a line, the first [`MAX_SHOWN_PROBLEMS`] and how many more there are.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct CatalogError {
    pub problems: Vec<Problem>,
}

/// Problems that a message lists.
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

/// A name that no body has. One line: the name, and the nearest.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct UnknownName(pub String);

impl Catalog {
    /// The catalog that ships inside the program. A test holds that it has no problem, so it never panics in a built program.
    pub fn embedded() -> Self {
        match read::read(TABLES) {
            Ok(catalog) => catalog,
            Err(e) => panic!("the embedded catalog is broken:\n{e}"),
        }
    }

    /// The embedded catalog under the user's files: (name, text) pairs in reading order. A `[[body]]` whose `id` is known overrides the
    /// fields it gives; another adds a body.
    pub fn with_files(files: &[(String, String)]) -> Result<Self, CatalogError> {
        let all: Vec<(&str, &str)> = TABLES.iter().copied().chain(files.iter().map(|(n, t)| (n.as_str(), t.as_str()))).collect();
        read::read(&all)
    }

    /// A problem of a body's field, with its file and line.
    pub fn problem(&self, id: NaifId, field: &'static str, message: String) -> Problem {
        let place = self.field_lines.get(&(id, field)).or_else(|| self.field_lines.get(&(id, "")));
        let (file, line) = place.cloned().unwrap_or_default();
        let name = self.body(id).map_or_else(|| format!("body {}", id.0), |b| b.name.clone());
        Problem { file, line, message: format!("{name}.{field}: {message}") }
    }

    /// Every body, by rising NAIF code.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Well-known moments, by kind and time.
    pub fn moments(&self) -> &[moments::Moment] {
        &self.moments
    }

    pub fn body(&self, id: NaifId) -> Option<&Body> {
        self.bodies.iter().find(|b| b.id == id)
    }

    /// The place of a name: a body's name or alias, `solar system barycenter`, `ssb`, `earth-moon barycenter`, `emb`, or
    /// `<planet> barycenter`. Case and the spelling of barycentre do not matter.
    pub fn find_body_or_barycenter(&self, name: &str) -> Option<NaifId> {
        let wanted = name.trim().to_lowercase().replace("barycentre", "barycenter").replace(['_', '-'], " ");
        let wanted = wanted.split_whitespace().collect::<Vec<_>>().join(" ");
        match wanted.as_str() {
            "ssb" | "solar system barycenter" => return Some(NaifId::SOLAR_SYSTEM_BARYCENTER),
            "emb" | "earth moon barycenter" | "earth barycenter" => return Some(NaifId::EARTH_MOON_BARYCENTER),
            _ => {}
        }
        if let Some(planet) = wanted.strip_suffix(" barycenter") {
            let id = self.find_body(planet)?.id.0;
            return (100..1000).contains(&id).then_some(id).filter(|id| id % 100 == 99).map(|id| NaifId(id / 100));
        }
        self.find_body(&wanted).map(|b| b.id)
    }

    /// The place of a name.
    ///
    /// # Errors
    /// What the name may have meant.
    pub fn place(&self, name: &str) -> Result<NaifId, UnknownName> {
        self.find_body_or_barycenter(name).ok_or_else(|| self.unknown(name, "body or centre of mass"))
    }

    /// The body of a name.
    ///
    /// # Errors
    /// What the name may have meant, or that it is a centre of mass.
    pub fn named(&self, name: &str) -> Result<&Body, UnknownName> {
        let id = self.find_body_or_barycenter(name).ok_or_else(|| self.unknown(name, "body"))?;
        self.body(id).ok_or_else(|| {
            UnknownName(format!("`{}` is a centre of mass, which has no surface: name a body", echo_within(name.trim(), 60)))
        })
    }

    fn unknown(&self, name: &str, what: &str) -> UnknownName {
        let known = self.bodies.iter().flat_map(|b| std::iter::once(&b.name).chain(&b.aliases)).map(String::as_str);
        let hint = did_you_mean(name.trim(), known).unwrap_or_else(|| "`orrery doctor` lists all names".into());
        UnknownName(format!("no {what} is called `{}`; {hint}", echo(name.trim())))
    }

    fn find_body(&self, lower: &str) -> Option<&Body> {
        let same = |n: &String| n.to_lowercase().replace(['_', '-'], " ") == lower;
        self.bodies.iter().find(|b| same(&b.name) || b.aliases.iter().any(same))
    }
}
