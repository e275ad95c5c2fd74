//! Kernel classes (instruction sets), and what an element type must bring to be computed with: the interface between `math` and the kernels.

use crate::render::software::tape::Op;
use std::sync::OnceLock;

/// Lanes of one piece of the less frequent kernels; [`LANES`] is a multiple of it.
pub const CHUNK: usize = 32;

/// Lanes of a batch, of every kernel: 32 x 4 pixels. Measured best of 32, 64, 128 and 256: fewer and calls cost, more and the first cache is full.
pub const LANES: usize = 128;

/// The lanes that are written; where operands are counted from; the place of each operand, in elements (lane arrays or single values as the
/// table was asked). A kernel of one operation reads three places, whatever it uses; a chain's kernel one for each operand. That nothing
/// overlaps the written lanes is in the type, which spares every kernel the test.
pub type KernelFn<R> = unsafe fn(&mut [R; LANES], *const R, *const u32);

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

/// One operation on single values.
pub type ScalarFn<R> = fn(R, R, R) -> R;

/// The kernels of an element type.
///
/// Methods of two types and no generic functions: those would be compiled anew in every program that uses this library, 6,500 kernels each time.
pub trait Kernels: Sized + 'static {
    /// What computes one operation on single values: folding and the per-draw tape.
    fn scalar(op: Op, fused: bool) -> ScalarFn<Self>;
    /// The kernel for operands of these kinds (true = lanes); None when every operand must be lanes, which [`Kernels::general`] takes.
    /// The class must be one of [`KernelClass::available`] where the kernel is called; so for the others.
    fn special(class: KernelClass, op: Op, kinds: [bool; 3]) -> Option<KernelFn<Self>>;
    /// The kernel that takes lane operands.
    fn general(class: KernelClass, op: Op) -> KernelFn<Self>;
    /// The kernels of [`all`](super::chains::all), in that order; none for f64, which is for checks and would take as long to build again. There a chain
    /// runs as its single operations, with the same bits.
    fn chained(class: KernelClass) -> &'static [KernelFn<Self>];
}
