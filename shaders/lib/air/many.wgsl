// Light that the air has scattered more than once: the table of src/scene/air_table.rs, read between its nodes.
//
// It adds to the light scattered once, at the same samples. Where the Sun is hidden by another body at a sample, lib/air/spread.wgsl says what is left of it.

//: use lib/draw.wgsl

// Place among the 16 columns, which lie evenly in mu / (|mu| + 0.3) from -0.5 to 1 / 1.3; below 0 past the first.
fn many_column(sun_cosine: f32) -> f32 {
    return min((sun_cosine / (abs(sun_cosine) + 0.3) + 0.5) * 11.818182, 15.0);
}

// Between two columns. The table begins 17 degrees under the horizon: below that the light goes on to fall as it does between the first two; at 37 that of
// the highest air has gone, too.
fn many_between(left: vec3f, right: vec3f, column: f32, sun_cosine: f32) -> vec3f {
    if column >= 0.0 {
        return mix(left, right, column - min(floor(column), 14.0));
    }
    let fall = clamp(left / max(right, vec3f(1.0e-12)), vec3f(1.0e-6), vec3f(1.0));
    return left * exp(-column * log(fall)) * clamp(2.0 + sun_cosine * 3.3333333, 0.0, 1.0);
}

// Per unit of scattering, times pi. `row`: 0 on the ground, 7 at the top.
fn many_at(row: f32, sun_cosine: f32) -> vec3f {
    let column = many_column(sun_cosine);
    let c = min(u32(max(column, 0.0)), 14u);
    let r = min(u32(row), 6u);
    let k = r * 16u + c;
    let left = mix(draw.air_many[k].rgb, draw.air_many[k + 16u].rgb, row - f32(r));
    let right = mix(draw.air_many[k + 1u].rgb, draw.air_many[k + 17u].rgb, row - f32(r));
    let root = many_between(left, right, column, sun_cosine);
    return root * root;
}

// Irradiance of level ground by the whole sky, of all orders.
fn many_on_ground(sun_cosine: f32) -> vec3f {
    let column = many_column(sun_cosine);
    let c = min(u32(max(column, 0.0)), 14u);
    let root = many_between(draw.air_many[128u + c].rgb, draw.air_many[129u + c].rgb, column, sun_cosine);
    return root * root;
}

// Row of a height over the frame's floor.
fn many_row(height: f32) -> f32 {
    return 7.0 * sqrt(clamp((height + draw.air_many_heights.x) * draw.air_many_heights.y, 0.0, 1.0));
}

// The same at a sample of lib/air/rising.wgsl under a Sun above the horizon: src/scene/air_nodes.rs fits a polynomial to the table there.
fn many_at_node(node: u32, sun_cosine: f32) -> vec3f {
    let x = sun_cosine / (sun_cosine + 0.3);
    let k = 5u * node;
    var root = draw.air_many_nodes[k + 4u].rgb;
    root = root * x + draw.air_many_nodes[k + 3u].rgb;
    root = root * x + draw.air_many_nodes[k + 2u].rgb;
    root = root * x + draw.air_many_nodes[k + 1u].rgb;
    root = root * x + draw.air_many_nodes[k].rgb;
    return root * root;
}
