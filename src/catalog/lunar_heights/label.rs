//! Reads heights from a PDS3 label and its image, the format of LOLA's LDEM maps.
//!
//! In: the label's text and the image's bytes. Out: heights in kilometres, the western edge of the map and the radius of its reference sphere. Supported are
//! detached labels (in a file of their own), 16-bit integers and 32-bit floating point, both byte orders, SCALING_FACTOR and OFFSET, metres and kilometres,
//! other bytes around the samples of a line, simple cylindrical maps of the entire Moon, and longitudes positive east or west. Anything else, such as a sample
//! without a height, is rejected with an error that names the keyword.

use super::{DEFAULT_SPHERE_KM, check_size};
use crate::wording::{echo, without_byte_order_mark};

/// The map that a label and its image describe.
pub(super) struct LabelledHeights {
    pub columns: usize,
    /// Heights, rows from north to south.
    pub heights_km: Vec<f32>,
    /// Longitude of the western edge.
    pub west_deg: f64,
    /// Radius of the reference sphere.
    pub sphere_km: f64,
}

/// The value of a keyword: the text after the first `KEYWORD =`, without unit and comment, and without the quotes and parentheses at its ends.
fn value<'t>(label: &'t str, keyword: &str) -> Option<&'t str> {
    label.lines().find_map(|line| {
        let (name, value) = line.split_once('=')?;
        let value = value.split("/*").next().unwrap_or(value);
        let value = value.split('<').next().unwrap_or(value);
        (name.trim().eq_ignore_ascii_case(keyword)).then_some(value.trim().trim_matches(['"', '(', ')']).trim())
    })
}

/// The value of a keyword; an error if the label lacks it.
fn required<'t>(label: &'t str, keyword: &str) -> Result<&'t str, String> {
    value(label, keyword).ok_or_else(|| format!("the label has no {keyword}"))
}

/// Parses `text`, the value of a keyword, as a finite number.
fn number(keyword: &str, text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| format!("{keyword} = {}: not a number", echo(text)))
}

/// The number of a keyword, or a default if the label lacks it.
fn number_or(label: &str, keyword: &str, default: f64) -> Result<f64, String> {
    value(label, keyword).map_or(Ok(default), |v| number(keyword, v))
}

/// The whole number of a keyword, or a default if the label lacks it.
fn count_or(label: &str, keyword: &str, default: usize) -> Result<usize, String> {
    value(label, keyword).map_or(Ok(default), |v| v.parse().map_err(|_| format!("{keyword} = {}: not a whole number", echo(v))))
}

/// The keywords of the values, before scaling, that stand for samples without a height.
const NO_HEIGHT_KEYWORDS: [&str; 2] = ["MISSING_CONSTANT", "INVALID_CONSTANT"];

/// The values that stand for samples without a height, each with its keyword and value as in the label.
fn no_height_values(label: &str) -> Result<Vec<(String, f32)>, String> {
    let given = NO_HEIGHT_KEYWORDS.into_iter().filter_map(|keyword| Some((keyword, value(label, keyword)?)));
    // PDS's words for a keyword that has no value.
    let with_value = given.filter(|(_, text)| !["N/A", "UNK", "NULL"].iter().any(|word| word.eq_ignore_ascii_case(text)));
    // As f32, because the decimals of a label need not give the exact value of a 32-bit sample.
    with_value.map(|(keyword, text)| Ok((format!("{keyword} = {}", echo(text)), number(keyword, text)? as f32))).collect()
}

/// The name of the image file that a label refers to.
pub(super) fn image_file(label: &str) -> Result<String, String> {
    let pointer = required(without_byte_order_mark(label), "^IMAGE")?;
    // Either a file name, optionally followed by a record number, or a record number in the label's own file.
    let file = pointer.split(',').next().unwrap_or(pointer).trim().trim_matches('"').trim();
    if file.is_empty() || file.chars().all(|c| c.is_ascii_digit()) {
        return Err("^IMAGE does not name a file: only labels in a file of their own are supported".into());
    }
    match file.contains(['/', '\\', ':']) || file.starts_with('.') {
        true => Err(format!("^IMAGE = {}: the image must be in the same folder as its label", echo(file))),
        false => Ok(file.to_owned()),
    }
}

/// Number of bytes in the image file before the first height. After the file's name, `^IMAGE` may give the number of the first record or, with the unit
/// `<BYTES>`, of the first byte; both are counted from 1.
fn image_offset(label: &str) -> Result<usize, String> {
    let Some((pointer, (_, location))) = value(label, "^IMAGE").and_then(|pointer| Some((pointer, pointer.split_once(',')?))) else {
        return Ok(0);
    };
    // Records or bytes.
    let units_before = location.trim().parse::<usize>().ok().and_then(|n| n.checked_sub(1));
    let units_before = units_before.ok_or_else(|| format!("^IMAGE = {}: its location is not a whole number from 1", echo(pointer)))?;
    let is_image_pointer = |line: &&str| line.split_once('=').is_some_and(|(name, _)| name.trim().eq_ignore_ascii_case("^IMAGE"));
    let is_in_bytes = label.lines().find(is_image_pointer).is_some_and(|line| line.to_ascii_uppercase().contains("<BYTES>"));
    let unit_bytes = match units_before {
        0 => 0,
        _ if is_in_bytes => 1,
        _ => required(label, "RECORD_BYTES")?.parse::<usize>().map_err(|_| "RECORD_BYTES: not a whole number".to_owned())?,
    };
    Ok(units_before.saturating_mul(unit_bytes))
}

/// The sample format of the image: type and byte order. Integers have 16 bits, reals have 32.
#[derive(Clone, Copy)]
enum Sample {
    SignedLittle,
    SignedBig,
    UnsignedLittle,
    UnsignedBig,
    RealLittle,
    RealBig,
}

impl Sample {
    fn of(label: &str) -> Result<Self, String> {
        let (kind, bits) = (required(label, "SAMPLE_TYPE")?.to_ascii_uppercase(), required(label, "SAMPLE_BITS")?);
        Ok(match (kind.as_str(), bits) {
            ("LSB_INTEGER" | "PC_INTEGER", "16") => Self::SignedLittle,
            ("MSB_INTEGER" | "INTEGER" | "SUN_INTEGER" | "MAC_INTEGER", "16") => Self::SignedBig,
            ("LSB_UNSIGNED_INTEGER" | "PC_UNSIGNED_INTEGER", "16") => Self::UnsignedLittle,
            ("MSB_UNSIGNED_INTEGER" | "UNSIGNED_INTEGER", "16") => Self::UnsignedBig,
            ("PC_REAL" | "LSB_REAL", "32") => Self::RealLittle,
            ("IEEE_REAL" | "REAL" | "FLOAT" | "MSB_REAL" | "SUN_REAL", "32") => Self::RealBig,
            _ => {
                let what = format!("SAMPLE_TYPE = {} of SAMPLE_BITS = {}", echo(&kind), echo(bits));
                return Err(format!(
                    "{what}: supported are 16-bit integers (LSB_INTEGER, MSB_INTEGER, ...) and 32-bit PC_REAL and IEEE_REAL"
                ));
            }
        })
    }

    fn bytes(self) -> usize {
        if matches!(self, Self::RealLittle | Self::RealBig) { 4 } else { 2 }
    }

    /// The value of one sample. `bytes` must have the length that [`Self::bytes`] returns.
    fn value(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Self::SignedLittle, [a, b]) => i16::from_le_bytes([*a, *b]).into(),
            (Self::SignedBig, [a, b]) => i16::from_be_bytes([*a, *b]).into(),
            (Self::UnsignedLittle, [a, b]) => u16::from_le_bytes([*a, *b]).into(),
            (Self::UnsignedBig, [a, b]) => u16::from_be_bytes([*a, *b]).into(),
            (Self::RealLittle, [a, b, c, d]) => f32::from_le_bytes([*a, *b, *c, *d]).into(),
            (Self::RealBig, [a, b, c, d]) => f32::from_be_bytes([*a, *b, *c, *d]).into(),
            _ => f64::NAN,
        }
    }
}

/// The heights that a label and the bytes of its image give.
pub(super) fn heights(label: &str, image: &[u8]) -> Result<LabelledHeights, String> {
    let label = without_byte_order_mark(label);
    let count = |keyword: &str| -> Result<usize, String> {
        let value = required(label, keyword)?;
        value.parse().map_err(|_| format!("{keyword} = {}: not a whole number", echo(value)))
    };
    let (rows, columns) = (count("LINES")?, count("LINE_SAMPLES")?);
    check_size(columns, rows)?;
    let bands = count_or(label, "BANDS", 1)?;
    if bands != 1 {
        return Err(format!("BANDS = {bands}: only images of one band are supported"));
    }
    let sample = Sample::of(label)?;
    let is_supported = |projection: &str| ["SIMPLE CYLINDRICAL", "EQUIRECTANGULAR"].iter().any(|p| p.eq_ignore_ascii_case(projection));
    if let Some(other) = value(label, "MAP_PROJECTION_TYPE").filter(|p| !is_supported(p)) {
        return Err(format!("MAP_PROJECTION_TYPE = {}: only simple cylindrical maps of the whole Moon are supported", echo(other)));
    }
    let poles_deg = [("MAXIMUM_LATITUDE", 90.0), ("MINIMUM_LATITUDE", -90.0)];
    for (keyword, pole_deg) in poles_deg {
        let latitude_deg = number_or(label, keyword, pole_deg)?;
        if (latitude_deg - pole_deg).abs() > 1e-6 {
            return Err(format!("{keyword} = {latitude_deg}: only maps of the whole Moon, from pole to pole, are supported"));
        }
    }
    // A sample times SCALING_FACTOR is the height above the sphere, and OFFSET is the sphere's radius, both in the unit UNIT.
    let (factor, offset) = (number_or(label, "SCALING_FACTOR", 1.0)?, number_or(label, "OFFSET", 0.0)?);
    let unit = value(label, "UNIT").map(str::to_ascii_uppercase);
    let km_per_unit = match unit.as_deref() {
        Some("METER" | "METERS" | "M") => 1e-3,
        Some("KILOMETER" | "KILOMETERS" | "KM") => 1.0,
        // Without UNIT, the size of OFFSET shows whether it is in metres or kilometres.
        None if offset > 1e6 => 1e-3,
        None if offset > 1e3 => 1.0,
        _ => return Err(format!("UNIT = {}: only METER and KILOMETER are supported", echo(unit.as_deref().unwrap_or("(none)")))),
    };
    let sphere_km = if offset == 0.0 { DEFAULT_SPHERE_KM } else { offset * km_per_unit };
    let image = image.get(image_offset(label)?..).unwrap_or_default();
    // Each line may have other bytes before and after its samples.
    let (prefix_bytes, suffix_bytes) = (count_or(label, "LINE_PREFIX_BYTES", 0)?, count_or(label, "LINE_SUFFIX_BYTES", 0)?);
    let line_bytes = (columns * sample.bytes()).saturating_add(prefix_bytes).saturating_add(suffix_bytes);
    let needed_bytes = line_bytes.saturating_mul(rows);
    if image.len() < needed_bytes {
        return Err(format!("its image has {} bytes; {columns} x {rows} heights need {needed_bytes}", image.len()));
    }
    let no_height = no_height_values(label)?;
    let mut heights_km = Vec::with_capacity(columns * rows);
    for (row, line) in image.chunks_exact(line_bytes).take(rows).enumerate() {
        for (column, bytes) in line[prefix_bytes..].chunks_exact(sample.bytes()).take(columns).enumerate() {
            let value = sample.value(bytes);
            if let Some((constant, _)) = no_height.iter().find(|(_, constant)| value as f32 == *constant) {
                let (row, column) = (row + 1, column + 1);
                return Err(format!("row {row}, column {column}: no height ({constant}); only maps without gaps are supported"));
            }
            heights_km.push((value * factor * km_per_unit) as f32);
        }
    }
    // Columns run eastward even if longitudes are positive west; only the sign of the longitude differs.
    let west_deg = number_or(label, "WESTERNMOST_LONGITUDE", 0.0)?;
    if west_deg.abs() > 360.0 {
        return Err(format!("WESTERNMOST_LONGITUDE = {west_deg:?}: expected degrees from -360 to 360"));
    }
    let west_deg = match value(label, "POSITIVE_LONGITUDE_DIRECTION").map(str::to_ascii_uppercase).as_deref() {
        None | Some("EAST") => west_deg,
        Some("WEST") => -west_deg,
        Some(other) => return Err(format!("POSITIVE_LONGITUDE_DIRECTION = {}: only EAST and WEST are supported", echo(other))),
    };
    Ok(LabelledHeights { columns, heights_km, west_deg, sphere_km })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LABEL: &str = "PDS_VERSION_ID = \"PDS3\"\r
^IMAGE = \"LDEM_4.IMG\"\r
OBJECT = IMAGE\r
  LINES = 2\r
  LINE_SAMPLES = 4 /* a comment */\r
  SAMPLE_TYPE = LSB_INTEGER\r
  SAMPLE_BITS = 16\r
  UNIT = METER\r
  SCALING_FACTOR = 0.5\r
  OFFSET = 1737400.\r
END_OBJECT = IMAGE\r
OBJECT = IMAGE_MAP_PROJECTION\r
  MAP_PROJECTION_TYPE = \"SIMPLE CYLINDRICAL\"\r
  MAXIMUM_LATITUDE = 90 <DEG>\r
  MINIMUM_LATITUDE = -90 <DEG>\r
  WESTERNMOST_LONGITUDE = 0 <DEG>\r
END_OBJECT\r
";

    /// Values of the argument of [`image`].
    const LITTLE_ENDIAN: bool = false;
    const BIG_ENDIAN: bool = true;

    /// The bytes of the image that [`LABEL`] describes.
    fn image(is_big_endian: bool) -> Vec<u8> {
        let values = [-2000_i16, 2000, 0, 0, 0, 0, 0, 3];
        values.iter().flat_map(|v| if is_big_endian { v.to_be_bytes() } else { v.to_le_bytes() }).collect()
    }

    #[test]
    fn ldem_labels_are_read() {
        assert_eq!(image_file(LABEL), Ok("LDEM_4.IMG".into()));
        let read = heights(LABEL, &image(LITTLE_ENDIAN)).expect("read");
        assert_eq!((read.columns, read.west_deg, read.sphere_km), (4, 0.0, 1737.4));
        assert_eq!((read.heights_km[0], read.heights_km[1], read.heights_km[7]), (-1.0, 1.0, 0.0015));
        let big_endian_label = LABEL.replace("LSB_INTEGER", "MSB_INTEGER");
        assert_eq!(heights(&big_endian_label, &image(BIG_ENDIAN)).expect("read").heights_km, read.heights_km);
        // The floating-point maps are in kilometres.
        let real_label = LABEL
            .replace("LSB_INTEGER", "PC_REAL")
            .replace("SAMPLE_BITS = 16", "SAMPLE_BITS = 32")
            .replace("METER", "KILOMETER")
            .replace("0.5", "1.")
            .replace("1737400.", "1737.4");
        let bytes: Vec<u8> = read.heights_km.iter().flat_map(|km| km.to_le_bytes()).collect();
        let real_heights = heights(&real_label, &bytes).expect("read");
        assert_eq!((real_heights.heights_km, real_heights.sphere_km), (read.heights_km, 1737.4));
    }

    /// It would be part of the first line's keyword.
    #[test]
    fn a_byte_order_mark_is_no_part_of_the_label() {
        for first_line in ["^IMAGE = \"LDEM_4.IMG\"\r\n", "  LINES = 2\r\n"] {
            let text = format!("\u{feff}{first_line}{}", LABEL.replace(first_line, ""));
            assert_eq!(image_file(&text), Ok("LDEM_4.IMG".into()));
            assert_eq!(heights(&text, &image(LITTLE_ENDIAN)).map(|read| read.columns), Ok(4), "{first_line}");
        }
    }

    #[test]
    fn longitudes_may_grow_westward() {
        let edge = |direction: &str| {
            let text = LABEL.replace(
                "WESTERNMOST_LONGITUDE = 0",
                &format!("POSITIVE_LONGITUDE_DIRECTION = {direction}\r\n  WESTERNMOST_LONGITUDE = 90"),
            );
            heights(&text, &image(LITTLE_ENDIAN)).map(|read| read.west_deg)
        };
        assert_eq!((edge("EAST"), edge("\"WEST\"")), (Ok(90.0), Ok(-90.0)));
        assert!(edge("UP").is_err_and(|why| why.contains("POSITIVE_LONGITUDE_DIRECTION")));
    }

    #[test]
    fn an_image_may_begin_after_other_records() {
        let read = |pointer: &str, bytes_before: usize| {
            let text = LABEL.replace("\"LDEM_4.IMG\"", pointer).replace("LINES = 2", "RECORD_BYTES = 6\r\n  LINES = 2");
            let bytes = [vec![7; bytes_before], image(LITTLE_ENDIAN)].concat();
            heights(&text, &bytes).map(|read| [read.heights_km[0], read.heights_km[7]])
        };
        for (pointer, bytes_before) in
            [("\"A.IMG\"", 0), ("(\"A.IMG\", 1)", 0), ("(\"A.IMG\", 3)", 12), ("(\"A.IMG\", 3 <BYTES>)", 2), ("(\"A.IMG\",5<bytes>)", 4)]
        {
            assert_eq!(read(pointer, bytes_before), Ok([-1.0, 0.0015]), "{pointer}");
        }
        assert!(read("(\"A.IMG\", 3)", 11).is_err(), "cut short");
        assert!(read("(\"A.IMG\", 99999999999999999)", 12).is_err(), "beyond the file");
        for pointer in ["(\"A.IMG\", 0)", "(\"A.IMG\", x)"] {
            assert!(read(pointer, 0).is_err_and(|why| why.starts_with("^IMAGE")), "{pointer}");
        }
    }

    #[test]
    fn lines_may_have_other_bytes_around_their_samples() {
        let plain = image(LITTLE_ENDIAN);
        for (before, after) in [(6, 0), (0, 5), (3, 2)] {
            let keywords = format!("LINES = 2\r\n  LINE_PREFIX_BYTES = {before}\r\n  LINE_SUFFIX_BYTES = {after}");
            let text = LABEL.replace("LINES = 2", &keywords);
            let bytes: Vec<u8> =
                plain.chunks_exact(8).flat_map(|line| [&vec![7; before][..], line, &vec![9; after][..]].concat()).collect();
            let read = heights(&text, &bytes).expect("read");
            assert_eq!(read.heights_km, heights(LABEL, &plain).expect("read").heights_km, "{before} before, {after} after");
            assert!(heights(&text, &bytes[1..]).is_err(), "cut short");
        }
        for keyword in ["LINE_PREFIX_BYTES", "LINE_SUFFIX_BYTES"] {
            for (count, named) in [("-1", keyword), ("x", keyword), ("18446744073709551615", "bytes")] {
                let why = heights(&LABEL.replace("LINES = 2", &format!("LINES = 2\r\n {keyword} = {count}")), &plain).err();
                assert!(why.as_ref().is_some_and(|why| why.contains(named)), "{keyword} = {count}: {why:?}");
            }
        }
    }

    /// -32768 half metres are -16.4 km, near enough to the Moon's lowest height to be drawn.
    #[test]
    fn samples_without_a_height_are_refused_by_keyword() {
        let read = |constant: &str, bytes: &[u8]| heights(&LABEL.replace("LINES = 2", &format!("LINES = 2\r\n  {constant}")), bytes).err();
        let mut with_gap = image(LITTLE_ENDIAN);
        with_gap[10..12].copy_from_slice(&i16::MIN.to_le_bytes());
        for keyword in ["MISSING_CONSTANT", "INVALID_CONSTANT"] {
            let why = read(&format!("{keyword} = -32768"), &with_gap).expect("a gap");
            assert!(why.starts_with("row 2, column 2: ") && why.contains(keyword), "{why}");
            assert!(read(&format!("{keyword} = 16#8000#"), &with_gap).is_some_and(|why| why.starts_with(keyword)), "another notation");
        }
        // Controls: a map that has all its heights, and keywords without a value.
        assert_eq!(read("MISSING_CONSTANT = -32768", &image(LITTLE_ENDIAN)), None);
        assert_eq!(read("MISSING_CONSTANT = \"N/A\"", &with_gap), None);
        assert_eq!(read("", &with_gap), None);
        // The decimals of a 32-bit constant are rounded.
        let real_label = LABEL.replace("LSB_INTEGER", "PC_REAL").replace("SAMPLE_BITS = 16", "SAMPLE_BITS = 32");
        let real_label = real_label.replace("LINES = 2", "LINES = 2\r\n  MISSING_CONSTANT = -3.40282265508890E+38");
        let bytes: Vec<u8> = [0.0; 7].into_iter().chain([f32::from_bits(0xFF7F_FFFB)]).flat_map(f32::to_le_bytes).collect();
        assert!(heights(&real_label, &bytes).is_err_and(|why| why.starts_with("row 2, column 4: ")));
    }

    #[test]
    fn keywords_may_have_values_in_lower_case() {
        let text =
            LABEL.replace("SIMPLE CYLINDRICAL", "Simple Cylindrical").replace("METER", "meter").replace("LSB_INTEGER", "lsb_integer");
        assert!(heights(&text, &image(LITTLE_ENDIAN)).is_ok());
    }

    #[test]
    fn unsupported_labels_are_rejected_by_keyword() {
        let whole = image(LITTLE_ENDIAN);
        for (from, to, named) in [
            ("  LINES = 2\r", "", "LINES"),
            ("LINES = 2", "LINES = two", "LINES"),
            ("SAMPLE_BITS = 16", "SAMPLE_BITS = 8", "SAMPLE_BITS"),
            ("SIMPLE CYLINDRICAL", "Polar Stereographic", "MAP_PROJECTION_TYPE"),
            ("LINES = 2", "BANDS = 2\r\n  LINES = 2", "BANDS"),
            ("MAXIMUM_LATITUDE = 90", "MAXIMUM_LATITUDE = 60", "MAXIMUM_LATITUDE"),
            ("WESTERNMOST_LONGITUDE = 0", "WESTERNMOST_LONGITUDE = 1e30", "WESTERNMOST_LONGITUDE"),
            ("METER", "FATHOM", "UNIT"),
            ("0.5", "much", "SCALING_FACTOR"),
            ("LINE_SAMPLES = 4", "LINE_SAMPLES = 4000000000", "twice as wide"),
        ] {
            let why = heights(&LABEL.replace(from, to), &whole).err().unwrap_or_default();
            assert!(why.contains(named), "{to}: {why}");
        }
        assert!(heights(LABEL, &whole[1..]).is_err(), "cut short");
        for bad in ["3", "\"../secret.img\"", "\"/etc/passwd\"", ""] {
            assert!(image_file(&LABEL.replace("\"LDEM_4.IMG\"", bad)).is_err(), "{bad}");
        }
    }
}
