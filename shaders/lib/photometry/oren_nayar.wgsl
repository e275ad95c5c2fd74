// Oren-Nayar: a rough surface of Lambert facets that shade and hide each other (M. Oren and S. K. Nayar, SIGGRAPH 1994, equation 30,
// the qualitative model: without the terms C2 and C3 of the full one and without interreflections; what that leaves out is not
// measured here).

fn reflectance(cos_incidence: f32, cos_emission: f32, cos_phase: f32, sigma_sq: f32) -> f32 {
    let a = 1.0 - 0.5 * sigma_sq / (sigma_sq + 0.33);
    let b = 0.45 * sigma_sq / (sigma_sq + 0.09);
    // sin(alpha) tan(beta) cos(phi) without angles: the numerator is cos(phi) times both sines, and tan's cosine is the greater of the
    // two. Incidence over that cosine stays between 0 and 1, so the quotient needs no other guard.
    let aligned = max(cos_phase - cos_incidence * cos_emission, 0.0);
    let ratio = cos_incidence / max(max(cos_incidence, cos_emission), 1.0e-6);
    return a * cos_incidence + b * aligned * ratio;
}
