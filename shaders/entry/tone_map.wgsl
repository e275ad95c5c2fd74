// Linear radiance of the scene pass to display-ready sRGB bytes.
//
// Coming in: the HDR pass as a texture of the same size. Going out: sRGB-encoded colour, opaque.

//: use lib/screen.wgsl
//: use lib/display.wgsl

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

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(screen_corner(index), 0.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let radiance = textureLoad(hdr, vec2i(floor(position.xy)), 0).rgb;
    return displayed(radiance * draw.exposure, draw.true_to, draw.dither, position.xy);
}
