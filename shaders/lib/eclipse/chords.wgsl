// What ellipses hide together of the Sun's disc, slice by slice: on each chord of the Sun the union of the casters' chords.
//
// The same integrals as in circle.wgsl. The slices end where the casters' own ends lie, not at every crossing of outlines: measured
// 1.3e-4 of the light for one ellipse (tests/data).

//: use lib/eclipse/nodes.wgsl
//: use lib/eclipse/silhouette.wgsl
//: use lib/eclipse/circle.wgsl

// The outline in axes whose y is `up`: centre, and the terms of its chords.
struct Sliced {
    centre: vec2f,
    slope: f32,
    // Squared half chord through the centre, over the squared half height.
    half_chord: f32,
    half_height: f32,
}

fn sliced(s: Silhouette, up: vec2f) -> Sliced {
    let right = vec2f(up.y, -up.x);
    let axis = vec2f(dot(s.axis, right), dot(s.axis, up));
    let squared = s.semi * s.semi;
    // The half height squared; axis is a unit vector.
    let height = axis.y * axis.y * squared.x + axis.x * axis.x * squared.y;
    let half_height = sqrt(max(height, 1.0e-30));
    var out: Sliced;
    out.centre = vec2f(dot(s.centre, right), dot(s.centre, up));
    out.slope = axis.x * axis.y * (squared.x - squared.y) / (half_height * half_height);
    out.half_chord = s.semi.x * s.semi.y / half_height;
    out.half_height = half_height;
    return out;
}

// From left to right at a height, inside the Sun's half chord; where there is none, from end to same end.
fn chord(s: Sliced, y: f32, sun_half: f32) -> vec2f {
    let level = (y - s.centre.y) / s.half_height;
    let half = s.half_chord * sqrt(max((1.0 - level) * (1.0 + level), 0.0));
    let middle = s.centre.x + s.slope * (y - s.centre.y);
    let ends = clamp(vec2f(middle - half, middle + half), vec2f(-sun_half), vec2f(sun_half));
    return select(vec2f(-sun_half), ends, abs(level) < 1.0);
}

// Integrals of 1, mu, mu^2 along a chord of the Sun from its middle to x.
fn along_chord(x: f32, sun_squared: f32) -> vec3f {
//: if eclipse.uniform-disc
    return vec3f(x, 0.0, 0.0);
//: else
    let end = sqrt(max(sun_squared - x * x, 0.0));
    return vec3f(x, 0.5 * (x * end + sun_squared * atan2(x, end)), x * (sun_squared - x * x / 3.0));
//: end
}

fn between(ends: vec2f, sun_squared: f32) -> vec3f {
    return along_chord(ends.y, sun_squared) - along_chord(ends.x, sun_squared);
}

fn hidden_by_ellipse(s: Silhouette) -> vec3f {
    let distance = length(s.centre);
    let up = select(vec2f(0.0, 1.0), s.centre / distance, distance > 1.0e-6);
    let e = sliced(s, up);
    let low = max(e.centre.y - e.half_height, -1.0);
    let half_span = 0.5 * (min(e.centre.y + e.half_height, 1.0) - low);
    var hidden = vec3f(0.0);
    for (var k = 0; k < CHORD_NODES; k++) {
        let y = low + half_span * (1.0 + CHORD_NODE[k]);
        let sun_squared = max((1.0 - y) * (1.0 + y), 0.0);
        hidden += CHORD_WEIGHT[k] * between(chord(e, y, sqrt(sun_squared)), sun_squared);
    }
    return hidden * max(half_span, 0.0);
}

//: if eclipse.2
// The two in order of their left ends.
fn first_of(a: vec2f, b: vec2f) -> vec2f {
    return select(b, a, a.x <= b.x);
}
fn second_of(a: vec2f, b: vec2f) -> vec2f {
    return select(a, b, a.x <= b.x);
}

// Heights between which a caster lies, within the Sun's.
fn low_end(s: Sliced) -> f32 {
    return clamp(s.centre.y - s.half_height, -1.0, 1.0);
}
fn high_end(s: Sliced) -> f32 {
    return clamp(s.centre.y + s.half_height, -1.0, 1.0);
}

// What a chord adds beyond `reached`.
fn beyond(ends: vec2f, reached: f32, sun_squared: f32) -> vec3f {
    return between(vec2f(max(ends.x, reached), max(ends.y, reached)), sun_squared);
}

//: if eclipse.4
fn hidden_together(s0: Silhouette, s1: Silhouette, s2: Silhouette, s3: Silhouette) -> Overlap {
//: else
  //: if eclipse.3
fn hidden_together(s0: Silhouette, s1: Silhouette, s2: Silhouette) -> Overlap {
  //: else
fn hidden_together(s0: Silhouette, s1: Silhouette) -> Overlap {
  //: end
//: end
    let up = vec2f(0.0, 1.0);
    let e0 = sliced(s0, up);
    let e1 = sliced(s1, up);
  //: if eclipse.3
    let e2 = sliced(s2, up);
  //: end
  //: if eclipse.4
    let e3 = sliced(s3, up);
  //: end
    // Between the heights where a caster ends the chords are smooth but for the crossings of outlines.
  //: if eclipse.4
    const ENDS: i32 = 8;
    var ends = array<f32, 8>(low_end(e0), high_end(e0), low_end(e1), high_end(e1), low_end(e2), high_end(e2), low_end(e3), high_end(e3));
  //: else
    //: if eclipse.3
    const ENDS: i32 = 6;
    var ends = array<f32, 6>(low_end(e0), high_end(e0), low_end(e1), high_end(e1), low_end(e2), high_end(e2));
    //: else
    const ENDS: i32 = 4;
    var ends = array<f32, 4>(low_end(e0), high_end(e0), low_end(e1), high_end(e1));
    //: end
  //: end
    for (var last = ENDS - 1; last > 0; last--) {
        for (var k = 0; k < last; k++) {
            let low = min(ends[k], ends[k + 1]);
            ends[k + 1] = max(ends[k], ends[k + 1]);
            ends[k] = low;
        }
    }
    var hidden = vec3f(0.0);
    // The longest stretch of a chord that is left, or that of a height that no caster reaches.
    var gap = max(max(ends[0] + 1.0, 1.0 - ends[ENDS - 1]), 0.0);
    for (var step = 0; step < CIRCLE_NODES * (ENDS - 1); step++) {
        let span = step / CIRCLE_NODES;
        let node = step % CIRCLE_NODES;
        let half_span = 0.5 * (ends[span + 1] - ends[span]);
        let y = ends[span] + half_span * (1.0 + CIRCLE_NODE[node]);
        let sun_squared = max((1.0 - y) * (1.0 + y), 0.0);
        let sun_half = sqrt(sun_squared);
        var a = chord(e0, y, sun_half);
        var b = chord(e1, y, sun_half);
        var swap = first_of(a, b);
        b = second_of(a, b);
        a = swap;
  //: if eclipse.3
        var c = chord(e2, y, sun_half);
    //: if eclipse.4
        var d = chord(e3, y, sun_half);
        // A sorting network: (a b) (c d) (a c) (b d) (b c).
        swap = first_of(c, d);
        d = second_of(c, d);
        c = swap;
        swap = first_of(a, c);
        c = second_of(a, c);
        a = swap;
        swap = first_of(b, d);
        d = second_of(b, d);
        b = swap;
        swap = first_of(b, c);
        c = second_of(b, c);
        b = swap;
    //: else
        swap = first_of(b, c);
        c = second_of(b, c);
        b = swap;
        swap = first_of(a, b);
        b = second_of(a, b);
        a = swap;
    //: end
  //: end
        var sum = between(a, sun_squared) + beyond(b, a.y, sun_squared);
        var open = max(a.x + sun_half, b.x - a.y);
        var last = max(a.y, b.y);
  //: if eclipse.3
        sum += beyond(c, last, sun_squared);
        open = max(open, c.x - last);
        last = max(last, c.y);
    //: if eclipse.4
        sum += beyond(d, last, sun_squared);
        open = max(open, d.x - last);
        last = max(last, d.y);
    //: end
  //: end
        // A span of no height has no chords.
        gap = max(gap, select(0.0, max(open, sun_half - last), half_span > 0.0));
        hidden += CIRCLE_WEIGHT[node] * half_span * sum;
    }
    // Together they may hide all where none does alone.
    if gap <= 1.0e-6 {
        return Overlap(WHOLE_SUN, vec3f(0.0));
    }
    return Overlap(hidden, max(WHOLE_SUN - hidden, vec3f(0.0)));
}
//: end
