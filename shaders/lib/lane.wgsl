// One question a column of the target: its numbers come as instance attributes, its answers go out as the rows of the column.
//
// Twelve numbers a question. Each is the sum of a high and a low part, so that the f64 run sees all its digits; in f32 the low part
// rounds away.

//: use lib/rectangle.wgsl

struct Varyings {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) a: vec4f,
    @location(1) @interpolate(flat) b: vec4f,
    @location(2) @interpolate(flat) c: vec4f,
    @location(3) @interpolate(flat) a_low: vec4f,
    @location(4) @interpolate(flat) b_low: vec4f,
    @location(5) @interpolate(flat) c_low: vec4f,
}

// `span`: clip x of the column's left and right edge.
@vertex
fn vertex_main(
    @builtin(vertex_index) index: u32,
    @location(0) span: vec2f,
    @location(1) a: vec4f,
    @location(2) b: vec4f,
    @location(3) c: vec4f,
    @location(4) a_low: vec4f,
    @location(5) b_low: vec4f,
    @location(6) c_low: vec4f,
) -> Varyings {
    let corner = rectangle_corner(index);
    var out: Varyings;
    out.position = vec4f(mix(span.x, span.y, corner.x), 1.0 - 2.0 * corner.y, 0.0, 1.0);
    out.a = a;
    out.b = b;
    out.c = c;
    out.a_low = a_low;
    out.b_low = b_low;
    out.c_low = c_low;
    return out;
}

struct Question {
    a: vec4f,
    b: vec4f,
    c: vec4f,
    // Which answer is asked for, from 0.
    row: i32,
}

fn question(in: Varyings) -> Question {
    return Question(in.a + in.a_low, in.b + in.b_low, in.c + in.c_low, i32(floor(in.position.y)));
}
