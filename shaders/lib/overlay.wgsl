// Images laid over the ground's colour. Their texels are premultiplied by alpha in linear light, so that filtering carries no colour from
// where they are clear.
//
// Rows of one overlay in `draw.overlay`:
//   0..2 axes of its frame (xyz): towards its middle meridian, east of it and the pole, or east, north and up at its middle;
//        w: stretch of z to planetographic latitude, ratio of the second axis, ratio of the third
//   3    image widths and heights per radian (or per radius); middle latitude (or the middle's place along north); 1: orthographic
//   4    u from and to, v from and to, where the image ends
//   5    factor on its colour, opacity

//: use lib/draw.wgsl
//: use lib/filtered.wgsl
//: use lib/map_place.wgsl

@group(0) @binding(9) var overlay_map: texture_2d<f32>;
@group(0) @binding(11) var overlay_sampler: sampler;
//: if overlays.2
@group(0) @binding(10) var overlay_map_2: texture_2d<f32>;
@group(0) @binding(12) var overlay_sampler_2: sampler;
//: end

struct OverlayPlace {
    place: MapPlace,
    // Part of the pixel that lies within the image.
    part: f32,
}

// Takes differences between neighbouring pixels. `position`: unit-sphere frame; `row`: the overlay's first.
fn overlay_place(position: vec3f, row: u32) -> OverlayPlace {
    let kind = draw.overlay[row + 3u];
    let orthographic = kind.w > 0.5;
    let normal = normalize(position * vec3f(1.0, 1.0, draw.overlay[row].w));
    let ground = position * vec3f(1.0, draw.overlay[row + 1u].w, draw.overlay[row + 2u].w);
    let source = select(normal, ground, orthographic);
    let m = vec3f(dot(source, draw.overlay[row].xyz), dot(source, draw.overlay[row + 1u].xyz), dot(source, draw.overlay[row + 2u].xyz));
    let dx = dpdx(m);
    let dy = dpdy(m);

    let equatorial_sq = m.x * m.x + m.y * m.y;
    // map_uv_of_direction and map_step count turns and half turns from the map's corner.
    let turns = map_uv_of_direction(m, equatorial_sq) - 0.5;
    let angles = vec2f(turns.x * 6.2831853, turns.y * 3.1415927 + kind.z);
    let unroll = kind.xy * vec2f(6.2831853, 3.1415927);
    let flat = vec2f(m.x, kind.z - m.y);
    let per_radius = kind.xy * vec2f(1.0, -1.0);

    var seen: OverlayPlace;
    seen.place.uv = 0.5 + kind.xy * select(angles, flat, orthographic);
    seen.place.dx = select(map_step(m, dx, equatorial_sq) * unroll, dx.xy * per_radius, orthographic);
    seen.place.dy = select(map_step(m, dy, equatorial_sq) * unroll, dy.xy * per_radius, orthographic);
    let limits = draw.overlay[row + 4u];
    let width = max(abs(seen.place.dx) + abs(seen.place.dy), vec2f(1.0e-9));
    let past_first = clamp((seen.place.uv - limits.xz) / width + 0.5, vec2f(0.0), vec2f(1.0));
    let before_last = clamp((limits.yw - seen.place.uv) / width + 0.5, vec2f(0.0), vec2f(1.0));
    let within = past_first * before_last;
    // The far side lies under the same place of an orthographic image.
    seen.part = select(within.x * within.y, 0.0, orthographic && m.z <= 0.0);
    return seen;
}

struct OverlayPlaces {
    lower: OverlayPlace,
//: if overlays.2
    upper: OverlayPlace,
//: end
}

fn overlay_places(position: vec3f) -> OverlayPlaces {
    var all: OverlayPlaces;
    all.lower = overlay_place(position, 0u);
//: if overlays.2
    all.upper = overlay_place(position, 6u);
//: end
    return all;
}

fn under(albedo: vec3f, texel: vec4f, part: f32, row: u32) -> vec3f {
    let light = draw.overlay[row + 5u];
    let opacity = part * light.w;
    return albedo * (1.0 - texel.a * opacity) + texel.rgb * light.rgb * opacity;
}

// The ground's colour with the images over it.
fn overlaid(albedo: vec3f, images: OverlayPlaces) -> vec3f {
    let lower = images.lower.place;
    let colour = under(albedo, filtered_map(overlay_map, overlay_sampler, lower.uv, lower.dx, lower.dy, draw.map_taps), images.lower.part, 0u);
//: if overlays.2
    let upper = images.upper.place;
    return under(colour, filtered_map(overlay_map_2, overlay_sampler_2, upper.uv, upper.dx, upper.dy, draw.map_taps), images.upper.part, 6u);
//: else
    return colour;
//: end
}
