// What other bodies and rings leave of the Sun's light at a place on a view ray.

//: use lib/draw.wgsl
//: use lib/sunlight.wgsl
//: use lib/air/path.wgsl

fn shaded_air(path: AirPath, s: f32) -> vec3f {
//: if shape.ellipsoid
    return sunlight_reaching((path.nearest + s * path.along) * draw.axis_ratios);
//: else
    return sunlight_reaching(path.nearest + s * path.along);
//: end
}
