//! The elementary functions, with and without fused multiply-add, against those of the standard library; errors are in units in the last place (ulp) of
//! the result. Their edge cases; and every kernel, lane by lane, against the scalar form of its operation.

use orrery::render::software::exec::{Executor, LaneMask, NoTextures};
use orrery::render::software::kernels::{self, KernelClass, chains};
use orrery::render::software::math::Real;
use orrery::render::software::program::{Constant, LaneInput, LaneOutput, Program, ShaderStage};
use orrery::render::software::tape::{FusedOp, Instr, Op, Operand};

/// Distance in units in the last place of f32 at `exact`; for subnormal results, in units of the smallest subnormal.
fn ulp32(found: f32, exact: f64) -> f64 {
    if f64::from(found) == exact || (found.is_nan() && exact.is_nan()) || (found.is_infinite() && exact as f32 == found) {
        return 0.0;
    }
    let exponent = (exact.abs().log2().floor() as i32).max(-126);
    (f64::from(found) - exact).abs() / 2f64.powi(exponent - 23)
}

/// The same for f64; below 2^-970, in units of 2^-1022, the smallest normal number.
fn ulp64(found: f64, exact: f64) -> f64 {
    if found == exact || (found.is_nan() && exact.is_nan()) {
        return 0.0;
    }
    let exponent = (exact.abs().log2().floor() as i32).max(-1022);
    (found - exact).abs() / 2f64.powi(exponent.max(-970) - 52)
}

/// Even steps through a range, slightly irregular so that round values are not favoured.
fn even_steps(from: f64, to: f64, n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(move |i| from + (to - from) * (i as f64 + 0.5 + 0.4 * (i as f64 * 0.618).fract()) / n as f64)
}

/// Even steps through the exponents.
fn exponent_steps(from: f64, to: f64, n: usize) -> impl Iterator<Item = f64> {
    even_steps(from.log2(), to.log2(), n).map(f64::exp2)
}

struct Case {
    name: &'static str,
    op: Op,
    exact: fn(f64) -> f64,
    samples: Vec<f64>,
    /// Bounds on the error in ulp: f32, f64.
    max_ulp: [f64; 2],
}

fn cases() -> Vec<Case> {
    const N: usize = 60_000;
    let case = |name, op, exact, samples: Vec<f64>, max_ulp| Case { name, op, exact, samples, max_ulp };
    let both = |v: Vec<f64>| v.iter().flat_map(|x| [*x, -x]).collect::<Vec<_>>();
    vec![
        case("exp", Op::Exp, f64::exp, even_steps(-86.98, 88.7, N).collect(), [1.1, 1.5]),
        // The code computes half of the result first. At the lower end of f32's range that half is subnormal and has one bit less.
        case("exp2", Op::Exp2, f64::exp2, even_steps(-125.49, 127.9, N).collect(), [1.4, 2.5]),
        case("log", Op::Log, f64::ln, exponent_steps(1e-38, 1e38, N).chain(even_steps(0.5, 2.0, N)).collect(), [1.1, 1.5]),
        case("log2", Op::Log2, f64::log2, exponent_steps(1e-38, 1e38, N).chain(even_steps(0.5, 2.0, N)).collect(), [1.6, 1.5]),
        case("sin", Op::Sin, f64::sin, both(exponent_steps(1e-20, 1e6, N).chain(even_steps(0.0, 100.0, N)).collect()), [1.6, 2.5]),
        case("cos", Op::Cos, f64::cos, both(exponent_steps(1e-20, 1e6, N).chain(even_steps(0.0, 100.0, N)).collect()), [1.6, 2.5]),
        case("tan", Op::Tan, f64::tan, both(exponent_steps(1e-20, 1e5, N).chain(even_steps(0.0, 100.0, N)).collect()), [0.51, 4.0]),
        case("asin", Op::Asin, f64::asin, both(even_steps(0.0, 1.0, N).chain(exponent_steps(1e-20, 1.0, N)).collect()), [2.6, 2.5]),
        case("acos", Op::Acos, f64::acos, even_steps(-1.0, 1.0, N).collect(), [1.6, 2.0]),
        case("atan", Op::Atan, f64::atan, both(exponent_steps(1e-20, 1e20, N).collect()), [2.6, 2.5]),
        case("sinh", Op::Sinh, f64::sinh, both(exponent_steps(1e-20, 88.0, N).collect()), [0.51, 4.0]),
        case("cosh", Op::Cosh, f64::cosh, even_steps(-88.0, 88.0, N).collect(), [0.51, 4.0]),
        case("tanh", Op::Tanh, f64::tanh, both(exponent_steps(1e-20, 30.0, N).collect()), [0.51, 4.0]),
        case("asinh", Op::Asinh, f64::asinh, both(exponent_steps(1e-20, 1e30, N).collect()), [0.51, 6.0]),
        case("acosh", Op::Acosh, |x| 2.0 * ((x - 1.0) / 2.0).sqrt().asinh(), even_steps(1.0, 40.0, N).collect(), [0.51, 6.0]),
        case("atanh", Op::Atanh, |x| x.abs().atanh().copysign(x), both(exponent_steps(1e-20, 0.999, N).collect()), [0.51, 6.0]),
    ]
}

#[test]
fn elementary_functions_are_within_their_error_bounds() {
    let mut table = String::new();
    let mut exceeded = false;
    for case in cases() {
        let mut worst = [[0.0f64; 2]; 2];
        let mut worst_x = [[0.0f64; 2]; 2];
        for fused in [false, true] {
            for x in &case.samples {
                let x32 = *x as f32;
                let errors_ulp = [
                    ulp32(kernels::eval::<f32>(case.op, fused, x32, 0.0, 0.0), (case.exact)(f64::from(x32))),
                    ulp64(kernels::eval::<f64>(case.op, fused, *x, 0.0, 0.0), (case.exact)(*x)),
                ];
                for k in 0..2 {
                    if errors_ulp[k] > worst[k][usize::from(fused)] || errors_ulp[k].is_nan() {
                        worst[k][usize::from(fused)] = errors_ulp[k];
                        worst_x[k][usize::from(fused)] = *x;
                    }
                }
            }
        }
        for (errors, max_ulp) in worst.iter().zip(case.max_ulp) {
            exceeded |= errors.iter().any(|error| error.is_nan() || *error > max_ulp);
        }
        table += &format!(
            "{:6} f32 {:.2} {:.2} (bound {}) f64 {:.2} {:.2} (bound {}) at {:?}\n",
            case.name, worst[0][0], worst[0][1], case.max_ulp[0], worst[1][0], worst[1][1], case.max_ulp[1], worst_x
        );
    }
    println!("{table}");
    assert!(!exceeded, "unfused, fused:\n{table}");
}

#[test]
fn atan2_and_pow_are_within_their_error_bounds() {
    // Errors in ulp: atan2 in f32 and f64, pow in f32 and f64.
    let mut worst = [0.0f64; 4];
    let mut record = |k: usize, error_ulp: f64, x: f32, y: f32| {
        // `max` would ignore NaN.
        assert!(!error_ulp.is_nan(), "case {k} of {x} and {y}");
        worst[k] = worst[k].max(error_ulp);
    };
    for fused in [false, true] {
        for (i, a) in even_steps(0.0, std::f64::consts::TAU, 40_000).enumerate() {
            let r = f64::exp2((i % 200) as f64 - 100.0);
            let (y, x) = ((r * a.sin()) as f32, (r * a.cos()) as f32);
            let exact = f64::from(y).atan2(f64::from(x));
            record(0, ulp32(kernels::eval::<f32>(Op::Atan2, fused, y, x, 0.0), exact), y, x);
            record(1, ulp64(kernels::eval::<f64>(Op::Atan2, fused, y.into(), x.into(), 0.0), exact), y, x);
        }
        for x in exponent_steps(1e-10, 1e10, 300) {
            for y in even_steps(-30.0, 30.0, 300) {
                let (x, y) = (x as f32, y as f32);
                let exact = f64::from(x).powf(f64::from(y));
                if exact > 1e-37 && exact < 3e38 {
                    record(2, ulp32(kernels::eval::<f32>(Op::Pow, fused, x, y, 0.0), exact), x, y);
                    record(3, ulp64(kernels::eval::<f64>(Op::Pow, fused, x.into(), y.into(), 0.0), exact), x, y);
                }
            }
        }
    }
    println!("atan2 f32 {:.2} f64 {:.2}; pow f32 {:.2} f64 {:.2} ulp", worst[0], worst[1], worst[2], worst[3]);
    assert!(worst[0] < 3.0 && worst[1] < 2.5 && worst[2] < 0.51 && worst[3] < 6.0, "{worst:?}");
    assert!(ulp32(1.0 + 4.0 * f32::EPSILON, 1.0) > 3.9, "the measure must detect four ulp");
}

fn unary<R: Real>(op: Op, x: f64) -> f64 {
    kernels::eval::<R>(op, true, R::from_f64(x), R::ZERO, R::ZERO).to_f64()
}
fn binary<R: Real>(op: Op, x: f64, y: f64) -> f64 {
    kernels::eval::<R>(op, true, R::from_f64(x), R::from_f64(y), R::ZERO).to_f64()
}

fn assert_edge_cases<R: Real>(smallest_subnormal: f64) {
    let inf = f64::INFINITY;
    let same = |found: f64, expected: f64, what: &str| {
        assert!(
            found == expected && found.is_sign_negative() == expected.is_sign_negative() || found.is_nan() && expected.is_nan(),
            "{what}: {found} instead of {expected}"
        );
    };
    for op in [
        Op::Exp,
        Op::Exp2,
        Op::Log,
        Op::Log2,
        Op::Sin,
        Op::Cos,
        Op::Tan,
        Op::Asin,
        Op::Acos,
        Op::Atan,
        Op::Sinh,
        Op::Cosh,
        Op::Tanh,
        Op::Asinh,
        Op::Acosh,
        Op::Atanh,
        Op::Sqrt,
        Op::Floor,
        Op::Fract,
    ] {
        same(unary::<R>(op, f64::NAN), f64::NAN, &format!("{op:?}(NaN)"));
    }
    for (op, x, y) in [
        (Op::Exp, -inf, 0.0),
        (Op::Exp, inf, inf),
        (Op::Exp, 0.0, 1.0),
        (Op::Exp, 1e9, inf),
        (Op::Exp, -1e9, 0.0),
        (Op::Exp2, -inf, 0.0),
        (Op::Exp2, inf, inf),
        (Op::Exp2, 10.0, 1024.0),
        (Op::Exp2, -1e9, 0.0),
        (Op::Log, 0.0, -inf),
        (Op::Log, -1.0, f64::NAN),
        (Op::Log, inf, inf),
        (Op::Log, 1.0, 0.0),
        (Op::Log2, 0.0, -inf),
        (Op::Log2, 0.125, -3.0),
        (Op::Log2, smallest_subnormal, smallest_subnormal.log2()),
        (Op::Sin, inf, f64::NAN),
        (Op::Cos, -inf, f64::NAN),
        (Op::Sin, -0.0, -0.0),
        (Op::Cos, 0.0, 1.0),
        (Op::Asin, -0.0, -0.0),
        (Op::Asin, 1.5, f64::NAN),
        (Op::Acos, 1.0, 0.0),
        (Op::Acos, -1.5, f64::NAN),
        (Op::Tanh, inf, 1.0),
        (Op::Sinh, -inf, -inf),
        (Op::Cosh, -inf, inf),
        (Op::Acosh, 0.5, f64::NAN),
        (Op::Acosh, 1.0, 0.0),
        (Op::Asinh, -inf, -inf),
        (Op::Atanh, 1.0, inf),
        (Op::Atanh, -0.0, -0.0),
        (Op::Atanh, 2.0, f64::NAN),
        (Op::Sqrt, -1.0, f64::NAN),
        (Op::InverseSqrt, 0.0, inf),
        (Op::Floor, -0.5, -1.0),
        (Op::Floor, 1e30f32.into(), 1e30f32.into()),
        (Op::Round, 2.5, 2.0),
        (Op::Round, -0.25, -0.0),
        (Op::Trunc, -2.75, -2.0),
        (Op::Ceil, inf, inf),
    ] {
        same(unary::<R>(op, x), y, &format!("{op:?}({x})"));
    }
    for (y, x) in [
        (0.0, 1.0),
        (-0.0, 1.0),
        (0.0, -1.0),
        (-0.0, -1.0),
        (0.0, 0.0),
        (-0.0, 0.0),
        (0.0, -0.0),
        (-0.0, -0.0),
        (1.0, 0.0),
        (-1.0, -0.0),
        (inf, inf),
        (inf, -inf),
        (-inf, 1.0),
        (1.0, inf),
        (1.0, -inf),
        (2.0, 2.0),
        (-3.0, -3.0),
    ] {
        let (found, expected) = (binary::<R>(Op::Atan2, y, x), y.atan2(x));
        assert!(
            (found - expected).abs() < 3e-7 && found.is_sign_negative() == expected.is_sign_negative(),
            "atan2({y}, {x}): {found} instead of {expected}"
        );
    }
    for (x, y) in [
        (0.0, 2.0),
        (0.0, -2.0),
        (0.0, 0.0),
        (inf, 0.5),
        (inf, -1.0),
        (1.0, inf),
        (2.0, inf),
        (2.0, -inf),
        (0.5, inf),
        (7.0, 0.0),
        (2.0, 10.0),
        (10.0, 1e9),
        (10.0, -1e9),
        (1.5, f64::NAN),
        (f64::NAN, 2.0),
    ] {
        same(binary::<R>(Op::Pow, x, y), x.powf(y), &format!("pow({x}, {y})"));
    }
    same(binary::<R>(Op::Pow, -2.0, 2.0), f64::NAN, "pow of a negative base");
    for x in [1e7, 1e15, 1e30] {
        assert!(unary::<R>(Op::Sin, x).abs() <= 1.0, "sin({x}) stays in range");
    }
}

#[test]
fn functions_have_their_values_at_the_edges_of_domain_and_range() {
    assert_edge_cases::<f32>(2f64.powi(-149));
    assert_edge_cases::<f64>(f64::from_bits(1));
    // f64 extends to the smallest subnormal. In f32, results below 2^-125.5, just above the smallest normal number 2^-126, become zero.
    assert!(unary::<f64>(Op::Exp, f64::from_bits(1).ln() + 0.1) == f64::from_bits(1), "exp into the subnormals");
    for (op, threshold) in [(Op::Exp, -125.5 * std::f64::consts::LN_2), (Op::Exp2, -125.5)] {
        for step in even_steps(0.0, 30.0, 1000) {
            let small = unary::<f32>(op, threshold - 1e-4 - step);
            assert!(small == 0.0 && small.is_sign_positive(), "{op:?}({})", threshold - step);
        }
        assert!(unary::<f32>(op, threshold + 1e-4) > 0.0);
    }
    // The last numbers before infinity, with and without fused multiply-add.
    for fused in [false, true] {
        let largest = kernels::eval::<f32>(Op::Exp, fused, 88.722_83, 0.0, 0.0);
        assert!(ulp32(largest, f64::from(88.722_83_f32).exp()) < 1.1, "{largest}");
        assert!(kernels::eval::<f32>(Op::Exp, fused, 88.722_84, 0.0, 0.0).is_infinite());
        assert!(kernels::eval::<f32>(Op::Exp2, fused, 127.999_99, 0.0, 0.0).is_finite());
        assert!(kernels::eval::<f32>(Op::Exp2, fused, 128.0, 0.0, 0.0).is_infinite());
    }
}

#[test]
fn both_roundings_to_integers_give_the_same_bits() {
    /// `whole_from`: every number from there on is whole.
    fn compare<R: Real>(whole_from: f64) {
        let values =
            even_steps(-9.0, 9.0, 5000).chain((-40..40).map(|k| f64::from(k) * 0.25)).chain(exponent_steps(1e-30, whole_from, 5000));
        let extremes = [0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, whole_from - 0.5, 0.5 - whole_from, whole_from * 3.0];
        for x in values.chain(extremes).flat_map(|x| [x, -x]).map(R::from_f64) {
            for op in [Op::Floor, Op::Ceil, Op::Round, Op::Trunc, Op::Fract] {
                let [a, b] = [false, true].map(|fused| kernels::eval(op, fused, x, R::ZERO, R::ZERO));
                assert!(equal(a, b), "{op:?}({}): {} and {}", x.to_f64(), a.to_f64(), b.to_f64());
            }
        }
    }
    // 2^23 and 2^52.
    compare::<f32>(8_388_608.0);
    compare::<f64>(4_503_599_627_370_496.0);
}

/// Operand values with edge cases of all operations: floats, bit patterns of integers, masks.
fn operands<R: Real>() -> Vec<R> {
    let floats = [0.0, -0.0, 1.0, -1.0, 0.5, 2.5, -3.75, 1e-30, 3e20, -7e9, f64::INFINITY, -f64::INFINITY, f64::NAN, 0.3, 88.0, 1e-42];
    let ints = [0u32, 1, 2, 31, 32, 33, 0x8000_0000, u32::MAX, 0x7fff_ffff, 12345, 0x00ff_00ff, 77, 0xdead_beef, 5, 3, 4];
    floats
        .iter()
        .map(|x| R::from_f64(*x))
        .chain(ints.iter().map(|i| R::from_lane_bits(*i)))
        .chain([R::from_mask(true), R::from_mask(false)])
        .collect()
}

fn equal<R: Real>(a: R, b: R) -> bool {
    // The NaN's bit pattern depends on the machine.
    !a.bit_xor(b).is_mask_set() || (a.is_nan() && b.is_nan())
}

fn assert_kernels_match<R: Real>() {
    const N: usize = kernels::LANES;
    let pool = operands::<R>();
    for class in KernelClass::available() {
        for &op in Op::ALL {
            if matches!(op, Op::Dpdx | Op::Dpdy) {
                continue;
            }
            let lane = |step: usize| std::array::from_fn::<R, N, _>(|i| pool[(i * step + i / 7 + step) % pool.len()]);
            let (mut a, b, c) = (lane(1), lane(5), lane(3));
            if op == Op::Select {
                a = std::array::from_fn(|i| R::from_mask(i % 3 == 0));
            }
            for single_valued in 0..8u8 {
                // Whether each operand has a value per lane; the others have one value for all lanes.
                let per_lane = [single_valued & 1 == 0, single_valued & 2 == 0, single_valued & 4 == 0];
                let run = match R::specialised(class, op, per_lane) {
                    Some(kernel) => kernel,
                    None if per_lane == [true; 3] => R::generic(class, op),
                    None => continue,
                };
                let mut out = [R::ZERO; N];
                let operand_lanes = [a, b, c].concat();
                // SAFETY: each operand has N lanes of `operand_lanes`, and the class is one that this machine has.
                unsafe { run(&mut out, operand_lanes.as_ptr(), [0, N as u32, 2 * N as u32].as_ptr()) };
                for i in 0..N {
                    let pick = |v: &[R; N], k: usize| if per_lane[k] { v[i] } else { v[0] };
                    let expected = kernels::eval(op, class.has_fma(), pick(&a, 0), pick(&b, 1), pick(&c, 2));
                    assert!(
                        equal(out[i], expected),
                        "{} {op:?} {per_lane:?} lane {i}: {} instead of {}",
                        class.name(),
                        out[i].to_f64(),
                        expected.to_f64()
                    );
                }
            }
        }
    }
}

/// The value of a chain of operations, computed one after the other.
fn evaluate_one_by_one<R: Real>(ops: &[FusedOp], fused: bool, mut operands: impl Iterator<Item = R>) -> R {
    let mut last = None;
    for fused_op in ops {
        let mut args = [R::ZERO; 3];
        for (k, arg) in args.iter_mut().enumerate().take(fused_op.op.arity()) {
            *arg = match last {
                Some(v) if k == usize::from(fused_op.chained_operand) => v,
                _ => operands.next().expect("as many operands as the chain takes"),
            };
        }
        last = Some(kernels::eval(fused_op.op, fused, args[0], args[1], args[2]));
    }
    assert!(operands.next().is_none(), "{ops:?}: an operand too many");
    last.expect("a chain is never empty")
}

/// A program of one chain. `kinds` has a letter per operand: `L`, an input with a value per lane; `R`, a register that holds a constant.
fn program_of(ops: &[FusedOp], kinds: &str, constants: Vec<Constant>) -> Program {
    let (mut lanes, mut registers) = (0, 0);
    let args = kinds.bytes().map(|kind| {
        let count = if kind == b'L' { &mut lanes } else { &mut registers };
        *count += 1;
        if kind == b'L' { Operand::Slot(*count - 1) } else { Operand::Reg(*count - 1) }
    });
    let args = args.collect();
    // The slot after the inputs holds the mask of active lanes.
    let dst = lanes + 1;
    Program {
        name: "one chain".into(),
        stage: ShaderStage::Fragment,
        inputs: (0..lanes).map(|k| LaneInput::Location { index: k.into(), component: 0, flat: false }).collect(),
        inputs_read: vec![true; usize::from(lanes)],
        outputs: vec![LaneOutput::Location { index: 0, component: 0, flat: false }],
        output_operands: vec![Operand::Slot(dst)],
        textures: Vec::new(),
        uses_discard: false,
        discarded: None,
        uses_derivatives: false,
        uniform_size: 0,
        constants,
        draw_tape: Vec::new(),
        lane_tape: vec![Instr::FusedKernel { ops: ops.to_vec(), dst, args }],
        register_count: u32::from(registers),
        slot_count: u32::from(dst) + 1,
    }
}

/// Compares every chain with its operations computed one by one. A class without fused kernels runs a chain by the kernels of its operations.
fn assert_chains_match<R: Real>() {
    const N: usize = kernels::LANES;
    let pool = operands::<R>();
    for class in KernelClass::available() {
        let count = R::chain_kernels(class).len();
        assert!(count == 0 || count == chains::all().len(), "{}: {count}", class.name());
        for (index, &(ops, kinds)) in chains::all().iter().enumerate() {
            assert_eq!(chains::find(ops, chains::kind_bits(kinds)), Some(index), "{ops:?} {kinds} is listed twice");
            assert!(ops.len() > 1 && ops.len() <= chains::MAX_CHAIN_OPS && kinds.len() <= chains::MAX_OPERANDS && kinds.contains('L'));
            assert_eq!(chains::operand_count(ops), kinds.len(), "{ops:?} {kinds}");
            // First edge cases, then ordinary values, which do not become NaN after a few operations.
            for ordinary in [false, true] {
                let operands: [[R; N]; chains::MAX_OPERANDS] = [1, 5, 3, 7, 11, 13, 17, 19].map(|step: usize| {
                    std::array::from_fn(|i| match ordinary {
                        false => pool[(i * step + i / 7 + step) % pool.len()],
                        true => R::from_f64(((i * step) as f64 * 0.618 + 0.1).fract() * 3.0 - if i % 5 == 0 { 1.5 } else { 0.0 }),
                    })
                });
                let by_kind = |selected: u8| kinds.bytes().zip(&operands).filter(move |(kind, _)| *kind == selected).map(|(_, o)| o);
                let program = program_of(ops, kinds, by_kind(b'R').map(|o| Constant::Float(o[0].to_f64())).collect());
                let mut executor = Executor::<R>::with_class(&program, class).expect("a program of one chain");
                for (k, lanes) in by_kind(b'L').enumerate() {
                    *executor.input_mut(k) = *lanes;
                }
                let alive = executor.run(&program.run_draw_tape(&[], class, &NoTextures), LaneMask::MAX, &NoTextures);
                assert_eq!((alive, executor.counts().instructions), (LaneMask::MAX, 1), "{} {ops:?} {kinds}", class.name());
                for (i, found) in executor.output(0).iter().enumerate() {
                    let args = kinds.bytes().zip(&operands).map(|(kind, o)| if kind == b'L' { o[i] } else { R::from_f64(o[0].to_f64()) });
                    let expected = evaluate_one_by_one(ops, class.has_fma(), args);
                    assert!(
                        equal(*found, expected),
                        "{} {ops:?} {kinds} lane {i}: {} instead of {}",
                        class.name(),
                        found.to_f64(),
                        expected.to_f64()
                    );
                }
            }
        }
    }
}

#[test]
fn every_chain_computes_what_its_operations_do() {
    assert_chains_match::<f32>();
    assert_chains_match::<f64>();
    assert_eq!(chains::find(&[FusedOp { op: Op::Mul, chained_operand: 0 }, FusedOp { op: Op::Ldexp, chained_operand: 0 }], 3), None);
}

#[test]
fn every_kernel_of_every_class_computes_its_scalar_form() {
    assert_kernels_match::<f32>();
    assert_kernels_match::<f64>();
}

fn assert_converts_as_rust_does<R: Real>() {
    let limit = 2_147_483_648.0;
    let edges =
        [0.0, -0.0, 0.99, -0.99, 1.5, -1.5, 8_388_609.0, limit, -limit, limit - 128.0, limit + 256.0, -limit - 256.0, 1e30, f64::INFINITY];
    for x in edges.into_iter().flat_map(|x| [x, -x]).chain([f64::NAN, 1e-40]) {
        let x = R::from_f64(x);
        assert_eq!(x.to_i32(), x.to_f64() as i32, "{}", x.to_f64());
        if x.to_f64().abs() <= 4_194_304.0 {
            let (whole, k) = x.round_small();
            assert_eq!((whole.to_f64(), k), (x.to_f64().round_ties_even(), x.to_f64().round_ties_even() as i32), "{}", x.to_f64());
        }
    }
}

#[test]
fn conversions_to_integers_saturate_and_round() {
    assert_converts_as_rust_does::<f32>();
    assert_converts_as_rust_does::<f64>();
}
