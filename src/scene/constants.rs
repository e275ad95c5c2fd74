//! Numbers that Rust and the fragments of shaders/ share: shapes of tables and the constants by which both read them.
//!
//! Each stands here once. `shader::constants` writes them as WGSL for the fragments; the modules of `scene` that fill the tables
//! use them under names of their own. Not here: numbers that only one side knows.

/// Slopes that a ring's table has rows for at most: x = 2^(k / [`RING_SLOPES_PER_OCTAVE`]), from 1 up to one over [`MIN_COSINE`].
pub const RING_SLOPES: u32 = 97;
pub const RING_SLOPES_PER_OCTAVE: u32 = 8;
/// Cosines below this count as it: paths that are almost parallel to a ring's plane.
pub const MIN_COSINE: f64 = 1.0 / 4096.0;
/// Strips of the Sun's disc, along its height over a ring's plane, that a low Sun's penumbra is summed by.
pub const SUN_PARTS: usize = 7;
/// Heights over the ring's plane, of one side, and hour angles from the Sun of the ring-shine table.
pub const RING_SHINE_ROWS: usize = 25;
pub const RING_SHINE_COLUMNS: usize = 33;

/// Slope in t = 1 / (1 + slope z), the variable of the polynomial that stands for erfcx(z).
pub const ERFCX_SLOPE: f64 = 0.46;

/// Heights of the multiple-scattering table, growing as squares from the ground to the top. One row more is for level ground.
pub const MULTIPLE_HEIGHTS: usize = 8;
/// Columns of the multiple-scattering table: cosines of the Sun's zenith angle.
pub const MULTIPLE_SUNS: usize = 16;
/// Columns lie evenly in x = mu / (|mu| + bend).
pub const MULTIPLE_BEND: f64 = 0.3;
/// x of the first column; that of the last one is of the Sun in the zenith.
pub const MULTIPLE_FIRST: f64 = -0.5;
/// Coefficients of the polynomial in x that stands for the table at one height under a Sun above the horizon.
pub const MULTIPLE_COEFFICIENTS: usize = 5;

/// Heights of the table of multiply scattered light in an eclipse's shadow. One row more is for level ground.
pub const SPREAD_HEIGHTS: usize = 4;
/// Its distances from the occluder's limb.
pub const SPREAD_COLUMNS: usize = 16;

/// Layers of an occluder's atmosphere that bend sunlight into its shadow.
pub const REFRACTION_LAYERS: usize = 32;

/// Vectors that describe one overlay image.
pub const OVERLAY_ROWS: usize = 6;

/// Sizes of invented craters that one frame may show.
pub const DETAIL_ROWS: usize = 16;

/// Columns and rows of the table of the Moon's own limb: together the points of its profile.
pub const LIMB_COLUMNS: usize = 1024;
pub const LIMB_ROWS: usize = 8;

/// Sine of the Sun's depression at which city lights are fully lit: 6 degrees, the end of civil twilight.
pub const CIVIL_TWILIGHT_SINE: f64 = 0.104_528_46;
