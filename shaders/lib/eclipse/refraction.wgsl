// Sunlight that the first caster's air bends into its shadow.
//
// The air's limb is a stack of layers. A ray that passes at some height arrives as if it came straight, but left the Sun elsewhere: each
// layer's ring on the sky shows a ring of the Sun's disc, larger or smaller by the bending, dimmed by what the layer lets through.
// Radiance is kept along a ray, so a layer's light is its own ring's area times the part of it that shows the Sun. Within a layer the
// part is the mean over its ring of the Sun's disc; the limb's darkening is that of two places of the arc: its middle, and one so near its end
// that the means of mu and of mu squared come out within 0.5 % where the arc ends at the Sun's limb. Against an integral over the limb: 2 % in red, 3 % in
// green, 14 % in blue where next to none is left (tests/atmosphere/refracted_limb.rs). The edges, bendings and transmissions come from scene.

//: use lib/draw.wgsl

// Area common to the Sun's disc and a circle around the caster's centre.
fn common_area(radius: f32, distance: f32) -> f32 {
    let d = max(distance, 1.0e-6);
    // Heights of the line through both crossings, from the Sun's centre.
    let y = clamp((1.0 + (d - radius) * (d + radius)) / (2.0 * d), -1.0, 1.0);
    let z = clamp(d - y, -radius, radius);
    let sun_half = sqrt((1.0 - y) * (1.0 + y));
    let half = sqrt(max((radius - z) * (radius + z), 0.0));
    let crossing = atan2(sun_half, y) - y * sun_half + radius * radius * atan2(half, z) - z * half;
    let smaller = min(radius, 1.0);
    return select(select(crossing, 3.14159265359 * smaller * smaller, d <= abs(1.0 - radius)), 0.0, d >= 1.0 + radius);
}

// `centre`: the caster's from the Sun's, solar radii; `depth`: its distance along the axis, equatorial radii; `scale`: solar radii per
// equatorial radius there.
fn refracted_light(centre: vec2f, depth: f32, scale: f32) -> vec3f {
    let distance = length(centre);
    var light = vec3f(0.0);
    // Outside the largest ring nothing comes through the air, and nothing behind the point bends light.
    if depth > 0.0 && distance < 1.0 + scale * draw.caster_air_edges[31].z {
        let edge = draw.caster_air_edges[0];
        var below = (edge.x - edge.y * depth) * scale;
        var area_below = sign(below) * common_area(abs(below), distance);
        for (var k = 0; k < 32; k++) {
            let edges = draw.caster_air_edges[k];
            let above = (edges.z - edges.w * depth) * scale;
            let area_above = sign(above) * common_area(abs(above), distance);
            // Rings are counted by their signed areas: a layer may send light from both sides of the axis.
            let ring = 3.14159265359 * (above * abs(above) - below * abs(below));
            let shows = clamp((area_above - area_below) / max(ring, 1.0e-9), 0.0, 1.0);
            let radius = 0.5 * abs(above + below);
            let across = vec2f(1.0, cos(0.82 * 3.14159265359 * shows));
            let mu_sq = clamp(1.0 - radius * radius - distance * distance + 2.0 * radius * distance * across, vec2f(0.0), vec2f(1.0));
            let mu_sums = 0.5 * vec2f(sqrt(mu_sq.x) + sqrt(mu_sq.y), mu_sq.x + mu_sq.y);
            let radiance = draw.eclipse_limb[0].xyz + mu_sums.x * draw.eclipse_limb[1].xyz + mu_sums.y * draw.eclipse_limb[2].xyz;
            let own_ring = 3.14159265359 * (edges.z - edges.x) * (edges.z + edges.x) * scale * scale;
            light += radiance * draw.caster_air_passes[k].xyz * (own_ring * shows);
            below = above;
            area_below = area_above;
        }
    }
    return light;
}
