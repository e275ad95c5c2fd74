// Sunlight mirrored by waves: facets of Cox and Munk's slopes (1954), each a mirror with the Fresnel reflectance of water.
//
// The slopes are Gaussian and equal in all directions, mean square 0.003 + 0.00512 per m/s of wind. The microfacet form with its
// shadowing (B. Walter and others, EGSR 2007: Beckmann's distribution is that of Gaussian slopes) lets the glitter stretch
// towards the horizon and keeps it finite there. Left out: the skew of the slopes along the wind, and light mirrored twice.

// Schlick's form, R0 = 0.02 of sea water (index 1.33); the angle is half the phase angle. Measured against Fresnel's formulas: within
// 0.01 up to 60 degrees of incidence, 0.06 at worst, at 84 degrees.
fn fresnel_water(cos_phase: f32) -> f32 {
    let cos_half_phase = sqrt(clamp(0.5 + 0.5 * cos_phase, 0.0, 1.0));
    let s = 1.0 - cos_half_phase;
    let s_sq = s * s;
    return 0.02 + 0.98 * s_sq * s_sq * s;
}

// Part of the facets that others do not hide, over the cosine: Walter's fit (equation 27). Finite at the horizon, where it is
// 3.535 / slope.
fn open_over_cosine(cosine: f32, slope_sq: f32) -> f32 {
    let c = clamp(cosine, 1.0e-4, 1.0);
    let a = c * inverseSqrt(max(slope_sq * (1.0 - c * c), 1.0e-12));
    let near_horizon = a * (3.535 + 2.181 * a) / (1.0 + a * (2.276 + 2.577 * a));
    return select(near_horizon, 1.0, a >= 1.6) / c;
}

// Pi times radiance over irradiance on a plane facing the Sun, for mirrors that turn back everything. `cos_half`: between the
// surface's normal and the facets that mirror the Sun to the viewer.
fn glint_lobe(cos_half: f32, cos_incidence: f32, cos_emission: f32, slope_sq: f32) -> f32 {
    let c_sq = max(cos_half * cos_half, 1.0e-4);
    let facets = exp((1.0 - 1.0 / c_sq) / slope_sq) / (slope_sq * c_sq * c_sq);
    return 0.25 * facets * cos_incidence * open_over_cosine(cos_incidence, slope_sq) * open_over_cosine(cos_emission, slope_sq);
}
