// Linear radiance of the scene pass to display-ready sRGB bytes.
//
// Coming in: the HDR pass as a texture of the same size. Going out: sRGB-encoded colour, opaque.

struct Draw {
    // Factor on radiance: 2^stops.
    exposure: f32,
    // 1: ordered dither of one 255th; 0: none.
    dither: f32,
    // Radiance times exposure up to which the picture is true; 0.8, or without bound where values are to be read off.
    true_to: f32,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var hdr: texture_2d<f32>;

// One triangle that covers the screen.
@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let x = f32((index & 2u) << 1u) - 1.0;
    let y = 1.0 - f32((index & 1u) << 2u);
    return vec4f(x, y, 0.0, 1.0);
}

// True to the input up to 0.8, then a shoulder that reaches 1 at infinity. It works on the greatest channel and scales all three alike,
// so a bright colour keeps its hue; far beyond white it fades to white, as film does. The form is that of the Khronos PBR
// Neutral tone mapper (2024) without its toe.
fn filmic(radiance: vec3f) -> vec3f {
    let colour = clamp(radiance, vec3f(0.0), vec3f(1.0e6));
    let peak = max(max(colour.r, colour.g), max(colour.b, 1.0e-12));
    let shoulder = 1.0 - 0.04 / (max(peak, 0.8) - 0.6);
    let mapped = select(shoulder, peak, peak <= draw.true_to);
    let hue_kept = colour * (mapped / peak);
    let whiteness = 1.0 - 1.0 / (0.15 * (peak - mapped) + 1.0);
    return mix(hue_kept, vec3f(mapped), whiteness);
}

// IEC 61966-2-1. The power by way of exp2 and log2, as hardware computes pow: the base is positive, and the error stays below a
// thousandth of a 255th.
fn srgb_encoded(linear: vec3f) -> vec3f {
    let curve = 1.055 * exp2(log2(max(linear, vec3f(0.0031308))) * (1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * linear, linear <= vec3f(0.0031308));
}

// Bayer's matrix by halves: 0, 1/2 / 3/4, 1/4 for the last bit of x and y.
fn bayer_2(pixel: vec2f) -> f32 {
    let p = floor(pixel);
    return fract(0.5 * p.x + 0.75 * p.y * p.y);
}

// Threshold in 0..1 over an 8x8 tile.
fn bayer_8(pixel: vec2f) -> f32 {
    return bayer_2(pixel) + 0.25 * bayer_2(0.5 * pixel) + 0.0625 * bayer_2(0.25 * pixel);
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(floor(position.xy));
    let radiance = textureLoad(hdr, pixel, 0).rgb;
    let encoded = srgb_encoded(filmic(radiance * draw.exposure));
    // The mean of the thresholds is 63/128: the dither moves no average.
    let threshold = bayer_8(position.xy - 8.0 * floor(position.xy / 8.0)) - 0.4921875;
    return vec4f(encoded + draw.dither * threshold / 255.0, 1.0);
}
