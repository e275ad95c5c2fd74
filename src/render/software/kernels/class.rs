//! Classes of SIMD kernels (instruction sets), and the trait that supplies the kernels of an element type (f32 or f64).
//!
//! In: a class, an operation. Out: kernels. Every operation has a *generic* kernel, whose operands are arrays of lanes. Frequent operations also have
//! *specialised* ones, one for each combination of operand kinds (array of lanes, or one value for all lanes). A *chain's* kernel computes several operations.

use crate::render::software::tape::Op;
use std::sync::OnceLock;

/// Number of lanes that a generic kernel, or the test whether a mask is set in any lane, processes at a time. [`LANES`] is a multiple of this number.
pub const CHUNK: usize = 32;

/// Number of lanes of a batch: 32 quads of 4 pixels. Measured as the fastest of 32, 64, 128 and 256: with fewer lanes the time of the calls dominates, with
/// more the data no longer fit into the L1 cache.
pub const LANES: usize = 128;

/// Number of lanes of the inner loop of a specialised kernel or of a chain's kernel. The compiler vectorises and then unrolls a loop of this length, even if
/// the kernel has many operations. A loop over all [`LANES`] is not unrolled, and therefore executes three more instructions per vector. A shorter loop may be
/// unrolled before the compiler can vectorise it.
pub(super) const UNROLLED_LANES: usize = 64;

/// A SIMD kernel. Arguments: the lanes that it writes; the base of the operands; the offset of each operand from the base, in elements. Each kernel is
/// compiled for fixed operand kinds. A kernel of one operation reads three offsets even if it has fewer operands; a chain's kernel reads one for each operand.
/// The `&mut` tells the compiler that no operand overlaps the written lanes.
///
/// # Safety
/// The machine has the instruction set of the kernel's class. Each operand is valid for reads: of [`LANES`] elements if it is an array, otherwise of one.
pub type KernelFn<R> = unsafe fn(&mut [R; LANES], *const R, *const u32);

/// The instruction set of the kernels. The classes with fused multiply-add give the same bits as each other, and so do the classes without.
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
            let has_avx2_fma = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            // The features with which the kernels of this class are compiled.
            let has_avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512bw");
            if has_avx2_fma && has_avx512 {
                all.push(Self::Avx512);
            }
            if has_avx2_fma {
                all.push(Self::Avx2Fma);
            }
            all.push(Self::Sse2);
        }
        #[cfg(target_arch = "aarch64")]
        all.push(Self::Neon);
        all.push(Self::Portable);
        all
    }

    /// The class in use: the one that `ORRERY_KERNELS` names, or the best available if the variable names none of [`Self::available`]. Decided once per
    /// process.
    pub fn in_use() -> Self {
        static CLASS: OnceLock<KernelClass> = OnceLock::new();
        *CLASS.get_or_init(|| {
            let all = Self::available();
            let requested = std::env::var("ORRERY_KERNELS").ok();
            requested.and_then(|name| all.iter().copied().find(|c| c.name() == name)).unwrap_or(all[0])
        })
    }

    /// What is wrong with `ORRERY_KERNELS`, if it names no class that this machine can run and is therefore ignored.
    pub fn unavailable_choice() -> Option<String> {
        let requested = std::env::var_os("ORRERY_KERNELS")?.to_string_lossy().into_owned();
        let available: Vec<&str> = Self::available().iter().map(|class| class.name()).collect();
        let is_unavailable = !requested.is_empty() && !available.contains(&requested.as_str());
        is_unavailable.then(|| {
            let (requested, used) = (requested.escape_default().take(60).collect::<String>(), Self::in_use().name());
            format!("ORRERY_KERNELS={requested}: not one of {}; {used} is used", available.join(", "))
        })
    }

    /// The name in `ORRERY_KERNELS` and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2Fma => "avx2",
            Self::Sse2 => "sse2",
            Self::Neon => "neon",
            Self::Portable => "portable",
        }
    }

    /// Whether the class has fused multiply-add.
    pub fn has_fma(self) -> bool {
        matches!(self, Self::Avx512 | Self::Avx2Fma | Self::Neon)
    }
}

/// One operation on single values.
pub type ScalarFn<R> = fn(R, R, R) -> R;

/// The kernels of an element type.
///
/// Implemented for f32 and f64, so that the kernels (some 2,000) are compiled once. Generic functions would be compiled again in every program that uses this
/// library.
pub trait Kernels: Sized + 'static {
    /// One operation on single values, for constant folding and operations on registers. `has_fma`: whether multiply-adds round once.
    fn scalar(op: Op, has_fma: bool) -> ScalarFn<Self>;
    /// The kernel for these operands (true: an array of lanes, false: one value); `None` if there is only the generic kernel. The kernels of a class may be
    /// called only on machines where the class is in [`KernelClass::available`].
    fn specialised(class: KernelClass, op: Op, is_array: [bool; 3]) -> Option<KernelFn<Self>>;
    /// The kernel whose operands must all be arrays of lanes.
    fn generic(class: KernelClass, op: Op) -> KernelFn<Self>;
    /// The kernels of [`all`](super::chains::all), in that order. Empty for f64, which is used only for checks and would double the build time; a
    /// chain then runs as single operations, with the same bits.
    fn chain_kernels(class: KernelClass) -> &'static [KernelFn<Self>];
}
