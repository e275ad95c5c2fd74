//! Images in FITS files: the first image with two axes, in the primary HDU (header-data unit) or an IMAGE extension.
//!
//! In: bytes, whether the image is a map of a body, and its style. Out: [`PlacedImage`], or an error with the number of a card (80 bytes of a header).
//! Always: a stored number is multiplied by BSCALE, then BZERO is added; pixels that are BLANK or not finite are transparent; sizes are checked before data
//! are read. Rejected: cubes of several planes and compressed images (fpack).

mod header;
mod wcs;

use super::image_style::{ImageStyle, colours};
use header::{BLOCK_BYTES, CARD_BYTES, CardError, Header};
pub use wcs::ImageWcs;

/// Maximum number of pixels of an image.
const MAX_PIXELS: i64 = 100_000_000;
/// Maximum number of pixels along a side. An adapter may have a lower limit on textures.
const MAX_SIDE: i64 = 16_384;
/// Maximum number of HDUs that are searched.
const MAX_HDUS: usize = 100;

/// An image in colours with its world coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// sRGB and alpha, rows from the top: the last row of the file first. On a body, columns run from west to east.
    pub rgba: Vec<u8>,
    /// Its world coordinates.
    pub wcs: ImageWcs,
}

/// A header-data unit (HDU): a header and the data after it.
struct Hdu<'a> {
    header: Header,
    data: &'a [u8],
}

/// Number of data bytes that a header announces (FITS standard 4.0, section 4.4.1). A size that no file has is an error: more than 2^40 along an axis, or 2^48
/// values or more.
fn data_bytes(header: &Header) -> Result<usize, CardError> {
    let axes = header.integer("NAXIS", 0..=999)?;
    // Checked here, because a wrong number of bits would lead to a wrong place for the next header.
    let bits = bits_per_value(header)?.unsigned_abs();
    // Without axes there are no values.
    let mut value_count: u64 = u64::from(axes > 0);
    for k in 1..=axes {
        let side = header.integer(&format!("NAXIS{k}"), 0..=1 << 40)?.unsigned_abs();
        // In the deprecated structure of random groups, NAXIS1 is 0 and does not count (standard, section 6).
        if k == 1 && side == 0 && has_random_groups(header) {
            continue;
        }
        value_count = value_count
            .checked_mul(side)
            .filter(|c| *c < 1 << 48)
            .ok_or_else(|| (header.card_number("NAXIS1"), "more data than a file holds".to_owned()))?;
    }
    let parameters = if header.text("PCOUNT").is_empty() { 0 } else { header.integer("PCOUNT", 0..=1 << 40)?.unsigned_abs() };
    let groups = if header.text("GCOUNT").is_empty() { 1 } else { header.integer("GCOUNT", 0..=1 << 20)?.unsigned_abs() };
    let bytes = (bits / 8).checked_mul(groups).and_then(|b| b.checked_mul(value_count.checked_add(parameters)?));
    let bytes = bytes.and_then(|b| usize::try_from(b).ok()).filter(|b| *b < usize::MAX / 2);
    bytes.ok_or_else(|| (header.card_number("NAXIS1"), "more data than a file holds".to_owned()))
}

/// The value of BITPIX: the number of bits of a value, negative for floating point.
fn bits_per_value(header: &Header) -> Result<i64, CardError> {
    let bits = header.integer("BITPIX", -64..=64)?;
    match bits {
        8 | 16 | 32 | 64 | -32 | -64 => Ok(bits),
        other => Err((header.card_number("BITPIX"), format!("BITPIX: {other} is not one of 8, 16, 32, 64, -32, -64"))),
    }
}

fn has_random_groups(header: &Header) -> bool {
    header.text("GROUPS") == "T"
}

/// The first HDU whose image has at least two axes, none of length 0.
fn image_hdu(bytes: &[u8]) -> Result<Hdu<'_>, CardError> {
    if !bytes.starts_with(b"SIMPLE  =") {
        return Err((1, "does not begin with SIMPLE: not FITS".to_owned()));
    }
    let (mut offset, mut is_compressed) = (0, false);
    // The error of the first image without pixels, for a file that has no other image.
    let mut empty_image_error = None;
    for _ in 0..MAX_HDUS {
        let rest = bytes.get(offset..).filter(|rest| rest.len() >= BLOCK_BYTES);
        let Some(rest) = rest else { break };
        let header = Header::read(rest, offset / CARD_BYTES + 1)?;
        let length = data_bytes(&header)?;
        let data = rest.get(header.data_offset..).unwrap_or_default();
        is_compressed |= header.text("ZIMAGE") == "T";
        let is_image = matches!(header.text("XTENSION"), "" | "IMAGE") && header.integer("NAXIS", 0..=999)? >= 2;
        let empty_error = if is_image { empty_axis_error(&header) } else { None };
        if is_image && empty_error.is_none() && length > 0 {
            let data = data.get(..length).ok_or_else(|| {
                (header.card_number("NAXIS1"), format!("{length} bytes of data announced, {} in the file: cut short", data.len()))
            })?;
            return Ok(Hdu { header, data });
        }
        empty_image_error = empty_image_error.or(empty_error);
        offset = offset.saturating_add(header.data_offset).saturating_add(length.next_multiple_of(BLOCK_BYTES));
    }
    Err(match empty_image_error {
        _ if is_compressed => (1, "the image is compressed; unpack it (funpack)".to_owned()),
        Some(error) => error,
        None => (1, "no image in it: no HDU of two axes".to_owned()),
    })
}

/// The error that describes an image with a side of 0: random groups, which have NAXIS1 = 0, or an image without pixels. `None` if no side is 0.
fn empty_axis_error(header: &Header) -> Option<CardError> {
    let mut keywords = (1..=999).map(|k| format!("NAXIS{k}")).take_while(|k| !header.text(k).is_empty());
    let keyword = keywords.find(|k| header.integer(k, 0..=0).is_ok())?;
    let why = if has_random_groups(header) {
        format!("{keyword}: 0, so that these are random groups, not an image; they cannot be drawn")
    } else {
        format!("{keyword}: 0 pixels along this axis, so that there is no image to draw")
    };
    Some((header.card_number(&keyword), why))
}

/// The values of the pixels after BSCALE and BZERO, in the order of the file; NaN where the value is BLANK. The data may be longer than the image: by the
/// values that PCOUNT announces, or by further groups (GCOUNT); these are left out.
fn scaled_values(hdu: &Hdu<'_>, pixel_count: usize) -> Result<Vec<f32>, CardError> {
    let header = &hdu.header;
    let scale = header.number("BSCALE")?.unwrap_or(1.0);
    let zero = header.number("BZERO")?.unwrap_or(0.0);
    let blank = if header.text("BLANK").is_empty() { None } else { Some(header.integer("BLANK", i64::MIN..=i64::MAX)?) };
    let scaled_integer = |v: i64| if Some(v) == blank { f32::NAN } else { (scale * v as f64 + zero) as f32 };
    let scaled_float = |v: f64| (scale * v + zero) as f32;
    fn map_chunks<const N: usize>(data: &[u8], value: impl Fn([u8; N]) -> f32) -> Vec<f32> {
        data.as_chunks::<N>().0.iter().map(|b| value(*b)).collect()
    }
    let bits = bits_per_value(header)?;
    let data = hdu.data.get(..pixel_count * (bits.unsigned_abs() / 8) as usize).unwrap_or(hdu.data);
    Ok(match bits {
        8 => map_chunks(data, |[b]| scaled_integer(i64::from(b))),
        16 => map_chunks(data, |b| scaled_integer(i64::from(i16::from_be_bytes(b)))),
        32 => map_chunks(data, |b| scaled_integer(i64::from(i32::from_be_bytes(b)))),
        64 => map_chunks(data, |b| scaled_integer(i64::from_be_bytes(b))),
        -32 => map_chunks(data, |b| scaled_float(f64::from(f32::from_be_bytes(b)))),
        // -64, the only other value of `bits_per_value`.
        _ => map_chunks(data, |b| scaled_float(f64::from_be_bytes(b))),
    })
}

/// Reads the first image of a file. `on_body`: the image is a map of a body, not of the sky.
pub(super) fn read(bytes: &[u8], on_body: bool, style: &ImageStyle) -> Result<PlacedImage, CardError> {
    let hdu = image_hdu(bytes)?;
    let header = &hdu.header;
    let [width, height] = [header.integer("NAXIS1", 1..=MAX_SIDE)?, header.integer("NAXIS2", 1..=MAX_SIDE)?];
    for k in 3..=header.integer("NAXIS", 2..=999)? {
        header
            .integer(&format!("NAXIS{k}"), 1..=1)
            .map_err(|(card, why)| (card, format!("{why}: only an image of one plane can be drawn, not a cube")))?;
    }
    if width * height > MAX_PIXELS {
        return Err((header.card_number("NAXIS1"), format!("{width}x{height} pixels; the limit is {MAX_PIXELS}")));
    }
    let size = [width, height].map(|side| u32::try_from(side).unwrap_or(1));
    let wcs = if on_body { wcs::of_body_map(header, size)? } else { wcs::of_sky_image(header)? };
    let values = scaled_values(&hdu, size[0] as usize * size[1] as usize)?;
    let colours = colours(&values, style).ok_or_else(|| (header.card_number("BITPIX"), "the image has no finite value".to_owned()))?;
    let row_bytes = 4 * size[0] as usize;
    let mut rgba: Vec<u8> = colours.chunks_exact(row_bytes).rev().flatten().copied().collect();
    if matches!(wcs, ImageWcs::PlateCarree { mirrored: true, .. }) {
        rgba.chunks_exact_mut(row_bytes).for_each(|row| {
            let mirrored: Vec<u8> = row.as_chunks::<4>().0.iter().rev().flatten().copied().collect();
            row.copy_from_slice(&mirrored);
        });
    }
    Ok(PlacedImage { width: size[0], height: size[1], rgba, wcs })
}

#[cfg(test)]
mod tests {
    use super::super::image_style::Stretch;
    use super::*;

    /// Values of the argument `on_body` of [`read`].
    const ON_SKY: bool = false;
    const ON_BODY: bool = true;
    const TAN: &[(&str, &str)] = &[
        ("CTYPE1", "'RA---TAN'"),
        ("CTYPE2", "'DEC--TAN'"),
        ("CRVAL1", "83.633"),
        ("CRVAL2", "22.0145"),
        ("CRPIX1", "1.5"),
        ("CRPIX2", "1.0"),
        ("CDELT1", "-0.01"),
        ("CDELT2", "0.01"),
    ];
    const SIZE: &[(&str, &str)] = &[("NAXIS", "2"), ("NAXIS1", "2"), ("NAXIS2", "2")];

    /// A header of whole blocks: its first card, the cards given, and END.
    fn header_block(first: &str, cards: &[&[(&str, &str)]]) -> Vec<u8> {
        let mut text = format!("{first:<80}");
        for (keyword, value) in cards.iter().copied().flatten() {
            text += &format!("{:<80}", format!("{keyword:<8}= {value:>20} / about"));
        }
        text += &format!("{:<80}", "END");
        let length = text.len().next_multiple_of(BLOCK_BYTES);
        format!("{text:<length$}").into_bytes()
    }

    const SIMPLE: &str = "SIMPLE  =                    T";

    fn file(cards: &[&[(&str, &str)]], data: &[u8]) -> Vec<u8> {
        let mut bytes = header_block(SIMPLE, cards);
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(BLOCK_BYTES), 0);
        bytes
    }

    fn full_range() -> ImageStyle {
        ImageStyle { percentiles: [0.0, 100.0], ..ImageStyle::default() }
    }

    fn red(image: &PlacedImage) -> Vec<u8> {
        image.rgba.chunks(4).map(|p| p[0]).collect()
    }

    /// Each number format is read. The first row of the file is the lowest, that of the image the highest.
    #[test]
    fn every_number_format_is_read_scaled_and_stretched() {
        let formats: [(&str, Vec<u8>); 6] = [
            ("8", vec![0, 51, 102, 255]),
            ("16", [0_i16, 51, 102, 255].iter().flat_map(|v| v.to_be_bytes()).collect()),
            ("32", [0_i32, 51, 102, 255].iter().flat_map(|v| v.to_be_bytes()).collect()),
            ("64", [0_i64, 51, 102, 255].iter().flat_map(|v| v.to_be_bytes()).collect()),
            ("-32", [0_f32, 51.0, 102.0, 255.0].iter().flat_map(|v| v.to_be_bytes()).collect()),
            ("-64", [0_f64, 51.0, 102.0, 255.0].iter().flat_map(|v| v.to_be_bytes()).collect()),
        ];
        for (bits, data) in formats {
            let image = read(&file(&[&[("BITPIX", bits)], SIZE, TAN], &data), ON_SKY, &full_range()).expect(bits);
            assert_eq!(red(&image), [102, 255, 0, 51], "{bits}");
        }
        let scaled: &[(&str, &str)] = &[("BITPIX", "16"), ("BSCALE", "-2.0D0"), ("BZERO", "10"), ("BLANK", "7")];
        let data: Vec<u8> = [0_i16, 7, 5, 10].iter().flat_map(|v| v.to_be_bytes()).collect();
        let image = read(&file(&[scaled, SIZE, TAN], &data), ON_SKY, &full_range()).expect("scaled");
        // The values are 10, blank, 0, -10.
        assert_eq!(image.rgba, [128, 128, 128, 255, 0, 0, 0, 255, 255, 255, 255, 255, 0, 0, 0, 0]);
        let sqrt = ImageStyle { stretch: Stretch::Sqrt, ..full_range() };
        let data = [0_u8, 51, 102, 255];
        let image = read(&file(&[&[("BITPIX", "8")], SIZE, TAN], &data), ON_SKY, &sqrt).expect("stretched");
        // The value 51, in the first row of the file, and so in the last of the image: 255 sqrt(51 / 255) = 114.0.
        assert_eq!(red(&image)[3], 114);
    }

    /// The values of PCOUNT and those of a second group follow the pixels. They are no part of the image, and do not change its stretch.
    #[test]
    fn values_after_the_pixels_are_ignored() {
        let pixels: Vec<u8> = [0_i16, 51, 102, 204].iter().flat_map(|v| v.to_be_bytes()).collect();
        let with_others: Vec<u8> = [0_i16, 51, 102, 204, -9000, 9000, 9000, 9000].iter().flat_map(|v| v.to_be_bytes()).collect();
        let image = |cards: &[(&str, &str)], data: &[u8]| {
            read(&file(&[&[("BITPIX", "16")], SIZE, TAN, cards], data), ON_SKY, &full_range())
                .unwrap_or_else(|e| panic!("{cards:?}: {e:?}"))
        };
        let alone = image(&[], &pixels);
        assert_eq!(alone.rgba.len(), 16);
        for cards in [&[("PCOUNT", "4")][..], &[("PCOUNT", "4"), ("GCOUNT", "1")], &[("PCOUNT", "0"), ("GCOUNT", "2")]] {
            assert_eq!(image(cards, &with_others), alone, "{cards:?}");
        }
        assert_ne!(image(&[], &with_others[8..]), alone, "the comparison must be able to fail");
    }

    #[test]
    fn the_first_image_is_read_with_its_place() {
        let empty: &[(&str, &str)] = &[("BITPIX", "8"), ("NAXIS", "0")];
        let table: &[(&str, &str)] =
            &[("BITPIX", "8"), ("NAXIS", "2"), ("NAXIS1", "3000"), ("NAXIS2", "1"), ("PCOUNT", "0"), ("GCOUNT", "1")];
        let mut bytes = header_block(SIMPLE, &[empty]);
        bytes.extend(header_block("XTENSION= 'BINTABLE'", &[table]));
        bytes.extend([0; 2 * BLOCK_BYTES]);
        bytes.extend(header_block("XTENSION= 'IMAGE   '", &[&[("BITPIX", "8")], SIZE, TAN]));
        bytes.extend([1, 2, 3, 4]);
        let image = read(&bytes, ON_SKY, &full_range()).expect("the third");
        let ImageWcs::Tangent { centre_deg, centre_px, deg_per_px } = image.wcs else { panic!("{:?}", image.wcs) };
        assert_eq!((centre_deg, centre_px, deg_per_px), ([83.633, 22.0145], [1.5, 1.0], [[-0.01, -0.0], [-0.0, 0.01]]));
        // A quarter turn, expressed in each of the three ways; the last without CDELT, too.
        let quarter = |cards: &[(&str, &str)]| {
            let image = read(&file(&[&[("BITPIX", "8")], SIZE, &TAN[..6], cards], &[1, 2, 3, 4]), ON_SKY, &full_range()).expect("placed");
            let ImageWcs::Tangent { deg_per_px, .. } = image.wcs else { panic!("{:?}", image.wcs) };
            deg_per_px.map(|row| row.map(|v| (v * 1e6).round()))
        };
        let expected = [[0.0, -1e4], [1e4, 0.0]];
        let scale = [("CDELT1", "0.01"), ("CDELT2", "0.01")];
        assert_eq!(quarter(&[("CD1_2", "-0.01"), ("CD2_1", "0.01")]), expected);
        assert_eq!(quarter(&[scale[0], scale[1], ("CROTA2", "90")]), expected);
        assert_eq!(quarter(&[scale[0], scale[1], ("PC1_1", "0"), ("PC1_2", "-1"), ("PC2_1", "1"), ("PC2_2", "0")]), expected);
        assert_eq!(quarter(&[("PC1_1", "0"), ("PC1_2", "-0.01"), ("PC2_1", "0.01"), ("PC2_2", "0")]), expected);
    }

    #[test]
    fn maps_of_bodies_have_edges() {
        let file_with = |cards: &[(&str, &str)], size: &[(&str, &str)], data: &[u8]| {
            read(&file(&[&[("BITPIX", "8")], size, cards], data), ON_BODY, &full_range()).map(|i| (red(&i), i.wcs))
        };
        let (_, globe) = file_with(&[], &[("NAXIS", "2"), ("NAXIS1", "2"), ("NAXIS2", "1")], &[1, 2]).expect("the globe");
        assert_eq!(globe, ImageWcs::PlateCarree { west_deg: -180.0, east_deg: 180.0, south_deg: -90.0, north_deg: 90.0, mirrored: false });
        let plate_carree = |dx: &'static str| {
            [
                ("CTYPE1", "'MALN-CAR'"),
                ("CTYPE2", "'MALT-CAR'"),
                ("CRVAL1", "30"),
                ("CRPIX1", "1.5"),
                ("CRPIX2", "0.5"),
                ("CDELT1", dx),
                ("CDELT2", "10"),
            ]
        };
        let (texels, part) = file_with(&plate_carree("10"), SIZE, &[0, 85, 170, 255]).expect("a part");
        assert_eq!(part, ImageWcs::PlateCarree { west_deg: 20.0, east_deg: 40.0, south_deg: 0.0, north_deg: 20.0, mirrored: false });
        assert_eq!(texels, [170, 255, 0, 85]);
        let (texels, part) = file_with(&plate_carree("-10"), SIZE, &[0, 85, 170, 255]).expect("west to the right");
        assert_eq!(part, ImageWcs::PlateCarree { west_deg: 20.0, east_deg: 40.0, south_deg: 0.0, north_deg: 20.0, mirrored: true });
        assert_eq!(texels, [255, 170, 85, 0]);
        assert!(file_with(&plate_carree("1000"), SIZE, &[1, 2, 3, 4]).is_err_and(|(_, why)| why.contains("do not fit on a globe")));
        assert!(file_with(&[], SIZE, &[1, 2, 3, 4]).is_err_and(|(_, why)| why.contains("plate carree")));
        assert!(file_with(TAN, SIZE, &[1, 2, 3, 4]).is_err_and(|(_, why)| why.contains("RA---TAN")));
        let in_radians = [&plate_carree("0.1")[..], &[("CUNIT1", "'rad'")][..]].concat();
        assert!(file_with(&in_radians, SIZE, &[1, 2, 3, 4]).is_err_and(|(_, why)| why.starts_with("CUNIT1: `rad`")));
        for degrees in ["'deg'", "'DEG'", "'degree'", "'Degrees '"] {
            let in_degrees = [&plate_carree("10")[..], &[("CUNIT1", degrees), ("CUNIT2", degrees)]].concat();
            assert!(file_with(&in_degrees, SIZE, &[1, 2, 3, 4]).is_ok(), "{degrees}");
        }
        let rotated = [&plate_carree("10")[..], &[("LONPOLE", "90")]].concat();
        assert!(file_with(&rotated, SIZE, &[1, 2, 3, 4]).is_err_and(|(_, why)| why.starts_with("LONPOLE")));
        let (_, north_up) = file_with(&plate_carree("10"), SIZE, &[1, 2, 3, 4]).expect("a part");
        // Card 13 follows SIMPLE, BITPIX, the three cards of SIZE, the seven of the projection.
        for (latitude, is_north_up) in [("90", true), ("0", true), ("-90", false)] {
            let with_pole = [&plate_carree("10")[..], &[("LATPOLE", latitude)]].concat();
            match file_with(&with_pole, SIZE, &[1, 2, 3, 4]) {
                Ok((_, wcs)) => assert!(is_north_up && wcs == north_up, "{latitude}: {wcs:?}"),
                Err((card, why)) => assert!(!is_north_up && card == 13 && why.starts_with("LATPOLE: `-90`"), "{latitude}: {card}: {why}"),
            }
        }
        let far = plate_carree("10").map(|(keyword, value)| (keyword, if keyword == "CRPIX1" { "1e300" } else { value }));
        assert!(
            file_with(&far, SIZE, &[1, 2, 3, 4]).is_err_and(|(card, why)| card == 9 && why == "CRPIX1: `1e300` is not within ±10000000000")
        );
        // The error names the card at fault: CD1_1 (card 11) is zero, or CD2_2 (card 12) is negative.
        for (cd, expected) in [(["0.0", "10"], 11), (["10", "-10"], 12)] {
            let cards = [&plate_carree("10")[..5], &[("CD1_1", cd[0]), ("CD2_2", cd[1])]].concat();
            assert!(file_with(&cards, SIZE, &[1, 2, 3, 4]).is_err_and(|(card, _)| card == expected), "{cd:?}");
        }
    }

    /// In older files the cards of frame and equinox have other names.
    #[test]
    fn older_cards_of_frame_and_equinox_count() {
        let result = |cards: &[(&str, &str)]| read(&file(&[&[("BITPIX", "8")], SIZE, TAN, cards], &[1, 2, 3, 4]), ON_SKY, &full_range());
        for cards in [&[("EPOCH", "1950.0")][..], &[("RADECSYS", "'FK4'")][..], &[("RADECSYS", "'FK5'"), ("EPOCH", "1950.0")][..]] {
            assert!(result(cards).is_err_and(|(_, why)| why.contains("only ICRS and FK5 J2000")), "{cards:?}");
        }
        // An EPOCH of 2000 is J2000. EPOCH is not read as the equinox if there is an EQUINOX, if the frame is the ICRS, or if EPOCH is a text.
        for cards in [
            &[("EPOCH", "2000.0"), ("RADECSYS", "'FK5'")][..],
            &[("EPOCH", "1954.8"), ("EQUINOX", "2000.0")][..],
            &[("EPOCH", "2015.5"), ("RADESYS", "'ICRS'")][..],
            &[("EPOCH", "'J2000'")][..],
        ] {
            assert!(result(cards).is_ok(), "{cards:?}");
        }
    }

    /// LONPOLE is the native longitude of the celestial pole. Along the intermediate coordinates 0 is towards -y, 90 towards +x, 180 towards +y. The default is
    /// 180, but 0 at the north pole.
    #[test]
    fn lonpole_says_where_north_is() {
        let matrix = |declination: &str, cards: &[(&str, &str)]| {
            let tan: Vec<(&str, &str)> = TAN.iter().map(|(k, v)| (*k, if *k == "CRVAL2" { declination } else { *v })).collect();
            match read(&file(&[&[("BITPIX", "8")], SIZE, &tan, cards], &[1, 2, 3, 4]), ON_SKY, &full_range()).expect("placed").wcs {
                ImageWcs::Tangent { deg_per_px, .. } => deg_per_px,
                other => panic!("{other:?}"),
            }
        };
        let (north_up, north_down) = ([[-0.01, 0.0], [0.0, 0.01]], [[0.01, 0.0], [0.0, -0.01]]);
        assert_eq!([matrix("89.9", &[]), matrix("-90", &[]), matrix("90", &[("LONPOLE", "180")])], [north_up; 3]);
        assert_eq!([matrix("90", &[]), matrix("20", &[("LONPOLE", "0")])], [north_down; 2]);
        // At 90 degrees north is in the direction of x, which is to the left here, and east is down.
        let [[east_by_x, east_by_y], [north_by_x, north_by_y]] = matrix("20", &[("LONPOLE", "90")]);
        assert!((east_by_y + 0.01).abs() < 1e-9 && (north_by_x + 0.01).abs() < 1e-9, "{east_by_y} {north_by_x}");
        assert!(east_by_x.abs() < 1e-9 && north_by_y.abs() < 1e-9, "{east_by_x} {north_by_y}");
    }

    #[test]
    fn errors_of_unsupported_images_name_the_card() {
        let why = |cards: &[&[(&str, &str)]], data: &[u8]| read(&file(cards, data), ON_SKY, &full_range()).expect_err("refused");
        let bits: &[(&str, &str)] = &[("BITPIX", "8")];
        let data = [1, 2, 3, 4];
        assert!(read(b"GIF89a", ON_SKY, &full_range()).is_err_and(|(_, w)| w.contains("not FITS")));
        assert!(read(&header_block(SIMPLE, &[bits])[..2000], ON_SKY, &full_range()).is_err_and(|(_, w)| w.contains("no image")));
        assert!(why(&[bits, &[("NAXIS", "0")]], &[]).1.starts_with("no image in it"));
        let sides = |width, height| -> [(&str, &str); 3] { [("NAXIS", "2"), ("NAXIS1", width), ("NAXIS2", height)] };
        for (width, height, card, expected) in [("0", "2", 4, "NAXIS1: 0 pixels along this axis"), ("2", "0", 5, "NAXIS2: 0 pixels")] {
            let (at, reason) = why(&[bits, &sides(width, height), TAN], &[]);
            assert!(at == card && reason.starts_with(expected), "{at}: {reason}");
        }
        let groups: &[(&str, &str)] = &[("GROUPS", "T"), ("PCOUNT", "1"), ("GCOUNT", "4000")];
        let (at, reason) = why(&[bits, &sides("0", "2"), groups], &[]);
        assert!(at == 4 && reason.contains("random groups"), "{at}: {reason}");
        // An image after random groups (4000 groups of 1 + 2 bytes) is found.
        let mut groups_then_image = header_block(SIMPLE, &[bits, &sides("0", "2"), groups]);
        groups_then_image.resize(groups_then_image.len() + 12_000_usize.next_multiple_of(BLOCK_BYTES), 0);
        groups_then_image.extend(header_block("XTENSION= 'IMAGE   '", &[bits, SIZE, TAN]));
        groups_then_image.extend([1_u8, 2, 3, 4]);
        assert!(read(&groups_then_image, ON_SKY, &full_range()).is_ok());
        let cut = header_block(SIMPLE, &[bits, &[("NAXIS", "2"), ("NAXIS1", "100"), ("NAXIS2", "100")], TAN]);
        assert!(read(&cut, ON_SKY, &full_range()).is_err_and(|(_, w)| w.starts_with("10000 bytes of data announced, 0 in the file")));
        for (from, to, card, expected) in [
            ("RA---TAN", "RA---SIN", 6, "CTYPE1: `RA---SIN`: on the sky only"),
            ("RA---TAN", "RA---TAN-SIP", 6, "CTYPE1: `RA---TAN-SIP`"),
            ("83.633", "x", 8, "CRVAL1: `x` is not a number"),
            ("22.0145", "122.0", 9, "CRVAL2: `122.0` is not within ±90"),
        ] {
            let changed: Vec<(&str, String)> = TAN.iter().map(|(k, v)| (*k, v.replace(from, to))).collect();
            let changed: Vec<(&str, &str)> = changed.iter().map(|(k, v)| (*k, v.as_str())).collect();
            let (at, reason) = why(&[bits, SIZE, &changed], &data);
            assert!(at == card && reason.starts_with(expected), "{at}: {reason}");
        }
        assert!(why(&[bits, SIZE, TAN, &[("RADESYS", "'FK4'")]], &data).1.starts_with("RADESYS: `FK4`"));
        assert!(why(&[bits, SIZE, TAN, &[("EQUINOX", "1950.0")]], &data).1.starts_with("EQUINOX: `1950.0`"));
        assert!(why(&[bits, SIZE, TAN, &[("A_ORDER", "2")]], &data).1.starts_with("A_ORDER"));
        assert!(why(&[bits, SIZE, &TAN[..6]], &data).1.contains("the image has no scale"));
        assert!(why(&[bits, SIZE, &TAN[..6], &[("CD1_1", "0.01")]], &data).1.contains("cannot be placed"));
        assert!(why(&[&[("BITPIX", "12")], SIZE, TAN], &data).1.contains("not one of 8"));
        // With 7 bits, that is no bytes, the next header would be searched in the data.
        let (card, reason) = why(&[&[("BITPIX", "7")], SIZE, TAN], &data);
        assert!(card == 2 && reason.starts_with("BITPIX: 7 is not one of 8"), "{card}: {reason}");
        let cube: &[(&str, &str)] = &[("NAXIS", "3"), ("NAXIS1", "2"), ("NAXIS2", "1"), ("NAXIS3", "2")];
        assert!(why(&[bits, cube, TAN], &data).1.contains("not a cube"));
        let huge: &[(&str, &str)] = &[("NAXIS", "2"), ("NAXIS1", "1000000000"), ("NAXIS2", "1000000000")];
        assert!(why(&[bits, huge, TAN], &data).1.contains("more data than a file holds"));
        let nothing: Vec<u8> = [f32::NAN; 4].iter().flat_map(|v| v.to_be_bytes()).collect();
        assert!(why(&[&[("BITPIX", "-32")], SIZE, TAN], &nothing).1.contains("the image has no finite value"));
        let mut packed = header_block(SIMPLE, &[bits, &[("NAXIS", "0")]]);
        packed.extend(header_block("XTENSION= 'BINTABLE'", &[bits, SIZE, &[("PCOUNT", "0"), ("GCOUNT", "1"), ("ZIMAGE", "T")]]));
        packed.extend([0; BLOCK_BYTES]);
        assert!(read(&packed, ON_SKY, &full_range()).is_err_and(|(_, w)| w.contains("funpack")));
    }
}
