// The planet's shadow on its ring: what the planet leaves of the Sun's light at a point outside it.

//: use lib/draw.wgsl

// Per channel. `position`: body axes, equatorial radii; at least a radius from the centre.
fn body_light(position: vec3f) -> vec3f {
    let sun = draw.light_direction[0].xyz;
//: if body-shadow.sphere
    // A sphere and a point Sun; the edge is softened over a pixel.
    let away = cross(position, sun);
    let beside = length(away) - 1.0;
    let lit = clamp(0.5 + beside / max(2.0 * draw.ring_blur, 1.0e-6), 0.0, 1.0);
    return vec3f(select(lit, 1.0, dot(position, sun) > 0.0));
//: else
    // In the frame where the planet is the unit sphere: a direction d from p meets it where |d|^2 - |p x d|^2 >= 0, ahead.
    let p = position / draw.shadow_axes;
    let d = sun / draw.shadow_axes;
    if dot(p, d) >= 0.0 {
        return vec3f(1.0);
    }
    let turned = cross(p, d);
    let depth = dot(d, d) - dot(turned, turned);
    // Across the Sun's disc: e1 is where the depth grows fastest, e2 beside it.
    let slope = (d - cross(turned, p)) / draw.shadow_axes;
    let flat_slope = slope - sun * dot(slope, sun);
    let steepness = length(flat_slope);
    // The depth changes by less than this over the disc: wholly lit or wholly dark.
    let reach = draw.sun_tangent * (2.0 * steepness + draw.sun_tangent * 4.0 * (1.0 + dot(p, p)));
    if depth > reach {
        return vec3f(0.0);
    }
    if depth < -reach {
        return vec3f(1.0);
    }
    let e1 = flat_slope / max(steepness, 1.0e-12);
    let e2 = cross(sun, e1);
    let step = draw.sun_tangent * e1 / draw.shadow_axes;
    let step_turned = cross(p, step);
    let curve = dot(step, step) - dot(step_turned, step_turned);
    // What is left of each chord, and the whole of it: where no chord is cut both sums are the same, where every chord is hidden nothing is left.
    var left = vec3f(0.0);
    var whole = vec3f(0.0);
    var cut = false;
    // Sixteen chords along e1, Gauss-Chebyshev nodes of the second kind; on each the planet's edge is a root of a quadratic.
    for (var k = 1; k <= 16; k++) {
        let angle = f32(k) * 0.18479957;
        let half = sin(angle);
        let start = d + draw.sun_tangent * cos(angle) * e2 / draw.shadow_axes;
        let start_turned = cross(p, start);
        let level = dot(start, start) - dot(start_turned, start_turned);
        let rise = dot(start, step) - dot(start_turned, step_turned);
        let square = rise * rise - curve * level;
        let root = sqrt(max(square, 0.0));
        let first = -level / max(rise + root, 1.0e-20);
        // Past the second root the chord leaves the planet again; a parabola that opens upwards never does.
        let last = select(2.0, (rise + root) / max(-curve, 1.0e-20), curve < 0.0);
        let from_x = clamp(first, -half, half);
        let to_x = clamp(last, from_x, half);
        let of_chord = half * 2.0 * chord_light(half, half);
        let crosses = square > 0.0 && to_x > from_x;
        let beside = select(vec3f(0.0), chord_light(from_x, half) + chord_light(half, half), from_x > -half)
            + select(vec3f(0.0), chord_light(half, half) - chord_light(to_x, half), to_x < half);
        left += select(of_chord, half * max(beside, vec3f(0.0)), crosses);
        whole += of_chord;
        cut = cut || crosses;
    }
    return select(vec3f(1.0), clamp(left / whole, vec3f(0.0), vec3f(1.0)), cut);
//: end
}

//: if body-shadow.ellipsoid-penumbra
// Light of a chord from its middle to x, half chord h: the integral of 1 - u1 (1 - mu) - u2 (1 - mu)^2 with mu^2 = h^2 - x^2.
fn chord_light(x: f32, h: f32) -> vec3f {
    let mu = sqrt(max(h * h - x * x, 0.0));
    let of_mu = 0.5 * (x * mu + h * h * asin(clamp(x / max(h, 1.0e-9), -1.0, 1.0)));
    let of_mu_squared = x * (h * h - x * x / 3.0);
    return x * (1.0 - draw.sun_limb_u1 - draw.sun_limb_u2) + of_mu * (draw.sun_limb_u1 + 2.0 * draw.sun_limb_u2)
        - of_mu_squared * draw.sun_limb_u2;
}
//: end
