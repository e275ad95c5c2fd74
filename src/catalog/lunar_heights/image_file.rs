//! Reads heights of the Moon above its reference sphere from a PNG or a TIFF.
//!
//! In: bytes, and, where the values have no known scale, the heights that black and white pixels stand for. Out: the number of columns, and heights in
//! kilometres, rows from north to south. Always: the size (twice as wide as high, at most [`MAX_HEIGHTS`]) is checked before decoding. Not supported: colour,
//! palettes, alpha, several bands.

use super::{HeightRange, MAX_HEIGHTS, check_size};
use std::io::Cursor;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};

/// Error for 1, 2 or 4 bits per value.
const TOO_FEW_BITS: &str = "fewer than 8 bits per height";
/// Error for other unsupported types of values.
const UNSUPPORTED_VALUES: &str = "heights must be 8-bit or 16-bit unsigned, 16-bit signed, or 32-bit or 64-bit floating point";
/// The advice in errors about values whose scale is unknown. Its example has the range of the Moon's heights (LOLA).
const RANGE_HINT: &str = "add the heights of black and white in km, as FILE,-9.15,10.76";
/// Unit of unsigned 16-bit values in the CGI Moon Kit (<https://svs.gsfc.nasa.gov/4720>).
const HALF_METRE_KM: f64 = 0.0005;
/// The unsigned 16-bit value of height 0 in the CGI Moon Kit.
const VALUE_OF_HEIGHT_0: f64 = 20_000.0;

/// Number of columns, and heights in kilometres, row by row.
type Heights = (usize, Vec<f32>);

/// Reads a PNG or a TIFF. `range`: the heights that black and white pixels stand for. It is required for values of unknown scale, optional for unsigned 16-bit
/// values, and refused for floating-point values, which are in kilometres.
///
/// # Errors
/// The reason why the file cannot be read, in one line.
pub(super) fn heights_km(bytes: &[u8], range: Option<HeightRange>) -> Result<Heights, String> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => read_png(bytes, range),
        [b'I', b'I', 42, 0, ..] | [b'M', b'M', 0, 42, ..] => read_tiff(bytes, range),
        _ => Err("neither PNG nor TIFF, nor a PDS label (.LBL) or its image (.IMG)".into()),
    }
}

/// Maps pixel values linearly to kilometres: `black` to `range.black_km`, `white` to `range.white_km`.
fn range_to_km(range: HeightRange, [black, white]: [f64; 2]) -> impl Fn(f64) -> f32 {
    let slope = (range.white_km - range.black_km) / (white - black);
    move |value| (range.black_km + (value - black) * slope) as f32
}

/// Maps unsigned 16-bit values to kilometres: by the range, or without one by the scale of the CGI Moon Kit.
fn unsigned_16_to_km(range: Option<HeightRange>) -> Box<dyn Fn(f64) -> f32> {
    match range {
        Some(range) => Box::new(range_to_km(range, [0.0, 65_535.0])),
        None => Box::new(|value| ((value - VALUE_OF_HEIGHT_0) * HALF_METRE_KM) as f32),
    }
}

fn read_png(bytes: &[u8], range: Option<HeightRange>) -> Result<Heights, String> {
    // Twice the bytes of the 16-bit values.
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: 4 * MAX_HEIGHTS });
    decoder.set_transformations(png::Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
    let info = reader.info();
    let (columns, rows) = (info.width as usize, info.height as usize);
    let (colour, depth) = (info.color_type, info.bit_depth);
    check_size(columns, rows)?;
    if colour != png::ColorType::Grayscale {
        return Err("a colour, palette or alpha PNG: heights must be grey, of 8 or 16 bits".into());
    }
    let mut pixel_bytes = vec![0; reader.output_buffer_size().ok_or("too large")?];
    reader.next_frame(&mut pixel_bytes).map_err(|e| e.to_string())?;
    let heights: Vec<f32> = match depth {
        png::BitDepth::Sixteen => {
            let to_km = unsigned_16_to_km(range);
            pixel_bytes.as_chunks::<2>().0.iter().map(|pair| to_km(f64::from(u16::from_be_bytes(*pair)))).collect()
        }
        png::BitDepth::Eight => {
            let to_km = range_to_km(range.ok_or(format!("8-bit values have no stated scale: {RANGE_HINT}"))?, [0.0, 255.0]);
            pixel_bytes.iter().map(|v| to_km(f64::from(*v))).collect()
        }
        _ => return Err(TOO_FEW_BITS.into()),
    };
    Ok((columns, heights))
}

fn read_tiff(bytes: &[u8], range: Option<HeightRange>) -> Result<Heights, String> {
    // Eight bytes per value: f64.
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 8 * MAX_HEIGHTS;
    limits.intermediate_buffer_size = 8 * MAX_HEIGHTS;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?.with_limits(limits);
    let (columns, rows) = decoder.dimensions().map_err(|e| e.to_string())?;
    let (columns, rows) = (columns as usize, rows as usize);
    check_size(columns, rows)?;
    match decoder.colortype().map_err(|e| e.to_string())? {
        ColorType::Gray(8 | 16 | 32 | 64) => {}
        ColorType::Gray(..8) => return Err(TOO_FEW_BITS.into()),
        ColorType::Gray(_) => return Err(UNSUPPORTED_VALUES.into()),
        _ => return Err("a TIFF that is coloured, or of several bands: heights must be one grey band".into()),
    }
    let required_range = |what: &str| range.ok_or(format!("{what} have no stated scale: {RANGE_HINT}"));
    fn convert<T: Copy + Into<f64>>(values: &[T], to_km: impl Fn(f64) -> f32) -> Vec<f32> {
        values.iter().map(|v| to_km((*v).into())).collect()
    }
    let require_no_range =
        || if range.is_some() { Err("floating point is in km: leave out the heights of black and white".to_owned()) } else { Ok(()) };
    let heights = match decoder.read_image().map_err(|e| e.to_string())? {
        DecodingResult::U8(v) => convert(&v, range_to_km(required_range("8-bit values")?, [0.0, 255.0])),
        DecodingResult::U16(v) => convert(&v, unsigned_16_to_km(range)),
        DecodingResult::I16(v) => convert(&v, range_to_km(required_range("signed 16-bit values")?, [-32_768.0, 32_767.0])),
        DecodingResult::F32(v) => require_no_range().map(|()| v)?,
        DecodingResult::F64(v) => require_no_range().map(|()| convert(&v, |km| km as f32))?,
        _ => return Err(UNSUPPORTED_VALUES.into()),
    };
    if heights.len() != columns * rows {
        return Err("the number of values differs from the number of pixels".into());
    }
    Ok((columns, heights))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiff::encoder::{TiffEncoder, colortype};

    const RANGE: HeightRange = HeightRange { black_km: -9.0, white_km: 10.0 };
    const NO_RANGE: Option<HeightRange> = None;

    fn png(depth: png::BitDepth, colour: png::ColorType, width: u32, height: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_depth(depth);
        encoder.set_color(colour);
        encoder.write_header().and_then(|mut w| w.write_image_data(data)).expect("a PNG");
        bytes
    }

    #[test]
    fn pngs_of_both_depths_give_kilometres() {
        let sixteen: Vec<u8> =
            [0_u16, 20_000, 22_000, 40_000, 20_000, 20_000, 20_000, 65_535].iter().flat_map(|v| v.to_be_bytes()).collect();
        let bytes = png(png::BitDepth::Sixteen, png::ColorType::Grayscale, 4, 2, &sixteen);
        let (columns, km) = heights_km(&bytes, NO_RANGE).expect("read");
        assert_eq!((columns, km[1], km[2], km[3]), (4, 0.0, 1.0, 10.0));
        let (_, km) = heights_km(&bytes, Some(RANGE)).expect("read");
        assert_eq!((km[0], km[7]), (-9.0, 10.0));
        let eight = png(png::BitDepth::Eight, png::ColorType::Grayscale, 4, 2, &[0, 255, 0, 0, 0, 0, 0, 51]);
        assert!(heights_km(&eight, NO_RANGE).expect_err("no range").contains("FILE,-9.15,10.76"));
        let (_, km) = heights_km(&eight, Some(RANGE)).expect("read");
        assert_eq!((km[0], km[1]), (-9.0, 10.0));
        // 51 is a fifth of white: -9 + 19 / 5.
        assert!((km[7] + 5.2).abs() < 1e-6);
    }

    #[test]
    fn tiffs_of_integers_and_floats_give_kilometres() {
        fn tiff<C: colortype::ColorType>(width: u32, height: u32, data: &[C::Inner]) -> Vec<u8>
        where
            [C::Inner]: tiff::encoder::TiffValue,
        {
            let mut bytes = Cursor::new(Vec::new());
            TiffEncoder::new(&mut bytes).and_then(|mut e| e.write_image::<C>(width, height, data)).expect("a TIFF");
            bytes.into_inner()
        }
        let float = tiff::<colortype::Gray32Float>(4, 2, &[-1.5, 2.5, 0.0, 0.0, 0.0, 0.0, 0.0, 3.25]);
        let (columns, km) = heights_km(&float, NO_RANGE).expect("read");
        assert_eq!((columns, km[0], km[7]), (4, -1.5, 3.25));
        assert!(heights_km(&float, Some(RANGE)).is_err());
        let half_metres = tiff::<colortype::Gray16>(4, 2, &[18_000, 20_000, 20_002, 0, 0, 0, 0, 0]);
        assert_eq!(heights_km(&half_metres, NO_RANGE).expect("read").1[..3], [-1.0, 0.0, 0.001]);
        let signed = tiff::<colortype::GrayI16>(4, 2, &[-32_768, 32_767, 0, 0, 0, 0, 0, 0]);
        assert!(heights_km(&signed, NO_RANGE).is_err());
        assert_eq!(heights_km(&signed, Some(RANGE)).expect("read").1[..2], [-9.0, 10.0]);
        let double = tiff::<colortype::Gray64Float>(4, 2, &[-1.5, 2.5, 0.0, 0.0, 0.0, 0.0, 0.0, 3.25]);
        assert_eq!(heights_km(&double, NO_RANGE).expect("read").1[..2], [-1.5, 2.5]);
        let error_of = |bytes: &[u8]| heights_km(bytes, Some(RANGE)).expect_err("refused");
        assert!(error_of(&tiff::<colortype::RGB8>(4, 2, &[0; 24])).contains("several bands"));
        for bytes in [
            tiff::<colortype::GrayI8>(4, 2, &[0; 8]),
            tiff::<colortype::Gray32>(4, 2, &[0; 8]),
            tiff::<colortype::GrayI32>(4, 2, &[0; 8]),
            tiff::<colortype::Gray64>(4, 2, &[0; 8]),
        ] {
            assert_eq!(error_of(&bytes), UNSUPPORTED_VALUES);
        }
        // The TIFF entry BitsPerSample: tag 258, type 3 (u16), count 1; in native byte order, as the encoder writes. Other numbers of bits replace its value.
        let eight = tiff::<colortype::Gray8>(4, 2, &[0; 8]);
        let mut entry = [258_u16.to_ne_bytes(), 3_u16.to_ne_bytes()].concat();
        entry.extend(1_u32.to_ne_bytes());
        let value = eight.windows(entry.len()).position(|bytes| bytes == entry).expect("an entry") + entry.len();
        for (bits, error) in [(1_u16, TOO_FEW_BITS), (2, TOO_FEW_BITS), (4, TOO_FEW_BITS), (12, UNSUPPORTED_VALUES)] {
            let mut bytes = eight.clone();
            bytes[value..value + 2].copy_from_slice(&bits.to_ne_bytes());
            assert_eq!(error_of(&bytes), error, "{bits} bits");
        }
    }

    #[test]
    fn wrong_sizes_colours_and_damage_are_reported() {
        let square = png(png::BitDepth::Eight, png::ColorType::Grayscale, 2, 2, &[0; 4]);
        assert!(heights_km(&square, Some(RANGE)).expect_err("a square").contains("twice as wide"));
        let colour = png(png::BitDepth::Eight, png::ColorType::Rgb, 4, 2, &[0; 24]);
        assert!(heights_km(&colour, Some(RANGE)).expect_err("coloured").contains("grey"));
        let whole = png(png::BitDepth::Sixteen, png::ColorType::Grayscale, 4, 2, &[0; 16]);
        // Cut anywhere between the signature and the last chunk, IEND.
        assert!((9..whole.len() - 12).step_by(3).all(|n| heights_km(&whole[..n], NO_RANGE).is_err()));
        assert!(heights_km(b"GIF89a", NO_RANGE).is_err());
        // Width and height in the header are replaced by sizes that no memory can store, the width still twice the height.
        let mut huge = whole;
        huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xfe, 0x3f, 0xff, 0xff, 0xff]);
        assert!(heights_km(&huge, NO_RANGE).is_err());
    }
}
