// Sunlight scattered once into a ray that only rises or only falls, all of it in sunlight and under a Sun above the horizon.
//
// That is the ground seen from outside by day, and the sky over the ground. The samples lie at the same heights for every pixel
// (src/scene/air_nodes.rs): Gauss and Legendre's in w, with the gas's density 1 - w^2 over the lower end, which makes the integrand smooth for
// steep and for grazing rays alike. What depends on the height alone is then the same for all pixels, optical depths of whole ways are
// closed forms, and half as many samples as lib/air/scatter.wgsl has do. Through thick air the light comes from a small part of the heights, which
// differs from ray to ray: that is left to lib/air/scatter.wgsl. Errors: tests/atmosphere/tier_bounds.rs.

//: use lib/air/columns.wgsl
//: use lib/air/counts.wgsl
//: use lib/air/path.wgsl
//: use lib/air/sums.wgsl
//: use lib/air/of_draw.wgsl
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
//: use lib/air/shaded.wgsl
//: end
//: if air.table
//: use lib/air/many.wgsl
  //: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
//: use lib/air/spread.wgsl
  //: end
//: end

// Optical depth, mean of the channels, up to which the samples of all pixels do for a ray that rises, and for one that falls: it ends in the thick air, and
// begins with what is seen of it. With 8 in place of 4 the worst of 22 000 rays at pixel-32 was 1.1 % off in place of 0.4 %; 4 in place of 12 gained nothing.
const MOST_RISING = 4.0;
const MOST_FALLING = 12.0;

// `at_camera`: columns outwards from the camera's end, of the camera's node.
fn air_rising(air: Air, path: AirPath, at_camera: vec3f, sun_along: f32, sun_nearest: f32, scale: vec2f) -> AirSums {
    var sums: AirSums;
    let side = select(1.0, -1.0, path.to_s <= 0.0);
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
    var shaded = vec3f(1.0);
    var many_shaded = vec3f(1.0);
//: end
    for (var i = 0u; i < AIR_NODES; i++) {
        let node = air_node(i);
        let s = side * sqrt(max(node.a.x - path.low, 1.0e-12));
        let rise = sun_nearest + s * sun_along;
        let seen = scale.x * abs(columns_from(air, node, s) - at_camera);
        let sunlit = scale.y * columns_from(air, node, rise);
        let gas = scale.x * node.a.y / abs(s);
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
        // Two neighbours share what other bodies leave, between them.
        if (i & 1u) == 0u {
            shaded = shaded_air(path, side * sqrt(max(node.c.w - path.low, 0.0)));
        }
//: end
//: if air.table
        let kept = exp(-depth_of(air, seen));
        var part = kept * exp(-depth_of(air, sunlit));
        var many = kept * many_at_node(i, max(rise, 0.0) * node.a.w);
  //: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
        if (i & 1u) == 0u {
            many_shaded = many_left(path, side * sqrt(max(node.c.w - path.low, 0.0)), node.c.w);
        }
        many *= many_shaded;
  //: end
  //: if air.mie
        sums.many += many * (gas * (air.gas_scattering + node.a.z * air.haze_scattering));
  //: else
        sums.many += many * (gas * air.gas_scattering);
  //: end
//: else
        var part = exp(-depth_of(air, seen + sunlit));
//: end
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
        part *= shaded;
//: end
        part *= gas;
        sums.gas += part;
//: if air.mie
        sums.haze += node.a.z * part;
//: end
    }
    return sums;
}
