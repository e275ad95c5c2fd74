// The Sun's light past the bodies before it.
//
// Everything counts from the axis through the lit body's centre and the Sun's: a point and a caster enter by their offsets from it, so that
// no small angle is ever the difference of two directions. Casters' outlines are those of parallel light along the axis: over the Sun's
// disc that moves a limb by less than (angular radius of the Sun)^2 / 2 of the caster's size.

//: use lib/draw.wgsl
//: use lib/eclipse/silhouette.wgsl
//: if eclipse.linear
//: use lib/eclipse/linear.wgsl
//: else
//: use lib/eclipse/overlap.wgsl
//: end
//: if eclipse.refracted
//: use lib/eclipse/refraction.wgsl
//: end

// Solar radii on the sky per equatorial radius at a depth towards the Sun.
fn scale_at(depth: f32, along: f32) -> f32 {
    return draw.eclipse_across[0].w * (1.0 - along * draw.eclipse_axis.w) / depth;
}

// `place`: the caster's centre across the axis (xy) and along it (z); `shape`: unit vector of its long axis (xy), semi-axes (zw);
// equatorial radii. `across`, `along`: the lit point.
fn before_sun(place: vec4f, shape: vec4f, across: vec2f, along: f32) -> Silhouette {
    let depth = place.z - along;
    let scale = scale_at(depth, along);
    var s: Silhouette;
    s.axis = shape.xy;
    let behind = depth <= 0.0;
    s.centre = select((place.xy - across) * scale + across * draw.eclipse_across[1].w, vec2f(1.0e6), behind);
    s.semi = select(shape.zw * scale, vec2f(0.0), behind);
    return s;
}

//: if eclipse.linear
//: else
// Light of a part of the Sun's disc, from its integrals.
fn light_of(part: vec3f) -> vec3f {
    return draw.eclipse_limb[0].xyz * part.x + draw.eclipse_limb[1].xyz * part.y + draw.eclipse_limb[2].xyz * part.z;
}

fn left_of(o: Overlap) -> vec3f {
    return part_left(o, light_of(o.hidden), light_of(o.left), light_of(WHOLE_SUN));
}
//: end

//: if eclipse.2
// Whether two outlines may meet.
fn may_meet(s: Silhouette, t: Silhouette) -> bool {
    let reach = s.semi.x + t.semi.x;
    let apart = s.centre - t.centre;
    return near_sun(s) && near_sun(t) && dot(apart, apart) < reach * reach;
}
//: end

// Per channel. `position`: body axes, equatorial radii.
fn eclipse_light(position: vec3f) -> vec3f {
    let across = vec2f(dot(position, draw.eclipse_across[0].xyz), dot(position, draw.eclipse_across[1].xyz));
    let along = dot(position, draw.eclipse_axis.xyz);
    let s0 = before_sun(draw.caster_place[0], draw.caster_shape[0], across, along);
    var near = near_sun(s0);
//: if eclipse.2
    let s1 = before_sun(draw.caster_place[1], draw.caster_shape[1], across, along);
    near = near || near_sun(s1);
    var meet = may_meet(s0, s1);
//: end
//: if eclipse.3
    let s2 = before_sun(draw.caster_place[2], draw.caster_shape[2], across, along);
    near = near || near_sun(s2);
    meet = meet || may_meet(s0, s2) || may_meet(s1, s2);
//: end
//: if eclipse.4
    let s3 = before_sun(draw.caster_place[3], draw.caster_shape[3], across, along);
    near = near || near_sun(s3);
    meet = meet || may_meet(s0, s3) || may_meet(s1, s3) || may_meet(s2, s3);
//: end
    var light = vec3f(1.0);
    if near {
//: if eclipse.linear
        var hidden = ramp_hidden_by(s0);
  //: if eclipse.2
        var most = hidden;
        let h1 = ramp_hidden_by(s1);
        hidden += h1;
        most = max(most, h1);
    //: if eclipse.3
        let h2 = ramp_hidden_by(s2);
        hidden += h2;
        most = max(most, h2);
    //: end
    //: if eclipse.4
        let h3 = ramp_hidden_by(s3);
        hidden += h3;
        most = max(most, h3);
    //: end
        // What two hide both counts once.
        if meet {
            hidden -= ramp_hidden_by_both(s0, s1);
    //: if eclipse.3
            hidden -= ramp_hidden_by_both(s0, s2) + ramp_hidden_by_both(s1, s2);
    //: end
    //: if eclipse.4
            hidden -= ramp_hidden_by_both(s0, s3) + ramp_hidden_by_both(s1, s3) + ramp_hidden_by_both(s2, s3);
    //: end
            hidden = max(hidden, most);
        }
  //: end
        light = vec3f(1.0 - min(hidden, 1.0));
//: else
  //: if eclipse.2
        let o0 = overlap_if_near(s0);
        let o1 = overlap_if_near(s1);
        // Apart: each hides its own.
        var all = both_apart(o0, o1);
        var least = min(o0.left.x, o1.left.x);
    //: if eclipse.3
        let o2 = overlap_if_near(s2);
        all = both_apart(all, o2);
        least = min(least, o2.left.x);
    //: end
    //: if eclipse.4
        let o3 = overlap_if_near(s3);
        all = both_apart(all, o3);
        least = min(least, o3.left.x);
    //: end
        if meet {
    //: if eclipse.4
            all = hidden_together(s0, s1, s2, s3);
    //: else
      //: if eclipse.3
            all = hidden_together(s0, s1, s2);
      //: else
            all = hidden_together(s0, s1);
      //: end
    //: end
            // What one hides alone stays hidden.
            if least <= 0.0 {
                all = Overlap(WHOLE_SUN, vec3f(0.0));
            }
        }
        light = left_of(all);
  //: else
        light = left_of(overlap_of(s0));
  //: end
//: end
    }
//: if eclipse.refracted
    let depth = draw.caster_place[0].z - along;
    light += refracted_light(s0.centre, depth, scale_at(depth, along));
//: end
    return light;
}

//: if eclipse.2
  //: if eclipse.linear
  //: else
fn overlap_if_near(s: Silhouette) -> Overlap {
    var o = Overlap(vec3f(0.0), WHOLE_SUN);
    if near_sun(s) {
        o = overlap_of(s);
    }
    return o;
}
  //: end
//: end
