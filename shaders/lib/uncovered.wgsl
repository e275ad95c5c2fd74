// What nearer bodies leave of a pixel of a glowing disc.
//
// A nearer body is drawn later over this one, by its own coverage w: what is given here is left by 1 - w. Where both limbs cross one pixel the product of two
// coverages is no area: of a disc that lies wholly behind it would leave up to a quarter. Both limbs are straight lines over a pixel, so the
// part that is inside this one and outside the nearer is known from both coverages and the angle between the lines; divided by 1 - w, it
// comes out right after the later draw.
//
// The nearer limb is where L = sqrt(M), L linear and M quadratic in the pixel's place: the ray's nearness to the body's middle, and the tangent cone's. Rows per
// body: the quadratic form F = L^2 - M as 1, x, y and the kind (0 none, 1 drawn over, 2 too small to be drawn, 3 hides all); F as x^2, xy, y^2 and
// a factor on its coverage; L as 1, x, y and, of the first body x, of the second y of the pixel from which places count.

//: use lib/draw.wgsl

// Area inside a line and outside another. `u`, `w`: what each holds of the pixel, `cosine`: between their outward normals. Exact for lines that cross at a small
// angle (either way round), and for those at a right angle.
fn inside_and_outside(u: f32, w: f32, cosine: f32) -> f32 {
    // Over the pixel one line runs this far to either side of the other; less, where that would lead out of the pixel.
    let room = 2.0 * min(min(u, 1.0 - u), min(w, 1.0 - w));
    let slack = min(0.5 * sqrt(max(1.0 - cosine * cosine, 0.0)), room);
    let other = select(w, 1.0 - w, cosine < 0.0);
    let over = max(slack - abs(u - other), 0.0);
    let both = min(u, other) - over * over / max(4.0 * slack, 1.0e-9);
    let along = select(u - both, both, cosine < 0.0);
    let straight = 1.0 - abs(cosine);
    return mix(along, u * (1.0 - w), straight * straight);
}

// Distance to the nearer body's limb in pixels, positive inside (x), and the outward normal (yz).
fn hider_limb(row: i32, at: vec2f) -> vec3f {
    let f = draw.hider[row];
    let h = draw.hider[row + 1];
    let l = draw.hider[row + 2];
    let level = f.x + dot(f.yz, at) + h.x * at.x * at.x + h.y * at.x * at.y + h.z * at.y * at.y;
    let level_change = f.yz + vec2f(2.0 * h.x * at.x + h.y * at.y, h.y * at.x + 2.0 * h.z * at.y);
    let near = l.x + dot(l.yz, at);
    let cone = sqrt(max(near * near - level, 1.0e-30));
    let cone_change = (near * l.yz - 0.5 * level_change) / cone;
    // L - sqrt(M) without the difference of two like numbers.
    let sum = near + cone;
    let sum_change = l.yz + cone_change;
    let ahead = near > 0.0;
    let value = select(near - cone, level / sum, ahead);
    let change = select(l.yz - cone_change, (level_change - value * sum_change) / sum, ahead);
    let steep = max(length(change), 1.0e-30);
    let inwards = change / steep;
    // The curve along the normal: small bodies have round limbs.
    let bend = (h.x * inwards.x * inwards.x + h.y * inwards.x * inwards.y + h.z * inwards.y * inwards.y - steep * dot(inwards, sum_change)) / sum;
    let curve = select(0.0, bend, ahead);
    let inside_px = 2.0 * value / (steep + sqrt(max(steep * steep - 4.0 * value * curve, 0.0)));
    return vec3f(inside_px, -inwards);
}

// `coverage`: of the glowing disc, its limb's outward normal and the pixel's place on the screen.
fn uncovered(coverage: f32, outwards: vec2f, place: vec2f) -> f32 {
    var left = coverage;
    for (var row = 0; row < 6; row += 3) {
        let kind = draw.hider[row].w;
        if kind > 0.5 {
            let limb = hider_limb(row, place - vec2f(draw.hider[2].w, draw.hider[5].w));
            let covers = clamp(0.5 + limb.x, 0.0, 1.0) * draw.hider[row + 1].w;
            let part = inside_and_outside(coverage, covers, dot(outwards, limb.yz)) / max(coverage, 1.0e-9);
            // The later draw leaves 1 - covers of what is given; a point takes nothing, so that here the light is taken.
            let given = select(part, part / max(1.0 - covers, 1.0e-6), kind < 1.5);
            left *= select(clamp(given, 0.0, 1.0), 0.0, kind > 2.5);
        }
    }
    return left;
}
