// Bodies and stars smaller than a pixel: instanced sprites with a Gaussian point-spread function, added to the frame.
//
// Per instance: centre (clip x, clip y, reversed depth), radius of the sprite in pixels, flux (linear RGB: the radiance that the
// point would have if it filled one pixel). The sum over the sprite's pixels is the flux: within 0.6 % for a
// radius of 2 pixels or more, wherever the centre lies in its pixel (measured); below that pixels miss the peak: 4 % at 1.5, 50 % at 1.

//: use lib/own_depth.wgsl
//: use lib/rectangle.wgsl

struct Draw {
    // Clip units per pixel, x and y: 2 / width, 2 / height.
    pixel_size: vec2f,
}

@group(0) @binding(0) var<uniform> draw: Draw;

struct Varyings {
    @builtin(position) position: vec4f,
    // Offset from the centre in standard deviations; the sprite reaches to 3.
    @location(0) offset: vec2f,
    // Radiance at the centre.
    @location(1) @interpolate(flat) peak: vec3f,
    @location(2) @interpolate(flat) depth: f32,
}

@vertex
fn vertex_main(
    @builtin(vertex_index) index: u32,
    @location(0) centre: vec3f,
    @location(1) radius_px: f32,
    @location(2) flux: vec3f,
) -> Varyings {
    let corner = rectangle_corner(index) * 2.0 - 1.0;
    var out: Varyings;
    out.position = vec4f(centre.xy + vec2f(corner.x, -corner.y) * radius_px * draw.pixel_size, centre.z, 1.0);
    out.offset = 3.0 * corner;
    out.depth = centre.z;
    // 1 / (2 pi sigma^2) per pixel, sigma a third of the radius, over the 0.99461 of a Gaussian that a square of 3 sigma holds.
    let sigma = max(radius_px, 1.0e-3) / 3.0;
    out.peak = flux * (0.16001802 / (sigma * sigma));
    return out;
}

@fragment
fn fragment_main(in: Varyings) -> OwnDepth {
    return OwnDepth(vec4f(in.peak * exp(-0.5 * dot(in.offset, in.offset)), 0.0), in.depth);
}
