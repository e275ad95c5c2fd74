// Where a point lies in an equirectangular map: longitude 0 at the centre, east to the right, north up.

struct MapPlace {
    uv: vec2f,
    // Change of uv from this pixel to the next one right and down, for the choice of mip level.
    dx: vec2f,
    dy: vec2f,
}

// Differential of uv for a step of the direction m. By the chain rule from the geometry: differences of u itself jump by one
// at the date line, and the seam would show as a line of the smallest mip level.
fn map_step(m: vec3f, step: vec3f, equatorial_sq: f32) -> vec2f {
    // At the pole itself a step spans all longitudes; the floor keeps the quotient finite.
    let r_sq = max(equatorial_sq, 1.0e-12);
    let du = (m.x * step.y - m.y * step.x) / r_sq;
    // No angle is longer than its chord's step: over the pole itself the quotient is of two vanishing numbers.
    let longest = length(step);
    let dv = clamp(-step.z * inverseSqrt(r_sq), -longest, longest);
    return vec2f(du * 0.15915494, dv * 0.31830989);
}

// The place alone, without its change between pixels.
fn map_uv(position: vec3f, stretch: f32) -> vec2f {
    let m = normalize(position * vec3f(1.0, 1.0, stretch));
    return map_uv_of_direction(m, m.x * m.x + m.y * m.y);
}

fn map_uv_of_direction(m: vec3f, equatorial_sq: f32) -> vec2f {
    // atan2(z, r) keeps its digits at the poles, where asin(z) loses half of them.
    let east = select(m.x, 1.0, equatorial_sq == 0.0);
    return vec2f(0.5 + atan2(m.y, east) * 0.15915494, 0.5 - atan2(m.z, sqrt(equatorial_sq)) * 0.31830989);
}

// `position`: unit-sphere frame. `stretch`: factor on z that gives the direction whose latitude the map's rows count.
fn map_place(position: vec3f, stretch: f32) -> MapPlace {
    let m = normalize(position * vec3f(1.0, 1.0, stretch));
    let equatorial_sq = m.x * m.x + m.y * m.y;
    // Rows near a pole are as coarse in longitude as in latitude (src/image/poles.rs), so a footprint need not count all the texels that it crosses there: from
    // 78 degrees on it is narrower, at the pole five times as wide as high. Else each pixel there would be read from a level that mixes latitudes.
    let narrower = vec2f(min(5.0 * sqrt(equatorial_sq), 1.0), 1.0);
    let dx = map_step(m, dpdx(m), equatorial_sq) * narrower;
    let dy = map_step(m, dpdy(m), equatorial_sq) * narrower;
    return MapPlace(map_uv_of_direction(m, equatorial_sq), dx, dy);
}
