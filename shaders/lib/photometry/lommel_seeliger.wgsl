// Lommel-Seeliger: single scattering in a dark, deep layer of grains (Seeliger 1887; Hapke 2012, "Theory of Reflectance and
// Emittance Spectroscopy", section 8.5, with an isotropic phase function). The full Moon and dark asteroids are evenly bright to the
// limb like this. Multiple scattering and the opposition surge are left out.
// Scaled so that a facet lit and seen along its normal gives 1: a sphere of albedo A has geometric albedo A.

fn reflectance(cos_incidence: f32, cos_emission: f32, cos_phase: f32) -> f32 {
    // Where both cosines vanish the quotient has no limit; it is taken as 0. Everywhere else it lies between 0 and 2.
    return 2.0 * cos_incidence / max(cos_incidence + cos_emission, 1.0e-6);
}
