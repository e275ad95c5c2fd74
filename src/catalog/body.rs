//! A body's record: identity, figure, light, maps, motion, rotation, rings, air.
//!
//! Plain values, as the reader of catalog files makes them.

use glam::{DVec3, Vec3};
use std::collections::BTreeMap;

/// A NAIF integer code: a body (`399` the Earth), a system barycentre (`1`..`9`), or `0`, the solar system barycentre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct NaifId(pub i32);

impl NaifId {
    /// The root of all positions.
    pub const SOLAR_SYSTEM_BARYCENTER: Self = Self(0);
    /// What the planetary theories place in place of the Earth.
    pub const EARTH_MOON_BARYCENTER: Self = Self(3);
    /// The star of the system.
    pub const SUN: Self = Self(10);
    /// The planet, not its system.
    pub const EARTH: Self = Self(399);
    /// The Earth's moon.
    pub const MOON: Self = Self(301);
}

/// What a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    /// It shines by itself.
    Star,
    /// One of the eight.
    Planet,
    /// Round, in an orbit that it shares.
    DwarfPlanet,
    /// Its parent is no star.
    Moon,
    /// A small body about the Sun.
    Asteroid,
}

/// How a surface turns sunlight into radiance. The numbers are uniforms; the variant is structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Photometry {
    /// Glows by itself; limb darkening I(mu)/I(1) = 1 - u1 (1-mu) - u2 (1-mu)^2 per linear RGB channel.
    Emissive {
        /// Linear term, per linear RGB channel.
        u1: [f64; 3],
        /// Quadratic term, per linear RGB channel.
        u2: [f64; 3],
    },
    /// Equally bright from every direction.
    Lambert,
    /// mu0/(mu+mu0): dark, porous ground.
    LommelSeeliger,
    /// McEwen's blend: 2 L mu0/(mu+mu0) + (1-L) mu0.
    LunarLambert {
        /// L, 0 to 1.
        lunar_weight: f64,
    },
    /// Roughness as the standard deviation of facet slopes, degrees.
    OrenNayar {
        /// 0 to 60.
        roughness_deg: f64,
    },
}

/// Which latitude the rows of a map count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapLatitude {
    /// Angle of the ellipsoid's normal to the equator.
    Planetographic,
    /// Angle of the line from the centre to the equator.
    Planetocentric,
}

/// One equirectangular map: longitude 0 at the centre, east to the right, north up.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// File name inside textures/ (embedded) or `--textures`.
    pub file: String,
    /// Linear factor per channel that brings the decoded map to the body's published colour and albedo.
    pub gain: [f64; 3],
    /// Which latitude its rows count.
    pub latitude: MapLatitude,
    /// Its width, texels, where the catalog says it: what is finer than a texel can be decided before the map is read.
    pub columns: Option<u32>,
    /// What of it nobody has measured, and what it was made from; `None`: all of it is pictures or measurements.
    pub invented: Option<String>,
}

/// A body's maps; a missing one is drawn by its mean or not at all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// Colour of the ground.
    pub albedo: Option<Map>,
    /// Slopes of the ground, tangent space: red east, green north.
    pub normal: Option<Map>,
    /// White where water mirrors the Sun.
    pub specular: Option<Map>,
    /// City lights of the night side.
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
    /// Of a closed deck.
    pub closed_texel: f64,
}

/// Which theory places a body, relative to its parent.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// The kernel and the planetary series know this code.
    Planetary,
    /// L1.2, index 0 Io .. 3 Callisto.
    GalileanL12 {
        /// 0 Io to 3 Callisto.
        index: usize,
    },
    /// TASS 1.7, index in the table's order.
    Tass17 {
        /// 0 Mimas to 7 Hyperion.
        index: usize,
    },
    /// Mean elements; see catalogs/README.md for the formula.
    MeanElements(MeanElements),
}

/// Mean orbital elements about the parent, in the frame whose pole is given (x axis at the pole's RA + 90 degrees).
#[derive(Clone, Debug, PartialEq)]
pub struct MeanElements {
    /// Right ascension of the frame's pole, ICRF.
    pub pole_ra_deg: f64,
    /// Declination of the frame's pole, ICRF.
    pub pole_dec_deg: f64,
    /// Julian date, TT, at which the elements hold.
    pub epoch_jd_tt: f64,
    /// Of the ellipse.
    pub semi_major_axis_km: f64,
    /// 0 to below 1.
    pub eccentricity: f64,
    /// Against the frame's equator.
    pub inclination_deg: f64,
    /// Longitude of the ascending node, from the frame's x axis.
    pub node_deg: f64,
    /// From the ascending node.
    pub argument_of_periapsis_deg: f64,
    /// At the epoch.
    pub mean_anomaly_deg: f64,
    /// Of the mean anomaly.
    pub mean_motion_deg_day: f64,
    /// Julian years; 0 = does not precess.
    pub node_period_yr: f64,
    /// Of the argument of periapsis, Julian years; 0 = does not precess.
    pub argument_period_yr: f64,
    /// Coefficient of T² in the mean longitude, degrees per Julian century squared, T from the epoch: what a tide does to the motion. 0 = none known.
    pub longitude_quadratic_deg_cy2: f64,
}

/// Which model turns a body.
#[derive(Clone, Debug, PartialEq)]
pub enum Rotation {
    /// IAU 2006 precession, nutation, UT1.
    EarthIau2006,
    /// The text PCK has this body's pole and prime meridian.
    Pck,
    /// Turns once an orbit, the same face to the parent, pole along the orbit's normal.
    Synchronous,
    /// Pole and spin given here (bodies that the PCK lacks).
    Fixed {
        /// Right ascension of the north pole, ICRF.
        pole_ra_deg: f64,
        /// Declination of the north pole, ICRF.
        pole_dec_deg: f64,
        /// Angle of the prime meridian at J2000 (TDB).
        w0_deg: f64,
        /// Its change a day.
        w_deg_day: f64,
    },
}

/// One ring, flat and even, in the plane of its body's equator.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// As astronomers call it.
    pub name: String,
    /// Radius of the inner edge.
    pub inner_km: f64,
    /// Radius of the outer edge.
    pub outer_km: f64,
    /// Optical depth along the normal.
    pub tau_normal: f64,
    /// Single-scattering albedo per linear RGB channel that makes single scattering as bright as what is observed.
    pub albedo: [f64; 3],
    /// Part of its light that dust scatters forward.
    pub dust: f64,
}

/// A gas or aerosol with an exponential profile (or a tent when `tent_centre_km` is set).
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// Of the gas or aerosol.
    pub name: String,
    /// Of the exponential; of a tent its half width.
    pub scale_height_km: f64,
    /// Height of a tent's peak; `None`: an exponential profile.
    pub tent_centre_km: Option<f64>,
    /// Linear sRGB channel means, per kilometre, at the reference level.
    pub scattering_per_km: [f64; 3],
    /// As the scattering.
    pub absorption_per_km: [f64; 3],
    /// Henyey-Greenstein asymmetry; `None` is Rayleigh's phase function.
    pub asymmetry: Option<f64>,
    /// By how much scattering and absorption may be off, where no published table was read.
    pub estimate_percent: Option<f64>,
}

/// By how much a value may be off that was not read in a published table, percent of it; `None` was read there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimates {
    /// Of the geometric albedo.
    pub albedo_percent: Option<f64>,
    /// Of the colour.
    pub colour_percent: Option<f64>,
}

/// Images that one body may have.
pub const MAX_OVERLAYS: u8 = 2;

/// Where an overlay's image lies. Latitudes are planetographic, longitudes east; north is up in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Even in longitude and latitude.
    Equirectangular {
        /// Longitude of the left edge.
        west_deg: f64,
        /// Longitude of the right edge, by 360 at most above the left.
        east_deg: f64,
        /// Latitude of the lower edge.
        south_deg: f64,
        /// Latitude of the upper edge.
        north_deg: f64,
    },
    /// Seen from far above a place, straight down.
    Orthographic {
        /// Of the place below the image's middle.
        latitude_deg: f64,
        /// Of the place below the image's middle.
        longitude_deg: f64,
        /// Of the whole image.
        width_km: f64,
        /// Of the whole image.
        height_km: f64,
    },
}

/// An image laid over a body's ground by its alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// What users switch it by; single within its body.
    pub name: String,
    /// File name inside `--textures` or textures/.
    pub file: String,
    /// Linear factor per channel from the image's colour to albedo.
    pub gain: [f64; 3],
    /// On its alpha.
    pub opacity: f64,
    /// Where it lies.
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

/// The air around a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Atmosphere {
    /// Height above which there is none.
    pub top_km: f64,
    /// Refractive index less 1 at the reference level, green light; `None`: its bending of light is not counted.
    pub refractivity: Option<f64>,
    /// Luminance of its glow at night, straight up; `None`: not known, and left out.
    pub airglow_cd_m2: Option<f64>,
    /// Rayleigh gas, Mie aerosol and absorption layers.
    pub species: Vec<Species>,
}

/// Everything known of one body. Lengths in kilometres, angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its NAIF code.
    pub id: NaifId,
    /// In English, without an article.
    pub name: String,
    /// Other names that [`find_body_or_barycenter`](super::Catalog::find_body_or_barycenter) finds.
    pub aliases: Vec<String>,
    /// Star, planet, moon and so on.
    pub kind: BodyKind,
    /// What it moves about; `None`: the Sun.
    pub parent: Option<NaifId>,
    /// Semi-axes: x through the prime meridian, y at 90 degrees east, z the pole.
    pub radii_km: DVec3,
    /// Gravitational parameter, km³/s².
    pub gm_km3_s2: Option<f64>,
    /// V-band geometric albedo (0 for the Sun).
    pub geometric_albedo: f64,
    /// Reflected part of all sunlight.
    pub bond_albedo: Option<f64>,
    /// Geometric albedo of the ground alone where the map shows it without the clouds that the whole disc has.
    pub clear_sky_albedo: Option<f64>,
    /// Linear sRGB of the mean disc, scaled to luminance 1: what an eye would see, without the brightness.
    pub colour: Vec3,
    /// Old ground, covered with craters down to the smallest: finer ones than its map holds may be invented near it.
    pub cratered: bool,
    /// Which custom surface colours its ground: 0 for none, else 1..=4.
    pub custom_surface: u8,
    /// How its ground reflects or shines.
    pub photometry: Photometry,
    /// Pictures of its ground.
    pub maps: Maps,
    /// The first lies under the second.
    pub overlays: Vec<Overlay>,
    /// A deck of them over the ground.
    pub clouds: Option<Clouds>,
    /// A shape in place of the ellipsoid.
    pub mesh: Option<ShapeModel>,
    /// What places it.
    pub motion: Motion,
    /// What turns it.
    pub rotation: Rotation,
    /// From the inside out.
    pub rings: Vec<Ring>,
    /// Its air.
    pub atmosphere: Option<Atmosphere>,
    /// Where the values come from, by topic (`radii`, `gm`, `albedo`, `colour`, ...).
    pub sources: BTreeMap<String, String>,
    /// Values that were not read in a published table.
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
