//! Tables of small bodies as text: comma-separated values with named columns, JSON of the JPL's Small-Body Database, MPCORB.DAT.
//!
//! In: the text. Out: the bodies in the order of the text, or the first wrong line, with its field. Unknown columns are ignored. A line that begins with # is a
//! comment, unless it is the first line that names the columns. JSON is the reply of the database's query interface: `fields` and `data`.

use super::rows::{
    ABSOLUTE_MAGNITUDE, ARGUMENT_OF_PERIHELION, ASCENDING_NODE, ECCENTRICITY, EPOCH, EPOCH_MJD, FIELDS, INCLINATION, M1, MEAN_ANOMALY,
    PERIHELION_DISTANCE, PERIHELION_PASSAGE, SEMI_MAJOR_AXIS, Values, body, number,
};
use super::{SmallBody, SmallBodyFileError, mpcorb};
use crate::catalog::csv_line::{borrowed_values, comparable_name, unique_columns_of_fields};
use crate::wording::{echo, echo_within, json_error_text, without_byte_order_mark};
use serde::Deserialize;
use std::borrow::Cow;

/// Maximum number of bodies in a file: twice as many as MPCORB.DAT listed in 2025. Each takes about 200 bytes of memory.
const MAX_BODIES: usize = 3_000_000;

/// The indices of the columns of a table that are read; `None` for a column that the table lacks.
struct Columns {
    /// The column of each field, by the field's index in [`FIELDS`].
    by_field: [Option<usize>; FIELDS.len()],
    designation: Option<usize>,
    name: Option<usize>,
    /// The database's full name, such as `1 Ceres (A801 AA)` or `1P/Halley`. It contains the designation.
    full_name: Option<usize>,
    /// Number of all columns of the table, including ignored ones.
    column_count: usize,
}

impl Columns {
    /// Finds the columns by name. The error names a required column that is missing, or one that the table has twice.
    fn of(names: &[String]) -> Result<Self, String> {
        // The earlier of a field's accepted names has precedence: `M_deg` before `m`, which may be a magnitude.
        let by_field = unique_columns_of_fields(names, FIELDS.each_ref().map(|f| f.columns))?;
        let has_any = |alternatives: &[usize]| alternatives.iter().any(|k| by_field[*k].is_some());
        let missing = |alternatives: &[usize]| {
            let names: Vec<_> = alternatives.iter().map(|k| format!("`{}`", FIELDS[*k].name)).collect();
            Err(format!("no column {}; the first line must name it", names.join(" or ")))
        };
        for alternatives in [
            &[ECCENTRICITY][..],
            &[INCLINATION],
            &[ASCENDING_NODE],
            &[ARGUMENT_OF_PERIHELION],
            &[SEMI_MAJOR_AXIS, PERIHELION_DISTANCE],
            &[MEAN_ANOMALY, PERIHELION_PASSAGE],
            &[ABSOLUTE_MAGNITUDE, M1],
        ] {
            if !has_any(alternatives) {
                return missing(alternatives);
            }
        }
        if !has_any(&[PERIHELION_PASSAGE, EPOCH, EPOCH_MJD]) {
            return missing(&[EPOCH, EPOCH_MJD]);
        }
        let texts = [&["number", "pdes", "designation", "desig"][..], &["name"], &["fullname"]];
        let [designation, name, full_name] = unique_columns_of_fields(names, texts)?;
        Ok(Self { by_field, designation, name, full_name, column_count: names.len() })
    }

    /// The body of a row.
    fn body(&self, cells: &[Cow<'_, str>]) -> Result<SmallBody, String> {
        if cells.len() != self.column_count {
            return Err(format!("{} values, and the first line names {} columns", cells.len(), self.column_count));
        }
        let mut values = Values::default();
        for (k, column) in self.by_field.iter().enumerate() {
            values[k] = number(k, column.map_or("", |c| cells[c].as_ref()))?;
        }
        let text = |column: Option<usize>| column.map_or("", |c| cells[c].as_ref());
        // A table may have all three columns. The full name contains the designation, so it replaces both if the table has no column of names, or if this body
        // has neither name nor designation. A body that has only a provisional designation keeps it, with an empty name.
        match [self.designation, self.name, self.full_name].map(text) {
            [designation, "", full_name] if !full_name.is_empty() && (designation.is_empty() || self.name.is_none()) => {
                body("", full_name, &values)
            }
            [designation, name, _] => body(designation, name, &values),
        }
    }
}

/// The reply of the database's query interface.
#[derive(Deserialize)]
struct Reply {
    fields: Vec<String>,
    data: Vec<Vec<serde_json::Value>>,
}

/// The bodies of a reply. The error is a line number and what is wrong there.
fn read_json(text: &str) -> Result<Vec<SmallBody>, (usize, String)> {
    let reply: Reply =
        serde_json::from_str(text).map_err(|e| (e.line().max(1), format!("not a reply of the database: {}", json_error_text(&e))))?;
    let names: Vec<String> = reply.fields.iter().map(|n| comparable_name(n)).collect();
    let columns = Columns::of(&names).map_err(|e| (1, e))?;
    let cell = |v: &serde_json::Value| match v {
        serde_json::Value::Null => String::new(),
        serde_json::Value::String(s) => s.trim().to_owned(),
        other => other.to_string(),
    };
    // Parsed JSON has no line numbers: an error is at line 1, and its text names the row.
    let row = |(k, row): (usize, &Vec<serde_json::Value>)| {
        let cells: Vec<Cow<'_, str>> = row.iter().map(|v| Cow::Owned(cell(v))).collect();
        columns.body(&cells).map_err(|e| (1, format!("row {} of `data`: {e}", k + 1)))
    };
    reply.data.iter().enumerate().map(row).collect()
}

/// The bodies of a table of comma-separated values. The error is a line number and what is wrong there.
fn read_csv(text: &str) -> Result<Vec<SmallBody>, (usize, String)> {
    let mut columns: Option<Columns> = None;
    let mut all = Vec::new();
    for (line_number, line) in text.lines().enumerate().map(|(k, line)| (k + 1, line.trim())).filter(|(_, line)| !line.is_empty()) {
        if let Some(columns) = &columns {
            if !line.starts_with('#') {
                let body = borrowed_values(line).and_then(|cells| columns.body(&cells));
                all.push(body.map_err(|e| (line_number, e))?);
            }
            continue;
        }
        let names: Vec<String> = match borrowed_values(line.trim_start_matches('#')) {
            Ok(cells) => cells.iter().map(|n| comparable_name(n)).collect(),
            Err(_) if line.starts_with('#') => continue,
            Err(why) => return Err((line_number, why)),
        };
        match Columns::of(&names) {
            Ok(found) => columns = Some(found),
            // This is a comment above the line that names the columns.
            Err(_) if line.starts_with('#') => {}
            Err(why) if names.len() > 2 => return Err((line_number, why)),
            Err(_) => {
                let shown = echo_within(line, 40);
                let expected =
                    "expected the names of columns (e, a_au or q_au, i_deg, node_deg, argp_deg, M_deg and epoch_mjd or tp_jd, H or M1)";
                return Err((line_number, format!("`{shown}`: {expected}")));
            }
        }
    }
    Ok(all)
}

/// Reads a table in any of the three formats.
pub(super) fn read(file: &str, text: &str) -> Result<Vec<SmallBody>, SmallBodyFileError> {
    let file_error = |(line, message): (usize, String)| SmallBodyFileError { file: echo(file), line, message };
    let text = without_byte_order_mark(text);
    let all = if text.trim_start().starts_with('{') {
        read_json(text)
    } else if mpcorb::is_mpcorb(text) {
        mpcorb::lines(text).map(|(line, text)| mpcorb::body(text).map_err(|e| (line, e))).collect()
    } else {
        read_csv(text)
    }
    .map_err(file_error)?;
    match all.len() {
        0 => Err(file_error((1, "no bodies: the file has no row".into()))),
        1..=MAX_BODIES => Ok(all),
        n => Err(file_error((1, format!("{n} bodies; {MAX_BODIES} at most")))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::small_bodies::BrightnessLaw;

    const HEAD: &str = "name,e,a_au,i_deg,node_deg,argp_deg,M_deg,epoch_mjd,H,G\n";

    /// The same orbit as CSV, as the database's JSON and CSV, and as a line of MPCORB.DAT (Ceres on 13 September 2023).
    #[test]
    fn all_formats_give_the_same_body() {
        let csv = format!("{HEAD}Ceres,0.0789125,2.7672543,10.58769,80.25498,73.42179,60.07881,60200,3.34,0.15\n");
        let quoted = "full_name,epoch,e,a,i,om,w,ma,H,G\n\"     1 Ceres (A801 AA)\",2460200.5,.0789125,2.7672543,10.58769,80.25498,73.42179,60.07881,3.34,\n";
        let json = r#"{"signature":{"version":"1.0"},"fields":["full_name","epoch.mjd","e","a","i","om","w","ma","H","G"],
            "data":[["     1 Ceres (A801 AA)",60200,".0789125","2.7672543",10.58769,"80.25498","73.42179","60.07881","3.34",null]]}"#;
        let mpcorb = format!(
            "{:<7} {:5.2} {:5.2} {:5} {:9.5}  {:9.5}  {:9.5}  {:9.5}  {:9.7} {:11.8} {:11.7}{}{}",
            "00001",
            3.34,
            0.15,
            "K239D",
            60.07881,
            73.42179,
            80.25498,
            10.58769,
            0.0789125,
            0.21410522,
            2.7672543,
            " ".repeat(63),
            "     (1) Ceres"
        );
        let one = |file: &str, text: &str| read(file, text).unwrap_or_else(|e| panic!("{e}")).remove(0);
        let reference = one("a.csv", &csv);
        for (file, text) in [("b.csv", quoted), ("c.json", json), ("MPCORB.DAT", mpcorb.as_str())] {
            let found = one(file, text);
            assert_eq!(one(file, &format!("\u{feff}{text}")), found, "{file} with a byte order mark");
            assert_eq!(found.brightness, BrightnessLaw::Asteroid { h: 3.34, g: 0.15 }, "{file}");
            assert!(
                found.name.contains("Ceres") && (reference.orbit.passage_days - found.orbit.passage_days).abs() < 1e-6,
                "{file}: {found:?}"
            );
            assert!(
                reference.orbit.to_perihelion.distance(found.orbit.to_perihelion) < 1e-12
                    && (reference.orbit.perihelion_au - found.orbit.perihelion_au).abs() < 1e-12
            );
        }
    }

    /// Two lists in one file, the second with its heading: its bodies alone would not be the whole file.
    #[test]
    fn bodies_before_a_heading_are_not_skipped() {
        let body = |name: &str| {
            let columns = [(0, "00001"), (8, "3.34"), (14, "0.15"), (20, "K239D"), (26, "60.07881"), (37, "73.42179"), (48, "80.25498")];
            let mut line = String::new();
            for (start, text) in columns.into_iter().chain([(59, "10.58769"), (70, "0.0789125"), (92, "2.7672543"), (166, name)]) {
                line = format!("{line:<start$}{text}");
            }
            line
        };
        let dashes = "-".repeat(160);
        let names = |text: &str| read("MPCORB.DAT", text).map(|bodies| bodies.into_iter().map(|b| b.name).collect::<Vec<_>>());
        let (first, second) = (body("(1) Ceres"), body("(2) Pallas"));
        assert_eq!(names(&format!("a heading\n{dashes}\n{first}\n\n{second}\n")), Ok(vec!["Ceres".to_owned(), "Pallas".to_owned()]));
        let error = names(&format!("{first}\na heading\n{dashes}\n{second}\n")).expect_err("a heading among the bodies");
        assert_eq!(error.line, 2, "{error}");
        // A mistake in the first line does not make the file one of another format.
        let wrong_epoch = first.replace("K239D", "K23ZD");
        assert_ne!(wrong_epoch, first);
        let error = names(&format!("{wrong_epoch}\n{second}\n")).expect_err("a wrong first line");
        assert!(error.line == 1 && error.message.starts_with("epoch is `K23ZD`"), "{error}");
    }

    /// Magnitudes in columns `i` and `m` are not taken for the inclination and the mean anomaly.
    #[test]
    fn the_most_explicit_name_of_a_column_counts() {
        let one = |text: &str| read("m.csv", text).unwrap_or_else(|e| panic!("{e}")).remove(0);
        let plain = one(&format!("{HEAD}x,0.1,2.5,3,4,5,6,60000,9,\n"));
        assert_eq!(one(&format!("i,m,{HEAD}17.1,18.2,x,0.1,2.5,3,4,5,6,60000,9,\n")), plain);
    }

    /// The database's full name contains the designation, so a body has only one of them; a body without a name has either.
    #[test]
    fn no_designation_is_shown_twice_and_no_body_is_nameless() {
        let full_name = |columns: &str, cells: &str| {
            let text = format!("{columns},e,q,i,om,w,tp,M1\n{cells},0.97,0.59,162,59,112,2446470.96,5.5\n");
            read("c.csv", &text).unwrap_or_else(|e| panic!("{e}")).remove(0).full_name()
        };
        assert_eq!(full_name("pdes,full_name", "1P,1P/Halley"), "1P/Halley");
        assert_eq!(full_name("pdes,name,full_name", "1,Ceres,\"     1 Ceres (A801 AA)\""), "1 Ceres");
        assert_eq!(full_name("pdes,name,full_name", "2004 MN4,,\"       (2004 MN4)\""), "2004 MN4");
        assert_eq!(full_name("name,full_name", ",\"       (2004 MN4)\""), "(2004 MN4)");
        assert_eq!(full_name("pdes,full_name", "2004 MN4,"), "2004 MN4");
    }

    /// As in the CSV files of data layers.
    #[test]
    fn only_a_quote_at_the_start_of_a_value_quotes_it() {
        let name = |cell: &str| read("q.csv", &format!("{HEAD}{cell},0.1,2.5,3,4,5,6,60000,9,\n")).map(|bodies| bodies[0].name.clone());
        for (cell, expected) in [("O\"Hara", "O\"Hara"), ("\"O\"\"Hara, K.\"", "O\"Hara, K."), (" \"Ceres\" ", "Ceres")] {
            assert_eq!(name(cell).unwrap_or_else(|e| panic!("{cell}: {e}")), expected, "{cell}");
        }
        assert_eq!(name("\"Ceres").expect_err("an open quote").to_string(), "q.csv:2: a quoted value does not end on this line");
        // Not in a comment above the line that names the columns.
        assert!(read("q.csv", &format!("# \"Ceres\n{HEAD}x,0.1,2.5,3,4,5,6,60000,9,\n")).is_ok());
        assert_eq!(read("q.csv", &format!("\"{HEAD}")).expect_err("an open quote").line, 1);
    }

    #[test]
    fn errors_name_line_and_field() {
        let why = |text: &str| read("m.csv", text).expect_err(text).to_string();
        assert_eq!(why("name,a_au,i_deg,node_deg,argp_deg,M_deg,epoch_mjd,H\n"), "m.csv:1: no column `e`; the first line must name it");
        assert_eq!(why("e,i,om,w,ma,epoch,H\n"), "m.csv:1: no column `a_au` or `q_au`; the first line must name it");
        assert!(why(&HEAD.replace(",epoch_mjd", "")).contains("no column `epoch_jd` or `epoch_mjd`"));
        let twice = why(&HEAD.replace("e,a_au", "e,E,a_au"));
        assert_eq!(twice, "m.csv:1: two columns are named `e` (only letters and digits count); leave one out");
        let row = |text: &str| why(&format!("{HEAD}x,0.1,2.5,3,4,5,6,60000,9,\n{text}\n"));
        assert_eq!(row("y,-0.1,2.5,3,4,5,6,60000,9,"), "m.csv:3: e is `-0.1`; expected an eccentricity from 0 to 100");
        assert!(row("y,1.2,2.5,3,4,5,6,60000,9,").contains("m.csv:3: a_au is `2.5` and e `1.2`"));
        // A perihelion distance computed from a and e must be in the range of q_au, too. Otherwise the positions of the next two bodies would not be numbers,
        // or would be far beyond the stars.
        assert_eq!(
            row("y,0,1e-300,3,4,5,6,60000,9,"),
            "m.csv:3: a_au is `1e-300` and e `0.0`, so q_au would be 1e-300; expected au from 0.00001 to 10000"
        );
        assert!(row("y,100,-1e6,3,4,5,6,60000,9,").contains("so q_au would be 99000000.0"));
        assert!(row("y,0.1,2.5,190,4,5,6,60000,9,").contains("i_deg is `190`; expected degrees from 0 to 180"));
        assert!(row("y,0.1,2.5,3,4,5,,60000,9,").contains("tp_jd is empty, and so is M_deg"));
        assert!(row("y,0.1,2.5,3,4,5,6,60000,dim,").contains("H is `dim`"));
        assert_eq!(
            row("y,0.1,2.5,3,4,5,6,2460000.5,9,"),
            "m.csv:3: epoch_mjd is `2460000.5`; expected a modified Julian date (TDB) from -1400000 to 999999"
        );
        assert!(
            why(&format!("{}x,0.1,2.5,3,4,5,6,60000,9,\n", HEAD.replace("epoch_mjd", "epoch"))).contains("m.csv:2: epoch_jd is `60000`")
        );
        assert_eq!(row("y,0.1"), "m.csv:3: 2 values, and the first line names 10 columns");
        assert!(
            why("").contains("no bodies") && why(HEAD).contains("no bodies") && why("one two\n").contains("expected the names of columns")
        );
        assert!(why(r#"{"fields":["e"],"data":[]}"#).contains("no column `i_deg`"));
        assert!(
            why(r#"{"fields":["e","a","i","om","w","ma","epoch","H"],"data":[[7,"2.5",1,1,1,1,2460000.5,9]]}"#)
                .contains("row 1 of `data`: a_au is")
        );
        assert!(why("{\n\n").starts_with("m.csv:3: not a reply of the database"));
        // A body without a magnitude is not an error.
        assert_eq!(read("m.csv", &format!("{HEAD}x,0.1,2.5,3,4,5,6,60000,,\n")).expect("a body")[0].brightness, BrightnessLaw::Unknown);
    }
}
