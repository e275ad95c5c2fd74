//! The tape against the semantics of WGSL: most tests lower a small fragment shader, run it on every kernel class and compare each lane with the value
//! that Rust computes for it. A `tolerance` is a fraction of the value, or of 1 if the value is smaller.

use orrery::render::software::exec::{Executor, Gradients, LANES, LaneMask, NoTextures, TextureUnit};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::lower::{lower, lower_to_bytes, lower_with, programs_from_bytes};
use orrery::render::software::math::Real;
use orrery::render::software::program::{LaneInput, LaneOutput, Program};
use orrery::render::software::tape::{FusedOp, Instr, Op, Operand};

pub(super) const ALL: LaneMask = LaneMask::MAX;

fn parse(wgsl: &str) -> (naga::Module, naga::valid::ModuleInfo) {
    let module = naga::front::wgsl::parse_str(wgsl).unwrap_or_else(|e| panic!("{}", e.emit_to_string(wgsl)));
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32);
    let info = validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(wgsl)));
    (module, info)
}

pub(super) fn compile(wgsl: &str) -> Program {
    let (module, info) = parse(wgsl);
    let name = module.entry_points[0].name.clone();
    let program = lower(&module, &info, &name).unwrap_or_else(|e| panic!("{e}"));
    let bytes = lower_to_bytes(&module, &info).expect("lowers to bytes");
    assert_eq!(programs_from_bytes(&bytes).expect("reads back")[0], program, "the bytes encode another program");
    program
}

/// Lane values: x rises by 0.25 per lane from 0, y falls by 0.5 per lane from 10.
pub(super) fn lane_x(i: usize) -> f32 {
    i as f32 * 0.25
}

pub(super) fn lane_y(i: usize) -> f32 {
    10.0 - i as f32 * 0.5
}

/// Runs a program on one batch, with NaN in inputs that it does not read; returns the outputs of each lane, and the lanes that were active and not discarded.
pub(super) fn run_with<R: Real>(
    program: &Program,
    class: KernelClass,
    uniform_bytes: &[u8],
    active: LaneMask,
    textures: &dyn TextureUnit<R>,
) -> (Vec<Vec<f64>>, LaneMask) {
    let mut executor = Executor::<R>::with_class(program, class).expect("binds");
    let prepared = program.run_draw_tape::<R>(uniform_bytes, class, textures);
    for (k, input) in program.inputs.iter().enumerate() {
        if !executor.reads_input(k) {
            executor.set_input_constant(k, R::from_f64(f64::NAN));
            continue;
        }
        let values = executor.input_mut(k);
        for (i, v) in values.iter_mut().enumerate() {
            *v = match input {
                LaneInput::Location { component: 0, .. } => R::from_f64(f64::from(lane_x(i))),
                LaneInput::Location { .. } => R::from_f64(f64::from(lane_y(i))),
                LaneInput::FragCoord { component } => R::from_f64((i * 4 + *component as usize) as f64),
                LaneInput::FrontFacing => R::from_mask(i % 3 == 0),
                _ => R::from_lane_bits(i as u32),
            };
        }
    }
    let alive = executor.run(&prepared, active, textures);
    let lanes = (0..LANES).map(|i| (0..program.outputs.len()).map(|k| executor.output(k)[i].to_f64()).collect()).collect();
    (lanes, alive)
}

/// Runs `body` (it sees `p: vec2f` and returns a vec4f) on all classes and in both precisions, and checks every lane.
pub(super) fn check(declarations: &str, body: &str, tolerance: f64, expected: impl Fn(f64, f64) -> [f64; 4]) {
    check_uniform(declarations, body, &[], tolerance, expected);
}

/// [`check`] of a shader whose uniform block has these bytes.
pub(super) fn check_uniform(declarations: &str, body: &str, uniform_bytes: &[u8], tolerance: f64, expected: impl Fn(f64, f64) -> [f64; 4]) {
    let wgsl = format!("{declarations}\n@fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {{\n{body}\n}}");
    let program = compile(&wgsl);
    let compare = |lanes: &[Vec<f64>], tolerance: f64, what: &str| {
        for (i, found) in lanes.iter().enumerate() {
            let value = expected(f64::from(lane_x(i)), f64::from(lane_y(i)));
            for k in 0..4 {
                let same = found[k] == value[k] || (found[k].is_nan() && value[k].is_nan());
                let close = (found[k] - value[k]).abs() <= tolerance * value[k].abs().max(1.0);
                assert!(same || close, "{what}, lane {i}, component {k}: {} instead of {}\n{wgsl}", found[k], value[k]);
            }
        }
    };
    // The values of all lanes by the first class without fused multiply-add, and by the first class with it.
    let mut by_rounding: [Option<Vec<Vec<f64>>>; 2] = [None, None];
    for class in KernelClass::available() {
        let (lanes, alive) = run_with::<f32>(&program, class, uniform_bytes, ALL, &NoTextures);
        assert_eq!(alive, ALL);
        compare(&lanes, tolerance, class.name());
        let first = by_rounding[usize::from(class.has_fma())].get_or_insert_with(|| lanes.clone());
        assert!(same_bits(first, &lanes), "{}: the bits differ from those of another class that rounds alike", class.name());
        let (double, _) = run_with::<f64>(&program, class, uniform_bytes, ALL, &NoTextures);
        compare(&double, tolerance, "f64");
    }
}

fn same_bits(a: &[Vec<f64>], b: &[Vec<f64>]) -> bool {
    a.iter().flatten().map(|x| x.to_bits()).eq(b.iter().flatten().map(|x| x.to_bits()))
}

#[test]
fn arithmetic_and_comparisons_follow_wgsl() {
    check("", "let a = p.x * 3.0 - p.y / 2.0; let b = -p.x; return vec4f(a, b, p.x % 0.7, select(1.0, 2.0, p.x > p.y));", 1e-5, |x, y| {
        [x * 3.0 - y / 2.0, -x, f64::from(x as f32 % 0.7), if x > y { 2.0 } else { 1.0 }]
    });
    check(
        "",
        "let c = p > vec2f(3.0, 2.0); let d = !c.x || (c.y && p.x != p.y); return vec4f(f32(c.x), f32(c.y), f32(d), f32(all(c) == any(c)));",
        0.0,
        |x, y| {
            let (c, d) = (x > 3.0, y > 2.0);
            let f = |b: bool| if b { 1.0 } else { 0.0 };
            [f(c), f(d), f(!c || (d && x != y)), f((c && d) == (c || d))]
        },
    );
}

#[test]
fn integers_follow_wgsl() {
    check(
        "",
        "let i = i32(p.y); let u = u32(p.x); let z = i - i;
         return vec4f(f32(i / -3), f32(i % 3), f32((u << 3u) ^ (u >> 1u)), f32(i / z + i % z));",
        0.0,
        |x, y| {
            let (i, u) = (y as i32, x as u32);
            [f64::from(i / -3), f64::from(i % 3), f64::from((u << 3) ^ (u >> 1)), f64::from(i)]
        },
    );
    check(
        "",
        "let i = bitcast<i32>(p.x); return vec4f(bitcast<f32>(i), f32(u32(-p.x)), f32(i32(p.y * 1e12)), f32(~u32(p.x)));",
        1e-6,
        |x, y| [x, 0.0, f64::from((y * 1e12) as i32), f64::from(!(x as u32))],
    );
}

#[test]
fn bit_and_packing_functions_follow_wgsl() {
    check(
        "",
        "let u = u32(p.x) * 0x01010101u; let i = i32(p.y);
         return vec4f(f32(countOneBits(u)), f32(countLeadingZeros(u)), f32(countTrailingZeros(u)), f32(firstLeadingBit(i)));",
        0.0,
        |x, y| {
            let u = (x as u32).wrapping_mul(0x0101_0101);
            let i = y as i32;
            let first = if i == 0 || i == -1 { -1.0 } else { f64::from(31 - (if i < 0 { !i } else { i }).leading_zeros()) };
            [f64::from(u.count_ones()), f64::from(u.leading_zeros()), f64::from(u.trailing_zeros()), first]
        },
    );
    check(
        "",
        "let u = u32(p.x) * 0x9e3779b9u; return vec4f(f32(extractBits(u, 5u, 7u)), f32(extractBits(bitcast<i32>(u), 28u, 9u)),
           f32(insertBits(u, 5u, 4u, 8u) & 0xffffu), f32(reverseBits(u) & 0xffffu));",
        0.0,
        |x, _| {
            let u = (x as u32).wrapping_mul(0x9e37_79b9);
            let inserted = (u & !0xff0) | (5 << 4);
            [f64::from((u >> 5) & 127), f64::from((u as i32) >> 28), f64::from(inserted & 0xffff), f64::from(u.reverse_bits() & 0xffff)]
        },
    );
    check("", "return unpack4x8unorm(pack4x8unorm(vec4f(p.x / 32.0, p.y / 10.0, 0.5, 2.0)));", 0.5 / 255.0 + 1e-6, |x, y| {
        [x / 32.0, (y / 10.0).max(0.0), 0.5, 1.0]
    });
    check("", "let q = unpack2x16float(pack2x16float(p)); return vec4f(q, quantizeToF16(p.y), 0.0);", 1e-3, |x, y| [x, y, y, 0.0]);
}

#[test]
fn matrices_and_vectors_follow_wgsl() {
    check(
        "",
        "let m = mat3x3f(p.x, 1.0, 2.0, 3.0, p.y, 5.0, 6.0, 7.0, p.x); let v = vec3f(1.0, p.x, p.y);
         let t = transpose(m); let w = m * v; let z = v * t; let q = (m * t)[1];
         return vec4f(w.x, w.y - z.y, q.z, determinant(m));",
        2e-5,
        |x, y| {
            let m = [[x, 1.0, 2.0], [3.0, y, 5.0], [6.0, 7.0, x]];
            let det = x * (y * x - 7.0 * 5.0) - 3.0 * (x - 7.0 * 2.0) + 6.0 * (5.0 - y * 2.0);
            // (m t)[1].z = sum over k of m[k].z * t[1][k] with t[1][k] = m[k].y
            let q = m[0][2] * m[0][1] + m[1][2] * m[1][1] + m[2][2] * m[2][1];
            [m[0][0] + m[1][0] * x + m[2][0] * y, 0.0, q, det]
        },
    );
    check(
        "",
        "let a = vec3f(p, 1.0); let b = vec3f(1.0, p.y, -2.0); let n = normalize(a);
         return vec4f(dot(cross(a, b), a), length(n), distance(a, b), dot(reflect(a, vec3f(0.0, 1.0, 0.0)), vec3f(1.0, 1.0, 1.0)));",
        2e-5,
        |x, y| [0.0, 1.0, ((x - 1.0).powi(2) + 9.0).sqrt(), x - y + 1.0],
    );
}

#[test]
fn pointers_arrays_and_structs_follow_wgsl() {
    check(
        "struct S { a: vec2f, b: array<f32, 4> }
         fn bump(v: ptr<function, f32>, by: f32) { if (by > 4.0) { return; } *v += by; }
         fn make(p: vec2f) -> S { var s: S; s.a = p.yx; for (var i = 0; i < 4; i++) { s.b[i] = f32(i) * p.x; } return s; }
         var<private> total: f32 = 2.0;",
        "var s = make(p); bump(&s.b[2], p.x); s.b[u32(p.x) % 4u] = -1.0; total += s.a.x;
         const table = array<f32, 3>(3.0, 5.0, 7.0); return vec4f(s.b[2], s.b[u32(p.y + 60.0) % 4u], total, table[u32(p.x) % 3u]);",
        1e-6,
        |x, y| {
            let mut b = [0.0, x, 2.0 * x, 3.0 * x];
            b[2] += if x > 4.0 { 0.0 } else { x };
            b[x as usize % 4] = -1.0;
            [b[2], b[(y + 60.0) as usize % 4], 2.0 + y, [3.0, 5.0, 7.0][x as usize % 3]]
        },
    );
}

#[test]
fn shaping_functions_follow_wgsl() {
    check("", "return vec4f(mix(p.x, p.y, 0.25), clamp(p.x, 1.0, 3.0), smoothstep(2.0, 6.0, p.x), step(p.y, p.x));", 1e-6, |x, y| {
        let t = ((x - 2.0) / 4.0).clamp(0.0, 1.0);
        [0.75 * x + 0.25 * y, x.clamp(1.0, 3.0), t * t * (3.0 - 2.0 * t), if x >= y { 1.0 } else { 0.0 }]
    });
    check("", "return vec4f(floor(p.y) + fract(p.y), round(p.y), trunc(p.y) + ceil(p.y), sign(p.y));", 0.0, |_, y| {
        [y, y.round_ties_even(), y.trunc() + y.ceil(), if y == 0.0 { 0.0 } else { y.signum() }]
    });
    check("", "let m = modf(p.y); return vec4f(m.fract, m.whole, ldexp(p.x, 3), degrees(radians(p.x)));", 1e-6, |x, y| {
        [y.fract(), y.trunc(), 8.0 * x, x]
    });
    check(
        "",
        "let r = refract(normalize(vec3f(p.x, 1.0, 0.0)), vec3f(0.0, -1.0, 0.0), 0.8); return vec4f(r.x, length(r), 0.0, 0.0);",
        1e-5,
        |x, _| [0.8 * x / (x * x + 1.0).sqrt(), 1.0, 0.0, 0.0],
    );
}

#[test]
fn derivatives_are_quad_differences() {
    let program = compile(
        "@fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f { let q = p.x * p.x; return vec4f(dpdx(q), dpdy(q), fwidth(q), dpdx(1.0)); }",
    );
    assert!(program.uses_derivatives);
    for class in KernelClass::available() {
        let (lanes, _) = run_with::<f32>(&program, class, &[], ALL, &NoTextures);
        for (i, lane) in lanes.iter().enumerate() {
            let q = |i: usize| f64::from(lane_x(i)).powi(2);
            let (dx, dy) = (q(i | 1) - q(i & !1), q(i | 2) - q(i & !2));
            assert_eq!(lane, &vec![dx, dy, dx.abs() + dy.abs(), 0.0], "lane {i}");
        }
    }
}

/// A texture source that returns its own arguments.
struct EchoTextures;

/// Writes the values of each lane. A channel that was not requested has no lanes.
fn write_channels<R: Real>(out: [&mut [R]; 4], of_lane: impl Fn(usize) -> [R; 4]) {
    for (k, to) in out.into_iter().enumerate() {
        to.iter_mut().enumerate().for_each(|(i, to)| *to = of_lane(i)[k]);
    }
}

impl<R: Real> TextureUnit<R> for EchoTextures {
    fn sample_gradients(&self, texture: usize, u: &[R], v: &[R], g: Gradients<'_, R>, _: LaneMask, out: [&mut [R]; 4]) {
        let number = R::from_f64(100.0 * texture as f64);
        write_channels(out, |i| [u[i] + v[i] + number, g.du_dx[i], g.dv_dy[i], g.du_dy[i] + g.dv_dx[i]]);
    }
    fn sample_level(&self, _: usize, u: &[R], v: &[R], level: &[R], _: LaneMask, out: [&mut [R]; 4]) {
        write_channels(out, |i| [u[i], v[i], level[i], R::ONE]);
    }
    fn load_bilinear(&self, _: usize, at: [&[R]; 2], _: LaneMask, out: [&mut [R]; 4]) {
        write_channels(out, |i| [at[0][i], at[1][i], R::ZERO, R::ONE]);
    }
    fn load(&self, _: usize, x: &[R], y: &[R], level: &[R], active: LaneMask, out: [&mut [R]; 4]) {
        let of_lane = |values: &[R], lane: usize| values[if values.len() == 1 { 0 } else { lane }].lane_bits();
        write_channels(out, |i| [of_lane(x, i), of_lane(y, i), of_lane(level, i), (active >> i & 1) as u32].map(R::from_u32));
    }
    fn dimensions(&self, _: usize, level: u32) -> [u32; 2] {
        [64 >> level, 32 >> level]
    }
    fn levels(&self, _: usize) -> u32 {
        7
    }
}

#[test]
fn inactive_lanes_are_skipped_unless_derivatives_need_them() {
    let program = |rest: &str| {
        compile(&format!(
            "@group(0) @binding(1) var t: texture_2d<f32>; @group(0) @binding(8) var s: sampler;
            @fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {{ let q = p.x * p.x; if (p.y > -50.25) {{ discard; }} {rest} }}"
        ))
    };
    let reads = |program: &Program| {
        let mut executor = Executor::<f32>::with_class(program, KernelClass::in_use()).expect("binds");
        (0..program.inputs.len()).for_each(|k| executor.set_input_constant(k, 1.0));
        let alive = executor.run(&program.run_draw_tape::<f32>(&[], KernelClass::in_use(), &EchoTextures), ALL, &EchoTextures);
        assert_eq!(alive, 0);
        executor.counts().texture_reads
    };
    assert_eq!(reads(&program("return textureSampleLevel(t, s, p, q);")), 0, "no lane is active");
    assert_eq!(reads(&program("return textureSample(t, s, p);")), 1, "the sampler needs differences between lanes");
    // y falls by 0.5 per lane from 10, so lanes 0 to 120 are discarded; lane 121 needs the value of lane 120 for its derivative.
    let program = program("return vec4f(dpdx(q), 0.0, 0.0, 1.0);");
    let (lanes, alive) = run_with::<f32>(&program, KernelClass::in_use(), &[], ALL, &NoTextures);
    assert_eq!(alive, ALL << 121);
    let q = |i: usize| f64::from(lane_x(i)).powi(2);
    assert_eq!(lanes[121][0], q(121) - q(120), "the inactive lane 120 provides its value");
}

#[test]
fn textures_get_their_arguments() {
    let head =
        "@group(0) @binding(1) var t: texture_2d<f32>; @group(0) @binding(2) var t2: texture_2d<f32>; @group(0) @binding(8) var s: sampler;
        @fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {";
    let run = |body: &str| {
        let program = compile(&format!("{head} {body} }}"));
        (run_with::<f32>(&program, KernelClass::in_use(), &[], ALL, &EchoTextures).0, program)
    };
    let (lanes, program) = run("return textureSample(t, s, p);");
    assert!(program.uses_derivatives && program.textures[0].sampler_binding == Some(8));
    assert_eq!(lanes[5], [f64::from(lane_x(5) + lane_y(5)), 0.25, -1.0, 0.5 - 0.5]);
    let (lanes, _) = run("return textureSampleBias(t, s, p, 2.0);");
    assert_eq!(lanes[5][1..3], [1.0, -4.0]);
    let (lanes, program) = run("return textureSampleGrad(t, s, p, vec2f(1.0, 2.0), vec2f(p.x, 4.0)) + textureSampleLevel(t2, s, p, 3.0);");
    assert_eq!(program.textures.len(), 2);
    let (x, y) = (f64::from(lane_x(7)), f64::from(lane_y(7)));
    assert_eq!(lanes[7], [x + y + x, 1.0 + y, 4.0 + 3.0, x + 2.0 + 1.0]);
    let (lanes, _) = run(
        "let n = textureDimensions(t, 1); if (p.x < 2.0) { return textureLoad(t, vec2u(u32(p.x), n.y), textureNumLevels(t)); } return vec4f(0.0);",
    );
    assert_eq!(lanes[4], [1.0, 16.0, 7.0, 1.0]);
    assert_eq!(lanes[8], [0.0; 4]);
    // In some lanes each iteration loads again and rearranges channels: later iterations read channels of several loads.
    let (lanes, _) = run("var texel = textureLoad(t, vec2i(3, 5), 7); var sum = vec4f(0.0);
         for (var k = 0; k < 4; k++) {
           sum.x += texel.x; sum.y = texel.y + sum.z; sum.z = f32(k);
           if (p.x > 2.0) { let more = textureLoad(t, vec2i(k + i32(p.x), 2 * k), k); texel = vec4f(more.x, more.z, texel.w, more.w); }
         }
         return vec4f(sum.xyz, texel.z);");
    assert_eq!(lanes[4], [12.0, 5.0 + 2.0, 3.0, 7.0]);
    // At lane 12 p.x is 3: loads (3, 0), (4, 2), (5, 4), (6, 6) at levels 0 to 3.
    assert_eq!(lanes[12], [3.0 + 3.0 + 4.0 + 5.0, 2.0 + 2.0, 3.0, 1.0]);
}

/// `value` is used in a branch that reads other texels, and after it. The slots of its unused channels are free for the values of the branch.
#[test]
fn unused_channels_of_a_texture_read_are_not_computed() {
    let program = compile(
        "struct Draw { detail: f32 }
        @group(0) @binding(0) var<uniform> draw: Draw;
        @group(0) @binding(1) var map: texture_2d<f32>;
        @fragment fn main(@location(0) at: vec2f) -> @location(0) vec4f {
            var value = textureLoad(map, vec2i(at), 0);
            if draw.detail > 0.5 {
                var finer = vec4f(0.0);
                for (var k = 0; k < 4; k++) {
                    finer += 0.25 * textureLoad(map, vec2i(at) + vec2i(k, 0), 0);
                }
                if at.x > 8.0 {
                    value = mix(value, finer, fract(at.x));
                }
            }
            return vec4f(value.x, 0.0, 0.0, value.z);
        }",
    );
    let channels: Vec<[bool; 4]> = program
        .lane_tape
        .iter()
        .filter_map(|i| if let Instr::Texture { channels_read, .. } = i { Some(*channels_read) } else { None })
        .collect();
    assert_eq!(channels, [[true, false, true, false]; 2]);
}

#[test]
fn a_vertex_stage_has_its_inputs_and_outputs_in_order() {
    let program = compile(
        "struct V { @builtin(position) clip: vec4f, @location(0) a: vec3f, @location(1) @interpolate(flat) id: u32 }
         @vertex fn main(@builtin(vertex_index) i: u32, @builtin(instance_index) k: u32, @location(0) p: vec2f) -> V {
           let corner = array<vec2f, 3>(vec2f(-1.0, -1.0), vec2f(3.0, -1.0), vec2f(-1.0, 3.0));
           return V(vec4f(corner[i % 3u], 0.0, 1.0), vec3f(p, f32(k)), i); }",
    );
    assert_eq!(program.inputs[..2], [LaneInput::VertexIndex, LaneInput::InstanceIndex]);
    assert_eq!(program.outputs[0], LaneOutput::Position { component: 0 });
    assert_eq!(program.outputs[7], LaneOutput::Location { index: 1, component: 0, flat: true });
    let (lanes, _) = run_with::<f32>(&program, KernelClass::in_use(), &[], ALL, &NoTextures);
    assert_eq!(lanes[4][..7], [3.0, -1.0, 0.0, 1.0, f64::from(lane_x(4)), f64::from(lane_y(4)), 4.0]);
}

#[test]
fn what_is_not_supported_is_refused_with_the_reason() {
    for (source, reason) in [
        (
            "@group(0) @binding(1) var<storage, read> b: array<f32>;\n@fragment fn main() -> @location(0) vec4f { return vec4f(b[0]); }",
            "Storage",
        ),
        (
            "@group(0) @binding(1) var t: texture_3d<f32>; @group(0) @binding(2) var s: sampler;\n@fragment fn main() -> @location(0) vec4f {\n return textureSampleLevel(t, s, vec3f(0.0), 0.0); }",
            "texture_2d",
        ),
        ("@fragment fn main(@location(0) @interpolate(linear) p: vec2f) -> @location(0) vec4f {\n return vec4f(p, p); }", "Linear"),
    ] {
        let (module, info) = parse(source);
        let error = lower(&module, &info, "main").expect_err("refused");
        assert!(error.to_string().contains(reason), "{error}");
    }
    // The construct is in line 2, the body of the loop in line 3, the call of the function in line 6.
    for (construct, reason) in [
        ("var x = 1.0; loop {\n x += 1.0;\n }", "never ends"),
        ("let x = frexp(p.x).fract;\n\n", "Frexp"),
        ("var x: array<f32, 20000>;\n\n", "numbers"),
    ] {
        let function = format!("fn f(p: vec2f) -> f32 {{\n {construct}\n return 1.0; }}\n");
        let source = format!("{function}@fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {{ return vec4f(f(p)); }}");
        let (module, info) = parse(&source);
        let error = lower(&module, &info, "main").expect_err("refused");
        let line = error.span.location(&source).line_number;
        assert!(error.to_string().contains(reason) && line == 2, "line {line}: {error}");
    }
}

#[test]
fn a_program_with_an_index_out_of_range_is_refused() {
    let mut program = compile("@fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f { return vec4f(p, p) * 2.0; }");
    assert!(program.check().is_ok());
    program.slot_count = 2;
    assert!(Executor::<f32>::new(&program).is_err());
    assert!(programs_from_bytes(&[1, 2, 3, 255]).is_err());
}

#[test]
fn fused_operations_change_no_bit() {
    let (module, info) = parse(include_str!("../../benches/heavy/heavy.wgsl"));
    let fused = lower(&module, &info, "fragment_main").expect("lowers");
    let unfused = lower_with(&module, &info, "fragment_main", false).expect("lowers");
    let chains = |p: &Program| p.lane_tape.iter().filter(|i| matches!(i, Instr::FusedKernel { .. })).count();
    assert!(chains(&fused) > 20 && chains(&unfused) == 0, "{} chains", chains(&fused));
    assert!(3 * fused.lane_tape.len() < 2 * unfused.lane_tape.len(), "{} of {} steps", fused.lane_tape.len(), unfused.lane_tape.len());
    // Fusing may merge a negation into a following multiply-add. It neither adds nor removes the operations of this list.
    let count = |p: &Program, op: Op| p.op_statistics().iter().find(|(o, _)| *o == op).map_or(0, |(_, n)| *n);
    for op in [Op::Mul, Op::Exp, Op::Sqrt, Op::Div, Op::Max, Op::Select] {
        assert_eq!(count(&fused, op), count(&unfused, op), "{op:?}");
    }
    // The uniform block of the heavy shader.
    let uniform_bytes: Vec<u8> =
        [0.6f32, 0.3, 0.741_62, 0.0, 9.0, 4.6, 11.3, 0.9, 0.01, 6.0, 13.0, 30.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    fn compare<R: Real>(fused: &Program, unfused: &Program, uniform_bytes: &[u8]) {
        for class in KernelClass::available() {
            let [a, b] = [fused, unfused].map(|program| {
                let mut executor = Executor::<R>::with_class(program, class).expect("binds");
                let prepared = program.run_draw_tape::<R>(uniform_bytes, class, &NoTextures);
                let mut values = Vec::new();
                // Rows across the disc, its atmosphere and the space next to it.
                for row in 0..16 {
                    for (k, input) in program.inputs.iter().enumerate() {
                        for (i, v) in executor.input_mut(k).iter_mut().enumerate() {
                            *v = R::from_f64(match input {
                                LaneInput::Location { component: 0, .. } => (i as f64 - 63.5) / 58.0,
                                LaneInput::Location { .. } => (f64::from(row) - 7.5) / 6.8,
                                _ => 0.5,
                            });
                        }
                    }
                    executor.run(&prepared, ALL, &NoTextures);
                    values.extend((0..program.outputs.len()).flat_map(|k| executor.output(k).map(|v| v.to_f64().to_bits())));
                }
                values
            });
            assert!(a == b, "{} {}", class.name(), std::any::type_name::<R>());
            assert!(a.iter().any(|v| *v != a[0]), "the values must differ");
        }
    }
    compare::<f32>(&fused, &unfused, &uniform_bytes);
    compare::<f64>(&fused, &unfused, &uniform_bytes);
}

#[test]
fn a_chain_without_a_kernel_is_refused() {
    let unchanged = compile("@fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f { return vec4f(exp(p.x * p.y)); }");
    let is_accepted_after = |change: &dyn Fn(&mut Vec<FusedOp>, &mut Vec<Operand>)| {
        let mut program = unchanged.clone();
        let chain = program.lane_tape.iter_mut().find_map(|i| match i {
            Instr::FusedKernel { ops, args, .. } => Some((ops, args)),
            _ => None,
        });
        let (ops, args) = chain.expect("product and exp are fused");
        assert_eq!(ops[..], [FusedOp { op: Op::Mul, chained_operand: 0 }, FusedOp { op: Op::Exp, chained_operand: 0 }]);
        change(ops, args);
        Executor::<f32>::new(&program).is_ok()
    };
    assert!(is_accepted_after(&|_, _| ()));
    assert!(!is_accepted_after(&|ops, _| ops[1].op = Op::Ldexp));
    assert!(!is_accepted_after(&|ops, _| ops.clear()));
    // One operand too few or too many matches no kernel.
    assert!(!is_accepted_after(&|_, args| args.truncate(1)));
    assert!(!is_accepted_after(&|_, args| args.push(Operand::Reg(0))));
}
