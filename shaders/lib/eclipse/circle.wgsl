// What a disc hides of the Sun's disc, and what it leaves: integrals of 1, mu and mu^2 over that part, mu = sqrt(1 - r^2), lengths in solar radii.
//
// Where nothing is hidden the one is exactly 0, where all is hidden the other. Near those ends each keeps its own digits: a crescent is summed
// itself, not as what is missing from the whole.
//
// Slices across the line of centres. Where the caster's chord is shorter than the Sun's each slice is closed and the sum is by the
// nodes; beyond the crossing of the two circles the Sun's whole chords are hidden, and that cap is closed. Measured against 40-digit
// integrals (tests/data): 2e-7 in f64 with these 12 nodes.

//: use lib/eclipse/nodes.wgsl

//: if eclipse.uniform-disc
const WHOLE_SUN = vec3f(3.14159265359, 0.0, 0.0);
//: else
const WHOLE_SUN = vec3f(3.14159265359, 2.09439510239, 1.57079632679);
//: end

// Integrals of 1, mu, mu^2; together WHOLE_SUN. Exact ends: nothing hidden is 0, nothing left is 0.
struct Overlap {
    hidden: vec3f,
    left: vec3f,
}

fn hidden_by_circle(radius: f32, distance: f32) -> vec3f {
    let d = max(distance, 1.0e-9);
    // From the far limb of the Sun to the near limb of the caster; the form keeps its digits for two like discs.
    let overhang = (1.0 - radius) + d;
    if overhang >= 2.0 {
        return vec3f(0.0);
    }
    if overhang <= 0.0 {
        return WHOLE_SUN;
    }
    let far_limb = d + radius;
    let inside = far_limb < 1.0;
    // Heights count from the Sun's centre towards the caster's; `depth` from the caster's near limb.
    let half_span = select(overhang * (2.0 - overhang) / (4.0 * d), radius, inside);
    let past_end = select(0.0, (1.0 - far_limb) * (1.0 + far_limb), inside);
    var hidden = vec3f(0.0);
    for (var k = 0; k < CIRCLE_NODES; k++) {
        let depth = half_span * (1.0 + CIRCLE_NODE[k]);
        let half_chord = sqrt(max(depth * (2.0 * radius - depth), 0.0));
//: if eclipse.uniform-disc
        hidden.x += CIRCLE_WEIGHT[k] * half_chord;
//: else
        // mu^2 at the chord's end, without the difference of two like squares.
        let end_squared = past_end + 2.0 * d * half_span * (1.0 - CIRCLE_NODE[k]);
        let end = sqrt(end_squared);
        let half_squared = half_chord * half_chord;
        let sun_squared = half_squared + end_squared;
        hidden += CIRCLE_WEIGHT[k] * vec3f(
            half_chord,
            0.5 * (half_chord * end + sun_squared * atan2(half_chord, end)),
            half_chord * (sun_squared - half_squared / 3.0),
        );
//: end
    }
    hidden *= 2.0 * half_span;
    if !inside {
        let y = clamp(overhang - 1.0 + 2.0 * half_span, -1.0, 1.0);
        let half_chord = sqrt((1.0 - y) * (1.0 + y));
        let angle = atan2(half_chord, y);
//: if eclipse.uniform-disc
        hidden.x += angle - y * half_chord;
//: else
        hidden += vec3f(
            angle - y * half_chord,
            1.57079632679 * (0.66666666667 - y * (1.0 - y * y / 3.0)),
            0.5 * angle - y * half_chord * (5.0 - 2.0 * y * y) / 6.0,
        );
//: end
    }
    return hidden;
}

// What is left beside a disc of at least the Sun's size that covers the Sun's centre.
fn left_by_circle(radius: f32, distance: f32) -> vec3f {
    let d = max(distance, 1.0e-9);
    let overhang = (1.0 - radius) + d;
    if overhang <= 0.0 {
        return vec3f(0.0);
    }
    // Up to the near limb the Sun's whole chords are left: a cap of this height. Beyond it their ends, up to the crossing of the circles.
    let half_span = overhang * (2.0 - overhang) / (4.0 * d);
    let y = 1.0 - overhang;
    let cap_half = sqrt(overhang * (2.0 - overhang));
    let angle = atan2(cap_half, y);
    var left = vec3f(0.0);
    for (var k = 0; k < CIRCLE_NODES; k++) {
        let depth = half_span * (1.0 + CIRCLE_NODE[k]);
        let half_chord = sqrt(max(depth * (2.0 * radius - depth), 0.0));
        let end_squared = 2.0 * d * half_span * (1.0 - CIRCLE_NODE[k]);
        let sun_squared = half_chord * half_chord + end_squared;
        let sun_half = sqrt(sun_squared);
        // From the caster's limb to the Sun's, without the difference of two like lengths.
        let beyond = end_squared / max(sun_half + half_chord, 1.0e-20);
//: if eclipse.uniform-disc
        left.x += CIRCLE_WEIGHT[k] * beyond;
//: else
        let end = sqrt(end_squared);
        left += CIRCLE_WEIGHT[k] * vec3f(
            beyond,
            0.5 * (sun_squared * atan2(end, half_chord) - half_chord * end),
            beyond * beyond * (2.0 * sun_half + half_chord) / 3.0,
        );
//: end
    }
    left *= 2.0 * half_span;
//: if eclipse.uniform-disc
    left.x += angle - y * cap_half;
//: else
    left += vec3f(
        angle - y * cap_half,
        0.52359877560 * overhang * overhang * (3.0 - overhang),
        0.5 * angle - y * cap_half * (5.0 - 2.0 * y * y) / 6.0,
    );
//: end
    return max(left, vec3f(0.0));
}
