// One view ray for each pixel of the rectangle that bounds what is drawn.

//: use lib/draw.wgsl
//: use lib/rectangle.wgsl

struct Varyings {
    @builtin(position) position: vec4f,
    // A point of the view ray, and the ray's direction (any length). Affine over the rectangle, so interpolation is exact.
    @location(0) anchor: vec3f,
    @location(1) ray: vec3f,
}

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> Varyings {
    let corner = rectangle_corner(index);
    var out: Varyings;
    out.position = vec4f(mix(draw.rect_in_clip.xy, draw.rect_in_clip.zw, corner), 0.0, 1.0);
    out.anchor = draw.anchor_origin + corner.x * draw.anchor_du + corner.y * draw.anchor_dv;
    out.ray = draw.ray_origin + corner.x * draw.ray_du + corner.y * draw.ray_dv;
    return out;
}
