// The part of the Sun's light that one disc takes.
//
// Question: a = (caster's radius, distance of the centres, u1, u2), lengths in solar radii. Answer: the part blocked, in every channel.

//: use lib/lane.wgsl

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    let q = question(in);
    let radius = q.a.x;
    let distance = q.a.y;
    var blocked = 0.0;
//: if eclipse.linear
    // From first contact to the greatest overlap in a straight line.
    let most = min(radius * radius, 1.0);
    blocked = most * clamp((1.0 + radius - distance) / max(1.0 + radius - abs(1.0 - radius), 1.0e-30), 0.0, 1.0);
//: end
    return vec4f(blocked);
}
