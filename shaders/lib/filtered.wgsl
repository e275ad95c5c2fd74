// How maps are filtered: the same taps on every driver, because drivers differ in how they filter elongated footprints.
//
// A pixel's footprint is the ellipse that its unit circle becomes in texels. Up to `most` trilinear taps stand evenly along its major axis; the mip
// level is log2 of the minor one, or of the major over `most` where that is more. With one tap it is log2 of the longer gradient.
// The software renderer runs `filtered_map` as one operation, by the same formula (src/render/software/sample/footprint.rs; tests/software/filtered.rs).

struct Footprint {
    level: f32,
    // A whole number from 1 on.
    taps: f32,
    // From tap to tap, in map coordinates.
    step: vec2f,
}

// `size`: texels of the map. `dx`, `dy`: change of the map's coordinates from this pixel to the next one right and down.
fn footprint(size: vec2f, dx: vec2f, dy: vec2f, most: f32) -> Footprint {
    let along_x = dx * size;
    let along_y = dy * size;
    // J J^T = [a b; b c]; its eigenvalues are the squares of the axes.
    let a = along_x.x * along_x.x + along_y.x * along_y.x;
    let c = along_x.y * along_x.y + along_y.y * along_y.y;
    let b = along_x.x * along_x.y + along_y.x * along_y.y;
    let half_difference = 0.5 * (a - c);
    let longest_sq = max(dot(along_x, along_x), dot(along_y, along_y));
    let major_sq = select(longest_sq, 0.5 * (a + c) + sqrt(half_difference * half_difference + b * b), most > 1.0);
    let det = along_x.x * along_y.y - along_x.y * along_y.x;
    // Below one texel there is nothing finer to read.
    let kept_sq = max(max(det * det / max(major_sq, 1.0e-30), major_sq / (most * most)), 1.0);
    // 1 % under the next whole number is still that number of taps.
    let taps = clamp(floor(sqrt(major_sq / kept_sq) + 0.99), 1.0, max(most, 1.0));
    // The eigenvector of the major axis, by whichever row is better conditioned.
    let axis = select(vec2f(b, major_sq - a), vec2f(major_sq - c, b), half_difference > 0.0);
    // The outermost taps, as wide as the minor axis, end with the major one: a second tap begins where the first is, and nothing jumps there.
    let spread = sqrt(major_sq) - sqrt(kept_sq);
    let step = axis * (spread * inverseSqrt(max(dot(axis, axis), 1.0e-30)) / max(taps - 1.0, 1.0)) / size;
    return Footprint(0.5 * log2(kept_sq), taps, select(vec2f(0.0), step, taps > 1.0));
}

fn filtered_map(map: texture_2d<f32>, map_sampler: sampler, uv: vec2f, dx: vec2f, dy: vec2f, most: f32) -> vec4f {
    let reach = footprint(vec2f(textureDimensions(map)), dx, dy, most);
    let first = uv - 0.5 * (reach.taps - 1.0) * reach.step;
    var sum = vec4f(0.0);
    for (var tap = 0.0; tap < reach.taps; tap += 1.0) {
        sum += textureSampleLevel(map, map_sampler, first + tap * reach.step, reach.level);
    }
    return sum / reach.taps;
}
