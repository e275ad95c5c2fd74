// A body given by triangles: positions in the unit-sphere frame, normals in body axes. What of the Sun the shape itself hides is known at each vertex.

//: use lib/draw.wgsl

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    // Of the Sun's centre over the shape's own horizon, in radii of the Sun.
    @location(3) sun_height: f32,
//: if flags.vertexcolour
    // Linear RGB; the fourth component is not read.
    @location(4) colour: vec4f,
//: end
}

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) sun_height: f32,
//: if flags.vertexcolour
    @location(4) colour: vec3f,
//: end
//: if flags.twosided
    @builtin(front_facing) front: bool,
//: end
}

struct MeshVertex {
    @builtin(position) position: vec4f,
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) sun_height: f32,
//: if flags.vertexcolour
    @location(4) colour: vec3f,
//: end
}

@vertex
fn vertex_main(vertex: Vertex) -> MeshVertex {
    var out: MeshVertex;
    out.position = draw.clip_from_unit_sphere * vec4f(vertex.position - draw.mesh_anchor, 1.0);
    out.place = vertex.position;
    out.normal = vertex.normal;
    out.uv = vertex.uv;
    out.sun_height = vertex.sun_height;
//: if flags.vertexcolour
    out.colour = vertex.colour.rgb;
//: end
    return out;
}

struct Seen {
    // Unit-sphere frame.
    position: vec3f,
    // Outward (towards the viewer on a two-sided surface), body axes.
    normal: vec3f,
    // Unit vector, body axes.
    towards_camera: vec3f,
    // Cosine between the two, not below 0.
    cos_emission: f32,
    // Edges are left to multisampling.
    coverage: f32,
    // Part of the Sun's light that the shape itself lets through.
    sunlit: f32,
}

fn seen_surface(in: Varyings) -> Seen {
    var seen: Seen;
    seen.position = in.place;
    // A zero normal of a broken mesh must not turn into NaN.
    seen.normal = in.normal * inverseSqrt(max(dot(in.normal, in.normal), 1.0e-20));
//: if flags.twosided
    seen.normal = select(-seen.normal, seen.normal, in.front);
//: end
    let back = (draw.camera_in_unit_sphere - in.place) * draw.axis_ratios;
    seen.towards_camera = back * inverseSqrt(max(dot(back, back), 1.0e-20));
    seen.cos_emission = clamp(dot(seen.normal, seen.towards_camera), 0.0, 1.0);
    seen.coverage = 1.0;
//: if view.eclipse
    seen.sunlit = 1.0;
//: else
    // The part of the Sun over a straight horizon: within 0.03 for a disc darkened to its limb by 0.4 to 0.8. No sharper than a pixel.
    let blur = max(0.5 * length(vec2f(dpdx(in.sun_height), dpdy(in.sun_height))), 1.0);
    seen.sunlit = smoothstep(-1.0, 1.0, in.sun_height / blur);
//: end
    return seen;
}
