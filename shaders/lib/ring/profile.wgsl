// The ring's radial profile: integrals over radius that answer any pixel's footprint with two reads, however narrow a ringlet.
//
// Row 0 of the table: the radii where the optical depth changes (x), and how far the next one is (y: the difference of two radii has few
// digits). Row 1 + k: up to each of these radii, the integral of
// 1 - exp(-tau x) at x = 2^(k/8), where x is one over the cosine of a path (or the sum of two): times the colour and the part of bodies (xyz) and
// alone (w). Row 98 + k: the same times the colour and the part of dust (xyz). Exact in radius; between rows linear in log2 x, off by 2.8e-4 at most (h^2/8 times the second derivative, 0.3).

//: use lib/draw.wgsl

@group(0) @binding(5) var ring_profile: texture_2d<f32>;

const ROWS_PER_OCTAVE: f32 = 8.0;
// x up to 2^12: nearer than 0.014 degrees to the ring's plane a path counts as that steep.
const LAST_ROW: f32 = 96.0;
const BODIES: i32 = 1;
const DUST: i32 = 98;
const LEAST_COSINE: f32 = 0.000244140625;
// Footprints below this (6 km at Saturn) are taken as a point: the difference of two integrals has no digits left there.
const LEAST_FOOTPRINT: f32 = 1.0e-4;

struct RingPlace {
    // The node at or below the radius.
    node: i32,
    // 0 at that node, 1 at the next.
    part: f32,
    radius: f32,
}

// Finds a radius among the nodes; beyond the ends, the end.
fn ring_place(radius: f32) -> RingPlace {
    var low = 0;
    var high = i32(draw.ring_nodes) - 1;
    while high - low > 1 {
        let middle = (low + high) / 2;
        let reached = textureLoad(ring_profile, vec2i(middle, 0), 0).x <= radius;
        low = select(low, middle, reached);
        high = select(middle, high, reached);
    }
    let below = textureLoad(ring_profile, vec2i(low, 0), 0).x;
    let above = textureLoad(ring_profile, vec2i(high, 0), 0).x;
    return RingPlace(low, clamp((radius - below) / max(above - below, 1.0e-12), 0.0, 1.0), radius);
}

// The integral up to a place in one row.
fn ring_sum(place: RingPlace, row: i32) -> vec4f {
    let below = textureLoad(ring_profile, vec2i(place.node, row), 0);
    let above = textureLoad(ring_profile, vec2i(place.node + 1, row), 0);
    return mix(below, above, place.part);
}

// Density between two nodes in one row.
fn ring_step(place: RingPlace, row: i32) -> vec4f {
    let width = textureLoad(ring_profile, vec2i(place.node, 0), 0).y;
    let below = textureLoad(ring_profile, vec2i(place.node, row), 0);
    let above = textureLoad(ring_profile, vec2i(place.node + 1, row), 0);
    // Past the ends there is nothing; stretches are half open.
    let inside = place.radius >= draw.ring_reach.x && place.radius < draw.ring_reach.y;
    return select(vec4f(0.0), (above - below) / max(width, 1.0e-12), inside);
}

// Mean over a stretch of radius.
struct RingStretch {
    inner: RingPlace,
    outer: RingPlace,
}

fn ring_stretch(from_radius: f32, to_radius: f32) -> RingStretch {
    let inner = ring_place(from_radius);
    if to_radius - from_radius < LEAST_FOOTPRINT {
        let middle = ring_place(0.5 * (from_radius + to_radius));
        return RingStretch(middle, middle);
    }
    return RingStretch(inner, ring_place(to_radius));
}

// Mean of 1 - exp(-tau x) over the stretch: by bodies times their colour (xyz), by all that is there (w).
fn ring_opacity(stretch: RingStretch, x: f32) -> vec4f {
    return ring_stopped(stretch, BODIES, x);
}

// The same of either part of the table.
fn ring_stopped(stretch: RingStretch, first_row: i32, x: f32) -> vec4f {
    let at = clamp(log2(x) * ROWS_PER_OCTAVE, 0.0, LAST_ROW - 0.001);
    let row = first_row + i32(at);
    let upper = fract(at);
    let width = stretch.outer.radius - stretch.inner.radius;
    if width < LEAST_FOOTPRINT {
        return mix(ring_step(stretch.inner, row), ring_step(stretch.inner, row + 1), upper);
    }
    let low_row = ring_sum(stretch.outer, row) - ring_sum(stretch.inner, row);
    let high_row = ring_sum(stretch.outer, row + 1) - ring_sum(stretch.inner, row + 1);
    return max(mix(low_row, high_row, upper) / width, vec4f(0.0));
}
