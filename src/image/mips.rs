//! Mip chains in linear light.
//!
//! In: 8-bit RGBA rows. Out: every level down to 1x1, each side half of that of the finer level, rounded down and at least 1. Each level is the area mean of
//! the finer level in linear light; along an odd side a texel is the weighted mean of up to three. Means stay floats from level to level and are rounded only
//! on encoding, so errors do not accumulate. For a map of opacities ([`OpacityTexels`]), the opacities are averaged instead of the light. Rows near the poles
//! are filtered first ([`super::poles`]). At every level the image's left and right edges are edges of texels, so no mean mixes texels across the map's seam.

use super::map_decoding::{MapDecoding, OpacityTexels};
use super::poles::{PoleRowFilter, PrefixSums};
use super::{Level, PoleFilter, TexelFormat};
use crate::units::{linear_to_srgb, srgb_to_linear};
use rayon::prelude::*;
use std::sync::LazyLock;

/// Which threads compute the rows of a level. The result is the same either way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RowThreads {
    /// The threads of the rayon pool.
    All,
    /// The calling thread alone, which runs no other rayon task meanwhile.
    CallingOnly,
}

impl RowThreads {
    /// The fewest rows that a rayon task computes; a task of all rows stays on the calling thread.
    fn min_rows(self) -> usize {
        match self {
            Self::All => 1,
            Self::CallingOnly => usize::MAX,
        }
    }
}

/// Linear values of sRGB-encoded bytes.
static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f64 / 255.0) as f32));
/// Linear values of linear bytes.
static UNORM: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| i as f32 / 255.0));

/// Steps of the sRGB encoding table. The slope of the encoding at black is 12.92, so a step is at most 12.92 x 255 / 65536 = 0.050 of an 8-bit level.
const SRGB_STEPS: usize = 65_536;
/// The sRGB-encoded byte of each step from a linear value of 0 to 1.
static SRGB_BYTES: LazyLock<Vec<u8>> =
    LazyLock::new(|| (0..=SRGB_STEPS).map(|i| (linear_to_srgb(i as f64 / SRGB_STEPS as f64) * 255.0).round() as u8).collect());

/// The linear values of a colour channel's bytes.
pub(super) fn decode_table(format: TexelFormat) -> &'static [f32; 256] {
    if format == TexelFormat::Rgba8Srgb { &SRGB } else { &UNORM }
}

/// The byte that stores a linear value without sRGB encoding, such as alpha.
fn encode_unorm(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// The byte of a linear value. `is_srgb`: whether the byte is sRGB-encoded.
fn encode(v: f32, is_srgb: bool) -> u8 {
    if is_srgb { SRGB_BYTES[(v.clamp(0.0, 1.0) * SRGB_STEPS as f32 + 0.5) as usize] } else { encode_unorm(v) }
}

/// Steps of the table that encodes opacities.
const OPACITY_STEPS: usize = 4096;

/// Converts between the bytes of a map's colour channels and the quantity that is averaged: linear light, or opacity.
enum Codec {
    Light { is_srgb: bool },
    Opacity { opacity_of_byte: Box<[f32; 256]>, byte_of_opacity: Vec<u8> },
}

impl Codec {
    fn new(format: TexelFormat, opacity: Option<OpacityTexels>) -> Self {
        let Some(texels) = opacity else { return Self::Light { is_srgb: format == TexelFormat::Rgba8Srgb } };
        let opacity_of_byte = Box::new(decode_table(format).map(|value| texels.opacity(value)));
        let byte_of_opacity = (0..=OPACITY_STEPS).map(|step| {
            let opacity = step as f32 / OPACITY_STEPS as f32;
            // The first byte that is at least as opaque, or the one before, whichever is closer.
            let upper = opacity_of_byte.partition_point(|o| *o < opacity).min(255);
            let lower = upper.saturating_sub(1);
            (if opacity - opacity_of_byte[lower] < opacity_of_byte[upper] - opacity { lower } else { upper }) as u8
        });
        Self::Opacity { byte_of_opacity: byte_of_opacity.collect(), opacity_of_byte }
    }

    fn decode_table(&self) -> &[f32; 256] {
        match self {
            Self::Light { is_srgb: true } => &SRGB,
            Self::Light { is_srgb: false } => &UNORM,
            Self::Opacity { opacity_of_byte, .. } => opacity_of_byte,
        }
    }

    #[inline]
    fn encode(&self, v: f32) -> u8 {
        match self {
            Self::Light { is_srgb } => encode(v, *is_srgb),
            Self::Opacity { byte_of_opacity, .. } => byte_of_opacity[(v.clamp(0.0, 1.0) * OPACITY_STEPS as f32 + 0.5) as usize],
        }
    }
}

/// Texel `i` of the `count` texels along one side of a level covers up to three of the `finer_count` texels along the same side of the finer level. Returns
/// the index of the first of these, and the weights of the first and the next two, whose sum is 1.
fn area_weights(i: usize, count: usize, finer_count: usize) -> (usize, [f32; 3]) {
    let (start, end) = (i as f64 * finer_count as f64 / count as f64, (i + 1) as f64 * finer_count as f64 / count as f64);
    let first = start as usize;
    let weight = |k: usize| ((end.min((first + k + 1) as f64) - start.max((first + k) as f64)).max(0.0) / (end - start)) as f32;
    (first, [weight(0), weight(1), weight(2)])
}

/// The texels of a level, which are read row by row as linear RGBA floats.
#[derive(Clone, Copy)]
enum Rows<'a> {
    /// Bytes, and the table that decodes their colour channels; alpha is always linear.
    Encoded {
        rgba: &'a [u8],
        colour_table: &'a [f32; 256],
    },
    Linear(&'a [[f32; 4]]),
}

impl<'a> Rows<'a> {
    /// Row `y` of a level of this width. An encoded row is decoded into `buffer`.
    fn row<'b>(self, y: usize, width: usize, buffer: &'b mut Vec<[f32; 4]>) -> &'b [[f32; 4]]
    where
        'a: 'b,
    {
        match self {
            Self::Encoded { rgba, colour_table } => {
                decode_row(&rgba[y * width * 4..][..width * 4], colour_table, buffer);
                buffer.as_slice()
            }
            Self::Linear(texels) => &texels[y * width..][..width],
        }
    }
}

/// Linear texels of a row of bytes.
fn decode_row(rgba: &[u8], colour_table: &[f32; 256], out: &mut Vec<[f32; 4]>) {
    let (colour, alpha) = (colour_table, &*UNORM);
    out.clear();
    out.extend(
        rgba.as_chunks::<4>()
            .0
            .iter()
            .map(|t| [colour[usize::from(t[0])], colour[usize::from(t[1])], colour[usize::from(t[2])], alpha[usize::from(t[3])]]),
    );
}

/// Adds a row of the finer level, with a weight, to the sums of a row of the next level. In both branches the finer texels under a texel are added from left to
/// right, so that the branches round alike. `columns`: [`area_weights`] of each texel of the coarser row.
#[inline(always)]
fn add_row(sums: &mut [[f32; 4]], row: &[[f32; 4]], columns: &[(usize, [f32; 3])], row_weight: f32) {
    if row.len() == 2 * sums.len() {
        // Each texel covers exactly two finer texels.
        let weight = 0.5 * row_weight;
        for (sum, [a, b]) in sums.iter_mut().zip(row.as_chunks::<2>().0) {
            for c in 0..4 {
                sum[c] = sum[c] + weight * a[c] + weight * b[c];
            }
        }
        return;
    }
    for (sum, (first, weights)) in sums.iter_mut().zip(columns) {
        for (t, &column_weight) in row[*first..].iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
            for c in 0..4 {
                sum[c] += column_weight * row_weight * t[c];
            }
        }
    }
}

/// The next mip level: its width and height, and the area means of the finer level's texels. `rows`: the finer level, of `width` x `height` texels.
fn halve(width: usize, height: usize, rows: Rows<'_>, threads: RowThreads) -> (usize, usize, Vec<[f32; 4]>) {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let columns: Vec<_> = (0..w).map(|x| area_weights(x, w, width)).collect();
    let mut out = vec![[0.0; 4]; w * h];
    out.par_chunks_mut(w).enumerate().with_min_len(threads.min_rows()).for_each_init(Vec::new, |buffer, (y, sums)| {
        let (first_row, row_weights) = area_weights(y, h, height);
        for (j, &row_weight) in row_weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            add_row(sums, rows.row(first_row + j, width, buffer), &columns, row_weight);
        }
    });
    (w, h, out)
}

/// Premultiplies colours by alpha in linear light. Opaque texels keep their bytes.
pub(super) fn premultiply(rgba: &mut [u8], format: TexelFormat) {
    let (colour_table, is_srgb) = (decode_table(format), format == TexelFormat::Rgba8Srgb);
    for texel in rgba.chunks_exact_mut(4) {
        let alpha = UNORM[usize::from(texel[3])];
        for c in &mut texel[..3] {
            *c = encode(colour_table[usize::from(*c)] * alpha, is_srgb);
        }
    }
}

/// Applies the pole filter to the finest level.
fn filter_finest_level(width: usize, height: usize, rgba: &mut [u8], codec: &Codec, poles: PoleFilter, threads: RowThreads) {
    let colour_table = codec.decode_table();
    // The finest level has no finer one.
    let finer_is_filtered = false;
    let pole_filter = PoleRowFilter::of(poles, width, height, finer_is_filtered);
    let rows = rgba.par_chunks_exact_mut(width * 4).enumerate().with_min_len(threads.min_rows()).filter(|(y, _)| pole_filter.changes(*y));
    rows.for_each_init(<(Vec<_>, PrefixSums)>::default, |(row, sums), (y, bytes)| {
        decode_row(bytes, colour_table, row);
        pole_filter.smooth(y, row, sums);
        for (out, t) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(&*row) {
            *out = [codec.encode(t[0]), codec.encode(t[1]), codec.encode(t[2]), encode_unorm(t[3])];
        }
    });
}

/// Applies the pole filter to a coarser level, in floats.
fn filter_coarser_level(width: usize, height: usize, linear: &mut [[f32; 4]], poles: PoleFilter, threads: RowThreads) {
    let finer_is_filtered = true;
    let pole_filter = PoleRowFilter::of(poles, width, height, finer_is_filtered);
    let rows = linear.par_chunks_mut(width).enumerate().with_min_len(threads.min_rows());
    rows.for_each_init(PrefixSums::new, |sums, (y, row)| pole_filter.smooth(y, row, sums));
}

/// All levels of an 8-bit image.
pub(super) fn chain(width: u32, height: u32, mut rgba: Vec<u8>, decoding: MapDecoding, threads: RowThreads) -> Vec<Level> {
    let MapDecoding { format, poles, opacity } = decoding;
    let codec = Codec::new(format, opacity);
    let colour_table = codec.decode_table();
    let pack = |w: usize, h: usize, linear: &[[f32; 4]]| {
        let mut bytes = vec![0; w * h * 4];
        bytes.par_chunks_mut(w * 4).zip(linear.par_chunks(w)).with_min_len(threads.min_rows()).for_each(|(row, texels)| {
            for (out, t) in row.chunks_exact_mut(4).zip(texels) {
                out.copy_from_slice(&[codec.encode(t[0]), codec.encode(t[1]), codec.encode(t[2]), encode_unorm(t[3])]);
            }
        });
        Level::new(w as u32, h as u32, bytes)
    };
    let (mut w, mut h) = (width as usize, height as usize);
    filter_finest_level(w, h, &mut rgba, &codec, poles, threads);
    let mut levels = Vec::new();
    if w > 1 || h > 1 {
        let (next_w, next_h, mut linear) = halve(w, h, Rows::Encoded { rgba: &rgba, colour_table }, threads);
        (w, h) = (next_w, next_h);
        filter_coarser_level(w, h, &mut linear, poles, threads);
        levels.push(pack(w, h, &linear));
        while w > 1 || h > 1 {
            let (next_w, next_h, next) = halve(w, h, Rows::Linear(&linear), threads);
            (w, h, linear) = (next_w, next_h, next);
            filter_coarser_level(w, h, &mut linear, poles, threads);
            levels.push(pack(w, h, &linear));
        }
    }
    levels.insert(0, Level::new(width, height, rgba));
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use parking_lot::Mutex;

    #[test]
    fn every_byte_survives_decoding_and_encoding() {
        for i in 0..=255_u8 {
            for (table, is_srgb) in [(&SRGB, true), (&UNORM, false)] {
                assert_eq!(encode(table[usize::from(i)], is_srgb), i);
            }
        }
    }

    #[test]
    fn a_checkerboard_averages_in_linear_light() {
        let rgba = [[0, 0, 0, 255], [255; 4], [255; 4], [0, 0, 0, 255]].concat();
        let levels = chain(2, 2, rgba.clone(), MapDecoding::plain(TexelFormat::Rgba8Srgb), RowThreads::All);
        // IEC 61966-2-1: linear one half is 187.5 of 255; the mean of the encoded bytes would be 127.
        assert_eq!(levels[1].bytes(), [188, 188, 188, 255]);
        assert_eq!(
            chain(2, 2, rgba, MapDecoding::plain(TexelFormat::Rgba8Unorm), RowThreads::CallingOnly)[1].bytes(),
            [128, 128, 128, 255]
        );
    }

    /// Half of the sky is overcast, half clear: half of the light is blocked at every level. A texel of the mean value, 0.5, would block 0.73 of it.
    #[test]
    fn coarser_texels_of_a_map_of_opacities_have_the_mean_opacity() {
        let texels = OpacityTexels::new(0.03, 0.75);
        let decoding = MapDecoding { opacity: Some(texels), ..MapDecoding::plain(TexelFormat::Rgba8Unorm) };
        let opacity = |byte: u8| texels.opacity(f32::from(byte) / 255.0);
        let rgba = [[0, 0, 0, 255], [255; 4], [255; 4], [0, 0, 0, 255]].concat();
        let coarse = chain(2, 2, rgba.clone(), decoding, RowThreads::All)[1].bytes()[0];
        assert!((opacity(coarse) - 0.5).abs() < 0.005, "{coarse}");
        let plain = chain(2, 2, rgba, MapDecoding::plain(TexelFormat::Rgba8Unorm), RowThreads::All)[1].bytes()[0];
        assert!((opacity(plain) - 0.726).abs() < 0.005, "{plain}");
        // Any field: each level has the mean opacity of the first, within the rounding to bytes.
        let rgba: Vec<u8> = (0..64_u32 * 32)
            .flat_map(|i| {
                let v = (i * i * 7 / 3 % 256) as u8;
                [v, v, v, 255]
            })
            .collect();
        let levels = chain(64, 32, rgba, decoding, RowThreads::All);
        let mean = |level: &Level| level.bytes().iter().step_by(4).map(|b| opacity(*b)).sum::<f32>() / (level.width * level.height) as f32;
        for level in &levels[1..] {
            assert!((mean(level) - mean(&levels[0])).abs() < 0.005, "{} columns: {} of {}", level.width, mean(level), mean(&levels[0]));
        }
    }

    #[test]
    fn an_opacity_is_encoded_as_the_byte_with_the_closest_opacity() {
        let texels = OpacityTexels::new(0.03, 0.75);
        let codec = Codec::new(TexelFormat::Rgba8Unorm, Some(texels));
        for step in 0..=1000_u32 {
            let opacity = step as f32 / 1000.0;
            let found = codec.decode_table()[usize::from(codec.encode(opacity))];
            // A step between bytes is at most 0.0082 of opacity: 1.5 / 0.72 / 255.
            assert!((found - opacity).abs() < 0.0043, "{opacity}: {found}");
        }
    }

    #[test]
    fn colours_are_premultiplied_in_linear_light() {
        let mut texels = [[255, 255, 255, 128], [200, 10, 99, 255], [255, 0, 0, 0]].concat();
        premultiply(&mut texels, TexelFormat::Rgba8Srgb);
        // IEC 61966-2-1: linear 128/255 is 187.8 of 255.
        assert_eq!(texels, [[188, 188, 188, 128], [200, 10, 99, 255], [0, 0, 0, 0]].concat());
        let mut plain = vec![200, 100, 50, 51];
        premultiply(&mut plain, TexelFormat::Rgba8Unorm);
        assert_eq!(plain, [40, 20, 10, 51]);
    }

    #[test]
    fn odd_sides_keep_the_mean() {
        let (w, h) = (7_u32, 5_u32);
        let rgba: Vec<u8> = (0..w * h).flat_map(|i| [(i * 7 % 256) as u8, (i * 31 % 256) as u8, 40, 255]).collect();
        let levels = chain(w, h, rgba.clone(), MapDecoding::plain(TexelFormat::Rgba8Unorm), RowThreads::All);
        assert_eq!(levels.iter().map(|l| (l.width, l.height)).collect::<Vec<_>>(), [(7, 5), (3, 2), (1, 1)]);
        for c in 0..4 {
            let mean = rgba.iter().skip(c).step_by(4).map(|&b| f64::from(b)).sum::<f64>() / f64::from(w * h);
            assert!((f64::from(levels[2].bytes()[c]) - mean).abs() <= 0.51, "channel {c}");
        }
    }

    /// The area mean by its definition, cell by cell.
    #[test]
    fn adding_rows_gives_the_area_mean_of_each_texel() {
        for (width, height) in [(8, 6), (7, 5), (9, 8), (2, 1), (1, 3), (1638, 3)] {
            let texels: Vec<[f32; 4]> = (0..width * height).map(|i| [0, 1, 2, 3].map(|c| ((i * 29 + c * 7) % 101) as f32 / 97.0)).collect();
            let (w, h, level) = halve(width, height, Rows::Linear(&texels), RowThreads::All);
            for (at, found) in level.iter().enumerate() {
                let ((x0, wx), (y0, wy)) = (area_weights(at % w, w, width), area_weights(at / w, h, height));
                let mut sum = [0.0_f32; 4];
                for (j, wy) in wy.into_iter().enumerate().filter(|(_, w)| *w > 0.0) {
                    for (i, wx) in wx.into_iter().enumerate().filter(|(_, w)| *w > 0.0) {
                        let t = texels[(y0 + j) * width + x0 + i];
                        (0..4).for_each(|c| sum[c] += wx * wy * t[c]);
                    }
                }
                assert_eq!(found.map(f32::to_bits), sum.map(f32::to_bits), "{width}x{height}, texel {at}");
            }
        }
    }

    /// If rayon ran another task on this thread in between, that task could wait for the level that this thread is computing: a deadlock.
    #[test]
    fn rows_on_the_calling_thread_give_the_same_levels_and_run_no_other_task() {
        let (w, h) = (300_u32, 150_u32);
        let rgba: Vec<u8> = (0..w * h).flat_map(|i| [(i * 7 % 256) as u8, (i * 31 % 251) as u8, (i / 97 % 256) as u8, 255]).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
        for poles in [PoleFilter::None, PoleFilter::Values, PoleFilter::Normals] {
            let levels_by =
                |threads| chain(w, h, rgba.clone(), MapDecoding { poles, ..MapDecoding::plain(TexelFormat::Rgba8Srgb) }, threads);
            let parallel = levels_by(RowThreads::All);
            let working = Mutex::new(None);
            pool.scope(|scope| {
                for _ in 0..1000 {
                    scope.spawn(|_| assert_ne!(*working.lock(), Some(std::thread::current().id()), "{poles:?}"));
                }
                *working.lock() = Some(std::thread::current().id());
                let on_one_thread = levels_by(RowThreads::CallingOnly);
                *working.lock() = None;
                assert!(on_one_thread == parallel, "{poles:?}");
            });
        }
    }
}
