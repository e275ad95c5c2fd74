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
fn near_at(texel: vec2i) -> vec3f {
    return textureLoad(near, clamp(texel, vec2i(0), vec2i(textureDimensions(near)) - vec2i(1)), 0).rgb;
}

fn far_at(texel: vec2i) -> vec3f {
    return textureLoad(far, clamp(texel, vec2i(0), vec2i(textureDimensions(far)) - vec2i(1)), 0).rgb;
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let radiance = textureLoad(hdr, vec2i(floor(position.xy)), 0).rgb;
    // Between the middles of four texels.
    let of_near = position.xy / 4.0 - 0.5;
    let n = vec2i(floor(of_near));
    let a = fract(of_near);
    let near_light = mix(
        mix(near_at(n), near_at(n + vec2i(1, 0)), a.x),
        mix(near_at(n + vec2i(0, 1)), near_at(n + vec2i(1, 1)), a.x),
        a.y,
    );
    let of_far = position.xy / 16.0 - 0.5;
    let f = vec2i(floor(of_far));
    let b = fract(of_far);
    let far_light = mix(
        mix(far_at(f), far_at(f + vec2i(1, 0)), b.x),
        mix(far_at(f + vec2i(0, 1)), far_at(f + vec2i(1, 1)), b.x),
        b.y,
    );
    let exposed = radiance * draw.exposure + draw.near_part * near_light + draw.far_part * far_light;
    return displayed(exposed, draw.true_to, draw.dither, position.xy);
}
