// A line of light around a shape, over the finished picture.
//
// Coming in: what the shape covers, and the same blurred, as alpha. Going out: display colour, premultiplied: full at the shape's edge, nothing on the
// shape, fading out beside it.

//: use lib/screen.wgsl

struct Draw {
    // sRGB-encoded.
    colour: vec3f,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var shape: texture_2d<f32>;
@group(0) @binding(2) var blurred: texture_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(screen_corner(index), 0.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(floor(position.xy));
    // Beside a straight edge half of the blur's reach is covered.
    let near = min(2.0 * textureLoad(blurred, pixel, 0).a, 1.0);
    let opacity = near * (1.0 - textureLoad(shape, pixel, 0).a);
    return vec4f(draw.colour * opacity, opacity);
}
