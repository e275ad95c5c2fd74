// The part of the Sun's light that reaches points of a body past all that the key knows to stand before the Sun.
//
// Question: a = the point (xyz), body axes, equatorial radii. Answer: the part, per channel. The amounts are those of the body's draw.

//: use lib/lane.wgsl
//: use lib/draw.wgsl
//: use lib/sunlight.wgsl

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    return vec4f(sunlight_reaching(question(in).a.xyz), 1.0);
}
