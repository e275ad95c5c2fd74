// Lamps on the night side.

// 0 by day, 1 once the Sun is 6 degrees down (the end of civil twilight), smooth between. `cos_incidence` of the Sun, of either sign.
fn lamps_lit(cos_incidence: f32) -> f32 {
    return 1.0 - smoothstep(-0.10452846, 0.0, cos_incidence);
}
