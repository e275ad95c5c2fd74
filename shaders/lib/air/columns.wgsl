// Air in spherical shells: what a body's air is, and how much of it lies between a point and the Sun.
//
// Unit-sphere frame of the ground, lengths in equatorial radii. Heights come as the excess |p|^2 - 1, which keeps its digits a metre above
// the ground; h = excess / (1 + sqrt(1 + excess)).

struct Air {
    // Excess at the top, above which there is nothing.
    top: f32,
    // Scale height of the gas; scattering and extinction per radius at the ground.
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
    // Excess at the foot, the middle and the top of a layer that only absorbs; its density is a tent, linear in the excess.
    layer: vec3f,
    layer_extinction: vec3f,
//: end
}

fn height_of(excess: f32) -> f32 {
    return excess / (1.0 + sqrt(1.0 + excess));
}

// What a height has, of each species; src/scene/air_nodes.rs fills the rows of heights that are the same for all pixels.
struct AirNode {
    // Excess; density of the gas, in the rows times the step of the quadrature and |p|; haze per gas; 1 / |p|.
    a: vec4f,
    // Gas, then haze: ERFCX_SLOPE sqrt(x / 2) / |p| and density times H sqrt(pi x / 2), for x = |p| / H.
    b: vec4f,
    // The absorbing layer: excess of its foot, middle and top over this height; in the rows, excess of the middle between this node and the next.
    c: vec4f,
}

// Of the argument of erfcx_of; src/scene/air_nodes.rs has the same.
const ERFCX_SLOPE = 0.46;

fn node_at(air: Air, excess: f32) -> AirNode {
    var node: AirNode;
    let per_radius = inverseSqrt(1.0 + excess);
    let height = height_of(excess);
    let radius = (1.0 + excess) * per_radius;
    let density = exp(-height / air.gas_height);
    let root = sqrt(0.5 * radius / air.gas_height);
    node.a = vec4f(excess, density, 0.0, per_radius);
    node.b = vec4f(ERFCX_SLOPE * root * per_radius, density * (air.gas_height * 1.7724539) * root, 0.0, 0.0);
//: if air.mie
    let haze_per_gas = exp(height * (1.0 / air.gas_height - 1.0 / air.haze_height));
    let haze_root = sqrt(0.5 * radius / air.haze_height);
    node.a.z = haze_per_gas;
    node.b.z = ERFCX_SLOPE * haze_root * per_radius;
    node.b.w = density * haze_per_gas * (air.haze_height * 1.7724539) * haze_root;
//: end
//: if air.absorption
    node.c = vec4f(air.layer - excess, 0.0);
//: end
    return node;
}

// Chapman's grazing incidence function: the column of an exponential air outwards from |p|, along a line that rises there by `rise` = |p| cos of its
// angle from the zenith, over the column sqrt(pi x / 2) H of a line that grazes, x = |p| / H. It is erfcx(z) (1 + g(z) / x + O(1 / x^2)), where
// z = sqrt(x / 2) cos and g goes from 3 / 8 to 1; both are polynomials in t = 1 / (1 + ERFCX_SLOPE z), fitted over all z (erfcx within 1.6e-5 of it, g
// within 8e-4). Against quadrature: 2e-5 for x above 130, 1.1e-4 for Titan's haze (x = 40), 3e-4 for Pluto's (24).
fn chapman(slope: f32, end: f32, rise: f32) -> f32 {
    let t = 1.0 / (1.0 + slope * rise);
    let erfcx = (((((-0.12700092 * t + 0.24332373) * t + 0.12417976) * t + 0.24097663) * t + 0.25897046) * t + 0.25953417) * t;
    let bend = (((1.1991911 * t - 2.0924342) * t + 0.32620976) * t - 0.05932309) * t + 1.0013116;
    return erfcx * (1.0 + end * bend);
}

//: if air.absorption
// Column of the tent outwards, in closed form: over a piece from a to b with distances s from the line's point nearest the centre, a density that is linear
// in s^2 gives (s_b^2 - s_a^2) (d_a (2 s_b + s_a) + d_b (s_b + 2 s_a)) / (3 (s_a + s_b)^2), without a difference of near numbers.
// `knots`: excesses of foot, middle and top over the place.
fn layer_out(layer: vec3f, knots: vec3f, rise: f32) -> f32 {
    // The least keeps a line that grazes the top from 0 / 0.
    let above = max(knots, vec3f(1.0e-18));
    let s = sqrt(above + rise * rise);
    // Density where the first piece begins, and in the middle, or here if that is higher.
    let first = max(-knots.x, 0.0) / (layer.y - layer.x);
    let second = min(above.z / (layer.z - layer.y), 1.0);
    let below = s.x + s.y;
    let beyond = s.y + s.z;
    let lower = (above.y - above.x) * (first * (s.y + below) + second * (s.x + below));
    let upper = (above.z - above.y) * second * (s.z + beyond);
    let below_sq = below * below;
    let beyond_sq = beyond * beyond;
    return 0.33333333 * (lower * beyond_sq + upper * below_sq) / (below_sq * beyond_sq);
}
//: end

// Columns of gas, haze and layer outwards from a node, the way there rising, in units of the density at the ground (the layer's in its middle) times the
// radius. `rise`: dot(p, direction), of either sign, as if it rose.
fn columns_from(air: Air, node: AirNode, rise: f32) -> vec3f {
    let risen = abs(rise);
    var columns = vec3f(0.0);
    columns.x = node.b.y * chapman(node.b.x, air.gas_height * node.a.w, risen);
//: if air.mie
    columns.y = node.b.w * chapman(node.b.z, air.haze_height * node.a.w, risen);
//: end
//: if air.absorption
    columns.z = layer_out(air.layer, node.c.xyz, risen);
//: end
    return columns;
}

// Along a whole line that grazes this height, in and out.
fn columns_through(air: Air, excess: f32) -> vec3f {
    return 2.0 * columns_from(air, node_at(air, excess), 0.0);
}

// Towards the Sun; below the horizon the way down and up again through the tangent point is counted. Under the ground the planet itself shades; the
// caller knows.
fn columns_towards(air: Air, node: AirNode, rise: f32) -> vec3f {
    let out = columns_from(air, node, rise);
    if rise >= 0.0 {
        return out;
    }
    return max(columns_through(air, max(node.a.x - rise * rise, 0.0)) - out, vec3f(0.0));
}

// Optical depth of columns.
fn depth_of(air: Air, columns: vec3f) -> vec3f {
    var depth = columns.x * air.gas_extinction;
//: if air.mie
    depth += columns.y * air.haze_extinction;
//: end
//: if air.absorption
    depth += columns.z * air.layer_extinction;
//: end
    return depth;
}
