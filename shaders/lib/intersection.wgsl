// A sphere or ellipsoid met exactly by each pixel's view ray, with no triangles but the two that bound it on the screen.
//
// All in the unit-sphere frame: body-fixed axes, each coordinate divided by its semi-axis, so that the body is |p| = 1.
// The silhouette is that of the exact quadric; tests/scene_silhouette.rs measures the rounding of the rays.

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

struct Seen {
    // Unit-sphere frame, length 1.
    position: vec3f,
    // Outward, body axes.
    normal: vec3f,
    // Unit vector, body axes.
    towards_camera: vec3f,
    // Cosine between the two, 0 at the limb.
    cos_emission: f32,
    // Part of the pixel that the body fills.
    coverage: f32,
    // Reversed depth: 1 near, 0 infinitely far.
    depth: f32,
}

fn seen_surface(in: Varyings) -> Seen {
    let along = normalize(in.ray);
    let b = dot(in.anchor, along);
    let closest = in.anchor - b * along;
    let near = draw.anchor_is_camera > 0.5;
    // Far: 1 - q^2 with q the ray's distance from the centre. Near: the same number without the cancellation of two large
    // squares, from |camera|^2 - 1 as the scene computed it in f64.
    let discriminant = select(1.0 - dot(closest, closest), b * b - draw.anchor_excess, near);
    let root = sqrt(max(discriminant, 0.0));
    // The nearer root; for a near camera as a quotient, which keeps its digits close above the ground.
    let along_ray = select(-b - root, draw.anchor_excess / max(root - b, 1.0e-12), near);
    let in_front = select(true, b < 0.0, near);
    let hits = select(false, discriminant > 0.0, in_front);
    // A ray that misses takes the point of the limb beside it, so that differences between pixels stay finite.
    let beside = select(in.anchor, closest, in_front);
    let hit = normalize(select(beside, in.anchor + along_ray * along, hits));

    var seen: Seen;
    seen.position = hit;
//: if shape.ellipsoid
    // The gradient of the ellipsoid, and the ray back to the camera with the axes restored. Their cosine is dot(hit, -along) over
    // both lengths, and that product is the root itself: exactly 0 at the limb.
    let gradient = hit / draw.axis_ratios;
    let back = -along * draw.axis_ratios;
    let gradient_length = length(gradient);
    let back_length = length(back);
    seen.normal = gradient / gradient_length;
    seen.towards_camera = back / back_length;
    seen.cos_emission = min(root / (gradient_length * back_length), 1.0);
//: else
    seen.normal = hit;
    seen.towards_camera = -along;
    seen.cos_emission = min(root, 1.0);
//: end
    // The discriminant crosses zero at the limb; over its change per pixel it is the distance to the limb in pixels.
    // A straight limb across each 2x2 quad is assumed. Measured: a disc of 4 pixels radius has up to 2.8 % too much area and one of its
    // pixels is off by up to 0.11; at 16 pixels 0.1 % and 0.065.
    let change = length(vec2f(dpdx(discriminant), dpdy(discriminant)));
    let filled = clamp(0.5 + discriminant / max(change, 1.0e-20), 0.0, 1.0);
    seen.coverage = select(0.0, filled, in_front);
    seen.depth = clamp(1.0 / max(dot(draw.depth_row.xyz, hit) + draw.depth_row.w, 1.0e-20), 0.0, 1.0);
    return seen;
}
