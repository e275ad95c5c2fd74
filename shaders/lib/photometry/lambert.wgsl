// Lambert's law: equally bright from everywhere. Cloud-covered bodies, roughly.
// A sphere of albedo A has geometric albedo 2/3 A.

fn reflectance(cos_incidence: f32, cos_emission: f32, cos_phase: f32) -> f32 {
    return cos_incidence;
}
