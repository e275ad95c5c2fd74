// A picture at a quarter of its sides: the mean of what lies beyond a bound.
//
// Coming in: a picture of light. Going out: for each pixel the mean over 4 by 4 texels (those that there are) of what is beyond the bound, hue kept.

//: use lib/screen.wgsl

struct Draw {
    // Factor on the light that comes in.
    exposure: f32,
    // Of exposed light, brightest channel: this much counts for nothing.
    beyond: f32,
    // At most this much of it counts.
    most: f32,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var light: texture_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(screen_corner(index), 0.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = 4 * vec2i(floor(position.xy));
    let size = vec2i(textureDimensions(light));
    var sum = vec3f(0.0);
    for (var k = 0; k < 16; k++) {
        let texel = first + vec2i(k & 3, k >> 2u);
        let there = select(0.0, 1.0, texel.x < size.x && texel.y < size.y);
        let exposed = max(textureLoad(light, min(texel, size - vec2i(1)), 0).rgb, vec3f(0.0)) * draw.exposure;
        let peak = max(max(exposed.r, exposed.g), max(exposed.b, 1.0e-12));
        sum += exposed * (there * clamp(peak - draw.beyond, 0.0, draw.most) / peak);
    }
    return vec4f(sum / 16.0, 1.0);
}
