//! Single scattering by a flat layer of particles, under a Sun whose disc the layer's plane may cut.
//!
//! In: optical depth, slants of paths (1 / cosine of the angle between path and normal), the Sun's elevation. Out: light without the factors albedo and phase
//! function / 4. The formulas are those of shaders/lib/ring/photometry.wesl; tests/shader/formulas.rs compares them.

use std::f64::consts::PI;

/// The two parts into which the layer's plane cuts the Sun's disc; the first contains the Sun's centre. For each: its fraction of the disc, and the mean sine
/// of its elevation over its own side of the plane. `sine`: sine of the centre's elevation, not negative; `tangent`: tangent of the Sun's angular radius.
pub fn sun_disc_parts(sine: f64, tangent: f64) -> [[f64; 2]; 2] {
    if sine >= tangent {
        return [[1.0, sine], [0.0, 1.0]];
    }
    // The disc cut by the plane: height of its centre above the plane and half the chord, both in radii of the disc; area and first moment of the part above.
    let height = sine / tangent;
    let half_chord = (1.0 - height * height).sqrt();
    let above = 0.5 + (height * half_chord + height.asin()) / PI;
    let moment = tangent * (height * above + half_chord.powi(3) * 2.0 / (3.0 * PI));
    [[above, moment / above.max(1e-9)], [1.0 - above, (moment - sine) / (1.0 - above).max(1e-9)]]
}

/// Sunlight of slant `sun_slant` scattered into a path of slant `view_slant` to the viewer, without the factors albedo and phase function / 4. `tau`: normal
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
