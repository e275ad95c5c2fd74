// Part of the Sun's light that reaches a point past all that can stand before the Sun.

//: if eclipse.1
//: use lib/eclipse/casters.wgsl
//: end
//: if ring-shadow.point-sun|ring-shadow.penumbra
//: use lib/ring/shadow.wgsl
//: end
//: if body-shadow.sphere|body-shadow.ellipsoid-penumbra
//: use lib/ring/body_shadow.wgsl
//: end

//: if ring-shadow.point-sun|ring-shadow.penumbra
// Per channel. `position`: body axes, equatorial radii; on the ground, in the air or on a ring. `blur`: half the stretch of the ring's radius
// whose shadow is seen as one.
fn sunlight_over(position: vec3f, blur: f32) -> vec3f {
    var part = vec3f(ring_light(position, blur));
//: else
// Per channel. `position`: body axes, equatorial radii; on the ground, in the air or on a ring.
fn sunlight_reaching(position: vec3f) -> vec3f {
    var part = vec3f(1.0);
//: end
//: if eclipse.1
    part *= eclipse_light(position);
//: end
//: if body-shadow.sphere|body-shadow.ellipsoid-penumbra
    part *= body_light(position);
//: end
    return part;
}

//: if ring-shadow.point-sun|ring-shadow.penumbra
// As a pixel that faces the viewer at the body's distance sees it.
fn sunlight_reaching(position: vec3f) -> vec3f {
    return sunlight_over(position, draw.ring_blur);
}
//: end
