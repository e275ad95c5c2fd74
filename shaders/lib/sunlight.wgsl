// Part of the Sun's light that reaches a point past all that can stand before the Sun.

//: if eclipse.1
//: use lib/eclipse/casters.wgsl
//: end

// Per channel. `position`: body axes, equatorial radii; on the ground, in the air or on a ring.
fn sunlight_reaching(position: vec3f) -> vec3f {
    var part = vec3f(1.0);
//: if eclipse.1
    part *= eclipse_light(position);
//: end
    return part;
}
