// A sphere or ellipsoid met exactly by each pixel's view ray, with no triangles but the two that bound it on the screen.
//
// All in the unit-sphere frame: body-fixed axes, each coordinate divided by its semi-axis, so that the body is |p| = 1.
// The silhouette is that of the exact quadric; tests/scene/silhouette.rs measures the rounding of the rays.

//: use lib/draw.wgsl
//: use lib/view_ray.wgsl
//: if surface.emissive
//: use lib/uncovered.wgsl
//: end

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
    // The distance to the limb in pixels: 1 - q over its change per pixel, from the discriminant's own change, which anchor and ray give
    // exactly. A straight limb across the pixel is assumed.
    let q = length(closest);
    let along_per_ray = b / length(in.ray);
    let change_x = dot(closest, dpdx(in.anchor) - along_per_ray * dpdx(in.ray));
    let change_y = dot(closest, dpdy(in.anchor) - along_per_ray * dpdy(in.ray));
    // q times its own change.
    let q_change = max(length(vec2f(change_x, change_y)), 1.0e-20);
    let from_limb = discriminant * q / ((1.0 + q) * q_change);
    // Amid a disc there is no direction to the limb; it is 0.7 radii away.
    let filled = select(clamp(0.5 + from_limb, 0.0, 1.0), 1.0, (q < 0.3) & (discriminant > 0.0));
    // A pixel that the limb crosses shows its filled part, from a place 4/9 into it: there the square root that the cosine at
    // the limb is has its mean. A ray that misses takes the limb itself, so that differences between pixels stay finite.
    let within = min(max(from_limb, 0.4444444 * filled) * q_change / max(q, 1.0e-6), 1.0);
    let crossed = filled < 1.0;
    let cosine = sqrt(within * (2.0 - within));
    let beside = closest * ((1.0 - within) / max(q, 1.0e-6)) - cosine * along;
    let at_limb = select(in.anchor, beside, in_front);
    let hit = normalize(select(in.anchor + along_ray * along, at_limb, crossed | !hits));
    let emission = select(root, cosine, crossed);

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
    seen.cos_emission = min(emission / (gradient_length * back_length), 1.0);
//: else
    seen.normal = hit;
    seen.towards_camera = -along;
    seen.cos_emission = min(emission, 1.0);
//: end
    seen.coverage = select(0.0, filled, in_front);
//: if surface.emissive
    // The limb's outward normal on the screen is the way in which q grows.
    seen.coverage = uncovered(seen.coverage, vec2f(change_x, change_y) / q_change, in.position.xy);
//: end
    seen.depth = clamp(1.0 / max(dot(draw.depth_row.xyz, hit) + draw.depth_row.w, 1.0e-20), 0.0, 1.0);
    return seen;
}
