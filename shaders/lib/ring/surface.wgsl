// A flat ring met by each pixel's view ray: no mesh. What a pixel sees of the plane is a thin parallelogram; the profile is averaged over the
// stretches of radius that it covers, so that edges are soft, narrow ringlets keep their light, and a ring seen edge-on stays finite.
//
// Coming in, going out: as entry/planet.wgsl. Lengths are equatorial radii of the body on all three axes. The opacity is 1 - exp(-tau / mu).

//: use lib/view_ray.wgsl
//: use lib/ring/profile.wgsl
//: if lights.1
  //: if view.shaded
//: use lib/ring/photometry.wgsl
  //: end
  //: if eclipse.1|body-shadow.sphere|body-shadow.ellipsoid-penumbra
//: use lib/sunlight.wgsl
  //: end
//: end

struct Pixel {
    @location(0) colour: vec4f,
    @builtin(frag_depth) depth: f32,
}

// The pixel's parallelogram in the ring's plane.
struct RingFootprint {
    middle: vec2f,
    // Unit vector along the view, in the plane.
    along: vec2f,
    // Full lengths along it and across.
    length: f32,
    width: f32,
}

// One piece of the parallelogram's middle line, from a to b along it: the stretch of radius it covers.
fn piece(f: RingFootprint, a: f32, b: f32) -> RingStretch {
    let across = vec2f(-f.along.y, f.along.x);
    let nearest = -dot(f.middle, f.along);
    let aside = abs(dot(f.middle, across));
    let inner = length(vec2f(aside, nearest - clamp(nearest, a, b)));
    let outer = length(vec2f(aside, max(abs(a - nearest), abs(b - nearest))));
    let centre = f.middle + f.along * (0.5 * (a + b));
    let tilt = abs(dot(centre, across)) * inverseSqrt(max(dot(centre, centre), 1.0e-12));
    let spread = 0.5 * f.width * tilt;
    return ring_stretch(max(inner - spread, 0.0), outer + spread);
}

@fragment
fn fragment_main(in: Varyings) -> Pixel {
    let slant = length(in.ray);
    let along = in.ray / slant;
    // Where the ray meets the plane z = 0; a ray within 1e-6 of it counts as that steep.
    let rise = select(min(along.z, -1.0e-6), max(along.z, 1.0e-6), along.z >= 0.0);
    let reach = -in.anchor.z / rise;
    let met = in.anchor + along * reach;
    // Change of the meeting point from pixel to pixel: the rays turn and their anchors move; the plane holds z.
    let step_x = dpdx(in.anchor) + dpdx(in.ray) * (reach / slant);
    let step_y = dpdy(in.anchor) + dpdy(in.ray) * (reach / slant);
    let dx = step_x.xy - along.xy * (step_x.z / rise);
    let dy = step_y.xy - along.xy * (step_y.z / rise);
    let flat_length = length(along.xy);
    var f: RingFootprint;
    f.middle = met.xy;
    f.along = select(vec2f(1.0, 0.0), along.xy / max(flat_length, 1.0e-9), flat_length > 1.0e-6);
    let across = vec2f(-f.along.y, f.along.x);
    f.length = max(length(vec2f(dot(dx, f.along), dot(dy, f.along))), 1.0e-9);
    f.width = length(vec2f(dot(dx, across), dot(dy, across)));
    let distance_row = dot(draw.depth_row.xyz, vec3f(met.xy, 0.0)) + draw.depth_row.w;

    // Only the part of it inside the ring's outer edge counts.
    let edge = draw.ring_reach.y + 0.5 * f.width;
    let nearest = -dot(f.middle, f.along);
    let aside = dot(f.middle, across);
    let half_chord = sqrt(max(edge * edge - aside * aside, 0.0));
    // The half before or behind the body's centre. A pixel goes to one of them as a whole, or two half-filled layers would let the sky through
    // between them; seen so nearly edge-on that the globe stands within a pixel's stretch, it is cut.
    let cut = select(nearest, select(-1.0e9, 1.0e9, nearest > 0.0), f.length < 0.1);
    let first = max(nearest - half_chord, select(-1.0e9, cut, draw.ring_half < 0.0));
    let last = min(nearest + half_chord, select(1.0e9, cut, draw.ring_half > 0.0));
    let from_here = clamp(first, -0.5 * f.length, 0.5 * f.length);
    let to_here = clamp(last, -0.5 * f.length, 0.5 * f.length);
    let inside = (to_here - from_here) / f.length;
    if inside <= 0.0 || half_chord <= 0.0 || distance_row <= 0.0 {
        discard;
    }

    let cos_emission = max(abs(along.z), LEAST_COSINE);
    // Pieces of a sixteenth of a radius; the last one is what is left, so that nothing jumps where it begins.
    let pieces = clamp((to_here - from_here) * 16.0, 1.0, 8.0);
    let stride = (to_here - from_here) / pieces;
    var opacity = vec4f(0.0);
    var light = vec3f(0.0);
//: if lights.1
    let sun = draw.light_direction[0].xyz;
    let side = select(-1.0, 1.0, sun.z * along.z < 0.0);
//: end
    for (var k = 0.0; k < pieces; k += 1.0) {
        let ends = min(from_here + stride * vec2f(k, k + 1.0), vec2f(to_here));
        let share = (ends.y - ends.x) / f.length;
        let stretch = piece(f, ends.x, ends.y);
        opacity += share * ring_opacity(stretch, 1.0 / cos_emission);
//: if view.albedo
        opacity += vec4f(share * ring_stopped(stretch, DUST, 1.0 / cos_emission).rgb, 0.0);
//: end
//: if lights.1
  //: if view.shaded
        light += share * ring_reflectance(stretch, cos_emission, abs(sun.z), side, -dot(sun, along));
  //: end
//: end
    }
    let coverage = clamp(opacity.w, 0.0, 1.0);
    let place = vec3f(f.middle + f.along * (0.5 * (from_here + to_here)), 0.0);

    // Premultiplied from here on.
    var radiance = vec3f(0.0);
//: if lights.1
    var sunlight = draw.light_irradiance[0].rgb;
  //: if eclipse.1|body-shadow.sphere|body-shadow.ellipsoid-penumbra
    sunlight *= sunlight_reaching(place);
  //: end
  //: if view.shaded
    radiance = light * sunlight * draw.albedo;
  //: end
  //: if view.sunlight
    radiance = sunlight * abs(draw.light_direction[0].z) * coverage;
  //: end
  //: if view.eclipse
    radiance = sunlight / draw.light_irradiance[0].rgb * coverage;
  //: end
//: end
//: if view.depth
    // As on the globe, in the ring's extent.
    let extent = max(length(draw.depth_row.xyz) * draw.ring_reach.y, 1.0e-30);
    radiance = vec3f(clamp(0.5 - 0.5 * dot(draw.depth_row.xyz, place) / extent, 0.0, 1.0) * coverage);
//: end
//: if view.normal
    radiance = (0.5 + 0.5 * vec3f(0.0, 0.0, -sign(rise))) * coverage;
//: end
//: if view.albedo
    radiance = opacity.rgb * draw.albedo;
//: end
//: if view.uv
    let between = (length(place) - draw.ring_reach.x) / (draw.ring_reach.y - draw.ring_reach.x);
    radiance = vec3f(clamp(between, 0.0, 1.0), 0.5 + atan2(place.y, place.x) * 0.15915494, 0.0) * coverage;
//: end
//: if view.optical-depth
    radiance = vec3f(-log(max(1.0 - coverage, 1.0e-6)) * coverage);
//: end
//: if view.ring
    // The optical depth along the view, as the opacity that it makes.
    radiance = vec3f(coverage * coverage);
//: end

    var pixel: Pixel;
    pixel.colour = vec4f(radiance, coverage);
    pixel.depth = clamp(1.0 / max(dot(draw.depth_row.xyz, place) + draw.depth_row.w, 1.0e-20), 0.0, 1.0);
    return pixel;
}
