// From exposed light to sRGB bytes.

// True to the input up to `true_to`, then a shoulder that reaches 1 at infinity. It works on the greatest channel and scales all three alike,
// so a bright colour keeps its hue; far beyond white it fades to white, as film does. The form is that of the Khronos PBR
// Neutral tone mapper (2024) without its toe.
fn filmic(radiance: vec3f, true_to: f32) -> vec3f {
    let colour = clamp(radiance, vec3f(0.0), vec3f(1.0e6));
    let peak = max(max(colour.r, colour.g), max(colour.b, 1.0e-12));
    let shoulder = 1.0 - 0.04 / (max(peak, 0.8) - 0.6);
    let mapped = select(shoulder, peak, peak <= true_to);
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

// What is shown of exposed light at a pixel. `dither`: in 255ths.
fn displayed(exposed: vec3f, true_to: f32, dither: f32, position: vec2f) -> vec4f {
    // Most of the sky is black, and stays so.
    if dither == 0.0 && max(max(exposed.r, exposed.g), exposed.b) <= 0.0 {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let encoded = srgb_encoded(filmic(exposed, true_to));
    if dither == 0.0 {
        return vec4f(encoded, 1.0);
    }
    // The mean of the thresholds is 63/128: the dither moves no average.
    let threshold = bayer_8(position - 8.0 * floor(position / 8.0)) - 0.4921875;
    return vec4f(encoded + dither * threshold / 255.0, 1.0);
}
