// Lines of one width in pixels: orbits.
//
// Coming in, per instance, a straight piece: its ends, the way from each end to the line's edge (neighbouring pieces share theirs, so that they meet
// without gap or overlap), the opacity at each end and the colour. Going out: linear RGB radiance, premultiplied by opacity (blend: premultiplied
// over), and depth: that of the ends, linear between them on the screen as reversed depth is (lib/own_depth.wgsl); it is tested, and not kept.

//: use lib/own_depth.wgsl
//: use lib/rectangle.wgsl

struct Draw {
    // Clip units per pixel, x and y: 2 / width, 2 / height.
    pixel_size: vec2f,
    // Half the line's width in pixels.
    half_width_px: f32,
    // Radiance of a line of colour 1.
    radiance: f32,
}

@group(0) @binding(0) var<uniform> draw: Draw;

struct Varyings {
    @builtin(position) position: vec4f,
    // Pixels from the middle of the line.
    @location(0) across_px: f32,
    @location(1) strength: f32,
    @location(2) @interpolate(flat) colour: vec3f,
    @location(3) depth: f32,
}

@vertex
fn vertex_main(
    @builtin(vertex_index) index: u32,
    // Clip x and y, reversed depth.
    @location(0) from_end: vec3f,
    @location(1) to_end: vec3f,
    // Pixels, x right, y up.
    @location(2) from_across: vec2f,
    @location(3) to_across: vec2f,
    @location(4) strength: vec2f,
    @location(5) colour: vec3f,
) -> Varyings {
    let corner = rectangle_corner(index);
    let at_end = corner.x > 0.5;
    let side = 2.0 * corner.y - 1.0;
    // One pixel more on each side, for the soft edge.
    let reach_px = side * (draw.half_width_px + 1.0);
    let end = select(from_end, to_end, at_end);
    let across = select(from_across, to_across, at_end);
    var out: Varyings;
    out.position = vec4f(end.xy + across * reach_px * draw.pixel_size, end.z, 1.0);
    out.across_px = reach_px;
    out.strength = select(strength.x, strength.y, at_end);
    out.colour = colour;
    out.depth = end.z;
    return out;
}

@fragment
fn fragment_main(in: Varyings) -> OwnDepth {
    // How much of a pixel at this distance the line covers.
    let opacity = in.strength * clamp(draw.half_width_px + 0.5 - abs(in.across_px), 0.0, 1.0);
    return OwnDepth(vec4f(in.colour * (draw.radiance * opacity), opacity), in.depth);
}
