//! Vector kernels: one generic source, compiled once per instruction set and chosen at run time.
//!
//! In: pointers to lanes or to one broadcast value. Out: `N` lanes written. Frequent operations have one kernel per combination of
//! operand kinds with the lane count known at compile time; the rest take lane operands only and run in pieces of [`CHUNK`] lanes.

mod ops;

use super::math::Real;
use super::tape::{Op, with_ops};
pub use ops::Eval;
use std::sync::OnceLock;

/// Lanes of one piece of the less frequent kernels; every lane count is a multiple of it.
pub const CHUNK: usize = 32;

/// dst, three operands (lane arrays or single values as the table was asked), number of lanes.
pub type KernelFn<R> = unsafe fn(*mut R, *const R, *const R, *const R, usize);

/// Which instruction set the kernels use. Classes that fuse multiply and add give the same bits, and so do those that do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum KernelClass {
    Avx512,
    Avx2Fma,
    Sse2,
    Neon,
    /// Any machine, without fused multiply-add.
    Portable,
}

impl KernelClass {
    /// All classes that this machine can run, best first.
    pub fn available() -> Vec<Self> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            let fma = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            let wide = ["avx512f", "avx512dq", "avx512vl", "avx512bw"];
            let has = |f: &str| match f {
                "avx512f" => is_x86_feature_detected!("avx512f"),
                "avx512dq" => is_x86_feature_detected!("avx512dq"),
                "avx512vl" => is_x86_feature_detected!("avx512vl"),
                _ => is_x86_feature_detected!("avx512bw"),
            };
            if fma && wide.iter().all(|f| has(f)) {
                all.push(Self::Avx512);
            }
            if fma {
                all.push(Self::Avx2Fma);
            }
            all.push(Self::Sse2);
        }
        #[cfg(target_arch = "aarch64")]
        all.push(Self::Neon);
        all.push(Self::Portable);
        all
    }

    /// The class in use: the best available, or the one named by `ORRERY_KERNELS` when this machine has it. Decided once per process.
    pub fn detect() -> Self {
        static CLASS: OnceLock<KernelClass> = OnceLock::new();
        *CLASS.get_or_init(|| {
            let all = Self::available();
            let wanted = std::env::var("ORRERY_KERNELS").ok();
            wanted.and_then(|w| all.iter().copied().find(|c| c.name() == w)).unwrap_or(all[0])
        })
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2Fma => "avx2",
            Self::Sse2 => "sse2",
            Self::Neon => "neon",
            Self::Portable => "portable",
        }
    }

    /// Whether multiply and add round once.
    pub fn fused(self) -> bool {
        matches!(self, Self::Avx512 | Self::Avx2Fma | Self::Neon)
    }
}

/// Computes one operation on single values: folding and the per-draw tape.
pub fn eval<R: Real>(op: Op, fused: bool, a: R, b: R, c: R) -> R {
    macro_rules! arms {
        ($($name:ident $arity:literal,)*) => {
            match (op, fused) {
                $((Op::$name, true) => ops::$name::eval::<R, true>(a, b, c),
                  (Op::$name, false) => ops::$name::eval::<R, false>(a, b, c),)*
            }
        };
    }
    with_ops!(arms)
}

/// # Safety
/// `dst` is valid for `N` writes and disjoint from the operands, which are valid for `N` reads, or one where their flag is false.
#[inline(always)]
unsafe fn lanes<O: Eval, R: Real, const N: usize, const A: bool, const B: bool, const C: bool, const F: bool>(
    dst: *mut R,
    a: *const R,
    b: *const R,
    c: *const R,
) {
    // SAFETY: the caller vouches for validity and disjointness.
    unsafe {
        let dst = &mut *dst.cast::<[R; N]>();
        let (a0, b0, c0) = (*a, *b, *c);
        for (i, d) in dst.iter_mut().enumerate() {
            let x = if A { *a.add(i) } else { a0 };
            let y = if B { *b.add(i) } else { b0 };
            let z = if C { *c.add(i) } else { c0 };
            *d = O::eval::<R, F>(x, y, z);
        }
    }
}

/// Difference of neighbours in each 2x2 quad: along x (`STEP` 1) or y (`STEP` 2).
/// # Safety
/// `dst` is valid for `n` writes and disjoint from `a`, which is valid for `n` reads; `n` is a multiple of 4.
#[inline(always)]
unsafe fn quad_difference<R: Real, const STEP: usize>(dst: *mut R, a: *const R, n: usize) {
    // SAFETY: the caller vouches for validity and disjointness.
    let (dst, a) = unsafe { (std::slice::from_raw_parts_mut(dst, n), std::slice::from_raw_parts(a, n)) };
    for (d, s) in dst.chunks_exact_mut(4).zip(a.chunks_exact(4)) {
        if STEP == 1 {
            let (top, bottom) = (s[1] - s[0], s[3] - s[2]);
            // Value by value: a copied array would be four small stores read back at once by a large load, which stalls.
            (d[0], d[1], d[2], d[3]) = (top, top, bottom, bottom);
        } else {
            let (left, right) = (s[2] - s[0], s[3] - s[1]);
            (d[0], d[1], d[2], d[3]) = (left, right, left, right);
        }
    }
}

macro_rules! class {
    ($module:ident, $fused:literal, $(#[$feature:meta])*) => {
        mod $module {
            use super::*;

            /// # Safety
            /// As [`lanes`]; the instruction set of this class is available.
            $(#[$feature])*
            unsafe fn fixed<O: Eval, R: Real, const N: usize, const A: bool, const B: bool, const C: bool>(
                dst: *mut R, a: *const R, b: *const R, c: *const R, _n: usize,
            ) {
                // SAFETY: passed on to the caller.
                unsafe { lanes::<O, R, N, A, B, C, $fused>(dst, a, b, c) }
            }

            /// # Safety
            /// As [`lanes`] with all operands lane arrays of `n` lanes, a multiple of [`CHUNK`]; the instruction set is available.
            $(#[$feature])*
            unsafe fn pieces<O: Eval, R: Real>(dst: *mut R, a: *const R, b: *const R, c: *const R, n: usize) {
                for k in (0..n).step_by(CHUNK) {
                    // SAFETY: each piece lies inside the n lanes.
                    unsafe { lanes::<O, R, CHUNK, true, true, true, $fused>(dst.add(k), a.add(k), b.add(k), c.add(k)) }
                }
            }

            /// # Safety
            /// As [`quad_difference`]; the instruction set is available.
            $(#[$feature])*
            unsafe fn dpdx<R: Real>(dst: *mut R, a: *const R, _b: *const R, _c: *const R, n: usize) {
                // SAFETY: passed on to the caller.
                unsafe { quad_difference::<R, 1>(dst, a, n) }
            }

            /// # Safety
            /// As [`quad_difference`]; the instruction set is available.
            $(#[$feature])*
            unsafe fn dpdy<R: Real>(dst: *mut R, a: *const R, _b: *const R, _c: *const R, n: usize) {
                // SAFETY: passed on to the caller.
                unsafe { quad_difference::<R, 2>(dst, a, n) }
            }

            fn unary<O: Eval, R: Real, const N: usize>(kinds: [bool; 3]) -> Option<KernelFn<R>> {
                kinds[0].then_some(fixed::<O, R, N, true, false, false>)
            }

            fn binary<O: Eval, R: Real, const N: usize>(kinds: [bool; 3]) -> Option<KernelFn<R>> {
                Some(match kinds {
                    [true, true, _] => fixed::<O, R, N, true, true, false>,
                    [true, false, _] => fixed::<O, R, N, true, false, false>,
                    [false, true, _] => fixed::<O, R, N, false, true, false>,
                    _ => return None,
                })
            }

            fn ternary<O: Eval, R: Real, const N: usize>(kinds: [bool; 3]) -> Option<KernelFn<R>> {
                Some(match kinds {
                    [true, true, true] => fixed::<O, R, N, true, true, true>,
                    [true, true, false] => fixed::<O, R, N, true, true, false>,
                    [true, false, true] => fixed::<O, R, N, true, false, true>,
                    [true, false, false] => fixed::<O, R, N, true, false, false>,
                    [false, true, true] => fixed::<O, R, N, false, true, true>,
                    [false, true, false] => fixed::<O, R, N, false, true, false>,
                    [false, false, true] => fixed::<O, R, N, false, false, true>,
                    _ => return None,
                })
            }

            /// The kernel that takes operands of these kinds as they are (true = lanes), if there is one.
            pub fn special<R: Real, const N: usize>(op: Op, kinds: [bool; 3]) -> Option<KernelFn<R>> {
                match op {
                    Op::Copy if kinds[0] => Some(fixed::<ops::Copy, R, N, true, false, false>),
                    Op::Copy => Some(fixed::<ops::Copy, R, N, false, false, false>),
                    Op::Neg => unary::<ops::Neg, R, N>(kinds),
                    Op::Abs => unary::<ops::Abs, R, N>(kinds),
                    Op::Sqrt => unary::<ops::Sqrt, R, N>(kinds),
                    Op::InverseSqrt => unary::<ops::InverseSqrt, R, N>(kinds),
                    Op::Floor => unary::<ops::Floor, R, N>(kinds),
                    Op::Fract => unary::<ops::Fract, R, N>(kinds),
                    Op::BNot => unary::<ops::BNot, R, N>(kinds),
                    Op::Exp => unary::<ops::Exp, R, N>(kinds),
                    Op::Exp2 => unary::<ops::Exp2, R, N>(kinds),
                    Op::Log => unary::<ops::Log, R, N>(kinds),
                    Op::Asin => unary::<ops::Asin, R, N>(kinds),
                    Op::Acos => unary::<ops::Acos, R, N>(kinds),
                    Op::Add => binary::<ops::Add, R, N>(kinds),
                    Op::Sub => binary::<ops::Sub, R, N>(kinds),
                    Op::Mul => binary::<ops::Mul, R, N>(kinds),
                    Op::Div => binary::<ops::Div, R, N>(kinds),
                    Op::Min => binary::<ops::Min, R, N>(kinds),
                    Op::Max => binary::<ops::Max, R, N>(kinds),
                    Op::FLt => binary::<ops::FLt, R, N>(kinds),
                    Op::FLe => binary::<ops::FLe, R, N>(kinds),
                    Op::And => binary::<ops::And, R, N>(kinds),
                    Op::Or => binary::<ops::Or, R, N>(kinds),
                    Op::Fma => ternary::<ops::Fma, R, N>(kinds),
                    Op::Fms => ternary::<ops::Fms, R, N>(kinds),
                    Op::Fnma => ternary::<ops::Fnma, R, N>(kinds),
                    Op::Select => ternary::<ops::Select, R, N>(kinds),
                    _ => None,
                }
            }

            with_ops!(general_table);
        }
    };
}

macro_rules! general_table {
    ($($name:ident $arity:literal,)*) => {
        /// The kernel that takes lane operands of any count.
        pub fn general<R: Real>(op: Op) -> KernelFn<R> {
            match op {
                Op::Dpdx => dpdx::<R>,
                Op::Dpdy => dpdy::<R>,
                $(#[allow(unreachable_patterns)]
                Op::$name => pieces::<ops::$name, R>,)*
            }
        }
    };
}

class!(plain, false,);
#[cfg(target_arch = "x86_64")]
class!(avx2, true, #[target_feature(enable = "avx2,fma")]);
#[cfg(target_arch = "x86_64")]
class!(avx512, true, #[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma")]);
#[cfg(target_arch = "aarch64")]
class!(neon, true, #[target_feature(enable = "neon")]);

/// The kernel for operands of these kinds (true = lanes); None when every operand must be lanes, which [`general`] takes.
/// The class must be one of [`KernelClass::available`] where the kernel is called.
pub fn special<R: Real, const N: usize>(class: KernelClass, op: Op, kinds: [bool; 3]) -> Option<KernelFn<R>> {
    match class {
        #[cfg(target_arch = "x86_64")]
        KernelClass::Avx512 => avx512::special::<R, N>(op, kinds),
        #[cfg(target_arch = "x86_64")]
        KernelClass::Avx2Fma => avx2::special::<R, N>(op, kinds),
        #[cfg(target_arch = "aarch64")]
        KernelClass::Neon => neon::special::<R, N>(op, kinds),
        _ => plain::special::<R, N>(op, kinds),
    }
}

/// The kernel that takes lane operands.
pub fn general<R: Real>(class: KernelClass, op: Op) -> KernelFn<R> {
    match class {
        #[cfg(target_arch = "x86_64")]
        KernelClass::Avx512 => avx512::general::<R>(op),
        #[cfg(target_arch = "x86_64")]
        KernelClass::Avx2Fma => avx2::general::<R>(op),
        #[cfg(target_arch = "aarch64")]
        KernelClass::Neon => neon::general::<R>(op),
        _ => plain::general::<R>(op),
    }
}
