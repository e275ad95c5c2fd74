// A star's disc, dimmer towards the limb where the line of sight ends in higher, cooler layers.

// Radiance over that of the disc's centre: I(mu)/I(1) = 1 - u1 (1 - mu) - u2 (1 - mu)^2 per channel (quadratic law, Kopal 1950).
// A fit with two numbers: the coefficients and how well they fit stand with the body in the catalog.
fn limb_darkening(mu: f32, u1: vec3f, u2: vec3f) -> vec3f {
    let s = 1.0 - mu;
    return max(1.0 - s * (u1 + s * u2), vec3f(0.0));
}
