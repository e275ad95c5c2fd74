// The Sun through the air at a body's limb: its image bent, flattened and reddened, beside the disc or all round it.
//
// Drawn twice. Once behind the body's air, to take away what was drawn of the Sun along straight rays below the air's top; once over the body, to
// add the light that the air bends to the camera. Both blend premultiplied over: the first is black with an opacity, the second light without
// one. A view ray that grazes the air at some height is bent towards the body by the bending of that height; radiance is kept along it but for
// what the layer takes. Heights count from the limb, so that f32 keeps metres at any distance. The layers are thinner than most pixels: each gives
// its part of the pixel's area (a square's, exactly), two places in it its light. Along the limb a pixel stands for three directions. Left out: what
// stands before the Sun as the limb sees it, the curve of the limb within a pixel. src/scene/refracted_limb.rs fills the numbers.

//: use lib/own_depth.wgsl
//: use lib/rectangle.wgsl

const LAYERS: i32 = 32;
const DIRECTIONS: i32 = 3;

struct Draw {
    // View rays over a rectangle, as of lib/draw.wgsl: unit-sphere frame of the body.
    rect_in_clip: vec4f,
    anchor_origin: vec3f,
    anchor_du: vec3f,
    anchor_dv: vec3f,
    ray_origin: vec3f,
    ray_du: vec3f,
    ray_dv: vec3f,
    anchor_is_camera: f32,
    anchor_excess: f32,
    camera_in_unit_sphere: vec3f,
    // Semi-axes over the equatorial radius.
    axis_ratios: vec3f,
    // Reversed depth, the same for all of it: just before the body's near side.
    depth: f32,
    // Towards the Sun's centre and two directions across; body axes, unit vectors. w of the first: cotangent of the Sun's angular radius.
    sun_direction: vec4f,
    sun_across: array<vec4f, 2>,
    // Radiance of the Sun's disc: factors of 1, mu, mu^2 per channel.
    sun_limb: array<vec4f, 3>,
    // Edges of layers, upward: height over the limb (x, equatorial radii) and how far the Sun moves that is seen there (y, solar radii).
    air_edges: array<vec4f, 33>,
    // What each layer lets through: its mean, then its change from the lower edge to the upper.
    air_passes: array<vec4f, 64>,
    // 1: takes away the Sun that was drawn unbent; 0: adds the bent one.
    hides: f32,
}

@group(0) @binding(0) var<uniform> draw: Draw;

struct Varyings {
    @builtin(position) position: vec4f,
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

// A pixel as the limb's neighbourhood sees it. Heights in equatorial radii, the Sun's offsets in its radii.
struct Grazing {
    // Height of the pixel's middle over the limb.
    height: f32,
    // Half the changes of height along the pixel's two sides, the greater first.
    wide: f32,
    narrow: f32,
    // The unbent ray from the Sun's centre, and the way outward from the limb and along it, across the direction to the Sun.
    place: vec2f,
    outward: vec2f,
    // How far the ray's place moves with height, and from one side of the pixel to the other along the limb.
    per_height: f32,
    sideways: vec2f,
    // How far `outward` turns on that way.
    turn: vec2f,
    ahead: bool,
}

fn across_sun(v: vec3f) -> vec2f {
    return vec2f(dot(v, draw.sun_across[0].xyz), dot(v, draw.sun_across[1].xyz));
}

fn grazing(in: Varyings) -> Grazing {
    let along = normalize(in.ray);
    let b = dot(in.anchor, along);
    let closest = in.anchor - b * along;
    let near = draw.anchor_is_camera > 0.5;
    let q = max(length(closest), 1.0e-6);
    let excess = select(dot(closest, closest) - 1.0, draw.anchor_excess - b * b, near);
    let along_per_ray = b / length(in.ray);
    let change_x = abs(dot(closest, dpdx(in.anchor) - along_per_ray * dpdx(in.ray))) / q;
    let change_y = abs(dot(closest, dpdy(in.anchor) - along_per_ray * dpdy(in.ray))) / q;
    // The axes restored.
    let true_along = along * draw.axis_ratios;
    let stretch = length(true_along);
    let gradient = closest / draw.axis_ratios;
    let steepness = length(gradient);
    let outward = gradient / steepness;
    let direction = true_along / stretch;
    let sideways = cross(direction, outward);
    let cot = draw.sun_direction.w;
    var g: Grazing;
    g.height = excess / (1.0 + q);
    g.wide = max(0.5 * max(change_x, change_y), 1.0e-12);
    g.narrow = max(0.5 * min(change_x, change_y), 0.02 * g.wide);
    g.place = cot * across_sun(direction);
    g.outward = across_sun(outward);
    let distance = -dot(draw.camera_in_unit_sphere, along) * stretch;
    g.per_height = cot * q / (steepness * max(distance, 1.0e-9));
    let pixel = length(vec2f(change_x, change_y));
    g.sideways = across_sun(sideways) * (pixel * g.per_height);
    g.turn = across_sun(sideways) * pixel;
    g.ahead = dot(direction, draw.sun_direction.xyz) > 0.0 && distance > 0.0;
    return g;
}

// Part of the pixel that lies lower than its middle and this much: the integral of a square's width across the limb.
fn part_below(g: Grazing, height: f32) -> f32 {
    let y = min(abs(height), g.wide + g.narrow);
    let from_end = g.wide + g.narrow - y;
    let part = select(0.5 - from_end * from_end / (8.0 * g.wide * g.narrow), 0.5 * y / g.wide, y <= g.wide - g.narrow);
    return 0.5 + select(-part, part, height > 0.0);
}

// What was drawn of the Sun unbent, and two pixels more for its soft edge, below the top of the air.
fn unbent_sun(g: Grazing) -> f32 {
    let margin = 4.0 * (g.wide + g.narrow) * g.per_height;
    return select(0.0, part_below(g, draw.air_edges[LAYERS].x - g.height), g.ahead && length(g.place) < 1.0 + margin);
}

// Light of the layers along one direction across the limb.
fn bent_along(g: Grazing, place: vec2f, outward: vec2f) -> vec3f {
    // The Sun's chord on that line: counted outward from its middle, `half`; the unbent ray is at `start`.
    let stretch = max(dot(outward, outward), 1.0e-12);
    let start = dot(place, outward) / stretch;
    let beside = place - start * outward;
    let half_sq = (1.0 - dot(beside, beside)) / stretch;
    var light = vec3f(0.0);
    if half_sq > 0.0 {
        let half = sqrt(half_sq);
        let reach = g.wide + g.narrow;
        var below = draw.air_edges[0].xy;
        for (var k = 0; k < LAYERS; k++) {
            let above = draw.air_edges[k + 1].xy;
            let thickness = above.x - below.x;
            // Places of the bent ray at the layer's edges.
            let low = start + g.per_height * (below.x - g.height) - below.y;
            let high = start + g.per_height * (above.x - g.height) - above.y;
            let per_layer = 1.0 / max(high - low, 1.0e-9);
            // Parts of the layer between which it shows the Sun, and those that are in the pixel.
            let from_part = max(clamp((-half - low) * per_layer, 0.0, 1.0), (g.height - reach - below.x) / thickness);
            let to_part = min(clamp((half - low) * per_layer, 0.0, 1.0), (g.height + reach - below.x) / thickness);
            if to_part > from_part {
                let from_height = below.x + from_part * thickness - g.height;
                let to_height = below.x + to_part * thickness - g.height;
                let of_pixel = part_below(g, to_height) - part_below(g, from_height);
                let middle = 0.5 * (from_part + to_part);
                // Gauss and Legendre's two places.
                let aside = 0.28867513 * (to_part - from_part);
                for (var node = 0; node < 2; node++) {
                    let part = select(middle - aside, middle + aside, node == 1);
                    let chord = mix(low, high, part);
                    let mu_sq = clamp((half - chord) * (half + chord) * stretch, 0.0, 1.0);
                    let radiance = draw.sun_limb[0].xyz + sqrt(mu_sq) * draw.sun_limb[1].xyz + mu_sq * draw.sun_limb[2].xyz;
                    let passes = draw.air_passes[2 * k].xyz + (part - 0.5) * draw.air_passes[2 * k + 1].xyz;
                    light += (0.5 * of_pixel) * radiance * passes;
                }
            }
            below = above;
        }
    }
    return light;
}

fn bent_sun(g: Grazing) -> vec3f {
    var light = vec3f(0.0);
    let reach = g.wide + g.narrow;
    let meets = g.height + reach > draw.air_edges[0].x && g.height - reach < draw.air_edges[LAYERS].x;
    if g.ahead && meets {
        for (var k = 0; k < DIRECTIONS; k++) {
            let aside = (f32(k) + 0.5) / f32(DIRECTIONS) - 0.5;
            light += bent_along(g, g.place + aside * g.sideways, g.outward + aside * g.turn);
        }
    }
    return light / f32(DIRECTIONS);
}

@fragment
fn fragment_main(in: Varyings) -> OwnDepth {
    let g = grazing(in);
    var colour = vec4f(0.0);
    if draw.hides > 0.5 {
        colour.a = unbent_sun(g);
    } else {
        colour = vec4f(bent_sun(g), 0.0);
    }
    return OwnDepth(colour, draw.depth);
}
