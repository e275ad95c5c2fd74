//! Operands of a kernel: read in the same way whether they have one value per lane or one for all lanes.

use crate::render::software::math::Real;

/// The value at a pointer. Debug builds check each dereferenced pointer, which takes a fifth of a kernel's instructions; they do not check a
/// transmuted one.
/// # Safety
/// `pointer` is aligned, and valid for reads during the lifetime of the result.
#[inline(always)]
pub(super) unsafe fn unchecked_ref<'a, T>(pointer: *const T) -> &'a T {
    #[allow(clippy::transmute_ptr_to_ref, reason = "a dereferenced pointer is checked in debug builds")]
    // SAFETY: the caller guarantees it.
    unsafe {
        std::mem::transmute::<*const T, &T>(pointer)
    }
}

/// An operand: lanes, or one value for all lanes. It contains a reference instead of a pointer, because debug builds check every use of a pointer,
/// and loops with such checks are not vectorised.
pub(crate) struct KernelOperand<'a, R, const N: usize> {
    lanes: Option<&'a [R; N]>,
    shared: R,
}

impl<R: Real, const N: usize> KernelOperand<'_, R, N> {
    /// # Safety
    /// `values` is aligned, and valid for `N` reads, or for one if `is_per_lane` is false, during the lifetime of the result.
    #[inline(always)]
    pub(crate) unsafe fn new(values: *const R, is_per_lane: bool) -> Self {
        // SAFETY: the caller guarantees it. An array of `N` values has the alignment of one.
        unsafe { Self { lanes: if is_per_lane { Some(unchecked_ref(values.cast())) } else { None }, shared: *unchecked_ref(values) } }
    }

    #[inline(always)]
    pub(crate) fn at(&self, lane: usize) -> R {
        match self.lanes {
            Some(values) => values[lane],
            None => self.shared,
        }
    }
}
