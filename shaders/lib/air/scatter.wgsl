// Sunlight scattered once into a view ray, whatever it crosses, and what the air leaves of the light behind it.
//
// The samples are Gauss and Legendre's in w, on each lit piece of the ray: the planet's own shadow is the cylinder behind it, and what it darkens is left out.
// A density that falls with the height over the piece's lowest point is 1 - w^2, and the sign of w is that of the distance, so that the
// Gaussian of a grazing ray and the exponential of a steep one are both smooth. Optical depths of whole ways are closed forms (lib/air/columns.wgsl), so that
// neither the knots of an absorbing layer nor the steps before a sample add to the error. Through thick air the light comes from the thin air high
// up or from near the camera: w then stands for a larger scale height, and more samples lie near the camera. Left out: light scattered more than
// once, refraction, the Sun's width. Errors: tests/atmosphere/tier_bounds.rs.

//: use lib/draw.wgsl
//: use lib/air/columns.wgsl
//: use lib/air/counts.wgsl
//: use lib/air/path.wgsl
//: use lib/air/sums.wgsl
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
//: use lib/air/shaded.wgsl
//: end
//: if air.table
//: use lib/air/many.wgsl
  //: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
//: use lib/air/spread.wgsl
  //: end
//: end

// Growth of the scale height with the logarithm of the optical depth, and of the samples' density at the camera's end with its root. Of 0 to 0.8 and
// 0 to 2 these had the least error on rays like those of tests/atmosphere/tier_bounds.rs.
const DEEPER = 0.6;
const NEARER = 0.8;

// What a ray has taken before a place on it.
struct AirView {
    // Columns outwards from its start.
    at_camera: vec3f,
    // Of the whole line, where it passes its lowest point.
    through: vec3f,
    passes: bool,
}

fn view_of(air: Air, path: AirPath) -> AirView {
    var view: AirView;
    view.at_camera = columns_from(air, node_at(air, path.from_excess), path.from_s);
    view.passes = path.from_s < 0.0 && path.to_s > 0.0;
    if view.passes {
        view.through = columns_through(air, path.low);
    }
    return view;
}

// Columns from the camera, or where it looks into the air, to a node at the distance s.
fn columns_before(air: Air, view: AirView, node: AirNode, s: f32) -> vec3f {
    let out = columns_from(air, node, s);
    return abs(select(out, view.through - out, view.passes && s > 0.0) - view.at_camera);
}

// A piece of a path in w.
struct AirSpan {
    // Height of the lowest point, and its squared distance.
    base: f32,
    base_sq: f32,
    scale_height: f32,
    // w at the start, and from there to the end.
    first: f32,
    length: f32,
    nearer: f32,
    // The piece ends at its lowest point.
    inward: bool,
}

struct AirSample {
    excess: f32,
    // Distance along the ray.
    s: f32,
    // Way along the ray for a step of 1 in w's place.
    step: f32,
}

// |w| at a height over the lowest point, in scale heights.
fn w_of(heights: f32) -> f32 {
    return sqrt(max(select(1.0 - exp(-heights), heights * (1.0 - 0.5 * heights), heights < 1.0e-3), 0.0));
}

// Of a piece, given by distance and excess of its ends. `depth`: of the whole path.
fn span_of(air: Air, low: f32, start: vec2f, end: vec2f, depth: vec3f) -> AirSpan {
    var span: AirSpan;
    var lowest = low;
    span.inward = end.x <= 0.0;
    if span.inward {
        span.base_sq = end.x * end.x;
        lowest = end.y;
    } else if start.x >= 0.0 {
        span.base_sq = start.x * start.x;
        lowest = start.y;
    }
    span.base = height_of(lowest);
    let deep = 1.0 + dot(depth, vec3f(0.33333333));
    span.scale_height = air.gas_height;
//: if air.mie
    span.scale_height = max(air.gas_height, air.haze_height);
//: end
    span.scale_height *= 1.0 + DEEPER * log(deep);
    span.nearer = NEARER * (sqrt(deep) - 1.0);
    let from_w = w_of((height_of(start.y) - span.base) / span.scale_height);
    let to_w = w_of((height_of(end.y) - span.base) / span.scale_height);
    span.first = select(from_w, -from_w, start.x < 0.0);
    span.length = select(to_w, -to_w, span.inward) - span.first;
    return span;
}

// At a place from 0 to 1.
fn sample_of(span: AirSpan, place: f32) -> AirSample {
    let nearer = 1.0 / (1.0 + span.nearer - span.nearer * place);
    let w = span.first + span.length * (place * nearer);
    let w_sq = w * w;
    let over = span.scale_height * select(-log(1.0 - w_sq), w_sq * (1.0 + 0.5 * w_sq), w_sq < 1.0e-3);
    let height = span.base + over;
    let away = sqrt(span.base_sq + over * (2.0 + span.base + height));
    var sample: AirSample;
    sample.excess = height * (2.0 + height);
    sample.s = select(away, -away, span.inward || w < 0.0);
    sample.step = span.length * (1.0 + span.nearer) * nearer * nearer * (1.0 + height) * 2.0 * span.scale_height * abs(w)
        / ((1.0 - w_sq) * max(away, 1.0e-12));
    return sample;
}

// `shadow`: where the planet hides the Sun. `depth`: of the whole path.
fn air_marched(air: Air, path: AirPath, view: AirView, depth: vec3f, shadow: vec2f, sun_along: f32, sun_nearest: f32, scale: vec2f) -> AirSums {
    var sums: AirSums;
    let dark = select(vec2f(path.to_s), shadow, shadow.y > shadow.x);
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
    var shaded = vec3f(1.0);
//: end
    // Before the shadow, then behind it.
    for (var piece = 0u; piece < 2u; piece++) {
        var start = vec2f(path.from_s, path.from_excess);
        var end = vec2f(path.to_s, path.to_excess);
        if piece == 0u {
            if dark.x < path.to_s {
                end = vec2f(dark.x, path.low + dark.x * dark.x);
            }
        } else if dark.y > path.from_s {
            start = vec2f(dark.y, path.low + dark.y * dark.y);
        }
        if end.x > start.x {
            let span = span_of(air, path.low, start, end, depth);
            for (var i = 0u; i < AIR_SAMPLES; i++) {
                let row = draw.air_samples[i];
                let at = sample_of(span, row.x);
                let node = node_at(air, at.excess);
                let seen = scale.x * columns_before(air, view, node, at.s);
                let sunlit = scale.y * columns_towards(air, node, sun_nearest + at.s * sun_along);
                var part = exp(-depth_of(air, seen + sunlit));
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
                // Two neighbours share what other bodies leave, between them.
                if (i & 1u) == 0u {
                    shaded = shaded_air(path, sample_of(span, row.z).s);
                }
                part *= shaded;
//: end
                part *= scale.x * row.y * at.step * node.a.y;
                sums.gas += part;
//: if air.mie
                sums.haze += node.a.z * part;
//: end
            }
        }
    }
    return sums;
}

//: if air.table
// Light scattered many times, of the whole path: it reaches into the shadow. It is smooth along a ray. As many as air_many_samples in lib/draw.wgsl.
const MANY_SAMPLES = 8u;

fn many_marched(air: Air, path: AirPath, view: AirView, depth: vec3f, sun_along: f32, sun_nearest: f32, scale: vec2f) -> vec3f {
    // Behind four to eight optical depths the far side is drawn in, so that the limb of an opaque body is as bright as the ground beside it. This light has no
    // forward peak, and lacks nothing of it.
    var end = vec2f(path.to_s, path.to_excess);
    if view.passes {
        let near_side = min(depth.x, min(depth.y, depth.z)) * (path.from_s / (path.from_s - path.to_s));
        end.x = path.to_s * clamp(2.0 - near_side / 4.0, 0.0, 1.0);
        end.y = path.low + end.x * end.x;
    }
    let span = span_of(air, path.low, vec2f(path.from_s, path.from_excess), end, depth);
    var light = vec3f(0.0);
  //: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
    var shaded = vec3f(1.0);
  //: end
    for (var i = 0u; i < MANY_SAMPLES; i++) {
        let row = draw.air_many_samples[i];
        let at = sample_of(span, row.x);
        let node = node_at(air, at.excess);
        var scattered = air.gas_scattering;
  //: if air.mie
        scattered += node.a.z * air.haze_scattering;
  //: end
        let cosine = (sun_nearest + at.s * sun_along) * node.a.w;
        var part = exp(-scale.x * depth_of(air, columns_before(air, view, node, at.s))) * many_at(many_row(height_of(at.excess)), cosine);
  //: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
        if (i & 1u) == 0u {
            let between = sample_of(span, row.z);
            shaded = many_left(path, between.s, between.excess);
        }
        part *= shaded;
  //: end
        light += part * scattered * (scale.x * row.y * at.step * node.a.y);
    }
    return light;
}
//: end
