// One body, one draw: the colour, coverage and depth of a planet, moon, asteroid or star.
//
// Coming in: the uniform block `Draw` and the maps of lib/draw.wgsl, the shape's varyings.
// Going out: linear RGB radiance, premultiplied by coverage (blend: premultiplied over), and reversed depth.
// Unit of radiance: that of a white Lambert plane facing the Sun at 1 au is 1, so no factor pi is written anywhere.
// Directions and normals are in body-fixed axes; lengths are equatorial radii.

//: use lib/draw.wgsl
//: if surface.ring
//: use lib/ring/surface.wgsl
//: else
//: if shape.mesh
//: use lib/mesh.wgsl
//: else
//: use lib/intersection.wgsl
//: end
//: if maps.albedo|maps.normal|maps.specular|maps.night|maps.cloud-shadow|surface.cloud|view.uv
//: use lib/map_place.wgsl
//: end
//: if overlays.1
//: use lib/overlay.wgsl
//: end
//: if maps.cloud-shadow|surface.cloud
//: use lib/clouds.wgsl
//: end
//: if maps.normal
//: use lib/relief.wgsl
//: end
//: if surface.emissive
//: use lib/limb_darkening.wgsl
//: end
//: if lights.1
  //: if surface.sky
  //: else
//: use lib/reflected.wgsl
  //: end
//: end
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra|body-shadow.sphere|body-shadow.ellipsoid-penumbra
//: use lib/sunlight.wgsl
//: end
//: if maps.night
//: use lib/night_lights.wgsl
//: end
//: if air.vertex|air.pixel-8|air.pixel-16|air.pixel-32|air.table
//: use lib/air/seen_air.wgsl
//: end

struct Pixel {
    @location(0) colour: vec4f,
//: if shape.sphere|shape.ellipsoid
    @builtin(frag_depth) depth: f32,
//: end
}

@fragment
fn fragment_main(in: Varyings) -> Pixel {
    let seen = seen_surface(in);
    var coverage = seen.coverage;

    // Everything that takes differences between neighbouring pixels comes before the first discard.
//: if maps.albedo|maps.normal|maps.specular|maps.night|maps.cloud-shadow|surface.cloud|view.uv
  //: if shape.mesh
    let place = MapPlace(in.uv, dpdx(in.uv), dpdy(in.uv));
  //: else
    let place = map_place(seen.position, draw.map_latitude_stretch);
  //: end
//: end
//: if overlays.1
    let images = overlay_places(seen.position);
//: end
//: if maps.normal
  //: if shape.mesh
    let frame = tangent_frame_of_triangle(seen.position * draw.axis_ratios, place, seen.normal);
  //: else
    //: if shape.ellipsoid
    let frame = tangent_frame_of_ellipsoid(seen.position, draw.axis_ratios, seen.normal);
    //: else
    let frame = tangent_frame_of_ellipsoid(seen.position, vec3f(1.0), seen.normal);
    //: end
  //: end
//: end
//: if lights.1|view.ring
  //: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra|body-shadow.sphere|body-shadow.ellipsoid-penumbra
    // The body's own equatorial radii.
    //: if shape.ellipsoid|shape.mesh
    var in_radii = seen.position * draw.axis_ratios;
    //: else
    var in_radii = seen.position;
    //: end
    //: if surface.cloud
    in_radii *= draw.shell_scale;
    //: end
    //: if ring-shadow.point-sun|ring-shadow.penumbra
    let blur = shadow_blur(in_radii);
    //: end
  //: end
//: end
//: if surface.sky
    // Under the ground's soft edge the sky goes on; where the ground is whole it hides the sky.
    if coverage >= 1.0 {
        discard;
    }
//: else
    if coverage <= 0.0 {
        discard;
    }
//: end
//: if maps.albedo
    let albedo_texel = filtered_map(albedo_map, map_sampler, place.uv, place.dx, place.dy, draw.map_taps);
  //: if flags.alphatexture
    coverage *= albedo_texel.a;
  //: end
//: end
//: if surface.cloud
    coverage *= cloud_opacity(filtered_map(cloud_map, map_sampler, place.uv, place.dx, place.dy, draw.map_taps).r);
//: end
//: if flags.alphatexture|surface.cloud
    if coverage <= 0.0 { discard; }
//: end
//: if view.shaded|view.albedo
  //: if surface.emissive|lights.1|view.albedo
    var albedo = draw.albedo;
    //: if maps.albedo
    albedo *= albedo_texel.rgb;
    //: end
    //: if flags.vertexcolour
    albedo *= in.colour;
    //: end
    //: if overlays.1
    albedo = overlaid(albedo, images);
    //: end
  //: end
//: end
//: if surface.emissive|lights.1|view.normal
    var normal = seen.normal;
    var cos_emission = seen.cos_emission;
  //: if maps.normal
    let slope = filtered_map(normal_map, map_sampler, place.uv, place.dx, place.dy, draw.map_taps).xyz;
    let tilted = tilted_normal(frame, slope, draw.normal_strength, seen.normal);
    normal = seen_normal(tilted, seen.towards_camera, seen.cos_emission);
    cos_emission = max(dot(normal, seen.towards_camera), 0.0);
  //: end
//: end

//: if lights.1
    var sunlight = draw.light_irradiance[0].rgb;
  //: if ring-shadow.point-sun|ring-shadow.penumbra
    sunlight *= sunlight_over(in_radii, blur);
  //: else
    //: if eclipse.1|body-shadow.sphere|body-shadow.ellipsoid-penumbra
    sunlight *= sunlight_reaching(in_radii);
    //: end
  //: end
  //: if shape.mesh
    sunlight *= seen.sunlit;
  //: end
  //: if maps.cloud-shadow
    sunlight *= sunlight_through_clouds(seen.position, draw.light_direction[0].xyz, place.dx, place.dy);
  //: end
//: end
    var radiance = vec3f(0.0);
//: if view.shaded
  //: if surface.emissive
    radiance = albedo * limb_darkening(cos_emission, draw.limb_u1, draw.limb_u2);
  //: else
    //: if surface.sky
    //: else
    //: if lights.1
      //: if air.vertex|air.pixel-8|air.pixel-16|air.pixel-32|air.table
    let direct = sunlight_through_air(seen.position);
    radiance += albedo * skylight_on(seen.position, seen.normal, direct, sunlight);
    sunlight *= direct;
      //: end
    var facet: Facet;
    facet.normal = normal;
    facet.towards_camera = seen.towards_camera;
    facet.cos_emission = cos_emission;
    facet.albedo = albedo;
      //: if maps.normal
    facet.smooth_normal = seen.normal;
      //: end
      //: if maps.specular
    facet.water = filtered_map(specular_map, map_sampler, place.uv, place.dx, place.dy, draw.map_taps).r;
      //: end
    radiance += reflected(facet, draw.light_direction[0].xyz, sunlight);
    //: end
    //: if lights.2|ring-shine
    radiance += reflected_besides(facet, seen.position);
    //: end
    //: if maps.night
    let lamps = filtered_map(night_map, map_sampler, place.uv, place.dx, place.dy, draw.map_taps).rgb;
      //: if lights.1
    radiance += lamps * draw.night_radiance * lamps_lit(dot(seen.normal, draw.light_direction[0].xyz));
      //: else
    radiance += lamps * draw.night_radiance;
      //: end
    //: end
    //: end
  //: end
//: end
//: if view.depth
    // Nearest point of the body white, farthest black: distance along the view axis from the body's centre, in its own extent.
    radiance = vec3f(0.5 - 0.5 * dot(draw.depth_row.xyz, seen.position) / max(length(draw.depth_row.xyz), 1.0e-30));
//: end
//: if view.normal
    radiance = 0.5 + 0.5 * normal;
//: end
//: if view.albedo
    radiance = albedo;
//: end
//: if view.uv
    radiance = vec3f(fract(place.uv), 0.0);
//: end
//: if view.eclipse
  //: if eclipse.1
    radiance = sunlight / draw.light_irradiance[0].rgb;
  //: else
    radiance = vec3f(1.0);
  //: end
//: end
//: if view.sunlight
  //: if lights.1
    radiance += irradiance_on(normal, seen.normal, draw.light_direction[0].xyz, sunlight);
  //: end
  //: if lights.2|ring-shine
    radiance += irradiance_besides(normal, seen.normal, seen.position);
  //: end
//: end
//: if view.ring
    // Part of the Sun's light that the ring leaves.
  //: if ring-shadow.point-sun|ring-shadow.penumbra
    radiance = vec3f(ring_light(in_radii, blur));
  //: else
    radiance = vec3f(1.0);
  //: end
//: end

//: if air.vertex|air.pixel-8|air.pixel-16|air.pixel-32|air.table
    let aired = through_air(in, radiance, coverage);
    radiance = aired.rgb;
    coverage = aired.a;
//: end
    var pixel: Pixel;
    pixel.colour = vec4f(radiance * coverage, coverage);
//: if shape.sphere|shape.ellipsoid
    pixel.depth = seen.depth;
//: end
    return pixel;
}
//: end
