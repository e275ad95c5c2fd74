// Linear radiance and the light that a lens spreads around what is beyond white, to display-ready sRGB bytes.
//
// Coming in: the HDR pass as a texture of the same size, and two spread pictures of exposed light beyond white, a quarter and a sixteenth of its
// sides. Going out: sRGB-encoded colour, opaque. The spread light is added: src/render/plan/shared.rs says how much.

//: use lib/screen.wgsl
//: use lib/display.wgsl

struct Draw {
    exposure: f32,
    dither: f32,
    true_to: f32,
    // Part of the light beyond white that each picture adds.
    near_part: f32,
    far_part: f32,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var hdr: texture_2d<f32>;
@group(0) @binding(2) var near: texture_2d<f32>;
@group(0) @binding(3) var far: texture_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(screen_corner(index), 0.0, 1.0);
}

// Texel of a spread picture, from its edge on that of the edge.
fn spread_texel(spread: texture_2d<f32>, texel: vec2i) -> vec3f {
    return textureLoad(spread, clamp(texel, vec2i(0), vec2i(textureDimensions(spread)) - vec2i(1)), 0).rgb;
}

// A spread picture at a place in texels, between the middles of four of them.
fn spread_light(spread: texture_2d<f32>, place: vec2f) -> vec3f {
    let from_middle = place - 0.5;
    let t = vec2i(floor(from_middle));
    let part = fract(from_middle);
    let above = mix(spread_texel(spread, t), spread_texel(spread, t + vec2i(1, 0)), part.x);
    let below = mix(spread_texel(spread, t + vec2i(0, 1)), spread_texel(spread, t + vec2i(1, 1)), part.x);
    return mix(above, below, part.y);
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let radiance = textureLoad(hdr, vec2i(floor(position.xy)), 0).rgb;
    let near_light = spread_light(near, position.xy / 4.0);
    let far_light = spread_light(far, position.xy / 16.0);
    let exposed = radiance * draw.exposure + draw.near_part * near_light + draw.far_part * far_light;
    return displayed(exposed, draw.true_to, draw.dither, position.xy);
}
