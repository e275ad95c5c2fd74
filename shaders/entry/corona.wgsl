// The Sun's corona, added to what lies behind it and hidden by what is drawn later, nearer.
//
// Coming in: view rays in axes about the Sun, and the law of src/scene/corona.rs as amounts. Going out: linear RGB radiance to be added. Nothing on the
// Sun's own disc.

//: use lib/screen.wgsl

struct Draw {
    // View rays of depth 1: value = middle + clip x * across + clip y * up. Axes: x along the Sun's equator as seen, y along its pole as seen, z to its centre.
    middle: vec3f,
    across: vec3f,
    up: vec3f,
    // One over the sine of the Sun's angular radius.
    radii_per_sine: f32,
    // Half a pixel in solar radii.
    half_px: f32,
    // Ludendorff's index: by how much isophotes are flattened from two solar radii on.
    flattening: f32,
    // Radiance at the limb of the terms that fall with the powers 2.5, 7 and 17 of the distance.
    terms: vec3f,
    // Linear RGB.
    colour: vec3f,
}

@group(0) @binding(0) var<uniform> draw: Draw;

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) ray: vec3f,
}

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> Varyings {
    let corner = screen_corner(index);
    var out: Varyings;
    out.position = vec4f(corner, 0.0, 1.0);
    out.ray = draw.middle + corner.x * draw.across + corner.y * draw.up;
    return out;
}

// Integral of the law from a distance outwards; the disc has none of it.
fn beyond(rho: f32) -> f32 {
    let x = 1.0 / max(rho, 1.0);
    let x2 = x * x;
    let x4 = x2 * x2;
    let x16 = x4 * x4 * x4 * x4;
    return dot(draw.terms, vec3f(x * sqrt(x) * 0.66666667, x4 * x2 * 0.16666667, x16 * 0.0625));
}

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    let aside = dot(in.ray.xy, in.ray.xy);
    let sine = sqrt(aside / (aside + in.ray.z * in.ray.z));
    // Behind the observer it goes on to fall.
    let rho = select(2.0 - sine, sine, in.ray.z > 0.0) * draw.radii_per_sine;
    // Mean along the radius over a pixel: the innermost part falls by half within a twenty-fifth of a radius.
    let half_width = max(draw.half_px, 0.002 * rho);
    let mean = (beyond(rho - half_width) - beyond(rho + half_width)) / (2.0 * half_width);
    // Isophotes flattened at the poles; the mean over position angles stays that of the law.
    let x = 1.0 / max(rho, 1.0);
    let x2 = x * x;
    let x4 = x2 * x2;
    let parts = draw.terms * vec3f(x2 * sqrt(x), x4 * x2 * x, x4 * x4 * x4 * x4 * x);
    let steepness = dot(parts, vec3f(2.5, 7.0, 17.0)) / max(parts.x + parts.y + parts.z, 1.0e-30);
    // 1.609: twice the mean of the cosine of twice the angle over the diameters at 0 and 22.5 degrees to either side, which the index compares.
    let k = steepness * draw.flattening * clamp(rho - 1.0, 0.0, 1.0) / 1.609;
    let k_sq = 0.25 * k * k;
    let bessel = 1.0 + k_sq * (1.0 + k_sq * (0.25 + k_sq * 0.027777778));
    let cos_twice = (in.ray.x * in.ray.x - in.ray.y * in.ray.y) / max(aside, 1.0e-30);
    return vec4f(draw.colour * (mean * exp(k * cos_twice) / bessel), 0.0);
}
