// Normal maps: the red channel tilts the surface to the east, the green to the north, blue is up; 0.5 is no tilt.
//
// The frame comes from the geometry at each pixel, not from stored tangents, so it has no seam.

//: use lib/map_place.wgsl

struct TangentFrame {
    east: vec3f,
    north: vec3f,
}

// East is the derivative of the ellipsoid's point by longitude, which lies in the surface whatever the three axes are.
fn tangent_frame_of_ellipsoid(position: vec3f, axis_ratios: vec3f, normal: vec3f) -> TangentFrame {
    let by_longitude = vec3f(-position.y * axis_ratios.x, position.x * axis_ratios.y, 0.0);
    let length_sq = dot(by_longitude, by_longitude);
    // East has no direction at a pole; any tangent does.
    let at_pole = length_sq < 1.0e-12;
    let east = select(by_longitude * inverseSqrt(max(length_sq, 1.0e-12)), vec3f(0.0, 1.0, 0.0), at_pole);
    return TangentFrame(east, cross(normal, east));
}

// From how position and map place change across the triangle (cotangent frame, C. Schueler, "Normal Mapping without
// Precomputed Tangents", ShaderX 5, 2006). Longitudes grow with u, latitudes against v.
fn tangent_frame_of_triangle(position: vec3f, place: MapPlace, normal: vec3f) -> TangentFrame {
    let across = cross(dpdy(position), normal);
    let along = cross(normal, dpdx(position));
    let east = across * place.dx.x + along * place.dy.x;
    let south = across * place.dx.y + along * place.dy.y;
    let scale = inverseSqrt(max(max(dot(east, east), dot(south, south)), 1.0e-30));
    return TangentFrame(east * scale, -south * scale);
}

// Unit normal tilted by a texel; `strength` multiplies the slope.
fn tilted_normal(frame: TangentFrame, texel: vec3f, strength: f32, normal: vec3f) -> vec3f {
    let slope = texel * 2.0 - 1.0;
    let tilted = strength * (slope.x * frame.east + slope.y * frame.north) + max(slope.z, 0.05) * normal;
    return normalize(tilted);
}

// A slope that leans away from the viewer hides behind another: it is turned until the viewer sees it at half the cosine of the smooth
// ground. Otherwise single pixels near the limb would be black.
fn seen_normal(tilted: vec3f, towards_camera: vec3f, cos_smooth: f32) -> vec3f {
    let lacking = max(0.5 * cos_smooth - dot(tilted, towards_camera), 0.0);
    return normalize(tilted + lacking * towards_camera);
}
