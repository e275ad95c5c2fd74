// Lunar-Lambert (A. S. McEwen, Icarus 92, 298, 1991; LPSC 27, 841, 1996): a blend of Lommel-Seeliger and Lambert that follows
// Hapke's model for a given phase angle. L = 1 is all lunar, 0 all Lambert; in nature L falls with the phase angle, here one value
// serves a whole frame.
// A sphere of albedo A has geometric albedo A (L + 2/3 (1 - L)).

fn reflectance(cos_incidence: f32, cos_emission: f32, cos_phase: f32, lunar_weight: f32) -> f32 {
    let lunar = 2.0 * cos_incidence / max(cos_incidence + cos_emission, 1.0e-6);
    return mix(cos_incidence, lunar, lunar_weight);
}
