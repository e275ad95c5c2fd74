// The interface's triangles in a window: panels, letters, and the picture of the sky among them.
//
// Coming in, per corner: its place in the window, its place in the texture, and its colour. Colours are sRGB-encoded and premultiplied all the way,
// because the interface is blended so. Going out: display colour, premultiplied.

struct Draw {
    // Clip units per pixel, x and y: 2 / width, 2 / height.
    pixel_size: vec2f,
}

@group(0) @binding(0) var<uniform> draw: Draw;
@group(0) @binding(1) var texels: texture_2d<f32>;
@group(0) @binding(2) var reads: sampler;

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
    @location(1) colour: vec4f,
}

@vertex
fn vertex_main(
    // Pixels from the window's left top corner.
    @location(0) corner_px: vec2f,
    // 0 to 1, from the texture's left top corner.
    @location(1) place: vec2f,
    @location(2) colour: vec4f,
) -> Varyings {
    let at = corner_px * draw.pixel_size;
    var out: Varyings;
    out.position = vec4f(at.x - 1.0, 1.0 - at.y, 0.0, 1.0);
    out.place = place;
    out.colour = colour;
    return out;
}

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    return in.colour * textureSampleLevel(texels, reads, in.place, 0.0);
}
