// The outline of a caster on the sky, in units of the Sun's radius around the Sun's centre.

struct Silhouette {
    // Its centre from the Sun's.
    centre: vec2f,
    // Unit vector along the long axis.
    axis: vec2f,
    // Long and short semi-axis. 0: it stands behind the point that is lit.
    semi: vec2f,
}

// Whether it can hide any of the Sun.
fn near_sun(s: Silhouette) -> bool {
    let reach = 1.0 + s.semi.x;
    return dot(s.centre, s.centre) < reach * reach;
}

// The circle that follows the outline where it is nearest to the Sun's centre: its radius, and the distance of its centre.
//
// The centre of curvature moves on the ellipse's evolute; each round goes to the point of the outline whose normal leads there. Its error
// is of the third order in (solar radius / semi-axis): measured 4.1e-4 of the light at a short semi-axis of 1.8, 7e-6 at 7.4.
fn circle_at_limb(s: Silhouette) -> vec2f {
    let a = s.semi.x;
    let b = s.semi.y;
    let sun = vec2f(abs(dot(s.centre, s.axis)), abs(s.centre.y * s.axis.x - s.centre.x * s.axis.y));
    var t = normalize(max(sun / s.semi, vec2f(1.0e-9)));
    let focal = vec2f(a * a - b * b, b * b - a * a) / s.semi;
    for (var round = 0; round < 2; round++) {
        let evolute = focal * t * t * t;
        let radius = length(s.semi * t - evolute);
        let to_sun = sun - evolute;
        let along = to_sun * (radius / max(length(to_sun), 1.0e-9));
        t = normalize(max((along + evolute) / s.semi, vec2f(1.0e-9)));
    }
    let evolute = focal * t * t * t;
    return vec2f(length(s.semi * t - evolute), length(sun - evolute));
}
