// What one caster hides of the Sun's disc, and what it leaves.

//: use lib/eclipse/silhouette.wgsl
//: use lib/eclipse/circle.wgsl
//: use lib/eclipse/chords.wgsl

// Whether the Sun's disc lies inside the outline.
fn hides_all(s: Silhouette) -> bool {
    let limb = circle_at_limb(s);
    return s.semi.y >= 1.0 && (1.0 - limb.x) + limb.y <= 0.0;
}

fn overlap_of(s: Silhouette) -> Overlap {
    // Rounder than a thousandth, or so large that its limb is a circle where it crosses the Sun (1e-4 of the light at 3 solar radii).
    let round = s.semi.y > 0.999 * s.semi.x || s.semi.y > 3.0;
    let circle = circle_at_limb(s);
    let over_centre = round && circle.x >= 1.0 && circle.y < circle.x;
    var o: Overlap;
    if over_centre {
        o.left = left_by_circle(circle.x, circle.y);
        o.hidden = WHOLE_SUN - o.left;
    } else {
        if round {
            o.hidden = hidden_by_circle(circle.x, circle.y);
        } else {
            o.hidden = select(hidden_by_ellipse(s), WHOLE_SUN, hides_all(s));
        }
        o.left = max(WHOLE_SUN - o.hidden, vec3f(0.0));
    }
    return o;
}

// Both casters, apart from each other: what the one hides is taken from what the other leaves.
fn both_apart(a: Overlap, b: Overlap) -> Overlap {
    let less = b.left.x < a.left.x;
    let left = select(a.left - b.hidden, b.left - a.hidden, less);
    return Overlap(min(a.hidden + b.hidden, WHOLE_SUN), max(left, vec3f(0.0)));
}

// Part of the light that is left, from the light of what is hidden or left (whichever is less keeps more digits) and of the whole disc.
fn part_left(o: Overlap, hidden: vec3f, left: vec3f, whole: vec3f) -> vec3f {
    return clamp(select(1.0 - hidden / whole, left / whole, o.left.x < o.hidden.x), vec3f(0.0), vec3f(1.0));
}
