// What is summed along a view ray.

struct AirSums {
    // Gas and haze that the Sun lights, per channel, and the light of the many-times-scattered table.
    gas: vec3f,
    haze: vec3f,
    many: vec3f,
}
