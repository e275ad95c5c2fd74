//! The catalog entry of a body: identity, shape, photometry, maps, motion, rotation, rings, atmosphere.
//!
//! Plain values without a computation of positions: `read` and `read_body` fill them from catalog files and check their ranges.

use super::AlbedoHarmonics;
use super::species::Species;
use crate::message::{Argument, Message, message};
use glam::{DVec2, DVec3, Vec3};
use std::collections::BTreeMap;

/// A NAIF integer code: a body (`399` the Earth), a system barycentre (`1`..`9`), or `0`, the solar system barycentre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct NaifId(pub i32);

impl NaifId {
    /// The solar system barycentre, the origin of all positions.
    pub const SOLAR_SYSTEM_BARYCENTER: Self = Self(0);
    /// The Earth-Moon barycentre, whose position the planetary theories give.
    pub const EARTH_MOON_BARYCENTER: Self = Self(3);
    /// The Sun.
    pub const SUN: Self = Self(10);
    /// The Earth itself, not the Earth-Moon barycentre.
    pub const EARTH: Self = Self(399);
    /// The Earth's moon.
    pub const MOON: Self = Self(301);
}

/// Procedural relief of a body's ground, finer than its maps; shaders/lib/detail.wesl defines it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InventedRelief {
    /// No invented relief: the ground is smooth, or nothing is known about it.
    #[default]
    None,
    /// Craters, for old ground that they cover completely. They are not drawn on a body with an atmosphere or clouds.
    Craters,
    /// Hills, for ground eroded by air, water or ice.
    Hills,
}

/// What a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    /// A star.
    Star,
    /// One of the eight planets.
    Planet,
    /// A dwarf planet.
    DwarfPlanet,
    /// A satellite of a body that is not a star.
    Moon,
    /// A small body about the Sun.
    Asteroid,
}

/// The photometric model of a surface. mu and mu0: cosines of the angles of emission and of incidence. The variant selects the shader; the numbers are
/// uniforms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Photometry {
    /// Emissive, with limb darkening I(mu)/I(1) = 1 - u1 (1-mu) - u2 (1-mu)².
    Emissive {
        /// Linear term, per linear RGB channel.
        u1: [f64; 3],
        /// Quadratic term, per linear RGB channel.
        u2: [f64; 3],
    },
    /// Lambert's law: equal radiance in every direction.
    Lambert,
    /// Lommel-Seeliger, mu0/(mu+mu0), for dark porous regolith.
    LommelSeeliger,
    /// McEwen's lunar-Lambert mixture: 2 L mu0/(mu+mu0) + (1-L) mu0.
    LunarLambert {
        /// L, 0 to 1.
        lunar_weight: f64,
    },
    /// Oren-Nayar: facets that each obey Lambert's law.
    OrenNayar {
        /// Standard deviation of the facets' slopes, 0 to 60.
        roughness_deg: f64,
    },
}

/// The kind of latitude in which the rows of a map are evenly spaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapLatitude {
    /// Planetographic: angle of the ellipsoid's normal to the equator. If the equatorial semi-axes a and b differ, maps are read as if both were the square
    /// root of ab; the sine of the latitude's error is then at most |a - b| / (a + b).
    Planetographic,
    /// Planetocentric: angle of the line from the centre to the equator.
    Planetocentric,
}

/// One equirectangular map: longitude 0 at the centre, east to the right, north up.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// File name inside textures/ (embedded) or `--textures`.
    pub file: String,
    /// Linear factor per channel that scales the decoded map to the body's published colour and albedo.
    pub gain: [f64; 3],
    /// For an albedo map: the mean over the sphere of map times gain, relative to [`Body::mean_reflectance`]. It is 1, unless the published albedo is that of
    /// one side, as the Moon's is that of its near side. Also 1 for any other map.
    pub relative_mean: f64,
    /// The kind of latitude in which its rows are evenly spaced.
    pub latitude: MapLatitude,
    /// Its width in texels, if the catalog states it. The choice of procedural relief needs the width before the map is read.
    pub columns: Option<u32>,
    /// The invented part of the map and its source; `None` if the entire map consists of images or measurements.
    pub invented: Option<String>,
    /// For an albedo map: how bright each side of the body is. As the body rotates, its total brightness changes accordingly. `None`: all sides count as equal.
    pub harmonics: Option<AlbedoHarmonics>,
}

/// A body's maps. A missing map is replaced by a constant or left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// Colour of the ground.
    pub albedo: Option<Map>,
    /// Normal map in tangent space: red east, green north.
    pub normal: Option<Map>,
    /// Specular map: white for water.
    pub specular: Option<Map>,
    /// City lights of the night side.
    pub night: Option<Map>,
}

/// The cloud shell of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Clouds {
    /// Its red channel, read as a linear value from 0 to 1, gives the opacity: 0 up to `clear_texel`, 1 from `closed_texel`, by smoothstep between them. The
    /// map's gain is ignored.
    pub map: Map,
    /// Height above the ellipsoid.
    pub height_km: f64,
    /// Lambert albedo of a closed cloud deck.
    pub albedo: f64,
    /// Largest texel value of a clear sky, 0 to 1.
    pub clear_texel: f64,
    /// Smallest texel value of a closed cloud deck, above `clear_texel`, at most 1.
    pub closed_texel: f64,
}

/// The theory of a body's motion relative to its parent.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// As for the planets and the Moon: from the SPK kernel, the series or the mean elements that the ephemeris has for the body's NAIF code.
    Planetary,
    /// The theory L1.2 of Jupiter's Galilean moons.
    GalileanL12 {
        /// 0 Io to 3 Callisto.
        index: usize,
    },
    /// The theory TASS 1.7 of eight moons of Saturn.
    Tass17 {
        /// 0 Mimas to 7 Hyperion.
        index: usize,
    },
    /// Mean elements; see catalogs/README.md for the formula.
    MeanElements(MeanElements),
}

/// Mean orbital elements about the parent. The z axis of their frame points to the given pole, its x axis to the point of the ICRF equator 90 degrees east of
/// the pole's right ascension.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanElements {
    /// Right ascension of the frame's pole, ICRF.
    pub pole_ra_deg: f64,
    /// Declination of the frame's pole, ICRF.
    pub pole_dec_deg: f64,
    /// Epoch of the elements: Julian date, TT.
    pub epoch_jd_tt: f64,
    /// Semi-major axis.
    pub semi_major_axis_km: f64,
    /// Eccentricity, 0 to below 1.
    pub eccentricity: f64,
    /// Inclination to the frame's equator.
    pub inclination_deg: f64,
    /// Longitude of the ascending node, from the frame's x axis.
    pub node_deg: f64,
    /// Argument of periapsis, from the ascending node.
    pub argument_of_periapsis_deg: f64,
    /// Mean anomaly at the epoch.
    pub mean_anomaly_deg: f64,
    /// Mean motion: rate of the mean longitude at the epoch. The mean anomaly's rate is less by the rates of node and argument (catalogs/README.md).
    pub mean_motion_deg_day: f64,
    /// Precession period of the node, Julian years; 0: none. If positive, the node regresses in a prograde orbit and advances in a retrograde one.
    pub node_period_yr: f64,
    /// Precession period of the argument of periapsis, Julian years; 0: none. If positive, the argument increases.
    pub argument_period_yr: f64,
    /// Tidal acceleration: coefficient of T² in the mean longitude, T in Julian centuries from the epoch. 0: none known.
    pub longitude_quadratic_deg_cy2: f64,
}

/// The rotation model of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum Rotation {
    /// IAU 2006 precession, nutation, UT1.
    EarthIau2006,
    /// Pole and prime meridian from NAIF's text PCK (planetary constants kernel).
    Pck,
    /// Tidally locked: one rotation per orbit, pole along the orbit's normal.
    Synchronous,
    /// Pole and spin given here (bodies that the PCK lacks).
    Fixed {
        /// Right ascension of the north pole, ICRF.
        pole_ra_deg: f64,
        /// Declination of the north pole, ICRF.
        pole_dec_deg: f64,
        /// Angle W at J2000 (TDB): along the equator from its ascending node on the ICRF equator east to the prime meridian.
        w0_deg: f64,
        /// Rate of W.
        w_deg_day: f64,
    },
}

/// One flat homogeneous ring in the plane of its body's equator.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// The ring's name in astronomy.
    pub name: String,
    /// Radius of the inner edge.
    pub inner_km: f64,
    /// Radius of the outer edge.
    pub outer_km: f64,
    /// Optical depth along the normal.
    pub tau_normal: f64,
    /// Effective single-scattering albedo per linear RGB channel, which includes multiple scattering; chosen by eye for the brightness in images
    /// (catalogs/README.md).
    pub albedo: [f64; 3],
    /// Fraction of the scattered light, summed over all directions, that comes from dust. Dust scatters forward.
    pub dust_fraction: f64,
}

/// Estimated errors of values that were not taken from a published table, in percent; `None` for a published value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimates {
    /// Error of the geometric albedo.
    pub albedo_percent: Option<f64>,
    /// Error of the colour.
    pub colour_percent: Option<f64>,
}

/// Maximum number of overlays of a body.
pub const MAX_OVERLAYS: u8 = 2;

/// The map projection of an overlay. Latitudes are planetographic, longitudes planetocentric and east; north is up in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OverlayProjection {
    /// Equirectangular: linear in longitude and latitude.
    Equirectangular {
        /// Longitude of the left edge.
        west_deg: f64,
        /// Longitude of the right edge, at most 360 above the left.
        east_deg: f64,
        /// Latitude of the lower edge.
        south_deg: f64,
        /// Latitude of the upper edge.
        north_deg: f64,
    },
    /// Orthographic: seen from far above a place.
    Orthographic {
        /// Latitude of the place at the image's centre.
        latitude_deg: f64,
        /// Longitude of the place at the image's centre.
        longitude_deg: f64,
        /// Width of the entire image.
        width_km: f64,
        /// Height of the entire image.
        height_km: f64,
    },
}

/// An image blended over a body's ground by its alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// Name by which users switch it on and off; unique within its body.
    pub name: String,
    /// File name inside `--textures` or textures/.
    pub file: String,
    /// Linear factor per channel from the image's colour to albedo.
    pub gain: [f64; 3],
    /// Factor on its alpha.
    pub opacity: f64,
    /// Its projection and extent.
    pub projection: OverlayProjection,
}

/// A shape model of triangles that replaces the ellipsoid.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeModel {
    /// A Wavefront OBJ in `--textures` or in the folder of the catalog files; body axes: x through the prime meridian, z the pole.
    pub file: String,
    /// Kilometres per unit of the file.
    pub scale_km: f64,
    /// Whether both sides of each triangle are visible.
    pub two_sided: bool,
    /// Whether the albedo map's alpha makes parts of the mesh transparent.
    pub has_map_alpha: bool,
    /// Whether the file's vertex colours, if any, multiply the albedo.
    pub uses_vertex_colours: bool,
    /// The invented part of the shape; `None` for a measured shape.
    pub invented: Option<String>,
}

/// The atmosphere of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Atmosphere {
    /// Height of its top, above which it is not drawn. Sunlight is also dimmed by the part of the species above the top.
    pub top_km: f64,
    /// Refractivity (refractive index minus 1) in green light at height 0, on the ellipsoid; `None`: refraction is left out.
    pub refractivity: Option<f64>,
    /// Haze that only dims refracted light: the height at which the optical depth of a grazing ray in it is 1, and its scale height; `None`: no such haze.
    pub limb_haze_km: Option<[f64; 2]>,
    /// Luminance of its airglow in the zenith, seen from the ground; `None`: left out.
    pub airglow_cd_m2: Option<f64>,
    /// Light that haze or dust adds to that of the ground, in rows of ascending phase angle. Each row: the phase angle in degrees, then the mean radiance of
    /// the disc under irradiance 1, linear RGB; as in the geometric albedo, 1 is that of a white Lambert disc that faces the Sun. Linear between rows, constant
    /// beyond them. The published phase law of a body includes this light.
    pub forward_light: Vec<[f64; 4]>,
    /// Rayleigh gas, Mie aerosol and absorption layers.
    pub species: Vec<Species>,
}

/// All catalog values of one body. Lengths in kilometres, angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its NAIF code.
    pub id: NaifId,
    /// Its English name, without an article.
    pub name: String,
    /// Other names that [`find_body_or_barycenter`](super::Catalog::find_body_or_barycenter) finds.
    pub aliases: Vec<String>,
    /// Star, planet, moon and so on.
    pub kind: BodyKind,
    /// The body that it orbits; `None` for the Sun.
    pub parent: Option<NaifId>,
    /// Semi-axes: x through the prime meridian, y at 90 degrees east, z the pole.
    pub radii_km: DVec3,
    /// Gravitational parameter, km³/s²; `None`: unknown.
    pub gm_km3_s2: Option<f64>,
    /// V-band geometric albedo (0 for the Sun).
    pub geometric_albedo: f64,
    /// Bond albedo; `None`: unknown.
    pub bond_albedo: Option<f64>,
    /// Geometric albedo without clouds, if the map shows the ground without them; `None`: that of the ground is `geometric_albedo`.
    pub clear_sky_albedo: Option<f64>,
    /// Mean colour of the ground without air and clouds, linear sRGB scaled to luminance 1; `None`: that of the disc. Set if the map shows
    /// that ground and its colour differs from the disc's.
    pub clear_sky_colour: Option<Vec3>,
    /// Mean colour of the disc, linear sRGB scaled to luminance 1.
    pub colour: Vec3,
    /// Its procedural relief, finer than its maps.
    pub invented_relief: InventedRelief,
    /// The number of the user's custom surface shader that colours its ground: 1 to 4; 0: none.
    pub custom_surface: u8,
    /// Its photometric model.
    pub photometry: Photometry,
    /// Its maps.
    pub maps: Maps,
    /// Its overlays, the lowest first.
    pub overlays: Vec<Overlay>,
    /// Its cloud shell.
    pub clouds: Option<Clouds>,
    /// Its shape model, if it has one.
    pub mesh: Option<ShapeModel>,
    /// Its theory of motion.
    pub motion: Motion,
    /// How it rotates.
    pub rotation: Rotation,
    /// Its rings, in the order of the catalog file that lists them.
    pub rings: Vec<Ring>,
    /// Its atmosphere.
    pub atmosphere: Option<Atmosphere>,
    /// Sources of the values by topic (`radii`, `gm`, `albedo`, `colour`, ...).
    pub sources: BTreeMap<String, String>,
    /// Estimated errors of values that are not from a published table.
    pub estimates: Estimates,
}

impl Body {
    /// Whether it is a moon of this body.
    pub fn is_moon_of(&self, planet: NaifId) -> bool {
        self.kind == BodyKind::Moon && self.parent == Some(planet)
    }

    /// The planet, dwarf planet or asteroid to whose system it belongs: its parent, unless that is the Sun; else (also for the Sun) the body itself.
    pub fn system_planet(&self) -> NaifId {
        self.parent.filter(|parent| *parent != NaifId::SUN).unwrap_or(self.id)
    }

    /// The estimated values of the body and their effect on an image, one line per value.
    pub fn estimate_notes(&self) -> Vec<Message> {
        // The change in magnitudes for a decrease by this percentage. An increase by the same percentage changes the magnitude less.
        let magnitudes = |percent: f64| -2.5 * (1.0 - percent / 100.0).log10();
        let albedo = self.estimates.albedo_percent.map(|percent| {
            let change = magnitudes(percent);
            message!("estimate-albedo", value = self.geometric_albedo, percent = percent, magnitudes = format_args!("{change:.2}"))
        });
        let colour = self.estimates.colour_percent.map(|percent| message!("estimate-colour", percent = percent));
        let species = self.atmosphere.iter().flat_map(|air| &air.species);
        let air = species.filter_map(|species| {
            let percent = species.estimate_percent?;
            let species = Argument::CatalogText("species", species.name.clone());
            Some(message!("estimate-air", species = species, percent = percent))
        });
        albedo.into_iter().chain(colour).chain(air).collect()
    }

    /// Mean reflectance of the ground, linear RGB: the body's colour times its geometric albedo (for a star: 1). If the catalog has the colour and albedo of
    /// the ground without clouds and air (the Earth), they replace those of the disc. The mean over the sphere of the albedo map times its gain
    /// is this reflectance times the map's `relative_mean`.
    pub fn mean_reflectance(&self) -> [f64; 3] {
        let albedo = match self.kind {
            BodyKind::Star => 1.0,
            _ => self.clear_sky_albedo.unwrap_or(self.geometric_albedo),
        };
        self.clear_sky_colour.unwrap_or(self.colour).to_array().map(|channel| f64::from(channel) * albedo)
    }

    /// Factors by which y and z of a point in the unit-sphere frame are multiplied (x is kept) to look it up in a map. The longitude and latitude of the
    /// resulting direction are those in which the columns and rows of the body's maps are evenly spaced.
    pub fn map_stretch(&self) -> DVec2 {
        let latitude = self.maps.albedo.as_ref().or(self.maps.night.as_ref()).map_or(MapLatitude::Planetocentric, |map| map.latitude);
        let DVec3 { x: a, y: b, z: c } = self.radii_km;
        // Planetocentric latitude and longitude are those of the position: the unit-sphere point times the semi-axes.
        // Planetographic latitude is that of the normal: the unit-sphere point divided by the semi-axes. With r = sqrt(ab) for both equatorial semi-axes (see
        // `MapLatitude`), z is multiplied by r² / (ac) = b / c.
        let for_latitude = match latitude {
            MapLatitude::Planetocentric => c / a,
            MapLatitude::Planetographic => b / c,
        };
        DVec2::new(b / a, for_latitude)
    }
}
