// Sunlight scattered into one ray, and the transmittance of its way.
//
// Question: a = the ray's point nearest the centre, its excess |p|^2 - 1; b = unit direction, distance of the camera along it from that point;
// c = unit direction towards the Sun, the camera's excess.
// Rows: radiance per unit solar irradiance with, last, 1 where the ray ends on the ground; transmittance.

//: use lib/lane.wgsl
//: use lib/air/along.wgsl
//: use lib/air/of_draw.wgsl

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    let q = question(in);
    let hits = q.a.w < 0.0 && q.b.w < 0.0;
    let path = air_path(q.a.xyz, q.b.xyz, q.a.w, q.b.w, q.c.w, true, hits, draw.air_top);
    let from_node = hits || (q.b.w >= 0.0 && q.c.w < draw.air_top);
    let light = air_along(air_of_draw(), path, q.c.xyz, vec2f(1.0), dot(q.b.xyz, q.c.xyz), from_node);
    if q.row == 0 {
        return vec4f(light.scattered * 0.31830989, select(0.0, 1.0, hits));
    }
    return vec4f(exp(-light.depth), 0.0);
}
