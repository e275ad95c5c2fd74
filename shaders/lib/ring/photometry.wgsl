// Light scattered once by a flat layer of particles, over all the ringlets of a stretch of radius.
//
// Chandrasekhar's single scattering: with x = 1/mu towards the viewer and y = 1/mu0 towards the light,
//   lit side    (w P / 4) y' (1 - exp(-tau (x + y))),  y' = mu0 / (mu + mu0) = x / (x + y)
//   other side  (w P / 4) x (exp(-tau x) - exp(-tau y)) / (y - x), its limit where x = y
// Both need only the table's 1 - exp(-tau x). Light scattered more than once is in the effective albedo w of the catalog, which is
// fitted to observed brightness: it adds up to half of the B ring's light and is not coloured or spread apart from that.

//: use lib/ring/profile.wgsl

// Of the mean over all directions: power law of bodies in each other's shadow, which scatter back, and
// the opposition's peak 1 + B0 / (1 + tan(phase / 2) / h) (Hapke 1986, Icarus 67, 264).
fn ring_bodies_phase(cos_phase: f32) -> f32 {
    // pi minus the phase angle, by its half, which keeps its digits at both ends.
    let back = sqrt(max(0.5 * (1.0 + cos_phase), 0.0));
    let front = sqrt(max(0.5 * (1.0 - cos_phase), 0.0));
    let scattered = 2.0 * atan2(back, front);
    let bodies = draw.ring_phase.x * pow(max(scattered, 1.0e-6), draw.ring_phase.y);
    let peak = 1.0 + draw.ring_opposition.x / (1.0 + front / max(back * draw.ring_opposition.y, 1.0e-6));
    return bodies * peak;
}

// The same of dust, which scatters forward: three Henyey-Greenstein lobes. 1 + g² + 2 g cos(phase) is written without the difference of near
// numbers against the Sun.
fn ring_dust_phase(cos_phase: f32) -> f32 {
    let g = draw.ring_dust_asymmetry;
    let away = (1.0 - g) * (1.0 - g) + g * (2.0 * max(1.0 + cos_phase, 0.0));
    return dot(draw.ring_dust_share, (1.0 - g * g) / (away * sqrt(away)));
}

// The light that reaches the viewer through the layer's lit and its unlit side: part of the Sun's disc over the viewer's side, and 1/mu0 of that part and of the other.
struct RingLight {
    part_lit: f32,
    lit: f32,
    unlit: f32,
}

// Scattered once, of either part of the table, were it even over all directions. `x`: 1/mu towards the viewer.
fn ring_scattered(stretch: RingStretch, first_row: i32, sun: RingLight, x: f32) -> vec3f {
    var light = vec3f(0.0);
    if sun.part_lit > 0.0 {
        let y = sun.lit;
        light += sun.part_lit * x / (x + y) * ring_stopped(stretch, first_row, x + y).rgb;
    }
    if sun.part_lit < 1.0 {
        let y = sun.unlit;
        // At least a row of the table apart, about the same middle.
        let middle = sqrt(x * y);
        let half_apart = max(sqrt(max(x, y) / min(x, y)), 1.0443);
        let upper = middle * half_apart;
        let lower = middle / half_apart;
        let passed = ring_stopped(stretch, first_row, upper).rgb - ring_stopped(stretch, first_row, lower).rgb;
        light += (1.0 - sun.part_lit) * max(x * passed / (upper - lower), vec3f(0.0));
    }
    return light;
}

// I/F towards the viewer, per channel. `sin_sun`: not below 0. `side`: 1 where the viewer is on the side of the Sun's centre, else -1.
fn ring_reflectance(stretch: RingStretch, cos_emission: f32, sin_sun: f32, side: f32, cos_phase: f32) -> vec3f {
    // The Sun's disc may straddle the plane: part of it above, and the mean sine of that part.
    let h = clamp(sin_sun * side / draw.sun_tangent, -1.0, 1.0);
    let chord = sqrt(1.0 - h * h);
    let above = 0.5 + (h * chord + asin(h)) * 0.31830989;
    let moment = draw.sun_tangent * (h * above + chord * chord * chord * 0.21220659);
    let straddles = sin_sun < draw.sun_tangent;
    let sine_lit = select(sin_sun, moment / max(above, 1.0e-6), straddles);
    let sine_unlit = select(sin_sun, (moment - draw.sun_tangent * h) / max(1.0 - above, 1.0e-6), straddles);
    var sun: RingLight;
    sun.part_lit = select(step(0.0, side), above, straddles);
    sun.lit = 1.0 / max(sine_lit, LEAST_COSINE);
    sun.unlit = 1.0 / max(sine_unlit, LEAST_COSINE);
    let x = 1.0 / max(cos_emission, LEAST_COSINE);
    var light = ring_bodies_phase(cos_phase) * ring_scattered(stretch, BODIES, sun, x);
    if draw.ring_phase.z > 0.0 {
        light += ring_dust_phase(cos_phase) * ring_scattered(stretch, DUST, sun, x);
    }
    return 0.25 * light;
}
