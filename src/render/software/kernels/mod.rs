//! SIMD kernels: one generic source, compiled once per instruction set and chosen at run time.
//!
//! In: operands, each of one of two kinds: an array of lanes, or one value for all lanes. Out: [`LANES`] lanes written. A frequent operation has one
//! specialised kernel per combination of operand kinds in which at least one operand is an array; copies also have one that broadcasts one value. Every
//! operation has one generic kernel, which accepts only arrays of lanes and, except for derivatives, processes [`CHUNK`] lanes at a time. [`chains`] computes
//! several operations in one kernel.

mod chain_table;
pub mod chains;
pub mod class;
mod operand;
mod ops;

use super::math::Real;
use super::tape::{Op, with_ops};
use class::UNROLLED_LANES;
pub use class::{CHUNK, KernelClass, KernelFn, Kernels, LANES, ScalarFn};
use operand::{KernelOperand, unchecked_ref};
pub(crate) use ops::Eval;

/// The function that computes an operation on single values.
fn scalar_of<R: Real>(op: Op, has_fma: bool) -> ScalarFn<R> {
    macro_rules! arms {
        ($($name:ident $arity:literal,)*) => {
            match (op, has_fma) {
                $((Op::$name, true) => ops::$name::eval::<R, true>,
                  (Op::$name, false) => ops::$name::eval::<R, false>,)*
            }
        };
    }
    with_ops!(arms)
}

/// Computes one operation on single values. `has_fma`: whether multiply-adds round once.
pub fn eval<R: Real>(op: Op, has_fma: bool, a: R, b: R, c: R) -> R {
    R::scalar(op, has_fma)(a, b, c)
}

/// Computes one operation for `N` lanes. `A`, `B`, `C`: whether the operand has one value per lane. `FMA`: whether multiply-adds round once.
/// # Safety
/// Each operand is valid for `N` reads, or for one if its flag is false, and does not overlap `dst`.
#[inline(always)]
unsafe fn run_lanes<O: Eval, R: Real, const N: usize, const A: bool, const B: bool, const C: bool, const FMA: bool>(
    dst: &mut [R; N],
    a: *const R,
    b: *const R,
    c: *const R,
) {
    // SAFETY: the caller guarantees validity.
    let (a, b, c) = unsafe { (KernelOperand::<R, N>::new(a, A), KernelOperand::<R, N>::new(b, B), KernelOperand::<R, N>::new(c, C)) };
    for (k, part) in dst.chunks_mut(UNROLLED_LANES).enumerate() {
        for (i, d) in part.iter_mut().enumerate() {
            let lane = k * UNROLLED_LANES + i;
            *d = O::eval::<R, FMA>(a.at(lane), b.at(lane), c.at(lane));
        }
    }
}

/// Difference of neighbours in each 2x2 quad: along x (`STEP` 1) or y (`STEP` 2).
/// # Safety
/// `a` is valid for `N` reads and does not overlap `dst`; `N` is a multiple of 4.
#[inline(always)]
unsafe fn quad_difference<R: Real, const N: usize, const STEP: usize>(dst: &mut [R; N], a: *const R) {
    // SAFETY: the caller guarantees validity and disjointness.
    let a = unsafe { std::slice::from_raw_parts(a, N) };
    for (d, s) in dst.chunks_exact_mut(4).zip(a.chunks_exact(4)) {
        // Values are copied one by one, which compiles to vector shuffles and one subtraction. Copying an array would compile to four small
        // stores and one large load of the same bytes, which stalls.
        let [from, to] = if STEP == 1 { [[0, 0, 2, 2], [1, 1, 3, 3]] } else { [[0, 1, 0, 1], [2, 3, 2, 3]] };
        (d[0], d[1], d[2], d[3]) = (s[to[0]] - s[from[0]], s[to[1]] - s[from[1]], s[to[2]] - s[from[2]], s[to[3]] - s[from[3]]);
    }
}

/// The address of operand `k`: `base` plus entry `k` of `offsets`, in elements.
/// # Safety
/// `offsets` has more than `k` entries, and entry `k` lies inside the allocation of `base`.
#[inline(always)]
unsafe fn operand_at<R>(base: *const R, offsets: *const u32, k: usize) -> *const R {
    // SAFETY: the caller guarantees it.
    unsafe { base.add(*unchecked_ref(offsets.add(k)) as usize) }
}

/// The type of a chain, by nesting: [`chains::Then`] around the type of the chain before each operation.
macro_rules! nested {
    ($chain:ty) => { $chain };
    ($chain:ty, $op:ident $chained:literal $(, $next:ident $next_chained:literal)*) => {
        nested!(chains::Then<$chain, ops::$op, $chained> $(, $next $next_chained)*)
    };
}

/// A module with all kernels, compiled for one class: `$feature` enables its instruction set.
macro_rules! class {
    ($module:ident, $has_fma:literal, $(#[$feature:meta])*) => {
        mod $module {
            use super::*;

            /// The specialised kernel of `O` for operands of these kinds.
            /// # Safety
            /// As [`run_lanes`] for operands at their offsets; the instruction set of this class is available.
            $(#[$feature])*
            unsafe fn fixed_kinds<O: Eval, R: Real, const A: bool, const B: bool, const C: bool>(
                dst: &mut [R; LANES], base: *const R, offsets: *const u32,
            ) {
                // SAFETY: the caller guarantees it.
                unsafe {
                    let (a, b, c) = (operand_at(base, offsets, 0), operand_at(base, offsets, 1), operand_at(base, offsets, 2));
                    run_lanes::<O, R, LANES, A, B, C, $has_fma>(dst, a, b, c)
                }
            }

            /// The kernel of the chain `C` for operands of these kinds.
            /// # Safety
            /// As [`chains::run_lanes`]; the instruction set of this class is available.
            $(#[$feature])*
            unsafe fn chain<C: chains::FusedKernel, R: Real, const KINDS: u8>(
                dst: &mut [R; LANES], base: *const R, offsets: *const u32,
            ) {
                // SAFETY: the caller guarantees it.
                unsafe { chains::run_lanes::<C, R, LANES, KINDS, $has_fma>(dst, base, offsets) }
            }

            /// The generic kernel of `O`.
            /// # Safety
            /// As [`run_lanes`] for operands at their offsets, all of them arrays of lanes; the instruction set is available.
            $(#[$feature])*
            unsafe fn chunked<O: Eval, R: Real>(dst: &mut [R; LANES], base: *const R, offsets: *const u32) {
                // SAFETY: the caller guarantees it.
                let (a, b, c) = unsafe { (operand_at(base, offsets, 0), operand_at(base, offsets, 1), operand_at(base, offsets, 2)) };
                for (k, chunk) in dst.as_chunks_mut::<CHUNK>().0.iter_mut().enumerate() {
                    let first = k * CHUNK;
                    // SAFETY: each chunk lies inside the lanes of the operands.
                    unsafe { run_lanes::<O, R, CHUNK, true, true, true, $has_fma>(chunk, a.add(first), b.add(first), c.add(first)) }
                }
            }

            /// # Safety
            /// As [`quad_difference`] for the first offset; the instruction set is available.
            $(#[$feature])*
            unsafe fn dpdx<R: Real>(dst: &mut [R; LANES], base: *const R, offsets: *const u32) {
                // SAFETY: the caller guarantees it.
                unsafe { quad_difference::<R, LANES, 1>(dst, operand_at(base, offsets, 0)) }
            }

            /// # Safety
            /// As [`quad_difference`] for the first offset; the instruction set is available.
            $(#[$feature])*
            unsafe fn dpdy<R: Real>(dst: &mut [R; LANES], base: *const R, offsets: *const u32) {
                // SAFETY: the caller guarantees it.
                unsafe { quad_difference::<R, LANES, 2>(dst, operand_at(base, offsets, 0)) }
            }

            // The specialised kernel of an operation with one, two or three operands; `None` if each operand has one value for all lanes.
            fn unary<O: Eval, R: Real>(is_array: [bool; 3]) -> Option<KernelFn<R>> {
                is_array[0].then_some(fixed_kinds::<O, R, true, false, false>)
            }

            fn binary<O: Eval, R: Real>(is_array: [bool; 3]) -> Option<KernelFn<R>> {
                Some(match is_array {
                    [true, true, _] => fixed_kinds::<O, R, true, true, false>,
                    [true, false, _] => fixed_kinds::<O, R, true, false, false>,
                    [false, true, _] => fixed_kinds::<O, R, false, true, false>,
                    _ => return None,
                })
            }

            fn ternary<O: Eval, R: Real>(is_array: [bool; 3]) -> Option<KernelFn<R>> {
                Some(match is_array {
                    [true, true, true] => fixed_kinds::<O, R, true, true, true>,
                    [true, true, false] => fixed_kinds::<O, R, true, true, false>,
                    [true, false, true] => fixed_kinds::<O, R, true, false, true>,
                    [true, false, false] => fixed_kinds::<O, R, true, false, false>,
                    [false, true, true] => fixed_kinds::<O, R, false, true, true>,
                    [false, true, false] => fixed_kinds::<O, R, false, true, false>,
                    [false, false, true] => fixed_kinds::<O, R, false, false, true>,
                    _ => return None,
                })
            }

            /// The kernel for operands of these kinds (true: array of lanes), if there is one.
            pub fn specialised<R: Real>(op: Op, is_array: [bool; 3]) -> Option<KernelFn<R>> {
                match op {
                    Op::Copy if is_array[0] => Some(fixed_kinds::<ops::Copy, R, true, false, false>),
                    Op::Copy => Some(fixed_kinds::<ops::Copy, R, false, false, false>),
                    Op::Neg => unary::<ops::Neg, R>(is_array),
                    Op::Abs => unary::<ops::Abs, R>(is_array),
                    Op::Sqrt => unary::<ops::Sqrt, R>(is_array),
                    Op::InverseSqrt => unary::<ops::InverseSqrt, R>(is_array),
                    Op::Floor => unary::<ops::Floor, R>(is_array),
                    Op::Fract => unary::<ops::Fract, R>(is_array),
                    Op::BNot => unary::<ops::BNot, R>(is_array),
                    Op::Exp => unary::<ops::Exp, R>(is_array),
                    Op::Exp2 => unary::<ops::Exp2, R>(is_array),
                    Op::Log => unary::<ops::Log, R>(is_array),
                    Op::Asin => unary::<ops::Asin, R>(is_array),
                    Op::Acos => unary::<ops::Acos, R>(is_array),
                    Op::IFromF => unary::<ops::IFromF, R>(is_array),
                    Op::FFromI => unary::<ops::FFromI, R>(is_array),
                    Op::IAdd => binary::<ops::IAdd, R>(is_array),
                    Op::FEq => binary::<ops::FEq, R>(is_array),
                    Op::Add => binary::<ops::Add, R>(is_array),
                    Op::Sub => binary::<ops::Sub, R>(is_array),
                    Op::Mul => binary::<ops::Mul, R>(is_array),
                    Op::Div => binary::<ops::Div, R>(is_array),
                    Op::Min => binary::<ops::Min, R>(is_array),
                    Op::Max => binary::<ops::Max, R>(is_array),
                    Op::FLt => binary::<ops::FLt, R>(is_array),
                    Op::FLe => binary::<ops::FLe, R>(is_array),
                    Op::And => binary::<ops::And, R>(is_array),
                    Op::Or => binary::<ops::Or, R>(is_array),
                    Op::Fma => ternary::<ops::Fma, R>(is_array),
                    Op::Fms => ternary::<ops::Fms, R>(is_array),
                    Op::Fnma => ternary::<ops::Fnma, R>(is_array),
                    Op::Select => ternary::<ops::Select, R>(is_array),
                    _ => None,
                }
            }

            with_ops!(generic_kernels);
            chains::with_chains!(chain_kernels);
        }
    };
}

macro_rules! generic_kernels {
    ($($name:ident $arity:literal,)*) => {
        /// The kernel whose operands must all be arrays of lanes.
        pub fn generic<R: Real>(op: Op) -> KernelFn<R> {
            match op {
                Op::Dpdx => dpdx::<R>,
                Op::Dpdy => dpdy::<R>,
                $(#[allow(unreachable_patterns, reason = "the list of all operations contains the two above as well")]
                Op::$name => chunked::<ops::$name, R>,)*
            }
        }
    };
}

macro_rules! chain_kernels {
    ($($kinds:literal = $first:ident $(> $op:ident $chained:literal)+,)*) => {
        /// The kernels of [`chains::all`], in that order.
        pub fn chain_kernels<R: Real>() -> &'static [KernelFn<R>] {
            const {
                &[$(chain::<nested!(chains::First<ops::$first> $(, $op $chained)+), R, { chains::kind_bits($kinds) }> as KernelFn<R>,)*]
            }
        }
    };
}

// The classes without fused multiply-add: SSE2, which every x86-64 machine has, and the portable class.
class!(without_fma, false,);
#[cfg(target_arch = "x86_64")]
class!(avx2, true, #[target_feature(enable = "avx2,fma")]);
#[cfg(target_arch = "x86_64")]
class!(avx512, true, #[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma")]);
#[cfg(target_arch = "aarch64")]
class!(neon, true, #[target_feature(enable = "neon")]);

/// Calls a function of the module of kernels compiled for `$class`. SSE2, the portable class and classes that the target architecture lacks use the module
/// without fused multiply-add.
macro_rules! for_class {
    ($class:ident, $call:ident::<$t:ty>($($arg:ident),*)) => {
        match $class {
            #[cfg(target_arch = "x86_64")]
            KernelClass::Avx512 => avx512::$call::<$t>($($arg),*),
            #[cfg(target_arch = "x86_64")]
            KernelClass::Avx2Fma => avx2::$call::<$t>($($arg),*),
            #[cfg(target_arch = "aarch64")]
            KernelClass::Neon => neon::$call::<$t>($($arg),*),
            _ => without_fma::$call::<$t>($($arg),*),
        }
    };
}

/// Implements [`Kernels`] for an element type.
macro_rules! kernels_of {
    ($t:ty, chain_kernels: |$class:ident| $chains:expr) => {
        impl Kernels for $t {
            #[inline(never)]
            fn scalar(op: Op, has_fma: bool) -> ScalarFn<Self> {
                scalar_of::<$t>(op, has_fma)
            }
            #[inline(never)]
            fn specialised(class: KernelClass, op: Op, is_array: [bool; 3]) -> Option<KernelFn<Self>> {
                for_class!(class, specialised::<$t>(op, is_array))
            }
            #[inline(never)]
            fn generic(class: KernelClass, op: Op) -> KernelFn<Self> {
                for_class!(class, generic::<$t>(op))
            }
            #[inline(never)]
            fn chain_kernels(class: KernelClass) -> &'static [KernelFn<Self>] {
                let $class = class;
                $chains
            }
        }
    };
}
kernels_of!(f32, chain_kernels: |class| for_class!(class, chain_kernels::<f32>()));
kernels_of!(f64, chain_kernels: |_class| &[]);
