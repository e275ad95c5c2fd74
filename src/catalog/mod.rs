//! What is known of each body: identity, figure, light, maps, motion, rotation, rings, air.

use glam::{DVec3, Vec3};

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
pub enum Kind {
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
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    pub albedo: Option<Map>,
    pub normal: Option<Map>,
    pub specular: Option<Map>,
    pub night: Option<Map>,
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
}

#[derive(Clone, Debug, PartialEq)]
pub struct Atmosphere {
    pub top_km: f64,
    pub species: Vec<Species>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    pub id: NaifId,
    pub name: String,
    pub kind: Kind,
    pub parent: Option<NaifId>,
    /// Semi-axes: x through the prime meridian, y at 90 degrees east, z the pole.
    pub radii_km: DVec3,
    pub gm_km3_s2: Option<f64>,
    /// V-band geometric albedo (0 for the Sun).
    pub geometric_albedo: f64,
    pub bond_albedo: Option<f64>,
    /// Linear sRGB of the mean disc, scaled to luminance 1: what an eye would see, without the brightness.
    pub colour: Vec3,
    pub photometry: Photometry,
    pub maps: Maps,
    pub motion: Motion,
    pub rotation: Rotation,
    pub rings: Vec<Ring>,
    pub atmosphere: Option<Atmosphere>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Catalog {
    bodies: Vec<Body>,
}

#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct CatalogError(pub String);

impl Catalog {
    /// The catalog that ships inside the program.
    pub fn embedded() -> Self {
        unimplemented!()
    }
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }
    pub fn body(&self, id: NaifId) -> Option<&Body> {
        self.bodies.iter().find(|b| b.id == id)
    }
    /// Case-insensitive; also barycentre names (`mars barycenter`), which are not bodies.
    pub fn find_place(&self, _name: &str) -> Option<NaifId> {
        unimplemented!()
    }
}
