// What one caster hides of the Sun's disc.

//: use lib/eclipse/silhouette.wgsl
//: use lib/eclipse/circle.wgsl
//: use lib/eclipse/chords.wgsl

// Integrals of 1, mu, mu^2 over the hidden part.
fn hidden_by(s: Silhouette) -> vec3f {
    // Rounder than a thousandth, or so large that its limb is a circle where it crosses the Sun (1e-4 of the light at 3 solar radii).
    let round = s.semi.y > 0.999 * s.semi.x || s.semi.y > 3.0;
    var hidden = vec3f(0.0);
    if round {
        let circle = circle_at_limb(s);
        hidden = hidden_by_circle(circle.x, circle.y);
    }
    if !round {
        hidden = hidden_by_ellipse(s);
    }
    return hidden;
}
