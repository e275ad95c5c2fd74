//! Rows of a VOTable as BINARY and BINARY2 (IVOA, VOTable 1.5, sections 6.3 and 6.4): big-endian values in base64, without padding between them.
//!
//! In: the attributes of the FIELDs, and the text of the STREAM. Out: each row as the texts that TABLEDATA would contain; a null is an empty text.
//! Always: a length stated in a row is compared with the remaining bytes before it is used. Booleans, bits and complex numbers, which no field of a
//! data layer needs, give an empty text. Not here: streams in other files and compressed streams, which the caller rejects.

use crate::wording::echo_within;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

/// The type of one value of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DataType {
    Boolean,
    Bit,
    UnsignedByte,
    Short,
    Int,
    Long,
    Char,
    UnicodeChar,
    Float,
    Double,
    FloatComplex,
    DoubleComplex,
}

impl DataType {
    /// The type that a name in the attribute `datatype` denotes; `None` for an unknown name.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "boolean" => Self::Boolean,
            "bit" => Self::Bit,
            "unsignedByte" => Self::UnsignedByte,
            "short" => Self::Short,
            "int" => Self::Int,
            "long" => Self::Long,
            "char" => Self::Char,
            "unicodeChar" => Self::UnicodeChar,
            "float" => Self::Float,
            "double" => Self::Double,
            "floatComplex" => Self::FloatComplex,
            "doubleComplex" => Self::DoubleComplex,
            _ => return None,
        })
    }

    /// Number of bytes of `count` values; bits are padded to full bytes. `None` on overflow.
    fn bytes_of(self, count: usize) -> Option<usize> {
        let bytes_per_value = match self {
            Self::Bit => return Some(count.div_ceil(8)),
            Self::Boolean | Self::UnsignedByte | Self::Char => 1,
            Self::Short | Self::UnicodeChar => 2,
            Self::Int | Self::Float => 4,
            Self::Long | Self::Double | Self::FloatComplex => 8,
            Self::DoubleComplex => 16,
        };
        count.checked_mul(bytes_per_value)
    }
}

/// The number of values in each cell of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Length {
    /// The same number of values in each cell.
    Fixed(usize),
    /// Each cell begins with its count of items (big-endian i32). The variant holds the number of values per item: 2 for the `arraysize` `2x*`.
    Counted(usize),
}

impl Length {
    /// Parses an `arraysize`: numbers joined by `x`. The last one may be `*`, or a maximum (ignored here) followed by `*`. Empty: one value. `None` for any
    /// other text.
    fn of(arraysize: &str) -> Option<Self> {
        if arraysize.is_empty() {
            return Some(Self::Fixed(1));
        }
        let product = |numbers: &str| {
            let mut numbers = numbers.split('x').filter(|n| !n.is_empty());
            numbers.try_fold(1_usize, |product, n| n.trim().parse::<usize>().ok().and_then(|n| product.checked_mul(n)))
        };
        match arraysize.strip_suffix('*') {
            None => product(arraysize).map(Self::Fixed),
            Some(without_star) => product(without_star.rsplit_once('x').map_or("", |(fixed, _)| fixed)).map(Self::Counted),
        }
    }
}

/// The type, length and null value of a column.
#[derive(Clone, Debug)]
pub(super) struct BinaryColumn {
    data_type: DataType,
    length: Length,
    /// The number that means null, as text, if there is one.
    null: Option<String>,
}

impl BinaryColumn {
    /// A column with the attributes `datatype` and `arraysize` of a FIELD, and the `null` of its VALUES.
    pub(super) fn new(data_type: &str, arraysize: &str, null: Option<&str>) -> Result<Self, String> {
        let parsed_type =
            DataType::named(data_type).ok_or_else(|| format!("the datatype `{}` is not a VOTable type", echo_within(data_type, 20)))?;
        let length = Length::of(arraysize).ok_or_else(|| format!("the arraysize `{}` is not valid", echo_within(arraysize, 20)))?;
        Ok(Self { data_type: parsed_type, length, null: null.map(str::to_owned) })
    }

    /// The text that TABLEDATA would contain for a cell of these bytes; empty if the value is null or of a type that is not read.
    fn text(&self, bytes: &[u8]) -> String {
        // The first number of an array; that is enough, because no field of a point is an array.
        fn first<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
            bytes.first_chunk::<N>().copied()
        }
        let number = match self.data_type {
            DataType::Char => {
                let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
                return String::from_utf8_lossy(&bytes[..end]).trim().to_owned();
            }
            DataType::UnicodeChar => {
                let units: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).take_while(|u| *u != 0).collect();
                return String::from_utf16_lossy(&units).trim().to_owned();
            }
            DataType::Boolean | DataType::Bit | DataType::FloatComplex | DataType::DoubleComplex => None,
            DataType::UnsignedByte => bytes.first().map(u8::to_string),
            DataType::Short => first(bytes).map(|b| i16::from_be_bytes(b).to_string()),
            DataType::Int => first(bytes).map(|b| i32::from_be_bytes(b).to_string()),
            DataType::Long => first(bytes).map(|b| i64::from_be_bytes(b).to_string()),
            DataType::Float => first(bytes).map(f32::from_be_bytes).filter(|v| !v.is_nan()).map(|v| v.to_string()),
            DataType::Double => first(bytes).map(f64::from_be_bytes).filter(|v| !v.is_nan()).map(|v| v.to_string()),
        };
        number.filter(|text| Some(text) != self.null.as_ref()).unwrap_or_default()
    }
}

/// The rows of a stream.
pub(super) struct BinaryRows<'a> {
    columns: &'a [BinaryColumn],
    /// The decoded stream.
    bytes: Vec<u8>,
    /// Where the next row begins.
    offset: usize,
    /// BINARY2: each row begins with a bit for each column, set where the value is null.
    has_null_flags: bool,
}

impl<'a> BinaryRows<'a> {
    /// `text`: the content of the STREAM, which may contain blanks and line breaks.
    pub(super) fn new(columns: &'a [BinaryColumn], text: &str, has_null_flags: bool) -> Result<Self, String> {
        if columns.is_empty() {
            return Err("a TABLE without a FIELD has no rows".to_owned());
        }
        let engine = GeneralPurpose::new(&STANDARD, GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent));
        let packed: String = text.split_ascii_whitespace().collect();
        let bytes = engine.decode(packed).map_err(|e| format!("its STREAM is not base64: {e}"))?;
        Ok(Self { columns, bytes, offset: 0, has_null_flags })
    }

    /// The next bytes of the stream; `None` if fewer remain.
    fn take(&mut self, count: usize) -> Option<&[u8]> {
        let end = self.offset.checked_add(count)?;
        let taken = self.bytes.get(self.offset..end)?;
        self.offset = end;
        Some(taken)
    }

    /// The next row; `None` after the last row. The error for a row that is cut off states where the row begins.
    pub(super) fn next_row(&mut self) -> Result<Option<Vec<String>>, String> {
        if self.offset == self.bytes.len() {
            return Ok(None);
        }
        let row_start = self.offset;
        let cut_off = || format!("the row at byte {row_start} of its STREAM is cut off");
        let flags = if self.has_null_flags { self.take(self.columns.len().div_ceil(8)).ok_or_else(cut_off)?.to_vec() } else { Vec::new() };
        let columns = self.columns;
        let mut row = Vec::with_capacity(columns.len());
        for (k, column) in columns.iter().enumerate() {
            let count = match column.length {
                Length::Fixed(count) => count,
                Length::Counted(values_per_item) => {
                    let stated = self.take(4).and_then(|b| b.try_into().ok()).map(i32::from_be_bytes).ok_or_else(cut_off)?;
                    usize::try_from(stated).ok().and_then(|n| n.checked_mul(values_per_item)).ok_or_else(cut_off)?
                }
            };
            let bytes = column.data_type.bytes_of(count).and_then(|n| self.take(n)).ok_or_else(cut_off)?;
            // The flag of column 0 is the highest bit of the first byte.
            let is_null = flags.get(k / 8).is_some_and(|byte| byte & (0x80 >> (k % 8)) != 0);
            row.push(if is_null { String::new() } else { column.text(bytes) });
        }
        // Without this check, columns of zero bytes would give rows without end.
        if self.offset == row_start { Err("its rows have no bytes".to_owned()) } else { Ok(Some(row)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base64::prelude::BASE64_STANDARD;

    /// Values of the argument `has_null_flags`.
    const BINARY: bool = false;
    const BINARY2: bool = true;
    /// A column without a number that means null.
    const NO_NULL: Option<&str> = None;

    fn rows(columns: &[BinaryColumn], bytes: &[u8], has_null_flags: bool) -> Result<Vec<Vec<String>>, String> {
        let text = BASE64_STANDARD.encode(bytes);
        // Blanks and line breaks within the base64 are allowed.
        let wrapped: String = text.as_bytes().chunks(7).map(|part| format!("{}\n ", String::from_utf8_lossy(part))).collect();
        let mut rows = BinaryRows::new(columns, &wrapped, has_null_flags)?;
        let mut all = Vec::new();
        while let Some(row) = rows.next_row()? {
            all.push(row);
        }
        Ok(all)
    }

    fn column(data_type: &str, arraysize: &str) -> BinaryColumn {
        BinaryColumn::new(data_type, arraysize, NO_NULL).expect("a type")
    }

    #[test]
    fn each_type_and_size_is_read() {
        let columns = [
            column("double", ""),
            column("float", "2"),
            column("short", ""),
            column("char", "*"),
            column("char", "4"),
            column("unicodeChar", "3*"),
            column("bit", "9"),
            column("long", "2x*"),
            BinaryColumn::new("int", "", Some("-99")).expect("a type"),
            column("unsignedByte", ""),
        ];
        let mut bytes = Vec::new();
        for _ in 0..2 {
            bytes.extend(10.25_f64.to_be_bytes());
            bytes.extend([1.1_f32, 2.0].map(f32::to_be_bytes).concat());
            bytes.extend((-7_i16).to_be_bytes());
            bytes.extend([&3_i32.to_be_bytes()[..], b"abc", b"xy\0z"].concat());
            bytes.extend([&2_i32.to_be_bytes()[..], &[0, 0xe9, 0x20, 0xac]].concat());
            bytes.extend([0xff, 0x80]);
            bytes.extend([&1_i32.to_be_bytes()[..], &5_i64.to_be_bytes(), &6_i64.to_be_bytes()].concat());
            bytes.extend([&(-99_i32).to_be_bytes()[..], &[200]].concat());
        }
        let expected = ["10.25", "1.1", "-7", "abc", "xy", "\u{e9}\u{20ac}", "", "5", "", "200"];
        assert_eq!(rows(&columns, &bytes, BINARY).expect("rows"), [expected, expected]);
        // The last byte of the second of two equal rows is missing.
        let cut = rows(&columns, &bytes[..bytes.len() - 1], BINARY).expect_err("cut");
        assert!(cut.starts_with(&format!("the row at byte {}", bytes.len() / 2)), "{cut}");
    }

    #[test]
    fn nulls_are_flagged_from_the_highest_bit() {
        let columns: Vec<BinaryColumn> = (0..9).map(|_| column("unsignedByte", "")).collect();
        let row = [&[0b0100_0000, 0b1000_0000][..], &[1, 2, 3, 4, 5, 6, 7, 8, 9]].concat();
        assert_eq!(rows(&columns, &row, BINARY2).expect("a row"), [["1", "", "3", "4", "5", "6", "7", "8", ""]]);
    }

    #[test]
    fn lengths_beyond_the_stream_are_rejected() {
        // The number of values of the last, 1e9 x 1e9 x 1000, has no room in 64 bits.
        for (arraysize, claimed) in [("*", i32::MAX), ("*", -1), ("1000000000x1000000000x*", 1000)] {
            let columns = [column("double", arraysize)];
            let bytes = [&claimed.to_be_bytes()[..], &[0; 64]].concat();
            assert!(rows(&columns, &bytes, BINARY).expect_err("a claim").contains("cut off"), "{arraysize} {claimed}");
        }
        // A cell of no values has no bytes, so no row would reach the end of the stream.
        assert!(rows(&[column("char", "0")], b"x", BINARY).expect_err("nothing").contains("no bytes"));
        assert!(BinaryRows::new(&[column("int", "")], "A*==", BINARY).err().expect("no base64").contains("not base64"));
        assert!(
            [("quad", ""), ("int", "2y"), ("int", "*x2")]
                .iter()
                .all(|(data_type, size)| BinaryColumn::new(data_type, size, NO_NULL).is_err())
        );
    }
}
