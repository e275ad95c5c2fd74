// Letters and markers over the finished picture, each texel of theirs on one pixel.
//
// Coming in, per instance: where the letter's left top corner stands in the picture, its place and size in the texture of letters, and its colour.
// Going out: display colour, premultiplied by coverage.

//: use lib/rectangle.wgsl

struct Draw {
    // Clip units per pixel, x and y: 2 / width, 2 / height.
    pixel_size: vec2f,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var letters: texture_2d<f32>;

struct Varyings {
    @builtin(position) position: vec4f,
    // Texel of the letters, and the colour of this one.
    @location(0) texel: vec2f,
    @location(1) @interpolate(flat) colour: vec4f,
}

@vertex
fn vertex_main(
    @builtin(vertex_index) index: u32,
    // Whole pixels from the picture's left top corner.
    @location(0) corner_px: vec2f,
    // Left, top, width, height in texels.
    @location(1) cell: vec4f,
    // sRGB-encoded, and opacity.
    @location(2) colour: vec4f,
) -> Varyings {
    let across = rectangle_corner(index) * cell.zw;
    let place = (corner_px + across) * draw.pixel_size;
    var out: Varyings;
    out.position = vec4f(place.x - 1.0, 1.0 - place.y, 0.0, 1.0);
    out.texel = cell.xy + across;
    out.colour = colour;
    return out;
}

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    let opacity = in.colour.a * textureLoad(letters, vec2i(floor(in.texel)), 0).a;
    return vec4f(in.colour.rgb * opacity, opacity);
}
