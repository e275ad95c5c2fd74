// The air before what a pixel of a globe's draw shows, from the draw's own rays.

//: use lib/draw.wgsl
//: use lib/intersection.wgsl
//: use lib/air/along.wgsl
//: use lib/air/of_draw.wgsl
//: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
//: use lib/sunlight.wgsl
//: end

// The ray ends on the ground, but a sky's never does: under the horizon it grazes.
fn air_before(in: Varyings) -> AirLight {
//: if surface.sky
    let ground = false;
//: else
    let ground = true;
//: end
    let along = normalize(in.ray);
    let b = dot(in.anchor, along);
    let nearest = in.anchor - b * along;
    let near = draw.anchor_is_camera > 0.5;
    let low = select(dot(nearest, nearest) - 1.0, draw.anchor_excess - b * b, near);
    // Between the ground's last pixel and the first of the sky both graze; a ray that rises from a near camera meets no ground.
    let over = select(max(low, 0.0), low, near && b >= 0.0);
    let grazing = select(over, min(low, 0.0), ground);
    let path = air_path(nearest, along, grazing, b, draw.anchor_excess, near, ground, draw.air_top);
//: if lights.1
    let sun = draw.light_direction[0].xyz;
//: else
    let sun = vec3f(0.0, 0.0, 1.0);
//: end
//: if shape.ellipsoid
    let sun_in_frame = normalize(sun / draw.axis_ratios);
    let true_along = along * draw.axis_ratios;
    let along_length = length(true_along);
    let scale = vec2f(along_length, length(sun_in_frame * draw.axis_ratios));
    let cos_scattering = dot(true_along, sun) / along_length;
//: else
    let sun_in_frame = sun;
    let scale = vec2f(1.0);
    let cos_scattering = dot(along, sun);
//: end
//: if surface.sky
    let from_node = near && b >= 0.0 && draw.anchor_excess < draw.air_top;
//: else
    let from_node = true;
//: end
    return air_along(air_of_draw(), path, sun_in_frame, scale, cos_scattering, from_node);
}

//: if surface.sky
  //: if view.shaded
// Light beside a disc whose colours hold its gas, where that is opaque to a ray along the limb. What the disc's law and colour show at its limb is
// then that gas itself, with hazes and absorption that are not modelled: the same light goes on outward and thins as the gas does, grey, so that
// nothing shines along the limb that the disc does not show. Air too thin for that shows its own light (less than a fifth taken along the limb; all of
// it the disc's from a half on). Left out: the map's pattern (the disc's mean colour), twilight past the terminator. `taken`: mean of what the ray
// loses.
fn disc_going_on(in: Varyings, scattered: vec3f, taken: f32) -> vec3f {
    let along = normalize(in.ray);
    let nearest = normalize(in.anchor - dot(in.anchor, along) * along);
    let sun = draw.light_direction[0].xyz;
    //: if shape.ellipsoid
    let outward = normalize(nearest / draw.axis_ratios);
    let in_radii = nearest * draw.axis_ratios;
    //: else
    let outward = nearest;
    let in_radii = nearest;
    //: end
    let along_limb = depth_of(air_of_draw(), columns_through(air_of_draw(), 0.0));
    let at_limb = 1.0 - dot(exp(-along_limb), vec3f(0.33333333));
    var sunlight = draw.light_irradiance[0].rgb;
    //: if eclipse.1|ring-shadow.point-sun|ring-shadow.penumbra
    sunlight *= sunlight_reaching(in_radii);
    //: end
    let disc = draw.albedo * sunlight * (max(dot(outward, sun), 0.0) * taken / max(at_limb, 1.0e-6));
    return mix(scattered, disc, smoothstep(0.2, 0.5, at_limb));
}
  //: end
//: end

// What the camera sees of light and coverage behind the air. A sky covers by what it takes, and its light is per coverage.
fn through_air(in: Varyings, radiance: vec3f, coverage: f32) -> vec4f {
  //: if surface.sky
    // What is discarded would be summed all the same.
    let hidden = coverage >= 1.0;
  //: else
    let hidden = coverage <= 0.0;
  //: end
    if hidden {
        return vec4f(0.0);
    }
    let air = air_before(in);
//: if view.optical-depth
    return vec4f(air.depth, select(coverage, 1.0, air.depth.x > 0.0));
//: else
  //: if surface.sky
    let scattered = air.scattered * draw.light_irradiance[0].rgb + select(0.0, draw.air_night, air.depth.x > 0.0);
    let taken = 1.0 - dot(exp(-air.depth), vec3f(0.33333333));
    var seen = scattered;
    if draw.air_veil > 1.5 {
        seen = disc_going_on(in, scattered, taken);
    }
    // Not nothing where it shines: air too thin to dim would be lost.
    let least = select(0.0, 1.0e-6, seen.x + seen.y + seen.z > 0.0);
    let covers = max(taken, least);
    return vec4f(seen / max(covers, 1.0e-6), covers);
  //: else
    let scattered = air.scattered * draw.light_irradiance[0].rgb;
    //: if surface.cloud
    return vec4f(radiance * exp(-air.depth) + scattered, coverage);
    //: else
    if draw.air_veil > 0.5 {
        // Over a map that holds its air the light of that air goes on where the map's ends: past the terminator. Towards the limb it takes over, and at
        // the limb it is alone, as it is beside the ground. exp(-1/4) for each time the air straight up, less of thin air, was judged by eye on
        // Titan and Mars.
        let ground = air_node(AIR_NODES + 1u);
        let straight = dot(depth_of(air_of_draw(), columns_from(air_of_draw(), ground, 1.0)), vec3f(1.0));
        let along_limb = dot(depth_of(air_of_draw(), columns_from(air_of_draw(), ground, 0.0)), vec3f(1.0));
        // Thin air, straight down, is in the map: what shines past the terminator is that of air which hides the ground.
        let hides = 1.0 - exp(-0.33333333 * straight);
        let fall = 0.25 * hides / max(straight, 1.0e-6);
        let left = exp(fall * (straight - max(dot(air.depth, vec3f(1.0)), straight)));
        let at_limb = exp(fall * (straight - along_limb));
        let map_part = max(left - at_limb, 0.0) / (1.0 - at_limb);
        return vec4f(mix(scattered, max(radiance, scattered * hides * hides), map_part), coverage);
    }
    return vec4f(radiance * exp(-air.depth) + scattered, coverage);
    //: end
  //: end
//: end
}

//: if lights.1
// Part of the Sun's light that reaches the ground through the air; all, where the ground's colours hold the air.
fn sunlight_through_air(position: vec3f) -> vec3f {
//: if surface.cloud
//: else
    if draw.air_veil > 0.5 {
        return vec3f(1.0);
    }
//: end
    let sun = draw.light_direction[0].xyz;
//: if shape.ellipsoid
    let sun_in_frame = normalize(sun / draw.axis_ratios);
    let scale = length(sun_in_frame * draw.axis_ratios);
    return exp(-depth_of(air_of_draw(), columns_from(air_of_draw(), air_node(AIR_NODES + 1u), max(dot(position, sun_in_frame), 0.0))) * scale);
//: else
    return exp(-depth_of(air_of_draw(), columns_from(air_of_draw(), air_node(AIR_NODES + 1u), max(dot(position, sun), 0.0))));
//: end
}

// Irradiance by the whole sky, by day and by night. Without the table what the air takes out of the sunlight, `direct` is left, comes down in part as from a white dome.
// `sunlight`: what other bodies and the clouds leave of the Sun's.
fn skylight_on(position: vec3f, normal: vec3f, direct: vec3f, sunlight: vec3f) -> vec3f {
  //: if air.table
    //: if surface.cloud
    //: else
      //: if shape.ellipsoid
    let sky = (1.0 - draw.air_veil) * many_on_ground(dot(position, normalize(draw.light_direction[0].xyz / draw.axis_ratios)));
      //: else
    let sky = (1.0 - draw.air_veil) * many_on_ground(dot(position, draw.light_direction[0].xyz));
      //: end
      //: if eclipse.1
    // The sky is lit beyond the shadow, too.
        //: if shape.ellipsoid
    let in_radii = position * draw.axis_ratios;
        //: else
    let in_radii = position;
        //: end
    let spread = draw.light_irradiance[0].rgb * spread_reaching(in_radii, SPREAD_GROUND);
    let over_clouds = draw.light_irradiance[0].rgb * sunlight_reaching(in_radii);
    let past_clouds = select(vec3f(1.0), sunlight / max(over_clouds, vec3f(1.0e-30)), over_clouds > vec3f(0.0));
    return sky * max(sunlight, spread * past_clouds) + draw.air_night;
      //: else
    return sky * sunlight + draw.air_night;
      //: end
    //: end
  //: end
  //: if air.vertex|air.pixel-8|air.pixel-16|air.pixel-32|surface.cloud
    return draw.air_skylight * (1.0 - direct) * max(dot(normal, draw.light_direction[0].xyz), 0.0) * sunlight + draw.air_night;
  //: end
}
//: end
