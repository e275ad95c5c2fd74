// Light that the air has scattered more than once: the table of src/scene/air_table.rs, read between its nodes.
//
// It adds to what lib/air/scatter.wgsl sums. Where the Sun is hidden by another body at a sample, this light is hidden there in the same part;
// what would come from lit air beside it is left out.

//: use lib/draw.wgsl
//: use lib/air/scatter.wgsl

// The light is smooth along a ray: twice as many samples change the Earth's sky by less than 1 %.
const MANY_SAMPLES = 8u;

// Place among the 16 columns, which lie evenly in mu / (|mu| + 0.3) from -0.5 to 1 / 1.3.
fn many_column(sun_cosine: f32) -> f32 {
    return clamp((sun_cosine / (abs(sun_cosine) + 0.3) + 0.5) * 11.818182, 0.0, 15.0);
}

// Per unit of scattering, times pi. `row`: 0 on the ground, 7 at the top.
fn many_at(row: f32, sun_cosine: f32) -> vec3f {
    let column = many_column(sun_cosine);
    let c = min(u32(column), 14u);
    let r = min(u32(row), 6u);
    let k = r * 16u + c;
    let below = mix(draw.air_many[k].rgb, draw.air_many[k + 1u].rgb, column - f32(c));
    let above = mix(draw.air_many[k + 16u].rgb, draw.air_many[k + 17u].rgb, column - f32(c));
    let root = mix(below, above, row - f32(r));
    return root * root;
}

// Irradiance of level ground by the whole sky, of all orders.
fn many_on_ground(sun_cosine: f32) -> vec3f {
    let column = many_column(sun_cosine);
    let c = min(u32(column), 14u);
    let root = mix(draw.air_many[128u + c].rgb, draw.air_many[129u + c].rgb, column - f32(c));
    return root * root;
}

// What a view ray brings, in the unit of AirLight.
fn many_along(air: Air, path: AirPath, towards_sun: vec3f, scale: vec2f) -> vec3f {
    if path.to_s <= path.from_s || path.low >= air.top {
        return vec3f(0.0);
    }
    let span = span_of(path);
    let sun_along = dot(path.along, towards_sun);
    let sun_nearest = dot(path.nearest, towards_sun);
    var light = vec3f(0.0);
    var behind = vec3f(0.0);
    for (var i = 0u; i < MANY_SAMPLES; i++) {
        let at = sample_of(span, (f32(i) + 0.5) * (1.0 / f32(MANY_SAMPLES)));
        let height = height_of(at.excess);
        let step = scale.x * at.step * (1.0 / f32(MANY_SAMPLES));
        let gas = step * exp(-height / air.gas_height);
        var cell = gas * air.gas_extinction;
        var scattered = gas * air.gas_scattering;
//: if air.mie
        let haze = step * exp(-height / air.haze_height);
        cell += haze * air.haze_extinction;
        scattered += haze * air.haze_scattering;
//: end
//: if air.absorption
        cell += step * layer_density(air.layer, at.excess) * air.layer_extinction;
//: end
        let row = 7.0 * sqrt(clamp((height + draw.air_many_heights.x) * draw.air_many_heights.y, 0.0, 1.0));
        let cosine = (sun_nearest + at.s * sun_along) / sqrt(1.0 + at.excess);
        var part = exp(-behind) * kept_in(cell) * many_at(row, cosine);
//: if eclipse.1
  //: if shape.ellipsoid
        part *= sunlight_reaching((path.nearest + at.s * path.along) * draw.axis_ratios);
  //: else
        part *= sunlight_reaching(path.nearest + at.s * path.along);
  //: end
//: end
        light += part * scattered;
        behind += cell;
    }
    return light;
}
