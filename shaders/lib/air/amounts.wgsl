// Of the block in lib/draw.wgsl: the air at night, and in the shadow of other bodies.

//: if air.vertex|air.pixel-8|air.pixel-16|air.pixel-32|air.table
  //: if lights.1
    // Radiance of the night sky.
    air_night: f32,
  //: end
//: end
//: if eclipse.1
  //: if air.table
    // Roots of what each caster leaves of light scattered many times, and for each where the columns begin and one over how far they reach: lib/air/spread.wgsl.
    //: if eclipse.4
    caster_spread: array<vec4f, 320>,
    caster_spread_reach: array<vec4f, 4>,
    //: else
      //: if eclipse.3
    caster_spread: array<vec4f, 240>,
    caster_spread_reach: array<vec4f, 3>,
      //: else
        //: if eclipse.2
    caster_spread: array<vec4f, 160>,
    caster_spread_reach: array<vec4f, 2>,
        //: else
    caster_spread: array<vec4f, 80>,
    caster_spread_reach: array<vec4f, 1>,
        //: end
      //: end
    //: end
  //: end
//: end
