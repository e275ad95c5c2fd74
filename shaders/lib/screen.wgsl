// One triangle that covers the screen, from vertex numbers 0..2.
fn screen_corner(index: u32) -> vec2f {
    return vec2f(f32((index & 2u) << 1u) - 1.0, 1.0 - f32((index & 1u) << 2u));
}
