// The ring's shadow: what it leaves of the Sun's light at a point off its plane.

//: use lib/ring/profile.wgsl

// Through the ring towards one direction (unit vector, body axes); `blur`: half the stretch of radius that is averaged.
fn ring_passes(position: vec3f, towards: vec3f, blur: f32) -> f32 {
    // A point in the plane itself sees past it.
    let ahead = -position.z * sign(towards.z);
    if ahead <= 0.0 {
        return 1.0;
    }
    let steep = max(abs(towards.z), LEAST_COSINE);
    let met = position.xy + towards.xy * (ahead / steep);
    let radius = length(met);
    if radius - blur > draw.ring_reach.y || radius + blur < draw.ring_reach.x {
        return 1.0;
    }
    return clamp(1.0 - ring_opacity(ring_stretch(max(radius - blur, 0.0), radius + blur), 1.0 / steep).w, 0.0, 1.0);
}

// Half the stretch of the ring's radius whose shadow a pixel of the ground sees: it takes differences between neighbouring pixels.
fn shadow_blur(position: vec3f) -> f32 {
    let sun = draw.light_direction[0].xyz;
    let steep = select(min(sun.z, -LEAST_COSINE), max(sun.z, LEAST_COSINE), sun.z >= 0.0);
    let radius = length(position.xy - sun.xy * (position.z / steep));
    return min(0.5 * length(vec2f(dpdx(radius), dpdy(radius))), 1.0e3);
}

// `position`: body axes, equatorial radii; `blur`: half the stretch of the ring's radius that a pixel sees the shadow of.
fn ring_light(position: vec3f, blur: f32) -> f32 {
    let sun = draw.light_direction[0].xyz;
//: if ring-shadow.penumbra
    // Seven strips of the Sun's disc along its height over the ring's plane, by Gauss-Chebyshev nodes of the second kind: weights are
    // the chords of an evenly bright disc. Each strip is as wide in radius as the disc there and as the pixel.
    let level = vec3f(sun.xy, 0.0);
    let up = normalize(vec3f(0.0, 0.0, 1.0) - sun * sun.z + vec3f(sun.xy, 0.0) * 1.0e-6);
    // What is taken is summed: where the ring takes nothing all of the light is left, to the last digit.
    var taken = 0.0;
    for (var k = 1; k <= 7; k++) {
        let angle = f32(k) * 0.39269908;
        let height = cos(angle);
        let chord = sin(angle);
        let towards = normalize(sun + up * (height * draw.sun_tangent));
        let steep = max(abs(towards.z), LEAST_COSINE);
        let path = abs(position.z) / steep;
        // Half a strip's height moves the crossing along the plane by path / sine; half its chord moves it across.
        let met = position.xy + towards.xy * path;
        let outwards = met * inverseSqrt(max(dot(met, met), 1.0e-12));
        let along = normalize(level.xy + vec2f(1.0e-12, 0.0));
        let radial = abs(dot(outwards, along));
        let across = sqrt(max(1.0 - radial * radial, 0.0));
        let spread = path * draw.sun_tangent * (0.2 * radial / steep + 0.5 * chord * across);
        taken += chord * chord * 0.25 * (1.0 - ring_passes(position, towards, blur + min(spread, 1.0)));
    }
    return max(1.0 - taken, 0.0);
//: else
    return ring_passes(position, sun, blur);
//: end
}
