// The amounts of one draw and its maps. Field names are those of scene's `Amounts`; the plan fills them by name, so a field
// is here only where the key's code reads it.

//: if air.vertex|air.pixel-8|air.pixel-16|air.pixel-32|air.table
//: use lib/air/counts.wgsl
//: end

struct Draw {
//: if shape.mesh
    // Of a point less the anchor; reversed depth, no far plane.
    clip_from_unit_sphere: mat4x4f,
    // Near the ground the camera: there the difference is exact in f32. Farther out 0.
    mesh_anchor: vec3f,
    // The camera in the unit-sphere frame.
    camera_in_unit_sphere: vec3f,
//: else
    // Left, top, right, bottom of the rectangle that bounds the silhouette, clip space (y up).
    rect_in_clip: vec4f,
    // View rays over the rectangle: value = origin + u du + v dv, v down the screen; unit-sphere frame.
    anchor_origin: vec3f,
    anchor_du: vec3f,
    anchor_dv: vec3f,
    ray_origin: vec3f,
    ray_du: vec3f,
    ray_dv: vec3f,
    // 1: the anchor is the camera itself, and anchor_excess is |camera|^2 - 1; 0: a plane through the body's centre.
    anchor_is_camera: f32,
    anchor_excess: f32,
//: end
//: if shape.sphere|shape.ellipsoid|view.depth
    // Reversed depth of a point p = 1 / (dot(row.xyz, p) + row.w).
    depth_row: vec4f,
//: end
//: if shape.ellipsoid|shape.mesh
    // Semi-axes over the equatorial radius.
    axis_ratios: vec3f,
//: end
//: if view.shaded|view.albedo
  //: if surface.emissive|lights.1|view.albedo
    // Linear RGB factor on the map; alone where there is no map.
    albedo: vec3f,
  //: end
//: end
//: if lights.1
    // Unit vectors towards the lights (xyz), the Sun first.
  //: if lights.3
    light_direction: array<vec4f, 3>,
  //: else
    //: if lights.2
    light_direction: array<vec4f, 2>,
    //: else
    light_direction: array<vec4f, 1>,
    //: end
  //: end
    // Linear RGB irradiance (xyz) on a plane facing the light; the Sun's at 1 au is 1.
  //: if lights.3
    light_irradiance: array<vec4f, 3>,
  //: else
    //: if lights.2
    light_irradiance: array<vec4f, 2>,
    //: else
    light_irradiance: array<vec4f, 1>,
    //: end
  //: end
//: end
//: if eclipse.1
    // Unit vector from the body's centre to the Sun's (xyz), and 1 / their distance (w); lengths here are equatorial radii.
    eclipse_axis: vec4f,
    // Two unit vectors across it (xyz). w: cotangent of the Sun's angular radius, and that over the distance.
    eclipse_across: array<vec4f, 2>,
  //: if eclipse.linear
  //: else
    // Radiance of the Sun's disc per unit of its light and of its radius squared: factors of 1, mu, mu^2 per channel.
    eclipse_limb: array<vec4f, 3>,
  //: end
    // Casters: centre across the axis (xy) and along it (z); unit vector of the long axis (xy) and semi-axes of the outline (zw).
  //: if eclipse.4
    caster_place: array<vec4f, 4>,
    caster_shape: array<vec4f, 4>,
  //: else
    //: if eclipse.3
    caster_place: array<vec4f, 3>,
    caster_shape: array<vec4f, 3>,
    //: else
      //: if eclipse.2
    caster_place: array<vec4f, 2>,
    caster_shape: array<vec4f, 2>,
      //: else
    caster_place: array<vec4f, 1>,
    caster_shape: array<vec4f, 1>,
      //: end
    //: end
  //: end
  //: if eclipse.refracted
    // The first caster's air by layers, upward: radius and bending (radians) at the lower (xy) and the upper edge (zw); part let through.
    caster_air_edges: array<vec4f, 32>,
    caster_air_passes: array<vec4f, 32>,
  //: end
//: end
//: if surface.lunar-lambert|surface.oren-nayar
    // Lunar weight L, or Oren-Nayar's sigma squared (rad^2).
    photometric_parameter: f32,
//: end
//: if surface.emissive
    // Limb darkening, linear and quadratic term per channel. Limbs of nearer bodies, by rows of lib/uncovered.wgsl.
    limb_u1: vec3f,
    limb_u2: vec3f,
  //: if shape.sphere|shape.ellipsoid
    hider: array<vec4f, 6>,
  //: end
//: end
//: if maps.cloud-shadow|surface.cloud
    // Texels of the cloud map at which the sky is clear, and closed.
    cloud_clear: f32,
    cloud_full: f32,
//: end
//: if maps.cloud-shadow
    // Radius of the cloud shell and Lambert albedo of a closed deck.
    cloud_radius: f32,
    cloud_albedo: f32,
//: end
//: if surface.cloud
    // The shell's unit sphere over the body's.
    shell_scale: f32,
//: end
//: if maps.albedo|maps.normal|maps.specular|maps.night|maps.cloud-shadow|surface.cloud|view.uv
  //: if shape.sphere|shape.ellipsoid|maps.cloud-shadow
    // Stretch of z that turns a unit-sphere point into the direction whose latitude the map counts.
    map_latitude_stretch: f32,
  //: end
//: end
//: if maps.albedo|maps.normal|maps.specular|maps.night|maps.cloud-shadow|surface.cloud|overlays.1
    // Taps along a footprint at most: lib/filtered.wgsl.
    map_taps: f32,
//: end
//: if surface.ring|ring-shadow.point-sun|ring-shadow.penumbra
    // Radii in the ring's table, and the innermost and the outermost of them.
    ring_nodes: f32,
    ring_reach: vec2f,
//: end
//: if ring-shadow.point-sun|ring-shadow.penumbra|body-shadow.sphere
    // Half a pixel at the body's distance, equatorial radii.
    ring_blur: f32,
//: end
//: if ring-shine
    // Unit vector of the Sun in the ring's plane (xy), one over the height that sees no ring (z), factor on the ring's light (w).
    ring_shine: vec4f,
//: end
//: if surface.ring
  //: if view.shaded
    //: if lights.1
    // Phase function of the bodies: factor and exponent; 1 where any ring has dust.
    ring_phase: vec3f,
    // Asymmetry of the lobes of the dust's phase function, and the part of its light in each.
    ring_dust_asymmetry: vec3f,
    ring_dust_share: vec3f,
    // Height and width of the opposition's peak.
    ring_opposition: vec2f,
    //: end
  //: end
    // Which half is drawn: 1 before the body's centre, -1 behind it.
    ring_half: f32,
//: end
//: if surface.ring|ring-shadow.penumbra|body-shadow.ellipsoid-penumbra
  //: if lights.1
    // Tangent of the Sun's angular radius.
    sun_tangent: f32,
  //: end
//: end
//: if body-shadow.ellipsoid-penumbra
    // Semi-axes of the body over its equatorial radius, and the Sun's limb darkening per channel.
    shadow_axes: vec3f,
    sun_limb_u1: vec3f,
    sun_limb_u2: vec3f,
//: end
//: if overlays.1
    // lib/overlay.wgsl says what each row is.
  //: if overlays.2
    overlay: array<vec4f, 12>,
  //: else
    overlay: array<vec4f, 6>,
  //: end
//: end
//: if maps.normal
    normal_strength: f32,
//: end
//: if maps.specular
    specular_strength: f32,
    wave_slope_sq: f32,
//: end
//: if maps.night
    // Radiance of a white texel of the night map.
    night_radiance: vec3f,
//: end
//: if air.vertex|air.pixel-8|air.pixel-16|air.pixel-32|air.table
    // The air: lib/air/columns.wgsl says what each is.
    air_top: f32,
    air_gas_height: f32,
    air_gas_scattering: vec3f,
    air_gas_extinction: vec3f,
  //: if lights.1
    // Part of what the air takes out of the sunlight that reaches the ground from the whole sky.
    air_skylight: vec3f,
    air_night: f32,
  //: end
  //: if air.mie
    air_haze_height: f32,
    air_haze_asymmetry: f32,
    air_haze_scattering: vec3f,
    air_haze_extinction: vec3f,
  //: end
  //: if air.absorption
    air_layer: vec3f,
    air_layer_extinction: vec3f,
  //: end
  //: if surface.cloud
  //: else
    // 1: the ground's colours hold the air already; 2: and go on beside the disc.
    air_veil: f32,
  //: end
    // Place, weight, and the place between this and the next, of the samples of lib/air/scatter.wgsl.
    air_samples: array<vec4f, AIR_SAMPLES>,
  //: if air.table
    air_many_samples: array<vec4f, 8>,
  //: end
    // Rows of lib/air/columns.wgsl's AirNode: the samples', the camera's end, the far end. lib/air/counts.wgsl.
    air_nodes: array<vec4f, 3u * (AIR_NODES + 2u)>,
  //: if air.table
    //: if eclipse.1
    // lib/air/spread.wgsl: 80 rows for each of 4 casters, then one for each that says where they lie.
    caster_spread: array<vec4f, 324>,
    //: end
    // Height of the frame's floor over the ground, and one over that of the top; both in the frame's radii.
    air_many_heights: vec2f,
    // 8 rows of heights and one of the ground, each of 16 Suns: lib/air/many.wgsl.
    air_many: array<vec4f, 144>,
    // Five coefficients at each sample of lib/air/rising.wgsl.
    //: if surface.cloud
    air_many_nodes: array<vec4f, 20>,
    //: else
    air_many_nodes: array<vec4f, 40>,
    //: end
  //: end
//: end
}

@group(0) @binding(0) var<uniform> draw: Draw;
//: use lib/maps.wgsl
