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

// A height that is the same for all pixels; src/scene/air_nodes.rs fills the rows.
struct AirNode {
    // Excess; gas times the step of the quadrature in height; haze per gas; 1 / |p|^2.
    a: vec4f,
    // Gas, then haze: 0.56 sqrt(x / 2) / |p| and density times H sqrt(pi x / 2), for x = |p| / H.
    b: vec4f,
    // The absorbing layer: half of its column straight up, and at which two |q|^2 - |p|^2 above the halves are thought to lie; excess of
    // the middle between this node and the next.
    c: vec4f,
}

// Chapman's function over sqrt(pi x / 2) without its end terms.
fn erfcx_of(t: f32) -> f32 {
    return ((((-0.17849263 * t + 0.31750691) * t + 0.22426937) * t + 0.32062279) * t + 0.31582697) * t;
}

// Columns of gas, haze and layer from a node outwards, the way there rising: see column_out. `rise`: of either sign, as if it rose.
fn columns_from(air: Air, node: AirNode, rise: f32) -> vec3f {
    let rise_sq = rise * rise;
    let cos_sq = rise_sq * node.a.w;
    let per_radius = sqrt(node.a.w);
    var columns = vec3f(0.0);
    let gas_end = 2.0 * air.gas_height * per_radius;
    columns.x = erfcx_of(1.0 / (1.0 + node.b.x * abs(rise))) * (node.b.y * (1.0 + 0.1875 * gas_end) + (node.b.y * 0.3125 * gas_end) * cos_sq);
//: if air.mie
    let haze_end = 2.0 * air.haze_height * per_radius;
    columns.y = erfcx_of(1.0 / (1.0 + node.b.z * abs(rise))) * (node.b.w * (1.0 + 0.1875 * haze_end) + (node.b.w * 0.3125 * haze_end) * cos_sq);
//: end
//: if air.absorption
    columns.z = node.c.x * (inverseSqrt(rise_sq + node.c.y) + inverseSqrt(rise_sq + node.c.z));
//: end
    return columns;
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

// Column of an exponential air from a point outwards, in units of its density at the ground times the radius. `rise`: dot(p, direction), which
// is r times the cosine from the zenith; below the horizon the way down and up again through the tangent point is counted.
// Chapman's grazing incidence function as sqrt(pi x / 2) erfcx(sqrt(x / 2) |cos|), x = r / H, times the next term of both its ends,
// 1 + 3 / (8 x) at the horizon and 1 + 1 / x at the zenith; erfcx as a polynomial in 1 / (1 + 0.56 z) (error 2.7e-4 of it, fitted over 0..60).
// Transmittances that it gives are within 0.0006 of the reference's, and 0.25 % of those above 0.001.
fn column_out(excess: f32, rise: f32, scale_height: f32) -> f32 {
    let radius = sqrt(1.0 + excess);
    let half_x = 0.5 * radius / scale_height;
    let cosine = abs(rise) / radius;
    let t = 1.0 / (1.0 + 0.56 * sqrt(half_x) * cosine);
    let up = exp(-height_of(excess) / scale_height) * scale_height * sqrt(3.14159265 * half_x) * erfcx_of(t)
        * (1.0 + (0.1875 + 0.3125 * cosine * cosine) / half_x);
    if rise >= 0.0 {
        return up;
    }
    // Under the ground the planet itself shades; the caller knows.
    let low = max(excess - rise * rise, 0.0);
    let half_x_low = 0.5 * sqrt(1.0 + low) / scale_height;
    let through = 2.0 * exp(-height_of(low) / scale_height) * scale_height * sqrt(3.14159265 * half_x_low) * (1.0 + 0.1875 / half_x_low);
    return max(through - up, 0.0);
}

//: if air.absorption
fn layer_density(layer: vec3f, excess: f32) -> f32 {
    return max(min((excess - layer.x) / (layer.y - layer.x), (layer.z - excess) / (layer.z - layer.y)), 0.0);
}

// Column of the layer along a line from its point nearest the centre (excess `low`, may be below 0) to the distance s >= 0 from there. Exact.
fn layer_to(layer: vec3f, low: f32, s: f32) -> f32 {
    let reach = min(sqrt(max(layer - low, vec3f(0.0))), vec3f(s));
    let cubes = reach * reach * reach * 0.33333333;
    let rising = ((low - layer.x) * (reach.y - reach.x) + cubes.y - cubes.x) / (layer.y - layer.x);
    let falling = ((layer.z - low) * (reach.z - reach.y) - cubes.z + cubes.y) / (layer.z - layer.y);
    return rising + falling;
}

// The same with the sign of s.
fn layer_signed(layer: vec3f, low: f32, s: f32) -> f32 {
    let column = layer_to(layer, low, abs(s));
    return select(column, -column, s < 0.0);
}
//: end

// Optical depth from a point to the Sun past the air, per channel, for a Sun direction along which a unit of the frame is one radius.
fn depth_towards_sun(air: Air, excess: f32, rise: f32) -> vec3f {
    var depth = column_out(excess, rise, air.gas_height) * air.gas_extinction;
//: if air.mie
    depth += column_out(excess, rise, air.haze_height) * air.haze_extinction;
//: end
//: if air.absorption
    let low = excess - rise * rise;
    depth += (layer_to(air.layer, low, 10.0) - layer_signed(air.layer, low, rise)) * air.layer_extinction;
//: end
    return depth;
}
