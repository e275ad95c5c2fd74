// What a ring leaves of the Sun's light.
//
// Question: a.xyz = the point; body axes, equatorial radii. The Sun and the ring come with the uniforms. Answer: the part that passes, in
// every channel.

//: use lib/lane.wgsl
//: use lib/ring/shadow.wgsl

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    return vec4f(ring_light(question(in).a.xyz, draw.ring_blur));
}
