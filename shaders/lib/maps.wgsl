// The maps of one draw.

//: if maps.albedo
@group(0) @binding(1) var albedo_map: texture_2d<f32>;
//: end
//: if maps.normal
@group(0) @binding(2) var normal_map: texture_2d<f32>;
//: end
//: if maps.specular
@group(0) @binding(3) var specular_map: texture_2d<f32>;
//: end
//: if maps.night
@group(0) @binding(4) var night_map: texture_2d<f32>;
//: end
//: if maps.cloud-shadow|surface.cloud
@group(0) @binding(7) var cloud_map: texture_2d<f32>;
//: end
//: if maps.albedo|maps.normal|maps.specular|maps.night|maps.cloud-shadow|surface.cloud
// Repeats in u, clamps in v.
@group(0) @binding(8) var map_sampler: sampler;
//: use lib/filtered.wgsl
//: end
