// Sunlight mirrored by waves: a normalised Blinn-Phong lobe (J. Blinn 1977) times the Fresnel reflectance of water.
//
// The power stands for the spread of wave slopes (Cox and Munk 1954: mean square slope 0.003 + 0.00512 per m/s of wind; power =
// 2 / slope^2 - 2). The lobe does not stretch towards the horizon as real glitter does.

// Schlick's form, R0 = 0.02 of sea water (index 1.33); the angle is half the phase angle. Measured against Fresnel's formulas: within
// 0.01 up to 60 degrees of incidence, 0.06 at worst, at 84 degrees.
fn fresnel_water(cos_phase: f32) -> f32 {
    let cos_half_phase = sqrt(clamp(0.5 + 0.5 * cos_phase, 0.0, 1.0));
    let s = 1.0 - cos_half_phase;
    let s_sq = s * s;
    return 0.02 + 0.98 * s_sq * s_sq * s;
}

// Pi times the lobe. With the cosine of incidence in front it returns at most 1.08 of what arrives (power 1 to 1000, integrated over the
// hemisphere), and Fresnel's factor, 0.02 where that happens, goes on top: no more light leaves than arrives.
fn glint_lobe(cos_half: f32, power: f32) -> f32 {
    return (power + 8.0) * 0.125 * pow(max(cos_half, 1.0e-4), power);
}
