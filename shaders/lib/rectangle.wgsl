// Two triangles from six vertex numbers, no buffer. Both wind counter-clockwise on the screen when y of the corner goes down.

// Corner of vertex 0..5: x to the right, y down, each 0 or 1.
fn rectangle_corner(index: u32) -> vec2f {
    // 0 1 2, 3 2 1.
    let corner = select(6u - index, index, index < 3u);
    return vec2f(f32(corner >> 1u), f32(corner & 1u));
}
