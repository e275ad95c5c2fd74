// A star's disc, dimmer towards the limb where the line of sight ends in higher, cooler layers.

// Radiance over that of the disc's centre: I(mu)/I(1) = 1 - u1 (1 - mu) - u2 (1 - mu)^2 per channel (quadratic law, Kopal 1950).
// Against measured profiles of the Sun the law is off by some 1 % of the centre, more in the last hundredth of the radius.
fn limb_darkening(mu: f32, u1: vec3f, u2: vec3f) -> vec3f {
    let s = 1.0 - mu;
    return max(1.0 - s * (u1 + s * u2), vec3f(0.0));
}
