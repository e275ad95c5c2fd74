// The part of the Sun's light that one disc or ellipse takes.
//
// Question: a = (semi-axes, centre along and across the long axis), b = (u1, u2), lengths in solar radii. Answer: the part blocked, in
// every channel.

//: use lib/lane.wgsl
//: if eclipse.linear
//: use lib/eclipse/linear.wgsl
//: else
//: use lib/eclipse/overlap.wgsl
//: end

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    let q = question(in);
    let s = Silhouette(q.a.zw, vec2f(1.0, 0.0), q.a.xy);
    var blocked = 0.0;
    if near_sun(s) {
//: if eclipse.linear
        blocked = ramp_hidden_by(s);
//: else
        let o = overlap_of(s);
        let law = vec3f(1.0 - q.b.x - q.b.y, q.b.x + 2.0 * q.b.y, -q.b.y);
        let left = part_left(o, vec3f(dot(law, o.hidden)), vec3f(dot(law, o.left)), vec3f(dot(law, WHOLE_SUN)));
        blocked = 1.0 - left.x;
//: end
    }
    return vec4f(blocked);
}
