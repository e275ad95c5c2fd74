// A shell of cloud: how much of it stands at a place, and its shadow on the ground.
//
// The map counts opacity (0 clear, 1 closed), linear. What a cloud does not reflect it lets through, so the ground under it gets
// 1 - opacity * albedo of the Sun's light; the light that the cloud spreads sideways is left in its own column.

//: use lib/draw.wgsl
//: use lib/map_place.wgsl

// Thin haze of the map's darkest greys is clear sky; a closed deck is reached at draw.cloud_full.
fn cloud_opacity(texel: f32) -> f32 {
    return smoothstep(draw.cloud_clear, draw.cloud_full, texel);
}

//: if maps.cloud-shadow
// `position`: unit-sphere frame of the ground. `dx`, `dy`: change of the map's coordinates per pixel, that of the ground below.
fn sunlight_through_clouds(position: vec3f, towards_sun: vec3f, dx: vec2f, dy: vec2f) -> f32 {
  //: if shape.ellipsoid|shape.mesh
    let along = towards_sun / draw.axis_ratios;
  //: else
    let along = towards_sun;
  //: end
    // Where the way to the Sun leaves the shell: |p + s along| = cloud_radius. The ground is inside, so there is one such place ahead.
    let a = dot(along, along);
    let b = dot(position, along);
    let c = dot(position, position) - draw.cloud_radius * draw.cloud_radius;
    let s = (sqrt(max(b * b - a * c, 0.0)) - b) / a;
    let uv = map_uv(position + s * along, draw.map_latitude_stretch);
    let opacity = cloud_opacity(filtered_map(cloud_map, map_sampler, uv, dx, dy, draw.map_taps).r);
    return 1.0 - opacity * draw.cloud_albedo;
}
//: end
