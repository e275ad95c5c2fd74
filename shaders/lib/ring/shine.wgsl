// Light that the ring sends onto its planet, from the table that scene/ring_shine.rs sums in f64.
//
// Rows are heights over the ring's plane, close together at the equator (squares), those of the Sun's side first; columns are hour angles from
// the Sun, even in angle. Texels hold light over height, so that the equator, which sees the ring's edge, gets none. Linear between them: off by
// 1 % of the brightest place at most (tests/rings/ring_shine.rs).

//: use lib/draw.wgsl

@group(0) @binding(6) var ring_shine_table: texture_2d<f32>;

const SHINE_ROWS: f32 = 25.0;
const SHINE_COLUMNS: f32 = 33.0;

// Irradiance of level ground per unit of sunlight. `position`: unit-sphere frame.
fn ring_shine(position: vec3f) -> vec3f {
    let height = abs(position.z);
    let row = sqrt(min(height * draw.ring_shine.z, 1.0)) * (SHINE_ROWS - 1.0);
    let sunward = dot(position.xy, draw.ring_shine.xy);
    let aside = abs(position.x * draw.ring_shine.y - position.y * draw.ring_shine.x);
    // At the pole itself there is no hour angle, and no ring in sight.
    let hour = atan2(aside, select(sunward, 1.0, aside + abs(sunward) == 0.0)) * 0.31830989;
    let column = clamp(hour, 0.0, 1.0) * (SHINE_COLUMNS - 1.0);
    let low = vec2f(min(floor(column), SHINE_COLUMNS - 2.0), min(floor(row), SHINE_ROWS - 2.0));
    let part = vec2f(column, row) - low;
    let side = select(SHINE_ROWS, 0.0, position.z * draw.light_direction[0].z >= 0.0);
    let at = vec2i(low + vec2f(0.0, side));
    let lower = mix(textureLoad(ring_shine_table, at, 0).rgb, textureLoad(ring_shine_table, at + vec2i(1, 0), 0).rgb, part.x);
    let upper = mix(textureLoad(ring_shine_table, at + vec2i(0, 1), 0).rgb, textureLoad(ring_shine_table, at + vec2i(1, 1), 0).rgb, part.x);
    return mix(lower, upper, part.y) * (height * draw.ring_shine.w);
}
