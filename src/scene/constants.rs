//! Constants shared by Rust and the WESL files of shaders/: dimensions of tables, and the parameters with which both sides index them.
//!
//! Each constant is defined once, here. `shader::constants` writes those that shaders need as WGSL, some as a reciprocal; the modules of `scene` that fill the
//! tables import them, some under names of their own. Not here: constants of shaders alone.

/// Maximum number of slants in a ring's table. A slant is 1 / cosine of the angle between a path and the ring's normal. The table has the slants
/// 2^(k / [`RING_SLANTS_PER_OCTAVE`]) for whole numbers k, from 1 to 1 / [`MIN_COSINE`].
pub(crate) const RING_SLANTS: u32 = 97;
pub(crate) const RING_SLANTS_PER_OCTAVE: u32 = 8;
/// Rows of a ring's table that contain its bins. Bins are even steps of 1 / radius; each stores the index of the interval of constant optical depth in which
/// the bin begins, and the outer radii of that interval and of the next two (shaders/lib/ring/intervals.wesl).
pub(crate) const RING_BIN_ROWS: u32 = 4;
/// Rows of a ring's table before those of the first slant: the bins, and one row with the intervals.
pub(crate) const RING_HEADER_ROWS: u32 = RING_BIN_ROWS + 1;
/// Rows of a ring's table per slant: the light of large particles and its integral over the radius, then both for dust.
pub(crate) const RING_ROWS_PER_SLANT: u32 = 4;
/// Lower limit of the cosine of the angle between a path and a ring's normal; smaller cosines are raised to this value. A path with this cosine is
/// inclined by 50 arcseconds to the ring's plane. Its slant is 2^12, so the slants span twelve octaves.
pub const MIN_COSINE: f64 = 1.0 / 4096.0;
/// Number of strips parallel to a ring's plane into which the Sun's disc is divided, for the penumbra of a low Sun: nodes of a Gauss-Chebyshev rule.
pub(crate) const SUN_STRIPS: usize = 7;
/// Rows of the ring-shine table: heights on one side of the ring's plane.
pub const RING_SHINE_ROWS: usize = 25;
/// Columns of the ring-shine table: hour angles from the Sun.
pub const RING_SHINE_COLUMNS: usize = 33;

/// Factor in t = 1 / (1 + ERFCX_FIT_SCALE z), the variable of the polynomial that approximates the scaled complementary error function erfcx(z), for paths
/// through air. shaders/lib/air/column_density.wesl has the polynomial, which was fitted for this factor.
pub(crate) const ERFCX_FIT_SCALE: f64 = 0.46;
/// Terms of the polynomial that approximates the optical depth of the air above the ground along a line.
pub const OPTICAL_DEPTH_TERMS: usize = 8;

/// Rows of the multiple-scattering table: heights spaced quadratically from the ground to the top of the air. One more row contains the irradiance of level
/// ground.
pub const MULTI_SCATTER_HEIGHTS: usize = 8;
/// The last rows of the multiple-scattering table: the sky that water mirrors to a low view, at azimuths from the Sun's. They are spaced in the square root of
/// the sine of half the azimuth, so that they are dense around the Sun.
pub const MIRRORED_SKY_AZIMUTHS: usize = 8;
/// Columns of the multiple-scattering table: cosines of the Sun's zenith angle.
pub const MULTI_SCATTER_COLUMNS: usize = 16;
/// The constant in x = mu / (|mu| + bend), in which the columns are evenly spaced; mu is the cosine of the Sun's zenith angle. The smaller it is, the denser
/// are the columns near the horizon.
pub(crate) const MULTI_SCATTER_BEND: f64 = 0.3;
/// x of the first column: mu = -0.3, a Sun 17.5 degrees below the horizon. The last column is for a Sun in the zenith.
pub(crate) const MULTI_SCATTER_FIRST_X: f64 = -0.5;
/// Coefficients of the polynomial in x that approximates the table at one height for a Sun above the horizon.
pub(crate) const MULTI_SCATTER_COEFFICIENTS: usize = 5;

/// Rows of the table of multiply scattered light in an eclipse's shadow: heights. The table holds square roots of fractions: of the light without an eclipse,
/// the part that remains in the shadow. One more row contains the square roots for the irradiance of level ground.
pub const IN_SHADOW_HEIGHTS: usize = 4;
/// Columns of the same table: distances from the occluder's limb, in solar radii.
pub const IN_SHADOW_COLUMNS: usize = 16;

/// Pixels between neighbouring texels of the coarse image of the air, along each axis.
pub const COARSE_AIR_PX: u32 = 4;
/// Texels of the coarse image beyond each edge of the screen, so that each texel on the screen has neighbours.
pub const COARSE_AIR_BORDER: u32 = 1;

/// Layers of an occluder's atmosphere that bend sunlight into its shadow.
pub const REFRACTION_LAYERS: usize = 32;

/// Number of vec4 uniforms that describe one overlay image.
pub const VECTORS_PER_OVERLAY: usize = 6;

/// Maximum number of lattices, one for each size class of procedural detail (craters, hills or billows) in one frame.
pub(crate) const MAX_DETAIL_LATTICES: usize = 16;

/// Steps of the table of tints and transmittances by the altitude of the line of sight, from the horizon to the zenith. They are shortest at the horizon, where
/// the tint changes fastest: on the ground half of them are within 3.6 degrees.
pub(crate) const TINT_STEPS: usize = 32;

/// Columns and rows of the table of the lunar limb profile; their product is the number of position angles.
pub(crate) const LIMB_COLUMNS: usize = 1024;
pub(crate) const LIMB_ROWS: usize = 8;

/// Greatest dip of the horizon, radians, as it is seen from relief: 2.9 degrees. On the Moon this is the dip from a height of 2.2 km. Steeper slopes of a map
/// are those of short ridges, or exaggerated.
pub(crate) const MAX_RELIEF_DIP: f64 = 0.05;

/// Sine of the Sun's depression at which city lights are fully lit: 6 degrees, the end of civil twilight.
pub(crate) const CIVIL_TWILIGHT_SINE: f64 = 0.104_528_46;
