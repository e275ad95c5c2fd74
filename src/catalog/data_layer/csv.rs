//! Points in a table of comma-separated values (RFC 4180, without line breaks in values).
//!
//! In: the text. Empty lines and lines that begin with # are skipped; the first other line names the columns. Out: points, or the wrong line and field.

use super::columns::PointColumns;
use super::layer::Content;
use crate::catalog::csv_line::{repeated_column, values};
use crate::wording::echo_within;

/// The points of a table. `on_body`: its columns are latitude and longitude, not declination and right ascension. The error is a line number and what is wrong
/// there.
pub(super) fn read(text: &str, on_body: bool) -> Result<Content, (usize, String)> {
    let mut lines = (1..).zip(text.lines()).filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
    let (head_line_number, head) = lines.next().ok_or_else(|| (1, "empty; the first line names the columns".to_owned()))?;
    let names = values(head).map_err(|why| (head_line_number, why))?;
    let columns = PointColumns::of(&names, on_body).map_err(|why| {
        // The usual reasons: another separator, and places on a body in a layer of the sky, or the reverse.
        let hint = if names.len() == 1 && head.contains([';', '\t']) {
            "; separate the values by commas"
        } else if PointColumns::of(&names, !on_body).is_err() {
            ""
        } else if on_body {
            "; coordinates in the sky need a layer without `body`"
        } else {
            "; places on a body need `body` in the layer"
        };
        (head_line_number, format!("the line of column names {why}{hint}"))
    })?;
    // Checked here only: a VOTable, which a program writes, may have several columns of one name.
    if let Some(name) = columns.repeated_name(&names) {
        return Err((head_line_number, repeated_column(&echo_within(name, 40))));
    }
    let mut content = Content::default();
    for (line_number, line) in lines {
        let values = values(line).map_err(|why| (line_number, why))?;
        let point = columns.point(&values).and_then(|point| content.count_positions(1).map(|()| point));
        content.points.push(point.map_err(|why| (line_number, why))?);
    }
    Ok(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of the argument `on_body` of [`read`].
    const ON_BODY: bool = true;

    #[test]
    fn a_quoted_value_that_does_not_end_is_an_error() {
        let error = read("# places\nlat,lon,place\n1,2,\"Tohoku\n", ON_BODY).expect_err("an open quote");
        assert_eq!(error, (3, "a quoted value does not end on this line".to_owned()));
        assert_eq!(read("lat,\"lon\n1,2\n", ON_BODY).expect_err("an open quote").0, 1);
        // A comment precedes the line of column names, which is then the second line.
        let error = read("# places\nlat,place\n1,here\n", ON_BODY).expect_err("no longitude");
        assert_eq!(error, (2, "the line of column names has no column lon_deg".to_owned()));
    }

    #[test]
    fn usual_mistakes_in_the_line_of_column_names_have_a_hint() {
        for (text, on_body, hint) in [
            ("lat;lon\n1;2\n", ON_BODY, "; separate the values by commas"),
            ("lat\tlon\n1\t2\n", ON_BODY, "; separate the values by commas"),
            ("lat,lon\n1,2\n", !ON_BODY, "; places on a body need `body` in the layer"),
            ("ra,dec\n1,2\n", ON_BODY, "; coordinates in the sky need a layer without `body`"),
            ("x,y\n1,2\n", ON_BODY, "has no columns lat_deg and lon_deg"),
        ] {
            let (line, error) = read(text, on_body).expect_err(text);
            assert!(line == 1 && error.ends_with(hint), "{text}: {error}");
        }
    }

    #[test]
    fn two_columns_of_one_name_are_an_error_if_it_counts() {
        let error = read("lat,lon,Lat\n1,2,3\n", ON_BODY).expect_err("two latitudes");
        assert_eq!(error, (1, "two columns are named `lat` (only letters and digits count); leave one out".to_owned()));
        assert!(read("lat_deg,lon,name,Name,lat\n1,2,a,b,3\n", ON_BODY).is_ok(), "`lat` does not count beside `lat_deg`");
    }
}
