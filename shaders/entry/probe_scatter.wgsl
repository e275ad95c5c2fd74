// Sunlight scattered into one ray, and the transmittance of its way.
//
// Question: a = the ray's point nearest the centre, its excess |p|^2 - 1; b = unit direction, distance of the camera along it from that point;
// c = unit direction towards the Sun, the camera's excess.
// Rows: radiance per unit solar irradiance with, last, 1 where the ray ends on the ground; transmittance.

//: use lib/lane.wgsl
//: use lib/air/along.wgsl

struct Asked {
    // As in Air.
    top: f32,
    gas_height: f32,
    gas_scattering: vec3f,
    gas_extinction: vec3f,
//: if air.mie
    haze_height: f32,
    haze_asymmetry: f32,
    haze_scattering: vec3f,
    haze_extinction: vec3f,
//: end
//: if air.absorption
    layer: vec3f,
    layer_extinction: vec3f,
//: end
    // Of the asked ray: rows of lib/air/columns.wgsl's AirNode, of at most 16 samples and the two ends.
    nodes: array<vec4f, 54>,
}

@group(0) @binding(0) var<uniform> asked: Asked;

fn air_node(k: u32) -> AirNode {
    return AirNode(asked.nodes[3u * k], asked.nodes[3u * k + 1u], asked.nodes[3u * k + 2u]);
}

fn air_asked() -> Air {
    var air: Air;
    air.top = asked.top;
    air.gas_height = asked.gas_height;
    air.gas_scattering = asked.gas_scattering;
    air.gas_extinction = asked.gas_extinction;
//: if air.mie
    air.haze_height = asked.haze_height;
    air.haze_asymmetry = asked.haze_asymmetry;
    air.haze_scattering = asked.haze_scattering;
    air.haze_extinction = asked.haze_extinction;
//: end
//: if air.absorption
    air.layer = asked.layer;
    air.layer_extinction = asked.layer_extinction;
//: end
    return air;
}

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    let q = question(in);
    let hits = q.a.w < 0.0 && q.b.w < 0.0;
    let path = air_path(q.a.xyz, q.b.xyz, q.a.w, q.b.w, q.c.w, true, hits, asked.top);
    let from_node = hits || (q.b.w >= 0.0 && q.c.w < asked.top);
    let light = air_along(air_asked(), path, q.c.xyz, vec2f(1.0), dot(q.b.xyz, q.c.xyz), from_node);
    if q.row == 0 {
        return vec4f(light.scattered * 0.31830989, select(0.0, 1.0, hits));
    }
    return vec4f(exp(-light.depth), 0.0);
}
