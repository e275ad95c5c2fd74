// A straight ramp between first and last contact. Measured against the exact overlap of even discs: up to 0.09 of the light.

//: use lib/eclipse/silhouette.wgsl

// Radius of the outline towards the Sun's centre: that of its tangent line.
fn radius_towards_sun(s: Silhouette) -> f32 {
    let distance = length(s.centre);
    let towards = select(s.axis, s.centre / distance, distance > 1.0e-6);
    let along = dot(towards, s.axis);
    return sqrt(mix(s.semi.y * s.semi.y, s.semi.x * s.semi.x, along * along));
}

// 1 when the smaller of two discs lies in the other, 0 when they part.
fn ramp(radius_a: f32, radius_b: f32, distance: f32) -> f32 {
    let outer = radius_a + radius_b;
    return clamp((outer - distance) / max(outer - abs(radius_a - radius_b), 1.0e-30), 0.0, 1.0);
}

// Part of the Sun's light.
fn ramp_hidden_by(s: Silhouette) -> f32 {
    return min(s.semi.x * s.semi.y, 1.0) * ramp(1.0, radius_towards_sun(s), length(s.centre));
}

//: if eclipse.2
// Part that two casters hide both, as a ramp between their own contacts.
fn ramp_hidden_by_both(s: Silhouette, t: Silhouette) -> f32 {
    let less = min(ramp_hidden_by(s), ramp_hidden_by(t));
    return less * ramp(s.semi.y, t.semi.y, distance(s.centre, t.centre));
}
//: end
