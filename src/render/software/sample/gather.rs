//! Texels of four bytes by gathers, eight in one instruction.
//!
//! In: places inside a level, each below its number of texels. Out: the same bits as one read after the other. Only where the machine has AVX2.

use super::texels::{Decode, Srgb, TexelLevel, Unorm, unorm};
use std::arch::x86_64::{__m256i, _mm256_i32gather_epi32, _mm256_loadu_si256, _mm256_storeu_si256};

/// A format read by gathers; sRGB takes its red, green and blue from their table by further ones. Made by [`Decode::gathering`] alone.
#[derive(Clone, Copy)]
pub struct Gathering<D>(pub(super) D);

/// Formats of four bytes a texel, and the table by which red, green and blue are decoded.
trait FourBytes: Decode<Texel = u32> {
    fn table(self) -> Option<&'static [f32; 256]>;
}

impl FourBytes for Srgb {
    #[inline(always)]
    fn table(self) -> Option<&'static [f32; 256]> {
        Some(self.0)
    }
}

impl FourBytes for Unorm {
    #[inline(always)]
    fn table(self) -> Option<&'static [f32; 256]> {
        None
    }
}

/// Words at `index` from `base`, eight at a time.
/// # Safety
/// Every index is below 2^31, `base` points to more than that many words, and the machine has AVX2.
#[inline(always)]
unsafe fn gather<const N: usize>(base: *const u8, index: &[u32; N]) -> [u32; N] {
    const { assert!(N.is_multiple_of(8)) };
    let mut out = [0; N];
    for (to, from) in out.as_chunks_mut::<8>().0.iter_mut().zip(index.as_chunks::<8>().0) {
        // SAFETY: passed on to the caller; both arrays hold eight words.
        unsafe {
            let at = _mm256_loadu_si256(from.as_ptr().cast::<__m256i>());
            _mm256_storeu_si256(to.as_mut_ptr().cast::<__m256i>(), _mm256_i32gather_epi32::<4>(base.cast::<i32>(), at));
        }
    }
    out
}

impl<D: FourBytes> Decode for Gathering<D> {
    type Texel = u32;
    type Gathering = Self;
    #[inline(always)]
    unsafe fn gathering(self) -> Self {
        self
    }
    #[inline(always)]
    unsafe fn stored(self, level: &TexelLevel<'_>, index: u32) -> u32 {
        // SAFETY: passed on to the caller.
        unsafe { self.0.stored(level, index) }
    }
    #[inline(always)]
    fn channel<const K: usize>(self, texel: u32) -> f32 {
        self.0.channel::<K>(texel)
    }
    #[inline(always)]
    fn channel_of_each<const K: usize, const N: usize>(self, texels: &[u32; N]) -> [f32; N] {
        let mut out = [0.0; N];
        match self.0.table().filter(|_| K < 3) {
            Some(table) => {
                let mut byte = [0; N];
                for (byte, texel) in byte.iter_mut().zip(texels) {
                    *byte = texel >> (8 * K) & 0xff;
                }
                // SAFETY: a byte is below the table's length; whoever made this has AVX2.
                let words = unsafe { gather(table.as_ptr().cast::<u8>(), &byte) };
                for (out, word) in out.iter_mut().zip(words) {
                    *out = f32::from_bits(word);
                }
            }
            None => {
                for (out, texel) in out.iter_mut().zip(texels) {
                    *out = unorm::<K>(*texel);
                }
            }
        }
        out
    }
    #[inline(always)]
    unsafe fn fetch<const N: usize>(self, level: &TexelLevel<'_>, index: &[u32; N]) -> [u32; N] {
        // SAFETY: a level has at most 2^30 texels ([`Texels::new`]), and the caller keeps to them; whoever made this has AVX2.
        unsafe { gather(level.bytes.as_ptr(), index) }
    }
}
