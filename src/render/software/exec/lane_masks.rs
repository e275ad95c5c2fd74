//! Reads the mask that a slot contains, with AVX2: which lanes are set, and whether any lane is set. In: the slot's lanes. A lane is set if any of its bits is.

use super::{LANES, LaneMask};

/// The mask of the lanes that are set.
#[target_feature(enable = "avx2")]
pub(super) fn mask_avx2(lanes: &[f32; LANES]) -> LaneMask {
    use std::arch::x86_64::{
        __m256i, _mm256_and_si256, _mm256_castsi256_ps, _mm256_cmpeq_epi32, _mm256_movemask_ps, _mm256_set1_epi32, _mm256_setzero_si256,
        _mm256_testc_si256,
    };
    // Usually all lanes are active, and every bit of each is set.
    let mut common_bits = _mm256_set1_epi32(-1);
    for lanes in lanes.as_chunks::<8>().0 {
        // SAFETY: an array of eight words has the size of an AVX register.
        common_bits = _mm256_and_si256(common_bits, unsafe { std::mem::transmute::<[f32; 8], __m256i>(*lanes) });
    }
    if _mm256_testc_si256(common_bits, _mm256_set1_epi32(-1)) == 1 {
        return LaneMask::MAX;
    }
    // One bit per lane, set if the lane is not.
    let mut unset_lanes = [0u8; LANES / 8];
    for (byte, lanes) in unset_lanes.iter_mut().zip(lanes.as_chunks::<8>().0) {
        // SAFETY: an array of eight words has the size of an AVX register.
        let lanes = unsafe { std::mem::transmute::<[f32; 8], __m256i>(*lanes) };
        *byte = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(lanes, _mm256_setzero_si256()))) as u8;
    }
    !LaneMask::from_le_bytes(unset_lanes)
}

/// Whether any lane is set. Usually one of the first 32 lanes is, and the others are not read.
#[target_feature(enable = "avx2")]
pub(super) fn is_any_set_avx2(lanes: &[f32; LANES]) -> bool {
    use std::arch::x86_64::{__m256i, _mm256_or_si256, _mm256_testz_si256};
    for lanes in lanes.as_chunks::<32>().0 {
        // SAFETY: a chunk of 32 words has the size of four AVX registers.
        let [a, b, c, d] = unsafe { std::mem::transmute::<[f32; 32], [__m256i; 4]>(*lanes) };
        let united_bits = _mm256_or_si256(_mm256_or_si256(a, b), _mm256_or_si256(c, d));
        if _mm256_testz_si256(united_bits, united_bits) == 0 {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_lane_with_any_bit_set_is_in_the_mask() {
        if !is_x86_feature_detected!("avx2") {
            return;
        }
        let all_bits = f32::from_bits(u32::MAX);
        // SAFETY: AVX2 was detected.
        let mask = |lanes: &[f32; LANES]| unsafe { mask_avx2(lanes) };
        assert_eq!(mask(&[all_bits; LANES]), LaneMask::MAX);
        assert_eq!(mask(&[0.0; LANES]), 0);
        for lane in [0, 7, 64, LANES - 1] {
            for (bits, is_set) in [(0, false), (1, true), (u32::MAX, true)] {
                let mut lanes = [all_bits; LANES];
                lanes[lane] = f32::from_bits(bits);
                let others = LaneMask::MAX ^ 1 << lane;
                assert_eq!(mask(&lanes), if is_set { LaneMask::MAX } else { others }, "lane {lane}, bits {bits:x}");
            }
        }
    }

    #[test]
    fn a_single_bit_of_any_lane_is_found() {
        if !is_x86_feature_detected!("avx2") {
            return;
        }
        // SAFETY: AVX2 was detected.
        let is_any_set = |lanes: &[f32; LANES]| unsafe { is_any_set_avx2(lanes) };
        assert!(!is_any_set(&[0.0; LANES]));
        for lane in 0..LANES {
            // The sign bit alone makes -0.0, which equals 0.0 as a number.
            for bits in [1, 1 << 31, u32::MAX] {
                let mut lanes = [0.0; LANES];
                lanes[lane] = f32::from_bits(bits);
                assert!(is_any_set(&lanes), "lane {lane}, bits {bits:x}");
            }
        }
    }
}
