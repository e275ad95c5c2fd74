//! Single scattering by a flat layer of particles, under a Sun whose disc the layer's plane may cut.
//!
//! In: optical depth, slants of paths (1 / cosine of the angle between path and normal), the Sun's elevation. Out: scattered radiance per
//! irradiance of a plane that faces the Sun, in the Glossary's units, without the factors albedo and (phase function / 4). The formulas are those of
//! shaders/lib/ring/photometry.wesl; tests/shader/formulas.rs compares them.

use std::f64::consts::PI;

/// The two parts into which the layer's plane cuts the Sun's disc; the first contains the Sun's centre. For each: its fraction of the disc's area, and the mean
/// over the part of |sin(elevation)|; for an empty part the mean has no meaning. `sin_elevation`: of the Sun's centre, not negative. `tan_sun_radius`: tangent
/// of the Sun's angular radius.
pub fn sun_disc_parts(sin_elevation: f64, tan_sun_radius: f64) -> [[f64; 2]; 2] {
    if sin_elevation >= tan_sun_radius {
        return [[1.0, sin_elevation], [0.0, 1.0]];
    }
    // The disc cut by the plane. `height` of its centre above the plane and `half_chord` are in radii of the disc. `above`: fraction of its area above the
    // plane; `moment`: integral of sin(elevation) over that part, for a disc of area 1. The integral over the entire disc is `sin_elevation`.
    let height = sin_elevation / tan_sun_radius;
    let half_chord = (1.0 - height * height).sqrt();
    let above = 0.5 + (height * half_chord + height.asin()) / PI;
    let moment = tan_sun_radius * (height * above + half_chord.powi(3) * 2.0 / (3.0 * PI));
    [[above, moment / above.max(1e-9)], [1.0 - above, (moment - sin_elevation) / (1.0 - above).max(1e-9)]]
}

/// Sunlight of slant `sun_slant` scattered into a path of slant `view_slant` to the viewer, without the factors albedo and (phase function / 4). `tau`: normal
/// optical depth of the layer. `is_same_side`: whether Sun and viewer are on the same side of the layer.
pub fn scattered(tau: f64, view_slant: f64, sun_slant: f64, is_same_side: bool) -> f64 {
    let (x, y) = (view_slant, sun_slant);
    if is_same_side {
        return x / (x + y) * -(-tau * (x + y)).exp_m1();
    }
    // (exp(-tau x) - exp(-tau y)) / (y - x) is symmetric in x and y; its limit at y = x is tau exp(-tau x).
    let (smaller, difference) = (x.min(y), (y - x).abs());
    let quotient = if tau * difference < 1e-6 { tau } else { -(-tau * difference).exp_m1() / difference };
    x * (-tau * smaller).exp() * quotient
}
