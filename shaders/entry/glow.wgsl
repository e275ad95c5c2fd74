// The veil of light that an eye or a lens spreads around the Sun, added to the frame.
//
// Coming in: the Sun's direction in camera axes and the strength of the veil. Going out: linear RGB radiance to be added. src/scene/glow.rs says
// where the law and its numbers come from.

//: use lib/screen.wgsl

struct Draw {
    // Unit vector to the Sun: x right, y up, z forward.
    sun_direction: vec3f,
    // Square of the least angle that counts (radians squared): within the disc the law says nothing.
    least_sq: f32,
    // Radiance times the square of the angle from the Sun.
    strength: vec3f,
    // Tangents of half the field of view, horizontal and vertical.
    tan_half_fov: vec2f,
}

@group(0) @binding(0) var<uniform> draw: Draw;

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) ray: vec3f,
}

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> Varyings {
    let corner = screen_corner(index);
    var out: Varyings;
    out.position = vec4f(corner, 0.0, 1.0);
    out.ray = vec3f(corner * draw.tan_half_fov, 1.0);
    return out;
}

@fragment
fn fragment_main(in: Varyings) -> @location(0) vec4f {
    // The chord: 1 % less than the angle at 28 degrees, and exact beside the disc where an arc cosine would not be.
    let chord = normalize(in.ray) - draw.sun_direction;
    return vec4f(draw.strength / max(dot(chord, chord), draw.least_sq), 0.0);
}
