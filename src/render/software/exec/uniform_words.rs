//! Reads words of a uniform block: one, or one per lane where the index differs between lanes.
//!
//! In: the block's words, an element's index, and the position of the elements in the block ([`UniformElements`]). Out: values. Always: an index beyond
//! the last element reads the last one, and a word beyond the block reads as 0. Not here: the layout of the block (`shader::reflect`).

use super::LANES;
use crate::render::software::math::Real;
use crate::render::software::tape::WordKind;

/// The position of one word in each element of an array in the uniform block.
#[derive(Clone, Copy)]
pub(crate) struct UniformElements {
    pub kind: WordKind,
    /// Byte offset of the word in the first element.
    pub offset: u32,
    /// Bytes from one element to the next.
    pub stride: u32,
    /// Number of elements.
    pub count: u32,
}

impl UniformElements {
    fn last_index(self) -> u32 {
        self.count.max(1) - 1
    }

    fn value<R: Real>(self, bits: u32) -> R {
        match self.kind {
            WordKind::Float => R::from_f32_bits(bits),
            WordKind::Int => R::from_lane_bits(bits),
        }
    }

    /// The word of the element at `index`.
    pub fn read<R: Real>(self, words: &[u32], index: u32) -> R {
        let word = self.offset.saturating_add(index.min(self.last_index()).saturating_mul(self.stride)) as usize / 4;
        self.value(words.get(word).copied().unwrap_or(0))
    }

    /// The part of the block from the first element's word to the last element's word, and the number of words from one element to the next. `None` if the
    /// block ends before the last element's word, if offset or stride are not whole words, or if a word index needs more than 31 bits.
    fn span(self, words: &[u32]) -> Option<(&[u32], u32)> {
        let (first, word_stride) = (self.offset as usize / 4, self.stride / 4);
        let last = (self.last_index() as usize).checked_mul(word_stride as usize)?;
        let is_aligned = self.offset.is_multiple_of(4) && self.stride.is_multiple_of(4);
        let end = first.checked_add(last)?.checked_add(1)?;
        words.get(first..end).filter(|_| is_aligned && last < i32::MAX as usize).map(|span| (span, word_stride))
    }

    /// The word of each lane's element. Not inlined: the loop over a tape's steps would keep fewer of its values in processor registers.
    #[inline(never)]
    pub fn gather<R: Real>(self, words: &[u32], indices: &[R; LANES], out: &mut [R; LANES]) {
        let Some((span, word_stride)) = self.span(words) else {
            for (out, index) in out.iter_mut().zip(indices) {
                *out = self.read(words, index.lane_bits());
            }
            return;
        };
        #[cfg(target_arch = "x86_64")]
        if let (Some(indices), Some(out)) = (R::as_f32(indices), R::as_f32_mut(out))
            && is_x86_feature_detected!("avx2")
        {
            // SAFETY: AVX2 was detected, and `span` ends with the last element.
            unsafe { gather_avx2(span, word_stride, self.last_index(), indices, out) };
            return;
        }
        for (out, index) in out.iter_mut().zip(indices) {
            *out = self.value(span[(index.lane_bits().min(self.last_index()) * word_stride) as usize]);
        }
    }
}

/// [`UniformElements::gather`] for f32, where a value has the same bits as its word, whatever its kind.
/// # Safety
/// AVX2 is available; `last_index * word_stride` is below 2^31, and `span` has more words than that; `indices` and `out` have the same length, a multiple of 8.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn gather_avx2(span: &[u32], word_stride: u32, last_index: u32, indices: &[f32], out: &mut [f32]) {
    use std::arch::x86_64::{__m256i, _mm256_i32gather_epi32, _mm256_min_epu32, _mm256_mullo_epi32, _mm256_set1_epi32};
    let last = _mm256_set1_epi32(last_index.cast_signed());
    let word_stride = _mm256_set1_epi32(word_stride.cast_signed());
    for (out, indices) in out.as_chunks_mut::<8>().0.iter_mut().zip(indices.as_chunks::<8>().0) {
        // SAFETY: an array of eight words has the size of an AVX register; no word index is greater than the last element's.
        unsafe {
            let index = _mm256_min_epu32(std::mem::transmute::<[f32; 8], __m256i>(*indices), last);
            let words = _mm256_i32gather_epi32::<4>(span.as_ptr().cast(), _mm256_mullo_epi32(index, word_stride));
            *out = std::mem::transmute::<__m256i, [f32; 8]>(words);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares each lane with a single read, for indices inside and beyond the array.
    fn assert_gather_equals_single_reads<R: Real>(elements: UniformElements, words: &[u32]) {
        let indices: [R; LANES] = std::array::from_fn(|lane| match lane {
            0 => R::from_lane_bits(u32::MAX),
            1 => R::from_lane_bits(1 << 31),
            _ => R::from_lane_bits(lane as u32 % 9),
        });
        let mut gathered = [R::ZERO; LANES];
        elements.gather(words, &indices, &mut gathered);
        for (lane, (gathered, index)) in gathered.iter().zip(&indices).enumerate() {
            let single: R = elements.read(words, index.lane_bits());
            assert_eq!(gathered.to_f64().to_bits(), single.to_f64().to_bits(), "lane {lane}, index {}", index.lane_bits());
        }
    }

    #[test]
    fn gather_returns_in_each_lane_what_a_single_read_returns() {
        // A block of 160 bytes.
        let words: Vec<u32> = (0..40).map(|k| (1.5 * k as f32).to_bits()).collect();
        let elements = |kind, offset, stride, count| UniformElements { kind, offset, stride, count };
        let inside = [
            elements(WordKind::Float, 8, 16, 7),
            elements(WordKind::Int, 4, 4, 9),
            elements(WordKind::Float, 0, 16, 0),
            elements(WordKind::Float, 156, 16, 1),
        ];
        // The last elements lie beyond the block, or the words are not aligned.
        let beyond = [
            elements(WordKind::Float, 8, 32, 7),
            elements(WordKind::Float, 400, 4, 3),
            elements(WordKind::Float, 2, 6, 4),
            elements(WordKind::Int, 0, u32::MAX, 3),
        ];
        for (elements, has_span) in inside.map(|e| (e, true)).into_iter().chain(beyond.map(|e| (e, false))) {
            assert_eq!(elements.span(&words).is_some(), has_span);
            assert_gather_equals_single_reads::<f32>(elements, &words);
            assert_gather_equals_single_reads::<f64>(elements, &words);
        }
    }
}
