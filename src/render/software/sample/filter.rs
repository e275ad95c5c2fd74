//! Filtering a batch: nearest, bilinear, trilinear, several taps along a footprint.
//!
//! In: a batch's coordinates and footprints, whole arrays of [`MOST`] lanes. Out: four linear values a lane, for the active lanes.
//! Lanes are first put in order of (mip level, number of taps), by counting: then each level's lanes are one run, those that take a further tap are the
//! first of it, inactive lanes are left out, and level and size are the same for all lanes of a loop. A lane's result does not
//! depend on its neighbours, nor on the instruction set: nothing here fuses multiply and add, and every lane sums its taps in the
//! same order. Integers wrap on purpose: a check for overflow would keep loops from becoming vector code in checked builds. Coordinates that are not finite read some texel and never trap.

// Loops by index over several arrays of one fixed length are what becomes vector code.
#![allow(clippy::needless_range_loop)]

use super::footprint::{Footprint, floor};
use super::texels::{Decode, TexelLevel};
use crate::render::plan::{AddressMode, SamplerState};
use crate::render::software::exec::LaneMask;
use crate::render::software::math::Real;

/// Lanes of a batch.
pub const MOST: usize = 128;
/// Lanes of one piece: what is fetched and weighed in one go.
const PIECE: usize = 32;
/// Arrays that pieces run over end with room for the last one.
const ROOM: usize = MOST + PIECE;
/// Taps are at most these.
pub const MAX_TAPS: usize = 16;
/// Levels of a texture are at most these (a side has at most 2^22 texels).
const MAX_LEVELS: usize = 31;

/// Red, green, blue, alpha of a batch, where they are asked for.
pub type Channels<'a, R> = [Option<&'a mut [R; MOST]>; 4];
/// Which of them are.
type Wanted = [bool; 4];

/// What the lanes of a batch ask for.
pub struct FilterRequest<'a, R> {
    pub u: &'a [R; MOST],
    pub v: &'a [R; MOST],
    pub level: [R; MOST],
    pub taps: [R; MOST],
    pub step_u: [R; MOST],
    pub step_v: [R; MOST],
}

impl<'a, R: Real> FilterRequest<'a, R> {
    pub fn new(u: &'a [R; MOST], v: &'a [R; MOST]) -> Self {
        let z = [R::ZERO; MOST];
        Self { u, v, level: z, taps: [R::ONE; MOST], step_u: z, step_v: z }
    }

    /// Fills levels and taps from the gradients du/dx, dv/dx, du/dy, dv/dy. `most`: taps at most, of a plain sampler none.
    #[inline(always)]
    pub fn footprints(&mut self, size: [u32; 2], g: [&[R; MOST]; 4], most: Option<&[R; MOST]>) {
        let size = [R::from_u32(size[0]), R::from_u32(size[1])];
        let Some(most) = most else {
            for i in 0..MOST {
                self.level[i] = Footprint::isotropic(size, [g[0][i], g[1][i]], [g[2][i], g[3][i]]).level;
            }
            return;
        };
        let limit = R::from_u32(MAX_TAPS as u32);
        for i in 0..MOST {
            let most = if most[i] < limit { most[i] } else { limit };
            let f = Footprint::elongated(size, [g[0][i], g[1][i]], [g[2][i], g[3][i]], most);
            (self.level[i], self.taps[i], self.step_u[i], self.step_v[i]) = (f.level, f.taps, f.step[0], f.step[1]);
        }
    }
}

/// Room for the values of a batch, made when it is needed.
struct Room<R>(Option<[R; ROOM]>);

impl<R> Room<R> {
    #[inline(always)]
    fn new() -> Self {
        Self(None)
    }
}

/// Lanes in the order of their work.
struct Order {
    lane: [u8; MOST],
    count: usize,
    /// All lanes, as they are: nothing need be moved.
    plain: bool,
    /// `starts[key]`: the first place of lanes of that key or a later one; keys run by level, then from many taps to few.
    starts: [u8; (MAX_LEVELS + 1) * MAX_TAPS + 1],
    levels: std::ops::Range<usize>,
    /// Some lane, active or not, takes more than one tap.
    several_taps: bool,
}

impl Order {
    #[inline(always)]
    fn new(key: &[u16; MOST], active: LaneMask) -> Self {
        let count = active.count_ones() as usize;
        let mut order = Self { lane: [0; MOST], count, plain: false, starts: [0; _], levels: 0..0, several_taps: false };
        let (mut least, mut most, mut missing) = (u16::MAX, 0, 0);
        for k in key {
            least = least.min(*k);
            most = most.max(*k);
            missing |= !*k;
        }
        // One tap has the last key of its level.
        order.several_taps = usize::from(missing) % MAX_TAPS != 0;
        let (least, most) = (usize::from(least), usize::from(most));
        order.levels = least / MAX_TAPS..most / MAX_TAPS + 1;
        let last = order.levels.end * MAX_TAPS;
        if active == LaneMask::MAX && least == most {
            order.plain = true;
            order.starts[most + 1..=last].fill(MOST as u8);
            return order;
        }
        let mut left = active;
        while left != 0 {
            order.starts[usize::from(key[left.trailing_zeros() as usize]) + 1] += 1;
            left &= left - 1;
        }
        for k in least + 1..=last {
            order.starts[k] += order.starts[k - 1];
        }
        let mut next = order.starts;
        let mut left = active;
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let at = &mut next[usize::from(key[lane])];
            order.lane[usize::from(*at)] = lane as u8;
            *at += 1;
        }
        order
    }

    /// Values in this order, in `room` if they must be moved; pieces of them may begin at any place below the count.
    #[inline(always)]
    fn sorted<'a, R: Real>(&self, values: &'a [R; MOST], room: &'a mut Room<R>) -> &'a [R] {
        if self.plain {
            return values;
        }
        let room = room.0.insert([R::ZERO; ROOM]);
        for i in 0..MOST {
            room[i] = values[usize::from(self.lane[i] & 127)];
        }
        room
    }

    /// Puts sorted values back where they belong.
    #[inline(always)]
    fn unsorted<R: Real>(&self, sorted: &[R; ROOM], out: &mut [R; MOST]) {
        if self.plain {
            out.copy_from_slice(&sorted[..MOST]);
        } else {
            for i in 0..self.count.min(MOST) {
                out[usize::from(self.lane[i] & 127)] = sorted[i];
            }
        }
    }
}

/// One piece of an array.
#[inline(always)]
fn piece<T>(values: &[T], at: usize) -> &[T; PIECE] {
    match values[at..].first_chunk() {
        Some(p) => p,
        None => unreachable!("pieces begin below the count, and at whole pieces where nothing was moved"),
    }
}

/// Whole texels below and above a coordinate, and the fraction between them.
struct Between<R> {
    below: [u32; PIECE],
    above: [u32; PIECE],
    fraction: [R; PIECE],
}

#[inline(always)]
fn between<R: Real>(coordinate: &[R; PIECE], size: u32, mode: AddressMode) -> Between<R> {
    let n = R::from_u32(size);
    let last = size as i32 - 1;
    let repeat = mode == AddressMode::Repeat;
    // What lies before the first texel and after the last.
    let (before, after) = if repeat { (last, 0) } else { (0, last) };
    let mut out = Between { below: [0; PIECE], above: [0; PIECE], fraction: [R::ZERO; PIECE] };
    for i in 0..PIECE {
        let c = coordinate[i];
        let x = if repeat { c - floor(c) } else { c } * n - R::from_f64(0.5);
        // Written so that NaN becomes the first texel.
        let x = if x > -R::ONE { x } else { -R::ONE };
        let x = if x < n { x } else { n };
        let (r, k) = x.nearest_small();
        let over = r > x;
        out.fraction[i] = x - if over { r - R::ONE } else { r };
        let k = if over { k.wrapping_sub(1) } else { k };
        out.below[i] = (if k < 0 { before } else { k.min(last) }) as u32;
        out.above[i] = (if k >= last { after } else { k.wrapping_add(1) }) as u32;
    }
    out
}

#[inline(always)]
fn bilinear<R: Real, D: Decode>(
    decode: D,
    level: &TexelLevel<'_>,
    u: &[R; PIECE],
    v: &[R; PIECE],
    state: &SamplerState,
    wanted: Wanted,
) -> [[R; PIECE]; 4] {
    let x = between(u, level.width, state.address_u);
    let y = between(v, level.height, state.address_v);
    let fetch = |column: &[u32; PIECE], row: &[u32; PIECE]| {
        let mut index = [0; PIECE];
        for i in 0..PIECE {
            index[i] = row[i].wrapping_mul(level.width).wrapping_add(column[i]);
        }
        // SAFETY: `between` clamps columns and rows to the level.
        unsafe { decode.fetch(level, &index) }
    };
    let t = [fetch(&x.below, &y.below), fetch(&x.above, &y.below), fetch(&x.below, &y.above), fetch(&x.above, &y.above)];
    let mut out = [[R::ZERO; PIECE]; 4];
    let [r, g, b, a] = &mut out;
    if wanted[0] {
        weighed::<R, D, 0>(decode, &t, &x.fraction, &y.fraction, r);
    }
    if wanted[1] {
        weighed::<R, D, 1>(decode, &t, &x.fraction, &y.fraction, g);
    }
    if wanted[2] {
        weighed::<R, D, 2>(decode, &t, &x.fraction, &y.fraction, b);
    }
    if wanted[3] {
        weighed::<R, D, 3>(decode, &t, &x.fraction, &y.fraction, a);
    }
    out
}

/// Channel `K` between the four texels of each lane.
#[inline(always)]
fn weighed<R: Real, D: Decode, const K: usize>(
    decode: D,
    t: &[[D::Texel; PIECE]; 4],
    x: &[R; PIECE],
    y: &[R; PIECE],
    out: &mut [R; PIECE],
) {
    let [a, b] = [decode.channel_of_each::<K, PIECE>(&t[0]), decode.channel_of_each::<K, PIECE>(&t[1])];
    let [c, d] = [decode.channel_of_each::<K, PIECE>(&t[2]), decode.channel_of_each::<K, PIECE>(&t[3])];
    let own = |v: f32| R::from_f32_bits(v.to_bits());
    for i in 0..PIECE {
        let top = own(a[i]) + x[i] * (own(b[i]) - own(a[i]));
        let bottom = own(c[i]) + x[i] * (own(d[i]) - own(c[i]));
        out[i] = top + y[i] * (bottom - top);
    }
}

/// Nearest texel along one axis.
#[inline(always)]
fn nearest_texel<R: Real>(c: R, size: u32, mode: AddressMode) -> u32 {
    let n = R::from_u32(size);
    let x = if mode == AddressMode::Repeat { c - floor(c) } else { c } * n;
    let x = if x > R::ZERO { x } else { R::ZERO };
    let x = if x < n { x } else { n };
    let (r, k) = x.nearest_small();
    (if r > x { k.wrapping_sub(1) } else { k }).min(size as i32 - 1) as u32
}

#[inline(always)]
fn nearest<R: Real, D: Decode>(decode: D, level: &TexelLevel<'_>, u: &[R; PIECE], v: &[R; PIECE], state: &SamplerState) -> [[R; PIECE]; 4] {
    let mut index = [0; PIECE];
    for i in 0..PIECE {
        let row = nearest_texel(v[i], level.height, state.address_v);
        index[i] = row.wrapping_mul(level.width).wrapping_add(nearest_texel(u[i], level.width, state.address_u));
    }
    // SAFETY: both are below the level's size.
    let texels = unsafe { decode.fetch(level, &index) };
    let mut out = [[R::ZERO; PIECE]; 4];
    let [r, g, b, a] = &mut out;
    own::<R, D, 0>(decode, &texels, r);
    own::<R, D, 1>(decode, &texels, g);
    own::<R, D, 2>(decode, &texels, b);
    own::<R, D, 3>(decode, &texels, a);
    out
}

/// Channel `K` of each lane's texel.
#[inline(always)]
fn own<R: Real, D: Decode, const K: usize>(decode: D, texels: &[D::Texel; PIECE], out: &mut [R; PIECE]) {
    for (out, v) in out.iter_mut().zip(decode.channel_of_each::<K, PIECE>(texels)) {
        *out = R::from_f32_bits(v.to_bits());
    }
}

/// Adds the first `count` lanes.
#[inline(always)]
fn accumulate<R: Real>(sum: &mut [Room<R>; 4], at: usize, count: usize, value: &[[R; PIECE]; 4]) {
    for (sum, value) in sum.iter_mut().zip(value) {
        let Some(sum) = &mut sum.0 else { continue };
        let Some(sum) = sum[at..at + PIECE].first_chunk_mut::<PIECE>() else { return };
        for i in 0..PIECE {
            sum[i] = if i < count { sum[i] + value[i] } else { sum[i] };
        }
    }
}

#[inline(always)]
fn any_positive<R: Real>(values: &[R; PIECE]) -> bool {
    let mut any = false;
    for v in values {
        any |= *v > R::ZERO;
    }
    any
}

/// Filters the active lanes of a batch into `out`, whose other lanes stay as they are. What is not asked for is empty.
#[inline(always)]
pub fn sample<R: Real, D: Decode>(
    decode: D,
    levels: &[TexelLevel<'_>],
    wanted: &FilterRequest<'_, R>,
    state: &SamplerState,
    active: LaneMask,
    out: Channels<'_, R>,
) {
    let channels = out.each_ref().map(|o| o.is_some());
    let last = levels.len().min(MAX_LEVELS) - 1;
    let last_level = R::from_u32(last as u32);
    let round = if state.linear { R::ZERO } else { R::from_f64(0.5) };
    let (mut key, mut part) = ([0_u16; MOST], [R::ZERO; MOST]);
    for i in 0..MOST {
        let level = if wanted.level[i] > R::ZERO { wanted.level[i] } else { R::ZERO };
        let level = if level < last_level { level } else { last_level };
        let fine = floor(level + round);
        let fine = if fine < last_level { fine } else { last_level };
        part[i] = level - fine;
        let few = R::from_u32(MAX_TAPS as u32) - wanted.taps[i];
        key[i] = (fine * R::from_u32(MAX_TAPS as u32) + few).nearest_small().1 as u16;
    }
    let order = Order::new(&key, active);
    // What is not needed is not zeroed: a batch's arrays are as large as all that it computes on.
    let (mut room_u, mut room_v, mut room_part, mut room_step_u, mut room_step_v, mut room_taps) =
        (Room::new(), Room::new(), Room::new(), Room::new(), Room::new(), Room::new());
    let (u, v) = (order.sorted(wanted.u, &mut room_u), order.sorted(wanted.v, &mut room_v));
    let mut sum = [Room::new(), Room::new(), Room::new(), Room::new()];
    for (sum, _) in sum.iter_mut().zip(channels).filter(|(_, wanted)| *wanted) {
        sum.0 = Some([R::ZERO; ROOM]);
    }
    if !state.linear {
        for level in order.levels.clone() {
            let (from, to) = (order.starts[level * MAX_TAPS], order.starts[(level + 1) * MAX_TAPS]);
            for at in (usize::from(from)..usize::from(to)).step_by(PIECE) {
                let value = nearest(decode, &levels[level], piece(u, at), piece(v, at), state);
                accumulate(&mut sum, at, usize::from(to) - at, &value);
            }
        }
    } else {
        let part = order.sorted(&part, &mut room_part);
        // One tap stands in the middle of its footprint and is its own mean.
        let along = order.several_taps.then(|| {
            let (step_u, step_v) = (order.sorted(&wanted.step_u, &mut room_step_u), order.sorted(&wanted.step_v, &mut room_step_v));
            (step_u, step_v, order.sorted(&wanted.taps, &mut room_taps))
        });
        for level in order.levels.clone() {
            let from = usize::from(order.starts[level * MAX_TAPS]);
            for tap in 0..MAX_TAPS {
                // Lanes with more taps than this come first.
                let to = usize::from(order.starts[(level + 1) * MAX_TAPS - tap]);
                if to == from {
                    break;
                }
                for at in (from..to).step_by(PIECE) {
                    let (mut tap_u, mut tap_v) = (*piece(u, at), *piece(v, at));
                    if let Some((step_u, step_v, taps)) = along {
                        let (step_u, step_v, taps) = (piece(step_u, at), piece(step_v, at), piece(taps, at));
                        for i in 0..PIECE {
                            let offset = R::from_u32(tap as u32) - R::from_f64(0.5) * (taps[i] - R::ONE);
                            tap_u[i] = tap_u[i] + offset * step_u[i];
                            tap_v[i] = tap_v[i] + offset * step_v[i];
                        }
                    }
                    let mut value = bilinear(decode, &levels[level], &tap_u, &tap_v, state, channels);
                    let part = piece(part, at);
                    if level < last && any_positive(part) {
                        let coarse = bilinear(decode, &levels[level + 1], &tap_u, &tap_v, state, channels);
                        for ((value, coarse), _) in value.iter_mut().zip(&coarse).zip(channels).filter(|(_, wanted)| *wanted) {
                            for i in 0..PIECE {
                                let mixed = value[i] + part[i] * (coarse[i] - value[i]);
                                value[i] = if part[i] > R::ZERO { mixed } else { value[i] };
                            }
                        }
                    }
                    accumulate(&mut sum, at, to - at, &value);
                }
            }
        }
        if let Some((.., taps)) = along {
            for sum in sum.iter_mut().filter_map(|sum| sum.0.as_mut()) {
                for (sum, taps) in sum.iter_mut().zip(taps) {
                    *sum = *sum / *taps;
                }
            }
        }
    }
    for (out, sum) in out.into_iter().zip(&sum) {
        if let (Some(out), Some(sum)) = (out, &sum.0) {
            order.unsorted(sum, out);
        }
    }
}
