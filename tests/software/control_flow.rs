//! Branches, loops, switches and discard on the tape against the semantics of WGSL, lane by lane.

use super::lower::{ALL, check, check_uniform, compile, lane_x, lane_y, run_with};
use orrery::render::software::exec::{Executor, NoTextures};
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::tape::{Instr, Op};

#[test]
fn branches_merge_what_they_change() {
    check(
        "fn inner(x: f32) -> f32 { if (x > 20.0) { return 1.0; } if (x > 10.0) { return exp(log(x)); } return -x; }",
        "var a = 1.0; var b = vec2f(0.0);
         if (p.x > 5.0) { a = p.x; if (p.y > 0.0) { b.x = 2.0; } else { b = p; } } else if (p.x > 2.0) { b.y = sqrt(p.x) + sqrt(p.x); }
         return vec4f(a, b, inner(p.x));",
        1e-5,
        |x, y| {
            let a = if x > 5.0 { x } else { 1.0 };
            let b = if x > 5.0 { if y > 0.0 { [2.0, 0.0] } else { [x, y] } } else { [0.0, if x > 2.0 { 2.0 * x.sqrt() } else { 0.0 }] };
            [
                a,
                b[0],
                b[1],
                if x > 20.0 {
                    1.0
                } else if x > 10.0 {
                    x
                } else {
                    -x
                },
            ]
        },
    );
}

#[test]
fn an_early_return_ends_its_lanes_only() {
    check(
        "",
        "if (p.x > 8.0) { return vec4f(1.0); } let q = sin(p.x) + cos(p.x) + exp(p.x) + log(p.x + 1.0) + sqrt(p.x); return vec4f(q, p, 2.0);",
        1e-5,
        |x, y| {
            if x > 8.0 { [1.0; 4] } else { [x.sin() + x.cos() + x.exp() + (x + 1.0).ln() + x.sqrt(), x, y, 2.0] }
        },
    );
}

/// A variable keeps the value of an input if a loop or a branch that would overwrite it does not run for any lane.
#[test]
fn an_input_outlives_writes_that_are_jumped_over() {
    let block = "struct U { n: i32, } @group(0) @binding(0) var<uniform> u: U;";
    let looped = "var x = p.x; for (var i = 0; i < u.n; i++) { x = f32(i) + 0.5; } return vec4f(x, 0.0, 0.0, 1.0);";
    let branched = "var x = p.x; if (u.n > 1) { x = 7.5; } return vec4f(x, 0.0, 0.0, 1.0);";
    for n in [0_i32, 1, 3] {
        check_uniform(block, looped, &n.to_le_bytes(), 0.0, |x, _| [if n > 0 { f64::from(n) - 0.5 } else { x }, 0.0, 0.0, 1.0]);
        check_uniform(block, branched, &n.to_le_bytes(), 0.0, |x, _| [if n > 1 { 7.5 } else { x }, 0.0, 0.0, 1.0]);
    }
}

/// A branch on a uniform runs one side, whose values need no `select`: nested, with both sides, swapped, in loops and with early exits. Each as
/// (shader, values for the uniform 0 and above).
#[test]
fn a_branch_on_a_uniform_merges_without_selects() {
    let block = "struct U { n: i32, m: i32, } @group(0) @binding(0) var<uniform> u: U;";
    type Expected = fn(i32, f64, f64) -> [f64; 4];
    let cases: [(&str, Expected); 7] = [
        ("var a = p.x; var b = p.y; if (u.n > 0) { let t = a; a = b * 2.0; b = t; } return vec4f(a, b, a, p.x);", |n, x, y| {
            if n > 0 { [2.0 * y, x, 2.0 * y, x] } else { [x, y, x, x] }
        }),
        ("var a = p.x; var b = p.x; if (u.n > 0) { b = a + 1.0; a = b * p.y; } else { a = b - 3.0; } return vec4f(a, b, p);", |n, x, y| {
            if n > 0 { [(x + 1.0) * y, x + 1.0, x, y] } else { [x - 3.0, x, x, y] }
        }),
        (
            "var a = 0.5; var b = vec2f(0.0); if (u.n > 0) { a = p.x * p.y; if (u.n > 1) { b = p + a; } else { b.x = a; } a += b.y; }
             return vec4f(a, b, p.y);",
            |n, x, y| match n {
                0 => [0.5, 0.0, 0.0, y],
                1 => [x * y, x * y, 0.0, y],
                _ => [x * y + y + x * y, x + x * y, y + x * y, y],
            },
        ),
        ("var a = p.x; if (u.n > 0) { if (p.y > 0.0) { a = a * a; } } return vec4f(a * 3.0 + p.y, a, 0.0, 1.0);", |n, x, y| {
            let a = if n > 0 && y > 0.0 { x * x } else { x };
            [a * 3.0 + y, a, 0.0, 1.0]
        }),
        (
            "var a = p.x; for (var i = 0; i < 3; i++) { if (i < u.n) { a = a * 0.5 + p.y; } else { a = a - 1.0; } } return vec4f(a, p, 1.0);",
            |n, x, y| [(0..3).fold(x, |a, i| if i < n { a * 0.5 + y } else { a - 1.0 }), x, y, 1.0],
        ),
        (
            "var a = p.x; loop { if (u.n > 0) { a = a + 1.0; if (a > 4.0) { break; } } else { break; } } return vec4f(a, p, 1.0);",
            |n, x, y| [if n > 0 { (1..).map(|k| x + f64::from(k)).find(|a| *a > 4.0).unwrap_or_default() } else { x }, x, y, 1.0],
        ),
        (
            "var a = p.x; let before = a; if (u.n > 0) { a = before * p.y; } return vec4f(a, before, p.y - before, before * a);",
            |n, x, y| {
                let a = if n > 0 { x * y } else { x };
                [a, x, y - x, x * a]
            },
        ),
    ];
    for (k, (body, expected)) in cases.into_iter().enumerate() {
        for n in 0..3_i32 {
            let bytes: Vec<u8> = [n, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
            check_uniform(block, body, &bytes, 1e-5, |x, y| expected(n, x, y));
        }
        let program = compile(&format!("{block} @fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {{ {body} }}"));
        let selects = program.op_statistics().iter().filter(|(op, _)| *op == Op::Select).map(|(_, count)| *count).sum::<usize>();
        // Only the branch on a lane value, and the flags of the endless loop, need selects.
        assert_eq!(selects > 0, [3, 5].contains(&k), "{selects} selects: {body}");
    }
}

/// In a branch on a uniform, flags take the old values of variables that the branch changes, too.
#[test]
fn flags_keep_the_values_from_before_a_branch_on_a_uniform() {
    let block = "struct U { n: i32, m: i32, } @group(0) @binding(0) var<uniform> u: U;";
    type Expected = fn(i32, f64, f64) -> [f64; 4];
    let cases: [(&str, Expected); 3] = [
        ("var a = p.x > 2.0; var b = false; if (u.n > 0) { b = a; a = p.y > 0.0; } return vec4f(f32(a), f32(b), p);", |n, x, y| {
            let (old, new) = (f64::from(u8::from(x > 2.0)), f64::from(u8::from(y > 0.0)));
            if n > 0 { [new, old, x, y] } else { [old, 0.0, x, y] }
        }),
        ("var a = p.x > 2.0; var b = false; if (u.n > 0) { b = a; a = p.y > 0.0; } else { b = true; } return vec4f(f32(a), f32(b), p);", |n, x, y| {
            let (old, new) = (f64::from(u8::from(x > 2.0)), f64::from(u8::from(y > 0.0)));
            if n > 0 { [new, old, x, y] } else { [old, 1.0, x, y] }
        }),
        (
            "var a = p.x > 7.0; var count = 0.0;
             for (var i = 0; i < u.m; i++) { if (u.n > 0) { if (a) { break; } a = p.y > f32(i); } count += 1.0; } return vec4f(count, p, 1.0);",
            |n, x, y| {
                let (mut a, mut count) = (x > 7.0, 0.0);
                for i in 0..5 {
                    if n > 0 {
                        if a {
                            break;
                        }
                        a = y > f64::from(i);
                    }
                    count += 1.0;
                }
                [count, x, y, 1.0]
            },
        ),
    ];
    for (body, expected) in cases {
        for n in 0..2_i32 {
            let bytes: Vec<u8> = [n, 5].iter().flat_map(|v| v.to_le_bytes()).collect();
            check_uniform(block, body, &bytes, 0.0, |x, y| expected(n, x, y));
        }
    }
}

/// A loop whose condition follows a computation is lowered, whether or not it is unrolled.
#[test]
fn a_loop_that_begins_with_a_computation_is_lowered() {
    for (count, limit) in [(4, 4), (20, 20)] {
        let body = format!(
            "var s = 0.0; var i = 0; loop {{ let t = p.x * 0.5; if (i >= {limit}) {{ break; }} s += t; continuing {{ i++; }} }} return vec4f(s, p, 1.0);"
        );
        check("", &body, 1e-5, |x, y| [f64::from(count) * x * 0.5, x, y, 1.0]);
    }
}

/// A loop whose number of iterations is known becomes a sequence, in which values that depend on the counter alone are computed once per draw. Each case: the
/// loop's head and first statement, and whether a loop remains.
#[test]
fn short_loops_with_a_known_number_of_iterations_are_unrolled() {
    let block = "struct U { n: i32, m: i32, weights: array<vec4f, 12>, } @group(0) @binding(0) var<uniform> u: U;";
    let weights: Vec<f32> = (0..48).map(|k| 1.0 + 0.25 * k as f32).collect();
    let bytes: Vec<u8> =
        [3_i32, 0, 0, 0].iter().flat_map(|v| v.to_le_bytes()).chain(weights.iter().flat_map(|v| v.to_le_bytes())).collect();
    let sum = |count: usize, x: f64| (0..count).fold(0.0, |sum, k| sum + x * (f64::from(weights[4 * k + 1]) + k as f64));
    type Count = fn(f64) -> usize;
    let cases: [(&str, Count, bool); 6] = [
        ("for (var k = 0; k < 5; k++) { if k < 0 { continue; }", |_| 5, false),
        ("for (var k = 0; k < 8; k++) { if k == 6 { break; }", |_| 6, false),
        ("for (var k = 0; k < 0; k++) {", |_| 0, false),
        ("for (var k = 0; k < 9; k++) {", |_| 9, true),
        ("for (var k = 0; k < u.n; k++) {", |_| 3, true),
        ("for (var k = 0; k < 4; k++) { if p.x > 7.0 && k > 1 { break; }", |x| if x > 7.0 { 2 } else { 4 }, true),
    ];
    for (head, count, has_loop) in cases {
        let body = format!("var s = 0.0; {head} s += p.x * (u.weights[k].y + f32(k)); }} return vec4f(s, p, 1.0);");
        check_uniform(block, &body, &bytes, 1e-5, |x, y| [sum(count(x), x), x, y, 1.0]);
        let program = compile(&format!("{block} @fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {{ {body} }}"));
        let jumps_back = |(at, instr): (usize, &Instr)| matches!(instr, Instr::Jump { target } | Instr::JumpIf { target, .. } | Instr::SkipIfNoLane { target, .. } if *target as usize <= at);
        assert_eq!(program.lane_tape.iter().enumerate().any(jumps_back), has_loop, "{head} {:?}", program.lane_tape);
        let is_per_batch = |i: &Instr| matches!(i, Instr::LoadUniform { .. } | Instr::GatherUniform { .. } | Instr::Scalar { .. });
        assert_eq!(program.lane_tape.iter().any(is_per_batch), has_loop, "{head}");
    }
}

/// The size of a texture is read once per draw.
#[test]
fn a_branch_on_the_size_of_a_texture_is_decided_per_draw() {
    let program = compile(
        "@group(0) @binding(1) var t: texture_2d<f32>;
         @fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {
             if (textureDimensions(t).x > 1u) { return vec4f(sin(p.x)); } return vec4f(p, f32(textureNumLevels(t)), 0.0); }",
    );
    assert!(
        program.lane_tape.iter().all(|instr| !matches!(instr, Instr::TextureSize { .. } | Instr::Scalar { .. })),
        "{:?}",
        program.lane_tape
    );
    let (lanes, _) = run_with::<f32>(&program, KernelClass::in_use(), &[], ALL, &NoTextures);
    for (i, found) in lanes.iter().enumerate() {
        assert_eq!(found[..], [f64::from(lane_x(i)), f64::from(lane_y(i)), 1.0, 0.0]);
    }
}

#[test]
fn counted_loops_follow_wgsl() {
    let program = compile(
        "@fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f { var s = 0.0; for (var i = 0; i < 16; i++) { s += exp(p.x * f32(i)); } return vec4f(s); }",
    );
    assert!(program.lane_tape.len() < 20, "sixteen iterations stay a loop: {} steps", program.lane_tape.len());
    check(
        "",
        "var s = 0.0; var t = 1.0; for (var i = 0; i < 10; i++) { let k = t; t = s + p.x; s = k; } return vec4f(s, t, 0.0, 0.0);",
        1e-5,
        |x, _| {
            let (mut s, mut t) = (0.0, 1.0);
            for _ in 0..10 {
                (s, t) = (t, s + x);
            }
            [s, t, 0.0, 0.0]
        },
    );
    check(
        "",
        "var s = 0.0; for (var i = 0; i < 6; i++) { for (var j = i; j < 6; j++) { if (j == 4) { continue; } s += f32(i * j) * p.x; } if (i == 4) { break; } } return vec4f(s);",
        1e-5,
        |x, _| {
            let mut s = 0.0;
            for i in 0..=4 {
                for j in i..6 {
                    s += if j == 4 { 0.0 } else { f64::from(i * j) * x };
                }
            }
            [s; 4]
        },
    );
}

#[test]
fn loops_bounded_by_uniforms_and_indexed_uniforms_follow_wgsl() {
    let block = "struct U { n: i32, scale: vec3f, m: mat3x3f, values: array<vec4f, 5>, k: f32 } @group(0) @binding(0) var<uniform> u: U;";
    let mut bytes = vec![0u8; 176];
    let mut write_at = |at: usize, v: [u8; 4]| bytes[at..at + 4].copy_from_slice(&v);
    write_at(0, 3i32.to_le_bytes());
    for k in 0..3 {
        write_at(16 + 4 * k, (k as f32 + 1.0).to_le_bytes());
        for r in 0..3 {
            write_at(32 + 16 * k + 4 * r, ((3 * k + r) as f32).to_le_bytes());
        }
    }
    for k in 0..5 {
        for r in 0..4 {
            write_at(80 + 16 * k + 4 * r, ((10 * k + r) as f32).to_le_bytes());
        }
    }
    write_at(160, 0.5f32.to_le_bytes());
    check_uniform(
        block,
        "var s = 0.0; for (var i = 0; i < u.n; i++) { s += u.values[i].y * p.x; }
         return vec4f(s, (u.m * u.scale).y, u.values[u32(p.x)].z, u.scale.z * u.k + p.y);",
        &bytes,
        1e-5,
        |x, y| {
            let k = (x as usize).min(4) as f64;
            [(1.0 + 11.0 + 21.0) * x, 1.0 + 4.0 * 2.0 + 7.0 * 3.0, 10.0 * k + 2.0, 1.5 + y]
        },
    );
}

#[test]
fn lanes_leave_loops_independently() {
    check(
        "fn steps(x: f32) -> vec2f { var n = 0.0; var v = x; loop { if (v < 1.0) { break; } v = v * 0.5; n += 1.0; if (n > 3.0 && x > 30.0) { return vec2f(-1.0, v); } continuing { n += 0.0; } } return vec2f(n, v); }",
        "let a = steps(p.x); var c = 0.0; var i = 0; while (f32(i) < p.x) { i++; if (i % 2 == 0) { continue; } c += 1.0; } return vec4f(a, c, f32(i));",
        1e-6,
        |x, _| {
            let (mut n, mut v) = (0.0, x);
            while v >= 1.0 {
                v *= 0.5;
                n += 1.0;
                if n > 3.0 && x > 30.0 {
                    n = -1.0;
                    break;
                }
            }
            let i = x.ceil();
            [n, v, (i / 2.0).ceil(), i]
        },
    );
    check("", "var n = 0; loop { n++; continuing { break if f32(n) > p.x; } } return vec4f(f32(n));", 0.0, |x, _| [x.floor() + 1.0; 4]);
}

/// Lanes that `continue` take part in the next iteration, even if no lane is left in the current one. Lanes that `break` do not.
#[test]
fn a_loop_goes_on_after_an_iteration_that_every_lane_continued() {
    check(
        "",
        "var a = 0.0; for (var i = 0; i < 6; i++) { if (f32(i) < 3.0 + 0.0 * p.x) { continue; } a += exp(f32(i)); }
         var b = 0.0; for (var i = 0.0; i < p.x; i += 1.0) { if (i < 2.0) { continue; } b += 1.0; }
         var c = 0.0; var v = p.x; while (v > 1.0) { v *= 0.5; if (v > p.y) { if (v > 4.0) { c += 1.0; } else { c += 10.0; } } }
         return vec4f(a, b, c, v);",
        1e-5,
        |x, y| {
            let (mut c, mut v) = (0.0, x);
            while v > 1.0 {
                v *= 0.5;
                c += if v > y { if v > 4.0 { 1.0 } else { 10.0 } } else { 0.0 };
            }
            [(3..6).map(|i| f64::from(i).exp()).sum(), (x.max(0.0).ceil() - 2.0).max(0.0), c, v]
        },
    );
}

#[test]
fn loop_invariants_are_computed_once() {
    let body = "var sum = 0.0;
         for (var i = 0; i < 20; i++) {
             let fixed = sqrt(p.x * p.x + 1.0) * 0.125;
             if p.y > f32(i) {
                 sum += log(p.x + 2.0) * sin(p.x) * exp(p.x * -0.25);
             }
             sum += fixed * f32(i);
         }
         var product = 1.0;
         for (var j = 0; j < 20; j++) {
             product *= 1.0 + 1.0 / (p.x + 4.0) + f32(j);
         }
         return vec4f(sum, product, 0.0, 0.0);";
    check("", body, 1e-5, |x, y| {
        let sum = (0..20).map(|i| {
            let i = f64::from(i);
            let above = if y > i { (x + 2.0).ln() * x.sin() * (x * -0.25).exp() } else { 0.0 };
            above + (x * x + 1.0).sqrt() * 0.125 * i
        });
        let product = (0..20).map(|j| 1.0 + 1.0 / (x + 4.0) + f64::from(j)).product();
        [sum.sum(), product, 0.0, 0.0]
    });
    let program = compile(&format!("@fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {{ {body} }}"));
    let ops = |instr: &Instr| match instr {
        Instr::Lane { op, .. } => vec![*op],
        Instr::FusedKernel { ops, .. } => ops.iter().map(|fused| fused.op).collect(),
        _ => Vec::new(),
    };
    let loop_bodies = program.lane_tape.iter().enumerate().filter_map(|(at, instr)| match instr {
        Instr::Jump { target } if (*target as usize) < at => Some(*target as usize..at),
        _ => None,
    });
    let inside: Vec<Op> = loop_bodies.flat_map(|range| &program.lane_tape[range]).flat_map(ops).collect();
    let runs_in_loop = |op: Op| inside.contains(&op);
    assert!(!runs_in_loop(Op::Sqrt) && !runs_in_loop(Op::Div), "{inside:?}");
    // Hoisting these out of the branch would cost more than running them only for the lanes that need them.
    assert!(runs_in_loop(Op::Exp) && runs_in_loop(Op::Log) && runs_in_loop(Op::Sin), "{inside:?}");
    // A counted loop exits with a single jump.
    let is_double_exit = |w: &[Instr]| matches!(w, [Instr::JumpIf { .. }, Instr::Jump { .. }]);
    assert!(!program.lane_tape.windows(2).any(is_double_exit), "{:?}", program.lane_tape);
}

#[test]
fn switches_follow_wgsl() {
    let body = |selector: &str| {
        format!(
            "var a = 0.0; for (var i = 0; i < 3; i++) {{ switch {selector} {{ case 0 {{ a += 1.0; }} case 1, 2 {{ if (p.y < 5.0) {{ break; }} a += 10.0; }} case 3 {{ continue; }} default {{ a += 100.0; }} }} a += 1000.0; }} return vec4f(a);"
        )
    };
    let per_iteration = |k: i32, y: f64| match k {
        0 => 1001.0,
        1 | 2 => 1000.0 + if y < 5.0 { 0.0 } else { 10.0 },
        3 => 0.0,
        _ => 1100.0,
    };
    check("", &body("i32(p.x)"), 0.0, |x, y| [3.0 * per_iteration(x as i32, y); 4]);
    check("", &body("i + 1"), 0.0, |_, y| [per_iteration(1, y) + per_iteration(2, y) + per_iteration(3, y); 4]);
}

#[test]
fn discard_removes_lanes_and_nothing_else() {
    let program = compile(
        "@fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f { var a = p.x; if (p.x > 4.0) { if (p.y < 1.0) { discard; } a = 2.0; } return vec4f(a); }",
    );
    assert!(program.uses_discard);
    for class in KernelClass::available() {
        let active = ALL ^ 0b1010;
        let (lanes, alive) = run_with::<f32>(&program, class, &[], active, &NoTextures);
        for (i, lane) in lanes.iter().enumerate() {
            let (x, y) = (lane_x(i), lane_y(i));
            let is_alive = !(x > 4.0 && y < 1.0) && active >> i & 1 == 1;
            assert_eq!(alive >> i & 1 == 1, is_alive, "lane {i}");
            if is_alive {
                assert_eq!(lane[0], f64::from(if x > 4.0 { 2.0 } else { x }));
            }
        }
    }
}

/// Sums over n iterations, for even and odd n: values that one iteration hands to the next, also exchanged ones, one that a lane keeps after it
/// has left the loop, and one in an inner loop.
#[test]
fn loop_variables_pass_any_number_of_iterations() {
    let block = "struct U { n: i32, } @group(0) @binding(0) var<uniform> u: U;
         fn left(x: f32) -> vec2f {
             var sum = 0.0;
             for (var i = 0; i < u.n; i++) { sum += x * f32(i); if (sum > 40.0) { return vec2f(sum, -1.0); } }
             return vec2f(sum, 1.0);
         }";
    let body = "var sum = 0.0; var squares = 1.0; var a = p.x; var b = 1.0;
         for (var i = 0; i < u.n; i++) { let old = a; a = b; b = old * 0.5; sum += p.y * f32(i); squares += sum * sum; }
         var inner = 0.0;
         for (var i = 0; i < 3; i++) { for (var j = 0; j < u.n; j++) { inner += f32(i * j) + p.x; } inner *= 0.5; }
         let of_left = left(abs(p.x));
         return vec4f(sum + squares, a + 10.0 * b, inner, of_left.x * of_left.y);";
    for n in 0_i32..8 {
        check_uniform(block, body, &n.to_le_bytes(), 1e-5, |x, y| {
            let (mut sum, mut squares, mut a, mut b) = (0.0, 1.0, x, 1.0);
            let (mut inner, mut of_left) = (0.0, 0.0);
            for i in 0..n {
                (a, b) = (b, a * 0.5);
                sum += y * f64::from(i);
                squares += sum * sum;
            }
            for i in 0..3 {
                inner += (0..n).map(|j| f64::from(i * j) + x).sum::<f64>();
                inner *= 0.5;
            }
            for i in 0..n {
                of_left += x.abs() * f64::from(i);
                if of_left > 40.0 {
                    of_left = -of_left;
                    break;
                }
            }
            [sum + squares, a + 10.0 * b, inner, of_left]
        });
    }
}

/// An iteration runs no copies, although the stored program ends its loops with them.
#[test]
fn iterations_run_without_copies_of_loop_variables() {
    let program = compile(
        "struct U { n: i32, } @group(0) @binding(0) var<uniform> u: U;
         @fragment fn main(@location(0) p: vec2f) -> @location(0) vec4f {
             var sum = 0.0; var squares = 0.0;
             for (var i = 0; i < u.n; i++) { sum += exp(p.x * f32(i)); squares += sum * sum; }
             return vec4f(sum, squares, 0.0, 1.0);
         }",
    );
    let back = program.lane_tape.iter().enumerate().find_map(|(at, instr)| match instr {
        Instr::Jump { target } if (*target as usize) < at => Some(*target as usize..at),
        _ => None,
    });
    let iteration = &program.lane_tape[back.expect("a loop")];
    let count = |is_counted: fn(&Instr) -> bool| iteration.iter().filter(|i| is_counted(i)).count() as u32;
    let copies = count(|i| matches!(i, Instr::Lane { op: Op::Copy, .. }));
    let kernels = count(|i| matches!(i, Instr::Lane { .. } | Instr::FusedKernel { .. }));
    assert_eq!(copies, 2, "{iteration:?}");
    let instructions = |n: i32| {
        let mut executor = Executor::<f32>::with_class(&program, KernelClass::in_use()).expect("binds");
        (0..program.inputs.len()).for_each(|k| executor.set_input_constant(k, 0.5));
        executor.run(&program.run_draw_tape::<f32>(&n.to_le_bytes(), KernelClass::in_use(), &NoTextures), ALL, &NoTextures);
        executor.counts().instructions
    };
    assert_eq!(instructions(12) - instructions(2), 10 * (kernels - copies));
    assert_eq!(instructions(3) - instructions(2), kernels, "an odd number of iterations ends with the copies");
}

/// naga's `Restrict`, which wgpu applies. `b` has an index that is known when the loop is unrolled, the others one that is not.
#[test]
fn an_index_out_of_range_reads_and_writes_the_last_element() {
    let body = "let k = i32(p.y);
         var a = array<f32, 3>(1.0, 2.0, 3.0); a[k] = p.x; a[u32(k) + 1u] += 50.0;
         var b = array<f32, 3>(); for (var i = 0; i < 5; i++) { b[i] += f32(i); }
         var m = mat2x2f(0.0, 0.0, 0.0, 0.0); m[k][k] = 7.0; m[k + 1][0] += 1.0;
         return vec4f(a[0] + 1000.0 * a[1], a[2], b[0] + 10.0 * b[1] + 100.0 * b[2], m[0].x + 10.0 * m[0].y + 100.0 * m[1].x + 1000.0 * m[1].y);";
    check("", body, 1e-6, |x, y| {
        let k = y.trunc() as i64;
        let within = |k: i64, count: usize| usize::try_from(k).unwrap_or(usize::MAX).min(count - 1);
        let mut a = [1.0, 2.0, 3.0];
        a[within(k, 3)] = x;
        // -1 + 1 wraps to 0.
        a[within(k + 1, 3)] += 50.0;
        let mut m = [[0.0; 2]; 2];
        m[within(k, 2)][within(k, 2)] = 7.0;
        m[within(k + 1, 2)][0] += 1.0;
        [a[0] + 1000.0 * a[1], a[2], 10.0 + 100.0 * 9.0, m[0][0] + 10.0 * m[0][1] + 100.0 * m[1][0] + 1000.0 * m[1][1]]
    });
    let constant = "@fragment fn main() -> @location(0) vec4f { var a = array<f32, 3>(); a[3] = 1.0; return vec4f(a[0]); }";
    let is_accepted = naga::front::wgsl::parse_str(constant).is_ok_and(|module| {
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
        validator.validate(&module).is_ok()
    });
    assert!(!is_accepted, "naga refuses a constant index out of range");
}
