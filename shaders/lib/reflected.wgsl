// Light that one facet sends to the viewer: from one light, and from all but the Sun.
//
// `position`: unit-sphere frame.

//: if view.shaded
  //: if surface.lambert|surface.cloud|surface.ring
//: use lib/photometry/lambert.wgsl
  //: end
  //: if surface.lommel-seeliger
//: use lib/photometry/lommel_seeliger.wgsl
  //: end
  //: if surface.lunar-lambert
//: use lib/photometry/lunar_lambert.wgsl
  //: end
  //: if surface.oren-nayar
//: use lib/photometry/oren_nayar.wgsl
  //: end
  //: if maps.specular
//: use lib/glint.wgsl
  //: end
//: use lib/draw.wgsl

struct Facet {
    // Unit vectors, body axes.
    normal: vec3f,
    towards_camera: vec3f,
    // Cosine between the two, not below 0.
    cos_emission: f32,
    albedo: vec3f,
  //: if maps.normal
    // The normal before relief.
    smooth_normal: vec3f,
  //: end
  //: if maps.specular
    // 1 open water, 0 land.
    water: f32,
  //: end
}
//: end

//: if ring-shine
//: use lib/ring/shine.wgsl
//: end

//: if maps.normal
// A slope behind the horizon gets no light, though it may face the light: 1 where the light is up, 0 where it is down, over
// 0.05 rad (2.9 degrees) to either side of the smooth horizon. That is the dip of the horizon seen from 2.2 km above the Moon; higher
// peaks go dark too early, and shadows that relief throws are left out.
fn above_horizon(cos_smooth: f32) -> f32 {
    return clamp(0.5 + cos_smooth * 10.0, 0.0, 1.0);
}
//: end

//: if view.sunlight
// Irradiance on the surface itself, linear RGB.
fn irradiance_on(normal: vec3f, smooth_normal: vec3f, towards_light: vec3f, irradiance: vec3f) -> vec3f {
    let cos_incidence = max(dot(normal, towards_light), 0.0);
  //: if maps.normal
    return irradiance * (cos_incidence * above_horizon(dot(smooth_normal, towards_light)));
  //: else
    return irradiance * cos_incidence;
  //: end
}
//: end

//: if view.shaded
// Radiance towards the viewer. `towards_light`: unit vector, body axes; `irradiance` on a plane facing the light.
fn reflected(facet: Facet, towards_light: vec3f, irradiance: vec3f) -> vec3f {
    let cos_incidence = clamp(dot(facet.normal, towards_light), 0.0, 1.0);
    let cos_phase = dot(towards_light, facet.towards_camera);
  //: if surface.lunar-lambert|surface.oren-nayar
    let share = reflectance(cos_incidence, facet.cos_emission, cos_phase, draw.photometric_parameter);
  //: else
    let share = reflectance(cos_incidence, facet.cos_emission, cos_phase);
  //: end
  //: if maps.normal
    let arriving = irradiance * above_horizon(dot(facet.smooth_normal, towards_light));
  //: else
    let arriving = irradiance;
  //: end
  //: if maps.specular
    let half_way = towards_light + facet.towards_camera;
    let cos_half = max(dot(facet.normal, half_way), 0.0) * inverseSqrt(max(dot(half_way, half_way), 1.0e-12));
    let mirror = draw.specular_strength * facet.water * fresnel_water(cos_phase);
    // What the water's surface turns back does not reach what lies under it.
    let glint = mirror * glint_lobe(cos_half, cos_incidence, facet.cos_emission, draw.wave_slope_sq);
    return arriving * (facet.albedo * share * (1.0 - min(mirror, 1.0)) + glint);
  //: else
    return arriving * facet.albedo * share;
  //: end
}
//: end

//: if lights.2|ring-shine
//: use lib/draw.wgsl
  //: if view.shaded
// Of other bodies, and of the ring.
fn reflected_besides(facet: Facet, position: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    //: if lights.2
    sum += reflected(facet, draw.light_direction[1].xyz, draw.light_irradiance[1].rgb);
    //: end
    //: if lights.3
    sum += reflected(facet, draw.light_direction[2].xyz, draw.light_irradiance[2].rgb);
    //: end
    //: if ring-shine
    sum += facet.albedo * ring_shine(position) * draw.light_irradiance[0].rgb;
    //: end
    return sum;
}
  //: end
  //: if view.sunlight
// The same as irradiance.
fn irradiance_besides(normal: vec3f, smooth_normal: vec3f, position: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    //: if lights.2
    sum += irradiance_on(normal, smooth_normal, draw.light_direction[1].xyz, draw.light_irradiance[1].rgb);
    //: end
    //: if lights.3
    sum += irradiance_on(normal, smooth_normal, draw.light_direction[2].xyz, draw.light_irradiance[2].rgb);
    //: end
    //: if ring-shine
    sum += ring_shine(position) * draw.light_irradiance[0].rgb;
    //: end
    return sum;
}
  //: end
//: end
