// What a body leaves of the Sun's light on its ring.
//
// Question: a.xyz = the point; body axes, equatorial radii. The Sun and the body's figure come with the uniforms. Answer: the part that
// passes, per channel.

//: use lib/lane.wgsl
//: use lib/ring/body_shadow.wgsl

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    return vec4f(body_light(question(in).a.xyz), 1.0);
}
