// The part of a view ray that lies in a shell of air, and where on it the planet hides the Sun.
//
// Unit-sphere frame of the ground, distances along the ray from its point nearest the centre.

// The part of a view ray that lies in the air. Distances count from the ray's point nearest the centre, away from the camera.
struct AirPath {
    // That point, the unit direction, the excess |p|^2 - 1 there.
    nearest: vec3f,
    along: vec3f,
    low: f32,
    // Distance and excess at the start and the end; nothing where the end comes first.
    from_s: f32,
    from_excess: f32,
    to_s: f32,
    to_excess: f32,
}

// `camera`: distance of the camera along the ray; `near`: it may stand in the air.
fn air_path(nearest: vec3f, along: vec3f, low: f32, camera: f32, camera_excess: f32, near: bool, hits: bool, top: f32) -> AirPath {
    var path: AirPath;
    path.nearest = nearest;
    path.along = along;
    path.low = low;
    let edge = sqrt(max(top - low, 0.0));
    path.from_s = select(-edge, max(camera, -edge), near);
    path.from_excess = select(top, min(camera_excess, top), near);
    path.to_s = select(edge, -sqrt(max(-low, 0.0)), hits);
    path.to_excess = select(top, 0.0, hits);
    return path;
}

// Distances between which the ray is in the planet's shadow, the cylinder behind the terminator's plane: |p|^2 - (p.sun)^2 < 1.
fn planet_shadow(path: AirPath, towards_sun: vec3f, sun_along: f32, sun_nearest: f32) -> vec2f {
    let across = towards_sun - sun_along * path.along;
    let a = max(dot(across, across), 1.0e-12);
    let half_b = -sun_nearest * sun_along;
    let disc = half_b * half_b - a * (path.low - sun_nearest * sun_nearest);
    if disc <= 0.0 {
        return vec2f(0.0);
    }
    let root = sqrt(disc);
    let shadow = vec2f(-half_b - root, -half_b + root) / a;
    let terminator = -sun_nearest / select(sun_along, 1.0e-7, abs(sun_along) < 1.0e-7);
    return select(vec2f(max(shadow.x, terminator), shadow.y), vec2f(shadow.x, min(shadow.y, terminator)), sun_along >= 0.0);
}
