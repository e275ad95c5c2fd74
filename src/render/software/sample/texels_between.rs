//! Interpolates between the four texels around a position that is given in texels, as `texels_between` of shaders/lib/texels_between.wesl does.
//!
//! In: a position for each lane; along each axis the centre of texel `k` is at `k`. Out: up to four channels per lane, interpolated in the finest
//! level; lanes that are not active are left unchanged. Always: every kernel class gives the same bits. Beyond the edges the image continues with its
//! outermost texels.

#[cfg(target_arch = "x86_64")]
use super::corners::Corners;
use super::filter::{BATCH, Channels};
#[cfg(target_arch = "x86_64")]
use super::filter_avx2;
use super::footprint::floor;
use super::texels::{BoundLevel, Decode};
#[cfg(target_arch = "x86_64")]
use crate::render::plan::AddressMode;
use crate::render::software::exec::LaneMask;
use crate::render::software::math::Real;

/// Interpolates for all active lanes of a batch.
#[inline(always)]
pub(super) fn interpolate<R: Real, D: Decode>(
    decode: D,
    levels: &[BoundLevel<'_>],
    [x, y]: [&[R; BATCH]; 2],
    active: LaneMask,
    mut out: Channels<'_, R>,
) {
    let level = levels[0].read();
    #[cfg(target_arch = "x86_64")]
    if D::FILTERS_WITH_AVX2
        && let (Some(x), Some(y)) = (R::as_f32(x).and_then(|x| x.first_chunk()), R::as_f32(y).and_then(|y| y.first_chunk()))
    {
        let needed = out.each_ref().map(|o| o.is_some());
        let mut out = filter_avx2::in_groups(out.map(|lanes| R::as_f32_mut(lanes?)?.first_chunk_mut()));
        // SAFETY: AVX2 decoders exist only on machines with AVX2.
        let level = unsafe { filter_avx2::SizedLevel::new(level, [AddressMode::ClampToEdge; 2]) };
        for group in 0..BATCH / filter_avx2::GROUP_LANES {
            let active = (active >> (group * filter_avx2::GROUP_LANES)) as u32 & filter_avx2::ALL_OF_GROUP;
            if active == 0 {
                continue;
            }
            // SAFETY: AVX2 decoders exist only on machines with AVX2; `texels_beside` clamps columns and rows to the level.
            unsafe {
                let corners = Corners::new(
                    level.width,
                    filter_avx2::texels_beside(filter_avx2::group_of(x, group), &level.axes[0]),
                    filter_avx2::texels_beside(filter_avx2::group_of(y, group), &level.axes[1]),
                );
                let value = decode.interpolate_eight(&level.texels, &corners, needed);
                filter_avx2::write_group(&mut out, group, value, active);
            }
        }
        return;
    }
    // The texels before and after a position along one axis of `size` texels, and the position's fraction between them.
    let texels_beside = |position: R, size: u32| {
        let n = R::from_u32(size);
        // Written so that NaN becomes the first texel.
        let position = if position > -R::ONE { position } else { -R::ONE };
        let position = if position < n { position } else { n };
        let whole = floor(position);
        let (_, k) = whole.round_small();
        let last = size as i32 - 1;
        (k.clamp(0, last) as u32, (k + 1).min(last) as u32, position - whole)
    };
    for lane in (0..BATCH).filter(|lane| active >> lane & 1 == 1) {
        let (left, right, fraction_x) = texels_beside(x[lane], level.width);
        let (above, below, fraction_y) = texels_beside(y[lane], level.height);
        let [a, b, c, d] = [[left, above], [right, above], [left, below], [right, below]].map(|[column, row]| {
            // SAFETY: columns and rows lie inside the level.
            decode.channels(unsafe { decode.texel(&level, row * level.width + column) }).map(|v| R::from_f32_bits(v.to_bits()))
        });
        for (k, out) in out.iter_mut().enumerate() {
            let Some(out) = out else { continue };
            let top = a[k] + fraction_x * (b[k] - a[k]);
            let bottom = c[k] + fraction_x * (d[k] - c[k]);
            out[lane] = top + fraction_y * (bottom - top);
        }
    }
}
