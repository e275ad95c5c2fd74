// A picture spread by a Gaussian along one of its axes; twice, along both, it is round.
//
// Coming in: a picture of the same size. Going out: its four channels, each texel's share as the law wants it over three standard deviations; the
// shares sum to 1. Beyond the edge the picture goes on as at its edge.

//: use lib/screen.wgsl

struct Draw {
    // (1, 0) or (0, 1).
    axis: vec2f,
    // Standard deviation, pixels.
    sigma_px: f32,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var picture: texture_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(screen_corner(index), 0.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = vec2i(floor(position.xy));
    let step = vec2i(draw.axis);
    let last = vec2i(textureDimensions(picture)) - vec2i(1);
    let reach = i32(ceil(3.0 * draw.sigma_px));
    let narrowness = -0.5 / max(draw.sigma_px * draw.sigma_px, 1.0e-6);
    var sum = textureLoad(picture, here, 0);
    var weights = 1.0;
    for (var k = 1; k <= reach; k++) {
        let share = exp(narrowness * f32(k * k));
        let before = textureLoad(picture, clamp(here - k * step, vec2i(0), last), 0);
        let after = textureLoad(picture, clamp(here + k * step, vec2i(0), last), 0);
        sum += share * (before + after);
        weights += 2.0 * share;
    }
    return sum / weights;
}
