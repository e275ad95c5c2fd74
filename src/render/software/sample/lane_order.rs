//! The lanes of a batch in the order in which they are filtered: by mip level, then from many taps to few.
//!
//! In: a sort key for each lane, level * [`MAX_TAPS`] + ([`MAX_TAPS`] - taps), and the active lanes. Out: their order, by a counting sort; values in
//! that order, or back in their lanes. Not here: the filtering (`filter`).

// The compiler vectorises loops by index over several arrays of one fixed length.
#![allow(clippy::needless_range_loop)]

use crate::render::software::exec::{LANES, LaneMask};
use crate::render::software::math::Real;

/// Number of lanes in a batch.
pub(crate) const BATCH: usize = LANES;
/// Number of lanes that are fetched and interpolated together.
pub(super) const CHUNK: usize = 32;
/// Length of arrays in sorted order. A level's chunks begin at its first position, which need not be a multiple of [`CHUNK`], so the last chunk may
/// extend beyond the batch.
pub(super) const PADDED: usize = BATCH + CHUNK;
/// Maximum number of taps of a lane.
pub(crate) const MAX_TAPS: usize = 16;
/// Maximum number of mip levels that are read. Textures have at most 23, since a side has at most 2^22 texels; any number from 23 on would do.
/// [`LaneOrder::starts`] has entries for one level more, at which the last level ends.
pub(super) const MAX_LEVELS: usize = 31;

/// Red, green, blue, alpha of a batch; `None` for channels that are not needed.
pub(crate) type Channels<'a, R> = [Option<&'a mut [R; BATCH]>; 4];

/// An array for the values of a batch, initialised on first use.
pub(super) struct LazyArray<R>(pub(super) Option<[R; PADDED]>);

impl<R> LazyArray<R> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self(None)
    }
}

/// The active lanes sorted by mip level, then from many taps to few.
pub(super) struct LaneOrder {
    /// The active lanes in sorted order; `count` entries are valid. Not filled if `is_identity`.
    sorted_lanes: [u8; BATCH],
    pub(super) count: usize,
    /// Whether all lanes are active and have the same key, so that the sorted order is that of the batch.
    pub(super) is_identity: bool,
    /// `starts[key]`: the position of the first lane with that key or a greater one.
    pub(super) starts: [u8; (MAX_LEVELS + 1) * MAX_TAPS + 1],
    /// The levels from the finest to the coarsest among the keys of all lanes, active or not.
    pub(super) levels: std::ops::Range<usize>,
    /// Whether some lane, active or not, has more than one tap.
    pub(super) has_several_taps: bool,
}

impl LaneOrder {
    /// Sorts the active lanes by their keys. `key`: level * [`MAX_TAPS`] + ([`MAX_TAPS`] - taps) of each lane.
    #[inline(always)]
    pub(super) fn new(key: &[u16; BATCH], active: LaneMask) -> Self {
        let count = active.count_ones() as usize;
        let mut order = Self { sorted_lanes: [0; BATCH], count, is_identity: false, starts: [0; _], levels: 0..0, has_several_taps: false };
        let (mut min_key, mut max_key, mut inverted_keys) = (u16::MAX, 0, 0);
        for k in key {
            min_key = min_key.min(*k);
            max_key = max_key.max(*k);
            inverted_keys |= !*k;
        }
        // A lane with one tap has the last key of its level: all bits of key % MAX_TAPS are set, and those of the inverted key are not.
        order.has_several_taps = usize::from(inverted_keys) % MAX_TAPS != 0;
        let (min_key, max_key) = (usize::from(min_key), usize::from(max_key));
        order.levels = min_key / MAX_TAPS..max_key / MAX_TAPS + 1;
        let last = order.levels.end * MAX_TAPS;
        if active == LaneMask::MAX && min_key == max_key {
            order.is_identity = true;
            order.starts[max_key + 1..=last].fill(BATCH as u8);
            return order;
        }
        let mut remaining = active;
        while remaining != 0 {
            order.starts[usize::from(key[remaining.trailing_zeros() as usize]) + 1] += 1;
            remaining &= remaining - 1;
        }
        for k in min_key + 1..=last {
            order.starts[k] += order.starts[k - 1];
        }
        let mut next_position = order.starts;
        let mut remaining = active;
        while remaining != 0 {
            let lane = remaining.trailing_zeros() as usize;
            remaining &= remaining - 1;
            let position = &mut next_position[usize::from(key[lane])];
            order.sorted_lanes[usize::from(*position)] = lane as u8;
            *position += 1;
        }
        order
    }

    /// The values in sorted order, copied to `buffer` unless `is_identity`. A chunk of the result may start at any position below `count`. But if
    /// `is_identity`, the result is not padded, and a chunk may start only at multiples of [`CHUNK`].
    #[inline(always)]
    pub(super) fn gather<'a, R: Real>(&self, values: &'a [R; BATCH], buffer: &'a mut LazyArray<R>) -> &'a [R] {
        if self.is_identity {
            return values;
        }
        let buffer = buffer.0.insert([R::ZERO; PADDED]);
        // Here and below, `& 127` (`BATCH` - 1) shows the compiler that the index is in range.
        for i in 0..BATCH {
            buffer[i] = values[usize::from(self.sorted_lanes[i] & 127)];
        }
        buffer
    }

    /// Writes the first `valid` values of a chunk to their lanes. `start`: the sorted position of the chunk's first value. If `is_identity`, all `N` values
    /// are valid.
    #[inline(always)]
    pub(super) fn store<R: Real, const N: usize>(&self, value: &[[R; N]; 4], start: usize, valid: usize, out: &mut Channels<'_, R>) {
        if self.is_identity {
            for (out, value) in out.iter_mut().zip(value) {
                if let Some(out) = out.as_mut().and_then(|out| out[start..].first_chunk_mut::<N>()) {
                    *out = *value;
                }
            }
            return;
        }
        let lanes = self.sorted_lanes.get(start..(start + valid).min(start + N)).unwrap_or_default();
        for (out, value) in out.iter_mut().zip(value) {
            let Some(out) = out else { continue };
            for (lane, value) in lanes.iter().zip(value) {
                out[usize::from(lane & 127)] = *value;
            }
        }
    }

    /// The sorted positions of a level's lanes: the first, and the one after the last.
    #[inline(always)]
    pub(super) fn positions(&self, level: usize) -> (usize, usize) {
        (usize::from(self.starts[level * MAX_TAPS]), usize::from(self.starts[(level + 1) * MAX_TAPS]))
    }

    /// Writes sorted values back to their lanes.
    #[inline(always)]
    pub(super) fn scatter<R: Real>(&self, sorted: &[R; PADDED], out: &mut [R; BATCH]) {
        if self.is_identity {
            out.copy_from_slice(&sorted[..BATCH]);
        } else {
            for i in 0..self.count.min(BATCH) {
                out[usize::from(self.sorted_lanes[i] & 127)] = sorted[i];
            }
        }
    }
}
