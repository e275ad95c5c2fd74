//! The fragments constants/*.wesl: numbers that Rust and shaders share, generated from the Rust values.
//!
//! In: src/scene/constants.rs (here imported as `shared`) and the greatest counts (of lights, for example) that a key can have. Out: path and text of each
//! fragment. The text depends only on the Rust values. The files in shaders/constants are copies for text editors and for other engines. A test checks that
//! they are equal to this output; `orrery shader export shaders --overwrite` rewrites them.

use super::key::DIMENSIONS;
use super::source::condition::wesl_identifier;
use crate::scene::draw::MAX_OCCLUDERS;
use crate::scene::draw::constants as shared;
use std::fmt::Write as _;
use std::sync::LazyLock;

/// Path inside shaders/ and text of each generated fragment, sorted by path.
pub static CONSTANTS: LazyLock<Vec<(&'static str, String)>> = LazyLock::new(|| {
    vec![
        ("constants/air.wesl", air_fragment()),
        ("constants/draw.wesl", draw_fragment()),
        ("constants/eclipse.wesl", eclipse_fragment()),
        ("constants/rings.wesl", rings_fragment()),
        ("constants/tints.wesl", tints_fragment()),
    ]
});

/// A value with its WGSL type. `F32` also for counts with which the shaders compute in f32.
enum Value {
    U32(usize),
    I32(usize),
    F32(f64),
}

/// One declaration of a generated fragment.
struct SharedConstant {
    /// Text of the comment above the declaration.
    comment: &'static str,
    /// WESL condition under which a module declares the constant, such as `eclipse_1` (at least one occluder); empty if all modules declare it.
    condition: &'static str,
    name: &'static str,
    value: Value,
}

const fn constant(comment: &'static str, condition: &'static str, name: &'static str, value: Value) -> SharedConstant {
    SharedConstant { comment, condition, name, value }
}

/// The text of a fragment. `about`: the first sentence of its first comment.
fn fragment_text(about: &str, constants: &[SharedConstant]) -> String {
    let mut text = format!("// {about} Generated from src/scene/constants.rs.\n\n");
    for SharedConstant { comment, condition, name, value } in constants {
        let attribute = if condition.is_empty() { String::new() } else { format!("@if({condition}) ") };
        let value = match value {
            Value::U32(n) => format!("u32 = {n}u"),
            Value::I32(n) => format!("i32 = {n}"),
            Value::F32(x) => format!("f32 = {x:?}"),
        };
        let _ = writeln!(text, "// {comment}\n{attribute}const {name}: {value};");
    }
    text
}

fn air_fragment() -> String {
    // Length of the range of the columns' coordinate x = mu / (|mu| + MULTI_SCATTER_BEND), from the first column to the last, which is at mu = 1.
    let x_span = 1.0 / (1.0 + shared::MULTI_SCATTER_BEND) - shared::MULTI_SCATTER_FIRST_X;
    let vectors_per_occluder = (shared::IN_SHADOW_HEIGHTS + 1) * shared::IN_SHADOW_COLUMNS;
    let occluders = usize::from(MAX_OCCLUDERS);
    fragment_text(
        "Tables and polynomials of the atmosphere.",
        &[
            constant(
                "Factor in t = 1 / (1 + ERFCX_FIT_SCALE z), in which a polynomial approximates the scaled complementary error function erfcx(z).",
                "",
                "ERFCX_FIT_SCALE",
                Value::F32(shared::ERFCX_FIT_SCALE),
            ),
            constant(
                "Terms of the polynomial that approximates the optical depth of all air above a point (lib/air/optical_depth_above.wesl).",
                "",
                "OPTICAL_DEPTH_TERMS",
                Value::U32(shared::OPTICAL_DEPTH_TERMS),
            ),
            constant(
                "Table of light scattered more than once: its rows for heights. One more row holds the irradiance of level ground.",
                "air_table",
                "MULTI_SCATTER_HEIGHTS",
                Value::U32(shared::MULTI_SCATTER_HEIGHTS),
            ),
            constant(
                "Its last rows: azimuths of the sky that water mirrors.",
                "air_table",
                "MIRRORED_SKY_AZIMUTHS",
                Value::U32(shared::MIRRORED_SKY_AZIMUTHS),
            ),
            constant(
                "Columns of this table, evenly spaced in x = mu / (|mu| + MULTI_SCATTER_BEND); mu is the cosine of the Sun's zenith angle.",
                "air_table",
                "MULTI_SCATTER_COLUMNS",
                Value::U32(shared::MULTI_SCATTER_COLUMNS),
            ),
            constant(
                "Constant in the formula of x: the smaller it is, the denser are the columns near the horizon.",
                "air_table",
                "MULTI_SCATTER_BEND",
                Value::F32(shared::MULTI_SCATTER_BEND),
            ),
            constant(
                "Minus the x of the first column, in which the Sun is below the horizon.",
                "air_table",
                "MULTI_SCATTER_X_OFFSET",
                Value::F32(-shared::MULTI_SCATTER_FIRST_X),
            ),
            constant(
                "Columns per unit of x; the last column has the Sun at the zenith.",
                "air_table",
                "MULTI_SCATTER_COLUMNS_PER_UNIT",
                Value::F32((shared::MULTI_SCATTER_COLUMNS - 1) as f64 / x_span),
            ),
            constant(
                "By day a polynomial in x approximates the square roots of the table's values at one height: number of its coefficients.",
                "air_table",
                "MULTI_SCATTER_COEFFICIENTS",
                Value::U32(shared::MULTI_SCATTER_COEFFICIENTS),
            ),
            constant(
                "Table of the fraction of multiply scattered light left by an eclipse: columns for distances of the Sun's centre from the occluder's limb.",
                "air_table && eclipse_1",
                "IN_SHADOW_COLUMNS",
                Value::U32(shared::IN_SHADOW_COLUMNS),
            ),
            constant(
                "Rows of the table of fractions for heights. One more row is for the irradiance of level ground.",
                "air_table && eclipse_1",
                "IN_SHADOW_HEIGHTS",
                Value::U32(shared::IN_SHADOW_HEIGHTS),
            ),
            constant(
                "Elements (vec4f) of the table of fractions per occluder: all its rows times its columns.",
                "air_table && eclipse_1",
                "OCCLUDER_TABLE_VECTORS",
                Value::U32(vectors_per_occluder),
            ),
            constant(
                "Elements of the tables of all possible occluders, and one more per occluder with the range of its columns' distances.",
                "air_table && eclipse_1",
                "IN_SHADOW_VECTORS",
                Value::U32(occluders * (vectors_per_occluder + 1)),
            ),
            constant(
                "Index of the first of these ranges in the array of all elements.",
                "air_table && eclipse_1",
                "IN_SHADOW_FIRST_RANGE",
                Value::U32(occluders * vectors_per_occluder),
            ),
            constant(
                "Texels per pixel, along each axis, of the coarse image of the air (lib/air/coarse.wesl).",
                "reads_coarse_air",
                "COARSE_AIR_PER_PIXEL",
                Value::F32(1.0 / f64::from(shared::COARSE_AIR_PX)),
            ),
            constant(
                "Texels of that image before the one at the screen's left edge, and rows before the one at its top edge.",
                "reads_coarse_air",
                "COARSE_AIR_BORDER",
                Value::F32(f64::from(shared::COARSE_AIR_BORDER)),
            ),
        ],
    )
}

fn tints_fragment() -> String {
    fragment_text(
        "The table of the air's tints.",
        &[constant(
            "Steps of the table from the horizon to the zenith; it has one value more.",
            "",
            "TINT_STEPS",
            Value::U32(shared::TINT_STEPS),
        )],
    )
}

fn rings_fragment() -> String {
    fragment_text(
        "Tables of the rings.",
        &[
            constant(
                "Slants of view rays (x = 1 / cosine to the ring's normal) in the ring profile's table, per doubling of x.",
                "",
                "RING_SLANTS_PER_OCTAVE",
                Value::F32(f64::from(shared::RING_SLANTS_PER_OCTAVE)),
            ),
            constant(
                "Rows of a ring's table with the bins by which the interval of a radius is found (lib/ring/intervals.wesl).",
                "",
                "RING_BIN_ROWS",
                Value::I32(shared::RING_BIN_ROWS as usize),
            ),
            constant(
                "Rows of the ring profile's table before those of the first slant.",
                "",
                "RING_HEADER_ROWS",
                Value::I32(shared::RING_HEADER_ROWS as usize),
            ),
            constant(
                "Rows per slant: light of large particles, its integral over radius, light of dust, its integral.",
                "",
                "RING_ROWS_PER_SLANT",
                Value::I32(shared::RING_ROWS_PER_SLANT as usize),
            ),
            constant(
                "Lower limit of the cosine between a path and the ring's normal; smaller cosines are raised to it.",
                "",
                "MIN_COSINE",
                Value::F32(shared::MIN_COSINE),
            ),
            constant(
                "Strips into which the Sun's disc is divided when the Sun is low over the rings.",
                "ring_shadow_penumbra",
                "SUN_STRIPS",
                Value::I32(shared::SUN_STRIPS),
            ),
            constant(
                "Ring-shine table: rows for heights above the ring's plane, on one side of it.",
                "ring_shine",
                "SHINE_ROWS",
                Value::F32(shared::RING_SHINE_ROWS as f64),
            ),
            constant(
                "Ring-shine table: columns for hour angles from the Sun, 0 to 180 degrees.",
                "ring_shine",
                "SHINE_COLUMNS",
                Value::F32(shared::RING_SHINE_COLUMNS as f64),
            ),
        ],
    )
}

fn eclipse_fragment() -> String {
    fragment_text(
        "Eclipses by other bodies, and twilight.",
        &[
            constant(
                "Refracting layers of the first occluder's atmosphere.",
                "eclipse_refracted",
                "REFRACTION_LAYERS",
                Value::I32(shared::REFRACTION_LAYERS),
            ),
            constant(
                "Sine of the Sun's depression below the horizon at which city lights are fully lit.",
                "maps_night",
                "CIVIL_TWILIGHT_SINE",
                Value::F32(shared::CIVIL_TWILIGHT_SINE),
            ),
            constant(
                "Greatest dip of the horizon, radians, as it is seen from relief: so far beyond the terminator the steepest slopes have sunlight.",
                "maps_normal || has_detail",
                "MAX_RELIEF_DIP",
                Value::F32(shared::MAX_RELIEF_DIP),
            ),
        ],
    )
}

/// The sizes of arrays. The numbers of lights, occluders and overlays depend on the key: one WGSL constant for each possible number, under an `@if` or `@elif`.
fn draw_fragment() -> String {
    let mut text = "// Sizes of a draw's arrays. Generated from the key's dimensions and src/scene/constants.rs.\n\n".to_owned();
    let counts = [
        ("lights", "LIGHTS", "Lights: the Sun, then other bodies."),
        ("occluders", "OCCLUDERS", "Bodies that may be in front of the Sun."),
        ("overlays", "OVERLAYS", "Images laid over the ground."),
    ];
    for (dimension, name, comment) in counts {
        let _ = writeln!(text, "// {comment}");
        let feature_names = DIMENSIONS.iter().find(|d| d.name == dimension).map_or(&[][..], |d| d.feature_names);
        let mut keyword = "if";
        // A key with a count has the features of all lesser counts, too. So the greatest count is tested first.
        for (count, feature) in feature_names.iter().enumerate().skip(1).rev() {
            let _ = writeln!(text, "@{keyword}({}) const {name}: u32 = {count}u;", wesl_identifier(feature));
            keyword = "elif";
        }
    }
    let _ = writeln!(
        text,
        "// Elements (vec4f) that describe one overlaid image: lib/overlay.wesl.\n@if(overlays_1) const VECTORS_PER_OVERLAY: u32 = {}u;",
        shared::VECTORS_PER_OVERLAY
    );
    let _ = writeln!(
        text,
        "// Maximum number of lattices of procedural detail (lib/detail.wesl), one for each size of cells.\n\
         @if(has_detail) const MAX_DETAIL_LATTICES: i32 = {};",
        shared::MAX_DETAIL_LATTICES
    );
    let limb_table = [
        ("LIMB_COLUMNS", shared::LIMB_COLUMNS, "Points per row of the table of the Moon's limb profile, continued from row to row."),
        ("LIMB_ROWS", shared::LIMB_ROWS, "Rows of this table."),
    ];
    for (name, count, comment) in limb_table {
        let _ = writeln!(text, "// {comment}\n@if(limb_heights) const {name}: f32 = {:?};", count as f64);
    }
    text
}
