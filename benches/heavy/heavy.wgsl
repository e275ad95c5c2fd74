// A fragment shader as expensive as a planet's, for benches only: an atmosphere of 16 samples, each with a column density by an approximate Chapman function
// and an eclipse (5 or 6 exp, 3 or 4 sqrt, 5 divisions, acos and asin), map coordinates and one texture read. It draws a planet in an orthographic view;
// lengths are in radii of the body. The numbers are those of no real planet.

struct Draw {
    // Direction to the Sun (x, y, z).
    sun: vec4f,
    // Centre (x, y, z) and radius of the occluder.
    occluder: vec4f,
    // Scale height; scattering coefficients at the ground per radius (red, green, blue).
    air: vec4f,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var map: texture_2d<f32>;
@group(0) @binding(8) var map_sampler: sampler;

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> Varyings {
    let x = f32((index & 2u) << 1u) - 1.0;
    let y = 1.0 - f32((index & 1u) << 2u);
    return Varyings(vec4f(x, y, 0.0, 1.0), vec2f(x, y) * 1.2);
}

// Column density of air from a height (in scale heights) in a direction given by the cosine of its zenith angle: a length of air at ground density, in
// scale heights. `x`: the body's radius in scale heights. The square root is that of pi / 2 times x, the column along the horizon.
fn column(height: f32, cosine: f32, x: f32) -> f32 {
    let c = sqrt(1.5707963 * x);
    if cosine >= 0.0 {
        return c / ((c - 1.0) * cosine + 1.0) * exp(-height);
    }
    let s = sqrt(max(1.0 - cosine * cosine, 1.0e-6));
    let lowest = (x + height) * s - x;
    return 2.0 * c * exp(-max(lowest, 0.0)) - c / ((c - 1.0) * -cosine + 1.0) * exp(-height);
}

// The fraction of sunlight that passes the occluder to a point. The penumbra is 0.05 radians wide on each side of the occluder's limb.
fn sunlight_fraction(p: vec3f) -> f32 {
    let to = draw.occluder.xyz - p;
    let distance = length(to);
    let separation = acos(clamp(dot(to, draw.sun.xyz) / distance, -1.0, 1.0));
    let radius = asin(clamp(draw.occluder.w / distance, 0.0, 1.0));
    return smoothstep(radius - 0.05, radius + 0.05, separation);
}

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    let r2 = dot(in.place, in.place);
    // The top of the atmosphere, eight scale heights above the ground.
    let top = 1.0 + 8.0 * draw.air.x;
    if r2 >= top * top {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let hits = r2 < 1.0;
    let z_top = sqrt(top * top - r2);
    let z_end = select(-z_top, sqrt(max(1.0 - r2, 0.0)), hits);
    let x = 1.0 / draw.air.x;
    let step = (z_top - z_end) / 16.0;
    var light = vec3f(0.0);
    var column_to_camera = 0.0;
    for (var k = 0; k < 16; k += 1) {
        let p = vec3f(in.place, z_top - (f32(k) + 0.5) * step);
        let radius = length(p);
        let height = max(radius - 1.0, 0.0) * x;
        let density = exp(-height) * step;
        let cosine = dot(p, draw.sun.xyz) / radius;
        let column_to_sun = column(height, cosine, x) * draw.air.x;
        column_to_camera += density;
        let transmittance = exp(-draw.air.yzw * (column_to_camera + column_to_sun));
        light += draw.air.yzw * transmittance * (density * sunlight_fraction(p));
    }
    if !hits {
        return vec4f(light, 1.0);
    }
    let p = vec3f(in.place, z_end);
    // Longitude / (2 pi) and colatitude / pi.
    let uv = vec2f(0.5 + atan2(p.x, p.z) * 0.15915494, acos(clamp(p.y, -1.0, 1.0)) * 0.31830989);
    let ground = textureSampleLevel(map, map_sampler, uv, 0.0).rgb;
    let sunlit = max(dot(p, draw.sun.xyz), 0.0) * sunlight_fraction(p);
    return vec4f(ground * exp(-draw.air.yzw * column_to_camera) * sunlit + light, 1.0);
}
