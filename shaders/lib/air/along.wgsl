// Sunlight scattered into a view ray, and what the air leaves of the light behind it.
//
// A ray that only rises or falls, lit from end to end, takes the short way of lib/air/rising.wgsl; one through twilight, shadow, a limb or thick air is
// marched (lib/air/scatter.wgsl). Left out: refraction, the Sun's width.

//: use lib/air/path.wgsl
//: use lib/air/rising.wgsl
//: use lib/air/scatter.wgsl

struct AirLight {
    // Radiance per irradiance of the Sun, times pi: 1 is a white plane's that faces the Sun.
    scattered: vec3f,
    // Optical depth of the path.
    depth: vec3f,
}

// `towards_sun`: unit vector of the frame. `scale`: real length of a unit along the ray and along the Sun's light.
// `cos_scattering`: between the light's way and the ray's way back to the camera, in true axes. `from_node`: the ray only rises or falls, and
// begins and ends at the heights of the nodes.
fn air_along(air: Air, path: AirPath, towards_sun: vec3f, scale: vec2f, cos_scattering: f32, from_node: bool) -> AirLight {
    var light: AirLight;
    // A metre of a steep ray is no distance in f32; the heights of its ends tell them apart.
    if path.to_s < path.from_s || path.low >= air.top {
        return light;
    }
    let sun_along = dot(path.along, towards_sun);
    let sun_nearest = dot(path.nearest, towards_sun);
    let shadow = planet_shadow(path, towards_sun, sun_along, sun_nearest);
    // The planet's shadow begins under the horizon, so a Sun above it at both ends lights the whole path.
    let day = min(sun_nearest + path.from_s * sun_along, sun_nearest + path.to_s * sun_along) >= 0.0;
    var sums: AirSums;
    var rising = from_node && day;
    if rising {
        let at_camera = columns_from(air, air_node(AIR_NODES), path.from_s);
        light.depth = scale.x * depth_of(air, abs(columns_from(air, air_node(AIR_NODES + 1u), path.to_s) - at_camera));
        rising = dot(light.depth, vec3f(0.33333333)) < select(MOST_RISING, MOST_FALLING, path.to_s <= 0.0);
        if rising {
            sums = air_rising(air, path, at_camera, sun_along, sun_nearest, scale);
        }
    }
    if !rising {
        let view = view_of(air, path);
        light.depth = scale.x * depth_of(air, columns_before(air, view, node_at(air, path.to_excess), path.to_s));
        // All of it in shadow: what it takes, and no light.
        if !(shadow.y > shadow.x && shadow.x <= path.from_s && shadow.y >= path.to_s) {
            sums = air_marched(air, path, view, light.depth, shadow, sun_along, sun_nearest, scale);
        }
//: if air.table
        sums.many = many_marched(air, path, view, light.depth, sun_along, sun_nearest, scale);
//: end
    }
    // Rayleigh's phase function, 3 / (16 pi) (1 + cos^2), times pi.
    light.scattered = sums.gas * air.gas_scattering * (0.1875 * (1.0 + cos_scattering * cos_scattering));
//: if air.mie
    // Henyey and Greenstein's.
    let g = air.haze_asymmetry;
    let away = max(1.0 + g * g - 2.0 * g * cos_scattering, 1.0e-6);
    light.scattered += sums.haze * air.haze_scattering * (0.25 * (1.0 - g * g) / (away * sqrt(away)));
//: end
//: if air.table
    light.scattered += sums.many;
//: end
    return light;
}
