//! Tables of points: finds the column of each field of a point (latitude, longitude, time, size, colour), and converts rows to points.
//!
//! In: the names of a table's columns, then its rows as texts. Out: points, or a message that names the field whose value is wrong. Always: columns of no field
//! are ignored.

use super::layer::{DataPoint, hex_colour};
use crate::catalog::csv_line::{columns_of_fields, comparable_name, first_repeated};
use crate::time::Instant;
use crate::wording::echo_within;

/// The columns of a table that describe a point.
pub(super) struct PointColumns {
    /// Indices of the columns of latitude (or declination), longitude (or right ascension), time, size and colour; `None` for a column that the table lacks.
    indices: [Option<usize>; 5],
    /// Number of all columns of the table, including those that describe no point.
    column_count: usize,
    /// The names of the two coordinates in messages, in the order of `indices`.
    coordinate_names: [&'static str; 2],
}

impl PointColumns {
    /// Finds the fields' columns by name. Only letters and digits are compared, without regard to case. `on_body`: the points are given by latitude and
    /// longitude, not by declination and right ascension. The error is a message without its subject, the table: `has no column lat_deg`.
    pub fn of(names: &[String], on_body: bool) -> Result<Self, String> {
        let names: Vec<String> = names.iter().map(|name| comparable_name(name)).collect();
        let coordinates: [&[&str]; 2] = match on_body {
            true => [&["latdeg", "lat", "latitude"], &["londeg", "lon", "longitude", "lng"]],
            false => [&["decdeg", "dec", "dedeg", "deicrs", "dej2000"], &["radeg", "ra", "raicrs", "raj2000"]],
        };
        let names_of_fields: [&[&str]; 5] =
            [coordinates[0], coordinates[1], &["datetime", "time", "date"], &["sizepx", "size"], &["colour", "color"]];
        // The earlier of a field's names has precedence: `ra_deg` before `ra`, which may be in hours.
        let indices = columns_of_fields(&names, names_of_fields);
        let coordinate_names = if on_body { ["lat_deg", "lon_deg"] } else { ["dec_deg", "ra_deg"] };
        // Messages use the customary order: latitude before longitude, but right ascension before declination.
        let message_order = if on_body { [0, 1] } else { [1, 0] };
        let missing: Vec<&str> = message_order.into_iter().filter(|k| indices[*k].is_none()).map(|k| coordinate_names[k]).collect();
        match missing[..] {
            [] => {}
            [one] => return Err(format!("has no column {one}")),
            _ => return Err(format!("has no columns {}", missing.join(" and "))),
        }
        Ok(Self { indices, column_count: names.len(), coordinate_names })
    }

    /// The name of a field's column if a later column has this name, too (compared as in [`PointColumns::of`]): that of the first such field, or `None`.
    /// `names`: those of all columns.
    pub fn repeated_name<'n>(&self, names: &'n [String]) -> Option<&'n str> {
        let comparable_names: Vec<String> = names.iter().map(|name| comparable_name(name)).collect();
        first_repeated(&comparable_names, &self.indices).map(|column| names[column].as_str())
    }

    /// The indices of the columns of latitude and longitude (or declination and right ascension).
    pub fn coordinate_columns(&self) -> impl Iterator<Item = usize> {
        self.indices[..2].iter().flatten().copied()
    }

    /// Converts a row to a point. `values`: those of all columns; an empty time, size or colour counts as missing.
    pub fn point(&self, values: &[String]) -> Result<DataPoint, String> {
        if values.len() != self.column_count {
            return Err(format!("{} values; the table names {} columns", values.len(), self.column_count));
        }
        let invalid = |field: &str, value: &str, allowed: &str| format!("field {field}: `{}` is not {allowed}", echo_within(value, 40));
        let [lat_column, lon_column, time_column, size_column, colour_column] = self.indices;
        let non_empty = |column: Option<usize>| column.map(|c| values[c].as_str()).filter(|v| !v.is_empty());
        let within = |field: &str, value: &str, [min, max]: [f64; 2], allowed: &str| {
            value.parse().ok().filter(|v| (min..=max).contains(v)).ok_or_else(|| invalid(field, value, allowed))
        };
        let coordinate = |k: usize, column: Option<usize>, max: f64| {
            // The column is known: `PointColumns::of` requires both coordinates.
            let value = column.map_or("", |c| values[c].as_str());
            within(self.coordinate_names[k], value, [-max, max], &format!("degrees from -{max} to {max}"))
        };
        let time = non_empty(time_column).map(|v| Instant::parse(v).map_err(|_| invalid("time", v, "ISO 8601 UTC or jd_tdb:DAY")));
        let size_px = non_empty(size_column).map(|v| within("size_px", v, [1e-3, 1000.0], "0.001 to 1000 pixels"));
        let colour = non_empty(colour_column).map(|v| hex_colour(v).ok_or_else(|| invalid("colour", v, "a colour as #ff8040")));
        Ok(DataPoint {
            lat_deg: coordinate(0, lat_column, 90.0)?,
            lon_deg: coordinate(1, lon_column, 360.0)?,
            time: time.transpose()?,
            size_px: size_px.transpose()?,
            colour: colour.transpose()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the argument `on_body` of [`PointColumns::of`].
    const ON_SKY: bool = false;
    const ON_BODY: bool = true;

    #[test]
    fn the_most_explicit_name_counts() {
        let names = ["ra", "dec", "date", "RA_deg", "datetime", "dec_deg"].map(String::from);
        let columns = PointColumns::of(&names, ON_SKY).expect("the columns of a point");
        let point = columns.point(&["5.5", "x", "2024-04-08", "82.5", "2024-04-08T18:00:00Z", "-20"].map(String::from)).expect("a point");
        assert_eq!((point.lon_deg, point.lat_deg), (82.5, -20.0));
        assert_eq!(point.time.map(Instant::to_utc_iso).as_deref(), Some("2024-04-08T18:00:00Z"));
    }

    /// The message names exactly the range that is accepted.
    #[test]
    fn the_message_of_a_wrong_size_names_the_range() {
        let names = ["lat", "lon", "size"].map(String::from);
        let columns = PointColumns::of(&names, ON_BODY).expect("the columns of a point");
        let point = |size: &str| columns.point(&["0", "0", size].map(String::from));
        for (size, is_allowed) in [("0", false), ("1e-4", false), ("9.99e-4", false), ("0.001", true), ("1000", true), ("1000.1", false)] {
            match point(size) {
                Ok(point) => assert!(is_allowed && point.size_px.is_some(), "{size}"),
                Err(message) => {
                    assert!(!is_allowed, "{size}: {message}");
                    assert_eq!(message, format!("field size_px: `{size}` is not 0.001 to 1000 pixels"));
                }
            }
        }
    }
}
