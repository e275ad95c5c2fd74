// What casters leave of the light that the air scatters many times: in an umbra that which comes from the lit air around it.
//
// The tables are those of src/scene/air_spread.rs, the roots of factors: for each caster 4 rows of heights and one of the ground, 16 distances from its limb each.

//: use lib/draw.wgsl
//: use lib/air/columns.wgsl
//: use lib/air/path.wgsl
//: use lib/air/shaded.wgsl
//: use lib/air/many.wgsl

//: if eclipse.1
//: use lib/eclipse/casters.wgsl

const SPREAD_NODES = 80u;
const SPREAD_GROUND = 4.0;

// Per channel. `row`: 0 to 3 at the heights of lib/air/many.wgsl's rows, 4 on the ground.
fn spread_past(caster: u32, s: Silhouette, row: f32) -> vec3f {
    let reach = draw.caster_spread[4u * SPREAD_NODES + caster];
    // From the outline, along the line to its centre.
    let turned = vec2f(dot(s.centre, s.axis), s.centre.y * s.axis.x - s.centre.x * s.axis.y) + vec2f(1.0e-6);
    let apart = length(turned);
    let edge = apart - apart / max(length(turned / max(s.semi, vec2f(1.0e-9))), 1.0e-9);
    let part = (edge - reach.x) * reach.y;
    if part >= 1.0 || s.semi.x <= 0.0 {
        return vec3f(1.0);
    }
    let column = 15.0 * sqrt(max(part, 0.0));
    let c = min(u32(column), 14u);
    let r = min(u32(row), 3u);
    let k = caster * SPREAD_NODES + r * 16u + c;
    let below = mix(draw.caster_spread[k].rgb, draw.caster_spread[k + 1u].rgb, column - f32(c));
    let above = mix(draw.caster_spread[k + 16u].rgb, draw.caster_spread[k + 17u].rgb, column - f32(c));
    let root = mix(below, above, row - f32(r));
    return root * root;
}

// `position`: body axes, equatorial radii.
fn spread_reaching(position: vec3f, row: f32) -> vec3f {
    let across = vec2f(dot(position, draw.eclipse_across[0].xyz), dot(position, draw.eclipse_across[1].xyz));
    let along = dot(position, draw.eclipse_axis.xyz);
    var part = spread_past(0u, before_sun(draw.caster_place[0], draw.caster_shape[0], across, along), row);
//: if eclipse.2
    part *= spread_past(1u, before_sun(draw.caster_place[1], draw.caster_shape[1], across, along), row);
//: end
//: if eclipse.3
    part *= spread_past(2u, before_sun(draw.caster_place[2], draw.caster_shape[2], across, along), row);
//: end
//: if eclipse.4
    part *= spread_past(3u, before_sun(draw.caster_place[3], draw.caster_shape[3], across, along), row);
//: end
    return part;
}
//: end

// At a place on a view ray: its distance and excess.
fn many_left(path: AirPath, s: f32, excess: f32) -> vec3f {
//: if eclipse.1
  //: if shape.ellipsoid
    let position = (path.nearest + s * path.along) * draw.axis_ratios;
  //: else
    let position = path.nearest + s * path.along;
  //: end
    let left = spread_reaching(position, min(many_row(height_of(excess)), 3.0));
  //: if eclipse.refracted
    return max(left, shaded_air(path, s));
  //: else
    return left;
  //: end
//: else
    return shaded_air(path, s);
//: end
}
